//! The contour stage: holds motions back until what follows them is known.
//!
//! Motions that nothing changes pass through at once. While one is held, the elements behind it wait with it, so that the order of the
//! stream stays that of the program.

use std::collections::VecDeque;

use super::fault::Fault;
use super::path::Path;
use crate::snc::Element;

/// What waits in the stage, and what leaves it.
#[derive(Debug)]
pub(super) enum Item {
    /// Anything without motion.
    Element(Element),
    /// A motion, and the element that it becomes: its origin, number and place in the block. Its kind is a placeholder.
    Path(Box<Path>, Element),
}

/// The stage.
#[derive(Debug, Default)]
pub(super) struct Contour {
    held: VecDeque<Item>,
}

impl Contour {
    /// Whether something is held, so that whatever comes must wait behind it.
    pub(super) fn is_holding(&self) -> bool {
        !self.held.is_empty()
    }

    /// Whether a motion must go through the stage.
    pub(super) fn wants(&self, _path: &Path) -> bool {
        self.is_holding()
    }

    /// Takes an item and gives those that are final now.
    ///
    /// # Errors
    /// Where the contour cannot be followed.
    pub(super) fn take(&mut self, item: Item, out: &mut Vec<Item>) -> Result<(), Fault> {
        self.held.push_back(item);
        self.finish(out)
    }

    /// Gives everything that is held: the program has ended, or must wait here.
    ///
    /// # Errors
    /// Where the contour cannot be followed.
    pub(super) fn finish(&mut self, out: &mut Vec<Item>) -> Result<(), Fault> {
        out.extend(self.held.drain(..));
        Ok(())
    }
}
