//! The errors of an original and a corrected program, both on the error model, both against the nominal path of the original.
//!
//! The streams are walked side by side: every move of the original corresponds to one move of the corrected program or to several in
//! a row. What matters is where the tool is: a group of moves is complete when its tip, on the error model, reaches the nominal tip
//! at the end of the original move, and in between belongs to the place of the original move whose nominal tip is nearest. Marks in
//! the text are not needed, so programs of other origin, or an original beside itself, can be compared too; where a program is known
//! to carry them ([`Grouping::ByMarks`]), they decide instead.

mod course;
mod feed;
mod step;

use std::iter::Peekable;

use crate::diagnostic::Diagnostic;
use crate::geometry::{AXES, AxisVector, ROTARY_AXES, Vector};
use crate::machine::{Kinematics, Machine};
use crate::model::Model;
use crate::snc::{Element, Origin, WordValue};

pub use course::Course;
use step::{SENSE_STEP, Step, Walk};

use super::prediction::{Pair, sample_count, sample_place};
use super::{Feeds, Prediction, Spread};

/// Distance of the samples along the path, mm.
const SAMPLE_MM: f64 = 1.0;
/// Ends nearer than this are the same, mm.
const SAME_END_MM: f64 = 0.02;
/// The same as a share of the length of the move: the error of an uncorrected program changes along it.
const SAME_END_SHARE: f64 = 1e-3;
/// A further move belongs to the group only if it comes nearer by more than rounding does, mm.
const NEARER_MM: f64 = 0.002;
/// An end that is off by this may still be meant, where the next move leads away from it, mm.
const MEANT_END_MM: f64 = 0.5;
/// A group at least this long, as a share of the original move, may be complete; a full circle begins at its end.
const LEAST_SHARE: f64 = 0.5;
/// A group this much longer than the original move is another path.
const MOST_SHARE: f64 = 1.5;
/// mm per rad that rotary axes are off: little, as their corrections are no sign of another place, but moves of the table about the
/// tip have nothing else.
const ROTARY_ARM_MM: f64 = 10.0;
/// Where the tip moves at least by this share of what the rotary axes do, it alone tells the place.
const TIP_DECIDES: f64 = 0.1;
/// A piece whose end differs by less than arithmetic does is left as it was, mm and rad.
const SAME_MM: f64 = 1e-8;
/// Steps of the search for the nearest place on the original move.
const NEAREST_STEPS: usize = 4;
/// Pieces shorter than this, half of the shortest that is made, stand on the spot and have no place along the move, mm.
const ON_THE_SPOT_MM: f64 = 0.005;

/// Errors of two programs. Moves with feed count, or all where there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Comparison {
    /// The original.
    pub before: Spread,
    /// The corrected program.
    pub after: Spread,
    /// Places at which both were evaluated.
    pub samples: u64,
    /// Where in the original the largest error of the corrected program lies.
    pub max_at: Option<Origin>,
}

/// A piece of the corrected program beside the place of the original that it belongs to.
#[derive(Clone, Copy, Debug)]
pub struct Follow<'a> {
    /// The move of the original.
    pub original: Origin,
    /// The piece.
    pub corrected: Origin,
    /// Rapid or with feed.
    pub rapid: bool,
    /// The first piece of its move.
    pub is_first: bool,
    /// A step on the spot: its place is that where the move stands.
    pub on_the_spot: bool,
    /// Where the original is at the end of the piece, in the coordinates in which the corrected program writes, mm and rad.
    pub nominal: AxisVector,
    /// Where the piece ends, in the same.
    pub written: AxisVector,
    /// How far the tip of the original is from its nominal place there, on the error model, mm; 0 where the piece is changed.
    pub error_mm: f64,
    /// The largest errors of the original and of the corrected program on the piece, mm; `None` where it does not count.
    pub errors_mm: Option<[f64; 2]>,
    /// Length of the path of the original that the piece covers, mm and what its rotary axes make of it.
    pub length_mm: f64,
    /// Whether the program has stated where all axes are that it moves.
    pub is_stated: bool,
    /// The feed of the piece as a share of that of its move; by the times that both take where rotary axes turn or one of them says its time.
    /// `None` where there is no feed, or it is not comparable.
    pub feed_share: Option<f64>,
    /// The axis command of the piece, mm and rad.
    pub command: AxisVector,
    /// The tool word that stands above the piece.
    pub tool: Option<&'a WordValue>,
    /// What the original does meanwhile.
    pub course: Course<'a>,
}

