//! Circular arcs and helices in one of the three principal planes.
//!
//! An arc is defined by its start, its end, its center in the plane, its direction and the number of extra full turns. The axis perpendicular to the plane,
//! and every other axis, moves linearly with the swept angle.

use std::f64::consts::TAU;

use super::{Axis, AxisVector, Vector};

/// Working plane, by the G code that selects it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Plane {
    /// G17: abscissa X, ordinate Y, applicate Z.
    #[default]
    XY,
    /// G18: abscissa Z, ordinate X, applicate Y.
    ZX,
    /// G19: abscissa Y, ordinate Z, applicate X.
    YZ,
}

impl Plane {
    /// Returns abscissa, ordinate and applicate: right-handed in this order.
    #[must_use]
    pub fn axes(self) -> [Axis; 3] {
        match self {
            Plane::XY => [Axis::X, Axis::Y, Axis::Z],
            Plane::ZX => [Axis::Z, Axis::X, Axis::Y],
            Plane::YZ => [Axis::Y, Axis::Z, Axis::X],
        }
    }

    /// Returns the number 17, 18 or 19.
    #[must_use]
    pub fn number(self) -> u8 {
        match self {
            Plane::XY => 17,
            Plane::ZX => 18,
            Plane::YZ => 19,
        }
    }

    /// Returns the plane of 17, 18 or 19.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Plane> {
        [Plane::XY, Plane::ZX, Plane::YZ].into_iter().find(|plane| plane.number() == number)
    }
}

/// Reason why start, end and center do not define an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CenterFault {
    /// The radii at start and end differ, or the center is off the perpendicular bisector.
    OffCircle {
        /// Distance of the center from the start, mm.
        start_radius_mm: f64,
        /// Distance of the center from the end, mm.
        end_radius_mm: f64,
        /// Distance of the center from the perpendicular bisector of the chord, mm.
        off_bisector_mm: f64,
    },
    /// The radius is zero.
    ZeroRadius,
    /// A number overflowed.
    NotFinite,
}

/// Arc or helix without its start, which the user stores: center, direction, sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Plane of the circle.
    pub plane: Plane,
    /// True for G2, viewed against the applicate.
    pub clockwise: bool,
    /// Center: abscissa and ordinate, absolute, mm.
    pub center_mm: [f64; 2],
    /// Full turns beyond the arc itself (Sinumerik TURN).
    pub extra_turns: u32,
}

/// Distance in the plane, mm, below which start and end are one point and the arc is a full circle.
const SAME_POINT_MM: f64 = 1e-9;
/// Largest squared angle at the start between the lines to the programmed center and to the center on the bisector, rad² (Sinumerik alarm 14040).
const CENTER_ANGLE_SQUARED: f64 = 0.001;

impl Arc {
    /// Builds the arc like a Sinumerik: the center moves onto the perpendicular bisector of the chord, start and end stay. The radii at start and end may
    /// differ by `tolerance_mm` of the radius at the start. The center may be off the bisector by this length, or by √0.001 rad as seen from the start.
    ///
    /// # Errors
    /// If the radii differ by more, the center is off by more, or the radius is zero.
    pub fn through(
        plane: Plane,
        clockwise: bool,
        start: &AxisVector,
        end: &AxisVector,
        center_mm: [f64; 2],
        extra_turns: u32,
        tolerance_mm: impl Fn(f64) -> f64,
    ) -> Result<Arc, CenterFault> {
        let [abscissa, ordinate, _] = plane.axes();
        let (s, e) = ([start[abscissa], start[ordinate]], [end[abscissa], end[ordinate]]);
        let start_radius_mm = (s[0] - center_mm[0]).hypot(s[1] - center_mm[1]);
        let end_radius_mm = (e[0] - center_mm[0]).hypot(e[1] - center_mm[1]);
        if !(start_radius_mm.is_finite() && end_radius_mm.is_finite()) {
            return Err(CenterFault::NotFinite);
        }
        if start_radius_mm < SAME_POINT_MM {
            return Err(CenterFault::ZeroRadius);
        }
        let chord = [e[0] - s[0], e[1] - s[1]];
        let length = chord[0].hypot(chord[1]);
        let mut arc = Arc { plane, clockwise, center_mm, extra_turns };
        if length < SAME_POINT_MM {
            return Ok(arc);
        }
        let tolerance_mm = tolerance_mm(start_radius_mm);
        let unit = [chord[0] / length, chord[1] / length];
        let middle = [s[0].midpoint(e[0]), s[1].midpoint(e[1])];
        let off_bisector = (center_mm[0] - middle[0]) * unit[0] + (center_mm[1] - middle[1]) * unit[1];
        let off_radius = (start_radius_mm - end_radius_mm).abs();
        arc.center_mm = [center_mm[0] - off_bisector * unit[0], center_mm[1] - off_bisector * unit[1]];
        let is_near = off_bisector.abs() <= tolerance_mm || {
            // The two centers are on a line parallel to the chord, this far from it.
            let height = (center_mm[1] - s[1]) * unit[0] - (center_mm[0] - s[0]) * unit[1];
            let angle = height.atan2(length / 2.0 + off_bisector) - height.atan2(length / 2.0);
            let moved_radius_mm = (s[0] - arc.center_mm[0]).hypot(s[1] - arc.center_mm[1]);
            angle * angle < CENTER_ANGLE_SQUARED && (moved_radius_mm - start_radius_mm).abs() <= tolerance_mm
        };
        if off_radius > tolerance_mm || !is_near {
            return Err(CenterFault::OffCircle { start_radius_mm, end_radius_mm, off_bisector_mm: off_bisector.abs() });
        }
        Ok(arc)
    }

