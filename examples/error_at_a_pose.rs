//! Asks how far a machine is off at a pose: cold and empty, with a workpiece on its table, and after a reversal.

#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use ncfix::prelude::*;

/// A small machine: Y carries the table, X and Z the spindle. Squareness, a scale that is wrong, backlash, a table that tilts under weight.
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
EC0Y = 20.0
[[motion]]
component = "EXX"
kind = "polynomial"
coefficients = [0, 5e-5]
[[motion]]
component = "EXX"
kind = "backlash"
value_um = 6.0
"#;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machine = Machine::from_text("small_mill.toml", MACHINE)?;
    // mm and degrees; axes that are left out are at 0.
    let pose: AxisVector = "X400,Y300,Z100".parse()?;
    let tool = ToolVector::Length(120.0);

    let unmoved = machine.deviation(&pose, tool, &State::default());
    let [x_um, y_um, z_um] = unmoved.position_um;
    println!("the tip is off by {x_um:.1} {y_um:.1} {z_um:.1} µm, {:.1} µm in all", unmoved.distance_um());

    // Backlash counts once it is known how an axis moved last.
    let forth = machine.deviation(&pose, tool, &"X+".parse()?);
    let back = machine.deviation(&pose, tool, &"X-".parse()?);
    let lost_um = forth.position_um[0] - back.position_um[0];
    println!("X loses {lost_um:.1} µm when it turns round");
    assert!((lost_um - 6.0).abs() < 0.01);
    // 50 µm in a meter, at 400 mm.
    assert!((unmoved.position_um[0] - 20.0).abs() < 6.1);
    Ok(())
}
