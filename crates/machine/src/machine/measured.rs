//! Ranges in which the errors of a machine were measured: `[measured]`.
//!
//! Outside of these ranges the error model is an assumption. `ncfix calibrate` writes the section from its data, and a person may write it by hand.

use std::collections::BTreeMap;

use super::edit::{Edit, Given};
use super::section::Section;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, Axis, AxisSet, ROTARY_AXES};

/// Name of the section.
const SECTION: &str = "measured";
/// Key of the temperatures, a section with the sensors.
const TEMPERATURES: &str = "temperature_C";
/// Key of the errors that no reading can show.
const NOT_SHOWN: &str = "not_shown";
/// Plausible temperatures in a machine, °C.
const PLAUSIBLE_C: [f64; 2] = [-60.0, 400.0];

/// Ranges in which the errors of a machine were measured: lowest and highest value of each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredRanges {
    /// Positions of each axis, mm or rad.
    pub axes: BTreeMap<Axis, [f64; 2]>,
    /// Distances of the tool tip from the gauge point of the spindle, mm.
    pub tool_length_mm: Option<[f64; 2]>,
    /// Temperatures of each sensor, °C.
    pub temperatures_c: BTreeMap<String, [f64; 2]>,
    /// Weights on the table, N.
    pub load_n: Option<[f64; 2]>,
    /// Date of the latest measurement, `2026-11-27`.
    pub date: Option<String>,
    /// Instruments, by the kinds of their measurements.
    pub instruments: Vec<String>,
    /// Residual of readings that were held out of the fit, root mean square, µm.
    pub residual_um: Option<f64>,
    /// Errors that no reading can show, by their names; `None` if nothing states it. Squareness (`EC0Y`), positioning, straightness (`EZX`) and angles (`EAX`) of
    /// linear axes, places of rotary axes (`EX0C`) and of the spindle.
    pub not_shown: Option<Vec<String>>,
}

/// Returns the range that contains both.
fn union(one: Option<[f64; 2]>, other: [f64; 2]) -> [f64; 2] {
    one.map_or(other, |one| [one[0].min(other[0]), one[1].max(other[1])])
}

impl MeasuredRanges {
    /// True if nothing is known.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == MeasuredRanges::default()
    }

    /// Extends the ranges by those of other measurements. The later date counts, and the residual of the other ones.
    pub fn extend_by(&mut self, later: &MeasuredRanges) {
        for (&axis, &range) in &later.axes {
            let known = self.axes.get(&axis).copied();
            self.axes.insert(axis, union(known, range));
        }
        for (sensor, &range) in &later.temperatures_c {
            let known = self.temperatures_c.get(sensor).copied();
            self.temperatures_c.insert(sensor.clone(), union(known, range));
        }
        self.tool_length_mm =
            later.tool_length_mm.map(|range| union(self.tool_length_mm, range)).or(self.tool_length_mm);
        self.load_n = later.load_n.map(|range| union(self.load_n, range)).or(self.load_n);
        self.date = self.date.take().max(later.date.clone());
        self.residual_um = later.residual_um.or(self.residual_um);
        for instrument in &later.instruments {
            if !self.instruments.contains(instrument) {
                self.instruments.push(instrument.clone());
            }
        }
    }

    /// Returns the text of a machine file with these ranges in `[measured]`; `None` if the section cannot be written.
    #[must_use]
    pub fn written_into(&self, text: &str) -> Option<String> {
        let mut edit = Edit::parse(text)?;
        self.values().iter().all(|(key, given)| edit.set(SECTION, key, given)).then(|| edit.text())
    }

    /// Returns the keys of the section with their values, in the units of the file.
    fn values(&self) -> Vec<(String, Given)> {
        let range = |range: [f64; 2]| Given::Numbers(range.to_vec());
        let mut values: Vec<(String, Given)> = Vec::new();
        for (&axis, &ends) in &self.axes {
            values.push((key_of(axis), range(if axis.is_rotary() { ends.map(f64::to_degrees) } else { ends })));
        }
        values.extend(self.tool_length_mm.map(|ends| ("tool_length_mm".to_owned(), range(ends))));
        values.extend(self.load_n.map(|ends| ("load_N".to_owned(), range(ends))));
        if !self.temperatures_c.is_empty() {
            let sensors = self.temperatures_c.iter().map(|(sensor, &ends)| (sensor.clone(), range(ends)));
            values.push((TEMPERATURES.to_owned(), Given::Entry(sensors.collect())));
        }
        values.extend(self.date.clone().map(|date| ("date".to_owned(), Given::Text(date))));
        if !self.instruments.is_empty() {
            values.push(("instruments".to_owned(), Given::Texts(self.instruments.clone())));
        }
        values.extend(self.residual_um.map(|um| ("residual_um".to_owned(), Given::Number(um))));
        values.extend(self.not_shown.clone().map(|names| (NOT_SHOWN.to_owned(), Given::Texts(names))));
        values
    }
}

