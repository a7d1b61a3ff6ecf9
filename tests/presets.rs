//! Presets: the printed lists on the printed machines, and on other chains no parameter that the others stand for.
//!
//! The rank is found here by finite differences of the forward model and an elimination with pivots, not by the sensitivities and the
//! fixed order of the presets.

use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::{Lever, Machine, State};
use ncfix_model::motion::{EntryFunction, piecewise, polynomial::Polynomial};
use ncfix_model::parameter::ParameterName;
use ncfix_model::preset::{PRESETS, Rest, find, rest};
use ncfix_model::{ErrorModel, LocationError, Model, MotionError};

use crate::model::{Random, machine, sample};

fn names(preset: &str, machine: &Machine) -> Vec<String> {
    let parameters = (find(preset).unwrap().parameters)(machine).unwrap();
    parameters.iter().map(ToString::to_string).collect()
}

/// A list as printed: `EXX1-3` stands for three coefficients.
fn printed(list: &str) -> Vec<String> {
    let mut out = Vec::new();
    for word in list.split_whitespace() {
        match word.split_once('-') {
            Some((first, last)) => {
                let (stem, low) = first.split_at(3);
                for degree in low.parse::<u8>().unwrap()..=last.parse().unwrap() {
                    out.push(format!("{stem}{degree}"));
                }
            }
            None => out.push(word.to_owned()),
        }
    }
    out
}

fn sorted(mut names: Vec<String>) -> Vec<String> {
    names.sort();
    names
}

/// Table 4-3, machine wCBXFZYSt.
const TABLE_4_3: &str = "EA0B EC0B EX0C EA0C EB0C EB0Z EA0Y EC0Y EY0S EX0S EXX1 EYY1 EZZ1";
/// Table 4-2; the first EYB3 (1.53E-02) is EXB3.
const TABLE_4_2: &str = "EXX1-3 EYX2-3 EZX2-3 EAX0-3 EBX1-3 ECX0-3
    EXY0 EXY2-3 EYY0-3 EZY2-3
    EXZ1-3 EYZ2-3 EZZ1-3 EAZ0-3 ECZ0-3
    EXB0-2 EXB3 EYB1-3 EZB1-3 EAB0-3 EBB0-3 EBBb ECB1-3
    EXC1-3 EYC1-3 EZC1-3 EAC1-3 EBC1-3 ECC1-3 ECCb";
/// Table 5-1, machine wCAYFXZSt, without the datum axes in brackets; the gains are those relative to X.
const TABLE_5_1: &str = "EB0A EC0A EY0C EA0C EB0C EC0X EA0Z EB0Z EAAb ECCb EYY1 EZZ1";
/// Appendix 5.13; the second EAY0 … EAY3 are ECY0 … ECY3.
const APPENDIX_5_13: &str = "EXX2-3 EYX1-3 EZX2-3 EAX0-3 EBX0-3
    EXY2-3 EYY1-3 EZY2-3 EAY1-3 EBY0-3 ECY0-3
    EXZ2-3 EYZ2-3 EZZ1-3
    EXA1-3 EYA0-3 EZA1-3 EAA0-3 EAAb EBA0-3 ECA1-3
    EXC1-3 EYC1-3 EZC1-3 EAC1-3 EBC1-3 ECC1-3 ECCb";
/// Table 6-1, the same machine.
const TABLE_6_1: &str = "EB0A EC0A EY0C EA0C EB0C EC0X EA0Z EB0Z EYY1 EZZ1";
/// Table 7-1, machine wCAYFXZSt with A at 45°; EZ0S is printed in a frame turned by −90° about X.
const TABLE_7_1: &str = "EB0A EC0A EY0C EA0C EB0C EC0X EA0Z EB0Z EX0S EY0S EXX1 EYY1 EZZ1";

