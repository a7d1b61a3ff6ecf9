//! A log of temperatures or of the spindle speed whose clock differs from that of the readings.
//!
//! The readings are fitted by one sensor and bodies that follow it with several time constants, with the log shifted in time. All columns of a log have one
//! clock. A shift is certain if the shifted sensor explains the readings better than all sensors without a shift, each with all time constants. A body that
//! follows its sensor late looks like a log that is early. If time constants explain the readings as well as a shift, both are reported as alternatives, and
//! nothing is shifted.

use super::cells::Sensor;
use super::regression::{ColumnProducts, residuals};
use super::trail::{ReadingTrail, Trail};
use super::{DataDefect, DefectCheck, DefectKind, ShiftedLog, Then, View};
use crate::measure::data::DataSet;
use ncfix_base::numeric::in_parts;
use ncfix_machine::machine::condition::shift_readings;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "clock offset of a log",
    made_by: "a logger with another clock than the control or the instrument: set by hand, summer time, another time zone",
    shown_by: "a drift that follows a sensor with any time constant only if the log is shifted in time",
    source: "profile likelihood of a delay; first-order response of a body to a temperature",
    look,
};

/// Time constants of the bodies that may follow a sensor, s.
const LAGS_S: [f64; 4] = [0.0, 300.0, 1800.0, 7200.0];
/// Shortest time constant of the only body in the alternative to a shift, s, ratio of one to the next, and their number: up to 2 h.
const ONE_LAG_S: f64 = 60.0;
const ONE_LAG_RATIO: f64 = 1.2;
const ONE_LAGS: i32 = 28;
/// Time constants without a shift, s, each alone and twice in series: a body far from its sensor follows with a delay that one time constant lacks.
const RICH_LAGS_S: [f64; 8] = [0.0, 60.0, 150.0, 400.0, 1000.0, 2000.0, 4000.0, 8000.0];
/// Largest offset to search, s: two time zones, or summer time and one.
const MOST_S: f64 = 7200.0;
/// Largest offset as a share of the duration of a log: enough readings must remain.
const MOST_SHARE: f64 = 1.0 / 3.0;
/// Number of offsets on each side in the first pass, and in each finer one.
const STEPS: [i32; 2] = [48, 8];
/// Number of finer passes.
const PASSES: usize = 3;
/// Minimum number of rows, and maximum number of those used: a drift changes slowly.
const ROWS: [usize; 2] = [60, 800];
/// Smallest standard deviation of the readings, in units of their noise.
const DRIFT: f64 = 3.0;
/// Smallest share of the variance of the readings that a shifted log explains.
const SHARE: f64 = 0.8;
/// One of these two is required in addition. The first is the share that leaves no room for another cause. The second is the ratio of the residual without a
/// shift to that with it. A drift of a few times the noise that no sensor shows may follow a shifted one by chance, and about a tenth better than the others.
const SURE_SHARE: f64 = 0.98;
const SURE_RATIO: f64 = 1.3;
/// Smallest gain in −2 ln of the likelihood: p < 10⁻⁵ for each of about a hundred offsets.
const GAIN: f64 = 30.0;
/// Half of the 95 % interval of an offset is where −2 ln of the likelihood is this much larger (χ² with one degree of freedom).
const INTERVAL: f64 = 3.84;
/// Smallest offset that is reported, s, and in intervals of the log: a reading may be taken at any time within an interval.
const LEAST_S: f64 = 60.0;
const LEAST_ROWS: f64 = 2.0;
/// These limits for an offset that may be a time constant: most bodies follow their sensor within minutes.
const DOUBTFUL_S: f64 = 300.0;
/// Smallest share of rows in which a sensor has a reading, and maximum number of sensors.
const KNOWN: f64 = 0.9;
const SENSORS: usize = 8;

/// A column of a log: known values with their times, s.
struct LogColumn {
    name: String,
    times: Vec<f64>,
    /// The values followed with each of [`LAGS_S`].
    followed: Vec<Vec<f64>>,
    values: Vec<f64>,
}

