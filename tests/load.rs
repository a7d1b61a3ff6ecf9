//! Workpiece weight: eq. 4.1 of Spaan 1995 by hand, the tilt of the table, signs by rotations of their own, findings.

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Condition, Load, Machine, State};
use ncfix_model::{ErrorModel, Model, file};

use crate::support::Shop;

/// The table carries X on Y; the head carries Z: the chain of a horizontal milling machine, without its rotary table.
const MACHINE: &str = "[machine]\nname = \"knee\"\ntopology = \"wXYFZSt\"\n\
    [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [0, 700]\npoint_mm = [0, 100, -50]\n\
    [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 600]\n";

/// 5 µrad at X 0, 0 at 350, −9 at 700.
const ROLL: &str = "[[load]]\ncomponent = \"EAX\"\nreference_N = 4800\nalong = \"Z\"\narm_mm = 375\nkind = \"table\"\n\
    positions_mm = [0, 350, 700]\nvalues_urad = [5, 0, -9]\n";

/// N, and mm from the center of the table.
type Weight = (f64, [f64; 3]);

fn read(text: &str) -> (Machine, ErrorModel) {
    let source = Source::new(FileId(0), "test.toml", text.as_bytes().to_vec()).unwrap();
    let (result, findings) = file::load(&source);
    assert!(findings.is_empty(), "{findings:#?}");
    result.unwrap()
}

/// Codes and lines of the findings in a section that stands behind the machine.
fn found(section: &str) -> Vec<(String, usize)> {
    let source = Source::new(FileId(0), "test.toml", format!("{MACHINE}{section}").into_bytes()).unwrap();
    let first = MACHINE.lines().count();
    let (result, findings) = file::load(&source);
    assert!(result.is_none());
    findings
        .iter()
        .map(|finding| {
            let (line, _) = source.line_column(finding.place.unwrap().span.start);
            (finding.code.as_str().to_owned(), line - first)
        })
        .collect()
}

fn condition(loads: &[Weight]) -> Condition {
    let mut condition = Condition::default();
    for &(force_n, position_mm) in loads {
        condition.add_load(Load { force_n, position_mm: position_mm.into() });
    }
    condition
}

fn at(x: f64, y: f64, z: f64) -> AxisVector {
    let mut command = AxisVector::ZERO;
    command.set_xyz(Vector::new(x, y, z));
    command
}

/// Rotation of the tool relative to the table at X, in µrad.
fn turned_urad(text: &str, loads: &[Weight], x: f64) -> Vector {
    let (machine, errors) = read(text);
    let model = Model::at(&machine, &errors, &condition(loads));
    model.volumetric_error(&at(x, 120.0, 80.0), &Vector::new(1.0, 2.0, -90.0), &State::default()).rotation * 1e6
}

fn near(seen: Vector, expected: [f64; 3], limit: f64) {
    assert!((seen - Vector::from(expected)).norm() < limit, "{seen:?} is not {expected:?}");
}

#[test]
fn the_roll_of_the_table_follows_weight_and_arm() {
    let text = format!("{MACHINE}{ROLL}");
    // The tool turns by minus the roll of the table relative to it.
    let cases: [(&[Weight], f64, f64); 8] = [
        // The reference load in the center: the table itself.
        (&[(4800.0, [0.0; 3])], 0.0, 5.0),
        (&[(4800.0, [0.0; 3])], 700.0, -9.0),
        (&[(4800.0, [0.0; 3])], 525.0, -4.5),
        // 1700 N at the front, Z −280: 1700/4800 · 655/375 = 0.618611.
        (&[(1700.0, [0.0, 0.0, -280.0])], 0.0, 3.093_055_6),
        // At the back, Z 280: 1700/4800 · 95/375 = 0.0897222, times −9.
        (&[(1700.0, [0.0, 0.0, 280.0])], 700.0, -0.8075),
        // Above the guideway nothing is left, and beyond it the sense is reversed.
        (&[(4800.0, [0.0, 0.0, 375.0])], 700.0, 0.0),
        (&[(4800.0, [55.0, 66.0, 750.0])], 700.0, 9.0),
        // Two loads: 2600/4800 · (375 − 100)/375 + 1200/4800 · (375 + 150)/375 = 0.397222 + 0.35, times −4.5.
        (&[(2600.0, [0.0, 0.0, 100.0]), (1200.0, [-80.0, 0.0, -150.0])], 525.0, -3.3625),
    ];
    for (loads, x, roll) in cases {
        near(turned_urad(&text, loads, x), [-roll, 0.0, 0.0], 1e-6);
    }
}

