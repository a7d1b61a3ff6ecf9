//! What a diagnosis found: the page for people and the object for programs.

use std::fmt::Write as _;

use serde::Serialize;

use super::json;
use super::number::significant;

/// The version of the object.
pub const SCHEMA: u32 = 1;
/// Rivals that are named for people.
const RIVALS: usize = 4;
/// A chance below this is said to be this.
const LEAST_CHANCE: f64 = 1e-12;

/// The result of `ncfix diagnose`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Diagnosis {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Noise of the readings.
    pub noise_um: f64,
    /// How it is known: `repeats`, `instrument`, `neighbours`.
    pub noise_from: &'static str,
    /// What a machine without errors would leave.
    pub without_model: Sizes,
    /// What the model leaves.
    pub before: Sizes,
    /// What it lacks, the largest first.
    pub findings: Vec<Cause>,
    /// Readings that did not count.
    pub data_faults: Vec<DataFault>,
    /// What is left behind all findings.
    pub after: Sizes,
    /// Share by which the root of the mean square falls.
    pub gain: f64,
    /// The same on the data held out.
    pub holdout_gain: Option<f64>,
    /// Its interval of 95 %.
    pub holdout_gain_95: Option<[f64; 2]>,
    /// Whether the model says the data (those held out, where there are any) worse than no model.
    pub expired: bool,
    /// What is left beyond the noise.
    pub unexplained: Unexplained,
    /// What stood in the data but was not confirmed by the data held out.
    pub not_confirmed: Vec<String>,
    /// Candidates that were tried.
    pub tried: usize,
    /// Readings that were used.
    pub readings: usize,
    /// Name of the machine.
    pub machine: String,
    /// The machine file that was written.
    pub output: Option<String>,
    /// Findings about the files in the order in which they were met.
    pub diagnostics: Vec<json::Finding>,
}

/// How large readings are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Sizes {
    /// Root of the mean square.
    pub rms_um: f64,
    /// Its interval of 95 %.
    pub rms_95_um: [f64; 2],
    /// Largest.
    pub max_um: f64,
    /// Share of the sum of sizes that is said (Spaan 1995, eq. 3.6).
    pub efficiency: f64,
    /// The same of the data held out.
    pub holdout_rms_um: Option<f64>,
    /// Interval of 95 %.
    pub holdout_rms_95_um: Option<[f64; 2]>,
    /// Largest.
    pub holdout_max_um: Option<f64>,
    /// Efficiency.
    pub holdout_efficiency: Option<f64>,
}

/// What no finding says.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Unexplained {
    /// Root of the mean square beyond the noise.
    pub rms_um: f64,
    /// Whether it is more than noise, and enough to matter.
    pub structure: bool,
    /// Chance of such correlations in noise (Ljung & Box).
    pub p: f64,
    /// What it goes with.
    pub with: Vec<With>,
}

/// A column that what is left goes with.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct With {
    /// Its name.
    pub driver: String,
    /// How much of it.
    pub rms_um: f64,
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
    /// Size: reversal value, amplitude, slope, range over the travel.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Expanded uncertainty (95 %).
    pub u95: f64,
    /// What it does to the readings (root of the mean square).
    pub rms_um: f64,
    /// Share of the root of the mean square of unseen readings that it takes away.
    pub gain_holdout: f64,
    /// Its fair part of the squares (Shapley).
    pub share: f64,
    /// What comes back without it.
    pub share_alone: f64,
    /// Chance of this where there is nothing, over all candidates.
    pub p: f64,
    /// Explanations that the data cannot tell from it, itself first.
    pub class: Vec<String>,
    /// The measurement that tells them apart; `null` where there is one explanation.
    pub separate_by: Option<String>,
    /// `program`, `live` or `no`.
    pub correctable: String,
    /// Whether the machine file that was written has it.
    pub extends: bool,
    /// Why it does not; `null` where it does, and where none was asked for.
    pub extends_why: Option<String>,
    /// What makes it.
    pub made_by: String,
}

impl Diagnosis {
    /// The page for people.
    #[must_use]
    pub fn page(&self) -> String {
        let mut out = String::new();
        self.head(&mut out);
        for (rank, one) in self.findings.iter().enumerate() {
            cause(rank + 1, one, &mut out);
        }
        self.tail(&mut out);
        out
    }

