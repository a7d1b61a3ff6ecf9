//! Conditions that radius compensation rejects.

use super::contour_request::Rules;
use super::curve::Curve;
use super::moving::Moving;
use crate::exec::core::fault::Fault;
use ncfix_base::diagnostic::Code;

pub(super) fn transformed(moving: &Moving) -> Fault {
    if moving.wish.modal.rules != Rules::Sinumerik {
        return moving.fault(
            Code::NOT_SUPPORTED,
            "radius compensation under a five-axis transformation is not supported",
            "program the path of the tool center in the CAM system, or a tilted plane with G41 and G42",
        );
    }
    moving.fault(
        Code::NOT_SUPPORTED,
        "radius compensation under TRAORI, while the tool turns or is not at right angles to the working plane",
        "turn the tool or the plane (TOROT, CYCLE800) before G41, or program the path of the tool center in the CAM system",
    )
}

pub(super) fn wear_under_transformation(moving: &Moving) -> Fault {
    moving.fault(
        Code::NO_WEAR,
        "radius compensation under a five-axis transformation cannot stay at the control for the wear",
        "leave out --compensation wear, and give the radius with its wear in the machine file or with --setup",
    )
}

pub(super) fn no_contour(moving: &Moving) -> Fault {
    moving.fault(
        Code::BAD_COMPENSATION,
        "radius compensation begins here, but no contour follows",
        "program a motion in the plane after it, before G40 or the end",
    )
}

pub(super) fn soft_alone(moving: &Moving) -> Fault {
    moving.fault(
        Code::NOT_SUPPORTED,
        "a soft approach or retraction is supported only where radius compensation begins or ends",
        "program it where G41, G42 or G40 takes effect (Sinumerik G147, G247, G347 and G148, G248, G348; Grundig G61 and G62)",
    )
}

pub(super) fn polynomial(moving: &Moving) -> Fault {
    moving.fault(
        Code::NOT_SUPPORTED,
        "approach and retraction along a polynomial (KONTT, KONTC) are not supported",
        "use NORM or KONT",
    )
}

/// Advice for a contour that is narrower than the tool.
pub(super) const NARROW: &str = "use a smaller tool, or change the contour; if the program already has the tool center path and G41 or G42 is for wear alone, set radius_mm of the tool in the machine file to the wear, or to 0";

pub(super) fn too_narrow(moving: &Moving, contour: &Curve, beside: f64) -> Fault {
    let radius = if let Curve::Arc { radius, .. } = *contour { radius } else { 0.0 };
    moving.fault(
        Code::CONTOUR_NOT_FOLLOWED,
        format!(
            "this inner arc of radius {radius:.4} mm is too narrow for a tool center at a distance of {:.4} mm",
            beside.abs()
        ),
        NARROW,
    )
}
