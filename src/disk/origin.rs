//! `ncfix machine show --origin`: the place where each value of a machine was written.

use std::path::{Path, PathBuf};

use super::machine_file::{self, FoundFile, Member};
use crate::error::Error;
use ncfix_base::geometry::{AXES, FrameParts};
use ncfix_base::source::Source;
use ncfix_language::exec::apply_archive;
use ncfix_machine::machine::file::{MachineFile, apply_setup, read_machine};
use ncfix_machine::machine::origin::{defaults, written};
use ncfix_machine::machine::{Machine, Setting, Tool};
use ncfix_machine::saved::apply_saved;
use ncfix_report::origin::{OriginFile, OriginFileKind, OriginRow, Origins};

/// Sections that have values even if they are not written.
const ALWAYS: [&str; 3] = ["machine", "spindle", "control"];

/// The origins of the values of a machine in a machine file with its set-up files, both read without an error.
///
/// # Errors
/// If a set-up file cannot be read.
pub(crate) fn origins(source: &Source, found: FoundFile, setups: &[PathBuf]) -> Result<Origins, Error> {
    let mut out = Origins::default();
    out.files.push(OriginFile {
        what: OriginFileKind::Machine,
        file: source.name().to_owned(),
        found: found.words().to_owned(),
    });
    let Ok(file) = MachineFile::parse(source) else { return Ok(out) };
    let Some(mut machine) = read_machine(&file).0 else { return Ok(out) };
    out.values = rows(&file, source);
    for path in setups {
        out.files.push(OriginFile {
            what: OriginFileKind::SetUp,
            file: path.display().to_string(),
            found: "--setup".to_owned(),
        });
        for Member { source, is_saved_data, format } in machine_file::members(path)?.1 {
            if is_saved_data || format.is_some() {
                // Errors in it were reported when the machine was read.
                let apply = |machine: &mut Machine| {
                    let _ = match format {
                        Some(format) => apply_saved(format, &source, machine),
                        None => apply_archive(&source, machine),
                    };
                };
                let before = machine.clone();
                apply(&mut machine);
                // Data that are equal to those of an earlier file come from this file too: they differ from other data.
                let other = with_other_data(&before);
                let mut over_other = other.clone();
                apply(&mut over_other);
                let stated = [(&before, &machine), (&other, &over_other)];
                lay_over(&mut out.values, changes(stated, &source));
            } else if let Ok(file) = MachineFile::parse(&source) {
                let _ = apply_setup(&source, &mut machine);
                lay_over(&mut out.values, rows(&file, &source));
            }
        }
    }
    let folder = Path::new(source.name()).parent().unwrap_or(Path::new("."));
    for table in &machine.active_tables.files {
        let file = folder.join(table).display().to_string();
        let key = if machine.active_tables.is_offline { "machine.offline_tables" } else { "machine.active_tables" };
        out.files.push(OriginFile { what: OriginFileKind::Tables, file, found: key.to_owned() });
    }
    fill_in(&mut out.values, &machine);
    Ok(out)
}

fn rows(file: &MachineFile, source: &Source) -> Vec<OriginRow> {
    let row = |one: ncfix_machine::machine::origin::WrittenValue| OriginRow {
        path: one.path,
        value: one.value,
        origin: format!("{}:{}", source.name(), one.line),
    };
    written(file, source).into_iter().map(row).collect()
}

/// The section of a value: its path without the last key. A key may hold points in brackets and quotation marks of its own.
fn section(path: &str) -> &str {
    for name in ["system.", "gud.", "parameter."] {
        if path.starts_with(name) {
            return name.trim_end_matches('.');
        }
    }
    path.rsplit_once('.').map_or("", |(section, _)| section)
}

