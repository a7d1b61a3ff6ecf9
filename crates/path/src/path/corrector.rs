//! The corrector: an iterator that takes elements and returns corrected pieces and all other elements, in order, one move at a time.

mod between;
mod bodies;
mod clamps;
mod dead_band;
mod hole;
mod pace;
mod write;

use std::collections::VecDeque;
use std::sync::Arc;

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXIS_COUNT, AxisSet};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{BlockNumber, Element, Kind, MotionMode, Move, Origin};
use ncfix_model::Model;

use super::ahead::Ahead;
use super::check::Sampler;
use super::cut::{fit_arc, fit_line, line_for_short_arc, next_step};
use super::extend::SearchBounds;
use super::findings::{DiagnosticCollector, placing_axes};
use super::lead::Lead;
use super::place::CommandSolver;
use super::poses::PoseSampler;
use super::route::Route;
use super::segment_candidate::{SegmentCandidate, SegmentFitter};
use super::side_plan::SidePlan;
use super::standing::PathState;
use super::tip_divider::TipDivider;
use super::treatment::{MoveTreatment, is_pushed_out};
use super::{Arcs, CorrectionOptions, Increments, Output, Piece, PoseSample, Prediction, Rotary, Subdivision};
use clamps::{Clamps, rotary_axes};

/// Minimum length of a piece, mm.
const SHORTEST_MM: f64 = 0.01;

/// Corrects a stream of elements. Diagnostics are items of the stream too: after an error the correction goes on, so that one run reports all of
/// them.
pub struct Corrector<'a, I> {
    elements: Ahead<'a, I>,
    machine: &'a Machine,
    options: CorrectionOptions,
    placer: CommandSolver<'a>,
    sampler: Sampler,
    lead: Lead<'a>,
    cut: dead_band::Cut,
    placing: AxisSet,
    clamps: Clamps,
    standing: PathState,
    ever_named: AxisSet,
    active: Option<Box<Active<'a>>>,
    /// Reused storage for the next move.
    idle: Option<Box<Active<'a>>>,
    pending: VecDeque<Result<Output, Diagnostic>>,
    findings: DiagnosticCollector<'a>,
    prediction: Prediction,
    poses: PoseSampler,
    pace: pace::Pace,
    /// The initial level, if the last output was a drilling cycle.
    initial: Option<hole::InitialLevel>,
    /// Shift of the last hole along the drilling axis, increments.
    last_shift: i64,
    /// Pieces whose bodies no way leads where they should be.
    in_vain: u32,
    scratch: Vec<f64>,
}

/// The move in progress.
#[derive(Debug)]
struct Active<'a> {
    /// Deviation of its pieces above which it is reported, mm.
    tolerance_mm: f64,
    origin: Origin,
    starts_block: bool,
    number: Option<BlockNumber>,
    motion: Move,
    /// Axes of the output that the program moves.
    moving: AxisSet,
    treatment: MoveTreatment,
    route: Route<'a>,
    /// Number of samples of the whole route.
    samples: f64,
    /// Its time, if the correction may change the path to which its feed refers.
    pacing: Option<pace::Pacing>,
    /// Its time at the programmed feed, s; `None` if the machine file states no block cycle, or the move has no such feed.
    duration_s: Option<f64>,
    /// Parameter at which the next piece begins.
    parameter: f64,
    /// Length of the last piece, as a parameter; before the first piece, the whole move.
    length: f64,
    is_first: bool,
    /// Share of the time of unwritten pieces, which are shorter than an increment.
    unwritten: f64,
    /// No useful arc fits; the arc becomes chords.
    as_chords: bool,
    /// `true` if its error counts in the prediction.
    is_counted: bool,
    /// Parameter up to which its errors are sampled.
    sampled: f64,
    /// As in [`SegmentFitter::settled`].
    settled: [i8; AXIS_COUNT],
}