#[test]
fn printed_machines_have_the_printed_parameters() {
    let horizontal = machine("wCBXFZYSt");
    let kolibri = machine("wCAYFXZSt");
    for (preset, machine, table, count) in [
        ("mayer-13", &horizontal, TABLE_4_3, 13),
        ("84", &horizontal, TABLE_4_2, 84),
        ("12", &kolibri, TABLE_5_1, 12),
        ("81", &kolibri, APPENDIX_5_13, 81),
        ("10", &kolibri, TABLE_6_1, 10),
        ("mayer-13", &sample("esmaeili_huron").0, TABLE_7_1, 13),
        ("mayer-13", &sample("esmaeili_xyz5").0, TABLE_4_3, 13),
        ("84", &sample("esmaeili_xyz5").0, TABLE_4_2, 84),
    ] {
        let expected = printed(table);
        assert_eq!(expected.len(), count, "the table as typed here");
        assert_eq!(sorted(names(preset, machine)), sorted(expected), "{preset}");
    }
}

/// Chains with both rotary axes on the table, both in the head, and one each; linear axes on either side. With how many cubic
/// coefficients there are beyond the printed number.
const CHAINS: [(&str, usize); 14] = [
    ("wCBXFZYSt", 0),
    ("wCAYFXZSt", 0),
    ("wCAFXYZSt", 0),
    ("wBAXFYZSt", 0),
    ("wABFXYZSt", 0),
    ("wCAXYFZSt", 1),
    ("wCAXYZFSt", 3),
    ("wFXYZCBSt", 3),
    ("wXFYZCASt", 3),
    ("wXYFZCBSt", 3),
    ("wXYZFCBSt", 3),
    ("wCFXYZBSt", 3),
    ("wCXFYZBSt", 3),
    ("wBXFYZASt", 3),
];

/// Poses with their senses, reached at random.
fn poses(random: &mut Random) -> Vec<(AxisVector, State)> {
    let mut state = State::default();
    let mut pose = || {
        state.direction.iter_mut().for_each(|sense| *sense = if random.symmetric() < 0.0 { -1 } else { 1 });
        (random.command(1.5), state)
    };
    (0..110).map(|_| pose()).collect()
}

/// Tool along −Z of F, as the spindles of the chains here have it.
fn tool(length_mm: f64) -> Vector {
    Vector::new(0.0, 0.0, -length_mm)
}

/// What each parameter does to the place of the tip in the workpiece, by central differences.
fn effects(machine: &Machine, parameters: &[ParameterName], poses: &[(AxisVector, State)]) -> Vec<Vec<f64>> {
    let effect = |parameter: &ParameterName| {
        let reach: f64 = if parameter.component.axis().is_some_and(|axis| axis.is_rotary()) { 1.5 } else { 300.0 };
        let step = 1e-4 / reach.powi(i32::from(parameter.degree()));
        let [plus, minus] = [step, -step].map(|value| {
            let mut errors = ErrorModel::default();
            parameter.set(&mut errors, value);
            Model::new(machine, &errors)
        });
        let difference = |(command, state): &(AxisVector, State)| {
            let of = |model: &Model| model.tip_error_mm(command, command, &tool(150.0), state);
            (of(&plus) - of(&minus)) / (2.0 * step)
        };
        poses.iter().map(difference).flat_map(|vector| [vector.x, vector.y, vector.z]).collect()
    };
    parameters.iter().map(effect).collect()
}

/// What an unknown place of the workpiece does, an unknown tool length or tool vector, and, with the whole vector, an unknown size.
fn set_up(machine: &Machine, whole: bool, poses: &[(AxisVector, State)]) -> Vec<Vec<f64>> {
    let model = Model::new(machine, &ErrorModel::default());
    let mut columns = vec![Vec::new(); if whole { 10 } else { 7 }];
    for (command, _) in poses {
        let pose = model.nominal(command, &tool(150.0));
        let units = [Vector::x(), Vector::y(), Vector::z()];
        let mut row = units.to_vec();
        row.extend(units.map(|unit| unit.cross(&pose.translation)));
        row.push(pose.rotation * Vector::z());
        row.extend([pose.rotation * Vector::x(), pose.rotation * Vector::y(), pose.translation]);
        for (column, vector) in columns.iter_mut().zip(row) {
            column.extend([vector.x, vector.y, vector.z]);
        }
    }
    columns
}

