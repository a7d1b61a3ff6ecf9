//! Exact stops: they belong to the end of a source block, even if the block becomes several lines.

use super::line::LineBuilder;
use ncfix_dialect::BlockEnds;

/// The active exact stop, and the pending one of the current block.
#[derive(Debug)]
pub(super) struct Stops {
    words: BlockEnds,
    /// `true` if the block has an exact stop that is not written yet.
    stops_once: bool,
    /// `true` if the program has commanded an exact stop for every block.
    always_stops: bool,
    /// `true` if the lines of the block pass through without stop while the program stops at the end of the block.
    is_running: bool,
}

impl Stops {
    pub(super) fn new(words: BlockEnds) -> Stops {
        Stops { words, stops_once: false, always_stops: false, is_running: false }
    }

    /// Writes a word that is passed on; a stop at the end of the block is held back until then.
    pub(super) fn keep(&mut self, line: &mut LineBuilder, word: &str) {
        if self.words.once == Some(word) {
            self.stops_once = true;
            return;
        }
        self.note(word);
        line.word(word.as_bytes());
        if word == self.words.exact {
            line.mark_last(word.len());
        }
    }

    /// Records a word of the group that another part of the writer writes.
    pub(super) fn note(&mut self, word: &str) {
        if self.words.group.contains(&word) {
            self.always_stops = word == self.words.exact;
        }
    }

    pub(super) fn begin_block(&mut self) {
        self.stops_once = false;
    }

    /// Writes the pending exact stop before the last line of a block ends.
    pub(super) fn end_block(&mut self, line: &mut LineBuilder) {
        if line.is_open() {
            if let Some(once) = self.words.once.filter(|_| std::mem::take(&mut self.stops_once)) {
                line.insert(once);
            }
            if std::mem::take(&mut self.is_running) {
                line.insert(self.words.exact);
            }
        }
    }

    /// Suppresses the stop before a further line of a block: the program stops at the end of its block, not at the end of each line.
    pub(super) fn run_through(&mut self, line: &mut LineBuilder) {
        if !self.always_stops || !line.has_motion || std::mem::replace(&mut self.is_running, true) {
            return;
        }
        // A block may have one word of a group: the existing one changes.
        if !line.replace_marked(self.words.exact.len(), self.words.running) {
            line.insert(self.words.running);
        }
    }
}
