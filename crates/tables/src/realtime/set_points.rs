//! Set-points and orders as lines of text, read one by one as they arrive.

use std::io::{BufRead, Read as _};

use ncfix_base::geometry::{AXES, Axis, AxisSet, AxisVector};

/// Maximum bytes of a line: nine numbers need far less.
const LONGEST: u64 = 4096;

/// Content of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum ControlLine {
    /// A set-point, mm and rad.
    SetPoint(AxisVector),
    /// `tool 120` or `tool 0,0,-120`: another tool is in the spindle; its length, or its vector, mm (Spaan 1995, Fig. 6.2, process 2).
    Tool(Vec<f64>),
    /// `head vertical 80`: another head is active, with the length or the vector of its tool, mm.
    Head(String, Vec<f64>),
    /// `reset`: an axis was referenced, so the control has dropped all corrections (process 5).
    Reset,
}

/// Reason why there is no next set-point.
#[derive(Debug)]
pub enum NoSetPoint {
    /// The input cannot be read.
    Unreadable(std::io::Error),
    /// A line is not a set-point.
    Wrong {
        /// The line, from 1.
        line: u64,
        /// The byte in it, from 1.
        column: usize,
        /// The reason.
        what: String,
    },
}

/// Format of a line.
#[derive(Clone, Debug)]
enum Form {
    /// With axis letters; axes that are left out stay.
    Words,
    /// In columns.
    Table(Vec<Axis>, char),
}

/// The set-points of a text, mm and degrees: words with axis letters, or a table whose first line has the letters. Orders may stand between them, and
/// before them.
#[derive(Debug)]
pub struct SetPointLines<R: BufRead> {
    input: R,
    axes: AxisSet,
    form: Option<Form>,
    buffer: Vec<u8>,
    line: u64,
    last: AxisVector,
    known: AxisSet,
}

impl<R: std::io::Read> SetPointLines<std::io::BufReader<R>> {
    /// `true` if a further whole line has already arrived.
    #[must_use]
    pub fn has_more(&self) -> bool {
        self.input.buffer().contains(&b'\n')
    }
}

impl<R: BufRead> SetPointLines<R> {
    /// Set-points of these axes, each of which must be stated.
    #[must_use]
    pub fn new(input: R, axes: AxisSet) -> SetPointLines<R> {
        let buffer = Vec::new();
        SetPointLines { input, axes, form: None, buffer, line: 0, last: AxisVector::ZERO, known: AxisSet::EMPTY }
    }

    /// The next set-point or order; `None` at the end.
    ///
    /// # Errors
    /// An error if the line is neither.
    pub fn next_line(&mut self) -> Result<Option<ControlLine>, NoSetPoint> {
        while self.read()? {
            let text = String::from_utf8_lossy(&self.buffer).into_owned();
            let text = text.trim_end();
            if let Some(order) = self.order(text)? {
                return Ok(Some(order));
            }
            let form = match self.form.clone() {
                Some(form) => form,
                None => match self.heading(text)? {
                    Some(form) => {
                        self.form = Some(form);
                        continue;
                    }
                    None => self.form.insert(Form::Words).clone(),
                },
            };
            match form {
                Form::Words => self.words(text)?,
                Form::Table(columns, separator) => self.row(text, &columns, separator)?,
            }
            return Ok(Some(ControlLine::SetPoint(self.last)));
        }
        Ok(None)
    }

    /// The order of a line, if it begins with the word of one.
    fn order(&self, text: &str) -> Result<Option<ControlLine>, NoSetPoint> {
        let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let column = text.len() - rest.trim_start().len() + 1;
        match word {
            "reset" if rest.trim().is_empty() => Ok(Some(ControlLine::Reset)),
            "reset" => Err(self.wrong(column, "reset stands alone")),
            "tool" => self.tool(rest, column).map(|numbers| Some(ControlLine::Tool(numbers))),
            "head" => {
                let Some((name, tool)) = rest.trim().rsplit_once(char::is_whitespace) else {
                    return Err(self.wrong(column, "head needs a name and a tool, such as: head vertical 80"));
                };
                let column = text.len() - tool.len() + 1;
                self.tool(tool, column).map(|numbers| Some(ControlLine::Head(name.trim().to_owned(), numbers)))
            }
            _ => Ok(None),
        }
    }

    /// The length or the vector of a tool, at a column.
    fn tool(&self, text: &str, column: usize) -> Result<Vec<f64>, NoSetPoint> {
        let number = |part: &str| part.trim().parse().ok().filter(|value: &f64| value.is_finite());
        let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
        let what = || format!("'{}' is neither a length nor a vector, such as 120 or 0,0,-120", text.trim());
        numbers.filter(|numbers| [1, 3].contains(&numbers.len())).ok_or_else(|| self.wrong(column, what()))
    }

