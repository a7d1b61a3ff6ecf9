//! What is to be sent: bytes of lines in order, and bytes that overtake them.

use std::collections::VecDeque;

/// Bytes on their way to a port.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wire {
    urgent: VecDeque<u8>,
    plain: VecDeque<u8>,
    /// Bytes that the port has taken, of both.
    sent: u64,
    /// Bytes of these that wait in the queue of the system.
    queued: usize,
    is_paused: bool,
}

impl Wire {
    /// Bytes behind all others.
    pub fn push(&mut self, bytes: &[u8]) {
        self.plain.extend(bytes);
    }

    /// Bytes before all others, which no pause holds back: answers, a hold.
    pub fn push_urgent(&mut self, bytes: &[u8]) {
        self.urgent.extend(bytes);
    }

    /// Holds the bytes of lines back, or lets them go on.
    pub fn pause(&mut self, is_paused: bool) {
        self.is_paused = is_paused;
    }

    /// Whether bytes of lines are held back.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.is_paused
    }

    /// What goes next, at most so many bytes.
    #[must_use]
    pub fn next(&self, most: usize) -> &[u8] {
        let queue = if !self.urgent.is_empty() {
            &self.urgent
        } else if self.is_paused {
            return &[];
        } else {
            &self.plain
        };
        // What lies behind the turn of the ring goes next time.
        let (first, _) = queue.as_slices();
        first.get(..most.min(first.len())).unwrap_or_default()
    }

    /// Notes that the port has taken so many bytes of [`Wire::next`].
    pub fn took(&mut self, count: usize) {
        let queue = if self.urgent.is_empty() { &mut self.plain } else { &mut self.urgent };
        let count = count.min(queue.len());
        queue.drain(..count);
        self.sent += count as u64;
        // Until the system says otherwise.
        self.queued += count;
    }

    /// Bytes of lines that the port has not taken.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.plain.len()
    }

    /// Whether the port has taken everything.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.plain.is_empty() && self.urgent.is_empty()
    }

    /// Throws away what the port has not taken. Returns how many bytes of lines that were.
    pub fn clear(&mut self) -> usize {
        let count = self.plain.len();
        self.plain.clear();
        self.urgent.clear();
        count
    }

    /// Throws away the bytes of lines that the port has not taken; what overtakes them still goes out.
    pub fn withdraw(&mut self) {
        self.plain.clear();
    }

    /// Bytes that the port has taken so far.
    #[must_use]
    pub fn sent(&self) -> u64 {
        self.sent
    }

    /// Notes how many of the bytes that the port has taken wait in the queue of the system.
    pub fn queue(&mut self, count: usize) {
        self.queued = count;
    }

    /// Bytes that wait in the queue of the system: what it said, and what it has taken since.
    #[must_use]
    pub fn queued(&self) -> usize {
        self.queued
    }

    /// Bytes that have left the queue of the system, as far as it tells of it.
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
