//! Effects that the plant hides must be named: rows of the catalogue by what they are, effects that no catalogue has by what they depend on, and
//! nothing where there is nothing.

use std::path::Path;

use serde_json::Value;

use crate::plant::{Bench, Case, Recipe, Unknown};

/// The diagnosis of a case, with its data held out where that is wanted.
pub(crate) fn diagnosed(case: &Case, holds_out: bool) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let paths = case.save(folder.path()).unwrap();
    let text = |path: &Path| path.display().to_string();
    let mut arguments = vec!["diagnose".to_owned()];
    arguments.extend(paths.files.iter().map(|path| text(path)));
    arguments.extend(["--machine".to_owned(), text(&paths.machine), "--json".to_owned()]);
    for path in paths.held_out.iter().filter(|_| holds_out) {
        arguments.extend(["--holdout".to_owned(), text(path)]);
    }
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_ncfix")).args(&arguments).output().unwrap();
    serde_json::from_slice(&run.stdout).unwrap_or_else(|error| panic!("{}: {error}", case.words()))
}

fn findings(case: &Case) -> Vec<Value> {
    diagnosed(case, false)["findings"].as_array().unwrap().clone()
}

pub(crate) fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// The axes of a plane or a pair are in no order.
pub(crate) fn same(one: (&str, &str), other: (&str, &str)) -> bool {
    let plain = |parameter: &str| {
        let mut letters: Vec<char> = parameter.chars().collect();
        if letters.len() < 4 && !parameter.starts_with('E') {
            letters.sort_unstable();
        }
        letters
    };
    one.0 == other.0 && plain(one.1) == plain(other.1)
}

pub(crate) fn words(finding: &Value) -> String {
    let name = format!("{} {}", text(&finding["effect"]), text(&finding["parameter"]));
    if text(&finding["effect"]) == "unknown" {
        let drivers: Vec<&str> = finding["drivers"].as_array().unwrap().iter().map(text).collect();
        return format!("{name} of {}", drivers.join(" "));
    }
    name
}

/// Whether what is hidden is named first or in the first class.
pub(crate) fn is_named(case: &Case, findings: &[Value]) -> bool {
    let Some(first) = findings.first() else { return case.truth.effects.is_empty() };
    let Some(truth) = case.truth.effects.first() else { return false };
    if truth.effect == "unknown" {
        let mut drivers: Vec<&str> = first["drivers"].as_array().unwrap().iter().map(text).collect();
        let mut known: Vec<&str> = truth.drivers.iter().map(String::as_str).collect();
        drivers.sort_unstable();
        known.sort_unstable();
        return text(&first["effect"]) == "unknown" && drivers == known;
    }
    let names: Vec<(&str, &str)> = std::iter::once((truth.effect, truth.parameter.as_str()))
        .chain(truth.class.iter().map(|(effect, parameter)| (*effect, parameter.as_str())))
        .collect();
    let known = |name: (&str, &str)| names.iter().any(|own| same(*own, name));
    known((text(&first["effect"]), text(&first["parameter"])))
        || first["class"].as_array().unwrap().iter().any(|entry| {
            let (effect, parameter) = text(entry).split_once(' ').unwrap_or((text(entry), ""));
            known((effect, parameter))
        })
}

pub(crate) fn recipe(bench: Bench, hide: &[u8], unknown: Option<Unknown>, size_in_noise: f64, seed: u64) -> Recipe {
    Recipe { hide: hide.to_vec(), unknown, ..Recipe::new(bench, size_in_noise, seed) }
}

#[test]
fn hidden_rows_are_named() {
    let few = [
        (Bench::Laser, 1),
        (Bench::Laser, 20),
        (Bench::OnTheFly, 27),
        (Bench::Plate, 24),
        (Bench::Load, 46),
        (Bench::Drift, 38),
        (Bench::FiveAxis, 9),
        (Bench::FiveAxis, 14),
    ];
    for (bench, row) in few {
        let case = recipe(bench, &[row], None, 5.0, 1).cook().unwrap();
        let found = findings(&case);
        assert!(is_named(&case, &found), "{}\n{:?}", case.words(), found.iter().map(words).collect::<Vec<_>>());
    }
}

#[test]
fn nothing_is_named_where_nothing_is_hidden() {
    for bench in [Bench::Laser, Bench::OnTheFly, Bench::Load] {
        let case = recipe(bench, &[], None, 5.0, 1).cook().unwrap();
        let found = findings(&case);
        assert!(found.is_empty(), "{bench:?}: {:?}", found.iter().map(words).collect::<Vec<_>>());
    }
}
