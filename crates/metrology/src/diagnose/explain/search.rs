//! Explanations: sets of terms with their probabilities.
//!
//! The score of a set is its marginal likelihood times the odds of its terms. From each start (the empty set, all simple terms, and further sets such
//! as the result of a search) the search adds, drops and exchanges terms until no step improves the score. Every visited set within [`WITHIN`] of the
//! best is an explanation: alternatives are part of the answer.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use ncfix_base::numeric::in_parts;

use super::likelihood::{Likelihood, Posterior};

/// Sets whose logarithm of the score is within this of the best are kept: the others have a probability below 5·10⁻⁵.
pub const WITHIN: f64 = 10.0;
/// Number of additions and exchanges that are evaluated exactly in a step: those with the largest gain at the scale of the current set.
const CLOSEST: usize = 12;
/// Maximum number of terms, so that the search ends.
const MOST: usize = 60;

/// A set of terms.
#[derive(Clone, Debug)]
pub struct Explanation {
    /// Indices of its terms among those of the likelihood, ascending.
    pub set: Vec<usize>,
    /// Its probability among all explanations.
    pub probability: f64,
    /// Amounts.
    pub posterior: Posterior,
}

/// Odds of sets of terms.
#[derive(Clone, Debug, Default)]
pub struct Odds {
    /// Logarithm of the odds of each term.
    pub log: Vec<f64>,
    /// The term that usually accompanies it: for an order, the one below.
    pub parents: Vec<Option<usize>>,
}

/// Factor by which a term without its usual companion is rarer (principle of heredity: Chipman 1996, Bayesian variable selection with related
/// predictors, Canadian Journal of Statistics 24).
const ORPHAN: f64 = 10.0;

impl Odds {
    /// Logarithm of the odds of a set.
    #[must_use]
    pub fn of(&self, set: &[usize]) -> f64 {
        let one = |&term: &usize| {
            let parent = self.parents.get(term).copied().flatten();
            let orphan = parent.is_some_and(|parent| !set.contains(&parent));
            self.log.get(term).copied().unwrap_or(0.0) - if orphan { ORPHAN.ln() } else { 0.0 }
        };
        set.iter().map(one).sum()
    }
}

/// Cached scores.
struct Scores<'a> {
    likelihood: &'a Likelihood<'a>,
    odds: &'a Odds,
    known: HashMap<Vec<usize>, (f64, f64)>,
}

impl Scores<'_> {
    /// Scale of the noise and score.
    fn of(&mut self, set: &[usize]) -> (f64, f64) {
        if let Some(known) = self.known.get(set) {
            return *known;
        }
        let (scale, evidence) = self.likelihood.evidence(set);
        let score = (scale, evidence + self.odds.of(set));
        self.known.insert(set.to_vec(), score);
        score
    }

    /// Computes the scores of sets, on all cores.
    fn learn(&mut self, sets: &[Vec<usize>]) {
        let new: BTreeSet<&Vec<usize>> = sets.iter().filter(|set| !self.known.contains_key(*set)).collect();
        let new: Vec<&Vec<usize>> = new.into_iter().collect();
        let found = in_parts(&new, &|set: &&Vec<usize>| {
            let (scale, evidence) = self.likelihood.evidence(set);
            (scale, evidence + self.odds.of(set))
        });
        self.known.extend(new.into_iter().cloned().zip(found));
    }

    /// The best single additions to a set, by score at its scale.
    fn closest(&self, set: &[usize], scale: f64) -> Vec<usize> {
        let gains = self.likelihood.gains(set, scale);
        let mut order: Vec<(f64, usize)> = gains
            .iter()
            .enumerate()
            .map(|(k, gain)| (gain + self.odds.log[k], k))
            .filter(|(gain, _)| gain.is_finite())
            .collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        order.into_iter().take(CLOSEST).map(|(_, k)| k).collect()
    }

    /// Replaces a set by the best neighboring one until no step improves it.
    fn climb(&mut self, start: &[usize]) {
        let mut set = start.to_vec();
        let (mut scale, mut score) = self.of(&set);
        loop {
            let mut next: Vec<Vec<usize>> = Vec::new();
            if set.len() < MOST {
                next.extend(self.closest(&set, scale).into_iter().map(|column| with(&set, column)));
            }
            let places: Vec<usize> = (0..set.len()).collect();
            let exchanged = in_parts(&places, &|&place: &usize| {
                let without = without(&set, place);
                let others = self.closest(&without, scale).into_iter().filter(|&column| column != set[place]);
                let others: Vec<Vec<usize>> = others.map(|column| with(&without, column)).collect();
                std::iter::once(without).chain(others).collect::<Vec<_>>()
            });
            next.extend(exchanged.into_iter().flatten());
            self.learn(&next);
            let mut best: Option<(f64, f64, Vec<usize>)> = None;
            for next in next {
                let (scale, score) = self.of(&next);
                if best.as_ref().is_none_or(|(_, known, _)| score > *known) {
                    best = Some((scale, score, next));
                }
            }
            match best {
                Some((next_scale, next_score, next)) if next_score > score + 1e-9 => {
                    (scale, score, set) = (next_scale, next_score, next);
                }
                _ => return,
            }
        }
    }
}

fn with(set: &[usize], column: usize) -> Vec<usize> {
    let mut out = set.to_vec();
    let place = out.partition_point(|&known| known < column);
    out.insert(place, column);
    out
}

fn without(set: &[usize], place: usize) -> Vec<usize> {
    let mut out = set.to_vec();
    out.remove(place);
    out
}

/// Finds the explanations of a likelihood, the most probable first. The search starts from each of the `starts`, sets of terms in ascending order.
#[must_use]
pub fn explanations(likelihood: &Likelihood<'_>, odds: &Odds, starts: &[Vec<usize>]) -> Vec<Explanation> {
    let mut scores = Scores { likelihood, odds, known: HashMap::new() };
    starts.iter().for_each(|start| scores.climb(start));
    let best = scores.known.values().map(|(_, score)| *score).fold(f64::NEG_INFINITY, f64::max);
    let mut kept: BTreeMap<Vec<usize>, f64> = BTreeMap::new();
    for (set, (_, score)) in scores.known {
        if score > best - WITHIN {
            kept.insert(set, (score - best).exp());
        }
    }
    let total: f64 = kept.values().sum();
    let mut out: Vec<Explanation> = kept
        .into_iter()
        .map(|(set, weight)| Explanation { posterior: likelihood.posterior(&set), set, probability: weight / total })
        .collect();
    out.sort_by(|a, b| b.probability.total_cmp(&a.probability).then_with(|| a.set.cmp(&b.set)));
    out
}
