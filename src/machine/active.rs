//! What the control corrects by itself: compensation tables that are switched on.
//!
//! The machine file names their files (`machine.active_tables`); who opens files reads them and puts here what they do. The forward function of the
//! error model ([`crate::model::Model::actual`] there) applies it to every command, as the control does, so that a program is only corrected for
//! what the tables leave.

use std::fmt::Debug;
use std::sync::Arc;

use super::State;
use crate::geometry::{Axis, AxisVector, Vector};

/// What a control adds to a command by itself.
pub trait Compensation: Debug + Send + Sync {
    /// What is added at a command, mm and rad. `tool_mm` runs from the gauge point to the tip, in F at the zero pose.
    fn correction(&self, command: &AxisVector, tool_mm: &Vector, state: &State) -> AxisVector;

    /// Positions of an axis at which it has a kink, increasing, mm or rad.
    fn knots(&self, axis: Axis) -> Vec<f64>;

    /// Whether it depends on the sense in which the axis moves.
    fn has_senses(&self, axis: Axis) -> bool;
}

/// The tables that are switched on.
#[derive(Clone, Debug, Default)]
pub struct ActiveTables {
    /// Their files, as the machine file names them.
    pub files: Vec<String>,
    /// What they do; `None` until they are read.
    pub control: Option<Arc<dyn Compensation>>,
}

/// Two are the same where they name the same files.
impl PartialEq for ActiveTables {
    fn eq(&self, other: &Self) -> bool {
        self.files == other.files
    }
}
