//! What a diagnosis found: the page for people and the object for programs.

use std::fmt::Write as _;

use serde::Serialize;

use super::json;
use super::number::significant;

/// The version of the object.
pub const SCHEMA: u32 = 1;

/// The result of `ncfix diagnose`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Diagnosis {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Noise of the readings.
    pub noise_um: f64,
    /// What the model leaves.
    pub before: Sizes,
    /// What it lacks, the largest first.
    pub findings: Vec<Cause>,
    /// Readings that did not count.
    pub data_faults: Vec<DataFault>,
    /// What is left behind all findings.
    pub after: Sizes,
    /// Candidates that were tried.
    pub tried: usize,
    /// Name of the machine.
    pub machine: String,
    /// Findings about the files in the order in which they were met.
    pub diagnostics: Vec<json::Finding>,
}

/// Root of the mean square and largest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Sizes {
    /// Root of the mean square.
    pub rms_um: f64,
    /// Largest.
    pub max_um: f64,
}

/// A fault of the data.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DataFault {
    /// `outlier`, `sensor` …
    pub kind: String,
    /// The measurement, sensor or column.
    pub name: String,
    /// What is wrong with it.
    pub what: String,
    /// Rows from 1: the first and the last, of outliers each.
    pub rows: Vec<usize>,
    /// The measurement.
    pub file: String,
    /// Why this is thought.
    pub evidence: String,
    /// What was left out for it.
    pub excluded: String,
}

/// One finding.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Cause {
    /// Kind of effect.
    pub effect: String,
    /// ISO 230-1 name, axes or direction.
    pub parameter: String,
    /// What it depends on.
    pub drivers: Vec<String>,
    /// Sensor of temperature; `null` where it is none.
    pub sensor: Option<String>,
    /// Its time constant.
    pub lag_s: Option<f64>,
    /// Period, where it repeats.
    pub period: Option<f64>,
    /// Amount.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Expanded uncertainty (95 %).
    pub u95: f64,
    /// What it does to the readings (root of the mean square).
    pub rms_um: f64,
    /// Share of the squares of unseen readings that it takes away.
    pub gain_holdout: f64,
    /// Chance of this where there is nothing, over all candidates.
    pub p: f64,
    /// Explanations that the data cannot tell from it, the best first.
    pub class: Vec<String>,
    /// The measurement that tells them apart; `null` where there is one.
    pub separate_by: Option<String>,
    /// `program`, `live` or `no`.
    pub correctable: String,
    /// What makes it.
    pub made_by: String,
}

impl Diagnosis {
    /// The page for people.
    #[must_use]
    pub fn page(&self) -> String {
        let mut out = String::new();
        let number = significant;
        // Writing into a String cannot fail.
        let _ = writeln!(
            out,
            "{} leaves {} µm (RMS), {} at most; noise {} µm",
            self.machine,
            number(self.before.rms_um),
            number(self.before.max_um),
            number(self.noise_um)
        );
        if self.findings.is_empty() {
            let _ = writeln!(out, "no cause stands: {} were tried", self.tried);
        }
        for (rank, one) in self.findings.iter().enumerate() {
            let _ = writeln!(
                out,
                "\n{}. {} {}: {} ± {} {} (95 %), {} µm of the readings (RMS), {:.0} % of unseen readings",
                rank + 1,
                one.effect,
                one.parameter,
                number(one.value),
                number(one.u95),
                one.unit,
                number(one.rms_um),
                one.gain_holdout * 100.0
            );
            let _ = writeln!(out, "   depends on {}; made by {}", one.drivers.join(", "), one.made_by);
            if one.class.len() > 1 {
                let _ = writeln!(out, "   not told from {}", one.class[1..].join(", "));
            }
            if let Some(how) = &one.separate_by {
                let _ = writeln!(out, "   to tell them apart: {how}");
            }
        }
        for fault in &self.data_faults {
            let rows = match fault.rows.as_slice() {
                [first, last] => format!("rows {first} to {last}"),
                rows => format!("{} rows", rows.len()),
            };
            let _ = writeln!(out, "\n{} {}: {} ({rows})", fault.kind, fault.name, fault.what);
            if !fault.evidence.is_empty() {
                let _ = writeln!(out, "   {}", fault.evidence);
                let _ = writeln!(out, "   left out: {}", fault.excluded);
            }
        }
        let _ = writeln!(
            out,
            "\nleft behind them: {} µm (RMS), {} at most",
            number(self.after.rms_um),
            number(self.after.max_um)
        );
        out
    }
}
