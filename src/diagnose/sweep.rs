//! Periods in position: which one of many a residual has, without trying each in full.
//!
//! For readings r with factors f at positions x, |Σ f r exp(2πi x/p)|² against half of Σ f² is what a sine and a cosine of period p would explain
//! were they at right angles to all else. Positions are put into bins that are fine beside the shortest period, and a Fourier transform gives
//! all periods at once. What comes out is a proposal: how much it explains is found in full.

use std::fmt;
use std::sync::Arc;

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

/// Bins over the travel.
const BINS: usize = 4096;
/// Bins of the transform: the travel and so many times nothing behind it, so that no peak falls between two frequencies.
const LENGTH: usize = 8 * BINS;
/// Cycles over the travel, at least: fewer are smooth.
const FEWEST: f64 = 3.0;
/// At most: a tenth of a radian for a bin.
const MOST: f64 = 130.0;
/// A period explains nearly as much as another by this share of it.
const NEARLY: f64 = 0.95;
/// Periods that are told apart for one cycle more over the travel.
const STEPS: f64 = 3.0;

/// A Fourier transform of real numbers with nothing behind them.
#[derive(Clone)]
pub(super) struct Transform(Arc<dyn Fft<f64>>);

impl Transform {
    /// To so many frequencies.
    pub(super) fn new(length: usize) -> Transform {
        Transform(FftPlanner::new().plan_fft_forward(length.max(1)))
    }

    /// How many.
    pub(super) fn length(&self) -> usize {
        self.0.len()
    }

    /// Squares of the amplitudes of the first frequencies, from 0 on.
    pub(super) fn powers(&self, values: &[f64], first: usize) -> Vec<f64> {
        let mut all: Vec<Complex<f64>> = values.iter().map(|&value| Complex::new(value, 0.0)).collect();
        all.resize(self.length(), Complex::default());
        self.0.process(&mut all);
        all.iter().take(first).map(|one| one.norm_sqr()).collect()
    }
}

impl fmt::Debug for Transform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Transform({})", self.length())
    }
}

/// Positions in bins.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    travel: f64,
    most: f64,
    bins: Vec<u32>,
    transform: Transform,
}

impl Sweep {
    /// By positions, one for each reading; `None` where they are too few for any period.
    pub(super) fn new(positions: &[f64]) -> Option<Sweep> {
        let mut places: Vec<f64> = positions.iter().copied().filter(|place| place.is_finite()).collect();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|a, b| (*a - *b).abs() < 1e-3);
        let (first, last) = (*places.first()?, *places.last()?);
        let travel = last - first;
        // Places that are evenly spaced cannot tell a period below two steps from a longer one.
        let mut steps: Vec<f64> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        let step = *steps.get(steps.len() / 2)?;
        let most = (travel / (2.5 * step)).min(MOST);
        let bin = |place: &f64| {
            let share = if place.is_finite() { (place - first) / travel } else { 0.0 };
            (share * (BINS - 1) as f64).round() as u32
        };
        let bins = || positions.iter().map(bin).collect();
        (most > FEWEST).then(|| Sweep { travel, most, bins: bins(), transform: Transform::new(LENGTH) })
    }

    /// The range of the positions.
    pub(super) fn travel(&self) -> f64 {
        self.travel
    }

    /// How many periods it tells apart.
    pub(super) fn count(&self) -> usize {
        ((self.most - FEWEST) * STEPS) as usize + 1
    }

    /// The period that explains most of `products` = f r, mm.
    pub(super) fn best(&self, products: &[f64]) -> f64 {
        let (step, powers, range) = self.powers(products);
        self.travel / (step * top(&powers, range))
    }

    /// The longest period that explains nearly as much as the best: where some of the readings stand evenly, shorter ones are its images.
    pub(super) fn longest(&self, products: &[f64]) -> f64 {
        let (step, powers, range) = self.powers(products);
        let at = |place: usize| powers.get(place).copied().unwrap_or(0.0);
        let most = range.clone().map(at).fold(0.0, f64::max);
        let is_top = |&place: &usize| {
            at(place) >= NEARLY * most && at(place) >= at(place + 1) && at(place) >= at(place.saturating_sub(1))
        };
        let first = range.clone().find(is_top).unwrap_or(range.start);
        self.travel / (step * top(&powers, first..first + 1))
    }

    /// Cycles over the travel of each frequency, squares of the amplitudes, and which of them count.
    fn powers(&self, products: &[f64]) -> (f64, Vec<f64>, std::ops::Range<usize>) {
        let mut bins = vec![0.0; BINS];
        for (&bin, product) in self.bins.iter().zip(products) {
            if let Some(sum) = bins.get_mut(bin as usize) {
                *sum += product;
            }
        }
        let step = (BINS - 1) as f64 / self.transform.length() as f64;
        let (from, until) = ((FEWEST / step).ceil() as usize, (self.most / step) as usize);
        (step, self.transform.powers(&bins, until + 2), from..until + 1)
    }
}

/// Where the largest of some values is, between them as a parabola has it.
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
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn it_finds_the_period() {
        let positions: Vec<f64> = (0..2000).map(|k| 50.0 + 200.0 * f64::from(k) / 2000.0).collect();
        let sweep = Sweep::new(&positions).unwrap();
        for period in [10.0, 7.3, 40.0, 2.1] {
            let products: Vec<f64> = positions.iter().map(|x| (TAU * x / period + 0.4).sin()).collect();
            let found = sweep.best(&products);
            assert!((found / period - 1.0).abs() < 0.02, "{period}: {found}");
        }
    }
}
