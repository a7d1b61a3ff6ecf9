//! Periods in position: finds the period that explains most of a residual, without a fit of each one.
//!
//! For readings r with factors f at positions x, the gain of a sine and a cosine over a constant follows from Σ f r exp(2πi x ν) and Σ f² exp(2πi x ν) at ν
//! and 2ν. Positions are sorted into bins that are short compared with the shortest period. One Fourier transform then gives both sums for all periods. The
//! result is a proposal; a full fit determines its gain.
//!
//! Evenly spaced places cannot distinguish a period from its aliases, so periods below two steps are excluded. Uneven steps can distinguish them. Uneven by a
//! small share of a step, they leave a slow wave an alias that explains nearly as much. So a period below two steps must explain clearly more than any slow wave,
//! which is a smooth shape and no period.

use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

/// Number of bins over the travel.
const BINS: usize = 8192;
/// Number of bins of the transform: a multiple of the travel, padded with zeros, so that peaks between two frequencies are found.
const LENGTH: usize = 4 * BINS;
/// Minimum number of cycles over the travel: fewer are smooth shapes.
const FEWEST: f64 = 3.0;
/// Number of cycles over the travel of the slowest wave that is compared with short ones: half a cycle, a bow.
const SLOWEST: f64 = 0.5;
/// A slow wave explains as much as a short one from this share on: the frequencies of the transform miss its peak by up to an eighth of a cycle.
const AS_MUCH: f64 = 0.9;
/// Maximum: half a bin is a tenth of a radian.
const MOST: f64 = 250.0;
/// Number of distinguishable periods per cycle over the travel.
const STEPS: f64 = 3.0;
/// A wave is indistinguishable from a constant if the square of the mean of exp(2πi x ν) over the places exceeds this.
const ALIKE: f64 = 0.98;
/// Same limit for binned positions.
const NEARLY_ALIKE: f64 = 0.8;
/// Minimum number of places, and maximum number of cycles per place: with few places, some wave fits anything.
const FEWEST_PLACES: usize = 8;
const PER_PLACE: f64 = 6.0;
/// Sine and cosine must be independent: minimum product of their remaining squares.
const TOLD: f64 = 0.02;
/// Maximum number of peaks.
const PEAKS: usize = 12;

/// Fourier transform of real numbers, padded with zeros.
#[derive(Clone)]
pub(super) struct FourierTransform(Arc<dyn Fft<f64>>);

impl FourierTransform {
    /// Number of frequencies.
    pub(super) fn new(length: usize) -> FourierTransform {
        FourierTransform(FftPlanner::new().plan_fft_forward(length.max(1)))
    }

    /// Number of values.
    pub(super) fn length(&self) -> usize {
        self.0.len()
    }

    /// Squares of the amplitudes of the first frequencies, from 0 on.
    pub(super) fn powers(&self, values: &[f64], first: usize) -> Vec<f64> {
        let all = values.iter().map(|&value| Complex::new(value, 0.0)).collect();
        self.of(all).iter().take(first).map(|one| one.norm_sqr()).collect()
    }

    /// All frequencies.
    pub(super) fn of(&self, mut all: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
        all.resize(self.length(), Complex::default());
        self.0.process(&mut all);
        all
    }
}

impl fmt::Debug for FourierTransform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Transform({})", self.length())
    }
}

/// Positions in bins.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    travel: f64,
    most: f64,
    /// Smallest number of cycles over the travel that is indistinguishable from a constant; infinite for uneven steps.
    replica: f64,
    /// Number of steps over the travel: its length in median steps.
    steps: f64,
    bins: Vec<u32>,
    transform: FourierTransform,
}

/// Returns the cycles over the travel of a frequency of the transform.
const STEP: f64 = (BINS - 1) as f64 / LENGTH as f64;

