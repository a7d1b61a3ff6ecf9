//! The residual of every reading of a fit, as a table in CSV.

use std::fmt::Write as _;

use super::cells::ReadingCells;
use super::held::value_name;
use super::measurement::Measurement;
use crate::calibrate::Fit;
use ncfix_base::geometry::Axis;
use ncfix_base::units::Unit;
use ncfix_machine::machine::Machine;

/// Decimals of readings, 0.1 nm or nrad, and of positions, nm or 1e-6 degrees.
const DECIMALS: [i32; 2] = [4, 6];

/// Returns the residuals of the readings that a fit used: file and line, set-up, positions of all axes (mm or degrees), the value that was read, its unit (um or
/// urad), reading, prediction of the fitted model with the unknowns of the set-up, reading minus prediction, and weight. A probed ball has no reading of its
/// own: these cells are empty.
#[must_use]
pub(super) fn residual_table(machine: &Machine, fit: &Fit, used: &[Measurement]) -> String {
    let axes: Vec<Axis> = machine.axes.iter().flatten().map(|data| data.axis).collect();
    let mut out = "file,line,setup".to_owned();
    for axis in &axes {
        // Writing into a String cannot fail.
        let _ = write!(out, ",{axis}_{}", if axis.is_rotary() { "deg" } else { "mm" });
    }
    out.push_str(",value,unit,reading,model,residual,weight\n");
    let mut tables: Vec<Option<ReadingCells<'_>>> = used.iter().map(|_| None).collect();
    let mut last = (usize::MAX, usize::MAX, 0);
    for &(set, row, residual, weight) in &fit.residuals {
        last = if (last.0, last.1) == (set, row) { (set, row, last.2 + 1) } else { (set, row, 0) };
        let (Some(measurement), Some(cells)) = (used.get(set), tables.get_mut(set)) else { continue };
        let data = &measurement.data;
        let Some(observation) = data.observations.get(row) else { continue };
        let place = cells.get_or_insert_with(|| ReadingCells::new(measurement)).place(observation, last.2);
        let source = &measurement.sources[0];
        let setup = data.setups.get(observation.setup).map_or("", |setup| setup.label.as_str());
        let line = source.line_column(place.span.start).0;
        let _ = write!(out, "{},{line},{}", quoted(source.name()), quoted(setup));
        for &axis in &axes {
            let at = observation.reading.position[axis];
            let _ = write!(out, ",{}", rounded(if axis.is_rotary() { at.to_degrees() } else { at }, DECIMALS[1]));
        }
        let unit = Unit::of(observation.is_angle());
        let shown = |value: f64| rounded(unit.shown(value), DECIMALS[0]);
        let reading = observation.values.iter().flatten().nth(last.2);
        let cell = |value: Option<f64>| value.map_or_else(String::new, |value| shown(value).to_string());
        let _ = writeln!(
            out,
            ",{},{},{},{},{},{}",
            quoted(&value_name(data, row, last.2)),
            if observation.is_angle() { "urad" } else { "um" },
            cell(reading.copied()),
            cell(reading.map(|reading| reading - residual)),
            shown(residual),
            rounded(weight, DECIMALS[0])
        );
    }
    out
}

/// A number with few decimals, without a negative zero.
fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).round() / scale + 0.0
}

/// A cell; in quotation marks if it has signs of the table.
fn quoted(text: &str) -> String {
    if text.contains([',', ';', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}
