//! Fits parameters of a machine to readings of a ball-bar and prints them with their uncertainties:
//! `cargo run --example fit_ball_bar_data`.

#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use ncfix::prelude::*;

pub(crate) fn main() -> Result<(), Error> {
    let machine = Machine::from_file("samples/machines/demo.toml")?;
    // The table of readings; its description, ball_bar.toml, is in the same folder.
    let data = [DataSet::read("samples/measurements/ball_bar.csv")?];
    let mut options = CalibrationOptions::default();
    // Squareness of X and Y, scale of X, and half of the reversal value of X.
    options.parameters = ["EC0X", "EXX1", "EXXb"].map(String::from).to_vec();
    let found = Calibration::run(&machine, &data, &options)?;
    print!("{}", found.diagnostics());

    // The circles were simulated with 43 µrad, 52 µm/m and 2.5 µm.
    for (one, made_with) in found.result().parameters.iter().zip([43.0, 52.0, 2.5]) {
        assert!((one.value - made_with).abs() < 4.0 * one.sigma, "{one:?}");
    }
    println!("parameter       value      ± 1σ  unit      before");
    for one in found.parameters() {
        println!("{:<10}{:>11.2}{:>10.2}  {:<6}{:>10.2}", one.name, one.value, one.sigma, one.unit, one.start);
    }
    for one in &found.result().data {
        let (name, unit, count) = (&one.name, one.unit, one.readings);
        println!(
            "{name}: {count} readings, {:.2} {unit} RMS without the parameters, {:.2} {unit} RMS with them",
            one.measured_rms, one.left_rms
        );
    }
    Ok(())
}
