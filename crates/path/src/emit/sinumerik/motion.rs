//! Pieces of moves.

use super::Sinumerik;
use crate::path::{Piece, RotaryWord};
use ncfix_base::geometry::Axis;
use ncfix_base::units::push_integer;
use ncfix_machine::snc::{MotionMode, RotaryDirection, ThreadCode};

use super::super::comment::mark_of;
use super::super::number::push_value;

/// Word of each block with machine coordinates.
const IN_MACHINE_FRAME: &str = "G153";

impl Sinumerik {
    pub(super) fn piece(&mut self, piece: &Piece) {
        self.line.begin_motion();
        if self.in_machine_frame {
            self.word(IN_MACHINE_FRAME.as_bytes());
        } else if let Some(word) = self.suppressing.filter(|_| self.is_again && piece.in_machine_frame) {
            self.word(word.as_bytes());
        }
        let motion = match (piece.rapid, &piece.arc, &piece.motion_mode) {
            (_, _, MotionMode::Thread(thread)) => thread.code.word(),
            (true, ..) => "G0",
            (false, None, _) => "G1",
            (false, Some(arc), _) if arc.through_counts.is_some() => "CIP",
            (false, Some(arc), _) if arc.clockwise => "G2",
            (false, Some(_), _) => "G3",
        };
        let is_positioning = piece.motion_mode == MotionMode::Positioning;
        if !is_positioning && (piece.starts_block || piece.first || motion != self.motion) {
            self.word(motion.as_bytes());
            self.line.kept.in_force = Some(motion).filter(|motion| *motion == self.motion);
            // G63 acts in its block only.
            if motion != ThreadCode::G63.word() {
                self.motion = motion;
            }
        }
        for axis in piece.words.iter() {
            self.word(if is_positioning { b"POS[" } else { b"" });
            let mut needs_equals = self.axis_name(axis);
            if is_positioning {
                self.line.text.push(b']');
                needs_equals = true;
            }
            // A function has its own equals sign.
            if needs_equals && !(axis.is_rotary() && piece.rotary_words[axis.dimension()].is_function()) {
                self.line.text.push(b'=');
            }
            if axis.is_rotary() {
                self.rotary_position(piece.rotary_words[axis.dimension()], piece.counts[axis.slot()]);
            } else {
                self.numbers.linear.push(&mut self.line.text, piece.counts[axis.slot()]);
            }
        }
        if let Some(through_counts) = piece.arc.and_then(|arc| arc.through_counts) {
            for (word, count) in [b"I1=", b"J1=", b"K1="].into_iter().zip(through_counts) {
                self.word(word);
                self.numbers.linear.push(&mut self.line.text, count);
            }
        } else if let Some(arc) = &piece.arc {
            let across = arc.plane.axes()[2];
            for (letter, axis) in [(b'I', Axis::X), (b'J', Axis::Y), (b'K', Axis::Z)] {
                if axis != across {
                    self.word(&[letter]);
                    self.numbers.linear.push(&mut self.line.text, arc.center_counts[axis.slot()]);
                }
            }
            if arc.extra_turns > 0 {
                self.word(b"TURN=");
                push_integer(&mut self.line.text, u64::from(arc.extra_turns));
            }
        }
        if let MotionMode::Thread(thread) = &piece.motion_mode {
            if let Some((letter, lead)) = thread.lead {
                self.word(&[letter]);
                push_value(&mut self.line.text, lead);
            }
            if let Some(change) = thread.change {
                self.word(b"F");
                push_value(&mut self.line.text, change);
                // The feed of the path has another value.
                self.feed = f64::NAN;
            }
        }
        if self.needs_feed(piece) {
            self.feed_word(piece.feed);
        }
        self.line.release();
        if let Some(mark) = mark_of(piece) {
            self.line.mark(&[b";", mark.as_bytes()]);
        }
    }

    /// Writes the position of a rotary axis after its letter.
    fn rotary_position(&mut self, word: RotaryWord, count: i64) {
        let within = count.rem_euclid(self.numbers.turn_counts);
        let (function, count): (&[u8], i64) = match word {
            RotaryWord::Plain => (b"", count),
            RotaryWord::Within(RotaryDirection::Plain) => (b"", within),
            RotaryWord::Within(RotaryDirection::Shortest | RotaryDirection::Either) => (b"=DC(", within),
            RotaryWord::Within(RotaryDirection::Positive) => (b"=ACP(", within),
            RotaryWord::Within(RotaryDirection::Negative) => (b"=ACN(", within),
            RotaryWord::Step(step) => (b"=IC(", step),
        };
        self.line.text.extend_from_slice(function);
        self.numbers.rotary.push(&mut self.line.text, count);
        if !function.is_empty() {
            self.line.text.push(b')');
        }
    }
}
