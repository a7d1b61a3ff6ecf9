//! Work that is done by both cores of a small computer.

use std::panic::resume_unwind;

/// Shares of the work.
const WORKERS: usize = 2;

/// Works on all of them at once; what comes out is in their order.
///
/// # Panics
/// Where the work does.
#[must_use]
pub fn in_parts<T: Sync, R: Send>(all: &[T], work: &(dyn Fn(&T) -> R + Sync)) -> Vec<R> {
    if all.len() < 2 {
        return all.iter().map(work).collect();
    }
    let share = all.len().div_ceil(4 * WORKERS).max(1);
    let parts: Vec<&[T]> = all.chunks(share).collect();
    std::thread::scope(|scope| {
        // Parts are dealt out in turn: neighbours cost alike.
        let deal = |worker: usize| parts.iter().enumerate().skip(worker).step_by(WORKERS);
        let workers: Vec<_> = (0..WORKERS)
            .map(|worker| {
                let own: Vec<(usize, &[T])> = deal(worker).map(|(place, part)| (place, *part)).collect();
                scope.spawn(move || {
                    let one = |(place, part): (usize, &[T])| (place, part.iter().map(work).collect::<Vec<R>>());
                    own.into_iter().map(one).collect::<Vec<_>>()
                })
            })
            .collect();
        let mut done: Vec<(usize, Vec<R>)> =
            workers.into_iter().flat_map(|worker| worker.join().unwrap_or_else(|fault| resume_unwind(fault))).collect();
        done.sort_by_key(|(place, _)| *place);
        done.into_iter().flat_map(|(_, part)| part).collect()
    })
}
