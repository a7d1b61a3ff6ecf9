//! The request for making and checking compensation tables: a machine in its condition, a part of its volume, axis names, a tool.

use std::fmt::{self, Write as _};

use super::result::{CorrectionSum, TablesCheck};
use crate::tables::check::check;
use crate::tables::region::Region;
use crate::tables::{Control, Multiplication, Orientation, Tables, Target, Wiring};
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_base::units::um_from_mm;
use ncfix_machine::machine::{Condition, Machine, State};
use ncfix_model::{ErrorModel, Model};

/// Seed of the generator of check poses, which differ from those of the schemes.
pub(super) const SEED: u64 = 0x43_4845_434b;

/// The request for making and checking tables.
#[derive(Clone, Debug)]
pub struct TablesRequest<'a> {
    /// The machine, without active tables of its control.
    pub machine: &'a Machine,
    /// Its errors.
    pub errors: &'a ErrorModel,
    /// Its condition.
    pub condition: &'a Condition,
    /// The part of its working volume.
    pub region: Region,
    /// Requested ranges instead of the travel, mm or deg.
    pub ranges: Vec<(Axis, [f64; 2])>,
    /// The control's axis names.
    pub wiring: Wiring,
    /// Tool vector from the gauge point to the tip, mm.
    pub tool_mm: Vector,
    /// Orientation option; `None` for the default of each scheme.
    pub orientation: Option<Orientation>,
    /// The control's interpretation of products, if known.
    pub multiplication: Option<Multiplication>,
    /// Number of poses for the check.
    pub poses: usize,
}

/// Reason why a machine does not have such a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoRegion {
    /// An axis has no travel.
    NoTravel(Axis),
    /// The machine lacks an axis with a requested range.
    NoAxis(Axis),
    /// A range exceeds the travel, given here in mm or rad.
    BeyondTravel(Axis, [f64; 2]),
}

impl fmt::Display for NoRegion {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoRegion::NoTravel(axis) => {
                write!(out, "axis {axis} has no travel; write its travel_mm in the machine file")
            }
            NoRegion::NoAxis(axis) => write!(out, "--range: the machine has no axis {axis}"),
            NoRegion::BeyondTravel(axis, range) => {
                let [lowest, highest] = range.map(|value| if axis.is_rotary() { value.to_degrees() } else { value });
                write!(out, "--range: {axis} travels from {} to {}", short(lowest), short(highest))
            }
        }
    }
}

impl std::error::Error for NoRegion {}

/// The travel of a machine, with requested ranges of some axes, mm or deg.
///
/// # Errors
/// An error if an axis has no travel, or a range is for a missing axis or exceeds the travel.
pub fn region(machine: &Machine, ranges: &[(Axis, [f64; 2])]) -> Result<Region, NoRegion> {
    let mut region = Region::travel(machine).map_err(NoRegion::NoTravel)?;
    for &(axis, range) in ranges {
        let data = machine.axis(axis).ok_or(NoRegion::NoAxis(axis))?;
        let range = range.map(|value| if axis.is_rotary() { value.to_radians() } else { value });
        if let Some(travel) =
            data.travel.filter(|[lowest, highest]| range[0] < lowest - 1e-9 || range[1] > highest + 1e-9)
        {
            return Err(NoRegion::BeyondTravel(axis, travel));
        }
        region.set(axis, range);
    }
    Ok(region)
}

