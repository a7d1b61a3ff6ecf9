//! Values of earlier programs that a run replaces by 0 or null. A run for a correction refuses them; a run that only shows the moves goes on and names them.

use std::cell::RefCell;

use super::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// Largest number of values that are named.
const MOST: usize = 20;

/// Numbers of the values, and those that are not reported yet, with the place of the first use.
#[derive(Clone, Debug, Default)]
pub(in crate::exec) struct AssumedValues {
    /// True if they are named.
    is_told: bool,
    noted: RefCell<Noted>,
}

#[derive(Clone, Debug, Default)]
struct Noted {
    numbers: Vec<i64>,
    new: Vec<(i64, Span)>,
}

impl AssumedValues {
    pub(in crate::exec) fn new(is_told: bool) -> AssumedValues {
        AssumedValues { is_told, ..AssumedValues::default() }
    }

    /// Notes that a value was replaced.
    pub(in crate::exec) fn note(&self, number: i64, span: Span) {
        let mut noted = self.noted.borrow_mut();
        if self.is_told && noted.numbers.len() < MOST && !noted.numbers.contains(&number) {
            noted.numbers.push(number);
            noted.new.push((number, span));
        }
    }

    /// Takes the warnings of values that were not reported yet. `letter` is `R`, `E` or `#`; `used` takes the place of the values.
    pub(in crate::exec) fn take(&mut self, letter: char, used: &'static str) -> impl Iterator<Item = Fault> {
        let new = std::mem::take(&mut self.noted.get_mut().new);
        new.into_iter().map(move |(number, span)| {
            let key = if letter == 'R' { format!("$R[{number}]") } else { format!("{letter}{number}") };
            let message = format!(
                "{letter}{number} keeps its value between programs, and this program has not set it; {used} is used"
            );
            let help = format!("set it in the program, or add \"{key}\" = … to [system] of the machine file");
            fault(Code::START_ASSUMED, span, message, help)
        })
    }
}
