//! Diagnostics that a table repeats row by row: a wrong unit is wrong in every row.

use std::collections::BTreeMap;

use ncfix_base::diagnostic::Diagnostic;

/// Keeps the first `most` of diagnostics whose codes and messages differ only in numbers; the last kept one states the number of the others.
pub(super) fn without_repeats(findings: &mut Vec<Diagnostic>, most: usize) {
    let key = |one: &Diagnostic| -> (&'static str, String) {
        let is_number = |letter: &char| letter.is_ascii_digit() || ['.', '-', '+'].contains(letter);
        (one.code.as_str(), one.message.chars().filter(|letter| !is_number(letter)).collect())
    };
    let mut counts: BTreeMap<(&'static str, String), usize> = BTreeMap::new();
    for one in findings.iter() {
        *counts.entry(key(one)).or_insert(0) += 1;
    }
    let mut seen: BTreeMap<(&'static str, String), usize> = BTreeMap::new();
    findings.retain_mut(|one| {
        let own = key(one);
        let all = counts.get(&own).copied().unwrap_or(1);
        let number = seen.entry(own).or_insert(0);
        *number += 1;
        if *number == most && all > most {
            one.message = format!("{}; {} more of this kind", one.message, all - most);
        }
        *number <= most
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::diagnostic::Code;

    #[test]
    fn diagnostics_that_differ_in_numbers_alone_are_counted() {
        let of = |text: String| Diagnostic::nowhere(Code::OUT_OF_TRAVEL, text, "");
        let mut all: Vec<Diagnostic> = (0..1184).map(|k| of(format!("X {}.5 mm is outside", 700 + k))).collect();
        all.insert(1, of("Y -3 mm is outside".into()));
        without_repeats(&mut all, 3);
        let messages: Vec<&str> = all.iter().map(|one| one.message.as_str()).collect();
        let last = "X 702.5 mm is outside; 1181 more of this kind";
        assert_eq!(messages, ["X 700.5 mm is outside", "Y -3 mm is outside", "X 701.5 mm is outside", last]);
    }
}
