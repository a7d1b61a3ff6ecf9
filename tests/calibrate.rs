//! Calibration: a true error model, readings of it by exact kinematics, and what a fit makes of them. Here the bench; the tests are in
//! `calibrate_*.rs`.

use nalgebra::Rotation3;
use ncfix_base::diagnostic::Place;
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Span};
use ncfix_machine::machine::{Branch, Kinematics, Machine, State};
use ncfix_metrology::calibrate::{Fit, FitOptions, fit, identify};
use ncfix_metrology::measure::data::{DataSet, Free, KnownLength, Observation, Setup};
use ncfix_metrology::measure::kind::Instruments;
use ncfix_metrology::measure::reading::Reading;
use ncfix_model::parameter::ParameterName;
use ncfix_model::{ErrorModel, ErrorName, Model};

use crate::model::Random;

impl Random {
    /// Normal, of variance 1 (Box and Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        let (size, turn) = (self.symmetric() / 2.0 + 0.5, self.symmetric());
        (-2.0 * size.max(1e-300).ln()).sqrt() * (std::f64::consts::PI * turn).cos()
    }
}

/// A machine with its true errors, and what is true of the set-ups.
#[derive(Clone)]
pub(crate) struct Bench {
    pub(crate) machine: Machine,
    pub(crate) parameters: Vec<ParameterName>,
    pub(crate) errors: ErrorModel,
    pub(crate) data: Vec<DataSet>,
    /// True unknowns of each measurement, as its kind lists them.
    pub(crate) unknowns: Vec<Vec<f64>>,
}

/// Parameters by their names.
pub(crate) fn named(names: &str) -> Vec<ParameterName> {
    names.split_whitespace().map(|name| name.parse().unwrap()).collect()
}

pub(crate) fn reading(position: AxisVector, tool_mm: Vector, state: State) -> Reading {
    Reading { position, tool_mm, state }
}

pub(crate) fn measurement(kind: &str, free: &[Free]) -> DataSet {
    DataSet {
        balls: Vec::new(),
        is_plan: false,
        fixed: Vec::new(),
        ranges: Vec::new(),
        conditions: Vec::new(),
        is_in_order: true,
        is_order_stated: true,
        is_unit_stated: false,
        is_square_stated: false,
        sensors: None,
        has_senses: true,
        name: kind.to_owned(),
        kind: Instruments::default().find(kind).copied().unwrap(),
        date: None,
        head: None,
        sigma: None,
        sigma_rad: None,
        scale_sigma: 0.0,
        free: free.to_vec(),
        artefact: Setup::default(),
        rods: Vec::new(),
        cycles: Vec::new(),
        setups: Vec::new(),
        runs: vec![String::new()],
        targets: Vec::new(),
        lengths: Vec::new(),
        observations: Vec::new(),
        drivers: Vec::new(),
    }
}

pub(crate) fn setup(label: &str, centre_mm: [f64; 3], length_mm: f64) -> Setup {
    Setup { label: label.to_owned(), centre_mm: Vector::from(centre_mm), length_mm, ..Setup::default() }
}

/// An observation that read zero.
pub(crate) fn observation(reading: Reading, setup: usize) -> Observation {
    Observation {
        reading,
        setup,
        run: 0,
        t_s: None,
        condition: 0,
        temperature_c: None,
        feed: None,
        cycle: None,
        values: [Some(0.0); 3],
        target: None,
        component: None,
        spindle_rad: 0.0,
        place: Place { file: FileId(0), span: Span::default() },
    }
}

/// Axis positions: `[('X', 10.0), ('B', 30.0)]`, mm and degrees.
pub(crate) fn at(values: &[(char, f64)]) -> AxisVector {
    let mut out = AxisVector::ZERO;
    for &(letter, value) in values {
        let axis = Axis::from_letter(letter as u8).unwrap();
        out[axis] = if axis.is_rotary() { value.to_radians() } else { value };
    }
    out
}

/// Random errors of parameters, whose effects on the tip are about `size_mm`.
pub(crate) fn errors(parameters: &[ParameterName], size_mm: f64, random: &mut Random) -> ErrorModel {
    let mut errors = ErrorModel::default();
    for parameter in parameters {
        let arm: f64 = if parameter.component.direction.is_rotation() { 300.0 } else { 1.0 };
        let reach: f64 = if parameter.component.axis().is_some_and(|axis| axis.is_rotary()) { 1.5 } else { 250.0 };
        let sign = if random.symmetric() < 0.0 { -1.0 } else { 1.0 };
        let value = size_mm * sign * (0.5 + 0.5 * random.symmetric().abs());
        parameter.set(&mut errors, value / arm / reach.powi(i32::from(parameter.degree())));
    }
    errors
}

