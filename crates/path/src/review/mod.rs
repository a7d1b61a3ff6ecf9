//! What changed between a program and its corrected one: rows, and what they add up to.
//!
//! A row is a piece of the corrected program beside the place of the original that it belongs to ([`crate::path::Follow`]): both programs are executed, so
//! that expressions, loops, frames and modal words are values. What a row shows of the text comes from [`words`]. Programs that do not run here are
//! compared as they are written ([`text`]).

mod pairs;
mod summary;
pub mod text;
mod trace;
pub mod words;

pub use pairs::pairs;
pub use summary::{AxisFigures, ReviewPlace, Summary, UncorrectedMoves};
pub use trace::Trace;

use crate::path::Follow;
use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis};

/// What is smaller is arithmetic, mm and rad: a thousandth of the finest increment.
const NOTHING: f64 = 1e-8;

/// A piece of the corrected program beside the original. Small, since there may be millions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Number of the file of the original.
    pub file: u16,
    /// Line of the original, from 1.
    pub line: u32,
    /// Line of the corrected program, from 1.
    pub corrected_line: u32,
    /// What was added to the word of each axis, by slot, mm and rad.
    pub added: [f32; AXIS_COUNT],
    /// How far the tip of the original is from its nominal place, on the error model, mm, where the piece is left as it was.
    pub error_mm: f32,
    /// Bits of [`Row::RAPID`] and the others.
    flags: u8,
}

impl Row {
    /// Rapid.
    const RAPID: u8 = 1;
    /// First piece of its move.
    const FIRST: u8 = 2;
    /// On the spot.
    const SPOT: u8 = 4;
    /// The program has not stated where the axes are.
    const UNSTATED: u8 = 8;
    /// Its feed is another one.
    const FEED: u8 = 16;

    /// A row from a piece.
    #[must_use]
    pub fn new(follow: &Follow<'_>) -> Row {
        let added = AXES.map(|axis| {
            let added = follow.written[axis] - follow.nominal[axis];
            if added.abs() < NOTHING { 0.0 } else { added as f32 }
        });
        let flags = [
            (Row::RAPID, follow.rapid),
            (Row::FIRST, follow.is_first),
            (Row::SPOT, follow.on_the_spot),
            (Row::UNSTATED, !follow.is_stated),
            (Row::FEED, follow.feed_share.is_some_and(|share| (share - 1.0).abs() > 1e-6)),
        ];
        Row {
            file: follow.original.file.0,
            line: follow.original.line,
            corrected_line: follow.corrected.line,
            added,
            error_mm: follow.error_mm as f32,
            flags: flags.into_iter().filter(|(_, is_set)| *is_set).fold(0, |all, (flag, _)| all | flag),
        }
    }

    /// All that is told of the row beside numbers: 1 rapid, 2 first piece of its move, 4 on the spot, 8 before the axes were stated, 16 with another feed.
    #[must_use]
    pub fn flags(&self) -> u8 {
        self.flags
    }

    /// Rapid or with feed.
    #[must_use]
    pub fn is_rapid(&self) -> bool {
        self.flags & Row::RAPID != 0
    }

    /// The first piece of its move.
    #[must_use]
    pub fn is_first(&self) -> bool {
        self.flags & Row::FIRST != 0
    }

    /// A step on the spot.
    #[must_use]
    pub fn is_on_the_spot(&self) -> bool {
        self.flags & Row::SPOT != 0
    }

    /// Whether the program has stated where all axes are that it moves.
    #[must_use]
    pub fn is_stated(&self) -> bool {
        self.flags & Row::UNSTATED == 0
    }

    /// Whether its feed is another one than that of the original.
    #[must_use]
    pub fn has_other_feed(&self) -> bool {
        self.flags & Row::FEED != 0
    }

    /// What was added to an axis, mm or rad.
    #[must_use]
    pub fn added(&self, axis: Axis) -> f64 {
        without_noise(self.added[axis.slot()])
    }

    /// The largest of what was added to some axes, in µm and µrad: one number to sort by.
    #[must_use]
    pub fn largest(&self, axes: &[Axis]) -> f64 {
        axes.iter().map(|&axis| 1e3 * size(axis, self.added(axis))).fold(0.0, f64::max)
    }
}

/// A value as it was stored, mm or rad: to a hundredth of a nanometre. Behind that there is noise, and a limit that is just kept shall be kept.
fn without_noise(value: f32) -> f64 {
    const PARTS: f64 = 1e8;
    (f64::from(value) * PARTS).round() / PARTS
}

/// A value of an axis as a size that can be compared: mm, and what an angle makes at an arm of 1000 mm.
fn size(axis: Axis, value: f64) -> f64 {
    const ARM_MM: f64 = 1000.0;
    value.abs() * if axis.is_rotary() { ARM_MM } else { 1.0 }
}

/// The rows of one move of the original.
pub fn moves(rows: &[Row]) -> impl Iterator<Item = &[Row]> {
    rows.chunk_by(|_, next| !next.is_first())
}
