//! The changes between a program and its corrected version: rows and their summary.
//!
//! A row pairs a piece of the corrected program with its place in the original ([`crate::path::Follow`]). Both programs are executed, so that
//! expressions, loops, frames and modal words have values. The text of a row comes from [`words`]. Programs that cannot be executed here are compared
//! as text ([`text`]).

mod pairs;
mod summary;
pub mod text;
mod trace;
pub mod words;

pub use pairs::pairs;
pub use summary::{AxisFigures, ReviewPlace, Summary, UncorrectedMoves};
pub use trace::ReviewTrace;

use crate::path::Follow;
use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis};

/// Limit below which a difference is rounding noise, mm and rad: a thousandth of the finest increment.
const NOTHING: f64 = 1e-8;

/// A piece of the corrected program with its place in the original. Kept small, as there may be millions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReviewRow {
    /// Number of the file of the original.
    pub file: u16,
    /// Line of the original, from 1.
    pub line: u32,
    /// Line of the corrected program, from 1.
    pub corrected_line: u32,
    /// Correction added to the word of each axis, by slot, mm and rad.
    pub added: [f32; AXIS_COUNT],
    /// Distance of the original tip from its nominal place under the error model, mm, if the piece is unchanged.
    pub error_mm: f32,
    /// Flags: bits of [`ReviewRow::RAPID`] and the others.
    flags: u8,
}

impl ReviewRow {
    /// Rapid piece.
    const RAPID: u8 = 1;
    /// First piece of its move.
    const FIRST: u8 = 2;
    /// Step on the spot.
    const SPOT: u8 = 4;
    /// The program has not stated the position of an axis that it moves.
    const UNSTATED: u8 = 8;
    /// The feed differs from that of the original.
    const FEED: u8 = 16;

    /// Creates a row from a piece.
    #[must_use]
    pub fn new(follow: &Follow<'_>) -> ReviewRow {
        let added = AXES.map(|axis| {
            let added = follow.written[axis] - follow.nominal[axis];
            if added.abs() < NOTHING { 0.0 } else { added as f32 }
        });
        let flags = [
            (ReviewRow::RAPID, follow.rapid),
            (ReviewRow::FIRST, follow.is_first),
            (ReviewRow::SPOT, follow.on_the_spot),
            (ReviewRow::UNSTATED, !follow.is_stated),
            (ReviewRow::FEED, follow.feed_share.is_some_and(|share| (share - 1.0).abs() > 1e-6)),
        ];
        ReviewRow {
            file: follow.original.file.0,
            line: follow.original.line,
            corrected_line: follow.corrected.line,
            added,
            error_mm: follow.error_mm as f32,
            flags: flags.into_iter().filter(|(_, is_set)| *is_set).fold(0, |all, (flag, _)| all | flag),
        }
    }

    /// Flags of the row: 1 rapid, 2 first piece of its move, 4 on the spot, 8 before the axes were stated, 16 with another feed.
    #[must_use]
    pub fn flags(&self) -> u8 {
        self.flags
    }

    /// `true` for a rapid piece, `false` for a piece with feed.
    #[must_use]
    pub fn is_rapid(&self) -> bool {
        self.flags & ReviewRow::RAPID != 0
    }

    /// `true` for the first piece of its move.
    #[must_use]
    pub fn is_first(&self) -> bool {
        self.flags & ReviewRow::FIRST != 0
    }

    /// `true` for a step on the spot.
    #[must_use]
    pub fn is_on_the_spot(&self) -> bool {
        self.flags & ReviewRow::SPOT != 0
    }

    /// `true` if the program has stated the position of all axes that it moves.
    #[must_use]
    pub fn is_stated(&self) -> bool {
        self.flags & ReviewRow::UNSTATED == 0
    }

    /// `true` if the feed differs from that of the original.
    #[must_use]
    pub fn has_other_feed(&self) -> bool {
        self.flags & ReviewRow::FEED != 0
    }

    /// Correction added to an axis, mm or rad.
    #[must_use]
    pub fn added(&self, axis: Axis) -> f64 {
        without_noise(self.added[axis.slot()])
    }

    /// The largest correction added to any of these axes, in µm or µrad, as a sort key.
    #[must_use]
    pub fn largest(&self, axes: &[Axis]) -> f64 {
        axes.iter().map(|&axis| 1e3 * size(axis, self.added(axis))).fold(0.0, f64::max)
    }
}

/// The stored value, mm or rad, rounded to a hundredth of a nanometer. Digits beyond are noise, and a limit that is just met must hold.
fn without_noise(value: f32) -> f64 {
    const PARTS: f64 = 1e8;
    (f64::from(value) * PARTS).round() / PARTS
}

/// Comparable magnitude of a value of an axis: mm; an angle counts as its displacement at an arm of 1000 mm.
fn size(axis: Axis, value: f64) -> f64 {
    const ARM_MM: f64 = 1000.0;
    value.abs() * if axis.is_rotary() { ARM_MM } else { 1.0 }
}

/// The rows of each move of the original.
pub fn moves(rows: &[ReviewRow]) -> impl Iterator<Item = &[ReviewRow]> {
    rows.chunk_by(|_, next| !next.is_first())
}