    /// Builds the arc like LinuxCNC and a Fanuc: the center stays as programmed. If the radii at start and end differ, by at most `tolerance_mm` of the larger one, the
    /// path between them is a spiral.
    ///
    /// # Errors
    /// If the radii differ by more, or the radius is zero.
    pub fn spiral(
        plane: Plane,
        clockwise: bool,
        start: &AxisVector,
        end: &AxisVector,
        center_mm: [f64; 2],
        extra_turns: u32,
        tolerance_mm: impl Fn(f64) -> f64,
    ) -> Result<Arc, CenterFault> {
        let arc = Arc { plane, clockwise, center_mm, extra_turns };
        let (start_radius_mm, end_radius_mm) = (arc.radius_mm(start), arc.radius_mm(end));
        if !(start_radius_mm.is_finite() && end_radius_mm.is_finite()) {
            return Err(CenterFault::NotFinite);
        }
        if start_radius_mm < SAME_POINT_MM {
            return Err(CenterFault::ZeroRadius);
        }
        if (start_radius_mm - end_radius_mm).abs() > tolerance_mm(start_radius_mm.max(end_radius_mm)) {
            let [abscissa, ordinate, _] = plane.axes();
            let chord = (end[abscissa] - start[abscissa]).hypot(end[ordinate] - start[ordinate]);
            // Law of cosines in the triangle of start, end and center.
            let off_bisector_mm = (start_radius_mm.powi(2) - end_radius_mm.powi(2)).abs() / (2.0 * chord);
            return Err(CenterFault::OffCircle { start_radius_mm, end_radius_mm, off_bisector_mm });
        }
        Ok(arc)
    }

    /// Returns the radius at the start, mm.
    #[must_use]
    pub fn radius_mm(&self, start: &AxisVector) -> f64 {
        let [abscissa, ordinate, _] = self.plane.axes();
        (start[abscissa] - self.center_mm[0]).hypot(start[ordinate] - self.center_mm[1])
    }

    /// Returns the signed angle swept from start to end, rad: positive counter-clockwise, a full circle if both coincide, plus the extra turns.
    #[must_use]
    pub fn sweep_rad(&self, start: &AxisVector, end: &AxisVector) -> f64 {
        let from = self.angle_rad(start);
        let to = self.angle_rad(end);
        let [abscissa, ordinate, _] = self.plane.axes();
        let same = (start[abscissa] - end[abscissa]).hypot(start[ordinate] - end[ordinate]) < SAME_POINT_MM;
        let turns = f64::from(self.extra_turns) * TAU;
        let part = if same {
            TAU
        } else if self.clockwise {
            (from - to).rem_euclid(TAU)
        } else {
            (to - from).rem_euclid(TAU)
        };
        if self.clockwise { -(part + turns) } else { part + turns }
    }

    /// Returns the angle of a point about the center, rad, from the abscissa.
    fn angle_rad(&self, point: &AxisVector) -> f64 {
        let [abscissa, ordinate, _] = self.plane.axes();
        (point[ordinate] - self.center_mm[1]).atan2(point[abscissa] - self.center_mm[0])
    }

    /// Returns the position at `fraction` (0 … 1) of the sweep; exact at both ends. If the radius differs at the end, it changes in proportion.
    #[must_use]
    pub fn at(&self, start: &AxisVector, end: &AxisVector, fraction: f64) -> AxisVector {
        if fraction <= 0.0 {
            return *start;
        }
        if fraction >= 1.0 {
            return *end;
        }
        let [abscissa, ordinate, _] = self.plane.axes();
        let mut out = start.lerp(end, fraction);
        let angle = self.angle_rad(start) + self.sweep_rad(start, end) * fraction;
        let radius = self.radius_mm(start) * (1.0 - fraction) + self.radius_mm(end) * fraction;
        out[abscissa] = self.center_mm[0] + radius * angle.cos();
        out[ordinate] = self.center_mm[1] + radius * angle.sin();
        out
    }

    /// Returns center minus start along X, Y, Z, mm: the I J K of the flat stream (0 perpendicular to the plane).
    #[must_use]
    pub fn center_from_start_mm(&self, start: &AxisVector) -> Vector {
        let [abscissa, ordinate, _] = self.plane.axes();
        let mut ijk = Vector::zeros();
        ijk[abscissa.slot()] = self.center_mm[0] - start[abscissa];
        ijk[ordinate.slot()] = self.center_mm[1] - start[ordinate];
        ijk
    }

