//! Columns that a reader does not read: each is listed, or the file is refused because its rows may not be of one kind.

use crate::differences::difference;
use crate::grid::{GridHeading, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::row_fact::{ColumnValues, RowFact, row_fact};
use crate::words::{self, ColumnRole};

impl Inquiry<'_> {
    /// Notes the columns that are not read. `headings` are those of the table, or of `--columns`.
    ///
    /// # Errors
    /// If one of them states what the reading of a row is, or divides the rows into groups, and `--columns` does not say that it is not read.
    pub(crate) fn unread(
        &mut self,
        table: &GridTable,
        headings: &[GridHeading],
        columns: &[usize],
    ) -> Result<(), ImportStop> {
        let mut names = Vec::new();
        for &column in columns {
            let Some(heading) = headings.get(column) else { continue };
            // Drivers go into the measurement, or are named there.
            if words::is_driver(&heading.written) || self.is_skipped(table, column) {
                continue;
            }
            self.check_fact(table, (column, heading))?;
            if !heading.written.is_empty() {
                names.push(heading.written.clone());
            }
        }
        if !names.is_empty() {
            self.note(format!("columns that are not read: {}", names.join(", ")), table.heading_line);
        }
        Ok(())
    }

    /// Checks that all features of a table were measured in one set-up with one sign. The coordinates of a feature say where it is.
    ///
    /// # Errors
    /// If a column divides them.
    pub(crate) fn check_places(&mut self, table: &GridTable) -> Result<(), ImportStop> {
        for (column, heading) in table.headings.iter().enumerate() {
            let is_place = matches!(row_fact(&heading.words), Some(RowFact::Place | RowFact::Sign));
            if is_place && !self.is_skipped(table, column) {
                self.check_fact(table, (column, heading))?;
            }
        }
        Ok(())
    }

    /// True if `--columns` says that a column is not read.
    fn is_skipped(&self, table: &GridTable, column: usize) -> bool {
        let given = &self.answers().columns;
        let is_skip = |text: &String| words::role(&text.trim().to_lowercase()) == ColumnRole::Skip;
        let is_said = given.len() == table.width() && given.get(column).is_some_and(is_skip);
        if is_said {
            self.answer("columns", |_| ());
        }
        is_said
    }

    /// Checks one column that is not read.
    ///
    /// # Errors
    /// If its cells change the meaning of the readings.
    fn check_fact(&self, table: &GridTable, (column, heading): (usize, &GridHeading)) -> Result<(), ImportStop> {
        /// Help for a column that has no effect.
        const SKIP: &str =
            "if the column has no effect on the readings, name all columns with --columns and write - for this one";
        let line = table.heading_line;
        let values = ColumnValues::of(table, column);
        let fact = row_fact(&heading.words);
        let is_name = words::role(&heading.words) == ColumnRole::Name;
        let divides = values.differ() && fact.is_some() || !is_name && values.are_groups();
        if divides {
            let written = &heading.written;
            let message =
                format!("the column '{written}' is not read, and its rows are of several kinds: {}", values.named());
            let help = format!("save the rows of each kind in a file of their own, and import all files; {SKIP}");
            return Err(self.refused(message, help, line));
        }
        if difference(&heading.written).is_some() {
            let message =
                format!("the column '{}' is not read, and its heading states a sign of readings", heading.written);
            return Err(self.refused(message, format!("name the readings with --columns; {SKIP}"), line));
        }
        if fact.is_some_and(|fact| fact.counts_alone()) && !values.distinct.is_empty() {
            let message = format!(
                "the column '{}' is not read, and it states what the readings are: {}",
                heading.written,
                values.named()
            );
            let help = "remove the column if it agrees with your options, or name all columns with --columns and write - for this one";
            return Err(self.refused(message, help, line));
        }
        Ok(())
    }
}
