//! What a diagnosis calls correctable by a program moves the machine nearer to where it should be: also where was not measured.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use ncfix_base::geometry::Vector;
use ncfix_base::source::{FileId, Source};
use ncfix_metrology::diagnose::{Causes, Scene, commands};
use ncfix_metrology::measure::plan::{Wishes, find};
use serde_json::Value;

use crate::cli_calibrate::bare;
use crate::diagnose::{findings, name, number, report, run};
use crate::diagnose_waves::found;
use crate::plant::Random;
use crate::support::{Shop, machine};

const PLATE: &str = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\", \"rotation\"]\nsigma_um = 0.6\n";
const CIRCLES: &str = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\", \"length\"]\nsigma_um = 0.6\n\
                       [setup.A]\ncentre_mm = [350, 250, 100]\nlength_mm = 150\n";
const LINE: &str = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.4\n";

/// Whether a finding may move a machine.
fn is_written(one: &Value) -> bool {
    one["correctable"] == "program" || one["extends"] == true
}

/// A plate with 8 × 8 holes every 50 mm, twice: errors along X by the place, µm.
fn plate(seed: u64, error: impl Fn(f64) -> f64) -> String {
    let mut random = Random::new(seed, "plate");
    let mut table = "run,setup,X,Y,Z,tool_z_mm,dx_um,dy_um\n".to_owned();
    for run in 1..=2 {
        for (i, k) in (0..64).map(|n| (n / 8, n % 8)) {
            let [x, y] = [175.0 + 50.0 * f64::from(i), 75.0 + 50.0 * f64::from(k)];
            let [dx, dy] = [error(x) + 0.6 * random.normal(), 0.6 * random.normal()];
            let _ = writeln!(table, "{run},A,{x},{y},200,-120,{dx:.4},{dy:.4}");
        }
    }
    table
}

#[test]
fn a_short_wave_on_an_even_plate_is_no_polynomial_to_correct() {
    // Every 50 mm, 16 mm are 3.125 turns: the same as an eighth of a turn.
    for (seed, phase) in [(1, 0.5), (2, 2.1), (3, 4.0)] {
        let table = plate(seed, |x| 3.0 * (TAU * x / 16.0 + phase).sin());
        let (shop, report) = found(&table, PLATE, &["-o", "out.toml"]);
        let all = findings(&report);
        assert!(!all.is_empty() && !shop.path("out.toml").exists(), "{report:#}");
        for one in &all {
            assert!(!is_written(one), "{one:#}");
            let class = one["class"].as_array().unwrap();
            assert!(
                class.iter().any(|name| name == "periodic EXX every 16 mm") || name(one) == "periodic EXX",
                "{one:#}"
            );
            assert!(one["separate_by"].as_str().unwrap().contains("ncfix plan laser --axis X"), "{one:#}");
            assert!(one["extends_why"].as_str().unwrap().contains("wave") || name(one) == "periodic EXX", "{one:#}");
        }
    }
}

#[test]
fn a_scale_on_an_even_plate_is_corrected_all_the_same() {
    for seed in 1..4 {
        let (_, report) = found(&plate(seed, |x| 0.02 * x), PLATE, &[]);
        let all = findings(&report);
        assert!(all.len() == 1 && name(&all[0]) == "motion EXX" && all[0]["correctable"] == "program", "{report:#}");
    }
}

/// Circles of 150 mm about the middle in three planes and both senses: readings are errors along the bar, µm, by the position.
fn circles(seed: u64, error: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    let mut random = Random::new(seed, "circles");
    let mut table = "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_z_mm,dr_um\n".to_owned();
    for (plane, axes) in [("XY", [0, 1]), ("YZ", [1, 2]), ("ZX", [2, 0])] {
        for sense in [1.0, -1.0] {
            for k in 0..72 {
                let angle: f64 = sense * TAU * f64::from(k) / 72.0;
                let mut normal = [0.0; 3];
                normal[axes[0]] = angle.cos();
                normal[axes[1]] = angle.sin();
                let mut senses = [0.0; 3];
                senses[axes[0]] = if sense * angle.sin() > 0.0 { -1.0 } else { 1.0 };
                senses[axes[1]] = if sense * angle.cos() < 0.0 { -1.0 } else { 1.0 };
                let at = [350.0 + 150.0 * normal[0], 250.0 + 150.0 * normal[1], 220.0 + 150.0 * normal[2]];
                let dr: f64 = error(at).iter().zip(&normal).map(|(error, along)| error * along).sum();
                let ([x, y, z], [a, b, c]) = (at, senses);
                let dr = dr + 0.6 * random.normal();
                let _ = writeln!(table, "{plane}{sense},A,{x:.6},{y:.6},{z:.6},{a},{b},{c},-120,{dr:.4}");
            }
        }
    }
    table
}

