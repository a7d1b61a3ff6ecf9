//! Compares the effects of two sets of compensation tables.

use std::fmt;

use super::request::SEED;
use super::result::TablesDifference;
use crate::tables::check::stands;
use crate::tables::region::Region;
use crate::tables::{Control, Tables};
use ncfix_base::geometry::{AXES, Axis, Vector};
use ncfix_base::units::{UnitKey, um_from_mm, urad_from_rad};
use ncfix_machine::machine::{ActiveCompensation as _, Machine};

/// Reason why two sets of tables cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotComparable {
    /// Error functions need the kinematics of a machine, but no machine is given.
    NeedsMachine,
    /// The built-in substitute machine cannot be read, which is a defect of this program.
    NoDemo,
}

impl fmt::Display for NotComparable {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            NotComparable::NeedsMachine => "error functions need the kinematics of the machine; give --machine",
            NotComparable::NoDemo => "the machine file of the demo machine cannot be read",
        })
    }
}

impl std::error::Error for NotComparable {}

/// Differences of two sets of tables at `count` poses of a region, axis by axis; without a machine the tables must not need one.
///
/// # Errors
/// An error if error functions lack the kinematics of a machine.
pub fn difference(
    both: [&Tables; 2],
    machine: Option<&Machine>,
    region: &Region,
    tool_mm: Vector,
    count: usize,
) -> Result<Vec<TablesDifference>, NotComparable> {
    if machine.is_none() && both.iter().any(|tables| tables.errors.is_some()) {
        return Err(NotComparable::NeedsMachine);
    }
    let machine = machine.cloned().or_else(demo).ok_or(NotComparable::NoDemo)?;
    let controls = both.map(|tables| Control::new(&machine, tables));
    let both_have = |axis: &Axis| controls.iter().any(|control| control.has_senses(*axis));
    let with_senses: Vec<Axis> = AXES.into_iter().filter(both_have).collect();
    let poses = stands(&region.poses(count, SEED), &with_senses);
    let mut axes: Vec<(Axis, f64, f64)> = region.ranges.iter().map(|&(axis, _)| (axis, 0.0, 0.0)).collect();
    for (pose, state) in &poses {
        let [first, second] = [0, 1].map(|index: usize| controls[index].correction(pose, &tool_mm, state));
        for (axis, squares, most) in &mut axes {
            let apart = first[*axis] - second[*axis];
            *squares += apart * apart;
            *most = most.max(apart.abs());
        }
    }
    let report = |(axis, squares, most): (Axis, f64, f64)| {
        let rms = (squares / poses.len().max(1) as f64).sqrt();
        let scale = if axis.is_rotary() { urad_from_rad } else { um_from_mm };
        TablesDifference {
            axis: axis.to_string(),
            unit: UnitKey::of(axis.is_rotary()),
            rms: scale(rms),
            max: scale(most),
        }
    };
    Ok(axes.into_iter().map(report).collect())
}

/// A substitute machine for tables that need none.
fn demo() -> Option<Machine> {
    let text = ncfix_machine::machine::file::DEMO.as_bytes().to_vec();
    let source = ncfix_base::source::Source::new(ncfix_base::source::FileId(0), "<demo machine>", text).ok()?;
    let (loaded, _) = ncfix_model::file::load(&source);
    loaded.map(|(machine, _)| machine)
}

/// The positions covered by the tables.
#[must_use]
pub fn range_of(both: [&Tables; 2]) -> Region {
    let mut region = Region::default();
    let mut cover = |axis: Axis, [low, high]: [f64; 2]| {
        let unit = |value: f64| if axis.is_rotary() { value.to_radians() } else { value };
        let range = [unit(low), unit(high)];
        match region.ranges.iter_mut().find(|(known, _)| *known == axis) {
            Some((_, known)) => *known = [known[0].min(range[0]), known[1].max(range[1])],
            None => region.ranges.push((axis, range)),
        }
    };
    for tables in both {
        for lookup in &tables.lookups {
            cover(lookup.input, lookup.nodes.range());
            if lookup.output != lookup.input {
                cover(lookup.output, [0.0, 0.0]);
            }
        }
        if let Some(grid) = &tables.grid {
            for (i, &axis) in grid.axes.iter().enumerate() {
                cover(axis, [grid.start[i], grid.start[i] + grid.step[i] * (grid.count[i].max(1) - 1) as f64]);
            }
        }
    }
    region.ranges.sort_by_key(|&(axis, _)| axis);
    region
}
