//! Numbers in cells: decimal signs, and separators of thousands.

use ncfix_base::csv::DecimalSign;

/// Number in a cell; `None` if the text is not a number.
#[must_use]
pub fn number(text: &str, decimal: DecimalSign) -> Option<f64> {
    /// No reading is larger in any unit.
    const MOST: f64 = 1e12;
    let text = text.trim().replace(['\u{2212}', '\u{2013}'], "-");
    if !text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | ',')) {
        return None;
    }
    let plain = match decimal {
        DecimalSign::Point => without_thousands(&text, ',', '.')?,
        DecimalSign::Comma => without_thousands(&text, '.', ',')?.replace(',', "."),
    };
    if !plain.bytes().any(|byte| byte.is_ascii_digit()) {
        return None;
    }
    plain.parse::<f64>().ok().filter(|value| value.is_finite() && value.abs() <= MOST)
}

/// Removes separators of thousands that a decimal sign after them proves: `1.234,56`. Without that proof the cell is not a number.
fn without_thousands(text: &str, thousands: char, decimal: char) -> Option<String> {
    if !text.contains(thousands) {
        return Some(text.to_owned());
    }
    let (whole, _) = text.split_once(decimal)?;
    let mut groups = whole.trim_start_matches(['+', '-']).split(thousands);
    let is_first = groups.next().is_some_and(|first| (1..=3).contains(&first.len()));
    let are_groups = groups.all(|group| group.len() == 3 && group.bytes().all(|byte| byte.is_ascii_digit()));
    (is_first && are_groups && !text[whole.len()..].contains(thousands)).then(|| text.replace(thousands, ""))
}

/// True if the commas of a number may separate thousands: `1,234`.
pub(crate) fn may_be_thousands(text: &str) -> bool {
    let mut groups = text.trim_start_matches(['+', '-', '\u{2212}', '\u{2013}']).split(',');
    let is_first = groups.next().is_some_and(|first| (1..=3).contains(&first.len()) && !first.starts_with('0'));
    is_first && groups.all(|group| group.len() == 3 && group.bytes().all(|byte| byte.is_ascii_digit()))
}
