//! What is wrong with tables as a whole: columns in each other's place, files of different noise, rows that stand there twice or in no order, noise that
//! wanders. Readings are those of the plant, or of a drift at one place whose noise is made here.

use ncfix_base::source::{FileId, Source};
use ncfix_metrology::diagnose::{Scene, fault};
use ncfix_metrology::measure::data;
use serde_json::Value;

use crate::plant::{Bench, Case, FaultKind, Recipe, random::Random};
use crate::support::Shop;

const MACHINE: &str = include_str!("../samples/machines/demo.toml");

fn found(machine: &str, tables: &[(&str, &str, &str)]) -> Vec<fault::DataDefect> {
    looked(machine, tables).unwrap()
}

/// `None` where not even the set-ups can be told, which the command refuses.
fn looked(machine: &str, tables: &[(&str, &str, &str)]) -> Option<Vec<fault::DataDefect>> {
    let source = |id, name: &str, text: &str| Source::new(FileId(id), name, text.as_bytes().to_vec()).unwrap();
    let (machine, errors) = ncfix_model::file::load(&source(0, "machine.toml", machine)).0.unwrap();
    let load = |(name, csv, toml): &(&str, &str, &str)| {
        let (data, findings) = data::load(name, &source(1, "table.csv", csv), &source(2, "table.toml", toml), &machine);
        data.unwrap_or_else(|| panic!("{findings:?}"))
    };
    let sets: Vec<data::DataSet> = tables.iter().map(load).collect();
    Some(fault::find(&Scene::new(&machine, &errors, &sets).ok()?))
}

