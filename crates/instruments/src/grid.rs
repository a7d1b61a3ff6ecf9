//! Cells of a text: separator, decimal sign, and the table in it.
//!
//! Exports have lines before and after their table, blanks as separators, and headers in two lines. Readers of CSV take none of these and do not keep
//! the place of a cell, so lines are split here; quoted cells follow RFC 4180.

use ncfix_base::csv::DecimalSign;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{FileId, Span};

use crate::differences::{difference, without_difference};
use crate::numerals::may_be_thousands;
pub use crate::numerals::number;
use crate::text::DecodedText;
use crate::unit::ReadingUnit;

/// Most cells in one line; a reading has far fewer columns.
const MOST_CELLS: usize = 512;

/// Separator of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// `;`
    Semicolon,
    /// A tab.
    Tab,
    /// `,`
    Comma,
    /// One or more blanks or tabs.
    Blanks,
    /// `|`, at both ends of the line too: a table in a report.
    Bar,
}

impl Separator {
    /// Returns the name in a sentence.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Separator::Semicolon => "semicolon",
            Separator::Tab => "tab",
            Separator::Comma => "comma",
            Separator::Blanks => "blank",
            Separator::Bar => "bar",
        }
    }
}

/// Cell of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GridCell {
    /// Content, trimmed, without quotation marks.
    pub text: String,
    /// Bytes of the cell.
    pub span: Span,
}

/// Line of cells.
#[derive(Clone, Debug)]
pub struct GridLine {
    /// Number of the line, from 1.
    pub number: usize,
    /// Cells.
    pub cells: Vec<GridCell>,
}

/// Table in a text: headings, optional units, and rows of equal width.
#[derive(Clone, Debug)]
pub struct GridTable {
    /// Separator of cells.
    pub separator: Separator,
    /// Decimal sign of its numbers.
    pub decimal: DecimalSign,
    /// Headings; empty if the file has none.
    pub headings: Vec<GridHeading>,
    /// Line of the headings; 0 without headings.
    pub heading_line: usize,
    /// Rows of readings.
    pub rows: Vec<GridLine>,
    /// Lines before the table.
    pub before: Vec<usize>,
    /// Rows of statistics, and lines after the table, which are not read.
    pub skipped: Vec<usize>,
}

/// Heading of a column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridHeading {
    /// Words in lower case, without the unit.
    pub words: String,
    /// As written.
    pub written: String,
    /// Unit in the heading.
    pub unit: Option<ReadingUnit>,
}

/// Splits a line.
#[must_use]
pub fn split(line: &str, start: u32, separator: Separator) -> Vec<GridCell> {
    let (line, start) =
        if separator == Separator::Bar { inside_bars(line, start as usize) } else { (line, start as usize) };
    let mut cells = Vec::new();
    let mut push = |from: usize, to: usize| {
        let raw = line.get(from..to).unwrap_or_default();
        let text = raw.trim();
        let lead = raw.len() - raw.trim_start().len();
        let text = match text.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')) {
            Some(inner) => inner.replace("\"\"", "\"").trim().to_owned(),
            None => text.to_owned(),
        };
        let length = raw.trim().len();
        cells.push(GridCell { text, span: Span::new(start + from + lead, start + from + lead + length) });
        cells.len() < MOST_CELLS
    };
    let mut from = 0;
    let mut is_quoted = false;
    let mut last_blank = true;
    for (at, letter) in line.char_indices() {
        if letter == '"' {
            is_quoted = !is_quoted;
        }
        let is_end = !is_quoted
            && match separator {
                Separator::Semicolon => letter == ';',
                Separator::Tab => letter == '\t',
                Separator::Comma => letter == ',',
                Separator::Blanks => letter.is_whitespace(),
                Separator::Bar => letter == '|',
            };
        if is_end {
            if (separator != Separator::Blanks || !last_blank) && !push(from, at) {
                return cells;
            }
            from = at + letter.len_utf8();
        }
        last_blank = is_end;
    }
    if separator != Separator::Blanks || !last_blank {
        push(from, line.len());
    }
    cells
}

