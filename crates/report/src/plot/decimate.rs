//! Reduction of many points to few columns: the visible part of a million points.

/// Points of one pixel column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelSpan {
    /// First value.
    pub first: f64,
    /// Last value.
    pub last: f64,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Number of points.
    pub count: usize,
}

/// Returns the range of values in each of `columns` columns; `None` if a column has none. A place is 0 at the left end and 1 at the right one. Points beyond,
/// and those that are not numbers, are omitted.
#[must_use]
pub fn spans(points: impl IntoIterator<Item = (f64, f64)>, columns: usize) -> Vec<Option<PixelSpan>> {
    let mut out: Vec<Option<PixelSpan>> = vec![None; columns];
    for (place, value) in points {
        let at = place * columns as f64;
        if !value.is_finite() || !(-1e-6..=columns as f64 + 1e-6).contains(&at) {
            continue;
        }
        // Not negative and small here.
        let column = (at.max(0.0) as usize).min(columns.saturating_sub(1));
        let Some(slot) = out.get_mut(column) else { continue };
        match slot {
            Some(span) => {
                span.last = value;
                span.low = span.low.min(value);
                span.high = span.high.max(value);
                span.count += 1;
            }
            None => *slot = Some(PixelSpan { first: value, last: value, low: value, high: value, count: 1 }),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_survive() {
        let points = (0..1_000_000).map(|k| {
            let value = if k == 654_321 { 99.0 } else { f64::from(k % 7) };
            (f64::from(k) / 999_999.0, value)
        });
        let found = spans(points, 500);
        assert_eq!(found.len(), 500);
        assert_eq!(found.iter().flatten().map(|span| span.count).sum::<usize>(), 1_000_000);
        assert!(found.iter().all(|span| span.is_some_and(|span| span.low == 0.0)));
        let with_peak: Vec<usize> = found
            .iter()
            .enumerate()
            .filter(|(_, span)| span.is_some_and(|span| span.high == 99.0))
            .map(|(k, _)| k)
            .collect();
        // 654321 / 999999 · 500 = 327.16
        assert_eq!(with_peak, [327]);
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let found = spans([(0.1, f64::NAN), (f64::NAN, 1.0), (2.0, 1.0), (1.0, 3.0), (0.0, -3.0)], 2);
        assert_eq!(found.iter().map(|span| span.map(|span| span.low)).collect::<Vec<_>>(), [Some(-3.0), Some(3.0)]);
        assert!(spans([(0.5, 1.0)], 0).is_empty());
    }
}
