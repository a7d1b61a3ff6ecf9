//! Weight of workpieces: the table tilts, and the guideways bend as the table moves along them (Spaan 1995, ch. 4).
//!
//! ```text
//! e(x, F, p) = e(x, F₀) · F/F₀ · (a − p)/a        arm_mm = a    (eq. 4.1: the moment about a guideway a away from the center of the table)
//! e(x, F, p) = e(x, F₀) · F/F₀ · p/p₀             at_mm = p₀    (a moment that is zero in the center)
//! e(x, F, p) = e(x, F₀) · F/F₀                    neither       (the weight alone)
//! ```
//!
//! e(x, F₀) is the effect of a load of F₀ on a motion error or on a location error (load at the center of the table; at p₀ for the second formula). F is the
//! weight, and p its position from the center of the table along a direction of F. The effects of several loads add up.

use super::{Effect, MachineFileReading, Parameter, SourceInfo, WrittenAt};
use crate::accumulator::Accumulator;
use crate::motion::{Entry, EntryFunction, MotionKinds};
use crate::name::{ErrorKind, ErrorName};
use crate::{ErrorModel, file};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::AxisSet;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::file::Section;
use ncfix_machine::machine::{Condition, Load};

/// Name, title and sections of the source.
pub(super) static SOURCE: SourceInfo = SourceInfo {
    name: "load",
    title: "workpiece weight",
    sections: &["load"],
    example: "\
[[load]]
component = \"EAX\"
reference_N = 4800
along = \"Z\"
arm_mm = 375
kind = \"piecewise\"
coefficients = [-8.575e-5, 4.9e-7, -7e-10]
knots = [{ at_mm = 350, coefficients = [0, 0, 1.4e-9] }]
[[load]]
component = \"EA0Y\"
reference_N = 4800
along = \"Z\"
at_mm = -280
value_urad = -45
",
};

/// Directions of a position on the table.
const ALONG: [&str; 3] = ["X", "Y", "Z"];

pub(super) fn read(reading: &mut MachineFileReading<'_, '_>, errors: &mut ErrorModel) {
    for (entry, section) in reading.root.sections("load").into_iter().enumerate() {
        if let Some(effect) = read_effect(section, reading.axes, reading.kinds, reading.findings) {
            errors.effects.push(Box::new(LoadEffect { entry, ..effect }));
        }
    }
}

fn read_effect(
    mut section: Section<'_>,
    axes: AxisSet,
    kinds: &MotionKinds,
    findings: &mut Vec<Diagnostic>,
) -> Option<LoadEffect> {
    let component = section.required("component", "\"EAX\"", Section::text);
    let place = section.place_of("component");
    let help = "write E, a direction and an axis of the machine, or with a 0 before the axis, for example EAX or EA0Y";
    let name = component.and_then(|text| {
        let kind = text.parse().map_or(ErrorKind::Motion, |name: ErrorName| name.kind);
        file::known_component(&mut section, text, place, axes, kind, help)
    });
    let reference_n = section.required("reference_N", "4800", |section, key| {
        section.number_where(key, "a weight in N above 0", |force| force > 0.0)
    });
    let lean = read_lean(&mut section);
    let Some(name) = name else {
        // The required keys follow from the component.
        let keys: Vec<&str> = section.keys().collect();
        keys.into_iter().for_each(|key| section.accept(key));
        section.finish(findings);
        return None;
    };
    let amount = match name.kind {
        ErrorKind::Location => {
            let mut entry = Entry { section, name, axes };
            let value = entry.deviation("value");
            entry.section.finish(findings);
            value.map(Amount::Constant)
        }
        ErrorKind::Motion => {
            let kind = file::read_kind(&mut section, kinds);
            let Some(kind) = kind else {
                let keys: Vec<&str> = section.keys().collect();
                keys.into_iter().for_each(|key| section.accept(key));
                section.finish(findings);
                return None;
            };
            let mut entry = Entry { section, name, axes };
            let function = kind.read(&mut entry);
            entry.section.finish(findings);
            function.map(Amount::Function)
        }
    };
    Some(LoadEffect { entry: 0, name, amount: amount?, reference_n: reference_n?, lean: lean? })
}

