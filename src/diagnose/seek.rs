//! What is sought by what is left, since there is too much of it to try each in full: periods in position and in time, chords of circles, shapes
//! without a name.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use super::cause::{Candidate, Values, circle, periodic, vibration};
use super::empirical::Empirical;
use super::scene::{NO_ROW, Scene, Through};
use super::sweep::Sweep;
use crate::geometry::Axis;
use crate::model::name::{DIRECTIONS, ErrorName};

/// Rows of which a first look is had.
const SOME: usize = 1500;
/// Frequencies times rows of a first look.
const WORK: f64 = 2e6;
/// Cycles within a run, at least: fewer are drift.
const CYCLES: f64 = 8.0;
/// Slower than this nothing vibrates, s.
const SLOWEST: f64 = 20.0;
/// Chords of a circle that are tried.
const CHORDS: std::ops::Range<u32> = 24..720;
/// All directions of the tool.
const TIPS: [Through; 3] = [Through::Tip(0), Through::Tip(1), Through::Tip(2)];

/// Factors of places by reading.
pub(super) type Factors = HashMap<Through, Arc<Vec<f64>>>;

/// All of it.
#[derive(Clone, Debug)]
pub(super) struct Seek {
    sweeps: Vec<(Axis, Sweep)>,
    time: Option<Clock>,
    circles: Option<(Values, Values)>,
    empirical: Empirical,
}

/// Rows by runs with times.
#[derive(Clone, Debug)]
struct Clock {
    /// Of each row: its run, when.
    rows: Vec<(usize, f64)>,
    /// Runs of a first look.
    some: Vec<bool>,
    length: f64,
    fastest: f64,
}

impl Seek {
    pub(super) fn new(scene: &Scene<'_>) -> Seek {
        let linear = scene.machine.axes.iter().flatten().map(|data| data.axis).filter(|axis| !axis.is_rotary());
        let place =
            |item: &super::scene::Item, axis| scene.rows.get(item.row).map_or(f64::NAN, |row| row.position[axis]);
        let sweep = |axis| {
            let positions: Vec<f64> = scene.items.iter().map(|item| place(item, axis)).collect();
            Some((axis, Sweep::new(&positions)?))
        };
        Seek {
            sweeps: linear.filter_map(sweep).collect(),
            time: Clock::new(scene),
            circles: circle::angles(scene),
            empirical: Empirical::new(scene),
        }
    }

    /// The range of the positions of an axis whose periods are sought.
    pub(super) fn travel(&self, axis: Axis) -> Option<f64> {
        self.sweeps.iter().find(|(own, _)| *own == axis).map(|(_, sweep)| sweep.travel())
    }

    /// Where all of this comes in.
    pub(super) fn places(&self) -> Vec<Through> {
        let names =
            self.sweeps.iter().flat_map(|(axis, _)| DIRECTIONS.map(|direction| ErrorName::motion(direction, *axis)));
        let mut places: Vec<Through> = names.map(Through::Component).chain(TIPS).collect();
        places.extend(&self.empirical.places);
        places.extend(self.circles.as_ref().map(|_| Through::Reading(false)));
        places
    }

    /// How many candidates that are.
    pub(super) fn count(&self) -> usize {
        let sweeps: usize = self.sweeps.iter().map(|(_, sweep)| sweep.count() * DIRECTIONS.len()).sum();
        let time = self.time.as_ref().map_or(0, |clock| 3 * clock.count());
        let chords = if self.circles.is_some() { CHORDS.len() } else { 0 };
        sweeps + time + chords + self.empirical.count()
    }

