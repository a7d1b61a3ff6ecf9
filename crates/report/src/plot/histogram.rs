//! Histogram of values, with the normal curve of an expected standard deviation.

use std::fmt::Write as _;

use super::frame::{PlotFrame, text};
use super::ticks::Scale;
use super::{Picture, WIDTH, color};
use crate::markup::Markup;

/// Maximum and minimum number of bins.
const MOST_BINS: usize = 60;
const FEWEST_BINS: usize = 7;
/// Multiple of the quartile distance beyond the quartiles from which values are counted, not drawn: one wrong row must not squeeze the rest into one bin.
const FAR: f64 = 4.0;

/// Histogram.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Histogram {
    /// Title.
    pub title: String,
    /// Title of the axis, with its unit.
    pub across: String,
    /// Counted items: `readings`.
    pub counted: &'static str,
    /// Values; those that are not numbers are omitted.
    pub values: Vec<f64>,
    /// Standard deviation of the curve; no curve if `None`.
    pub sigma: Option<f64>,
}

/// Bins that are drawn.
#[derive(Clone, Debug, PartialEq)]
struct Bins {
    low: f64,
    width: f64,
    counts: Vec<usize>,
    beyond: usize,
}

impl Histogram {
    /// Returns bins by the rule of Freedman and Diaconis: width 2 · quartile distance / ∛n.
    fn bins(&self) -> Bins {
        let mut sorted: Vec<f64> = self.values.iter().copied().filter(|value| value.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(0.0);
        let [first, third] = [at(0.25), at(0.75)];
        let between = third - first;
        let is_near = |value: f64| between <= 0.0 || (first - FAR * between..=third + FAR * between).contains(&value);
        let near: Vec<f64> = sorted.iter().copied().filter(|&value| is_near(value)).collect();
        let (Some(&low), Some(&high)) = (near.first(), near.last()) else {
            return Bins { low: 0.0, width: 1.0, counts: Vec::new(), beyond: 0 };
        };
        let range = if high > low { high - low } else { low.abs().max(1e-9) };
        let wanted = 2.0 * between / (near.len() as f64).cbrt();
        let count = if wanted > 0.0 { (range / wanted).ceil() } else { 0.0 };
        // Small because of the limits; larger numbers saturate.
        let count = (count as usize).clamp(FEWEST_BINS, MOST_BINS);
        let width = range / count as f64;
        let mut counts = vec![0; count];
        for value in &near {
            let bin = (((value - low) / width) as usize).min(count - 1);
            if let Some(slot) = counts.get_mut(bin) {
                *slot += 1;
            }
        }
        Bins { low, width, counts, beyond: sorted.len() - near.len() }
    }
}

impl Picture for Histogram {
    fn title(&self) -> &str {
        &self.title
    }

    fn height(&self) -> f64 {
        260.0
    }

    fn inside(&self, out: &mut Markup) {
        let bins = self.bins();
        let total: usize = bins.counts.iter().sum();
        let edge = |k: usize| bins.low + bins.width * k as f64;
        let high = edge(bins.counts.len());
        let sigma = self.sigma.filter(|sigma| sigma.is_finite() && *sigma > 0.0);
        // Expected count of a bin at the top of the curve: n · w / (σ √(2π)).
        let top = sigma.map_or(0.0, |sigma| total as f64 * bins.width / (sigma * std::f64::consts::TAU.sqrt()));
        let most = bins.counts.iter().copied().max().unwrap_or(1) as f64;
        // A curve much narrower than the bins would dominate the picture.
        let across = Scale::around([bins.low, high], 8);
        let frame = PlotFrame::new(across, Scale::around([0.0, most, top.min(2.0 * most)], 5), self.height());
        frame.draw(out, &self.title, &self.across, self.counted);
        let mut shapes = String::new();
        for (k, &count) in bins.counts.iter().enumerate() {
            let (left, right) = (frame.x(edge(k)) + 0.5, frame.x(edge(k + 1)) - 0.5);
            let (base, up) = (frame.y(0.0), frame.y(count as f64));
            let _ = write!(shapes, "M{left:.1} {base:.1}V{up:.1}H{right:.1}V{base:.1}z");
        }
        let (class, fallback) = color(0);
        let attributes: crate::markup::Attributes<'_> = &[
            ("class", &class),
            ("fill", &fallback),
            ("fill-opacity", &"0.55"),
            ("stroke-width", &"0"),
            ("d", &shapes),
        ];
        out.empty("path", attributes);
        if let Some(sigma) = sigma {
            let [from, to] = across.ends();
            let mut path = String::new();
            for k in 0..=200 {
                let value = from + (to - from) * f64::from(k) / 200.0;
                let height = top * (-(value / sigma).powi(2) / 2.0).exp();
                let _ = write!(path, "{}{:.1} {:.1}", if k == 0 { 'M' } else { 'L' }, frame.x(value), frame.y(height));
            }
            let (class, fallback) = color(1);
            out.empty(
                "path",
                &[
                    ("class", &class),
                    ("stroke", &fallback),
                    ("stroke-width", &"2"),
                    ("fill-opacity", &"0"),
                    ("d", &path),
                ],
            );
        }
        if bins.beyond > 0 {
            let note = format!("{} outside the picture", bins.beyond);
            text(out, [WIDTH - 16.0, 36.0], "end", &note);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_a_bin_and_a_wrong_row_is_counted() {
        let mut values: Vec<f64> = (0..1000).map(|k| f64::from(k) / 100.0).collect();
        values.extend([1e9, f64::NAN]);
        let bins = Histogram { values, ..Histogram::default() }.bins();
        // Quartiles at 2.50 and 7.50 of 0 … 9.99: 2 · 5 / 10 = 1 wide, so ten bins of a hundred.
        assert_eq!((bins.counts.as_slice(), bins.beyond), ([100; 10].as_slice(), 1));
        let same = Histogram { values: vec![2.0; 5], ..Histogram::default() }.bins();
        assert_eq!(same.counts.iter().sum::<usize>(), 5);
        assert!(Histogram::default().bins().counts.is_empty());
    }
}
