//! `ncfix diagnose --report`: the readings of each measurement before and after, with all that they may depend on.

use std::collections::HashMap;

use super::calibrated_report::{shown_circle, timed};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_metrology::diagnose::scene::Item;
use ncfix_metrology::diagnose::{Diagnosis, Scene, Tried, shape};
use ncfix_metrology::measure::circles::circles;
use ncfix_report::compared::Circle;
use ncfix_report::diagnosis::readings::{self, Driver, Reading, Set, Shown};

/// Puts the readings of a diagnosis into what is shown; the first measurements were `used`.
pub(super) fn fill(found: &Diagnosis, scene: &Scene<'_>, used: usize, shown: &mut Shown) {
    let drivers = drivers(scene);
    for number in 0..scene.sets.len() {
        for of_angles in [false, true] {
            shown.sets.extend(set(found, scene, &drivers, (number, number >= used), of_angles));
        }
    }
    shown.causes = found.causes.iter().map(tried).collect();
}

fn tried(one: &Tried) -> readings::Tried {
    readings::Tried {
        cause: one.cause.name.to_owned(),
        effect: one.cause.effect.to_string(),
        shown_by: one.cause.shown_by.to_owned(),
        candidates: one.candidates,
        best: one.best.clone(),
    }
}

/// All drivers there are: time, axes and their senses, further columns.
fn drivers(scene: &Scene<'_>) -> Vec<shape::Driver> {
    let axes: Vec<String> = scene.machine.axes.iter().flatten().map(|data| data.axis.to_string()).collect();
    let mut names = vec!["t_s".to_owned()];
    names.extend(axes.iter().cloned());
    names.extend(axes.iter().map(|axis| format!("{axis}_dir")));
    for driver in scene.sets.iter().flat_map(|set| &set.drivers) {
        if !names.contains(&driver.name) {
            names.push(driver.name.clone());
        }
    }
    names.iter().filter_map(|name| shape::driver(scene, name)).collect()
}

fn set(
    found: &Diagnosis,
    scene: &Scene<'_>,
    drivers: &[shape::Driver],
    (number, is_held_out): (usize, bool),
    of_angles: bool,
) -> Option<Set> {
    let data = scene.sets.get(number)?;
    let is_own =
        |item: &Item| item.is_angle == of_angles && scene.rows.get(item.row).is_some_and(|row| row.set == number);
    let places: Vec<usize> =
        scene.items.iter().enumerate().filter(|(_, item)| is_own(item)).map(|(place, _)| place).collect();
    if places.is_empty() {
        return None;
    }
    let micro = if of_angles { urad_from_rad(1.0) } else { um_from_mm(1.0) };
    let mut parts: Vec<String> = Vec::new();
    let mut out = Vec::new();
    let mut rows = Vec::new();
    for &place in &places {
        let Some(item) = scene.items.get(place) else { continue };
        let row = scene.rows.get(item.row)?;
        let name = part_name(scene, item);
        let part = parts.iter().position(|known| *known == name).unwrap_or_else(|| {
            parts.push(name);
            parts.len() - 1
        });
        let at = |values: &[f64]| values.get(place).map_or(f64::NAN, |value| micro * value);
        out.push(Reading {
            row: row.number + 1,
            part,
            before: at(&found.account.before),
            after: at(&found.account.after),
            counts: found.account.counts.get(place).copied().unwrap_or(false),
        });
        rows.push(item.row);
    }
    let doing = |values: &Vec<f64>| -> Vec<f64> {
        places.iter().map(|&place| values.get(place).map_or(0.0, |value| micro * value)).collect()
    };
    let findings = found.findings.iter().filter(|_| !is_held_out);
    Some(Set {
        name: data.name.clone(),
        kind: data.kind.name,
        is_held_out,
        unit: if of_angles { "µrad" } else { "µm" },
        parts,
        setups: data.setups.iter().map(|setup| setup.label.clone()).collect(),
        circles: shown_circles(scene, number, &out),
        readings: out,
        doing: findings.map(|one| doing(&one.doing)).collect(),
        drivers: drivers.iter().filter_map(|driver| along(driver, &rows)).collect(),
    })
}

/// A driver at the readings of some rows; `None` where it is always the same there.
fn along(driver: &shape::Driver, rows: &[usize]) -> Option<Driver> {
    let values: Vec<f64> = rows.iter().map(|&row| driver.values.get(row).copied().unwrap_or(f64::NAN)).collect();
    let mut known = values.iter().copied().filter(|value| value.is_finite());
    let first = known.next()?;
    if known.all(|value| (value - first).abs() <= 1e-9 * first.abs()) {
        return None;
    }
    let name = driver.name.clone();
    if name == "t_s"
        && let Some((title, values)) = timed(values.clone())
    {
        return Some(Driver { name, title, values });
    }
    let title = match name.strip_suffix("_dir") {
        Some(axis) => format!("sense of {axis}"),
        None if driver.unit.is_empty() => name.clone(),
        None => format!("{name} in {}", driver.unit),
    };
    Some(Driver { name, title, values })
}

/// The direction or component of a reading.
fn part_name(scene: &Scene<'_>, item: &Item) -> String {
    let Some(row) = scene.rows.get(item.row) else { return String::new() };
    if let Some(component) = row.component {
        return component.to_string();
    }
    let columns = scene.sets.get(row.set).map(|set| set.kind.columns).unwrap_or_default();
    match columns.get(item.value) {
        Some(name) => name.trim_end_matches("_um").to_owned(),
        None => ["X", "Y", "Z"].get(item.value).map_or_else(String::new, |name| (*name).to_owned()),
    }
}

fn shown_circles(scene: &Scene<'_>, number: usize, readings: &[Reading]) -> Vec<Circle> {
    let Some(data) = scene.sets.get(number).filter(|data| data.kind.name == "ballbar") else { return Vec::new() };
    let places: HashMap<usize, usize> =
        readings.iter().enumerate().map(|(place, reading)| (reading.row - 1, place)).collect();
    let found = circles(scene.machine, data);
    found.iter().map(|circle| shown_circle(circle, data, |row| places.get(&row).copied())).collect()
}
