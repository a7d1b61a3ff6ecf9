//! Lines through the working volume for the residual of a fixed step.
//!
//! The set is deterministic for a machine: lines along every axis at several positions of the others, including corners with the longest arms; the
//! diagonals of the volume; and lines between positions from a seeded generator.

use std::f64::consts::{PI, TAU};

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::{AxisData, Kinematics, Machine};

use super::steps::StraightLine;

/// Maximum number of corners for lines along an axis, and of diagonals.
const MOST_CORNERS: u64 = 16;
/// Number of positions within the volume for lines along an axis.
const PLACES: u32 = 12;
/// Number of lines in random directions.
const RANDOM_LINES: u32 = 64;
/// Seed of the generator; any number works.
const SEED: u64 = 0x5350_4141_4e20_3732;

/// The examined part of the travel: one turn of rotary axes with more travel.
struct Range {
    axis: Axis,
    low: f64,
    high: f64,
}

impl Range {
    fn of(data: &AxisData) -> Option<Range> {
        let axis = data.axis;
        let [low, high] = match data.travel {
            Some([low, high]) if axis.is_rotary() && high - low > TAU => {
                // Around zero if possible.
                let middle = f64::max(0.0, low + PI).min(high - PI);
                [middle - PI, middle + PI]
            }
            Some(travel) => travel,
            None if axis.is_rotary() => [-PI, PI],
            None => return None,
        };
        (low < high).then_some(Range { axis, low, high })
    }

    fn at(&self, fraction: f64) -> f64 {
        self.low + (self.high - self.low) * fraction
    }
}

/// Lines through the travel of all axes, for a tool vector. Linear axes without travel limits stay at 0; the result is empty if no axis has limits.
#[must_use]
pub fn volume(machine: &Machine, tool_mm: &Vector) -> Vec<StraightLine> {
    let ranges: Vec<Range> = machine.axes.iter().flatten().filter_map(Range::of).collect();
    let mut set = Set { ranges, kinematics: Kinematics::new(machine), tool_mm: *tool_mm, lines: Vec::new() };
    let mut random = Random(SEED);
    let count = set.ranges.len();
    for moving in 0..count {
        for corner in set.corners(&mut random) {
            set.along(moving, corner);
        }
        set.along(moving, vec![0.5; count]);
        for _ in 0..PLACES {
            let place = (0..count).map(|_| random.fraction()).collect();
            set.along(moving, place);
        }
    }
    if count > 1 {
        for corner in set.corners(&mut random) {
            let opposite = corner.iter().map(|fraction| 1.0 - fraction).collect();
            set.between(&corner, opposite);
        }
        set.linear_diagonals();
        for _ in 0..RANDOM_LINES {
            let start: Vec<f64> = (0..count).map(|_| random.fraction()).collect();
            let end = (0..count).map(|_| random.fraction()).collect();
            set.between(&start, end);
        }
    }
    set.lines
}

/// The lines so far.
struct Set {
    ranges: Vec<Range>,
    kinematics: Kinematics,
    tool_mm: Vector,
    lines: Vec<StraightLine>,
}

impl Set {
    /// Corners of the volume, none opposite to another: all, or the allowed number.
    fn corners(&self, random: &mut Random) -> Vec<Vec<f64>> {
        let free = self.ranges.len().saturating_sub(1);
        let all = 1_u64 << free;
        let chosen =
            (0..all.min(MOST_CORNERS)).map(|number| if all > MOST_CORNERS { random.next() % all } else { number });
        let fraction = |number: u64, bit: usize| if number >> bit & 1 == 1 { 1.0 } else { 0.0 };
        chosen.map(|number| (0..=free).map(|bit| fraction(number, bit)).collect()).collect()
    }

    /// A line along one axis, the others at a position. In a corner the last axis is at its low end; it swaps places with the moving one.
    fn along(&mut self, moving: usize, mut place: Vec<f64>) {
        if let Some(last) = place.len().checked_sub(1) {
            place.swap(moving, last);
        }
        let mut end = place.clone();
        for (fractions, fraction) in [(&mut place, 0.0), (&mut end, 1.0)] {
            if let Some(value) = fractions.get_mut(moving) {
                *value = fraction;
            }
        }
        self.between(&place, end);
    }

    /// The diagonals of the linear axes alone, rotary axes in the middle of their travel.
    fn linear_diagonals(&mut self) {
        if !self.ranges.iter().any(|range| range.axis.is_rotary()) {
            return;
        }
        for signs in 0..4_u32 {
            let fraction = |range: &Range, is_end: bool| {
                let is_high = range.axis.dimension() < 2 && signs >> range.axis.dimension() & 1 == 1;
                if range.axis.is_rotary() { 0.5 } else { f64::from(u8::from(is_high != is_end)) }
            };
            let start: Vec<f64> = self.ranges.iter().map(|range| fraction(range, false)).collect();
            let end = self.ranges.iter().map(|range| fraction(range, true)).collect();
            self.between(&start, end);
        }
    }

    fn between(&mut self, start: &[f64], end: Vec<f64>) {
        let place = |fractions: &[f64]| {
            let mut position = AxisVector::ZERO;
            for (range, &fraction) in self.ranges.iter().zip(fractions) {
                position[range.axis] = range.at(fraction);
            }
            position
        };
        let ends = [place(start), place(&end)];
        self.lines.push(StraightLine::new(ends, None, &self.kinematics, self.tool_mm, None));
    }
}

/// A small deterministic generator (`SplitMix64`).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number uniformly distributed between 0 and 1.
    fn fraction(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_four_diagonals_of_the_linear_axes_leave_a_table_in_the_middle() {
        let mut text = "[machine]\nname = \"test\"\ntopology = \"wCFXYZSt\"\n".to_owned();
        for (axis, direction) in [("X", "[1, 0, 0]"), ("Y", "[0, 1, 0]"), ("Z", "[0, 0, 1]")] {
            text += &format!("[axis.{axis}]\ndirection = {direction}\ntravel_mm = [-100, 100]\n");
        }
        text += "[axis.C]\ndirection = [0, 0, -1]\ntravel_deg = [-90, 90]\n";
        let source =
            ncfix_base::source::Source::new(ncfix_base::source::FileId(0), "m.toml", text.as_bytes().to_vec()).unwrap();
        let machine = ncfix_model::file::load(&source).0.unwrap().0;
        let ends = |line: &StraightLine| {
            let mut both = [line.start(), line.end()]
                .map(|at| [Axis::X, Axis::Y, Axis::Z, Axis::C].map(|axis| at[axis].round() as i64));
            both.sort_unstable();
            both
        };
        let is_it = |both: &[[i64; 4]; 2]| {
            (0..3).all(|k| both[0][k].abs() == 100 && both[0][k] == -both[1][k]) && both[0][3] == 0 && both[1][3] == 0
        };
        let mut found: Vec<_> = volume(&machine, &Vector::zeros()).iter().map(ends).filter(is_it).collect();
        found.sort_unstable();
        let of = |y: i64, z: i64| [[-100, y, z, 0], [100, -y, -z, 0]];
        assert_eq!(found, [of(-100, -100), of(-100, 100), of(100, -100), of(100, 100)]);
    }
}