impl Bench {
    pub(crate) fn new(machine: Machine, parameters: Vec<ParameterName>, data: Vec<DataSet>, seed: u64) -> Bench {
        let mut random = Random(seed);
        let errors = errors(&parameters, 0.03, &mut random);
        let unknowns = data.iter().map(|set| vec![0.0; (set.kind.unknowns)(set).len()]).collect();
        Bench { machine, parameters, errors, data, unknowns }
    }

    /// The data with readings: `noise_mm` of normal noise (a thousandth of it in rad for angles), and a share of the rows 50 times off.
    pub(crate) fn measured(
        &self,
        noise_mm: f64,
        outliers: f64,
        random: &mut Random,
    ) -> (Vec<DataSet>, Vec<(usize, usize)>) {
        let mut data = self.data.clone();
        let mut off = Vec::new();
        let model = Model::new(&self.machine, &self.errors);
        for (number, (set, unknowns)) in data.iter_mut().zip(&self.unknowns).enumerate() {
            let copy = set.clone();
            for (row, observation) in set.observations.iter_mut().enumerate() {
                let is_off = random.symmetric() / 2.0 + 0.5 < outliers;
                let mut noise = Vector::from_fn(|_, _| random.normal() * noise_mm);
                if is_off {
                    off.push((number, row));
                    noise = noise.map(|part| part.signum() * 50.0 * noise_mm);
                }
                self.read(&model, &copy, unknowns, observation, &noise);
            }
        }
        (data, off)
    }

    fn read(&self, model: &Model, set: &DataSet, unknowns: &[f64], observation: &mut Observation, noise: &Vector) {
        let Reading { position, tool_mm, state } = observation.reading;
        let three = |first: usize| Vector::from_fn(|k, _| unknowns.get(first + k).copied().unwrap_or(0.0));
        let setups = set.setups.len();
        let has = |free: Free| set.free.contains(&free);
        match set.kind.name {
            "displacement" => {
                // The artifact's point, as seen from where the tool nominally is, turned into F.
                let place = model.nominal(&position, &tool_mm).translation;
                let offset = if has(Free::Offset) { three(3 * observation.setup) } else { Vector::zeros() };
                let turn = if has(Free::Offset) { 3 * setups } else { 0 } + 3 * observation.setup;
                let turn = if has(Free::Rotation) { three(turn) } else { Vector::zeros() };
                // An artifact that is warm is larger as seen from the point that stays.
                let of = &set.setups[observation.setup];
                let warmth = of.expansion_per_k * (of.temperature_c.unwrap_or(20.0) - 20.0);
                let grown = place + (place - of.origin_mm.unwrap_or(place)) * warmth;
                let moved = Rotation3::new(turn) * grown + offset - place;
                let kinematics = Kinematics::new(&self.machine);
                let to_f = model.tool_orientation(&position) * kinematics.rotation(&position).transpose();
                let read = model.deviation(&position, &tool_mm, &state).translation - to_f * moved + noise;
                observation.values = [0, 1, 2].map(|k| Some(read[k]));
            }
            "ballbar" => {
                let setup = &set.setups[observation.setup];
                let ball = setup.centre_mm + three(3 * observation.setup);
                let which = if has(Free::Rod) { setup.rod } else { observation.setup };
                let warmth = setup.expansion_per_k * (setup.temperature_c.unwrap_or(20.0) - 20.0);
                let longer = unknowns.get(3 * setups + which).copied().unwrap_or(0.0);
                let length = (setup.length_mm + longer) * (1.0 + warmth);
                let tip = model.actual(&position, &tool_mm, &state).translation;
                observation.values[0] = Some((tip - ball).norm() - length + noise.x);
            }
            "probe" => {
                let target = observation.target.unwrap();
                let axis = nalgebra::Unit::new_normalize(self.machine.spindle.axis);
                let tool = 3 * (set.targets.len() + observation.setup);
                let spindle = Rotation3::from_axis_angle(&axis, observation.spindle_rad);
                let tool = tool_mm + if has(Free::Tool) { spindle * three(tool) } else { Vector::zeros() };
                let wanted = three(3 * target) + noise;
                let kinematics = Kinematics::new(&self.machine);
                let mut aim = wanted;
                let mut command = position;
                for _ in 0..12 {
                    command = kinematics.placed(&aim, &command, &tool).unwrap();
                    aim += wanted - model.actual(&command, &tool, &state).translation;
                }
                assert!((model.actual(&command, &tool, &state).translation - wanted).norm() < 1e-11);
                observation.reading.position = command;
            }
            "direct" => {
                let component = observation.component.unwrap();
                let deviation = model.deviation(&position, &tool_mm, &state);
                let on_table =
                    component.axis().and_then(|axis| self.machine.topology.branch(axis)) == Some(Branch::Workpiece);
                let sense = if on_table { -1.0 } else { 1.0 };
                let k = component.direction.index() % 3;
                let offset = observation.setup * set.targets.len() + observation.target.unwrap();
                let mut offset = if has(Free::Offset) { unknowns[offset] } else { 0.0 };
                if let Some((cycle, time)) = observation.cycle {
                    let first = setups * set.targets.len();
                    let level = set.cycles[cycle].level;
                    let level = level.map_or(0.0, |level| unknowns[first + set.cycles.len() + level]);
                    offset += unknowns[first + cycle] * time + level;
                }
                let value = if component.direction.is_rotation() {
                    deviation.rotation[k] * sense + offset + noise.x / 1000.0
                } else {
                    deviation.translation[k] * sense + offset + noise.x
                };
                observation.values[0] = Some(value);
            }
            other => panic!("{other}"),
        }
    }

