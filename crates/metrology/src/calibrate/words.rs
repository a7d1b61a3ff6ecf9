//! The unidentifiable part of a model, in words.
//!
//! Every direction of the null space has its own parameter (`null_space`), the last in an order of simplicity (set-up unknowns, location errors,
//! coefficients by degree, backlash, truncated powers, parameters of effects). It is described by simpler columns: a coefficient of high degree is
//! not distinguishable from those of low degree, a parameter not from ball positions, never the reverse. Directions of one kind share a sentence.

use nalgebra::DVector;

use crate::measure::data::DataSet;
use crate::measure::kind::{Measurand, Unknown};
use ncfix_base::geometry::Plane;
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::squareness::{SquarenessTerm, squareness};
use ncfix_model::parameter::{ComponentTerm, ParameterName};

use super::cause::{UndeterminedCause, cause};
use super::column::Column;
use super::effect::Parameter;
use super::null_space::{self, COUNTS, NullDirection};

/// End of the sentence about parameters that no reading depends on.
const NO_EFFECT: &str = "no effect on the measurements";
/// Maximum number of names in a sentence.
const MOST_NAMES: usize = 6;
/// Smallest number of consecutive truncated powers of a component of which only the first and the last are shown.
const MANY_KNOTS: usize = 3;

/// The unidentifiable part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lost {
    /// Combinations with machine parameters, grouped by kind, the most frequent kind first.
    pub confused: Vec<Confused>,
    /// A smallest set of parameters whose removal makes all others identifiable, by the rule of [`super::reduce()`].
    pub leave_out: Vec<Parameter>,
    /// A sentence for every combination of set-up unknowns alone, such as the height of a ball-bar over a circle: they are harmless, and held at
    /// their start values.
    pub unknowns: Vec<String>,
    /// The held columns, one for each of these sentences.
    pub(super) held: Vec<usize>,
    /// All columns involved in these.
    pub(super) loose: Vec<usize>,
}

/// Parameters that are not identifiable for one reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Confused {
    /// The sentence about them.
    pub sentence: String,
    /// The remedy.
    pub remedy: String,
    /// The parameters, each with its own combination.
    pub parameters: Vec<Parameter>,
    /// The measurement whose unknowns are involved, if any.
    pub set: Option<usize>,
}

/// Describes a null space, whose directions are scaled by effects ([`ncfix_base::numeric::Solution::null_space`]).
#[must_use]
pub fn lost(null_space: &[DVector<f64>], columns: &[Column], data: &[DataSet]) -> Lost {
    let is_parameter = |k: &usize| columns.get(*k).is_some_and(Column::is_of_machine);
    let (mut parameters, unknowns): (Vec<usize>, Vec<usize>) = (0..columns.len()).partition(is_parameter);
    parameters.sort_by_key(|&k| (columns.get(k).map(simplicity), k));
    let found = null_space::directions(null_space, &[unknowns, parameters]);
    let (mut told, held): (Vec<NullDirection>, Vec<NullDirection>) =
        found.into_iter().partition(|(own, _)| is_parameter(own));
    let mut lost = Lost::default();
    for (own, direction) in &held {
        lost.unknowns.push(single(*own, &others(*own, direction, columns), columns, data));
        lost.held.push(*own);
        lost.loose.extend((0..columns.len()).filter(|&k| direction[k] != 0.0));
    }
    let lengths: Vec<usize> = (0..columns.len()).filter(|&k| columns.get(k).is_some_and(is_length)).collect();
    let name = |own: usize| columns.get(own).and_then(Column::parameter);
    lost.leave_out = told.iter().filter_map(|(own, _)| name(*own)).collect();
    null_space::shorten(&mut told);
    let mut kinds: Vec<(Key, Vec<Member>)> = Vec::new();
    for (own, direction) in &told {
        let others = others(*own, direction, columns);
        let Some(parameter) = name(*own) else { continue };
        let shown: Vec<&Column> = others.iter().filter_map(|&k| columns.get(k)).collect();
        let cause = cause(&parameter, &shown, data, null_space::is_settled(null_space, *own, &lengths));
        let key = Key { cause, is_unfelt: others.is_empty(), unknowns: phrases(&shown, data) };
        match kinds.iter_mut().find(|(known, _)| known.is_like(&key)) {
            Some((known, members)) => {
                known.add(key);
                members.push((*own, others));
            }
            None => kinds.push((key, vec![(*own, others)])),
        }
    }
    kinds.sort_by_key(|(_, members)| std::cmp::Reverse(members.len()));
    for (key, members) in kinds {
        let parameters: Vec<Parameter> = members.iter().filter_map(|(own, _)| name(*own)).collect();
        let sentence = match members.as_slice() {
            [(own, others)] => format!("{}{}", single(*own, others, columns, data), key.cause),
            _ => of_many(&key, &parameters, &members, columns),
        };
        let set = members.iter().flat_map(|(_, others)| others).find_map(|&k| match columns.get(k) {
            Some(Column::Unknown(set, _)) => Some(*set),
            _ => None,
        });
        lost.confused.push(Confused { sentence, remedy: key.cause.remedy(parameters.len() > 1), parameters, set });
    }
    lost
}

