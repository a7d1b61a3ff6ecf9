//! What a diagnosis found: the object for programs; its text for people is in `text`, its page in [`crate::page::diagnosis`].

pub mod readings;
mod text;

pub(crate) use text::{chance, differing, sign};

use serde::Serialize;

use super::json;

/// The version of the object.
pub const SCHEMA: u32 = 1;

/// The result of `ncfix diagnose`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Diagnosis {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Unit of all sizes `…_um`: `um`, or `urad` where only angles were read.
    pub unit: &'static str,
    /// Noise of the readings.
    pub noise_um: f64,
    /// How it is known: `repeats`, `instrument`, `neighbours`, `rest` where all that is left is white and more than stated.
    pub noise_from: &'static str,
    /// What the descriptions of the instruments say of it; `null` where they say nothing.
    pub noise_stated_um: Option<f64>,
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
    /// What was tried and stopped.
    pub rejected: Vec<Rejected>,
    /// Candidates that were tried.
    pub tried: usize,
    /// Readings that were used.
    pub readings: usize,
    /// Name of the machine.
    pub machine: String,
    /// The machine file that was written.
    pub output: Option<String>,
    /// The page that was written.
    pub report: Option<String>,
    /// Findings about the files in the order in which they were met.
    pub diagnostics: Vec<json::Finding>,
}

impl Diagnosis {
    /// Where nothing was diagnosed no size is known: `null` for programs, no zero.
    pub fn forget_sizes(&mut self) {
        let none = Sizes {
            rms_um: f64::NAN,
            rms_95_um: [f64::NAN; 2],
            max_um: f64::NAN,
            efficiency: f64::NAN,
            ..Sizes::default()
        };
        [self.without_model, self.before, self.after] = [none; 3];
        [self.noise_um, self.gain, self.unexplained.rms_um, self.unexplained.p] = [f64::NAN; 4];
    }
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

/// A candidate that did not stand.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Rejected {
    /// Kind of effect.
    pub effect: String,
    /// ISO 230-1 name, axes or direction.
    pub parameter: String,
    /// What it depends on.
    pub drivers: Vec<String>,
    /// The gate that stopped it: `significance`, `too small`, `gain on unseen parts`, `held-out data`.
    pub why: &'static str,
    /// Chance of this where there is nothing, over all candidates.
    pub p: f64,
    /// Share of the root of the mean square of unseen readings that it takes away; `null` where that was not tried, or the parts could not say.
    pub gain: Option<f64>,
    /// What it is in each file, where files surely differ; else empty.
    pub by_file: Vec<InFile>,
}

/// What a cause is in one file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct InFile {
    /// The measurement.
    pub file: String,
    /// Size.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Expanded uncertainty (95 %).
    pub u95: f64,
}

/// A place of a shape.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Place {
    /// Values of the drivers, in their order and units.
    pub at: Vec<f64>,
    /// The deviation there (µrad where the unit of the finding is `urad`).
    pub value_um: f64,
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
    /// By how much it alone swings the readings of a set-up: the largest less the smallest of what it does.
    pub alone_um: f64,
    /// The part of that in the sum over all findings.
    pub alone_share: f64,
    /// Share of the root of the mean square of unseen readings that it takes away.
    pub gain_holdout: f64,
    /// Its fair part of the squares (Shapley).
    pub share: f64,
    /// What comes back without it.
    pub share_alone: f64,
    /// Chance of this where there is nothing, over all candidates.
    pub p: f64,
    /// What it is in each file, where files surely differ; else empty.
    pub by_file: Vec<InFile>,
    /// Explanations that the data cannot tell from it, itself first.
    pub class: Vec<String>,
    /// The measurement that tells them apart; `null` where there is one explanation.
    pub separate_by: Option<String>,
    /// `program`, `live` or `no`.
    pub correctable: String,
    /// Whether the machine file that was written has it.
    pub extends: bool,
    /// Why it does not, or must not; `null` where it does, and where none was asked for.
    pub extends_why: Option<String>,
    /// What makes it.
    pub made_by: String,
    /// What shows it.
    pub shown_by: String,
    /// Of a finding without a name: what it depends on and where it acts, in a sentence.
    pub what: Option<String>,
    /// How large it is over its drivers; empty where the value says it all.
    pub shape: Vec<Place>,
}
