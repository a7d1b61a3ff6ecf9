//! An arc in any plane as a circle through three written points: start, intermediate point and end (CIP of a Sinumerik).

use ncfix_base::geometry::{AXES, AXIS_COUNT, Arc, Axis, Matrix, Plane, Vector};

use super::segment_candidate::{SegmentCandidate, SegmentFitter, state_of};
use super::standing::PathState;
use super::{Increments, PieceArc};

/// Largest sweep of a piece, rad: near a full turn, rounding moves the circle far beside its points.
const MOST_SWEEP: f64 = 330.0 * std::f64::consts::PI / 180.0;
/// Smallest height of the triangle of the three points, increments: with a lower one, a control may read a straight line.
const LEAST_HEIGHT: f64 = 10.0;
/// Motion of other axes that is rounding noise, mm or rad.
const SAME_PLACE: f64 = 1e-9;

/// A circle in space, relative to the start of its arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpatialCircle {
    /// From the start to the center, mm.
    pub(crate) to_center: Vector,
    /// Unit vector: the arc turns about it by the right-hand rule.
    pub(crate) normal: Vector,
    /// From the start to the end, mm.
    pub(crate) to_end: Vector,
}

impl SpatialCircle {
    /// The circle from the origin through a point to an end; `None` if the height of their triangle is lower than `least_mm`.
    ///
    /// The center is equally far from all three points. With a and b from the start to the others and n = a × b, it is (b a² − a b²) × n / 2n².
    fn through(middle: &Vector, end: &Vector, least_mm: f64) -> Option<SpatialCircle> {
        let across = middle.cross(end);
        let area = across.norm();
        let longest_mm = middle.norm().max(end.norm()).max((end - middle).norm());
        // A range, so that NaN has no circle.
        if !(least_mm * longest_mm..).contains(&area) || area == 0.0 {
            return None;
        }
        let to_center =
            (end * middle.norm_squared() - middle * end.norm_squared()).cross(&across) / (2.0 * area * area);
        Some(SpatialCircle { to_center, normal: across / area, to_end: *end })
    }

    /// Angle from the start to the end, rad.
    pub(crate) fn sweep_rad(&self) -> f64 {
        let first = -self.to_center;
        let last = self.to_end - self.to_center;
        self.normal.cross(&first).dot(&last).atan2(first.dot(&last)).rem_euclid(std::f64::consts::TAU)
    }
}

impl PieceArc {
    /// The circle of an arc through an intermediate point, in the emitted frame; `end` are the counts at its end.
    pub(crate) fn spatial(&self, end: &[i64; AXIS_COUNT], increments: &Increments) -> Option<SpatialCircle> {
        let through = self.through_counts?;
        let from_start = |counts: [i64; 3]| {
            let mut way = Vector::zeros();
            for (slot, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
                way[slot] = increments.position(axis, counts[slot] - self.start_counts[slot]);
            }
            way
        };
        let end = [end[Axis::X.slot()], end[Axis::Y.slot()], end[Axis::Z.slot()]];
        SpatialCircle::through(&from_start(through), &from_start(end), 0.0)
    }
}

impl<'m> SegmentFitter<'_, 'm> {
    /// The piece as an arc through an intermediate point, without measured deviation; `None` if the language has no such arcs, or other axes move too.
    pub(super) fn unmeasured_spatial_arc(
        &self,
        standing: &PathState,
        between: [f64; 2],
    ) -> Option<SegmentCandidate<'m>> {
        let placer = self.placer;
        let [from, to] = between;
        let swept = self.route.sweep_rad().abs() * (to - from);
        let keeps_circles = placer.is_parallel() || placer.setup.frame.keeps_shapes();
        let is_possible = placer.has_spatial_arcs && !placer.is_transformed() && !self.route.is_of_tip();
        if !is_possible || !keeps_circles || swept > MOST_SWEEP {
            return None;
        }
        let ends = self.ends(standing, between, true);
        let way = ends.end.command - ends.start;
        if ends.end.is_held_back || AXES.into_iter().any(|axis| axis.slot() > 2 && way[axis].abs() > SAME_PLACE) {
            return None;
        }
        let nominal = self.route.at(0.5 * (from + to));
        let correction = ends.end.command - self.route.at(to);
        let exact = placer.exact(&nominal, self.known, &state_of(ends.sense), &correction, f64::INFINITY).ok()?;
        let through = placer.round(&exact, self.known);
        let start = ends.start.xyz();
        let [middle, end] = [&through.command, &ends.end.command].map(|command| command.xyz() - start);
        let circle = SpatialCircle::through(&middle, &end, LEAST_HEIGHT * placer.increments.linear_mm)?;
        let first = (-circle.to_center).try_normalize(0.0)?;
        let basis = Matrix::from_columns(&[first, circle.normal.cross(&first), circle.normal]);
        let center = basis.tr_mul(&(start + circle.to_center));
        let arc = Arc { plane: Plane::XY, clockwise: false, center_mm: [center.x, center.y], extra_turns: 0 };
        let emitted = placer.emitted_arc(ends.start, ends.end.command, Some((arc, Some(basis))));
        let standing = placer.programmed(&ends.start);
        let start_counts = [Axis::X, Axis::Y, Axis::Z].map(|axis| placer.increments.count(axis, standing[axis]));
        let [x, y, z, ..] = through.counts;
        let circle = PieceArc {
            plane: placer.setup.plane,
            clockwise: false,
            center_counts: self.round_direction(circle.to_center).0,
            start_counts,
            extra_turns: 0,
            through_counts: Some([x, y, z]),
        };
        Some(self.trial(between, ends, emitted, Some(circle)))
    }
}