impl Sweep {
    /// Takes one position for each reading; `None` if there are too few for any period.
    pub(super) fn new(positions: &[f64]) -> Option<Sweep> {
        let mut places: Vec<f64> = positions.iter().copied().filter(|place| place.is_finite()).collect();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|a, b| (*a - *b).abs() < 1e-3);
        let (first, last) = (*places.first()?, *places.last()?);
        let travel = last - first;
        let bin = |place: &f64| {
            let share = if place.is_finite() { (place - first) / travel } else { 0.0 };
            (share * (BINS - 1) as f64).round() as u32
        };
        let transform = FourierTransform::new(LENGTH);
        let shares: Vec<f64> = places.iter().map(|place| (place - first) / travel).collect();
        if shares.len() < FEWEST_PLACES {
            return None;
        }
        let replica = replica(&transform, &shares);
        let most = (replica / 2.0).min(MOST).min(PER_PLACE * shares.len() as f64);
        let bins = || positions.iter().map(bin).collect();
        let mut gaps: Vec<f64> = shares.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let middle = gaps.len() / 2;
        let steps = gaps.select_nth_unstable_by(middle, f64::total_cmp).1.recip();
        (most > FEWEST && travel > 0.0).then(|| Sweep { travel, most, replica, steps, bins: bins(), transform })
    }

    /// Range of the positions.
    pub(super) fn travel(&self) -> f64 {
        self.travel
    }

    /// Number of distinguishable periods.
    pub(super) fn count(&self) -> usize {
        ((self.most - FEWEST) * STEPS) as usize + 1
    }

    /// Returns the aliases of a period on evenly spaced places, the longest first.
    pub(super) fn aliases(&self, period: f64) -> Vec<f64> {
        let cycles = self.travel / period;
        if !self.replica.is_finite() {
            return Vec::new();
        }
        let times = (MOST / self.replica) as u32 + 1;
        let all = (1..=times).map(f64::from).flat_map(|k| [k * self.replica - cycles, k * self.replica + cycles]);
        all.filter(|other| (FEWEST..MOST).contains(other)).map(|other| self.travel / other).collect()
    }

    /// Returns the period that explains most, from f r and f² by reading, mm; `None` if it is shorter than two steps and a slow wave explains as much.
    pub(super) fn best(&self, products: &[f64], information: &[f64]) -> Option<f64> {
        let gains = self.gains(products, information, self.most);
        let best = top(&gains, first()..gains.len().saturating_sub(1));
        let most_of =
            |range: std::ops::Range<usize>| gains.get(range).unwrap_or_default().iter().copied().fold(0.0, f64::max);
        let is_short = STEP * best > 0.5 * self.steps;
        let is_slow = most_of((SLOWEST / STEP) as usize..first()) >= AS_MUCH * most_of(first()..gains.len());
        (!is_short || !is_slow).then(|| self.travel / (STEP * best))
    }

    /// Returns the periods that explain at least a share of the best gain, including their aliases, the best first.
    pub(super) fn peaks(&self, products: &[f64], information: &[f64], share: f64) -> Vec<f64> {
        let gains = self.gains(products, information, MOST);
        let at = |place: usize| gains.get(place).copied().unwrap_or(0.0);
        let best = gains.iter().skip(first()).copied().fold(0.0, f64::max);
        let mut peaks: Vec<usize> = (first()..gains.len().saturating_sub(1))
            .filter(|&k| at(k) >= share * best && at(k) > at(k - 1) && at(k) >= at(k + 1))
            .collect();
        peaks.sort_by(|&a, &b| at(b).total_cmp(&at(a)));
        peaks.truncate(PEAKS);
        peaks.into_iter().map(|k| self.travel / (STEP * top(&gains, k..k + 1))).collect()
    }

    /// Returns the gains of waves of all frequencies up to a number of cycles, in addition to a constant.
    fn gains(&self, products: &[f64], information: &[f64], most: f64) -> Vec<f64> {
        let mut bins = vec![Complex::new(0.0, 0.0); BINS];
        for ((&bin, product), own) in self.bins.iter().zip(products).zip(information) {
            if let Some(sum) = bins.get_mut(bin as usize) {
                sum.re += product;
                sum.im += own;
            }
        }
        // Both inputs are real: their transforms are separated by the symmetry of positive and negative frequencies.
        let all = self.transform.of(bins);
        let both = |k: usize| {
            let one = all.get(k).copied().unwrap_or_default();
            let other = if k == 0 { one } else { all.get(all.len() - k).copied().unwrap_or_default() }.conj();
            (0.5 * (one + other), Complex::new(0.0, -0.5) * (one - other))
        };
        let whole = both(0).1.re;
        let until = (most / STEP) as usize + 2;
        let gain = |k: usize| {
            let (sums, first) = both(k);
            let second = both(2 * k).1;
            if whole <= 0.0 {
                return 0.0;
            }
            // A constant is included, because set-ups absorb it.
            let cosines = 0.5 * (whole + second.re) - first.re * first.re / whole;
            let sines = 0.5 * (whole - second.re) - first.im * first.im / whole;
            let mixed = 0.5 * second.im - first.re * first.im / whole;
            let told = cosines * sines - mixed * mixed;
            if told < TOLD * (0.5 * whole).powi(2) {
                return 0.0;
            }
            let (u, v) = (sums.re, sums.im);
            (u * u * sines - 2.0 * u * v * mixed + v * v * cosines) / told
        };
        (0..until).map(gain).collect()
    }
}

/// Returns the first frequency that counts as a period.
fn first() -> usize {
    (FEWEST / STEP).ceil() as usize
}

