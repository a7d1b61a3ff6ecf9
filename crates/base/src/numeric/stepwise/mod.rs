//! Selection of the columns that a value needs: stepwise regression that stays valid for autocorrelated noise.
//!
//! Some columns are always in. Candidates enter, leave and replace each other as long as one criterion decreases strictly. It is ν ln of the residual sum of
//! squares plus, for each column, the gain of a t value at its limit. Rows are first made independent (generalised least squares). Selected terms are tested
//! by Student's t with the degrees of freedom that the uncertainty of the autocorrelation leaves (Satterthwaite 1946), corrected for the number of candidates
//! (Bonferroni). They must also improve the prediction of held-out blocks by more than one standard error: each term alone, and all together with the
//! selection repeated in every fold. Without these tests a t test at 99.99 % nearly always finds an effect in noise of autocorrelation 0.95.

mod descent;
mod held_out;
mod lagged;
mod prepared;
mod search;
mod sweep;

#[cfg(test)]
mod tests;

use std::collections::HashMap;

use nalgebra::DMatrix;

use descent::descend;
use held_out::{Blocks, Folds};
use prepared::PreparedRows;
use search::StepwiseSearch;

/// Maximum number of iterations in which the autocorrelation is estimated again.
const MOST_ROUNDS: usize = 8;

/// Repeats are the yardstick of the noise of a group if this share of its rows is repeated.
pub const REPEATED: f64 = 0.8;

/// Rows for the selection. All lists except `handicaps` have one entry per row.
#[derive(Clone, Debug)]
pub struct Rows {
    /// Number of leading columns that are always in.
    pub always: usize,
    /// Factors by column: first the columns that are always in, then the candidates; divided by the uncertainty of their row.
    pub factors: DMatrix<f64>,
    /// Values, also divided by the uncertainty of their row.
    pub values: Vec<f64>,
    /// Series number. Rows of one series follow each other in time, in their order here.
    pub series: Vec<usize>,
    /// Noise group. Series of one group have the same autocorrelation; a series belongs to one group only.
    pub noise: Vec<usize>,
    /// Cluster, whose runs may be held out for each other; `None` for a row that is never held out.
    pub cluster: Vec<Option<usize>>,
    /// Run.
    pub run: Vec<usize>,
    /// Place and condition: rows of one number are repeated readings, which differ by noise alone; `None` for a row that nothing repeats.
    pub place: Vec<Option<usize>>,
    /// Side from which a place was reached. If rows of one place are repeats from several sides, a constant of each side is not part of their noise.
    pub side: Vec<usize>,
    /// Additional gain that a candidate needs beyond its limit, in −2 ln of the likelihood: the simpler of two equivalent candidates comes first.
    pub handicaps: Vec<f64>,
}

/// Acceptance rule for columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Significance level: probability of accepting any term if there is no effect.
    pub significance: f64,
    /// True if rows may have autocorrelated noise; false for the classical procedure.
    pub correlated: bool,
    /// True if terms must improve the prediction of held-out blocks.
    pub held_out: bool,
}

impl Default for Rule {
    fn default() -> Rule {
        Rule { significance: 0.01, correlated: true, held_out: true }
    }
}

/// Change of a candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// It entered.
    Entered,
    /// It replaced the candidate with this number.
    Replaced(usize),
    /// It was removed because the criterion decreases without it.
    Left,
    /// It was removed because it is not significant given the others.
    NotSignificant,
    /// It was removed because it does not improve the prediction of held-out blocks.
    NoGain,
}

/// Step of the selection.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Number of the candidate.
    pub candidate: usize,
    /// Change.
    pub change: Change,
    /// Its t value while it is in (after the step; before it if the candidate was removed).
    pub t: f64,
    /// Degrees of freedom of the t value.
    pub freedom: f64,
    /// p-value of the t value, multiplied by the number of candidates.
    pub p: f64,
    /// Largest autocorrelation that was assumed.
    pub correlation: f64,
}

