//! The source text as syntax trees: nodes with spans, and parsers that never fail.
//!
//! The trees do not contain the meaning of codes. Nodes are stored in flat arenas and refer to each other by number, so that a block of plain words
//! needs no allocation. Each family of languages has its own trees: [`sinumerik`] and the word languages, [`words`].

pub(crate) mod firmware;
pub(crate) mod look_alike;
mod names;
mod paged_store;
mod plain;
mod reading;
pub mod sinumerik;
mod tape;
mod token;
pub mod words;

use ncfix_base::diagnostic::{Code, Diagnostic, Place, character};
use ncfix_base::source::{Source, Span};
use ncfix_dialect::{Dialect, Language};
pub use paged_store::PagedStore;
use sinumerik::Macros;

/// Maximum number of diagnostics of one file; a file with more is not a part program, and the rest of it is not read.
const MAX_FINDINGS: usize = 1000;

/// Maximum number of programs and tables in one file: many times the memory of a control.
const MAX_PARTS: usize = 10_000;

/// Size from which programs are read by pages if possible.
const LARGE_BYTES: usize = 8 << 20;
/// The size of a page.
const PAGE_BYTES: usize = 128 << 10;

/// A parsed program.
#[derive(Clone, Debug)]
pub enum Program {
    /// A Sinumerik program.
    Sinumerik(sinumerik::Program),
    /// A Grundig, Fanuc or RS274/NGC program.
    Words(words::Program),
}

impl Program {
    /// Its source text.
    #[must_use]
    pub fn source(&self) -> &Source {
        match self {
            Program::Sinumerik(program) => &program.source,
            Program::Words(program) => &program.source,
        }
    }

    /// Number of its blocks.
    #[must_use]
    pub fn block_count(&self) -> usize {
        match self {
            Program::Sinumerik(program) => program.blocks.len(),
            Program::Words(program) => program.blocks.len(),
        }
    }
}

/// Parses a program. Never fails: unreadable text is reported and skipped, and parsing continues in the next block.
#[must_use]
pub fn parse(source: &Source, dialect: &'static Dialect) -> (Program, Vec<Diagnostic>) {
    parse_with(source, dialect, &Macros::default())
}

/// Parses a program with macros of definition files in addition to its own.
#[must_use]
pub fn parse_with(source: &Source, dialect: &'static Dialect, macros: &Macros) -> (Program, Vec<Diagnostic>) {
    if dialect.language == Language::Sinumerik {
        let (program, findings) = sinumerik::parse_with(source, dialect, macros);
        return (Program::Sinumerik(program), findings);
    }
    let (program, findings) = words::parse(source, dialect);
    (Program::Words(program), findings)
}

/// Parses a program of any size by pages of `page_bytes`; `None` if it must be kept as a whole. [`parse`] does this for large programs, with an
/// identical result.
#[must_use]
pub fn parse_by_pages(source: &Source, dialect: &'static Dialect, page_bytes: usize) -> Option<Program> {
    if dialect.language == Language::Sinumerik {
        return sinumerik::parse_by_pages(source, dialect, page_bytes).map(Program::Sinumerik);
    }
    words::parse_by_pages(source, dialect, page_bytes).map(Program::Words)
}

/// The diagnostic for a file without blocks.
fn nothing_done(source: &Source) -> Diagnostic {
    Diagnostic::at(
        Code::NOT_A_PROGRAM,
        Place { file: source.id(), span: Span::new(0, source.bytes().len().min(1)) },
        "the file has no block with any effect",
        "check that this is the part program and not an empty or truncated copy",
    )
}

/// The diagnostic for a file with more programs than [`MAX_PARTS`], at the header of the first excess program.
fn too_many_parts(source: &Source, header: Span) -> Diagnostic {
    let message = format!("this is program {} of the file; at most {MAX_PARTS} are read", MAX_PARTS + 1);
    let help = "check that the file is a part program; split it into one file per program";
    Diagnostic::at(Code::NOT_A_PROGRAM, Place { file: source.id(), span: header }, message, help)
}

/// True for a comma between two digits.
fn is_decimal_comma(bytes: &[u8], at: usize) -> bool {
    let is_digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
    bytes.get(at) == Some(&b',') && at > 0 && is_digit(at - 1) && is_digit(at + 1)
}

/// Reports a file in UTF-16, and names the first character outside ASCII that no word has; the places of others are counted.
fn name_characters(source: &Source, findings: &mut Vec<Diagnostic>) {
    let bytes = source.bytes();
    if let Some(encoding) = character::wide_encoding(bytes) {
        let place = Place { file: source.id(), span: Span::new(0, 2) };
        let message = format!("the file is {encoding}, with two bytes for each character");
        *findings = vec![Diagnostic::at(Code::UNEXPECTED, place, message, "save it as ASCII or UTF-8")];
        return;
    }
    let (mut at, mut named, mut more) = (0, None, 0_usize);
    findings.retain_mut(|finding| {
        at += 1;
        let span = finding.place.filter(|place| place.file == source.id()).map(|place| place.span);
        if let (Code::UNEXPECTED, Some(span)) = (finding.code, span)
            && is_decimal_comma(bytes, span.start as usize)
        {
            "a comma within a number".clone_into(&mut finding.message);
            "write a decimal point, for example X10.5".clone_into(&mut finding.help);
            return true;
        }
        let name = match (finding.code, span) {
            (Code::UNEXPECTED, Some(span)) => character::name_at(bytes, span.start as usize),
            // The value of an address begins after it.
            (Code::MISSING_VALUE, Some(span)) => character::name_at(bytes, span.end as usize),
            _ => None,
        };
        let Some(name) = name else { return true };
        if named.is_some() {
            // A text with such a character usually has it everywhere.
            more += 1;
            at -= 1;
            return false;
        }
        finding.help = format!("{name}; {}", finding.help);
        named = Some(at - 1);
        true
    });
    if let Some(first) = named.and_then(|first| findings.get_mut(first)).filter(|_| more > 0) {
        first.message = format!("{}; such characters are at {more} more places", first.message);
    }
}

/// The diagnostics of a file, or a single one if there are too many.
fn checked(found: Vec<Diagnostic>, source: &Source, dialect: &Dialect) -> Vec<Diagnostic> {
    let mut findings = reading::hidden(source);
    findings.extend(found);
    findings.extend(tape::lost_lines(source, dialect.language));
    findings.extend(tape::lost_after_number(source, dialect.language));
    name_characters(source, &mut findings);
    if findings.len() > MAX_FINDINGS {
        findings.truncate(MAX_FINDINGS);
        findings.insert(
            0,
            Diagnostic::at(
                Code::NOT_A_PROGRAM,
                Place { file: source.id(), span: Span::new(0, source.bytes().len().min(1)) },
                format!("more than {MAX_FINDINGS} blocks cannot be read; the file is not a {} program", dialect.title),
                "check --dialect and that the file is a part program",
            ),
        );
    }
    findings
}