    /// Fits the data, from a machine without errors.
    pub(crate) fn fit(&self, data: &[DataSet], robust: bool) -> Fit {
        fit(&self.machine, &ErrorModel::default(), &self.parameters, data, FitOptions { robust })
            .unwrap_or_else(|fault| panic!("{fault:?}"))
    }

    /// The true values of all columns.
    pub(crate) fn truth(&self) -> Vec<f64> {
        let parameters = self.parameters.iter().map(|name| name.get(&self.errors));
        parameters.chain(self.unknowns.iter().flatten().copied()).collect()
    }

    /// What the data cannot tell; the readings do not matter.
    pub(crate) fn lost(&self) -> Vec<String> {
        let lost = identify(&self.machine, &ErrorModel::default(), &self.parameters, &self.data).unwrap().lost;
        lost.confused.into_iter().map(|one| one.sentence).collect()
    }
}

/// Three axes: plates in three planes at two places each, with two tools.
pub(crate) fn plates() -> Bench {
    let parameters = named(
        "EXX1 EXX2 EXX3 EXXb EYY1 EYY2 EZZ1 EZZ2 EYX2 EZX2 EXY2 EZY2 EXZ2 EYZ2 EAX1 EBX1 ECX1 EAY1 EBY1 ECY1 EAZ1 EBZ1 \
         ECZ1 EC0Y EA0Z EB0Z",
    );
    let mut set = measurement("displacement", &[Free::Offset, Free::Rotation]);
    let mut random = Random(3);
    for (number, (plane, height)) in [(2, -80.0), (2, 120.0), (0, -90.0), (0, 150.0), (1, 10.0)].into_iter().enumerate()
    {
        set.setups.push(setup(&format!("P{number}"), [0.0; 3], 0.0));
        for tool in [[0.0, 0.0, -60.0], [90.0, 40.0, -180.0]] {
            for k in 0..16 {
                let mut place = [0.0; 3];
                place[(plane + 1) % 3] = f64::from(k % 4) * 100.0 - 150.0;
                place[(plane + 2) % 3] = f64::from(k / 4) * 100.0 - 150.0;
                place[plane] = height;
                let position = at(&[('X', place[0]), ('Y', place[1]), ('Z', place[2])]);
                let mut state = State::default();
                AXES.iter()
                    .for_each(|axis| state.direction[axis.slot()] = if random.symmetric() < 0.0 { -1 } else { 1 });
                set.observations.push(observation(reading(position, Vector::from(tool), state), number));
            }
        }
    }
    let mut bench = Bench::new(crate::model::machine("wXFYZSt"), parameters, vec![set], 11);
    // Half a millimetre and a milliradian: where squares count.
    bench.unknowns[0].iter_mut().enumerate().for_each(|(k, value)| {
        *value = random.symmetric() * if k < 15 { 0.5 } else { 1e-3 };
    });
    bench
}

