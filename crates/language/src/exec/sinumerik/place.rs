//! The mark of a block: its label or its number.

use crate::syntax::sinumerik::{Block, BlockNumber, NameId, Program};

/// The mark of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Place {
    Label(NameId),
    Number(BlockNumber),
}

impl Place {
    /// `true` if the block has this mark.
    pub(super) fn is_at(self, block: &Block) -> bool {
        match self {
            Place::Label(name) => block.label == Some(name),
            Place::Number(number) => block.number == Some(number),
        }
    }

    /// The mark for the text `LABEL`, `N10` or `:10`; `None` for a label that the program does not have.
    pub(super) fn of_text(program: &Program, text: &[u8]) -> Option<Place> {
        let text: String = text.trim_ascii().iter().map(|byte| char::from(byte.to_ascii_uppercase())).collect();
        let number = |main, digits: &str| {
            let is_number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
            let number = digits.parse().ok().filter(|_| is_number)?;
            Some(Place::Number(BlockNumber { main, number }))
        };
        let numbered = match text.as_bytes().first() {
            Some(b'N') => number(false, &text[1..]),
            Some(b':') => number(true, &text[1..]),
            _ => None,
        };
        numbered.or_else(|| program.names.find(text.trim_end_matches(':')).map(Place::Label))
    }
}
