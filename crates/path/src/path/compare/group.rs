//! The corrected moves of one original move: their selection, and their residual error.

use ncfix_base::geometry::{AXES, Axis, AxisVector, ROTARY_AXES, Vector};
use ncfix_machine::machine::{Kinematics, TipPath};
use ncfix_model::Model;

use super::ahead::MovesAhead;
use super::divergence::Divergence;
use super::judge::{Judge, PlaceInMove, TipDeviation};
use super::step::ComparedMove;
use super::{Course, Follow, Grouping, SAME_END_MM};
use crate::path::Prediction;
use crate::path::lead::Lead;
use crate::path::route::Route;
use crate::path::sampling::{ON_THE_SPOT_MM, Offset, SampledPiece};

/// End tolerance as a share of the move length: the error of an uncorrected program changes along it.
const SAME_END_SHARE: f64 = 1e-3;
/// A further move belongs to the group only if it comes nearer by more than rounding, mm.
const NEARER_MM: f64 = 0.002;
/// Largest distance of an end that still counts as reached if the next move leads away from it, mm.
pub(super) const MEANT_END_MM: f64 = 0.5;
/// Largest distance of a rapid move to a hole of the corrected program from the place where a move of the original begins, mm: the correction changes by less
/// along a hole and above it.
pub(super) const BESIDE_HOLE_MM: f64 = 0.02;
/// A block that moves less than this repeats a position that was rounded: mm, and rad (0.001°).
const ROUNDING_MM: f64 = 1e-3;
const ROUNDING_RAD: f64 = 1.75e-5;
/// Minimum length of a complete group as a share of the original move; a full circle begins at its end.
const LEAST_SHARE: f64 = 0.5;
/// A group longer than the original move by this factor is another path.
const MOST_SHARE: f64 = 1.5;
/// Difference below which the end of a piece counts as unchanged, mm and rad.
const SAME_MM: f64 = 1e-8;
/// Minimum share of the lost motion that a step must cover to lead a body through it.
const LED_SHARE: f64 = 0.5;
/// The corrected moves of one original move, during their search.
pub(super) struct MoveGroup<'a> {
    /// The model in the zero offset of the move.
    pub(super) model: &'a Model,
    /// The model of the head with all zero offsets.
    base: &'a Model,
    grouping: Grouping,
    pub(super) kinematics: &'a Kinematics,
    pub(super) step: &'a ComparedMove<'a>,
    pub(super) lead: Lead<'a>,
    /// Offset at the start of the group: an uncorrected program carries its errors along.
    carried: Offset,
    /// Length of the corrected moves so far, mm.
    length_mm: f64,
    /// `true` after the first move of the group.
    has_begun: bool,
    /// `true` if the acts before the move were compared.
    pub(super) is_judged: bool,
    /// Parameter up to which the original move is covered.
    parameter: f64,
}

impl<'a> MoveGroup<'a> {
    pub(super) fn new(
        model: &'a Model,
        grouping: Grouping,
        (kinematics, lead): (&'a Kinematics, Lead<'a>),
        step: &'a ComparedMove<'a>,
        carried: Offset,
    ) -> MoveGroup<'a> {
        let head = step.setup.head;
        let base = model.for_head(head);
        let model = base.for_zero(step.setup.zero);
        let mut lead = if head == 0 { lead } else { lead.with(base) };
        lead.model = model;
        let kinematics = if head == 0 { kinematics } else { base.kinematics() };
        let (length_mm, has_begun, is_judged, parameter) = (0.0, false, false, 0.0);
        MoveGroup { model, base, grouping, kinematics, step, lead, carried, length_mm, has_begun, is_judged, parameter }
    }
}

/// `true` for a step on the spot that is the whole of a move without motion.
pub(super) fn course_stands(course: &Course<'_>) -> bool {
    course.piece.on_the_spot && course.step.route.size_mm() <= ON_THE_SPOT_MM
}

