//! Statements about the sign of readings: lines such as `Sign convention;target - actual`, and headings such as `Deviation (target - actual)`.
//!
//! A wrong sign doubles an error, so no such statement may be dropped. A difference of two known words decides the sign of a positioning; any other
//! statement needs an answer of a person.

use crate::differences::difference;
use crate::grid::{self, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::text::DecodedText;

/// Words of the sign in the key of a line.
const SIGN: &[&str] = &["sign", "signs", "polarity", "signe", "polarité", "segno", "polarità", "signo", "polaridad"];
/// Parts of German compounds of the sign.
const SIGN_PARTS: &[&str] = &["vorzeichen", "polarität"];
/// Parts of the words for a definition, and of those for an error: a line with both states a sign.
const DEFINITIONS: &[&str] = &["defini", "défini", "convention", "konvention", "convenzion", "convenci"];
const ERRORS: &[&str] =
    &["error", "deviation", "fehler", "abweich", "erreur", "écart", "ecart", "errore", "scostament", "desviaci"];

/// Meaning of a reading with a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignMeaning {
    /// Difference of the actual and the nominal value: words of a difference decide its sign.
    Difference,
    /// A direction of the tool or of a rotation: the mounting of the instrument decides too.
    Direction,
    /// The nominal and the actual values are in the file; the sign says where the features come from.
    Origin,
}

/// A sign with its line, and the line of a statement that needs a person.
pub(crate) type StatedSigns = (Option<(f64, usize)>, Option<usize>);

/// A statement about the sign.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SignStatement {
    /// 1 for actual minus nominal, -1 for nominal minus actual; `None` for other words.
    pub(crate) sign: Option<f64>,
    /// Line.
    pub(crate) line: usize,
}

/// True for the key of a line about the sign.
fn is_key(key: &str) -> bool {
    let key = key.to_lowercase();
    let mut tokens = key.split(|c: char| !c.is_alphanumeric());
    let has = |parts: &[&str]| parts.iter().any(|part| key.contains(part));
    tokens.any(|token| SIGN.contains(&token)) || has(SIGN_PARTS) || has(DEFINITIONS) && has(ERRORS)
}

/// All statements about the sign, in the order of their lines. `heading_line` is that of the table.
pub(crate) fn statements(text: &DecodedText, heading_line: usize) -> Vec<SignStatement> {
    let mut found = Vec::new();
    for (line, content, _) in text.lines() {
        let key = content.split([';', ':', '=', '\t', ',']).next().unwrap_or_default();
        let sign = difference(content);
        let has_value = key.len() < content.trim_end_matches([';', ':', '=', '\t', ',', ' ']).len();
        if line == heading_line {
            // Each heading is about its own column.
            let cells = content.split([';', '\t', ',', '|']).filter_map(difference);
            found.extend(cells.map(|sign| SignStatement { sign: Some(sign), line }));
        } else if sign.is_some() || has_value && is_key(key) {
            let is_iso = content.to_lowercase().replace(' ', "").contains("iso230");
            found.push(SignStatement { sign: sign.or(is_iso.then_some(1.0)), line });
        }
    }
    found
}

