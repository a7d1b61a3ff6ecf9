//! The error model as a whole: forward against hand arithmetic, sensitivities against finite differences, inverse against forward.

use ncfix_base::geometry::{AXES, Axis, AxisVector, Matrix, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::file::DEMO;
use ncfix_machine::machine::{Lever, Machine, State};
use ncfix_model::motion::{EntryFunction, MotionKinds, periodic::Periodic, polynomial::Polynomial};
use ncfix_model::name::DIRECTIONS;
use ncfix_model::{ErrorModel, ErrorName, LocationError, Model, MotionError, Solve, file, write};

/// A generator with a fixed seed (splitmix64), so that a failure repeats.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// Even between −1 and 1.
    pub(crate) fn symmetric(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Linear commands within ±300 mm, rotary ones within ±`rotary_rad`.
    pub(crate) fn command(&mut self, rotary_rad: f64) -> AxisVector {
        AxisVector(AXES.map(|axis| self.symmetric() * if axis.is_rotary() { rotary_rad } else { 300.0 }))
    }
}

/// A machine with every axis of the topology along its direction of F; table-side axes move the other way.
pub(crate) fn machine(topology: &str) -> Machine {
    let mut text = format!("[machine]\nname = \"test\"\ntopology = \"{topology}\"\n");
    let foundation = topology.find('F').unwrap();
    for (at, letter) in topology.char_indices().filter(|(_, letter)| "XYZUVWABC".contains(*letter)) {
        let axis = Axis::from_letter(letter as u8).unwrap();
        let mut direction = [0; 3];
        direction[axis.dimension()] = if at < foundation { -1 } else { 1 };
        let travel = if axis.is_rotary() { "travel_deg = [-360, 360]" } else { "travel_mm = [-400, 400]" };
        text += &format!("[axis.{letter}]\ndirection = {direction:?}\n{travel}\n");
    }
    read(&text).0
}

pub(crate) fn read(text: &str) -> (Machine, ErrorModel) {
    let source = Source::new(FileId(0), "test.toml", text.as_bytes().to_vec()).unwrap();
    let (result, findings) = file::load(&source);
    assert!(findings.is_empty(), "{findings:#?}");
    result.unwrap()
}

pub(crate) fn sample(name: &str) -> (Machine, ErrorModel) {
    read(&std::fs::read_to_string(format!("{}/samples/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"))).unwrap())
}

fn polynomial(name: ErrorName, coefficients: &[f64]) -> MotionError {
    MotionError { name, function: EntryFunction::Polynomial(Polynomial { coefficients: coefficients.to_vec() }) }
}

/// Every location and motion error of a machine, of random size: up to 50 µm and 100 µrad at the limits.
fn all_errors(machine: &Machine, random: &mut Random) -> ErrorModel {
    let mut errors = ErrorModel::default();
    for axis in machine.axis_set().iter() {
        for direction in DIRECTIONS {
            let (size, reach) =
                (if direction.is_rotation() { 1e-4 } else { 0.05 }, if axis.is_rotary() { 3.0 } else { 300.0 });
            let value = size * random.symmetric();
            errors.location.push(LocationError { name: ErrorName::location(direction, axis), value });
            let coefficients: Vec<f64> = (0..4).map(|k| size * random.symmetric() / f64::powi(reach, k)).collect();
            errors.motion.push(polynomial(ErrorName::motion(direction, axis), &coefficients));
        }
    }
    for direction in &DIRECTIONS[..5] {
        let value = if direction.is_rotation() { 1e-4 } else { 0.05 } * random.symmetric();
        errors.location.push(LocationError { name: ErrorName::spindle(*direction), value });
    }
    errors
}