/// The number of independent columns: the longest remainder is taken out of the others until none is left.
fn rank(mut columns: Vec<Vec<f64>>) -> usize {
    let norm = |column: &Vec<f64>| column.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
    for column in &mut columns {
        let length = norm(column).max(1e-12);
        column.iter_mut().for_each(|entry| *entry /= length);
    }
    let mut rank = 0;
    while let Some(at) = (0..columns.len()).max_by(|&a, &b| norm(&columns[a]).total_cmp(&norm(&columns[b]))) {
        let pivot = columns.swap_remove(at);
        let length = norm(&pivot);
        if length < 1e-6 {
            break;
        }
        rank += 1;
        for column in &mut columns {
            let share: f64 = column.iter().zip(&pivot).map(|(a, b)| a * b).sum::<f64>() / (length * length);
            column.iter_mut().zip(&pivot).for_each(|(entry, pivot)| *entry -= share * pivot);
        }
    }
    rank
}

fn rank_with(machine: &Machine, parameters: &[ParameterName], whole: bool) -> usize {
    let poses = poses(&mut Random(7));
    let mut columns = set_up(machine, whole, &poses);
    columns.extend(effects(machine, parameters, &poses));
    rank(columns)
}

fn parameters(preset: &str, machine: &Machine) -> Vec<ParameterName> {
    (find(preset).unwrap().parameters)(machine).unwrap()
}

/// Every location error that has a name on the machine.
fn every_location_error(machine: &Machine) -> Vec<ParameterName> {
    let carriers = machine.axis_set().iter().map(|axis| axis.to_string()).chain(["S".to_owned()]);
    carriers
        .flat_map(|carrier| ["X", "Y", "Z", "A", "B", "C"].map(|letter| format!("E{letter}0{carrier}").parse().ok()))
        .flatten()
        .collect()
}

#[test]
fn location_models_are_all_that_location_errors_can_do() {
    for (topology, _) in CHAINS {
        let machine = machine(topology);
        let [thirteen, twelve, ten] = ["mayer-13", "12", "10"].map(|preset| parameters(preset, &machine));
        assert_eq!([thirteen.len(), twelve.len(), ten.len()], [13, 12, 10], "{topology}");
        // Nothing twice.
        assert_eq!(rank_with(&machine, &thirteen, false), 13 + 7, "{topology}");
        assert_eq!(rank_with(&machine, &twelve, true), 12 + 10, "{topology}");
        assert_eq!(rank_with(&machine, &ten, true), 10 + 10, "{topology}");
        // Nothing forgotten: all 36 location errors are no more than the eight and, with the tool known, two of the spindle. EC0S turns this spindle about
        // its own axis.
        let all = every_location_error(&machine);
        assert_eq!(all.len(), 36);
        assert_eq!(rank_with(&machine, &all, true), 8 + 10, "{topology}");
        assert_eq!(rank_with(&machine, &all, false), 10 + 7, "{topology}");
        let mut both = all.clone();
        both.extend(&thirteen);
        assert_eq!(rank_with(&machine, &both, false), 13 + 7, "{topology}: the 13 are not those");
        // The third gain and the spindle offsets show only with a length standard and an indexed spindle.
        assert_eq!(rank_with(&machine, &thirteen, true), 10 + 10, "{topology}");
    }
}

#[test]
fn cubic_models_are_all_that_cubic_motion_errors_can_do() {
    for (topology, more) in CHAINS {
        let machine = machine(topology);
        let rotary: Vec<String> =
            machine.axis_set().iter().filter(|axis| axis.is_rotary()).map(|axis| axis.to_string()).collect();
        let mut every: Vec<String> = rotary.iter().map(|axis| format!("E{axis}{axis}b")).collect();
        for axis in machine.axis_set().iter() {
            for letter in ["X", "Y", "Z", "A", "B", "C"] {
                every.extend((0..4).map(|degree| format!("E{letter}{axis}{degree}")));
            }
        }
        let every: Vec<ParameterName> = every.iter().map(|name| name.parse().unwrap()).collect();
        assert_eq!(every.len(), 122);
        for (preset, whole, unknown) in [("84", false, 7), ("81", true, 10)] {
            let parameters = parameters(preset, &machine);
            assert_eq!(rank_with(&machine, &parameters, whole), parameters.len() + unknown, "{topology} {preset}");
            assert_eq!(rank_with(&machine, &every, whole), parameters.len() + unknown, "{topology} {preset}");
            assert_eq!(parameters.len(), preset.parse::<usize>().unwrap() + more, "{topology} {preset}");
        }
    }
}

