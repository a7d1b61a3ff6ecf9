//! How often a diagnosis is right: every row of the catalogue on every bench that shows it, effects that no catalogue has, two effects at once
//! and nothing, over seeds, at three and at five times the noise. The confusion table is a snapshot.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Mutex;

use serde_json::Value;

use crate::diagnose_causes::{diagnosed, is_named, recipe, same, text, words};
use crate::plant::{BENCHES, Bench, Case, Hidden, Recipe, UNKNOWNS, rows_shown};

/// Rows from here on are faults of the data.
const FIRST_FAULT: u8 = 60;
/// A hidden effect gains at least so much of what is left of the data held out for a share of it to be asked for.
const GAINS: f64 = 0.05;

/// What is hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Row,
    Two,
    Unknown,
    Nothing,
}

/// One case of the table.
struct Job {
    bench: Bench,
    name: String,
    kind: Kind,
    recipe: Recipe,
}

/// What came of it.
struct Outcome {
    bench: Bench,
    name: String,
    kind: Kind,
    is_right: bool,
    said: String,
    /// Whether the size is within its interval.
    is_inside: Option<bool>,
    /// The gain on data held out over that of the truth.
    gain: Option<f64>,
}

fn jobs(bench: Bench) -> Vec<Job> {
    let rows: Vec<u8> = rows_shown(bench).iter().copied().filter(|&row| row < FIRST_FAULT).collect();
    let mut jobs = Vec::new();
    let mut add = |name: String, kind, recipe| jobs.push(Job { bench, name, kind, recipe });
    for (size, seed) in [(3.0, 101), (5.0, 102)] {
        for &row in &rows {
            add(format!("{row:02}"), Kind::Row, recipe(bench, &[row], None, size, seed));
        }
        for one in UNKNOWNS {
            add(format!("{one:?}"), Kind::Unknown, recipe(bench, &[], Some(one), size, seed));
        }
    }
    // Every row with the one that is so many places further.
    let pairs = rows.iter().zip(rows.iter().cycle().skip(rows.len() / 2 + 1)).step_by(2).filter(|(a, b)| a != b);
    for (a, b) in pairs {
        add(format!("{a:02} and {b:02}"), Kind::Two, recipe(bench, &[*a, *b], None, 5.0, 103));
    }
    for seed in 201..=213 {
        add("nothing".to_owned(), Kind::Nothing, recipe(bench, &[], None, 5.0, seed));
    }
    jobs
}

/// The names under which an effect is known.
fn names(hidden: &Hidden) -> Vec<(&str, &str)> {
    let others = hidden.class.iter().map(|(effect, parameter)| (*effect, parameter.as_str()));
    std::iter::once((hidden.effect, hidden.parameter.as_str())).chain(others).collect()
}

fn has(findings: &[Value], names: &[(&str, &str)]) -> bool {
    findings.iter().any(|finding| {
        let class = finding["class"].as_array().unwrap().iter().map(text);
        let class = class.map(|name| name.split_once(' ').unwrap_or((name, "")));
        let own = (text(&finding["effect"]), text(&finding["parameter"]));
        std::iter::once(own).chain(class).any(|one| names.iter().any(|name| same(*name, one)))
    })
}

fn outcome(job: Job) -> Option<Outcome> {
    let case: Case = job.recipe.cook()?;
    let report = diagnosed(&case, job.kind != Kind::Nothing);
    let findings = report["findings"].as_array().unwrap();
    let is_right = match job.kind {
        Kind::Two => case.truth.effects.iter().all(|hidden| has(findings, &names(hidden))),
        _ => is_named(&case, findings),
    };
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let inside = |hidden: &Hidden| {
        let own = (hidden.effect, hidden.parameter.as_str());
        let one = findings.iter().find(|one| same(own, (text(&one["effect"]), text(&one["parameter"]))))?;
        // A difference of two sensors is that of the first less the second.
        let is_turned = hidden.drivers.len() > 1 && one["drivers"][0] == hidden.drivers[1].as_str();
        let size = if is_turned && hidden.sensor.is_some() { -hidden.size } else { hidden.size };
        // Set-ups have no size in one number, and some sizes belong to the ends of the travel.
        (hidden.effect != "setup" && one["unit"] == hidden.unit)
            .then(|| (number(&one["value"]) - size).abs() <= number(&one["u95"]))
    };
    let is_inside = (job.kind == Kind::Row).then(|| case.truth.effects.first().and_then(inside)).flatten();
    // What belongs to one set-up or one day is another one in the data held out: who knows it here knows nothing there.
    let transfers = case.truth.effects.iter().all(|hidden| hidden.transfers);
    let gain = (job.kind == Kind::Row && transfers && case.truth.gain > GAINS)
        .then(|| number(&report["holdout_gain"]).max(0.0) / case.truth.gain);
    let said = findings.first().map_or("nothing".to_owned(), words);
    Some(Outcome { bench: job.bench, name: job.name, kind: job.kind, is_right, said, is_inside, gain })
}

