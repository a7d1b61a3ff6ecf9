//! Block numbers of the source. Each is written once, on the first line of its block, so that a block search finds that block.
//!
//! A block becomes several lines, a loop runs several times, and subprograms have their own numbers. The number stands on the first line of the first
//! execution of its block of the main program, and nowhere else.

use ncfix_machine::snc::{BlockNumber, Origin};

/// The largest block number that a control accepts: eight digits.
const LARGEST: u32 = 99_999_999;

/// A set of block numbers, one bit each.
#[derive(Clone, Debug, Default)]
pub struct NumberSet {
    bits: Vec<u64>,
    largest: u32,
}

impl NumberSet {
    /// Adds a number. Returns `true` if it is new; a number beyond the control's limit is never new.
    pub fn add(&mut self, number: u32) -> bool {
        if number > LARGEST {
            return false;
        }
        let (index, bit) = (number as usize / 64, 1 << (number % 64));
        if index >= self.bits.len() {
            self.bits.resize(index + 1, 0);
        }
        self.largest = self.largest.max(number);
        let word = &mut self.bits[index];
        let is_new = *word & bit == 0;
        *word |= bit;
        is_new
    }

    /// `true` if the set contains the number.
    #[must_use]
    pub fn has(&self, number: u32) -> bool {
        self.bits.get(number as usize / 64).is_some_and(|word| word & (1 << (number % 64)) != 0)
    }

    /// The largest number in the set; 0 if it is empty.
    #[must_use]
    pub fn largest(&self) -> u32 {
        self.largest
    }
}

/// The block numbers written so far.
#[derive(Debug, Default)]
pub(super) struct BlockNumbers {
    plain: NumberSet,
    /// Numbers of main blocks, `:10`.
    main: NumberSet,
}

impl BlockNumbers {
    /// Returns the number to write for a block that begins: its own, if it belongs to the main program and is not written yet.
    pub(super) fn first(&mut self, origin: &Origin, number: Option<BlockNumber>) -> Option<BlockNumber> {
        let number = number.filter(|_| origin.calls == 0)?;
        let written = if number.main { &mut self.main } else { &mut self.plain };
        written.add(number.number).then_some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_new_once_and_only_in_the_main_program() {
        let mut numbers = BlockNumbers::default();
        let (main, called) = (Origin::default(), Origin { calls: 1, ..Origin::default() });
        let mut first =
            |origin: &Origin, number, main| numbers.first(origin, Some(BlockNumber { main, number })).is_some();
        assert!(first(&main, 100, false) && !first(&main, 100, false));
        assert!(first(&main, 10, false), "numbers need not rise");
        assert!(!first(&called, 20, false) && first(&main, 20, false));
        assert!(first(&main, 10, true) && !first(&main, 10, true));
        assert!(first(&main, LARGEST, false) && !first(&main, LARGEST + 1, false) && !first(&main, u32::MAX, false));
        assert!(first(&main, 0, false));
    }

    #[test]
    fn a_set_knows_its_largest() {
        let mut set = NumberSet::default();
        assert_eq!(set.largest(), 0);
        for number in [5, 640, 63, 64] {
            assert!(set.add(number) && set.has(number));
        }
        assert!(!set.has(6) && !set.has(1_000_000));
        assert_eq!(set.largest(), 640);
    }
}
