//! Holes that stay a drilling cycle: CYCLE81 to CYCLE89, CYCLE840.

use super::Sinumerik;
use crate::path::CycleBlock;
use ncfix_base::geometry::Axis;
use ncfix_machine::snc::{CycleArgument, HoleTrigger};

/// The modal call, without a name its end.
pub(super) const MODAL: &str = "MCALL";

impl Sinumerik {
    /// Writes a hole: the call, or the position that triggers the modal call.
    pub(super) fn cycle(&mut self, block: &CycleBlock, out: &mut Vec<u8>) {
        let call = self.call_of(block);
        if block.cycle.trigger == HoleTrigger::Call {
            if self.needs_cycle_feed(block) {
                self.feed_word(block.feed);
                self.line.end(out);
            }
            self.word(&call);
            return;
        }
        if self.modal_call != call {
            let mut text = std::mem::take(&mut self.bare_block);
            if !text.is_empty() {
                text.push(b' ');
            }
            text.extend_from_slice(&[MODAL.as_bytes(), b" ", &call].concat());
            self.line.words_before(&text, out);
            self.modal_call = call;
        }
        self.end_bare_block(out);
        self.line.begin_motion();
        if self.motion != "G0" {
            self.word(b"G0");
            self.motion = "G0";
        }
        for axis in block.words.iter() {
            self.place_word(block, axis);
        }
        if self.needs_cycle_feed(block) {
            self.feed_word(block.feed);
        }
        self.line.release();
        // The program may state coordinates again that do not change.
        let end = self.line.text.len();
        let [abscissa, ordinate, _] = block.cycle.plane.axes();
        self.word(b"G0");
        self.place_word(block, abscissa);
        self.place_word(block, ordinate);
        self.line.kept.may_state.extend_from_slice(&self.line.text[end..]);
        self.line.text.truncate(end);
    }

    /// Appends a coordinate of a hole.
    fn place_word(&mut self, block: &CycleBlock, axis: Axis) {
        self.word(b"");
        if self.axis_name(axis) {
            self.line.text.push(b'=');
        }
        self.numbers.linear.push(&mut self.line.text, block.position[axis.slot()]);
    }

    /// Holds back the line under construction if it is only a number: the next modal call may belong to it. A number before any other line is written.
    pub(super) fn set_bare_block_aside(&mut self, out: &mut Vec<u8>) {
        if !self.line.is_open() {
            return;
        }
        self.end_bare_block(out);
        if !self.line.has_words() && !self.line.has_comment() && !self.line.text.is_empty() {
            std::mem::swap(&mut self.bare_block, &mut self.line.text);
        }
    }

    /// Writes the number that was held back as its own line.
    pub(super) fn end_bare_block(&mut self, out: &mut Vec<u8>) {
        if !self.bare_block.is_empty() {
            self.line.header(&self.bare_block, out);
            self.bare_block.clear();
        }
    }

    /// `true` if the feed of a hole must be written.
    fn needs_cycle_feed(&self, block: &CycleBlock) -> bool {
        block.feed > 0.0 && block.feed != self.feed
    }

    /// The call with its arguments.
    fn call_of(&self, block: &CycleBlock) -> Vec<u8> {
        let mut text = block.cycle.name.clone().into_bytes();
        text.push(b'(');
        for (place, argument) in block.cycle.arguments.iter().enumerate() {
            if place > 0 {
                text.push(b',');
            }
            match argument {
                CycleArgument::Height(height_mm) => {
                    let count = (height_mm / self.increment_mm).round() as i64 + block.shift;
                    self.numbers.linear.push(&mut text, count);
                }
                CycleArgument::Text(argument) => text.extend_from_slice(argument.as_bytes()),
            }
        }
        text.push(b')');
        text
    }

    /// Ends the modal call before the line under construction, if there is one.
    pub(super) fn end_modal_call(&mut self, out: &mut Vec<u8>) {
        if !self.modal_call.is_empty() {
            self.modal_call.clear();
            self.line.words_before(MODAL.as_bytes(), out);
        }
    }
}
