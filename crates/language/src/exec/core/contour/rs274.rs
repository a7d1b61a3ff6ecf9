//! Radius compensation by the rules of RS274/NGC, as in LinuxCNC.
//!
//! The first motion ends perpendicular to its own end, so that its path is tangent to the tool at its start. From then on one motion, with the items
//! after it, waits for the next. At an inner corner both are cut back to their intersection; around an outer corner an arc is inserted in the next
//! block. Nothing is left out; motions without intersection are rejected. The motion after G40 begins at the tool position.

use super::moving::Switch;
use super::tracking::unreachable;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::check::NARROW;
use super::compensation::Compensation;
use super::contour_request::Rules;
use super::curve::{Curve, SAME_MM, add, cross, distance, dot, left, scaled, sub, unit};
use super::moving::{Item, Moving, same_plane};
use super::tracking::{Held, Next, Piece, TrackedPath, Tracking, sign};
use crate::exec::core::fault::Fault;
use crate::exec::core::path::Shape;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisVector, Plane, PlaneBasis};

/// Changes of direction below this count as none, rad.
const SMALL_RAD: f64 = 0.05;

impl Compensation {
    /// Takes an item under the rules of RS274/NGC; returns items that need no change.
    pub(super) fn track(&mut self, item: Item, out: &mut Vec<Item>, findings: &mut Vec<Fault>) -> Option<Item> {
        let moving = match (item, &mut self.tracking) {
            (Item::Path(moving), None) if moving.wish.modal.rules == Rules::Rs274 && has_no_radius(&moving) => {
                out.push(Item::Path(moving));
                return None;
            }
            (Item::Path(moving), None) if moving.wish.modal.rules != Rules::Rs274 || !is_beside(&moving) => {
                return Some(Item::Path(moving));
            }
            (Item::Path(moving), _) => moving,
            (item, None) => return Some(item),
            (item, Some(tracking)) => {
                if tracking.held.is_empty() {
                    out.push(item);
                } else {
                    tracking.wait(Held::Item(item), out, findings);
                }
                return None;
            }
        };
        let place = match self.tracking.take() {
            None => moving.path.start,
            Some(mut tracking) => {
                if is_beside(&moving) && moving.wish.modal.activation == tracking.activation {
                    tracking.element(moving, out, findings);
                    self.tracking = Some(tracking);
                    return None;
                }
                tracking.finish(out, findings);
                tracking.position
            }
        };
        let mut moving = moving;
        if self.limits.keeps_wear {
            moving.switch = if is_beside(&moving) { Switch::On } else { Switch::Off };
        }
        if is_beside(&moving) {
            self.tracking = Tracking::begin(moving, place, out, findings);
        } else {
            leave(moving, place, out, findings);
        }
        None
    }
}

fn is_beside(moving: &Moving) -> bool {
    moving.wish.compensates() && moving.wish.distance_mm != 0.0
}

/// `true` if the offset is zero: the tool is on the contour.
fn has_no_radius(moving: &Moving) -> bool {
    moving.wish.compensates() && moving.wish.distance_mm == 0.0
}

/// The motion after the compensation.
fn leave(mut moving: Box<Moving>, place: AxisVector, out: &mut Vec<Item>, findings: &mut Vec<Fault>) {
    if matches!(moving.path.shape, Shape::Arc { .. }) {
        findings.push(not_straight(&moving));
    }
    moving.path.start = place;
    out.push(Item::Path(moving));
}

impl Tracking {
    /// The first motion; `place` is the tool center, which after G40 is not the programmed position.
    fn begin(
        mut moving: Box<Moving>,
        place: AxisVector,
        out: &mut Vec<Item>,
        findings: &mut Vec<Fault>,
    ) -> Option<Box<Tracking>> {
        let basis = moving.path.basis;
        let beside = moving.wish.distance_mm;
        let mut tracking = Box::new(Tracking {
            basis,
            position: place,
            held: Vec::new(),
            center: place,
            point: basis.flat(&moving.path.motion.target),
            distance: beside,
            activation: moving.wish.modal.activation,
        });
        let contour = moving.curve(&basis);
        let (start, end) = (basis.flat(&moving.path.start), tracking.point);
        let is_displaced = distance(basis.flat(&place), start) > SAME_MM;
        let found = tracking
            .objection(&moving)
            .or_else(|| (is_displaced && matches!(contour, Some(Curve::Arc { .. }))).then(|| not_straight(&moving)));
        let found = found.or_else(|| {
            (distance(start, end) <= beside.abs()).then(|| {
                moving.fault(
                    Code::BAD_COMPENSATION,
                    "radius compensation begins with a motion that is not longer than the radius of the tool",
                    "begin it farther away, with a motion in the plane",
                )
            })
        });
        let contour = match (found, contour) {
            (None, Some(contour)) => contour,
            (found, _) => {
                findings.extend(found);
                moving.path.start = place;
                out.push(Item::Path(moving));
                return None;
            }
        };
        let beside_end = add(end, scaled(left(contour.last_tangent()), beside));
        let way = match contour {
            Curve::Line { .. } => Some(TrackedPath::Line([0.0; 2])),
            Curve::Arc { center, radius, sweep, .. } => {
                // About a point equidistant from start and end, on the line from the end to the programmed center.
                let u = unit(sub(center, beside_end));
                let chord = sub(start, beside_end);
                let along = dot(chord, u);
                let is_inside = sweep * beside > 0.0;
                (along.abs() > 1e-4 * distance(start, beside_end) && !(is_inside && radius <= beside.abs())).then(
                    || {
                        let reach = dot(chord, chord) / (2.0 * along);
                        TrackedPath::Arc {
                            center: add(beside_end, scaled(u, reach)),
                            radius: reach.abs(),
                            clockwise: sweep < 0.0,
                            extra_turns: contour.extra_turns(),
                            sweep: 0.0,
                        }
                    },
                )
            }
        };
        let Some(way) = way else {
            findings.push(too_narrow(&moving, beside));
            moving.path.start = place;
            out.push(Item::Path(moving));
            return None;
        };
        tracking.hold(moving, beside_end, way);
        Some(tracking)
    }

