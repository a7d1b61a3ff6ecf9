//! The location error that describes the squareness of two linear axes, which depends on the chain of the machine.
//!
//! γ is the angle between the positive motions of the tool relative to the workpiece, minus 90°. A small rotation of the second axis of a plane about its
//! normal opens the angle, a rotation of the first one closes it. If both axes are on one side of F, the axis further from F has the error: a rotation of the
//! other one turns both. If they are on two sides, the axis on the tool side has it, by convention.

use super::{Branch, Topology};
use ncfix_base::geometry::{Axis, Plane, ROTARY_AXES, Vector};

/// Location error of the squareness of two axes.
#[derive(Clone, Debug, PartialEq)]
pub struct SquarenessTerm {
    /// Name, such as `EC0Y`.
    pub name: String,
    /// Name of the other axis of the pair about the same normal. It describes the same angle or has no effect.
    pub other: String,
    /// Value of the error for γ = 1: 1 or -1.
    pub factor: f64,
}

/// Returns the axes of a plane and its normal, in cyclic order: X Y Z, Z X Y or Y Z X.
#[must_use]
pub fn pair(plane: Plane) -> [Axis; 3] {
    match plane {
        Plane::XY => [Axis::X, Axis::Y, Axis::Z],
        Plane::ZX => [Axis::Z, Axis::X, Axis::Y],
        Plane::YZ => [Axis::Y, Axis::Z, Axis::X],
    }
}

/// Returns the location error of the squareness in a plane; `None` if the machine lacks an axis of it. `direction` is the direction in F of an axis for a
/// positive command.
#[must_use]
pub fn squareness(
    topology: &Topology,
    plane: Plane,
    direction: impl Fn(Axis) -> Option<Vector>,
) -> Option<SquarenessTerm> {
    let [first, second, normal] = pair(plane);
    let rotation = ROTARY_AXES.into_iter().find(|axis| axis.dimension() == normal.dimension())?;
    // Distance from F in bodies, and sense of the motion of the tool relative to the workpiece along the axis of F.
    let place = |axis: Axis| {
        let branch = topology.branch(axis)?;
        let (axes, sign) = match branch {
            Branch::Workpiece => (&topology.workpiece, -1.0),
            Branch::Tool => (&topology.tool, 1.0),
        };
        let distance = axes.iter().position(|one| *one == axis)?;
        Some((branch, distance, direction(axis)?[axis.dimension()].signum() * sign))
    };
    let (one, two) = (place(first)?, place(second)?);
    let is_second = if one.0 == two.0 { two.1 > one.1 } else { two.0 == Branch::Tool };
    let name = |axis: Axis| format!("E{rotation}0{axis}");
    let (own, other, sign) = if is_second { (second, first, 1.0) } else { (first, second, -1.0) };
    Some(SquarenessTerm { name: name(own), other: name(other), factor: sign * one.2 * two.2 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn term(topology: &str, plane: Plane) -> (String, f64) {
        let topology: Topology = topology.parse().unwrap();
        let direction = |axis: Axis| {
            let mut own = Vector::zeros();
            own[axis.dimension()] = if topology.branch(axis)? == Branch::Tool { 1.0 } else { -1.0 };
            Some(own)
        };
        let found = squareness(&topology, plane, direction).unwrap();
        (found.name, found.factor)
    }

    #[test]
    fn the_chain_chooses_axis_and_sign() {
        for (topology, plane, name, factor) in [
            ("wFXYZSt", Plane::XY, "EC0Y", 1.0),
            ("wYXFZSt", Plane::XY, "EC0Y", 1.0),
            ("wXYFZSt", Plane::XY, "EC0X", -1.0),
            ("wYFXZSt", Plane::XY, "EC0X", -1.0),
            ("wFXYZSt", Plane::ZX, "EB0Z", -1.0),
            ("wFXYZSt", Plane::YZ, "EA0Z", 1.0),
        ] {
            assert_eq!(term(topology, plane), (name.to_owned(), factor), "{topology}");
        }
    }
}
