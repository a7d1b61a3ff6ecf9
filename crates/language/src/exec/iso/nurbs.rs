//! Curves of RS274/NGC: G5, G5.1 and G5.2/G5.3 are NURBS of the XY plane, divided into straight pieces.
//!
//! LinuxCNC's own interpreter emits them in equal parameter steps, 15 for each control point. Here every such step is divided into as many equal
//! steps as keep the pieces within the tolerance. The knots are equidistant, repeated at both ends according to the order.

/// Maximum number of pieces of a curve.
const MOST_PIECES: usize = 1_000_000;
/// Number of steps for each control point.
const STEPS: usize = 15;
/// Maximum number of control points, and maximum order.
const MOST_POINTS: usize = 2_000;
/// Positions within a piece at which its distance from the curve is measured.
const SAMPLES: [f64; 3] = [0.25, 0.5, 0.75];

/// A control point, mm, and its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Control {
    /// X and Y.
    pub(super) at: [f64; 2],
    /// P.
    pub(super) weight: f64,
}

/// A curve from its first to its last control point.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Nurbs {
    control: Vec<Control>,
    /// Degree plus 1.
    order: usize,
}

/// Reason why there is no curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NurbsFault {
    /// Fewer control points than the order.
    TooFew,
    /// Too many control points.
    TooMany,
    /// A weight is not above 0, or a number is invalid.
    BadValue,
    /// The tolerance needs too many pieces.
    TooFine,
}

impl Nurbs {
    /// A curve of an order.
    pub(super) fn new(control: Vec<Control>, order: usize) -> Result<Nurbs, NurbsFault> {
        if order < 2 || control.len() < order {
            return Err(NurbsFault::TooFew);
        }
        if control.len() > MOST_POINTS || order > MOST_POINTS {
            return Err(NurbsFault::TooMany);
        }
        let is_good = |point: &Control| {
            point.at.iter().all(|value| value.is_finite()) && point.weight > 0.0 && point.weight.is_finite()
        };
        if !control.iter().all(is_good) {
            return Err(NurbsFault::BadValue);
        }
        Ok(Nurbs { control, order })
    }

    /// A curve with equal weights, of the highest possible degree.
    pub(super) fn bezier(points: &[[f64; 2]]) -> Result<Nurbs, NurbsFault> {
        Nurbs::new(points.iter().map(|&at| Control { at, weight: 1.0 }).collect(), points.len())
    }

    /// End of the parameter, which starts at 0.
    fn end(&self) -> f64 {
        (self.control.len() + 1 - self.order) as f64
    }

    fn knot(&self, index: usize) -> f64 {
        (index + 1).saturating_sub(self.order).min(self.control.len() + 1 - self.order) as f64
    }

    /// The point at a parameter (de Boor); `work` is scratch space.
    fn at(&self, parameter: f64, work: &mut Vec<[f64; 3]>) -> [f64; 2] {
        let degree = self.order - 1;
        // Within range by construction; the last piece includes its end.
        let piece = (parameter.max(0.0).floor() as usize).min(self.control.len() - self.order);
        work.clear();
        work.extend(
            self.control
                .iter()
                .skip(piece)
                .take(self.order)
                .map(|point| [point.at[0] * point.weight, point.at[1] * point.weight, point.weight]),
        );
        for level in 1..=degree {
            for place in (level..=degree).rev() {
                let (low, high) = (self.knot(piece + place), self.knot(piece + place + self.order - level));
                let share = (parameter - low) / (high - low);
                if let [.., before, here] = work.get_mut(..=place).unwrap_or_default() {
                    for (value, before) in here.iter_mut().zip(*before) {
                        *value = before + (*value - before) * share;
                    }
                }
            }
        }
        let [x, y, weight] = work.last().copied().unwrap_or([0.0, 0.0, 1.0]);
        [x / weight, y / weight]
    }