    /// A motion under active compensation.
    fn element(&mut self, moving: Box<Moving>, out: &mut Vec<Item>, findings: &mut Vec<Fault>) {
        if !moving.is_plane_motion() {
            let end = self.basis.flat(&self.center);
            self.center = self.basis.moved(&moving.path.motion.target, end);
            let way = TrackedPath::Line([0.0; 2]);
            self.wait(Held::Piece(Piece { moving, end, way }), out, findings);
            return;
        }
        if let Some(found) = self.objection(&moving) {
            findings.push(found);
            self.release(out);
            self.center = moving.path.motion.target;
            self.position = self.center;
            out.push(Item::Path(moving));
            return;
        }
        let Some(contour) = moving.curve(&self.basis) else { return };
        let radius = self.distance.abs();
        let side = self.distance.signum();
        let center = self.basis.flat(&self.center);
        let next = match contour {
            Curve::Line { .. } => Next { direction: contour.first_tangent(), arc: None },
            Curve::Arc { center, sweep, .. } => {
                // The radius is that at the end.
                let wide = distance(center, contour.end());
                let is_inside = sweep * side > 0.0;
                if is_inside && wide <= radius {
                    findings.push(too_narrow(&moving, self.distance));
                }
                let beside = if is_inside { wide - radius } else { wide + radius };
                Next { direction: contour.first_tangent(), arc: Some((center, beside, sweep > 0.0, is_inside)) }
            }
        };
        // From the last direction to the next, positive away from the tool.
        let square = unit(sub(center, self.point));
        let before = scaled(left(square), -side);
        let turn = -side * cross(before, next.direction).atan2(dot(before, next.direction));
        let bend = if turn < -FRAC_PI_2 { turn + TAU } else { turn };
        // On the way back along an arc, going around the corner and staying beside both are equal: the tool stays.
        let turns_back = (bend - PI).abs() < SMALL_RAD
            && match (next.arc, self.last_arc()) {
                (Some((.., is_inside)), _) => !is_inside,
                (None, Some((_, _, turns_left))) => sign(turns_left) * side < 0.0,
                (None, None) => false,
            };
        let mut moving = moving;
        let beside_start = add(self.point, scaled(left(next.direction), self.distance));
        if turns_back || !(-SMALL_RAD..=PI + SMALL_RAD).contains(&bend) {
            match self.meeting(center, before, &next) {
                Some(point) => self.cut_back(point, out, findings),
                None => {
                    findings.push(unreachable(&moving));
                    self.release(out);
                }
            }
        } else if bend > SMALL_RAD {
            if next.arc.is_none() {
                self.cut_back(center, out, findings);
            } else {
                self.release(out);
            }
            moving = self.around(moving, beside_start, out);
        } else {
            self.release(out);
        }
        let end = add(contour.end(), scaled(left(contour.last_tangent()), self.distance));
        let way = match (contour, next.arc) {
            (Curve::Arc { center, sweep, .. }, Some((_, radius, ..))) => {
                TrackedPath::Arc { center, radius, clockwise: sweep < 0.0, extra_turns: contour.extra_turns(), sweep }
            }
            _ => TrackedPath::Line(next.direction),
        };
        self.point = contour.end();
        self.hold(moving, end, way);
    }

    /// The fault for a motion that cannot be compensated.
    fn objection(&self, moving: &Moving) -> Option<Fault> {
        if let Some(found) = super::check::doubtful(moving) {
            return Some(found);
        }
        let (code, message, help) = if !same_plane(&self.basis, &moving.path.basis)
            || self.basis == PlaneBasis::Principal(Plane::YZ)
        {
            let help = "end it with G40 before the plane changes, and use it in G17 and G18";
            (Code::BAD_COMPENSATION, "radius compensation in G19, or the plane changes while it is on", help)
        } else if moving.path.motion.is_inverse_time() {
            let help = "program the feed with G94 or G95";
            (Code::NOT_SUPPORTED, "inverse-time feed (G93) under radius compensation", help)
        } else if moving.path.motion.in_machine_frame {
            let help = "end it with G40 before G53";
            (Code::BAD_COMPENSATION, "machine coordinates while radius compensation is on", help)
        } else if matches!(moving.path.shape, Shape::Chords(_)) {
            let help = "program lines and arcs, or end it with G40 before";
            (Code::BAD_COMPENSATION, "a curve that is not a line or arc in the plane, under radius compensation", help)
        } else {
            return None;
        };
        Some(moving.fault(code, message, help))
    }
}

fn not_straight(moving: &Moving) -> Fault {
    moving.fault(
        Code::BAD_COMPENSATION,
        "the first move after G40 is not straight",
        "end the compensation with G0 or G1 off the contour",
    )
}

fn too_narrow(moving: &Moving, beside: f64) -> Fault {
    moving.fault(
        Code::CONTOUR_NOT_FOLLOWED,
        format!("this arc is too narrow for a tool center at a distance of {:.4} mm", beside.abs()),
        NARROW,
    )
}
