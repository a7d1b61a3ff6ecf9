//! Grbl: what went out and was answered, held against what the control says of its buffers.
//!
//! Everything comes in the order in which the control says it: at a report, all answers that it had given were heard, and all bytes that had left before
//! the question had reached it. So of the bytes that are not answered its buffer has at most all, and at least all but one line, which it reads. Where
//! this does not hold an answer came twice, or some are missing: it was reset, or the line is disturbed.

use std::collections::VecDeque;

use super::status::GrblReport;

/// So many answers too many, until the control is asked next, do not make its buffer overflow.
pub(super) const SURPLUS: usize = 2;
/// A buffer of so many bytes is reported with one less by grblHAL, which keeps one place free.
const PLACE: usize = 1;
/// The control is asked so often without answers that must have come: some of these reports may be older than the question, where it reports by itself.
const MOST_DOUBTS: u32 = 5;

/// What a report says of the count of answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CountVerdict {
    /// It does not say what its buffers hold.
    Silent,
    Fits,
    /// Answers are missing, perhaps: nothing more goes out before it is known.
    Doubt,
    Missing,
    Surplus,
}

/// Bytes and lines that went out and were answered.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Free bytes of an empty buffer: the most that was told.
    bytes: usize,
    /// Bytes of lines that went out, or are to, and of those that were answered.
    sent: u64,
    answered: u64,
    /// Bytes that were gone when the control was asked last.
    gone: u64,
    /// The same of the question before.
    gone_before: u64,
    doubts: u32,
    /// Lines that went out and were not seen to have been taken, and the byte behind each.
    lines: VecDeque<(u64, u64)>,
    /// The last line that has left its buffer: it may wait before the planner; and the one before it, which does not.
    read: u64,
    taken: u64,
}

impl Counts {
    /// What `[OPT:…]` says of the receive buffer, bytes.
    pub(super) fn has(&mut self, bytes: usize) {
        self.bytes = self.bytes.max(bytes.saturating_sub(PLACE));
    }

    pub(super) fn sent(&mut self, number: u64, bytes: usize) {
        self.sent += bytes as u64;
        self.lines.push_back((number, self.sent));
    }

    pub(super) fn answered(&mut self, bytes: usize) {
        self.answered += bytes as u64;
    }

    /// The control is asked; so many bytes of lines have not left.
    pub(super) fn ask(&mut self, waiting: usize) {
        self.gone_before = self.gone;
        self.gone = self.sent.saturating_sub(waiting as u64);
    }

    /// What is free in an empty buffer is the most that was ever free.
    pub(super) fn see(&mut self, status: &GrblReport) {
        self.bytes = self.bytes.max(status.free_bytes.unwrap_or(0));
    }

    /// Whether it has said how large its buffer is.
    pub(super) fn is_size_known(&self) -> bool {
        self.bytes > 0
    }

    /// Whether nothing is in the receive buffer, as far as it says so.
    pub(super) fn is_empty(&self, status: &GrblReport) -> Option<bool> {
        status.free_bytes.map(|free| free >= self.bytes)
    }

    /// Holds a report against the count. `longest` is that of the lines under way, `waiting` bytes have not left.
    pub(super) fn judge(
        &mut self,
        status: &GrblReport,
        is_asked: bool,
        longest: usize,
        waiting: usize,
    ) -> CountVerdict {
        let Some(free) = status.free_bytes else { return CountVerdict::Silent };
        let used = self.bytes.saturating_sub(free) as u64;
        let open = self.sent.saturating_sub(self.answered);
        if used > open.saturating_sub(waiting as u64) + PLACE as u64 {
            return CountVerdict::Surplus;
        }
        if !is_asked {
            return if self.doubts > 0 { CountVerdict::Doubt } else { CountVerdict::Fits };
        }
        let due = self.gone.saturating_sub(self.answered);
        if due > used + (longest + PLACE) as u64 {
            self.doubts += 1;
            return if self.doubts >= MOST_DOUBTS { CountVerdict::Missing } else { CountVerdict::Doubt };
        }
        self.doubts = 0;
        CountVerdict::Fits
    }

    /// The last line that was taken for sure, by what its buffer holds: not by the count of answers, one of which may have come twice. A report may be
    /// older than the question, but not than the one before that.
    pub(super) fn taken(&mut self, status: &GrblReport) -> u64 {
        let Some(free) = status.free_bytes else { return self.taken };
        let out = self.gone_before.saturating_sub((self.bytes.saturating_sub(free) + PLACE) as u64);
        while let Some(&(number, end)) = self.lines.front()
            && end <= out
        {
            self.lines.pop_front();
            self.taken = self.read;
            self.read = self.read.max(number);
        }
        self.taken
    }

    /// Whether answers are missing, perhaps.
    pub(super) fn is_in_doubt(&self) -> bool {
        self.doubts > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::dialogue::grbl::status::GrblState;

    fn report(free_bytes: usize) -> GrblReport {
        GrblReport { word: GrblState::Run, free_blocks: None, free_bytes: Some(free_bytes) }
    }

    #[test]
    fn what_was_taken_is_what_has_left_the_buffer_whatever_was_answered() {
        let mut counts = Counts::default();
        counts.see(&report(128));
        (1..=5).for_each(|number| counts.sent(number, 10));
        counts.ask(0);
        // A report may be older than the question.
        assert_eq!(counts.taken(&report(128)), 0);
        counts.ask(0);
        // 12 of 50 bytes wait, one place may be kept free: 37 have been read, three lines; the last of these may wait before the planner.
        assert_eq!(counts.taken(&report(116)), 2);
        assert_eq!(counts.taken(&report(128)), 3);
        // Bytes that have not left count for nothing.
        (6..=9).for_each(|number| counts.sent(number, 10));
        counts.ask(35);
        counts.ask(0);
        assert_eq!(counts.taken(&report(128)), 4);
        assert_eq!(counts.taken(&GrblReport { free_bytes: None, ..report(0) }), 4);
    }
}
