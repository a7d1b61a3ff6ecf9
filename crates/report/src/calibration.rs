//! Result of a calibration: tables for people and the JSON object.

use std::fmt::Write as _;

use serde::Serialize;

use super::component::spelled_out;
use super::correction::{output_name, push_row};
use super::figures;
use super::inputs::InputFile;
use super::json::DiagnosticReport;
use super::number::significant;
use super::selection;
use ncfix_metrology::results::calibration::{CalibrationResult, EstimateReport, MeanLineReport};

/// Maximum number of outlier rows that are listed.
const MOST_SHOWN: usize = 20;

/// Output of `ncfix calibrate`: the result, with its input and output files.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CalibrationReport {
    /// Result.
    #[serde(flatten)]
    pub found: CalibrationResult,
    /// Machine file that was written; `null` if there is none.
    pub output: Option<String>,
    /// Row with the command to type next; empty without a file.
    #[serde(skip)]
    pub next: String,
    /// Report page that was written; `null` if there is none.
    pub report: Option<String>,
    /// Files from which the result was computed.
    pub inputs: Vec<InputFile>,
    /// Version of the program.
    pub version: &'static str,
    /// Diagnostics in order of occurrence.
    pub diagnostics: Vec<DiagnosticReport>,
}

/// Width of a name column; a longer name shifts its line.
const WIDEST_NAME: usize = 60;

/// Returns value, uncertainty, effect and inflation of a number as text. The value has as many decimals as the uncertainty, as ball positions are large
/// numbers.
#[must_use]
pub fn cells(one: &EstimateReport) -> [String; 4] {
    let effect = one.effect_um.map_or(String::new(), significant);
    // The readings do not determine it: its value is only where the fit began.
    if !one.sigma.is_finite() {
        return ["-".into(), "unknown".into(), effect, "-".into()];
    }
    let sigma = significant(one.sigma);
    // A slope that follows from the curve is shown by no reading.
    let inflation = if one.inflation.is_finite() { significant(one.inflation) } else { "-".into() };
    let decimals = sigma.split_once('.').map_or(0, |(_, behind)| behind.len());
    [format!("{:.decimals$}", one.value), sigma, effect, inflation]
}