#[test]
fn a_squareness_and_a_scale_on_circles_are_no_yaw_to_correct() {
    let mut found_any = 0;
    for seed in 1..4 {
        for [scale, square] in [[0.007, 0.010], [0.007, -0.010], [-0.007, 0.010], [-0.007, -0.010]] {
            // 7 µm/m along X, and Y 10 µrad off square, on a table that carries both axes: there a yaw of X, which turns the table, bends lines of Y 250 mm
            // away from the middle.
            let table = circles(seed, |[x, y, _]| [scale * x + square * y, 0.0, 0.0]);
            let shop = Shop::new().file("m.toml", bare("demo")).file("d.csv", table).file("d.toml", CIRCLES);
            let report = report(&run(&shop, &["d.csv".to_owned()], "m.toml", &[]));
            let right = ["motion EXX", "location EC0Y", "location EC0X", "motion EXY", "motion EYX"];
            for one in findings(&report) {
                found_any += 1;
                assert!(!is_written(&one) || right.contains(&name(&one).as_str()), "{one:#}");
            }
        }
    }
    assert!(found_any > 6);
}

/// One with a probability below 95 % is named all the same: only the file waits for the next measurement.
#[test]
fn one_error_on_circles_is_corrected_all_the_same() {
    let mut corrected = 0;
    for seed in 1..4 {
        let known_length = CIRCLES.replace(", \"length\"", "");
        for (truth, slope, description) in
            [("location EC0Y", [0.0, 0.02], CIRCLES), ("motion EXX", [0.02, 0.0], &known_length)]
        {
            let table = circles(seed, |[x, y, _]| [slope[0] * x + slope[1] * y, 0.0, 0.0]);
            let (_, report) = found(&table, description, &[]);
            let all = findings(&report);
            assert!(all.len() == 1 && name(&all[0]) == truth, "{report:#}");
            let is_certain = number(&all[0], "probability") >= 0.95;
            assert_eq!(all[0]["correctable"] == "program", is_certain, "{report:#}");
            assert!(is_certain || all[0]["separate_by"].as_str().is_some_and(|plan| plan.contains("ncfix plan")));
            corrected += u32::from(is_certain);
        }
    }
    assert!(corrected >= 4, "{corrected} of 6");
}

/// A bar of unknown length shows only differences of scales: X may be too long, or Y and Z too short by the same share.
#[test]
fn a_scale_on_circles_of_unknown_length_waits_for_a_line() {
    for seed in 1..4 {
        let table = circles(seed, |[x, ..]| [0.02 * x, 0.0, 0.0]);
        let (shop, report) = found(&table, CIRCLES, &["-o", "out.toml"]);
        let all = findings(&report);
        let scale = all.iter().find(|one| name(one) == "motion EXX").unwrap_or_else(|| panic!("{report:#}"));
        assert!(scale["certain"] == false && !is_written(scale) && !shop.path("out.toml").exists(), "{scale:#}");
        assert_eq!(scale["rivals"][0]["cause"], "motion EYY with motion EZZ");
        assert!(scale["separate_by"].as_str().unwrap().contains("ncfix plan laser --axis X"), "{scale:#}");
    }
}

/// A warm machine on a bar of known length makes all circles too large, as a lag of all axes makes them smaller at one feed: neither is certain.
#[test]
fn equal_scales_of_all_axes_are_no_certain_lag() {
    let known_length = CIRCLES.replace(", \"length\"", "");
    for (seed, scale) in [(1, 0.02), (2, -0.02)] {
        let table = circles(seed, |[x, y, z]| [scale * x, scale * y, scale * z]);
        let table: String = table
            .lines()
            .enumerate()
            .map(|(line, cells)| format!("{cells},{}\n", if line == 0 { "feed_mm_min" } else { "1000" }))
            .collect();
        let (_, report) = found(&table, &known_length, &[]);
        for one in findings(&report) {
            assert!(one["certain"] == false && !is_written(&one), "{one:#}");
        }
        let explanations = report["explanations"].to_string();
        assert!(explanations.contains("motion XYZ"), "{explanations}");
    }
}

