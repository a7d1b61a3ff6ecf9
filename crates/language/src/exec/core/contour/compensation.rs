//! G41 and G42: the tool center path beside the contour.
//!
//! Contour elements are offset by the tool radius and joined: around outer corners by an arc or to the intersection, at inner corners by cutting both
//! back. The last pieces are held until no following element can change them.

use super::chain::Chain;
use super::check::{doubtful, no_contour, polynomial, soft_alone, too_narrow, wear_under_transformation};
use super::contour_request::Approach;
use super::contour_request::Rules;
use super::curve::{Curve, Flat, POINT_MM, SAME_MM, add, angle_between, cross, left, scaled, unit};
use super::guard::Guard;
use super::link::MOST_WAITING;
use super::link::{Link, Role, release_items};
use super::moving::Switch;
use super::moving::same_plane;
use super::moving::{Item, Moving, blocks_between, own_of};
use super::tracking::Tracking;
use super::unknown;
use crate::exec::core::fault::Fault;
use crate::exec::core::path::Shape;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, AxisVector, PlaneBasis};
use ncfix_machine::machine::Control;
use ncfix_machine::snc::MotionMode;

/// Change of direction below which there is no corner, rad.
pub(super) const NO_CORNER: f64 = 1e-7;
/// Misfit of two nominally tangential elements that may be rounding of the program, rad.
pub(super) const NEARLY_TANGENTIAL: f64 = 1e-2;

/// Limits of the control.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Change of direction above which G451 also goes around the corner, rad.
    pub(super) corner_rad: f64,
    /// Change of direction below which G450 also goes to the intersection, rad.
    pub(super) flat_rad: f64,
    pub(super) blocks_between: usize,
    pub(super) look_ahead: usize,
    /// `true` if the control compensates the tool center path again, by wear.
    pub(super) keeps_wear: bool,
}

impl Limits {
    pub(super) fn new(control: &Control, keeps_wear: bool) -> Limits {
        Limits {
            corner_rad: control.compensation_corner_rad,
            flat_rad: control.compensation_flat_rad,
            blocks_between: control.compensation_blocks_between as usize,
            look_ahead: control.compensation_look_ahead as usize,
            keeps_wear,
        }
    }

    /// Maximum number of elements left out if the tool is too wide for them; other controls stop there.
    pub(super) fn most_left_out(&self, rules: Rules) -> usize {
        if rules == Rules::Sinumerik { self.look_ahead } else { 0 }
    }
}

/// Radius compensation.
#[derive(Debug)]
pub(super) struct Compensation {
    pub(super) limits: Limits,
    pub(super) active: Option<Box<Active>>,
    /// State for the rules of RS274/NGC.
    pub(super) tracking: Option<Box<Tracking>>,
    /// G43, G44: the tool position beside the programmed end.
    pub(super) reached: Option<Box<AxisVector>>,
    /// A machine position directly after G40, or a lost position: the axes that are still beside the programmed position.
    pub(super) departed: Option<Box<Departed>>,
}

/// The tool after a machine position directly after a lone G40, or after it has lost its position there.
#[derive(Debug)]
pub(super) struct Departed {
    pub(super) position: AxisVector,
    /// Axes that are beside the programmed position.
    pub(super) open: AxisSet,
    /// `true` if only the machine knows where they are.
    pub(super) is_lost: bool,
}

/// State of active compensation.
#[derive(Debug)]
pub(super) struct Active {
    pub(super) basis: PlaneBasis,
    /// Tool center after the released items.
    pub(super) position: AxisVector,
    /// The motion that begins it, until the first contour element is known.
    pub(super) approach: Option<Box<Moving>>,
    pub(super) chain: Chain,
    /// Checks for bottlenecks.
    pub(super) guard: Guard,
    /// Of the last contour element: the motion, its end, its last tangent, the distance beside it.
    pub(super) last: Box<Moving>,
    pub(super) point: Flat,
    pub(super) tangent: Flat,
    pub(super) distance: f64,
}

impl Compensation {
    pub(super) fn new(control: &Control, keeps_wear: bool) -> Compensation {
        let limits = Limits::new(control, keeps_wear);
        Compensation { limits, active: None, tracking: None, reached: None, departed: None }
    }

    /// `true` if following items must wait or begin at another position than programmed.
    pub(super) fn is_holding(&self) -> bool {
        self.is_on() || self.reached.is_some() || self.departed.is_some()
    }

    /// `true` if the tool is beside the contour.
    pub(super) fn is_on(&self) -> bool {
        self.active.is_some() || self.tracking.is_some()
    }

