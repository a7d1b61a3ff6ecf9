//! Pictures of plain data as SVG: points and lines over an axis, bars, histograms, ball-bar traces.
//!
//! A picture is a value with public fields that draws itself: into a page with [`Picture::draw`], or as a separate file with [`Picture::svg`]. A million
//! points are reduced to what the pixel columns can show, so no picture exceeds about ten kilobytes. Colors are those of Okabe and Ito, which are
//! distinguishable with any color vision; markers and dashes also differ. In a page the colors follow the light or dark scheme by variables of [`STYLE`]; a
//! viewer without variables shows the light ones.

mod bars;
mod chart;
mod decimate;
mod frame;
mod histogram;
mod polar;
mod ticks;

pub use bars::{Bar, Bars};
pub use chart::{Chart, LevelLine, PlotSeries, Shape};
pub use decimate::{PixelSpan, spans};
pub use histogram::Histogram;
pub use polar::{Polar, PolarTrace};
pub use ticks::{Scale, round_step};

use super::markup::Markup;

/// Width of every picture in its own units.
pub const WIDTH: f64 = 600.0;

/// Colors of series on white paper.
const COLORS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#b0508a", "#a67c00", "#4a5568"];

/// Dashes of lines. Their number and that of the colors have no common divisor, so thirty lines differ.
const DASHES: [&str; 5] = ["none", "6 3", "2 3", "9 3 2 3", "1 4"];

/// Style rules that pictures need, for a page or a file.
pub const STYLE: &str = "\
:root{color-scheme:light dark;--paper:#fff;--ink:#1b1f24;--soft:#59636e;--grid:#dde2e7;--bad:#b3261e;\
--s0:#0072b2;--s1:#d55e00;--s2:#009e73;--s3:#b0508a;--s4:#a67c00;--s5:#4a5568}\n\
@media (prefers-color-scheme:dark){:root{--paper:#14181d;--ink:#e6e9ed;--soft:#9aa5b1;--grid:#333b44;--bad:#ff8a80;\
--s0:#56b4e9;--s1:#ff8f47;--s2:#2fc79a;--s3:#e59bc8;--s4:#f0c23c;--s5:#a9b4c2}}\n\
@media print{:root{color-scheme:light;--paper:#fff;--ink:#000;--soft:#444;--grid:#ccc;--bad:#900;\
--s0:#0072b2;--s1:#d55e00;--s2:#009e73;--s3:#b0508a;--s4:#a67c00;--s5:#4a5568}}\n\
.plot{fill:var(--ink)}.plot .paper{fill:var(--paper)}.plot .soft{fill:var(--soft)}\
.plot .halo{stroke:var(--paper)}.plot .grid{stroke:var(--grid)}.plot .axis{stroke:var(--soft)}\
.plot .s0{fill:var(--s0);stroke:var(--s0)}.plot .s1{fill:var(--s1);stroke:var(--s1)}.plot .s2{fill:var(--s2);stroke:var(--s2)}\
.plot .s3{fill:var(--s3);stroke:var(--s3)}.plot .s4{fill:var(--s4);stroke:var(--s4)}.plot .s5{fill:var(--s5);stroke:var(--s5)}\n";

/// Picture that draws itself.
pub trait Picture {
    /// Returns a short title.
    fn title(&self) -> &str;

    /// Returns its height in the units of [`WIDTH`].
    fn height(&self) -> f64;

    /// Draws the content, within [`WIDTH`] and the height.
    fn inside(&self, out: &mut Markup);

    /// Draws it as an element of a page whose style contains [`STYLE`].
    fn draw(&self, out: &mut Markup) {
        drawing(self, out, false);
    }

    /// Returns the text of a separate file.
    fn svg(&self) -> String {
        let mut out = Markup::new();
        drawing(self, &mut out, true);
        out.to_string()
    }
}

fn drawing<P: Picture + ?Sized>(picture: &P, out: &mut Markup, is_alone: bool) {
    let height = picture.height();
    let whole = format!("0 0 {WIDTH} {height:.0}");
    out.element(
        "svg",
        &[
            ("xmlns", &"http://www.w3.org/2000/svg"),
            ("class", &"plot"),
            ("viewBox", &whole),
            ("width", &WIDTH),
            ("height", &format_args!("{height:.0}")),
            ("role", &"img"),
            ("font-family", &"system-ui, sans-serif"),
            ("font-size", &"16"),
            ("fill", &"#1b1f24"),
        ],
        |out| {
            out.leaf("title", &[], picture.title());
            if is_alone {
                out.leaf("style", &[], STYLE);
            }
            out.empty(
                "rect",
                &[("class", &"paper"), ("width", &WIDTH), ("height", &format_args!("{height:.0}")), ("fill", &"#fff")],
            );
            picture.inside(out);
        },
    );
}

/// Shortens a text to at most `most` characters.
fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
}

/// Returns class and color of the series with this number.
fn color(number: usize) -> (String, &'static str) {
    let which = number % COLORS.len();
    (format!("s{which}"), COLORS.get(which).copied().unwrap_or("#000"))
}

/// Returns the dashes of the line with this number.
fn dash(number: usize) -> &'static str {
    DASHES.get(number % DASHES.len()).copied().unwrap_or("none")
}
