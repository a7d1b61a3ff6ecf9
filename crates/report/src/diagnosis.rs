//! What a diagnosis found: the object for programs; its text for people is in `text`, its page in [`crate::page::diagnosis`].

mod text;

pub(crate) use text::{CauseText, chance, differing};

use serde::Serialize;

use super::inputs::Input;
use super::json;
use ncfix_metrology::results::diagnosis::{DiagnosisResult, Sizes};
use ncfix_metrology::results::readings;

/// What `ncfix diagnose` prints: the result, and where it went.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DiagnosisReport {
    /// What was found.
    #[serde(flatten)]
    pub found: DiagnosisResult,
    /// The machine file that was written.
    pub output: Option<String>,
    /// The page that was written.
    pub report: Option<String>,
    /// Findings about the files in the order in which they were met.
    pub diagnostics: Vec<json::Finding>,
}

impl DiagnosisReport {
    /// Where nothing was diagnosed no size is known: `null` for programs, no zero.
    pub fn forget_sizes(&mut self) {
        let none = Sizes {
            rms_um: f64::NAN,
            rms_95_um: [f64::NAN; 2],
            max_um: f64::NAN,
            efficiency: f64::NAN,
            ..Sizes::default()
        };
        let found = &mut self.found;
        [found.without_model, found.before, found.after] = [none; 3];
        [found.noise_um, found.gain, found.unexplained.rms_um, found.unexplained.p] = [f64::NAN; 4];
    }
}

/// What a page shows beside the object for programs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// Readings and causes.
    pub readings: readings::ShownReadings,
    /// Files that it comes from.
    pub inputs: Vec<Input>,
    /// Version of the program.
    pub version: &'static str,
}
