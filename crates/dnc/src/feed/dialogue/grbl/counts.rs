//! Grbl: compares the sent and answered bytes with the buffer state that the control reports.
//!
//! Everything arrives in the order in which the control says it. When a report arrives, all earlier answers have been heard. All bytes that had left before
//! the question have reached the control. So its buffer holds at most all unanswered bytes, and at least all but one line, which it is reading. If this does
//! not hold, an answer came twice or answers are missing: the control was reset, or the line is disturbed.

use std::collections::VecDeque;

use super::status::GrblReport;

/// Number of surplus answers until the next report that do not make the buffer overflow.
pub(super) const SURPLUS: usize = 2;
/// grblHAL reports a buffer one byte smaller, because it keeps one place free.
const PLACE: usize = 1;
/// Number of questions while due answers are missing. Some of the reports may be older than the question, if the control also reports unasked.
const MOST_DOUBTS: u32 = 5;

/// Verdict of a report on the count of answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CountVerdict {
    /// The report does not contain the buffer state.
    Silent,
    Fits,
    /// Answers may be missing: nothing more is sent until this is clear.
    Doubt,
    Missing,
    Surplus,
}

/// Bytes and lines that were sent and answered.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Free bytes of an empty buffer: the largest number reported.
    bytes: usize,
    /// Free places of an empty planner: the largest number reported.
    blocks: usize,
    /// Bytes of lines that were sent or queued, and bytes of those that were answered.
    sent: u64,
    answered: u64,
    /// Bytes that had left when the control was last asked.
    gone: u64,
    /// Bytes that had left at the question before.
    gone_before: u64,
    doubts: u32,
    /// Lines that were sent and not yet known to be taken, each with the position of its end in bytes.
    lines: VecDeque<(u64, u64)>,
    /// Last line that has left the buffer, which may still wait before the planner; and the line before it, which does not.
    read: u64,
    taken: u64,
}

impl Counts {
    /// Notes the size of the receive buffer from `[OPT:…]`, bytes.
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

    /// Notes that the control is asked. `waiting` bytes of lines have not left.
    pub(super) fn ask(&mut self, waiting: usize) {
        self.gone_before = self.gone;
        self.gone = self.sent.saturating_sub(waiting as u64);
    }

    /// Notes the free bytes; the largest number ever free is the size of the buffer.
    pub(super) fn see(&mut self, status: &GrblReport<'_>) {
        self.bytes = self.bytes.max(status.free_bytes.unwrap_or(0));
        self.blocks = self.blocks.max(status.free_blocks.unwrap_or(0));
    }

    /// False if blocks wait in the planner; true if the report does not say.
    pub(super) fn has_no_block(&self, status: &GrblReport<'_>) -> bool {
        status.free_blocks.is_none_or(|free| free >= self.blocks)
    }

    /// True if the size of the buffer is known.
    pub(super) fn is_size_known(&self) -> bool {
        self.bytes > 0
    }

    /// True if the receive buffer is empty; `None` if the report does not say.
    pub(super) fn is_empty(&self, status: &GrblReport<'_>) -> Option<bool> {
        status.free_bytes.map(|free| free >= self.bytes)
    }

    /// Compares a report with the count. `longest` is the longest line under way, bytes; `waiting` bytes have not left.
    pub(super) fn judge(
        &mut self,
        status: &GrblReport<'_>,
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

    /// Returns the last line that was certainly taken. It follows from the buffer state, not from the count of answers, one of which may have come twice. A
    /// report may be older than the last question, but not than the one before that.
    pub(super) fn taken(&mut self, status: &GrblReport<'_>) -> u64 {
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

    /// True if answers may be missing.
    pub(super) fn is_in_doubt(&self) -> bool {
        self.doubts > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(free_bytes: usize) -> GrblReport<'static> {
        GrblReport { free_bytes: Some(free_bytes), ..GrblReport::read("<Run>").unwrap() }
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
        // 12 of 50 bytes wait, and one place may be kept free. So 37 have been read: three lines, the last of which may wait before the planner.
        assert_eq!(counts.taken(&report(116)), 2);
        assert_eq!(counts.taken(&report(128)), 3);
        // Bytes that have not left do not count.
        (6..=9).for_each(|number| counts.sent(number, 10));
        counts.ask(35);
        counts.ask(0);
        assert_eq!(counts.taken(&report(128)), 4);
        assert_eq!(counts.taken(&GrblReport { free_bytes: None, ..report(0) }), 4);
    }
}
