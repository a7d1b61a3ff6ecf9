//! Programs of the Sinumerik 840D and 828D.
//!
//! Further lines of a source block carry the comment `;+`, steps on the spot `;~`.

mod cycle;
mod motion;
mod words;

use std::collections::HashSet;

use crate::path::{Centers, Feeds, Output, OutputFrame, Piece, Turns};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXIS_COUNT, Axis};
use ncfix_base::source::Source;
use ncfix_machine::snc::{BlockNumber, FeedUnit, Kind, Origin};

use super::block_number::BlockNumbers;
use super::kept::KeptLines;
use super::line::LineBuilder;
use super::number::{AxisNumbers, push_value, to_digits};
use super::passes::{self, LoopPasses};
use super::sections::Sections;
use super::stops::Stops;
use super::{Writer, WriterEntry, WriterOptions, is_compensation};

/// Assumption of the output: absolute coordinates. Written before the first motion if the program does not state it.
const ASSUMED: &str = "G90";
/// Significant digits of a feed; the last digits of computed feeds are noise.
const FEED_DIGITS: i32 = 12;

pub(super) const ENTRY: WriterEntry = WriterEntry {
    dialect: "sinumerik",
    create,
    turns: Turns::Several,
    centers: Centers::OnBisector,
    feeds: Feeds::OfLinear,
    has_machine_frame: true,
    has_transformation: true,
    has_spatial_arcs: true,
    assumed: ASSUMED,
    guard: Some(super::guard::sinumerik),
};

/// The writer of the dialect.
fn create(options: &WriterOptions) -> Option<Box<dyn Writer>> {
    Some(Box::new(Sinumerik {
        numbers: AxisNumbers::new(&options.increments)?,
        names: options.names.clone(),
        in_machine_frame: options.frame == OutputFrame::Machine,
        stamp: options.stamp.text(),
        is_stamped: false,
        guard: Vec::new(),
        has_assumed: false,
        line: LineBuilder::new(options.crlf, KeptLines::new(&["G90"], false, false)),
        stops: Stops::new(ncfix_dialect::sinumerik().block_ends),
        block_numbers: BlockNumbers::default(),
        labels: HashSet::new(),
        is_again: false,
        suppressing: None,
        motion: "",
        modal_call: Vec::new(),
        bare_block: Vec::new(),
        increment_mm: options.increments.linear_mm,
        feed: 0.0,
        sections: None,
    }))
}

struct Sinumerik {
    numbers: AxisNumbers,
    names: [Option<String>; AXIS_COUNT],
    in_machine_frame: bool,
    stamp: String,
    is_stamped: bool,
    /// Lines after the stamp.
    guard: Vec<String>,
    has_assumed: bool,
    line: LineBuilder,
    stops: Stops,
    block_numbers: BlockNumbers,
    /// Labels written so far.
    labels: HashSet<Vec<u8>>,
    /// `true` if the line is a further line of its block.
    is_again: bool,
    /// The frame-suppressing word of the block.
    suppressing: Option<&'static str>,
    /// The active G word of motion; empty if none yet.
    motion: &'static str,
    /// The modal call in force; empty without one.
    modal_call: Vec<u8>,
    /// Number of a block without words that may be the one of the next modal call.
    bare_block: Vec<u8>,
    /// Increment of heights, mm.
    increment_mm: f64,
    feed: f64,
    /// Sections that can become subprograms, if the output marks them.
    sections: Option<Sections>,
}

impl Writer for Sinumerik {
    fn write(&mut self, output: &Output, out: &mut Vec<u8>) -> Result<(), Diagnostic> {
        let leads_to_hole = match output {
            Output::Piece(_) => false,
            Output::Cycle(_) => true,
            Output::Element(element) => matches!(element.kind, Kind::Setup(_) | Kind::Keep(_) | Kind::Empty),
        };
        if !leads_to_hole {
            self.end_bare_block(out);
        }
        match output {
            // Nothing moves: the line above ends the move, and stops if the program stops.
            Output::Piece(piece) if piece.stands_still() && !self.needs_feed(piece) => {}
            Output::Piece(piece) => {
                // Words that a contour held back may come after the feed of the next block.
                let has_other_feed = self.line.has_feed && self.needs_feed(piece);
                self.is_again = !piece.starts_block && (!piece.first || self.line.has_motion || has_other_feed);
                if piece.starts_block || self.is_again {
                    self.begin(piece.starts_block, (&piece.origin, piece.number), out);
                    // The line above may have been a number that waits for a modal call.
                    self.end_bare_block(out);
                }
                self.assume(out);
                self.end_modal_call(out);
                self.piece(piece);
            }
            Output::Cycle(block) => {
                self.is_again = false;
                if block.starts_block || self.line.has_motion {
                    self.begin(block.starts_block, (&block.origin, block.number), out);
                }
                self.assume(out);
                self.cycle(block, out);
            }
            Output::Element(element) => {
                let switches = matches!(&element.kind, Kind::Verbatim(text) if is_compensation(text));
                if element.starts_block || switches && self.line.has_motion {
                    self.begin(element.starts_block, (&element.origin, element.number), out);
                    if !leads_to_hole {
                        self.end_bare_block(out);
                    }
                }
                self.element(element, out);
            }
        }
        Ok(())
    }

