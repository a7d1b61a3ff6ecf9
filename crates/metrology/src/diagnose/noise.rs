//! Noise of the readings, and the test for systematic residuals beyond it: their size and the drivers that they follow.

use std::collections::BTreeMap;

use ncfix_base::geometry::AXES;
use ncfix_base::numeric::fisher;

use super::fold::counts;
use super::freedom::Order;
use super::scene::{Scene, SceneReading};
use super::search::{Field, Weights};
use crate::measure::display;

/// Minimum number of repeats, beyond the first reading of each pose, that determine the noise.
const REPEATS: usize = 12;
/// Repeats drift if their scatter exceeds that of consecutive ones by this factor. Drift is not noise of a reading.
const WANDER: f64 = 1.3;
/// Significance limit of this ratio: the ratio of both variances has a standard deviation of one over the root of the number of pairs (von Neumann 1941).
const SURELY: f64 = 3.0;
/// Median of the absolute values of normal noise, in standard deviations.
pub(super) const MEDIAN: f64 = 0.674_489_750_196_081_7;
/// Maximum lag in the Ljung–Box test.
const DISTANCES: usize = 20;
/// Largest p-value at which correlation is accepted.
const LIMIT: f64 = 1e-3;
/// Correlation below this share of the noise is negligible.
const MATTERS: f64 = 0.5;
/// The residual is noise if it exceeds the stated noise by this factor,
const STATED: f64 = 1.5;
/// is uncorrelated, and differences of neighbors have at least this share of their value for white noise.
const WHITE: f64 = 0.8;
/// A residual beyond this multiple of the noise of repeats is systematic, whatever its order. With ten degrees of freedom each, a variance ratio of 4 has a
/// p-value of 2 %.
const BEYOND: f64 = 2.0;
/// Rounding error, mm or rad.
const NOTHING: f64 = 1e-9;
/// Number of parts of the range of a driver.
const PARTS: usize = 10;
/// Maximum number of reported drivers of the residual.
const PLACES: usize = 4;
/// Minimum share of the degrees of freedom in an F test over parts.
const LEAST_FREEDOM: f64 = 4.0;

/// Source of the noise estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum NoiseSource {
    /// Repeated readings of the same pose, direction of approach and set-up.
    Repeats,
    /// Description of the instrument.
    Instrument,
    /// The whole residual: it is white and larger than stated for the instrument.
    Rest,
    /// Differences of neighboring readings.
    #[default]
    Differences,
}

/// Residual in relation to the noise.
#[derive(Clone, Debug, Default)]
pub struct Left {
    /// Standard deviation of a reading, mm or rad.
    pub noise: f64,
    /// Source of this value.
    pub source: NoiseSource,
    /// Noise stated in the descriptions of the instruments, mm or rad.
    pub stated: Option<f64>,
    /// RMS of the residual beyond the noise, mm or rad.
    pub unexplained: f64,
    /// p-value of the correlations.
    pub chance: f64,
    /// True if the residual is systematic and not negligible.
    pub has_structure: bool,
    /// Drivers that the residual follows, with the RMS of the dependence, the largest first.
    pub places: Vec<(String, f64)>,
}

/// True if the readings are angles: only if there are no lengths.
pub(super) fn is_angle(scene: &Scene<'_>) -> bool {
    scene.items.iter().all(|item| item.is_angle)
}

