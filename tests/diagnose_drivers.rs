//! `ncfix diagnose` where an error depends on more than a smooth function of places: it acts only beyond a position, or follows the speed of the spindle. The readings come from closed
//! formulas that share no code with the search; the file that is written must be one that `fix` accepts.

use std::fmt::Write as _;

use ncfix::prelude::{AxisVector, Machine, State, ToolVector};
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
    grid_at_heights(seed, |_| "S1".to_owned(), |x, y, _| error(x, y))
}

/// Such a grid with set-ups by height, and an error that depends on the height too.
fn grid_at_heights(seed: u64, setup: impl Fn(f64) -> String, error: impl Fn(f64, f64, f64) -> [f64; 3]) -> String {
    let mut random = Random::new(seed, "grid");
    let mut table = "setup,run,X,Y,Z,X_dir,Y_dir,Z_dir,tool_x_mm,tool_y_mm,tool_z_mm,dx_um,dy_um,dz_um\n".to_owned();
    for run in 0..2 {
        for z in [-300.0, -100.0] {
            for j in 0..7 {
                for i in 0..13 {
                    let [x, y] = [50.0 * f64::from(i), 60.0 * f64::from(j)];
                    let [dx, dy, dz] = error(x, y, z).map(|um| um + 0.7 * random.normal());
                    let _ = writeln!(table, "{},r{run},{x},{y},{z},1,1,1,0,0,-120,{dx:.4},{dy:.4},{dz:.4}", setup(z));
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

/// Positioning tests of all axes with one reversal value, that of X, µm; the other axes show noise alone.
fn positioning(seed: u64, reversal_um: f64) -> String {
    let mut random = Random::new(seed, "laser");
    let mut table = "setup,run,component,X,Y,Z,X_dir,Y_dir,Z_dir,value_um\n".to_owned();
    // Targets at uneven distances (ISO 230-2, 5.3).
    let targets = [7.0, 41.0, 88.0, 120.0, 171.0, 203.0, 246.0, 290.0, 331.0, 377.0];
    for (component, axis) in [("EXX", 0), ("EYY", 1), ("EZZ", 2)] {
        for run in 0..5 {
            for side in [1, -1] {
                for k in 0..targets.len() {
                    let target = targets[if side > 0 { k } else { targets.len() - 1 - k }];
                    let mut at = [200.0, 200.0, -100.0];
                    at[axis] = if axis == 2 { -300.0 + 0.8 * target } else { target };
                    let mut senses = [1; 3];
                    senses[axis] = side;
                    let own = if axis == 0 { 0.5 * reversal_um * f64::from(side) } else { 0.0 };
                    let value = own + 0.3 * random.normal();
                    let ([x, y, z], [a, b, c]) = (at, senses);
                    let _ = writeln!(table, "{component},r{run},{component},{x},{y},{z},{a},{b},{c},{value:.4}");
                }
            }
        }
    }
    table
}

#[test]
fn one_axis_of_three_is_corrected_though_the_others_are_quiet() {
    let description = "[measurement]\nkind = \"direct\"\nsigma_um = 0.3\nfree = [\"offset\"]\n";
    for (seed, reversal_um) in [(3, -8.0), (4, 8.0)] {
        let (shop, report) =
            diagnosed(positioning(seed, reversal_um), positioning(seed + 10, reversal_um), description);
        let all = findings(&report);
        assert_eq!(all.iter().map(name).collect::<Vec<_>>(), ["backlash EXX"], "{report:#}");
        assert!((number(&all[0], "value") - reversal_um).abs() < number(&all[0], "u95").max(0.15), "{report:#}");
        // The noise of the readings is all that stays.
        assert!(all[0]["extends"] == true && number(&report["written"], "after_rms_um") < 0.33, "{report:#}");
        assert!(shop.path("out.toml").exists());
    }
}

#[test]
fn an_angle_that_is_written_has_no_mean_over_the_travel() {
    // Pitch about Y that grows along X, seen by its arm in Z. The plate is mounted anew at each height: nothing is known of the squareness of X and Z.
    let pitch = |x: f64| 40e-6 * x / 600.0;
    let law = |x: f64, _: f64, z: f64| [1e3 * pitch(x) * (z - 120.0), 0.0, 0.0];
    let at_heights = |seed| grid_at_heights(seed, |z| format!("S{z}"), law);
    let description = "[measurement]\nkind = \"displacement\"\nsigma_um = 0.7\nfree = [\"offset\", \"rotation\"]\n";
    let (shop, report) = diagnosed(at_heights(5), at_heights(6), description);
    assert_eq!(report["findings"][0]["effect"], "motion", "{report:#}");
    let name = report["findings"][0]["parameter"].as_str().unwrap().to_owned();
    let text = shop.text("out.toml");
    let machine = Machine::from_text("out.toml", &text).unwrap();
    // A rotation of the tool about Y by the model of the file, over the travel that was measured.
    let mean: f64 = (0..=60)
        .map(|k| {
            let pose: AxisVector = format!("X{},Y180,Z-200", 10 * k).parse().unwrap();
            machine.deviation(&pose, ToolVector::Length(120.0), &State::default()).rotation_urad[1]
        })
        .sum::<f64>()
        / 61.0;
    // It would be 20 µrad if the angle began at zero.
    assert!(name == "EBX" && mean.abs() < 1.5, "{name}: {mean}\n{text}");
}
