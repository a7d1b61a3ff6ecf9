//! Arcs in place of the chords of a curve.
//!
//! The ends of the chords are places of the curve. The longest arc from one of these places to a later one, within the tolerance of all places between,
//! replaces the chords. An arc follows a curve with an error of third order, a chord with one of second order: a tenth of the blocks remains, and
//! the direction changes less between them. Corners stay: an arc is never farther from its chords than their tolerance permits.

use super::sagitta;
use ncfix_base::geometry::{AXES, AxisVector, PlaneBasis};

/// Share of the chord tolerance for the places of the curve; the rest is for the curve between them.
const FIT_SHARE: f64 = 0.8;
/// Distance of an arc from a chord of the curve in chord tolerances. The chord keeps the tolerance where the curve has the curvature of the arc.
const SAG_SHARE: f64 = 1.5;
/// Largest radius of an arc, mm: controls read centers up to 99,999 mm.
const MOST_RADIUS_MM: f64 = 10_000.0;
/// Largest sine of half the sweep: an arc of 116 degrees is well defined by its ends and its radius.
const MOST_HALF_SINE: f64 = 0.85;
/// Shortest distance of the ends of an arc, mm.
const SHORTEST_MM: f64 = 0.01;
/// Motion outside the plane that is rounding noise, mm and rad.
const SAME_LEVEL: f64 = 1e-9;

/// A piece of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec) struct CurvePiece {
    /// Its end.
    pub(in crate::exec) target: AxisVector,
    /// Direction and center of an arc in the plane: clockwise about its normal, plane coordinates; `None` for a straight piece.
    pub(in crate::exec) arc: Option<(bool, [f64; 2])>,
    /// Largest distance from the curve, mm.
    pub(in crate::exec) off_mm: f64,
}

/// The curvature of a piece between two places, 1/mm; counter-clockwise is positive, 0 is straight.
#[derive(Clone, Copy, Debug)]
struct ArcFit {
    last: usize,
    curvature: f64,
}

/// Calls `out` with the pieces of a curve that its chords from `start` to `ends` state within a tolerance.
pub(in crate::exec) fn pieces(
    start: &AxisVector,
    ends: &[AxisVector],
    basis: &PlaneBasis,
    tolerance_mm: f64,
    mut out: impl FnMut(CurvePiece),
) {
    let curve = ChordEnds::new(start, ends, basis, tolerance_mm);
    let mut first = 0;
    while first < ends.len() {
        let fit = curve.longest(first).unwrap_or(ArcFit { last: first + 1, curvature: 0.0 });
        let Some(&target) = ends.get(fit.last - 1) else { return };
        let off_mm = (first..fit.last)
            .map(|k| {
                let sag_mm = 0.125 * curve.chord_mm(k).powi(2) * fit.curvature.abs();
                let off_mm = curve.off_mm(first, &fit, k).max(curve.off_mm(first, &fit, k + 1));
                off_mm + (sagitta::off_mm(start, ends, k, tolerance_mm) - sag_mm).abs()
            })
            .fold(0.0, f64::max);
        let arc = curve.center(first, &fit).map(|center| (fit.curvature < 0.0, center));
        out(CurvePiece { target, arc, off_mm });
        first = fit.last;
    }
}

/// Places of a curve in the plane.
struct ChordEnds {
    points: Vec<[f64; 2]>,
    /// Number of chords from each place on that stay in the plane.
    level: Vec<usize>,
    tolerance_mm: f64,
}

impl ChordEnds {
    fn new(start: &AxisVector, ends: &[AxisVector], basis: &PlaneBasis, tolerance_mm: f64) -> ChordEnds {
        let places: Vec<&AxisVector> = std::iter::once(start).chain(ends).collect();
        let points: Vec<[f64; 2]> = places.iter().map(|place| basis.flat(place)).collect();
        let mut level = vec![0; places.len()];
        for (k, pair) in places.windows(2).enumerate().rev() {
            let way = *pair[1] - *pair[0];
            let turns = AXES.into_iter().skip(3).any(|axis| way[axis] != 0.0);
            if !turns && (basis.height(pair[1]) - basis.height(pair[0])).abs() <= SAME_LEVEL {
                level[k] = level[k + 1] + 1;
            }
        }
        ChordEnds { points, level, tolerance_mm }
    }