impl<'a, I> Corrector<'a, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// Starts a correction. The model must belong to the machine.
    #[must_use]
    pub fn new(elements: I, machine: &'a Machine, model: &'a Model, options: CorrectionOptions) -> Self {
        let mut standing = PathState::default();
        if let Some(start) = options.start {
            // The start is the position in the control, uncorrected.
            standing.nominal = start;
            standing.command = start;
            standing.known = machine.axis_set();
            standing.written = standing.known;
            standing.is_doubtful = true;
        }
        let is_looked_for = options.rotary == Rotary::Auto && model.has_errors();
        let rotary = if is_looked_for { rotary_axes(machine) } else { AxisSet::EMPTY };
        // Without the transformation, the control moves the axes straight: the path of the tip is then one of chords.
        let tips = (!options.keeps_transform()).then(|| TipDivider::new(machine, standing.nominal));
        Corrector {
            elements: Ahead::new(elements, machine, rotary, tips),
            clamps: Clamps::new(machine),
            machine,
            placer: CommandSolver::new(machine, model, &options),
            lead: Lead::new(model, machine),
            sampler: sampler_of(model, machine, &options),
            cut: dead_band::Cut::default(),
            placing: placing_axes(machine),
            standing,
            ever_named: AxisSet::EMPTY,
            active: None,
            idle: None,
            pending: VecDeque::with_capacity(8),
            findings: DiagnosticCollector::new(machine, options.max_correction_mm),
            prediction: Prediction::default(),
            poses: PoseSampler::default(),
            pace: pace::Pace::default(),
            initial: None,
            last_shift: 0,
            in_vain: 0,
            scratch: Vec::with_capacity(64),
            options,
        }
    }

    /// The error along the path so far; complete at the end of the stream.
    #[must_use]
    pub fn prediction(&self) -> &Prediction {
        &self.prediction
    }

    /// Sampled poses of the corrected moves so far, spread over the program.
    #[must_use]
    pub fn poses(&self) -> &[PoseSample] {
        self.poses.kept()
    }

    /// The underlying stream of elements.
    #[must_use]
    pub fn elements(&self) -> &I {
        self.elements.elements()
    }

    fn begin(&mut self, element: &Element, motion: &Move) {
        let (named, known, unknown) = self.placer.in_output_axes(motion);
        let is_turned_thread = matches!(motion.motion_mode, MotionMode::Thread(_)) && self.placer.turns_output();
        self.findings.in_machine_frame(&element.origin, unknown, is_turned_thread);
        let standing = &mut self.standing;
        let starts_at_known = named.difference(standing.known).is_empty();
        let is_placed = self.placing.difference(known).is_empty();
        let frame = &self.placer.setup.frame;
        let is_parallel = self.placer.is_parallel();
        standing.sensed = if is_parallel { standing.known } else { frame.known_across(standing.known, false) };
        standing.written = standing.written.intersection(known);
        self.ever_named = self.ever_named.union(named);
        if self.pace.counts_turns && self.placer.leaves_transform() && !motion.rapid {
            self.findings.feed_of_turns(&element.origin);
        }
        let treatment = MoveTreatment::of(motion.rapid, self.options.rapids, starts_at_known && is_placed);
        let (treatment, moving) = if motion.rapid || motion.motion_mode == MotionMode::Reference {
            let ends = [&standing.nominal, &motion.target];
            let moving = self.placer.moving(named, standing.known.intersection(known), ends);
            (self.treatment_of_rapid(motion, treatment, moving), moving)
        } else {
            (treatment, named)
        };
        self.fix(motion, moving);
        self.note_cut(motion);
        let settled = self.settling(motion, treatment, moving);
        let route = self.placer.nominal(self.standing.nominal, motion);
        let feed = self.placer.feed(&self.standing.nominal, motion);
        self.prediction.moves += 1;
        let samples = self.sampler.whole(&route);
        let cycle_s = self.machine.control.block_cycle_s;
        let make = || Active {
            origin: element.origin,
            starts_block: element.starts_block,
            number: element.number,
            motion: Move { feed, named, known, ..*motion },
            moving,
            treatment,
            samples,
            pacing: self.placer.pacing(self.options.feeds, &route, motion, feed),
            duration_s: cycle_s.and_then(|_| self.placer.duration_s(self.options.feeds, &route, motion, feed)),
            route,
            parameter: 0.0,
            length: 1.0,
            is_first: true,
            unwritten: 0.0,
            as_chords: self.options.arcs == Arcs::Chords,
            tolerance_mm: self.options.tolerance_mm,
            is_counted: starts_at_known && self.ever_named.difference(known).is_empty(),
            sampled: 0.0,
            settled,
        };
        self.active = Some(match self.idle.take() {
            Some(mut idle) => {
                *idle = make();
                idle
            }
            None => Box::new(make()),
        });
        if let (Some(cycle_s), Some(duration_s)) = (cycle_s, self.active.as_ref().and_then(|active| active.duration_s))
        {
            self.prediction.short_blocks.note_source(duration_s, cycle_s);
        }
    }

    /// Makes the next piece of the move.
    fn advance(&mut self, mut active: Box<Active<'a>>) -> Option<Piece> {
        let mut scratch = std::mem::take(&mut self.scratch);
        let mut trial = self.next_piece(&mut active, &mut scratch);
        self.lead_bodies(&active, &mut trial, &mut scratch);
        self.scratch = scratch;
        self.overshoot(&active, &mut trial);
        let piece = self.accept(&mut active, &trial);
        if active.parameter < 1.0 {
            self.active = Some(active);
        } else {
            self.standing.known = active.motion.known;
            self.standing.is_doubtful |= active.treatment.leaves_others();
            self.idle = Some(active);
        }
        piece
    }

    /// The fitter of pieces of a move.
    fn fitter<'b>(&'b self, active: &'b Active<'a>) -> SegmentFitter<'b, 'a> {
        SegmentFitter {
            placer: &self.placer,
            sampler: &self.sampler,
            lead: &self.lead,
            control: &self.machine.control,
            route: &active.route,
            samples: active.samples,
            known: active.motion.known,
            tolerance_mm: self.options.tolerance_mm,
            takes_up: active.treatment == MoveTreatment::RotaryDirection
                && active.motion.motion_mode == MotionMode::Path,
            limits_turns: active.treatment == MoveTreatment::RotaryDirection,
            settled: active.settled,
            plan: SidePlan::default(),
        }
    }

    fn next_piece(&self, active: &mut Active<'a>, scratch: &mut Vec<f64>) -> SegmentCandidate<'a> {
        let bench = self.fitter(active);
        let standing = &self.standing;
        let (route, from) = (&active.route, active.parameter);
        match active.treatment {
            MoveTreatment::Programmed => return bench.as_programmed(standing, active.moving),
            MoveTreatment::Named => return bench.of_named(standing, active.moving),
            MoveTreatment::End | MoveTreatment::RotaryDirection => {}
        }
        // A move that a control may make in either direction has no defined path to cut.
        let is_whole = active.motion.motion_mode != MotionMode::Path || active.motion.turns_either_way();
        if is_whole && active.treatment == MoveTreatment::RotaryDirection {
            return bench.straight(standing, [from, 1.0], scratch);
        }
        if active.treatment == MoveTreatment::End || self.placer.model.is_empty() {
            if route.arc().is_none() {
                let trial = bench.unmeasured(standing, [from, 1.0]);
                if active.motion.rapid && is_pushed_out(self.machine, &route.end, &trial.end.command) {
                    let programmed = bench.as_programmed(standing, active.moving);
                    active.treatment = MoveTreatment::Programmed;
                    return programmed;
                }
                return trial;
            }
            // Without errors only rounding bends an arc: it rotates the bisector of a chord that is not much longer than an increment.
            let whole = match active.treatment {
                MoveTreatment::End => bench.unmeasured_arc(standing, [from, 1.0]),
                _ => bench.arc(standing, [from, 1.0], scratch).filter(SegmentCandidate::fits),
            };
            if let Some(trial) = whole.filter(|_| !active.as_chords) {
                return trial;
            }
        }
        let checkable = from + self.sampler.longest_share(active.samples);
        let turning = route.next_turning(self.sampler.backlash, from).min(checkable);
        if let (Subdivision::Step(step_mm), None) = (self.options.subdivision, route.arc()) {
            return bench.unmeasured(standing, [from, next_step(route.leading_mm(), from, step_mm)]);
        }
        let step = match self.options.subdivision {
            Subdivision::Adaptive => f64::INFINITY,
            Subdivision::Step(step_mm) => step_mm / route.size_mm(),
        };
        if route.arc().is_some() && !active.as_chords {
            if let Some(line) = line_for_short_arc(&bench, standing, [from, turning.min(from + step)], scratch) {
                return line;
            }
            if let Some(trial) = fit_arc(&bench, standing, [from, turning.min(from + step)], active.length, scratch) {
                return trial;
            }
            active.as_chords = true;
            active.length = 1.0;
        }
        let bench = self.fitter(active);
        let limit = turning.min(from + step);
        let mut first = None;
        if active.length >= limit - from {
            // Most moves of a surface are one piece, which a single attempt confirms.
            let whole = bench.straight(standing, [from, limit], scratch);
            if whole.fits() && !whole.end.is_held_back {
                return whole;
            }
            first = Some(whole);
        }
        let floor = SHORTEST_MM / active.route.size_mm();
        let reach = SearchBounds { from, limit, guess: active.length, floor, order: 2.0 };
        fit_line(&bench, standing, reach, first, scratch).unwrap_or_else(|| bench.unmeasured(standing, [from, turning]))
    }

    /// Commits a piece candidate. A step on the spot before it is already in the queue.
    fn accept(&mut self, active: &mut Active<'a>, trial: &SegmentCandidate<'a>) -> Option<Piece> {
        let [from, to] = trial.between;
        let is_last = to >= 1.0;
        let stated = self.stated(active);
        let bands = self.bands(trial, stated);
        let (first, first_band) = (self.standing.command, self.standing.band);
        if let Some(start) = &trial.overshoot {
            let end = active.route.end;
            let step = self.write(active, start, None, (0.0, &end), false);
            self.pending.extend(step.map(|piece| Ok(Output::Piece(Piece { take_up: false, ..piece }))));
        }
        for start in [&trial.ready, &trial.take_up].into_iter().flatten() {
            let way = self.placer.emitted(self.standing.command, start.command);
            let piece = (&active.route, from);
            self.findings.check(&active.origin, stated, piece, &way, &self.placer.setup.tool_mm);
            // Such a step takes the time that a path of this length takes.
            let share = way.size_mm() / active.route.size_mm();
            let at = active.route.at(from);
            let step = self.write(active, start, None, (share, &at), false);
            self.pending.extend(step.map(|piece| Ok(Output::Piece(piece))));
        }
        let nominal = active.route.at(to);
        let piece = (&active.route, to);
        self.findings.check(&active.origin, stated, piece, &trial.emitted, &self.placer.setup.tool_mm);
        if let Some(failure) = trial.end.failure.or(trial.take_up.and_then(|start| start.failure)) {
            self.findings.not_converged(&active.origin, failure);
        }
        let is_measured = trial.deviation_mm > 0.0 && !self.placer.model.is_empty();
        if is_measured && trial.deviation_mm > active.tolerance_mm {
            let is_cut = active.motion.motion_mode == MotionMode::Path;
            self.findings.tolerance_missed(&active.origin, is_cut, trial.deviation_mm, active.tolerance_mm);
        }
        let mut piece = self.write(active, &trial.end, Some(trial), (to - from, &nominal), is_last);
        if let Some(piece) = &mut piece {
            piece.take_up |= trial.overshoot.is_some();
        }
        let has_backlash = !self.sampler.backlash.is_empty();
        self.check_sense(active, &bands, trial);
        // A piece that is not written belongs to the next one.
        if active.is_counted && self.prediction.wants(active.motion.rapid) && piece.is_some() {
            self.predict(active, trial, &bands, (&first, &first_band));
        }
        if has_backlash {
            if is_last {
                let sensed = self.standing.sensed;
                self.lead.along(&mut self.standing.nominal_band, &active.route, sensed, [0.0, 1.0]);
            }
            self.standing.band = bands.end;
        }
        self.prediction.note_correction(&nominal, &trial.end.command);
        if active.motion.rapid {
            self.prediction.note_rapid();
        }
        if active.treatment.leaves_others() {
            let error_mm = self.placer.tip_error_mm(&nominal, &trial.end.command, &trial.state());
            self.prediction.note_as_programmed(error_mm, active.treatment == MoveTreatment::Programmed);
        } else if active.is_counted {
            let tool_mm = self.placer.setup.tool_mm;
            let (command, turning, head) = (trial.end.command, self.placer.turning(), self.placer.setup.head);
            self.poses.offer(|| PoseSample { nominal, command, state: trial.state(), tool_mm, turning, head });
        }
        let standing = &mut self.standing;
        standing.nominal = nominal;
        standing.correction = trial.end.command - nominal;
        standing.state.direction = if has_backlash { standing.band.direction() } else { trial.sense };
        standing.is_doubtful = trial.is_torn;
        active.parameter = to;
        active.length = to - from;
        piece
    }
}

