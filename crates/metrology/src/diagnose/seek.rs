//! Screening for candidates that are too many to fit each one: periods in position and in time, chords of circles, unnamed shapes.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use super::cause::{Candidate, circle, drift, periodic, vibration};
use super::circles::Circles;
use super::empirical::Empirical;
use super::event::Events;
use super::scene::{NO_ROW, Scene, Through};
use super::sweep::{self, FourierTransform, Sweep};
use ncfix_base::geometry::Axis;
use ncfix_base::numeric::both;
use ncfix_model::name::{DIRECTIONS, ErrorName};

/// Number of rows in the first pass.
pub(super) const SOME: usize = 1500;
/// Maximum number of cycles within a run.
const MOST_CYCLES: f64 = 1000.0;
/// Number of bins for a cycle of the highest frequency.
const PER_CYCLE: f64 = 8.0;
/// Length of the transform as a multiple of a run; the rest is zero.
const PADDED: usize = 4;
/// Number of sections of a run.
const PIECES: f64 = 32.0;
/// Minimum number of cycles within a run: fewer are drift.
const CYCLES: f64 = 8.0;
/// Longest period of a vibration, s.
const SLOWEST: f64 = 20.0;
/// All directions of the tool.
const TIPS: [Through; 3] = [Through::Tip(0), Through::Tip(1), Through::Tip(2)];

/// Factors of each point, by reading.
pub(super) type Factors = HashMap<Through, Arc<Vec<f64>>>;

/// Data for all screenings; empty by default.
#[derive(Clone, Debug, Default)]
pub(super) struct Seek {
    sweeps: Vec<(Axis, Sweep)>,
    time: Option<Clock>,
    circles: Option<Circles>,
    events: Option<Events>,
    empirical: Empirical,
}

/// Rows grouped by runs with times.
#[derive(Clone, Debug)]
struct Clock {
    /// For each row: its run and its time.
    rows: Vec<(usize, f64)>,
    /// Start of each run.
    starts: Vec<f64>,
    /// Runs of the first pass.
    some: Vec<bool>,
    length: f64,
    fastest: f64,
    transform: FourierTransform,
}

impl Seek {
    pub(super) fn new(scene: &Scene<'_>) -> Seek {
        let linear = scene.machine.axes.iter().flatten().map(|data| data.axis).filter(|axis| !axis.is_rotary());
        let place = |item: &super::scene::SceneReading, axis| {
            scene.rows.get(item.row).map_or(f64::NAN, |row| row.position[axis])
        };
        let sweep = |axis| {
            let positions: Vec<f64> = scene.items.iter().map(|item| place(item, axis)).collect();
            Some((axis, Sweep::new(&positions)?))
        };
        Seek {
            sweeps: linear.filter_map(sweep).collect(),
            time: Clock::new(scene),
            circles: Circles::new(scene),
            events: Events::new(scene),
            empirical: Empirical::new(scene),
        }
    }

    /// Positions of an axis that are screened for periods.
    pub(super) fn sweep(&self, axis: Axis) -> Option<&Sweep> {
        self.sweeps.iter().find(|(own, _)| *own == axis).map(|(_, sweep)| sweep)
    }

    /// Points at which all these candidates act.
    pub(super) fn places(&self) -> Vec<Through> {
        let names =
            self.sweeps.iter().flat_map(|(axis, _)| DIRECTIONS.map(|direction| ErrorName::motion(direction, *axis)));
        let mut places: Vec<Through> = names.map(Through::Component).chain(TIPS).collect();
        places.extend(&self.empirical.places);
        places.extend(self.circles.as_ref().map(|_| Through::Reading(false)));
        places
    }

    /// Number of these candidates.
    pub(super) fn count(&self) -> usize {
        let sweeps: usize = self.sweeps.iter().map(|(_, sweep)| sweep.count() * DIRECTIONS.len()).sum();
        let time = self.time.as_ref().map_or(0, |clock| 3 * clock.count());
        let chords = self.circles.as_ref().map_or(0, Circles::count);
        let events = self.events.as_ref().map_or(0, |events| TIPS.len() * events.count());
        sweeps + time + chords + events + self.empirical.count()
    }

    /// Returns the most promising candidate of each kind for an unwhitened residual, with 1/σ of the readings and the minimum that a column must explain.
    pub(super) fn propose(
        &self,
        scene: &Scene<'_>,
        factors: &Factors,
        left: &[f64],
        weights: &[f64],
        price: f64,
    ) -> Vec<Candidate> {
        let nothing = Arc::new(Vec::new());
        let own: Vec<Arc<Vec<f64>>> =
            self.empirical.places.iter().map(|place| Arc::clone(factors.get(place).unwrap_or(&nothing))).collect();
        let shapes = || self.empirical.propose(&own, left, weights, price);
        let (mut out, shapes) = both(|| self.named(scene, factors, left, weights), shapes);
        out.extend(shapes);
        out
    }

