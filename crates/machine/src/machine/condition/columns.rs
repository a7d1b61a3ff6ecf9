//! Columns of tables that describe the state of the machine: temperatures and the workpiece on the table.
//!
//! | column | meaning |
//! | --- | --- |
//! | `t_s` | time |
//! | `T_head_C` | temperature of the sensor `T_head` of the machine file: the column name without `_C` |
//! | `load_N`, `load_x_mm`, `load_y_mm`, `load_z_mm` | weight on the table and its position, from this row on |

use ncfix_base::csv::{DecimalSign, Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Vector;

use super::Load;

/// Meaning of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum ConditionColumn {
    /// Time, s.
    Time,
    /// Temperature of a sensor, °C.
    Sensor(String),
    /// Weight, N.
    Force,
    /// Coordinate (0, 1, 2: x, y, z) of the load position, mm.
    LoadPlace(usize),
    /// Any other column.
    Other,
}

impl ConditionColumn {
    /// Returns the meaning of a column by its name.
    #[must_use]
    pub fn of(name: &str) -> ConditionColumn {
        match name {
            "t_s" => ConditionColumn::Time,
            "load_N" => ConditionColumn::Force,
            "load_x_mm" => ConditionColumn::LoadPlace(0),
            "load_y_mm" => ConditionColumn::LoadPlace(1),
            "load_z_mm" => ConditionColumn::LoadPlace(2),
            other => match other.strip_suffix("_C") {
                Some(sensor) if !sensor.is_empty() => ConditionColumn::Sensor(sensor.to_owned()),
                _ => ConditionColumn::Other,
            },
        }
    }

    /// Returns the meanings of all columns of a table.
    #[must_use]
    pub fn all(table: &Table) -> Vec<ConditionColumn> {
        table.names().iter().map(|name| ConditionColumn::of(name)).collect()
    }
}

/// Empty table: no force, at the center of the table.
pub const NO_LOAD: Load = Load { force_n: 0.0, position_mm: Vector::new(0.0, 0.0, 0.0) };

/// Reports a table that has the position of a load but not its weight.
pub fn check_load(table: &Table, columns: &[ConditionColumn], findings: &mut Vec<Diagnostic>) {
    if !columns.contains(&ConditionColumn::Force)
        && columns.iter().any(|column| matches!(column, ConditionColumn::LoadPlace(_)))
    {
        let help = "add a column load_N with the weight, or remove the position of the load";
        let message = "the table has the position of a load but no load_N";
        findings.push(Diagnostic::at(Code::DATA_COLUMN, table.header_place(None), message, help));
    }
}

/// Treatment of an implausible temperature, such as the value of a dead sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OfDead {
    /// The value is refused.
    Refused,
    /// The value is treated as an empty cell; the reader of the table reports the dead sensor.
    Empty,
}

/// Reads a cell of a temperature or of a load; a load column updates `load`. Temperatures are plausible within a range, °C. `None` if the column holds something else or the cell is empty.
///
/// # Errors
/// A diagnostic if the cell is not a number, or is not plausible for a machine.
pub fn read_cell(
    row: &Row<'_>,
    index: usize,
    column: &ConditionColumn,
    sign: DecimalSign,
    load: &mut Load,
    (of_dead, [low, high]): (OfDead, [f64; 2]),
) -> Result<Option<f64>, Diagnostic> {
    if matches!(column, ConditionColumn::Time | ConditionColumn::Other) || row.text(index).is_empty() {
        return Ok(None);
    }
    let value = row.number(index, sign)?;
    let fault = |message: String, help: &str| Err(Diagnostic::at(Code::DATA_CELL, row.place(index), message, help));
    match column {
        ConditionColumn::Sensor(_) if !(low..=high).contains(&value) && of_dead == OfDead::Empty => return Ok(None),
        ConditionColumn::Sensor(_) if !(low..=high).contains(&value) => {
            let help =
                format!("leave the cell empty where a sensor has no reading; temperatures are {low} to {high} °C");
            return fault(format!("{value} °C is not a plausible temperature"), &help);
        }
        ConditionColumn::Force if value < 0.0 => {
            return fault(format!("{value} N is not a valid weight"), "write the weight in N, 0 for an empty table");
        }
        ConditionColumn::Force => load.force_n = value,
        ConditionColumn::LoadPlace(axis) => load.position_mm[*axis] = value,
        _ => {}
    }
    Ok(Some(value))
}
