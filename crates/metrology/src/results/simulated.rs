//! Simulated readings of a planned measurement: the plan's own table with the instrument readings.

use std::io::{self, Write};

use super::measurement::Measurement;
use crate::measure::data::{MOVED, Observation, TURNED};
use crate::measure::noise::Noise;
use crate::measure::reading::Readings;
use crate::measure::simulate::{ReadValue, Simulation};
use ncfix_base::csv::{DecimalSign, Row, Table, number_text};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_base::units::{rad_from_urad, um_from_mm, urad_from_rad};
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::edit::{Edit, Given};
use ncfix_model::{ErrorModel, Model};

/// Decimals of readings in µm and µrad.
const DECIMALS_UM: usize = 5;
/// Decimals of positions in mm.
const DECIMALS_MM: usize = 8;
/// Tolerance within which a position counts as on its limit, mm.
const ON_LIMIT: f64 = 1e-9;
const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// A planned measurement on a machine with errors.
#[derive(Clone, Copy, Debug)]
pub struct PlannedReadings<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Its errors.
    pub errors: &'a ErrorModel,
    /// The error model in the condition of the machine.
    pub model: &'a Model,
    /// The plan, with the conditions of its rows.
    pub plan: &'a Measurement,
    /// Its table.
    pub table: &'a Table,
}

/// A number for a column.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedCell {
    column: String,
    value: f64,
    decimals: usize,
}

