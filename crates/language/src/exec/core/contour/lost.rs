//! A lone G40 after which the axes lose their position, as at a tool change.
//!
//! The compensation ends with the next motion in the plane, and only the machine knows where that begins. Nothing of the old contour decides about it:
//! the motion goes from there to its programmed end (Haas mill operator's manual, cutter compensation: without a motion in X and Y, the change waits for
//! the next one). Motions that name no axis of the plane stay as they are. One that names only one of its axes is not accepted: the control may end the offset
//! of the other one there.

use super::compensation::{Active, Compensation, Departed};
use super::contour_request::{ContourRequest, Reach};
use super::moving::{Item, Moving, plane_axes};
use super::stage::ContourStage;
use crate::exec::core::fault::Fault;
use crate::exec::core::path::Path;
use ncfix_base::geometry::AxisSet;

impl ContourStage {
    /// `true` for a motion after a lone G40 that does not depend on the position in the plane, because that was lost between them.
    pub(in crate::exec) fn ends_by_loss(&self, path: &Path, wish: &ContourRequest) -> bool {
        self.open.is_none() && !self.holds_transition() && self.compensation.ends_by_loss(path, wish)
    }
}

impl Compensation {
    fn ends_by_loss(&self, path: &Path, wish: &ContourRequest) -> bool {
        let is_plain = !wish.compensates()
            && wish.modal.reach == Reach::End
            && wish.corner.is_none()
            && wish.soft.is_none()
            && !self.limits.keeps_wear;
        let departed = self.departed.as_ref().filter(|departed| departed.is_lost).map(|departed| departed.open);
        let open = departed.or_else(|| self.active.as_ref().and_then(|active| active.loses(path)));
        is_plain && open.is_some_and(|open| is_clear(path, open))
    }

    /// Ends the contour before such a motion.
    pub(super) fn end_by_loss(&mut self, item: &Item, out: &mut Vec<Item>, findings: &mut Vec<Fault>) {
        let Item::Path(moving) = item else { return };
        if !self.ends_by_loss(&moving.path, &moving.wish) {
            return;
        }
        let Some(mut active) = self.active.take() else { return };
        active.give_up(findings);
        active.end_pieces(&self.limits, findings);
        active.flush(out);
        let open = plane_axes(&active.basis);
        self.departed = Some(Box::new(Departed { position: active.position, open, is_lost: true }));
    }
}

/// `true` for a motion that names no axis of the plane, or all axes that may still have an offset.
fn is_clear(path: &Path, open: AxisSet) -> bool {
    let named = path.motion.named;
    let is_beside = named.intersection(plane_axes(&path.basis)).is_empty();
    is_beside || path.motion.in_machine_frame && path.motion.rapid || open.difference(named).is_empty()
}

impl Active {
    /// The axes of the plane if their position was known at the last contour element and is unknown at the start of a motion.
    fn loses(&self, path: &Path) -> Option<AxisSet> {
        let plane = plane_axes(&self.basis);
        let was_known = plane.difference(self.last.path.motion.known).is_empty();
        let is_lost = self.approach.is_none() && was_known && plane.intersection(path.start_known).is_empty();
        is_lost.then_some(plane)
    }
}

impl Departed {
    /// Takes a motion after the loss; `None` once the offset has ended. An executor that refuses unknown positions has refused all other motions.
    pub(super) fn after_loss(mut self: Box<Self>, moving: &mut Moving) -> Option<Box<Departed>> {
        let unnamed = self.open.difference(moving.path.motion.named);
        if moving.path.motion.in_machine_frame {
            self.open = unnamed;
        } else if moving.names_plane() {
            moving.path.motion.named = moving.path.motion.named.union(unnamed);
            return None;
        }
        (!unnamed.is_empty()).then_some(self)
    }
}
