//! Results for compensation tables: the tables, their residual errors, and the differences of two sets.

use serde::Serialize;

use crate::tables::check::{Check, Errors};
use crate::tables::kinds::kinds;
use crate::tables::scheme::auto::Tried;
use crate::tables::scheme::functions::SecondAxisPart;
use crate::tables::scheme::mesh::CountedResidual;
use crate::tables::{Lookup, Sense, Tables};
use ncfix_base::geometry::Vector;
use ncfix_base::units::{UnitKey, um_from_mm, urad_from_rad};

/// Compensation tables that were made or read.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TablesResult {
    /// Name of the machine; empty if none was needed.
    pub machine: String,
    /// Format that was written or read.
    pub format: String,
    /// Scheme that filled the tables; empty for tables that were read.
    pub scheme: String,
    /// Number of tables.
    pub tables: usize,
    /// Number of values.
    pub entries: usize,
    /// Number of grid nodes along X, Y, Z.
    pub grid: Option<[usize; 3]>,
    /// Rows.
    pub rows: Vec<TableRow>,
    /// Residual errors.
    pub check: Option<TablesCheck>,
    /// Tool vector for which the file says its tables are made, mm from the gauge point, if another one was checked.
    pub made_for_tool_mm: Option<[f64; 3]>,
    /// Difference of two sets of tables, µm or µrad: root mean square and largest for each axis.
    pub difference: Vec<TablesDifference>,
    /// Target of `auto`: below the tolerance, as a margin for poses that were not checked.
    pub aim: Option<String>,
    /// Ranges that were requested instead of the travel.
    pub ranges: Vec<String>,
    /// Schemes that `auto` tried.
    pub tried: Vec<TriedScheme>,
    /// Reversal values that the tables cannot hold, for the backlash compensation of the control.
    pub reversals: Vec<ReversalRow>,
    /// Kinds of compensation of ISO/TR 16907, by the form of the tables.
    pub kinds: Vec<String>,
    /// Largest sum of the corrections of each axis.
    pub sums: Vec<CorrectionSum>,
    /// Parts of errors that the tables lack, because they depend on a second axis.
    pub left_out: Vec<MissingPart>,
    /// Number of tables of the scheme, if the best set of a smaller number was asked for.
    pub chosen_of: Option<usize>,
    /// Residual with the best set of each smaller number of tables, or with the nodes of smaller grids.
    pub fewer: Vec<FewerRow>,
    /// Number of tables that each error needs if it is the only one.
    pub single_errors: Vec<SingleErrorRow>,
    /// Number of errors in the machine file that was made from the tables.
    pub errors_found: Option<usize>,
}

/// Largest sum of the corrections that tables add to an axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CorrectionSum {
    /// Axis.
    pub axis: String,
    /// Largest absolute value, mm or deg.
    pub largest: f64,
}

/// Part of a motion error that tables lack: they hold its mean over the second axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MissingPart {
    /// Name of the error.
    pub error: String,
    /// Axis on which it depends too.
    pub second: String,
    /// Largest distance from the mean, in the unit.
    pub largest: f64,
    /// Unit.
    pub unit: UnitKey,
}

/// Residual with a number of tables, or of nodes along each axis of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FewerRow {
    /// Number of tables, or of nodes along each axis.
    pub count: usize,
    /// Root mean square of the tip error, µm.
    pub rms_um: f64,
}

/// Number of tables for a machine with a single error.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SingleErrorRow {
    /// Name of the error.
    pub error: String,
    /// Its size, with unit: that of the machine file, else an assumed one.
    pub size: String,
    /// Number of tables; `null` if no tables were made.
    pub tables: Option<usize>,
    /// Scheme of these tables; empty without tables.
    pub scheme: String,
    /// Root mean square of the tip error without tables, µm.
    pub before_rms_um: Option<f64>,
    /// Root mean square of the tip error with the tables, µm.
    pub rms_um: Option<f64>,
    /// Root mean square of the tilt of the tool with the tables, µrad.
    pub tilt_rms_urad: Option<f64>,
    /// Reason why no tables were made.
    pub reason: Option<String>,
}

impl From<&SecondAxisPart> for MissingPart {
    fn from(part: &SecondAxisPart) -> MissingPart {
        let (unit, largest) = if part.name.direction.is_rotation() {
            (UnitKey::Urad, urad_from_rad(part.largest))
        } else {
            (UnitKey::Um, um_from_mm(part.largest))
        };
        MissingPart { error: part.name.to_string(), second: part.second.to_string(), largest, unit }
    }
}

