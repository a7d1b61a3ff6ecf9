//! Slow state of a machine: temperatures of its sensors, workpieces on its table, and the time.
//!
//! The state that changes from move to move is [`super::State`]. A condition is one instant of a log of readings, or a single reading. Error sources query it
//! for temperatures, with a lag if they respond slowly, and for loads.

pub mod columns;
pub mod file;
pub mod log;
mod trace;

pub use trace::ConditionLog;

use std::collections::BTreeMap;
use std::str::FromStr;
use std::sync::Arc;

use ncfix_base::geometry::{AXIS_COUNT, AxisVector, Vector};

/// Largest plausible weight of a workpiece, N: 1000 t. A greater value is in another unit.
pub const MOST_FORCE_N: f64 = 1e7;
/// Largest plausible distance of a load from the center of the table, mm.
pub const FARTHEST_MM: f64 = 1e5;

/// A pass over all readings of a sensor pays off if at least one in this number of them is requested.
const FEW: usize = 8;

/// Weight on the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Weight, N.
    pub force_n: f64,
    /// Position from the center of the table along the axes of F at the zero pose, mm.
    pub position_mm: Vector,
}

/// Slow state at one instant. The default is the reference state: no load, no temperature deviation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Condition {
    /// Readings by sensor, shared by the conditions at all instants of one log.
    sensors: Arc<BTreeMap<String, ConditionLog>>,
    /// Current loads; the one of the log comes first.
    loads: Vec<Load>,
    /// Load on the table from a time on, s, in order of time.
    load_log: Vec<(f64, Load)>,
    /// True if the first of `loads` is that of the log.
    is_logged: bool,
    time_s: f64,
    zero: Option<Box<Condition>>,
    zero_pose: Option<ZeroPose>,
}

impl Load {
    /// True if the load is plausible for a machine tool.
    #[must_use]
    pub fn is_plausible(&self) -> bool {
        (0.0..=MOST_FORCE_N).contains(&self.force_n) && self.position_mm.iter().all(|mm| mm.abs() <= FARTHEST_MM)
    }
}

impl FromStr for Load {
    type Err = String;

    /// Reads `1700` or `1700@0,0,-280`: weight in N, and position in mm.
    fn from_str(text: &str) -> Result<Load, String> {
        let wrong = || format!("'{text}' is not a load; write newtons and the position: 1700 or 1700@0,0,-280");
        let number = |part: &str| part.trim().parse().ok().filter(|value: &f64| value.is_finite());
        let (force, place) = text.split_once('@').map_or((text, None), |(force, place)| (force, Some(place)));
        let force_n = number(force.trim().trim_end_matches('N')).filter(|&force_n| force_n >= 0.0).ok_or_else(wrong)?;
        let place: Option<Option<Vec<f64>>> = place.map(|place| place.split(',').map(number).collect());
        let position_mm = match place {
            None => Vector::zeros(),
            Some(Some(place)) if place.len() == 3 => Vector::new(place[0], place[1], place[2]),
            Some(_) => return Err(wrong()),
        };
        let load = Load { force_n, position_mm };
        if load.is_plausible() { Ok(load) } else { Err(format!("'{text}': no machine tool carries this load")) }
    }
}

/// Readings of all sensors, which the conditions of a table share.
type SharedLogs = Arc<BTreeMap<String, ConditionLog>>;

/// Changes the readings of a sensor in all of the conditions. Conditions that share their readings still share them afterwards.
pub fn change_readings(conditions: &mut [Condition], sensor: &str, of: &dyn Fn(f64) -> f64) {
    change_points(conditions, sensor, &|time_s, value| (time_s, of(value)));
}

/// Shifts the readings of a sensor in all of the conditions to later times, s. Conditions that share their readings still share them afterwards.
pub fn shift_readings(conditions: &mut [Condition], sensor: &str, by_s: f64) {
    change_points(conditions, sensor, &|time_s, value| (time_s + by_s, value));
}

fn change_points(conditions: &mut [Condition], sensor: &str, of: &dyn Fn(f64, f64) -> (f64, f64)) {
    // Kept alive, so that no other readings get the same address meanwhile.
    let mut done: Vec<[SharedLogs; 2]> = Vec::new();
    let mut change = |condition: &mut Condition| {
        let known = done.iter().rev().find(|[old, _]| Arc::ptr_eq(old, &condition.sensors));
        let new = known.map(|[_, new]| Arc::clone(new)).unwrap_or_else(|| {
            let mut sensors = BTreeMap::clone(&condition.sensors);
            if let Some(own) = sensors.get_mut(sensor) {
                let mut trace = ConditionLog::default();
                for &(time_s, value) in own.points() {
                    let (time_s, value) = of(time_s, value);
                    trace.add(time_s, value);
                }
                *own = trace;
            }
            let new = Arc::new(sensors);
            done.push([Arc::clone(&condition.sensors), Arc::clone(&new)]);
            new
        });
        condition.sensors = new;
    };
    for condition in conditions {
        change(condition);
        condition.zero.as_deref_mut().into_iter().for_each(&mut change);
    }
}

