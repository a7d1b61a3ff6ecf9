//! Whether the axes can go where a program leads them, before any correction.

use super::findings::DiagnosticCollector;
use super::lost_axes;
use super::route::Route;
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXES, AxisSet, AxisVector, Vector};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, Kind, Manner, Move, Origin};

/// Looks at the moves of a program while it streams by.
#[derive(Debug)]
pub struct Reach<'a> {
    machine: &'a Machine,
    findings: DiagnosticCollector<'a>,
    standing: AxisVector,
    known: AxisSet,
}

impl<'a> Reach<'a> {
    /// Nothing is known yet, but where the axes stand, if the caller does (mm, rad).
    #[must_use]
    pub fn new(machine: &'a Machine, start: Option<AxisVector>) -> Reach<'a> {
        Reach {
            machine,
            findings: DiagnosticCollector::new(machine, f64::INFINITY),
            standing: start.unwrap_or(AxisVector::ZERO),
            known: start.map_or(AxisSet::EMPTY, |_| machine.axis_set()),
        }
    }

    /// Takes the next element; what was found by now: `E0302`, once a line.
    pub fn note(&mut self, element: &Element) -> impl Iterator<Item = Diagnostic> + '_ {
        self.known = self.known.difference(lost_axes(element, self.machine));
        if let Kind::Move(motion) = &element.kind {
            // The way to a reference point is that of the control.
            if motion.manner != Manner::Reference {
                self.look(&element.origin, motion);
            }
            self.standing = motion.target;
            self.known = motion.known;
        }
        self.findings.take()
    }

    fn look(&mut self, origin: &Origin, motion: &Move) {
        // Of an axis that comes from nobody knows where only the end tells.
        let mut start = motion.target;
        for axis in AXES.into_iter().filter(|&axis| self.known.contains(axis)) {
            start[axis] = self.standing[axis];
        }
        let route = Route::new(start, motion.target, motion.arc);
        self.findings.check(origin, motion.known, (&route, 1.0), &route, &Vector::zeros());
    }
}