    /// Returns periods and chords.
    fn named(&self, scene: &Scene<'_>, factors: &Factors, left: &[f64], weights: &[f64]) -> Vec<Candidate> {
        let mut out = Vec::new();
        let products = |place: Through| -> Vec<f64> {
            factors.get(&place).map_or_else(Vec::new, |factors| {
                left.iter().zip(factors.iter()).map(|(left, factor)| left * factor).collect()
            })
        };
        let by_reading = |place: Through| -> Vec<f64> { information_of(factors, place, weights) };
        for (axis, sweep) in &self.sweeps {
            for name in DIRECTIONS.map(|direction| ErrorName::motion(direction, *axis)) {
                let place = Through::Component(name);
                let period = sweep.best(&products(place), &by_reading(place));
                out.extend(period.map(|period| periodic::candidate(name, *axis, period)));
            }
        }
        let by_row = |products: Vec<f64>| {
            let mut sums = vec![0.0; scene.rows.len()];
            for (item, product) in scene.items.iter().zip(products) {
                if item.row != NO_ROW {
                    sums[item.row] += product;
                }
            }
            sums
        };
        if let Some(clock) = &self.time {
            for (direction, place) in TIPS.into_iter().enumerate() {
                let found = clock.best(&by_row(products(place)));
                out.extend(found.map(|frequency| vibration::candidate(direction, frequency)));
            }
        }
        let information = |place: Through| by_row(by_reading(place));
        if let Some(events) = &self.events {
            for (direction, place) in TIPS.into_iter().enumerate() {
                let found = events.best(&by_row(products(place)), &information(place));
                out.extend(found.map(|event| drift::behind(direction, event.set, event.instant, event.fade)));
            }
        }
        if let Some(circles) = &self.circles {
            let place = Through::Reading(false);
            let information = information(place);
            let sums = by_row(products(place));
            out.extend(circles.best(&sums, &information).map(|count| circle::chords(&circles.places, count)));
            let lobes = circles.best_lobes(&sums, &information).into_iter();
            out.extend(lobes.map(|one| circle::lobes(&circles.places, &one.planes, one.count, one.are_alike)));
        }
        out
    }
}

/// Information of each reading about a deviation at a point: squares of factor times 1/σ.
pub(super) fn information_of(factors: &Factors, place: Through, weights: &[f64]) -> Vec<f64> {
    let of = |factors: &Arc<Vec<f64>>| {
        factors.iter().zip(weights).map(|(factor, weight)| (factor * weight).powi(2)).collect()
    };
    factors.get(&place).map_or_else(Vec::new, of)
}

impl Clock {
    fn new(scene: &Scene<'_>) -> Option<Clock> {
        let rows: Option<Vec<(usize, f64)>> = scene.rows.iter().map(|row| Some((row.sequence, row.time_s?))).collect();
        let rows = rows?;
        let runs = rows.iter().map(|(run, _)| run + 1).max()?;
        let mut spans = vec![(f64::INFINITY, f64::NEG_INFINITY, 0_usize); runs];
        for &(run, time) in &rows {
            let span = &mut spans[run];
            *span = (span.0.min(time), span.1.max(time), span.2 + 1);
        }
        let mut lengths: Vec<f64> = spans.iter().filter(|span| span.2 > 15).map(|span| span.1 - span.0).collect();
        lengths.sort_by(f64::total_cmp);
        let length = *lengths.get(lengths.len() / 2)?;
        let mut steps: Vec<f64> = rows
            .windows(2)
            .filter(|pair| pair[0].0 == pair[1].0)
            .map(|pair| pair[1].1 - pair[0].1)
            .filter(|step| *step > 0.0)
            .collect();
        steps.sort_by(f64::total_cmp);
        let step = *steps.get(steps.len() / 4)?;
        if !(length > 0.0 && step > 0.0) {
            return None;
        }
        // Runs distributed over all data, until there are enough rows.
        let share = (SOME as f64 / rows.len() as f64).min(1.0);
        let mut sum = 1.0;
        let some = (0..runs)
            .map(|_| {
                sum += share;
                let is_in = sum >= 1.0;
                sum -= f64::from(u8::from(is_in));
                is_in
            })
            .collect();
        let fastest = (1.0 / (2.2 * step)).min(MOST_CYCLES / length);
        let starts = spans.iter().map(|span| span.0).collect();
        let bins = (PER_CYCLE * fastest * length) as usize;
        let transform = FourierTransform::new((PADDED * bins.max(1)).next_power_of_two());
        (fastest * length > CYCLES && fastest * SLOWEST > 1.0).then_some(Clock {
            rows,
            starts,
            some,
            length,
            fastest,
            transform,
        })
    }

