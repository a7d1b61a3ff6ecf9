//! Work that all cores share, with results that do not depend on how many there are.

use std::sync::mpsc;
use std::thread;

use rayon::prelude::*;

/// Works on all of them at once; the results are in their order.
///
/// # Panics
/// Where the work does.
#[must_use]
pub fn in_parts<T: Sync, R: Send>(all: &[T], work: &(dyn Fn(&T) -> R + Sync)) -> Vec<R> {
    all.par_iter().map(work).collect()
}

/// Does both at once.
///
/// # Panics
/// Where one of them does.
pub fn both<A: Send, B: Send>(one: impl FnOnce() -> A + Send, other: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(one, other)
}

/// Works on the numbers below `count` at once; the results are in their order. `progress` is told in the thread of the caller how many are done.
///
/// # Panics
/// Where the work does.
#[must_use]
pub fn repeated<R: Send>(count: usize, work: &(dyn Fn(usize) -> R + Sync), progress: &mut dyn FnMut(u64)) -> Vec<R> {
    let (sender, results) = mpsc::channel();
    let mut found: Vec<(usize, R)> = thread::scope(|scope| {
        scope.spawn(move || {
            // The receiver waits until the last sender is gone.
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