    /// Takes an item and emits final ones.
    pub(super) fn take(&mut self, item: Item, out: &mut Vec<Item>, findings: &mut Vec<Fault>) {
        if let Item::Element(element) = &item
            && self.is_on()
        {
            findings.extend(unknown::under_compensation(element));
        }
        let item = if self.limits.keeps_wear { self.told(item, findings) } else { item };
        let Some(item) = self.track(item, out, findings) else { return };
        let Some(item) = self.reach(item, out, findings) else { return };
        self.end_by_loss(&item, out, findings);
        let item = self.after_departure(item, findings);
        let moving = match item {
            Item::Path(moving)
                if moving.is_plane_motion() || moving.goes_off_contour() || moving.wish.soft.is_some() =>
            {
                moving
            }
            other => {
                match &mut self.active {
                    Some(active) => active.hold(other, findings),
                    None => out.push(other),
                }
                return;
            }
        };
        match self.active.take() {
            None if !moving.wish.compensates() => {
                if moving.wish.soft.is_some() {
                    findings.push(soft_alone(&moving));
                }
                out.push(Item::Path(moving));
            }
            None => self.begin(moving, out, findings),
            Some(mut active) => {
                if active.departs(&moving, &self.limits) {
                    self.departed = active.depart(moving, &self.limits, out, findings);
                } else if let Some(found) = active.objection(&moving) {
                    findings.push(found);
                    active.flush(out);
                    out.push(Item::Path(moving));
                } else if active.awaits_end() {
                    active.end_of_approach(&moving);
                    self.active = Some(active);
                } else if moving.wish.compensates() {
                    active.element(moving, &self.limits, findings);
                    active.release(self.limits.look_ahead, out);
                    self.active = Some(active);
                } else {
                    active.retract(moving, &self.limits, out, findings);
                }
            }
        }
    }

    fn begin(&mut self, mut moving: Box<Moving>, out: &mut Vec<Item>, findings: &mut Vec<Fault>) {
        if moving.wish.soft.is_some_and(|soft| soft.retracts) {
            findings.push(soft_alone(&moving));
        }
        let is_wear = moving.path.setup.transform.is_some() && self.limits.keeps_wear;
        if let Some(found) = doubtful(&moving).or_else(|| is_wear.then(|| wear_under_transformation(&moving))) {
            findings.push(found);
            out.push(Item::Path(moving));
            return;
        }
        let found = if !matches!(moving.path.shape, Shape::Line) {
            Some("radius compensation begins in a block that is not a straight move")
        } else if moving.path.motion.in_machine_frame {
            Some("radius compensation begins in a block with machine coordinates")
        } else {
            None
        };
        if let Some(message) = found {
            findings.push(moving.fault(
                Code::BAD_COMPENSATION,
                message,
                "begin it with G0 or G1 to the start of the contour",
            ));
            out.push(Item::Path(moving));
            return;
        }
        if moving.wish.modal.approach == Approach::Polynomial {
            findings.push(polynomial(&moving));
        }
        if self.limits.keeps_wear {
            moving.switch = Switch::On;
        }
        self.active = Some(Box::new(Active {
            basis: moving.path.basis,
            position: moving.path.start,
            chain: Chain::default(),
            guard: Guard::default(),
            point: [0.0; 2],
            tangent: [1.0, 0.0],
            distance: moving.wish.distance_mm,
            last: moving.clone(),
            approach: Some(moving),
        }));
    }

    /// Ends compensation by the rules of RS274/NGC without a motion back to the contour: emits what is held, and returns the tool center if it is
    /// beside the contour.
    pub(super) fn settle(&mut self, out: &mut Vec<Item>, findings: &mut Vec<Fault>) -> Option<AxisVector> {
        self.no_wear_at_end(findings);
        let mut tracking = self.tracking.take()?;
        tracking.finish(out, findings);
        Some(tracking.position)
    }

    /// Emits everything that is held: the program has ended, or waits here.
    pub(super) fn finish(&mut self, out: &mut Vec<Item>, findings: &mut Vec<Fault>) {
        self.no_wear_at_end(findings);
        if let Some(tracking) = &mut self.tracking {
            tracking.finish(out, findings);
        }
        let Some(mut active) = self.active.take() else { return };
        if active.approach.is_some() {
            findings.push(no_contour(&active.last));
        } else {
            findings.push(active.last.fault(
                Code::COMPENSATION_LEFT_ON,
                "radius compensation is still on after the last contour element",
                "end it with G40 and a straight motion off the contour",
            ));
        }
        active.give_up(findings);
        active.end_pieces(&self.limits, findings);
        active.flush(out);
    }
}

impl Active {
    fn hold(&mut self, item: Item, findings: &mut Vec<Fault>) {
        self.chain.tail().push(item);
        if self.chain.tail().len() == MOST_WAITING {
            findings.push(self.too_many());
        } else if self.chain.tail().len() > MOST_WAITING {
            self.chain.tail().pop();
        }
    }

