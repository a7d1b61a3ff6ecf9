//! Shares of the linear axes, the rotary axes and the spindle in the tip error over the travel (Lei and Hsu 2003, ch. 5: the rotary axes of their
//! machine cause up to 80 % of it, the linear axes less than 20 %).
//!
//! Every group is computed alone, at poses that cover the travel evenly; its share is its mean error over the sum of those of all groups.

use crate::ErrorModel;
use crate::accumulator::Accumulator;
use crate::forward::Model;
use crate::name::{Carrier, ErrorName};
use crate::source::Effect;
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::units::um_from_mm;
use ncfix_machine::machine::{ActiveTables, Condition, Machine, State};
use std::f64::consts::PI;

/// Number of poses.
const POSES: usize = 500;

/// Mean tip error of a group over the travel.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupShare {
    /// Name of the group.
    pub name: &'static str,
    /// Its axes.
    pub axes: Vec<Axis>,
    /// Mean distance of the tip from its place by the errors of this group alone, µm.
    pub mean_um: f64,
    /// Its share in the sum of all groups, 0 to 1.
    pub share: f64,
}

/// The carrier of an error, as far as its label is the name of a component.
fn carrier(effect: &dyn Effect) -> Option<Carrier> {
    effect.label().parse::<ErrorName>().ok().map(|name| name.carrier)
}

/// Shares of the groups with errors, the largest first, in the reference condition. Empty if a linear axis has no travel, or if there are no errors.
#[must_use]
pub fn volume_shares(machine: &Machine, errors: &ErrorModel, tool_mm: &Vector) -> Vec<GroupShare> {
    let Some(poses) = poses(machine) else { return Vec::new() };
    let bare = Machine { active_tables: ActiveTables::default(), ..machine.clone() };
    let axes = |is_rotary: bool| -> Vec<Axis> {
        machine.axes.iter().flatten().map(|data| data.axis).filter(|axis| axis.is_rotary() == is_rotary).collect()
    };
    let of_axes = |effect: &dyn Effect, is_rotary: bool| matches!(carrier(effect), Some(Carrier::Axis(axis)) if axis.is_rotary() == is_rotary);
    let mean_um = |wanted: &dyn Fn(&dyn Effect) -> bool| {
        let model = Model::summed(&Accumulator::sum(&bare, errors, &Condition::default(), wanted));
        let distance = |pose: &AxisVector| model.deviation(pose, tool_mm, &State::default()).translation.norm();
        um_from_mm(poses.iter().map(distance).sum::<f64>() / poses.len() as f64)
    };
    let mut groups = vec![
        ("linear axes", axes(false), mean_um(&|effect| of_axes(effect, false))),
        ("rotary axes", axes(true), mean_um(&|effect| of_axes(effect, true))),
        ("spindle", Vec::new(), mean_um(&|effect| carrier(effect) == Some(Carrier::Spindle))),
        ("others", Vec::new(), mean_um(&|effect| carrier(effect).is_none())),
    ];
    groups.retain(|(_, _, mean_um)| *mean_um > 0.0);
    groups.sort_by(|(_, _, one), (_, _, other)| other.total_cmp(one));
    let sum: f64 = groups.iter().map(|(_, _, mean_um)| mean_um).sum();
    let share = |(name, axes, mean_um)| GroupShare { name, axes, mean_um, share: mean_um / sum };
    groups.into_iter().map(share).collect()
}

/// Poses that cover the travel evenly: multiples of irrational numbers, without their whole parts. A rotary axis without travel makes a turn.
fn poses(machine: &Machine) -> Option<Vec<AxisVector>> {
    const PRIMES: [f64; 9] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0];
    let mut ranges = Vec::new();
    for data in machine.axes.iter().flatten() {
        ranges.push((data.axis, data.travel.or(data.axis.is_rotary().then_some([-PI, PI]))?));
    }
    let pose = |number: usize| {
        let mut pose = AxisVector::default();
        for ((axis, [low, high]), prime) in ranges.iter().zip(PRIMES) {
            pose[*axis] = low + (high - low) * ((number as f64 + 0.5) * prime.sqrt()).fract();
        }
        pose
    };
    Some((0..POSES).map(pose).collect())
}
