//! The frame of a tilted plane as statements of the output.

use super::channel::Channel;
use super::frame_store;
use super::save;
use super::setup;
use crate::exec::core::fault::Fault;
use ncfix_base::geometry::{AXES, Axis, AxisSet, AxisVector, Frame, Matrix, RotationOrder};
use ncfix_base::source::Span;
use ncfix_machine::snc::{FrameKind, FrameStatement};

/// Tolerance of a rotation matrix.
pub(super) const SAME_ROTATION: f64 = 1e-9;
/// Resolution of shifts in the statements, parts of a mm: the rounding of each is at most 5 nm, a twentieth of the usual increment.
const SHIFT_PARTS: f64 = 1e5;
/// Resolution of angles in the statements, parts of a degree: the rounding of each is at most 9 nm at an arm of 1 m.
const ANGLE_PARTS: f64 = 1e6;

/// A frame between the settable and the programmable one, as its statements in the output give it, and these.
pub(super) fn stated(channel: &Channel<'_>, frame: &Frame, span: Span) -> Result<(Frame, [FrameStatement; 2]), Fault> {
    let statements = statements_of(frame, setup::rotation_order(channel.settings.machine))
        .ok_or_else(|| save::refused(span, "the zero offset scales or mirrors".to_owned()))?;
    let frame = statements.iter().fold(Frame::identity(), |frame, statement| {
        let added = frame_store::frame_of(statement, channel.modal.modes.plane, &channel.settings.machine.control);
        frame.compose(&added.unwrap_or_else(Frame::identity))
    });
    Ok((frame, statements))
}

/// `TRANS` and `AROT` that form a frame; `None` if it scales or mirrors.
fn statements_of(frame: &Frame, order: RotationOrder) -> Option<[FrameStatement; 2]> {
    let linear = frame.linear();
    let is_rotation =
        (linear * linear.transpose() - Matrix::identity()).norm() < SAME_ROTATION && linear.determinant() > 0.0;
    let shown = |value: f64, parts: f64| (value * parts).round() / parts;
    let mut shift = AxisVector::ZERO;
    let mut angles = AxisVector::ZERO;
    for (slot, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
        shift[axis] = shown(frame.shift(axis), SHIFT_PARTS);
        angles[axis] = shown(order.angles_rad(linear)[slot].to_degrees(), ANGLE_PARTS).to_radians();
    }
    let named = |values: &AxisVector| AXES.into_iter().filter(|&axis| values[axis] != 0.0).collect::<AxisSet>();
    let statement = |kind, additive, values: AxisVector| FrameStatement {
        kind,
        additive,
        values,
        named: named(&values),
        in_plane_rad: None,
    };
    is_rotation.then(|| [statement(FrameKind::Translate, false, shift), statement(FrameKind::Rotate, true, angles)])
}
