//! Permitted range of the numbers in a TOML file, by key.
//!
//! A number far outside the range of machines is a wrong unit or a typing error. Every number that a section reads is checked here, so no key is without
//! limits. A reader checks further conditions, such as a whole number or a narrower range, itself.

use std::ops::RangeInclusive;

/// Permitted range of the numbers of keys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NumberRange {
    /// Key, or `*` and the end of the key.
    pub keys: &'static str,
    /// Smallest permitted value, in the unit of the key.
    pub least: f64,
    /// Largest permitted value, in the unit of the key.
    pub most: f64,
    /// Reason for the limits.
    pub reason: &'static str,
}

/// More turns than a rotary axis makes in one direction, degrees.
const MANY_TURNS_DEG: f64 = 360_000.0;
/// One kilometer, mm.
const KILOMETRE_MM: f64 = 1e6;
/// One year, s.
const YEAR_S: f64 = 366.0 * 86_400.0;

/// All ranges. The first match counts, so a full key comes before a pattern that also matches it.
pub const RANGES: &[NumberRange] = &[
    of("increment_mm", 1e-5, 0.1, "as `--increment`: no control has a finer one, and a coarser one has no use"),
    of("increment_deg", 1e-5, 0.1, "the same for rotary axes"),
    of("block_cycle_ms", 0.01, 1000.0, "from the fastest controls to those fed over a serial line"),
    of("arc_tolerance_mm", 0.0, 1.0, "an arc whose ends are farther off is another arc"),
    of("arc_tolerance_ratio", 0.0, 0.1, "a tenth of the radius is more than a rounding error"),
    of("chord_tolerance_mm", 1e-6, 1.0, "coarser chords are not a curve; finer ones are below every increment"),
    of("travel_mm", -1e9, 1e9, "see [limits](limits.md)"),
    of("travel_deg", -1e9, 1e9, "see [limits](limits.md)"),
    of("radius_mm", 0.0, 1e4, "10 m; no tool is larger"),
    of("baud", 50.0, 4e6, "the slowest serial lines and the fastest adapters"),
    of("lines", 1.0, 1000.0, "lines in the window no longer follow the temperatures"),
    of("bytes", 1.0, 65_536.0, "the largest receive buffers of controls"),
    of("system_bytes", 1.0, 65_536.0, "as `bytes`"),
    of("planned", 0.0, 10_000.0, "ten times the largest planners (grblHAL: 1000)"),
    of("at_most", 1.0, 10_000.0, "as `planned`; a control without a planner has no `[depth]`"),
    of("longest_line", 1.0, 4096.0, "no control takes longer blocks"),
    of("repeats", 0.0, 100.0, "more repetitions do not repair a link"),
    of("*sigma_um_per_m", 0.0, 1e6, "a strain of 1"),
    of("*um_per_m_K", -1e4, 1e4, "hundreds of times the expansion of aluminum: probably another unit"),
    of("*um_per_K", -1e4, 1e4, "10 mm per K"),
    of("*_mm_min", 0.0, 1e7, "10 km/min"),
    of("*_deg_min", 0.0, 1e9, "a million turns per minute"),
    of("*_per_min", -1e7, 1e7, "as feeds"),
    of("*_mm", -KILOMETRE_MM, KILOMETRE_MM, "1 km; no machine is larger"),
    of("*_inch", -KILOMETRE_MM, KILOMETRE_MM, "as lengths in mm"),
    of("*_deg", -MANY_TURNS_DEG, MANY_TURNS_DEG, "1000 turns"),
    of("*_um", -1e6, 1e6, "1 m: a larger error is probably in another unit"),
    of("*_urad", -1e7, 1e7, "10 rad: a larger error is probably in another unit"),
    of("*_ms", 0.0, 1e6, "a quarter of an hour"),
    of("*_s", 0.0, YEAR_S, "a year"),
    of("*_C", -273.15, 1000.0, "from absolute zero to above any temperature of a machine"),
    of("*_K", -1e4, 1e4, "no temperature difference is larger"),
    of("*_N", 0.0, 1e6, "100 t on a table"),
    of("*_percent", 0.0, 100.0, "a share of the whole"),
    of("*", -1e9, 1e9, "any other number: nine digits before the point, as in a program"),
];

const fn of(keys: &'static str, least: f64, most: f64, reason: &'static str) -> NumberRange {
    NumberRange { keys, least, most, reason }
}

/// Maximum number of list items: no measured table of one axis has more.
const MOST_IN_LIST: usize = 100_000;
/// Maximum number of coefficients of a polynomial: higher degrees are noise in double precision.
const MOST_COEFFICIENTS: usize = 64;

/// Returns the maximum number of items in the list of a key.
#[must_use]
pub fn most_in_list(key: &str) -> usize {
    if key.ends_with("coefficients") { MOST_COEFFICIENTS } else { MOST_IN_LIST }
}

impl NumberRange {
    /// True if the range applies to a key.
    fn is_about(&self, key: &str) -> bool {
        self.keys.strip_prefix('*').map_or(self.keys == key, |end| key.ends_with(end))
    }

    /// Returns the permitted values.
    #[must_use]
    pub fn values(&self) -> RangeInclusive<f64> {
        self.least..=self.most
    }
}

/// Returns the range of a key.
#[must_use]
pub fn range_of(key: &str) -> NumberRange {
    let found = RANGES.iter().find(|range| range.is_about(key));
    found.copied().unwrap_or(of("*", -1e9, 1e9, ""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_has_the_range_of_its_name_or_of_its_unit() {
        assert_eq!(range_of("increment_mm").values(), 1e-5..=0.1);
        assert_eq!(range_of("point_mm").values(), -1e6..=1e6);
        assert_eq!(range_of("head_C").values(), -273.15..=1000.0);
        assert_eq!(range_of("number").values(), -1e9..=1e9);
        assert_eq!(range_of("max_feed_mm_min").values(), 0.0..=1e7);
    }

    #[test]
    fn no_range_hides_another() {
        for (index, range) in RANGES.iter().enumerate() {
            let key = range.keys.replace('*', "some");
            assert_eq!(RANGES.iter().position(|one| one.is_about(&key)), Some(index), "{}", range.keys);
            assert!(range.least < range.most && !range.reason.is_empty());
        }
    }
}