/// Travel of 200 mm: three knots an axis.
fn three_axes(topology: &str, lever: Lever) -> Machine {
    let mut machine = machine(topology);
    for axis in machine.axes.iter_mut().flatten() {
        axis.travel = Some([-100.0, 100.0]);
        axis.lever = lever;
    }
    machine
}

/// What each parameter does to the tip with these tools, all with each pose.
fn effects_with(
    machine: &Machine,
    tools: &[Vector],
    parameters: &[ParameterName],
    poses: &[(AxisVector, State)],
) -> Vec<Vec<f64>> {
    let of = |parameter: &ParameterName| {
        let mut errors = ErrorModel::default();
        let step = 1e-4 / 100_f64.powi(i32::from(parameter.degree()));
        parameter.set(&mut errors, step);
        let model = Model::new(machine, &errors);
        let error =
            |(command, state): &(AxisVector, State), tool| model.tip_error_mm(command, command, tool, state) / step;
        let each = poses.iter().flat_map(|pose| tools.iter().map(move |tool| error(pose, tool)));
        each.flat_map(|vector| [vector.x, vector.y, vector.z]).collect()
    };
    parameters.iter().map(of).collect()
}

#[test]
fn eighteen_and_twenty_one_functions_say_the_same() {
    let topologies = ["wFXYZSt", "wXFYZSt", "wXYFZSt", "wYXFZSt", "wZFXYSt", "wXYZFSt"];
    for (topology, lever) in topologies.into_iter().flat_map(|name| [(name, Lever::Fixed), (name, Lever::Carried)]) {
        let machine = three_axes(topology, lever);
        let [eighteen, twenty_one] = ["spaan-18", "spaan-21"].map(|preset| parameters(preset, &machine));
        let both = [eighteen.clone(), twenty_one.clone()].concat();
        let components = |parameters: &[ParameterName]| {
            let components: std::collections::BTreeSet<_> =
                parameters.iter().map(|parameter| parameter.component).collect();
            components.len()
        };
        assert_eq!([components(&eighteen), components(&twenty_one)], [18, 21], "{topology}");
        // Two coefficients of 9 rotations and 3 positionings, one of 6 straightnesses, three squarenesses, three knots each.
        assert_eq!([eighteen.len(), twenty_one.len()], [33 + 54; 2], "{topology}");
        let mut poses = poses(&mut Random(3));
        poses.iter_mut().for_each(|(command, _)| command.0 = command.0.map(|value| value / 3.0));
        // With several tool vectors, on a workpiece of known place: all can be told apart.
        let tools = [tool(50.0), tool(250.0), Vector::new(80.0, 0.0, -100.0), Vector::new(0.0, 90.0, -100.0)];
        let rank_of = |parameters: &[ParameterName]| rank(effects_with(&machine, &tools, parameters, &poses));
        assert_eq!([rank_of(&eighteen), rank_of(&twenty_one)], [87; 2], "{topology} {lever:?}");
        if lever == Lever::Fixed {
            assert_eq!(rank_of(&both), 87, "{topology}: together they say more than each");
        }
        // With one tool and a workpiece of unknown place what the models differ by does not show.
        let with_set_up = |parameters: &[ParameterName]| {
            let mut columns = set_up(&machine, false, &poses);
            columns.extend(effects_with(&machine, &[tool(150.0)], parameters, &poses));
            rank(columns)
        };
        let each = with_set_up(&twenty_one);
        assert_eq!([with_set_up(&eighteen), with_set_up(&both)], [each; 2], "{topology} {lever:?}");
    }
}

