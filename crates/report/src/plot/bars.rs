//! Horizontal bars with names and error bars.

use std::fmt::Write as _;

use super::frame::{HALF_LETTER, heading, text};
use super::ticks::Scale;
use super::{Picture, WIDTH, color, shortened};
use crate::markup::Markup;
use crate::scale::Log;

/// Margins around the bars.
const LEFT: f64 = 206.0;
const RIGHT: f64 = 30.0;
const TOP: f64 = 32.0;
const BOTTOM: f64 = 50.0;
/// Height of a bar with its gap.
const STEP: f64 = 21.0;
/// Maximum number of bars; the others are counted.
const MOST_BARS: usize = 120;

/// Bar chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bars {
    /// Title.
    pub title: String,
    /// Title of the axis, with its unit.
    pub across: String,
    /// Bars from top to bottom.
    pub bars: Vec<Bar>,
    /// True if the axis is logarithmic, beginning at 1.
    pub is_logarithmic: bool,
}

/// Bar.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bar {
    /// Name.
    pub label: String,
    /// Length; not drawn if it is not a number.
    pub value: f64,
    /// Half the length of its error bar; 0 for none.
    pub error: f64,
}

/// Linear or logarithmic axis.
enum Axis {
    Linear(Scale),
    Logarithmic(Log),
}

impl Axis {
    fn share(&self, value: f64) -> f64 {
        match self {
            Axis::Linear(scale) => scale.share(value).clamp(0.0, 1.0),
            Axis::Logarithmic(log) => log.share(value).clamp(0.0, 1.0),
        }
    }

    fn marks(&self) -> Vec<(f64, String)> {
        match self {
            Axis::Linear(scale) => scale.marks().map(|mark| (mark, scale.label(mark))).collect(),
            Axis::Logarithmic(log) => log.decades().map(|mark| (mark, format!("{mark}"))).collect(),
        }
    }
}

impl Bars {
    fn shown(&self) -> impl Iterator<Item = &Bar> {
        self.bars.iter().take(MOST_BARS)
    }

    fn axis(&self) -> Axis {
        let ends = |bar: &Bar| {
            let error = if bar.error.is_finite() { bar.error } else { 0.0 };
            [bar.value - error, bar.value + error]
        };
        if self.is_logarithmic {
            let all = self.shown().flat_map(ends).filter(|value| value.is_finite());
            return Axis::Logarithmic(Log::new(1.0, all.fold(10.0, f64::max).min(1e30)).to_decades());
        }
        Axis::Linear(Scale::around(self.shown().flat_map(ends).chain([0.0]), 7))
    }
}

impl Picture for Bars {
    fn title(&self) -> &str {
        &self.title
    }

    fn height(&self) -> f64 {
        TOP + BOTTOM + STEP * (self.bars.len().min(MOST_BARS) + usize::from(self.bars.len() > MOST_BARS)) as f64
    }

    fn inside(&self, out: &mut Markup) {
        let axis = self.axis();
        let x = |value: f64| LEFT + axis.share(value) * (WIDTH - LEFT - RIGHT);
        let bottom = self.height() - BOTTOM;
        let mut grid = String::new();
        for (mark, label) in axis.marks() {
            let _ = write!(grid, "M{:.1} {TOP}V{bottom:.1}", x(mark));
            text(out, [x(mark), bottom + 19.0], "middle", &label);
        }
        out.empty("path", &[("class", &"grid"), ("stroke", &"#dde2e7"), ("fill", &"none"), ("d", &grid)]);
        heading(out, &self.title);
        text(out, [f64::midpoint(LEFT, WIDTH - RIGHT), bottom + 40.0], "middle", &self.across);
        let [mut shapes, mut lines] = [String::new(), String::new()];
        let zero = x(0.0);
        for (number, bar) in self.shown().enumerate() {
            let middle = TOP + STEP * (number as f64 + 0.5);
            text(out, [LEFT - 8.0, middle + HALF_LETTER], "end", &shortened(&bar.label, 22));
            if !bar.value.is_finite() {
                text(out, [zero + 6.0, middle + HALF_LETTER], "start", "not identifiable");
                continue;
            }
            let (top, end) = (middle - 5.5, x(bar.value));
            let _ = write!(shapes, "M{zero:.1} {top:.1}H{end:.1}v11H{zero:.1}z");
            if bar.error.is_finite() && bar.error > 0.0 {
                let (from, to) = (x(bar.value - bar.error), x(bar.value + bar.error));
                let (high, low) = (middle - 3.0, middle + 3.0);
                let _ = write!(
                    lines,
                    "M{from:.1} {middle:.1}H{to:.1}M{from:.1} {high:.1}V{low:.1}M{to:.1} {high:.1}V{low:.1}"
                );
            }
        }
        let (class, fallback) = color(0);
        out.empty(
            "path",
            &[
                ("class", &class),
                ("fill", &fallback),
                ("fill-opacity", &"0.55"),
                ("stroke-width", &"0"),
                ("d", &shapes),
            ],
        );
        if !lines.is_empty() {
            out.empty(
                "path",
                &[
                    ("class", &"axis"),
                    ("stroke", &"#59636e"),
                    ("stroke-width", &"1.5"),
                    ("fill", &"none"),
                    ("d", &lines),
                ],
            );
        }
        if let Some(more) = self.bars.len().checked_sub(MOST_BARS).filter(|&more| more > 0) {
            text(out, [LEFT - 8.0, bottom - 4.0], "end", &format!("… {more} more"));
        }
    }
}
