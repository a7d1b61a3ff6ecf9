//! Holes that stay a drilling cycle of the control.
//!
//! A cycle moves along one straight line at constant X and Y, and its pecks follow from its heights. So the moves of a hole are shifted as a whole: by
//! the mean correction of both ends of the line across it, and by whole increments along it. If the tip of a feed move is then outside the
//! tolerance of holes, the hole is written as moves.

mod attempt;
mod fit;
mod level;
mod shifted;

use std::sync::Arc;

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, Axis, AxisSet, AxisVector};
use ncfix_machine::snc::{DrillingCycle, Element, FeedUnit, HoleTrigger, Kind, MotionMode, Origin};

use super::Corrector;
use crate::path::cycle_block::CycleBlock;
use crate::path::segment_candidate::SAME_PLACE_MM;
use crate::path::staying::must_stay;
use crate::path::treatment::MoveTreatment;
use crate::path::{Output, Piece};

/// Maximum number of elements of one hole that are held; a longer hole is written as moves.
const MOST_HELD: usize = 10_000;

/// The initial level of the cycles, along the drilling axis: of the program and of the output, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct InitialLevel {
    nominal_mm: f64,
    command_mm: f64,
}

/// The straight line of a hole, from its reference plane to its bottom, in the coordinates of [`in_frame`](crate::path::place::CommandSolver::in_frame).
#[derive(Clone, Copy, Debug)]
struct HoleLine {
    axes: [Axis; 3],
    top: AxisVector,
    bottom: AxisVector,
    /// `true` if a rapid move in the plane leads to the hole.
    has_approach: bool,
    /// `true` if the call names the position, also where the tool is.
    is_positioned: bool,
    initial: InitialLevel,
    /// `true` if the tool returns to the initial level (G98).
    returns: bool,
}

/// Shift of the moves of a hole: coordinates minus those of the program, mm.
#[derive(Clone, Copy, Debug)]
struct HoleShift {
    /// Across the hole; `None` if the tool stays.
    plane: Option<[f64; 2]>,
    /// Way across the hole from a place to go to first, so that the axes reach the hole in a known direction; 0 without one.
    brought: [f64; 2],
    /// Along the hole, in increments.
    along: i64,
    /// Along it at the reference plane, in increments.
    top: i64,
}

/// The shift with the smallest deviation.
#[derive(Clone, Copy, Debug)]
struct NearestShift {
    /// As in [`HoleFit`]; infinite if an axis is on no known side.
    deviation_mm: f64,
    shift: HoleShift,
    /// As in [`HoleFit`].
    peck: Option<i64>,
    /// `true` if the hole is within its tolerance.
    fits: bool,
}

/// A hole as a cycle with one shift.
#[derive(Clone, Copy, Debug)]
struct HoleFit {
    /// Largest distance of the tip from the programmed path on the feed moves, mm.
    deviation_mm: f64,
    /// Depth of one peck, increments; `None` if the cycle has none.
    peck: Option<i64>,
}

