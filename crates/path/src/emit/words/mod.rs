//! Programs in word-address languages: Fanuc and compatible controls, RS274/NGC, Grundig.
//!
//! One writer, three flavors: differences are data of a [`Flavour`] or an arm over its [`Language`]. All coordinates are absolute, in millimeters or
//! inches as in the program. The line before the first words states this; the program's own statements about it are left out.

mod cycle;
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
use ncfix_base::source::Source;
use ncfix_machine::snc::{BlockNumber, Origin};

use super::block_number::{BlockNumbers, NumberSet};
use super::comment::in_parentheses;
use super::guard::GuardWords;
use super::kept::KeptLines;
use super::line::LineBuilder;
use super::number::{AxisNumbers, push_pointed, push_value, to_digits};
use super::passes::{self, LoopPasses};
use super::sections::Sections;
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

/// Codes of the unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum UnitCodes {
    /// G20 and G21.
    G20AndG21,
    /// G70 and G71.
    G70AndG71,
}

/// Differences between the languages.
#[derive(Debug)]
struct Flavour {
    language: Language,
    /// Name of the dialect.
    dialect: &'static str,
    /// Codes of inches and millimeters.
    units: UnitCodes,
    /// Assumptions of the output in millimeters, written before its first words. The code of the unit is the first one.
    assumed: &'static str,
    /// Codes that [`Self::assumed`] replaces wherever the program has them.
    replaced: &'static [&'static str],
    /// `true` if positions and feeds always have a decimal point.
    is_pointed: bool,
    /// Significant digits of a feed.
    feed_digits: i32,
    /// Length of a line with words, bytes, beyond which its comment gets a separate line.
    longest: usize,
    /// `true` if every line has a number, not only the first line of a source block.
    is_numbered: bool,
    /// `true` if comments need parentheses and texts need capitals.
    is_plain: bool,
    /// The largest turn of one block around a circle.
    turns: Turns,
    /// Coordinates of arc centers.
    centers: Centers,
    /// The path to which the feed refers.
    feeds: Feeds,
    /// Words that compare data of the control.
    guard: Option<GuardWords>,
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
            has_spatial_arcs: false,
            has_transformation: !matches!(self.language, Language::Grundig),
            assumed: self.assumed,
            guard: self.guard,
        }
    }
}

/// Creates the writer of a flavor; `None` if an increment is not a decimal.
fn create(flavour: &'static Flavour, options: &WriterOptions) -> Option<Box<dyn Writer>> {
    let mut numbers = AxisNumbers::new(&options.increments)?;
    if flavour.is_pointed {
        numbers.linear = numbers.linear.pointed();
        numbers.rotary = numbers.rotary.pointed();
    }
    // The output is absolute, in one unit.
    let in_force: &[&str] = match (flavour.units, options.increments.unit_mm == 1.0) {
        (UnitCodes::G20AndG21, true) => &["G90", "G21"],
        (UnitCodes::G20AndG21, false) => &["G90", "G20"],
        (UnitCodes::G70AndG71, true) => &["G90", "G71"],
        (UnitCodes::G70AndG71, false) => &["G90", "G70"],
    };
    let line = LineBuilder::new(options.crlf, KeptLines::new(in_force, true, flavour.is_pointed))
        .no_longer_than(flavour.longest);
    let block_ends = ncfix_dialect::find(flavour.dialect)?.block_ends;
    let stamp = &options.stamp;
    Some(Box::new(Words {
        flavour,
        numbers,
        stamp: if flavour.is_plain { format!("({})", stamp.capital_text()) } else { format!("; {}", stamp.text()) },
        is_stamped: false,
        guard: Vec::new(),
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
        cycle: None,
        definition: String::new(),
        increment_mm: options.increments.linear_mm,
        has_centers_reversed: options.has_centers_reversed && flavour.language != Language::Rs274,
        is_drilling: false,
        has_ended: false,
        feed: 0.0,
        is_inverse_time: false,
        sections: None,
    }))
}

struct Words {
    flavour: &'static Flavour,
    numbers: AxisNumbers,
    /// The stamp, as text of the first comment.
    stamp: String,
    is_stamped: bool,
    /// Lines after the assumptions.
    guard: Vec<String>,
    /// `true` if the words of a center point from it to the start of the arc.
    has_centers_reversed: bool,
    has_assumed: bool,
    /// The length unit of the output, mm.
    unit_mm: f64,
    /// `true` if the file began with `%` and so must end with it.
    is_tape: bool,
    line: LineBuilder,
    stops: Stops,
    block_numbers: BlockNumbers,
    /// `true` if the line has a P word that an arc in the same line would read as its turns.
    has_p: bool,
    /// End of the last piece; `None` if the coordinates have changed since.
    place: Option<[i64; AXIS_COUNT]>,
    /// Start position of rigid tapping.
    tapped_from: Option<[i64; AXIS_COUNT]>,
    /// The active G word of motion; empty if unknown.
    motion: &'static str,
    /// Words of the drilling cycle that a further hole need not repeat.
    cycle: Option<cycle::WrittenCycle>,
    /// The defined cycle of a Grundig; empty if none was written.
    definition: String,
    /// Increment of heights, mm.
    increment_mm: f64,
    /// `true` if a drilling cycle is in force.
    is_drilling: bool,
    /// `true` if the line ends the drilling cycles; a motion needs its own line.
    has_ended: bool,
    /// The active feed; NaN if unknown.
    feed: f64,
    /// Feed mode G93: every feed move states its inverse time.
    is_inverse_time: bool,
    /// Sections that can become subprograms, if the output marks them.
    sections: Option<Sections>,
}

