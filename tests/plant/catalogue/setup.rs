//! Errors of mountings and instruments that should have been free, or that nobody thinks of.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::thermal::follower;
use crate::plant::bench::Bench;
use crate::plant::effect::{Effect, Law, Place, Stage, unit_vector};
use crate::plant::random::Random;
use crate::plant::row::Kind;
use crate::plant::vector::{V3, cross};

/// The effect of a row of the catalogue.
pub(super) fn effect(row: u8, stage: &Stage<'_>, random: &mut Random) -> Option<Effect> {
    let most = stage.sheets.iter().map(|sheet| sheet.setups.len()).max()?;
    let by_setup: Vec<Vec<V3>> =
        stage.sheets.iter().map(|_| (0..most).map(|_| unit_vector(random)).collect()).collect();
    Some(match row {
        50 => {
            let effect = Effect::new(row, "setup", "centre", &["setup"], Law::Linear(1e3), "um").only_here();
            let mut effect = (0..3).fold(effect, |effect, k| {
                let by_setup = by_setup.clone();
                effect.acts(Place::Tip(k), move |row| by_setup[row.day][row.setup][k])
            });
            effect.binds = Some("centre");
            effect
        }
        51 => {
            let (short, long) = (random.between(0.4, 1.0) * random.sign(), random.between(0.4, 1.0) * random.sign());
            let mut effect = Effect::new(row, "setup", "length", &["setup"], Law::Linear(1e3), "um")
                .acts(Place::Reading(0), move |row| {
                    row.circle.map_or(0.0, |circle| if circle.radius < 120.0 { -short } else { -long })
                });
            effect.binds = Some("length");
            effect
        }
        52 => {
            // A ball that rolls in its cup: never the same way twice.
            let mut phases: Vec<HashMap<String, f64>> = Vec::new();
            for sheet in stage.sheets {
                let mut by_run = HashMap::new();
                for row in &sheet.rows {
                    if !by_run.contains_key(&row.run) {
                        by_run.insert(row.run.clone(), random.between(0.0, TAU));
                    }
                }
                phases.push(by_run);
            }
            Effect::new(row, "setup", "cup", &["run", "X", "Y", "Z"], Law::Linear(1e3), "um")
                .acts(Place::Reading(0), move |row| {
                    row.circle.map_or(0.0, |circle| (3.0 * circle.angle + phases[row.day][&row.run]).sin())
                })
                .alias("unknown", "")
                .only_here()
        }
        53 => {
            let warm = follower(stage, "T_plate", 0.0)?;
            let kinds: Vec<Kind> = stage.sheets.iter().map(|sheet| sheet.kind).collect();
            let warm = std::rc::Rc::new(warm);
            let effect = Effect::new(row, "setup", "scale", &["T_plate_C"], Law::Linear(1e6), "um/(m K)")
                .alias("thermal-expansion", "EXX")
                .alias("thermal-expansion", "EYY")
                .follows("T_plate", 0.0);
            (0..2).fold(effect, |effect, k| {
                let (warm, kinds) = (warm.clone(), kinds.clone());
                effect.acts(Place::Reading(k), move |row| {
                    if kinds[row.day] == Kind::Displacement {
                        -warm(row) * (row.point()[k] - [350.0, 250.0][k])
                    } else {
                        0.0
                    }
                })
            })
        }
        54 => {
            let effect = Effect::new(row, "setup", "rotation", &["setup"], Law::Linear(1e6), "urad").only_here();
            let mut effect = (0..3).fold(effect, |effect, k| {
                let by_setup = by_setup.clone();
                effect.acts(Place::Reading(k), move |row| cross(by_setup[row.day][row.setup], row.point())[k])
            });
            effect.binds = Some("rotation");
            effect
        }
        58 => {
            let lengths: Vec<bool> =
                stage.sheets.iter().map(|sheet| sheet.kind == Kind::Direct && !sheet.angles).collect();
            let is_on = move |row: &crate::plant::row::Row| lengths[row.day] && row.component[0] == row.component[1];
            if stage.bench == Bench::HotCold {
                let warm = follower(stage, "T_air", 0.0)?;
                Effect::new(row, "setup", "scale", &["T_air_C"], Law::Linear(1e6), "um/(m K)")
                    .acts(
                        Place::Reading(0),
                        move |row| {
                            if is_on(row) { warm(row) * row.q[row.component[1]] } else { 0.0 }
                        },
                    )
                    .follows("T_air", 0.0)
            } else {
                // The beam of the second mounting is not along the axis.
                Effect::new(row, "setup", "scale", &["setup"], Law::Linear(1e6), "um/m")
                    .acts(
                        Place::Reading(0),
                        move |row| {
                            if is_on(row) && row.setup == 1 { -row.q[row.component[1]] } else { 0.0 }
                        },
                    )
                    .only_here()
            }
        }
        _ => return None,
    })
}
