//! Writes corrected pieces in the language of a control: numbers, blocks, the stamp, and one writer for each dialect.
//!
//! A writer turns each [`Output`] into bytes of a reusable buffer; [`emit`] sends them to a file or link. To add a dialect, write its file and
//! register it in [`WRITERS`].

mod block_number;
mod check_cut;
mod comment;
mod flat;
mod growth;
mod guard;
mod kept;
mod line;
mod number;
mod passes;
mod sections;
mod sinumerik;
mod stamp;
mod stops;
mod subprograms;
mod traces;
mod words;

pub use block_number::NumberSet;
pub use check_cut::check_cut;
pub use flat::{PartFrame, flat, flat_part};
pub use growth::{growth, lines_with_words};
pub use guard::{GuardLines, GuardWords, GuardedData, GuardedTool, GuardedZero};
pub use number::Decimals;
pub use sections::without_sections;
pub use stamp::{
    Stamp, is_stamp_changed, is_stamped, is_stamped_for, stamped_model, stamped_promise, stamped_source, stamped_state,
};

pub use subprograms::{FoldedProgram, SubprogramNames, SubprogramStyle, fold};
pub use traces::{CorrectionTrace, correction_trace, guard_end};

use std::io::{self, Write};

use crate::path::{Centers, Feeds, Increments, Output, OutputFrame, Turns};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::AXIS_COUNT;
use ncfix_base::source::Source;

/// Settings of a writer.
#[derive(Clone, Debug, PartialEq)]
pub struct WriterOptions {
    /// Increments of the piece counts.
    pub increments: Increments,
    /// Frame of the piece coordinates.
    pub frame: OutputFrame,
    /// `true` if lines of the source end with CR LF, `false` for LF.
    pub crlf: bool,
    /// Names of axes that are not single letters, by slot.
    pub names: [Option<String>; AXIS_COUNT],
    /// The stamp, which becomes the first comment.
    pub stamp: Stamp,
    /// The largest block number, if the language needs numbers and the control limits them.
    pub last_block_number: Option<u32>,
    /// `true` if the control reads the words of an arc center as the way from it to the start of the arc (Fanuc, Grundig).
    pub has_centers_reversed: bool,
}

/// Turns corrected output into lines of a control's language.
pub trait Writer: Send {
    /// Appends the lines that `output` completes.
    ///
    /// # Errors
    /// `E0201` if the language has no words for it; then nothing is written.
    fn write(&mut self, output: &Output, out: &mut Vec<u8>) -> Result<(), Diagnostic>;
    /// Ends the program: appends what is still held back.
    fn finish(&mut self, out: &mut Vec<u8>);
    /// Reserves the block numbers of the source, if every line needs a number.
    fn keep_free(&mut self, _numbers: NumberSet) {}
    /// Writes lines before the first words of the program.
    fn begin_with(&mut self, _lines: Vec<String>) {}
    /// Keeps the bytes of lines of the main program in which no word changes.
    fn keep_lines(&mut self, _program: Source) {}
    /// Comments on further passes of loops, for people who read the file.
    fn mark_passes(&mut self) {}
    /// Marks sections that can become subprograms, for [`fold`].
    fn mark_sections(&mut self) {}
    /// The number of lines with words written so far, without comments and headers.
    fn blocks(&self) -> u64;
}

/// A dialect that can be written.
#[derive(Clone, Copy, Debug)]
pub struct WriterEntry {
    /// Name of the dialect.
    pub dialect: &'static str,
    /// Creates its writer; `None` if it cannot write these increments.
    pub create: fn(&WriterOptions) -> Option<Box<dyn Writer>>,
    /// The largest turn of one block around a circle.
    pub turns: Turns,
    /// Coordinates of arc centers.
    pub centers: Centers,
    /// The path to which the feed refers.
    pub feeds: Feeds,
    /// `true` if every motion can be written in machine coordinates.
    pub has_machine_frame: bool,
    /// `true` if the language has five-axis transformations that the output keeps.
    pub has_transformation: bool,
    /// `true` if the language has circles through an intermediate point in any plane.
    pub has_spatial_arcs: bool,
    /// Words before the first move of every program, for millimeters: they define the coordinates.
    pub assumed: &'static str,
    /// Words that compare data of the control; `None` if the language has none.
    pub guard: Option<GuardWords>,
}

/// All dialects that can be written.
pub const WRITERS: &[WriterEntry] = &[sinumerik::ENTRY, words::GRUNDIG, words::FANUC, words::RS274];

/// Returns the writer entry of a dialect; `None` if the dialect cannot be written.
#[must_use]
pub fn entry(dialect: &str) -> Option<&'static WriterEntry> {
    WRITERS.iter().find(|entry| entry.dialect.eq_ignore_ascii_case(dialect))
}

/// Creates the writer of a dialect. `None` if the dialect or its coordinates cannot be written, or if an increment is not a decimal of at most nine
/// places.
#[must_use]
pub fn writer(dialect: &str, options: &WriterOptions) -> Option<Box<dyn Writer>> {
    (entry(dialect)?.create)(options)
}

/// `true` if the words begin or end radius compensation at the control; they act on the motion after them.
fn is_compensation(text: &[u8]) -> bool {
    let first = text.split(|&byte| byte == b' ').next().unwrap_or_default();
    [b"G40", b"G41", b"G42"].iter().any(|word| *word == first)
}

/// Buffer size, bytes, at which the buffer is handed on.
const CHUNK: usize = 64 * 1024;

/// Writes a whole stream; diagnostics go to `report`. After an error nothing more is written, but the stream is read to its end to collect all
/// diagnostics. Returns the number of blocks written.
///
/// # Errors
/// Errors of `sink`.
pub fn emit(
    outputs: impl Iterator<Item = Result<Output, Diagnostic>>,
    writer: &mut dyn Writer,
    sink: &mut dyn Write,
    mut report: impl FnMut(Diagnostic),
) -> io::Result<u64> {
    let mut buffer = Vec::with_capacity(CHUNK + 4096);
    let mut is_good = true;
    for output in outputs {
        match output {
            Ok(output) if is_good => {
                if let Err(finding) = writer.write(&output, &mut buffer) {
                    is_good = false;
                    report(finding);
                } else if buffer.len() >= CHUNK {
                    sink.write_all(&buffer)?;
                    buffer.clear();
                }
            }
            Ok(_) => {}
            Err(finding) => {
                is_good &= !finding.is_error();
                report(finding);
            }
        }
    }
    if is_good {
        writer.finish(&mut buffer);
        sink.write_all(&buffer)?;
    }
    sink.flush()?;
    Ok(writer.blocks())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_executable_dialect_has_a_writer() {
        for dialect in ncfix_dialect::DIALECTS.iter().filter(|dialect| dialect.is_executable) {
            assert!(WRITERS.iter().any(|entry| entry.dialect == dialect.name), "{} has no writer", dialect.name);
        }
    }
}
