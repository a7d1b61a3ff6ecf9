//! Further passes of loops: a block of the main program that is executed again says so on its first line.

use std::collections::HashMap;

use super::block_number::NumberSet;

/// Passes of the blocks that were executed again. A program without loops needs a bit for each of its lines.
#[derive(Debug, Default)]
pub(super) struct LoopPasses {
    /// Lines of the blocks executed so far.
    executed: NumberSet,
    /// Executions of the blocks that were executed again, by line.
    counts: HashMap<u32, u64>,
    /// Line of the last block.
    reached: u32,
    /// `true` if the program has jumped back, and no block was executed again since.
    is_back: bool,
}

impl LoopPasses {
    /// Notes the begin of a block by its line in the main program. Returns the number of its execution if it is the first one that is executed again
    /// after a jump back. Further lines of a block have no number, for example a rounding that is made after the next block. A block that is written
    /// in several parts has the line of the last one: a loop of one block has no marks.
    pub(super) fn note(&mut self, line: u32, has_number: bool) -> Option<u64> {
        if !has_number {
            self.reached = self.reached.max(line);
            return None;
        }
        if line == self.reached {
            return None;
        }
        self.is_back |= line <= self.reached;
        self.reached = line;
        if self.executed.add(line) {
            return None;
        }
        let count = self.counts.entry(line).or_insert(1);
        *count += 1;
        std::mem::take(&mut self.is_back).then_some(*count)
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

    fn found(lines: &[u32]) -> Vec<Option<u64>> {
        let mut passes = LoopPasses::default();
        lines.iter().map(|&line| passes.note(line, true)).collect()
    }

    #[test]
    fn the_first_block_of_a_further_pass_is_counted() {
        // Lines 3 to 5 three times; line 4 in two parts within the second pass.
        let second = [Some(2), None, None, None];
        let expected = [&[None; 4][..], &second, &[Some(3), None, None, None]].concat();
        assert_eq!(found(&[1, 3, 4, 5, 3, 4, 4, 5, 3, 4, 5, 6]), expected);
        // Line 2 runs in the second pass only: the first block that is executed again is line 3.
        assert_eq!(found(&[1, 3, 2, 3, 3]), [None, None, None, Some(2), None]);
        assert_eq!(text(2, Some(60), 6), "pass 2 of N60");
        assert_eq!(text(3, None, 6), "pass 3 of line 6");
    }

    #[test]
    fn further_lines_of_a_block_are_no_pass() {
        let mut passes = LoopPasses::default();
        // A rounding of line 3 after line 4.
        let lines = [(3, true), (4, true), (3, false), (6, true), (6, false), (6, true)];
        assert_eq!(lines.map(|(line, own)| passes.note(line, own)), [None; 6]);
        // A loop of a block with a number and one without.
        let mut passes = LoopPasses::default();
        let lines = [(6, true), (7, false), (6, true), (7, false), (6, true)];
        assert_eq!(lines.map(|(line, own)| passes.note(line, own)), [None, None, Some(2), None, Some(3)]);
    }
}
