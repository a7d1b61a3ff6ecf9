//! The tool center path by the rules of RS274/NGC: the waiting motion, its cut-back, and the arc about an outer corner.

use std::f64::consts::PI;

use super::check::NARROW;
use super::curve::{Curve, Flat, SAME_MM, add, distance, dot, left, scaled, sub, unit};
use super::link::MOST_WAITING;
use super::moving::{Item, Moving};
use crate::exec::core::fault::Fault;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisVector, LINEAR_AXES, PlaneBasis};

/// Largest extension of an arc by the cut-back, rad.
const LONGER_RAD: f64 = 0.0254;
/// Missing angle below which an arc is a full circle, rad.
const FULL_CIRCLE_RAD: f64 = 1e-6;

/// The tool center path under active compensation, and until the motion after it.
#[derive(Debug)]
pub(super) struct Tracking {
    pub(super) basis: PlaneBasis,
    /// Tool center after the released items.
    pub(super) position: AxisVector,
    /// The last motion in the plane, with the items after it.
    pub(super) held: Vec<Held>,
    /// Tool center after these.
    pub(super) center: AxisVector,
    /// The end of the contour there.
    pub(super) point: Flat,
    /// To the left of the contour, mm.
    pub(super) distance: f64,
    pub(super) activation: u32,
}

#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "nearly all are the large one; a box would be an allocation for each")]
pub(super) enum Held {
    Piece(Piece),
    Item(Item),
}

/// A piece of the path whose end in the plane may still change.
#[derive(Debug)]
pub(super) struct Piece {
    pub(super) moving: Box<Moving>,
    pub(super) end: Flat,
    pub(super) way: TrackedPath,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum TrackedPath {
    /// In the programmed direction; a zero vector if it does not count.
    Line(Flat),
    Arc {
        center: Flat,
        radius: f64,
        clockwise: bool,
        extra_turns: u32,
        /// Angle swept by the contour, rad; 0 if it does not count.
        sweep: f64,
    },
}

/// A path that intersects the last one at an inner corner.
pub(super) struct Next {
    /// Its direction at the corner.
    pub(super) direction: Flat,
    /// For an arc: center, radius beside it, `true` if counter-clockwise, `true` if the tool is inside.
    pub(super) arc: Option<(Flat, f64, bool, bool)>,
}

impl Tracking {
    /// The arc about the outer corner, at rapid the chord; returns the rest of the motion.
    pub(super) fn around(&mut self, moving: Box<Moving>, end: Flat, out: &mut Vec<Item>) -> Box<Moving> {
        let behind = Box::new(moving.further());
        let mut corner = *moving;
        corner.path.motion.named = corner.path.motion.named.difference(LINEAR_AXES.into_iter().collect());
        let start = self.basis.flat(&self.position);
        let curve = if corner.path.motion.rapid {
            Curve::Line { start, end }
        } else {
            Curve::arc(start, end, self.point, self.distance > 0.0, 0)
        };
        // The height waits for the element, rotary axes do not.
        let target = corner.path.motion.target;
        let mut other_axes = target;
        other_axes.set_xyz(self.basis.lift(end, self.basis.height(&self.position)));
        let corner = corner.ending(&curve, self.basis, self.position, other_axes);
        self.position = corner.path.motion.target;
        out.push(Item::Path(Box::new(corner)));
        behind
    }

    pub(super) fn hold(&mut self, moving: Box<Moving>, end: Flat, way: TrackedPath) {
        self.center = self.basis.moved(&moving.path.motion.target, end);
        self.held.push(Held::Piece(Piece { moving, end, way }));
    }

    /// Holds the items after the last motion in the plane, up to a limit.
    pub(super) fn wait(&mut self, item: Held, out: &mut Vec<Item>, findings: &mut Vec<Fault>) {
        self.held.push(item);
        if self.held.len() < MOST_WAITING {
            return;
        }
        if let Some(Held::Piece(piece)) = self.held.first() {
            findings.push(piece.moving.fault(
                Code::BAD_COMPENSATION,
                "too many blocks without motion in the plane follow this contour element",
                "move them out of the contour",
            ));
        }
        self.release(out);
    }

    /// Center, radius and direction of the held arc.
    pub(super) fn last_arc(&self) -> Option<(Flat, f64, bool)> {
        match self.held.iter().find_map(|held| if let Held::Piece(piece) = held { Some(piece.way) } else { None })? {
            TrackedPath::Line(_) => None,
            TrackedPath::Arc { center, radius, clockwise, .. } => Some((center, radius, !clockwise)),
        }
    }

