//! Pieces whose axis bodies would stay within their dead bands.
//!
//! An axis that the program does not move follows the corrections of the others. If it drifts back by about an increment, its body stays, although rounding
//! alone could explain the step. The tip is then off by that step, in addition to rounding. Such a piece is placed for the other side of the axis, after a step
//! on the spot.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXIS_COUNT, AxisSet};
use ncfix_machine::snc::{Element, MotionMode};

use super::{Active, Corrector};
use crate::path::segment_candidate::{SegmentCandidate, SegmentFitter};
use crate::path::treatment::MoveTreatment;

/// Number of intervals of a piece at whose ends it is examined, in addition to the places where bodies begin to follow.
const PLACES: u32 = 8;

impl<'a, I> Corrector<'a, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// Replaces a piece of a cut that would miss the tolerance because bodies stay: by the best one on other sides.
    pub(super) fn lead_bodies(&self, active: &Active<'a>, trial: &mut SegmentCandidate<'a>, scratch: &mut Vec<f64>) {
        let is_cut = active.treatment == MoveTreatment::RotaryDirection
            && active.motion.motion_mode == MotionMode::Path
            && !active.motion.rapid
            && !active.motion.turns_either_way();
        if self.sampler.backlash.is_empty() || !is_cut {
            return;
        }
        let allowed_mm = self.placer.increments.allowed_mm(active.tolerance_mm);
        let Some(off_mm) = self.of_bodies_mm(active, trial, scratch).filter(|&off_mm| off_mm > allowed_mm) else {
            return;
        };
        let off = self.off_side(active, trial);
        let (own, mut best_mm) = (*trial, off_mm);
        // All of them, then each alone.
        for only in std::iter::once(None).chain(off.iter().map(Some)) {
            let mut sides = [0; AXIS_COUNT];
            for axis in off.iter().filter(|axis| only.is_none_or(|only| only == *axis)) {
                sides[axis.slot()] = -own.sense[axis.slot()];
            }
            let Some(found) = self.on_sides(active, &own, sides, scratch) else { continue };
            let off_mm = self.of_bodies_mm(active, &found, scratch).unwrap_or(0.0);
            if off_mm < best_mm {
                (*trial, best_mm) = (found, off_mm);
            }
        }
    }

    /// The piece `like` with axes tried on these sides; `None` if it cannot be placed, or deviates more otherwise.
    fn on_sides(
        &self,
        active: &Active<'a>,
        like: &SegmentCandidate<'a>,
        sides: [i8; AXIS_COUNT],
        scratch: &mut Vec<f64>,
    ) -> Option<SegmentCandidate<'a>> {
        let bench = SegmentFitter { sides, ..self.fitter(active) };
        let found = match like.circle {
            Some(_) => bench.arc(&self.standing, like.between, scratch)?,
            None => bench.straight(&self.standing, like.between, scratch),
        };
        let is_placed = found.end.failure.is_none() && !found.end.is_held_back;
        (is_placed && (found.fits() || found.deviation_mm <= like.deviation_mm)).then_some(found)
    }

    /// The axes whose bodies are not on the sides for which a piece was placed.
    fn off_side(&self, active: &Active<'a>, trial: &SegmentCandidate<'a>) -> AxisSet {
        let bands = self.bands(trial, self.stated(active));
        let only = |axis| std::iter::once(axis).collect();
        let is_led = |axis| [bands.start, bands.end].iter().all(|band| band.is_on(only(axis), &trial.sense));
        self.sampler.backlash.iter().filter(|&axis| trial.sense[axis.slot()] != 0 && !is_led(axis)).collect()
    }

    /// The largest distance of the tip from its place on a piece, with its bodies, mm; `None` if all of them are led.
    fn of_bodies_mm(&self, active: &Active<'a>, trial: &SegmentCandidate<'a>, scratch: &mut Vec<f64>) -> Option<f64> {
        let bands = self.bands(trial, self.stated(active));
        if bands.are_led {
            return None;
        }
        scratch.clear();
        scratch.extend((1..=PLACES).map(|k| f64::from(k) / f64::from(PLACES)));
        self.lead.edges(&bands.start, &trial.emitted, scratch);
        let tool_mm = &self.placer.setup.tool_mm;
        let off_mm = |share: f64| {
            let at = trial.parameter(share);
            let places = (&active.route.at(at), &trial.emitted.at(share));
            self.lead.error_mm(&bands.at(&self.lead, trial, share), places, tool_mm, active.way_at(at)).nearest.norm()
        };
        Some(scratch.iter().map(|&share| off_mm(share)).fold(0.0, f64::max))
    }

    /// Axes with a known position after a step before a piece.
    pub(super) fn stated(&self, active: &Active<'a>) -> AxisSet {
        let known = active.motion.known;
        if self.placer.is_parallel() { known } else { self.placer.setup.frame.known_across(known, false) }
    }
}