#[test]
fn squareness_of_spaan_is_in_the_rotation_that_he_names() {
    // Ch. 6: xsy is considered by yrz on a machine X-Y-Z.
    let beside = |lever| {
        let machine = three_axes("wFXYZSt", lever);
        let [eighteen, twenty_one] = ["spaan-18", "spaan-21"].map(|preset| names(preset, &machine));
        assert!(eighteen.contains(&"ECY2@-50".to_owned()) && eighteen.contains(&"EXX1".to_owned()), "{eighteen:?}");
        assert_eq!(twenty_one[84..], ["EC0Y", "EA0Z", "EB0Z"]);
        eighteen.into_iter().filter(|name| !twenty_one.contains(name)).collect::<Vec<_>>()
    };
    assert_eq!(beside(Lever::Fixed), ["ECY0", "EAZ0", "EBZ0"]);
    assert_eq!(beside(Lever::Carried), ["EXY1", "EXZ1", "EYZ1"]);
}

#[test]
fn unsuitable_machines_are_told_why() {
    for (preset, topology, reason) in [
        ("mayer-13", "wXFYZSt", "two rotary axes, and this one has none"),
        ("84", "wCXFYZSt", "two rotary axes, and this one has C"),
        ("10", "wCBAFXYZSt", "two rotary axes, and this one has C, B, A"),
        ("81", "wCAYFXSt", "three linear axes, and this one has Y, X"),
        ("spaan-21", "wFXZSt", "three linear axes, and this one has X, Z"),
        ("spaan-18", "wFXYZWSt", "three linear axes, and this one has X, Y, Z, W"),
        ("12", "wCAFXYZSt", "not parallel, and C, A are"),
    ] {
        let mut machine = machine(topology);
        if preset == "12" {
            let direction = Vector::z();
            machine
                .axes
                .iter_mut()
                .flatten()
                .filter(|axis| axis.axis.is_rotary())
                .for_each(|axis| axis.direction = direction);
        }
        let refused = (find(preset).unwrap().parameters)(&machine).unwrap_err();
        assert!(refused.to_string().contains(reason), "{preset} {topology}: {refused}");
    }
    for preset in PRESETS {
        let suits = (preset.parameters)(&machine("wCAFXYZSt")).is_ok();
        assert!(suits, "{} has a machine", preset.name);
    }
}

