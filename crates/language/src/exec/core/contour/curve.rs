//! Lines and arcs in the coordinates of a working plane: tangents, offsets, intersections, distances.

use std::f64::consts::{PI, TAU};

/// A point or direction of the plane.
pub(super) type Flat = [f64; 2];

/// Points nearer to each other than this are equal, mm.
pub(super) const SAME_MM: f64 = 1e-7;
/// Difference of the radii of an inner arc and the tool, mm, below which the center of the tool stays at one point.
pub(super) const POINT_MM: f64 = 1e-4;
/// Radius of the arc that stands for this point, mm.
const SHORT_MM: f64 = 1e-6;
/// Sine of the angle below which directions are parallel.
const PARALLEL: f64 = 1e-12;

/// A line or an arc. Its parameter is the length along it, mm, and may exceed both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Curve {
    Line {
        start: Flat,
        end: Flat,
    },
    Arc {
        center: Flat,
        radius: f64,
        /// Direction of the start from the center, rad.
        from: f64,
        /// Swept angle, rad, positive counter-clockwise.
        sweep: f64,
    },
}

pub(super) fn add(a: Flat, b: Flat) -> Flat {
    [a[0] + b[0], a[1] + b[1]]
}

pub(super) fn sub(a: Flat, b: Flat) -> Flat {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn scaled(a: Flat, by: f64) -> Flat {
    [a[0] * by, a[1] * by]
}

pub(super) fn dot(a: Flat, b: Flat) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn cross(a: Flat, b: Flat) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn distance(a: Flat, b: Flat) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// A vector rotated left by a right angle.
pub(super) fn left(a: Flat) -> Flat {
    [-a[1], a[0]]
}

/// A vector of length 1; along the abscissa for a zero vector.
pub(super) fn unit(a: Flat) -> Flat {
    let length = a[0].hypot(a[1]);
    if length > 0.0 && length.is_finite() { scaled(a, 1.0 / length) } else { [1.0, 0.0] }
}

/// From 0 up to a full turn.
pub(super) fn turn(angle: f64) -> f64 {
    let turned = angle.rem_euclid(TAU);
    if turned >= TAU { 0.0 } else { turned }
}

impl Curve {
    /// The arc from one point to another; a full circle if they coincide.
    pub(super) fn arc(start: Flat, end: Flat, center: Flat, clockwise: bool, extra_turns: u32) -> Curve {
        let (a, b) = (sub(start, center), sub(end, center));
        let (from, to) = (a[1].atan2(a[0]), b[1].atan2(b[0]));
        let part = if distance(start, end) < 1e-9 {
            TAU
        } else if clockwise {
            turn(from - to)
        } else {
            turn(to - from)
        };
        let total = part + f64::from(extra_turns) * TAU;
        // For a spiral, the radius at its end, as its start is already fixed.
        let (first, last) = (a[0].hypot(a[1]), b[0].hypot(b[1]));
        let radius = if (first - last).abs() < SAME_MM { first } else { last };
        Curve::Arc { center, radius, from, sweep: if clockwise { -total } else { total } }
    }

    pub(super) fn length(&self) -> f64 {
        match *self {
            Curve::Line { start, end } => distance(start, end),
            Curve::Arc { radius, sweep, .. } => radius * sweep.abs(),
        }
    }

    /// The point at a length along the curve, also beyond its ends.
    pub(super) fn at(&self, along: f64) -> Flat {
        match *self {
            Curve::Line { start, end } => {
                let length = distance(start, end);
                if along == length { end } else { add(start, scaled(unit(sub(end, start)), along)) }
            }
            Curve::Arc { center, radius, from, sweep } => {
                let angle = from + (along / radius.max(f64::MIN_POSITIVE)).min(1e6) * sweep.signum();
                add(center, [radius * angle.cos(), radius * angle.sin()])
            }
        }
    }

    pub(super) fn start(&self) -> Flat {
        self.at(0.0)
    }

    pub(super) fn end(&self) -> Flat {
        self.at(self.length())
    }

    /// Unit tangent at a length along the curve.
    pub(super) fn tangent(&self, along: f64) -> Flat {
        match *self {
            Curve::Line { start, end } => unit(sub(end, start)),
            Curve::Arc { radius, from, sweep, .. } => {
                let angle = from + along / radius.max(f64::MIN_POSITIVE) * sweep.signum();
                scaled([-angle.sin(), angle.cos()], sweep.signum())
            }
        }
    }

    pub(super) fn first_tangent(&self) -> Flat {
        self.tangent(0.0)
    }

    pub(super) fn last_tangent(&self) -> Flat {
        self.tangent(self.length())
    }

    /// The curve at a distance to the left; `None` if the arc is too narrow for it.
    pub(super) fn offset(&self, by: f64) -> Option<Curve> {
        Some(match *self {
            Curve::Line { start, end } => {
                let normal = scaled(left(unit(sub(end, start))), by);
                Curve::Line { start: add(start, normal), end: add(end, normal) }
            }
            Curve::Arc { center, radius, from, sweep } => {
                // The center of a counter-clockwise arc is on its left.
                let radius = radius - by * sweep.signum();
                if radius < SAME_MM {
                    return None;
                }
                Curve::Arc { center, radius, from, sweep }
            }
        })
    }

    /// The curve of an inner arc whose radius is the distance: the center stays at one point, and an arc of a millionth of a millimeter keeps its
    /// tangents. `None` for other curves.
    pub(super) fn point_of(&self, by: f64) -> Option<Curve> {
        let Curve::Arc { center, radius, from, sweep } = *self else { return None };
        let is_point = (radius - by * sweep.signum()).abs() < POINT_MM;
        is_point.then_some(Curve::Arc { center, radius: SHORT_MM, from, sweep })
    }

    /// The length along the curve of a point on it, nearest to `near` if turns of an arc make it ambiguous.
    pub(super) fn along(&self, point: Flat, near: f64) -> f64 {
        match *self {
            Curve::Line { start, end } => dot(sub(point, start), unit(sub(end, start))),
            Curve::Arc { center, radius, from, sweep } => {
                let to_point = sub(point, center);
                let angle = (to_point[1].atan2(to_point[0]) - from) * sweep.signum();
                let turns = ((near / radius.max(f64::MIN_POSITIVE) - angle) / TAU).round();
                (angle + turns * TAU) * radius
            }
        }
    }

    /// Intersections of two curves extended beyond their ends.
    pub(super) fn crossings(&self, other: &Curve) -> Crossings {
        match (*self, *other) {
            (Curve::Line { start: a, end: b }, Curve::Line { start: c, end: d }) => {
                let (u, v) = (unit(sub(b, a)), unit(sub(d, c)));
                let sine = cross(u, v);
                if sine.abs() < PARALLEL {
                    return Crossings::default();
                }
                Crossings([Some(add(a, scaled(u, cross(sub(c, a), v) / sine))), None])
            }
            (Curve::Line { start, end }, Curve::Arc { center, radius, .. })
            | (Curve::Arc { center, radius, .. }, Curve::Line { start, end }) => {
                let u = unit(sub(end, start));
                let foot = add(start, scaled(u, dot(sub(center, start), u)));
                on_both_sides(foot, u, radius * radius - dot(sub(foot, center), sub(foot, center)), radius)
            }
            (Curve::Arc { center: a, radius: r, .. }, Curve::Arc { center: b, radius: s, .. }) => {
                let apart = distance(a, b);
                if apart < SAME_MM {
                    return Crossings::default();
                }
                let u = unit(sub(b, a));
                let x = (apart * apart + r * r - s * s) / (2.0 * apart);
                on_both_sides(add(a, scaled(u, x)), left(u), r * r - x * x, r.max(s))
            }
        }
    }

    /// The part between two lengths along the curve, which may be beyond its ends.
    pub(super) fn part(&self, from: f64, to: f64) -> Curve {
        match *self {
            Curve::Line { .. } => Curve::Line { start: self.at(from), end: self.at(to) },
            Curve::Arc { center, radius, from: angle, sweep } => Curve::Arc {
                center,
                radius,
                from: angle + from / radius * sweep.signum(),
                sweep: ((to - from) / radius).max(0.0) * sweep.signum(),
            },
        }
    }

    /// Distance of a point from the curve between its ends.
    pub(super) fn distance(&self, point: Flat) -> f64 {
        let ends = distance(point, self.start()).min(distance(point, self.end()));
        let along = self.along(point, self.length() / 2.0);
        let inside = match *self {
            Curve::Line { .. } => (0.0..=self.length()).contains(&along),
            Curve::Arc { sweep, .. } if sweep.abs() >= TAU => true,
            Curve::Arc { .. } => (0.0..=self.length()).contains(&along),
        };
        if !inside {
            return ends;
        }
        match *self {
            Curve::Line { start, end } => cross(unit(sub(end, start)), sub(point, start)).abs().min(ends),
            Curve::Arc { center, radius, .. } => (distance(point, center) - radius).abs().min(ends),
        }
    }

    /// Turns beyond the arc itself.
    pub(super) fn extra_turns(&self) -> u32 {
        match *self {
            Curve::Line { .. } => 0,
            // A full circle is one turn without extra turns.
            Curve::Arc { sweep, .. } => ((sweep.abs() - 1e-9) / TAU).floor().clamp(0.0, 1e6) as u32,
        }
    }

    /// `true` if all its numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        match *self {
            Curve::Line { start, end } => start.iter().chain(&end).all(|value| value.is_finite()),
            Curve::Arc { center, radius, from, sweep } => {
                center.iter().chain(&[radius, from, sweep]).all(|value| value.is_finite())
            }
        }
    }
}

