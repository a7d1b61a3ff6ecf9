//! Result of weighing: table for people and the JSON object.

use serde::Serialize;

use super::correction::push_row;
use super::json::Finding;
use super::number::significant;
use ncfix_metrology::measure::weighing::{Coordinate as Weighed, Weighing};

/// Output of `ncfix load`. Uncertainties are standard uncertainties.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Load {
    /// Weight; `null` if it could not be determined.
    #[serde(rename = "force_N")]
    pub force_n: Option<f64>,
    /// Uncertainty of the weight.
    #[serde(rename = "force_sigma_N")]
    pub force_sigma_n: Option<f64>,
    /// Position from the center of the table along X, Y and Z.
    pub place: Option<[Coordinate; 3]>,
    /// Uncertainty of a reading.
    pub noise_um_m: Option<f64>,
    /// Degrees of freedom: readings used minus unknowns.
    pub degrees_of_freedom: usize,
    /// Number of readings used.
    pub readings: usize,
    /// Number of readings left out.
    pub left_out: usize,
    /// State file that was written; `null` if there is none.
    pub output: Option<String>,
    /// Name of the machine.
    pub machine: String,
    /// Diagnostics in order of occurrence.
    pub diagnostics: Vec<Finding>,
}

/// Coordinate of the load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Coordinate {
    /// Value.
    pub value_mm: f64,
    /// Uncertainty; `null` if it was not measured.
    pub sigma_mm: Option<f64>,
    /// Basis of the value.
    pub basis: PlaceBasis,
}

/// Basis of a coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PlaceBasis {
    /// Determined from the readings.
    Measured,
    /// Given.
    Known,
    /// Assumed to be 0.
    #[default]
    Assumed,
}

impl PlaceBasis {
    /// Returns its word.
    fn word(self) -> &'static str {
        match self {
            PlaceBasis::Measured => "measured",
            PlaceBasis::Known => "known",
            PlaceBasis::Assumed => "assumed",
        }
    }
}

impl Load {
    /// Adds a weighing to the report.
    pub fn note(&mut self, weighing: &Weighing) {
        self.force_n = Some(weighing.force_n.value);
        self.force_sigma_n = Some(weighing.force_n.sigma);
        self.place = Some(weighing.position_mm.map(|coordinate| {
            let (sigma_mm, basis) = match coordinate {
                Weighed::Measured(measured) => (Some(measured.sigma), PlaceBasis::Measured),
                Weighed::Known(_) => (None, PlaceBasis::Known),
                Weighed::Assumed => (None, PlaceBasis::Assumed),
            };
            Coordinate { value_mm: coordinate.value(), sigma_mm, basis }
        }));
        self.noise_um_m = Some(weighing.noise_um_m);
        self.degrees_of_freedom = weighing.freedom;
        self.readings = weighing.used;
        self.left_out = weighing.left_out.len();
    }

    /// Returns the table for people, with a line feed after every line.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        let mut row = |name: &str, text: &str| push_row(&mut out, name, text);
        if let (Some(force), Some(sigma)) = (self.force_n, self.force_sigma_n) {
            row("weight", &format!("{force:.1} ± {} N", significant(sigma)));
        }
        for (letter, place) in ['X', 'Y', 'Z'].into_iter().zip(self.place.iter().flatten()) {
            let text = match place.sigma_mm {
                Some(sigma) => format!("{:.1} ± {} mm", place.value_mm, significant(sigma)),
                None => format!("{:.1} mm, {}", place.value_mm, place.basis.word()),
            };
            row(&format!("place {letter}"), &text);
        }
        if let Some(noise) = self.noise_um_m {
            let (all, freedom) = (self.readings + self.left_out, self.degrees_of_freedom);
            let used = self.readings;
            row("readings", &format!("{used} of {all}, ± {noise:.3} µm/m each, {freedom} degrees of freedom"));
        }
        row("machine", &self.machine);
        if let Some(output) = &self.output {
            row("output", output);
        }
        out
    }
}