    /// The longest piece from a place on that replaces more than one chord.
    fn longest(&self, first: usize) -> Option<ArcFit> {
        let most = first + self.level[first];
        let mut best = self.fit(first, first + 2).filter(|_| first + 2 <= most)?;
        let mut beyond = most + 1;
        while best.last < most {
            let next = (first + 2 * (best.last - first)).min(most);
            let Some(found) = self.fit(first, next) else {
                beyond = next;
                break;
            };
            best = found;
        }
        while best.last + 1 < beyond {
            let middle = best.last.midpoint(beyond);
            match self.fit(first, middle) {
                Some(found) => best = found,
                None => beyond = middle,
            }
        }
        Some(best)
    }

    /// The piece between two places whose distance from all places between is within the tolerance.
    fn fit(&self, first: usize, last: usize) -> Option<ArcFit> {
        let within = self.points.get(first..=last)?;
        let (from, to) = (within[0], within[last - first]);
        let chord_mm = distance(from, to);
        if chord_mm < SHORTEST_MM {
            return None;
        }
        let allowed_mm = FIT_SHARE * self.tolerance_mm;
        let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
        for near in within.windows(3) {
            let along = [near[2][0] - near[0][0], near[2][1] - near[0][1]];
            let size = along[0].hypot(along[1]);
            if size == 0.0 {
                return None;
            }
            let aside = [-along[1] / size * allowed_mm, along[0] / size * allowed_mm];
            let bend = |sign: f64| curvature(from, [near[1][0] + sign * aside[0], near[1][1] + sign * aside[1]], to);
            let (one, other) = (bend(1.0)?, bend(-1.0)?);
            least = least.max(one.min(other));
            most = most.min(one.max(other));
            // The ends bound a short arc.
            let share = dot([near[1][0] - from[0], near[1][1] - from[1]], [to[0] - from[0], to[1] - from[1]]);
            if least > most || !(0.0..=chord_mm * chord_mm).contains(&share) {
                return None;
            }
        }
        let middle = least.midpoint(most);
        let is_straight = least <= 0.0 && most >= 0.0 || middle.abs() * MOST_RADIUS_MM < 1.0;
        let fit = ArcFit { last, curvature: if is_straight { 0.0 } else { middle } };
        let is_short = 0.5 * chord_mm * middle.abs() <= MOST_HALF_SINE;
        let allowed_sag_mm = SAG_SHARE * self.tolerance_mm;
        let follows = |k: usize| {
            let sag_mm = 0.125 * self.chord_mm(k).powi(2) * fit.curvature.abs();
            sag_mm <= allowed_sag_mm && self.off_mm(first, &fit, k) <= self.tolerance_mm
        };
        (is_short && (first..last).all(follows)).then_some(fit)
    }

    /// Length of a chord, mm.
    fn chord_mm(&self, k: usize) -> f64 {
        self.points.get(k..=k + 1).map_or(0.0, |ends| distance(ends[0], ends[1]))
    }

    /// Center of a piece, if it is an arc.
    fn center(&self, first: usize, fit: &ArcFit) -> Option<[f64; 2]> {
        let (from, to) = (*self.points.get(first)?, *self.points.get(fit.last)?);
        if fit.curvature == 0.0 {
            return None;
        }
        let (radius_mm, half_mm) = (1.0 / fit.curvature.abs(), 0.5 * distance(from, to));
        let height_mm = (radius_mm * radius_mm - half_mm * half_mm).max(0.0).sqrt().copysign(fit.curvature);
        let left = [-(to[1] - from[1]) / (2.0 * half_mm), (to[0] - from[0]) / (2.0 * half_mm)];
        Some([0, 1].map(|axis: usize| from[axis].midpoint(to[axis]) + height_mm * left[axis]))
    }

    /// Distance of a place from a piece, mm.
    fn off_mm(&self, first: usize, fit: &ArcFit, place: usize) -> f64 {
        let Some(&point) = self.points.get(place) else { return 0.0 };
        if let Some(center) = self.center(first, fit) {
            return (distance(point, center) - 1.0 / fit.curvature.abs()).abs();
        }
        let (Some(&from), Some(&to)) = (self.points.get(first), self.points.get(fit.last)) else { return 0.0 };
        let chord_mm = distance(from, to);
        if chord_mm == 0.0 { 0.0 } else { cross(from, point, to).abs() / chord_mm }
    }
}

