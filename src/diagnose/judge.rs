//! Whether candidates stand beside each other: chance, by the memory of what is left.

use super::freedom::Order;
use super::score::in_parts;
use super::search::{Field, Taken, Weights};
use crate::numeric::{Series, fisher};

impl Field<'_, '_> {
    /// By how much the variances of the amounts of columns are larger than of independent readings, at most.
    pub(super) fn inflation(&self, weights: &Weights, taken: &[usize], others: &[usize], number: usize) -> f64 {
        let order = Order::new(weights);
        let memory = self.memory(weights, taken);
        let of_noise = order.correlations(self.series(weights, taken, memory).left());
        let columns = self.candidates.get(number).map(|one| self.columns(one)).unwrap_or_default();
        inflation(&order, &of_noise, &self.series(weights, others, memory), &columns)
    }

    /// The memory of what is left with some candidates.
    pub(super) fn memory(&self, weights: &Weights, taken: &[usize]) -> f64 {
        let plain = self.series(weights, taken, 0.0);
        let left: Vec<f64> = plain
            .left()
            .iter()
            .zip(&weights.items)
            .map(|(left, weight)| if *weight > 0.0 { left / weight } else { 0.0 })
            .collect();
        plain.memory_of(&left)
    }

    /// Takes out what does not stand beside the others, the weakest first; `note` gets it.
    pub(super) fn backward(
        &self,
        weights: &Weights,
        mut taken: Vec<usize>,
        limit: f64,
        note: &mut dyn FnMut(&Taken),
    ) -> Vec<Taken> {
        let order = Order::new(weights);
        loop {
            let memory = self.memory(weights, &taken);
            let of_noise = order.correlations(self.series(weights, &taken, memory).left());
            let judged = in_parts(&taken, &|&number: &usize| {
                let others: Vec<usize> = taken.iter().copied().filter(|&other| other != number).collect();
                let series = self.series(weights, &others, memory);
                let columns = self.columns(&self.candidates[number]);
                let gain = series.gain(&columns);
                let inflation = inflation(&order, &of_noise, &series, &columns);
                // Readings that wander together are as good as fewer that do not.
                let freedom = (series.count() as f64 / inflation - (series.rank() + gain.rank) as f64).max(1.0);
                let rest = (series.squares() - gain.squares).max(0.0) / series.count() as f64;
                let ratio = (gain.squares / gain.rank.max(1) as f64) / (rest * inflation);
                let chance = fisher::exceeded(ratio, gain.rank as f64, freedom) * self.tried as f64;
                Taken { candidate: number, chance: chance.min(1.0) }
            });
            let weakest = judged.iter().max_by(|a, b| a.chance.total_cmp(&b.chance));
            match weakest {
                Some(weakest) if weakest.chance > limit => {
                    note(weakest);
                    let out = weakest.candidate;
                    taken.retain(|&number| number != out);
                }
                _ => return judged,
            }
        }
    }
}

/// By how much the variances of the amounts of columns beside a basis are larger than of independent readings, at most.
fn inflation(order: &Order, of_noise: &[f64], series: &Series, columns: &[Vec<f64>]) -> f64 {
    let mut beside = series.clone();
    let of_column = |column: &Vec<f64>| {
        beside.set_values(column);
        order.inflation(of_noise, beside.left())
    };
    columns.iter().map(of_column).fold(1.0, f64::max)
}
