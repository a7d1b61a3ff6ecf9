//! Initialisation programs of the SINUMERIK: members of an archive, units, assignments to variables with indices.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::scan::{Report, ScannedLine, shown};
use ncfix_base::pattern::{RegexSet, patterns};
use ncfix_base::source::Span;
use ncfix_base::units::MM_PER_INCH;

/// Other statements of such a program, without relation to the tables.
const SILENT: [&str; 5] = ["M0", "M00", "M01", "M1", "NEWCONF"];
/// Statements that end it.
const ENDS: [&str; 5] = ["M17", "M30", "M2", "M02", "RET"];

/// Help for a table that lacks a field.
pub(super) const KEEPS_FIELDS: &str = "write every field as the control saves it, including 0: the control keeps its old value of a missing field, which is unknown here and 0 only after its memory was cleared";

/// The missing fields of a table, with their name prefix; `None` if it has all.
pub(super) fn missing(prefix: &str, wanted: &[&str], there: &BTreeMap<String, f64>) -> Option<String> {
    let names: Vec<String> =
        wanted.iter().filter(|&&name| !there.contains_key(name)).map(|name| format!("{prefix}{name}")).collect();
    (!names.is_empty()).then(|| names.join(", "))
}

/// Variables of compensation tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TableVariable {
    /// `$AN_CEC`, member `_CEC_INI`: sag compensation.
    Cec,
    /// `$AA_ENC_COMP`, member `_EEC_INI`: leadscrew error compensation.
    Enc,
}

/// The variables outside remarks, then the members of an archive for them, each in the order of [`TableVariable`].
static MARKS: LazyLock<RegexSet> = LazyLock::new(|| {
    patterns([
        r"(?:^|[\r\n])[^;\r\n]*\$AN_CEC",
        r"(?:^|[\r\n])[^;\r\n]*\$AA_ENC_COMP",
        r"(?:^|[\r\n])[ \t\x0c]*%[^;\r\n]*_CEC_INI",
        r"(?:^|[\r\n])[ \t\x0c]*%[^;\r\n]*_EEC_INI",
    ])
});

/// `true` if a file has this variable outside its remarks, or a member for it without any table variable.
pub(super) fn has(bytes: &[u8], variable: TableVariable) -> bool {
    let found = MARKS.matches(bytes);
    let is = |mark: usize| found.iter().any(|one| one == mark);
    let own = variable as usize;
    is(own) || (is(own + 2) && !is(0) && !is(1))
}

/// `$NAME[index, index] = value`.
#[derive(Debug)]
pub(super) struct IniAssignment<'a> {
    /// The name in upper case, with its `$`.
    pub(super) name: String,
    /// The text of each index.
    pub(super) indices: Vec<&'a str>,
    /// The text after the equals sign.
    pub(super) value: &'a str,
    /// The whole assignment.
    pub(super) text: &'a str,
}

impl IniAssignment<'_> {
    /// An index that is a whole number below a limit.
    pub(super) fn index(&self, place: usize, limit: usize) -> Option<usize> {
        self.indices.get(place).and_then(|index| index.parse::<usize>().ok()).filter(|&index| index < limit)
    }
}

/// Position of a reader in an archive.
#[derive(Debug)]
pub(super) struct IniPosition {
    /// Text in the names of members with such tables.
    member: &'static str,
    /// Text in the names of their variables.
    mark: &'static str,
    /// `true` in a member for another purpose, of which only assignments to tables are relevant.
    is_foreign: bool,
    /// Millimeters per unit of length.
    pub(super) unit_mm: f64,
    /// The last assignment without a following end.
    open: Option<Span>,
}

impl IniPosition {
    pub(super) fn new(member: &'static str, mark: &'static str) -> IniPosition {
        IniPosition { member, mark, is_foreign: false, unit_mm: 1.0, open: None }
    }

    /// Reports a list that breaks off: a missing end is the only sign of missing lines.
    pub(super) fn end(&mut self, report: &mut Report<'_>) {
        if let Some(span) = self.open.take() {
            let help = "check that the file is complete: the control ends it with M17";
            report.unused_at(span, "no M17 follows: the list may be truncated", help);
        }
    }

    /// Calls `see` for each assignment to a system variable in a line.
    pub(super) fn line<'a>(
        &mut self,
        line: &ScannedLine<'a>,
        report: &mut Report<'_>,
        mut found: impl FnMut(f64, IniAssignment<'a>),
    ) {
        let text = line.before(';').trim();
        if text.starts_with('%') {
            self.end(report);
            self.is_foreign = !text.to_ascii_uppercase().contains(self.member);
            self.unit_mm = 1.0;
            return;
        }
        for statement in statements(without_number(text)) {
            match self.assignment(line, report, statement) {
                Some(assignment) if !self.is_foreign || assignment.name.contains(self.mark) => {
                    // Settings and machine data also occur in other lists, with another end.
                    if assignment.name.starts_with("$A") {
                        self.open = Some(line.span(assignment.text));
                    }
                    found(self.unit_mm, assignment);
                }
                _ => {}
            }
        }
    }

    /// Parses an assignment; other text is handled or reported.
    fn assignment<'a>(
        &mut self,
        line: &ScannedLine<'a>,
        report: &mut Report<'_>,
        text: &'a str,
    ) -> Option<IniAssignment<'a>> {
        if text.eq_ignore_ascii_case("METRIC") || text.eq_ignore_ascii_case("INCH") {
            self.unit_mm = if text.eq_ignore_ascii_case("INCH") { MM_PER_INCH } else { 1.0 };
            return None;
        }
        let begins = |word: &str| text.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word));
        if ENDS.iter().any(|word| text.eq_ignore_ascii_case(word)) {
            self.open = None;
            return None;
        }
        if SILENT.iter().any(|word| text.eq_ignore_ascii_case(word)) || begins("CHANDATA") || begins("STOPRE") {
            return None;
        }
        match text.split_once('=').filter(|_| text.starts_with('$')) {
            Some((left, value)) => {
                let (name, indices) = left.split_once('[').unwrap_or((left, ""));
                let indices = indices.trim().trim_end_matches(']');
                // No variable has more than three.
                let indices = indices.split(',').take(4).map(str::trim).collect();
                Some(IniAssignment { name: name.trim().to_ascii_uppercase(), indices, value: value.trim(), text })
            }
            None if self.is_foreign => None,
            None if text.starts_with('$') || text.to_ascii_uppercase().contains(self.mark) => {
                let help = "a table is a list of assignments such as $AN_CEC[0,0]=0.005";
                report.fault(line, text, format!("'{}' is not an assignment", shown(text)), help);
                None
            }
            None => {
                let help = "a table is a list of assignments; check that no part of it is missing";
                report.unused(line, text, format!("'{}' is not part of a table and is ignored", shown(text)), help);
                None
            }
        }
    }
}

/// A block without its number.
fn without_number(text: &str) -> &str {
    let number = text.strip_prefix(['N', 'n']).filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
    number.map_or(text, |rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start())
}

/// The statements of a block, each beginning with a variable.
fn statements(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let first = rest.chars().next()?;
        let behind = rest.get(first.len_utf8()..)?;
        let length = first.len_utf8() + behind.find('$').unwrap_or(behind.len());
        let statement = rest.get(..length)?;
        rest = rest.get(length..)?;
        Some(statement.trim())
    })
    .filter(|statement| !statement.is_empty())
}
