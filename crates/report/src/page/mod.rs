//! Report as a single HTML file. It opens from the disk, loads nothing from a network, needs no script, follows the light or dark scheme, and can be printed.
//! A page is also valid XML ([`super::markup`]).

pub mod apart;
pub mod calibration;
pub mod decomposition;
pub mod diagnosis;
mod parts;
pub mod review;
pub mod stability;
pub mod steps;
pub mod tables;
pub mod verification;

use std::fmt::Display;

use super::markup::Markup;
use super::plot::{Picture, STYLE};

/// Style of a page in addition to that of pictures. None of its characters needs an escape.
const PAGE_STYLE: &str = "\
*{box-sizing:border-box}\n\
body{margin:0 auto;padding:1.5rem clamp(1rem,3vw,3rem) 3rem;max-width:1800px;background:var(--paper);color:var(--ink);\
font:15px/1.5 system-ui,-apple-system,'Segoe UI',Roboto,sans-serif;font-variant-numeric:tabular-nums}\n\
h1{font-size:1.7rem;line-height:1.2;margin:0 0 .2rem}h2{font-size:1.25rem;margin:2.2rem 0 .6rem;border-bottom:1px solid var(--grid);\
padding-bottom:.2rem}h3{font-size:1.05rem;margin:1.6rem 0 .4rem}p{margin:.4rem 0;max-width:60em}.soft{color:var(--soft)}\n\
.banner{max-width:none;border-left:4px solid var(--s2);padding:.5rem .9rem;margin:1rem 0;background:color-mix(in srgb,var(--s2) 10%,var(--paper))}\
.banner.bad{border-color:var(--bad);background:color-mix(in srgb,var(--bad) 10%,var(--paper))}\n\
.strip{display:flex;flex-wrap:wrap;gap:.7rem;margin:1rem 0}.strip div{border:1px solid var(--grid);border-radius:6px;padding:.45rem .9rem;\
min-width:8.5rem}.strip span{display:block;color:var(--soft);font-size:.83rem}.strip b{font-size:1.2rem}\n\
.wide{overflow-x:auto;margin:.6rem 0}table{border-collapse:collapse;font-size:.93rem}\
th,td{padding:.22rem .75rem;text-align:left;border-bottom:1px solid var(--grid);white-space:nowrap}\
th{white-space:normal;color:var(--soft);font-weight:600;vertical-align:bottom}.n{text-align:right}tr.whole td{font-weight:600}tr.part td:first-child{padding-left:2rem}\
tr.bad td{color:var(--bad)}tr.wrap td{white-space:normal;vertical-align:top;max-width:34em}.note{color:var(--soft);font-size:.87rem}\n\
@media (max-width:1000px){table{font-size:.85rem}th,td{padding:.2rem .3rem}td.t{white-space:normal}}\n\
.pictures{display:grid;grid-template-columns:repeat(6,minmax(0,1fr));gap:1rem;align-items:start}.pictures figure{grid-column:span 2}\
.pictures figure:is(:nth-child(3n+1):nth-last-child(2),:nth-child(3n+2):last-child,:nth-child(3n+1):nth-last-child(4),\
:nth-child(3n+2):nth-last-child(3),:nth-child(3n):nth-last-child(2),:nth-child(3n+1):last-child){grid-column:span 3}\
@media (max-width:1200px){.pictures{grid-template-columns:repeat(2,minmax(0,1fr))}.pictures figure:nth-child(n):nth-child(n){grid-column:span 1}}\
@media (max-width:1000px){.pictures{grid-template-columns:minmax(0,1fr)}}\n\
figure{margin:0;border:1px solid var(--grid);border-radius:6px;padding:.4rem;container-type:inline-size}\
figure svg{width:100%;height:auto;display:block}@container (min-width:600px){.plot{font-size:12.5px}}figcaption{color:var(--soft);font-size:.87rem;padding:.2rem .4rem}\n\
.rank{margin-right:.5rem;color:var(--soft)}dl.evidence{display:grid;grid-template-columns:max-content 1fr;gap:.25rem 1.1rem;margin:.6rem 0;max-width:75em}\
.evidence dt{color:var(--soft)}.evidence dd{margin:0}@media (max-width:700px){dl.evidence{grid-template-columns:1fr}.evidence dd{margin:0 0 .4rem}}\n\
details{margin:.8rem 0}summary{cursor:pointer;color:var(--soft)}\n\
.findings{padding-left:0;list-style:none}.findings li{margin:.5rem 0;padding-left:.8rem;border-left:3px solid var(--s4)}\
.findings li.error{border-color:var(--bad)}.findings p{margin:0}\n\
code{font-family:ui-monospace,Consolas,monospace;font-size:.92em}\n\
@media print{body{font-size:10pt;max-width:none;padding:0}figure,tr,li{break-inside:avoid}h2,h3{break-after:avoid}\
.pictures{grid-template-columns:1fr 1fr}.pictures figure:nth-child(n):nth-child(n){grid-column:span 1}.wide{overflow:visible}th,td{white-space:normal;padding:.1rem .35rem}}\n";