/// Selects the places at which pieces are checked with the errors of a head.
fn sampler_of(model: &Model, machine: &Machine, options: &CorrectionOptions) -> Sampler {
    Sampler::new(model).with_rounding(&Increments::new(&machine.control), options.tolerance_mm)
}

impl<I> Iterator for Corrector<'_, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    type Item = Result<Output, Diagnostic>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(item) = self.pending.pop_front() {
                return Some(item);
            }
            if let Some(active) = self.active.take() {
                let piece = self.advance(active);
                if self.pending.is_empty() && self.findings.is_empty() {
                    match piece {
                        Some(piece) => return Some(Ok(Output::Piece(piece))),
                        None => continue,
                    }
                }
                self.pending.extend(piece.map(|piece| Ok(Output::Piece(piece))));
                self.pending.extend(self.findings.take().map(Err));
                continue;
            }
            let Some(item) = self.elements.take() else {
                if self.end_pace() {
                    continue;
                }
                return None;
            };
            match item {
                Ok(element) => match &element.kind {
                    Kind::Cycle(Some(cycle)) => self.take_hole(&Arc::clone(cycle), element, None),
                    Kind::Move(motion) if motion.rapid && self.elements.triggers_cycle() => {
                        if let Some(Ok(mark)) = self.elements.take()
                            && let Kind::Cycle(Some(cycle)) = &mark.kind
                        {
                            self.take_hole(&Arc::clone(cycle), mark, Some(element));
                        }
                    }
                    // The next cycle returns to where it begins.
                    Kind::Move(_) | Kind::Keep("G80") => {
                        self.initial = None;
                        self.take_in(element);
                    }
                    _ => self.take_in(element),
                },
                Err(finding) => {
                    if finding.is_error() {
                        self.findings.distrust_positions();
                    }
                    return Some(Err(finding));
                }
            }
        }
    }
}
