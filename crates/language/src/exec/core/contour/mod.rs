//! The contour stage: holds motions back until what follows them is known.
//!
//! First [`transition`] puts roundings and chamfers between contour elements, then [`compensation`] moves them sideways by the radius
//! of the tool. Motions that nothing changes pass through at once. While one is held, the elements behind it wait with it, so that
//! the order of the stream stays that of the program.

mod angle;
mod approach;
#[cfg(test)]
mod bench;
mod chain;
mod check;
mod compensation;
mod corner;
mod curve;
mod gap;
mod guard;
mod link;
mod moving;
mod reach;
mod rs274;
#[cfg(test)]
mod rs274_tests;
mod rules;
mod soft;
#[cfg(test)]
mod stage_tests;
mod switch;
mod tracking;
mod transition;
mod unknown;
mod wish;

pub(in crate::exec) use angle::crossing;
pub(in crate::exec) use moving::{Item, Moving};
pub(in crate::exec) use rules::Reach;
pub(in crate::exec) use switch::Shown;
pub(in crate::exec) use unknown::unstated;
pub(in crate::exec) use wish::{
    Approach, Clearance, ContourModal, Corner, FeedAt, Side, Soft, SoftForm, SoftSide, Transition, Wish,
};

use super::fault::Fault;
use angle::OpenLine;
use compensation::Compensation;
use ncfix_base::geometry::{AxisSet, AxisVector};
use ncfix_machine::machine::Control;
use ncfix_machine::snc::Origin;
use transition::Transitions;

/// The stage.
#[derive(Debug)]
pub(super) struct Contour {
    open: Option<OpenLine>,
    transitions: Transitions,
    compensation: Compensation,
    between: Vec<Item>,
    /// What was found.
    pub(super) findings: Vec<Fault>,
}

impl Contour {
    /// With `keeps_wear` motions that begin and end compensation are marked for the control.
    pub(super) fn new(control: &Control, keeps_wear: bool) -> Contour {
        Contour {
            open: None,
            transitions: Transitions::default(),
            compensation: Compensation::new(control, keeps_wear),
            between: Vec::new(),
            findings: Vec::new(),
        }
    }

    /// Whether something is held, so that whatever comes must wait behind it.
    pub(super) fn is_holding(&self) -> bool {
        self.open.is_some() || self.transitions.is_holding() || self.compensation.is_holding()
    }

    /// A block reads what the control knows only when it has got there: it looks no further ahead.
    pub(super) fn stop(&mut self, origin: Origin, name: &'static str) {
        self.transitions.stop(origin, name);
    }

    /// Takes an item and gives those that are final now.
    pub(super) fn take(&mut self, item: Item, out: &mut Vec<Item>) {
        let Some(item) = self.behind_open(item) else { return };
        self.transitions.take(item, &mut self.between, &mut self.findings);
        self.compensate(out);
    }

    /// Gives everything that is held: the program has ended, or must wait here.
    pub(super) fn finish(&mut self, out: &mut Vec<Item>) {
        self.close(None, AxisSet::EMPTY, out);
        self.transitions.finish(&mut self.between, &mut self.findings);
        self.compensate(out);
        self.compensation.finish(out, &mut self.findings);
    }

    /// The control looks where the axes are: gives what is held, and where the tool center is if it is beside the contour.
    pub(super) fn settle(&mut self, out: &mut Vec<Item>) -> Option<AxisVector> {
        self.transitions.finish(&mut self.between, &mut self.findings);
        self.compensate(out);
        self.compensation.settle(out, &mut self.findings)
    }

    fn compensate(&mut self, out: &mut Vec<Item>) {
        for item in self.between.drain(..) {
            self.compensation.take(item, out, &mut self.findings);
        }
    }
}
