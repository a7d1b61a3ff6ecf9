//! Explanations of what a model leaves of readings: one likelihood, sets of terms with probabilities.
//!
//! ```text
//! Scene::new(machine, errors, sets)   the residual of every reading, and its sensitivity to a deviation anywhere
//! term::terms                         what readings would have in addition, each error in one form
//! NoiseSeries::new                    readings in series; noise with memory, filtered
//! Likelihood::new                     set-ups eliminated; everything about a set of terms from products of columns
//! search::explanations                sets of terms with probabilities
//! findings                            terms with the probability that they are there, sizes averaged over all explanations
//! ```
//!
//! This is the core of the next diagnosis; it stands beside [`crate::diagnose`] until it does all that that one does. It knows position-dependent and
//! position-independent errors, backlash and play of all axes, lags, and noise with memory; it has no
//! thermal or instrument terms and no deflection yet.

pub mod assumptions;
pub mod likelihood;
pub mod noise;
pub mod search;
pub mod term;

use std::collections::HashMap;
use std::sync::Arc;

use crate::diagnose::Scene;
use crate::diagnose::scene::Through;
use likelihood::Likelihood;
use ncfix_base::numeric::in_parts;
use noise::{Memory, NoiseSeries};
use search::Explanation;
use term::Term;

/// Memories of the noise that are searched with at most.
const MOST_MEMORIES: usize = 5;

/// Explanations of the readings of a scene.
#[derive(Clone, Debug, Default)]
pub struct Explained {
    /// The terms that readings can show.
    pub terms: Vec<Term>,
    /// Names of terms that act like one of these on everything that was measured, with the number of that one.
    pub alike: Vec<(String, usize)>,
    /// Explanations, the most probable first; numbers of their sets are those of `terms`.
    pub explanations: Vec<Explanation>,
    /// Standard deviation of the readings beside what is stated, with the first explanation.
    pub scale: f64,
    /// Memory of the noise; its length is in seconds if the readings have a clock, else in rows.
    pub memory: Memory,
    /// Readings have a clock.
    pub has_clock: bool,
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
    let log_odds: Vec<f64> = all.iter().map(|term| term.family.assumption().odds.ln()).collect();
    let noise = NoiseSeries::new(scene);
    let readings = (scene.items.len() as f64).max(2.0);
    // Two numbers more than white noise has, by the information criterion of Schwarz (1978).
    let price = |memory: Memory| if memory.ratio > 0.0 { readings.ln() } else { 0.0 };
    let choose = |set: &[usize]| {
        let some: Vec<Vec<f64>> = set.iter().map(|&number| columns[number].clone()).collect();
        let some_sizes: Vec<f64> = set.iter().map(|&number| sizes[number]).collect();
        let worth = |&memory: &Memory| {
            let likelihood = Likelihood::new(scene, &some, &some_sizes, (&noise, memory));
            let own: Vec<usize> = (0..likelihood.count()).collect();
            likelihood.evidence(&own).1 - price(memory)
        };
        let memories = noise.memories();
        let worths = in_parts(&memories, &worth);
        let best = memories.into_iter().zip(worths).max_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or_else(Memory::default, |(memory, _)| memory)
    };
    let mut best: Option<(f64, Memory, Likelihood, Vec<Explanation>)> = None;
    let mut tried: Vec<Memory> = Vec::new();
    // Terms and noise explain the same readings: the search starts from white noise, and from all readings as noise with memory.
    for start in [Memory::default(), choose(&[])] {
        let mut memory = start;
        while !tried.contains(&memory) && tried.len() < MOST_MEMORIES {
            tried.push(memory);
            let likelihood = Likelihood::new(scene, &columns, &sizes, (&noise, memory));
            let own_odds: Vec<f64> = likelihood.kept.iter().map(|&number| log_odds[number]).collect();
            let is_simple = |&k: &usize| all[likelihood.kept[k]].family.is_simple();
            let simple: Vec<usize> = (0..likelihood.count()).filter(is_simple).collect();
            let explanations = search::explanations(&likelihood, &own_odds, &simple);
            let Some(first) = explanations.first() else { break };
            let odds: f64 = first.set.iter().map(|&k| own_odds[k]).sum();
            let worth = likelihood.evidence(&first.set).1 + odds - price(memory);
            let set: Vec<usize> = first.set.iter().map(|&k| likelihood.kept[k]).collect();
            if best.as_ref().is_none_or(|(known, ..)| worth > *known) {
                best = Some((worth, memory, likelihood, explanations));
            }
            memory = choose(&set);
        }
    }
    let Some((_, memory, likelihood, explanations)) = best else { return Explained::default() };
    let number = |given: usize| likelihood.kept.iter().position(|&kept| kept == given).unwrap_or(0);
    Explained {
        terms: likelihood.kept.iter().map(|&number| all[number].clone()).collect(),
        alike: likelihood.alike.iter().map(|&(given, same)| (all[given].name(), number(same))).collect(),
        scale: explanations.first().map_or(1.0, |first| first.posterior.scale),
        memory,
        has_clock: noise.has_clock,
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
