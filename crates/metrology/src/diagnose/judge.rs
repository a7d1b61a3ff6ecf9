//! Backward elimination of candidates: p-values that include the autocorrelation of the residual.

use std::collections::HashMap;

use super::cause::EffectKind;
use super::freedom::Order;
use super::search::{Field, Taken, Weights};
use ncfix_base::geometry::AXIS_COUNT;
use ncfix_base::numeric::{LeaveOut, Series, fisher, in_parts};
use ncfix_model::ErrorName;

/// Positions are equal if they agree to one part in this number, mm or rad.
const FINE: f64 = 1e3;
/// Unknowns of a wave: mean, period, sine and cosine.
const UNKNOWNS: f64 = 4.0;
/// Readings of a pose are correlated if their correlation exceeds this many of its standard deviations.
const SURELY: f64 = 2.0;

impl Field<'_, '_> {
    /// Largest factor by which autocorrelation increases the variance of the amounts of a candidate, relative to independent readings.
    pub(super) fn inflation(&self, weights: &Weights, taken: &[usize], others: &[usize], number: usize) -> f64 {
        let order = Order::new(weights);
        let memory = self.memory(weights, taken);
        let of_noise = order.correlations(self.series(weights, taken, memory).left());
        let columns = self.columns_of(number);
        let series = self.series(weights, others, memory);
        inflation(&order, &of_noise, &series, &columns)
    }

    /// Groups the readings by pose: repeated readings of a pose form one group.
    fn poses(&self, weights: &Weights) -> Poses {
        let mut numbers: HashMap<Pose, usize> = HashMap::new();
        let mut members: Vec<Vec<usize>> = Vec::new();
        for (place, (item, weight)) in self.scene.items.iter().zip(&weights.items).enumerate() {
            let Some(row) = self.scene.rows.get(item.row).filter(|_| *weight > 0.0) else { continue };
            let fine = |value: f64| (value * FINE).round() as i64;
            let at = row.position.0.map(fine);
            let pose = (at, row.tool_mm.map(fine), item.value, row.component);
            let number = *numbers.entry(pose).or_insert(members.len());
            if number == members.len() {
                members.push(Vec::new());
            }
            if let Some(own) = members.get_mut(number) {
                own.push(place);
            }
        }
        Poses(members)
    }

    /// Factor by which the variance of the amounts of a candidate grows because the residual repeats at each pose: repetitions average noise, but no error
    /// that the terms lack.
    pub(super) fn growth_by_poses(&self, weights: &Weights, taken: &[usize], others: &[usize], number: usize) -> f64 {
        let left = self.series(weights, taken, 0.0);
        let mut beside = self.series(weights, others, 0.0);
        let of_column = |column: Vec<f64>| {
            beside.set_values(&column);
            beside.left().to_vec()
        };
        let columns: Vec<Vec<f64>> = self.columns_of(number).into_iter().map(of_column).collect();
        self.poses(weights).inflation(left.left(), &columns).times
    }

    /// Ratio of the residual to the scatter of repeated readings, if the poses surely have errors that the terms lack; otherwise `None`.
    pub(super) fn lack_of_fit(&self, weights: &Weights, taken: &[usize]) -> Option<f64> {
        /// p-value of a lack of fit that is no chance.
        const CHANCE: f64 = 1e-6;
        /// Smallest ratio that matters beside the noise.
        const RATIO: f64 = 2.0;
        let series = self.series(weights, taken, 0.0);
        let poses = self.poses(weights);
        let count = poses.0.iter().map(Vec::len).sum::<usize>();
        let within = count.checked_sub(poses.0.len()).filter(|freedom| *freedom > 0)? as f64;
        let between = poses.0.len().checked_sub(series.rank()).filter(|freedom| *freedom > 0)? as f64;
        let all: f64 =
            poses.0.iter().flatten().filter_map(|&place| series.left().get(place)).map(|left| left * left).sum();
        let of_means = poses.squares(series.left());
        let scatter = ((all - of_means) / within).max(0.0);
        let ratio = (all / (within + between) / scatter).sqrt();
        let is_sure = fisher::exceeded(of_means / between / scatter, between, within) < CHANCE;
        (is_sure && ratio > RATIO && ratio.is_finite()).then_some(ratio)
    }

