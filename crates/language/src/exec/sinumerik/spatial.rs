//! Arcs in space: through an intermediate point (CIP), and tangential to the preceding motion (CT).

use super::address::Named;
use super::context::MotionContext;
use super::gathered::{Gathered, NamedValue};
use super::modal::{Modal, MotionKind};
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::path::Shape;
use crate::exec::core::sagitta::chord_count;
use crate::syntax::sinumerik::DimensionFunction;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Matrix, Plane, PlaneBasis, Vector};

/// Sagitta below which an arc is straight, mm.
const STRAIGHT_MM: f64 = 1e-6;
/// Tolerance of equal normals: 1 minus the cosine of the angle between them.
const SAME_NORMAL: f64 = 1e-12;

/// A circle in programmed coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Circle {
    center: Vector,
    /// Normal about which the path is counter-clockwise.
    normal: Vector,
}

/// The circle of a CIP or CT block between two positions in base coordinates; `None` if the path is straight.
pub(super) fn circle(
    gathered: &Gathered,
    modal: &Modal,
    context: MotionContext<'_>,
    start: &AxisVector,
    target: &AxisVector,
) -> Result<Option<Circle>, Fault> {
    if context.strict
        && let Some(axis) = AxisSet::XYZ.difference(modal.position.known).iter().next()
    {
        return Err(modal.unknown_start(context.span, axis));
    }
    let (from, to) = (context.setup.programmed(start), context.setup.programmed(target));
    let chord = to.xyz() - from.xyz();
    if chord.amax() < context.control.grid[0] {
        let message = "start and end of this arc coincide";
        return Err(fault(Code::BAD_ARC, context.span, message, "a full circle needs G2 or G3 with I, J, K"));
    }
    if modal.modes.motion == MotionKind::Tangent {
        let Some(tangent) = modal.tangent else {
            let message = "a tangential arc without a preceding motion";
            return Err(fault(Code::BAD_ARC, context.span, message, "program a motion before it, or G2 or G3"));
        };
        return Ok(tangential(&from.xyz(), &context.setup.frame.unapply_direction(tangent), &chord));
    }
    let middle = intermediate(gathered, modal, context, &from)?;
    Ok(through(&from.xyz(), &(middle - from.xyz()), &chord))
}

/// The circle from a point along a tangent to the end of a chord.
fn tangential(from: &Vector, tangent: &Vector, chord: &Vector) -> Option<Circle> {
    let along = tangent.normalize();
    let across = chord - along * along.dot(chord);
    let (offset, square) = (across.norm(), chord.norm_squared());
    // The sagitta is about a quarter of the offset of the end.
    if offset.is_nan() || offset <= 4.0 * STRAIGHT_MM {
        return None;
    }
    let side = across / offset;
    Some(Circle { center: from + side * (square / (2.0 * offset)), normal: along.cross(&side) })
}

/// The circle through three points: the first, and the others relative to it.
fn through(from: &Vector, middle: &Vector, end: &Vector) -> Option<Circle> {
    let normal = middle.cross(end);
    let size = normal.norm();
    // The height of the triangle over its longest side.
    let longest = middle.norm().max(end.norm()).max((end - middle).norm());
    if size.is_nan() || size <= STRAIGHT_MM * longest {
        return None;
    }
    let to_center = (end * middle.norm_squared() - middle * end.norm_squared()).cross(&normal) / (2.0 * size * size);
    Some(Circle { center: from + to_center, normal: normal / size })
}

/// The intermediate point of CIP in programmed coordinates.
fn intermediate(
    gathered: &Gathered,
    modal: &Modal,
    context: MotionContext<'_>,
    from: &AxisVector,
) -> Result<Vector, Fault> {
    let mut middle = from.xyz();
    let words = [Named::I1, Named::J1, Named::K1];
    if !words.into_iter().any(|word| gathered.named(word).is_some()) {
        let message = "CIP without an intermediate point";
        return Err(fault(Code::NO_CENTER, context.span, message, "add I1=, J1=, K1="));
    }
    for (word, axis) in words.into_iter().zip([Axis::X, Axis::Y, Axis::Z]) {
        match gathered.named(word) {
            Some(&NamedValue { value, dimension, .. }) => {
                let is_incremental = match dimension {
                    Some(DimensionFunction::Incremental) => true,
                    Some(_) => false,
                    None => modal.modes.incremental,
                };
                let value = value * modal.modes.scale();
                middle[axis.slot()] = if is_incremental { from[axis] + value } else { value };
            }
            None if gathered.named.contains(axis) && modal.programmed[axis] != from[axis] => {
                let letter = char::from(b"IJK"[axis.slot()]);
                let message = format!("{axis} moves, but the intermediate point has no {letter}1");
                return Err(fault(
                    Code::BAD_ARC,
                    context.span,
                    message,
                    "give all coordinates of the intermediate point",
                ));
            }
            None => {}
        }
    }
    Ok(middle)
}

