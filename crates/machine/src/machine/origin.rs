//! Places of the values of a machine file, and defaults of keys that are not written.

use super::Machine;
use super::document::{Document, TomlItem, TomlTable, TomlValue};
use super::setting::normal;
use ncfix_base::source::Source;

/// Value that is written in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenValue {
    /// Keys from the top of the file: `axis.X.travel_mm`, `tool[5,1].length_mm` (number and edge), `motion[3].kind` (the third one).
    pub path: String,
    /// Value as written.
    pub value: String,
    /// Line from 1.
    pub line: usize,
}

/// Defaults of keys of `[control]`.
const OF_CONTROL: &[(&str, &str)] = &[
    ("allow_synchronised", "[]"),
    ("arc_plane_from_words", "false"),
    ("arc_radius_check", "true"),
    ("arc_words_from_center", "false"),
    ("arc_tolerance_mm", "0.01"),
    ("arc_tolerance_ratio", "0.001"),
    ("arguments_two", "true"),
    ("chip_clearance_mm", "1"),
    ("chord_tolerance_mm", "0.00025"),
    ("compensation_blocks_between", "3"),
    ("compensation_corner_deg", "100"),
    ("compensation_flat_deg", "10"),
    ("compensation_look_ahead", "4"),
    ("compensation_start", "\"A\""),
    ("dwell_turns", "false"),
    ("edge_after_tool_change", "1"),
    ("fine_shift", "false"),
    ("grundig_chamfer_is_length", "false"),
    ("grundig_engagement_percent", "83"),
    ("grundig_mirror_outside", "false"),
    ("grundig_offset_cancels_shift", "true"),
    ("grundig_peck_clearance_mm", "1"),
    ("grundig_positioning_logic", "true"),
    ("grundig_scale_in_percent", "false"),
    ("grundig_scaled_axes", "\"plane\""),
    ("grundig_shift_is_turned", "true"),
    ("grundig_slot_from_arc_center", "false"),
    ("grundig_turns_first", "false"),
    ("increment_system", "\"IS-B\""),
    ("incremental_traverses_frame_change", "true"),
    ("initial_codes", "[]"),
    ("initial_plane", "17"),
    ("length_compensation", "\"A\""),
    ("macro_codes", "{}"),
    ("max_program_levels", "16"),
    ("mirror_toggles", "true"),
    ("modulo_shortest", "false"),
    ("opaque", "[]"),
    ("orientation_angles", "\"rpy\""),
    ("oripath", "\"end\""),
    ("passed_on_axes", "[]"),
    ("peck_clearance_mm", "1"),
    ("pole_limit_deg", "2"),
    ("relative_comparison", "true"),
    ("rotation_order", "\"rpy\""),
    ("search_path", "[]"),
    ("signed_angles", "false"),
    ("startup_code", "\"\""),
    ("tilt_about", "\"normal\""),
    ("tool_change", "\"M6\""),
    ("transverse_axis", "\"X\""),
];

/// Defaults of keys of the other sections, each by its keys without names and numbers.
const OF_SECTIONS: &[(&str, &[(&str, &str)])] = &[
    ("machine", &[("controller", "\"sinumerik\""), ("reference_temperature_C", "20"), ("active_tables", "[]")]),
    ("spindle", &[("origin_mm", "[0, 0, 0]"), ("axis", "[0, 0, 1]")]),
    ("head", &[("origin_mm", "[0, 0, 0]"), ("axis", "[0, 0, 1]"), ("start", "false")]),
    ("axis", &[("point_mm", "[0, 0, 0]"), ("lever", "\"carried\"")]),
    ("zero_offset", &[("rotation_deg", "[0, 0, 0]"), ("scale", "[1, 1, 1]"), ("mirror", "[]")]),
    ("tool", &[("edge", "1"), ("radius_mm", "0")]),
    ("opaque", &[("moves", "true")]),
    ("servo", &[("smoothing_ms", "0")]),
    ("segment", &[("torsion_share", "1"), ("lag_s", "0")]),
    ("drift.sensors", &[("lag_s", "0")]),
    ("expansion.scale", &[("lag_s", "0")]),
    ("expansion.workpiece", &[("lag_s", "0")]),
];

