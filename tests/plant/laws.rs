//! Laws of the plant as a whole: every row of the catalogue is hidden somewhere, sizes are what they say, seeds repeat, faults are where
//! they are said to be.

use std::path::Path;

use super::random::Random;
use super::{
    BENCHES, Bench, Case, FAULTS, FaultKind, File, NOT_SHOWN, Recipe, UNKNOWNS, Unknown, case, is_possible, rows_shown,
};

/// The words that a finding may have.
const WORDS: [&str; 22] = [
    "location",
    "motion",
    "periodic",
    "backlash",
    "lateral-play",
    "reversal-spike",
    "cross",
    "servo-mismatch",
    "following",
    "dynamic",
    "delay",
    "thermal-drift",
    "thermal-expansion",
    "thermal-squareness",
    "drift",
    "load",
    "setup",
    "probe",
    "sensor",
    "outlier",
    "program",
    "unknown",
];

fn recipe(bench: Bench, hide: &[u8], seed: u64) -> Recipe {
    // Enough to see the laws.
    Recipe { hide: hide.to_vec(), fineness: 0.5, outliers: Some(0.0), ..Recipe::new(bench, 5.0, seed) }
}

/// The cells of a column, by its name.
fn column<'a>(file: &'a File, name: &str) -> Vec<&'a str> {
    let mut lines = file.csv.lines();
    let place = lines.next().unwrap().split(',').position(|known| known == name).unwrap_or_else(|| panic!("no {name}"));
    lines.map(|line| line.split(',').nth(place).unwrap()).collect()
}

fn numbers(file: &File, name: &str) -> Vec<f64> {
    column(file, name).iter().map(|cell| cell.parse().unwrap()).collect()
}

/// The names of the columns with readings, and what turns them into µm or µrad.
fn readings(file: &File) -> (Vec<&'static str>, f64) {
    let head = file.csv.lines().next().unwrap();
    if head.contains("target") {
        return (vec!["X", "Y", "Z"], 1e3);
    }
    let all = ["dx_um", "dy_um", "dz_um", "dr_um", "value_um", "value_urad"];
    (all.into_iter().filter(|name| head.split(',').any(|cell| cell == *name)).collect(), 1.0)
}

#[test]
fn every_row_of_the_catalogue_is_shown_or_says_why_not() {
    for row in 1..=67 {
        let shown: Vec<Bench> = BENCHES.into_iter().filter(|&bench| rows_shown(bench).contains(&row)).collect();
        let reason = NOT_SHOWN.iter().find(|(number, _)| *number == row);
        assert_eq!(shown.is_empty(), reason.is_some(), "row {row}: {shown:?}, {reason:?}");
        assert!(reason.is_none_or(|(_, reason)| reason.len() > 20));
    }
}

#[test]
fn what_is_hidden_is_as_large_as_asked_and_knowing_it_helps() {
    for (bench, row) in BENCHES.into_iter().flat_map(|bench| rows_shown(bench).iter().map(move |&row| (bench, row))) {
        let case = recipe(bench, &[row], 7 + u64::from(row)).cook().unwrap_or_else(|| panic!("{bench:?} {row}"));
        let words = case.words();
        if row >= 60 {
            assert!(case.truth.effects.is_empty() && !case.truth.faults.is_empty(), "{words}");
            continue;
        }
        let [hidden] = &case.truth.effects[..] else { panic!("{words}") };
        assert!(WORDS.contains(&hidden.effect) && hidden.row == row && !hidden.drivers.is_empty(), "{words}");
        assert!(hidden.size.is_finite() && hidden.size != 0.0 && !hidden.unit.is_empty(), "{words}");
        assert!(hidden.rms_um > 0.0 && hidden.rms_um <= 1.01 * hidden.rms_acting_um, "{words}");
        assert_eq!(hidden.sensor.is_some(), hidden.lag_s.is_some(), "{words}");
        let sigma = |file: &File| -> f64 {
            let line = file.toml.lines().find(|line| line.starts_with("sigma_")).unwrap();
            line.rsplit(' ').next().unwrap().parse().unwrap()
        };
        // Chords come in whole numbers, and their circles in two sizes.
        let close = if row == 36 { 0.5 } else { 1e-6 };
        let is_asked = |file: &File| (hidden.rms_acting_um / sigma(file) / 5.0 - 1.0).abs() < close;
        assert!(case.files.iter().any(is_asked), "{words}");
        for file in &case.files {
            // Where the effect shows, the truth takes it away down to the noise.
            assert!(file.after_um < 1.25 * file.noise_um && file.before_um > 0.98 * file.after_um, "{words}");
        }
        assert!(!hidden.transfers || case.truth.gain > 0.08, "{words}");
    }
}

