//! Rational Bézier curves over all axes: the form of splines and polynomials before they are divided into chords.

use super::{AXES, AXIS_COUNT, AxisVector};

/// Maximum number of control points of a curve: degree 6.
const MOST_POINTS: usize = 7;
/// Maximum number of halvings of one curve.
const MOST_HALVINGS: u32 = 30;
/// Lever arm that converts rotary angles to lengths, mm: about the reach of a workpiece on a table.
const ROTARY_ARM_MM: f64 = 100.0;

/// Point with its weight: positions times weight, then the weight.
pub type Weighted = [f64; AXIS_COUNT + 1];

/// Curve from its first to its last control point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bezier {
    points: [Weighted; MOST_POINTS],
    count: usize,
}

/// Reason why a curve cannot be divided into chords.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveFault {
    /// A weight is not positive: the curve goes through infinity.
    Nowhere,
    /// More chords than permitted.
    TooManyChords,
}

/// Returns a position with a weight.
#[must_use]
pub fn weighted(position: &AxisVector, weight: f64) -> Weighted {
    let mut out = [weight; AXIS_COUNT + 1];
    for (value, position) in out.iter_mut().zip(position.0) {
        *value = position * weight;
    }
    out
}

impl Bezier {
    /// Creates the curve of two to seven control points; `None` for any other number.
    #[must_use]
    pub fn new(control: &[Weighted]) -> Option<Bezier> {
        let mut points = [[0.0; AXIS_COUNT + 1]; MOST_POINTS];
        if !(2..=MOST_POINTS).contains(&control.len()) {
            return None;
        }
        for (point, given) in points.iter_mut().zip(control) {
            *point = *given;
        }
        Some(Bezier { points, count: control.len() })
    }

    /// Creates the cubic curve between two positions with derivatives by a parameter from 0 to 1.
    #[must_use]
    pub fn hermite(positions: [&AxisVector; 2], derivatives: [&AxisVector; 2]) -> Option<Bezier> {
        let (mut first, mut second) = (*positions[0], *positions[1]);
        for slot in 0..AXIS_COUNT {
            first.0[slot] += derivatives[0].0[slot] / 3.0;
            second.0[slot] -= derivatives[1].0[slot] / 3.0;
        }
        Bezier::new(&[positions[0], &first, &second, positions[1]].map(|position| weighted(position, 1.0)))
    }

    /// Creates the curve of a polynomial in a parameter from 0 to 1, coefficients in ascending order from the constant one.
    #[must_use]
    pub fn of_powers(coefficients: &[Weighted]) -> Option<Bezier> {
        let degree = coefficients.len().checked_sub(1)?;
        let control: Vec<Weighted> = (0..=degree)
            .map(|j| {
                let mut point = [0.0; AXIS_COUNT + 1];
                for (i, coefficient) in coefficients.iter().enumerate().take(j + 1) {
                    let share = binomial(j, i) / binomial(degree, i);
                    point.iter_mut().zip(coefficient).for_each(|(value, part)| *value += share * part);
                }
                point
            })
            .collect();
        Bezier::new(&control)
    }

    /// Returns the position at a parameter from 0 to 1.
    #[must_use]
    pub fn at(&self, parameter: f64) -> AxisVector {
        position(&self.halves(parameter).1.points[0])
    }

    /// Calls `out` with the ends of all chords except the last. The chords deviate from the curve by no more than a tolerance: the curve lies in the hull of
    /// its control points. `budget` is the number of permitted chords and is decremented.
    ///
    /// # Errors
    /// If the curve goes through infinity, or needs more chords.
    pub fn chords(
        &self,
        tolerance_mm: f64,
        budget: &mut usize,
        out: &mut impl FnMut(AxisVector),
    ) -> Result<(), CurveFault> {
        self.cut(tolerance_mm, 0, budget, out)
    }

    fn cut(
        &self,
        tolerance_mm: f64,
        halvings: u32,
        budget: &mut usize,
        out: &mut impl FnMut(AxisVector),
    ) -> Result<(), CurveFault> {
        let is_positive = self.control().iter().all(|point| point[AXIS_COUNT] > 0.0);
        if is_positive && self.bulge_mm() <= tolerance_mm {
            return Ok(());
        }
        let (first, second) = self.halves(0.5);
        let middle = second.points[0];
        if middle[AXIS_COUNT] <= 0.0 || !is_positive && halvings == MOST_HALVINGS {
            return Err(CurveFault::Nowhere);
        }
        *budget = budget.checked_sub(1).filter(|_| halvings < MOST_HALVINGS).ok_or(CurveFault::TooManyChords)?;
        first.cut(tolerance_mm, halvings + 1, budget, out)?;
        out(position(&middle));
        second.cut(tolerance_mm, halvings + 1, budget, out)
    }

    fn control(&self) -> &[Weighted] {
        self.points.get(..self.count).unwrap_or_default()
    }

