//! What LinuxCNC remembers of the loops that it runs through.

use std::collections::HashMap;

/// What LinuxCNC remembers of its loops, all of which share it.
///
/// A `break` is not forgotten until the end of a `do` loop, which then ends; neither is one that LinuxCNC only passes on its way to the
/// end of the loop that it belongs to, because a condition or a `continue` leads there: it looks at the labels of what it passes. A
/// `continue` in a `do` loop is not forgotten until the end of another loop, which then begins anew; and a `repeat` that a `return`
/// leaves goes on with the passes that were left.
#[derive(Debug, Default)]
pub(super) struct Passes {
    pub(super) breaks: bool,
    pub(super) continues: bool,
    /// Passes that are left, by program and block of the `repeat`.
    left: HashMap<(usize, usize), u32>,
}

impl Passes {
    /// Whether the pass of a `repeat` that begins here is made.
    pub(super) fn repeat(&mut self, place: (usize, usize), count: u32) -> bool {
        let left = self.left.remove(&place).unwrap_or(count);
        let left = if left == 0 && std::mem::take(&mut self.continues) { count } else { left };
        if left > 0 {
            self.left.insert(place, left - 1);
        }
        left > 0
    }
}
