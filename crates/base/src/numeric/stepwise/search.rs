//! Parts of a selection: noise, t values with their degrees of freedom, removal of terms, replacements.

use std::collections::BTreeMap;

use super::descent::{Criterion, descend};
use super::held_out::Folds;
use super::lagged::{Lagged, NoiseGroup, step_at, with};
use super::prepared::PreparedRows;
use super::sweep::Swept;
use super::{Change, Choice, Rival, Rows, Rule, Step, Term};
use crate::numeric::student;

/// Two autocorrelations are equal if they differ by less than this.
const SAME: f64 = 1e-3;
/// Correlation above which columns are not distinguishable.
const ALIKE: f64 = 0.95;
/// Increase of ν ln of the squares below which an exchange is not distinguishable: two standard deviations.
const NOT_APART: f64 = 4.0;

/// Degrees of freedom from which a noise group shows its own spread.
const LEAST_FREEDOM: f64 = 8.0;
/// Variance, in units of the stated one, below which a group counts as free of noise.
const NO_NOISE: f64 = 1e-12;

/// A misfit is certain from this many standard deviations on.
const SURELY: f64 = 2.0;

/// Systematic residual of a noise group at its places.
#[derive(Clone, Copy, Debug)]
struct Misfit {
    /// Variance of a place beside that of independent rows; 1 without a misfit.
    factor: f64,
    /// Degrees of freedom of the places, if there is a misfit.
    freedom: Option<f64>,
}

impl Default for Misfit {
    fn default() -> Misfit {
        Misfit { factor: 1.0, freedom: None }
    }
}

/// Tested t value.
#[derive(Clone, Copy, Debug, Default)]
struct Tested {
    t: f64,
    freedom: f64,
    p: f64,
}

/// Autocorrelations with their variances.
#[derive(Clone, Debug)]
pub(super) struct CorrelatedNoise {
    pub(super) correlation: Vec<f64>,
    variance: Vec<f64>,
}

impl CorrelatedNoise {
    pub(super) fn same(&self, other: &CorrelatedNoise) -> bool {
        self.correlation.iter().zip(&other.correlation).all(|(one, other)| (one - other).abs() < SAME)
    }

    fn most(&self) -> f64 {
        self.correlation.iter().copied().fold(0.0, f64::max)
    }
}

/// Search in prepared rows.
pub(super) struct StepwiseSearch<'a> {
    prepared: &'a PreparedRows,
    lagged: Lagged,
    /// Autocorrelation and its variance of each noise group from repeats, which no missing term can feign; `None` without repeats.
    of_repeats: Vec<Option<(f64, f64)>>,
    rule: Rule,
    /// Handicaps of the identifiable candidates.
    handicaps: Vec<f64>,
}

