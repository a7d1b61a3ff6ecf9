//! Files of pages and their pictures: `--report` and `--svg`.

use std::io;
use std::path::{Path, PathBuf};

use super::arguments::PageChoice;
use super::atomic_writes::AtomicWrites;
use super::input::is_standard_stream;
use super::output::{Target, is_same};
use super::stop::Stop;
pub(super) use crate::disk::hash::input_of as input;
use ncfix_report::page::apart::pictures;

/// Requested page and pictures.
#[derive(Debug)]
pub(super) struct Pages {
    page: Option<Target>,
    pictures: Option<PathBuf>,
}

impl Pages {
    /// The request, if any; `output` is the other file that is written.
    ///
    /// # Errors
    /// If it cannot be written there.
    pub(super) fn new(choice: &PageChoice, output: Option<&Path>, json: bool) -> Result<Option<Pages>, Stop> {
        let page = target(choice.report.as_deref(), output, json)?;
        let pictures = choice.svg.clone();
        if let Some(folder) = pictures.as_deref().filter(|folder| folder.exists() && !folder.is_dir()) {
            return Err(Stop::Usage(format!("--svg needs a folder, but {} is not a folder", folder.display())));
        }
        if pictures.as_deref().is_some_and(is_standard_stream) {
            return Err(Stop::Usage("--svg needs a folder, not standard output: there are several pictures".into()));
        }
        if let Some(folder) = &pictures {
            let is_folder = |path: &Path| is_same(folder, path) || path == folder;
            if output.into_iter().chain(choice.report.as_deref()).any(is_folder) {
                return Err(Stop::Usage(format!(
                    "--svg needs a folder of its own, but {} is also another output",
                    folder.display()
                )));
            }
        }
        Ok((page.is_some() || pictures.is_some()).then_some(Pages { page, pictures }))
    }

    /// The file of the page, which must not be an input.
    pub(super) fn target(&self) -> Option<&Target> {
        self.page.as_ref()
    }

    /// Adds the page to the files to write, and its pictures in their folder, which is made if missing.
    ///
    /// # Errors
    /// If that is not possible.
    pub(super) fn add(self, page: &str, to: &mut AtomicWrites) -> Result<(), Stop> {
        if let Some(folder) = &self.pictures {
            let fault = |error: &io::Error| Stop::file("write", folder, error);
            std::fs::create_dir_all(folder).map_err(|error| fault(&error))?;
            for one in pictures(page) {
                to.add(Target::new(&folder.join(one.name))?, one.text.as_bytes())?;
            }
        }
        Ok(self.page.map_or(Ok(()), |target| to.add(target, page.as_bytes()))?)
    }

    /// Writes the page and the pictures alone.
    ///
    /// # Errors
    /// If that is not possible.
    pub(super) fn publish(self, page: &str) -> Result<(), Stop> {
        let mut together = AtomicWrites::default();
        self.add(page, &mut together)?;
        Ok(together.publish()?)
    }
}

/// Target of the page.
fn target(report: Option<&Path>, output: Option<&Path>, json: bool) -> Result<Option<Target>, Stop> {
    let Some(path) = report else { return Ok(None) };
    if is_standard_stream(path) && (json || output.is_some_and(is_standard_stream)) {
        return Err(Stop::Usage("standard output is already in use; give --report a file".into()));
    }
    let target = Target::new(path)?;
    if !is_standard_stream(path) && output.is_some_and(|output| target.is(output) || path == output) {
        return Err(Stop::Usage("--report and -o name the same file".into()));
    }
    Ok(Some(target))
}

/// Target of a page that cannot go to standard output.
///
/// # Errors
/// If it cannot be written there.
pub(super) fn file(path: &Path) -> Result<Target, Stop> {
    if is_standard_stream(path) {
        return Err(Stop::Usage("a page needs a file, not standard output".into()));
    }
    Ok(Target::new(path)?)
}

/// Writes a text as a whole.
///
/// # Errors
/// If it cannot be written.
pub(super) fn publish(target: Target, text: &str) -> Result<(), Stop> {
    let mut together = AtomicWrites::default();
    together.add(target, text.as_bytes())?;
    Ok(together.publish()?)
}
