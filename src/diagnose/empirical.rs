//! Structure that needs no name: shapes over every single driver and over pairs of them, smooth, one-sided, or turning over with a sense.
//!
//! Readings are put into bins of two drivers; what the means over the bins would explain tells which pair and which shape is worth a candidate.
//! That costs a pass over the rows for a pair. How much a candidate explains is found in full, like that of all others.

use std::sync::Arc;

use super::cause::{self, Candidate, UNNAMED, Weight};
use super::scene::{NO_ROW, Scene, Through};
use super::sweep::Sweep;
use crate::geometry::Axis;

/// Bins over a driver.
const BINS: usize = 12;
/// Drivers at most.
const MOST: usize = 22;
/// Shapes that are tried in full in each step.
const BEST: usize = 8;
/// Rows of which a first look is had.
const SOME: usize = 4000;
/// Places of a bump along each driver.
const BUMPS: usize = 9;
/// In no bin.
const NONE: u8 = u8::MAX;
/// Knots of smooth shapes over one driver.
const KNOTS: [usize; 3] = [4, 7, 12];

/// On what something may depend.
#[derive(Clone, Debug)]
struct Driver {
    name: String,
    /// By row; NaN where it is not known.
    values: Arc<Vec<f64>>,
    /// By row.
    bins: Vec<u8>,
    low: f64,
    high: f64,
    is_sense: bool,
    /// Whether it is a length in space.
    is_length: bool,
}

/// How a shape is made of one driver or two.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// A smooth function of one with so many knots.
    Smooth(usize, usize),
    /// More than so much of one.
    Step(usize, f64),
    /// A smooth function of the second that turns over with the sense of the first.
    Sense(usize, usize, usize),
    /// A smooth function of the second where the first is more (or less, −1) than so much.
    Beyond(usize, usize, usize, f64, f64),
    /// The product of both.
    Product(usize, usize),
    /// A smooth function of both with so many knots each.
    Surface(usize, usize, usize),
    /// A bump over both: where, how wide.
    Bump(usize, usize, [f64; 2], f64),
    /// A wave of the second where the first is more (or less) than so much, with a period.
    Wave(usize, usize, f64, f64, f64),
}

/// All that may be looked for in the readings of a scene.
#[derive(Clone, Debug)]
pub(super) struct Empirical {
    drivers: Vec<Driver>,
    /// Where shapes come in.
    pub(super) places: Vec<Through>,
    rows: Vec<usize>,
    row_count: usize,
    /// Number of the row of each row in its measurement: weights find their values by measurement and number.
    index: Arc<Vec<usize>>,
}

