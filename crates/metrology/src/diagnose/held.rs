//! Residuals before and after, for the data used and held out: RMS, largest value and Spaan's efficiency, with their intervals.
//!
//! Intervals come from a block bootstrap (Künsch 1989): consecutive rows stay together, which preserves slowly varying noise.

use super::fold::counts;
use super::noise::is_angle;
use super::scene::Scene;
use super::search::Weights;

/// Approximate number of blocks.
const STRETCHES: usize = 60;
/// Minimum number of rows in a block.
const LEAST: usize = 4;
/// Number of bootstrap samples.
const DRAWS: usize = 400;
/// Minimum number of blocks for an interval of 95 %: six have the same sign by chance in one case of 64.
const DRAWN: usize = 6;
/// Minimum relative excess of the RMS at which a model counts as worse than none.
const WORSE: f64 = 0.02;
/// Sums of one block.
const SUMS: usize = 10;
/// Positions of the ends of the 95 % interval among the sorted samples.
const ENDS: [usize; 2] = [9, 389];

/// Summary of a set of readings, mm or rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sizes {
    /// RMS.
    pub rms: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
    /// Largest absolute value.
    pub max: f64,
    /// Efficiency 1 − Σ|residual| / Σ|measured| (Spaan 1995, eq. 3.6).
    pub efficiency: f64,
}

/// Residuals of a machine without errors, of the model, and of the model with all findings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Compared {
    /// Residuals of a machine without errors.
    pub measured: Sizes,
    /// Residuals of the model.
    pub before: Sizes,
    /// Residuals of the model with all findings.
    pub after: Sizes,
    /// Relative reduction of the RMS and its 95 % interval. Lengths and angles are combined in units of their noise.
    pub gain: (f64, [f64; 2]),
    /// True if the model is significantly worse than no model.
    pub is_expired: bool,
    /// Number of readings.
    pub readings: usize,
}

/// Compares three sets of residuals, all in the order of the readings, mm or rad.
pub(super) fn compare(scene: &Scene<'_>, weights: &Weights, of: [&[f64]; 3]) -> Compared {
    let of_angles = is_angle(scene);
    let places: Vec<usize> = counts(scene, weights);
    let has_size = |place: usize| scene.items.get(place).is_some_and(|item| item.is_angle == of_angles);
    let stretch = (places.len() / STRETCHES).max(LEAST);
    // Sums over blocks: squares and absolute values of all three, number of readings; squares in units of the noise, which is common to lengths and angles.
    let mut sums: Vec<[f64; SUMS]> = Vec::new();
    let mut last = (usize::MAX, 0);
    let mut most = [0.0_f64; 3];
    for &place in &places {
        let series = weights.series.get(place).copied().unwrap_or(0);
        if last.0 != series || last.1 >= stretch {
            sums.push([0.0; SUMS]);
            last = (series, 0);
        }
        last.1 += 1;
        let Some(sum) = sums.last_mut() else { continue };
        for (k, values) in of.iter().enumerate() {
            let value = values.get(place).copied().unwrap_or(0.0);
            sum[7 + k] += (value * weights.items.get(place).copied().unwrap_or(0.0)).powi(2);
            if has_size(place) {
                sum[k] += value * value;
                sum[3 + k] += value.abs();
                most[k] = most[k].max(value.abs());
            }
        }
        sum[6] += f64::from(u8::from(has_size(place)));
    }
    let total = |draw: &mut dyn Iterator<Item = usize>| {
        let mut all = [0.0; SUMS];
        for number in draw {
            if let Some(sum) = sums.get(number) {
                all.iter_mut().zip(sum).for_each(|(all, own)| *all += own);
            }
        }
        all
    };
    let rms = |all: &[f64; SUMS], k: usize| (all[k] / all[6].max(1.0)).sqrt();
    let whole = total(&mut (0..sums.len()));
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut draw = |count: usize| {
        // xorshift, Marsaglia 2003.
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % count.max(1) as u64) as usize
    };
    let draws: Vec<[f64; SUMS]> = (0..DRAWS)
        .map(|_| total(&mut (0..sums.len()).map(|_| draw(sums.len())).collect::<Vec<_>>().into_iter()))
        .collect();
    let interval = |value: &dyn Fn(&[f64; SUMS]) -> f64| {
        let mut all: Vec<f64> = draws.iter().map(value).collect();
        all.sort_by(f64::total_cmp);
        ENDS.map(|end| all.get(end).copied().unwrap_or(0.0))
    };
    let sizes = |k: usize| Sizes {
        rms: rms(&whole, k),
        interval: interval(&|all| rms(all, k)),
        max: most[k],
        efficiency: if whole[3] > 0.0 { 1.0 - whole[3 + k] / whole[3] } else { 0.0 },
    };
    let gain = |all: &[f64; SUMS]| if all[8] > 0.0 { 1.0 - (all[9] / all[8]).sqrt() } else { 0.0 };
    let worse = interval(&|all| all[8].sqrt() - (1.0 + WORSE) * all[7].sqrt());
    Compared {
        measured: sizes(0),
        before: sizes(1),
        after: sizes(2),
        gain: (gain(&whole), interval(&gain)),
        is_expired: sums.len() >= DRAWN && worse[0] > 0.0,
        readings: places.into_iter().filter(|&place| has_size(place)).count(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn intervals_are_those_of_draws_with_replacement_and_efficiency_is_of_sizes() {
        let machine = bench::machine();
        // 60 blocks of four rows. Every other row reads 2, the others 0. The model halves the readings, the findings leave a tenth.
        let measured: Vec<f64> = (0..240).map(|row| if row / 4 % 2 == 0 { 2.0 } else { 0.0 }).collect();
        let [before, after] = [0.5, 0.1].map(|share| measured.iter().map(|value| value * share).collect::<Vec<f64>>());
        let sets = [bench::reads_along_x(&machine, &[0.0; 240])];
        let scene = bench::scene(&machine, &sets);
        let found = compare(&scene, &bench::even(&scene), [&measured, &before, &after]);
        assert!((found.measured.rms - 2.0_f64.sqrt()).abs() < 1e-12 && found.measured.max == 2.0);
        // The share of rows with readings is 1/2 with a standard deviation of √(1/4 / 60) = 0.065. So the mean squares are 4 · (0.5 ∓ 1.96 · 0.065).
        let sigma = (0.25_f64 / 60.0).sqrt();
        for (end, sign) in found.measured.interval.iter().zip([-1.0, 1.0]) {
            let expected = (4.0 * (0.5 + sign * 1.96 * sigma)).sqrt();
            assert!((end - expected).abs() < 0.05, "{end} {expected}");
        }
        assert_eq!([found.before, found.after].map(|sizes| (sizes.efficiency * 1e9).round() / 1e9), [0.5, 0.9]);
        // If the model removes half of everything, the result does not depend on the sample.
        assert!((found.gain.0 - 0.8).abs() < 1e-12 && found.gain.1.iter().all(|end| (end - 0.8).abs() < 1e-9));
        assert!(!found.is_expired && found.readings == 240);
    }
}
