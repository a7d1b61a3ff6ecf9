//! Approaches that determine the side of the dead band of an axis.
//!
//! A rapid move exceeds its end by the lost motion and a quarter of it, and returns. The tool axis does so away from the workpiece. An axis across
//! the tool does so only if the next move descends along the tool: the tool is then above the place that it cuts.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, AxisSet, AxisVector, Vector};
use ncfix_machine::snc::{Element, MotionMode, Move};
use ncfix_model::DeadBand;

use super::{Active, Corrector};
use crate::path::Rapids;
use crate::path::ahead::Upcoming;
use crate::path::lead::Lead;
use crate::path::route::Route;
use crate::path::segment_candidate::SegmentCandidate;
use crate::path::treatment::MoveTreatment;

/// An axis that lifts the tool by more than `ALONG` of its path is along the tool, one below `ACROSS` is across it.
const ALONG: f64 = 0.99;
const ACROSS: f64 = 0.01;
/// Number of intervals of a piece at whose ends an unknown side is examined.
const UNKNOWN_PLACES: u32 = 8;

/// Tolerance of equal tool directions, rad, and of equal heights, mm.
const SAME: f64 = 1e-6;

/// The highest place along the tool that was cut so far: above it there is no material beside a cut.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cut {
    /// Direction from the tip to the spindle, in the workpiece; `None` before the first cut.
    direction: Option<Vector>,
    /// Height along it, mm; infinite if the tool has cut in several directions.
    top_mm: f64,
}

/// Positions of the axes in their dead bands on a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bands {
    pub(super) start: DeadBand,
    pub(super) end: DeadBand,
    /// Axes with a known direction of motion.
    pub(super) sensed: AxisSet,
    /// `true` if all axes are on the sides for which they were placed.
    pub(super) are_led: bool,
}

impl Active<'_> {
    /// The path on which the tool may lag at a parameter; `None` at its end, where it must have arrived.
    pub(super) fn way_at(&self, parameter: f64) -> Option<(&Route<'_>, f64)> {
        (parameter < 1.0).then_some((&self.route, parameter))
    }
}

impl Bands {
    /// The state at a share of the piece.
    pub(super) fn at(&self, lead: &Lead<'_>, trial: &SegmentCandidate<'_>, share: f64) -> DeadBand {
        let mut band = self.start;
        lead.along(&mut band, &trial.emitted, self.sensed, [0.0, share]);
        band
    }
}