/// Curvature of the circle through three places, 1/mm; `None` if two of them coincide.
fn curvature(from: [f64; 2], by: [f64; 2], to: [f64; 2]) -> Option<f64> {
    let sides = distance(from, by) * distance(by, to) * distance(from, to);
    (sides > 0.0).then(|| 2.0 * cross(from, by, to) / sides)
}

/// Twice the area of the triangle of three places: positive if they are counter-clockwise.
fn cross(from: [f64; 2], by: [f64; 2], to: [f64; 2]) -> f64 {
    (by[0] - from[0]) * (to[1] - by[1]) - (by[1] - from[1]) * (to[0] - by[0])
}

fn dot(one: [f64; 2], other: [f64; 2]) -> f64 {
    one[0] * other[0] + one[1] * other[1]
}

fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::{Axis, Plane};

    const TOLERANCE_MM: f64 = 2.5e-4;

    fn at(x: f64, y: f64) -> AxisVector {
        AxisVector([x, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    fn found(points: &[AxisVector]) -> Vec<CurvePiece> {
        let mut found = Vec::new();
        pieces(&points[0], &points[1..], &PlaneBasis::Principal(Plane::XY), TOLERANCE_MM, |piece| found.push(piece));
        found
    }

    #[test]
    fn a_circle_is_a_few_arcs_about_its_center() {
        // R 20 mm from (20, 0), clockwise: chords of 0.5 degrees have a sagitta of 20 (1 − cos 0.25°) = 0.19 µm.
        let points: Vec<AxisVector> = (0..=400)
            .map(|k| (-0.5 * f64::from(k)).to_radians().sin_cos())
            .map(|(y, x)| at(20.0 * x, 20.0 * y))
            .collect();
        let found = found(&points);
        assert!(found.len() <= 3, "{}", found.len());
        for piece in &found {
            let (clockwise, center) = piece.arc.unwrap();
            assert!(clockwise && center[0].hypot(center[1]) < 0.01, "{piece:?}");
            assert!(piece.off_mm < TOLERANCE_MM, "{piece:?}");
        }
        assert_eq!(found.last().unwrap().target, points[400]);
    }

    #[test]
    fn a_parabola_is_within_the_tolerance_by_dense_samples() {
        // y = x²/40 from 0 to 40: the sagitta of a chord of 0.2 mm is 0.2² / (8 · 20) = 0.25 µm at most.
        let on = |x: f64| [x, x * x / 40.0];
        let points: Vec<AxisVector> = (0..=200).map(|k| on(0.2 * f64::from(k))).map(|[x, y]| at(x, y)).collect();
        let found = found(&points);
        assert!(found.len() < 30, "{}", found.len());
        let mut from = 0.0;
        for piece in &found {
            let to = piece.target[Axis::X];
            let (clockwise, center) = piece.arc.unwrap();
            assert!(!clockwise);
            let radius = distance(center, on(to));
            for k in 0..=100 {
                let off = (distance(center, on(from + (to - from) * f64::from(k) / 100.0)) - radius).abs();
                assert!(off <= piece.off_mm + 1e-6 && piece.off_mm < 2.0 * TOLERANCE_MM, "{off} {piece:?}");
            }
            from = to;
        }
    }

    #[test]
    fn corners_heights_and_lines_stay() {
        let corner = [at(0.0, 0.0), at(5.0, 0.0), at(5.0, 5.0)];
        assert!(found(&corner).iter().all(|piece| piece.arc.is_none()));
        assert_eq!(found(&corner).len(), 2);
        let line: Vec<AxisVector> = (0..=20).map(|k| at(f64::from(k), 0.5 * f64::from(k))).collect();
        assert_eq!(found(&line).len(), 1);
        let mut rising = line;
        for (k, point) in rising.iter_mut().enumerate() {
            point[Axis::Z] = k as f64;
        }
        assert_eq!(found(&rising).len(), 20);
    }
}
