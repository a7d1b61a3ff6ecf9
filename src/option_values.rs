//! Values of options, as a person writes them: numbers, lengths with units, axes, planes, skip levels, a start position.

use std::time::Duration;

use clap::ValueEnum;

use crate::correction::MOST_THREADS;
use ncfix_base::geometry::{Axis, Plane, Vector};
use ncfix_base::units::parse_length_mm;
use ncfix_machine::machine::range::range_of;
use ncfix_model::ErrorName;
use ncfix_tables::tables::{Multiplication, Orientation};

/// Skipped levels of `/` blocks; `/` alone is level 0.
pub(crate) type SkipLevels = [bool; 10];

/// A length above zero, in mm.
pub(crate) fn positive_length_mm(text: &str) -> Result<f64, String> {
    let length_mm = parse_length_mm(text)?;
    if length_mm > 0.0 { Ok(length_mm) } else { Err(format!("'{text}' is not greater than zero")) }
}

/// A length of whole mm.
pub(crate) fn whole_mm(text: &str) -> Result<i32, String> {
    let length_mm = positive_length_mm(text)?;
    let whole = length_mm.round();
    if (whole - length_mm).abs() < 1e-9 && (1.0..=1e6).contains(&whole) {
        Ok(whole as i32)
    } else {
        Err(format!("'{text}' is not a whole number of mm"))
    }
}

/// A step into which moves are divided, in mm: a finer step than a micrometer makes huge files.
pub(crate) fn step_mm(text: &str) -> Result<f64, String> {
    let length_mm = positive_length_mm(text)?;
    if length_mm >= 1e-3 { Ok(length_mm) } else { Err(format!("'{text}' is below 1um")) }
}

/// Number of threads.
pub(crate) fn threads(text: &str) -> Result<usize, String> {
    let value = text.parse().ok().filter(|value| (1..=MOST_THREADS).contains(value));
    value.ok_or_else(|| format!("write a whole number from 1 to {}", MOST_THREADS))
}

/// A percentage, as a fraction.
pub(crate) fn percent(text: &str) -> Result<f64, String> {
    let value = text.strip_suffix('%').and_then(|number| number.trim().parse::<f64>().ok());
    let value = value.filter(|value| *value > 0.0 && *value <= 50.0);
    value
        .map(|value| value / 100.0)
        .ok_or_else(|| "write a number above 0 and up to 50 with %, for example 1%".to_owned())
}

/// A time above zero and up to a year, given in seconds.
pub(crate) fn seconds(text: &str) -> Result<Duration, String> {
    let value = text.parse::<f64>().ok().filter(|value| *value > 0.0 && *value <= 366.0 * 86_400.0);
    value.map(Duration::from_secs_f64).ok_or_else(|| "write a number of seconds above 0, for example 60".to_owned())
}

/// A rate limit above zero; infinite for `off`.
pub(crate) fn dose(text: &str) -> Result<f64, String> {
    if text == "off" {
        return Ok(f64::INFINITY);
    }
    let value = text.parse::<f64>().ok().filter(|value| *value > 0.0 && value.is_finite());
    value.ok_or_else(|| "write a number above 0, for example 1, or off".to_owned())
}

/// A temperature difference above zero, in K.
pub(crate) fn kelvin(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| (0.0..=100.0).contains(value) && *value > 0.0);
    value.ok_or_else(|| "write a temperature difference above 0 in K, for example 0.5".to_owned())
}

/// An increment of a control, in mm, in the range of that key of the machine file.
pub(crate) fn increment_mm(text: &str) -> Result<f64, String> {
    let length_mm = positive_length_mm(text)?;
    if range_of("increment_mm").values().contains(&length_mm) {
        // Reading the decimal text again gives the double nearest to it: 0.1um becomes 1e-4 mm and not 1.0000000000000002e-4.
        format!("{length_mm:.9}").parse().map_err(|_| format!("'{text}' is not a number"))
    } else {
        Err(format!("'{text}' is not between 10nm and 0.1mm"))
    }
}

/// `0`, `0,3` or `all`.
pub(crate) fn skip_levels(text: &str) -> Result<SkipLevels, String> {
    if text.eq_ignore_ascii_case("all") {
        return Ok([true; 10]);
    }
    let mut levels = [false; 10];
    for part in text.split(',') {
        let level = part.trim().parse().ok().and_then(|level: usize| levels.get_mut(level));
        *level.ok_or_else(|| format!("'{part}' is not a skip level; write 0 to 9, separated by commas, or all"))? =
            true;
    }
    Ok(levels)
}

/// See [`Orientation`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum OrientationChoice {
    /// As much of the tilt as possible without much rotation of the tool about its axis: a smooth function without poles
    Smooth,
    /// Tilt and roll alike (Esmaeili 2021, eq. 37): lowest trigonometric functions, largest residual tilt
    SixRows,
    /// All of the tilt, as in the correction of programs: steep near a pole
    Exact,
    /// None: only the tip position is corrected
    Off,
}

