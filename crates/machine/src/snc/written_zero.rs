//! Zero offsets that a program sets itself. They are values of the control like those of the machine file, so they may contain the error of the machine.

use std::sync::Arc;

use ncfix_base::geometry::{AxisVector, FrameParts};

/// Maximum number of values with an index.
const MOST: usize = 1000;

/// Value of a zero offset that a program sets itself.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenZero {
    /// Index after those of the machine file, in the order of first use.
    pub index: u16,
    /// Name of the zero offset.
    pub name: String,
    /// Its shift, mm and rad.
    pub shift: AxisVector,
}

/// Values of zero offsets that a program has set and used.
#[derive(Clone, Debug, Default)]
pub struct WrittenZeros(Vec<Arc<WrittenZero>>);

impl WrittenZeros {
    /// Returns the entry for a value, a new one at its first use; `None` after a thousand values. `first` is the number of zero offsets of the machine.
    pub fn entry(&mut self, first: usize, name: &str, parts: &FrameParts) -> Option<Arc<WrittenZero>> {
        let shift = parts.shift();
        if let Some(known) = self.0.iter().find(|known| known.name == name && known.shift == shift) {
            return Some(Arc::clone(known));
        }
        let index = u16::try_from(first + self.0.len()).ok().filter(|_| self.0.len() < MOST)?;
        let new = Arc::new(WrittenZero { index, name: name.to_owned(), shift });
        self.0.push(Arc::clone(&new));
        Some(new)
    }
}
