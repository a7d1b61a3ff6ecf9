//! The error propagation of three axes and the correction of end points against the chain: H. A. M. Spaan, Software error compensation
//! of machine tools, PhD thesis, Technische Universiteit Eindhoven 1995, eq. 2.2–2.9 and Fig. 7.4.

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::{Lever, Machine, State};
use ncfix_model::motion::EntryFunction;
use ncfix_model::name::DIRECTIONS;
use ncfix_model::{ErrorModel, ErrorName, LocationError, Model, MotionError};
use ncfix_path::path::{CorrectionOptions, Subdivision};

use crate::bench_machine::{Random, Replay, correct, motion, polynomial};
use crate::machines::xyz_machine;

const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// A machine whose tool moves in the positive directions relative to the workpiece, whichever side carries an axis.
fn machine(topology: &str, levers: [Lever; 3]) -> Machine {
    let mut machine = xyz_machine();
    machine.topology = topology.parse().unwrap();
    let foundation = topology.find('F').unwrap();
    for (axis, lever) in LINEAR.into_iter().zip(levers) {
        let data = machine.axes[axis.slot()].as_mut().unwrap();
        data.lever = lever;
        if topology.find(char::from(axis.letter())).unwrap() < foundation {
            data.direction = -data.direction;
        }
    }
    machine
}

/// Coefficients of itx ity itz irx iry irz of each axis i, and its location errors in the same order.
struct Parameters {
    motion: [[[f64; 4]; 6]; 3],
    location: [[f64; 6]; 3],
}

impl Parameters {
    /// Cubic functions of up to `size` rad and as many times 500 mm, and the three squareness errors.
    fn random(random: &mut Random, size: f64) -> Parameters {
        let scale = |row: usize| if row < 3 { 500.0 * size } else { size };
        let mut motion = [[[0.0; 4]; 6]; 3];
        for (row, power) in (0..6).flat_map(|row| (0..4).map(move |power| (row, power))) {
            for axis in &mut motion {
                axis[row][power as usize] = random.between(-scale(row), scale(row)) / 500_f64.powi(power);
            }
        }
        let mut location = [[0.0; 6]; 3];
        for (axis, row) in [(1, 5), (2, 3), (2, 4)] {
            location[axis][row] = random.between(-size, size);
        }
        Parameters { motion, location }
    }

    fn model(&self) -> ErrorModel {
        let mut errors = ErrorModel::default();
        for (i, axis) in LINEAR.into_iter().enumerate() {
            for (row, direction) in DIRECTIONS.into_iter().enumerate() {
                let name = ErrorName::motion(direction, axis);
                errors.motion.push(MotionError { name, function: polynomial(&self.motion[i][row]) });
                let (name, value) = (ErrorName::location(direction, axis), self.location[i][row]);
                errors.location.push(LocationError { name, value });
            }
        }
        errors
    }
}

/// Eᵢ = eᵢ + εᵢ × pᵢ with pᵢ = l + (bx X, by Y, bz Z): eq. 2.3–2.6.
fn share(components: [f64; 6], configuration: [u8; 3], position: Vector, tool: Vector) -> Vector {
    let [x, y, z, a, b, c] = components;
    let arm = tool + position.component_mul(&Vector::from(configuration.map(f64::from)));
    Vector::new(x, y, z) + Vector::new(a, b, c).cross(&arm)
}

/// Where an axis is in the chain and which motions its arms include.
#[derive(Clone, Copy)]
struct Arms {
    /// −1 on the workpiece side: there the workpiece moves instead of the tool.
    sense: f64,
    motion: [u8; 3],
    location: [u8; 3],
}

/// E = Σ Eᵢ (eq. 2.2) by Horner's rule and cross products; nothing of the chain is used.
fn position_error(parameters: &Parameters, arms: [Arms; 3], position: Vector, tool: Vector) -> Vector {
    (0..3).fold(Vector::zeros(), |sum, i| {
        let own = position[i];
        let components = parameters.motion[i].map(|[k0, k1, k2, k3]| ((k3 * own + k2) * own + k1) * own + k0);
        let motion = share(components, arms[i].motion, position, tool);
        sum + (motion + share(parameters.location[i], arms[i].location, position, tool)) * arms[i].sense
    })
}

const TOOLS: [[f64; 3]; 4] = [[0.0, 0.0, -80.0], [0.0, 0.0, -250.0], [35.0, -20.0, -150.0], [0.0, -200.0, 40.0]];

