//! Prints the error of a machine at a pose, and its backlash from the error after a motion in each direction.

#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use ncfix::prelude::*;

/// A small machine: Y carries the table, X and Z carry the spindle. It has a squareness error, a scale error and backlash.
const MACHINE: &str = r#"
[machine]
name = "small mill"
topology = "wYFXZSt"
controller = "fanuc"
[axis.X]
direction = [1, 0, 0]
travel_mm = [0, 500]
[axis.Y]
direction = [0, -1, 0]
travel_mm = [0, 400]
[axis.Z]
direction = [0, 0, 1]
travel_mm = [0, 450]
[spindle]
origin_mm = [0, 0, 0]
axis = [0, 0, 1]
[location]
EC0X = 20.0
[[motion]]
component = "EXX"
kind = "polynomial"
coefficients = [0, 5e-5]
[[motion]]
component = "EXX"
kind = "backlash"
value_um = -6.0
"#;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machine = Machine::from_text("small_mill.toml", MACHINE)?;
    // Positions in mm and degrees; axes that are not named are at 0.
    let pose: AxisVector = "X400,Y300,Z100".parse()?;
    let tool = ToolVector::Length(120.0);

    let unmoved = machine.deviation(&pose, tool, &State::default());
    let [x_um, y_um, z_um] = unmoved.position_um;
    println!("error of the tip: X {x_um:.1}, Y {y_um:.1}, Z {z_um:.1} µm; distance {:.1} µm", unmoved.distance_um());

    // The error includes backlash only if the direction of the last motion is known.
    let forth = machine.deviation(&pose, tool, &"X+".parse()?);
    let back = machine.deviation(&pose, tool, &"X-".parse()?);
    // An axis on the tool side: lost motion is negative, so the tool lags in both directions.
    let lost_um = back.position_um[0] - forth.position_um[0];
    println!("X loses {lost_um:.1} µm at a reversal");
    assert!((lost_um - 6.0).abs() < 0.01);
    // X: 50 µm/m · 400 mm. Y: the squareness of 20 µrad rotates 400 mm of X.
    assert!((x_um - 20.0).abs() < 0.01 && (y_um - 8.0).abs() < 0.01);
    Ok(())
}
