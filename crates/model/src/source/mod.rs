//! Sources of error: one file each, and the register of them ([`Sources`]), which a caller extends.
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
use ncfix_base::register::{Register, Registered};
use ncfix_machine::machine::file::{SECTIONS, Section};
use ncfix_machine::machine::{Condition, Machine};

use super::ErrorModel;
use super::accumulator::Accumulator;
use super::motion::MotionKinds;

/// What a source is called and where it stands in the machine file: one static for each source, to which its effects point.
#[derive(Debug)]
pub struct SourceInfo {
    /// Its name in tables: `load`. No other source of a register has it.
    pub name: &'static str,
    /// A few words for people: `workpiece weight`.
    pub title: &'static str,
    /// The top-level sections of the machine file that are its own: `load` for `[[load]]` or `[load]`. The parameters that its effects show
    /// ([`Written`]) stand in the first.
    pub sections: &'static [&'static str],
    /// Sections as they may stand in the file of a machine with X, Y and Z, for help and tests.
    pub example: &'static str,
}

/// A source of error: reads its sections of the machine file into effects.
///
/// A caller adds one with [`Sources::with`](ncfix_base::register::Register::with) and reads the machine file with [`file::load_with`](crate::file::load_with).
/// A section of a source that is not in the register is an unknown one.
pub trait ErrorSource: Send + Sync {
    /// What it is called: the same static at every call, and that of its effects.
    fn info(&self) -> &'static SourceInfo;

    /// Reads its sections from [`Reading::root`] and pushes an [`Effect`] for each into [`ErrorModel::effects`], mm and rad. It is called
    /// once for every machine file, whether or not its sections are there, and does not fail: what is wrong is reported at its place
    /// ([`Section::report`], [`Section::finish`] for each section that was taken), and an entry that is not sound is left out.
    fn read(&self, reading: &mut Reading<'_, '_>, errors: &mut ErrorModel);
}

impl<S: ErrorSource + 'static> From<S> for Box<dyn ErrorSource> {
    fn from(source: S) -> Self {
        Box::new(source)
    }
}

/// The sources of error that a machine file may have: [`Register::default`](ncfix_base::register::Register::default) are those that are built in, in the order
/// in which tables show them.
pub type Sources = Register<dyn ErrorSource>;

impl Registered for dyn ErrorSource {
    const KIND: &'static str = "source of error";

    fn name(&self) -> &str {
        self.info().name
    }

    fn built_in() -> Vec<Box<Self>> {
        BUILT_IN.iter().map(|&source| Box::new(source) as Box<dyn ErrorSource>).collect()
    }

    fn conflict(&self, other: &Self) -> Option<String> {
        let sections = other.info().sections;
        let taken = |section: &&&str| self.info().sections.contains(section) || SECTIONS.contains(section);
        sections.iter().find(taken).map(|section| format!("the section {section} of the machine file is another's"))
    }
}

/// A source of error that is built in.
#[derive(Clone, Copy)]
struct BuiltIn {
    info: &'static SourceInfo,
    read: fn(&mut Reading<'_, '_>, &mut ErrorModel),
}

impl ErrorSource for BuiltIn {
    fn info(&self) -> &'static SourceInfo {
        self.info
    }

    fn read(&self, reading: &mut Reading<'_, '_>, errors: &mut ErrorModel) {
        (self.read)(reading, errors);
    }
}

/// Those that are built in. Coupling and reversal are read with the motion errors of the geometry.
const BUILT_IN: &[BuiltIn] = &[
    BuiltIn { info: &geometry::SOURCE, read: geometry::read },
    BuiltIn { info: &coupling::SOURCE, read: |_, _| {} },
    BuiltIn { info: &reversal::SOURCE, read: |_, _| {} },
    BuiltIn { info: &dynamic::SOURCE, read: dynamic::read },
    BuiltIn { info: &load::SOURCE, read: load::read },
    BuiltIn { info: &structure::SOURCE, read: structure::read },
    BuiltIn { info: &drift::SOURCE, read: drift::read },
    BuiltIn { info: &expansion::SOURCE, read: expansion::read },
];

/// The place of a source among those that are built in; behind them for another.
pub(super) fn rank(info: &SourceInfo) -> usize {
    BUILT_IN.iter().position(|source| source.info.name == info.name).unwrap_or(BUILT_IN.len())
}

/// One effect of a source: what one entry of the machine file says. It is `Clone`, and shows all of itself by `Debug`: effects are equal where that is.
pub trait Effect: BoxedEffect + Debug + Send + Sync {
    /// The source that it belongs to.
    fn source(&self) -> &'static SourceInfo;

    /// The component of the error that it makes, for tables: `EXX`.
    fn label(&self) -> String {
        self.source().title.to_owned()
    }

    /// Adds what it does in a condition to the location and motion errors of the axes: mm and rad along and about the directions of F
    /// at the zero pose, as deviation of the body that the axis moves, also on the workpiece side. It depends on the condition (loads,
    /// temperatures, time) alone; what depends on the position of an axis or on its last motion goes in as a
    /// [`Function`](crate::motion::Function). It is called whenever the condition changes, not for every position. Where the condition does not say what
    /// it needs, it adds nothing.
    fn contribute(&self, condition: &Condition, sum: &mut Accumulator<'_>);

    /// Shows every parameter with its name and unit, always in the same order: `name.of.it`, in mm, rad, s or K. What is
    /// shown is listed, varied, fitted (`ncfix calibrate` by the name) and written back to the machine file.
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
}

/// Copies an effect: what is an [`Effect`] and `Clone` does it by itself.
pub trait BoxedEffect {
    /// A copy.
    fn boxed(&self) -> Box<dyn Effect>;
}

impl<E: Effect + Clone + 'static> BoxedEffect for E {
    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Effect> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

impl PartialEq for dyn Effect {
    fn eq(&self, other: &Self) -> bool {
        // A name is that of one source of a register, and every value shows itself in full.
        self.source().name == other.source().name && format!("{self:?}") == format!("{other:?}")
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

/// Where a parameter stands in the machine file: in the first section of its source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Written<'a> {
    /// Number of the entry in the list `[[section]]`; 0 for a single `[section]`.
    pub entry: usize,
    /// The key in it: `knots[0].coefficients[2]`, `sensors[1].um_per_K`.
    pub key: &'a str,
    /// What its value is multiplied with to give that of the file.
    pub factor: f64,
}

/// A machine file while sources read their sections.
#[derive(Debug)]
#[non_exhaustive]
pub struct Reading<'a, 'f> {
    /// All sections: a source takes its own with [`Section::section`] (`[name]`) or [`Section::sections`] (`[[name]]`).
    pub root: &'a mut Section<'f>,
    /// Axes that have a section, whether or not it is sound.
    pub axes: AxisSet,
    /// The machine, where it is sound.
    pub machine: Option<&'a Machine>,
    /// The kinds of functions that an entry may have.
    pub kinds: &'a MotionKinds,
    /// What was found: the place to which [`Section::finish`] hands over.
    pub findings: &'a mut Vec<Diagnostic>,
}