impl OrientationChoice {
    /// Orientation for the library.
    pub(crate) fn orientation(self) -> Orientation {
        match self {
            OrientationChoice::Smooth => Orientation::Smooth,
            OrientationChoice::SixRows => Orientation::SixRows,
            OrientationChoice::Exact => Orientation::Exact,
            OrientationChoice::Off => Orientation::Off,
        }
    }
}

/// See [`Multiplication`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum MultiplicationChoice {
    /// Product instead of the table's own value
    Instead,
    /// Product in addition to the table's own value
    Beside,
}

impl MultiplicationChoice {
    /// Multiplication for the library.
    pub(crate) fn multiplication(self) -> Multiplication {
        match self {
            MultiplicationChoice::Instead => Multiplication::Instead,
            MultiplicationChoice::Beside => Multiplication::Beside,
        }
    }
}

fn axis_of(text: &str) -> Result<Axis, String> {
    match text.trim().as_bytes() {
        [letter] => Axis::from_letter(*letter).ok_or_else(|| format!("'{text}' is not an axis")),
        _ => Err(format!("'{text}' is not an axis")),
    }
}

/// A range of an axis, mm or deg: `A=-55..55`.
pub(crate) fn axis_range(text: &str) -> Result<(Axis, [f64; 2]), String> {
    let (axis, range) = text.split_once('=').ok_or("write AXIS=LOW..HIGH, such as A=-55..55")?;
    let (low, high) = range.split_once("..").ok_or("write LOW..HIGH, such as -55..55")?;
    let number = |text: &str| {
        text.trim()
            .parse::<f64>()
            .ok()
            .filter(|value| value.is_finite())
            .ok_or_else(|| format!("'{text}' is not a number"))
    };
    let (low, high) = (number(low)?, number(high)?);
    if low > high {
        return Err(format!("{low} is above {high}"));
    }
    Ok((axis_of(axis)?, [low, high]))
}

/// The name of an axis at the control: `X=AX1`.
pub(crate) fn axis_name(text: &str) -> Result<(Axis, String), String> {
    let (axis, name) = text.split_once('=').ok_or("write AXIS=NAME, such as X=AX1")?;
    let is_name = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if is_name { Ok((axis_of(axis)?, name.to_owned())) } else { Err(format!("'{name}' is not an axis name")) }
}

/// A number.
fn number(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("'{text}' is not a number"))
}

/// A number above zero.
pub(crate) fn above_zero(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| if value > 0.0 { Ok(value) } else { Err(format!("'{text}' is not above 0")) })
}

/// A number that is not negative.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| if value >= 0.0 { Ok(value) } else { Err(format!("'{text}' is below 0")) })
}

/// A distance in mm, with or without the unit.
pub(crate) fn margin(text: &str) -> Result<f64, String> {
    not_negative(text.trim().strip_suffix("mm").unwrap_or(text))
}

/// `N` numbers, separated by commas.
pub(crate) fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let all: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
    all.try_into().map_err(|_| format!("'{text}' is not {N} numbers separated by commas"))
}

/// Three numbers, separated by commas.
pub(crate) fn vector(text: &str) -> Result<Vector, String> {
    numbers::<3>(text).map(Vector::from)
}

/// A plane of two axes.
pub(crate) fn plane(text: &str) -> Result<Plane, String> {
    match text.to_ascii_uppercase().as_str() {
        "XY" => Ok(Plane::XY),
        "YZ" => Ok(Plane::YZ),
        "ZX" | "XZ" => Ok(Plane::ZX),
        _ => Err(format!("'{text}' is not a plane; write XY, YZ or ZX")),
    }
}

/// The letter of an axis.
pub(crate) fn axis(text: &str) -> Result<Axis, String> {
    let axis = match *text.as_bytes() {
        [letter] => Axis::from_letter(letter.to_ascii_uppercase()),
        _ => None,
    };
    axis.ok_or_else(|| format!("'{text}' is not an axis"))
}

/// The name of an error, such as `EXX`.
pub(crate) fn component(text: &str) -> Result<ErrorName, String> {
    text.to_ascii_uppercase().parse().map_err(|_| format!("'{text}' is not an error name such as EXX or EBX"))
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
    fn increments_are_exact_decimals() {
        assert_eq!(increment_mm("0.1um"), Ok(0.0001));
        assert_eq!(increment_mm("1um"), Ok(0.001));
        assert_eq!(increment_mm("0.0005mm"), Ok(0.0005));
        assert!(increment_mm("0.1nm").is_err());
        assert!(increment_mm("1mm").is_err());
    }
}
