//! A new kernel every minute, passed to the cycle without a lock.
//!
//! Kernels form a chain in which each points to its successor. The cycle holds the active one and checks, with one atomic load, whether it has a
//! successor; then it moves on. The other side keeps every kernel until the cycle has released it, so that memory is freed there and never in the
//! cycle. Spaan's control loads new tables every 60 s (1995, ch. 6); the rate limit smooths the transition.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::kernel::Kernel;

/// Interval at which the other side checks whether the cycle has moved on.
const PUMP: Duration = Duration::from_millis(50);

#[derive(Debug)]
struct Node {
    kernel: Kernel,
    next: OnceLock<Arc<Node>>,
}

impl Node {
    fn new(kernel: Kernel) -> Arc<Node> {
        Arc::new(Node { kernel, next: OnceLock::new() })
    }
}

/// The side that creates kernels.
#[derive(Debug)]
pub struct Publisher {
    last: Arc<Node>,
    /// The previous one, until the cycle has released it.
    before: Option<Arc<Node>>,
    /// The latest one that is not passed on yet.
    waiting: Option<Kernel>,
}

/// The side of the cycle.
#[derive(Debug)]
pub struct Subscriber {
    current: Arc<Node>,
}

/// Both sides of a handover that begins with a kernel.
#[must_use]
pub fn handover(kernel: Kernel) -> (Publisher, Subscriber) {
    let node = Node::new(kernel);
    (Publisher { last: Arc::clone(&node), before: None, waiting: None }, Subscriber { current: node })
}

impl Publisher {
    /// Publishes a kernel. Until the cycle has taken the previous one, the newest waits; [`Self::pump`] passes it on later.
    pub fn publish(&mut self, kernel: Kernel) {
        self.waiting = Some(kernel);
        self.pump();
    }

    /// Frees kernels that the cycle has released, and passes on a waiting one. Returns `true` if none is waiting any more.
    pub fn pump(&mut self) -> bool {
        // Its only other owner is the cycle, until it moves on.
        self.before.take_if(|before| Arc::strong_count(before) == 1);
        if self.before.is_none()
            && let Some(kernel) = self.waiting.take()
        {
            let node = Node::new(kernel);
            // Only this side sets it, so it is empty.
            let _ = self.last.next.set(Arc::clone(&node));
            self.before = Some(std::mem::replace(&mut self.last, node));
        }
        self.waiting.is_none()
    }
}

impl Subscriber {
    /// The active kernel, and `true` if it is new. Without a publisher the active one stays, because releasing it would free it.
    pub(super) fn latest(&mut self) -> (&Kernel, bool) {
        let next = self.current.next.get().filter(|_| Arc::strong_count(&self.current) > 1).cloned();
        let is_new = next.is_some();
        if let Some(next) = next {
            self.current = next;
        }
        (&self.current.kernel, is_new)
    }
}

/// A thread that creates and publishes a kernel in every period.
#[derive(Debug)]
pub struct Updater {
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Updater {
    /// Starts the thread; if `make` returns nothing new, the active kernel stays. The first one is made after one period.
    #[must_use]
    pub fn start(
        mut publisher: Publisher,
        period: Duration,
        mut make: impl FnMut() -> Option<Kernel> + Send + 'static,
    ) -> Updater {
        let is_over = Arc::new(AtomicBool::new(false));
        let over = Arc::clone(&is_over);
        let thread = thread::spawn(move || {
            let mut due = Instant::now() + period;
            while !over.load(Ordering::Acquire) {
                let now = Instant::now();
                if now >= due {
                    due = now + period;
                    if let Some(kernel) = make() {
                        publisher.publish(kernel);
                    }
                }
                publisher.pump();
                thread::park_timeout(PUMP.min(due.saturating_duration_since(now)));
            }
        });
        Updater { is_over, thread: Some(thread) }
    }
}

impl Drop for Updater {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // A failed thread has reported its error itself.
            let _ = thread.join();
        }
    }
}
