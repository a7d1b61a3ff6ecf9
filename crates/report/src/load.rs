//! Result of weighing: table for people and the JSON object.

use serde::Serialize;

use super::correction::push_row;
use super::json::DiagnosticReport;
use super::number::significant;
use ncfix_metrology::results::weighed::WeighingResult;

/// Output of `ncfix weigh`: the result, with its output file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Load {
    /// Result.
    #[serde(flatten)]
    pub found: WeighingResult,
    /// State file that was written; `null` if there is none.
    pub output: Option<String>,
    /// Name of the machine.
    pub machine: String,
    /// Diagnostics in order of occurrence.
    pub diagnostics: Vec<DiagnosticReport>,
}

impl Load {
    /// Returns the table for people, with a line feed after every line.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        let mut row = |name: &str, text: &str| push_row(&mut out, name, text);
        if let (Some(force), Some(sigma)) = (self.found.force_n, self.found.force_sigma_n) {
            row("weight", &format!("{force:.1} ± {} N", significant(sigma)));
        }
        for (letter, place) in ['X', 'Y', 'Z'].into_iter().zip(self.found.place.iter().flatten()) {
            let text = match place.sigma_mm {
                Some(sigma) => format!("{:.1} ± {} mm", place.value_mm, significant(sigma)),
                None => format!("{:.1} mm, {}", place.value_mm, place.basis.word()),
            };
            row(&format!("place {letter}"), &text);
        }
        if let Some(noise) = self.found.noise_um_m {
            let (all, freedom) = (self.found.readings + self.found.left_out, self.found.degrees_of_freedom);
            let used = self.found.readings;
            let freedom =
                if freedom == 1 { "1 degree of freedom".to_owned() } else { format!("{freedom} degrees of freedom") };
            row("readings", &format!("{used} of {all}, ± {noise:.3} µm/m each, {freedom}"));
        }
        row("machine", &self.machine);
        if let Some(output) = &self.output {
            row("output", output);
        }
        out
    }
}
