//! Finds where an interrupted job can be restarted, and the lines that the control needs before that.
//!
//! A person states a height that is clear of workpiece and clamps. It must lie above everything that is machined, by [`CLEAR_MM`] at least, and within the
//! travel of Z. The restart path goes up to this height and across at it. Then it goes down at a slow feed to the end of a retract of the program. From there
//! the program continues with its next rapid move. So no added move is rapid below that height. Nothing begins at the depth of a cut, which may never have
//! been made: the tool may have broken long before. Everything after the restart place is executed again.
//!
//! The state of the control at the place is read from the lines before it (`told`). Frames and words of unknown effect cannot be rebuilt. After them only the
//! beginning remains as a place. It is accepted only if the stated height can be reached before its first move or with that move.

use super::heights::{Heights, SAME_MM, is_height_known};
use super::rules::Grammar;
use super::told::{RestartPath, SentState};
use crate::feed::Line;
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::snc::{FrameWords, Kind};
use ncfix_path::path::{Output, Piece, Tips};

/// The stated height must lie this far above everything machined, mm. Corrections are below 0.2 mm, and the stated height of a workpiece is no more accurate.
pub const CLEAR_MM: f64 = 1.0;

/// Two tool directions are equal if they differ by less than this.
const SAME_DIRECTION: f64 = 1e-6;

/// Restart place.
#[derive(Clone, Debug, PartialEq)]
pub struct RestartPlace {
    /// First element that is sent.
    pub element: u64,
    /// Source line.
    pub source_line: u32,
    /// Lines that are sent before it.
    pub lines: Vec<String>,
    /// Tool in the spindle at this place.
    pub tool: Option<String>,
    /// First line of the program that is sent.
    pub first: String,
    /// Height of the tool above everything machined when it moves across, mm.
    pub above_mm: f64,
}

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub enum SearchOutcome {
    /// A safe place.
    Place(RestartPlace),
    /// The beginning: the lines that are sent before it, and its height above everything machined, mm.
    Beginning(Vec<String>, f64),
    /// No height was stated. Holds the highest machined Z of the program, mm, if it is known.
    NotStated(Option<f64>),
    /// The stated height is too close to the highest machined point: Z of that point in the program, mm.
    TooLow(f64),
    /// The stated height is outside the travel of Z. Holds that travel as Z of the program, mm.
    OutOfTravel([f64; 2]),
    /// No move brings the tool clear of the workpiece, with the reason.
    Nothing(Why),
}

/// Reason why no place is safe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// The tool was tilted against Z: no Z move retracts it along its own axis.
    Tilted,
    /// A cut of this source line is at a height that the program does not state.
    HeightUnknown(u32),
    /// Only the beginning remains, and its first move does not lift the tool.
    BeginningCrosses,
}

/// Result of checking the stated height at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stated {
    Above(f64),
    TooLow(f64),
    OutOfTravel([f64; 2]),
}

/// First move of a program.
#[derive(Clone, Copy, Debug, Default)]
struct Start {
    element: u64,
    /// Highest machined Z of the program, mm.
    highest_z_mm: Option<f64>,
    stated: Option<Stated>,
    /// True if it lifts the tool to the stated height or higher and moves no other axis.
    lifts: bool,
}

/// Searches for the last safe place.
pub struct RestartSearch<'a> {
    tips: Tips<'a>,
    heights: &'a Heights,
    /// Clear height as stated by a person, Z of the program, mm.
    clearance_mm: Option<f64>,
    /// Last element that may be a place.
    until: u64,
    /// Last element that may have been executed.
    sent: u64,
    told: SentState,
    /// State that the lines before the first move state, sent or not: a lift before the beginning must be right for all of them.
    stated: SentState,
    /// State of the control at the best place.
    at_best: Option<SentState>,
    element: u64,
    /// True if the axes are where a rapid move has retracted the tool to.
    is_retracted: bool,
    /// Place whose first line is still to come: its element, the height of the path to it above everything machined, mm, and its Z of the program, mm.
    pending: Option<(u64, f64, f64)>,
    best: Option<RestartPlace>,
    start: Option<Start>,
    /// Lines that lift the tool to the stated height before the first move, once they are known.
    beginning: Option<Option<Vec<String>>>,
    /// Result for the stated height at the last place that a different height would make acceptable.
    refused: Option<Stated>,
    is_numbered: bool,
    /// Source line after which no place is safe.
    unsure: Option<u32>,
}

