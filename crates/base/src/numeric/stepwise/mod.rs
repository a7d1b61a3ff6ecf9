//! Which of many columns a value needs: stepwise regression that is honest where neighbours have the same noise.
//!
//! Some columns are always in. Candidates enter, leave and take each other's place as long as one criterion falls strictly: ν ln of the squares that
//! are left, and for each column what a t value at its limit would win. Rows are made independent first (generalised least squares). What is chosen
//! is held to Student's t at the freedom that the uncertainty of the correlation leaves (Satterthwaite 1946), by the number of candidates
//! (Bonferroni), and must say something of blocks that were held out, by more than one standard error: each term alone, and all
//! together with the choice repeated in every fold. Without all this a t test at 99.99 % finds an effect in noise of correlation 0.95 nearly always.

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

/// Rounds in which the correlation is found again.
const MOST_ROUNDS: usize = 8;

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
    let prepared = PreparedRows::new(rows)?;
    if prepared.count() <= prepared.always + 1 {
        return None;
    }
    let search = StepwiseSearch::new(&prepared, rows, rule);
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