/// The comment, without the signs that make it one, of a piece that continues the move of the block above it.
pub const CONTINUES: &str = "+";
/// The same of a step on the spot that continues the move of the block above it.
pub const CONTINUES_ON_THE_SPOT: &str = "+~";
/// The same of a step on the spot with which a move begins.
pub const ON_THE_SPOT: &str = "~";

/// How the corrected moves of one original move are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grouping {
    /// By the comments [`CONTINUES`] and [`CONTINUES_ON_THE_SPOT`], which the corrected program is known to carry.
    ByMarks,
    /// By where the tool is.
    ByPlace,
}

/// How two programs are compared.
#[derive(Clone, Copy, Debug)]
pub struct How {
    /// How the moves are found.
    pub grouping: Grouping,
    /// For which way the controls of both take a feed.
    pub feeds: [Feeds; 2],
}

/// Compares two programs; neither may have had errors in its execution.
///
/// # Errors
/// `E0311` where the moves of the one do not follow those of the other.
pub fn compare(
    original: impl Iterator<Item = Element>,
    corrected: impl Iterator<Item = Element>,
    grouping: Grouping,
    machine: &Machine,
    model: &Model,
) -> Result<Comparison, Diagnostic> {
    let how = How { grouping, feeds: [Feeds::default(); 2] };
    compare_seeing(original, corrected, how, machine, model, &mut |_| {})
}

/// The same; every piece of the corrected program is shown on the way.
///
/// # Errors
/// `E0311` where the moves of the one do not follow those of the other.
pub fn compare_seeing(
    original: impl Iterator<Item = Element>,
    corrected: impl Iterator<Item = Element>,
    How { grouping, feeds }: How,
    machine: &Machine,
    model: &Model,
    see: &mut dyn FnMut(Follow<'_>),
) -> Result<Comparison, Diagnostic> {
    let has_backlash = AXES.into_iter().any(|axis| model.features(axis).backlash);
    let mut corrected = Walk::new(corrected, machine, feeds[1], has_backlash).peekable();
    let kinematics = Kinematics::new(machine);
    let mut prediction = Prediction::default();
    let mut carried = Offset::default();
    for step in Walk::new(original, machine, feeds[0], has_backlash) {
        let mut group = Group {
            model,
            grouping,
            kinematics: &kinematics,
            step: &step,
            has_backlash,
            carried,
            length_mm: 0.0,
            has_begun: false,
            parameter: 0.0,
        };
        carried = group.follow(&mut corrected, &mut prediction, see)?;
    }
    match corrected.find(|step| step.route.size_mm() > SAME_END_MM) {
        Some(rest) => Err(rest.mismatch("the corrected program goes on behind the end of the original")),
        None => Ok(prediction.counted().into()),
    }
}

impl From<&Pair> for Comparison {
    fn from(pair: &Pair) -> Comparison {
        Comparison { before: pair.before, after: pair.after, samples: pair.after.samples, max_at: pair.max_at }
    }
}

/// How far the tool is from where it should be.
#[derive(Clone, Copy, Debug, Default)]
struct Offset {
    /// Tip, in the workpiece frame, mm.
    tip: Vector,
    /// Rotary axes, at [`ROTARY_ARM_MM`].
    turned: Vector,
}

impl Offset {
    fn minus(&self, other: &Offset) -> Offset {
        Offset { tip: self.tip - other.tip, turned: self.turned - other.turned }
    }

    fn dot(&self, other: &Offset) -> f64 {
        self.tip.dot(&other.tip) + self.turned.dot(&other.turned)
    }

    fn norm_mm(&self) -> f64 {
        self.dot(self).sqrt()
    }
}

/// The corrected moves of one original move, while they are found.
struct Group<'a> {
    model: &'a Model,
    grouping: Grouping,
    kinematics: &'a Kinematics,
    step: &'a Step,
    has_backlash: bool,
    /// Offset at which the group began: an uncorrected program carries its errors along.
    carried: Offset,
    /// Length of the corrected moves so far, mm.
    length_mm: f64,
    /// Whether a move of the group was taken.
    has_begun: bool,
    /// How far the original move is covered.
    parameter: f64,
}

