//! What the control corrects by itself: compensation tables that are switched on.
//!
//! The machine file names their files (`machine.active_tables`); who opens files reads them and puts here what they do. The forward function of the
//! error model (`ncfix_model::Model::actual` there) applies it to every command, as the control does, so that a program is only corrected for
//! what the tables leave.

use std::fmt::Debug;
use std::sync::Arc;

use super::State;
use super::section::Section;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisVector, Vector};

/// What a control adds to a command by itself.
pub trait ActiveCompensation: Debug + Send + Sync {
    /// What is added at a command, mm and rad. `tool_mm` runs from the gauge point to the tip, in F at the zero pose.
    fn correction(&self, command: &AxisVector, tool_mm: &Vector, state: &State) -> AxisVector;

    /// Positions of an axis at which it has a kink, increasing, mm or rad.
    fn knots(&self, axis: Axis) -> Vec<f64>;

    /// Whether it depends on the sense in which the axis moves.
    fn has_senses(&self, axis: Axis) -> bool;
}

/// What a table adds in the control that is multiplied by another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableProducts {
    /// The product in place of its own value.
    Instead,
    /// The product beside its own value.
    Beside,
}

/// The tables that are switched on.
#[derive(Clone, Debug, Default)]
pub struct ActiveTables {
    /// Their files, as the machine file names them.
    pub files: Vec<String>,
    /// What the control does with products of tables, where the machine file says it.
    pub multiplication: Option<TableProducts>,
    /// What they do; `None` until they are read.
    pub control: Option<Arc<dyn ActiveCompensation>>,
}

/// Two are the same where they name the same files and multiply alike.
impl PartialEq for ActiveTables {
    fn eq(&self, other: &Self) -> bool {
        self.files == other.files && self.multiplication == other.multiplication
    }
}

/// What is switched on, and what the control does with products.
pub(super) fn read(section: &mut Section<'_>) -> ActiveTables {
    let files = section.texts("active_tables").unwrap_or_default();
    let multiplication = match section.text("table_multiplication") {
        None => None,
        Some("instead") => Some(TableProducts::Instead),
        Some("beside") => Some(TableProducts::Beside),
        Some(other) => {
            let place = section.place_of("table_multiplication");
            let help =
                "write \"instead\" where the control adds the product in place of the own value, else \"beside\"";
            section.report(Code::BAD_VALUE, place, format!("'{other}' says nothing of products"), help);
            None
        }
    };
    ActiveTables { files, multiplication, control: None }
}

/// The axes in the order of their numbers in the control.
pub(super) fn read_axis_order(section: &mut Section<'_>) -> Vec<Axis> {
    let letters = section.texts("axis_order").unwrap_or_default();
    let mut order = Vec::new();
    for (index, letter) in letters.iter().enumerate() {
        let axis = if let [letter] = letter.as_bytes() { Axis::from_letter(*letter) } else { None };
        match axis.filter(|axis| !order.contains(axis)) {
            Some(axis) => order.push(axis),
            None => {
                let place = section.place_of_item("axis_order", index);
                let help = "write each axis once, in the order of AX1, AX2 …: [\"X\", \"Y\", \"Z\", \"A\", \"C\"]";
                section.report(Code::BAD_VALUE, place, format!("'{letter}' is no axis, or there twice"), help);
            }
        }
    }
    order
}
