//! G64: the intersection of two contour elements if the first one is programmed without its end.
//!
//! Elements are straight lines and arcs of the plane. The first begins at the tool position; the second gives its direction and end. A line has an
//! angle (B1=) or is tangential to the adjacent arc (K1=), an arc has a center. J1= selects one of two intersections: 1, the default, is the one that
//! the tool reaches first on the first element, 2 the other.

use std::f64::consts::TAU;

use crate::exec::core::contour::crossing;

type Flat = [f64; 2];

/// Distance below which circles count as touching, mm.
const TOUCH_MM: f64 = 1e-4;

/// An element of a contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Element {
    /// Straight, at an angle to the abscissa, rad.
    Line { angle_rad: f64 },
    /// Straight, and tangential to the adjacent arc.
    Touching,
    /// On a circle about this center, mm.
    Arc { center: Flat, clockwise: bool },
}

/// Selection of one of two intersections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Choice {
    /// The one reached first.
    #[default]
    First,
    /// The other.
    Second,
}

/// Reason why two elements do not meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MeetFault {
    /// Lines in the same direction, or circles about one center.
    Parallel,
    /// They do not intersect.
    Apart,
    /// A tangential line next to another line, or a line whose end lies inside the circle.
    NothingToTouch,
}

impl MeetFault {
    /// The message.
    pub(super) fn message(self) -> &'static str {
        match self {
            MeetFault::Parallel => "this element and the previous one never meet: they have the same direction",
            MeetFault::Apart => "this element and the previous one do not meet",
            MeetFault::NothingToTouch => "there is no arc that is tangent to this line",
        }
    }
}

/// The intersection of the first element, starting at `start`, with the second, which ends at `end`.
///
/// # Errors
/// A reason if they do not meet.
pub(super) fn meet(start: Flat, first: Element, second: Element, end: Flat, choice: Choice) -> Result<Flat, MeetFault> {
    match (first, second) {
        (Element::Line { angle_rad: a }, Element::Line { angle_rad: b }) => {
            crossing((start, a), (end, b)).ok_or(MeetFault::Parallel)
        }
        (Element::Line { angle_rad }, Element::Arc { center, .. }) => {
            let points = line_and_circle(start, angle_rad, center, distance(end, center))?;
            let (sin, cos) = angle_rad.sin_cos();
            let ahead = |point: Flat| (point[0] - start[0]) * cos + (point[1] - start[1]) * sin;
            Ok(chosen(points, ahead, choice))
        }
        (Element::Arc { center, clockwise }, Element::Line { angle_rad }) => {
            let points = line_and_circle(end, angle_rad, center, distance(start, center))?;
            Ok(chosen(points, |point| sweep(start, point, center, clockwise), choice))
        }
        (Element::Arc { center, clockwise }, Element::Arc { center: other, .. }) => {
            let points = two_circles(center, distance(start, center), other, distance(end, other))?;
            Ok(chosen(points, |point| sweep(start, point, center, clockwise), choice))
        }
        // The line arrives in the direction in which the arc continues.
        (Element::Touching, Element::Arc { center, clockwise }) => {
            touching(start, center, distance(end, center), !clockwise)
        }
        // Seen from its end, the line leaves the arc in the opposite direction.
        (Element::Arc { center, clockwise }, Element::Touching) => {
            touching(end, center, distance(start, center), clockwise)
        }
        (Element::Touching, _) | (_, Element::Touching) => Err(MeetFault::NothingToTouch),
    }
}

fn distance(a: Flat, b: Flat) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The angle of an arc from one point of its circle to another, rad, above 0.
fn sweep(from: Flat, to: Flat, center: Flat, clockwise: bool) -> f64 {
    let angle = |point: Flat| (point[1] - center[1]).atan2(point[0] - center[0]);
    let way = if clockwise { angle(from) - angle(to) } else { angle(to) - angle(from) }.rem_euclid(TAU);
    // The start itself counts as a full turn.
    if way < 1e-9 { way + TAU } else { way }
}

/// The first of two points ahead, or the other.
fn chosen(points: [Flat; 2], ahead: impl Fn(Flat) -> f64, choice: Choice) -> Flat {
    let [a, b] = points.map(|point| match ahead(point) {
        way if way > 1e-9 => way,
        way => f64::MAX / 2.0 - way,
    });
    if (a <= b) == (choice == Choice::First) { points[0] } else { points[1] }
}

fn line_and_circle(point: Flat, angle_rad: f64, center: Flat, radius: f64) -> Result<[Flat; 2], MeetFault> {
    let (sin, cos) = angle_rad.sin_cos();
    let along = (center[0] - point[0]) * cos + (center[1] - point[1]) * sin;
    let foot = [point[0] + along * cos, point[1] + along * sin];
    let off = distance(foot, center);
    if off > radius + TOUCH_MM {
        return Err(MeetFault::Apart);
    }
    let half = (radius * radius - off * off).max(0.0).sqrt();
    Ok([-half, half].map(|by| [foot[0] + by * cos, foot[1] + by * sin]))
}

