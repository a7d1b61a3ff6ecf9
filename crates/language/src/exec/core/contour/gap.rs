//! The smallest distance between two curves of a plane.

use super::curve::{Curve, Flat, add, dot, left, scaled, sub, unit};

/// Rounding error of a point beyond the ends of a curve, mm.
const ROUNDING_MM: f64 = 1e-9;
/// Points nearer to each other than this are intended to be equal, mm.
const SAME_POINT_MM: f64 = 5e-3;

impl Curve {
    /// The smallest distance between two curves between their ends, or `most` if that is smaller.
    pub(super) fn gap(&self, other: &Curve, most: f64) -> f64 {
        let ((low, high), (other_low, other_high)) = (self.bounds(), other.bounds());
        if (0..2).any(|k| low[k] - other_high[k] >= most || other_low[k] - high[k] >= most) {
            return most;
        }
        let mut smallest = most;
        let mut consider = |point: Flat| {
            if self.distance(point) < ROUNDING_MM {
                smallest = smallest.min(other.distance(point));
            }
        };
        // At the smallest distance, one of the points is an end, or the common normal passes through the centers.
        for point in [self.start(), self.end()].into_iter().chain(self.crossings(other).iter()) {
            consider(point);
        }
        for point in [other.start(), other.end()].into_iter().chain(other.center()) {
            for foot in self.feet(point) {
                consider(foot);
            }
        }
        if let (Curve::Arc { center, radius, .. }, Curve::Line { start, end }) = (*self, *other) {
            let normal = scaled(left(unit(sub(end, start))), radius);
            consider(add(center, normal));
            consider(sub(center, normal));
        }
        smallest
    }

    fn center(&self) -> Option<Flat> {
        match *self {
            Curve::Line { .. } => None,
            Curve::Arc { center, .. } => Some(center),
        }
    }

    /// Foot points of the normals through a point, also beyond the ends of the curve.
    fn feet(&self, point: Flat) -> [Flat; 2] {
        match *self {
            Curve::Line { start, end } => {
                let direction = unit(sub(end, start));
                [add(start, scaled(direction, dot(sub(point, start), direction))); 2]
            }
            Curve::Arc { center, radius, .. } => {
                let towards = scaled(unit(sub(point, center)), radius);
                [add(center, towards), sub(center, towards)]
            }
        }
    }

    /// Corners of a rectangle around the curve.
    fn bounds(&self) -> (Flat, Flat) {
        match *self {
            Curve::Line { start: [a, b], end: [c, d] } => ([a.min(c), b.min(d)], [a.max(c), b.max(d)]),
            Curve::Arc { center: [x, y], radius, .. } => ([x - radius, y - radius], [x + radius, y + radius]),
        }
    }

    /// `true` if the curve passes through a point, within the decimals of a program.
    pub(super) fn passes(&self, point: Flat) -> bool {
        self.distance(point) < SAME_POINT_MM
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn gaps_are_those_of_many_points() {
        // Pseudo-random numbers from the golden ratio.
        let mut state = 0.5_f64;
        let mut next = |low: f64, high: f64| {
            state = (state + 0.618_033_988_749_895).fract();
            let mixed = (state * 7919.0 + (state * 104_729.0).sin()).rem_euclid(1.0);
            low + (high - low) * mixed
        };
        let mut curve = |k: u32| {
            if k == 0 {
                Curve::Line { start: [next(-9.0, 9.0), next(-9.0, 9.0)], end: [next(-9.0, 9.0), next(-9.0, 9.0)] }
            } else {
                let center = [next(-9.0, 9.0), next(-9.0, 9.0)];
                Curve::Arc { center, radius: next(0.5, 6.0), from: next(0.0, TAU), sweep: next(-TAU, TAU) }
            }
        };
        for round in 0..400 {
            let (a, b) = (curve(round % 2), curve(round / 2 % 2));
            let sampled =
                (0..=400).map(|k| b.distance(a.at(a.length() * f64::from(k) / 400.0))).fold(f64::INFINITY, f64::min);
            let gap = a.gap(&b, 1e3);
            // Between two sample points the distance changes by at most half their spacing.
            assert!(gap <= sampled + 1e-9 && gap >= sampled - a.length() / 800.0 - 1e-9, "{gap} {sampled} {a:?} {b:?}");
            assert!((gap - b.gap(&a, 1e3)).abs() < 1e-7, "{a:?} {b:?}");
            assert!((a.gap(&b, 1.0) - gap.min(1.0)).abs() < 1e-12);
        }
    }
}
