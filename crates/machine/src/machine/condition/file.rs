//! State file: `[temperature_C]`, `[[load]]` and `[zero]` in TOML.
//!
//! ```toml
//! [temperature_C]
//! T_head = 27.4
//!
//! [[load]]
//! force_N = 1700
//! position_mm = [0, 0, -280]   # from the center of the table, along the axes of F; default: the center
//!
//! [zero.temperature_C]         # temperatures when the zero point of the workpiece was set
//! T_head = 24.0
//!
//! [zero.at]                    # optional: the pose at that time, axis positions and tool; otherwise all drift is zeroed, at every position
//! X_mm = 300
//! Z_mm = -120
//! tool_mm = [0, 0, -95]
//! ```

use super::{Condition, Load, ZeroPose};
use crate::machine::file::{MachineFile, Section};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, AXIS_COUNT, AxisVector, Vector};
use ncfix_base::source::Source;

/// Range of the temperatures that a sensor can have, °C: from a cold store to a hot end (a printer's has up to 300 °C). Values of failed sensors are beyond it: −127 °C
/// and 85 °C of a DS18B20 (only the first is impossible), 850 °C of an open Pt100 (IEC 60751 ends there).
pub const READABLE_C: [f64; 2] = [-60.0, 400.0];

/// Reads a state file and reports all diagnostics in one run. The condition is `None` if any of them is an error.
#[must_use]
pub fn load(source: &Source) -> (Option<Condition>, Vec<Diagnostic>) {
    let file = match MachineFile::parse(source) {
        Ok(file) => file,
        Err(findings) => return (None, findings),
    };
    let mut findings = Vec::new();
    let mut root = file.root();
    let mut condition = Condition::default();
    if let Some(section) = root.section("temperature_C") {
        read_temperatures(section, &mut condition, &mut findings);
    }
    for section in root.sections("load") {
        condition.loads.extend(read_load(section, &mut findings));
    }
    if let Some(mut section) = root.section("zero") {
        let mut zero = Condition::default();
        if let Some(temperatures) = section.required("temperature_C", "{ T_head = 21.5 }", Section::section) {
            read_temperatures(temperatures, &mut zero, &mut findings);
        }
        if let Some(at) = section.section("at") {
            condition.set_zero_pose(read_pose(at, &mut findings));
        }
        section.finish(&mut findings);
        condition.set_zero(zero);
    }
    root.finish(&mut findings);
    findings.sort_by_key(|finding| (finding.place, finding.code));
    let sound = !findings.iter().any(Diagnostic::is_error);
    (sound.then_some(condition), findings)
}

/// Returns the section of a state file for a load.
#[must_use]
pub fn load_text(load: &Load) -> String {
    let [x, y, z]: [f64; 3] = load.position_mm.into();
    format!("[[load]]\nforce_N = {:.2}\nposition_mm = [{x:.2}, {y:.2}, {z:.2}]\n", load.force_n)
}

fn read_temperatures(mut section: Section<'_>, condition: &mut Condition, findings: &mut Vec<Diagnostic>) {
    let [low, high] = READABLE_C;
    let keys: Vec<&str> = section.keys().collect();
    for key in keys {
        let expected = "a temperature from -60 to 400 °C";
        if let Some(value) = section.number_where(key, expected, |value| (low..=high).contains(&value)) {
            condition.add_reading(key, 0.0, value);
        }
    }
    section.finish(findings);
}

/// Reads `X_mm = 100`, `C_deg = 30`, `tool_mm = [0, 0, -120]`; missing keys are 0.
fn read_pose(mut section: Section<'_>, findings: &mut Vec<Diagnostic>) -> ZeroPose {
    let mut pose = ZeroPose { command: AxisVector::ZERO, tool_mm: Vector::zeros(), direction: [0; AXIS_COUNT] };
    for axis in AXES {
        let key = format!("{axis}_{}", if axis.is_rotary() { "deg" } else { "mm" });
        let value = section.number(&key).unwrap_or(0.0);
        pose.command[axis] = if axis.is_rotary() { value.to_radians() } else { value };
    }
    pose.tool_mm = section.vector("tool_mm").unwrap_or_default();
    section.finish(findings);
    pose
}

fn read_load(mut section: Section<'_>, findings: &mut Vec<Diagnostic>) -> Option<Load> {
    let force_n = section.required("force_N", "1700", |section, key| {
        section.number_where(key, "a weight in N that is not negative", |value| value >= 0.0)
    });
    let position_mm = section.vector("position_mm").unwrap_or_default();
    if section.has("mass_kg") {
        section.accept("mass_kg");
        let place = section.place_of_key("mass_kg");
        section.report(Code::WRONG_UNIT, place, "mass_kg: a load is a weight", "write force_N, 9.81 N for each kg");
    }
    let load = force_n.map(|force_n| Load { force_n, position_mm });
    if load.is_some_and(|load| !load.is_plausible()) {
        let place = section.place();
        let help = "give newtons and mm from the center of the table: at most 10000000 N, at most 100000 mm away";
        section.report(Code::BAD_VALUE, place, "no machine tool carries this load", help);
    }
    section.finish(findings);
    load
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::source::FileId;

    fn read(text: &str) -> (Option<Condition>, Vec<&'static str>) {
        let (condition, findings) = load(&Source::new(FileId(0), "state.toml", text.as_bytes().to_vec()).unwrap());
        (condition, findings.iter().map(|finding| finding.code.as_str()).collect())
    }

    #[test]
    fn temperatures_loads_and_the_zero_are_read() {
        let text = "[temperature_C]\nT_head = 27.5\n[[load]]\nforce_N = 1700\nposition_mm = [0, 0, -280]\n[[load]]\nforce_N = 5\n\
                    [zero.temperature_C]\nT_head = 24\n";
        let (condition, findings) = read(text);
        let condition = condition.unwrap();
        assert!(findings.is_empty(), "{findings:?}");
        assert_eq!(condition.temperature_c("T_head", 0.0), Some(27.5));
        assert_eq!(condition.temperature_c("T_bed", 0.0), None);
        assert_eq!(condition.loads()[0], Load { force_n: 1700.0, position_mm: Vector::new(0.0, 0.0, -280.0) });
        assert_eq!(condition.loads()[1].position_mm, Vector::zeros());
        assert_eq!(condition.zero().unwrap().temperature_c("T_head", 60.0), Some(24.0));
    }

    #[test]
    fn faults_are_reported_together() {
        let text = "temp = 1\n[temperature_C]\nT_head = 500\nT_b = \"x\"\n[[load]]\nmass_kg = 3\n[zero]\n";
        assert_eq!(read(text).1, ["E0402", "E0404", "E0404", "E0403", "E0407", "E0403"]);
        assert!(read(text).0.is_none());
    }
}
