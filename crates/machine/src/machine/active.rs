//! Compensation tables that are active in the control.
//!
//! The machine file names their files (`machine.active_tables`). The code that opens files reads them and sets their effect here. The forward function of the
//! error model (`ncfix_model::Model::actual` there) applies it to every command, as the control does. So a program is corrected only for the residual of the
//! tables.
//!
//! `machine.offline_tables` names tables that no control uses: programs get their values instead (Esmaeili 2021, 4.6: a control without tables). To the
//! forward function, such tables are the errors that they would correct.

use std::fmt::Debug;
use std::sync::Arc;

use super::State;
use super::section::Section;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisVector, Vector};

/// Compensation that a control adds to a command by itself.
pub trait ActiveCompensation: Debug + Send + Sync {
    /// Returns the correction at a command, mm and rad. `tool_mm` runs from the gauge point to the tip, in F at the zero pose.
    fn correction(&self, command: &AxisVector, tool_mm: &Vector, state: &State) -> AxisVector;

    /// Returns the positions of an axis at which the correction has a kink, increasing, mm or rad.
    fn knots(&self, axis: Axis) -> Vec<f64>;

    /// True if the correction depends on the direction in which the axis moves.
    fn has_senses(&self, axis: Axis) -> bool;
}

/// Use of the product of two multiplied tables in the control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableProducts {
    /// The product replaces the table's own value.
    Instead,
    /// The product is added to the table's own value.
    Beside,
}

/// Active compensation tables.
#[derive(Clone, Debug, Default)]
pub struct ActiveTables {
    /// File names, as in the machine file.
    pub files: Vec<String>,
    /// Use of products of tables, if the machine file states it.
    pub multiplication: Option<TableProducts>,
    /// Effect of the tables; `None` until they are read.
    pub control: Option<Arc<dyn ActiveCompensation>>,
    /// True if no control uses the tables: their effect is then that of the errors that they correct.
    pub is_offline: bool,
}

impl ActiveTables {
    /// Sets the tables as a control would use them.
    pub fn set(&mut self, control: impl ActiveCompensation + 'static) {
        self.control = Some(if self.is_offline { Arc::new(CorrectedErrors(control)) } else { Arc::new(control) });
    }
}

/// The errors that tables correct: a command with the value of the tables at its set-point brings the axes to this set-point.
#[derive(Debug)]
struct CorrectedErrors<C>(C);

impl<C: ActiveCompensation> ActiveCompensation for CorrectedErrors<C> {
    fn correction(&self, command: &AxisVector, tool_mm: &Vector, state: &State) -> AxisVector {
        // The set-point s of the command s + t(s). Tables change by far less than 1 % of the distance, so the second step is exact to a nanometer.
        let mut set_point = *command;
        for _ in 0..3 {
            set_point = *command - self.0.correction(&set_point, tool_mm, state);
        }
        set_point - *command
    }

    fn knots(&self, axis: Axis) -> Vec<f64> {
        self.0.knots(axis)
    }

    fn has_senses(&self, axis: Axis) -> bool {
        self.0.has_senses(axis)
    }
}

/// Two are equal if they name the same files and multiply in the same way.
impl PartialEq for ActiveTables {
    fn eq(&self, other: &Self) -> bool {
        self.files == other.files && self.multiplication == other.multiplication && self.is_offline == other.is_offline
    }
}

/// Reads the active tables and the use of products.
pub(super) fn read(section: &mut Section<'_>) -> ActiveTables {
    let active = section.texts("active_tables").unwrap_or_default();
    let offline = section.texts("offline_tables").unwrap_or_default();
    if !active.is_empty() && !offline.is_empty() {
        let place = section.place_of("offline_tables");
        let help =
            "name the tables that the control uses in active_tables, or those that no control uses in offline_tables";
        section.report(Code::BAD_VALUE, place, "active_tables and offline_tables exclude each other", help);
    }
    let is_offline = !offline.is_empty();
    let files = if is_offline { offline } else { active };
    let multiplication = match section.text("table_multiplication") {
        None => None,
        Some("instead") => Some(TableProducts::Instead),
        Some("beside") => Some(TableProducts::Beside),
        Some(other) => {
            let place = section.place_of("table_multiplication");
            let help = "write \"instead\" where the control adds the product instead of the table's own value, else \"beside\"";
            section.report(Code::BAD_VALUE, place, format!("'{other}' is not 'instead' or 'beside'"), help);
            None
        }
    };
    ActiveTables { files, multiplication, control: None, is_offline }
}

/// Name in `axis_order` of an axis of the control that the machine file does not have, such as a spindle.
pub(crate) const OTHER_AXIS: &str = "-";

/// Reads the axes in the order of their numbers in the control.
pub(super) fn read_axis_order(section: &mut Section<'_>) -> Vec<Option<Axis>> {
    let letters = section.texts("axis_order").unwrap_or_default();
    let mut order = Vec::new();
    for (index, letter) in letters.iter().enumerate() {
        if *letter == OTHER_AXIS {
            order.push(None);
            continue;
        }
        let axis = if let [letter] = letter.as_bytes() { Axis::from_letter(*letter) } else { None };
        match axis.filter(|axis| !order.contains(&Some(*axis))) {
            Some(axis) => order.push(Some(axis)),
            None => {
                let place = section.place_of_item("axis_order", index);
                let help = "write each axis once, in the order of AX1, AX2 …, and \"-\" for a spindle or another axis that this file does not have: [\"X\", \"Y\", \"Z\", \"-\", \"A\", \"C\"]";
                section.report(Code::BAD_VALUE, place, format!("'{letter}' is not an axis, or is given twice"), help);
            }
        }
    }
    order
}