impl<'a> StepwiseSearch<'a> {
    pub(super) fn new(prepared: &'a PreparedRows, rows: &Rows, rule: Rule) -> StepwiseSearch<'a> {
        let lagged = Lagged::new(&prepared.rows, &prepared.groups);
        let handicaps = prepared.told.iter().map(|&candidate| rows.handicaps[candidate]).collect();
        let found = Lagged::new(&prepared.repeats, &prepared.groups).correlations_apart();
        let of_repeats = prepared.repeated.iter().zip(found).map(|(count, (rho, variance))| {
            // The mean of n repeats takes 1/n of the information.
            count.map(|count| (rho, variance * count / (count - 1.0)))
        });
        StepwiseSearch { prepared, lagged, of_repeats: of_repeats.collect(), rule, handicaps }
    }

    /// Returns the columns that are always in, then these columns.
    fn inside(&self, chosen: &[usize]) -> impl Iterator<Item = usize> {
        (0..self.prepared.always).chain(chosen.iter().copied())
    }

    /// Returns the columns of the candidates.
    fn candidates(&self) -> std::ops::Range<usize> {
        self.prepared.always..self.prepared.width() - 1
    }

    pub(super) fn noise(&self, chosen: &[usize]) -> CorrelatedNoise {
        let count = self.lagged.len();
        if !self.rule.correlated {
            return CorrelatedNoise { correlation: vec![0.0; count], variance: vec![0.0; count] };
        }
        let columns: Vec<usize> = self.inside(chosen).chain([self.prepared.width() - 1]).collect();
        let (mut correlation, mut variance) = self.lagged.only(&columns).correlations();
        for ((rho, variance), known) in correlation.iter_mut().zip(&mut variance).zip(&self.of_repeats) {
            if let Some(known) = known {
                (*rho, *variance) = *known;
            }
        }
        CorrelatedNoise { correlation, variance }
    }

    fn swept_at(&self, correlation: &[f64], chosen: &[usize]) -> Swept {
        let mut swept = Swept::new(self.lagged.gram(correlation));
        self.inside(chosen).for_each(|column| {
            swept.pivot(column);
        });
        swept
    }

    pub(super) fn swept(&self, noise: &CorrelatedNoise, chosen: &[usize]) -> Swept {
        self.swept_at(&noise.correlation, chosen)
    }

    /// Returns the standard deviation of the rows of each noise group, given these columns, in the order of the groups: its squares per degree of freedom
    /// (Förstner 1979), without autocorrelation: a wrong one would change it. `None` for a group with too few degrees of freedom, or without noise.
    pub(super) fn spreads(&self, chosen: &[usize]) -> Vec<Option<f64>> {
        let columns: Vec<usize> = self.inside(chosen).chain([self.prepared.width() - 1]).collect();
        let own = self.lagged.only(&columns);
        let count = columns.len() - 1;
        let none = vec![0.0; self.lagged.len()];
        let mut swept = Swept::new(own.gram(&none));
        (0..count).for_each(|column| {
            swept.pivot(column);
        });
        let factor = |place: usize| match place {
            value if value == count => 1.0,
            column if swept.is_inside(column) => -swept.coefficient(column),
            _ => 0.0,
        };
        let spread = |number: usize| {
            let (gram, rows) = own.gram_of(number, 0.0)?;
            let (mut squares, mut used) = (0.0, 0.0);
            for row in 0..=count {
                for column in 0..=count {
                    squares += factor(row) * factor(column) * gram[(row, column)];
                    used += swept.cofactor(row, column) * gram[(row, column)];
                }
            }
            let freedom = rows as f64 - used;
            let variance = squares / freedom;
            (freedom >= LEAST_FREEDOM && variance > NO_NOISE).then(|| variance.sqrt())
        };
        (0..none.len()).map(spread).collect()
    }

    /// Returns the degrees of freedom of the t value of each column: those of the noise, reduced by the uncertainty of the autocorrelation.
    fn freedoms_by(
        &self,
        noise: &CorrelatedNoise,
        columns: std::ops::Range<usize>,
        own: f64,
        at: impl Fn(&[f64]) -> Swept,
    ) -> Vec<f64> {
        let mut inverse = vec![1.0 / own; columns.len()];
        for (number, (&rho, &variance)) in noise.correlation.iter().zip(&noise.variance).enumerate() {
            if !self.rule.correlated || !self.lagged.follows(number) {
                continue;
            }
            let step = step_at(rho);
            let ends = [(rho - step).max(0.0), rho + step];
            let [below, above] = ends.map(|rho| at(&with(&noise.correlation, number, rho)));
            // The best-fitting noise changes with the autocorrelation.
            let noise = (above.left() / below.left()).ln();
            for (sum, column) in inverse.iter_mut().zip(columns.clone()) {
                let factor = (above.variance(column) / below.variance(column)).ln();
                let slope = (factor + noise) / (ends[1] - ends[0]);
                *sum += if slope.is_finite() { slope * slope * variance / 2.0 } else { 1.0 };
            }
        }
        inverse.into_iter().map(|inverse| (1.0 / inverse).clamp(1.0, own.max(1.0))).collect()
    }

    fn freedom(&self, terms: usize) -> f64 {
        self.prepared.count().saturating_sub(self.prepared.always + terms).max(1) as f64
    }

    fn tried(&self) -> f64 {
        self.prepared.told.len().max(1) as f64
    }

    /// Returns the criterion. Its limit is that of a known autocorrelation. Before the effects are in, they look like autocorrelation, which would leave too
    /// few degrees of freedom for any of them. Selected terms are tested with their own degrees of freedom afterwards.
    pub(super) fn criterion(&self) -> Criterion {
        let freedom = self.freedom(0);
        let limit = student::limit(self.rule.significance / self.tried(), freedom);
        let price = freedom * (limit * limit / freedom).ln_1p();
        Criterion {
            first: self.prepared.always,
            freedom,
            prices: self.handicaps.iter().map(|handicap| price + handicap).collect(),
            most: (self.prepared.count() - self.prepared.always) / 3,
        }
    }

    /// Tests each of these columns with all of them in.
    fn tested(&self, noise: &CorrelatedNoise, chosen: &[usize]) -> Vec<Tested> {
        let columns: Vec<usize> = self.inside(chosen).chain([self.prepared.width() - 1]).collect();
        let own = self.lagged.only(&columns);
        let (first, count) = (self.prepared.always, columns.len() - 1);
        let at = |correlation: &[f64]| {
            let mut swept = Swept::new(own.gram(correlation));
            (0..count).for_each(|column| {
                swept.pivot(column);
            });
            swept
        };
        let swept = at(&noise.correlation);
        let freedom = self.freedom(chosen.len());
        let freedoms = self.freedoms_by(noise, first..count, freedom, at);
        let misfits = self.misfits(&columns, &swept);
        let tested = (first..count).zip(freedoms).map(|(column, freedom_of_t)| {
            let misfit = self.misfit_of(columns[column], &misfits);
            let freedom_of_t = misfit.freedom.map_or(freedom_of_t, |places| freedom_of_t.min(places));
            let t =
                swept.coefficient(column) / (misfit.factor * swept.left() / freedom * swept.variance(column)).sqrt();
            // A column that depends on the others is not in.
            let t = if swept.is_inside(column) && !t.is_nan() { t } else { 0.0 };
            Tested { t, freedom: freedom_of_t, p: (student::two_sided(t, freedom_of_t) * self.tried()).min(1.0) }
        });
        tested.collect()
    }

    /// Returns the misfit of each noise group: of repeats that agree with each other and not with the terms, each place counts once, however often it was read.
    fn misfits(&self, columns: &[usize], swept: &Swept) -> Vec<Misfit> {
        let Some((&value, inside)) = columns.split_last() else { return Vec::new() };
        let coefficient = |place: usize| if swept.is_inside(place) { swept.coefficient(place) } else { 0.0 };
        let coefficients: Vec<f64> = (0..inside.len()).map(coefficient).collect();
        let of_group = |(group, repeated): (&NoiseGroup, &Option<f64>)| {
            if repeated.is_none() {
                return Misfit::default();
            }
            let mut places: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
            let (mut squares, mut rows) = (0.0, 0.0);
            for row in group.from..group.until {
                let Some(place) = self.prepared.place.get(row).copied().flatten() else { continue };
                let own = self.prepared.rows.column(row);
                let said: f64 = inside.iter().zip(&coefficients).map(|(&column, factor)| own[column] * factor).sum();
                let left = own[value] - said;
                let sum = places.entry(place).or_insert((0.0, 0.0));
                *sum = (sum.0 + left, sum.1 + 1.0);
                squares += left * left;
                rows += 1.0;
            }
            let between: f64 = places.values().map(|(sum, count)| sum * sum / count).sum();
            let used = (inside.len() as f64).min(0.5 * places.len() as f64);
            let freedom = places.len() as f64 - used;
            let ratio = between / freedom * (rows - used) / squares;
            let is_misfit = freedom >= 1.0 && ratio > 1.0 + SURELY * (2.0 / freedom).sqrt();
            if is_misfit { Misfit { factor: ratio, freedom: Some(freedom) } } else { Misfit::default() }
        };
        self.prepared.groups.iter().zip(&self.prepared.repeated).map(of_group).collect()
    }

    /// Returns the misfit for a column: that of the noise group in which its squares are largest.
    fn misfit_of(&self, column: usize, misfits: &[Misfit]) -> Misfit {
        if misfits.iter().all(|misfit| misfit.freedom.is_none()) {
            return Misfit::default();
        }
        let squares = |group: &NoiseGroup| -> f64 {
            (group.from..group.until).map(|row| self.prepared.rows[(column, row)].powi(2)).sum()
        };
        let sizes = self.prepared.groups.iter().map(squares).zip(misfits);
        sizes.max_by(|one, other| one.0.total_cmp(&other.0)).map_or_else(Misfit::default, |(_, misfit)| *misfit)
    }

    /// Records the changes, step by step.
    pub(super) fn record(
        &self,
        log: &[(usize, Change)],
        noise: &CorrelatedNoise,
        chosen: &[usize],
        steps: &mut Vec<Step>,
    ) {
        // State before the first step: the steps undone.
        let mut now: Vec<usize> = chosen.to_vec();
        for &(column, change) in log.iter().rev() {
            match change {
                Change::Entered => now.retain(|&own| own != column),
                Change::Replaced(other) => {
                    now.retain(|&own| own != column);
                    now.push(other);
                }
                _ => now.push(column),
            }
        }
        for &(column, change) in log {
            let before = now.clone();
            match change {
                Change::Entered => now.push(column),
                Change::Replaced(other) => {
                    now.retain(|&own| own != other);
                    now.push(column);
                }
                _ => now.retain(|&own| own != column),
            }
            let is_in = now.contains(&column);
            steps.push(self.step(column, change, noise, if is_in { &now } else { &before }));
        }
    }

    fn step(&self, column: usize, change: Change, noise: &CorrelatedNoise, with: &[usize]) -> Step {
        let tested = self.tested(noise, with);
        let found = with.iter().zip(&tested).find(|(own, _)| **own == column).map(|(_, tested)| *tested);
        let Tested { t, freedom, p } = found.unwrap_or_default();
        let change = match change {
            Change::Replaced(other) => Change::Replaced(self.candidate(other)),
            other => other,
        };
        Step { candidate: self.candidate(column), change, t, freedom, p, correlation: noise.most() }
    }

    fn candidate(&self, column: usize) -> usize {
        column.checked_sub(self.prepared.always).and_then(|told| self.prepared.told.get(told)).copied().unwrap_or(0)
    }

    /// Removes terms that are not significant given the others, the worst one first.
    pub(super) fn demand_significance(
        &self,
        noise: &mut CorrelatedNoise,
        chosen: &mut Vec<usize>,
        steps: &mut Vec<Step>,
    ) {
        while !chosen.is_empty() {
            *noise = self.noise(chosen);
            let tested = self.tested(noise, chosen);
            let worst = tested.iter().zip(chosen.iter()).max_by(|one, other| one.0.p.total_cmp(&other.0.p));
            let Some((p, column)) = worst.map(|(tested, &column)| (tested.p, column)) else { return };
            if p <= self.rule.significance {
                return;
            }
            steps.push(self.step(column, Change::NotSignificant, noise, chosen));
            chosen.retain(|&own| own != column);
        }
        *noise = self.noise(chosen);
    }

    /// Removes terms that do not improve the prediction of held-out blocks: each term given the others, then all of them.
    pub(super) fn demand_gain(
        &self,
        folds: &Folds<'_>,
        noise: &CorrelatedNoise,
        chosen: &mut Vec<usize>,
        choice: &mut Choice,
    ) {
        let prices = self.criterion();
        let of_folds: Vec<Vec<(usize, f64)>> = folds
            .training()
            .enumerate()
            .map(|(fold, (training, rows))| {
                let mut swept = Swept::new(training.clone());
                (0..self.prepared.always).for_each(|column| {
                    swept.pivot(column);
                });
                let freedom = rows.saturating_sub(self.prepared.always).max(1);
                let criterion = Criterion { freedom: freedom as f64, most: freedom / 3, ..prices.clone() };
                let mut own = Vec::new();
                descend(&mut swept, &criterion, &mut own, |_, _| {});
                folds.coefficients(fold, &own)
            })
            .collect();
        let gain = folds.gain(&folds.losses_of(&[]), &folds.losses(&of_folds));
        choice.gain = Some(gain);
        let is_real = gain.is_real();
        while !chosen.is_empty() {
            let with_all = folds.losses_of(chosen);
            let gains = chosen.iter().map(|&column| {
                let others: Vec<usize> = chosen.iter().copied().filter(|&own| own != column).collect();
                (folds.gain(&folds.losses_of(&others), &with_all), column)
            });
            let worst = gains.min_by(|one, other| {
                (one.0.share - one.0.uncertainty).total_cmp(&(other.0.share - other.0.uncertainty))
            });
            let Some((gain, column)) = worst else { return };
            if is_real && gain.is_real() {
                return;
            }
            choice.steps.push(self.step(column, Change::NoGain, noise, chosen));
            chosen.retain(|&own| own != column);
        }
    }

    pub(super) fn terms(&self, noise: &CorrelatedNoise, chosen: &[usize], folds: Option<&Folds<'_>>) -> Vec<Term> {
        let mut swept = self.swept(noise, chosen);
        let with_all = folds.map(|folds| folds.losses_of(chosen)).unwrap_or_default();
        let mut sorted = chosen.to_vec();
        sorted.sort_unstable();
        let mut terms = Vec::new();
        for (&column, Tested { t, freedom, p }) in sorted.iter().zip(self.tested(noise, &sorted)) {
            let length = self.prepared.lengths.get(column - self.prepared.always).copied().unwrap_or(1.0);
            let others: Vec<usize> = chosen.iter().copied().filter(|&own| own != column).collect();
            let gain = folds.map(|folds| folds.gain(&folds.losses_of(&others), &with_all)).unwrap_or_default();
            let rivals = self.rivals(&mut swept, column);
            let value = swept.coefficient(column) / length;
            terms.push(Term { candidate: self.candidate(column), value, t, freedom, p, gain, rivals });
        }
        terms
    }

    /// Returns the candidates that could replace a column.
    fn rivals(&self, swept: &mut Swept, column: usize) -> Vec<Rival> {
        let (freedom, left) = (self.freedom(0), swept.left().max(f64::MIN_POSITIVE));
        let outside = self.candidates().filter(|&other| !swept.is_inside(other));
        let worse: Vec<(usize, f64)> = outside
            .filter_map(|other| Some((other, freedom * ((left - swept.exchange(column, other)?) / left).ln())))
            .collect();
        swept.pivot(column);
        let mut rivals: Vec<Rival> = worse
            .into_iter()
            .map(|(other, worse)| (other, worse, swept.correlation(column, other)))
            .filter(|&(_, worse, correlation)| correlation.abs() > ALIKE || worse < NOT_APART)
            .map(|(other, worse, correlation)| Rival { candidate: self.candidate(other), correlation, worse })
            .collect();
        swept.pivot(column);
        rivals.sort_by(|one, other| one.worse.total_cmp(&other.worse));
        rivals
    }
}
