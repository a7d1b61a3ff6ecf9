//! The errors of an original and a corrected program, both on the error model, both relative to the nominal path of the original.
//!
//! The streams are read in parallel: every move of the original corresponds to one or several consecutive moves of the corrected program. A group of
//! moves is complete when its tip, on the error model, reaches the nominal tip at the end of the original move. In between, a piece belongs to the
//! place of the original move whose nominal tip is nearest. This needs no marks in the text, so programs of other origin, or an original and itself,
//! can be compared too. If a program is known to carry marks ([`Grouping::ByMarks`]), the marks decide.

mod acts;
mod ahead;
mod course;
mod detour;
mod difference;
mod divergence;
mod feed;
mod group;
mod judge;
mod motion_mode;
mod promise;
mod same_text;
mod step;

use std::convert::Infallible;

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::AxisVector;
use ncfix_machine::machine::{Kinematics, Machine};
use ncfix_machine::snc::{Element, Origin, WordValue};
use ncfix_model::Model;

pub use course::Course;
pub use difference::{ActSubject, ProgramDifference, What};
pub use divergence::Divergence;
pub use promise::Promise;

use ahead::{MovesAhead, omit_leads, rejoin};
use group::{BESIDE_HOLE_MM, MoveGroup};
use judge::Judge;
use step::{ComparedMove, Walk};

use super::lead::Lead;
use super::prediction::SpreadPair;
use super::sampling::{ON_THE_SPOT_MM, Offset};
use super::tip_divider::{DividedTips, TipDivider};
use super::{ErrorPlace, Feeds, Prediction, Spread};

/// Receives data along the moves.
type See<'a> = &'a mut dyn FnMut(Follow<'_>);
/// Receives the differences.
type Differ<'a> = &'a mut dyn FnMut(ProgramDifference);

/// Ends nearer to each other than this are equal, mm.
const SAME_END_MM: f64 = 0.02;

/// Errors of two programs. Feed moves count, or all moves if there are none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// The original.
    pub before: Spread,
    /// The corrected program.
    pub after: Spread,
    /// The original, beyond the displacement that a touched zero takes up.
    pub form: Spread,
    /// Number of places at which both were evaluated.
    pub samples: u64,
    /// Place in the original of the largest error of the corrected program.
    pub max_at: Option<Origin>,
    /// Some of these places.
    pub places: Vec<ErrorPlace>,
}

/// A piece of the corrected program with its place in the original.
#[derive(Clone, Copy, Debug)]
pub struct Follow<'a> {
    /// The move of the original.
    pub original: Origin,
    /// The piece.
    pub corrected: Origin,
    /// `true` for rapid, `false` for feed.
    pub rapid: bool,
    /// The first piece of its move.
    pub is_first: bool,
    /// A step on the spot: its place is the current one of the move.
    pub on_the_spot: bool,
    /// Position of the original at the end of the piece, in the coordinates of the corrected program, mm and rad.
    pub nominal: AxisVector,
    /// End of the piece, in the same coordinates.
    pub written: AxisVector,
    /// Distance of the original tip from its nominal place there, on the error model, mm; 0 if the piece is changed.
    pub error_mm: f64,
    /// The largest errors of the original and of the corrected program on the piece, mm; `None` if it does not count.
    pub errors_mm: Option<[f64; 2]>,
    /// Length of the original path that the piece covers, mm, including the weighted rotary path.
    pub length_mm: f64,
    /// `true` if the program has stated the position of all axes that it moves.
    pub is_stated: bool,
    /// Ratio of the feed of the piece to that of its move, by durations if rotary axes turn or one of them states its duration. `None` without feed
    /// or if not comparable.
    pub feed_share: Option<f64>,
    /// The axis command of the piece, mm and rad.
    pub command: AxisVector,
    /// The active tool word.
    pub tool: Option<&'a WordValue>,
    /// The part of the original that the piece covers.
    pub course: Course<'a>,
}

/// The comment text of a piece that continues the move of the block above it.
pub const CONTINUES: &str = "+";
/// The comment text of a step on the spot that continues the move of the block above it.
pub const CONTINUES_ON_THE_SPOT: &str = "+~";
/// The comment text of a step on the spot with which a move begins.
pub const ON_THE_SPOT: &str = "~";

/// Assignment of corrected moves to an original move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grouping {
    /// By the comments [`CONTINUES`] and [`CONTINUES_ON_THE_SPOT`], which the corrected program is known to carry.
    ByMarks,
    /// By the tool position.
    ByPlace,
}

/// Settings of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct How {
    /// Assignment of moves.
    pub grouping: Grouping,
    /// The path to which the feed refers in the controls of both programs.
    pub feeds: [Feeds; 2],
    /// The promise of the correction; `None` if only the motion is measured.
    pub promise: Option<Promise>,
    /// Position of all axes in the control before both programs, mm and rad, if it is stated.
    pub start: Option<AxisVector>,
}

