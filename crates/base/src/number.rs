//! Numbers for people: grouped thousands, µm with suitable decimals.

/// Reads a factor, with or without `x`: `20x`.
///
/// # Errors
/// If it is not a number above 0.
pub fn factor(text: &str) -> Result<f64, String> {
    let value =
        text.trim_end_matches(['x', 'X']).parse().ok().filter(|factor: &f64| factor.is_finite() && *factor > 0.0);
    value.ok_or_else(|| format!("'{text}' is not a factor above 0, such as 20x"))
}

/// Formats a count with its thousands separated: `1,234,567`.
#[must_use]
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut out = String::with_capacity(digits.len() * 4 / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// Formats a count with its noun in the singular or plural: `1 block`, `1,234 blocks`.
#[must_use]
pub fn counted(count: u64, noun: &str) -> String {
    format!("{} {noun}{}", grouped(count), if count == 1 { "" } else { "s" })
}

/// Formats a distance in µm with its significant decimals: `213 µm`, `21.4 µm`, `2.14 µm`, `0.021 µm`.
#[must_use]
pub fn micrometers(um: f64) -> String {
    format!("{} µm", significant(um))
}

/// Formats a value with three significant digits, at most three decimals.
#[must_use]
pub fn significant(value: f64) -> String {
    let decimals = match value.abs() {
        size if size >= 99.95 => 0,
        size if size >= 9.995 => 1,
        size if size >= 0.9995 => 2,
        _ => 3,
    };
    format!("{value:.decimals$}")
}

/// Probabilities above this are printed as a limit: the assumptions are not known that well.
const MOST_PROBABLE: f64 = 0.99;

/// Formats a probability: `probability 97 %`, `probability > 99 %`.
#[must_use]
pub fn probability(value: f64) -> String {
    if value > MOST_PROBABLE {
        format!("probability > {:.0} %", 100.0 * MOST_PROBABLE)
    } else {
        format!("probability {}", percent(value))
    }
}

/// Formats a probability in percent, rounded down: a limit is never shown for a value below it. One below 1 % is printed as a limit too.
#[must_use]
pub fn percent(probability: f64) -> String {
    if probability < 0.01 {
        return "< 1 %".to_owned();
    }
    // Sums of shares such as 0.29 are a rounding error below.
    format!("{:.0} %", (100.0 * probability + 1e-6).floor())
}

/// Formats a time: `0.42 s`, `12.3 s`, `3 min 20 s`.
#[must_use]
pub fn duration(seconds: f64) -> String {
    if seconds < 10.0 {
        format!("{seconds:.2} s")
    } else if seconds < 60.0 {
        format!("{seconds:.1} s")
    } else {
        format!("{:.0} min {:.0} s", (seconds / 60.0).floor(), seconds % 60.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_grouped() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_000), "1,000");
        assert_eq!(grouped(12_345_678), "12,345,678");
    }

    #[test]
    fn a_probability_is_never_shown_above_its_value() {
        for (value, shown) in [(0.9499, "94 %"), (0.95, "95 %"), (0.29, "29 %"), (0.9999, "99 %"), (1.0, "100 %")] {
            assert_eq!(percent(value), shown);
        }
    }

    #[test]
    fn three_digits_are_shown() {
        assert_eq!(micrometers(213.4), "213 µm");
        assert_eq!(micrometers(99.96), "100 µm");
        assert_eq!(micrometers(21.44), "21.4 µm");
        assert_eq!(micrometers(2.144), "2.14 µm");
        assert_eq!(micrometers(0.0214), "0.021 µm");
        assert_eq!(micrometers(0.0), "0.000 µm");
    }

    #[test]
    fn minutes_are_split() {
        assert_eq!(duration(0.417), "0.42 s");
        assert_eq!(duration(12.34), "12.3 s");
        assert_eq!(duration(200.0), "3 min 20 s");
    }
}
