//! Answers to stated hypotheses, for people.

use std::fmt::Write as _;

use super::DiagnosisReport;
use super::text::{plus_minus, sign};
use crate::number::significant;
use ncfix_metrology::diagnose::cause::Correctable;
use ncfix_metrology::results::hypotheses::{
    HypothesisAmount, HypothesisAnswer, HypothesisReport, HypothesisSet, STRONG,
};

/// Factors from this on are shown as a power of ten.
const MOST_TIMES: f64 = 1e4;
/// Factors below 1.05 do not count as a difference, as a natural logarithm.
const EQUALLY: f64 = 0.05;
/// Maximum number of other explanations and of combinations that are named.
const RIVALS: usize = 4;
const SETS: usize = 3;

impl DiagnosisReport {
    /// Returns the answers to all hypotheses, each with its reasons; empty if none was stated.
    // Writing into a String cannot fail.
    pub(super) fn hypotheses(&self) -> String {
        let mut out = String::new();
        for one in &self.found.hypotheses {
            let _ = writeln!(out, "Hypothesis {}: {}.", one.text, answer_in_words(one));
            for line in self.reasons(one) {
                let _ = writeln!(out, "   {line}");
            }
        }
        if self.found.hypotheses.len() > 1 {
            let _ = writeln!(out, "{}", together(&self.found.hypotheses_together));
        }
        if !out.is_empty() {
            out.push('\n');
        }
        out
    }

    /// Returns the lines after the answer.
    fn reasons(&self, one: &HypothesisReport) -> Vec<String> {
        let (Some(alone), Some(beside)) = (one.log_evidence, one.log_evidence_beside) else { return Vec::new() };
        let mut out: Vec<String> =
            one.amounts.iter().map(|amount| format!("{}: {} (95 %)", amount.term, in_words(amount))).collect();
        let of_findings = if one.beside.is_empty() {
            String::new()
        } else {
            format!("; together with {}: {}", one.beside.join(", "), times_in_words(beside))
        };
        out.push(format!("alone: {}{of_findings}", times_in_words(alone)));
        if !one.stands_for.is_empty() {
            let names = one.stands_for.join(" and ");
            let instead = one
                .log_evidence_of_findings
                .map_or_else(String::new, |evidence| format!("; {names} instead of it: {}", rather(evidence)));
            out.push(format!("left out for this test: {names}, because both explain the same readings{instead}"));
        }
        let unseen = if one.gain_is_held_out { "the held-out data" } else { "left-out readings" };
        let gain = match one.gain_unseen {
            Some(gain) if gain >= 0.0 => format!("{:.0} % smaller residual on {unseen}", 100.0 * gain),
            Some(gain) => format!("{:.0} % larger residual on {unseen}", -100.0 * gain),
            None => "the left-out readings cannot show whether it improves the prediction".into(),
        };
        out.push(format!("{gain}; effect on the readings {} {} RMS", significant(one.rms_um), self.unit_sign()));
        if one.variants > 1 {
            let own = one.variant.as_ref().map_or_else(String::new, |own| format!(": {own}"));
            out.push(format!("the best of {} variants of this cause{own}", one.variants));
        }
        let rivals: Vec<String> = one
            .rivals
            .iter()
            .take(RIVALS)
            .map(|rival| format!("{} ({})", rival.name, rather(rival.log_evidence)))
            .collect();
        if !rivals.is_empty() {
            out.push(format!("other explanations: {}", rivals.join(", ")));
        }
        let is_said = |how: &&String| one.extends_why.as_ref().is_some_and(|why| why.contains(how.as_str()));
        if let Some(how) = one.separate_by.as_ref().filter(|how| !is_said(how)) {
            out.push(format!("to separate them: {how}"));
        }
        out.push(match (&one.extends_why, one.correctable) {
            (Some(why), _) => format!("not corrected: {why}"),
            (None, Correctable::Live) => "only live readings can remove it".into(),
            (None, Correctable::Program) => "a corrected program can remove it".into(),
            (None, Correctable::No) => "no program can remove it".into(),
        });
        out.extend(one.next.as_ref().map(|command| format!("next: {command}")));
        out
    }
}

/// Returns the answer in a few words.
#[must_use]
pub(crate) fn answer_in_words(one: &HypothesisReport) -> String {
    let times = one.log_evidence_beside.map_or_else(String::new, times_in_words);
    match one.answer {
        HypothesisAnswer::NotShown => {
            let why = one.why_not_shown.as_deref().unwrap_or("the readings do not respond to it");
            format!("these data cannot show it: {why}")
        }
        HypothesisAnswer::Supported => format!("supported, the readings are {times}"),
        HypothesisAnswer::Outdone => {
            let others = one.stands_for.join(" and ");
            let better = one.log_evidence_of_findings.unwrap_or_default();
            format!("supported, but with {others} instead, the readings are {} times as probable", factor(better))
        }
        HypothesisAnswer::Undecided if one.log_evidence_beside.is_some_and(|evidence| evidence >= STRONG) => {
            match one.amounts.as_slice() {
                [amount] => format!(
                    "undecided: the readings are {times}, but its amount {} is smaller than its uncertainty, so these data do not determine it",
                    in_words(amount)
                ),
                _ => format!(
                    "undecided: the readings are {times}, but its amounts are smaller than their uncertainties, and left-out readings do not confirm it"
                ),
            }
        }
        HypothesisAnswer::Undecided => format!("undecided, the readings are {times}"),
        HypothesisAnswer::Refuted => format!("refuted, the readings are {times}"),
    }
}

/// Returns an amount with its uncertainty and unit.
#[must_use]
pub(crate) fn in_words(amount: &HypothesisAmount) -> String {
    let unit = (2..=9)
        .zip(["²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"])
        .fold(sign(&amount.unit), |unit, (power, raised)| unit.replace(&format!("^{power}"), raised));
    plus_minus(amount.value, amount.u95, &unit)
}

/// Returns an evidence, a natural logarithm, as a factor.
#[must_use]
pub(crate) fn times_in_words(evidence: f64) -> String {
    let which = if evidence < 0.0 { "without" } else { "with" };
    format!("{} times as probable {which} it", factor(evidence.abs()))
}

/// Returns the factor by which another explanation is better or worse.
fn rather(evidence: f64) -> String {
    if evidence.abs() < EQUALLY {
        return "equally probable".into();
    }
    let which = if evidence < 0.0 { "less" } else { "more" };
    format!("{which} probable by a factor of {}", factor(evidence.abs()))
}

fn factor(evidence: f64) -> String {
    let times = evidence.exp();
    if times < MOST_TIMES { significant(times) } else { format!("10^{:.0}", evidence / std::f64::consts::LN_10) }
}

fn together(sets: &[HypothesisSet]) -> String {
    let one = |set: &HypothesisSet| {
        let name = if set.hypotheses.is_empty() { "none of them".to_owned() } else { set.hypotheses.join(" and ") };
        format!("{name} {:.1} %", 100.0 * set.probability)
    };
    let all: Vec<String> = sets.iter().take(SETS).map(one).collect();
    if all.is_empty() {
        return "These data can test none of these hypotheses.".into();
    }
    format!("Comparison with equal prior odds: {}.", all.join("; "))
}
