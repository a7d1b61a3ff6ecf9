//! How much less correlated readings tell than independent ones.
//!
//! The variance of an amount is that for independent noise times 1 + 2 Σ ρₑ(h) ρₓ(h), with the correlations of the noise and of its column
//! at the distance h in the series (Bayley & Hammersley 1946), tapered as by Newey & West 1987. A memory of one step, which whitens, takes
//! most of it away; noise that wanders slowly beside noise that does not leaves the rest.

use super::search::Weights;
use crate::numeric::sums::dot;

/// Distances at most.
const MOST: usize = 250;
/// A series says something of distances up to this share of its length.
const SHARE: usize = 3;

/// The readings that count, series by series.
#[derive(Clone, Debug)]
pub(super) struct Order(Vec<Vec<usize>>);

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
        Order(series)
    }

    /// Correlations at the distances 1, 2 …
    pub(super) fn correlations(&self, values: &[f64]) -> Vec<f64> {
        let longest = self.0.iter().map(Vec::len).max().unwrap_or(0);
        let most = (longest / SHARE).min(MOST);
        let at = |place: &usize| values.get(*place).copied().unwrap_or(0.0);
        let square: f64 = self.0.iter().flatten().map(|place| at(place).powi(2)).sum();
        if square <= 0.0 {
            return Vec::new();
        }
        let row = |places: &Vec<usize>| places.iter().map(at).collect::<Vec<f64>>();
        // What belongs to one set-up is nothing in most series.
        let rows: Vec<Vec<f64>> = self.0.iter().map(row).filter(|row| row.iter().any(|value| *value != 0.0)).collect();
        let product = |h: usize| -> f64 { rows.iter().map(|row| dot(row, row.get(h..).unwrap_or_default())).sum() };
        (1..=most).map(|h| product(h) / square).collect()
    }

    /// How many readings are how far behind another of their series.
    pub(super) fn pairs(&self, distance: usize) -> usize {
        self.0.iter().map(|places| places.len().saturating_sub(distance)).sum()
    }

    /// By how much the variance of an amount grows, 1 at least.
    pub(super) fn inflation(&self, of_noise: &[f64], column: &[f64]) -> f64 {
        let of_column = self.correlations(column);
        let count = of_noise.len().min(of_column.len()) as f64 + 1.0;
        let sum: f64 =
            of_noise.iter().zip(&of_column).enumerate().map(|(k, (a, b))| (1.0 - (k + 1) as f64 / count) * a * b).sum();
        (1.0 + 2.0 * sum).max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_noise_tells_less_of_slow_columns_only() {
        let count = 4000;
        let weights = Weights { items: vec![1.0; count], series: vec![0; count] };
        let order = Order::new(&weights);
        // A correlation of 0.9 to the power of the distance: (1 + ρ)/(1 − ρ) = 19 for a column that hardly changes.
        let of_noise: Vec<f64> = (1..=250).map(|h| 0.9_f64.powi(h)).collect();
        let slow: Vec<f64> = (0..count).map(|k| (k as f64 / 600.0).sin()).collect();
        let fast: Vec<f64> = (0..count).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let found = order.inflation(&of_noise, &slow);
        assert!((16.0..19.0).contains(&found), "{found}");
        assert_eq!(order.inflation(&of_noise, &fast).to_bits(), 1.0_f64.to_bits());
        assert_eq!(order.pairs(10), count - 10);
    }
}