/// Returns all values of a file, in their order.
#[must_use]
pub fn written(file: &Document, source: &Source) -> Vec<WrittenValue> {
    let mut out = Vec::new();
    walk(&file.root, "", source, &mut out);
    out.sort_by_key(|(at, _)| *at);
    out.into_iter().map(|(_, written)| written).collect()
}

/// Returns the keys of a section that have a value even if they are not written, with that value. The section is that of [`WrittenValue::path`] without the
/// last key. `own_kind` is the value of its `kind` as written.
#[must_use]
pub fn defaults(section: &str, own_kind: Option<&str>, machine: &Machine) -> Vec<(String, String)> {
    let kind = kind_of(section);
    let own = |row: &(&str, &str)| (row.0.to_owned(), row.1.to_owned());
    let listed = OF_SECTIONS.iter().find(|(name, _)| *name == kind);
    let mut rows: Vec<(String, String)> = listed.map_or(&[][..], |(_, rows)| rows).iter().map(own).collect();
    match kind.as_str() {
        "control" => {
            rows.extend(OF_CONTROL.iter().map(own));
            let fresh = super::output_control::of_controller(&machine.controller);
            rows.push(("increment_mm".into(), fresh.increment_mm.to_string()));
            let least = if machine.control.iso.is_haas() { 1 } else { 100 };
            rows.push(("least_arc_feed_percent".into(), least.to_string()));
            // Both increments have an equal number of decimals.
            rows.push(("increment_deg".into(), fresh.increment_mm.to_string()));
        }
        "axis" if section.ends_with(['A', 'B', 'C']) => rows.push(("modulo".into(), "false".into())),
        "motion" if own_kind == Some("\"periodic\"") => rows.push(("phase_deg".into(), "0".into())),
        // The place of setting has no default of its own: it is that of the zero.
        "zero_offset" if section.ends_with(".set_at") => rows.clear(),
        "zero_offset" => {
            for axis in machine.topology.axis_set().iter() {
                let unit = if axis.is_rotary() { "deg" } else { "mm" };
                rows.push((format!("{axis}_{unit}"), "0".into()));
                rows.push((format!("fine_{axis}_{unit}"), "0".into()));
            }
        }
        _ => {}
    }
    rows
}

/// Required keys of sections that many files state in the wrong one.
const REQUIRED: &[(&str, &[&str])] = &[
    ("machine", &["topology"]),
    ("axis", &["direction", "travel_mm", "travel_deg", "max_feed_mm_min", "max_feed_deg_min"]),
    ("tool", &["length_mm"]),
];

/// Sections of a machine file that a person can take for another one. Those of other files have keys of their own.
const MISTAKEN: [&str; 7] = ["machine", "control", "axis", "spindle", "head", "tool", "zero_offset"];

/// Returns the one section of a machine file that has a key, as a file writes it: `[machine]` for `topology`. None if several have it, if none has, or if
/// `title` is not a section of the machine that lacks it.
pub(super) fn home_of(key: &str, title: &str) -> Option<String> {
    let section = kind_of(title.trim_matches(['[', ']']));
    if !MISTAKEN.contains(&section.as_str()) {
        return None;
    }
    let title = |name: &str| match name {
        "axis" => "[axis.X]".to_owned(),
        "zero_offset" => "[zero_offset.G54]".to_owned(),
        "tool" | "head" | "segment" => format!("[[{name}]]"),
        _ => format!("[{name}]"),
    };
    let is_key = |rows: &[(&str, &str)]| rows.iter().any(|row| row.0 == key);
    let with_default = OF_SECTIONS.iter().filter(|(_, rows)| is_key(rows)).map(|(name, _)| title(name));
    let of_control = is_key(OF_CONTROL).then(|| title("control"));
    let required = REQUIRED.iter().filter(|(_, keys)| keys.contains(&key)).map(|(name, _)| title(name));
    let mut homes = with_default.chain(of_control).chain(required);
    let home = homes.next().filter(|_| homes.next().is_none())?;
    (kind_of(home.trim_matches(['[', ']'])) != section).then_some(home)
}