/// A line without the bars at its ends, and the byte at which it begins.
fn inside_bars(line: &str, start: usize) -> (&str, usize) {
    let lead = line.len() - line.trim_start().len();
    let inner = line.trim();
    let (inner, from) = inner.strip_prefix('|').map_or((inner, start + lead), |inner| (inner, start + lead + 1));
    (inner.strip_suffix('|').unwrap_or(inner), from)
}

/// True if a cell is a number in either notation.
fn is_numeric(text: &str) -> bool {
    number(text, DecimalSign::Point).is_some() || number(text, DecimalSign::Comma).is_some()
}

/// Words at the beginning of a row of statistics.
const STATISTICS: &[&str] = &[
    "mean",
    "mittel",
    "mittelwert",
    "average",
    "moyenne",
    "media",
    "sigma",
    "std",
    "stdev",
    "s",
    "s+",
    "s-",
    "max",
    "min",
    "range",
    "spannweite",
    "x̄",
    "b",
    "bi",
    "reversal",
    "umkehrspanne",
    "sum",
    "total",
    "rms",
    "end",
];

/// Comment lines of exports.
const COMMENTS: &[&str] = &["#", "//", "!"];

/// True for a line without readings.
fn is_comment(line: &str) -> bool {
    let line = line.trim_start();
    line.is_empty() || COMMENTS.iter().any(|mark| line.starts_with(mark))
}

/// True for the rule below the headings of a table with bars: `|---|:---:|`.
fn is_rule(line: &str) -> bool {
    line.contains('-') && line.chars().all(|letter| matches!(letter, '|' | '-' | ':' | '+' | '=' | ' ' | '\t'))
}

/// Finds the table of a text.
///
/// # Errors
/// A diagnostic if the text has no table, if a row has more or fewer cells than the others, or if the decimal sign is not certain.
pub fn table(text: &DecodedText) -> Result<GridTable, Box<Diagnostic>> {
    let candidates = [Separator::Semicolon, Separator::Tab, Separator::Comma, Separator::Bar, Separator::Blanks];
    let scored = candidates.into_iter().map(|separator| (score(text, separator), separator));
    let scored: Vec<(usize, Separator)> = scored.collect();
    let better = |best: (usize, Separator), one: &(usize, Separator)| if one.0 > best.0 { *one } else { best };
    let mut best = scored.iter().fold((0, Separator::Semicolon), better);
    if best.1 == Separator::Blanks {
        // In rows with tabs or semicolons, blanks belong to the cells: names with a number make more numeric cells.
        let is_written =
            |one: &&(usize, Separator)| matches!(one.1, Separator::Semicolon | Separator::Tab | Separator::Bar);
        let written = scored.iter().filter(is_written).fold((0, Separator::Semicolon), better);
        if BLANKS_IN_CELLS * written.0 >= best.0 {
            best = written;
        }
    }
    if best.0 == 0 {
        let help = "export the readings as a table: a line of headings, then one line for each reading";
        return Err(Box::new(Diagnostic::nowhere(Code::DATA_NO_TABLE, "the file has no table of numbers", help)));
    }
    read(text, best.1)
}

/// Numeric cells of a table split at blanks for each one of the table itself at most: each cell may be a name with up to three numbers.
const BLANKS_IN_CELLS: usize = 4;

/// Number of numeric cells in rows that look like readings with this separator.
fn score(text: &DecodedText, separator: Separator) -> usize {
    let mut widths: std::collections::BTreeMap<usize, usize> = std::collections::BTreeMap::new();
    for (_, line, start) in text.lines().filter(|(_, line, _)| !is_comment(line)) {
        let cells = split(line, start, separator);
        let filled = cells.iter().filter(|cell| !cell.text.is_empty()).count();
        let numbers = cells.iter().filter(|cell| is_numeric(&cell.text)).count();
        if cells.len() >= 2 && numbers >= 1 && 2 * numbers >= filled.min(4) {
            *widths.entry(cells.len()).or_default() += 10 * numbers - (filled - numbers).min(numbers);
        }
    }
    // Blanks split every prose line, so a written separator is preferred for equal evidence.
    widths.values().copied().max().unwrap_or(0)
}

