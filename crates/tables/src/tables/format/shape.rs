//! Validity of tables: equal numbers of values and points, increasing positions, finite numbers.

use crate::tables::{ErrorTables, Grid, Lookup, Nodes, Tables};

/// Errors that no format can write.
pub(super) fn faults(tables: &Tables) -> Vec<String> {
    let mut faults = Vec::new();
    for (index, one) in tables.lookups.iter().enumerate() {
        faults.extend(lookup(one, tables.lookups.len()).map(|fault| format!("table {index} {fault}")));
    }
    faults.extend(tables.grid.as_ref().and_then(grid).map(|fault| format!("the grid {fault}")));
    faults.extend(tables.errors.iter().flat_map(errors));
    if tables.matrix.is_some_and(|matrix| !matrix.iter().flatten().all(|value| value.is_finite())) {
        faults.push("the matrix has a value that is not a number".to_owned());
    }
    faults
}

fn are_finite<'a>(values: impl IntoIterator<Item = &'a f64>) -> bool {
    values.into_iter().all(|value| value.is_finite())
}

/// `true` if finite and strictly increasing.
fn increase(positions: &[f64]) -> bool {
    are_finite(positions) && positions.windows(2).all(|pair| pair[0] < pair[1])
}

fn lookup(one: &Lookup, tables: usize) -> Option<String> {
    let count = one.nodes.count();
    let positions_are_good = match &one.nodes {
        Nodes::Even { start, step, end } => are_finite([start, step, end]),
        Nodes::At(positions) => increase(positions),
    };
    if !positions_are_good {
        Some("has positions that do not increase".to_owned())
    } else if one.values.len() != count {
        Some(format!("has {} values at {count} points", one.values.len()))
    } else if !are_finite(&one.values) || !one.weight.is_finite() {
        Some("has a value that is not a number".to_owned())
    } else if one.factor.is_some_and(|factor| factor >= tables) {
        Some("is multiplied by one that does not exist".to_owned())
    } else {
        None
    }
}

fn grid(grid: &Grid) -> Option<String> {
    let nodes = grid.count.iter().try_fold(1_usize, |nodes, &count| nodes.checked_mul(count));
    if grid.count.iter().any(|&count| count < 2) {
        Some("has an axis with fewer than two nodes".to_owned())
    } else if !are_finite(&grid.start) || !grid.step.iter().all(|step| step.is_finite() && *step > 0.0) {
        Some("has positions that do not increase".to_owned())
    } else if nodes != Some(grid.values.len()) {
        Some(format!(
            "has {} values, but {} by {} by {} nodes",
            grid.values.len(),
            grid.count[0],
            grid.count[1],
            grid.count[2]
        ))
    } else if !are_finite(grid.values.iter().flatten()) {
        Some("has a value that is not a number".to_owned())
    } else {
        None
    }
}

fn errors(errors: &ErrorTables) -> Vec<String> {
    let mut faults = Vec::new();
    for one in &errors.axes {
        let axis = one.axis;
        if one.positions.is_empty() || !increase(&one.positions) {
            faults.push(format!("the errors of {axis} have positions that do not increase"));
        }
        if one.positions.len() != one.values.len() {
            faults.push(format!("the errors of {axis}: {} values at {} points", one.values.len(), one.positions.len()));
        }
        if !are_finite(one.values.iter().flatten()) {
            faults.push(format!("the errors of {axis} have a value that is not a number"));
        }
        if errors.axes.iter().filter(|other| other.axis == axis).count() > 1 {
            faults.push(format!("the errors of {axis} are given twice"));
        }
    }
    for (name, value) in &errors.location {
        if !value.is_finite() {
            faults.push(format!("{name} is not a number"));
        }
    }
    faults
}
