//! Passes a stream from one thread to another in batches and in order: the result does not depend on the speed of either side.
//!
//! Batches go back empty to be filled again, so that a long stream allocates no more than a short one, and the faster side waits for the
//! slower one, so that memory is bounded.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// Items of a batch: small enough that a batch stays in the cache of a core, large enough that the cost of passing it is negligible.
const BATCH: usize = 1024;
/// Batches that may wait.
const AHEAD: usize = 4;

/// Sender: collects items into batches.
pub(crate) struct BatchSender<T> {
    full: SyncSender<VecDeque<T>>,
    empty: Receiver<VecDeque<T>>,
    batch: VecDeque<T>,
}

/// Receiver: an iterator that ends when the sender was dropped.
pub(crate) struct BatchReceiver<T> {
    full: Receiver<VecDeque<T>>,
    empty: SyncSender<VecDeque<T>>,
    batch: VecDeque<T>,
}

/// Both sides of a channel.
pub(crate) fn channel<T>() -> (BatchSender<T>, BatchReceiver<T>) {
    let (full_in, full_out) = sync_channel(AHEAD);
    // Room for all batches, so that returning one never waits.
    let (empty_in, empty_out) = sync_channel(AHEAD + 2);
    let sender = BatchSender { full: full_in, empty: empty_out, batch: VecDeque::with_capacity(BATCH) };
    (sender, BatchReceiver { full: full_out, empty: empty_in, batch: VecDeque::new() })
}

impl<T> BatchSender<T> {
    /// Passes an item; `false` if the receiver has closed.
    pub(crate) fn put(&mut self, item: T) -> bool {
        self.batch.push_back(item);
        self.batch.len() < BATCH || self.hand_on()
    }

    fn hand_on(&mut self) -> bool {
        let next = self.empty.try_recv().unwrap_or_else(|_| VecDeque::with_capacity(BATCH));
        self.full.send(std::mem::replace(&mut self.batch, next)).is_ok()
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

impl<T> Iterator for BatchReceiver<T> {
    type Item = T;

    #[inline]
    fn next(&mut self) -> Option<T> {
        loop {
            if let Some(item) = self.batch.pop_front() {
                return Some(item);
            }
            let next = self.full.recv().ok()?;
            // A sender that has ended needs no empty batches.
            let _ = self.empty.try_send(std::mem::replace(&mut self.batch, next));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_comes_out_once_and_in_order() {
        for count in [0, 1, BATCH - 1, BATCH, BATCH + 1, 40 * BATCH + 7] {
            let (sender, receiver) = channel();
            let all: Vec<usize> = std::thread::scope(|scope| {
                scope.spawn(move || sender.put_all(0..count));
                receiver.collect()
            });
            assert!(all.into_iter().eq(0..count), "{count}");
        }
    }

    #[test]
    fn a_stream_without_end_stops_when_nobody_takes() {
        let (sender, receiver) = channel();
        let first: Vec<u64> = std::thread::scope(|scope| {
            scope.spawn(move || sender.put_all(0..));
            receiver.take(1000).collect()
        });
        assert_eq!(first.last(), Some(&999));
    }

    #[test]
    fn no_more_parts_are_made_than_may_wait() {
        let (mut sender, mut receiver) = channel();
        // The receiver keeps pace: batches are used again.
        for k in 0..100 * BATCH {
            assert!(sender.put(k));
            if sender.batch.is_empty() {
                assert!((0..BATCH).all(|_| receiver.next().is_some()));
            }
        }
        assert!(sender.batch.capacity() < 2 * BATCH);
    }
}
