//! `ncfix correct-readings`: takes the corrections out of positions that were read on the machine.

use super::arguments::{MeasuredArguments, RotaryChoice};
use super::exit_code::ExitCode;
use super::findings::Findings;
use super::machine_choice::{self, Chosen};
use super::output::{Old, Spool, Target};
use super::program::protect;
use super::progress::Progress;
use super::state;
use super::stop::Stop;
use super::{input, tell};
use ncfix_base::csv::{DecimalSign, Row, Table, number_text};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::AxisVector;
use ncfix_base::source::{FileId, Source};
use ncfix_base::units::um_from_mm;
use ncfix_machine::machine::{Condition, Kinematics};
use ncfix_metrology::measure::mode;
use ncfix_metrology::measure::reading::{Reading, Readings};
use ncfix_model::{Model, NotConverged, Solve};
use ncfix_report::measured::Measured;
use ncfix_report::number::micrometers;

/// Decimals of mm: a hundredth of what a correction promises.
const DECIMALS_MM: usize = 8;
/// Decimals of degrees: 1e-7 mm at an arm of 500 mm.
const DECIMALS_DEG: usize = 10;

/// Corrects a table of readings.
pub(super) fn run(arguments: &MeasuredArguments) -> Result<ExitCode, Stop> {
    let mut findings = Findings::default();
    let result = correct(arguments, &mut findings);
    findings.draw();
    match result? {
        Some(report) => tell(&report.table()),
        None => tell(&format!("{}; nothing was written\n", findings.count())),
    }
    Ok(findings.exit_code())
}

/// Reads the table and writes its copy; `None` where findings forbid it.
fn correct(arguments: &MeasuredArguments, findings: &mut Findings) -> Result<Option<Measured>, Stop> {
    let target = Target::new(&arguments.output)?;
    let source = input::read(&arguments.data, FileId(0), "positions")?;
    let Some(mut chosen) = machine_choice::choose(&arguments.machine, &arguments.data, findings)? else {
        return Ok(None);
    };
    if !state::apply(&arguments.state, &mut chosen, findings)? {
        return Ok(None);
    }
    protect(&target, chosen.files.iter().chain([&arguments.data]), findings);
    let (table, found) = Table::read(&source);
    findings.extend(found, std::slice::from_ref(&source));
    let Some(table) = table.filter(|_| !findings.has_errors()) else { return Ok(None) };
    let readings = match Readings::new(&table, &chosen.machine) {
        Ok(readings) => readings,
        Err(found) => {
            findings.extend(found, std::slice::from_ref(&source));
            return Ok(None);
        }
    };
    let mut spool = Spool::new(target)?;
    let job = Job { arguments, source: &source, chosen: &chosen, table: &table };
    let report = job.write(readings, &mut spool, findings)?;
    if findings.has_errors() {
        return Ok(None);
    }
    spool.publish(Old::Replaced)?;
    Ok(Some(report))
}

/// One table on its way.
struct Job<'a> {
    arguments: &'a MeasuredArguments,
    source: &'a Source,
    chosen: &'a Chosen,
    table: &'a Table,
}

