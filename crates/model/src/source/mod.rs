//! Sources of error: one file each, registered in [`SOURCES`].
//!
//! A source reads its sections of the machine file into effects. An [`Effect`] contributes to the location and motion errors of the axes what
//! the condition of the machine makes of it, and shows its parameters, so that they can be listed, varied and fitted.

mod coupling;
mod drift;
pub mod dynamic;
mod expansion;
mod geometry;
mod load;
mod reversal;
mod structure;

use std::fmt::Debug;

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::AxisSet;
use ncfix_machine::machine::file::Section;
use ncfix_machine::machine::{Condition, Machine};

use super::ErrorModel;
use super::accumulator::Accumulator;

/// A source of error.
#[derive(Debug)]
pub struct Source {
    /// Its name in tables: `load`.
    pub name: &'static str,
    /// What it is: `workpiece weight`.
    pub title: &'static str,
    /// The sections of the machine file that are its own.
    pub sections: &'static [&'static str],
    /// Reads them.
    pub read: fn(&mut Reading<'_, '_>, &mut ErrorModel),
    /// Sections as they may stand in the file of a machine with X, Y and Z, for help and tests.
    pub example: &'static str,
}

/// All sources, in the order in which tables show them.
pub const SOURCES: &[&Source] = &[
    &geometry::SOURCE,
    &coupling::SOURCE,
    &reversal::SOURCE,
    &dynamic::SOURCE,
    &load::SOURCE,
    &structure::SOURCE,
    &drift::SOURCE,
    &expansion::SOURCE,
];

/// One effect of a source.
pub trait Effect: Debug + Send + Sync {
    /// The source that it belongs to.
    fn source(&self) -> &'static Source;

    /// The component of the error that it makes, for tables: `EXX`.
    fn label(&self) -> String {
        self.source().title.to_owned()
    }

    /// Adds what it does in a condition.
    fn contribute(&self, condition: &Condition, sum: &mut Accumulator<'_>);

    /// Shows every parameter with its name and unit.
    fn visit_parameters(&mut self, visit: &mut dyn FnMut(&Parameter<'_>, &mut f64));

    /// The sensors that it needs.
    fn sensors(&self) -> Vec<&str> {
        Vec::new()
    }

    /// Whether it depends on the workpieces on the table.
    fn needs_load(&self) -> bool {
        false
    }

    /// Whether it is an offset in time that ends when the zero point of the workpiece is set.
    fn drifts(&self) -> bool {
        false
    }

    /// A copy.
    fn boxed(&self) -> Box<dyn Effect>;
}

impl Clone for Box<dyn Effect> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

impl PartialEq for dyn Effect {
    fn eq(&self, other: &Self) -> bool {
        // Every value shows itself in full.
        std::ptr::eq(self.source(), other.source()) && format!("{self:?}") == format!("{other:?}")
    }
}

/// A parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter<'a> {
    /// Its name: `EC0Y`, `EXX.coefficients[1]`.
    pub name: &'a str,
    /// Whether the error is proportional to it (with all others of the effect that are).
    pub is_linear: bool,
    /// Where it stands in the machine file; `None` for location and motion errors, which have names of their own there.
    pub written: Option<Written<'a>>,
}

/// Where a parameter stands in the machine file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Written<'a> {
    /// Number of the entry in the list of sections of the source.
    pub entry: usize,
    /// The key in it: `knots[0].coefficients[2]`, `sensors[1].um_per_K`.
    pub key: &'a str,
    /// What its value is multiplied with to give that of the file.
    pub factor: f64,
}

/// A machine file while sources read their sections.
#[derive(Debug)]
pub struct Reading<'a, 'f> {
    /// All sections.
    pub root: &'a mut Section<'f>,
    /// Axes that have a section, whether or not it is sound.
    pub axes: AxisSet,
    /// The machine, where it is sound.
    pub machine: Option<&'a Machine>,
    /// What was found.
    pub findings: &'a mut Vec<Diagnostic>,
}
