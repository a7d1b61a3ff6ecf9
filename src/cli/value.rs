//! Values of options: lengths with units, skip levels, a start position.

use crate::geometry::{Axis, AxisVector};
use crate::units::parse_length_mm;

/// Which levels of `/` blocks are skipped; `/` alone is level 0.
pub(super) type SkipLevels = [bool; 10];

/// A length above zero, in mm.
pub(super) fn positive_length_mm(text: &str) -> Result<f64, String> {
    let length_mm = parse_length_mm(text)?;
    if length_mm > 0.0 { Ok(length_mm) } else { Err(format!("'{text}' is not greater than zero")) }
}

/// An increment of a control, in mm: nothing finer than 1 nm and nothing coarser than 0.1 mm makes sense.
pub(super) fn increment_mm(text: &str) -> Result<f64, String> {
    let length_mm = positive_length_mm(text)?;
    if (1e-6..=0.1).contains(&length_mm) {
        // Reading the decimal text again gives the double nearest to it: 0.1um becomes 1e-4 mm and not 1.0000000000000002e-4.
        format!("{length_mm:.9}").parse().map_err(|_| format!("'{text}' is no number"))
    } else {
        Err(format!("'{text}' is not between 1nm and 0.1mm"))
    }
}

/// `0`, `0,3` or `all`.
pub(super) fn skip_levels(text: &str) -> Result<SkipLevels, String> {
    if text.eq_ignore_ascii_case("all") {
        return Ok([true; 10]);
    }
    let mut levels = [false; 10];
    for part in text.split(',') {
        let level = part.trim().parse().ok().and_then(|level: usize| levels.get_mut(level));
        *level.ok_or_else(|| format!("'{part}' is no skip level; write 0 to 9, separated by commas, or all"))? = true;
    }
    Ok(levels)
}

/// `X0,Y0,Z100,A90`: mm and degrees; axes that are not given are zero.
pub(super) fn start(text: &str) -> Result<AxisVector, String> {
    let mut position = AxisVector::ZERO;
    for part in text.split(',').map(str::trim) {
        let wrong = || format!("'{part}' is no axis position; write for example X0,Y0,Z100");
        let letter = part.bytes().next().ok_or_else(wrong)?;
        let axis = Axis::from_letter(letter.to_ascii_uppercase()).ok_or_else(wrong)?;
        let number: f64 = part.get(1..).and_then(|number| number.trim().parse().ok()).ok_or_else(wrong)?;
        if !number.is_finite() {
            return Err(wrong());
        }
        position[axis] = if axis.is_rotary() { number.to_radians() } else { number };
    }
    Ok(position)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_listed() {
        assert_eq!(skip_levels("all"), Ok([true; 10]));
        let levels = skip_levels("0, 3").unwrap();
        assert_eq!(levels.iter().filter(|&&skipped| skipped).count(), 2);
        assert!(levels[0] && levels[3]);
        assert!(skip_levels("10").is_err());
        assert!(skip_levels("").is_err());
    }

    #[test]
    fn a_start_names_axes_in_mm_and_degrees() {
        let position = start("X-1.5, z100,A90").unwrap();
        assert_eq!((position[Axis::X], position[Axis::Y], position[Axis::Z]), (-1.5, 0.0, 100.0));
        assert!((position[Axis::A] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert!(start("Q1").is_err());
        assert!(start("X").is_err());
        assert!(start("Xinf").is_err());
        assert!(start("X1,,Y1").is_err());
        assert!(start("ü1").is_err());
    }

    #[test]
    fn increments_are_exact_decimals() {
        assert_eq!(increment_mm("0.1um"), Ok(0.0001));
        assert_eq!(increment_mm("1um"), Ok(0.001));
        assert_eq!(increment_mm("0.0005mm"), Ok(0.0005));
        assert!(increment_mm("0.1nm").is_err());
        assert!(increment_mm("1mm").is_err());
    }
}