impl Job<'_> {
    /// Writes the copy. Behind the first error it is of no use, but all findings are gathered.
    fn write(&self, mut readings: Readings, spool: &mut Spool, findings: &mut Findings) -> Result<Measured, Stop> {
        let mut model = self.chosen.model();
        let mut clock = Clock::new(self.table, self.chosen);
        let solve = match self.arguments.rotary {
            RotaryChoice::Auto | RotaryChoice::Correct => Solve::Full,
            RotaryChoice::Hold => Solve::PositionOnly,
        };
        let mut report = Measured {
            axes: readings.axes().iter().map(|&(axis, _)| axis).collect(),
            machine: self.chosen.machine.name.clone(),
            output: self.arguments.output.display().to_string(),
            ..Measured::default()
        };
        let kinematics = Kinematics::new(&self.chosen.machine);
        let mut progress = Progress::new();
        let mut fault = None;
        let mut copy = self.table.copy(spool.writer());
        let count = self.table.row_count().max(1) as f64;
        for (index, row) in self.table.rows().enumerate() {
            progress.share("rows", index as f64 / count);
            match clock.model_at(&row, readings.sign()) {
                Ok(Some(then)) => model = then,
                Ok(None) => {}
                Err(finding) => {
                    findings.extend(vec![finding], std::slice::from_ref(self.source));
                    continue;
                }
            }
            let found = match readings.read(&row) {
                Ok(reading) => match mode::nominal(&model, &reading, solve) {
                    Ok(nominal) => {
                        if let Some(finding) = self.too_large(&kinematics, &reading, &nominal, &row, &readings) {
                            findings.extend(vec![finding], std::slice::from_ref(self.source));
                            continue;
                        }
                        report.note(&(reading.position - nominal));
                        report.without_sense += u64::from(lacks_sense(&model, &reading, &readings));
                        fault = fault.or(put(&mut copy, &row, &readings, &reading, &nominal).err());
                        continue;
                    }
                    Err(failure) => vec![not_converged(failure, &row, &readings)],
                },
                Err(found) => found,
            };
            findings.extend(found, std::slice::from_ref(self.source));
            if findings.is_hopeless() {
                break;
            }
        }
        let fault = fault.or(copy.finish().err());
        fault.map_or(Ok(report), |error| Err(spool.fault(&error).into()))
    }
}

impl Job<'_> {
    /// The finding for a position whose correction is larger than was asked for, as of a program.
    fn too_large(
        &self,
        kinematics: &Kinematics,
        reading: &Reading,
        nominal: &AxisVector,
        row: &Row,
        readings: &Readings,
    ) -> Option<Diagnostic> {
        let most_mm = self.arguments.max_correction;
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

/// The condition of the machine when each row was read, where the rows have times and the state is a log.
struct Clock<'a> {
    chosen: &'a Chosen,
    condition: Condition,
    column: Option<usize>,
}

impl<'a> Clock<'a> {
    fn new(table: &Table, chosen: &'a Chosen) -> Clock<'a> {
        let is_log = chosen.condition.time_range_s().is_some_and(|[first, last]| first < last);
        let column = table.column("t_s").filter(|_| is_log);
        Clock { chosen, condition: chosen.condition.clone(), column }
    }

    /// The model of another instant than that of the row before; `None` where it is the same.
    fn model_at(&mut self, row: &Row, sign: DecimalSign) -> Result<Option<Model>, Diagnostic> {
        let Some(column) = self.column else { return Ok(None) };
        let time_s = row.number(column, sign)?;
        let [first, last] = self.condition.time_range_s().unwrap_or_default();
        if !(first..=last).contains(&time_s) {
            let message = format!("{time_s} s lies outside the log of the state, which runs from {first} to {last} s");
            let help = "give a log that covers the readings, or rename the column if it is another time";
            return Err(Diagnostic::at(Code::DATA_CELL, row.place(column), message, help));
        }
        if time_s == self.condition.time_s() {
            return Ok(None);
        }
        self.condition.set_time(time_s);
        Ok(Some(Model::at(&self.chosen.machine, &self.chosen.errors, &self.condition)))
    }
}

/// Writes the positions of a row. A position without a correction stays as it was written.
fn put<W: std::io::Write>(
    copy: &mut ncfix_base::csv::Copy<W>,
    row: &Row,
    readings: &Readings,
    reading: &Reading,
    nominal: &ncfix_base::geometry::AxisVector,
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

/// Whether an axis whose error depends on the sense of its motion has none.
fn lacks_sense(model: &Model, reading: &Reading, readings: &Readings) -> bool {
    readings.axes().iter().any(|&(axis, _)| model.features(axis).backlash && reading.state.direction(axis) == 0)
}

/// The finding for a row without a solution.
fn not_converged(failure: NotConverged, row: &Row, readings: &Readings) -> Diagnostic {
    let column = readings.axes().first().map_or(0, |&(_, column)| column);
    let mut message = "no position is corrected to this reading".to_owned();
    if failure.residual_mm.is_finite() {
        message.push_str(&format!("; {} are left", micrometers(um_from_mm(failure.residual_mm))));
    }
    let help = "check the error model; next to a pole of the rotary axes try --rotary hold";
    Diagnostic::at(Code::NOT_CONVERGED, row.place(column), message, help)
}
