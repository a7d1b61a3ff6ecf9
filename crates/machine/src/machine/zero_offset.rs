//! Settable zero offsets in the machine file: `[zero_offset.G54]` with shifts, rotation, scale and mirror.

use std::collections::{BTreeMap, BTreeSet};

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{AXES, Axis, AxisSet, FrameParts};

use super::datum::{Datum, ZeroSetting};
use super::section::Section;
use super::{AxisData, Machine};

/// Settable zero offsets of a control.
struct Names {
    controller: &'static str,
    /// Description for diagnostics.
    help: &'static str,
    is_name: fn(&str) -> bool,
}

/// Beginning of the names of the additional systems of a Fanuc.
const ADDITIONAL: &str = "G54.1 P";

/// Beginning of the names of a Haas for the additional systems of a Fanuc.
const OF_HAAS: &str = "G154 P";

/// The external offset of a Fanuc, which shifts all others.
pub(crate) const EXTERNAL: &str = "EXT";

const NAMES: &[Names] = &[
    Names {
        controller: "sinumerik",
        help: "settable zero offsets are G500, G54 to G57 and G505 to G599",
        is_name: |name| numbered(name, "G").is_some_and(|number| matches!(number, 54..=57 | 500 | 505..=599)),
    },
    Names {
        controller: "fanuc",
        help: "settable zero offsets are G54 to G59, \"G54.1 P1\" to \"G54.1 P300\" (on a Haas \"G154 P1\" to \"G154 P99\") and \
               EXT, which shifts them all",
        is_name: |name| {
            name == EXTERNAL
                || numbered(name, "G").is_some_and(|number| (54..=59).contains(&number))
                || numbered(name, ADDITIONAL).is_some_and(|number| (1..=300).contains(&number))
                || numbered(name, OF_HAAS).is_some_and(|number| (1..=99).contains(&number))
        },
    },
    Names {
        controller: "rs274",
        help: "settable zero offsets are G54 to G59 and G59.1 to G59.3",
        is_name: |name| {
            numbered(name, "G").is_some_and(|number| (54..=59).contains(&number))
                || numbered(name, "G59.").is_some_and(|number| (1..=3).contains(&number))
        },
    },
    Names {
        controller: "grundig",
        help: "settable zero offsets are G52, G54 to G59 and \"G54 I0\" to \"G54 I99\"",
        is_name: |name| {
            numbered(name, "G").is_some_and(|number| number == 52 || (54..=59).contains(&number))
                || name == "G54 I0"
                || numbered(name, "G54 I").is_some_and(|number| number <= 99)
        },
    },
];

/// Returns the number after a prefix; leading zeros are refused.
fn numbered(name: &str, prefix: &str) -> Option<u32> {
    let digits = name.strip_prefix(prefix)?;
    let is_number = digits.bytes().all(|digit| digit.is_ascii_digit()) && !digits.starts_with('0');
    digits.parse().ok().filter(|_| is_number)
}

/// Checks the name of a settable zero offset; the error lists the valid names of the control. An unknown control may use the names of any control.
pub(super) fn check_name(name: &str, controller: &str) -> Result<(), String> {
    let own = |names: &&Names| names.controller.eq_ignore_ascii_case(controller);
    match NAMES.iter().find(own) {
        Some(names) if (names.is_name)(name) => Ok(()),
        Some(names) => Err(names.help.to_owned()),
        None if NAMES.iter().any(|names| (names.is_name)(name)) => Ok(()),
        None => Err(NAMES[0].help.to_owned()),
    }
}

/// Content of `[zero_offset]`, by the names of the offsets.
#[derive(Default)]
pub(super) struct ZeroOffsets {
    /// Values; 0 without a value.
    pub(super) offsets: BTreeMap<String, FrameParts>,
    /// Methods and poses.
    pub(super) datums: BTreeMap<String, Datum>,
    /// Entries that state only a method or a pose.
    pub(super) without_value: BTreeSet<String>,
}

