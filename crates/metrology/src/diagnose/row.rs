//! Drivers of every row of a measurement: positions, directions of approach, times, velocities, further columns.

use std::collections::BTreeMap;

use crate::measure::data::{DataSet, Observation};
use crate::measure::kind::Measurand;
use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, AxisVector};
use ncfix_model::ErrorName;

/// Number of a row that was not measured, such as a place of a shape.
pub const NOWHERE: usize = usize::MAX;
/// Name of the column with the path feed.
const FEED: &str = "feed_mm_min";
/// Motions below this are ignored, mm or rad.
const STILL: f64 = 1e-9;
/// An instrument that samples a moving axis takes several readings a second. Readings farther apart in time than this, s, are taken at rest, as ISO 230-2 (4.3)
/// requires of a positioning test.
const AT_REST: f64 = 2.0;

/// Feed of circles whose feed was not noted, mm/min: usual for ball-bars. Only the stated lag depends on it, not what it does to the readings.
pub const USUAL_FEED_MM_MIN: f64 = 1000.0;
/// Feeds are equal if they differ by less than this share.
const ONE_FEED: f64 = 0.01;

/// One row of a measurement.
#[derive(Clone, Debug)]
pub struct SceneRow {
    /// Number of its measurement.
    pub set: usize,
    /// Its number in the measurement.
    pub number: usize,
    /// Number of its sequence, counted over all measurements. A sequence has the consecutive rows of one measurement, set-up and run.
    pub sequence: usize,
    /// Number of its series in time: its sequence, or the first of all sequences that were read in turn with it. These share one drift of the machine.
    pub series: usize,
    /// Number of its set-up.
    pub setup: usize,
    /// Number of its run in its measurement.
    pub run: usize,
    /// Tool vector, mm.
    pub tool_mm: [f64; 3],
    /// Rotation of the spindle, rad.
    pub spindle_rad: f64,
    /// Measured component, if any.
    pub component: Option<ErrorName>,
    /// Position, mm and rad.
    pub position: AxisVector,
    /// Direction of the last motion of each axis: −1, 0, 1.
    pub sense: [i8; AXIS_COUNT],
    /// Path of each axis since its last reversal, mm or rad; infinite before the first one.
    pub since_turn: AxisVector,
    /// Path of the tool since the last reversal or start of each axis, mm; infinite before.
    pub way_since_turn: AxisVector,
    /// Velocity of each axis, mm/s or rad/s; `None` if neither times nor feeds determine it.
    pub velocity: Option<AxisVector>,
    /// The velocity of a moving instrument whose times and feeds were not noted: along the path, at [`USUAL_FEED_MM_MIN`].
    pub assumed_velocity: Option<AxisVector>,
    /// Acceleration, mm/s² or rad/s².
    pub acceleration: Option<AxisVector>,
    /// Time, s.
    pub time_s: Option<f64>,
}

impl SceneRow {
    /// Returns the direction of the last motion of an axis as a factor.
    #[must_use]
    pub fn sense_of(&self, axis: Axis) -> f64 {
        f64::from(self.sense.get(axis.slot()).copied().unwrap_or(0))
    }
}

/// Returns the rows of all measurements in their order.
pub(super) fn rows(sets: &[DataSet]) -> Vec<SceneRow> {
    let mut rows = Vec::new();
    let mut sequences = 0;
    for (set, data) in sets.iter().enumerate() {
        let mut known: BTreeMap<(usize, usize, usize), usize> = BTreeMap::new();
        let from = rows.len();
        for (number, one) in data.observations.iter().enumerate() {
            // Readings of one component form a separate series.
            let series = data.targets.len().min(1) * usize::from(one.component.is_some()) * one.target.unwrap_or(0);
            let sequence = *known.entry((one.setup, one.run, series)).or_insert_with(|| {
                sequences += 1;
                sequences - 1
            });
            rows.push(row(set, number, sequence, one));
        }
        let own = rows.get_mut(from..).unwrap_or_default();
        join_in_turn(own);
        move_along(data, own);
    }
    rows
}

fn row(set: usize, number: usize, sequence: usize, one: &Observation) -> SceneRow {
    SceneRow {
        set,
        number,
        sequence,
        series: sequence,
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
        assumed_velocity: None,
        acceleration: None,
        time_s: one.t_s,
    }
}

