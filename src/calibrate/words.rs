//! What the data cannot tell, in words.
//!
//! A null space says it by as many directions, of which any mixture would do as well. Here every direction has one column of its own, the
//! last in an order of simplicity (unknowns of the set-ups, then parameters by degree), and says it by columns before: a coefficient of high
//! degree cannot be told from those of low degree, a parameter from places of balls, not the other way round.

use nalgebra::DVector;

use crate::geometry::Axis;
use crate::measure::data::DataSet;
use crate::measure::kind::Unknown;
use crate::model::parameter::Term;

use super::column::Column;
use super::effect;

/// Parts of a direction that are smaller than this share of its largest one are left out.
const COUNTS: f64 = 0.01;
/// What is smaller is left by the arithmetic.
const NOISE: f64 = 1e-6;
/// Names in a sentence at most.
const MOST_NAMES: usize = 6;
/// Positions that are nearer to each other are one, mm or rad.
const SAME_PLACE: f64 = 1e-3;

/// What cannot be told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lost {
    /// A sentence for every combination with parameters of the machine.
    pub parameters: Vec<String>,
    /// A sentence for every combination of nothing but unknowns of set-ups, as the height of a ball-bar over a circle: they do no harm, and
    /// stay where they start.
    pub unknowns: Vec<String>,
    /// The columns that stay, one for each of these sentences.
    pub(super) held: Vec<usize>,
    /// All columns that take part in these.
    pub(super) loose: Vec<usize>,
}

/// Says a null space, which has its directions by sizes of effects ([`crate::numeric::Solution::null_space`]).
#[must_use]
pub fn lost(null_space: &[DVector<f64>], columns: &[Column], data: &[DataSet]) -> Lost {
    let mut order: Vec<usize> = (0..columns.len()).collect();
    order.sort_by_key(|&k| (simplicity(columns, k), k));
    let mut found = told_apart(null_space, &order);
    found.sort_by_key(|(own, _)| *own);
    let mut lost = Lost::default();
    for (own, direction) in &found {
        let text = sentence(*own, direction, columns, data);
        if columns.get(*own).is_some_and(Column::is_of_machine) {
            lost.parameters.push(text);
        } else {
            // Unknowns come first: what has one of them for its own column has no parameter at all.
            lost.unknowns.push(text);
            lost.held.push(*own);
            let largest = direction.amax();
            lost.loose.extend((0..columns.len()).filter(|&k| direction[k].abs() > NOISE * largest));
        }
    }
    lost
}

/// The lower, the rather it stands for others.
fn simplicity(columns: &[Column], k: usize) -> (u8, u8) {
    match columns.get(k) {
        Some(Column::Parameter(name)) => match name.term {
            Term::Whole | Term::Coefficient(_) => (1, name.degree()),
            Term::Backlash => (2, 0),
            Term::Knot { degree, .. } => (3, degree),
        },
        Some(Column::Effect(parameter)) => (4, u8::try_from(parameter.index()).unwrap_or(u8::MAX)),
        _ => (0, 0),
    }
}

/// The same space by directions each of which has a column that no other has, the last possible in the order.
fn told_apart(null_space: &[DVector<f64>], order: &[usize]) -> Vec<(usize, DVector<f64>)> {
    let mut open: Vec<DVector<f64>> = null_space.to_vec();
    let mut done: Vec<(usize, DVector<f64>)> = Vec::new();
    for &column in order.iter().rev() {
        let part = |row: &DVector<f64>| row.get(column).map_or(0.0, |part| part.abs());
        let Some(best) = (0..open.len()).max_by(|&a, &b| part(&open[a]).total_cmp(&part(&open[b]))) else { break };
        if part(&open[best]) <= NOISE * open[best].amax() {
            continue;
        }
        let mut own = open.swap_remove(best);
        own /= own[column];
        for row in open.iter_mut().chain(done.iter_mut().map(|(_, row)| row)) {
            let factor = row[column];
            *row -= &own * factor;
            // Exactly, so that it does not come back as noise.
            row[column] = 0.0;
        }
        done.push((column, own));
    }
    done
}

