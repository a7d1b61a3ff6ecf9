//! Arguments of macro calls: the variable for each word of the block of G65 or G66.

use super::call::Arguments;
use super::expression::Scope;
use super::origin;
use crate::exec::core::fault::{Fault, bad_value, fault};
use crate::syntax::words::{Address, Value, Word};
use ncfix_base::diagnostic::Code;

/// First variable of the groups of I, J, K.
const FIRST_IJK: u32 = 4;
/// Number of groups of I, J, K.
const GROUPS: u32 = 10;

/// The variable of a letter of argument specification I; I, J and K are those of the first group of specification II.
fn variable_of(letter: u8) -> Option<u32> {
    Some(match letter {
        b'A' => 1,
        b'B' => 2,
        b'C' => 3,
        b'D' => 7,
        b'E' => 8,
        b'F' => 9,
        b'H' => 11,
        b'M' => 13,
        b'Q' => 17,
        b'R' => 18,
        b'S' => 19,
        b'T' => 20,
        b'U' => 21,
        b'V' => 22,
        b'W' => 23,
        b'X' => 24,
        b'Y' => 25,
        b'Z' => 26,
        _ => return None,
    })
}

/// The letter that alone sets a variable.
pub(super) fn letter_of(number: u32) -> Option<u8> {
    match number {
        4..=6 => Some(b'I' + (number - FIRST_IJK) as u8),
        _ => (b'A'..=b'Z').find(|&letter| variable_of(letter) == Some(number)),
    }
}

/// `true` if an argument without decimal point counts increments in that mode (lengths and angles), `false` for whole numbers.
fn is_measured(letter: u8) -> bool {
    !matches!(letter, b'D' | b'E' | b'F' | b'H' | b'M' | b'S' | b'T')
}

/// Position in the groups of I, J, K.
///
/// Within a group the letters are in alphabetical order; a letter out of order begins the next group.
#[derive(Default)]
struct Groups {
    group: u32,
    last: u32,
}

impl Groups {
    /// The variable of the next I (0), J (1) or K (2); `None` after the tenth group.
    fn next(&mut self, place: u32) -> Option<u32> {
        if self.last > place {
            self.group += 1;
        }
        self.last = place + 1;
        (self.group < GROUPS).then(|| FIRST_IJK + 3 * self.group + place)
    }
}

/// Evaluates the arguments. The letters in `taken` belong to the call itself; `increment` is the length unit of numbers without point, mm.
pub(super) fn read(
    scope: &Scope<'_, '_>,
    words: &[Word],
    taken: &[u8],
    increment: Option<f64>,
) -> Result<Arguments, Fault> {
    let mut out = Arguments::new();
    let mut groups = Groups::default();
    let type_two = scope.channel.settings.machine.control.macros.arguments_two;
    for word in words {
        let letter = match word.address {
            Address::Letter(letter) => letter,
            Address::Name(_) => continue,
            _ => {
                return Err(bad_value(
                    word.span,
                    "this is not an argument of a macro",
                    "arguments are letters with values",
                ));
            }
        };
        if taken.contains(&letter) {
            continue;
        }
        let number = match letter {
            b'I' | b'J' | b'K' if type_two => match groups.next(u32::from(letter - b'I')) {
                Some(number) => number,
                None => {
                    let message = "more than ten groups of I, J and K";
                    return Err(fault(Code::BAD_ARGUMENTS, word.span, message, "the variables end at #33"));
                }
            },
            b'I' | b'J' | b'K' => FIRST_IJK + u32::from(letter - b'I'),
            _ => variable_of(letter).ok_or_else(|| {
                let message = format!("{} cannot be an argument", char::from(letter));
                fault(Code::BAD_ARGUMENTS, word.span, message, "G, L, N, O and P have no variable")
            })?,
        };
        let scale = match word.value {
            Value::Number { has_point: false, .. } if is_measured(letter) => increment.unwrap_or(1.0),
            _ => 1.0,
        };
        // Of two words for one variable the later one is used.
        out.retain(|(known, ..)| *known != number);
        if let Some(value) = scope.word(word)? {
            out.push((number, value * scale, origin::of_word(scope, word)?));
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::Groups;

    fn variables(letters: &str) -> Vec<Option<u32>> {
        let mut groups = Groups::default();
        letters.bytes().map(|letter| groups.next(u32::from(letter - b'I'))).collect()
    }

    #[test]
    fn the_triples_go_on_where_the_alphabet_does_not() {
        assert_eq!(variables("IJK"), [Some(4), Some(5), Some(6)]);
        assert_eq!(variables("II"), [Some(4), Some(7)]);
        assert_eq!(variables("IKIJ"), [Some(4), Some(6), Some(7), Some(8)]);
        assert_eq!(variables("JI"), [Some(5), Some(7)]);
        let all = variables(&"IJK".repeat(11));
        assert_eq!((all[29], all[30]), (Some(33), None));
    }
}
