//! The moves of a program, one by one, with the state before each.

use std::cell::RefCell;
use std::f64::consts::TAU;
use std::rc::Rc;
use std::sync::Arc;

use super::super::lead::Lead;
use super::super::route::Route;
use super::super::sampling::LedPath;
use super::super::segment_candidate::SAME_PLACE_MM;
use super::super::staying::is_better_whole;
use super::super::way::counts_turns;
use super::super::{Feeds, lost_axes};
use super::acts::{Act, Acts, Passing};
use super::{CONTINUES, CONTINUES_ON_THE_SPOT, ON_THE_SPOT};
use ncfix_base::geometry::{AXES, Axis, AxisSet, AxisVector, Plane, Vector};
use ncfix_machine::machine::{Kinematics, Machine, TipPath};
use ncfix_machine::snc::{
    BlockNumber, Element, FeedUnit, HoleTrigger, Kind, MotionMode, Move, Origin, Setup, Turning, WordValue,
};
use ncfix_model::{DeadBand, Model};

/// More than a plausible correction of a position, mm: the last rapid move before a hole may be as programmed.
const MOST_CORRECTION_MM: f64 = 1.0;
/// More than the change of a correction over [`MOST_CORRECTION_MM`], mm: the tool comes from a place with another one.
const MOST_CHANGE_MM: f64 = 0.1;
/// Share of a move at its end that determines its final direction.
const NEAR_END: f64 = 1e-4;
/// Weight of rotary axes in directions, mm per rad.
const TURN_ARM_MM: f64 = 100.0;
/// Cosine of the largest angle between pieces of a curve: 60°. Chords of curves turn by far less, reversals and corners by more.
const SAME_WAY: f64 = 0.5;

/// Range before the end of a turn in which the first position of a modulo axis counts as below 0°, rad. It is larger than a correction: a corrected 0° that
/// is written as 359.998° is then beside the original one.
const BELOW_ZERO_RAD: f64 = 2e-3;

/// A move of one of the programs.
#[derive(Clone, Debug)]
pub(super) struct ComparedMove<'a> {
    pub(super) origin: Origin,
    pub(super) route: Route<'a>,
    pub(super) rapid: bool,
    pub(super) feed: f64,
    /// Unit of the feed.
    pub(super) unit: FeedUnit,
    /// The path to which the feed refers.
    pub(super) feeds: Feeds,
    /// Meaning of the program's coordinates.
    pub(super) setup: Arc<Setup>,
    /// `true` if written in machine coordinates.
    pub(super) in_machine_frame: bool,
    pub(super) tool_mm: Vector,
    /// The active tool word.
    pub(super) tool: Option<Arc<WordValue>>,
    /// Positions of the axes in their dead bands before the move.
    pub(super) band: DeadBand,
    /// Axes that were stated before it.
    pub(super) stated: AxisSet,
    pub(super) is_counted: bool,
    /// `true` if marked as a further piece of the move above it.
    pub(super) continues: bool,
    /// `true` if marked as a step on the spot.
    pub(super) on_the_spot: bool,
    /// `true` for a move of a drilling cycle, or to its hole.
    pub(super) in_cycle: bool,
    /// `true` if it leads a tool that is nearly at a hole to the place of its call. The other program may lack it.
    pub(super) leads_to_hole: bool,
    /// The hole of a feed move in a cycle that stays a cycle in any case.
    pub(super) whole: Option<WholeHole>,
    /// Motion mode.
    pub(super) motion_mode: MotionMode,
    /// Largest distance between the programmed path and this one, mm.
    pub(super) off_curve_mm: f64,
    /// Acts between the previous move and this one.
    pub(super) acts: Vec<Act>,
    /// Stop at its end.
    pub(super) passing: Passing,
    /// The number of its block, on the first move of the block.
    pub(super) number: Option<BlockNumber>,
    /// The word of the active five-axis transformation; empty if there is none.
    pub(super) transformation: &'static str,
}

/// The hole of a cycle that stays a cycle in any case, at one of its feed moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct WholeHole {
    /// Where its first feed move begins.
    pub(super) top: AxisVector,
    /// The drilling axis.
    pub(super) along: Axis,
    /// `true` if the move leads out of the hole.
    pub(super) is_back: bool,
}

