//! Detects differences of a corrected program that are not corrections: other acts, other feeds, and tool deviations beyond the promise.

use ncfix_base::geometry::{AXES, AxisVector, ROTARY_AXES, Vector};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Origin, Turning};

use super::acts::{Act, ActPairing, differences};
use super::course::Course;
use super::detour::Detour;
use super::difference::{ActSubject, ProgramDifference, What};
use super::group::{BESIDE_HOLE_MM, MoveGroup, course_stands};
use super::motion_mode;
use super::promise::Promise;
use super::step::ComparedMove;
use crate::path::Increments;

/// Allowance for the path between samples, as a share.
const BETWEEN_SAMPLES: f64 = 0.05;
/// Relative difference below which feeds are equal: feeds are written with few digits.
const SAME_FEED: f64 = 1e-4;
/// Difference below which a word counts as unchanged, mm and rad.
const SAME_WORD: f64 = 1e-7;
/// Change of a word that determines its effect on the tip, mm and rad.
const NUDGE: f64 = 1e-4;
/// Directions nearer to each other than this are equal, rad: the place on a move is known to a thousandth of a millimeter.
const SAME_TILT_RAD: f64 = 2e-5;
/// Tip motion below which a direction is undefined.
const NO_WAY: f64 = 1e-9;

/// Deviation of the tool from its place on a piece.
#[derive(Clone, Debug, Default)]
pub(super) struct TipDeviation {
    /// At the end.
    pub(super) end: Vector,
    /// At the end for other sides of bodies that no motion has led to a known side.
    pub(super) other_ends: Vec<Vector>,
    /// The largest at all examined places including the end, mm.
    pub(super) most_mm: f64,
}

/// Position of a piece in its move.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlaceInMove {
    pub(super) is_first: bool,
    pub(super) is_last: bool,
    /// `true` for a step on the spot.
    pub(super) stands: bool,
}

/// Examines the pieces of one move after the other.
pub(super) struct Judge<'d> {
    promise: Option<Promise>,
    /// Permitted deviation of the tool, mm.
    limit_mm: f64,
    increments: Increments,
    differ: &'d mut dyn FnMut(ProgramDifference),
    /// The largest deviation of the move so far: value, limit, and piece.
    off: Option<(f64, f64, Origin)>,
    /// The largest tilt of the move so far: value, limit, and piece.
    tilt: Option<(f64, f64, Origin)>,
    /// True if the machine has rotary axes, which may tilt the tool.
    turns: bool,
    /// Permitted deviation of a hole that is a drilling cycle in the output, mm.
    hole_limit_mm: f64,
    /// Permitted deviation on an arc, whose center is rounded too, mm.
    arc_limit_mm: f64,
    /// The feed with the largest ratio.
    feed: Option<(f64, What, Origin)>,
    /// Reported stops at block ends in both, if they differ.
    passing: Option<[Option<String>; 2]>,
    /// Reported planes and transformations of both, if they differ.
    setups: Option<[String; 2]>,
    last: [Origin; 2],
    detour: Detour,
    /// `true` if the end of the move lies within a continuing curve.
    runs_on: bool,
}