    /// Reads a line; `false` at the end.
    fn read(&mut self) -> Result<bool, NoSetPoint> {
        self.buffer.clear();
        let mut limited = (&mut self.input).take(LONGEST);
        let count = limited.read_until(b'\n', &mut self.buffer).map_err(NoSetPoint::Unreadable)?;
        self.line += 1;
        if count as u64 == LONGEST && self.buffer.last() != Some(&b'\n') {
            return Err(self.wrong(1, format!("the line has more than {LONGEST} bytes")));
        }
        Ok(count > 0)
    }

    fn wrong(&self, column: usize, what: impl Into<String>) -> NoSetPoint {
        NoSetPoint::Wrong { line: self.line, column, what: what.into() }
    }

    /// The columns of a first line with axis letters and without numbers.
    fn heading(&self, text: &str) -> Result<Option<Form>, NoSetPoint> {
        if text.bytes().any(|byte| byte.is_ascii_digit()) || text.trim().is_empty() {
            return Ok(None);
        }
        let separator = [',', ';', '\t'].into_iter().find(|&separator| text.contains(separator)).unwrap_or(',');
        let mut columns = Vec::new();
        for (start, cell) in cells(text, separator) {
            let letter = cell.split('_').next().unwrap_or_default().trim().as_bytes();
            let axis = if let [letter] = letter { Axis::from_letter(*letter) } else { None };
            let axis = axis.filter(|&axis| self.axes.contains(axis));
            let unit = cell.split_once('_').map(|(_, unit)| unit.trim());
            match (axis, unit) {
                (Some(axis), None) => columns.push(axis),
                (Some(axis), Some("mm")) if !axis.is_rotary() => columns.push(axis),
                (Some(axis), Some("deg")) if axis.is_rotary() => columns.push(axis),
                _ => {
                    let what = format!("'{}' is not an axis of the machine ({})", cell.trim(), letters(self.axes));
                    return Err(self.wrong(start, what));
                }
            }
        }
        let stated: AxisSet = columns.iter().copied().collect();
        if stated.iter().count() != columns.len() {
            return Err(self.wrong(1, "an axis has two columns"));
        }
        self.demand(stated)?;
        Ok(Some(Form::Table(columns, separator)))
    }

    /// Checks that every axis is stated.
    fn demand(&self, stated: AxisSet) -> Result<(), NoSetPoint> {
        let missing = self.axes.difference(stated);
        if missing.is_empty() {
            return Ok(());
        }
        Err(self.wrong(1, format!("the position of {} is not stated", letters(missing))))
    }

    fn row(&mut self, text: &str, columns: &[Axis], separator: char) -> Result<(), NoSetPoint> {
        let mut count = 0;
        for (start, cell) in cells(text, separator) {
            let Some(&axis) = columns.get(count) else {
                return Err(self.wrong(start, format!("there are more cells than the {} columns", columns.len())));
            };
            self.set(axis, cell.trim(), start + (cell.len() - cell.trim_start().len()))?;
            count += 1;
        }
        if count < columns.len() {
            return Err(self.wrong(text.len() + 1, format!("there are {count} cells for {} columns", columns.len())));
        }
        Ok(())
    }

    fn words(&mut self, text: &str) -> Result<(), NoSetPoint> {
        let is_gap = |c: char| c.is_whitespace() || c == ',';
        let mut stated = AxisSet::EMPTY;
        let mut rest = text;
        loop {
            rest = rest.trim_start_matches(is_gap);
            let column = text.len() - rest.len() + 1;
            let word = rest.split(is_gap).next().unwrap_or_default();
            let Some(letter) = word.chars().next() else { break };
            rest = &rest[word.len()..];
            let axis = u8::try_from(letter).ok().and_then(Axis::from_letter).filter(|&axis| self.axes.contains(axis));
            let Some(axis) = axis else {
                let what = format!("'{word}' is not a word of an axis of the machine ({})", letters(self.axes));
                return Err(self.wrong(column, what));
            };
            if stated.contains(axis) {
                return Err(self.wrong(column, format!("{axis} is given twice")));
            }
            stated.insert(axis);
            let number = word[1..].strip_prefix('=').unwrap_or(&word[1..]);
            self.set(axis, number, column + word.len() - number.len())?;
        }
        if stated.is_empty() {
            return Err(self.wrong(1, "the line is empty"));
        }
        self.known = self.known.union(stated);
        self.demand(self.known)
    }

    fn set(&mut self, axis: Axis, number: &str, column: usize) -> Result<(), NoSetPoint> {
        let value: Option<f64> = number.parse().ok().filter(|value: &f64| value.is_finite());
        let value = value.ok_or_else(|| self.wrong(column, format!("'{number}' is not a number")))?;
        self.last[axis] = if axis.is_rotary() { value.to_radians() } else { value };
        Ok(())
    }
}