/// Ball-bar circles in three planes at two places, in both senses.
pub(crate) fn circles(points: usize, senses: &[f64]) -> Bench {
    let parameters = named("EC0Y EA0Z EB0Z EYY1 EZZ1 EXXb EYYb EZZb EXX2 EYY2 EZZ2 EYX2 EXY2");
    let mut set = measurement("ballbar", &[Free::Centre, Free::Length]);
    let tool = Vector::new(0.0, 0.0, -70.0);
    let places = [[-100.0, 20.0, 60.0], [120.0, -50.0, -80.0]];
    for (number, (plane, centre)) in (0..3).flat_map(|plane| places.map(|centre| (plane, centre))).enumerate() {
        set.setups.push(setup(&format!("{number}"), centre, 150.0));
        for &sense in senses {
            for k in 0..points {
                let angle = std::f64::consts::TAU * (k as f64 + 0.3) / points as f64 * sense;
                let mut tip = Vector::from(centre);
                let mut along = Vector::zeros();
                let (first, second) = ((plane + 1) % 3, (plane + 2) % 3);
                (tip[first], tip[second]) = (tip[first] + 150.0 * angle.cos(), tip[second] + 150.0 * angle.sin());
                (along[first], along[second]) = (-angle.sin() * sense, angle.cos() * sense);
                let mut position = AxisVector::ZERO;
                position.set_xyz(tip - tool);
                let mut state = State::default();
                for k in 0..3 {
                    state.direction[k] = if along[k] > 0.0 { 1 } else { -1 };
                }
                set.observations.push(observation(reading(position, tool, state), number));
            }
        }
    }
    let setups = set.setups.len();
    let mut bench = Bench::new(crate::model::machine("wXFYZSt"), parameters, vec![set], 5);
    let mut random = Random(8);
    bench.unknowns[0].iter_mut().enumerate().for_each(|(k, value)| {
        // Two set-ups in each plane; what is across a circle cannot be told, and is as described.
        let is_across = k < 3 * setups && k % 3 == k / 6;
        *value = random.symmetric()
            * if is_across {
                0.0
            } else if k < 3 * setups {
                0.2
            } else {
                0.05
            };
    });
    bench
}

/// Table 4-1: indexes of spindle, B and C, and the balls that are probed there.
const TABLE_4_1: &[([f64; 3], &[usize])] = &[
    ([0.0, 10.0, 30.0], &[3, 4, 5]),
    ([0.0, 30.0, 90.0], &[3, 4, 5]),
    ([0.0, 50.0, 150.0], &[3, 4, 5]),
    ([0.0, 70.0, 210.0], &[3, 4, 5]),
    ([0.0, 90.0, 270.0], &[3, 4, 5, 6]),
    ([0.0, 60.0, 180.0], &[3, 4, 5]),
    ([0.0, 40.0, 120.0], &[3, 4, 6]),
    ([0.0, 20.0, 60.0], &[3, 4, 6]),
    ([0.0, -10.0, -30.0], &[3, 4, 5]),
    ([0.0, -30.0, -90.0], &[3, 4, 5]),
    ([0.0, -50.0, -150.0], &[3, 4, 5]),
    ([0.0, -70.0, -210.0], &[3, 4, 5]),
    ([0.0, -90.0, -270.0], &[3, 4, 5, 6]),
    ([0.0, -60.0, -180.0], &[3, 4, 5]),
    ([0.0, -40.0, -120.0], &[3, 4, 6]),
    ([0.0, -20.0, -60.0], &[3, 4, 6]),
    ([0.0, 0.0, 90.0], &[1, 2, 3, 4, 5, 6]),
    ([0.0, 0.0, 240.0], &[3, 4, 5]),
    ([0.0, 0.0, 300.0], &[3, 4, 5]),
    ([0.0, 0.0, 180.0], &[1, 2, 3, 4, 5, 6]),
    ([0.0, 0.0, 45.0], &[1, 2, 3, 4, 5, 6]),
    ([0.0, 0.0, -45.0], &[1, 2, 3, 4, 5, 6]),
    ([0.0, 0.0, -180.0], &[1, 2, 3, 4, 5, 6]),
    ([0.0, 0.0, -300.0], &[3, 4, 5]),
    ([0.0, 0.0, -240.0], &[3, 4, 5]),
    ([0.0, 0.0, -90.0], &[1, 2, 3, 4, 5, 6]),
    ([0.0, 0.0, 0.0], &[1, 2, 3, 4, 5, 6]),
    ([60.0, 0.0, 0.0], &[3]),
    ([120.0, 0.0, 0.0], &[3]),
    ([180.0, 0.0, 0.0], &[3]),
    ([240.0, 0.0, 0.0], &[3]),
    ([300.0, 0.0, 0.0], &[3]),
];

