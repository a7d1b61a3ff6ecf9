//! Errors of the motion of linear axes, of their location, of their reversal, and of loads.

use std::f64::consts::{PI, TAU};

use super::square;
use crate::plant::bench::Bench;
use crate::plant::effect::{Effect, Law, Place, Stage, location, motion};
use crate::plant::machine::LETTERS;
use crate::plant::random::Random;
use crate::plant::row::Row;

/// The middle and half of the travel on which shapes are made.
const MIDDLE: [f64; 3] = [350.0, 250.0, 250.0];
const HALF: [f64; 3] = [350.0, 250.0, 250.0];

/// The command of an axis as −1 … 1 over its travel.
fn share(row: &Row, axis: usize) -> f64 {
    (row.q[axis] - MIDDLE[axis]) / HALF[axis]
}

/// The effect of a row of the catalogue.
pub(super) fn effect(row: u8, stage: &Stage<'_>, random: &mut Random) -> Option<Effect> {
    let is_plate = stage.bench == Bench::Plate;
    // A plate moves Z little.
    let axis = random.below(if is_plate { 2 } else { 3 });
    let letter = LETTERS[axis];
    let sense = format!("{letter}_dir");
    let other = (axis + 1 + random.below(2)) % 3;
    let own = |effect, drivers: &[&str], law, unit| Effect::new(row, effect, &motion(axis, axis), drivers, law, unit);
    Some(match row {
        1 => own("motion", &[letter], Law::Linear(1e6), "um/m")
            .acts(Place::Motion(axis, axis), move |row| row.q[axis] - MIDDLE[axis]),
        2 => {
            let (cubic, waves, phase) = (random.sign(), random.between(0.8, 1.6), random.between(-0.5, 0.5));
            own("motion", &[letter], Law::Span(1e3), "um").acts(Place::Motion(axis, axis), move |row| {
                let u = share(row, axis);
                cubic * (u.powi(3) - 0.6 * u) + 0.5 * (PI * waves * u + phase).sin()
            })
        }
        3 => {
            let (period, phase) = (random.pick(&[8.0, 10.0, 12.5, 16.0, 20.0]), random.between(0.0, TAU));
            own("periodic", &[letter], Law::Linear(1e3), "um")
                .acts(Place::Motion(axis, axis), move |row| (TAU * row.q[axis] / period + phase).sin())
                .repeats(period)
        }
        5 => {
            let third = random.between(-0.4, 0.4);
            Effect::new(row, "motion", &motion(other, axis), &[letter], Law::Span(1e3), "um").acts(
                Place::Motion(other, axis),
                move |row| {
                    let u = share(row, axis);
                    u * u + third * u.powi(3)
                },
            )
        }
        6 => Effect::new(row, "motion", &motion(3 + axis, axis), &[letter], Law::Span(1e6), "urad")
            .acts(Place::Motion(3 + axis, axis), move |row| share(row, axis)),
        7 => {
            let direction = 3 + other;
            let straight = random.between(-1.0, 1.0);
            Effect::new(row, "motion", &motion(direction, axis), &[letter], Law::Span(1e6), "urad").acts(
                Place::Motion(direction, axis),
                move |row| {
                    let u = share(row, axis);
                    u * u + straight * u
                },
            )
        }
        8 => {
            let (a, b) = if is_plate { (0, 1) } else { random.pick(&[(0, 1), (0, 2), (1, 2)]) };
            let (direction, of) = square(stage, a, b);
            let rival = a + b - of;
            Effect::new(row, "location", &location(direction, of), &[LETTERS[a], LETTERS[b]], Law::Linear(1e6), "urad")
                .acts(Place::Location(direction, of), |_| 1.0)
                .alias("location", &location(direction, rival))
        }
        20 => own("backlash", &[&sense], Law::Linear(1e3), "um")
            .acts(Place::Motion(axis, axis), move |row| row.dir[axis] / 2.0),
        21 => own("backlash", &[&sense, letter], Law::Linear(1e3), "um at the + end")
            .acts(Place::Motion(axis, axis), move |row| row.dir[axis] / 2.0 * (1.0 + share(row, axis)) / 2.0),
        24 => Effect::new(row, "lateral-play", &motion(other, axis), &[&sense], Law::Linear(1e3), "um")
            .acts(Place::Motion(other, axis), move |row| row.dir[axis] / 2.0)
            .alias("backlash", &motion(other, axis)),
        25 | 49 => {
            // Racking of a gantry is the yaw of its beam.
            let (direction, axis) = if row == 49 { (5, 1) } else { (3 + other, axis) };
            let sense = format!("{}_dir", LETTERS[axis]);
            Effect::new(row, "backlash", &motion(direction, axis), &[&sense], Law::Linear(1e6), "urad")
                .acts(Place::Motion(direction, axis), move |row| row.dir[axis] / 2.0)
                .alias("lateral-play", &motion(direction, axis))
        }
        47 => Effect::new(row, "motion", "EAZ", &["Z"], Law::Span(1e6), "urad")
            .acts(Place::Motion(3, 2), |row| (row.q[2] / 500.0).powi(2)),
        48 => {
            let (direction, axis, with) = random.pick(&[(3, 1, 0), (4, 0, 1)]);
            let drivers = [LETTERS[axis], LETTERS[with]];
            Effect::new(row, "cross", &motion(direction, axis), &drivers, Law::Linear(1e6), "urad at both ends")
                .acts(Place::Motion(direction, axis), move |row| share(row, axis) * share(row, with))
        }
        45 => {
            let arm = 420.0;
            let bend = random.between(0.3, 1.0) * random.sign();
            Effect::new(row, "load", "EAX", &["load_N", "load_y_mm", "X"], Law::Linear(1e6), "urad at 4800 N, X + end")
                .acts(Place::Motion(3, 0), move |row| {
                    let u = share(row, 0);
                    row.load / 4800.0 * (arm - row.load_at[1]) / arm * (u * u + bend * u) / (1.0 + bend)
                })
        }
        46 => {
            let (direction, along) = random.pick(&[(3, 1), (4, 0)]);
            let driver = ["load_x_mm", "load_y_mm"][along];
            let unit = "urad at 4800 N, 150 mm";
            Effect::new(row, "load", &location(direction, 1), &["load_N", driver], Law::Linear(1e6), unit)
                .acts(Place::Location(direction, 1), move |row| row.load / 4800.0 * row.load_at[along] / 150.0)
                .alias("load", &location(direction, 0))
        }
        _ => return None,
    })
}
