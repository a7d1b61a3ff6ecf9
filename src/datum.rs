//! The datum of a job: the zero offsets that a program uses, the method by which each was set, and the error of the machine that a touched one contains.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{FRAC_PI_2, PI};

use crate::diagnostics::Diagnostics;
use crate::first_tools::{self, FirstTools};
use crate::machine::Machine;
use crate::program::Program;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Vector};
use ncfix_base::number::significant;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_language::exec;
use ncfix_machine::machine::condition::Condition;
use ncfix_machine::machine::zero_offset::common_name;
use ncfix_machine::machine::{Datum, State};
use ncfix_machine::snc::Kind;
use ncfix_model::Model;
use ncfix_report::json::{ZeroReport, components_um};

/// A model of the machine with the errors that its zero offsets contain.
pub(crate) fn with_zeros(chosen: &Machine, model: Model) -> Model {
    let machine = &chosen.machine;
    if all(chosen).next().is_none() || model.is_empty() {
        return model;
    }
    let earlier = chosen.condition.zero().map(|_| {
        let then = chosen.condition.when_zeroed();
        Model::at(machine, &chosen.errors, &then)
    });
    let then = earlier.as_ref().unwrap_or(&model);
    // The temperature of the machine at a touch that no file states is unknown: drift counts from the reference condition.
    let reference = Model::at(machine, &chosen.errors, &Condition::default());
    let datums = all(chosen).zip(0_u16..).map(|((name, shift), index)| {
        let datum = datum_of(chosen, name, index);
        let is_assumed = datum.setting.is_none() && earlier.is_none();
        let then = if is_assumed { &reference } else { then };
        let touch_mm = then.displacement_at(&[0, 1, 2].map(|side| datum.pose(side, &shift, machine)));
        let touch_mm = if touch_mm.iter().all(|mm| mm.is_finite()) { touch_mm } else { Vector::zeros() };
        (touch_mm, is_relative(&datum))
    });
    let (touches_mm, relative): (Vec<Vector>, Vec<bool>) = datums.unzip();
    model.with_zeros(&touches_mm, &relative)
}

/// A touch from a side that nothing states is wrong by half of the reversal to one side or the other. A normal amount with this share of it has both in its
/// interval of 95 %: 1.96 times 0.6 is more than 1.
const OF_HALF_REVERSAL: f64 = 0.6;
/// Displacements below this are rounding noise, mm.
const NOISE_MM: f64 = 1e-9;

