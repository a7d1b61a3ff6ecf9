//! The pole and the polar position.

use crate::exec::core::fault::Fault;
use crate::exec::core::fault::fault;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Plane;
use ncfix_base::source::Span;
/// Pole, and polar values programmed about it, in plane coordinates of the program (mm, rad).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Polar {
    pub(super) pole: [f64; 2],
    /// The plane of pole, radius and angle.
    pub(super) plane: Option<Plane>,
    pub(super) radius: Option<f64>,
    pub(super) angle_rad: Option<f64>,
}

/// Reference of a pole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PoleBase {
    /// `G110`: the last position.
    Position,
    /// `G111`: the workpiece zero.
    Zero,
    /// `G112`: the last pole.
    Pole,
}

impl PoleBase {
    /// The base of a G code.
    pub(super) fn of(code: &str) -> Option<PoleBase> {
        Some(match code {
            "G110" => PoleBase::Position,
            "G111" => PoleBase::Zero,
            "G112" => PoleBase::Pole,
            _ => return None,
        })
    }
}

impl Polar {
    /// The pole; the workpiece zero until one is programmed.
    pub(super) fn pole(&self, plane: Plane, span: Span) -> Result<[f64; 2], Fault> {
        match self.plane {
            None => Ok([0.0; 2]),
            Some(own) if own == plane => Ok(self.pole),
            Some(_) => {
                let message = "the plane was changed after the pole";
                Err(fault(Code::BAD_POLAR, span, message, "program the pole in this plane with G110, G111 or G112"))
            }
        }
    }
}
