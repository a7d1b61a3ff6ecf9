//! Rapid moves to machine positions (G53, G28, G30, SUPA, G153) directly after a lone G40, on a Fanuc, a Haas and a Sinumerik.
//!
//! After a lone G40 the tool stays perpendicular to the end of the last element, and the next motion in the plane ends the offset (Fanuc B-64604EN,
//! cutter compensation cancel without a movement; programming manual of the 840D sl, G40). A machine position has no offset: the named axes arrive where
//! the block says. No manual states whether the other axis of the plane then gives up its offset. It stays here until a rapid move names the plane;
//! cuts before that are refused.

use super::compensation::{Active, Compensation, Departed, Limits};
use super::contour_request::{Approach, Rules};
use super::curve::SAME_MM;
use super::moving::{Item, Moving, plane_axes, same_plane};
use crate::exec::core::fault::Fault;
use crate::exec::core::path::Shape;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, PlaneBasis};
use ncfix_machine::snc::{Kind, MotionMode, Word, WordValue};

impl Active {
    /// `true` if a motion leaves the contour straight for a machine position.
    pub(super) fn departs(&self, moving: &Moving, limits: &Limits) -> bool {
        let motion = &moving.path.motion;
        let is_home = motion.in_machine_frame && motion.rapid && matches!(moving.path.shape, Shape::Line);
        // The words of the control follow the wear only through a motion of the program.
        let is_free = self.approach.is_none() && moving.path.setup.transform.is_none() && !limits.keeps_wear;
        let is_principal =
            matches!(moving.path.basis, PlaneBasis::Principal(_)) && same_plane(&self.basis, &moving.path.basis);
        let modal = &moving.wish.modal;
        let is_straight = match modal.rules {
            Rules::Fanuc => true,
            Rules::Sinumerik => modal.approach == Approach::Norm && modal.leaves_along.is_none(),
            Rules::Rs274 | Rules::Grundig => false,
        };
        is_straight
            && motion.motion_mode != MotionMode::Positioning
            && !moving.wish.compensates()
            && moving.wish.soft.is_none()
            && is_home
            && is_free
            && is_principal
    }

    /// Emits everything and the motion. Returns the axes that it leaves beside the programmed position.
    pub(super) fn depart(
        mut self,
        mut moving: Box<Moving>,
        limits: &Limits,
        out: &mut Vec<Item>,
        findings: &mut Vec<Fault>,
    ) -> Option<Box<Departed>> {
        self.give_up(findings);
        self.end_pieces(limits, findings);
        self.flush(out);
        let position = self.position;
        let programmed = moving.path.start;
        let plane = plane_axes(&moving.path.basis);
        let motion = &mut moving.path.motion;
        let beside = plane.iter().filter(|&axis| (position[axis] - programmed[axis]).abs() > SAME_MM);
        let open = beside.collect::<AxisSet>().difference(motion.named);
        for axis in open.iter() {
            motion.target[axis] = position[axis];
        }
        let target = motion.target;
        moving.path.start = position;
        out.push(Item::Path(moving));
        (!open.is_empty()).then(|| Box::new(Departed { position: target, open, is_lost: false }))
    }
}

impl Compensation {
    /// Takes an item after such a move: axes beside the programmed position return to it with the next rapid move in the plane.
    pub(super) fn after_departure(&mut self, item: Item, findings: &mut Vec<Fault>) -> Item {
        let Some(mut departed) = self.departed.take() else { return item };
        let mut moving = match item {
            Item::Path(moving) => moving,
            Item::Element(element) => {
                // A tool change or a program of the control moves the axes itself.
                match &element.kind {
                    _ if departed.is_lost => {}
                    Kind::Lost(axes) => departed.open = departed.open.difference(*axes),
                    Kind::Before(words) | Kind::After(words) if words.iter().any(changes_tool) => {
                        return Item::Element(element);
                    }
                    _ => {}
                }
                self.departed = (!departed.open.is_empty()).then_some(departed);
                return Item::Element(element);
            }
        };
        if departed.is_lost {
            self.departed = departed.after_loss(&mut moving);
            return Item::Path(moving);
        }
        let motion = &mut moving.path.motion;
        let unnamed = departed.open.difference(motion.named);
        let is_line = matches!(moving.path.shape, Shape::Line);
        if !is_line || (!motion.rapid && !unnamed.is_empty()) {
            findings.push(beside(&moving, departed.open));
            return Item::Path(moving);
        }
        let ends = !motion.in_machine_frame
            && !motion.named.intersection(departed.open.union(plane_axes(&moving.path.basis))).is_empty();
        let motion = &mut moving.path.motion;
        for axis in departed.open.iter() {
            moving.path.start[axis] = departed.position[axis];
        }
        if ends {
            motion.named = motion.named.union(unnamed);
        } else if !unnamed.is_empty() {
            for axis in unnamed.iter() {
                motion.target[axis] = departed.position[axis];
            }
            self.departed = Some(Box::new(Departed { position: motion.target, open: unnamed, is_lost: false }));
        }
        Item::Path(moving)
    }
}

/// `true` for M6.
fn changes_tool(word: &Word) -> bool {
    word.letter == b'M'
        && word.extension.is_none()
        && matches!(word.value, WordValue::Number(number) if [6.0].contains(&number))
}

/// The fault for a cut that depends on an axis beside the programmed position.
fn beside(moving: &Moving, axes: AxisSet) -> Fault {
    let shown: Vec<String> = axes.iter().map(|axis| axis.to_string()).collect();
    let shown = shown.join(" and ");
    let message = format!(
        "a lone G40 and a machine position without {shown} precede this cut: whether {shown} still has the offset depends on the control"
    );
    moving.fault(Code::BAD_COMPENSATION, message, "move there at rapid, with all axes of the plane, before this block")
}
