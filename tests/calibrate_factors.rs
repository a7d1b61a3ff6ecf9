//! Analytic factors against finite differences of the residuals, by every column.

use ncfix_base::geometry::{AXES, Vector};
use ncfix_machine::machine::{Machine, State};
use ncfix_metrology::calibrate::equations;
use ncfix_metrology::measure::data::{DataSet, Free, KnownLength};
use ncfix_model::name::DIRECTIONS;
use ncfix_model::parameter::{ComponentTerm, ParameterName};
use ncfix_model::{ErrorModel, ErrorName};

use crate::calibrate::{measurement, observation, reading, setup};
use crate::model::{Random, machine};

/// Every location error, and a coefficient of every term of every motion error.
fn parameters(machine: &Machine) -> Vec<ParameterName> {
    let mut out = Vec::new();
    for direction in DIRECTIONS {
        out.push(ParameterName::location(ErrorName::spindle(direction)));
        for axis in AXES.into_iter().filter(|&axis| machine.axis(axis).is_some()) {
            out.push(ParameterName::location(ErrorName::location(direction, axis)));
            let component = ErrorName::motion(direction, axis);
            let degree = 1 + (direction.index() % 3) as u8;
            out.push(ParameterName::coefficient(component, degree));
            out.push(ParameterName::backlash(component));
            out.push(ParameterName { component, term: ComponentTerm::Knot { degree: 2, at: -20 } });
        }
    }
    out
}

/// A measurement of each kind at random poses, all unknowns free.
fn measurements(machine: &Machine, random: &mut Random) -> Vec<DataSet> {
    let kinds: [(&str, &[Free]); 4] = [
        ("displacement", &[Free::Offset, Free::Rotation]),
        ("ballbar", &[Free::Centre, Free::Length]),
        ("probe", &[Free::Tool]),
        ("direct", &[Free::Offset]),
    ];
    let components: Vec<ErrorName> = DIRECTIONS
        .into_iter()
        .flat_map(|direction| {
            let axes = AXES.into_iter().filter(|&axis| machine.axis(axis).is_some());
            axes.map(move |axis| ErrorName::motion(direction, axis))
        })
        .collect();
    kinds
        .into_iter()
        .map(|(kind, free)| {
            let mut set = measurement(kind, free);
            set.setups = vec![setup("A", [10.0, 20.0, -30.0], 150.0), setup("B", [-40.0, 0.0, 90.0], 100.0)];
            set.targets = match kind {
                "probe" => vec!["b1".into(), "b2".into(), "b3".into()],
                "direct" => components.iter().map(ToString::to_string).collect(),
                _ => Vec::new(),
            };
            if kind == "probe" {
                set.lengths.push(KnownLength { between: [0, 2], value_mm: 100.0, sigma_mm: None });
            }
            for (k, &component) in
                components.iter().enumerate().take(if kind == "direct" { components.len() } else { 6 })
            {
                let mut state = State::default();
                state.direction.iter_mut().for_each(|sense| *sense = if random.symmetric() < 0.0 { -1 } else { 1 });
                let tool = Vector::from_fn(|_, _| 150.0 * random.symmetric());
                let mut row = observation(reading(random.command(3.0), tool, state), k % 2);
                row.spindle_rad = random.symmetric();
                match kind {
                    "probe" => row.target = Some(k % 3),
                    "direct" => (row.target, row.component) = (Some(k), Some(component)),
                    _ => {}
                }
                set.observations.push(row);
            }
            set
        })
        .collect()
}

#[test]
fn factors_are_derivatives() {
    let mut modulo = machine("wCBXFZYSt");
    for data in modulo.axes.iter_mut().flatten().filter(|data| data.axis.is_rotary()) {
        data.modulo = true;
    }
    let mut machines: Vec<Machine> =
        ["wCAYFXZSt", "wFXYZCBSt", "wCXFYZBSt", "wXFYZSt"].into_iter().map(machine).collect();
    machines.push(modulo);
    machines.push(crate::model::sample("esmaeili_huron").0);
    for (number, machine) in machines.iter().enumerate() {
        let mut random = Random(number as u64 + 40);
        let parameters = parameters(machine);
        for set in measurements(machine, &mut random) {
            let data = [set];
            let kind = data[0].kind.name;
            let count = (data[0].kind.unknowns)(&data[0]).len();
            // Balls in different places; the rest small, but not zero. Factors have the arms of the tool vector of the row.
            let size = |k: usize| match (kind, k < 9) {
                ("probe", true) => 200.0,
                ("probe", false) => 1e-5,
                _ => 2e-2,
            };
            let unknowns: Vec<f64> = (0..count).map(|k| size(k) * random.symmetric()).collect();
            let at = |errors: &ErrorModel, unknowns: &[f64]| {
                equations(machine, errors, &parameters, &data, Some(unknowns)).1
            };
            let analytic = at(&ErrorModel::default(), &unknowns);
            assert!(analytic.len() >= data[0].observations.len());
            for column in 0..parameters.len() + count {
                let side = |sign: f64, step: f64| {
                    let (mut errors, mut moved) = (ErrorModel::default(), unknowns.clone());
                    match parameters.get(column) {
                        Some(parameter) => parameter.set(&mut errors, sign * step),
                        None => moved[column - parameters.len()] += sign * step,
                    }
                    at(&errors, &moved)
                };
                let largest = analytic.iter().fold(0.0, |most, (_, factors)| f64::max(most, factors[column].abs()));
                // A step that moves readings by up to 2 µm.
                let step = 2e-3 / largest.max(1.0);
                for ((plus, minus), (line, factors)) in side(1.0, step).iter().zip(side(-1.0, step)).zip(&analytic) {
                    let found = -(plus.0.residual - minus.0.residual) / (2.0 * step);
                    let error = (found - factors[column]).abs();
                    let limit = if kind == "displacement" && column >= parameters.len() { 1e-5 } else { 1e-6 };
                    assert!(
                        error < limit * largest.max(1.0),
                        "machine {number}, {kind}, column {column} {:?}: {found} is not {} in {line:?}",
                        parameters.get(column).map(ToString::to_string),
                        factors[column]
                    );
                }
            }
        }
    }
}
