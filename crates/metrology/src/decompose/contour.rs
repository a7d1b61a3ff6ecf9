//! The contouring error: distance of the tool from its path, not from its target position at that instant.
//!
//! A lag along the path does no harm; the relevant quantity is the distance at right angles (Andolfatto, Lavernhe and Mayer 2011, section 3.2 and
//! Fig. 4, after Sencer, Altintas and Croft 2009). It is measured in the workpiece frame, from the tip by the encoders to the nearest point of the
//! set-point path of the tip. The search covers only the neighboring part of the path, as a path may return to a position.

use ncfix_base::geometry::Vector;

/// The shortest vector from a path to a point: `path` are the path points by instants, `number` is the instant of the point, and the search covers
/// `window` instants on both sides.
#[must_use]
pub fn from_path(path: &[Vector], point: &Vector, number: usize, window: usize) -> Vector {
    let first = number.saturating_sub(window);
    let last = (number + window).min(path.len().saturating_sub(1));
    let part = path.get(first..=last).unwrap_or_default();
    let Some(&start) = part.first() else { return Vector::zeros() };
    let mut nearest = point - start;
    for ends in part.windows(2) {
        let along = ends[1] - ends[0];
        let square = along.norm_squared();
        let share = if square > 0.0 { ((point - ends[0]).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
        let off = point - (ends[0] + along * share);
        if off.norm_squared() < nearest.norm_squared() {
            nearest = off;
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_along_the_path_is_no_contouring_error() {
        let path: Vec<Vector> = (0..100).map(|k| Vector::new(f64::from(k), 0.0, 0.0)).collect();
        assert!(from_path(&path, &Vector::new(46.5, 0.0, 0.0), 50, 10).norm() < 1e-12);
        let off = from_path(&path, &Vector::new(46.5, 0.25, -0.5), 50, 10);
        assert!((off - Vector::new(0.0, 0.25, -0.5)).norm() < 1e-12);
        // Outside the window: from its end.
        let behind = from_path(&path, &Vector::new(30.0, 0.0, 0.0), 50, 10);
        assert!((behind - Vector::new(-10.0, 0.0, 0.0)).norm() < 1e-12);
    }

    #[test]
    fn in_a_corner_the_nearest_leg_counts() {
        // Along X to (10, 0), then along Y: a tool that cuts the corner by 0.3 in both directions.
        let path: Vec<Vector> =
            (0..=20)
                .map(|k| {
                    if k <= 10 {
                        Vector::new(f64::from(k), 0.0, 0.0)
                    } else {
                        Vector::new(10.0, f64::from(k - 10), 0.0)
                    }
                })
                .collect();
        let off = from_path(&path, &Vector::new(9.7, 0.4, 0.0), 10, 5);
        assert!((off - Vector::new(-0.3, 0.0, 0.0)).norm() < 1e-12, "{off}");
    }
}
