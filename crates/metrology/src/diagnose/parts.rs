//! Size of a cause in each file. A cause that acts in one file only, or differs between files, appeared or changed between them.
//!
//! The fit scales the overall effect of the cause in each file, together with the other terms.

use super::cause::{Candidate, EffectKind};
use super::scene::NO_ROW;
use super::search::{Field, Weights};

/// Minimum difference between files, in standard deviations,
const SURELY: f64 = 4.0;
/// and as a share of the largest value in a file.
const MUCH: f64 = 0.5;
/// A file determines the size if one standard deviation is below this share of the largest.
const TOLD: f64 = 0.2;
/// Half width of an interval of 95 %, in standard deviations.
const EXPANDED: f64 = 1.96;

/// Size of a cause in one file, relative to its size in all files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FileShare {
    /// Number of the measurement.
    pub set: usize,
    /// Relative size.
    pub share: f64,
    /// Its expanded uncertainty (95 %).
    pub u95: f64,
}

/// Relative sizes of a candidate by file if they differ significantly, otherwise empty. `others` are the other terms; `inflation` multiplies the variances of
/// independent readings.
pub(super) fn differing(
    field: &Field<'_, '_>,
    weights: &Weights,
    (candidate, amounts): (&Candidate, &[f64]),
    others: &[usize],
    (memory, inflation): (f64, f64),
) -> Vec<FileShare> {
    // A cause of one day or set-up differs from file to file.
    if matches!(
        candidate.cause.effect,
        EffectKind::Setup
            | EffectKind::Earlier
            | EffectKind::Drift
            | EffectKind::Sensor
            | EffectKind::Outlier
            | EffectKind::Program
    ) {
        return Vec::new();
    }
    // A separate finding describes its difference between files.
    let through = |one: &Candidate| one.columns.first().and_then(|parts| parts.first()).map(|(through, _)| *through);
    let is_earlier =
        |other: &Candidate| other.cause.effect == EffectKind::Earlier && through(other) == through(candidate);
    if others.iter().filter_map(|&number| field.candidates.get(number)).any(is_earlier) {
        return Vec::new();
    }
    let scene = field.scene;
    let set_of = |place: usize| {
        let item = scene.items.get(place).filter(|item| item.row != NO_ROW)?;
        let counts = weights.items.get(place).is_some_and(|weight| *weight > 0.0);
        scene.rows.get(item.row).filter(|_| counts).map(|row| row.set)
    };
    let sets: Vec<Option<usize>> = (0..scene.items.len()).map(set_of).collect();
    let mut does = vec![0.0; sets.len()];
    for (column, amount) in field.columns(candidate).iter().zip(amounts) {
        does.iter_mut().zip(column).for_each(|(sum, value)| *sum += amount * value);
    }
    let mut numbers: Vec<usize> =
        sets.iter().zip(&does).filter(|(_, does)| **does != 0.0).filter_map(|(set, _)| *set).collect();
    numbers.sort_unstable();
    numbers.dedup();
    if numbers.len() < 2 {
        return Vec::new();
    }
    let of_set = |set: &usize| -> Vec<f64> {
        does.iter().zip(&sets).map(|(does, own)| if *own == Some(*set) { *does } else { 0.0 }).collect()
    };
    let columns: Vec<Vec<f64>> = numbers.iter().map(of_set).collect();
    let mut series = field.series(weights, others, memory);
    let (shares, covariance) = series.amounts(&columns);
    columns.iter().for_each(|column| {
        series.take(column);
    });
    // Residual with a separate amount for each file.
    let freedom = series.count().saturating_sub(series.rank()).max(1) as f64;
    let variance = inflation * series.squares() / freedom;
    let sigma = |k: usize| (covariance[(k, k)] * variance).max(0.0).sqrt();
    let told = || (0..numbers.len()).filter(|&k| sigma(k) > 0.0);
    let most = told().filter(|&k| shares[k].abs() > SURELY * sigma(k)).map(|k| shares[k].abs()).fold(0.0, f64::max);
    let known: Vec<usize> = told().filter(|&k| sigma(k) < TOLD * most).collect();
    let differ = |(one, other): (usize, usize)| {
        let apart = (shares[one] - shares[other]).abs();
        let own = covariance[(one, one)] + covariance[(other, other)] - 2.0 * covariance[(one, other)];
        apart > MUCH * most && apart > SURELY * (own * variance).max(0.0).sqrt()
    };
    let pairs = known.iter().enumerate().flat_map(|(k, &one)| known.iter().skip(k + 1).map(move |&other| (one, other)));
    if !pairs.into_iter().any(differ) {
        return Vec::new();
    }
    known.into_iter().map(|k| FileShare { set: numbers[k], share: shares[k], u95: EXPANDED * sigma(k) }).collect()
}
