//! Unit conversion: mm, rad, s inside; µm, µrad, degrees, inches in files, options and reports.

use serde::Serialize;

/// mm per inch, exact by definition (ISO 31, 1959 international inch).
pub const MM_PER_INCH: f64 = 25.4;

/// Converts µm to mm.
#[must_use]
pub fn mm_from_um(um: f64) -> f64 {
    um * 1e-3
}

/// Converts mm to µm.
#[must_use]
pub fn um_from_mm(mm: f64) -> f64 {
    mm * 1e3
}

/// Converts µrad to rad.
#[must_use]
pub fn rad_from_urad(urad: f64) -> f64 {
    urad * 1e-6
}

/// Converts rad to µrad.
#[must_use]
pub fn urad_from_rad(rad: f64) -> f64 {
    rad * 1e6
}

/// Unit of small quantities in results: micrometers for lengths, microradians for angles. In JSON it has its usual symbol.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Unit {
    /// Micrometers, for lengths.
    #[default]
    #[serde(rename = "µm")]
    Um,
    /// Microradians, for angles.
    #[serde(rename = "µrad")]
    Urad,
}

impl Unit {
    /// Returns the unit of angles or of lengths.
    #[must_use]
    pub fn of(is_angle: bool) -> Unit {
        if is_angle { Unit::Urad } else { Unit::Um }
    }

    /// Returns the symbol: `µm`, `µrad`.
    #[must_use]
    pub fn sign(self) -> &'static str {
        match self {
            Unit::Um => "µm",
            Unit::Urad => "µrad",
        }
    }

    /// Converts a length in mm, or an angle in rad, to this unit.
    #[must_use]
    pub fn shown(self, value: f64) -> f64 {
        match self {
            Unit::Um => um_from_mm(value),
            Unit::Urad => urad_from_rad(value),
        }
    }
}

impl std::fmt::Display for Unit {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.pad(self.sign())
    }
}

/// Unit of small quantities in ASCII, as in JSON keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum UnitKey {
    /// Micrometers, for lengths.
    #[default]
    Um,
    /// Microradians, for angles.
    Urad,
}

impl UnitKey {
    /// Returns the unit of angles or of lengths.
    #[must_use]
    pub fn of(is_angle: bool) -> UnitKey {
        if is_angle { UnitKey::Urad } else { UnitKey::Um }
    }

    /// Returns the unit with its usual symbol.
    #[must_use]
    pub fn unit(self) -> Unit {
        match self {
            UnitKey::Um => Unit::Um,
            UnitKey::Urad => Unit::Urad,
        }
    }

    /// `µm`, `µrad`.
    #[must_use]
    pub fn sign(self) -> &'static str {
        self.unit().sign()
    }
}

/// A position of an axis at the edge: mm, or rad shown as degrees. Both are rounded to a billionth, below every increment, so that 120° does not
/// appear as 119.99999999999999.
#[must_use]
pub fn shown_position(is_rotary: bool, position: f64) -> f64 {
    /// Parts of the unit that are kept.
    const PARTS: f64 = 1e9;
    let value = if is_rotary { position.to_degrees() } else { position };
    (value * PARTS).round() / PARTS
}

/// Returns the sine of an angle in degrees, exact at multiples of 90 and 30: a zero in a bolt circle must be exactly zero.
#[must_use]
pub fn sin_deg(degrees: f64) -> f64 {
    let turn = degrees.rem_euclid(360.0);
    let (sign, half) = if turn >= 180.0 { (-1.0, turn - 180.0) } else { (1.0, turn) };
    let quarter = if half > 90.0 { 180.0 - half } else { half };
    let value = match quarter {
        0.0 => 0.0,
        30.0 => 0.5,
        90.0 => 1.0,
        _ if quarter > 45.0 => (90.0 - quarter).to_radians().cos(),
        _ => quarter.to_radians().sin(),
    };
    sign * value
}

/// Reads a length with its unit, `1um`, `0.02mm`, `1e-3 mm`, `0.001in`, in mm; a number without a unit is refused.
///
/// # Errors
/// The text is not a length. The error is a sentence that states what was found and what is expected.
pub fn parse_length_mm(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, factor) = [("um", 1e-3), ("µm", 1e-3), ("nm", 1e-6), ("mm", 1.0), ("in", MM_PER_INCH)]
        .iter()
        .find_map(|&(unit, factor)| text.strip_suffix(unit).map(|number| (number, factor)))
        .ok_or_else(|| match text.trim_start_matches(|c: char| c.is_ascii_digit() || "+-.,".contains(c)) {
            "" if text.parse::<f64>().is_ok() => format!("'{text}' has no unit; write {text}mm or {text}um"),
            "" => format!("'{text}' has no unit; write for example 1um or 0.02mm"),
            unit => format!("'{}' is not a unit of length; write for example 1um or 0.02mm", unit.trim()),
        })?;
    let value: f64 = number.trim().parse().map_err(|_| match number.contains(',') {
        true => format!("'{number}' is not a number; write a decimal point"),
        false => format!("'{number}' is not a number"),
    })?;
    if value.is_finite() { Ok(value * factor) } else { Err(format!("'{text}' is not finite")) }
}

/// Appends a whole number as text, without allocation.
pub fn push_integer(line: &mut Vec<u8>, value: u64) {
    /// Numbers below this have at most eight digits.
    const SHORT: u64 = 100_000_000;
    if value >= SHORT {
        push_integer(line, value / SHORT);
        push_digits(line, value % SHORT, 8);
        return;
    }
    let count = value.checked_ilog10().map_or(1, |power| power as usize + 1);
    push_digits(line, value, count);
}

/// Appends the last `count` digits of a whole number, at most eight, including leading zeros.
pub fn push_digits(line: &mut Vec<u8>, value: u64, count: usize) {
    let count = count.min(8);
    let mut digits = [b'0'; 8];
    let mut rest = value;
    for digit in digits[..count].iter_mut().rev() {
        *digit = b'0' + (rest % 10) as u8;
        rest /= 10;
    }
    // A copy of fixed length is one instruction.
    let end = line.len() + count;
    line.extend_from_slice(&digits);
    line.truncate(end);
}

#[cfg(test)]
mod tests {
    use super::{parse_length_mm, push_digits, push_integer};

    #[test]
    fn a_length_needs_its_unit() {
        assert_eq!(parse_length_mm("20mm"), Ok(20.0));
        assert_eq!(parse_length_mm("0.5 um"), Ok(0.0005));
        assert_eq!(parse_length_mm("2in"), Ok(50.8));
        assert!(parse_length_mm("5").is_err());
        assert!(parse_length_mm("x mm").is_err());
        assert!(parse_length_mm("infmm").is_err());
    }

    #[test]
    fn whole_numbers_are_written_as_the_standard_library_does() {
        let around = (0..20).flat_map(|power| {
            let ten = 10_u64.pow(power);
            [ten - 1, ten, ten + 1, ten.saturating_mul(7), u64::MAX / ten]
        });
        for value in around {
            let mut line = b"X".to_vec();
            push_integer(&mut line, value);
            assert_eq!(String::from_utf8(line).unwrap(), format!("X{value}"));
        }
        let mut line = Vec::new();
        push_digits(&mut line, 705, 5);
        push_digits(&mut line, 0, 0);
        assert_eq!(line, b"00705");
    }
}
