//! The best set of each size among tables that were made: which of them are worth their place in a control with few (Esmaeili 2021, 9.2).
//!
//! To the first order, the error of the tip at a pose is e + Σ d over the tables of a set: e without tables, d the motion of the tip by a table, or by
//! two that are multiplied. The sum of the squares over the poses is then a quadratic form in the choice of the tables, which is cheap for every set.
//! With few tables, all sets are compared. With more, sets grow and shrink by a table and exchange one for another until no set of any size gets better.
//! The residual that is printed or compared with a tolerance is always that of the chosen set itself, as the control interpolates it.

use super::Task;
use crate::tables::check::CheckedPose;
use crate::tables::{Control, Tables};
use ncfix_base::geometry::{AXES, Axis, Vector};

/// Number of tables, or pairs that are multiplied, up to which all sets are compared: a million.
const MOST_COMPARED: u32 = 20;
/// Number of tables or pairs up to which sets are searched.
const MOST_GROUPS: usize = 128;
/// Largest number of rounds of the search among many tables.
const MOST_ROUNDS: usize = 60;
/// Steps of an axis that determine the motion of the tip, mm and rad.
const STEP: [f64; 2] = [0.01, 1e-5];

/// The best set with a number of tables.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BestSet {
    /// Number of tables.
    pub(super) count: usize,
    /// `true` for each table of the set.
    pub(super) kept: Vec<bool>,
    /// Root mean square of the tip error, to the first order, mm.
    pub(super) rms_mm: f64,
}

/// The best set of each size that occurs, in ascending order: from no table to all of them. Empty for other kinds of tables, or for a great many.
pub(super) fn best_sets(task: &Task<'_>, tables: &Tables, poses: &[CheckedPose]) -> Vec<BestSet> {
    let groups = groups(tables);
    if groups.is_empty() || groups.len() > MOST_GROUPS || poses.is_empty() {
        return Vec::new();
    }
    let squares = Squares::of(task, tables, &groups, poses);
    let sizes: Vec<usize> = groups.iter().map(Vec::len).collect();
    let best = if groups.len() <= MOST_COMPARED as usize { squares.all(&sizes) } else { squares.searched(&sizes) };
    let set = |(count, found): (usize, Option<(f64, u128)>)| {
        let (square, set) = found?;
        let mut kept = vec![false; tables.lookups.len()];
        let members = groups.iter().enumerate().filter(|(group, _)| (set >> group) & 1 == 1);
        members.flat_map(|(_, group)| group).for_each(|&index| kept[index] = true);
        Some(BestSet { count, kept, rms_mm: (square.max(0.0) / poses.len() as f64).sqrt() })
    };
    best.into_iter().enumerate().filter_map(set).collect()
}

/// The tables that only work together, by their indices: a table, or two that are multiplied.
fn groups(tables: &Tables) -> Vec<Vec<usize>> {
    let group = |(index, one): (usize, &crate::tables::Lookup)| match one.factor {
        Some(factor) if factor < index => None,
        Some(factor) => Some(vec![index, factor]),
        None => Some(vec![index]),
    };
    tables.lookups.iter().enumerate().filter_map(group).collect()
}

/// The kept tables, with renumbered factors.
pub(super) fn subset(tables: &Tables, kept: &[bool]) -> Tables {
    let number = |old: usize| kept.iter().take(old).filter(|&&is_kept| is_kept).count();
    let mut subset = tables.clone();
    let lookups = tables.lookups.iter().zip(kept).filter(|&(_, &is_kept)| is_kept).map(|(one, _)| one.clone());
    subset.lookups = lookups.collect();
    subset.lookups.iter_mut().for_each(|one| one.factor = one.factor.map(number));
    subset
}

/// The sum of the squared tip errors of any set, mm²: alone + Σ 2·linear + Σ Σ pairs.
#[derive(Debug)]
struct Squares {
    alone: f64,
    linear: Vec<f64>,
    pairs: Vec<Vec<f64>>,
}

