//! Programs of the Sinumerik 840D and 828D.
//!
//! A line is put together word by word and written when the next one begins, so that what belongs behind the last piece of a move
//! (M words of the end, exact stop) and what belongs on its first line (number, comment) find their places. Lines that a block of the
//! source needs beside its first carry the comment `;+`, steps on the spot `;~`.

mod motion;
mod words;

use crate::geometry::{AXIS_COUNT, Axis};
use crate::path::{Output, OutputFrame};
use crate::snc::BlockNumber;
use crate::units::push_integer;

use super::number::push_value;
use super::{Decimals, Writer, WriterOptions};

/// What the output takes for granted: absolute coordinates. Written before the first motion where the program does not say it.
const ASSUMED: &str = "G90";
/// Exact stop at the end of every block, and its counterpart; the group has more members, which all stop nowhere.
const ALWAYS_STOP: &str = "G60";
const NEVER_STOP: &str = "G64";
/// Acts at the end of its block.
const EXACT_STOP: &str = "G9";

/// The writer of the dialect.
pub(in crate::emit) fn create(options: &WriterOptions) -> Option<Box<dyn Writer>> {
    Some(Box::new(Sinumerik {
        linear: Decimals::of_increment(options.increments.linear_mm)?,
        rotary: Decimals::of_increment(options.increments.rotary_deg)?,
        // The increment is above 0 where it has decimals.
        turn_counts: ((360.0 / options.increments.rotary_deg).round() as i64).max(1),
        names: options.names.clone(),
        in_machine_frame: options.frame == OutputFrame::Machine,
        line_end: if options.crlf { b"\r\n" } else { b"\n" },
        stamp: options.stamp.text(),
        is_stamped: false,
        has_assumed: false,
        line: Vec::with_capacity(256),
        held: Vec::with_capacity(64),
        comment: Vec::with_capacity(64),
        has_words: false,
        has_motion: false,
        is_again: false,
        is_open: false,
        suppressing: None,
        stops_exactly: false,
        always_stops: false,
        stop_word_at: None,
        is_running: false,
        motion_at: None,
        motion: "",
        feed: 0.0,
        blocks: 0,
    }))
}

struct Sinumerik {
    linear: Decimals,
    rotary: Decimals,
    names: [Option<String>; AXIS_COUNT],
    /// Increments of a full turn.
    turn_counts: i64,
    in_machine_frame: bool,
    line_end: &'static [u8],
    stamp: String,
    is_stamped: bool,
    has_assumed: bool,
    /// The line so far, without its comment.
    line: Vec<u8>,
    /// S, M, H and D words of the block, which follow the words of its motion.
    held: Vec<u8>,
    comment: Vec<u8>,
    has_words: bool,
    /// Whether the line moves already: another move of the same block needs its own.
    has_motion: bool,
    /// Whether the line is a further one of its block.
    is_again: bool,
    is_open: bool,
    /// The suppressing word of the block.
    suppressing: Option<&'static str>,
    /// Whether the block has an exact stop that is not written yet.
    stops_exactly: bool,
    /// Whether the program has said that every block stops exactly (G60).
    always_stops: bool,
    /// Where in the line it says so.
    stop_word_at: Option<usize>,
    /// Whether the lines of the block run through where the program stops at its end.
    is_running: bool,
    /// Where in the line its motion begins.
    motion_at: Option<usize>,
    /// The G word of motion in force, empty for none yet.
    motion: &'static str,
    feed: f64,
    blocks: u64,
}

impl Writer for Sinumerik {
    fn write(&mut self, output: &Output, out: &mut Vec<u8>) {
        match output {
            Output::Piece(piece) => {
                self.is_again = !piece.starts_block && (!piece.first || self.has_motion);
                if piece.starts_block || self.is_again {
                    self.begin(piece.starts_block, piece.number, out);
                }
                self.assume(out);
                self.piece(piece);
            }
            Output::Element(element) => {
                if element.starts_block {
                    self.begin(true, element.number, out);
                }
                self.element(element, out);
            }
        }
    }

    fn finish(&mut self, out: &mut Vec<u8>) {
        self.end_block(out);
        self.stamp(out);
    }

    fn blocks(&self) -> u64 {
        self.blocks
    }
}

