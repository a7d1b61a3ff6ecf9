//! Presentation of a fit: numbers in display units, and the table cells to which they refer.

use std::collections::HashMap;

use super::calibrated;
use super::compared::DOES_NOT_FIT;
use super::measurement::Measurement;
use crate::calibrate::effect::coefficient_unit;
use crate::calibrate::{Column, Estimate, Fit, Parameter};
use crate::measure::data::{DataSet, Observation};
use ncfix_base::csv::Table;
use ncfix_base::diagnostic::Place;
use ncfix_base::units::{Unit, um_from_mm};
use ncfix_model::ErrorModel;

/// An estimated number; `start` is the previous error model.
pub(super) fn estimate(found: &Estimate, start: &ErrorModel, data: &[DataSet]) -> calibrated::EstimateReport {
    let (factor, unit) = unit_of(&found.column, data);
    let name = found.column.name(data).to_string();
    let (before, effect_um) = match &found.column {
        Column::Parameter(name) => (name.get(start), Some(um_from_mm(found.effect_mm))),
        Column::Effect(parameter) => (Parameter::from(parameter.clone()).get(start), Some(um_from_mm(found.effect_mm))),
        Column::Unknown(..) => (0.0, None),
    };
    calibrated::EstimateReport {
        name,
        value: found.value * factor,
        sigma: found.sigma * factor,
        sigma_monte_carlo: None,
        unit,
        start: before * factor,
        effect_um,
        inflation: found.inflation,
    }
}

/// The display unit and the factor from mm, rad and powers of them: µm, µrad, per power of m or rad.
pub(super) fn unit_of(column: &Column, data: &[DataSet]) -> (f64, String) {
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

/// The rows with reduced weight, once each, with the places of their worst readings.
pub(super) fn weighted_down(fit: &Fit, all: &[Measurement]) -> Vec<(calibrated::OutlierRow, Place)> {
    let mut rows: Vec<(calibrated::OutlierRow, Place)> = Vec::new();
    let mut tables: Vec<Option<ReadingCells<'_>>> = all.iter().map(|_| None).collect();
    // Of the previous row: its measurement and index, and the number of its readings so far.
    let mut last = (usize::MAX, usize::MAX, 0);
    let mut shown = (usize::MAX, usize::MAX);
    for &(set, row, residual, weight) in &fit.residuals {
        last = if (last.0, last.1) == (set, row) { (set, row, last.2 + 1) } else { (set, row, 0) };
        if weight >= DOES_NOT_FIT {
            continue;
        }
        let (Some(measurement), Some(cells)) = (all.get(set), tables.get_mut(set)) else { continue };
        let Some(observation) = measurement.data.observations.get(row) else { continue };
        let place = cells.get_or_insert_with(|| ReadingCells::new(measurement)).place(observation, last.2);
        let source = &measurement.sources[0];
        let found = calibrated::OutlierRow {
            file: source.name().to_owned(),
            line: source.line_column(place.span.start).0,
            residual: Unit::of(observation.is_angle()).shown(residual),
            unit: Unit::of(observation.is_angle()),
            weight,
            is_without_direction: observation
                .component
                .and_then(|component| component.axis())
                .is_some_and(|axis| observation.reading.state.direction(axis) == 0),
        };
        // A row may have three readings: the worst is reported.
        match rows.last_mut().filter(|_| shown == (set, row)) {
            Some(known) if known.0.weight > weight => *known = (found, place),
            Some(_) => {}
            None => rows.push((found, place)),
        }
        shown = (set, row);
    }
    rows
}

/// The cells of a measurement.
pub(super) struct ReadingCells<'a> {
    measurement: &'a Measurement,
    table: Option<Table>,
    /// The indices of rows by their start offset.
    rows: HashMap<u32, usize>,
}

impl<'a> ReadingCells<'a> {
    /// Reads the table of a measurement again.
    pub(super) fn new(measurement: &'a Measurement) -> ReadingCells<'a> {
        let (table, _) = Table::read(&measurement.sources[0]);
        let places = table.iter().flat_map(Table::rows).map(|row| row.place(0).span.start);
        let rows = places.enumerate().map(|(number, start)| (start, number)).collect();
        ReadingCells { measurement, table, rows }
    }

    /// The place of a reading of a row, by index; the row itself if it has no separate cell.
    pub(super) fn place(&self, row: &Observation, number: usize) -> Place {
        let columns = self.measurement.data.kind.columns;
        let index = (0..row.values.len()).filter(|&k| row.values[k].is_some()).nth(number);
        let cell = || {
            let line = self.table.as_ref()?.rows().nth(*self.rows.get(&row.place.span.start)?)?;
            let filled = |name: &&str| line.column(name).filter(|&column| !line.text(column).is_empty());
            let single = columns.iter().find(|name| name.starts_with("value_") && filled(name).is_some());
            Some(line.place(filled(single.or_else(|| columns.get(index?))?)?))
        };
        cell().unwrap_or(row.place)
    }
}

/// The position of a value of a row in its table; the row itself if the table has no cell for it.
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
