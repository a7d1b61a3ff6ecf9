//! The residual error of tables over the volume, with the interpolation of the control, compared to the exact correction.

use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::State;
use ncfix_model::Solve;

use super::region::senses;
use super::target::Target;
use super::{Control, Orientation};
use ncfix_base::geometry::{AXES, Axis};
use ncfix_machine::machine::ActiveCompensation as _;

/// A pose and the directions in which the axes reached it.
pub type CheckedPose = (AxisVector, State);

/// Seed of the generator of directions.
const SEED: u64 = 0x53_454e_5345;

/// Errors at poses: of the tip in mm and of the direction of the tool in rad.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// Distance of the tip from its nominal place, mm.
    pub tip_mm: Vec<f64>,
    /// Angle of the tool axis to its nominal direction, rad.
    pub tilt_rad: Vec<f64>,
    /// Sum of the tip errors as vectors, mm.
    sum_mm: Vector,
}

/// Errors without correction, with tables, and with the exact correction for the same orientation option and kinematics.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Without correction.
    pub before: Errors,
    /// With the tables as written.
    pub tables: Errors,
    /// With the correction that programs get.
    pub exact: Errors,
    /// The pose with the largest tip error under the tables.
    pub worst: AxisVector,
    /// Axes with direction-dependent errors; every pose is reached in both directions of them.
    pub senses: Vec<Axis>,
}

/// Poses, each reached in a random combination of directions of some axes and in the opposite one; without such axes once, in the mean state.
#[must_use]
pub fn stands(poses: &[AxisVector], axes: &[Axis]) -> Vec<CheckedPose> {
    if axes.is_empty() {
        return poses.iter().map(|pose| (*pose, State::default())).collect();
    }
    let all = poses.iter().zip(senses(axes, poses.len(), SEED));
    all.flat_map(|(pose, one)| {
        let other = State { direction: one.direction.map(|sense| -sense), ..one };
        [(*pose, one), (*pose, other)]
    })
    .collect()
}

impl Errors {
    fn push(&mut self, target: &Target<'_>, (nominal, state): &CheckedPose, command: &AxisVector) {
        let tip = target.model.tip_error_mm(nominal, command, &target.tool_mm, state);
        self.tip_mm.push(tip.norm());
        self.sum_mm += tip;
        let axis = target.machine.spindle.axis;
        let wanted = target.model.nominal(nominal, &target.tool_mm).rotation * axis;
        let found = target.model.actual(command, &target.tool_mm, state).rotation * axis;
        self.tilt_rad.push(wanted.cross(&found).norm());
    }

    /// Root mean square of the tip error, mm.
    #[must_use]
    pub fn rms_mm(&self) -> f64 {
        rms(&self.tip_mm)
    }

    /// Mean tip error, mm.
    #[must_use]
    pub fn mean_mm(&self) -> f64 {
        self.tip_mm.iter().sum::<f64>() / self.tip_mm.len().max(1) as f64
    }

    /// Mean of the tip errors as vectors, mm: the part that a newly touched zero takes away on a machine without rotary axes.
    #[must_use]
    pub fn shift_mm(&self) -> Vector {
        self.sum_mm / self.tip_mm.len().max(1) as f64
    }

    /// Root mean square of the tip error about its mean vector, mm.
    #[must_use]
    pub fn about_shift_mm(&self) -> f64 {
        (self.rms_mm().powi(2) - self.shift_mm().norm_squared()).max(0.0).sqrt()
    }

    /// Largest tip error, mm.
    #[must_use]
    pub fn max_mm(&self) -> f64 {
        self.tip_mm.iter().copied().fold(0.0, f64::max)
    }

    /// Root mean square of the tilt, rad.
    #[must_use]
    pub fn rms_rad(&self) -> f64 {
        rms(&self.tilt_rad)
    }

    /// Largest tilt, rad.
    #[must_use]
    pub fn max_rad(&self) -> f64 {
        self.tilt_rad.iter().copied().fold(0.0, f64::max)
    }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Residual errors of a control with tables at poses.
#[must_use]
pub fn left(target: &Target<'_>, control: &Control, poses: &[CheckedPose]) -> Errors {
    let mut errors = Errors::default();
    for stand in poses {
        let (pose, state) = stand;
        let command = *pose + control.correction(pose, &target.tool_mm, state);
        errors.push(target, stand, &command);
    }
    errors
}

/// Compares no correction, tables and the exact correction at poses, in both directions of the axes with direction-dependent errors.
#[must_use]
pub fn check(target: &Target<'_>, control: &Control, poses: &[AxisVector]) -> Check {
    let (mut before, mut exact) = (Errors::default(), Errors::default());
    let counts = |axis: &Axis| {
        target.machine.axis(*axis).is_some() && (target.model.features(*axis).backlash || control.has_senses(*axis))
    };
    let axes: Vec<Axis> = AXES.into_iter().filter(counts).collect();
    let stands = stands(poses, &axes);
    let mode = if target.orientation == Orientation::Off { Solve::PositionOnly } else { Solve::Full };
    for stand in &stands {
        let (pose, state) = stand;
        before.push(target, stand, pose);
        let solved = target.model.solve(pose, &target.tool_mm, state, pose, mode);
        exact.push(target, stand, &solved.unwrap_or(*pose));
    }
    let tables = left(target, control, &stands);
    let order = |(_, one): &(usize, &f64), (_, other): &(usize, &f64)| one.total_cmp(other);
    let worst = tables.tip_mm.iter().enumerate().max_by(order).and_then(|(index, _)| stands.get(index));
    let worst = worst.map(|(pose, _)| *pose).unwrap_or_default();
    Check { before, tables, exact, worst, senses: axes }
}