impl Sinumerik {
    /// Ends the line before and begins another.
    fn begin(&mut self, is_block: bool, number: Option<BlockNumber>, out: &mut Vec<u8>) {
        if is_block {
            self.end_block(out);
        } else {
            self.run_through();
            self.end_line(out);
        }
        self.is_open = true;
        if is_block {
            self.suppressing = None;
            self.stops_exactly = false;
        }
        if let Some(number) = number {
            self.line.push(if number.main { b':' } else { b'N' });
            push_integer(&mut self.line, u64::from(number.number));
        }
    }

    /// Ends the last line of a block.
    fn end_block(&mut self, out: &mut Vec<u8>) {
        if self.is_open {
            if std::mem::take(&mut self.stops_exactly) {
                self.insert(EXACT_STOP);
            }
            if std::mem::take(&mut self.is_running) {
                self.insert(ALWAYS_STOP);
            }
        }
        self.end_line(out);
    }

    /// The program stops at the end of its block, not at the end of each line that the block becomes.
    fn run_through(&mut self) {
        if !self.always_stops || !self.has_motion || std::mem::replace(&mut self.is_running, true) {
            return;
        }
        match self.stop_word_at {
            // One word of a group in a block: the one that is there changes.
            Some(at) => self.line[at..at + NEVER_STOP.len()].copy_from_slice(NEVER_STOP.as_bytes()),
            None => self.insert(NEVER_STOP),
        }
    }

    /// Puts a word before those of the motion of the line.
    fn insert(&mut self, word: &str) {
        match self.motion_at {
            None => self.word(word.as_bytes()),
            Some(0) => {
                self.line.splice(0..0, word.bytes().chain([b' ']));
            }
            Some(at) => {
                self.line.splice(at..at, [b' '].into_iter().chain(word.bytes()));
            }
        }
    }

    fn end_line(&mut self, out: &mut Vec<u8>) {
        if !std::mem::take(&mut self.is_open) {
            return;
        }
        self.release();
        if !self.line.is_empty() || !self.comment.is_empty() {
            out.extend_from_slice(&self.line);
            if !self.line.is_empty() && !self.comment.is_empty() {
                out.push(b' ');
            }
            out.extend_from_slice(&self.comment);
            out.extend_from_slice(self.line_end);
            self.blocks += u64::from(self.has_words);
        }
        self.line.clear();
        self.stop_word_at = None;
        self.motion_at = None;
        self.comment.clear();
        self.has_words = false;
        self.has_motion = false;
    }

    /// Writes the stamp unless it is there.
    fn stamp(&mut self, out: &mut Vec<u8>) {
        if !std::mem::replace(&mut self.is_stamped, true) {
            out.extend_from_slice(b"; ");
            out.extend_from_slice(self.stamp.as_bytes());
            out.extend_from_slice(self.line_end);
        }
    }

    /// Before the first words: what the coordinates of this file mean, in a line of its own.
    fn assume(&mut self, out: &mut Vec<u8>) {
        if self.has_assumed {
            return;
        }
        self.stamp(out);
        self.has_assumed = true;
        out.extend_from_slice(ASSUMED.as_bytes());
        out.extend_from_slice(self.line_end);
        self.blocks += 1;
    }

    /// Appends a word with a blank before it.
    fn word(&mut self, bytes: &[u8]) {
        self.is_open = true;
        self.has_words = true;
        if !self.line.is_empty() {
            self.line.push(b' ');
        }
        self.line.extend_from_slice(bytes);
    }

    /// Appends the words that were held back for the motion.
    fn release(&mut self) {
        let held = self.held.trim_ascii_start();
        if !self.line.is_empty() && !held.is_empty() {
            self.line.push(b' ');
        }
        self.line.extend_from_slice(held);
        self.held.clear();
    }

    /// Appends the name of an axis, and whether a value behind it needs an equals sign.
    fn axis_name(&mut self, axis: Axis) -> bool {
        let name = self.names.get(axis.slot()).and_then(Option::as_ref);
        match name {
            Some(name) => self.line.extend_from_slice(name.as_bytes()),
            None => self.line.push(axis.letter()),
        }
        name.is_some()
    }

    fn feed_word(&mut self, feed: f64) {
        self.word(b"F");
        push_value(&mut self.line, without_noise(feed));
        self.feed = feed;
    }
}

/// A value to twelve significant digits: what conversions and cycles compute has noise in the last ones.
fn without_noise(value: f64) -> f64 {
    // Powers of ten up to the 22nd are exact doubles.
    let places = 11 - value.abs().log10().floor() as i32;
    if !(0..=22).contains(&places) {
        return value;
    }
    let power = 10_f64.powi(places);
    (value * power).round() / power
}
