//! One run whose readings have the opposite sign of the other runs at the same positions.
//!
//! Positions are compared with themselves, so no model is necessary. A machine that has become warmer, or a drift, can mirror errors that are linear
//! over a position: a run at 18 °C and two at 22 °C. So constant and linear parts are removed from each run, and only the others are evidence.
//!
//! A run may pass the positions in the opposite direction, and reversal errors mirror it. Then terms by direction, and by direction and position, are
//! removed as well. In a circle they have too many shapes, so circles are compared in one direction only.

use std::collections::{BTreeMap, BTreeSet};

use super::constant::columns;
use super::{DataDefect, DefectCheck, DefectKind, Then, View};
use crate::measure::data::{DataSet, Observation};
use crate::measure::kind::Measurand;
use ncfix_base::geometry::{AXES, AXIS_COUNT};
use ncfix_base::numeric::Series;
use ncfix_base::units::um_from_mm;

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "run with the opposite sign",
    made_by: "an instrument whose sign was changed between two runs, or a table that was joined from files of different signs",
    shown_by: "a run that differs from the other runs at the same positions, but agrees with them after its sign is changed",
    source: "repetition at the same positions (ISO 230-2)",
    look,
};

/// Minimum number of positions beyond the removed terms.
const FEWEST: usize = 8;
/// Largest mean squared difference of a run that agrees with the others, in squares of the noise.
const AGREES: f64 = 4.0;
/// Smallest mean squared difference of a run that contradicts them, in squares of the noise.
const CONTRADICTS: f64 = 9.0;
/// Smallest ratio of the squared differences with one sign to those with the other.
const WORSE: f64 = 9.0;
/// Minimum number of runs that show which one has the other sign.
const RUNS: usize = 3;

/// Differences of a run from the others.
#[derive(Clone, Copy, Debug, Default)]
struct Comparison {
    /// Sum of squares with the given sign, mm² or rad².
    as_is: f64,
    /// Same sum with the opposite sign.
    otherwise: f64,
    /// Number of positions beyond the removed terms.
    count: f64,
    /// Sum of the squares of the expected differences.
    noise: f64,
}

/// Meaning of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sign {
    Same,
    Opposite,
    Unknown,
}

impl Comparison {
    fn sign(&self) -> Sign {
        let agrees = |squares: f64| squares < AGREES * self.noise;
        let contradicts = |squares: f64, other: f64| squares > CONTRADICTS * self.noise && squares > WORSE * other;
        if self.count < FEWEST as f64 {
            Sign::Unknown
        } else if agrees(self.otherwise) && contradicts(self.as_is, self.otherwise) {
            Sign::Opposite
        } else if agrees(self.as_is) && contradicts(self.otherwise, self.as_is) {
            Sign::Same
        } else {
            Sign::Unknown
        }
    }

    fn add(&mut self, other: Comparison) {
        self.as_is += other.as_is;
        self.otherwise += other.otherwise;
        self.count += other.count;
        self.noise += other.noise;
    }
}

/// Column of readings: target and value.
type Column = (Option<usize>, usize);

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    for (set, data) in view.sets() {
        let is_deviation = matches!(
            data.kind.measurand,
            Measurand::BallDistance | Measurand::Component | Measurand::Displacement | Measurand::MovingDisplacement
        );
        if data.runs.len() < 2 || !is_deviation {
            continue;
        }
        let Some(trail) = view.trails.get(set) else { continue };
        let of_column = |(target, value): Column| {
            let sigma = trail.channels.get(3 * target.unwrap_or(0) + value).map_or(0.0, |channel| channel.sigma);
            ((target, value), compared(data, (target, value), sigma, data.kind.measurand != Measurand::BallDistance))
        };
        let all: Vec<(Column, Vec<Comparison>)> = columns(data).into_iter().map(of_column).collect();
        let columns_with = |run: usize, sign: Sign| -> Vec<Column> {
            all.iter()
                .filter(|(_, runs)| runs.get(run).is_some_and(|one| one.sign() == sign))
                .map(|one| one.0)
                .collect()
        };
        let reversed: Vec<usize> =
            (0..data.runs.len()).filter(|&run| !columns_with(run, Sign::Opposite).is_empty()).collect();
        let is_clear = reversed.len() == 1 && data.runs.len() >= RUNS;
        for &run in reversed.iter().take(1) {
            let opposite = columns_with(run, Sign::Opposite);
            // Columns that show neither sign were read by the same instrument.
            let is_whole = columns_with(run, Sign::Same).is_empty();
            let mut sum = Comparison::default();
            all.iter().filter(|(column, _)| opposite.contains(column)).for_each(|(_, runs)| sum.add(runs[run]));
            out.push(defect(data, (set, run), (&sum, is_clear), &|column| is_whole || opposite.contains(column)));
        }
    }
}

