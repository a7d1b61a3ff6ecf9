//! The readings of a measurement beside what the model says of them, both without what the set-ups may take up.

use crate::diagnose::scene::{NO_ROW, Scene};
use crate::numeric::Series;

/// Squares of what is left count up to this: a single reading decides nothing.
const MOST: f64 = 25.0;

/// One measurement, in units of the uncertainty of each reading.
#[derive(Debug)]
pub(super) struct Readings {
    /// Row, value and number of the component of each.
    pub(super) at: Vec<[usize; 3]>,
    read: Vec<f64>,
    predicted: Vec<f64>,
    series: Series,
}

/// How readings go with the prediction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Match {
    /// Readings that count.
    pub(super) count: f64,
    /// Readings per prediction.
    pub(super) gain: f64,
    /// Share of the squares of the readings that the prediction explains.
    pub(super) share: f64,
    /// Root of the mean square of the prediction.
    pub(super) size: f64,
}

impl Readings {
    pub(super) fn new(scene: &Scene<'_>, set: usize) -> Option<Readings> {
        let data = scene.sets.get(set)?;
        let (mut at, mut read, mut predicted, mut weights) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut items = Vec::new();
        for item in scene.items.iter().filter(|item| item.row != NO_ROW) {
            let Some(row) = scene.rows.get(item.row).filter(|row| row.set == set) else { continue };
            let one = data.observations.get(row.number)?;
            // A probing says where axes stood, not how far from anything.
            let value = one.values.get(item.value).copied().flatten()?;
            at.push([row.number, item.value, one.component.and(one.target).unwrap_or(0)]);
            read.push(value);
            predicted.push(value - item.left);
            weights.push(1.0 / item.sigma);
            items.push(item);
        }
        let mut unknowns: Vec<usize> =
            items.iter().flat_map(|item| &item.by_unknown).map(|(number, _)| *number).collect();
        unknowns.sort_unstable();
        unknowns.dedup();
        let mut columns = vec![vec![0.0; items.len()]; unknowns.len()];
        for (place, item) in items.iter().enumerate() {
            for (unknown, factor) in &item.by_unknown {
                if let Ok(number) = unknowns.binary_search(unknown) {
                    columns[number][place] += factor;
                }
            }
        }
        let mut series = Series::new(&vec![0; items.len()], &weights, 0.0);
        columns.iter().for_each(|column| {
            series.take(column);
        });
        (!at.is_empty()).then_some(Readings { at, read, predicted, series })
    }

    fn without_setups(&self, values: &[f64]) -> Vec<f64> {
        let mut series = self.series.clone();
        series.set_values(values);
        series.left().to_vec()
    }

    /// How the readings of a component, or all, go with the prediction.
    pub(super) fn matched(&self, of: Option<usize>) -> Match {
        let (read, predicted) = (self.without_setups(&self.read), self.without_setups(&self.predicted));
        let is_in = |place: &usize| of.is_none_or(|of| self.at[*place][2] == of);
        let places: Vec<usize> = (0..self.at.len()).filter(is_in).collect();
        let sum = |a: &[f64], b: &[f64]| places.iter().map(|&place| a[place] * b[place]).sum::<f64>();
        let (rr, rp, pp) = (sum(&read, &read), sum(&read, &predicted), sum(&predicted, &predicted));
        let count = places.len() as f64;
        let gain = if pp > 0.0 { rp / pp } else { 0.0 };
        let share = if pp > 0.0 && rr > 0.0 { rp * rp / (rr * pp) } else { 0.0 };
        Match { count, gain, share, size: (pp / count.max(1.0)).sqrt() }
    }

    /// Mean square of what is left of a component, or all, where the readings are taken otherwise: `of` gives each from all values of its row.
    pub(super) fn left_if(&self, component: Option<usize>, of: &dyn Fn(usize, [f64; 3]) -> f64, times: f64) -> f64 {
        let mut rows = std::collections::HashMap::new();
        for ([row, value, _], read) in self.at.iter().zip(&self.read) {
            rows.entry(*row).or_insert([f64::NAN; 3])[(*value).min(2)] = *read;
        }
        let all: Vec<f64> = self
            .at
            .iter()
            .zip(&self.predicted)
            .map(|([row, value, _], predicted)| {
                of(*value, rows.get(row).copied().unwrap_or([0.0; 3])) - times * predicted
            })
            .collect();
        let left = self.without_setups(&all);
        let own = left.iter().zip(&self.at).filter(|(_, at)| component.is_none_or(|of| at[2] == of));
        let squares: Vec<f64> = own.map(|(left, _)| (left * left).min(MOST)).collect();
        squares.iter().sum::<f64>() / squares.len().max(1) as f64
    }

    /// The same with the readings as they are, and a part of the prediction.
    pub(super) fn left_with(&self, component: Option<usize>, times: f64) -> f64 {
        self.left_if(component, &|value, all| all[value.min(2)], times)
    }

    /// Which values rows have.
    pub(super) fn values(&self) -> Vec<usize> {
        (0..3).filter(|value| self.at.iter().any(|at| at[1] == *value)).collect()
    }
}
