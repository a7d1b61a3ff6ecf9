//! Two temperature sensors whose plugs are exchanged from one row on: each continues at the reading of the other.
//!
//! Only the change is visible. Sensors that were exchanged from the beginning just have each other's names, and no reading contradicts that.

use super::cells::{Sensor, TableClock};
use super::{DataDefect, DefectCheck, DefectKind, Then, View, spread};

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "exchanged sensors",
    made_by: "plugs that were exchanged when the logger was reconnected",
    shown_by: "two sensors that jump in the same row, each to the level of the other",
    source: "likelihood over permutations of the channels before and after a row",
    look,
};

/// Smallest jump, in standard deviations, if nothing was exchanged.
const JUMP: f64 = 4.5;
/// Largest remaining jump, in standard deviations, after exchanging them back.
const NONE: f64 = 3.5;

/// Number of rows on each side for means.
const SIDE: usize = 8;
/// Smallest jump of the means of some rows, in units of the usual jump.
const OVER_ROWS: f64 = 6.0;

/// A row at which two sensors may have been exchanged.
struct Swap {
    row: usize,
    pair: [usize; 2],
    score: f64,
    apart_k: f64,
    left_k: f64,
}

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, sensors) in view.sensors.iter().enumerate() {
        let Some(data) = view.scene.sets.get(set) else { continue };
        let clock = TableClock::new(data);
        let Some(best) = best(sensors, &clock).or_else(|| over_rows(sensors, &clock)) else { continue };
        let names = best.pair.map(|number| sensors[number].name.clone());
        out.push(DataDefect {
            kind: DefectKind::Sensor,
            set,
            name: names.join(" "),
            what: "exchanged".into(),
            rows: [best.row, sensors[best.pair[0]].values.len().saturating_sub(1)],
            evidence: format!(
                "both jump in one row by {:.2} K in opposite directions; if they are exchanged from this row on, no jump exceeds {:.2} K",
                best.apart_k, best.left_k
            ),
            then: Then::WithoutSensors(names.to_vec()),
        });
    }
}