impl LogColumn {
    fn new(name: &str, times: &[f64], values: &[f64]) -> Option<LogColumn> {
        let known: Vec<(f64, f64)> =
            times.iter().copied().zip(values.iter().copied()).filter(|(_, value)| value.is_finite()).collect();
        let is_known = known.len() as f64 >= KNOWN * times.len() as f64;
        let (times, values): (Vec<f64>, Vec<f64>) = known.into_iter().unzip();
        let first = values.first()?;
        let is_usable = is_known && values.iter().any(|value| value != first);
        let followed = LAGS_S.iter().map(|&lag_s| follow(&times, &values, lag_s)).collect();
        is_usable.then(|| LogColumn { name: name.to_owned(), times, followed, values })
    }

    /// Times of the first and last value, s.
    fn range(&self) -> [f64; 2] {
        [self.times.first(), self.times.last()].map(|time| time.copied().unwrap_or(0.0))
    }

    /// Values at a time, linear in between.
    fn at(&self, values: &[f64], time_s: f64) -> f64 {
        let next = self.times.partition_point(|time| *time < time_s).clamp(1, self.times.len().max(2) - 1);
        let [from, to] = [self.times[next - 1], self.times[next]];
        let share = if to > from { ((time_s - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        values[next - 1] + share * (values[next] - values[next - 1])
    }
}

/// Means of five values with the weights 1 2 3 2 1; a gap takes no part. With the noise of a sensor, a body that follows it fits better than the sensor itself,
/// and the shift that fits best would be too large by the time constant.
fn smooth(values: &[f64]) -> Vec<f64> {
    let around = |row: usize| {
        let near = (row.saturating_sub(2)..(row + 3).min(values.len())).filter(|&other| values[other].is_finite());
        // Equal numbers of rows on both sides, so that the mean is not shifted.
        let is_paired = |other: &usize| {
            (2 * row).checked_sub(*other).is_some_and(|own| values.get(own).is_some_and(|own| own.is_finite()))
        };
        let (sum, whole) = near.filter(is_paired).fold((0.0, 0.0), |(sum, whole), other| {
            let weight = 3.0 - row.abs_diff(other) as f64;
            (sum + weight * values[other], whole + weight)
        });
        if values[row].is_finite() { sum / whole } else { f64::NAN }
    };
    (0..values.len()).map(around).collect()
}

/// Values that follow others with a time constant, s, from equilibrium at the first one.
fn follow(times: &[f64], values: &[f64], lag_s: f64) -> Vec<f64> {
    let mut at = values.first().copied().unwrap_or(0.0);
    let mut out = vec![at];
    for (times, values) in times.windows(2).zip(values.windows(2)) {
        let fade = if lag_s > 0.0 { (-(times[1] - times[0]) / lag_s).exp() } else { 0.0 };
        let drive = if lag_s > 0.0 { f64::midpoint(values[0], values[1]) } else { values[1] };
        at = drive + (at - drive) * fade;
        out.push(at);
    }
    out
}

/// Readings of one channel that drift: time, s, value in units of the noise, and repetition of each.
struct DriftSeries {
    times: Vec<f64>,
    values: Vec<f64>,
    groups: Vec<usize>,
    count: usize,
}

impl DriftSeries {
    /// The channel with the largest drift relative to its noise; `None` without a drift, or if its times do not increase.
    fn new(trail: &Trail, data: &DataSet) -> Option<DriftSeries> {
        let times: Vec<f64> = data.observations.iter().map(|one| one.t_s).collect::<Option<_>>()?;
        if times.len() < ROWS[0] || times.windows(2).any(|two| two[1] < two[0]) {
            return None;
        }
        let of = |channel: &ReadingTrail| {
            let is_used = |k: &usize| channel.left[*k].is_finite() && channel.group[*k] < channel.groups;
            let used: Vec<usize> = (0..channel.at.len()).filter(is_used).collect();
            let drift = DriftSeries {
                times: used.iter().map(|&k| times[channel.at[k].0]).collect(),
                values: used.iter().map(|&k| channel.value[k] / channel.noise).collect(),
                groups: used.iter().map(|&k| channel.group[k]).collect(),
                count: channel.groups,
            };
            let values = drift.relative(&drift.values, &(0..used.len()).collect::<Vec<_>>());
            let size = (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt();
            (used.len() >= ROWS[0]).then_some((size, drift))
        };
        let all = trail.channels.iter().filter(|channel| !channel.at.is_empty()).filter_map(of);
        let (size, drift) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (size > DRIFT).then(|| drift.thinned())
    }

    fn thinned(self) -> DriftSeries {
        let step = self.times.len().div_ceil(ROWS[1]).max(1);
        DriftSeries {
            times: self.times.into_iter().step_by(step).collect(),
            values: self.values.into_iter().step_by(step).collect(),
            groups: self.groups.into_iter().step_by(step).collect(),
            count: self.count,
        }
    }

    /// Values of some rows relative to the means of their repetitions.
    fn relative(&self, values: &[f64], rows: &[usize]) -> Vec<f64> {
        let mut means = vec![[0.0; 2]; self.count];
        for &row in rows {
            let mean = &mut means[self.groups[row]];
            *mean = [mean[0] + values[row], mean[1] + 1.0];
        }
        rows.iter().map(|&row| values[row] - means[self.groups[row]][0] / means[self.groups[row]][1]).collect()
    }

    /// Rows whose times are within a log that is shifted.
    fn rows(&self, [first, last]: [f64; 2], by_s: f64) -> Vec<usize> {
        (0..self.times.len()).filter(|&row| (first..=last).contains(&(self.times[row] + by_s))).collect()
    }

    /// The best fit of some rows by courses, shifted, with these followers.
    fn fitted(&self, rows: &[usize], courses: &[&LogColumn], followers: &FollowerSet, by_s: f64) -> Option<LogFit> {
        let values = self.relative(&self.values, rows);
        let columns: Vec<Vec<f64>> = courses
            .iter()
            .flat_map(|course| {
                let followed: Vec<Vec<f64>> = match followers {
                    FollowerSet::All => course.followed.clone(),
                    FollowerSet::Rich => {
                        let once = |lag_s: f64| follow(&course.times, &course.values, lag_s);
                        let lags = RICH_LAGS_S.iter().copied();
                        let twice = lags.clone().filter(|lag_s| *lag_s > 0.0);
                        let twice = twice.map(|lag_s| follow(&course.times, &once(lag_s), lag_s));
                        lags.map(once).chain(twice).collect()
                    }
                    FollowerSet::One(lag_s) => vec![follow(&course.times, &course.values, *lag_s)],
                };
                followed.into_iter().map(|values| {
                    let at: Vec<f64> = self.times.iter().map(|time| course.at(&values, time + by_s)).collect();
                    self.relative(&at, rows)
                })
            })
            .filter(|column| column.iter().any(|value| *value != 0.0))
            .collect();
        let amounts = ColumnProducts::new(&columns, &values, 0..rows.len()).amounts()?;
        let left = residuals(&columns, &values, &amounts, 0..rows.len());
        let whole = values.iter().map(|value| value * value).sum();
        Some(LogFit {
            squares: left.iter().map(|left| left * left).sum(),
            whole,
            freedom: (rows.len() as f64 - columns.len() as f64).max(1.0),
            worth: worth(&left),
        })
    }
}

/// Bodies that follow a sensor.
enum FollowerSet {
    /// With all of [`LAGS_S`].
    All,
    /// With all of [`RICH_LAGS_S`], once and twice.
    Rich,
    /// One with this time constant, s.
    One(f64),
}

/// Result of a fit.
struct LogFit {
    squares: f64,
    /// Squares of the readings.
    whole: f64,
    /// Number of readings minus that of columns.
    freedom: f64,
    /// Effective number of readings.
    worth: f64,
}

impl LogFit {
    /// Increase of −2 ln of the likelihood if a fit of the same readings with these squares takes its place.
    fn gain_over(&self, other: &LogFit) -> f64 {
        self.worth * (other.variance() / self.variance().max(f64::MIN_POSITIVE)).ln()
    }

    fn variance(&self) -> f64 {
        self.squares / self.freedom
    }

    fn share(&self) -> f64 {
        1.0 - self.squares / self.whole
    }
}

/// Effective number of readings: residuals that are correlated from one to the next count as fewer.
fn worth(left: &[f64]) -> f64 {
    let squares: f64 = left.iter().map(|left| left * left).sum();
    let products: f64 = left.windows(2).map(|two| two[0] * two[1]).sum();
    let rho = (products / squares.max(f64::MIN_POSITIVE)).clamp(0.0, 0.999);
    left.len() as f64 * (1.0 - rho) / (1.0 + rho)
}

/// A shift of a log with the half width of its 95 % interval, s. A positive one means that the clock of the log is ahead.
struct ClockShift<'a> {
    by_s: f64,
    by_95_s: f64,
    course: &'a LogColumn,
    rows: Vec<usize>,
    fitted: LogFit,
}

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, data) in view.sets() {
        let Some(trail) = view.trails.get(set).filter(|trail| trail.is_repeated) else { continue };
        let Some(drift) = DriftSeries::new(trail, data) else { continue };
        let sensors = view.sensors.get(set).map(Vec::as_slice).unwrap_or_default();
        let [temperatures, speeds] = courses(data, sensors);
        let both: Vec<&LogColumn> = temperatures.iter().chain(&speeds).collect();
        for own in [&temperatures, &speeds] {
            let columns: Vec<String> = own.iter().map(|course| course.name.clone()).collect();
            let own: Vec<&LogColumn> = own.iter().collect();
            if let Some((what, evidence, by_s)) = offset(&drift, &own, &both) {
                let name = if columns.len() > 1 { "temperatures".into() } else { columns.join(" ") };
                let then = by_s.map_or(Then::Nothing, |by_s| shifted(data, columns, by_s));
                let rows = [0, data.observations.len().saturating_sub(1)];
                out.push(DataDefect { kind: DefectKind::Clock, set, name, what: what.into(), rows, evidence, then });
                break;
            }
        }
    }
}

/// The columns of the logs: temperatures, and the speed of the spindle.
fn courses(data: &DataSet, sensors: &[Sensor]) -> [Vec<LogColumn>; 2] {
    /// Column of the speed.
    const SPEED: &str = "spindle_rpm";
    let times: Vec<f64> = data.observations.iter().map(|one| one.t_s.unwrap_or(f64::NAN)).collect();
    let speed = data.drivers.iter().filter(|driver| driver.name == SPEED);
    [
        sensors
            .iter()
            .filter_map(|sensor| LogColumn::new(&sensor.name, &times, &smooth(&sensor.values)))
            .take(SENSORS)
            .collect(),
        speed.filter_map(|driver| LogColumn::new(&driver.name, &times, &driver.values)).collect(),
    ]
}

/// Description, evidence and, if it is certain, the offset of a log, s.
fn offset(drift: &DriftSeries, own: &[&LogColumn], all: &[&LogColumn]) -> Option<(&'static str, String, Option<f64>)> {
    let found = best(drift, own, &FollowerSet::All, &|_| true)?;
    let limit_s = LEAST_S.max(LEAST_ROWS * interval(&drift.times));
    // All sensors together need many columns, and few rows remain: each alone explains as much with fewer.
    let unshifted = |courses: &[&LogColumn]| -> Option<LogFit> {
        let together = drift.fitted(&found.rows, courses, &FollowerSet::Rich, 0.0);
        let alone = courses.iter().flat_map(|course| {
            [FollowerSet::All, FollowerSet::Rich].map(|set| drift.fitted(&found.rows, &[*course], &set, 0.0))
        });
        alone.chain([together]).flatten().min_by(|a, b| a.variance().total_cmp(&b.variance()))
    };
    let is_explained = found.fitted.share() > SHARE && found.by_s.abs() - found.by_95_s > limit_s;
    let before = if is_explained { unshifted(own) } else { None };
    let rms = |fitted: &LogFit| fitted.variance().sqrt();
    let is_better = |before: &LogFit| {
        found.fitted.gain_over(before) > GAIN
            && (found.fitted.share() > SURE_SHARE || rms(before) > SURE_RATIO * rms(&found.fitted))
    };
    if let Some(before) = before.filter(is_better) {
        let shown = format!(
            "with the log shifted by {}, {} explains {:.0} % of the drift, and the residual is {:.1} times the noise; without a shift it is {:.1} times, with any column and time constant",
            minutes(found.by_s, found.by_95_s),
            found.course.name,
            100.0 * found.fitted.share(),
            rms(&found.fitted),
            rms(&before)
        );
        let with_all = unshifted(all)?;
        if own.len() == all.len() || found.fitted.gain_over(&with_all) > GAIN {
            let side = if found.by_s > 0.0 { "ahead of that of the readings" } else { "behind that of the readings" };
            let evidence = format!("its clock is {side}: {shown}; correct t_s of the log, or its clock");
            return Some(("clock offset", evidence, Some(found.by_s)));
        }
        // Two logs that explain the drift equally: one of them may have another clock.
        let evidence =
            format!("{shown}; the other log explains the drift as well, so nothing is shifted: compare both clocks");
        let is_equal = with_all.gain_over(&found.fitted) < GAIN / 2.0;
        return is_equal.then_some(("clock offset or an effect of the other log", evidence, None));
    }
    // Readings that follow the log late: one body with a time constant, or a shift.
    let late = best(drift, own, &FollowerSet::One(0.0), &|by_s| by_s < 0.0)?;
    let with = |lag_s: f64| drift.fitted(&late.rows, &[late.course], &FollowerSet::One(lag_s), 0.0);
    let at_once = with(0.0)?;
    let is_late = late.fitted.share() > SHARE
        && -late.by_s - late.by_95_s > DOUBTFUL_S.max(LEAST_ROWS * interval(&drift.times))
        && late.fitted.gain_over(&at_once) > GAIN;
    if !is_late {
        return None;
    }
    let (lag_s, lagged) = (0..ONE_LAGS)
        .map(|number| ONE_LAG_S * ONE_LAG_RATIO.powi(number))
        .filter_map(|lag_s| Some((lag_s, with(lag_s)?)))
        .min_by(|a, b| a.1.squares.total_cmp(&b.1.squares))?;
    // One time constant that explains as much is the usual case: a body that follows its sensor.
    let is_doubtful = late.fitted.gain_over(&lagged) > GAIN / 2.0;
    let evidence = format!(
        "the readings follow {} late: the clock of the log is late by {}, or several bodies follow in series, with a time constant of about {:.0} min; compare the clocks, or record a faster change of temperature",
        late.course.name,
        minutes(late.by_s, late.by_95_s),
        lag_s / 60.0
    );
    is_doubtful.then_some(("clock offset or time constant", evidence, None))
}

/// Usual interval of rows, s.
fn interval(times: &[f64]) -> f64 {
    super::median(times.windows(2).map(|two| two[1] - two[0]).collect())
}

/// A time for people, without a sign.
fn minutes(by_s: f64, by_95_s: f64) -> String {
    format!("{:.1} ± {:.1} min", by_s.abs() / 60.0, by_95_s / 60.0)
}

/// The shift of the sensor that explains the readings best with the shift that improves it most; `None` if it is at the end of the search, or the readings
/// do not determine it.
fn best<'a>(
    drift: &DriftSeries,
    courses: &[&'a LogColumn],
    followers: &FollowerSet,
    is_allowed: &(dyn Fn(f64) -> bool + Sync),
) -> Option<ClockShift<'a>> {
    let of = |course: &&'a LogColumn| -> Option<(LogFit, f64, &'a LogColumn, Vec<usize>)> {
        let course = *course;
        let [first, last] = course.range();
        let most_s = MOST_S.min(MOST_SHARE * (last - first));
        let gain = |by_s: f64| -> Option<f64> {
            let rows = drift.rows(course.range(), by_s);
            let shifted = drift.fitted(&rows, &[course], followers, by_s)?;
            Some(shifted.gain_over(&drift.fitted(&rows, &[course], followers, 0.0)?))
        };
        let mut step = most_s / f64::from(STEPS[0]);
        let highest = |middle: f64, step: f64, count: i32| {
            let all = (-count..=count).map(|k| middle + f64::from(k) * step).filter(|by_s| is_allowed(*by_s));
            all.filter_map(|by_s| Some((gain(by_s)?, by_s))).max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let (_, mut by_s) = highest(0.0, step, STEPS[0])?;
        if by_s.abs() > most_s - 0.5 * step {
            return None;
        }
        for _ in 0..PASSES {
            let finer = step / f64::from(STEPS[1]);
            (_, by_s) = highest(by_s, finer, STEPS[1])?;
            step = finer;
        }
        let rows = drift.rows(course.range(), by_s);
        Some((drift.fitted(&rows, &[course], followers, by_s)?, by_s, course, rows))
    };
    let all = in_parts(courses, &of);
    let (fitted, by_s, course, rows) = all.into_iter().flatten().max_by(|a, b| a.0.share().total_cmp(&b.0.share()))?;
    // The rows of the best shift that a slightly different one has too.
    let width = |sense: f64| {
        let mut far = 1.0;
        while far < MOST_S {
            let other = by_s + sense * far;
            let within = drift.rows(course.range(), other);
            let common: Vec<usize> = rows.iter().copied().filter(|row| within.binary_search(row).is_ok()).collect();
            let [own, other] = [by_s, other].map(|by_s| drift.fitted(&common, &[course], followers, by_s));
            if own?.gain_over(&other?) > INTERVAL {
                return Some(far);
            }
            far *= 1.25;
        }
        None
    };
    // A reading of the log may be taken at any time within an interval.
    let by_95_s = width(1.0)?.max(width(-1.0)?).hypot(interval(&course.times));
    Some(ClockShift { by_s, by_95_s, course, rows, fitted })
}