/// Joins the sequences that were read in turn, such as several points again and again while the machine warms up. Between two rows of one of them there are
/// rows of the others.
fn join_in_turn(rows: &mut [SceneRow]) {
    // Groups of joined sequences of each component, by the order of their last rows.
    let mut by_component: Vec<(Option<ErrorName>, Vec<Vec<usize>>)> = Vec::new();
    for row in rows.iter() {
        let known = by_component.iter().position(|(component, _)| *component == row.component);
        let place = known.unwrap_or_else(|| {
            by_component.push((row.component, Vec::new()));
            by_component.len() - 1
        });
        let groups = &mut by_component[place].1;
        match groups.iter().rposition(|group| group.contains(&row.sequence)) {
            Some(place) => {
                let joined: Vec<usize> = groups.split_off(place).into_iter().flatten().collect();
                groups.push(joined);
            }
            None => groups.push(vec![row.sequence]),
        }
    }
    let mut series: BTreeMap<usize, usize> = BTreeMap::new();
    for group in by_component.into_iter().flat_map(|(_, groups)| groups) {
        let first = group.iter().copied().min().unwrap_or(0);
        series.extend(group.into_iter().map(|sequence| (sequence, first)));
    }
    for row in rows {
        row.series = series.get(&row.sequence).copied().unwrap_or(row.sequence);
    }
}

/// Adds the quantities that depend on the preceding and following rows: reversals, velocities.
fn move_along(data: &DataSet, rows: &mut [SceneRow]) {
    let feed = data.drivers.iter().find(|driver| driver.name == FEED).map(|driver| driver.values.as_slice());
    let mut sequences: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (place, row) in rows.iter().enumerate() {
        sequences.entry(row.sequence).or_default().push(place);
    }
    let is_at_rest = is_at_rest(data, rows, sequences.values());
    for places in sequences.into_values() {
        let is_bar = data.kind.measurand == Measurand::BallDistance;
        turns(rows, &places, is_bar);
        if is_at_rest {
            continue;
        }
        let velocities: Vec<Option<AxisVector>> = (0..places.len()).map(|k| velocity(rows, &places, k, feed)).collect();
        let mut accelerations: Vec<Option<AxisVector>> =
            (0..places.len()).map(|k| acceleration(rows, &places, k, &velocities, feed)).collect();
        if is_bar {
            continue_ends(&mut accelerations);
        }
        for (k, ((&place, velocity), acceleration)) in places.iter().zip(velocities).zip(accelerations).enumerate() {
            if is_bar && velocity.is_none() {
                rows[place].assumed_velocity = assumed(rows, &places, k);
            }
            rows[place].velocity = velocity;
            // Velocities from encoders at their own rate are more accurate than differences of the remaining rows.
            rows[place].acceleration = if data.kind.measurand == Measurand::MovingDisplacement {
                data.observations.get(rows[place].number).map(|one| one.reading.state.acceleration)
            } else {
                acceleration
            };
        }
    }
}

/// Path of an axis before its first reversal.
const UNTURNED: AxisVector = AxisVector([f64::INFINITY; AXIS_COUNT]);
/// An axis reverses in the first row of a circle if it does so within this many steps after it: positions are rounded.
const NEARLY_TURNING: f64 = 0.05;
/// Rows at each end of a circle whose acceleration is not that of central differences.
const OUTER: usize = 2;

/// True if the axes stood still at each reading: the median time from one position to the next is long. A ball-bar and a trace record moving axes.
fn is_at_rest<'p>(data: &DataSet, rows: &[SceneRow], sequences: impl Iterator<Item = &'p Vec<usize>>) -> bool {
    if matches!(data.kind.measurand, Measurand::BallDistance | Measurand::MovingDisplacement) {
        return false;
    }
    // A single feed without times is the feed from target to target (ISO 230-2, 4.3); several feeds are there to show what depends on them.
    let has_times = rows.iter().any(|row| row.time_s.is_some());
    let feeds = data.drivers.iter().filter(|driver| driver.name == FEED).flat_map(|driver| &driver.values);
    let mut feeds = feeds.filter(|feed| feed.is_finite());
    if let Some(first) = feeds.next().filter(|_| !has_times)
        && feeds.all(|feed| (feed / first - 1.0).abs() < ONE_FEED)
    {
        return true;
    }
    let mut seconds: Vec<f64> = sequences
        .flat_map(|places| places.windows(2))
        .filter(|pair| {
            let step = difference(rows, [pair[0], pair[1]]);
            AXES.into_iter().any(|axis| step[axis].abs() > STILL)
        })
        .filter_map(|pair| Some(rows[pair[1]].time_s? - rows[pair[0]].time_s?))
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds.get(seconds.len() / 2).is_some_and(|median| *median > AT_REST)
}

