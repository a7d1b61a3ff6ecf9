//! Shape of a finding: its size over its drivers, and a description of where it acts.

use super::cause::EffectKind;
use super::nature::ORDER;
use super::row::SceneRow;
use super::scene::{Scene, Through};
use super::size::{is_angle, weights_at};
use super::verdict::AcceptedCause;
use ncfix_base::geometry::AXES;
use ncfix_base::units::{um_from_mm, urad_from_rad};

/// Maximum number of places along a single driver, and along each of two.
const ALONE: usize = 13;
const TOGETHER: usize = 9;
/// A finding acts where its size exceeds this share of its largest size.
const ACTS: f64 = 0.05;
/// It acts in a part of a driver only if at least this share of the rows is outside.
const OUTSIDE: f64 = 0.08;
/// Minimum share of its variance that the driver must explain within that part.
const DEPENDS: f64 = 0.3;
/// Number of parts of the range of a driver for this test.
const PARTS: usize = 8;

/// A driver, by row of the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Driver {
    /// Column of the table.
    pub name: String,
    /// Its unit; empty for directions of motion and unknown units.
    pub unit: &'static str,
    /// Its values in the units of the table; NaN if missing.
    pub values: Vec<f64>,
}

impl Driver {
    fn is_sense(&self) -> bool {
        self.name.ends_with("_dir")
    }
}

/// Returns the unit of a column of numbers, by its name.
#[must_use]
pub fn unit_of(name: &str) -> &'static str {
    const UNITS: [(&str, &str); 9] = [
        ("_mm_min", "mm/min"),
        ("_rpm", "1/min"),
        ("_mm", "mm"),
        ("_deg", "°"),
        ("_C", "°C"),
        ("_s", "s"),
        ("_N", "N"),
        ("_um", "µm"),
        ("_urad", "µrad"),
    ];
    if let Some(axis) = AXES.into_iter().find(|axis| axis.to_string() == name) {
        return if axis.is_rotary() { "°" } else { "mm" };
    }
    UNITS.iter().find(|(ending, _)| name.ends_with(ending)).map_or("", |(_, unit)| unit)
}

/// Returns a driver by its name: a position, a direction of motion, time or a column of numbers; `None` if no row has it.
#[must_use]
pub fn driver(scene: &Scene<'_>, name: &str) -> Option<Driver> {
    let column = |row: &SceneRow| {
        let own = scene.sets.get(row.set)?.drivers.iter().find(|driver| driver.name == name)?;
        own.values.get(row.number).copied()
    };
    let axis = AXES.into_iter().find(|axis| name.strip_suffix("_dir").unwrap_or(name) == axis.to_string());
    let values: Vec<f64> = match axis {
        Some(axis) if name.ends_with("_dir") => scene.rows.iter().map(|row| row.sense_of(axis)).collect(),
        Some(axis) => {
            let factor = if axis.is_rotary() { 1.0_f64.to_degrees() } else { 1.0 };
            scene.rows.iter().map(|row| row.position[axis] * factor).collect()
        }
        None if name == ORDER => scene.rows.iter().map(|row| row.number as f64 + 1.0).collect(),
        None if name == "t_s" => scene.rows.iter().map(|row| row.time_s.unwrap_or(f64::NAN)).collect(),
        None => scene.rows.iter().map(|row| column(row).unwrap_or(f64::NAN)).collect(),
    };
    values.iter().any(|value| value.is_finite()).then(|| Driver { name: name.to_owned(), unit: unit_of(name), values })
}

