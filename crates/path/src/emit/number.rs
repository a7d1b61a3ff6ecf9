//! Numbers as text: counts of an increment by integer arithmetic, other values as the shortest decimal that reads back unchanged.
//!
//! Never `-0`, never an exponent, no decimal point after a whole number.

use std::io::Write as _;

use crate::path::{Increments, RotaryWord};
use ncfix_base::units::{push_digits, push_integer};
use ncfix_machine::snc::RotaryDirection;

/// The print format of counts of an increment: a count times `units` is the number without its decimal point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decimals {
    /// The increment without its decimal point: 5 for 0.0005.
    units: u64,
    /// Digits after the decimal point.
    places: usize,
    /// 10 to the power of `places`.
    scale: u64,
    /// `true` if a whole number ends with a decimal point.
    is_pointed: bool,
}

/// Maximum number of decimals; further digits are rounding noise, not part of an increment.
const MOST_PLACES: usize = 9;
/// Relative tolerance between an increment and its decimal.
const SAME_INCREMENT: f64 = 1e-12;

impl Decimals {
    /// Returns the decimals of an increment, such as 0.0001 or 0.0005; `None` if it is not a positive decimal of at most nine places.
    #[must_use]
    pub fn of_increment(increment: f64) -> Option<Decimals> {
        let mut scale = 1_u64;
        for places in 0..=MOST_PLACES {
            let scaled = increment * scale as f64;
            let units = scaled.round();
            if (1.0..1e15).contains(&units) && (scaled - units).abs() <= SAME_INCREMENT * units {
                // The conversion is exact: a whole number below 10¹⁵.
                return Some(Decimals { units: units as u64, places, scale, is_pointed: false });
            }
            scale *= 10;
        }
        None
    }

    /// Adds a decimal point after whole numbers: `10.`.
    #[must_use]
    pub fn pointed(self) -> Decimals {
        Decimals { is_pointed: true, ..self }
    }

    /// Appends a count as a number.
    pub fn push(&self, line: &mut Vec<u8>, count: i64) {
        if count < 0 {
            line.push(b'-');
        }
        let fraction = match count.unsigned_abs().checked_mul(self.units) {
            Some(number) => {
                push_integer(line, number / self.scale);
                number % self.scale
            }
            None => {
                let number = u128::from(count.unsigned_abs()) * u128::from(self.units);
                let scale = u128::from(self.scale);
                // Writing into a Vec cannot fail.
                let _ = write!(line, "{}", number / scale);
                // The conversion is exact: a remainder of a 64-bit number.
                (number % scale) as u64
            }
        };
        if fraction == 0 {
            if self.is_pointed {
                line.push(b'.');
            }
            return;
        }
        line.push(b'.');
        let mut places = self.places;
        let mut rest = fraction;
        if places > 8 {
            let scale = 10_u64.pow((places - 8) as u32);
            push_digits(line, rest / scale, 8);
            rest %= scale;
            places -= 8;
        }
        push_digits(line, rest, places);
        while line.last() == Some(&b'0') {
            line.pop();
        }
    }
}

/// Thousandths above this limit are not exact integers in a double.
const EXACT_LIMIT: f64 = 9e15;

/// Appends a value as the shortest decimal that reads back unchanged.
pub(super) fn push_value(line: &mut Vec<u8>, value: f64) {
    let thousandths = (value * 1000.0).round();
    // Reading the decimal gives the correctly rounded quotient, so this decimal is already the shortest.
    if thousandths.abs() < EXACT_LIMIT && thousandths / 1000.0 == value {
        THOUSANDTHS.push(line, thousandths as i64);
    } else {
        // Writing into a Vec cannot fail.
        let _ = write!(line, "{value}");
    }
}

const THOUSANDTHS: Decimals = Decimals { units: 1, places: 3, scale: 1000, is_pointed: false };

/// Appends a value as [`push_value`] does, always with a decimal point.
pub(super) fn push_pointed(line: &mut Vec<u8>, value: f64) {
    let start = line.len();
    push_value(line, value);
    if !line.iter().skip(start).any(|&byte| byte == b'.') {
        line.push(b'.');
    }
}

/// Rounds a value to a number of significant digits.
pub(super) fn to_digits(value: f64, digits: i32) -> f64 {
    // Powers of ten up to the 22nd are exact doubles.
    let places = (digits - 1).saturating_sub(value.abs().log10().floor() as i32);
    if !(0..=22).contains(&places) {
        return value;
    }
    let power = 10_f64.powi(places);
    (value * power).round() / power
}

/// The print format of axis positions.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisNumbers {
    pub(super) linear: Decimals,
    pub(super) rotary: Decimals,
    /// Increments in a full turn.
    pub(super) turn_counts: i64,
}

