//! Several files: what acts in some of them only, tables that repeat others, and noise that is more than what is stated. Readings are those of the plant.

use serde_json::Value;

use crate::diagnose_causes::text;
use crate::plant::{Bench, Case, File, Recipe, random::Random};
use crate::support::Shop;

/// Two files of a plan: of the first day with an effect, and of the other one with it or without, with more noise of its own.
fn days(bench: Bench, row: u8, seed: u64, on_both: bool) -> (Case, [File; 2]) {
    let plain = Recipe { outliers: Some(0.0), fineness: 0.3, ..Recipe::new(bench, 5.0, seed) };
    let with = Recipe { hide: vec![row], ..plain.clone() }.cook().unwrap();
    let other = if on_both { with.files[0].clone() } else { plain.cook().unwrap().files[0].clone() };
    let other = File { stem: "other".into(), ..noisy(&other, with.truth.noise_um, seed) };
    let files = [with.files[0].clone(), other];
    (with, files)
}

/// Benches, rows of the catalogue and seeds.
const DAYS: [(Bench, u8, u64); 4] =
    [(Bench::Ballbar, 20, 1), (Bench::Ballbar, 3, 2), (Bench::Plate, 20, 3), (Bench::Plate, 1, 4)];

fn diagnosed(machine: &str, files: &[&File], more: &str, status: i32) -> Value {
    let mut shop = Shop::new().file("machine.toml", machine);
    for file in files {
        shop = shop.file(&format!("{}.csv", file.stem), &file.csv).file(&format!("{}.toml", file.stem), &file.toml);
    }
    let arguments = format!("diagnose {more} --machine machine.toml --json");
    shop.run(arguments.split_whitespace()).exits(status).json()
}

/// What was found or rejected and differs from file to file.
fn differing(report: &Value) -> Vec<Value> {
    let all = ["findings", "rejected"].map(|name| report[name].as_array().unwrap().clone()).concat();
    all.into_iter().filter(|one| !one["by_file"].as_array().unwrap().is_empty()).collect()
}

#[test]
fn what_acts_on_one_day_only_is_told_file_by_file() {
    for (bench, row, seed) in DAYS {
        let (case, [first, other]) = days(bench, row, seed, false);
        let both = format!("{}.csv {}.csv", first.stem, other.stem);
        let report = diagnosed(&case.machine_toml, &[&first, &other], &both, 0);
        let truth = &case.truth.effects[0];
        // An error that the machine had before the second file, and has no more.
        let earlier = report["findings"].as_array().unwrap().iter().find(|one| {
            one["effect"] == "earlier" && text(&one["parameter"]).starts_with(&format!("{} ", truth.parameter))
        });
        if let Some(one) = earlier {
            let [value, u95] = ["value", "u95"].map(|name| one[name].as_f64().unwrap());
            assert!((value.abs() - truth.size.abs()).abs() < 2.0 * u95, "{}{one}", case.words());
            assert!(text(&one["parameter"]).ends_with(&format!(" before {}", other.stem)), "{}{one}", case.words());
            assert!(
                report["findings"].as_array().unwrap().iter().all(|one| one["correctable"] != "program"),
                "{report:#}"
            );
            continue;
        }
        let told = differing(&report);
        let own =
            told.iter().find(|one| text(&one["effect"]) == truth.effect && text(&one["parameter"]) == truth.parameter);
        let own = own.unwrap_or_else(|| panic!("{}{} {}", case.words(), report["findings"], report["rejected"]));
        let of = |stem: &str| {
            let part = own["by_file"].as_array().unwrap().iter().find(|part| part["file"] == stem).unwrap();
            ["value", "u95"].map(|name| part[name].as_f64().unwrap())
        };
        let [value, u95] = of(&first.stem);
        assert!((value - truth.size).abs() < 2.0 * u95 && value.abs() > 2.0 * u95, "{}{own}", case.words());
        let [value, u95] = of(&other.stem);
        assert!(value.abs() < 2.0 * u95, "{}{own}", case.words());
        // A program would be moved by half of it on both days.
        let is_moved = report["findings"]
            .as_array()
            .unwrap()
            .iter()
            .any(|one| one["parameter"] == truth.parameter.as_str() && one["correctable"] == "program");
        assert!(!is_moved, "{}{}", case.words(), report["findings"]);
    }
}

