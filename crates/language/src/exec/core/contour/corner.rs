//! Outer corners: around them on an arc or on straight lines, or beyond them to an intersection; and other corner handling.

use super::compensation::{Active, Limits, NEARLY_TANGENTIAL};
use super::contour_request::Rules;
use super::curve::{Curve, Flat, SAME_MM, add, angle_between, distance, left, scaled};
use super::link::{Link, Role};
use super::moving::{Item, Moving};
use crate::exec::core::fault::Fault;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;

/// Length below which a path around a corner is omitted, mm.
pub(super) const NO_WAY_MM: f64 = 1e-3;
/// Rounding error of an angle, rad.
const ROUNDING: f64 = 1e-9;

impl Active {
    /// From the last element to the next around an outer corner; `tip` is the intersection of their straight extensions.
    pub(super) fn outer(
        &mut self,
        mut link: Link,
        own: Vec<Item>,
        tip: Flat,
        limits: &Limits,
        findings: &mut Vec<Fault>,
    ) {
        let modal = link.moving.wish.modal;
        let (beside, most) = (link.moving.wish.distance_mm, limits.most_left_out(modal.rules));
        let (d, e) = (self.tangent, link.contour.first_tangent());
        let bend = angle_between(d, e);
        let is_flat = match modal.rules {
            Rules::Sinumerik => bend < limits.flat_rad,
            Rules::Fanuc | Rules::Grundig | Rules::Rs274 => bend * beside.abs() < NO_WAY_MM,
        };
        let is_sharp = is_flat || modal.rules != Rules::Fanuc && modal.sharp && bend <= limits.corner_rad;
        if is_sharp && self.extend(&mut link, tip) {
            self.chain.tail().extend(own);
            self.chain.push(link);
            return;
        }
        if is_flat && modal.rules != Rules::Sinumerik {
            self.chain.tail().extend(own);
            self.chain.push_touching(link, most, findings);
            return;
        }
        if modal.rules == Rules::Fanuc && modal.sharp {
            self.straight_around(link, own, d, most, findings);
            return;
        }
        // The control traverses the corner with the block after it: with its feed, or at rapid.
        self.chain.tail().extend(own);
        let mut corner = self.corner(scaled(left(d), beside), scaled(left(e), beside), beside);
        let known = corner.moving.path.motion.known;
        corner.moving = first_of(&mut link, known);
        self.chain.push_touching(corner, most, findings);
        self.chain.push_touching(link, most, findings);
    }

    /// Around an outer corner between a direction and that of an element: to the intersection if it bends by at most a right angle. Otherwise a
    /// radius beyond the corner on both sides, and straight between them.
    pub(super) fn straight_around(
        &mut self,
        mut link: Link,
        own: Vec<Item>,
        d: Flat,
        most: usize,
        findings: &mut Vec<Fault>,
    ) {
        let (beside, e) = (link.moving.wish.distance_mm, link.contour.first_tangent());
        let known = self.last.path.motion.known;
        let (points, end) = self.points_around(d, e, beside);
        let mut place = self.extend_to(points[0], d, beside, most, findings);
        self.chain.tail().extend(own);
        if distance(points[1], place) > NO_WAY_MM {
            let line = Curve::Line { start: place, end: points[1] };
            let piece = self.piece(first_of(&mut link, known), line, beside);
            self.chain.push_touching(piece, most, findings);
            place = points[1];
        }
        if matches!(link.curve, Curve::Line { .. }) && self.chain.waiting.is_empty() {
            link.from = -distance(place, end);
            self.chain.push(link);
            return;
        }
        let piece = self.piece(first_of(&mut link, known), Curve::Line { start: place, end }, beside);
        self.chain.push_touching(piece, most, findings);
        self.chain.push_touching(link, most, findings);
    }

    /// Points of the path around an outer corner by straight lines, and its end.
    pub(super) fn points_around(&self, d: Flat, e: Flat, beside: f64) -> ([Flat; 2], Flat) {
        let bend = angle_between(d, e);
        let [start, end] = [d, e].map(|direction| add(self.point, scaled(left(direction), beside)));
        if bend <= std::f64::consts::FRAC_PI_2 + ROUNDING {
            let tip = add(start, scaled(d, beside.abs() * (bend / 2.0).tan()));
            ([tip, tip], end)
        } else {
            ([add(start, scaled(d, beside.abs())), add(end, scaled(e, -beside.abs()))], end)
        }
    }

    /// Extends the last piece straight to a point: the piece itself if it is straight. Returns the point.
    pub(super) fn extend_to(
        &mut self,
        point: Flat,
        d: Flat,
        beside: f64,
        most: usize,
        findings: &mut Vec<Fault>,
    ) -> Flat {
        let start = add(self.point, scaled(left(d), beside));
        let last = self.chain.links.back_mut().filter(|_| self.chain.waiting.is_empty());
        if let Some(link) = last.filter(|link| link.goes_straight_to(start, d)) {
            link.to += distance(start, point);
            return point;
        }
        // Items after the last element act at the end of its block.
        let items = std::mem::take(self.chain.tail());
        let piece = self.piece(Box::new(self.last.further()), Curve::Line { start, end: point }, beside);
        self.chain.push_touching(piece, most, findings);
        self.chain.tail().extend(items);
        point
    }

    /// A piece of the path around the corner.
    pub(super) fn piece(&self, moving: Box<Moving>, curve: Curve, beside: f64) -> Link {
        Link::new(Role::Corner, moving, Curve::Line { start: self.point, end: self.point }, curve, beside)
    }

