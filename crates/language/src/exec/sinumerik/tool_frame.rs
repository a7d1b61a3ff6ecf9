//! TOROT and TOFRAME: Z of the program points along the tool, until TOROTOF.
//!
//! The frame lies between the settable and the programmable one, as that of CYCLE800, and is computed once: later turns of the tool do not change it. The
//! new X lies in the old ZX plane, as controls are delivered (Sinumerik SD42980, MD21110 with the value 1). The output states the frame with TRANS
//! and AROT: with corrected rotary axes, TOROT would give the control another frame than the one for which its moves were computed.

use super::channel::Channel;
use super::gathered::Gathered;
use super::modal::Swivelled;
use super::save;
use super::tilt_frame;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::tilted_plane::unknown_places;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, AxisVector, Frame, Matrix, Vector};
use ncfix_base::source::Span;
use ncfix_machine::machine::Kinematics;

/// Sine of the angle between the tool and Y below which X keeps its direction.
const ALONG_Y: f64 = 1e-9;

/// Executes `TOROT`, `TOFRAME` and `TOROTOF`.
pub(super) fn tool_frame(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    let Some((name, span)) = gathered.transform.tool_frame else { return Ok(()) };
    if !gathered.named.is_empty() {
        let message = format!("{name} in a block with a motion");
        return Err(fault(Code::MUST_STAND_ALONE, span, message, "give it its own block"));
    }
    let is_tilted = channel.modal.swivelled.as_ref().is_some_and(|swivelled| swivelled.is_of_tool);
    if name == "TOROTOF" {
        if !is_tilted {
            save::keep(channel, name);
            return Ok(());
        }
        channel.modal.swivelled = None;
        end_on_control(channel);
        return save::restate(channel, span);
    }
    if channel.modal.transform.turning().is_none() {
        let message = format!("{name} without TRAORI");
        let help = "program TRAORI before it, or tilt the plane with CYCLE800";
        return Err(fault(Code::NOT_SUPPORTED, span, message, help));
    }
    if channel.modal.programmable != Frame::identity() {
        let message = format!("{name} while a programmable frame is in force");
        let help = "end it with TRANS before, and program it again after: then it counts in the turned coordinates";
        return Err(fault(Code::NOT_SUPPORTED, span, message, help));
    }
    let kinematics = Kinematics::of_head(channel.settings.machine, channel.modal.tool.head);
    let has_origin = name == "TOFRAME";
    let is_first = channel.modal.swivelled.is_none();
    check_known(channel, &kinematics, has_origin, span);
    let below = channel.modal.base.compose(&channel.modal.settable);
    let along = below.unapply_direction(kinematics.direction(&channel.modal.position.command));
    let rotation = along_tool(&along).ok_or_else(|| {
        let message = format!("{name} with a tool that points below the plane XY: the direction of X is not known");
        fault(Code::BAD_SWIVEL, span, message, "program the rotation with ROT")
    })?;
    let mut tilt = Frame::rotation(rotation);
    if has_origin {
        // The last frame of a tool no longer counts.
        channel.modal.swivelled = None;
        let here = channel.modal.setup().programmed(&channel.modal.position.command);
        let mut origin = AxisVector::ZERO;
        origin.set_xyz(here.xyz());
        tilt = Frame::translation(origin).compose(&tilt);
    }
    let (frame, statements) = tilt_frame::stated(channel, &tilt, span)?;
    if is_first {
        end_on_control(channel);
    }
    let tool_mm = channel.modal.tool_mm();
    channel.modal.swivelled = Some(Box::new(Swivelled { frame, statements, tilt, tool_mm, is_of_tool: true }));
    save::restate(channel, span)
}

/// Writes `TOROTOF`: a tool frame of an earlier program would be added to the frame that the output states with TRANS and AROT, which delete no tool frame.
fn end_on_control(channel: &mut Channel<'_>) {
    channel.outlet.begin_line();
    save::keep(channel, "TOROTOF");
}

/// Reports axes on whose positions the frame depends, and which the program has not stated.
fn check_known(channel: &mut Channel<'_>, kinematics: &Kinematics, has_origin: bool, span: Span) {
    if !channel.settings.strict {
        return;
    }
    let linear = if has_origin { AxisSet::XYZ } else { AxisSet::EMPTY };
    let needed = linear.iter().chain(kinematics.rotary_axes());
    let known = channel.modal.position.known;
    let unknown: AxisSet = needed.filter(|axis| !known.contains(*axis)).collect();
    if !unknown.is_empty() {
        channel.outlet.warnings.push(unknown_places(span, unknown, "G0"));
        channel.modal.position.known = known.union(unknown);
    }
}

/// The rotation whose Z is a direction and whose X is in the old ZX plane; `None` if the direction is below the old XY plane.
fn along_tool(direction: &Vector) -> Option<Matrix> {
    let z = direction.try_normalize(0.0).filter(|z| z.iter().all(|part| part.is_finite()))?;
    if z.z < -ALONG_Y {
        return None;
    }
    let x = Vector::new(z.z, 0.0, -z.x).try_normalize(ALONG_Y).unwrap_or_else(Vector::x);
    Some(Matrix::from_columns(&[x, z.cross(&x), z]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn x_stays_in_the_zx_plane() {
        let turned = along_tool(&Vector::new(1.0, 0.0, 1.0)).unwrap();
        let half = 0.5_f64.sqrt();
        let wanted = Matrix::new(half, 0.0, half, 0.0, 1.0, 0.0, -half, 0.0, half);
        assert!((turned - wanted).norm() < 1e-15, "{turned}");
        let turned = along_tool(&Vector::new(0.0, 1.0, 0.0)).unwrap();
        assert!((turned * Vector::x() - Vector::x()).norm() < 1e-15, "{turned}");
        let skew = along_tool(&Vector::new(0.3, -0.4, 0.5)).unwrap();
        assert!((skew * skew.transpose() - Matrix::identity()).norm() < 1e-15 && skew.determinant() > 0.0);
        assert!(skew[(1, 0)].abs() < 1e-15 && along_tool(&Vector::new(0.0, 0.5, -0.5)).is_none());
    }
}
