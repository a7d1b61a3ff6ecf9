//! Statements about axes on the command line: `X=0..600`, `C=-`, `C=300,-198,-440`.

use std::fmt;
use std::str::FromStr;

use ncfix_base::geometry::Axis;

/// Travel of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TravelRange {
    /// Lowest and highest position, mm or degrees.
    Ends([f64; 2]),
    /// A modulo axis, which turns without limits.
    Modulo,
}

/// A travel with its axis: `X=0..600`, `C=modulo`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedTravel {
    /// Axis.
    pub axis: Axis,
    /// Travel.
    pub range: TravelRange,
}

/// A sense with its axis: `C=-`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatedSense {
    /// Axis.
    pub axis: Axis,
    /// True if the carried part moves along, or by the right-hand rule about, the vector of the axis for a positive command.
    pub is_positive: bool,
}

/// A point on a rotary axis: `C=300,-198,-440`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedPivot {
    /// Axis.
    pub axis: Axis,
    /// Point in F with every axis at zero, mm.
    pub point_mm: [f64; 3],
}

/// The axis before `=` and the text after it.
fn parts<'a>(text: &'a str, example: &str) -> Result<(Axis, &'a str), String> {
    let wrong = || format!("'{text}' is not an axis with a value; write for example {example}");
    let (letter, value) = text.split_once('=').ok_or_else(wrong)?;
    let [letter] = letter.trim().as_bytes() else { return Err(wrong()) };
    Ok((Axis::from_letter(letter.to_ascii_uppercase()).ok_or_else(wrong)?, value.trim()))
}

/// A finite number.
fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|value| value.is_finite() && value.abs() < 1e6)
}

impl FromStr for StatedTravel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (axis, value) = parts(text, "X=0..600")?;
        if value.eq_ignore_ascii_case("modulo") && axis.is_rotary() {
            return Ok(StatedTravel { axis, range: TravelRange::Modulo });
        }
        let ends = value.split_once("..").and_then(|(low, high)| Some([number(low)?, number(high)?]));
        match ends.filter(|[low, high]| low < high) {
            Some(ends) => Ok(StatedTravel { axis, range: TravelRange::Ends(ends) }),
            None => {
                Err(format!("'{value}' is not a travel; write the lowest and the highest position: {axis}=-500..0"))
            }
        }
    }
}

impl FromStr for StatedSense {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (axis, value) = parts(text, "C=-")?;
        match value {
            "+" => Ok(StatedSense { axis, is_positive: true }),
            "-" => Ok(StatedSense { axis, is_positive: false }),
            _ => Err(format!("'{value}' is not a sense; write {axis}=+ or {axis}=-")),
        }
    }
}

impl FromStr for StatedPivot {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (axis, value) = parts(text, "C=300,-198,-440")?;
        let numbers: Option<Vec<f64>> = value.split(',').map(number).collect();
        match numbers.as_deref() {
            Some([x, y, z]) => Ok(StatedPivot { axis, point_mm: [*x, *y, *z] }),
            _ => Err(format!("'{value}' is not a point; write three numbers in mm: {axis}=300,-198,-440")),
        }
    }
}

impl fmt::Display for TravelRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TravelRange::Ends([low, high]) => write!(f, "{low}..{high}"),
            TravelRange::Modulo => f.write_str("modulo"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_are_read() {
        let travel: StatedTravel = "x=-600..0".parse().unwrap();
        assert_eq!((travel.axis, travel.range), (Axis::X, TravelRange::Ends([-600.0, 0.0])));
        assert_eq!("C=modulo".parse::<StatedTravel>().unwrap().range, TravelRange::Modulo);
        assert!("X=modulo".parse::<StatedTravel>().is_err() && "X=5..5".parse::<StatedTravel>().is_err());
        assert!(!"C=-".parse::<StatedSense>().unwrap().is_positive && "C=1".parse::<StatedSense>().is_err());
        assert_eq!("A=1,-2,3".parse::<StatedPivot>().unwrap().point_mm, [1.0, -2.0, 3.0]);
        assert!("A=1,2".parse::<StatedPivot>().is_err() && "AB=1,2,3".parse::<StatedPivot>().is_err());
    }
}
