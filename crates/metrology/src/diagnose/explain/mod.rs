//! Explanations of the residual of a model: one likelihood, sets of terms with probabilities.
//!
//! ```text
//! Scene::new(machine, errors, sets)   the residual of every reading, and its sensitivity to a deviation anywhere
//! term::terms                         the additional effect of each error on the readings, in one form
//! NoiseSeries::new                    readings in series; autocorrelated noise, filtered
//! Likelihood::new                     set-ups eliminated; everything about a set of terms from products of columns
//! search::explanations                sets of terms with probabilities
//! contest::contest                    the search over a growing pool of terms, with the autocorrelation of the noise
//! findings                            terms with their probabilities, and sizes averaged over all explanations
//! ```
//!
//! A diagnosis compares the result of its search with all sets of these terms and of the candidates of the registry. [`explain`] uses only errors of
//! axes: position-dependent and position-independent ones, backlash and lateral play, lags.

pub mod assumptions;
pub mod contest;
pub mod likelihood;
pub mod noise;
pub mod search;
mod setups;
pub mod term;
mod tridiagonal;

use std::collections::HashMap;
use std::sync::Arc;

use crate::diagnose::scene::Scene;
use crate::diagnose::scene::Through;
use contest::{Entrant, Outside};
use likelihood::ColumnGroup;
use noise::Memory;
use search::Explanation;
use term::Term;

/// Explanations of the readings of a scene.
#[derive(Clone, Debug, Default)]
pub struct Explained {
    /// The terms that readings can show.
    pub terms: Vec<Term>,
    /// Names of terms with the same effect as one of these on all measured positions, with the index of that one.
    pub alike: Vec<(String, usize)>,
    /// Explanations, the most probable first; their sets contain indices of `terms`.
    pub explanations: Vec<Explanation>,
    /// Factor of the stated uncertainty of the readings, with the first explanation.
    pub scale: f64,
    /// Autocorrelation of the noise; its length is in seconds if the readings have times, else in rows.
    pub memory: Memory,
    /// True if the readings have times.
    pub has_clock: bool,
}

/// A term that may be present.
#[derive(Clone, Debug)]
pub struct ProbableTerm {
    /// Index of the term.
    pub term: usize,
    /// Sum of the probabilities of the explanations that contain it.
    pub probability: f64,
    /// Amount averaged over these, mm or rad.
    pub mean: f64,
    /// Standard deviation between and within these explanations, mm or rad.
    pub sigma: f64,
}

impl Term {
    /// Its displayed name: `EC0X`, `EXX backlash`, `EYX X order 2`.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} {}", self.component, self.shape).trim_end().to_owned()
    }
}

/// Explains the readings of a scene.
#[must_use]
pub fn explain(scene: &Scene<'_>) -> Explained {
    let all = term::terms(scene);
    let mut factors: HashMap<Through, Arc<Vec<f64>>> = HashMap::new();
    let groups: Vec<ColumnGroup> = all
        .iter()
        .map(|term| {
            let through = term.through();
            let factors = factors.entry(through).or_insert_with(|| Arc::new(scene.factors(through)));
            ColumnGroup::one(term.column(scene, factors), term.size)
        })
        .collect();
    let weights: Vec<f64> = scene.items.iter().map(|item| 1.0 / item.sigma).collect();
    let log_odds: Vec<f64> = all.iter().map(|term| (term.share * term.family.assumption().odds).ln()).collect();
    let entrants = groups.into_iter().zip(&all).zip(&log_odds).map(|((group, term), log_odds)| Entrant {
        group,
        log_odds: *log_odds,
        parent: term.parent,
        is_simple: term.family.is_simple(),
    });
    let nobody = Outside { count: 0, log_odds: &|_| 0.0, group: &|_| ColumnGroup::default() };
    let found = contest::contest(scene, &weights, entrants.collect(), &nobody, &[]);
    let place = |given: usize| found.visible.iter().position(|&kept| kept == given).unwrap_or(0);
    let inner = |one: &Explanation| Explanation { set: one.set.iter().map(|&k| place(k)).collect(), ..one.clone() };
    Explained {
        terms: found.visible.iter().map(|&number| all[number].clone()).collect(),
        alike: found.alike.iter().map(|&(given, same)| (all[given].name(), place(same))).collect(),
        scale: found.explanations.first().map_or(1.0, |first| first.posterior.scale),
        memory: found.memory,
        has_clock: found.has_clock,
        explanations: found.explanations.iter().map(inner).collect(),
    }
}

impl Explained {
    /// Returns the terms of all explanations, the most probable first.
    #[must_use]
    pub fn findings(&self) -> Vec<ProbableTerm> {
        let mut sums: HashMap<usize, [f64; 3]> = HashMap::new();
        for one in &self.explanations {
            for ((&term, mean), sigma) in one.set.iter().zip(&one.posterior.mean).zip(&one.posterior.sigma) {
                let sum = sums.entry(term).or_default();
                sum[0] += one.probability;
                sum[1] += one.probability * mean;
                sum[2] += one.probability * (mean * mean + sigma * sigma);
            }
        }
        let mut out: Vec<ProbableTerm> = sums
            .into_iter()
            .map(|(term, [probability, first, second])| {
                let mean = first / probability;
                let sigma = (second / probability - mean * mean).max(0.0).sqrt();
                ProbableTerm { term, probability, mean, sigma }
            })
            .collect();
        out.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.term.cmp(&b.term)));
        out
    }
}
