//! Explanations of what a model leaves of readings: one likelihood, sets of terms with probabilities.
//!
//! ```text
//! Scene::new(machine, errors, sets)   the residual of every reading, and its sensitivity to a deviation anywhere
//! term::terms                         what readings would have in addition, each error in one form
//! Likelihood::new                     set-ups eliminated; everything about a set of terms from products of columns
//! search::explanations                sets of terms with probabilities
//! findings                            terms with the probability that they are there, sizes averaged over all explanations
//! ```
//!
//! This is the core of the next diagnosis; it stands beside [`crate::diagnose`] until it does all that that one does. It knows position-dependent and
//! position-independent errors, backlash and play of all axes; it has no thermal, dynamic or instrument terms yet, and noise without memory only.

pub mod assumptions;
pub mod likelihood;
pub mod search;
pub mod term;

use std::collections::HashMap;
use std::sync::Arc;

use crate::diagnose::Scene;
use crate::diagnose::scene::Through;
use assumptions::Family;
use likelihood::Likelihood;
use search::Explanation;
use term::Term;

/// Explanations of the readings of a scene.
#[derive(Clone, Debug)]
pub struct Explained {
    /// The terms that readings can show.
    pub terms: Vec<Term>,
    /// Names of terms that act like one of these on everything that was measured, with the number of that one.
    pub alike: Vec<(String, usize)>,
    /// Explanations, the most probable first; numbers of their sets are those of `terms`.
    pub explanations: Vec<Explanation>,
    /// Standard deviation of the readings beside what is stated, with the first explanation.
    pub scale: f64,
}

/// A term that may be there.
#[derive(Clone, Debug)]
pub struct ProbableTerm {
    /// Number of the term.
    pub term: usize,
    /// Sum of the probabilities of the explanations that have it.
    pub probability: f64,
    /// Amount averaged over these, mm or rad.
    pub mean: f64,
    /// Standard deviation over these and of each, mm or rad.
    pub sigma: f64,
}

impl Term {
    /// Its name for people: `EC0X`, `EXX backlash`, `EYX X order 2`.
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
    let columns: Vec<Vec<f64>> = all
        .iter()
        .map(|term| {
            let through = term.through();
            let factors = factors.entry(through).or_insert_with(|| Arc::new(scene.factors(through)));
            term.column(scene, factors)
        })
        .collect();
    let sizes: Vec<f64> = all.iter().map(|term| term.size).collect();
    let likelihood = Likelihood::new(scene, &columns, &sizes);
    let terms: Vec<Term> = likelihood.kept.iter().map(|&number| all[number].clone()).collect();
    let log_odds: Vec<f64> = terms.iter().map(|term| term.family.assumption().odds.ln()).collect();
    let is_simple = |term: &Term| {
        matches!(term.family, Family::Squareness | Family::Scale | Family::Backlash | Family::Offset | Family::Tilt)
    };
    let simple: Vec<usize> = (0..terms.len()).filter(|&k| is_simple(&terms[k])).collect();
    let explanations = search::explanations(&likelihood, &log_odds, &simple);
    let number = |given: usize| likelihood.kept.iter().position(|&kept| kept == given).unwrap_or(0);
    Explained {
        alike: likelihood.alike.iter().map(|&(given, same)| (all[given].name(), number(same))).collect(),
        scale: explanations.first().map_or(1.0, |first| first.posterior.scale),
        terms,
        explanations,
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
