//! Conditions that radius compensation rejects.

use super::contour_request::{CompensationDoubt, Rules};
use super::curve::Curve;
use super::moving::Moving;
use crate::exec::core::fault::Fault;
use ncfix_base::diagnostic::Code;

/// The fault for a motion whose path of the tool center is not known.
pub(super) fn doubtful(moving: &Moving) -> Option<Fault> {
    let (message, help) = match moving.wish.doubt {
        _ if moving.path.setup.transform.is_some() && moving.wish.modal.rules != Rules::Sinumerik => (
            "radius compensation under a five-axis transformation is not supported",
            "program the path of the tool center in the CAM system, or a tilted plane with G41 and G42",
        ),
        Some(CompensationDoubt::ToolTurns) => (
            "the tool turns while radius compensation is on",
            "turn it before G41, or program the path of the tool center in the CAM system",
        ),
        Some(CompensationDoubt::TiltedPlane) => (
            "radius compensation with CUT2D in a plane that a frame tilts: CUT2D compensates in the plane of the machine",
            "write CUT2DF, which compensates in the tilted plane, before G41; or tilt the plane with CYCLE800",
        ),
        None => return None,
    };
    Some(moving.fault(Code::NOT_SUPPORTED, message, help))
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