fn read(text: &DecodedText, separator: Separator) -> Result<GridTable, Box<Diagnostic>> {
    let mut lines: Vec<GridLine> = text
        .lines()
        .filter(|(_, line, _)| !is_comment(line))
        .filter(|(_, line, _)| separator != Separator::Bar || !is_rule(line))
        .map(|(number, line, start)| GridLine { number, cells: split(line, start, separator) })
        .filter(|line| line.cells.iter().any(|cell| !cell.text.is_empty()))
        .collect();
    let numbers = |line: &GridLine| line.cells.iter().filter(|cell| is_numeric(&cell.text)).count();
    let is_row = |line: &GridLine| {
        line.cells.len() >= 2
            && numbers(line) >= 1
            && 2 * numbers(line) >= line.cells.iter().filter(|cell| !cell.text.is_empty()).count().min(4)
    };
    // The table is where most rows have the same number of cells.
    let mut widths: std::collections::BTreeMap<usize, usize> = std::collections::BTreeMap::new();
    for line in lines.iter().filter(|line| is_row(line)) {
        *widths.entry(line.cells.len()).or_default() += numbers(line);
    }
    let width = widths.iter().max_by_key(|(width, count)| (**count, **width)).map_or(0, |(width, _)| *width);
    if separator == Separator::Blanks {
        for line in lines.iter_mut().filter(|line| line.cells.len() > width && numbers(line) == 0) {
            let wide = wide_cells(&line.cells);
            if wide.len() == width {
                line.cells = wide;
            }
        }
    }
    let is_words = |line: &GridLine| {
        line.cells.len() == width && line.cells.iter().filter(|cell| !cell.text.is_empty()).count() * 2 > width
    };
    let is_of_table = |line: &&GridLine| line.cells.len() == width && is_row(line);
    // Where rows begin with a number, a line such as `Feed;1000` above them is not one of them.
    let begins_with_number = |line: &GridLine| line.cells.first().is_some_and(|cell| is_numeric(&cell.text));
    let rows_of_table = lines.iter().filter(is_of_table);
    let is_numbered = 2 * rows_of_table.clone().filter(|line| begins_with_number(line)).count() > rows_of_table.count();
    let is_first = |line: &GridLine| is_of_table(&line) && (!is_numbered || begins_with_number(line));
    let first = lines.iter().position(is_first).unwrap_or(0);
    // A wide table of runs has numbers as headings, such as 1+ 1- 2+: the first line with a word that is a heading begins it.
    let is_title = |at: usize| {
        lines.get(at).is_some_and(|line| is_words(line) && numbers(line) * 3 < width.max(3) || is_heading(line, width))
    };
    // A pair such as `Axis;X` above a title is not a title.
    let is_pair_above = |at: usize| {
        let filled = lines.get(at).map_or(0, |line| line.cells.iter().filter(|cell| !cell.text.is_empty()).count());
        filled == 2
            && at + 1 < first
            && is_title(at + 1)
            && !lines.get(at + 1).is_some_and(|line| is_units(line, width))
    };
    let heading = (first.saturating_sub(2)..=first).find(|&at| is_title(at) && !is_pair_above(at));
    let mut headings = Vec::new();
    let mut start = first;
    if let Some(at) = heading {
        headings = lines[at].cells.iter().map(|cell| heading_of(&cell.text)).collect();
        start = at + 1;
        if let Some(line) = lines.get(at + 1).filter(|line| is_units(line, width)) {
            for (heading, cell) in headings.iter_mut().zip(&line.cells) {
                heading.unit = heading.unit.or(ReadingUnit::find(cell.text.trim_matches(['[', ']', '(', ')'])));
            }
            start = at + 2;
        }
    }
    let mut rows = Vec::new();
    let mut skipped = Vec::new();
    for line in &lines[start.min(lines.len())..] {
        let label =
            line.cells.first().map(|cell| cell.text.trim_end_matches([':', '.']).to_lowercase()).unwrap_or_default();
        if (is_by_number(&rows) && STATISTICS.contains(&label.as_str())) || (numbers(line) == 0 && !rows.is_empty()) {
            skipped.push(line.number);
        } else if line.cells.len() != width {
            let message = format!("line {} has {} cells, the other rows have {width}", line.number, line.cells.len());
            let help = "a missing cell needs its separator, and a number in another notation makes two cells of one: export the table again";
            return Err(Box::new(Diagnostic::at(Code::DATA_NO_TABLE, text.place(line.number), message, help)));
        } else if !skipped.is_empty() && is_row(line) {
            let places = blocks(&lines[start.min(lines.len())..], &|own| own.cells.len() == width && is_row(own));
            let message = format!("line {} belongs to a second table; rows are in the lines {places}", line.number);
            let help = "save each table with the lines above it in a file of its own, and import all files together";
            let help = format!("{help}{}", tables_of_targets(text));
            return Err(Box::new(Diagnostic::at(Code::DATA_NO_TABLE, text.place(line.number), message, help)));
        } else {
            rows.push(line.clone());
        }
    }
    let before = lines[..heading.unwrap_or(first).min(lines.len())].iter().map(|line| line.number).collect();
    let decimal = decimal_sign(&rows, separator)?;
    let heading_line = heading.and_then(|at| lines.get(at)).map_or(0, |line| line.number);
    Ok(GridTable { separator, decimal, headings, heading_line, rows, before, skipped })
}

