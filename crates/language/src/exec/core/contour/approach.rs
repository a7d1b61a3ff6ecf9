//! Start and end of compensation: NORM, KONT and related modes.

use std::f64::consts::PI;

use super::compensation::{Active, Limits, NO_CORNER};
use super::contour_request::Approach;
use super::corner::{NO_WAY_MM, first_of};
use super::curve::{Curve, Flat, SAME_MM, add, angle_between, cross, distance, dot, left, scaled, sub, unit};
use super::link::{Link, Role};
use super::moving::Switch;
use super::moving::{Item, Moving, own_of};
use crate::exec::core::fault::Fault;
use crate::exec::core::path::Shape;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisSet;

/// The path of the tool from a position beside the contour to its first perpendicular position.
enum ApproachPath {
    Straight,
    /// To this point, then around the corner.
    Around(Flat),
    /// Through this point.
    Over(Flat),
    /// To the point perpendicular to the direction of its block, then around the outer corner.
    Own(Flat),
    /// The position is nearer to the corner than the tool radius, and behind the contour.
    Blocked,
}

impl Active {
    /// The straight motion to the first element, around its start if required, and the element.
    pub(super) fn approach(
        &mut self,
        approach: Box<Moving>,
        link: Link,
        own: Vec<Item>,
        limits: &Limits,
        findings: &mut Vec<Fault>,
    ) {
        let start = self.basis.flat(&self.position);
        let (beside, tangent) = (link.moving.wish.distance_mm, link.contour.first_tangent());
        let normal = scaled(left(tangent), beside);
        self.point = link.contour.start();
        self.last.clone_from(&approach);
        let items = std::mem::take(&mut self.chain.first_items);
        if let Some(soft) = approach.wish.soft {
            self.soft_approach(&approach, &soft, &link, findings);
            self.chain.tail().extend(items.into_iter().chain(own));
            self.chain.push(link);
            return;
        }
        let target = approach.path.motion.target;
        let way = self.way(start, tangent, beside, &approach, limits);
        if matches!(way, ApproachPath::Blocked) {
            findings.push(blocked(&approach));
        }
        let end = match way {
            ApproachPath::Around(point) | ApproachPath::Over(point) => point,
            ApproachPath::Own(direction) => add(self.point, scaled(left(direction), beside)),
            ApproachPath::Straight | ApproachPath::Blocked => add(self.point, normal),
        };
        self.chain.push(Link::approach(*approach, Curve::Line { start, end }, target));
        self.chain.tail().extend(items);
        match way {
            ApproachPath::Own(direction) => {
                self.tangent = direction;
                self.around(link, own, limits, findings);
                return;
            }
            ApproachPath::Around(point) => {
                let mut corner = self.corner(sub(point, self.point), normal, beside);
                corner.is_sealed = true;
                self.chain.push(corner);
            }
            ApproachPath::Over(point) => {
                let line = Curve::Line { start: point, end: add(self.point, normal) };
                let moving = self.last.further();
                self.chain.push(Link::approach(moving, line, target));
            }
            ApproachPath::Straight | ApproachPath::Blocked => {}
        }
        self.chain.tail().extend(own);
        self.chain.push(link);
    }