fn two_circles(a: Flat, radius_a: f64, b: Flat, radius_b: f64) -> Result<[Flat; 2], MeetFault> {
    let between = distance(a, b);
    if between < TOUCH_MM {
        return Err(MeetFault::Parallel);
    }
    let is_apart = between > radius_a + radius_b + TOUCH_MM || between < (radius_a - radius_b).abs() - TOUCH_MM;
    if is_apart {
        return Err(MeetFault::Apart);
    }
    let along = (radius_a * radius_a - radius_b * radius_b + between * between) / (2.0 * between);
    let half = (radius_a * radius_a - along * along).max(0.0).sqrt();
    let unit = [(b[0] - a[0]) / between, (b[1] - a[1]) / between];
    let foot = [a[0] + along * unit[0], a[1] + along * unit[1]];
    Ok([-half, half].map(|by| [foot[0] - by * unit[1], foot[1] + by * unit[0]]))
}

/// The tangent point of a line from a point outside a circle, for a counter-clockwise or clockwise direction about the center.
fn touching(point: Flat, center: Flat, radius: f64, counter_clockwise: bool) -> Result<Flat, MeetFault> {
    let away = distance(point, center);
    if away < radius - TOUCH_MM || radius == 0.0 {
        return Err(MeetFault::NothingToTouch);
    }
    // The angle at the center between the point and the tangent point.
    let angle = (radius / away).min(1.0).acos();
    let towards = (point[1] - center[1]).atan2(point[0] - center[0]);
    let (sin, cos) = if counter_clockwise { towards + angle } else { towards - angle }.sin_cos();
    Ok([center[0] + radius * cos, center[1] + radius * sin])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(found: Result<Flat, MeetFault>, expected: Flat) {
        let found = found.unwrap();
        assert!(distance(found, expected) < 1e-9, "{found:?} is not {expected:?}");
    }

    #[test]
    fn lines_meet_where_their_angles_lead() {
        let line = |degrees: f64| Element::Line { angle_rad: degrees.to_radians() };
        check(meet([0.0, 0.0], line(45.0), line(0.0), [30.0, 10.0], Choice::First), [10.0, 10.0]);
        let found = meet([0.0, 0.0], line(45.0), line(45.0), [30.0, 10.0], Choice::First);
        assert_eq!(found, Err(MeetFault::Parallel));
    }

    #[test]
    fn a_line_meets_a_circle_twice() {
        // Circle of radius 5 about (10, 3): the abscissa cuts it at 10 - 4 and 10 + 4.
        let (line, arc) = (Element::Line { angle_rad: 0.0 }, Element::Arc { center: [10.0, 3.0], clockwise: true });
        check(meet([0.0, 0.0], line, arc, [10.0, 8.0], Choice::First), [6.0, 0.0]);
        check(meet([0.0, 0.0], line, arc, [10.0, 8.0], Choice::Second), [14.0, 0.0]);
        // From inside, the first is the one ahead.
        check(meet([10.0, 0.0], line, arc, [10.0, 8.0], Choice::First), [14.0, 0.0]);
        let far = Element::Arc { center: [10.0, 9.0], clockwise: true };
        assert_eq!(meet([0.0, 0.0], line, far, [10.0, 14.0], Choice::First), Err(MeetFault::Apart));
        // Clockwise from the top of the circle, the abscissa is crossed on the right first, counter-clockwise on the left.
        let (cw, ccw) = (arc, Element::Arc { center: [10.0, 3.0], clockwise: false });
        check(meet([10.0, 8.0], cw, line, [50.0, 0.0], Choice::First), [14.0, 0.0]);
        check(meet([10.0, 8.0], ccw, line, [50.0, 0.0], Choice::First), [6.0, 0.0]);
    }

    #[test]
    fn two_circles_meet_twice() {
        // Radii 5 about (0, 0) and (6, 0): at (3, ±4).
        let (a, b) = (
            Element::Arc { center: [0.0, 0.0], clockwise: false },
            Element::Arc { center: [6.0, 0.0], clockwise: true },
        );
        check(meet([5.0, 0.0], a, b, [11.0, 0.0], Choice::First), [3.0, 4.0]);
        check(meet([5.0, 0.0], a, b, [11.0, 0.0], Choice::Second), [3.0, -4.0]);
    }

    #[test]
    fn tangents_go_the_way_of_the_arc() {
        // From (-13, 0) to the circle of radius 5 about the origin: at distance 12, touching at (-25/13, ±60/13).
        let (x, y) = (-25.0 / 13.0, 60.0 / 13.0);
        let arc = |clockwise| Element::Arc { center: [0.0, 0.0], clockwise };
        // Passing over the top to the right is clockwise.
        check(meet([-13.0, 0.0], Element::Touching, arc(true), [5.0, 0.0], Choice::First), [x, y]);
        check(meet([-13.0, 0.0], Element::Touching, arc(false), [5.0, 0.0], Choice::First), [x, -y]);
        // From the arc to (13, 0): clockwise, the line leaves at the top.
        check(meet([-5.0, 0.0], arc(true), Element::Touching, [13.0, 0.0], Choice::First), [-x, y]);
        check(meet([-5.0, 0.0], arc(false), Element::Touching, [13.0, 0.0], Choice::First), [-x, -y]);
        let inside = meet([1.0, 0.0], Element::Touching, arc(true), [5.0, 0.0], Choice::First);
        assert_eq!(inside, Err(MeetFault::NothingToTouch));
    }
}
