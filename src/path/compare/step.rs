//! The moves of a program, one by one, with what has been stated before each.

use std::sync::Arc;

use super::super::route::Route;
use super::super::way::counts_turns;
use super::super::{Feeds, lost_axes};
use super::{CONTINUES, CONTINUES_ON_THE_SPOT, ON_THE_SPOT, ON_THE_SPOT_MM};
use crate::diagnostic::{Code, Diagnostic, Place};
use crate::geometry::{AxisSet, AxisVector, Vector};
use crate::machine::{Kinematics, Machine, State};
use crate::snc::{Element, FeedUnit, Kind, Origin, Setup, WordValue};

/// Half the step over which the sense of motion is looked up, as a parameter.
pub(super) const SENSE_STEP: f64 = 1e-4;

/// A move of one of the programs.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub(super) origin: Origin,
    pub(super) route: Route,
    pub(super) rapid: bool,
    pub(super) feed: f64,
    /// What it counts.
    pub(super) unit: FeedUnit,
    /// For which way it is.
    pub(super) feeds: Feeds,
    /// What the coordinates of the program mean.
    pub(super) setup: Arc<Setup>,
    /// Written as machine coordinates.
    pub(super) in_machine_frame: bool,
    pub(super) tool_mm: Vector,
    /// The tool word that stands above it.
    pub(super) tool: Option<Arc<WordValue>>,
    /// Sense of motion before the move.
    pub(super) state: State,
    /// Axes that were stated before it.
    pub(super) stated: AxisSet,
    pub(super) is_counted: bool,
    /// Whether it is marked as a further piece of the move above it.
    pub(super) continues: bool,
    /// Whether it is marked as a step on the spot.
    pub(super) on_the_spot: bool,
}

impl Step {
    /// Sense of motion at a parameter.
    pub(super) fn state_at(&self, parameter: f64) -> State {
        let mut state = self.state;
        let [before, behind] = [parameter - SENSE_STEP, parameter + SENSE_STEP].map(|place| self.route.at(place));
        state.note_stated(self.stated, &before, &behind);
        state
    }

    /// An axis command as this program would write it here: coordinates of the frame in force, of the tip in the workpiece under a transformation.
    pub(super) fn programmed(&self, command: &AxisVector, kinematics: &Kinematics) -> AxisVector {
        if self.in_machine_frame {
            let mut out = *command;
            out.set_xyz(out.xyz() + self.setup.tool_mm);
            return out;
        }
        let is_transformed = self.setup.transform.is_some();
        let position = if is_transformed { kinematics.on_workpiece(command, &self.setup.tool_mm) } else { *command };
        self.setup.programmed(&position)
    }

    /// Sense of motion before the end, where rounding does not turn an arc that ends at a turning point of an axis.
    pub(super) fn state_before_end(&self) -> State {
        let share = (ON_THE_SPOT_MM / self.route.size_mm().max(ON_THE_SPOT_MM)).clamp(SENSE_STEP, 0.5);
        self.state_at(1.0 - share)
    }

    pub(super) fn mismatch(&self, message: &str) -> Diagnostic {
        let place = Place { file: self.origin.file, span: self.origin.span };
        let help = "compare a program with what was made from it, on the same machine";
        Diagnostic::at(Code::CANNOT_ALIGN, place, message, help)
    }
}

/// The moves of a stream of elements.
pub(super) struct Walk<'a, I> {
    elements: I,
    machine: &'a Machine,
    feeds: Feeds,
    counts_turns: bool,
    has_backlash: bool,
    position: AxisVector,
    tool_mm: Vector,
    tool: Option<Arc<WordValue>>,
    setup: Arc<Setup>,
    state: State,
    known: AxisSet,
    ever_named: AxisSet,
    continues: bool,
    on_the_spot: bool,
}

impl<'a, I> Walk<'a, I> {
    pub(super) fn new(elements: I, machine: &'a Machine, feeds: Feeds, has_backlash: bool) -> Self {
        Walk {
            elements,
            machine,
            feeds,
            counts_turns: false,
            has_backlash,
            position: AxisVector::ZERO,
            tool_mm: Vector::zeros(),
            tool: None,
            setup: Arc::default(),
            state: State::default(),
            known: AxisSet::EMPTY,
            ever_named: AxisSet::EMPTY,
            continues: false,
            on_the_spot: false,
        }
    }
}

impl<I: Iterator<Item = Element>> Iterator for Walk<'_, I> {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        loop {
            let element = self.elements.next()?;
            if element.starts_block {
                // A mark belongs to its own line, which may move nothing.
                self.continues = false;
                self.on_the_spot = false;
            }
            let lost = lost_axes(&element, self.machine);
            self.known = self.known.difference(lost);
            self.state.forget(lost);
            let motion = match element.kind {
                Kind::Comment(text) => {
                    let text = text.strip_prefix(b";").or_else(|| text.strip_prefix(b"(")?.strip_suffix(b")"));
                    let is_one_of = |marks: [&str; 2]| marks.iter().any(|mark| text == Some(mark.as_bytes()));
                    self.continues = is_one_of([CONTINUES, CONTINUES_ON_THE_SPOT]);
                    self.on_the_spot = is_one_of([ON_THE_SPOT, CONTINUES_ON_THE_SPOT]);
                    continue;
                }
                Kind::Setup(setup) => {
                    self.tool_mm = setup.tool_mm;
                    self.setup = setup;
                    continue;
                }
                Kind::Tool(word) => {
                    self.tool = Some(Arc::new(word));
                    continue;
                }
                Kind::Verbatim(text) => {
                    self.counts_turns = counts_turns(&text, self.machine).unwrap_or(self.counts_turns);
                    continue;
                }
                Kind::Move(motion) => motion,
                _ => continue,
            };
            self.ever_named = self.ever_named.union(motion.named);
            let step = Step {
                origin: element.origin,
                route: Route::new(self.position, motion.target, motion.arc),
                rapid: motion.rapid,
                setup: Arc::clone(&self.setup),
                in_machine_frame: motion.in_machine_frame,
                feed: if motion.rapid { 0.0 } else { motion.feed },
                unit: motion.unit,
                feeds: if self.counts_turns { Feeds::OfAll } else { self.feeds },
                tool_mm: self.tool_mm,
                tool: self.tool.clone(),
                state: self.state,
                stated: self.known,
                is_counted: motion.named.difference(self.known).is_empty()
                    && self.ever_named.difference(motion.known).is_empty(),
                continues: std::mem::take(&mut self.continues),
                on_the_spot: std::mem::take(&mut self.on_the_spot),
            };
            if self.has_backlash {
                self.state.note_stated(self.known, &step.route.at(0.0), &step.route.at(SENSE_STEP));
                self.state.note_stated(self.known, &step.route.at(1.0 - SENSE_STEP), &motion.target);
            }
            self.position = motion.target;
            self.known = motion.known;
            return Some(step);
        }
    }
}
