//! Words of a line that goes to a control: codes, addresses, and the words that a code uses.

use super::rules::{Axes, BlockCode, Grammar};

/// Axis letters.
pub(super) const AXES: &[u8] = b"XYZABCUVW";

/// Word of a block: its name and its value.
pub(super) struct BlockWord<'t> {
    pub(super) text: &'t str,
    /// Name: `X`, `B1`, `ADIS`.
    pub(super) name: &'t str,
    pub(super) value: &'t str,
    pub(super) code: Option<BlockCode>,
    pub(super) is_claimed: bool,
}

impl BlockWord<'_> {
    pub(super) fn letter(&self) -> u8 {
        self.name.as_bytes().first().copied().unwrap_or(0)
    }

    pub(super) fn is_axis(&self) -> bool {
        AXES.contains(&self.letter()) && self.name.bytes().skip(1).all(|byte| byte.is_ascii_digit())
    }
}

/// Splits a line into words. Text in quotation marks stays part of its word.
pub(super) fn words<'t>(text: &'t str, grammar: &Grammar) -> Vec<BlockWord<'t>> {
    let mut is_quoted = false;
    let is_between = |character: char| {
        is_quoted ^= character == '"';
        character.is_ascii_whitespace() && !is_quoted
    };
    let parts = text.split(is_between).filter(|part| !part.is_empty());
    let word = |part: &'t str| {
        let (name, value) = part.split_once('=').unwrap_or_else(|| {
            let end = part.find(|character: char| !character.is_ascii_alphabetic()).unwrap_or(part.len());
            part.split_at(if end == 0 { part.chars().next().map_or(0, char::len_utf8) } else { end })
        });
        BlockWord { text: part, name, value, code: grammar.code(part), is_claimed: false }
    };
    parts.map(word).collect()
}

/// True if a value is a finite number.
pub(super) fn is_number(value: &str) -> bool {
    value.parse::<f64>().is_ok_and(f64::is_finite)
}

/// True if a value is a number in the given brackets.
pub(super) fn absolute(value: &str, begin: &str) -> bool {
    value.strip_prefix(begin).and_then(|rest| rest.strip_suffix(')')).is_some_and(is_number)
}

/// Claims the words of a block that a code uses and returns their texts. `None` if one of them is an axis word that the code must not have.
pub(super) fn arguments(code: BlockCode, words: &mut [BlockWord<'_>], axes: Axes) -> Option<Vec<String>> {
    let mut out = Vec::new();
    let mut is_refused = false;
    let is_speed = code.entry.is_some_and(|entry| entry.name.starts_with("G96"));
    for word in words.iter_mut().filter(|word| word.code.is_none() && !word.is_claimed) {
        let Some(entry) = code.entry else { continue };
        let letter = word.letter();
        let is_used = match word.name {
            "F" => false,
            "S" => is_speed,
            name if name.len() == 1 => entry.uses(letter),
            name => {
                let index = name.get(1..).and_then(|digits| digits.parse::<u16>().ok());
                index.is_some_and(|index| entry.uses_indexed(letter, index))
                    || entry.words.split(' ').any(|known| known == name)
            }
        };
        // A dwell accepts any word for its time.
        let is_used = is_used || entry.name == "G4";
        if !is_used || word.is_axis() && axes == Axes::Positions && entry.name != "G4" {
            continue;
        }
        is_refused |= word.is_axis() && axes == Axes::Refused;
        is_refused |= !is_number(word.value);
        word.is_claimed = true;
        out.push(word.text.to_owned());
    }
    (!is_refused).then_some(out)
}

/// Joins a code and its words to a block.
pub(super) fn block(code: &str, arguments: Option<Vec<String>>) -> Option<String> {
    let words = arguments?;
    Some(std::iter::once(code.to_owned()).chain(words).collect::<Vec<_>>().join(" "))
}
