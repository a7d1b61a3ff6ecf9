//! An error-free machine and handwritten tables, for tests of this module and of those that build on it.

use crate::measure::data::{DataSet, load};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;
use ncfix_model::file;

fn source(name: &str, text: &str) -> Source {
    Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap()
}

/// Three axes of which each moves the tool along a direction of F.
pub(crate) fn machine() -> Machine {
    built("wFXYZSt", "")
}

/// The machine with a rotary table.
pub(crate) fn turning() -> Machine {
    built("wCFXYZSt", "[axis.C]\ndirection = [0, 0, -1]\ntravel_deg = [-360, 360]\n")
}

fn built(topology: &str, more: &str) -> Machine {
    let mut text = format!("[machine]\nname = \"bench\"\ntopology = \"{topology}\"\n{more}");
    for (letter, direction) in [("X", "[1, 0, 0]"), ("Y", "[0, 1, 0]"), ("Z", "[0, 0, 1]")] {
        text += &format!("[axis.{letter}]\ndirection = {direction}\ntravel_mm = [-1000, 1000]\n");
    }
    file::load(&source("bench.toml", &text)).0.unwrap().0
}

/// A table with its description.
pub(crate) fn table(machine: &Machine, rows: &str, description: &str) -> DataSet {
    let (data, findings) = load("t", &source("t.csv", rows), &source("t.toml", description), machine);
    data.unwrap_or_else(|| panic!("{findings:#?}"))
}