/// Residuals of held-out rows before and after.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gain {
    /// Root mean square before, in units of the rows.
    pub before: f64,
    /// Root mean square after, in units of the rows.
    pub after: f64,
    /// Share by which the squares decrease.
    pub share: f64,
    /// Standard error of the share, from the differences of the blocks.
    pub uncertainty: f64,
}

impl Gain {
    /// True if the decrease exceeds one standard error.
    #[must_use]
    pub fn is_real(&self) -> bool {
        self.share > self.uncertainty
    }
}

/// Candidate that could replace a selected one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rival {
    /// Number of the candidate.
    pub candidate: usize,
    /// Partial correlation of both, given the other columns.
    pub correlation: f64,
    /// Increase of −2 ln of the likelihood by the replacement.
    pub worse: f64,
}

/// Selected candidate.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Number of the candidate.
    pub candidate: usize,
    /// Coefficient.
    pub value: f64,
    /// t value.
    pub t: f64,
    /// Degrees of freedom of the t value.
    pub freedom: f64,
    /// p-value, multiplied by the number of candidates.
    pub p: f64,
    /// Improvement of held-out blocks, given the other terms.
    pub gain: Gain,
    /// Candidates that could replace it, the best one first.
    pub rivals: Vec<Rival>,
}

/// Result of the selection.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choice {
    /// Selected terms, in the order of the candidates.
    pub terms: Vec<Term>,
    /// Steps in their order.
    pub steps: Vec<Step>,
    /// Candidates that are not identifiable given the columns that are always in.
    pub not_identified: Vec<usize>,
    /// Number of candidates that were tested.
    pub tried: usize,
    /// Autocorrelation in each noise group, by its label.
    pub correlation: Vec<(usize, f64)>,
    /// All terms against none, with the selection repeated in every fold; `None` if nothing was held out.
    pub gain: Option<Gain>,
}

/// Maximum number of selections with the spread of each noise group renewed.
const MOST_SPREADS: usize = 4;
/// Relative change below which a spread is the same.
const SAME_SPREAD: f64 = 0.1;

/// Selects the terms. `None` if numbers are not finite, or there are no more rows than columns that are always in.
///
/// Each noise group has its own spread: what the terms leave in the readings of one instrument is no noise of another one.
#[must_use]
pub fn choose(rows: &Rows, rule: Rule) -> Option<Choice> {
    let (mut choice, mut spreads) = choose_at(rows, rule)?;
    if spreads.len() < 2 {
        return Some(choice);
    }
    let mut scaled = rows.clone();
    for _ in 1..MOST_SPREADS {
        if spreads.values().all(|spread| (spread - 1.0).abs() <= SAME_SPREAD) {
            break;
        }
        for (row, noise) in rows.noise.iter().enumerate() {
            let Some(spread) = spreads.get(noise) else { continue };
            scaled.factors.row_mut(row).scale_mut(1.0 / spread);
            scaled.values[row] /= spread;
        }
        (choice, spreads) = choose_at(&scaled, rule)?;
    }
    Some(choice)
}

/// Selects the terms with the uncertainties as they are, and the spread of each noise group that the terms leave, by its label.
fn choose_at(rows: &Rows, rule: Rule) -> Option<(Choice, HashMap<usize, f64>)> {
    let prepared = PreparedRows::new(rows)?;
    if prepared.count() <= prepared.always + 1 {
        return None;
    }
    let search = StepwiseSearch::new(&prepared, rows, rule);
    let mut choice =
        Choice { not_identified: prepared.not_identified.clone(), tried: prepared.told.len(), ..Choice::default() };
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
        // Without a removed term, others may lose their significance.
        search.demand_significance(&mut noise, &mut chosen, &mut choice.steps);
    }
    choice.terms = search.terms(&noise, &chosen, folds.as_ref());
    let spreads = labels.into_iter().zip(search.spreads(&chosen));
    // A group that is never held out, such as known distances, has the uncertainty that was stated.
    let is_read =
        |label: usize| rows.noise.iter().zip(&rows.cluster).any(|(own, cluster)| *own == label && cluster.is_some());
    let spreads = spreads.filter_map(|(label, spread)| Some((label, spread.filter(|_| is_read(label))?)));
    Some((choice, spreads.collect()))
}