/// A set during a search, with half the derivative of its square by the share of each group.
#[derive(Clone, Debug)]
struct SetWalk {
    set: u128,
    square: f64,
    slopes: Vec<f64>,
}

/// The smallest square of each size, with its set.
type Best = Vec<Option<(f64, u128)>>;

impl Squares {
    fn of(task: &Task<'_>, tables: &Tables, groups: &[Vec<usize>], poses: &[CheckedPose]) -> Squares {
        let count = groups.len();
        let mut sum = Squares { alone: 0.0, linear: vec![0.0; count], pairs: vec![vec![0.0; count]; count] };
        let one = |group: &Vec<usize>| {
            let kept: Vec<bool> = (0..tables.lookups.len()).map(|index| group.contains(&index)).collect();
            Control::new(task.target.machine, &subset(tables, &kept))
        };
        let controls: Vec<Control> = groups.iter().map(one).collect();
        let is_moved = |axis: &Axis| tables.lookups.iter().any(|lookup| lookup.output == *axis);
        let outputs: Vec<Axis> = AXES.into_iter().filter(is_moved).collect();
        let (model, tool_mm) = (task.target.model, &task.target.tool_mm);
        let mut moves = vec![Vector::zeros(); count];
        let mut columns = vec![Vector::zeros(); outputs.len()];
        for (pose, state) in poses {
            let error = model.tip_error_mm(pose, pose, tool_mm, state);
            for (column, &axis) in columns.iter_mut().zip(&outputs) {
                let step = STEP[usize::from(axis.is_rotary())];
                let mut beside = *pose;
                beside[axis] += step;
                *column = (model.tip_error_mm(pose, &beside, tool_mm, state) - error) / step;
            }
            for (motion, control) in moves.iter_mut().zip(&controls) {
                let correction = control.correction(pose, tool_mm, state);
                *motion = columns.iter().zip(&outputs).map(|(column, &axis)| column * correction[axis]).sum();
            }
            sum.alone += error.norm_squared();
            for (i, motion) in moves.iter().enumerate() {
                sum.linear[i] += motion.dot(&error);
                sum.pairs[i].iter_mut().zip(&moves).for_each(|(pair, other)| *pair += motion.dot(other));
            }
        }
        sum
    }

    fn empty(&self) -> SetWalk {
        SetWalk { set: 0, square: self.alone, slopes: self.linear.clone() }
    }

    /// The square with a group added to a set or taken from it.
    fn toggled(&self, walk: &SetWalk, group: usize) -> f64 {
        let is_in = (walk.set >> group) & 1 == 1;
        let sign = if is_in { -1.0 } else { 1.0 };
        walk.square + sign * 2.0 * walk.slopes[group] + self.pairs[group][group]
    }

    fn toggle(&self, walk: &mut SetWalk, group: usize) {
        let sign = if (walk.set >> group) & 1 == 1 { -1.0 } else { 1.0 };
        walk.square = self.toggled(walk, group);
        walk.set ^= 1 << group;
        walk.slopes.iter_mut().zip(&self.pairs[group]).for_each(|(slope, pair)| *slope += sign * pair);
    }

    fn walk_to(&self, set: u128) -> SetWalk {
        let mut walk = self.empty();
        (0..self.linear.len()).filter(|group| (set >> group) & 1 == 1).for_each(|group| self.toggle(&mut walk, group));
        walk
    }

    /// The best of all sets. Consecutive sets differ in one group (Gray 1953).
    fn all(&self, sizes: &[usize]) -> Best {
        let mut best: Best = vec![None; sizes.iter().sum::<usize>() + 1];
        let mut walk = self.empty();
        let mut size = 0;
        best[0] = Some((walk.square, 0));
        for step in 1_u32..1 << sizes.len().min(MOST_COMPARED as usize) {
            let group = step.trailing_zeros() as usize;
            self.toggle(&mut walk, group);
            if (walk.set >> group) & 1 == 1 {
                size += sizes[group]
            } else {
                size -= sizes[group]
            }
            note(&mut best, size, walk.square, walk.set);
        }
        // A million steps add up their rounding.
        best.iter_mut().flatten().for_each(|(square, set)| *square = self.walk_to(*set).square);
        best
    }