/// The models after one standard deviation of each axis whose touched zeros do not state from which side they were touched.
pub(crate) fn of_unknown_sides(chosen: &Machine) -> Vec<Model> {
    let base = chosen.model();
    let names: Vec<&String> = all(chosen).map(|(name, _)| name).collect();
    let touches_of =
        |model: &Model| -> Vec<Vector> { names.iter().zip(0_u16..).map(|(_, index)| model.touch_mm(index)).collect() };
    let own_mm = touches_of(&base);
    let relative: Vec<bool> =
        names.iter().map(|name| is_relative(&chosen.machine.datums.get(*name).copied().unwrap_or_default())).collect();
    let of_axis = |(side, axis): (usize, Axis)| {
        let mut other = chosen.clone();
        for name in &names {
            let datum = other.machine.datums.entry((*name).clone()).or_default();
            let direction = &mut datum.at[side].direction[axis.slot()];
            if *direction == 0 {
                *direction = 1;
            }
        }
        let touches_mm = touches_of(&other.model());
        let varied_mm: Vec<Vector> =
            own_mm.iter().zip(&touches_mm).map(|(own, other)| own + (other - own) * OF_HALF_REVERSAL).collect();
        let is_felt = own_mm.iter().zip(&varied_mm).any(|(own, varied)| (varied - own).amax() > NOISE_MM);
        is_felt.then(|| base.clone().with_zeros(&varied_mm, &relative))
    };
    [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate().filter_map(of_axis).collect()
}

/// The machine with other lengths of a tool or probe that touched, where nothing states the length and it matters: anything from a touch without a tool to the
/// longest tool is possible. The length that counts is in between.
pub(crate) fn of_other_lengths(chosen: &Machine) -> Vec<Machine> {
    let zeros: Vec<(&String, u16)> = all(chosen).map(|(name, _)| name).zip(0_u16..).collect();
    let is_open = |name: &str, index: u16| {
        let datum = datum_of(chosen, name, index);
        is_relative(&datum) && chosen.machine.datums.get(name).is_none_or(has_open_length)
    };
    let open: Vec<(&String, u16)> = zeros.into_iter().filter(|(name, index)| is_open(name, *index)).collect();
    if open.is_empty() {
        return Vec::new();
    }
    let touches_of = |machine: &Machine| -> Vec<Vector> {
        let model = machine.model();
        open.iter().map(|(_, index)| model.touch_mm(*index)).collect()
    };
    let counted_mm = touches_of(chosen);
    let of_file = chosen.machine.tools.iter().map(|tool| tool.length_mm[0]);
    // A control that measures tools from the machine zero has negative lengths.
    let [shortest_mm, longest_mm] = of_file
        .chain(chosen.first_tools_mm.values().copied())
        .fold([0.0_f64; 2], |[low, high], length_mm| [low.min(length_mm), high.max(length_mm)]);
    let with = |length_mm: f64| {
        let mut other = chosen.clone();
        for (name, _) in &open {
            let datum = other.machine.datums.entry((*name).clone()).or_default();
            datum.at.iter_mut().for_each(|at| at.tool_length_mm = at.tool_length_mm.or(Some(length_mm)));
        }
        other
    };
    let differs = |other: &Machine| {
        let touches_mm = touches_of(other);
        counted_mm.iter().zip(&touches_mm).any(|(own, other)| (other - own).amax() > NOISE_MM)
    };
    [shortest_mm, 0.5 * (shortest_mm + longest_mm), longest_mm].map(with).into_iter().filter(differs).collect()
}

/// True if a touch of it has no stated length.
fn has_open_length(datum: &Datum) -> bool {
    datum.at.iter().any(|at| at.tool_length_mm.is_none())
}

/// The statement about a zero offset. If it says that the zero was touched and not with which tool, that is the first one with which the program cuts there.
fn datum_of(chosen: &Machine, name: &str, index: u16) -> Datum {
    let mut datum = chosen.machine.datums.get(name).copied().unwrap_or_default();
    let first_mm = chosen.first_tools_mm.get(&index).copied().filter(|_| datum.setting.is_some());
    datum.at.iter_mut().for_each(|at| at.tool_length_mm = at.tool_length_mm.or(first_mm));
    datum
}

/// Names and shifts of all zero offsets, by index: those of the machine file, and then those that the program sets.
fn all(chosen: &Machine) -> impl Iterator<Item = (&String, AxisVector)> {
    let of_file = chosen.machine.zero_offsets.iter().map(|(name, zero)| (name, zero.shift()));
    of_file.chain(chosen.written_zeros.iter().map(|(name, shift)| (name, *shift)))
}

/// Beginnings of words with which a program sets a zero offset itself: G10, `$P_UIFR`, `$P_IFRAME`, `#5221`, `#7001`, `#[…]`.
const SETTERS: [&[u8]; 6] = [b"G10", b"UIFR", b"IFRAME", b"#5", b"#7", b"#["];

/// Maximum number of executed elements of this: a program may have no end.
const MOST_ELEMENTS: usize = 10_000_000;

/// The machine with the values of the zero offsets that a program sets itself, and with the first tool of each offset. If the program may set any, or if a
/// touch depends on a length that nothing states, it is executed once.
pub(crate) fn with_written(program: &Program, chosen: &Machine) -> Machine {
    let mut out = chosen.clone();
    out.written_zeros.clear();
    out.first_tools_mm.clear();
    let sets = |at: usize, text: &[u8]| {
        SETTERS.iter().any(|word| text.get(at..at + word.len()).is_some_and(|part| part.eq_ignore_ascii_case(word)))
    };
    let bytes = program.bytes();
    let begins = |byte: &u8| matches!(byte, b'G' | b'g' | b'U' | b'u' | b'I' | b'i' | b'#');
    let may_set = bytes.iter().enumerate().any(|(at, byte)| begins(byte) && sets(at, bytes));
    let model = chosen.model();
    let asked = if model.is_empty() { Vec::new() } else { first_tools::asked(chosen, &model, all(chosen)) };
    if model.is_empty() || !may_set && asked.is_empty() {
        return out;
    }
    let Ok(Some(opened)) = program.open(Some(chosen), &mut Diagnostics::default()) else { return out };
    let elements = program.start_as(opened, &chosen.machine, exec::Options::default());
    let first = chosen.machine.zero_offsets.len();
    let mut found: BTreeMap<usize, (String, AxisVector)> = BTreeMap::new();
    let mut tools = FirstTools::new(&chosen.machine);
    for element in elements.take(MOST_ELEMENTS).flatten() {
        tools.see(&element.kind);
        if !may_set && tools.has_all(&asked) {
            break;
        }
        if let Kind::Setup(setup) = &element.kind
            && let Some(written) = &setup.written_zero
        {
            let index = usize::from(written.index).saturating_sub(first);
            found.entry(index).or_insert_with(|| (written.name.clone(), written.shift));
        }
    }
    // A value that was replaced before any motion has an index, but no move counts from it.
    let count = found.keys().next_back().map_or(0, |last| last + 1);
    out.written_zeros = (0..count).map(|index| found.remove(&index).unwrap_or_default()).collect();
    out.first_tools_mm = tools.lengths_mm();
    out
}

/// True if errors are relative to the touched position.
fn is_relative(datum: &Datum) -> bool {
    datum.method().is_relative()
}

/// The zero offsets of these indices, with a warning for those without a stated method if it matters by more than
/// `tolerance_mm`.
pub(crate) fn of_run(
    chosen: &Machine,
    model: &Model,
    used: &BTreeSet<u16>,
    tools_mm: Option<[Vector; 2]>,
    tolerance_mm: f64,
    found: &mut Diagnostics,
) -> Vec<ZeroReport> {
    let machine = &chosen.machine;
    let used: Vec<_> = all(chosen).zip(0_u16..).filter(|(_, index)| used.contains(index)).collect();
    let reports = used.iter().map(|((name, shift), index)| {
        let datum = datum_of(chosen, name, *index);
        let contains_mm = model.touch_mm(*index);
        ZeroReport {
            name: machine.shown_offset(name),
            set: datum.method().name(),
            is_stated: datum.setting.is_some(),
            contains_um: [0, 1, 2].map(|axis| um_from_mm(contains_mm[axis])),
            distance_um: um_from_mm(contains_mm.norm()),
            turned_urad: turned_urad(machine, model, &datum, shift),
        }
    });
    let reports: Vec<ZeroReport> = reports.collect();
    let is_doubtful = |one: &&ZeroReport| !one.is_stated && one.distance_um > um_from_mm(tolerance_mm);
    // On the demo machine no workpiece was touched off.
    for one in reports.iter().filter(is_doubtful).filter(|_| !chosen.is_demo) {
        let name = &one.name;
        let message = format!("nothing states how {name} was set, so it counts as touched; {}", one.contents());
        let mut help = format!(
            "if you touched it off or probed it, write set = \"touched\" in [{}]; if it is the true position in the machine, set = \"absolute\"",
            section(name)
        );
        if machine.zero_offsets.contains_key(&common_name(name)) {
            help += &format!("; or give {} or {}", option(name, "touched"), option(name, "absolute"));
        }
        found.add(Diagnostic::nowhere(Code::ZERO_NOT_STATED, message, help), &[]);
    }
    let is_of_other_value = |one: &&ZeroReport| {
        one.distance_um > um_from_mm(tolerance_mm)
            && machine.datums.get(&common_name(&one.name)).is_some_and(|datum| datum.is_of_other_value)
    };
    for one in reports.iter().filter(is_of_other_value) {
        let name = &one.name;
        let message = format!(
            "{name} counts as absolute, as stated beside its earlier value, but a later file gives another value; {}",
            one.contents()
        );
        let help = format!(
            "if you touched it off since, give {}; if the new value is the true position, {}",
            option(name, "touched"),
            option(name, "absolute")
        );
        found.add(Diagnostic::nowhere(Code::ZERO_NOT_STATED, message, help), &[]);
    }
    for one in reports.iter().filter(|one| !one.is_stated && !chosen.is_demo) {
        let Some(drift_mm) = since_reference_mm(chosen, model, &common_name(&one.name)) else { continue };
        let parts = components_um([0, 1, 2].map(|axis| um_from_mm(drift_mm[axis])));
        if drift_mm.norm() <= tolerance_mm || parts.is_empty() {
            continue;
        }
        let name = &one.name;
        let message = format!(
            "nothing states how {name} was set, so temperature and weight are corrected from the reference condition; if you touched off at these temperatures and this weight, the correction is too large by {}",
            parts.join(", ")
        );
        let help = format!(
            "if you touched off at these temperatures and this weight, give {}; for another time, --zero-time or [zero]; if the zero is the true position, {}",
            option(name, "touched"),
            option(name, "absolute")
        );
        found.add(Diagnostic::nowhere(Code::ZERO_NOT_STATED, message, help), &[]);
    }
    let tools_mm = tools_mm.filter(|_| !chosen.is_demo);
    for ((name, shift), index) in &used {
        let datum = machine.datums.get(*name).copied().unwrap_or_default();
        let first_mm = chosen.first_tools_mm.get(index).copied().filter(|_| datum.setting.is_some());
        let finding = tools_mm.and_then(|tools_mm| {
            length_unstated(chosen, model, (name, &datum, shift), (first_mm, tools_mm), tolerance_mm)
        });
        finding.into_iter().for_each(|finding| found.add(finding, &[]));
        let finding = rotary_unstated(chosen, model, (name, &datum, shift), tolerance_mm);
        finding.into_iter().for_each(|finding| found.add(finding, &[]));
    }
    reports
}

/// Angles of a rotary axis beside the assumed one at which a touch is tried, rad: a quarter to both sides, and the half turn.
const OTHER_ANGLES_RAD: [f64; 3] = [FRAC_PI_2, -FRAC_PI_2, PI];

/// A warning if a zero states where linear axes were at the touch and not where rotary axes were, and this matters by more than `tolerance_mm`.
fn rotary_unstated(
    chosen: &Machine,
    model: &Model,
    (name, datum, shift): (&String, &Datum, &AxisVector),
    tolerance_mm: f64,
) -> Option<Diagnostic> {
    let machine = &chosen.machine;
    let states = |axis: Axis| datum.at.iter().any(|at| at.stated.contains(axis));
    if !datum.method().is_relative() || !AxisSet::XYZ.iter().any(states) {
        return None;
    }
    let contained_mm = |turned: Option<(Axis, f64)>| {
        let pose = |side: usize| {
            let mut pose = datum.pose(side, shift, machine);
            turned.into_iter().for_each(|(axis, rad)| pose.command[axis] += rad);
            pose
        };
        model.displacement_at(&[0, 1, 2].map(pose))
    };
    let counted_mm = contained_mm(None);
    let open: Vec<Axis> = machine.axis_set().iter().filter(|axis| axis.is_rotary() && !states(*axis)).collect();
    let within = |axis: Axis, rad: f64| {
        let end = shift[axis] + rad;
        machine.axis(axis).and_then(|data| data.travel).is_none_or(|[low, high]| (low..=high).contains(&end))
    };
    let tried = open.iter().flat_map(|axis| OTHER_ANGLES_RAD.map(|rad| (*axis, rad)));
    let changes =
        tried.filter(|(axis, rad)| within(*axis, *rad)).map(|turned| (turned, contained_mm(Some(turned)) - counted_mm));
    let ((axis, rad), change_mm) = changes.max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()))?;
    let parts = components_um([0, 1, 2].map(|side| um_from_mm(change_mm[side])));
    if !(change_mm.norm() > tolerance_mm && change_mm.norm().is_finite()) || parts.is_empty() {
        return None;
    }
    let shown = machine.shown_offset(name);
    let listed = |value: &dyn Fn(Axis) -> String| open.iter().map(|axis| value(*axis)).collect::<Vec<_>>().join(", ");
    // To the increment of a control, without zeros at the end.
    let shown_deg = |rad: f64| format!("{}", (rad.to_degrees() * 1e4).round() / 1e4 + 0.0);
    let degrees = |axis: Axis| shown_deg(shift[axis]);
    let counted = listed(&|axis| format!("{axis} {}°", degrees(axis)));
    let message = format!(
        "{shown} counts as touched at {counted}, because the touch states no position of {}; if {axis} was at {}°, the zero is wrong by {}",
        listed(&|axis| axis.to_string()),
        shown_deg(shift[axis] + rad),
        parts.join(", ")
    );
    let help = format!(
        "state the positions of the rotary axes at the touch: {} in [{}.set_at], or {} in --zero",
        listed(&|axis| format!("{axis}_deg = {}", degrees(axis))),
        section(&shown),
        listed(&|axis| format!("{axis}{}", degrees(axis)))
    );
    Some(Diagnostic::nowhere(Code::ZERO_TURNED, message, help))
}