pub(super) fn read_zero_offsets(
    root: &mut Section<'_>,
    (axes, data): (AxisSet, &[Option<AxisData>]),
    controller: &str,
    findings: &mut Vec<Diagnostic>,
) -> ZeroOffsets {
    let mut out = ZeroOffsets::default();
    let Some(mut section) = root.section("zero_offset") else { return out };
    let names: Vec<&str> = section.keys().collect();
    for name in names {
        if let Err(help) = check_name(name, controller) {
            let message = format!("\"{name}\" is not a settable zero offset");
            section.accept(name);
            section.report(Code::UNKNOWN_KEY, section.place_of_key(name), message, help);
            continue;
        }
        let Some(mut own) = section.section(name) else { continue };
        let states_value = own.keys().any(|key| !matches!(key, "set" | "set_at"));
        let parts = read_parts(&mut own, axes);
        check_whole(&mut own, name, axes);
        if let Some(datum) = Datum::read(&mut own, (axes, data), findings) {
            out.datums.insert(common_name(name), datum);
        }
        own.finish(findings);
        if !states_value {
            out.without_value.insert(common_name(name));
        }
        out.offsets.insert(common_name(name), parts);
    }
    section.finish(findings);
    out
}

impl Machine {
    /// Returns the name of an offset at the control: `G54.1 P5` is `G154 P5` on a Haas.
    #[must_use]
    pub fn shown_offset(&self, name: &str) -> String {
        match name.strip_prefix(ADDITIONAL).filter(|_| self.control.iso.is_haas()) {
            Some(number) => format!("{OF_HAAS}{number}"),
            None => name.to_owned(),
        }
    }

    /// Replaces a zero offset by the one of a set-up file. The zero was set again: the method of the machine file still holds, its places of touch do
    /// not.
    pub fn set_zero_offset(&mut self, name: String, parts: FrameParts) {
        if let Some(datum) = self.datums.get_mut(&name) {
            datum.at = Default::default();
            // An entry without value states the method of every value.
            let earlier = self.zero_offsets.get(&name).filter(|earlier| **earlier != FrameParts::default());
            let is_other = earlier.is_some_and(|earlier| *earlier != parts);
            datum.is_of_other_value |= is_other && datum.setting == Some(ZeroSetting::Absolute);
        }
        self.partial_offsets.remove(&name);
        self.zero_offsets.insert(name, parts);
    }
}

/// The name of an offset among those of a Fanuc: `G154 P5` of a Haas is `G54.1 P5`.
#[must_use]
pub fn common_name(name: &str) -> String {
    name.strip_prefix(OF_HAAS).map_or_else(|| name.to_owned(), |number| format!("{ADDITIONAL}{number}"))
}

/// Returns the linear axes that an offset lacks beside others, with a message: an offset is set for the axes together, so they may be forgotten. `None` if it
/// has all of them or none, or if it is the external one. With `is_kept`, they keep the values of an earlier file, otherwise they are 0.
#[must_use]
pub fn lacking_axes(
    name: &str,
    axes: AxisSet,
    is_kept: bool,
    has: impl Fn(Axis) -> bool,
) -> Option<(Vec<Axis>, String)> {
    let (there, lacking): (Vec<Axis>, Vec<Axis>) =
        axes.iter().filter(|axis| axis.slot() < 3).partition(|axis| has(*axis));
    if there.is_empty() || lacking.is_empty() || name == EXTERNAL {
        return None;
    }
    let listed = |axes: &[Axis]| axes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" and ");
    let rest = match (is_kept, lacking.len()) {
        (true, 1) => "which keeps its value of an earlier file",
        (true, _) => "which keep their values of an earlier file",
        (false, 1) => "which counts as 0 unless a later --setup states it",
        (false, _) => "which count as 0 unless a later --setup states them",
    };
    let message = format!("{name} gives {} but not {}, {rest}", listed(&there), listed(&lacking));
    Some((lacking, message))
}