impl CalibrationReport {
    /// Returns the tables for people, with a line feed after every line.
    #[must_use]
    pub fn table(&self) -> String {
        let found = &self.found;
        let mut out = found.selection.as_ref().map_or_else(String::new, selection::table);
        let wide = |names: &mut dyn Iterator<Item = usize>| names.max().unwrap_or(0).clamp(12, WIDEST_NAME) + 1;
        // Writing into a String cannot fail.
        for (title, list, is_model) in [("parameter", &found.parameters, true), ("set-up", &found.unknowns, false)] {
            if list.is_empty() {
                continue;
            }
            let width = wide(&mut list.iter().map(|one| one.name.chars().count()));
            let has_repetitions = list.iter().any(|one| one.sigma_monte_carlo.is_some());
            let repeated = |text: &str| if has_repetitions { format!("{text:>12}") } else { String::new() };
            let _ = writeln!(
                out,
                "{title:<width$}{:>12}{:>12}{}  {:<10}{:>12}{:>12}{}",
                "value",
                "± 1σ",
                repeated("± MC"),
                "unit",
                "effect µm",
                "inflation",
                if is_model { "  meaning" } else { "" }
            );
            for one in list {
                let [value, sigma, effect, inflation] = cells(one);
                let (name, unit) = (&one.name, &one.unit);
                let scatter = repeated(&one.sigma_monte_carlo.map_or("-".into(), significant));
                let meaning = if is_model { spelled_out(name) } else { None };
                let meaning = meaning.map_or(String::new(), |words| format!("  {words}"));
                let _ = writeln!(
                    out,
                    "{name:<width$}{value:>12}{sigma:>12}{scatter}  {unit:<10}{effect:>12}{inflation:>12}{meaning}"
                );
            }
            out.push('\n');
        }
        if !found.terms.is_empty() {
            let width = wide(&mut found.terms.iter().map(|one| one.term.chars().count()));
            let _ = writeln!(out, "{:<width$}{:>12}{:>12}  {:<10}  hypothesis", "stated term", "value", "± 1σ", "unit");
            for one in &found.terms {
                let [value, sigma] = [one.value, one.sigma].map(significant);
                let (term, hypothesis) = (&one.term, &one.hypothesis);
                // Names of keys have no µ.
                let unit = one.unit.replacen('u', "µ", 1);
                let _ = writeln!(out, "{term:<width$}{value:>12}{sigma:>12}  {unit:<10}  {hypothesis}");
            }
            out.push('\n');
        }
        let width = wide(&mut found.data.iter().map(|one| one.name.chars().count()));
        if !found.data.is_empty() {
            let _ = writeln!(
                out,
                "{:<width$}{:>9}{:>11}{:>9}{:>11}{:>9}{:>9}{:>11}",
                "measurement", "readings", "measured", "max", "residual", "max", "σ", "efficiency"
            );
        }
        for one in &found.data {
            let sizes = [one.measured_rms, one.measured_max, one.left_rms, one.left_max].map(significant);
            let [measured, most, left, left_most] = sizes;
            let sigma = one.sigma.map_or("-".into(), significant);
            let efficiency = format!("{:.1} %", one.efficiency * 100.0);
            let held = if one.is_held_out { ", held out" } else { "" };
            let unit = one.unit;
            let _ = writeln!(
                out,
                "{:<width$}{:>9}{measured:>11}{most:>9}{left:>11}{left_most:>9}{sigma:>9}{efficiency:>11}  {unit}{held}",
                one.name, one.readings
            );
            if !one.repeated.is_empty() {
                let sigmas = one.repeated.iter().map(|part| format!("{} {}", part.name, significant(part.sigma)));
                let count: usize = one.repeated.iter().map(|part| part.repetitions).sum();
                let sigmas = sigmas.collect::<Vec<_>>().join(", ");
                let drifting: Vec<&str> =
                    one.repeated.iter().filter(|part| part.has_drift).map(|part| part.name.as_str()).collect();
                let drift = match drifting.as_slice() {
                    [] => String::new(),
                    names => format!("; in {} it is mostly a drift, not noise of the instrument", names.join(", ")),
                };
                let _ = writeln!(
                    out,
                    "  scatter of repeated readings about the mean of each pose, {count} degrees of freedom: σ {sigmas} {unit}{drift}"
                );
            }
            if let Some(kept) = one.kept {
                let [left, left_most] = [kept.left_rms, kept.left_max].map(significant);
                let readings = if kept.rejected == 1 { "reading" } else { "readings" };
                let _ = writeln!(
                    out,
                    "  without the {} {readings} of weight 0, which the line above includes: residual {left}, max {left_most} {unit}",
                    kept.rejected
                );
            }
        }
        if !found.weighted_down.is_empty() {
            out.push('\n');
        }
        for row in found.weighted_down.iter().take(MOST_SHOWN) {
            let _ = writeln!(
                out,
                "{}:{}: residual {} {}, weight {:.0} %",
                row.file,
                row.line,
                significant(row.residual),
                row.unit.sign(),
                row.weight * 100.0
            );
        }
        if found.weighted_down.len() > MOST_SHOWN {
            let _ = writeln!(out, "… and {} more", found.weighted_down.len() - MOST_SHOWN);
        }
        out.push('\n');
        out.push_str(&figures::lines(&found.figures));
        if let Some(condition) = found.condition {
            let (freedom, rounds) = (found.degrees_of_freedom, found.rounds);
            push_row(
                &mut out,
                "condition",
                &format!("{condition:.1}, {freedom} degrees of freedom, {rounds} iterations"),
            );
        }
        for line in &found.mean_lines {
            let turn = if line.turn_urad > 0.0 {
                format!("; that over the travel may be turned: ± {} µrad (1σ)", significant(line.turn_urad))
            } else {
                String::new()
            };
            let MeanLineReport { slope, from_mm, to_mm, .. } = line;
            push_row(&mut out, "direction", &format!("{slope}: mean line from {from_mm} to {to_mm} mm{turn}"));
        }
        let left_out: usize = found.left_out.iter().map(|one| one.parameters.len()).sum();
        let rest = if left_out > 0 { format!(" without {left_out} of its parameters") } else { String::new() };
        push_row(&mut out, "model", &format!("{}{rest}", found.model));
        push_row(&mut out, "machine", &found.machine);
        if let Some(output) = &self.output {
            push_row(&mut out, "written", output_name(output));
        }
        if let Some(report) = &self.report {
            push_row(&mut out, "report", output_name(report));
        }
        out.push_str(&self.next);
        out
    }
}
