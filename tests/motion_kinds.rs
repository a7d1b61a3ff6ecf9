//! Every kind of motion error, by the example that it gives: read, zero, scaled, in other units, on a mirrored axis, and its kinks.

use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_machine::machine::{Machine, State};
use ncfix_model::motion::{
    EntryFunction, MotionKind, MotionKinds, backlash, cross, dynamic, grid, periodic, piecewise, polynomial, table,
};
use ncfix_model::{ErrorModel, Model, MotionError};

use crate::machine_file::load;
use crate::model::Random;
use crate::support::repository;

/// Y and C on the side of the workpiece, X and Z on that of the tool.
const MACHINE: &str = "[machine]\nname = \"test\"\ntopology = \"wCYFXZSt\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-400, 800]\n\
    [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-400, 800]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-400, 800]\n\
    [axis.C]\ndirection = [0, 0, -1]\npoint_mm = [30, -20, 0]\ntravel_deg = [-360, 360]\n";

/// The machine with one entry.
fn read(entry: &str) -> (Machine, MotionError) {
    let (result, mut findings) = load(&format!("{MACHINE}[[motion]]\n{entry}"));
    // The random numbers of the kinds are no errors of a real machine.
    findings.retain(|found| found.code.as_str() != "W0408");
    assert!(findings.is_empty(), "{entry}\n{findings:#?}");
    let (machine, ErrorModel { motion, .. }) = result.unwrap();
    let [error] = <[MotionError; 1]>::try_from(motion).unwrap();
    (machine, error)
}

/// The entry with its deviations, as its keys tell, replaced.
fn with_deviations(kind: &dyn MotionKind, change: &dyn Fn(f64) -> f64) -> String {
    fn walk(value: &mut toml::Value, change: &dyn Fn(f64) -> f64) {
        match value {
            toml::Value::Float(number) => *number = change(*number),
            toml::Value::Integer(number) => *value = toml::Value::Float(change(*number as f64)),
            toml::Value::Array(items) => items.iter_mut().for_each(|item| walk(item, change)),
            toml::Value::Table(table) => walk_table(table, change),
            _ => {}
        }
    }
    fn walk_table(table: &mut toml::Table, change: &dyn Fn(f64) -> f64) {
        for (key, value) in table.iter_mut() {
            let is_deviation = key == "coefficients" || key.ends_with("_um") || key.ends_with("_urad");
            if is_deviation || key == "knots" {
                walk(value, change);
            }
        }
    }
    let mut table: toml::Table = kind.example().parse().unwrap();
    // A knot is an inline table, whose deviations are its coefficients.
    if let Some(toml::Value::Array(knots)) = table.remove("knots") {
        let knots = knots.into_iter().map(|mut knot| {
            walk_table(knot.as_table_mut().unwrap(), change);
            knot
        });
        let knots = toml::Value::Array(knots.collect());
        walk_table(&mut table, change);
        table.insert("knots".to_owned(), knots);
    } else {
        walk_table(&mut table, change);
    }
    text_of(&table)
}

/// An entry as text, tables in its values inline.
fn text_of(entry: &toml::Table) -> String {
    entry.iter().map(|(key, value)| format!("{key} = {value}\n")).collect()
}

/// Commands all over the travel and beyond, and a sense for each axis.
fn places(seed: u64) -> impl Iterator<Item = (AxisVector, State)> {
    let mut random = Random(seed);
    (0..200).map(move |_| {
        let command =
            AxisVector(AXES.map(|axis| {
                if axis.is_rotary() { 7.0 * random.symmetric() } else { 300.0 + 700.0 * random.symmetric() }
            }));
        let direction = AXES.map(|_| (random.symmetric() * 1.5).round() as i8);
        (command, State { direction, ..State::default() })
    })
}

fn value(error: &MotionError, command: &AxisVector, state: &State) -> f64 {
    error.function.value(error.name.axis().unwrap(), command, state)
}

fn model_of(machine: &Machine, error: &MotionError) -> Model {
    Model::new(machine, &ErrorModel { motion: vec![error.clone()], ..ErrorModel::default() })
}

