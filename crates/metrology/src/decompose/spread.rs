//! Uncertainty of the shares: fitted values are moved within their covariance, and the shares evaluated again.
//!
//! Shares, maxima and RMS are not linear. Points at √n standard deviations along each of n independent directions, on both sides, have the covariance of the
//! fitted values, and so have the results to the second order (Julier and Uhlmann 2004, Proceedings of the IEEE 92, 401–422).

use nalgebra::DMatrix;

use ncfix_base::geometry::Vector;

use super::shares::{SourceShares, shares};
use super::signal::SIGMAS_95;

/// The parts of every sample, mm.
type Parts = [Vector; 5];

/// Changes of the parts by one standard deviation along independent directions, by sample, mm.
#[derive(Clone, Debug, Default)]
pub(super) struct Shifts {
    /// The change from the given values to the mean of the fit, common to all.
    off: Vec<Parts>,
    all: Vec<Vec<Parts>>,
}

impl Shifts {
    /// Adds a direction.
    pub(super) fn add(&mut self, shift: Vec<Parts>) {
        self.all.push(shift);
    }

    /// Adds the directions of the link errors: what a link gains, the motion errors lose, as only their sum is known.
    ///
    /// `effects` are those of 1 mm or rad of every link by sample, `off` the differences of the mean of their fit from the given values.
    pub(super) fn add_links(&mut self, effects: &[Vec<Vector>], off: &[f64], covariance: &DMatrix<f64>) {
        let swap = |amounts: &[f64]| -> Vec<Parts> {
            let none = Vector::zeros();
            let each = effects.iter().map(|effects| {
                let link: Vector = effects.iter().zip(amounts).map(|(effect, amount)| effect * *amount).sum();
                [none, link, -link, none, none]
            });
            each.collect()
        };
        self.off = swap(off);
        let own = covariance.clone().symmetric_eigen();
        for (direction, variance) in own.eigenvectors.column_iter().zip(own.eigenvalues.iter()) {
            let amounts: Vec<f64> = direction.iter().map(|share| share * variance.max(0.0).sqrt()).collect();
            self.all.push(swap(&amounts));
        }
    }
}

/// Half widths of the 95 % intervals of the shares of some samples.
#[must_use]
pub(super) fn half_widths(samples: &[Parts], shifts: &Shifts) -> SourceShares {
    let given = shares(samples.iter().copied());
    let far = (shifts.all.len() as f64).sqrt();
    let mut out = SourceShares::default();
    let count = 2.0 * shifts.all.len().max(1) as f64;
    for (shift, sign) in shifts.all.iter().flat_map(|shift| [(shift, far), (shift, -far)]) {
        let moved = samples.iter().enumerate().map(|(place, parts)| {
            let off = shifts.off.get(place);
            let own = shift.get(place);
            let part = |source: usize| {
                let off = off.map_or_else(Vector::zeros, |off| off[source]);
                parts[source] + off + own.map_or_else(Vector::zeros, |own| own[source] * sign)
            };
            [part(0), part(1), part(2), part(3), part(4)]
        });
        let moved = shares(moved);
        for source in 0..5 {
            out.percent[source] += (moved.percent[source] - given.percent[source]).powi(2) / count;
            for k in 0..3 {
                out.max_mm[source][k] += (moved.max_mm[source][k] - given.max_mm[source][k]).powi(2) / count;
                out.rms_mm[source][k] += (moved.rms_mm[source][k] - given.rms_mm[source][k]).powi(2) / count;
            }
        }
    }
    let root = |square: f64| SIGMAS_95 * square.sqrt();
    SourceShares {
        percent: out.percent.map(root),
        max_mm: out.max_mm.map(|along| along.map(root)),
        rms_mm: out.rms_mm.map(|along| along.map(root)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_that_is_known_is_divided_within_the_covariance() {
        // Link 3 µm and motion 3 µm along X in all samples; the link is uncertain by 0.5 µm, and its effect is 1. The RMS of each moves by 0.5 µm, and with
        // it the share: 3.5 of 6 is 58.33 %, so ± 8.333 % for one standard deviation.
        let x = |um: f64| Vector::new(um * 1e-3, 0.0, 0.0);
        let none = Vector::zeros();
        let samples = vec![[none, x(3.0), x(3.0), none, none]; 4];
        let mut shifts = Shifts::default();
        let effects = vec![vec![Vector::x()]; 4];
        shifts.add_links(&effects, &[0.0], &DMatrix::from_element(1, 1, 0.25e-6));
        let found = half_widths(&samples, &shifts);
        for source in [1, 2] {
            assert!((found.rms_mm[source][0] - 1.96 * 0.5e-3).abs() < 1e-12, "{found:?}");
            assert!((found.percent[source] - 1.96 * 100.0 * 0.5 / 6.0).abs() < 1e-9, "{found:?}");
        }
        assert_eq!((found.percent[0], found.rms_mm[1][1]), (0.0, 0.0));
        // A given value that is 1 µm off the mean of the fit adds its square: √(0.5² + 1²).
        let mut shifts = Shifts::default();
        shifts.add_links(&effects, &[1e-3], &DMatrix::from_element(1, 1, 0.25e-6));
        let found = half_widths(&samples, &shifts);
        assert!((found.rms_mm[1][0] - 1.96 * 1.25_f64.sqrt() * 1e-3).abs() < 1e-12, "{found:?}");
    }
}
