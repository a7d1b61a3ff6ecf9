//! Result of a diagnosis: the JSON object; its text for people is in `text`, its page in [`crate::page::diagnosis`].

mod contradiction;
mod hypotheses;
mod next;
mod text;

pub(crate) use hypotheses::{answer_in_words, in_words, times_in_words};
pub(crate) use next::next_sentence;
pub(crate) use text::{CauseText, differing, p_value};

use serde::Serialize;

use super::inputs::InputFile;
use super::json;
use ncfix_metrology::results::diagnosis::{DiagnosisResult, ReadingSizes};
use ncfix_metrology::results::readings;

/// Output of `ncfix diagnose`: the result, with its output files.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DiagnosisReport {
    /// Result.
    #[serde(flatten)]
    pub found: DiagnosisResult,
    /// Machine file that was written.
    pub output: Option<String>,
    /// Report page that was written.
    pub report: Option<String>,
    /// Diagnostics of the files in order of occurrence.
    pub diagnostics: Vec<json::DiagnosticReport>,
    /// True if a machine file is to be written.
    #[serde(skip)]
    pub is_to_be_written: bool,
}

impl DiagnosisReport {
    /// Sets all sizes to NaN if nothing was diagnosed: `null` in JSON, not zero.
    pub fn forget_sizes(&mut self) {
        let none = ReadingSizes {
            rms_um: f64::NAN,
            rms_95_um: [f64::NAN; 2],
            max_um: f64::NAN,
            efficiency: f64::NAN,
            ..ReadingSizes::default()
        };
        let found = &mut self.found;
        [found.without_model, found.before, found.after] = [none; 3];
        [found.noise_um, found.gain, found.unexplained.rms_um, found.unexplained.p] = [f64::NAN; 4];
    }
}

/// Additional data for the page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PageReadings {
    /// Readings and causes.
    pub readings: readings::ShownReadings,
    /// Files from which the result was computed.
    pub inputs: Vec<InputFile>,
    /// Version of the program.
    pub version: &'static str,
}
