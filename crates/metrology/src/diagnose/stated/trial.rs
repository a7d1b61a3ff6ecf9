//! The test of stated hypotheses: amount, evidence alone and beside the findings, gain on unseen readings, rivals, possible correction.
//!
//! The evidence is the ratio of the marginal likelihoods with and without the hypothesis ([`crate::diagnose::explain::likelihood`]), as a natural logarithm. Both sides have
//! the memory of the noise that suits them best, so that slow noise is no evidence. It holds no odds: those are for the person who states the hypothesis.

use super::super::cause::{Candidate, Causes, Correctable, EffectKind};
use super::super::contest::group;
use super::super::explain::contest::evidences;
use super::super::extend::{self, Change};
use super::super::fold::confirmed;
use super::super::held_out::{settled, unseen};
use super::super::readings::left_of;
use super::super::row::SceneRow;
use super::super::scene::{Scene, Through};
use super::super::search::{Field, Taken};
use super::super::shape::{Driver, driver};
use super::super::size::{Amounts, EXPANDED};
use super::super::verdict::{AcceptedCause, DiagnosedCauses, Settled, class, diagnose_then};
use super::build::{AmountUnit, Built, of_shape, of_sum};
use super::form::{StatedContent, StatedHypothesis, TermAmount};
use ncfix_base::geometry::AXES;
use ncfix_base::numeric::both;

/// A finding that takes this share of the squares of a hypothesis stands for it.
const STANDS: f64 = 0.9;
/// A column of which set-ups and other terms leave less than this share shows nothing of its own.
const OWN: f64 = 1e-9;
/// An effect of the usual size that changes the readings by less than this, in standard deviations of all of them together, is not visible: as in the likelihood.
const FAINT: f64 = 0.3;
/// Variants of a named cause that are compared, and rivals, at most.
const VARIANTS: usize = 6;
const RIVALS: usize = 6;
/// Hypotheses of which all combinations are compared, at most.
const COMBINED: usize = 6;

/// The outcome for one hypothesis. Lengths are in mm, angles in rad.
#[derive(Clone, Debug, Default)]
pub struct HypothesisTrial {
    /// The hypothesis as stated.
    pub text: String,
    /// Effect and parameter, as a finding of this form is named.
    pub name: String,
    /// Why these readings cannot show it; `None` if they can.
    pub why_not_shown: Option<String>,
    /// Amount of each term.
    pub amounts: Vec<TermAmount>,
    /// Root mean square of its effect on the readings, mm or rad.
    pub rms: f64,
    /// Largest less smallest effect on the readings of a set-up, mm or rad.
    pub alone: f64,
    /// Natural logarithm of the evidence for it, with no finding beside it.
    pub evidence_alone: f64,
    /// Natural logarithm of the evidence for it beside the findings that do not stand for it.
    pub evidence_beside: f64,
    /// Names of the findings beside which it was tested.
    pub beside: Vec<String>,
    /// Names of the findings that have the same effect on the readings: it stands in their place.
    pub stands_for: Vec<String>,
    /// Natural logarithm of the evidence of all these findings together in its place, less its own; `None` without such findings.
    pub evidence_of_findings: Option<f64>,
    /// Share of the root mean square of unseen readings that it removes; `None` if no part could decide.
    pub gain: Option<f64>,
    /// `true` if the gain is that of the data held out.
    pub is_held_out: bool,
    /// Explanations that are nearly as good, the best first.
    pub rivals: Vec<EqualExplanation>,
    /// The measurement that separates it from the first rival.
    pub separate_by: Option<String>,
    /// Possible correction.
    pub correctable: Correctable,
    /// Changes of the machine file that hold it, or why it cannot.
    pub changes: Option<Result<Vec<Change>, String>>,
    /// Probability over all combinations of the stated hypotheses, with even odds of each; `None` if it is not visible.
    pub probability: Option<f64>,
    /// Number of variants of a named cause from which the best was taken.
    pub variants: usize,
    /// Its drivers by row of the scene.
    pub drivers: Vec<Driver>,
    /// Residual of each reading without it and with it, in the order of [`Scene::items`], mm or rad.
    pub without: Vec<f64>,
    /// See [`HypothesisTrial::without`].
    pub with: Vec<f64>,
}

