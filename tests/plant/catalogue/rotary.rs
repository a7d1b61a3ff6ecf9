//! Errors of rotary axes, of the spindle and of the stylus in it.

use std::f64::consts::TAU;

use crate::plant::effect::{Effect, Law, Place, location, motion};
use crate::plant::machine::SPINDLE;
use crate::plant::random::Random;

/// Number of C.
const C: usize = 4;

/// A wave of C in one component.
fn wave(row: u8, direction: usize, count: f64, phase: f64) -> Effect {
    let (law, unit) = if direction < 3 { (Law::Linear(1e3), "um") } else { (Law::Linear(1e6), "urad") };
    Effect::new(row, "periodic", &motion(direction, C), &["C"], law, unit)
        .acts(Place::Motion(direction, C), move |row| (count * row.q[C] + phase).sin())
        .repeats(360.0 / count)
}

/// A constant error of location.
fn still(row: u8, direction: usize, axis: usize) -> Effect {
    let (law, unit) = if direction < 3 { (Law::Linear(1e3), "um") } else { (Law::Linear(1e6), "urad") };
    let drivers: &[&str] = if axis == SPINDLE { &["A", "C", "spindle_deg"] } else { &["A", "C"] };
    Effect::new(row, "location", &location(direction, axis), drivers, law, unit)
        .acts(Place::Location(direction, axis), |_| 1.0)
}

/// The effect of a row of the catalogue.
pub(super) fn effect(row: u8, random: &mut Random) -> Option<Effect> {
    let phase = random.between(0.0, TAU);
    Some(match row {
        4 => wave(row, 5, random.pick(&[2.0, 3.0, 4.0, 5.0]), phase),
        9 => {
            let effect = still(row, random.pick(&[0, 1]), C);
            // Along A both axes are one.
            if effect.hidden.parameter == "EX0C" { effect.alias("location", "EX0A") } else { effect }
        }
        10 => {
            let effect = still(row, random.pick(&[3, 4]), C);
            if effect.hidden.parameter == "EA0C" { effect.alias("location", "EA0A") } else { effect }
        }
        11 => still(row, random.pick(&[4, 5]), 3),
        12 if random.unit() < 0.5 => Effect::new(row, "motion", "ECC", &["C"], Law::Linear(1e6), "urad/rad")
            .acts(Place::Motion(5, C), |row| row.q[C]),
        12 => wave(row, 5, 1.0, phase).alias("location", "EX0C").alias("location", "EY0C"),
        13 => {
            let (direction, count) = (random.pick(&[0, 1, 2]), random.pick(&[1.0, 2.0]));
            let effect = wave(row, direction, count, phase);
            if direction < 2 {
                // Both directions of the plane make the same wave, a quarter of a turn apart.
                let other = motion(1 - direction, C);
                effect.alias("periodic", &other)
            } else {
                effect
            }
        }
        14 => {
            let (direction, count) = (random.pick(&[3, 4]), random.pick(&[1.0, 2.0]));
            let effect = wave(row, direction, count, phase).alias("periodic", &motion(7 - direction, C));
            if count < 1.5 { effect.alias("location", "EA0C").alias("location", "EB0C") } else { effect }
        }
        15 => Effect::new(row, "backlash", "ECC", &["C_dir"], Law::Linear(1e6), "urad")
            .acts(Place::Motion(5, C), |row| row.dir[C] / 2.0),
        16 => still(row, random.pick(&[0, 1]), SPINDLE),
        17 => still(row, random.pick(&[3, 4]), SPINDLE),
        18 => {
            let second = random.between(-1.0, 1.0);
            let mut effect = Effect::new(row, "setup", "tool_z", &["setup"], Law::Linear(1e3), "um")
                .acts(Place::Tool(2), move |row| if row.setup == 0 { 1.0 } else { second })
                .alias("location", "EZ0S")
                .alias("location", "EZ0A")
                .only_here();
            effect.binds = Some("tool");
            effect
        }
        19 => {
            let mut effect = Effect::new(row, "setup", "tool_x", &["spindle_deg", "setup"], Law::Linear(1e3), "um")
                .acts(Place::Tool(0), |row| row.spindle.cos())
                .acts(Place::Tool(1), |row| row.spindle.sin())
                .alias("probe", "tool_x");
            effect.binds = Some("tool");
            effect
        }
        57 => Effect::new(row, "probe", "Z", &["feed_mm_min"], Law::Linear(1e3), "ms")
            .acts(Place::Tool(2), |row| -row.feed / 60.0),
        _ => return None,
    })
}