/// Returns the key of an axis: `X_mm`, `C_deg`.
fn key_of(axis: Axis) -> String {
    format!("{axis}_{}", if axis.is_rotary() { "deg" } else { "mm" })
}

/// Reads `[measured]` of a machine with these axes.
pub(super) fn read(mut section: Section<'_>, axes: AxisSet, findings: &mut Vec<Diagnostic>) -> MeasuredRanges {
    let mut ranges = MeasuredRanges::default();
    for axis in AXES.into_iter().filter(|&axis| axes.contains(axis)) {
        let ends = read_range(&mut section, &key_of(axis), "[0, 500]");
        let ends = ends.map(|ends| if axis.is_rotary() { ends.map(f64::to_radians) } else { ends });
        ranges.axes.extend(ends.map(|ends| (axis, ends)));
    }
    ranges.tool_length_mm = read_range(&mut section, "tool_length_mm", "[0, 150]");
    ranges.load_n = read_range(&mut section, "load_N", "[0, 2000]");
    if let Some(mut sensors) = section.section(TEMPERATURES) {
        let names: Vec<&str> = sensors.keys().collect();
        for name in names {
            let Some(ends) = read_range(&mut sensors, name, "[18, 26]") else { continue };
            let [low, high] = PLAUSIBLE_C;
            if ends.iter().all(|end| (low..=high).contains(end)) {
                ranges.temperatures_c.insert(name.to_owned(), ends);
            } else {
                let message = format!("{name} must be temperatures from {low} to {high} °C");
                let place = sensors.place_of(name);
                sensors.report(Code::OUT_OF_RANGE, place, message, "write the lowest and the highest one in °C");
            }
        }
        sensors.finish(findings);
    }
    ranges.date = section.date("date").map(str::to_owned);
    ranges.instruments = section.texts("instruments").unwrap_or_default();
    ranges.residual_um = section.number_where("residual_um", "a number that is not negative", |um| um >= 0.0);
    if let Some(names) = section.texts(NOT_SHOWN) {
        let is_own = |name: &String| is_squareness(name, axes) || is_motion(name, axes) || is_place(name, axes);
        let (own, others): (Vec<String>, Vec<String>) = names.into_iter().partition(is_own);
        ranges.not_shown = Some(own);
        for name in others {
            let message = format!(
                "{NOT_SHOWN} has '{name}', which is no squareness, positioning, straightness or angular error of a linear axis of this machine, and no place of a rotary axis"
            );
            let help = "write the names of such errors, for example [\"EC0Y\", \"EZX\"]";
            section.report(Code::BAD_VALUE, section.place_of(NOT_SHOWN), message, help);
        }
    }
    section.finish(findings);
    ranges
}

/// True for the positioning, a straightness or an angle of a linear axis of the machine: `EXX`, `EZX`, `EAX`.
fn is_motion(name: &str, axes: AxisSet) -> bool {
    axes.iter()
        .filter(|axis| !axis.is_rotary())
        .any(|axis| "XYZABC".chars().any(|along| name == format!("E{along}{axis}")))
}

/// True for a location error of a rotary axis of the machine, or of the spindle: `EX0C`, `EB0S`.
fn is_place(name: &str, axes: AxisSet) -> bool {
    let rotary = axes.iter().filter(|axis| axis.is_rotary()).map(|axis| axis.to_string());
    rotary.chain(["S".to_owned()]).any(|of| "XYZABC".chars().any(|along| name == format!("E{along}0{of}")))
}

/// True for the rotation of a linear axis of the machine about another axis: `EC0Y`.
fn is_squareness(name: &str, axes: AxisSet) -> bool {
    let of_axis = |axis: Axis| {
        ROTARY_AXES
            .into_iter()
            .filter(|about| about.dimension() != axis.dimension())
            .any(|about| name == format!("E{about}0{axis}"))
    };
    axes.iter().filter(|axis| !axis.is_rotary()).any(of_axis)
}

/// Reads the lowest and the highest value, which may be equal.
fn read_range(section: &mut Section<'_>, key: &str, example: &str) -> Option<[f64; 2]> {
    let ends = section.numbers(key)?;
    if let [low, high] = *ends.as_slice()
        && low <= high
    {
        return Some([low, high]);
    }
    let message = format!("{key} must be the lowest and the highest measured value");
    let help = format!("write two numbers, the lower one first, for example `{key} = {example}`");
    section.report(Code::BAD_VALUE, section.place_of(key), message, help);
    None
}