    /// Repeated G41, G42: the last element ends perpendicular to itself at any corner, and the next one leads from there to its end.
    pub(super) fn square(&mut self, mut link: Link, own: Vec<Item>, findings: &mut Vec<Fault>) {
        if matches!(link.contour, Curve::Arc { .. }) {
            findings.push(link.moving.fault(
                Code::BAD_COMPENSATION,
                "G41 or G42 repeated in an arc: the control leaves the arc",
                "repeat it in a straight block, or not at all while it is on",
            ));
        }
        self.give_up(findings);
        if let Some(last) = self.chain.links.back_mut() {
            last.is_sealed = true;
        }
        self.chain.tail().extend(own);
        link.begins_anywhere = true;
        self.chain.push(link);
    }

    /// Reports a change of sides that needs G40.
    pub(super) fn check_side_change(&self, link: &Link, findings: &mut Vec<Fault>) {
        let start = add(self.point, scaled(left(self.tangent), self.distance));
        let allows = match link.moving.wish.modal.rules {
            Rules::Sinumerik => true,
            // On the way back along the same line the tool stays.
            Rules::Fanuc => distance(start, link.curve.start()) < NO_WAY_MM,
            Rules::Grundig | Rules::Rs274 => false,
        };
        if !allows {
            findings.push(link.moving.fault(
                Code::BAD_COMPENSATION,
                "the tool changes the side of the contour while radius compensation is on",
                "end it with G40 and a straight motion off the contour before it begins on the other side",
            ));
        }
    }

    /// The arc around the end of the last element, from one normal to another.
    pub(super) fn corner(&mut self, from: Flat, to: Flat, beside: f64) -> Link {
        let (start, end) = (add(self.point, from), add(self.point, to));
        let mut curve = Curve::arc(start, end, self.point, beside > 0.0, 0);
        if distance(start, end) < 1e-9 {
            curve = Curve::Line { start, end };
        }
        let mut moving = self.last.further();
        moving.element.starts_block = !self.chain.tail().is_empty();
        Link::new(Role::Corner, Box::new(moving), Curve::Line { start: self.point, end: self.point }, curve, beside)
    }

    /// Extends the last piece and the new one to their intersection beyond an outer corner, if there is one near the tip.
    fn extend(&mut self, link: &mut Link, tip: Flat) -> bool {
        if !self.chain.waiting.is_empty() {
            return false;
        }
        let reach = distance(tip, self.point);
        let Some(old) = self.chain.links.back_mut() else { return false };
        let mut best: Option<(f64, f64, Flat)> = None;
        for point in old.curve.crossings(&link.curve).iter() {
            let (end, start) = (old.curve.along(point, old.to), link.curve.along(point, 0.0));
            let lies_beyond = end >= old.to - SAME_MM && start <= SAME_MM && distance(point, tip) <= reach;
            if lies_beyond && best.is_none_or(|(_, _, other)| distance(point, tip) < distance(other, tip)) {
                best = Some((end, start, point));
            }
        }
        let Some((end, start, _)) = best else { return false };
        old.to = end;
        link.from = start;
        true
    }

    /// From one side of the contour to the other, straight through the corner.
    pub(super) fn other_side(&mut self, link: &Link) {
        let start = add(self.point, scaled(left(self.tangent), self.distance));
        let curve = Curve::Line { start, end: link.curve.start() };
        let mut moving = Box::new(self.last.further());
        moving.element.starts_block = !self.chain.tail().is_empty();
        let mut through = Link::new(Role::Corner, moving, curve, curve, 0.0);
        through.is_sealed = true;
        self.chain.push(through);
    }

    /// Changes the radius from this element on: a straight element tapers to it.
    pub(super) fn taper(&mut self, link: &mut Link, before: f64, bend: f64, findings: &mut Vec<Fault>) {
        let beside = link.moving.wish.distance_mm;
        let is_smooth = bend < NEARLY_TANGENTIAL && self.chain.waiting.is_empty();
        match link.contour {
            Curve::Line { start, end } if is_smooth => {
                let normal = left(link.contour.first_tangent());
                let curve =
                    Curve::Line { start: add(start, scaled(normal, before)), end: add(end, scaled(normal, beside)) };
                link.curve = curve;
                link.to = curve.length();
                link.clearance_mm = before.abs().min(beside.abs());
            }
            _ => findings.push(link.moving.fault(
                Code::BAD_COMPENSATION,
                "the radius of the tool changes at a corner or in an arc of the compensated contour",
                "change D, OFFN or the tool in a straight block that continues in the previous direction, or after G40",
            )),
        }
    }
}

impl Link {
    /// `true` if it is straight and ends at a point in a direction.
    fn goes_straight_to(&self, point: Flat, direction: Flat) -> bool {
        matches!(self.curve, Curve::Line { .. })
            && self.role == Role::Contour
            && self.to == self.curve.length()
            && distance(self.curve.end(), point) < SAME_MM
            && angle_between(self.curve.last_tangent(), direction) < ROUNDING
    }
}

/// The motion of the first of several pieces of an element's block; the element keeps the rest.
pub(super) fn first_of(link: &mut Link, known: AxisSet) -> Box<Moving> {
    let behind = Box::new(link.moving.further());
    let mut moving = std::mem::replace(&mut link.moving, behind);
    moving.path.motion.named = AxisSet::EMPTY;
    moving.path.motion.known = known;
    moving
}
