//! Axis positions, tool vector and directions of motion in the columns of a table.
//!
//! Columns: the axis letters of the machine (mm, deg), all required; `tool_x_mm tool_y_mm tool_z_mm`, from the spindle gauge point to the tip, along
//! F's directions at the zero pose, default 0; `X_dir` …, the direction of the last motion, −1, 0 or 1. Without such a column or value, the direction
//! follows from the order of the rows within a `run`.

use std::collections::HashMap;

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_machine::machine::{Machine, State};

use ncfix_base::csv::{DecimalSign, Row, Table};

/// Tolerance within which a position counts as on its limit: rounding noise, mm or rad.
const ON_LIMIT: f64 = 1e-9;
const TOOL_COLUMNS: [&str; 3] = ["tool_x_mm", "tool_y_mm", "tool_z_mm"];

/// The columns with axis positions.
#[derive(Debug)]
pub struct Readings<'a> {
    machine: &'a Machine,
    sign: DecimalSign,
    axes: Vec<(Axis, usize)>,
    /// Positions of axes without a column.
    fixed: AxisVector,
    senses: Vec<(Axis, usize)>,
    tool: [Option<usize>; 3],
    run: Option<usize>,
    /// True if the order of the rows is that of the motion.
    is_in_order: bool,
    /// Position and directions of motion in the last row of each run.
    last: HashMap<Vec<u8>, (AxisVector, State)>,
}

/// One row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Positions, mm and rad.
    pub position: AxisVector,
    /// Vector from the spindle gauge point to the tip, mm.
    pub tool_mm: Vector,
    /// Directions of motion.
    pub state: State,
}