#[test]
fn every_example_is_read_and_documented() {
    let text = std::fs::read_to_string(repository("docs/reference/motion.md")).unwrap();
    for kind in MotionKinds::default().iter() {
        let (machine, error) = read(kind.example());
        assert!(kind.example().contains(&format!("kind = \"{}\"", kind.name())));
        assert!(places(1).any(|(command, state)| value(&error, &command, &state) != 0.0), "{}", kind.name());
        assert!(!model_of(&machine, &error).is_empty());
        let block = format!("```toml\n[[motion]]\n{}```", kind.example());
        assert!(text.contains(&block), "docs/reference/motion.md lacks\n{block}");
    }
}

/// What the examples give, computed by hand: own command, other command (X), sense, mm or rad.
#[test]
fn the_examples_mean_what_their_formulas_say() {
    let cases = [
        // −3.13e−4 · 100 + 7.53e−8 · 100² + 1.35e−10 · 100³
        ("polynomial", 100.0, 0.0, 0, -0.030_412),
        ("table", 525.0, 0.0, 0, 1.5e-3),
        // 1e−5 · 150 + 2e−8 · 150² + 3e−8 · 50²
        ("piecewise", 150.0, 0.0, 0, 2.025e-3),
        // 60° + 30°
        ("periodic", 5.0 / 3.0, 0.0, 0, 1.5e-3),
        ("backlash", 350.0, 0.0, -1, 2.5e-3),
        ("backlash", 700.0, 0.0, 1, -2e-3),
        ("cross", 200.0, 50.0, 0, 1e-5),
        // Halfway between the means of the rows, 1 and 4.5 µrad.
        ("grid", 125.0, 350.0, 0, 2.75e-6),
    ];
    for kind in MotionKinds::default().iter() {
        let (_, error) = read(kind.example());
        let axis = error.name.axis().unwrap();
        let mut of_kind = cases.iter().filter(|case| case.0 == kind.name()).peekable();
        assert!(of_kind.peek().is_some(), "no case of {}", kind.name());
        for &(_, own, other, sense, expected) in of_kind {
            let mut command = AxisVector::ZERO;
            command[Axis::X] = other;
            command[axis] = own;
            let mut state = State::default();
            state.direction[axis.slot()] = sense;
            assert!((value(&error, &command, &state) - expected).abs() < 1e-15, "{} at {own}", kind.name());
        }
    }
}

#[test]
fn zero_parameters_are_zero_error() {
    for kind in MotionKinds::default().iter() {
        let (machine, error) = read(&with_deviations(kind, &|_| 0.0));
        let model = model_of(&machine, &error);
        assert!(error.function.is_zero() && model.is_empty(), "{}", kind.name());
        for (command, state) in places(2) {
            assert_eq!(value(&error, &command, &state), 0.0);
            let tool = Vector::new(5.0, -8.0, -120.0);
            assert_eq!(model.actual(&command, &tool, &state), model.nominal(&command, &tool));
        }
        for axis in AXES {
            let features = model.features(axis);
            assert!(features.knots.is_empty() && !features.backlash, "{}: nothing to look at", kind.name());
        }
    }
}

#[test]
fn the_error_grows_with_its_parameters() {
    for kind in MotionKinds::default().iter() {
        let (_, once) = read(kind.example());
        let (_, thrice) = read(&with_deviations(kind, &|number| -3.0 * number));
        for (command, state) in places(3) {
            let expected = -3.0 * value(&once, &command, &state);
            let found = value(&thrice, &command, &state);
            assert!((found - expected).abs() <= 1e-14 * expected.abs().max(1e-3), "{}: {found}", kind.name());
        }
    }
}

/// As a rotation the deviations are µrad and as a displacement µm: 1e−6 rad and 1e−3 mm. Coefficients are mm and rad themselves.
#[test]
fn deviations_are_micrometers_and_microradians() {
    for kind in MotionKinds::default().iter() {
        let (_, error) = read(kind.example());
        let name = error.name.to_string();
        let (from, to, other) = match error.name.direction.is_rotation() {
            true => ("_urad", "_um", format!("EY{}", &name[2..])),
            false => ("_um", "_urad", format!("EB{}", &name[2..])),
        };
        let (_, renamed) = read(&kind.example().replace(&name, &other).replace(from, to));
        let is_scaled = kind.example().contains(from);
        assert!(is_scaled || kind.example().contains("coefficients"), "{}: which unit?", kind.name());
        let factor = match (is_scaled, from) {
            (false, _) => 1.0,
            (true, "_um") => 1e-3,
            (true, _) => 1e3,
        };
        for (command, state) in places(4) {
            let (a, b) = (value(&error, &command, &state) * factor, value(&renamed, &command, &state));
            assert!((a - b).abs() <= 1e-13 * a.abs().max(1e-6), "{}: {a} {b}", kind.name());
        }
    }
}