impl From<&CountedResidual> for FewerRow {
    fn from(one: &CountedResidual) -> FewerRow {
        FewerRow { count: one.count, rms_um: um_from_mm(one.rms_mm) }
    }
}

/// Reversal value of an axis: its correction after a positive motion minus that after a negative one.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReversalRow {
    /// Axis.
    pub axis: String,
    /// Its name at the control.
    pub name: String,
    /// Its number, from 0.
    pub joint: usize,
    /// Mean over its range, mm or deg.
    pub value: f64,
    /// Largest distance from the mean, mm or deg.
    pub spread: f64,
}

/// Detection unit of FANUC controls with increment system IS-B, mm or deg.
const DETECTION_UNIT: f64 = 1e-3;

impl ReversalRow {
    /// The machine data with which the controls compensate for it, with the value.
    #[must_use]
    pub fn settings(&self) -> [String; 3] {
        let units = (self.value / DETECTION_UNIT).round();
        [
            format!("SINUMERIK  MD32450 $MA_BACKLASH[0,{}] = {:.5}", self.name, self.value),
            format!("FANUC      1851 and 1852 of {} = {units:.0} detection units of {DETECTION_UNIT}", self.axis),
            format!("LinuxCNC   [JOINT_{}] BACKLASH = {:.5}", self.joint, self.value),
        ]
    }
}

/// A table.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TableRow {
    /// Number, from 1.
    pub number: usize,
    /// Corrected axis.
    pub output: String,
    /// Axis whose position is looked up.
    pub input: String,
    /// Number of points.
    pub points: usize,
    /// First and last position, mm or deg.
    pub range: [f64; 2],
    /// Largest absolute value, mm or deg.
    pub largest: f64,
    /// Number of the table by which it is multiplied.
    pub times: Option<usize>,
    /// Direction of motion of its axis for which it is valid.
    pub sense: Sense,
    /// True if it is periodic.
    pub modulo: bool,
    /// True if the control evaluates it.
    pub enabled: bool,
}

/// Errors over the volume.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TablesCheck {
    /// Number of poses.
    pub poses: usize,
    /// Without correction.
    pub before: VolumeErrors,
    /// With the tables.
    pub tables: VolumeErrors,
    /// Errors with the exact correction of the kinematics.
    pub exact: VolumeErrors,
    /// Place of the largest residual with the tables.
    pub worst: String,
    /// Tool vector from the gauge point to the tip, mm.
    pub tool_mm: [f64; 3],
    /// Axes whose direction of motion matters: every pose was reached in both directions.
    pub senses: Vec<String>,
    /// Tip error without correction and with the tables about its mean vector, RMS, µm; `None` on a machine with rotary axes, where a touched zero does not
    /// take a constant error away at every angle.
    #[serde(skip)]
    pub about_shift_um: Option<[f64; 2]>,
    /// Change of the mean vector of the tip error by the tables, µm.
    #[serde(skip)]
    pub shift_um: [f64; 3],
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

/// Difference of two sets of tables.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct TablesDifference {
    pub axis: String,
    pub unit: UnitKey,
    pub rms: f64,
    pub max: f64,
}

/// Scheme that `auto` tried.
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

/// Rounds a tool vector to one nanometer, mm, to remove rounding noise of the spindle direction and negative zero.
#[must_use]
pub fn rounded_mm(tool_mm: &Vector) -> [f64; 3] {
    [0, 1, 2].map(|index| (tool_mm[index] * 1e6).round() / 1e6 + 0.0)
}

impl TablesCheck {
    /// Creates the results of a check; `worst` is the place, the tool vector leads from the gauge point to the tip.
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
            about_shift_um: None,
            shift_um: (check.tables.shift_mm() - check.before.shift_mm()).map(um_from_mm).into(),
            tips_um: [&check.before, &check.tables].map(|one| one.tip_mm.iter().map(|mm| um_from_mm(*mm)).collect()),
        }
    }
}

impl TablesResult {
    /// Adds the tables to the result.
    pub fn note(&mut self, tables: &Tables) {
        self.tables = tables.count();
        self.entries = tables.entries();
        self.grid = tables.grid.as_ref().map(|grid| grid.count);
        self.rows = tables.lookups.iter().enumerate().map(|(index, one)| row(index, one)).collect();
        self.kinds = kinds(tables).into_iter().map(str::to_owned).collect();
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
