//! Every error source in the registry: its example is read, contributes, follows its parameters, and gives the same error if the direction of an axis is reversed.

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Condition, Load, Machine, State};
use ncfix_model::name::{DIRECTIONS, ErrorName};
use ncfix_model::{Accumulator, ErrorModel, Model, SourceInfo, Sources, Twist, write};

/// A machine with a swiveling rotary table; `sense` is −1 where X counts the other way.
fn text(sense: i32, errors: &str) -> String {
    let travel = if sense > 0 { "[-50, 700]" } else { "[-700, 50]" };
    format!(
        "[machine]\nname = \"test\"\ntopology = \"wCAYFXZSt\"\n[axis.X]\ndirection = [{sense}, 0, 0]\ntravel_mm = {travel}\n\
         [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 500]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-400, 0]\n\
         [axis.A]\ndirection = [-1, 0, 0]\npoint_mm = [250, -200, -300]\ntravel_deg = [-100, 100]\n\
         [axis.C]\ndirection = [0, 0, -1]\npoint_mm = [250, -200, -300]\ntravel_deg = [-360, 360]\n{errors}"
    )
}

#[track_caller]
fn load(sense: i32, errors: &str) -> (Machine, ErrorModel) {
    let source = Source::new(FileId(0), "test.toml", text(sense, errors).into_bytes()).unwrap();
    let (loaded, findings) = ncfix_model::file::load(&source);
    // All sources together have two models of the drift.
    assert!(findings.iter().all(|finding| finding.code.as_str() == "W0402"), "{errors}\n{findings:?}");
    loaded.unwrap()
}

/// Warm sensors, each differently, and a workpiece off the center.
fn condition(errors: &ErrorModel) -> Condition {
    let mut condition = Condition::default();
    for (k, sensor) in errors.sensors().into_iter().enumerate() {
        condition.add_reading(sensor, 0.0, 22.0 + 1.3 * k as f64);
    }
    condition.add_load(Load { force_n: 2300.0, position_mm: Vector::new(40.0, 10.0, -120.0) });
    condition
}

const TOOL: Vector = Vector::new(3.0, -2.0, -110.0);

/// Poses with the sense of the last motion; `sense` turns X around.
fn poses(sense: i32) -> Vec<(AxisVector, State)> {
    let mut poses = Vec::new();
    for (x, y, z, a, c, way) in [
        (30.0, 40.0, -20.0, 0.0, 0.0, 1),
        (555.5, 120.0, -333.0, -31.0, 77.0, -1),
        (340.0, 499.0, -210.0, 64.0, -140.0, 1),
        (660.0, 3.0, -5.0, 12.0, 301.0, -1),
    ] {
        let mut command = AxisVector([x, y, z, 0.0, 0.0, 0.0, f64::to_radians(a), 0.0, f64::to_radians(c)]);
        command[Axis::X] *= f64::from(sense);
        let mut state = State { direction: [way; 9], ..State::default() };
        state.direction[Axis::X.slot()] *= sense as i8;
        // 2.5 m/s², 40 m/s³.
        state.acceleration = AxisVector([2500.0 * f64::from(way); 9]);
        state.jerk = AxisVector([40_000.0; 9]);
        state.acceleration[Axis::X] *= f64::from(sense);
        state.jerk[Axis::X] *= f64::from(sense);
        poses.push((command, state));
    }
    poses
}

fn deviations(machine: &Machine, errors: &ErrorModel, condition: &Condition, sense: i32) -> Vec<Twist> {
    let model = Model::at(machine, errors, condition);
    poses(sense).iter().map(|(command, state)| model.deviation(command, &TOOL, state)).collect()
}

/// Distance of two deviations: mm, and rad at an arm of 100 mm.
fn apart(a: &Twist, b: &Twist) -> f64 {
    (a.translation - b.translation).norm() + 100.0 * (a.rotation - b.rotation).norm()
}

const NOTHING: Twist = Twist { translation: Vector::new(0.0, 0.0, 0.0), rotation: Vector::new(0.0, 0.0, 0.0) };

fn largest(all: &[Twist]) -> f64 {
    all.iter().map(|one| apart(one, &NOTHING)).fold(0.0, f64::max)
}

/// Changes every parameter that the error is proportional to.
fn change_linear(errors: &mut ErrorModel, mut change: impl FnMut(usize, &mut f64)) -> usize {
    let mut count = 0;
    for effect in errors.effects_mut() {
        effect.visit_parameters(&mut |parameter, value| {
            if parameter.is_linear {
                change(count, value);
                count += 1;
            }
        });
    }
    count
}

/// All that are built in.
fn built_in() -> Vec<&'static SourceInfo> {
    Sources::default().iter().map(|source| source.info()).collect()
}

