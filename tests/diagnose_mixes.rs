//! Ordinary mixes of errors through the command: what a ball-bar finds on a fresh machine, friction at reversals, an artifact of another length, a machine
//! that changed between two files. The readings come from closed formulas that share no code with the search.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use serde_json::Value;

use crate::cli_calibrate::bare;
use crate::diagnose::{findings, name, number, report, run};
use crate::explain::{DESCRIPTION, Plant};
use crate::plant::Random;
use crate::support::Shop;

/// Diagnoses files `NAME.csv`, which have one description, on the bare demo machine, and writes `out.toml`.
fn diagnosed(tables: &[(&str, String)], description: &str) -> (Shop, Value) {
    let mut shop = Shop::new().file("m.toml", bare("demo"));
    let mut names = Vec::new();
    for (name, table) in tables {
        shop = shop.file(&format!("{name}.csv"), table.clone()).file(&format!("{name}.toml"), description);
        names.push(format!("{name}.csv"));
    }
    let report = report(&run(&shop, &names, "m.toml", &["-o", "out.toml"]));
    (shop, report)
}

/// Names of the findings, sorted.
fn names(report: &Value) -> Vec<String> {
    let mut names: Vec<String> = findings(report).iter().map(name).collect();
    names.sort();
    names
}

/// A finding by its name.
fn one(report: &Value, wanted: &str) -> Value {
    findings(report).into_iter().find(|one| name(one) == wanted).unwrap_or_else(|| panic!("{wanted}: {report:#}"))
}

#[test]
fn a_fresh_machine_on_a_ball_bar_is_named_and_corrected_whole() {
    // Squareness of all pairs, scales and one, two or three reversal values; µrad, µm/m, µm.
    let mixes: [([f64; 3], [f64; 3], [f64; 3]); 5] = [
        ([28.0, -41.0, 19.0], [0.0; 3], [0.0, 7.0, 0.0]),
        ([0.0; 3], [24.0, 35.0, 30.0], [4.0, 7.0, 0.0]),
        ([0.0; 3], [0.0; 3], [4.0, 4.0, 4.0]),
        ([40.0, 35.0, -50.0], [30.0, -25.0, 20.0], [6.0, 0.0, 5.0]),
        ([30.0, 0.0, 0.0], [0.0; 3], [5.0, 5.0, 0.0]),
    ];
    let (mut inside, mut all, mut extended) = (0, 0, 0);
    for (number_of_mix, (squareness, scale, backlash)) in (0_u64..).zip(mixes) {
        let plant = Plant {
            squareness: squareness.map(|urad| urad * 1e-6),
            scale: scale.map(|um_per_m| um_per_m * 1e-6),
            backlash: backlash.map(|um| um * 1e-3),
        };
        let (shop, report) = diagnosed(&[("d", plant.measured(20 + number_of_mix))], DESCRIPTION);
        let mut truth: Vec<(String, f64)> = Vec::new();
        truth.extend(["EC0X", "EB0Z", "EA0Z"].iter().zip(squareness).map(|(n, v)| (format!("location {n}"), v)));
        truth.extend(["EXX", "EYY", "EZZ"].iter().zip(scale).map(|(n, v)| (format!("motion {n}"), v)));
        truth.extend(["EXX", "EYY", "EZZ"].iter().zip(backlash).map(|(n, v)| (format!("backlash {n}"), v)));
        truth.retain(|(_, size)| *size != 0.0);
        truth.sort_by(|a, b| a.0.cmp(&b.0));
        let wanted: Vec<&str> = truth.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names(&report), wanted, "{number_of_mix}: {report:#}");
        for (wanted, size) in &truth {
            let found = one(&report, wanted);
            assert_eq!(found["extends"] == true, number(&found, "probability") >= 0.95, "{number_of_mix}: {found:#}");
            extended += u32::from(found["extends"] == true);
            all += 1;
            inside += u32::from((number(&found, "value").abs() - size.abs()).abs() < number(&found, "u95"));
        }
        // The noise of the instrument is 0.5 µm; a cause with a probability below 95 % stays.
        let written = &report["written"];
        let held: Vec<Value> = findings(&report).into_iter().filter(|one| one["extends"] == true).collect();
        let limit_um = if held.len() == truth.len() { 0.55 } else { 0.7 };
        assert!(shop.path("out.toml").exists() && number(written, "after_rms_um") < limit_um, "{written:#}");
        assert!(number(written, "before_rms_um") > 1.0 && number(written, "causes") == held.len() as f64);
    }
    assert!(extended >= 21, "{extended} of {all}");
    // Of 23 sizes that are each within their interval by 95 %, four or more are outside with a probability of 3 %.
    assert!(all == 23 && inside >= 20, "{inside} of {all}");
}