/// Removes names and numbers: `axis.X` is an `axis`, `drift[2].sensors[1]` are `drift.sensors`.
fn kind_of(section: &str) -> String {
    let mut kind = String::new();
    let mut depth = 0;
    for letter in section.chars() {
        match letter {
            '[' => depth += 1,
            ']' => depth -= 1,
            _ if depth == 0 => kind.push(letter),
            _ => {}
        }
    }
    match kind.split_once('.') {
        Some((first @ ("axis" | "zero_offset"), _)) => first.to_owned(),
        _ => kind,
    }
}

fn walk(table: &TomlTable, path: &str, source: &Source, out: &mut Vec<(u32, WrittenValue)>) {
    for entry in &table.entries {
        let key = match path {
            "system" | "gud" => normal(&entry.key),
            _ => entry.key.clone(),
        };
        let own = if path.is_empty() { key } else { format!("{path}.{key}") };
        match &entry.item.value {
            TomlValue::Table(inner) if !inner.entries.is_empty() => walk(inner, &own, source, out),
            TomlValue::Items(items) if is_list_of_tables(items) => {
                for (number, item) in items.iter().enumerate() {
                    if let TomlValue::Table(inner) = &item.value {
                        let name = if own == "tool" { tool_name(inner) } else { (number + 1).to_string() };
                        walk(inner, &format!("{own}[{name}]"), source, out);
                    }
                }
            }
            _ => {
                let start = entry.item.span.start;
                let (_, line_start) = source.line_at(start);
                let before = source.bytes().get(..line_start as usize).unwrap_or_default();
                let line = 1 + before.iter().filter(|&&byte| byte == source.line_end()).count();
                let text = source.bytes().get(entry.item.span.range()).unwrap_or_default();
                let value = String::from_utf8_lossy(text).split_whitespace().collect::<Vec<_>>().join(" ");
                out.push((start, WrittenValue { path: own, value, line }));
            }
        }
    }
}

fn is_list_of_tables(items: &[TomlItem]) -> bool {
    !items.is_empty() && items.iter().all(|item| matches!(item.value, TomlValue::Table(_)))
}

/// Returns number and edge, such as `5,1`, which identify tools across files.
fn tool_name(tool: &TomlTable) -> String {
    let number = |key: &str| tool.entry(key).and_then(|entry| entry.item.number());
    format!("{},{}", number("number").unwrap_or_default(), number("edge").unwrap_or(1.0))
}

#[cfg(test)]
mod tests {
    use super::super::file::{DEMO, read_machine};
    use super::*;
    use ncfix_base::source::FileId;

    fn machine(text: &str) -> Machine {
        let source = Source::new(FileId(0), "m.toml", text.as_bytes().to_vec()).unwrap();
        let (machine, findings) = read_machine(&Document::parse(&source).unwrap());
        machine.unwrap_or_else(|| panic!("{findings:?}\n{text}"))
    }

    const HEAD: &str = "[machine]\nname = \"m\"\ntopology = \"wCFXYZt\"\ncontroller = \"CONTROLLER\"\n";

    /// Returns the text of a small machine with a rotary axis, a tool and a zero offset, and with additional lines in its sections.
    fn text(controller: &str, of: impl Fn(&str) -> String) -> String {
        let mut text = HEAD.replace("CONTROLLER", controller) + &of("machine");
        text += "[sensor.T]\nreference_C = 20\n";
        for (axis, direction) in [("X", "[1, 0, 0]"), ("Y", "[0, 1, 0]"), ("Z", "[0, 0, 1]"), ("C", "[0, 0, 1]")] {
            text += &format!("[axis.{axis}]\ndirection = {direction}\n{}", of(&format!("axis.{axis}")));
        }
        text += &format!("[spindle]\n{}[control]\n{}", of("spindle"), of("control"));
        text += &format!("[zero_offset.G54]\n{}", of("zero_offset.G54"));
        text + &format!("[[tool]]\nnumber = 5\nlength_mm = 120\n{}", of("tool[5,1]"))
    }

