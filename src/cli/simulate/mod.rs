//! `ncfix simulate`: what instruments would read on a machine with errors.

pub(in crate::cli) mod arguments;
mod trace;

use crate::cli::arguments::SimulateArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::findings::Findings;
use crate::cli::input::is_standard_stream;
use crate::cli::measurement::{self, description_of};
use crate::cli::output::{Spool, Target};
use crate::cli::program::protect;
use crate::cli::stop::Stop;
use crate::cli::together::Together;
use crate::cli::{machine_choice, state, tell};
use ncfix_base::csv::{DecimalSign, Row, Table, number_text};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_base::units::{rad_from_urad, um_from_mm, urad_from_rad};
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::edit::{Edit, Given};
use ncfix_metrology::measure::data::Observation;
use ncfix_metrology::measure::noise::Noise;
use ncfix_metrology::measure::reading::Readings;
use ncfix_metrology::measure::simulate::{Read, Simulation};
use ncfix_metrology::results::measurement::Measurement;
use ncfix_model::{ErrorModel, Model};

/// Decimals of readings in µm and µrad.
const DECIMALS_UM: usize = 5;
/// Decimals of positions in mm.
const DECIMALS_MM: usize = 8;
/// A position this much beyond its limit is on it, mm.
const ON_LIMIT: f64 = 1e-9;
const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// Simulates a measurement.
pub(in crate::cli) fn run(arguments: &SimulateArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let is_plan = arguments.plan.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
    if !is_plan {
        return trace::run(arguments);
    }
    if !arguments.feed.is_empty() {
        return Err(Stop::Usage("--feed is for part programs; a plan says itself what is read".into()));
    }
    let result = simulate(arguments, &mut findings);
    findings.draw();
    match result? {
        Some(rows) => tell(&format!("{rows} rows simulated, written {}\n", arguments.output.display())),
        None => tell(&format!("{}; nothing was written\n", findings.count())),
    }
    Ok(findings.exit_code())
}

/// Writes both files; the number of rows, `None` where findings forbid it.
fn simulate(arguments: &SimulateArguments, findings: &mut Findings) -> Result<Option<usize>, Stop> {
    if is_standard_stream(&arguments.output) {
        return Err(Stop::Usage("a measurement is a pair of files, NAME.csv and NAME.toml; give -o NAME.csv".into()));
    }
    let paths = [arguments.output.clone(), description_of(&arguments.output)?];
    let targets = [Target::new(&paths[0])?, Target::new(&paths[1])?];
    if targets.iter().any(|target| !target.is_file()) {
        return Err(Stop::Usage("a measurement is a pair of files, NAME.csv and NAME.toml; give -o NAME.csv".into()));
    }
    let Some(mut chosen) = machine_choice::choose(&arguments.machine, &arguments.plan, findings)? else {
        return Ok(None);
    };
    if !state::apply(&arguments.state, &mut chosen, findings)? {
        return Ok(None);
    }
    let inputs = [arguments.plan.clone(), description_of(&arguments.plan)?];
    for target in &targets {
        protect(target, chosen.files.iter().chain(&inputs), findings);
    }
    let read = measurement::read(&arguments.plan, 0, true, &chosen.machine, findings)?;
    let Some(mut plan) = read.filter(|_| !findings.has_errors()) else { return Ok(None) };
    let (Some(table), _) = Table::read(&plan.sources[0]) else { return Ok(None) };
    plan.data.fill_in(&chosen.condition);
    let model = chosen.model();
    let job = Job { machine: &chosen.machine, errors: &chosen.errors, model: &model, plan: &plan, table: &table };
    let rows = job.rows(arguments, findings);
    if findings.has_errors() {
        return Ok(None);
    }
    let [data, description] = targets;
    let mut data = Spool::new(data)?;
    if let Err(error) = job.write(&rows, data.writer()) {
        return Err(data.fault(&error).into());
    }
    let mut together = Together::default();
    together.take(data)?;
    together.add(description, &job.description(arguments.noise))?;
    together.publish()?;
    Ok(Some(rows.len()))
}

struct Job<'a> {
    machine: &'a Machine,
    errors: &'a ErrorModel,
    model: &'a Model,
    plan: &'a Measurement,
    table: &'a Table,
}

/// A number on its way into a column.
struct Cell {
    column: String,
    value: f64,
    decimals: usize,
}

