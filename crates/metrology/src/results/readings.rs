//! Individual readings of a diagnosis, for pictures: residuals before and after, the contribution of each finding, and all possible drivers.

use std::collections::HashMap;

use super::compared::Circle;
use super::held::{shown_circle, timed};
use crate::diagnose::scene::SceneReading;
use crate::diagnose::stated::{HypothesisTrial, StatedTrials};
use crate::diagnose::{self, DiagnosedCauses, Scene, shape};
use crate::measure::circles::circles;
use crate::measure::data::TIME;
use crate::measure::kind::Measurand;
use ncfix_base::units::Unit;

/// Page content in addition to the JSON object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShownReadings {
    /// Measurements, lengths and angles separately.
    pub sets: Vec<Set>,
    /// Tried candidates, by cause.
    pub causes: Vec<TriedCauseReport>,
}

/// Readings of a measurement in one unit; all lists of readings have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Set {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// `true` if it was held out.
    pub is_held_out: bool,
    /// Unit of all readings.
    pub unit: Unit,
    /// Directions or components.
    pub parts: Vec<String>,
    /// Labels of the set-ups.
    pub setups: Vec<String>,
    /// The readings in the order of the table.
    pub readings: Vec<DiagnosisReading>,
    /// Contribution of each finding to every reading, in the order of the findings; empty if it was held out.
    pub doing: Vec<Vec<f64>>,
    /// Residuals of each stated hypothesis, in their order; empty if it was held out.
    pub stated: Vec<HypothesisReadings>,
    /// Possible drivers.
    pub drivers: Vec<DriverReadings>,
    /// Circles of a ball-bar.
    pub circles: Vec<Circle>,
}

/// Residuals of a stated hypothesis in addition to the findings that do not represent it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HypothesisReadings {
    /// Of every reading without the hypothesis; empty if the data cannot show it.
    pub without: Vec<f64>,
    /// Of every reading with it.
    pub with: Vec<f64>,
    /// Its drivers.
    pub drivers: Vec<DriverReadings>,
}

/// One reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DiagnosisReading {
    /// Row of the table, from 1.
    pub row: usize,
    /// Index in [`Set::parts`].
    pub part: usize,
    /// Residual of the model.
    pub before: f64,
    /// Residual after all findings.
    pub after: f64,
    /// `true` if it was used.
    pub counts: bool,
}

/// A possible driver of readings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriverReadings {
    /// Its name, as in findings.
    pub name: String,
    /// Its name with unit: `X in mm`.
    pub title: String,
    /// True for the time of the readings.
    pub is_time: bool,
    /// Its value for each reading.
    pub values: Vec<f64>,
}

/// A cause of the catalog.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriedCauseReport {
    /// Its name.
    pub cause: String,
    /// Kind of effect.
    pub effect: String,
    /// Evidence.
    pub shown_by: String,
    /// Number of its candidates.
    pub candidates: usize,
    /// Parameter of the best candidate that was not accepted, and its share of the residual squares.
    pub best: Option<(String, f64)>,
}

/// Fills in the readings of a diagnosis; the first `used` measurements were used.
pub(super) fn fill(
    (found, trials): (&DiagnosedCauses, &StatedTrials),
    scene: &Scene<'_>,
    used: usize,
    shown: &mut ShownReadings,
) {
    let drivers = drivers(scene);
    for number in 0..scene.sets.len() {
        for of_angles in [false, true] {
            shown.sets.extend(set((found, trials), scene, &drivers, (number, number >= used), of_angles));
        }
    }
    shown.causes = found.causes.iter().map(tried).collect();
}

fn tried(one: &diagnose::TriedCause) -> TriedCauseReport {
    TriedCauseReport {
        cause: one.cause.name.to_owned(),
        effect: one.cause.effect.to_string(),
        shown_by: one.cause.shown_by.to_owned(),
        candidates: one.candidates,
        best: one.best.clone(),
    }
}

/// All drivers: time, axes and their directions, further columns.
fn drivers(scene: &Scene<'_>) -> Vec<shape::Driver> {
    let axes: Vec<String> = scene.machine.axes.iter().flatten().map(|data| data.axis.to_string()).collect();
    let mut names = vec![TIME.to_owned()];
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
    (found, trials): (&DiagnosedCauses, &StatedTrials),
    scene: &Scene<'_>,
    drivers: &[shape::Driver],
    (number, is_held_out): (usize, bool),
    of_angles: bool,
) -> Option<Set> {
    let data = scene.sets.get(number)?;
    let is_own = |item: &SceneReading| {
        item.is_angle == of_angles && scene.rows.get(item.row).is_some_and(|row| row.set == number)
    };
    let places: Vec<usize> =
        scene.items.iter().enumerate().filter(|(_, item)| is_own(item)).map(|(place, _)| place).collect();
    if places.is_empty() {
        return None;
    }
    let unit = Unit::of(of_angles);
    let micro = unit.shown(1.0);
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
        out.push(DiagnosisReading {
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
    let stated = |trial: &HypothesisTrial| {
        let is_shown = trial.why_not_shown.is_none();
        let of = |values: &Vec<f64>| if is_shown { doing(values) } else { Vec::new() };
        HypothesisReadings {
            without: of(&trial.without),
            with: of(&trial.with),
            drivers: trial.drivers.iter().filter_map(|driver| along(driver, &rows)).collect(),
        }
    };
    let trials = trials.trials.iter().filter(|_| !is_held_out);
    Some(Set {
        name: data.name.clone(),
        kind: data.kind.name,
        is_held_out,
        unit,
        parts,
        setups: data.setups.iter().map(|setup| setup.label.clone()).collect(),
        circles: shown_circles(scene, number, &out),
        readings: out,
        doing: findings.map(|one| doing(&one.doing)).collect(),
        stated: trials.map(stated).collect(),
        drivers: drivers.iter().filter_map(|driver| along(driver, &rows)).collect(),
    })
}

/// A driver at the readings of some rows; `None` if it is constant there.
fn along(driver: &shape::Driver, rows: &[usize]) -> Option<DriverReadings> {
    let values: Vec<f64> = rows.iter().map(|&row| driver.values.get(row).copied().unwrap_or(f64::NAN)).collect();
    let mut known = values.iter().copied().filter(|value| value.is_finite());
    let first = known.next()?;
    if known.all(|value| (value - first).abs() <= 1e-9 * first.abs()) {
        return None;
    }
    let name = driver.name.clone();
    let is_time = name == TIME;
    if is_time && let Some((title, values)) = timed(values.clone()) {
        return Some(DriverReadings { name, title, is_time, values });
    }
    let title = match name.strip_suffix("_dir") {
        Some(axis) => format!("sense of {axis}"),
        None if driver.unit.is_empty() => name.clone(),
        None => format!("{name} in {}", driver.unit),
    };
    Some(DriverReadings { name, title, is_time, values })
}

/// The direction or component of a reading.
fn part_name(scene: &Scene<'_>, item: &SceneReading) -> String {
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

fn shown_circles(scene: &Scene<'_>, number: usize, readings: &[DiagnosisReading]) -> Vec<Circle> {
    let Some(data) = scene.sets.get(number).filter(|data| data.kind.measurand == Measurand::BallDistance) else {
        return Vec::new();
    };
    let places: HashMap<usize, usize> =
        readings.iter().enumerate().map(|(place, reading)| (reading.row - 1, place)).collect();
    let found = circles(scene.machine, data);
    found.iter().map(|circle| shown_circle(circle, data, |row| places.get(&row).copied())).collect()
}
