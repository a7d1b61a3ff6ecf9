//! Programs in the languages of letters with values: Fanuc and its kin, RS274/NGC, Grundig.
//!
//! One writer, three flavours: what they write differently is data of a [`Flavour`] or an arm over its [`Language`]. All coordinates
//! are absolute, and metric or in inches as the program states it, which the line before the first words says; what the program says about that itself is left out.

mod element;
mod fanuc;
mod grundig;
mod motion;
mod rs274;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod thread_tests;

use crate::path::{Centers, Feeds, Output, Piece, Turns};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::AXIS_COUNT;
use ncfix_machine::snc::{BlockNumber, Origin};

use super::block_number::{BlockNumbers, NumberSet};
use super::line::LineBuilder;
use super::number::{AxisNumbers, push_pointed, push_value, to_digits};
use super::stops::Stops;
use super::{Writer, WriterEntry, WriterOptions};

pub(super) const FANUC: WriterEntry = fanuc::FLAVOUR.entry(fanuc::create);
pub(super) const GRUNDIG: WriterEntry = grundig::FLAVOUR.entry(grundig::create);
pub(super) const RS274: WriterEntry = rs274::FLAVOUR.entry(rs274::create);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Language {
    Fanuc,
    Rs274,
    Grundig,
}

/// What the languages write differently.
#[derive(Debug)]
struct Flavour {
    language: Language,
    /// Name of the dialect.
    dialect: &'static str,
    /// What the output takes for granted, before its first words.
    assumed: &'static str,
    /// Codes that this replaces, wherever the program has them.
    replaced: &'static [&'static str],
    /// Whether positions and feeds have a decimal point in any case.
    is_pointed: bool,
    /// Significant digits of a feed.
    feed_digits: i32,
    /// Bytes of a line with words beyond which its comment gets a line of its own.
    longest: usize,
    /// Whether every line has a number of its own, instead of those of the source.
    is_numbered: bool,
    /// Whether comments are known in parentheses only, and texts in capitals.
    is_plain: bool,
    /// How far one block may lead around a circle.
    turns: Turns,
    /// Where its controls have the center of an arc.
    centers: Centers,
    /// For which way its controls take a feed.
    feeds: Feeds,
}

impl Flavour {
    const fn entry(&self, create: fn(&WriterOptions) -> Option<Box<dyn Writer>>) -> WriterEntry {
        WriterEntry {
            dialect: self.dialect,
            create,
            turns: self.turns,
            centers: self.centers,
            feeds: self.feeds,
            has_machine_frame: false,
            assumed: self.assumed,
        }
    }
}

/// The writer of a flavour; `None` where an increment is no decimal.
fn create(flavour: &'static Flavour, options: &WriterOptions) -> Option<Box<dyn Writer>> {
    let mut numbers = AxisNumbers::new(&options.increments)?;
    if flavour.is_pointed {
        numbers.linear = numbers.linear.pointed();
        numbers.rotary = numbers.rotary.pointed();
    }
    let line = LineBuilder::new(options.crlf).no_longer_than(flavour.longest);
    let block_ends = ncfix_dialect::find(flavour.dialect)?.block_ends;
    let stamp = &options.stamp;
    Some(Box::new(Words {
        flavour,
        numbers,
        stamp: if flavour.is_plain { format!("({})", stamp.capital_text()) } else { format!("; {}", stamp.text()) },
        is_stamped: false,
        has_assumed: false,
        is_tape: false,
        unit_mm: options.increments.unit_mm,
        line: if flavour.is_numbered { line.numbered(options.last_block_number.unwrap_or(u32::MAX)) } else { line },
        stops: Stops::new(block_ends),
        block_numbers: BlockNumbers::default(),
        has_p: false,
        place: None,
        tapped_from: None,
        motion: "",
        feed: 0.0,
        is_inverse_time: false,
    }))
}

struct Words {
    flavour: &'static Flavour,
    numbers: AxisNumbers,
    /// The first comment.
    stamp: String,
    is_stamped: bool,
    has_assumed: bool,
    /// The length unit of the output, mm.
    unit_mm: f64,
    /// Whether the file began with `%`, and so ends.
    is_tape: bool,
    line: LineBuilder,
    stops: Stops,
    block_numbers: BlockNumbers,
    /// Whether the line has a P that an arc beside it would take for its turns.
    has_p: bool,
    /// Where the last piece ended, unless the coordinates have changed since.
    place: Option<[i64; AXIS_COUNT]>,
    /// Where rigid tapping began.
    tapped_from: Option<[i64; AXIS_COUNT]>,
    /// The G word of motion in force, empty for none that is known.
    motion: &'static str,
    /// The feed in force, NaN for none that is known.
    feed: f64,
    /// Feed mode G93: every feed move says how long it takes.
    is_inverse_time: bool,
}

