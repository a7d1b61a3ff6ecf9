//! Splines through points (Akima, cubic with continuous curvature) and B-splines, as Bézier curves.

use super::bezier::{Bezier, Weighted};
use super::{AXIS_COUNT, AxisVector};

/// End condition of a spline through points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SplineEnd {
    /// Zero curvature.
    Natural,
    /// Given derivative by the parameter.
    Tangent(AxisVector),
    /// Condition derived from the points.
    Automatic,
}

/// Returns the derivatives of an Akima spline at its points: `chords` are the slopes between the points by the parameter, `lengths` the steps of the
/// parameter (Akima 1970). Weights are lengths of vectors, so rotating the points rotates the curve.
#[must_use]
pub fn akima_slopes(chords: &[AxisVector], lengths: &[f64], ends: [SplineEnd; 2]) -> Vec<AxisVector> {
    let (Some(&first), Some(&last)) = (chords.first(), chords.last()) else { return Vec::new() };
    let second = *chords.get(1).unwrap_or(&first);
    let last_but_one = *chords.iter().rev().nth(1).unwrap_or(&last);
    // Two slopes beyond each end, as if a parabola continued.
    let before = sum(2.0, &first, -1.0, &second);
    let behind = sum(2.0, &last, -1.0, &last_but_one);
    let mut all = vec![sum(2.0, &before, -1.0, &first), before];
    all.extend_from_slice(chords);
    all.extend([behind, sum(2.0, &behind, -1.0, &last)]);
    let mut slopes: Vec<AxisVector> = all
        .windows(4)
        .map(|four| match four {
            [a, b, c, d] => {
                let (left, right) = (norm(&(*d - *c)), norm(&(*b - *a)));
                if left + right > 0.0 {
                    sum(left / (left + right), b, right / (left + right), c)
                } else {
                    sum(0.5, b, 0.5, c)
                }
            }
            _ => first,
        })
        .collect();
    // An end without curvature: 2 s0 + s1 = 3 m0.
    let natural = |chord: &AxisVector, neighbor: &AxisVector| sum(1.5, chord, -0.5, neighbor);
    let count = slopes.len();
    let known = |end: &SplineEnd, neighbor: Option<&AxisVector>, chord: &AxisVector| match end {
        SplineEnd::Natural => neighbor.map(|neighbor| natural(chord, neighbor)),
        SplineEnd::Tangent(tangent) => Some(*tangent),
        SplineEnd::Automatic => None,
    };
    let is_single = lengths.len() < 2;
    let [start, end] = &ends;
    let start = if is_single && *start == SplineEnd::Natural { None } else { known(start, slopes.get(1), &first) };
    if let (Some(slope), Some(place)) = (start, slopes.first_mut()) {
        *place = slope;
    }
    let end = known(end, count.checked_sub(2).and_then(|k| slopes.get(k)), &last);
    if let (Some(slope), Some(place)) = (end, slopes.last_mut()) {
        *place = slope;
    }
    slopes
}

