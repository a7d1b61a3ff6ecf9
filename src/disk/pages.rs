//! Files of pages and their pictures: `--report` and `--svg`.

use std::io;
use std::path::{Path, PathBuf};

use super::atomic_writes::AtomicWrites;
use super::files::is_standard_stream;
pub(crate) use super::hash::input_of as input;
use super::output::{Target, is_same};
use crate::error::Error;
use ncfix_report::page::apart::pictures;

/// Requested page and pictures.
#[derive(Debug)]
pub(crate) struct Pages {
    page: Option<Target>,
    pictures: Option<PathBuf>,
}

impl Pages {
    /// The request for a page and a folder of pictures, if any; `output` is the other file that is written.
    ///
    /// # Errors
    /// If it cannot be written there.
    pub(crate) fn new(
        (report, svg): (Option<&Path>, Option<&Path>),
        output: Option<&Path>,
        json: bool,
    ) -> Result<Option<Pages>, Error> {
        let page = target(report, output, json)?;
        let pictures = svg.map(Path::to_path_buf);
        if let Some(folder) = pictures.as_deref().filter(|folder| folder.exists() && !folder.is_dir()) {
            return Err(Error::usage(format!("--svg needs a folder, but {} is not a folder", folder.display())));
        }
        if pictures.as_deref().is_some_and(is_standard_stream) {
            return Err(Error::usage("--svg needs a folder, not standard output: there are several pictures".into()));
        }
        if let Some(folder) = &pictures {
            let is_folder = |path: &Path| is_same(folder, path) || path == folder;
            if output.into_iter().chain(report).any(is_folder) {
                return Err(Error::usage(format!(
                    "--svg needs a folder of its own, but {} is also another output",
                    folder.display()
                )));
            }
        }
        Ok((page.is_some() || pictures.is_some()).then_some(Pages { page, pictures }))
    }

    /// The file of the page, which must not be an input.
    pub(crate) fn target(&self) -> Option<&Target> {
        self.page.as_ref()
    }

    /// Adds the page to the files to write, and its pictures in their folder, which is made if missing.
    ///
    /// # Errors
    /// If that is not possible.
    pub(crate) fn add(self, page: &str, to: &mut AtomicWrites) -> Result<(), Error> {
        if let Some(folder) = &self.pictures {
            let fault = |error: &io::Error| Error::file("write", folder, error);
            std::fs::create_dir_all(folder).map_err(|error| fault(&error))?;
            for one in pictures(page) {
                to.add(Target::new(&folder.join(one.name))?, one.text.as_bytes())?;
            }
        }
        self.page.map_or(Ok(()), |target| to.add(target, page.as_bytes()))
    }

    /// Writes the page and the pictures alone.
    ///
    /// # Errors
    /// If that is not possible.
    pub(crate) fn publish(self, page: &str) -> Result<(), Error> {
        let mut together = AtomicWrites::default();
        self.add(page, &mut together)?;
        together.publish()
    }
}

/// Target of the page.
fn target(report: Option<&Path>, output: Option<&Path>, json: bool) -> Result<Option<Target>, Error> {
    let Some(path) = report else { return Ok(None) };
    if is_standard_stream(path) && (json || output.is_some_and(is_standard_stream)) {
        return Err(Error::usage("standard output is already in use; give --report a file".into()));
    }
    let target = Target::new(path)?;
    if !is_standard_stream(path) && output.is_some_and(|output| target.is(output) || path == output) {
        return Err(Error::usage("--report and -o name the same file".into()));
    }
    Ok(Some(target))
}

/// Target of a page that cannot go to standard output.
///
/// # Errors
/// If it cannot be written there.
pub(crate) fn file(path: &Path) -> Result<Target, Error> {
    if is_standard_stream(path) {
        return Err(Error::usage("a page needs a file, not standard output".into()));
    }
    Target::new(path)
}

/// Writes a text as a whole.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn publish(target: Target, text: &str) -> Result<(), Error> {
    let mut together = AtomicWrites::default();
    together.add(target, text.as_bytes())?;
    together.publish()
}
