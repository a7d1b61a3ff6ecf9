//! How parameters were chosen: steps, terms with what could stand for them, held-out gain.

use std::fmt::Write as _;

use serde::Serialize;

use super::correction::push_row;
use super::number::significant;

/// Names of a list at most.
const MOST_NAMES: usize = 8;

/// The choice among candidates.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Selection {
    /// Candidates that the data tells, and that were tried.
    pub tried: usize,
    /// Chance to accept anything where there is nothing.
    pub significance: f64,
    /// Candidates that the data tells nothing of, or nothing beside what is always in.
    pub not_told: Vec<String>,
    /// Steps of the last choice.
    pub steps: Vec<Step>,
    /// What was chosen.
    pub terms: Vec<Term>,
    /// Correlation of neighbouring readings, by measurement.
    pub correlation: Vec<Correlation>,
    /// What all terms help with readings that were held out, the choice repeated in every fold; `null` where nothing was chosen.
    pub held_out: Option<Gain>,
    /// Choices and fits in turn.
    pub passes: usize,
    /// Whether the last choice was that before it.
    pub is_settled: bool,
}

/// A step.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Step {
    /// What happened: `in`, `out`, `not significant`, `no gain`.
    pub change: &'static str,
    /// The candidate.
    pub name: String,
    /// The candidate whose place it took.
    pub instead_of: Option<String>,
    /// Its t value; F is its square.
    pub t: f64,
    /// Effective degrees of freedom.
    pub freedom: f64,
    /// Chance, times the number of candidates.
    pub p: f64,
    /// Correlation of neighbours that was assumed.
    pub correlation: f64,
}

/// What was chosen.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Term {
    /// The parameter.
    pub name: String,
    /// Its t value.
    pub t: f64,
    /// Effective degrees of freedom.
    pub freedom: f64,
    /// Chance, times the number of candidates.
    pub p: f64,
    /// What it helps with readings that were held out, beside the other terms.
    pub held_out: Gain,
    /// Candidates that the data cannot tell from it.
    pub rivals: Vec<String>,
}

/// What is left of readings that were held out, in units of their uncertainty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Gain {
    /// Root of the mean square without.
    pub before: f64,
    /// And with.
    pub after: f64,
    /// The share of the squares by which it falls.
    pub gain: f64,
    /// Its standard error, over blocks.
    pub error: f64,
}

/// The correlation of neighbouring readings.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Correlation {
    /// The measurement; angles of one that has lengths too are separate.
    pub name: String,
    /// The correlation.
    pub correlation: f64,
}

impl Gain {
    fn shown(&self) -> String {
        format!("{:.1} ± {:.1} %", self.gain * 100.0, self.error * 100.0)
    }
}

fn chance(p: f64) -> String {
    if p < 1e-3 { format!("{p:.0e}") } else { significant(p) }
}

fn listed(names: &[String]) -> String {
    let shown = names.get(..MOST_NAMES.min(names.len())).unwrap_or_default().join(", ");
    let more = names.len().saturating_sub(MOST_NAMES);
    if more > 0 { format!("{shown} and {more} more") } else { shown }
}

impl Selection {
    /// The tables for people, with a line feed behind every line.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        // Writing into a String cannot fail.
        if !self.steps.is_empty() {
            let _ = writeln!(
                out,
                "{:<17}{:<12}{:<12}{:>10}{:>10}{:>10}{:>12}",
                "step", "parameter", "instead of", "t", "freedom", "p", "neighbours"
            );
        }
        for step in &self.steps {
            let [t, freedom, correlation] = [step.t, step.freedom, step.correlation].map(significant);
            let (change, name, p) = (step.change, &step.name, chance(step.p));
            let instead = step.instead_of.as_deref().unwrap_or_default();
            let _ = writeln!(out, "{change:<17}{name:<12}{instead:<12}{t:>10}{freedom:>10}{p:>10}{correlation:>12}");
        }
        if !self.terms.is_empty() {
            let _ = writeln!(
                out,
                "\n{:<13}{:>10}{:>10}{:>10}  {:<18}not told from",
                "chosen", "t", "freedom", "p", "held-out gain"
            );
        }
        for term in &self.terms {
            let [t, freedom] = [term.t, term.freedom].map(significant);
            let (name, p, gain, rivals) = (&term.name, chance(term.p), term.held_out.shown(), listed(&term.rivals));
            let line = format!("{name:<13}{t:>10}{freedom:>10}{p:>10}  {gain:<18}{rivals}");
            let _ = writeln!(out, "{}", line.trim_end());
        }
        if !out.is_empty() {
            out.push('\n');
        }
        let significance = self.significance * 100.0;
        let count = self.terms.len();
        push_row(
            &mut out,
            "candidates",
            &format!(
                "{} tried, {count} chosen at {significant} %",
                self.tried,
                significant = significant(significance)
            ),
        );
        if !self.not_told.is_empty() {
            push_row(&mut out, "not told", &listed(&self.not_told));
        }
        if let Some(gain) = &self.held_out {
            let [before, after] = [gain.before, gain.after].map(significant);
            push_row(
                &mut out,
                "held out",
                &format!("{before} σ without terms, {after} σ with them, gain {}", gain.shown()),
            );
        }
        for one in &self.correlation {
            push_row(&mut out, "neighbours", &format!("correlation {:.2} ({})", one.correlation, one.name));
        }
        if !self.is_settled {
            push_row(&mut out, "unsettled", &format!("the choice still changed in pass {}", self.passes));
        }
        out.push('\n');
        out
    }
}
