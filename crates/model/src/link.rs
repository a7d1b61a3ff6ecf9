//! One axis of the chain: its nominal motion and its errors, applied to a body.
//!
//! With the nominal location L (a translation to a point of the axis), the nominal motion M(q) and small displacements D:
//!
//! ```text
//! lever carried   L · D(e0) · M(q) · D(e(q)) · L⁻¹     (the chain of Esmaeili 2021, eq. 1–4)
//! lever fixed     L · D(e0) · D(e(q)) · M(q) · L⁻¹     (Spaan, eq. 2.7–2.9: the arm includes the axis's own motion)
//! ```
//!
//! D(e) first rotates by the exponential of (EA, EB, EC), then translates by (EX, EY, EZ). An error is always the deviation of the moving body, on the
//! workpiece side, too. There the inverse transform is applied on the way from F to the workpiece.

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::{AxisData, Lever, State};

use super::body::{BodyPlace, RigidBody};
use super::motion::Functions;
use super::name::Carrier;
use super::rotation::Rotation;

/// Small rigid displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Displacement {
    rotation: Rotation,
    translation: Vector,
}

impl Displacement {
    /// Creates a displacement from EX EY EZ (mm) and EA EB EC (rad).
    #[inline(always)]
    pub(super) fn new(components: &[f64; 6]) -> Displacement {
        let [x, y, z, a, b, c] = *components;
        Displacement { rotation: Rotation::from_vector(Vector::new(a, b, c)), translation: Vector::new(x, y, z) }
    }

    /// Returns `None` if all components are zero, so that nothing needs to be computed.
    pub(super) fn unless_zero(components: &[f64; 6]) -> Option<Displacement> {
        components.iter().any(|&component| component != 0.0).then(|| Displacement::new(components))
    }

    /// Returns a component by its index, EX EY EZ in mm, EA EB EC in rad.
    pub(super) fn component(&self, index: usize) -> f64 {
        if index < 3 { self.translation[index] } else { self.rotation.vector()[index % 3] }
    }

    #[inline(always)]
    pub(super) fn apply(&self, body: &mut impl RigidBody) {
        body.tilt(&self.rotation);
        body.translate(&self.translation);
    }

    #[inline(always)]
    fn undo(&self, body: &mut impl RigidBody) {
        body.translate(&-self.translation);
        body.tilt(&self.rotation.inverse());
    }
}

/// Axis with its errors, prepared for evaluation.
#[derive(Clone, Debug)]
pub(super) struct AxisLink {
    pub(super) axis: Axis,
    pub(super) direction: Vector,
    point_mm: Vector,
    lever: Lever,
    pub(super) location: Option<Displacement>,
    pub(super) functions: Functions,
}

impl AxisLink {
    pub(super) fn new(data: &AxisData, location: &[f64; 6], functions: Functions) -> AxisLink {
        AxisLink {
            axis: data.axis,
            direction: data.direction,
            point_mm: data.point_mm,
            lever: data.lever,
            location: Displacement::unless_zero(location),
            functions,
        }
    }

    /// True if the axis has no error that can ever differ from zero.
    pub(super) fn is_ideal(&self) -> bool {
        self.location.is_none() && self.functions.is_empty()
    }

    /// Carries a body on the tool side, from the body that the axis moves to the one that carries the axis.
    pub(super) fn carry<B: RigidBody>(&self, body: &mut B, command: &AxisVector, errors: Option<&State>) {
        let motion = self.motion_error(command, errors);
        body.translate(&-self.point_mm);
        if self.lever == Lever::Carried {
            body.visit(Carrier::Axis(self.axis), BodyPlace::Motion);
            if let Some(error) = &motion {
                error.apply(body);
            }
        }
        self.advance(body, command[self.axis]);
        body.moved(self.axis, &self.direction, 1.0);
        if self.lever == Lever::Fixed {
            body.visit(Carrier::Axis(self.axis), BodyPlace::Motion);
            if let Some(error) = &motion {
                error.apply(body);
            }
        }
        body.visit(Carrier::Axis(self.axis), BodyPlace::Location);
        if let (Some(error), Some(_)) = (&self.location, errors) {
            error.apply(body);
        }
        body.translate(&self.point_mm);
    }

    /// Carries a body on the workpiece side, from the body that carries the axis to the one that it moves: the inverse transform.
    pub(super) fn uncarry<B: RigidBody>(&self, body: &mut B, command: &AxisVector, errors: Option<&State>) {
        let motion = self.motion_error(command, errors);
        body.translate(&-self.point_mm);
        body.visit(Carrier::Axis(self.axis), BodyPlace::Location);
        if let (Some(error), Some(_)) = (&self.location, errors) {
            error.undo(body);
        }
        if self.lever == Lever::Fixed {
            body.visit(Carrier::Axis(self.axis), BodyPlace::Motion);
            if let Some(error) = &motion {
                error.undo(body);
            }
        }
        self.advance(body, -command[self.axis]);
        body.moved(self.axis, &self.direction, -1.0);
        if self.lever == Lever::Carried {
            body.visit(Carrier::Axis(self.axis), BodyPlace::Motion);
            if let Some(error) = &motion {
                error.undo(body);
            }
        }
        body.translate(&self.point_mm);
    }

    #[inline(always)]
    fn advance(&self, body: &mut impl RigidBody, by: f64) {
        if self.axis.is_rotary() {
            body.turn(&Rotation::about(self.direction, by));
        } else {
            body.translate(&(self.direction * by));
        }
    }

    #[inline(always)]
    pub(super) fn motion_error(&self, command: &AxisVector, errors: Option<&State>) -> Option<Displacement> {
        let state = errors.filter(|_| !self.functions.is_empty())?;
        Some(Displacement::new(&self.functions.evaluate(self.axis, command, state)))
    }
}