impl AxisNumbers {
    /// Returns `None` if an increment is not a decimal.
    pub(super) fn new(increments: &Increments) -> Option<AxisNumbers> {
        Some(AxisNumbers {
            linear: Decimals::of_increment(increments.linear_mm / increments.unit_mm)?,
            rotary: Decimals::of_increment(increments.rotary_deg)?,
            // An increment that has decimals is above 0.
            turn_counts: ((360.0 / increments.rotary_deg).round() as i64).max(1),
        })
    }

    /// Returns the count of a rotary axis as a plain number; `None` if the plain number does not determine the direction.
    pub(super) fn plain_count(&self, word: RotaryWord, count: i64) -> Option<i64> {
        match word {
            RotaryWord::Plain => Some(count),
            RotaryWord::Within(RotaryDirection::Plain) => Some(count.rem_euclid(self.turn_counts)),
            RotaryWord::Within(_) | RotaryWord::Step(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn shown(increment: f64, count: i64) -> String {
        let mut line = Vec::new();
        Decimals::of_increment(increment).unwrap().push(&mut line, count);
        String::from_utf8(line).unwrap()
    }

    fn value(value: f64) -> String {
        let mut line = Vec::new();
        push_value(&mut line, value);
        String::from_utf8(line).unwrap()
    }

    #[test]
    fn increments_have_their_decimals() {
        for (increment, units, places) in
            [(0.001, 1, 3), (1e-4, 1, 4), (1e-5, 1, 5), (5e-4, 5, 4), (0.0025, 25, 4), (1.0, 1, 0), (2.0, 2, 0)]
        {
            let decimals = Decimals::of_increment(increment).unwrap();
            assert_eq!((decimals.units, decimals.places), (units, places), "{increment}");
        }
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1.0 / 3.0] {
            assert_eq!(Decimals::of_increment(bad), None, "{bad}");
        }
    }

    #[test]
    fn counts_print_without_trailing_zeros_or_negative_zero() {
        for (increment, count, text) in [
            (1e-4, 0, "0"),
            (1e-4, -1, "-0.0001"),
            (1e-4, 100_000, "10"),
            (1e-4, 105_000, "10.5"),
            (1e-4, -12_345_678, "-1234.5678"),
            (5e-4, 3, "0.0015"),
            (5e-4, -20, "-0.01"),
            (0.001, 1_000_000_000_000, "1000000000"),
            (1.0, -7, "-7"),
            (1e-5, i64::MIN, "-92233720368547.75808"),
            (0.0025, i64::MAX, "23058430092136939.5175"),
        ] {
            assert_eq!(shown(increment, count), text);
        }
    }

    /// The expected text, made by string operations on formatted integers.
    fn by_strings(units: i128, places: usize, count: i64) -> String {
        let number = i128::from(count) * units;
        let digits = format!("{:0>width$}", number.unsigned_abs(), width = places + 1);
        let (whole, fraction) = digits.split_at(digits.len() - places);
        let fraction = fraction.trim_end_matches('0');
        let point = if fraction.is_empty() { "" } else { "." };
        format!("{}{whole}{point}{fraction}", if number < 0 { "-" } else { "" })
    }

    #[test]
    fn every_small_count_prints_as_by_hand() {
        for (increment, units, places) in [(1e-4, 1, 4), (5e-4, 5, 4), (0.001, 1, 3)] {
            for count in -30_000..=30_000 {
                assert_eq!(shown(increment, count), by_strings(units, places, count));
            }
        }
    }

    proptest! {
        #[test]
        fn counts_of_any_size_print_as_by_hand(count in any::<i64>(), places in 0_usize..8, units in 1_i64..100) {
            prop_assume!(units % 10 != 0);
            let increment: f64 = by_strings(i128::from(units), places, 1).parse().unwrap();
            prop_assert_eq!(shown(increment, count), by_strings(i128::from(units), places, count));
        }

        #[test]
        fn values_read_back_the_same_and_have_no_exponent(number in any::<f64>().prop_filter("finite", |v| v.is_finite())) {
            let text = value(number);
            prop_assert_eq!(text.parse::<f64>().unwrap(), number);
            prop_assert!(!text.contains(['e', 'E']) && text != "-0");
        }

        #[test]
        fn everyday_values_are_shortest(thousandths in -100_000_000_i64..100_000_000) {
            let number = thousandths as f64 / 1000.0;
            prop_assert_eq!(value(number), format!("{}", number));
        }
    }

    #[test]
    fn digits_are_those_that_count() {
        for (number, digits, text) in [
            (0.0, 12, "0"),
            (0.1 + 0.2, 12, "0.3"),
            (123_456.789, 8, "123456.79"),
            (-0.000_123_456_78, 4, "-0.0001235"),
            (1e300, 8, &format!("{}", 1e300)),
        ] {
            assert_eq!(value(to_digits(number, digits)), text);
        }
    }

    #[test]
    fn values_print_as_programmers_write_them() {
        for (number, text) in
            [(500.0, "500"), (0.1, "0.1"), (1.5, "1.5"), (-0.0, "0"), (12_000.25, "12000.25"), (1e-7, "0.0000001")]
        {
            assert_eq!(value(number), text);
        }
    }
}