/// Circles of 150 mm in XY in both senses, every two degrees from the turning point of X: friction holds X after each turn by 6 µm, and it is gone after some 3 mm.
fn circle_with_spikes(seed: u64) -> String {
    let mut random = Random::new(seed, "spikes");
    let mut table = "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_z_mm,feed_mm_min,dr_um\n".to_owned();
    for (run, sense) in [(1, 1.0), (2, -1.0), (3, 1.0), (4, -1.0)] {
        for k in 0..720 {
            let turned = TAU * f64::from(k) / 720.0;
            let angle = sense * turned;
            let [cos, sin] = [angle.cos(), angle.sin()];
            // A row at a turning point has no sense.
            let sign = |value: f64| if value.abs() < 1e-9 { 0.0 } else { value.signum() };
            let senses = [sign(-sense * sin), sign(sense * cos)];
            // It turns at 0 and at half a turn; the body lags against its sense.
            let way = 150.0 * turned.rem_euclid(TAU / 2.0);
            let held = -6.0 * senses[0] * (-way / 3.0).exp();
            // The error of the table moves the tool the other way.
            let dr = -held * cos + 0.5 * random.normal();
            let [x, y] = [350.0 + 150.0 * cos, 250.0 + 150.0 * sin];
            let [a, b] = senses;
            let _ = writeln!(table, "{run},A,{x:.6},{y:.6},220,{a},{b},0,-120,1000,{dr:.4}");
        }
    }
    table
}

#[test]
fn spikes_are_found_where_rows_lie_on_the_turning_points_and_circles_begin_there() {
    let description = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\", \"length\"]\nsigma_um = 0.5\n\
                       [setup.A]\ncentre_mm = [350, 250, 100]\nlength_mm = 150\n";
    for seed in [1, 2] {
        let (_, report) = diagnosed(&[("d", circle_with_spikes(seed))], description);
        assert_eq!(names(&report), ["reversal-spike X"], "{report:#}");
        let found = one(&report, "reversal-spike X");
        assert!((number(&found, "value").abs() - 6.0).abs() < 1.0, "{found:#}");
        assert!(findings(&report).iter().all(|one| one["correctable"] != "program"), "{report:#}");
    }
}

/// Hole plates: 6 × 5 holes every 80 mm in four mountings, errors of the readings by mounting and place, µm.
fn plates(seed: u64, error: impl Fn(usize, [f64; 2]) -> [f64; 2]) -> String {
    let mut random = Random::new(seed, "plates");
    let mut table = "run,setup,X,Y,Z,tool_z_mm,dx_um,dy_um\n".to_owned();
    for mounting in 0..4 {
        for (i, k) in (0..30).map(|n| (n % 6, n / 6)) {
            let at = [150.0 + 80.0 * f64::from(i), 90.0 + 80.0 * f64::from(k)];
            let [dx, dy] = error(mounting, at).map(|um| um + 0.7 * random.normal());
            let _ = writeln!(table, "r{mounting},S{mounting},{:.3},{:.3},200,-120,{dx:.4},{dy:.4}", at[0], at[1]);
        }
    }
    table
}

#[test]
fn an_artefact_of_another_length_is_no_error_of_the_machine() {
    let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\nsigma_um = 0.7\n";
    for (seed, off) in [(1, -32.0), (2, 25.0)] {
        // The second one of four plates is longer or shorter in all directions.
        let table = plates(seed, |mounting, at| at.map(|mm| if mounting == 1 { off * 1e-3 * mm } else { 0.0 }));
        let (shop, report) = diagnosed(&[("d", table)], description);
        assert_eq!(names(&report), ["setup scale S1"], "{report:#}");
        let found = one(&report, "setup scale S1");
        assert!(found["unit"] == "um/m" && (number(&found, "value") - off).abs() < number(&found, "u95").max(1.0));
        assert!(!shop.path("out.toml").exists(), "an instrument is no machine: {found:#}");
    }
}