impl Job<'_> {
    /// What is read in every row.
    fn rows(&self, arguments: &SimulateArguments, findings: &mut Findings) -> Vec<Vec<Cell>> {
        let data = &self.plan.data;
        let mut simulation = Simulation::new(self.machine, self.errors, data);
        let mut noise = Noise::new(arguments.seed);
        let mut next = |sigma: f64| if arguments.noise.is_some() { sigma * noise.normal() } else { 0.0 };
        let sigma_mm = arguments.noise.unwrap_or(0.0);
        let mut rows = Vec::new();
        for row in &data.observations {
            match simulation.read(row) {
                Ok(Read::Values(values)) => {
                    let cells = values.iter().enumerate().filter_map(|(k, value)| {
                        let value = (*value)?;
                        let column = column_of(data.kind.columns, row, k);
                        let um = if column.ends_with("urad") {
                            urad_from_rad(value + next(rad_from_urad(um_from_mm(sigma_mm))))
                        } else {
                            um_from_mm(value + next(sigma_mm))
                        };
                        Some(Cell { column, value: um, decimals: DECIMALS_UM })
                    });
                    rows.push(cells.collect());
                }
                Ok(Read::Position(mut position)) => {
                    LINEAR.iter().for_each(|&axis| position[axis] += next(sigma_mm));
                    self.check_travel(&position, row.place, findings);
                    rows.push(self.position_cells(row, &position));
                }
                Err(_) => {
                    let message = "the linear axes cannot bring the tip to the ball";
                    let help = "probing needs three linear axes; check place_mm of the ball and the angles of the row";
                    let found = Diagnostic::at(Code::NOT_CONVERGED, row.place, message, help);
                    findings.add(found, &self.plan.sources);
                }
            }
        }
        rows
    }

    /// Positions of a probing, and where the order of noisy positions could say otherwise the senses of motion of the plan.
    fn position_cells(&self, row: &Observation, position: &AxisVector) -> Vec<Cell> {
        let mut cells: Vec<Cell> = LINEAR
            .iter()
            .map(|&axis| Cell { column: axis.to_string(), value: position[axis], decimals: DECIMALS_MM })
            .collect();
        let with_backlash = LINEAR.into_iter().filter(|&axis| self.model.features(axis).backlash);
        cells.extend(with_backlash.map(|axis| Cell {
            column: format!("{axis}_dir"),
            value: f64::from(row.reading.state.direction(axis)),
            decimals: 0,
        }));
        cells
    }

    fn check_travel(&self, position: &AxisVector, place: Place, findings: &mut Findings) {
        for axis in LINEAR {
            let Some([low, high]) = self.machine.axis(axis).and_then(|data| data.travel) else { continue };
            if !(low - ON_LIMIT..=high + ON_LIMIT).contains(&position[axis]) {
                let message = format!(
                    "to reach the ball {axis} would move to {:.3} mm, outside its travel of {low} … {high} mm",
                    position[axis]
                );
                let help = "check place_mm of the ball, or move the row away from the end of the travel";
                findings.add(Diagnostic::at(Code::OUT_OF_TRAVEL, place, message, help), &self.plan.sources);
            }
        }
    }

    /// Writes the table with the cells; columns that are not there are added behind the others.
    fn write(&self, rows: &[Vec<Cell>], out: &mut dyn std::io::Write) -> std::io::Result<()> {
        let sign = Readings::with(self.table, self.machine, &self.plan.data.fixed)
            .map_or(DecimalSign::Point, |readings| readings.sign());
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
            let mut own: Vec<(usize, &Cell)> =
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

    fn text(&self, cell: &Cell, row: &Row<'_>, column: usize, sign: DecimalSign) -> String {
        let text = number_text(cell.value, cell.decimals, row.text(column), sign);
        let needs_quotes = sign == DecimalSign::Comma && self.table.separator() == b',' && row.text(column).is_empty();
        if needs_quotes && text.contains(',') { format!("\"{text}\"") } else { text }
    }

    /// The description, with the uncertainty of the instrument where it says none.
    fn description(&self, noise: Option<f64>) -> Vec<u8> {
        let bytes = self.plan.sources[1].bytes();
        let (Some(noise), None) = (noise, self.plan.data.sigma) else { return bytes.to_vec() };
        let Some(mut edit) = std::str::from_utf8(bytes).ok().and_then(Edit::parse) else { return bytes.to_vec() };
        edit.set("measurement", "sigma_um", &Given::Number(um_from_mm(noise)));
        // Where lengths and angles were read, angles have as many µrad.
        let rows = &self.plan.data.observations;
        let is_mixed = rows.iter().any(Observation::is_angle) && !rows.iter().all(Observation::is_angle);
        if is_mixed && self.plan.data.sigma_rad.is_none() {
            edit.set("measurement", "sigma_urad", &Given::Number(um_from_mm(noise)));
        }
        edit.text().into_bytes()
    }
}

/// The column of a value: one each, or for single components the one of their unit.
fn column_of(columns: &[&str], row: &Observation, index: usize) -> String {
    let column = match row.component {
        Some(name) if name.direction.is_rotation() => columns.iter().find(|name| name.ends_with("_urad")),
        Some(_) => columns.iter().find(|name| name.ends_with("_um")),
        None => columns.get(index),
    };
    column.map_or_else(String::new, |&column| column.to_owned())
}