/// Holes drilled in serpentine order and listed row by row: a backlash of X shifts every second row, which looks like a straightness of Y with a bend at
/// each row.
#[test]
fn a_backlash_behind_a_sorted_report_is_no_straightness() {
    for seed in 1..4 {
        let mut random = Random::new(seed, "sorted report");
        let mut table = "setup,X,Y,Z,tool_z_mm,dx_um,dy_um\n".to_owned();
        for (line, hole) in (0..63).map(|n| (n / 9, n % 9)) {
            let side = if line % 2 == 0 { 10.0 } else { -10.0 };
            let [x, y] = [60.0 + 60.0 * f64::from(hole), 50.0 + 50.0 * f64::from(line)];
            let [dx, dy] = [side + 2.0 * random.normal(), 2.0 * random.normal()];
            let _ = writeln!(table, "A,{x},{y},200,-120,{dx:.4},{dy:.4}");
        }
        let (shop, report) = found(&table, &PLATE.replace("0.6", "2"), &["-o", "out.toml"]);
        let all = findings(&report);
        assert!(all.len() == 1 && name(&all[0]) == "backlash EXX", "{report:#}");
        assert!((number(&all[0], "value").abs() - 20.0).abs() < number(&all[0], "u95"), "{:#}", all[0]);
        assert!(!is_written(&all[0]) && !shop.path("out.toml").exists(), "{:#}", all[0]);
    }
}

/// What goes round with the angle of the circles in all planes, as a radial error of so many lobes, µm; in each plane behind by its own phase.
fn lobes([x, y, z]: [f64; 3], amplitude: f64, count: f64, phases: [f64; 3]) -> [f64; 3] {
    let normal = [(x - 350.0) / 150.0, (y - 250.0) / 150.0, (z - 220.0) / 150.0];
    let still = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap();
    let angle = normal[(still + 2) % 3].atan2(normal[(still + 1) % 3]);
    normal.map(|along| amplitude * (count * angle + phases[still]).cos() * along)
}

#[test]
fn lobes_that_go_round_in_every_plane_are_no_errors_of_axes() {
    for seed in 1..6 {
        let turn = 0.8 * seed as f64;
        for (amplitude, count, phases) in
            [(2.0, 5.0, [turn; 3]), (1.2, 5.0, [turn; 3]), (2.0, 5.0, [turn, 2.5 - turn, 1.3]), (2.0, 4.0, [turn; 3])]
        {
            let table = circles(seed, |at| lobes(at, amplitude, count, phases));
            let (shop, report) = found(&table, CIRCLES, &["-o", "out.toml"]);
            let all = findings(&report);
            assert!(all.iter().all(|one| !is_written(one)) && !shop.path("out.toml").exists(), "{report:#}");
            assert_eq!(all[0]["effect"], "unknown", "{report:#}");
            assert!(all[0]["what"].as_str().unwrap().contains(&format!("{count} lobes")), "{report:#}");
            assert!((number(&all[0], "value") - amplitude).abs() < 0.3, "{report:#}");
        }
    }
}

#[test]
fn a_bow_on_circles_is_named_before_a_cross_coupling() {
    for seed in 1..5 {
        for (truth, own) in [("motion EYX", 0), ("motion EXY", 1)] {
            // 4 µm over the half of the circle: as X bends sideways, Y · X² of the radius is what X · Y along X makes as well.
            let bow = |at: [f64; 3]| 4.0 * ((at[own] - [350.0, 250.0][own]) / 150.0).powi(2);
            let table = circles(seed, |at| if own == 0 { [0.0, bow(at), 0.0] } else { [bow(at), 0.0, 0.0] });
            let (_, report) = found(&table, CIRCLES, &[]);
            let all = findings(&report);
            assert!(all.len() == 1 && name(&all[0]) == truth && is_written(&all[0]), "{report:#}");
            assert!((number(&all[0], "value") - 4.0).abs() < 1.0, "{report:#}");
        }
    }
}