#[test]
fn readings_with_an_effect_less_those_without_are_what_it_is_said_to_make() {
    for (bench, row) in [
        (Bench::Laser, 25),
        (Bench::OnTheFly, 33),
        (Bench::Ballbar, 22),
        (Bench::Plate, 8),
        (Bench::Drift, 38),
        (Bench::Load, 45),
        (Bench::FiveAxis, 14),
        (Bench::HotCold, 42),
    ] {
        let (with, without) = (recipe(bench, &[row], 3).cook().unwrap(), recipe(bench, &[], 3).cook().unwrap());
        assert!(without.truth.effects.is_empty() && without.truth.gain.abs() < 1e-9);
        assert_eq!(with.machine_toml, without.machine_toml, "the start machine does not know");
        let all = |case: &Case| [case.files.clone(), case.held_out.clone()].concat();
        for (one, other) in all(&with).iter().zip(all(&without)) {
            assert!(other.hidden_um.iter().flatten().all(|v| v.abs() < 1e-9));
            let (names, factor) = readings(one);
            for (k, name) in names.into_iter().enumerate() {
                for ((a, b), hidden) in numbers(one, name).iter().zip(numbers(&other, name)).zip(&one.hidden_um) {
                    assert!(((a - b) * factor - hidden[k]).abs() < 2e-3, "{} {name}: {a} {b} {hidden:?}", one.stem);
                }
            }
        }
    }
}

#[test]
fn two_effects_add_up_and_neither_changes_the_other() {
    let [both, one, other] = [&[20, 8][..], &[20], &[8]].map(|rows| recipe(Bench::Ballbar, rows, 5).cook().unwrap());
    let sizes: Vec<f64> = both.truth.effects.iter().map(|hidden| hidden.size).collect();
    assert_eq!(sizes, [one.truth.effects[0].size, other.truth.effects[0].size]);
    for ((sum, a), b) in both.files[0].hidden_um.iter().zip(&one.files[0].hidden_um).zip(&other.files[0].hidden_um) {
        assert!((sum[0] - a[0] - b[0]).abs() < 2e-3);
    }
}

#[test]
fn noise_has_its_sigma() {
    for bench in BENCHES {
        let case = recipe(bench, &[], 11).cook().unwrap();
        let declared = case.truth.noise_um;
        for file in &case.files {
            // Set-ups take some of the slow drift.
            assert!((0.80..1.12).contains(&(file.after_um / file.noise_um)), "{}", case.words());
        }
        assert!((0.6..1.0).contains(&(declared / case.files[0].noise_um)));
        let sigma: f64 = case.files[0]
            .toml
            .lines()
            .find(|line| line.starts_with("sigma_"))
            .unwrap()
            .rsplit(' ')
            .next()
            .unwrap()
            .parse()
            .unwrap();
        assert!((sigma - declared).abs() < 1e-9);
    }
    let mut random = Random::new(1, "normal");
    let drawn: Vec<f64> = (0..40_000).map(|_| random.normal()).collect();
    let moment = |power: i32| drawn.iter().map(|v| v.powi(power)).sum::<f64>() / drawn.len() as f64;
    assert!(moment(1).abs() < 0.02 && (moment(2) - 1.0).abs() < 0.03 && (moment(4) - 3.0).abs() < 0.2);
    let even: Vec<f64> = (0..40_000).map(|_| random.unit()).collect();
    assert!((even.iter().sum::<f64>() / 40_000.0 - 0.5).abs() < 0.01 && even.iter().all(|v| (0.0..1.0).contains(v)));
}

