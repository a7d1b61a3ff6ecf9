//! Compares what two sets of compensation tables add.

use super::stop::Stop;
use ncfix_base::geometry::{AXES, Axis, Vector};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::{ActiveCompensation as _, Machine};
use ncfix_report::tables::Difference;
use ncfix_tables::tables::check::stands;
use ncfix_tables::tables::region::Region;
use ncfix_tables::tables::{Control, Tables};

/// What two sets of tables add at poses: of the travel of the machine, or of the range of the tables.
///
/// # Errors
/// Where error functions lack the kinematics of a machine.
pub(super) fn difference(
    both: [&Tables; 2],
    machine: Option<&Machine>,
    region: &Region,
    tool_mm: Vector,
    seed: u64,
    count: u32,
) -> Result<Vec<Difference>, Stop> {
    if machine.is_none() && both.iter().any(|tables| tables.errors.is_some()) {
        return Err(Stop::Usage("error functions need the kinematics of the machine; give --machine".into()));
    }
    let machine = machine.map_or_else(demo, |machine| Ok(machine.clone()))?;
    let controls = both.map(|tables| Control::new(&machine, tables));
    let both_have = |axis: &Axis| controls.iter().any(|control| control.has_senses(*axis));
    let with_senses: Vec<Axis> = AXES.into_iter().filter(both_have).collect();
    let poses = stands(&region.poses(count as usize, seed), &with_senses);
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
        let (unit, scale): (_, fn(f64) -> f64) =
            if axis.is_rotary() { ("urad", urad_from_rad) } else { ("um", um_from_mm) };
        Difference { axis: axis.to_string(), unit, rms: scale(rms), max: scale(most) }
    };
    Ok(axes.into_iter().map(report).collect())
}

/// A machine for tables that need none.
fn demo() -> Result<Machine, Stop> {
    let text = ncfix_machine::machine::file::DEMO.as_bytes().to_vec();
    let source = ncfix_base::source::Source::new(ncfix_base::source::FileId(0), "<demo machine>", text);
    let source = source.map_err(|_| Stop::Usage("the demo machine is too large".into()))?;
    let (loaded, _) = ncfix_model::file::load(&source);
    loaded.map(|(machine, _)| machine).ok_or_else(|| Stop::Usage("the demo machine cannot be read".into()))
}

/// The positions that tables cover.
pub(super) fn range_of(both: [&Tables; 2]) -> Region {
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