/// Table 5-3: indexes of A and C.
const TABLE_5_3: &[[f64; 2]] = &[
    [15.0, 60.0],
    [30.0, 180.0],
    [45.0, 280.0],
    [55.0, 340.0],
    [40.0, 240.0],
    [20.0, 120.0],
    [0.0, 0.0],
    [-20.0, -100.0],
    [-40.0, 250.0],
    [-55.0, 350.0],
    [-50.0, -310.0],
    [-25.0, -40.0],
    [0.0, 180.0],
    [0.0, 280.0],
    [0.0, 360.0],
    [0.0, 320.0],
    [0.0, 210.0],
    [0.0, -160.0],
    [0.0, -300.0],
    [0.0, -220.0],
    [0.0, -50.0],
    [15.0, 0.0],
    [40.0, 0.0],
    [55.0, 0.0],
    [45.0, 0.0],
    [30.0, 0.0],
    [-20.0, 0.0],
    [-45.0, 0.0],
    [-55.0, 0.0],
    [-35.0, 0.0],
    [44.0, -30.0],
    [53.0, -208.0],
    [36.0, -318.0],
    [30.0, 45.0],
    [21.0, 326.0],
    [9.0, 290.0],
    [-16.0, -12.0],
    [-54.0, -304.0],
    [-40.0, -10.0],
    [-17.0, 100.0],
    [-38.0, 197.0],
    [-5.0, 345.0],
];

/// A probing plan on balls: angles by axis letter and of the spindle, and the ball. Senses follow from the order.
fn probings(
    machine: &Machine,
    balls: &[[f64; 3]],
    tool_mm: Vector,
    plan: impl Iterator<Item = (AxisVector, f64, usize)>,
) -> DataSet {
    let mut set = measurement("probe", &[Free::Tool]);
    set.setups.push(setup("", [0.0; 3], 0.0));
    set.targets = (1..=balls.len()).map(|number| format!("b{number}")).collect();
    let kinematics = Kinematics::new(machine);
    let mut state = State::default();
    let mut last = AxisVector::ZERO;
    for (index, spindle_deg, ball) in plan {
        let command = kinematics.placed(&Vector::from(balls[ball]), &index, &tool_mm).unwrap();
        state.note_motion(&last, &command);
        last = command;
        let mut row = observation(reading(command, tool_mm, state), 0);
        row.target = Some(ball);
        row.spindle_rad = spindle_deg.to_radians();
        set.observations.push(row);
    }
    set
}

/// Balls, the stylus offset, and the known distance of the first two.
fn probing_bench(machine: Machine, parameters: Vec<ParameterName>, balls: &[[f64; 3]], set: DataSet) -> Bench {
    let mut bench = Bench::new(machine, parameters, vec![set], 21);
    bench.unknowns[0] = balls.iter().flatten().copied().chain([0.02, -0.03, 0.05]).collect();
    bench
}

/// The plan of Table 4-1 (SAMBA) on a machine wCBXFZYSt; the scale bar is the first and second ball.
pub(crate) fn samba(parameters: Vec<ParameterName>, scale_bar: bool) -> Bench {
    let machine = crate::model::machine("wCBXFZYSt");
    let balls = [
        [-120.0, 150.0, 60.0],
        [130.0, -20.0, 75.0],
        [-160.0, -110.0, 90.0],
        [30.0, 170.0, 140.0],
        [180.0, 90.0, 50.0],
        [70.0, -150.0, 200.0],
    ];
    let rows =
        TABLE_4_1.iter().flat_map(|([s, b, c], ids)| ids.iter().map(|id| (at(&[('B', *b), ('C', *c)]), *s, id - 1)));
    let mut set = probings(&machine, &balls, Vector::new(0.0, 0.0, -275.86), rows);
    assert_eq!(set.observations.len(), 109);
    if scale_bar {
        let value_mm = (Vector::from(balls[0]) - Vector::from(balls[1])).norm();
        set.lengths.push(KnownLength { between: [0, 1], value_mm, sigma_mm: Some(1e-6) });
    }
    probing_bench(machine, parameters, &balls, set)
}