/// Removes readings of a sensor that turned out to be missing, each given by the index of a condition of its log and by its time, s. Other readings
/// bridge the gap linearly. A sensor keeps its readings where no others remain.
pub fn forget_readings(conditions: &mut [Condition], sensor: &str, missing: &[(usize, f64)]) {
    // All conditions of a log share its readings, so each log is changed once.
    let mut logs: Vec<(SharedLogs, Vec<f64>)> = Vec::new();
    for &(index, time_s) in missing {
        let Some(condition) = conditions.get(index) else { continue };
        match logs.iter_mut().rev().find(|(log, _)| Arc::ptr_eq(log, &condition.sensors)) {
            Some((_, times_s)) => times_s.push(time_s),
            None => logs.push((Arc::clone(&condition.sensors), vec![time_s])),
        }
    }
    let changed = logs.iter_mut().filter_map(|(old, times_s)| {
        times_s.sort_by(f64::total_cmp);
        let is_missing = |time_s: f64| times_s.binary_search_by(|other| other.total_cmp(&time_s)).is_ok();
        let mut kept = ConditionLog::default();
        let known = old.get(sensor)?.points().iter().filter(|(time_s, _)| !is_missing(*time_s));
        known.for_each(|&(time_s, value)| kept.add(time_s, value));
        if kept.points().is_empty() {
            return None;
        }
        let mut sensors = BTreeMap::clone(old);
        sensors.insert(sensor.to_owned(), kept);
        Some([Arc::clone(old), Arc::new(sensors)])
    });
    let changed: Vec<[SharedLogs; 2]> = changed.collect();
    let change = |condition: &mut Condition| {
        if let Some([_, new]) = changed.iter().find(|[old, _]| Arc::ptr_eq(old, &condition.sensors)) {
            condition.sensors = Arc::clone(new);
        }
    };
    for condition in conditions {
        change(condition);
        condition.zero.as_deref_mut().into_iter().for_each(change);
    }
}

/// Returns [`Condition::temperature_c`] for each condition. Conditions that share their readings and are in order of time need one pass.
#[must_use]
pub fn temperatures_c<'a>(
    conditions: impl IntoIterator<Item = &'a Condition>,
    sensor: &str,
    lag_s: f64,
) -> Vec<Option<f64>> {
    let mut out = Vec::new();
    let mut times_s: Vec<f64> = Vec::new();
    let mut finish = |shared: Option<&Condition>, times_s: &mut Vec<f64>| {
        match shared.and_then(|condition| condition.trace(sensor)) {
            Some(trace) if FEW * times_s.len() >= trace.points().len() && !trace.points().is_empty() => {
                out.extend(trace.lagged_at(times_s, lag_s).into_iter().map(Some));
            }
            Some(trace) => out.extend(times_s.iter().map(|&time_s| trace.lagged(time_s, lag_s))),
            None => out.extend(times_s.iter().map(|_| None)),
        }
        times_s.clear();
    };
    let mut shared: Option<&Condition> = None;
    for condition in conditions {
        let goes_on = shared.is_some_and(|other| Arc::ptr_eq(&other.sensors, &condition.sensors))
            && times_s.last().is_some_and(|last_s| *last_s <= condition.time_s);
        if !goes_on {
            finish(shared.replace(condition), &mut times_s);
        }
        times_s.push(condition.time_s);
    }
    finish(shared, &mut times_s);
    out
}

/// Pose of the machine when the zero point of the workpiece was set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZeroPose {
    /// Axis command, mm and rad.
    pub command: AxisVector,
    /// From the spindle gauge point to the tip, in F at the zero pose, mm.
    pub tool_mm: Vector,
    /// Direction of the last motion of each axis: −1, 0 (not known) or 1.
    pub direction: [i8; AXIS_COUNT],
}

impl Condition {
    /// Adds a reading of a sensor, °C; readings of one sensor come in order of time.
    pub fn add_reading(&mut self, sensor: &str, time_s: f64, temperature_c: f64) {
        let sensors = Arc::make_mut(&mut self.sensors);
        if let Some(trace) = sensors.get_mut(sensor) {
            trace.add(time_s, temperature_c);
        } else {
            let mut trace = ConditionLog::default();
            trace.add(time_s, temperature_c);
            sensors.insert(sensor.to_owned(), trace);
        }
    }

