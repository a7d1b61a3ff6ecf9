//! Detects tables with identical readings: rounded, reordered, or at other times. Readings that were repeated at the same places differ by their
//! noise.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use super::data::{DataSet, Observation};
use ncfix_base::geometry::AXES;

/// Minimum number of common readings.
const LEAST: usize = 20;
/// Minimum share of the readings at the same places.
const SHARE: f64 = 0.9;
/// Largest rounding relative to the noise,
const FINE: f64 = 0.3;
/// and largest expected number of chance matches.
const CHANCE: f64 = 0.5;
/// Maximum number of decimals in µm or µrad.
const DECIMALS: i32 = 7;
/// Rounding of the numbers themselves, as a share of a step.
const ROUNDING: f64 = 1e-3;
/// Median of the absolute values of normal noise, in standard deviations.
const MEDIAN: f64 = 0.674_489_750_196_081_7;
/// µm per mm, µrad per rad.
const MICRO: (f64, f64) = (1e3, 1e6);

/// Common readings of two tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Copied {
    /// Number of common readings.
    pub readings: usize,
    /// Number of readings at the same places.
    pub of: usize,
}

/// The readings of a table by place and by measured quantity, µm or µrad.
#[derive(Clone, Debug)]
pub struct ReadingsByPlace {
    /// Sorted readings, by a hash of the place and of the quantity.
    values: BTreeMap<u64, Vec<f64>>,
    /// The last decimal in which readings differ.
    step: f64,
    /// Noise of the readings.
    noise: f64,
}

impl ReadingsByPlace {
    /// The readings of a table.
    #[must_use]
    pub fn new(data: &DataSet) -> ReadingsByPlace {
        let values = places(data);
        ReadingsByPlace { step: step(&values), noise: noise(data), values }
    }
}

/// The common readings of two tables that differ by rounding only, although their noise is larger.
#[must_use]
pub fn copied(one: &ReadingsByPlace, other: &ReadingsByPlace) -> Option<Copied> {
    let step = one.step.max(other.step);
    let noise = one.noise.min(other.noise);
    if step >= FINE * noise {
        return None;
    }
    let close = step * (0.5 + ROUNDING);
    let (mut same, mut all, mut by_chance) = (0, 0, 0.0);
    for (place, values) in &one.values {
        let Some(others) = other.values.get(place) else { continue };
        let count = values.len().min(others.len());
        all += count;
        by_chance += count as f64 * (others.len().max(values.len()) as f64 * step / noise).min(1.0);
        // Both are sorted: a value below all remaining values of the other has no match.
        let (mut k, mut l) = (0, 0);
        while let (Some(a), Some(b)) = (values.get(k), others.get(l)) {
            let matches = (a - b).abs() <= close;
            same += usize::from(matches);
            k += usize::from(matches || a < b);
            l += usize::from(matches || a >= b);
        }
    }
    let is_copy = same >= LEAST && same as f64 > SHARE * all as f64 && by_chance < CHANCE * all as f64;
    is_copy.then_some(Copied { readings: same, of: all })
}

fn micro(one: &Observation) -> f64 {
    if one.is_angle() { MICRO.1 } else { MICRO.0 }
}

fn places(data: &DataSet) -> BTreeMap<u64, Vec<f64>> {
    let fine = |value: f64| (value * 1e3).round() as i64;
    let mut all: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for one in &data.observations {
        // Numbers of balls and components refer to their own table.
        let what = one.target.and_then(|target| data.targets.get(target)).map_or("", String::as_str);
        let mut place = DefaultHasher::new();
        AXES.iter().for_each(|&axis| fine(one.reading.position[axis]).hash(&mut place));
        one.reading.tool_mm.iter().for_each(|value| fine(*value).hash(&mut place));
        one.reading.state.direction.iter().for_each(|sense| i64::from(*sense).hash(&mut place));
        [fine(one.spindle_rad), fine(one.feed.unwrap_or(0.0))].hash(&mut place);
        what.hash(&mut place);
        for (k, value) in one.values.iter().enumerate() {
            let Some(value) = value.filter(|value| value.is_finite()) else { continue };
            let mut place = place.clone();
            k.hash(&mut place);
            all.entry(place.finish()).or_default().push(value * micro(one));
        }
    }
    all.values_mut().for_each(|values| values.sort_by(f64::total_cmp));
    all
}

/// The last decimal in which readings differ, µm or µrad.
fn step(places: &BTreeMap<u64, Vec<f64>>) -> f64 {
    let all = || places.values().flatten();
    let is_of = |step: f64| all().all(|value| ((value / step).round() * step - value).abs() < ROUNDING * step);
    (-DECIMALS..=0).rev().map(|decimals| 10.0_f64.powi(decimals)).find(|step| is_of(*step)).unwrap_or(0.0)
}

/// Noise of the readings: the stated value, but at most the difference of neighbors, µm or µrad.
fn noise(data: &DataSet) -> f64 {
    let mut bends: Vec<f64> = data
        .observations
        .windows(3)
        .flat_map(|three| {
            (0..3).map(move |k| three.iter().map(|one| Some(one.values[k]? * micro(one))).collect::<Option<Vec<f64>>>())
        })
        .flatten()
        .filter_map(|three| match three.as_slice() {
            [a, b, c] => Some((a - 2.0 * b + c).abs()),
            _ => None,
        })
        .collect();
    if bends.is_empty() {
        return 0.0;
    }
    let middle = bends.len() / 2;
    let differ = *bends.select_nth_unstable_by(middle, f64::total_cmp).1 / (MEDIAN * 6.0_f64.sqrt());
    let is_angle = data.observations.iter().all(Observation::is_angle);
    let stated = if is_angle { data.sigma_rad.map(|rad| rad * MICRO.1) } else { data.sigma.map(|mm| mm * MICRO.0) };
    stated.map_or(differ, |stated| differ.min(stated))
}
