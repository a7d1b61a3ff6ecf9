//! The value of a stated probability: of the causes stated with 95 % and more, at least 95 % are hidden there. Mixes of two to four rows of the
//! catalogue, from half of the noise to five times the noise, on every bench, and nothing at all in every sixth case.

use std::fmt::Write as _;
use std::sync::Mutex;

use serde_json::Value;

use crate::diagnose_causes::{diagnosed, same, text, words};
use crate::plant::{BENCHES, Bench, Case, Hidden, Random, Recipe, rows_shown};

/// Rows from here on are faults of the data, which have no probability.
const FIRST_FAULT: u8 = 60;
/// Upper limits of the bands of the table.
const BANDS: [f64; 6] = [0.5, 0.8, 0.95, 0.99, 0.999, f64::INFINITY];

/// A finding and what is true of it.
struct Told {
    probability: f64,
    is_true: bool,
    /// True if the size is within its interval; `None` where no size can be compared.
    is_inside: Option<bool>,
    words: String,
}

/// A mix by its number.
fn mix(number: u64) -> Option<Case> {
    let bench = BENCHES[(number % BENCHES.len() as u64) as usize];
    let random = &mut Random::new(number, "mix");
    let mut rows: Vec<u8> = rows_shown(bench).iter().copied().filter(|&row| row < FIRST_FAULT).collect();
    let count = if number % 6 == 5 { 0 } else { 2 + random.below(3) };
    let mut hide = Vec::new();
    while hide.len() < count.min(rows.len()) {
        hide.push(rows.swap_remove(random.below(rows.len())));
    }
    let size = (random.between(0.5_f64.ln(), 5.0_f64.ln())).exp();
    Recipe { hide, ..Recipe::new(bench, size, 5_000 + number) }.cook()
}

/// True if a finding is, or lists in its class, what is hidden. A finding without a name is true of what acts through all of its drivers.
fn is_of(finding: &Value, hidden: &Hidden) -> bool {
    let has_driver = |driver: &Value| hidden.drivers.iter().any(|own| own == text(driver));
    if text(&finding["effect"]) == "unknown" && finding["drivers"].as_array().unwrap().iter().all(has_driver) {
        return true;
    }
    // An unknown of set-ups is named with its set-up.
    if (text(&finding["effect"]), hidden.effect) == ("setup", "setup") {
        return text(&finding["parameter"]).split(' ').any(|word| word == hidden.parameter);
    }
    let class = finding["class"].as_array().unwrap().iter().map(text);
    let class = class.map(|name| name.split_once(' ').unwrap_or((name, "")));
    let own = (text(&finding["effect"]), text(&finding["parameter"]));
    let mut known = hidden.class.iter().map(|(effect, parameter)| (*effect, parameter.as_str()));
    let hidden = (hidden.effect, hidden.parameter.as_str());
    same(hidden, own) || known.any(|name| same(name, own)) || class.into_iter().any(|name| same(hidden, name))
}

/// Travels of X, Y and Z of the plant, mm; they begin at 0.
const TRAVELS_MM: [f64; 3] = [700.0, 500.0, 500.0];

/// The hidden size over the range that a finding states; `None` if the plant defines it in another way. A reversal value that grows from the lower end of the
/// travel is largest at the upper end of the range; an interaction is proportional to both ranges.
fn size_over(hidden: &Hidden, finding: &Value) -> Option<f64> {
    let ranges = finding["over"].as_array().unwrap().iter().map(|one| {
        let travel_mm = TRAVELS_MM["XYZ".find(text(&one["axis"])).unwrap()];
        ["low", "high"].map(|end| one[end].as_f64().unwrap() / travel_mm)
    });
    let ranges: Vec<[f64; 2]> = ranges.collect();
    match (hidden.row, ranges.as_slice()) {
        (21, [[_, high]]) => Some(hidden.size * high),
        (48, [one, other]) => Some(hidden.size * (one[1] - one[0]) * (other[1] - other[0])),
        _ => (finding["unit"] == hidden.unit).then_some(hidden.size),
    }
}

fn told(case: &Case) -> Vec<Told> {
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let report = diagnosed(case, false);
    let findings = report["findings"].as_array().unwrap();
    let told = findings.iter().map(|finding| {
        let own = (text(&finding["effect"]), text(&finding["parameter"]));
        let mut exact = case.truth.effects.iter().filter(|hidden| same((hidden.effect, &hidden.parameter), own));
        // Two hidden effects of one name have one size together.
        let exact = exact.next().filter(|hidden| exact.next().is_none() && hidden.effect != "setup");
        let exact = exact.and_then(|hidden| size_over(hidden, finding));
        let off = |size: f64| (number(&finding["value"]).abs() - size.abs()).abs();
        Told {
            probability: number(&finding["probability"]),
            is_true: case.truth.effects.iter().any(|hidden| is_of(finding, hidden)),
            is_inside: exact.map(|size| off(size) <= number(&finding["u95"])),
            words: format!("{} {} ± {}", words(finding), finding["value"], finding["u95"]),
        }
    });
    told.collect()
}