/// Analyzes the residual (mm, rad) after some candidates.
pub(super) fn look(field: &Field<'_, '_>, weights: &Weights, left: &[f64]) -> Left {
    let scene = field.scene;
    let of_angles = is_angle(scene);
    let places: Vec<usize> = counts(scene, weights)
        .into_iter()
        .filter(|&place| scene.items.get(place).is_some_and(|item| item.is_angle == of_angles))
        .collect();
    let at = |place: usize| left.get(place).copied().unwrap_or(0.0);
    let rms = (places.iter().map(|&place| at(place).powi(2)).sum::<f64>() / places.len().max(1) as f64).sqrt();
    let order = Order::new(weights);
    let known = described(scene, &places);
    let (mut noise, mut source) = match (repeats(scene, &places, &at), known) {
        (Some(Repeats { noise, follows: None }), _) => (noise, NoiseSource::Repeats),
        // The cause of the drift acts between repeats, so their scatter is not noise.
        (Some(Repeats { follows: Some(near), .. }), known) => match known.filter(|known| *known >= near) {
            Some(noise) => (noise, NoiseSource::Instrument),
            None => (near, NoiseSource::Differences),
        },
        (None, Some(noise)) => (noise, NoiseSource::Instrument),
        (None, None) => (differences(weights, &places, &at), NoiseSource::Differences),
    };
    let standard: Vec<f64> =
        left.iter().zip(&weights.items).map(|(left, weight)| if *weight > 0.0 { left * weight } else { 0.0 }).collect();
    let chance = ljung_box(&order, &standard, places.len());
    // A white residual is not systematic, even if it is larger than the stated noise.
    let white = differences(weights, &places, &at);
    if source == NoiseSource::Instrument && chance >= LIMIT && rms > STATED * noise && white > WHITE * rms {
        (noise, source) = (rms, NoiseSource::Rest);
    }
    if matches!(source, NoiseSource::Differences | NoiseSource::Repeats) {
        // Neighbors and repeats with the same digit of a display have no difference.
        let steps = scene.sets.iter().map(|set| display::noise_of(set, of_angles)).fold(0.0, f64::max);
        noise = noise.max(steps.min(rms));
    }
    let unexplained = (rms * rms - noise * noise).max(0.0).sqrt();
    // A few uncorrelated readings may still scatter more than their repeats.
    let is_beyond = source == NoiseSource::Repeats && rms > BEYOND * noise;
    Left {
        noise,
        source,
        stated: known,
        unexplained,
        chance,
        has_structure: (chance < LIMIT || is_beyond) && unexplained > (MATTERS * noise).max(NOTHING),
        places: drivers(scene, &places, &at, noise),
    }
}

fn described(scene: &Scene<'_>, places: &[usize]) -> Option<f64> {
    let mut squares = 0.0;
    for &place in places {
        let item = scene.items.get(place)?;
        let set = scene.sets.get(scene.rows.get(item.row)?.set)?;
        squares += if item.is_angle { set.sigma_rad } else { set.sigma }?.powi(2);
    }
    (!places.is_empty()).then(|| (squares / places.len() as f64).sqrt())
}

/// Readings with equal keys are repeats of each other.
fn key(scene: &Scene<'_>, item: &SceneReading) -> Option<Vec<i64>> {
    let row = scene.rows.get(item.row)?;
    let set = scene.sets.get(row.set)?;
    let one = set.observations.get(row.number)?;
    let whole = |value: f64| if value.is_finite() { (value * 1e3).round() as i64 } else { i64::MIN };
    let number = |value: usize| i64::try_from(value).unwrap_or(i64::MAX);
    let mut key = vec![number(row.set), number(row.setup), number(item.value), number(one.target.unwrap_or(0))];
    key.extend(AXES.into_iter().map(|axis| whole(row.position[axis])));
    key.extend(row.sense.map(i64::from));
    key.extend(one.reading.tool_mm.iter().map(|&value| whole(value)));
    key.push(whole(one.spindle_rad));
    // Times and temperatures never repeat exactly.
    let of_drivers = set.drivers.iter().filter(|driver| !driver.name.starts_with("T_"));
    key.extend(of_drivers.map(|driver| whole(driver.values.get(row.number).copied().unwrap_or(f64::NAN))));
    Some(key)
}

/// Scatter of repeats, mm or rad.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Repeats {
    /// Standard deviation about the means of the groups.
    noise: f64,
    /// Standard deviation from consecutive repeats, if it is significantly smaller.
    follows: Option<f64>,
}

fn repeats(scene: &Scene<'_>, places: &[usize], at: &dyn Fn(usize) -> f64) -> Option<Repeats> {
    let mut groups: BTreeMap<Vec<i64>, Vec<f64>> = BTreeMap::new();
    for &place in places {
        if let Some(key) = scene.items.get(place).and_then(|item| key(scene, item)) {
            groups.entry(key).or_default().push(at(place));
        }
    }
    of_groups(groups.values().map(Vec::as_slice))
}