/// Returns the drivers of a finding.
#[must_use]
pub fn drivers(one: &AcceptedCause, scene: &Scene<'_>) -> Vec<Driver> {
    let searched = |(name, values): &(String, std::sync::Arc<Vec<f64>>)| {
        let is_rotary = AXES.into_iter().any(|axis| axis.is_rotary() && axis.to_string() == *name);
        let factor = if is_rotary { 1.0_f64.to_degrees() } else { 1.0 };
        Driver { name: name.clone(), unit: unit_of(name), values: values.iter().map(|value| value * factor).collect() }
    };
    if one.candidate.along.is_empty() {
        return one.candidate.drivers.iter().filter_map(|name| driver(scene, name)).collect();
    }
    one.candidate.along.iter().map(searched).collect()
}

/// Size of a finding at the point where it acts, by row of the scene, µm or µrad.
#[must_use]
pub fn deviations(one: &AcceptedCause, scene: &Scene<'_>) -> Vec<f64> {
    let micro = if is_angle(&one.candidate) { urad_from_rad(1.0) } else { um_from_mm(1.0) };
    let of = |row: &SceneRow| {
        let weights = weights_at(&one.candidate, row);
        micro * weights.iter().zip(&one.amounts.values).map(|(weight, amount)| weight * amount).sum::<f64>()
    };
    scene.rows.iter().map(of).collect()
}

/// Returns the shape over one or two drivers: means over measured places. The first `used` measurements were used.
#[must_use]
pub fn shape(one: &AcceptedCause, scene: &Scene<'_>, used: usize) -> Vec<(Vec<f64>, f64)> {
    let all = drivers(one, scene);
    let most = match all.len() {
        1 => ALONE,
        2 => TOGETHER,
        _ => return Vec::new(),
    };
    let deviations = deviations(one, scene);
    let rows: Vec<usize> = rows(scene, used, &all);
    let places: Vec<Vec<usize>> = all.iter().map(|driver| places(driver, &rows, most)).collect();
    let mut cells: std::collections::BTreeMap<Vec<usize>, (Vec<f64>, f64, f64)> = std::collections::BTreeMap::new();
    for (k, &row) in rows.iter().enumerate() {
        let key: Vec<usize> = places.iter().filter_map(|own| own.get(k).copied()).collect();
        let cell = cells.entry(key).or_insert_with(|| (vec![0.0; all.len()], 0.0, 0.0));
        cell.0.iter_mut().zip(&all).for_each(|(sum, driver)| *sum += driver.values[row]);
        cell.1 += deviations.get(row).copied().unwrap_or(0.0);
        cell.2 += 1.0;
    }
    // Rows of a grid lie on common lines: one mean for each line, not for each cell.
    let mut lines: Vec<std::collections::BTreeMap<usize, [f64; 2]>> =
        vec![std::collections::BTreeMap::new(); all.len()];
    for (key, (sums, _, count)) in &cells {
        for ((line, place), sum) in lines.iter_mut().zip(key).zip(sums) {
            let own = line.entry(*place).or_insert([0.0; 2]);
            own[0] += sum;
            own[1] += count;
        }
    }
    let at = |key: &[usize]| -> Vec<f64> {
        let mean = |(place, line): (&usize, &std::collections::BTreeMap<usize, [f64; 2]>)| {
            line.get(place).map_or(f64::NAN, |[sum, count]| sum / count)
        };
        key.iter().zip(&lines).map(mean).collect()
    };
    cells.into_iter().map(|(key, (_, sum, count))| (at(&key), sum / count)).collect()
}

/// Rows of the used measurements that have all drivers.
fn rows(scene: &Scene<'_>, used: usize, drivers: &[Driver]) -> Vec<usize> {
    let is_known = |row: &usize| {
        drivers.iter().all(|driver| driver.values.get(*row).is_some_and(|value| value.is_finite()))
            && scene.rows.get(*row).is_some_and(|row| row.set < used)
    };
    (0..scene.rows.len()).filter(is_known).collect()
}