impl Circle {
    /// The path between two positions in base coordinates, and its reference basis. `working` is the working plane after the frame.
    pub(super) fn shape(
        &self,
        working: PlaneBasis,
        plane: Plane,
        ends: [&AxisVector; 2],
        context: MotionContext<'_>,
    ) -> (Shape, PlaneBasis) {
        let (frame, setup) = (&context.setup.frame, context.setup);
        let [from, to] = ends.map(|end| setup.programmed(end));
        let first = from.xyz() - self.center;
        let second = self.normal.cross(&first);
        if frame.keeps_shapes() {
            let (u, v) = (frame.apply_direction(first).normalize(), frame.apply_direction(second).normalize());
            let normal = u.cross(&v);
            let mut center = from;
            center.set_xyz(self.center);
            let center = setup.command(&center);
            let principal = [plane, Plane::XY, Plane::ZX, Plane::YZ].map(PlaneBasis::Principal);
            let same = |basis: &PlaneBasis| basis.lift([0.0; 2], 1.0).dot(&normal).abs() > 1.0 - SAME_NORMAL;
            let basis = std::iter::once(working)
                .chain(principal)
                .find(same)
                .unwrap_or_else(|| PlaneBasis::Tilted(Matrix::from_columns(&[u, v, normal])));
            let clockwise = basis.lift([0.0; 2], 1.0).dot(&normal) < 0.0;
            return (Shape::Arc { clockwise, center: basis.flat(&center), extra_turns: 0 }, basis);
        }
        let last = to.xyz() - self.center;
        let sweep_rad = second.dot(&last).atan2(first.dot(&last)).rem_euclid(std::f64::consts::TAU);
        let radius_mm = first.norm() * frame.linear().norm();
        let count = chord_count(radius_mm, sweep_rad, context.control.chord_tolerance_mm);
        let mut chords: Vec<AxisVector> = (1..count)
            .map(|k| {
                let share = f64::from(k) / f64::from(count);
                let (sine, cosine) = (sweep_rad * share).sin_cos();
                let mut position = from.lerp(&to, share);
                position.set_xyz(self.center + first * cosine + second * sine);
                setup.command(&position)
            })
            .collect();
        chords.push(*ends[1]);
        (Shape::Chords(chords), working)
    }
}

/// Records the direction at the end of a path, in base coordinates; a motion of zero length keeps the previous one.
pub(super) fn note_tangent(
    tangent: &mut Option<Vector>,
    start: &AxisVector,
    target: &AxisVector,
    shape: &Shape,
    basis: &PlaneBasis,
) {
    let last = match shape {
        Shape::Line => target.xyz() - start.xyz(),
        Shape::Chords(ends) => {
            let before = ends.len().checked_sub(2).and_then(|place| ends.get(place)).unwrap_or(start);
            target.xyz() - before.xyz()
        }
        Shape::Arc { clockwise, center, extra_turns } => {
            let (from, to) = (basis.flat(start), basis.flat(target));
            let flat = |point: [f64; 2]| AxisVector([point[0], point[1], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let (clockwise, extra_turns) = (*clockwise, *extra_turns);
            let arc = ncfix_base::geometry::Arc { plane: Plane::XY, clockwise, center_mm: *center, extra_turns };
            let sweep = arc.sweep_rad(&flat(from), &flat(to));
            let climb = (basis.height(target) - basis.height(start)) / sweep;
            let sense = sweep.signum();
            basis.lift([-(to[1] - center[1]) * sense, (to[0] - center[0]) * sense], climb * sense)
        }
    };
    if last.iter().all(|part| part.is_finite()) && last.norm_squared() > 0.0 {
        *tangent = Some(last);
    }
}