    fn step(&self) -> f64 {
        1.0 / (3.0 * self.length)
    }

    fn slowest(&self) -> f64 {
        (CYCLES / self.length).max(1.0 / SLOWEST)
    }

    fn count(&self) -> usize {
        ((self.fastest - self.slowest()) / self.step()).max(0.0) as usize + 1
    }

    /// Returns the frequency that explains most, Hz: first for some runs separately, then over longer and longer times.
    fn best(&self, sums: &[f64]) -> Option<f64> {
        let runs = self.starts.len();
        let step = 1.0 / (PER_CYCLE * self.fastest);
        let mut bins: Vec<Vec<f64>> = vec![Vec::new(); runs];
        for ((run, time), sum) in self.rows.iter().zip(sums) {
            if let Some(own) = bins.get_mut(*run).filter(|_| self.some.get(*run) == Some(&true) && *sum != 0.0) {
                let place = ((time - self.starts[*run]) / step).round() as usize;
                if place < self.transform.length() / PADDED {
                    own.resize(own.len().max(place + 1), 0.0);
                    own[place] += sum;
                }
            }
        }
        let hertz = 1.0 / (step * self.transform.length() as f64);
        let (from, until) = ((self.slowest() / hertz).ceil() as usize, (self.fastest / hertz) as usize);
        let mut powers = vec![0.0; until + 2];
        for own in bins.iter().filter(|own| !own.is_empty()) {
            let of_run = self.transform.powers(own, until + 2);
            powers.iter_mut().zip(of_run).for_each(|(sum, power)| *sum += power);
        }
        let mut frequency = hertz * sweep::top(&powers, from..until + 1);
        // Residual demodulated with this frequency, in short sections: a nearby frequency changes their phase slowly.
        let piece = self.length / PIECES;
        let mut pieces: Vec<(f64, [f64; 2])> = Vec::new();
        let mut last = (usize::MAX, 0);
        for ((run, time), sum) in self.rows.iter().zip(sums) {
            let number = ((time - self.starts[*run]) / piece) as usize;
            if (*run, number) != last {
                last = (*run, number);
                pieces.push((self.starts[*run] + (number as f64 + 0.5) * piece, [0.0; 2]));
            }
            if let Some((_, own)) = pieces.last_mut().filter(|_| *sum != 0.0) {
                let (sine, cosine) = (TAU * frequency * time).sin_cos();
                own[0] += sum * cosine;
                own[1] -= sum * sine;
            }
        }
        let size = |own: &[f64; 2]| own[0].hypot(own[1]);
        let strongest = pieces.iter().max_by(|a, b| size(&a.1).total_cmp(&size(&b.1)))?;
        let middle = strongest.0;
        let first = frequency;
        let whole = pieces.iter().map(|(time, _)| (time - middle).abs()).fold(0.0, f64::max);
        let mut half = self.length / 2.0;
        loop {
            let power = |frequency: f64| {
                let (mut real, mut imaginary) = (0.0, 0.0);
                for (time, own) in pieces.iter().filter(|(time, _)| (time - middle).abs() <= half) {
                    let (sine, cosine) = (TAU * (frequency - first) * (time - middle)).sin_cos();
                    real += own[0] * cosine + own[1] * sine;
                    imaginary += own[1] * cosine - own[0] * sine;
                }
                real * real + imaginary * imaginary
            };
            let near = (-6..=6).map(|k| frequency + f64::from(k) / (16.0 * half));
            frequency = near.map(|one| (power(one), one)).max_by(|a, b| a.0.total_cmp(&b.0))?.1;
            if half >= whole {
                return Some(frequency);
            }
            half = (half * 1.7).min(whole);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;

    #[test]
    fn a_vibration_is_found_at_its_frequency() {
        let machine = bench::machine();
        // 20 readings per second for 50 s, starting at a time that is not a multiple of the period.
        let time = |row: usize| 7.3 + 0.05 * row as f64;
        let cells: Vec<(f64, String)> = (0..1000).map(|row| (0.1 * row as f64, format!(",{}", time(row)))).collect();
        let cells: Vec<(f64, &str)> = cells.iter().map(|(x, t)| (*x, t.as_str())).collect();
        let sets = [bench::along_x(&machine, ",t_s", &cells)];
        let clock = Clock::new(&bench::scene(&machine, &sets)).unwrap();
        for hertz in [0.7, 2.93, 6.1] {
            let sums: Vec<f64> = (0..1000).map(|row| (TAU * hertz * time(row) + 0.4).sin()).collect();
            let found = clock.best(&sums).unwrap();
            assert!((found - hertz).abs() < 0.005, "{hertz}: {found}");
        }
    }
}
