//! Options for the correction and the output of a program: those of `path` and `emit` from the arguments, the machine and the source.

use crate::datum;
use crate::error::Error;
use crate::machine::Machine;
use crate::options::Options;
use ncfix_base::geometry::AxisVector;
use ncfix_base::source::Source;
use ncfix_base::units::um_from_mm;
use ncfix_path::emit;
use ncfix_path::path::{self, Increments};
use ncfix_report::number::micrometers;

/// Options for the correction and the output of one program.
pub(crate) struct Writing {
    /// Options of the correction.
    pub(crate) options: path::CorrectionOptions,
    pub(super) dialect: &'static str,
    entry: &'static emit::WriterEntry,
    pub(super) writer: emit::WriterOptions,
    program: Source,
}

impl Writing {
    /// Options for a program in a dialect, from its text and its hash, with the position before its first block.
    ///
    /// # Errors
    /// If it cannot be written like that.
    pub(crate) fn new(
        choice: &Options,
        start: Option<AxisVector>,
        dialect: &'static str,
        chosen: &Machine,
        (program, hash): (&Source, String),
    ) -> Result<Writing, Error> {
        let entry = emit::entry(dialect).ok_or_else(|| unwritable(dialect))?;
        let options = path::CorrectionOptions {
            turns: match chosen.machine.control.firmware {
                Some(firmware) if !firmware.has_turns() => path::Turns::One,
                _ => entry.turns,
            },
            centers: entry.centers,
            feeds: entry.feeds,
            has_transformation: entry.has_transformation,
            has_spatial_arcs: entry.has_spatial_arcs,
            start,
            ..choice.of_path()
        };
        if options.frame == path::OutputFrame::Machine && !entry.has_machine_frame {
            return Err(Error::usage(format!(
                "in the dialect '{dialect}' not every motion can be written in machine coordinates; do not use --frame machine or --five-axis axes"
            )));
        }
        // The path may leave the exact one by the tolerance, so one beyond every plausible correction permits any path.
        let largest_mm = path::CorrectionOptions::default().max_correction_mm.max(choice.max_correction_mm);
        if choice.tolerance_mm > largest_mm {
            return Err(Error::usage(format!(
                "--tolerance {} is larger than {}, the largest correction that is permitted (--max-correction): cuts could be omitted; check the unit",
                micrometers(um_from_mm(choice.tolerance_mm)),
                micrometers(um_from_mm(largest_mm))
            )));
        }
        let machine = &chosen.machine;
        if choice.increment_mm.is_some() && machine.control.is_finer_than_read(dialect)[0] {
            let read_mm = machine.control.word_grid(dialect).map_or(0.0, |[linear_mm, _]| linear_mm);
            return Err(Error::usage(format!(
                "--increment is finer than {read_mm} mm, to which the control rounds the words that it reads"
            )));
        }
        let writer = emit::WriterOptions {
            names: machine.written_names(),
            increments: Increments::new(&machine.control),
            frame: options.frame,
            crlf: has_crlf(program.bytes()),
            last_block_number: machine.control.last_block_number,
            has_centers_reversed: machine.control.has_arc_words_from_center,
            stamp: emit::Stamp {
                machine: machine.name.clone(),
                model: chosen.hash.clone(),
                state: chosen.state.clone(),
                zeros: datum::stamped(chosen),
                source: hash,
                promise: path::Promise {
                    increment_mm: choice.increment_mm,
                    limits_feed: choice.feed_limit_mm.is_some(),
                    ..path::Promise::of(&options)
                },
                is_demo: chosen.is_demo,
            },
        };
        Ok(Writing { options, dialect, entry, writer, program: program.clone() })
    }

    /// Notes in the stamp that the control has the wear of tools.
    pub(crate) fn keep_wear(&mut self) {
        self.writer.stamp.promise.keeps_wear = true;
    }

    /// A writer at the beginning of the program.
    ///
    /// # Errors
    /// If the increments of the machine cannot be written.
    pub(crate) fn writer(&self) -> Result<Box<dyn emit::Writer>, Error> {
        let mut writer = (self.entry.create)(&self.writer).ok_or_else(|| unwritable(self.dialect))?;
        writer.keep_lines(self.program.clone());
        Ok(writer)
    }
}

fn unwritable(dialect: &str) -> Error {
    Error::usage(format!("programs in the dialect '{dialect}' cannot be written"))
}

/// True if the lines of a program end with CR LF.
fn has_crlf(bytes: &[u8]) -> bool {
    bytes.iter().position(|&byte| byte == b'\n').is_some_and(|at| bytes[..at].ends_with(b"\r"))
}
