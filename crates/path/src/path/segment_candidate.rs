//! One candidate piece: its ends corrected and rounded, its deviation from the nominal path measured by the forward function.

use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, AxisSet, AxisVector, ROTARY_AXES};
use ncfix_machine::machine::{Control, State};

use super::PieceArc;
use super::check::Sampler;
use super::lead::Lead;
use super::place::{CommandSolver, Placed, SHORT_MM};
use super::route::{Route, distance_mm};
use super::side_plan::SidePlan;
use super::standing::PathState;

/// Share of the tolerance for the samples; the rest covers the path between them.
pub(super) const SAMPLED_SHARE: f64 = 0.96;
/// Deviation of a bend in addition to rounding if rounding alone exceeds the tolerance, as a share of it.
pub(super) const BEND_SHARE: f64 = 0.1;
/// Guesses of the direction of motion before an axis without a consistent direction is held.
const MOST_TRIES: u32 = 3;
/// Share of the tolerance by which an axis without a consistent direction may deviate before a step on the spot.
const READY_SHARE: f64 = 0.5;
/// Number of intervals for checking a piece that begins or ends off its place. The residual of a bend between them is 4 (1/16)², 2 % of the bend.
const BESIDE_ENDS: u32 = 8;
/// Arm at which the direction of the tool along a piece may deviate from that at its ends by the tolerance, mm: about a cutting edge.
pub(super) const EDGE_MM: f64 = 50.0;
/// Permitted tilt of the tool, rad, along a piece that turns differently than its move: near a pole the control moves the rotary axes in proportion, and a piece
/// that does not end there follows a great circle. The control has its own rule within its pole limit, 35 mrad.
const OTHER_TURNING_RAD: f64 = 1e-3;
/// Turn of a piece below which its direction is not examined, rad. Corrections of rotary axes change over the damped range of a singularity, 0.1 rad, so that
/// the direction bends by at most 0.5 % of them.
const LEAST_TURN_RAD: f64 = 0.02;
/// Commands nearer to each other than this are one grid position, mm.
pub(super) const SAME_PLACE_MM: f64 = 1e-9;

/// Input for candidate pieces of one move.
pub(super) struct SegmentFitter<'a, 'm> {
    pub(super) placer: &'a CommandSolver<'m>,
    pub(super) sampler: &'a Sampler,
    pub(super) lead: &'a Lead<'m>,
    pub(super) control: &'a Control,
    pub(super) route: &'a Route<'m>,
    /// Number of samples of the whole route.
    pub(super) samples: f64,
    pub(super) known: AxisSet,
    pub(super) tolerance_mm: f64,
    /// `true` if a piece may begin with a step on the spot.
    pub(super) takes_up: bool,
    /// `true` if the change of rotary corrections in a piece is limited near a singularity.
    pub(super) limits_turns: bool,
    /// Axes whose final direction is fixed, by slot: after an overshoot.
    pub(super) settled: [i8; AXIS_COUNT],
    /// The way on which the bodies of the axes are led.
    pub(super) plan: SidePlan,
}

/// A candidate piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct SegmentCandidate<'m> {
    /// Parameters of the move at its ends.
    pub(super) between: [f64; 2],
    /// Position to go to before the take-up, so that bodies approach it from the right side.
    pub(super) ready: Option<Placed>,
    /// Position to go to first, on the spot.
    pub(super) take_up: Option<Placed>,
    /// Position to go to first so that the axes reach the end in a known direction.
    pub(super) overshoot: Option<Placed>,
    pub(super) end: Placed,
    /// Direction of motion of each axis along the piece, as in [`State::direction`].
    pub(super) sense: [i8; AXIS_COUNT],
    /// As in [`PieceEnds`].
    pub(super) is_torn: bool,
    pub(super) begins_off: bool,
    pub(super) circle: Option<PieceArc>,
    /// The path of the machine.
    pub(super) emitted: Route<'m>,
    /// Largest measured deviation, mm; 0 if not measured.
    pub(super) deviation_mm: f64,
    /// Largest deviation allowed, mm.
    pub(super) allowed_mm: f64,
    /// Largest change of the direction between its ends as a share of the permitted one; 0 if not measured.
    pub(super) tilt_share: f64,
    /// Deviation due to bodies that are within their dead bands at the start, mm: it does not depend on the length.
    pub(super) brought_mm: f64,
    /// Deviation at the middle, if measured, mm.
    pub(super) middle_mm: Option<f64>,
}

