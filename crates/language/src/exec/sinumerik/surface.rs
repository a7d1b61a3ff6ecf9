//! Tool directions from path and surface: `LEAD=`, `TILT=`, the normals `A4= B4= C4=` and `A5= B5= C5=`, and ORIPATH.
//!
//! The direction is that at the end of a block: the surface normal there, rotated by LEAD towards the end of the path and by TILT sideways. On the
//! path the tool follows a great circle, as with a programmed direction (Sinumerik MD21094, last digit 0).

use super::address::Named;
use super::gathered::{Gathered, NamedValue};
use super::modal::Modal;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::path::{Path, Shape};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, Vector};
use ncfix_base::source::Span;
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::{OriPath, TiltAbout};

/// Smallest angle between normal and path that defines a plane for LEAD (Sinumerik MD21084), rad.
const NORMAL_ALONG_PATH_RAD: f64 = 0.052_36;

/// Takes the words of a block for the surface and the tool direction relative to it.
pub(super) fn surface(modal: &mut Modal, gathered: &Gathered) -> Result<(), Fault> {
    let is_on = modal.transform.turning().is_some();
    let surface = &mut modal.transform.surface;
    for value in &gathered.addresses {
        let slot = match value.address {
            Named::Lead => 0,
            Named::Tilt => 1,
            _ => continue,
        };
        if !is_on {
            return Err(bad_value(value.span, "an angle to the path without TRAORI", "program TRAORI first"));
        }
        if value.dimension.is_some() || !(-180.0..=180.0).contains(&value.value) {
            let message = "LEAD and TILT are absolute angles from -180 to 180 degrees";
            return Err(bad_value(value.span, message, "give the angle without AC or IC"));
        }
        surface.angles[slot] = Some(value.value.to_radians());
    }
    // The normal at the end of the block; a normal at its start alone applies to the end too.
    for number in [5, 4] {
        let Some((normal, span)) = vector(gathered, number) else { continue };
        if !is_on {
            return Err(bad_value(span, "a surface normal without TRAORI", "program TRAORI first"));
        }
        if !(normal.norm_squared() > 0.0 && normal.norm_squared().is_finite()) {
            let message = format!("a surface normal of length zero: A{number}, B{number}, C{number}");
            return Err(bad_value(span, message, "give a component a value other than 0"));
        }
        surface.normal = normal;
        break;
    }
    Ok(())
}

/// The direction at the end of a block from path and surface, in program coordinates, and the word that requests it.
pub(super) fn direction_on_path(
    machine: &Machine,
    modal: &Modal,
    outlet: &MotionSink<'_>,
    gathered: &Gathered,
    path: &Path,
) -> Result<Option<(Vector, Span)>, Fault> {
    let transform = &modal.transform;
    let surface = &transform.surface;
    let word = gathered.addresses.iter().find(|value| matches!(value.address, Named::Lead | Named::Tilt));
    if path.setup.transform.is_none() || !surface.follows_path && word.is_none() {
        return Ok(None);
    }
    let span = word.map_or(path.span, |word| word.span);
    let moves = path.start.xyz() != path.motion.target.xyz() || path.shape != Shape::Line;
    check_only_direction(outlet, gathered, word)?;
    if !moves {
        return match word {
            None => Ok(None),
            Some(_) => {
                Err(bad_value(span, "LEAD or TILT in a block without path motion", "program them with a motion"))
            }
        };
    }
    let refused = |message: &str, help: &str| Err(fault(Code::NOT_SUPPORTED, span, message, help));
    if transform.in_machine {
        return refused(
            "LEAD and TILT under ORIMKS are not supported",
            "program ORIWKS, or the direction with A3, B3, C3",
        );
    }
    if surface.angles == [None; 2] {
        return Err(bad_value(span, "ORIPATH before any LEAD or TILT", "program LEAD and TILT"));
    }
    if !AxisSet::XYZ.difference(path.start_known).is_empty() {
        let message = "the path direction is not known, because its start is not known";
        return Err(fault(Code::UNKNOWN_START, span, message, "begin with a motion that programs X, Y and Z"));
    }
    let tangent = match &path.shape {
        // Chords give the direction at the end of a curve only approximately.
        Shape::Chords(_) => None,
        Shape::Line | Shape::Arc { .. } => modal.tangent,
    };
    let Some(tangent) = tangent else {
        let message = "LEAD and TILT with splines, polynomials and arcs in space are not supported";
        return refused(message, "program lines and arcs, or the direction with A3, B3, C3");
    };
    let tangent = path.setup.frame.unapply_direction(tangent);
    let [lead, tilt] = surface.angles.map(|angle| angle.unwrap_or(0.0));
    match on_surface(&tangent, &surface.normal, [lead, tilt], machine.control.tilt_about) {
        Some(direction) => Ok(Some((direction, span))),
        None => Err(bad_value(
            span,
            "the surface normal is parallel to the path, so LEAD has no plane",
            "give a normal across the path with A5, B5, C5, or program ORIVECT for this block",
        )),
    }
}

