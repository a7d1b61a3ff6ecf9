//! Diagnostics with one text, apart from its quantities: they are drawn once, with the lines of the others.

use std::borrow::Cow;
use std::collections::HashMap;

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::source::Source;

/// Further lines of a repeated diagnostic that are named.
const MOST_LINES: usize = 8;

/// Units of quantities in messages.
const UNITS: &[&str] = &["mm", "µm", "mm/min", "deg", "degrees"];

/// A message in which each quantity with a unit is `#`. The same fault has other numbers in each block, such as the radii of arcs without a common center.
fn without_quantities(message: &str) -> Cow<'_, str> {
    let unit = |word: &str| UNITS.contains(&word.trim_end_matches([',', ';', ':', ')', '.']));
    if !message.split(' ').skip(1).any(unit) {
        return Cow::Borrowed(message);
    }
    let mut words: Vec<&str> = message.split(' ').collect();
    let is_quantity = |pair: &[&str]| match pair {
        [number, of] => unit(of) && number.trim_start_matches('(').parse::<f64>().is_ok(),
        _ => false,
    };
    let quantities: Vec<bool> = words.windows(2).map(is_quantity).collect();
    for (word, _) in words.iter_mut().zip(quantities).filter(|(_, is_quantity)| *is_quantity) {
        *word = "#";
    }
    Cow::Owned(words.join(" "))
}

/// The text that a diagnostic shares with others of its group. In diagnostics of a program the quantities are those of one block; in those of measured data
/// they are the result.
fn shared_text(diagnostic: &Diagnostic) -> Cow<'_, str> {
    let is_of_program = matches!(diagnostic.code.as_str().as_bytes(), [_, b'0', b'1'..=b'3', ..]);
    if is_of_program { without_quantities(&diagnostic.message) } else { Cow::Borrowed(&diagnostic.message) }
}

/// The diagnostics in groups with the same text in the same file, in order of their first occurrence.
pub(super) fn repeated<'a>(shown: &[&'a (Diagnostic, Option<Source>)]) -> Vec<Vec<&'a (Diagnostic, Option<Source>)>> {
    let mut groups: Vec<Vec<&(Diagnostic, Option<Source>)>> = Vec::new();
    let mut known = HashMap::new();
    for &entry in shown {
        let (diagnostic, source) = entry;
        let name = source.as_ref().map(Source::name);
        let index =
            *known.entry((diagnostic.code, shared_text(diagnostic), &*diagnostic.help, name)).or_insert(groups.len());
        match groups.get_mut(index) {
            Some(group) => group.push(entry),
            None => groups.push(vec![entry]),
        }
    }
    groups
}

/// The lines of further occurrences, as a line of text.
pub(super) fn further_lines(others: &[&(Diagnostic, Option<Source>)]) -> String {
    let mut lines: Vec<usize> = others
        .iter()
        .filter_map(|(diagnostic, source)| Some(source.as_ref()?.line_column(diagnostic.place?.span.start).0))
        .collect();
    lines.dedup();
    let more = lines.len().saturating_sub(MOST_LINES);
    let named: Vec<String> = lines.iter().take(MOST_LINES).map(usize::to_string).collect();
    match (named.as_slice(), more) {
        ([], _) => String::new(),
        ([one], _) => format!("  = also in line {one}\n"),
        ([most @ .., last], 0) => format!("  = also in lines {} and {last}\n", most.join(", ")),
        (all, more) => format!("  = also in lines {} and {more} more\n", all.join(", ")),
    }
}
