//! Step of the linear axes that brings the tip to its position.

use ncfix_base::geometry::{Axis, AxisSet, AxisVector, LINEAR_AXES, Matrix, Vector};

use super::body::Pointer;

/// Error if linear axes are parallel to each other, so that they cannot position the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Singular;

/// Axis that corrects each direction of space: X, else U, and so on.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinearAxes(pub(super) [Option<Axis>; 3]);

impl LinearAxes {
    /// Returns the correcting axes of a machine with these axes.
    pub(super) fn of(axes: AxisSet) -> LinearAxes {
        let mut linear = [None; 3];
        for axis in LINEAR_AXES.into_iter().filter(|&axis| axes.contains(axis)) {
            linear[axis.dimension()].get_or_insert(axis);
        }
        LinearAxes(linear)
    }

    /// Returns the existing axes.
    pub(super) fn axes(&self) -> impl Iterator<Item = Axis> {
        self.0.into_iter().flatten()
    }

    /// Returns the derivatives of the tip by their commands; zero if there is no axis.
    pub(super) fn columns(&self, pointer: &Pointer) -> [Vector; 3] {
        self.0.map(|axis| axis.map_or(Vector::zeros(), |axis| pointer.tip_by_command[axis.slot()]))
    }
}

/// Step of the linear axes that removes a residual; the least-squares step if there are fewer than three.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinearStep {
    axes: [Option<Axis>; 3],
    columns: Matrix,
    inverse: Matrix,
}

impl LinearStep {
    /// Creates the step from the derivatives of the tip by each linear command; zero if the machine has no axis.
    pub(super) fn new(linear: &LinearAxes, columns: [Vector; 3]) -> Result<LinearStep, Singular> {
        let filled = fill(&linear.0, columns);
        // The adjugate: its rows are the cross products of the columns.
        let rows = [filled[1].cross(&filled[2]), filled[2].cross(&filled[0]), filled[0].cross(&filled[1])];
        let determinant = rows[0].dot(&filled[0]);
        // Axes that have become parallel, such as X and Y after a rotary axis, cannot position the tip.
        if determinant.is_nan() || determinant.abs() < 1e-6 {
            return Err(Singular);
        }
        let inverse = Matrix::from_columns(&rows.map(|row| row / determinant)).transpose();
        Ok(LinearStep { axes: linear.0, columns: Matrix::from_columns(&columns), inverse })
    }

    /// Returns the part of a residual that the axes can remove, mm.
    pub(super) fn reachable(&self, residual: &Vector) -> Vector {
        if self.axes.iter().all(Option::is_some) { *residual } else { self.columns * (self.inverse * residual) }
    }

    /// Removes a residual, mm.
    #[inline]
    pub(super) fn apply(&self, residual: &Vector, command: &mut AxisVector) {
        let step = self.inverse * residual;
        for (axis, step) in self.axes.iter().zip(step.iter()) {
            if let Some(axis) = axis {
                command[*axis] += step;
            }
        }
    }
}

/// Replaces missing columns by unit vectors perpendicular to the others; the rows of the inverse that belong to the others are then those of the
/// pseudo-inverse.
fn fill(axes: &[Option<Axis>; 3], mut columns: [Vector; 3]) -> [Vector; 3] {
    let missing: [bool; 3] = axes.map(|axis| axis.is_none());
    match missing.iter().filter(|&&missing| missing).count() {
        0 => columns,
        1 => {
            let hole = missing.iter().position(|&missing| missing).unwrap_or(0);
            let normal = columns[(hole + 1) % 3].cross(&columns[(hole + 2) % 3]);
            columns[hole] = normal.try_normalize(1e-9).unwrap_or_default();
            columns
        }
        2 => {
            let only = missing.iter().position(|&missing| !missing).unwrap_or(0);
            let helper = Vector::ith(columns[only].iamin(), 1.0);
            columns[(only + 1) % 3] = columns[only].cross(&helper).try_normalize(1e-9).unwrap_or_default();
            columns[(only + 2) % 3] =
                columns[only].cross(&columns[(only + 1) % 3]).try_normalize(1e-9).unwrap_or_default();
            columns
        }
        _ => [Vector::x(), Vector::y(), Vector::z()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_linear_axes_leave_the_least_squares_step() {
        let linear = LinearAxes([Some(Axis::X), None, Some(Axis::Z)]);
        let columns = [Vector::new(1.0, 0.2, 0.0), Vector::zeros(), Vector::new(0.0, 0.0, -1.0)];
        let step = LinearStep::new(&linear, columns).unwrap();
        let mut command = AxisVector::ZERO;
        step.apply(&Vector::new(1.0, 1.0, 1.0), &mut command);
        // Projection on (1, 0.2, 0): 1.2 / 1.04.
        assert!((command[Axis::X] - 1.2 / 1.04).abs() < 1e-15);
        assert_eq!((command[Axis::Y], command[Axis::Z]), (0.0, -1.0));
        let single = LinearAxes([None, Some(Axis::V), None]);
        let step = LinearStep::new(&single, [Vector::zeros(), Vector::new(0.6, 0.8, 0.0), Vector::zeros()]).unwrap();
        let reachable = step.reachable(&Vector::new(0.6, 0.8, 5.0));
        assert!((reachable - Vector::new(0.6, 0.8, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn parallel_linear_axes_are_refused() {
        let linear = LinearAxes([Some(Axis::X), Some(Axis::Y), Some(Axis::Z)]);
        assert!(LinearStep::new(&linear, [Vector::x(), Vector::x(), Vector::z()]).is_err());
        assert!(LinearStep::new(&linear, [Vector::x(), Vector::repeat(f64::NAN), Vector::z()]).is_err());
    }
}
