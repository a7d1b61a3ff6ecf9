//! The straight moves of a program that bend most, as lines on which a fixed step is tried.

use ncfix_base::geometry::{AxisSet, AxisVector, Vector};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, Kind, Manner, Move};

use super::findings::placing_axes;
use super::lost_axes;
use super::route::Route;
use super::steps::{Line, StepTrial};

/// Moves that are kept, those that bend most: memory and time stay bounded however long the program is.
const MOST_KEPT: usize = 2000;

/// Gathers the moves with feed of a program while it streams by.
pub struct Moves<'a> {
    machine: &'a Machine,
    trial: StepTrial<'a>,
    /// The tool to be used whatever the program says.
    fixed_tool_mm: Option<Vector>,
    placing: AxisSet,
    standing: AxisVector,
    known: AxisSet,
    tool_mm: Vector,
    kept: Vec<(f64, Line)>,
    /// Straight moves with feed.
    pub lines: u64,
    /// Arcs with feed, which are cut by the tolerance and not looked at.
    pub arcs: u64,
}

impl<'a> Moves<'a> {
    /// Nothing yet. Without `fixed_tool_mm` each move has the tool that the program gives it.
    #[must_use]
    pub fn new(machine: &'a Machine, trial: StepTrial<'a>, fixed_tool_mm: Option<Vector>) -> Moves<'a> {
        Moves {
            machine,
            trial,
            fixed_tool_mm,
            placing: placing_axes(machine),
            standing: AxisVector::ZERO,
            known: AxisSet::EMPTY,
            tool_mm: Vector::zeros(),
            kept: Vec::new(),
            lines: 0,
            arcs: 0,
        }
    }

    /// The machine stands at a position that is known.
    pub fn start_at(&mut self, start: AxisVector) {
        self.standing = start;
        self.known = self.machine.axis_set();
    }

    /// Takes the next element.
    pub fn note(&mut self, element: &Element) {
        match &element.kind {
            Kind::Move(motion) => {
                if self.is_looked_at(motion) {
                    self.take(element, motion);
                }
                self.standing = motion.target;
                self.known = motion.known;
            }
            Kind::Setup(setup) => self.tool_mm = setup.tool_mm,
            _ => self.known = self.known.difference(lost_axes(element, self.machine)),
        }
    }

    /// Whether a move is cut by a fixed step: with feed, along a path, between places that are known.
    fn is_looked_at(&self, motion: &Move) -> bool {
        let is_known =
            motion.named.difference(self.known).is_empty() && self.placing.difference(motion.known).is_empty();
        !motion.rapid && motion.manner == Manner::Path && is_known
    }

    fn take(&mut self, element: &Element, motion: &Move) {
        if motion.arc.is_some() {
            self.arcs += 1;
            return;
        }
        self.lines += 1;
        let route = Route::new(self.standing, motion.target, None);
        let line = Line::new(route, self.fixed_tool_mm.unwrap_or(self.tool_mm), Some(element.origin));
        let bend_mm = self.trial.bend_mm(&line);
        self.kept.push((bend_mm, line));
        if self.kept.len() >= 2 * MOST_KEPT {
            self.trim();
        }
    }

    fn trim(&mut self) {
        // Stable, so that of equal moves the first stay.
        self.kept.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.kept.truncate(MOST_KEPT);
    }

    /// The lines, those that bend most first, and the trial to go on with.
    #[must_use]
    pub fn finish(mut self) -> (Vec<Line>, StepTrial<'a>) {
        self.trim();
        (self.kept.into_iter().map(|(_, line)| line).collect(), self.trial)
    }
}