    // Writing into a String cannot fail.
    fn head(&self, out: &mut String) {
        let number = significant;
        let from = match self.noise_from {
            "repeats" => "from repeated readings",
            "instrument" => "as the instrument says",
            _ => "from neighbouring readings",
        };
        let _ = writeln!(
            out,
            "{} leaves {} µm of {} readings (RMS), {} at most; the noise is {} µm, {from}.",
            self.machine,
            number(self.before.rms_um),
            self.readings,
            number(self.before.max_um),
            number(self.noise_um)
        );
        if self.expired {
            let _ = writeln!(
                out,
                "The model has expired: without any model {} µm would be left. Calibrate again.",
                number(self.without_model.holdout_rms_um.unwrap_or(self.without_model.rms_um))
            );
        }
        if self.findings.is_empty() {
            let _ = writeln!(out, "No cause stands; {} were tried.", self.tried);
        }
    }

    fn tail(&self, out: &mut String) {
        let number = significant;
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
        for one in &self.not_confirmed {
            let _ = writeln!(out, "\n{one} stands in the data, but the data held out does not confirm it.");
        }
        if !self.findings.is_empty() {
            let _ = writeln!(
                out,
                "\nWith them {} µm are left (RMS), {} at most; efficiency {:.0} % → {:.0} %.",
                number(self.after.rms_um),
                number(self.after.max_um),
                100.0 * self.before.efficiency,
                100.0 * self.after.efficiency
            );
        }
        if let (Some(before), Some(after)) = (self.before.holdout_rms_um, self.after.holdout_rms_um) {
            let [low, high] = self.holdout_gain_95.unwrap_or_default();
            let _ = writeln!(
                out,
                "Data held out: {} → {} µm, {:.0} % less ({:.0} … {:.0} %).",
                number(before),
                number(after),
                100.0 * self.holdout_gain.unwrap_or_default(),
                100.0 * low,
                100.0 * high
            );
        }
        if self.unexplained.structure {
            let with: Vec<String> =
                self.unexplained.with.iter().map(|one| format!("{} ({} µm)", one.driver, number(one.rms_um))).collect();
            let _ = writeln!(
                out,
                "{} µm are more than noise and have no name yet{}{}.",
                number(self.unexplained.rms_um),
                if with.is_empty() { "" } else { "; they go with " },
                with.join(", ")
            );
        } else {
            let _ = writeln!(out, "Nothing with a shape is left beside the noise.");
        }
        if let Some(path) = &self.output {
            let _ = writeln!(out, "\nWritten: {path}");
            for one in self.findings.iter().filter(|one| !one.extends) {
                let name = format!("{} {}", one.effect, one.parameter);
                let why = one.extends_why.as_deref().unwrap_or("it has no entry");
                let _ = writeln!(out, "It does not have {}: {why}.", name.trim_end());
            }
        }
    }
}

fn cause(rank: usize, one: &Cause, out: &mut String) {
    let number = significant;
    let _ = writeln!(
        out,
        "\n{rank}. {}: {} ± {} {} (95 %)",
        format!("{} {}", one.effect, one.parameter).trim_end(),
        number(one.value),
        number(one.u95),
        one.unit
    );
    let chance = if one.p < LEAST_CHANCE { "next to none".to_owned() } else { format!("{:.0e}", one.p) };
    let _ = writeln!(
        out,
        "   {} µm of the readings (RMS), {:.0} % of what the model leaves; {:.0} % less on unseen readings; chance {chance}",
        number(one.rms_um),
        100.0 * one.share,
        100.0 * one.gain_holdout
    );
    let mut depends = one.drivers.join(", ");
    if let Some(period) = one.period {
        let _ = write!(depends, ", every {}", number(period));
    }
    if let Some(lag) = one.lag_s.filter(|lag| *lag > 0.0) {
        let _ = write!(depends, ", {} s behind", number(lag));
    }
    let can = match one.correctable.as_str() {
        "program" => "a corrected program takes it away",
        "live" => "only live readings can take it away",
        _ => "no program can take it away",
    };
    let goes = if depends.is_empty() { String::new() } else { format!("goes with {depends}; ") };
    let _ = writeln!(out, "   {goes}usually {}; {can}", one.made_by);
    if one.class.len() > 1 {
        let more = one.class.len().saturating_sub(1 + RIVALS);
        let rivals: Vec<&str> = one.class.iter().skip(1).take(RIVALS).map(String::as_str).collect();
        let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
        let _ = writeln!(out, "   may as well be {}{rest}", rivals.join(", "));
    }
    if let Some(how) = &one.separate_by {
        let _ = writeln!(out, "   to tell them apart: {how}");
    }
}