    /// The intersection of the last path and the next one at an inner corner.
    pub(super) fn meeting(&self, place: Flat, before: Flat, next: &Next) -> Option<Flat> {
        let side = self.distance.signum();
        match (self.last_arc(), next.arc) {
            (None, None) => {
                let line = |at: Flat, direction: Flat| Curve::Line { start: at, end: add(at, direction) };
                let beside = add(self.point, scaled(left(next.direction), self.distance));
                line(place, before).crossings(&line(beside, next.direction)).iter().next()
            }
            (None, Some((center, radius, _, is_inside))) => {
                // As in LinuxCNC: with the radius at the end of the arc, even if that at its start differs slightly.
                let wide = if is_inside { radius + self.distance.abs() } else { radius - self.distance.abs() };
                let height = wide * dot(unit(sub(self.point, center)), left(before)) + self.distance;
                let square = radius * radius - height * height;
                let along = sign(is_inside) * checked_root(square)?;
                Some(add(center, add(scaled(left(before), height), scaled(before, along))))
            }
            (Some((center, radius, turns_left)), None) => {
                let is_inside = sign(turns_left) * side > 0.0;
                let beside = add(self.point, scaled(left(next.direction), self.distance));
                let height = dot(sub(beside, center), left(next.direction));
                let along = -sign(is_inside) * checked_root(radius * radius - height * height)?;
                Some(add(center, add(scaled(left(next.direction), height), scaled(next.direction, along))))
            }
            (Some((center, radius, turns_left)), Some((other, wide, other_turns_left, _))) => {
                let is_inside = sign(turns_left) * side > 0.0;
                let apart = distance(center, other);
                if apart < SAME_MM || radius < SAME_MM {
                    return None;
                }
                let u = unit(sub(other, center));
                let along = (radius * radius + apart * apart - wide * wide) / (2.0 * apart);
                let aside = sign(is_inside) * sign(other_turns_left) * checked_root(radius * radius - along * along)?;
                Some(add(center, add(scaled(u, along), scaled(left(u), aside))))
            }
        }
    }

    /// Ends the held motion at a point of the plane.
    pub(super) fn cut_back(&mut self, point: Flat, out: &mut Vec<Item>, findings: &mut Vec<Fault>) {
        let start = self.basis.flat(&self.position);
        for held in &mut self.held {
            let Held::Piece(piece) = held else { continue };
            let is_reachable = match piece.way {
                TrackedPath::Line(direction) => dot(direction, sub(point, start)) >= 0.0,
                TrackedPath::Arc { center, radius, clockwise, extra_turns, sweep } => {
                    let new = Curve::arc(start, point, center, clockwise, extra_turns).length() / radius;
                    sweep == 0.0 || new <= sweep.abs() + LONGER_RAD
                }
            };
            if !is_reachable {
                findings.push(unreachable(&piece.moving));
            }
            piece.end = point;
        }
        self.release(out);
    }

    /// Emits what is held.
    pub(super) fn release(&mut self, out: &mut Vec<Item>) {
        for held in self.held.drain(..) {
            match held {
                Held::Item(item) => out.push(item),
                Held::Piece(Piece { moving, end, way }) => {
                    let start = self.basis.flat(&self.position);
                    let (curve, end) = match way {
                        TrackedPath::Line(_) => (Curve::Line { start, end }, end),
                        TrackedPath::Arc { center, radius, clockwise, extra_turns, sweep } => {
                            // A full circle stays one for any rounding of its ends.
                            let is_circle = sweep.abs() > PI && distance(start, end) < FULL_CIRCLE_RAD * radius;
                            let end = if is_circle { start } else { end };
                            (Curve::arc(start, end, center, clockwise, extra_turns), end)
                        }
                    };
                    let mut moved = moving.ending(&curve, self.basis, self.position, moving.path.motion.target);
                    // After a small bend an arc begins slightly off its circle; its end is correct.
                    moved.path.motion.target = self.basis.moved(&moved.path.motion.target, end);
                    self.position = moved.path.motion.target;
                    out.push(Item::Path(Box::new(moved)));
                }
            }
        }
    }

    /// Ends at the end of compensation or of the program.
    pub(super) fn finish(&mut self, out: &mut Vec<Item>, findings: &mut Vec<Fault>) {
        let end = self.basis.flat(&self.center);
        self.cut_back(end, out, findings);
    }
}

pub(super) fn sign(is_positive: bool) -> f64 {
    if is_positive { 1.0 } else { -1.0 }
}

/// The square root of a value that is negative only by rounding; `None` for a truly negative one.
fn checked_root(square: f64) -> Option<f64> {
    (square > -1e-9).then(|| square.max(0.0).sqrt())
}

pub(super) fn unreachable(moving: &Moving) -> Fault {
    moving.fault(
        Code::CONTOUR_NOT_FOLLOWED,
        "the tool cannot reach this element at its inner corner without damaging the contour",
        NARROW,
    )
}