/// Returns a page with a title; `inside` writes the content after the heading.
#[must_use]
pub fn page(title: &str, inside: impl FnOnce(&mut Markup)) -> String {
    page_with(title, "", "default-src 'none'; style-src 'unsafe-inline'", inside)
}

/// Returns a page with additional style, and with a policy for what a browser may load or run.
fn page_with(title: &str, style: &str, policy: &str, inside: impl FnOnce(&mut Markup)) -> String {
    let mut out = Markup::new();
    out.element("html", &[("lang", &"en")], |out| {
        out.element("head", &[], |out| {
            out.empty("meta", &[("charset", &"utf-8")]);
            out.empty("meta", &[("name", &"viewport"), ("content", &"width=device-width, initial-scale=1")]);
            out.empty("meta", &[("http-equiv", &"Content-Security-Policy"), ("content", &policy)]);
            out.leaf("title", &[], title);
            out.leaf("style", &[], STYLE);
            out.leaf("style", &[], PAGE_STYLE);
            if !style.is_empty() {
                // A style that would end its element is omitted: the page is readable without it.
                let _ = out.verbatim("style", &[], style);
            }
        });
        out.element("body", &[], |out| {
            out.leaf("h1", &[], title);
            inside(out);
        });
    });
    format!("<!DOCTYPE html>\n{out}")
}

/// Column of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageColumn {
    /// Heading.
    pub title: &'static str,
    /// True if it contains numbers, which are right-aligned.
    pub is_number: bool,
}

/// Creates columns of texts and, with a leading `#`, of numbers.
#[must_use]
pub fn columns<const N: usize>(titles: [&'static str; N]) -> [PageColumn; N] {
    titles.map(|title| match title.strip_prefix('#') {
        Some(title) => PageColumn { title, is_number: true },
        None => PageColumn { title, is_number: false },
    })
}

/// Row of a table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PageRow {
    /// Class: `whole`, `part`, `bad`, `wrap` for long texts, or empty.
    pub class: &'static str,
    /// Cells.
    pub cells: Vec<String>,
}

/// Writes a table with a caption below. Rows beyond `most` are counted, not written.
pub fn table(out: &mut Markup, columns: &[PageColumn], rows: &[PageRow], caption: &str, most: usize) {
    let class = |column: Option<&PageColumn>| if column.is_some_and(|column| column.is_number) { "n" } else { "t" };
    out.element("div", &[("class", &"wide")], |out| {
        out.element("table", &[], |out| {
            out.element("thead", &[], |out| {
                out.element("tr", &[], |out| {
                    for column in columns {
                        out.leaf("th", &[("class", &class(Some(column))), ("scope", &"col")], column.title);
                    }
                });
            });
            out.element("tbody", &[], |out| {
                for row in rows.iter().take(most) {
                    out.element("tr", &[("class", &row.class)], |out| {
                        for (k, cell) in row.cells.iter().enumerate() {
                            out.leaf("td", &[("class", &class(columns.get(k)))], cell);
                        }
                    });
                }
            });
        });
    });
    let more = rows.len().saturating_sub(most);
    if more > 0 || !caption.is_empty() {
        let counted = if more > 0 { format!("{more} more rows are not shown. ") } else { String::new() };
        out.leaf("p", &[("class", &"note")], format_args!("{counted}{caption}"));
    }
}

/// Writes the key figures of a page: name and number.
pub fn strip(out: &mut Markup, entries: &[(&str, String)]) {
    out.element("div", &[("class", &"strip")], |out| {
        for (what, number) in entries {
            out.element("div", &[], |out| {
                out.leaf("span", &[], what);
                out.leaf("b", &[], number);
            });
        }
    });
}

/// Writes pictures side by side, as the window width permits.
pub fn pictures(out: &mut Markup, inside: impl FnOnce(&mut Markup)) {
    out.element("div", &[("class", &"pictures")], inside);
}

/// Writes a picture with its caption.
pub fn figure(out: &mut Markup, picture: &impl Picture, caption: impl Display) {
    let caption = caption.to_string();
    out.element("figure", &[], |out| {
        picture.draw(out);
        if !caption.is_empty() {
            out.leaf("figcaption", &[], caption);
        }
    });
}