impl Inquiry<'_> {
    /// Sign of the readings. `proven` is what the columns themselves say, with their line; `question` describes a positive reading.
    ///
    /// # Errors
    /// If the option contradicts the file, or the file itself.
    pub fn sign(
        &mut self,
        proven: Option<(f64, usize)>,
        question: &str,
        meaning: SignMeaning,
    ) -> Result<f64, ImportStop> {
        self.is_origin |= meaning == SignMeaning::Origin;
        let (stated, open) = self.stated_sign(meaning)?;
        if let (Some((own, line)), Some((other, at))) = (proven, stated)
            && own != other
        {
            let message = format!("line {at} contradicts the readings, which are {}", how(own));
            return Err(self.refused(message, "correct the line, or the columns", at.max(line)));
        }
        let proven = proven.or(stated);
        if let Some(line) = open.filter(|_| meaning != SignMeaning::Origin) {
            if self.answers().sign.is_none() {
                let sentence = format!(
                    "line {line} is about the sign of the readings, and ncfix cannot evaluate it ('{}'); {}",
                    self.text.line(line).trim().replace(char::is_control, " "),
                    question.rsplit(": ").next().unwrap_or(question)
                );
                self.ask("sign", sentence, "+, or - for the opposite; answer for the readings as they are in the file");
                return Ok(1.0);
            }
            self.note("a line about the sign: --sign decides", line);
        }
        let sign = match (self.answer("sign", |own| own.sign), proven) {
            (Some(sign), Some((stated, line))) if sign != stated => {
                let [said, stated] = [sign, stated].map(|sign| if sign > 0.0 { "+" } else { "-" });
                let message = format!("--sign {said} contradicts the file, whose readings have the sign {stated}");
                return Err(self.refused(message, "remove --sign, or correct the file", line));
            }
            (Some(sign), _) => {
                let shown = if sign > 0.0 { "+" } else { "-" };
                self.note(format!("sign: --sign {shown}"), 0);
                sign
            }
            (None, Some((sign, line))) => {
                let reversed = if sign > 0.0 { "" } else { ": the sign is reversed" };
                self.note(format!("sign: {}{reversed}", how(sign)), line);
                sign
            }
            (None, None) => {
                self.ask("sign", question, "+, or - for the opposite");
                1.0
            }
        };
        Ok(sign)
    }

    /// Notes the lines about the sign that no reader has used, so that a person sees them.
    pub(crate) fn note_signs(&mut self) {
        if self.has_used("sign") && !self.is_origin {
            return;
        }
        for one in self.sign_statements() {
            self.note(
                "a line about a sign that is not used, because the positions and values in the file state it",
                one.line,
            );
        }
    }

    /// Statements of the file about the sign.
    pub(crate) fn sign_statements(&self) -> Vec<SignStatement> {
        statements(self.text, grid::table(self.text).map_or(0, |table| table.heading_line))
    }

    /// The sign by the statements of the file, with its line, and the line of a statement that needs a person.
    ///
    /// # Errors
    /// If two statements contradict each other.
    pub(crate) fn stated_sign(&self, meaning: SignMeaning) -> Result<StatedSigns, ImportStop> {
        let all = self.sign_statements();
        let mut known = all.iter().filter_map(|one| Some((one.sign?, one.line)));
        let first = known.next();
        if let (Some((sign, line)), Some((_, other))) =
            (first, known.find(|(sign, _)| first.is_some_and(|first| first.0 != *sign)))
        {
            let how = if sign > 0.0 { "actual minus nominal" } else { "nominal minus actual" };
            let message = format!("line {line} states {how}, and line {other} the opposite");
            return Err(self.refused(message, "readings of one file need one sign: correct the wrong line, or save the columns of each sign in a file of their own", other));
        }
        let unknown = all.iter().find(|one| one.sign.is_none()).map(|one| one.line);
        Ok(match meaning {
            SignMeaning::Difference => (first, unknown),
            SignMeaning::Direction | SignMeaning::Origin => (None, unknown.or(first.map(|(_, line)| line))),
        })
    }

    /// Checks that all columns of readings have one sign: the heading of each states it, or none does.
    ///
    /// # Errors
    /// If only some of them state it.
    pub(crate) fn check_signs(&self, table: &GridTable, columns: &[usize]) -> Result<(), ImportStop> {
        let of = |column: &usize| table.headings.get(*column).and_then(|heading| difference(&heading.written));
        let stated = columns.iter().find(|column| of(column).is_some());
        let other = columns.iter().find(|column| of(column).is_none());
        if let (Some(stated), Some(other)) = (stated, other) {
            let written = |column: usize| table.headings.get(column).map_or("", |heading| heading.written.as_str());
            let message = format!(
                "the column '{}' states its sign, and the column '{}' does not",
                written(*stated),
                written(*other)
            );
            let help = "write the sign into the headings of all readings, or save the columns of each sign in a file of their own";
            return Err(self.refused(message, help, table.heading_line));
        }
        Ok(())
    }
}

/// A sign in words.
fn how(sign: f64) -> &'static str {
    if sign > 0.0 { "actual minus nominal" } else { "nominal minus actual" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_about_the_sign_are_found() {
        let of = |text: &str| {
            let text = DecodedText::of_text("a.csv", text, "UTF-8").unwrap();
            statements(&text, grid::table(&text).map_or(0, |table| table.heading_line))
        };
        let rows = "Target;1+;1-\n0;0,5;0,6\n100;1,5;1,6\n";
        for (line, sign) in [
            ("Sign;reversed", None),
            ("Error definition;commanded minus measured", Some(-1.0)),
            ("Fehlerdefinition;siehe Handbuch", None),
            ("# polarity = inverted", None),
            ("Sign convention;ISO 230-2", Some(1.0)),
        ] {
            assert_eq!(of(&format!("{line}\n{rows}")), [SignStatement { sign, line: 1 }], "{line}");
        }
        for line in ["Design;A", "Signature;Meier", "Sign;", "Axis;X", "Definition;10 points"] {
            assert_eq!(of(&format!("{line}\n{rows}")), [], "{line}");
        }
    }
}
