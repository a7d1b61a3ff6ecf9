//! Which of many columns a value needs: stepwise regression that is honest where neighbours have the same noise.
//!
//! Some columns are always in. Candidates enter, leave and take each other's place as long as one criterion falls strictly: ν ln of the squares that
//! are left, and for each column what a t value at its limit would win. Rows are made independent first (generalised least squares, see
//! [`lagged`]); the limit is that of Student's t at the freedom that the uncertainty of the correlation leaves (Satterthwaite 1946), by the number of
//! candidates (Bonferroni). What is chosen must say something of blocks that were held out, by more than one standard error: each term alone, and all
//! together with the choice repeated in every fold. Without all this a t test at 99.99 % finds an effect in noise of correlation 0.95 nearly always.

mod descent;
mod held_out;
mod lagged;
mod prepared;
mod sweep;

#[cfg(test)]
mod tests;

use std::collections::HashMap;

use nalgebra::DMatrix;

use super::student;
use descent::{Criterion, descend};
use held_out::{Blocks, Folds};
use lagged::{Lagged, step_at, with};
use prepared::Prepared;
use sweep::Swept;

/// Rounds in which the correlation is found again.
const MOST_ROUNDS: usize = 8;
/// Correlations that differ by less are the same.
const SAME: f64 = 1e-3;
/// Columns whose correlation is larger cannot be told apart.
const ALIKE: f64 = 0.95;
/// Nor can those whose exchange raises ν ln of the squares by less: two standard deviations.
const NOT_APART: f64 = 4.0;

/// Rows to choose from. All lists but `handicaps` have an entry for each row.
#[derive(Clone, Debug)]
pub struct Rows {
    /// How many of the first columns are always in.
    pub always: usize,
    /// Factors by column, the candidates behind what is always in; divided by the uncertainty of their row.
    pub factors: DMatrix<f64>,
    /// Values, divided likewise.
    pub values: Vec<f64>,
    /// Rows of one series follow each other in time, in the order in which they are here.
    pub series: Vec<usize>,
    /// Series of one group have the same correlation; a group has series of its own.
    pub noise: Vec<usize>,
    /// What has runs of its own that may be held out for each other; `None` for a row that is never held out.
    pub cluster: Vec<Option<usize>>,
    /// The run.
    pub run: Vec<usize>,
    /// What a candidate has to win beside its limit, in −2 ln of the likelihood: the simpler one of two that say the same comes first.
    pub handicaps: Vec<f64>,
}

/// When a column is in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Chance to accept anything where there is nothing.
    pub significance: f64,
    /// Whether rows may have the noise of the row before; without it this is the classical procedure.
    pub correlated: bool,
    /// Whether terms have to say something of blocks that were held out.
    pub held_out: bool,
}

impl Default for Rule {
    fn default() -> Rule {
        Rule { significance: 0.01, correlated: true, held_out: true }
    }
}

/// What happened to a candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// It came in.
    Entered,
    /// It took the place of the candidate of this number.
    Replaced(usize),
    /// It went out because the criterion falls without it.
    Left,
    /// It went out because it is not significant beside the others.
    NotSignificant,
    /// It went out because it does not help with blocks that were held out.
    NoGain,
}

/// A step.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The number of the candidate.
    pub candidate: usize,
    /// What happened.
    pub change: Change,
    /// Its t value where it is in (behind the step, or before it where it went out).
    pub t: f64,
    /// The freedom of it.
    pub freedom: f64,
    /// Chance of such a t, times the number of candidates.
    pub p: f64,
    /// The largest correlation of neighbours that was assumed.
    pub correlation: f64,
}

/// What is left of held-out rows before and after.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gain {
    /// Root of the mean square before, in units of the rows.
    pub before: f64,
    /// And after.
    pub after: f64,
    /// The share of the squares by which it falls.
    pub share: f64,
    /// Its standard error, from the differences of the blocks.
    pub uncertainty: f64,
}

