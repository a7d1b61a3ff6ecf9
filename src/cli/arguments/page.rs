//! The arguments of all commands that write a page.

use std::path::PathBuf;

use clap::Args;

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
    /// True if the page or its pictures are requested.
    pub(in crate::cli) fn is_wanted(&self) -> bool {
        self.report.is_some() || self.svg.is_some()
    }
}
