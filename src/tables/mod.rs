//! Compensation tables of a control: what they do, how they are made from the error model, and how each control writes and reads them.
//!
//! ```text
//! Model ──scheme──▶ Tables ──format: round, check limits, write──▶ text of the control
//!                     │ ▲                                             │
//!                     │ └──────────────── format: read ───────────────┘
//!                     └──▶ Control::correction, as the control interpolates ──▶ check: the error that is left
//! ```
//!
//! [`Tables`] is what a control is told, whatever its file looks like: functions of one axis that are added or multiplied in pairs
//! ([`Lookup`]), a grid of corrections ([`Grid`]), or error functions that the control puts through its own kinematics
//! ([`ErrorTables`]). A [`Scheme`] fills them, a [`Format`] writes and reads them. [`Control`] does what the control does with them. A format is a
//! file in `format/` and a line in [`FORMATS`], a scheme a file in `scheme/` and a line in [`SCHEMES`].
//!
//! Positions and values are kept in mm and degrees, the units of the controls: a table that was read is written again digit by digit.

pub mod check;
mod control;
mod errors;
pub mod format;
mod grid;
mod lookup;
pub mod region;
pub mod scheme;
mod target;
mod wiring;

pub use control::Control;
pub use errors::{AxisErrors, ErrorTables};
pub use format::{FORMATS, Format, Written};
pub use grid::Grid;
pub use lookup::{Lookup, Nodes, Sense};
pub use scheme::{SCHEMES, Scheme};
pub use target::{Orientation, Target};
pub use wiring::Wiring;

/// What a control is told. Kinds that a format does not have stay empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tables {
    /// Functions of one axis, in the order of their numbers; products name each other by their index.
    pub lookups: Vec<Lookup>,
    /// What a table with a factor adds.
    pub multiplication: Multiplication,
    /// Corrections of three axes on a grid of their positions.
    pub grid: Option<Grid>,
    /// Error functions for the control's own kinematic model.
    pub errors: Option<ErrorTables>,
    /// Commands times a matrix (LinuxCNC matrixkins): rows are the motors of X, Y, Z.
    pub matrix: Option<[[f64; 3]; 3]>,
}

/// What a table adds that is multiplied by another one. The manuals can be read in two ways (SINUMERIK 840D sl, Extended Functions K3:
/// "the product is added"; Esmaeili 2021, 2.4.5.3: the table is multiplied instead of added).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Multiplication {
    /// The product in place of its own value. A table without a factor of its own that others name is added too.
    #[default]
    Instead,
    /// The product beside its own value.
    Beside,
}

impl Tables {
    /// How many tables a control must hold: functions of one axis, or one for each grid, matrix and axis with error functions.
    #[must_use]
    pub fn count(&self) -> usize {
        let axes = self.errors.as_ref().map_or(0, |errors| errors.axes.len());
        self.lookups.len() + usize::from(self.grid.is_some()) + axes + usize::from(self.matrix.is_some())
    }

    /// How many values they hold.
    #[must_use]
    pub fn entries(&self) -> usize {
        let lookups: usize = self.lookups.iter().map(|lookup| lookup.values.len()).sum();
        let grid = self.grid.as_ref().map_or(0, |grid| grid.values.len() * 3);
        let axes = self.errors.as_ref().map_or(0, |errors| errors.axes.iter().map(|axis| axis.values.len() * 6).sum());
        lookups + grid + axes + self.matrix.map_or(0, |_| 9)
    }

    /// Whether nothing would be corrected.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count() == 0
    }
}
