//! Programs of the Sinumerik 840D and 828D.
//!
//! A line is put together word by word and written when the next one begins, so that what belongs behind the last piece of a move
//! (M words of the end, exact stop) and what belongs on its first line (number, comment) find their places. Lines that a block of the
//! source needs beside its first carry the comment `;+`, steps on the spot `;~`.

use crate::geometry::{Axis, AxisVector};
use crate::path::{CONTINUES, CONTINUES_ON_THE_SPOT, Output, OutputFrame, Piece};
use crate::snc::{BlockNumber, Dwell, Element, FrameWords, Kind, Word, WordValue};
use crate::units::push_integer;

use super::number::push_value;
use super::{Decimals, Writer, WriterOptions};

/// What the output takes for granted: absolute coordinates. Written before the first motion where the program does not say it.
const ASSUMED: &str = "G90";
/// Stands in each block with machine coordinates.
const IN_MACHINE_FRAME: &str = "G153";
/// Words that suppress frames for their block.
const SUPPRESSING: [&str; 3] = ["G53", "G153", "SUPA"];
/// The comment of a step on the spot with which a move begins.
const ON_THE_SPOT: &str = ";~";
/// Exact stop at the end of every block, and its counterpart; the group has more members, which all stop nowhere.
const ALWAYS_STOP: &str = "G60";
const NEVER_STOP: &str = "G64";
const STOP_GROUP: [&str; 7] = [ALWAYS_STOP, NEVER_STOP, "G641", "G642", "G643", "G644", "G645"];
/// Acts at the end of its block.
const EXACT_STOP: &str = "G9";
/// Shifts are written to this many parts of a mm or degree: far below any increment, without the noise of the arithmetic.
const SHIFT_PARTS: f64 = 1e9;

/// The writer of the dialect.
pub(super) fn create(options: &WriterOptions) -> Option<Box<dyn Writer>> {
    Some(Box::new(Sinumerik {
        linear: Decimals::of_increment(options.increments.linear_mm)?,
        rotary: Decimals::of_increment(options.increments.rotary_deg)?,
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
        motion: 0,
        feed: 0.0,
        blocks: 0,
    }))
}

