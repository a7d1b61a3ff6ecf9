//! The corrected pieces of a program as an iterator.

use std::cell::RefCell;
use std::fmt;
use std::rc::Rc;

use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::run::Running;
use ncfix_base::diagnostic::Diagnostic;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::Element;
use ncfix_model::Model;
use ncfix_path::path::{CorrectionOptions, Corrector, Output};

/// The corrected pieces of moves, and between them elements without motion, from [`Correction::pieces`](super::Correction::pieces). It is lazy: a
/// program without end has pieces without end.
///
/// ```
/// use ncfix::prelude::*;
///
/// let machine = Machine::demo();
/// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
/// let correction = program.correct(&machine, &Options::default());
/// let is_piece = |output: &Result<Output, Error>| matches!(output, Ok(Output::Piece(_)));
/// assert!(correction.pieces()?.filter(is_piece).count() > 2, "the long move is divided");
/// # Ok::<(), ncfix::Error>(())
/// ```
pub struct Pieces<'a> {
    corrector: Corrector<'a, Elements<'a>>,
    running: Rc<RefCell<Running<'a>>>,
    found: Diagnostics,
}

impl fmt::Debug for Pieces<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Pieces").field("found", &self.found).finish_non_exhaustive()
    }
}

/// The elements of a program that others look at too.
struct Elements<'a>(Rc<RefCell<Running<'a>>>);

impl Iterator for Elements<'_> {
    type Item = Result<Element, Diagnostic>;

    fn next(&mut self) -> Option<Self::Item> {
        self.0.borrow_mut().next()
    }
}

impl<'a> Pieces<'a> {
    pub(super) fn new(
        running: Running<'a>,
        machine: &'a Machine,
        model: &'a Model,
        options: CorrectionOptions,
        found: Diagnostics,
    ) -> Pieces<'a> {
        let running = Rc::new(RefCell::new(running));
        let corrector = Corrector::new(Elements(Rc::clone(&running)), machine, model, options);
        Pieces { corrector, running, found }
    }

    /// The diagnostics so far, including warnings.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let machine = Machine::demo();
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// let correction = program.correct(&machine, &Options::default());
    /// let mut pieces = correction.pieces()?;
    /// assert!(pieces.by_ref().all(|output| output.is_ok()));
    /// assert!(!pieces.diagnostics().has_errors());
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.found
    }
}

impl Iterator for Pieces<'_> {
    type Item = Result<Output, Error>;

    /// The next piece. After an error the correction continues, so that one run reports all errors.
    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.corrector.next()? {
                Ok(output) => return Some(Ok(output)),
                Err(found) => {
                    let running = self.running.borrow();
                    if found.is_error() {
                        let mut one = Diagnostics::default();
                        one.add(found.clone(), running.sources());
                        self.found.add(found, running.sources());
                        return Some(Err(Error::found(one)));
                    }
                    self.found.add(found, running.sources());
                }
            }
        }
    }
}