/// Returns the derivatives at the points of the cubic spline with continuous curvature; see [`akima_slopes`] for the arguments. An automatic end has no knot
/// at the point next to it: one cubic passes through the first three points.
#[must_use]
pub fn cubic_slopes(chords: &[AxisVector], lengths: &[f64], ends: [SplineEnd; 2]) -> Vec<AxisVector> {
    let count = chords.len().min(lengths.len());
    let (Some(first), Some(last)) = (chords.first(), chords.last()) else { return Vec::new() };
    let [start, end] = ends.map(|end| if count < 2 && end == SplineEnd::Automatic { SplineEnd::Natural } else { end });
    if count == 2 && start == SplineEnd::Automatic && end == SplineEnd::Automatic {
        return parabola(chords, lengths);
    }
    // Rows of a tridiagonal system: below, on, above the diagonal, right side.
    let mut rows: Vec<(f64, f64, f64, AxisVector)> = Vec::with_capacity(count + 1);
    let automatic = |near: f64, far: f64, chord: &AxisVector, next: &AxisVector| {
        let both = near + far;
        let right = sum((near + 2.0 * both) * far / both, chord, near * near / both, next);
        (far, both, right)
    };
    rows.push(match (start, chords.get(1), lengths) {
        (SplineEnd::Tangent(tangent), ..) => (0.0, 1.0, 0.0, tangent),
        (SplineEnd::Automatic, Some(next), [near, far, ..]) => {
            let (on, above, right) = automatic(*near, *far, first, next);
            (0.0, on, above, right)
        }
        _ => (0.0, 2.0, 1.0, sum(3.0, first, 0.0, first)),
    });
    for (chord, length) in chords.windows(2).zip(lengths.windows(2)) {
        if let ([left, right], [before, behind]) = (chord, length) {
            rows.push((*behind, 2.0 * (before + behind), *before, sum(3.0 * behind, left, 3.0 * before, right)));
        }
    }
    let far = lengths.iter().rev().nth(1).zip(chords.iter().rev().nth(1));
    rows.push(match (end, far, lengths.last()) {
        (SplineEnd::Tangent(tangent), ..) => (0.0, 1.0, 0.0, tangent),
        (SplineEnd::Automatic, Some((far, next)), Some(near)) => {
            let (on, below, right) = automatic(*near, *far, last, next);
            (below, on, 0.0, right)
        }
        _ => (1.0, 2.0, 0.0, sum(3.0, last, 0.0, last)),
    });
    solve(rows)
}

/// Returns the slopes of the parabola through three points, if both ends are automatic.
fn parabola(chords: &[AxisVector], lengths: &[f64]) -> Vec<AxisVector> {
    let ([first, second], [before, behind]) = (chords, lengths) else { return Vec::new() };
    let both = before + behind;
    let middle = sum(behind / both, first, before / both, second);
    vec![sum(2.0, first, -1.0, &middle), middle, sum(2.0, second, -1.0, &middle)]
}

/// Solves the system by the Thomas algorithm; the rows are diagonally dominant, or nearly so at the ends.
fn solve(mut rows: Vec<(f64, f64, f64, AxisVector)>) -> Vec<AxisVector> {
    for k in 1..rows.len() {
        let (_, on, above, right) = rows[k - 1];
        let factor = rows[k].0 / on;
        rows[k].1 -= factor * above;
        rows[k].3 = sum(1.0, &rows[k].3, -factor, &right);
    }
    let mut next = AxisVector::ZERO;
    let mut slopes: Vec<AxisVector> = rows
        .iter()
        .rev()
        .map(|(_, on, above, right)| {
            next = sum(1.0 / on, right, -above / on, &next);
            next
        })
        .collect();
    slopes.reverse();
    slopes
}

/// B-spline that begins at its first and ends at its last control point, with equally spaced knots.
#[derive(Clone, Debug)]
pub struct BSpline {
    degree: usize,
    control: Vec<Weighted>,
}

impl BSpline {
    /// Creates a B-spline of degree 1 to 3, lower if there are too few control points; `None` with fewer than two.
    #[must_use]
    pub fn new(degree: usize, control: Vec<Weighted>) -> Option<BSpline> {
        let most = control.len().checked_sub(1)?;
        (most > 0).then(|| BSpline { degree: degree.clamp(1, 3).min(most), control })
    }

    /// Returns the number of polynomial pieces.
    #[must_use]
    pub fn pieces(&self) -> usize {
        self.control.len() - self.degree
    }

    /// Returns the curve between two parameters of one piece; parameters run from 0 to the number of pieces.
    #[must_use]
    pub fn part(&self, from: f64, to: f64) -> Option<Bezier> {
        let middle = 0.5 * (from + to);
        // In range by construction: there is at least one piece.
        let piece = (middle.floor().max(0.0) as usize).min(self.pieces() - 1);
        let control: Option<Vec<Weighted>> = (0..=self.degree)
            .map(|k| {
                let arguments: Vec<f64> = (0..self.degree).map(|j| if j < k { to } else { from }).collect();
                self.blossom(piece, &arguments)
            })
            .collect();
        Bezier::new(&control?)
    }