#[test]
fn a_pitch_on_circles_is_no_squareness_to_correct() {
    let demo = std::fs::read_to_string(machine("demo")).unwrap();
    let plan = ["plan", "ballbar", "--machine", "m.toml", "--tool", "150", "--radius", "100", "--every", "2"];
    let shop = Shop::new().file("m.toml", &demo);
    shop.run(plan.into_iter().chain(["-o", "plan.csv"])).exits(0);
    let mut named = 0;
    for seed in 1..4 {
        for truth in ["EBX", "EAY"] {
            // 60 µrad/m.
            let entry =
                format!("\n[[motion]]\ncomponent = \"{truth}\"\nkind = \"polynomial\"\ncoefficients = [0, 6e-8]\n");
            std::fs::write(shop.path("true.toml"), format!("{demo}{entry}")).unwrap();
            let noise = ["--noise", "0.5um", "--seed", &seed.to_string()].map(str::to_owned);
            let words = ["simulate", "--machine", "true.toml", "plan.csv", "-o", "d.csv"].map(str::to_owned);
            shop.run(words.into_iter().chain(noise)).exits(0);
            let report = report(&run(&shop, &["d.csv".to_owned()], "m.toml", &[]));
            let all = findings(&report);
            assert!(all.iter().all(|one| !is_written(one) || name(one) == format!("motion {truth}")), "{report:#}");
            named += u32::from(all.iter().any(|one| name(one) == format!("motion {truth}")));
            std::fs::remove_file(shop.path("d.csv")).unwrap();
            let _ = std::fs::remove_file(shop.path("d.toml"));
        }
    }
    assert!(named > 3, "{named}");
}

#[test]
fn a_squareness_and_a_scale_on_circles_are_named_in_place_of_a_yaw() {
    let mut both = 0;
    for seed in 1..5 {
        for [scale, square] in [[0.007, 0.010], [0.007, -0.010], [-0.007, 0.010], [-0.007, -0.010]] {
            let table = circles(seed, |[x, y, _]| [scale * x + square * y, 0.0, 0.0]);
            let shop = Shop::new().file("m.toml", bare("demo")).file("d.csv", table).file("d.toml", CIRCLES);
            let report = report(&run(&shop, &["d.csv".to_owned()], "m.toml", &[]));
            let names: Vec<String> = findings(&report).iter().map(name).collect();
            both += u32::from(names.len() == 2 && names.iter().any(|one| one == "motion EXX"));
        }
    }
    assert!(both > 10, "{both}");
}

#[test]
fn own_errors_of_a_few_targets_are_no_wave() {
    // Places, mm, and what each has of its own, µm: of random numbers of a normal distribution. One in ten of eleven such lies as near to some wave of a
    // hundred (here of 25.1 mm: 0.85 of their variance).
    const TARGETS: [(f64, f64); 11] = [
        (6.7636, 0.53),
        (83.4049, 0.31),
        (161.956, -0.24),
        (209.2898, -0.54),
        (278.4859, 1.83),
        (360.9154, -0.61),
        (434.8675, -0.05),
        (489.3577, -1.12),
        (548.6943, 0.35),
        (639.0067, -0.66),
        (692.02, -0.77),
    ];
    let mut told = 0;
    for seed in 1..9 {
        for truth in [None, Some(25.1)] {
            let mut random = Random::new(seed, "targets");
            let mut table = "run,setup,component,X,Y,Z,X_dir,value_um\n".to_owned();
            for run in 0..3 {
                for sense in [1, -1] {
                    for k in 0..11 {
                        let (x, own) = TARGETS[if sense > 0 { k } else { 10 - k }];
                        let error = truth.map_or(own, |period: f64| 2.0 * (TAU * x / period + 0.4).sin());
                        let _ = writeln!(
                            table,
                            "{run}{sense},A,EXX,{x},250,200,{sense},{:.4}",
                            error + 0.5 * random.normal()
                        );
                    }
                }
            }
            let (_, report) = found(&table, LINE, &[]);
            let is_wave = findings(&report).iter().any(|one| one["effect"] == "periodic" && is_written(one));
            told += u32::from(is_wave && truth.is_some());
            assert!(truth.is_some() || !is_wave, "{report:#}");
        }
    }
    // A wave of four times the noise is told all the same.
    assert!(told > 5, "{told}");
}