/// Returns the number of the place of each row along a driver: its values if they are few, else equal parts of its range.
fn places(driver: &Driver, rows: &[usize], most: usize) -> Vec<usize> {
    let value = |row: &usize| driver.values.get(*row).copied().unwrap_or(0.0);
    let mut values: Vec<f64> = rows.iter().map(value).collect();
    values.sort_by(f64::total_cmp);
    let (low, high) = (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(0.0));
    // A machine reaches its target only approximately.
    let near = (high - low) * 1e-3;
    let mut different: Vec<f64> = Vec::new();
    for value in values {
        if different.last().is_none_or(|last| value - last > near) {
            different.push(value);
        }
        if different.len() > most {
            let parts = (most - 1) as f64;
            let part = |row: &usize| ((value_share(value_of(driver, *row), low, high) * parts) as usize).min(most - 2);
            return rows.iter().map(part).collect();
        }
    }
    let nearest = |row: &usize| different.partition_point(|known| *known <= value(row)).saturating_sub(1);
    rows.iter().map(nearest).collect()
}

fn value_of(driver: &Driver, row: usize) -> f64 {
    driver.values.get(row).copied().unwrap_or(0.0)
}

fn value_share(value: f64, low: f64, high: f64) -> f64 {
    if high > low { ((value - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 }
}

/// Describes an unnamed finding in a sentence; `None` for named ones.
#[must_use]
pub fn sentence(one: &AcceptedCause, scene: &Scene<'_>, used: usize) -> Option<String> {
    if one.candidate.cause.effect != EffectKind::Unknown {
        return None;
    }
    if let Some((count, "lobes")) = one.candidate.constant {
        let plane = match one.candidate.drivers.len() {
            2 => format!("the plane {}", one.candidate.parameter),
            _ => "all planes".to_owned(),
        };
        return Some(format!("unknown: {count} lobes over the angle of circles in {plane}, the same in all runs"));
    }
    let all = drivers(one, scene);
    let deviations = deviations(one, scene);
    let rows = rows(scene, used, &all);
    let size = |row: &usize| deviations.get(*row).map_or(0.0, |value| value.abs());
    let most = rows.iter().map(size).fold(0.0, f64::max);
    let acting: Vec<usize> = rows.iter().copied().filter(|row| size(row) > ACTS * most).collect();
    let (mut depends, mut senses, mut limits) = (Vec::new(), Vec::new(), Vec::new());
    let is_alone = all.iter().filter(|driver| !driver.is_sense()).count() == 1;
    for driver in &all {
        if driver.is_sense() {
            senses.push(format!("changes sign with the direction of {}", driver.name.trim_end_matches("_dir")));
            continue;
        }
        // If set-ups have a free zero, the zero of a function of one driver is arbitrary. Its most frequent value counts as zero only if it is the value at
        // most places.
        let is_usual = !is_alone || acting.len() < rows.len() / 2;
        let limit = limit(driver, &rows, &acting).filter(|_| is_usual);
        if limit.is_none() || explained(driver, &acting, &deviations) > DEPENDS {
            depends.push(driver.name.as_str());
        }
        limits.extend(limit);
    }
    let place = match one.candidate.columns.first().and_then(|parts| parts.first()) {
        Some((Through::Tip(_), _)) => format!("an error along {}", one.candidate.parameter),
        _ if one.candidate.parameter.is_empty() => "an error of the readings".to_owned(),
        _ => format!("an error {}", one.candidate.parameter),
    };
    // A single driver that describes both place and size is named once.
    let is_one = depends.len() == 1 && is_alone;
    let limits: Vec<String> = limits
        .into_iter()
        .map(|(name, where_it_is)| if is_one { format!("that {where_it_is}") } else { format!("{name} {where_it_is}") })
        .collect();
    let mut parts = Vec::new();
    match (depends.as_slice(), limits.is_empty()) {
        ([], false) => parts.push(format!("is there only where {}", limits.join(" and "))),
        ([], true) => {}
        (names, true) => parts.push(format!("depends on {}", names.join(" and "))),
        (names, false) => parts.push(format!("depends on {} only where {}", names.join(" and "), limits.join(" and "))),
    }
    parts.extend(senses);
    Some(format!("unknown: {place} that {}; shape attached", parts.join(" and ")))
}

/// Describes the part of a driver where it acts, if it does not act everywhere.
fn limit(driver: &Driver, rows: &[usize], acting: &[usize]) -> Option<(String, String)> {
    let value = |row: &usize| value_of(driver, *row);
    let low = acting.iter().map(value).fold(f64::INFINITY, f64::min);
    let high = acting.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
    let [below, above]: [Vec<f64>; 2] = [
        rows.iter().map(value).filter(|value| *value < low).collect(),
        rows.iter().map(value).filter(|value| *value > high).collect(),
    ];
    let is_outside = |rest: &Vec<f64>| rest.len() as f64 > OUTSIDE * rows.len() as f64;
    // Limit between the last place without it and the first one with it.
    let from = f64::midpoint(low, below.iter().copied().fold(f64::NEG_INFINITY, f64::max));
    let to = f64::midpoint(high, above.iter().copied().fold(f64::INFINITY, f64::min));
    let round = |value: f64| rounded(value, rows.iter().map(value_in(driver)));
    let unit = if driver.unit.is_empty() { String::new() } else { format!(" {}", driver.unit) };
    let text = match (is_outside(&below), is_outside(&above)) {
        (true, true) => format!("is between {} and {}{unit}", round(from), round(to)),
        (true, false) => format!("is beyond {}{unit}", round(from)),
        (false, true) => format!("is below {}{unit}", round(to)),
        (false, false) => return None,
    };
    Some((driver.name.clone(), text))
}

fn value_in(driver: &Driver) -> impl Fn(&usize) -> f64 + '_ {
    move |row| value_of(driver, *row)
}

/// A limit is rounded to a hundredth of the range.
fn rounded(value: f64, all: impl Iterator<Item = f64>) -> String {
    let (low, high) =
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let step = 10.0_f64.powf(((high - low) / 100.0).log10().floor());
    if !(step.is_finite() && step > 0.0) {
        return format!("{value}");
    }
    let decimals = (-step.log10()).clamp(0.0, 9.0) as usize;
    format!("{:.decimals$}", (value / step).round() * step)
}

/// Share of the variance of a deviation that its means over parts of a driver explain, in some rows.
fn explained(driver: &Driver, rows: &[usize], deviations: &[f64]) -> f64 {
    let places = places(driver, rows, PARTS);
    let at = |row: &usize| deviations.get(*row).copied().unwrap_or(0.0);
    let mean = rows.iter().map(at).sum::<f64>() / rows.len().max(1) as f64;
    let mut sums = [[0.0; 2]; PARTS];
    for (row, place) in rows.iter().zip(places) {
        if let Some(sum) = sums.get_mut(place) {
            *sum = [sum[0] + at(row) - mean, sum[1] + 1.0];
        }
    }
    let total: f64 = rows.iter().map(|row| (at(row) - mean).powi(2)).sum();
    let between: f64 = sums.iter().filter(|sum| sum[1] > 0.0).map(|sum| sum[0] * sum[0] / sum[1]).sum();
    if total > 0.0 { between / total } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_values_are_places_of_their_own_and_many_are_parts_of_the_range() {
        let of = |values: &[f64], most: usize| {
            let driver = Driver { name: "X".into(), unit: "mm", values: values.to_vec() };
            places(&driver, &(0..values.len()).collect::<Vec<_>>(), most)
        };
        // A thousandth of the range is not a different place.
        assert_eq!(of(&[10.0, 0.0, 0.009, 5.0, 10.0], 5), [2, 0, 0, 1, 2]);
        // Four parts of 100, because five places are too few.
        assert_eq!(of(&[0.0, 24.0, 26.0, 49.0, 51.0, 74.0, 76.0, 100.0], 5), [0, 0, 1, 1, 2, 2, 3, 3]);
    }
}
