//! Readings of a machine whose control already takes out what the model has: an active table. What is left is the known map with the other sign.

use super::readings::WeighedReadings;
use super::single::{MOST, by_one_cause, left, thinned};
use super::{DataDefect, DefectCheck, DefectKind, Then, View};

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "active compensation",
    made_by: "a table of the control that was active while measuring, or one with the wrong sign",
    shown_by: "nothing in the readings goes with the errors that the model knows, or twice as much as it should",
    source: "residual = −1 or +1 × the known map",
    look,
};

/// The prediction is at least so large in units of the noise.
const SIZE: f64 = 0.9;
/// What is left in squares of the noise where readings fit.
const FITS: f64 = 2.4;
/// The known errors as they are leave so much of their own squares more.
const WORSE: f64 = 0.5;
/// Uncertainty of the gain at most.
const SURE: f64 = 0.06;
/// Readings that slow noise makes one.
const MEMORY: f64 = 10.0;
/// Or this many times its uncertainty.
const FAR: f64 = 3.0;
/// A single cause explains so many squares of the noise less, or more: readings of one line do not tell a slope from a table of slopes.
const SURELY: f64 = 24.0;
/// A gain is within this.
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
        for (gain, what) in
            [(0.0, "known errors already taken out"), (2.0, "known errors taken out with the wrong sign")]
        {
            let [as_is, otherwise] = [1.0, gain].map(|times| readings.left_with(None, times));
            let sure = (noise * MEMORY / matched.count).sqrt() / matched.size;
            if (matched.gain - gain).abs() > NEAR.max(FAR * sure) {
                continue;
            }
            if otherwise < FITS * noise && as_is - otherwise > WORSE * matched.size.min(4.0).powi(2) && sure < SURE {
                // Squares of some rows count up to some σ here, as those with a single cause do.
                let sets = [thinned(data)];
                let Some(rest) = left(scene.machine, scene, &sets, MOST) else { continue };
                let count = rest.values.len() as f64;
                let more = by_one_cause(scene.machine, &sets, &rest) - otherwise.min(rest.squares / count) * count;
                if more < -SURELY * noise {
                    continue;
                }
                let is_sure = more > SURELY * noise;
                let single =
                    if is_sure { "; no single cause explains as much" } else { "; a single cause does the same" };
                out.push(DataDefect {
                    kind: DefectKind::Compensated,
                    set,
                    name: data.name.clone(),
                    what: what.into(),
                    rows: [0, data.observations.len().saturating_sub(1)],
                    evidence: format!(
                        "{} readings are {:.2} times what the model says: with it they leave {:.1} times their noise, with {gain:.0} times it {:.1}{single}",
                        matched.count,
                        matched.gain,
                        (as_is / noise).sqrt(),
                        (otherwise / noise).sqrt()
                    ),
                    // The slope of one line is a cause as well, and no reason to refuse it.
                    then: if is_sure { Then::Refuse } else { Then::Nothing },
                });
            }
        }
    }
}
