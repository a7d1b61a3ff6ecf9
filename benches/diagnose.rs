//! How long a diagnosis of 20,000 readings of a ball-bar takes, the whole program with all its cores: one hidden row of the catalogue each, measured by
//! the plant of the tests. `cargo bench --bench diagnose -- 03 52` takes some rows only; in a test it is one row and few readings.
#![allow(clippy::unwrap_used, reason = "a bench that cannot be set up has nothing to measure")]
#![allow(clippy::print_stdout, reason = "the figures are what it is for")]
#![allow(dead_code, unused_imports, unreachable_pub, reason = "the plant is that of the tests, which use all of it")]

use std::process::{Command, Stdio};
use std::time::Instant;

#[path = "../tests/plant/mod.rs"]
mod plant;

use plant::{Bench, Recipe, rows_shown};

/// Rows of the catalogue from here on are faults of the data.
const FIRST_FAULT: u8 = 60;
/// So densely sampled that there are 20,000 readings, and as few as a test needs.
const FINENESS: f64 = 2.14;
const FEW: f64 = 0.12;
/// What is hidden, in units of the noise, and the seed of the afternoon.
const SIZE: f64 = 5.0;
const SEED: u64 = 2;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_test = arguments.iter().any(|one| one == "--test");
    let wanted: Vec<u8> = arguments.iter().filter_map(|one| one.parse().ok()).collect();
    let shown = rows_shown(Bench::Ballbar).iter().copied().filter(|&row| row < FIRST_FAULT);
    let rows = shown.filter(|row| wanted.is_empty() || wanted.contains(row)).take(if is_test { 1 } else { usize::MAX });
    for row in rows {
        let fineness = if is_test { FEW } else { FINENESS };
        let recipe = Recipe { hide: vec![row], fineness, ..Recipe::new(Bench::Ballbar, SIZE, SEED) };
        let Some(case) = recipe.cook() else { continue };
        let folder = tempfile::tempdir().unwrap();
        let paths = case.save(folder.path()).unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_ncfix"));
        program.arg("diagnose").args(&paths.files).arg("--machine").arg(&paths.machine).arg("--json");
        let start = Instant::now();
        let status = program.stdout(Stdio::null()).stderr(Stdio::null()).status().unwrap();
        let took = start.elapsed().as_secs_f64();
        assert!(status.success(), "row {row:02}: {status}");
        let readings: usize = case.files.iter().map(|file| file.csv.lines().count() - 1).sum();
        println!("row {row:02} of the catalogue, {readings} readings: {took:.1} s");
    }
}
