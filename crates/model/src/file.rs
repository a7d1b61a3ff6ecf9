//! Error model in the machine file, source by source, and reading of the whole file.
//!
//! Displacements are µm and rotations µrad in the file; polynomial coefficients are mm and rad per power of mm or rad.

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{Axis, AxisSet, Vector};
use ncfix_base::source::Source;
use ncfix_base::units::{mm_from_um, rad_from_urad};
use ncfix_machine::machine::file::{MachineFile, SECTIONS, Section, nearest, read_machine};
use ncfix_machine::machine::{MOST_HEADS, Machine, uncertainty};

use super::location;
use super::motion::{Entry, MotionKind, MotionKinds};
use super::name::{ErrorKind, ErrorName};
use super::plausible;
use super::source::MachineFileReading;
use super::uncertainty::UncertainParameter;
use super::{ErrorModel, HeadEntries, LocationError, ModelRegisters, MotionError};

/// Directions whose angle has a smaller sine are parallel.
const PARALLEL: f64 = 1e-9;

/// Reads a machine file and reports all diagnostics in one run, in the order of the file. The machine is `None` if any of them is an error.
#[must_use]
pub fn load(source: &Source) -> (Option<(Machine, ErrorModel)>, Vec<Diagnostic>) {
    load_with(source, &ModelRegisters::default())
}

/// Reads a machine file like [`load`]; it may contain the sections of these error sources and these kinds of motion errors.
#[must_use]
pub fn load_with(source: &Source, registers: &ModelRegisters) -> (Option<(Machine, ErrorModel)>, Vec<Diagnostic>) {
    let file = match MachineFile::parse(source) {
        Ok(file) => file,
        Err(findings) => return (None, findings),
    };
    let (machine, mut findings) = read_machine(&file);
    let mut root = file.root();
    for &section in SECTIONS {
        root.accept(section);
    }
    let axes = axes_in(file.root());
    let mut errors = ErrorModel::default();
    let kinds = &registers.motion_kinds;
    for source in registers.sources.iter() {
        let mut reading =
            MachineFileReading { root: &mut root, axes, machine: machine.as_ref(), kinds, findings: &mut findings };
        source.read(&mut reading, &mut errors);
    }
    read_heads(&mut root, axes, machine.as_ref(), registers, (&mut errors, &mut findings));
    let used = errors.sensors();
    let unused: Vec<String> = machine
        .iter()
        .flat_map(|machine| machine.sensor_references_c.keys())
        .filter(|sensor| !used.contains(&sensor.as_str()))
        .cloned()
        .collect();
    if let Some(first) = unused.first() {
        let help = match nearest(first, used.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "remove it, or correct its name".into(),
        };
        let message = format!("no error source uses the sensor {}", unused.join(", "));
        root.report(Code::UNUSED_SENSOR, root.place_of_key("sensor"), message, help);
    }
    if root.has("segment") && root.has("drift") {
        let message = "[[drift]] and [[segment]] both describe the drift of the warm machine, and are added";
        let help = "keep one of them, or let each describe the parts that the other does not";
        root.report(Code::TWO_DRIFTS, root.place_of_key("segment"), message, help);
    }
    check_uncertainty(&mut root, axes, &errors, &mut findings);
    if let Some(machine) = &machine {
        check_location(&mut root, machine, &errors);
        check_sizes(&mut root, machine, &errors);
        if machine.heads.is_empty() {
            check_spindle(&mut root, &machine.spindle.axis);
        }
    }
    root.finish(&mut findings);
    findings.sort_by_key(|finding| (finding.place, finding.code));
    let sound = !findings.iter().any(Diagnostic::is_error);
    (machine.filter(|_| sound).map(|machine| (machine, errors)), findings)
}

