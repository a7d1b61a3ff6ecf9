//! Files that contradict each other in sign, as a sentence.

use super::text::sign;
use crate::number::{probability, significant};
use ncfix_metrology::diagnose::{SignContradiction, SignedError};

/// Signs that are wrong with less than this probability are not the main result.
const MAIN: f64 = 0.5;

/// Returns the contradiction with the signs that differ and the next step; `None` if another cause of the difference is more probable.
pub(super) fn contradiction_sentence(found: &SignContradiction) -> Option<String> {
    if found.probability < MAIN {
        return None;
    }
    let of = |one: &SignedError| {
        let plus = if one.value > 0.0 { "+" } else { "" };
        format!("{} {plus}{} {}", one.cause, significant(one.value), sign(&one.unit))
    };
    let first = found.one_of.first()?;
    let errors: Vec<String> = found.errors.iter().map(of).collect();
    let read = if errors.is_empty() { "its errors".to_owned() } else { listed(&errors) };
    let sure = probability(found.probability);
    Some(if found.one_of.len() > 1 {
        let all = listed(&found.one_of);
        let others = listed(found.one_of.get(1..).unwrap_or_default());
        format!(
            "{all} contradict each other in sign: {first} has {read}, {others} the opposite. One of them has the wrong sign ({sure}); the readings do not show which. \
             Next: check the sign of one reading of each after a known motion of the axis, and import the wrong file again with the other --sign."
        )
    } else {
        let others = match found.supported_by.as_slice() {
            [] => "the other readings".to_owned(),
            others => listed(others),
        };
        let verb = if found.supported_by.len() == 1 { "has" } else { "have" };
        let agree = if found.supported_by.len() > 1 { ", and these agree with each other" } else { "" };
        format!(
            "{first} contradicts {others} in sign: {first} has {read}, {others} {verb} the opposite{agree}. So {first} has the wrong sign ({sure}). \
             Next: check the sign of one reading of {first} after a known motion of the axis, and import it again with the other --sign."
        )
    })
}

/// Joins names: `A`, `A and B`, `A, B and C`.
fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_accused_only_if_others_agree() {
        let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        let error = SignedError { cause: "motion EXX".to_owned(), value: 20.0, unit: "um/m".to_owned() };
        let mut found = SignContradiction {
            one_of: names(&["a", "b"]),
            supported_by: Vec::new(),
            errors: vec![error],
            probability: 0.999,
        };
        let two = contradiction_sentence(&found).unwrap();
        assert!(
            two.starts_with("a and b contradict each other in sign: a has motion EXX +20.0 µm/m, b the opposite."),
            "{two}"
        );
        (found.one_of, found.supported_by) = (names(&["b"]), names(&["a", "c"]));
        let three = contradiction_sentence(&found).unwrap();
        assert!(
            three.starts_with("b contradicts a and c in sign:") && three.contains("agree with each other"),
            "{three}"
        );
        found.probability = 0.4;
        assert_eq!(contradiction_sentence(&found), None);
    }
}