impl<'a, I> Corrector<'a, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// Dead-band state after a path on which no axis reverses.
    pub(super) fn led(&self, mut band: DeadBand, from: &AxisVector, to: &AxisVector) -> DeadBand {
        self.lead.along(&mut band, &self.placer.emitted(*from, *to), self.standing.sensed, [0.0, 1.0]);
        band
    }

    /// Effect of a piece on the dead bands; `stated` are the axes with known positions after a step before it.
    pub(super) fn bands(&self, trial: &SegmentCandidate<'_>, stated: AxisSet) -> Bands {
        let mut start = self.standing.band;
        let mut sensed = self.standing.sensed;
        if self.sampler.backlash.is_empty() {
            return Bands { start, end: start, sensed, are_led: true };
        }
        let mut from = self.standing.command;
        for step in [trial.ready, trial.take_up, trial.overshoot].into_iter().flatten() {
            self.lead.along(&mut start, &self.placer.emitted(from, step.command), sensed, [0.0, 1.0]);
            from = step.command;
            sensed = sensed.union(stated);
        }
        let mut end = start;
        self.lead.along(&mut end, &trial.emitted, sensed, [0.0, 1.0]);
        let are_led = [start, end].iter().all(|band| band.is_on(self.sampler.backlash, &trial.sense));
        Bands { start, end, sensed, are_led }
    }

    /// Reports cutting axes whose approach direction is unknown, if their backlash matters.
    pub(super) fn check_sense(&mut self, active: &Active<'_>, bands: &Bands, trial: &SegmentCandidate<'_>) {
        if bands.are_led || active.motion.rapid {
            return;
        }
        let tool_mm = &self.placer.setup.tool_mm;
        let mut most_mm = [0.0_f64; AXIS_COUNT];
        for k in 0..=UNKNOWN_PLACES {
            let share = f64::from(k) / f64::from(UNKNOWN_PLACES);
            let band = bands.at(&self.lead, trial, share);
            let at = trial.parameter(share);
            let places = (&active.route.at(at), &trial.emitted.at(share));
            for axis in self.sampler.backlash.iter() {
                let off_mm = self.lead.unknown_mm(&band, axis, places, tool_mm, active.way_at(at));
                most_mm[axis.slot()] = most_mm[axis.slot()].max(off_mm);
            }
        }
        for axis in self.sampler.backlash.iter() {
            if most_mm[axis.slot()] > self.options.tolerance_mm {
                self.findings.sense_unknown(&active.origin, axis, most_mm[axis.slot()]);
            }
        }
    }

    /// Records the height of a cut.
    pub(super) fn note_cut(&mut self, motion: &Move) {
        if self.sampler.backlash.is_empty() || motion.rapid {
            return;
        }
        let route = self.placer.nominal(self.standing.nominal, motion);
        for command in [route.start, route.end] {
            let (direction, height_mm) = self.placer.height_at(&command);
            let reach_mm = height_mm + self.rise_mm(&route, &command);
            let top_mm = match self.cut.direction {
                None => reach_mm,
                Some(before) if (before - direction).norm() < SAME => reach_mm.max(self.cut.top_mm),
                Some(_) => f64::INFINITY,
            };
            self.cut = Cut { direction: Some(direction), top_mm };
        }
    }

    /// Largest rise of an arc along the tool above its ends, mm: its diameter, times the inclination of its plane.
    fn rise_mm(&self, route: &Route<'_>, command: &AxisVector) -> f64 {
        let Some(arc) = route.arc() else { return 0.0 };
        let [abscissa, ordinate, _] = arc.plane.axes();
        if route.is_of_tip() || route.basis().is_some() {
            // A bound: along the tool the arc rises by no more than its diameter.
            return 2.0 * route.radius_mm();
        }
        let [one, other] = [abscissa, ordinate].map(|axis| self.rise_of(axis, command));
        2.0 * route.radius_mm() * one.hypot(other)
    }

    /// Rise of the tool per millimeter of an axis, mm.
    fn rise_of(&self, axis: Axis, command: &AxisVector) -> f64 {
        let mut further = *command;
        further[axis] += 1.0;
        self.placer.height_mm(command, &further)
    }

    /// `true` if the tool is at least as high as at all places that it has cut so far.
    fn is_above_cuts(&self, command: &AxisVector) -> bool {
        let (direction, height_mm) = self.placer.height_at(command);
        self.cut.direction.is_none_or(|before| (before - direction).norm() < SAME && height_mm > self.cut.top_mm - SAME)
    }

    /// Directions in which axes should reach the end of a rapid move, by slot; 0 if known already, or without room. `moving` are the axes that the
    /// move moves.
    pub(super) fn settling(&mut self, motion: &Move, treatment: MoveTreatment, moving: AxisSet) -> [i8; AXIS_COUNT] {
        let mut settled = [0; AXIS_COUNT];
        let is_end = matches!(treatment, MoveTreatment::Named | MoveTreatment::End);
        let is_plain = motion.rapid && motion.motion_mode == MotionMode::Path && self.options.rapids == Rapids::Ends;
        if self.sampler.backlash.is_empty() || !is_end || !is_plain || !self.placer.is_parallel() {
            return settled;
        }
        let band = self.led(self.standing.band, &self.standing.nominal, &motion.target);
        let is_open = |axis: &Axis| !axis.is_rotary() && band.direction()[axis.slot()] == 0;
        let lost = |axis: Axis| self.placer.model.lost_motion(axis, &motion.target);
        let open = moving.intersection(self.sampler.backlash).iter().filter(is_open);
        let open: AxisSet = open.filter(|&axis| lost(axis) > self.options.tolerance_mm).collect();
        if open.is_empty() {
            return settled;
        }
        // If the program has not stated the height, the tool is at the change position or where an operator left it. If the next move is along the
        // tool, it leads to the workpiece.
        let is_height_known = AxisSet::XYZ
            .iter()
            .all(|axis| motion.known.contains(axis) || self.rise_of(axis, &motion.target).abs() < ACROSS);
        let upcoming = self.elements.next();
        let goes_down = match upcoming {
            Upcoming::Move(next) if !is_height_known || self.is_above_cuts(&motion.target) => {
                (!is_height_known || self.placer.height_mm(&motion.target, &next.target) < 0.0) && {
                    let ends = [&motion.target, &next.target];
                    let moving = self.placer.moving(next.named, motion.known, ends);
                    self.placer.is_along_tool(moving, ends)
                }
            }
            Upcoming::Move(_) => false,
            Upcoming::Change | Upcoming::Nothing => return settled,
        };
        let drift = match upcoming {
            Upcoming::Move(next) if goes_down && is_height_known => self.drift(motion, &next),
            _ => AxisVector::ZERO,
        };
        for axis in open.iter() {
            let height_mm = self.rise_of(axis, &motion.target);
            settled[axis.slot()] = match () {
                () if height_mm > ALONG => -1,
                () if height_mm < -ALONG => 1,
                () if height_mm.abs() > ACROSS => 0,
                () if !goes_down => 0,
                // The body of an axis at rest follows its correction only on this side.
                () if drift[axis] < -self.options.tolerance_mm
                    && self.has_room(axis, motion.target[axis], self.beyond_mm(axis, &motion.target)) =>
                {
                    -1
                }
                () if self.has_room(axis, motion.target[axis], -self.beyond_mm(axis, &motion.target)) => 1,
                () => -1,
            };
            let back_mm = -f64::from(settled[axis.slot()]) * self.beyond_mm(axis, &motion.target);
            if !self.has_room(axis, motion.target[axis], back_mm) {
                settled[axis.slot()] = 0;
            }
        }
        settled
    }

    /// Change of the correction of each axis along the next move, mm and rad; zero where no correction is found.
    fn drift(&self, motion: &Move, next: &Move) -> AxisVector {
        let (state, guess) = (self.standing.state, self.standing.correction);
        let corrected = |at: &Move| self.placer.exact(&at.target, at.known, &state, &guess, f64::INFINITY);
        match [corrected(motion), corrected(next)] {
            [Ok(here), Ok(there)] => (there - next.target) - (here - motion.target),
            _ => AxisVector::ZERO,
        }
    }

    /// Length of an overshoot, mm.
    pub(super) fn beyond_mm(&self, axis: Axis, command: &AxisVector) -> f64 {
        self.lead.beyond_mm(axis, command, self.placer.increments.linear_mm)
    }

    /// `true` if the travel of an axis allows a step beyond a place, including its correction.
    pub(super) fn has_room(&self, axis: Axis, command: f64, step_mm: f64) -> bool {
        let reach = command + step_mm + self.options.max_correction_mm * step_mm.signum();
        let travel = self.machine.axis(axis).and_then(|data| data.travel);
        step_mm.abs() <= self.options.max_correction_mm
            && travel.is_none_or(|[low, high]| (low..=high).contains(&reach))
    }

    /// Adds the overshoot position before the end, for axes that should reach it in a known direction.
    pub(super) fn overshoot(&self, active: &Active<'_>, trial: &mut SegmentCandidate<'a>) {
        if active.settled == [0; AXIS_COUNT] || trial.between[1] < 1.0 || trial.end.failure.is_some() {
            return;
        }
        let mut beyond = trial.end.command;
        for axis in AXES {
            let back = -f64::from(active.settled[axis.slot()]);
            if back != 0.0 {
                beyond[axis] += back * self.beyond_mm(axis, &beyond);
            }
        }
        let mut placed = self.placer.round(&beyond, active.motion.known);
        for axis in AXES.into_iter().filter(|axis| active.settled[axis.slot()] == 0) {
            placed.counts[axis.slot()] = trial.end.counts[axis.slot()];
            placed.command[axis] = trial.end.command[axis];
        }
        trial.emitted = self.placer.emitted(placed.command, trial.end.command);
        trial.overshoot = Some(placed);
    }
}