impl<'a> RestartSearch<'a> {
    /// Begins a search. No place after the element `until` is accepted. No element after `sent` has been executed.
    #[must_use]
    pub fn new(
        grammar: Grammar,
        (tips, heights): (Tips<'a>, &'a Heights),
        [until, sent]: [u64; 2],
        clearance_mm: Option<f64>,
    ) -> RestartSearch<'a> {
        RestartSearch {
            tips,
            heights,
            clearance_mm,
            until,
            sent,
            told: SentState::new(grammar),
            stated: SentState::new(grammar),
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

    /// Takes the next element, before its lines.
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
            // A transfer has the moves of a cycle.
            Output::Cycle(_) => {}
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

    /// True if the tool is retracted after a piece: a rapid move has lifted it since the last cut and the last plunge.
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
            // First move of a program, or a change of the tool direction: to above everything machined.
            None => end_mm.is_some_and(|above_mm| above_mm >= CLEAR_MM),
        }
    }

    /// Returns the height of the tool above everything machined, along its own axis, mm. `None` if it is not known or the tool does not rise along its own
    /// axis.
    fn height_mm(&self, command: &AxisVector) -> Option<f64> {
        let above_mm = self.heights.above_mm(&self.tips.tip_mm(command), &self.tips.direction(command));
        above_mm.filter(|_| self.tips.rises_along_itself(command))
    }

    /// Checks the stated height at a place. The restart path crosses at that height.
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

    /// Returns the highest machined Z of the program, for the axes at this place, mm.
    fn highest_z_mm(&self, place: &AxisVector) -> Option<f64> {
        Some(self.tips.programmed_z_mm(place)? - self.height_mm(place)?)
    }

    /// Returns the height of the path to the beginning of a piece above everything machined, and its Z of the program, mm. `None` if that is not a restart
    /// place.
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
        // Moves across or further up, and not at a depth.
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

    /// Takes a line of the program, in order.
    pub fn line(&mut self, line: &Line) {
        let text = String::from_utf8_lossy(&line.text).into_owned();
        if let Some((element, above_mm, stands_mm)) = self.pending.filter(|(element, ..)| line.element >= *element) {
            self.pending = None;
            let way = self.clearance_mm.map(|clearance_mm| RestartPath { clearance_mm, stands_mm });
            if let Some(lines) = way.and_then(|way| self.told.lines(self.is_numbered, way)) {
                let (source_line, first, tool) = (line.source_line, text.clone(), self.told.tool.clone());
                self.at_best = Some(self.told.clone());
                self.best = Some(RestartPlace { element, source_line, lines, tool, first, above_mm });
            }
        }
        if self.beginning.is_none()
            && let (Some(start), Some(clearance_mm)) = (self.start, self.clearance_mm)
            && line.element >= start.element
        {
            self.beginning = Some(self.stated.beginning(self.is_numbered, clearance_mm));
        }
        if self.beginning.is_none() {
            self.stated.note(&text);
        }
        self.is_numbered |= text.starts_with('N');
        if line.element <= self.sent {
            self.told.note(&text);
            if self.told.is_beyond {
                self.unsure.get_or_insert(line.source_line);
            }
        }
    }

    /// Returns the last safe place. Lines after a place may set a state that is not known before it: an axis, a zero offset, the coolant. Its earlier value
    /// is then unknown, and only the beginning remains as a place.
    #[must_use]
    pub fn finish(self) -> SearchOutcome {
        let start = self.start.unwrap_or_default();
        if self.clearance_mm.is_none() {
            return SearchOutcome::NotStated(start.highest_z_mm);
        }
        let is_known = self.at_best.is_some_and(|at_best| at_best.knows(&self.told));
        if let Some(place) = self.best.filter(|_| is_known) {
            return SearchOutcome::Place(place);
        }
        match self.refused.or(start.stated) {
            Some(Stated::TooLow(highest_z_mm)) => return SearchOutcome::TooLow(highest_z_mm),
            Some(Stated::OutOfTravel(travel_mm)) => return SearchOutcome::OutOfTravel(travel_mm),
            _ => {}
        }
        // The restart path crosses at the stated height if lines can be sent before the first move, or if that move itself lifts the tool.
        match (start.stated, self.beginning.flatten()) {
            (Some(Stated::Above(above_mm)), Some(lift)) => SearchOutcome::Beginning(lift, above_mm),
            (Some(Stated::Above(above_mm)), None) if start.lifts => SearchOutcome::Beginning(Vec::new(), above_mm),
            _ => SearchOutcome::Nothing(match self.heights.unknown() {
                Some(line) => Why::HeightUnknown(line),
                None if self.heights.is_tilted(self.sent) => Why::Tilted,
                None => Why::BeginningCrosses,
            }),
        }
    }

    /// Returns the source line after which the state of the control cannot be rebuilt.
    #[must_use]
    pub fn unsure(&self) -> Option<u32> {
        self.unsure
    }
}
