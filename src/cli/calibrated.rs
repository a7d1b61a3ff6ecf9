//! What `ncfix calibrate` reports of a fit: numbers in the units of people.

use super::measurement::Measurement;
use crate::calibrate::effect::coefficient_unit;
use crate::calibrate::{Column, Estimate, Fit, Parameter};
use crate::csv::Table;
use crate::diagnostic::Place;
use crate::measure::data::{DataSet, Observation};
use crate::model::ErrorModel;
use crate::report::calibration;
use crate::report::compared::DOES_NOT_FIT;
use crate::units::{um_from_mm, urad_from_rad};

/// A number that was found; `start` is the error model before.
pub(super) fn estimate(found: &Estimate, start: &ErrorModel, data: &[DataSet]) -> calibration::Estimate {
    let (factor, unit) = unit_of(&found.column, data);
    let name = found.column.name(data).to_string();
    let (before, effect_um) = match &found.column {
        Column::Parameter(name) => (name.get(start), Some(um_from_mm(found.effect_mm))),
        Column::Effect(parameter) => (Parameter::from(parameter.clone()).get(start), Some(um_from_mm(found.effect_mm))),
        Column::Unknown(..) => (0.0, None),
    };
    calibration::Estimate {
        name,
        value: found.value * factor,
        sigma: found.sigma * factor,
        unit,
        start: before * factor,
        effect_um,
        inflation: found.inflation,
    }
}

/// The factor from mm, rad and powers of them to the unit that is shown: µm, µrad, per power of m or rad.
fn unit_of(column: &Column, data: &[DataSet]) -> (f64, String) {
    if let Some(mm_per_k) = column.mm_per_k(data) {
        return (1.0 / mm_per_k, "K".into());
    }
    match column {
        Column::Parameter(name) => {
            let is_rotary = name.component.axis().is_some_and(|axis| axis.is_rotary());
            coefficient_unit(column.is_angle(data), is_rotary, name.degree())
        }
        Column::Effect(parameter) => {
            let (factor, unit) = parameter.unit();
            (factor, unit.to_owned())
        }
        Column::Unknown(..) => coefficient_unit(column.is_angle(data), false, 0),
    }
}

/// The rows that count for less because they do not fit, once each, with their places and the number of their measurement.
pub(super) fn weighted_down(fit: &Fit, all: &[Measurement]) -> Vec<(calibration::Row, usize, Place)> {
    let mut rows: Vec<(calibration::Row, usize, Place)> = Vec::new();
    for &(set, row, residual, weight) in fit.residuals.iter().filter(|&&(_, _, _, weight)| weight < DOES_NOT_FIT) {
        let Some(measurement) = all.get(set) else { continue };
        let Some(place) = measurement.data.observations.get(row).map(|row| row.place) else { continue };
        let source = &measurement.sources[0];
        let is_angle = measurement.data.observations.get(row).is_some_and(Observation::is_angle);
        let found = calibration::Row {
            file: source.name().to_owned(),
            line: source.line_column(place.span.start).0,
            residual: if is_angle { urad_from_rad(residual) } else { um_from_mm(residual) },
            unit: if is_angle { "µrad" } else { "µm" },
            weight,
        };
        // A row may have three readings: the worst says it all.
        match rows.iter_mut().find(|(_, of, known)| *of == set && *known == place) {
            Some((known, _, _)) if known.weight > weight => *known = found,
            Some(_) => {}
            None => rows.push((found, set, place)),
        }
    }
    rows
}

/// Where a value of a row stands in its table; the row itself where there is none.
pub(super) fn cell(measurement: &Measurement, row: Place, index: usize) -> (Place, String) {
    let (table, _) = Table::read(&measurement.sources[0]);
    let columns = measurement.data.kind.columns;
    table
        .as_ref()
        .and_then(|table| {
            let row = table.rows().find(|found| found.place(0) == row)?;
            let named = |name: &&str| row.column(name).filter(|&column| !row.text(column).is_empty());
            let single = |name: &&&str| name.starts_with("value_") && named(name).is_some();
            let name = columns.iter().find(single).or_else(|| columns.get(index))?;
            let column = named(name)?;
            let shown = String::from_utf8_lossy(row.text(column)).trim().to_owned();
            Some((row.place(column), format!("{name} {shown}")))
        })
        .unwrap_or((row, "the reading".into()))
}
