//! What goes with temperatures is found by its name, its sensor, its size and its time constant, whatever the runs and clocks of the file are; a machine
//! file that is extended by it says the same as the search did; and noise that wanders is nothing that goes with them.

use serde_json::Value;

use crate::diagnose_causes::{diagnosed, recipe, text, words};
use crate::plant::{Bench, Case, File};
use crate::support::Shop;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn findings(report: &Value) -> &[Value] {
    report["findings"].as_array().unwrap()
}

/// Why what is hidden first is not found with its sensor, its size within its interval and its lag within 20 %.
fn wrong(case: &Case, findings: &[Value]) -> Option<String> {
    let truth = &case.truth.effects[0];
    let sensor = format!("{}_C", truth.sensor.unwrap());
    let is_own = |one: &&Value| {
        text(&one["effect"]) == truth.effect && text(&one["parameter"]) == truth.parameter && one["sensor"] == sensor
    };
    let Some(own) = findings.iter().find(is_own) else { return Some("not found".into()) };
    if (number(&own["value"]) - truth.size).abs() > number(&own["u95"]) {
        return Some(format!("{} ± {}", own["value"], own["u95"]));
    }
    let (lag, known) = (number(&own["lag_s"]), truth.lag_s.unwrap());
    // A lag below half of the interval between readings is none. Growth is read on lines on levels that stay, while temperatures change within 6000 s:
    // beside a size and a free zero for each set-up, growth of 1.1 to 2.1 µm/(m K) with a lag of 1000 s differs there from one without by χ² of 1 to 6
    // only (three of these days, in arithmetic apart from the program), with one of 30 s by nothing. Less than 9, no lag is told from none.
    let none = if text(&own["effect"]) == "thermal-expansion" { 1000.0 } else { 30.0 };
    let is_told = if known == 0.0 { lag <= none } else { (lag / known - 1.0).abs() <= 0.2 };
    (!is_told).then(|| format!("lag {lag}"))
}

/// Of cases by seeds 1, 2, … so many at least are told.
fn most(bench: Bench, row: u8, [least, count]: [u64; 2]) {
    let (mut out, mut wrongs, mut cooked) = (String::new(), 0, 0);
    // Not all days show what is hidden.
    let cases = (1..=2 * count).filter_map(|seed| recipe(bench, &[row], None, 6.0, seed).cook());
    for case in cases.take(count as usize) {
        cooked += 1;
        let report = diagnosed(&case, false);
        if let Some(why) = wrong(&case, findings(&report)) {
            wrongs += 1;
            let said = |one: &Value| {
                format!("{} {} ± {}, {} lag {}", words(one), one["value"], one["u95"], one["sensor"], one["lag_s"])
            };
            let said: Vec<String> = findings(&report).iter().map(said).collect();
            out += &format!("{why}\n{}  {}\n", case.words(), said.join("\n  "));
        }
    }
    assert!(cooked == count && wrongs + least <= count, "{out}");
}

#[test]
fn drift_in_runs_of_one_set_up_is_told_with_its_lag() {
    // On days that begin at rest, in the course of one day with a clock that begins again, and with one that goes on; two without a lag.
    most(Bench::DriftRuns, 38, [5, 6]);
}

#[test]
fn drift_of_two_sensors_in_runs_is_told_with_the_faster_one() {
    most(Bench::DriftRuns, 39, [3, 4]);
}

#[test]
fn growth_of_a_scale_is_told_without_a_lag() {
    most(Bench::HotCold, 40, [3, 4]);
}

/// Runs the program on the files of a case in a shop.
fn shop(case: &Case) -> (Shop, Vec<String>) {
    let mut shop = Shop::new().file("machine.toml", &case.machine_toml);
    for file in &case.files {
        shop = shop.file(&format!("{}.csv", file.stem), &file.csv).file(&format!("{}.toml", file.stem), &file.toml);
    }
    (shop, case.files.iter().map(|file| format!("{}.csv", file.stem)).collect())
}

