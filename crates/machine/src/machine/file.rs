//! Machine file: the part that describes the machine itself. Its error model is read by `ncfix_model::file`.
//!
//! Units are part of the keys: mm, degrees, mm/min. A file is read as a whole, and all its faults are reported in one run. A set-up file contains only zero
//! offsets and tools and is applied to a machine by [`apply_setup`].

use std::collections::BTreeMap;

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, AxisSet, Plane, Vector};
use ncfix_base::source::Source;

use super::condition::file::READABLE_C;
use super::controller::{ControllerMeaning, controller, starts_with_g98, states_retraction};
use super::zero_offset::{ZeroOffsets, check_name, common_name, read_zero_offsets};
use super::{ActiveTables, AxisData, Control, Firmware, Lever, Machine, ToolChange, Topology};
use super::{active, head, load_sensor, measured, opaque, orientation, servo, setting, strain, tool, uncertainty};

pub use super::document::Document as MachineFile;
pub use super::section::{Section, nearest};

/// Built-in machine for trying the program without a machine file; not for a real machine.
pub const DEMO: &str = include_str!(env!("NCFIX_DEMO"));

/// Top-level sections that describe the machine.
pub const SECTIONS: &[&str] = &[
    "machine",
    "axis",
    "spindle",
    "head",
    "control",
    "opaque",
    "zero_offset",
    "tool",
    "sensor",
    "strain",
    "load_sensor",
    "servo",
    "measured",
    "uncertainty",
    "system",
    "gud",
];

/// A Haas is a Fanuc with other meanings of some words.
const FANUC: &str = "fanuc";

/// Maximum deviation of the direction of a linear axis from its direction of F.
const PARALLEL_LIMIT: f64 = 1e-9;

/// Reads the machine without its errors. The machine is `None` if any diagnostic is an error.
#[must_use]
pub fn read_machine(file: &MachineFile) -> (Option<Machine>, Vec<Diagnostic>) {
    let mut findings = Vec::new();
    let mut root = file.root();
    let named = root.required("machine", "a section [machine] with name and topology", Section::section);
    let heading = named.map(|section| read_heading(section, &mut findings)).unwrap_or_default();
    let (axes, headers) = read_axes(root.section("axis"), &heading.controller, &mut findings);
    if let Some((topology, place)) = &heading.topology {
        check_chain(topology, *place, &headers, &mut findings);
    }
    let spindle = head::read_spindle(root.section("spindle"), &mut findings);
    let (heads, start) = head::read(&mut root, &mut findings);
    let controller = heading.controller.clone();
    let known = heading.topology.as_ref().map(|(topology, _)| topology.axis_set());
    let chain = known.unwrap_or(AxisSet::EMPTY);
    let mut control = read_control(root.section("control"), (&controller, heading.is_haas), chain, &mut findings);
    control.firmware = heading.firmware;
    if heading.starts_with_g98 && !states_retraction(&control.iso.startup_code) {
        control.iso.startup_code = format!("G98 {}", control.iso.startup_code).trim_end().to_owned();
    }
    opaque::read_sections(root.sections("opaque"), &mut control, &mut findings);
    let axis_set = known.unwrap_or_else(|| AXES.into_iter().collect());
    let ZeroOffsets { offsets: zero_offsets, datums, .. } =
        read_zero_offsets(&mut root, (axis_set, &axes), &controller, &mut findings);
    let tools = tool::read(&mut root, &mut findings);
    let sensor_references_c = read_sensors(root.section("sensor"), &mut findings);
    let system = setting::read(root.section("system"), true, &mut findings);
    let gud = setting::read(root.section("gud"), false, &mut findings);
    let strain = root.section("strain").and_then(|section| strain::read(section, axis_set, &mut findings));
    let load_sensors = load_sensor::read(root.sections("load_sensor"), &mut findings);
    let servo = root.section("servo").and_then(|section| servo::read(section, &axes, axis_set, &mut findings));
    let measured = root.section("measured").map(|section| measured::read(section, axis_set, &mut findings));
    let uncertainty = root.section(uncertainty::SECTION).map(|section| uncertainty::read(section, &mut findings));
    if let (false, Some(_), Some(section)) = (heads.is_empty(), control.grundig.head, root.section("control")) {
        let message = "grundig_head beside [[head]]: the heads themselves have the words that select them";
        let place = section.place_of_key("grundig_head");
        findings.push(Diagnostic::at(Code::BAD_HEAD, place, message, "remove grundig_head"));
    }
    // Other modules have their own sections; the last reader reports unknown ones.
    let keys: Vec<&str> = root.keys().collect();
    keys.into_iter().for_each(|key| root.accept(key));
    root.finish(&mut findings);
    let sound = !findings.iter().any(Diagnostic::is_error);
    let MachineHeading {
        name: Some(name),
        topology: Some((topology, _)),
        controller,
        reference_temperature_c,
        active_tables,
        axis_order,
        ..
    } = heading
    else {
        return (None, findings);
    };
    let mut machine = Machine {
        name,
        topology,
        controller,
        reference_temperature_c,
        sensor_references_c,
        active_tables,
        axis_order,
        axes,
        spindle,
        heads,
        has_fixed_head: false,
        control,
        zero_offsets,
        partial_offsets: BTreeMap::new(),
        datums,
        tools,
        radius_wear_mm: BTreeMap::new(),
        base_frames: BTreeMap::new(),
        parameters: BTreeMap::new(),
        system,
        gud,
        strain,
        load_sensors,
        servo,
        measured,
        uncertainty,
    };
    machine.start_with_head(start);
    (sound.then_some(machine), findings)
}

