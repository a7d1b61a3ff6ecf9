//! The least-squares sphere through points: size and form (Esmaeili 2021, ch. 4.7).
//!
//! | figure | meaning |
//! | --- | --- |
//! | size | radius of the fitted minus that of the nominal sphere |
//! | form | largest minus smallest distance of the points from the fitted sphere |
//! | s | standard deviation of these distances |

use nalgebra::{Matrix4, Vector4};

use ncfix_base::geometry::Vector;

/// Iterations; the error of each is the square of the last shift.
const ROUNDS: usize = 8;
/// Ratio of smallest to largest eigenvalue of the equations below which points are coplanar.
const FLAT: f64 = 1e-6;

/// A fitted sphere, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its center.
    pub centre_mm: Vector,
    /// Its radius.
    pub radius_mm: f64,
    /// Largest minus smallest residual.
    pub form_mm: f64,
    /// Standard deviation of the residuals (n − 1).
    pub deviation_mm: f64,
}

/// Fits a sphere to points around a center near the origin; `None` if they are coplanar or too few.
#[must_use]
pub fn fit(points: &[Vector]) -> Option<Sphere> {
    if points.len() < 5 {
        return None;
    }
    let count = points.len() as f64;
    let mut centre = Vector::zeros();
    let mut radius = points.iter().map(|point| point.norm()).sum::<f64>() / count;
    for round in 0..ROUNDS {
        let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
        for point in points {
            let from = point - centre;
            let distance = from.norm();
            if !(distance > 0.0 && distance.is_finite()) {
                return None;
            }
            let row = (from / distance).push(1.0);
            normal += row * row.transpose();
            right += row * (distance - radius);
        }
        if round == 0 {
            let values = normal.symmetric_eigenvalues();
            if values.min() <= FLAT * values.max() {
                return None;
            }
        }
        let step = normal.cholesky()?.solve(&right);
        centre += step.xyz();
        radius += step.w;
    }
    let residuals = || points.iter().map(|point| (point - centre).norm() - radius);
    let [low, high] = residuals().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], r| [low.min(r), high.max(r)]);
    let mean = residuals().sum::<f64>() / count;
    let squares = residuals().map(|residual| (residual - mean).powi(2)).sum::<f64>();
    let deviation_mm = (squares / (count - 1.0)).sqrt();
    let sphere = Sphere { centre_mm: centre, radius_mm: radius, form_mm: high - low, deviation_mm };
    (radius.is_finite() && centre.iter().all(|value| value.is_finite())).then_some(sphere)
}
