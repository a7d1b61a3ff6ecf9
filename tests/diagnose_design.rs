//! Causes that the design of a measurement cannot separate: the alignment of straightness optics, the sign of one of two files, a drift in runs of one
//! direction, an angle at one height. The readings are made by formulas of their own.

use std::f64::consts::PI;
use std::fmt::Write as _;

use serde_json::Value;

use crate::diagnose::{findings, name, number, report, run};
use crate::plant::Random;
use crate::support::{Run, Shop};

const LINE: &str = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.3\n";
/// A gantry that carries the tool along X: a squareness is then a slope of what a straightness reads.
const GANTRY: &str = "[machine]\nname = \"gantry\"\ntopology = \"wYFXZSt\"\n\
                      [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n\
                      [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 500]\n\
                      [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-50, 450]\n";
/// Targets with uneven steps, mm.
const UNEVEN: [f64; 13] = [10.0, 71.0, 118.0, 190.0, 236.0, 301.0, 344.0, 419.0, 470.0, 521.0, 588.0, 629.0, 690.0];

/// Readings of a component along X: runs of these ways at some targets and a height, µm by position, way and number of the reading in its run.
fn line(
    seed: u64,
    (component, z): (&str, f64),
    (targets, runs): (&[f64], &[f64]),
    um: impl Fn(f64, f64, usize) -> f64,
) -> String {
    let mut random = Random::new(seed, component);
    let mut table = "run,setup,component,X,Y,Z,X_dir,Y_dir,Z_dir,tool_z_mm,value_um\n".to_owned();
    for (run, way) in runs.iter().enumerate() {
        for k in 0..targets.len() {
            let x = targets[if *way > 0.0 { k } else { targets.len() - 1 - k }];
            let value = um(x, *way, k) + 0.3 * random.normal();
            let _ = writeln!(table, "{run},A,{component},{x},250,{z},{way},0,0,-60,{value:.4}");
        }
    }
    table
}

/// Files a, b, c … with one description, in this order.
fn shop(tables: &[&str], description: &str) -> (Shop, Vec<String>) {
    let mut shop = Shop::new().file("m.toml", GANTRY);
    let mut files = Vec::new();
    for (table, stem) in tables.iter().zip(["a", "b", "c"]) {
        shop = shop.file(&format!("{stem}.csv"), table).file(&format!("{stem}.toml"), description);
        files.push(format!("{stem}.csv"));
    }
    (shop, files)
}

/// A diagnosis that may write.
fn diagnosed(tables: &[&str], description: &str) -> (Shop, Run, Value) {
    let (shop, files) = shop(tables, description);
    let run = run(&shop, &files, "m.toml", &["-o", "out.toml"]);
    let report = report(&run);
    (shop, run, report)
}

/// The first line of the text.
fn first_line(tables: &[&str], order: &[usize]) -> String {
    let (shop, files) = shop(tables, LINE);
    let files: Vec<String> = order.iter().map(|&k| files[k].clone()).collect();
    let words = ["diagnose".to_owned()].into_iter().chain(files);
    let run = shop.run(words.chain(["--machine", "m.toml"].map(str::to_owned)));
    run.stdout.lines().next().unwrap_or_default().to_owned()
}

#[test]
fn the_slope_of_straightness_optics_is_no_squareness_without_a_square() {
    for seed in 1..=3 {
        // A bow of 6 µm, which has no slope, and optics at 60 µrad.
        let table = line(seed, ("EYX", 200.0), (&UNEVEN, &[1.0, -1.0, 1.0, -1.0]), |x, _, _| {
            0.06 * x + 6.0 * (PI * x / 700.0).sin()
        });
        let with = |key: &str| format!("{LINE}{key}\n");
        for (description, is_named) in [
            (LINE.to_owned(), true),
            (with("reference = \"straightedge\""), false),
            (LINE.replace("\"offset\"", "\"offset\", \"slope\""), false),
        ] {
            let (shop, run, report) = diagnosed(&[&table], &description);
            assert_eq!(run.codes().contains(&"W0612".to_owned()), is_named, "{run:?}");
            let all = findings(&report);
            assert!(all.iter().all(|one| one["effect"] != "location"), "{report:#}");
            let bow = all.iter().find(|one| name(one) == "motion EYX").unwrap_or_else(|| panic!("{report:#}"));
            assert!((number(bow, "value").abs() - 6.0).abs() < 1.0 && bow["extends"] == true, "{bow:#}");
            assert!(!shop.text("out.toml").contains("C0"), "{}", shop.text("out.toml"));
            if is_named {
                assert!(run.stderr.is_empty() || run.stderr.contains("60"), "{run:?}");
            }
        }
        // Along a square, the slope is that of the machine.
        let (shop, run, report) = diagnosed(&[&table], &with("reference = \"square\""));
        let square = findings(&report).into_iter().find(|one| one["effect"] == "location");
        let square = square.unwrap_or_else(|| panic!("{report:#}"));
        assert!((number(&square, "value").abs() - 60.0).abs() < number(&square, "u95"), "{square:#}");
        assert!(square["certain"] == true && square["extends"] == true, "{square:#}");
        assert!(shop.text("out.toml").contains("C0") && !run.codes().contains(&"W0612".to_owned()), "{run:?}");
    }
}