#[test]
fn a_seed_gives_the_same_text_again_and_another_gives_another() {
    for bench in [Bench::Plate, Bench::Drift, Bench::FiveAxis] {
        let row = rows_shown(bench)[0];
        let [one, again, other] = [4, 4, 5].map(|seed| case(bench, &[row], 3.0, seed).unwrap());
        assert_eq!(one.words(), again.words());
        assert_eq!(one.files[0].csv, again.files[0].csv);
        assert_eq!(one.held_out[0].csv, again.held_out[0].csv);
        assert_ne!(one.files[0].csv, other.files[0].csv);
        assert_ne!(one.files[0].csv, one.held_out[0].csv);
    }
}

#[test]
fn outliers_are_where_they_are_said_to_be() {
    let mut with = recipe(Bench::Plate, &[], 9);
    with.outliers = Some(0.02);
    let (with, without) = (with.cook().unwrap(), recipe(Bench::Plate, &[], 9).cook().unwrap());
    let (file, clean) = (&with.files[0], &without.files[0]);
    assert!((10..40).contains(&file.outliers.len()) && clean.outliers.is_empty());
    let rows: Vec<(&str, &str)> = file.csv.lines().skip(1).zip(clean.csv.lines().skip(1)).collect();
    for (k, (a, b)) in rows.iter().enumerate() {
        assert_eq!(a != b, file.outliers.contains(&k), "row {k}");
    }
}

#[test]
fn effects_outside_the_catalogue_have_no_name_but_drivers() {
    for kind in UNKNOWNS {
        let cases: Vec<Case> = BENCHES
            .into_iter()
            .filter_map(|bench| Recipe { unknown: Some(kind), ..recipe(bench, &[], 21) }.cook())
            .collect();
        assert!(!cases.is_empty(), "{kind:?} is hidden nowhere");
        for case in cases {
            let [hidden] = &case.truth.effects[..] else { panic!("{}", case.words()) };
            assert!(hidden.effect == "unknown" && hidden.row == 0 && !hidden.drivers.is_empty());
            let head = case.files[0].csv.lines().next().unwrap();
            assert!(hidden.drivers.iter().all(|name| head.split(',').any(|cell| cell == name)), "{}", case.words());
            assert!(case.truth.gain > 0.1, "{}", case.words());
        }
    }
    assert!(Recipe { unknown: Some(Unknown::Speed), ..recipe(Bench::Plate, &[], 1) }.cook().is_none());
}

#[test]
fn faults_are_in_the_rows_that_are_said() {
    for kind in FAULTS {
        let benches: Vec<Bench> = BENCHES.into_iter().filter(|&bench| is_possible(kind, bench)).collect();
        assert!(!benches.is_empty() && benches.len() < BENCHES.len(), "{kind:?}");
        for bench in benches {
            let broken = Recipe { faults: vec![kind], ..recipe(bench, &[], 13) }.cook().unwrap();
            let sound = recipe(bench, &[], 13).cook().unwrap();
            let words = broken.words();
            assert_eq!(broken.held_out[0].csv == sound.held_out[0].csv, kind != FaultKind::Compensated, "{words}");
            for fault in &broken.truth.faults {
                let [file, clean] =
                    [&broken, &sound].map(|case| case.files.iter().find(|file| file.stem == fault.file).unwrap());
                let rows: Vec<(&str, &str)> = file.csv.lines().skip(1).zip(clean.csv.lines().skip(1)).collect();
                let [first, last] = fault.rows;
                assert!(
                    first <= last && last < rows.len() && rows[first..=last].iter().any(|(a, b)| a != b),
                    "{words}"
                );
                check(kind, fault.name.as_str(), fault.rows, file, clean);
            }
            let touched =
                |k: usize| broken.truth.faults.iter().any(|fault| (fault.rows[0]..=fault.rows[1]).contains(&k));
            let rows = broken.files[0].csv.lines().skip(1).zip(sound.files[0].csv.lines().skip(1));
            assert!(rows.enumerate().all(|(k, (a, b))| a == b || touched(k)), "{words}");
        }
    }
}