/// Adds the name of a squareness at the other axis to the remedy, where the chain of the machine hides the effect of the stated name.
pub(super) fn name_other_axis(lost: &mut Lost, machine: &Machine) {
    let direction = |axis| machine.axis(axis).map(|data| data.direction);
    let planes = [Plane::XY, Plane::ZX, Plane::YZ];
    let terms: Vec<SquarenessTerm> =
        planes.into_iter().filter_map(|plane| squareness(&machine.topology, plane, direction)).collect();
    for one in lost.confused.iter_mut().filter(|one| one.sentence.contains(NO_EFFECT)) {
        let of = |parameter: &Parameter| {
            let name = parameter.to_string();
            terms.iter().find(|term| term.other == name).map(|term| format!("{} instead of {name}", term.name))
        };
        let names: Vec<String> = one.parameters.iter().filter_map(of).collect();
        if !names.is_empty() {
            let (chain, names) = (&machine.topology, joined(&names, MOST_NAMES));
            one.remedy = format!("on {chain} this squareness has another name: {names}; otherwise {}", one.remedy);
        }
    }
}

/// A direction as described: its own column and the others.
type Member = (usize, Vec<usize>);

/// Common properties of directions of one kind.
#[derive(Clone, Debug, PartialEq)]
struct Key {
    cause: UndeterminedCause,
    is_unfelt: bool,
    /// Involved set-up unknowns, in words.
    unknowns: Vec<String>,
}

impl Key {
    /// `true` if both are of one kind.
    fn is_like(&self, other: &Key) -> bool {
        let is_same = match (self.cause, other.cause) {
            (UndeterminedCause::Few(axis, found, _), UndeterminedCause::Few(other, others, _)) => {
                (axis, found) == (other, others)
            }
            (one, other) => one == other,
        };
        is_same && self.is_unfelt == other.is_unfelt && (self.cause.is_of_poses() || self.unknowns == other.unknowns)
    }

    /// Adds another direction of the kind.
    fn add(&mut self, other: Key) {
        // As many positions as the highest degree needs.
        self.cause = self.cause.max(other.cause);
        self.unknowns.extend(other.unknowns.into_iter().filter(|one| !self.unknowns.contains(one)).collect::<Vec<_>>());
    }
}

/// Rank of simplicity: a lower one represents the others.
pub(super) fn simplicity(column: &Column) -> (u8, u8) {
    match column {
        Column::Parameter(name) => match name.term {
            ComponentTerm::Whole => (1, 0),
            ComponentTerm::Coefficient(degree) => (2, degree),
            ComponentTerm::Backlash => (3, 0),
            ComponentTerm::Knot { degree, .. } => (4, degree),
        },
        Column::Effect(parameter) => (5, u8::try_from(parameter.index()).unwrap_or(u8::MAX)),
        Column::Unknown(..) => (0, 0),
    }
}

/// True for the length of an instrument.
fn is_length(column: &Column) -> bool {
    matches!(column, Column::Unknown(_, Unknown::Length(_) | Unknown::Rod(_) | Unknown::RodTemperature(_)))
}

/// The other columns of a direction, machine parameters first, as these are of interest.
fn others(own: usize, direction: &DVector<f64>, columns: &[Column]) -> Vec<usize> {
    let least = COUNTS * direction.amax();
    let mut others: Vec<usize> = (0..direction.len()).filter(|&k| k != own && direction[k].abs() >= least).collect();
    // Then lengths of instruments, which can be measured; a shift of a set-up accompanies most directions.
    let rank = |k: usize| match columns.get(k) {
        Some(column) if is_length(column) => 1,
        Some(column) if column.is_of_machine() => 0,
        _ => 2,
    };
    others.sort_by_key(|&k| (rank(k), k));
    others
}

