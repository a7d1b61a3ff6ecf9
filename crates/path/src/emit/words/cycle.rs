//! Holes that stay a drilling cycle: G73, G76, G81 to G89.

use std::sync::Arc;

use super::{Language, Words};
use crate::path::CycleBlock;
use ncfix_base::geometry::Axis;
use ncfix_machine::snc::{CycleArgument, DrillingCycle};

/// The end of the cycles.
pub(super) const END: &str = "G80";

/// The words of the cycle in force.
#[derive(Debug)]
pub(super) struct WrittenCycle {
    cycle: Arc<DrillingCycle>,
    reference: i64,
    bottom: i64,
    peck: Option<i64>,
}

impl Words {
    /// Writes a hole. Words in force are left out.
    pub(super) fn cycle(&mut self, block: &CycleBlock, out: &mut Vec<u8>) {
        if self.flavour.language == Language::Grundig {
            self.defined_cycle(block, out);
            return;
        }
        let CycleBlock { cycle, reference, bottom, peck, .. } = block;
        let (reference, bottom, peck) = (*reference, *bottom, *peck);
        let before = self.cycle.take().filter(|before| *before.cycle == **cycle);
        // An M function of the cycle (M29) is in the block before it.
        for text in cycle.arguments.iter().filter_map(CycleArgument::function).filter(|_| before.is_none()) {
            self.line.words_before(text.as_bytes(), out);
        }
        self.line.begin_motion();
        if before.is_none() {
            self.end_of_strokes(cycle);
            self.line.word(cycle.name.as_bytes());
        }
        let [abscissa, ordinate, along] = cycle.plane.axes();
        // Without a word across the hole its depth triggers the cycle.
        let is_there = block.words.is_empty();
        let is_written = |axis: &Axis| !is_there && (before.is_none() || block.words.contains(*axis));
        for axis in [abscissa, ordinate].into_iter().filter(is_written) {
            self.cycle_word(axis.letter(), block.position[axis.slot()]);
        }
        if is_there || before.as_ref().is_none_or(|before| before.bottom != bottom) {
            self.cycle_word(along.letter(), bottom);
        }
        if before.as_ref().is_none_or(|before| before.reference != reference) {
            self.cycle_word(b'R', reference);
        }
        if let Some(count) = peck.filter(|_| before.as_ref().is_none_or(|before| before.peck != peck)) {
            self.cycle_word(b'Q', count);
        }
        if before.is_none() {
            for argument in &cycle.arguments {
                if let CycleArgument::Text(text) = argument
                    && argument.function().is_none()
                {
                    self.line.word(text.as_bytes());
                }
            }
        }
        if block.feed > 0.0 && (block.feed_named || block.feed != self.feed) {
            self.feed_word(block.feed);
        }
        self.line.release();
        self.note_words_in_force(block);
        self.place = Some(block.position);
        self.motion = "";
        self.is_drilling = true;
        self.cycle = Some(WrittenCycle { cycle: Arc::clone(cycle), reference, bottom, peck });
    }

    /// Writes where the strokes end, if the program states it.
    fn end_of_strokes(&mut self, cycle: &DrillingCycle) {
        if cycle.is_end_stated {
            self.line.word(if cycle.ends_at_reference { b"G99" } else { b"G98" });
        }
    }

    /// Notes all words of a hole: the program may state those again that do not change.
    fn note_words_in_force(&mut self, block: &CycleBlock) {
        let CycleBlock { cycle, reference, bottom, peck, .. } = block;
        let end = self.line.text.len();
        self.end_of_strokes(cycle);
        self.line.word(cycle.name.as_bytes());
        let [abscissa, ordinate, along] = cycle.plane.axes();
        for axis in [abscissa, ordinate] {
            self.cycle_word(axis.letter(), block.position[axis.slot()]);
        }
        self.cycle_word(along.letter(), *bottom);
        self.cycle_word(b'R', *reference);
        if let Some(count) = *peck {
            self.cycle_word(b'Q', count);
        }
        for argument in &cycle.arguments {
            if let CycleArgument::Text(text) = argument {
                self.line.word(text.as_bytes());
            }
        }
        if block.feed > 0.0 && !block.feed_named && block.feed == self.feed {
            let (feed, has_feed) = (self.feed, self.line.has_feed);
            self.feed_word(feed);
            self.line.has_feed = has_feed;
        }
        self.line.kept.may_state.extend_from_slice(&self.line.text[end..]);
        self.line.text.truncate(end);
    }

    /// Writes the definition if another one is in force, and its execution at the hole.
    fn defined_cycle(&mut self, block: &CycleBlock, out: &mut Vec<u8>) {
        let [CycleArgument::Height(surface_mm), CycleArgument::Text(words)] = &block.cycle.arguments[..] else {
            return;
        };
        let definition = format!("{} {words}", block.cycle.name);
        if self.definition != definition {
            self.line.words_before(definition.as_bytes(), out);
            self.definition = definition;
            // The definition may leave its feed in force.
            self.feed = f64::NAN;
        }
        self.line.begin_motion();
        self.line.word(b"G79");
        let [abscissa, ordinate, along] = block.cycle.plane.axes();
        for axis in [abscissa, ordinate] {
            self.cycle_word(axis.letter(), block.position[axis.slot()]);
        }
        let surface = (surface_mm / self.increment_mm).round() as i64 + block.shift;
        self.cycle_word(along.letter(), surface);
        self.line.release();
        self.place = Some(block.position);
        self.motion = "";
    }

    fn cycle_word(&mut self, letter: u8, count: i64) {
        self.line.word(&[letter]);
        self.numbers.linear.push(&mut self.line.text, count);
    }

    /// Writes the end of the cycles, if one is in force.
    pub(super) fn end_cycle(&mut self, out: &mut Vec<u8>) {
        self.cycle = None;
        if std::mem::take(&mut self.is_drilling) {
            self.leave_motion(out);
            self.line.word(END.as_bytes());
            self.has_ended = true;
            self.motion = "";
        }
    }
}