/// Step of a rotary axis for the direction in which it turns the tool relative to the workpiece, rad.
const TURN_STEP_RAD: f64 = 1e-3;

/// The rotary axes of the workpiece with a zero of their own, and the error of each angle where the zero was set, µrad: an axis turns this much farther than
/// commanded. A workpiece that was aligned by turning the axis stands at this true angle.
fn turned_urad(
    machine: &ncfix_machine::machine::Machine,
    model: &Model,
    datum: &Datum,
    shift: &AxisVector,
) -> Vec<(Axis, f64)> {
    let pose = datum.pose(2, shift, machine);
    let state = State { direction: pose.direction, ..State::default() };
    // Squareness and tilts act at every angle: only the difference from the zero of the axis is an error of the angle.
    let turned_rad = |command: &AxisVector, axis: Axis| {
        let nominal = model.nominal(command, &pose.tool_mm);
        let mut next = *command;
        next[axis] += TURN_STEP_RAD;
        let way = nominal.turn_to(&model.nominal(&next, &pose.tool_mm)) / TURN_STEP_RAD;
        nominal.turn_to(&model.actual(command, &pose.tool_mm, &state)).dot(&way) / way.norm_squared()
    };
    let of_axis = |axis: Axis| {
        let mut zero = pose.command;
        zero[axis] = 0.0;
        let urad = urad_from_rad(turned_rad(&pose.command, axis) - turned_rad(&zero, axis));
        urad.is_finite().then_some((axis, urad))
    };
    let is_own = |axis: &Axis| axis.is_rotary() && machine.topology.workpiece.contains(axis) && shift[*axis] != 0.0;
    machine.axis_set().iter().filter(is_own).filter_map(of_axis).collect()
}