/// Returns the noise from groups of repeats, each in the order of measurement.
fn of_groups<'g>(groups: impl Iterator<Item = &'g [f64]>) -> Option<Repeats> {
    let (mut squares, mut freedom, mut steps) = (0.0, 0, 0.0);
    let mut bends: Vec<f64> = Vec::new();
    for group in groups.filter(|group| group.len() > 1) {
        let mean = group.iter().sum::<f64>() / group.len() as f64;
        squares += group.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        freedom += group.len() - 1;
        steps += group.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum::<f64>() / 2.0;
        bends.extend(group.windows(3).map(bend));
    }
    if freedom < REPEATS {
        return None;
    }
    let ratio = if squares > 0.0 { steps / squares } else { 1.0 };
    let wanders = ratio < (1.0 / (WANDER * WANDER)).min(1.0 - SURELY / (freedom as f64).sqrt());
    let follows = wanders.then(|| of_bends(bends).unwrap_or((steps / freedom as f64).sqrt()));
    Some(Repeats { noise: (squares / freedom as f64).sqrt(), follows })
}

fn bend(row: &[f64]) -> f64 {
    match row {
        [a, b, c] => (a - 2.0 * b + c).abs(),
        _ => 0.0,
    }
}

/// Returns the noise of a reading from second differences: their variance is six times as large.
fn of_bends(mut sizes: Vec<f64>) -> Option<f64> {
    let middle = sizes.len() / 2;
    (!sizes.is_empty()).then(|| *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 / (MEDIAN * 6.0_f64.sqrt()))
}

/// Second differences of neighbors, in which smooth functions are negligible.
fn differences(weights: &Weights, places: &[usize], at: &dyn Fn(usize) -> f64) -> f64 {
    let mut series: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for &place in places {
        series.entry(weights.series.get(place).copied().unwrap_or(0)).or_default().push(at(place));
    }
    of_bends(series.values().flat_map(|row| row.windows(3).map(bend).collect::<Vec<_>>()).collect()).unwrap_or(0.0)
}

/// Ljung & Box 1978: for white noise, n (n + 2) Σ ρₖ²/(n − k) is χ² distributed.
fn ljung_box(order: &Order, values: &[f64], count: usize) -> f64 {
    let correlations = order.correlations(values);
    let most = correlations.len().min(DISTANCES);
    if most == 0 {
        return 1.0;
    }
    let n = count as f64;
    let sum: f64 =
        correlations.iter().take(most).enumerate().map(|(k, rho)| rho * rho / (order.pairs(k + 1).max(1)) as f64).sum();
    fisher::exceeded(n * (n + 2.0) * sum / most as f64, most as f64, 1e9)
}

/// Returns the dependence of the residual on every driver: means over parts of its range, beyond their noise.
fn drivers(scene: &Scene<'_>, places: &[usize], at: &dyn Fn(usize) -> f64, noise: f64) -> Vec<(String, f64)> {
    let row_of = |place: usize| scene.items.get(place).and_then(|item| scene.rows.get(item.row));
    let mut all: Vec<(String, Vec<f64>)> = Vec::new();
    for axis in scene.machine.axes.iter().flatten().map(|data| data.axis) {
        let rows: Vec<Option<&super::row::SceneRow>> = places.iter().map(|&place| row_of(place)).collect();
        let at = rows.iter().map(|row| row.map_or(f64::NAN, |row| row.position[axis])).collect();
        let sense = rows.iter().map(|row| row.map_or(f64::NAN, |row| row.sense_of(axis))).collect();
        all.extend([(axis.to_string(), at), (format!("{axis}_dir"), sense)]);
    }
    all.push((
        "t_s".to_owned(),
        places.iter().map(|&place| row_of(place).and_then(|row| row.time_s).unwrap_or(f64::NAN)).collect(),
    ));
    let mut names: Vec<&str> = scene.sets.iter().flat_map(|set| &set.drivers).map(|one| one.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let value = |place: &usize| {
            let row = row_of(*place)?;
            let driver = scene.sets.get(row.set)?.drivers.iter().find(|driver| driver.name == name)?;
            driver.values.get(row.number).copied()
        };
        all.push((name.to_owned(), places.iter().map(|place| value(place).unwrap_or(f64::NAN)).collect()));
    }
    let left: Vec<f64> = places.iter().map(|&place| at(place)).collect();
    let mut found: Vec<(String, f64)> = all
        .into_iter()
        .map(|(name, values)| (name, along(&values, &left)))
        .filter(|(_, size)| *size > 0.3 * noise)
        .collect();
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    found.truncate(PLACES);
    found
}

