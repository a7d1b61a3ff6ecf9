//! The minimum zone: two concentric circles of least difference that enclose the points between them, exactly.
//!
//! Near the center the radii are linear in its shift, and the best shift is a Chebyshev problem with three unknowns. It is solved by exchange: the
//! best circle for four points has residuals of alternating ±h. The farthest point then replaces the one of the four that makes h grow most. h grows
//! with every step until no point is farther off than h, which is the optimum; then the radii are recomputed about the shifted center. The last
//! circle is optimal for its own linear problem, whose error is of second order in a shift that is then zero.

use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// Maximum number of exchanges.
const EXCHANGES: usize = 500;
/// Maximum number of center shifts; each is smaller than the square of the last one.
const SHIFTS: usize = 30;

/// Two concentric circles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Their center.
    pub centre: [f64; 2],
    /// Radius of the smaller one and of the larger one.
    pub radii: [f64; 2],
}

impl Zone {
    /// Difference of the radii.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.radii[1] - self.radii[0]
    }
}

/// The minimum zone of points on an approximate circle; `None` for fewer than four points, or points that do not determine a center.
#[must_use]
pub fn minimum_zone(points: &[[f64; 2]]) -> Option<Zone> {
    let mut centre = mean_circle(points)?;
    let scale = points.iter().flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
    let mut zone = around(points, centre);
    for _ in 0..SHIFTS {
        let rows: Vec<(Vector3<f64>, f64)> = points
            .iter()
            .map(|&[x, y]| {
                let [dx, dy] = [x - centre[0], y - centre[1]];
                let radius = dx.hypot(dy);
                (Vector3::new(dx / radius, dy / radius, 1.0), radius)
            })
            .collect();
        if rows.iter().any(|(row, _)| !row.iter().all(|value| value.is_finite())) {
            return None;
        }
        let shift = chebyshev(&rows)?;
        let next = [centre[0] + shift[0], centre[1] + shift[1]];
        let found = around(points, next);
        let is_there = shift[0].hypot(shift[1]) <= 1e-14 * scale;
        if found.width() <= zone.width() {
            zone = found;
        }
        if is_there || !found.width().is_finite() {
            break;
        }
        centre = next;
    }
    zone.width().is_finite().then_some(zone)
}

/// The circles about a center.
fn around(points: &[[f64; 2]], centre: [f64; 2]) -> Zone {
    let radii = points.iter().map(|&[x, y]| (x - centre[0]).hypot(y - centre[1]));
    let ends = radii.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], r| [low.min(r), high.max(r)]);
    Zone { centre, radii: ends }
}

/// The center of the circle with the least squares of x² + y² − 2ax − 2by − c.
fn mean_circle(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    if points.len() < 4 {
        return None;
    }
    let count = points.len() as f64;
    let middle = [0, 1].map(|k| points.iter().map(|point| point[k]).sum::<f64>() / count);
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for &[x, y] in points {
        let row = Vector3::new(x - middle[0], y - middle[1], 1.0);
        normal += row * row.transpose();
        right += row * (row[0] * row[0] + row[1] * row[1]);
    }
    let solution = normal.lu().solve(&right)?;
    let centre = [middle[0] + 0.5 * solution[0], middle[1] + 0.5 * solution[1]];
    centre.iter().all(|value| value.is_finite()).then_some(centre)
}

/// The unknowns that minimize the largest |value − row · unknowns|.
fn chebyshev(rows: &[(Vector3<f64>, f64)]) -> Option<Vector3<f64>> {
    let last = rows.len().checked_sub(1)?;
    // Four directions around the circle: rows of several circles one after the other may have few directions at equal distances.
    let mut around: Vec<usize> = (0..rows.len()).collect();
    let angle = |index: usize| rows.get(index).map_or(0.0, |(row, _)| row.y.atan2(row.x));
    around.sort_by(|one, other| angle(*one).total_cmp(&angle(*other)));
    let mut chosen = [0, last / 4, last / 2, last * 3 / 4].map(|place| around.get(place).copied().unwrap_or(0));
    let (mut best, mut height) = levelled(rows, chosen)?;
    for _ in 0..EXCHANGES {
        let off = |&(_, (row, value)): &(usize, &(Vector3<f64>, f64))| (value - row.dot(&best)).abs();
        let far = rows.iter().enumerate().max_by(|one, other| off(one).total_cmp(&off(other)))?;
        if off(&far) <= height * (1.0 + 1e-12) + 1e-15 {
            break;
        }
        let tried = (0..4).filter_map(|place| {
            let mut other = chosen;
            other[place] = far.0;
            levelled(rows, other).map(|(unknowns, height)| (other, unknowns, height))
        });
        let (other, unknowns, higher) = tried.max_by(|one, other| one.2.total_cmp(&other.2))?;
        if higher <= height {
            break;
        }
        (chosen, best, height) = (other, unknowns, higher);
    }
    Some(best)
}

/// The best unknowns for four rows and their common residual; `None` for linearly dependent rows.
fn levelled(rows: &[(Vector3<f64>, f64)], chosen: [usize; 4]) -> Option<(Vector3<f64>, f64)> {
    let mut four = [(Vector3::zeros(), 0.0); 4];
    for (slot, &index) in four.iter_mut().zip(&chosen) {
        *slot = *rows.get(index)?;
    }
    // Coefficients of the linear dependence of the rows: minors with alternating signs.
    let minor = |left_out: usize| {
        let kept: Vec<Vector3<f64>> = (0..4).filter(|&k| k != left_out).map(|k| four[k].0).collect();
        Matrix3::from_columns(&kept).determinant()
    };
    let factors = [minor(0), -minor(1), minor(2), -minor(3)];
    if factors.iter().map(|factor| factor.abs()).sum::<f64>() < 1e-12 {
        return None;
    }
    // A row with factor 0 does not affect the level: either sign is correct.
    let signs = factors.map(|factor| if factor < 0.0 { -1.0 } else { 1.0 });
    let matrix = Matrix4::from_fn(|i, k| if k < 3 { four[i].0[k] } else { signs[i] });
    let solution = matrix.lu().solve(&Vector4::from_fn(|i, _| four[i].1))?;
    Some((Vector3::new(solution[0], solution[1], solution[2]), solution[3].abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two circles one way and two back, 100 mm with 2 µm · cos 2θ: their zone has the width 4 µm.
    #[test]
    fn several_circles_in_sequence_have_a_zone() {
        let circle = |index: usize| {
            let angle = (2.5 + 5.0 * index as f64).to_radians();
            let radius = 100.0 + 0.002 * (2.0 * angle).cos();
            [radius * angle.cos(), radius * angle.sin()]
        };
        let there: Vec<[f64; 2]> = (0..72).map(circle).collect();
        let back: Vec<[f64; 2]> = there.iter().rev().copied().collect();
        let all = [there.clone(), there, back.clone(), back].concat();
        let width = minimum_zone(&all).unwrap().width();
        // The readings lie 2.5° beside the extremes.
        assert!((width - 0.004 * 5.0_f64.to_radians().cos()).abs() < 1e-9, "{width}");
    }
}
