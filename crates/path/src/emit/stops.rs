//! Exact stops: they belong to the end of a block of the source, however many lines the block becomes.

use super::line::LineBuilder;
use ncfix_dialect::BlockEnds;

/// What is in force, and what the block that is being written has still to say.
#[derive(Debug)]
pub(super) struct Stops {
    words: BlockEnds,
    /// Whether the block has an exact stop that is not written yet.
    stops_once: bool,
    /// Whether the program has said that every block stops exactly.
    always_stops: bool,
    /// Whether the lines of the block run through where the program stops at its end.
    is_running: bool,
}

impl Stops {
    pub(super) fn new(words: BlockEnds) -> Stops {
        Stops { words, stops_once: false, always_stops: false, is_running: false }
    }

    /// Writes a word that is passed on, unless it is the stop at the end of the block, which waits for that.
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

    /// Takes note of a word of the group that something else writes.
    pub(super) fn note(&mut self, word: &str) {
        if self.words.group.contains(&word) {
            self.always_stops = word == self.words.exact;
        }
    }

    pub(super) fn begin_block(&mut self) {
        self.stops_once = false;
    }

    /// Before the last line of a block ends.
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

    /// Before another line of a block ends: the program stops at the end of its block, not at the end of each line that the block
    /// becomes.
    pub(super) fn run_through(&mut self, line: &mut LineBuilder) {
        if !self.always_stops || !line.has_motion || std::mem::replace(&mut self.is_running, true) {
            return;
        }
        // One word of a group in a block: the one that is there changes.
        if !line.replace_marked(self.words.exact.len(), self.words.running) {
            line.insert(self.words.running);
        }
    }
}