    /// Returns the polar form of a piece: one argument for every step of de Boor's algorithm.
    fn blossom(&self, piece: usize, arguments: &[f64]) -> Option<Weighted> {
        let degree = self.degree;
        let mut points: Vec<Weighted> = self.control.get(piece..=piece + degree)?.to_vec();
        for (level, argument) in arguments.iter().enumerate() {
            for k in (level + 1..=degree).rev() {
                let (low, high) = (self.knot(piece + k), self.knot(piece + k + degree - level));
                let share = (argument - low) / (high - low);
                let (a, b) = (*points.get(k - 1)?, *points.get(k)?);
                let mut out = [0.0; AXIS_COUNT + 1];
                for ((value, a), b) in out.iter_mut().zip(a).zip(b) {
                    *value = a + (b - a) * share;
                }
                *points.get_mut(k)? = out;
            }
        }
        points.last().copied()
    }

    /// Returns a knot: 0 at the start and the number of pieces at the end, degree + 1 times each.
    fn knot(&self, index: usize) -> f64 {
        index.saturating_sub(self.degree).min(self.pieces()) as f64
    }
}

fn sum(p: f64, a: &AxisVector, q: f64, b: &AxisVector) -> AxisVector {
    let mut out = *a;
    for (value, b) in out.0.iter_mut().zip(b.0) {
        *value = p * *value + q * b;
    }
    out
}