/// The ends of a piece.
pub(super) struct PieceEnds {
    pub(super) ready: Option<Placed>,
    pub(super) take_up: Option<Placed>,
    pub(super) start: AxisVector,
    pub(super) end: Placed,
    pub(super) sense: [i8; AXIS_COUNT],
    /// `true` if an axis has no consistent direction at any position: the tip is then off by its backlash or, if the axis is held, by the change of
    /// its correction.
    pub(super) is_torn: bool,
    /// `true` if the start was placed for another direction or not at all: the resulting error is within the tolerance.
    pub(super) begins_off: bool,
}

impl SegmentCandidate<'_> {
    pub(super) fn fits(&self) -> bool {
        self.deviation_mm <= self.allowed_mm && self.tilt_share <= 1.0
    }

    /// Ratio of the length-dependent deviation to its allowed value; above 1 the piece does not fit.
    pub(super) fn share(&self) -> f64 {
        let of_tip = if self.fits() && self.brought_mm < self.allowed_mm {
            (self.deviation_mm - self.brought_mm).max(0.0) / (self.allowed_mm - self.brought_mm)
        } else {
            self.deviation_mm / self.allowed_mm
        };
        of_tip.max(self.tilt_share)
    }

    /// The parameter of the move at a share of the piece.
    pub(super) fn parameter(&self, share: f64) -> f64 {
        let [from, to] = self.between;
        if share < 1.0 { from + (to - from) * share } else { to }
    }

    /// State of the errors along the piece, besides the commands.
    pub(super) fn state(&self) -> State {
        state_of(self.sense)
    }
}

/// The state of a program that is not simulated in time: accelerations are unknown.
pub(super) fn state_of(sense: [i8; AXIS_COUNT]) -> State {
    State { direction: sense, ..State::default() }
}