/// Warns of each zero offset whose method the command line states and in which no axis moves.
pub(crate) fn without_use(chosen: &Machine, used: &BTreeSet<u16>, found: &mut Diagnostics) {
    let named = all(chosen).zip(0_u16..).filter(|(_, index)| used.contains(index));
    let names: Vec<&str> = named.map(|((name, _), _)| name.as_str()).collect();
    // On a machine without errors, the names of offsets that the program sets itself are not collected.
    if names.len() < used.len() {
        return;
    }
    let used = names;
    for name in chosen.stated_zeros.iter().filter(|name| !used.contains(&name.as_str())) {
        let place = match used.as_slice() {
            [] => "no zero offset is in force where the axes move".to_owned(),
            used => {
                let shown: Vec<String> = used.iter().map(|name| chosen.machine.shown_offset(name)).collect();
                format!("the axes move in {}", shown.join(", "))
            }
        };
        let message = format!("{} has no effect: {place}", option(&chosen.machine.shown_offset(name), "…"));
        let help = match used.first() {
            None => "check the program: positions in the coordinates of the machine have no touched zero".to_owned(),
            Some(used) => {
                let example = option(&chosen.machine.shown_offset(used), "touched");
                format!("check the name: for example {example}; or check the offset in the program")
            }
        };
        found.add(Diagnostic::nowhere(Code::ZERO_NOT_USED, message, help), &[]);
    }
}

