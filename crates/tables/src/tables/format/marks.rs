//! What a file of tables says of itself in remarks: for which reading of products it is.

use crate::tables::Multiplication;
use ncfix_base::source::Source;

/// What stands in front of the reading.
const PRODUCTS: &str = "products of tables count ";
/// The readings, and how they are written.
const READINGS: [(Multiplication, &str); 2] =
    [(Multiplication::Instead, "instead of the own value"), (Multiplication::Beside, "beside the own value")];

/// The remark for a reading of products.
pub(super) fn multiplication(multiplication: Multiplication) -> String {
    let reading = READINGS.iter().find(|(one, _)| *one == multiplication);
    format!("{PRODUCTS}{}", reading.map_or("", |(_, text)| text))
}

/// For which reading of products a file says it is; `None` where it says nothing.
#[must_use]
pub fn multiplication_of(source: &Source) -> Option<Multiplication> {
    let end = source.line_end();
    let lines = source.bytes().split(|&byte| byte == end).filter_map(|line| std::str::from_utf8(line).ok());
    let marks = lines.filter_map(|line| line.trim().strip_prefix(';')?.trim().strip_prefix(PRODUCTS));
    let readings = marks.filter_map(|mark| READINGS.iter().find(|(_, text)| mark.trim() == *text));
    readings.map(|(one, _)| *one).next()
}
