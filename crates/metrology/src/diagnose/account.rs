//! The readings one by one: what is left of each before and after, and what a finding by itself swings them by.

use std::collections::BTreeMap;

use super::fold::counts;
use super::noise::is_angle;
use super::scene::{NO_ROW, Scene};
use super::search::Weights;

/// What is left of every reading beside its set-up, in the order of [`Scene::items`], mm or rad.
#[derive(Clone, Debug, Default)]
pub struct Account {
    /// By the model.
    pub before: Vec<f64>,
    /// By the model with all findings.
    pub after: Vec<f64>,
    /// Whether it counted; what did not is as it was read.
    pub counts: Vec<bool>,
}

impl Account {
    /// Puts together what is left of the data used and of the data held out, each with its weights; `raw` and `explained` are the readings that do
    /// not count, before and after.
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

/// By how much a finding alone swings the readings of a set-up: the largest less the smallest of what it does to one of their values, of the set-up
/// where that is most.
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