impl Empirical {
    pub(super) fn new(scene: &Scene<'_>) -> Empirical {
        let mut drivers = Vec::new();
        let axes: Vec<Axis> = scene.machine.axes.iter().flatten().map(|data| data.axis).collect();
        for &axis in &axes {
            let of = |row: &super::row::Row| {
                if axis.is_rotary() { row.position[axis].rem_euclid(std::f64::consts::TAU) } else { row.position[axis] }
            };
            // A rotary axis that does not go round has no seam.
            let goes_round = cause::range(scene, axis).is_some_and(|[low, high]| high - low > 3.2);
            let values = scene.rows.iter().map(|row| if goes_round { of(row) } else { row.position[axis] });
            let own = driver(axis.to_string(), values.collect(), false);
            drivers.extend(own.map(|driver| Driver { is_length: !axis.is_rotary(), ..driver }));
        }
        // Where tools differ, a place in the workpiece is not a position of an axis.
        for &axis in axes.iter().filter(|axis| !axis.is_rotary()) {
            let tool = |row: &super::row::Row| row.tool_mm.get(axis.dimension()).copied().unwrap_or(0.0);
            let first = scene.rows.first().map_or(0.0, tool);
            if scene.rows.iter().any(|row| (tool(row) - first).abs() > 1.0) {
                let values = scene.rows.iter().map(|row| row.position[axis] + tool(row)).collect();
                drivers.extend(driver(axis.to_string(), values, false).map(|own| Driver { is_length: true, ..own }));
            }
        }
        for &axis in &axes {
            let values = scene.rows.iter().map(|row| row.sense_of(axis)).collect();
            drivers.extend(driver(format!("{axis}_dir"), values, true));
        }
        let times = scene.rows.iter().map(|row| row.time_s.unwrap_or(f64::NAN)).collect();
        drivers.extend(driver("t_s".to_owned(), times, false));
        let mut names: Vec<&str> =
            scene.sets.iter().flat_map(|set| &set.drivers).map(|driver| driver.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        for name in names {
            let at = |row: &super::row::Row| {
                let column = scene.sets.get(row.set)?.drivers.iter().find(|driver| driver.name == name)?;
                column.values.get(row.number).copied()
            };
            let values = scene.rows.iter().map(|row| at(row).unwrap_or(f64::NAN)).collect();
            drivers.extend(driver(name.to_owned(), values, false));
        }
        drivers.truncate(MOST);
        let mut places: Vec<Through> = (0..3).map(Through::Tip).collect();
        let mut components: Vec<_> = scene.rows.iter().filter_map(|row| row.component).collect();
        components.sort_unstable();
        components.dedup();
        places.extend(components.into_iter().filter(|name| name.direction.is_rotation()).map(Through::Component));
        let mut first = Vec::new();
        let mut count = 0;
        for set in scene.sets {
            first.push(count);
            count += set.observations.len();
        }
        Empirical {
            drivers,
            places,
            rows: scene.items.iter().map(|item| item.row).collect(),
            row_count: scene.rows.len(),
            index: Arc::new(first),
        }
    }

    /// How many shapes it chooses from.
    pub(super) fn count(&self) -> usize {
        self.drivers.len() * self.drivers.len() * self.places.len() * 3
    }

    /// The most promising shapes for what is left: `factors` of the places, `left` unwhitened, `weights` 1/σ, and what a column must explain.
    pub(super) fn propose(
        &self,
        factors: &[Arc<Vec<f64>>],
        left: &[f64],
        weights: &[f64],
        price: f64,
    ) -> Vec<Candidate> {
        let mut found: Vec<(f64, Through, Form)> = Vec::new();
        for (&place, factors) in self.places.iter().zip(factors) {
            let mut sums = vec![[0.0; 2]; self.row_count];
            for (((&row, factor), left), weight) in self.rows.iter().zip(factors.iter()).zip(left).zip(weights) {
                if row != NO_ROW
                    && *weight > 0.0
                    && let Some(sum) = sums.get_mut(row)
                {
                    sum[0] += factor * left;
                    sum[1] += (factor * weight).powi(2);
                }
            }
            if sums.iter().all(|sum| sum[1] == 0.0) {
                continue;
            }
            let mut own: Vec<(f64, Form)> = Vec::new();
            for a in 0..self.drivers.len() {
                for b in a..self.drivers.len() {
                    let from = own.len();
                    self.forms(a, b, &sums, price, &mut own);
                    best_of_each(&mut own, from);
                }
            }
            self.bumps(&sums, price, &mut own);
            self.waves(&sums, price, &mut own);
            found.extend(own.into_iter().map(|(worth, form)| (worth, place, form)));
        }
        found.sort_by(|one, other| other.0.total_cmp(&one.0));
        found
            .into_iter()
            .take(BEST)
            .filter(|(worth, ..)| *worth > 0.0)
            .map(|(_, place, form)| self.candidate(place, form))
            .collect()
    }

    fn forms(&self, a: usize, b: usize, sums: &[[f64; 2]], price: f64, out: &mut Vec<(f64, Form)>) {
        let [Some(one), Some(other)] = [self.drivers.get(a), self.drivers.get(b)] else { return };
        let mut cells = vec![[0.0; 2]; BINS * BINS];
        for ((&x, &y), sum) in one.bins.iter().zip(&other.bins).zip(sums) {
            if x != NONE
                && y != NONE
                && let Some(cell) = cells.get_mut(usize::from(x) * BINS + usize::from(y))
            {
                cell[0] += sum[0];
                cell[1] += sum[1];
            }
        }
        let add = |[s, i]: [f64; 2], [t, j]: [f64; 2]| [s + t, i + j];
        let worth = |parts: &[[f64; 2]]| -> f64 {
            parts.iter().filter(|part| part[1] > 0.0).map(|[sum, information]| sum * sum / information - price).sum()
        };
        let cell = |x: usize, y: usize| cells.get(x * BINS + y).copied().unwrap_or_default();
        if a == b {
            if one.is_sense {
                return;
            }
            let all: Vec<[f64; 2]> = (0..BINS).map(|x| cell(x, x)).collect();
            for knots in KNOTS {
                let merged = merge(&all, knots);
                out.push((worth(&merged), Form::Smooth(a, knots)));
            }
            for edge in 1..BINS {
                let above = all.iter().skip(edge).copied().fold([0.0; 2], add);
                out.push((worth(&[above]), Form::Step(a, one.edge(edge))));
            }
            return;
        }
        for (first, second, turned) in [(a, b, false), (b, a, true)] {
            let [Some(one), Some(other)] = [self.drivers.get(first), self.drivers.get(second)] else { continue };
            let at = |x: usize, y: usize| if turned { cell(y, x) } else { cell(x, y) };
            if one.is_sense {
                let odd: Vec<[f64; 2]> = (0..BINS)
                    .map(|y| {
                        let (plus, minus) = (at(BINS - 1, y), at(0, y));
                        [plus[0] - minus[0], plus[1] + minus[1]]
                    })
                    .collect();
                if !other.is_sense {
                    for knots in KNOTS {
                        out.push((worth(&merge(&odd, knots)), Form::Sense(first, second, knots)));
                    }
                }
                continue;
            }
            if other.is_sense {
                continue;
            }
            for edge in 1..BINS {
                for (side, range) in [(1.0, edge..BINS), (-1.0, 0..edge)] {
                    let over: Vec<[f64; 2]> =
                        (0..BINS).map(|y| range.clone().map(|x| at(x, y)).fold([0.0; 2], add)).collect();
                    for knots in KNOTS {
                        out.push((
                            worth(&merge(&over, knots)),
                            Form::Beyond(first, second, knots, one.edge(edge), side),
                        ));
                    }
                }
            }
        }
        if one.is_sense || other.is_sense {
            return;
        }
        let share = |k: usize| (k as f64 + 0.5) / BINS as f64 - 0.5;
        let mut product = [0.0; 2];
        for x in 0..BINS {
            for y in 0..BINS {
                let (at, shape) = (cell(x, y), share(x) * share(y));
                product = add(product, [at[0] * shape, at[1] * shape * shape]);
            }
        }
        out.push((worth(&[product, [0.0, 1.0], [0.0, 1.0]]), Form::Product(a, b)));
        for knots in [3, 4, 6] {
            let rows: Vec<Vec<[f64; 2]>> =
                (0..BINS).map(|x| merge(&(0..BINS).map(|y| cell(x, y)).collect::<Vec<_>>(), knots)).collect();
            let columns = (0..knots).flat_map(|y| {
                let column: Vec<[f64; 2]> = rows.iter().map(|row| row.get(y).copied().unwrap_or_default()).collect();
                merge(&column, knots)
            });
            out.push((worth(&columns.collect::<Vec<_>>()), Form::Surface(a, b, knots)));
        }
    }

    /// A bump over two lengths: the best of a grid, then nearer.
    fn bumps(&self, sums: &[[f64; 2]], price: f64, out: &mut Vec<(f64, Form)>) {
        let lengths: Vec<usize> =
            (0..self.drivers.len()).filter(|&k| self.drivers.get(k).is_some_and(|driver| driver.is_length)).collect();
        for (place, &a) in lengths.iter().enumerate() {
            for &b in lengths.iter().skip(place + 1) {
                let [Some(one), Some(other)] = [self.drivers.get(a), self.drivers.get(b)] else { continue };
                if one.name == other.name {
                    continue;
                }
                let step = (sums.len() / SOME).max(1);
                let rows: Vec<[f64; 4]> = one
                    .values
                    .iter()
                    .zip(other.values.iter())
                    .zip(sums)
                    .filter(|(_, sum)| sum[1] > 0.0)
                    .map(|((x, y), sum)| [*x, *y, sum[0], sum[1]])
                    .collect();
                let worth = |at: [f64; 2], wide: f64, step: usize| {
                    let (mut sum, mut information) = (0.0, 1e-300);
                    for [x, y, own, known] in rows.iter().step_by(step) {
                        let far = ((x - at[0]).powi(2) + (y - at[1]).powi(2)) / (2.0 * wide * wide);
                        if far < 12.0 {
                            let shape = (-far).exp();
                            sum += own * shape;
                            information += known * shape * shape;
                        }
                    }
                    sum * sum / information * step as f64
                };
                let range = (one.high - one.low).min(other.high - other.low);
                if range < 1.0 {
                    continue;
                }
                let mut best = (0.0, [0.0; 2], 1.0);
                for wide in [range / 12.0, range / 6.0] {
                    for x in 0..BUMPS {
                        for y in 0..BUMPS {
                            let share = |k: usize| (k as f64 + 0.5) / BUMPS as f64;
                            let at = [
                                one.low + (one.high - one.low) * share(x),
                                other.low + (other.high - other.low) * share(y),
                            ];
                            let own = worth(at, wide, 4 * step);
                            if own > best.0 {
                                best = (own, at, wide);
                            }
                        }
                    }
                }
                let mut reach = range / 12.0;
                best.0 = worth(best.1, best.2, step);
                for _ in 0..5 {
                    for (dx, dy, factor) in [
                        (1.0, 0.0, 1.0),
                        (-1.0, 0.0, 1.0),
                        (0.0, 1.0, 1.0),
                        (0.0, -1.0, 1.0),
                        (0.0, 0.0, 1.25),
                        (0.0, 0.0, 0.8),
                    ] {
                        let (at, wide) = ([best.1[0] + dx * reach, best.1[1] + dy * reach], best.2 * factor);
                        let own = worth(at, wide, step);
                        if own > best.0 {
                            best = (own, at, wide);
                        }
                    }
                    reach *= 0.6;
                }
                out.push((best.0 - 4.0 * price, Form::Bump(a, b, best.1, best.2)));
            }
        }
    }

    /// Waves of a length at some feeds only.
    fn waves(&self, sums: &[[f64; 2]], price: f64, out: &mut Vec<(f64, Form)>) {
        let Some(a) = self.drivers.iter().position(|driver| driver.name == "feed_mm_min") else { return };
        let Some(feed) = self.drivers.get(a) else { return };
        let mut feeds: Vec<f64> = feed.values.iter().copied().filter(|value| value.is_finite()).collect();
        feeds.sort_by(f64::total_cmp);
        feeds.dedup();
        if feeds.len() > 6 {
            return;
        }
        for (b, driver) in self.drivers.iter().enumerate().filter(|(_, driver)| driver.is_length) {
            let Some(sweep) = Sweep::new(&driver.values) else { continue };
            for pair in feeds.windows(2) {
                let edge = f64::midpoint(pair[0], pair[1]);
                for side in [1.0, -1.0] {
                    let is_in = |value: &f64| side * (value - edge) > 0.0;
                    let products: Vec<f64> = sums
                        .iter()
                        .zip(feed.values.iter())
                        .map(|(sum, value)| if is_in(value) { sum[0] } else { 0.0 })
                        .collect();
                    let information: f64 = sums
                        .iter()
                        .zip(feed.values.iter())
                        .filter(|(_, value)| is_in(value))
                        .map(|(sum, _)| sum[1])
                        .sum();
                    let period = sweep.best(&products);
                    let (mut sines, mut cosines) = (0.0, 0.0);
                    for (product, value) in products.iter().zip(driver.values.iter()) {
                        let (sine, cosine) = (std::f64::consts::TAU * value / period).sin_cos();
                        sines += product * sine;
                        cosines += product * cosine;
                    }
                    let worth = 2.0 * (sines * sines + cosines * cosines) / information.max(1e-300);
                    out.push((worth - 2.0 * price, Form::Wave(a, b, edge, side, period)));
                }
            }
        }
    }

    fn candidate(&self, place: Through, form: Form) -> Candidate {
        let (columns, used): (Vec<(Column, Vec<f64>)>, Vec<usize>) = match form {
            Form::Smooth(a, knots) => (self.hats(a, knots), vec![a]),
            Form::Step(a, edge) => (vec![(self.beyond(a, edge, 1.0), vec![edge])], vec![a]),
            Form::Sense(a, b, knots) => {
                let sense: Column = self.value(a);
                (times(&[(sense, Vec::new())], &self.hats(b, knots)), vec![b, a])
            }
            Form::Beyond(a, b, knots, edge, side) => {
                (times(&[(self.beyond(a, edge, side), vec![edge])], &self.hats(b, knots)), vec![a, b])
            }
            Form::Product(a, b) => {
                let [one, other] = [a, b].map(|k| vec![(self.centred(k), Vec::new())]);
                let mut all = times(&one, &other);
                all.extend(one.into_iter().chain(other));
                (all, vec![a, b])
            }
            Form::Bump(a, b, at, wide) => {
                let (one, other) = (self.value(a), self.value(b));
                let bump: Column = Arc::new(move |row| {
                    let far = (one(row) - at[0]).powi(2) + (other(row) - at[1]).powi(2);
                    (-far / (2.0 * wide * wide)).exp()
                });
                (vec![(bump, at.to_vec())], vec![a, b])
            }
            Form::Wave(a, b, edge, side, period) => {
                let value = self.value(b);
                let wave = |of: fn(f64) -> f64| -> Column {
                    let value = Arc::clone(&value);
                    Arc::new(move |row| of(std::f64::consts::TAU * value(row) / period))
                };
                let waves = [(wave(f64::sin), Vec::new()), (wave(f64::cos), Vec::new())];
                (times(&[(self.beyond(a, edge, side), vec![edge])], &waves), vec![a, b])
            }
            Form::Surface(a, b, knots) => (times(&self.hats(a, knots), &self.hats(b, knots)), vec![a, b]),
        };
        let mut one = Candidate::one(&UNNAMED, "", place, Weight::new(|_| 0.0));
        one.columns = columns.iter().map(|(column, _)| vec![(place, self.weight(column.clone()))]).collect();
        one.points = columns.into_iter().map(|(_, at)| at).collect();
        let mut used = used;
        used.sort_unstable();
        one.drivers = used.into_iter().filter_map(|k| self.drivers.get(k)).map(|driver| driver.name.clone()).collect();
        one.drivers.dedup();
        one.parameter = match place {
            Through::Tip(direction) => ["X", "Y", "Z"].get(direction).copied().unwrap_or("").to_owned(),
            Through::Component(name) => name.to_string(),
            _ => String::new(),
        };
        one
    }

    fn weight(&self, column: Column) -> Weight {
        let first = Arc::clone(&self.index);
        Weight::new(move |row| {
            let place = first.get(row.set).map_or(usize::MAX, |first| first + row.number);
            column(place)
        })
    }

    fn value(&self, a: usize) -> Column {
        let values = self.drivers.get(a).map(|driver| Arc::clone(&driver.values)).unwrap_or_default();
        Arc::new(move |row| values.get(row).copied().unwrap_or(0.0))
    }

    fn centred(&self, a: usize) -> Column {
        let Some(driver) = self.drivers.get(a) else { return Arc::new(|_| 0.0) };
        let (value, low, high) = (self.value(a), driver.low, driver.high);
        Arc::new(move |row| (value(row) - f64::midpoint(low, high)) / (high - low))
    }

    fn beyond(&self, a: usize, edge: f64, side: f64) -> Column {
        let value = self.value(a);
        Arc::new(move |row| f64::from(u8::from(side * (value(row) - edge) > 0.0)))
    }

    /// Straight between knots, 1 at one of them and 0 at all others.
    fn hats(&self, a: usize, knots: usize) -> Vec<(Column, Vec<f64>)> {
        let Some(driver) = self.drivers.get(a) else { return Vec::new() };
        let (low, step) = (driver.low, (driver.high - driver.low) / (knots.max(2) - 1) as f64);
        (0..knots)
            .map(|knot| {
                let at = low + step * knot as f64;
                let value = self.value(a);
                let hat: Column = Arc::new(move |row| (1.0 - ((value(row) - at) / step).abs()).max(0.0));
                (hat, vec![at])
            })
            .collect()
    }
}

/// A function of the number of a row.
type Column = Arc<dyn Fn(usize) -> f64 + Send + Sync>;

fn times(ones: &[(Column, Vec<f64>)], others: &[(Column, Vec<f64>)]) -> Vec<(Column, Vec<f64>)> {
    let mut out = Vec::new();
    for (one, at) in ones {
        for (other, and) in others {
            let (one, other) = (Arc::clone(one), Arc::clone(other));
            let product: Column = Arc::new(move |row| one(row) * other(row));
            out.push((product, at.iter().chain(and).copied().collect()));
        }
    }
    out
}

/// Of the forms from a place on only the best of each kind stays.
fn best_of_each(all: &mut Vec<(f64, Form)>, from: usize) {
    let mut own = all.split_off(from.min(all.len()));
    own.sort_by(|one, other| other.0.total_cmp(&one.0));
    let mut kinds = Vec::new();
    own.retain(|(worth, form)| {
        let kind = std::mem::discriminant(form);
        let is_new = *worth > 0.0 && !kinds.contains(&kind);
        kinds.push(kind);
        is_new
    });
    all.extend(own);
}

fn merge(all: &[[f64; 2]], count: usize) -> Vec<[f64; 2]> {
    let mut out = vec![[0.0; 2]; count];
    for (k, part) in all.iter().enumerate() {
        if let Some(sum) = out.get_mut(k * count / all.len().max(1)) {
            sum[0] += part[0];
            sum[1] += part[1];
        }
    }
    out
}

/// `None` where it is always the same.
fn driver(name: String, values: Vec<f64>, is_sense: bool) -> Option<Driver> {
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    let low = finite().fold(f64::INFINITY, f64::min);
    let high = finite().fold(f64::NEG_INFINITY, f64::max);
    if high.partial_cmp(&(low + 1e-9 * low.abs().max(1e-3))) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    let bin = |value: &f64| {
        if value.is_finite() {
            ((value - low) / (high - low) * BINS as f64).floor().clamp(0.0, (BINS - 1) as f64) as u8
        } else {
            NONE
        }
    };
    let bins = values.iter().map(bin).collect();
    Some(Driver { name, bins, values: Arc::new(values), low, high, is_sense, is_length: false })
}

impl Driver {
    fn edge(&self, edge: usize) -> f64 {
        self.low + (self.high - self.low) * edge as f64 / BINS as f64
    }
}