/// The machine was right on the first day, and has an error since. The readings of the first day must not speak against it.
#[test]
fn what_acts_since_the_second_day_has_its_whole_size() {
    let mut count = 0;
    for (bench, row, seed) in [(Bench::Ballbar, 8), (Bench::Ballbar, 20)]
        .into_iter()
        .flat_map(|(bench, row)| [1, 2, 3, 4].map(|seed| (bench, row, seed)))
    {
        let (case, [now, before]) = days(bench, row, seed, false);
        let truth = &case.truth.effects[0];
        let names = format!("{}.csv {}.csv", before.stem, now.stem);
        let report = diagnosed(&case.machine_toml, &[&before, &now], &names, 0);
        // A squareness has a name for each of its axes.
        let is_own = |one: &&Value| {
            text(&one["effect"]) == truth.effect
                && (text(&one["parameter"]) == truth.parameter || !one["same_as"].as_array().unwrap().is_empty())
        };
        let own = report["findings"].as_array().unwrap().iter().find(is_own);
        let own = own.unwrap_or_else(|| panic!("{}{:#}", case.words(), report["findings"]));
        let [value, u95] = ["value", "u95"].map(|name| own[name].as_f64().unwrap());
        let off = (value.abs() - truth.size.abs()).abs();
        assert!(off < 1.5 * u95 && u95 < 0.5 * truth.size.abs(), "{}{own}", case.words());
        count += u32::from(own["correctable"] == "program" && own["probability"].as_f64().unwrap() > 0.95);
    }
    assert!(count >= 6, "{count} of 8 are certain");
}

#[test]
fn what_acts_on_both_days_differs_in_none() {
    for (bench, row, seed) in DAYS {
        let (case, [first, other]) = days(bench, row, seed, true);
        let both = format!("{}.csv {}.csv", first.stem, other.stem);
        let report = diagnosed(&case.machine_toml, &[&first, &other], &both, 0);
        assert!(differing(&report).is_empty(), "{}{:?}", case.words(), differing(&report));
        assert_eq!(report["findings"][0]["correctable"], "program", "{}{}", case.words(), report["findings"]);
    }
}

/// The same table with readings in other decimals; `decimals` of µm.
fn rounded(file: &File, stem: &str, decimals: usize) -> File {
    let mut lines = file.csv.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut csv = head.join(",") + "\n";
    for line in lines {
        let cells = line.split(',').zip(&head).map(|(cell, name)| match cell.parse::<f64>() {
            Ok(value) if name.ends_with("_um") => format!("{value:.decimals$}"),
            _ => cell.to_owned(),
        });
        csv += &(cells.collect::<Vec<String>>().join(",") + "\n");
    }
    File { csv, stem: stem.to_owned(), ..file.clone() }
}

/// The rows from the last to the first.
fn backwards(file: &File, stem: &str) -> File {
    let mut lines: Vec<&str> = file.csv.lines().collect();
    lines[1..].reverse();
    File { csv: lines.join("\n") + "\n", stem: stem.to_owned(), ..file.clone() }
}

#[test]
fn a_copy_that_is_rounded_or_in_another_order_is_no_judge() {
    for bench in [Bench::Ballbar, Bench::Plate] {
        let case = Recipe { fineness: 0.3, ..Recipe::new(bench, 5.0, 6) }.cook().unwrap();
        let own = &case.files[0];
        // 0.01 µm is a fiftieth of the noise or less.
        for copy in [rounded(own, "copy", 2), backwards(own, "copy"), backwards(&rounded(own, "copy", 3), "copy")] {
            for more in [format!("{}.csv copy.csv", own.stem), format!("{}.csv --holdout copy.csv", own.stem)] {
                let report = diagnosed(&case.machine_toml, &[own, &copy], &more, 4);
                // Circles backwards go against the names of their runs too (W0607).
                let mut codes = report["diagnostics"].as_array().unwrap().iter().map(|one| &one["code"]);
                assert!(codes.any(|code| code == "E0605"), "{more}: {report:#}");
            }
        }
        // The same places once more, with noise of their own: the noise of the first in another order.
        let other = Recipe { fineness: 0.3, ..Recipe::new(bench, 5.0, 6) };
        let again = File { stem: "again".into(), ..noisy(own, 0.5, 3) };
        let report = diagnosed(
            &other.cook().unwrap().machine_toml,
            &[own, &again],
            &format!("{}.csv --holdout again.csv", own.stem),
            0,
        );
        assert!(report["diagnostics"].as_array().unwrap().iter().all(|one| one["code"] != "E0605"));
    }
}