#[test]
fn a_written_drift_says_what_the_search_said() {
    let case = recipe(Bench::DriftRuns, &[38], None, 6.0, 3).cook().unwrap();
    let (shop, data) = shop(&case);
    let run = |more: &[&str]| {
        let mut arguments = vec!["diagnose".to_owned()];
        arguments.extend(data.iter().cloned());
        arguments.extend(more.iter().map(|&word| word.to_owned()));
        shop.run(&arguments).exits(0).json()
    };
    let found = run(&["--machine", "machine.toml", "--json", "-o", "extended.toml"]);
    assert_eq!(found["findings"][0]["effect"], "thermal-drift", "{}", found["findings"]);
    let again = run(&["--machine", "extended.toml", "--json"]);
    let [after, before] = [&found["after"], &again["before"]].map(|sizes| number(&sizes["rms_um"]));
    assert!((before / after - 1.0).abs() < 0.01, "{after} {before}");
    assert!(findings(&again).is_empty(), "{}", again["findings"]);
}

/// The same case with the cells of a column changed by their row.
fn changed(case: &Case, column: &str, with: impl Fn(usize, &[&str], f64) -> String) -> Case {
    let of = |file: &File| {
        let mut lines = file.csv.lines();
        let head = lines.next().unwrap();
        let place = head.split(',').position(|cell| cell == column).unwrap();
        let mut csv = head.to_owned() + "\n";
        for (row, line) in lines.enumerate() {
            let mut cells: Vec<&str> = line.split(',').collect();
            let new = with(row, &cells, cells[place].parse().unwrap());
            cells[place] = &new;
            csv += &(cells.join(",") + "\n");
        }
        File { csv, ..file.clone() }
    };
    Case { files: case.files.iter().map(of).collect(), ..case.clone() }
}

#[test]
fn a_sensor_in_fahrenheit_says_the_same() {
    let case = recipe(Bench::DriftRuns, &[38], None, 6.0, 3).cook().unwrap();
    let sensor = format!("{}_C", case.truth.effects[0].sensor.unwrap());
    let plain = diagnosed(&case, false);
    let other = diagnosed(&changed(&case, &sensor, |_, _, value| format!("{:.5}", 1.8 * value + 32.0)), false);
    let faults: Vec<&str> = other["data_faults"].as_array().unwrap().iter().map(|one| text(&one["what"])).collect();
    assert!(faults.contains(&"degrees Fahrenheit"), "{faults:?}");
    assert!(!findings(&plain).is_empty());
    for (one, other) in findings(&plain).iter().zip(findings(&other)) {
        assert_eq!([&one["effect"], &one["sensor"]], [&other["effect"], &other["sensor"]]);
        let [one, other] = [one, other].map(|finding| number(&finding["value"]));
        assert!((other / one - 1.0).abs() < 1e-3, "{one} {other}");
    }
}

#[test]
fn a_sensor_that_is_stuck_in_one_run_is_told_by_the_others() {
    let case = recipe(Bench::DriftRuns, &[38], None, 6.0, 5).cook().unwrap();
    let sensor = format!("{}_C", case.truth.effects[0].sensor.unwrap());
    // A run has 150 rows at least, and the fourth of four begins behind 450 of them.
    let rows = case.files[0].csv.lines().count() - 1;
    let stays = (rows - 60)..rows;
    let stuck =
        changed(&case, &sensor, |row, _, value| if stays.contains(&row) { "24.5".into() } else { value.to_string() });
    let report = diagnosed(&stuck, false);
    let fault = report["data_faults"].as_array().unwrap().iter().find(|one| one["what"] == "stuck").unwrap().clone();
    assert_eq!([&fault["name"], &fault["excluded"]], [sensor.as_str(), "these rows"], "{fault}");
    assert_eq!(fault["rows"], serde_json::json!([rows - 59, rows]));
    assert_eq!(wrong(&stuck, findings(&report)), None, "{}{}", case.words(), report["findings"]);
}

