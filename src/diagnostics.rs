//! Diagnostics of a run, collected from all crates with their files.

mod repeated;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt;

use ncfix_base::diagnostic::{Code, Diagnostic, Place, Severity};
use ncfix_base::number::counted;
use ncfix_base::source::{Source, Span};
use ncfix_report::{json, terminal};

use repeated::{further_lines, repeated};

/// Maximum number of stored diagnostics. A program with an error in every block is understood with fewer, and memory
/// stays bounded.
const MOST_KEPT: usize = 1000;

/// Maximum number of printed diagnostics.
const MOST_DRAWN: usize = 50;

/// Number of errors drawn for a file that is probably in another language.
const MOST_MISREAD: usize = 3;

/// Diagnostics of which there may be several in one line: those about a file as a whole, and words of one block.
const ABOUT_FILES: &[Code] = &[
    Code::NOT_TOLD,
    Code::NOT_SETTLED,
    Code::REDUCED,
    Code::POOR_FIT,
    Code::DATA_FAULT,
    Code::FAULTY_DATA,
    Code::LOAD_ASSUMED,
    Code::OTHER_ACT,
];

/// Errors that depend on the axes, offsets, tools and settings of the machine.
const ABOUT_MACHINE: &[Code] = &[
    Code::CONTOUR_NOT_FOLLOWED,
    Code::OUT_OF_TRAVEL,
    Code::UNITS_DOUBT,
    Code::NO_OFFSET,
    Code::NO_TOOL,
    Code::NO_AXIS,
];

/// The help before that of such an error on the demo machine, which is not the user's.
const DEMO_HELP: &str =
    "the demo machine has its own limits, offsets and tools: give your machine file with --machine; else ";

/// The identity of a diagnostic, so that one in a loop is reported only once. Without a position the message is the
/// identity.
type Identity = (Code, String, Option<Place>);

/// Diagnostics of a run, each once, in order of occurrence; at most a thousand are kept.
///
/// ```
/// use ncfix::prelude::*;
///
/// let program = Program::parse("part.mpf", "G0 X9000\nM30\n", DialectChoice::Sinumerik)?;
/// for one in program.check(&Machine::demo()).errors() {
///     println!("{}:{}: {}", one.file().unwrap_or("?"), one.line().unwrap_or(0), one.message());
/// }
/// # Ok::<(), ncfix::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    kept: Vec<(Diagnostic, Option<Source>)>,
    seen: HashSet<Identity>,
    errors: usize,
    warnings: usize,
    has_language_error: bool,
    /// True after the warning that the demo machine is used.
    has_demo: bool,
    /// The errors whose help names the demo machine.
    of_demo: HashSet<Identity>,
    /// The help for the first syntax error of a file, by file name.
    hints: HashMap<String, Hint>,
    /// The hints that applied: files that turned out to be in another language.
    misread: BTreeMap<String, Hint>,
}

impl fmt::Display for Diagnostics {
    /// One line for each.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.iter().try_for_each(|one| writeln!(out, "{one}"))
    }
}

/// A diagnostic with its position in its file.
///
/// ```
/// use ncfix::prelude::*;
///
/// let program = Program::parse("part.mpf", "G0 X9000\nM30\n", DialectChoice::Sinumerik)?;
/// let found = program.check(&Machine::demo());
/// let one = found.errors().next().unwrap();
/// assert_eq!((one.file(), one.line(), one.column()), (Some("part.mpf"), Some(1), Some(1)));
/// assert_eq!(one.severity(), Severity::Error);
/// assert_eq!(&b"G0 X9000"[one.span().unwrap().range()], b"G0 X9000");
/// # Ok::<(), ncfix::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Located<'a> {
    diagnostic: &'a Diagnostic,
    source: Option<&'a Source>,
}

impl<'a> Located<'a> {
    /// Its stable code, such as E0203; `ncfix explain` has a long text for each.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let found = Program::parse("part.mpf", "G0 X9000\nM30\n", DialectChoice::Sinumerik)?.check(&Machine::demo());
    /// let one = found.errors().next().unwrap();
    /// assert_eq!(one.code().as_str(), "E0302");
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn code(&self) -> Code {
        self.diagnostic.code
    }

