//! Faults of the data are found before causes are looked for, and effects of the machine are not taken for faults: held against the plant, which
//! shares no code with the checks.

use std::collections::BTreeMap;

use ncfix_base::source::{FileId, Source};
use ncfix_metrology::diagnose::{Scene, fault};
use ncfix_metrology::measure::data;

use crate::plant::{BENCHES, Bench, Case, FAULTS, FaultKind, Recipe, UNKNOWNS, Unknown, is_possible, rows_shown};
use crate::support::Shop;

/// The first row of the catalogue that is a fault itself.
const FIRST_FAULT: u8 = 60;

/// Everything that was found in a case, with the file; as [`fault::find`] has it.
fn found(case: &Case) -> Vec<(String, fault::DataDefect)> {
    found_in(case, &case.files)
}

fn found_in(case: &Case, files: &[crate::plant::File]) -> Vec<(String, fault::DataDefect)> {
    let source = |id, name: &str, text: &str| Source::new(FileId(id), name, text.as_bytes().to_vec()).unwrap();
    let (machine, findings) = ncfix_model::file::load(&source(0, "machine.toml", &case.machine_toml));
    let (machine, errors) = machine.unwrap_or_else(|| panic!("{findings:?}"));
    let load = |file: &crate::plant::File| {
        let (table, description) = (source(1, "table.csv", &file.csv), source(2, "table.toml", &file.toml));
        let (data, findings) = data::load_with_dead(&file.stem, &table, &description, &machine);
        data.unwrap_or_else(|| panic!("{}: {findings:?}", case.name))
    };
    let sets: Vec<data::DataSet> = files.iter().map(load).collect();
    let scene = Scene::new(&machine, &errors, &sets).unwrap();
    fault::find(&scene).into_iter().map(|found| (sets[found.set].name.clone(), found)).collect()
}

/// How many of the faults that were put into a case are among those found, of how many that can be seen: the same kind, file, names and words,
/// and mostly the same rows.
fn named(case: &Case, found: &[(String, fault::DataDefect)]) -> [usize; 2] {
    let names = |text: &str| {
        let mut names: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
        names.sort();
        names
    };
    let seen = case.truth.faults.iter().filter(|truth| truth.unseen.is_none());
    let is_named = |truth: &&crate::plant::Fault| {
        found.iter().any(|(file, one)| {
            let common = (one.rows[1].min(truth.rows[1]) + 1).saturating_sub(one.rows[0].max(truth.rows[0]));
            let both = one.rows[1].max(truth.rows[1]) + 1 - one.rows[0].min(truth.rows[0]);
            one.kind.word() == truth.kind
                && *file == truth.file
                && one.what == truth.what
                && (truth.name.is_empty() || names(&one.name) == names(&truth.name))
                && 2 * common >= both
                && !one.evidence.is_empty()
        })
    };
    [seen.clone().filter(is_named).count(), seen.count()]
}

/// Cases in which nothing is wrong with the data: no effect, each row of the catalogue, each effect that no catalogue has.
fn clean(bench: Bench, size_in_noise: f64, seed: u64) -> Vec<Case> {
    let mut recipes = vec![Recipe::new(bench, size_in_noise, seed)];
    for row in rows_shown(bench).iter().copied().filter(|row| *row < FIRST_FAULT) {
        recipes.push(Recipe { hide: vec![row], ..Recipe::new(bench, size_in_noise, seed) });
    }
    recipes.extend(UNKNOWNS.map(|kind| Recipe { unknown: Some(kind), ..Recipe::new(bench, size_in_noise, seed) }));
    recipes.iter().filter_map(Recipe::cook).collect()
}

/// Faults other than single readings, of which the plant makes some everywhere.
fn claims(found: &[(String, fault::DataDefect)]) -> Vec<String> {
    let claimed = found.iter().filter(|(_, one)| one.kind.word() != "outlier");
    claimed.map(|(file, one)| format!("{file} {} {} {:?}: {}", one.kind, one.what, one.rows, one.evidence)).collect()
}