impl MoveGroup<'_> {
    /// Takes the moves of the group and adds their errors; returns the offset at its end.
    pub(super) fn follow<'m, I: Iterator<Item = ComparedMove<'m>>>(
        &mut self,
        corrected: &mut MovesAhead<'m, I>,
        prediction: &mut Prediction,
        see: &mut dyn FnMut(Follow<'_>),
        judge: &mut Judge<'_>,
    ) -> Result<Offset, Divergence> {
        let whole_mm = self.step.route.size_mm();
        loop {
            let Some(piece) = corrected.next() else {
                return Err(if corrected.has_begun {
                    Divergence::alone(self.step, "the corrected program ends before this move of the original")
                } else {
                    Divergence::guarded(self.step)
                });
            };
            let is_first = !self.has_begun;
            let begins = corrected.peek().is_some_and(|next| !next.continues);
            if is_first
                && begins
                && self.is_rounding(&piece)
                && let Some(mut next) = corrected.next()
            {
                next.acts.splice(..0, piece.acts);
                corrected.put_back(next);
                continue;
            }
            if is_first
                && self.leads_to_hole(&piece, corrected.peek())
                && let Some(mut next) = corrected.next()
            {
                next.acts.splice(..0, piece.acts);
                next.continues = false;
                corrected.put_back(next);
                continue;
            }
            // Both programs begin at a place that none of them states: the error there, relative to a touched zero, is no difference of the programs.
            if is_first && !self.step.is_counted {
                let standing =
                    ComparedMove { route: Route::new(piece.route.start, piece.route.start, None), ..piece.clone() };
                let start = self.offset(&standing, 0.0);
                if start.norm_mm() > self.carried.norm_mm() {
                    self.carried = start;
                }
            }
            let is_torn = self.grouping == Grouping::ByMarks && piece.continues != self.has_begun;
            self.has_begun = true;
            // Preparatory motion after a thread is rapid.
            let is_another =
                piece.rapid != self.step.rapid && !(piece.rapid && piece.continues && self.step.is_uncut());
            if is_torn || is_another || self.length_mm > MOST_SHARE * whole_mm + MEANT_END_MM {
                let why = match (is_torn, is_another, piece.rapid) {
                    (true, ..) => "is marked as one more piece of a move that has already ended",
                    (_, true, true) => "goes at rapid where this move of the original has a feed",
                    (_, true, false) => "has a feed where this move of the original goes at rapid",
                    _ => "does not follow this move of the original",
                };
                let divergence = self.divergence(&piece, why, corrected.peek());
                corrected.put_back(piece);
                return Err(divergence);
            }
            self.length_mm += self.size_mm(&piece);
            let offset = self.offset(&piece, 1.0);
            let is_complete = self.is_complete(&offset, corrected.peek());
            // Lateral backlash moves the tip across the path in such a step, so that proximity does not determine its place.
            let stands = self.grouping == Grouping::ByMarks && piece.on_the_spot;
            let before = self.parameter;
            if !stands || is_complete {
                self.parameter = if is_complete { 1.0 } else { self.nearest(&piece) };
            }
            if is_complete && self.off_mm(&offset) > self.meant_end_mm() {
                let why = "does not end at the end of this move of the original";
                let divergence = self.divergence(&piece, why, corrected.peek());
                corrected.put_back(piece);
                return Err(divergence);
            }
            let course = Course {
                step: self.step,
                piece: &piece,
                kinematics: self.kinematics,
                from: before,
                to: self.parameter,
            };
            let (errors_mm, mut seen) = self.sample(&course, (stands && !is_complete, is_complete), prediction);
            if stands && let Some(next) = corrected.peek().filter(|next| next.continues && next.on_the_spot) {
                seen.end = self.beyond_play(&piece, next, seen.end, judge.rounding_mm());
            }
            let length_mm = whole_mm * (self.parameter - before);
            let feed_share = self.feed_share(&course, stands, judge.rounding_mm());
            judge.piece(self, &course, PlaceInMove { is_first, is_last: is_complete, stands }, &seen, feed_share);
            self.is_judged = true;
            see(Follow { errors_mm, length_mm, feed_share, ..self.seen(course, is_first, stands) });
            if is_complete {
                judge.end(self.step);
                return Ok(offset);
            }
        }
    }

    /// Describes the divergence at a piece; `next` is the following piece.
    fn divergence(&self, piece: &ComparedMove<'_>, why: &str, next: Option<&ComparedMove<'_>>) -> Divergence {
        let is_new = next.is_some_and(|next| next.rapid == self.step.rapid && self.ends_at(next));
        let words = [&self.step.route.end, &piece.route.end].map(|end| piece.programmed(end, self.kinematics));
        Divergence::at(self.step, piece, why, words, is_new)
    }

    /// `true` if a piece ends at the end of the original move.
    pub(super) fn ends_at(&self, piece: &ComparedMove<'_>) -> bool {
        self.off_mm(&self.offset(piece, 1.0)) <= self.meant_end_mm()
    }

    /// Largest distance of an end that counts as reached. A move in machine coordinates stays as programmed beside axes that keep their corrected place, so it
    /// may be off by the whole error of the machine there.
    fn meant_end_mm(&self) -> f64 {
        MEANT_END_MM + if self.step.in_machine_frame { self.before_mm(1.0) } else { 0.0 }
    }

    /// A piece beside the original move.
    fn beside<'p>(&'p self, piece: &'p ComparedMove<'p>) -> SampledPiece<'p> {
        SampledPiece {
            lead: &self.lead,
            base: self.base,
            zero: self.step.setup.zero,
            head: self.step.setup.head,
            programmed: self.step.path(),
            emitted: piece.path(),
            origin: self.step.origin,
            rapid: self.step.rapid,
            off_curve_mm: self.step.off_curve_mm,
            middle_mm: None,
        }
    }

    /// The largest error of the original at a parameter, mm.
    pub(super) fn before_mm(&self, parameter: f64) -> f64 {
        self.beside(self.step).before(parameter).most_mm
    }

    /// The data of a piece that covers the original move up to the parameter.
    fn seen<'p>(&self, course: Course<'p>, is_first: bool, on_the_spot: bool) -> Follow<'p> {
        let piece = course.piece;
        let nominal = self.step.route.at(self.parameter);
        let [nominal, written] = [&nominal, &piece.route.end].map(|command| piece.programmed(command, self.kinematics));
        // The error is needed only for unchanged pieces.
        let is_left = (written - nominal).max_abs(&AXES) < SAME_MM;
        Follow {
            original: self.step.origin,
            corrected: piece.origin,
            rapid: piece.rapid,
            is_first,
            on_the_spot,
            nominal,
            written,
            error_mm: if is_left { self.before_mm(self.parameter) } else { 0.0 },
            errors_mm: None,
            length_mm: 0.0,
            is_stated: self.step.is_counted,
            feed_share: None,
            command: piece.route.end,
            tool: piece.tool.as_deref(),
            course,
        }
    }

    /// `true` if the group ends with a piece whose end is off by `offset`.
    fn is_complete(&self, offset: &Offset, next: Option<&ComparedMove<'_>>) -> bool {
        if self.grouping == Grouping::ByMarks {
            return next.is_none_or(|next| !next.continues);
        }
        let whole_mm = self.step.route.size_mm();
        if self.length_mm < LEAST_SHARE * whole_mm - SAME_END_MM {
            return false;
        }
        let off_mm = self.off_mm(offset);
        let next = next.filter(|next| next.rapid == self.step.rapid);
        let with_next = next.map_or(f64::INFINITY, |next| self.length_mm + self.size_mm(next));
        let next_is_nearer = next.is_some_and(|next| {
            with_next <= whole_mm * (1.0 + SAME_END_SHARE) + SAME_END_MM
                && self.off_mm(&self.offset(next, 1.0)) + NEARER_MM < off_mm
        });
        let leads_away = with_next > whole_mm + 2.0 * MEANT_END_MM;
        let near_mm = if leads_away { MEANT_END_MM } else { SAME_END_MM.max(SAME_END_SHARE * whole_mm) };
        !next_is_nearer && off_mm <= near_mm
    }

    /// Length of a piece in the measure of the original move: the axes move farther than a tip that the original keeps on its path.
    fn size_mm(&self, piece: &ComparedMove<'_>) -> f64 {
        if !self.step.route.is_of_tip() || piece.route.is_of_tip() {
            return piece.route.size_mm();
        }
        let (start, end) = (piece.route.start, piece.route.end);
        let tip = TipPath::new(self.kinematics, false, [&start, &end], &piece.tool_mm);
        Route::of_tip(start, end, None, tip).size_mm()
    }

    /// Offset of the tool from the place of the original move at `parameter` at the end of a piece.
    fn offset(&self, piece: &ComparedMove<'_>, parameter: f64) -> Offset {
        self.beside(piece).end_offset(parameter)
    }

    /// `true` for a rapid motion of less than the rounding of a block before a longer one of the original: the selection of a tilted plane that the block before
    /// it has reached already (G53.1).
    fn is_rounding(&self, piece: &ComparedMove<'_>) -> bool {
        let (start, end) = (&piece.route.start, &piece.route.end);
        let turned = ROTARY_AXES.into_iter().map(|axis| (end[axis] - start[axis]).abs()).fold(0.0, f64::max);
        let is_plain = piece.rapid && self.step.rapid && !piece.continues && !piece.on_the_spot && !piece.in_cycle;
        is_plain
            && turned < ROUNDING_RAD
            && piece.route.size_mm() < ROUNDING_MM
            && self.step.route.size_mm() > SAME_END_MM
    }

    /// `true` for a short rapid motion at a hole of the corrected program that ends where the move of the original begins: the control goes to a corrected place
    /// or level where the original already is.
    fn leads_to_hole(&self, piece: &ComparedMove<'_>, next: Option<&ComparedMove<'_>>) -> bool {
        let leads_on = |next: &ComparedMove<'_>| next.in_cycle || next.rapid && next.on_the_spot;
        let is_at_hole = piece.in_cycle || piece.on_the_spot && next.is_some_and(leads_on);
        if self.grouping == Grouping::ByPlace || !piece.rapid || !is_at_hole || next.is_none() {
            return false;
        }
        let [off_mm, of_end_mm] = [0.0, 1.0].map(|parameter| self.off_mm(&self.offset(piece, parameter)));
        let beyond_mm = |axis| self.lead.beyond_mm(axis, &piece.route.end, 0.0);
        // The tool may come from a rapid move that is as programmed.
        let most_mm = BESIDE_HOLE_MM + self.before_mm(0.0) + self.lead.axes.iter().map(beyond_mm).sum::<f64>();
        off_mm <= most_mm && off_mm + NEARER_MM < of_end_mm
    }

    /// Deviation of a hole that stays a cycle in any case, with the best shift of all its moves, mm: half the change of the error of the original along it, and
    /// the backlash of the drilling axis.
    pub(super) fn of_whole_mm(&self, piece: &ComparedMove<'_>) -> f64 {
        let (Some(hole), Some(own)) = (piece.whole, self.step.whole) else { return 0.0 };
        let state = piece.band.state();
        let error = |place: &AxisVector| self.model.tip_error_mm(place, place, &piece.tool_mm, &state);
        let [start, end] = [&self.step.route.start, &self.step.route.end].map(error);
        let change_mm = (error(&own.top) - start).norm().max((error(&own.top) - end).norm());
        // A hole in a turned plane reverses several axes.
        let of_drilling = |of_axis: &dyn Fn(Axis) -> f64| match piece.setup.frame.is_translation() {
            true => of_axis(hole.along),
            false => self.lead.axes.iter().map(|axis| of_axis(axis).powi(2)).sum::<f64>().sqrt(),
        };
        if !hole.is_back {
            return 0.5 * change_mm + of_drilling(&|axis| self.model.lost_motion(axis, &piece.route.end));
        }
        // The words are for the way in. On the way out the drilling axis is on its other side, which displaces the tip along the hole and across it.
        let lost_mm = of_drilling(&|axis| self.reversal_of_mm(piece, axis));
        let ends = [&self.step.route.end, &piece.route.end].map(|place| place[hole.along]);
        let leaves_hole = (self.step.route.end - own.top).max_abs(&AXES) > SAME_MM;
        // The way out may lead to the initial level, which may be as programmed.
        let is_as_programmed = (ends[0] - ends[1]).abs() < SAME_MM;
        let level_mm = if leaves_hole || is_as_programmed { end[hole.along.slot()].abs() } else { 0.0 };
        level_mm + lost_mm + if leaves_hole { change_mm } else { 0.5 * change_mm }
    }

    /// Displacement of the tip when the axes that a move of a hole moves, and the drilling axis, change sides, mm: with their lateral backlash.
    pub(super) fn reversal_mm(&self, piece: &ComparedMove<'_>) -> f64 {
        let (start, end) = (&piece.route.start, &piece.route.end);
        // In a turned frame the drilling axis is several axes of the machine.
        let is_turned = !piece.setup.frame.is_translation();
        let is_of_hole = |axis: Axis| axis == piece.setup.plane.axes()[2] || is_turned && !axis.is_rotary();
        let moves = |axis: &Axis| is_of_hole(*axis) || (end[*axis] - start[*axis]).abs() > SAME_MM;
        self.lead.axes.iter().filter(moves).map(|axis| self.reversal_of_mm(piece, axis)).sum()
    }

    /// Displacement of the tip at the end of a piece when an axis changes its side, mm: along it and across it.
    fn reversal_of_mm(&self, piece: &ComparedMove<'_>, axis: Axis) -> f64 {
        let end = &piece.route.end;
        let tip = |side: i8| {
            let mut state = piece.band.state();
            state.direction[axis.slot()] = side;
            self.model.tip_error_mm(end, end, &piece.tool_mm, &state)
        };
        (tip(1) - tip(-1)).norm()
    }

    /// An offset as a distance, mm: the smaller of its own length and its difference from the initial offset.
    fn off_mm(&self, offset: &Offset) -> f64 {
        offset.norm_mm().min(offset.minus(&self.carried).norm_mm())
    }

    /// The parameter of the original move at which its nominal tip is nearest to the end of a piece.
    fn nearest(&self, piece: &ComparedMove<'_>) -> f64 {
        let share = (self.length_mm / self.step.route.size_mm().max(ON_THE_SPOT_MM)).min(1.0);
        self.beside(piece).nearest(share, self.parameter)
    }

    /// The offset at the end of a step on the spot or of a rapid move, reduced by the permitted backlash. A quick body may be on either side, for the
    /// side to which the next piece leads it. A body that a rapid move leaves within its dead band waits for a step that leads it out.
    fn on_either_side(&self, piece: &ComparedMove<'_>, nominal: &AxisVector, seen: &mut TipDeviation) {
        let command = piece.route.end;
        let band = piece.path().band_at(1.0, &self.lead);
        let mut bands = vec![band];
        for axis in self.lead.axes.iter() {
            let lost = self.model.lost_motion(axis, &command);
            let sides: &[i8] = match band.direction()[axis.slot()] {
                // Nobody knows its side: the correction aims at the middle. A step on the spot that leads the body to a side leaves it within its dead band
                // too, until it has moved by the whole of it.
                0 => &[1, 0, -1],
                _ if self.lead.is_quick(axis, &command) => &[1, -1],
                _ if band.is_on(std::iter::once(axis).collect(), &band.direction()) => continue,
                // The rounding of two commands may leave the body short of its side.
                1 => &[1],
                _ => &[-1],
            };
            let before = std::mem::take(&mut bands);
            for band in before {
                bands.extend(sides.iter().map(|&side| {
                    let mut other = band;
                    other.put(axis, side, lost);
                    other
                }));
            }
        }
        for band in bands {
            let other = self.lead.error_mm(&band, (nominal, &command), &piece.tool_mm, None);
            if other.nearest.norm() < seen.end.norm() {
                seen.end = other.nearest;
            }
            seen.other_ends.push(other.middle);
        }
    }

    /// The part of the offset after a preparatory step that exceeds the permitted backlash and the rounding of the way through it. `next` leads bodies to the
    /// other side on the spot; until then the tip is displaced by their lateral backlash.
    fn beyond_play(
        &self,
        piece: &ComparedMove<'_>,
        next: &ComparedMove<'_>,
        offset: Vector,
        rounding_mm: f64,
    ) -> Vector {
        let (from, to) = (piece.route.end, next.route.end);
        let aside = self.lead.axes.iter().map(|axis| {
            let (lost, way) = (self.model.lost_motion(axis, &to), to[axis] - from[axis]);
            if lost == 0.0 || way.abs() < LED_SHARE * lost {
                return 0.0;
            }
            let mut led = from;
            led[axis] += lost.copysign(way);
            let tip = |command: &AxisVector, side: i8| {
                let mut state = piece.band.state();
                state.direction[axis.slot()] = side;
                self.model.tip_error_mm(&from, command, &piece.tool_mm, &state)
            };
            let side = if way > 0.0 { 1 } else { -1 };
            (tip(&led, side) - tip(&from, -side)).norm()
        });
        let (off_mm, aside_mm) = (offset.norm(), aside.sum::<f64>());
        let aside_mm = if aside_mm > 0.0 { aside_mm + rounding_mm } else { 0.0 };
        if off_mm > aside_mm { offset * (1.0 - aside_mm / off_mm) } else { Vector::zeros() }
    }

    /// Adds the errors of a piece: the largest of the original and of the corrected program, if they count, and the deviation of the latter. Its end
    /// is always examined. A piece that `waits` covers nothing of the move.
    fn sample(
        &self,
        course: &Course<'_>,
        (waits, is_complete): (bool, bool),
        prediction: &mut Prediction,
    ) -> (Option<[f64; 2]>, TipDeviation) {
        let (piece, between) = (course.piece, [course.from, course.to]);
        let beside = self.beside(piece);
        let end = beside.end_offset(course.to).tip;
        let mut seen = TipDeviation { end, most_mm: end.norm(), other_ends: Vec::new() };
        let is_still = course_stands(course);
        let is_tapped = piece.whole.is_some() && self.step.is_uncut();
        if (waits || self.step.rapid || is_still || is_tapped) && !self.lead.axes.is_empty() {
            self.on_either_side(piece, &self.step.route.at(course.to), &mut seen);
        }
        if self.step.rapid {
            prediction.note_rapid();
        }
        if waits || !self.step.is_counted || !prediction.wants(self.step.rapid) {
            return (None, seen);
        }
        let found = beside.sample(between, prediction, &mut Vec::new());
        if is_complete {
            prediction.end_move(self.step.rapid, self.step.route.size_mm());
        }
        let Some(found) = found else { return (None, seen) };
        // If the side of an axis is unknown, the place for either side satisfies the promise.
        seen.most_mm = found.nearest_mm;
        let before_mm = found.before_mm.unwrap_or_else(|| beside.before(0.5 * (course.from + course.to)).most_mm);
        (Some([before_mm, found.after_mm]), seen)
    }
}
