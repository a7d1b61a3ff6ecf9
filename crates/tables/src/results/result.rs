//! What was found about compensation tables: each of them, what they leave of the error, what two sets differ by.

use serde::Serialize;

use crate::tables::check::{Check, Errors};
use crate::tables::scheme::Tried;
use crate::tables::{Lookup, Sense, Tables};
use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::units::{um_from_mm, urad_from_rad};

/// Compensation tables that were made or read.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TablesResult {
    /// Name of the machine; empty where none was needed.
    pub machine: String,
    /// Format that was written or read.
    pub format: String,
    /// Scheme that filled them; empty for tables that were read.
    pub scheme: String,
    /// How many tables.
    pub tables: usize,
    /// How many values.
    pub entries: usize,
    /// Nodes of a grid.
    pub grid: Option<[usize; 3]>,
    /// Rows.
    pub rows: Vec<TableRow>,
    /// What they leave.
    pub check: Option<TablesCheck>,
    /// The tool that the file says its tables are for, mm from the gauge point, where another one was checked.
    pub made_for_tool_mm: Option<[f64; 3]>,
    /// What two sets of tables differ by, µm or µrad: root mean square and largest for each axis.
    pub difference: Vec<TablesDifference>,
    /// What `auto` aimed at: less than the tolerance, for the poses that it did not see.
    pub aim: Option<String>,
    /// Ranges that were asked for in place of the travel.
    pub ranges: Vec<String>,
    /// What was tried by `auto`.
    pub tried: Vec<TriedScheme>,
}

/// A table.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TableRow {
    /// Its number, from 1.
    pub number: usize,
    /// Corrected axis.
    pub output: String,
    /// Axis that is looked up.
    pub input: String,
    /// Points.
    pub points: usize,
    /// First and last position, mm or deg.
    pub range: [f64; 2],
    /// Largest value without its sign, mm or deg.
    pub largest: f64,
    /// Number of the table that it is multiplied by.
    pub times: Option<usize>,
    /// In which sense of the motion of its axis it adds.
    pub sense: Sense,
    /// Whether it repeats.
    pub modulo: bool,
    /// Whether the control evaluates it.
    pub enabled: bool,
}

/// Errors over the volume.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TablesCheck {
    /// Poses.
    pub poses: usize,
    /// Without correction.
    pub before: VolumeErrors,
    /// With the tables.
    pub tables: VolumeErrors,
    /// With the exact correction of the kinematics.
    pub exact: VolumeErrors,
    /// Where the tables leave most.
    pub worst: String,
    /// From the gauge point to the tip, mm.
    pub tool_mm: [f64; 3],
    /// Axes whose sense of motion counts: every pose was reached in both.
    pub senses: Vec<String>,
    /// Tip errors of all poses without correction and with the tables, µm, for pictures.
    #[serde(skip)]
    pub tips_um: [Vec<f64>; 2],
}

/// Errors of tip and tool axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "mean, root mean square and largest, with their units")]
pub struct VolumeErrors {
    pub mean_um: f64,
    pub rms_um: f64,
    pub max_um: f64,
    pub tilt_rms_urad: f64,
    pub tilt_max_urad: f64,
}

/// What two sets of tables differ by.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct TablesDifference {
    pub axis: String,
    pub unit: DifferenceUnit,
    pub rms: f64,
    pub max: f64,
}

/// The unit of a difference of corrections.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum DifferenceUnit {
    /// µm, of a linear axis.
    #[serde(rename = "um")]
    Micrometer,
    /// µrad, of a rotary axis.
    #[serde(rename = "urad")]
    Microradian,
}

/// A scheme that `auto` tried.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct TriedScheme {
    pub scheme: String,
    pub points: usize,
    pub tables: Option<usize>,
    pub entries: Option<usize>,
    pub rms_um: Option<f64>,
    pub tilt_rms_urad: Option<f64>,
    pub reason: Option<String>,
}

impl DifferenceUnit {
    /// That of the corrections of an axis.
    #[must_use]
    pub fn of(axis: Axis) -> DifferenceUnit {
        if axis.is_rotary() { DifferenceUnit::Microradian } else { DifferenceUnit::Micrometer }
    }

    /// In letters that every terminal has: `um`, `urad`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            DifferenceUnit::Micrometer => "um",
            DifferenceUnit::Microradian => "urad",
        }
    }
}

impl From<&Errors> for VolumeErrors {
    fn from(errors: &Errors) -> Self {
        VolumeErrors {
            mean_um: um_from_mm(errors.mean_mm()),
            rms_um: um_from_mm(errors.rms_mm()),
            max_um: um_from_mm(errors.max_mm()),
            tilt_rms_urad: urad_from_rad(errors.rms_rad()),
            tilt_max_urad: urad_from_rad(errors.max_rad()),
        }
    }
}

/// A tool to a nanometre, without the digits that a direction of the spindle makes and without a minus in front of zero, mm.
#[must_use]
pub fn rounded_mm(tool_mm: &Vector) -> [f64; 3] {
    [0, 1, 2].map(|index| (tool_mm[index] * 1e6).round() / 1e6 + 0.0)
}

impl TablesCheck {
    /// The figures of a check; `worst` says where, the tool runs from the gauge point to the tip.
    #[must_use]
    pub fn new(check: &Check, worst: String, tool_mm: &Vector) -> TablesCheck {
        TablesCheck {
            poses: check.before.tip_mm.len(),
            before: (&check.before).into(),
            tables: (&check.tables).into(),
            exact: (&check.exact).into(),
            worst,
            tool_mm: rounded_mm(tool_mm),
            senses: check.senses.iter().map(ToString::to_string).collect(),
            tips_um: [&check.before, &check.tables].map(|one| one.tip_mm.iter().map(|mm| um_from_mm(*mm)).collect()),
        }
    }
}

impl TablesResult {
    /// Takes the tables into the result.
    pub fn note(&mut self, tables: &Tables) {
        self.tables = tables.count();
        self.entries = tables.entries();
        self.grid = tables.grid.as_ref().map(|grid| grid.count);
        self.rows = tables.lookups.iter().enumerate().map(|(index, one)| row(index, one)).collect();
    }
}

impl From<&Tried> for TriedScheme {
    fn from(tried: &Tried) -> TriedScheme {
        let mut report =
            TriedScheme { scheme: tried.scheme.to_owned(), points: tried.points, ..TriedScheme::default() };
        match &tried.outcome {
            Ok((tables, entries, [rms_mm, rms_rad])) => {
                (report.tables, report.entries) = (Some(*tables), Some(*entries));
                (report.rms_um, report.tilt_rms_urad) = (Some(um_from_mm(*rms_mm)), Some(urad_from_rad(*rms_rad)));
            }
            Err(why) => report.reason = Some(why.clone()),
        }
        report
    }
}

fn row(index: usize, one: &Lookup) -> TableRow {
    TableRow {
        number: index + 1,
        output: one.output.to_string(),
        input: one.input.to_string(),
        points: one.nodes.count(),
        range: one.nodes.range(),
        largest: one.values.iter().fold(0.0, |most, value| value.abs().max(most)),
        times: one.factor.map(|factor| factor + 1),
        sense: one.sense,
        modulo: one.modulo,
        enabled: one.is_enabled,
    }
}