/// The cells of a line with their columns, from 1.
fn cells(text: &str, separator: char) -> impl Iterator<Item = (usize, &str)> {
    let mut start = 1;
    text.split(separator).map(move |cell| {
        let here = start;
        start += cell.len() + separator.len_utf8();
        (here, cell)
    })
}

/// `X Y Z`.
fn letters(axes: AxisSet) -> String {
    let all = AXES.into_iter().filter(|&axis| axes.contains(axis));
    all.map(|axis| axis.to_string()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The set-points of X, Y and C in degrees, and the position and reason of the end.
    fn read(text: &str) -> (Vec<[f64; 3]>, Option<String>) {
        let axes = [Axis::X, Axis::Y, Axis::C].into_iter().collect();
        let mut lines = SetPointLines::new(text.as_bytes(), axes);
        let mut all = Vec::new();
        loop {
            match lines.next_line() {
                Ok(Some(ControlLine::SetPoint(at))) => {
                    all.push([at[Axis::X], at[Axis::Y], at[Axis::C].to_degrees().round()])
                }
                Ok(Some(ControlLine::Tool(numbers))) => all.push([numbers[0], numbers.len() as f64, -1.0]),
                Ok(Some(ControlLine::Reset)) => all.push([0.0, 0.0, -2.0]),
                Ok(Some(ControlLine::Head(..))) => all.push([0.0, 0.0, -3.0]),
                Ok(None) => return (all, None),
                Err(NoSetPoint::Wrong { line, column, what }) => {
                    return (all, Some(format!("{line}:{column}: {what}")));
                }
                Err(NoSetPoint::Unreadable(error)) => panic!("{error}"),
            }
        }
    }

    #[test]
    fn words_stay_and_columns_do_not() {
        assert_eq!(read("X1 Y=2.5,C90\nY-3\r\n"), (vec![[1.0, 2.5, 90.0], [1.0, -3.0, 90.0]], None));
        assert_eq!(read("C_deg;X;Y_mm\n90; 1;2.5\n"), (vec![[1.0, 2.5, 90.0]], None));
        assert_eq!(read(""), (vec![], None));
    }

    #[test]
    fn orders_stand_before_and_between_set_points() {
        let (tool, reset) = ([120.0, 1.0, -1.0], [0.0, 0.0, -2.0]);
        let point = [1.0, 2.0, 90.0];
        assert_eq!(read("tool 120\nX1 Y2 C90\nreset\nX1\n"), (vec![tool, point, reset, point], None));
        assert_eq!(
            read("tool 120\nX,Y,C\n1,2,90\ntool 5, 6,-70\r\n1,2,90\n").0,
            [tool, point, [5.0, 3.0, -1.0], point]
        );
    }

    #[test]
    fn what_is_no_set_point_has_its_place() {
        for (text, fault) in [
            ("tool\n", "1:5: '' is neither a length nor a vector, such as 120 or 0,0,-120"),
            ("tool 1,2\n", "1:6: '1,2' is neither a length nor a vector, such as 120 or 0,0,-120"),
            ("tool inf\n", "1:6: 'inf' is neither a length nor a vector, such as 120 or 0,0,-120"),
            ("reset X\n", "1:7: reset stands alone"),
            ("X1 Y2\n", "1:1: the position of C is not stated"),
            ("X1 Y2 C0\nX1 Zs\n", "2:4: 'Zs' is not a word of an axis of the machine (X Y C)"),
            ("X1 Y2 C0\nX1o\n", "2:2: '1o' is not a number"),
            ("X1 Y2 C0\nX=nan\n", "2:3: 'nan' is not a number"),
            ("X1 Y2 C0\n\n", "2:1: the line is empty"),
            ("X1 X2 Y2 C0\n", "1:4: X is given twice"),
            ("X,Y,Z\n", "1:5: 'Z' is not an axis of the machine (X Y C)"),
            ("X,Y,C_mm\n", "1:5: 'C_mm' is not an axis of the machine (X Y C)"),
            ("X,Y\n", "1:1: the position of C is not stated"),
            ("X,Y,C\n1,2\n", "2:4: there are 2 cells for 3 columns"),
            ("X,Y,C\n1,2,3,4\n", "2:7: there are more cells than the 3 columns"),
            ("X,Y,C\n1, ä,3\n", "2:4: 'ä' is not a number"),
            ("é1 Y2\n", "1:1: 'é1' is not a word of an axis of the machine (X Y C)"),
        ] {
            assert_eq!(read(text).1.as_deref(), Some(fault), "{text}");
        }
        assert!(read(&"X".repeat(5000)).1.unwrap().contains("more than 4096 bytes"));
    }
}