/// The consequence: the log is shifted, and rows outside it do not count.
fn shifted(data: &DataSet, columns: Vec<String>, by_s: f64) -> Then {
    let times: Vec<f64> = data.observations.iter().filter_map(|one| one.t_s).collect();
    let [first, last] = [times.first(), times.last()].map(|time| time.copied().unwrap_or(0.0));
    let is_outside = |row: &usize| !(first..=last).contains(&(times[*row] + by_s));
    let rows: Vec<usize> = (0..times.len()).filter(is_outside).collect();
    let pieces = rows.chunk_by(|one, next| one + 1 == *next);
    let uncounted = pieces.filter_map(|piece| Some([*piece.first()?, *piece.last()?])).collect();
    Then::ShiftLog(ShiftedLog { columns, by_s, uncounted })
}

/// Shifts columns of a measurement and the logs of its conditions.
pub(super) fn shift(set: &mut DataSet, log: &ShiftedLog) {
    let times: Vec<f64> = set.observations.iter().map(|one| one.t_s.unwrap_or(f64::NAN)).collect();
    for driver in set.drivers.iter_mut().filter(|driver| log.columns.contains(&driver.name)) {
        let Some(course) = LogColumn::new(&driver.name, &times, &driver.values) else { continue };
        let [first, last] = course.range();
        for (value, time) in driver.values.iter_mut().zip(&times) {
            let at = time + log.by_s;
            *value = if (first..=last).contains(&at) { course.at(&course.values, at) } else { f64::NAN };
        }
        let sensor = driver.name.strip_suffix("_C").unwrap_or(&driver.name);
        shift_readings(&mut set.conditions, sensor, -log.by_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_is_linear_between_its_values_and_its_followers_approach_them() {
        let course = LogColumn::new("T_C", &[0.0, 10.0, 20.0], &[20.0, 21.0, 25.0]).unwrap();
        assert_eq!(
            [-5.0, 0.0, 5.0, 12.5, 20.0, 30.0].map(|at| course.at(&course.values, at)),
            [20.0, 20.0, 20.5, 22.0, 25.0, 25.0]
        );
        // One time constant after a step from 0 to 1, which the log has within one second: 1 − 1/e.
        let times: Vec<f64> = (0..=300).map(f64::from).collect();
        let values: Vec<f64> = times.iter().map(|time| if *time > 0.0 { 1.0 } else { 0.0 }).collect();
        let at = follow(&times, &values, 300.0)[300];
        assert!((at - (1.0 - (-1.0_f64).exp())).abs() < 1e-3, "{at}");
    }
}
