//! Compensation tables of a control: their effect, their derivation from the error model, and the file formats of each control.
//!
//! ```text
//! Model ──scheme──▶ Tables ──format: round, check limits, write──▶ text of the control
//!                     │ ▲                                             │
//!                     │ └──────────────── format: read ───────────────┘
//!                     └──▶ Control::correction, as the control interpolates ──▶ check: the error that is left
//! ```
//!
//! [`Tables`] is the content of a control's tables in any file format: functions of one axis that are added or multiplied in pairs ([`Lookup`]), a
//! grid of corrections ([`Grid`]), or error functions for the control's own kinematics ([`ErrorTables`]). A [`Scheme`] fills them, a [`Format`]
//! writes and reads them. [`Control`] evaluates them as the control does. A format is a file in `format/` and a line in [`FORMATS`], a scheme a file
//! in `scheme/` and a line in [`SCHEMES`]; a caller adds its own to [`Formats`] and [`Schemes`].
//!
//! Positions and values are stored in mm and degrees, the units of the controls: a table that was read is written again with identical digits.

pub mod check;
mod control;
mod errors;
pub mod format;
mod grid;
pub mod kinds;
mod lookup;
pub mod region;
pub mod scheme;
mod target;
mod wiring;

pub use control::Control;
pub use errors::{AxisErrors, ErrorTables};
pub use format::{FORMATS, Format, Formats, Written};
pub use grid::Grid;
pub use lookup::{Lookup, Nodes, Sense};
pub use scheme::{SCHEMES, Scheme, Schemes};
pub use target::{Orientation, Target};
pub use wiring::Wiring;

use ncfix_base::geometry::{AXES, Axis};
use ncfix_machine::machine::TableProducts;

/// The tables of a control. Kinds that a format does not have stay empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tables {
    /// Functions of one axis, in the order of their numbers; products name each other by their index.
    pub lookups: Vec<Lookup>,
    /// Effect of a table with a factor.
    pub multiplication: Multiplication,
    /// Corrections of three axes on a grid of their positions.
    pub grid: Option<Grid>,
    /// Error functions for the control's own kinematic model.
    pub errors: Option<ErrorTables>,
    /// Commands times a matrix (LinuxCNC matrixkins): rows are the motors of X, Y, Z.
    pub matrix: Option<[[f64; 3]; 3]>,
}

/// Effect of a table that is multiplied by another one. The manuals are ambiguous (SINUMERIK 840D sl, Extended Functions K3: "the product is added";
/// Esmaeili 2021, 2.4.5.3: the table is multiplied instead of added).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Multiplication {
    /// The product replaces the table's own value. A table without a factor adds its own value, also if it is itself the factor of another table.
    #[default]
    Instead,
    /// The product is added to the table's own value.
    Beside,
}

impl From<TableProducts> for Multiplication {
    fn from(products: TableProducts) -> Multiplication {
        match products {
            TableProducts::Instead => Multiplication::Instead,
            TableProducts::Beside => Multiplication::Beside,
        }
    }
}

impl Tables {
    /// Number of tables that a control must hold: functions of one axis, or one for each grid, matrix and axis with error functions.
    #[must_use]
    pub fn count(&self) -> usize {
        let axes = self.errors.as_ref().map_or(0, |errors| errors.axes.len());
        self.lookups.len() + usize::from(self.grid.is_some()) + axes + usize::from(self.matrix.is_some())
    }

    /// Adds other tables: a control with both adds both. `false` if both have a kind that a control has only once.
    #[must_use]
    pub fn add(&mut self, others: Tables) -> bool {
        let first = self.lookups.len();
        self.lookups.extend(others.lookups.into_iter().map(|mut lookup| {
            lookup.factor = lookup.factor.map(|factor| factor + first);
            lookup
        }));
        let is_once = (self.grid.is_none() || others.grid.is_none())
            && (self.matrix.is_none() || others.matrix.is_none())
            && (self.errors.is_none() || others.errors.is_none());
        self.grid = self.grid.take().or(others.grid);
        self.matrix = self.matrix.or(others.matrix);
        self.errors = self.errors.take().or(others.errors);
        is_once
    }

    /// `true` if a table depends on an axis or corrects it.
    #[must_use]
    pub fn names(&self, axis: Axis) -> bool {
        self.lookups.iter().any(|one| one.input == axis || one.output == axis)
            || self.grid.as_ref().is_some_and(|grid| grid.axes.contains(&axis))
            || self.errors.iter().flat_map(|errors| &errors.axes).any(|one| one.axis == axis)
            || self.errors.iter().flat_map(|errors| &errors.location).any(|(name, _)| name.axis() == Some(axis))
    }

    /// The axes that the tables name.
    #[must_use]
    pub fn axes(&self) -> Vec<Axis> {
        AXES.into_iter().filter(|axis| self.names(*axis)).collect()
    }

    /// Number of values.
    #[must_use]
    pub fn entries(&self) -> usize {
        let lookups: usize = self.lookups.iter().map(|lookup| lookup.values.len()).sum();
        let grid = self.grid.as_ref().map_or(0, |grid| grid.values.len() * 3);
        let axes = self.errors.as_ref().map_or(0, |errors| errors.axes.iter().map(|axis| axis.values.len() * 6).sum());
        lookups + grid + axes + self.matrix.map_or(0, |_| 9)
    }

    /// `true` if no value has an effect.
    #[must_use]
    pub fn are_zeros(&self) -> bool {
        let is_identity = |matrix: &[[f64; 3]; 3]| {
            let apart = |(row, values): (usize, &[f64; 3])| {
                values.iter().enumerate().any(|(column, &value)| value != f64::from(u8::from(row == column)))
            };
            !matrix.iter().enumerate().any(apart)
        };
        let errors = || self.errors.iter().flat_map(|errors| &errors.axes).flat_map(|one| one.values.iter().flatten());
        self.lookups.iter().flat_map(|one| &one.values).all(|&value| value == 0.0)
            && self.grid.iter().flat_map(|grid| grid.values.iter().flatten()).all(|&value| value == 0.0)
            && errors().all(|&value| value == 0.0)
            && self.errors.iter().flat_map(|errors| &errors.location).all(|&(_, value)| value == 0.0)
            && self.matrix.as_ref().is_none_or(is_identity)
    }

    /// `true` if nothing would be corrected.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count() == 0
    }
}
