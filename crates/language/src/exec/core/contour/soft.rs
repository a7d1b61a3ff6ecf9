//! Soft approach and retraction, G147 to G348: tangentially onto the contour by a line, a quadrant or a semicircle.
//!
//! Points are named as in the control: P0 start, P1 above the curve at the height of the start, P2 at the clearance, P3 start of the curve, P4 the
//! contour. Retraction uses them in reverse order.

use super::compensation::Active;
use super::contour_request::{Clearance, Soft, SoftForm, SoftSide};
use super::curve::{Curve, Flat, add, dot, left, scaled, sub};
use super::link::Link;
use super::moving::Moving;
use crate::exec::core::fault::Fault;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisVector, PlaneBasis};

impl Active {
    /// Pieces from the position to the start of the first element.
    pub(super) fn soft_approach(&mut self, moving: &Moving, soft: &Soft, link: &Link, findings: &mut Vec<Fault>) {
        let basis = self.basis;
        let start = basis.flat(&self.position);
        let (end, tangent) = (link.curve.start(), link.contour.first_tangent());
        let beside = link.moving.wish.distance_mm;
        let Some(side) = side_of(soft, beside, sub(start, end), tangent) else {
            findings.push(no_side(moving));
            return;
        };
        let curve = curve_onto(soft, end, tangent, side, beside);
        let target = moving.path.motion.target;
        let above = self.position;
        let clear = at_clearance(basis, &target, &above, soft.clearance);
        let place = curve.start();
        let fast = |mut moving: Moving| {
            moving.path.motion.rapid = soft.rapid_before;
            moving.path.motion.feed = soft.feed_before;
            // The F of the block belongs to the following pieces.
            moving.path.motion.feed_named = false;
            moving
        };
        let slow = |mut moving: Moving| {
            moving.path.motion.rapid = false;
            if soft.infeed > 0.0 {
                moving.path.motion.feed = soft.infeed;
            }
            moving
        };
        let here = Curve::Line { start: place, end: place };
        let mut last = moving.further();
        last.path.motion.rapid = false;
        // Other axes arrive with the first piece, the height does not.
        let level = with_height(basis, &target, &above);
        let feeds = [slow(moving.further()).path.motion.feed, last.path.motion.feed];
        let needs_before = !soft.rapid_before && soft.feed_before <= 0.0;
        if needs_before || feeds.iter().any(|feed| *feed <= 0.0) {
            findings.push(no_feed(moving));
        }
        self.chain.push(Link::approach(fast(moving.clone()), Curve::Line { start, end: place }, level));
        self.chain.push(Link::approach(fast(moving.further()), here, clear));
        if soft.in_plane {
            self.chain.push(Link::approach(slow(moving.further()), here, target));
            self.chain.push(Link::approach(last, curve, target));
        } else {
            self.chain.push(Link::approach(slow(moving.further()), curve, target));
        }
    }

    /// Pieces from the end of the last element to above the end of the curve; the caller adds the rest of the path.
    pub(super) fn soft_retract(&mut self, moving: &Moving, soft: &Soft, findings: &mut Vec<Fault>) {
        let basis = self.basis;
        let start = add(self.point, scaled(left(self.tangent), self.distance));
        let end = basis.flat(&moving.path.motion.target);
        let reversed = scaled(self.tangent, -1.0);
        // Left of the motion is right of the reversed one.
        let Some(side) = side_of(soft, self.distance, sub(end, start), self.tangent) else {
            findings.push(no_side(moving));
            return;
        };
        let curve = reverse(&curve_onto(soft, start, reversed, -side, self.distance));
        let low = self.last.path.motion.target;
        let high = moving.path.motion.target;
        let clear = at_clearance(basis, &low, &high, soft.clearance);
        let place = curve.end();
        let here = Curve::Line { start: place, end: place };
        let mut cutting = moving.clone();
        cutting.path.motion.rapid = false;
        cutting.path.motion.feed = soft.feed_before;
        cutting.path.motion.feed_named = false;
        if soft.feed_before <= 0.0 {
            findings.push(no_feed(moving));
        }
        let mut slow = moving.further();
        slow.path.motion.rapid = false;
        slow.path.motion.feed = if soft.infeed > 0.0 { soft.infeed } else { soft.feed_before };
        if soft.in_plane {
            self.chain.push(Link::approach(cutting, curve, low));
            self.chain.push(Link::approach(slow, here, clear));
        } else {
            cutting.path.motion.feed = slow.path.motion.feed;
            self.chain.push(Link::approach(cutting, curve, clear));
        }
        let above = with_height(basis, &clear, &high);
        self.chain.push(Link::approach(moving.further(), here, above));
    }
}

/// +1 if the curve is to the left of the contour, −1 if to the right.
fn side_of(soft: &Soft, beside: f64, place: Flat, tangent: Flat) -> Option<f64> {
    match soft.side {
        SoftSide::Left => Some(1.0),
        SoftSide::Right => Some(-1.0),
        SoftSide::Nearest => Some(if dot(place, left(tangent)) < 0.0 { -1.0 } else { 1.0 }),
        SoftSide::Compensation if beside != 0.0 => Some(beside.signum()),
        // A line has no side.
        SoftSide::Compensation if soft.form == SoftForm::Line => Some(1.0),
        SoftSide::Compensation => None,
    }
}

/// The curve that reaches a point along a tangent.
fn curve_onto(soft: &Soft, end: Flat, tangent: Flat, side: f64, beside: f64) -> Curve {
    let across = scaled(left(tangent), side * soft.size_mm);
    let center = add(end, across);
    let start = match soft.form {
        // The edge of the tool is to have this distance from the contour.
        SoftForm::Line => {
            return Curve::Line { start: sub(end, scaled(tangent, soft.size_mm + beside.abs())), end };
        }
        SoftForm::Quadrant => sub(center, scaled(tangent, soft.size_mm)),
        SoftForm::Semicircle => add(center, across),
    };
    Curve::arc(start, end, center, side < 0.0, 0)
}

fn reverse(curve: &Curve) -> Curve {
    match *curve {
        Curve::Line { start, end } => Curve::Line { start: end, end: start },
        Curve::Arc { center, radius, from, sweep } => Curve::Arc { center, radius, from: from + sweep, sweep: -sweep },
    }
}

/// A position at the clearance above the contour, towards another position but not beyond it.
fn at_clearance(basis: PlaneBasis, contour: &AxisVector, other: &AxisVector, clearance: Clearance) -> AxisVector {
    let (low, high) = (basis.height(contour), basis.height(other));
    let above = match clearance {
        Clearance::Above(distance) => distance,
        Clearance::At(height) => (height - low) * (high - low).signum(),
    };
    let most = (high - low).abs();
    at_height(basis, contour, low + above.clamp(0.0, most).copysign(high - low))
}

/// A position with the height of another one.
fn with_height(basis: PlaneBasis, position: &AxisVector, other: &AxisVector) -> AxisVector {
    at_height(basis, position, basis.height(other))
}

fn at_height(basis: PlaneBasis, position: &AxisVector, height: f64) -> AxisVector {
    let mut out = *position;
    out.set_xyz(basis.lift(basis.flat(position), height));
    out
}

fn no_feed(moving: &Moving) -> Fault {
    let message = "a soft approach or retraction at feed before any F word";
    moving.fault(Code::MISSING_FEED, message, "program F before it or in it")
}

fn no_side(moving: &Moving) -> Fault {
    moving.fault(
        Code::BAD_COMPENSATION,
        "a soft approach or retraction by an arc needs a side from radius compensation",
        "program G141, G142 or G143, or the compensation with G41 or G42",
    )
}