/// A warning if a zero that contains the error of the machine depends on the length of the tool at the touch by more than `tolerance_mm`, and no length
/// is stated. `first_mm` is the length of the first tool there, which counts; the other lengths are 0, and those of the shortest and the longest tool of
/// the program.
fn length_unstated(
    chosen: &Machine,
    model: &Model,
    (name, datum, shift): (&String, &Datum, &AxisVector),
    (first_mm, tools_mm): (Option<f64>, [Vector; 2]),
    tolerance_mm: f64,
) -> Option<Diagnostic> {
    if !datum.method().is_relative() {
        return None;
    }
    let contained_mm = |length_mm: f64| {
        let mut stated = *datum;
        stated.at.iter_mut().for_each(|at| at.tool_length_mm = at.tool_length_mm.or(Some(length_mm)));
        model.displacement_at(&[0, 1, 2].map(|side| stated.pose(side, shift, &chosen.machine)))
    };
    let counted_mm = contained_mm(first_mm.unwrap_or(0.0));
    let [shortest_mm, longest_mm] = tools_mm.map(|tool_mm| first_tools::length_mm(&chosen.machine, &tool_mm));
    let changes = [0.0, shortest_mm, longest_mm].map(|length_mm| (length_mm, contained_mm(length_mm) - counted_mm));
    let (length_mm, change_mm) = changes.into_iter().max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()))?;
    let parts = components_um([0, 1, 2].map(|axis| um_from_mm(change_mm[axis])));
    if !(change_mm.norm() > tolerance_mm && change_mm.norm().is_finite()) || parts.is_empty() {
        return None;
    }
    let [first, other] =
        [first_mm.unwrap_or(0.0), length_mm].map(|mm| if mm == 0.0 { "0".to_owned() } else { significant(mm) });
    let counted = match first_mm {
        Some(_) => format!("the first tool of the program there, of length {first} mm"),
        None => "a tool of length 0".to_owned(),
    };
    let shown = chosen.machine.shown_offset(name);
    let message = format!(
        "{shown} counts as touched with {counted}, because no length is stated; if a tool of length {other} mm touched, the zero is wrong by {}",
        parts.join(", ")
    );
    let mut help = format!(
        "state the length of the tool or probe at the touch: tool_length_mm in [{}.set_at], or 0 for a touch without a tool",
        section(&shown)
    );
    if chosen.machine.zero_offsets.contains_key(name) {
        let example = if first_mm.is_some() { first } else { other };
        help += &format!("; or {}", option(&shown, &format!("{}@L{example}", datum.method().name())));
    }
    Some(Diagnostic::nowhere(Code::ZERO_LENGTH_NOT_STATED, message, help))
}