    /// Good sets of each size: from every known one, a group is added, taken away, or exchanged for another, until no size improves.
    fn searched(&self, sizes: &[usize]) -> Best {
        let count = sizes.len();
        let mut best: Best = vec![None; sizes.iter().sum::<usize>() + 1];
        let everything = if count >= 128 { u128::MAX } else { (1 << count) - 1 };
        for set in [0, everything] {
            let size = (0..count).filter(|group| (set >> group) & 1 == 1).map(|group| sizes[group]).sum::<usize>();
            best[size] = Some((self.walk_to(set).square, set));
        }
        let mut done: Best = vec![None; best.len()];
        for _ in 0..MOST_ROUNDS {
            // Once upward and once downward in a round: sets grow from nothing, and shrink from everything.
            for size in (0..best.len()).chain((0..best.len()).rev()) {
                let Some((_, set)) = best[size].filter(|_| best[size] != done[size]) else { continue };
                done[size] = best[size];
                let walk = self.walk_to(set);
                for group in 0..count {
                    let mut next = walk.clone();
                    self.toggle(&mut next, group);
                    let is_in = (next.set >> group) & 1 == 1;
                    let size = if is_in { size + sizes[group] } else { size - sizes[group] };
                    note(&mut best, size, next.square, next.set);
                    // An exchange is counted once: something leaves, then another enters.
                    for other in (0..count).filter(|other| !is_in && *other != group && (walk.set >> other) & 1 == 0) {
                        note(&mut best, size + sizes[other], self.toggled(&next, other), next.set ^ (1 << other));
                    }
                }
            }
            if best == done {
                break;
            }
        }
        best
    }
}

/// Keeps a set that is better than the known one of its size, by more than rounding.
fn note(best: &mut Best, size: usize, square: f64, set: u128) {
    let is_better = |(known, _): (f64, u128)| square < known - 1e-12 * known.abs();
    if best[size].is_none_or(is_better) {
        best[size] = Some((square, set));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five tables, of which two are a pair, on four places: the squares of all 16 sets, and of those that the search finds, by sums of vectors.
    #[test]
    fn the_best_set_of_each_size_is_that_of_all_sets() {
        let error = [5.0, -3.0, 2.0, 1.0];
        let moves = [[-5.0, 0.0, 0.0, 0.5], [0.0, 2.0, -1.0, 0.0], [-4.0, 3.0, -2.0, -1.0], [0.1, 1.0, -1.5, 0.0]];
        let dot = |one: &[f64; 4], other: &[f64; 4]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
        let squares = Squares {
            alone: dot(&error, &error),
            linear: moves.iter().map(|motion| dot(motion, &error)).collect(),
            pairs: moves.iter().map(|one| moves.iter().map(|other| dot(one, other)).collect()).collect(),
        };
        let sizes = [1, 1, 2, 1];
        let mut wanted = [f64::MAX; 6];
        for set in 0_u32..16 {
            let size: usize = (0..4).filter(|group| (set >> group) & 1 == 1).map(|group| sizes[group]).sum();
            let left = (0..4).map(|place| {
                let moved = (0..4).filter(|group| (set >> group) & 1 == 1).map(|group| moves[group][place]);
                (error[place] + moved.sum::<f64>()).powi(2)
            });
            wanted[size] = wanted[size].min(left.sum());
        }
        // By hand: without tables 25 + 9 + 4 + 1, with the first alone 0 + 9 + 4 + 2.25, with the pair 1 + 0 + 0 + 0.
        assert_eq!([wanted[0], wanted[1], wanted[2]], [39.0, 15.25, 1.0]);
        for best in [squares.all(&sizes), squares.searched(&sizes)] {
            for (found, wanted) in best.iter().zip(wanted) {
                assert!((found.unwrap().0 - wanted).abs() < 1e-9, "{found:?} {wanted}");
            }
        }
    }
}