/// Overrides values by those of a set-up file: a tool and a zero offset replace the complete entry of the same name, a variable only itself. The method
/// by which a zero was set holds until another is stated; the poses of the old touch do not.
fn lay_over(values: &mut Vec<OriginRow>, over: Vec<OriginRow>) {
    let is_of_touch = |path: &str| path.ends_with(".set") || path.contains(".set_at.");
    let zero = |path: &str| section(path).split(".set_at").next().unwrap_or_default().to_owned();
    values.retain(|row| {
        if over.iter().any(|new| new.path == row.path) {
            return false;
        }
        let own = section(&row.path);
        if own.starts_with("tool[") {
            return !over.iter().any(|new| section(&new.path) == own);
        }
        if !own.starts_with("zero_offset.") {
            return true;
        }
        let own = zero(&row.path);
        let mut same = over.iter().filter(|new| zero(&new.path) == own);
        match (row.path.ends_with(".set"), is_of_touch(&row.path)) {
            (true, _) => !same.any(|new| is_of_touch(&new.path)),
            (false, true) => same.next().is_none(),
            (false, false) => !same.any(|new| !is_of_touch(&new.path)),
        }
    });
    over.into_iter().for_each(|row| insert(values, row));
}

/// Inserts a value after the others of its section, or else of its kind.
fn insert(values: &mut Vec<OriginRow>, row: OriginRow) {
    let kind = |path: &str| path.split(['.', '[']).next().unwrap_or_default().to_owned();
    let same_section = values.iter().rposition(|other| section(&other.path) == section(&row.path));
    let place = same_section.or_else(|| values.iter().rposition(|other| kind(&other.path) == kind(&row.path)));
    values.insert(place.map_or(values.len(), |place| place + 1), row);
}

/// Adds the defaults of keys that were not written.
fn fill_in(values: &mut Vec<OriginRow>, machine: &Machine) {
    let is_valid = |section: &&str| machine.heads.is_empty() || *section != "spindle";
    let mut sections: Vec<String> = ALWAYS.iter().copied().filter(is_valid).map(str::to_owned).collect();
    for row in values.iter() {
        let own = section(&row.path).to_owned();
        if !sections.contains(&own) {
            sections.push(own);
        }
    }
    for section in sections {
        let kind = format!("{section}.kind");
        let kind = values.iter().find(|row| row.path == kind).map(|row| row.value.clone());
        for (key, value) in defaults(&section, kind.as_deref(), machine) {
            let path = format!("{section}.{key}");
            // A key may be a separate section, such as macro_codes.
            let is_written = |row: &OriginRow| {
                row.path.strip_prefix(&path).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
            };
            if !values.iter().any(is_written) {
                insert(values, OriginRow { path, value, origin: "default".to_owned() });
            }
        }
    }
}

/// A machine whose zero offsets, base frames and tools all have other values.
fn with_other_data(machine: &Machine) -> Machine {
    let mut other = machine.clone();
    for frame in other.zero_offsets.values_mut().chain(other.base_frames.values_mut()) {
        AXES.into_iter().for_each(|axis| frame.translation[axis] += 1.0);
    }
    for tool in &mut other.tools {
        tool.length_mm[0] += 1.0;
    }
    other
}

