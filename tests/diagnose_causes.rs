//! Effects that the plant hides must be named: rows of the catalogue by what they are, effects that no catalogue has by what they depend on, and
//! nothing where there is nothing.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;

use crate::plant::{BENCHES, Bench, Case, Recipe, UNKNOWNS, Unknown, rows_shown};

/// Rows from here on are faults of the data.
const FIRST_FAULT: u8 = 60;

fn findings(case: &Case) -> Vec<Value> {
    let folder = tempfile::tempdir().unwrap();
    let paths = case.save(folder.path()).unwrap();
    let text = |path: &Path| path.display().to_string();
    let mut arguments = vec!["diagnose".to_owned()];
    arguments.extend(paths.files.iter().map(|path| text(path)));
    arguments.extend(["--machine".to_owned(), text(&paths.machine), "--json".to_owned()]);
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_ncfix")).args(&arguments).output().unwrap();
    let json: Value = serde_json::from_slice(&run.stdout).unwrap();
    json["findings"].as_array().unwrap().clone()
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// The axes of a plane or a pair are in no order.
fn same(one: (&str, &str), other: (&str, &str)) -> bool {
    let plain = |parameter: &str| {
        let mut letters: Vec<char> = parameter.chars().collect();
        if letters.len() < 4 && !parameter.starts_with('E') {
            letters.sort_unstable();
        }
        letters
    };
    one.0 == other.0 && plain(one.1) == plain(other.1)
}

fn words(finding: &Value) -> String {
    let name = format!("{} {}", text(&finding["effect"]), text(&finding["parameter"]));
    if text(&finding["effect"]) == "unknown" {
        let drivers: Vec<&str> = finding["drivers"].as_array().unwrap().iter().map(text).collect();
        return format!("{name} of {}", drivers.join(" "));
    }
    name
}

/// Whether what is hidden is named first or in the first class.
fn is_named(case: &Case, findings: &[Value]) -> bool {
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

fn recipe(bench: Bench, hide: &[u8], unknown: Option<Unknown>, size_in_noise: f64, seed: u64) -> Recipe {
    Recipe {
        bench,
        hide: hide.to_vec(),
        unknown,
        faults: Vec::new(),
        size_in_noise,
        fineness: 1.0,
        outliers: None,
        seed,
    }
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

/// Cases, those that were named rightly, and what others were named.
type Counted = (usize, usize, BTreeMap<String, usize>);

/// What was named for each hidden row, over seeds and sizes.
#[test]
#[ignore = "takes half an hour"]
fn confusion_of_hidden_rows() {
    let mut table: BTreeMap<(String, String), Counted> = BTreeMap::new();
    for bench in BENCHES {
        let rows = rows_shown(bench).iter().filter(|&&row| row < FIRST_FAULT);
        let hidden = rows.map(|&row| (format!("{row:02}"), vec![row], None));
        let unknown = UNKNOWNS.into_iter().map(|one| (format!("{one:?}"), Vec::new(), Some(one)));
        let kinds: Vec<_> = hidden.chain(unknown).chain([("nothing".to_owned(), Vec::new(), None)]).collect();
        for (name, hide, unknown) in kinds {
            for (size, seed) in [3.0, 5.0].into_iter().flat_map(|size| (1..=5).map(move |seed| (size, seed))) {
                let Some(case) = recipe(bench, &hide, unknown, size, seed).cook() else { continue };
                let found = findings(&case);
                let entry = table.entry((format!("{bench:?}"), name.clone())).or_default();
                entry.0 += 1;
                if is_named(&case, &found) {
                    entry.1 += 1;
                } else {
                    *entry.2.entry(found.first().map_or("nothing".to_owned(), words)).or_default() += 1;
                }
            }
        }
    }
    let mut out = String::new();
    for ((bench, name), (count, named, others)) in &table {
        let others: Vec<String> = others.iter().map(|(name, count)| format!("{count} × {name}")).collect();
        writeln!(out, "{bench:9} {name:16} {named:2} of {count:2}  {}", others.join(", ")).unwrap();
    }
    insta::assert_snapshot!("diagnose_causes", out);
}
