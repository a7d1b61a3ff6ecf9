//! Where a job that was broken off can be taken up again, and what the control must be told before.
//!
//! A place is safe where the tool moves rapidly above the highest place at which anything is machined, by [`CLEAR_MM`] at least, so that whatever was
//! carried out behind it is carried out again from a place that nothing is hit on the way to. At the height of the highest cut itself nothing is safe:
//! there the tool crosses what stands beside the cut. A person may state a height that is clear; then the way leads over that, and a rapid move
//! at the highest place will do. What the control must know there is read from the lines before: the last code of every group, spindle and coolant, and
//! where each axis stands. Frames and words of unknown effect cannot be rebuilt; behind them nothing is safe but the beginning, and that only
//! where the program itself begins by lifting the tool.

use super::heights::{Heights, SAME_MM, is_height_known};
use super::told::Told;
use crate::dialect::CodeTable;
use crate::feed::Line;
use crate::geometry::Axis;
use crate::path::{Output, Piece, Tips};
use crate::snc::{FrameWords, Kind};

/// A place lies so far above all that is machined, mm: corrections are below 0.2 mm, and what is told of the height of a workpiece is no better.
pub const CLEAR_MM: f64 = 1.0;

/// A place to begin again.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The first element that is sent.
    pub element: u64,
    /// Line of the source.
    pub source_line: u32,
    /// What is sent before it.
    pub lines: Vec<String>,
    /// The tool word that was last in force.
    pub tool: Option<String>,
    /// The first line of the program that is sent.
    pub first: String,
    /// How far the tool is above all that is machined when it moves across, mm.
    pub above_mm: f64,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// A safe place.
    Place(Place),
    /// The beginning, which lifts the tool by so many mm above all that is machined; what is sent before it.
    Beginning(Vec<String>, f64),
    /// The height that a person has stated is not above all that is machined: that ends at this Z of the program, mm.
    TooLow(f64),
    /// Nothing brings the tool clear of the workpiece: why.
    Nothing(Why),
}

/// Why no place is safe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// None lies above all that is machined, and the first move does not lead there: with a height stated it may.
    NoneAbove,
    /// The tool stood tilted against Z: no move of Z lifts it along itself.
    Tilted,
    /// A cut of this line of the source is at a height that the program does not state.
    HeightUnknown(u32),
    /// Only the beginning is left, and its first move does not lift the tool.
    BeginningCrosses,
}

/// The first move of a program.
#[derive(Clone, Copy, Debug, Default)]
struct Start {
    element: u64,
    /// How far it lifts the tool above all that is machined, mm, where it does so and moves nothing else.
    lifts_mm: Option<f64>,
    /// How far a stated height is above that, mm.
    stated_mm: Option<f64>,
}

/// Looks for the last safe place.
pub struct Search<'a> {
    codes: &'static CodeTable,
    tips: Tips<'a>,
    heights: &'a Heights,
    /// A height that is clear, as a person has stated it, mm of Z of the program.
    clearance_mm: Option<f64>,
    /// No place behind this element.
    until: u64,
    /// The last element that may have been carried out.
    sent: u64,
    told: Told,
    /// What it was told at the best place.
    at_best: Told,
    element: u64,
    /// A place whose first line is to come, and how far it is above all that is machined.
    pending: Option<(u64, f64)>,
    best: Option<Place>,
    start: Option<Start>,
    /// What lifts the tool before the first move, to the stated height, once that is known.
    beginning: Option<Option<Vec<String>>>,
    /// Which Z the highest cut has where a place would do with a stated height, mm.
    highest_z_mm: Option<f64>,
    is_numbered: bool,
    /// Line of the source behind which nothing is safe.
    unsure: Option<u32>,
}