#[test]
fn temperatures_that_end_early_or_fail_for_a_while_keep_the_drift_that_goes_with_them() {
    let case = recipe(Bench::DriftRuns, &[38], None, 6.0, 5).cook().unwrap();
    let sensor = format!("{}_C", case.truth.effects[0].sensor.unwrap());
    let rows = case.files[0].csv.lines().count() - 1;
    let fault = |report: &Value, name: &str| {
        let all = report["data_faults"].as_array().unwrap();
        all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{all:?}")).clone()
    };
    // The log of all sensors ends 40 rows before the readings, and repeats what it said last.
    let end = rows - 40;
    let mut last = std::collections::BTreeMap::new();
    let head: Vec<&str> = case.files[0].csv.lines().next().unwrap().split(',').collect();
    for (place, name) in head.iter().enumerate().filter(|(_, name)| name.starts_with("T_")) {
        last.insert(*name, case.files[0].csv.lines().nth(1 + end).unwrap().split(',').nth(place).unwrap());
    }
    let ended = last.iter().fold(case.clone(), |case, (name, value)| {
        changed(&case, name, |row, _, own| if row < end { own.to_string() } else { (*value).to_owned() })
    });
    let report = diagnosed(&ended, false);
    let told = fault(&report, "temperatures");
    assert_eq!([&told["what"], &told["excluded"]], ["log ends", "these rows"], "{told}");
    assert_eq!(told["rows"], serde_json::json!([end + 1, rows]));
    // Beside single readings, which the case has as well.
    let of_sensors = report["data_faults"].as_array().unwrap().iter().filter(|one| one["kind"] == "sensor").count();
    assert_eq!(of_sensors, 1, "{}", report["data_faults"]);
    assert_eq!(wrong(&ended, findings(&report)), None, "{}{}", case.words(), report["findings"]);
    // An open circuit for half an hour.
    let open = 200..230;
    let dead = changed(&case, &sensor, |row, _, own| if open.contains(&row) { "-180".into() } else { own.to_string() });
    let report = diagnosed(&dead, false);
    let told = fault(&report, &sensor);
    assert_eq!([&told["what"], &told["excluded"]], ["dead", "these rows"], "{told}");
    assert_eq!(told["rows"], serde_json::json!([201, 230]));
    assert_eq!(wrong(&dead, findings(&report)), None, "{}{}", case.words(), report["findings"]);
}

/// A case with one table of displacements at one place.
fn of_table(csv: String) -> Case {
    let case = recipe(Bench::DriftRuns, &[], None, 5.0, 3).cook().unwrap();
    let toml =
        "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\n[position]\nX_mm = 300\nY_mm = 200\nZ_mm = 200\n";
    let files = vec![File { csv, toml: toml.to_owned(), ..case.files[0].clone() }];
    Case { files, ..case }
}

#[test]
fn a_run_that_begins_cold_again_is_no_sensor_that_was_moved() {
    // 10 µm/K, and 0.1 µm a minute besides; the clock goes on.
    let row = |k: usize| {
        let run = 1 + k / 8;
        let warm = k % 8;
        let noise = [0.03, -0.05, 0.01, 0.04, -0.02, -0.04, 0.05][k % 7];
        format!("{run},A,{},{},{}\n", 60 * k, 20 + warm, 10.0 * warm as f64 + 0.1 * k as f64 + noise)
    };
    let case = of_table("run,setup,t_s,T_head_C,dz_um\n".to_owned() + &(0..24).map(row).collect::<String>());
    let report = diagnosed(&case, false);
    assert!(report["data_faults"].as_array().unwrap().is_empty(), "{}", report["data_faults"]);
    let own = findings(&report).iter().find(|one| one["sensor"] == "T_head_C").unwrap();
    // The drift of the zero in a run is 0.1 µm for each K as well.
    assert!((number(&own["value"]) - 10.0).abs() < 0.15, "{own}");
}

/// Normal numbers by a seed: a multiplicative generator (Lewis, Goodman & Miller 1969), twelve of which are added.
struct Normal(u64);

impl Normal {
    fn next(&mut self) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            self.0 = self.0 * 16_807 % 2_147_483_647;
            sum += self.0 as f64 / 2_147_483_647.0;
        }
        sum
    }
}

