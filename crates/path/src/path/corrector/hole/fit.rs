//! The shift of a hole as a whole: its search, and the deviation that it leaves.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXES, Axis, AxisSet, AxisVector};
use ncfix_machine::snc::{DrillingCycle, Element, Kind, Move};

use super::{Corrector, HoleFit, HoleLine, HoleShift, MOST_HELD, NearestShift, before_hole};
use crate::path::place::Placed;
use crate::path::route::Route;
use crate::path::segment_candidate::{SAME_PLACE_MM, SegmentCandidate, SegmentFitter};
use crate::path::standing::PathState;
use crate::path::staying::{is_better_whole, must_stay};

impl<'a, I> Corrector<'a, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// The shift with which all feed moves of a hole are within the tolerance, and the depth of one peck, increments.
    pub(super) fn shift_of(
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
    pub(super) fn shift_by(
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

    /// Largest deviation of a hole that stays a cycle, mm. Rounding that exceeds the tolerance is no reason for moves: they have it too.
    pub(super) fn allowed_at_hole_mm(&self, tolerance_mm: f64) -> f64 {
        let increments = &self.placer.increments;
        if increments.rounding_mm() > tolerance_mm { increments.allowed_mm(tolerance_mm) } else { tolerance_mm }
    }

    /// A hole as a cycle with a shift; `None` if the cycle makes other moves, or an axis beside it reverses.
    pub(super) fn fit_hole(
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
    pub(super) fn leveled(&self, line: &HoleLine, shift: &HoleShift, mut standing: PathState) -> PathState {
        let along = line.axes[2];
        let mut place = self.placer.in_frame(&standing.command);
        place[along] = line.top[along] + self.placer.increments.position(along, shift.top);
        let placed = self.placer.round(&self.placer.of_frame(&place), standing.known);
        self.note_difference(&mut standing, &placed);
        (standing.command, standing.counts) = (placed.command, placed.counts);
        standing
    }

    /// The state at the position of the call: a tool that is at the programmed place moves by the difference first.
    pub(super) fn positioned(&self, line: &HoleLine, shift: &HoleShift, mut standing: PathState) -> PathState {
        let Some(plane) = shift.plane else { return standing };
        if shift.brought != [0.0; 2] {
            standing = self.at_shift(line, before_hole(plane, shift.brought), standing);
        }
        if line.has_approach { standing } else { self.at_shift(line, plane, standing) }
    }

    /// The state after a move to the place of a hole with a shift, at the height of the tool.
    pub(super) fn at_shift(&self, line: &HoleLine, plane: [f64; 2], mut standing: PathState) -> PathState {
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
    pub(super) fn note_difference(&self, standing: &mut PathState, placed: &Placed) {
        standing.state.note_motion(&standing.command, &placed.command);
        let route = self.placer.emitted(standing.command, placed.command);
        self.lead.along(&mut standing.band, &route, standing.sensed, [0.0, 1.0]);
    }

    /// The end of a move of a hole, shifted.
    pub(super) fn shifted(&self, line: &HoleLine, shift: &HoleShift, motion: &Move, standing: &PathState) -> Placed {
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
    pub(super) fn hole_candidate(
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
            sides: Default::default(),
        };
        let trial = fitter.at_end(standing, end, &mut scratch);
        self.scratch = scratch;
        trial
    }
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
