//! Distance of a curve from its chords.
//!
//! The curve that produced the chords may have been changed since: an offset of a curve by the tool radius has another curvature. This module
//! therefore uses the chords alone: the curve through the ends of three chords has the curvature of their circle.

use ncfix_base::geometry::AxisVector;

/// Ratio of the curvatures at both ends of a chord above which one of them belongs to a corner.
const CORNER: f64 = 3.0;
/// Upper bound of the distance in chord tolerances if only one curvature is known.
const MOST_TOLERANCES: f64 = 4.0;

/// Largest distance of the curve from chord `k` of consecutive chords from `start` to `ends`, mm. A single chord has no known curvature: it was made
/// within the tolerance.
pub(in crate::exec) fn off_mm(start: &AxisVector, ends: &[AxisVector], k: usize, tolerance_mm: f64) -> f64 {
    let point = |place: usize| if place == 0 { Some(start) } else { ends.get(place - 1) };
    let bend = |place: usize| {
        let before = point(place.checked_sub(1)?)?;
        Some(curvature(before, point(place)?, point(place + 1)?))
    };
    let (Some(from), Some(to)) = (point(k), point(k + 1)) else { return 0.0 };
    let of = |curvature: f64| (to.xyz() - from.xyz()).norm_squared() * curvature / 8.0;
    let beside = |near: Option<f64>, far: Option<f64>| match (near, far) {
        (Some(near), Some(far)) => Some(smooth(near, far)),
        (near, _) => near,
    };
    match (bend(k), bend(k + 1)) {
        (Some(one), Some(other)) => of(smooth(one, other)),
        // First and last chord: the neighboring chord reveals a corner.
        (None, near) => beside(near, bend(k + 2)).map_or(tolerance_mm, of),
        (near, None) => beside(near, k.checked_sub(1).and_then(bend)).map_or(tolerance_mm, of),
    }
    .min(if ends.len() < 3 { MOST_TOLERANCES * tolerance_mm } else { f64::INFINITY })
}

/// The larger of two curvatures, or the smaller one if the larger one is a corner.
fn smooth(one: f64, other: f64) -> f64 {
    let (least, most) = (one.min(other), one.max(other));
    if most > CORNER * least { least } else { most }
}

/// The curvature of the circle through three points, 1/mm.
fn curvature(a: &AxisVector, b: &AxisVector, c: &AxisVector) -> f64 {
    let [ab, bc, ac] = [b.xyz() - a.xyz(), c.xyz() - b.xyz(), c.xyz() - a.xyz()];
    let sides = ab.norm() * bc.norm() * ac.norm();
    if sides > 0.0 { 2.0 * ab.cross(&bc).norm() / sides } else { 0.0 }
}

/// Maximum number of chords of one arc; a tolerance that needs more is not met.
const MOST_CHORDS: f64 = 100_000.0;

/// The number of equal chords within a tolerance of an arc: the sagitta of a chord of angle a is r (1 − cos a/2).
pub(in crate::exec) fn chord_count(radius_mm: f64, sweep_rad: f64, tolerance_mm: f64) -> u32 {
    let share = (1.0 - tolerance_mm / radius_mm).clamp(0.0, 1.0);
    let widest = (2.0 * share.acos()).max(1e-6);
    // Between 1 and the limit.
    (sweep_rad.abs() / widest).ceil().clamp(1.0, MOST_CHORDS) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64) -> AxisVector {
        AxisVector([x, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    #[test]
    fn chords_of_a_circle_are_off_by_their_sagitta() {
        // R = 20 mm, chords of 3 degrees: R (1 - cos 1.5 degrees) = 6.853 um.
        let points: Vec<AxisVector> = (0..=30)
            .map(|k| (3.0 * f64::from(k)).to_radians().sin_cos())
            .map(|(y, x)| at(20.0 * x, 20.0 * y))
            .collect();
        for k in 0..30 {
            let off = off_mm(&points[0], &points[1..], k, 2.5e-4);
            assert!((off - 6.853e-3).abs() < 5e-6, "{k}: {off}");
        }
    }

    #[test]
    fn corners_and_lines_are_no_curves() {
        let points = [at(1.0, 0.0), at(2.0, 0.0), at(3.0, 0.0), at(3.0, 1.0), at(3.0, 2.0), at(3.0, 3.0)];
        for k in 0..points.len() {
            assert_eq!(off_mm(&at(0.0, 0.0), &points, k, 2.5e-4), 0.0, "{k}");
        }
        assert_eq!(off_mm(&at(0.0, 0.0), &points[..1], 0, 2.5e-4), 2.5e-4);
    }

    #[test]
    fn chords_keep_the_sagitta() {
        // r = 10, a = 90 degrees: sagitta 10 (1 - cos 45°) = 2.9289.
        assert_eq!(chord_count(10.0, std::f64::consts::TAU, 2.93), 4);
        assert_eq!(chord_count(10.0, std::f64::consts::TAU, 2.92), 5);
        assert_eq!(chord_count(10.0, 0.1, 100.0), 1);
    }
}