impl Gain {
    /// Whether it is beyond one standard error.
    #[must_use]
    pub fn is_real(&self) -> bool {
        self.share > self.uncertainty
    }
}

/// A candidate that could stand for one that was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rival {
    /// Its number.
    pub candidate: usize,
    /// The correlation of both, less what the others say.
    pub correlation: f64,
    /// By how much −2 ln of the likelihood would rise.
    pub worse: f64,
}

/// A candidate that was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Its number.
    pub candidate: usize,
    /// Its coefficient.
    pub value: f64,
    /// Its t value, the freedom of it, and its chance times the number of candidates.
    pub t: f64,
    /// The freedom of it.
    pub freedom: f64,
    /// Chance times the number of candidates.
    pub p: f64,
    /// What it helps with held-out blocks, beside the other terms.
    pub gain: Gain,
    /// Those that could stand for it, the best one first.
    pub rivals: Vec<Rival>,
}

/// What was chosen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choice {
    /// The terms, in the order of the candidates.
    pub terms: Vec<Term>,
    /// Steps in their order.
    pub steps: Vec<Step>,
    /// Candidates that the rows tell nothing of beside the columns that are always in.
    pub not_told: Vec<usize>,
    /// Candidates that were tried.
    pub tried: usize,
    /// The correlation of neighbours in each group of noise, by its label.
    pub correlation: Vec<(usize, f64)>,
    /// All terms against none, with the choice repeated in every fold; `None` where nothing was held out.
    pub gain: Option<Gain>,
}

/// Chooses. `None` where numbers are not finite, or there are not more rows than columns that are always in.
#[must_use]
pub fn choose(rows: &Rows, rule: Rule) -> Option<Choice> {
    let prepared = Prepared::new(rows)?;
    if prepared.count() <= prepared.always + 1 {
        return None;
    }
    let search = Search::new(&prepared, rows, rule);
    let mut choice = Choice { not_told: prepared.not_told.clone(), tried: prepared.told.len(), ..Choice::default() };
    let mut chosen: Vec<usize> = Vec::new();
    let mut noise = search.noise(&chosen);
    let criterion = search.criterion();
    for _ in 0..MOST_ROUNDS {
        let mut swept = search.swept(&noise, &chosen);
        let mut log = Vec::new();
        descend(&mut swept, &criterion, &mut chosen, |column, change| log.push((column, change)));
        search.record(&log, &noise, &chosen, &mut choice.steps);
        let next = search.noise(&chosen);
        let is_same = next.same(&noise);
        noise = next;
        if is_same && log.is_empty() {
            break;
        }
    }
    search.demand_significance(&mut noise, &mut chosen, &mut choice.steps);
    let labels: Vec<usize> = prepared.groups.iter().map(|group| prepared.noise[group.from]).collect();
    choice.correlation = labels.iter().copied().zip(noise.correlation.iter().copied()).collect();
    let blocks = Blocks::new(rows, &choice.correlation.iter().copied().collect::<HashMap<usize, f64>>());
    let folds = (rule.held_out && !chosen.is_empty()).then(|| Folds::new(&prepared, blocks, &noise.correlation));
    if let Some(folds) = &folds {
        search.demand_gain(folds, &noise, &mut chosen, &mut choice);
        // Without a term the others may lose theirs.
        search.demand_significance(&mut noise, &mut chosen, &mut choice.steps);
    }
    choice.terms = search.terms(&noise, &chosen, folds.as_ref());
    Some(choice)
}

/// A t value.
#[derive(Clone, Copy, Debug, Default)]
struct Tested {
    t: f64,
    freedom: f64,
    p: f64,
}

/// Correlations, and how well they are known.
#[derive(Clone, Debug)]
struct Noise {
    correlation: Vec<f64>,
    variance: Vec<f64>,
}

impl Noise {
    fn same(&self, other: &Noise) -> bool {
        self.correlation.iter().zip(&other.correlation).all(|(one, other)| (one - other).abs() < SAME)
    }

