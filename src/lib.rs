//! ncfix reads a part program and executes it. The result is a flat stream of simple moves. ncfix corrects these moves for the measured errors of one machine,
//! and writes a program for this machine only.
//!
//! ```
//! use ncfix::prelude::*;
//!
//! let machine = Machine::from_file("samples/machines/demo.toml")?;
//! let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
//! assert!(!program.check(&machine).has_errors());
//!
//! let mut text = Vec::new();
//! let report = program.correct(&machine, &Options::default()).write_to(&mut text)?;
//! println!("{}", report.table());
//! # Ok::<(), ncfix::Error>(())
//! ```
//!
//! [`prelude`] exports the types of the library. Lengths are mm, angles rad, times s, temperatures °C (differences K) and forces N unless a name states another unit.
//! Positions are axis commands in machine coordinates; deviations are along the axes of the foundation F. Everything that holds data is `Send` and `Sync`.
//!
//! Only these functions read or write files: those with *from_file* in their name, [`DataSet::read`], [`Tables::read`], [`Transfer::send`] and
//! [`Transfer::send_seen`] (the journal), and [`sensors::from_text`] (the sources that the text names). In addition, the execution of a program from a file reads
//! its subprograms. If it cannot read a subprogram, it logs the reason with [`log`].
//!
//! No stage holds the whole path, so the program text bounds the memory, even for a program with an endless loop. `ARCHITECTURE.md` of the
//! project is the map of its crates. `docs/explanation/theory.md` has the formulas with their sources.

pub mod extend;
pub mod prelude;
pub mod sensors;

mod answers;
mod assumed_start;
mod calibration;
mod channel;
mod check;
mod compare;
mod condition;
mod correction;
mod coverage;
mod data;
mod datum;
mod diagnosis;
mod diagnostics;
mod disk;
mod error;
mod feed;
mod first_tools;
mod head;
mod import;
mod interval;
mod machine;
mod machine_doubts;
mod measured;
mod moves;
mod new_machine;
mod next_line;
mod option_values;
mod options;
mod plan;
mod program;
mod realtime;
mod recognition;
mod registry;
mod run;
mod simulate;
mod square;
mod stated_zero;
mod steps;
mod support_file;
mod tables;
mod tool;
mod travel_trial;
mod watch;
mod zero_shift;

#[doc(hidden)]
pub mod cli;

pub use calibration::{Calibration, CalibrationOptions};
pub use correction::{Correction, Pieces};
pub use data::DataSet;
pub use diagnosis::{Diagnosis, DiagnosisOptions};
pub use diagnostics::{Diagnostics, Located};
pub use error::Error;
pub use feed::{ControlLink, FeedEnd, FeedOptions, FeedView, Sent, Transfer};
pub use machine::Machine;
pub use moves::Elements;
pub use options::{Compensation, DialectChoice, Options};
pub use program::Program;
pub use registry::Registry;
pub use simulate::{Recorded, SimulateOptions};
pub use tables::{TableCheck, TableOptions, Tables};
pub use tool::ToolVector;