struct Sinumerik {
    linear: Decimals,
    rotary: Decimals,
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
    /// The G word of motion in force: `b'0'` to `b'3'`, 0 for none yet.
    motion: u8,
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
            // Still to be written in a block without motion.
            self.exact_stop();
        }
        self.end_line(out);
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

    fn element(&mut self, element: &Element, out: &mut Vec<u8>) {
        if let Kind::Header(bytes) = &element.kind {
            out.extend_from_slice(bytes);
            out.extend_from_slice(self.line_end);
            return;
        }
        self.stamp(out);
        match &element.kind {
            Kind::Header(_) | Kind::Move(_) | Kind::Setup(_) | Kind::Empty => {}
            Kind::Comment(bytes) => {
                if !self.comment.is_empty() {
                    self.comment.push(b' ');
                }
                self.comment.extend_from_slice(bytes);
            }
            kind => self.words(kind),
        }
    }

    fn words(&mut self, kind: &Kind) {
        match kind {
            Kind::Keep(word) if SUPPRESSING.contains(word) => {
                self.suppressing = Some(word);
                if !self.in_machine_frame {
                    self.word(word.as_bytes());
                }
            }
            Kind::Keep(word) if *word == EXACT_STOP => self.stops_exactly = true,
            Kind::Keep(word) if *word == ASSUMED => {
                self.has_assumed = true;
                self.word(word.as_bytes());
            }
            Kind::Keep(word) => {
                if STOP_GROUP.contains(word) {
                    self.always_stops = *word == ALWAYS_STOP;
                }
                self.word(word.as_bytes());
                if *word == ALWAYS_STOP {
                    self.stop_word_at = Some(self.line.len() - word.len());
                }
            }
            Kind::Frame(words) => self.frame(words),
            Kind::Tool(value) => self.auxiliary(b'T', None, value),
            Kind::Before(words) => {
                // They are put together on the line and taken off it until the motion has been written.
                let start = self.line.len();
                for Word { letter, extension, value } in words {
                    self.auxiliary(*letter, *extension, value);
                }
                self.held.extend_from_slice(&self.line[start..]);
                self.line.truncate(start);
            }
            Kind::After(words) => {
                self.release();
                for Word { letter, extension, value } in words {
                    self.auxiliary(*letter, *extension, value);
                }
            }
            Kind::Feed(feed) => self.feed_word(*feed),
            Kind::Dwell(dwell) => {
                let (letter, value) = match dwell {
                    Dwell::Seconds(seconds) => (&b"F"[..], *seconds),
                    Dwell::Turns(turns) => (&b"S"[..], *turns),
                };
                self.word(b"G4");
                self.word(letter);
                push_value(&mut self.line, value);
            }
            Kind::Message(text) if text.is_empty() => self.word(b"MSG()"),
            Kind::Message(text) => {
                self.word(b"MSG(\"");
                self.line.extend_from_slice(text);
                self.line.extend_from_slice(b"\")");
            }
            Kind::Header(_) | Kind::Comment(_) | Kind::Move(_) | Kind::Setup(_) | Kind::Empty => {}
        }
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

    fn exact_stop(&mut self) {
        if std::mem::take(&mut self.stops_exactly) {
            self.word(EXACT_STOP.as_bytes());
        }
    }

    fn feed_word(&mut self, feed: f64) {
        self.word(b"F");
        push_value(&mut self.line, feed);
        self.feed = feed;
    }

    fn auxiliary(&mut self, letter: u8, extension: Option<u32>, value: &WordValue) {
        self.word(&[letter]);
        if let Some(extension) = extension {
            push_integer(&mut self.line, u64::from(extension));
        }
        match value {
            WordValue::Number(number) => {
                if extension.is_some() {
                    self.line.push(b'=');
                }
                push_value(&mut self.line, *number);
            }
            WordValue::Name(name) => {
                self.line.extend_from_slice(b"=\"");
                self.line.extend_from_slice(name);
                self.line.push(b'"');
            }
        }
    }

    fn frame(&mut self, words: &FrameWords) {
        match words {
            FrameWords::Settable(name) => self.word(name.as_bytes()),
            FrameWords::Translate { additive, shift, named } => {
                self.word(if *additive { b"ATRANS" } else { b"TRANS" });
                for axis in named.iter() {
                    self.word(&[axis.letter()]);
                    push_value(&mut self.line, shown_shift(axis, shift));
                }
            }
        }
    }

    fn piece(&mut self, piece: &Piece) {
        if piece.last {
            self.exact_stop();
        }
        let is_continued = !piece.first;
        self.has_motion = true;
        // The program stops at the end of its move, not at the end of each piece.
        if self.always_stops && piece.first != piece.last {
            let word = if piece.first { NEVER_STOP } else { ALWAYS_STOP }.as_bytes();
            match self.stop_word_at {
                // One word of a group in a block: the one that is there changes.
                Some(at) => self.line[at..at + word.len()].copy_from_slice(word),
                None => self.word(word),
            }
        }
        if self.in_machine_frame {
            self.word(IN_MACHINE_FRAME.as_bytes());
        } else if let Some(word) = self.suppressing.filter(|_| self.is_again && piece.in_machine_frame) {
            self.word(word.as_bytes());
        }
        let motion = match (piece.rapid, &piece.arc) {
            (true, _) => b'0',
            (false, None) => b'1',
            (false, Some(arc)) if arc.clockwise => b'2',
            (false, Some(_)) => b'3',
        };
        if piece.starts_block || piece.first || motion != self.motion {
            self.word(&[b'G', motion]);
            self.motion = motion;
        }
        for axis in piece.words.iter() {
            self.word(&[axis.letter()]);
            let decimals = if axis.is_rotary() { self.rotary } else { self.linear };
            decimals.push(&mut self.line, piece.counts[axis.slot()]);
        }
        if let Some(arc) = &piece.arc {
            let across = arc.plane.axes()[2];
            for (letter, axis) in [(b'I', Axis::X), (b'J', Axis::Y), (b'K', Axis::Z)] {
                if axis != across {
                    self.word(&[letter]);
                    self.linear.push(&mut self.line, arc.center_counts[axis.slot()]);
                }
            }
            if arc.extra_turns > 0 {
                self.word(b"TURN=");
                push_integer(&mut self.line, u64::from(arc.extra_turns));
            }
        }
        if piece.feed_named || !piece.rapid && piece.feed > 0.0 && piece.feed != self.feed {
            self.feed_word(piece.feed);
        }
        self.release();
        if self.comment.is_empty() {
            let mark = match (piece.take_up, is_continued) {
                (true, false) => ON_THE_SPOT,
                (true, true) => CONTINUES_ON_THE_SPOT,
                (false, true) => CONTINUES,
                (false, false) => "",
            };
            self.comment.extend_from_slice(mark.as_bytes());
        }
    }
}

/// A shift in mm or degrees without the noise of the arithmetic.
fn shown_shift(axis: Axis, shift: &AxisVector) -> f64 {
    let value = if axis.is_rotary() { shift[axis].to_degrees() } else { shift[axis] };
    (value * SHIFT_PARTS).round() / SHIFT_PARTS
}
