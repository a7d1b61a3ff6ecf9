//! Decomposition of a trace at several feeds: the JSON object and its text for people; its page is in [`super::page::decomposition`].

use std::fmt::Write as _;

use serde::Serialize;

use super::inputs::InputFile;
use super::json::DiagnosticReport;
use super::number::{grouped, significant};
use ncfix_metrology::decompose::DETERMINED_EXPONENT;
use ncfix_metrology::results::decomposition::{
    ComplianceReport, DecompositionResult, Delay, DynamicAccuracy, Law, LinkReport, Loop, RunReport,
};

/// Output of `ncfix decompose`: the result, with its output files.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DecompositionReport {
    /// Result.
    #[serde(flatten)]
    pub found: DecompositionResult,
    /// Machine file that was written.
    pub output: Option<String>,
    /// Report page that was written.
    pub report: Option<String>,
    /// Diagnostics.
    pub diagnostics: Vec<DiagnosticReport>,
    /// Files from which the result was computed.
    #[serde(skip)]
    pub inputs: Vec<InputFile>,
}

impl DecompositionReport {
    /// Returns the verdict in one sentence.
    #[must_use]
    pub fn verdict(&self) -> String {
        let Some(fast) = self.found.runs.last() else { return "Nothing was decomposed.".into() };
        let feed = fast.feed_mm_min.map_or_else(String::new, |feed| format!(" at {} mm/min", grouped(feed as u64)));
        if !self.found.is_measured() {
            return format!(
                "The servo loops cause up to {} µm{feed}; without an instrument nothing else can be determined.",
                significant(norm(fast.max_um.contouring))
            );
        }
        let shares = fast.share_percent.list().into_iter().zip(fast.share_95_percent.list());
        let mut parts: Vec<(&str, (f64, f64))> = ncfix_metrology::decompose::SOURCES.into_iter().zip(shares).collect();
        parts.sort_by(|a, b| b.1.0.total_cmp(&a.1.0));
        let shares: Vec<String> =
            parts.iter().take(3).map(|(name, (share, by))| format!("{name} {share:.1} ± {by:.1} %")).collect();
        let named: Vec<&str> = self.found.compliances.iter().map(|one| one.component.as_str()).collect();
        let why = if named.is_empty() { String::new() } else { format!(" Compliance: {}.", named.join(", ")) };
        format!("Of the error{feed}: {}.{why}", shares.join(", "))
    }

    /// Returns the text for people.
    #[must_use]
    pub fn page(&self) -> String {
        let mut out = String::new();
        let _ = writeln!(out, "{}\n", self.verdict());
        self.write_delays(&mut out);
        self.write_runs(&mut out);
        self.write_links(&mut out);
        self.write_compliances(&mut out);
        self.write_laws(&mut out);
        out
    }

    fn write_delays(&self, out: &mut String) {
        let line = |out: &mut String, what: &str, delay: &Delay| {
            let _ = writeln!(out, "{what:<40} {}", delay_cell(delay));
        };
        let _ = writeln!(out, "± is half of the 95 % interval");
        line(out, "encoder delay after set-points (record)", &self.found.record_delay);
        if let Some(delay) = &self.found.reading_delay {
            line(out, "reading delay after encoders", delay);
        }
        let _ = writeln!(
            out,
            "\naxis  {:>20}  {:>18}  {:>16}  residual, RMS",
            "velocity gain, 1/s", "feed-forward", "lag, ms"
        );
        for one in &self.found.servo {
            let [gain, forward, lag] = loop_cells(one);
            let (rms, by) = (significant(one.rms), significant(one.rms_95));
            let sign = one.unit.unit().sign();
            let _ = writeln!(out, "{:<4}  {gain:>20}  {forward:>18}  {lag:>16}  {rms} ± {by} {sign}", one.axis);
        }
        for one in &self.found.servo {
            if let Some(not) = &one.not_determined {
                let _ = writeln!(
                    out,
                    "velocity gain of {} is {NO_NUMBER}: {}; measure {}",
                    one.axis, not.reason, not.measure
                );
            }
        }
    }

