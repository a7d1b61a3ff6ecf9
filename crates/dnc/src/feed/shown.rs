//! Temperatures, corrections and the fill of the buffer over time, from a journal.

use std::collections::BTreeMap;

use super::journal::FIRST;
use ncfix_base::geometry::Axis;
use ncfix_base::units::{um_from_mm, urad_from_rad};

/// Temperatures, corrections and the fill of the buffer over time, one entry for each frozen line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ThermalHistory {
    /// Time since the start, s.
    pub times_s: Vec<f64>,
    /// Temperatures by sensor, °C; NaN while a sensor has no value yet.
    pub sensors_c: Vec<(String, Vec<f64>)>,
    /// Correction of the model and applied correction by axis, µm or µrad.
    pub axes_um: Vec<(String, [Vec<f64>; 2])>,
    /// Lines that wait, by the evidence for their end: sent and not answered, or not transmitted; sent and not executed, if the control reports it. Each line
    /// counts itself.
    pub waiting: Vec<(String, Vec<f64>)>,
}

/// Counts the lines that wait.
#[derive(Debug, Default)]
struct Fill {
    frozen: f64,
    /// The last line that was answered, that left, that was executed.
    last: [f64; 3],
    /// Lines that wait for each of these, at each frozen line.
    all: [Vec<f64>; 3],
}

impl Fill {
    /// Kinds of records, and the names of the lines that wait.
    const KINDS: [(&str, &str); 3] = [("A", "not answered"), ("L", "not transmitted"), ("X", "not executed")];

    /// Notes the record of a line that no longer waits.
    fn ended(&mut self, kind: &str, number: f64) {
        for ((own, _), last) in Fill::KINDS.iter().zip(&mut self.last) {
            if *own == kind {
                *last = last.max(number);
            }
        }
    }

    fn frozen(&mut self, number: f64) {
        self.frozen = number;
        self.all.iter_mut().zip(self.last).for_each(|(all, last)| all.push((number - last).max(0.0)));
    }

    /// Returns the counts of the kinds that occur.
    fn finish(self) -> Vec<(String, Vec<f64>)> {
        let all = Fill::KINDS.iter().zip(self.last).zip(self.all);
        all.filter(|((_, last), _)| *last > 0.0).map(|(((_, name), _), counts)| ((*name).to_owned(), counts)).collect()
    }
}

/// Reads a journal.
///
/// # Errors
/// The number of the line that is not a valid record, and the reason.
pub fn shown(text: &str) -> Result<ThermalHistory, (usize, String)> {
    let whole = text.rfind('\n').map_or("", |end| text.get(..end).unwrap_or_default());
    let mut out = ThermalHistory::default();
    let mut sensors: BTreeMap<String, (f64, Vec<f64>)> = BTreeMap::new();
    let mut axes: BTreeMap<Axis, [Vec<f64>; 2]> = BTreeMap::new();
    let mut fill = Fill::default();
    for (number, line) in (1..).zip(whole.split('\n')) {
        let fault = |why: &str| (number, why.to_owned());
        if number == 1 && line != FIRST {
            return Err(fault("this is not a journal"));
        }
        if number == 1 || line.starts_with("# ") {
            continue;
        }
        let mut words = line.splitn(3, ' ');
        let [time, kind, rest] = [words.next(), words.next(), words.next()];
        match (kind, rest) {
            (Some("T"), Some(rest)) => {
                let (value, name) = rest.split_once(' ').ok_or_else(|| fault("a temperature without its sensor"))?;
                let value = value.parse().map_err(|_| fault("a temperature that is not a number"))?;
                let known = out.times_s.len();
                sensors.entry(name.to_owned()).or_insert_with(|| (f64::NAN, vec![f64::NAN; known])).0 = value;
            }
            (Some("F"), Some(rest)) => {
                let time_ms: f64 =
                    time.and_then(|time| time.parse().ok()).ok_or_else(|| fault("a record without its time"))?;
                let known = out.times_s.len();
                out.times_s.push(time_ms / 1e3);
                fill.frozen(number_of(rest).ok_or_else(|| fault("a frozen line without its number"))?);
                sensors.values_mut().for_each(|(now, all)| all.push(*now));
                for word in rest.split(' ').skip(4) {
                    let (axis, both) = offset(word).ok_or_else(|| fault("an offset that cannot be read"))?;
                    let own = axes.entry(axis).or_insert_with(|| [vec![0.0; known], vec![0.0; known]]);
                    own.iter_mut().zip(both).for_each(|(all, value)| all.push(value));
                }
                // Axes that a line does not name have the value zero.
                axes.values_mut().flatten().for_each(|all| all.resize(known + 1, 0.0));
            }
            (Some(kind), Some(rest)) => {
                if let Some(number) = number_of(rest) {
                    fill.ended(kind, number);
                }
            }
            _ => {}
        }
    }
    out.waiting = fill.finish();
    out.sensors_c = sensors.into_iter().map(|(name, (_, all))| (name, all)).collect();
    out.axes_um = axes.into_iter().map(|(axis, both)| (axis.to_string(), both)).collect();
    if whole.is_empty() { Err((1, "this is not a journal".to_owned())) } else { Ok(out) }
}

