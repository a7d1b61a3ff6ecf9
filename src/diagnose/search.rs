//! The search: which candidates explain what is left, one after the other, until nothing is gained; then those that do not stand are taken out.
//!
//! A step forward takes the candidate whose gain is largest beside its number of unknowns. Whether it stands is judged at the end, with all that were
//! taken: by the memory of what is then left, so that slow noise counts for the little that it tells, and by the number of all that
//! were tried.

use std::collections::HashMap;
use std::sync::Arc;

use crate::numeric::Series;
use crate::numeric::fisher;

use super::cause::{Candidate, Effect, periodic, thermal};
use super::freedom::Order;
use super::price::Price;
use super::scene::{NO_ROW, Scene, Through};
use super::score::{Layout, Scores, in_parts};
use super::seek::Seek;

/// Terms at most.
const MOST: usize = 10;
/// Worth of what has no name beside what has one.
const UNNAMED: f64 = 0.9;
/// The same of what depends on two.
const UNNAMED_PAIR: f64 = 0.87;
/// Candidates explain the same where −2 ln of the likelihood differs by less.
const TIE: f64 = 8.0;
/// Periods that differ by less, as a share, are one.
const NEARLY: f64 = 0.01;
/// The same of waves without a name, which are long.
const NEARLY_UNNAMED: f64 = 0.2;
/// Half of the width of the peak of a period, cycles over the travel, and steps towards its top.
const PEAK: f64 = 0.4;
const REFINED: usize = 14;

/// Candidates and what they would do to the readings of a scene.
#[derive(Debug)]
pub(super) struct Field<'s, 'a> {
    pub(super) scene: &'s Scene<'a>,
    pub(super) candidates: Vec<Candidate>,
    factors: HashMap<Through, Arc<Vec<f64>>>,
    layout: Arc<Layout>,
    seek: Seek,
    /// How many candidates there are to choose from, those of sweeps too.
    pub(super) tried: usize,
}

/// One candidate that was taken.
#[derive(Clone, Debug)]
pub(super) struct Taken {
    /// Its number.
    pub(super) candidate: usize,
    /// Chance of a gain like this where there is nothing, times the number of candidates.
    pub(super) chance: f64,
}

/// How readings count.
#[derive(Clone, Debug)]
pub(super) struct Weights {
    /// 1/σ, 0 for those that do not count.
    pub(super) items: Vec<f64>,
    /// Series of each.
    pub(super) series: Vec<usize>,
}

impl<'s, 'a> Field<'s, 'a> {
    pub(super) fn new(scene: &'s Scene<'a>, candidates: Vec<Candidate>) -> Field<'s, 'a> {
        let seek = Seek::new(scene);
        let of_candidates = candidates.iter().flat_map(|one| one.columns.iter().flatten()).map(|(through, _)| *through);
        let mut factors = HashMap::new();
        for through in of_candidates.chain(seek.places()) {
            factors.entry(through).or_insert_with(|| Arc::new(scene.factors(through)));
        }
        let tried = candidates.len() + seek.count();
        let layout = Arc::new(Layout::new(scene, &candidates));
        Field { scene, candidates, factors, layout, seek, tried }
    }

    /// Adds what is sought by what is left.
    fn seek(&mut self, series: &Series, weights: &Weights) {
        let left = series.unwhitened(series.left());
        let noise = series.squares() / (series.count() as f64).max(1.0);
        let price = noise * ((series.count() as f64).ln() + 2.0 * (self.tried as f64).ln());
        let found = self.seek.propose(self.scene, &self.factors, &left, &weights.items, price);
        self.candidates.extend(found);
    }

    /// Whether a candidate is one that was taken, with a time constant or a period that is nearly the same: a lag between two that are tried is one
    /// effect, not two, and two waves that beat are none.
    fn is_again(&self, number: usize, taken: &[usize]) -> bool {
        let Some(one) = self.candidates.get(number) else { return false };
        let is_near = |other: &Candidate| match (one.constant, other.constant) {
            _ if one.sensor.is_some() => true,
            (Some((own, unit)), Some((known, of))) if one.columns.len() > 1 => {
                let nearly = if one.cause.effect == Effect::Unknown { NEARLY_UNNAMED } else { NEARLY };
                unit == of && (own / known - 1.0).abs() < nearly
            }
            _ => false,
        };
        taken.iter().filter_map(|&other| self.candidates.get(other)).any(|other| {
            let is_one_effect = one.sensor.is_some() && other.cause.effect == one.cause.effect;
            (is_one_effect || other.cause.name == one.cause.name)
                && other.parameter == one.parameter
                && other.sensor == one.sensor
                && is_near(other)
        })
    }