/// A number without conversion noise in its digits.
fn short(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

impl TablesRequest<'_> {
    /// `X -130 .. 130, A -55 .. 55`: the region, mm and deg.
    #[must_use]
    pub fn volume(&self) -> String {
        let text = |&(axis, [low, high]): &(Axis, [f64; 2])| {
            let shown = |value: f64| ncfix_base::units::shown_position(axis.is_rotary(), value);
            format!("{axis} {} .. {}", short(shown(low)), short(shown(high)))
        };
        self.region.ranges.iter().map(text).collect::<Vec<_>>().join(", ")
    }

    /// `A -55 .. 55 deg` for each requested range.
    #[must_use]
    pub fn asked_ranges(&self) -> Vec<String> {
        let text = |&(axis, [low, high]): &(Axis, [f64; 2])| {
            let unit = if axis.is_rotary() { "deg" } else { "mm" };
            format!("{axis} {} .. {} {unit}", short(low), short(high))
        };
        self.ranges.iter().map(text).collect()
    }

    /// The error model of the machine in its condition.
    #[must_use]
    pub fn model(&self) -> Model {
        Model::at(self.machine, self.errors, self.condition)
    }

    /// The target corrections of tables.
    #[must_use]
    pub fn target<'t>(&'t self, model: &'t Model) -> Target<'t> {
        let orientation = self.orientation.unwrap_or(Orientation::Smooth);
        Target { machine: self.machine, model, tool_mm: self.tool_mm, orientation }
    }

    /// Residual errors of tables over the region; a grid does not include rotary axes.
    #[must_use]
    pub fn check(&self, tables: &Tables) -> TablesCheck {
        let mut region = self.region.reached(self.machine);
        if tables.grid.is_some() || tables.matrix.is_some() {
            for (axis, [low, high]) in self.region.ranges.iter().filter(|(axis, _)| axis.is_rotary()) {
                let at = 0_f64.clamp(*low, *high);
                region.set(*axis, [at, at]);
            }
        }
        self.check_in(&region, tables)
    }

    /// Residual errors over the range of every axis. This includes rotary axes that turn although a grid has no tables for them. `checked` is the
    /// result of [`check`](Self::check).
    #[must_use]
    pub fn everywhere(&self, tables: &Tables, checked: &TablesCheck) -> TablesCheck {
        if tables.grid.is_none() && tables.matrix.is_none() {
            return checked.clone();
        }
        self.check_in(&self.region.reached(self.machine), tables)
    }

    /// The largest sum of the corrections of each axis that the tables move, mm or deg, as a control limits it (Esmaeili 2021, Fig. 5.2): at the poses
    /// of the check, and with the linear axes at the nearer ends of their ranges, where the corrections are usually largest.
    #[must_use]
    pub fn largest_sums(&self, tables: &Tables) -> Vec<CorrectionSum> {
        let control = Control::new(self.machine, tables);
        let mut most = AxisVector::default();
        for pose in self.region.poses(self.poses, SEED) {
            let mut corner = pose;
            for &(axis, [low, high]) in self.region.ranges.iter().filter(|(axis, _)| !axis.is_rotary()) {
                corner[axis] = if pose[axis] < f64::midpoint(low, high) { low } else { high };
            }
            for at in [pose, corner] {
                let sum = control.correction(&at, &self.tool_mm, &State::default());
                AXES.into_iter().for_each(|axis| most[axis] = most[axis].max(sum[axis].abs()));
            }
        }
        let shown = |axis: Axis| if axis.is_rotary() { most[axis].to_degrees() } else { most[axis] };
        let moved = AXES.into_iter().filter(|&axis| most[axis] > 0.0);
        moved.map(|axis| CorrectionSum { axis: axis.to_string(), largest: shown(axis) }).collect()
    }

    fn check_in(&self, region: &Region, tables: &Tables) -> TablesCheck {
        let model = self.model();
        let target = self.target(&model);
        let poses = region.poses(self.poses, SEED);
        let found = check(&target, &Control::new(self.machine, tables), &poses);
        let about = || [&found.before, &found.tables].map(|one| um_from_mm(one.about_shift_mm()));
        let has_rotary = self.machine.axes.iter().flatten().any(|data| data.axis.is_rotary());
        TablesCheck {
            about_shift_um: (!has_rotary).then(about),
            ..TablesCheck::new(&found, place(region, &found.worst), &self.tool_mm)
        }
    }
}

/// `X120.5 Y-3 A30`
fn place(region: &Region, pose: &AxisVector) -> String {
    let mut text = String::new();
    for &(axis, _) in &region.ranges {
        let value = if axis.is_rotary() { pose[axis].to_degrees() } else { pose[axis] };
        let _ = write!(text, "{}{axis}{value:.1}", if text.is_empty() { "" } else { " " });
    }
    text
}
