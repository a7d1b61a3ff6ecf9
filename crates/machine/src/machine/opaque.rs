//! Programs and axes of which only the control knows the motion, and synchronized actions that may move axes.

use super::Control;
use super::section::Section;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, AxisSet};

/// Program or cycle whose calls are passed on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Opaque {
    /// Name, upper case; a `*` at the end matches any rest.
    pub name: String,
    /// True if it moves axes, so that their positions are unknown afterwards.
    pub moves: bool,
}

/// The synchronized actions that may move axes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AllowedSynchronised {
    /// All of them, with an ID or without.
    All,
    /// The one of this ID, as it is written.
    Id(String),
}

impl AllowedSynchronised {
    /// From an entry of `allow_synchronised`: `all`, or an ID.
    #[must_use]
    pub fn read(entry: String) -> AllowedSynchronised {
        if entry == "all" { AllowedSynchronised::All } else { AllowedSynchronised::Id(entry) }
    }
}

impl Control {
    /// Returns whether a program (upper case) moves axes; `None` if its calls are not passed on.
    #[must_use]
    pub fn opaque_moves(&self, name: &str) -> Option<bool> {
        let fits = |entry: &&Opaque| match entry.name.strip_suffix('*') {
            Some(start) => name.starts_with(start),
            None => entry.name == name,
        };
        self.opaque.iter().find(fits).map(|entry| entry.moves)
    }

    /// True if an entry may name a G or M code.
    #[must_use]
    pub fn has_opaque_codes(&self) -> bool {
        self.opaque.iter().any(|entry| matches!(entry.name.as_bytes(), [b'G' | b'M', b'0'..=b'9' | b'*', ..]))
    }

    /// Returns whether a tool change may move axes: unless the machine file names M6 with `moves = false`.
    #[must_use]
    pub fn tool_change_moves(&self) -> bool {
        self.opaque_moves("M6") != Some(false)
    }

    /// Returns whether the words of an axis (its name in upper case) are passed on.
    #[must_use]
    pub fn passes_axis(&self, name: &str) -> bool {
        self.passed_on_axes.iter().any(|known| known == name)
    }

    /// True if a synchronized action with this ID may move axes; `None` is an action without ID.
    #[must_use]
    pub fn allows_synchronised(&self, id: Option<u32>) -> bool {
        let shown = id.map(|id| id.to_string());
        self.allow_synchronised.iter().any(|entry| match entry {
            AllowedSynchronised::All => true,
            AllowedSynchronised::Id(id) => Some(id) == shown.as_ref(),
        })
    }
}

/// Reads `opaque`, `search_path`, `initial_codes`, `allow_synchronised` and `transverse_axis` of `[control]`.
pub(super) fn read(section: &mut Section<'_>, control: &mut Control) {
    for name in section.texts("opaque").unwrap_or_default() {
        control.opaque.push(Opaque { name: called(name), moves: true });
    }
    control.initial_codes = section.texts("initial_codes").unwrap_or_default();
    control.search_path = section.texts("search_path").unwrap_or_default();
    let allowed = section.texts("allow_synchronised").unwrap_or_default();
    control.allow_synchronised = allowed.into_iter().map(AllowedSynchronised::read).collect();
    if let Some(text) = section.text("transverse_axis") {
        let axis = match text.as_bytes() {
            [letter] => Axis::from_letter(*letter).filter(|axis| !axis.is_rotary()),
            _ => None,
        };
        match axis {
            Some(axis) => control.transverse_axis = axis,
            None => {
                let message = format!("\"{text}\" is not a linear axis");
                let help = "write one of X Y Z U V W";
                section.report(Code::BAD_VALUE, section.place_of("transverse_axis"), message, help);
            }
        }
    }
}

/// Reads `passed_on_axes` of `[control]`; `chain` has the axes of the machine.
pub(super) fn read_axes(section: &mut Section<'_>, control: &mut Control, chain: AxisSet) {
    for (place, name) in section.texts("passed_on_axes").unwrap_or_default().into_iter().enumerate() {
        let name = name.to_ascii_uppercase();
        let is_name = name.starts_with(|first: char| first.is_ascii_alphabetic())
            && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        let own = chain.iter().find(|axis| axis.to_string() == name);
        let fault = match (is_name, own) {
            (false, _) => Some((
                format!("\"{name}\" is not the name of an axis"),
                "write a letter such as \"W\", or a name such as \"Q1\"",
            )),
            (true, Some(axis)) => Some((
                format!("{axis} is an axis of the topology, so that its positions are corrected"),
                "name only axes that the topology does not have",
            )),
            (true, None) => None,
        };
        match fault {
            Some((message, help)) => {
                section.report(Code::BAD_VALUE, section.place_of_item("passed_on_axes", place), message, help);
            }
            None => control.passed_on_axes.push(name),
        }
    }
}

/// The name of an entry: upper case, and a code without leading zeros (`M06` is M6).
fn called(name: impl AsRef<str>) -> String {
    let name = name.as_ref().to_ascii_uppercase();
    let number = name.strip_prefix(['G', 'M']).filter(|rest| rest.starts_with(|first: char| first.is_ascii_digit()));
    match number {
        Some(number) if number.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.') => {
            let short = number.trim_start_matches('0');
            let short = if short.is_empty() || short.starts_with('.') { format!("0{short}") } else { short.to_owned() };
            format!("{}{short}", &name[..1])
        }
        _ => name,
    }
}

/// Reads `[[opaque]]`: `name` and `moves`.
pub(super) fn read_sections(sections: Vec<Section<'_>>, control: &mut Control, findings: &mut Vec<Diagnostic>) {
    for mut section in sections {
        let name = section.required("name", "\"TOOLCHANGE\"", Section::text).map(called);
        let moves = section.boolean("moves").unwrap_or(true);
        if let Some(name) = name {
            // A separate entry takes precedence over the short list.
            control.opaque.insert(0, Opaque { name, moves });
        }
        section.finish(findings);
    }
}
