//! Error sources: one file each, and their registry ([`Sources`]), which a caller can extend.
//!
//! A source reads its sections of the machine file into effects. An [`Effect`] contributes to the location and motion errors of the axes, depending on the
//! condition of the machine. It also exposes its parameters, so that they can be listed, varied and fitted.

mod coupling;
mod drift;
pub mod dynamic;
mod expansion;
mod geometry;
mod load;
mod reversal;
mod structure;

use std::any::Any;
use std::fmt::Debug;

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::AxisSet;
use ncfix_base::register::{Register, Registered};
use ncfix_machine::machine::file::{SECTIONS, Section};
use ncfix_machine::machine::{Condition, Machine};

use super::ErrorModel;
use super::accumulator::Accumulator;
use super::motion::MotionKinds;

/// Name and sections of a source: one static for each source, to which its effects refer.
#[derive(Debug)]
pub struct SourceInfo {
    /// Name in tables: `load`. It is unique in a registry.
    pub name: &'static str,
    /// Short description for people: `workpiece weight`.
    pub title: &'static str,
    /// Top-level sections of the machine file that belong to it: `load` for `[[load]]` or `[load]`. The parameters of its effects ([`WrittenAt`]) are in the
    /// first section.
    pub sections: &'static [&'static str],
    /// Example sections in the file of a machine with X, Y and Z, for help and tests.
    pub example: &'static str,
}

/// Error source: reads its sections of the machine file into effects.
///
/// To add one, pass it to `ncfix::Registry::with_source`, and read the machine file with `ncfix::Machine::from_file_with`. A section of a source that is not
/// in the registry is unknown.
pub trait ErrorSource: Send + Sync {
    /// Returns its description: always the same static, which its effects return, too.
    fn info(&self) -> &'static SourceInfo;

    /// Reads its sections from [`MachineFileReading::root`] and pushes an [`Effect`] for each into [`ErrorModel::effects`], mm and rad. It is called once for every
    /// machine file, with or without its sections, and does not fail. Faults are reported at their place ([`Section::report`], [`Section::finish`] for each
    /// section that was taken); an invalid entry is omitted.
    fn read(&self, reading: &mut MachineFileReading<'_, '_>, errors: &mut ErrorModel);
}

impl<S: ErrorSource + 'static> From<S> for Box<dyn ErrorSource> {
    fn from(source: S) -> Self {
        Box::new(source)
    }
}

/// Error sources that a machine file may have. [`Register::default`](ncfix_base::register::Register::default) contains the built-in ones, in the order in
/// which tables show them.
pub type Sources = Register<dyn ErrorSource>;

impl Registered for dyn ErrorSource {
    const KIND: &'static str = "error source";

    fn name(&self) -> &str {
        self.info().name
    }

    fn built_in() -> Vec<Box<Self>> {
        BUILT_IN.iter().map(|&source| Box::new(source) as Box<dyn ErrorSource>).collect()
    }

    fn conflict(&self, other: &Self) -> Option<String> {
        let sections = other.info().sections;
        let taken = |section: &&&str| self.info().sections.contains(section) || SECTIONS.contains(section);
        sections
            .iter()
            .find(taken)
            .map(|section| format!("the section {section} of the machine file belongs to another source"))
    }
}

/// Built-in error source.
#[derive(Clone, Copy)]
struct BuiltIn {
    info: &'static SourceInfo,
    read: fn(&mut MachineFileReading<'_, '_>, &mut ErrorModel),
}

impl ErrorSource for BuiltIn {
    fn info(&self) -> &'static SourceInfo {
        self.info
    }

    fn read(&self, reading: &mut MachineFileReading<'_, '_>, errors: &mut ErrorModel) {
        (self.read)(reading, errors);
    }
}

/// Built-in sources. Coupling and reversal are read with the motion errors of the geometry.
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

/// Returns the rank of a source among the built-in ones; others come after them.
pub(super) fn rank(info: &SourceInfo) -> usize {
    BUILT_IN.iter().position(|source| source.info.name == info.name).unwrap_or(BUILT_IN.len())
}