impl ComparedMove<'_> {
    /// Its path with the bodies of the axes at its beginning.
    pub(super) fn path(&self) -> LedPath<'_> {
        LedPath { route: &self.route, band: &self.band, stated: self.stated, tool_mm: &self.tool_mm }
    }

    /// An axis command as this program would write it here: coordinates of the active frame; under a transformation, of the tip in the workpiece.
    pub(super) fn programmed(&self, command: &AxisVector, kinematics: &Kinematics) -> AxisVector {
        // Under a transformation the block has a bare frame, but its words are those of the tip.
        if self.in_machine_frame && self.setup.transform.is_none() {
            let mut out = *command;
            out.set_xyz(out.xyz() + self.setup.tool_mm);
            return out;
        }
        let is_transformed = self.setup.transform.is_some();
        let position = if is_transformed { kinematics.on_workpiece(command, &self.setup.tool_mm) } else { *command };
        self.setup.programmed(&position)
    }

    /// `true` if only its end must be at its place: a thread and a positioning axis are not divided.
    pub(super) fn is_uncut(&self) -> bool {
        self.motion_mode != MotionMode::Path
    }

    /// The axis command for the words of this program, the inverse of [`ComparedMove::programmed`]; `None` if the machine cannot reach it.
    pub(super) fn commanded(&self, words: &AxisVector, kinematics: &Kinematics) -> Option<AxisVector> {
        if self.in_machine_frame && self.setup.transform.is_none() {
            let mut out = *words;
            out.set_xyz(out.xyz() - self.setup.tool_mm);
            return Some(out);
        }
        let position = self.setup.command(words);
        if self.setup.transform.is_some() {
            kinematics.command_on_workpiece(&position, &self.setup.tool_mm)
        } else {
            Some(position)
        }
    }

    /// `true` if it moves as `other` does, apart from a correction.
    fn moves_as(&self, other: &ComparedMove<'_>) -> bool {
        let way = |step: &ComparedMove<'_>| step.route.end - step.route.start;
        self.rapid == other.rapid && (way(self) - way(other)).xyz().amax() <= MOST_CHANGE_MM
    }

    /// `true` if it only leads to the place of a call, and the next move of the other program is another one or leads there as well.
    pub(super) fn is_lead_beside(&self, other: Option<&ComparedMove<'_>>) -> bool {
        self.leads_to_hole && other.is_none_or(|other| other.leads_to_hole || !self.moves_as(other))
    }

    /// Takes over what belongs to a move before it that is not compared.
    pub(super) fn take_over(&mut self, before: ComparedMove<'_>) {
        self.acts.splice(..0, before.acts);
        self.number = before.number.or(self.number);
        self.continues = before.continues;
    }

    /// `true` if the control passes without exact stop into a move of the same block in the same direction, as between the pieces of a curve.
    pub(super) fn runs_into(&self, next: &ComparedMove<'_>) -> bool {
        let way = |route: &Route<'_>, [from, to]: [f64; 2]| {
            let step = route.at(to) - route.at(from);
            AXES.map(|axis| if axis.is_rotary() { TURN_ARM_MM * step[axis] } else { step[axis] })
        };
        let ways = [way(&self.route, [1.0 - NEAR_END, 1.0]), way(&next.route, [0.0, NEAR_END])];
        let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
        let sizes = ways.map(|way| dot(&way, &way).sqrt());
        next.continues && next.rapid == self.rapid && dot(&ways[0], &ways[1]) > SAME_WAY * sizes[0] * sizes[1]
    }
}

/// The moves of a stream of elements.
pub(super) struct Walk<'a, I> {
    elements: I,
    machine: &'a Machine,
    feeds: Feeds,
    counts_turns: bool,
    /// The model with all heads.
    base: &'a Model,
    lead: Lead<'a>,
    position: AxisVector,
    /// Whole turns that are added to the positions of modulo axes, rad.
    turns: AxisVector,
    tool_mm: Vector,
    tool: Option<Arc<WordValue>>,
    setup: Arc<Setup>,
    band: DeadBand,
    known: AxisSet,
    ever_named: AxisSet,
    continues: bool,
    on_the_spot: bool,
    /// Plane of the drilling cycle between the marks of a hole.
    hole: Option<Plane>,
    /// `true` if that cycle stays a cycle in any case.
    is_whole: bool,
    /// Start and end of the first feed move of the hole.
    first_feed: Option<[AxisVector; 2]>,
    /// `true` after a feed move.
    has_fed: bool,
    /// `true` up to the first move between these marks.
    approaches: bool,
    /// The element after the last move, if it was read already.
    held: Option<Element>,
    /// `true` if the block has moved already.
    has_moved: bool,
    acts: Acts,
    passing: Passing,
    number: Option<BlockNumber>,
    transformation: &'static str,
    tail: Tail,
}

