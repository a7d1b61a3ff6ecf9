//! Analytical temperature model: the structure as segments between workpiece and tool that expand, bend and twist (Spaan 1995, ch. 5).
//!
//! A segment is a beam from its clamped end, nearer to F, along `s`. Sensors are at the corners of its section, across along `g` and `n = s × g`.
//! Temperatures are linear between its ends. ΔT is the rise of the mean, G the gradient along g (warmer on the side +g), D its difference between the walls
//! at +n and −n, and l the distance from the clamped end:
//!
//! ```text
//! expansion    α ∫ ΔT ds                      along s
//! bending      θ = α/h ∫ G ds                 the end turns away from the warm side, about −n
//!              v = α/h ∫ (l − s) G ds         and moves along −g      (the same for n, with the width w)
//! torsion      φ = α/(h w) ∫ (l − s) D ds     walls at ±n that bend differently turn the end about s
//! ```
//!
//! A uniform gradient gives the circular arc of a bimetal. The twist assumes two walls that are free to bend along g; a closed box twists less, which
//! `torsion_share` describes. The axis (or spindle) after the segment and everything that it carries follow the end of the segment. The effects are location
//! errors, and thus zero-point drift and squareness. If an axis slides along the segment, they are motion errors of that axis: its scale, straightness and
//! angles.

use super::{Effect, MachineFileReading, Parameter, SourceInfo, WrittenAt};
use crate::ErrorModel;
use crate::accumulator::Accumulator;
use crate::motion::{EntryFunction, polynomial::Polynomial};
use crate::name::{Carrier, DIRECTIONS, ErrorKind, ErrorName};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, Vector};
use ncfix_machine::machine::file::Section;
use ncfix_machine::machine::{Condition, Lever, Machine};

/// Tolerance of directions from a right angle or from each other.
const DIRECTION_LIMIT: f64 = 1e-6;
/// Number of coefficients of a polynomial of the distance from the clamped end.
const POWERS: usize = 5;

