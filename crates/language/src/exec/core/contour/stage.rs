//! The stage itself: motions go in, and come out where nothing can change them any more.

use super::compensation::Compensation;
use super::moving::{Item, Moving};
use super::transition::Transitions;
use crate::exec::core::fault::Fault;
use ncfix_base::geometry::{AxisSet, AxisVector};
use ncfix_machine::machine::Control;
use ncfix_machine::snc::Origin;

/// The stage.
#[derive(Debug)]
pub(in crate::exec) struct ContourStage {
    pub(super) open: Option<OpenLine>,
    transitions: Transitions,
    compensation: Compensation,
    between: Vec<Item>,
    /// What was found.
    pub(in crate::exec) findings: Vec<Fault>,
}

impl ContourStage {
    /// With `keeps_wear` motions that begin and end compensation are marked for the control.
    pub(in crate::exec) fn new(control: &Control, keeps_wear: bool) -> ContourStage {
        ContourStage {
            open: None,
            transitions: Transitions::default(),
            compensation: Compensation::new(control, keeps_wear),
            between: Vec::new(),
            findings: Vec::new(),
        }
    }

    /// Whether something is held, so that whatever comes must wait behind it.
    pub(in crate::exec) fn is_holding(&self) -> bool {
        self.open.is_some() || self.transitions.is_holding() || self.compensation.is_holding()
    }

    /// A block reads what the control knows only when it has got there: it looks no further ahead.
    pub(in crate::exec) fn stop(&mut self, origin: Origin, name: &'static str) {
        self.transitions.stop(origin, name);
    }

    /// Takes an item and gives those that are final now.
    pub(in crate::exec) fn take(&mut self, item: Item, out: &mut Vec<Item>) {
        let Some(item) = self.behind_open(item) else { return };
        self.transitions.take(item, &mut self.between, &mut self.findings);
        self.compensate(out);
    }

    /// Gives everything that is held: the program has ended, or must wait here.
    pub(in crate::exec) fn finish(&mut self, out: &mut Vec<Item>) {
        self.close(None, AxisSet::EMPTY, out);
        self.transitions.finish(&mut self.between, &mut self.findings);
        self.compensate(out);
        self.compensation.finish(out, &mut self.findings);
    }

    /// The control looks where the axes are: gives what is held, and where the tool center is if it is beside the contour.
    pub(in crate::exec) fn settle(&mut self, out: &mut Vec<Item>) -> Option<AxisVector> {
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

/// A motion whose end is not known yet, and what stands behind it.
#[derive(Debug)]
pub(super) struct OpenLine {
    pub(super) moving: Box<Moving>,
    pub(super) behind: Vec<Item>,
}