/// The values that data of a control state. Each pair is a machine before and after it read them; a value is stated if it changes in one of the pairs. The
/// values are those of the first pair.
fn changes(stated: [(&Machine, &Machine); 2], source: &Source) -> Vec<OriginRow> {
    let (before, after) = stated[0];
    let mut out = Vec::new();
    let mut add = |path: String, value: String, mark: &str| {
        out.push(OriginRow { path, value, origin: place(source, mark) });
    };
    for tool in &after.tools {
        let Tool { number, edge, length_mm, radius_mm, name } = tool;
        let is_same = |one: &&Tool| (one.number, one.edge) == (*number, *edge);
        let has_changed = |(before, after): (&Machine, &Machine)| {
            before.tools.iter().find(is_same) != after.tools.iter().find(is_same)
        };
        if !stated.into_iter().any(has_changed) {
            continue;
        }
        // Avoids a negative zero in the output.
        let [l1, l2, l3] = length_mm.map(|length_mm| length_mm + 0.0);
        let mark = format!("[{number},{edge}]");
        let path = |key: &str| format!("tool[{number},{edge}].{key}");
        add(path("number"), number.to_string(), &mark);
        add(path("edge"), edge.to_string(), &mark);
        add(path("length_mm"), format!("[{l1}, {l2}, {l3}]"), &mark);
        add(path("radius_mm"), radius_mm.to_string(), &mark);
        name.iter().for_each(|name| add(path("name"), format!("\"{name}\""), &mark));
    }
    for (name, frame) in &after.zero_offsets {
        let has_changed =
            |(before, after): (&Machine, &Machine)| before.zero_offsets.get(name) != after.zero_offsets.get(name);
        if stated.into_iter().any(has_changed) {
            of_frame(&format!("zero_offset.{name}"), frame, after, |path, value| add(path, value, "$P_UIFR"));
        }
    }
    for (number, frame) in &after.base_frames {
        let has_changed =
            |(before, after): (&Machine, &Machine)| before.base_frames.get(number) != after.base_frames.get(number);
        if stated.into_iter().any(has_changed) {
            of_frame(&format!("base_frame.{number}"), frame, after, |path, value| add(path, value, "BFR["));
        }
    }
    for (number, value) in &after.parameters {
        if before.parameters.get(number) != Some(value) {
            add(format!("parameter.R{number}"), value.to_string(), &format!("R{number}="));
        }
    }
    for (name, old, new) in [("system", &before.system, &after.system), ("gud", &before.gud, &after.gud)] {
        for (key, value) in new.iter().filter(|(key, value)| old.get(*key) != Some(*value)) {
            add(format!("{name}.{key}"), shown(value), key);
        }
    }
    out
}

/// The components of a frame that have an effect; the shifts always.
fn of_frame(path: &str, frame: &FrameParts, machine: &Machine, mut add: impl FnMut(String, String)) {
    for axis in AXES.into_iter().filter(|&axis| machine.axis(axis).is_some()) {
        let (unit, factor) = if axis.is_rotary() { ("deg", 1_f64.to_degrees()) } else { ("mm", 1.0) };
        add(format!("{path}.{axis}_{unit}"), (frame.translation[axis] * factor).to_string());
        if frame.fine[axis] != 0.0 {
            add(format!("{path}.fine_{axis}_{unit}"), (frame.fine[axis] * factor).to_string());
        }
    }
    if frame.rotation != [0.0; 3] {
        add(format!("{path}.rotation_deg"), format!("{:?}", frame.rotation.map(f64::to_degrees)));
    }
    if frame.scale != [1.0; 3] {
        add(format!("{path}.scale"), format!("{:?}", frame.scale));
    }
    if frame.mirror != [false; 3] {
        let names: Vec<&str> = ["\"X\"", "\"Y\"", "\"Z\""]
            .into_iter()
            .zip(frame.mirror)
            .filter(|(_, is)| *is)
            .map(|(name, _)| name)
            .collect();
        add(format!("{path}.mirror"), format!("[{}]", names.join(", ")));
    }
}

/// The first line of saved data with a mark, ignoring blanks and case; only the file if no line contains the mark.
fn place(source: &Source, mark: &str) -> String {
    let plain = |line: &[u8]| -> String {
        line.iter()
            .filter(|byte| !byte.is_ascii_whitespace())
            .map(|&byte| char::from(byte.to_ascii_uppercase()))
            .collect()
    };
    let mut lines = source.bytes().split(|&byte| byte == source.line_end());
    match lines.position(|line| plain(line).contains(mark)) {
        Some(index) => format!("{}:{}", source.name(), index + 1),
        None => source.name().to_owned(),
    }
}

fn shown(value: &Setting) -> String {
    match value {
        Setting::Whole(value) => value.to_string(),
        Setting::Number(value) => value.to_string(),
        Setting::Truth(value) => value.to_string(),
        Setting::Text(value) => format!("\"{value}\""),
        Setting::List(values) => format!("[{}]", values.iter().map(shown).collect::<Vec<_>>().join(", ")),
    }
}
