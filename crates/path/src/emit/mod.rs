//! Writes corrected pieces in the language of a control: numbers, blocks, the stamp, one writer per dialect.
//!
//! A writer turns one [`Output`] after the other into bytes of a reusable buffer; [`emit`] drives it into a file or link. To add a
//! dialect, write its file and register it in [`WRITERS`].

mod block_number;
mod comment;
mod flat;
mod line;
mod number;
mod sinumerik;
mod stamp;
mod stops;
mod words;

pub use block_number::NumberSet;
pub use flat::flat;
pub use number::Decimals;
pub use stamp::{
    Stamp, is_stamp_changed, is_stamped, is_stamped_for, stamped_model, stamped_promise, stamped_source, stamped_state,
};

use std::io::{self, Write};

use crate::path::{Centers, Feeds, Increments, Output, OutputFrame, Turns};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::AXIS_COUNT;

/// What a writer must know beside the stream.
#[derive(Clone, Debug, PartialEq)]
pub struct WriterOptions {
    /// What the counts of the pieces are multiples of.
    pub increments: Increments,
    /// What the coordinates of the pieces relate to.
    pub frame: OutputFrame,
    /// Line end of the source: CR LF rather than LF.
    pub crlf: bool,
    /// Names of axes that are not written by their letters, by slot.
    pub names: [Option<String>; AXIS_COUNT],
    /// The first comment.
    pub stamp: Stamp,
    /// The largest number of a block, where the language wants numbers and the control has a limit.
    pub last_block_number: Option<u32>,
}

/// Turns corrected output into lines of a control's language.
pub trait Writer: Send {
    /// Appends the lines that `output` completes.
    ///
    /// # Errors
    /// `E0201` where the language has no words for it; nothing may be written then.
    fn write(&mut self, output: &Output, out: &mut Vec<u8>) -> Result<(), Diagnostic>;
    /// Appends what is still held back; the end of the program.
    fn finish(&mut self, out: &mut Vec<u8>);
    /// Keeps numbers free for the blocks of the source that have them, where every line needs a number.
    fn keep_free(&mut self, _numbers: NumberSet) {}
    /// Lines with words written so far, comments and headers not counted.
    fn blocks(&self) -> u64;
}

/// A dialect that can be written.
#[derive(Clone, Copy, Debug)]
pub struct WriterEntry {
    /// Name of the dialect.
    pub dialect: &'static str,
    /// Makes its writer; `None` where it cannot write such increments.
    pub create: fn(&WriterOptions) -> Option<Box<dyn Writer>>,
    /// How far one of its blocks may lead around a circle.
    pub turns: Turns,
    /// Where its controls have the center of an arc.
    pub centers: Centers,
    /// For which way its controls take a feed.
    pub feeds: Feeds,
    /// Whether every motion can be written in machine coordinates.
    pub has_machine_frame: bool,
    /// Words that stand in every program before its first move, in millimeters: what the coordinates mean.
    pub assumed: &'static str,
}

/// All dialects that can be written.
pub const WRITERS: &[WriterEntry] = &[sinumerik::ENTRY, words::GRUNDIG, words::FANUC, words::RS274];

/// What is known about writing a dialect; `None` where it cannot be written.
#[must_use]
pub fn entry(dialect: &str) -> Option<&'static WriterEntry> {
    WRITERS.iter().find(|entry| entry.dialect.eq_ignore_ascii_case(dialect))
}

/// The writer of a dialect; `None` where it or its coordinates cannot be written, or an increment is no decimal of at most nine places.
#[must_use]
pub fn writer(dialect: &str, options: &WriterOptions) -> Option<Box<dyn Writer>> {
    (entry(dialect)?.create)(options)
}

/// Whether words begin or end radius compensation at the control. They act on the motion behind them.
fn is_compensation(text: &[u8]) -> bool {
    let first = text.split(|&byte| byte == b' ').next().unwrap_or_default();
    [b"G40", b"G41", b"G42"].iter().any(|word| *word == first)
}

/// Bytes after which the buffer is handed on.
const CHUNK: usize = 64 * 1024;

/// Writes a whole stream; findings go to `report`. After an error nothing more is written, but the stream is followed to its end,
/// so that all findings come up. Returns the number of blocks written.
///
/// # Errors
/// Those of `sink`.
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
