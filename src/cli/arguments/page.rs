//! The arguments of all commands that write a page.

use std::path::PathBuf;

use clap::Args;

/// Which page.
#[derive(Clone, Debug, Default, Args)]
pub(in crate::cli) struct PageChoice {
    /// Write a page (HTML) with tables and pictures of everything: one file that opens in a browser without a network; also where the data is refused
    #[arg(long, value_name = "REPORT.html")]
    pub(in crate::cli) report: Option<PathBuf>,
    /// Write each picture of that page into a folder, as a file of its own
    #[arg(long, value_name = "FOLDER")]
    pub(in crate::cli) svg: Option<PathBuf>,
}

impl PageChoice {
    /// Whether the page is drawn, as a whole or its pictures.
    pub(in crate::cli) fn is_wanted(&self) -> bool {
        self.report.is_some() || self.svg.is_some()
    }
}
