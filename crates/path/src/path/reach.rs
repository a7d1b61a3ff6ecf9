//! Checks that the programmed positions are within the travel of the axes, before any correction.

use super::findings::DiagnosticCollector;
use super::lost_axes;
use super::route::Route;
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXES, AxisSet, AxisVector, Vector};
use ncfix_machine::machine::{Kinematics, Machine, TipPath};
use ncfix_machine::snc::{Element, Kind, MotionMode, Move, Origin, Turning};

/// Checks the moves of a program from its stream.
#[derive(Debug)]
pub struct ReachScan<'a> {
    machine: &'a Machine,
    findings: DiagnosticCollector<'a>,
    standing: AxisVector,
    known: AxisSet,
    kinematics: Kinematics,
    tool_mm: Vector,
}

impl<'a> ReachScan<'a> {
    /// Starts a check; `start` is the known start position, if any (mm, rad).
    #[must_use]
    pub fn new(machine: &'a Machine, start: Option<AxisVector>) -> ReachScan<'a> {
        ReachScan {
            machine,
            findings: DiagnosticCollector::new(machine, f64::INFINITY),
            standing: start.unwrap_or(AxisVector::ZERO),
            known: start.map_or(AxisSet::EMPTY, |_| machine.axis_set()),
            kinematics: Kinematics::new(machine),
            tool_mm: Vector::zeros(),
        }
    }

    /// Checks the next element; returns the diagnostics so far: `E0302`, once per line.
    pub fn note(&mut self, element: &Element) -> impl Iterator<Item = Diagnostic> + '_ {
        self.known = self.known.difference(lost_axes(element, self.machine));
        if let Kind::Setup(setup) = &element.kind {
            self.tool_mm = setup.tool_mm;
            self.kinematics.set_head(self.machine, setup.head);
        }
        if let Kind::Move(motion) = &element.kind {
            // The path to a reference point is chosen by the control.
            if motion.motion_mode != MotionMode::Reference {
                self.look(&element.origin, motion);
            }
            self.standing = motion.target;
            self.known = motion.known;
        }
        self.findings.take()
    }

    fn look(&mut self, origin: &Origin, motion: &Move) {
        // For an axis whose start is unknown only the end is checked.
        let mut start = motion.target;
        for axis in AXES.into_iter().filter(|&axis| self.known.contains(axis)) {
            start[axis] = self.standing[axis];
        }
        let arc = motion.arc.map(|arc| (arc, motion.arc_basis));
        let route = match motion.tip {
            Some(turning) => {
                let follows_circle = turning == Turning::Vector;
                let tip = TipPath::new(&self.kinematics, follows_circle, [&start, &motion.target], &self.tool_mm);
                Route::of_tip(start, motion.target, arc, tip)
            }
            None => Route::new(start, motion.target, arc),
        };
        self.findings.check(origin, motion.known, (&route, 1.0), &route, &Vector::zeros());
    }
}
