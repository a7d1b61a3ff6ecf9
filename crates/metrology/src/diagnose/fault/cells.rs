//! Readings of the temperature sensors of a table.

use crate::measure::data::DataSet;

/// A temperature sensor.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    /// Name of its column.
    pub(super) name: String,
    /// °C, NaN for missing readings.
    pub(super) values: Vec<f64>,
}

impl Sensor {
    /// Deletes the readings of a range of rows.
    pub(super) fn forget(&mut self, [first, last]: [usize; 2]) {
        let end = self.values.len().min(last.saturating_add(1));
        self.values.get_mut(first..end).into_iter().flatten().for_each(|value| *value = f64::NAN);
    }

    /// Its readings without gaps.
    pub(super) fn said(&self) -> impl Iterator<Item = f64> {
        self.values.iter().copied().filter(|value| value.is_finite())
    }

    /// Smallest and largest reading, °C.
    pub(super) fn range(&self) -> Option<[f64; 2]> {
        let low = self.said().reduce(f64::min)?;
        Some([low, self.said().reduce(f64::max)?])
    }

    /// Median of its readings in a range of rows, °C.
    pub(super) fn median_of(&self, rows: std::ops::Range<usize>) -> Option<f64> {
        let values: Vec<f64> =
            self.values.get(rows).into_iter().flatten().copied().filter(|value| value.is_finite()).collect();
        (!values.is_empty()).then(|| super::median(values))
    }
}

/// All temperature sensors of a measurement.
pub(super) fn sensors(data: &DataSet) -> Vec<Sensor> {
    let is_sensor = |name: &str| name.starts_with("T_") && name.ends_with("_C");
    let own = data.drivers.iter().filter(|driver| is_sensor(&driver.name));
    own.map(|driver| Sensor { name: driver.name.clone(), values: driver.values.clone() }).collect()
}

/// Times of a table, which separate jumps of a sensor between rows from warming.
#[derive(Debug)]
pub(super) struct TableClock {
    times: Vec<f64>,
    /// Longest interval, s, that is not a pause. After a pause the machine may be in another state.
    pause: f64,
}

impl TableClock {
    pub(super) fn new(data: &DataSet) -> TableClock {
        /// Ratio of a pause to the longer usual intervals.
        const PAUSE: f64 = 3.0;
        /// A day: longer than any pause, s.
        const APART_S: f64 = 86_400.0;
        /// Interval, s, within which nothing warms up.
        const SHORT_S: f64 = 30.0;
        let times: Option<Vec<f64>> = data.observations.iter().map(|one| one.t_s).collect();
        // Without times, rows count as consecutive; between runs in different set-ups any time may pass.
        let times = times.unwrap_or_else(|| {
            let mut at = 0.0;
            let next = |row: usize| {
                let own = data.observations.get(row)?;
                let last = data.observations.get(row.checked_sub(1)?)?;
                Some(if own.run != last.run && own.setup != last.setup { APART_S } else { 1.0 })
            };
            (0..data.observations.len())
                .map(|row| {
                    at += next(row).unwrap_or(0.0);
                    at
                })
                .collect()
        });
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        let usual = steps.get(steps.len() * 9 / 10).copied().unwrap_or(0.0);
        TableClock { times, pause: (PAUSE * usual).max(SHORT_S) }
    }

    /// Time from one row to another, s; `None` across a pause.
    pub(super) fn step(&self, from: usize, to: usize) -> Option<f64> {
        let step = self.times.get(to)? - self.times.get(from)?;
        (0.0..=self.pause).contains(&step).then_some(step)
    }

    /// Time from one row to another, s; number of rows without times.
    pub(super) fn between(&self, from: usize, to: usize) -> f64 {
        let at = |row: usize| self.times.get(row).copied().unwrap_or(f64::NAN);
        at(to) - at(from)
    }

    /// True if there is no pause in a range of rows.
    pub(super) fn goes_on(&self, first: usize, last: usize) -> bool {
        (first..last).all(|row| self.step(row, row + 1).is_some())
    }

    /// Change of a sensor at a row beyond its changes before and those of another sensor after it, in an equal time; `None` at a pause.
    pub(super) fn jump(&self, before: &[f64], behind: &[f64], row: usize) -> Option<f64> {
        let last = row.checked_sub(1)?;
        let own = self.step(last, row)?;
        let long = 0.9 * own;
        let from = (0..last).rev().take(10).find(|&k| self.times[last] - self.times[k] >= long)?;
        let to = (row + 1..behind.len())
            .take(10)
            .find(|&k| self.times.get(k).is_some_and(|t| t - self.times[row] >= long))?;
        let rate = |values: &[f64], from: usize, to: usize| {
            let step = self.times.get(to)? - self.times.get(from)?;
            let change = values.get(to)? - values.get(from)?;
            Some(if step > 0.0 { change / step * own } else { change })
        };
        let (one, other) = (rate(before, from, last)?, rate(behind, row, to)?);
        let change = behind.get(row)? - before.get(last)?;
        (one.is_finite() && other.is_finite() && change.is_finite())
            .then(|| change - change.clamp(one.min(other).min(0.0), one.max(other).max(0.0)))
    }
}