/// The example on C with its positions written in degrees is the same function of radians.
#[test]
fn positions_are_millimeters_and_degrees() {
    for kind in MotionKinds::default().iter() {
        let (_, linear) = read(kind.example());
        let own = linear.name.axis().unwrap();
        let mut entry: toml::Table = kind.example().parse().unwrap();
        to_degrees(&mut entry);
        let name = linear.name.to_string();
        entry["component"] = toml::Value::String(format!("{}C", &name[..2]));
        let (_, rotary) = read(&text_of(&entry));
        for (command, state) in places(5) {
            let mut turned = command;
            turned[Axis::C] = command[own];
            let mut state_c = state;
            state_c.direction[Axis::C.slot()] = state.direction(own);
            let (a, b) = (value(&linear, &command, &state), value(&rotary, &turned, &state_c));
            assert!((a - b).abs() <= 1e-11 * a.abs().max(1e-3), "{}: {a} {b}", kind.name());
        }
    }
}

/// Renames and converts the keys of the own positions.
fn to_degrees(entry: &mut toml::Table) {
    fn scale(value: &mut toml::Value) {
        match value {
            toml::Value::Array(items) => items.iter_mut().for_each(scale),
            toml::Value::Float(number) => *number = number.to_degrees(),
            toml::Value::Integer(number) => *value = toml::Value::Float((*number as f64).to_degrees()),
            _ => {}
        }
    }
    let keys: Vec<String> = entry.keys().cloned().collect();
    for key in keys {
        if let Some(stem) = key.strip_suffix("_mm").filter(|stem| !stem.starts_with("with_")) {
            let mut value = entry.remove(&key).unwrap();
            scale(&mut value);
            entry.insert(format!("{stem}_deg"), value);
        } else if let toml::Value::Array(items) = &mut entry[&key] {
            items.iter_mut().filter_map(toml::Value::as_table_mut).for_each(to_degrees);
        }
    }
}

/// The function of an axis whose commands have the other sign.
fn mirrored(function: &EntryFunction) -> EntryFunction {
    let reversed = |values: &[f64]| values.iter().rev().copied().collect::<Vec<_>>();
    let negated = |values: &[f64]| values.iter().rev().map(|value| -value).collect::<Vec<_>>();
    match function {
        EntryFunction::Polynomial(p) => {
            EntryFunction::Polynomial(polynomial::Polynomial { coefficients: odd_negated(&p.coefficients) })
        }
        EntryFunction::Table(t) => {
            EntryFunction::Table(table::ErrorTable { positions: negated(&t.positions), values: reversed(&t.values) })
        }
        EntryFunction::Piecewise(p) => {
            // (−q − t)₊ʲ = (−1)ʲ (q + t)ʲ − (−1)ʲ (q + t)₊ʲ: everywhere, less what is beyond −t.
            let mut coefficients = odd_negated(&p.coefficients);
            let mut knots = Vec::new();
            for knot in p.knots.iter().rev() {
                let powers = odd_negated(&knot.coefficients);
                coefficients.resize(coefficients.len().max(powers.len()), 0.0);
                for (power, factor) in powers.iter().enumerate() {
                    let mut binomial = 1.0;
                    for (k, coefficient) in coefficients.iter_mut().enumerate().take(power + 1) {
                        *coefficient += factor * binomial * knot.at.powi((power - k) as i32);
                        binomial *= (power - k) as f64 / (k + 1) as f64;
                    }
                }
                knots.push(piecewise::Knot { at: -knot.at, coefficients: powers.iter().map(|c| -c).collect() });
            }
            EntryFunction::Piecewise(piecewise::Piecewise { coefficients, knots })
        }
        EntryFunction::Periodic(p) => {
            // sin(−x + φ) = −sin(x − φ)
            EntryFunction::Periodic(periodic::Periodic { amplitude: -p.amplitude, phase_rad: -p.phase_rad, ..*p })
        }
        // Behind a positive motion the mirrored axis stands as behind a negative one.
        EntryFunction::Backlash(b) => EntryFunction::Backlash(backlash::Backlash {
            reversal: table::ErrorTable {
                positions: negated(&b.reversal.positions),
                values: negated(&b.reversal.values),
            },
        }),
        EntryFunction::Cross(c) => {
            EntryFunction::Cross(cross::Cross { coefficients: odd_negated(&c.coefficients), ..c.clone() })
        }
        EntryFunction::Grid(g) => EntryFunction::Grid(grid::ErrorGrid {
            positions: negated(&g.positions),
            values: g.values.iter().rev().cloned().collect(),
            ..g.clone()
        }),
        // The same acceleration of the body has the other sign.
        EntryFunction::Dynamic(d) => {
            EntryFunction::Dynamic(dynamic::Dynamic { by_acceleration: -d.by_acceleration, by_jerk: -d.by_jerk })
        }
        other => panic!("no mirrored {other:?}"),
    }
}