/// RMS of the means over parts of the range, minus the contribution of the noise; 0 if not significant.
fn along(values: &[f64], left: &[f64]) -> f64 {
    let mut pairs: Vec<(f64, f64)> =
        values.iter().copied().zip(left.iter().copied()).filter(|(value, _)| value.is_finite()).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let count = pairs.len();
    if count < 3 * PARTS || pairs.first().map(|pair| pair.0.to_bits()) == pairs.last().map(|pair| pair.0.to_bits()) {
        return 0.0;
    }
    let mut sums: Vec<(f64, f64)> = Vec::new();
    let mut last = (usize::MAX, f64::NAN);
    for (place, (value, left)) in pairs.iter().enumerate() {
        let mut part = place * PARTS / count;
        // Equal values are in one part.
        if value.to_bits() == last.1.to_bits() {
            part = last.0;
        }
        if part != last.0 {
            sums.push((0.0, 0.0));
        }
        last = (part, *value);
        if let Some(sum) = sums.last_mut() {
            *sum = (sum.0 + 1.0, sum.1 + left);
        }
    }
    let whole = pairs.iter().map(|pair| pair.1).sum::<f64>() / count as f64;
    let total: f64 = pairs.iter().map(|pair| (pair.1 - whole).powi(2)).sum();
    let between: f64 = sums.iter().map(|(count, sum)| count * (sum / count - whole).powi(2)).sum();
    let above = sums.len() as f64 - 1.0;
    let below = (count as f64 - sums.len() as f64).max(1.0);
    let within = (total - between).max(0.0) / below;
    if above < 1.0 || within <= 0.0 || between / above < LEAST_FREEDOM * within {
        return 0.0;
    }
    ((between - above * within) / count as f64).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values from −1 to 1 with a variance of 1/3, from xorshift.
    fn white(count: usize) -> Vec<f64> {
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn repeats_that_wander_together_are_none() {
        let noise = white(600);
        let sigma = 1.0 / 3.0_f64.sqrt();
        let plain = of_groups(noise.chunks(6)).unwrap();
        assert!(plain.follows.is_none() && (plain.noise / sigma - 1.0).abs() < 0.1, "{plain:?}");
        // One pose for hours, and a wave of 200 readings with an amplitude of 8.
        let wave = |k: usize| 8.0 * (std::f64::consts::TAU * k as f64 / 200.0).sin();
        let waved: Vec<f64> = noise.iter().enumerate().map(|(k, noise)| noise + wave(k)).collect();
        let found = of_groups(std::iter::once(waved.as_slice())).unwrap();
        // The second differences of the wave are 8 (2π/200)² = 0.008.
        assert!((found.follows.unwrap() / sigma - 1.0).abs() < 0.15, "{found:?}");
        // Runs with their own zero are not a drift within the groups that they form.
        let of_runs: Vec<f64> = noise.iter().enumerate().map(|(k, noise)| noise + 3.0 * noise_of_run(k)).collect();
        let found = of_groups(of_runs.chunks(5)).unwrap();
        assert!(found.follows.is_none(), "{found:?}");
    }

    fn noise_of_run(place: usize) -> f64 {
        [0.7, -0.4, 0.1, -0.9, 0.5][place % 5]
    }

    #[test]
    fn means_of_parts_are_less_by_what_their_noise_makes_of_them() {
        // Ten parts of ten, alternately 1 and −1, with ±1/2 within each.
        let values: Vec<f64> = (0..100).map(f64::from).collect();
        let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        let left: Vec<f64> = (0..100).map(|k| sign(k / 10) + 0.5 * sign(k)).collect();
        // 100 between parts with nine degrees of freedom, 25 within them with 90: 100 − 9 · 25/90 of 100.
        assert!((along(&values, &left) - 0.975_f64.sqrt()).abs() < 1e-12);
        // Noise alone gives 0.
        assert_eq!(along(&values, &(0..100).map(sign).collect::<Vec<_>>()), 0.0);
    }
}