fn defect(
    data: &DataSet,
    (set, run): (usize, usize),
    (sum, is_clear): (&Comparison, bool),
    is_in: &dyn Fn(&Column) -> bool,
) -> DataDefect {
    let own = data.observations.iter().enumerate().filter(|(_, one)| one.run == run);
    let columns = columns(data);
    let of_row = |(row, one): (usize, &Observation)| {
        let is_of = |column: &&Column| is_in(column) && reading(one, **column).is_some();
        columns.iter().filter(is_of).map(|(_, value)| (row, *value)).collect::<Vec<_>>()
    };
    let mut readings: Vec<(usize, usize)> = own.flat_map(of_row).collect();
    readings.sort_unstable();
    readings.dedup();
    let rows = [readings.first(), readings.last()].map(|at| at.map_or(0, |(row, _)| *row));
    let [as_is, otherwise] = [sum.as_is, sum.otherwise].map(|squares| um_from_mm((squares / sum.count).sqrt()));
    let open = if is_clear { "" } else { "; the readings do not show which run has the wrong sign" };
    DataDefect {
        kind: DefectKind::Axes,
        set,
        name: data.runs.get(run).cloned().unwrap_or_default(),
        what: "reversed run".into(),
        rows,
        evidence: format!(
            "{} readings: without constant and linear parts they differ by {as_is:.2} µm RMS from the other runs at the same positions, with the opposite sign by {otherwise:.2} µm{open}",
            readings.len()
        ),
        then: if is_clear { Then::WithoutReadings(readings) } else { Then::Refuse },
    }
}

fn reading(one: &Observation, (target, value): Column) -> Option<f64> {
    (one.component.is_none() || one.target == target).then(|| one.values.get(value).copied().flatten())?
}

/// A position with one tool and feed, in µm and 10⁻³ rad.
fn key(one: &Observation) -> Vec<i64> {
    let fine = |value: f64| (value * 1e3).round() as i64;
    let axes = AXES.iter().map(|&axis| one.reading.position[axis]);
    let more = one.reading.tool_mm.iter().copied().chain([one.feed.unwrap_or(0.0), one.spindle_rad]);
    axes.chain(more).map(fine).collect()
}

/// A reading at a position.
struct Visit {
    run: usize,
    value: f64,
    /// Directions of the last motions.
    sense: [i8; AXIS_COUNT],
}

/// Readings at one position.
type Visits = BTreeMap<Vec<i64>, Vec<Visit>>;

