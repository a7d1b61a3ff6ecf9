//! Initialisation programs of the SINUMERIK: members of an archive, units, assignments to variables with indices.

use super::scan::{Line, Report, shown};
use crate::units::MM_PER_INCH;

/// What else stands in such a program and has nothing to do with the tables.
const SILENT: [&str; 10] = ["M0", "M00", "M01", "M1", "M17", "M30", "M2", "M02", "RET", "NEWCONF"];

/// `$NAME[index, index] = value`.
#[derive(Debug)]
pub(super) struct Assignment<'a> {
    /// The name in capitals, with its `$`.
    pub(super) name: String,
    /// What stands between the brackets.
    pub(super) indices: Vec<&'a str>,
    /// What stands behind the equals sign.
    pub(super) value: &'a str,
    /// All of it.
    pub(super) text: &'a str,
}

impl Assignment<'_> {
    /// An index that is a whole number below a limit.
    pub(super) fn index(&self, place: usize, limit: usize) -> Option<usize> {
        self.indices.get(place).and_then(|index| index.parse::<usize>().ok()).filter(|&index| index < limit)
    }
}

/// Where a reader is in an archive.
#[derive(Debug)]
pub(super) struct Place {
    /// What the names of members with such tables have in them.
    member: &'static str,
    /// What the names of their variables have in them.
    mark: &'static str,
    /// Whether it is in a member for something else, of which only the assignments to tables matter.
    is_foreign: bool,
    /// Millimetres of a unit of length.
    pub(super) unit_mm: f64,
}

impl Place {
    pub(super) fn new(member: &'static str, mark: &'static str) -> Place {
        Place { member, mark, is_foreign: false, unit_mm: 1.0 }
    }

    /// Calls back for each assignment to a system variable in a line.
    pub(super) fn line<'a>(
        &mut self,
        line: &Line<'a>,
        report: &mut Report<'_>,
        mut found: impl FnMut(f64, Assignment<'a>),
    ) {
        let text = line.before(';').trim();
        if text.starts_with('%') {
            self.is_foreign = !text.to_ascii_uppercase().contains(self.member);
            self.unit_mm = 1.0;
            return;
        }
        for statement in statements(without_number(text)) {
            match self.assignment(line, report, statement) {
                Some(assignment) if !self.is_foreign || assignment.name.contains(self.mark) => {
                    found(self.unit_mm, assignment);
                }
                _ => {}
            }
        }
    }

    /// An assignment; what is none is taken up or pointed out.
    fn assignment<'a>(&mut self, line: &Line<'a>, report: &mut Report<'_>, text: &'a str) -> Option<Assignment<'a>> {
        if text.eq_ignore_ascii_case("METRIC") || text.eq_ignore_ascii_case("INCH") {
            self.unit_mm = if text.eq_ignore_ascii_case("INCH") { MM_PER_INCH } else { 1.0 };
            return None;
        }
        let begins = |word: &str| text.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word));
        if SILENT.iter().any(|word| text.eq_ignore_ascii_case(word)) || begins("CHANDATA") || begins("STOPRE") {
            return None;
        }
        match text.split_once('=').filter(|_| text.starts_with('$')) {
            Some((left, value)) => {
                let (name, indices) = left.split_once('[').unwrap_or((left, ""));
                let indices = indices.trim().trim_end_matches(']');
                // No variable has more than three.
                let indices = indices.split(',').take(4).map(str::trim).collect();
                Some(Assignment { name: name.trim().to_ascii_uppercase(), indices, value: value.trim(), text })
            }
            None if self.is_foreign => None,
            None if text.starts_with('$') || text.to_ascii_uppercase().contains(self.mark) => {
                let help = "a table is a list of assignments such as $AN_CEC[0,0]=0.005";
                report.fault(line, text, format!("'{}' is no assignment", shown(text)), help);
                None
            }
            None => {
                let help = "a table is a list of assignments; see that nothing of it is lost";
                report.unused(line, text, format!("'{}' says nothing of tables", shown(text)), help);
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

/// The statements of a block: each variable begins one.
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