fn odd_negated(coefficients: &[f64]) -> Vec<f64> {
    coefficients.iter().enumerate().map(|(power, c)| if power % 2 == 1 { -c } else { *c }).collect()
}

/// The function of the same axis where the other axis that it depends on has the other sign; `None` where there is none.
fn mirrored_across(function: &EntryFunction) -> Option<(Axis, EntryFunction)> {
    match function {
        EntryFunction::Cross(c) => {
            let with_coefficients = odd_negated(&c.with_coefficients);
            Some((c.with, EntryFunction::Cross(cross::Cross { with_coefficients, ..c.clone() })))
        }
        EntryFunction::Grid(g) => {
            let with_positions = g.with_positions.iter().rev().map(|position| -position).collect();
            let values = g.values.iter().map(|row| row.iter().rev().copied().collect()).collect();
            Some((g.with, EntryFunction::Grid(grid::ErrorGrid { with_positions, values, ..g.clone() })))
        }
        _ => None,
    }
}

#[test]
fn a_mirrored_axis_moves_the_tool_alike() {
    let mut across = 0;
    for kind in MotionKinds::default().iter() {
        let (_, linear) = read(kind.example());
        // Also as a function of the rotary axis, whose commands are radians.
        let rotary =
            MotionError { name: format!("E{}C", &linear.name.to_string()[1..2]).parse().unwrap(), ..linear.clone() };
        for error in [linear, rotary] {
            let own = error.name.axis().unwrap();
            let turned = MotionError { function: mirrored(&error.function), ..error.clone() };
            agree_mirrored(kind, own, &error, &turned);
            if let Some((other, function)) = mirrored_across(&error.function) {
                across += 1;
                agree_mirrored(kind, other, &error, &MotionError { function, ..error.clone() });
            }
        }
    }
    assert_eq!(across, 4);
}

/// The deviation of the tool on a machine whose axis points and counts the other way.
fn agree_mirrored(kind: &dyn MotionKind, axis: Axis, error: &MotionError, mirrored: &MotionError) {
    let (machine, _) = read(kind.example());
    let mut opposite = machine.clone();
    opposite.axes[axis.slot()].as_mut().unwrap().direction *= -1.0;
    let (plain, opposite) = (model_of(&machine, error), model_of(&opposite, mirrored));
    let tool = Vector::new(5.0, -8.0, -120.0);
    for (command, state) in places(6) {
        let (mut turned, mut turned_state) = (command, state);
        turned[axis] *= -1.0;
        turned_state.direction[axis.slot()] *= -1;
        let (a, b) = (plain.actual(&command, &tool, &state), opposite.actual(&turned, &tool, &turned_state));
        let off = (a.translation - b.translation).norm() + 100.0 * (a.rotation - b.rotation).norm();
        assert!(off < 1e-9, "{} {} along {axis}: {off} mm", kind.name(), error.name);
    }
}

/// Places between −400 and 800 at which the slope of a function jumps: where the change of the slope between two neighbouring steps stays when
/// the steps become smaller.
fn kinks(function: impl Fn(f64) -> f64) -> Vec<f64> {
    const STEP: f64 = 0.37;
    const FINER: f64 = 50.0;
    let slope_change = |at: f64, step: f64| (function(at - step) - 2.0 * function(at) + function(at + step)) / step;
    let mut found: Vec<f64> = Vec::new();
    let mut at = -400.1;
    while at < 800.0 {
        at += STEP;
        let coarse = [-STEP, 0.0, STEP].map(|off| slope_change(at + off, STEP).abs()).into_iter().fold(0.0, f64::max);
        if coarse < 1e-10 {
            continue;
        }
        let fine = (-50..=50)
            .map(|k| at + f64::from(k) * STEP / FINER)
            .max_by(|a, b| slope_change(*a, STEP / FINER).abs().total_cmp(&slope_change(*b, STEP / FINER).abs()));
        let fine = fine.unwrap();
        if slope_change(fine, STEP / FINER).abs() > 0.4 * coarse && found.last().is_none_or(|last| fine - last > STEP) {
            found.push(fine);
        }
    }
    found
}

