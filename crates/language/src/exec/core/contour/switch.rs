//! Words for the control in motions at the start or end of radius compensation: the control compensates wear alone.
//!
//! The tool center path ends perpendicular to the first contour element and begins perpendicular to the last one. A control that compensates it again
//! by a small radius therefore offsets all of it: an offset curve of an offset curve.

use super::compensation::Compensation;
use super::contour_request::Shown;
use super::contour_request::Side;
use super::contour_request::{Reach, Rules};
use super::curve::SAME_MM;
use super::moving::Switch;
use super::moving::{Item, Moving};
use super::tracking::Held;
use crate::exec::core::fault::Fault;
use crate::exec::core::path::Shape;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AXES, AxisSet};
use ncfix_machine::snc::Kind;

/// Length of the part of a motion to the contour in which the control applies its radius, mm. It is one output piece, so that there is no corner
/// between it and the contour.
const LEAD_MM: f64 = 5.0;

impl Moving {
    /// The compensation words of the motion.
    pub(in crate::exec) fn switch_words(&self) -> Option<String> {
        let modal = &self.wish.modal;
        let word = match self.switch {
            Switch::None => return None,
            Switch::Off => return Some("G40".to_owned()),
            Switch::On if (modal.side == Side::Right) == (modal.shown == Shown::Mirrored) => "G41",
            Switch::On => "G42",
        };
        Some(match (modal.rules, modal.register) {
            // The path onto the contour and around its outer corners is already complete. Via intersections it is the offset path for any wear, at
            // inner corners also for a negative wear.
            (Rules::Sinumerik, _) => format!("{word} NORM G451 {}", if modal.collision { "CDON" } else { "CDOF" }),
            (_, Some(register)) => format!("{word} D{register}"),
            (_, None) => word.to_owned(),
        })
    }

    /// The parts of a motion before and after the compensation word: nothing before it, or a long path that the control executes without
    /// compensation.
    pub(in crate::exec) fn parted(self: Box<Self>) -> (Option<Box<Moving>>, Box<Moving>, Option<Box<Moving>>) {
        let way = (self.path.motion.target - self.path.start).xyz().norm();
        let is_long = way > 2.0 * LEAD_MM && matches!(self.path.shape, Shape::Line) && !self.path.motion.rapid;
        // An intermediate position is known only if both ends are.
        let (start, target) = (&self.path.start, &self.path.motion.target);
        let moving: AxisSet = AXES.into_iter().filter(|&axis| start[axis] != target[axis]).collect();
        let is_known = moving.union(self.path.motion.named).difference(self.path.start_known).is_empty();
        if !is_long || !is_known {
            return (None, self, None);
        }
        let share = if self.switch == Switch::On { 1.0 - LEAD_MM / way } else { LEAD_MM / way };
        let between = self.path.start.lerp(&self.path.motion.target, share);
        let (mut behind, mut before) = (Box::new(self.further()), self);
        behind.path.start = between;
        before.path.motion.target = between;
        if before.switch == Switch::On { (Some(before), behind, None) } else { (None, before, Some(behind)) }
    }

    /// The fault for compensation that cannot be left to the control.
    pub(super) fn no_wear(&self, message: &str, help: &str) -> Fault {
        self.fault(Code::NO_WEAR, format!("{message}: not possible with --compensation wear"), help)
    }
}

impl Compensation {
    /// Rejects or replaces items that the control must not see, or cannot follow with wear alone.
    pub(super) fn told(&self, mut item: Item, findings: &mut Vec<Fault>) -> Item {
        match &mut item {
            // The motion off the contour carries the word.
            Item::Element(element) if self.is_on() && element.kind == Kind::Keep("G40") => element.kind = Kind::Empty,
            Item::Element(_) => {}
            Item::Path(moving) => findings.extend(self.no_wear_for(moving)),
        }
        item
    }

    fn no_wear_for(&self, moving: &Moving) -> Option<Fault> {
        let modal = &moving.wish.modal;
        let again = |last: u32| moving.wish.compensates() && modal.activation != last;
        let is_rs274 = modal.rules == Rules::Rs274;
        if modal.reach != Reach::End {
            let help = "program G41 or G42 with the motion to the contour";
            return Some(moving.no_wear("G43 and G44 shift the end position by the radius only", help));
        }
        if !moving.wish.compensates() {
            return None;
        }
        if modal.shown == Shown::Other {
            let help = "program the contour in a plane of the work offset";
            return Some(
                moving.no_wear("the plane of the contour is tilted, but the output has no tilted plane", help),
            );
        }
        if is_rs274 && modal.register.is_none() {
            let help = "program G41 or G42 with the number of a tool";
            return Some(moving.no_wear("G41.1 and G42.1 have the diameter in the program, not in a register", help));
        }
        if is_rs274 && moving.wish.distance_mm == 0.0 && modal.register != Some(0) {
            let help = "give the tool its radius in the machine file, or with --setup";
            return Some(moving.no_wear("radius compensation with a tool of radius 0", help));
        }
        let changes = match (&self.active, &self.tracking) {
            (Some(active), _) => {
                let is_other = (moving.wish.distance_mm - active.distance).abs() > SAME_MM;
                is_other
                    || modal.register != active.last.wish.modal.register
                    || again(active.last.wish.modal.activation)
            }
            (None, Some(tracking)) => again(tracking.activation),
            (None, None) => false,
        };
        let help = "end it with G40 and a straight motion off the contour, then begin it again";
        changes.then(|| {
            moving.no_wear("radius compensation is repeated, or its side or radius changes while it is on", help)
        })
    }

    /// Reports a program end or a position read without a motion off the contour.
    pub(super) fn no_wear_at_end(&self, findings: &mut Vec<Fault>) {
        let held = self.tracking.as_ref().and_then(|tracking| {
            tracking.held.iter().find_map(|held| if let Held::Piece(piece) = held { Some(&piece.moving) } else { None })
        });
        let last = self.active.as_ref().map(|active| &active.last).or(held);
        if let Some(last) = last.filter(|_| self.limits.keeps_wear) {
            let help = "program G40 and a straight motion off the contour";
            findings.push(last.no_wear("no motion leaves the contour after this element", help));
        }
    }
}