/// Returns the smallest number of cycles over a travel that is indistinguishable from a constant at some places (shares of the travel); infinite if every
/// number is distinguishable.
fn replica(transform: &FourierTransform, places: &[f64]) -> f64 {
    let count = places.len() as f64;
    let mut bins = vec![0.0; BINS];
    for place in places {
        if let Some(sum) = bins.get_mut((place * (BINS - 1) as f64).round() as usize) {
            *sum += 1.0 / count;
        }
    }
    let rough = transform.powers(&bins, (2.0 * MOST / STEP) as usize + 2);
    let power = |cycles: f64| {
        let each = places.iter().map(|place| (TAU * cycles * place).sin_cos());
        let (real, imaginary) = each.fold((0.0, 0.0), |sum, (sine, cosine)| (sum.0 + cosine, sum.1 + sine));
        (real * real + imaginary * imaginary) / (count * count)
    };
    let at = |k: usize| rough.get(k).copied().unwrap_or(0.0);
    let peaks = (first()..rough.len()).filter(|&k| at(k) > NEARLY_ALIKE && at(k) >= at(k - 1) && at(k) > at(k + 1));
    for peak in peaks {
        let cycles = STEP * top(&rough, peak..peak + 1);
        if power(cycles) > ALIKE {
            return cycles;
        }
    }
    f64::INFINITY
}

/// Returns the position of the maximum of some values, interpolated by a parabola.
pub(super) fn top(powers: &[f64], range: std::ops::Range<usize>) -> f64 {
    let at = |place: usize| powers.get(place).copied().unwrap_or(0.0);
    let start = range.start;
    let best = range.max_by(|&a, &b| at(a).total_cmp(&at(b))).unwrap_or(start);
    let (before, own, behind) = (at(best.saturating_sub(1)), at(best), at(best + 1));
    let bend = before - 2.0 * own + behind;
    let shift = if bend < 0.0 { 0.5 * (before - behind) / bend } else { 0.0 };
    best as f64 + shift.clamp(-0.5, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_the_period() {
        let positions: Vec<f64> = (0..2000).map(|k| 50.0 + 200.0 * f64::from(k) / 2000.0).collect();
        let sweep = Sweep::new(&positions).unwrap();
        for period in [10.0, 7.3, 40.0, 2.1] {
            let products: Vec<f64> = positions.iter().map(|x| (TAU * x / period + 0.4).sin()).collect();
            let found = sweep.best(&products, &vec![1.0; positions.len()]).unwrap();
            assert!((found / period - 1.0).abs() < 0.02, "{period}: {found}");
        }
    }

    #[test]
    fn uneven_steps_tell_a_period_below_two_of_them() {
        // ISO 230-2 requires uneven steps: here they differ by thirds of a step, in both directions.
        let positions: Vec<f64> =
            (0..21).map(|k| 33.0 * f64::from(k) + [0.0, 9.0, -7.0, 4.0, -10.0][k as usize % 5]).collect();
        let sweep = Sweep::new(&positions).unwrap();
        let products: Vec<f64> = positions.iter().map(|x| (TAU * x / 10.0 + 1.0).sin()).collect();
        let found = sweep.best(&products, &[1.0; 21]).unwrap();
        assert!((found - 10.0).abs() < 0.1, "{found}");
        assert!(sweep.aliases(found).is_empty());
    }

    #[test]
    fn a_slow_wave_is_no_short_period() {
        // 33 places about 25 mm apart, uneven by at most 2 mm.
        let places: Vec<f64> = (0..33_u32).map(|k| 25.0 * f64::from(k) + f64::from(k * 7 % 5) - 2.0).collect();
        let sweep = Sweep::new(&places).unwrap();
        let found = |period: f64| {
            let wave: Vec<f64> = places.iter().map(|x| (TAU * x / period + 0.3).sin()).collect();
            // Set-ups have taken the constant.
            let mean = wave.iter().sum::<f64>() / 33.0;
            let products: Vec<f64> = wave.iter().map(|value| value - mean).collect();
            sweep.best(&products, &[1.0; 33])
        };
        for slow in [300.0, 400.0, 600.0, 1200.0] {
            assert_eq!(found(slow), None, "{slow}");
        }
        for period in [160.0, 80.0, 8.0] {
            assert!((found(period).unwrap() / period - 1.0).abs() < 0.02, "{period}: {:?}", found(period));
        }
    }

    #[test]
    fn even_steps_have_aliases() {
        let positions: Vec<f64> = (0..41).map(|k| 25.0 * f64::from(k)).collect();
        let sweep = Sweep::new(&positions).unwrap();
        let products: Vec<f64> = positions.iter().map(|x| (TAU * x / 16.0 + 1.0).sin()).collect();
        // 1/16 = 0.0625 is 1/25 + 0.0225 and 2/25 − 0.0175 and so on: the longest period has the frequency 0.0175.
        let found = sweep.best(&products, &[1.0; 41]).unwrap();
        assert!((found * 0.0175 - 1.0).abs() < 0.02, "{found}");
        let aliases = sweep.aliases(found);
        for frequency in [0.0225, 0.0575, 0.0625, 0.0975] {
            assert!(aliases.iter().any(|other| (other * frequency - 1.0).abs() < 0.02), "{frequency}: {aliases:?}");
        }
    }
}