impl Group<'_> {
    /// Takes the moves of the group and adds their errors; gives the offset at its end.
    fn follow<I: Iterator<Item = Element>>(
        &mut self,
        corrected: &mut Peekable<Walk<'_, I>>,
        prediction: &mut Prediction,
        see: &mut dyn FnMut(Follow<'_>),
    ) -> Result<Offset, Diagnostic> {
        let whole_mm = self.step.route.size_mm();
        loop {
            let Some(piece) = corrected.next() else {
                return Err(self.step.mismatch("the corrected program ends before this move of the original"));
            };
            let is_first = !self.has_begun;
            let is_torn = self.grouping == Grouping::ByMarks && piece.continues != self.has_begun;
            self.has_begun = true;
            if is_torn || piece.rapid != self.step.rapid || self.length_mm > MOST_SHARE * whole_mm + MEANT_END_MM {
                return Err(self.step.mismatch("the corrected program does not follow this move of the original"));
            }
            if self.step.is_of_another_unit(&piece) {
                return Err(self
                    .step
                    .mismatch("the feed of this move is per minute in the one program and per turn in the other"));
            }
            self.length_mm += piece.route.size_mm();
            let offset = self.offset(&piece, 1.0);
            let is_complete = self.is_complete(&offset, corrected.peek());
            // Lateral play leads across the path on such a step, so that nearness does not tell its place.
            let stands = self.grouping == Grouping::ByMarks && piece.on_the_spot;
            let mut errors_mm = None;
            let before = self.parameter;
            if !stands || is_complete {
                let to = if is_complete { 1.0 } else { self.nearest(&piece) };
                errors_mm = self.sample(&piece, to, prediction);
                self.parameter = to;
            }
            let length_mm = whole_mm * (self.parameter - before);
            let course = Course {
                step: self.step,
                piece: &piece,
                kinematics: self.kinematics,
                from: before,
                to: self.parameter,
            };
            let feed_share = self.feed_share(&course, stands);
            see(Follow { errors_mm, length_mm, feed_share, ..self.seen(course, is_first, stands) });
            if is_complete && self.off_mm(&offset) > MEANT_END_MM {
                return Err(self
                    .step
                    .mismatch("the corrected program does not end this move of the original where it ends"));
            }
            if is_complete {
                return Ok(offset);
            }
        }
    }

    /// A piece that has covered the original move up to the parameter.
    fn seen<'p>(&self, course: Course<'p>, is_first: bool, on_the_spot: bool) -> Follow<'p> {
        let piece = course.piece;
        let nominal = self.step.route.at(self.parameter);
        let [nominal, written] = [&nominal, &piece.route.end].map(|command| piece.programmed(command, self.kinematics));
        let error_mm = |nominal: &AxisVector| {
            let state = if self.has_backlash { self.step.state_at(self.parameter) } else { self.step.state };
            self.model.tip_error_mm(nominal, nominal, &self.step.tool_mm, &state).norm()
        };
        // Only for what is left as it was does anybody ask why.
        let is_left = (written - nominal).max_abs(&AXES) < SAME_MM;
        Follow {
            original: self.step.origin,
            corrected: piece.origin,
            rapid: piece.rapid,
            is_first,
            on_the_spot,
            nominal,
            written,
            error_mm: if is_left { error_mm(&self.step.route.at(self.parameter)) } else { 0.0 },
            errors_mm: None,
            length_mm: 0.0,
            is_stated: self.step.is_counted,
            feed_share: None,
            command: piece.route.end,
            tool: piece.tool.as_deref(),
            course,
        }
    }

    /// Whether the group ends with a piece whose end is off by `offset`.
    fn is_complete(&self, offset: &Offset, next: Option<&Step>) -> bool {
        if self.grouping == Grouping::ByMarks {
            return next.is_none_or(|next| !next.continues);
        }
        let whole_mm = self.step.route.size_mm();
        if self.length_mm < LEAST_SHARE * whole_mm - SAME_END_MM {
            return false;
        }
        let off_mm = self.off_mm(offset);
        let next = next.filter(|next| next.rapid == self.step.rapid);
        let with_next = next.map_or(f64::INFINITY, |next| self.length_mm + next.route.size_mm());
        let next_is_nearer = next.is_some_and(|next| {
            with_next <= whole_mm * (1.0 + SAME_END_SHARE) + SAME_END_MM
                && self.off_mm(&self.offset(next, 1.0)) + NEARER_MM < off_mm
        });
        let leads_away = with_next > whole_mm + 2.0 * MEANT_END_MM;
        let near_mm = if leads_away { MEANT_END_MM } else { SAME_END_MM.max(SAME_END_SHARE * whole_mm) };
        !next_is_nearer && off_mm <= near_mm
    }

    /// How far the tool is from the place of the original move at `parameter` when a piece has ended.
    fn offset(&self, piece: &Step, parameter: f64) -> Offset {
        let command = piece.route.end;
        let state = if self.has_backlash { piece.state_before_end() } else { piece.state };
        let nominal = self.step.route.at(parameter);
        let tip = self.model.tip_error_mm(&nominal, &command, &piece.tool_mm, &state);
        let turned = ROTARY_AXES.map(|axis| ROTARY_ARM_MM * (command[axis] - nominal[axis]));
        Offset { tip, turned: Vector::from(turned) }
    }

    /// An offset as a distance, mm: by itself, or from the one at the start.
    fn off_mm(&self, offset: &Offset) -> f64 {
        offset.norm_mm().min(offset.minus(&self.carried).norm_mm())
    }

    /// The parameter of the original move at which its nominal tip is nearest to the end of a piece: Gauss–Newton from the share of
    /// the length.
    fn nearest(&self, piece: &Step) -> f64 {
        let mut parameter = (self.length_mm / self.step.route.size_mm().max(ON_THE_SPOT_MM)).min(1.0);
        for _ in 0..NEAREST_STEPS {
            let [low, high] = [parameter - SENSE_STEP, parameter + SENSE_STEP].map(|value| value.clamp(0.0, 1.0));
            let mut change = self.offset(piece, high).minus(&self.offset(piece, low));
            if change.tip.norm() > TIP_DECIDES * change.turned.norm() {
                // Corrections of rotary axes are no sign of another place.
                change.turned = Vector::zeros();
            }
            let square = change.dot(&change);
            if square > 0.0 {
                parameter -= (high - low) * change.dot(&self.offset(piece, parameter)) / square;
            }
            parameter = parameter.clamp(self.parameter, 1.0);
        }
        parameter
    }

    /// Adds the errors of a piece; the largest of the original and of the corrected program, where they count.
    fn sample(&self, piece: &Step, to: f64, prediction: &mut Prediction) -> Option<[f64; 2]> {
        let size_mm = self.step.route.size_mm() * (to - self.parameter);
        let stands_still = size_mm < ON_THE_SPOT_MM && self.step.route.size_mm() > ON_THE_SPOT_MM;
        if stands_still || !self.step.is_counted || !prediction.wants(self.step.rapid) {
            return None;
        }
        let mut largest = [0.0_f64; 2];
        let count = sample_count(size_mm, SAMPLE_MM);
        for k in 0..count {
            let fraction = sample_place(k, count);
            let parameter = self.parameter + (to - self.parameter) * fraction;
            let nominal = self.step.route.at(parameter);
            let command = piece.route.at(fraction);
            let (before, after) = if self.has_backlash {
                (self.step.state_at(parameter), piece.state_at(fraction))
            } else {
                (self.step.state, piece.state)
            };
            let before_mm = self.model.tip_error_mm(&nominal, &nominal, &self.step.tool_mm, &before).norm();
            let after_mm = self.model.tip_error_mm(&nominal, &command, &piece.tool_mm, &after).norm();
            prediction.add(self.step.rapid, before_mm, after_mm, &self.step.origin);
            largest = [largest[0].max(before_mm), largest[1].max(after_mm)];
        }
        Some(largest)
    }
}
