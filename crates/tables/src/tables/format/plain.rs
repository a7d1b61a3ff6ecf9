//! Converts tables for formats without weights, switches and free nodes, without changing their effect.

use super::rounded;
use crate::tables::{Lookup, Nodes, Sense, Tables};
use ncfix_base::geometry::Axis;

/// Applies weights to the values and drops disabled tables. Products keep theirs, as they refer to each other by index.
pub(super) fn weigh(tables: &mut Tables) {
    if tables.lookups.iter().any(|one| one.factor.is_some()) {
        return;
    }
    tables.lookups.retain(|one| one.is_enabled);
    for one in &mut tables.lookups {
        let weight = std::mem::replace(&mut one.weight, 1.0);
        if weight != 1.0 {
            one.values.iter_mut().for_each(|value| *value *= weight);
        }
    }
}

/// Converts the nodes to explicit positions, rounded to a number of decimals.
pub(super) fn name_points(one: &mut Lookup, decimals: usize) {
    // A step that is far too small must not produce an extreme length.
    if one.values.len() == one.nodes.count() {
        let positions = (0..one.values.len()).map(|index| rounded(one.nodes.position(index), decimals));
        one.nodes = Nodes::At(positions.collect());
    }
}

/// Rounds positions in equal steps.
pub(super) fn round_steps(one: &mut Lookup, decimals: usize) {
    if let Nodes::Even { start, step, end } = &mut one.nodes {
        for value in [start, step, end] {
            *value = rounded(*value, decimals);
        }
    }
}

/// Converts explicit positions with equal spacing, within the decimals, to steps; the last step may be shorter.
pub(super) fn even_points(one: &mut Lookup, decimals: usize) {
    let Nodes::At(points) = &one.nodes else { return };
    let (&[start, second, ..], Some(&end)) = (&points[..], points.last()) else { return };
    let even = Nodes::Even { start, step: rounded(second - start, decimals), end };
    let unit = 0.1_f64.powi(i32::try_from(decimals).unwrap_or(0));
    let is_near = |(index, point): (usize, &f64)| (even.position(index) - point).abs() < 0.5 * unit;
    if even.count() == points.len() && points.iter().enumerate().all(is_near) {
        one.nodes = even;
    }
}

/// All positions of some tables, increasing.
pub(super) fn points_of<'a>(tables: impl IntoIterator<Item = &'a Lookup>) -> Vec<f64> {
    let mut points: Vec<f64> = Vec::new();
    for one in tables {
        points.extend((0..one.values.len()).map(|index| one.nodes.position(index)));
    }
    points.retain(|point| point.is_finite());
    points.sort_by(f64::total_cmp);
    points.dedup();
    points
}

/// The sum of tables of one input and one output axis: a table for both directions, or one for each. Sums of piecewise linear functions are linear
/// between all of their points, so this changes only the last digit.
pub(super) fn sum(group: &[&Lookup], points: &[f64], decimals: usize) -> Vec<Lookup> {
    let Some(first) = group.first() else { return Vec::new() };
    let in_sense = |sense: Sense| -> Vec<f64> {
        let moving = |one: &&&Lookup| one.sense == Sense::Both || one.sense == sense;
        let value = |&point: &f64| group.iter().filter(moving).map(|one| one.value(point)).sum::<f64>();
        points.iter().map(|point| rounded(value(point), decimals)).collect()
    };
    let table = |sense: Sense, values: Vec<f64>| {
        let nodes = Nodes::At(points.to_vec());
        Lookup { sense, ..Lookup::added(first.input, first.output, nodes, values) }
    };
    let (forward, backward) = (in_sense(Sense::Positive), in_sense(Sense::Negative));
    if forward == backward {
        vec![table(Sense::Both, forward)]
    } else {
        vec![table(Sense::Positive, forward), table(Sense::Negative, backward)]
    }
}

/// The basic axes in the order of their first occurrence.
pub(super) fn inputs(tables: &Tables) -> Vec<Axis> {
    let mut inputs = Vec::new();
    for one in &tables.lookups {
        if !inputs.contains(&one.input) {
            inputs.push(one.input);
        }
    }
    inputs
}

/// The table of an input axis for an output axis in a direction, or in both.
pub(super) fn find(tables: &Tables, input: Axis, output: Axis, sense: Sense) -> Option<&Lookup> {
    let fits = |one: &&Lookup| {
        one.input == input && one.output == output && matches!(one.sense, Sense::Both) | (one.sense == sense)
    };
    tables.lookups.iter().find(fits)
}