fn turns(rows: &mut [SceneRow], places: &[usize], is_bar: bool) {
    let (mut path, mut way) = if is_bar { before_circle(rows, places) } else { [UNTURNED; 2].into() };
    if let Some(&first) = places.first() {
        (rows[first].since_turn, rows[first].way_since_turn) = (path, way);
    }
    // Mean motion towards both neighbors: a measure of the speed of the axis there.
    let speed = |rows: &[SceneRow], k: usize, axis: Axis| {
        let pair = [k.saturating_sub(1), (k + 1).min(places.len() - 1)];
        (rows[places[pair[1]]].position[axis] - rows[places[pair[0]]].position[axis]).abs()
    };
    // Direction of the last motion of each axis; a row at a reversal has none of its own.
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
            // It starts from rest: at a reversal, or with its run, where friction holds it too.
            let starts = old == 0.0 && new != 0.0;
            if starts && (k == 0 || last[axis] * new < 0.0) {
                way[axis] = length;
                if k > 0 {
                    path[axis] = step[axis].abs();
                }
            } else if old * new < 0.0 {
                // It reversed between two rows: the place is interpolated with their speeds.
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

/// Path of each axis and path of the tool since the reversals within one step before a circle. A circle is a part of a longer arc: the feed-in arc brings the axes
/// to the path feed, so they reverse before the first reading as they do later.
fn before_circle(rows: &[SceneRow], places: &[usize]) -> (AxisVector, AxisVector) {
    let (mut path, mut way) = (UNTURNED, UNTURNED);
    let &[first, second, third, ..] = places else { return (path, way) };
    let (step, two) = (difference(rows, [first, second]), difference(rows, [first, third]));
    let length = linear_length(&step);
    for axis in AXES.into_iter().filter(|&axis| step[axis].abs() > STILL) {
        // Velocity at the first row by the parabola through three rows, over its acceleration, in steps: the number of steps since it was zero.
        let bend = (two[axis] - 2.0 * step[axis]).abs();
        let steps = (2.0 * step[axis] - 0.5 * two[axis]) * step[axis].signum() / bend.max(STILL);
        if (-NEARLY_TURNING..1.0).contains(&steps) {
            let steps = steps.max(0.0);
            way[axis] = steps * length;
            path[axis] = step[axis].abs() * steps * steps / (2.0 * steps + 1.0);
        }
    }
    (path, way)
}

/// Sum over the linear axes.
fn linear_length(step: &AxisVector) -> f64 {
    AXES.into_iter().filter(|axis| !axis.is_rotary()).map(|axis| step[axis].powi(2)).sum::<f64>().sqrt()
}

/// Neighbors in the same sequence.
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

/// Duration, s: from the times, else from the feed along the path of the linear axes.
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

/// Velocity at the usual feed.
fn assumed(rows: &[SceneRow], places: &[usize], k: usize) -> Option<AxisVector> {
    let mut out = difference(rows, around(places, k)?);
    let length = linear_length(&out);
    AXES.into_iter().for_each(|axis| out[axis] *= USUAL_FEED_MM_MIN / 60.0 / length);
    (length > STILL).then_some(out)
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

/// The outer two rows of a circle have the acceleration of the next row: the velocities at its ends are those of half a step further inside.
fn continue_ends(accelerations: &mut [Option<AxisVector>]) {
    if let Some(last) = accelerations.len().checked_sub(1).filter(|last| *last >= 2 * OUTER) {
        let [first_inner, last_inner] = [accelerations[OUTER], accelerations[last - OUTER]];
        accelerations[..OUTER].fill(first_inner);
        accelerations[last + 1 - OUTER..].fill(last_inner);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn a_circle_has_its_acceleration_at_its_ends_too() {
        // 3000 mm/min are 50 mm/s; on a radius of 100 mm the acceleration is 50²/100 = 25 mm/s² towards the center, at each end of a run too.
        let machine = bench::machine();
        let mut text = "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_x_mm,tool_y_mm,tool_z_mm,feed_mm_min,dr_um\n".to_owned();
        for k in 0..60 {
            let (sin, cos) = (f64::from(k) * 2.0_f64.to_radians()).sin_cos();
            text += &format!("1,A,{},{},0,-1,1,0,0,0,0,3000,0\n", 100.0 * cos, 100.0 * sin);
        }
        let description = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\"]\nsigma_um = 1\n\
                           [setup.A]\ncentre_mm = [0, 0, 0]\nlength_mm = 100\n";
        let found = rows(&[bench::table(&machine, &text, description)]);
        for row in &found {
            let own = row.acceleration.unwrap();
            let size = own[Axis::X].hypot(own[Axis::Y]);
            assert!((size - 25.0).abs() < 0.1, "{}: {size}", row.number);
        }
    }

    #[test]
    fn an_axis_turns_in_a_row_that_has_no_sense_and_starts_with_its_run() {
        let machine = bench::machine();
        // From rest at 0 in steps of 10 mm to a reversal at 30, and back.
        let cells = [(0.0, ",0"), (10.0, ",1"), (20.0, ",1"), (30.0, ",0"), (20.0, ",-1"), (10.0, ",-1"), (25.0, ",1")];
        let found = rows(&[bench::along_x(&machine, ",X_dir", &cells)]);
        let of = |at: fn(&SceneRow) -> AxisVector| found.iter().map(|row| at(row)[Axis::X]).collect::<Vec<f64>>();
        let far = f64::INFINITY;
        // The last reversal is between two rows: its place is estimated from the speeds.
        assert_eq!(of(|row| row.way_since_turn)[..6], [far, 10.0, 20.0, 30.0, 10.0, 20.0]);
        assert_eq!(of(|row| row.since_turn)[..6], [far, far, far, far, 10.0, 20.0]);
        assert!(of(|row| row.way_since_turn)[6] <= 15.0);
    }

    #[test]
    fn an_axis_reverses_where_its_circle_begins() {
        let machine = bench::machine();
        let description = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\"]\nsigma_um = 1\n\
                           [setup.A]\ncentre_mm = [0, 0, 0]\nlength_mm = 100\n";
        // X at the first row of a circle in steps of 2°, that begins N degrees after the reversal of X.
        let first = |degrees: f64| {
            let mut text = "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_x_mm,tool_y_mm,tool_z_mm,dr_um\n".to_owned();
            for k in 0..40 {
                let (sin, cos) = (degrees + 2.0 * f64::from(k)).to_radians().sin_cos();
                text += &format!("1,A,{:.5},{:.5},0,-1,1,0,0,0,0,0\n", 100.0 * cos, 100.0 * sin);
            }
            let rows = rows(&[bench::table(&machine, &text, description)]);
            [rows[0].way_since_turn[Axis::X], rows[1].way_since_turn[Axis::X], rows[0].way_since_turn[Axis::Y]]
        };
        // An arc of 2° on a radius of 100 mm is 3.491 mm long.
        let near = |[a, b, c]: [f64; 3], expected: [f64; 2]| {
            (a - expected[0]).abs() < 0.02 && (b - expected[1]).abs() < 0.02 && c.is_infinite()
        };
        assert!(near(first(0.0), [0.0, 3.491]), "{:?}", first(0.0));
        assert!(near(first(1.0), [1.745, 5.236]), "{:?}", first(1.0));
        // Further back the feed-in arc is not known.
        assert!(first(10.0)[0].is_infinite());
    }

    #[test]
    fn set_ups_that_are_read_in_turn_are_one_series() {
        let machine = bench::machine();
        let series = |labels: &str| -> Vec<usize> {
            let cells: Vec<(f64, String)> =
                labels.chars().enumerate().map(|(row, label)| (row as f64, format!(",{label}"))).collect();
            let cells: Vec<(f64, &str)> = cells.iter().map(|(x, label)| (*x, label.as_str())).collect();
            rows(&[bench::along_x(&machine, ",setup", &cells)]).iter().map(|row| row.series).collect()
        };
        assert_eq!(series("AABBCC"), [0, 0, 1, 1, 2, 2]);
        assert_eq!(series("ABCABC"), [0; 6]);
        // B to D in turn, after A and before E.
        assert_eq!(series("AABCBDCBEE"), [0, 0, 1, 1, 1, 1, 1, 1, 4, 4]);
    }

    #[test]
    fn speeds_and_accelerations_of_a_line_are_differences_to_its_ends() {
        let machine = bench::machine();
        // x = t², with one reading per second.
        let cells: Vec<(f64, String)> = (0..5).map(|t| (f64::from(t * t), format!(",{t}"))).collect();
        let data = bench::along_x(&machine, ",t_s", &cells.iter().map(|(x, t)| (*x, t.as_str())).collect::<Vec<_>>());
        let found = rows(&[data]);
        let of = |at: fn(&SceneRow) -> Option<AxisVector>| -> Vec<f64> {
            found.iter().map(|row| at(row).unwrap()[Axis::X]).collect()
        };
        // In the middle over two seconds: 2t and 2. At the ends over one second: 1 and 16 − 9, and 1 from there to the next.
        assert_eq!(of(|row| row.velocity), [1.0, 2.0, 4.0, 6.0, 7.0]);
        assert_eq!(of(|row| row.acceleration), [1.0, 1.5, 2.0, 1.5, 1.0]);
    }

    #[test]
    fn readings_several_seconds_apart_are_taken_at_rest() {
        let machine = bench::machine();
        let velocities = |seconds: u32| {
            let cells: Vec<(f64, String)> =
                (0..5).map(|k| (10.0 * f64::from(k), format!(",{}", k * seconds))).collect();
            let cells: Vec<(f64, &str)> = cells.iter().map(|(x, t)| (*x, t.as_str())).collect();
            rows(&[bench::along_x(&machine, ",t_s", &cells)]).iter().filter(|row| row.velocity.is_some()).count()
        };
        assert_eq!([velocities(1), velocities(12)], [5, 0]);
    }
}
