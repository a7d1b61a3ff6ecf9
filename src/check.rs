//! Checks programs: parses, executes and corrects them as for an output that is discarded.

use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use crate::options::Options;
use crate::program::Program;
use crate::run::Watch;
use crate::support_file;
use ncfix_base::diagnostic::Severity;
use ncfix_language::syntax;

/// The stages that a check completed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Checked {
    /// True if the text was parsed without an error.
    pub(crate) parsed: bool,
    /// True if the program was executed, corrected and written to its end without an error.
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

    /// Notes a program that was parsed without an error, and the kind of its file.
    fn note(&mut self, program: &syntax::Program) {
        self.parsed = true;
        self.support_file = match program {
            syntax::Program::Sinumerik(program) => support_file::kind(program),
            syntax::Program::Words(_) => None,
        };
    }
}

/// The file of the first error of a machine that cannot be used.
pub(crate) fn faulty_file(found: &Diagnostics) -> String {
    let first = found.json().into_iter().find(|one| one.severity == Severity::Error);
    first.and_then(|one| one.file).unwrap_or_else(|| "the machine file or the state".to_owned())
}

impl Program {
    /// Parses, executes and corrects the program with the default options, and discards the text: it reports what a correction reports.
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
        let _ = self.examine(Some(machine), (false, &Options::default()), None, &mut found);
        found
    }

    /// Parses, and with a machine executes, corrects and writes the program like a correction whose text is discarded, unless `is_syntax_only`.
    ///
    /// # Errors
    /// If the dialect does not exist, or the program cannot be written with these options.
    pub(crate) fn examine(
        &self,
        machine: Option<&Machine>,
        (is_syntax_only, options): (bool, &Options),
        watch: Option<fn() -> Box<dyn Watch>>,
        found: &mut Diagnostics,
    ) -> Result<Checked, Error> {
        if let Some(checked) = Checked::of_text(self) {
            return Ok(checked);
        }
        let mut check = Checked::default();
        let Some(machine) = machine.filter(|_| !is_syntax_only) else {
            if let Some(opened) = self.open(machine, found)? {
                check.note(&opened.program);
            }
            return Ok(check);
        };
        let correction = self.correct(machine, options);
        if self.was_corrected_before(found) {
            check.parsed = self.open(Some(machine), &mut Diagnostics::default())?.is_some();
            return Ok(check);
        }
        let Some(prepared) = correction.prepare(found)? else { return Ok(check) };
        check.note(prepared.program());
        if check.support_file.is_none() {
            check.elements = prepared.discard(watch.map(|watch| watch()), found)?;
            check.executed = !found.has_errors();
        }
        Ok(check)
    }
}
