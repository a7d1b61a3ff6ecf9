//! Duration of a diagnosis of 20,000 readings by the whole program on all cores, and its result: one hidden row of
//! the catalog each, measured by the synthetic machine of the tests. `cargo bench --bench diagnose -- ballbar 03 52`
//! selects benches and rows; a test uses one row and few readings.
#![allow(clippy::unwrap_used, reason = "a bench that cannot be set up has nothing to measure")]
#![allow(clippy::print_stdout, reason = "the figures are what it is for")]
#![allow(dead_code, unused_imports, unreachable_pub, reason = "the plant is that of the tests, which use all of it")]

use std::process::{Command, Stdio};
use std::time::Instant;

use serde_json::Value;

#[path = "../tests/plant/mod.rs"]
mod plant;

use plant::{Bench, Recipe, rows_shown};

/// First row of the catalog that is a fault of the data.
const FIRST_FAULT: u8 = 60;
/// Sampling densities with 20,000 readings of a ball-bar, on the fly, and of the drift of a day.
const BENCHES: [(Bench, f64); 3] = [(Bench::Ballbar, 2.14), (Bench::OnTheFly, 13.92), (Bench::Drift, 43.45)];
/// Sampling density of a test.
const FEW: f64 = 0.12;
/// Size of the hidden effect in units of the noise, and the seed of the noise.
const SIZE: f64 = 5.0;
const SEED: u64 = 2;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).map(|one| one.to_lowercase()).collect();
    let is_test = arguments.iter().any(|one| one == "--test");
    let rows: Vec<u8> = arguments.iter().filter_map(|one| one.parse().ok()).collect();
    let name = |bench: Bench| format!("{bench:?}").to_lowercase();
    let is_named = |bench: Bench| arguments.contains(&name(bench));
    let names_none = !BENCHES.iter().any(|&(bench, _)| is_named(bench));
    for (bench, fineness) in BENCHES.into_iter().filter(|&(bench, _)| names_none || is_named(bench)) {
        let shown = rows_shown(bench).iter().copied().filter(|&row| row < FIRST_FAULT);
        let wanted = shown.filter(|row| rows.is_empty() || rows.contains(row));
        for row in wanted.take(if is_test { 1 } else { usize::MAX }) {
            measure(bench, row, if is_test { FEW } else { fineness });
        }
        if is_test {
            break;
        }
    }
}

/// One diagnosis, if the bench can hide the row with this seed.
fn measure(bench: Bench, row: u8, fineness: f64) {
    let recipe = Recipe { hide: vec![row], fineness, ..Recipe::new(bench, SIZE, SEED) };
    let Some(case) = recipe.cook() else { return };
    let folder = tempfile::tempdir().unwrap();
    let paths = case.save(folder.path()).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_ncfix"));
    program.arg("diagnose").args(&paths.files).arg("--machine").arg(&paths.machine).arg("--json");
    let start = Instant::now();
    let run = program.stderr(Stdio::null()).output().unwrap();
    let took = start.elapsed().as_secs_f64();
    assert!(run.status.success(), "row {row:02}: {}", run.status);
    let report: Value = serde_json::from_slice(&run.stdout).unwrap();
    let first = &report["findings"][0];
    let said = format!(
        "{} {}",
        first["effect"].as_str().unwrap_or("nothing"),
        first["parameter"].as_str().unwrap_or_default()
    );
    let hidden: Vec<String> =
        case.truth.effects.iter().map(|one| format!("{} {}", one.effect, one.parameter)).collect();
    let readings: usize = case.files.iter().map(|file| file.csv.lines().count() - 1).sum();
    println!("{bench:?} row {row:02}, {readings} readings: {took:.1} s; hidden {}, named {said}", hidden.join(", "));
}