/// Up to two points.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Crossings(pub(super) [Option<Flat>; 2]);

impl Crossings {
    pub(super) fn iter(&self) -> impl Iterator<Item = Flat> + '_ {
        self.0.iter().flatten().copied()
    }
}

/// Points on both sides of a foot point; one if the curves only touch, within rounding.
fn on_both_sides(foot: Flat, direction: Flat, square: f64, size: f64) -> Crossings {
    if square < -SAME_MM * size.max(SAME_MM) {
        return Crossings::default();
    }
    let half = square.max(0.0).sqrt();
    Crossings([Some(add(foot, scaled(direction, half))), Some(add(foot, scaled(direction, -half)))])
}

/// Angle between two unit directions, rad, 0 to a half turn.
pub(super) fn angle_between(a: Flat, b: Flat) -> f64 {
    cross(a, b).atan2(dot(a, b)).abs().min(PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_lie_to_the_left() {
        let line = Curve::Line { start: [0.0, 0.0], end: [10.0, 0.0] };
        assert_eq!(line.offset(2.0), Some(Curve::Line { start: [0.0, 2.0], end: [10.0, 2.0] }));
        let ccw = Curve::arc([10.0, 0.0], [0.0, 10.0], [0.0, 0.0], false, 0);
        assert!(matches!(ccw.offset(4.0), Some(Curve::Arc { radius, .. }) if radius == 6.0));
        assert_eq!(ccw.offset(10.0), None);
        let cw = Curve::arc([0.0, 10.0], [10.0, 0.0], [0.0, 0.0], true, 0);
        assert!(matches!(cw.offset(4.0), Some(Curve::Arc { radius, .. }) if radius == 14.0));
    }

    #[test]
    fn curves_cross_where_arithmetic_says() {
        let line = Curve::Line { start: [-9.0, 3.0], end: [9.0, 3.0] };
        let circle = Curve::arc([5.0, 0.0], [5.0, 0.0], [0.0, 0.0], false, 0);
        let mut points: Vec<Flat> = line.crossings(&circle).iter().collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(points, [[-4.0, 3.0], [4.0, 3.0]]);
        let other = Curve::arc([13.0, 0.0], [13.0, 0.0], [8.0, 0.0], true, 0);
        let points: Vec<Flat> = circle.crossings(&other).iter().collect();
        assert!(points.iter().all(|p| distance(*p, [4.0, p[1].signum() * 3.0]) < 1e-12), "{points:?}");
        assert!((circle.distance([3.0, 0.0]) - 2.0).abs() < 1e-12);
        assert!((line.distance([13.0, 0.0]) - 5.0).abs() < 1e-12);
    }
}