/// Reads the errors of each `[[head]]`, which add to those of the machine while the head is active: a head may have every section of an error source.
fn read_heads(
    root: &mut Section<'_>,
    axes: AxisSet,
    machine: Option<&Machine>,
    registers: &ModelRegisters,
    (errors, findings): (&mut ErrorModel, &mut Vec<Diagnostic>),
) {
    let mut heads = Vec::new();
    let mut start = 0;
    for (index, mut section) in root.sections("head").into_iter().take(MOST_HEADS).enumerate() {
        for key in ["select", "origin_mm", "axis"] {
            section.accept(key);
        }
        if section.boolean("start") == Some(true) {
            start = index;
        }
        let common = [errors.location.len(), errors.motion.len(), errors.effects.len()];
        let mut own = ErrorModel { head_entries: Some(HeadEntries { index, common }), ..errors.clone() };
        for source in registers.sources.iter() {
            let kinds = &registers.motion_kinds;
            let mut reading = MachineFileReading { root: &mut section, axes, machine, kinds, findings };
            source.read(&mut reading, &mut own);
        }
        let name = section.text("name");
        if let Some(head) =
            machine.and_then(|machine| machine.heads.iter().find(|head| Some(head.name.as_str()) == name))
        {
            check_spindle(&mut section, &head.spindle.axis);
        }
        section.finish(findings);
        heads.push(own);
    }
    errors.heads = heads;
    errors.start_with_head(start);
}

/// Reports location errors that move neither the tip nor the tool axis on this machine, such as the rotation of everything under the workpiece: the
/// measured deviation then belongs to another axis, and would never be corrected.
fn check_location(root: &mut Section<'_>, machine: &Machine, errors: &ErrorModel) {
    let Some(section) = root.section("location") else { return };
    for (name, others) in location::without_effect(machine, &errors.location) {
        let names: Vec<String> = others.iter().map(ToString::to_string).collect();
        let help = match names.as_slice() {
            [] => "remove it".to_owned(),
            names => format!(
                "on this machine {} describes this angle; a squareness of two axes changes its sign if the other axis states it",
                names.join(" or ")
            ),
        };
        let message = format!(
            "{name} has no effect on this machine: it tilts the workpiece together with all axes on its side, so no angle between axes changes"
        );
        root.report(Code::NO_EFFECT, section.place_of_key(&name.to_string()), message, help);
    }
}

/// Reports errors of the machine and of its heads whose size is not plausible.
fn check_sizes(root: &mut Section<'_>, machine: &Machine, errors: &ErrorModel) {
    let is_fitted = plausible::fitted(machine);
    let [location, motion] = match errors.head_entries {
        Some(HeadEntries { common: [location, motion, _], .. }) => [location, motion],
        None => [errors.location.len(), errors.motion.len()],
    };
    let common = (errors.location.get(..location), errors.motion.get(..motion));
    if let (Some(location), Some(motion)) = common {
        let found = plausible::check(root, machine, (location, motion), &is_fitted);
        root.add(found);
    }
    for (mut section, own) in root.sections("head").into_iter().zip(&errors.heads) {
        let Some([location, motion, _]) = own.head_entries.map(|entries| entries.common) else { continue };
        if let (Some(location), Some(motion)) = (own.location.get(location..), own.motion.get(motion..)) {
            let found = plausible::check(&mut section, machine, (location, motion), &is_fitted);
            root.add(found);
        }
    }
}

/// Reports a rotation of the spindle about its own axis, which moves nothing.
fn check_spindle(section: &mut Section<'_>, axis: &Vector) {
    let Some(location) = section.section("location") else { return };
    for key in location.keys() {
        let Ok(name) = key.parse::<ErrorName>() else { continue };
        let along = Vector::ith(name.direction.index() % 3, 1.0);
        if name.axis().is_some() || !name.direction.is_rotation() || axis.cross(&along).norm() > PARALLEL {
            continue;
        }
        let message = format!("{key} is a rotation of the spindle about its own axis, which moves nothing");
        let help = "remove it; the tilts of a spindle are rotations about the other two directions";
        section.report(Code::UNKNOWN_COMPONENT, location.place_of_key(key), message, help);
    }
}

/// Reports names of `[uncertainty]` that are no parameter of this machine.
fn check_uncertainty(root: &mut Section<'_>, axes: AxisSet, errors: &ErrorModel, findings: &mut Vec<Diagnostic>) {
    let Some(mut section) = root.section(uncertainty::SECTION) else { return };
    let names: Vec<&str> = section.keys().collect();
    for name in names {
        section.accept(name);
        let found = UncertainParameter::find(name, errors);
        let is_of_machine = |one: UncertainParameter| {
            one.component().and_then(|component| component.axis()).is_none_or(|axis| axes.contains(axis))
        };
        if name == uncertainty::UNEXPLAINED || found.is_some_and(is_of_machine) {
            continue;
        }
        let message = format!("{name} is not a parameter of the error model of this machine");
        let help = "write a parameter such as EC0Y, EXX1 or EXXb, a motion error such as EXX, or a parameter of an effect as `ncfix calibrate` names it";
        section.report(Code::UNKNOWN_COMPONENT, section.place_of_key(name), message, help);
    }
    section.finish(findings);
}

