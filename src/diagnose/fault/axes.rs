//! Columns that are exchanged, and columns or components with the wrong sign.
//!
//! All permutations and signs of the columns are tried, each with the best set-ups that it allows. Only where the readings as they are do not fit, others
//! fit to the noise, and the simplest of these is clear, it is said.

use super::readings::Readings;
use super::{Check, Fault, Then, View};

pub(super) const CHECK: Check = Check {
    name: "exchanged or reversed axes",
    made_by: "cables or columns that are confused, an instrument that counts the other way",
    shown_by: "readings that fit the model to the noise when two columns are exchanged or one is reversed, and not as they are",
    source: "likelihood over permutations",
    look,
};

/// What is left in squares of the noise where readings fit.
const FITS: f64 = 4.0;
/// As they are they leave at least so many times more.
const WORSE: f64 = 2.5;
/// Explanations within this factor are as good as each other.
const TIE: f64 = 1.15;
/// The prediction is at least so large in units of the noise.
const SIZE: f64 = 2.0;
/// A gain of −1 is within this.
const NEAR: f64 = 0.12;
const PERMUTATIONS: [[usize; 3]; 6] = [[0, 1, 2], [1, 0, 2], [2, 1, 0], [0, 2, 1], [1, 2, 0], [2, 0, 1]];
const COLUMNS: [&str; 3] = ["dx_um", "dy_um", "dz_um"];

fn look(view: &View<'_, '_>, out: &mut Vec<Fault>) {
    for (set, data) in view.sets() {
        let (Some(readings), Some(trail)) = (Readings::new(view.scene, set), view.trails.get(set)) else { continue };
        let noise = trail.noise_ratio().unwrap_or(1.0).powi(2).max(1e-6);
        let rows = [0, data.observations.len().saturating_sub(1)];
        let mut add = |name: String, what: &str, [as_is, otherwise]: [f64; 2]| {
            let evidence = format!(
                "as they are the readings leave {:.1} times their noise, {what} {:.1} times",
                (as_is / noise).sqrt(),
                (otherwise / noise).sqrt()
            );
            out.push(Fault { kind: "axes", set, name, what: what.into(), rows, evidence, then: Then::Refuse });
        };
        if data.targets.is_empty() || data.observations.iter().all(|one| one.component.is_none()) {
            if let Some((name, what, left)) = columns(&readings, noise) {
                add(name, what, left);
            }
            continue;
        }
        for (number, name) in data.targets.iter().enumerate() {
            let matched = readings.matched(Some(number));
            if matched.size > SIZE * noise.sqrt() && (matched.gain + 1.0).abs() < NEAR {
                let left = [1.0, -1.0].map(|times| readings.left_with(Some(number), times));
                if left[1] < FITS * noise && left[0] > WORSE * left[1] {
                    add(name.clone(), "reversed", left);
                }
            }
        }
    }
}

/// The simplest of the other ways to read the columns that fits.
fn columns(readings: &Readings, noise: f64) -> Option<(String, &'static str, [f64; 2])> {
    let values = readings.values();
    let as_is = readings.left_with(None, 1.0);
    if as_is < FITS * noise.min(1.0) {
        return None;
    }
    let mut ways: Vec<(usize, f64, [usize; 3], [f64; 3])> = Vec::new();
    for permutation in PERMUTATIONS {
        if (0..3).any(|k| permutation[k] != k && !values.contains(&k)) {
            continue;
        }
        for signs in 0..8_usize {
            let sign = [0, 1, 2].map(|k| if signs >> k & 1 == 1 { -1.0 } else { 1.0 });
            if (0..3).any(|k| sign[k] < 0.0 && !values.contains(&k)) {
                continue;
            }
            let moved = (0..3).filter(|&k| permutation[k] != k).count();
            let left = readings.left_if(None, &|value, all| sign[value.min(2)] * all[permutation[value.min(2)]], 1.0);
            ways.push((moved + signs.count_ones() as usize, left, permutation, sign));
        }
    }
    let best = ways.iter().map(|way| way.1).fold(f64::INFINITY, f64::min);
    let good: Vec<&(usize, f64, [usize; 3], [f64; 3])> = ways.iter().filter(|way| way.1 < TIE * best).collect();
    let simplest = good.iter().map(|way| way.0).min()?;
    let mut simple = good.iter().filter(|way| way.0 == simplest);
    let (_, left, permutation, sign) = simple.next()?;
    if simple.next().is_some() || simplest == 0 || *left > FITS * noise || as_is < WORSE * left {
        return None;
    }
    let moved: Vec<&str> = (0..3).filter(|&k| permutation[k] != k).map(|k| COLUMNS[k]).collect();
    let reversed: Vec<&str> = (0..3).filter(|&k| sign[k] < 0.0).map(|k| COLUMNS[k]).collect();
    let what = match (moved.is_empty(), reversed.is_empty()) {
        (false, true) => "swapped",
        (true, _) => "reversed",
        (false, false) => "swapped and reversed",
    };
    let names = if moved.is_empty() { reversed } else { moved };
    Some((names.join(" "), what, [as_is, *left]))
}