#[test]
fn a_square_has_no_free_alignment_and_other_kinds_have_no_reference() {
    let table = line(1, ("EYX", 200.0), (&UNEVEN, &[1.0]), |_, _, _| 0.0);
    let both = LINE.replace("\"offset\"", "\"offset\", \"slope\"") + "reference = \"square\"\n";
    let wrong = format!("{LINE}reference = \"table\"\n");
    let bar = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\"]\nreference = \"square\"\n";
    for (description, text) in
        [(both.as_str(), "square is exact"), (wrong.as_str(), "unknown reference"), (bar, "reference")]
    {
        let (shop, files) = shop(&[&table], description);
        let run = shop.run(["diagnose", &files[0], "--machine", "m.toml"]);
        assert!(run.code != 0 && run.stderr.contains(text), "{text}: {run:?}");
    }
}

#[test]
fn two_files_of_opposite_signs_contradict_each_other_and_a_third_decides() {
    let ways = [1.0, -1.0, 1.0, -1.0];
    for seed in 1..=2 {
        // 20 µm/m and 6 µm of backlash.
        let of = |seed: u64, z: f64, sign: f64| {
            line(seed, ("EXX", z), (&UNEVEN, &ways), |x, way, _| sign * (0.02 * x - 3.0 * way))
        };
        let [one, other, third] = [of(seed, 200.0, 1.0), of(seed + 10, 100.0, -1.0), of(seed + 20, 300.0, 1.0)];
        for order in [[0, 1], [1, 0]] {
            let said = first_line(&[&one, &other], &order);
            let start = ["a and b", "b and a"][order[0]];
            assert!(said.starts_with(&format!("{start} contradict each other in sign: ")), "{said}");
            for error in ["motion EXX", "backlash EXX"] {
                assert!(said.contains(error), "{said}");
            }
        }
        let (_, _, report) = diagnosed(&[&one, &other], LINE);
        assert_eq!(report["contradiction"]["one_of"], serde_json::json!(["a", "b"]), "{report:#}");
        assert!(findings(&report).iter().all(|one| one["certain"] == false && one["extends"] == false), "{report:#}");
        for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
            let said = first_line(&[&one, &other, &third], &order);
            assert!(said.starts_with("b contradicts ") && said.contains("agree with each other"), "{said}");
            assert!(said.contains("a and c") || said.contains("c and a"), "{said}");
        }
        // Equal signs contradict nothing.
        let same = of(seed + 30, 100.0, 1.0);
        let (_, _, report) = diagnosed(&[&one, &same], LINE);
        assert!(report["contradiction"].is_null(), "{report:#}");
    }
}

#[test]
fn a_drift_in_each_run_of_one_direction_is_no_scale_to_correct() {
    let even: Vec<f64> = (0..13).map(|k| 30.0 + 50.0 * f64::from(k)).collect();
    let up = [1.0, 1.0, 1.0];
    for seed in 1..=4 {
        // 0.5 µm per reading, from zero in each run; the scale of 10 µm/m has the same readings at even steps.
        let drift: fn(f64, f64, usize) -> f64 = |_, _, k| 0.5 * k as f64;
        let scale: fn(f64, f64, usize) -> f64 = |x, _, _| 0.01 * (x - 30.0);
        for um in [drift, scale] {
            let (shop, _, report) = diagnosed(&[&line(seed, ("EXX", 200.0), (&even, &up), um)], LINE);
            let all = findings(&report);
            assert!(!all.is_empty() && !shop.path("out.toml").exists(), "{report:#}");
            for one in &all {
                assert!(one["certain"] == false && number(one, "probability") < 0.9, "{one:#}");
                let rivals = one["rivals"].to_string();
                let other = if name(one) == "drift X" { "motion EXX" } else { "drift X" };
                assert!(rivals.contains(other), "{other}: {one:#}");
            }
        }
        // At uneven steps the two differ a little: what is written is never the scale.
        let table = line(seed, ("EXX", 200.0), (&UNEVEN, &up), |_, _, k| 0.5 * k as f64);
        let (_, _, report) = diagnosed(&[&table], LINE);
        assert!(findings(&report).iter().all(|one| one["extends"] == false), "{report:#}");
        // Back and forth, the scale is certain.
        let table = line(seed, ("EXX", 200.0), (&even, &[1.0, -1.0, 1.0, -1.0]), |x, _, _| 0.01 * x);
        let (shop, _, report) = diagnosed(&[&table], LINE);
        let all = findings(&report);
        assert!(all.len() == 1 && name(&all[0]) == "motion EXX" && all[0]["certain"] == true, "{report:#}");
        assert!(shop.path("out.toml").exists(), "{report:#}");
    }
}