/// Acts after the last move, complete at the end of the walk.
pub(super) type Tail = Rc<RefCell<Vec<Act>>>;

impl<'a, I> Walk<'a, I> {
    pub(super) fn new(elements: I, machine: &'a Machine, feeds: Feeds, lead: Lead<'a>) -> Self {
        Walk {
            elements,
            machine,
            feeds,
            counts_turns: false,
            base: lead.model,
            lead,
            position: AxisVector::ZERO,
            turns: AxisVector::ZERO,
            tool_mm: Vector::zeros(),
            tool: None,
            setup: Arc::default(),
            band: DeadBand::default(),
            known: AxisSet::EMPTY,
            ever_named: AxisSet::EMPTY,
            continues: false,
            on_the_spot: false,
            hole: None,
            is_whole: false,
            first_feed: None,
            has_fed: false,
            approaches: false,
            held: None,
            has_moved: false,
            acts: Acts::default(),
            passing: Passing::of(machine),
            number: None,
            transformation: "",
            tail: Tail::default(),
        }
    }

    /// Begins at a stated position of all axes.
    pub(super) fn from(mut self, start: Option<AxisVector>) -> Self {
        if let Some(start) = start {
            self.position = start;
            self.known = self.machine.axis_set();
        }
        self
    }

    /// The path of a move from the current position.
    fn route(&self, motion: &Move) -> Route<'a> {
        let (start, end) = (self.position, motion.target);
        let arc = motion.arc.map(|arc| (arc, motion.arc_basis));
        match motion.tip {
            Some(turning) => {
                let follows_circle = turning == Turning::Vector;
                let kinematics = self.lead.model.kinematics();
                let tip = TipPath::new(kinematics, follows_circle, [&start, &end], &self.tool_mm);
                Route::of_tip(start, end, arc, tip)
            }
            None => Route::new(start, end, arc),
        }
    }

    /// Acts after the last move; complete when the walk has ended.
    pub(super) fn tail(&self) -> Tail {
        Rc::clone(&self.tail)
    }
}

impl<I: Iterator<Item = Element>> Walk<'_, I> {
    /// Plane of the drilling cycle that the last move triggers.
    fn triggered_cycle(&mut self) -> Option<Plane> {
        self.held = self.held.take().or_else(|| self.elements.next());
        match self.held.as_ref().map(|element| &element.kind) {
            Some(Kind::Cycle(Some(cycle))) if cycle.trigger == HoleTrigger::Motion => Some(cycle.plane),
            _ => None,
        }
    }
}

impl<I> Walk<'_, I> {
    /// The move with the turns of modulo axes counted from their first positions.
    fn with_turns(&mut self, mut motion: Move) -> Move {
        for data in self.machine.axes.iter().flatten().filter(|data| data.modulo) {
            let axis = data.axis;
            if motion.known.contains(axis) && !self.known.contains(axis) {
                // 359.998° is below 0°. An executor that takes the shortest way has such a position without the turn already.
                let from_least = motion.target[axis] + BELOW_ZERO_RAD;
                let is_below = from_least.rem_euclid(TAU) < BELOW_ZERO_RAD;
                self.turns[axis] = if is_below { -TAU * (from_least / TAU).floor() } else { 0.0 };
            }
            motion.target[axis] += self.turns[axis];
        }
        motion
    }

    /// The hole of a feed move, if its cycle stays in any case.
    fn whole(&mut self, motion: &Move) -> Option<WholeHole> {
        let plane = self.hole.filter(|_| self.is_whole && !motion.rapid)?;
        let way = [self.position, motion.target];
        let [top, bottom] = *self.first_feed.get_or_insert(way);
        let along = plane.axes()[2];
        let is_back = (way[1] - way[0]).xyz().dot(&(bottom - top).xyz()) < 0.0;
        Some(WholeHole { top, along, is_back })
    }

    /// `true` if a move of a cycle leads a tool that is nearly at the hole to the place of the call. The program need not name that place, or has moved
    /// there with feed.
    fn is_at_hole(&self, motion: &Move, plane: Option<Plane>) -> bool {
        let Some([abscissa, ordinate, _]) = plane.map(Plane::axes) else { return false };
        let off_mm = |axis: Axis| motion.target[axis] - self.position[axis];
        let across_mm = off_mm(abscissa).hypot(off_mm(ordinate));
        motion.rapid
            && motion.arc.is_none()
            && motion.known == self.known
            && across_mm > SAME_PLACE_MM
            && across_mm <= MOST_CORRECTION_MM
            && AXES.iter().all(|&axis| axis == abscissa || axis == ordinate || off_mm(axis) == 0.0)
    }
}

