//! The stage: takes motions, and emits them once nothing can change them.

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
    pub(super) compensation: Compensation,
    between: Vec<Item>,
    /// Faults found so far.
    pub(in crate::exec) findings: Vec<Fault>,
}

impl ContourStage {
    /// Creates a stage; with `keeps_wear`, motions that begin and end compensation are marked for the control.
    pub(in crate::exec) fn new(control: &Control, keeps_wear: bool) -> ContourStage {
        ContourStage {
            open: None,
            transitions: Transitions::default(),
            compensation: Compensation::new(control, keeps_wear),
            between: Vec::new(),
            findings: Vec::new(),
        }
    }

    /// `true` if something is held, so that following items must wait.
    pub(in crate::exec) fn is_holding(&self) -> bool {
        self.open.is_some() || self.transitions.is_holding() || self.compensation.is_holding()
    }

    /// `true` if an element waits for the one after a rounding or chamfer.
    pub(super) fn holds_transition(&self) -> bool {
        self.transitions.is_holding()
    }

    /// Records a read access to the main run: the control looks no further ahead.
    pub(in crate::exec) fn stop(&mut self, origin: Origin, name: &'static str) {
        self.transitions.stop(origin, name);
    }

    /// Takes an item and emits those that are now final.
    pub(in crate::exec) fn take(&mut self, item: Item, out: &mut Vec<Item>) {
        let Some(item) = self.behind_open(item) else { return };
        self.transitions.take(item, &mut self.between, &mut self.findings);
        self.compensate(out);
    }

    /// Emits everything that is held: the program has ended, or must wait here.
    pub(in crate::exec) fn finish(&mut self, out: &mut Vec<Item>) {
        self.close(None, AxisSet::EMPTY, out);
        self.transitions.finish(&mut self.between, &mut self.findings);
        self.compensate(out);
        self.compensation.finish(out, &mut self.findings);
    }

    /// Handles a read of the axis positions by the control: emits what is held, and returns the tool center if it is beside the contour.
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

/// A motion whose end is not known yet, with the items after it.
#[derive(Debug)]
pub(super) struct OpenLine {
    pub(super) moving: Box<Moving>,
    pub(super) behind: Vec<Item>,
}