/// Reads `[sensor.NAME]`: the reference temperature of each sensor for the model, °C.
fn read_sensors(section: Option<Section<'_>>, findings: &mut Vec<Diagnostic>) -> BTreeMap<String, f64> {
    let Some(mut section) = section else { return BTreeMap::new() };
    let mut references = BTreeMap::new();
    let keys: Vec<&str> = section.keys().collect();
    for key in keys {
        if let Some(mut sensor) = section.section(key) {
            let reference_c = sensor.required("reference_C", "20.4", |section, key| {
                let [low, high] = READABLE_C;
                section.number_where(key, "a temperature from -60 to 400 °C", |value| (low..=high).contains(&value))
            });
            references.extend(reference_c.map(|value| (key.to_owned(), value)));
            sensor.finish(findings);
        }
    }
    section.finish(findings);
    references
}

/// Applies a set-up file to a machine: `[zero_offset.*]` and `[[tool]]` replace those of the same name, number and edge, or add to them. If there is an
/// error, the machine stays unchanged.
#[must_use]
pub fn apply_setup(source: &Source, machine: &mut Machine) -> Vec<Diagnostic> {
    let file = match MachineFile::parse(source) {
        Ok(file) => file,
        Err(findings) => return findings,
    };
    let mut findings = Vec::new();
    let mut root = file.root();
    let axes = (machine.topology.axis_set(), machine.axes.as_slice());
    let zeros = read_zero_offsets(&mut root, axes, &machine.controller, &mut findings);
    let tools = tool::read(&mut root, &mut findings);
    let system = setting::read(root.section("system"), true, &mut findings);
    let gud = setting::read(root.section("gud"), false, &mut findings);
    root.finish(&mut findings);
    if findings.iter().any(Diagnostic::is_error) {
        return findings;
    }
    for (name, parts) in zeros.offsets {
        // A method alone says how the known zero was set. It must not replace the zero by 0.
        if !zeros.without_value.contains(&name) || !machine.zero_offsets.contains_key(&name) {
            machine.set_zero_offset(name, parts);
        }
    }
    machine.datums.extend(zeros.datums);
    machine.system.extend(system);
    machine.gud.extend(gud);
    machine.set_tools(tools);
    findings
}