    /// Sets the readings of a sensor and replaces its earlier ones.
    pub fn set_trace(&mut self, sensor: &str, trace: ConditionLog) {
        Arc::make_mut(&mut self.sensors).insert(sensor.to_owned(), trace);
    }

    /// Adds a workpiece to those on the table.
    pub fn add_load(&mut self, load: Load) {
        self.loads.push(load);
    }

    /// Notes the load on the table from a time on, s; it replaces the previous one. Changes come in order of time.
    pub fn add_load_change(&mut self, time_s: f64, load: Load) {
        self.load_log.push((time_s, load));
        self.set_time(self.time_s);
    }

    /// Removes all workpieces from the table, including those of a log.
    pub fn clear_loads(&mut self) {
        self.loads.clear();
        self.load_log.clear();
        self.is_logged = false;
    }

    /// Sets the current time within the readings, s.
    pub fn set_time(&mut self, time_s: f64) {
        self.time_s = time_s;
        if std::mem::take(&mut self.is_logged) {
            self.loads.remove(0);
        }
        let passed = self.load_log.partition_point(|&(from_s, _)| from_s <= time_s);
        if let Some(&(_, load)) = passed.checked_sub(1).and_then(|index| self.load_log.get(index)) {
            self.loads.insert(0, load);
            self.is_logged = true;
        }
    }

    /// Sets the condition in which the zero point of the workpiece was set: drift counts from there.
    pub fn set_zero(&mut self, zero: Condition) {
        self.zero = Some(Box::new(zero));
    }

    /// Sets the time of the readings at which the zero point of the workpiece was set, s.
    pub fn set_zero_at(&mut self, time_s: f64) {
        let mut zero = Condition { zero: None, zero_pose: None, ..self.clone() };
        zero.set_time(time_s);
        self.set_zero(zero);
    }

    /// Sets the pose at which the zero point was set: only the drift of the tool at this pose is zeroed.
    pub fn set_zero_pose(&mut self, pose: ZeroPose) {
        self.zero_pose = Some(pose);
    }

    /// Returns the pose at which the zero point was set, if known.
    #[must_use]
    pub fn zero_pose(&self) -> Option<&ZeroPose> {
        self.zero_pose.as_ref()
    }

    /// Returns the first and last time of the readings, s; `None` without readings.
    #[must_use]
    pub fn time_range_s(&self) -> Option<[f64; 2]> {
        let of_traces =
            self.sensors.values().flat_map(|trace| trace.points().first().into_iter().chain(trace.points().last()));
        let times = of_traces.map(|&(time_s, _)| time_s).chain(self.load_log.iter().map(|&(time_s, _)| time_s));
        times.fold(None, |range: Option<[f64; 2]>, time_s| {
            let [first, last] = range.unwrap_or([time_s, time_s]);
            Some([first.min(time_s), last.max(time_s)])
        })
    }

    /// Overlays another condition: its sensors, its loads and its zero point if it has any, and its time.
    pub fn lay_over(&mut self, other: Condition) {
        let has_loads = !other.loads.is_empty() || !other.load_log.is_empty();
        if self.sensors.is_empty() {
            self.sensors = other.sensors;
        } else {
            let sensors = other.sensors.iter().map(|(sensor, trace)| (sensor.clone(), trace.clone()));
            Arc::make_mut(&mut self.sensors).extend(sensors);
        }
        if has_loads {
            self.loads = other.loads;
            self.load_log = other.load_log;
            self.is_logged = other.is_logged;
        }
        self.zero = other.zero.or(self.zero.take());
        self.zero_pose = other.zero_pose.or(self.zero_pose.take());
        self.set_time(self.time_s.max(other.time_s));
    }

    /// Returns the current time, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Returns the workpieces on the table.
    #[must_use]
    pub fn loads(&self) -> &[Load] {
        &self.loads
    }

    /// Returns the condition in which the zero point was set, if known.
    #[must_use]
    pub fn zero(&self) -> Option<&Condition> {
        self.zero.as_deref()
    }

    /// Returns the condition at the time when the zero point was set, with the present loads; the present one if that time is not known.
    #[must_use]
    pub fn when_zeroed(&self) -> Condition {
        let Some(zero) = &self.zero else { return self.clone() };
        Condition {
            loads: self.loads.clone(),
            zero: self.zero.clone(),
            zero_pose: self.zero_pose,
            ..Condition::clone(zero)
        }
    }

    /// Returns the names of the sensors that have readings.
    pub fn sensors(&self) -> impl Iterator<Item = &str> {
        self.sensors.keys().map(String::as_str)
    }

