//! What a weighing found: the table for people and the object for programs.

use serde::Serialize;

use super::correction::push_row;
use super::json::Finding;
use super::number::significant;
use ncfix_metrology::measure::weighing::{Coordinate as Weighed, Weighing};

/// The result of `ncfix weigh`. Uncertainties are standard uncertainties.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Load {
    /// The weight; `null` where it could not be told.
    #[serde(rename = "force_N")]
    pub force_n: Option<f64>,
    /// Its uncertainty.
    #[serde(rename = "force_sigma_N")]
    pub force_sigma_n: Option<f64>,
    /// The place from the center of the table along X, Y and Z.
    pub place: Option<[Coordinate; 3]>,
    /// Uncertainty of a reading.
    pub noise_um_m: Option<f64>,
    /// Readings that are used less unknowns.
    pub degrees_of_freedom: usize,
    /// Readings that are used.
    pub readings: usize,
    /// Readings that are left out.
    pub left_out: usize,
    /// The written state file; `null` where there is none.
    pub output: Option<String>,
    /// Name of the machine.
    pub machine: String,
    /// Findings in the order in which they were met.
    pub diagnostics: Vec<Finding>,
}

/// A coordinate of the load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Coordinate {
    /// Its value.
    pub value_mm: f64,
    /// Its uncertainty; `null` where it was not measured.
    pub sigma_mm: Option<f64>,
    /// Where it comes from.
    pub basis: PlaceBasis,
}

/// Where a coordinate comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PlaceBasis {
    /// From the readings.
    Measured,
    /// As stated.
    Known,
    /// Taken for 0.
    #[default]
    Assumed,
}

impl PlaceBasis {
    /// Its word.
    fn word(self) -> &'static str {
        match self {
            PlaceBasis::Measured => "measured",
            PlaceBasis::Known => "known",
            PlaceBasis::Assumed => "assumed",
        }
    }
}

impl Load {
    /// Takes a weighing into the report.
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

    /// The table for people, with a line feed behind every line.
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