impl<'a> Search<'a> {
    /// Begins one; nothing behind the element `until` is taken, and nothing behind the element `sent` has been carried out.
    #[must_use]
    pub fn new(
        codes: &'static CodeTable,
        (tips, heights): (Tips<'a>, &'a Heights),
        [until, sent]: [u64; 2],
        clearance_mm: Option<f64>,
    ) -> Search<'a> {
        Search {
            codes,
            tips,
            heights,
            clearance_mm,
            until,
            sent,
            told: Told::default(),
            at_best: Told::default(),
            element: 0,
            pending: None,
            best: None,
            start: None,
            beginning: None,
            highest_z_mm: None,
            is_numbered: false,
            unsure: None,
        }
    }

    /// The next element, before its lines.
    pub fn element(&mut self, output: &Output) {
        self.element += 1;
        match output {
            Output::Piece(piece) => {
                if self.start.is_none() {
                    let (lifts_mm, stated_mm) = (self.lifts_mm(piece), self.stated_above_mm(piece));
                    self.start = Some(Start { element: self.element, lifts_mm, stated_mm });
                }
                if let Some(above_mm) = self.above_mm(piece) {
                    self.pending = Some((self.element, above_mm));
                }
            }
            Output::Element(element) => {
                let is_unknown = match &element.kind {
                    Kind::Frame(FrameWords::Statement(_)) => true,
                    Kind::Verbatim(text) => !is_plain(text, self.codes),
                    _ => false,
                };
                if is_unknown {
                    self.unsure.get_or_insert(element.origin.line);
                }
            }
        }
        self.tips.take(output);
    }

    /// How far the tool is above all that is machined at both ends of a rapid move, or at the stated height, mm; `None` where that is not safe.
    fn above_mm(&mut self, piece: &Piece) -> Option<f64> {
        let is_place = piece.rapid
            && piece.first
            && !piece.take_up
            && is_height_known(piece)
            && self.unsure.is_none()
            && self.element <= self.until
            && !self.heights.is_tilted(self.sent);
        let start = *self.tips.stands().filter(|_| is_place)?;
        let mut lowest_mm = f64::INFINITY;
        for end in [&start, &piece.nominal] {
            if !self.tips.rises_along_itself(end) {
                return None;
            }
            let above_mm = self.heights.above_mm(&self.tips.tip_mm(end), &self.tips.direction(end))?;
            lowest_mm = lowest_mm.min(above_mm);
        }
        let Some(clearance_mm) = self.clearance_mm else {
            return (lowest_mm >= CLEAR_MM).then_some(lowest_mm);
        };
        let above_mm = self.heights.above_mm(&self.tips.tip_mm(&start), &self.tips.direction(&start))?;
        let highest_z_mm = self.tips.programmed_z_mm(&start)? - above_mm;
        if lowest_mm < -SAME_MM {
            return None;
        }
        self.highest_z_mm = Some(self.highest_z_mm.map_or(highest_z_mm, |known| known.max(highest_z_mm)));
        (clearance_mm > highest_z_mm + SAME_MM).then_some(clearance_mm - highest_z_mm)
    }

    fn lifts_mm(&self, piece: &Piece) -> Option<f64> {
        let is_lift = piece.rapid && piece.words.iter().all(|axis| axis == Axis::Z) && is_height_known(piece);
        let above_mm = self.free_mm(piece).filter(|_| is_lift)?;
        (above_mm >= CLEAR_MM).then_some(above_mm)
    }

    fn stated_above_mm(&self, piece: &Piece) -> Option<f64> {
        let highest_z_mm = self.tips.programmed_z_mm(&piece.nominal)? - self.free_mm(piece)?;
        Some(self.clearance_mm? - highest_z_mm)
    }

    fn free_mm(&self, piece: &Piece) -> Option<f64> {
        let is_free = self.tips.rises_along_itself(&piece.nominal) && !self.heights.is_tilted(self.sent);
        self.heights
            .above_mm(&self.tips.tip_mm(&piece.nominal), &self.tips.direction(&piece.nominal))
            .filter(|_| is_free)
    }

    /// A line of the program, in order.
    pub fn line(&mut self, line: &Line) {
        let text = String::from_utf8_lossy(&line.text).into_owned();
        if let Some((element, above_mm)) = self.pending.filter(|(element, _)| line.element >= *element) {
            self.pending = None;
            if let Some(lines) = self.told.lines(self.is_numbered, self.clearance_mm) {
                let tool = self.told.values.get(&b'T').cloned();
                self.at_best = self.told.clone();
                let (source_line, first) = (line.source_line, text.clone());
                self.best = Some(Place { element, source_line, lines, tool, first, above_mm });
            }
        }
        if self.beginning.is_none()
            && let (Some(start), Some(clearance_mm)) = (self.start, self.clearance_mm)
            && line.element >= start.element
        {
            self.beginning = Some(self.told.beginning(self.is_numbered, clearance_mm));
        }
        self.is_numbered |= text.starts_with('N');
        if line.element <= self.sent {
            self.told.note(&text, self.codes);
        }
    }

    /// The last safe place. Only the beginning is one also where the control was told something behind a place of which nothing is known before it, an
    /// axis, a zero offset, the coolant: how it stood then nobody has said.
    #[must_use]
    pub fn finish(self) -> Found {
        let is_known = self.at_best.knows(&self.told);
        if let Some(place) = self.best.filter(|_| is_known) {
            return Found::Place(place);
        }
        let start = self.start.unwrap_or_default();
        if let Some(clearance_mm) = self.clearance_mm {
            let of_start = start.stated_mm.map(|above_mm| clearance_mm - above_mm);
            let highest_z_mm = self.highest_z_mm.or(of_start);
            if let Some(highest_z_mm) = highest_z_mm.filter(|highest_mm| clearance_mm <= highest_mm + SAME_MM) {
                return Found::TooLow(highest_z_mm);
            }
            // The way leads over the stated height, where something can be sent before the first move.
            if let (Some(above_mm), Some(lift)) = (start.stated_mm, self.beginning.flatten()) {
                return Found::Beginning(lift, above_mm);
            }
        }
        match start.lifts_mm {
            Some(above_mm) => Found::Beginning(Vec::new(), above_mm),
            None => Found::Nothing(match self.heights.unknown() {
                Some(line) => Why::HeightUnknown(line),
                None if self.heights.is_tilted(self.sent) => Why::Tilted,
                None if self.clearance_mm.is_some() => Why::BeginningCrosses,
                None => Why::NoneAbove,
            }),
        }
    }

    /// The line of the source behind which the state of the control cannot be rebuilt.
    #[must_use]
    pub fn unsure(&self) -> Option<u32> {
        self.unsure
    }
}

/// Whether a text is codes of groups and plain numbers only.
fn is_plain(text: &[u8], codes: &CodeTable) -> bool {
    String::from_utf8_lossy(text).split_ascii_whitespace().all(|word| match codes.word(word) {
        Some(entry) => entry.group > 0,
        None => {
            let (letter, value) = word.split_at_checked(1).unwrap_or((word, ""));
            b"XYZABCUVWFSTDH".contains(&letter.as_bytes().first().copied().unwrap_or(0)) && value.parse::<f64>().is_ok()
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialect;

    #[test]
    fn plain_words_can_be_told_again() {
        let codes = dialect::find("rs274").unwrap().codes();
        assert!(is_plain(b"G43 H12", codes) && is_plain(b"G64", codes));
        assert!(!is_plain(b"G92 X1", codes) && !is_plain(b"ADIS=0.5", codes));
    }
}
