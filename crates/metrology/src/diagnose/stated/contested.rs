//! Findings that a stated hypothesis contests: it explains the same readings at least nearly as well, and acts in another way elsewhere. Such a finding is
//! not certain.

use super::super::cause::{Candidate, CauseId};
use super::super::doubt::{ExtrapolationRisk, is_bounded, leaves, sum};
use super::super::separate::separating;
use super::super::undecided::{RivalCause, share_out};
use super::super::verdict::{AcceptedCause, DiagnosedCauses, Settled};
use super::super::volume::Volume;
use ncfix_base::numeric::sums::dot;

/// Two errors are one if correcting by one of them leaves less than this share of the other over the travel.
const SAME: f64 = 0.2;

/// A contested finding.
#[derive(Clone, Debug)]
pub(super) struct ContestedFinding {
    /// Key of its first weight.
    key: Option<usize>,
    /// The hypothesis, with its share.
    rival: RivalCause,
    separate_by: String,
}

/// Key of a candidate and its clones.
pub(super) fn key(one: &Candidate) -> Option<usize> {
    one.columns.first().and_then(|parts| parts.first()).map(|(_, weight)| weight.key())
}

/// The findings `replaced` that a supported hypothesis contests, with its amounts: its text, and the natural logarithm of their evidence minus its own. `beside`
/// are the findings that both leave in the model.
pub(super) fn contested(
    (text, better): (&str, f64),
    outcome: &Settled<'_, '_, '_>,
    (one, accepted): (&Candidate, &AcceptedCause),
    (beside, replaced): (&[usize], &[usize]),
) -> Vec<ContestedFinding> {
    let field = &*outcome.field;
    let all: Vec<&Candidate> = replaced.iter().filter_map(|&number| field.candidates.get(number)).collect();
    let columns: Vec<Vec<f64>> = all.iter().flat_map(|own| field.columns(own)).collect();
    let (amounts, _) = field.series(outcome.weights, beside, 0.0).amounts(&columns);
    let volume = Volume::new(field.scene, |row| row.set < outcome.used);
    let is_elsewhere = volume.as_ref().is_none_or(|volume| {
        let fields: Vec<Vec<f64>> = all.iter().flat_map(|own| volume.fields(own, is_bounded(own))).collect();
        let own = sum(&fields, &amounts);
        let stated = sum(&volume.fields(one, is_bounded(one)), &accepted.amounts.values);
        if dot(&own, &own) > 0.0 && dot(&stated, &stated) > 0.0 {
            return leaves(&own, &stated, SAME);
        }
        // Without displacements by position, only causes of the same quantities are known to be the same elsewhere.
        let of_all: Vec<&String> = all.iter().flat_map(|own| &own.drivers).collect();
        one.drivers.iter().any(|driver| !of_all.contains(&driver))
            || of_all.iter().any(|own| !one.drivers.contains(own))
    });
    if !is_elsewhere {
        return Vec::new();
    }
    // At even odds: the user has a reason to state it.
    let rival = RivalCause { cause: CauseId::Stated(text.to_owned()), probability: 1.0 / (1.0 + better.exp()) };
    let of = |own: &&Candidate| ContestedFinding {
        key: key(own),
        rival: rival.clone(),
        separate_by: separating(field.scene, own, one),
    };
    all.iter().map(of).collect()
}

/// Gives hypotheses their shares in the probabilities of the findings that they contest.
pub(super) fn share(contested: &[ContestedFinding], found: &mut DiagnosedCauses) {
    for one in contested {
        let Some(finding) = found.findings.iter_mut().find(|own| key(&own.candidate) == one.key) else { continue };
        let own = 1.0 - one.rival.probability;
        if finding.rivals.iter().any(|known| known.cause == one.rival.cause) {
            continue;
        }
        let is_certain = finding.is_certain();
        finding.nature_share = finding.nature_share.min(own);
        finding.probability = finding.probability.map(|probability| probability.min(own));
        share_out(&mut found.explanations, &finding.candidate.id(), own, std::slice::from_ref(&one.rival));
        if is_certain && finding.is_certain() {
            continue;
        }
        finding.rivals.push(one.rival.clone());
        finding.rivals.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        if finding.doubt.is_none() {
            finding.separate_by = Some(one.separate_by.clone());
            finding.doubt = Some(ExtrapolationRisk {
                rivals: vec![one.rival.cause.to_string()],
                separate_by: one.separate_by.clone(),
            });
        }
    }
}
