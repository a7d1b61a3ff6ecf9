//! The measurement that separates the explanations, as a sentence.

use crate::number::{grouped, significant};
use ncfix_metrology::diagnose::NextMeasurement;

/// Returns the command of a measurement with what it contributes.
pub(crate) fn next_sentence(next: &NextMeasurement) -> String {
    let difference = if next.separates_the_first_two() {
        format!(
            "the first two explanations differ by {} {} RMS in them",
            significant(next.difference),
            next.unit.sign()
        )
    } else {
        "it does not separate the first two explanations".to_owned()
    };
    format!(
        "{} (its {} readings should remove {:.0} % of the ambiguity; {difference})",
        next.command,
        grouped(next.readings as u64),
        100.0 * next.resolves
    )
}