    fn most(&self) -> f64 {
        self.correlation.iter().copied().fold(0.0, f64::max)
    }
}

struct Search<'a> {
    prepared: &'a Prepared,
    lagged: Lagged,
    rule: Rule,
    /// Of the candidates that are told.
    handicaps: Vec<f64>,
}

impl<'a> Search<'a> {
    fn new(prepared: &'a Prepared, rows: &Rows, rule: Rule) -> Search<'a> {
        let lagged = Lagged::new(&prepared.rows, &prepared.groups);
        let handicaps = prepared.told.iter().map(|&candidate| rows.handicaps[candidate]).collect();
        Search { prepared, lagged, rule, handicaps }
    }

    /// What is always in, then these columns.
    fn inside(&self, chosen: &[usize]) -> impl Iterator<Item = usize> {
        (0..self.prepared.always).chain(chosen.iter().copied())
    }

    /// The columns of candidates.
    fn candidates(&self) -> std::ops::Range<usize> {
        self.prepared.always..self.prepared.width() - 1
    }

    fn noise(&self, chosen: &[usize]) -> Noise {
        let count = self.lagged.len();
        if !self.rule.correlated {
            return Noise { correlation: vec![0.0; count], variance: vec![0.0; count] };
        }
        let columns: Vec<usize> = self.inside(chosen).chain([self.prepared.width() - 1]).collect();
        let (correlation, variance) = self.lagged.only(&columns).correlations();
        Noise { correlation, variance }
    }

    fn swept_at(&self, correlation: &[f64], chosen: &[usize]) -> Swept {
        let mut swept = Swept::new(self.lagged.gram(correlation));
        self.inside(chosen).for_each(|column| {
            swept.pivot(column);
        });
        swept
    }

    fn swept(&self, noise: &Noise, chosen: &[usize]) -> Swept {
        self.swept_at(&noise.correlation, chosen)
    }

    /// The freedom of the t value of each column: that of the noise, less what the uncertainty of the correlation takes.
    fn freedoms_by(
        &self,
        noise: &Noise,
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
            // The noise that fits best changes with the correlation.
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

    /// The limit of the descent is that of a known correlation. Before the effects are in, they look like correlation, and the freedom that it leaves
    /// would be too small for any of them; what is chosen is held to its own freedom afterwards.
    fn criterion(&self) -> Criterion {
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

    /// What is tested of each of these columns where they are in.
    fn tested(&self, noise: &Noise, chosen: &[usize]) -> Vec<Tested> {
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
        let tested = (first..count).zip(freedoms).map(|(column, freedom_of_t)| {
            let t = swept.coefficient(column) / (swept.left() / freedom * swept.variance(column)).sqrt();
            // What is told by the others is out.
            let t = if swept.is_inside(column) && !t.is_nan() { t } else { 0.0 };
            Tested { t, freedom: freedom_of_t, p: (student::two_sided(t, freedom_of_t) * self.tried()).min(1.0) }
        });
        tested.collect()
    }

    /// Writes down what happened, step by step.
    fn record(&self, log: &[(usize, Change)], noise: &Noise, chosen: &[usize], steps: &mut Vec<Step>) {
        // The state before the first step: what the steps did, undone.
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

    fn step(&self, column: usize, change: Change, noise: &Noise, with: &[usize]) -> Step {
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

    /// Takes out what is not significant beside the others, the worst one first.
    fn demand_significance(&self, noise: &mut Noise, chosen: &mut Vec<usize>, steps: &mut Vec<Step>) {
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

    /// Takes out what does not help with held-out blocks: each term beside the others, then all of them.
    fn demand_gain(&self, folds: &Folds<'_>, noise: &Noise, chosen: &mut Vec<usize>, choice: &mut Choice) {
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

    fn terms(&self, noise: &Noise, chosen: &[usize], folds: Option<&Folds<'_>>) -> Vec<Term> {
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

    /// The candidates that could stand for a column.
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
