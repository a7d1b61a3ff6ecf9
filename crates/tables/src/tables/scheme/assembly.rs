//! Converts functions of one axis, and products of two, to numbered tables.

use std::collections::BTreeMap;

use super::{Holds, Task};
use crate::tables::format::rounded;
use crate::tables::region::Region;
use crate::tables::{Lookup, Multiplication, Nodes, Tables};
use ncfix_base::geometry::Axis;

/// Decimals of positions, mm or degrees.
const POSITION_DECIMALS: usize = 6;
/// Size below which a function is zero everywhere: a tenth of a nanometer, mm or rad.
const NOTHING: f64 = 1e-7;

/// Largest difference of ends that is fit noise, mm or degrees.
const ENDS: f64 = 1e-5;

/// Functions to be converted to tables; values in mm or rad of the output.
pub(super) struct Assembly<'a> {
    task: &'a Task<'a>,
    /// Corrections of an output as a function of the position of an input.
    added: BTreeMap<(Axis, Axis), Vec<f64>>,
    constants: BTreeMap<Axis, f64>,
    products: Vec<Product>,
}

/// The product of two functions.
struct Product {
    output: Axis,
    sides: [AxisFunction; 2],
}

/// A function of one axis at its nodes.
pub(super) struct AxisFunction {
    pub(super) axis: Axis,
    /// Two values make a straight line.
    pub(super) values: Vec<f64>,
}

/// Equal steps within a range, mm or rad, with decimals that a file can store: the nodes in mm or degrees. The first and the last node are never beyond
/// the range, so that a table says nothing about positions that were not asked for; at the end, up to a millionth per step is without a node.
pub(super) fn nodes(axis: Axis, [low, high]: [f64; 2], points: usize) -> Nodes {
    let unit = |value: f64| if axis.is_rotary() { value.to_degrees() } else { value };
    let steps = points.max(2) - 1;
    let start = inner(unit(low), f64::ceil);
    let step = inner((inner(unit(high), f64::floor) - start) / steps as f64, f64::floor);
    Nodes::Even { start, step, end: rounded(start + step * steps as f64, POSITION_DECIMALS) }
}

/// The nearest value with the decimals of positions on one side; a value that has these decimals, except for the noise of a conversion, stays.
fn inner(value: f64, side: fn(f64) -> f64) -> f64 {
    let near = rounded(value, POSITION_DECIMALS);
    let unit = 0.1_f64.powi(i32::try_from(POSITION_DECIMALS).unwrap_or(0));
    if (value - near).abs() < 1e-3 * unit { near } else { rounded(side(value / unit) * unit, POSITION_DECIMALS) }
}

/// The positions of nodes, mm or rad.
pub(super) fn positions(axis: Axis, region: &Region, points: usize) -> Vec<f64> {
    let nodes = nodes(axis, region.range(axis), points);
    let unit = |value: f64| if axis.is_rotary() { value.to_radians() } else { value };
    (0..nodes.count()).map(|index| unit(nodes.position(index))).collect()
}