#[test]
fn each_kind_of_fault_is_found() {
    for kind in FAULTS {
        let made = [Bench::Drift, Bench::Plate, Bench::Laser].into_iter().filter(|&bench| is_possible(kind, bench));
        let mut cases = made.filter_map(|bench| Recipe { faults: vec![kind], ..Recipe::new(bench, 5.0, 2) }.cook());
        let case = cases.find(|case| case.truth.faults.iter().any(|fault| fault.unseen.is_none())).unwrap();
        let found = found(&case);
        let [hits, all] = named(&case, &found);
        assert!(hits == all && all > 0, "{}{:?}", case.words(), claims(&found));
    }
}

#[test]
fn what_the_machine_does_is_no_fault() {
    let mut wrong = Vec::new();
    for bench in [Bench::Drift, Bench::OnTheFly, Bench::Load] {
        for case in clean(bench, 5.0, 2) {
            let claims = claims(&found(&case));
            wrong.extend(claims.into_iter().map(|claim| format!("{}: {claim}", case.name)));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn what_fades_or_is_switched_and_what_goes_on_while_others_are_read_is_no_step() {
    // A shift that fades within an hour; one that comes above a speed and goes below it; a line that is read again after minutes on others.
    let fading = [51, 52, 56].map(|seed| (Bench::Drift, vec![44], None, seed));
    let switched = [56, 62, 64].map(|seed| (Bench::Drift, vec![], Some(Unknown::Speed), seed));
    let others = [52, 56].map(|seed| (Bench::HotCold, vec![42], None, seed));
    for (bench, hide, unknown, seed) in fading.into_iter().chain(switched).chain(others) {
        let case = Recipe { hide, unknown, ..Recipe::new(bench, 5.0, seed) }.cook().unwrap();
        let claims = claims(&found(&case));
        assert!(claims.is_empty(), "{}{claims:?}", case.words());
    }
}

#[test]
#[ignore = "minutes; shows the shares that the light ones sample"]
fn faults_are_found_and_none_is_claimed_over_many_seeds() {
    let mut table: BTreeMap<String, [usize; 2]> = BTreeMap::new();
    for kind in FAULTS {
        for bench in BENCHES.into_iter().filter(|&bench| is_possible(kind, bench)) {
            for seed in 51..=70 {
                let Some(case) = (Recipe { faults: vec![kind], ..Recipe::new(bench, 3.0, seed) }).cook() else {
                    continue;
                };
                let cell = table.entry(format!("{kind:?} {bench:?}")).or_default();
                let [hits, all] = named(&case, &found(&case));
                cell[0] += hits;
                cell[1] += all;
            }
        }
    }
    let weak: Vec<_> = table.iter().filter(|(_, [hits, all])| hits * 100 < all * 90).collect();
    let (mut wrong, mut all) = (Vec::new(), 0);
    for seed in 51..=56 {
        for case in BENCHES.into_iter().flat_map(|bench| clean(bench, 5.0, seed)) {
            all += 1;
            let claims = claims(&found(&case));
            wrong.extend((!claims.is_empty()).then(|| format!("{}: {claims:?}", case.name)));
        }
    }
    assert!(all > 300 && wrong.len() * 100 <= all, "{wrong:#?}\n{table:#?}");
    let [hits, whole] = table.values().fold([0, 0], |[hits, whole], cell| [hits + cell[0], whole + cell[1]]);
    assert!(weak.is_empty() && hits * 100 >= whole * 97, "{weak:?}\n{table:#?}");
}

/// The same case with the names of the sensors changed, or all times later.
fn told_otherwise(case: &Case, name: impl Fn(&str) -> String, later_s: f64) -> Case {
    let of = |file: &crate::plant::File| {
        let mut lines = file.csv.lines();
        let head: Vec<&str> = lines.next().unwrap().split(',').collect();
        let time = head.iter().position(|cell| *cell == "t_s").unwrap();
        let mut csv = head.iter().map(|cell| name(cell)).collect::<Vec<String>>().join(",") + "\n";
        for line in lines {
            let cells = line.split(',').enumerate().map(|(column, cell)| match column == time {
                true => format!("{:.4}", cell.parse::<f64>().unwrap() + later_s),
                false => cell.to_owned(),
            });
            csv += &(cells.collect::<Vec<String>>().join(",") + "\n");
        }
        crate::plant::File { csv, ..file.clone() }
    };
    Case { files: case.files.iter().map(of).collect(), ..case.clone() }
}

#[test]
fn other_names_of_sensors_and_other_times_change_no_fault() {
    use FaultKind as F;
    for kind in [F::Stuck, F::Dead, F::Exchanged, F::Offset, F::Fahrenheit, F::Pulses, F::FirstCycle, F::Step] {
        let drift = Recipe::new(Bench::Drift, 5.0, 2);
        let case = Recipe { faults: vec![kind], fineness: 0.5, ..drift }.cook().unwrap();
        let rename = |name: &str| if name.starts_with("T_") { name.replace("T_", "T_q") } else { name.to_owned() };
        let told = |found: Vec<(String, fault::DataDefect)>, name: &dyn Fn(&str) -> String| -> Vec<_> {
            let mut all: Vec<_> = found
                .into_iter()
                .map(|(file, one)| {
                    let mut names: Vec<String> = one.name.split(' ').map(name).collect();
                    names.sort();
                    (file, one.kind.word(), names, one.what, one.rows)
                })
                .collect();
            all.sort();
            all
        };
        let before = found(&case);
        assert!(!before.is_empty(), "{kind:?}");
        let same = |name: &str| name.to_owned();
        let renamed = told(found(&told_otherwise(&case, rename, 0.0)), &same);
        assert_eq!(told(before.clone(), &rename), renamed, "{kind:?}");
        let later = told(found(&told_otherwise(&case, same, 86_400.0)), &same);
        assert_eq!(told(before, &same), later, "{kind:?}");
    }
}

/// A case whose only table is this one, of a length along X.
fn of_table(csv: String) -> Case {
    let case = Recipe::new(Bench::Laser, 5.0, 2).cook().unwrap();
    let toml = "[measurement]\nkind = \"displacement\"\nsigma_um = 0.5\nfree = []\n".to_owned();
    let files = vec![crate::plant::File { csv, toml, ..case.files[0].clone() }];
    Case { files, ..case }
}

#[test]
fn tables_that_say_little_are_no_fault_and_long_ones_take_no_time() {
    let head = "X,Y,Z,X_dir,Y_dir,Z_dir,run,t_s,T_a_C,T_b_C,dx_um\n";
    let row = |k: usize, dx: f64| {
        let x = 10 * (k % 40);
        let (warm, cool) = (20.0 + (k as f64 * 0.7).sin(), 21.0 + (k as f64 * 0.9).cos());
        format!("{x},100,100,1,0,0,{},{},{warm:.3},{cool:.3},{dx:.4}\n", k / 40, 2 * k)
    };
    assert!(found(&of_table(head.to_owned() + &row(0, 0.1))).is_empty(), "one row");
    let constant: String = (0..50).map(|k| format!("10,100,100,1,0,0,1,{k},20,20,0\n")).collect();
    assert!(claims(&found(&of_table(head.to_owned() + &constant))).is_empty(), "constant columns");
    // Noise without random numbers: digits of a product.
    let noise = |k: usize| (k as f64 * 0.618_033_988).fract() + (k as f64 * 0.414_213_562).fract() - 1.0;
    let begin = std::time::Instant::now();
    let long: String = (0..20_000).map(|k| row(k, noise(k))).collect();
    let mut claims = claims(&found(&of_table(head.to_owned() + &long)));
    // Noise alone has none of the errors that the machine file knows, which is rightly said.
    claims.retain(|claim| !claim.contains("known errors already removed"));
    assert!(claims.is_empty() && begin.elapsed().as_secs() < 30, "{:?} {claims:?}", begin.elapsed());
}

/// Diagnoses a case; gives the exit status and the object.
fn diagnosed(case: &Case, status: i32) -> serde_json::Value {
    let mut shop = Shop::new().file("machine.toml", &case.machine_toml);
    let mut arguments = vec!["diagnose".to_owned()];
    for file in &case.files {
        let table = format!("{}.csv", file.stem);
        shop = shop.file(&table, &file.csv).file(&format!("{}.toml", file.stem), &file.toml);
        arguments.push(table);
    }
    arguments.extend(["--machine", "machine.toml", "--json"].map(str::to_owned));
    shop.run(&arguments).exits(status).json()
}

#[test]
fn the_command_reports_faults_and_refuses_what_is_no_data() {
    let case = Recipe { faults: vec![FaultKind::Millimetres], ..Recipe::new(Bench::Plate, 5.0, 2) }.cook().unwrap();
    let object = diagnosed(&case, 4);
    assert_eq!(object["diagnostics"][0]["code"], "E0614");
    assert_eq!(object["data_faults"][0]["what"], "factor 0.001");
    assert!(object["findings"].as_array().unwrap().is_empty(), "nothing is read on");
    let of_a_day = Recipe { fineness: 0.5, ..Recipe::new(Bench::Drift, 5.0, 2) };
    let case = Recipe { faults: vec![FaultKind::Stuck], ..of_a_day }.cook().unwrap();
    let truth = &case.truth.faults[0];
    let object = diagnosed(&case, 0);
    let fault = &object["data_faults"][0];
    assert_eq!([&fault["kind"], &fault["name"], &fault["what"]], ["sensor", truth.name.as_str(), "stuck"]);
    assert_eq!(fault["rows"], serde_json::json!([truth.rows[0] + 1, truth.rows[1] + 1]));
    let sensors: Vec<_> = object["findings"].as_array().unwrap().iter().map(|one| one["sensor"].clone()).collect();
    assert!(!sensors.contains(&truth.name.as_str().into()), "a sensor at fault is no cause");
    let told = object["diagnostics"].as_array().unwrap().iter().find(|one| one["code"] == "W0607").unwrap();
    assert!(told["message"].as_str().unwrap().contains("stuck"), "{told}");
    assert_eq!(told["line"], truth.rows[0] + 2, "the header is a line as well");
    assert!(told["column"].as_u64().unwrap() > 1, "{told}");
}

#[test]
fn dead_sensors_and_faults_of_data_held_out_are_told_and_do_not_forbid_a_diagnosis() {
    let of_a_day = Recipe { fineness: 0.4, ..Recipe::new(Bench::Drift, 5.0, 3) };
    let sound = of_a_day.cook().unwrap();
    let dead = Recipe { faults: vec![FaultKind::Dead], ..of_a_day }.cook().unwrap();
    let truth = &dead.truth.faults[0];
    // What is at fault is held out.
    let held = crate::plant::File { stem: "judge".to_owned(), ..dead.files[0].clone() };
    let mut shop = Shop::new().file("machine.toml", &dead.machine_toml);
    for file in [&sound.held_out[0], &held] {
        shop = shop.file(&format!("{}.csv", file.stem), &file.csv).file(&format!("{}.toml", file.stem), &file.toml);
    }
    let table = format!("{}.csv", sound.held_out[0].stem);
    let arguments = ["diagnose", &table, "--holdout", "judge.csv", "--machine", "machine.toml", "--json"];
    let object = shop.run(arguments).exits(0).json();
    let faults = object["data_faults"].as_array().unwrap();
    let told = faults.iter().find(|one| one["what"] == "dead").unwrap_or_else(|| panic!("{faults:?}"));
    assert_eq!([&told["kind"], &told["name"], &told["file"]], ["sensor", truth.name.as_str(), "judge"]);
    let is_held = |one: &serde_json::Value| {
        one["code"] == "W0607" && one["message"].as_str().unwrap().starts_with("held out, judge T_")
    };
    assert!(object["diagnostics"].as_array().unwrap().iter().any(is_held), "{}", object["diagnostics"]);
    // Who calibrates has to take it out.
    let source = |id, text: &str| Source::new(FileId(id), "judge", text.as_bytes().to_vec()).unwrap();
    let (machine, _) = ncfix_model::file::load(&source(0, &dead.machine_toml)).0.unwrap();
    let (read, refused) = data::load("judge", &source(1, &held.csv), &source(2, &held.toml), &machine);
    assert!(read.is_none() && refused.iter().all(|one| one.code.as_str() == "E0603"), "{refused:?}");
}

#[test]
fn a_cause_is_found_beside_a_fault() {
    let hidden = Recipe { hide: vec![20], faults: vec![FaultKind::Pulses], ..Recipe::new(Bench::Plate, 5.0, 11) };
    let case = hidden.cook().unwrap();
    let object = diagnosed(&case, 0);
    let kinds: Vec<_> = object["data_faults"].as_array().unwrap().iter().map(|one| one["kind"].clone()).collect();
    assert!(kinds.contains(&"pulse".into()), "{}{kinds:?}", case.words());
    let truth = &case.truth.effects[0];
    let is_named =
        |one: &serde_json::Value| one["effect"] == truth.effect && one["parameter"] == truth.parameter.as_str();
    assert!(object["findings"].as_array().unwrap().iter().any(is_named), "{}{}", case.words(), object["findings"]);
}

/// Steps of cases in which readings drift with temperatures as well: found of those that can be seen, those that were not, and claims where no step is.
fn steps_beside_drifts(
    size_in_noise: f64,
    seeds: std::ops::RangeInclusive<u64>,
) -> ([usize; 2], Vec<String>, Vec<String>) {
    let (mut hits, mut missed, mut wrong) = ([0; 2], Vec::new(), Vec::new());
    for (bench, seed) in
        [Bench::Drift, Bench::DriftRuns].into_iter().flat_map(|bench| seeds.clone().map(move |seed| (bench, seed)))
    {
        for row in [38, 39, 43] {
            let clean = Recipe { hide: vec![row], ..Recipe::new(bench, size_in_noise, seed) };
            let step = Recipe { faults: vec![FaultKind::Step], ..clean.clone() };
            if let Some(case) = step.cook() {
                let found = found(&case);
                let [own, all] = named(&case, &found);
                hits = [hits[0] + own, hits[1] + all];
                if own < all {
                    missed.push(format!("{} {:?} {:?}", case.name, case.truth.faults, claims(&found)));
                }
            }
            if let Some(case) = clean.cook() {
                wrong.extend(claims(&found(&case)).into_iter().map(|claim| format!("{}: {claim}", case.name)));
            }
        }
    }
    (hits, missed, wrong)
}

#[test]
fn a_step_is_found_beside_a_drift() {
    let (hits, missed, wrong) = steps_beside_drifts(5.0, 1..=8);
    assert!(wrong.is_empty() && 10 * hits[0] >= 9 * hits[1], "{hits:?} {missed:#?} {wrong:#?}");
}

/// A laser whose runs differ by whole steps of its display, 0.1 µm: most neighbors agree exactly, which is no noise of zero. The repetitions differ by up to
/// 0.4 µm. A reading that is 5 µm off stays a fault.
#[test]
fn readings_that_agree_by_chance_make_no_outliers() {
    // Targets 0 to 400 mm upwards and back, five runs; a laser as it printed them.
    let up = [
        [0.1, 0.2, 0.0, -0.2, 0.1],
        [2.1, 2.2, 2.0, 1.8, 2.1],
        [5.1, 5.2, 5.0, 4.8, 5.1],
        [7.1, 7.2, 7.0, 6.8, 7.1],
        [9.0, 9.2, 9.0, 8.8, 9.1],
    ];
    let down = [
        [-4.8, -5.0, -5.1, -4.7, -4.9],
        [-2.8, -3.0, -3.1, -2.7, -2.9],
        [0.2, 0.0, -0.1, 0.3, 0.1],
        [2.2, 2.0, 1.9, 2.3, 2.1],
        [4.2, 4.0, 3.9, 4.3, 4.1],
    ];
    let table = |off_um: f64| {
        let mut text = "run,component,X,Y,Z,X_dir,value_um\n".to_owned();
        for run in 0..5 {
            for (place, values) in up.iter().enumerate() {
                let off = if (run, place) == (2, 2) { off_um } else { 0.0 };
                text += &format!("{run},EXX,{},200,100,1,{:.1}\n", 100 * place, values[run] + off);
            }
            for (place, values) in down.iter().enumerate().rev() {
                text += &format!("{run},EXX,{},200,100,-1,{:.1}\n", 100 * place, values[run]);
            }
        }
        text
    };
    let machine = "[machine]\nname = \"mill\"\ntopology = \"wFXYZSt\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n\
        [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-100, 400]\n";
    let description = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\n";
    for (off_um, is_fault) in [(0.0, false), (5.0, true)] {
        let shop = crate::support::Shop::new()
            .file("m.toml", machine)
            .file("laser.csv", table(off_um))
            .file("laser.toml", description);
        let run = shop.run(["diagnose", "laser.csv", "--machine", "m.toml"]);
        assert_eq!(
            run.stderr.contains("W0607") && run.stderr.contains("far from neighbors"),
            is_fault,
            "{}",
            run.stderr
        );
        assert!(!is_fault || run.stderr.contains("1 reading is more than 7 times the noise"), "{}", run.stderr);
    }
}