impl<'a> Readings<'a> {
    /// Finds the columns.
    ///
    /// # Errors
    /// Diagnostics for axes without a column, columns of missing axes, and contradictory decimal signs.
    pub fn new(table: &Table, machine: &'a Machine) -> Result<Readings<'a>, Vec<Diagnostic>> {
        Readings::with(table, machine, &[])
    }

    /// Finds the columns; axes in `fixed` need none, mm and rad.
    ///
    /// # Errors
    /// As for [`Readings::new`].
    pub fn with(table: &Table, machine: &'a Machine, fixed: &[(Axis, f64)]) -> Result<Readings<'a>, Vec<Diagnostic>> {
        let mut standing = AxisVector::ZERO;
        fixed.iter().for_each(|&(axis, at)| standing[axis] = at);
        let is_fixed = |axis: Axis| fixed.iter().any(|&(known, _)| known == axis);
        let mut findings = Vec::new();
        let (mut axes, mut senses) = (Vec::new(), Vec::new());
        for axis in AXES {
            let letter = axis.to_string();
            let [position, sense] = [table.column(&letter), table.column(&format!("{letter}_dir"))];
            if machine.axis(axis).is_some() {
                match position {
                    Some(column) => axes.push((axis, column)),
                    None if is_fixed(axis) => {}
                    None => findings.push(missing(table, axis)),
                }
                senses.extend(sense.map(|column| (axis, column)));
            } else {
                for column in [position, sense].into_iter().flatten() {
                    findings.push(Diagnostic::at(
                        Code::DATA_COLUMN,
                        table.header_place(Some(column)),
                        format!("the machine {} has no axis {axis}", machine.name),
                        "check --machine, or rename the column if it is something else",
                    ));
                }
            }
        }
        let tool = TOOL_COLUMNS.map(|name| table.column(name));
        let numbers: Vec<usize> = axes.iter().map(|&(_, column)| column).chain(tool.into_iter().flatten()).collect();
        let sign = table.decimal_sign(&numbers).unwrap_or_else(|finding| {
            findings.push(finding);
            DecimalSign::Point
        });
        if !findings.is_empty() {
            return Err(findings);
        }
        let run = table.column("run");
        Ok(Readings {
            machine,
            sign,
            axes,
            fixed: standing,
            senses,
            tool,
            run,
            is_in_order: true,
            last: HashMap::new(),
        })
    }

    /// Directions of rows that are not in the order of the motion: only columns state them.
    #[must_use]
    pub fn in_no_order(self) -> Readings<'a> {
        Readings { is_in_order: false, ..self }
    }

    /// The axes and their columns.
    #[must_use]
    pub fn axes(&self) -> &[(Axis, usize)] {
        &self.axes
    }

    /// The decimal sign of the table.
    #[must_use]
    pub fn sign(&self) -> DecimalSign {
        self.sign
    }

    /// `true` if the table contains directions of motion, `false` if they follow from the order of its rows.
    #[must_use]
    pub fn has_senses(&self) -> bool {
        !self.senses.is_empty()
    }

    /// Reads the next row; rows must come in order.
    ///
    /// # Errors
    /// Diagnostics for cells that are not numbers and positions outside the travel.
    pub fn read(&mut self, row: &Row) -> Result<Reading, Vec<Diagnostic>> {
        let mut findings = Vec::new();
        let mut position = self.fixed;
        for &(axis, column) in &self.axes {
            match row.number(column, self.sign) {
                Ok(number) => {
                    position[axis] = if axis.is_rotary() { number.to_radians() } else { number };
                    findings.extend(self.outside(axis, position[axis], number, row, column));
                }
                Err(finding) => findings.push(finding),
            }
        }
        let mut tool_mm = Vector::zeros();
        for (value, column) in tool_mm.iter_mut().zip(self.tool) {
            match column.map(|column| row.number(column, self.sign)) {
                Some(Ok(number)) => *value = number,
                Some(Err(finding)) => findings.push(finding),
                None => {}
            }
        }
        let state = self.state(row, &position, &mut findings);
        if findings.is_empty() { Ok(Reading { position, tool_mm, state }) } else { Err(findings) }
    }

    fn state(&mut self, row: &Row, position: &AxisVector, findings: &mut Vec<Diagnostic>) -> State {
        let run = self.run.map_or(&[][..], |column| row.text(column));
        let mut state = State::default();
        match self.last.get_mut(run) {
            _ if !self.is_in_order => {}
            Some((last, last_state)) => {
                last_state.note_motion(last, position);
                *last = *position;
                state = *last_state;
            }
            None => {
                self.last.insert(run.to_vec(), (*position, state));
            }
        }
        for &(axis, column) in self.senses.iter().filter(|(_, column)| !row.text(*column).is_empty()) {
            match row.number(column, self.sign) {
                Ok(number) if [-1.0, 0.0, 1.0].contains(&number) => {
                    state.direction[axis.slot()] = if number > 0.0 { 1 } else { -i8::from(number < 0.0) };
                }
                Ok(number) => {
                    let message = format!("the direction of approach of {axis} is {number}");
                    let help = "write -1, 0 (no motion yet) or 1";
                    findings.push(Diagnostic::at(Code::DATA_CELL, row.place(column), message, help));
                }
                Err(finding) => findings.push(finding),
            }
        }
        state
    }

    fn outside(&self, axis: Axis, position: f64, shown: f64, row: &Row, column: usize) -> Option<Diagnostic> {
        let [low, high] = self.machine.axis(axis)?.travel?;
        if (low - ON_LIMIT..=high + ON_LIMIT).contains(&position) {
            return None;
        }
        let (unit, shown_limit) =
            if axis.is_rotary() { ("deg", [low, high].map(f64::to_degrees)) } else { ("mm", [low, high]) };
        let message =
            format!("{axis} {shown} {unit} is outside the travel of {} … {} {unit}", shown_limit[0], shown_limit[1]);
        let help =
            format!("check the unit of the column, --machine, and axis.{axis}.travel_{unit} in the machine file");
        Some(Diagnostic::at(Code::OUT_OF_TRAVEL, row.place(column), message, help))
    }
}

/// The diagnostic for an axis without a column, with a similar column name if there is one.
fn missing(table: &Table, axis: Axis) -> Diagnostic {
    let letter = axis.to_string();
    let unit = if axis.is_rotary() { "deg" } else { "mm" };
    let alike = table.names().iter().position(|name| {
        let upper = name.to_ascii_uppercase();
        upper.strip_prefix(&letter).is_some_and(|rest| {
            rest.is_empty() || rest.trim_start_matches(['_', ' ', '[', '(']).starts_with(&unit.to_ascii_uppercase())
        })
    });
    let (message, help) = match alike.and_then(|column| table.names().get(column)) {
        Some(name) => (
            format!("there is a column {name}, but no column {letter}"),
            format!("rename the column {name} to {letter} if it is in {unit}"),
        ),
        None => (
            format!("there is no column {letter}"),
            format!(
                "every axis of the machine needs a column with its positions in {unit}; for an axis that did not move, the description of a measurement can state it once, under [position]"
            ),
        ),
    };
    Diagnostic::at(Code::DATA_COLUMN, table.header_place(alike), message, help)
}