/// The chain differs from the equations by the second order: errors a tenth as large leave a hundredth.
#[track_caller]
fn agrees(topology: &str, levers: [Lever; 3], arms: [Arms; 3]) {
    let machine = machine(topology, levers);
    let worst = |size: f64| {
        let mut random = Random(41);
        let mut worst: f64 = 0.0;
        for k in 0..400 {
            let parameters = Parameters::random(&mut random, size);
            let position = Vector::from([0; 3].map(|_| random.between(-500.0, 500.0)));
            let tool = Vector::from(TOOLS[k % 4]);
            let mut command = AxisVector::ZERO;
            command.set_xyz(position);
            let model = Model::new(&machine, &parameters.model());
            let chain = model.tip_error_mm(&command, &command, &tool, &State::default());
            worst = worst.max((chain - position_error(&parameters, arms, position, tool)).norm());
        }
        worst
    };
    let (large, small) = (worst(1e-3), worst(1e-4));
    assert!((80.0..125.0).contains(&(large / small)), "{topology}: {large} {small}");
    // Of errors of about a millimeter.
    assert!(small < 5e-4, "{topology}: {small}");
}

/// Eq. 2.7–2.9 and the other five orders: the arm of an axis includes its own motion and those of the axes behind it.
#[test]
fn every_order_of_the_chain_has_the_arms_of_the_thesis() {
    for order in ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"] {
        let at = |axis: Axis| order.find(char::from(axis.letter())).unwrap();
        let arms = LINEAR.map(|axis| {
            let configuration = LINEAR.map(|other| u8::from(at(other) >= at(axis)));
            Arms { sense: 1.0, motion: configuration, location: configuration }
        });
        if order == "XYZ" {
            assert_eq!(arms.map(|arms| arms.motion), [[1, 1, 1], [0, 1, 1], [0, 0, 1]], "eq. 2.7, 2.8, 2.9");
        }
        agrees(&format!("wF{order}St"), [Lever::Fixed; 3], arms);
    }
}

/// With tables the chain from the workpiece to the tool is the same: there the arm includes the own motion with the lever `carried`, because
/// the table moves the workpiece and the frame of its errors with it.
#[test]
fn tables_have_the_same_arms_seen_from_the_workpiece() {
    let table = |motion, location| Arms { sense: -1.0, motion, location };
    let z = Arms { sense: 1.0, motion: [0, 0, 1], location: [0, 0, 1] };
    let [fixed, carried] = [Lever::Fixed, Lever::Carried];
    let locations = [[0, 1, 1], [0, 0, 1]];
    let as_printed = [table([1, 1, 1], locations[0]), table([0, 1, 1], locations[1]), z];
    agrees("wXYFZSt", [carried, carried, fixed], as_printed);
    agrees("wXYFZSt", [fixed; 3], [table([0, 1, 1], locations[0]), table([0, 0, 1], locations[1]), z]);
    agrees("wXYFZSt", [carried; 3], [as_printed[0], as_printed[1], Arms { motion: [0; 3], ..z }]);
}

/// The tool of Fig. 7.4, and a long move in XZ.
const TOOL_MM: f64 = -200.0;
const FROM: [f64; 3] = [50.0, 180.0, 20.0];
const TO: [f64; 3] = [650.0, 180.0, 420.0];

/// Curved errors of a machine of that size: bows of some micrometers, pitches of some ten µrad.
fn curved() -> Parameters {
    let mut parameters = Parameters { motion: [[[0.0; 4]; 6]; 3], location: [[0.0; 6]; 3] };
    let [x, _, z] = &mut parameters.motion;
    x[0] = [0.0, -3.0e-5, 9.0e-8, 0.0];
    x[2] = [0.0, 8.4e-5, -1.2e-7, 0.0];
    x[4] = [0.0, 2.1e-7, -3.0e-10, 0.0];
    z[0] = [0.0, -4.0e-5, 0.0, 2.0e-10];
    z[2] = [0.0, 2.0e-5, -5.0e-8, 0.0];
    z[4] = [0.0, -1.2e-7, 2.5e-10, 0.0];
    parameters.location[2][4] = 3.0e-5;
    parameters
}

/// The largest distance of the tip from the programmed line at right angles to it in XZ, signed, and at which share of the way.
fn across(residual: impl Fn(f64) -> Vector) -> (f64, f64) {
    let way = Vector::from(TO) - Vector::from(FROM);
    let normal = Vector::new(-way.z, 0.0, way.x).normalize();
    let places = (0..=4000).map(|k| f64::from(k) / 4000.0);
    places.map(|at| (normal.dot(&residual(at)), at)).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).unwrap()
}

