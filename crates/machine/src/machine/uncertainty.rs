//! Standard uncertainties of the numbers of the error model: `[uncertainty]`.
//!
//! A number is the standard uncertainty of one parameter, independent of the others. A list is a row of a factor of the covariance: the list entries are
//! effects of independent causes of unit variance, which all lists share. `ncfix calibrate` writes lists, and a person may write numbers.

use std::collections::BTreeMap;

use super::document::TomlValue;
use super::edit::{Edit, Given};
use super::section::Section;
use ncfix_base::diagnostic::{Code, Diagnostic};

/// Name of the section.
pub const SECTION: &str = "uncertainty";
/// Key of the error that the fitted model does not contain.
pub const UNEXPLAINED: &str = "unexplained_um";
/// Maximum length of a list: the number of independent causes.
const MOST_CAUSES: usize = 256;
/// Maximum number of parameters.
const MOST_PARAMETERS: usize = 1024;
/// Largest plausible number, in the unit of the file.
const LARGEST: f64 = 1e6;
/// Significant digits of a written row: strongly correlated rows need more than a person reads.
const DIGITS: i32 = 7;

/// Uncertainty of one parameter, in the unit of its number in the file.
#[derive(Clone, Debug, PartialEq)]
pub enum UncertaintyRow {
    /// Standard uncertainty, independent of all other parameters.
    Alone(f64),
    /// Effects of the shared causes, in their order; the standard uncertainty is the root of the sum of squares.
    Shared(Vec<f64>),
}

/// Standard uncertainties of an error model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Uncertainty {
    /// Parameters by their names: `EC0Y`, `EXX1`, `EXXb`, `load.EAX.coefficients[1]`, and whole motion errors: `EXX`.
    pub rows: BTreeMap<String, UncertaintyRow>,
    /// Error of the tool tip that the fitted model does not contain, root mean square of one direction, µm.
    pub unexplained_um: Option<f64>,
}

impl UncertaintyRow {
    /// Returns the standard uncertainty, in the unit of the file.
    #[must_use]
    pub fn sigma(&self) -> f64 {
        match self {
            UncertaintyRow::Alone(sigma) => *sigma,
            UncertaintyRow::Shared(row) => row.iter().map(|part| part * part).sum::<f64>().sqrt(),
        }
    }
}

impl Uncertainty {
    /// Returns the number of causes that lists share.
    #[must_use]
    pub fn causes(&self) -> usize {
        self.shared().map(|row| row.len()).max().unwrap_or(0)
    }

    /// Returns `true` if two parameters have a cause in common.
    #[must_use]
    pub fn is_correlated(&self) -> bool {
        let has = |row: &&Vec<f64>, cause: usize| row.get(cause).is_some_and(|part| *part != 0.0);
        (0..self.causes()).any(|cause| self.shared().filter(|row| has(row, cause)).nth(1).is_some())
    }

    fn shared(&self) -> impl Iterator<Item = &Vec<f64>> {
        self.rows.values().filter_map(|row| match row {
            UncertaintyRow::Shared(row) => Some(row),
            UncertaintyRow::Alone(_) => None,
        })
    }

    /// Takes in the rows of a new fit: they replace those of the same parameters, and share no cause with the others.
    pub fn extend_by(&mut self, fitted: Vec<(String, Vec<f64>)>) {
        fitted.iter().for_each(|(name, _)| {
            self.rows.remove(name);
        });
        // Causes that concern no parameter any more are dropped.
        let count = self.causes();
        let is_used = |cause: &usize| self.shared().any(|row| row.get(*cause).is_some_and(|part| *part != 0.0));
        let used: Vec<usize> = (0..count).filter(is_used).collect();
        for row in self.rows.values_mut() {
            if let UncertaintyRow::Shared(row) = row {
                let kept: Vec<f64> = used.iter().map(|&cause| row.get(cause).copied().unwrap_or(0.0)).collect();
                *row = without_end(kept);
            }
        }
        for (name, own) in fitted {
            let row = vec![0.0; used.len()].into_iter().chain(own.into_iter().map(rounded)).collect();
            self.rows.insert(name, UncertaintyRow::Shared(without_end(row)));
        }
    }

    /// Returns the text of a machine file with these uncertainties; `None` if the section cannot be written.
    #[must_use]
    pub fn written_into(&self, text: &str) -> Option<String> {
        let mut edit = Edit::parse(text)?;
        let unexplained = self.unexplained_um.map(|um| (UNEXPLAINED.to_owned(), Given::Number(um)));
        let rows = self.rows.iter().map(|(name, row)| {
            let given = match row {
                UncertaintyRow::Alone(sigma) => Given::Number(*sigma),
                UncertaintyRow::Shared(row) => Given::Numbers(row.clone()),
            };
            (name.clone(), given)
        });
        unexplained.into_iter().chain(rows).all(|(key, given)| edit.set(SECTION, &key, &given)).then(|| edit.text())
    }
}

