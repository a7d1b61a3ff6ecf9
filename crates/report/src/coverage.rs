//! Coverage of a program by the measurements of its machine: the JSON object and the row for people.

use serde::Serialize;

use super::number::counted;
use ncfix_base::units::um_from_mm;
use ncfix_model::coverage::{Coverage, CoverageGap};

/// Nine decimals of mm, degrees, °C and N.
const DECIMALS: f64 = 1e9;
/// An angle of 1 µrad over 1 m is 1 µm.
const MM_PER_M: f64 = 1000.0;

/// Coverage of positions, tools and conditions by the ranges in which the errors of the machine were measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CoverageReport {
    /// True if the measured ranges are known and nothing goes beyond them.
    pub is_complete: bool,
    /// True if the machine file states measured ranges.
    pub is_stated: bool,
    /// Gaps, by kind and axis.
    pub gaps: Vec<GapReport>,
}

/// Place that no measurement covers.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GapReport {
    /// `no-errors`, `range-not-stated`, `squareness`, `component`, `angle`, `position`, `tool-length`, `temperature` or `load`.
    pub kind: &'static str,
    /// Code of its warning.
    pub code: &'static str,
    /// Axis, if the gap concerns one.
    pub axis: Option<String>,
    /// Sensor of a temperature.
    pub sensor: Option<String>,
    /// Error whose table ends, if the range is that of a table.
    pub table: Option<String>,
    /// Squareness that no measurement shows.
    pub squareness: Option<String>,
    /// Positioning, straightness and angular errors of the axis, or places of a rotary axis, that no measurement shows.
    pub components: Vec<String>,
    /// Largest shift of the tool per µrad by which one of these angles changes, µm/µrad.
    pub um_per_urad: Option<f64>,
    /// Unit of `used`, `measured` and `beyond`: `mm`, `deg`, `C` or `N`.
    pub unit: &'static str,
    /// Lowest and highest value in use.
    pub used: [f64; 2],
    /// Lowest and highest measured value, if known.
    pub measured: Option<[f64; 2]>,
    /// Distance from the measured range, negative below it; 0 if the range is not known.
    pub beyond: f64,
    /// Part of the error of the tool tip that is extrapolated, µm; `null` if it cannot be bounded.
    pub size_um: Option<f64>,
}

impl From<&CoverageGap> for GapReport {
    fn from(gap: &CoverageGap) -> GapReport {
        // Degrees without the noise of their conversion.
        let rounded = |value: f64| (gap.shown(value) * DECIMALS).round() / DECIMALS;
        let shown = |range: [f64; 2]| range.map(rounded);
        GapReport {
            kind: gap.kind.name(),
            code: gap.kind.code().as_str(),
            axis: gap.axis.map(|axis| axis.to_string()),
            sensor: gap.sensor.clone(),
            table: gap.table.map(|name| name.to_string()),
            squareness: gap.squareness.map(|name| name.to_string()),
            components: gap.components.iter().map(ToString::to_string).collect(),
            um_per_urad: gap.arm_mm.map(|arm_mm| arm_mm / MM_PER_M),
            unit: gap.unit(),
            used: shown(gap.used),
            measured: gap.measured.map(shown),
            beyond: rounded(gap.beyond),
            size_um: gap.size_mm.map(um_from_mm),
        }
    }
}

impl From<&Coverage> for CoverageReport {
    fn from(coverage: &Coverage) -> CoverageReport {
        CoverageReport {
            is_complete: coverage.is_complete(),
            is_stated: coverage.is_stated,
            gaps: coverage.gaps.iter().map(GapReport::from).collect(),
        }
    }
}

impl CoverageReport {
    /// Returns it as a part of a sentence, for the row of a table.
    #[must_use]
    pub fn words(&self) -> String {
        match (self.gaps.len(), self.is_stated) {
            (0, true) => "within the measured ranges".to_owned(),
            (0, false) => "not known: the machine file does not state the measured ranges".to_owned(),
            (gaps, _) => format!("{}, named in the warnings", counted(gaps as u64, "gap")),
        }
    }
}
