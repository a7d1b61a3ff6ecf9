//! Squareness of two axes from two diagonals, or from a square and a dial gauge.
//!
//! γ is the angle between the positive motions of the tool relative to the workpiece, minus 90°. With sides a and b, the diagonal d1 from the corner with the
//! smallest positions to the one with the largest, and d2 the other one, the law of cosines gives d1² = a² + b² − 2ab sin γ and d2² = a² + b² + 2ab sin γ. So
//! sin γ = (d2² − d1²) / 4ab.

use super::kind::location;
use ncfix_base::units::urad_from_rad;
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::squareness::SquarenessTerm;
use ncfix_model::ErrorModel;

/// Largest angle that counts as a squareness, rad: beyond it a number is wrong.
const MOST_RAD: f64 = 0.05;
/// Largest angle by a square and a dial gauge, rad: beyond it the reading is probably in µm.
const MOST_DIAL_RAD: f64 = 0.005;
/// Largest deviation of the diagonals from the length that the sides require: a share of it for a part that is not cut to size, and a multiple of the
/// reading uncertainty.
const MOST_SHARE: f64 = 1e-3;
const MOST_READINGS: f64 = 5.0;
/// As before, if the sides are measured: the mean of both diagonals may be off by one reading uncertainty, and their length by the sides by √2 of it.
const MOST_OF_MEASURED: f64 = 2.5;

/// Measured squareness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredSquareness {
    /// Angle between the positive motions minus 90°, rad.
    pub gamma_rad: f64,
    /// Standard uncertainty by the readings, rad.
    pub uncertainty_rad: f64,
}

/// The part of a squareness, as its location error counts it, that other errors of the machine file explain, µrad: a square shows the angle between the mean
/// lines of two motions, and a straightness may have a mean slope.
#[must_use]
pub fn explained_urad(machine: &Machine, errors: &ErrorModel, term: &SquarenessTerm) -> f64 {
    term.name.parse().map_or(0.0, |name| urad_from_rad(location::beside_location(machine, errors, name)))
}

/// Standard uncertainty of a reading within ± `limit`: all values in it are equally probable.
fn standard(limit: f64) -> f64 {
    limit / 3_f64.sqrt()
}

impl MeasuredSquareness {
    /// Calculates the angle from the diagonals d1 and d2 and the sides, mm. Each diagonal is read within ± `read_to_mm`, and
    /// so are the sides with `are_measured`; else the part may be cut with a wrong size.
    ///
    /// # Errors
    /// Returns a sentence if the lengths are not those of a parallelogram that is nearly a rectangle.
    pub fn of_diagonals(
        [d1, d2]: [f64; 2],
        ([a, b], are_measured): ([f64; 2], bool),
        read_to_mm: f64,
    ) -> Result<MeasuredSquareness, String> {
        let nominal = a.hypot(b);
        let mean = ((d1 * d1 + d2 * d2) / 2.0).sqrt();
        let most = if are_measured {
            MOST_OF_MEASURED * read_to_mm
        } else {
            MOST_SHARE * nominal + MOST_READINGS * read_to_mm
        };
        let wrong = mean - nominal;
        if wrong.is_nan() || wrong.abs() > most {
            return Err(format!(
                "sides of {a} and {b} mm have diagonals of {nominal:.3} mm; {d1} and {d2} mm do not fit: their mean is {:.3} mm too {}, and at most {most:.3} mm \
                 can come from reading. Measure the diagonals and the sides again, and give the measured sides with --sides",
                wrong.abs(),
                if wrong < 0.0 { "small" } else { "large" }
            ));
        }
        let sine = (d2 * d2 - d1 * d1) / (4.0 * a * b);
        Self::checked(sine.asin(), standard(read_to_mm) * mean / (2_f64.sqrt() * a * b))
    }

    /// Calculates the angle from a square whose first leg is aligned with the other axis: the reading of the dial gauge changes by `dial_mm` over the length
    /// `leg_mm` of the second leg. `+` is a plunger that is pressed in and points in the positive direction of the other axis.
    ///
    /// # Errors
    /// Returns a sentence if the angle is too large.
    pub fn of_dial(leg_mm: f64, dial_mm: f64, read_to_mm: f64) -> Result<MeasuredSquareness, String> {
        if (dial_mm / leg_mm).abs() > MOST_DIAL_RAD {
            return Err(format!(
                "a change of {dial_mm} mm over {leg_mm} mm is {:.1} mm/m, and more than {:.0} mm/m is no squareness of a machine: a number is wrong. \
                 --dial is in mm, so {dial_mm} µm is --dial {}",
                1000.0 * (dial_mm / leg_mm).abs(),
                1000.0 * MOST_DIAL_RAD,
                dial_mm / 1000.0
            ));
        }
        Self::checked((-dial_mm / leg_mm).atan(), standard(read_to_mm) * 2_f64.sqrt() / leg_mm)
    }

    fn checked(gamma_rad: f64, uncertainty_rad: f64) -> Result<MeasuredSquareness, String> {
        if gamma_rad.is_nan() || gamma_rad.abs() > MOST_RAD {
            return Err("the angle differs by more than 2.9° from 90°: a number is wrong".to_owned());
        }
        Ok(MeasuredSquareness { gamma_rad, uncertainty_rad })
    }

    /// Returns the diagonals d1 and d2 of a part with these sides, mm.
    #[must_use]
    pub fn diagonals_mm(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        let (squares, change) = (a * a + b * b, 2.0 * a * b * self.gamma_rad.sin());
        [(squares - change).sqrt(), (squares + change).sqrt()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_of_two_diagonals_is_found() {
        // 400 x 300 mm with 100 µrad: by the law of cosines √(250 000 ∓ 2 · 400 · 300 · 1e-4) mm.
        let made = MeasuredSquareness { gamma_rad: 1e-4, uncertainty_rad: 0.0 }.diagonals_mm([400.0, 300.0]);
        assert!((made[0] - 499.975_999_4).abs() < 1e-6 && (made[1] - 500.023_999_4).abs() < 1e-6, "{made:?}");
        let found = MeasuredSquareness::of_diagonals(made, ([400.0, 300.0], false), 0.0).unwrap();
        assert!((found.gamma_rad - 1e-4).abs() < 1e-12);
        assert!(MeasuredSquareness::of_diagonals([500.0, 400.0], ([400.0, 300.0], false), 0.0).is_err());
        // 500 mm · 1e-3 + 5 · 0.1 mm = 1 mm.
        let of = |wrong: f64, are_measured: bool| {
            MeasuredSquareness::of_diagonals([500.0 + wrong; 2], ([400.0, 300.0], are_measured), 0.1).is_ok()
        };
        assert!(of(0.99, false) && of(-0.99, false) && !of(1.01, false) && !of(-1.01, false));
        // 2.5 · 0.1 mm.
        assert!(of(0.24, true) && of(-0.24, true) && !of(0.26, true) && !of(-0.26, true));
    }
}