    /// Error or warning; it follows from the code.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let found = Program::parse("part.mpf", "G0 X9000\nM30\n", DialectChoice::Sinumerik)?.check(&Machine::demo());
    /// let one = found.errors().next().unwrap();
    /// assert_eq!(one.severity(), Severity::Error);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn severity(&self) -> Severity {
        self.diagnostic.severity()
    }

    /// The message, with numbers and units.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let found = Program::parse("part.mpf", "G0 X9000\nM30\n", DialectChoice::Sinumerik)?.check(&Machine::demo());
    /// let one = found.errors().next().unwrap();
    /// assert!(one.message().contains("limit of 700 mm"), "{}", one.message());
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn message(&self) -> &'a str {
        &self.diagnostic.message
    }

    /// The suggested action.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let found = Program::parse("part.mpf", "G0 X9000\nM30\n", DialectChoice::Sinumerik)?.check(&Machine::demo());
    /// let one = found.errors().next().unwrap();
    /// assert!(!one.help().is_empty());
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn help(&self) -> &'a str {
        &self.diagnostic.help
    }

    /// The name of its file; `None` if it has no position.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let found = Program::parse("part.mpf", "G0 X9000\nM30\n", DialectChoice::Sinumerik)?.check(&Machine::demo());
    /// let one = found.errors().next().unwrap();
    /// assert_eq!(one.file(), Some("part.mpf"));
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn file(&self) -> Option<&'a str> {
        self.diagnostic.place.and(self.source).map(Source::name)
    }

    /// Its line, from 1.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let found = Program::parse("part.mpf", "G0 X9000\nM30\n", DialectChoice::Sinumerik)?.check(&Machine::demo());
    /// let one = found.errors().next().unwrap();
    /// assert_eq!(one.line(), Some(1));
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        self.as_data().line
    }

    /// Its column, from 1, in characters; in a line that is not UTF-8, in bytes.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let found = Program::parse("part.mpf", "G0 X9000\nM30\n", DialectChoice::Sinumerik)?.check(&Machine::demo());
    /// let one = found.errors().next().unwrap();
    /// assert_eq!(one.column(), Some(1));
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn column(&self) -> Option<usize> {
        self.as_data().column
    }

    /// Its byte range in its file.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let found = Program::parse("part.mpf", "G0 X9000\nM30\n", DialectChoice::Sinumerik)?.check(&Machine::demo());
    /// let one = found.errors().next().unwrap();
    /// assert_eq!(one.span().unwrap().range(), 0..8);
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn span(&self) -> Option<Span> {
        self.source.and(self.diagnostic.place).map(|place| place.span)
    }

    fn as_data(&self) -> json::DiagnosticReport {
        json::DiagnosticReport::new(self.diagnostic, self.source)
    }
}

impl fmt::Display for Located<'_> {
    /// `part.mpf:1:4: error[E0302]: X leaves its travel …`
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let json::DiagnosticReport { file, line, column, .. } = self.as_data();
        if let (Some(file), Some(line), Some(column)) = (file, line, column) {
            write!(out, "{file}:{line}:{column}: ")?;
        }
        write!(out, "{}[{}]: {}", self.severity().word(), self.code().as_str(), self.message())
    }
}

/// The message for a file that is not in the language in which it was parsed.
#[derive(Clone, Debug)]
pub(crate) struct Hint {
    /// The suggested action.
    pub(crate) help: String,
    /// The language that the file resembles and the reason why another was used, for all errors of the file; `None` if the user chose the language.
    pub(crate) sentence: Option<String>,
}

impl Diagnostics {
    /// Adds a diagnostic whose position, if any, is in one of `sources`.
    pub(crate) fn add(&mut self, mut diagnostic: Diagnostic, sources: &[Source]) {
        let source = diagnostic.place.and_then(|place| sources.iter().find(|source| source.id() == place.file));
        let name = source.map_or(diagnostic.message.as_str(), Source::name);
        let what = if ABOUT_FILES.contains(&diagnostic.code) { diagnostic.message.as_str() } else { name };
        let identity = (diagnostic.code, what.to_owned(), diagnostic.place);
        let is_full = self.seen.len() >= MOST_KEPT;
        if self.seen.contains(&identity) {
            return;
        }
        self.has_demo |= diagnostic.code == Code::NO_MACHINE;
        if diagnostic.is_error() {
            if self.has_demo && ABOUT_MACHINE.contains(&diagnostic.code) && self.of_demo.insert(identity.clone()) {
                diagnostic.help.insert_str(0, DEMO_HELP);
            }
            if is_of_text(&diagnostic)
                && let Some((file, hint)) = self.hints.remove_entry(name)
            {
                diagnostic.help = format!("{}; else {}", hint.help, diagnostic.help);
                self.misread.insert(file, hint);
            }
            self.errors += 1;
            self.has_language_error |= diagnostic.code.is_language();
        } else {
            self.warnings += 1;
        }
        if !is_full {
            self.seen.insert(identity);
            self.kept.push((diagnostic, source.cloned()));
        }
    }

