//! Capabilities and limits of a control.

use super::Format;
use crate::tables::{Lookup, Multiplication, Tables};

/// A kind of table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Functions of an axis that correct the same axis.
    Own,
    /// Functions of an axis that correct another one.
    Cross,
    /// Products of two functions.
    Products,
    /// Tables for one direction of motion that correct the same axis.
    Senses,
    /// Tables for one direction of motion that correct another axis.
    CrossSenses,
    /// Periodic tables.
    Repetition,
    /// A grid of corrections.
    Grid,
    /// Error functions for the control's own kinematics.
    Errors,
    /// Location errors in addition.
    Locations,
    /// A matrix.
    Matrix,
}

/// Limits of a control. Zero for no limit or an unknown one.
#[derive(Clone, Copy, Debug)]
pub struct FormatLimits {
    /// Number of tables.
    pub tables: usize,
    /// Number of values of a table, or of nodes along an axis of a grid.
    pub points: usize,
    /// Largest correction, mm.
    pub value_mm: f64,
    /// Smallest difference of two written values, mm.
    pub resolution_mm: f64,
    /// Limits of other kinds in words, which the format checks itself; else empty.
    pub further: &'static str,
}

/// Table kinds that the format does not support.
pub(super) fn kinds(format: &Format, tables: &Tables) -> Vec<String> {
    let lookups = &tables.lookups;
    let errors = tables.errors.as_ref();
    let has = [
        (Holds::Own, lookups.iter().any(|one| one.input == one.output), "tables of an axis that correct the same axis"),
        (Holds::Cross, lookups.iter().any(|one| one.input != one.output), "tables that correct another axis"),
        (Holds::Products, lookups.iter().any(|one| one.factor.is_some()), "products of tables"),
        (
            Holds::Senses,
            lookups.iter().any(|one| one.sense != crate::tables::Sense::Both),
            "tables for one direction of motion",
        ),
        (
            Holds::CrossSenses,
            lookups.iter().any(|one| one.sense != crate::tables::Sense::Both && one.input != one.output),
            "tables for one direction of motion that correct another axis",
        ),
        (Holds::Repetition, lookups.iter().any(|one| one.modulo), "tables that repeat"),
        (Holds::Grid, tables.grid.is_some(), "a grid of corrections"),
        (Holds::Errors, errors.is_some_and(|errors| !errors.axes.is_empty()), "error functions"),
        (Holds::Locations, errors.is_some_and(|errors| !errors.location.is_empty()), "location errors"),
        (Holds::Matrix, tables.matrix.is_some(), "a matrix"),
    ];
    let mut faults: Vec<String> = has
        .into_iter()
        .filter(|&(kind, is_there, _)| is_there && !format.can_hold(kind))
        .map(|(_, _, what)| format!("{} cannot hold {what}", format.title))
        .collect();
    if tables.multiplication == Multiplication::Beside && !format.can_hold(Holds::Products) {
        faults.push(format!("{} does not multiply tables", format.title));
    }
    faults
}

/// Limits of the control that are exceeded.
pub(super) fn exceeded(limits: &FormatLimits, tables: &Tables) -> Vec<String> {
    let mut faults = Vec::new();
    if limits.tables > 0 && tables.count() > limits.tables {
        faults.push(format!("{} tables are needed, but the control has {}", tables.count(), limits.tables));
    }
    let mut points = |what: String, count: usize| {
        if limits.points > 0 && count > limits.points {
            faults.push(format!("{what} has {count} points, but the control allows {}", limits.points));
        }
    };
    for (index, one) in tables.lookups.iter().enumerate() {
        points(format!("table {index} ({} over {})", one.output, one.input), one.nodes.count());
    }
    if let Some(grid) = &tables.grid {
        grid.axes.iter().zip(grid.count).for_each(|(axis, count)| points(format!("the grid along {axis}"), count));
    }
    if let Some(errors) = &tables.errors {
        errors.axes.iter().for_each(|one| points(format!("the table of {}", one.axis), one.positions.len()));
    }
    if let Some(matrix) = &tables.matrix {
        let apart = |row: usize, column: usize| (matrix[row][column] - f64::from(u8::from(row == column))).abs();
        let most = (0..9).map(|place| apart(place / 3, place % 3)).fold(0.0, f64::max);
        if most > MOST_SLOPE {
            let message = format!(
                "a factor of the matrix is off by {most:.4}; plausible errors of an axis are at most {MOST_MM} mm per meter"
            );
            faults.push(message);
        }
    }
    let [largest_mm, largest_deg] = largest(tables);
    if limits.value_mm > 0.0 && largest_mm > limits.value_mm {
        faults.push(format!("a value of {largest_mm:.4} mm; the control allows {} mm", limits.value_mm));
    } else if largest_mm > MOST_MM {
        faults.push(format!("a value of {largest_mm:.4} mm; plausible errors of an axis are at most {MOST_MM} mm"));
    }
    if largest_deg > MOST_DEG {
        faults.push(format!("a value of {largest_deg:.4} degrees; plausible errors of an axis are at most {MOST_DEG}"));
    }
    faults
}

/// Largest plausible correction of any axis, mm and degrees: a larger value has another unit, or is not a table.
const MOST_MM: f64 = 10.0;
const MOST_DEG: f64 = 5.0;
/// Largest plausible factor of a matrix: 10 mm in a meter.
const MOST_SLOPE: f64 = 0.01;

/// The largest values of additive tables, of a grid and of errors, mm and degrees; factors of products are excluded.
fn largest(tables: &Tables) -> [f64; 2] {
    let named: Vec<usize> = tables.lookups.iter().filter_map(|one| one.factor).collect();
    let is_factor = |index: usize| tables.lookups[index].factor.is_some() || named.contains(&index);
    let added = tables.lookups.iter().enumerate().filter(|&(index, _)| !is_factor(index));
    let most = |one: &Lookup| one.values.iter().map(|value| (value * one.weight).abs()).fold(0.0, f64::max);
    let (turned, moved): (Vec<_>, Vec<_>) = added.partition(|(_, one)| one.output.is_rotary());
    let of = |all: Vec<(usize, &Lookup)>| all.into_iter().map(|(_, one)| most(one)).fold(0.0, f64::max);
    let grid = tables.grid.iter().flat_map(|grid| grid.values.iter().flatten().map(|value| value.abs()));
    let functions = tables.errors.iter().flat_map(|errors| &errors.axes).flat_map(|one| &one.values);
    let functions = functions.flat_map(|row| row.iter().enumerate().map(|(index, value)| (index >= 3, value.abs())));
    let locations = tables.errors.iter().flat_map(|errors| &errors.location);
    let locations = locations.map(|(name, value)| (name.direction.is_rotation(), value.abs()));
    let (angles, lengths): (Vec<_>, Vec<_>) = functions.chain(locations).partition(|(is_rotation, _)| *is_rotation);
    let lengths = lengths.into_iter().map(|(_, value)| value);
    let angles = angles.into_iter().map(|(_, value)| value.to_degrees());
    [grid.chain(lengths).fold(of(moved), f64::max), angles.fold(of(turned), f64::max)]
}