fn sentence(own: usize, direction: &DVector<f64>, columns: &[Column], data: &[DataSet]) -> String {
    let largest = direction.amax();
    let name = |k: usize| columns.get(k).map(|column| column.name(data).to_string()).unwrap_or_default();
    let parts = direction.iter().enumerate().filter(|&(k, part)| k != own && part.abs() >= COUNTS * largest);
    // Parameters of the machine first: they are what is asked for.
    let mut others: Vec<usize> = parts.map(|(k, _)| k).collect();
    // Then lengths of instruments, which a person can do something about; a shift of a set-up comes with most of it.
    let rank = |k: usize| match columns.get(k) {
        Some(Column::Unknown(_, Unknown::Length(_) | Unknown::Rod(_) | Unknown::RodTemperature(_))) => 1,
        Some(column) if column.is_of_machine() => 0,
        _ => 2,
    };
    others.sort_by_key(|&k| (rank(k), k));
    let hint = hint(own, &others, columns, data);
    if others.is_empty() {
        return format!("{} moves nothing that was measured{hint}", name(own));
    }
    let shown = others.iter().take(MOST_NAMES).map(|&k| name(k)).collect::<Vec<_>>();
    let shown = match (shown.as_slice(), others.len().saturating_sub(MOST_NAMES)) {
        ([most @ .., last], 0) if !most.is_empty() => format!("{} and {last}", most.join(", ")),
        (all, 0) => all.join(", "),
        (all, more) => format!("{} and {more} more", all.join(", ")),
    };
    format!("{} cannot be told from {shown}{hint}", name(own))
}

/// Which axis of those concerned stood at too few positions, if one did.
fn hint(own: usize, others: &[usize], columns: &[Column], data: &[DataSet]) -> String {
    let names = || {
        std::iter::once(&own).chain(others).filter_map(|&k| match columns.get(k) {
            Some(Column::Parameter(name)) => Some(name),
            _ => None,
        })
    };
    let effects: Vec<&str> = std::iter::once(&own)
        .chain(others)
        .filter_map(|&k| match columns.get(k) {
            Some(Column::Effect(parameter)) => Some(parameter.name()),
            _ => None,
        })
        .collect();
    if let Some(text) = Some(&effects).filter(|names| !names.is_empty()).and_then(|names| effect::hint(names, data)) {
        return text.to_owned();
    }
    let mut axes: Vec<Axis> = names().filter_map(|name| name.component.axis()).collect();
    axes.sort_unstable();
    axes.dedup();
    let few = axes.into_iter().find_map(|axis| {
        let highest =
            names().filter(|name| name.component.axis() == Some(axis)).map(|name| name.degree()).max().unwrap_or(0);
        let needed = (usize::from(highest) + 1).max(if axis.is_rotary() { 2 } else { 1 });
        if names().any(|name| name.term == Term::Backlash && name.component.axis() == Some(axis)) {
            let mut readings = data.iter().flat_map(|set| &set.observations);
            let first = readings.next().map(|row| row.reading.state.direction(axis));
            if readings.all(|row| Some(row.reading.state.direction(axis)) == first) {
                return Some(format!("; {axis} was reached in one sense only"));
            }
        }
        let found = positions(axis, data, needed);
        let s = if found == 1 { "" } else { "s" };
        (found < needed).then(|| format!("; {axis} stood at {found} position{s}, at least {needed} are needed"))
    });
    few.unwrap_or_default()
}

/// How many positions of an axis there are, counted up to `most`.
fn positions(axis: Axis, data: &[DataSet], most: usize) -> usize {
    let mut found: Vec<f64> = Vec::new();
    for observation in data.iter().flat_map(|set| &set.observations) {
        let position = observation.reading.position[axis];
        if found.len() < most && found.iter().all(|known| (known - position).abs() > SAME_PLACE) {
            found.push(position);
        }
    }
    found.len()
}
