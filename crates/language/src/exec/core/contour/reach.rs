//! G43 and G44 of Grundig: straight motions that end a tool radius before or beyond their end, and the following motions.

use super::check::doubtful;
use super::compensation::{Active, Compensation};
use super::contour_request::Reach;
use super::corner::NO_WAY_MM;
use super::curve::{Curve, add, distance, left, scaled, sub, unit};
use super::moving::{Item, Moving};
use crate::exec::core::fault::Fault;
use crate::exec::core::path::Shape;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AxisVector;

impl Compensation {
    /// Takes a motion that ends at another position than programmed, or begins after such a one; returns unaffected items.
    pub(super) fn reach(&mut self, item: Item, out: &mut Vec<Item>, findings: &mut Vec<Fault>) -> Option<Item> {
        let wants = |moving: &Moving| moving.wish.modal.reach != Reach::End && !moving.wish.compensates();
        let moving = match item {
            Item::Path(moving) if self.active.is_none() && (self.reached.is_some() || wants(&moving)) => moving,
            other => return Some(other),
        };
        let position = self.reached.as_deref().copied().unwrap_or(moving.path.start);
        if moving.wish.compensates() && moving.is_plane_motion() {
            self.reached = None;
            self.begin_beside(moving, position, findings);
        } else if !moving.is_plane_motion() && !moving.names_plane() {
            // Heights and other axes move at the tool position.
            let basis = moving.path.basis;
            let carried = moving.carried(&basis, position);
            self.reached = self.reached.take().map(|_| Box::new(carried.path.motion.target));
            out.push(Item::Path(carried));
        } else if !matches!(moving.path.shape, Shape::Line) {
            findings.push(moving.fault(
                Code::BAD_COMPENSATION,
                "a move that is not straight with G43 or G44, or directly after them",
                "program a straight move, or G41 or G42 after G43 or G44",
            ));
            self.reached = None;
            out.push(Item::Path(moving));
        } else {
            let basis = moving.path.basis;
            let (start, end) = (basis.flat(&moving.path.start), basis.flat(&moving.path.motion.target));
            let further = match moving.wish.modal.reach {
                _ if !moving.is_plane_motion() => 0.0,
                Reach::End => 0.0,
                Reach::To => -moving.wish.distance_mm,
                Reach::Past => moving.wish.distance_mm,
            };
            let end = add(end, scaled(unit(sub(end, start)), further));
            let line = Curve::Line { start: basis.flat(&position), end };
            let moved = moving.along(&line, basis, position);
            self.reached = (further != 0.0).then(|| Box::new(moved.path.motion.target));
            out.push(Item::Path(Box::new(moved)));
        }
        None
    }

    /// Begins compensation with a contour element whose start the tool is already beside.
    fn begin_beside(&mut self, moving: Box<Moving>, position: AxisVector, findings: &mut Vec<Fault>) {
        findings.extend(doubtful(&moving));
        let basis = moving.path.basis;
        let beside = moving.wish.distance_mm;
        let mut active = Box::new(Active {
            basis,
            position,
            chain: super::chain::Chain::default(),
            guard: super::guard::Guard::default(),
            point: [0.0; 2],
            tangent: [1.0, 0.0],
            distance: beside,
            last: moving.clone(),
            approach: None,
        });
        if let Some(found) = active.objection(&moving) {
            findings.push(found);
        } else if let Some(contour) = moving.curve(&basis) {
            active.point = contour.start();
            active.tangent = contour.first_tangent();
            let wanted = add(active.point, scaled(left(active.tangent), beside));
            if distance(wanted, basis.flat(&position)) > NO_WAY_MM {
                findings.push(moving.fault(
                    Code::BAD_COMPENSATION,
                    "radius compensation begins after G43 or G44, but the tool is not beside the start of this element",
                    "end the motion with G43 or G44 perpendicular to the contour on the side of G41 or G42, or begin without G43 and G44",
                ));
            }
        }
        active.element(moving, &self.limits, findings);
        self.active = Some(active);
    }
}
