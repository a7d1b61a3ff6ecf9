//! Times that readings carry: RFC 3339 with its zone, or seconds (milliseconds) since 1970.

use std::time::{Duration, SystemTime};

/// A number below this is no time of a reading but a count of something else: 2001.
const LEAST_S: f64 = 1e9;
/// A number above this counts milliseconds.
const MOST_S: f64 = 1e11;

/// The time that a text says; `None` where it says none, or none that is the same everywhere: a time without a zone is not known to an hour.
#[must_use]
pub fn stamp(text: &str) -> Option<SystemTime> {
    let text = text.trim();
    if let Ok(number) = text.parse::<f64>() {
        let seconds = if number >= MOST_S { number / 1000.0 } else { number };
        let is_time = (LEAST_S..MOST_S).contains(&seconds);
        return is_time.then(|| SystemTime::UNIX_EPOCH + Duration::from_secs_f64(seconds));
    }
    let (date, rest) = text.split_at_checked(10)?;
    let [year, month, day] = parts(date, '-', [4, 2, 2])?;
    let rest = rest.strip_prefix(['T', 't', ' '])?;
    let (clock, rest) = rest.split_at_checked(8)?;
    let [hour, minute, second] = parts(clock, ':', [2, 2, 2])?;
    let (fraction, zone) = match rest.strip_prefix('.') {
        Some(rest) => {
            let end = rest.find(|character: char| !character.is_ascii_digit()).unwrap_or(rest.len());
            let (digits, zone) = rest.split_at_checked(end)?;
            (format!("0.{digits}").parse::<f64>().ok()?, zone)
        }
        None => (0.0, rest),
    };
    let offset_minutes = match zone {
        "Z" | "z" => 0,
        _ => {
            let sign = if zone.starts_with('-') { -1 } else { 1 };
            let [hours, minutes] = parts(zone.strip_prefix(['+', '-'])?, ':', [2, 2])?;
            sign * (hours * 60 + minutes)
        }
    };
    let is_sound = (1..=12).contains(&month) && (1..=31).contains(&day) && hour < 24 && minute < 60 && second <= 60;
    let days = days_since_1970(year, month, day);
    let seconds = ((days * 24 + hour) * 60 + minute - offset_minutes) * 60 + second;
    let seconds = u64::try_from(seconds).ok().filter(|_| is_sound)?;
    SystemTime::UNIX_EPOCH.checked_add(Duration::from_secs(seconds) + Duration::from_secs_f64(fraction))
}

/// Numbers of so many digits with a sign between them.
fn parts<const N: usize>(text: &str, between: char, digits: [usize; N]) -> Option<[i64; N]> {
    let mut found = [0; N];
    let mut words = text.split(between);
    for (value, digits) in found.iter_mut().zip(digits) {
        let word =
            words.next().filter(|word| word.len() == digits && word.bytes().all(|byte| byte.is_ascii_digit()))?;
        *value = word.parse().ok()?;
    }
    words.next().is_none().then_some(found)
}

/// Days of the proleptic Gregorian calendar. The year is counted from March, so that the leap day is its last one.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    // 719468 days from 0000-03-01 to 1970-01-01; (153 m + 2) / 5 days in the months before.
    365 * year + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400) + (153 * month + 2) / 5 + day
        - 1
        - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(text: &str) -> Option<f64> {
        stamp(text).map(|time| time.duration_since(SystemTime::UNIX_EPOCH).unwrap().as_secs_f64())
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
        assert_eq!(seconds("2024-02-29T12:00:00é"), None);
    }
}
