//! How much amounts change when a part of the readings is left out: what no model of the noise says, the readings do (Miller 1974).

use super::cause::{Candidate, Effect};
use super::fold::{NO_PART, repeats, stretches};
use super::scene::Scene;
use super::search::{Field, Weights};
use super::size::{Amounts, Size, size};
use crate::numeric::student;

/// Parts at least.
const FEWEST: usize = 4;
/// Chance outside the interval.
const OUTSIDE: f64 = 0.05;

/// Amounts of all columns, each without one part: runs or set-ups, else stretches of rows.
pub(super) fn without_parts(
    field: &Field<'_, '_>,
    weights: &Weights,
    columns: &[Vec<f64>],
    memory: f64,
) -> Vec<Vec<f64>> {
    let counted = |parts: &[usize]| {
        let mut all: Vec<usize> =
            parts.iter().zip(&weights.items).filter(|(_, weight)| **weight > 0.0).map(|(part, _)| *part).collect();
        all.retain(|part| *part != NO_PART);
        all.sort_unstable();
        all.dedup();
        all
    };
    let mut parts = repeats(field.scene, weights);
    let mut numbers = counted(&parts);
    if numbers.len() < FEWEST {
        parts = stretches(field.scene, 1);
        numbers = counted(&parts);
    }
    if columns.is_empty() || numbers.len() < FEWEST {
        return Vec::new();
    }
    let without = |number: &usize| {
        let items = weights.items.iter().zip(&parts).map(|(weight, part)| if part == number { 0.0 } else { *weight });
        let rest = Weights { items: items.collect(), series: weights.series.clone() };
        field.series(&rest, &[], memory).amounts(columns).0
    };
    numbers.iter().map(without).collect()
}

/// The expanded uncertainty (95 %) of a size by what it is without each part; `None` where parts take with them what shows it.
pub(super) fn u95(
    candidate: &Candidate,
    amounts: &Amounts,
    without: &[Vec<f64>],
    scene: &Scene<'_>,
    used: usize,
) -> Option<f64> {
    // What happened in one part is not in the others.
    if matches!(candidate.cause.effect, Effect::Setup | Effect::Drift) || without.len() < FEWEST {
        return None;
    }
    let of = |values: &Vec<f64>| size(candidate, &Amounts { values: values.clone(), ..amounts.clone() }, scene, used);
    let sizes: Vec<Size> = without.iter().map(of).collect();
    let count = sizes.len() as f64;
    let mean = sizes.iter().map(|size| size.value).sum::<f64>() / count;
    let squares: f64 = sizes.iter().map(|size| (size.value - mean).powi(2)).sum();
    let sigma = (squares * (count - 1.0) / count).sqrt();
    Some(student::limit(OUTSIDE, count - 1.0) * sigma).filter(|u95| u95.is_finite())
}
