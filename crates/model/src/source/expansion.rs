//! Thermal expansion of scales and of the workpiece, linear in the position of the axis (Spaan 1995, ch. 6).
//!
//! e(x) = (α_s ΔT_s (x − x_s) − α_w ΔT_w (x − x_w)) along the axis, as deviation of the body that it moves. ΔT counts from the reference state; x_s and x_w
//! are the commands of the fixed points of scale and workpiece. A warm scale makes the axis move farther. The material that a tool should touch has moved
//! outwards by α_w ΔT_w (x − x_w) along its path, so a tool without correction falls short of it. On the workpiece side the body moves in the opposite
//! direction relative to the tool, and so does its deviation: the sign is the same.
//!
//! Unlike a drift it does not end when the zero point is set: it changes distances, not a position, and distances relate to the reference temperature (ISO
//! 1). It is treated like the position-dependent errors of the geometry.

use crate::accumulator::Accumulator;
use crate::motion::EntryFunction;
use crate::motion::polynomial::Polynomial;
use crate::name::DIRECTIONS;
use crate::{ErrorModel, ErrorName};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, AxisSet};
use ncfix_machine::machine::file::Section;
use ncfix_machine::machine::{Condition, Machine};

use super::{Effect, MachineFileReading, Parameter, SourceInfo, WrittenAt};

