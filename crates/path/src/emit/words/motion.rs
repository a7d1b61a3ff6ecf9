//! Pieces of moves.

use super::super::comment::{in_parentheses, mark_of};
use super::{Language, Words};
use crate::path::{Piece, PieceArc};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXES, Axis};
use ncfix_base::units::push_integer;
use ncfix_machine::snc::{MotionMode, Origin, Thread, ThreadCode};

/// Machine coordinates, for this block only.
const IN_MACHINE_FRAME: &str = "G53";
const CENTERS: [(u8, Axis); 3] = [(b'I', Axis::X), (b'J', Axis::Y), (b'K', Axis::Z)];

impl Words {
    pub(super) fn piece(&mut self, piece: &Piece) -> Result<(), Diagnostic> {
        let mut piece = piece;
        let retraction;
        if let Some(again) = self.behind_tapping(piece) {
            retraction = again;
            piece = &retraction;
        }
        self.place = Some(piece.counts);
        (self.cycle, self.is_drilling) = (None, false);
        let motion = self.motion_word(piece)?;
        let is_circle = piece.arc.as_ref().is_some_and(|arc| is_full(arc, piece));
        if piece.words.is_empty() && piece.arc.is_none() {
            // Nothing moves: an axis word without change is not needed.
            if piece.feed_named {
                self.feed_word(piece.feed);
            }
            return Ok(());
        }
        self.line.begin_motion();
        if piece.in_machine_frame {
            self.line.word(IN_MACHINE_FRAME.as_bytes());
        }
        if piece.starts_block || piece.first || motion != self.motion {
            self.line.kept.in_force = Some(motion).filter(|motion| *motion == self.motion);
            self.line.word(motion.as_bytes());
            self.motion = motion;
        }
        self.positions(piece, is_circle)?;
        if let Some(arc) = &piece.arc {
            self.center(arc, is_circle);
        }
        match &piece.motion_mode {
            MotionMode::Thread(Thread { lead: Some((_, lead)), .. }) => {
                let letter = if self.flavour.language == Language::Rs274 { b"K" } else { b"F" };
                self.line.word(letter);
                // The finest resolution that controls read.
                self.value((lead / self.unit_mm * 1e6).round() / 1e6);
                // The feed of the path has another value.
                self.feed = f64::NAN;
            }
            _ => self.feed_of(piece),
        }
        self.line.release();
        if let Some(mark) = mark_of(piece) {
            if self.flavour.is_plain {
                self.line.mark(&[&in_parentheses(mark.as_bytes())]);
            } else {
                self.line.mark(&[b";", mark.as_bytes()]);
            }
        }
        Ok(())
    }