impl Writer for Words {
    fn write(&mut self, output: &Output, out: &mut Vec<u8>) -> Result<(), Diagnostic> {
        match output {
            // Nothing moves: the line above ends the move, and stops if the program stops.
            Output::Piece(piece) if piece.stands_still() && !self.needs_feed(piece) => Ok(()),
            Output::Piece(piece) => {
                if piece.starts_block {
                    self.begin_block(&piece.origin, piece.number, out);
                // Words that a contour held back may come after the feed of the next block.
                } else if !piece.first || self.line.has_motion || self.line.has_feed && self.needs_feed(piece) {
                    self.stops.run_through(&mut self.line);
                    self.line.end(out);
                    self.line.open();
                }
                let is_apart = std::mem::take(&mut self.has_p) && piece.arc.is_some();
                if std::mem::take(&mut self.has_ended) || is_apart {
                    self.line.end(out);
                }
                self.assume(out);
                self.piece(piece)
            }
            Output::Cycle(block) => {
                if block.starts_block {
                    self.begin_block(&block.origin, block.number, out);
                } else if self.line.has_motion || std::mem::take(&mut self.has_ended) {
                    self.line.end(out);
                    self.line.open();
                }
                self.assume(out);
                self.cycle(block, out);
                Ok(())
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
        if let Some(change) = self.sections.as_mut().map(Sections::finish) {
            change.mark(b"", out);
        }
        if self.is_tape {
            self.line.header(b"%", out);
        }
    }

    fn keep_free(&mut self, numbers: NumberSet) {
        self.line.keep_free(numbers);
    }

    fn begin_with(&mut self, lines: Vec<String>) {
        self.guard = lines;
    }

    fn keep_lines(&mut self, program: Source) {
        self.line.kept.of(program);
    }

    fn mark_passes(&mut self) {
        self.line.kept.passes = Some(LoopPasses::default());
    }

    fn mark_sections(&mut self) {
        self.sections = Some(Sections::default());
    }

    fn blocks(&self) -> u64 {
        self.line.blocks()
    }
}

impl Words {
    /// Ends the previous block and begins another.
    fn begin_block(&mut self, origin: &Origin, number: Option<BlockNumber>, out: &mut Vec<u8>) {
        self.end_block(out);
        self.has_p = false;
        self.has_ended = false;
        self.stops.begin_block();
        let pass = self.line.kept.begin(origin, number.is_some());
        let pass = pass.map(|pass| passes::text(pass, number.map(|number| number.number), origin.line));
        let pass = pass.map_or_else(Vec::new, |text| match self.flavour.is_plain {
            true => in_parentheses(text.to_ascii_uppercase().as_bytes()),
            false => format!("; {text}").into_bytes(),
        });
        if !self.turn_section(origin, &pass, out) && !pass.is_empty() {
            self.line.note(&[&pass]);
        }
        self.line.open();
        let own = self.block_numbers.first(origin, number).map(|own| own.number);
        if self.flavour.is_numbered {
            self.line.own_number(own);
        } else if let Some(number) = own {
            self.line.block_number(b'N', number);
        }
    }

    /// Begins or ends a section. Its text depends as little as possible on what precedes it: it states motion, feed and cycle again. Returns `true`
    /// within a section.
    fn turn_section(&mut self, origin: &Origin, comment: &[u8], out: &mut Vec<u8>) -> bool {
        let Some(sections) = &mut self.sections else { return false };
        let change = sections.note(origin);
        let is_open = sections.is_open();
        if change.is_any() {
            self.assume(out);
            change.mark(comment, out);
            self.motion = "";
            self.feed = f64::NAN;
            self.cycle = None;
            self.definition.clear();
        }
        is_open
    }

    /// Ends the last line of a block.
    fn end_block(&mut self, out: &mut Vec<u8>) {
        self.stops.end_block(&mut self.line);
        self.line.end(out);
    }

    /// Begins a separate line for words that act after the motion of the line or before another.
    fn leave_motion(&mut self, out: &mut Vec<u8>) {
        if self.line.has_motion {
            self.line.end(out);
        }
    }

    /// Writes the stamp, once.
    fn stamp(&mut self, out: &mut Vec<u8>) {
        if !std::mem::replace(&mut self.is_stamped, true) {
            self.line.comment_before(self.stamp.as_bytes(), out);
        }
    }

    /// Writes the assumptions of the file in a separate line, before the first words.
    fn assume(&mut self, out: &mut Vec<u8>) {
        if !self.has_assumed {
            self.stamp(out);
            self.has_assumed = true;
            let assumed = self.flavour.assumed;
            let inch = if self.unit_mm == 1.0 { None } else { assumed.strip_prefix("G21") };
            let text = inch.map_or_else(|| assumed.to_owned(), |rest| format!("G20{rest}"));
            self.line.words_before(text.as_bytes(), out);
            self.guard.iter().for_each(|line| self.line.header(line.as_bytes(), out));
        }
    }

    /// `true` if the feed of a piece must be written.
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

    /// Appends a number, with a decimal point if the language needs one.
    fn value(&mut self, value: f64) {
        if self.flavour.is_pointed {
            push_pointed(&mut self.line.text, value);
        } else {
            push_value(&mut self.line.text, value);
        }
    }

    /// The diagnostic for an element that the language cannot express.
    fn no_words(&self, origin: &Origin, what: &str, help: &str) -> Diagnostic {
        let place = Place { file: origin.file, span: origin.span };
        let dialect = self.flavour.dialect;
        Diagnostic::at(Code::NOT_SUPPORTED, place, format!("{what} cannot be written in the dialect {dialect}"), help)
    }
}
