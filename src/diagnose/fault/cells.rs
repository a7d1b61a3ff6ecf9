//! The readings of sensors of temperature, as one table has them.

use crate::measure::data::DataSet;

/// One sensor.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    /// The name of its column.
    pub(super) name: String,
    /// °C, NaN where it says nothing.
    pub(super) values: Vec<f64>,
}

impl Sensor {
    /// Some rows say nothing any more.
    pub(super) fn forget(&mut self, [first, last]: [usize; 2]) {
        let end = self.values.len().min(last.saturating_add(1));
        self.values.get_mut(first..end).into_iter().flatten().for_each(|value| *value = f64::NAN);
    }

    /// What it says, without gaps.
    pub(super) fn said(&self) -> impl Iterator<Item = f64> {
        self.values.iter().copied().filter(|value| value.is_finite())
    }

    /// Smallest and largest.
    pub(super) fn range(&self) -> Option<[f64; 2]> {
        let low = self.said().reduce(f64::min)?;
        Some([low, self.said().reduce(f64::max)?])
    }

    /// Middle of what some rows say.
    pub(super) fn median_of(&self, rows: std::ops::Range<usize>) -> Option<f64> {
        let values: Vec<f64> =
            self.values.get(rows).into_iter().flatten().copied().filter(|value| value.is_finite()).collect();
        (!values.is_empty()).then(|| super::median(values))
    }
}

/// All sensors of a measurement.
pub(super) fn sensors(data: &DataSet) -> Vec<Sensor> {
    let is_sensor = |name: &str| name.starts_with("T_") && name.ends_with("_C");
    let own = data.drivers.iter().filter(|driver| is_sensor(&driver.name));
    own.map(|driver| Sensor { name: driver.name.clone(), values: driver.values.clone() }).collect()
}

/// Rows behind which the clock goes on as usual; not at a pause, where a machine may have become another one.
pub(super) fn goes_on(data: &DataSet) -> Vec<bool> {
    /// A pause is longer than so many usual intervals.
    const PAUSE: f64 = 5.0;
    /// Interval below which nothing warms up, s.
    const SHORT_S: f64 = 30.0;
    let times: Vec<Option<f64>> = data.observations.iter().map(|one| one.t_s).collect();
    let step = |k: usize| Some(times.get(k + 1).copied()?? - times.get(k).copied()??);
    let steps: Vec<Option<f64>> = (0..times.len()).map(step).collect();
    let usual = super::median(steps.iter().flatten().copied().filter(|step| *step > 0.0).collect());
    let limit = (PAUSE * usual).max(SHORT_S);
    // Without a clock rows are taken as one after the other.
    let is_timed = times.iter().any(Option::is_some);
    steps.iter().map(|step| step.map_or(!is_timed, |step| (0.0..=limit).contains(&step))).collect()
}
