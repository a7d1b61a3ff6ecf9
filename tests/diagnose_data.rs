//! What is wrong with tables as a whole: columns in each other's place, files of different noise, rows that stand there twice or in no order, noise that
//! wanders. Readings are those of the plant, or of a drift at one place whose noise is made here.

use ncfix::diagnose::{Scene, fault};
use ncfix::measure::data;
use ncfix::source::{FileId, Source};
use serde_json::Value;

use crate::plant::{Bench, Case, FaultKind, Recipe, random::Random};
use crate::support::Shop;

const MACHINE: &str = include_str!("../samples/machines/demo.toml");

fn found(machine: &str, tables: &[(&str, &str, &str)]) -> Vec<fault::Fault> {
    looked(machine, tables).unwrap()
}

/// `None` where not even the set-ups can be told, which the command refuses.
fn looked(machine: &str, tables: &[(&str, &str, &str)]) -> Option<Vec<fault::Fault>> {
    let source = |id, name: &str, text: &str| Source::new(FileId(id), name, text.as_bytes().to_vec()).unwrap();
    let (machine, errors) = ncfix::model::file::load(&source(0, "machine.toml", machine)).0.unwrap();
    let load = |(name, csv, toml): &(&str, &str, &str)| {
        let (data, findings) = data::load(name, &source(1, "table.csv", csv), &source(2, "table.toml", toml), &machine);
        data.unwrap_or_else(|| panic!("{findings:?}"))
    };
    let sets: Vec<data::DataSet> = tables.iter().map(load).collect();
    Some(fault::find(&Scene::new(&machine, &errors, &sets).ok()?))
}

fn words(found: &[fault::Fault]) -> Vec<String> {
    let others = found.iter().filter(|one| one.kind != "outlier");
    others.map(|one| format!("{} {} {} {:?}: {}", one.kind, one.name, one.what, one.rows, one.evidence)).collect()
}

/// A table with changed rows: names of the columns, cells.
fn changed(csv: &str, change: impl Fn(&[&str], &mut Vec<String>)) -> String {
    let mut lines = csv.lines();
    let head = lines.next().unwrap();
    let names: Vec<&str> = head.split(',').collect();
    let mut out = format!("{head}\n");
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        change(&names, &mut cells);
        out.push_str(&(cells.join(",") + "\n"));
    }
    out
}

fn place(names: &[&str], name: &str) -> usize {
    names.iter().position(|own| *own == name).unwrap()
}

fn recipe(bench: Bench, hide: &[u8], seed: u64) -> Recipe {
    Recipe { hide: hide.to_vec(), ..Recipe::new(bench, 5.0, seed) }
}

/// What is found in a case whose first table is changed.
fn after(case: &Case, change: impl Fn(&[&str], &mut Vec<String>)) -> Vec<fault::Fault> {
    let file = &case.files[0];
    found(&case.machine_toml, &[(&file.stem, &changed(&file.csv, change), &file.toml)])
}

#[test]
fn positions_in_each_others_columns_are_told_and_so_are_readings_with_the_wrong_sign() {
    for hide in [&[][..], &[3]] {
        let mut case = recipe(Bench::Ballbar, hide, 5).cook().unwrap();
        // Positions in the wrong columns lie within the travel.
        let wide = |line: &str| {
            if line.starts_with("travel_mm") { "travel_mm = [-2000, 2000]\n".into() } else { format!("{line}\n") }
        };
        case.machine_toml = case.machine_toml.lines().map(wide).collect();
        assert!(words(&after(&case, |_, _| {})).is_empty(), "{}", case.words());
        let file = &case.files[0];
        let swapped = changed(&file.csv, |names, cells| cells.swap(place(names, "X"), place(names, "Y")));
        if let Some(swapped) = looked(&case.machine_toml, &[(&file.stem, &swapped, &file.toml)]) {
            let is_told = |one: &fault::Fault| one.kind == "axes" && one.then == fault::Then::Refuse;
            assert!(swapped.iter().any(is_told), "{}{:?}", case.words(), words(&swapped));
        }
        // A cause that is larger than all that the machine file knows hides the sign.
        if !hide.is_empty() {
            continue;
        }
        let reversed = after(&case, |names, cells| {
            let cell = &mut cells[place(names, "dr_um")];
            *cell = cell.strip_prefix('-').map_or_else(|| format!("-{cell}"), str::to_owned);
        });
        let is_reversed = |one: &fault::Fault| one.kind == "axes" && one.what.contains("reversed");
        assert!(reversed.iter().any(is_reversed), "{}{:?}", case.words(), words(&reversed));
    }
}