    /// p-value of a wave if each pose counts as one reading: the probability that one of `waves` waves fits the systematic deviation of each place as well. 0
    /// if no pose was measured twice.
    pub(super) fn chance_of_places(&self, weights: &Weights, taken: &[usize], number: usize, waves: usize) -> f64 {
        let others: Vec<usize> = taken.iter().copied().filter(|&other| other != number).collect();
        let memory = self.memory(weights, taken);
        let columns = self.columns_of(number);
        let poses = self.poses(weights).that_see(&columns);
        let gain = self.series(weights, &others, memory).gain(&columns).squares;
        let rest = poses.squares(self.series(weights, taken, memory).left());
        let freedom = poses.0.len() as f64 - UNKNOWNS;
        let is_again = poses.0.iter().any(|own| own.len() > 1);
        if !is_again || rest <= 0.0 {
            return 0.0;
        }
        (waves as f64 * (rest / (rest + gain)).powf(0.5 * freedom.max(0.0))).min(1.0)
    }

    /// Autocorrelation of the residual after the given candidates.
    pub(super) fn memory(&self, weights: &Weights, taken: &[usize]) -> f64 {
        let plain = self.series(weights, taken, 0.0);
        memory_of(weights, &plain, plain.left())
    }

    /// Removes the candidates that are not significant given the others, the weakest first. `note` receives each of them.
    pub(super) fn backward(
        &self,
        weights: &Weights,
        mut taken: Vec<usize>,
        limit: f64,
        note: &mut dyn FnMut(&Taken),
    ) -> Vec<Taken> {
        let order = Order::new(weights);
        let is_wave =
            |number: &usize| self.candidates.get(*number).is_some_and(|one| one.cause.effect == EffectKind::Periodic);
        let poses = taken.iter().any(is_wave).then(|| self.poses(weights));
        let mut columns: Vec<Vec<Vec<f64>>> = taken.iter().map(|&number| self.columns_of(number)).collect();
        let plain = LeaveOut::new(self.series(weights, &[], 0.0), &columns);
        // Numbers of the initial candidates that remain.
        let mut open: Vec<usize> = (0..taken.len()).collect();
        loop {
            let memory = memory_of(weights, plain.whole(), &plain.left(&open));
            let all = LeaveOut::new(self.series(weights, &[], memory), &columns);
            let whole = all.whole();
            let of_noise = order.correlations(whole.left());
            let places: Vec<usize> = (0..taken.len()).collect();
            let judged = in_parts(&places, &|&place: &usize| {
                let number = taken[place];
                let others: Vec<usize> = places.iter().copied().filter(|&other| other != place).collect();
                let beside = all.beside(place, &others);
                let gain = beside.gain;
                let of_column = |column: Vec<f64>| order.inflation(&of_noise, &column);
                let mut inflation = all.own(&beside).map(of_column).fold(1.0, f64::max);
                let mut count = f64::INFINITY;
                if let Some(poses) = poses.as_ref().filter(|_| is_wave(&number)) {
                    let own = poses.that_see(&columns[place]).inflation(whole.left(), &columns[place]);
                    inflation = inflation.max(own.times);
                    count = own.count;
                }
                // Autocorrelated readings reduce the effective sample size.
                let readings = whole.count() as f64;
                let freedom = (readings / inflation - (beside.rank + gain.rank) as f64).min(count).max(1.0);
                let rest = (beside.squares - gain.squares).max(0.0) / readings;
                let ratio = (gain.squares / gain.rank.max(1) as f64) / (rest * inflation);
                let chance = fisher::exceeded(ratio, gain.rank as f64, freedom) * self.tried as f64;
                Taken { candidate: number, chance: chance.min(1.0) }
            });
            let weakest = judged.iter().max_by(|a, b| a.chance.total_cmp(&b.chance));
            match weakest {
                Some(weakest) if weakest.chance > limit => {
                    note(weakest);
                    let out = weakest.candidate;
                    let place = taken.iter().position(|&number| number == out).unwrap_or(0);
                    taken.remove(place);
                    columns.remove(place);
                    open.remove(place);
                }
                _ => return judged,
            }
        }
    }
}

