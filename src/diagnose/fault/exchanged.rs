//! Two sensors that are plugged the other way round from one row on: each goes on where the other one was.
//!
//! Only the change shows it: two sensors that were exchanged from the beginning are two sensors with each other's names, which no reading contradicts.

use super::cells::{Sensor, goes_on};
use super::{Check, Fault, Then, View, spread};

pub(super) const CHECK: Check = Check {
    name: "exchanged sensors",
    made_by: "plugs that were confused when the logger was connected again",
    shown_by: "two sensors that jump in the same row, each to where the other one was",
    source: "likelihood over permutations of the channels before and behind a row",
    look,
};

/// Rows on both sides that say where a sensor goes.
const SIDE: usize = 4;
/// A jump is at least so many standard deviations, in the hypothesis that nothing happened.
const JUMP: f64 = 6.0;
/// None is left behind where they were exchanged.
const NONE: f64 = 4.0;

/// A place where two sensors may have been exchanged.
struct Swap {
    row: usize,
    pair: [usize; 2],
    score: f64,
    apart_k: f64,
    left_k: f64,
}

fn look(view: &View<'_, '_>, out: &mut Vec<Fault>) {
    for (set, sensors) in view.sensors.iter().enumerate() {
        let Some(data) = view.scene.sets.get(set) else { continue };
        let on = goes_on(data);
        let Some(best) = best(sensors, &on) else { continue };
        let names = best.pair.map(|number| sensors[number].name.clone());
        out.push(Fault {
            kind: "sensor",
            set,
            name: names.join(" "),
            what: "exchanged".into(),
            rows: [best.row, sensors[best.pair[0]].values.len().saturating_sub(1)],
            evidence: format!(
                "both jump in one row by {:.2} K in opposite senses; exchanged from there on no jump above {:.2} K is left",
                best.apart_k, best.left_k
            ),
            then: Then::WithoutSensors(names.to_vec()),
        });
    }
}

fn best(sensors: &[Sensor], on: &[bool]) -> Option<Swap> {
    let noise: Vec<f64> = sensors.iter().map(|sensor| noise(&sensor.values)).collect();
    let rows = sensors.iter().map(|sensor| sensor.values.len()).max()?;
    let mut best: Option<Swap> = None;
    for row in 2..rows.saturating_sub(2) {
        if !on.get(row - 1).copied().unwrap_or(false) {
            continue;
        }
        // Where each would go and where it is.
        let sides: Vec<Option<[f64; 2]>> = sensors.iter().map(|sensor| sides(&sensor.values, row)).collect();
        for one in 0..sensors.len() {
            for other in one + 1..sensors.len() {
                let (Some([a, b]), Some([c, d])) = (sides[one], sides[other]) else { continue };
                let unit = noise[one].hypot(noise[other]).max(1e-6);
                let (straight, crossed) = ([b - a, d - c], [d - a, b - c]);
                let apart = straight[0].abs().min(straight[1].abs());
                let left = crossed[0].abs().max(crossed[1].abs());
                // Neither warms up so fast that it only looks like a jump.
                let score = apart / unit;
                let is_one = straight[0] * straight[1] < 0.0 && score > JUMP && left < NONE * unit && left < 0.25 * apart;
                if is_one && best.as_ref().is_none_or(|best| score > best.score) {
                    best = Some(Swap { row, pair: [one, other], score, apart_k: apart, left_k: left });
                }
            }
        }
    }
    best
}

/// What a sensor says just before and just behind the beginning of a row, straight on from some rows on both sides.
fn sides(values: &[f64], row: usize) -> Option<[f64; 2]> {
    let before: Vec<f64> = (1..=SIDE).map_while(|k| values.get(row.checked_sub(k)?).copied()).collect();
    let behind: Vec<f64> = (0..SIDE).map_while(|k| values.get(row + k).copied()).collect();
    let to_edge = |side: &[f64]| {
        // Least squares in 0.5, 1.5, … rows from the edge.
        let count = side.len() as f64;
        if side.len() < 2 || side.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let mean = side.iter().sum::<f64>() / count;
        let middle = count / 2.0;
        let moment = |k: usize| k as f64 + 0.5 - middle;
        let square: f64 = (0..side.len()).map(|k| moment(k).powi(2)).sum();
        let slope = side.iter().enumerate().map(|(k, value)| moment(k) * value).sum::<f64>() / square;
        Some(mean - slope * middle)
    };
    Some([to_edge(&before)?, to_edge(&behind)?])
}

/// Noise of a difference of two sides: what the rows have of jumps.
fn noise(values: &[f64]) -> f64 {
    spread((2..values.len().saturating_sub(2)).filter_map(|row| sides(values, row)).map(|[a, b]| b - a))
}
