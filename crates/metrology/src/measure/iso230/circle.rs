//! Circular tests (ISO 230-4): figures of the paths of a ball-bar, one clockwise and one counterclockwise.
//!
//! | figure | meaning |
//! | --- | --- |
//! | G | circular deviation: width of the minimum zone of one path |
//! | G(b) | circular deviation of both paths together |
//! | F | radial deviation: extreme distances of a path from the nominal circle about the common least-squares center (no set-up eccentricity) |
//! | D | mean bidirectional radial deviation: middle of the largest and smallest distance of the mean of both paths from the nominal circle |
//! | H | hysteresis: largest distance between the two paths at one angle |

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use super::zone::minimum_zone;

/// Number of angles for comparing two paths: steps of 0.1°.
const STEPS: usize = 3600;
/// Gap above which a path is not interpolated, rad.
const GAP: f64 = 0.1;
/// Iterations of the least-squares center; the error of each is the square of the last shift.
const ROUNDS: usize = 6;

/// A reading of a ball-bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CirclePoint {
    /// Angle on the nominal circle, rad.
    pub angle: f64,
    /// Measured minus nominal radius, mm.
    pub deviation_mm: f64,
}

/// The figures, mm; `None` for those of a missing path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CircleFigures {
    /// Circular deviation of the counterclockwise path.
    pub g_counter: Option<f64>,
    /// Circular deviation of the clockwise path.
    pub g_clock: Option<f64>,
    /// Circular deviation of both paths.
    pub g_both: Option<f64>,
    /// Largest and smallest radial deviation of the counterclockwise path.
    pub f_counter: Option<[f64; 2]>,
    /// Largest and smallest radial deviation of the clockwise path.
    pub f_clock: Option<[f64; 2]>,
    /// Mean bidirectional radial deviation.
    pub d: Option<f64>,
    /// Hysteresis.
    pub h: Option<f64>,
    /// Eccentricity of the set-up, which is removed from F, D and H.
    pub centre_mm: [f64; 2],
}

/// The figures of two paths on a circle of a radius; a path that was not measured is empty. `None` if neither is a circle.
#[must_use]
pub fn figures(radius_mm: f64, counter: &[CirclePoint], clock: &[CirclePoint]) -> Option<CircleFigures> {
    let place = |point: &CirclePoint| {
        let radius = radius_mm + point.deviation_mm;
        [radius * point.angle.cos(), radius * point.angle.sin()]
    };
    let [counter, clock] = [counter, clock].map(|path| path.iter().map(place).collect::<Vec<_>>());
    let both: Vec<[f64; 2]> = counter.iter().chain(&clock).copied().collect();
    let centre_mm = centre(&both)?;
    let g = |points: &[[f64; 2]]| minimum_zone(points).map(|zone| zone.width());
    let about = |points: &[[f64; 2]]| -> Vec<CirclePoint> {
        let own = |&[x, y]: &[f64; 2]| {
            let [dx, dy] = [x - centre_mm[0], y - centre_mm[1]];
            CirclePoint { angle: dy.atan2(dx).rem_euclid(TAU), deviation_mm: dx.hypot(dy) - radius_mm }
        };
        points.iter().map(own).collect()
    };
    let f =
        |points: &[[f64; 2]]| (!points.is_empty()).then(|| ends(about(points).iter().map(|point| point.deviation_mm)));
    let [one, other] = [&counter, &clock].map(|points| resampled(about(points)));
    let pairs: Vec<[f64; 2]> = one.iter().zip(&other).filter_map(|(one, other)| Some([(*one)?, (*other)?])).collect();
    let has_pairs = !pairs.is_empty();
    Some(CircleFigures {
        g_counter: g(&counter),
        g_clock: g(&clock),
        g_both: (!counter.is_empty() && !clock.is_empty()).then(|| g(&both)).flatten(),
        f_counter: f(&counter),
        f_clock: f(&clock),
        d: has_pairs.then(|| 0.5 * ends(pairs.iter().map(|[one, other]| 0.5 * (one + other))).iter().sum::<f64>()),
        h: has_pairs.then(|| pairs.iter().fold(0.0, |most: f64, [one, other]| most.max((one - other).abs()))),
        centre_mm,
    })
}

/// The center with the least squares of the radius differences.
fn centre(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let mut centre = minimum_zone(points)?.centre;
    for _ in 0..ROUNDS {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for &[x, y] in points {
            let [dx, dy] = [x - centre[0], y - centre[1]];
            let radius = dx.hypot(dy);
            let row = Vector3::new(dx / radius, dy / radius, 1.0);
            normal += row * row.transpose();
            right += row * radius;
        }
        let shift = normal.lu().solve(&right)?;
        centre = [centre[0] + shift[0], centre[1] + shift[1]];
    }
    centre.iter().all(|value| value.is_finite()).then_some(centre)
}

/// Largest and smallest value.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::NEG_INFINITY, f64::INFINITY], |[high, low], value| [high.max(value), low.min(value)])
}

/// A path at equidistant angles, linear between readings; `None` in gaps.
fn resampled(mut points: Vec<CirclePoint>) -> Vec<Option<f64>> {
    points.sort_by(|one, other| one.angle.total_cmp(&other.angle));
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else { return vec![None; STEPS] };
    // Periodic continuation.
    points.insert(0, CirclePoint { angle: last.angle - TAU, ..last });
    points.push(CirclePoint { angle: first.angle + TAU, ..first });
    (0..STEPS)
        .map(|step| {
            let angle = TAU * step as f64 / STEPS as f64;
            let after = points.partition_point(|point| point.angle < angle).max(1);
            let (before, after) = (points.get(after - 1)?, points.get(after)?);
            let gap = after.angle - before.angle;
            let share = if gap > 0.0 { (angle - before.angle) / gap } else { 0.0 };
            (gap <= GAP).then_some(before.deviation_mm + share * (after.deviation_mm - before.deviation_mm))
        })
        .collect()
}