/// Names the first and the last line of each block of rows: `3 to 5, 9 to 11`.
fn blocks(lines: &[GridLine], is_row: &dyn Fn(&GridLine) -> bool) -> String {
    /// Most blocks that are named.
    const MOST: usize = 8;
    let groups = lines.chunk_by(|one, other| is_row(one) == is_row(other));
    let mut named: Vec<String> = groups
        .filter(|group| group.iter().all(is_row))
        .filter_map(|group| Some(format!("{} to {}", group.first()?.number, group.last()?.number)))
        .collect();
    if named.len() > MOST {
        named.truncate(MOST);
        named.push("…".to_owned());
    }
    named.join(", ")
}

/// Names the tables of a report in Markdown that have targets, for an advice; empty without such tables.
fn tables_of_targets(text: &DecodedText) -> String {
    /// Words of a heading with targets, and most tables that are named.
    const WORDS: [&str; 5] = ["target", "tgt", "soll", "cible", "nominal"];
    const MOST: usize = 6;
    let lines: Vec<(usize, &str)> = text.lines().map(|(number, line, _)| (number, line.trim())).collect();
    let is_rule = |line: &str| line.contains("---") && line.contains('|') && line.chars().all(|c| "-|: ".contains(c));
    let cells =
        |line: &str| line.trim_matches('|').split('|').map(|cell| cell.trim().to_lowercase()).collect::<Vec<_>>();
    let mut found = Vec::new();
    for pair in lines.windows(2).filter(|pair| is_rule(pair[1].1)) {
        let ((number, heading), (below, _)) = (pair[0], pair[1]);
        let has_targets = cells(heading).iter().any(|cell| WORDS.iter().any(|word| cell.contains(word)));
        let rows = lines.iter().filter(|(own, _)| *own > below).take_while(|(_, line)| line.contains('|'));
        let is_row = |line: &str| cells(line).iter().filter(|cell| is_numeric(cell)).count() >= 2;
        let count = rows.filter(|(_, line)| is_row(line)).count();
        if has_targets && count >= 2 {
            found.push(format!("line {number} ({count} rows)"));
        }
    }
    found.truncate(MOST);
    if found.is_empty() { String::new() } else { format!("; the tables with targets begin in {}", found.join(", ")) }
}

