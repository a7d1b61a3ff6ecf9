//! Where a job that was broken off can be taken up again, and what the control must be told before.
//!
//! A person states a height that is clear of workpiece and clamps. It must lie above everything that is machined, by [`CLEAR_MM`] at least, and within
//! the travel of Z. The way leads up to it and across at it, and down with a slow feed to where a retract of the program had ended: there the program
//! goes on with the rapid move that follows. So nothing that is added moves rapidly below that height, and nothing begins at the depth of a cut, which may
//! never have been made: the tool may have broken long before. What was carried out behind the place is carried out again.
//!
//! What the control must know at the place is read from the lines before (`told`). Frames and words of unknown effect cannot be rebuilt; behind
//! them only the beginning is left, and that only where the stated height can be reached before its first move, or is, with that move.

use super::heights::{Heights, SAME_MM, is_height_known};
use super::rules::Grammar;
use super::told::{RestartPath, SentState};
use crate::feed::Line;
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::snc::{FrameWords, Kind};
use ncfix_path::path::{Output, Piece, Tips};

/// The stated height lies so far above all that is machined, mm: corrections are below 0.2 mm, and what is told of the height of a workpiece is no better.
pub const CLEAR_MM: f64 = 1.0;

/// Directions of the tool that differ by less are the same.
const SAME_DIRECTION: f64 = 1e-6;

/// A place to begin again.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The first element that is sent.
    pub element: u64,
    /// Line of the source.
    pub source_line: u32,
    /// What is sent before it.
    pub lines: Vec<String>,
    /// The tool that is in the spindle there.
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
    /// The beginning, which is reached so many mm above all that is machined; what is sent before it.
    Beginning(Vec<String>, f64),
    /// No height was stated. Up to which Z of the program it machines, mm, where that is known.
    NotStated(Option<f64>),
    /// The stated height is not so far above all that is machined as it must be: that ends at this Z of the program, mm.
    TooLow(f64),
    /// The stated height is outside of the travel of Z, which is this, mm of Z of the program.
    OutOfTravel([f64; 2]),
    /// Nothing brings the tool clear of the workpiece: why.
    Nothing(Why),
}

/// Why no place is safe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// The tool stood tilted against Z: no move of Z lifts it along itself.
    Tilted,
    /// A cut of this line of the source is at a height that the program does not state.
    HeightUnknown(u32),
    /// Only the beginning is left, and its first move does not lift the tool.
    BeginningCrosses,
}

/// A height that was stated, held against a place.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stated {
    Above(f64),
    TooLow(f64),
    OutOfTravel([f64; 2]),
}

/// The first move of a program.
#[derive(Clone, Copy, Debug, Default)]
struct Start {
    element: u64,
    /// Z of the program up to which is machined, mm.
    highest_z_mm: Option<f64>,
    stated: Option<Stated>,
    /// Whether it lifts the tool to the stated height, or further, and moves nothing else.
    lifts: bool,
}

/// Looks for the last safe place.
pub struct Search<'a> {
    tips: Tips<'a>,
    heights: &'a Heights,
    /// A height that is clear, as a person has stated it, mm of Z of the program.
    clearance_mm: Option<f64>,
    /// No place behind this element.
    until: u64,
    /// The last element that may have been carried out.
    sent: u64,
    told: SentState,
    /// What it was told at the best place.
    at_best: Option<SentState>,
    element: u64,
    /// Whether the axes stand where a rapid move has lifted the tool to.
    is_retracted: bool,
    /// A place whose first line is to come, how far the way to it is above all that is machined, and at which Z of the program it lies.
    pending: Option<(u64, f64, f64)>,
    best: Option<Place>,
    start: Option<Start>,
    /// What lifts the tool before the first move, to the stated height, once that is known.
    beginning: Option<Option<Vec<String>>>,
    /// What was found of the stated height at the last place that would do with another one.
    refused: Option<Stated>,
    is_numbered: bool,
    /// Line of the source behind which nothing is safe.
    unsure: Option<u32>,
}

