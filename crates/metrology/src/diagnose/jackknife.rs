//! Uncertainty of amounts from leaving out parts of the readings (Miller 1974). It includes effects that no noise model contains.

use super::cause::{Candidate, EffectKind};
use super::fold::{NO_PART, repeats, stretches};
use super::scene::Scene;
use super::search::{Field, Weights};
use super::size::{Amounts, Size, size};
use nalgebra::DMatrix;
use ncfix_base::numeric::student;

/// Minimum number of parts.
const FEWEST: usize = 4;
/// Maximum number of parts. The fewer they are, the wider is the interval by Student's factor: by 31 % for 6, by 12 % for 12.
const PARTS: usize = 12;
/// The change due to a part counts fully up to this multiple of the change that noise would cause with equally informative parts.
const LEVERAGE: f64 = 4.0;
/// A column is determined if at least this share of its squares remains beside the others.
const DETERMINED: f64 = 1e-9;
/// Probability outside the interval.
const OUTSIDE: f64 = 0.05;

/// Amounts of all columns without one part, and their covariance at unit noise.
pub(super) struct Without {
    values: Vec<f64>,
    covariance: DMatrix<f64>,
}

impl Without {
    /// Returns the amounts of one candidate, at this variance of the noise.
    pub(super) fn of(&self, range: &std::ops::Range<usize>, noise: f64) -> Amounts {
        Amounts {
            values: self.values.get(range.clone()).unwrap_or_default().to_vec(),
            covariance: range
                .clone()
                .map(|k| range.clone().map(|l| noise * self.covariance[(k, l)]).collect())
                .collect(),
        }
    }
}

/// Amounts of all columns, each fitted without one part. Parts are runs or set-ups, otherwise blocks of rows. With `has_changes`, a part may be the only
/// one after a change of the machine: the amount of the error that has changed then has no variance.
pub(super) fn without_parts(
    field: &Field<'_, '_>,
    weights: &Weights,
    (columns, has_changes): (&[Vec<f64>], bool),
    memory: f64,
) -> Vec<Without> {
    let counted = |parts: &[usize]| {
        let mut all: Vec<usize> =
            parts.iter().zip(&weights.items).filter(|(_, weight)| **weight > 0.0).map(|(part, _)| *part).collect();
        all.retain(|part| *part != NO_PART);
        all.sort_unstable();
        all.dedup();
        all
    };
    let mut parts = repeats(field.scene, weights, PARTS);
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
        let (values, mut covariance) = field.series(&rest, &[], memory).amounts(columns);
        for k in (0..columns.len()).filter(|&k| has_changes && !is_determined(field, &rest, (columns, k), memory)) {
            covariance.row_mut(k).fill(0.0);
            covariance.column_mut(k).fill(0.0);
        }
        Without { values, covariance }
    };
    numbers.iter().map(without).collect()
}

/// True if some readings determine the amount of a column beside the other columns.
fn is_determined(field: &Field<'_, '_>, weights: &Weights, (columns, k): (&[Vec<f64>], usize), memory: f64) -> bool {
    let Some(own) = columns.get(k) else { return false };
    let mut series = field.series(weights, &[], memory);
    series.set_values(own);
    let whole = series.squares();
    for (_, column) in columns.iter().enumerate().filter(|(other, _)| *other != k) {
        series.take(column);
    }
    series.squares() > DETERMINED * whole
}

/// Returns the expanded uncertainty (95 %) of a size from its values without each part; `None` if too few parts leave the size determined.
///
/// If one part determines most of the size, its omission changes the size by noise alone. A change beyond that counts in proportion (leverage: Bell &
/// `McCaffrey` 2002). With equally informative parts this is Miller's jackknife.
pub(super) fn u95(
    candidate: &Candidate,
    amounts: &Amounts,
    without: &[Amounts],
    scene: &Scene<'_>,
    used: usize,
) -> Option<f64> {
    // An effect that exists in one part only is absent from the others.
    if matches!(candidate.cause.effect, EffectKind::Setup | EffectKind::Earlier | EffectKind::Drift) {
        return None;
    }
    let whole = size(candidate, amounts, scene, used);
    let without: Vec<Size> = without.iter().map(|amounts| size(candidate, amounts, scene, used)).collect();
    scatter([whole.value, whole.u95], &without.iter().map(|size| [size.value, size.u95]).collect::<Vec<_>>())
}

