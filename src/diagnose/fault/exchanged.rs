//! Two sensors that are plugged the other way round from one row on: each goes on where the other one was.
//!
//! Only the change shows it: two sensors that were exchanged from the beginning are two sensors with each other's names, which no reading contradicts.

use super::cells::{Clock, Sensor};
use super::{Check, Fault, Then, View, spread};

pub(super) const CHECK: Check = Check {
    name: "exchanged sensors",
    made_by: "plugs that were confused when the logger was connected again",
    shown_by: "two sensors that jump in the same row, each to where the other one was",
    source: "likelihood over permutations of the channels before and behind a row",
    look,
};

/// A jump is at least so many standard deviations, in the hypothesis that nothing happened.
const JUMP: f64 = 4.5;
/// None is left behind where they were exchanged.
const NONE: f64 = 3.5;

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
        let clock = Clock::new(data);
        let Some(best) = best(sensors, &clock) else { continue };
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

fn best(sensors: &[Sensor], clock: &Clock) -> Option<Swap> {
    let rows = sensors.iter().map(|sensor| sensor.values.len()).max()?;
    let jumps: Vec<Vec<Option<f64>>> = sensors
        .iter()
        .map(|sensor| (0..rows).map(|row| clock.jump(&sensor.values, &sensor.values, row)).collect())
        .collect();
    let noise: Vec<f64> = sensors
        .iter()
        .zip(&jumps)
        .map(|(sensor, jumps)| noise(&sensor.values).max(spread(jumps.iter().copied().flatten())))
        .collect();
    let at = |sensor: usize, row: usize| jumps.get(sensor).and_then(|all| all.get(row)).copied().flatten();
    let mut best: Option<Swap> = None;
    for row in 0..rows {
        for one in 0..sensors.len() {
            let Some(a) = at(one, row) else { continue };
            for other in one + 1..sensors.len() {
                let unit = noise[one].hypot(noise[other]).max(1e-6);
                let Some(b) = at(other, row).filter(|b| a * b < 0.0 && a.abs().min(b.abs()) > JUMP * unit) else {
                    continue;
                };
                let (from, to) = (&sensors[one].values, &sensors[other].values);
                let (Some(c), Some(d)) = (clock.jump(from, to, row), clock.jump(to, from, row)) else { continue };
                let (apart, left) = (a.abs().min(b.abs()), c.abs().max(d.abs()));
                let score = apart / unit;
                if left < NONE * unit && left < 0.25 * apart && best.as_ref().is_none_or(|best| score > best.score) {
                    best = Some(Swap { row, pair: [one, other], score, apart_k: apart, left_k: left });
                }
            }
        }
    }
    best
}

/// Noise of a sensor by its second differences.
fn noise(values: &[f64]) -> f64 {
    spread(values.windows(3).map(|three| (three[2] - 2.0 * three[1] + three[0]) / 6.0_f64.sqrt()))
}
