//! Finds the time of an event whose effect decays. Tests all times and many time constants, in one pass over the rows for each time constant.

use super::cause;
use super::scene::Scene;

/// Number of time constants, and the shortest and longest as shares of the measured time.
const FADES: u32 = 24;
const SHORTEST: f64 = 0.01;
const LONGEST: f64 = 0.5;
/// Distinguishable candidates per shortest time constant: 1 + 1/2 + 1/4 … over the time constants, with times half a time constant apart.
const APART: f64 = 4.0;
/// Minimum number of rows before and after the event.
const FEWEST: usize = 5;

/// Rows with times for each measurement, in order of time.
#[derive(Clone, Debug)]
pub(super) struct Events {
    sets: Vec<Vec<(usize, f64)>>,
    fades: Vec<f64>,
    /// For each measurement and time constant: decay factor from each row to the next, 0 for the last row. Stored, because every search step uses it.
    left: Vec<Vec<Vec<f64>>>,
}

/// An event in one measurement.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeasurementEvent {
    pub(super) set: usize,
    /// Time of the event, s.
    pub(super) instant: f64,
    /// Time constant of the decay, s.
    pub(super) fade: f64,
}

impl Events {
    /// Returns `None` unless one pose is measured repeatedly: otherwise time and position are not separable.
    pub(super) fn new(scene: &Scene<'_>) -> Option<Events> {
        let [start, end] = cause::times(scene)?;
        if cause::axes(scene).filter(|&axis| cause::range(scene, axis).is_some()).count() > 1 {
            return None;
        }
        let mut sets: Vec<Vec<(usize, f64)>> = vec![Vec::new(); scene.sets.len()];
        for (number, row) in scene.rows.iter().enumerate() {
            if let (Some(rows), Some(time)) = (sets.get_mut(row.set), row.time_s) {
                rows.push((number, time));
            }
        }
        sets.iter_mut().for_each(|rows| rows.sort_by(|a, b| a.1.total_cmp(&b.1)));
        let growth = (LONGEST / SHORTEST).powf(1.0 / f64::from(FADES - 1));
        let fades = (0..FADES).map(|k| (end - start) * SHORTEST * growth.powi(k as i32)).collect();
        Some(Events::of(sets, fades))
    }

    fn of(sets: Vec<Vec<(usize, f64)>>, fades: Vec<f64>) -> Events {
        let between = |rows: &[(usize, f64)], fade: f64| {
            let pairs = rows.windows(2).map(|pair| (-(pair[1].1 - pair[0].1) / fade).exp());
            pairs.chain([0.0]).collect()
        };
        let left = sets.iter().map(|rows| fades.iter().map(|&fade| between(rows, fade)).collect()).collect();
        Events { sets, fades, left }
    }

    /// Number of distinguishable events: times closer than the time constant are not distinguishable.
    pub(super) fn count(&self) -> usize {
        self.sets.len() * (APART / SHORTEST) as usize
    }

    /// Returns the event that explains most in addition to a constant. Arguments, per row: sums of factor times residual, and sums of squared factors.
    pub(super) fn best(&self, sums: &[f64], information: &[f64]) -> Option<MeasurementEvent> {
        let of = |values: &[f64], row: usize| values.get(row).copied().unwrap_or(0.0);
        let mut best: Option<(f64, MeasurementEvent)> = None;
        for ((set, rows), faded) in self.sets.iter().enumerate().zip(&self.left) {
            let whole = rows.iter().map(|(row, _)| of(information, *row)).sum::<f64>();
            let level = rows.iter().map(|(row, _)| of(sums, *row)).sum::<f64>();
            if whole <= 0.0 {
                continue;
            }
            for (&fade, faded) in self.fades.iter().zip(faded) {
                // Sums over all rows from this one on, weighted by the decay.
                let (mut left, mut once, mut twice) = (0.0, 0.0, 0.0);
                for ((place, &(row, time)), &fades) in rows.iter().enumerate().zip(faded).rev() {
                    left = of(sums, row) + fades * left;
                    once = of(information, row) + fades * once;
                    twice = of(information, row) + fades * fades * twice;
                    let own = twice - once * once / whole;
                    if place < FEWEST || rows.len() - place < FEWEST || own <= 1e-6 * twice {
                        continue;
                    }
                    let gain = (left - once * level / whole).powi(2) / own;
                    if best.is_none_or(|(most, _)| gain > most) {
                        best = Some((gain, MeasurementEvent { set, instant: time, fade }));
                    }
                }
            }
        }
        best.map(|(_, event)| event)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_the_instant() {
        let rows: Vec<(usize, f64)> = (0..500).map(|k| (k, 60.0 * k as f64)).collect();
        let events = Events::of(vec![rows], vec![900.0, 1800.0, 3600.0]);
        let left: Vec<f64> =
            (0..500).map(|k| if k < 200 { 0.0 } else { (-60.0 * f64::from(k - 200) / 1800.0).exp() }).collect();
        let mean = left.iter().sum::<f64>() / 500.0;
        let left: Vec<f64> = left.iter().map(|value| value - mean).collect();
        let found = events.best(&left, &[1.0; 500]).unwrap();
        assert_eq!((found.instant, found.fade), (12_000.0, 1800.0));
    }
}
