//! Dynamics: the deflection of the structure while axes accelerate.
//!
//! One `[[dynamic]]` for each component with a compliance: e = k·a + c·ȧ of the axis of the component ([`crate::motion::dynamic`]). It is zero if the
//! acceleration of an axis is unknown, for positions measured at rest and for the correction of a program.

use super::{Effect, MachineFileReading, Parameter, SourceInfo, WrittenAt};
use crate::ErrorModel;
use crate::accumulator::Accumulator;
use crate::file::known_component;
use crate::motion::EntryFunction;
use crate::motion::dynamic::Dynamic;
use crate::name::{ErrorKind, ErrorName};
use ncfix_base::diagnostic::Code;
use ncfix_machine::machine::Condition;
use ncfix_machine::machine::file::Section;

/// Largest compliance; greater ones are in another unit: one millimeter for the acceleration of gravity.
const MOST: f64 = 1e3;
/// Factor from µm per m/s² to mm per mm/s², and likewise for angles: from µrad per rad/s² to rad per rad/s².
const MICRO: f64 = 1e-6;
/// Millimeters per meter.
const MM_PER_M: f64 = 1e3;

/// Name, title and sections of the source.
pub(super) static SOURCE: SourceInfo = SourceInfo {
    name: "dynamic",
    title: "deflection by acceleration",
    sections: &["dynamic"],
    example: "\
[[dynamic]]
component = \"EXX\"
um_per_m_s2 = 1.5
[[dynamic]]
component = \"EAY\"
urad_per_m_s2 = 0.8
urad_per_m_s3 = 0.01
",
};

/// One entry.
#[derive(Clone, Debug, PartialEq)]
struct Deflection {
    /// Number of its section.
    entry: usize,
    name: ErrorName,
    function: Dynamic,
}

impl Effect for Deflection {
    fn source(&self) -> &'static SourceInfo {
        &SOURCE
    }

    fn label(&self) -> String {
        self.name.to_string()
    }

    fn contribute(&self, _: &Condition, sum: &mut Accumulator<'_>) {
        sum.add_motion(self.name, &EntryFunction::Dynamic(self.function), 1.0);
    }

    fn visit_parameters(&mut self, visit: &mut dyn FnMut(&Parameter<'_>, &mut f64)) {
        let (name, entry) = (self.name, self.entry);
        let Dynamic { by_acceleration, by_jerk } = &mut self.function;
        for (order, value) in [(2, by_acceleration), (3, by_jerk)] {
            let key = key(name, order);
            let written = Some(WrittenAt { entry, key: &key, factor: 1.0 / factor(name) });
            visit(&Parameter { name: &format!("dynamic.{name}.{key}"), is_linear: true, written }, value);
        }
    }
}

/// Returns the key of a compliance by its component: `um_per_m_s2`; `order` is 2 for the acceleration, 3 for the jerk.
#[must_use]
pub fn key(name: ErrorName, order: u8) -> String {
    let of = if name.direction.is_rotation() { "urad" } else { "um" };
    let by = if is_rotary(name) { "rad" } else { "m" };
    format!("{of}_per_{by}_s{order}")
}

/// Returns the factor from the unit of the file to mm or rad per mm/s², rad/s² (s³).
#[must_use]
pub fn factor(name: ErrorName) -> f64 {
    let of = if name.direction.is_rotation() { MICRO } else { MICRO * MM_PER_M };
    if is_rotary(name) { of } else { of / MM_PER_M }
}

fn is_rotary(name: ErrorName) -> bool {
    name.axis().is_some_and(|axis| axis.is_rotary())
}

pub(super) fn read(reading: &mut MachineFileReading<'_, '_>, errors: &mut ErrorModel) {
    for (entry, mut section) in reading.root.sections("dynamic").into_iter().enumerate() {
        let one = read_entry(entry, &mut section, reading);
        section.finish(reading.findings);
        errors.effects.extend(one.map(|one| Box::new(one) as Box<dyn Effect>));
    }
}

fn read_entry(entry: usize, section: &mut Section<'_>, reading: &MachineFileReading<'_, '_>) -> Option<Deflection> {
    let text = section.required("component", "\"EXX\"", Section::text);
    let place = section.place_of("component");
    let help = "write E, a direction and the axis that accelerates, for example EXX or EAY";
    let name = text.and_then(|text| known_component(section, text, place, reading.axes, ErrorKind::Motion, help));
    let Some(name) = name else {
        // Without a component the units of the other keys cannot be checked.
        let keys: Vec<&str> = section.keys().collect();
        keys.into_iter().for_each(|key| section.accept(key));
        return None;
    };
    let [acceleration, jerk] = [2, 3].map(|order| {
        let key = key(name, order);
        let value = section.number_where(&key, "a compliance from -1000 to 1000", |value| value.abs() <= MOST);
        value.map(|value| value * factor(name))
    });
    if acceleration.is_none() && jerk.is_none() && ![2, 3].iter().any(|&order| section.has(&key(name, order))) {
        let help = format!("write {} = 1.5", key(name, 2));
        section.report(Code::MISSING_KEY, place, format!("{name} states no compliance"), help);
        return None;
    }
    let function = Dynamic { by_acceleration: acceleration.unwrap_or(0.0), by_jerk: jerk.unwrap_or(0.0) };
    Some(Deflection { entry, name, function })
}