/// A laser with straightness along X from 200 to 500 mm, of 0 to 700: readings by position, µm.
fn line(seed: u64, component: &str, error: impl Fn(f64) -> f64) -> String {
    let mut random = Random::new(seed, "line");
    let mut table = "run,setup,component,X,Y,Z,X_dir,value_um\n".to_owned();
    for run in 0..3 {
        for sense in [1, -1] {
            let places = (0..21).map(|k| if sense > 0 { k } else { 20 - k });
            for x in places.map(|k| 200.0 + 15.0 * f64::from(k) + f64::from(k * k % 7)) {
                let value = error(x) + 0.4 * random.normal();
                let _ = writeln!(table, "{run}{sense},A,{component},{x},250,200,{sense},{value:.4}");
            }
        }
    }
    table
}

#[test]
fn what_bends_is_written_as_far_as_it_was_measured() {
    // 6 µm over 300 mm; at 0 and 700 mm a parabola would have 25 to 35 µm.
    let table = line(1, "EYX", |x| 6.0 * ((x - 350.0) / 150.0).powi(2));
    let square = format!("{LINE}reference = \"square\"\n");
    let (shop, report) = found(&table, &square, &["-o", "out.toml"]);
    let all = findings(&report);
    assert!(all.len() == 1 && name(&all[0]) == "motion EYX" && all[0]["extends"] == true, "{report:#}");
    assert!((number(&all[0], "value") - 6.0).abs() < 1.5, "{report:#}");
    let text = shop.text("out.toml");
    assert!(text.contains("kind = \"table\"") && !text.contains("polynomial"), "{text}");
    let places = text.lines().find_map(|line| line.strip_prefix("positions_mm = [")).unwrap();
    let places: Vec<f64> = places.trim_end_matches(']').split(',').map(|place| place.trim().parse().unwrap()).collect();
    assert!(places[0] == 200.0 && *places.last().unwrap() < 507.0, "{text}");
    // The polynomial is zero at X 0, 33 µm away from all that was measured: the instrument was set to zero somewhere, and no reading tells this offset.
    let values = text.lines().find_map(|line| line.strip_prefix("values_um = [")).unwrap();
    let mut values = values.trim_end_matches(']').split(',').map(|value| value.trim().parse::<f64>().unwrap());
    assert!(values.all(|value| value.abs() < 9.0), "{text}");
}

#[test]
fn a_line_that_goes_on_is_a_slope_beyond_it_too() {
    let (shop, report) = found(&line(1, "EXX", |x| 0.03 * x), LINE, &["-o", "out.toml"]);
    assert!(findings(&report).iter().all(|one| one["extends"] == true), "{report:#}");
    assert!(shop.text("out.toml").contains("polynomial"), "{}", shop.text("out.toml"));
}

#[test]
fn every_plan_that_tells_rivals_apart_can_be_made() {
    for name in ["demo", "vmc", "maho700s"] {
        let path = machine(name);
        let text = std::fs::read(&path).unwrap();
        let source = Source::new(FileId(0), "m.toml", text).unwrap();
        let (machine, errors) = ncfix_model::file::load(&source).0.unwrap();
        // Any measurement of it: a line with a tool of 120 mm.
        let tools_mm = vec![Vector::new(0.0, 0.0, -120.0)];
        let wishes = Wishes { tools_mm, points: Some(9), runs: Some(1), ..Wishes::default() };
        let mut set = (find("laser").unwrap().build)(&machine, &wishes).unwrap().data;
        set.observations.iter_mut().for_each(|row| row.values = [Some(0.0), None, None]);
        let sets = [set];
        let scene = Scene::new(&machine, &errors, &sets).unwrap();
        let all = commands(&Causes::default(), &scene);
        let kinds = ["ballbar", "laser", "plate", "drift"];
        assert!(
            kinds.iter().all(|kind| all.iter().any(|one| one.starts_with(&format!("ncfix plan {kind}")))),
            "{all:?}"
        );
        let shop = Shop::new();
        for command in all {
            let words: Vec<&str> =
                command.split(' ').skip(1).map(|word| if word == "M.toml" { &path } else { word }).collect();
            shop.run(&words).exits(0);
            assert!(shop.path("PLAN.csv").exists(), "{command}");
        }
    }
}

