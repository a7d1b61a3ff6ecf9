//! Polar coordinates: radius and angle of the plane instead of its two axes.
//!
//! Fanuc (G16, operator's manual "polar coordinate command"): under G90 a radius is measured from the program zero, under G91 from the tool position;
//! an angle under G91 adds to the last one. Without a radius the distance from the zero stays. LinuxCNC (`@` and `^`, user manual "polar
//! coordinates"): about the program zero, under G91 as increments of both.

/// State while G16 is active.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Polar {
    /// The last angle, rad.
    angle_rad: Option<f64>,
}

impl Polar {
    /// Target of a block; lengths mm, angles rad.
    pub(super) fn target(
        &mut self,
        here: [f64; 2],
        radius: Option<f64>,
        angle_rad: Option<f64>,
        incremental: bool,
    ) -> [f64; 2] {
        let last = self.angle_rad.unwrap_or_else(|| angle_of(here));
        let angle = match angle_rad {
            Some(angle) if incremental => last + angle,
            Some(angle) => angle,
            None => last,
        };
        self.angle_rad = Some(angle);
        match radius {
            Some(radius) if incremental => at(here, radius, angle),
            Some(radius) => at([0.0; 2], radius, angle),
            None => at([0.0; 2], here[0].hypot(here[1]), angle),
        }
    }
}

/// Target of `@` and `^`; lengths mm, angles rad. `None` if the direction from the zero to itself is needed.
pub(super) fn rs274(
    here: [f64; 2],
    radius: Option<f64>,
    angle_rad: Option<f64>,
    incremental: bool,
) -> Option<[f64; 2]> {
    let needs_angle = if incremental { true } else { angle_rad.is_none() };
    if needs_angle && here == [0.0; 2] {
        return None;
    }
    let (size, angle) = (here[0].hypot(here[1]), angle_of(here));
    let (size, angle) = if incremental {
        (size + radius.unwrap_or(0.0), angle + angle_rad.unwrap_or(0.0))
    } else {
        (radius.unwrap_or(size), angle_rad.unwrap_or(angle))
    };
    Some(at([0.0; 2], size, angle))
}

fn angle_of(place: [f64; 2]) -> f64 {
    place[1].atan2(place[0])
}

fn at(center: [f64; 2], radius: f64, angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    [center[0] + radius * cos, center[1] + radius * sin]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn near(found: [f64; 2], wanted: [f64; 2]) {
        assert!((found[0] - wanted[0]).hypot(found[1] - wanted[1]) < 1e-12, "{found:?} {wanted:?}");
    }

    fn deg(angle: f64) -> Option<f64> {
        Some(angle.to_radians())
    }

    #[test]
    fn a_missing_radius_keeps_the_distance_from_the_zero() {
        let mut polar = Polar::default();
        let here = polar.target([0.0; 2], Some(10.0), deg(30.0), false);
        near(here, [75_f64.sqrt(), 5.0]);
        let here = polar.target(here, None, deg(60.0), true);
        near(here, [0.0, 10.0]);
        near(polar.target(here, Some(20.0), deg(180.0), false), [-20.0, 0.0]);
    }

    #[test]
    fn a_radius_behind_g91_counts_from_the_tool_and_a_missing_angle_is_the_last() {
        let mut polar = Polar::default();
        let here = polar.target([0.0; 2], Some(10.0), deg(0.0), false);
        let here = polar.target(here, Some(5.0), deg(90.0), true);
        near(here, [10.0, 5.0]);
        near(polar.target(here, Some(5.0), None, true), [10.0, 10.0]);
        near(polar.target(here, Some(3.0), None, false), [0.0, 3.0]);
    }

    #[test]
    fn rs274_words_are_about_the_zero() {
        near(rs274([3.0, 4.0], Some(10.0), None, false).unwrap(), [6.0, 8.0]);
        near(rs274([3.0, 4.0], None, deg(90.0), false).unwrap(), [0.0, 5.0]);
        near(rs274([0.0, 0.0], Some(2.0), deg(180.0), false).unwrap(), [-2.0, 0.0]);
        near(rs274([0.0, 5.0], Some(1.0), deg(90.0), true).unwrap(), [-6.0, 0.0]);
        assert_eq!(rs274([0.0, 0.0], Some(2.0), None, false), None);
        assert_eq!(rs274([0.0, 0.0], Some(2.0), deg(10.0), true), None);
    }
}