    /// Returns the largest distance of a control point from the chord, mm.
    fn bulge_mm(&self) -> f64 {
        let places: Vec<AxisVector> = self.control().iter().map(|point| scaled(&position(point))).collect();
        let [start, inner @ .., end] = places.as_slice() else { return 0.0 };
        let chord = *end - *start;
        let square = dot(&chord, &chord);
        let off = inner.iter().map(|point| {
            let from_start = *point - *start;
            let share = if square > 0.0 { (dot(&from_start, &chord) / square).clamp(0.0, 1.0) } else { 0.0 };
            let off = *point - start.lerp(end, share);
            // NaN counts as infinitely far.
            Some(dot(&off, &off)).filter(|square| !square.is_nan()).unwrap_or(f64::INFINITY)
        });
        off.fold(0.0, f64::max).sqrt()
    }

    /// Returns the parts before and after a parameter (de Casteljau).
    fn halves(&self, parameter: f64) -> (Bezier, Bezier) {
        let (mut first, mut second) = (*self, *self);
        let last = self.count - 1;
        for level in 1..=last {
            for k in 0..=last - level {
                let (a, b) = (second.points[k], second.points[k + 1]);
                for (slot, value) in second.points[k].iter_mut().enumerate() {
                    *value = a[slot] + (b[slot] - a[slot]) * parameter;
                }
            }
            first.points[level] = second.points[0];
        }
        (first, second)
    }
}

fn position(point: &Weighted) -> AxisVector {
    let mut out = AxisVector::ZERO;
    for (value, part) in out.0.iter_mut().zip(point) {
        *value = part / point[AXIS_COUNT];
    }
    out
}

/// Converts rotary axes to lengths at their lever arm.
fn scaled(position: &AxisVector) -> AxisVector {
    let mut out = *position;
    for axis in AXES.into_iter().filter(|axis| axis.is_rotary()) {
        out[axis] *= ROTARY_ARM_MM;
    }
    out
}

fn dot(a: &AxisVector, b: &AxisVector) -> f64 {
    a.0.iter().zip(b.0).map(|(a, b)| a * b).sum()
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Axis;

    fn at(x: f64, y: f64) -> AxisVector {
        AxisVector([x, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    #[test]
    fn a_quarter_circle_is_a_rational_parabola_and_its_chords_stay_near() {
        let control =
            [weighted(&at(10.0, 0.0), 1.0), weighted(&at(10.0, 10.0), 0.5_f64.sqrt()), weighted(&at(0.0, 10.0), 1.0)];
        let curve = Bezier::new(&control).unwrap();
        for k in 0..=10 {
            let place = curve.at(f64::from(k) / 10.0);
            assert!((place[Axis::X].hypot(place[Axis::Y]) - 10.0).abs() < 1e-12);
        }
        let mut ends = vec![at(10.0, 0.0)];
        curve.chords(1e-3, &mut 1000, &mut |end| ends.push(end)).unwrap();
        ends.push(at(0.0, 10.0));
        assert!((12..200).contains(&ends.len()), "{}", ends.len());
        for pair in ends.windows(2) {
            let middle = pair[0].lerp(&pair[1], 0.5);
            assert!(10.0 - middle[Axis::X].hypot(middle[Axis::Y]) < 1e-3);
        }
    }

    #[test]
    fn powers_and_bernstein_polynomials_are_the_same_curve() {
        // x = 1 + 2p - 3p² + p³ - 5p⁴, y = p⁵.
        let mut powers = [[0.0; AXIS_COUNT + 1]; 6];
        for (power, (x, y)) in
            powers.iter_mut().zip([(1.0, 0.0), (2.0, 0.0), (-3.0, 0.0), (1.0, 0.0), (-5.0, 0.0), (0.0, 1.0)])
        {
            power[0] = x;
            power[1] = y;
        }
        powers[0][AXIS_COUNT] = 1.0;
        let curve = Bezier::of_powers(&powers).unwrap();
        for p in [0.0, 0.3, 0.8, 1.0_f64] {
            let place = curve.at(p);
            let x = 1.0 + 2.0 * p - 3.0 * p.powi(2) + p.powi(3) - 5.0 * p.powi(4);
            assert!((place[Axis::X] - x).abs() < 1e-12 && (place[Axis::Y] - p.powi(5)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_curve_through_infinity_is_refused() {
        let control = [weighted(&at(0.0, 0.0), 1.0), weighted(&at(1.0, 0.0), -3.0), weighted(&at(2.0, 0.0), 1.0)];
        let curve = Bezier::new(&control).unwrap();
        assert_eq!(curve.chords(1e-3, &mut 1000, &mut |_| {}), Err(CurveFault::Nowhere));
        let control = [weighted(&at(0.0, 0.0), 1.0), weighted(&at(1.0, 9.0), 1.0), weighted(&at(2.0, 0.0), 1.0)];
        let curve = Bezier::new(&control).unwrap();
        assert_eq!(curve.chords(1e-3, &mut 10, &mut |_| {}), Err(CurveFault::TooManyChords));
        let wild = Bezier::new(&[
            weighted(&at(0.0, f64::NAN), 1.0),
            weighted(&at(1e300, 0.0), 1.0),
            weighted(&at(0.0, 1.0), 1.0),
        ]);
        assert_eq!(wild.unwrap().chords(1e-3, &mut 1000, &mut |_| {}), Err(CurveFault::TooManyChords));
    }
}
