//! The arguments of all commands that write a page.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::disk::pages::Pages;
use crate::error::Error;

/// Report page and its pictures.
#[derive(Clone, Debug, Default, Args)]
pub(in crate::cli) struct PageChoice {
    /// Write an HTML report with tables and pictures: one file that needs no network; also if the data are refused
    #[arg(long, value_name = "REPORT.html")]
    pub(in crate::cli) report: Option<PathBuf>,
    /// Write each picture of the report as an SVG file into this folder
    #[arg(long, value_name = "FOLDER")]
    pub(in crate::cli) svg: Option<PathBuf>,
}

impl PageChoice {
    /// The requested page and pictures, if any; `output` is the other file that is written.
    ///
    /// # Errors
    /// If they cannot be written.
    pub(in crate::cli) fn pages(&self, output: Option<&Path>, json: bool) -> Result<Option<Pages>, Error> {
        Pages::new((self.report.as_deref(), self.svg.as_deref()), output, json)
    }

    /// True if the page or its pictures are requested.
    pub(in crate::cli) fn is_wanted(&self) -> bool {
        self.report.is_some() || self.svg.is_some()
    }
}