/// Compares two programs; both must have been executed without errors.
///
/// # Errors
/// `E0311` if the moves of the two programs do not correspond.
pub fn compare(
    original: impl Iterator<Item = Element>,
    corrected: impl Iterator<Item = Element>,
    grouping: Grouping,
    machine: &Machine,
    model: &Model,
) -> Result<Comparison, Diagnostic> {
    let how = How { grouping, feeds: [Feeds::default(); 2], promise: None, start: None };
    let found = compare_seeing(original, corrected, how, machine, model, (&mut |_| {}, &mut |_| {}));
    found.map_err(|divergences| {
        let line = |origin: &Origin| format!("line {} of the corrected program", origin.line);
        let first = divergences.first().map(|divergence| divergence.diagnostic(line));
        first.unwrap_or_else(|| {
            Diagnostic::nowhere(
                Code::CANNOT_ALIGN,
                "the programs no longer match from here",
                "compare them manually from here",
            )
        })
    })
}

/// Number of divergences after which the programs count as unrelated.
const MOST_DIVERGENCES: usize = 20;

/// As [`compare`]; also reports every piece of the corrected program and every difference that is not a correction.
///
/// # Errors
/// The places at which the moves do not correspond; after each, the comparison continues at the next common block.
pub fn compare_seeing(
    original: impl Iterator<Item = Element>,
    corrected: impl Iterator<Item = Element>,
    How { grouping, feeds, promise, start }: How,
    machine: &Machine,
    model: &Model,
    (see, differ): (See<'_>, Differ<'_>),
) -> Result<Comparison, Vec<Divergence>> {
    let lead = Lead::new(model, machine);
    // A correction without the transformation has divided the paths of the tip.
    let in_axes = promise.is_some_and(|promise| promise.in_axes);
    let tips = in_axes.then(|| TipDivider::new(machine, start.unwrap_or(AxisVector::ZERO)));
    let divided = DividedTips { elements: original.map(Ok::<_, Infallible>), tips };
    let original = Walk::new(divided.map(|Ok(element)| element), machine, feeds[0], lead).from(start);
    let corrected = Walk::new(corrected, machine, feeds[1], lead).from(start);
    let tails = [original.tail(), corrected.tail()];
    let (mut original, mut corrected) = (MovesAhead::new(original), MovesAhead::new(corrected));
    let kinematics = Kinematics::new(machine);
    let mut prediction = Prediction::default();
    let mut judge = Judge::new(promise, machine, differ);
    let mut carried = Offset::default();
    let mut divergences: Vec<Divergence> = Vec::new();
    loop {
        omit_leads(&mut original, &mut corrected);
        let Some(mut step) = original.next() else { break };
        let is_too_short = step.rapid && step.in_cycle && step.route.size_mm() <= BESIDE_HOLE_MM;
        if is_too_short
            && grouping == Grouping::ByMarks
            && corrected.peek().is_some_and(|piece| !piece.rapid)
            && let Some(mut next) = original.next()
        {
            // Both levels have one corrected word.
            next.acts.splice(..0, step.acts);
            original.put_back(next);
            continue;
        }
        let mut group = MoveGroup::new(model, grouping, (&kinematics, lead), &step, carried);
        judge.begin(original.peek().is_some_and(|next| step.runs_into(next)));
        match group.follow(&mut corrected, &mut prediction, see, &mut judge) {
            Ok(offset) => carried = offset,
            Err(mut divergence) => {
                let is_judged = group.is_judged;
                judge.part(&step);
                let ends = |step: &ComparedMove<'_>, piece: &ComparedMove<'_>| {
                    let of = (&kinematics, lead);
                    MoveGroup::new(model, grouping, of, step, Offset::default()).ends_at(piece)
                };
                if let (Some(next), Some(piece)) = (original.peek(), corrected.peek())
                    && divergence.corrected == Some(piece.origin)
                    && ends(next, piece)
                {
                    divergence.lacks_a_move();
                }
                divergences.push(divergence);
                if is_judged {
                    step.acts.clear();
                }
                original.put_back(step);
                let passed =
                    (divergences.len() < MOST_DIVERGENCES).then(|| rejoin(&mut original, &mut corrected, ends));
                let Some(passed) = passed.flatten() else {
                    if let (Some(step), Some(piece)) = (original.peek(), corrected.peek()) {
                        judge.lose(step, piece);
                    }
                    return Err(divergences);
                };
                let [own, other] = passed.map(|steps| steps.into_iter().flat_map(|step| step.acts).collect::<Vec<_>>());
                judge.rest(&own, &other);
                carried = Offset::default();
            }
        }
    }
    let mut rest = Vec::new();
    for step in corrected {
        if step.route.size_mm() > SAME_END_MM {
            let why = "continues to move after the end of the original";
            divergences.push(Divergence::at(&step, &step, why, [step.route.end; 2], false));
            return Err(divergences);
        }
        rest.extend(step.acts);
    }
    rest.append(&mut tails[1].borrow_mut());
    judge.rest(&tails[0].borrow(), &rest);
    if !divergences.is_empty() {
        return Err(divergences);
    }
    let places = prediction.places();
    Ok(Comparison { places, ..prediction.counted().into() })
}

impl From<&SpreadPair> for Comparison {
    fn from(pair: &SpreadPair) -> Comparison {
        Comparison {
            before: pair.before,
            after: pair.after,
            form: pair.form,
            samples: pair.after.samples,
            max_at: pair.max_at,
            places: Vec::new(),
        }
    }
}