    /// Ends of straight pieces within a tolerance from the curve; the last control point is last.
    pub(super) fn pieces(&self, tolerance_mm: f64) -> Result<Vec<[f64; 2]>, NurbsFault> {
        let steps = self.control.len() * STEPS;
        let mut work = Vec::with_capacity(self.order);
        // The distance of a chord is proportional to the square of its step.
        let off = self.farthest(steps, &mut work);
        let mut finer = (off / tolerance_mm).sqrt().ceil().max(1.0);
        for _ in 0..8 {
            if !finer.is_finite() || finer * steps as f64 > MOST_PIECES as f64 {
                return Err(NurbsFault::TooFine);
            }
            // Between 1 and the limit.
            let count = steps * finer as usize;
            if finer == 1.0 || self.farthest(count, &mut work) <= tolerance_mm {
                return Ok(self.ends(count, &mut work));
            }
            finer = (finer * 1.25).ceil();
        }
        Err(NurbsFault::TooFine)
    }

    fn ends(&self, count: usize, work: &mut Vec<[f64; 3]>) -> Vec<[f64; 2]> {
        let step = self.end() / count as f64;
        let mut out: Vec<[f64; 2]> = (1..count).map(|k| self.at(k as f64 * step, work)).collect();
        out.extend(self.control.last().map(|point| point.at));
        out
    }

    /// Largest distance of the curve from the chords of `count` equal steps.
    fn farthest(&self, count: usize, work: &mut Vec<[f64; 3]>) -> f64 {
        let step = self.end() / count as f64;
        let mut from = self.at(0.0, work);
        let mut worst = 0.0_f64;
        for k in 0..count {
            let to = self.at((k + 1) as f64 * step, work);
            for share in SAMPLES {
                let point = self.at((k as f64 + share) * step, work);
                worst = worst.max(distance(point, from, to));
            }
            from = to;
        }
        worst
    }
}

