//! The kinds of compensation of ISO/TR 16907 that tables carry out, by their form alone (as Esmaeili 2021, 2.4.5.1, quotes them).
//!
//! | kind | corrects |
//! | --- | --- |
//! | L-POS | positioning of a linear axis along a line |
//! | L-STR | straightness: a linear axis is moved as a function of another one along a line |
//! | L-SQR | squareness, likewise |
//! | L-ANG | angular errors of linear axes: products of two positions |
//! | L-VOL | the tip in the whole volume: a grid, or error functions of linear axes |
//! | R-RAX | radial and axial errors of rotary axes: linear axes are moved as a function of a rotary one |
//! | R-ANG | position and orientation errors of rotary axes: products with a rotary position, or their error functions |
//! | FOR | direction of the tool: rotary axes are moved |

use super::{Lookup, Tables};

/// Names of the kinds, in the order of the table above.
#[must_use]
pub fn kinds(tables: &Tables) -> Vec<&'static str> {
    let lookups = || tables.lookups.iter();
    let factor = |one: &Lookup| one.factor.and_then(|factor| tables.lookups.get(factor));
    let added = |wanted: &dyn Fn(&Lookup) -> bool| lookups().any(|one| one.factor.is_none() && wanted(one));
    let multiplied = |wanted: &dyn Fn(&Lookup, &Lookup) -> bool| {
        lookups().any(|one| !one.output.is_rotary() && factor(one).is_some_and(|other| wanted(one, other)))
    };
    let error_axes = || tables.errors.iter().flat_map(|errors| errors.axes.iter().map(|one| one.axis));
    let moves_across = |one: &Lookup| !one.output.is_rotary() && !one.input.is_rotary() && one.input != one.output;
    let is_across = added(&moves_across);
    let has_matrix = tables.matrix.is_some();
    let all = [
        ("L-POS", has_matrix || added(&|one| !one.output.is_rotary() && one.input == one.output)),
        ("L-STR", is_across),
        ("L-SQR", is_across || has_matrix),
        ("L-ANG", multiplied(&|one, other| !one.input.is_rotary() && !other.input.is_rotary())),
        ("L-VOL", tables.grid.is_some() || error_axes().any(|axis| !axis.is_rotary())),
        ("R-RAX", added(&|one| !one.output.is_rotary() && one.input.is_rotary())),
        (
            "R-ANG",
            multiplied(&|one, other| one.input.is_rotary() || other.input.is_rotary())
                || error_axes().any(|axis| axis.is_rotary()),
        ),
        ("FOR", lookups().any(|one| one.output.is_rotary())),
    ];
    all.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::{Grid, Nodes};
    use ncfix_base::geometry::Axis;

    fn table(output: Axis, input: Axis, factor: Option<usize>) -> Lookup {
        let nodes = Nodes::Even { start: 0.0, step: 1.0, end: 1.0 };
        Lookup { factor, ..Lookup::added(input, output, nodes, vec![0.0, 0.01]) }
    }

    #[test]
    fn the_form_of_the_tables_decides() {
        let of = |lookups: Vec<Lookup>| kinds(&Tables { lookups, ..Tables::default() });
        assert_eq!(of(vec![table(Axis::X, Axis::X, None)]), ["L-POS"]);
        assert_eq!(of(vec![table(Axis::Y, Axis::X, None)]), ["L-STR", "L-SQR"]);
        assert_eq!(of(vec![table(Axis::X, Axis::C, None)]), ["R-RAX"]);
        assert_eq!(of(vec![table(Axis::A, Axis::X, None)]), ["FOR"]);
        assert_eq!(of(vec![table(Axis::X, Axis::Y, Some(1)), table(Axis::X, Axis::Z, Some(0))]), ["L-ANG"]);
        assert_eq!(of(vec![table(Axis::X, Axis::Y, Some(1)), table(Axis::X, Axis::A, Some(0))]), ["R-ANG"]);
        let grid = Grid {
            axes: [Axis::X, Axis::Y, Axis::Z],
            start: [0.0; 3],
            step: [1.0; 3],
            count: [2; 3],
            values: vec![[0.0; 3]; 8],
        };
        assert_eq!(kinds(&Tables { grid: Some(grid), ..Tables::default() }), ["L-VOL"]);
        assert_eq!(kinds(&Tables { matrix: Some([[1.0; 3]; 3]), ..Tables::default() }), ["L-POS", "L-SQR"]);
        assert!(kinds(&Tables::default()).is_empty());
    }
}