    /// Returns the length of the path in space, mm: that of the helix if the applicate also moves.
    #[must_use]
    pub fn length_mm(&self, start: &AxisVector, end: &AxisVector) -> f64 {
        let across = self.plane.axes()[2];
        let radius = self.radius_mm(start).midpoint(self.radius_mm(end));
        (radius * self.sweep_rad(start, end)).hypot(end[across] - start[across])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn at(x: f64, y: f64, z: f64) -> AxisVector {
        AxisVector([x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    #[test]
    fn a_quarter_turns_by_a_right_angle_in_every_plane() {
        let ccw = Arc { plane: Plane::XY, clockwise: false, center_mm: [0.0, 0.0], extra_turns: 0 };
        assert!((ccw.sweep_rad(&at(10.0, 0.0, 0.0), &at(0.0, 10.0, 0.0)) - FRAC_PI_2).abs() < 1e-15);
        // G18: abscissa Z, ordinate X; from +Z to +X is a positive quarter about +Y.
        let zx = Arc { plane: Plane::ZX, clockwise: false, center_mm: [0.0, 0.0], extra_turns: 0 };
        assert!((zx.sweep_rad(&at(0.0, 0.0, 10.0), &at(10.0, 0.0, 0.0)) - FRAC_PI_2).abs() < 1e-15);
        let cw = Arc { clockwise: true, ..ccw };
        assert!((cw.sweep_rad(&at(10.0, 0.0, 0.0), &at(0.0, 10.0, 0.0)) + 3.0 * FRAC_PI_2).abs() < 1e-15);
    }

    #[test]
    fn full_circles_and_turns_add_up() {
        let arc = Arc { plane: Plane::XY, clockwise: false, center_mm: [0.0, 0.0], extra_turns: 2 };
        let (start, end) = (at(10.0, 0.0, 0.0), at(10.0, 0.0, -9.0));
        assert!((arc.sweep_rad(&start, &end) - 6.0 * PI).abs() < 1e-12);
        let middle = arc.at(&start, &end, 0.5);
        assert!((middle.xyz() - Vector::new(-10.0, 0.0, -4.5)).norm() < 1e-12);
    }

    #[test]
    fn a_center_within_tolerance_moves_onto_the_bisector_and_beyond_is_refused() {
        let (start, end) = (at(10.0, 0.0, 0.0), at(0.0, 10.0, 0.0));
        let arc = Arc::through(Plane::XY, false, &start, &end, [0.003, -0.003], 0, |_| 0.01).unwrap();
        assert!((arc.radius_mm(&start) - arc.radius_mm(&end)).abs() < 1e-12);
        let fault = Arc::through(Plane::XY, false, &start, &end, [0.02, -0.02], 0, |_| 0.01);
        assert!(matches!(fault, Err(CenterFault::OffCircle { .. })));
    }

    /// Off the bisector by 0.1495 mm, which is 0.857° as seen from the start, with radii 10 and 9.9925.
    #[test]
    fn a_short_chord_is_checked_by_the_angle_of_its_center() {
        let (start, end) = (at(0.0, 0.0, 0.0), at(0.02, -0.5, 0.0));
        let arc = Arc::through(Plane::XY, false, &start, &end, [10.0, 0.0], 0, |_| 0.01).unwrap();
        assert!((arc.radius_mm(&start) - arc.radius_mm(&end)).abs() < 1e-12);
        // The foot of the perpendicular: 10 - 0.1495 · 0.03997, and 0.1495 · 0.99920.
        assert!((arc.center_mm[0] - 9.99402).abs() < 1e-4 && (arc.center_mm[1] - 0.14938).abs() < 1e-4, "{arc:?}");
    }

    /// The end is 5 µm inside of the circle, at the angle of the start: on the bisector of this chord there is no circle of this size.
    #[test]
    fn a_chord_along_the_radius_is_refused() {
        let (start, end) = (at(0.0, 0.0, 0.0), at(0.005, 0.0, 0.0));
        let fault = Arc::through(Plane::XY, false, &start, &end, [10.0, 0.0], 0, |_| 0.01);
        assert!(matches!(fault, Err(CenterFault::OffCircle { .. })));
    }

    #[test]
    fn a_spiral_keeps_its_center_and_changes_its_radius_with_the_angle() {
        let (start, end) = (at(10.0, 0.0, 0.0), at(0.0, 10.02, 0.0));
        let arc = Arc::spiral(Plane::XY, false, &start, &end, [0.0, 0.0], 0, |radius| 0.0021 * radius).unwrap();
        let middle = arc.at(&start, &end, 0.5);
        let radius = 10.01 * std::f64::consts::FRAC_1_SQRT_2;
        assert!((middle.xyz() - Vector::new(radius, radius, 0.0)).norm() < 1e-12);
        let fault = Arc::spiral(Plane::XY, false, &start, &end, [0.0, 0.0], 0, |radius| 0.0019 * radius);
        assert!(matches!(fault, Err(CenterFault::OffCircle { .. })));
    }
}