#[test]
fn without_arm_the_weight_alone_counts_and_a_moment_is_zero_in_the_center() {
    let weight = ROLL.replace("along = \"Z\"\narm_mm = 375\n", "");
    near(turned_urad(&format!("{MACHINE}{weight}"), &[(2400.0, [9.0, 8.0, 7.0])], 0.0), [-2.5, 0.0, 0.0], 1e-6);
    let moment = ROLL.replace("along = \"Z\"\narm_mm = 375\n", "along = \"X\"\nat_mm = -200\n");
    let text = format!("{MACHINE}{moment}");
    near(turned_urad(&text, &[(4800.0, [0.0, 40.0, 40.0])], 0.0), [0.0; 3], 1e-12);
    near(turned_urad(&text, &[(2400.0, [-100.0, 0.0, 0.0])], 0.0), [-1.25, 0.0, 0.0], 1e-6);
    near(turned_urad(&text, &[(2400.0, [100.0, 0.0, 0.0])], 0.0), [1.25, 0.0, 0.0], 1e-6);
}

#[test]
fn the_table_tilts_everywhere_alike() {
    let tilt = "[[load]]\ncomponent = \"EA0Y\"\nreference_N = 4900\nalong = \"Z\"\nat_mm = -280\nvalue_urad = -45\n\
        [[load]]\ncomponent = \"EY0X\"\nreference_N = 4900\nvalue_um = -12\n";
    let text = format!("{MACHINE}{tilt}");
    let (machine, errors) = read(&text);
    // 1700/4900 · (−280/−280) · −45 µrad of the table.
    let tilt_urad = -45.0 * 1700.0 / 4900.0;
    for x in [0.0, 333.0, 700.0] {
        near(turned_urad(&text, &[(1700.0, [0.0, 0.0, -280.0])], x), [-tilt_urad, 0.0, 0.0], 1e-6);
    }
    // In the center the table only sinks: the tool is 1700/4900 · 12 µm too high in the workpiece.
    let model = Model::at(&machine, &errors, &condition(&[(1700.0, [0.0; 3])]));
    let error = model.volumetric_error(&at(10.0, 20.0, 30.0), &Vector::zeros(), &State::default());
    near(error.translation * 1e3, [0.0, 12.0 * 1700.0 / 4900.0, 0.0], 1e-9);
}

#[test]
fn no_load_and_no_effect_are_no_error() {
    let (machine, errors) = read(&format!("{MACHINE}{ROLL}"));
    assert!(errors.effects.iter().all(|effect| effect.needs_load()));
    assert!(Model::new(&machine, &errors).is_empty());
    assert!(Model::at(&machine, &errors, &condition(&[(0.0, [1.0, 2.0, 3.0])])).is_empty());
    let (machine, errors) = read(&format!("{MACHINE}{}", ROLL.replace("[5, 0, -9]", "[0, 0, 0]")));
    assert!(Model::at(&machine, &errors, &condition(&[(5000.0, [0.0; 3])])).is_empty());
}

#[test]
fn parameters_scale_the_error_and_the_arm_does_not() {
    let (machine, errors) = read(&format!("{MACHINE}{ROLL}"));
    let loads = condition(&[(1700.0, [0.0, 0.0, -280.0])]);
    let tip = |errors: &ErrorModel| {
        let command = at(600.0, 100.0, 50.0);
        Model::at(&machine, errors, &loads).tip_error_mm(&command, &command, &Vector::zeros(), &State::default())
    };
    let before = tip(&errors);
    let (mut scaled, mut moved) = (errors.clone(), errors.clone());
    let mut names = Vec::new();
    for effect in scaled.effects_mut() {
        effect.visit_parameters(&mut |parameter, value| {
            names.push((parameter.name.to_owned(), parameter.is_linear));
            *value *= if parameter.is_linear { 3.0 } else { 1.0 };
        });
    }
    let expected = [("values[0]", true), ("values[1]", true), ("values[2]", true), ("arm_mm", false)];
    let expected = expected.map(|(name, is_linear)| (format!("load.EAX.{name}"), is_linear));
    assert_eq!(names, expected);
    assert!(before.norm() > 1e-4);
    // Rotations of some µrad: what is not linear is below 1e-9 mm.
    assert!((tip(&scaled) - before * 3.0).norm() < 1e-8, "{before:?} {:?}", tip(&scaled));
    // Twice the arm: (750 + 280)/750 instead of (375 + 280)/375.
    for effect in moved.effects_mut() {
        effect.visit_parameters(&mut |parameter, value| *value *= if parameter.is_linear { 1.0 } else { 2.0 });
    }
    assert!((tip(&moved) - before * ((1030.0 / 750.0) / (655.0 / 375.0))).norm() < 1e-8);
    // An arm of nothing has no meaning and spoils nothing.
    for effect in moved.effects_mut() {
        effect.visit_parameters(&mut |parameter, value| *value *= f64::from(u8::from(parameter.is_linear)));
    }
    assert!(tip(&moved).iter().all(|value| value.is_finite()));
}

