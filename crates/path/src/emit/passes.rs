//! Further passes of loops: a block of the main program that is executed again says so on its first line.

use std::collections::HashMap;

/// Passes of the blocks that were executed again: a program without loops needs no memory.
#[derive(Debug, Default)]
pub(super) struct LoopPasses {
    /// Line of the last block.
    reached: u32,
    /// Executions of the blocks at which a further pass began, by line.
    counts: HashMap<u32, u64>,
}

impl LoopPasses {
    /// Notes a block by its line in the main program. Returns the number of the pass if a further one begins with it: the program has jumped back.
    /// Further lines of a block have its line, but not its number.
    pub(super) fn note(&mut self, line: u32, has_number: bool) -> Option<u64> {
        let is_back = line < self.reached || line == self.reached && has_number;
        self.reached = line;
        if !is_back {
            return None;
        }
        let count = self.counts.entry(line).or_insert(1);
        *count += 1;
        Some(*count)
    }
}

/// The comment of a further pass.
pub(super) fn text(pass: u64, number: Option<u32>, line: u32) -> String {
    match number {
        Some(number) => format!("pass {pass} of N{number}"),
        None => format!("pass {pass} of line {line}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_block_of_a_further_pass_is_counted() {
        let mut passes = LoopPasses::default();
        let mut note = |line: u32| passes.note(line, true);
        // Lines 3 to 5 three times, line 4 twice within the second pass.
        let found: Vec<Option<u64>> = [1, 3, 4, 5, 3, 4, 4, 5, 3, 4, 5, 6].into_iter().map(&mut note).collect();
        let second = [Some(2), None, Some(2), None];
        let expected = [&[None; 4][..], &second, &[Some(3), None, None, None]].concat();
        assert_eq!(found, expected);
        assert_eq!(passes.note(6, false), None);
        assert_eq!(text(2, Some(60), 6), "pass 2 of N60");
        assert_eq!(text(3, None, 6), "pass 3 of line 6");
    }
}
