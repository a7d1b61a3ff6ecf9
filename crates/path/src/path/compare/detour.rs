//! Moves that are judged at their ends, in several pieces: each of these must lie on the straight way of its move.
//!
//! A rapid move may be corrected at its end only, so that its pieces keep no tolerance; but none of them leads anywhere else.

use ncfix_base::geometry::{Axis, AxisSet, AxisVector, ROTARY_AXES};
use ncfix_machine::snc::Origin;

use super::course::Course;
use super::difference::What;
use super::group::MoveGroup;
use super::judge::TipDeviation;

/// How far the end of a piece may be off the way besides what the machine errs there, mm: steps that settle the side of a backlash go beyond the end by the
/// lost motion and a little more, and no machine that is worth a correction loses more than this.
const BESIDE_MM: f64 = 0.2;
/// How far a rotary axis may be beyond both of its ends, rad: corrections of angles are far below one degree where the tool is not upright.
const BEYOND_RAD: f64 = 0.02;

/// The pieces of a move that are not its last.
#[derive(Debug, Default)]
pub(super) struct Detour {
    /// The one that is furthest off: by how much, how much it may be, and where.
    off: Option<(f64, f64, Origin)>,
    /// Ends of pieces.
    turned: Vec<(AxisVector, Origin)>,
}

/// Pieces of one move whose rotary axes are looked at.
const MOST_PIECES: usize = 1000;

impl Detour {
    /// A piece that is not the last of its move.
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

    /// What is wrong with the way of a move that does not come to its end, and where.
    pub(super) fn broken(&mut self) -> Option<(What, Origin)> {
        self.turned.clear();
        self.off.take().map(|(off_mm, limit_mm, origin)| (What::Detour { off_mm, limit_mm }, origin))
    }

    /// What is wrong with the pieces of a move, when its last one is known, and where; `beyond_mm` is how far beyond its end an axis may go.
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
        // Where nobody has said where an axis was, it has no way but to its end, and beyond that as far as settles the side of its backlash.
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