/// Joins words with one blank between them: in aligned columns, headings of several words are further apart.
fn wide_cells(cells: &[GridCell]) -> Vec<GridCell> {
    let mut out: Vec<GridCell> = Vec::new();
    for cell in cells {
        match out.last_mut().filter(|last| cell.span.start == last.span.end + 1) {
            Some(last) => {
                last.text = format!("{} {}", last.text, cell.text);
                last.span.end = cell.span.end;
            }
            None => out.push(cell.clone()),
        }
    }
    out
}

/// True if rows begin with a number: then a row that begins with a word is not a reading. Names of features may be any word.
fn is_by_number(rows: &[GridLine]) -> bool {
    rows.first().and_then(|row| row.cells.first()).is_some_and(|cell| is_numeric(&cell.text))
}

/// True for a heading whose columns are runs: the first cell is a word, the others name a run and a direction.
fn is_heading(line: &GridLine, width: usize) -> bool {
    let mut cells = line.cells.iter();
    let is_word = cells.next().is_some_and(|cell| !cell.text.is_empty() && !is_numeric(&cell.text));
    let is_run = |text: &str| !text.is_empty() && text.len() <= 12 && !text.contains(['.', ',']);
    line.cells.len() == width
        && is_word
        && cells.clone().count() > 0
        && cells.all(|cell| is_run(&cell.text) && (!is_numeric(&cell.text) || cell.text.len() <= 2))
}

/// True for a line that has only units.
fn is_units(line: &GridLine, width: usize) -> bool {
    let mut filled = line.cells.iter().filter(|cell| !cell.text.is_empty()).peekable();
    line.cells.len() == width
        && filled.peek().is_some()
        && filled.all(|cell| ReadingUnit::find(cell.text.trim_matches(['[', ']', '(', ')'])).is_some())
}

/// Splits a heading into words and unit: `Deviation [µm]`, `dev_um`, `Abw. (mm)`, `Error/µm`.
#[must_use]
pub fn heading_of(text: &str) -> GridHeading {
    let written = text.trim().to_owned();
    let lower = written.to_lowercase();
    let bracket = lower.match_indices(['[', '(']).find_map(|(at, _)| {
        let inner = lower[at + 1..].split([']', ')']).next()?;
        Some((lower[..at].to_owned(), ReadingUnit::find(inner)?))
    });
    let after = || {
        let at = lower.rfind(['_', ' ', '/'])?;
        let unit =
            ReadingUnit::find(&lower[at + 1..]).filter(|unit| unit.sign().len() > 1 || lower[at + 1..].len() > 1)?;
        // `Ziel in mm`
        let words = lower[..at].strip_suffix(" in").unwrap_or(&lower[..at]);
        Some((words.to_owned(), unit))
    };
    let (words, unit) = match bracket.or_else(after) {
        Some((words, unit)) => (words, Some(unit)),
        None => (lower.clone(), None),
    };
    // The words of a sign stay in the heading as written.
    let words = match difference(&words).map(|_| without_difference(&words)) {
        Some(other) if other.is_empty() => "deviation".to_owned(),
        Some(other) => other,
        None => words,
    };
    GridHeading { words: words.trim_matches([' ', '.', ':', '_']).to_owned(), written, unit }
}

