//! Readings of one sensor over time, linear between readings, constant outside.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// Maximum number of time constants whose lagged temperatures are cached.
const MOST_KEPT: usize = 32;
/// Traces with fewer readings are evaluated from the beginning every time.
const SHORT: usize = 8;

/// Readings in order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConditionLog {
    /// Time, s, and temperature, °C.
    points: Vec<(f64, f64)>,
    followers: Followers,
}

/// Cache of lagged temperatures at each reading, by time constant: a trace is queried at thousands of instants.
#[derive(Clone, Default)]
struct Followers(Arc<Mutex<Vec<Follower>>>);

/// Time constant, s, and lagged temperatures, °C.
type Follower = (f64, Arc<[f64]>);

impl Followers {
    /// Returns the values for a time constant; `make` computes them if they are not cached.
    fn with(&self, lag_s: f64, make: impl FnOnce() -> Vec<f64>) -> Arc<[f64]> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, found)) = kept.iter().find(|(known_s, _)| *known_s == lag_s) {
            return Arc::clone(found);
        }
        if kept.len() >= MOST_KEPT {
            kept.remove(0);
        }
        let made: Arc<[f64]> = make().into();
        kept.push((lag_s, Arc::clone(&made)));
        made
    }

    /// Forgets the cache. Copies of readings may diverge, so the cache of one is not valid for the other.
    fn forget(&mut self) {
        if Arc::strong_count(&self.0) > 1 || self.0.lock().is_ok_and(|kept| !kept.is_empty()) {
            *self = Followers::default();
        }
    }
}

impl fmt::Debug for Followers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Followers")
    }
}

impl PartialEq for Followers {
    fn eq(&self, _: &Followers) -> bool {
        // The cache follows from the readings.
        true
    }
}

impl ConditionLog {
    /// Adds a reading. A reading older than the last one is ignored; one at the same time replaces it.
    pub fn add(&mut self, time_s: f64, temperature_c: f64) {
        self.followers.forget();
        match self.points.last_mut() {
            Some(last) if time_s < last.0 => {}
            Some(last) if time_s <= last.0 => last.1 = temperature_c,
            _ => self.points.push((time_s, temperature_c)),
        }
    }