/// Distance of a point from a line segment.
fn distance(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let off = [point[0] - from[0], point[1] - from[1]];
    let square = way[0] * way[0] + way[1] * way[1];
    let share = if square > 0.0 { ((off[0] * way[0] + off[1] * way[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (off[0] - way[0] * share).hypot(off[1] - way[1] * share)
}

/// The incomplete curve, and the end tangent of the last one.
#[derive(Clone, Debug, Default)]
pub(super) struct Curve {
    pub(super) control: Vec<Control>,
    pub(super) order: usize,
    /// From the end of the last G5 along its tangent, mm.
    pub(super) onwards: [f64; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A Bézier curve by Bernstein's polynomials.
    fn cubic(points: [[f64; 2]; 4], t: f64) -> [f64; 2] {
        let s = 1.0 - t;
        let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        let sum = |axis: usize| points.iter().zip(weights).map(|(point, weight)| point[axis] * weight).sum();
        [sum(0), sum(1)]
    }

    #[test]
    fn four_points_of_order_four_are_a_bezier_curve_in_sixty_steps() {
        let points = [[0.0, 0.0], [0.0, 3.0], [1.0, -2.0], [1.0, 1.0]];
        let pieces = Nurbs::bezier(&points).unwrap().pieces(0.01).unwrap();
        assert_eq!(pieces.len(), 60);
        for (k, piece) in pieces.iter().enumerate() {
            let wanted = cubic(points, (k + 1) as f64 / 60.0);
            assert!((piece[0] - wanted[0]).hypot(piece[1] - wanted[1]) < 1e-12, "{k}");
        }
    }

    #[test]
    fn a_finer_tolerance_divides_every_step() {
        let points = [[0.0, 0.0], [0.0, 300.0], [100.0, -200.0], [100.0, 100.0]];
        let pieces = Nurbs::bezier(&points).unwrap().pieces(2.5e-4).unwrap();
        assert_eq!(pieces.len() % 60, 0);
        let finer = pieces.len() / 60;
        assert!(finer > 1);
        for k in 1..=60 {
            let wanted = cubic(points, f64::from(k) / 60.0);
            let piece = pieces[k as usize * finer - 1];
            assert!((piece[0] - wanted[0]).hypot(piece[1] - wanted[1]) < 1e-10, "{k}");
        }
        // The curve is nowhere farther off than permitted.
        let mut from = points[0];
        for (k, to) in pieces.iter().enumerate() {
            for sample in 1..10 {
                let t = (k as f64 + f64::from(sample) / 10.0) / pieces.len() as f64;
                assert!(distance(cubic(points, t), from, *to) <= 2.6e-4);
            }
            from = *to;
        }
    }

    #[test]
    fn weights_make_a_quarter_circle() {
        let weight = 0.5_f64.sqrt();
        let control = [([1.0, 0.0], 1.0), ([1.0, 1.0], weight), ([0.0, 1.0], 1.0)];
        let control: Vec<Control> = control.into_iter().map(|(at, weight)| Control { at, weight }).collect();
        for [x, y] in Nurbs::new(control, 3).unwrap().pieces(1e-3).unwrap() {
            assert!((x.hypot(y) - 1.0).abs() < 1e-12);
        }
    }

    /// Cox and de Boor's recursion, explicitly.
    fn basis(knots: &[f64], i: usize, order: usize, t: f64) -> f64 {
        if order == 1 {
            let last = knots[knots.len() - 1];
            return f64::from(u8::from(knots[i] <= t && (t < knots[i + 1] || t == last && knots[i + 1] == last)));
        }
        let part = |a: f64, b: f64| if b == 0.0 { 0.0 } else { a / b };
        part(t - knots[i], knots[i + order - 1] - knots[i]) * basis(knots, i, order - 1, t)
            + part(knots[i + order] - t, knots[i + order] - knots[i + 1]) * basis(knots, i + 1, order - 1, t)
    }

    #[test]
    fn curves_are_sums_of_their_basis_functions() {
        let points = [[0.0, 1.0], [2.0, 2.0], [2.0, 0.0], [0.0, 0.0], [-1.0, 3.0], [5.0, 5.0]];
        let weights = [1.0, 0.5, 2.0, 1.0, 3.0, 0.7];
        for order in 2..=6 {
            let control = points.iter().zip(weights).map(|(&at, weight)| Control { at, weight }).collect();
            let curve = Nurbs::new(control, order).unwrap();
            let last = (7 - order) as f64;
            let mut knots = vec![0.0; order];
            knots.extend((1..7 - order).map(|k| k as f64));
            knots.extend(vec![last; order]);
            let mut work = Vec::new();
            for k in 0..=40 {
                let t = last * f64::from(k) / 40.0;
                let parts: Vec<f64> = (0..6).map(|i| basis(&knots, i, order, t) * weights[i]).collect();
                let whole: f64 = parts.iter().sum();
                let found = curve.at(t, &mut work);
                for axis in 0..2 {
                    let wanted = parts.iter().zip(points).map(|(part, at)| part * at[axis]).sum::<f64>() / whole;
                    assert!((found[axis] - wanted).abs() < 1e-12, "{order} {t}");
                }
            }
        }
    }

    #[test]
    fn no_curve_of_faulty_values() {
        let point = Control { at: [0.0, 0.0], weight: 1.0 };
        assert_eq!(Nurbs::new(vec![point; 2], 3), Err(NurbsFault::TooFew));
        assert_eq!(Nurbs::new(vec![Control { weight: 0.0, ..point }; 3], 3), Err(NurbsFault::BadValue));
        assert_eq!(Nurbs::new(vec![point; 5000], 3), Err(NurbsFault::TooMany));
        let huge = [[0.0, 0.0], [1e300, 1e300], [0.0, 1.0]];
        assert_eq!(Nurbs::bezier(&huge).and_then(|curve| curve.pieces(1e-3)), Err(NurbsFault::TooFine));
        // All points are coincident.
        assert_eq!(Nurbs::new(vec![point; 3], 3).unwrap().pieces(1e-3).unwrap().len(), 45);
    }
}