#[cfg(test)]
mod tests {
    use super::super::document::Document;
    use super::*;
    use ncfix_base::source::{FileId, Source};

    fn read_text(text: &str) -> (MeasuredRanges, Vec<Diagnostic>) {
        let source = Source::new(FileId(0), "m.toml", text.as_bytes().to_vec()).unwrap();
        let document = Document::parse(&source).unwrap();
        let mut findings = Vec::new();
        let axes = [Axis::X, Axis::C].into_iter().collect();
        let ranges = read(document.root().section(SECTION).unwrap(), axes, &mut findings);
        (ranges, findings)
    }

    #[test]
    fn ranges_are_extended_written_and_read_again() {
        let text = "[measured]\nX_mm = [10, 500]   # laser\nC_deg = [-30, 90]\ninstruments = [\"direct\"]\ndate = \"2026-11-01\"\n";
        let (mut ranges, findings) = read_text(text);
        assert_eq!(findings, []);
        assert!((ranges.axes[&Axis::C][1] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        let later = MeasuredRanges {
            axes: [(Axis::X, [-5.0, 200.0])].into(),
            tool_length_mm: Some([120.0, 120.0]),
            temperatures_c: [("HEAD".to_owned(), [19.5, 26.0])].into(),
            load_n: Some([0.0, 1700.0]),
            instruments: vec!["ballbar".into(), "direct".into()],
            residual_um: Some(0.8),
            date: None,
            ..MeasuredRanges::default()
        };
        ranges.extend_by(&later);
        assert_eq!(ranges.axes[&Axis::X], [-5.0, 500.0]);
        assert_eq!((ranges.instruments.len(), ranges.date.as_deref()), (2, Some("2026-11-01")));
        let written = ranges.written_into(text).unwrap();
        assert!(written.contains("X_mm = [-5.0, 500.0]   # laser\n"), "{written}");
        let (again, findings) = read_text(&written);
        assert_eq!(findings, []);
        assert_eq!(again.temperatures_c, ranges.temperatures_c);
        assert_eq!((again.load_n, again.residual_um), (ranges.load_n, ranges.residual_um));
        // Writing twice changes nothing.
        assert_eq!(ranges.written_into(&written).unwrap(), written);
    }

    #[test]
    fn errors_that_nothing_shows_are_listed_and_taken_back() {
        let text = "[measured]\nX_mm = [0, 500]\nnot_shown = [\"EC0X\"]\n";
        let (mut ranges, findings) = read_text(text);
        assert_eq!((findings.len(), &ranges.not_shown), (0, &Some(vec!["EC0X".to_owned()])));
        ranges.not_shown = Some(Vec::new());
        let written = ranges.written_into(text).unwrap();
        assert!(written.contains("not_shown = []"), "{written}");
        // A file without the list gets none.
        let bare = "[measured]\nX_mm = [0, 500]\n";
        assert!(!read_text(bare).0.written_into(bare).unwrap().contains("not_shown"));
        let (ranges, findings) = read_text("[measured]\nnot_shown = [\"EZX\", \"EXX\"]\n");
        assert_eq!((findings.len(), ranges.not_shown.map_or(0, |names| names.len())), (0, 2));
        // A roll and the place of a rotary axis can be listed. A roll of the axis as a whole, the tilt of a turning axis, and an axis that the machine lacks cannot.
        let text = "[measured]\nnot_shown = [\"EAX\", \"EA0X\", \"EA0C\", \"EAC\", \"EC0Y\"]\n";
        let (ranges, findings) = read_text(text);
        let own = Some(vec!["EAX".to_owned(), "EA0C".to_owned()]);
        assert_eq!((findings.len(), ranges.not_shown), (3, own), "{findings:?}");
    }

    #[test]
    fn wrong_ranges_are_reported_at_their_place() {
        let text = "[measured]\nX_mm = [500, 10]\nY_mm = [0, 1]\nC_deg = 5\ndate = \"today\"\ntool_length_mm = [1]\n\
                    [measured.temperature_C]\nHEAD = [19, 500]\n";
        let (ranges, findings) = read_text(text);
        assert!(ranges.is_empty(), "{ranges:?}");
        let mut seen: Vec<&str> = findings.iter().map(|found| found.code.as_str()).collect();
        seen.sort_unstable();
        assert_eq!(seen, ["E0402", "E0404", "E0404", "E0404", "E0404", "E0410"], "{findings:?}");
    }
}