#[test]
fn faults_of_axes_are_told_beside_a_cause_of_the_machine() {
    for (kind, what) in [(FaultKind::Swapped, "swapped"), (FaultKind::Reversed, "reversed")] {
        for hide in [1, 20] {
            let case = Recipe { faults: vec![kind], ..recipe(Bench::Plate, &[hide], 51) }.cook().unwrap();
            let file = &case.files[0];
            let found = found(&case.machine_toml, &[(&file.stem, &file.csv, &file.toml)]);
            let is_named = |one: &fault::Fault| one.then == fault::Then::Refuse && one.what.contains(what);
            assert!(found.iter().any(is_named), "{}{:?}", case.words(), words(&found));
        }
    }
}

/// Readings of dy and dz at one place over three runs of five hours, one a minute; µm by run and row.
fn drift(noise: f64, seed: u64, of: impl Fn(usize, usize, &mut Random) -> [f64; 2]) -> String {
    let mut random = Random::new(seed, "drift");
    let mut out = String::from("run,t_s,T_a_C,dy_um,dz_um\n");
    for run in 0..3 {
        for row in 0..300 {
            let [y, z] = of(run, row, &mut random);
            let warm = 20.0 + (row as f64 / 40.0).sin() + 0.02 * random.normal();
            let [y, z] = [y + noise * random.normal(), z + noise * random.normal()];
            out.push_str(&format!("r{run},{},{warm:.3},{y:.4},{z:.4}\n", 60 * row));
        }
    }
    out
}

const PLACE: &str = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\nsigma_um = 0.5\n[position]\nX_mm = 300\nY_mm = 200\nZ_mm = 200\n";

/// Noise of a first order: what is left of it from one reading to the next.
fn wandering(memory: f64, seed: u64) -> String {
    let state = std::cell::RefCell::new([0.0; 2]);
    drift(0.5, seed, |_, row, random| {
        let mut state = state.borrow_mut();
        for own in state.iter_mut() {
            *own = if row == 0 { 0.0 } else { memory * *own + 0.3 * random.normal() };
        }
        *state
    })
}

#[test]
fn noise_that_wanders_makes_no_steps_and_no_pulses() {
    let of = |csv: String| words(&found(MACHINE, &[("drift", &csv, PLACE)]));
    let mut wrong = Vec::new();
    for seed in 1..=12 {
        wrong.extend(of(wandering(0.97, seed)));
        wrong.extend(of(wandering(1.0, seed)));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    // Pulses of five minutes and five times the noise are found all the same.
    let pulses =
        of(drift(0.5, 3, |run, row, _| [if (100 + 40 * run..105 + 40 * run).contains(&row) { 2.5 } else { 0.0 }; 2]));
    assert_eq!(pulses.iter().filter(|one| one.starts_with("pulse")).count(), 3, "{pulses:#?}");
}

fn run(tables: &[(&str, &str)], arguments: &str, status: i32) -> Value {
    let mut shop = Shop::new().file("demo.toml", MACHINE);
    for (name, csv) in tables {
        shop = shop.file(&format!("{name}.csv"), csv).file(&format!("{name}.toml"), PLACE);
    }
    let all = format!("diagnose {arguments} --machine demo.toml --json");
    shop.run(all.split_whitespace()).exits(status).json()
}

#[test]
fn files_of_different_noise_count_each_by_its_own() {
    let warming = |noise: f64, seed| drift(noise, seed, |_, row, _| [0.0, -4.0 * (row as f64 / 40.0).sin()]);
    let found = run(&[("fine", &warming(0.2, 1)), ("coarse", &warming(3.0, 2))], "fine.csv coarse.csv", 0);
    let rows = |one: &Value| one["rows"].as_array().unwrap().len();
    let far: usize =
        found["data_faults"].as_array().unwrap().iter().filter(|one| one["kind"] == "outlier").map(rows).sum();
    // Beyond six spreads nothing of 3600 normal readings lies.
    assert!(far < 4, "{}", found["data_faults"]);
    let cause = &found["findings"][0];
    assert_eq!([&cause["effect"], &cause["parameter"]], ["thermal-drift", "Z"]);
    assert!((cause["value"].as_f64().unwrap() + 4.0).abs() < 0.1, "{cause}");
}

#[test]
fn the_same_readings_twice_are_no_test_and_too_few_tell_nothing() {
    let quiet = drift(0.5, 7, |_, _, _| [0.0; 2]);
    for arguments in ["one.csv two.csv", "one.csv --holdout two.csv"] {
        let found = run(&[("one", &quiet), ("two", &quiet)], arguments, 4);
        assert_eq!(found["diagnostics"][0]["code"], "E0605", "{arguments}");
        assert!(found["before"]["rms_um"].is_null() && found["noise_um"].is_null(), "{}", found["before"]);
    }
    let twice: String =
        quiet.lines().enumerate().flat_map(|(k, line)| vec![format!("{line}\n"); 1 + usize::from(k > 0)]).collect();
    let found = run(&[("one", &twice)], "one.csv", 4);
    let told = found["diagnostics"].as_array().unwrap();
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0]["message"].as_str().unwrap().contains("899 more"), "{}", told[0]);
    let one_row: String = quiet.lines().take(2).map(|line| format!("{line}\n")).collect();
    let found = run(&[("one", &one_row)], "one.csv", 4);
    assert_eq!(found["diagnostics"][0]["code"], "E0606");
}