    #[test]
    fn writing_every_default_changes_nothing() {
        for controller in ["sinumerik", "fanuc", "grundig", "rs274"] {
            let bare = machine(&text(controller, |_| String::new()));
            let of = |section: &str| {
                let rows = defaults(section, None, &bare).into_iter().filter(|(key, _)| key != "controller");
                rows.map(|(key, value)| format!("{key} = {value}\n")).collect()
            };
            assert_eq!(machine(&text(controller, of)), bare, "{controller}");
        }
    }

    #[test]
    fn every_key_has_a_default_or_says_nothing_when_it_is_not_written() {
        // Without these keys nothing is set, so they have no default.
        const NOTHING: &[&str] = &[
            "name",
            "topology",
            "axis_order",
            "direction",
            "travel_mm",
            "travel_deg",
            "start_deg",
            "max_feed_mm_min",
            "max_feed_deg_min",
            "clamp_codes",
            "unclamp_codes",
            "increments_per_mm",
            "block_cycle_ms",
            "saved_unit",
            "rollover",
            "one_axis_in_rotation",
            "codes_within_rotation",
            "program_kind",
            "dwell_with_point",
            "tip_coordinates",
            "word_meaning",
            "number",
            "length_mm",
            "last_block_number",
            "tool_length_plane",
            "swivel_retract_x_mm",
            "swivel_retract_y_mm",
            "swivel_retract_z_mm",
            "swivel_direction_axis",
            "arc_center",
            "compensation_corner",
            "decimal_point",
            "orient_shift",
            "rigid_tapping",
            "grundig_head",
            "grundig_plane_order",
            "initial_zero_offset",
            "table_multiplication",
            "offline_tables",
            "set",
            "set_at",
        ];
        let bare = machine(&text("sinumerik", |_| String::new()));
        for section in ["machine", "axis.X", "axis.C", "spindle", "control", "zero_offset.G54", "tool[5,1]"] {
            let of = |other: &str| if other == section { "qqqqqqqq = 1\n".to_owned() } else { String::new() };
            let source = Source::new(FileId(0), "m.toml", text("sinumerik", of).into_bytes()).unwrap();
            let (_, findings) = read_machine(&Document::parse(&source).unwrap());
            let unknown = findings.iter().find(|finding| finding.message.contains("qqqqqqqq")).unwrap();
            let (_, known) = unknown.help.split_once("known here: ").unwrap();
            let listed = defaults(section, None, &bare);
            for key in known.split(", ").filter(|key| !NOTHING.contains(key) && !key.starts_with("reference_point_")) {
                assert!(listed.iter().any(|(name, _)| name == key), "{section} {key}");
            }
        }
    }

    #[test]
    fn a_key_in_the_wrong_section_is_sent_home() {
        let cases = [
            ("control", "active_tables = []", "move it to [machine]"),
            ("machine", "initial_plane = 18", "move it to [control]"),
            ("zero_offset.G54", "travel_mm = [0, 1]", "move it to [axis.X]"),
            ("axis.X", "length_mm = 5", "move it to [[tool]]"),
        ];
        for (section, line, help) in cases {
            let of = |other: &str| if other == section { format!("{line}\n") } else { String::new() };
            let source = Source::new(FileId(0), "m.toml", text("sinumerik", of).into_bytes()).unwrap();
            let (_, findings) = read_machine(&Document::parse(&source).unwrap());
            let unknown = findings.iter().filter(|finding| finding.message.starts_with("unknown key"));
            let found: Vec<&str> = unknown.map(|finding| finding.help.as_str()).collect();
            assert_eq!(found, [help], "{section}: {line}");
        }
        // The files of sensors and readings have sections of their own.
        assert_eq!(home_of("radius_mm", "[channel.T]"), None);
    }

    #[test]
    fn every_value_of_a_file_has_its_line() {
        let source = Source::new(FileId(0), "demo", DEMO.as_bytes().to_vec()).unwrap();
        let all = written(&Document::parse(&source).unwrap(), &source);
        assert!(all.len() > 20, "{all:?}");
        let lines: Vec<&str> = DEMO.lines().collect();
        for one in all {
            let key = one.path.rsplit('.').next().unwrap();
            assert!(lines[one.line - 1].contains(key), "{one:?}");
        }
    }
}
