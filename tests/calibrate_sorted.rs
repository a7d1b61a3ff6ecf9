//! Readings of a grid that a program has sorted by position: no direction of approach follows from the order of their rows (W0625).

use std::fmt::Write as _;

use crate::import::Noise;
use crate::support::{Run, Shop};

const MILL: &str = "[machine]\nname = \"bench\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 600]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-300, 0]\n";

/// A grid that was measured to and fro along X, with a reversal value of X. Sorted, its lines all run from the same end. With `has_directions`, the table
/// states them.
fn grid(reversal_um: f64, is_sorted: bool, has_directions: bool) -> String {
    let mut noise = Noise(3);
    let mut all: Vec<(u32, u32, f64, f64)> = Vec::new();
    for line in 0..5 {
        for (way, side) in [(0, 1.0), (1, -1.0)] {
            for number in 0..7 {
                let place = if way == 0 { number } else { 6 - number };
                let um = 12e-3 * f64::from(100 * place) + reversal_um / 2.0 * side + noise.next(0.1);
                all.push((line, place, side, um));
            }
        }
    }
    if is_sorted {
        all.sort_by_key(|&(line, place, side, _)| (line, place, side > 0.0));
    }
    let mut rows = format!("X,Y,Z,{}dx_um\n", if has_directions { "X_dir," } else { "" });
    for (line, place, side, um) in all {
        let side = if has_directions { format!("{side},") } else { String::new() };
        let _ = writeln!(rows, "{},{},0,{side}{um:.3}", 100 * place, 100 * line);
    }
    rows
}

fn calibrate(rows: String, order: &str, more: &str) -> Run {
    let description = format!("[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\n{order}");
    let shop = Shop::new().file("mill.toml", MILL).file("grid.csv", rows).file("grid.toml", description);
    shop.run(format!("calibrate grid.csv --machine mill.toml -o out.toml --json {more}").split_whitespace())
}

/// The fitted half of the reversal value of X, µm.
fn backlash(run: &Run) -> Option<f64> {
    let json = run.json();
    let all = json["parameters"].as_array().unwrap();
    all.iter().find(|one| one["name"] == "EXXb").map(|one| one["value"].as_f64().unwrap())
}

#[test]
fn a_sorted_grid_has_no_backlash() {
    for reversal_um in [0.0, 6.0] {
        let run = calibrate(grid(reversal_um, true, false), "", "").exits(0);
        assert!(run.json().to_string().contains("W0625") && backlash(&run).is_none(), "{}", run.stdout);
        // Stated by a column, sorted or not, and by the rows of the path itself: half of it, without a warning.
        for (is_sorted, has_directions) in [(true, true), (false, true), (false, false)] {
            let run = calibrate(grid(reversal_um, is_sorted, has_directions), "", "").exits(0);
            let found = backlash(&run).unwrap_or_else(|| panic!("{}", run.stdout));
            assert!((found - reversal_um / 2.0).abs() < 0.1, "{found}: {reversal_um}");
            assert!(!run.json().to_string().contains("W0625"), "{}", run.stdout);
        }
    }
}

#[test]
fn the_description_may_state_the_order() {
    let run = calibrate(grid(6.0, true, false), "order = \"unknown\"\n", "").exits(0);
    assert!(backlash(&run).is_none() && !run.json().to_string().contains("W0625"), "{}", run.stdout);
    // Then the first reading of each line counts as approached from the other side.
    let run = calibrate(grid(6.0, true, false), "order = \"motion\"\n", "").exits(0);
    assert!(backlash(&run).is_some() && !run.json().to_string().contains("W0625"), "{}", run.stdout);
}

#[test]
fn a_backlash_that_the_model_states_is_refused_there() {
    let run = calibrate(grid(6.0, true, false), "", "--model EXX1,EXXb");
    assert!(run.stderr.contains("E06") || run.stdout.contains("E06"), "{}{}", run.stdout, run.stderr);
    assert!(run.stderr.contains("W0625") || run.stdout.contains("W0625"), "{}{}", run.stdout, run.stderr);
    // Without a backlash, the directions do not matter.
    let run = calibrate(grid(0.0, true, false), "", "--model EXX1").exits(0);
    assert!(!run.json().to_string().contains("W0625"), "{}", run.stdout);
}
