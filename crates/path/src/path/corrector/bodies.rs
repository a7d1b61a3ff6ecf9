//! Pieces on which axis bodies are not where the piece was placed for.
//!
//! An axis that the program does not move, or hardly moves, follows the corrections of the others. If it drifts back, its body stays within its dead band,
//! although rounding alone could explain the step. The tip is then off by that step, in addition to rounding. A body without a dead band changes its side at
//! once. Such a piece is placed in another way: the axis stays, or it is led to a side by a step on the spot, or the piece ends where the axis turns back.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXIS_COUNT, AxisSet};
use ncfix_machine::snc::{Element, MotionMode};

use super::write::CENTER_INCREMENTS;
use super::{Active, Corrector};
use crate::path::Subdivision;
use crate::path::segment_candidate::{SAMPLED_SHARE, SegmentCandidate, SegmentFitter};
use crate::path::side_plan::SidePlan;
use crate::path::treatment::MoveTreatment;

/// Number of intervals of a piece at whose ends it is examined, in addition to the places where bodies begin to follow.
const PLACES: u32 = 8;
/// Largest motion of an axis that may be left out on a piece, mm: more than a correction changes on a piece.
const MOST_HELD_MM: f64 = 0.01;
/// Share of the tolerance by which the tip may be off before a step on the spot, if a piece would miss the tolerance otherwise.
const EARLY_SHARE: f64 = 0.2;
/// Number of lengths that are tried below the whole one, and the shortest of them, mm.
const SHORTER: u32 = 6;
const SHORTEST_MM: f64 = 0.05;
/// Number of pieces for which no way was found, after which only whole pieces are tried: on such a machine the search takes time and helps nothing.
const MOST_IN_VAIN: u32 = 100;

/// All of these axes together, then each alone.
fn each(axes: AxisSet) -> impl Iterator<Item = AxisSet> {
    let is_several = axes.iter().count() > 1;
    let single = axes.iter().map(|axis| std::iter::once(axis).collect()).filter(move |_: &AxisSet| is_several);
    std::iter::once(axes).filter(|axes| !axes.is_empty()).chain(single)
}

/// The distance of the tip from its place on a piece, with its bodies.
#[derive(Clone, Copy, Debug)]
struct BodyError {
    /// The largest, mm.
    most_mm: f64,
    /// Share of the piece up to which the distance is allowed.
    good_share: f64,
}

