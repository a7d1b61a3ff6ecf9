//! Items for an extension in another crate: one module for each kind of item that a [`Registry`](crate::Registry) takes.
//!
//! `docs/how-to/extending.md` of the project describes the requirements; the programs `examples/own_*.rs` are complete extensions.

/// Error sources with their sections of the machine file, and kinds of motion errors.
pub mod source {
    pub use ncfix_base::diagnostic::Code;
    pub use ncfix_base::geometry::{Axis, AxisVector, Vector};
    pub use ncfix_machine::machine::file::Section;
    pub use ncfix_machine::machine::{Condition, Load, State};
    pub use ncfix_model::motion::backlash::Backlash;
    pub use ncfix_model::motion::cross::Cross;
    pub use ncfix_model::motion::grid::ErrorGrid;
    pub use ncfix_model::motion::periodic::Periodic;
    pub use ncfix_model::motion::piecewise::{Knot, Piecewise};
    pub use ncfix_model::motion::polynomial::Polynomial;
    pub use ncfix_model::motion::table::ErrorTable;
    pub use ncfix_model::motion::{Entry, EntryFunction, MotionFunction, MotionKind, Sampling};
    pub use ncfix_model::name::{Direction, ErrorName};
    pub use ncfix_model::source::{MachineFileReading, Parameter, WrittenAt};
    pub use ncfix_model::{Accumulator, Effect, ErrorModel, ErrorSource, SourceInfo};
}

/// Formats of the files of instruments, which become measurements.
pub mod import {
    pub use ncfix_base::diagnostic::{Code, Diagnostic};
    pub use ncfix_base::geometry::Axis;
    pub use ncfix_instruments::answers::{ImportAnswers, MeasuredComponent, MeasuringPoint, ReadingMaterial};
    pub use ncfix_instruments::format::InstrumentFormat;
    pub use ncfix_instruments::grid::{GridCell, GridHeading, GridLine, GridTable, Separator, table};
    pub use ncfix_instruments::inquiry::{ImportQuestion, ImportStop, Inquiry};
    pub use ncfix_instruments::readings::{ImportedKind, ImportedReadings, ImportedRow};
    pub use ncfix_instruments::text::DecodedText;
    pub use ncfix_instruments::unit::ReadingUnit;
}

/// Causes that a diagnosis searches for.
pub mod cause {
    pub use ncfix_base::geometry::Axis;
    pub use ncfix_machine::machine::edit::Given;
    pub use ncfix_metrology::diagnose::cause::{
        Candidate, Cause, CauseId, Correctable, EffectKind, Propose, Term, Values, Weight, axes, column, linear, own,
        range, times,
    };
    pub use ncfix_metrology::diagnose::extend::Change;
    pub use ncfix_metrology::diagnose::row::SceneRow;
    pub use ncfix_metrology::diagnose::scene::{Scene, Through};
    pub use ncfix_model::name::Direction;
    pub use ncfix_model::{ErrorName, ParameterName};
}

/// Presets: sets of parameters of an error model.
pub mod preset {
    pub use ncfix_machine::machine::Machine;
    pub use ncfix_model::ParameterName;
    pub use ncfix_model::preset::{Preset, Unsuitable};
}

/// Instruments and data checks.
pub mod instrument {
    pub use ncfix_base::csv::{DecimalSign, Row, Table};
    pub use ncfix_base::diagnostic::Diagnostic;
    pub use ncfix_metrology::diagnose::fault::{
        DataDefect, DefectCheck, DefectKind, MissingTemperatures, ShiftedLog, Then, View,
    };
    pub use ncfix_metrology::measure::data::{DataSet, Free, Observation};
    pub use ncfix_metrology::measure::kind::{
        Equation, Instrument, Measurand, Seen, Unknown, at, needed, no_ties, optional, three, vector_at, zeros,
    };
}

/// Formats of compensation tables, and schemes that fill them.
pub mod table {
    pub use ncfix_base::diagnostic::Diagnostic;
    pub use ncfix_base::source::Source;
    pub use ncfix_tables::tables::format::{FormatLimits, Holds, without_numbers};
    pub use ncfix_tables::tables::scheme::Task;
    pub use ncfix_tables::tables::{
        Format, Lookup, Multiplication, Nodes, Orientation, Scheme, Sense, Tables, Wiring, Written,
    };
}

/// Protocols of links.
pub mod link {
    pub use ncfix_dnc::feed::{Dialogue, Event, Halt, Line, LineRewriter, LossKind, Profile, Protocol, Wire};
}

/// Sources of live readings.
pub mod sensor {
    pub use ncfix_dnc::sense::source::{Clocked, OpenedSource, Polled, SourcePlan, Wanted, items, polled};
    pub use ncfix_dnc::sense::{ChannelFault, ReadingOutlet, SensorSource, SourceReport};
    pub use ncfix_machine::machine::file::Section;
}

/// Detection of dialects.
pub mod dialect {
    pub use ncfix_dialect::{Detector, Dialect, find};
}
