//! Passes a stream from one thread to another in parts and in order: the result does not depend on the speed of either side.
//!
//! Parts go back empty to be filled again, so that a long stream allocates no more than a short one, and the faster side waits for the
//! slower one, so that memory is bounded.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// Items of a part: small enough that a part stays in the cache of a core, large enough that the cost of passing it is negligible.
const PART: usize = 1024;
/// Parts that may wait.
const AHEAD: usize = 4;

/// Sender: collects items into parts.
pub(crate) struct Filler<T> {
    full: SyncSender<VecDeque<T>>,
    empty: Receiver<VecDeque<T>>,
    part: VecDeque<T>,
}

/// Receiver: an iterator that ends when the sender was dropped.
pub(crate) struct Taker<T> {
    full: Receiver<VecDeque<T>>,
    empty: SyncSender<VecDeque<T>>,
    part: VecDeque<T>,
}

/// Both sides of a channel.
pub(crate) fn channel<T>() -> (Filler<T>, Taker<T>) {
    let (full_in, full_out) = sync_channel(AHEAD);
    // Room for all parts, so that returning one never waits.
    let (empty_in, empty_out) = sync_channel(AHEAD + 2);
    let filler = Filler { full: full_in, empty: empty_out, part: VecDeque::with_capacity(PART) };
    (filler, Taker { full: full_out, empty: empty_in, part: VecDeque::new() })
}

impl<T> Filler<T> {
    /// Passes an item; `false` if the receiver has closed.
    pub(crate) fn put(&mut self, item: T) -> bool {
        self.part.push_back(item);
        self.part.len() < PART || self.hand_on()
    }

    fn hand_on(&mut self) -> bool {
        let next = self.empty.try_recv().unwrap_or_else(|_| VecDeque::with_capacity(PART));
        self.full.send(std::mem::replace(&mut self.part, next)).is_ok()
    }

    /// Passes a whole stream, or as much of it as the receiver takes.
    pub(crate) fn put_all(mut self, stream: impl IntoIterator<Item = T>) {
        for item in stream {
            if !self.put(item) {
                return;
            }
        }
        // The receiver may be closed: then it needs no further items.
        let _ = self.hand_on();
    }
}

impl<T> Iterator for Taker<T> {
    type Item = T;

    #[inline]
    fn next(&mut self) -> Option<T> {
        loop {
            if let Some(item) = self.part.pop_front() {
                return Some(item);
            }
            let next = self.full.recv().ok()?;
            // A sender that has ended needs no empty parts.
            let _ = self.empty.try_send(std::mem::replace(&mut self.part, next));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_comes_out_once_and_in_order() {
        for count in [0, 1, PART - 1, PART, PART + 1, 40 * PART + 7] {
            let (filler, taker) = channel();
            let all: Vec<usize> = std::thread::scope(|scope| {
                scope.spawn(move || filler.put_all(0..count));
                taker.collect()
            });
            assert!(all.into_iter().eq(0..count), "{count}");
        }
    }

    #[test]
    fn a_stream_without_end_stops_when_nobody_takes() {
        let (filler, taker) = channel();
        let first: Vec<u64> = std::thread::scope(|scope| {
            scope.spawn(move || filler.put_all(0..));
            taker.take(1000).collect()
        });
        assert_eq!(first.last(), Some(&999));
    }

    #[test]
    fn no_more_parts_are_made_than_may_wait() {
        let (mut filler, mut taker) = channel();
        // The taker keeps pace: parts are used again.
        for k in 0..100 * PART {
            assert!(filler.put(k));
            if filler.part.is_empty() {
                assert!((0..PART).all(|_| taker.next().is_some()));
            }
        }
        assert!(filler.part.capacity() < 2 * PART);
    }
}
