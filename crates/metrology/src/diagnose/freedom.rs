//! Effective number of correlated readings.
//!
//! The variance of an amount is that for independent noise times 1 + 2 Σ ρₑ(h) ρₓ(h), with the autocorrelations of the noise and of the column at lag h
//! (Bayley & Hammersley 1946), tapered as by Newey & West 1987. Whitening with a lag of one removes most of the autocorrelation. The sum of white noise and
//! slowly varying noise keeps a part of it.

use rustfft::num_complex::Complex;

use super::sample::MANY;
use super::search::Weights;
use super::sweep::FourierTransform;
use ncfix_base::numeric::sums::dot;

/// Maximum lag.
const MOST: usize = 250;
/// Maximum lag as a share of the length of a series.
const SHARE: usize = 3;

/// The included readings, series by series.
#[derive(Clone, Debug)]
pub(super) struct Order {
    series: Vec<Vec<usize>>,
    /// For many readings: a transform of the length of a series, padded with zeros by the maximum lag.
    transform: Option<FourierTransform>,
}

impl Order {
    pub(super) fn new(weights: &Weights) -> Order {
        let most = weights.series.iter().max().map_or(0, |most| most + 1);
        let mut series = vec![Vec::new(); most];
        for (place, (&number, &weight)) in weights.series.iter().zip(&weights.items).enumerate() {
            if weight > 0.0
                && let Some(own) = series.get_mut(number)
            {
                own.push(place);
            }
        }
        let longest = series.iter().map(Vec::len).max().unwrap_or(0);
        let is_many = series.iter().map(Vec::len).sum::<usize>() > MANY;
        let transform = is_many.then(|| FourierTransform::new((longest + furthest(longest) + 1).next_power_of_two()));
        Order { series, transform }
    }

    /// Returns the autocorrelations at the lags 1, 2 …
    pub(super) fn correlations(&self, values: &[f64]) -> Vec<f64> {
        let most = furthest(self.series.iter().map(Vec::len).max().unwrap_or(0));
        let at = |place: &usize| values.get(*place).copied().unwrap_or(0.0);
        let square: f64 = self.series.iter().flatten().map(|place| at(place).powi(2)).sum();
        if square <= 0.0 {
            return Vec::new();
        }
        let row = |places: &Vec<usize>| places.iter().map(at).collect::<Vec<f64>>();
        // A column of one set-up is zero in most series.
        let rows: Vec<Vec<f64>> =
            self.series.iter().map(row).filter(|row| row.iter().any(|value| *value != 0.0)).collect();
        if let Some(transform) = &self.transform {
            return products(transform, &rows, most).into_iter().map(|product| product / square).collect();
        }
        let product = |h: usize| -> f64 { rows.iter().map(|row| dot(row, row.get(h..).unwrap_or_default())).sum() };
        (1..=most).map(|h| product(h) / square).collect()
    }

    /// Returns the number of pairs of readings of a series at each lag.
    pub(super) fn pairs(&self, distance: usize) -> usize {
        self.series.iter().map(|places| places.len().saturating_sub(distance)).sum()
    }

    /// Returns the factor by which the variance of an amount grows, at least 1.
    pub(super) fn inflation(&self, of_noise: &[f64], column: &[f64]) -> f64 {
        let of_column = self.correlations(column);
        let count = of_noise.len().min(of_column.len()) as f64 + 1.0;
        let sum: f64 =
            of_noise.iter().zip(&of_column).enumerate().map(|(k, (a, b))| (1.0 - (k + 1) as f64 / count) * a * b).sum();
        (1.0 + 2.0 * sum).max(1.0)
    }
}

/// Returns the largest lag.
fn furthest(longest: usize) -> usize {
    (longest / SHARE).min(MOST)
}

/// Sums of products at the lags 1, 2 … in all rows, from their spectrum (Wiener & Khinchin). Two rows form one complex row: the real part of its products is
/// the sum of those of both.
fn products(transform: &FourierTransform, rows: &[Vec<f64>], most: usize) -> Vec<f64> {
    let mut powers = vec![Complex::new(0.0, 0.0); transform.length()];
    for pair in rows.chunks(2) {
        let [one, other] = [0, 1].map(|k| pair.get(k).map_or(&[][..], Vec::as_slice));
        let at = |row: &[f64], place: usize| row.get(place).copied().unwrap_or(0.0);
        let both = (0..one.len().max(other.len())).map(|place| Complex::new(at(one, place), at(other, place)));
        powers.iter_mut().zip(transform.of(both.collect())).for_each(|(sum, own)| sum.re += own.norm_sqr());
    }
    let count = powers.len() as f64;
    transform.of(powers).iter().skip(1).take(most).map(|sum| sum.re / count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_noise_tells_less_of_slow_columns_only() {
        let count = 4000;
        let weights = Weights { items: vec![1.0; count], series: vec![0; count] };
        let order = Order::new(&weights);
        // Autocorrelation of 0.9 to the power of the lag: (1 + ρ)/(1 − ρ) = 19 for a column that hardly changes.
        let of_noise: Vec<f64> = (1..=250).map(|h| 0.9_f64.powi(h)).collect();
        let slow: Vec<f64> = (0..count).map(|k| (k as f64 / 600.0).sin()).collect();
        let fast: Vec<f64> = (0..count).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let found = order.inflation(&of_noise, &slow);
        assert!((16.0..19.0).contains(&found), "{found}");
        assert_eq!(order.inflation(&of_noise, &fast).to_bits(), 1.0_f64.to_bits());
        assert_eq!(order.pairs(10), count - 10);
    }

    #[test]
    fn many_readings_have_the_same_products() {
        // Three rows: 1 2 3 4, 1 0 −1, 5. The sum at lag 1 is 2 + 6 + 12 + 0 + 0, at lag 2 it is 3 + 8 − 1.
        let rows = [vec![1.0, 2.0, 3.0, 4.0], vec![1.0, 0.0, -1.0], vec![5.0]];
        let found = products(&FourierTransform::new(8), &rows, 2);
        assert!((found[0] - 20.0).abs() < 1e-12 && (found[1] - 10.0).abs() < 1e-12, "{found:?}");
    }
}
