//! The part of the working volume for which tables are made and checked, and poses in it.

use std::f64::consts::{PI, TAU};

use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::machine::{AxisData, Machine, State};

/// Ranges of the axes, mm or rad.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    /// Axes with the lowest and highest command, in slot order.
    pub ranges: Vec<(Axis, [f64; 2])>,
    /// Axes whose range was set by the caller.
    chosen: Vec<Axis>,
}

impl Region {
    /// The travel of the axes. Modulo axes use a turn from zero, rotary axes with more than a turn a turn around zero.
    ///
    /// # Errors
    /// The linear axis that has no travel.
    pub fn travel(machine: &Machine) -> Result<Region, Axis> {
        let ranges = machine.axes.iter().flatten().map(|data| Ok((data.axis, range(data).ok_or(data.axis)?)));
        Ok(Region { ranges: ranges.collect::<Result<_, Axis>>()?, chosen: Vec::new() })
    }

    /// Sets the range of an axis, mm or rad.
    pub fn set(&mut self, axis: Axis, range: [f64; 2]) {
        if let Some(entry) = self.ranges.iter_mut().find(|(one, _)| *one == axis) {
            entry.1 = range;
            self.chosen.push(axis);
        }
    }

    /// The range of actual commands: the whole travel of rotary axes of which this holds a turn, and one more turn on either side for modulo axes.
    /// Tables that are not periodic are wrong there. Ranges set by the caller stay.
    #[must_use]
    pub fn reached(&self, machine: &Machine) -> Region {
        let mut region = self.clone();
        for (axis, range) in region.ranges.iter_mut().filter(|(axis, _)| !self.chosen.contains(axis)) {
            let Some(data) = machine.axis(*axis).filter(|data| data.axis.is_rotary()) else { continue };
            if range[1] - range[0] < TAU - 1e-9 {
                continue;
            }
            *range = match data.travel {
                Some([low, high]) => [low.min(range[0]), high.max(range[1])],
                None if data.modulo => [range[0] - TAU, range[1] + TAU],
                None => continue,
            };
        }
        region
    }

    /// The range of an axis; zero if the axis is not in the region.
    #[must_use]
    pub fn range(&self, axis: Axis) -> [f64; 2] {
        self.ranges.iter().find(|(one, _)| *one == axis).map_or([0.0; 2], |&(_, range)| range)
    }

    /// The axes that move in it.
    pub fn axes(&self) -> impl Iterator<Item = Axis> {
        self.ranges.iter().filter(|(_, [low, high])| high > low).map(|&(axis, _)| axis)
    }

    /// The middle of every range.
    #[must_use]
    pub fn middle(&self) -> AxisVector {
        let mut middle = AxisVector::default();
        self.ranges.iter().for_each(|&(axis, [low, high])| middle[axis] = f64::midpoint(low, high));
        middle
    }

    /// Uniformly distributed random poses, identical for the same seed.
    #[must_use]
    pub fn poses(&self, count: usize, seed: u64) -> Vec<AxisVector> {
        let mut random = Random(seed);
        let mut pose = || {
            let mut pose = AxisVector::default();
            for &(axis, [low, high]) in &self.ranges {
                pose[axis] = low + (high - low) * random.fraction();
            }
            pose
        };
        (0..count).map(|_| pose()).collect()
    }
}

/// The range of an axis, if it has one.
fn range(data: &AxisData) -> Option<[f64; 2]> {
    match data.travel {
        Some([low, high]) if data.axis.is_rotary() && high - low > TAU => {
            let middle = f64::max(0.0, low + PI).min(high - PI);
            Some([middle - PI, middle + PI])
        }
        Some(travel) => Some(travel),
        // As the error functions of a modulo axis, and the positions that its control shows.
        None if data.modulo => Some([0.0, TAU]),
        None if data.axis.is_rotary() => Some([-PI, PI]),
        None => None,
    }
}

/// Random combinations of directions of motion of some axes.
#[must_use]
pub fn senses(axes: &[Axis], count: usize, seed: u64) -> Vec<State> {
    let mut random = Random(seed);
    let mut state = || {
        let mut state = State::default();
        axes.iter().for_each(|axis| state.direction[axis.slot()] = if random.fraction() < 0.5 { -1 } else { 1 });
        state
    };
    (0..count).map(|_| state()).collect()
}

/// SplitMix64 (Steele, Lea & Flood 2014): a few lines give identical poses on every platform.
#[derive(Clone, Debug)]
struct Random(u64);

impl Random {
    fn fraction(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        (bits >> 11) as f64 / (1_u64 << 53) as f64
    }
}
