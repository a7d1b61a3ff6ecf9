//! The test of stated hypotheses: amount, evidence alone and together with the accepted causes, gain on left-out readings, other explanations, possible
//! correction.
//!
//! The evidence is the ratio of the marginal likelihoods with and without the hypothesis ([`crate::diagnose::explain::likelihood`]), as a natural
//! logarithm. Both sides use the autocorrelation of the noise of the best set of terms that is compared. So slow noise is no evidence, nor is a
//! cause that is left out on both sides. The evidence contains no odds: those are for the user who states the hypothesis.

use super::super::cause::{Candidate, Causes, Correctable, Term};
use super::super::class::class;
use super::super::entrant::{group, is_slope};
use super::super::explain::contest::evidences;
use super::super::extend::{self, Change};
use super::super::fold::confirmed;
use super::super::held_out::{settled, unseen};
use super::super::readings::left_of;
use super::super::row::SceneRow;
use super::super::scene::Scene;
use super::super::search::Taken;
use super::super::shape::{Driver, driver};
use super::super::verdict::{AcceptedCause, DiagnosedCauses, Settled, diagnose_then};
use super::contested::{self, ContestedFinding, contested, key};
use super::form::{StatedHypothesis, TermAmount};
use super::subject::{StatedSubject, amounts, enter, subject};
use super::variant::variant;
use ncfix_base::geometry::AXES;
use ncfix_base::numeric::both;

/// Evidence from which a hypothesis is called supported or refuted, as a natural logarithm: 20 times as probable with it, or without it ("strong", Kass and Raftery 1995,
/// Bayes factors, Journal of the American Statistical Association 90).
pub const STRONG: f64 = 3.0;

/// Maximum number of other explanations that are compared.
const RIVALS: usize = 6;
/// Maximum number of hypotheses for which all combinations are compared.
const COMBINED: usize = 6;

/// The outcome for one hypothesis. Lengths are in mm, angles in rad.
#[derive(Clone, Debug, Default)]
pub struct HypothesisTrial {
    /// The hypothesis as stated.
    pub text: String,
    /// Effect and parameter, as a cause of this form is named.
    pub name: String,
    /// The reason why these readings cannot show it; `None` if they can.
    pub why_not_shown: Option<String>,
    /// Amount of each term.
    pub amounts: Vec<TermAmount>,
    /// RMS of its effect on the readings, mm or rad.
    pub rms: f64,
    /// Range of its effect on the readings of a set-up, mm or rad.
    pub alone: f64,
    /// Natural logarithm of the evidence for it, without any accepted cause.
    pub evidence_alone: f64,
    /// Natural logarithm of the evidence for it, in addition to the accepted causes that do not represent it.
    pub evidence_beside: f64,
    /// Names of the accepted causes that were included in the test.
    pub beside: Vec<String>,
    /// Parameters of the machine file of these causes: a calibration needs them beside the hypothesis.
    pub beside_parameters: Vec<String>,
    /// Names of the accepted causes with the same effect on the readings, which it replaces in the test.
    pub stands_for: Vec<String>,
    /// Natural logarithm of the evidence of all these causes together in its place, minus its own; `None` without such causes.
    pub evidence_of_findings: Option<f64>,
    /// Relative reduction of the RMS of left-out readings; `None` if no part of the data could decide.
    pub gain: Option<f64>,
    /// `true` if the gain is that on held-out data.
    pub is_held_out: bool,
    /// Other explanations that are nearly as good, the best first.
    pub rivals: Vec<EqualExplanation>,
    /// The measurement that separates it from the first other explanation.
    pub separate_by: Option<String>,
    /// Possible correction.
    pub correctable: Correctable,
    /// Changes of the machine file that hold it, or the reason why it cannot.
    pub changes: Option<Result<Vec<Change>, String>>,
    /// Probability over all combinations of the stated hypotheses, with equal prior odds; `None` if it is not visible.
    pub probability: Option<f64>,
    /// Number of variants of a named cause from which the best was selected.
    pub variants: usize,
    /// The words that distinguish the selected variant from the others; `None` for a single one.
    pub variant: Option<String>,
    /// True if the machine file has an entry for it, so that a calibration can fit and write it.
    pub is_storable: bool,
    /// Its drivers by row of the scene.
    pub drivers: Vec<Driver>,
    /// Residual of each reading without it and with it, in the order of [`Scene::items`], mm or rad.
    pub without: Vec<f64>,
    /// See [`HypothesisTrial::without`].
    pub with: Vec<f64>,
}

