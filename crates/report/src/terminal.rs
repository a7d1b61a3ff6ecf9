//! Draws diagnostics like a compiler: code, message, place, the line with a caret, advice.
//!
//! This module is the only user of `annotate-snippets`. The text contains colors; the caller strips them if they are not shown.

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};

use super::excerpt::{Excerpt, printable};
use ncfix_base::diagnostic::{Diagnostic, Severity};
use ncfix_base::source::Source;

/// Width of a drawing in columns if the width of the terminal is not known.
const WIDTH: usize = 120;

/// Color mode of the drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colors {
    /// ANSI escape sequences in the text.
    Ansi,
    /// Text only.
    Plain,
}

/// Draws one diagnostic; `source` is the file of its place. Ends with a line feed.
#[must_use]
pub fn draw(diagnostic: &Diagnostic, source: Option<&Source>, colors: Colors) -> String {
    let renderer = match colors {
        Colors::Ansi => Renderer::styled(),
        Colors::Plain => Renderer::plain(),
    };
    let level = match diagnostic.severity() {
        Severity::Warning => Level::WARNING,
        Severity::Error => Level::ERROR,
    };
    let title = level.primary_title(printable(&diagnostic.message)).id(diagnostic.code.as_str());
    let help = (!diagnostic.help.is_empty()).then(|| Level::HELP.message(printable(&diagnostic.help)));
    let group = match diagnostic.place.zip(source) {
        None => title.elements(help),
        Some((place, source)) => {
            let name = printable(source.name());
            let Excerpt { line, column, text } = Excerpt::new(source, place);
            match text {
                Some((text, range)) => title
                    .element(
                        Snippet::source(text)
                            .line_start(line)
                            .path(name)
                            .annotation(AnnotationKind::Primary.span(range)),
                    )
                    .elements(help),
                None => title.element(Origin::path(name).line(line).char_column(column)).elements(help),
            }
        }
    };
    let mut drawn = renderer.term_width(WIDTH).render(&[group]);
    drawn.push('\n');
    drawn
}

/// Draws advice that concerns several diagnostics at once. Ends with a line feed.
#[must_use]
pub fn hint(sentence: &str, colors: Colors) -> String {
    let renderer = match colors {
        Colors::Ansi => Renderer::styled(),
        Colors::Plain => Renderer::plain(),
    };
    let title = Level::HELP.primary_title(printable(sentence));
    let mut drawn = renderer.term_width(WIDTH).render(&[Group::with_title(title)]);
    drawn.push('\n');
    drawn
}

/// Formats `2 errors, 1 warning`.
#[must_use]
pub fn count(errors: usize, warnings: usize) -> String {
    let one = |number: usize, word: &str| format!("{number} {word}{}", if number == 1 { "" } else { "s" });
    match (errors, warnings) {
        (0, 0) => "no errors or warnings".into(),
        (_, 0) => one(errors, "error"),
        (0, _) => one(warnings, "warning"),
        _ => format!("{}, {}", one(errors, "error"), one(warnings, "warning")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::diagnostic::{Code, Place};
    use ncfix_base::source::{FileId, Span};

    #[test]
    fn a_finding_shows_code_place_line_caret_and_help() {
        let source = Source::new(FileId(0), "part.mpf", b"N10 G0 X0\r\nN20 G2 X10 Y0 I4 J0\r\n".to_vec()).unwrap();
        let place = Place { file: FileId(0), span: Span::new(18, 30) };
        let found =
            Diagnostic::at(Code::ARC_OFF_CIRCLE, place, "start radius 4 mm, end radius 6 mm", "correct I and J");
        insta::assert_snapshot!(draw(&found, Some(&source), Colors::Plain), @r"
        error[E0203]: start radius 4 mm, end radius 6 mm
         --> part.mpf:2:8
          |
        2 | N20 G2 X10 Y0 I4 J0
          |        ^^^^^^^^^^^^
          |
          = help: correct I and J
        ");
    }

    #[test]
    fn a_finding_without_place_has_no_excerpt() {
        let found = Diagnostic::nowhere(Code::NO_MACHINE, "the demo machine is used", "give --machine M.toml");
        insta::assert_snapshot!(draw(&found, None, Colors::Plain), @r"
        warning[W0304]: the demo machine is used
         |
         = help: give --machine M.toml
        ");
    }

    #[test]
    fn bytes_of_the_file_cannot_command_the_terminal() {
        let source = Source::new(FileId(0), "p", b"X1\x1b[2J\x00\t\x9b5Y ;\xb0".to_vec()).unwrap();
        let place = Place { file: FileId(0), span: Span::new(2, 6) };
        let drawn = draw(&Diagnostic::at(Code::UNEXPECTED, place, "found \u{1b}[2J", ""), Some(&source), Colors::Plain);
        assert!(!drawn.chars().any(|c| c.is_control() && c != '\n'), "{drawn:?}");
    }

    #[test]
    fn counts_are_words() {
        assert_eq!(count(0, 0), "no errors or warnings");
        assert_eq!(count(1, 0), "1 error");
        assert_eq!(count(2, 1), "2 errors, 1 warning");
    }
}
