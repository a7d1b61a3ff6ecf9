//! Texts of Markdown as a terminal shows them.

/// The text of Markdown without links and bold letters: the pages of its links are in parentheses at the end, and code keeps its backticks.
pub(super) fn plain(markdown: &str) -> String {
    let mut out = String::new();
    let mut pages: Vec<String> = Vec::new();
    let mut rest = markdown;
    while let Some(at) = rest.find("](") {
        let Some(open) = rest[..at].rfind('[') else { break };
        let Some(length) = rest[at..].find(')') else { break };
        let target = &rest[at + 2..at + length];
        out += &rest[..open];
        let words = &rest[open + 1..at];
        rest = &rest[at + length + 1..];
        if !target.starts_with('#') {
            let page = target.strip_prefix("../").map_or_else(|| format!("docs/{target}"), ToOwned::to_owned);
            if !pages.contains(&page) {
                pages.push(page);
            }
        }
        rest = join(&mut out, words, rest);
    }
    out += rest;
    let out = unmarked(&out).replace("\\|", "|");
    if pages.is_empty() {
        return out;
    }
    let (text, end) = out.strip_suffix('.').map_or((out.as_str(), ""), |text| (text, "."));
    format!("{text} ({}){end}", pages.join(", "))
}

/// Adds the words of a link to a text, unless the link only points to a page, in parentheses: then it is omitted. Returns the rest of the text.
fn join<'t>(out: &mut String, words: &str, rest: &'t str) -> &'t str {
    let is_inside = out.rfind('(') > out.rfind(')');
    let is_alone = out.ends_with('(') || is_inside && out.ends_with(", ");
    if !is_alone || !rest.starts_with([')', ',']) {
        out.push_str(words);
        return rest;
    }
    if out.ends_with(", ") {
        out.truncate(out.len() - 2);
        return rest;
    }
    if let Some(rest) = rest.strip_prefix(')') {
        out.pop();
        out.truncate(out.trim_end().len());
        return rest;
    }
    rest.strip_prefix(", ").unwrap_or(rest)
}

/// A text without the marks of bold and inclined letters; code stays.
fn unmarked(text: &str) -> String {
    let parts = text.split('`').enumerate();
    let parts: Vec<String> =
        parts.map(|(at, part)| if at % 2 == 0 { part.replace('*', "") } else { part.to_owned() }).collect();
    parts.join("`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_are_at_the_end_and_code_keeps_its_marks() {
        for (markdown, shown) in [
            ("No, `E0225` ([output](reference/output.md#x), [here](#y)).", "No, `E0225` (docs/reference/output.md#x)."),
            (
                "They stay. Their tolerance [is not included](explanation/a.md) in `error after`.",
                "They stay. Their tolerance is not included in `error after` (docs/explanation/a.md).",
            ),
            (
                "It is *red* (`E0314`, [files](b.md)). `3*R` stays **so**",
                "It is red (`E0314`). `3*R` stays so (docs/b.md)",
            ),
            ("In [`grammars`](../grammars/), which it reads.", "In `grammars`, which it reads (grammars/)."),
            ("`keep\\|chords` (see [a](c.md) and more).", "`keep|chords` (see a and more) (docs/c.md)."),
        ] {
            assert_eq!(plain(markdown), shown);
        }
    }
}
