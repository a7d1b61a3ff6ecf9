//! What an error may depend on, for every row of a measurement: where the axes stood, how they came there, when, how fast, what else was noted.

use std::collections::BTreeMap;

use crate::measure::data::{DataSet, Observation};
use crate::measure::kind::Measurand;
use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, AxisVector};
use ncfix_model::ErrorName;

/// Number of a row that was not measured: of a place where a shape is wanted.
pub const NOWHERE: usize = usize::MAX;
/// The name of the column that says how fast the tool goes along its path.
const FEED: &str = "feed_mm_min";
/// Motions below this are none, mm or rad.
const STILL: f64 = 1e-9;

/// One row.
#[derive(Clone, Debug)]
pub struct SceneRow {
    /// Number of its measurement.
    pub set: usize,
    /// Number in its measurement.
    pub number: usize,
    /// Rows of one measurement, set-up and run that follow each other: number counted over all measurements.
    pub sequence: usize,
    /// Number of its set-up.
    pub setup: usize,
    /// Number of its run in its measurement.
    pub run: usize,
    /// Tool vector, mm.
    pub tool_mm: [f64; 3],
    /// By how much the spindle was turned, rad.
    pub spindle_rad: f64,
    /// The component that was measured.
    pub component: Option<ErrorName>,
    /// Position, mm and rad.
    pub position: AxisVector,
    /// Sense of the last motion: −1, 0, 1.
    pub sense: [i8; AXIS_COUNT],
    /// Path of each axis since it turned last, mm or rad; infinite before it has turned.
    pub since_turn: AxisVector,
    /// Path of the tool since each axis turned last or started from rest with its run, mm; infinite before that.
    pub way_since_turn: AxisVector,
    /// Velocity of each axis, mm/s or rad/s; `None` where neither times nor feed say.
    pub velocity: Option<AxisVector>,
    /// Acceleration, mm/s² or rad/s².
    pub acceleration: Option<AxisVector>,
    /// When, s.
    pub time_s: Option<f64>,
}

impl SceneRow {
    /// Sense of the last motion of an axis as a factor.
    #[must_use]
    pub fn sense_of(&self, axis: Axis) -> f64 {
        f64::from(self.sense.get(axis.slot()).copied().unwrap_or(0))
    }
}

/// The rows of measurements, one after another; `first` numbers the sequences.
pub(super) fn rows(sets: &[DataSet]) -> Vec<SceneRow> {
    let mut rows = Vec::new();
    let mut sequences = 0;
    for (set, data) in sets.iter().enumerate() {
        let mut known: BTreeMap<(usize, usize, usize), usize> = BTreeMap::new();
        let from = rows.len();
        for (number, one) in data.observations.iter().enumerate() {
            // Readings of one component are a series of their own.
            let series = data.targets.len().min(1) * usize::from(one.component.is_some()) * one.target.unwrap_or(0);
            let sequence = *known.entry((one.setup, one.run, series)).or_insert_with(|| {
                sequences += 1;
                sequences - 1
            });
            rows.push(row(set, number, sequence, one));
        }
        move_along(data, rows.get_mut(from..).unwrap_or_default());
    }
    rows
}

fn row(set: usize, number: usize, sequence: usize, one: &Observation) -> SceneRow {
    SceneRow {
        set,
        number,
        sequence,
        setup: one.setup,
        run: one.run,
        tool_mm: [0, 1, 2].map(|k| one.reading.tool_mm[k]),
        spindle_rad: one.spindle_rad,
        component: one.component,
        position: one.reading.position,
        sense: one.reading.state.direction,
        since_turn: AxisVector([f64::INFINITY; AXIS_COUNT]),
        way_since_turn: AxisVector([f64::INFINITY; AXIS_COUNT]),
        velocity: None,
        acceleration: None,
        time_s: one.t_s,
    }
}

/// What follows from the rows before and behind: turns, velocities.
fn move_along(data: &DataSet, rows: &mut [SceneRow]) {
    let feed = data.drivers.iter().find(|driver| driver.name == FEED).map(|driver| driver.values.as_slice());
    let mut sequences: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (place, row) in rows.iter().enumerate() {
        sequences.entry(row.sequence).or_default().push(place);
    }
    for places in sequences.into_values() {
        turns(rows, &places);
        let velocities: Vec<Option<AxisVector>> = (0..places.len()).map(|k| velocity(rows, &places, k, feed)).collect();
        let accelerations: Vec<Option<AxisVector>> =
            (0..places.len()).map(|k| acceleration(rows, &places, k, &velocities, feed)).collect();
        for ((&place, velocity), acceleration) in places.iter().zip(velocities).zip(accelerations) {
            rows[place].velocity = velocity;
            // What encoders say at their own rate is better than differences of the rows that are left of them.
            rows[place].acceleration = if data.kind.measurand == Measurand::MovingDisplacement {
                data.observations.get(rows[place].number).map(|one| one.reading.state.acceleration)
            } else {
                acceleration
            };
        }
    }
}

