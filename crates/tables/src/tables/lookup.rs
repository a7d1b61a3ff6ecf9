//! A compensation table of one axis: linear between its points, the end values outside (SINUMERIK 840D sl, Extended Functions K3 4.4).

use serde::Serialize;

use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::machine::State;

/// A function of one axis that corrects an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Lookup {
    /// The basic axis, whose position is looked up.
    pub input: Axis,
    /// The compensation axis, which is corrected.
    pub output: Axis,
    /// Positions of the points.
    pub nodes: Nodes,
    /// Values added to the command of the output at each point, mm or degrees; for the factor of a product, the value that the control multiplies.
    pub values: Vec<f64>,
    /// Direction of motion of the basic axis for which the table is valid.
    pub sense: Sense,
    /// `true` if the table is periodic: after the value at its end comes the one at its start.
    pub modulo: bool,
    /// Index of the table by which it is multiplied.
    pub factor: Option<usize>,
    /// Weight of the values.
    pub weight: f64,
    /// `true` if the control evaluates it.
    pub is_enabled: bool,
}

/// Positions of the points of a table, mm or degrees.
#[derive(Clone, Debug, PartialEq)]
pub enum Nodes {
    /// Equally spaced from a start. The last step may be shorter: the range need not be a multiple of the step.
    Even {
        /// First position.
        start: f64,
        /// Spacing.
        step: f64,
        /// Last position.
        end: f64,
    },
    /// Arbitrary, strictly increasing.
    At(Vec<f64>),
}

/// Directions of motion for which a table is valid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Sense {
    /// Both directions.
    #[default]
    #[serde(rename = "both")]
    Both,
    /// Towards larger positions.
    #[serde(rename = "+")]
    Positive,
    /// Towards smaller positions.
    #[serde(rename = "-")]
    Negative,
}

impl Sense {
    /// `both`, `+` or `-`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Sense::Both => "both",
            Sense::Positive => "+",
            Sense::Negative => "-",
        }
    }

    /// Weight of a table in a direction of motion; half for each if the direction is unknown.
    fn share(self, direction: i8) -> f64 {
        match (self, direction) {
            (Sense::Both, _) => 1.0,
            (_, 0) => 0.5,
            (Sense::Positive, 1) | (Sense::Negative, -1) => 1.0,
            _ => 0.0,
        }
    }
}

/// Number of whole steps in a range, ignoring a remainder due to rounding; limited to a number of points that fits in memory.
fn whole_steps(range: f64, step: f64) -> f64 {
    (range / step + 1e-9).floor().min(1e12)
}

impl Nodes {
    /// The number of points of a table with these nodes, from the start to the end.
    #[must_use]
    pub fn count(&self) -> usize {
        match self {
            Nodes::Even { start, step, end } if *step > 0.0 && end > start => {
                let whole = whole_steps(end - start, *step);
                // A remainder after the last whole step has a separate point at the end.
                let rest = (end - start) - whole * step > 1e-9 * step;
                whole as usize + 1 + usize::from(rest)
            }
            Nodes::Even { .. } => 1,
            Nodes::At(positions) => positions.len(),
        }
    }

    /// The position of a point.
    #[must_use]
    pub fn position(&self, index: usize) -> f64 {
        match self {
            Nodes::Even { start, step, end } => (start + step * index as f64).min(end.max(*start)),
            Nodes::At(positions) => positions.get(index).copied().unwrap_or(f64::NAN),
        }
    }

    /// First and last position.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        match self {
            Nodes::Even { start, end, .. } => [*start, *end],
            Nodes::At(positions) => {
                [positions.first().copied().unwrap_or(0.0), positions.last().copied().unwrap_or(0.0)]
            }
        }
    }

    /// The points around a position, and the fraction of the distance from the lower to the upper one.
    fn around(&self, position: f64) -> (usize, usize, f64) {
        let last = self.count().saturating_sub(1);
        let lower = match self {
            Nodes::Even { start, step, .. } if *step > 0.0 => ((position - start) / step).floor().max(0.0) as usize,
            Nodes::Even { .. } => 0,
            Nodes::At(positions) => positions.partition_point(|&one| one <= position).saturating_sub(1),
        };
        let lower = lower.min(last);
        let upper = (lower + 1).min(last);
        let (left, right) = (self.position(lower), self.position(upper));
        let share = if right > left { ((position - left) / (right - left)).clamp(0.0, 1.0) } else { 0.0 };
        (lower, upper, share)
    }
}