/// Diagnoses a number of mixes; the table of the bands and what must hold.
fn table(cases: u64) -> (String, [(usize, usize); 2], usize) {
    let open = Mutex::new((0..cases).rev().collect::<Vec<u64>>());
    let done: Mutex<Vec<(u64, Case, Vec<Told>)>> = Mutex::default();
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(number) = { open.lock().unwrap().pop() } {
                    if let Some(case) = mix(number) {
                        let told = told(&case);
                        done.lock().unwrap().push((number, case, told));
                    }
                }
            });
        }
    });
    let mut done = done.into_inner().unwrap();
    done.sort_by_key(|(number, ..)| *number);
    let all = || done.iter().flat_map(|(_, case, told)| told.iter().map(move |one| (case, one)));
    let mut out = String::new();
    let mut least = 0.0;
    for most in BANDS {
        let of_band: Vec<&Told> =
            all().map(|(_, one)| one).filter(|one| (least..most).contains(&one.probability)).collect();
        let right = of_band.iter().filter(|one| one.is_true).count();
        writeln!(out, "from {:5.1} %: {right:3} of {:3} true", 100.0 * least, of_band.len()).unwrap();
        least = most;
    }
    let certain = || all().filter(|(_, one)| one.probability >= 0.95);
    for (case, one) in certain().filter(|(_, one)| !one.is_true) {
        writeln!(out, "false with {:.1} %: {} in {}", 100.0 * one.probability, one.words, case.words()).unwrap();
    }
    for (case, one) in certain().filter(|(_, one)| one.is_inside == Some(false)) {
        writeln!(out, "outside its interval: {} in {}", one.words, case.words()).unwrap();
    }
    let right = (certain().filter(|(_, one)| one.is_true).count(), certain().count());
    let sizes: Vec<bool> = certain().filter_map(|(_, one)| one.is_inside).collect();
    let inside = (sizes.iter().filter(|is| **is).count(), sizes.len());
    writeln!(out, "{} of {} sizes within their interval, {} cases", inside.0, inside.1, done.len()).unwrap();
    let in_nulls = all().filter(|(case, one)| case.truth.effects.is_empty() && one.probability >= 0.95).count();
    writeln!(out, "{in_nulls} causes stated with 95 % where nothing is hidden").unwrap();
    (out, [right, inside], in_nulls)
}

/// True if a part of all is compatible with a share: not below it by more than twice the standard deviation of a count.
fn has_share(share: f64, (part, all): (usize, usize)) -> bool {
    let wanted = share * all as f64;
    part as f64 >= wanted - 2.0 * (wanted * (1.0 - share)).sqrt()
}

#[test]
fn a_slow_drift_while_balls_are_probed_is_no_cause_over_time() {
    // The noise of the plant wanders along the directions of F over 60 readings. These mixes were named as functions of time, or had EBA for EB0C.
    for number in [22, 62, 78, 134] {
        let case = mix(number).unwrap();
        for one in told(&case).iter().filter(|one| one.probability >= 0.95) {
            assert!(one.is_true, "{} in {}", one.words, case.words());
        }
    }
}

#[test]
fn causes_stated_with_95_percent_are_there() {
    // `NCFIX_MIXES=400` draws the whole table, with an optimized program within a quarter of an hour.
    let cases = std::env::var("NCFIX_MIXES").map_or(24, |count| count.parse().unwrap());
    let (out, [right, inside], in_nulls) = table(cases);
    assert!(right.1 as u64 >= cases / 2, "hardly anything is stated:\n{out}");
    // An effect that is too small to be found biases those that are: of 199 sizes in 160 mixes, 85 % were within their interval.
    assert!(has_share(0.95, right) && has_share(0.85, inside), "{out}");
    assert_eq!(in_nulls, 0, "{out}");
}

#[test]
fn sizes_state_the_range_that_they_belong_to() {
    // Reversal values that grow along an axis (row 21) and interactions of two axes (row 48), alone and without noise from other effects.
    for (bench, row, seed) in [
        (Bench::Ballbar, 21, 1),
        (Bench::Ballbar, 21, 2),
        (Bench::Laser, 21, 3),
        (Bench::Plate, 48, 4),
        (Bench::Plate, 48, 5),
    ] {
        let case = Recipe { hide: vec![row], ..Recipe::new(bench, 4.0, seed) }.cook().unwrap();
        let report = diagnosed(&case, false);
        let hidden = &case.truth.effects[0];
        let findings = report["findings"].as_array().unwrap();
        let own = findings
            .iter()
            .find(|one| same((hidden.effect, &hidden.parameter), (text(&one["effect"]), text(&one["parameter"]))));
        let own = own.unwrap_or_else(|| panic!("{bench:?} {row} {seed}: {findings:?}"));
        assert!(!own["over"].as_array().unwrap().is_empty(), "{own}");
        let size = size_over(hidden, own).unwrap();
        let [value, u95] = ["value", "u95"].map(|key| own[key].as_f64().unwrap());
        assert!((value.abs() - size.abs()).abs() <= u95, "{size}: {own}");
    }
}