    /// Adds the diagnostics of another collection.
    pub(crate) fn absorb(&mut self, other: Diagnostics) {
        self.of_demo.extend(other.of_demo);
        for (finding, source) in other.kept {
            self.add(finding, source.as_slice());
        }
        self.hints.extend(other.hints);
        self.misread.extend(other.misread);
    }

    /// Stores the help for the case that a file is in another language.
    pub(crate) fn hint(&mut self, source: &Source, hint: Hint) {
        self.hints.insert(source.name().to_owned(), hint);
    }

    /// Adds diagnostics with positions in `sources`.
    pub(crate) fn extend(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>, sources: &[Source]) {
        diagnostics.into_iter().for_each(|diagnostic| self.add(diagnostic, sources));
    }

    /// The first of all.
    pub(crate) fn first(&self) -> Option<&Diagnostic> {
        self.kept.first().map(|(diagnostic, _)| diagnostic)
    }

    /// The first diagnostic with a code, and its file.
    pub(crate) fn first_of(&self, code: Code) -> Option<&(Diagnostic, Option<Source>)> {
        self.kept.iter().find(|(diagnostic, _)| diagnostic.code == code)
    }

    /// Removes the warnings with a code that no longer apply, such as that of a demo machine that is not used.
    pub(crate) fn withdraw(&mut self, code: Code) {
        self.has_demo &= code != Code::NO_MACHINE;
        let before = self.kept.len();
        self.kept.retain(|(diagnostic, _)| diagnostic.code != code || diagnostic.is_error());
        self.warnings -= before - self.kept.len();
    }

    /// Gives the diagnostics with a code the help of a command that has another way out.
    pub(crate) fn advise(&mut self, code: Code, help: &str) {
        for (diagnostic, _) in self.kept.iter_mut().filter(|(diagnostic, _)| diagnostic.code == code) {
            diagnostic.help = help.to_owned();
        }
    }

    /// True if there is an error, so that no output is written.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert!(!Diagnostics::default().has_errors());
    /// ```
    #[must_use]
    pub fn has_errors(&self) -> bool {
        self.errors > 0
    }

    /// True if there is a syntax error.
    pub(crate) fn has_language_errors(&self) -> bool {
        self.has_language_error
    }