impl<'a, I> Corrector<'a, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// Replaces a piece of a cut that would miss the tolerance because of its bodies.
    pub(super) fn lead_bodies(
        &mut self,
        active: &Active<'a>,
        trial: &mut SegmentCandidate<'a>,
        scratch: &mut Vec<f64>,
    ) {
        let is_on_path = active.treatment == MoveTreatment::RotaryDirection
            && !active.motion.rapid
            && !active.motion.turns_either_way();
        if self.sampler.backlash.is_empty() || !is_on_path {
            return;
        }
        match active.motion.motion_mode {
            MotionMode::Path => self.lead_on_path(active, trial, scratch),
            MotionMode::Thread(_) => self.hold_in_thread(active, trial, scratch),
            _ => {}
        }
    }

    /// Keeps axes beside a thread where they are, if the tolerance allows it: their bodies would not return on the way out.
    fn hold_in_thread(&self, active: &Active<'a>, trial: &mut SegmentCandidate<'a>, scratch: &mut Vec<f64>) {
        let held = self.nearly_still(active, trial);
        if held.is_empty() {
            return;
        }
        let plan = SidePlan { held, ..SidePlan::default() };
        if let Some((found, off_mm)) = self.planned(active, trial, (trial.between, &plan), scratch)
            && off_mm <= self.allowed_off_mm(active, &found)
        {
            *trial = found;
        }
    }

    fn lead_on_path(&mut self, active: &Active<'a>, trial: &mut SegmentCandidate<'a>, scratch: &mut Vec<f64>) {
        let allowed_mm = self.allowed_off_mm(active, trial);
        let own = *trial;
        if !self.is_suspect(active, &own) {
            return;
        }
        let off = self.of_bodies(active, &own, allowed_mm, scratch);
        if off.most_mm <= allowed_mm {
            return;
        }
        let plans = self.plans(active, &own);
        let [from, to] = own.between;
        let mut best_mm = off.most_mm;
        for plan in &plans {
            let Some((found, off_mm)) = self.planned(active, &own, (own.between, plan), scratch) else { continue };
            if off_mm < best_mm {
                (*trial, best_mm) = (found, off_mm);
            }
            if off_mm <= self.allowed_off_mm(active, &found) {
                return;
            }
        }
        let may_divide = self.options.subdivision == Subdivision::Adaptive && self.in_vain < MOST_IN_VAIN;
        let mut length = (to - from) * if off.good_share > 0.0 { off.good_share } else { 0.5 };
        for _ in 0..SHORTER {
            if !may_divide || length * active.route.size_mm() < SHORTEST_MM {
                break;
            }
            for plan in std::iter::once(&SidePlan::default()).chain(&plans) {
                let Some((found, off_mm)) = self.planned(active, &own, ([from, from + length], plan), scratch) else {
                    continue;
                };
                if off_mm <= self.allowed_off_mm(active, &found) {
                    *trial = found;
                    return;
                }
            }
            length *= 0.5;
        }
        self.in_vain += u32::from(may_divide);
    }

    /// The distance of the tip from its place that a piece may have, mm: with the rounding of the center of an arc.
    fn allowed_off_mm(&self, active: &Active<'a>, trial: &SegmentCandidate<'a>) -> f64 {
        let increments = &self.placer.increments;
        let center_mm = if trial.circle.is_some() { CENTER_INCREMENTS * increments.linear_mm } else { 0.0 };
        increments.allowed_mm(active.tolerance_mm) + center_mm
    }

    /// The ways to lead the bodies of a piece: those without a step on the spot come first.
    fn plans(&self, active: &Active<'a>, own: &SegmentCandidate<'a>) -> Vec<SidePlan> {
        let still = self.nearly_still(active, own);
        let turning = self.off_side(active, own).union(still);
        let own_sides = [0; AXIS_COUNT];
        let flipped = |axes: AxisSet| {
            let mut sides = own_sides;
            axes.iter().for_each(|axis| sides[axis.slot()] = -own.sense[axis.slot()]);
            sides
        };
        let of = |sides, held, ready_share| SidePlan { sides, held, ready_share };
        let mut plans: Vec<SidePlan> = Vec::new();
        plans.extend(each(still).map(|held| of(own_sides, held, SAMPLED_SHARE)));
        plans.extend(each(turning).map(|axes| of(flipped(axes), AxisSet::EMPTY, SAMPLED_SHARE)));
        plans.push(of(own_sides, AxisSet::EMPTY, EARLY_SHARE));
        plans.extend(each(still).map(|held| of(own_sides, held, EARLY_SHARE)));
        for axes in each(turning) {
            let rest = still.difference(axes);
            let helds = [Some(AxisSet::EMPTY), Some(rest), Some(still).filter(|still| *still != rest)];
            let helds = helds.into_iter().flatten().enumerate().filter(|(k, held)| *k == 0 || !held.is_empty());
            plans.extend(helds.map(|(_, held)| of(flipped(axes), held, EARLY_SHARE)));
        }
        plans
    }

    /// Linear axes with backlash that move little on a piece, and that the program moves little.
    fn nearly_still(&self, active: &Active<'a>, own: &SegmentCandidate<'a>) -> AxisSet {
        if !self.placer.is_parallel() {
            return AxisSet::EMPTY;
        }
        let nominal = own.between.map(|parameter| active.route.at(parameter));
        let known = self.standing.written.intersection(active.motion.known);
        let axes = self.sampler.backlash.intersection(known);
        let is_still = |axis| {
            let (step, way) = (own.emitted.end[axis] - own.emitted.start[axis], nominal[1][axis] - nominal[0][axis]);
            step != 0.0 && step.abs() <= MOST_HELD_MM && way.abs() <= MOST_HELD_MM
        };
        axes.iter().filter(|axis| !axis.is_rotary() && is_still(*axis)).collect()
    }

    /// The piece between two parameters in the way of a plan, and the largest distance of the tip from its place on it, mm; `None` if it cannot be placed,
    /// or deviates more than `like` otherwise. An arc may become a chord.
    fn planned(
        &self,
        active: &Active<'a>,
        like: &SegmentCandidate<'a>,
        (between, plan): ([f64; 2], &SidePlan),
        scratch: &mut Vec<f64>,
    ) -> Option<(SegmentCandidate<'a>, f64)> {
        let bench = SegmentFitter { plan: *plan, ..self.fitter(active) };
        let arc = like.circle.and_then(|_| bench.arc(&self.standing, between, scratch));
        let is_good = |found: &SegmentCandidate<'a>, scratch: &mut Vec<f64>| {
            let is_placed = found.end.failure.is_none() && !found.end.is_held_back;
            if !is_placed || !found.fits() && found.deviation_mm > like.deviation_mm {
                return None;
            }
            let allowed_mm = self.allowed_off_mm(active, found);
            // The ends of held axes are off their places, which counts in any case.
            Some((*found, self.of_bodies(active, found, allowed_mm, scratch).most_mm))
        };
        let of_arc = arc.and_then(|arc| is_good(&arc, scratch));
        let is_enough = |(found, off_mm): &(SegmentCandidate<'a>, f64)| *off_mm <= self.allowed_off_mm(active, found);
        if of_arc.as_ref().is_some_and(is_enough) {
            return of_arc;
        }
        let line = bench.straight(&self.standing, between, scratch);
        let of_line = is_good(&line, scratch).filter(|(found, _)| like.circle.is_none() || found.fits());
        match (of_arc, of_line) {
            (Some(arc), Some(line)) => Some(if line.1 < arc.1 { line } else { arc }),
            (arc, line) => arc.or(line),
        }
    }

    /// The axes whose bodies are not on the sides for which a piece was placed.
    fn off_side(&self, active: &Active<'a>, trial: &SegmentCandidate<'a>) -> AxisSet {
        let bands = self.bands(trial, self.stated(active));
        let only = |axis| std::iter::once(axis).collect();
        let is_led = |axis| [bands.start, bands.end].iter().all(|band| band.is_on(only(axis), &trial.sense));
        self.sampler.backlash.iter().filter(|&axis| trial.sense[axis.slot()] != 0 && !is_led(axis)).collect()
    }

    /// `true` unless a piece was measured with all bodies on its sides.
    fn is_suspect(&self, active: &Active<'a>, trial: &SegmentCandidate<'a>) -> bool {
        // The rounded center of an arc may bring the turning point of an axis into a piece.
        let turns_back = || trial.circle.is_some() && trial.emitted.next_turning(self.sampler.backlash, 0.0) < 1.0;
        let are_led = self.bands(trial, self.stated(active)).are_led;
        !are_led || trial.is_torn || trial.begins_off || turns_back()
    }

    /// The distance of the tip from its place on a piece, with its bodies.
    fn of_bodies(
        &self,
        active: &Active<'a>,
        trial: &SegmentCandidate<'a>,
        allowed_mm: f64,
        scratch: &mut Vec<f64>,
    ) -> BodyError {
        let bands = self.bands(trial, self.stated(active));
        scratch.clear();
        scratch.extend((0..=PLACES).map(|k| f64::from(k) / f64::from(PLACES)));
        self.lead.edges(&bands.start, &trial.emitted, scratch);
        scratch.sort_unstable_by(f64::total_cmp);
        let tool_mm = &self.placer.setup.tool_mm;
        let off_mm = |share: f64| {
            let at = trial.parameter(share);
            let places = (&active.route.at(at), &trial.emitted.at(share));
            // A step on the spot may follow within the move: its way is not along the path, so the end counts as it is.
            let is_inner_end = share >= 1.0 && trial.between[1] < 1.0;
            let way = active.way_at(at).filter(|_| !is_inner_end);
            self.lead.error_mm(&bands.at(&self.lead, trial, share), places, tool_mm, way).nearest.norm()
        };
        let mut off = BodyError { most_mm: 0.0, good_share: 0.0 };
        for &share in scratch.iter() {
            off.most_mm = off.most_mm.max(off_mm(share));
            if off.most_mm <= allowed_mm {
                off.good_share = share;
            }
        }
        off
    }

    /// Axes with a known position after a step before a piece.
    pub(super) fn stated(&self, active: &Active<'a>) -> AxisSet {
        let known = active.motion.known;
        if self.placer.is_parallel() { known } else { self.placer.setup.frame.known_across(known, false) }
    }
}
