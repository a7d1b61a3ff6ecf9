//! Frame of a picture with two axes: grid, tick marks with their numbers, titles, legend.

use super::ticks::Scale;
use super::{WIDTH, color, shortened};
use crate::markup::Markup;

/// Margins.
const LEFT: f64 = 88.0;
const RIGHT: f64 = 44.0;
const TOP: f64 = 56.0;
const BOTTOM: f64 = 52.0;
/// Distance of the baseline of a text below its middle.
pub(super) const HALF_LETTER: f64 = 5.0;
/// Approximate width of a letter.
const LETTER: f64 = 8.9;
/// Maximum number of legend entries.
const MOST_ENTRIES: usize = 8;

/// Area in which values are drawn.
#[derive(Clone, Debug)]
pub(super) struct PlotFrame {
    pub(super) across: Scale,
    pub(super) up: Scale,
    height: f64,
}

impl PlotFrame {
    pub(super) fn new(across: Scale, up: Scale, height: f64) -> PlotFrame {
        PlotFrame { across, up, height }
    }

    /// Returns the horizontal position of a value.
    pub(super) fn x(&self, value: f64) -> f64 {
        LEFT + self.across.share(value) * (WIDTH - LEFT - RIGHT)
    }

    /// Returns the vertical position of a value, within the frame.
    pub(super) fn y(&self, value: f64) -> f64 {
        self.height - BOTTOM - self.up.share(value).clamp(0.0, 1.0) * (self.height - TOP - BOTTOM)
    }

    /// Writes a name to the right of the frame at a height.
    pub(super) fn beside(&self, out: &mut Markup, value: f64, label: &str) {
        text(out, [WIDTH - RIGHT + 4.0, self.y(value) + HALF_LETTER], "start", label);
    }

    /// Returns the side of the frame on which a value is: 1 above, −1 below, 0 inside.
    pub(super) fn beyond(&self, value: f64) -> f64 {
        match self.up.share(value) {
            share if share > 1.0 + 1e-9 => 1.0,
            share if share < -1e-9 => -1.0,
            _ => 0.0,
        }
    }

    /// Returns the number of pixel columns.
    pub(super) fn columns(&self) -> usize {
        // A small number.
        ((WIDTH - LEFT - RIGHT) / 1.25) as usize
    }

    /// Draws grid, numbers and titles.
    pub(super) fn draw(&self, out: &mut Markup, title: &str, across: &str, up: &str) {
        let (bottom, right) = (self.height - BOTTOM, WIDTH - RIGHT);
        let mut grid = String::new();
        let mut add = |[x1, y1, x2, y2]: [f64; 4]| grid.push_str(&format!("M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}"));
        self.across.marks().for_each(|mark| add([self.x(mark), TOP, self.x(mark), bottom]));
        self.up.marks().for_each(|mark| add([LEFT, self.y(mark), right, self.y(mark)]));
        out.empty("path", &[("class", &"grid"), ("stroke", &"#dde2e7"), ("fill", &"none"), ("d", &grid)]);
        let mut axis = format!("M{LEFT} {TOP}V{bottom}H{right}");
        let [low, high] = self.up.ends();
        if low < 0.0 && high > 0.0 {
            axis.push_str(&format!("M{LEFT} {0:.1}H{right}", self.y(0.0)));
        }
        out.empty("path", &[("class", &"axis"), ("stroke", &"#59636e"), ("fill", &"none"), ("d", &axis)]);
        for mark in self.across.marks() {
            text(out, [self.x(mark), bottom + 19.0], "middle", &self.across.label(mark));
        }
        for mark in self.up.marks() {
            text(out, [LEFT - 6.0, self.y(mark) + HALF_LETTER], "end", &self.up.label(mark));
        }
        heading(out, title);
        text(out, [f64::midpoint(LEFT, right), self.height - 10.0], "middle", across);
        let place = format!("translate(18 {:.1}) rotate(-90)", f64::midpoint(TOP, bottom));
        out.leaf("text", &[("transform", &place), ("text-anchor", &"middle")], up);
    }
}

/// Writes the title of a picture.
pub(super) fn heading(out: &mut Markup, title: &str) {
    let title = shortened(title, 54);
    out.leaf("text", &[("x", &"10"), ("y", &"18"), ("font-size", &"1.06em"), ("font-weight", &"600")], title);
}

/// Writes a text at a place.
pub(super) fn text(out: &mut Markup, [x, y]: [f64; 2], anchor: &str, text: &str) {
    out.leaf("text", &[("x", &format_args!("{x:.1}")), ("y", &format_args!("{y:.1}")), ("text-anchor", &anchor)], text);
}

/// Writes the legend in one line; `sample` draws the sample of an entry at a place.
pub(super) fn legend(out: &mut Markup, labels: &[&str], sample: impl Fn(&mut Markup, usize, [f64; 2])) {
    let named: Vec<(usize, String)> = labels
        .iter()
        .enumerate()
        .filter(|(_, label)| !label.is_empty())
        .map(|(number, label)| (number, shortened(label, 24)))
        .collect();
    let mut x = 10.0;
    for (shown, (number, label)) in named.iter().enumerate() {
        let width = 34.0 + label.chars().count() as f64 * LETTER;
        // Room for the note on further entries, unless this is the last one.
        let room = if shown + 1 == named.len() { WIDTH } else { WIDTH - 80.0 };
        if shown >= MOST_ENTRIES || x + width > room {
            text(out, [x, 36.0 + HALF_LETTER], "start", &format!("… {} more", named.len() - shown));
            return;
        }
        let (class, fallback) = color(*number);
        out.element("g", &[("class", &class), ("fill", &fallback), ("stroke", &fallback)], |out| {
            sample(out, *number, [x + 8.0, 36.0]);
        });
        text(out, [x + 20.0, 36.0 + HALF_LETTER], "start", label);
        x += width;
    }
}
