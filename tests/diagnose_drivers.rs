//! `ncfix diagnose` where an error depends on more than a smooth function of places: it acts only beyond a position, or follows the speed of the spindle. The readings come from closed
//! formulas that share no code with the search; the file that is written must be one that `fix` accepts.

use std::fmt::Write as _;

use serde_json::Value;

use crate::diagnose::{findings, name, number};
use crate::plant::Random;
use crate::support::Shop;

/// The tool goes with all axes, so a displacement of an axis is one of the tool.
const MACHINE: &str = "[machine]\nname = \"gantry\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 600]\nmax_feed_mm_min = 12000\n\
    [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\nmax_feed_mm_min = 12000\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-350, 60]\nmax_feed_mm_min = 12000\n\
    [[tool]]\nnumber = 1\nlength_mm = 120\nradius_mm = 5\n";
const GRID: &str = "[measurement]\nkind = \"displacement\"\nsigma_um = 0.7\nfree = [\"offset\"]\n";

/// A grid of lines along X, twice: `error` in mm gives the displacement by X and Y, µm.
fn grid(seed: u64, error: impl Fn(f64, f64) -> [f64; 3]) -> String {
    let mut random = Random::new(seed, "grid");
    let mut table = "setup,run,X,Y,Z,X_dir,Y_dir,Z_dir,tool_x_mm,tool_y_mm,tool_z_mm,dx_um,dy_um,dz_um\n".to_owned();
    for run in 0..2 {
        for z in [-300.0, -100.0] {
            for j in 0..7 {
                for i in 0..13 {
                    let [x, y] = [50.0 * f64::from(i), 60.0 * f64::from(j)];
                    let [dx, dy, dz] = error(x, y).map(|um| um + 0.7 * random.normal());
                    let _ = writeln!(table, "S1,r{run},{x},{y},{z},1,1,1,0,0,-120,{dx:.4},{dy:.4},{dz:.4}");
                }
            }
        }
    }
    table
}

fn diagnosed(train: String, hold: String, description: &str) -> (Shop, Value) {
    let shop = Shop::new().file("m.toml", MACHINE).file("t.csv", train).file("t.toml", description);
    let shop = shop.file("h.csv", hold).file("h.toml", description);
    let call = ["diagnose", "t.csv", "--machine", "m.toml", "--holdout", "h.csv", "-o", "out.toml", "--json"];
    let report = shop.run(call).json();
    (shop, report)
}

#[test]
fn an_error_that_begins_at_a_position_is_named_with_it_and_fix_accepts_the_file() {
    // EXX grows with the square of Y where X is beyond 425 mm: 11.2 µm at Y 360.
    let law = |x: f64, y: f64| [if x > 425.0 { 11.2 * (y / 360.0).powi(2) } else { 0.0 }, 0.0, 0.0];
    let (shop, report) = diagnosed(grid(1, law), grid(2, law), GRID);
    let all = findings(&report);
    let first = all.first().unwrap_or_else(|| panic!("{report:#}"));
    assert_eq!((name(first).as_str(), all.len()), ("cross EXX", 1), "{report:#}");
    assert_eq!(first["threshold_axis"], "X");
    assert_eq!(first["threshold_mm"], serde_json::json!([400.0, 450.0]));
    // The machine carries the tool: the sign is that of the readings, and the largest is 11.2 µm.
    assert!((number(first, "value").abs() - 11.2).abs() < number(first, "u95").max(0.3), "{first:#}");
    assert_eq!(first["extends"], true, "{first:#}");
    assert!(number(&report["written"], "holdout_after_rms_um") < 0.75, "{:#}", report["written"]);
    let program = "G90 G17 G71 G40 G500 T1 D1 M6\nG0 X100 Y0 Z-100\nG1 X600 Y360 F1000\nM30\n";
    let shop = shop.file("p.mpf", program);
    shop.run(["fix", "p.mpf", "--machine", "out.toml", "-o", "q.mpf"]).exits(0);
}

/// A log of one pose over six hours: the spindle turns and rests by a plan, and the readings follow by `move_um` and its time constant, and at once by the square of the speed.
fn log(seed: u64, [lagged_um, lag_s, at_once_um]: [f64; 3]) -> String {
    let mut random = Random::new(seed, "spindle");
    let mut table = "run,setup,t_s,X,Y,Z,tool_z_mm,spindle_rpm,dx_um,dy_um,dz_um\n".to_owned();
    let (mut heat, mut before) = (0.0, 0.0);
    let plan = [0.0, 6000.0, 12000.0, 3000.0, 0.0, 9000.0, 0.0, 12000.0];
    for minute in 0..360_usize {
        let speed = plan[(minute / 30 + usize::from(seed > 1) * (minute / 45)) % plan.len()];
        // A body of the first order, in steps of one second; the speed changes with the reading.
        for _ in 0..if minute == 0 { 0 } else { 60 } {
            heat += (before - heat) / lag_s;
        }
        before = speed;
        let dz = lagged_um * heat / 12000.0 + at_once_um * (speed / 12000.0).powi(2) + 0.3 * random.normal();
        let [dx, dy] = [0.3 * random.normal(), 0.3 * random.normal()];
        let _ = writeln!(table, "r1,A,{},300,200,-100,-120,{speed},{dx:.4},{dy:.4},{dz:.4}", 60 * minute);
    }
    table
}

#[test]
fn displacements_with_the_spindle_speed_are_named_at_once_and_later() {
    let description = "[measurement]\nkind = \"displacement\"\nsigma_um = 0.3\nfree = [\"offset\"]\n";
    for (sizes, lags) in [([30.0, 1500.0, 0.0], vec![1500.0]), ([0.0, 1500.0, 6.0], vec![0.0])] {
        let (_, report) = diagnosed(log(1, sizes), log(2, sizes), description);
        let all = findings(&report);
        assert!(all.iter().all(|one| name(one) == "spindle-speed Z"), "{report:#}");
        let found: Vec<f64> = all.iter().map(|one| number(one, "lag_s")).collect();
        assert_eq!(found.len(), lags.len(), "{report:#}");
        // Readings stand a minute apart.
        assert!(
            found.iter().zip(&lags).all(|(found, lag)| (found - lag).abs() <= 0.05 * lag),
            "{found:?} for {lags:?}"
        );
    }
}
