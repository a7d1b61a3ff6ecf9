//! What radius compensation refuses.

use super::compensation::Active;
use super::curve::Curve;
use super::moving::{Item, Moving, same_plane};
use crate::exec::core::fault::Fault;
use crate::exec::core::path::Shape;
use ncfix_base::diagnostic::Code;
use ncfix_machine::snc::Manner;

impl Active {
    pub(super) fn too_many(&self) -> Fault {
        self.last.fault(
            Code::BAD_COMPENSATION,
            "too many blocks without motion in the plane follow this contour element",
            "move them off the contour; the limit is control.compensation_blocks_between",
        )
    }

    /// Whether a soft approach ends where the next motion ends.
    pub(super) fn awaits_end(&self) -> bool {
        self.approach.as_ref().is_some_and(|approach| approach.wish.soft.is_some() && !approach.names_plane())
    }

    /// The soft approach ends where this motion ends.
    pub(super) fn end_of_approach(&mut self, moving: &Moving) {
        if let Some(approach) = &mut self.approach {
            let motion = &mut approach.path.motion;
            motion.target = moving.path.motion.target;
            motion.named = motion.named.union(moving.path.motion.named);
            motion.known = motion.known.union(moving.path.motion.known);
            motion.feed = moving.path.motion.feed;
            self.last.clone_from(approach);
        }
        if moving.element.starts_block {
            self.chain.tail().push(Item::Element(moving.element.clone()));
        }
    }

    /// Why a motion in the plane cannot be part of the contour.
    pub(super) fn objection(&self, moving: &Moving) -> Option<Fault> {
        let (code, message, help) = if moving.path.setup.transform.is_some() {
            return Some(transformed(moving));
        } else if !moving.wish.compensates() && !same_plane(&self.basis, &moving.path.basis) {
            let help = "program a motion in the plane in the block of G40 or behind it, before the plane changes";
            let message = "radius compensation ends with the next motion behind G40, and the plane has changed or been mirrored before it";
            (Code::BAD_COMPENSATION, message, help)
        } else if !same_plane(&self.basis, &moving.path.basis) {
            let help = "end the compensation with G40 before plane, mirror or tilt change";
            (Code::BAD_COMPENSATION, "the working plane changes while radius compensation is on", help)
        } else if moving.path.motion.is_inverse_time() {
            let help = "program the feed with G94 or G95";
            (Code::NOT_SUPPORTED, "inverse-time feed (G93) under radius compensation", help)
        } else if moving.path.motion.in_machine_frame && !moving.wish.compensates() {
            let help = "program a motion in the plane in the block of G40 or behind it";
            let message = "machine coordinates directly behind G40: nothing has led the tool off the contour yet";
            (Code::BAD_COMPENSATION, message, help)
        } else if moving.path.motion.in_machine_frame {
            let help = "end it with G40 and a motion in the plane before G53, G153 or SUPA";
            (Code::BAD_COMPENSATION, "machine coordinates while radius compensation is on", help)
        } else if moving.path.motion.manner == Manner::Positioning {
            let help = "end it with G40 and a motion in the plane before POS";
            (Code::BAD_COMPENSATION, "an axis of the plane is positioned (POS) while radius compensation is on", help)
        } else if self.awaits_end() && !matches!(moving.path.shape, Shape::Line) {
            let help = "program a straight motion to the start of the contour";
            (Code::BAD_COMPENSATION, "the end of a soft approach that is not straight", help)
        } else if moving.wish.soft.is_some_and(|soft| soft.retracts == moving.wish.compensates()) {
            return Some(soft_alone(moving));
        } else if moving.wish.soft.is_some() && !moving.names_plane() {
            let help =
                "program the end in the plane in the block of the retraction (Sinumerik G148, G248, G348; Grundig G62)";
            (Code::NOT_SUPPORTED, "a soft retraction without an end in the plane", help)
        } else if moving.wish.soft.is_none() && moving.curve(&self.basis).is_none() {
            let help = "program lines and arcs, without unequal SCALE";
            (Code::NOT_SUPPORTED, "a curve that is no line or arc of the plane under radius compensation", help)
        } else {
            return None;
        };
        Some(moving.fault(code, message, help))
    }
}

pub(super) fn transformed(moving: &Moving) -> Fault {
    moving.fault(
        Code::NOT_SUPPORTED,
        "radius compensation under TRAORI is not supported: it is known for tools that stand upright on their plane",
        "program G41 and G42 behind TRAFOOF, or the way of the tool center",
    )
}

pub(super) fn no_contour(moving: &Moving) -> Fault {
    moving.fault(
        Code::BAD_COMPENSATION,
        "radius compensation begins here, and no contour follows",
        "program a motion in the plane behind it before G40 or the end",
    )
}

pub(super) fn soft_alone(moving: &Moving) -> Fault {
    moving.fault(
        Code::NOT_SUPPORTED,
        "a soft approach or retraction is supported where radius compensation begins or ends only",
        "program it where G41, G42 or G40 takes effect (Sinumerik G147, G247, G347 and G148, G248, G348; Grundig G61 and G62)",
    )
}

pub(super) fn polynomial(moving: &Moving) -> Fault {
    moving.fault(
        Code::NOT_SUPPORTED,
        "approach and retraction along a polynomial (KONTT, KONTC) are not supported",
        "use NORM or KONT",
    )
}

pub(super) fn too_narrow(moving: &Moving, contour: &Curve, beside: f64) -> Fault {
    let radius = if let Curve::Arc { radius, .. } = *contour { radius } else { 0.0 };
    moving.fault(
        Code::CONTOUR_NOT_FOLLOWED,
        format!(
            "this inner arc of radius {radius:.4} mm is too narrow for a tool center {:.4} mm beside it",
            beside.abs()
        ),
        "use a smaller tool, or a wider arc",
    )
}