    /// Returns the readings of a sensor.
    #[must_use]
    pub fn trace(&self, sensor: &str) -> Option<&ConditionLog> {
        self.sensors.get(sensor)
    }

    /// True if there is any temperature reading.
    #[must_use]
    pub fn has_temperatures(&self) -> bool {
        !self.sensors.is_empty()
    }

    /// Returns the current temperature of a sensor, °C, for a body that follows it with the time constant `lag_s` (0: the sensor itself). `None` if the
    /// sensor has no reading.
    #[must_use]
    pub fn temperature_c(&self, sensor: &str, lag_s: f64) -> Option<f64> {
        self.sensors.get(sensor)?.lagged(self.time_s, lag_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_is_a_weight_and_where_it_stands() {
        assert_eq!("1700N".parse(), Ok(Load { force_n: 1700.0, position_mm: Vector::zeros() }));
        assert_eq!("5@1,2,-3".parse::<Load>().unwrap().position_mm, Vector::new(1.0, 2.0, -3.0));
        for wrong in ["-5", "5@1", "x"] {
            assert!(wrong.parse::<Load>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_shifted_log_has_its_readings_at_other_times() {
        let mut all = [Condition::default(), Condition::default()];
        all[0].add_reading("T", 0.0, 20.0);
        all[0].add_reading("T", 10.0, 22.0);
        all[1] = all[0].clone();
        shift_readings(&mut all, "T", 5.0);
        for (time_s, expected) in [(0.0, 20.0), (10.0, 21.0), (15.0, 22.0)] {
            all.iter_mut().for_each(|one| one.set_time(time_s));
            assert!(all.iter().all(|one| one.temperature_c("T", 0.0) == Some(expected)));
        }
        assert!(Arc::ptr_eq(&all[0].sensors, &all[1].sensors));
    }

    #[test]
    fn forgotten_readings_are_bridged_by_their_neighbours() {
        let mut log = Condition::default();
        // 20, 21 … 24 °C every 10 s; from 20 s to 30 s the logger repeats 99 °C.
        [20.0, 21.0, 99.0, 99.0, 24.0]
            .iter()
            .enumerate()
            .for_each(|(k, &value)| log.add_reading("T", 10.0 * k as f64, value));
        let at = |time_s: f64| {
            let mut one = log.clone();
            one.set_time(time_s);
            one.set_zero_at(20.0);
            one
        };
        let mut all: Vec<Condition> = (0..5).map(|k| at(10.0 * f64::from(k))).collect();
        forget_readings(&mut all, "T", &[(2, 20.0), (3, 30.0)]);
        let own: Vec<_> = all.iter().filter_map(|one| one.temperature_c("T", 0.0)).collect();
        assert_eq!(own, [20.0, 21.0, 22.0, 23.0, 24.0]);
        let zeros: Vec<_> = all.iter().filter_map(|one| one.zero()?.temperature_c("T", 0.0)).collect();
        assert_eq!(zeros, [22.0; 5]);
        // Without any other reading nothing could bridge the gap.
        let mut alone = [Condition::default()];
        alone[0].add_reading("T", 0.0, 20.0);
        forget_readings(&mut alone, "T", &[(0, 0.0)]);
        assert_eq!(alone[0].temperature_c("T", 0.0), Some(20.0));
    }

    #[test]
    fn temperatures_of_many_conditions_are_those_of_each() {
        let with = |offset_c: f64, count: u32| {
            let mut log = Condition::default();
            (0..count).for_each(|k| log.add_reading("T", 10.0 * f64::from(k), offset_c + f64::from(k * k % 13)));
            log
        };
        let (long, short, none) = (with(20.0, 60), with(-3.0, 3), Condition::default());
        // In passes, backwards in time, alternating, with too few for a pass, and before the first reading.
        let at = |log: &Condition, time_s: f64| {
            let mut one = log.clone();
            one.set_time(time_s);
            one
        };
        let mut all: Vec<Condition> = (0..40).map(|k| at(&long, 14.0 * f64::from(k) - 20.0)).collect();
        all.extend([
            at(&long, 3.0),
            at(&short, 5.0),
            at(&long, 7.0),
            at(&none, 7.0),
            at(&short, 19.0),
            at(&short, 99.0),
        ]);
        for lag_s in [0.0, 35.0] {
            let own: Vec<_> = all.iter().map(|one| one.temperature_c("T", lag_s)).collect();
            assert_eq!(temperatures_c(&all, "T", lag_s), own, "{lag_s}");
        }
        assert!(temperatures_c(&all, "other", 0.0).iter().all(Option::is_none));
    }
}