    /// Returns the readings: time, s, and temperature, °C.
    #[must_use]
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }

    /// Returns the temperature of a body that follows the readings with a time constant τ: τ dT′/dt = T − T′, in equilibrium at the first reading. The
    /// solution is exact for the straight lines between readings. With T = a + b s and s from the beginning of a line, T′ = a + b (s − τ) + (T′₀ − a + b τ)
    /// exp(−s/τ). `None` without readings.
    #[must_use]
    pub fn lagged(&self, time_s: f64, lag_s: f64) -> Option<f64> {
        if self.points.len() > SHORT && time_s.is_finite() {
            let next = self.next(time_s);
            let Some(before) = next.checked_sub(1) else { return self.points.first().map(|&(_, first)| first) };
            if lag_s > 0.0 && self.points.get(next).is_some_and(|&(at_s, _)| at_s == time_s) {
                return self.at_readings(lag_s).get(next).copied();
            }
            let &(from_s, from) = self.points.get(before)?;
            let slope = self.points.get(next).map_or(0.0, |&(to_s, to)| (to - from) / (to_s - from_s));
            let start = if lag_s > 0.0 { *self.at_readings(lag_s).get(before)? } else { from };
            return Some(follow(start, from, slope, time_s - from_s, lag_s));
        }
        let mut follower = self.points.first()?.1;
        for pair in self.points.windows(2) {
            let [(from_s, from), (to_s, to)] = [pair[0], pair[1]];
            if from_s >= time_s {
                break;
            }
            let (passed_s, slope) = (time_s.min(to_s) - from_s, (to - from) / (to_s - from_s));
            follower = follow(follower, from, slope, passed_s, lag_s);
        }
        let &(last_s, last) = self.points.last()?;
        Some(if time_s > last_s { follow(follower, last, 0.0, time_s - last_s, lag_s) } else { follower })
    }

    /// Returns the index of the first reading that is not before a time. Most logs are evenly spaced, so the index is estimated first, then searched.
    fn next(&self, time_s: f64) -> usize {
        let is_next = |next: usize| {
            let at_s = |place: usize| self.points.get(place).map(|&(at_s, _)| at_s);
            let begins = next.checked_sub(1).is_none_or(|before| at_s(before).is_some_and(|at_s| at_s < time_s));
            begins && at_s(next).is_none_or(|at_s| at_s >= time_s)
        };
        if let [(first_s, _), .., (last_s, _)] = self.points[..] {
            let share = (time_s - first_s) / (last_s - first_s);
            // An invalid index saturates and does not match.
            let near = (share * (self.points.len() - 1) as f64).round() as usize;
            if let Some(next) = [near, near.saturating_add(1)].into_iter().find(|&next| is_next(next)) {
                return next;
            }
        }
        self.points.partition_point(|&(from_s, _)| from_s < time_s)
    }

    /// Returns the lagged temperatures at each reading.
    fn at_readings(&self, lag_s: f64) -> Arc<[f64]> {
        self.followers.with(lag_s, || {
            let times_s: Vec<f64> = self.points.iter().map(|&(time_s, _)| time_s).collect();
            self.lagged_at(&times_s, lag_s)
        })
    }

    /// Returns [`ConditionLog::lagged`] at many times in one pass; the times must not decrease. Empty without readings.
    #[must_use]
    pub fn lagged_at(&self, times_s: &[f64], lag_s: f64) -> Vec<f64> {
        let Some(&(mut from_s, mut from)) = self.points.first() else { return Vec::new() };
        let mut follower = from;
        let mut next = 1;
        let mut out = Vec::with_capacity(times_s.len());
        for &time_s in times_s {
            while let Some(&(to_s, to)) = self.points.get(next).filter(|point| point.0 <= time_s) {
                follower = follow(follower, from, (to - from) / (to_s - from_s), to_s - from_s, lag_s);
                (from_s, from) = (to_s, to);
                next += 1;
            }
            let slope = self.points.get(next).map_or(0.0, |&(to_s, to)| (to - from) / (to_s - from_s));
            out.push(if time_s > from_s { follow(follower, from, slope, time_s - from_s, lag_s) } else { follower });
        }
        out
    }
}