fn words(found: &[fault::DataDefect]) -> Vec<String> {
    let others = found.iter().filter(|one| one.kind.word() != "outlier");
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
fn after(case: &Case, change: impl Fn(&[&str], &mut Vec<String>)) -> Vec<fault::DataDefect> {
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
            let is_told = |one: &fault::DataDefect| one.kind.word() == "axes" && one.then == fault::Then::Refuse;
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
        let is_reversed = |one: &fault::DataDefect| one.kind.word() == "axes" && one.what.contains("reversed");
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
            let is_named = |one: &fault::DataDefect| one.then == fault::Then::Refuse && one.what.contains(what);
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
    assert!(of(&in_order).iter().all(|one| one.kind.word() != "order"));
    let mut random = Random::new(1, "order");
    for k in (2..lines.len()).rev() {
        lines.swap(k, 1 + random.below(k));
    }
    let shuffled: String = lines.iter().map(|line| without(line)).collect();
    assert!(of(&shuffled).iter().any(|one| one.kind.word() == "order"));
    // With senses in the table any order will do.
    assert!(of(&(lines.join("\n") + "\n")).iter().all(|one| one.kind.word() != "order"));
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

#[test]
fn a_slope_as_large_as_the_known_one_is_a_cause_and_no_table_with_the_wrong_sign() {
    // What the machine file says of EXX, µm over mm.
    let known = |x: f64| 3.2e-2 * x - 4.0e-5 * x * x + 1.5e-8 * x * x * x;
    let toml = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.5\n";
    let table = |more: &dyn Fn(f64) -> f64, seed: u64| {
        let mut random = Random::new(seed, "slope");
        let mut csv = "run,setup,component,X,Y,Z,X_dir,Y_dir,Z_dir,value_um\n".to_owned();
        for run in 1..=5 {
            for sense in [1, -1] {
                for k in 0..11 {
                    let place = if sense > 0 { k } else { 10 - k };
                    let x = [6.8, 83.4, 162.0, 209.3, 278.5, 360.9, 434.9, 489.4, 548.7, 639.0, 692.0][place];
                    let value = known(x) + more(x) + 0.5 * random.normal();
                    // No arm at which angles would act.
                    csv += &format!("{run},A,EXX,{x},0,0,{sense},0,-1,{value:.4}\n");
                }
            }
        }
        csv
    };
    for seed in 1..=6 {
        let csv = table(&|x| 0.01 * x, seed);
        let found = found(MACHINE, &[("one", &csv, toml)]);
        assert!(found.iter().all(|one| one.then != fault::Then::Refuse), "{:?}", words(&found));
    }
    let shop =
        Shop::new().file("demo.toml", MACHINE).file("one.csv", table(&|x| 0.01 * x, 7).as_str()).file("one.toml", toml);
    let report = shop.run("diagnose one.csv --machine demo.toml --json".split(' ')).exits(0).json();
    let one = &report["findings"][0];
    let [value, u95] = ["value", "u95"].map(|key| one[key].as_f64().unwrap());
    assert!([&one["effect"], &one["parameter"]] == ["motion", "EXX"] && (value - 10.0).abs() < u95, "{one}");
    // With the bend of the known error twice as large as well, it is a table.
    let found = found(MACHINE, &[("one", &table(&known, 8), toml)]);
    assert!(
        found.iter().any(|one| one.what.contains("wrong sign") && one.then == fault::Then::Refuse),
        "{:?}",
        words(&found)
    );
}

#[test]
fn readings_that_stay_the_same_are_left_out_and_their_rows_told() {
    let case = recipe(Bench::Plate, &[], 41).cook().unwrap();
    let file = &case.files[0];
    let with = |cell: &str| {
        let row = std::cell::Cell::new(0);
        changed(&file.csv, |names, cells| {
            row.set(row.get() + 1);
            if (101..=150).contains(&row.get()) || (301..=330).contains(&row.get()) {
                cells[place(names, "dx_um")] = cell.into();
            }
        })
    };
    let report = |csv: &str| {
        let shop =
            Shop::new().file("machine.toml", &case.machine_toml).file("one.csv", csv).file("one.toml", &file.toml);
        shop.run("diagnose one.csv --machine machine.toml --json".split(' ')).exits(0).json()
    };
    let (stuck, cut) = (report(&with("40.5")), report(&with("")));
    let constant = |one: &&Value| one["what"] == "constant";
    let rows: Vec<&Value> =
        stuck["data_faults"].as_array().unwrap().iter().filter(constant).map(|one| &one["rows"]).collect();
    assert_eq!(rows, [&serde_json::json!([101, 150]), &serde_json::json!([301, 330])]);
    let size = |report: &Value, key: &str| report[key]["rms_um"].as_f64().unwrap();
    for key in ["before", "after"] {
        let [left, right] = [&stuck, &cut].map(|report| size(report, key));
        assert!((left / right - 1.0).abs() < 0.01, "{key} {left} {right}");
    }
    // dx, dy and dz of each row; a few more are far out.
    let [most, rows] = [stuck["readings"].as_u64().unwrap(), file.csv.lines().count() as u64 - 1];
    assert!(most <= 3 * rows - 80, "{most} of {rows} rows");
}

#[test]
fn a_few_readings_do_not_say_that_a_model_has_expired() {
    // Noise of 0.6 µm where the model says 0.2 µm: they are two stretches, in both of which it is worse by a little than no model.
    let readings = [0.6, -0.6, 0.6, -0.6, -0.6, 0.6, -0.6];
    let row = |(k, value): (usize, &f64)| format!("a,A,EXX,{:.3},250,200,1,0,-1,{value}\n", 340.0 + 3.333 * k as f64);
    let csv = "run,setup,component,X,Y,Z,X_dir,Y_dir,Z_dir,value_um\n".to_owned();
    let csv = csv + &readings.iter().enumerate().map(row).collect::<String>();
    let toml = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.5\n";
    let shop = Shop::new().file("demo.toml", MACHINE).file("one.csv", &csv).file("one.toml", toml);
    let report = shop.run("diagnose one.csv --machine demo.toml --json".split(' ')).exits(0).json();
    let [before, without] = ["before", "without_model"].map(|key| report[key]["rms_um"].as_f64().unwrap());
    assert!(before > without && report["expired"] == false, "{report:#}");
}

/// One reading a minute beside a spindle that turns at four speeds. A display with steps of 1 µm shows two of three readings of X and Y as 0, and the growth
/// of 12 µm of Z in whole numbers. None of them is an outlier.
#[test]
fn a_coarse_display_has_no_outliers_and_shows_the_growth() {
    let mut table = "t_s,spindle_rpm,dx_um,dy_um,dz_um\n".to_owned();
    let speeds = [0.0, 12_000.0, 3_000.0, 9_000.0, 12_000.0, 0.0, 9_000.0, 3_000.0];
    let mut random = Random::new(12, "display");
    for minute in 0..480_u32 {
        let rpm = speeds[minute as usize / 60];
        let growth = -12.0 * (rpm / 12_000.0_f64).powi(2);
        let [x, y, z] = [0.0, 0.0, growth].map(|um| (um + 0.5 * random.normal()).round());
        table.push_str(&format!("{},{rpm},{x},{y},{z}\n", 60 * minute));
    }
    let shop = Shop::new().file("m.toml", MACHINE).file("log.csv", table).file("log.toml", PLACE);
    let report: Value = shop.run(["diagnose", "log.csv", "--machine", "m.toml", "--json"]).exits(0).json();
    let faults = report["data_faults"].as_array().unwrap();
    assert!(faults.iter().all(|one| one["kind"] != "outlier"), "{faults:?}");
    let all = report["findings"].as_array().unwrap();
    assert!(all.iter().any(|one| one["effect"] == "spindle-speed" && one["parameter"] == "Z"), "{report:#}");
}
