//! The flat stream of a program as an iterator.

use std::fmt;

use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::run::Running;
use ncfix_machine::snc::Element;

/// The elements of a program in their order, from [`Program::moves`](crate::Program::moves): moves, dwells, tool and auxiliary words.
pub struct Elements<'m> {
    running: Running<'m>,
    found: Diagnostics,
}

impl fmt::Debug for Elements<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Elements").field("found", &self.found).finish_non_exhaustive()
    }
}

impl<'m> Elements<'m> {
    pub(crate) fn new(running: Running<'m>, found: Diagnostics) -> Elements<'m> {
        Elements { running, found }
    }

    /// What was found so far, warnings too.
    #[must_use]
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.found
    }

    /// The lines that called the program of an element, innermost first.
    #[must_use]
    pub fn call_lines(&self, element: &Element) -> Vec<u32> {
        self.running.call_lines(element)
    }
}

impl Iterator for Elements<'_> {
    type Item = Result<Element, Error>;

    /// The next element. After an error the program goes on, so that one run shows all of them.
    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.running.next()? {
                Ok(element) => return Some(Ok(element)),
                Err(found) => {
                    let is_error = found.is_error();
                    let mut one = Diagnostics::default();
                    one.add(found, self.running.sources());
                    self.found.absorb(one.clone());
                    if is_error {
                        return Some(Err(Error::found(one)));
                    }
                }
            }
        }
    }
}
