//! Parallel work on all cores, with results that do not depend on the number of cores.

use std::sync::mpsc;
use std::thread;

use rayon::prelude::*;

/// Processes all items in parallel; the results are in their order.
///
/// # Panics
/// If the work panics.
#[must_use]
pub fn in_parts<T: Sync, R: Send>(all: &[T], work: &(dyn Fn(&T) -> R + Sync)) -> Vec<R> {
    all.par_iter().map(work).collect()
}

/// Runs both in parallel.
///
/// # Panics
/// If one of them panics.
pub fn both<A: Send, B: Send>(one: impl FnOnce() -> A + Send, other: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(one, other)
}

/// Processes the numbers below `count` in parallel; the results are in their order. `progress` gets the number of completed ones, in the thread of the
/// caller.
///
/// # Panics
/// If the work panics.
#[must_use]
pub fn repeated<R: Send>(count: usize, work: &(dyn Fn(usize) -> R + Sync), progress: &mut dyn FnMut(u64)) -> Vec<R> {
    let (sender, results) = mpsc::channel();
    let mut found: Vec<(usize, R)> = thread::scope(|scope| {
        scope.spawn(move || {
            // The receiver waits until the last sender is dropped.
            (0..count).into_par_iter().for_each_with(sender, |sender, number| {
                let _ = sender.send((number, work(number)));
            });
        });
        (1..).zip(results).inspect(|&(done, _)| progress(done)).map(|(_, result)| result).collect()
    });
    found.sort_by_key(|&(number, _)| number);
    found.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_work() {
        let all: Vec<u64> = (0..1000).collect();
        let squares: Vec<u64> = (0..1000).map(|number| number * number).collect();
        assert_eq!(in_parts(&all, &|number| number * number), squares);
        let mut told = Vec::new();
        assert_eq!(repeated(1000, &|number| (number * number) as u64, &mut |done| told.push(done)), squares);
        assert_eq!(told, (1..=1000).collect::<Vec<u64>>());
        assert_eq!(both(|| 1, || "two"), (1, "two"));
        assert_eq!(in_parts(&[0_u8; 0], &|byte| *byte), Vec::<u8>::new());
    }

    #[test]
    #[should_panic(expected = "a scoped thread panicked")]
    fn a_panic_of_the_work_is_one_of_the_caller() {
        let _ = repeated(8, &|number| assert!(number != 5), &mut |_| {});
    }
}
