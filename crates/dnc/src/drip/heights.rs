//! Highest machined point along each tool direction.
//!
//! Every point of every feed move counts as a cut: the start of a plunge and the top of an arc as well as the end points. Heights are measured in the
//! workpiece frame along the tool. They therefore hold for tools of any length and in any tilted plane.

use ncfix_base::geometry::{Axis, Vector};
use ncfix_path::path::{Output, Piece, Tips};

/// Maximum number of directions along which heights are measured. Other directions are not judged.
const MOST_DIRECTIONS: usize = 256;
/// Two directions are equal if one minus their cosine is below this: 0.03 mrad.
const SAME: f64 = 5e-10;
/// Two heights are equal within this, mm: numerical noise plus half an increment.
pub(super) const SAME_MM: f64 = 1e-3;

/// Highest machined points.
#[derive(Clone, Debug, Default)]
pub struct Heights {
    /// Directions, and the greatest height along each, mm.
    along: Vec<(Vector, f64)>,
    /// Source line of a cut whose height the program does not state.
    unknown: Option<u32>,
    /// First element that cuts with a tool that does not rise along its own axis.
    tilted: Option<u64>,
    element: u64,
}

impl Heights {
    /// Notes a rapid move: from now on heights are also measured along the tool direction at its end.
    pub fn look(&mut self, tips: &Tips<'_>, output: &Output) {
        if let Output::Piece(piece) = output
            && piece.rapid
        {
            let direction = tips.direction(&piece.nominal);
            if self.along.len() < MOST_DIRECTIONS && self.find(&direction).is_none() {
                self.along.push((direction, f64::NEG_INFINITY));
            }
        }
    }

    /// Takes the next output, before [`Tips`] take it.
    pub fn take(&mut self, tips: &Tips<'_>, output: &Output) {
        self.element += 1;
        let Output::Piece(piece) = output else { return };
        if piece.rapid {
            return;
        }
        if !is_height_known(piece) {
            self.unknown.get_or_insert(piece.origin.line);
        }
        if !tips.rises_along_itself(&piece.nominal) {
            self.tilted.get_or_insert(self.element);
        }
        tips.points(piece, &mut |point, slack_mm| {
            for (direction, highest_mm) in &mut self.along {
                *highest_mm = highest_mm.max(direction.dot(point) + slack_mm);
            }
        });
    }

    fn find(&self, direction: &Vector) -> Option<f64> {
        let along = self.along.iter().find(|(known, _)| known.dot(direction) > 1.0 - SAME);
        along.map(|(_, highest_mm)| *highest_mm)
    }

    /// Returns the distance of a point above the highest machined point along the tool, mm; `None` if it is not known.
    #[must_use]
    pub fn above_mm(&self, point: &Vector, direction: &Vector) -> Option<f64> {
        let highest_mm = self.find(direction).filter(|_| self.unknown.is_none())?;
        Some(direction.dot(point) - highest_mm)
    }

    /// True if an element up to this one cuts with a tool that does not rise along its own axis. A Z move does not retract such a tool.
    #[must_use]
    pub fn is_tilted(&self, until: u64) -> bool {
        self.tilted.is_some_and(|element| element <= until)
    }

    /// Returns the source line of a cut whose height is not known.
    #[must_use]
    pub fn unknown(&self) -> Option<u32> {
        self.unknown
    }
}

/// True if the program has stated the position of Z.
pub(super) fn is_height_known(piece: &Piece) -> bool {
    piece.known.contains(Axis::Z)
}
