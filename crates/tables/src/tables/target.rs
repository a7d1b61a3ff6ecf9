//! The target correction of tables: that of the exact kinematics, with a tool direction that tables can represent.

use ncfix_base::geometry::{Axis, AxisVector, LINEAR_AXES, Matrix, ROTARY_AXES, Vector};
use ncfix_machine::machine::{Machine, State};
use ncfix_model::name::DIRECTIONS;
use ncfix_model::{ErrorName, Model, Solve, Twist};

/// Correction of the tool direction by the rotary axes. The tip is placed exactly in every case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Orientation {
    /// As much as possible without much roll of the tool: the least squares of tilt and roll, with a weight for the roll. A smooth function without
    /// poles, so that tables can represent it; some tilt remains if the tool is almost parallel to a rotary axis.
    #[default]
    Smooth,
    /// The pseudo-inverse of all six rows (Esmaeili 2021, eq. 37): the roll of the tool is corrected with the same weight as tilt, and more tilt
    /// remains. Its functions are trigonometric polynomials of low degree, on which the 23 tables of chapter 6 are based.
    SixRows,
    /// Full correction, as for programs: steep near a pole.
    Exact,
    /// No correction.
    Off,
}

/// Input of the target correction.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Its errors.
    pub model: &'a Model,
    /// From the gauge point to the tip, in F at the zero pose, mm.
    pub tool_mm: Vector,
    /// Correction of the tool direction.
    pub orientation: Orientation,
}

/// Weight of a roll in the least squares of [`Orientation::Smooth`], relative to tilt.
const ROLL_COST: f64 = 0.1;

/// Regularization that avoids a division by zero with three rotary axes, two of which may be parallel.
const RIDGE: f64 = 1e-9;

impl Target<'_> {
    /// Correction to add to the commands, mm and rad; `None` if the tip cannot be brought to its place.
    #[must_use]
    pub fn correction(&self, nominal: &AxisVector, state: &State) -> Option<AxisVector> {
        let mut start = *nominal;
        let mode = match self.orientation {
            Orientation::Exact => Solve::Full,
            Orientation::Off => Solve::PositionOnly,
            Orientation::Smooth | Orientation::SixRows => {
                let error = self.model.volumetric_error(nominal, &self.tool_mm, state);
                start = start + self.turned(nominal, &error.rotation);
                Solve::PositionOnly
            }
        };
        let solved = self.model.solve(nominal, &self.tool_mm, state, &start, mode).ok()?;
        Some(solved - *nominal)
    }

    /// The first-order correction per mm or rad of an error component: the linear inverse kinematics of its linear forward kinematics (Esmaeili 2021,
    /// eq. 48 and 51, with the missing sign). Not for [`Orientation::Exact`].
    #[must_use]
    pub fn first_order(&self, name: ErrorName, nominal: &AxisVector) -> Option<AxisVector> {
        let error = self.model.sensitivity(name, nominal, &self.tool_mm);
        let mut correction = AxisVector::default();
        if self.orientation != Orientation::Off {
            correction = self.turned(nominal, &error.rotation);
        }
        let mut left = error.translation;
        for axis in self.rotary() {
            left += self.column(axis, nominal).translation * correction[axis];
        }
        let mut columns = Matrix::identity();
        let mut axes = [None; 3];
        for axis in LINEAR_AXES.into_iter().filter(|&axis| self.machine.axis(axis).is_some()) {
            let slot = axis.dimension();
            if axes[slot].is_none() {
                axes[slot] = Some(axis);
                columns.set_column(slot, &self.column(axis, nominal).translation);
            }
        }
        let step = columns.try_inverse()? * left;
        axes.into_iter().zip(step.iter()).for_each(|(axis, step)| {
            if let Some(axis) = axis {
                correction[axis] = -step;
            }
        });
        Some(correction)
    }

    /// The rotary axes of the machine.
    pub(super) fn rotary(&self) -> impl Iterator<Item = Axis> {
        ROTARY_AXES.into_iter().filter(|&axis| self.machine.axis(axis).is_some())
    }

    /// Motion of the tool per mm or rad of a command, in the nominal tool frame.
    fn column(&self, axis: Axis, nominal: &AxisVector) -> Twist {
        let mut sum = Twist { translation: Vector::zeros(), rotation: Vector::zeros() };
        let Some(data) = self.machine.axis(axis) else { return sum };
        let kinds = if axis.is_rotary() { &DIRECTIONS[3..] } else { &DIRECTIONS[..3] };
        for (direction, along) in kinds.iter().zip(data.direction.iter()) {
            let part = self.model.sensitivity(ErrorName::motion(*direction, axis), nominal, &self.tool_mm);
            sum.translation += part.translation * *along;
            sum.rotation += part.rotation * *along;
        }
        sum
    }

    /// The rotary corrections that cancel a rotation of the tool in the least-squares sense, with weights for tilt and roll.
    fn turned(&self, nominal: &AxisVector, rotation: &Vector) -> AxisVector {
        let axis_of_tool = self.machine.spindle.axis;
        let tilt = |rotation: &Vector| rotation - axis_of_tool * axis_of_tool.dot(rotation);
        let is_smooth = self.orientation == Orientation::Smooth;
        let wanted = if is_smooth { tilt(rotation) } else { *rotation };
        // A roll with cost c has the weight √c.
        let weighed = |column: Vector| {
            if is_smooth {
                tilt(&column) + axis_of_tool * (axis_of_tool.dot(&column) * ROLL_COST.sqrt())
            } else {
                column
            }
        };
        let axes: Vec<Axis> = self.rotary().collect();
        let columns: Vec<Vector> = axes.iter().map(|&axis| weighed(self.column(axis, nominal).rotation)).collect();
        let mut gram = Matrix::identity();
        let mut right = Vector::zeros();
        for (i, one) in columns.iter().enumerate() {
            right[i] = -one.dot(&wanted);
            for (j, other) in columns.iter().enumerate() {
                gram[(i, j)] = one.dot(other) + if i == j { RIDGE } else { 0.0 };
            }
        }
        let mut correction = AxisVector::default();
        if let Some(inverse) = gram.try_inverse() {
            let step = inverse * right;
            axes.iter().zip(step.iter()).for_each(|(&axis, &step)| correction[axis] = step);
        }
        correction
    }
}