#[test]
fn rows_in_no_order_have_no_senses() {
    let case = recipe(Bench::Ballbar, &[], 5).cook().unwrap();
    let file = &case.files[0];
    let names: Vec<&str> = file.csv.lines().next().unwrap().split(',').collect();
    let without = |line: &str| {
        let cells = line.split(',').zip(&names).filter(|(_, name)| !name.ends_with("_dir") && **name != "t_s");
        cells.map(|(cell, _)| cell).collect::<Vec<_>>().join(",") + "\n"
    };
    let mut lines: Vec<&str> = file.csv.lines().collect();
    let in_order: String = lines.iter().map(|line| without(line)).collect();
    let of = |csv: &str| found(&case.machine_toml, &[(&file.stem, csv, &file.toml)]);
    assert!(of(&in_order).iter().all(|one| one.kind != "order"));
    let mut random = Random::new(1, "order");
    for k in (2..lines.len()).rev() {
        lines.swap(k, 1 + random.below(k));
    }
    let shuffled: String = lines.iter().map(|line| without(line)).collect();
    assert!(of(&shuffled).iter().any(|one| one.kind == "order"));
    // With senses in the table any order will do.
    assert!(of(&(lines.join("\n") + "\n")).iter().all(|one| one.kind != "order"));
}

#[test]
fn what_can_be_corrected_does_not_depend_on_what_is_written() {
    let warming = drift(0.3, 4, |_, row, _| [3.0 * (row as f64 / 25.0).cos(), -4.0 * (row as f64 / 40.0).sin()]);
    let of = |arguments: &str| {
        let mut shop = Shop::new().file("demo.toml", MACHINE);
        shop = shop.file("one.csv", &warming).file("one.toml", PLACE);
        let found =
            shop.run(format!("diagnose one.csv --machine demo.toml --json {arguments}").split_whitespace()).json();
        let all = found["findings"].as_array().unwrap();
        all.iter()
            .map(|one| format!("{} {} {}", one["effect"], one["parameter"], one["correctable"]))
            .collect::<Vec<_>>()
    };
    let plain = of("");
    assert!(!plain.is_empty());
    assert_eq!(plain, of("-o out.toml"));
}

#[test]
fn readings_that_are_the_same_number_on_and_on_are_told() {
    let case = recipe(Bench::Plate, &[], 41).cook().unwrap();
    // A dead channel.
    let found = after(&case, |names, cells| cells[place(names, "dx_um")] = "3.7".into());
    assert!(found.iter().any(|one| one.what == "constant" && one.then == fault::Then::Refuse), "{:?}", words(&found));
    // One that hangs for fifty rows: the rest is sound.
    let rows = std::cell::Cell::new(0);
    let found = after(&case, |names, cells| {
        rows.set(rows.get() + 1);
        if (100..150).contains(&rows.get()) {
            cells[place(names, "dx_um")] = "3.7".into();
        }
    });
    let constant: Vec<_> = found.iter().filter(|one| one.what == "constant").collect();
    assert_eq!(constant.len(), 1, "{:?}", words(&found));
    assert_eq!(constant[0].rows, [99, 148]);
    assert!(found.iter().all(|one| one.then != fault::Then::Refuse), "{:?}", words(&found));
    let sound = after(&case, |_, _| {});
    assert!(sound.iter().all(|one| one.what != "constant"), "{:?}", words(&sound));
}