impl PlannedReadings<'_> {
    /// The readings of every row, with normal noise of this standard deviation, mm, reproducible by a seed. Impossible readings are reported.
    pub fn rows(&self, noise_mm: Option<f64>, seed: u64, findings: &mut Vec<Diagnostic>) -> Vec<Vec<SimulatedCell>> {
        let data = &self.plan.data;
        let mut simulation = Simulation::new(self.machine, self.errors, data);
        let mut noise = Noise::new(seed);
        let mut next = |sigma: f64| if noise_mm.is_some() { sigma * noise.normal() } else { 0.0 };
        let sigma_mm = noise_mm.unwrap_or(0.0);
        let mut rows = Vec::new();
        let sign = self.sign();
        let [moved, turned] = [MOVED, TURNED].map(|name| self.table.column(name));
        for (row, cells) in data.observations.iter().zip(self.table.rows()) {
            // A known move of a test of signs shows in the reading.
            let moved = if row.is_angle() { turned } else { moved };
            let by = moved.and_then(|column| cells.number(column, sign).ok()).unwrap_or(0.0);
            match simulation.read(row) {
                Ok(ReadValue::Values(values)) => {
                    let cells = values.iter().enumerate().filter_map(|(k, value)| {
                        let value = (*value)?;
                        let column = column_of(data.kind.columns, row, k);
                        let um = if column.ends_with("urad") {
                            urad_from_rad(value + next(rad_from_urad(um_from_mm(sigma_mm))))
                        } else {
                            um_from_mm(value + next(sigma_mm))
                        };
                        Some(SimulatedCell { column, value: um + by, decimals: DECIMALS_UM })
                    });
                    rows.push(cells.collect());
                }
                Ok(ReadValue::Position(mut position)) => {
                    LINEAR.iter().for_each(|&axis| position[axis] += next(sigma_mm));
                    self.check_travel(&position, row.place, findings);
                    rows.push(self.position_cells(row, &position));
                }
                Err(_) => {
                    let message = "the linear axes cannot bring the tip to the ball";
                    let help = "probing needs three linear axes; check place_mm of the ball and the angles of the row";
                    findings.push(Diagnostic::at(Code::NOT_CONVERGED, row.place, message, help));
                }
            }
        }
        rows
    }

    /// Positions of a probing, with the directions of motion of the plan if the order of noisy positions could contradict them.
    fn position_cells(&self, row: &Observation, position: &AxisVector) -> Vec<SimulatedCell> {
        let mut cells: Vec<SimulatedCell> = LINEAR
            .iter()
            .map(|&axis| SimulatedCell { column: axis.to_string(), value: position[axis], decimals: DECIMALS_MM })
            .collect();
        let with_backlash = LINEAR.into_iter().filter(|&axis| self.model.features(axis).backlash);
        cells.extend(with_backlash.map(|axis| SimulatedCell {
            column: format!("{axis}_dir"),
            value: f64::from(row.reading.state.direction(axis)),
            decimals: 0,
        }));
        cells
    }

    fn check_travel(&self, position: &AxisVector, place: Place, findings: &mut Vec<Diagnostic>) {
        for axis in LINEAR {
            let Some([low, high]) = self.machine.axis(axis).and_then(|data| data.travel) else { continue };
            if !(low - ON_LIMIT..=high + ON_LIMIT).contains(&position[axis]) {
                let message = format!(
                    "to reach the ball {axis} would move to {:.3} mm, outside its travel of {low} … {high} mm",
                    position[axis]
                );
                let help = "check place_mm of the ball, or move the row away from the end of the travel";
                findings.push(Diagnostic::at(Code::OUT_OF_TRAVEL, place, message, help));
            }
        }
    }

    /// Writes the table with the cells; missing columns are appended.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn write(&self, rows: &[Vec<SimulatedCell>], out: &mut dyn Write) -> io::Result<()> {
        let sign = self.sign();
        let separator = char::from(self.table.separator());
        let mut added: Vec<&str> = Vec::new();
        for cell in rows.iter().flatten() {
            if self.table.column(&cell.column).is_none() && !added.contains(&cell.column.as_str()) {
                added.push(&cell.column);
            }
        }
        let last = self.table.names().len().saturating_sub(1);
        let mut copy = self.table.copy(out);
        let names: String = added.iter().map(|name| format!("{separator}{name}")).collect();
        copy.replace(self.table.place_behind(self.table.header_place(Some(last))), &names)?;
        for (row, cells) in self.table.rows().zip(rows) {
            let mut own: Vec<(usize, &SimulatedCell)> =
                cells.iter().filter_map(|cell| Some((self.table.column(&cell.column)?, cell))).collect();
            own.sort_by_key(|&(column, _)| column);
            for (column, cell) in own {
                copy.replace(row.place(column), &self.text(cell, &row, column, sign))?;
            }
            let more = added.iter().map(|name| {
                let cell = cells.iter().find(|cell| cell.column == *name);
                let text = cell.map_or(String::new(), |cell| self.text(cell, &row, usize::MAX, sign));
                format!("{separator}{text}")
            });
            copy.replace(self.table.place_behind(row.place(last)), &more.collect::<String>())?;
        }
        copy.finish()
    }

    fn sign(&self) -> DecimalSign {
        Readings::with(self.table, self.machine, &self.plan.data.fixed)
            .map_or(DecimalSign::Point, |readings| readings.sign())
    }

    fn text(&self, cell: &SimulatedCell, row: &Row<'_>, column: usize, sign: DecimalSign) -> String {
        let text = number_text(cell.value, cell.decimals, row.text(column), sign);
        let needs_quotes = sign == DecimalSign::Comma && self.table.separator() == b',' && row.text(column).is_empty();
        if needs_quotes && text.contains(',') { format!("\"{text}\"") } else { text }
    }

    /// The description, with the uncertainty of the instrument, mm, if it has none.
    #[must_use]
    pub fn description(&self, noise: Option<f64>) -> Vec<u8> {
        let bytes = self.plan.sources[1].bytes();
        let (Some(noise), None) = (noise, self.plan.data.sigma) else { return bytes.to_vec() };
        let Some(mut edit) = std::str::from_utf8(bytes).ok().and_then(Edit::parse) else { return bytes.to_vec() };
        edit.set("measurement", "sigma_um", &Given::Number(um_from_mm(noise)));
        // If lengths and angles were read, angles have as many µrad.
        let rows = &self.plan.data.observations;
        let is_mixed = rows.iter().any(Observation::is_angle) && !rows.iter().all(Observation::is_angle);
        if is_mixed && self.plan.data.sigma_rad.is_none() {
            edit.set("measurement", "sigma_urad", &Given::Number(um_from_mm(noise)));
        }
        edit.text().into_bytes()
    }
}

/// The column of a value: one for each value, or for single components that of their unit.
fn column_of(columns: &[&str], row: &Observation, index: usize) -> String {
    let column = match row.component {
        Some(name) if name.direction.is_rotation() => columns.iter().find(|name| name.ends_with("_urad")),
        Some(_) => columns.iter().find(|name| name.ends_with("_um")),
        None => columns.get(index),
    };
    column.map_or_else(String::new, |&column| column.to_owned())
}