impl Lookup {
    /// An additive table for both directions.
    #[must_use]
    pub fn added(input: Axis, output: Axis, nodes: Nodes, values: Vec<f64>) -> Lookup {
        Lookup {
            input,
            output,
            nodes,
            values,
            sense: Sense::Both,
            modulo: false,
            factor: None,
            weight: 1.0,
            is_enabled: true,
        }
    }

    /// Its weighted value at a position of its axis, mm or degrees of the output.
    #[must_use]
    pub fn value(&self, position: f64) -> f64 {
        let [start, end] = self.nodes.range();
        let position =
            if self.modulo && end > start { start + (position - start).rem_euclid(end - start) } else { position };
        let (lower, upper, share) = self.nodes.around(position);
        let value = |index: usize| self.values.get(index).copied().unwrap_or(0.0);
        let low = value(lower);
        self.weight * if share == 0.0 { low } else { low + (value(upper) - low) * share }
    }

    /// The value at commands in mm and rad, for a direction of motion; 0 if the control does not evaluate it.
    #[must_use]
    pub fn at(&self, command: &AxisVector, state: &State) -> f64 {
        if !self.is_enabled {
            return 0.0;
        }
        let position = command[self.input];
        let position = if self.input.is_rotary() { position.to_degrees() } else { position };
        self.sense.share(state.direction(self.input)) * self.value(position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sag() -> Lookup {
        let nodes = Nodes::Even { start: -400.0, step: 200.0, end: 400.0 };
        Lookup::added(Axis::Y, Axis::Z, nodes, vec![0.0, 0.010, 0.012, 0.006, -0.004])
    }

    #[test]
    fn between_points_it_is_linear_and_outside_the_end_value_holds() {
        let sag = sag();
        for (position, value) in
            [(-500.0, 0.0), (-400.0, 0.0), (-300.0, 0.005), (100.0, 0.009), (350.0, -0.0015), (900.0, -0.004)]
        {
            assert!((sag.value(position) - value).abs() < 1e-15, "{position}: {}", sag.value(position));
        }
    }

    #[test]
    fn the_end_need_not_be_a_multiple_of_the_step() {
        let nodes = Nodes::Even { start: 0.0, step: 40.0, end: 100.0 };
        assert_eq!(nodes.count(), 4);
        let table = Lookup::added(Axis::X, Axis::X, nodes, vec![0.0, 4.0, 8.0, 10.0]);
        assert_eq!((table.value(60.0), table.value(90.0), table.value(200.0)), (6.0, 9.0, 10.0));
    }

    #[test]
    fn a_modulo_table_repeats() {
        let nodes = Nodes::Even { start: 0.0, step: 90.0, end: 360.0 };
        let mut table = Lookup::added(Axis::C, Axis::C, nodes, vec![0.0, 1.0, 2.0, 1.0, 0.0]);
        table.modulo = true;
        assert_eq!((table.value(405.0), table.value(-45.0), table.value(720.0)), (0.5, 0.5, 0.0));
    }

    #[test]
    fn a_table_of_one_sense_counts_half_where_the_sense_is_unknown() {
        let mut table = sag();
        table.sense = Sense::Positive;
        let mut command = AxisVector::default();
        command[Axis::Y] = -200.0;
        let mut state = State::default();
        assert_eq!(table.at(&command, &state), 0.005);
        state.direction[Axis::Y.slot()] = 1;
        assert_eq!(table.at(&command, &state), 0.010);
        state.direction[Axis::Y.slot()] = -1;
        assert_eq!(table.at(&command, &state), 0.0);
    }
}