/// Decimal sign of the numbers of a table.
///
/// Between commas, a number with a comma was in quotation marks: `"2,4"`. There, English programs write thousands in this way too.
fn decimal_sign(rows: &[GridLine], separator: Separator) -> Result<DecimalSign, Box<Diagnostic>> {
    let mut is_sure = separator != Separator::Comma;
    let mut found: Option<(DecimalSign, &GridCell)> = None;
    for cell in rows.iter().flat_map(|row| &row.cells).filter(|cell| is_numeric(&cell.text)) {
        let sign = match (cell.text.rfind('.'), cell.text.rfind(',')) {
            (Some(point), Some(comma)) if point > comma => DecimalSign::Point,
            (Some(_), Some(_)) | (None, Some(_)) => DecimalSign::Comma,
            (Some(_), None) => DecimalSign::Point,
            (None, None) => continue,
        };
        is_sure |= sign == DecimalSign::Point || !may_be_thousands(&cell.text);
        match found {
            None => found = Some((sign, cell)),
            Some((other, first)) if other != sign => {
                let message = format!("'{}' has another decimal sign than '{}'", cell.text, first.text);
                let help = "write all numbers with one decimal sign and without separators of thousands";
                return Err(Box::new(Diagnostic::at(Code::DATA_CELL, place(cell), message, help)));
            }
            Some(_) => {}
        }
    }
    if let Some((DecimalSign::Comma, cell)) = found.filter(|_| !is_sure) {
        let message =
            format!("'{0}' may be {1} or {2}", cell.text, cell.text.replace(',', "."), cell.text.replace(',', ""));
        let help = "export the table with a decimal point, and without separators of thousands";
        return Err(Box::new(Diagnostic::at(Code::DATA_CELL, place(cell), message, help)));
    }
    Ok(found.map_or(DecimalSign::Point, |(sign, _)| sign))
}

/// Place of a cell, at least one byte wide.
#[must_use]
pub fn place(cell: &GridCell) -> Place {
    let mut span = cell.span;
    span.end = span.end.max(span.start.saturating_add(1));
    Place { file: FileId(0), span }
}

impl GridTable {
    /// Returns the number of columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.rows.first().map_or(self.headings.len(), |row| row.cells.len())
    }

    /// Returns the number in a cell; `None` if the cell is empty.
    ///
    /// # Errors
    /// A diagnostic if the cell is not a number.
    pub fn value(&self, row: &GridLine, column: usize) -> Result<Option<f64>, Box<Diagnostic>> {
        let Some(cell) = row.cells.get(column).filter(|cell| !is_missing(&cell.text)) else { return Ok(None) };
        let read = number(&cell.text, self.decimal);
        read.map(Some).ok_or_else(|| {
            let example = if self.decimal == DecimalSign::Comma { "12,5" } else { "12.5" };
            let message = format!("'{}' is not a number of this table", cell.text);
            Box::new(Diagnostic::at(
                Code::DATA_CELL,
                place(cell),
                message,
                format!("write a plain number such as {example}"),
            ))
        })
    }

    /// Returns the number in a cell that must have one.
    ///
    /// # Errors
    /// A diagnostic if the cell is empty or not a number.
    pub fn needed(&self, row: &GridLine, column: usize) -> Result<f64, Box<Diagnostic>> {
        self.value(row, column)?.ok_or_else(|| {
            let span = row.cells.get(column).map(place).or_else(|| row.cells.last().map(place)).unwrap_or_default();
            let name = self
                .headings
                .get(column)
                .map_or_else(|| format!("column {}", column + 1), |heading| heading.written.clone());
            Box::new(Diagnostic::at(
                Code::DATA_CELL,
                span,
                format!("the cell of '{name}' is empty"),
                "write the number, or remove the row",
            ))
        })
    }
}