impl<'a, I: Iterator<Item = Element>> Iterator for Walk<'a, I> {
    type Item = ComparedMove<'a>;

    fn next(&mut self) -> Option<ComparedMove<'a>> {
        loop {
            let Some(element) = self.held.take().or_else(|| self.elements.next()) else {
                self.tail.borrow_mut().append(&mut self.acts.rest());
                return None;
            };
            self.acts.see(&element, self.machine, &self.passing);
            self.passing.see(&element);
            if element.starts_block {
                // A mark belongs to its own line, which may contain no motion.
                self.continues = false;
                self.on_the_spot = false;
                self.has_moved = false;
                // A further line of a block has no number but belongs to the same block.
                self.number = element.number.or(self.number);
            }
            let lost = lost_axes(&element, self.machine);
            self.known = self.known.difference(lost);
            self.band.forget(lost);
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
                    if setup.head != self.setup.head {
                        self.lead = self.lead.with(self.base.for_head(setup.head));
                    }
                    self.setup = setup;
                    continue;
                }
                Kind::Cycle(mark) => {
                    self.is_whole = mark.as_ref().is_some_and(|cycle| is_better_whole(cycle));
                    self.hole = mark.map(|cycle| cycle.plane);
                    self.first_feed = None;
                    self.approaches = true;
                    continue;
                }
                Kind::Tool(word) => {
                    self.tool = Some(Arc::new(word));
                    continue;
                }
                Kind::Keep(word) if word.starts_with("TRA") => {
                    self.transformation = if word.starts_with("TRAORI") { word } else { "" };
                    continue;
                }
                Kind::Verbatim(text) => {
                    self.counts_turns = counts_turns(&text, self.machine).unwrap_or(self.counts_turns);
                    continue;
                }
                Kind::Move(motion) => self.with_turns(motion),
                _ => continue,
            };
            self.ever_named = self.ever_named.union(motion.named);
            let triggered = if motion.rapid { self.triggered_cycle() } else { None };
            let hole = if std::mem::take(&mut self.approaches) { self.hole } else { None };
            // After a feed move to the hole, the output moves to the place of its call.
            let after_feed = std::mem::replace(&mut self.has_fed, !motion.rapid);
            let leads_to_hole = self.is_at_hole(&motion, hole.or(triggered.filter(|_| after_feed)));
            let in_cycle = self.hole.is_some() || triggered.is_some();
            let whole = self.whole(&motion);
            let step = ComparedMove {
                origin: element.origin,
                route: self.route(&motion),
                rapid: motion.rapid,
                setup: Arc::clone(&self.setup),
                in_machine_frame: motion.in_machine_frame,
                feed: if motion.rapid { 0.0 } else { motion.feed },
                unit: motion.unit,
                feeds: if self.counts_turns { Feeds::OfAll } else { self.feeds },
                tool_mm: self.tool_mm,
                tool: self.tool.clone(),
                band: self.band,
                stated: self.known,
                is_counted: motion.named.difference(self.known).is_empty()
                    && self.ever_named.difference(motion.known).is_empty(),
                // The moves of one executed block belong together.
                continues: std::mem::take(&mut self.continues) | std::mem::replace(&mut self.has_moved, true),
                on_the_spot: std::mem::take(&mut self.on_the_spot),
                in_cycle,
                leads_to_hole,
                whole,
                motion_mode: motion.motion_mode,
                off_curve_mm: motion.off_curve_mm,
                acts: self.acts.before(motion.rapid),
                passing: self.passing.clone(),
                number: self.number.take(),
                transformation: self.transformation,
            };
            self.lead.along(&mut self.band, &step.route, self.known, [0.0, 1.0]);
            self.position = motion.target;
            self.known = motion.known;
            return Some(step);
        }
    }
}
