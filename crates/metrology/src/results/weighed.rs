//! What a weighing of the workpiece found.

use serde::Serialize;

use super::has_errors;
use crate::measure::strain;
use crate::measure::weighing::{self, Coordinate as Weighed, Weighing};
use ncfix_base::csv::Table;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::Source;
use ncfix_machine::machine::Machine;

/// Weight and place of the workpiece. Uncertainties are standard uncertainties.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WeighingResult {
    /// The weight; `null` where it could not be told.
    #[serde(rename = "force_N")]
    pub force_n: Option<f64>,
    /// Its uncertainty.
    #[serde(rename = "force_sigma_N")]
    pub force_sigma_n: Option<f64>,
    /// The place from the center of the table along X, Y and Z.
    pub place: Option<[LoadCoordinate; 3]>,
    /// Uncertainty of a reading.
    pub noise_um_m: Option<f64>,
    /// Readings that are used less unknowns.
    pub degrees_of_freedom: usize,
    /// Readings that are used.
    pub readings: usize,
    /// Readings that are left out.
    pub left_out: usize,
}

/// A coordinate of the load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LoadCoordinate {
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
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            PlaceBasis::Measured => "measured",
            PlaceBasis::Known => "known",
            PlaceBasis::Assumed => "assumed",
        }
    }
}

impl From<&Weighing> for WeighingResult {
    fn from(weighing: &Weighing) -> WeighingResult {
        WeighingResult {
            force_n: Some(weighing.force_n.value),
            force_sigma_n: Some(weighing.force_n.sigma),
            place: Some(weighing.position_mm.map(|coordinate| {
                let (sigma_mm, basis) = match coordinate {
                    Weighed::Measured(measured) => (Some(measured.sigma), PlaceBasis::Measured),
                    Weighed::Known(_) => (None, PlaceBasis::Known),
                    Weighed::Assumed => (None, PlaceBasis::Assumed),
                };
                LoadCoordinate { value_mm: coordinate.value(), sigma_mm, basis }
            })),
            noise_um_m: Some(weighing.noise_um_m),
            degrees_of_freedom: weighing.freedom,
            readings: weighing.used,
            left_out: weighing.left_out.len(),
        }
    }
}

/// Weighs the workpiece from the text of a table of readings of the strain gauge of a machine; `known` coordinates of its place, mm, are not looked for. `None` where
/// findings forbid it.
pub fn weigh(
    source: &Source,
    machine: &Machine,
    known: [Option<f64>; 3],
    findings: &mut Vec<Diagnostic>,
) -> Option<Weighing> {
    let Some(gauge) = &machine.strain else {
        let message = format!("the machine {} has no section [strain]", machine.name);
        let help = "give the signals of the strain gauge in [strain] of the machine file, or the load itself";
        findings.push(Diagnostic::nowhere(Code::MISSING_KEY, message, help));
        return None;
    };
    let (table, found) = Table::read(source);
    findings.extend(found);
    let readings = strain::read(&table?, gauge).map_err(|found| findings.extend(found)).ok()?;
    let (weighing, found) = weighing::weigh(&readings, gauge, known);
    findings.extend(found);
    weighing.filter(|_| !has_errors(findings))
}
