//! Figures of the acceptance tests of a measurement.

use serde::Serialize;

use super::features::{self, FeatureDeviation};
pub use super::figure::{FigureGroup, FigureValue, Standard};
use crate::measure::data::DataSet;
use crate::measure::iso230::figures::{self as iso230, CirclePath, Figures, MeasuredFigures, RUNS};
use crate::measure::iso230::positioning::OneWay;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::units::{Unit, um_from_mm, urad_from_rad};
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

/// The figures of a measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MeasurementFigures {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// Its figures.
    pub figures: Vec<FigureGroup>,
    /// Features of a workpiece, in the order of the table; empty for other measurements.
    pub features: Vec<FeatureDeviation>,
}

/// The figures of a measurement.
#[must_use]
pub fn of(data: &DataSet, machine: &Machine) -> MeasurementFigures {
    let figures = iso230::figures(data, machine).iter().map(group).collect();
    MeasurementFigures { name: data.name.clone(), kind: data.kind.name, figures, features: Vec::new() }
}

/// The figures of measurements; a diagnostic for each that has none, unless others have some. Features of a workpiece are compared with these errors of the machine, and with
/// those of the first workpiece.
#[must_use]
pub fn of_all(
    all: &[super::measurement::Measurement],
    machine: &Machine,
    errors: &ErrorModel,
) -> (Vec<MeasurementFigures>, Vec<Diagnostic>) {
    let mut found = Vec::new();
    let mut measurements: Vec<MeasurementFigures> = Vec::new();
    for one in all {
        let mut of = of(&one.data, machine);
        if let Some((figures, features)) = features::figures(one, machine, errors) {
            of.figures.extend(figures);
            let earlier = measurements.iter().find(|earlier| !earlier.features.is_empty());
            of.figures
                .extend(earlier.and_then(|earlier| features::against(&earlier.name, &earlier.features, &features)));
            of.features = features;
        }
        if of.figures.is_empty() {
            let message = format!("{}: ncfix calculates no figures of ISO 230 for a {} measurement", of.name, of.kind);
            let help = "give readings of single components (direct), of a ball-bar, or of features (a column feature)";
            found.push(Diagnostic::nowhere(Code::DATA_COLUMN, message, help));
        }
        measurements.push(of);
    }
    if measurements.iter().any(|one| !one.figures.is_empty()) {
        found.clear();
    }
    (measurements, found)
}

fn group(found: &MeasuredFigures) -> FigureGroup {
    let mut group =
        FigureGroup { setup: found.setup.clone(), of: found.of.clone(), unit: Unit::Um, ..FigureGroup::default() };
    match &found.figures {
        Ok(figures) => fill(&mut group, figures),
        Err(reason) => group.reason = Some(reason.clone()),
    }
    group
}

fn fill(group: &mut FigureGroup, figures: &Figures) {
    let mut put = |name: &'static str, value: Option<f64>, factor: f64| {
        group.values.extend(value.map(|value| FigureValue { name, value: value * factor }));
    };
    let um = um_from_mm(1.0);
    match figures {
        Figures::Positioning { figures, is_angle, without_drift, left_out } => {
            let factor = if *is_angle { urad_from_rad(1.0) } else { um };
            let (both, up, down) = (figures.both.as_ref(), figures.up.as_ref(), figures.down.as_ref());
            let of = |side: Option<&OneWay>, value: fn(&OneWay) -> f64| side.map(value);
            put("A", both.map(|both| both.accuracy), factor);
            put("A+", of(up, |up| up.accuracy), factor);
            put("A-", of(down, |down| down.accuracy), factor);
            put("E", both.map(|both| both.systematic), factor);
            put("E+", of(up, |up| up.systematic), factor);
            put("E-", of(down, |down| down.systematic), factor);
            put("R", both.map(|both| both.repeatability), factor);
            put("R+", of(up, |up| up.repeatability), factor);
            put("R-", of(down, |down| down.repeatability), factor);
            put("B", both.map(|both| both.reversal), factor);
            put("B mean", both.map(|both| both.mean_reversal), factor);
            put("M", both.map(|both| both.mean_systematic), factor);
            group.standard = Standard::Iso230Part2;
            group.unit = Unit::of(*is_angle);
            let fewer =
                if figures.runs < RUNS { format!(", the standard requires {RUNS} runs") } else { String::new() };
            group.conditions =
                vec![format!("{} targets", figures.targets.len()), format!("{} runs{fewer}", figures.runs)];
            add_state(group, *without_drift, *left_out);
        }
        Figures::Straightness { figures, deviation, without_drift, left_out } => {
            put("straightness", Some(deviation[0]), um);
            put("end points", Some(deviation[1]), um);
            put("R", figures.both.map(|both| both.repeatability), um);
            put("B", figures.both.map(|both| both.reversal), um);
            put("B mean", figures.both.map(|both| both.mean_reversal), um);
            group.standard = Standard::Iso230Part1;
            group.conditions = vec![format!("{} targets", figures.targets.len()), format!("{} runs", figures.runs)];
            add_state(group, *without_drift, *left_out);
        }
        Figures::Circle { figures, radius_mm, paths } => {
            let end = |ends: Option<[f64; 2]>, which: usize| ends.and_then(|ends| ends.get(which).copied());
            put("G(ccw)", figures.g_counter, um);
            put("G(cw)", figures.g_clock, um);
            put("G(b)", figures.g_both, um);
            put("D(b)", figures.d, um);
            put("H", figures.h, um);
            put("F(ccw) max", end(figures.f_counter, 0), um);
            put("F(ccw) min", end(figures.f_counter, 1), um);
            put("F(cw) max", end(figures.f_clock, 0), um);
            put("F(cw) min", end(figures.f_clock, 1), um);
            put("eccentricity 1", Some(figures.centre_mm[0]), um);
            put("eccentricity 2", Some(figures.centre_mm[1]), um);
            group.standard = Standard::Iso230Part4;
            group.conditions = vec![format!("R {radius_mm:.3} mm")];
            let named = ["ccw", "cw"].into_iter().zip(paths).filter(|(_, path)| path.points > 0);
            group.conditions.extend(named.map(|(name, path)| shown(name, path)));
        }
        Figures::Sphere { sphere, radius_mm, points } => {
            put("size", Some(sphere.radius_mm - radius_mm), um);
            put("form", Some(sphere.form_mm), um);
            put("s", Some(sphere.deviation_mm), um);
            put("center X", Some(sphere.centre_mm.x), um);
            put("center Y", Some(sphere.centre_mm.y), um);
            put("center Z", Some(sphere.centre_mm.z), um);
            group.standard = Standard::LeastSquares;
            group.conditions = vec![format!("R {radius_mm:.3} mm"), format!("{points} readings")];
        }
    }
}

/// Adds the conditions of the readings to those of their targets.
fn add_state(group: &mut FigureGroup, without_drift: bool, left_out: usize) {
    if without_drift {
        group.conditions.push("zero drift removed".into());
    }
    if left_out > 0 {
        group.conditions.push(format!("{left_out} left out, direction unknown"));
    }
}

fn shown(name: &str, path: &CirclePath) -> String {
    let feed = path.feed.map_or(String::new(), |feed| format!(" F {feed:.0} mm/min"));
    let start = path.start.to_degrees();
    format!("{name} {:.0}° from {start:.1}°{feed}, {} readings", path.arc.to_degrees(), path.points)
}
