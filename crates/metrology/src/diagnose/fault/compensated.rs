//! Readings of a machine whose control already applies the known corrections, with an active table. The residual is then the known map with the
//! opposite sign.

use super::readings::WeighedReadings;
use super::single::{MOST, ROWS, by_one_cause, left, thinned};
use super::{DataDefect, DefectCheck, DefectKind, Then, View};

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "active compensation",
    made_by: "a table of the control that was active during the measurement, or one with the wrong sign",
    shown_by: "the readings contain the errors of the model twice, or not at all",
    source: "residual = −1 or +1 × the known map",
    look,
};

/// Smallest prediction, in units of the noise.
const SIZE: f64 = 0.9;
/// Largest mean squared residual of readings that fit, in squares of the noise.
const FITS: f64 = 2.4;
/// Smallest excess of the residual with the known errors, as a share of their squares.
const WORSE: f64 = 0.5;
/// Largest uncertainty of the gain.
const SURE: f64 = 0.06;
/// Number of correlated readings that count as one.
const MEMORY: f64 = 10.0;
/// Tolerance of the gain, in units of its uncertainty.
const FAR: f64 = 3.0;
/// Difference in squares of the noise that decides between a single cause and the table; readings on one line cannot separate a slope from a table of
/// slopes.
const SURELY: f64 = 24.0;
/// Tolerance of the gain.
const NEAR: f64 = 0.1;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    let scene = view.scene;
    for (set, data) in view.sets() {
        let (Some(readings), Some(trail)) = (WeighedReadings::new(scene, set), view.trails.get(set)) else { continue };
        let noise = trail.noise_ratio().unwrap_or(1.0).powi(2).max(1e-6);
        let matched = readings.matched(None);
        if matched.size < SIZE * noise.sqrt() {
            continue;
        }
        for (gain, what) in [(0.0, "known errors already removed"), (2.0, "known errors removed with the wrong sign")] {
            let [as_is, otherwise] = [1.0, gain].map(|times| readings.left_with(None, times));
            let sure = (noise * MEMORY / matched.count).sqrt() / matched.size;
            if (matched.gain - gain).abs() > NEAR.max(FAR * sure) {
                continue;
            }
            if otherwise < FITS * noise && as_is - otherwise > WORSE * matched.size.min(4.0).powi(2) && sure < SURE {
                // Squares of some rows are limited here, as in the comparison with a single cause.
                let sets = [thinned(data, ROWS)];
                let Some(rest) = left(scene.machine, scene, &sets, MOST) else { continue };
                let count = rest.values.len() as f64;
                let more = by_one_cause(scene.machine, &sets, &rest) - otherwise.min(rest.squares / count) * count;
                if more < -SURELY * noise {
                    continue;
                }
                let is_sure = more > SURELY * noise;
                let single =
                    if is_sure { "; no single cause explains as much" } else { "; a single cause explains as much" };
                out.push(DataDefect {
                    kind: DefectKind::Compensated,
                    set,
                    name: data.name.clone(),
                    what: what.into(),
                    rows: [0, data.observations.len().saturating_sub(1)],
                    evidence: format!(
                        "{} readings contain {:.2} times the errors of the machine file; the residual is {:.1} times the noise with these errors, {:.1} times with {gain:.0} times these errors{single}",
                        matched.count,
                        matched.gain,
                        (as_is / noise).sqrt(),
                        (otherwise / noise).sqrt()
                    ),
                    // The slope of a single line may also be a cause, so it is not refused.
                    then: if is_sure { Then::Refuse } else { Then::Nothing },
                });
            }
        }
    }
}