/// Three runs of five hours with a head that warms up with the spindle, an air that wanders and a bed that follows it; readings of white noise and
/// a random walk, and of the head as well.
fn walk(seed: u64, um_per_k: f64) -> Case {
    let mut normal = Normal(seed);
    let mut csv = "run,setup,t_s,T_head_C,T_air_C,T_bed_C,speed_rpm,dz_um\n".to_owned();
    for run in 0..3 {
        let (mut head, mut air, mut bed, mut slow, mut speed) = (0.0, 1.5 * normal.next(), 0.0, 0.0, 0.0);
        let first = 20.0 + 0.02 * normal.next();
        for k in 0..300 {
            if k % 30 == 0 {
                speed = 3000.0 * (normal.next() / 2.0).clamp(-1.0, 1.0) + 3000.0;
            }
            head += (12.0 * speed / 6000.0 - head) / 20.0;
            air += 0.05 * normal.next();
            bed += (air - bed) / 60.0;
            slow += 0.3 * normal.next();
            let [head_c, air_c, bed_c] = [head, air, bed].map(|above| 20.0 + above + 0.02 * normal.next());
            let head_c = if k == 0 { first } else { head_c };
            let z = um_per_k * head + slow + 0.5 * normal.next();
            csv += &format!("{run},A,{},{head_c:.3},{air_c:.3},{bed_c:.3},{speed:.0},{z:.4}\n", 60 * k);
        }
    }
    of_table(csv)
}

/// What is named in random walks of these seeds.
fn matched(seeds: std::ops::RangeInclusive<u64>) -> Vec<String> {
    let said = |seed: u64| {
        let report = diagnosed(&walk(seed, 0.0), false);
        assert_eq!(report["unexplained"]["structure"], true, "it is not told, and said to be there");
        let names: Vec<String> = findings(&report).iter().map(words).collect();
        (!names.is_empty()).then(|| format!("{seed} {names:?}"))
    };
    seeds.filter_map(said).collect()
}

/// Walks of these seeds that hide a drift of 2 µm/K.
fn hidden(seeds: std::ops::RangeInclusive<u64>) -> Vec<String> {
    let said = |seed: u64| {
        let report = diagnosed(&walk(seed, 2.0), false);
        let own = findings(&report).iter().find(|one| one["sensor"] == "T_head_C" && one["effect"] == "thermal-drift");
        let names: Vec<String> = findings(&report).iter().map(words).collect();
        let is_told = own.is_some_and(|own| (number(&own["value"]) - 2.0).abs() < 0.4);
        (!is_told).then(|| format!("{seed} {names:?}"))
    };
    seeds.filter_map(said).collect()
}

#[test]
fn a_random_walk_goes_with_no_temperature_and_hides_none() {
    // One chance match among six is allowed, since there is no end of shapes.
    let matched = matched(1..=6);
    assert!(matched.len() <= 1, "{matched:?}");
    let hidden = hidden(1..=4);
    assert!(hidden.len() <= 1, "{hidden:?}");
}

#[test]
#[ignore = "a minute; shows the rates that the light ones sample"]
fn rates_of_random_walks_and_drifts() {
    let matched = matched(1..=40);
    let hidden = hidden(1..=40);
    // Where nothing is hidden 2 % may be claimed: of 40 walks three or more with a chance of 5 %. With the noise known as it is 2 µm/K have a standard
    // deviation of 0.12 µm/K at most, 17 times less: all 40 could be told. The search, which has to find the noise as well, reaches 34.
    assert!(matched.len() <= 2 && hidden.len() <= 8, "{matched:?} {hidden:?}");
    // Bodies follow each other: T_spindle with a lag of 2112 s says what T_head does with 438 s but for χ² of 5 to 12 (seed 8, and 9 to 11 for seed 22; the
    // size and zeros free), which no search tells. Others differ by 20 to 50 and should be told (seeds 10 and 19): 13, 11 and 17 of 20 are reached, so this
    // fails here until they are.
    most(Bench::DriftRuns, 38, [18, 20]);
    most(Bench::DriftRuns, 39, [18, 20]);
    most(Bench::HotCold, 40, [18, 20]);
}