fn turns(rows: &mut [SceneRow], places: &[usize]) {
    let mut path = AxisVector([f64::INFINITY; AXIS_COUNT]);
    let mut way = path;
    // Half the motion over the two neighbours: what the speed of the axis is like there.
    let speed = |rows: &[SceneRow], k: usize, axis: Axis| {
        let pair = [k.saturating_sub(1), (k + 1).min(places.len() - 1)];
        (rows[places[pair[1]]].position[axis] - rows[places[pair[0]]].position[axis]).abs()
    };
    // The sense in which each axis went last: a row at its turning point itself has none.
    let mut last = AxisVector::ZERO;
    for (k, pair) in places.windows(2).enumerate() {
        let [before, now] = [pair[0], pair[1]];
        let step = difference(rows, [before, now]);
        let length = linear_length(&step);
        for axis in AXES {
            let [old, new] = [rows[before].sense_of(axis), rows[now].sense_of(axis)];
            if old != 0.0 {
                last[axis] = old;
            }
            // It starts from rest: from its turning point, or with its run, where friction holds it as well.
            let starts = old == 0.0 && new != 0.0;
            if starts && (k == 0 || last[axis] * new < 0.0) {
                way[axis] = length;
                if k > 0 {
                    path[axis] = step[axis].abs();
                }
            } else if old * new < 0.0 {
                // It turned where it stood still: between the two as their speeds have it.
                let [from, to] = [speed(rows, k, axis), speed(rows, k + 1, axis)];
                let share = if from + to > STILL { to / (from + to) } else { 1.0 };
                (path[axis], way[axis]) = (step[axis].abs(), length * share);
            } else {
                path[axis] += step[axis].abs();
                way[axis] += length;
            }
        }
        rows[now].since_turn = path;
        rows[now].way_since_turn = way;
    }
}

/// Of the linear axes together.
fn linear_length(step: &AxisVector) -> f64 {
    AXES.into_iter().filter(|axis| !axis.is_rotary()).map(|axis| step[axis].powi(2)).sum::<f64>().sqrt()
}

/// Neighbours in the same sequence.
fn around(places: &[usize], k: usize) -> Option<[usize; 2]> {
    let before = places.get(k.checked_sub(1).unwrap_or(k))?;
    let behind = places.get(k + 1).or(places.get(k))?;
    (before != behind).then_some([*before, *behind])
}

fn difference(rows: &[SceneRow], [from, to]: [usize; 2]) -> AxisVector {
    let mut out = AxisVector::ZERO;
    for axis in AXES {
        out[axis] = rows[to].position[axis] - rows[from].position[axis];
    }
    out
}

/// How long it took, s: by the clock, else by the feed along the path of the linear axes.
fn duration(rows: &[SceneRow], [from, to]: [usize; 2], at: usize, feed: Option<&[f64]>) -> Option<f64> {
    if let (Some(from), Some(to)) = (rows[from].time_s, rows[to].time_s) {
        return (to > from).then_some(to - from);
    }
    let feed = feed?.get(rows[at].number).copied().filter(|feed| *feed > 0.0)?;
    let way = difference(rows, [from, to]);
    let length = linear_length(&way);
    (length > STILL).then_some(length / (feed / 60.0))
}

fn velocity(rows: &[SceneRow], places: &[usize], k: usize, feed: Option<&[f64]>) -> Option<AxisVector> {
    let pair = around(places, k)?;
    let seconds = duration(rows, pair, *places.get(k)?, feed)?;
    let mut out = difference(rows, pair);
    AXES.into_iter().for_each(|axis| out[axis] /= seconds);
    Some(out)
}

fn acceleration(
    rows: &[SceneRow],
    places: &[usize],
    k: usize,
    velocities: &[Option<AxisVector>],
    feed: Option<&[f64]>,
) -> Option<AxisVector> {
    let pair = around(places, k)?;
    let seconds = duration(rows, pair, *places.get(k)?, feed)?;
    let [before, behind] = [k.saturating_sub(1), (k + 1).min(places.len() - 1)];
    let (Some(Some(from)), Some(Some(to))) = (velocities.get(before), velocities.get(behind)) else { return None };
    let mut out = AxisVector::ZERO;
    AXES.into_iter().for_each(|axis| out[axis] = (to[axis] - from[axis]) / seconds);
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn an_axis_turns_in_a_row_that_has_no_sense_and_starts_with_its_run() {
        let machine = bench::machine();
        // From rest at 0 by 10 mm each to its turning point at 30, and back.
        let cells = [(0.0, ",0"), (10.0, ",1"), (20.0, ",1"), (30.0, ",0"), (20.0, ",-1"), (10.0, ",-1"), (25.0, ",1")];
        let found = rows(&[bench::along_x(&machine, ",X_dir", &cells)]);
        let of = |at: fn(&SceneRow) -> AxisVector| found.iter().map(|row| at(row)[Axis::X]).collect::<Vec<f64>>();
        let far = f64::INFINITY;
        // The last one turned between two rows: in the middle, as far as their speeds say.
        assert_eq!(of(|row| row.way_since_turn)[..6], [far, 10.0, 20.0, 30.0, 10.0, 20.0]);
        assert_eq!(of(|row| row.since_turn)[..6], [far, far, far, far, 10.0, 20.0]);
        assert!(of(|row| row.way_since_turn)[6] <= 15.0);
    }

    #[test]
    fn speeds_and_accelerations_of_a_line_are_differences_to_its_ends() {
        let machine = bench::machine();
        // x = t² with a reading in every second.
        let cells: Vec<(f64, String)> = (0..5).map(|t| (f64::from(t * t), format!(",{t}"))).collect();
        let data = bench::along_x(&machine, ",t_s", &cells.iter().map(|(x, t)| (*x, t.as_str())).collect::<Vec<_>>());
        let found = rows(&[data]);
        let of = |at: fn(&SceneRow) -> Option<AxisVector>| -> Vec<f64> {
            found.iter().map(|row| at(row).unwrap()[Axis::X]).collect()
        };
        // In the middle over two seconds, 2t and 2; at the ends over one: 1 and 16 − 9, and 1 from there to the next.
        assert_eq!(of(|row| row.velocity), [1.0, 2.0, 4.0, 6.0, 7.0]);
        assert_eq!(of(|row| row.acceleration), [1.0, 1.5, 2.0, 1.5, 1.0]);
    }
}