/// The plan of Table 5-3 (RUMBA) on a machine wCAYFXZSt, one ball after another.
pub(crate) fn rumba(parameters: Vec<ParameterName>) -> Bench {
    let machine = crate::model::machine("wCAYFXZSt");
    let balls = [[-60.0, 45.0, 37.5], [50.0, 60.0, 37.5], [-20.0, -75.0, 47.5], [80.0, -15.0, 47.5]];
    let rows = (0..4).flat_map(|ball| TABLE_5_3.iter().map(move |[a, c]| (at(&[('A', *a), ('C', *c)]), 0.0, ball)));
    let set = probings(&machine, &balls, Vector::new(0.0, 0.0, -74.0), rows);
    probing_bench(machine, parameters, &balls, set)
}

/// Laser, straightedge and level along each axis, there and back, at two places of the tool.
pub(crate) fn lines() -> Bench {
    let parameters = named(
        "EXX1 EXX2 EXX3 EXXb EYX2 EZX3 EAX1 EBX1 EBX2 ECX1 EYY1 EYY2 EYYb EXY2 EAY1 EBY2 ECY1 EZZ1 EZZb EBZ1 EAZ2",
    );
    let mut set = measurement("direct", &[Free::Offset]);
    set.targets = parameters.iter().map(|name| name.component.to_string()).collect();
    set.targets.dedup();
    for (number, tool) in [[0.0, 0.0, -50.0], [120.0, -80.0, -200.0]].into_iter().enumerate() {
        set.setups.push(setup(&format!("T{number}"), [0.0; 3], 0.0));
        for (target, component) in set.targets.clone().iter().enumerate() {
            let component: ErrorName = component.parse().unwrap();
            let axis = component.axis().unwrap();
            for k in 0..22 {
                let (step, sense) = if k < 11 { (k, 1) } else { (21 - k, -1) };
                let mut position = at(&[('X', 40.0), ('Y', -30.0), ('Z', 20.0)]);
                position[axis] = f64::from(step) * 50.0 - 250.0;
                let mut state = State::default();
                state.direction[axis.slot()] = sense;
                let mut row = observation(reading(position, Vector::from(tool), state), number);
                row.component = Some(component);
                row.target = Some(target);
                set.observations.push(row);
            }
        }
    }
    let mut bench = Bench::new(crate::model::machine("wXFYZSt"), parameters, vec![set], 17);
    let mut random = Random(4);
    let is_angle =
        |which: usize| bench.data[0].targets[which % bench.data[0].targets.len()].starts_with(['A', 'B', 'C']);
    let values: Vec<f64> = (0..bench.unknowns[0].len())
        .map(|which| random.symmetric() * if is_angle(which) { 1e-4 } else { 0.02 })
        .collect();
    bench.unknowns[0] = values;
    bench
}

/// Every motion error of five axes as a cubic, and the backlashes of both rotary axes: 122 parameters.
pub(crate) fn cubic(machine: &Machine) -> Vec<ParameterName> {
    let mut out = Vec::new();
    for axis in AXES.into_iter().filter(|&axis| machine.axis(axis).is_some()) {
        for letter in ["X", "Y", "Z", "A", "B", "C"] {
            out.extend(named(&[0, 1, 2, 3].map(|degree| format!("E{letter}{axis}{degree}")).join(" ")));
        }
    }
    for axis in AXES.into_iter().filter(|&axis| axis.is_rotary() && machine.axis(axis).is_some()) {
        out.extend(named(&format!("E{axis}{axis}b")));
    }
    assert_eq!(out.len(), 122);
    out
}

/// The parameters of a preset.
pub(crate) fn preset(name: &str, machine: &Machine) -> Vec<ParameterName> {
    (ncfix_model::preset::find(name).unwrap().parameters)(machine).unwrap()
}

/// All kinds, with enough readings to tell the parameters.
pub(crate) fn benches() -> Vec<Bench> {
    let thirteen = preset("mayer-13", &crate::model::machine("wCBXFZYSt"));
    vec![plates(), circles(24, &[1.0, -1.0]), samba(thirteen, true), lines()]
}