/// What a fault did to the columns.
fn check(kind: FaultKind, name: &str, [first, last]: [usize; 2], file: &File, clean: &File) {
    let factor = |k: f64| {
        let name = readings(file).0[0];
        let (a, b) = (numbers(file, name), numbers(clean, name));
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b * k).abs() < 0.0001 + 0.0001 * k), "{kind:?}");
    };
    let within = |cells: Vec<f64>| cells[first..=last].to_vec();
    match kind {
        FaultKind::Millimetres => factor(1e-3),
        FaultKind::Thousandfold => factor(1e3),
        FaultKind::Inches => factor(1.0 / 25.4),
        FaultKind::Swapped => assert_eq!(numbers(file, "dx_um"), numbers(clean, "dy_um")),
        FaultKind::Stuck => assert!(within(numbers(file, name)).windows(2).all(|two| two[0] == two[1])),
        FaultKind::Dead => assert!(within(numbers(file, name)).iter().all(|v| *v == -180.0)),
        FaultKind::Exchanged => {
            let (one, other) = name.split_once(' ').unwrap();
            assert_eq!(within(numbers(file, one)), within(numbers(clean, other)));
        }
        FaultKind::Offset => {
            let off: Vec<f64> =
                within(numbers(file, name)).iter().zip(within(numbers(clean, name))).map(|(a, b)| a - b).collect();
            assert!(off.iter().all(|v| v.abs() > 2.9 && (v - off[0]).abs() < 0.003));
        }
        FaultKind::Fahrenheit => {
            let (a, b) = (numbers(file, name), numbers(clean, name));
            assert!(a.iter().zip(b).all(|(a, b)| ((a - 32.0) / 1.8 - b).abs() < 0.002));
        }
        // Their rows are looked at by the caller.
        FaultKind::Reversed
        | FaultKind::Pulses
        | FaultKind::FirstCycle
        | FaultKind::Step
        | FaultKind::Compensated
        | FaultKind::Quantised => {}
    }
}

#[test]
fn what_a_bench_cannot_show_is_refused() {
    assert!(case(Bench::Laser, &[26], 3.0, 1).is_none());
    assert!(case(Bench::Plate, &[8, 38], 3.0, 1).is_none());
    assert!(case(Bench::Load, &[60], 3.0, 1).is_none());
    assert!(Recipe { faults: vec![FaultKind::Stuck], ..recipe(Bench::Ballbar, &[], 1) }.cook().is_none());
}

#[test]
fn the_plant_shares_no_code_with_the_crate() {
    fn walk(folder: &Path, faults: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, faults);
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            let own = text.replace(concat!("crate", "::plant"), "");
            if [concat!("nc", "fix::"), concat!("crate", "::")].iter().any(|word| own.contains(word)) {
                faults.push(format!("{}: names code that is not the plant's", path.display()));
            }
            if text.lines().count() > 400 || !text.starts_with("//! ") {
                faults.push(format!("{}: too long, or no first sentence", path.display()));
            }
        }
    }
    let mut faults = Vec::new();
    walk(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/plant"), &mut faults);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_case_is_a_folder_of_files() {
    let folder = std::env::temp_dir().join(format!("plant-{}", std::process::id()));
    let case = recipe(Bench::HotCold, &[40], 2).cook().unwrap();
    let paths = case.save(&folder).unwrap();
    assert_eq!(paths.machine, folder.join("machine.toml"));
    assert_eq!(paths.files, [folder.join("plate.csv"), folder.join("laser.csv")]);
    assert_eq!(paths.held_out, [folder.join("held_plate.csv"), folder.join("held_laser.csv")]);
    for (path, file) in paths.files.iter().chain(&paths.held_out).zip(case.files.iter().chain(&case.held_out)) {
        assert_eq!(std::fs::read_to_string(path).unwrap(), file.csv);
        assert_eq!(std::fs::read_to_string(path.with_extension("toml")).unwrap(), file.toml);
    }
    assert!(std::fs::read_to_string(&paths.machine).unwrap().contains("topology = \"w"));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn the_machine_file_says_in_micrometres_what_the_plant_has() {
    let text = case(Bench::Plate, &[], 3.0, 1).unwrap().machine_toml;
    // 14 µrad, 3.1 µm and 2 µm in the plant.
    for line in ["EC0Y = 14.0", "values_um = [0.0, 3.1, 4.4, -1.2]", "value_um = 2.0"] {
        assert!(text.lines().any(|known| known == line), "{line} in\n{text}");
    }
}
