//! Serves the rings in shared memory until the control, a person or a fault ends it.

use std::time::{Duration, Instant};

use super::counted::CycleCounts;
use super::cycle::Cycle;
use super::ring::{Overrun, Ring};

/// Looks at an empty ring before the thread rests, and for how long it does.
const LOOKS: u32 = 2000;
const REST: Duration = Duration::from_micros(50);

/// How serving ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServingEnd {
    /// The control ended it.
    Control,
    /// It was told to end.
    Told,
    /// The control went over the end of a ring.
    Overrun(Overrun),
}

/// Answers the set-points of a ring until the control ends it, it goes over the end of a ring, or `is_over` says so.
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
        if ring.beat() {
            return ServingEnd::Control;
        }
        if is_over() {
            return ServingEnd::Told;
        }
        looks += 1;
        if looks < LOOKS { std::hint::spin_loop() } else { std::thread::sleep(REST) }
    }
}
