//! Pictures of a page as separate files, for papers and slides.

use crate::plot::STYLE;

/// Maximum number of letters of the title in a file name.
const MOST: usize = 60;

/// Picture of a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Single {
    /// File name: its number on the page and its title, in letters that every file system supports: `01-residual-over-x.svg`.
    pub name: String,
    /// Text of the file.
    pub text: String,
}

/// Returns all pictures of a page that [`super::page`] wrote, in order. In a page `<` occurs only in element tags, so the pictures are found by their end
/// tags.
#[must_use]
pub fn pictures(page: &str) -> Vec<Single> {
    let mut out: Vec<Single> = Vec::new();
    for rest in page.split("<svg ").skip(1) {
        let Some((inside, _)) = rest.split_once("</svg>") else { continue };
        let Some((head, title, body)) = titled(inside) else { continue };
        let name = format!("{:02}-{}.svg", out.len() + 1, plain(title));
        let text = format!("<svg {head}<title>{title}</title><style>{STYLE}</style>{body}</svg>\n");
        out.push(Single { name, text });
    }
    out
}

/// Splits into the text before a title, the title, and the text after it.
fn titled(inside: &str) -> Option<(&str, &str, &str)> {
    let (head, rest) = inside.split_once("<title>")?;
    let (title, body) = rest.split_once("</title>")?;
    Some((head, title, body))
}

/// Converts a title to a file name: lower-case letters, digits, and one dash for everything between.
fn plain(title: &str) -> String {
    let mut out = String::new();
    let signs = [("&lt;", " "), ("&gt;", " "), ("&quot;", " "), ("&amp;", " "), ("µ", "u")];
    let title = signs.iter().fold(title.to_owned(), |title, (sign, letter)| title.replace(sign, letter));
    for letter in title.chars() {
        if letter.is_ascii_alphanumeric() {
            out.push(letter.to_ascii_lowercase());
        } else if !out.ends_with('-') && !out.is_empty() {
            out.push('-');
        }
        if out.len() >= MOST {
            break;
        }
    }
    let name = out.trim_end_matches('-');
    if name.is_empty() { "picture".to_owned() } else { name.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::{figure, page};
    use crate::plot::Histogram;

    #[test]
    fn every_picture_becomes_a_file_that_stands_alone() {
        let picture = |title: &str| Histogram { title: title.into(), values: vec![1.0, 2.0], ..Histogram::default() };
        let text = page("two", |out| {
            figure(out, &picture("Error of X < 3 µm & more"), "<svg class='none'>");
            figure(out, &picture("…"), "");
        });
        let all = pictures(&text);
        let names: Vec<&str> = all.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(names, ["01-error-of-x-3-um-more.svg", "02-picture.svg"]);
        for one in &all {
            let read = roxmltree::Document::parse(&one.text).unwrap();
            let elements = read.root_element().children().filter(roxmltree::Node::is_element);
            let names: Vec<&str> = elements.map(|child| child.tag_name().name()).collect();
            assert_eq!(names[..3], ["title", "style", "rect"], "{}", one.text);
        }
    }
}
