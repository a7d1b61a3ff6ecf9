//! Markup that is well-formed for any text content: elements close themselves, and texts are escaped in a single place.
//!
//! Programs, labels and file names are data: they enter as [`Markup::text`] or as attribute values, and in no other way. The output is XML, so any XML parser
//! can read a page, and a picture can be a separate file. It is also HTML as long as [`Markup::empty`] is only used for SVG and for HTML elements without an
//! end tag. It is implemented here because `maud` and `askama` write only HTML.

use std::fmt::{self, Display, Write as _};

/// Attributes of an element.
pub type Attributes<'a> = &'a [(&'static str, &'a dyn Display)];

/// Markup under construction.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Markup {
    text: String,
}

impl Markup {
    /// Creates empty markup.
    #[must_use]
    pub fn new() -> Markup {
        Markup::default()
    }

    /// Appends an element with the content written by `inside`.
    pub fn element(&mut self, name: &'static str, attributes: Attributes<'_>, inside: impl FnOnce(&mut Markup)) {
        self.open(name, attributes);
        self.text.push('>');
        inside(self);
        self.text.push_str("</");
        self.text.push_str(name);
        self.text.push_str(">\n");
    }

    /// Appends an element with a text.
    pub fn leaf(&mut self, name: &'static str, attributes: Attributes<'_>, text: impl Display) {
        self.element(name, attributes, |out| out.text(text));
    }

    /// Appends an element without content.
    pub fn empty(&mut self, name: &'static str, attributes: Attributes<'_>) {
        self.open(name, attributes);
        self.text.push_str("/>\n");
    }

    /// Appends a text.
    pub fn text(&mut self, text: impl Display) {
        // Writing into a String cannot fail.
        let _ = write!(Escaped(&mut self.text), "{text}");
    }

    /// Appends a script, a data block or a style, whose content HTML takes verbatim: nothing in it may end the element. External texts enter here only as
    /// base64 or as JSON without `<`.
    ///
    /// # Errors
    /// The text, if it would end the element.
    pub fn verbatim<'t>(
        &mut self,
        name: &'static str,
        attributes: Attributes<'_>,
        text: &'t str,
    ) -> Result<(), &'t str> {
        let ends_it = |place: usize| {
            let rest = text.get(place..).unwrap_or_default();
            let own = rest.strip_prefix("</").and_then(|rest| rest.get(..name.len()));
            rest.starts_with("<!--") || own.is_some_and(|own| own.eq_ignore_ascii_case(name))
        };
        if text.match_indices('<').any(|(place, _)| ends_it(place)) {
            return Err(text);
        }
        self.open(name, attributes);
        self.text.push('>');
        self.text.push_str(text);
        let _ = writeln!(self.text, "</{name}>");
        Ok(())
    }

    /// True if nothing was written.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.text.is_empty()
    }

    fn open(&mut self, name: &'static str, attributes: Attributes<'_>) {
        self.text.push('<');
        self.text.push_str(name);
        for (key, value) in attributes {
            let _ = write!(self.text, " {key}=\"");
            let _ = write!(Escaped(&mut self.text), "{value}");
            self.text.push('"');
        }
    }
}

impl Display for Markup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Escapes a text for XML, for markup that is not written with [`Markup`].
#[must_use]
pub fn escaped(text: &str) -> String {
    let mut out = Markup::new();
    out.text(text);
    out.text
}

/// Writer that escapes its input.
struct Escaped<'a>(&'a mut String);

impl fmt::Write for Escaped<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            match character {
                '&' => self.0.push_str("&amp;"),
                '<' => self.0.push_str("&lt;"),
                '>' => self.0.push_str("&gt;"),
                '"' => self.0.push_str("&quot;"),
                '\n' => self.0.push('\n'),
                // XML permits neither control characters nor characters that Unicode reserves, not even as numbers.
                control if control.is_control() => self.0.push(' '),
                '\u{fffe}' | '\u{ffff}' => self.0.push('\u{fffd}'),
                other => self.0.push(other),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_and_attributes_are_data() {
        let hostile = "</p><script>alert(\"1\")</script> & \u{0}\u{7}\u{ffff}";
        let mut out = Markup::new();
        out.element("p", &[("title", &hostile), ("n", &1.5)], |out| {
            out.text(hostile);
            out.empty("br", &[]);
        });
        let text = out.to_string();
        assert_eq!(text.matches("<script").count(), 0);
        let document = roxmltree::Document::parse(&text).unwrap();
        let root = document.root_element();
        let read = "</p><script>alert(\"1\")</script> &   \u{fffd}";
        assert_eq!((root.attribute("title"), root.attribute("n")), (Some(read), Some("1.5")));
        assert_eq!(root.text(), Some(read));
        assert_eq!(root.children().filter(roxmltree::Node::is_element).count(), 1);
    }

    #[test]
    fn what_would_end_a_script_is_no_script() {
        for (name, text, is_taken) in [
            ("script", "if (a < b && b > c) '<p>'", true),
            ("script", "'</SCRIPT>'", false),
            ("script", "'<!--'", false),
            ("script", "'</style>'", true),
            ("style", "a>b{}", true),
            ("style", "</style ", false),
        ] {
            let mut out = Markup::new();
            assert_eq!(out.verbatim(name, &[], text).is_ok(), is_taken, "{text}");
            assert_eq!(out.to_string().contains(text), is_taken, "{text}");
        }
    }
}