    /// A candidate with its period or its time constant moved to where it explains most: one that is a little off leaves beats and tails. `None` where
    /// there is none to move.
    pub(super) fn refined(&self, number: usize, series: &Series) -> Option<Candidate> {
        let one = self.candidates.get(number)?;
        let (first, _) = one.constant?;
        let (through, _) = one.columns.first()?.first()?;
        if one.cause.effect == Effect::Periodic {
            let Through::Component(name) = *through else { return None };
            let axis = name.axis()?;
            let travel = self.seek.travel(axis)?;
            let cycles = travel / first;
            let with = |cycles: f64| Some(periodic::candidate(name, axis, travel / cycles));
            return self.best_near(series, [cycles - PEAK, cycles, cycles + PEAK], &with);
        }
        let [shortest, longest] = thermal::around(first)?;
        let with = |lag: f64| thermal::with_lag(self.scene, one, lag.exp());
        self.best_near(series, [shortest.ln(), first.ln(), longest.ln()], &with)
    }

    /// The candidate of the number between two others that gains most, if it gains more than that of the middle one.
    fn best_near(
        &self,
        series: &Series,
        [low, middle, high]: [f64; 3],
        with: &dyn Fn(f64) -> Option<Candidate>,
    ) -> Option<Candidate> {
        let gain = |at: f64| with(at).map_or(0.0, |one| series.gain(&self.columns(&one)).squares);
        let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
        let [mut low, mut high] = [low, high];
        let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
        let (mut at_left, mut at_right) = (gain(left), gain(right));
        for _ in 0..REFINED {
            if at_left > at_right {
                (high, right, at_right) = (right, left, at_left);
                left = high - golden * (high - low);
                at_left = gain(left);
            } else {
                (low, left, at_left) = (left, right, at_right);
                right = low + golden * (high - low);
                at_right = gain(right);
            }
        }
        let best = f64::midpoint(low, high);
        with(best).filter(|_| gain(best) > gain(middle))
    }

    /// The columns of a candidate.
    pub(super) fn columns(&self, candidate: &Candidate) -> Vec<Vec<f64>> {
        let sum = |parts: &Vec<(Through, super::cause::Weight)>| {
            let mut column = vec![0.0; self.scene.items.len()];
            for (through, weight) in parts {
                let Some(factors) = self.factors.get(through) else { continue };
                let mut at = (NO_ROW, 0.0);
                for ((value, factor), item) in column.iter_mut().zip(factors.iter()).zip(&self.scene.items) {
                    if *factor != 0.0 {
                        if item.row != at.0 {
                            at = (item.row, self.scene.rows.get(item.row).map_or(0.0, |row| weight.of(row)));
                        }
                        *value += factor * at.1;
                    }
                }
            }
            column
        };
        candidate.columns.iter().map(sum).collect()
    }

    /// A regression with the unknowns of the set-ups and some candidates in it.
    pub(super) fn series(&self, weights: &Weights, taken: &[usize], memory: f64) -> Series {
        let mut series = Series::new(&weights.series, &weights.items, memory);
        for column in self.unknowns() {
            series.take(&column);
        }
        for &number in taken {
            for column in self.candidates.get(number).map(|one| self.columns(one)).unwrap_or_default() {
                series.take(&column);
            }
        }
        let values: Vec<f64> = self.scene.items.iter().map(|item| item.left).collect();
        series.set_values(&values);
        series
    }

    pub(super) fn unknowns(&self) -> Vec<Vec<f64>> {
        let mut columns = vec![vec![0.0; self.scene.items.len()]; self.scene.unknowns];
        for (place, item) in self.scene.items.iter().enumerate() {
            for &(unknown, factor) in &item.by_unknown {
                if let Some(value) = columns.get_mut(unknown).and_then(|column| column.get_mut(place)) {
                    *value += factor;
                }
            }
        }
        columns
    }

    /// What each candidate would gain; candidates that say nothing of their own have rank 0.
    pub(super) fn gains(&self, series: &Series) -> Vec<crate::numeric::Gain> {
        self.gains_of(series, &mut Scores::new(&self.layout, self.scene, &self.factors, series))
    }

    /// The same with the scores of a series to which columns were added since.
    fn gains_of(&self, series: &Series, scores: &mut Scores<'_>) -> Vec<crate::numeric::Gain> {
        let mut gains = scores.gains(series);
        let later = self.candidates.get(self.layout.count()..).unwrap_or_default();
        let layout = Layout::new(self.scene, later);
        gains.extend(Scores::new(&layout, self.scene, &self.factors, series).gains(series));
        gains
    }

