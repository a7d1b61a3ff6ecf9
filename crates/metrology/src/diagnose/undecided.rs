//! Rivals of another nature: causes that predict the same readings as a finding, but depend on another quantity.
//!
//! In one run along an axis the temperature may rise with the position; circles in one direction do not separate a squareness from a lag of the drives. The
//! design of the measurement then leaves the cause open, however small the noise is, and what machines usually have is no evidence about this one. So every
//! registered cause takes the place of the finding in turn, together with the other findings, and natures that predict the readings to within the noise share
//! the probability by their likelihood alone. The corrections of different natures differ: one that is not certain must not be written.

use super::cause::{Candidate, CauseId, EffectKind, setup};
use super::contest::{ExplanationSummary, MOST_SHOWN};
use super::doubt::ExtrapolationRisk;
use super::entrant::{family, group};
use super::explain::assumptions::Family;
use super::nature::Nature;
use super::search::{Field, Weights};
use super::separate::separating;
use ncfix_base::numeric::{Gain, Series};

/// A cause with at least this probability is certain.
pub(super) const CERTAIN: f64 = 0.95;
/// Sizes beyond the typical one of their family times this factor, that of a worn machine, are implausible.
const WORN: f64 = 2.5;
/// A rival with a smaller share is not counted.
pub(super) const LEAST: f64 = 0.01;

/// The share of a finding in the probability of the natures that predict its readings.
#[derive(Clone, Debug)]
pub(super) struct Undecided {
    /// The share of its own nature; 1 without rivals.
    pub(super) own: f64,
    /// The best candidate of every other nature with its share, the largest first.
    pub(super) rivals: Vec<(usize, f64)>,
}

/// A cause that predicts the same readings as a finding but depends on another quantity.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RivalCause {
    /// Its effect and parameter, as `thermal-drift X`.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub cause: CauseId,
    /// Its share in the probability of the finding and its rivals.
    pub probability: f64,
}

impl Undecided {
    /// True if its nature is certain.
    pub(super) fn is_certain(&self) -> bool {
        self.own >= CERTAIN
    }
}

impl Field<'_, '_> {
    /// Compares a candidate with those of other natures, each together with the other findings: the regression on these and the gains of all candidates.
    /// `noise` is the variance of the readings.
    pub(super) fn undecided(
        &self,
        (series, gains): (&Series, &[Gain]),
        (number, others): (usize, &[usize]),
        noise: f64,
    ) -> Undecided {
        let certain = Undecided { own: 1.0, rivals: Vec::new() };
        let Some(one) = self.candidates.get(number) else { return certain };
        let Some(nature) = Nature::of(one) else { return certain };
        // Schwarz (1978): each further column must gain this much.
        let price = (series.count().max(2) as f64).ln();
        let evidence = |place: usize| -> Option<f64> {
            let (own, gain) = (self.candidates.get(place)?, gains.get(place)?);
            let readings = gain.squares / noise.max(f64::MIN_POSITIVE) - price * gain.rank as f64;
            Some(readings + certified(own) - self.strange(series, own))
        };
        let Some(own) = evidence(number) else { return certain };
        let mut best: Vec<(Nature, f64, usize)> = Vec::new();
        for (place, gain) in gains.iter().enumerate() {
            let Some(other) = self.candidates.get(place).filter(|_| gain.rank > 0 && !others.contains(&place)) else {
                continue;
            };
            let Some(of_other) = Nature::of(other).filter(|of_other| *of_other != nature && is_named(other)) else {
                continue;
            };
            // The size is computed for those only that come near.
            let bound = gain.squares / noise.max(f64::MIN_POSITIVE) - price * gain.rank as f64;
            if (0.5 * (bound - own)).exp() < LEAST {
                continue;
            }
            let Some(worth) = evidence(place) else { continue };
            match best.iter_mut().find(|(known, ..)| *known == of_other) {
                Some(known) if known.1 < worth => (known.1, known.2) = (worth, place),
                Some(_) => {}
                None => best.push((of_other, worth, place)),
            }
        }
        let most = best.iter().map(|(_, worth, _)| *worth).fold(own, f64::max);
        let weight = |worth: f64| (0.5 * (worth - most)).exp();
        let whole = weight(own) + best.iter().map(|(_, worth, _)| weight(*worth)).sum::<f64>();
        let share = |(_, worth, place): (Nature, f64, usize)| (place, weight(worth) / whole);
        let mut rivals: Vec<(usize, f64)> = best.into_iter().map(share).filter(|(_, share)| *share >= LEAST).collect();
        rivals.sort_by(|a, b| b.1.total_cmp(&a.1));
        Undecided { own: weight(own) / whole, rivals }
    }

    /// −2 ln of the prior density of the amounts of a candidate beside its mode: sizes that no machine has count against it.
    fn strange(&self, series: &Series, one: &Candidate) -> f64 {
        let own = group(self, one);
        let (amounts, _) = series.amounts(&own.columns);
        let of = |(amount, size): (&f64, &f64)| if *size > 0.0 { (amount / (WORN * size)).powi(2) } else { 0.0 };
        amounts.iter().zip(&own.sizes).map(of).sum()
    }