    fn finish(&mut self, out: &mut Vec<u8>) {
        self.end_bare_block(out);
        self.end_block(out);
        self.stamp(out);
        if let Some(change) = self.sections.as_mut().map(Sections::finish) {
            change.mark(b"", out);
        }
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

impl Sinumerik {
    /// Ends the previous line and begins another.
    fn begin(&mut self, is_block: bool, (origin, number): (&Origin, Option<BlockNumber>), out: &mut Vec<u8>) {
        if is_block {
            self.set_bare_block_aside(out);
            self.end_block(out);
            self.suppressing = None;
            self.stops.begin_block();
        } else {
            self.stops.run_through(&mut self.line);
            self.line.end(out);
        }
        if is_block {
            let own = number.filter(|number| !number.main).map(|number| number.number);
            let pass = self.line.kept.begin(origin, number.is_some());
            let pass = pass.map(|pass| format!("; {}", passes::text(pass, own, origin.line))).unwrap_or_default();
            if !self.turn_section(origin, pass.as_bytes(), out) && !pass.is_empty() {
                self.line.note(&[pass.as_bytes()]);
            }
        }
        self.line.open();
        if let Some(number) = self.block_numbers.first(origin, number.filter(|_| is_block)) {
            self.line.block_number(if number.main { b':' } else { b'N' }, number.number);
        }
    }

    /// Begins or ends a section. Its text depends as little as possible on what precedes it: it states motion, feed and cycle again, and no modal call
    /// leads out of it. Returns `true` within a section.
    fn turn_section(&mut self, origin: &Origin, comment: &[u8], out: &mut Vec<u8>) -> bool {
        let Some(sections) = &mut self.sections else { return false };
        let change = sections.note(origin);
        let is_open = sections.is_open();
        if change.is_any() {
            self.end_bare_block(out);
            self.end_modal_call(out);
            self.assume(out);
            change.mark(comment, out);
            self.motion = "";
            self.feed = f64::NAN;
        }
        is_open
    }

    /// Ends the last line of a block.
    fn end_block(&mut self, out: &mut Vec<u8>) {
        self.stops.end_block(&mut self.line);
        self.line.end(out);
    }

    /// Writes the stamp, once.
    fn stamp(&mut self, out: &mut Vec<u8>) {
        if !std::mem::replace(&mut self.is_stamped, true) {
            self.line.header(format!("; {}", self.stamp).as_bytes(), out);
            self.guard.iter().for_each(|line| self.line.header(line.as_bytes(), out));
        }
    }

    /// Writes the meaning of the coordinates in its own line, before the first words.
    fn assume(&mut self, out: &mut Vec<u8>) {
        if self.has_assumed {
            return;
        }
        self.stamp(out);
        self.has_assumed = true;
        self.line.words_before(ASSUMED.as_bytes(), out);
    }

    /// Appends a word after a blank.
    fn word(&mut self, bytes: &[u8]) {
        self.line.word(bytes);
    }

    /// Appends the name of an axis; `true` if a value after it needs an equals sign.
    fn axis_name(&mut self, axis: Axis) -> bool {
        let name = self.names.get(axis.slot()).and_then(Option::as_ref);
        match name {
            Some(name) => self.line.text.extend_from_slice(name.as_bytes()),
            None => self.line.text.push(axis.letter()),
        }
        name.is_some()
    }

    /// `true` if the feed of a piece must be written.
    fn needs_feed(&self, piece: &Piece) -> bool {
        // An inverse time applies to its block only: a control does not inherit it.
        let is_new = piece.feed > 0.0 && (piece.unit == FeedUnit::InverseTime || piece.feed != self.feed);
        piece.feed_named || !piece.rapid && is_new
    }

    fn feed_word(&mut self, feed: f64) {
        self.line.has_feed = true;
        self.word(b"F");
        push_value(&mut self.line.text, to_digits(feed, FEED_DIGITS));
        self.feed = feed;
    }
}
