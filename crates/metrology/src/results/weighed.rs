//! Result of weighing the workpiece.

use serde::Serialize;

use super::has_errors;
use crate::measure::strain;
use crate::measure::weighing::{self, Coordinate as Weighed, Weighing, at_rest};
use ncfix_base::csv::Table;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::Source;
use ncfix_machine::machine::Machine;

/// Weight and place of the workpiece. Uncertainties are standard uncertainties.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WeighingResult {
    /// Weight; `null` if it could not be determined.
    #[serde(rename = "force_N")]
    pub force_n: Option<f64>,
    /// Uncertainty of the weight.
    #[serde(rename = "force_sigma_N")]
    pub force_sigma_n: Option<f64>,
    /// Position from the center of the table along X, Y and Z.
    pub place: Option<[LoadCoordinate; 3]>,
    /// Uncertainty of a reading.
    pub noise_um_m: Option<f64>,
    /// Degrees of freedom: readings used minus unknowns.
    pub degrees_of_freedom: usize,
    /// Number of readings used.
    pub readings: usize,
    /// Number of readings left out.
    pub left_out: usize,
}

/// Coordinate of the load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LoadCoordinate {
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
            noise_um_m: Some(weighing.noise_um_m).filter(|noise| noise.is_finite()),
            degrees_of_freedom: weighing.freedom,
            readings: weighing.used,
            left_out: weighing.left_out.len(),
        }
    }
}

/// Weighs the workpiece from a table of readings of the strain gauge of a machine. `known` coordinates of its position, mm, are not determined.
/// `None` if there are errors.
pub fn weigh(
    source: &Source,
    machine: &Machine,
    known: [Option<f64>; 3],
    findings: &mut Vec<Diagnostic>,
) -> Option<Weighing> {
    if machine.strain.is_none() && machine.load_sensors.is_empty() {
        let message = format!("the machine {} has no section [strain]", machine.name);
        let help = "give the signals of the strain gauge in [strain] of the machine file, or a [[load_sensor]], or the load itself";
        findings.push(Diagnostic::nowhere(Code::MISSING_KEY, message, help));
        return None;
    }
    let (table, found) = Table::read(source);
    findings.extend(found);
    let table = table?;
    if at_rest::has_readings(&table, &machine.load_sensors) {
        let (weighing, found) = at_rest::weigh_at_rest(&table, &machine.load_sensors, known);
        findings.extend(found);
        return weighing.filter(|_| !has_errors(findings));
    }
    let Some(gauge) = &machine.strain else {
        let names: Vec<&str> = machine.load_sensors.iter().map(|sensor| sensor.name.as_str()).collect();
        let message = format!("the table has no column of a load sensor: {}", names.join(", "));
        let help = "name the column of the readings as in [[load_sensor]]";
        findings.push(Diagnostic::at(Code::DATA_COLUMN, table.header_place(None), message, help));
        return None;
    };
    let readings = strain::read(&table, gauge).map_err(|found| findings.extend(found)).ok()?;
    let (weighing, found) = weighing::weigh(&readings, gauge, known);
    findings.extend(found);
    weighing.filter(|_| !has_errors(findings))
}