fn best(sensors: &[Sensor], clock: &TableClock) -> Option<Swap> {
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

/// Finds two sensors with a smaller difference than their noise in one row. The mean of their difference over some rows on each side changes its
/// sign, while their sum does not jump.
fn over_rows(sensors: &[Sensor], clock: &TableClock) -> Option<Swap> {
    let mut best: Option<Swap> = None;
    for one in 0..sensors.len() {
        for other in one + 1..sensors.len() {
            let (a, b) = (&sensors[one].values, &sensors[other].values);
            let count = a.len().min(b.len());
            let sums = |sign: f64| {
                let (mut sum, mut last) = (0.0, 0.0);
                // A gap keeps the value of the row before it.
                let all = (0..count).map(|k| {
                    let value = a[k] + sign * b[k];
                    last = if value.is_finite() { value } else { last };
                    sum += last;
                    sum
                });
                std::iter::once(0.0).chain(all).collect::<Vec<f64>>()
            };
            let (apart, together) = (sums(-1.0), sums(1.0));
            // Means of the rows before and after each row.
            let means = |sums: &[f64], row: usize| {
                let mean = |from: usize, to: usize| Some((sums.get(to)? - sums.get(from)?) / SIDE as f64);
                Some([mean(row.checked_sub(SIDE)?, row)?, mean(row, row + SIDE)?])
            };
            // Missing values have no noise, which would make the noise of all others unusual.
            let is_known = |row: usize| (row - SIDE..row + SIDE).all(|k| a[k].is_finite() && b[k].is_finite());
            let rows: Vec<usize> = (SIDE..count.saturating_sub(SIDE))
                .filter(|&row| clock.goes_on(row - SIDE, row + SIDE) && is_known(row))
                .collect();
            let jump = |sums: &[f64], row: usize| means(sums, row).map_or(f64::NAN, |[before, behind]| behind - before);
            let usual = |sums: &[f64]| spread(rows.iter().map(|&row| jump(sums, row))).max(1e-6);
            let (unit, unit_together) = (usual(&apart), usual(&together));
            let found = rows.iter().copied().max_by(|x, y| jump(&apart, *x).abs().total_cmp(&jump(&apart, *y).abs()));
            let Some(row) = found else { continue };
            let Some([before, behind]) = means(&apart, row) else { continue };
            let own = jump(&apart, row);
            let score = own.abs() / unit;
            let is_exchanged = score > OVER_ROWS
                && before * behind < 0.0
                && (before + behind).abs() < 0.3 * own.abs()
                && own.abs() > 2.0 * step(a).max(step(b))
                && jump(&together, row).abs() < NONE * unit_together.max(unit / 2.0)
                && jump(&together, row).abs() < 0.25 * own.abs()
                && is_sudden(&apart, row, own);
            if is_exchanged && best.as_ref().is_none_or(|best| score > best.score) {
                let left_k = jump(&together, row).abs() / 2.0;
                best = Some(Swap { row, pair: [one, other], score, apart_k: own.abs() / 2.0, left_k });
            }
        }
    }
    best
}

/// True if means over wider ranges show no larger jump than those nearby; a slow crossing does.
fn is_sudden(sums: &[f64], row: usize, jump: f64) -> bool {
    const HALF: usize = SIDE / 2;
    let mean = |from: usize, to: usize| Some((sums.get(to)? - sums.get(from)?) / HALF as f64);
    let near = || Some(mean(row, row + HALF)? - mean(row.checked_sub(HALF)?, row)?);
    near().is_some_and(|near| near * jump.signum() > 0.7 * jump.abs())
}

/// Noise of a sensor by second differences, and at least one step of its display, even if the display rarely changes.
fn noise(values: &[f64]) -> f64 {
    spread(values.windows(3).map(|three| (three[2] - 2.0 * three[1] + three[0]) / 6.0_f64.sqrt())).max(step(values))
}

/// Step of the display of a sensor, K: displays of two sensors that are alike may change by a step in one row, in opposite directions.
fn step(values: &[f64]) -> f64 {
    let changes = values.windows(2).map(|two| (two[1] - two[0]).abs()).filter(|change| *change > 0.0);
    changes.reduce(f64::min).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    /// Sensors with one temperature in the first half of the rows and another one in the second, with noise from −0.1 to 0.1 K (xorshift).
    fn sensors<const N: usize>(halves: [[f64; 2]; N], rows: usize) -> [Sensor; N] {
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let mut noise = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            0.2 * ((state >> 11) as f64 / (1_u64 << 53) as f64) - 0.1
        };
        halves.map(|[before, behind]| Sensor {
            name: format!("T_{before}_C"),
            values: (0..rows).map(|row| if row < rows / 2 { before } else { behind } + noise()).collect(),
        })
    }

    #[test]
    fn sensors_far_apart_that_are_exchanged_leave_their_noise() {
        let machine = bench::machine();
        let clock = TableClock::new(&bench::reads_along_x(&machine, &[0.0; 60]));
        let swapped = sensors([[20.0, 35.0], [35.0, 20.0], [22.0, 22.0]], 60);
        let found = best(&swapped, &clock).unwrap();
        assert_eq!((found.row, found.pair), (30, [0, 1]));
        assert!((found.apart_k - 15.0).abs() < 0.4 && found.left_k < 0.5, "{} {}", found.apart_k, found.left_k);
        // Neither sensor continues at the reading of the other.
        assert!(best(&sensors([[20.0, 35.0], [40.0, 25.0]], 60), &clock).is_none());
    }

    #[test]
    fn sensors_that_are_nearly_alike_are_told_by_means_over_rows() {
        let machine = bench::machine();
        let clock = TableClock::new(&bench::reads_along_x(&machine, &[0.0; 120]));
        // 0.3 K apart with noise up to 0.1 K.
        let alike = sensors([[20.0, 20.3], [20.3, 20.0]], 120);
        let found = over_rows(&alike, &clock).unwrap();
        assert_eq!(found.pair, [0, 1]);
        assert!(
            found.row.abs_diff(60) <= 1 && (found.apart_k - 0.3).abs() < 0.1 && found.left_k < 0.1,
            "{}",
            found.row
        );
        // Two sensors that approach each other are not exchanged.
        assert!(over_rows(&sensors([[20.0, 20.3], [21.0, 20.7]], 120), &clock).is_none());
    }
}
