//! Circular tests (ISO 230-4): figures of the paths of a ball-bar, one clockwise and one the other way round.
//!
//! | figure | what it is |
//! | --- | --- |
//! | G | circular deviation: width of the minimum zone of one path |
//! | G(b) | the same of both paths together |
//! | F | radial deviation: largest and smallest distance of a path from the nominal circle, about the centre that both paths have together (least squares): the eccentricity of the set-up is none of the machine |
//! | D | mean bidirectional radial deviation: middle of the largest and smallest distance of the mean of both paths from the nominal circle |
//! | H | hysteresis: largest distance between the two paths at one angle |

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use super::zone::minimum_zone;

/// Steps of the grid on which two paths are compared: 0.1°.
const STEPS: usize = 3600;
/// A path with a larger gap has no value in between, rad.
const GAP: f64 = 0.1;
/// Rounds of the centre by least squares; each is exact to the square of the last shift.
const ROUNDS: usize = 6;

/// A reading of a ball-bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CirclePoint {
    /// Angle on the nominal circle, rad.
    pub angle: f64,
    /// Measured less nominal radius, mm.
    pub deviation_mm: f64,
}

/// The figures; those of a path that there is not are `None`. mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CircleFigures {
    /// Circular deviation of the path against the clock.
    pub g_counter: Option<f64>,
    /// Circular deviation of the path with the clock.
    pub g_clock: Option<f64>,
    /// Of both.
    pub g_both: Option<f64>,
    /// Largest and smallest radial deviation of the path against the clock.
    pub f_counter: Option<[f64; 2]>,
    /// Largest and smallest radial deviation of the path with the clock.
    pub f_clock: Option<[f64; 2]>,
    /// Mean bidirectional radial deviation.
    pub d: Option<f64>,
    /// Hysteresis.
    pub h: Option<f64>,
    /// Eccentricity of the set-up, which F, D and H are free of.
    pub centre_mm: [f64; 2],
}

/// The figures of two paths on a circle of a radius; an empty one was not measured. `None` where neither is a circle.
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

/// The centre from which the squares of the differences of the radii are least.
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

/// Largest and smallest.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::NEG_INFINITY, f64::INFINITY], |[high, low], value| [high.max(value), low.min(value)])
}

/// A path at even angles, linear between readings; `None` in gaps.
fn resampled(mut points: Vec<CirclePoint>) -> Vec<Option<f64>> {
    points.sort_by(|one, other| one.angle.total_cmp(&other.angle));
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else { return vec![None; STEPS] };
    // Around the turn.
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
