//! Readings of a measurement and their predictions by the model, both without the part that set-ups can explain.

use crate::diagnose::scene::{NO_ROW, Scene};
use ncfix_base::geometry::AXES;
use ncfix_base::numeric::Series;

/// Upper limit of a squared residual, so that no single reading decides.
const MOST: f64 = 25.0;

/// One measurement, in units of the uncertainty of each reading.
#[derive(Debug)]
pub(super) struct WeighedReadings {
    /// Row, value and index of the component of each reading.
    pub(super) at: Vec<[usize; 3]>,
    read: Vec<f64>,
    predicted: Vec<f64>,
    /// Their indices among the readings of the scene.
    items: Vec<usize>,
    sigma: Vec<f64>,
    /// All values of its row.
    of_row: Vec<[f64; 3]>,
    /// The run of each reading.
    run: Vec<usize>,
    series: Series,
}

/// Terms that are fitted to the readings as possible errors of the machine; without them, a fault together with a cause would not be recognized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Allowance {
    /// Only the set-ups.
    Nothing,
    /// Also terms that reverse with the direction of an axis.
    Turning,
    /// Also terms proportional to an axis position.
    Straight,
    /// Also terms that bend over an axis position.
    Bent,
}

impl Allowance {
    /// All, from the fewest terms to the most.
    pub(super) const ALL: [Allowance; 4] =
        [Allowance::Nothing, Allowance::Turning, Allowance::Straight, Allowance::Bent];
}

/// Agreement of readings and prediction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Match {
    /// Number of readings used.
    pub(super) count: f64,
    /// Ratio of readings to prediction.
    pub(super) gain: f64,
    /// Share of the squares of the readings that the prediction explains.
    pub(super) share: f64,
    /// RMS of the prediction, in units of the uncertainty.
    pub(super) size: f64,
}