/// The error for an offset of a saved file that shifts an axis which neither the machine file nor the control alone moves: the file may be that of another
/// machine.
#[must_use]
pub fn foreign_axis(name: &str, parts: &FrameParts, machine: &Machine) -> Option<Diagnostic> {
    let is_foreign = |axis: &Axis| {
        parts.shift()[*axis] != 0.0
            && !machine.axis_set().contains(*axis)
            && !machine.control.passes_axis(&axis.to_string())
    };
    let axis = AXES.into_iter().find(is_foreign)?;
    let message = format!("{name} shifts {axis}, and the machine has no axis {axis}");
    let help = "give the file of this machine, or add the axis to the machine file; if only the control moves it, name it in control.passed_on_axes";
    Some(Diagnostic::nowhere(Code::NO_AXIS, message, help))
}

/// Warns of linear axes that an offset lacks beside others.
fn check_whole(section: &mut Section<'_>, name: &str, axes: AxisSet) {
    let key = |axis: Axis| format!("{axis}_mm");
    let Some((lacking, message)) = lacking_axes(name, axes, false, |axis| section.has(&key(axis))) else { return };
    let keys = lacking.iter().map(|axis| key(*axis)).collect::<Vec<_>>().join(" and ");
    let help = format!("write {keys} as shown on the control, even if it is 0");
    section.report(Code::PARTIAL_OFFSET, section.place(), message, help);
}

fn read_parts(section: &mut Section<'_>, axes: AxisSet) -> FrameParts {
    let mut parts = FrameParts::default();
    for axis in axes.iter() {
        let unit = if axis.is_rotary() { "deg" } else { "mm" };
        let value = |number: f64| if axis.is_rotary() { number.to_radians() } else { number };
        parts.translation[axis] = section.number(&format!("{axis}_{unit}")).map_or(0.0, value);
        parts.fine[axis] = section.number(&format!("fine_{axis}_{unit}")).map_or(0.0, value);
    }
    if let Some(angles) = section.vector("rotation_deg") {
        parts.rotation = [angles.x, angles.y, angles.z].map(f64::to_radians);
    }
    if let Some(factors) = section.vector("scale") {
        if factors.iter().all(|factor| (1e-6..1e6).contains(factor)) {
            parts.scale = [factors.x, factors.y, factors.z];
        } else {
            let help = "write the factors of X, Y and Z, for example [1, 1, 1]";
            section.report(Code::BAD_VALUE, section.place_of("scale"), "scale factors must be above 0", help);
        }
    }
    for (index, name) in section.texts("mirror").unwrap_or_default().iter().enumerate() {
        let axis = [Axis::X, Axis::Y, Axis::Z].into_iter().find(|axis| axis.to_string() == *name);
        match axis.and_then(|axis| parts.mirror.get_mut(axis.slot())) {
            Some(mirror) => *mirror = true,
            None => {
                let place = section.place_of_item("mirror", index);
                let message = format!("\"{name}\" cannot be mirrored");
                section.report(Code::BAD_VALUE, place, message, "name X, Y or Z");
            }
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::check_name;

    #[test]
    fn each_control_has_names_of_its_own() {
        for (controller, good, bad) in [
            ("sinumerik", &["G500", "G54", "G505"][..], &["G58", "G054", "G59.1"][..]),
            ("fanuc", &["G54", "G59", "G54.1 P1", "G54.1 P300", "EXT"], &["G500", "G54.1 P0", "G54.1P1", "G59.1"]),
            ("rs274", &["G54", "G59", "G59.3"], &["G59.4", "G54.1 P1", "EXT"]),
            ("grundig", &["G52", "G59", "G54 I0", "G54 I99"], &["G53", "G54 I100", "G500"]),
            ("another", &["G500", "G59.3"], &["X"]),
        ] {
            good.iter().for_each(|name| assert!(check_name(name, controller).is_ok(), "{controller} {name}"));
            bad.iter().for_each(|name| assert!(check_name(name, controller).is_err(), "{controller} {name}"));
        }
    }
}
