//! Smooth functions of the pose, or of the position on the path, that represent the motion errors along one path.
//!
//! The motion errors of an axis are smooth functions of its position. Along one path their sum is a sum of smooth functions of the positions of all
//! axes: Legendre polynomials of each, without products. At block transitions the path has kinks, and so does such a sum. Andolfatto, Lavernhe and
//! Mayer 2011, section 3.3.3, use polynomials of degree 20 of a path parameter instead, which smooth the kinks.

use ncfix_base::geometry::{Axis, AxisVector};

/// Kind of smooth functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Smooth {
    /// Of the position of each axis, up to this degree.
    Pose(usize),
    /// Of the relative path position, up to this degree.
    Path(usize),
}

impl Default for Smooth {
    fn default() -> Self {
        Smooth::Pose(6)
    }
}

/// Functions on the range of a run.
#[derive(Clone, Debug)]
pub struct Basis {
    kind: Smooth,
    /// Moving axes, with the ends of their range, mm or rad.
    ranges: Vec<(Axis, [f64; 2])>,
}

impl Basis {
    /// For the axes that move over these positions.
    #[must_use]
    pub fn new(kind: Smooth, axes: &[Axis], positions: &[AxisVector]) -> Basis {
        let range = |axis: Axis| {
            let ends = positions
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at[axis]), high.max(at[axis])]);
            // Smaller ranges are noise of a servo loop.
            (ends[1] - ends[0] > if axis.is_rotary() { 1e-4 } else { 1e-2 }).then_some((axis, ends))
        };
        Basis { kind, ranges: axes.iter().copied().filter_map(range).collect() }
    }

    /// Number of functions, without the constant.
    #[must_use]
    pub fn len(&self) -> usize {
        match self.kind {
            Smooth::Pose(degree) => degree * self.ranges.len(),
            Smooth::Path(degree) => degree,
        }
    }

    /// `true` without any.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Highest degree.
    #[must_use]
    pub fn degree(&self) -> usize {
        match self.kind {
            Smooth::Pose(degree) | Smooth::Path(degree) => degree,
        }
    }

    /// Axis and degree of every function, in the order of [`Basis::push`]; no axis for functions of the path.
    #[must_use]
    pub fn terms(&self) -> Vec<(Option<Axis>, usize)> {
        match self.kind {
            Smooth::Pose(degree) => {
                let of = |axis: Axis| (1..=degree).map(move |degree| (Some(axis), degree));
                self.ranges.iter().flat_map(|(axis, _)| of(*axis)).collect()
            }
            Smooth::Path(degree) => (1..=degree).map(|degree| (None, degree)).collect(),
        }
    }

    /// Half of the range of a moving axis, mm or rad.
    #[must_use]
    pub fn half_range(&self, axis: Axis) -> Option<f64> {
        self.ranges.iter().find(|(own, _)| *own == axis).map(|(_, [low, high])| 0.5 * (high - low))
    }

    /// Appends their values at a pose and a relative path position.
    pub fn push(&self, at: &AxisVector, share: f64, out: &mut Vec<f64>) {
        match self.kind {
            Smooth::Pose(degree) => {
                for (axis, [low, high]) in &self.ranges {
                    push_legendre(2.0 * (at[*axis] - low) / (high - low) - 1.0, degree, out);
                }
            }
            Smooth::Path(degree) => push_legendre(2.0 * share - 1.0, degree, out),
        }
    }
}

/// P₁ … Pₙ; constant beyond the ends, where they would diverge.
fn push_legendre(x: f64, degree: usize, out: &mut Vec<f64>) {
    let x = x.clamp(-1.0, 1.0);
    let (mut before, mut now) = (1.0, x);
    for n in 1..=degree {
        out.push(now);
        let n = n as f64;
        (before, now) = (now, ((2.0 * n + 1.0) * x * now - n * before) / (n + 1.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_legendre() {
        let mut out = Vec::new();
        push_legendre(0.5, 4, &mut out);
        // x, (3x² − 1)/2, (5x³ − 3x)/2, (35x⁴ − 30x² + 3)/8.
        let expected = [0.5, -0.125, -0.4375, -0.289_062_5];
        assert!(out.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{out:?}");
    }

    #[test]
    fn axes_that_stand_have_none() {
        let at = |x: f64| AxisVector([x, 5.0, 0.0, 0.0, 0.0, 0.0, 0.1 * x, 0.0, 0.0]);
        let positions = [at(0.0), at(10.0)];
        let basis = Basis::new(Smooth::Pose(3), &[Axis::X, Axis::Y, Axis::A], &positions);
        let mut out = Vec::new();
        basis.push(&at(10.0), 0.0, &mut out);
        assert_eq!((basis.len(), out), (6, vec![1.0; 6]));
        assert_eq!(Basis::new(Smooth::Path(20), &[Axis::X], &positions).len(), 20);
    }
}
