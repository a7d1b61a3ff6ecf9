//! Remarks of a table file about the interpretation of products.

use crate::tables::Multiplication;
use ncfix_base::source::Source;

/// Text before the interpretation.
const PRODUCTS: &str = "products of tables count ";
/// The interpretations and their texts.
const READINGS: [(Multiplication, &str); 2] =
    [(Multiplication::Instead, "instead of the own value"), (Multiplication::Beside, "beside the own value")];

/// The remark for an interpretation of products.
pub(super) fn multiplication(multiplication: Multiplication) -> String {
    let reading = READINGS.iter().find(|(one, _)| *one == multiplication);
    format!("{PRODUCTS}{}", reading.map_or("", |(_, text)| text))
}

/// The interpretation of products stated in a file; `None` if there is none.
#[must_use]
pub fn multiplication_of(source: &Source) -> Option<Multiplication> {
    let end = source.line_end();
    let lines = source.bytes().split(|&byte| byte == end).filter_map(|line| std::str::from_utf8(line).ok());
    let marks = lines.filter_map(|line| line.trim().strip_prefix(';')?.trim().strip_prefix(PRODUCTS));
    let readings = marks.filter_map(|mark| READINGS.iter().find(|(_, text)| mark.trim() == *text));
    readings.map(|(one, _)| *one).next()
}