/// Machines of every build: table, head, both; parallel axes; the 45° table.
pub(crate) fn machines() -> Vec<Machine> {
    let topologies = [
        "wFXYZSt",
        "wXYZFSt",
        "wXYFZSt",
        "wCBXFZYSt",
        "wFXYZCBSt",
        "wFXYZBASt",
        "wXFYZBSt",
        "wCXFYZASt",
        "wXYFZWSt",
        "wUXYFVZCBSt",
    ];
    let mut machines: Vec<Machine> = topologies.into_iter().map(machine).collect();
    machines.push(sample("esmaeili_huron").0);
    let mut fixed = machine("wCBXFZYSt");
    fixed.axes.iter_mut().flatten().for_each(|axis| axis.lever = Lever::Fixed);
    fixed.axes[Axis::B.slot()].as_mut().unwrap().point_mm = Vector::new(10.0, -20.0, 30.0);
    fixed.axes[Axis::C.slot()].as_mut().unwrap().point_mm = Vector::new(0.0, 5.0, -7.0);
    fixed.spindle.origin_mm = Vector::new(40.0, 50.0, 60.0);
    machines.push(fixed);
    machines
}

const TOOL: [f64; 3] = [3.0, -2.0, -150.0];

#[test]
fn a_linear_machine_moves_the_tip_by_its_commands() {
    for machine in [machine("wXYFZSt"), machine("wFXYZSt"), machine("wXYZFSt")] {
        let model = Model::new(&machine, &ErrorModel::default());
        assert!(model.is_empty());
        let command = AxisVector([10.0, 20.0, 30.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let pose = model.nominal(&command, &Vector::from(TOOL));
        assert_eq!(pose.translation, Vector::new(13.0, 18.0, -120.0));
        assert_eq!(pose.rotation, Matrix::identity());
    }
}

#[test]
fn no_errors_are_exactly_no_error() {
    let mut random = Random(1);
    for machine in machines() {
        let model = Model::new(&machine, &ErrorModel::default());
        let mut zeros = all_errors(&machine, &mut random);
        zeros.location.iter_mut().for_each(|error| error.value = 0.0);
        zeros.motion.iter_mut().for_each(|error| *error = polynomial(error.name, &[0.0, 0.0]));
        assert!(Model::new(&machine, &zeros).is_empty());
        let (command, tool) = (random.command(3.0), Vector::from(TOOL));
        assert_eq!(model.actual(&command, &tool, &State::default()), model.nominal(&command, &tool));
        assert_eq!(model.tip_error_mm(&command, &command, &tool, &State::default()), Vector::zeros());
        assert_eq!(model.solve(&command, &tool, &State::default(), &random.command(3.0), Solve::Full), Ok(command));
    }
}

/// Every location and motion error, at random poses, on every machine.
#[test]
fn sensitivities_are_the_finite_differences_of_the_forward_function() {
    let mut random = Random(2);
    let (step, tool) = (1e-4, Vector::from(TOOL));
    for machine in machines() {
        let ideal = Model::new(&machine, &ErrorModel::default());
        for axis in machine.axis_set().iter() {
            for direction in DIRECTIONS {
                let command = random.command(3.0);
                let mut twists = Vec::new();
                for name in [ErrorName::location(direction, axis), ErrorName::motion(direction, axis)] {
                    let with = |value: f64| {
                        let mut errors = ErrorModel::default();
                        match name.kind {
                            ncfix_model::name::ErrorKind::Location => {
                                errors.location.push(LocationError { name, value })
                            }
                            ncfix_model::name::ErrorKind::Motion => errors.motion.push(polynomial(name, &[value])),
                        }
                        Model::new(&machine, &errors).volumetric_error(&command, &tool, &State::default())
                    };
                    let (plus, minus) = (with(step), with(-step));
                    let slope = ideal.sensitivity(name, &command, &tool);
                    let translation = (plus.translation - minus.translation) / (2.0 * step) - slope.translation;
                    let rotation = (plus.rotation - minus.rotation) / (2.0 * step) - slope.rotation;
                    assert!(translation.norm() < 2e-5, "{} {name}: {translation}", machine.topology);
                    assert!(rotation.norm() < 1e-7, "{} {name}: {rotation}", machine.topology);
                    twists.push(slope);
                }
                assert!(twists[0].translation.norm() + twists[0].rotation.norm() > 0.5, "no error is without effect");
            }
        }
        for direction in &DIRECTIONS[..5] {
            let name = ErrorName::spindle(*direction);
            let command = random.command(3.0);
            let with = |value: f64| {
                let errors = ErrorModel { location: vec![LocationError { name, value }], ..ErrorModel::default() };
                Model::new(&machine, &errors).volumetric_error(&command, &tool, &State::default())
            };
            let slope = ideal.sensitivity(name, &command, &tool);
            let translation = (with(step).translation - with(-step).translation) / (2.0 * step) - slope.translation;
            assert!(translation.norm() < 2e-5, "{} {name}: {translation}", machine.topology);
        }
    }
}

#[test]
fn the_solution_puts_the_tool_where_it_nominally_is() {
    let mut random = Random(3);
    for machine in machines() {
        let errors = all_errors(&machine, &mut random);
        let model = Model::new(&machine, &errors);
        let rotary = machine.axis_set().iter().filter(|axis| axis.is_rotary()).count();
        let spindle = machine.spindle.axis;
        let (mut undamped, mut before) = (0, 0.0);
        for _ in 0..200 {
            let (nominal, tool) = (random.command(1.4), Vector::from(TOOL));
            let mut state = State::default();
            state.note_motion(&AxisVector::ZERO, &nominal);
            let command = model.solve(&nominal, &tool, &state, &nominal, Solve::Full).unwrap();
            let (target, reached) = (model.nominal(&nominal, &tool), model.actual(&command, &tool, &state));
            before += model.tip_error_mm(&nominal, &nominal, &tool, &state).norm();
            assert!((reached.translation - target.translation).norm() < 1e-6, "{}", machine.topology);
            if rotary == 2 && singular_value(&model, &machine, &nominal, &tool) > 0.06 {
                undamped += 1;
                let tilt = (reached.rotation * spindle).cross(&(target.rotation * spindle)).norm();
                assert!(tilt < 1e-8, "{}: tilt {tilt:e} rad", machine.topology);
            }
            // A start from elsewhere finds the same place.
            let mut start = command;
            start.0.iter_mut().for_each(|value| *value += 1e-3);
            let again = model.solve(&nominal, &tool, &state, &start, Solve::Full).unwrap();
            assert!((model.actual(&again, &tool, &state).translation - target.translation).norm() < 1e-6);
            assert!((again - command).max_abs(&AXES) < 3e-6, "{}: {:?}", machine.topology, (again - command).0);
        }
        assert!(before / 200.0 > 0.02, "there was something to correct");
        assert!(rotary != 2 || undamped > 120, "{}: {undamped} of 200", machine.topology);
    }
}

/// The smaller singular value of the tool axis direction by the rotary commands, by differences.
fn singular_value(model: &Model, machine: &Machine, command: &AxisVector, tool: &Vector) -> f64 {
    let axis_at = |command: &AxisVector| model.nominal(command, tool).rotation * machine.spindle.axis;
    let columns: Vec<Vector> = (machine.axis_set().iter().filter(|axis| axis.is_rotary()))
        .map(|axis| {
            let (mut plus, mut minus) = (*command, *command);
            plus[axis] += 1e-5;
            minus[axis] -= 1e-5;
            (axis_at(&plus) - axis_at(&minus)) / 2e-5
        })
        .collect();
    let (a, b, c) = (columns[0].norm_squared(), columns[0].dot(&columns[1]), columns[1].norm_squared());
    (0.5 * (a + c - ((a - c).powi(2) + 4.0 * b * b).sqrt())).max(0.0).sqrt()
}

#[test]
fn rotary_commands_given_leave_the_position_exact() {
    let mut random = Random(4);
    for machine in machines() {
        let model = Model::new(&machine, &all_errors(&machine, &mut random));
        for _ in 0..20 {
            let (nominal, tool) = (random.command(1.4), Vector::from(TOOL));
            let mut start = model.solve(&nominal, &tool, &State::default(), &nominal, Solve::Full).unwrap();
            for axis in machine.axis_set().iter().filter(|axis| axis.is_rotary()) {
                let increment = 1e-3_f64.to_radians();
                start[axis] = (start[axis] / increment).round() * increment;
            }
            let command = model.solve(&nominal, &tool, &State::default(), &start, Solve::PositionOnly).unwrap();
            for axis in machine.axis_set().iter().filter(|axis| axis.is_rotary()) {
                assert_eq!(command[axis], start[axis]);
            }
            let left = model.tip_error_mm(&nominal, &command, &tool, &State::default());
            assert!(left.norm() < 1e-6, "{}: {left}", machine.topology);
        }
    }
}

#[test]
fn a_parallel_axis_takes_no_part() {
    let machine = machine("wXYFZWSt");
    let mut random = Random(5);
    let model = Model::new(&machine, &all_errors(&machine, &mut random));
    let nominal = random.command(1.0);
    let command = model.solve(&nominal, &Vector::from(TOOL), &State::default(), &nominal, Solve::Full).unwrap();
    assert_eq!(command[Axis::W], nominal[Axis::W]);
    assert_ne!(command[Axis::Z], nominal[Axis::Z]);
}

#[test]
fn a_machine_with_two_linear_axes_corrects_their_directions() {
    let machine = machine("wFXZSt");
    let errors = ErrorModel {
        location: vec![
            LocationError { name: "EX0S".parse().unwrap(), value: 0.02 },
            LocationError { name: "EY0S".parse().unwrap(), value: 0.03 },
        ],
        ..ErrorModel::default()
    };
    let model = Model::new(&machine, &errors);
    let nominal = AxisVector([10.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let tool = Vector::from(TOOL);
    let command = model.solve(&nominal, &tool, &State::default(), &nominal, Solve::Full).unwrap();
    let left = model.tip_error_mm(&nominal, &command, &tool, &State::default());
    assert!((left - Vector::new(0.0, 0.03, 0.0)).norm() < 1e-7, "{left}");
}

#[test]
fn values_that_are_no_numbers_do_not_pass() {
    let (machine, errors) = sample("esmaeili_huron");
    for (machine, errors) in [(machine, errors), read(DEMO)] {
        let model = Model::new(&machine, &errors);
        let mut nominal = AxisVector([100.0; 9]);
        let tool = Vector::from(TOOL);
        let mut start = nominal;
        start[Axis::X] = f64::NAN;
        assert!(model.solve(&nominal, &tool, &State::default(), &start, Solve::Full).is_ok());
        nominal[Axis::X] = f64::NAN;
        assert!(model.solve(&nominal, &tool, &State::default(), &nominal, Solve::Full).is_err());
        nominal[Axis::X] = f64::INFINITY;
        assert!(model.solve(&nominal, &tool, &State::default(), &nominal, Solve::PositionOnly).is_err());
    }
}

/// Errors far too large end in a finding, not in a wrong command.
#[test]
fn what_cannot_be_reached_is_said() {
    let machine = machine("wFXYZSt");
    let errors = ErrorModel { motion: vec![polynomial("EXX".parse().unwrap(), &[5.0, -1.0])], ..ErrorModel::default() };
    let model = Model::new(&machine, &errors);
    let nominal = AxisVector::ZERO;
    assert!(model.solve(&nominal, &Vector::zeros(), &State::default(), &nominal, Solve::Full).is_err());
}

/// Pitch of Y by 1 mrad: the arm from the carriage to the tip, with and without the motion of Y itself.
#[test]
fn the_lever_carries_the_error_or_stays_where_it_is() {
    let mut machine = machine("wFYSt");
    let errors = ErrorModel { motion: vec![polynomial("ECY".parse().unwrap(), &[1e-3])], ..ErrorModel::default() };
    let mut command = AxisVector::ZERO;
    command[Axis::Y] = 400.0;
    let tool = Vector::new(0.0, 50.0, 0.0);
    let error =
        |machine: &Machine| Model::new(machine, &errors).tip_error_mm(&command, &command, &tool, &State::default());
    // Carried: rotation about the carriage, arm 50 mm. Fixed: about the origin of the axis, arm 450 mm.
    let carried = Vector::new(-50.0 * 1e-3_f64.sin(), 50.0 * (1e-3_f64.cos() - 1.0), 0.0);
    assert!((error(&machine) - carried).norm() < 1e-12);
    machine.axes[Axis::Y.slot()].as_mut().unwrap().lever = Lever::Fixed;
    assert!((error(&machine) - carried * 9.0).norm() < 1e-12);
    machine.axes[Axis::Y.slot()].as_mut().unwrap().point_mm = Vector::new(0.0, 100.0, 0.0);
    assert!((error(&machine) - carried * 7.0).norm() < 1e-12, "the arm begins at the point of the axis");
}

/// Spaan eq. 2.7 to 2.9: in a chain F-X-Y-Z each rotation acts on the arm from its axis to the tip, which includes the motions of
/// the axes behind it, and of itself. First order, so 1 µrad is exact enough.
#[test]
fn the_arms_of_a_chain_are_those_of_spaan() {
    let mut machine = machine("wFXYZSt");
    machine.axes.iter_mut().flatten().for_each(|axis| axis.lever = Lever::Fixed);
    let (x, y, z) = (200.0, 150.0, -80.0);
    let command = AxisVector([x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let tool = Vector::new(7.0, 0.0, -120.0);
    let arm = |letter: char| match letter {
        'X' => Vector::new(x, y, z) + tool,
        'Y' => Vector::new(0.0, y, z) + tool,
        _ => Vector::new(0.0, 0.0, z) + tool,
    };
    for letter in ['X', 'Y', 'Z'] {
        for (name, rotation) in [('A', Vector::x()), ('B', Vector::y()), ('C', Vector::z())] {
            let motion = vec![polynomial(format!("E{name}{letter}").parse().unwrap(), &[1e-6])];
            let model = Model::new(&machine, &ErrorModel { motion, ..ErrorModel::default() });
            let error = model.tip_error_mm(&command, &command, &tool, &State::default());
            assert!((error - rotation.cross(&arm(letter)) * 1e-6).norm() < 1e-9, "E{name}{letter}");
        }
    }
}

#[test]
fn an_error_of_the_table_is_that_of_the_table() {
    // The table goes 10 µm too far in +X of F: the tool is 10 µm short in the workpiece.
    let machine = machine("wXFYZSt");
    let errors = ErrorModel { motion: vec![polynomial("EXX".parse().unwrap(), &[0.01])], ..ErrorModel::default() };
    let model = Model::new(&machine, &errors);
    let command = AxisVector([100.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let error = model.tip_error_mm(&command, &command, &Vector::zeros(), &State::default());
    assert!((error - Vector::new(-0.01, 0.0, 0.0)).norm() < 1e-12);
    let solved = model.solve(&command, &Vector::zeros(), &State::default(), &command, Solve::Full).unwrap();
    assert!((solved[Axis::X] - 100.01).abs() < 1e-7, "the tool is sent farther: the table goes back by as much");
}

#[test]
fn mirrored_directions_and_commands_are_the_same_machine() {
    let (machine, errors) = sample("esmaeili_huron");
    let mut mirrored = machine.clone();
    for axis in [Axis::Y, Axis::A, Axis::C] {
        mirrored.axes[axis.slot()].as_mut().unwrap().direction *= -1.0;
    }
    let mut mirrored_errors = errors.clone();
    mirrored_errors.motion[1] = polynomial("EYY".parse().unwrap(), &[0.0, -1.43e-5]);
    let (first, second) = (Model::new(&machine, &errors), Model::new(&mirrored, &mirrored_errors));
    let mut random = Random(6);
    for _ in 0..50 {
        let command = random.command(3.0);
        let mut other = command;
        [Axis::Y, Axis::A, Axis::C].into_iter().for_each(|axis| other[axis] *= -1.0);
        let tool = Vector::from(TOOL);
        let (a, b) =
            (first.actual(&command, &tool, &State::default()), second.actual(&other, &tool, &State::default()));
        assert!((a.translation - b.translation).norm() < 1e-10);
        assert!((a.rotation - b.rotation).norm() < 1e-13);
    }
}

#[test]
fn at_the_singularity_rotary_corrections_stay_small_and_the_position_exact() {
    let (machine, errors) = sample("esmaeili_huron");
    let model = Model::new(&machine, &errors);
    let tool = Vector::new(0.0, 0.0, -160.0);
    let mut last: Option<AxisVector> = None;
    for tenth in -400..=400 {
        let mut nominal = AxisVector([80.0, -60.0, 200.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.7]);
        nominal[Axis::A] = f64::from(tenth) * 0.025_f64.to_radians();
        let command = model.solve(&nominal, &tool, &State::default(), &nominal, Solve::Full).unwrap();
        let correction = command - nominal;
        // Tilts of 150 µrad at ε = 0.05: never more than about 150e-6 / 0.05.
        assert!(correction.max_abs(&[Axis::A, Axis::C]) < 4e-3, "A {}: {:?}", nominal[Axis::A], correction.0);
        assert!(model.tip_error_mm(&nominal, &command, &tool, &State::default()).norm() < 1e-6);
        if let Some(last) = last {
            let jump = (correction - last).max_abs(&[Axis::A, Axis::C]);
            assert!(jump < 1e-4, "no jump along the way: {jump} at A {}", nominal[Axis::A]);
        }
        last = Some(correction);
    }
    // Exactly at A0 only the tilt that the remaining direction can make is taken.
    let nominal = AxisVector([80.0, -60.0, 200.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.7]);
    let command = model.solve(&nominal, &tool, &State::default(), &nominal, Solve::Full).unwrap();
    assert_eq!(command[Axis::C], nominal[Axis::C], "C does not turn the axis of a tool that is parallel to it");
}

#[test]
fn features_say_where_to_sample() {
    let (machine, errors) = read(DEMO);
    let model = Model::new(&machine, &errors);
    // EXX of degree 3 on 700 mm; EYY a table every 100 mm on Y, degree 3 besides.
    assert!((model.features(Axis::X).length - 700.0 / 6.0).abs() < 1e-12);
    assert_eq!(model.features(Axis::Y).knots, [0.0, 100.0, 200.0, 300.0, 400.0, 500.0]);
    assert!((model.features(Axis::Y).length - 500.0 / 6.0).abs() < 1e-12);
    assert_eq!(model.features(Axis::Z).knots.len(), 6);
    assert!(AXES.iter().all(|&axis| !model.features(axis).backlash));
    assert_eq!(model.features(Axis::W).length, 500.0);
    assert!((model.features(Axis::C).length - 30_f64.to_radians()).abs() < 1e-12);
}

#[test]
fn the_kinds_are_those_of_the_documentation() {
    let kinds = MotionKinds::default();
    let names: Vec<&str> = kinds.names().collect();
    assert_eq!(names, ["polynomial", "table", "piecewise", "periodic", "backlash", "cross", "grid"]);
}

#[test]
fn errors_of_the_demo_machine_are_of_realistic_size() {
    let (machine, errors) = read(DEMO);
    let model = Model::new(&machine, &errors);
    let mut names: Vec<String> = errors.motion.iter().map(|error| error.name.to_string()).collect();
    names.extend(errors.location.iter().map(|error| error.name.to_string()));
    names.sort();
    names.dedup();
    assert_eq!(names.len(), 21, "18 motion and 3 location errors");
    let tool = Vector::new(0.0, 0.0, -100.0);
    let mut worst_mm = 0.0_f64;
    for x in 0..=7 {
        for y in 0..=5 {
            for z in 0..=5 {
                let command = AxisVector([
                    100.0 * f64::from(x),
                    100.0 * f64::from(y),
                    100.0 * f64::from(z) - 50.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                ]);
                worst_mm = worst_mm.max(model.tip_error_mm(&command, &command, &tool, &State::default()).norm());
            }
        }
    }
    assert!((0.015..0.06).contains(&worst_mm), "{worst_mm}");
}

/// A control has no time for more: what is left behind the second step is the error times the square of its slopes.
#[test]
fn two_steps_in_a_cycle_put_the_tool_where_it_nominally_is() {
    let mut random = Random(31);
    for machine in machines() {
        let errors = all_errors(&machine, &mut random);
        let model = Model::new(&machine, &errors);
        let tool = Vector::from(TOOL);
        for _ in 0..50 {
            let nominal = random.command(1.4);
            let state = State::default();
            let target = model.nominal(&nominal, &tool).translation;
            // Linear axes that a rotary one turns nearly parallel to each other have no solution either way.
            let Ok(command) = model.solve(&nominal, &tool, &state, &nominal, Solve::Full) else { continue };
            if model.is_near_singularity(&nominal, &tool) {
                continue;
            }
            for mode in [Solve::Full, Solve::PositionOnly] {
                let found = model.solve_in_cycle(&nominal, &tool, &state, mode).unwrap();
                let left = (model.actual(&found, &tool, &state).translation - target).norm();
                assert!(left < 2e-5, "{} {mode:?}: {left:e} mm", machine.topology);
            }
            assert!((command - nominal).max_abs(&AXES) > 0.0);
        }
    }
}

/// A chord over an interval of h is off a parabola c q² by c (q − a) (b − q), at most c h²/8.
#[test]
fn tables_of_equal_intervals_take_in_what_they_can_follow() {
    let machine = machine("wFXYZSt");
    let name = |text: &str| text.parse::<ErrorName>().unwrap();
    let curve = polynomial(name("EXX"), &[0.0, 0.0, 1e-7]);
    // 10 µm over 10 mm: chords of 4 mm are off by more than 2 µm.
    let wave = Periodic { amplitude: 0.01, period: 10.0, phase_rad: 0.0 };
    let wave = MotionError { name: name("EYY"), function: EntryFunction::Periodic(wave) };
    let errors = ErrorModel { motion: vec![curve, wave], ..ErrorModel::default() };
    let direct = Model::new(&machine, &errors);
    let model = direct.on_intervals(&machine, 200);
    let counts = |model: &Model| [Axis::X, Axis::Y, Axis::Z].map(|axis| model.direct_functions(axis));
    assert_eq!((counts(&direct), counts(&model)), ([1, 1, 0], [0, 1, 0]));
    // 200 intervals of the 800 mm from −400 mm are 4 mm each.
    for (q, within) in [(0.0, 0.0), (1.0, 1.0 * 3.0), (2.0, 2.0 * 2.0), (203.5, 3.5 * 0.5)] {
        let command = AxisVector([q, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let found = model.deviation(&command, &Vector::zeros(), &State::default()).translation.x;
        assert!((found - 1e-7 * (q * q + within)).abs() < 1e-12, "{q}: {found:e}");
    }
}

/// Behind A the tool leans against C by A: the singular value of the direction by C is sin A, that by A is 1. ε is 0.05.
#[test]
fn a_singularity_begins_at_2_87_degrees() {
    let limit = 0.05_f64.asin();
    for machine in [machine("wCAYFXZSt"), machine("wCAFXYZSt")] {
        let model = Model::new(&machine, &ErrorModel::default());
        let is_near = |a: f64, c: f64| {
            let mut command = AxisVector::ZERO;
            (command[Axis::A], command[Axis::C]) = (a, c);
            model.is_near_singularity(&command, &Vector::from(TOOL))
        };
        for (a, expected) in
            [(0.0, true), (0.999 * limit, true), (1.001 * limit, false), (-0.999 * limit, true), (0.7, false)]
        {
            assert_eq!([is_near(a, 0.0), is_near(a, 2.0)], [expected; 2], "{a}");
        }
    }
    // One axis turns the tool in one direction only, everywhere the same; none turns it in none.
    let [alone, none] = ["wBXYFZSt", "wXYFZSt"].map(|topology| Model::new(&machine(topology), &ErrorModel::default()));
    for model in [alone, none] {
        assert!(!model.is_near_singularity(&AxisVector::ZERO, &Vector::from(TOOL)));
    }
}

#[test]
fn a_changed_error_takes_the_place_of_the_old_one_in_the_file() {
    let head = "[machine]\nname = \"test\"\ntopology = \"wFXYZSt\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 400]\n\
        [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 400]\n";
    // What has no parameters stands between: it is not written, and must not be asked for.
    let text = format!(
        "{head}[location]\nEC0Y = 20 # a square\nEB0Z = 7\n[[motion]]\ncomponent = \"EYY\"\nkind = \"periodic\"\nperiod_mm = 10\n\
         amplitude_um = 1\n[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0.0, 2e-5]\n"
    );
    let (_, errors) = read(&text);
    assert_eq!(write::write(&text, &errors, &errors).unwrap(), text);
    let mut changed = errors.clone();
    changed.location[0].value = 30e-6;
    changed.motion[1] = polynomial(errors.motion[1].name, &[1e-3, 4e-5]);
    let written = write::write(&text, &errors, &changed).unwrap();
    let (_, found) = read(&written);
    assert!((found.location[0].value - 30e-6).abs() < 1e-18 && found.location[1] == errors.location[1]);
    assert_eq!(found.motion, changed.motion);
    assert!(written.contains(" # a square\n") && written.starts_with(head));
    // An entry that the text has not is no place to write to.
    assert!(write::write(head, &errors, &changed).is_err());
}
