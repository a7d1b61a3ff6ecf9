//! How high the material may stand: the highest place that is cut, along each direction in which the tool looks.
//!
//! A cut is every point of every move with feed: the start of a plunge and the top of an arc as much as the ends. Heights are measured in the workpiece
//! along the tool, so that they mean the same for tools of any length and in any tilted plane.

use ncfix_base::geometry::{Axis, Vector};
use ncfix_path::path::{Output, Piece, Tips};

/// Directions along which heights are measured, at most; what looks elsewhere is not judged.
const MOST_DIRECTIONS: usize = 256;
/// Directions whose cosine is nearer to one than this are the same: 0.03 mrad.
const SAME: f64 = 5e-10;
/// Heights are the same within this: the noise of the arithmetic, and half an increment, mm.
pub(super) const SAME_MM: f64 = 1e-3;

/// The highest places.
#[derive(Clone, Debug, Default)]
pub struct Heights {
    /// Directions, and the highest place along each, mm.
    along: Vec<(Vector, f64)>,
    /// Line of the source of a cut at a height that the program does not state.
    unknown: Option<u32>,
    /// The first element that cuts with a tool that does not rise along itself.
    tilted: Option<u64>,
    element: u64,
}

impl Heights {
    /// A rapid move: from now on heights are measured along the tool at its end, too.
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

    /// The next output, before [`Tips`] take it.
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

    /// How far a point lies above all that is cut, along the tool, mm; `None` where that is not known.
    #[must_use]
    pub fn above_mm(&self, point: &Vector, direction: &Vector) -> Option<f64> {
        let highest_mm = self.find(direction).filter(|_| self.unknown.is_none())?;
        Some(direction.dot(point) - highest_mm)
    }

    /// Whether something up to this element was cut with a tool that does not rise along itself: Z does not lift it out then.
    #[must_use]
    pub fn is_tilted(&self, until: u64) -> bool {
        self.tilted.is_some_and(|element| element <= until)
    }

    /// Line of the source of a cut whose height is not known.
    #[must_use]
    pub fn unknown(&self) -> Option<u32> {
        self.unknown
    }
}

/// Whether the program has stated where Z is.
pub(super) fn is_height_known(piece: &Piece) -> bool {
    piece.known.contains(Axis::Z)
}