/// The same readings with white noise beside theirs, µm.
fn noisy(file: &File, sigma_um: f64, seed: u64) -> File {
    let mut random = Random::new(seed, "more noise");
    let mut lines = file.csv.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut csv = head.join(",") + "\n";
    for line in lines {
        let cells = line.split(',').zip(&head).map(|(cell, name)| match cell.parse::<f64>() {
            Ok(value) if name.ends_with("_um") => format!("{:.4}", value + sigma_um * random.normal()),
            _ => cell.to_owned(),
        });
        csv += &(cells.collect::<Vec<String>>().join(",") + "\n");
    }
    File { csv, ..file.clone() }
}

#[test]
fn white_noise_far_above_what_is_stated_is_noise() {
    let case = Recipe { outliers: Some(0.0), ..Recipe::new(Bench::Plate, 5.0, 5) }.cook().unwrap();
    let sigma = 90.0 * case.truth.noise_um;
    let loud = noisy(&case.files[0], sigma, 1);
    let shop = Shop::new().file("machine.toml", &case.machine_toml);
    let shop = shop.file("loud.csv", &loud.csv).file("loud.toml", &loud.toml);
    let report = shop.run(["diagnose", "loud.csv", "--machine", "machine.toml", "--json"]).exits(0).json();
    let [noise, stated] = ["noise_um", "noise_stated_um"].map(|name| report[name].as_f64().unwrap());
    assert!((noise / sigma - 1.0).abs() < 0.1, "{noise} of {sigma}");
    assert!((noise / stated - 90.0).abs() < 10.0, "{noise} {stated}");
    let left = report["after"]["rms_um"].as_f64().unwrap();
    assert!(report["unexplained"]["structure"] == false && noise > 0.9 * left, "{left} {noise}");
    let said = shop.run(["diagnose", "loud.csv", "--machine", "machine.toml"]).exits(0);
    assert!(said.stdout.contains("times the stated sigma"), "{}", said.stdout);
}

#[test]
fn another_order_of_the_axes_in_the_machine_file_is_told() {
    const DEMO: &str = include_str!("../samples/machines/demo.toml");
    let shop = Shop::new().file("demo.toml", DEMO).file("other.toml", DEMO.replace("\"wXYFZSt\"", "\"wYXFZSt\""));
    let plan = "plan ballbar --machine demo.toml --tool 120 --radius 150 --every 5 -o plan.csv";
    shop.run(plan.split_whitespace()).exits(0);
    let read = "simulate --machine demo.toml plan.csv -o read.csv --noise 0.5um --seed 3";
    shop.run(read.split_whitespace()).exits(0);
    let found = shop.run("diagnose read.csv --machine other.toml --json".split_whitespace()).exits(4).json();
    let told = &found["data_faults"][0];
    assert_eq!(told["kind"], "topology", "{found}");
    assert!(told["what"].as_str().unwrap().contains("wXYFZSt"), "{told}");
    let codes: Vec<&str> =
        found["diagnostics"].as_array().unwrap().iter().map(|one| one["code"].as_str().unwrap()).collect();
    assert!(codes.contains(&"E0614"), "{codes:?}");
    // The squareness of a lower axis is a symptom as well.
    assert!(codes.contains(&"W0405"), "{codes:?}");
    let found = shop.run("diagnose read.csv --machine demo.toml --json".split_whitespace()).exits(0).json();
    assert!(found["data_faults"].as_array().unwrap().is_empty(), "{}", found["data_faults"]);
}

#[test]
fn numbers_beyond_everything_are_told_with_their_cell() {
    let case = Recipe::new(Bench::Plate, 5.0, 2).cook().unwrap();
    let file = &case.files[0];
    let mut lines: Vec<String> = file.csv.lines().map(str::to_owned).collect();
    let column = lines[0].split(',').position(|name| name == "dx_um").unwrap();
    let mut cells: Vec<&str> = lines[5].split(',').collect();
    cells[column] = "1e300";
    lines[5] = cells.join(",");
    let huge = File { csv: lines.join("\n") + "\n", ..file.clone() };
    let report = diagnosed(&case.machine_toml, &[&huge], &format!("{}.csv", huge.stem), 4);
    let told = &report["diagnostics"][0];
    assert_eq!([&told["code"], &told["line"]], [&Value::from("E0603"), &Value::from(6)], "{told}");
    assert!(told["column"].as_u64().unwrap() > 1 && told["message"].as_str().unwrap().contains("1e300"), "{told}");
}
