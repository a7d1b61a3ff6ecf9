//! States at the start of a program that only the control knows: unit, zero offset, return of drilling cycles, reference positions.

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{Axis, AxisSet};
use ncfix_base::source::{Source, Span};
use ncfix_dialect::{Dialect, Language};
use ncfix_machine::machine::Setting;

/// Parameter of RS274/NGC with the number of the coordinate system in force: 1 for G54.
const SYSTEM_IN_FORCE: u32 = 5220;

/// Warnings of states that a program takes over from the control, and that neither it nor the startup code states: on a Fanuc the unit of lengths, in
/// RS274/NGC also where a drilling cycle ends, the positions of G28 and G30, and the zero offset if a file of the control has another one in force.
pub(crate) fn assumed_start(
    source: &Source,
    dialect: &Dialect,
    machine: &ncfix_machine::machine::Machine,
) -> Vec<Diagnostic> {
    if !matches!(dialect.language, Language::Rs274 | Language::Fanuc) {
        return Vec::new();
    }
    let (mut has_unit, mut has_return, mut has_offset, mut motion, mut cycle) = (false, false, false, None, None);
    // The place of the first G28 and G30, and the axes that any of them moves.
    let mut homes: [Option<(usize, AxisSet)>; 2] = [None; 2];
    let mut note = |code: u32, at: Option<usize>| match code {
        20 | 21 => has_unit = true,
        98 | 99 => has_return |= cycle.is_none(),
        54..=59 => has_offset = true,
        0..=3 => motion = motion.or(at),
        73 | 81..=83 | 85 | 86 | 88 | 89 => cycle = cycle.or(at),
        28 | 30 => {
            let home = &mut homes[usize::from(code == 30)];
            if let Some(at) = at {
                let moved = home_axes(source.bytes(), at, machine.axis_set());
                *home = Some(home.map_or((at, moved), |(first, known)| (first, known.union(moved))));
            }
        }
        _ => {}
    };
    each_g(machine.control.iso.startup_code.as_bytes(), |code, _| note(code, None));
    each_g(source.bytes(), |code, at| note(code, Some(at)));
    let warn = |at: usize, message: &str, help: &str| {
        let span = u32::try_from(at).map_or_else(|_| Span::default(), |start| Span { start, end: start + 1 });
        Diagnostic::at(Code::START_ASSUMED, Place { file: source.id(), span }, message, help)
    };
    let unit = motion.filter(|_| !has_unit).map(|at| {
        let message = "neither the program nor control.startup_code states G20 or G21: millimeters are assumed";
        let help = "write G21 or G20 at the beginning of the program, or state startup_code in [control]: the control keeps the unit of an earlier program";
        warn(at, message, help)
    });
    let retraction = cycle.filter(|_| !has_return).map(|at| {
        let message = "neither the program nor control.startup_code states G98 or G99 before this drilling cycle: G99 is assumed: the tool moves to the next hole at R, unless the control keeps G98 of an earlier program";
        let help = "write G98 (return to the initial level) or G99 (to R) before the cycle, or state startup_code in [control]";
        warn(at, message, help)
    });
    // From these parameters on, in the order of the axes, are the two positions.
    let home = [(28, 5161), (30, 5181)].into_iter().zip(homes).filter_map(|((code, first), home)| {
        let (at, moved) = home?;
        let name = |axis: Axis| format!("#{}", first + axis.slot());
        let is_stated = |name: &str| {
            machine.system.contains_key(name) || source.bytes().windows(name.len()).any(|text| text == name.as_bytes())
        };
        let unstated: Vec<Axis> = moved.iter().filter(|&axis| !is_stated(&name(axis))).collect();
        let lacking = name(*unstated.first()?);
        let axes = unstated.iter().map(Axis::to_string).collect::<Vec<_>>().join(", ");
        let message = format!("no file states the position of G{code} in {axes}: the machine zero is assumed, so the output moves there at rapid");
        let help = format!("give the file of the control with --setup (.var, or the answer to $#), or state \"{lacking}\" … in [system] of the machine file");
        Some(warn(at, &message, &help))
    });
    let in_force = match machine.system.get(&format!("#{SYSTEM_IN_FORCE}")) {
        Some(Setting::Number(value)) => Some(value.round()),
        Some(Setting::Whole(value)) => Some(*value as f64),
        _ => None,
    }
    .filter(|value| *value > 1.0);
    let offset = in_force.zip(motion).filter(|_| !has_offset && machine.control.initial_zero_offset.is_none()).map(|(value, at)| {
        let name = if value > 6.0 { format!("G59.{}", value - 6.0) } else { format!("G{}", value + 53.0) };
        let message = format!(
            "a file of the control has {name} in force (#{SYSTEM_IN_FORCE} = {value}), and the program names no zero offset: G54 is assumed"
        );
        let help = "write G54, or the offset of the job, at the beginning of the program: LinuxCNC begins with G54 only after M2 or M30";
        warn(at, &message, help)
    });
    // A Fanuc begins with G98, and its machine file states the reference position.
    let only_rs274 = retraction.into_iter().chain(home).chain(offset).filter(|_| dialect.language == Language::Rs274);
    unit.into_iter().chain(only_rs274).collect()
}

/// The axes that the block of a G28 or G30 at `at` moves: those that it names, or all.
fn home_axes(bytes: &[u8], at: usize, all: AxisSet) -> AxisSet {
    let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
    let start = bytes[..at].iter().rposition(is_end).map_or(0, |end| end + 1);
    let (mut named, mut depth) = (AxisSet::EMPTY, 0_u32);
    for &byte in bytes[start..].iter().take_while(|byte| !is_end(byte) && **byte != b';') {
        match byte {
            b'(' | b'[' | b'<' => depth += 1,
            b')' | b']' | b'>' => depth = depth.saturating_sub(1),
            _ if depth == 0 => {
                if let Some(axis) = Axis::from_letter(byte.to_ascii_uppercase()) {
                    named = named.union(std::iter::once(axis).collect());
                }
            }
            _ => {}
        }
    }
    if named.is_empty() { all } else { named.intersection(all) }
}

/// Calls `each` with every whole G code outside of comments, and its place.
pub(crate) fn each_g(bytes: &[u8], mut each: impl FnMut(u32, usize)) {
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        at += 1;
        let end = match byte {
            b'(' => bytes[at..].iter().position(|byte| matches!(byte, b')' | b'\n' | b'\r')),
            b';' => bytes[at..].iter().position(|byte| matches!(byte, b'\n' | b'\r')),
            b'G' | b'g' => {
                let rest = bytes[at..].trim_ascii_start();
                let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
                let is_whole = rest.get(digits) != Some(&b'.');
                let code = std::str::from_utf8(&rest[..digits]).ok().and_then(|digits| digits.parse().ok());
                if let Some(code) = code.filter(|_| is_whole) {
                    each(code, at - 1);
                }
                continue;
            }
            _ => continue,
        };
        at = end.map_or(bytes.len(), |end| at + end);
    }
}