    /// Gives the terms of explanations that are not among the findings `kept` to their rivals too: a list of explanations must not be surer than a finding.
    /// Each is compared given the findings of its most probable explanation: those that it replaces would leave nothing for it.
    pub(super) fn share_others(&self, weights: &Weights, kept: &[usize], explanations: &mut Vec<ExplanationSummary>) {
        let id = |number: &usize| self.candidates.get(*number).map(Candidate::id);
        let known: Vec<CauseId> = kept.iter().filter_map(id).collect();
        let mut terms: Vec<(CauseId, Vec<CauseId>)> = Vec::new();
        let share = |term: &CauseId| -> f64 {
            explanations.iter().filter(|one| one.terms.contains(term)).map(|one| one.probability).sum()
        };
        for one in explanations.iter() {
            for term in one.terms.iter().filter(|term| !known.contains(term) && share(term) >= SHARED_OUT) {
                if !terms.iter().any(|(other, _)| other == term) {
                    terms.push((term.clone(), one.terms.clone()));
                }
            }
        }
        for (term, beside) in terms {
            let Some(number) = self.candidates.iter().position(|one| one.id() == term) else { continue };
            let others: Vec<usize> =
                kept.iter().copied().filter(|other| id(other).is_some_and(|id| beside.contains(&id))).collect();
            let with: Vec<usize> = others.iter().copied().chain([number]).collect();
            let series = self.series(weights, &others, self.memory(weights, &with));
            let gains = self.gains(weights, &series);
            let Some(gain) = gains.get(number) else { continue };
            let unknowns = (series.rank() + gain.rank).min(series.count());
            let freedom = (series.count() - unknowns).max(1) as f64;
            let noise = (series.squares() - gain.squares).max(0.0) / freedom;
            let noise = noise * self.inflation(weights, &with, &others, number);
            let undecided = self.undecided((&series, &gains), (number, &others), noise);
            if !undecided.is_certain() {
                share_out(explanations, &term, undecided.own, &self.rivals(&undecided));
            }
        }
    }

    /// The rivals by name.
    pub(super) fn rivals(&self, undecided: &Undecided) -> Vec<RivalCause> {
        let of = |&(place, probability): &(usize, f64)| {
            self.candidates.get(place).map(|one| RivalCause { cause: one.id(), probability })
        };
        undecided.rivals.iter().filter_map(of).collect()
    }

    /// The reason why a candidate whose nature is not certain must not be corrected.
    pub(super) fn nature_doubt(&self, one: &Candidate, undecided: &Undecided) -> Option<ExtrapolationRisk> {
        if undecided.is_certain() {
            return None;
        }
        let rival = undecided.rivals.first().and_then(|&(place, _)| self.candidates.get(place))?;
        Some(ExtrapolationRisk { rivals: vec![rival.title()], separate_by: separating(self.scene, one, rival) })
    }
}

/// Gives the rivals of a finding their share of the probability of every explanation that contains it.
pub(super) fn share_out(
    explanations: &mut Vec<ExplanationSummary>,
    finding: &CauseId,
    own: f64,
    rivals: &[RivalCause],
) {
    let has = |one: &ExplanationSummary| one.terms.iter().any(|term| term == finding);
    let whole: f64 = explanations.iter().filter(|one| has(one)).map(|one| one.probability).sum();
    let others: f64 = rivals.iter().map(|rival| rival.probability).sum();
    if whole <= own || others <= 0.0 {
        return;
    }
    let mut moved = Vec::new();
    for one in explanations.iter_mut().filter(|one| has(one)) {
        let kept = one.probability * own / whole;
        for rival in rivals {
            let beside = one.terms.iter().filter(|term| *term != finding);
            let terms = CauseId::in_order(beside.chain([&rival.cause]).cloned().collect());
            moved.push((terms, (one.probability - kept) * rival.probability / others));
        }
        one.probability = kept;
    }
    for (terms, probability) in moved {
        match explanations.iter_mut().find(|known| known.terms == terms) {
            Some(known) => known.probability += probability,
            None => explanations.push(ExplanationSummary { terms, probability }),
        }
    }
    explanations.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    explanations.truncate(MOST_SHOWN);
}

/// 2 ln of the odds of a set-up that its description states as known: a length with a certificate is rarely wrong. A probe has no certificate for its length
/// and its pre-travel on this machine, and an artifact has none for its alignment.
fn certified(one: &Candidate) -> f64 {
    let is_certified = family(one) == Family::Setup && !setup::is_alignment(one);
    if is_certified { 2.0 * Family::Setup.assumption().odds.ln() } else { 0.0 }
}

/// True for a cause with a name of its own. Cross-couplings and unnamed effects of any driver can follow almost everything.
fn is_named(one: &Candidate) -> bool {
    !matches!(one.cause.effect, EffectKind::Unknown | EffectKind::Cross) && one.columns.len() <= MOST
}

/// Terms with a smaller probability than this keep it: their rivals change no figure that is shown.
const SHARED_OUT: f64 = 0.05;

/// Columns of a rival at most: separate amounts at many places follow everything.
const MOST: usize = 3;