#[test]
fn nothing_absurd_stands_in_front_of_what_lines_show() {
    // Three lines through one point show the middle of cross-couplings only: none of them may take what the scale of Z is, as large as a door.
    for seed in 1..4 {
        let mut random = Random::new(seed, "lines");
        let mut table = "run,setup,component,X,Y,Z,X_dir,Y_dir,Z_dir,tool_z_mm,value_um\n".to_owned();
        for (axis, name, length, [wave, slope]) in
            [(0, "EXX", 690.0, [3.0, 0.0]), (1, "EYY", 490.0, [0.0, 0.0]), (2, "EZZ", 490.0, [0.0, 0.012])]
        {
            for run in 0..5 {
                for sense in [1.0, -1.0] {
                    for k in 0..15 {
                        let k = f64::from(if sense > 0.0 { k } else { 14 - k });
                        let mut at = [350.0, 250.0, 203.0];
                        let zero = if axis == 2 { 50.0 } else { 0.0 };
                        at[axis] = 12.0 + (length - 24.0) * k / 14.0 + 9.0 * (5.0 * k * k).sin() - zero;
                        let q = at[axis];
                        let value = wave * (TAU * q / 10.0 + 0.7).sin() + slope * q + 0.6 * random.normal();
                        let mut senses = [0.0; 3];
                        senses[axis] = sense;
                        let ([x, y, z], [a, b, c]) = (at, senses);
                        let _ =
                            writeln!(table, "{run}{sense},A,{name},{x:.4},{y:.4},{z:.4},{a},{b},{c},-150,{value:.4}");
                    }
                }
            }
        }
        let shop = Shop::new().file("m.toml", bare("demo")).file("d.csv", table).file("d.toml", LINE);
        let report = report(&run(&shop, &["d.csv".to_owned()], "m.toml", &[]));
        let all = findings(&report);
        for one in &all {
            let most = if one["unit"] == "urad" { 10_000.0 } else { 1000.0 };
            assert!(number(one, "value").abs() < most, "{one:#}");
        }
        let scale = all.iter().find(|one| name(one) == "motion EZZ").unwrap_or_else(|| panic!("{report:#}"));
        assert!((number(scale, "value") - 12.0).abs() < 2.0 * number(scale, "u95"), "{scale:#}");
    }
}

#[test]
fn a_plate_that_is_reached_from_one_side_shows_a_scale_and_no_play() {
    for seed in 1..4 {
        // Rows to and fro along X, the next row always further along Y: 29 µm/m, and half a play of 3 µm behind every motion of Y.
        let mut random = Random::new(seed, "one side");
        let mut table = "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_z_mm,dx_um,dy_um\n".to_owned();
        for row in 0..8 {
            for hole in 0..8 {
                let hole = if row % 2 == 0 { hole } else { 7 - hole };
                let [x, y] = [175.0 + 50.0 * f64::from(hole), 75.0 + 50.0 * f64::from(row)];
                let (along, across) = (if row % 2 == 0 { 1 } else { -1 }, i32::from(row > 0));
                let dy = 0.029 * y - 1.5 * f64::from(across) + 0.6 * random.normal();
                let dx = 0.6 * random.normal();
                let _ = writeln!(table, "1,A,{x},{y},200,{along},{across},-1,-120,{dx:.4},{dy:.4}");
            }
        }
        let (_, report) = found(&table, PLATE, &[]);
        let all = findings(&report);
        assert!(all.iter().all(|one| one["effect"] != "backlash"), "{report:#}");
        let scale = all.iter().find(|one| name(one) == "motion EYY").unwrap_or_else(|| panic!("{report:#}"));
        // 10.15 µm over 350 mm; the first row, from where nothing is known, takes up to 1.5 µm off them.
        let um = number(scale, "value") * if scale["unit"] == "um" { 1.0 } else { 0.35 };
        assert!((8.0..10.8).contains(&um), "{scale:#}");
    }
}