/// Right ones, all, and what was said in place of the right one.
type Counted<'a> = (usize, usize, BTreeMap<&'a str, usize>);

fn percent((part, all): (usize, usize)) -> f64 {
    100.0 * part as f64 / all.max(1) as f64
}

#[test]
#[ignore = "a quarter of an hour with optimized code: cargo test --release -- --ignored rates"]
fn rates_of_right_answers() {
    let open: Mutex<Vec<Job>> = Mutex::new(BENCHES.into_iter().flat_map(jobs).rev().collect());
    let done: Mutex<Vec<Outcome>> = Mutex::default();
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(job) = { open.lock().unwrap().pop() } {
                    if let Some(outcome) = outcome(job) {
                        done.lock().unwrap().push(outcome);
                    }
                }
            });
        }
    });
    let mut done = done.into_inner().unwrap();
    done.sort_by(|a, b| (format!("{:?}", a.bench), a.kind, &a.name).cmp(&(format!("{:?}", b.bench), b.kind, &b.name)));
    let mut table: BTreeMap<(String, Kind, &str), Counted<'_>> = BTreeMap::new();
    for one in &done {
        let entry = table.entry((format!("{:?}", one.bench), one.kind, &one.name)).or_default();
        entry.1 += 1;
        if one.is_right {
            entry.0 += 1;
        } else {
            *entry.2.entry(&one.said).or_default() += 1;
        }
    }
    let mut out = String::new();
    for ((bench, _, name), (right, all, others)) in &table {
        let others: Vec<String> = others.iter().map(|(name, count)| format!("{count} × {name}")).collect();
        writeln!(out, "{bench:9} {name:16} {right:2} of {all:2}  {}", others.join(", ")).unwrap();
    }
    let of = |kind: Kind| {
        let own = || done.iter().filter(move |one| one.kind == kind);
        (own().filter(|one| one.is_right).count(), own().count())
    };
    let sizes: Vec<bool> = done.iter().filter_map(|one| one.is_inside).collect();
    let sizes = (sizes.iter().filter(|inside| **inside).count(), sizes.len());
    let gains: Vec<f64> = done.iter().filter_map(|one| one.gain).collect();
    let mean = gains.iter().sum::<f64>() / gains.len().max(1) as f64;
    let gains = (gains.iter().filter(|gain| **gain >= 0.8).count(), gains.len());
    let [rows, two, unknown, nothing] = [Kind::Row, Kind::Two, Kind::Unknown, Kind::Nothing].map(of);
    for (what, (part, all)) in [
        ("named first or in the first class", rows),
        ("both of two named", two),
        ("unknown with its drivers", unknown),
        ("nothing named where nothing is", nothing),
        ("size within its interval", sizes),
        ("held-out gain at least 80 % of that of the truth", gains),
    ] {
        writeln!(out, "{part} of {all}: {what}").unwrap();
    }
    writeln!(out, "{mean:.2}: mean of that share").unwrap();
    for one in done.iter().filter(|one| one.gain.is_some_and(|gain| gain < 0.8)) {
        writeln!(out, "{:?} {}: {:.1} of it", one.bench, one.name, one.gain.unwrap_or_default()).unwrap();
    }
    insta::assert_snapshot!("diagnose_rates", out);
    let least = [(rows, 95.0), (two, 85.0), (unknown, 80.0), (nothing, 98.0), (sizes, 90.0), (gains, 90.0)];
    assert!(least.into_iter().all(|(share, least)| percent(share) >= least) && mean >= 0.8, "{out}");
}