/// Autocorrelation of the residual, in units of its uncertainty.
fn memory_of(weights: &Weights, plain: &Series, left: &[f64]) -> f64 {
    let of = |(left, weight): (&f64, &f64)| if *weight > 0.0 { left / weight } else { 0.0 };
    plain.memory_of(&left.iter().zip(&weights.items).map(of).collect::<Vec<f64>>())
}

/// Axes in thousandths of a mm or a rad, tool, number of the value, component.
type Pose = ([i64; AXIS_COUNT], [i64; 3], usize, Option<ErrorName>);

/// Readings grouped by pose.
struct Poses(Vec<Vec<usize>>);

impl Poses {
    /// Returns the poses in which columns act. Lines along other axes say nothing about a wave, however many places they have.
    fn that_see(&self, columns: &[Vec<f64>]) -> Poses {
        let acts = |place: &usize| columns.iter().any(|column| column.get(*place).is_some_and(|value| *value != 0.0));
        Poses(self.0.iter().filter(|own| own.iter().any(acts)).cloned().collect())
    }

    /// Returns the squares of the means of poses, weighted by the number of readings.
    fn squares(&self, left: &[f64]) -> f64 {
        let of = |own: &Vec<usize>| {
            let sum: f64 = own.iter().filter_map(|&place| left.get(place)).sum();
            sum * sum / own.len().max(1) as f64
        };
        self.0.iter().map(of).sum()
    }

    /// Returns the factor by which variances grow if the residual of a pose repeats: the readings of one pose then count as one reading. Among a hundred
    /// waves, one fits the deviations of a few poses by chance.
    fn inflation(&self, left: &[f64], columns: &[Vec<f64>]) -> Inflation {
        // Σ of products of different readings of a pose, and Σ of squares.
        let sums = |values: &[f64]| {
            self.0.iter().fold((0.0, 0.0), |sums, places| {
                let own = || places.iter().filter_map(|&place| values.get(place));
                let (sum, squares) = (own().sum::<f64>(), own().map(|value| value * value).sum::<f64>());
                (sums.0 + sum * sum - squares, sums.1 + squares)
            })
        };
        let pairs: f64 = self.0.iter().map(|own| own.len() as f64 * (own.len() as f64 - 1.0)).sum();
        let count: f64 = self.0.iter().map(|own| own.len() as f64).sum();
        let (products, squares) = sums(left);
        if pairs <= 0.0 || squares <= 0.0 {
            return Inflation { times: 1.0, count: f64::INFINITY };
        }
        let alike = (products / pairs / (squares / count)).clamp(0.0, 1.0);
        let own = (self.0.len() as f64 - UNKNOWNS).max(0.0);
        let of_column = |column: &Vec<f64>| {
            let (products, squares) = sums(column);
            if squares > 0.0 { 1.0 + alike * products / squares } else { 1.0 }
        };
        let times = columns.iter().map(of_column).fold(1.0, f64::max);
        let is_alike = alike > SURELY * (2.0 / pairs).sqrt();
        Inflation { times, count: if is_alike { own } else { f64::INFINITY } }
    }
}

/// Effect of repeated poses on the information in the readings.
struct Inflation {
    /// Factor by which variances grow.
    times: f64,
    /// Number of poses minus the unknowns of a wave, if the readings of a pose are significantly correlated; otherwise infinite.
    count: f64,
}

/// Largest factor by which autocorrelation increases the variance of the amounts of columns after a basis, relative to independent readings.
fn inflation(order: &Order, of_noise: &[f64], series: &Series, columns: &[Vec<f64>]) -> f64 {
    let mut beside = series.clone();
    let of_column = |column: &Vec<f64>| {
        beside.set_values(column);
        order.inflation(of_noise, beside.left())
    };
    columns.iter().map(of_column).fold(1.0, f64::max)
}
