//! Tables whose rows are sorted by position: their order need not be that of the motion, and then no direction of approach follows from it.
//!
//! A program that saves or filters a table may sort it. A grid that was measured in both directions then looks as if every line had been measured from the same
//! end. The way back to the next line gives the other direction to the first reading of each line: a backlash follows from nothing else than these readings.

use std::collections::BTreeMap;

use crate::measure::data::{DataSet, Free, Observation};
use crate::measure::kind::Measurand;
use ncfix_base::geometry::{AXES, Axis};
use ncfix_machine::machine::Machine;

/// Length of a travel below which an axis stands, mm or rad.
const STANDS: f64 = 1e-6;
/// Least number of rows of a run that can be said to be sorted.
const FEWEST: usize = 4;

/// Rows of one run of a set-up and a component.
type SeriesKey = (usize, usize, Option<usize>);

/// The axes whose directions of approach rest on nothing but the order of rows that are sorted by position. A line of one axis that was read once from end to end
/// has one direction, so it does not count.
#[must_use]
pub fn sorted_axes(machine: &Machine, set: &DataSet) -> Vec<Axis> {
    let is_of_lines =
        matches!(set.kind.measurand, Measurand::Displacement | Measurand::Component | Measurand::LineLength);
    // A time in the rows, and a drift in the order of the rows, state it.
    let has_times = set.free.contains(&Free::Drift) || set.observations.iter().any(|row| row.t_s.is_some());
    if !is_of_lines || !set.is_in_order || set.is_order_stated || set.has_senses || has_times {
        return Vec::new();
    }
    let mut series: BTreeMap<SeriesKey, Vec<&Observation>> = BTreeMap::new();
    for row in &set.observations {
        series.entry((row.setup, row.run, row.target)).or_default().push(row);
    }
    let axes: Vec<Axis> = AXES.into_iter().filter(|axis| machine.axis(*axis).is_some()).collect();
    let mut found: Vec<Axis> = Vec::new();
    for rows in series.values() {
        let moving: Vec<Axis> = axes.iter().copied().filter(|axis| moves(rows, *axis)).collect();
        if rows.len() < FEWEST || !is_sorted(rows, &moving) {
            return Vec::new();
        }
        let is_each_repeated = moving.len() == 1 && is_repeated(rows, moving[0]);
        found.extend(moving.iter().filter(|axis| is_each_repeated || turns(rows, **axis)));
    }
    found.sort_unstable_by_key(|axis| axis.slot());
    found.dedup();
    found
}

fn moves(rows: &[&Observation], axis: Axis) -> bool {
    rows.iter().any(|row| (row.reading.position[axis] - rows[0].reading.position[axis]).abs() > STANDS)
}

/// True if an axis has both directions of approach.
fn turns(rows: &[&Observation], axis: Axis) -> bool {
    [1, -1].iter().all(|sense| rows.iter().any(|row| row.reading.state.direction[axis.slot()] == *sense))
}

/// True if rows on a line have every position several times, as the readings of both ways have after sorting.
fn is_repeated(rows: &[&Observation], axis: Axis) -> bool {
    let blocks = rows.chunk_by(|one, next| (one.reading.position[axis] - next.reading.position[axis]).abs() <= STANDS);
    let sizes: Vec<usize> = blocks.map(<[&Observation]>::len).collect();
    sizes.len() > 2 && sizes.iter().all(|size| *size > 1 && *size == sizes[0])
}

/// True if an order of these axes exists in which the rows are sorted, each axis rising or falling.
fn is_sorted(rows: &[&Observation], moving: &[Axis]) -> bool {
    fn orders(left: &[Axis], chosen: &mut Vec<Axis>, accept: &mut dyn FnMut(&[Axis]) -> bool) -> bool {
        if left.is_empty() {
            return accept(chosen);
        }
        for (place, axis) in left.iter().enumerate() {
            chosen.push(*axis);
            let rest: Vec<Axis> = [&left[..place], &left[place + 1..]].concat();
            if orders(&rest, chosen, accept) {
                return true;
            }
            chosen.pop();
        }
        false
    }
    orders(moving, &mut Vec::new(), &mut |order| {
        let mut senses: Vec<f64> = vec![0.0; order.len()];
        rows.windows(2).all(|pair| {
            let step = |axis: &Axis| pair[1].reading.position[*axis] - pair[0].reading.position[*axis];
            let Some(place) = order.iter().position(|axis| step(axis).abs() > STANDS) else { return true };
            let sense = step(&order[place]).signum();
            if senses[place] == 0.0 {
                senses[place] = sense;
            }
            senses[place] == sense
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::bench;

    /// Positions in X and Y, and lines of the description.
    fn sorted(places: &[[f64; 2]], more: &str) -> Vec<Axis> {
        let machine = bench::machine();
        let row = |(number, [x, y]): (usize, &[f64; 2])| format!("{x},{y},0,{number}\n");
        let rows = "X,Y,Z,dx_um\n".to_owned() + &places.iter().enumerate().map(row).collect::<String>();
        let text = format!("[measurement]\nkind = \"displacement\"\n{more}");
        sorted_axes(&machine, &bench::table(&machine, &rows, &text))
    }

    #[test]
    fn a_sorted_grid_states_no_direction() {
        let grid = |ways: [&[f64]; 3]| -> Vec<[f64; 2]> {
            [0.0, 10.0, 20.0].iter().zip(ways).flat_map(|(y, way)| way.iter().map(move |x| [*x, *y])).collect()
        };
        let (out, back): (&[f64], &[f64]) = (&[0.0, 50.0, 90.0], &[90.0, 50.0, 0.0]);
        assert_eq!(sorted(&grid([out, out, out]), ""), [Axis::X]);
        assert_eq!(sorted(&grid([back, back, back]), ""), [Axis::X]);
        // Readings of both ways at each place.
        let twice: &[f64] = &[0.0, 0.0, 50.0, 50.0, 90.0, 90.0];
        assert_eq!(sorted(&grid([twice, twice, twice]), ""), [Axis::X]);
        // A path that goes to and fro was not sorted, and a statement counts.
        assert_eq!(sorted(&grid([out, back, out]), ""), []);
        assert_eq!(sorted(&grid([out, out, out]), "order = \"motion\"\n"), []);
        assert_eq!(sorted(&grid([out, out, out]), "order = \"unknown\"\n"), []);
    }

    #[test]
    fn a_line_that_was_read_once_is_no_sorted_one() {
        let line = |all: &[f64]| all.iter().map(|x| [*x, 0.0]).collect::<Vec<_>>();
        assert_eq!(sorted(&line(&[0.0, 10.0, 20.0, 30.0]), ""), []);
        assert_eq!(sorted(&line(&[0.0, 10.0, 20.0, 20.0, 10.0, 0.0]), ""), []);
        assert_eq!(sorted(&line(&[0.0, 0.0, 10.0, 10.0, 20.0, 20.0]), ""), [Axis::X]);
    }
}
