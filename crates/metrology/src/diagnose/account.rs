//! Residual of each reading before and after the diagnosis, and the effect range of a single finding.

use std::collections::BTreeMap;

use super::fold::counts;
use super::noise::is_angle;
use super::scene::{NO_ROW, Scene};
use super::search::Weights;

/// Residuals of all readings after the fit of the set-up unknowns, in the order of [`Scene::items`], mm or rad.
#[derive(Clone, Debug, Default)]
pub struct Account {
    /// Residuals of the model.
    pub before: Vec<f64>,
    /// Residuals of the model with all findings.
    pub after: Vec<f64>,
    /// True for readings that are included. The others have their raw residual.
    pub counts: Vec<bool>,
}

impl Account {
    /// Combines the residuals of the data used and of the data held out, each with its weights. `raw` and `explained` are the residuals of excluded readings,
    /// before and after.
    pub(super) fn new(
        scene: &Scene<'_>,
        parts: [(&Weights, &[f64], &[f64]); 2],
        raw: &[f64],
        explained: &[f64],
    ) -> Account {
        let mut out =
            Account { before: raw.to_vec(), after: explained.to_vec(), counts: vec![false; scene.items.len()] };
        for (weights, before, after) in parts {
            for place in counts(scene, weights) {
                let values = (before.get(place), after.get(place));
                let slots = (out.before.get_mut(place), out.after.get_mut(place), out.counts.get_mut(place));
                if let ((Some(before), Some(after)), (Some(old), Some(new), Some(counts))) = (values, slots) {
                    (*old, *new, *counts) = (*before, *after, true);
                }
            }
        }
        out
    }
}

/// Range of the effect of a finding on the readings of one set-up: largest minus smallest effect, for the value and set-up with the largest range.
pub(super) fn swing(scene: &Scene<'_>, weights: &Weights, does: &[f64]) -> f64 {
    let of_angles = is_angle(scene);
    let mut ends: BTreeMap<(usize, usize, usize), [f64; 2]> = BTreeMap::new();
    for place in counts(scene, weights) {
        let Some(item) = scene.items.get(place).filter(|item| item.row != NO_ROW && item.is_angle == of_angles) else {
            continue;
        };
        let (Some(row), Some(&value)) = (scene.rows.get(item.row), does.get(place)) else { continue };
        let own = ends.entry((row.set, row.setup, item.value)).or_insert([value; 2]);
        *own = [own[0].min(value), own[1].max(value)];
    }
    ends.values().map(|[low, high]| high - low).fold(0.0, f64::max)
}