impl Writer for Words {
    fn write(&mut self, output: &Output, out: &mut Vec<u8>) -> Result<(), Diagnostic> {
        match output {
            // Nothing moves: the line above ends the move, and stops where the program does.
            Output::Piece(piece) if piece.stands_still() && !self.needs_feed(piece) => Ok(()),
            Output::Piece(piece) => {
                if piece.starts_block {
                    self.begin_block(&piece.origin, piece.number, out);
                // What a contour has held back may come behind the feed of the next block.
                } else if !piece.first || self.line.has_motion || self.line.has_feed && self.needs_feed(piece) {
                    self.stops.run_through(&mut self.line);
                    self.line.end(out);
                    self.line.open();
                }
                if std::mem::take(&mut self.has_p) && piece.arc.is_some() {
                    self.line.end(out);
                }
                self.assume(out);
                self.piece(piece)
            }
            Output::Element(element) => {
                if element.starts_block {
                    self.begin_block(&element.origin, element.number, out);
                }
                self.element(element, out)
            }
        }
    }

    fn finish(&mut self, out: &mut Vec<u8>) {
        self.end_block(out);
        self.stamp(out);
        if self.is_tape {
            self.line.header(b"%", out);
        }
    }

    fn keep_free(&mut self, numbers: NumberSet) {
        self.line.keep_free(numbers);
    }

    fn blocks(&self) -> u64 {
        self.line.blocks()
    }
}

impl Words {
    /// Ends the block before and begins another.
    fn begin_block(&mut self, origin: &Origin, number: Option<BlockNumber>, out: &mut Vec<u8>) {
        self.end_block(out);
        self.has_p = false;
        self.stops.begin_block();
        self.line.open();
        let own = self.block_numbers.first(origin, number).map(|own| own.number);
        if self.flavour.is_numbered {
            self.line.own_number(own);
        } else if let Some(number) = own {
            self.line.block_number(b'N', number);
        }
    }

    /// Ends the last line of a block.
    fn end_block(&mut self, out: &mut Vec<u8>) {
        self.stops.end_block(&mut self.line);
        self.line.end(out);
    }

    /// Words that act behind the motion of the line, or before another, get a line of their own.
    fn leave_motion(&mut self, out: &mut Vec<u8>) {
        if self.line.has_motion {
            self.line.end(out);
        }
    }

    /// Writes the stamp unless it is there.
    fn stamp(&mut self, out: &mut Vec<u8>) {
        if !std::mem::replace(&mut self.is_stamped, true) {
            self.line.comment_before(self.stamp.as_bytes(), out);
        }
    }

    /// Before the first words: what this file takes for granted, in a line of its own.
    fn assume(&mut self, out: &mut Vec<u8>) {
        if !self.has_assumed {
            self.stamp(out);
            self.has_assumed = true;
            let assumed = self.flavour.assumed;
            let inch = if self.unit_mm == 1.0 { None } else { assumed.strip_prefix("G21") };
            let text = inch.map_or_else(|| assumed.to_owned(), |rest| format!("G20{rest}"));
            self.line.words_before(text.as_bytes(), out);
        }
    }

    /// Whether a piece has a feed that is to be written.
    fn needs_feed(&self, piece: &Piece) -> bool {
        let is_new = !piece.rapid && piece.feed > 0.0 && (self.is_inverse_time || piece.feed != self.feed);
        piece.feed_named || is_new
    }

    fn feed_word(&mut self, feed: f64) {
        self.line.has_feed = true;
        self.line.word(b"F");
        let unit = if self.is_inverse_time { 1.0 } else { self.unit_mm };
        self.value(to_digits(feed / unit, self.flavour.feed_digits));
        self.feed = feed;
    }

    /// Appends a number, with a decimal point where the language wants one.
    fn value(&mut self, value: f64) {
        if self.flavour.is_pointed {
            push_pointed(&mut self.line.text, value);
        } else {
            push_value(&mut self.line.text, value);
        }
    }

    /// What is to be written has no words in the language.
    fn no_words(&self, origin: &Origin, what: &str, help: &str) -> Diagnostic {
        let place = Place { file: origin.file, span: origin.span };
        let dialect = self.flavour.dialect;
        Diagnostic::at(Code::NOT_SUPPORTED, place, format!("{what} cannot be written in the dialect {dialect}"), help)
    }
}