    /// The next contour element.
    pub(super) fn element(&mut self, moving: Box<Moving>, limits: &Limits, findings: &mut Vec<Fault>) {
        let Some(contour) = moving.curve(&self.basis) else { return };
        let beside = moving.wish.distance_mm;
        let own = own_of(self.chain.tail(), &moving.element);
        if blocks_between(&self.last.element, self.chain.tail()) > limits.blocks_between {
            findings.push(self.too_many());
        }
        let changes_side = self.distance * beside < 0.0;
        if !changes_side {
            self.guard.element(&self.basis, &moving, contour, limits.look_ahead, findings);
        }
        let count = findings.len();
        match contour.offset(beside).or_else(|| contour.point_of(beside)) {
            _ if self.is_point(&contour, beside) => {
                self.chain.tail().extend(own);
                self.chain.tail().push(Item::Path(moving.clone()));
            }
            None => {
                findings.push(too_narrow(&moving, &contour, beside));
                self.chain.tail().extend(own);
                self.chain.tail().push(Item::Path(moving.clone()));
            }
            Some(curve) => {
                let link = Link::new(Role::Contour, moving.clone(), contour, curve, beside);
                if let Some(approach) = self.approach.take() {
                    self.approach(approach, link, own, limits, findings);
                } else {
                    self.join(link, own, limits, findings);
                }
            }
        }
        if findings.iter().skip(count).any(|found| found.code == Code::CONTOUR_NOT_FOLLOWED) {
            self.guard.switch_off();
        }
        if changes_side {
            self.guard.element(&self.basis, &moving, contour, limits.look_ahead, findings);
        }
        self.chain.skip_bottlenecks(false, limits.look_ahead, findings);
        self.point = contour.end();
        self.tangent = contour.last_tangent();
        self.distance = beside;
        self.last = moving;
    }

    /// `true` for an inner arc with the tool radius that continues from the end of the last element.
    fn is_point(&self, contour: &Curve, beside: f64) -> bool {
        let Curve::Arc { radius, sweep, .. } = *contour else { return false };
        let is_smooth = angle_between(self.tangent, contour.first_tangent()) < NEARLY_TANGENTIAL;
        (radius - beside * sweep.signum()).abs() < POINT_MM && self.approach.is_none() && is_smooth
    }

    /// Joins an element to the previous one.
    fn join(&mut self, mut link: Link, own: Vec<Item>, limits: &Limits, findings: &mut Vec<Fault>) {
        let (beside, before) = (link.moving.wish.distance_mm, self.distance);
        let (d, e) = (self.tangent, link.contour.first_tangent());
        let bend = angle_between(d, e);
        let most = limits.most_left_out(link.moving.wish.modal.rules);
        if beside * before < 0.0 {
            self.check_side_change(&link, findings);
            self.give_up(findings);
            self.end_pieces(limits, findings);
            self.other_side(&link);
            self.chain.tail().extend(own);
            self.chain.push(link);
            return;
        }
        let (modal, last) = (link.moving.wish.modal, self.last.wish.modal);
        if modal.rules == Rules::Fanuc && modal.activation != last.activation {
            self.square(link, own, findings);
            return;
        }
        if (beside - before).abs() > SAME_MM {
            self.taper(&mut link, before, bend, findings);
        }
        let is_reversal = std::f64::consts::PI - bend < NO_CORNER;
        let is_outer = cross(d, e) * beside < 0.0 || is_reversal;
        if bend < NO_CORNER || beside.abs() < SAME_MM || (beside - before).abs() > SAME_MM {
            self.chain.tail().extend(own);
            self.chain.push_touching(link, most, findings);
            return;
        }
        // On the bisector, at the distance of the tool center from both elements.
        let middle = unit(add(left(d), left(e)));
        let tip = add(self.point, scaled(middle, beside / (bend / 2.0).cos().max(1e-9)));
        if !is_outer {
            self.chain.tail().extend(own);
            self.chain.cut_at(link, (bend < NEARLY_TANGENTIAL).then_some(tip), most, findings);
            return;
        }
        self.outer(link, own, tip, limits, findings);
    }

    /// Releases all pieces except the last ones, which may still change.
    pub(super) fn release(&mut self, look_ahead: usize, out: &mut Vec<Item>) {
        let first = std::mem::take(&mut self.chain.first_items);
        if self.approach.is_some() {
            self.chain.first_items = first;
            return;
        }
        release_items(first, self.basis, &mut self.position, out);
        while self.chain.elements() > look_ahead + 1 {
            let Some(link) = self.chain.links.pop_front() else { break };
            if !link.is_watched {
                self.guard.piece(&self.basis, &link, look_ahead);
            }
            link.release(self.basis, &mut self.position, out);
        }
    }

