//! Writes the files of compensation tables, their picture and their page: all of them, or none.

use std::path::{Path, PathBuf};

use crate::diagnostics::Diagnostics;
use crate::disk::atomic_writes::AtomicWrites;
use crate::disk::output::{Target, protect};
use crate::disk::{files, pages};
use crate::error::Error;
use ncfix_base::source::FileId;
use ncfix_report::page;
use ncfix_report::tables::{TablesReport, charts, picture};
use ncfix_tables::tables::Tables;

/// The outputs beside the tables.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TableOutputs<'a> {
    /// The picture.
    pub(crate) svg: Option<&'a Path>,
    /// The page.
    pub(crate) report: Option<&'a Path>,
    /// True if standard output has a JSON object.
    pub(crate) is_json: bool,
}

impl TableOutputs<'_> {
    /// Writes all files and the picture, or none; `inputs` are the files that must not be overwritten.
    ///
    /// # Errors
    /// If two outputs go to the same place, or a file cannot be written.
    pub(crate) fn publish(
        &self,
        mut texts: Vec<(PathBuf, String)>,
        sets: &[(&str, &Tables)],
        inputs: &[PathBuf],
        report: &mut TablesReport,
        found: &mut Diagnostics,
    ) -> Result<(), Error> {
        if found.has_errors() {
            return Ok(());
        }
        if let Some(path) = self.svg {
            texts.push((path.to_path_buf(), picture(sets)));
        }
        let mut together = AtomicWrites::default();
        for (path, text) in &texts {
            let target = Target::new(path)?;
            if self.is_json && target == Target::Standard {
                let message = "--json and the tables cannot both go to standard output; give -o a file";
                return Err(Error::usage(message.into()));
            }
            protect(&target, inputs, found);
            if found.has_errors() {
                return Ok(());
            }
            together.add(target, text.as_bytes())?;
        }
        let page = self.report.map(pages::file).transpose()?;
        if let Some(page) = &page {
            protect(page, inputs, found);
            if let Some((path, _)) = texts.iter().find(|(path, _)| page.is(path) || Some(path.as_path()) == self.report)
            {
                return Err(Error::usage(format!("--report and {} name the same file", path.display())));
            }
        }
        if found.has_errors() {
            return Ok(());
        }
        report.written = texts.iter().map(|(path, _)| path.display().to_string()).collect();
        if let (Some(page), Some(path)) = (page, self.report) {
            report.diagnostics = found.json();
            let mut all = Vec::new();
            for path in inputs {
                all.push(pages::input(&files::read(path, FileId(0), "file")?, "read"));
            }
            together.add(page, page::tables::tables(report, &charts(sets), &all).as_bytes())?;
            report.written.push(path.display().to_string());
        }
        together.publish()
    }
}