/// Content of `[machine]`; invalid parts are missing.
#[derive(Default)]
struct MachineHeading {
    name: Option<String>,
    topology: Option<(Topology, Place)>,
    controller: String,
    /// True if `controller` is a Haas, which speaks the language of a Fanuc.
    is_haas: bool,
    firmware: Option<Firmware>,
    starts_with_g98: bool,
    reference_temperature_c: f64,
    active_tables: ActiveTables,
    axis_order: Vec<Option<Axis>>,
}

fn read_heading(mut section: Section<'_>, findings: &mut Vec<Diagnostic>) -> MachineHeading {
    let name = section.required("name", "\"my machine\"", Section::text).map(str::to_owned);
    let written = section.required("topology", "\"wXYFZSt\"", Section::text);
    let written_controller = section.text("controller").unwrap_or("sinumerik");
    let meaning = controller(written_controller).map(|row| row.meaning);
    let is_haas = meaning == Some(ControllerMeaning::Haas);
    let firmware = Firmware::of(written_controller);
    let starts_with_g98 = starts_with_g98(written_controller);
    let controller = match meaning {
        Some(ControllerMeaning::Language(language)) => language,
        Some(ControllerMeaning::Haas) => FANUC,
        _ => written_controller,
    }
    .to_owned();
    let reference_temperature_c = section.number("reference_temperature_C").unwrap_or(20.0);
    let active_tables = active::read(&mut section);
    let axis_order = active::read_axis_order(&mut section);
    let place = section.place_of("topology");
    let topology = written.and_then(|text| match text.parse::<Topology>() {
        Ok(topology) => Some((topology, place)),
        Err(fault) => {
            let help =
                "write the bodies from the workpiece w through the foundation F to the tool t, for example wCBXFZYSt";
            section.report(Code::BAD_TOPOLOGY, place, format!("topology {text}: {fault}"), help);
            None
        }
    });
    section.finish(findings);
    MachineHeading {
        name,
        topology,
        controller,
        is_haas,
        firmware,
        starts_with_g98,
        reference_temperature_c,
        active_tables,
        axis_order,
    }
}

/// The axes that could be read, and the header of every axis section.
type Axes = ([Option<AxisData>; AXIS_COUNT], [Option<Place>; AXIS_COUNT]);

fn read_axes(section: Option<Section<'_>>, controller: &str, findings: &mut Vec<Diagnostic>) -> Axes {
    let mut axes = [const { None }; AXIS_COUNT];
    let mut headers = [None; AXIS_COUNT];
    let Some(mut section) = section else { return (axes, headers) };
    for axis in AXES {
        let key = axis.to_string();
        if section.has(&key) {
            headers[axis.slot()] = Some(section.place_of(&key));
        }
        if let Some(own) = section.section(&key) {
            axes[axis.slot()] = read_axis(axis, controller, own, findings);
        }
    }
    super::axis_name::check(&axes, &mut section);
    section.finish(findings);
    (axes, headers)
}

