//! The search of the shift of a hole: an attempt for each way to its place, and each shift along it.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::snc::{DrillingCycle, Element};

use super::{Corrector, HoleFit, HoleLine, HoleShift, NearestShift};
use crate::path::segment_candidate::SAME_PLACE_MM;
use crate::path::staying::{is_better_whole, must_stay};

impl<I> Corrector<'_, I>
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
}