impl HypothesisTrial {
    /// True if an amount exceeds its uncertainty. The terms of a sum may be certain only together. The likelihood of a wrong noise may favor a term that the
    /// readings do not show otherwise.
    #[must_use]
    pub fn is_seen(&self) -> bool {
        self.amounts.iter().any(|amount| amount.value.abs() > amount.u95)
            || (self.amounts.len() != 1 && self.gain.is_some_and(|gain| gain > 0.0))
    }

    /// True if the readings support it, and the findings that it replaced are not surely better.
    #[must_use]
    pub fn is_supported(&self) -> bool {
        let is_outdone = self.evidence_of_findings.is_some_and(|better| better >= STRONG);
        self.why_not_shown.is_none() && self.evidence_beside >= STRONG && !is_outdone && self.is_seen()
    }
}

/// Another explanation instead of a hypothesis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EqualExplanation {
    /// Effect and parameter.
    pub name: String,
    /// Natural logarithm of its evidence, minus that of the hypothesis.
    pub log_evidence: f64,
}

/// A combination of stated hypotheses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StatedSet {
    /// Their indices.
    pub members: Vec<usize>,
    /// Probability among all combinations.
    pub probability: f64,
}

/// The outcome for all hypotheses.
#[derive(Clone, Debug, Default)]
pub struct StatedTrials {
    /// One for each hypothesis, in the order in which they were stated.
    pub trials: Vec<HypothesisTrial>,
    /// Combinations, the most probable first; empty if none is visible.
    pub sets: Vec<StatedSet>,
}

