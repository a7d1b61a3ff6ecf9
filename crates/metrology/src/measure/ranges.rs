//! Ranges that measurements cover: positions, tool lengths, temperatures and loads of their readings, for `[measured]` of the machine file.

use super::data::{DataSet, Observation};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_machine::machine::{Condition, Machine, MeasuredRanges};

/// Smallest motion of an axis that counts, mm or rad.
const STANDS: f64 = 1e-6;

/// The measured ranges of the machine, extended by those of these measurements. `residual_um` is the residual of readings that were held out, root mean
/// square.
#[must_use]
pub fn measured_ranges<'d>(
    machine: &Machine,
    sets: impl IntoIterator<Item = &'d DataSet>,
    residual_um: Option<f64>,
) -> MeasuredRanges {
    let mut ranges = machine.measured.clone().unwrap_or_default();
    for set in sets {
        ranges.extend_by(&of_set(machine, set));
    }
    ranges.extend_by(&MeasuredRanges { residual_um, ..MeasuredRanges::default() });
    ranges
}

/// The ranges of one measurement. An axis that did not move in it was not measured.
fn of_set(machine: &Machine, set: &DataSet) -> MeasuredRanges {
    // A reading of a location error itself has no place.
    let rows: Vec<_> =
        set.observations.iter().filter(|row| !row.component.is_some_and(|name| name.is_location())).collect();
    // A reading of one motion error is about its own axis alone.
    let is_about = |row: &Observation, axis: Axis| row.motion_axis().is_none_or(|own| own == axis);
    let moved = AXES.into_iter().filter(|&axis| machine.axis(axis).is_some()).filter_map(|axis| {
        let positions = rows.iter().filter(|row| is_about(row, axis)).map(|row| row.reading.position[axis]);
        let [low, high] = range_of(positions)?;
        (high - low > STANDS).then_some((axis, [low, high]))
    });
    // A table without tool columns states no tool: all its vectors are zero.
    let lengths_mm = range_of(rows.iter().map(|row| row.reading.tool_mm.norm())).filter(|[_, longest]| *longest > 0.0);
    let conditions: Vec<&Condition> = rows.iter().map(|row| set.condition(row)).collect();
    let mut sensors: Vec<&str> = conditions.iter().flat_map(|condition| condition.sensors()).collect();
    sensors.sort_unstable();
    sensors.dedup();
    let temperatures = sensors.into_iter().filter_map(|sensor| {
        let values_c = conditions.iter().filter_map(|condition| condition.temperature_c(sensor, 0.0));
        Some((sensor.to_owned(), range_of(values_c)?))
    });
    let weight_n = |condition: &&Condition| condition.loads().iter().map(|load| load.force_n).sum::<f64>();
    let has_loads = conditions.iter().any(|condition| !condition.loads().is_empty());
    MeasuredRanges {
        axes: moved.collect(),
        tool_length_mm: lengths_mm,
        temperatures_c: temperatures.collect(),
        load_n: if has_loads { range_of(conditions.iter().map(weight_n)) } else { None },
        date: set.date.clone(),
        instruments: vec![set.kind.name.to_owned()],
        ..MeasuredRanges::default()
    }
}

/// The lowest and the highest value; `None` without values.
fn range_of(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = values.filter(|value| value.is_finite());
    finite.fold(None, |range: Option<[f64; 2]>, value| {
        Some(range.map_or([value; 2], |[low, high]| [low.min(value), high.max(value)]))
    })
}
