//! LinuxCNC's state of the running loops.

use std::collections::HashMap;

/// LinuxCNC's state of its loops, common to all of them.
///
/// A `break` stays pending until the end of a `do` loop, which then ends. This includes a `break` that LinuxCNC only passes on its way to the end of
/// its loop, after a condition or a `continue`, as it evaluates the labels it passes. A `continue` in a `do` loop stays pending until the end of
/// another loop, which then restarts. A `repeat` left by a `return` continues with its remaining passes.
#[derive(Debug, Default)]
pub(super) struct Passes {
    pub(super) breaks: bool,
    pub(super) continues: bool,
    /// Remaining passes, by program and block of the `repeat`.
    left: HashMap<(usize, usize), u32>,
}

impl Passes {
    /// `true` if the pass of a `repeat` that begins here is executed.
    pub(super) fn repeat(&mut self, place: (usize, usize), count: u32) -> bool {
        let left = self.left.remove(&place).unwrap_or(count);
        let left = if left == 0 && std::mem::take(&mut self.continues) { count } else { left };
        if left > 0 {
            self.left.insert(place, left - 1);
        }
        left > 0
    }
}