    fn write_runs(&self, out: &mut String) {
        if self.found.is_measured() {
            let _ = writeln!(
                out,
                "\nmean share of the norms, %\n   F, mm/min  {:>14}  {:>14}  {:>14}  {:>14}  {:>14}",
                "contouring", "link", "motion", "thermal", "dynamic"
            );
            for run in &self.found.runs {
                out.push_str(&feed_cell(run));
                for (share, by) in run.share_percent.list().into_iter().zip(run.share_95_percent.list()) {
                    let _ = write!(out, "  {:>14}", format!("{share:.1} ± {by:.1}"));
                }
                out.push('\n');
            }
        }
        if let Some(one) = &self.found.dynamic_accuracy {
            let _ = writeln!(out, "\ndynamic accuracy on this path: {}", accuracy_cell(one));
        }
        for (title, is_max) in [("largest", true), ("RMS", false)] {
            let sources: &[(&str, usize)] = if self.found.is_measured() {
                &[("contouring", 0), ("link", 1), ("motion", 2), ("dynamic", 4)]
            } else {
                &[("contouring", 0)]
            };
            let _ = write!(out, "\n{title} along X Y Z, µm\n   F, mm/min");
            for (name, _) in sources {
                let _ = write!(out, "  {name:^20}");
            }
            out.push('\n');
            for run in &self.found.runs {
                let (of, by) = if is_max { (run.max_um, run.max_95_um) } else { (run.rms_um, run.rms_95_um) };
                for (head, of) in [(feed_cell(run), of), (format!("{:>12}", "±"), by)] {
                    out.push_str(&head);
                    for &(_, source) in sources {
                        let [x, y, z] = of.list()[source].map(significant);
                        let _ = write!(out, "  {x:>6} {y:>6} {z:>6}");
                    }
                    out.push('\n');
                }
            }
        }
        let _ = writeln!(
            out,
            "\n   F, mm/min  contouring error at right angles to the path, µm: largest, RMS  thermal X Y Z, µm"
        );
        for run in &self.found.runs {
            let [max, rms] = run.contouring_error_um.map(significant);
            let [x, y, z] = run.thermal_um.map(significant);
            let [x_95, y_95, z_95] = run.thermal_95_um.map(significant);
            let _ = writeln!(
                out,
                "{}  {max:>50}  {rms:>6}     {x:>6} {y:>6} {z:>6} ± {x_95} {y_95} {z_95}",
                feed_cell(run)
            );
        }
    }

    fn write_links(&self, out: &mut String) {
        if self.found.links.is_empty() {
            return;
        }
        let _ = writeln!(out, "\nlink error  beyond the machine file");
        for one in &self.found.links {
            let reason = one.not_determined.as_ref().map_or_else(String::new, |not| format!(": {}", not.reason));
            let _ = writeln!(out, "{:<10}  {}{reason}", one.parameter, link_cell(one));
        }
        if let Some(not) = self.found.links.iter().find_map(|one| one.not_determined.as_ref()) {
            let _ = writeln!(out, "to determine the others, measure {}", not.measure);
        }
    }

    fn write_compliances(&self, out: &mut String) {
        if !self.found.is_measured() {
            return;
        }
        if self.found.compliances.is_empty() {
            let _ = writeln!(out, "\nNo compliance explains the residual at feeds to which it was not fitted.");
            return;
        }
        let _ =
            writeln!(out, "\ncompliance of   with                value                          gain at other feeds");
        for one in &self.found.compliances {
            let with = format!("{} of {}", one.of.words(), one.axis);
            let value = format!("{:.4} ± {:.4} {}", one.value, one.uncertainty_95, compliance_unit(one));
            let _ = writeln!(out, "{:<14}  {with:<18}  {value:<30} {:>5.1} %", one.component, 100.0 * one.gain);
        }
        let _ = writeln!(out, "\n   F, mm/min  dynamic part, RMS µm  residual with the compliances of other feeds");
        for run in &self.found.runs {
            if let Some([before, after]) = run.held_out_um.map(|both| both.map(significant)) {
                let _ = writeln!(out, "{}  {before:>20}  {after:>6}", feed_cell(run));
            }
        }
    }

    fn write_laws(&self, out: &mut String) {
        if self.found.power_laws.is_empty() {
            return;
        }
        let _ = writeln!(
            out,
            "\nRMS = κ Fᴺ   {:>28}  {:>14}     R²  N without the slowest run",
            "κ, µm (95 % interval)", "N"
        );
        for law in &self.found.power_laws {
            let _ = writeln!(
                out,
                "{:<10} {} {:>28}  {:>14}  {:>5.3}  {:>14}",
                law.source.words(),
                law.direction,
                factor_cell(law),
                exponent_cell(law),
                law.explained,
                slowest_cell(law)
            );
        }
        if let Some(not) = self.found.power_laws.iter().find_map(|law| law.not_determined.as_ref()) {
            let _ = writeln!(out, "to determine the others, measure {}", not.measure);
        }
    }
}

