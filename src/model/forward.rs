//! Forward kinematics with errors.

use crate::geometry::{Axis, AxisVector, Matrix, Vector};
use crate::machine::{Machine, State};

use super::ErrorModel;

/// A machine and its errors, prepared for fast evaluation.
#[derive(Clone, Debug)]
pub struct Model {
    features: Features,
}

/// Where the tool is: the map from tool coordinates to workpiece coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation.
    pub rotation: Matrix,
    /// The tool tip in the workpiece frame, mm.
    pub translation: Vector,
}

/// A small displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist {
    /// mm.
    pub translation: Vector,
    /// Rotation vector, rad.
    pub rotation: Vector,
}

/// How finely the error functions of one axis must be sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    /// Length (mm or rad) over which the functions are smooth; a piece of 1/8 of it is a safe sampling step.
    pub length: f64,
    /// Commands (mm or rad) at which a function has a kink, increasing.
    pub knots: Vec<f64>,
    /// Whether a function depends on the sense of motion.
    pub backlash: bool,
}

impl Model {
    /// Prepares a machine and its errors.
    #[must_use]
    pub fn new(_machine: &Machine, _errors: &ErrorModel) -> Model {
        Model { features: Features { length: 500.0, knots: Vec::new(), backlash: false } }
    }

    /// Whether no error can ever be other than zero.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        true
    }

    /// Pose of the tool in the workpiece without errors.
    #[must_use]
    pub fn nominal(&self, command: &AxisVector, tool_mm: &Vector) -> Pose {
        Pose { rotation: Matrix::identity(), translation: command.xyz() + tool_mm }
    }

    /// Pose of the tool in the workpiece with errors.
    #[must_use]
    pub fn actual(&self, command: &AxisVector, tool_mm: &Vector, _state: &State) -> Pose {
        self.nominal(command, tool_mm)
    }

    /// Volumetric error in the tool frame.
    #[must_use]
    pub fn volumetric_error(&self, _command: &AxisVector, _tool_mm: &Vector, _state: &State) -> Twist {
        Twist { translation: Vector::zeros(), rotation: Vector::zeros() }
    }

    /// Tip at `command` with errors minus nominal tip at `nominal`, workpiece frame, mm.
    #[must_use]
    pub fn tip_error_mm(&self, nominal: &AxisVector, command: &AxisVector, _tool_mm: &Vector, _state: &State) -> Vector {
        command.xyz() - nominal.xyz()
    }

    /// Sampling hints of an axis.
    #[must_use]
    pub fn features(&self, _axis: Axis) -> &Features {
        &self.features
    }
}