/// Diagnoses a scene, and tests hypotheses together with the accepted causes.
#[must_use]
pub fn diagnose_stated(
    stated: &[StatedHypothesis],
    causes: &Causes,
    scene: &Scene<'_>,
    (bare, used): (&Scene<'_>, usize),
    note: &mut dyn FnMut(&str, f64),
) -> (DiagnosedCauses, StatedTrials) {
    let (mut trials, mut contested) = (StatedTrials::default(), Vec::new());
    let mut found = diagnose_then(causes, scene, (bare, used), note, &mut |outcome, note| {
        if !stated.is_empty() {
            (trials, contested) = of_all(stated, outcome, note);
        }
    });
    contested::share(&contested, &mut found);
    (found, trials)
}

/// The outcome for all hypotheses, and the findings that they contest.
fn of_all(
    stated: &[StatedHypothesis],
    mut outcome: Settled<'_, '_, '_>,
    note: &mut dyn FnMut(&str, f64),
) -> (StatedTrials, Vec<ContestedFinding>) {
    let mut trials: Vec<HypothesisTrial> = Vec::new();
    let mut subjects: Vec<(usize, StatedSubject)> = Vec::new();
    let mut contested = Vec::new();
    // Each hypothesis is tested without the candidates of the others.
    let known = outcome.field.candidates.len();
    let mut own: Vec<Option<Candidate>> = Vec::new();
    for (place, one) in stated.iter().enumerate() {
        note("hypotheses", place as f64 / stated.len().max(1) as f64);
        let mut trial = HypothesisTrial { text: one.text.clone(), ..HypothesisTrial::default() };
        match subject(one, &mut outcome, &[]) {
            Ok(subject) => {
                contested.extend(judge(&mut trial, &subject, &outcome, note));
                if trial.why_not_shown.is_none() {
                    let is_new = subject.number >= known;
                    own.push(outcome.field.candidates.get(subject.number).filter(|_| is_new).cloned());
                    subjects.push((place, subject));
                }
            }
            Err(why) => trial.why_not_shown = Some(why),
        }
        outcome.field.candidates.truncate(known);
        trials.push(trial);
    }
    for ((_, subject), own) in subjects.iter_mut().zip(own) {
        if let Some(own) = own {
            subject.number = enter(outcome.field, own);
        }
    }
    let sets = combinations(&subjects, &outcome);
    for (place, _) in &subjects {
        let own = sets.iter().filter(|set| set.members.contains(place)).map(|set| set.probability);
        if let Some(trial) = trials.get_mut(*place) {
            // Rounding must not make a sum of probabilities exceed 1.
            trial.probability = Some(own.fold(0.0, |sum, one| sum + one).min(1.0));
        }
    }
    (StatedTrials { trials, sets }, contested)
}

/// Velocity of an axis by row, mm/s or rad/s; `None` if the driver is not a velocity.
fn speed(scene: &Scene<'_>, name: &str) -> Option<Driver> {
    let letter = name.strip_prefix("v(")?.strip_suffix(')')?;
    let axis = AXES.into_iter().find(|axis| axis.to_string() == letter)?;
    let of = |row: &SceneRow| row.velocity.map_or(f64::NAN, |velocity| velocity[axis]);
    let unit = if axis.is_rotary() { "rad/s" } else { "mm/s" };
    Some(Driver { name: name.to_owned(), unit, values: scene.rows.iter().map(of).collect() })
}

fn name_of(one: &Candidate) -> String {
    format!("{} {}", one.cause.effect, one.parameter).trim_end().to_owned()
}

fn judge(
    trial: &mut HypothesisTrial,
    subject: &StatedSubject,
    outcome: &Settled<'_, '_, '_>,
    note: &mut dyn FnMut(&str, f64),
) -> Vec<ContestedFinding> {
    let field = &*outcome.field;
    let (scene, weights) = (field.scene, outcome.weights);
    let Some(one) = field.candidates.get(subject.number) else { return Vec::new() };
    let named = |number: usize| field.candidates.get(number).map_or_else(String::new, name_of);
    let is_beside = |place: &usize| !subject.overlap.stand_ins.contains(place);
    let kept = || outcome.kept.iter().enumerate();
    let again = subject.overlap.added().map(|candidate| (Taken { candidate, chance: 0.0 }, 0.0));
    let others: Vec<(Taken, f64)> =
        kept().filter(|(place, _)| is_beside(place)).map(|(_, one)| one.clone()).chain(again).collect();
    let beside: Vec<usize> = others.iter().map(|(taken, _)| taken.candidate).collect();
    let replaced: Vec<usize> =
        kept().filter(|(place, _)| !is_beside(place)).map(|(_, (taken, _))| taken.candidate).collect();
    trial.name = name_of(one);
    trial.variants = subject.variants;
    trial.variant = variant(one).filter(|_| subject.variants > 1);
    // A slope and a curve of one error have one name.
    let apart = |numbers: &[usize], others: &[usize]| -> Vec<String> {
        let of = |&number: &usize| {
            let name = named(number);
            let is_shared = numbers.iter().chain(others).filter(|&&other| named(other) == name).count() > 1;
            let is_straight = field.candidates.get(number).is_some_and(is_slope);
            if is_straight && is_shared { format!("{name} (slope)") } else { name }
        };
        numbers.iter().map(of).collect()
    };
    trial.beside = apart(&beside, &replaced);
    let of_file = |one: &Candidate| match &one.term {
        Term::Parameters(names) => names.iter().map(ToString::to_string).collect(),
        _ => Vec::new(),
    };
    trial.beside_parameters =
        beside.iter().filter_map(|&number| field.candidates.get(number)).flat_map(of_file).collect();
    trial.stands_for = apart(&replaced, &beside);
    trial.drivers = one.drivers.iter().filter_map(|name| driver(scene, name).or_else(|| speed(scene, name))).collect();
    let with: Vec<usize> = beside.iter().copied().chain([subject.number]).collect();
    // Other explanations in its place.
    let memory = field.memory(weights, &with);
    let whole = field.series(weights, &with, memory);
    let freedom = (whole.count() - whole.rank().min(whole.count())).max(1) as f64;
    let noise = whole.squares() / freedom * field.inflation(weights, &with, &beside, subject.number);
    let mut rivals: Vec<usize> = Vec::new();
    let gains = field.gains(weights, &field.series(weights, &beside, memory));
    for rival in class(field, &gains, subject.number, noise).into_iter().skip(1) {
        if !replaced.contains(&rival) && !beside.contains(&rival) && named(rival) != trial.name {
            rivals.push(rival);
        }
    }
    rivals.truncate(RIVALS);
    evidence(trial, subject, outcome, (&beside, &rivals, &replaced));
    gain(trial, subject, outcome, (&others, &with), note);
    let taken = Taken { candidate: subject.number, chance: 0.0 };
    let all: Vec<(Taken, f64)> = others.iter().cloned().chain([(taken, trial.gain.unwrap_or(0.0))]).collect();
    let found = outcome.verdict_of(&all);
    let mut out = Vec::new();
    if let Some(accepted) = found.findings.iter().find(|own| key(&own.candidate) == key(one)) {
        trial.rms = accepted.rms;
        trial.alone = accepted.alone;
        trial.amounts = amounts(&trial.name, subject, accepted);
        trial.separate_by = accepted.separate_by.clone().filter(|_| !trial.rivals.is_empty());
        if let Some(better) = trial.evidence_of_findings.filter(|_| trial.is_supported()) {
            out = contested((&trial.text, better), outcome, (one, accepted), (&beside, &replaced));
        }
        // Against its absence, at even odds; its rivals are a matter of the extrapolation risk.
        let probability = 1.0 / (1.0 + (-trial.evidence_beside).exp());
        let accepted = &AcceptedCause { probability: Some(probability.min(accepted.nature_share)), ..accepted.clone() };
        let changes = if subject.overlap.added().next().is_some() && trial.evidence_beside > 0.0 {
            let names: Vec<&str> =
                subject.overlap.added().filter_map(|one| Some(field.candidates.get(one)?.parameter.as_str())).collect();
            let names = names.join(" and ");
            let both = format!(
                "its amount is valid only together with a new value of {names}: fit both with ncfix calibrate --model"
            );
            // A calibration has no entry for some terms: then this is the reason.
            extend::of_stated(accepted, scene, outcome.used).and(Err(both))
        } else if trial.evidence_beside > 0.0 {
            extend::of_one(accepted, found.used.before.rms, (scene, outcome.used))
        } else if trial.evidence_beside > -STRONG {
            Err("the readings do not decide it".to_owned())
        } else {
            Err("the readings contradict it".to_owned())
        };
        trial.correctable = match (&changes, one.cause.correctable) {
            (Err(_), _) => Correctable::No,
            (Ok(_), Correctable::No) => Correctable::Program,
            (Ok(_), own) => own,
        };
        // An amount that needs another one needs a calibration of both.
        let is_needed = subject.overlap.added().next().is_some();
        let is_storable = || extend::of_stated(accepted, scene, outcome.used).is_ok();
        trial.is_storable = changes.is_ok() || (is_needed && trial.evidence_beside > 0.0 && is_storable());
        trial.changes = Some(changes);
    }
    (trial.without, trial.with) = both(|| left_of(field, weights, &beside), || left_of(field, weights, &with));
    out
}

/// Evidence alone, together with the accepted causes, and of other explanations in its place.
fn evidence(
    trial: &mut HypothesisTrial,
    subject: &StatedSubject,
    outcome: &Settled<'_, '_, '_>,
    (beside, rivals, replaced): (&[usize], &[usize], &[usize]),
) {
    let field = &*outcome.field;
    let all = [subject.number].into_iter().chain([beside, rivals, replaced].into_iter().flatten().copied());
    let all: Vec<usize> = all.collect();
    let groups: Vec<_> =
        all.iter().filter_map(|&number| field.candidates.get(number)).map(|one| group(field, one)).collect();
    let others: Vec<usize> = (1..=beside.len()).collect();
    let with = |number: usize| -> Vec<usize> { others.iter().copied().chain([number]).collect() };
    let first = 1 + beside.len() + rivals.len();
    // Its replaced shapes contain the slope that stays beside it.
    let is_slope = |k: &usize| k.checked_sub(1).and_then(|k| beside.get(k)).copied() == subject.overlap.slope;
    let kept = others.iter().copied().filter(|k| subject.overlap.slope.is_none() || !is_slope(k));
    let instead = kept.chain(first..first + replaced.len()).collect();
    let mut sets = vec![Vec::new(), vec![0], others.clone(), with(0), instead];
    sets.extend((0..rivals.len()).map(|k| with(1 + beside.len() + k)));
    let found = evidences(field.scene, &outcome.weights.items, &groups, &sets);
    // The best of several variants is better by chance.
    let look = (subject.variants.max(1) as f64).ln();
    if let [nothing, alone, without, own, instead, of_rivals @ ..] = found.as_slice() {
        trial.evidence_alone = alone - nothing - look;
        trial.evidence_beside = own - without - look;
        let is_other = replaced.iter().any(|number| *number != subject.number);
        trial.evidence_of_findings = is_other.then(|| instead - own);
        // Instead of an absent effect, every explanation is equally good.
        if trial.evidence_beside <= 0.0 {
            return;
        }
        let rival = |(&number, evidence): (&usize, &f64)| EqualExplanation {
            name: field.candidates.get(number).map_or_else(String::new, name_of),
            log_evidence: evidence - own,
        };
        trial.rivals = rivals.iter().zip(of_rivals).map(rival).collect();
        trial.rivals.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
    }
}

/// Gain on held-out data, otherwise on parts that are left out in turn.
fn gain(
    trial: &mut HypothesisTrial,
    subject: &StatedSubject,
    outcome: &Settled<'_, '_, '_>,
    (others, with): (&[(Taken, f64)], &[usize]),
    note: &mut dyn FnMut(&str, f64),
) {
    let field = &*outcome.field;
    if outcome
        .held_out
        .items
        .iter()
        .zip(&field.scene.items)
        .any(|(weight, item)| *weight > 0.0 && item.row < field.scene.rows.len())
    {
        let beside: Vec<usize> = others.iter().map(|(taken, _)| taken.candidate).collect();
        let squares = |taken: &[usize]| unseen(field, outcome.weights, outcome.held_out, taken);
        let (without, with) = (squares(&beside), squares(with));
        trial.is_held_out = true;
        trial.gain = (without > 0.0).then(|| 1.0 - (with / without).sqrt());
        return;
    }
    let judged: Vec<Taken> = with.iter().map(|&candidate| Taken { candidate, chance: 0.0 }).collect();
    let mut stopped = None;
    let mut out = |term: &Taken, gain: Option<f64>| {
        if term.candidate == subject.number {
            stopped = gain;
        }
    };
    let mut own = field.beside(field.candidates.len());
    let kept = confirmed(&mut own, outcome.weights, judged, &mut settled(with), &mut out, &mut |share| {
        note("hypotheses", share)
    });
    trial.gain = kept.iter().find(|(taken, _)| taken.candidate == subject.number).map(|(_, gain)| *gain).or(stopped);
}

/// Probabilities of combinations of visible hypotheses, together with the accepted causes that represent none of them, with equal prior odds.
fn combinations(subjects: &[(usize, StatedSubject)], outcome: &Settled<'_, '_, '_>) -> Vec<StatedSet> {
    if subjects.is_empty() {
        return Vec::new();
    }
    let field = &*outcome.field;
    let is_base = |place: &usize| subjects.iter().all(|(_, subject)| !subject.overlap.stand_ins.contains(place));
    let kept = outcome.kept.iter().enumerate().filter(|(place, _)| is_base(place));
    let again = subjects.iter().flat_map(|(_, subject)| subject.overlap.added());
    let mut base: Vec<usize> = kept.map(|(_, (taken, _))| taken.candidate).chain(again).collect();
    base.sort_unstable();
    base.dedup();
    let numbers = base.iter().copied().chain(subjects.iter().map(|(_, subject)| subject.number));
    let groups: Vec<_> =
        numbers.filter_map(|number| field.candidates.get(number)).map(|one| group(field, one)).collect();
    let count = subjects.len();
    let chosen: Vec<Vec<usize>> = if count <= COMBINED {
        (0..1_usize << count).map(|bits| (0..count).filter(|k| bits >> k & 1 == 1).collect()).collect()
    } else {
        let singles = (0..count).map(|k| vec![k]);
        std::iter::once(Vec::new()).chain(singles).chain([(0..count).collect()]).collect()
    };
    let set = |own: &Vec<usize>| (0..base.len()).chain(own.iter().map(|k| base.len() + k)).collect();
    let sets: Vec<Vec<usize>> = chosen.iter().map(set).collect();
    let mut found = evidences(field.scene, &outcome.weights.items, &groups, &sets);
    for (evidence, own) in found.iter_mut().zip(&chosen) {
        let looks =
            own.iter().filter_map(|&k| subjects.get(k)).map(|(_, subject)| (subject.variants.max(1) as f64).ln());
        *evidence -= looks.sum::<f64>();
    }
    let best = found.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let total: f64 = found.iter().map(|evidence| (evidence - best).exp()).sum();
    let mut out: Vec<StatedSet> = chosen
        .iter()
        .zip(&found)
        .map(|(own, evidence)| StatedSet {
            members: own.iter().filter_map(|&k| subjects.get(k)).map(|(place, _)| *place).collect(),
            probability: (evidence - best).exp() / total,
        })
        .collect();
    out.sort_by(|a, b| b.probability.total_cmp(&a.probability).then_with(|| a.members.cmp(&b.members)));
    out
}