/// Reads the number of a line at the beginning of a record.
fn number_of(rest: &str) -> Option<f64> {
    rest.split(' ').next()?.parse::<u32>().ok().map(f64::from)
}

/// Reads `X+0.0123/+0.0150`: axis, applied correction and correction of the model (mm or degrees), and returns µm or µrad.
fn offset(word: &str) -> Option<(Axis, [f64; 2])> {
    let axis = Axis::from_letter(*word.as_bytes().first()?)?;
    let (applied, asked) = word.get(1..)?.split_once('/').unwrap_or((word.get(1..)?, word.get(1..)?));
    let value = |text: &str| {
        let value: f64 = text.parse().ok()?;
        Some(if axis.is_rotary() { urad_from_rad(value.to_radians()) } else { um_from_mm(value) })
    };
    Some((axis, [value(asked)?, value(applied)?]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_journal_shows_temperatures_and_corrections_by_line() {
        let text = "ncfix journal 1\n# program 5a1e part.mpf\n0 T 20.000 nose\n0 F 1 00000000 1 1\n500 T 21.500 nose\n500 T 19.000 bed 2\n\
                    500 F 2 00000000 2 2 Z-0.0040/-0.0051\n700 F 3 00000000 3 3 X+0.0010\n900 A 3\n1000 F 4 cut";
        let found = shown(text).unwrap();
        assert_eq!(found.times_s, [0.0, 0.5, 0.7]);
        let [bed, nose] = &found.sensors_c[..] else { panic!("{found:?}") };
        assert_eq!((bed.0.as_str(), &bed.1[1..]), ("bed 2", &[19.0, 19.0][..]));
        assert!(bed.1[0].is_nan());
        assert_eq!(nose.1, [20.0, 21.5, 21.5]);
        let near = |one: &[f64], other: [f64; 3]| one.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-9);
        let [x, z] = &found.axes_um[..] else { panic!("{found:?}") };
        assert!(x.0 == "X" && near(&x.1[0], [0.0, 0.0, 1.0]) && near(&x.1[1], [0.0, 0.0, 1.0]));
        assert!(near(&z.1[0], [0.0, -5.1, 0.0]) && near(&z.1[1], [0.0, -4.0, 0.0]), "{z:?}");
        assert_eq!(found.waiting, [("not answered".to_owned(), vec![1.0, 2.0, 3.0])]);
        assert_eq!(shown("G1 X0\n").unwrap_err().0, 1);
        assert_eq!(shown("ncfix journal 1\n0 T warm nose\n").unwrap_err().0, 2);
    }

    #[test]
    fn the_fill_is_counted_at_each_frozen_line() {
        // A buffer of two lines: the third one is frozen after the answer to the first.
        let text = "ncfix journal 1\n0 F 1 00000000 1 1\n0 F 2 00000000 2 2\n9 A 1\n9 F 3 00000000 3 3\n20 X 1\n21 A 3\n22 F 4 00000000 4 4\n";
        let found = shown(text).unwrap();
        let of = |name: &str, counts: [f64; 4]| (name.to_owned(), counts.to_vec());
        assert_eq!(found.waiting, [of("not answered", [1.0, 2.0, 2.0, 1.0]), of("not executed", [1.0, 2.0, 3.0, 3.0])]);
        let left = shown("ncfix journal 1\n0 F 1 00000000 1 1\n5 L 1\n6 F 2 00000000 2 2\n").unwrap();
        assert_eq!(left.waiting, [("not transmitted".to_owned(), vec![1.0, 1.0])]);
    }
}
