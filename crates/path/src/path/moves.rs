//! The straight moves of a program with the largest bend, as lines for trials of a fixed step.

use ncfix_base::geometry::{AxisSet, AxisVector, Vector};
use ncfix_machine::machine::{Kinematics, Machine};
use ncfix_machine::snc::{Element, Kind, MotionMode, Move};

use super::findings::placing_axes;
use super::lost_axes;
use super::steps::{LineOfTip, StepTrial, StraightLine};

/// Maximum number of kept moves, those with the largest bend: memory and time stay bounded for any program length.
const MOST_KEPT: usize = 2000;

/// Collects the feed moves of a program from its stream.
pub struct Moves<'a> {
    machine: &'a Machine,
    trial: StepTrial<'a>,
    /// Tool vector that replaces that of the program.
    fixed_tool_mm: Option<Vector>,
    placing: AxisSet,
    standing: AxisVector,
    known: AxisSet,
    tool_mm: Vector,
    kinematics: Kinematics,
    kept: Vec<(f64, StraightLine)>,
    /// Straight moves with feed.
    pub lines: u64,
    /// Arcs with feed, which are divided by the tolerance and not examined.
    pub arcs: u64,
}

impl<'a> Moves<'a> {
    /// An empty collection. Without `fixed_tool_mm` each move uses the tool of the program.
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
            kinematics: Kinematics::new(machine),
            kept: Vec::new(),
            lines: 0,
            arcs: 0,
        }
    }

    /// Sets a known start position.
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

    /// `true` if a move is cut by a fixed step: with feed, along a path, between known positions.
    fn is_looked_at(&self, motion: &Move) -> bool {
        let is_known =
            motion.named.difference(self.known).is_empty() && self.placing.difference(motion.known).is_empty();
        !motion.rapid && motion.motion_mode == MotionMode::Path && is_known
    }

    fn take(&mut self, element: &Element, motion: &Move) {
        if motion.arc.is_some() {
            self.arcs += 1;
            return;
        }
        self.lines += 1;
        let tip = motion.tip.map(|turning| LineOfTip { turning, tool_mm: self.tool_mm });
        let tool_mm = self.fixed_tool_mm.unwrap_or(self.tool_mm);
        let ends = [self.standing, motion.target];
        let line = StraightLine::new(ends, tip, &self.kinematics, tool_mm, Some(element.origin));
        let bend_mm = self.trial.bend_mm(&line);
        self.kept.push((bend_mm, line));
        if self.kept.len() >= 2 * MOST_KEPT {
            self.trim();
        }
    }

    fn trim(&mut self) {
        // Stable, so that the first of equal moves stay.
        self.kept.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.kept.truncate(MOST_KEPT);
    }

    /// The lines, largest bend first, and the trial for further use.
    #[must_use]
    pub fn finish(mut self) -> (Vec<StraightLine>, StepTrial<'a>) {
        self.trim();
        (self.kept.into_iter().map(|(_, line)| line).collect(), self.trial)
    }
}