    /// The straight motion off the last element, around its end if required. Returns everything.
    pub(super) fn retract(
        mut self,
        mut moving: Box<Moving>,
        limits: &Limits,
        out: &mut Vec<Item>,
        findings: &mut Vec<Fault>,
    ) {
        if let Some(approach) = &self.approach {
            findings.push(approach.fault(
                Code::BAD_COMPENSATION,
                "radius compensation begins here and ends before any contour element",
                "program the contour between G41 or G42 and G40",
            ));
            self.flush(out);
            out.push(Item::Path(moving));
            return;
        }
        if !matches!(moving.path.shape, Shape::Line) {
            findings.push(moving.fault(
                Code::BAD_COMPENSATION,
                "radius compensation ends in a block that is not a straight move",
                "end it with G0 or G1 off the contour",
            ));
        }
        self.give_up(findings);
        self.end_pieces(limits, findings);
        let mut own = own_of(self.chain.tail(), &moving.element);
        let target = self.basis.flat(&moving.path.motion.target);
        let normal = scaled(left(self.tangent), self.distance);
        if let Some(soft) = moving.wish.soft {
            self.soft_retract(&moving, &soft, findings);
        } else if let Some(direction) = moving.wish.modal.leaves_along {
            self.cut_along(unit(direction));
        } else {
            let reversed = scaled(self.tangent, -1.0);
            match self.way(target, reversed, -self.distance, &moving, limits) {
                ApproachPath::Straight => {}
                ApproachPath::Blocked => findings.push(blocked(&moving)),
                ApproachPath::Own(reversed) => {
                    moving = self.off(moving, scaled(reversed, -1.0), std::mem::take(&mut own), findings);
                }
                ApproachPath::Around(point) => {
                    let corner = self.corner(normal, sub(point, self.point), self.distance);
                    self.chain.push(corner);
                }
                ApproachPath::Over(point) => {
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
        if limits.keeps_wear {
            last.switch = Switch::Off;
        }
        out.push(Item::Path(Box::new(last)));
    }

    /// Around the outer corner before the first element, none of which is cut back.
    fn around(&mut self, mut link: Link, own: Vec<Item>, limits: &Limits, findings: &mut Vec<Fault>) {
        let (beside, d, e) = (link.moving.wish.distance_mm, self.tangent, link.contour.first_tangent());
        let most = limits.most_left_out(link.moving.wish.modal.rules);
        if link.moving.wish.modal.sharp {
            self.straight_around(link, own, d, most, findings);
        } else {
            self.chain.tail().extend(own);
            let mut corner = self.corner(scaled(left(d), beside), scaled(left(e), beside), beside);
            corner.moving = first_of(&mut link, self.last.path.motion.known);
            self.chain.push(corner);
            self.chain.push(link);
        }
        let before = self.chain.links.len().saturating_sub(1);
        self.chain.links.iter_mut().take(before).for_each(|link| link.is_sealed = true);
    }

    /// Around the outer corner after the last element into a direction; returns the rest of the motion.
    fn off(&mut self, mut moving: Box<Moving>, e: Flat, own: Vec<Item>, findings: &mut Vec<Fault>) -> Box<Moving> {
        let (beside, d) = (self.distance, self.tangent);
        let first = |moving: &mut Box<Moving>| {
            let behind = Box::new(moving.further());
            let mut first = std::mem::replace(moving, behind);
            first.path.motion.named = AxisSet::EMPTY;
            first
        };
        if !moving.wish.modal.sharp {
            self.chain.tail().extend(own);
            let mut corner = self.corner(scaled(left(d), beside), scaled(left(e), beside), beside);
            corner.moving = first(&mut moving);
            self.chain.push(corner);
            return moving;
        }
        let (points, end) = self.points_around(d, e, beside);
        let mut place = self.extend_to(points[0], d, beside, 0, findings);
        self.chain.tail().extend(own);
        for point in [points[1], end] {
            if distance(point, place) > NO_WAY_MM {
                let piece = self.piece(first(&mut moving), Curve::Line { start: place, end: point }, beside);
                self.chain.push(piece);
                place = point;
            }
        }
        moving
    }

    /// Ends the last piece at its intersection with the path beside a virtual straight continuation in a direction; without an intersection the piece
    /// stays.
    fn cut_along(&mut self, direction: Flat) {
        let start = add(self.point, scaled(left(direction), self.distance));
        let line = Curve::Line { start, end: add(start, direction) };
        let place = add(self.point, scaled(left(self.tangent), self.distance));
        let last = self.chain.links.back_mut().filter(|link| link.role == Role::Contour);
        let Some(last) = last else { return };
        let crossings = last.curve.crossings(&line);
        let Some(point) = crossings.iter().min_by(|a, b| distance(*a, place).total_cmp(&distance(*b, place))) else {
            return;
        };
        let end = last.curve.along(point, last.to);
        if end > last.from {
            last.to = end;
        }
    }

    /// From a position to the position beside the corner; for the path off the contour, everything is reversed.
    fn way(&self, place: Flat, tangent: Flat, beside: f64, moving: &Moving, limits: &Limits) -> ApproachPath {
        let to_place = sub(place, self.point);
        if moving.wish.modal.approach == Approach::Own {
            let direction = unit(scaled(to_place, -1.0));
            let bend = angle_between(direction, tangent);
            let is_outer = cross(direction, tangent) * beside < 0.0 || PI - bend < NO_CORNER;
            let is_corner = is_outer && bend * beside.abs() > NO_WAY_MM && distance(place, self.point) > SAME_MM;
            return if is_corner { ApproachPath::Own(direction) } else { ApproachPath::Straight };
        }
        let is_behind = dot(to_place, left(tangent)) * beside < -SAME_MM * beside.abs();
        if moving.wish.modal.approach != Approach::Kont || !is_behind || beside.abs() < SAME_MM {
            return ApproachPath::Straight;
        }
        let apart = distance(place, self.point);
        if apart <= beside.abs() + SAME_MM {
            return ApproachPath::Blocked;
        }
        // The tangent from the position to the circle of the tool center about the corner.
        let towards = unit(to_place);
        let along = (apart * apart - beside * beside).sqrt();
        let direction = scaled(add(scaled(towards, -along), scaled(left(towards), -beside)), 1.0 / apart);
        let contact = add(self.point, scaled(left(direction), beside));
        let is_sharp = moving.wish.modal.sharp && angle_between(direction, tangent) <= limits.corner_rad;
        let sine = cross(direction, tangent);
        if is_sharp && sine.abs() > 1e-9 {
            let first = add(self.point, scaled(left(tangent), beside));
            let reach = cross(sub(first, place), tangent) / sine;
            return ApproachPath::Over(add(place, scaled(direction, reach)));
        }
        ApproachPath::Around(contact)
    }
}

fn blocked(moving: &Moving) -> Fault {
    moving.fault(
        Code::BAD_COMPENSATION,
        "the tool is behind the contour and closer to its corner than its radius",
        "begin or end the compensation farther away, or in front of the contour",
    )
}
