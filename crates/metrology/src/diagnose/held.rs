//! Readings before and after, of what was used and of what was held out: sizes, Spaan's efficiency, and how sure they are.
//!
//! Intervals are those of a bootstrap of stretches of rows (Künsch 1989): neighbouring readings stay together, so that slow noise counts for what it is.

use super::fold::counts;
use super::noise::is_angle;
use super::scene::Scene;
use super::search::Weights;

/// Stretches in all, about.
const STRETCHES: usize = 60;
/// Rows of a stretch at least.
const LEAST: usize = 4;
/// How often is drawn.
const DRAWS: usize = 400;
/// Stretches from which an interval of 95 % can be drawn: all of six have the same sign by chance in one case of 64.
const DRAWN: usize = 6;
/// A model is worse than none only where it leaves so much more, as a share of the root of the mean square.
const WORSE: f64 = 0.02;
/// Sums of a stretch.
const SUMS: usize = 10;
/// Places of the ends of an interval of 95 % among the draws.
const ENDS: [usize; 2] = [9, 389];

/// Sizes of some readings, mm or rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sizes {
    /// Root of the mean square.
    pub rms: f64,
    /// Its interval of 95 %.
    pub interval: [f64; 2],
    /// Largest.
    pub max: f64,
    /// 1 − Σ|left| / Σ|measured| (Spaan 1995, eq. 3.6).
    pub efficiency: f64,
}

/// Readings of a machine without errors, of the model, and of the model with all findings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Compared {
    /// Of no model.
    pub measured: Sizes,
    /// Of the model.
    pub before: Sizes,
    /// With the findings.
    pub after: Sizes,
    /// By how much the root of the mean square falls, as a share, and its interval of 95 %: of lengths and angles together, in units of their
    /// noise.
    pub gain: (f64, [f64; 2]),
    /// Whether the model is worse than none, surely.
    pub is_expired: bool,
    /// Readings.
    pub readings: usize,
}

/// Compares; all three in the order of the readings, mm or rad.
pub(super) fn compare(scene: &Scene<'_>, weights: &Weights, of: [&[f64]; 3]) -> Compared {
    let of_angles = is_angle(scene);
    let places: Vec<usize> = counts(scene, weights);
    let has_size = |place: usize| scene.items.get(place).is_some_and(|item| item.is_angle == of_angles);
    let stretch = (places.len() / STRETCHES).max(LEAST);
    // Sums over stretches: squares and sizes of all three, readings; squares in units of the noise, which lengths and angles share.
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
        // 60 stretches of four rows, of which every other one reads 2 and the others nothing; the model halves them, findings take a tenth.
        let measured: Vec<f64> = (0..240).map(|row| if row / 4 % 2 == 0 { 2.0 } else { 0.0 }).collect();
        let [before, after] = [0.5, 0.1].map(|share| measured.iter().map(|value| value * share).collect::<Vec<f64>>());
        let sets = [bench::reads_along_x(&machine, &[0.0; 240])];
        let scene = bench::scene(&machine, &sets);
        let found = compare(&scene, &bench::even(&scene), [&measured, &before, &after]);
        assert!((found.measured.rms - 2.0_f64.sqrt()).abs() < 1e-12 && found.measured.max == 2.0);
        // The share of those with readings is 1/2 with a standard deviation of √(1/4 / 60) = 0.065: 4 · (0.5 ∓ 1.96 · 0.065) are the mean squares.
        let sigma = (0.25_f64 / 60.0).sqrt();
        for (end, sign) in found.measured.interval.iter().zip([-1.0, 1.0]) {
            let expected = (4.0 * (0.5 + sign * 1.96 * sigma)).sqrt();
            assert!((end - expected).abs() < 0.05, "{end} {expected}");
        }
        assert_eq!([found.before, found.after].map(|sizes| (sizes.efficiency * 1e9).round() / 1e9), [0.5, 0.9]);
        // Of a model that takes half of everything away nothing depends on what is drawn.
        assert!((found.gain.0 - 0.8).abs() < 1e-12 && found.gain.1.iter().all(|end| (end - 0.8).abs() < 1e-9));
        assert!(!found.is_expired && found.readings == 240);
    }
}
