//! The errors of an original and a corrected program, both on the error model, both against the nominal path of the original.
//!
//! The streams are walked side by side: every move of the original corresponds to one move of the corrected program or to several in
//! a row. What matters is where the tool is: a group of moves is complete when its tip, on the error model, reaches the nominal tip
//! at the end of the original move, and in between belongs to the place of the original move whose nominal tip is nearest. Marks in
//! the text are not needed, so programs of other origin, or an original beside itself, can be compared too; where a program is known
//! to carry them ([`Grouping::ByMarks`]), they decide instead.

mod acts;
mod ahead;
mod course;
mod detour;
mod difference;
mod feed;
mod group;
mod judge;
mod manner;
mod parting;
mod promise;
mod same_text;
mod step;

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::AxisVector;
use ncfix_machine::machine::{Kinematics, Machine};
use ncfix_machine::snc::{Element, Origin, WordValue};
use ncfix_model::Model;

pub use course::Course;
pub use difference::{ActSubject, Difference, What};
pub use parting::Parting;
pub use promise::Promise;

use ahead::{MovesAhead, rejoin};
use group::{MoveGroup, Offset};
use judge::Judge;
use step::{ComparedMove, Walk};

use super::lead::Lead;
use super::prediction::SpreadPair;
use super::{Feeds, Prediction, Spread};

/// Takes what is seen along the moves.
type See<'a> = &'a mut dyn FnMut(Follow<'_>);
/// Takes what differs.
type Differ<'a> = &'a mut dyn FnMut(Difference);

/// Ends nearer than this are the same, mm.
const SAME_END_MM: f64 = 0.02;
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
    /// What the correction has promised; `None` where its motion is measured only.
    pub promise: Option<Promise>,
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
    let how = How { grouping, feeds: [Feeds::default(); 2], promise: None };
    let found = compare_seeing(original, corrected, how, machine, model, (&mut |_| {}, &mut |_| {}));
    found.map_err(|partings| {
        let line = |origin: &Origin| format!("line {} of the corrected program", origin.line);
        let first = partings.first().map(|parting| parting.diagnostic(line));
        first.unwrap_or_else(|| Diagnostic::nowhere(Code::CANNOT_ALIGN, "the programs part", "compare them by eye"))
    })
}

/// Places at which programs part before it is said that they have nothing to do with each other.
const MOST_PARTINGS: usize = 20;

/// The same; every piece of the corrected program is shown on the way, and every difference that is no correction.
///
/// # Errors
/// The places at which the moves of the one do not follow those of the other; behind each the comparison goes on where both have the same block again.
pub fn compare_seeing(
    original: impl Iterator<Item = Element>,
    corrected: impl Iterator<Item = Element>,
    How { grouping, feeds, promise }: How,
    machine: &Machine,
    model: &Model,
    (see, differ): (See<'_>, Differ<'_>),
) -> Result<Comparison, Vec<Parting>> {
    let lead = Lead::new(model, machine);
    let original = Walk::new(original, machine, feeds[0], lead);
    let corrected = Walk::new(corrected, machine, feeds[1], lead);
    let tails = [original.tail(), corrected.tail()];
    let (mut original, mut corrected) = (MovesAhead::new(original), MovesAhead::new(corrected));
    let kinematics = Kinematics::new(machine);
    let mut prediction = Prediction::default();
    let mut judge = Judge::new(promise, machine, differ);
    let mut carried = Offset::default();
    let mut partings: Vec<Parting> = Vec::new();
    while let Some(mut step) = original.next() {
        let mut group = MoveGroup::new(model, grouping, (&kinematics, lead), &step, carried);
        judge.begin(original.peek().is_some_and(|next| step.runs_into(next)));
        match group.follow(&mut corrected, &mut prediction, see, &mut judge) {
            Ok(offset) => carried = offset,
            Err(mut parting) => {
                let is_judged = group.is_judged;
                judge.part(&step);
                let ends = |step: &ComparedMove, piece: &ComparedMove| {
                    let of = (&kinematics, lead);
                    MoveGroup::new(model, grouping, of, step, Offset::default()).ends_at(piece)
                };
                if let (Some(next), Some(piece)) = (original.peek(), corrected.peek())
                    && parting.corrected == Some(piece.origin)
                    && ends(next, piece)
                {
                    parting.lacks_a_move();
                }
                partings.push(parting);
                if is_judged {
                    step.acts.clear();
                }
                original.put_back(step);
                let passed = (partings.len() < MOST_PARTINGS).then(|| rejoin(&mut original, &mut corrected, ends));
                let Some(passed) = passed.flatten() else {
                    if let (Some(step), Some(piece)) = (original.peek(), corrected.peek()) {
                        judge.lose(step, piece);
                    }
                    return Err(partings);
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
            let why = "moves on behind the end of the original";
            partings.push(Parting::at(&step, &step, why, [step.route.end; 2], false));
            return Err(partings);
        }
        rest.extend(step.acts);
    }
    rest.append(&mut tails[1].borrow_mut());
    judge.rest(&tails[0].borrow(), &rest);
    if partings.is_empty() { Ok(prediction.counted().into()) } else { Err(partings) }
}

impl From<&SpreadPair> for Comparison {
    fn from(pair: &SpreadPair) -> Comparison {
        Comparison { before: pair.before, after: pair.after, samples: pair.after.samples, max_at: pair.max_at }
    }
}