/// Another explanation in the place of a hypothesis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EqualExplanation {
    /// Effect and parameter.
    pub name: String,
    /// Natural logarithm of its evidence less that of the hypothesis.
    pub log_evidence: f64,
}

/// A combination of stated hypotheses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StatedSet {
    /// Their numbers.
    pub members: Vec<usize>,
    /// Probability among all combinations.
    pub probability: f64,
}

/// The outcome for all hypotheses.
#[derive(Clone, Debug, Default)]
pub struct StatedTrials {
    /// One for each, in the order in which they were stated.
    pub trials: Vec<HypothesisTrial>,
    /// Combinations, the most probable first; empty if none is visible.
    pub sets: Vec<StatedSet>,
}

/// Diagnoses a scene, and tests hypotheses beside the findings.
#[must_use]
pub fn diagnose_stated(
    stated: &[StatedHypothesis],
    causes: &Causes,
    scene: &Scene<'_>,
    (bare, used): (&Scene<'_>, usize),
    note: &mut dyn FnMut(&str, f64),
) -> (DiagnosedCauses, StatedTrials) {
    let mut trials = StatedTrials::default();
    let found = diagnose_then(causes, scene, (bare, used), note, &mut |outcome, note| {
        if !stated.is_empty() {
            trials = of_all(stated, outcome, note);
        }
    });
    (found, trials)
}

/// A hypothesis with the number of its candidate among those of the field.
struct Subject {
    number: usize,
    units: Vec<AmountUnit>,
    variants: usize,
    /// Places among the accepted candidates that stand for it.
    stand_ins: Vec<usize>,
}

fn of_all(
    stated: &[StatedHypothesis],
    mut outcome: Settled<'_, '_, '_>,
    note: &mut dyn FnMut(&str, f64),
) -> StatedTrials {
    let mut trials: Vec<HypothesisTrial> = Vec::new();
    let mut subjects: Vec<(usize, Subject)> = Vec::new();
    for (place, one) in stated.iter().enumerate() {
        note("hypotheses", place as f64 / stated.len().max(1) as f64);
        let mut trial = HypothesisTrial { text: one.text.clone(), ..HypothesisTrial::default() };
        match subject(one, &mut outcome) {
            Ok(subject) => {
                judge(&mut trial, &subject, &outcome, note);
                if trial.why_not_shown.is_none() {
                    subjects.push((place, subject));
                }
            }
            Err(why) => trial.why_not_shown = Some(why),
        }
        trials.push(trial);
    }
    let sets = combinations(&subjects, &outcome);
    for (place, _) in &subjects {
        let own = sets.iter().filter(|set| set.members.contains(place)).map(|set| set.probability);
        if let Some(trial) = trials.get_mut(*place) {
            // Sums of rounded shares stay probabilities.
            trial.probability = Some(own.fold(0.0, |sum, one| sum + one).min(1.0));
        }
    }
    StatedTrials { trials, sets }
}

/// The candidate of a hypothesis, or why these readings have none.
fn subject(one: &StatedHypothesis, outcome: &mut Settled<'_, '_, '_>) -> Result<Subject, String> {
    let scene = outcome.field.scene;
    let (number, units, variants) = match &one.statement {
        StatedContent::Sum(through, terms) => {
            let Built { candidate, amounts } = of_sum(scene, *through, terms)?;
            (enter(outcome.field, candidate), amounts, 1)
        }
        StatedContent::Shape(name) => {
            let candidate = of_shape(scene, name).ok_or("the axes of the machine have no term of this name")?;
            (enter(outcome.field, candidate), Vec::new(), 1)
        }
        StatedContent::Named(effect, parameter) => {
            let (number, variants) = named(outcome, *effect, parameter)?;
            (number, Vec::new(), variants)
        }
    };
    visible(outcome, number, !units.is_empty(), &units)?;
    let stand_ins = stand_ins(outcome, number);
    Ok(Subject { number, units, variants, stand_ins })
}

fn enter(field: &mut Field<'_, '_>, candidate: Candidate) -> usize {
    field.know(&candidate);
    field.candidates.push(candidate);
    field.candidates.len() - 1
}

/// The best variant of a cause, and the number of variants: an accepted one if there is one, else the one that explains most for its columns.
fn named(outcome: &Settled<'_, '_, '_>, effect: EffectKind, parameter: &str) -> Result<(usize, usize), String> {
    let field = &*outcome.field;
    let is_one = |number: &usize| {
        field.candidates.get(*number).is_some_and(|one| one.cause.effect == effect && one.parameter == parameter)
    };
    let all: Vec<usize> = (0..field.candidates.len()).filter(is_one).collect();
    if all.is_empty() {
        let mut known: Vec<String> = Vec::new();
        for one in field.candidates.iter().filter(|one| one.cause.effect == effect) {
            if !known.contains(&one.parameter) {
                known.push(one.parameter.clone());
            }
        }
        return Err(if known.is_empty() {
            format!("these readings have nothing on which {effect} could depend")
        } else {
            format!("{effect} has no parameter {parameter} here, only {}", known.join(", "))
        });
    }
    if let Some((taken, _)) = outcome.kept.iter().find(|(taken, _)| all.contains(&taken.candidate)) {
        return Ok((taken.candidate, all.len()));
    }
    let series = field.series(outcome.weights, &[], 0.0);
    let count = (series.count() as f64).max(2.0);
    // By the criterion of Schwarz (1978).
    let worth = |number: usize| {
        let gain = series.gain(&field.columns_of(number));
        let rest = (series.squares() - gain.squares).max(f64::MIN_POSITIVE);
        -count * rest.ln() - gain.rank as f64 * count.ln()
    };
    let mut order: Vec<(f64, usize)> = all.iter().map(|&number| (worth(number), number)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    order.truncate(VARIANTS);
    let some: Vec<usize> = order.iter().map(|(_, number)| *number).collect();
    let groups: Vec<_> =
        some.iter().filter_map(|&number| field.candidates.get(number)).map(|one| group(field, one)).collect();
    let sets: Vec<Vec<usize>> = (0..groups.len()).map(|k| vec![k]).collect();
    let found = evidences(field.scene, &outcome.weights.items, &groups, &sets);
    let best = some.iter().zip(found).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(number, _)| *number);
    best.map(|number| (number, all.len())).ok_or_else(|| format!("{effect} {parameter} has no form here"))
}

/// Checks that the readings can show a candidate.
///
/// # Errors
/// Why they cannot.
fn visible(outcome: &Settled<'_, '_, '_>, number: usize, has_terms: bool, units: &[AmountUnit]) -> Result<(), String> {
    let field = &*outcome.field;
    let Some(one) = field.candidates.get(number) else { return Err("there is no candidate".into()) };
    let weights = outcome.weights;
    let columns = field.columns_of(number);
    let squares =
        |column: &[f64]| column.iter().zip(&weights.items).map(|(value, weight)| (value * weight).powi(2)).sum::<f64>();
    let still = still(outcome, one);
    let because = if still.is_empty() { String::new() } else { format!(": {}", still.join(" and ")) };
    if columns.iter().all(|column| squares(column) == 0.0) {
        let has_effect = one
            .columns
            .iter()
            .flatten()
            .any(|(through, _)| field.factors.get(through).is_some_and(|factors| squares(factors) > 0.0));
        return Err(match (has_effect, one.columns.first().and_then(|parts| parts.first())) {
            (true, _) => format!("its drivers have no value, or stay at zero, in these readings{because}"),
            (false, Some((Through::Component(name), _))) => format!("no reading responds to {name}"),
            (false, _) => "no reading responds to it".into(),
        });
    }
    let mut series = field.series(weights, &[], 0.0);
    let mut of_setups = Vec::new();
    for column in &columns {
        series.set_values(column);
        of_setups.push(series.squares());
    }
    if columns.iter().zip(&of_setups).all(|(column, rest)| *rest <= OWN * squares(column)) {
        return Err(format!("the unknowns of the set-ups absorb it completely{because}"));
    }
    if has_terms {
        let mut beside = field.series(weights, &[], 0.0);
        for (place, column) in columns.iter().enumerate() {
            if !beside.take(column) {
                let own = units.iter().rev().find(|unit| unit.column <= place).map_or("", |unit| unit.term.as_str());
                return Err(format!(
                    "the readings cannot separate {own} from the other terms and the unknowns of the set-ups{because}"
                ));
            }
        }
    }
    let group = group(field, one);
    let is_faint = of_setups.iter().zip(&group.sizes).all(|(rest, size)| rest.sqrt() * size < FAINT);
    if is_faint {
        return Err(
            "of its usual size it would change all readings together by less than a third of their noise".into()
        );
    }
    Ok(())
}

/// Drivers that stay where they are, in words.
fn still(outcome: &Settled<'_, '_, '_>, one: &Candidate) -> Vec<String> {
    let scene = outcome.field.scene;
    let is_used = |row: usize| scene.rows.get(row).is_some_and(|row| row.set < outcome.used);
    let of = |name: &String| {
        let found = driver(scene, name)?;
        let values = found.values.iter().enumerate().filter(|(row, value)| is_used(*row) && value.is_finite());
        let (low, high) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, value)| (low.min(*value), high.max(*value)));
        let unit = if found.unit.is_empty() { String::new() } else { format!(" {}", found.unit) };
        (high >= low && high - low <= 1e-9 * high.abs().max(low.abs())).then(|| format!("{name} stays at {low}{unit}"))
    };
    one.drivers.iter().filter_map(of).collect()
}

