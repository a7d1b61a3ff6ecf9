//! Selection of parameters: steps, terms with their equivalents, gain on left-out readings.

use std::fmt::Write as _;

use super::correction::push_row;
use super::number::significant;
use ncfix_metrology::results::selection::{HoldoutGain, Selection};

/// Maximum number of names in a list.
const MOST_NAMES: usize = 8;

fn shown(gain: &HoldoutGain) -> String {
    format!("{:.1} ± {:.1} %", gain.gain * 100.0, gain.error * 100.0)
}

fn p_value(p: f64) -> String {
    if p < 1e-3 { format!("{p:.0e}") } else { significant(p) }
}

fn listed(names: &[String]) -> String {
    let shown = names.get(..MOST_NAMES.min(names.len())).unwrap_or_default().join(", ");
    let more = names.len().saturating_sub(MOST_NAMES);
    if more > 0 { format!("{shown} and {more} more") } else { shown }
}

/// Returns the tables for people, with a line feed after every line.
#[must_use]
pub fn table(found: &Selection) -> String {
    let mut out = String::new();
    // Writing into a String cannot fail.
    if !found.steps.is_empty() {
        let _ = writeln!(
            out,
            "{:<17}{:<12}{:<12}{:>10}{:>10}{:>10}{:>12}",
            "step", "parameter", "instead of", "t", "d.o.f.", "p", "autocorr."
        );
    }
    for step in &found.steps {
        let [t, freedom, correlation] = [step.t, step.freedom, step.correlation].map(significant);
        let (change, name, p) = (step.change.words(), &step.name, p_value(step.p));
        let instead = step.instead_of.as_deref().unwrap_or_default();
        let _ = writeln!(out, "{change:<17}{name:<12}{instead:<12}{t:>10}{freedom:>10}{p:>10}{correlation:>12}");
    }
    if !found.terms.is_empty() {
        let _ = writeln!(
            out,
            "\n{:<13}{:>10}{:>10}{:>10}  {:<18}not separable from",
            "chosen", "t", "d.o.f.", "p", "left-out gain"
        );
    }
    for term in &found.terms {
        let [t, freedom] = [term.t, term.freedom].map(significant);
        let (name, p, gain, rivals) = (&term.name, p_value(term.p), shown(&term.held_out), listed(&term.rivals));
        let line = format!("{name:<13}{t:>10}{freedom:>10}{p:>10}  {gain:<18}{rivals}");
        let _ = writeln!(out, "{}", line.trim_end());
    }
    if !out.is_empty() {
        out.push('\n');
    }
    let significance = found.significance * 100.0;
    let count = found.terms.len();
    push_row(
        &mut out,
        "candidates",
        &format!("{} tested, {count} chosen at {significant} %", found.tried, significant = significant(significance)),
    );
    if !found.not_identified.is_empty() {
        push_row(&mut out, "undetermined", &listed(&found.not_identified));
    }
    if let Some(gain) = &found.held_out {
        let [before, after] = [gain.before, gain.after].map(significant);
        push_row(
            &mut out,
            "left out",
            &format!(
                "residual of left-out readings {before} σ without terms, {after} σ with them, gain {}",
                shown(gain)
            ),
        );
    }
    for one in &found.correlation {
        push_row(&mut out, "residuals", &format!("autocorrelation {:.2} ({})", one.correlation, one.name));
    }
    if !found.is_settled {
        push_row(&mut out, "unsettled", &format!("the selection still changed in pass {}", found.passes));
    }
    out.push('\n');
    out
}
