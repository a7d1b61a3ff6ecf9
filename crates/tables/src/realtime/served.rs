//! Serves the rings in shared memory until the control, the operator or an error ends it.

use std::time::{Duration, Instant};

use super::counted::CycleCounts;
use super::cycle::Cycle;
use super::ring::{Overrun, Ring, RingOrder};

/// Number of polls of an empty ring before the thread sleeps, and the sleep time.
const LOOKS: u32 = 2000;
const REST: Duration = Duration::from_micros(50);

/// Reason of the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ServingEnd {
    /// The control ended it.
    Control,
    /// The operator ended it.
    Stopped,
    /// The control overran a ring.
    Overrun(Overrun),
    /// An order that needs another kernel: serve again when it is in the cycle.
    Order(RingOrder),
    /// There is no kernel for the tool, or with the head.
    NoKernel,
}

/// Answers the set-points of a ring until the control ends it, a ring is overrun, or `is_over` returns `true`.
pub fn serve(ring: &Ring, cycle: &mut Cycle, counts: &mut CycleCounts, is_over: impl Fn() -> bool) -> ServingEnd {
    let mut looks = 0;
    loop {
        let start = Instant::now();
        let served = match ring.serve(cycle) {
            Ok(served) => served,
            Err(overrun) => return ServingEnd::Overrun(overrun),
        };
        if let Some(signals) = served {
            counts.note(signals, start.elapsed());
            looks = 0;
            continue;
        }
        if let Some(order) = ring.order() {
            return ServingEnd::Order(order);
        }
        if ring.beat() {
            return ServingEnd::Control;
        }
        if is_over() {
            return ServingEnd::Stopped;
        }
        looks += 1;
        if looks < LOOKS { std::hint::spin_loop() } else { std::thread::sleep(REST) }
    }
}
