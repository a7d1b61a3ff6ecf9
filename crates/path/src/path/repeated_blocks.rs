//! Number of executions of each block: loops and subprograms lengthen the output.

use std::collections::HashMap;

use ncfix_base::source::FileId;
use ncfix_machine::snc::Origin;

/// Executions of the blocks that were executed again: a program without loops and calls needs no memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RepeatedBlocks {
    counts: HashMap<(FileId, u32), u64>,
    /// Last line of each file that was executed so far.
    reached: HashMap<FileId, u32>,
}

impl RepeatedBlocks {
    /// Counts an execution.
    pub(super) fn note(&mut self, origin: &Origin) {
        let reached = self.reached.entry(origin.file).or_default();
        if origin.line > *reached {
            *reached = origin.line;
        } else {
            *self.counts.entry((origin.file, origin.line)).or_insert(1) += 1;
        }
    }

    /// File, line and executions of the block that was executed most often, the first one of several; `None` without repetition.
    #[must_use]
    pub fn largest(&self) -> Option<(FileId, u32, u64)> {
        let largest =
            self.counts.iter().max_by_key(|((file, line), count)| (**count, std::cmp::Reverse((file.0, *line))));
        largest.map(|(&(file, line), &count)| (file, line, count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_the_most_frequent_blocks_is_named() {
        let mut blocks = RepeatedBlocks::default();
        let mut note = |line: u32| blocks.note(&Origin { line, ..Origin::default() });
        [1, 7, 8, 7, 8].into_iter().for_each(&mut note);
        assert_eq!(blocks.largest(), Some((FileId(0), 7, 2)));
        assert_eq!(RepeatedBlocks::default().largest(), None);
    }
}
