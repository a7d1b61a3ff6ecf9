//! NORM and KONT: how compensation begins and ends.

use super::compensation::{Active, Limits};
use super::curve::{Curve, Flat, SAME_MM, add, angle_between, cross, distance, dot, left, scaled, sub, unit};
use super::link::Link;
use super::moving::{Item, Moving, own_of};
use super::wish::Approach;
use crate::diagnostic::Code;
use crate::exec::fault::Fault;
use crate::exec::path::Shape;

/// How the tool gets from a place beside the contour to its first perpendicular position.
enum Way {
    Straight,
    /// To this point, then around the corner.
    Around(Flat),
    /// Over this point.
    Over(Flat),
    /// The place is nearer to the corner than the tool is wide, and behind the contour.
    Blocked,
}

impl Active {
    /// The straight motion to the first element, and around its start where it must.
    pub(super) fn approach(&mut self, approach: Box<Moving>, link: &Link, limits: &Limits, findings: &mut Vec<Fault>) {
        let start = self.basis.flat(&self.position);
        let (beside, tangent) = (link.moving.wish.distance_mm, link.contour.first_tangent());
        let normal = scaled(left(tangent), beside);
        self.point = link.contour.start();
        self.last.clone_from(&approach);
        let items = std::mem::take(&mut self.chain.first_items);
        if let Some(soft) = approach.wish.soft {
            self.soft_approach(&approach, &soft, link, findings);
            self.chain.tail().extend(items);
            return;
        }
        let target = approach.path.motion.target;
        let way = self.way(start, tangent, beside, &approach, limits);
        if matches!(way, Way::Blocked) {
            findings.push(blocked(&approach));
        }
        let end = match way {
            Way::Around(point) | Way::Over(point) => point,
            Way::Straight | Way::Blocked => add(self.point, normal),
        };
        self.chain.push(Link::approach(*approach, Curve::Line { start, end }, target));
        self.chain.tail().extend(items);
        match way {
            Way::Around(point) => {
                let mut corner = self.corner(sub(point, self.point), normal, beside);
                corner.is_sealed = true;
                self.chain.push(corner);
            }
            Way::Over(point) => {
                let line = Curve::Line { start: point, end: add(self.point, normal) };
                let moving = self.last.further();
                self.chain.push(Link::approach(moving, line, target));
            }
            Way::Straight | Way::Blocked => {}
        }
    }

    /// The straight motion off the last element, and around its end where it must. Gives everything.
    pub(super) fn retract(
        mut self,
        moving: Box<Moving>,
        limits: &Limits,
        out: &mut Vec<Item>,
        findings: &mut Vec<Fault>,
    ) {
        if let Some(approach) = &self.approach {
            findings.push(approach.fault(
                Code::BAD_COMPENSATION,
                "radius compensation begins here, and ends before a contour element",
                "program the contour between G41 or G42 and G40",
            ));
            self.flush(out);
            out.push(Item::Path(moving));
            return;
        }
        if !matches!(moving.path.shape, Shape::Line) {
            findings.push(moving.fault(
                Code::BAD_COMPENSATION,
                "radius compensation ends in a block that is not straight",
                "end it with G0 or G1 off the contour",
            ));
        }
        self.give_up(findings);
        self.end_pieces(limits, findings);
        let own = own_of(self.chain.tail(), &moving.element);
        let target = self.basis.flat(&moving.path.motion.target);
        let normal = scaled(left(self.tangent), self.distance);
        if let Some(soft) = moving.wish.soft {
            self.soft_retract(&moving, &soft, findings);
        } else {
            let reversed = scaled(self.tangent, -1.0);
            match self.way(target, reversed, -self.distance, &moving, limits) {
                Way::Straight => {}
                Way::Blocked => findings.push(blocked(&moving)),
                Way::Around(point) => {
                    let corner = self.corner(normal, sub(point, self.point), self.distance);
                    self.chain.push(corner);
                }
                Way::Over(point) => {
                    let line = Curve::Line { start: add(self.point, normal), end: point };
                    let last = self.last.path.motion.target;
                    let further = self.last.further();
                    self.chain.push(Link::approach(further, line, last));
                }
            }
        }
        self.chain.tail().extend(own);
        self.flush(out);
        let line = Curve::Line { start: self.basis.flat(&self.position), end: target };
        let mut last = moving.along(&line, self.basis, self.position);
        last.path.motion.target = moving.path.motion.target;
        out.push(Item::Path(Box::new(last)));
    }

    /// From a place to the position beside the corner; of the way off the contour, everything reversed.
    fn way(&self, place: Flat, tangent: Flat, beside: f64, moving: &Moving, limits: &Limits) -> Way {
        let to_place = sub(place, self.point);
        let is_behind = dot(to_place, left(tangent)) * beside < -SAME_MM * beside.abs();
        if moving.wish.modal.approach != Approach::Kont || !is_behind || beside.abs() < SAME_MM {
            return Way::Straight;
        }
        let apart = distance(place, self.point);
        if apart <= beside.abs() + SAME_MM {
            return Way::Blocked;
        }
        // The tangent from the place to the circle of the tool center about the corner.
        let towards = unit(to_place);
        let along = (apart * apart - beside * beside).sqrt();
        let direction = scaled(add(scaled(towards, -along), scaled(left(towards), -beside)), 1.0 / apart);
        let contact = add(self.point, scaled(left(direction), beside));
        let is_sharp = moving.wish.modal.sharp && angle_between(direction, tangent) <= limits.corner_rad;
        let sine = cross(direction, tangent);
        if is_sharp && sine.abs() > 1e-9 {
            let first = add(self.point, scaled(left(tangent), beside));
            let reach = cross(sub(first, place), tangent) / sine;
            return Way::Over(add(place, scaled(direction, reach)));
        }
        Way::Around(contact)
    }
}

fn blocked(moving: &Moving) -> Fault {
    moving.fault(
        Code::BAD_COMPENSATION,
        "the tool stands behind the contour and nearer to its corner than its radius",
        "begin or end the compensation farther away, or in front of the contour",
    )
}
