//! Bytes to be sent: those of lines in order, and urgent ones that overtake them.

use std::collections::VecDeque;

/// Bytes on their way to a port.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wire {
    urgent: VecDeque<u8>,
    plain: VecDeque<u8>,
    /// Bytes of both queues that the port has taken.
    sent: u64,
    /// Taken bytes that wait in the queue of the operating system.
    queued: usize,
    is_paused: bool,
}

impl Wire {
    /// Appends bytes after all others.
    pub fn push(&mut self, bytes: &[u8]) {
        self.plain.extend(bytes);
    }

    /// Adds bytes before those of lines. No pause holds them back: answers, a hold.
    pub fn push_urgent(&mut self, bytes: &[u8]) {
        self.urgent.extend(bytes);
    }

    /// Holds back the bytes of lines, or resumes them.
    pub fn pause(&mut self, is_paused: bool) {
        self.is_paused = is_paused;
    }

    /// True if bytes of lines are held back.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.is_paused
    }

    /// Returns the next bytes, at most `most`.
    #[must_use]
    pub fn next(&self, most: usize) -> &[u8] {
        let queue = if !self.urgent.is_empty() {
            &self.urgent
        } else if self.is_paused {
            return &[];
        } else {
            &self.plain
        };
        // Bytes beyond the wrap of the ring buffer follow next time.
        let (first, _) = queue.as_slices();
        first.get(..most.min(first.len())).unwrap_or_default()
    }

    /// Notes that the port has taken `count` bytes of [`Wire::next`].
    pub fn took(&mut self, count: usize) {
        let queue = if self.urgent.is_empty() { &mut self.plain } else { &mut self.urgent };
        let count = count.min(queue.len());
        queue.drain(..count);
        self.sent += count as u64;
        // Until the system reports otherwise.
        self.queued += count;
    }

    /// Returns the number of bytes of lines that the port has not taken.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.plain.len()
    }

    /// True if the port has taken everything.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.plain.is_empty() && self.urgent.is_empty()
    }

    /// Discards the bytes that the port has not taken. Returns the number of these that belong to lines.
    pub fn clear(&mut self) -> usize {
        let count = self.plain.len();
        self.plain.clear();
        self.urgent.clear();
        count
    }

    /// Discards the bytes of lines that the port has not taken; urgent bytes are still sent.
    pub fn withdraw(&mut self) {
        self.plain.clear();
    }

    /// Returns the number of bytes that the port has taken so far.
    #[must_use]
    pub fn sent(&self) -> u64 {
        self.sent
    }

    /// Notes the number of taken bytes that wait in the queue of the operating system.
    pub fn queue(&mut self, count: usize) {
        self.queued = count;
    }

    /// Returns the number of bytes in the queue of the operating system: its last report plus the bytes taken since.
    #[must_use]
    pub fn queued(&self) -> usize {
        self.queued
    }

    /// Returns the number of bytes that have left the queue of the operating system, as far as it reports.
    #[must_use]
    pub fn left(&self) -> u64 {
        self.sent.saturating_sub(self.queued as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn urgent_bytes_overtake_and_no_pause_holds_them_back() {
        let mut wire = Wire::default();
        wire.push(b"G1 X1\n");
        wire.took(2);
        wire.pause(true);
        assert_eq!(wire.next(99), b"");
        wire.push_urgent(b"!");
        assert_eq!(wire.next(99), b"!");
        wire.took(1);
        wire.pause(false);
        assert_eq!(wire.next(3), b" X1");
        assert_eq!((wire.waiting(), wire.sent()), (4, 3));
        wire.queue(2);
        assert_eq!(wire.left(), 1);
    }
}
