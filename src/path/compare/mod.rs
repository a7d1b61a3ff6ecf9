//! The errors of an original and a corrected program, both on the error model, both against the nominal path of the original.
//!
//! The streams are walked side by side: every move of the original corresponds to one move of the corrected program or to several in
//! a row. What matters is where the tool is: a group of moves is complete when its tip, on the error model, reaches the nominal tip
//! at the end of the original move, and in between belongs to the place of the original move whose nominal tip is nearest. Marks in
//! the text are not needed, so programs of other origin, or an original beside itself, can be compared too; where a program is known
//! to carry them ([`Grouping::ByMarks`]), they decide instead.

mod acts;
mod course;
mod difference;
mod feed;
mod group;
mod judge;
mod promise;
mod step;

use crate::diagnostic::Diagnostic;
use crate::geometry::{AXES, AxisVector};
use crate::machine::{Kinematics, Machine};
use crate::model::Model;
use crate::snc::{Element, Origin, WordValue};

pub use course::Course;
pub use difference::{Difference, What};
pub use promise::Promise;

use group::{Group, Offset};
use judge::Judge;
use step::Walk;

use super::prediction::Pair;
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
    compare_seeing(original, corrected, how, machine, model, (&mut |_| {}, &mut |_| {}))
}

/// The same; every piece of the corrected program is shown on the way, and every difference that is no correction.
///
/// # Errors
/// `E0311` where the moves of the one do not follow those of the other.
pub fn compare_seeing(
    original: impl Iterator<Item = Element>,
    corrected: impl Iterator<Item = Element>,
    How { grouping, feeds, promise }: How,
    machine: &Machine,
    model: &Model,
    (see, differ): (See<'_>, Differ<'_>),
) -> Result<Comparison, Diagnostic> {
    let has_backlash = AXES.into_iter().any(|axis| model.features(axis).backlash);
    let original = Walk::new(original, machine, feeds[0], has_backlash);
    let corrected = Walk::new(corrected, machine, feeds[1], has_backlash);
    let tails = [original.tail(), corrected.tail()];
    let mut corrected = corrected.peekable();
    let kinematics = Kinematics::new(machine);
    let mut prediction = Prediction::default();
    let mut judge = Judge::new(promise, machine, differ);
    let mut carried = Offset::default();
    for step in original {
        let mut group = Group::new(model, grouping, (&kinematics, has_backlash), &step, carried);
        carried = group.follow(&mut corrected, &mut prediction, see, &mut judge)?;
    }
    let mut rest = Vec::new();
    for step in &mut corrected {
        if step.route.size_mm() > SAME_END_MM {
            return Err(step.mismatch("the corrected program goes on behind the end of the original"));
        }
        rest.extend(step.acts);
    }
    rest.append(&mut tails[1].borrow_mut());
    judge.tail(&tails[0].borrow(), &rest);
    Ok(prediction.counted().into())
}

impl From<&Pair> for Comparison {
    fn from(pair: &Pair) -> Comparison {
        Comparison { before: pair.before, after: pair.after, samples: pair.after.samples, max_at: pair.max_at }
    }
}
