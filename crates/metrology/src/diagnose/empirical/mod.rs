//! Effects without a known cause: shapes over every single driver and over pairs of them, smooth, one-sided, or reversing with a direction.
//!
//! Readings are sorted into bins of two drivers. The gain of the bin means selects the pairs and shapes that become candidates, in one pass over the
//! rows for each pair. The gain of a candidate is computed exactly, like that of all others.

mod screen;
mod shape;

use std::borrow::Cow;
use std::collections::HashMap;
use std::mem::{Discriminant, discriminant};
use std::sync::Arc;

use super::cause::{self, Candidate};
use super::sample::some_rows;
use super::scene::{NO_ROW, Scene, Through};
use super::sweep::Sweep;
use ncfix_base::geometry::Axis;
use ncfix_base::numeric::in_parts;

/// Number of bins over a driver.
const BINS: usize = 12;
/// Maximum number of drivers.
const MOST: usize = 22;
/// Maximum number of shapes evaluated exactly in each step.
const BEST: usize = 10;
/// Maximum number of shapes of one kind among them.
const ALIKE: usize = 3;
/// Number of rows used for screening.
const SOME: usize = 4000;
/// Number of positions of a bump along each driver.
const BUMPS: usize = 9;
/// Marks a row that is in no bin.
const NONE: u8 = u8::MAX;
/// Numbers of knots of smooth shapes over one driver.
const KNOTS: [usize; 3] = [4, 7, 12];

/// A quantity on which an effect may depend.
#[derive(Clone, Debug)]
struct Driver {
    name: String,
    /// By row; NaN if unknown.
    values: Arc<Vec<f64>>,
    /// By binned row.
    bins: Vec<u8>,
    /// Rows with a known value, in the order of the values.
    order: Arc<Vec<u32>>,
    low: f64,
    high: f64,
    is_sense: bool,
    /// True if it is a length in space.
    is_length: bool,
    /// Its periods, if it is a length.
    sweep: Option<Sweep>,
    /// The axis, if it is exactly its position or its direction of motion.
    axis: Option<Axis>,
}

/// Form of a shape of one or two drivers, which are given by index.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// A smooth function of a driver with a number of knots.
    Smooth(usize, usize),
    /// A step of a driver at an edge.
    Step(usize, f64),
    /// A smooth function of the second driver that reverses with the direction of the first; number of knots.
    Sense(usize, usize, usize),
    /// A smooth function of the second driver with a number of knots where the first is above an edge (side 1) or below it (side −1).
    Beyond(usize, usize, usize, f64, f64),
    /// The product of both.
    Product(usize, usize),
    /// A smooth function of both with this number of knots each.
    Surface(usize, usize, usize),
    /// A bump over both: position, width.
    Bump(usize, usize, [f64; 2], f64),
    /// A wave of the second driver with a period where the first is above an edge (side 1) or below it (side −1).
    Wave(usize, usize, f64, f64, f64),
}

/// Drivers and paths of effects for a search of shapes in the readings of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Empirical {
    drivers: Vec<Driver>,
    /// Paths of effects.
    pub(super) places: Vec<Through>,
    rows: Vec<usize>,
    row_count: usize,
    /// The set-up of each row, over all measurements, and the number of set-ups.
    setups: Vec<usize>,
    setup_count: usize,
    /// Index of the first row of each measurement: weights find their values by measurement and number of the row.
    index: Arc<Vec<usize>>,
    /// Binned rows, if not all are.
    some: Option<Vec<usize>>,
}

