//! Check of moves that are evaluated at their ends only and have several pieces: each piece must lie on the straight path of its move.
//!
//! A rapid move may be corrected at its end only, so its pieces keep no tolerance, but none may lead elsewhere.

use ncfix_base::geometry::{Axis, AxisSet, AxisVector, ROTARY_AXES};
use ncfix_machine::snc::Origin;

use super::course::Course;
use super::difference::What;
use super::group::MoveGroup;
use super::judge::TipDeviation;

/// Largest distance of a piece end from the path in addition to the machine error there, mm. Steps that settle the side of a backlash exceed the end
/// by the lost motion and a little more; no machine worth a correction has more lost motion than this.
const BESIDE_MM: f64 = 0.2;
/// Largest excess of a rotary axis beyond both of its ends, rad: angle corrections are far below one degree if the tool is not upright.
const BEYOND_RAD: f64 = 0.02;

/// The pieces of a move before its last.
#[derive(Debug, Default)]
pub(super) struct Detour {
    /// The piece with the largest distance: the distance, its limit, and the origin.
    off: Option<(f64, f64, Origin)>,
    /// Ends of pieces.
    turned: Vec<(AxisVector, Origin)>,
}

/// Maximum number of pieces of one move whose rotary axes are checked.
const MOST_PIECES: usize = 1000;

impl Detour {
    /// Adds a piece that is not the last of its move.
    pub(super) fn see(&mut self, group: &MoveGroup<'_>, course: &Course<'_>, seen: &TipDeviation) {
        let piece = course.piece;
        let errors_mm = [0.0, course.to, 1.0].map(|place| group.before_mm(place));
        let most_mm = errors_mm.into_iter().fold(BESIDE_MM, |most, one| most.max(BESIDE_MM + one));
        let off_mm = seen.end.norm();
        if off_mm > most_mm && self.off.is_none_or(|(most, ..)| off_mm > most) {
            self.off = Some((off_mm, most_mm, piece.origin));
        }
        if self.turned.len() < MOST_PIECES {
            self.turned.push((piece.route.end, piece.origin));
        }
    }

    /// The difference for a move that does not reach its end, and its place.
    pub(super) fn broken(&mut self) -> Option<(What, Origin)> {
        self.turned.clear();
        self.off.take().map(|(off_mm, limit_mm, origin)| (What::Detour { off_mm, limit_mm }, origin))
    }

    /// The differences of a move when its last piece is known, and their places; `beyond_mm` is the permitted excess of an axis beyond its end.
    pub(super) fn end(
        &mut self,
        last: &Course<'_>,
        beyond_mm: impl Fn(Axis, &AxisVector) -> f64,
    ) -> Option<(What, Origin)> {
        let turned = std::mem::take(&mut self.turned);
        let (step, piece) = (last.step, last.piece);
        if let Some(found) = self.broken() {
            return Some(found);
        }
        let ends = [step.route.start, step.route.end, piece.route.end];
        // An axis at an unstated start may go only to its end, and beyond it as far as needed to settle its backlash.
        let unstated: AxisSet = AxisSet::XYZ.iter().filter(|&axis| !step.stated.contains(axis)).collect();
        for (place, origin) in turned {
            for axis in unstated.iter() {
                let off_mm = (place[axis] - piece.route.end[axis]).abs();
                let limit_mm = BESIDE_MM.max(beyond_mm(axis, &piece.route.end));
                if off_mm > limit_mm {
                    return Some((What::Detour { off_mm, limit_mm }, origin));
                }
            }
            for axis in ROTARY_AXES {
                let least = ends.iter().map(|end| end[axis]).fold(f64::INFINITY, f64::min);
                let most = ends.iter().map(|end| end[axis]).fold(f64::NEG_INFINITY, f64::max);
                let beyond_rad = (least - place[axis]).max(place[axis] - most);
                if beyond_rad > BEYOND_RAD {
                    return Some((What::Turned { axis, beyond_rad }, origin));
                }
            }
        }
        None
    }
}