fn read_axis(
    axis: Axis,
    controller: &str,
    mut section: Section<'_>,
    findings: &mut Vec<Diagnostic>,
) -> Option<AxisData> {
    let (travel_key, feed_key, to_internal) = if axis.is_rotary() {
        ("travel_deg", "max_feed_deg_min", f64::to_radians as fn(f64) -> f64)
    } else {
        ("travel_mm", "max_feed_mm_min", std::convert::identity as fn(f64) -> f64)
    };
    let direction = section
        .required("direction", "[1, 0, 0]", Section::vector)
        .and_then(|direction| checked_direction(axis, direction, &mut section));
    let point_mm = section.vector("point_mm").unwrap_or_default();
    let travel = super::travel::read(axis, travel_key, &mut section).map(|ends| ends.map(to_internal));
    let modulo = axis.is_rotary() && section.boolean("modulo").unwrap_or(false);
    if modulo && section.has(travel_key) {
        let message = format!("axis {axis} is a modulo axis and has {travel_key}");
        let help = "remove one of them: modulo = true is for axes that may turn any number of times";
        section.report(Code::BAD_VALUE, section.place_of(travel_key), message, help);
    }
    if !section.has(travel_key) && !modulo {
        let message = format!("axis {axis} has no {travel_key}");
        let help = format!("add `{travel_key} = [lowest, highest]`, so that positions outside the travel are detected");
        section.report(Code::NO_TRAVEL, section.place(), message, help);
    }
    let start_rad = read_start(axis, travel, &mut section);
    let max_feed = section.number_where(feed_key, "a number above 0", |feed| feed > 0.0);
    let lever = match section.text("lever") {
        None | Some("carried") => Lever::Carried,
        Some("fixed") => Lever::Fixed,
        Some(other) => {
            let message = format!("lever must be \"carried\" or \"fixed\", found \"{other}\"");
            let help = "carried: errors move with the carriage; fixed: their arm includes the axis's own motion";
            section.report(Code::BAD_VALUE, section.place_of("lever"), message, help);
            Lever::Carried
        }
    };
    let clamps = super::clamp::read(axis, controller, &mut section);
    let name = super::axis_name::read(axis, &mut section);
    section.finish(findings);
    Some(AxisData { axis, name, direction: direction?, point_mm, travel, modulo, start_rad, max_feed, clamps, lever })
}

/// Reads the position of a rotary axis at the beginning of a program, rad.
fn read_start(axis: Axis, travel: Option<[f64; 2]>, section: &mut Section<'_>) -> Option<f64> {
    const KEY: &str = "start_deg";
    if !axis.is_rotary() {
        return None;
    }
    let start_rad = section.number(KEY)?.to_radians();
    if travel.is_some_and(|[low, high]| start_rad < low || start_rad > high) {
        let message = format!("start_deg of axis {axis} is outside its travel");
        let help = "write the position that the control shows when a program begins";
        section.report(Code::BAD_VALUE, section.place_of(KEY), message, help);
    }
    Some(start_rad)
}

/// Returns the unit vector of a direction. A linear axis must run along its own direction of F; a deviation belongs to the errors, not to the direction.
fn checked_direction(axis: Axis, direction: Vector, section: &mut Section<'_>) -> Option<Vector> {
    let place = section.place_of("direction");
    let Some(unit) = direction.try_normalize(1e-12).filter(|unit| unit.norm().is_finite()) else {
        section.report(
            Code::BAD_VALUE,
            place,
            format!("the direction of axis {axis} has no length"),
            "write for example [1, 0, 0]",
        );
        return None;
    };
    let own = axis.dimension();
    let strays = (0..3).any(|dimension| dimension != own && unit[dimension].abs() > PARALLEL_LIMIT);
    if !axis.is_rotary() && strays {
        let letter = ['X', 'Y', 'Z'][own];
        let message = format!("axis {axis} must run along {letter} of F");
        let help = "write the deviation in [location], for example EC0Y for an axis Y that leans towards X";
        section.report(Code::BAD_VALUE, place, message, help);
        return None;
    }
    Some(unit)
}

/// Checks that every letter of the topology has a section and every axis section a letter.
fn check_chain(
    topology: &Topology,
    topology_place: Place,
    headers: &[Option<Place>; AXIS_COUNT],
    findings: &mut Vec<Diagnostic>,
) {
    for axis in AXES {
        match (topology.branch(axis), headers[axis.slot()]) {
            (Some(_), None) => {
                let message = format!("axis {axis} of the topology has no section [axis.{axis}]");
                let help = format!("add [axis.{axis}] with its direction, or remove {axis} from the topology");
                findings.push(Diagnostic::at(Code::BAD_TOPOLOGY, topology_place, message, help));
            }
            (None, Some(place)) => {
                let message = format!("axis {axis} is not in the topology {topology}");
                let help = format!("add {axis} to the topology, or remove the section");
                findings.push(Diagnostic::at(Code::BAD_TOPOLOGY, place, message, help));
            }
            _ => {}
        }
    }
}