    /// The most promising of each for what is left, unwhitened, with 1/σ of the readings and what a column must explain.
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
        std::thread::scope(|scope| {
            let shapes = scope.spawn(|| self.empirical.propose(&own, left, weights, price));
            let mut out = self.named(scene, factors, left, weights);
            out.extend(shapes.join().unwrap_or_default());
            out
        })
    }

    /// Periods and chords.
    fn named(&self, scene: &Scene<'_>, factors: &Factors, left: &[f64], weights: &[f64]) -> Vec<Candidate> {
        let mut out = Vec::new();
        let products = |place: Through| -> Vec<f64> {
            factors.get(&place).map_or_else(Vec::new, |factors| {
                left.iter().zip(factors.iter()).map(|(left, factor)| left * factor).collect()
            })
        };
        for (axis, sweep) in &self.sweeps {
            for name in DIRECTIONS.map(|direction| ErrorName::motion(direction, *axis)) {
                out.push(periodic::candidate(name, *axis, sweep.best(&products(Through::Component(name)))));
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
        if let Some((angles, radii)) = &self.circles {
            let mut information = vec![0.0; scene.rows.len()];
            let place = Through::Reading(false);
            if let Some(factors) = factors.get(&place) {
                for ((item, factor), weight) in scene.items.iter().zip(factors.iter()).zip(weights) {
                    if item.row != NO_ROW {
                        information[item.row] += (factor * weight).powi(2);
                    }
                }
            }
            let sums = by_row(products(place));
            let at = |values: &Values, row: &super::row::Row| {
                values.get(row.set).and_then(|own| own.get(row.number)).copied().unwrap_or(f64::NAN)
            };
            let step = (scene.rows.len() / SOME).max(1);
            let rows: Vec<[f64; 4]> = scene
                .rows
                .iter()
                .zip(sums.iter().zip(&information))
                .map(|(row, (sum, information))| [at(angles, row), at(radii, row), *sum, *information])
                .filter(|row| row[0].is_finite() && row[3] > 0.0)
                .step_by(step)
                .collect();
            // Chords are as far within as they are: their amount is one.
            let gain = |count: u32| -> f64 {
                let one = |[angle, radius, sum, information]: &[f64; 4]| {
                    let shape = radius * circle::chord(*angle, count);
                    2.0 * sum * shape - information * shape * shape
                };
                rows.iter().map(one).sum()
            };
            let best = CHORDS.map(|count| (gain(count), count)).max_by(|a, b| a.0.total_cmp(&b.0));
            out.extend(best.filter(|(gain, _)| *gain > 0.0).and_then(|(_, count)| circle::chords(scene, count)));
        }
        out
    }
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
        // Runs from all over, until there are enough rows.
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
        let seen = (rows.len() as f64 * share).max(1.0);
        let fastest = (1.0 / (2.2 * step)).min(WORK / seen / (3.0 * length));
        (fastest * length > CYCLES && fastest * SLOWEST > 1.0).then_some(Clock { rows, some, length, fastest })
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

    /// The frequency that explains most, Hz: first of all runs each for itself, then of more and more of the time together.
    fn best(&self, sums: &[f64]) -> Option<f64> {
        let runs = self.some.len();
        let powers = |frequency: f64| {
            let mut waves = vec![[0.0; 2]; runs];
            for ((run, time), sum) in self.rows.iter().zip(sums) {
                if *sum != 0.0 && self.some[*run] {
                    let (sine, cosine) = (TAU * frequency * time).sin_cos();
                    waves[*run][0] += sum * sine;
                    waves[*run][1] += sum * cosine;
                }
            }
            waves.into_iter().map(|[sine, cosine]| sine * sine + cosine * cosine).collect::<Vec<f64>>()
        };
        let grid = (0..self.count()).map(|k| self.slowest() + k as f64 * self.step());
        let (_, mut frequency) = grid
            .map(|frequency| (powers(frequency).iter().sum::<f64>(), frequency))
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        let own = powers(frequency);
        let strongest = (0..runs).max_by(|&a, &b| own[a].total_cmp(&own[b]))?;
        let of_run: Vec<f64> = self.rows.iter().filter(|(run, _)| *run == strongest).map(|(_, time)| *time).collect();
        let middle = f64::midpoint(*of_run.first()?, *of_run.last()?);
        let whole = self.rows.iter().map(|(_, time)| (time - middle).abs()).fold(0.0, f64::max);
        let mut half = self.length / 2.0;
        loop {
            let power = |frequency: f64| {
                let (mut sines, mut cosines) = (0.0, 0.0);
                for ((_, time), sum) in self.rows.iter().zip(sums) {
                    if *sum != 0.0 && (time - middle).abs() <= half {
                        let (sine, cosine) = (TAU * frequency * (time - middle)).sin_cos();
                        sines += sum * sine;
                        cosines += sum * cosine;
                    }
                }
                sines * sines + cosines * cosines
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