/// Name, title and sections of the source.
pub(super) static SOURCE: SourceInfo = SourceInfo {
    name: "expansion",
    title: "expansion of scales and workpiece",
    sections: &["expansion"],
    example: "\
[[expansion]]
axis = \"X\"
fixed_mm = 350
scale = { sensors = [\"T_scale_1\", \"T_scale_2\", \"T_scale_3\"], um_per_m_K = 8.0 }
workpiece = { sensors = [\"T_work\"], um_per_m_K = 11.5, fixed_mm = 200, lag_s = 900 }
",
};

/// Factor from µm per m and K to 1/K.
const PER_UM_PER_M: f64 = 1e-6;

/// Thermal expansion of one body along one axis.
#[derive(Clone, Debug, PartialEq)]
struct Expansion {
    /// Number of its section.
    entry: usize,
    axis: Axis,
    body: Body,
    per_k: f64,
    /// Command of its fixed point, mm.
    fixed_mm: f64,
    sensors: Vec<Sensor>,
    lag_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Body {
    Scale,
    Workpiece,
}

#[derive(Clone, Debug, PartialEq)]
struct Sensor {
    name: String,
    weight: f64,
}

impl Body {
    fn key(self) -> &'static str {
        match self {
            Body::Scale => "scale",
            Body::Workpiece => "workpiece",
        }
    }
}

impl Expansion {
    /// Returns the weighted mean of the sensors that have a reading, K: a body with one failed sensor of two is not half as warm.
    fn rise_k(&self, machine: &Machine, condition: &Condition) -> Option<f64> {
        let rises = self
            .sensors
            .iter()
            .filter_map(|sensor| Some((sensor.weight, machine.rise_k(condition, &sensor.name, self.lag_s)?)));
        let (weight, rise) = rises.fold((0.0, 0.0), |(weight, sum), (own, rise)| (weight + own, sum + own * rise));
        (weight > 0.0).then(|| rise / weight)
    }
}

impl Effect for Expansion {
    fn source(&self) -> &'static SourceInfo {
        &SOURCE
    }

    fn label(&self) -> String {
        format!("{} {}", self.axis, self.body.key())
    }

    fn contribute(&self, condition: &Condition, sum: &mut Accumulator<'_>) {
        let machine = sum.machine();
        let (Some(rise), Some(axis)) = (self.rise_k(machine, condition), machine.axis(self.axis)) else { return };
        let strain = match self.body {
            Body::Scale => self.per_k * rise,
            Body::Workpiece => -self.per_k * rise,
        };
        let along = EntryFunction::Polynomial(Polynomial { coefficients: vec![-strain * self.fixed_mm, strain] });
        for (direction, &share) in DIRECTIONS.into_iter().zip(axis.direction.iter()) {
            sum.add_motion(ErrorName::motion(direction, self.axis), &along, share);
        }
    }

    fn visit_parameters(&mut self, visit: &mut dyn FnMut(&Parameter<'_>, &mut f64)) {
        let name = format!("expansion.{}.{}", self.axis, self.body.key());
        let key = format!("{}.um_per_m_K", self.body.key());
        let written = Some(WrittenAt { entry: self.entry, key: &key, factor: 1.0 / PER_UM_PER_M });
        visit(&Parameter { name: &name, is_linear: true, written }, &mut self.per_k);
    }

    fn sensors(&self) -> Vec<&str> {
        self.sensors.iter().map(|sensor| sensor.name.as_str()).collect()
    }
}

pub(super) fn read(reading: &mut MachineFileReading<'_, '_>, errors: &mut ErrorModel) {
    let mut seen = AxisSet::EMPTY;
    for (entry, mut section) in reading.root.sections("expansion").into_iter().enumerate() {
        let axis = read_axis(&mut section, reading.axes, &mut seen);
        let fixed_mm = section.number("fixed_mm");
        for body in [Body::Scale, Body::Workpiece] {
            if let Some(part) = section.section(body.key()) {
                let mut findings = Vec::new();
                let read = read_body(part, body, axis, fixed_mm, &mut findings);
                section.add(findings);
                errors.effects.extend(read.map(|own| Box::new(Expansion { entry, ..own }) as Box<dyn Effect>));
            }
        }
        if !section.has("scale") && !section.has("workpiece") {
            let message = format!("{} has neither scale nor workpiece", section.title());
            let help = "write for example `scale = { sensors = [\"T_scale\"], um_per_m_K = 8.0 }`";
            section.report(Code::MISSING_KEY, section.place(), message, help);
        }
        section.finish(reading.findings);
    }
}

fn read_axis(section: &mut Section<'_>, axes: AxisSet, seen: &mut AxisSet) -> Option<Axis> {
    let letter = section.required("axis", "\"X\"", Section::text)?;
    let axis = match letter.as_bytes() {
        [byte @ b'A'..=b'Z'] => Axis::from_letter(*byte).filter(|axis| axes.contains(*axis) && !axis.is_rotary()),
        _ => None,
    };
    let place = section.place_of("axis");
    let Some(axis) = axis else {
        let known: Vec<String> = axes.iter().filter(|axis| !axis.is_rotary()).map(|axis| axis.to_string()).collect();
        let message = format!("axis must be a linear axis of the machine, found \"{letter}\"");
        section.report(Code::BAD_VALUE, place, message, format!("write one of {}", known.join(" ")));
        return None;
    };
    if seen.contains(axis) {
        let help = "write scale and workpiece into one section";
        section.report(Code::BAD_VALUE, place, format!("the expansion of {axis} is given twice"), help);
    }
    seen.insert(axis);
    Some(axis)
}

fn read_body(
    mut section: Section<'_>,
    body: Body,
    axis: Option<Axis>,
    fixed_mm: Option<f64>,
    findings: &mut Vec<Diagnostic>,
) -> Option<Expansion> {
    let um_per_m_k = section.required("um_per_m_K", "11.5", |section, key| {
        section.number_where(key, "a coefficient from -1000 to 1000 µm/(m K)", |value| value.abs() <= 1e3)
    });
    let fixed_mm = if fixed_mm.is_none() || section.has("fixed_mm") {
        section.required("fixed_mm", "350", Section::number)
    } else {
        section.accept("fixed_mm");
        fixed_mm
    };
    let lag_s = section.number_where("lag_s", "a time in s that is not negative", |lag_s| lag_s >= 0.0);
    let sensors = read_sensors(&mut section);
    section.finish(findings);
    Some(Expansion {
        entry: 0,
        axis: axis?,
        body,
        per_k: um_per_m_k? * PER_UM_PER_M,
        fixed_mm: fixed_mm?,
        sensors: sensors?,
        lag_s: lag_s.unwrap_or(0.0),
    })
}

fn read_sensors(section: &mut Section<'_>) -> Option<Vec<Sensor>> {
    let names = section.required("sensors", "[\"T_scale_1\", \"T_scale_2\"]", Section::texts)?;
    if names.is_empty() {
        let place = section.place_of("sensors");
        section.report(Code::BAD_VALUE, place, "sensors is empty", "name at least one sensor");
        return None;
    }
    let weights = match section.numbers("weights") {
        Some(weights) => weights,
        None if section.has("weights") => return None,
        None => vec![1.0; names.len()],
    };
    let are_sound = weights.len() == names.len()
        && weights.iter().all(|&weight| weight >= 0.0)
        && weights.iter().any(|&weight| weight > 0.0);
    if !are_sound {
        let message = format!("weights do not fit {} sensors", names.len());
        let help = "give one weight for every sensor, none below 0 and not all 0";
        section.report(Code::BAD_VALUE, section.place_of("weights"), message, help);
        return None;
    }
    Some(names.into_iter().zip(weights).map(|(name, weight)| Sensor { name, weight }).collect())
}