/// Returns this uncertainty for a size and its formal uncertainty, and for those without each part.
fn scatter([whole, formal]: [f64; 2], without: &[[f64; 2]]) -> Option<f64> {
    // Without a variance, the omitted part alone determined the size.
    let told: Vec<[f64; 2]> = without.iter().copied().filter(|[_, u95]| *u95 > 0.0).collect();
    if told.len() < FEWEST {
        return None;
    }
    let count = told.len() as f64;
    let most = LEVERAGE * formal.powi(2) / (count - 1.0);
    let square = |[value, u95]: &[f64; 2]| {
        let expected = u95.powi(2) - formal.powi(2);
        (value - whole).powi(2) * if expected > most { most / expected } else { 1.0 }
    };
    let sigma = (told.iter().map(square).sum::<f64>() * (count - 1.0) / count).sqrt();
    Some(student::limit(OUTSIDE, count - 1.0) * sigma).filter(|u95| u95.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use crate::diagnose::scene::Through;

    /// Sum of twelve uniform numbers (xorshift): nearly normal, variance 1.
    struct Noise(u64);

    impl Noise {
        fn draw(&mut self) -> f64 {
            let mut even = || {
                self.0 ^= self.0 << 13;
                self.0 ^= self.0 >> 7;
                self.0 ^= self.0 << 17;
                (self.0 >> 11) as f64 / (1_u64 << 53) as f64
            };
            (0..12).map(|_| even()).sum::<f64>() - 6.0
        }
    }

    /// Mean of parts with different weights: noise 1 per reading, and an offset of each part.
    fn median_of(weights: &[f64], own: f64) -> f64 {
        let mut random = Noise(11);
        let whole: f64 = weights.iter().sum();
        let mut all: Vec<f64> = (0..401)
            .map(|_| {
                let values: Vec<f64> =
                    weights.iter().map(|weight| random.draw() / weight.sqrt() + own * random.draw()).collect();
                let mean = |left_out: usize| {
                    let kept = || weights.iter().zip(&values).enumerate().filter(move |(k, _)| *k != left_out);
                    let weight: f64 = kept().map(|(_, (weight, _))| weight).sum();
                    [kept().map(|(_, (weight, value))| weight * value).sum::<f64>() / weight, 1.96 / weight.sqrt()]
                };
                let without: Vec<[f64; 2]> = (0..weights.len()).map(mean).collect();
                scatter([mean(weights.len())[0], 1.96 / whole.sqrt()], &without).unwrap() / (1.96 / whole.sqrt())
            })
            .collect();
        all.sort_by(f64::total_cmp);
        all[200]
    }

    #[test]
    fn parts_that_differ_by_their_noise_alone_do_not_widen_it_much() {
        // Student's factor of six parts is 2.57: 1.3 of 1.96.
        assert!((0.9..1.5).contains(&median_of(&[10.0; 6], 0.0)));
        // One part determines nearly all of it.
        let uneven = median_of(&[1000.0, 1.0, 1.0, 1.0, 1.0, 1.0], 0.0);
        assert!((0.3..3.0).contains(&uneven), "{uneven}");
    }

    #[test]
    fn parts_that_do_not_agree_widen_it() {
        // Each part has an offset of ten times its noise.
        let noise = 1.0 / 10_f64.sqrt();
        assert!(median_of(&[10.0; 6], 10.0 * noise) > 7.0);
    }

    #[test]
    fn a_part_that_alone_tells_it_does_not_count() {
        let without = [[5.1, 0.2], [4.9, 0.2], [5.0, 0.2], [5.05, 0.2], [0.0, 0.0]];
        let u95 = scatter([5.0, 0.18], &without).unwrap();
        assert!(u95 < 0.6, "{u95}");
        assert_eq!(scatter([5.0, 0.18], &without[2..]), None);
    }

    #[test]
    fn a_part_counts_in_full_up_to_its_leverage() {
        // Five parts. Without one of them, the variance is 17 instead of 1, an excess of 16. Only 4 · 1/(5 − 1) = 1 counts: its square of 16 counts as 1.
        let without = [[14.0, 17.0_f64.sqrt()], [10.0, 1.0], [10.0, 1.0], [10.0, 1.0], [10.0, 1.0]];
        let found = scatter([10.0, 1.0], &without).unwrap();
        // Student's factor of four degrees of freedom is 2.776445; √(1 · 4/5) of it.
        assert!((found - 2.776_445 * 0.8_f64.sqrt()).abs() < 1e-4, "{found}");
    }

    #[test]
    fn fewer_than_four_parts_say_nothing() {
        let machine = bench::machine();
        let found = |rows: usize| {
            let sets = [bench::reads_along_x(&machine, &vec![1.0; rows])];
            let scene = bench::scene(&machine, &sets);
            let field = Field::new(&scene, vec![bench::candidate(EffectKind::Unknown, Through::Tip(0), |_| 1.0)]);
            let columns = field.columns_of(0);
            without_parts(&field, &bench::even(&scene), (&columns, false), 0.0).len()
        };
        // A run is divided into five blocks; a short one has as many blocks as readings.
        assert_eq!([3, 4, 50].map(found), [0, 4, 5]);
    }
}
