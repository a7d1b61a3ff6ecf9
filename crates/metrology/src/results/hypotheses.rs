//! Stated hypotheses of a diagnosis, in display units.

use serde::Serialize;

use crate::diagnose::Scene;
use crate::diagnose::cause::Correctable;
pub use crate::diagnose::stated::STRONG;
use crate::diagnose::stated::{HypothesisTrial, StatedTrials};
use ncfix_base::source::{FileId, Source};
use ncfix_base::units::UnitKey;

/// The number of the text of hypotheses among the files of a run; files count from zero.
const STATED: FileId = FileId(u16::MAX);

/// The text of hypotheses, one per line; `None` without any.
#[must_use]
pub fn source(stated: &[String]) -> Option<Source> {
    let text = stated.join("\n").into_bytes();
    Source::new(STATED, "--hypothesis", text).ok().filter(|_| !stated.is_empty())
}

/// The result for a stated hypothesis.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct HypothesisReport {
    /// The hypothesis as stated.
    pub text: String,
    /// Effect and parameter, as a finding of this form is named; empty if the data cannot show it.
    pub name: String,
    /// The answer.
    pub answer: HypothesisAnswer,
    /// Reason why the data cannot show it; `null` if they can.
    pub why_not_shown: Option<String>,
    /// Amount of each term.
    pub amounts: Vec<HypothesisAmount>,
    /// RMS of its effect on the readings.
    pub rms_um: f64,
    /// Range of its effect on the readings of a set-up: largest minus smallest.
    pub alone_um: f64,
    /// Natural logarithm of the evidence for it without any finding: positive for it, negative against it; `null` if the data cannot show it.
    pub log_evidence: Option<f64>,
    /// Natural logarithm of the evidence in addition to the findings in `beside`.
    pub log_evidence_beside: Option<f64>,
    /// Findings that were included in the test.
    pub beside: Vec<String>,
    /// Findings that have the same effect on the readings, and that it replaced in the test.
    pub stands_for: Vec<String>,
    /// Natural logarithm of the evidence of all these findings together in its place, minus its own: positive if they explain the readings better;
    /// `null` without such findings.
    pub log_evidence_of_findings: Option<f64>,
    /// Relative reduction of the RMS of left-out readings, in addition to the findings in `beside`; `null` if no part could decide.
    pub gain_unseen: Option<f64>,
    /// True if this is the gain on held-out data, false if it is that on left-out readings.
    pub gain_is_held_out: bool,
    /// Other explanations that are nearly as good, the best first.
    pub rivals: Vec<HypothesisRival>,
    /// The measurement that separates it from the first other explanation.
    pub separate_by: Option<String>,
    /// Possible correction.
    pub correctable: Correctable,
    /// Reason why the machine file cannot hold it, or must not; `null` if it can.
    pub extends_why: Option<String>,
    /// Probability over all combinations of the stated hypotheses, with equal prior odds; `null` if the data cannot show it.
    pub probability: Option<f64>,
    /// Number of variants of a named cause from which the best is shown.
    pub variants: usize,
    /// Columns on which it depends.
    pub drivers: Vec<String>,
    /// The words that distinguish the shown variant from the others; `null` for a single one.
    pub variant: Option<String>,
    /// For a supported hypothesis that the machine file can hold: the command that fits and writes it together with the causes beside it; otherwise `null`.
    pub next: Option<String>,
}

/// The answer to a hypothesis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum HypothesisAnswer {
    /// The data cannot show it.
    #[default]
    NotShown,
    /// At least 20 times as probable with it.
    Supported,
    /// At least 20 times as probable with it, but the findings with its effect are 20 times as probable in its place.
    Outdone,
    /// Neither; or its only amount is smaller than its uncertainty; or those of a sum are, and left-out readings do not confirm it.
    Undecided,
    /// At least 20 times as probable without it.
    Refuted,
}