impl<'d> Judge<'d> {
    pub(super) fn new(
        promise: Option<Promise>,
        machine: &Machine,
        differ: &'d mut dyn FnMut(ProgramDifference),
    ) -> Judge<'d> {
        let mut increments = Increments::new(&machine.control);
        if let Some(increment_mm) = promise.and_then(|promise| promise.increment_mm) {
            increments.linear_mm = increment_mm;
        }
        let tolerance_mm = promise.map_or(0.0, |promise| promise.tolerance_mm);
        let limit = |tolerance_mm: f64| {
            increments.allowed_mm(tolerance_mm) + BETWEEN_SAMPLES * tolerance_mm.max(increments.rounding_mm())
        };
        let limit_mm = limit(tolerance_mm);
        let hole_limit_mm = limit(promise.map_or(0.0, |promise| promise.hole_tolerance_mm));
        // The center of a fitted arc is rounded by half an increment in each of two directions.
        let center_mm = 0.5 * 2.0_f64.sqrt() * increments.linear_mm;
        let arc_limit_mm = limit_mm + center_mm;
        let last = [Origin::default(); 2];
        let turns = ROTARY_AXES.into_iter().any(|axis| machine.axis_set().contains(axis));
        Judge {
            promise,
            limit_mm,
            hole_limit_mm,
            arc_limit_mm,
            increments,
            differ,
            off: None,
            tilt: None,
            turns,
            feed: None,
            passing: None,
            setups: None,
            last,
            detour: Detour::default(),
            runs_on: false,
        }
    }

    /// Tip displacement due to rounding, mm.
    pub(super) fn rounding_mm(&self) -> f64 {
        self.increments.rounding_mm()
    }

    /// Begins another move of the original; `runs_on` if there can be no stop at its end.
    pub(super) fn begin(&mut self, runs_on: bool) {
        self.runs_on = runs_on;
    }

    /// Handles a move of the original that has no end in the corrected program.
    pub(super) fn part(&mut self, step: &ComparedMove<'_>) {
        (self.off, self.tilt, self.feed) = (None, None, None);
        if let Some((what, corrected)) = self.detour.broken() {
            (self.differ)(ProgramDifference { original: step.origin, corrected, what });
        }
    }

    /// Examines a piece of a move.
    pub(super) fn piece(
        &mut self,
        group: &MoveGroup<'_>,
        course: &Course<'_>,
        at: PlaceInMove,
        seen: &TipDeviation,
        feed_share: Option<f64>,
    ) {
        let (step, piece) = (group.step, course.piece);
        self.last = [step.origin, piece.origin];
        self.acts(if at.is_first { &step.acts } else { &[] }, &piece.acts);
        if at.is_first {
            self.motion_mode(step, piece);
        }
        self.passing(step, piece, at.is_last && !self.runs_on);
        self.setups(step, piece);
        self.feed(step, piece, feed_share);
        if self.promise.is_some() && step.is_counted && !step.rapid && !at.stands {
            self.tilt(group, course);
        }
        if self.promise.is_some() {
            self.detour(group, course, at, seen);
        }
        if self.promise.is_some() && step.is_counted {
            let off_mm = self.off_mm(group, course, at, seen);
            let limit_mm = self.limit_of(group, piece);
            if off_mm > limit_mm && self.off.is_none_or(|(most_mm, ..)| off_mm > most_mm) {
                self.off = Some((off_mm, limit_mm, piece.origin));
            }
        }
    }

    /// Ends the move.
    pub(super) fn end(&mut self, step: &ComparedMove<'_>) {
        let original = step.origin;
        if let Some((_, what, corrected)) = self.feed.take() {
            (self.differ)(ProgramDifference { original, corrected, what });
        }
        if let Some((tilt_rad, limit_rad, corrected)) = self.tilt.take() {
            (self.differ)(ProgramDifference { original, corrected, what: What::Tilted { tilt_rad, limit_rad } });
        }
        if let Some((off_mm, limit_mm, corrected)) = self.off.take() {
            let what = What::Off { off_mm, limit_mm };
            (self.differ)(ProgramDifference { original, corrected, what });
        }
    }

    /// Examines pieces of a move that is evaluated at its end only.
    fn detour(&mut self, group: &MoveGroup<'_>, course: &Course<'_>, at: PlaceInMove, seen: &TipDeviation) {
        let (step, piece) = (group.step, course.piece);
        if at.is_last {
            // The last digit of both ends is rounded.
            let linear_mm = self.increments.linear_mm;
            let beyond_mm = |axis, end: &AxisVector| group.lead.beyond_mm(axis, end, linear_mm) + linear_mm;
            if let Some((what, corrected)) = self.detour.end(course, beyond_mm) {
                (self.differ)(ProgramDifference { original: step.origin, corrected, what });
            }
        } else if step.rapid || step.is_uncut() || piece.rapid || !step.is_counted {
            self.detour.see(group, course, seen);
        }
    }

    /// Compares the lead of a thread, or the type of a probing motion.
    fn motion_mode(&mut self, step: &ComparedMove<'_>, piece: &ComparedMove<'_>) {
        if let Some([before, after]) = motion_mode::difference(&step.motion_mode, &piece.motion_mode) {
            let what = What::Act { subject: ActSubject::Thread, before: Some(before), after: Some(after) };
            (self.differ)(ProgramDifference { original: step.origin, corrected: piece.origin, what });
        }
    }

    /// Compares the direction of the tool at the end of a piece: a correction improves it or leaves it unchanged.
    fn tilt(&mut self, group: &MoveGroup<'_>, course: &Course<'_>) {
        if !self.turns {
            return;
        }
        let tool_axis = group.model.kinematics().tool_axis();
        let (step, piece) = (group.step, course.piece);
        let (nominal, tool_mm) = (step.route.at(course.to), &piece.tool_mm);
        let ideal = group.model.nominal(&nominal, tool_mm);
        let tilt = |command: &AxisVector| {
            let turn = ideal.turn_to(&group.model.actual(command, tool_mm, &piece.band.state()));
            (turn - tool_axis * turn.dot(tool_axis)).norm()
        };
        let tilt_rad = tilt(&piece.route.end);
        let limit_rad = tilt(&nominal) + 2.0 * self.increments.rotary_deg.to_radians() + SAME_TILT_RAD;
        if tilt_rad > limit_rad && self.tilt.is_none_or(|(most, ..)| tilt_rad > most) {
            self.tilt = Some((tilt_rad, limit_rad, piece.origin));
        }
    }

    /// Compares the acts after the last moves, or after a divergence.
    pub(super) fn rest(&mut self, original: &[Act], corrected: &[Act]) {
        self.acts(original, corrected);
    }

    /// Reports the known differences of moves that do not correspond, where the comparison ends: missing or new acts may only be at another place.
    pub(super) fn lose(&mut self, step: &ComparedMove<'_>, piece: &ComparedMove<'_>) {
        self.setups(step, piece);
        let pairs = differences(&step.acts, &piece.acts);
        self.differ(pairs.into_iter().filter(|(before, after)| before.is_some() && after.is_some()));
    }

    fn acts(&mut self, original: &[Act], corrected: &[Act]) {
        self.differ(differences(original, corrected));
    }

    fn differ<'a>(&mut self, pairs: impl IntoIterator<Item = ActPairing<'a>>) {
        for (before, after) in pairs {
            let Some(subject) = before.or(after).map(|act| act.subject) else { continue };
            let [own, other] = [before, after].map(|act| act.map(|act| act.origin));
            let what = What::Act {
                subject,
                before: before.map(|act| act.text.clone()),
                after: after.map(|act| act.text.clone()),
            };
            let [original, corrected] = [own.unwrap_or(self.last[0]), other.unwrap_or(self.last[1])];
            (self.differ)(ProgramDifference { original, corrected, what });
        }
    }

    /// Compares the stop at the end of a block. A modal difference is reported once.
    fn passing(&mut self, step: &ComparedMove<'_>, piece: &ComparedMove<'_>, is_last: bool) {
        // A cycle that stops exactly makes the way to its hole; a step before the call does not belong to it.
        let leads_to_hole = step.rapid && step.in_cycle && piece.rapid && piece.on_the_spot;
        if leads_to_hole || step.passing.is_kept_by(&piece.passing, is_last) {
            if is_last {
                self.passing = None;
            }
            return;
        }
        let both = [step, piece].map(|one| one.passing.text());
        if self.passing.as_ref() == Some(&both) {
            return;
        }
        self.passing = Some(both.clone());
        let [before, after] = both;
        let what = What::Act { subject: ActSubject::Passing, before, after };
        let origin = |one: &ComparedMove<'_>| one.passing.mode.as_ref().map_or(one.origin, |mode| mode.origin);
        let corrected = if is_last { origin(piece) } else { piece.origin };
        (self.differ)(ProgramDifference { original: origin(step), corrected, what });
    }

    /// Compares the working plane and the transformation. A modal difference is reported once.
    fn setups(&mut self, step: &ComparedMove<'_>, piece: &ComparedMove<'_>) {
        let in_axes = self.promise.is_some_and(|promise| promise.in_axes) && piece.setup.transform.is_none();
        let is_transformed = |one: &ComparedMove<'_>| one.setup.transform.is_some() && !in_axes;
        let is_same = !is_transformed(step)
            || in_axes
            || step.transformation == piece.transformation && step.setup.transform == piece.setup.transform;
        if step.setup.plane == piece.setup.plane && is_transformed(step) == is_transformed(piece) && is_same {
            self.setups = None;
            return;
        }
        let shown = |one: &ComparedMove<'_>| {
            let plane = one.setup.plane.number();
            let way = match one.setup.transform {
                Some(Turning::Axes) => "rotary axes in proportion",
                _ => "the tool on a great circle",
            };
            match (is_transformed(one), one.transformation) {
                (false, _) => format!("G{plane} without a transformation"),
                (true, "") => format!("G{plane} with a transformation, {way}"),
                (true, word) => format!("G{plane} with {word}, {way}"),
            }
        };
        let both = [shown(step), shown(piece)];
        if self.setups.as_ref() == Some(&both) {
            return;
        }
        self.setups = Some(both.clone());
        let [before, after] = both.map(Some);
        let what = What::Act { subject: ActSubject::Plane, before, after };
        (self.differ)(ProgramDifference { original: step.origin, corrected: piece.origin, what });
    }

    fn feed(&mut self, step: &ComparedMove<'_>, piece: &ComparedMove<'_>, share: Option<f64>) {
        // A feed per minute and a feed per turn have no ratio.
        let share = if step.is_of_another_unit(piece) { Some(f64::NAN) } else { share };
        let Some(share) = share else { return };
        let is_limited = self.promise.is_some_and(|promise| promise.limits_feed) && share < 1.0;
        if (share - 1.0).abs() <= SAME_FEED || is_limited {
            return;
        }
        let ratio = if share.is_nan() { f64::INFINITY } else { share.max(1.0 / share) };
        if self.feed.as_ref().is_none_or(|(most, ..)| ratio > *most) {
            let [before, after] = [step, piece].map(|one| (one.feed, one.unit));
            self.feed = Some((ratio, What::Feed { before, after, share }, piece.origin));
        }
    }

    fn limit_of(&self, group: &MoveGroup<'_>, piece: &ComparedMove<'_>) -> f64 {
        match piece.route.arc() {
            Some(_) => self.arc_limit_mm,
            None if piece.in_cycle => self.hole_limit_mm + group.of_whole_mm(piece),
            None => self.limit_mm,
        }
    }

    /// Deviation of the tool from the promised place, mm.
    fn off_mm(&self, group: &MoveGroup<'_>, course: &Course<'_>, at: PlaceInMove, seen: &TipDeviation) -> f64 {
        let (step, piece) = (group.step, course.piece);
        if at.stands && !at.is_last {
            return seen.end.norm();
        }
        if step.rapid && !at.is_last {
            return 0.0;
        }
        let is_straight = step.route.arc().is_none() && piece.route.arc().is_none();
        let is_stepped = self.promise.is_some_and(|promise| promise.is_stepped) && is_straight;
        let ends_only = step.rapid || step.is_uncut() || is_stepped || course_stands(course);
        let off_mm = if ends_only { seen.end.norm() } else { seen.most_mm };
        // A tap does not move across its hole, but its place there counts.
        let may_be_left = step.rapid || step.in_machine_frame || step.is_uncut() && piece.whole.is_none();
        let off_mm = if off_mm > self.limit_of(group, piece) && may_be_left {
            self.beyond_left_mm(group, course, seen)
        } else {
            off_mm
        };
        // The rapid moves of a cycle keep the place of its hole at other heights, also above it at a level that is as programmed.
        let is_of_hole = piece.in_cycle || piece.on_the_spot && step.in_cycle;
        // Its axes are there on the other sides of their dead bands, and no word of the call can correct more than the hole itself.
        let is_beside = || off_mm <= BESIDE_HOLE_MM + group.before_mm(course.to) + group.reversal_mm(piece);
        if step.rapid && is_of_hole && is_beside() { 0.0 } else { off_mm }
    }

    /// The deviation beyond the effect of unchanged words: rapid moves may be corrected in some words only.
    fn beyond_left_mm(&self, group: &MoveGroup<'_>, course: &Course<'_>, seen: &TipDeviation) -> f64 {
        let (step, piece, kinematics) = (group.step, course.piece, group.kinematics);
        let place = step.route.at(course.to);
        let [nominal, before, written] =
            [&place, &piece.route.start, &piece.route.end].map(|command| piece.programmed(command, kinematics));
        let tip = |words: &AxisVector| {
            let command = piece.commanded(words, kinematics)?;
            Some(group.model.tip_error_mm(&place, &command, &piece.tool_mm, &piece.band.state()))
        };
        let Some(here) = tip(&written) else { return seen.end.norm() };
        let mut ways: Vec<Vector> = Vec::new();
        for axis in AXES {
            let increment =
                if axis.is_rotary() { self.increments.rotary_deg.to_radians() } else { self.increments.linear_mm };
            let is_nominal = (written[axis] - nominal[axis]).abs() <= 0.5 * increment + SAME_WORD;
            let stands = (written[axis] - before[axis]).abs() <= SAME_WORD;
            // If words turn with a rotary axis at its programmed angle, the linear axes compensate its whole error.
            let in_machine = step.in_machine_frame || piece.in_machine_frame;
            let turns = self.promise.is_some_and(|promise| promise.corrects_rotary);
            let is_idle = axis.is_rotary() && is_nominal && !in_machine && !turns && step.setup.transform.is_none();
            if is_idle || !is_nominal && !stands {
                continue;
            }
            let mut nudged = written;
            nudged[axis] += NUDGE;
            let Some(there) = tip(&nudged) else { continue };
            let mut way = (there - here) / NUDGE;
            for known in &ways {
                way -= known * known.dot(&way);
            }
            if way.norm() > NO_WAY {
                ways.push(way.normalize());
            }
        }
        // The sides for which the tool is nearest are not those for which the words that count are right: a word that is left may have the largest error.
        let beyond = |end: &Vector| ways.iter().fold(*end, |rest, way| rest - way * way.dot(&rest)).norm();
        std::iter::once(&seen.end).chain(&seen.other_ends).map(beyond).fold(f64::INFINITY, f64::min)
    }
}