/// Reads `along` with `arm_mm` or `at_mm`.
fn read_lean(section: &mut Section<'_>) -> Option<Lean> {
    let mut length = |key: &str| section.number_where(key, "a length in mm other than 0", |length| length != 0.0);
    let (arm, at) = (length("arm_mm"), length("at_mm"));
    let [has_arm, has_at] = ["arm_mm", "at_mm"].map(|key| section.has(key));
    if has_arm && has_at {
        let (message, help) =
            ("both arm_mm and at_mm", "arm_mm: the weight is multiplied by (arm − p)/arm; at_mm: by p/at");
        section.accept("along");
        section.report(Code::BAD_VALUE, section.place_of_key("at_mm"), message, format!("give one of them: {help}"));
        return None;
    }
    if !has_arm && !has_at {
        if section.has("along") {
            section.accept("along");
            let help = "give arm_mm or at_mm with it, or remove along if the position of the load has no effect";
            section.report(Code::MISSING_KEY, section.place_of_key("along"), "along without arm_mm or at_mm", help);
            return None;
        }
        return Some(Lean::None);
    }
    let text = section.required("along", "\"Z\"", Section::text)?;
    let Some(along) = ALONG.iter().position(|&known| known == text) else {
        let message = format!("along must be a direction of F, found \"{text}\"");
        section.report(Code::BAD_VALUE, section.place_of("along"), message, "write \"X\", \"Y\" or \"Z\"");
        return None;
    };
    match (arm, at) {
        (Some(arm_mm), _) => Some(Lean::Arm { along, arm_mm }),
        (_, Some(at_mm)) => Some(Lean::Moment { along, at_mm }),
        _ => None,
    }
}

/// Effect of a load on one component.
#[derive(Clone, Debug, PartialEq)]
struct LoadEffect {
    /// Number of its section.
    entry: usize,
    name: ErrorName,
    /// Amount for a load of `reference_n`, at the center of the table or at `at_mm`.
    amount: Amount,
    reference_n: f64,
    lean: Lean,
}

#[derive(Clone, Debug, PartialEq)]
enum Amount {
    /// Change of a location error, mm or rad.
    Constant(f64),
    /// Change of a motion error.
    Function(EntryFunction),
}

/// Returns the key of a value of a function in the file, and the factor to the unit of the file: coefficients are in mm and rad, all other values have a
/// unit.
fn written_as(name: &str, is_rotation: bool) -> (String, f64) {
    if name.contains("coefficients") {
        return (name.to_owned(), 1.0);
    }
    let (word, index) = name.split_at(name.find('[').unwrap_or(name.len()));
    if is_rotation {
        (format!("{word}_urad{index}"), urad_from_rad(1.0))
    } else {
        (format!("{word}_um{index}"), um_from_mm(1.0))
    }
}

/// Influence of the position of the load.
#[derive(Clone, Debug, PartialEq)]
enum Lean {
    None,
    Arm { along: usize, arm_mm: f64 },
    Moment { along: usize, at_mm: f64 },
}

impl LoadEffect {
    /// Returns the effect of a load as a share of the reference load.
    fn share(&self, load: &Load) -> f64 {
        let place = |along: usize| load.position_mm.get(along).copied().unwrap_or_default();
        let factor = match self.lean {
            Lean::None => 1.0,
            // An arm that a fit varies down to 0 has no meaning, and would make the sum of all sources invalid.
            Lean::Arm { arm_mm: 0.0, .. } | Lean::Moment { at_mm: 0.0, .. } => 0.0,
            Lean::Arm { along, arm_mm } => (arm_mm - place(along)) / arm_mm,
            Lean::Moment { along, at_mm } => place(along) / at_mm,
        };
        load.force_n / self.reference_n * factor
    }
}

impl Effect for LoadEffect {
    fn source(&self) -> &'static SourceInfo {
        &SOURCE
    }

    fn label(&self) -> String {
        self.name.to_string()
    }

    fn contribute(&self, condition: &Condition, sum: &mut Accumulator<'_>) {
        let share: f64 = condition.loads().iter().map(|load| self.share(load)).sum();
        if share == 0.0 {
            return;
        }
        match &self.amount {
            Amount::Constant(value) => sum.add_location(self.name, value * share),
            Amount::Function(function) => sum.add_motion(self.name, function, share),
        }
    }

    fn visit_parameters(&mut self, visit: &mut dyn FnMut(&Parameter<'_>, &mut f64)) {
        let component = format!("load.{}", self.name);
        let is_rotation = self.name.direction.is_rotation();
        let entry = self.entry;
        match &mut self.amount {
            Amount::Constant(value) => {
                let (key, factor) = written_as("value", is_rotation);
                visit(
                    &Parameter {
                        name: &component,
                        is_linear: true,
                        written: Some(WrittenAt { entry, key: &key, factor }),
                    },
                    value,
                );
            }
            Amount::Function(function) => function.visit_values(&mut |name, value| {
                let (key, factor) = written_as(name, is_rotation);
                let name = format!("{component}.{name}");
                visit(
                    &Parameter { name: &name, is_linear: true, written: Some(WrittenAt { entry, key: &key, factor }) },
                    value,
                );
            }),
        }
        let (key, arm) = match &mut self.lean {
            Lean::None => return,
            Lean::Arm { arm_mm, .. } => ("arm_mm", arm_mm),
            Lean::Moment { at_mm, .. } => ("at_mm", at_mm),
        };
        let written = Some(WrittenAt { entry, key, factor: 1.0 });
        visit(&Parameter { name: &format!("{component}.{key}"), is_linear: false, written }, arm);
    }

    fn needs_load(&self) -> bool {
        true
    }
}
