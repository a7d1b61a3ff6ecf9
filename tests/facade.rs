//! The library as a caller sees it: what may go to other threads, and that it is small.

use ncfix::prelude::*;

fn is_shared<T: Send + Sync>() {}

#[test]
fn what_holds_data_may_go_to_other_threads() {
    is_shared::<Machine>();
    is_shared::<Program>();
    is_shared::<Options>();
    is_shared::<Correction<'_>>();
    is_shared::<Diagnostics>();
    is_shared::<Error>();
}

#[test]
fn the_prelude_is_small() {
    let text = include_str!("../src/prelude.rs");
    let uses: String = text.lines().filter(|line| !line.starts_with("//")).collect();
    let names = uses.split(';').filter(|one| !one.trim().is_empty()).map(|one| one.matches(',').count() + 1);
    let count: usize = names.sum();
    assert!((20..=80).contains(&count), "{count} names");
}
