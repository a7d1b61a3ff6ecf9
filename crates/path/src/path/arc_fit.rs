//! The circle through two given points that is nearest to other points: least squares of the radial distances.
//!
//! Between two different points the center has one degree of freedom, its place on their perpendicular bisector. A full circle, whose ends coincide,
//! has two. The radius is the distance of the center from the start in both cases, so the residuals are f = |p − c| − |s − c| with ∂f/∂c = u(s) −
//! u(p), u(x) = (x − c) / |x − c|; Gauss–Newton.

/// Distance below which start and end are one point, mm.
const SAME_POINT_MM: f64 = 1e-9;
/// Weight of the initial guess, per point. If the points do not determine the center, as on a short arc, a center 20 µm off costs as much as points
/// 0.1 µm off.
const STAY: f64 = 2.5e-5;
/// Number of iterations. The problem is nearly linear: the guess is off by micrometers.
const STEPS: usize = 4;

/// The center, in the plane of the points, mm.
pub(super) fn center(start: [f64; 2], end: [f64; 2], guess: [f64; 2], points: &[[f64; 2]]) -> [f64; 2] {
    let chord = [end[0] - start[0], end[1] - start[1]];
    let length = chord[0].hypot(chord[1]);
    let stay = STAY * points.len().max(1) as f64;
    if length < SAME_POINT_MM {
        return of_full_circle(start, guess, points, stay);
    }
    let along = [-chord[1] / length, chord[0] / length];
    let middle = [start[0].midpoint(end[0]), start[1].midpoint(end[1])];
    let at = |offset: f64| [middle[0] + offset * along[0], middle[1] + offset * along[1]];
    let guessed = (guess[0] - middle[0]) * along[0] + (guess[1] - middle[1]) * along[1];
    let mut offset = guessed;
    for _ in 0..STEPS {
        let center = at(offset);
        let (mut slope, mut curvature) = (stay * (offset - guessed), stay);
        for &point in points {
            let (residual, gradient) = residual(start, center, point);
            let derivative = gradient[0] * along[0] + gradient[1] * along[1];
            slope += residual * derivative;
            curvature += derivative * derivative;
        }
        offset -= slope / curvature;
    }
    at(offset)
}

fn of_full_circle(start: [f64; 2], guess: [f64; 2], points: &[[f64; 2]], stay: f64) -> [f64; 2] {
    let mut center = guess;
    for _ in 0..STEPS {
        let mut right = [stay * (center[0] - guess[0]), stay * (center[1] - guess[1])];
        let (mut xx, mut xy, mut yy) = (stay, 0.0, stay);
        for &point in points {
            let (residual, gradient) = residual(start, center, point);
            right[0] += residual * gradient[0];
            right[1] += residual * gradient[1];
            xx += gradient[0] * gradient[0];
            xy += gradient[0] * gradient[1];
            yy += gradient[1] * gradient[1];
        }
        let determinant = xx * yy - xy * xy;
        center[0] -= (yy * right[0] - xy * right[1]) / determinant;
        center[1] -= (xx * right[1] - xy * right[0]) / determinant;
    }
    center
}

/// Distance of a point from the circle, and its derivative with respect to the center.
fn residual(start: [f64; 2], center: [f64; 2], point: [f64; 2]) -> (f64, [f64; 2]) {
    let from_center = |p: [f64; 2]| {
        let across = [p[0] - center[0], p[1] - center[1]];
        let distance = across[0].hypot(across[1]);
        (distance, [across[0] / distance, across[1] / distance])
    };
    let (radius, to_start) = from_center(start);
    let (distance, to_point) = from_center(point);
    (distance - radius, [to_start[0] - to_point[0], to_start[1] - to_point[1]])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on(center: [f64; 2], radius: f64, angle: f64) -> [f64; 2] {
        [center[0] + radius * angle.cos(), center[1] + radius * angle.sin()]
    }

    fn is_near(found: [f64; 2], expected: [f64; 2], within: f64) -> bool {
        (found[0] - expected[0]).hypot(found[1] - expected[1]) < within
    }

    #[test]
    fn points_of_a_circle_give_its_center() {
        let truth = [12.0, -7.0];
        let points: Vec<_> = (1..12).map(|k| on(truth, 25.0, 0.4 * f64::from(k))).collect();
        let guess = [12.02, -6.99];
        let found = center(on(truth, 25.0, 0.0), on(truth, 25.0, 5.0), guess, &points);
        assert!(is_near(found, truth, 1e-4), "{found:?}");
        let full = center(on(truth, 25.0, 0.0), on(truth, 25.0, 0.0), guess, &points);
        assert!(is_near(full, truth, 1e-4), "{full:?}");
    }

    #[test]
    fn the_center_stays_on_the_bisector() {
        let (start, end) = ([0.0, 0.0], [10.0, 0.0]);
        let found = center(start, end, [5.3, -20.0], &[[5.0, 0.62], [2.0, 0.39]]);
        assert!((found[0] - 5.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn a_short_arc_with_rounded_ends_keeps_its_center() {
        // 0.2 mm of a circle of 50 mm: the sagitta is 0.1 µm, the rounding of the ends 0.05 µm.
        let truth = [0.0, 0.0];
        let lifted = |angle: f64| on(truth, 50.000_05, angle);
        let points = [on(truth, 50.0, 0.001), on(truth, 50.0, 0.002), on(truth, 50.0, 0.003)];
        let found = center(lifted(0.0), lifted(0.004), truth, &points);
        assert!(is_near(found, truth, 0.02), "{found:?}");
    }
}
