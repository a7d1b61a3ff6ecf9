//! Holes that stay a drilling cycle of the control.
//!
//! A cycle moves along one straight line at constant X and Y, and its pecks follow from its heights. So the moves of a hole are shifted as a whole: by
//! the mean correction of both ends of the line across it, and by whole increments along it. If the tip of a feed move is then outside the
//! tolerance of holes, the hole is written as moves.

use std::sync::Arc;

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, Axis, AxisSet, AxisVector};
use ncfix_machine::snc::{
    CycleArgument, DrillingCycle, Element, FeedUnit, HoleTrigger, Kind, MotionMode, Move, Origin,
};

use super::Corrector;
use crate::path::cycle_block::CycleBlock;
use crate::path::place::Placed;
use crate::path::route::Route;
use crate::path::segment_candidate::{SAME_PLACE_MM, SegmentCandidate, SegmentFitter};
use crate::path::standing::PathState;
use crate::path::staying::{is_better_whole, must_stay};
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
            let changes_level = is_leading && (target[axes[2]] - at[axes[2]]).abs() > SAME_PLACE_MM;
            if !is_axis_move || others_move || changes_level || !own.difference(motion.known).is_empty() {
                return None;
            }
            let moves_across = axes[..2].iter().any(|&axis| (target[axis] - at[axis]).abs() > SAME_PLACE_MM);
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

    /// The shift with which all feed moves of a hole are within the tolerance, and the depth of one peck, increments.
    fn shift_of(
        &mut self,
        cycle: &DrillingCycle,
        line: &HoleLine,
        hole: &[Element],
    ) -> Option<(HoleShift, Option<i64>)> {
        let stays = is_better_whole(cycle);
        // A call without a position makes its hole where the tool stands; a move in front of it leads there.
        let ways = [(line.is_positioned, false), (true, false), (true, true)];
        let mut nearest: Option<NearestShift> = None;
        for (k, (is_moved, is_brought)) in ways.into_iter().enumerate() {
            if k == 1 && line.is_positioned || is_brought && !stays {
                continue;
            }
            let Some(found) = self.shift_by(cycle, line, hole, (is_moved, is_brought)) else { continue };
            let is_unknown = |before: NearestShift| is_moved && before.deviation_mm.is_infinite();
            if nearest.is_none_or(|before| found.deviation_mm < before.deviation_mm || is_unknown(before)) {
                nearest = Some(found);
            }
            if found.fits {
                break;
            }
        }
        let nearest = nearest?;
        // In a frame that turns, moves are placed for the sides of axes that no call can state.
        let is_certain = nearest.deviation_mm.is_finite() || self.placer.is_parallel();
        if nearest.fits || must_stay(cycle) || stays && is_certain {
            if nearest.deviation_mm.is_finite() {
                self.prediction.kept_hole_mm = self.prediction.kept_hole_mm.max(nearest.deviation_mm);
            }
            // No moves are better for a tap; the error along it is reported.
            return Some((nearest.shift, nearest.peck));
        }
        if nearest.deviation_mm.is_finite() {
            self.prediction.expanded_hole_mm = self.prediction.expanded_hole_mm.max(nearest.deviation_mm);
        }
        None
    }

    /// The best shift if the tool goes to the place of the hole, or stands there, and reaches it in a known direction, or not. `None` if the machine
    /// cannot go there.
    fn shift_by(
        &mut self,
        cycle: &DrillingCycle,
        line: &HoleLine,
        hole: &[Element],
        (is_moved, is_brought): (bool, bool),
    ) -> Option<NearestShift> {
        let standing = self.standing;
        let mut state = standing.state;
        let [top, bottom] = [&line.top, &line.bottom].map(|end| self.placer.of_frame(end));
        state.note_stated(standing.sensed, &standing.nominal, &top);
        state.note_motion(&top, &bottom);
        let known = standing.known.union(line.axes.into_iter().collect());
        let [abscissa, ordinate, along] = line.axes;
        let brought = if is_brought { self.brought(cycle, line, &top)? } else { [0.0; 2] };
        let level = self.level_of(cycle, line);
        // LinuxCNC returns to the initial level first only if R is not below the tool.
        let is_above = |height_mm: f64| (height_mm - line.top[along]).abs() > SAME_PLACE_MM;
        let needs_level = level.is_some() && line.returns && is_above(line.initial.nominal_mm);
        for (axis, way_mm) in [abscissa, ordinate].into_iter().zip(brought).filter(|(_, way_mm)| *way_mm != 0.0) {
            state.direction[axis.slot()] = if way_mm > 0.0 { 1 } else { -1 };
        }
        let hole_tolerance_mm = self.options.hole_tolerance_mm.max(self.options.tolerance_mm);
        let (most_mm, least_mm) =
            (self.allowed_at_hole_mm(hole_tolerance_mm), self.allowed_at_hole_mm(self.options.tolerance_mm));
        let mut last: Option<NearestShift> = None;
        let mut nearest: Option<NearestShift> = None;
        for attempt in 0..2 {
            let mut corrections = [AxisVector::ZERO; 2];
            for (correction, (place, own)) in corrections.iter_mut().zip([(&top, &line.top), (&bottom, &line.bottom)]) {
                let exact = self.placer.exact(place, known, &state, &standing.correction, 0.0).ok()?;
                *correction = self.placer.in_frame(&exact) - *own;
            }
            let [at_top, at_bottom] = corrections;
            let middle = |axis: Axis| 0.5 * (at_top[axis] + at_bottom[axis]);
            let plane = is_moved.then_some([middle(abscissa), middle(ordinate)]);
            let count = |mm: f64| self.placer.increments.count(along, mm);
            // The shift of the hole before saves words; the one of the bottom is the best; the mean is for a deep hole.
            let best = count(at_bottom[along]);
            let unfit = HoleShift { plane, brought, along: best, top: level.unwrap_or(best) };
            let unfit = NearestShift { deviation_mm: f64::INFINITY, shift: unfit, peck: None, fits: false };
            nearest = nearest.filter(|fit| fit.deviation_mm.is_finite()).or(Some(unfit));
            let shifts = [self.last_shift, best, count(middle(along))];
            let needs_level = needs_level || level.is_some() && self.rises_with_feed(cycle, line, hole);
            let at_level = shifts.into_iter().filter_map(|along| Some((along, level?)));
            let own = shifts.into_iter().filter(|_| !needs_level).map(|along| (along, along));
            for (along, top) in at_level.chain(own) {
                let shift = HoleShift { plane, brought, along, top };
                let Some(HoleFit { deviation_mm, peck }) = self.fit_hole(cycle, line, &shift, hole) else { continue };
                let fit = NearestShift { deviation_mm, shift, peck, fits: deviation_mm <= most_mm };
                if deviation_mm <= least_mm {
                    return Some(fit);
                }
                last = last.or(Some(fit).filter(|_| along == self.last_shift && fit.fits));
                if nearest.is_none_or(|nearest| deviation_mm < nearest.deviation_mm) {
                    nearest = Some(fit);
                }
            }
            // A tool that stands at the programmed place moves by the difference of the corrections first, and this may reverse an axis.
            let before = state.direction;
            if attempt == 0
                && !is_brought
                && let Some([x, y]) = plane.filter(|_| !line.has_approach)
            {
                let mut to = self.placer.in_frame(&standing.command);
                (to[abscissa], to[ordinate]) = (line.top[abscissa] + x, line.top[ordinate] + y);
                state.note_motion(&standing.command, &self.placer.of_frame(&to));
                state.note_motion(&top, &bottom);
            }
            if state.direction == before {
                break;
            }
        }
        // If no shift keeps the tolerance of cuts, the one of the hole before keeps the call too.
        last.or(nearest)
    }

    /// The shift of R with which it is the level of the tool, increments; `None` if the program has another R, or a call that states no R of its own.
    fn level_of(&self, cycle: &DrillingCycle, line: &HoleLine) -> Option<i64> {
        let along = line.axes[2];
        let has_heights = cycle.arguments.iter().any(|argument| matches!(argument, CycleArgument::Height(_)));
        let [nominal_mm, command_mm] =
            [&self.standing.nominal, &self.standing.command].map(|place| self.placer.in_frame(place)[along]);
        let is_there = self.standing.known.contains(along) && (nominal_mm - line.top[along]).abs() <= SAME_PLACE_MM;
        let is_own = cycle.trigger == HoleTrigger::Position && !has_heights;
        (is_own && is_there).then(|| self.placer.increments.count(along, command_mm - line.top[along]))
    }

    /// `true` if the tool leaves the hole with the feed: in some languages to the initial level, in others to R.
    fn rises_with_feed(&self, cycle: &DrillingCycle, line: &HoleLine, hole: &[Element]) -> bool {
        let along = line.axes[2];
        let rises = |motion: &Move| {
            let end = self.placer.in_frame(&motion.target)[along];
            !motion.rapid && (end - line.top[along]).abs() <= SAME_PLACE_MM
        };
        let is_up = |element: &Element| matches!(&element.kind, Kind::Move(motion) if rises(motion));
        line.returns && !is_better_whole(cycle) && hole.iter().any(is_up)
    }

    /// The state at the initial level after a hole, if that is the level of R in the program but not in the output.
    fn returned(&self, cycle: &DrillingCycle, line: &HoleLine, mut standing: PathState) -> PathState {
        let along = line.axes[2];
        let has_heights = cycle.arguments.iter().any(|argument| matches!(argument, CycleArgument::Height(_)));
        let is_level = (line.initial.nominal_mm - line.top[along]).abs() <= SAME_PLACE_MM;
        if !line.returns || !is_level || has_heights || cycle.trigger != HoleTrigger::Position {
            return standing;
        }
        let mut place = self.placer.in_frame(&standing.command);
        if (place[along] - line.initial.command_mm).abs() <= SAME_PLACE_MM {
            return standing;
        }
        place[along] = line.initial.command_mm;
        let placed = self.placer.round(&self.placer.of_frame(&place), standing.known);
        self.note_difference(&mut standing, &placed);
        (standing.command, standing.counts) = (placed.command, placed.counts);
        standing
    }

    /// The ways across a hole by which the axes with backlash reach it, mm; `None` without such an axis, or without room.
    fn brought(&self, cycle: &DrillingCycle, line: &HoleLine, top: &AxisVector) -> Option<[f64; 2]> {
        // A move between modal holes gives them another initial level.
        let level_mm = self.placer.in_frame(&self.standing.nominal)[line.axes[2]];
        let is_modal = cycle.trigger == HoleTrigger::Position;
        if is_modal && (level_mm - line.initial.nominal_mm).abs() > SAME_PLACE_MM {
            return None;
        }
        // In a frame that turns, dead bands of axes do not lie along its coordinates.
        let [abscissa, ordinate, _] = line.axes;
        let mut ways = [0.0; 2];
        for (way_mm, axis) in ways.iter_mut().zip([abscissa, ordinate]) {
            if self.sampler.backlash.contains(axis) {
                let beyond_mm = self.beyond_mm(axis, top);
                let side = [1.0, -1.0].into_iter().find(|side| self.has_room(axis, top[axis], -side * beyond_mm))?;
                *way_mm = side * beyond_mm;
            }
        }
        Some(ways).filter(|ways| *ways != [0.0; 2] && self.placer.is_parallel())
    }

    /// Largest deviation of a hole that stays a cycle, mm. Rounding that exceeds the tolerance is no reason for moves: they have it too.
    fn allowed_at_hole_mm(&self, tolerance_mm: f64) -> f64 {
        let increments = &self.placer.increments;
        if increments.rounding_mm() > tolerance_mm { increments.allowed_mm(tolerance_mm) } else { tolerance_mm }
    }

    /// A hole as a cycle with a shift; `None` if the cycle makes other moves, or an axis beside it reverses.
    fn fit_hole(
        &mut self,
        cycle: &DrillingCycle,
        line: &HoleLine,
        shift: &HoleShift,
        hole: &[Element],
    ) -> Option<HoleFit> {
        let along = line.axes[2];
        let mut standing = self.positioned(line, shift, self.standing);
        let mut cuts = 0;
        let mut heights = [None; 2];
        let mut deviation_mm = 0.0_f64;
        let increment_mm = self.placer.increments.linear_mm;
        // Rounding may add a peck of nothing: then each peck is one increment longer.
        let own = cycle.peck.map_or(0, |peck| (peck.depth_mm / increment_mm).round() as i64);
        let longer = [own, own + 1];
        let mut besides_mm = [0.0_f64; 2];
        for motion in hole.iter().filter_map(|element| match &element.kind {
            Kind::Move(motion) => Some(motion),
            _ => None,
        }) {
            if !motion.rapid && cuts == 0 {
                standing = self.leveled(line, shift, standing);
            }
            let placed = self.shifted(line, shift, motion, &standing);
            let route = self.placer.nominal(standing.nominal, motion);
            let trial = self.hole_candidate(&route, motion.known, &standing, placed);
            if !motion.rapid {
                cuts += 1;
                let is_open = |axis: &Axis| trial.sense[axis.slot()] == 0;
                if self.sampler.backlash.iter().any(|axis| is_open(&axis)) {
                    return None;
                }
                // On the way out of a thread the drilling axis is on the other side of its dead band: the depth counts.
                let ends_at = self.placer.in_frame(&motion.target)[along];
                let is_down = (ends_at - self.placer.in_frame(&route.start)[along])
                    * (line.bottom[along] - line.top[along])
                    > 0.0;
                if is_down || !is_better_whole(cycle) {
                    deviation_mm = deviation_mm.max(trial.deviation_mm);
                }
                let from = *heights[0].get_or_insert(standing.counts[along.slot()]);
                let end = placed.counts[along.slot()];
                if self.placer.in_frame(&motion.target)[along] == line.bottom[along] {
                    heights[1] = Some(end);
                } else {
                    // The control counts pecks from the reference plane: what their lengths are rounded by adds up.
                    for (besides_mm, peck) in besides_mm.iter_mut().zip(longer) {
                        let off = i64::from(cuts) * peck - (end - from).abs();
                        *besides_mm = besides_mm.max(off.abs() as f64 * increment_mm);
                    }
                }
            }
            self.lead.along(&mut standing.band, &trial.emitted, standing.sensed, [0.0, 1.0]);
            standing.nominal = motion.target;
            standing.command = placed.command;
            standing.counts = placed.counts;
            standing.correction = placed.command - motion.target;
            standing.state.direction = trial.sense;
            standing.sensed = motion.known;
            standing.known = motion.known;
        }
        let Some(peck) = cycle.peck else { return Some(HoleFit { deviation_mm, peck: None }) };
        let [Some(from), Some(to)] = heights else { return None };
        longer
            .into_iter()
            .zip(besides_mm)
            .find(|&(count, _)| pecks(from, to, count, increment_mm, peck.slack_mm) == cuts)
            .map(|(count, besides_mm)| HoleFit { deviation_mm: deviation_mm + besides_mm, peck: Some(count) })
    }

    /// The state at the reference plane of the call: a tool at that of another hole moves by the difference first.
    fn leveled(&self, line: &HoleLine, shift: &HoleShift, mut standing: PathState) -> PathState {
        let along = line.axes[2];
        let mut place = self.placer.in_frame(&standing.command);
        place[along] = line.top[along] + self.placer.increments.position(along, shift.top);
        let placed = self.placer.round(&self.placer.of_frame(&place), standing.known);
        self.note_difference(&mut standing, &placed);
        (standing.command, standing.counts) = (placed.command, placed.counts);
        standing
    }

    /// The state at the position of the call: a tool that is at the programmed place moves by the difference first.
    fn positioned(&self, line: &HoleLine, shift: &HoleShift, mut standing: PathState) -> PathState {
        let Some(plane) = shift.plane else { return standing };
        if shift.brought != [0.0; 2] {
            standing = self.at_shift(line, before_hole(plane, shift.brought), standing);
        }
        if line.has_approach { standing } else { self.at_shift(line, plane, standing) }
    }

    /// The state after a move to the place of a hole with a shift, at the height of the tool.
    fn at_shift(&self, line: &HoleLine, plane: [f64; 2], mut standing: PathState) -> PathState {
        let mut place = self.placer.in_frame(&standing.command);
        for (axis, shift_mm) in line.axes.into_iter().zip(plane) {
            place[axis] = line.top[axis] + shift_mm;
        }
        standing.known = standing.known.union(line.axes.into_iter().take(2).collect());
        let placed = self.placer.round(&self.placer.of_frame(&place), standing.known);
        self.note_difference(&mut standing, &placed);
        if self.placer.is_parallel() {
            standing.sensed = standing.sensed.union(standing.known);
        }
        (standing.command, standing.counts) = (placed.command, placed.counts);
        standing
    }

    /// Notes the motion by the difference of two corrections: its directions, and where the axes are within their dead bands.
    fn note_difference(&self, standing: &mut PathState, placed: &Placed) {
        standing.state.note_motion(&standing.command, &placed.command);
        let route = self.placer.emitted(standing.command, placed.command);
        self.lead.along(&mut standing.band, &route, standing.sensed, [0.0, 1.0]);
    }

    /// The end of a move of a hole, shifted.
    fn shifted(&self, line: &HoleLine, shift: &HoleShift, motion: &Move, standing: &PathState) -> Placed {
        let [abscissa, ordinate, along] = line.axes;
        let [target, nominal, from] =
            [&motion.target, &standing.nominal, &standing.command].map(|command| self.placer.in_frame(command));
        let mut place = target;
        let keeps = |axis: Axis| (target[axis] - nominal[axis]).abs() <= SAME_PLACE_MM;
        let stays_across = keeps(abscissa) && keeps(ordinate);
        for axis in AXES {
            if axis != abscissa && axis != ordinate && standing.known.contains(axis) && keeps(axis) {
                place[axis] = from[axis];
            }
        }
        for (index, axis) in [abscissa, ordinate].into_iter().enumerate() {
            match shift.plane {
                Some(plane) if !stays_across => place[axis] += plane[index],
                _ => place[axis] += from[axis] - nominal[axis],
            }
        }
        if !keeps(along) || !standing.known.contains(along) {
            let is_at_top = |height_mm: f64| (height_mm - line.top[along]).abs() <= SAME_PLACE_MM;
            let is_level = |height_mm: f64| (height_mm - line.initial.nominal_mm).abs() <= SAME_PLACE_MM;
            let is_initial = line.returns && is_level(target[along]) && !is_level(line.top[along]);
            if is_initial {
                place[along] = line.initial.command_mm;
            } else {
                let count = if is_at_top(target[along]) { shift.top } else { shift.along };
                place[along] += self.placer.increments.position(along, count);
            }
        }
        self.placer.round(&self.placer.of_frame(&place), motion.known)
    }

    /// A move of a hole to a position, measured along its path.
    fn hole_candidate(
        &mut self,
        route: &Route<'a>,
        known: AxisSet,
        standing: &PathState,
        end: Placed,
    ) -> SegmentCandidate<'a> {
        let mut scratch = std::mem::take(&mut self.scratch);
        let fitter = SegmentFitter {
            placer: &self.placer,
            sampler: &self.sampler,
            lead: &self.lead,
            control: &self.machine.control,
            route,
            samples: self.sampler.whole(route),
            known,
            tolerance_mm: self.options.tolerance_mm,
            takes_up: false,
            limits_turns: false,
            settled: Default::default(),
        };
        let trial = fitter.at_end(standing, end, &mut scratch);
        self.scratch = scratch;
        trial
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

/// Number of feed moves that a control makes of a depth, in increments.
fn pecks(from: i64, to: i64, peck: i64, increment_mm: f64, slack_mm: f64) -> u32 {
    let [from_mm, to_mm, peck_mm] = [from, to, peck].map(|count| count as f64 * increment_mm);
    let towards = (to_mm - from_mm).signum();
    let mut depth_mm = from_mm + towards * peck_mm;
    let mut count = 1;
    while peck > 0 && (to_mm - depth_mm) * towards > slack_mm && count < MOST_HELD as u32 {
        depth_mm += towards * peck_mm;
        count += 1;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pecks_are_counted_as_the_control_counts_them() {
        assert_eq!(pecks(2000, -28000, 5000, 1e-3, 1e-6), 6);
        assert_eq!(pecks(2001, -28000, 5000, 1e-3, 1e-6), 7);
        assert_eq!(pecks(2001, -28000, 5001, 1e-3, 1e-6), 6);
        assert_eq!(pecks(-28000, 2000, 40000, 1e-3, 1e-6), 1);
    }
}