#[test]
fn a_parameter_is_the_sum_of_its_entries_and_writing_keeps_the_rest() {
    let (machine, mut errors) = crate::model::read(
        "[machine]\nname = \"m\"\ntopology = \"wFXBSt\"\n\
         [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n[axis.B]\ndirection = [0, 1, 0]\ntravel_deg = [0, 90]\n\
         [location]\nEX0S = -2.5\n\
         [[motion]]\ncomponent = \"EXX\"\nkind = \"table\"\npositions_mm = [0, 700]\nvalues_um = [0, 7]\n\
         [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-5, 2e-8]\n\
         [[motion]]\ncomponent = \"EXX\"\nkind = \"piecewise\"\ncoefficients = [0, 4e-5]\n\
         knots = [{ at_mm = 100, coefficients = [0, 0, 3e-8] }]\n\
         [[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 6.0\n\
         [[motion]]\ncomponent = \"EAB\"\nkind = \"piecewise\"\ncoefficients = [0]\n\
         knots = [{ at_deg = 30, coefficients = [0, 5e-6] }]\n",
    );
    let before = errors.clone();
    let name = |text: &str| text.parse::<ParameterName>().unwrap();
    // µm and µrad of the file are mm and rad; a backlash counts by its half.
    for (text, value) in [
        ("EX0S", -2.5e-3),
        ("EXX1", 5e-5),
        ("EXX2", 2e-8),
        ("EXX3", 0.0),
        ("EXXb", 3e-3),
        ("EXX2@100", 3e-8),
        ("EXX2@150", 0.0),
        ("EAB1@30", 5e-6),
        ("EY0S", 0.0),
        ("EBBb", 0.0),
    ] {
        assert!((name(text).get(&errors) - value).abs() < 1e-15, "{text}: {}", name(text).get(&errors));
    }
    // What is set is read back, with the weight that the parameter says, and nothing else changes.
    let commands = [(120.0, 0.2, 1), (420.0, 1.1, -1)].map(|(x, b, sense)| {
        let mut command = AxisVector::ZERO;
        (command.0[0], command.0[7]) = (x, b);
        let mut state = State::default();
        state.direction.fill(sense);
        (command, state)
    });
    let value_of = |errors: &ErrorModel, parameter: &ParameterName, command: &AxisVector, state: &State| -> f64 {
        let location =
            errors.location.iter().filter(|error| error.name == parameter.component).map(|error| error.value);
        let motion = errors.motion.iter().filter(|error| error.name == parameter.component);
        let axis = parameter.component.axis().unwrap_or(ncfix_base::geometry::Axis::X);
        location.sum::<f64>() + motion.map(|error| error.function.value(axis, command, state)).sum::<f64>()
    };
    let sizes = [
        ("EX0S", 1e-3),
        ("EY0S", 2e-3),
        ("EXX1", -1e-5),
        ("EXX3", 1e-11),
        ("EXXb", -4e-3),
        ("EXX2@100", 1e-8),
        ("EXX2@50", 2e-8),
        ("EAB1@30", 1e-6),
        ("EAB2@10", 3e-6),
        ("EBBb", 1e-5),
        ("EBB2", 1e-5),
        ("EYB2@45", 1e-3),
    ];
    for (text, value) in sizes {
        let parameter = name(text);
        let before = errors.clone();
        let change = value - parameter.get(&errors);
        parameter.set(&mut errors, value);
        assert!((parameter.get(&errors) - value).abs() < 1e-15, "{text}");
        for (command, state) in &commands {
            let difference =
                value_of(&errors, &parameter, command, state) - value_of(&before, &parameter, command, state);
            assert!((difference - change * parameter.weight(command, state)).abs() < 1e-14, "{text}");
        }
    }
    for (text, value) in sizes {
        assert!((name(text).get(&errors) - value).abs() < 1e-15, "{text} was changed by another");
    }
    // Entries are used again: only what had none was added (EY0S; EBBb, EBB2, EYB2@45).
    assert_eq!(errors.location.len(), before.location.len() + 1);
    assert_eq!(errors.motion.len(), before.motion.len() + 3);
    assert_eq!(machine.name, "m");
}

#[test]
fn what_a_model_has_beside_given_parameters_is_listed() {
    let knot = |at: f64, coefficients: &[f64]| piecewise::Knot { at, coefficients: coefficients.to_vec() };
    let motion = |component: &str, function| MotionError { name: component.parse().unwrap(), function };
    let splines = piecewise::Piecewise {
        coefficients: vec![0.0, 3e-6],
        knots: vec![knot(150.0, &[0.0, 0.0, 1e-8]), knot(150.5, &[0.0, 1e-6]), knot(2_147_483_647.0, &[0.0, 1e-6])],
    };
    let turns =
        piecewise::Piecewise { coefficients: Vec::new(), knots: vec![knot(f64::to_radians(90.0), &[0.0, 1e-5])] };
    let errors = ErrorModel {
        location: [("EC0Y", 20e-6), ("EX0C", 0.01), ("EB0Z", 0.0)]
            .map(|(name, value)| LocationError { name: name.parse().unwrap(), value })
            .to_vec(),
        motion: vec![
            motion("EXX", EntryFunction::Polynomial(Polynomial { coefficients: vec![0.0, 1e-5] })),
            motion("EYY", EntryFunction::Piecewise(splines)),
            motion("ECC", EntryFunction::Piecewise(turns)),
        ],
        ..ErrorModel::default()
    };
    let given: Vec<ParameterName> = ["EX0C", "EYY1"].iter().map(|name| name.parse().unwrap()).collect();
    let mut found: Vec<String> = rest(&errors, &given)
        .into_iter()
        .map(|rest| match rest {
            Rest::Parameter(name) => name.to_string(),
            Rest::Function(name, kind) => format!("{kind} {name}"),
            Rest::Source(title) => title.to_owned(),
        })
        .collect();
    found.sort();
    // The knot at 150.5 mm has no name. What is zero is no error.
    assert_eq!(found, ["EC0Y", "ECC1@90", "EXX1", "EYY1@2147483647", "EYY2@150", "piecewise EYY"]);
}
