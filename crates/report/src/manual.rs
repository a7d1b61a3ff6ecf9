//! Pages of the manual in roff, made from the definition of a command line.

use std::io;

use clap::Command;
use clap_mangen::Man;
use clap_mangen::roff::{Roff, bold, roman};

/// Parts of a page that the definition of a command does not have, or has as text within its help.
#[derive(Clone, Copy, Debug)]
pub struct ManualSections<'a> {
    /// Exit statuses with their meanings.
    pub statuses: &'a [(u8, &'a str)],
    /// Environment variables with their meanings.
    pub environment: &'a [(&'a str, &'a str)],
    /// Text in the help that ends the description: the heading of the exit statuses.
    pub end_of_description: &'a str,
    /// Heading of the examples in the help.
    pub examples: &'a str,
}

/// Returns the page of a command as roff. `path` are the words that call it: `ncfix machine show`.
///
/// # Errors
/// If the text of the help is not UTF-8.
pub fn page(command: &Command, path: &str, sections: &ManualSections<'_>) -> io::Result<String> {
    let mut out = Vec::new();
    let source = concat!("ncfix ", env!("CARGO_PKG_VERSION"));
    let man = Man::new(command.clone()).title(path.replace(' ', "-")).source(source).manual("ncfix");
    man.render_title(&mut out)?;
    man.render_name_section(&mut out)?;
    man.render_synopsis_section(&mut out)?;
    man.render_description_section(&mut out)?;
    let text = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let (said, rest) = text.split_at(text.find(sections.end_of_description).unwrap_or(text.len()));
    let mut roff = Roff::new();
    said.split("\n\n").for_each(|block| paragraph(&mut roff, block));
    roff.to_writer(&mut out)?;
    man.render_options_section(&mut out)?;
    if command.has_subcommands() {
        man.render_subcommands_section(&mut out)?;
    }
    let mut roff = Roff::new();
    roff.control("SH", ["EXIT STATUS"]);
    sections.statuses.iter().for_each(|(status, meaning)| term(&mut roff, &status.to_string(), meaning));
    roff.control("SH", ["ENVIRONMENT"]);
    sections.environment.iter().for_each(|(name, meaning)| term(&mut roff, name, meaning));
    if let Some((_, examples)) = rest.split_once(sections.examples) {
        roff.control("SH", ["EXAMPLES"]);
        paragraph(&mut roff, examples);
    }
    if let Some((above, _)) = path.rsplit_once(' ') {
        roff.control("SH", ["SEE ALSO"]);
        roff.text([bold(above.replace(' ', "-")), roman("(1)")]);
    }
    roff.to_writer(&mut out)?;
    String::from_utf8(out).map_err(io::Error::other)
}

/// A term and what it means.
fn term(roff: &mut Roff, name: &str, meaning: &str) {
    roff.control("TP", []);
    roff.text([bold(name)]);
    roff.text([roman(meaning)]);
}

/// A paragraph; lines that are indented are a table or examples and stay lines.
fn paragraph(roff: &mut Roff, block: &str) {
    if block.trim().is_empty() {
        return;
    }
    roff.control("PP", []);
    let is_table = block.lines().any(|line| line.starts_with(' '));
    if is_table {
        roff.control("nf", []);
    }
    block.lines().for_each(|line| {
        roff.text([roman(line)]);
    });
    if is_table {
        roff.control("fi", []);
    }
}