/// Returns the axes that have a section, valid or not: faults of the chain are reported elsewhere and must not hide others.
fn axes_in(mut root: Section<'_>) -> AxisSet {
    let letters = root.section("axis").map(|section| section.keys().collect::<Vec<_>>()).unwrap_or_default();
    letters
        .into_iter()
        .filter_map(|key| match key.as_bytes() {
            [letter @ b'A'..=b'Z'] => Axis::from_letter(*letter),
            _ => None,
        })
        .collect()
}

pub(super) fn read_location(
    mut section: Section<'_>,
    axes: AxisSet,
    findings: &mut Vec<Diagnostic>,
) -> Vec<LocationError> {
    let mut errors = Vec::new();
    let keys: Vec<&str> = section.keys().collect();
    for key in keys {
        section.accept(key);
        let help = "write E, a direction, 0 and an axis of the machine or S, for example EC0Y or EX0S";
        let place = section.place_of_key(key);
        let Some(name) = known_component(&mut section, key, place, axes, ErrorKind::Location, help) else { continue };
        let is_angle = name.direction.is_rotation();
        if let Some(value) = section.number_in(key, if is_angle { "_urad" } else { "_um" }) {
            let value = if is_angle { rad_from_urad(value) } else { mm_from_um(value) };
            errors.push(LocationError { name, value });
        }
    }
    section.finish(findings);
    errors
}

pub(super) fn read_motion(
    mut section: Section<'_>,
    axes: AxisSet,
    kinds: &MotionKinds,
    findings: &mut Vec<Diagnostic>,
) -> Option<MotionError> {
    let component = section.required("component", "\"EXX\"", Section::text);
    let place = section.place_of("component");
    let help = "write E, a direction and an axis of the machine, for example EXX or EAY";
    let name = component.and_then(|text| known_component(&mut section, text, place, axes, ErrorKind::Motion, help));
    let kind = read_kind(&mut section, kinds);
    let (Some(name), Some(kind)) = (name, kind) else {
        // Without component and kind the other keys cannot be checked.
        let keys: Vec<&str> = section.keys().collect();
        keys.into_iter().for_each(|key| section.accept(key));
        section.finish(findings);
        return None;
    };
    let mut entry = Entry { section, name, axes };
    let function = kind.read(&mut entry);
    entry.section.finish(findings);
    Some(MotionError { name, function: function? })
}

/// Reads the kind of a function; reports a missing or unknown kind.
pub(super) fn read_kind<'k>(section: &mut Section<'_>, kinds: &'k MotionKinds) -> Option<&'k dyn MotionKind> {
    let text = section.required("kind", "\"polynomial\"", Section::text)?;
    let kind = kinds.find(text);
    if kind.is_none() {
        let known: Vec<&str> = kinds.names().collect();
        let help = match nearest(text, known.iter().copied()) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => format!("write one of {}", known.join(", ")),
        };
        section.report(Code::BAD_VALUE, section.place_of("kind"), format!("unknown kind \"{text}\""), help);
    }
    kind
}

/// Reads a component by its name; reports `E0406` if this machine does not have it or it is not of this kind.
pub(super) fn known_component(
    section: &mut Section<'_>,
    text: &str,
    place: Place,
    axes: AxisSet,
    kind: ErrorKind,
    help: &str,
) -> Option<ErrorName> {
    let fault = match text.parse::<ErrorName>() {
        Err(_) => format!("\"{text}\" is not an error component"),
        Ok(name) if name.axis().is_some_and(|axis| !axes.contains(axis)) => {
            format!("{text}: the machine has no axis {}", char::from(text.as_bytes()[text.len() - 1]))
        }
        Ok(name) if name.kind != kind => match kind {
            ErrorKind::Location => format!("{text} is a motion error, it belongs in [[motion]]"),
            ErrorKind::Motion => format!("{text} is a location error, it belongs in [location]"),
        },
        Ok(name) => return Some(name),
    };
    section.report(Code::UNKNOWN_COMPONENT, place, fault, help);
    None
}
