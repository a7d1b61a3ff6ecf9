//! What a calibration found: the tables for people and the object for programs.

use std::fmt::Write as _;

use serde::Serialize;

use super::compared::{Input, Part, Readings};
use super::correction::push_row;
use super::figures;
use super::json::Finding;
use super::number::significant;
use super::selection::Selection;

/// Rows that do not fit, as far as they are shown.
const MOST_SHOWN: usize = 20;

/// The result of `ncfix calibrate`. Uncertainties are standard uncertainties.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Calibration {
    /// Parameters of the machine.
    pub parameters: Vec<Estimate>,
    /// What was unknown of the set-ups.
    pub unknowns: Vec<Estimate>,
    /// Parameters of the model that were left out because the data cannot tell them.
    pub left_out: Vec<LeftOut>,
    /// Measurements.
    pub data: Vec<Data>,
    /// Figures of ISO 230 of the measurements, which do not depend on the model.
    pub figures: Vec<figures::Measurement>,
    /// Rows that count for less because they do not fit.
    pub weighted_down: Vec<Row>,
    /// Largest by smallest singular value of the equations; `null` without a result.
    pub condition: Option<f64>,
    /// Equations less unknowns.
    pub degrees_of_freedom: usize,
    /// Rounds of Gauss–Newton.
    pub rounds: usize,
    /// The preset or file of parameters.
    pub model: String,
    /// Name of the machine.
    pub machine: String,
    /// How parameters were chosen, where they were.
    pub selection: Option<Selection>,
    /// The written machine file; `null` where there is none.
    pub output: Option<String>,
    /// The written page; `null` where there is none.
    pub report: Option<String>,
    /// Files that the result comes from.
    pub inputs: Vec<Input>,
    /// Version of the program.
    pub version: &'static str,
    /// Findings in the order in which they were met.
    pub diagnostics: Vec<Finding>,
}

/// Parameters that were left out for one reason.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LeftOut {
    /// Their names.
    pub parameters: Vec<String>,
    /// Why the data cannot tell them.
    pub reason: String,
}

/// A number that was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Estimate {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its uncertainty.
    pub sigma: f64,
    /// The scatter of simulated repetitions, where they were asked for.
    pub sigma_monte_carlo: Option<f64>,
    /// The unit of these: `µm`, `µrad/m`.
    pub unit: String,
    /// Its value in the machine file that the calibration began with; 0 for set-ups.
    pub start: f64,
    /// How far it moves the tip, root of the mean square over the readings; `null` for set-ups.
    pub effect_um: Option<f64>,
    /// How much its variance grows because the others are unknown too.
    pub inflation: f64,
}

/// A measurement against the result.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Data {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// Whether it was held out of the fit.
    pub is_held_out: bool,
    /// Readings.
    pub readings: usize,
    /// The unit of all sizes: `µm`, or `µrad` where angles were read.
    pub unit: &'static str,
    /// Root of the mean square of what a machine without errors leaves.
    pub measured_rms: f64,
    /// The largest of it.
    pub measured_max: f64,
    /// Root of the mean square of what the model leaves.
    pub left_rms: f64,
    /// The largest of it.
    pub left_max: f64,
    /// Standard uncertainty of a reading, described or estimated; `null` where neither is.
    pub sigma: Option<f64>,
    /// Share of the measured sizes that the model explains (Spaan, eq. 3.6).
    pub efficiency: f64,
    /// By direction or component.
    pub parts: Vec<Part>,
    /// Sums of the measured sizes and of those that are left, for the efficiency of several measurements together.
    #[serde(skip)]
    pub sums: [f64; 2],
    /// The readings themselves; empty where nobody asks for pictures.
    #[serde(skip)]
    pub shown: Readings,
}

/// A row that does not fit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Row {
    /// Its file.
    pub file: String,
    /// Its line, from 1.
    pub line: usize,
    /// What is left of it.
    pub residual: f64,
    /// The unit of it: `µm` or `µrad`.
    pub unit: &'static str,
    /// What it counts, 0 to 1.
    pub weight: f64,
}

/// Columns for a name; a longer one shifts its line.
const WIDEST_NAME: usize = 60;