/// Rounds to the digits of the file.
fn rounded(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return 0.0;
    }
    format!("{value:.*e}", DIGITS.unsigned_abs() as usize - 1).parse().unwrap_or(value)
}

/// Removes zeros at the end; one entry stays.
fn without_end(mut row: Vec<f64>) -> Vec<f64> {
    while row.len() > 1 && row.last().is_some_and(|last| *last == 0.0) {
        row.pop();
    }
    row
}

/// Reads `[uncertainty]`. Names are checked where the error model is known.
pub(super) fn read(mut section: Section<'_>, findings: &mut Vec<Diagnostic>) -> Uncertainty {
    let mut found = Uncertainty::default();
    if section.has(UNEXPLAINED) {
        found.unexplained_um = section.number_where(UNEXPLAINED, "a number that is not negative", |um| um >= 0.0);
    }
    let keys: Vec<&str> = section.keys().filter(|key| *key != UNEXPLAINED).collect();
    if keys.len() > MOST_PARAMETERS {
        let message = format!("[uncertainty] has {} parameters, more than {MOST_PARAMETERS}", keys.len());
        section.report(Code::OUT_OF_RANGE, section.place(), message, "calibrate with fewer parameters");
        keys.into_iter().for_each(|key| section.accept(key));
        section.finish(findings);
        return found;
    }
    for key in keys {
        let is_plausible = |part: &f64| part.abs() <= LARGEST;
        let expected = "a standard uncertainty that is not negative, or a list of numbers";
        let row = section.value(key, expected, |item| match &item.value {
            TomlValue::Items(items) => {
                let row: Option<Vec<f64>> = items.iter().map(|item| item.number()).collect();
                row.filter(|row| !row.is_empty()).map(UncertaintyRow::Shared)
            }
            _ => item.number().filter(|&sigma| sigma >= 0.0).map(UncertaintyRow::Alone),
        });
        let Some(row) = row else { continue };
        let (length, is_right) = match &row {
            UncertaintyRow::Alone(sigma) => (1, is_plausible(sigma)),
            UncertaintyRow::Shared(row) => (row.len(), row.iter().all(is_plausible)),
        };
        if length > MOST_CAUSES || !is_right {
            let message = format!("{key} must have at most {MOST_CAUSES} numbers, none larger than {LARGEST}");
            let help = "write the standard uncertainty in the unit of the number that it belongs to";
            section.report(Code::OUT_OF_RANGE, section.place_of(key), message, help);
            continue;
        }
        found.rows.insert(key.to_owned(), row);
    }
    section.finish(findings);
    found
}

#[cfg(test)]
mod tests {
    use super::super::document::Document;
    use super::*;
    use ncfix_base::source::{FileId, Source};

    fn read_text(text: &str) -> (Uncertainty, Vec<Diagnostic>) {
        let source = Source::new(FileId(0), "m.toml", text.as_bytes().to_vec()).unwrap();
        let document = Document::parse(&source).unwrap();
        let mut findings = Vec::new();
        let found = read(document.root().section(SECTION).unwrap(), &mut findings);
        (found, findings)
    }

    #[test]
    fn a_new_fit_replaces_its_parameters_and_shares_no_cause_with_the_others() {
        let text = "[uncertainty]\nEC0X = 2   # by hand\nEC0Y = [3]\nEXX1 = [0, 4e-6]\nEZZ1 = [1e-6, 2e-6, 5e-6]\n";
        let (mut found, findings) = read_text(text);
        assert_eq!((findings.len(), found.causes(), found.rows["EC0X"].sigma()), (0, 3, 2.0));
        found.extend_by(vec![("EC0Y".into(), vec![1.0]), ("EZZ1".into(), vec![-6.0, 8.0])]);
        // Of the three causes only the second concerns a parameter that stays, EXX1.
        assert_eq!(found.rows["EXX1"], UncertaintyRow::Shared(vec![4e-6]));
        assert_eq!(found.rows["EZZ1"], UncertaintyRow::Shared(vec![0.0, -6.0, 8.0]));
        assert_eq!(found.rows["EZZ1"].sigma(), 10.0);
        let written = found.written_into(text).unwrap();
        assert!(written.contains("EC0X = 2.0   # by hand\n"), "{written}");
        let (again, findings) = read_text(&written);
        assert_eq!((findings.len(), again), (0, found));
    }

    #[test]
    fn wrong_entries_are_reported_at_their_place() {
        let text = "[uncertainty]\nEC0Y = -1\nEXX1 = []\nEYY1 = \"1\"\nEZZ1 = [1, true]\nEC0X = 1e7\nunexplained_um = -1\nEXXb = 1\n";
        let (found, findings) = read_text(text);
        assert_eq!(found.rows.keys().collect::<Vec<_>>(), ["EXXb"]);
        let mut seen: Vec<&str> = findings.iter().map(|found| found.code.as_str()).collect();
        seen.sort_unstable();
        assert_eq!(seen, ["E0404", "E0404", "E0404", "E0404", "E0404", "E0410"], "{findings:?}");
    }
}