/// The words instead of a value that the data do not determine.
const NO_NUMBER: &str = "not determined";

/// The dynamic accuracy with its interval.
pub(super) fn accuracy_cell(one: &DynamicAccuracy) -> String {
    let feed = one.feed_mm_min.map_or_else(String::new, |feed| format!(" at {} mm/min", grouped(feed.round() as u64)));
    format!("{} ± {} µm RMS{feed}", significant(one.rms_um), significant(one.rms_95_um))
}

/// A delay with its interval.
pub(super) fn delay_cell(delay: &Delay) -> String {
    match &delay.not_determined {
        Some(not) => format!("{NO_NUMBER:>9}: {}; measure {}", not.reason, not.measure),
        None if delay.uncertainty_95_ms > 0.0 => format!("{:>9.3} ± {:.3} ms", delay.ms, delay.uncertainty_95_ms),
        None => format!("{:>9.3} (given) ms", delay.ms),
    }
}

/// The exponent of a power law with its interval.
pub(super) fn exponent_cell(law: &Law) -> String {
    if law.is_determined { bounded(law.exponent, law.exponent_95) } else { NO_NUMBER.into() }
}

/// The exponent without the slowest run, with its interval; no number if the interval is wide.
pub(super) fn slowest_cell(law: &Law) -> String {
    match (law.without_slowest, law.without_slowest_95) {
        (Some(exponent), Some(by)) if by < DETERMINED_EXPONENT => bounded(exponent, Some(by)),
        (Some(_), _) => NO_NUMBER.into(),
        (None, _) => "–".into(),
    }
}

/// A link error with its interval; a value that is not determined has no number.
pub(super) fn link_cell(one: &LinkReport) -> String {
    let sign = one.unit.unit().sign();
    if one.is_determined { format!("{:.2} ± {:.2} {sign}", one.value, one.uncertainty_95) } else { NO_NUMBER.into() }
}

/// Velocity gain, feed-forward and lag of a loop with their intervals.
pub(super) fn loop_cells(one: &Loop) -> [String; 3] {
    let gain = match (one.velocity_gain_per_s, one.velocity_gain_95_per_s) {
        (Some(gain), Some(by)) if one.is_determined => format!("{gain:.1} ± {by:.1}"),
        (Some(_), _) => NO_NUMBER.into(),
        (None, _) => "no lag seen".into(),
    };
    let with = |value: f64, by: Option<f64>, digits: usize| {
        by.map_or(NO_NUMBER.into(), |by| format!("{value:.digits$} ± {by:.digits$}"))
    };
    [gain, with(one.feed_forward, one.feed_forward_95, 4), with(one.lag_ms, one.lag_95_ms, 3)]
}

/// The factor of a power law with its interval.
pub(super) fn factor_cell(law: &Law) -> String {
    if !law.is_determined {
        return NO_NUMBER.into();
    }
    let factor = format!("{:.3e}", law.factor_um);
    law.factor_95_um.map_or(factor.clone(), |[low, high]| format!("{factor} ({low:.1e} … {high:.1e})"))
}

/// An exponent with its interval.
fn bounded(exponent: f64, by: Option<f64>) -> String {
    by.map_or_else(|| format!("{exponent:.2}"), |by| format!("{exponent:.2} ± {by:.2}"))
}

/// The unit of a compliance for people: `µm per m/s²`.
pub(super) fn compliance_unit(one: &ComplianceReport) -> String {
    let signs = [("urad_per_", "µrad per "), ("um_per_", "µm per "), ("m_s", "m/s"), ("rad_s", "rad/s")];
    let unit = signs.iter().fold(one.unit.clone(), |unit, (from, to)| unit.replace(from, to));
    unit.replace("s2", "s²").replace("s3", "s³")
}

fn norm([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

fn feed_cell(run: &RunReport) -> String {
    let feed = run.feed_mm_min.map_or("–".into(), |feed| grouped(feed.round() as u64));
    format!("{feed:>12}")
}