/// The amount of a term.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HypothesisAmount {
    /// The term as stated.
    pub term: String,
    /// Its amount.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Expanded uncertainty (95 %).
    pub u95: f64,
}

/// Another explanation instead of a hypothesis.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HypothesisRival {
    /// Effect and parameter.
    pub name: String,
    /// Natural logarithm of its evidence, minus that of the hypothesis: positive if it explains the readings better.
    pub log_evidence: f64,
}

/// A combination of stated hypotheses.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HypothesisSet {
    /// Hypotheses that hold; empty if none holds.
    pub hypotheses: Vec<String>,
    /// Probability among all combinations, with equal prior odds.
    pub probability: f64,
}

/// Combinations less probable than this are not listed.
const LISTED: f64 = 1e-3;

/// The results of all trials; `micro` is the factor from mm or rad to the unit of readings.
pub(super) fn reports(trials: &StatedTrials, scene: &Scene<'_>) -> (Vec<HypothesisReport>, Vec<HypothesisSet>) {
    let micro = UnitKey::of(crate::diagnose::reads_angles(scene)).unit().shown(1.0);
    let texts = |members: &[usize]| {
        members.iter().filter_map(|&place| trials.trials.get(place)).map(|one| one.text.clone()).collect()
    };
    let sets = trials.sets.iter().filter(|set| set.probability >= LISTED);
    (
        trials.trials.iter().map(|one| report(one, micro)).collect(),
        sets.map(|set| HypothesisSet { hypotheses: texts(&set.members), probability: set.probability }).collect(),
    )
}

fn report(one: &HypothesisTrial, micro: f64) -> HypothesisReport {
    let is_shown = one.why_not_shown.is_none();
    let answer = match one.evidence_beside {
        _ if !is_shown => HypothesisAnswer::NotShown,
        evidence if evidence >= STRONG && one.evidence_of_findings.is_some_and(|better| better >= STRONG) => {
            HypothesisAnswer::Outdone
        }
        evidence if evidence >= STRONG && one.is_seen() => HypothesisAnswer::Supported,
        evidence if evidence <= -STRONG => HypothesisAnswer::Refuted,
        _ => HypothesisAnswer::Undecided,
    };
    let amount = |amount: &crate::diagnose::stated::TermAmount| HypothesisAmount {
        term: amount.term.clone(),
        value: amount.value,
        unit: amount.unit.clone(),
        u95: amount.u95,
    };
    HypothesisReport {
        text: one.text.clone(),
        name: one.name.clone(),
        answer,
        why_not_shown: one.why_not_shown.clone(),
        amounts: one.amounts.iter().map(amount).collect(),
        rms_um: micro * one.rms,
        alone_um: micro * one.alone,
        log_evidence: is_shown.then_some(one.evidence_alone),
        log_evidence_beside: is_shown.then_some(one.evidence_beside),
        beside: one.beside.clone(),
        stands_for: one.stands_for.clone(),
        log_evidence_of_findings: one.evidence_of_findings,
        gain_unseen: one.gain,
        gain_is_held_out: one.is_held_out,
        rivals: one
            .rivals
            .iter()
            .map(|rival| HypothesisRival { name: rival.name.clone(), log_evidence: rival.log_evidence })
            .collect(),
        separate_by: one.separate_by.clone(),
        correctable: one.correctable,
        extends_why: one.changes.as_ref().and_then(|changes| changes.as_ref().err().cloned()),
        probability: one.probability,
        variants: one.variants,
        drivers: one.drivers.iter().map(|driver| driver.name.clone()).collect(),
        variant: one.variant.clone(),
        next: (answer == HypothesisAnswer::Supported && one.is_storable).then(|| {
            let model: Vec<&str> =
                one.beside_parameters.iter().map(String::as_str).chain([one.text.as_str()]).collect();
            format!("ncfix calibrate DATA --machine M.toml --model \"{}\" -o NEW.toml", model.join(","))
        }),
    }
}