/// Effect of a source: one entry of the machine file. It must implement `Clone` and `PartialEq`.
pub trait Effect: BoxedEffect + Debug + Send + Sync {
    /// Returns the source to which it belongs.
    fn source(&self) -> &'static SourceInfo;

    /// Returns its name in tables, usually the error component that it affects: `EXX`. By default, the title of its source.
    fn label(&self) -> String {
        self.source().title.to_owned()
    }

    /// Adds its effect in a condition to the location and motion errors of the axes. Errors are in mm and rad, along and about the directions of F at the
    /// zero pose. They are deviations of the body that the axis moves, also on the workpiece side. The effect depends only on the condition (loads, temperatures, time).
    /// Dependence on the position of an axis or on its last motion is expressed by an [`EntryFunction`](crate::motion::EntryFunction). ncfix calls this
    /// function whenever the condition changes, not for every position. If the condition lacks the required data, the function adds nothing.
    fn contribute(&self, condition: &Condition, sum: &mut Accumulator<'_>);

    /// Visits every parameter, always in the same order, with a name that begins with its section (`overhang.sag`), and its value in mm, rad, s or K. These parameters are listed, varied, fitted
    /// (`ncfix calibrate` by the name) and written back to the machine file.
    fn visit_parameters(&mut self, visit: &mut dyn FnMut(&Parameter<'_>, &mut f64));

    /// Returns the sensors that it needs.
    fn sensors(&self) -> Vec<&str> {
        Vec::new()
    }

    /// True if it depends on the workpieces on the table.
    fn needs_load(&self) -> bool {
        false
    }

    /// True if it is a drift: setting the zero point of the workpiece takes up its value at that time.
    fn drifts(&self) -> bool {
        false
    }
}

/// Copies and compares an effect. It is implemented for every [`Effect`] that is `Clone` and `PartialEq`.
pub trait BoxedEffect: Any {
    /// Returns a boxed copy.
    fn boxed(&self) -> Box<dyn Effect>;

    /// True if the other effect has the same type and is equal.
    fn equals(&self, other: &dyn Effect) -> bool;
}

impl<E: Effect + Clone + PartialEq + 'static> BoxedEffect for E {
    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn equals(&self, other: &dyn Effect) -> bool {
        let other: &dyn Any = other;
        other.downcast_ref::<E>() == Some(self)
    }
}

impl Clone for Box<dyn Effect> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

impl PartialEq for dyn Effect {
    fn eq(&self, other: &Self) -> bool {
        // Two sources may have effects of one type. The name of a source is unique in a registry.
        self.source().name == other.source().name && self.equals(other)
    }
}

/// Parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter<'a> {
    /// Name: `EC0Y`, `EXX.coefficients[1]`.
    pub name: &'a str,
    /// True if the error is proportional to it (together with all other linear parameters of the effect).
    pub is_linear: bool,
    /// Place in the machine file; `None` for location and motion errors, which have their own names there.
    pub written: Option<WrittenAt<'a>>,
}

/// Place of a parameter in the machine file: in the first section of its source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrittenAt<'a> {
    /// Index of the entry in the list `[[section]]`; 0 for a single `[section]`.
    pub entry: usize,
    /// Key in the entry: `knots[0].coefficients[2]`, `sensors[1].um_per_K`.
    pub key: &'a str,
    /// Factor from its value to that of the file.
    pub factor: f64,
}

/// Machine file while sources read their sections.
#[derive(Debug)]
#[non_exhaustive]
pub struct MachineFileReading<'a, 'f> {
    /// All sections: a source takes its own with [`Section::section`] (`[name]`) or [`Section::sections`] (`[[name]]`).
    pub root: &'a mut Section<'f>,
    /// Axes that have a section, valid or not.
    pub axes: AxisSet,
    /// Machine, if it is valid.
    pub machine: Option<&'a Machine>,
    /// Kinds of functions that an entry may have.
    pub kinds: &'a MotionKinds,
    /// Diagnostics: [`Section::finish`] appends to them.
    pub findings: &'a mut Vec<Diagnostic>,
}
