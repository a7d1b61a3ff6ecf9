//! Measurement mode for a table: removes the corrections from measured positions, row by row.

use std::io::{self, Write};
use std::ops::ControlFlow;

use serde::Serialize;

use crate::measure::mode;
use crate::measure::reading::{Reading, Readings};
use ncfix_base::csv::{Copy, DecimalSign, Row, Table, number_text};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_base::number::micrometers;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::{Condition, Kinematics, Machine};
use ncfix_model::{ErrorModel, Model, NotConverged, Solve};

/// Decimals of mm: a hundredth of the promised accuracy.
const DECIMALS_MM: usize = 8;
/// Decimals of degrees: 1e-7 mm at an arm of 500 mm.
const DECIMALS_DEG: usize = 10;

/// A table of positions after removal of their corrections.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CorrectedReadings {
    /// Axes with a column.
    pub axes: Vec<AxisCorrection>,
    /// Number of data rows.
    pub rows: u64,
    /// Number of rows in which an axis with backlash has no direction of motion yet.
    pub without_sense: u64,
    /// Name of the machine.
    pub machine: String,
}

/// The corrections of an axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AxisCorrection {
    /// Axis.
    pub axis: String,
    /// Size of the corrections.
    #[serde(flatten)]
    pub size: CorrectionSize,
}

/// Absolute size of corrections.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
#[expect(missing_docs, reason = "mean and largest, with their units")]
pub enum CorrectionSize {
    /// Of a linear axis.
    Length { mean_um: f64, max_um: f64 },
    /// Of a rotary axis.
    Angle { mean_urad: f64, max_urad: f64 },
}

/// Statistics of corrections.
#[derive(Clone, Debug, Default)]
struct CorrectionSums {
    rows: u64,
    /// Sum of the absolute corrections, mm and rad.
    sum: AxisVector,
    /// Largest absolute correction, mm and rad.
    max: AxisVector,
    without_sense: u64,
}

impl CorrectionSums {
    fn note(&mut self, correction: &AxisVector) {
        self.rows += 1;
        for ((sum, max), size) in self.sum.0.iter_mut().zip(&mut self.max.0).zip(correction.0) {
            *sum += size.abs();
            *max = max.max(size.abs());
        }
    }

    fn result(&self, axes: &[Axis], machine: &Machine) -> CorrectedReadings {
        let of = |&axis: &Axis| {
            let (mean, max) = (self.sum[axis] / self.rows.max(1) as f64, self.max[axis]);
            let size = if axis.is_rotary() {
                CorrectionSize::Angle { mean_urad: urad_from_rad(mean), max_urad: urad_from_rad(max) }
            } else {
                CorrectionSize::Length { mean_um: um_from_mm(mean), max_um: um_from_mm(max) }
            };
            AxisCorrection { axis: axis.to_string(), size }
        };
        CorrectedReadings {
            axes: axes.iter().map(of).collect(),
            rows: self.rows,
            without_sense: self.without_sense,
            machine: machine.name.clone(),
        }
    }
}

/// Settings for removing corrections from readings.
#[derive(Clone, Copy, Debug)]
pub struct ReadingCorrection<'a> {
    /// The measured machine.
    pub machine: &'a Machine,
    /// Its errors.
    pub errors: &'a ErrorModel,
    /// Its condition; from a log, that at the time of each row, if the rows have times.
    pub condition: &'a Condition,
    /// Selects whether rotary axes are corrected too.
    pub solve: Solve,
    /// Largest accepted correction, mm at the tool.
    pub max_correction_mm: f64,
}