impl WeighedReadings {
    pub(super) fn new(scene: &Scene<'_>, set: usize) -> Option<WeighedReadings> {
        let data = scene.sets.get(set)?;
        let (mut at, mut read, mut predicted, mut weights) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (mut items, mut numbers, mut sigma, mut run) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut of_row = Vec::new();
        for (number, item) in scene.items.iter().enumerate().filter(|(_, item)| item.row != NO_ROW) {
            let Some(row) = scene.rows.get(item.row).filter(|row| row.set == set) else { continue };
            let one = data.observations.get(row.number)?;
            // A probing contains positions of the axes, not deviations.
            let value = one.values.get(item.value).copied().flatten()?;
            at.push([row.number, item.value, one.component.and(one.target).unwrap_or(0)]);
            read.push(value);
            predicted.push(value - item.left);
            weights.push(1.0 / item.sigma);
            sigma.push(item.sigma);
            of_row.push(one.values.map(|value| value.unwrap_or(f64::NAN)));
            run.push(row.sequence);
            numbers.push(number);
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
        (!at.is_empty()).then_some(WeighedReadings { at, read, predicted, items: numbers, sigma, of_row, run, series })
    }

    /// The readings with additional fitted terms; `None` if too few degrees of freedom remain.
    pub(super) fn beside(&self, scene: &Scene<'_>, tips: &[Vec<f64>], what: Allowance) -> Option<WeighedReadings> {
        /// Minimum number of readings for each unknown.
        const READINGS: usize = 3;
        let mut out = WeighedReadings {
            at: self.at.clone(),
            read: self.read.clone(),
            predicted: self.predicted.clone(),
            items: self.items.clone(),
            sigma: self.sigma.clone(),
            of_row: self.of_row.clone(),
            run: self.run.clone(),
            series: self.series.clone(),
        };
        if what == Allowance::Nothing {
            return Some(out);
        }
        let row = |item: usize| scene.items.get(item).and_then(|item| scene.rows.get(item.row));
        for tip in tips {
            let own = |weight: &dyn Fn(&crate::diagnose::row::SceneRow) -> f64| -> Vec<f64> {
                let of = |item: usize| tip.get(item).zip(row(item)).map_or(0.0, |(tip, row)| tip * weight(row));
                self.items.iter().map(|&item| of(item)).collect()
            };
            out.series.take(&own(&|_| 1.0));
            for axis in AXES {
                let at = self.items.iter().filter_map(|&item| row(item)).map(|row| row.position[axis]);
                let [low, high] = at.fold([f64::MAX, f64::MIN], |[low, high], at| [low.min(at), high.max(at)]);
                let (middle, half) = (f64::midpoint(low, high), ((high - low) / 2.0).max(f64::MIN_POSITIVE));
                out.series.take(&own(&|row| row.sense_of(axis)));
                if high > low && what != Allowance::Turning {
                    out.series.take(&own(&|row| (row.position[axis] - middle) / half));
                    if what == Allowance::Bent {
                        out.series.take(&own(&|row| ((row.position[axis] - middle) / half).powi(2)));
                    }
                }
            }
        }
        (self.at.len() >= READINGS * out.series.rank()).then_some(out)
    }

    /// Median of the absolute residuals, mm or rad.
    pub(super) fn middle(&self) -> f64 {
        let all: Vec<f64> = self.read.iter().zip(&self.predicted).map(|(read, predicted)| read - predicted).collect();
        let left = self.without_setups(&all);
        super::median(left.iter().zip(&self.sigma).map(|(left, sigma)| (left * sigma).abs()).collect())
    }

    /// True if all measured lengths are less than the errors of any machine.
    pub(super) fn are_tiny(&self) -> bool {
        /// mm.
        const TINY: f64 = 5e-5;
        let left = self.without_setups(&self.read);
        let sizes = || left.iter().zip(&self.sigma).map(|(left, sigma)| (left * sigma).abs());
        sizes().all(|size| size < TINY) && sizes().any(|size| size > 0.0)
    }

    /// Residuals, in units of the uncertainty.
    pub(super) fn left(&self) -> Vec<f64> {
        let all: Vec<f64> = self.read.iter().zip(&self.predicted).map(|(read, predicted)| read - predicted).collect();
        self.without_setups(&all)
    }

    /// The effect of a term on the readings beyond the set-ups, in units of the uncertainty, from its effect on all readings of the scene.
    pub(super) fn column(&self, of_all: &[f64]) -> Vec<f64> {
        let own: Vec<f64> = self.items.iter().map(|&item| of_all.get(item).copied().unwrap_or(0.0)).collect();
        self.without_setups(&own)
    }

    /// Factor for the degrees of freedom that unknowns use.
    fn freedom(&self) -> f64 {
        self.freedom_beside(0)
    }

    /// This factor with fitted terms in addition.
    pub(super) fn freedom_beside(&self, terms: usize) -> f64 {
        let count = self.at.len() as f64;
        count / (count - (self.series.rank() + terms) as f64).max(1.0)
    }

    fn without_setups(&self, values: &[f64]) -> Vec<f64> {
        let mut series = self.series.clone();
        series.set_values(values);
        series.left().to_vec()
    }

    /// Agreement of the readings of a component, or of all, with the prediction.
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

    /// Squared residuals, in squares of σ, with another assignment of the readings: `of` returns each reading from all values of its row.
    fn squares_if(&self, of: &dyn Fn(usize, [f64; 3]) -> f64, times: f64) -> Vec<f64> {
        let all: Vec<f64> = self
            .at
            .iter()
            .zip(self.of_row.iter().zip(&self.predicted))
            .map(|([_, value, _], (all, predicted))| of(*value, *all) - times * predicted)
            .collect();
        self.without_setups(&all).into_iter().map(|left| (left * left).min(MOST)).collect()
    }

    /// Number of runs in which another assignment of the readings fits better, and their share in the sum of all differences.
    pub(super) fn better_if(&self, of: &dyn Fn(usize, [f64; 3]) -> f64) -> (usize, f64) {
        let as_is = self.squares_if(&|value, all| all[value.min(2)], 1.0);
        let mut runs: std::collections::BTreeMap<usize, f64> = std::collections::BTreeMap::new();
        for ((run, as_is), otherwise) in self.run.iter().zip(as_is).zip(self.squares_if(of, 1.0)) {
            *runs.entry(*run).or_insert(0.0) += as_is - otherwise;
        }
        let better = || runs.values().filter(|less| **less > 0.0);
        let whole: f64 = runs.values().map(|less| less.abs()).sum();
        (better().count(), if whole > 0.0 { better().sum::<f64>() / whole } else { 0.0 })
    }

    /// Mean squared residual of a component, or of all, with another assignment of the readings.
    pub(super) fn left_if(&self, component: Option<usize>, of: &dyn Fn(usize, [f64; 3]) -> f64, times: f64) -> f64 {
        let squares = self.squares_if(of, times);
        let own = squares.iter().zip(&self.at).filter(|(_, at)| component.is_none_or(|of| at[2] == of));
        let squares: Vec<f64> = own.map(|(left, _)| *left).collect();
        self.freedom() * squares.iter().sum::<f64>() / squares.len().max(1) as f64
    }

    /// Mean squared residual with the given readings and a multiple of the prediction.
    pub(super) fn left_with(&self, component: Option<usize>, times: f64) -> f64 {
        self.left_if(component, &|value, all| all[value.min(2)], times)
    }

    /// Indices of the values that rows contain.
    pub(super) fn values(&self) -> Vec<usize> {
        (0..3).filter(|value| self.at.iter().any(|at| at[1] == *value)).collect()
    }
}
