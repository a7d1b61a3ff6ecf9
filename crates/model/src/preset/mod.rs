//! Presets: parameter sets of an error model for a given machine, generalized from those in the literature.
//!
//! A preset is derived from the roles of the axes (`roles`), not from their letters; for the published topology it gives exactly the published list. Every set is
//! free of redundancy under its assumptions about the set-up, which its file states. An omitted parameter moves the tool like a combination of the others, or
//! like the unknown position of the workpiece or the tool. A preset is a file here and a line in [`PRESETS`]; a caller adds its own to [`Presets`].

mod cubic;
mod linked;
mod rest;
mod roles;
mod separable;
mod spaan;

pub use rest::{Rest, rest};

use std::fmt;

use super::parameter::ParameterName;
use ncfix_base::register::{Register, Registered};
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::file::nearest;

/// Named set of parameters.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Name on the command line.
    pub name: &'static str,
    /// Description for people.
    pub title: &'static str,
    /// Source in the literature.
    pub source: &'static str,
    /// Returns the parameters for a machine, in the order in which they are listed.
    pub parameters: fn(&Machine) -> Result<Vec<ParameterName>, Unsuitable>,
}

/// Reason why a preset does not fit a machine: a sentence without a full stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unsuitable(pub String);

impl fmt::Display for Unsuitable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Unsuitable {}

/// Presets that have a name. [`Register::default`](ncfix_base::register::Register::default) contains the built-in ones.
pub type Presets = Register<&'static Preset>;

impl Registered for &'static Preset {
    const KIND: &'static str = "preset";

    fn name(&self) -> &str {
        self.name
    }

    fn built_in() -> Vec<Box<Self>> {
        PRESETS.iter().map(Box::new).collect()
    }
}

/// Built-in presets.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "spaan-18",
        title: "18 error functions of three linear axes, squareness in the rotations",
        source: "Spaan 1995, ch. 2 and 3",
        parameters: spaan::functions_18,
    },
    Preset {
        name: "spaan-21",
        title: "18 error functions of three linear axes and 3 squareness errors",
        source: "Spaan 1995, ch. 3",
        parameters: spaan::functions_21,
    },
    Preset {
        name: "mayer-13",
        title: "8 location errors of five axes, 2 spindle offsets, 3 scales",
        source: "Esmaeili 2021, Tables 4-3 and 7-1, after Mayer 2012",
        parameters: linked::mayer_13,
    },
    Preset {
        name: "84",
        title: "cubic motion errors of five axes with scales and spindle offsets, backlash of 2 axes",
        source: "Esmaeili 2021, Table 4-2",
        parameters: cubic::cubic_84,
    },
    Preset {
        name: "12",
        title: "8 location errors of five axes, 2 relative scales, backlash of 2 axes",
        source: "Esmaeili 2021, Table 5-1",
        parameters: linked::linked_12,
    },
    Preset {
        name: "81",
        title: "cubic motion errors of five axes with relative scales, backlash of 2 axes",
        source: "Esmaeili 2021, Table 5-2 and appendix 5.13",
        parameters: cubic::cubic_81,
    },
    Preset {
        name: "10",
        title: "8 location errors of five axes, 2 relative scales",
        source: "Esmaeili 2021, Table 6-1",
        parameters: linked::linked_10,
    },
];

/// Returns the location errors that are not redundant: the eight of five axes; with linear axes alone their squareness; none with fewer axes.
#[must_use]
pub fn location_errors(machine: &Machine) -> Vec<ParameterName> {
    linked::location_errors(machine).or_else(|_| linked::squareness(machine)).unwrap_or_default()
}

/// Returns the built-in preset of a name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}

/// Returns the message for a name without a built-in preset, with the nearest one and all of them.
#[must_use]
pub fn unknown(name: &str) -> String {
    let known: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
    let near = nearest(name, known.iter().copied());
    let guess = near.map_or_else(String::new, |near| format!("did you mean {near}? "));
    format!("unknown preset '{name}'; {guess}the presets are {}", known.join(", "))
}