/// Compares each run with the others in a column of readings, set-up by set-up.
fn compared(data: &DataSet, column: Column, sigma: f64, any_direction: bool) -> Vec<Comparison> {
    let mut out = vec![Comparison::default(); data.runs.len()];
    let setups: BTreeSet<usize> = data.observations.iter().map(|one| one.setup).collect();
    for setup in setups {
        let (mut one_direction, mut both): (Visits, Visits) = Default::default();
        for one in data.observations.iter().filter(|one| one.setup == setup) {
            let Some(value) = reading(one, column) else { continue };
            let sense = one.reading.state.direction;
            let visit = || Visit { run: one.run, value, sense };
            let position = key(one);
            let directed = position.iter().copied().chain(sense.map(i64::from)).collect();
            one_direction.entry(directed).or_default().push(visit());
            both.entry(position).or_default().push(visit());
        }
        for (run, sum) in out.iter_mut().enumerate() {
            let own = of_run(&one_direction, run, sigma, false);
            let is_compared = own.count > 0.0 || !any_direction;
            sum.add(if is_compared { own } else { of_run(&both, run, sigma, true) });
        }
    }
    out
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Compares a run with the others, without the terms that may differ between runs.
fn of_run(visits: &Visits, run: usize, sigma: f64, by_direction: bool) -> Comparison {
    let (mut own, mut others) = (Vec::new(), Vec::new());
    let mut positions: Vec<&[i64]> = Vec::new();
    let mut senses: Vec<[f64; AXIS_COUNT]> = Vec::new();
    let (mut squares, mut freedom, mut share) = (0.0, 0.0, 0.0);
    for (position, here) in visits {
        let [mine, rest]: [Vec<&Visit>; 2] =
            [true, false].map(|is_own| here.iter().filter(|one| (one.run == run) == is_own).collect());
        let Some(first) = mine.first().filter(|_| !rest.is_empty()) else { continue };
        let values = |of: &[&Visit]| of.iter().map(|one| one.value).collect::<Vec<f64>>();
        let middle = mean(&values(&rest));
        squares += rest.iter().map(|one| (one.value - middle).powi(2)).sum::<f64>();
        freedom += rest.len() as f64 - 1.0;
        share += 1.0 / mine.len() as f64 + 1.0 / rest.len() as f64;
        own.push(mean(&values(&mine)));
        others.push(middle);
        positions.push(position);
        senses.push(first.sense.map(f64::from));
    }
    let count = own.len();
    let mut series = Series::new(&vec![0; count], &vec![1.0; count], 0.0);
    series.take(&vec![1.0; count]);
    let along: Vec<Vec<f64>> = (0..AXIS_COUNT)
        .map(|axis| {
            let at: Vec<f64> = positions.iter().map(|at| at.get(axis).map_or(0.0, |at| *at as f64)).collect();
            let middle = mean(&at);
            at.iter().map(|at| at - middle).collect()
        })
        .collect();
    along.iter().for_each(|column| {
        series.take(column);
    });
    for axis in (0..AXIS_COUNT).filter(|_| by_direction) {
        let sense: Vec<f64> = senses.iter().map(|sense| sense[axis]).collect();
        series.take(&sense);
        for column in &along {
            series.take(&column.iter().zip(&sense).map(|(at, sense)| at * sense).collect::<Vec<_>>());
        }
    }
    let rank = series.rank();
    if count < FEWEST + rank {
        return Comparison::default();
    }
    let mut without = |values: &[f64]| {
        series.set_values(values);
        series.left().to_vec()
    };
    let (own, others) = (without(&own), without(&others));
    let sum = |sign: f64| own.iter().zip(&others).map(|(own, other)| (own - sign * other).powi(2)).sum::<f64>();
    let noise = if freedom >= FEWEST as f64 { squares / freedom } else { sigma * sigma };
    let beyond = (count - rank) as f64;
    Comparison { as_is: sum(1.0), otherwise: sum(-1.0), count: beyond, noise: noise * share / count as f64 * beyond }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use crate::diagnose::fault::{Checks, find_with};

    /// Readings along X in three runs, in one direction up to the ninth position and in the other beyond it: a factor of each run for a wave of 8 µm, for
    /// a slope of 12 µm, and for the directions with a reversal error of 12 µm; with noise of 0.5 µm (xorshift).
    fn found(wave: [f64; 3], slope: [f64; 3], turn: [i32; 3]) -> Vec<(String, Then)> {
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let mut noise = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            1.7 * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
        };
        let mut text = "X,Y,Z,X_dir,Y_dir,Z_dir,run,dx_um\n".to_owned();
        for run in 0..3 {
            for place in 0..21 {
                let x = f64::from(place) / 20.0;
                let way = turn[run] * if place < 9 { 1 } else { -1 };
                let um = wave[run] * 8.0 * (3.0 * std::f64::consts::PI * x).sin()
                    + slope[run] * 12.0 * x
                    + 6.0 * f64::from(way)
                    + noise();
                text += &format!("{},0,0,{way},1,1,r{run},{um:.4}\n", 20 * place);
            }
        }
        let machine = bench::machine();
        let sets = [bench::table(
            &machine,
            &text,
            "[measurement]\nkind = \"displacement\"\nsigma_um = 0.5\nfree = [\"offset\"]\n",
        )];
        let checks = Checks::empty().with(&CHECK);
        find_with(&checks, &bench::scene(&machine, &sets)).into_iter().map(|one| (one.name, one.then)).collect()
    }

    #[test]
    fn the_run_with_the_opposite_sign_is_excluded() {
        let readings = (21..42).map(|row| (row, 0)).collect();
        assert_eq!(
            found([1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1, -1, 1]),
            [("r1".to_owned(), Then::WithoutReadings(readings))]
        );
    }

    #[test]
    fn runs_of_one_sign_and_a_slope_that_changes_with_the_temperature_are_no_fault() {
        assert!(found([1.0; 3], [1.0; 3], [1; 3]).is_empty());
        assert!(found([1.0; 3], [1.0, -1.0, 1.0], [1; 3]).is_empty());
        // A run in the opposite direction mirrors a reversal error of 12 µm, in any order of the directions.
        assert!(found([0.0; 3], [1.0; 3], [1, -1, 1]).is_empty());
        // A wave of another size is an effect of the machine.
        assert!(found([1.0, 0.2, 1.0], [1.0; 3], [1; 3]).is_empty());
    }
}