/// Returns the lagged temperature after `passed_s` of a line.
fn follow(start: f64, from: f64, slope: f64, passed_s: f64, lag_s: f64) -> f64 {
    if lag_s > 0.0 {
        from + slope * (passed_s - lag_s) + (start - from + slope * lag_s) * (-passed_s / lag_s).exp()
    } else {
        from + slope * passed_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(points: &[(f64, f64)]) -> ConditionLog {
        let mut trace = ConditionLog::default();
        points.iter().for_each(|&(time_s, value)| trace.add(time_s, value));
        trace
    }

    #[test]
    fn without_a_lag_it_is_linear_between_readings() {
        let trace = trace(&[(0.0, 20.0), (10.0, 30.0), (20.0, 26.0)]);
        for (time_s, value) in [(-5.0, 20.0), (0.0, 20.0), (5.0, 25.0), (15.0, 28.0), (20.0, 26.0), (99.0, 26.0)] {
            assert_eq!(trace.lagged(time_s, 0.0), Some(value), "{time_s}");
        }
        assert_eq!(ConditionLog::default().lagged(0.0, 0.0), None);
    }

    #[test]
    fn a_lag_follows_the_differential_equation() {
        let trace = trace(&[(0.0, 20.0), (100.0, 40.0), (400.0, 40.0)]);
        let (lag_s, step_s) = (60.0, 1e-3);
        let mut follower: f64 = 20.0;
        let mut time_s = 0.0;
        for at in [50.0, 100.0, 250.0, 600.0] {
            while time_s < at - 0.5 * step_s {
                // Midpoint rule.
                let input = |time_s: f64| trace.lagged(time_s, 0.0).unwrap();
                let middle = follower + 0.5 * step_s * (input(time_s) - follower) / lag_s;
                follower += step_s * (input(time_s + 0.5 * step_s) - middle) / lag_s;
                time_s += step_s;
            }
            assert!((trace.lagged(at, lag_s).unwrap() - follower).abs() < 1e-6, "{at}");
        }
    }

    #[test]
    fn many_times_in_one_pass_are_the_same() {
        let short = trace(&[(0.0, 20.0), (100.0, 40.0), (130.0, 41.0), (400.0, 38.0)]);
        let mut long = trace(&[(0.0, 20.0)]);
        (1..40).for_each(|k| long.add(10.0 * f64::from(k), 20.0 + f64::from(k * k % 17)));
        let mut uneven = trace(&[(0.0, 20.0)]);
        (1..40).for_each(|k| uneven.add(f64::from(k * k) / 4.0, 20.0 + f64::from(k * k % 17)));
        let times_s = [-10.0, 0.0, 3.0, 50.0, 100.0, 110.0, 250.0, 250.0, 400.0, 900.0];
        let lags_s: Vec<f64> = (0..50).map(f64::from).chain([60.0, 5000.0, 1.0]).collect();
        for (trace, lag_s) in
            [&short, &long, &uneven].into_iter().flat_map(|trace| lags_s.iter().map(move |&lag_s| (trace, lag_s)))
        {
            for (&time_s, value) in times_s.iter().zip(trace.lagged_at(&times_s, lag_s)) {
                assert!((trace.lagged(time_s, lag_s).unwrap() - value).abs() < 1e-12, "{time_s} {lag_s}");
            }
        }
        assert!(ConditionLog::default().lagged_at(&times_s, 1.0).is_empty());
    }

    #[test]
    fn a_reading_that_is_added_counts() {
        let mut trace = trace(&[]);
        (0..20).for_each(|k| trace.add(f64::from(k), 20.0));
        let copy = trace.clone();
        assert_eq!(trace.lagged(30.0, 5.0), Some(20.0));
        trace.add(20.0, 40.0);
        // 20 K/s from 19 s on: 20 K - 100 K + 100 K exp(-1/5), and then 40 °C for 10 s.
        let at_20 = 20.0 + 20.0 - 100.0 + 100.0 * f64::exp(-0.2);
        let expected = 40.0 + (at_20 - 40.0) * f64::exp(-2.0);
        assert!((trace.lagged(30.0, 5.0).unwrap() - expected).abs() < 1e-12);
        assert_eq!(copy.lagged(30.0, 5.0), Some(20.0));
    }

    #[test]
    fn older_readings_are_left_out() {
        assert_eq!(trace(&[(0.0, 1.0), (5.0, 2.0), (3.0, 9.0), (5.0, 4.0)]).points(), [(0.0, 1.0), (5.0, 4.0)]);
    }

    #[test]
    fn copies_that_go_different_ways_have_followers_of_their_own() {
        // Long enough for caching, and not queried before the readings come.
        let mut both = vec![ConditionLog::default(); 2];
        for k in 0..20 {
            both[0].add(f64::from(k), 20.0);
            both[1].add(f64::from(k), 20.0 + f64::from(k));
        }
        assert!((both[0].lagged(19.0, 5.0).unwrap() - 20.0).abs() < 1e-12);
        // A ramp of 1 K/s from equilibrium: 20 + t − τ + τ exp(−t/τ).
        let expected = 20.0 + 19.0 - 5.0 + 5.0 * (-19.0_f64 / 5.0).exp();
        assert!((both[1].lagged(19.0, 5.0).unwrap() - expected).abs() < 1e-9);
    }
}