impl<'m> SegmentFitter<'_, 'm> {
    /// The whole move of these output axes as programmed; the others stay.
    pub(super) fn as_programmed(&self, standing: &PathState, moving: AxisSet) -> SegmentCandidate<'m> {
        self.unplaced(standing, self.placer.partly(&self.route.end, standing, moving, self.known))
    }

    /// The whole move of these output axes to their corrected positions; the others stay. An axis that the program does not move stays too.
    pub(super) fn of_named(&self, standing: &PathState, moving: AxisSet) -> SegmentCandidate<'m> {
        let [start, end] = [&self.route.start, &self.route.end].map(|command| self.placer.programmed(command));
        let stands = standing.known.intersection(standing.written);
        // An overshoot brings an axis to another side of its dead band, at which it has another place.
        let is_still = |axis: Axis| self.settled[axis.slot()] == 0 && (end[axis] - start[axis]).abs() < SHORT_MM;
        let rests = |axis: &Axis| stands.contains(*axis) && is_still(*axis);
        let moving: AxisSet = moving.iter().filter(|axis| !rests(axis)).collect();
        let ends = self.ends(standing, [0.0, 1.0], false);
        let partly = |target: &AxisVector, state: &State| {
            let mut target = *target;
            // A rotary axis that the program does not move is written with its correction by a later move. The tip must be at its place with it as it stands.
            for axis in ROTARY_AXES.into_iter().filter(|&axis| !moving.contains(axis)) {
                target[axis] =
                    if standing.known.contains(axis) { standing.command[axis] } else { self.route.end[axis] };
            }
            if self.placer.has_rotary {
                target = self.placer.around(&self.route.end, self.known, state, &target).unwrap_or(target);
            }
            self.placer.partly(&target, standing, moving, self.known)
        };
        let mut trial = self.unplaced(standing, partly(&ends.end.command, &standing.state));
        if self.sampler.backlash.is_empty() {
            return trial;
        }
        // The end was placed for a motion of all axes. One that stays does not reverse, and what it displaces across it stays too.
        let mut state = trial.state();
        self.settle(&mut state);
        for _ in 0..MOST_TRIES {
            let placed = self.place([0.0, 1.0], &self.route.end, &state, &standing.correction);
            trial = self.unplaced(standing, Placed { failure: placed.failure, ..partly(&placed.command, &state) });
            let mut led = trial.state();
            self.settle(&mut led);
            // A body that is led to no side is where the axis leaves it.
            let is_placed = |axis: Axis| {
                let own = led.direction(axis);
                own == state.direction(axis) || own == 0 && moving.contains(axis)
            };
            if self.sampler.backlash.iter().all(is_placed) {
                break;
            }
            state = led;
        }
        trial
    }

    /// The whole move straight to an end, with the deviation along it.
    pub(super) fn at_end(&self, standing: &PathState, end: Placed, scratch: &mut Vec<f64>) -> SegmentCandidate<'m> {
        // Its ends are not at their places: they count too.
        let mut trial = SegmentCandidate { begins_off: true, ..self.unplaced(standing, end) };
        self.measure(standing, &mut trial, scratch);
        trial
    }

    /// The whole move straight to an end that is not placed for the full pose.
    fn unplaced(&self, standing: &PathState, end: Placed) -> SegmentCandidate<'m> {
        let state = self.led(standing, &[standing.command, end.command], false);
        let emitted = self.placer.emitted(standing.command, end.command);
        let ends = PieceEnds {
            ready: None,
            take_up: None,
            start: standing.command,
            end,
            sense: state.direction,
            is_torn: false,
            begins_off: false,
        };
        self.trial([0.0, 1.0], ends, emitted, None)
    }

    /// The piece as a straight line, without measured deviation.
    pub(super) fn unmeasured(&self, standing: &PathState, between: [f64; 2]) -> SegmentCandidate<'m> {
        let ends = self.ends(standing, between, false);
        let emitted = self.placer.emitted(ends.start, ends.end.command);
        self.trial(between, ends, emitted, None)
    }

    /// The piece as a straight line.
    pub(super) fn straight(
        &self,
        standing: &PathState,
        between: [f64; 2],
        scratch: &mut Vec<f64>,
    ) -> SegmentCandidate<'m> {
        let mut trial = self.unmeasured(standing, between);
        self.measure(standing, &mut trial, scratch);
        trial
    }

    /// The piece as an arc; `None` if the rounded ends allow none.
    pub(super) fn arc(
        &self,
        standing: &PathState,
        between: [f64; 2],
        scratch: &mut Vec<f64>,
    ) -> Option<SegmentCandidate<'m>> {
        let mut trial = self.unmeasured_arc(standing, between)?;
        self.measure(standing, &mut trial, scratch);
        Some(trial)
    }

    pub(super) fn trial(
        &self,
        between: [f64; 2],
        ends: PieceEnds,
        emitted: Route<'m>,
        circle: Option<PieceArc>,
    ) -> SegmentCandidate<'m> {
        SegmentCandidate {
            between,
            ready: ends.ready,
            take_up: ends.take_up,
            overshoot: None,
            end: ends.end,
            sense: ends.sense,
            is_torn: ends.is_torn,
            begins_off: ends.begins_off,
            circle,
            emitted,
            deviation_mm: 0.0,
            tilt_share: 0.0,
            allowed_mm: SAMPLED_SHARE * self.tolerance_mm,
            brought_mm: 0.0,
            middle_mm: None,
        }
    }

    /// Corrects and rounds the ends. The direction of motion along the piece depends on the resulting commands, so it is guessed from the program and
    /// corrected in further attempts.
    pub(super) fn ends(&self, standing: &PathState, between: [f64; 2], is_arc: bool) -> PieceEnds {
        let nominal_end = self.route.at(between[1]);
        let place = |nominal: &AxisVector, state: &State, correction: &AxisVector| {
            self.unmoved(standing, self.place(between, nominal, state, correction))
        };
        if self.sampler.backlash.is_empty() && !standing.is_doubtful {
            let end = place(&nominal_end, &standing.state, &standing.correction);
            let sense = standing.state.direction;
            return PieceEnds {
                ready: None,
                take_up: None,
                start: standing.command,
                end,
                sense,
                is_torn: false,
                begins_off: false,
            };
        }
        let nominal_start = self.route.at(between[0]);
        let mut sense = standing.state;
        sense.note_stated(standing.sensed, &nominal_start, &nominal_end);
        self.settle(&mut sense);
        self.plan.direct(&mut sense, &standing.state);
        let mut tries = 0;
        let mut enough_mm = self.plan.ready_share * self.tolerance_mm;
        loop {
            let mut take_up = None;
            let turns = !self.same_sense(&sense, &standing.state);
            if self.takes_up
                && (standing.is_doubtful || turns)
                && self.turning_mm(standing, &nominal_start, &sense) > enough_mm
            {
                let start = place(&nominal_start, &sense, &standing.correction);
                let is_elsewhere = distance_mm(&start.command, &standing.command) > SAME_PLACE_MM;
                take_up = Some(start)
                    .filter(|start| is_elsewhere && !self.leads_away(standing, (start, between[0]), &sense, enough_mm));
            }
            let ready = take_up.and_then(|start| self.ready(standing, &start, &sense));
            let start = take_up.map_or(standing.command, |placed| placed.command);
            let correction = take_up.map_or(standing.correction, |placed| placed.command - nominal_start);
            let end = self.hold_words(standing, take_up.as_ref(), place(&nominal_end, &sense, &correction));
            // The actual motion: an axis that does not move keeps its direction, not the guessed one.
            let first = ready.map_or(standing.command, |placed| placed.command);
            let mut led = self.led(standing, &[standing.command, first, start, end.command], is_arc);
            self.settle(&mut led);
            let mut state = led;
            self.turn(standing, &mut state, &sense, &end.command);
            tries += 1;
            let is_torn = !self.same_sense(&state, &sense);
            let begins_off = take_up.is_none() && (standing.is_doubtful || !self.same_sense(&state, &standing.state));
            let ends = PieceEnds { ready, take_up, start, end, sense: led.direction, is_torn, begins_off };
            if !is_torn || tries == 2 * MOST_TRIES {
                return ends;
            }
            if tries == MOST_TRIES {
                if let Some(held) = self.held(standing, between, (&state, &sense), is_arc) {
                    return held;
                }
                // The program moves the axis by less than its backlash. A step on the spot makes room for that, though without it the tip error would
                // be within the tolerance here.
                enough_mm = enough_mm.min(READY_SHARE * self.tolerance_mm);
            }
            sense = state;
        }
    }

    /// An axis whose word does not change is not written and does not move, although a new frame has another grid. If the frame rotates or scales, a
    /// word does not belong to one axis; the grids then differ by noise only.
    pub(super) fn unmoved(&self, standing: &PathState, mut placed: Placed) -> Placed {
        let is_parallel = self.placer.is_parallel();
        for axis in standing.written.iter().filter(|axis| is_parallel || axis.slot() > 2) {
            if placed.counts[axis.slot()] == standing.counts[axis.slot()] {
                placed.command[axis] = standing.command[axis];
            }
        }
        // Rounding noise of a rotated frame must not move an axis: it would reverse its backlash.
        for axis in AXES {
            if (placed.command[axis] - standing.command[axis]).abs() < SAME_PLACE_MM {
                placed.command[axis] = standing.command[axis];
            }
        }
        placed
    }

    /// Measures the deviation at all relevant places.
    fn measure(&self, standing: &PathState, trial: &mut SegmentCandidate<'_>, scratch: &mut Vec<f64>) {
        let [from, to] = trial.between;
        let state = trial.state();
        self.sampler.fractions((self.route, self.samples), trial.between, &trial.emitted, scratch);
        if trial.is_torn || trial.begins_off {
            // Ends that were placed for the actual direction are correct except for rounding. Otherwise the largest deviation may be anywhere between
            // them.
            scratch.extend((0..=BESIDE_ENDS).map(|k| f64::from(k) / f64::from(BESIDE_ENDS)));
        }
        // Bodies pass their dead bands on the way.
        let lags = (trial.begins_off || trial.is_torn) && !self.lead.axes.is_empty();
        let mut first = standing.band;
        if lags {
            let mut last = standing.command;
            for step in [trial.ready, trial.take_up].into_iter().flatten() {
                let way = self.placer.emitted(last, step.command);
                self.lead.along(&mut first, &way, standing.sensed, [0.0, 1.0]);
                last = step.command;
            }
            self.lead.edges(&first, &trial.emitted, scratch);
        }
        let of_bodies = |trial: &SegmentCandidate<'_>, fraction: f64| {
            let mut band = first;
            self.lead.along(&mut band, &trial.emitted, standing.sensed, [0.0, fraction]);
            let at = trial.parameter(fraction);
            let way = (at < 1.0).then_some((self.route, at));
            let places = (&self.route.at(at), &trial.emitted.at(fraction));
            self.lead.error_mm(&band, places, &self.placer.setup.tool_mm, way).middle.norm()
        };
        trial.brought_mm = if lags { of_bodies(trial, 0.0) } else { 0.0 };
        for &fraction in &*scratch {
            let deviation = if lags {
                of_bodies(trial, fraction)
            } else {
                let nominal = self.route.at(from + (to - from) * fraction);
                self.placer.tip_error_mm(&nominal, &trial.emitted.at(fraction), &state)
            };
            trial.deviation_mm = trial.deviation_mm.max(deviation);
            if fraction == 0.5 {
                trial.middle_mm = Some(deviation);
            }
        }
        let pushed_mm = self.pushed_mm(standing, trial);
        trial.brought_mm = trial.brought_mm.max(pushed_mm);
        trial.deviation_mm = trial.deviation_mm.max(pushed_mm);
        // Next to a singularity a correction that is held back tilts the tool, whatever the length.
        let turns = !self.placer.turning().is_empty() && self.route.turned_rad(to - from) > LEAST_TURN_RAD;
        if turns && !trial.end.is_held_back {
            trial.tilt_share = self.tilt_share(trial, &state, scratch);
        }
        if trial.deviation_mm > trial.allowed_mm {
            // Rounding at the ends is no reason to cut: another end has the same rounding. Nor is the initial error, but backlash is.
            let at = |parameter: f64, command: &AxisVector| {
                self.placer.tip_error_mm(&self.route.at(parameter), command, &state)
            };
            let mut end = at(to, &trial.emitted.end);
            if trial.is_torn {
                end = end.min(self.placer.increments.rounding_mm());
            }
            let ends = at(from, &trial.emitted.start).max(end).max(trial.brought_mm);
            if ends > SAMPLED_SHARE * self.tolerance_mm {
                trial.allowed_mm = SAMPLED_SHARE * (1.0 + BEND_SHARE) * ends;
            }
        }
    }

    /// The largest tilt of the tool at these fractions of a piece, as a share of the permitted one: that at its ends, and the tolerance at [`EDGE_MM`].
    fn tilt_share(&self, trial: &SegmentCandidate<'_>, state: &State, fractions: &[f64]) -> f64 {
        let tilt_rad = |fraction: f64| {
            let nominal = self.route.at(trial.parameter(fraction));
            self.placer.tilt_rad(&nominal, &trial.emitted.at(fraction), state)
        };
        let is_same = self.route.turns_in_proportion() == trial.emitted.turns_in_proportion();
        let of_turning_rad = if is_same { self.tolerance_mm / EDGE_MM } else { OTHER_TURNING_RAD };
        let room_rad = of_turning_rad + 2.0 * self.placer.increments.rotary_deg.to_radians();
        let permitted_rad = tilt_rad(0.0).max(tilt_rad(1.0)) + room_rad;
        fractions.iter().map(|&fraction| tilt_rad(fraction)).fold(0.0, f64::max) / permitted_rad
    }
}