impl<'a, I> Corrector<'a, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// Takes a hole of a drilling cycle from the stream, after the mark of its beginning; `approach` is the move that triggers the cycle.
    pub(super) fn take_hole(&mut self, cycle: &Arc<DrillingCycle>, mark: Element, approach: Option<Element>) {
        if let Some(approach) = approach.as_ref().filter(|approach| self.moves_others(cycle, approach)) {
            // The move comes before the modal call; the call follows at its end.
            let between = Element { starts_block: false, number: None, kind: Kind::Empty, ..*approach };
            self.elements.put_back(vec![approach.clone(), between, mark]);
            return;
        }
        let has_approach = approach.is_some();
        let mut hole: Vec<Element> = approach.into_iter().collect();
        let place = |element: Element| Element { kind: Kind::Empty, ..element };
        hole.extend(mark.starts_block.then(|| place(mark)));
        let mut is_complete = false;
        while hole.len() < MOST_HELD && !is_complete {
            match self.elements.take() {
                None => break,
                Some(Err(finding)) => self.pending.push_back(Err(finding)),
                Some(Ok(element)) => {
                    is_complete = matches!(element.kind, Kind::Cycle(None));
                    if !matches!(element.kind, Kind::Cycle(_)) {
                        hole.push(element);
                    } else if element.starts_block {
                        hole.push(place(element));
                    }
                }
            }
        }
        // Words before the first move belong to the block.
        let lead = hole.iter().position(|element| matches!(element.kind, Kind::Move(_))).unwrap_or(hole.len());
        let moves = hole.split_off(lead);
        let mut first = None;
        for element in hole {
            // An exact stop is for the single moves.
            if matches!(element.kind, Kind::Keep("G61")) {
                first = Some(element);
            } else {
                // A state without words has no line between the number of the block and its call.
                let has_line = element.number.is_some() || !matches!(element.kind, Kind::Setup(_));
                let starts_block = element.starts_block && has_line;
                self.take_in(Element { starts_block, ..element });
            }
        }
        if let Some(block) = is_complete.then(|| self.kept_hole(cycle, &moves, has_approach)).flatten() {
            // Without an approach the hole is in the block of its mark.
            let starts_block = block.starts_block && has_approach;
            let number = block.number.filter(|_| has_approach);
            self.pending.push_back(Ok(Output::Cycle(Box::new(CycleBlock { starts_block, number, ..block }))));
            self.pending.extend(self.findings.take().map(Err));
            return;
        }
        if let Some(first) = moves.first().filter(|_| is_complete && must_stay(cycle)) {
            self.pending.push_back(Err(cannot_stay(cycle, &first.origin)));
        }
        self.initial = None;
        self.prediction.expanded_holes += u64::from(is_complete);
        self.elements.put_back(first.into_iter().chain(moves).collect());
    }

    /// `true` if the move that triggers a cycle moves other axes than those across the hole, which no call states.
    fn moves_others(&self, cycle: &DrillingCycle, approach: &Element) -> bool {
        let Kind::Move(motion) = &approach.kind else { return false };
        let [abscissa, ordinate, along] = cycle.plane.axes();
        let [from, to] = [&self.standing.nominal, &motion.target].map(|command| self.placer.in_frame(command));
        let is_other =
            |&axis: &Axis| axis != abscissa && axis != ordinate && (to[axis] - from[axis]).abs() > SAME_PLACE_MM;
        !self.standing.known.contains(along) || AXES.iter().any(is_other)
    }

    /// Corrects a hole as one cycle; `None` if it must be written as moves. With `is_led`, its first move is one of the program, which triggers the cycle.
    fn kept_hole(&mut self, cycle: &Arc<DrillingCycle>, hole: &[Element], is_led: bool) -> Option<CycleBlock> {
        let line = self.line_of(cycle, hole, is_led)?;
        let (shift, pecks) = self.shift_of(cycle, &line, hole)?;
        let moves = || {
            hole.iter().filter_map(|element| match &element.kind {
                Kind::Move(motion) => Some(motion),
                _ => None,
            })
        };
        let first = hole.first()?;
        let along = line.axes[2];
        let mut block = CycleBlock {
            origin: first.origin,
            starts_block: first.starts_block,
            number: first.number,
            cycle: Arc::clone(cycle),
            words: AxisSet::EMPTY,
            position: self.standing.counts,
            reference: 0,
            bottom: 0,
            shift: shift.along,
            peck: pecks,
            // The feed in force before the cycle, which may have feeds of its own.
            feed: moves().next()?.feed,
            unit: moves().next()?.unit,
            feed_named: false,
            command: self.standing.command,
            nominal: self.standing.nominal,
        };
        let mut is_cut = false;
        self.lead_to_hole(&line, &shift, &mut block, is_led);
        let (before, written) = (self.standing.counts, self.standing.written);
        self.standing = self.positioned(&line, &shift, self.standing);
        for element in hole {
            let Kind::Move(motion) = &element.kind else {
                self.keep_pace(element);
                continue;
            };
            if !motion.rapid && !is_cut {
                self.standing = self.leveled(&line, &shift, self.standing);
                block.reference = self.standing.counts[along.slot()];
            }
            self.begin(element, motion);
            let Some(mut active) = self.active.take() else { continue };
            active.treatment = MoveTreatment::End;
            active.tolerance_mm = self.options.hole_tolerance_mm.max(self.options.tolerance_mm);
            active.settled = Default::default();
            let standing = self.standing;
            let placed = self.shifted(&line, &shift, motion, &standing);
            let mut trial = self.hole_candidate(&active.route, active.motion.known, &standing, placed);
            if motion.rapid {
                // Only the end of a rapid move has a place.
                trial.deviation_mm = 0.0;
            } else {
                if !is_cut {
                    block.bottom = placed.counts[along.slot()];
                    block.position = placed.counts;
                    is_cut = true;
                }
                if self.placer.in_frame(&motion.target)[along] == line.bottom[along] {
                    block.bottom = placed.counts[along.slot()];
                }
            }
            block.feed_named |= motion.feed_named;
            (block.command, block.nominal) = (placed.command, motion.target);
            self.accept(&mut active, &trial);
            self.standing.known = active.motion.known;
            self.idle = Some(active);
        }
        self.standing = self.returned(cycle, &line, self.standing);
        block.command = self.standing.command;
        let across: AxisSet = line.axes.into_iter().take(2).collect();
        let changes = |axis: &Axis| !written.contains(*axis) || block.position[axis.slot()] != before[axis.slot()];
        if line.is_positioned {
            block.words = across.iter().filter(changes).collect();
            if block.words.is_empty() {
                block.words = across;
            }
        }
        if self.initial.is_none() {
            self.initial = Some(line.initial);
        }
        self.last_shift = shift.along;
        self.prediction.kept_holes += 1;
        // The tool is above the place of its hole, not at the one for its height: a cut must not begin there.
        self.standing.is_doubtful = true;
        Some(block)
    }

    /// Writes rapid moves to the place of a hole that no word of its call states. With [`HoleShift::brought`], the axes reach it in a known direction.
    fn lead_to_hole(&mut self, line: &HoleLine, shift: &HoleShift, block: &mut CycleBlock, is_led: bool) {
        let Some(plane) = shift.plane else { return };
        let across: AxisSet = line.axes.into_iter().take(2).collect();
        let is_brought = shift.brought != [0.0; 2];
        let places = [(is_brought, before_hole(plane, shift.brought)), (!line.is_positioned, plane)];
        for (_, place) in places.into_iter().filter(|(is_needed, _)| *is_needed) {
            let before = self.standing;
            self.standing = self.at_shift(line, place, before);
            let mut nominal = self.placer.in_frame(&before.nominal);
            across.iter().for_each(|axis| nominal[axis] = line.top[axis]);
            let nominal = self.placer.of_frame(&nominal);
            let standing = &mut self.standing;
            let changes = |axis: &Axis| {
                !before.written.contains(*axis) || standing.counts[axis.slot()] != before.counts[axis.slot()]
            };
            let words: AxisSet = across.iter().filter(changes).collect();
            if words.is_empty() {
                continue;
            }
            standing.written = standing.written.union(across);
            // The block of a hole begins with its first line.
            let starts_block = std::mem::take(&mut block.starts_block) && is_led;
            let number = block.number.take().filter(|_| is_led);
            self.prediction.pieces += 1;
            self.pending.push_back(Ok(Output::Piece(Piece {
                origin: block.origin,
                starts_block,
                number,
                first: true,
                last: true,
                take_up: true,
                rapid: true,
                arc: None,
                counts: standing.counts,
                words,
                feed: block.feed,
                unit: block.unit,
                feed_named: false,
                rotary_words: Default::default(),
                in_machine_frame: false,
                motion_mode: MotionMode::Path,
                command: standing.command,
                nominal,
                known: standing.known,
                is_corrected: true,
                others_stay: true,
            })));
        }
    }

    /// The line of a hole; `None` if its moves are not those of a cycle along a linear axis of the machine.
    fn line_of(&mut self, cycle: &DrillingCycle, hole: &[Element], is_led: bool) -> Option<HoleLine> {
        let setup = &self.placer.setup;
        let is_straight = self.placer.keeps_lengths() && setup.transform.is_none() && setup.plane == cycle.plane;
        if !self.options.may_keep_cycles() || !is_straight || self.pace.is_by_time() || !self.clamps.are_open() {
            return None;
        }
        let axes = cycle.plane.axes();
        let own: AxisSet = axes.into_iter().collect();
        let mut at = self.placer.in_frame(&self.standing.nominal);
        let command_mm = self.placer.in_frame(&self.standing.command)[axes[2]];
        let initial = self.initial.unwrap_or(InitialLevel { nominal_mm: at[axes[2]], command_mm });
        let returns = !cycle.ends_at_reference;
        let mut line: Option<HoleLine> = None;
        let mut has_approach = false;
        let mut first = None;
        for element in hole {
            let motion = match &element.kind {
                Kind::Move(motion) => motion,
                Kind::Setup(_) | Kind::Frame(_) | Kind::Lost(_) | Kind::Tool(_) | Kind::Label(_) => return None,
                _ => continue,
            };
            // The block of a hole has no word along it: a move of the program to another level, over a clamp for example, must stay a move.
            let is_leading = is_led && first.is_none();
            first.get_or_insert(motion);
            let is_axis_move = motion.arc.is_none()
                && motion.tip.is_none()
                && !motion.in_machine_frame
                && motion.off_curve_mm == 0.0
                && motion.unit != FeedUnit::InverseTime
                && matches!(motion.motion_mode, MotionMode::Path | MotionMode::Thread(_));
            let target = self.placer.in_frame(&motion.target);
            let others_move = AXES.iter().any(|&axis| !own.contains(axis) && target[axis] != at[axis]);
            let is_level = (target[axes[2]] - at[axes[2]]).abs() <= SAME_PLACE_MM;
            let changes_level = is_leading && !is_level;
            let moves_across = axes[..2].iter().any(|&axis| (target[axis] - at[axis]).abs() > SAME_PLACE_MM);
            // LinuxCNC rises to R on its way to the next hole, but before it if the level at the start of its cycles is lower: in the output these may start later.
            let is_from_below = initial.nominal_mm + SAME_PLACE_MM < target[axes[2]];
            let rises_on_its_way = motion.rapid && moves_across && !is_level && is_from_below;
            if !is_axis_move
                || others_move
                || changes_level
                || rises_on_its_way
                || !own.difference(motion.known).is_empty()
            {
                return None;
            }
            if motion.rapid {
                has_approach |= line.is_none() && moves_across;
            } else {
                let line = line.get_or_insert(HoleLine {
                    axes,
                    top: at,
                    bottom: target,
                    has_approach,
                    is_positioned: has_approach || cycle.trigger != HoleTrigger::Call,
                    initial,
                    returns,
                });
                let is_at_hole = |place: &AxisVector| {
                    axes[..2].iter().all(|&axis| (place[axis] - line.top[axis]).abs() <= SAME_PLACE_MM)
                };
                if moves_across || !is_at_hole(&target) {
                    return None;
                }
                // The first feed goes down; a tool that returns with the feed may go higher than it was deep.
                let down = (line.bottom[axes[2]] - line.top[axes[2]]).signum();
                let depth = |place: &AxisVector| down * (place[axes[2]] - line.top[axes[2]]);
                if depth(&target) > depth(&line.bottom) {
                    line.bottom = target;
                }
            }
            at = target;
        }
        let line = line?;
        // Before the first move the position along the hole must be known: the initial level depends on it.
        let is_known = self.standing.known.contains(axes[2])
            && (line.has_approach || own.difference(self.standing.known).is_empty());
        let ends_there = cycle.ends_at_reference || (at[axes[2]] - line.initial.nominal_mm).abs() <= SAME_PLACE_MM;
        self.fix(first?, AxisSet::EMPTY);
        (is_known && ends_there && self.placer.turning().is_empty()).then_some(line)
    }
}

/// The place across a hole from which the axes reach its shift by these ways.
fn before_hole(plane: [f64; 2], brought: [f64; 2]) -> [f64; 2] {
    [plane[0] - brought[0], plane[1] - brought[1]]
}

/// The error for a cycle that must stay and cannot.
fn cannot_stay(cycle: &DrillingCycle, origin: &Origin) -> Diagnostic {
    let message = format!("{} stays a cycle, which needs a known position and axes that may move", cycle.name);
    let help = "state all axes before it, and open the clamps of the linear axes";
    Diagnostic::at(Code::NOT_SUPPORTED, Place { file: origin.file, span: origin.span }, message, help)
}