fn read_control(
    section: Option<Section<'_>>,
    (controller, is_haas): (&str, bool),
    chain: AxisSet,
    findings: &mut Vec<Diagnostic>,
) -> Control {
    let mut control = super::output_control::of_controller(controller);
    if is_haas {
        control.iso.become_haas();
    }
    let Some(mut section) = section else { return control };
    let not_negative = |value: f64| value >= 0.0;
    super::output_control::read(&mut section, &mut control);
    if let Some(value) = section.number_where("block_cycle_ms", "a positive number", |value| value > 0.0) {
        control.block_cycle_s = Some(value * 1e-3);
    }
    if let Some(value) = section.number_where("arc_tolerance_mm", "a number that is not negative", not_negative) {
        control.arc_tolerance_mm = value;
    }
    if let Some(value) = section.number_where("arc_tolerance_ratio", "a number that is not negative", not_negative) {
        control.arc_tolerance_ratio = value;
    }
    match section.text("tool_change") {
        None | Some("M6") => {}
        Some("T") => control.tool_change = ToolChange::T,
        Some(other) => {
            let message = format!("tool_change must be \"M6\" or \"T\", found \"{other}\"");
            let help = "M6: T selects and M6 changes; T: T changes the tool immediately";
            section.report(Code::BAD_VALUE, section.place_of("tool_change"), message, help);
        }
    }
    if let Some(plane) = section.number_where("initial_plane", "17, 18 or 19", |number| plane_of(number).is_some()) {
        control.initial_plane = plane_of(plane).unwrap_or(control.initial_plane);
    }
    if let Some(number) = section.number_where("tool_length_plane", "17, 18 or 19", |number| plane_of(number).is_some())
    {
        control.tool_length_plane = plane_of(number);
    }
    if let Some(value) = section.integer("edge_after_tool_change") {
        control.edge_after_tool_change = value;
    }
    if let Some(value) = section.boolean("incremental_traverses_frame_change") {
        control.incremental_traverses_frame_change = value;
    }
    opaque::read(&mut section, &mut control);
    opaque::read_axes(&mut section, &mut control, chain);
    super::frame_control::read(&mut section, &mut control);
    orientation::read(&mut section, &mut control);
    super::contour_control::read(&mut section, &mut control);
    super::iso_control::read(&mut section, &mut control.iso);
    super::output_control::keep_to_grid(&mut control, controller);
    super::macro_control::read(&mut section, &mut control.macros);
    super::grundig_control::read(&mut section, &mut control);
    if let Some(value) = section.number_where("chord_tolerance_mm", "a number above 0", |value| value > 0.0) {
        control.chord_tolerance_mm = value;
    }
    if let Some(value) = section.number_where("max_program_levels", "a whole number from 1 to 100", |levels| {
        (1.0..=100.0).contains(&levels) && levels.fract() == 0.0
    }) {
        control.max_program_levels = value as u32;
    }
    if let Some(name) = section.text("initial_zero_offset") {
        match check_name(name, controller) {
            Ok(()) => control.initial_zero_offset = Some(common_name(name)),
            Err(help) => {
                let message = format!("\"{name}\" is not a settable zero offset");
                section.report(Code::BAD_VALUE, section.place_of("initial_zero_offset"), message, help);
            }
        }
    }
    super::foreign_key::report(&mut section, controller);
    section.finish(findings);
    control
}

/// Returns the plane of 17, 18 or 19.
fn plane_of(number: f64) -> Option<Plane> {
    [Plane::XY, Plane::ZX, Plane::YZ].into_iter().find(|plane| f64::from(plane.number()) == number)
}