#[test]
fn kinks_are_declared_where_the_slope_jumps() {
    let kinds = MotionKinds::default();
    let mut entries: Vec<&str> = kinds.iter().map(|kind| kind.example()).collect();
    // Slopes and values that jump at a knot, and a table of one point, which has no kink.
    entries.push(
        "component = \"EXX\"\nkind = \"piecewise\"\ncoefficients = [0, 1e-5]\n\
         knots = [{ at_mm = 120.5, coefficients = [0, 2e-5] }, { at_mm = 300, coefficients = [4e-3] }]\n",
    );
    entries.push("component = \"EXX\"\nkind = \"table\"\npositions_mm = [3]\nvalues_um = [7]\n");
    let mut found_by_entry = Vec::new();
    for entry in entries {
        let (machine, error) = read(entry);
        let model = model_of(&machine, &error);
        let own = error.name.axis().unwrap();
        let mut count = 0;
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let declared = &model.features(axis).knots;
            assert!(declared.windows(2).all(|pair| pair[0] < pair[1]));
            for sense in [-1, 0, 1] {
                let mut state = State::default();
                state.direction[own.slot()] = sense;
                let along = |at: f64| {
                    let mut command = AxisVector([111.0, 137.0, 77.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                    command[axis] = at;
                    value(&error, &command, &state)
                };
                let found = kinks(along);
                count += found.len();
                for kink in found {
                    assert!(declared.iter().any(|knot| (knot - kink).abs() < 0.5), "{kink} of {axis} in\n{entry}");
                }
            }
        }
        found_by_entry.push(count);
        let depends = value(&error, &AxisVector::ZERO, &State { direction: [1; 9], ..State::default() })
            != value(&error, &AxisVector::ZERO, &State { direction: [-1; 9], ..State::default() });
        assert_eq!(model.features(own).backlash, depends, "{entry}");
    }
    // Three senses each. Table: 0, 350 and 700. Backlash: both ends, not at rest. Grid: 0, 250, 500 of Y, 0 and 700 of X. Then 120.5 and 300.
    assert_eq!(found_by_entry, [0, 9, 0, 0, 4, 0, 15, 6, 0]);
}

#[test]
fn an_eighth_of_the_length_is_a_fine_step() {
    for kind in MotionKinds::default().iter() {
        let (machine, error) = read(kind.example());
        let model = model_of(&machine, &error);
        for axis in [Axis::X, Axis::Y] {
            let along = |at: f64| {
                let mut command = AxisVector([350.0, 125.0, 77.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                command[axis] = at;
                value(&error, &command, &State { direction: [1; 9], ..State::default() })
            };
            let step = model.features(axis).length / 8.0;
            let range = (0..=700).map(|at| along(f64::from(at)).abs()).fold(0.0, f64::max);
            let mut at = 0.0;
            while at + step < 700.0 {
                let is_smooth = !model.features(axis).knots.iter().any(|knot| (at..=at + step).contains(knot));
                let bend = (along(at + step / 2.0) - (along(at) + along(at + step)) / 2.0).abs();
                assert!(!is_smooth || bend <= 0.03 * range, "{} of {axis} at {at}: {bend} of {range}", kind.name());
                at += step;
            }
        }
    }
}

#[test]
fn a_wave_that_no_correction_can_follow_is_refused() {
    for (period, is_read) in [("0.0009", false), ("0.0001", false), ("0.001", true), ("0.002", true)] {
        let entry = format!("component = \"EXX\"\nkind = \"periodic\"\nperiod_mm = {period}\namplitude_um = 1.5\n");
        let (loaded, findings) = load(&format!("{MACHINE}[[motion]]\n{entry}"));
        assert_eq!((loaded.is_some(), findings.is_empty()), (is_read, is_read), "{period}: {findings:?}");
    }
}