    /// True if there are no diagnostics.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert!(Diagnostics::default().is_empty());
    /// ```
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// The number of diagnostics that are kept.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert_eq!(Diagnostics::default().len(), 0);
    /// ```
    #[must_use]
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// All stored diagnostics, errors and warnings.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let program = Program::parse("part.mpf", "G0 X9000\nM30\n", DialectChoice::Sinumerik)?;
    /// assert!(program.check(&Machine::demo()).iter().any(|one| one.line() == Some(1)));
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    pub fn iter(&self) -> impl Iterator<Item = Located<'_>> {
        self.kept.iter().map(|(diagnostic, source)| Located { diagnostic, source: source.as_ref() })
    }

    /// The errors, which prevent output.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// assert_eq!(Diagnostics::default().errors().count(), 0);
    /// ```
    pub fn errors(&self) -> impl Iterator<Item = Located<'_>> {
        self.iter().filter(|one| one.severity() == Severity::Error)
    }

    /// All of them as `ncfix` prints them, with their source lines, without colors.
    ///
    /// ```
    /// # use ncfix::prelude::*;
    /// let program = Program::parse("part.mpf", "G0 X9000\nM30\n", DialectChoice::Sinumerik)?;
    /// assert!(program.check(&Machine::demo()).drawn().contains("1 | G0 X9000"));
    /// # Ok::<(), ncfix::Error>(())
    /// ```
    #[must_use]
    pub fn drawn(&self) -> String {
        self.drawing(terminal::Colors::Plain, true)
    }

    /// The errors, with the line of each if it is in one of these files.
    pub(crate) fn errors_in(&self, sources: &[Source]) -> impl Iterator<Item = (Code, Option<usize>)> {
        let line = |one: &Diagnostic, source: &Option<Source>| {
            let source = source.as_ref().filter(|source| sources.iter().any(|one| one.name() == source.name()))?;
            Some(source.line_column(one.place?.span.start).0)
        };
        let errors = self.kept.iter().filter(|(one, _)| one.severity() == Severity::Error);
        errors.map(move |(one, source)| (one.code, line(one, source)))
    }

    /// True if the maximum number of errors is reached, after which the work stops.
    pub(crate) fn is_hopeless(&self) -> bool {
        self.errors >= MOST_KEPT
    }

    /// `2 errors, 1 warning`.
    pub(crate) fn count(&self) -> String {
        terminal::count(self.errors, self.warnings)
    }

    /// The diagnostics as data.
    pub(crate) fn json(&self) -> Vec<json::DiagnosticReport> {
        self.kept.iter().map(|(diagnostic, source)| json::DiagnosticReport::new(diagnostic, source.as_ref())).collect()
    }

    /// The printed first diagnostics: another machine than that of the program, errors, warnings (or only errors), each
    /// group in order of occurrence.
    pub(crate) fn drawing(&self, colors: terminal::Colors, with_warnings: bool) -> String {
        let mut shown: Vec<&(Diagnostic, Option<Source>)> = self.kept.iter().collect();
        shown.retain(|(diagnostic, _)| with_warnings || diagnostic.is_error());
        // A machine other than that of the program is the cause of everything that follows.
        let is_cause = |code: Code| code == Code::OTHER_STAMP || code == Code::NO_MACHINE;
        shown.sort_by_key(|(diagnostic, _)| (!is_cause(diagnostic.code), !diagnostic.is_error()));
        let total = self.errors + if with_warnings { self.warnings } else { 0 };
        let mut groups = repeated(&shown);
        let mut drawn = 0;
        let mut out = String::new();
        for (name, hint) in &self.misread {
            let Some(sentence) = &hint.sentence else { continue };
            let (mut kinds, mut hidden) = (0, 0);
            groups.retain(|group| {
                let (found, source) = group[0];
                let is_one = is_of_text(found) && source.as_ref().is_some_and(|source| source.name() == name.as_str());
                if !is_one {
                    return true;
                }
                kinds += 1;
                hidden += if kinds > MOST_MISREAD { group.len() } else { 0 };
                kinds <= MOST_MISREAD
            });
            drawn += hidden;
            out.push_str(&terminal::hint(sentence, colors));
            if hidden > 0 {
                out.push_str(&format!(
                    "not shown: {} of this file, probably with the same cause; state the language with --dialect, or list all with `ncfix check --json`\n",
                    counted(hidden as u64, "more error")
                ));
            }
            out.push('\n');
        }
        for group in groups.iter().take(MOST_DRAWN) {
            let (diagnostic, source) = group[0];
            let said = self.without_hint(diagnostic, source.as_ref());
            out.push_str(&terminal::draw(said.as_ref().unwrap_or(diagnostic), source.as_ref(), colors));
            out.push_str(&further_lines(&group[1..]));
            out.push('\n');
            drawn += group.len();
        }
        if total > drawn {
            out.push_str(&format!("… and {} more\n\n", total - drawn));
        }
        out
    }
}

impl Diagnostics {
    /// A diagnostic without the hint that is printed above all of them.
    fn without_hint(&self, diagnostic: &Diagnostic, source: Option<&Source>) -> Option<Diagnostic> {
        let hint = self.misread.get(source?.name()).filter(|hint| hint.sentence.is_some())?;
        let help = diagnostic.help.strip_prefix(hint.help.as_str())?.strip_prefix("; else ")?.to_owned();
        Some(Diagnostic { help, ..diagnostic.clone() })
    }
}

/// True if the diagnostic is a syntax error of a program.
fn is_of_text(diagnostic: &Diagnostic) -> bool {
    diagnostic.is_error() && matches!(diagnostic.code.as_str().get(..3), Some("E01" | "E02"))
}

#[cfg(test)]
mod tests;