    /// Reports waiting elements without intersection.
    pub(super) fn give_up(&mut self, findings: &mut Vec<Fault>) {
        if self.chain.give_up(findings) {
            self.guard.switch_off();
        }
    }

    /// Ends the pieces: checks the held ones too.
    pub(super) fn end_pieces(&mut self, limits: &Limits, findings: &mut Vec<Fault>) {
        self.chain.skip_bottlenecks(true, limits.look_ahead, findings);
        for link in &mut self.chain.links {
            if !std::mem::replace(&mut link.is_watched, true) {
                self.guard.piece(&self.basis, link, limits.look_ahead);
            }
        }
        self.guard.end(findings);
    }

    /// Emits everything unchanged.
    pub(super) fn flush(&mut self, out: &mut Vec<Item>) {
        if let Some(approach) = self.approach.take() {
            self.position = approach.path.motion.target;
            out.push(Item::Path(approach));
        }
        let first = std::mem::take(&mut self.chain.first_items);
        release_items(first, self.basis, &mut self.position, out);
        let waiting = std::mem::take(&mut self.chain.waiting);
        for link in self.chain.links.drain(..).chain(waiting) {
            link.release(self.basis, &mut self.position, out);
        }
    }
}

impl Active {
    pub(super) fn too_many(&self) -> Fault {
        self.last.fault(
            Code::BAD_COMPENSATION,
            "too many blocks without motion in the plane follow this contour element",
            "move them out of the contour; the limit is control.compensation_blocks_between",
        )
    }

    /// `true` if a soft approach ends at the end of the next motion.
    pub(super) fn awaits_end(&self) -> bool {
        self.approach.as_ref().is_some_and(|approach| approach.wish.soft.is_some() && !approach.names_plane())
    }

    /// Sets the end of the soft approach to the end of this motion.
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

    /// The fault for a motion in the plane that cannot be part of the contour.
    pub(super) fn objection(&self, moving: &Moving) -> Option<Fault> {
        if same_plane(&self.basis, &moving.path.basis)
            && let Some(found) = doubtful(moving)
        {
            return Some(found);
        }
        let (code, message, help) = if !moving.wish.compensates() && !same_plane(&self.basis, &moving.path.basis) {
            let help = "program a motion in the plane in the block of G40 or after it, before the plane changes";
            let message = "radius compensation ends with the next motion after G40, but the plane is changed or mirrored before it";
            (Code::BAD_COMPENSATION, message, help)
        } else if !same_plane(&self.basis, &moving.path.basis) {
            let help = "end the compensation with G40 before plane, mirror or tilt change";
            (Code::BAD_COMPENSATION, "the working plane changes while radius compensation is on", help)
        } else if moving.path.motion.is_inverse_time() {
            let help = "program the feed with G94 or G95";
            (Code::NOT_SUPPORTED, "inverse-time feed (G93) under radius compensation", help)
        } else if moving.path.motion.in_machine_frame && !moving.wish.compensates() {
            let help = "program a motion in the plane in the block of G40 or after it";
            let message = "machine coordinates directly after G40: the tool has not left the contour yet";
            (Code::BAD_COMPENSATION, message, help)
        } else if moving.path.motion.in_machine_frame {
            let help = "end it with G40 and a motion in the plane before G53, G153 or SUPA";
            (Code::BAD_COMPENSATION, "machine coordinates while radius compensation is on", help)
        } else if moving.path.motion.motion_mode == MotionMode::Positioning {
            let help = "end it with G40 and a motion in the plane before POS";
            (Code::BAD_COMPENSATION, "an axis of the plane is positioned (POS) while radius compensation is on", help)
        } else if self.awaits_end() && !matches!(moving.path.shape, Shape::Line) {
            let help = "program a straight motion to the start of the contour";
            (Code::BAD_COMPENSATION, "the end of a soft approach is not a straight move", help)
        } else if moving.wish.soft.is_some_and(|soft| soft.retracts == moving.wish.compensates()) {
            return Some(soft_alone(moving));
        } else if moving.wish.soft.is_some() && !moving.names_plane() {
            let help =
                "program the end in the plane in the block of the retraction (Sinumerik G148, G248, G348; Grundig G62)";
            (Code::NOT_SUPPORTED, "a soft retraction without an end in the plane", help)
        } else if moving.wish.soft.is_none() && moving.curve(&self.basis).is_none() {
            let help = "program lines and arcs, without unequal SCALE";
            (Code::NOT_SUPPORTED, "a curve that is not a line or arc in the plane, under radius compensation", help)
        } else {
            return None;
        };
        Some(moving.fault(code, message, help))
    }
}