fn each(check: impl Fn(&'static SourceInfo, &Machine, &ErrorModel, &Condition)) {
    for source in built_in() {
        let (machine, errors) = load(1, source.example);
        let condition = condition(&errors);
        check(source, &machine, &errors, &condition);
    }
}

#[test]
fn every_example_is_read_and_does_something() {
    each(|source, machine, errors, condition| {
        assert!(errors.effects().all(|effect| effect.source().name == source.name), "{}", source.name);
        assert!(errors.effects().count() > 0, "{}", source.name);
        let found = largest(&deviations(machine, errors, condition, 1));
        assert!((1e-4..0.5).contains(&found), "{}: {found} mm", source.name);
        assert!(
            source.sections.iter().all(|section| source.example.contains(&format!("[{section}"))),
            "{}",
            source.name
        );
    });
}

#[test]
fn zero_parameters_are_no_error() {
    each(|source, machine, errors, condition| {
        let mut errors = errors.clone();
        assert!(change_linear(&mut errors, |_, value| *value = 0.0) > 0, "{}", source.name);
        assert!(deviations(machine, &errors, condition, 1).iter().all(|found| *found == NOTHING), "{}", source.name);
    });
}

#[test]
fn half_the_parameters_are_half_the_error() {
    each(|source, machine, errors, condition| {
        let whole = deviations(machine, errors, condition, 1);
        let mut errors = errors.clone();
        change_linear(&mut errors, |_, value| *value *= 0.5);
        for (half, whole) in deviations(machine, &errors, condition, 1).iter().zip(&whole) {
            let twice = Twist { translation: half.translation * 2.0, rotation: half.rotation * 2.0 };
            // To second order: products of errors.
            assert!(
                apart(&twice, whole) < 2e-3 * apart(whole, &NOTHING) + 1e-9,
                "{}: {twice:?} {whole:?}",
                source.name
            );
        }
    });
}

/// What a parameter does to the error components, carried to the tool by the analytic sensitivities, is what finite differences of the
/// whole chain give.
#[test]
fn finite_differences_are_the_sensitivities() {
    each(|source, machine, errors, condition| {
        let count = change_linear(&mut errors.clone(), |_, _| {});
        for index in 0..count {
            let at = |sign: f64| {
                let mut errors = errors.clone();
                let mut step = 0.0;
                change_linear(&mut errors, |k, value| {
                    if k == index {
                        step = if *value == 0.0 { 1e-9 } else { 1e-3 * value.abs() };
                        *value += sign * step;
                    }
                });
                (errors, step)
            };
            let [(above, step), (below, _)] = [at(1.0), at(-1.0)];
            let models = [Model::at(machine, &above, condition), Model::at(machine, &below, condition)];
            let [more, less] = [&above, &below].map(|errors| Accumulator::sum(machine, errors, condition, |_| true));
            for (command, state) in poses(1) {
                let [one, other] = models.each_ref().map(|model| model.volumetric_error(&command, &TOOL, &state));
                let mut expected = NOTHING;
                for name in names(machine) {
                    let change = more.value(name, &command, &state) - less.value(name, &command, &state);
                    let unit = models[0].sensitivity(name, &command, &TOOL);
                    expected.translation += unit.translation * change;
                    expected.rotation += unit.rotation * change;
                }
                let found =
                    Twist { translation: one.translation - other.translation, rotation: one.rotation - other.rotation };
                let size = apart(&expected, &NOTHING);
                assert!(
                    apart(&found, &expected) < 2e-3 * size + 1e-12,
                    "{} parameter {index} (step {step}): {found:?} {expected:?}",
                    source.name
                );
            }
        }
    });
}

/// All components of a machine.
fn names(machine: &Machine) -> Vec<ErrorName> {
    let of = |axis: Axis| {
        DIRECTIONS.into_iter().flat_map(move |way| [ErrorName::location(way, axis), ErrorName::motion(way, axis)])
    };
    machine.axis_set().iter().flat_map(of).chain(DIRECTIONS.into_iter().map(ErrorName::spindle)).collect()
}

/// The same errors in the file of a machine whose X counts the other way: functions of X are mirrored, what is fixed to the machine stays.
fn mirrored(source: &SourceInfo) -> String {
    let swap = |pairs: &[(&str, &str)]| {
        pairs.iter().fold(source.example.to_owned(), |text, (from, to)| {
            assert!(text.contains(from), "{}: {from}", source.name);
            text.replace(from, to)
        })
    };
    match source.name {
        "geometry" => swap(&[
            ("[0.0, 1.2e-5, -3e-8]", "[0.0, -1.2e-5, -3e-8]"),
            ("[0, 350, 700]", "[-700, -350, 0]"),
            ("[0, 12, -8]", "[-8, 12, 0]"),
        ]),
        "coupling" => swap(&[
            ("with_coefficients = [0, 1.0]", "with_coefficients = [0, -1.0]"),
            ("with_positions_mm = [0, 700]", "with_positions_mm = [-700, 0]"),
            ("[[0, 2], [6, 3], [4, -1]]", "[[2, 0], [3, 6], [-1, 4]]"),
        ]),
        "reversal" => swap(&[("[0, 700]", "[-700, 0]"), ("[2.0, 5.0]", "[-5.0, -2.0]")]),
        // Segments stand in F; the slide on one is where it was.
        "structure" => source.example.to_owned(),
        "load" => swap(&[
            ("[-8.575e-5, 4.9e-7, -7e-10]", "[8.575e-5, 4.9e-7, 7e-10]"),
            ("at_mm = 350", "at_mm = -350"),
            ("[0, 0, 1.4e-9]", "[0, 0, -1.4e-9]"),
        ]),
        "dynamic" => swap(&[("um_per_m_s2 = 1.5", "um_per_m_s2 = -1.5")]),
        "drift" => source.example.to_owned(),
        "expansion" => swap(&[("fixed_mm = 350", "fixed_mm = -350"), ("fixed_mm = 200", "fixed_mm = -200")]),
        other => panic!("write here how the example of {other} looks where X counts the other way"),
    }
}

#[test]
fn it_does_not_matter_how_an_axis_counts() {
    each(|source, machine, errors, condition| {
        let (turned, turned_errors) = load(-1, &mirrored(source));
        let one = deviations(machine, errors, condition, 1);
        let other = deviations(&turned, &turned_errors, condition, -1);
        for (one, other) in one.iter().zip(&other) {
            assert!(apart(one, other) < 1e-12, "{}: {one:?} {other:?}", source.name);
        }
    });
}

#[test]
fn the_sum_is_that_of_all_sources() {
    let examples: Vec<&str> = built_in().iter().map(|source| source.example).collect();
    let (machine, all) = load(1, &examples.join("\n"));
    let condition = condition(&all);
    let sum = deviations(&machine, &all, &condition, 1);
    let mut parts = vec![NOTHING; sum.len()];
    for source in built_in() {
        let own = Accumulator::sum(&machine, &all, &condition, |effect| effect.source().name == source.name);
        let model = Model::summed(&own);
        for (part, (command, state)) in parts.iter_mut().zip(poses(1)) {
            let found = model.deviation(&command, &TOOL, &state);
            part.translation += found.translation;
            part.rotation += found.rotation;
        }
    }
    for (sum, parts) in sum.iter().zip(&parts) {
        assert!(apart(sum, parts) < 3e-3 * apart(sum, &NOTHING), "{sum:?} {parts:?}");
    }
}

/// The parameters that have a key of their own in the machine file.
fn written(errors: &mut ErrorModel) -> Vec<(String, f64)> {
    let mut values = Vec::new();
    for effect in errors.effects_mut() {
        effect.visit_parameters(&mut |parameter, value| {
            if parameter.written.is_some() {
                values.push((parameter.name.to_owned(), *value));
            }
        });
    }
    values
}

#[test]
fn parameters_that_are_written_into_the_file_are_read_back() {
    let mut sources = 0;
    for source in built_in() {
        let (_, errors) = load(1, source.example);
        let mut changed = errors.clone();
        for effect in changed.effects_mut() {
            effect.visit_parameters(&mut |parameter, value| {
                if parameter.written.is_some() {
                    *value *= 1.25;
                }
            });
        }
        let expected = written(&mut changed);
        sources += usize::from(!expected.is_empty());
        let head = text(1, "");
        let new = write::write(&text(1, source.example), &errors, &changed).unwrap();
        let (_, mut read) = load(1, new.strip_prefix(&head).unwrap());
        let found = written(&mut read);
        assert_eq!(found.len(), expected.len(), "{}", source.name);
        for ((name, found), (of, expected)) in found.iter().zip(&expected) {
            assert_eq!(name, of);
            assert!(
                (found - expected).abs() <= 1e-12 * expected.abs(),
                "{}: {name} {found:e} {expected:e}",
                source.name
            );
        }
    }
    // Location and motion errors have names of their own instead of keys; most sources are more than those.
    assert!(sources >= 5, "{sources}");
}

#[test]
fn effects_are_the_same_where_source_and_values_are() {
    for source in built_in() {
        let (_, errors) = load(1, source.example);
        let mut changed = errors.clone();
        assert!(errors.effects == changed.effects, "{}", source.name);
        let mut is_first = true;
        changed.effects.iter_mut().for_each(|effect| {
            effect.visit_parameters(&mut |_, value| {
                if std::mem::take(&mut is_first) {
                    *value *= 2.0;
                }
            });
        });
        assert_eq!(errors.effects == changed.effects, is_first, "{}", source.name);
    }
}

#[test]
fn a_sum_lists_what_was_added_and_nothing_else() {
    let (machine, errors) = load(
        1,
        "[location]\nEC0Y = 20\n[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0.0, 1e-5]\n",
    );
    let sum = Accumulator::sum(&machine, &errors, &Condition::default(), |_| true);
    let parts = sum.parts();
    let names: Vec<String> = parts.iter().map(|(name, ..)| name.to_string()).collect();
    assert_eq!(names, ["EC0Y", "EXX"]);
    assert!((parts[0].2 - 20e-6).abs() < 1e-18 && parts[0].1.is_none());
    assert_eq!(parts[1].1, Some(&errors.motion[0].function));
}