/// True for a cell without a reading.
fn is_missing(text: &str) -> bool {
    matches!(text.to_lowercase().as_str(), "" | "-" | "--" | "---" | "nan" | "n/a" | "." | "=====")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<GridTable, Box<Diagnostic>> {
        table(&DecodedText::of_text("a.csv", text, "UTF-8").unwrap())
    }

    #[test]
    fn separators_and_decimal_signs_are_found() {
        for (text, separator, value) in [
            ("Target;1+;1-\n0;0,5;1,5\n100;2,5;3,5\n", Separator::Semicolon, 2.5),
            ("Target,1+,1-\n0,0.5,1.5\n100,2.5,3.5\n", Separator::Comma, 2.5),
            ("Target\t1+\t1-\n0\t0,5\t1,5\n100\t2,5\t3,5\n", Separator::Tab, 2.5),
            ("Machine: A, B\n\n0 0,5 1,5\n100 2,5 3,5\n", Separator::Blanks, 2.5),
            (
                "A report, 3 runs\n\n| Target | 1+ | 1- |\n|---|--:|:-:|\n| 0 | 0,5 | 1,5 |\n| 100 | 2,5 | 3,5 |\n",
                Separator::Bar,
                2.5,
            ),
        ] {
            let table = of(text).unwrap();
            assert_eq!(table.separator, separator, "{text}");
            assert_eq!(table.rows.len(), 2, "{text}");
            assert_eq!(table.value(&table.rows[1], 1).unwrap(), Some(value), "{text}");
        }
    }

    #[test]
    fn blanks_in_the_cells_of_a_written_separator_are_no_separators() {
        let table = of("id\tactual\tnominal\thole\nX 1\t0.5\t0\tHole 1\nX 2\t1.5\t1\tHole 2\n").unwrap();
        assert_eq!((table.separator, table.width(), table.headings.len()), (Separator::Tab, 4, 4));
    }

    #[test]
    fn one_number_never_becomes_two_cells() {
        let found = of("Target,Deviation\n0,0.5\n100,1,5\n200,2.5\n").unwrap_err();
        assert_eq!(found.code, Code::DATA_NO_TABLE);
        assert!(found.message.contains("line 3 has 3 cells"), "{}", found.message);
    }

    #[test]
    fn thousands_need_their_proof() {
        assert_eq!(number("1.234,56", DecimalSign::Comma), Some(1234.56));
        assert_eq!(number("1,234.56", DecimalSign::Point), Some(1234.56));
        assert_eq!(number("1,234", DecimalSign::Point), None);
        let found = of("Target;Deviation\n1.234;0,5\n100;1,5\n").unwrap_err();
        assert_eq!(found.code, Code::DATA_CELL);
    }

    #[test]
    fn pairs_above_a_table_of_two_columns_are_not_its_headings() {
        for pairs in
            ["Machine;VMC\nAxis;X\n", "Axis;X\nFeed;1000\n", "Feed;1000\nDwell;4\nAxis;X\n", "Serial no;17\n\n", ""]
        {
            for title in ["Target [mm];Deviation [um]\n", "Target;Deviation\n[mm];[um]\n"] {
                let table = of(&format!("{pairs}{title}0;0.0\n100;1.2\n200;2.5\n")).unwrap();
                let headings: Vec<&str> = table.headings.iter().map(|one| one.words.as_str()).collect();
                assert_eq!(
                    (headings.as_slice(), table.rows.len()),
                    (["target", "deviation"].as_slice(), 3),
                    "{pairs}{title}"
                );
            }
        }
        // Filled up to the width of the table, as a spreadsheet writes it.
        let table = of("Machine;VMC;\nAxis;X;\nTarget;Run 1;Run 2\n0;0.0;0.1\n100;1.2;1.3\n").unwrap();
        assert_eq!((table.headings[2].written.as_str(), table.rows.len()), ("Run 2", 2));
    }

    #[test]
    fn statistics_are_not_readings() {
        let table = of("Target;1+;1-\n0;0,5;1,5\n100;2,5;3,5\nMean;1,5;2,5\n").unwrap();
        assert_eq!((table.rows.len(), table.skipped), (2, vec![4]));
    }

    #[test]
    fn units_come_from_brackets_endings_and_a_line_of_their_own() {
        assert_eq!(heading_of("Abw. [µm]").unit.map(ReadingUnit::sign), Some("um"));
        assert_eq!(heading_of("dev_um").words, "dev");
        assert_eq!(heading_of("Error (mm)").words, "error");
        let table = of("Target;Deviation\nmm;µm\n0;0,5\n100;2,5\n").unwrap();
        assert_eq!(table.headings[1].unit.map(ReadingUnit::sign), Some("um"));
        assert_eq!(table.rows.len(), 2);
    }
}