#[test]
fn a_scale_of_one_mounting_is_found_beside_a_scale_of_the_machine() {
    let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\nsigma_um = 0.7\n";
    // Readings along X grow by 12 µm/m, and by 25 µrad times Y; the second plate differs by −20 µm/m in both directions. The table moves along X, so
    // its positioning error is −12 µm/m.
    let table = plates(6, |mounting, [x, y]| {
        let of_plate = if mounting == 1 { -0.020 } else { 0.0 };
        [(0.012 + of_plate) * x + 0.025 * y, of_plate * y]
    });
    let (_, report) = diagnosed(&[("d", table)], description);
    assert_eq!(names(&report), ["location EC0X", "motion EXX", "setup scale S1"], "{report:#}");
    for (wanted, truth) in [("location EC0X", 25.0), ("motion EXX", -12.0), ("setup scale S1", -20.0)] {
        let found = one(&report, wanted);
        assert!((number(&found, "value") - truth).abs() < 1.5 * number(&found, "u95"), "{found:#}");
    }
}

#[test]
fn a_bar_that_was_set_again_in_one_plane_is_no_error_of_the_machine() {
    let plant = Plant { squareness: [25e-6, 0.0, 0.0], scale: [12e-6, 0.0, 0.0], backlash: [0.0; 3] };
    // Each plane has its own mounting with the same bar, which is 3 µm longer in the last one.
    let mut table = String::new();
    for row in plant.measured(30).lines() {
        let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
        if let Some((plane, _)) = row.split_once('-').filter(|(plane, _)| plane.len() == 2) {
            cells[1] = plane.to_owned();
            if plane == "YZ" {
                let dr_um: f64 = cells[9].parse().unwrap();
                cells[9] = format!("{:.5}", dr_um - 3.0);
            }
        }
        let _ = writeln!(table, "{}", cells.join(","));
    }
    let mut description = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\"]\nsigma_um = 0.5\n".to_owned();
    for plane in ["XY", "ZX", "YZ"] {
        let _ = writeln!(description, "[setup.{plane}]\ncentre_mm = [350, 250, 150]\nlength_mm = 100");
    }
    let (_, report) = diagnosed(&[("d", table)], &description);
    assert_eq!(names(&report), ["location EC0X", "motion EXX", "setup length YZ"], "{report:#}");
    let length = one(&report, "setup length YZ");
    assert!((number(&length, "value") + 3.0).abs() < 0.3 && length["extends"] == false, "{length:#}");
}

#[test]
fn a_machine_that_changed_between_two_files_is_corrected_as_it_is_now() {
    let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\nsigma_um = 0.7\n";
    // Squareness X–Y 15 µrad before, −40 µrad after a collision: X is longer by it times Y.
    let file = |seed, urad: f64| plates(seed, move |_, at| [urad * 1e-3 * at[1], 0.0]);
    // Also where two files were measured before it.
    let (shop, report) =
        diagnosed(&[("one", file(3, 15.0)), ("two", file(4, 15.0)), ("three", file(5, -40.0))], description);
    assert_eq!(names(&report), ["earlier EC0X before three", "location EC0X"], "{report:#}");
    assert!(one(&report, "location EC0X")["extends"] == true && shop.path("out.toml").exists(), "{report:#}");
    let (shop, report) = diagnosed(&[("before", file(1, 15.0)), ("after", file(2, -40.0))], description);
    assert_eq!(names(&report), ["earlier EC0X before after", "location EC0X"], "{report:#}");
    let [now, earlier] = ["location EC0X", "earlier EC0X before after"].map(|wanted| one(&report, wanted));
    for (found, truth) in [(&now, -40.0), (&earlier, 55.0)] {
        assert!((number(found, "value") - truth).abs() < number(found, "u95").max(2.0), "{found:#}");
    }
    assert!(now["extends"] == true && earlier["extends"] == false, "{report:#}");
    let written = shop.text("out.toml");
    let line = written.lines().find(|line| line.starts_with("EC0X")).unwrap();
    let value: f64 = line.split('=').nth(1).unwrap().split('#').next().unwrap().trim().parse().unwrap();
    assert!((value + 40.0).abs() < 2.0, "{line}");
}

#[test]
fn a_faultless_machine_on_a_ball_bar_has_no_certain_cause() {
    for seed in 101..=103 {
        let (_, report) = diagnosed(&[("d", Plant::default().measured(seed))], DESCRIPTION);
        assert!(findings(&report).iter().all(|one| one["certain"] == false), "{seed}: {report:#}");
    }
}