fn norm(vector: &AxisVector) -> f64 {
    vector.0.iter().map(|part| part * part).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Axis;
    use crate::geometry::bezier::weighted;

    fn curve(
        y: &[f64],
        x: &[f64],
        slopes: impl Fn(&[AxisVector], &[f64]) -> Vec<AxisVector>,
    ) -> (Vec<f64>, Vec<AxisVector>) {
        let at = |x: f64, y: f64| AxisVector([x, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let points: Vec<AxisVector> = x.iter().zip(y).map(|(&x, &y)| at(x, y)).collect();
        let lengths: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let chords: Vec<AxisVector> = points
            .windows(2)
            .zip(&lengths)
            .map(|(pair, length)| sum(1.0 / length, &(pair[1] - pair[0]), 0.0, &pair[0]))
            .collect();
        let found = slopes(&chords, &lengths);
        (lengths, found)
    }

    /// Akima's own example (Journal of the ACM 17, 1970): y = 10 up to x = 5, then rising; slopes calculated manually by his formula.
    #[test]
    fn akima_slopes_are_those_of_the_formula() {
        let x: Vec<f64> = (0..11).map(f64::from).collect();
        let y = [10.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.5, 15.0, 50.0, 60.0, 85.0];
        let (_, slopes) = curve(&y, &x, |chords, lengths| akima_slopes(chords, lengths, [SplineEnd::Automatic; 2]));
        // m = 0 0 0 0 0 0.5 4.5 35 10 25; at x = 6: (|35-4.5| 0.5 + |0.5-0| 4.5) / (30.5 + 0.5).
        for (k, wanted) in [
            (0, 0.0),
            (4, 0.0),
            (5, 0.0),
            (6, (30.5 * 0.5 + 0.5 * 4.5) / 31.0),
            (7, (25.0 * 4.5 + 4.0 * 35.0) / 29.0),
            (8, (15.0 * 35.0 + 30.5 * 10.0) / 45.5),
        ] {
            assert!((slopes[k][Axis::Y] - wanted).abs() < 1e-12, "{k}: {} {wanted}", slopes[k][Axis::Y]);
        }
        // Beyond the end the slopes 40 and 55: at x = 9 (|40-25| 10 + |10-35| 25) / 40, at x = 10 the mean of 25 and 40.
        assert!((slopes[9][Axis::Y] - (15.0 * 10.0 + 25.0 * 25.0) / 40.0).abs() < 1e-12);
        assert!((slopes[10][Axis::Y] - 32.5).abs() < 1e-12);
    }

    #[test]
    fn cubic_splines_have_continuous_curvature_and_the_ends_asked_for() {
        let (x, y) = ([0.0, 1.0, 2.5, 3.0, 5.0], [0.0, 2.0, -1.0, 0.5, 4.0]);
        let mut tangent = AxisVector::ZERO;
        tangent[Axis::X] = 1.0;
        tangent[Axis::Y] = -3.0;
        for ends in [
            [SplineEnd::Natural; 2],
            [SplineEnd::Tangent(tangent), SplineEnd::Natural],
            [SplineEnd::Automatic; 2],
            [SplineEnd::Natural, SplineEnd::Automatic],
        ] {
            let (h, s) = curve(&y, &x, |chords, lengths| cubic_slopes(chords, lengths, ends));
            let s: Vec<f64> = s.iter().map(|slope| slope[Axis::Y]).collect();
            let m: Vec<f64> = (0..4).map(|k| (y[k + 1] - y[k]) / h[k]).collect();
            let left = |k: usize| (6.0 * m[k] - 4.0 * s[k] - 2.0 * s[k + 1]) / h[k];
            let right = |k: usize| (2.0 * s[k] + 4.0 * s[k + 1] - 6.0 * m[k]) / h[k];
            let third = |k: usize| (right(k) - left(k)) / h[k];
            for k in 0..3 {
                assert!((right(k) - left(k + 1)).abs() < 1e-10);
            }
            match ends[0] {
                SplineEnd::Natural => assert!(left(0).abs() < 1e-10),
                SplineEnd::Tangent(_) => assert!((s[0] + 3.0).abs() < 1e-12),
                SplineEnd::Automatic => assert!((third(0) - third(1)).abs() < 1e-9),
            }
            match ends[1] {
                SplineEnd::Automatic => assert!((third(3) - third(2)).abs() < 1e-9),
                _ => assert!(right(3).abs() < 1e-10),
            }
        }
        // Three points, both ends automatic: reproduces y = x².
        let (_, s) = curve(&[0.0, 1.0, 9.0], &[0.0, 1.0, 3.0], |c, l| cubic_slopes(c, l, [SplineEnd::Automatic; 2]));
        for (slope, wanted) in s.iter().zip([0.0, 2.0, 6.0]) {
            assert!((slope[Axis::Y] - wanted).abs() < 1e-12);
        }
    }

    /// Cox and de Boor's recursion, written out independently.
    fn basis(knots: &[f64], i: usize, degree: usize, t: f64) -> f64 {
        if degree == 0 {
            let last = knots[knots.len() - 1];
            return f64::from(u8::from(knots[i] <= t && (t < knots[i + 1] || t == last && knots[i + 1] == last)));
        }
        let part = |a: f64, b: f64| if b == 0.0 { 0.0 } else { a / b };
        part(t - knots[i], knots[i + degree] - knots[i]) * basis(knots, i, degree - 1, t)
            + part(knots[i + degree + 1] - t, knots[i + degree + 1] - knots[i + 1]) * basis(knots, i + 1, degree - 1, t)
    }

    #[test]
    fn b_splines_are_sums_of_their_basis_functions() {
        let y = [0.0, 5.0, -3.0, 8.0, 2.0, 2.0, -7.0];
        let weights = [1.0, 0.5, 2.0, 1.0, 3.0, 0.7, 1.0];
        for degree in [2, 3] {
            let control = y.iter().zip(weights).enumerate().map(|(k, (&y, weight))| {
                weighted(&AxisVector([k as f64, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]), weight)
            });
            let spline = BSpline::new(degree, control.collect()).unwrap();
            let pieces = spline.pieces();
            assert_eq!(pieces, 7 - degree);
            let mut knots = vec![0.0; degree];
            knots.extend((0..=pieces).map(|k| k as f64));
            knots.extend(vec![pieces as f64; degree]);
            for piece in 0..pieces {
                let curve = spline.part(piece as f64, piece as f64 + 1.0).unwrap();
                let half = spline.part(piece as f64, piece as f64 + 0.5).unwrap();
                for share in [0.0, 0.2, 0.5, 0.9] {
                    let t = piece as f64 + share;
                    let sums: [f64; 2] = (0..7).fold([0.0; 2], |sums, i| {
                        let b = basis(&knots, i, degree, t) * weights[i];
                        [sums[0] + b * y[i], sums[1] + b]
                    });
                    assert!((curve.at(share)[Axis::Y] - sums[0] / sums[1]).abs() < 1e-12, "{degree} {t}");
                    if share <= 0.5 {
                        assert!((half.at(2.0 * share)[Axis::Y] - sums[0] / sums[1]).abs() < 1e-12);
                    }
                }
            }
        }
    }
}