/// A workpiece on a table that rolls about a line through `point_mm` sees the tool turn the other way about this line.
#[test]
fn the_tool_goes_the_other_way_than_the_table() {
    let (machine, errors) = read(&format!("{MACHINE}{}", ROLL.replace("[5, 0, -9]", "[5000, 0, -9000]")));
    let model = Model::at(&machine, &errors, &condition(&[(4800.0, [0.0; 3])]));
    let (command, tool) = (at(700.0, 120.0, 80.0), Vector::new(1.0, 2.0, -90.0));
    // In the frame of the table at X 700, Y 120 (both move the table the other way), without errors:
    let nominal = Vector::new(1.0 + 700.0, 2.0 + 120.0, 80.0 - 90.0);
    // The carriage of X turns by −9 mrad about a line along X through (0, 100, −50) of its own; seen from it, the tool turns by 9 mrad.
    let (sine, cosine) = 0.009_f64.sin_cos();
    let [y, z] = [nominal.y - 100.0, nominal.z + 50.0];
    let expected = Vector::new(nominal.x, 100.0 + cosine * y - sine * z, -50.0 + sine * y + cosine * z);
    let seen = model.actual(&command, &tool, &State::default()).translation;
    assert!((seen - expected).norm() < 1e-9, "{seen:?} {expected:?}");
    let axis = Model::at(&machine, &errors, &condition(&[])).actual(&command, &tool, &State::default()).translation;
    assert!((axis - nominal).norm() < 1e-9);
    assert_eq!(machine.axis(Axis::X).unwrap().travel, Some([0.0, 700.0]));
}

#[test]
fn every_fault_of_a_section_is_found_at_its_place() {
    let base = "[[load]]\ncomponent = \"EAX\"\nreference_N = 4800\nkind = \"polynomial\"\ncoefficients = [1e-6]\n";
    let cases = [
        (base.replace("4800", "0"), ("E0404", 3)),
        (base.replace("4800", "-5"), ("E0404", 3)),
        (base.replace("reference_N = 4800\n", ""), ("E0403", 1)),
        (base.replace("EAX", "EAB"), ("E0406", 2)),
        (base.replace("EAX", "EA0B"), ("E0406", 2)),
        (base.replace("EAX", "EQX"), ("E0406", 2)),
        (base.replace("polynomial", "polynom"), ("E0404", 4)),
        (format!("{base}along = \"Z\"\narm_mm = 0\n"), ("E0404", 7)),
        (format!("{base}along = \"Q\"\narm_mm = 5\n"), ("E0404", 6)),
        (format!("{base}arm_mm = 5\n"), ("E0403", 1)),
        (format!("{base}along = \"Z\"\n"), ("E0403", 6)),
        (format!("{base}along = \"Z\"\narm_mm = 5\nat_mm = 6\n"), ("E0404", 8)),
        (format!("{base}weight = 5\n"), ("E0402", 6)),
        ("[[load]]\ncomponent = \"EA0X\"\nreference_N = 5\nvalue_um = 5\n".to_owned(), ("E0407", 4)),
        (
            "[[load]]\ncomponent = \"EA0X\"\nreference_N = 5\nvalue_urad = 5\nkind = \"table\"\n".to_owned(),
            ("E0402", 5),
        ),
        ("[[load]]\ncomponent = \"EX0X\"\nreference_N = 5\n".to_owned(), ("E0403", 1)),
    ];
    for (section, (code, line)) in cases {
        assert_eq!(found(&section), [(code.to_owned(), line)], "{section}");
    }
}

#[test]
fn a_load_off_the_center_of_a_turning_table_is_pointed_out() {
    let table =
        MACHINE.replace("wXYFZSt", "wBXYFZSt") + "[axis.B]\ndirection = [0, 1, 0]\ntravel_deg = [0, 360]\n" + ROLL;
    let shop = Shop::new().file("m.toml", format!("{MACHINE}{ROLL}")).file("b.toml", table);
    let says = |machine: &str, load: &str| {
        let run = shop.run(["machine", "show", machine, "--at", "X700,Y0,Z0", "--load", load]).exits(0);
        assert!(run.stdout.contains("  EAX ") || load == "0", "{}", run.stdout);
        run.stderr.contains("W0503")
    };
    // Along the axis of the table it stays where it is.
    let cases = [("m.toml", "1700@0,0,-280"), ("b.toml", "1700"), ("b.toml", "1700@0,90,0"), ("b.toml", "0")];
    assert_eq!(cases.map(|(machine, load)| says(machine, load)), [false; 4]);
    assert!(says("b.toml", "1700@0,0,-280"));
}

/// What the command shows at a pose is eq. 4.1: −9 µrad · 1700/4800 · 655/375 about X, of the tool the other way.
#[test]
fn the_share_of_the_weight_is_shown() {
    let state = "[[load]]\nforce_N = 1700\nposition_mm = [0, 0, -280]\n";
    let shop = Shop::new().file("m.toml", format!("{MACHINE}{ROLL}")).file("state.toml", state);
    let run = shop.run(["machine", "show", "m.toml", "--at", "X700,Y0,Z0", "--state", "state.toml", "--json"]).exits(0);
    let json = run.json();
    let sources = json["sources"].as_array().unwrap();
    let load = sources.iter().find(|source| source["source"] == "load").unwrap();
    let turned = load["deviation"]["rotation_urad"][0].as_f64().unwrap();
    assert!((turned - 9.0 * 1700.0 / 4800.0 * 655.0 / 375.0).abs() < 1e-3, "{load}");
}
