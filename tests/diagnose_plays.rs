//! What one ball-bar at one height shows of plays: a turn of the carriage that is seen at one arm is no more than a plain play.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::cli_calibrate::bare;
use crate::diagnose::{findings, name, number, report, run};
use crate::plant::Random;
use crate::support::Shop;

const CIRCLE: &str = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\", \"length\"]\nsigma_um = 0.6\n\
                      [setup.A]\ncentre_mm = [350, 250, 100]\nlength_mm = 150\n";

/// Two circles of 150 mm in XY in each sense; readings are errors of X and Y along the bar, µm, by the sense of motion.
fn circle(seed: u64, error: impl Fn([f64; 2]) -> [f64; 2]) -> String {
    let mut random = Random::new(seed, "circle");
    let mut table = "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_z_mm,dr_um\n".to_owned();
    for (run, sense) in [(1, 1.0), (2, -1.0), (3, 1.0), (4, -1.0)] {
        for k in 0..90 {
            let angle: f64 = sense * TAU * f64::from(k) / 90.0;
            let [cos, sin] = [angle.cos(), angle.sin()];
            let senses = [if sense * sin > 0.0 { -1.0 } else { 1.0 }, if sense * cos < 0.0 { -1.0 } else { 1.0 }];
            let ([x, y], [dx, dy]) = ([350.0 + 150.0 * cos, 250.0 + 150.0 * sin], error(senses));
            let dr = dx * cos + dy * sin + 0.6 * random.normal();
            let [a, b] = senses;
            let _ = writeln!(table, "{run},A,{x:.6},{y:.6},220,{a},{b},0,-120,{dr:.4}");
        }
    }
    table
}

#[test]
fn plays_of_two_axes_are_no_turn_of_a_carriage() {
    let mut inside = 0;
    for seed in 1..=8 {
        // 5 and 3 µm between the senses.
        let table = circle(seed, |[x, y]| [2.5 * x, -1.5 * y]);
        let shop = Shop::new().file("m.toml", bare("demo")).file("d.csv", table).file("d.toml", CIRCLE);
        let report = report(&run(&shop, &["d.csv".to_owned()], "m.toml", &[]));
        let mut all = findings(&report);
        all.sort_by_key(name);
        let names: Vec<String> = all.iter().map(name).collect();
        assert_eq!(names, ["backlash EXX", "backlash EYY"], "seed {seed}: {report:#}");
        for (one, truth) in all.iter().zip([5.0, 3.0]) {
            let [value, u95] = ["value", "u95"].map(|key| number(one, key));
            assert_eq!(one["correctable"], "program", "seed {seed}: {one:#}");
            assert!(u95 < 1.0, "seed {seed}: {one:#}");
            inside += u32::from((value.abs() - truth).abs() < u95);
        }
    }
    // Of sixteen that are each within their interval by 95 %, three or more miss theirs with a chance of 4 %.
    assert!(inside >= 14, "{inside} of 16");
}