/// Places among the accepted candidates that have the effect of a hypothesis on the readings.
fn stand_ins(outcome: &Settled<'_, '_, '_>, number: usize) -> Vec<usize> {
    let field = &*outcome.field;
    let columns = field.columns_of(number);
    let (amounts, _) = field.series(outcome.weights, &[], 0.0).amounts(&columns);
    let mut effect = vec![0.0; field.scene.items.len()];
    for (column, amount) in columns.iter().zip(&amounts) {
        effect.iter_mut().zip(column).for_each(|(sum, value)| *sum += amount * value);
    }
    let mut series = field.series(outcome.weights, &[], 0.0);
    // The whole, and each term: one that a finding absorbs would get no amount beside it.
    let parts: Vec<&Vec<f64>> = std::iter::once(&effect).chain(&columns).collect();
    let mut absorbs = |taken: &Taken| {
        let own = field.columns_of(taken.candidate);
        parts.iter().any(|part| {
            series.set_values(part);
            series.gain(&own).squares > STANDS * series.squares()
        })
    };
    let kept = outcome.kept.iter().enumerate();
    kept.filter(|(_, (taken, _))| taken.candidate == number || absorbs(taken)).map(|(place, _)| place).collect()
}

/// Velocity of an axis by row, mm/s; `None` if the driver is no velocity.
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
    subject: &Subject,
    outcome: &Settled<'_, '_, '_>,
    note: &mut dyn FnMut(&str, f64),
) {
    let field = &*outcome.field;
    let (scene, weights) = (field.scene, outcome.weights);
    let Some(one) = field.candidates.get(subject.number) else { return };
    let named = |number: usize| field.candidates.get(number).map_or_else(String::new, name_of);
    let is_beside = |place: &usize| !subject.stand_ins.contains(place);
    let kept = || outcome.kept.iter().enumerate();
    let others: Vec<(Taken, f64)> = kept().filter(|(place, _)| is_beside(place)).map(|(_, one)| one.clone()).collect();
    let beside: Vec<usize> = others.iter().map(|(taken, _)| taken.candidate).collect();
    let replaced: Vec<usize> =
        kept().filter(|(place, _)| !is_beside(place)).map(|(_, (taken, _))| taken.candidate).collect();
    trial.name = name_of(one);
    trial.variants = subject.variants;
    trial.beside = beside.iter().map(|&number| named(number)).collect();
    trial.stands_for = replaced.iter().map(|&number| named(number)).collect();
    trial.drivers = one.drivers.iter().filter_map(|name| driver(scene, name).or_else(|| speed(scene, name))).collect();
    let with: Vec<usize> = beside.iter().copied().chain([subject.number]).collect();
    // Who explains as much in its place.
    let memory = field.memory(weights, &with);
    let whole = field.series(weights, &with, memory);
    let freedom = (whole.count() - whole.rank().min(whole.count())).max(1) as f64;
    let noise = whole.squares() / freedom * field.inflation(weights, &with, &beside, subject.number);
    let mut rivals: Vec<usize> = Vec::new();
    for rival in class(field, weights, (subject.number, &beside), memory, noise).into_iter().skip(1) {
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
    let key = |one: &Candidate| one.columns.first().and_then(|parts| parts.first()).map(|(_, weight)| weight.key());
    if let Some(accepted) = found.findings.iter().find(|own| key(&own.candidate) == key(one)) {
        trial.rms = accepted.rms;
        trial.alone = accepted.alone;
        trial.amounts = amounts(trial, subject, accepted);
        trial.separate_by = accepted.separate_by.clone().filter(|_| !trial.rivals.is_empty());
        let changes = if trial.evidence_beside > 0.0 {
            extend::of_one(accepted, found.used.before.rms, (scene, outcome.used))
        } else {
            Err("the readings speak against it".to_owned())
        };
        trial.correctable = match (&changes, one.cause.correctable) {
            (Err(_), _) => Correctable::No,
            (Ok(_), Correctable::No) => Correctable::Program,
            (Ok(_), own) => own,
        };
        trial.changes = Some(changes);
    }
    (trial.without, trial.with) = both(|| left_of(field, weights, &beside), || left_of(field, weights, &with));
}

/// Evidence alone, beside the findings, and of rivals in its place.
fn evidence(
    trial: &mut HypothesisTrial,
    subject: &Subject,
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
    let instead = others.iter().copied().chain(first..first + replaced.len()).collect();
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
        // In the place of what is not there anything is as good.
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

/// Gain on the data held out, else on parts that are left out in turn.
fn gain(
    trial: &mut HypothesisTrial,
    subject: &Subject,
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

/// Amounts of the terms; of a named cause its size.
fn amounts(trial: &HypothesisTrial, subject: &Subject, accepted: &AcceptedCause) -> Vec<TermAmount> {
    if subject.units.is_empty() {
        let size = &accepted.size;
        let (term, unit) = (trial.name.clone(), size.unit.to_owned());
        return vec![TermAmount { term, value: size.value, u95: size.u95, unit }];
    }
    // Parts that were left out may say that an amount is less sure.
    let inflation = match (accepted.size.value.abs(), accepted.amounts.values.as_slice()) {
        (value, [amount]) if value > 0.0 && *amount != 0.0 => {
            let relative = accepted.size.u95 / value;
            let own = accepted.amounts.u95(0) / amount.abs();
            if own > 0.0 && relative.is_finite() { (relative / own).max(1.0) } else { 1.0 }
        }
        _ => 1.0,
    };
    subject.units.iter().map(|unit| amount(unit, &accepted.amounts, inflation)).collect()
}

fn amount(unit: &AmountUnit, amounts: &Amounts, inflation: f64) -> TermAmount {
    let count = amounts.values.len();
    let at = |k: usize| amounts.values.get(k).copied().unwrap_or(0.0);
    let mut along = vec![0.0; count];
    let parts: Vec<usize> = if unit.is_wave { vec![unit.column, unit.column + 1] } else { vec![unit.column] };
    let length = parts.iter().map(|&k| at(k) * at(k)).sum::<f64>().sqrt();
    for &k in &parts {
        if let Some(one) = along.get_mut(k) {
            *one = if unit.is_wave && length > 0.0 { at(k) / length } else { 1.0 };
        }
    }
    let (value, sigma) = amounts.form(&along);
    TermAmount {
        term: unit.term.clone(),
        value: unit.factor * value,
        u95: inflation * EXPANDED * unit.factor.abs() * sigma,
        unit: unit.unit.clone(),
    }
}

/// Probabilities of combinations of visible hypotheses beside the findings that stand for none of them, with even odds of each.
fn combinations(subjects: &[(usize, Subject)], outcome: &Settled<'_, '_, '_>) -> Vec<StatedSet> {
    if subjects.is_empty() {
        return Vec::new();
    }
    let field = &*outcome.field;
    let is_base = |place: &usize| subjects.iter().all(|(_, subject)| !subject.stand_ins.contains(place));
    let base: Vec<usize> = outcome
        .kept
        .iter()
        .enumerate()
        .filter(|(place, _)| is_base(place))
        .map(|(_, (taken, _))| taken.candidate)
        .collect();
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