/// Checks that nothing else in the block defines the tool direction.
fn check_only_direction(outlet: &MotionSink<'_>, gathered: &Gathered, word: Option<&NamedValue>) -> Result<(), Fault> {
    let direct = gathered.addresses.iter().find(|value| matches!(value.address, Named::Orientation(2 | 3, _)));
    let rotary = outlet.kinematics.as_ref().and_then(|kinematics| {
        let axis = kinematics.rotary_axes().find(|&axis| gathered.named.contains(axis))?;
        gathered.axis_spans.get(axis.slot()).copied()
    });
    match (direct.map(|value| value.span).or(rotary), word) {
        (None, _) => Ok(()),
        (Some(span), Some(_)) => {
            let message = "LEAD or TILT and another word for the tool direction in one block";
            Err(fault(Code::DOUBLE_WORD, span, message, "keep one of them"))
        }
        (Some(span), None) => {
            let message = "an explicit tool direction under ORIPATH is not supported";
            Err(fault(Code::NOT_SUPPORTED, span, message, "program ORIVECT before it, or LEAD and TILT"))
        }
    }
}

/// ORIPATH: every following motion ends in the direction given by path and surface.
pub(super) fn follow_path(machine: &Machine, modal: &mut Modal, outlet: &mut MotionSink<'_>) -> Result<(), Fault> {
    if machine.control.ori_path == OriPath::Path {
        let message = "ORIPATH that keeps the tool relative to the path within a block is not supported";
        let help = "control.oripath states this behavior; program the directions with A3, B3, C3";
        return Err(fault(Code::NOT_SUPPORTED, outlet.origin.span, message, help));
    }
    modal.transform.surface.follows_path = true;
    Ok(())
}

/// The vector of the words with a number, with missing components 0, and the span of the first.
fn vector(gathered: &Gathered, number: u8) -> Option<(Vector, Span)> {
    let mut found: Option<(Vector, Span)> = None;
    for value in &gathered.addresses {
        if let Named::Orientation(known, slot) = value.address
            && known == number
            && let Some(part) = found.get_or_insert((Vector::zeros(), value.span)).0.get_mut(usize::from(slot))
        {
            *part = value.value;
        }
    }
    found
}

/// The unit vector of the tool for a path and a normal; `None` if these are parallel.
///
/// LEAD rotates the normal towards the tangent, about their common perpendicular. A positive TILT is counter-clockwise, seen against its axis.
fn on_surface(tangent: &Vector, normal: &Vector, [lead, tilt]: [f64; 2], about: TiltAbout) -> Option<Vector> {
    let (tangent, normal) = (tangent.try_normalize(0.0)?, normal.try_normalize(0.0)?);
    let across = normal.cross(&tangent);
    if across.norm() < NORMAL_ALONG_PATH_RAD.sin() {
        return None;
    }
    let across = across.normalize();
    Some(match about {
        TiltAbout::Normal => turned(&turned(&normal, &across, lead), &normal, tilt),
        TiltAbout::Tangent => turned(&turned(&normal, &across, lead), &tangent, tilt),
        // A rotation about the turned tangent afterwards equals one about the tangent before.
        TiltAbout::TurnedTangent => turned(&turned(&normal, &tangent, tilt), &across, lead),
    })
}

/// A vector rotated about a unit axis (Rodrigues).
fn turned(vector: &Vector, axis: &Vector, angle: f64) -> Vector {
    let (sine, cosine) = angle.sin_cos();
    vector * cosine + axis.cross(vector) * sine + axis * (axis.dot(vector) * (1.0 - cosine))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lead_leans_forward_and_tilt_turns_about_its_axis() {
        let at = |angles: [f64; 2], about| {
            on_surface(&(Vector::x() * 3.0), &(Vector::z() * 0.2), angles.map(f64::to_radians), about)
                .unwrap_or_default()
        };
        let half = 0.5_f64.sqrt();
        for about in [TiltAbout::Normal, TiltAbout::Tangent, TiltAbout::TurnedTangent] {
            assert!((at([0.0, 0.0], about) - Vector::z()).norm() < 1e-15);
            assert!((at([45.0, 0.0], about) - Vector::new(half, 0.0, half)).norm() < 1e-15);
        }
        assert!((at([45.0, 90.0], TiltAbout::Normal) - Vector::new(0.0, half, half)).norm() < 1e-15);
        assert!((at([45.0, 90.0], TiltAbout::Tangent) - Vector::new(half, -half, 0.0)).norm() < 1e-15);
        assert!((at([45.0, 90.0], TiltAbout::TurnedTangent) + Vector::y()).norm() < 1e-15);
        assert_eq!(on_surface(&Vector::z(), &Vector::z(), [0.1, 0.0], TiltAbout::Normal), None);
    }
}
