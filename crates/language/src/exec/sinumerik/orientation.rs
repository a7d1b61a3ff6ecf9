//! Tool directions in a block: `A3= B3= C3=` vectors and `A2= B2= C2=` angles become positions of the rotary axes.

use super::address::Named;
use super::gathered::Gathered;
use super::modal::Modal;
use super::surface;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::exec::core::five_axis;
use crate::exec::core::motion_sink::MotionSink;
use crate::exec::core::path::Path;
use crate::exec::core::settings::RunSettings;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::source::Span;
use ncfix_machine::machine::OrientationAngles;

/// Adds the orientation of a block to its motion.
pub(super) fn orient(
    settings: &RunSettings<'_>,
    modal: &mut Modal,
    outlet: &mut MotionSink<'_>,
    gathered: &Gathered,
    path: &mut Path,
) -> Result<(), Fault> {
    let on_path = surface::direction_on_path(settings.machine, modal, outlet, gathered, path)?;
    let Some((number, values, span)) = on_path.map(|(values, span)| (3, values, span)).or_else(|| words(gathered))
    else {
        return Ok(());
    };
    if !matches!(number, 2 | 3) {
        let message = "cones and second curves for orientations are not supported yet";
        return Err(fault(Code::NOT_SUPPORTED, span, message, "give the direction of the tool with A3, B3, C3"));
    }
    let (Some(turning), Some(kinematics)) = (path.setup.transform, &outlet.kinematics) else {
        let message = "a tool direction without TRAORI";
        return Err(bad_value(span, message, "program TRAORI first, or positions of the rotary axes"));
    };
    if let Some(axis) = kinematics.rotary_axes().find(|&axis| gathered.named.contains(axis)) {
        let message = format!("a tool direction and a position of {axis} in one block");
        return Err(fault(Code::DOUBLE_WORD, span, message, "keep one of them"));
    }
    let mut direction = match number {
        3 => values,
        _ => {
            let angles = modal.transform.angles.unwrap_or(settings.machine.control.orientation_angles);
            from_angles(angles, [values.x, values.y, values.z].map(f64::to_radians))
        }
    };
    if !modal.transform.in_machine {
        direction = path.setup.frame.apply_direction(direction);
    }
    let Some(direction) = direction.try_normalize(1e-9).filter(|unit| unit.iter().all(|part| part.is_finite())) else {
        return Err(bad_value(span, "a tool direction of length zero", "give A3, B3 or C3 a value other than 0"));
    };
    let Some(found) = five_axis::turned_to(kinematics, turning, path, &direction) else {
        let [a, b, c] = [direction.x, direction.y, direction.z];
        let message = format!("the rotary axes cannot orient the tool along {a:.6} {b:.6} {c:.6} of the machine");
        let help = "check the direction, the travel of the rotary axes, and the kinematics in the machine file";
        return Err(fault(Code::NO_ORIENTATION, span, message, help));
    };
    for axis in kinematics.rotary_axes() {
        path.motion.target[axis] = found[axis];
        path.motion.named.insert(axis);
        path.motion.known.insert(axis);
        modal.position.command[axis] = found[axis];
        modal.programmed[axis] = found[axis] - modal.frame().shift(axis);
        modal.position.known.insert(axis);
    }
    if let crate::exec::core::path::Shape::Chords(ends) = &mut path.shape {
        five_axis::spread_rotaries(kinematics, &path.start, &path.motion.target, ends);
    }
    Ok(())
}

/// Number of the direction words of a block (0 for several), their values, and the span of the first.
fn words(gathered: &Gathered) -> Option<(u8, Vector, Span)> {
    let mut found: Option<(u8, Vector, Span)> = None;
    for value in &gathered.addresses {
        if let Named::Orientation(number @ (2 | 3 | 6 | 7), slot) = value.address {
            let (first, values, _) = found.get_or_insert((number, Vector::zeros(), value.span));
            if *first != number {
                *first = 0;
            }
            values[usize::from(slot)] = value.value;
        }
    }
    found
}

/// The direction of the tool for three angles, rad.
fn from_angles(angles: OrientationAngles, [a, b, c]: [f64; 3]) -> Vector {
    let about = |axis: Axis, angle: f64, vector: Vector| {
        let (sine, cosine) = angle.sin_cos();
        let [x, y, z] = [vector.x, vector.y, vector.z];
        match axis {
            Axis::X => Vector::new(x, cosine * y - sine * z, sine * y + cosine * z),
            Axis::Y => Vector::new(cosine * x + sine * z, y, cosine * z - sine * x),
            _ => Vector::new(cosine * x - sine * y, sine * x + cosine * y, z),
        }
    };
    match angles {
        OrientationAngles::Rpy => about(Axis::Z, c, about(Axis::Y, b, about(Axis::X, a, Vector::z()))),
        OrientationAngles::Euler => about(Axis::Z, a, about(Axis::X, b, about(Axis::Z, c, Vector::z()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::sinumerik::address::address;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn angles_turn_in_their_order() {
        let rpy = |angles| from_angles(OrientationAngles::Rpy, angles);
        assert!((rpy([FRAC_PI_2, 0.0, 0.0]) - Vector::new(0.0, -1.0, 0.0)).norm() < 1e-15);
        assert!((rpy([0.0, FRAC_PI_2, 0.0]) - Vector::x()).norm() < 1e-15);
        // A leads to -Y, then C to X; B does not rotate X out of that direction.
        assert!((rpy([FRAC_PI_2, 0.0, FRAC_PI_2]) - Vector::x()).norm() < 1e-15);
        let euler = |angles| from_angles(OrientationAngles::Euler, angles);
        assert!((euler([FRAC_PI_2, FRAC_PI_2, 0.7]) - Vector::x()).norm() < 1e-15);
        assert_eq!(address(b'A', 3), Some(Named::Orientation(3, 0)));
        assert_eq!(address(b'C', 8), None);
        assert_eq!(address(b'S', 3), None);
    }
}