/// The section of a zero offset in the machine file: `zero_offset.G54`, `zero_offset."G154 P5"`.
fn section(name: &str) -> String {
    let is_bare = name.bytes().all(|byte| byte.is_ascii_alphanumeric());
    if is_bare { format!("zero_offset.{name}") } else { format!("zero_offset.\"{name}\"") }
}

/// The option that states a method: `--zero G54=touched`, `--zero "G154 P5=touched"`.
fn option(name: &str, method: &str) -> String {
    if name.contains(' ') { format!("--zero \"{name}={method}\"") } else { format!("--zero {name}={method}") }
}

/// Returns the displacement by temperature and weight at the touch of a zero offset, relative to the reference condition, in the directions of the workpiece,
/// mm. `None` if the condition states when the zero was set, or if the zero is not one of the machine.
fn since_reference_mm(chosen: &Machine, model: &Model, name: &str) -> Option<Vector> {
    if chosen.condition.zero().is_some() {
        return None;
    }
    let machine = &chosen.machine;
    let ((_, shift), index) = all(chosen).zip(0_u16..).find(|((own, _), _)| *own == name)?;
    let datum = datum_of(chosen, name, index);
    let poses = [0, 1, 2].map(|side| datum.pose(side, &shift, machine));
    let reference = Model::at(machine, &chosen.errors, &Condition::default());
    let drift_mm = model.displacement_at(&poses) - reference.displacement_at(&poses);
    drift_mm.iter().all(|mm| mm.is_finite()).then_some(drift_mm)
}

/// The offset of a Fanuc that is added to all others.
const EXTERNAL: &str = "EXT";

/// The zero offsets that count as touched, for the stamp: `G54-touched`; `unstated-touched` stands for all without a statement.
pub(crate) fn stamped(chosen: &Machine) -> Option<String> {
    let machine = &chosen.machine;
    let stated = |name: &String| machine.datums.get(name).and_then(|datum| datum.setting);
    let names: BTreeSet<&String> = all(chosen).map(|(name, _)| name).collect();
    let relative = names.into_iter().filter_map(|name| Some((name, stated(name)?)));
    let relative = relative.filter(|(_, setting)| setting.is_relative());
    let shown_in_stamp = |name: &String| machine.shown_offset(name).replace(' ', "_");
    let mut parts: Vec<String> =
        relative.map(|(name, setting)| format!("{}-{}", shown_in_stamp(name), setting.name())).collect();
    // An external offset of 0 adds nothing to a zero.
    let adds = |name: &String, shift: &AxisVector| name != EXTERNAL || *shift != AxisVector::ZERO;
    if all(chosen).any(|(name, shift)| stated(name).is_none() && adds(name, &shift)) {
        parts.push(format!("unstated-{}", Datum::default().method().name()));
    }
    (!parts.is_empty()).then(|| parts.join(","))
}
