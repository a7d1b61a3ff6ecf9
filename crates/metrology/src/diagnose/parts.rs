//! A cause in every file by itself: what acts in one of them only, or differs from one to the next, came between them.
//!
//! Each file scales what the cause does as it was found in all; others stand beside it.

use super::cause::{Candidate, EffectKind};
use super::scene::NO_ROW;
use super::search::{Field, Weights};

/// Files differ by so many standard deviations,
const SURELY: f64 = 4.0;
/// and by this share of what the cause is where it is largest.
const MUCH: f64 = 0.5;
/// A file tells its size to within this share of the largest, one standard deviation.
const TOLD: f64 = 0.2;
/// Half width of an interval of 95 %, in standard deviations.
const EXPANDED: f64 = 1.96;

/// How large a cause is in one file, as a share of what it is in all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FileShare {
    /// Number of the measurement.
    pub set: usize,
    /// Share.
    pub share: f64,
    /// Expanded uncertainty (95 %) of it.
    pub u95: f64,
}

/// Shares of the amounts of a candidate by file, where they surely differ: none where they do not. `others` stand beside it, and variances are so many
/// times those of independent readings.
pub(super) fn differing(
    field: &Field<'_, '_>,
    weights: &Weights,
    (candidate, amounts): (&Candidate, &[f64]),
    others: &[usize],
    (memory, inflation): (f64, f64),
) -> Vec<FileShare> {
    // What belongs to a day or a set-up is another one in each.
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
    // Its difference between files has a finding of its own.
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
    // What is left when each has its own.
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