/// One direction with all names.
fn single(own: usize, others: &[usize], columns: &[Column], data: &[DataSet]) -> String {
    let name = |k: usize| columns.get(k).map(|column| column.name(data).to_string()).unwrap_or_default();
    if others.is_empty() {
        return format!("{} has {NO_EFFECT}", name(own));
    }
    let all: Vec<String> = others.iter().map(|&k| name(k)).collect();
    format!("{} is not separable from {}", name(own), joined(&all, MOST_NAMES))
}

/// Several directions of one kind.
fn of_many(key: &Key, own: &[Parameter], members: &[Member], columns: &[Column]) -> String {
    let names = listed(own, MOST_NAMES);
    if key.is_unfelt {
        return format!("{names} have {NO_EFFECT}{}", key.cause);
    }
    let mut from: Vec<Parameter> = Vec::new();
    for &k in members.iter().flat_map(|(_, others)| others) {
        if let Some(name) = columns.get(k).and_then(Column::parameter)
            && !from.contains(&name)
            && !own.contains(&name)
        {
            from.push(name);
        }
    }
    let parameters = if from.is_empty() { None } else { Some(listed(&from, MOST_NAMES)) };
    let all: Vec<String> = parameters.into_iter().chain(key.unknowns.iter().cloned()).collect();
    let what = if key.cause == UndeterminedCause::Constant { ": constant parts" } else { "" };
    let each = if all.is_empty() { "each other".to_owned() } else { joined(&all, usize::MAX) };
    format!("{names}{what} are not separable from {each}{}", key.cause)
}

/// `a, b and c`, or the first ones and the number of the others.
fn joined(all: &[String], most: usize) -> String {
    let shown = all.get(..most.min(all.len())).unwrap_or_default();
    match (shown, all.len() - shown.len()) {
        ([first @ .., last], 0) if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        (shown, 0) => shown.join(", "),
        (shown, more) => format!("{} and {more} more", shown.join(", ")),
    }
}

/// Names of parameters, with truncated powers of a component combined: `EXX2@50 … EXX2@350`.
#[must_use]
pub fn listed(names: &[Parameter], most: usize) -> String {
    let family = |name: &Parameter| match name {
        Parameter::Geometry(ParameterName { component, term: ComponentTerm::Knot { degree, .. } }) => {
            Some((*component, *degree))
        }
        _ => None,
    };
    let mut items: Vec<(String, usize)> = Vec::new();
    let mut rest = names;
    while let Some(first) = rest.first() {
        let own = family(first);
        let run = rest.iter().take_while(|name| own.is_some() && family(name) == own).count().max(1);
        let (now, later) = rest.split_at(run);
        match now {
            [first, .., last] if run >= MANY_KNOTS => items.push((format!("{first} … {last}"), run)),
            _ => items.extend(now.iter().map(|name| (name.to_string(), 1))),
        }
        rest = later;
    }
    let shown: Vec<String> = items.iter().take(most).map(|(text, _)| text.clone()).collect();
    let more: usize = items.iter().skip(most).map(|(_, count)| count).sum();
    if more > 0 { format!("{} and {more} more", shown.join(", ")) } else { joined(&shown, usize::MAX) }
}

/// The kinds of set-up unknowns, each once.
fn phrases(columns: &[&Column], data: &[DataSet]) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for column in columns {
        let Column::Unknown(number, unknown) = column else { continue };
        let Some(set) = data.get(*number) else { continue };
        let phrase = match unknown {
            Unknown::Centre(..) => "the position of the table ball",
            Unknown::Length(_) => "the length of the ball-bar",
            Unknown::Rod(_) => "the length of the rod",
            Unknown::RodTemperature(_) => "the temperature of the rod",
            Unknown::Drift(_) => "the drift of the instrument",
            Unknown::Level(_) => "the zeros of the cycles",
            Unknown::Offset(..) if set.kind.measurand == Measurand::Component => "the zero of the instrument",
            Unknown::Offset(..) => "the position of the artifact",
            Unknown::Rotation(..) => "the rotation of the artifact",
            Unknown::Slope(_) => "the alignment of the instrument",
            Unknown::Place(..) => "the positions of the balls",
            Unknown::Tool(..) => "the tool",
            Unknown::Own(what, _) => what,
        };
        let phrase = if data.len() > 1 { format!("{phrase} ({})", set.name) } else { phrase.to_owned() };
        if !out.contains(&phrase) {
            out.push(phrase);
        }
    }
    out.sort_unstable();
    out
}
