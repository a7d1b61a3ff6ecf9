//! Output of pages: to a pager if standard output is a terminal, else directly to standard output.

use std::io::{IsTerminal as _, Write};
use std::process::{Child, Command, Stdio};

use super::files;
use crate::error::Error;
use ncfix_report::review::TerminalStyle;

/// Columns if the terminal does not report its width.
const WIDTH: usize = 100;
/// Smallest number of columns.
const LEAST: usize = 80;

/// A page that is being written.
pub(crate) struct Page {
    pager: Option<Child>,
    out: Box<dyn Write>,
    style: TerminalStyle,
    is_over: bool,
}

impl Page {
    /// Begins a page; `plain` keeps it from a pager.
    pub(crate) fn open(plain: bool) -> Page {
        files::before_stream();
        let is_terminal = std::io::stdout().is_terminal();
        let columns = std::env::var("COLUMNS").ok().and_then(|text| text.trim().parse::<usize>().ok());
        let width = columns.unwrap_or(WIDTH).clamp(LEAST, 1000);
        let choice = anstream::AutoStream::choice(&std::io::stdout());
        let style = TerminalStyle { width, has_color: choice != anstream::ColorChoice::Never };
        let mut pager = if is_terminal && !plain { pager() } else { None };
        let out: Box<dyn Write> = match pager.as_mut().and_then(|child| child.stdin.take()) {
            Some(stdin) => Box::new(std::io::BufWriter::new(stdin)),
            None => Box::new(std::io::BufWriter::new(std::io::stdout())),
        };
        Page { pager, out, style, is_over: false }
    }

    /// Appearance of rows.
    pub(crate) fn style(&self) -> TerminalStyle {
        self.style
    }

    /// Appends text. A pager that is closed early is not an error.
    ///
    /// # Errors
    /// If standard output cannot be written.
    pub(crate) fn write(&mut self, text: &str) -> Result<(), Error> {
        if self.is_over {
            return Ok(());
        }
        match self.out.write_all(text.as_bytes()) {
            Err(_) if self.pager.is_some() => self.is_over = true,
            written => written.map_err(|error| Error::output(&error))?,
        }
        Ok(())
    }

    /// Ends the page, and waits until the pager is closed.
    pub(crate) fn close(mut self) {
        // A reader that went away does not matter.
        let _ = self.out.flush();
        drop(self.out);
        if let Some(mut pager) = self.pager {
            let _ = pager.wait();
        }
    }
}

/// Pager of the user: `NCFIX_PAGER`, `PAGER`, else less, which prints a short page at once and ends.
fn pager() -> Option<Child> {
    let named = ["NCFIX_PAGER", "PAGER"].into_iter().find_map(|name| std::env::var(name).ok());
    let command = named.unwrap_or_else(|| "less".to_owned());
    let mut words = command.split_whitespace();
    let program = words.next().filter(|program| *program != "cat")?;
    let mut pager = Command::new(program);
    pager.args(words).stdin(Stdio::piped());
    if std::env::var_os("LESS").is_none() {
        pager.env("LESS", "FRX");
    }
    pager.spawn().ok()
}