/// Name, title and sections of the source.
pub(super) static SOURCE: SourceInfo = SourceInfo {
    name: "structure",
    title: "heat in the structure",
    sections: &["segment"],
    example: "\
[[segment]]
name = \"column\"
before = \"Z\"
from_mm = [250, 300, -600]
to_mm = [250, 300, 200]
um_per_m_K = 11.0
across = [0, 1, 0]
across_mm = 400
wide_mm = 350
torsion_share = 0.5
sensors_from = [\"T_c1\", \"T_c2\", \"T_c3\", \"T_c4\"]
sensors_to = [\"T_c5\", \"T_c6\", \"T_c7\", \"T_c8\"]
[[segment]]
name = \"bed\"
before = \"X\"
along = \"X\"
at_mm = 100
from_mm = [-100, 0, -500]
to_mm = [900, 0, -500]
um_per_m_K = 10.0
across = [0, 0, 1]
across_mm = 300
sensors_from = [\"T_b1\", \"T_b2\"]
",
};

/// Beam of the structure.
#[derive(Clone, Debug, PartialEq)]
struct Segment {
    /// Number of its section.
    entry: usize,
    name: String,
    /// Body that its end carries.
    before: Carrier,
    /// Distance of the slide from the clamped end at command 0, mm, if `before` slides along the beam; otherwise `None`.
    slide_mm: Option<f64>,
    /// Clamped end, in F at the zero pose, mm.
    from_mm: Vector,
    /// Directions s along the beam, g across, and n = s × g.
    directions: [Vector; 3],
    length_mm: f64,
    /// Section dimensions h and w, mm.
    section_mm: [f64; 2],
    /// Coefficient of thermal expansion α, 1/K.
    expansion: f64,
    torsion_share: f64,
    /// Time constant with which the beam follows its sensors, s.
    lag_s: f64,
    /// Sensors of both ends: one, two (−g, +g) or four (−g−n, +g−n, +g+n, −g+n).
    sensors: [Vec<String>; 2],
}

/// Temperatures of a section from its corners, K.
#[derive(Clone, Copy, Debug, Default)]
struct Warmth {
    mean: f64,
    /// Gradients along g and n, + side minus − side.
    gradients: [f64; 2],
    /// Gradient along g at +n minus that at −n.
    difference: f64,
}

impl Segment {
    fn warmth(&self, machine: &Machine, condition: &Condition, end: usize) -> Option<Warmth> {
        let rises: Option<Vec<f64>> =
            self.sensors[end].iter().map(|sensor| machine.rise_k(condition, sensor, self.lag_s)).collect();
        Some(match rises?.as_slice() {
            [mean] => Warmth { mean: *mean, ..Warmth::default() },
            [low, high] => Warmth { mean: 0.5 * (low + high), gradients: [high - low, 0.0], difference: 0.0 },
            [a, b, c, d] => Warmth {
                mean: 0.25 * (a + b + c + d),
                gradients: [0.5 * (b + c - a - d), 0.5 * (c + d - a - b)],
                difference: (c - d) - (b - a),
            },
            _ => return None,
        })
    }

    /// Returns translation and rotation vector of a section of the beam at a distance l from its clamped end, as polynomials of l: mm, rad.
    fn deformation(&self, [low, high]: [Warmth; 2]) -> [[Vector; POWERS]; 2] {
        let [s, g, n] = self.directions;
        let [h, w] = self.section_mm;
        // Single and double integral of a value that is linear from one end to the other.
        let once = |from: f64, to: f64| [0.0, from, 0.5 * (to - from) / self.length_mm, 0.0, 0.0];
        let twice = |from: f64, to: f64| [0.0, 0.0, 0.5 * from, (to - from) / (6.0 * self.length_mm), 0.0];
        let mut shift = [Vector::zeros(); POWERS];
        let mut turn = [Vector::zeros(); POWERS];
        let add = |to: &mut [Vector; POWERS], direction: Vector, factor: f64, powers: [f64; POWERS]| {
            for (sum, power) in to.iter_mut().zip(powers) {
                *sum += direction * (self.expansion * factor * power);
            }
        };
        add(&mut shift, s, 1.0, once(low.mean, high.mean));
        let [along_g, along_n] = [0, 1].map(|k| [low.gradients[k], high.gradients[k]]);
        add(&mut turn, -n, 1.0 / h, once(along_g[0], along_g[1]));
        add(&mut shift, -g, 1.0 / h, twice(along_g[0], along_g[1]));
        if along_n != [0.0; 2] {
            add(&mut turn, g, 1.0 / w, once(along_n[0], along_n[1]));
            add(&mut shift, -n, 1.0 / w, twice(along_n[0], along_n[1]));
        }
        if low.difference != 0.0 || high.difference != 0.0 {
            add(&mut turn, s, self.torsion_share / (h * w), twice(low.difference, high.difference));
        }
        [shift, turn]
    }
}

impl Effect for Segment {
    fn source(&self) -> &'static SourceInfo {
        &SOURCE
    }

    fn label(&self) -> String {
        self.name.clone()
    }

    fn contribute(&self, condition: &Condition, sum: &mut Accumulator<'_>) {
        let machine = sum.machine();
        let warmth = [0, 1].map(|end| self.warmth(machine, condition, end));
        let [Some(low), Some(high)] = warmth else { return };
        let [mut shift, turn] = self.deformation([low, high]);
        let (pivot_mm, lever) = match self.before {
            Carrier::Spindle => (machine.spindle.origin_mm, Lever::Carried),
            Carrier::Axis(axis) => match machine.axis(axis) {
                Some(data) => (data.point_mm, data.lever),
                None => return,
            },
        };
        // The error acts at the pivot of the axis. If the axis slides along the beam, the end of the lever arm moves along.
        let s = self.directions[0];
        let (arm_mm, grows) = match self.slide_mm {
            None => (pivot_mm - self.from_mm - s * self.length_mm, false),
            Some(slide_mm) if lever == Lever::Carried => (pivot_mm - self.from_mm - s * slide_mm, false),
            Some(_) => (pivot_mm - self.from_mm, true),
        };
        for power in 0..POWERS {
            shift[power] += turn[power].cross(&arm_mm);
            if grows && power > 0 {
                shift[power] -= turn[power - 1].cross(&s);
            }
        }
        for direction in DIRECTIONS {
            let index = direction.index();
            let of_length: [f64; POWERS] =
                std::array::from_fn(|power| if index < 3 { shift[power][index] } else { turn[power][index - 3] });
            match (self.slide_mm, self.before) {
                (Some(slide_mm), Carrier::Axis(axis)) => {
                    let sense = machine.axis(axis).map_or(1.0, |data| data.direction.dot(&s).signum());
                    let coefficients = substituted(&of_length, slide_mm, sense);
                    let name = ErrorName::motion(direction, axis);
                    sum.add_motion(name, &EntryFunction::Polynomial(Polynomial { coefficients }), 1.0);
                }
                _ => {
                    let value = of_length.iter().rev().fold(0.0, |sum, part| sum * self.length_mm + part);
                    sum.add_location(ErrorName { direction, carrier: self.before, kind: ErrorKind::Location }, value);
                }
            }
        }
    }

    fn visit_parameters(&mut self, visit: &mut dyn FnMut(&Parameter<'_>, &mut f64)) {
        let (segment, entry) = (self.name.clone(), self.entry);
        let mut show = |name: &str, is_linear, key, factor, value: &mut f64| {
            let written = Some(WrittenAt { entry, key, factor });
            visit(&Parameter { name: &format!("segment.{segment}.{name}"), is_linear, written }, value);
        };
        show("expansion", true, "um_per_m_K", 1e6, &mut self.expansion);
        show("torsion_share", false, "torsion_share", 1.0, &mut self.torsion_share);
        show("lag_s", false, "lag_s", 1.0, &mut self.lag_s);
    }

    fn sensors(&self) -> Vec<&str> {
        self.sensors.iter().flatten().map(String::as_str).collect()
    }

    fn drifts(&self) -> bool {
        true
    }
}

/// Returns Σ aₖ (l₀ ± q)ᵏ as a polynomial of q.
fn substituted(powers: &[f64; POWERS], offset: f64, sense: f64) -> Vec<f64> {
    let mut result = vec![0.0; POWERS];
    for &power in powers.iter().rev() {
        // Horner's rule for polynomials.
        let mut carry = 0.0;
        for value in &mut result {
            let next = *value * sense;
            *value = *value * offset + carry;
            carry = next;
        }
        result[0] += power;
    }
    result
}

pub(super) fn read(reading: &mut MachineFileReading<'_, '_>, errors: &mut ErrorModel) {
    for (entry, mut section) in reading.root.sections("segment").into_iter().enumerate() {
        let segment = read_segment(&mut section, reading);
        section.finish(reading.findings);
        errors.effects.extend(segment.map(|own| Box::new(Segment { entry, ..own }) as Box<dyn Effect>));
    }
}

fn read_segment(section: &mut Section<'_>, reading: &MachineFileReading<'_, '_>) -> Option<Segment> {
    let name = section.required("name", "\"column\"", Section::text);
    let before = section.required("before", "\"Z\"", Section::text);
    let along = section.text("along");
    let from_mm = section.required("from_mm", "[0, 0, 0]", Section::vector);
    let to_mm = section.required("to_mm", "[0, 0, 600]", Section::vector);
    let expansion = section.required("um_per_m_K", "11.0", |section, key| {
        section.number_where(key, "a coefficient from -1000 to 1000 µm/(m K)", |value| value.abs() <= 1e3)
    });
    let across = section.vector("across");
    let positive = |section: &mut Section<'_>, key: &str| section.number_where(key, "a length above 0", |mm| mm > 0.0);
    let [across_mm, wide_mm] = ["across_mm", "wide_mm"].map(|key| positive(section, key));
    let torsion_share = section.number("torsion_share").unwrap_or(1.0);
    let lag_s = section.number_where("lag_s", "a time in s that is not negative", |lag_s| lag_s >= 0.0).unwrap_or(0.0);
    let sensors_from = section.required("sensors_from", "[\"T_1\", \"T_2\"]", Section::texts);
    let sensors_to = section.texts("sensors_to");
    let at_mm = section.number("at_mm");
    let before = carrier(section, "before", before?, reading)?;
    let (from_mm, to_mm) = (from_mm?, to_mm?);
    let along_s = to_mm - from_mm;
    let Some(s) = along_s.try_normalize(1e-6) else {
        return refuse(section, "to_mm", "the segment has no length", "give both ends of the segment");
    };
    let sensors_from = sensors_from?;
    let sensors = [sensors_from.clone(), sensors_to.unwrap_or(sensors_from)];
    for (key, list) in ["sensors_from", "sensors_to"].iter().zip(&sensors) {
        if !matches!(list.len(), 1 | 2 | 4) {
            let message = format!("{} sensors at the end of a segment", list.len());
            return refuse(section, key, &message, "give one, two (-, + across) or four (corners --, +-, ++, -+)");
        }
    }
    let most = sensors.iter().map(Vec::len).max().unwrap_or(0);
    let g = match (across, across_mm) {
        (Some(across), Some(_)) => across.try_normalize(1e-9),
        _ if most > 1 => {
            let message = "several sensors at an end, and across and across_mm do not state where";
            return refuse(section, "sensors_from", message, "give the direction across and the distance across_mm");
        }
        _ => Some(s.cross(&Vector::ith(s.iamin(), 1.0)).normalize()),
    };
    let Some(g) = g.filter(|g| g.dot(&s).abs() < DIRECTION_LIMIT) else {
        return refuse(
            section,
            "across",
            "across is not at a right angle to the segment",
            "give a direction across it",
        );
    };
    if most == 4 && wide_mm.is_none() {
        return refuse(
            section,
            "sensors_from",
            "four corners, and no wide_mm",
            "give the distance of the other two walls",
        );
    }
    let slide_mm = match along {
        None if at_mm.is_some() => {
            let message = "at_mm states where an axis slides along the segment, and along names none";
            return refuse(section, "at_mm", message, "name the axis in along");
        }
        None => None,
        Some(text) => {
            let slides = carrier(section, "along", text, reading)?;
            let direction = reading.machine.zip(axis_of(slides)).and_then(|(machine, axis)| machine.axis(axis));
            let is_parallel = direction.is_none_or(|data| data.direction.cross(&s).norm() < DIRECTION_LIMIT);
            if slides != before || !is_parallel || axis_of(slides).is_none_or(Axis::is_rotary) {
                let help = "name in along and before the linear axis that slides along the segment";
                return refuse(section, "along", "only the axis after a segment in the chain may slide along it", help);
            }
            Some(section.required("at_mm", "100", |_, _| at_mm)?)
        }
    };
    section.accept("at_mm");
    Some(Segment {
        entry: 0,
        name: name?.to_owned(),
        before,
        slide_mm,
        from_mm,
        directions: [s, g, s.cross(&g)],
        length_mm: along_s.norm(),
        section_mm: [across_mm.unwrap_or(1.0), wide_mm.unwrap_or(1.0)],
        expansion: expansion? * 1e-6,
        torsion_share,
        lag_s,
        sensors,
    })
}

fn axis_of(carrier: Carrier) -> Option<Axis> {
    match carrier {
        Carrier::Axis(axis) => Some(axis),
        Carrier::Spindle => None,
    }
}

/// Reads an axis of the machine, or S.
fn carrier(section: &mut Section<'_>, key: &str, text: &str, reading: &MachineFileReading<'_, '_>) -> Option<Carrier> {
    let axis = match text.as_bytes() {
        [b'S'] => return Some(Carrier::Spindle),
        [letter @ b'A'..=b'Z'] => Axis::from_letter(*letter),
        _ => None,
    };
    match axis.filter(|&axis| reading.axes.contains(axis)) {
        Some(axis) => Some(Carrier::Axis(axis)),
        None => refuse(
            section,
            key,
            &format!("{key} must be an axis of the machine or S, found \"{text}\""),
            "write for example \"Z\"",
        ),
    }
}

/// Reports a bad value.
fn refuse<T>(section: &mut Section<'_>, key: &str, message: &str, help: &str) -> Option<T> {
    let place = section.place_of(key);
    section.report(Code::BAD_VALUE, place, message, help);
    None
}