/// What the emitted program leaves, by a replay of its counts on the chain.
fn left(options: CorrectionOptions) -> (f64, f64, usize) {
    let mut machine = machine("wFXYZSt", [Lever::Fixed; 3]);
    machine.spindle.origin_mm = Vector::new(0.0, 0.0, TOOL_MM);
    let errors = curved().model();
    let [from, to] = [FROM, TO].map(|[x, y, z]| format!("X{x} Y{y} Z{z}"));
    let run = correct(&format!("G0 {from}\nG1 {to} F500\n"), &machine, &errors, options);
    assert!(run.findings.is_empty(), "{:?}", run.findings);
    let model = Model::new(&machine, &errors);
    let mut replay = Replay::new(&machine);
    replay.follow(&run.pieces[0], 1);
    let (start, way) = (Vector::from(FROM) + machine.spindle.origin_mm, Vector::from(TO) - Vector::from(FROM));
    let normal = Vector::new(-way.z, 0.0, way.x).normalize();
    let (mut worst, mut at) = (0.0_f64, 0.0);
    for piece in &run.pieces[1..] {
        for (command, state) in replay.follow(piece, 400) {
            let tip = model.actual(&command, &Vector::zeros(), &state).translation - start;
            let off = normal.dot(&tip);
            if off.abs() > worst.abs() {
                (worst, at) = (off, tip.dot(&way) / way.norm_squared());
            }
        }
    }
    (worst, at, run.pieces.len() - 1)
}

/// Fig. 7.4: corrected at its end points only, a long move keeps the curvature of the errors, E(t) − ((1−t) E(0) + t E(1)); pieces
/// take it away. Where it is and how much, by the equations of chapter 2 alone.
#[test]
fn corrected_end_points_leave_the_curvature_of_the_errors() {
    let configuration = [[1, 1, 1], [0, 1, 1], [0, 0, 1]];
    let arms = configuration.map(|motion| Arms { sense: 1.0, motion, location: motion });
    let tool = Vector::new(0.0, 0.0, TOOL_MM);
    let (from, to) = (Vector::from(FROM), Vector::from(TO));
    let parameters = curved();
    let error = |at: f64| position_error(&parameters, arms, from.lerp(&to, at), tool);
    let bend = |start: f64, end: f64, at: f64| error(start + (end - start) * at) - error(start).lerp(&error(end), at);
    let (predicted, predicted_at) = across(|at| bend(0.0, 1.0, at));
    assert!(predicted.abs() > 0.01, "tens of micrometers, as in the figure: {predicted}");

    let (measured, at, pieces) =
        left(CorrectionOptions { subdivision: Subdivision::Step(1e4), ..CorrectionOptions::default() });
    assert_eq!(pieces, 1);
    // An increment of 0.1 µm at the ends and the second order.
    assert!((measured - predicted).abs() < 1.5e-4, "{measured} mm at {at}, {predicted} mm at {predicted_at} predicted");
    assert!((at - predicted_at).abs() < 0.02, "{at} {predicted_at}");

    // Steps of 20 mm along X, the axis that moves farthest.
    let (measured, _, pieces) =
        left(CorrectionOptions { subdivision: Subdivision::Step(20.0), ..CorrectionOptions::default() });
    let steps: Vec<f64> = (0..=30).map(|k| f64::from(k) / 30.0).collect();
    let largest = |worst: f64, step: &[f64]| across(|at| bend(step[0], step[1], at)).0.abs().max(worst);
    let predicted = steps.windows(2).fold(0.0, largest);
    assert_eq!(pieces, 30);
    assert!(measured.abs() < predicted + 1.5e-4 && predicted < 5e-3, "{measured} mm, {predicted} mm predicted");

    let (measured, _, pieces) = left(CorrectionOptions::default());
    assert!(measured.abs() <= 1e-3 && pieces < 30, "{measured} mm in {pieces} pieces");
}

/// Without curvature the end points are enough.
#[test]
fn straight_errors_need_no_pieces() {
    let mut machine = machine("wFXYZSt", [Lever::Fixed; 3]);
    machine.spindle.origin_mm = Vector::new(0.0, 0.0, TOOL_MM);
    let errors =
        ErrorModel { motion: vec![motion("EXX", linear(1e-4)), motion("EZX", linear(-5e-5))], ..ErrorModel::default() };
    let run = correct("G0 X50 Y0 Z20\nG1 X650 Y0 Z420 F500\n", &machine, &errors, CorrectionOptions::default());
    assert_eq!(run.pieces.len(), 2);
    assert!(run.prediction.before().max_mm > 0.05 && run.prediction.after().max_mm < 2e-4);
}

fn linear(slope: f64) -> EntryFunction {
    polynomial(&[0.0, slope])
}
