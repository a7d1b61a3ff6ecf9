//! Codes and lengths in the notation of the output.

use ncfix_base::units::MM_PER_INCH;
use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;
use std::fmt::Write as _;
/// mm in a length unit of the output.
pub(super) fn output_unit_mm(machine: &Machine) -> f64 {
    if machine.control.output_inch == Some(true) { MM_PER_INCH } else { 1.0 }
}

/// Appends a length word, given in mm, in the unit of the output.
pub(super) fn append_length(machine: &Machine, language: Language, text: &mut String, letter: u8, value_mm: f64) {
    append(language, text, letter, value_mm / output_unit_mm(machine));
}

/// Appends a word with a value in its written unit.
pub(super) fn append(language: Language, text: &mut String, letter: u8, value: f64) {
    let mut number = format!("{value:.5}");
    let kept = number.trim_end_matches('0').len();
    number.truncate(kept);
    if number == "-0." {
        "0.".clone_into(&mut number);
    }
    // A Fanuc reads a number without a point as increments.
    if language == Language::Rs274 {
        number.truncate(number.trim_end_matches('.').len());
    }
    // Writing to a string cannot fail.
    let _ = write!(text, " {}{number}", char::from(letter));
}
