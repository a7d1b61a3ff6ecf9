//! A piece of the tool center path, with the items after it.

use super::contour_request::FeedAt;
use super::curve::{Curve, SAME_MM, distance};
use super::moving::{Item, Moving};
use ncfix_base::geometry::{AXES, AxisVector, PlaneBasis};
use ncfix_machine::snc::Kind;

/// Maximum number of waiting items of any kind.
pub(super) const MOST_WAITING: usize = 10_000;

/// Role of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// An offset contour element.
    Contour,
    /// Around an outer corner.
    Corner,
    /// To the contour or off it.
    Approach,
}

/// A piece.
#[derive(Debug)]
pub(super) struct Link {
    pub(super) role: Role,
    /// The motion it comes from.
    pub(super) moving: Box<Moving>,
    /// The contour that it must not violate: the element, or the corner as a point.
    pub(super) contour: Curve,
    /// The tool center path.
    pub(super) curve: Curve,
    /// Lengths along the curve between which it is traversed.
    pub(super) from: f64,
    pub(super) to: f64,
    /// Distance from the contour, mm.
    pub(super) clearance_mm: f64,
    pub(super) items: Vec<Item>,
    /// `true` if nothing is cut back here or before it.
    pub(super) is_sealed: bool,
    /// `true` if it begins at the tool position and leads straight to its end, independent of the start of its curve.
    pub(super) begins_anywhere: bool,
    /// `true` if bottlenecks before it have been searched.
    pub(super) is_checked: bool,
    /// `true` if the guard has checked it.
    pub(super) is_watched: bool,
}

/// Number of steps of a computed feed per mm/min or mm per turn.
const FEED_STEPS: f64 = 1e5;
/// Gap between pieces that counts as rounding of the program, mm.
const GAP_MM: f64 = 1e-3;

impl Link {
    pub(super) fn new(role: Role, moving: Box<Moving>, contour: Curve, curve: Curve, distance_mm: f64) -> Link {
        let clearance_mm = distance_mm.abs();
        let is_sealed = role == Role::Approach;
        Link {
            role,
            moving,
            contour,
            curve,
            from: 0.0,
            to: curve.length(),
            clearance_mm,
            items: Vec::new(),
            is_sealed,
            begins_anywhere: false,
            is_checked: false,
            is_watched: false,
        }
    }

    /// A piece to the contour or off it, with the heights and other axes at its end.
    pub(super) fn approach(mut moving: Moving, curve: Curve, other_axes: AxisVector) -> Link {
        moving.path.motion.target = other_axes;
        Link::new(Role::Approach, Box::new(moving), curve, curve, 0.0)
    }

    /// Emits the motion and the items after it; `position` is the tool center.
    pub(super) fn release(self, basis: PlaneBasis, position: &mut AxisVector, out: &mut Vec<Item>) {
        let part = match self.curve.part(self.from, self.to) {
            part if self.begins_anywhere => Curve::Line { start: basis.flat(position), end: part.end() },
            part => part,
        };
        let mut moving = *self.moving;
        // Heights and other axes have reached the end of the element before the corner.
        let other_axes = if self.role == Role::Corner { *position } else { moving.path.motion.target };
        if distance(basis.flat(position), part.start()) > GAP_MM {
            let line = Curve::Line { start: basis.flat(position), end: part.start() };
            let between = moving.ending(&line, basis, *position, *position);
            moving = moving.further();
            *position = between.path.motion.target;
            out.push(Item::Path(Box::new(between)));
        }
        if self.role == Role::Contour && !moving.path.motion.rapid {
            let share = feed_share(moving.wish.modal.feed_at, &self.contour, &self.curve);
            if share != 1.0 {
                moving.path.motion.feed = (moving.path.motion.feed * share * FEED_STEPS).round() / FEED_STEPS;
            }
        }
        let moved = moving.ending(&part, basis, *position, other_axes);
        push_unless_still(moved, part.length(), position, out);
        release_items(self.items, basis, position, out);
    }

    /// Leaves the piece out: only its other axes and its items are kept.
    pub(super) fn into_items(self, out: &mut Vec<Item>) {
        if self.role != Role::Corner {
            out.push(Item::Path(self.moving));
        }
        out.extend(self.items);
    }
}

/// Emits the items after a piece; motions of other axes take place at the tool center.
pub(super) fn release_items(items: Vec<Item>, basis: PlaneBasis, position: &mut AxisVector, out: &mut Vec<Item>) {
    for item in items {
        match item {
            Item::Element(_) => out.push(item),
            Item::Path(moving) => push_unless_still(*moving.carried(&basis, *position), 0.0, position, out),
        }
    }
}

/// Emits a motion; for one of zero length, only its programmed position.
fn push_unless_still(moving: Moving, length: f64, position: &mut AxisVector, out: &mut Vec<Item>) {
    let target = moving.path.motion.target;
    let is_still =
        length < SAME_MM && AXES.iter().all(|&axis| (target[axis] - moving.path.start[axis]).abs() < SAME_MM);
    if !is_still {
        *position = target;
        out.push(Item::Path(Box::new(moving)));
    } else if moving.element.starts_block {
        out.push(Item::Element(ncfix_machine::snc::Element { kind: Kind::Empty, ..moving.element }));
    }
}

/// Ratio of the tool center feed to the contour feed.
fn feed_share(at: FeedAt, contour: &Curve, curve: &Curve) -> f64 {
    let (Curve::Arc { radius, .. }, Curve::Arc { radius: beside, .. }) = (contour, curve) else { return 1.0 };
    match at {
        FeedAt::Center => 1.0,
        FeedAt::Contour => beside / radius,
        FeedAt::InnerContour(least_percent) => (beside / radius).max(f64::from(least_percent) / 100.0).min(1.0),
    }
}