impl<'a> Search<'a> {
    /// Begins one; nothing behind the element `until` is taken, and nothing behind the element `sent` has been carried out.
    #[must_use]
    pub fn new(
        grammar: Grammar,
        (tips, heights): (Tips<'a>, &'a Heights),
        [until, sent]: [u64; 2],
        clearance_mm: Option<f64>,
    ) -> Search<'a> {
        Search {
            tips,
            heights,
            clearance_mm,
            until,
            sent,
            told: SentState::new(grammar),
            at_best: None,
            element: 0,
            is_retracted: false,
            pending: None,
            best: None,
            start: None,
            beginning: None,
            refused: None,
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
                    self.start = Some(self.first_move(piece));
                }
                if let Some((above_mm, stands_mm)) = self.place(piece) {
                    self.pending = Some((self.element, above_mm, stands_mm));
                }
                self.is_retracted = self.retracts(piece);
            }
            Output::Element(element) => {
                if let Kind::Frame(FrameWords::Statement(_)) = &element.kind {
                    self.unsure.get_or_insert(element.origin.line);
                }
            }
        }
        self.tips.take(output);
        if self.tips.stands().is_none() {
            self.is_retracted = false;
        }
    }

    /// Whether the tool stands retracted behind a piece: a rapid move has lifted it since the last cut and the last plunge.
    fn retracts(&self, piece: &Piece) -> bool {
        if !piece.rapid {
            return false;
        }
        let end_mm = self.height_mm(&piece.nominal);
        let looks_alike = |start: &&AxisVector| {
            let [from, to] = [*start, &piece.nominal].map(|command| self.tips.direction(command));
            (from - to).norm() < SAME_DIRECTION
        };
        let start = self.tips.stands().filter(looks_alike);
        match start.and_then(|start| self.height_mm(start)).zip(end_mm) {
            Some((from_mm, to_mm)) if to_mm > from_mm + SAME_MM => true,
            Some((from_mm, to_mm)) => self.is_retracted && to_mm > from_mm - SAME_MM,
            // The first move of a program, or a turn: to above all that is machined.
            None => end_mm.is_some_and(|above_mm| above_mm >= CLEAR_MM),
        }
    }

    /// How far the tool is above all that is machined, along itself, mm; `None` where that is not known, or it does not rise along itself.
    fn height_mm(&self, command: &AxisVector) -> Option<f64> {
        let above_mm = self.heights.above_mm(&self.tips.tip_mm(command), &self.tips.direction(command));
        above_mm.filter(|_| self.tips.rises_along_itself(command))
    }

    /// Holds the stated height against a place. The way across is at that height.
    fn stated(&self, place: &AxisVector) -> Option<Stated> {
        let (clearance_mm, highest_z_mm) = (self.clearance_mm?, self.highest_z_mm(place)?);
        let travel_mm = self.tips.programmed_travel_mm(place)?;
        Some(if clearance_mm < highest_z_mm + CLEAR_MM - SAME_MM {
            Stated::TooLow(highest_z_mm)
        } else if clearance_mm < travel_mm[0] || clearance_mm > travel_mm[1] {
            Stated::OutOfTravel(travel_mm)
        } else {
            Stated::Above(clearance_mm - highest_z_mm)
        })
    }

    /// Up to which Z of the program is machined, with the axes there, mm.
    fn highest_z_mm(&self, place: &AxisVector) -> Option<f64> {
        Some(self.tips.programmed_z_mm(place)? - self.height_mm(place)?)
    }

    /// How far the way to the beginning of a piece is above all that is machined, and its Z of the program, mm; `None` where that is no place.
    fn place(&mut self, piece: &Piece) -> Option<(f64, f64)> {
        let is_place = piece.rapid
            && piece.first
            && !piece.take_up
            && is_height_known(piece)
            && self.is_retracted
            && self.unsure.is_none()
            && self.element <= self.until
            && !self.heights.is_tilted(self.sent);
        let start = *self.tips.stands().filter(|_| is_place)?;
        let [from_mm, to_mm] = [self.height_mm(&start)?, self.height_mm(&piece.nominal)?];
        // Across, or further up, and at no depth.
        if from_mm < -SAME_MM || to_mm < from_mm - SAME_MM {
            return None;
        }
        match self.stated(&start)? {
            Stated::Above(above_mm) => Some((above_mm, self.tips.programmed_z_mm(&start)?)),
            other => {
                self.refused = Some(other);
                None
            }
        }
    }

    fn first_move(&self, piece: &Piece) -> Start {
        let is_known = !self.heights.is_tilted(self.sent);
        let stated = self.stated(&piece.nominal).filter(|_| is_known);
        let reaches =
            self.tips.programmed_z_mm(&piece.nominal).zip(self.clearance_mm).is_some_and(|(z, least)| z >= least);
        let is_lift = piece.rapid && piece.words.iter().all(|axis| axis == Axis::Z) && is_height_known(piece);
        let highest_z_mm = self.highest_z_mm(&piece.nominal).filter(|_| is_known);
        Start { element: self.element, highest_z_mm, stated, lifts: is_lift && reaches }
    }

    /// A line of the program, in order.
    pub fn line(&mut self, line: &Line) {
        let text = String::from_utf8_lossy(&line.text).into_owned();
        if let Some((element, above_mm, stands_mm)) = self.pending.filter(|(element, ..)| line.element >= *element) {
            self.pending = None;
            let way = self.clearance_mm.map(|clearance_mm| RestartPath { clearance_mm, stands_mm });
            if let Some(lines) = way.and_then(|way| self.told.lines(self.is_numbered, way)) {
                let (source_line, first, tool) = (line.source_line, text.clone(), self.told.tool.clone());
                self.at_best = Some(self.told.clone());
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
            self.told.note(&text);
            if self.told.is_beyond {
                self.unsure.get_or_insert(line.source_line);
            }
        }
    }

    /// The last safe place. Only the beginning is one also where the control was told something behind a place of which nothing is known before it, an
    /// axis, a zero offset, the coolant: how it stood then nobody has said.
    #[must_use]
    pub fn finish(self) -> Found {
        let start = self.start.unwrap_or_default();
        if self.clearance_mm.is_none() {
            return Found::NotStated(start.highest_z_mm);
        }
        let is_known = self.at_best.is_some_and(|at_best| at_best.knows(&self.told));
        if let Some(place) = self.best.filter(|_| is_known) {
            return Found::Place(place);
        }
        match self.refused.or(start.stated) {
            Some(Stated::TooLow(highest_z_mm)) => return Found::TooLow(highest_z_mm),
            Some(Stated::OutOfTravel(travel_mm)) => return Found::OutOfTravel(travel_mm),
            _ => {}
        }
        // The way leads over the stated height, where something can be sent before the first move; or that move is the way up itself.
        match (start.stated, self.beginning.flatten()) {
            (Some(Stated::Above(above_mm)), Some(lift)) => Found::Beginning(lift, above_mm),
            (Some(Stated::Above(above_mm)), None) if start.lifts => Found::Beginning(Vec::new(), above_mm),
            _ => Found::Nothing(match self.heights.unknown() {
                Some(line) => Why::HeightUnknown(line),
                None if self.heights.is_tilted(self.sent) => Why::Tilted,
                None => Why::BeginningCrosses,
            }),
        }
    }

    /// The line of the source behind which the state of the control cannot be rebuilt.
    #[must_use]
    pub fn unsure(&self) -> Option<u32> {
        self.unsure
    }
}