    /// Readings less what candidates do whose amounts some of them give.
    pub(super) fn left_with(&self, train: &Weights, taken: &[usize]) -> Vec<f64> {
        let columns: Vec<Vec<f64>> =
            taken.iter().filter_map(|&k| self.candidates.get(k)).flat_map(|one| self.columns(one)).collect();
        let (amounts, _) = self.series(train, &[], 0.0).amounts(&columns);
        let mut values: Vec<f64> = self.scene.items.iter().map(|item| item.left).collect();
        for (column, amount) in columns.iter().zip(&amounts) {
            values.iter_mut().zip(column).for_each(|(value, part)| *value -= part * amount);
        }
        values
    }

    /// Takes candidates one after the other behind those that are `kept`.
    pub(super) fn forward(&mut self, weights: &Weights, kept: &[usize]) -> Vec<usize> {
        let mut taken = kept.to_vec();
        let mut series = self.series(weights, kept, 0.0);
        let count = series.count() as f64;
        let layout = Arc::clone(&self.layout);
        let mut scores = Scores::new(&layout, self.scene, &self.factors, &series);
        while taken.len() < MOST {
            let freedom = count - series.rank() as f64;
            let squares = series.squares();
            if freedom < 2.0 || squares <= 0.0 {
                break;
            }
            let known = self.candidates.len();
            self.seek(&series, weights);
            let gains = self.gains_of(&series, &mut scores);
            let price = Price::new(count, self.tried);
            let open: Vec<(f64, usize)> = gains
                .iter()
                .enumerate()
                .filter(|(number, gain)| gain.rank > 0 && !taken.contains(number) && !self.is_again(*number, &taken))
                .map(|(number, gain)| (price.worth(squares, gain) * self.belief(number), number))
                .collect();
            let most = open.iter().map(|(worth, _)| *worth).fold(f64::NEG_INFINITY, f64::max);
            // The least far-fetched of those that explain as much.
            let best = open.iter().copied().filter(|(worth, _)| *worth > 0.0 && *worth > most - TIE).min_by(|a, b| {
                let far = |number: usize| self.candidates.get(number).map_or(u32::MAX, Candidate::far_fetched);
                far(a.1).cmp(&far(b.1)).then(b.0.total_cmp(&a.0)).then(a.1.cmp(&b.1))
            });
            let Some((_, number)) = best else {
                self.candidates.truncate(known);
                break;
            };
            let number = match best.filter(|(_, number)| self.is_unnamed(*number)) {
                Some((worth, _)) => self.named_instead(&series, &open, price, worth).unwrap_or(number),
                None => number,
            };
            // Of what was sought only one that was taken stays, and of others what is better than they are.
            let sought = (number >= known).then(|| self.candidates.swap_remove(number));
            self.candidates.truncate(known);
            let number = if let Some(one) = sought {
                self.candidates.push(one);
                known
            } else {
                number
            };
            let number = match self.best_sensor(number, &open, &series).or_else(|| self.refined(number, &series)) {
                Some(refined) => {
                    self.candidates.truncate(known);
                    self.candidates.push(refined);
                    known
                }
                None => number,
            };
            let columns = self.columns(&self.candidates[number]);
            columns.iter().for_each(|column| {
                series.take(column);
            });
            taken.push(number);
        }
        self.polish(weights, &mut taken, kept.len());
        taken
    }

    fn is_unnamed(&self, number: usize) -> bool {
        self.candidates.get(number).is_none_or(|one| one.cause.effect == Effect::Unknown)
    }

    /// The first of two causes with names that together explain what one without explains.
    fn named_instead(&self, series: &Series, open: &[(f64, usize)], price: Price, worth: f64) -> Option<usize> {
        let named = open.iter().filter(|(_, number)| !self.is_unnamed(*number));
        let &(own, first) = named.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let mut beside = series.clone();
        self.candidates.get(first).map(|one| self.columns(one))?.iter().for_each(|column| {
            beside.take(column);
        });
        let gains = self.gains(&beside);
        let others = gains.iter().enumerate().filter(|(number, _)| *number != first && !self.is_unnamed(*number));
        let others = others.filter(|(number, gain)| gain.rank > 0 && !self.is_again(*number, &[first]));
        let next = others.map(|(_, gain)| price.worth(beside.squares(), gain)).fold(0.0, f64::max);
        (own + next > worth).then_some(first)
    }

    /// What has no name must explain more than what has one.
    fn belief(&self, number: usize) -> f64 {
        match self.candidates.get(number) {
            Some(one) if one.cause.effect == Effect::Unknown && one.drivers.len() > 1 => UNNAMED_PAIR,
            Some(one) if one.cause.effect == Effect::Unknown => UNNAMED,
            _ => 1.0,
        }
    }

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