impl Empirical {
    pub(super) fn new(scene: &Scene<'_>) -> Empirical {
        let mut drivers = Vec::new();
        let axes: Vec<Axis> = scene.machine.axes.iter().flatten().map(|data| data.axis).collect();
        for &axis in &axes {
            let of = |row: &super::row::SceneRow| {
                if axis.is_rotary() { row.position[axis].rem_euclid(std::f64::consts::TAU) } else { row.position[axis] }
            };
            // A rotary axis with less than half a revolution has no wrap-around.
            let goes_round = cause::range(scene, axis).is_some_and(|[low, high]| high - low > 3.2);
            let values = scene.rows.iter().map(|row| if goes_round { of(row) } else { row.position[axis] });
            let own = driver(axis.to_string(), values.collect(), false);
            drivers.extend(own.map(|own| {
                let own = if axis.is_rotary() { own } else { own.length() };
                Driver { axis: Some(axis), ..own }
            }));
        }
        // If tools differ, the position in the workpiece is not that of an axis.
        for &axis in axes.iter().filter(|axis| !axis.is_rotary()) {
            let tool = |row: &super::row::SceneRow| row.tool_mm.get(axis.dimension()).copied().unwrap_or(0.0);
            let first = scene.rows.first().map_or(0.0, tool);
            if scene.rows.iter().any(|row| (tool(row) - first).abs() > 1.0) {
                let values = scene.rows.iter().map(|row| row.position[axis] + tool(row)).collect();
                drivers.extend(driver(axis.to_string(), values, false).map(Driver::length));
            }
        }
        for &axis in &axes {
            let values = scene.rows.iter().map(|row| row.sense_of(axis)).collect();
            let own = driver(format!("{axis}_dir"), values, true);
            drivers.extend(own.map(|driver| Driver { axis: Some(axis), ..driver }));
        }
        let times = scene.rows.iter().map(|row| row.time_s.unwrap_or(f64::NAN)).collect();
        drivers.extend(driver("t_s".to_owned(), times, false));
        let mut names: Vec<&str> =
            scene.sets.iter().flat_map(|set| &set.drivers).map(|driver| driver.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        for name in names {
            let at = |row: &super::row::SceneRow| {
                let column = scene.sets.get(row.set)?.drivers.iter().find(|driver| driver.name == name)?;
                column.values.get(row.number).copied()
            };
            let values = scene.rows.iter().map(|row| at(row).unwrap_or(f64::NAN)).collect();
            drivers.extend(driver(name.to_owned(), values, false));
        }
        drivers.truncate(MOST);
        let some = some_rows(scene);
        for driver in &mut drivers {
            if let Some(rows) = &some {
                driver.bins = rows.iter().filter_map(|&row| driver.bins.get(row)).copied().collect();
            }
        }
        let mut places: Vec<Through> = (0..3).map(Through::Tip).collect();
        let mut components: Vec<_> = scene.rows.iter().filter_map(|row| row.component).collect();
        components.sort_unstable();
        components.dedup();
        places.extend(
            components
                .into_iter()
                .filter(|name| name.direction.is_rotation() && !name.is_location())
                .map(Through::Component),
        );
        let mut first = Vec::new();
        let mut count = 0;
        for set in scene.sets {
            first.push(count);
            count += set.observations.len();
        }
        let mut numbers: HashMap<(usize, usize), usize> = HashMap::new();
        let mut number = |row: &super::row::SceneRow| {
            let next = numbers.len();
            *numbers.entry((row.set, row.setup)).or_insert(next)
        };
        let setups = scene.rows.iter().map(&mut number).collect();
        Empirical {
            drivers,
            places,
            rows: scene.items.iter().map(|item| item.row).collect(),
            row_count: scene.rows.len(),
            setup_count: numbers.len(),
            setups,
            index: Arc::new(first),
            some,
        }
    }

    /// Number of shapes to select from.
    pub(super) fn count(&self) -> usize {
        self.drivers.len() * self.drivers.len() * self.places.len() * 3
    }

    /// Shapes with the largest gain on the residual: `factors` of the paths, `left` not whitened, `weights` 1/σ, and the penalty of a column.
    pub(super) fn propose(
        &self,
        factors: &[Arc<Vec<f64>>],
        left: &[f64],
        weights: &[f64],
        price: f64,
    ) -> Vec<Candidate> {
        let mut in_use = vec![false; self.row_count];
        for (&row, weight) in self.rows.iter().zip(weights) {
            if let Some(is) = in_use.get_mut(row).filter(|_| *weight > 0.0) {
                *is = true;
            }
        }
        let places: Vec<(Through, &Arc<Vec<f64>>)> = self.places.iter().copied().zip(factors).collect();
        let of_place = |&(place, factors): &(Through, &Arc<Vec<f64>>)| -> Vec<(f64, Through, Form)> {
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
                return Vec::new();
            }
            let binned = self.binned(&sums);
            let mut own: Vec<(f64, Form)> = Vec::new();
            for a in 0..self.drivers.len() {
                for b in a..self.drivers.len() {
                    let from = own.len();
                    self.forms((a, b), (&sums, &binned), price, &mut own);
                    screen::best_of_each(&mut own, from);
                }
            }
            self.products(&sums, price, &mut own);
            self.bumps(&sums, price, &mut own);
            self.waves(&sums, price, &mut own);
            own.into_iter().map(|(worth, form)| (worth, place, form)).collect()
        };
        let mut found: Vec<(f64, Through, Form)> = in_parts(&places, &of_place).into_iter().flatten().collect();
        found.sort_by(|one, other| other.0.total_cmp(&one.0));
        let mut kinds: HashMap<Discriminant<Form>, usize> = HashMap::new();
        found.retain(|(_, _, form)| {
            let count = kinds.entry(discriminant(form)).or_insert(0);
            *count += 1;
            *count <= ALIKE
        });
        found
            .into_iter()
            .take(BEST)
            .filter(|(worth, ..)| *worth > 0.0)
            .map(|(_, place, form)| self.candidate(place, form, &in_use))
            .collect()
    }
}

impl Empirical {
    /// Sums of the binned rows, scaled to the sum of all rows.
    fn binned<'b>(&self, sums: &'b [[f64; 2]]) -> Cow<'b, [[f64; 2]]> {
        let Some(some) = &self.some else { return Cow::Borrowed(sums) };
        let times = sums.len() as f64 / some.len().max(1) as f64;
        let of = |&row: &usize| sums.get(row).map_or([0.0; 2], |sum| sum.map(|value| times * value));
        Cow::Owned(some.iter().map(of).collect())
    }
}

/// A driver; `None` if it is constant.
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
    let at = |row: &u32| values.get(*row as usize).copied().unwrap_or(f64::NAN);
    let mut order: Vec<u32> = (0..u32::try_from(values.len()).unwrap_or(0)).filter(|row| at(row).is_finite()).collect();
    order.sort_by(|one, other| at(one).total_cmp(&at(other)));
    let (values, order) = (Arc::new(values), Arc::new(order));
    Some(Driver { name, bins, values, order, low, high, is_sense, is_length: false, sweep: None, axis: None })
}

impl Driver {
    fn length(self) -> Driver {
        let sweep = Sweep::new(&self.values);
        Driver { is_length: true, sweep, ..self }
    }

    /// Distinct values of the used rows, in ascending order.
    fn levels(&self, in_use: &[bool]) -> Vec<f64> {
        let used = self.order.iter().filter(|row| in_use.get(**row as usize).copied().unwrap_or(false));
        let mut levels: Vec<f64> = used.filter_map(|row| self.values.get(*row as usize).copied()).collect();
        levels.dedup();
        levels
    }

    fn edge(&self, edge: usize) -> f64 {
        self.low + (self.high - self.low) * edge as f64 / BINS as f64
    }
}