impl Estimate {
    /// Value, uncertainty, effect and inflation as text. The value has as many decimals as the uncertainty: a place of a ball is large.
    #[must_use]
    pub fn cells(&self) -> [String; 4] {
        let effect = self.effect_um.map_or(String::new(), significant);
        let [sigma, inflation] = [self.sigma, self.inflation].map(significant);
        let decimals = sigma.split_once('.').map_or(0, |(_, behind)| behind.len());
        [format!("{:.decimals$}", self.value), sigma, effect, inflation]
    }
}

impl Calibration {
    /// The efficiency of all measurements in a unit together, those held out or those used; `None` where there are none.
    #[must_use]
    pub fn efficiency(&self, is_held_out: bool, unit: &str) -> Option<f64> {
        let own = self.data.iter().filter(|one| one.is_held_out == is_held_out && one.unit == unit);
        let [measured, left] =
            own.fold([0.0, 0.0], |[measured, left], one| [measured + one.sums[0], left + one.sums[1]]);
        (measured > 0.0).then(|| 1.0 - left / measured)
    }

    /// The tables for people, with a line feed behind every line.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = self.selection.as_ref().map_or_else(String::new, Selection::table);
        let wide = |names: &mut dyn Iterator<Item = usize>| names.max().unwrap_or(0).clamp(12, WIDEST_NAME) + 1;
        // Writing into a String cannot fail.
        for (title, list) in [("parameter", &self.parameters), ("set-up", &self.unknowns)] {
            if list.is_empty() {
                continue;
            }
            let width = wide(&mut list.iter().map(|one| one.name.chars().count()));
            let has_repetitions = list.iter().any(|one| one.sigma_monte_carlo.is_some());
            let repeated = |text: &str| if has_repetitions { format!("{text:>12}") } else { String::new() };
            let _ = writeln!(
                out,
                "{title:<width$}{:>12}{:>12}{}  {:<10}{:>12}{:>12}",
                "value",
                "± 1σ",
                repeated("± MC"),
                "unit",
                "effect µm",
                "inflation"
            );
            for one in list {
                let [value, sigma, effect, inflation] = one.cells();
                let (name, unit) = (&one.name, &one.unit);
                let scatter = repeated(&one.sigma_monte_carlo.map_or("-".into(), significant));
                let _ = writeln!(
                    out,
                    "{name:<width$}{value:>12}{sigma:>12}{scatter}  {unit:<10}{effect:>12}{inflation:>12}"
                );
            }
            out.push('\n');
        }
        let width = wide(&mut self.data.iter().map(|one| one.name.chars().count()));
        if !self.data.is_empty() {
            let _ = writeln!(
                out,
                "{:<width$}{:>9}{:>11}{:>9}{:>11}{:>9}{:>9}{:>11}",
                "measurement", "readings", "measured", "max", "left", "max", "σ", "efficiency"
            );
        }
        for one in &self.data {
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
        }
        if !self.weighted_down.is_empty() {
            out.push('\n');
        }
        for row in self.weighted_down.iter().take(MOST_SHOWN) {
            let _ = writeln!(
                out,
                "{}:{}: {} {} left, counts {:.0} %",
                row.file,
                row.line,
                significant(row.residual),
                row.unit,
                row.weight * 100.0
            );
        }
        if self.weighted_down.len() > MOST_SHOWN {
            let _ = writeln!(out, "… and {} more", self.weighted_down.len() - MOST_SHOWN);
        }
        out.push('\n');
        out.push_str(&figures::lines(&self.figures));
        if let Some(condition) = self.condition {
            let (freedom, rounds) = (self.degrees_of_freedom, self.rounds);
            push_row(&mut out, "condition", &format!("{condition:.1}, {freedom} degrees of freedom, {rounds} rounds"));
        }
        let left_out: usize = self.left_out.iter().map(|one| one.parameters.len()).sum();
        let rest = if left_out > 0 { format!(" less {left_out} parameters") } else { String::new() };
        push_row(&mut out, "model", &format!("{}{rest}", self.model));
        push_row(&mut out, "machine", &self.machine);
        if let Some(output) = &self.output {
            push_row(&mut out, "written", if output == "-" { "standard output" } else { output });
        }
        if let Some(report) = &self.report {
            push_row(&mut out, "report", if report == "-" { "standard output" } else { report });
        }
        out
    }
}