impl ReadingCorrection<'_> {
    /// Writes a copy of the table with corrected positions. `progress` receives the completed share of the rows; `found` receives diagnostics and
    /// returns `true` to continue. After the first error the copy is invalid, but all diagnostics are collected.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn write(
        &self,
        table: &Table,
        mut readings: Readings<'_>,
        out: &mut dyn Write,
        progress: &mut dyn FnMut(f64),
        found: &mut dyn FnMut(Vec<Diagnostic>) -> ControlFlow<()>,
    ) -> io::Result<CorrectedReadings> {
        let mut model = Model::at(self.machine, self.errors, self.condition);
        let mut clock = Clock::new(table, self);
        let axes: Vec<Axis> = readings.axes().iter().map(|&(axis, _)| axis).collect();
        let mut sizes = CorrectionSums::default();
        let kinematics = Kinematics::new(self.machine);
        let mut fault = None;
        let mut copy = table.copy(out);
        let count = table.row_count().max(1) as f64;
        for (index, row) in table.rows().enumerate() {
            progress(index as f64 / count);
            match clock.model_at(&row, readings.sign()) {
                Ok(Some(then)) => model = then,
                Ok(None) => {}
                Err(diagnostic) => {
                    let _ = found(vec![diagnostic]);
                    continue;
                }
            }
            let faults = match readings.read(&row) {
                Ok(reading) => match mode::nominal(&model, &reading, self.solve) {
                    Ok(nominal) => {
                        if let Some(diagnostic) = self.too_large(&kinematics, &reading, &nominal, &row, &readings) {
                            let _ = found(vec![diagnostic]);
                            continue;
                        }
                        sizes.note(&(reading.position - nominal));
                        sizes.without_sense += u64::from(lacks_sense(&model, &reading, &readings));
                        fault = fault.or(put(&mut copy, &row, &readings, &reading, &nominal).err());
                        continue;
                    }
                    Err(failure) => vec![not_converged(failure, &row, &readings)],
                },
                Err(faults) => faults,
            };
            if found(faults).is_break() {
                break;
            }
        }
        let fault = fault.or(copy.finish().err());
        fault.map_or_else(|| Ok(sizes.result(&axes, self.machine)), Err)
    }

    /// The diagnostic for a position whose correction is larger than permitted, as for a program.
    fn too_large(
        &self,
        kinematics: &Kinematics,
        reading: &Reading,
        nominal: &AxisVector,
        row: &Row,
        readings: &Readings,
    ) -> Option<Diagnostic> {
        let most_mm = self.max_correction_mm;
        readings.axes().iter().find_map(|&(axis, column)| {
            let correction = reading.position[axis] - nominal[axis];
            let at_tip_mm = if axis.is_rotary() && correction != 0.0 {
                kinematics.arc_mm(axis, (nominal, reading.position[axis]), &reading.tool_mm)
            } else {
                correction
            };
            if (..=most_mm).contains(&at_tip_mm.abs()) {
                return None;
            }
            let (at_tip, most) = (micrometers(um_from_mm(at_tip_mm)), micrometers(um_from_mm(most_mm)));
            let message = format!("the correction of {axis} is {at_tip} at the tool, more than {most}");
            let help = "check the units in the machine file before raising --max-correction";
            Some(Diagnostic::at(Code::CORRECTION_TOO_LARGE, row.place(column), message, help))
        })
    }
}

/// The condition of the machine at each row, if the rows have times and the state is a log.
struct Clock<'a> {
    correction: &'a ReadingCorrection<'a>,
    condition: Condition,
    column: Option<usize>,
}

impl<'a> Clock<'a> {
    fn new(table: &Table, correction: &'a ReadingCorrection<'a>) -> Clock<'a> {
        let is_log = correction.condition.time_range_s().is_some_and(|[first, last]| first < last);
        let column = table.column("t_s").filter(|_| is_log);
        Clock { correction, condition: correction.condition.clone(), column }
    }

    /// The model at the time of a row; `None` if it is that of the previous row.
    fn model_at(&mut self, row: &Row, sign: DecimalSign) -> Result<Option<Model>, Diagnostic> {
        let Some(column) = self.column else { return Ok(None) };
        let time_s = row.number(column, sign)?;
        let [first, last] = self.condition.time_range_s().unwrap_or_default();
        if !(first..=last).contains(&time_s) {
            let message = format!("{time_s} s lies outside the log of the state, which runs from {first} to {last} s");
            let help = "give a log that covers the readings, or rename the column if it is not the time of the log";
            return Err(Diagnostic::at(Code::DATA_CELL, row.place(column), message, help));
        }
        if time_s == self.condition.time_s() {
            return Ok(None);
        }
        self.condition.set_time(time_s);
        Ok(Some(Model::at(self.correction.machine, self.correction.errors, &self.condition)))
    }
}

/// Writes the positions of a row. A position without a correction keeps its text.
fn put<W: std::io::Write>(
    copy: &mut Copy<W>,
    row: &Row,
    readings: &Readings,
    reading: &Reading,
    nominal: &AxisVector,
) -> std::io::Result<()> {
    let mut columns = readings.axes().to_vec();
    columns.sort_by_key(|&(_, column)| column);
    for (axis, column) in columns {
        let value = nominal[axis];
        if value == reading.position[axis] {
            continue;
        }
        let (value, decimals) =
            if axis.is_rotary() { (value.to_degrees(), DECIMALS_DEG) } else { (value, DECIMALS_MM) };
        copy.replace(row.place(column), &number_text(value, decimals, row.text(column), readings.sign()))?;
    }
    Ok(())
}

/// `true` if an axis with a direction-dependent error has no direction.
fn lacks_sense(model: &Model, reading: &Reading, readings: &Readings) -> bool {
    readings.axes().iter().any(|&(axis, _)| model.features(axis).backlash && reading.state.direction(axis) == 0)
}

/// The diagnostic for a row without a solution.
fn not_converged(failure: NotConverged, row: &Row, readings: &Readings) -> Diagnostic {
    let column = readings.axes().first().map_or(0, |&(_, column)| column);
    let mut message = "no corrected position was found for this reading".to_owned();
    if failure.residual_mm.is_finite() {
        message.push_str(&format!("; the residual is {}", micrometers(um_from_mm(failure.residual_mm))));
    }
    let help = "check the error model; near a pole of the rotary axes try --rotary hold";
    Diagnostic::at(Code::NOT_CONVERGED, row.place(column), message, help)
}
