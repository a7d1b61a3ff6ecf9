//! Positions as whole numbers of the smallest programmable increment of the control.

use ncfix_base::geometry::Axis;
use ncfix_base::units::MM_PER_INCH;
use ncfix_machine::machine::Control;

/// Deviation of a bend in addition to rounding, as a share of the rounding.
const BEND_SHARE: f64 = 0.25;

/// The increments of a control: mm for linear axes, degrees for rotary axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Increments {
    /// Smallest step of a linear axis in a program, mm.
    pub linear_mm: f64,
    /// Smallest step of a rotary axis in a program, degrees.
    pub rotary_deg: f64,
    /// The length unit of the program, mm.
    pub unit_mm: f64,
}

impl Increments {
    /// The increments of a control.
    #[must_use]
    pub fn new(control: &Control) -> Increments {
        // The increment is a short decimal in degrees; the conversion through radians must not alter the last digits.
        let rotary_deg = (control.increment_rad.to_degrees() * 1e12).round() / 1e12;
        let (unit_mm, share) = match (control.output_inch == Some(true), control.has_inch_grid) {
            (false, _) => (1.0, 1.0),
            (true, true) => (MM_PER_INCH, MM_PER_INCH / 10.0),
            (true, false) => (MM_PER_INCH, MM_PER_INCH / 100.0),
        };
        Increments { linear_mm: control.increment_mm * share, rotary_deg, unit_mm }
    }

    /// Largest tip displacement due to rounding of the linear axes, mm: half an increment in each of three directions.
    #[must_use]
    pub fn rounding_mm(&self) -> f64 {
        0.5 * 3.0_f64.sqrt() * self.linear_mm
    }

    /// Allowed deviation of the tip for a promised tolerance, mm. If rounding exceeds the tolerance, the bend of a piece, or the rounded center of an
    /// arc, adds a share of it.
    #[must_use]
    pub fn allowed_mm(&self, tolerance_mm: f64) -> f64 {
        let rounding_mm = self.rounding_mm();
        tolerance_mm.max(rounding_mm) + BEND_SHARE * rounding_mm
    }

    /// The nearest whole number of increments to an axis position (mm, rad).
    #[must_use]
    pub fn count(&self, axis: Axis, position: f64) -> i64 {
        self.ratio(axis, position).round() as i64
    }

    /// The position in increments, unrounded.
    #[must_use]
    pub fn ratio(&self, axis: Axis, position: f64) -> f64 {
        if axis.is_rotary() { position.to_degrees() / self.rotary_deg } else { position / self.linear_mm }
    }

    /// The position of an axis (mm, rad) at a number of increments.
    #[must_use]
    pub fn position(&self, axis: Axis, count: i64) -> f64 {
        if axis.is_rotary() { (count as f64 * self.rotary_deg).to_radians() } else { count as f64 * self.linear_mm }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_of_counts_count_back_to_themselves() {
        let increments = Increments::new(&Control::default());
        assert_eq!(increments.rotary_deg, 1e-4);
        for count in [-3_600_001, -1, 0, 1, 7, 123_456_789, 900_000_000_000] {
            for axis in [Axis::X, Axis::C] {
                assert_eq!(increments.count(axis, increments.position(axis, count)), count);
            }
        }
        assert_eq!(increments.count(Axis::Y, 12.345_649), 123_456);
        assert_eq!(increments.count(Axis::A, 90_f64.to_radians()), 900_000);
    }
}