    /// The G word of the motion; an error if the language has none.
    fn motion_word(&self, piece: &Piece) -> Result<&'static str, Diagnostic> {
        let Piece { origin, arc, rapid, .. } = piece;
        let is_rapid_only = self.flavour.language == Language::Fanuc;
        if piece.in_machine_frame && (arc.is_some() || is_rapid_only && !rapid) {
            return Err(self.no_words(
                origin,
                "such a move in machine coordinates",
                "move to machine coordinates at rapid",
            ));
        }
        if arc.as_ref().is_some_and(|arc| arc.extra_turns > 0) && self.flavour.language != Language::Rs274 {
            return Err(self.no_words(origin, "an arc of several turns", "program one turn per block"));
        }
        if arc.as_ref().is_some_and(|arc| arc.through_counts.is_some()) {
            return Err(self.no_words(origin, "an arc through a point in space", "program chords"));
        }
        match (&piece.motion_mode, arc) {
            (MotionMode::Thread(thread), _) => self.thread_word(thread, origin),
            (MotionMode::Probe(word), _) => Ok(*word),
            (MotionMode::Positioning, _) => Err(self.no_words(origin, "an axis that moves on its own", "use G0")),
            (MotionMode::Reference, _) => Ok("G0"),
            (MotionMode::Path, _) if *rapid => Ok("G0"),
            (MotionMode::Path, None) => Ok("G1"),
            (MotionMode::Path, Some(arc)) if arc.clockwise => Ok("G2"),
            (MotionMode::Path, Some(_)) => Ok("G3"),
        }
    }

    /// Handles the retraction of rigid tapping. G33.1 of RS274/NGC retracts by itself; the remaining piece leads from the start of the tapping to the
    /// target position.
    fn behind_tapping(&mut self, piece: &Piece) -> Option<Piece> {
        let MotionMode::Thread(Thread { code, .. }) = piece.motion_mode else { return None };
        if self.flavour.language != Language::Rs274 {
            return None;
        }
        if code == ThreadCode::G331 {
            self.tapped_from = self.place;
        }
        if code != ThreadCode::G332 {
            return None;
        }
        let from = self.tapped_from.take();
        let is_off = |axis: &Axis| from.is_some_and(|from| from[axis.slot()] != piece.counts[axis.slot()]);
        let words = AXES.into_iter().filter(is_off).collect();
        Some(Piece { words, rapid: true, motion_mode: MotionMode::Path, first: false, feed_named: false, ..*piece })
    }

    fn thread_word(&self, thread: &Thread, origin: &Origin) -> Result<&'static str, Diagnostic> {
        match (thread.code, self.flavour.language) {
            (ThreadCode::G33, Language::Fanuc | Language::Rs274) if thread.change.is_none() => Ok("G33"),
            (ThreadCode::G331, Language::Rs274) => Ok("G33.1"),
            // The mode G63, which is passed on, makes it a tapping move.
            (ThreadCode::G63, Language::Fanuc) => Ok("G1"),
            (code, _) => {
                let what = format!("a thread like {}", code.word());
                Err(self.no_words(origin, &what, "cut this thread with the uncorrected program"))
            }
        }
    }

    /// Writes the words of the axes. A full circle has only those outside its plane that may have to be stated.
    fn positions(&mut self, piece: &Piece, is_circle: bool) -> Result<(), Diagnostic> {
        let is_grundig = self.flavour.language == Language::Grundig;
        let mut words = piece.words;
        if let Some(arc) = piece.arc.as_ref().filter(|_| is_grundig) {
            for axis in arc.plane.axes().into_iter().take(2) {
                // An arc without end point is a full circle; with an end point it is not.
                if is_circle {
                    words.remove(axis);
                } else {
                    words.insert(axis);
                }
            }
        }
        for axis in words.iter() {
            let count = piece.counts[axis.slot()];
            if !axis.is_rotary() {
                self.line.word(&[axis.letter()]);
                self.numbers.linear.push(&mut self.line.text, count);
                continue;
            }
            let word = piece.rotary_words[axis.dimension()];
            let plain = self.numbers.plain_count(word, count);
            // RS274/NGC gives a special meaning to the sign of a position within the turn.
            let plain = plain.filter(|&plain| self.flavour.language != Language::Rs274 || plain == count);
            let Some(count) = plain else {
                let what = format!("the direction in which {axis} turns");
                return Err(self.no_words(&piece.origin, &what, "turn by less than half a turn in each block"));
            };
            self.line.word(&[axis.letter()]);
            self.numbers.rotary.push(&mut self.line.text, count);
        }
        Ok(())
    }

    fn center(&mut self, arc: &PieceArc, is_circle: bool) {
        let across = arc.plane.axes()[2];
        for (letter, axis) in CENTERS.into_iter().filter(|&(_, axis)| axis != across) {
            self.line.word(&[letter]);
            let mut count = arc.center_counts[axis.slot()];
            if self.has_centers_reversed {
                count = -count;
            } else if self.flavour.language == Language::Grundig {
                count += arc.start_counts[axis.slot()];
            }
            self.numbers.linear.push(&mut self.line.text, count);
        }
        if is_circle && self.flavour.language == Language::Grundig {
            self.line.word(b"B5=360");
        }
        if arc.extra_turns > 0 {
            self.line.word(b"P");
            push_integer(&mut self.line.text, u64::from(arc.extra_turns) + 1);
        }
    }

    fn feed_of(&mut self, piece: &Piece) {
        if self.needs_feed(piece) {
            self.feed_word(piece.feed);
        }
    }
}

/// `true` if an arc ends at its start.
fn is_full(arc: &PieceArc, piece: &Piece) -> bool {
    arc.plane.axes().into_iter().take(2).all(|axis| piece.counts[axis.slot()] == arc.start_counts[axis.slot()])
}
