//! Checks programs: parses and executes them, and tests whether the axes reach all positions.

use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use crate::program::Program;
use crate::run::{self, Watch};
use crate::support_file;
use ncfix_base::diagnostic::Code;
use ncfix_language::exec::{Options, RapidOrder};
use ncfix_language::syntax;
use ncfix_path::path::ReachScan;

/// The check stops after this number of blocks with syntax errors.
const MOST_ERRORS: u32 = 1000;

/// The stages that a check completed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Checked {
    /// True if the text was parsed without an error.
    pub(crate) parsed: bool,
    /// True if the program was executed to its end without an error.
    pub(crate) executed: bool,
    /// The kind of the file if it is not a program.
    pub(crate) support_file: Option<&'static str>,
    /// Elements of the flat stream.
    pub(crate) elements: u64,
}

impl Checked {
    /// The result for a file that is not a program, by its name and its first lines; `None` if it may be a program.
    pub(crate) fn of_text(program: &Program) -> Option<Checked> {
        let kind = support_file::kind_of_text(program.source())?;
        Some(Checked { parsed: true, support_file: Some(kind), ..Checked::default() })
    }
}

impl Program {
    /// Parses and executes the program, and tests whether the axes reach all positions; all findings are reported.
    ///
    /// ```
    /// use ncfix::prelude::*;
    ///
    /// let program = Program::parse("part.mpf", "G0 X50 Y50 Z100\nG1 X600 F500\nM30\n", DialectChoice::Sinumerik)?;
    /// assert!(!program.check(&Machine::demo()).has_errors());
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn check(&self, machine: &Machine) -> Diagnostics {
        let mut found = Diagnostics::default();
        // The dialect was there when the program was made.
        let _ = self.examine(Some(machine), false, None, &mut found);
        found
    }

    /// Parses, and with a machine executes unless `is_syntax_only`.
    ///
    /// # Errors
    /// If the dialect does not exist.
    pub(crate) fn examine(
        &self,
        machine: Option<&Machine>,
        is_syntax_only: bool,
        watch: Option<fn() -> Box<dyn Watch>>,
        found: &mut Diagnostics,
    ) -> Result<Checked, Error> {
        if let Some(checked) = Checked::of_text(self) {
            return Ok(checked);
        }
        let mut check = Checked::default();
        let Some(opened) = self.open(machine, found)? else { return Ok(check) };
        check.parsed = true;
        check.support_file = match &opened.program {
            syntax::Program::Sinumerik(program) => support_file::kind(program),
            syntax::Program::Words(_) => None,
        };
        if check.support_file.is_some() {
            return Ok(check);
        }
        let Some(machine) = machine.filter(|_| !is_syntax_only) else { return Ok(check) };
        let options = Options { rapid_order: RapidOrder::All, ..Options::default() };
        let mut running = self.start_as(opened, &machine.machine, options);
        if let Some(watch) = watch {
            running = running.watched(watch());
        }
        check.executed = true;
        // Nobody's program is for the demo machine.
        let mut reach = (!machine.is_demo).then(|| ReachScan::new(&machine.machine, self.reading().start));
        let mut is_beyond = false;
        while let Some(item) = running.next() {
            match item {
                Ok(element) => {
                    check.elements += u64::from(element.kind.is_in_text());
                    if let Some(reach) = &mut reach {
                        is_beyond |= reach.note(&element).count() > 0;
                    }
                }
                Err(diagnostic) => {
                    check.executed &= !diagnostic.is_error();
                    found.add(diagnostic, running.sources());
                    if found.is_hopeless() {
                        break;
                    }
                }
            }
        }
        if check.executed && !running.moves() {
            found.add(run::without_motion(self.source(), Code::MOVES_NOTHING), running.sources());
        }
        if is_beyond {
            self.reach(machine, watch, found)?;
        }
        Ok(check)
    }

    /// Says where axes would leave their travel, as far as the program tells: what only an assumed place would do is no finding. For that it is
    /// executed as for a correction.
    fn reach(
        &self,
        machine: &Machine,
        watch: Option<fn() -> Box<dyn Watch>>,
        found: &mut Diagnostics,
    ) -> Result<(), Error> {
        let Some(opened) = self.open(Some(machine), &mut Diagnostics::default())? else { return Ok(()) };
        let mut running = self.start_as(opened, &machine.machine, run::strict(RapidOrder::All));
        if let Some(watch) = watch {
            running = running.watched(watch());
        }
        let mut reach = ReachScan::new(&machine.machine, self.reading().start);
        let mut errors = 0;
        while let Some(item) = running.next() {
            match item {
                Ok(element) => reach.note(&element).for_each(|one| found.add(one, running.sources())),
                Err(one) => errors += u32::from(one.is_error()),
            }
            if errors > MOST_ERRORS || found.is_hopeless() {
                break;
            }
        }
        Ok(())
    }
}