#[test]
fn a_scale_at_one_height_says_what_a_pitch_would_change() {
    let ways = [1.0, -1.0, 1.0, -1.0];
    let of = |seed: u64, z: f64| line(seed, ("EXX", z), (&UNEVEN, &ways), |x, _, _| 0.03 * x);
    let low = of(1, 100.0);
    let (_, _, report) = diagnosed(&[&low], LINE);
    let scale = &findings(&report)[0];
    assert!(name(scale) == "motion EXX" && scale["arm"]["cause"] == "motion EBX", "{scale:#}");
    // 20 µm over the travel, at an arm of 40 mm; 400 mm higher the pitch would be ten times as large.
    assert!(number(&scale["arm"], "difference_um") > number(scale, "rms_um"), "{scale:#}");
    let (shop, files) = shop(&[&low], LINE);
    let text = shop.run(["diagnose", &files[0], "--machine", "m.toml"]).stdout;
    assert!(text.contains("if it is motion EBX instead"), "{text}");
    // A second height separates them.
    let (_, _, report) = diagnosed(&[&low, &of(2, 350.0)], LINE);
    let scale = &findings(&report)[0];
    assert!(name(scale) == "motion EXX" && scale["arm"].is_null(), "{scale:#}");
}

#[test]
fn a_straightedge_read_as_a_displacement_may_be_turned_and_a_square_may_not() {
    for seed in 1..=2 {
        // 60 µrad without a bow.
        let table = line(seed, ("EYX", 200.0), (&UNEVEN, &[1.0, -1.0, 1.0, -1.0]), |x, _, _| 0.06 * x);
        let table = table.replace(",component,", ",").replace(",EYX,", ",").replace("value_um", "dy_um");
        let description = LINE.replace("direct", "displacement");
        let (shop, _, report) = diagnosed(&[&table], &description);
        for one in findings(&report).iter().filter(|one| one["effect"] == "location") {
            assert!(one["certain"] == false && one["rivals"].to_string().contains("setup rotation"), "{one:#}");
        }
        assert!(!shop.path("out.toml").exists(), "{report:#}");
        let (shop, _, report) = diagnosed(&[&table], &format!("{description}reference = \"square\"\n"));
        let square = findings(&report).into_iter().find(|one| one["effect"] == "location");
        assert!(square.is_some_and(|one| one["certain"] == true) && shop.path("out.toml").exists(), "{report:#}");
    }
}

#[test]
fn of_two_lasers_with_different_scales_neither_is_known_to_be_right() {
    let ways = [1.0, -1.0, 1.0, -1.0];
    let of = |seed: u64, scale: f64| line(seed, ("EXX", 200.0), (&UNEVEN, &ways), |x, _, _| scale * x);
    for seed in 1..=2 {
        let (shop, _, report) = diagnosed(&[&of(seed, 0.02), &of(seed + 10, 0.05)], LINE);
        let scales = || findings(&report).into_iter().filter(|one| name(one) == "motion EXX");
        assert!(scales().all(|one| one["certain"] == false && one["extends"] == false), "{report:#}");
        assert!(!shop.path("out.toml").exists() || !shop.text("out.toml").contains("EXX"), "{report:#}");
        // A third one decides.
        let (_, _, report) = diagnosed(&[&of(seed, 0.02), &of(seed + 10, 0.05), &of(seed + 20, 0.02)], LINE);
        let scale = findings(&report).into_iter().find(|one| name(one) == "motion EXX");
        let scale = scale.unwrap_or_else(|| panic!("{report:#}"));
        assert!((number(&scale, "value").abs() - 20.0).abs() < 2.0 && scale["certain"] == true, "{report:#}");
    }
}