impl<'a> Assembly<'a> {
    pub(super) fn new(task: &'a Task<'a>) -> Assembly<'a> {
        Assembly { task, added: BTreeMap::new(), constants: BTreeMap::new(), products: Vec::new() }
    }

    /// Positions of the nodes of an axis, mm or rad.
    pub(super) fn positions(&self, axis: Axis) -> Vec<f64> {
        positions(axis, self.task.region, self.task.points)
    }

    /// Adds a constant.
    pub(super) fn add_constant(&mut self, output: Axis, value: f64) {
        *self.constants.entry(output).or_default() += value;
    }

    /// Adds a function of an axis, at its nodes.
    pub(super) fn add(&mut self, output: Axis, input: Axis, values: &[f64]) {
        let sum = self.added.entry((output, input)).or_insert_with(|| vec![0.0; values.len()]);
        sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
    }

    /// Adds the product of two functions.
    pub(super) fn add_product(&mut self, output: Axis, sides: [AxisFunction; 2]) {
        self.products.push(Product { output, sides });
    }

    /// The tables. A product is written as two tables that name each other, each with half of it. The result is then independent of whether a control
    /// adds a table that only serves as a factor.
    pub(super) fn finish(mut self) -> Tables {
        let mut products = Vec::new();
        for product in std::mem::take(&mut self.products) {
            products.extend(self.balanced(product));
        }
        self.spread_constants();
        let mut tables = Tables { multiplication: self.task.multiplication, ..Tables::default() };
        for ((output, input), values) in &self.added {
            if largest(values) > NOTHING {
                tables.lookups.push(self.lookup(*output, *input, values));
            }
        }
        for pair in products {
            let first = tables.lookups.len();
            for (index, mut lookup) in pair.into_iter().enumerate() {
                lookup.factor = Some(first + 1 - index);
                tables.lookups.push(lookup);
            }
        }
        tables
    }

    /// The two tables of a product, balanced in size; `None` for a zero product.
    fn balanced(&mut self, product: Product) -> Option<[Lookup; 2]> {
        let [one, other] = product.sides.map(|side| {
            let mut lookup = self.lookup(product.output, side.axis, &side.values);
            // A product of degrees is not in degrees: the conversion of the output applies once.
            if product.output.is_rotary() {
                lookup.values = side.values.clone();
            }
            lookup
        });
        let unit = if product.output.is_rotary() { 1_f64.to_degrees() } else { 1.0 };
        let sizes = [largest(&one.values), largest(&other.values)];
        let size = sizes[0] * sizes[1];
        if size < NOTHING || !size.is_finite() {
            return None;
        }
        // Two tables that each add half of the product.
        let common = (0.5 * unit * size).sqrt();
        let mut pair = [one, other];
        for (lookup, size) in pair.iter_mut().zip(sizes) {
            lookup.values.iter_mut().for_each(|value| *value *= common / size);
        }
        if self.task.multiplication == Multiplication::Beside {
            // The values that the control adds of each table alone are subtracted again.
            for lookup in &pair {
                let alone: Vec<f64> = self.positions(lookup.input).iter().map(|&at| -at_position(lookup, at)).collect();
                self.add(product.output, lookup.input, &alone);
            }
        }
        Some(pair)
    }

    /// A table of values in mm or rad.
    fn lookup(&self, output: Axis, input: Axis, values: &[f64]) -> Lookup {
        let range = self.task.region.range(input);
        let unit = |value: f64| if output.is_rotary() { value.to_degrees() } else { value };
        let values: Vec<f64> = values.iter().map(|&value| unit(value)).collect();
        let mut lookup = Lookup::added(input, output, nodes(input, range, values.len()), values);
        repeat(self.task, &mut lookup);
        lookup
    }

    /// Adds constants to an existing table, or to one of the output itself.
    fn spread_constants(&mut self) {
        for (output, value) in std::mem::take(&mut self.constants) {
            if value.abs() < NOTHING {
                continue;
            }
            let is_used = |values: &Vec<f64>| largest(values) > NOTHING;
            let there = self.added.iter().find(|&(&(one, _), values)| one == output && is_used(values));
            let input = there.map(|(&(_, input), _)| input);
            let own = self.task.region.axes().any(|axis| axis == output);
            let input = input.or(own.then_some(output)).or_else(|| self.task.region.axes().next());
            let Some(input) = input else { continue };
            let count = self.added.get(&(output, input)).map_or(2, Vec::len);
            self.add(output, input, &vec![value; count]);
        }
    }
}

/// Makes the table of a rotary axis with more than a turn periodic, if it covers a turn and ends at its initial value. Both ends of a modulo axis are
/// the same position: a difference is fit noise, or beyond its terms, so their mean is used for both. An axis with a longer travel may have errors
/// that are not periodic.
pub(super) fn repeat(task: &Task<'_>, lookup: &mut Lookup) {
    let Some(data) = task.target.machine.axis(lookup.input).filter(|data| data.axis.is_rotary()) else { return };
    let is_endless = data.modulo;
    let turns = is_endless || data.travel.is_none_or(|[low, high]| high - low > std::f64::consts::TAU + 1e-9);
    let [start, end] = lookup.nodes.range();
    let (Some(&first), Some(&last)) = (lookup.values.first(), lookup.values.last()) else { return };
    // The last node may be a millionth per step before the turn.
    let is_turn = turns && (end - start - 360.0).abs() < f64::max(1e-3, 2e-6 * lookup.values.len() as f64);
    let is_same = (first - last).abs() <= f64::max(1e-3 * largest(&lookup.values), ENDS);
    if is_turn && (is_endless || is_same) && task.format.can_hold(Holds::Repetition) {
        lookup.modulo = true;
        let both = f64::midpoint(first, last);
        let count = lookup.values.len();
        lookup.values[0] = both;
        lookup.values[count - 1] = both;
    }
}

/// The value of a table at a position in mm or rad, mm or rad.
fn at_position(lookup: &Lookup, at: f64) -> f64 {
    let value = lookup.value(if lookup.input.is_rotary() { at.to_degrees() } else { at });
    if lookup.output.is_rotary() { value.to_radians() } else { value }
}

/// The largest magnitude.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}
