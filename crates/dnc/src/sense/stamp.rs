//! Time stamps of readings: RFC 3339 with its zone, or seconds (milliseconds) since 1970.

use std::time::{Duration, SystemTime};

use jiff::Timestamp;

/// A number below this is not a time stamp but a count of something else: 2001.
const LEAST_S: f64 = 1e9;
/// A number above this is in milliseconds.
const MOST_S: f64 = 1e11;

/// Reads a time stamp. `None` if the text is not a time, or a time without a zone, which is ambiguous by hours.
#[must_use]
pub fn stamp(text: &str) -> Option<SystemTime> {
    let text = text.trim();
    if let Ok(number) = text.parse::<f64>() {
        let seconds = if number >= MOST_S { number / 1000.0 } else { number };
        let is_time = (LEAST_S..MOST_S).contains(&seconds);
        return is_time.then(|| SystemTime::UNIX_EPOCH + Duration::from_secs_f64(seconds));
    }
    // The library reads more than RFC 3339: shorter clocks, names of zones.
    let has_seconds = text.as_bytes().get(16) == Some(&b':');
    let time: Timestamp = text.parse().ok().filter(|_| has_seconds && !text.ends_with(']'))?;
    let since = Duration::try_from(time.duration_since(Timestamp::UNIX_EPOCH)).ok()?;
    SystemTime::UNIX_EPOCH.checked_add(since)
}

/// Returns the time of day in UTC: `12:01:07`.
#[must_use]
pub fn clock(time: SystemTime) -> String {
    // `2026-03-01T12:01:07.25Z`
    let text = Timestamp::try_from(time).map_or(String::new(), |time| time.to_string());
    text.get(11..19).unwrap_or("--:--:--").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(text: &str) -> Option<f64> {
        stamp(text).map(|time| time.duration_since(SystemTime::UNIX_EPOCH).unwrap().as_secs_f64())
    }

    #[test]
    fn a_time_of_day_has_seconds() {
        // date -u -d @1772366467.25 +%T
        let time = SystemTime::UNIX_EPOCH + Duration::from_millis(1_772_366_467_250);
        assert_eq!(clock(time), "12:01:07");
        assert_eq!(clock(SystemTime::UNIX_EPOCH), "00:00:00");
    }

    #[test]
    fn times_are_those_of_date_1() {
        // date -u -d … +%s
        assert_eq!(seconds("1985-04-12T23:20:50.52Z"), Some(482_196_050.52));
        assert_eq!(seconds("1996-12-19T16:39:57-08:00"), Some(851_042_397.0));
        assert_eq!(seconds("2024-02-29 12:00:00+01:00"), Some(1_709_204_400.0));
        assert_eq!(seconds("1709204400"), Some(1_709_204_400.0));
        assert_eq!(seconds("1709204400500"), Some(1_709_204_400.5));
    }

    #[test]
    fn what_is_no_time_everywhere_is_none() {
        for text in [
            "",
            "12:00",
            "2024-02-29T12:00:00",
            "2024-13-01T00:00:00Z",
            "2024-1-1T00:00:00Z",
            "60",
            "nan",
            "1e300",
            "-5",
        ] {
            assert_eq!(seconds(text), None, "{text}");
        }
        for text in ["2024-02-29T12:00:00é", "2023-02-29T12:00:00Z", "2024-02-29T12:00Z", "1969-12-31T23:59:59Z"] {
            assert_eq!(seconds(text), None, "{text}");
        }
    }
}
