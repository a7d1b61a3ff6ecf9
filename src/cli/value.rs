//! Values of options: lengths with units, skip levels, a start position.

use std::time::Duration;

use crate::correction::MOST_THREADS;
use crate::error::Error;
pub(super) use crate::tool::ToolVector;
use ncfix_base::geometry::AxisVector;
use ncfix_base::units::parse_length_mm;
use ncfix_machine::machine::range::range_of;
use ncfix_machine::machine::{Load, State};

/// Which levels of `/` blocks are skipped; `/` alone is level 0.
pub(super) type SkipLevels = [bool; 10];

/// A length above zero, in mm.
pub(super) fn positive_length_mm(text: &str) -> Result<f64, String> {
    let length_mm = parse_length_mm(text)?;
    if length_mm > 0.0 { Ok(length_mm) } else { Err(format!("'{text}' is not greater than zero")) }
}

/// A length of whole mm.
pub(super) fn whole_mm(text: &str) -> Result<i32, String> {
    let length_mm = positive_length_mm(text)?;
    let whole = length_mm.round();
    if (whole - length_mm).abs() < 1e-9 && (1.0..=1e6).contains(&whole) {
        Ok(whole as i32)
    } else {
        Err(format!("'{text}' is no whole number of mm"))
    }
}

/// A step into which moves are cut, in mm: finer than a micrometer makes files that end nowhere.
pub(super) fn step_mm(text: &str) -> Result<f64, String> {
    let length_mm = positive_length_mm(text)?;
    if length_mm >= 1e-3 { Ok(length_mm) } else { Err(format!("'{text}' is below 1um")) }
}

/// Threads to work in.
pub(super) fn threads(text: &str) -> Result<usize, String> {
    let value = text.parse().ok().filter(|value| (1..=MOST_THREADS).contains(value));
    value.ok_or_else(|| format!("write a whole number from 1 to {}", MOST_THREADS))
}

/// A share in percent, as a number.
pub(super) fn percent(text: &str) -> Result<f64, String> {
    let value = text.strip_suffix('%').and_then(|number| number.trim().parse::<f64>().ok());
    let value = value.filter(|value| *value > 0.0 && *value <= 50.0);
    value
        .map(|value| value / 100.0)
        .ok_or_else(|| "write a number above 0 and up to 50 with %, for example 1%".to_owned())
}

/// A time above zero, up to a year.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let value = text.parse::<f64>().ok().filter(|value| *value > 0.0 && *value <= 366.0 * 86_400.0);
    value.map(Duration::from_secs_f64).ok_or_else(|| "write a number of seconds above 0, for example 60".to_owned())
}

/// A dose above zero; infinite for `off`.
pub(super) fn dose(text: &str) -> Result<f64, String> {
    if text == "off" {
        return Ok(f64::INFINITY);
    }
    let value = text.parse::<f64>().ok().filter(|value| *value > 0.0 && value.is_finite());
    value.ok_or_else(|| "write a number above 0, for example 1, or off".to_owned())
}

/// A difference of temperature above zero.
pub(super) fn kelvin(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| (0.0..=100.0).contains(value) && *value > 0.0);
    value.ok_or_else(|| "write a number of K above 0, for example 0.5".to_owned())
}

/// An increment of a control, in mm, in the range that the machine file has for it.
pub(super) fn increment_mm(text: &str) -> Result<f64, String> {
    let length_mm = positive_length_mm(text)?;
    if range_of("increment_mm").values().contains(&length_mm) {
        // Reading the decimal text again gives the double nearest to it: 0.1um becomes 1e-4 mm and not 1.0000000000000002e-4.
        format!("{length_mm:.9}").parse().map_err(|_| format!("'{text}' is no number"))
    } else {
        Err(format!("'{text}' is not between 10nm and 0.1mm"))
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
    text.parse()
}

/// `120` or `0,0,-120`.
pub(super) fn tool(text: &str) -> Result<ToolVector, String> {
    text.parse().map_err(|error: Error| error.to_string())
}

/// `1700` or `1700@0,0,-280`.
pub(super) fn load(text: &str) -> Result<Load, String> {
    text.parse()
}

/// `X+,Y-`.
pub(super) fn sense(text: &str) -> Result<State, String> {
    text.parse()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::{Axis, Vector};

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
    fn tools_loads_and_senses() {
        assert_eq!(tool("120"), Ok(ToolVector::Length(120.0)));
        assert_eq!(tool("0, 1,-120"), Ok(ToolVector::Tip(Vector::new(0.0, 1.0, -120.0))));
        assert!(tool("1,2").is_err());
        assert_eq!(load("1700N"), Ok(Load { force_n: 1700.0, position_mm: Vector::zeros() }));
        assert_eq!(load("5@1,2,-3").unwrap().position_mm, Vector::new(1.0, 2.0, -3.0));
        assert!(load("-5").is_err() && load("5@1").is_err() && load("x").is_err());
        assert_eq!(sense("X+,c-").unwrap().direction, [1, 0, 0, 0, 0, 0, 0, 0, -1]);
        assert!(sense("X").is_err());
        assert_eq!(start("X=5").unwrap()[Axis::X], 5.0);
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
