//! What holds for whatever comes in: one function a target, a panic where it does not hold.
//!
//! libFuzzer calls them from `fuzz_targets/`, and `tests/fuzzing.rs`, which includes this file, with samples that are damaged by a generator of its
//! own. To add one, write it, give it a row in [`TARGETS`], a file in `fuzz_targets/` and a `[[bin]]` in `Cargo.toml`.

pub mod correction;
pub mod expressions;
pub mod files;
pub mod links;
pub mod measured;
pub mod numbers;
pub mod programs;
pub mod sensors;
pub mod snc;
pub mod tables;

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::source::{FileId, Source};

/// A property and the folders whose files it begins with.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name, that of its file in `fuzz_targets/`.
    pub name: &'static str,
    /// Folders of the project with files that are read like this; without one, any bytes will do.
    pub seeds: &'static [&'static str],
    /// Panics where the property does not hold.
    pub run: fn(&[u8]),
}

const SINUMERIK: &[&str] =
    &["samples/programs/sinumerik", "samples/programs/sinumerik/bad", "crates/language/cycles/sinumerik"];
const GRUNDIG: &[&str] = &["samples/programs/grundig", "samples/programs/grundig/bad"];
const FANUC: &[&str] = &["samples/programs/fanuc", "samples/programs/fanuc/bad"];
const RS274: &[&str] = &["samples/programs/rs274", "samples/programs/rs274/bad", "tests/oracle/programs"];
const MACHINES: &[&str] = &["samples/machines", "samples/machines/bad"];

/// All targets.
pub const TARGETS: &[Target] = &[
    Target { name: "parse_sinumerik", seeds: SINUMERIK, run: programs::parse_sinumerik },
    Target { name: "parse_grundig", seeds: GRUNDIG, run: programs::parse_grundig },
    Target { name: "parse_fanuc", seeds: FANUC, run: programs::parse_fanuc },
    Target { name: "parse_rs274", seeds: RS274, run: programs::parse_rs274 },
    Target { name: "execute_sinumerik", seeds: SINUMERIK, run: programs::execute_sinumerik },
    Target { name: "execute_grundig", seeds: GRUNDIG, run: programs::execute_grundig },
    Target { name: "execute_fanuc", seeds: FANUC, run: programs::execute_fanuc },
    Target { name: "execute_rs274", seeds: RS274, run: programs::execute_rs274 },
    Target { name: "correct_sinumerik", seeds: SINUMERIK, run: correction::sinumerik },
    Target { name: "correct_grundig", seeds: GRUNDIG, run: correction::grundig },
    Target { name: "correct_fanuc", seeds: FANUC, run: correction::fanuc },
    Target { name: "correct_rs274", seeds: RS274, run: correction::rs274 },
    Target { name: "expressions", seeds: &[], run: expressions::agree },
    Target { name: "numbers", seeds: &[], run: numbers::agree },
    Target { name: "snc_text", seeds: &["fuzz/seeds/snc"], run: snc::read_and_written },
    Target { name: "machine_file", seeds: MACHINES, run: files::machine },
    Target { name: "saved_data", seeds: &["fuzz/seeds/saved", "samples/tables"], run: files::saved_data },
    Target { name: "state", seeds: &["fuzz/seeds/state", "samples/sensors"], run: files::state },
    Target { name: "csv", seeds: &["samples/sensors", "samples/tables"], run: measured::table },
    Target { name: "measurement", seeds: &["fuzz/seeds/measurement"], run: measured::pair },
    Target { name: "trace", seeds: &["fuzz/seeds/trace"], run: measured::trace },
    Target { name: "compensation_tables", seeds: &["samples/tables"], run: tables::read_and_written },
    Target { name: "dialogues", seeds: &["fuzz/seeds/dialogue"], run: links::dialogues },
    Target { name: "link_profile", seeds: &["crates/dnc/links"], run: links::profile },
    Target { name: "journal", seeds: &["fuzz/seeds/journal"], run: links::journal },
    Target { name: "sensors", seeds: &["samples/sensors"], run: sensors::config },
    Target { name: "sensor_lines", seeds: &["fuzz/seeds/lines", "samples/sensors"], run: sensors::lines },
];

/// A file with these bytes.
fn source(name: &str, bytes: &[u8]) -> Source {
    Source::new(FileId(0), name, bytes.to_vec()).expect("a fuzzer gives less than 4 GiB")
}

/// Findings say something, and at places that are in one of the files.
#[track_caller]
fn check_findings(findings: &[Diagnostic], sources: &[&Source]) {
    for finding in findings {
        assert!(!finding.message.is_empty() && !finding.help.is_empty(), "{finding:?}");
        let Some(place) = finding.place else { continue };
        let source = sources.iter().find(|source| source.id() == place.file);
        let length = source.unwrap_or_else(|| panic!("no file of {finding:?}")).bytes().len();
        // What is missing at the end of a file is drawn behind it.
        assert!(place.span.start <= place.span.end && place.span.end as usize <= length + 1, "{length} {finding:?}");
    }
}

/// The bytes before and behind a line of `====`: two files in one.
fn halves(bytes: &[u8]) -> (&[u8], &[u8]) {
    const BETWEEN: &[u8] = b"\n====\n";
    match bytes.windows(BETWEEN.len()).position(|window| window == BETWEEN) {
        Some(at) => (&bytes[..=at], &bytes[at + BETWEEN.len()..]),
        None => (bytes, &[]),
    }
}
