//! How a program is corrected and written: the options of `path` and `emit` from the arguments, the machine and the source.

use super::arguments::{ArcChoice, CorrectionChoice, FiveAxisChoice, FrameChoice, RapidChoice, RotaryChoice};
use super::machine_choice::Chosen;
use super::stop::Stop;
use ncfix_base::geometry::AxisVector;
use ncfix_path::emit;
use ncfix_path::path::{self, Increments};

/// Distance of the samples of the predicted error along the path, mm.
const SAMPLE_MM: f64 = 1.0;

/// How one program is corrected and written.
pub(super) struct Writing {
    /// How it is corrected.
    pub(super) options: path::Options,
    dialect: &'static str,
    entry: &'static emit::WriterEntry,
    writer: emit::WriterOptions,
}

impl Writing {
    /// For a program in a dialect, its bytes and their hash, with the position before its first block; `limits_feed` where feeds are lowered.
    ///
    /// # Errors
    /// Where it cannot be written like that.
    pub(super) fn new(
        choice: &CorrectionChoice,
        start: Option<AxisVector>,
        dialect: &'static str,
        chosen: &Chosen,
        (source, hash): (&[u8], String),
        limits_feed: bool,
    ) -> Result<Writing, Stop> {
        let entry = emit::entry(dialect).ok_or_else(|| unwritable(dialect))?;
        let options =
            path::Options { turns: entry.turns, centers: entry.centers, feeds: entry.feeds, start, ..options(choice) };
        if options.frame == path::OutputFrame::Machine && !entry.has_machine_frame {
            return Err(Stop::Usage(format!(
                "in the dialect '{dialect}' not every motion can be written in machine coordinates; leave out --frame machine \
                 and --five-axis axes"
            )));
        }
        let machine = &chosen.machine;
        if choice.increment.is_some() && machine.control.is_finer_than_read(dialect)[0] {
            let read_mm = machine.control.word_grid(dialect).map_or(0.0, |[linear_mm, _]| linear_mm);
            return Err(Stop::Usage(format!(
                "--increment is finer than the {read_mm} mm on which the control puts the words that it reads: it would round what is written"
            )));
        }
        let writer = emit::WriterOptions {
            names: machine.written_names(),
            increments: Increments::new(&machine.control),
            frame: options.frame,
            crlf: has_crlf(source),
            last_block_number: machine.control.last_block_number,
            stamp: emit::Stamp {
                machine: machine.name.clone(),
                model: chosen.hash.clone(),
                state: chosen.state.clone(),
                source: hash,
                promise: path::Promise { increment_mm: choice.increment, limits_feed, ..path::Promise::of(&options) },
                is_demo: chosen.is_demo,
            },
        };
        Ok(Writing { options, dialect, entry, writer })
    }

    /// The stamp says that the control has the wear of tools.
    pub(super) fn keep_wear(&mut self) {
        self.writer.stamp.promise.keeps_wear = true;
    }

    /// A writer at the beginning of the program.
    ///
    /// # Errors
    /// Where the increments of the machine cannot be written.
    pub(super) fn writer(&self) -> Result<Box<dyn emit::Writer>, Stop> {
        (self.entry.create)(&self.writer).ok_or_else(|| unwritable(self.dialect))
    }
}

fn unwritable(dialect: &str) -> Stop {
    Stop::Usage(format!("programs in the dialect '{dialect}' cannot be written"))
}

/// Whether the lines of a program end with CR LF.
fn has_crlf(bytes: &[u8]) -> bool {
    bytes.iter().position(|&byte| byte == b'\n').is_some_and(|at| bytes[..at].ends_with(b"\r"))
}

fn options(choice: &CorrectionChoice) -> path::Options {
    path::Options {
        tolerance_mm: choice.tolerance,
        subdivision: choice.step.map_or(path::Subdivision::Adaptive, path::Subdivision::Step),
        arcs: match choice.arcs {
            ArcChoice::Keep => path::Arcs::Keep,
            ArcChoice::Chords => path::Arcs::Chords,
        },
        rapids: match choice.rapids {
            RapidChoice::Ends => path::Rapids::Ends,
            RapidChoice::None => path::Rapids::None,
            RapidChoice::All => path::Rapids::All,
        },
        frame: match (choice.frame, choice.five_axis) {
            (FrameChoice::Work, FiveAxisChoice::Tcp) => path::OutputFrame::Work,
            _ => path::OutputFrame::Machine,
        },
        five_axis: match choice.five_axis {
            FiveAxisChoice::Tcp => path::FiveAxis::Tcp,
            FiveAxisChoice::Axes => path::FiveAxis::Axes,
        },
        max_correction_mm: choice.max_correction,
        rotary: match choice.rotary {
            RotaryChoice::Auto => path::Rotary::Auto,
            RotaryChoice::Correct => path::Rotary::Correct,
            RotaryChoice::Hold => path::Rotary::Hold,
        },
        sample_mm: SAMPLE_MM,
        ..path::Options::default()
    }
}
