//! Periods in position: which one of many a residual has, without trying each in full.
//!
//! For readings r with factors f at positions x, |Σ f r exp(2πi x/p)|² against half of Σ f² is what a sine and a cosine of period p would explain
//! were they at right angles to all else. Positions are put into bins that are fine beside the shortest period, so that a period costs
//! bins, not readings. What comes out is a proposal: how much it explains is found in full.

use std::f64::consts::TAU;

/// Bins over the travel.
const BINS: usize = 4096;
/// Cycles over the travel, at least: fewer are smooth.
const FEWEST: f64 = 3.0;
/// At most: a tenth of a radian for a bin.
const MOST: f64 = 130.0;
/// Steps of the grid for one cycle more over the travel.
const STEPS: f64 = 3.0;
/// Finer steps about the best one.
const FINE: i32 = 10;

/// Positions in bins.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    travel: f64,
    most: f64,
    bins: Vec<u32>,
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
        (most > FEWEST).then(|| Sweep { travel, most, bins: positions.iter().map(bin).collect() })
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
        let mut bins = vec![0.0; BINS];
        for (&bin, product) in self.bins.iter().zip(products) {
            if let Some(sum) = bins.get_mut(bin as usize) {
                *sum += product;
            }
        }
        let power = |cycles: f64| {
            let (turn_sin, turn_cos) = (TAU * cycles / (BINS - 1) as f64).sin_cos();
            let (mut sin, mut cos) = (0.0, 1.0);
            let (mut sines, mut cosines) = (0.0, 0.0);
            for value in &bins {
                sines += value * sin;
                cosines += value * cos;
                (sin, cos) = (sin * turn_cos + cos * turn_sin, cos * turn_cos - sin * turn_sin);
            }
            sines * sines + cosines * cosines
        };
        let better = |best: (f64, f64), cycles: f64| {
            let own = power(cycles);
            if own > best.0 { (own, cycles) } else { best }
        };
        let coarse = (0..self.count()).map(|k| FEWEST + k as f64 / STEPS).fold((0.0, FEWEST), better);
        let near = (-FINE..=FINE).map(|k| coarse.1 + f64::from(k) / (STEPS * f64::from(FINE)));
        let fine = near.fold(coarse, better);
        self.travel / fine.1
    }
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
            let found = sweep.best(&products);
            assert!((found / period - 1.0).abs() < 0.02, "{period}: {found}");
        }
    }
}
