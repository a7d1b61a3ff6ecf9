//! The machine file that a diagnosis extends: every kind of entry says data that were held out as well as the truth does, stands there once
//! however often a diagnosis is repeated, and what has no entry is said to have none.

use ncfix_machine::machine::edit::Edit;
use ncfix_metrology::diagnose::extend::{Anchor, Change};
use serde_json::Value;

use crate::cli_calibrate::bare;
use crate::diagnose::{case, diagnosed, findings, name, number, report, run, shop};
use crate::plant::{Bench, Case, Recipe, Unknown};
use crate::support::Shop;

const PART: &str = "G0 X100 Y100 Z100\nG1 X300 Y250 F1000\nM30\n";

/// Diagnoses with `-o` and the data held out.
fn extend(shop: &Shop, [data, held_out]: [&[String]; 2], machine: &str, out: &str) -> Value {
    let mut more = vec!["-o", out, "--holdout"];
    more.extend(held_out.iter().map(String::as_str));
    diagnosed(shop, data, machine, &more)
}

/// A case whose machine was extended.
struct Mended {
    shop: Shop,
    files: [Vec<String>; 2],
    /// The extended file.
    text: String,
    /// What it leaves of the data held out, µm.
    left: f64,
}

/// Extends the machine of a case, and demands that nothing is left then.
fn mended(case: &Case, most_left: f64) -> Mended {
    let (shop, data, held_out) = shop(case);
    let found = extend(&shop, [&data, &held_out], "machine.toml", "extended.toml");
    for one in findings(&found) {
        assert_eq!(one["extends"], true, "{one:#}");
        assert!(one["extends_why"].is_null(), "{one:#}");
    }
    let text = shop.text("extended.toml");
    for line in case.machine_toml.lines().filter(|line| line.starts_with(['[', '#'])) {
        assert!(text.contains(line), "{line}: {text}");
    }
    // What the file says of data held out, read again.
    let again = diagnosed(&shop, &held_out, "extended.toml", &[]);
    assert_eq!(findings(&again).len(), 0, "{text}\n{again:#}");
    let (before, after) = (number(&found["before"], "holdout_rms_um"), number(&again["before"], "rms_um"));
    assert!(after < most_left * case.truth.noise_um, "{before} {after}, noise {}\n{text}", case.truth.noise_um);
    let best = case.truth.gain.min(1.0 - case.truth.noise_um / before);
    assert!(1.0 - after / before > 0.8 * best, "{before} {after} of {best}\n{text}");
    Mended { shop, files: [data, held_out], text, left: after }
}

/// What a run of a program says with the extended machine.
fn program(shop: Shop, more: &[&str]) -> String {
    let shop = shop.file("part.mpf", PART);
    let run = shop.run(["part.mpf", "-o", "out.mpf", "--machine", "extended.toml"].iter().chain(more));
    assert_eq!(run.code, 0, "{run:?}");
    run.stderr
}

/// With all values of the entries that were added halved, a second diagnosis adds the other half to them and no entry.
fn twice(mended: Mended, keys: &[&str], list: &str) -> Shop {
    let Mended { shop, files: [data, held_out], text, left } = mended;
    let mut halved = String::new();
    let mut is_new = false;
    for line in text.lines() {
        is_new =
            if line.starts_with("[[") || line.is_empty() { false } else { is_new || line.starts_with("# diagnosed:") };
        // The section behind its comment.
        is_new |=
            line.starts_with("[[") && halved.trim_end().lines().last().is_some_and(|last| last.starts_with("#  "));
        let mut line = line.to_owned();
        for key in keys.iter().filter(|_| is_new) {
            if let Some((head, rest)) = line.clone().split_once(&format!("{key} = ")) {
                let end = rest.find([',', ' ', '}']).filter(|_| !rest.starts_with('[')).unwrap_or(rest.len());
                let (number, tail) = rest.split_at(end);
                let half = |number: &str| format!("{:e}", 0.5 * number.trim().parse::<f64>().unwrap());
                let number = match number.strip_prefix('[') {
                    Some(list) => {
                        let all = list.trim_end_matches(']').split(',').map(half);
                        format!("[{}]", all.collect::<Vec<_>>().join(", "))
                    }
                    None => half(number),
                };
                line = format!("{head}{key} = {number}{tail}");
            }
        }
        halved += &(line + "\n");
    }
    assert_ne!(halved, text);
    let count = |text: &str| text.matches(&format!("[[{list}]]")).count();
    let shop = shop.file("half.toml", &halved);
    let found = extend(&shop, [&data, &held_out], "half.toml", "again.toml");
    assert!(findings(&found).iter().all(|one| one["extends"] == true), "{found:#}");
    let again = shop.text("again.toml");
    assert_eq!(count(&text), count(&again), "{halved}\n{again}");
    let then = number(&diagnosed(&shop, &held_out, "again.toml", &[])["before"], "rms_um");
    assert!((left / then - 1.0).abs() < 0.02, "{left} {then}\n{again}");
    shop
}

#[test]
fn a_wave_is_an_entry_that_a_second_diagnosis_changes() {
    let mended = mended(&case(Bench::Ballbar, &[3], 6.0, 2), 1.3);
    assert!(mended.text.contains("kind = \"periodic\"") && mended.text.contains("period_mm = "), "{}", mended.text);
    twice(mended, &["amplitude_um"], "motion");
}

#[test]
#[ignore = "a minute or two: five axes"]
fn errors_of_rotary_axes_are_entries() {
    let text = |row| {
        let Mended { shop, text, .. } = mended(&case(Bench::FiveAxis, &[row], 6.0, 11), 1.3);
        program(shop, &[]);
        text
    };
    assert!(text(4).contains("period_deg = "));
    // A constant angle of C is none: it turns all balls, and these lie where they lie.
    let of_motion = text(12);
    assert!(of_motion.contains("# diagnosed: motion ECC"), "{of_motion}");
    assert!(text(10).contains("EB0C = "));
}

#[test]
fn drift_goes_with_a_sensor_and_its_lag_and_needs_live_readings() {
    let mended = mended(&case(Bench::Drift, &[38], 6.0, 3), 1.4);
    let text = &mended.text;
    assert!(text.contains("[[drift]]") && text.contains("lag_s = "), "{text}");
    assert!(text.contains("nothing is corrected without a reading of T_"), "{text}");
    let shop = twice(mended, &["um_per_K"], "drift");
    assert!(program(shop, &[]).contains("W0501"), "without temperatures");
}

#[test]
fn growth_of_a_scale_is_one_entry() {
    let mended = mended(&case(Bench::HotCold, &[40], 6.0, 11), 1.3);
    assert!(mended.text.contains("[[expansion]]"), "{}", mended.text);
    twice(mended, &["um_per_m_K"], "expansion");
}

#[test]
fn what_a_weight_does_is_an_entry_that_needs_the_weight() {
    let Mended { shop, text, .. } = mended(&case(Bench::Load, &[45], 6.0, 2), 1.3);
    assert!(text.contains("[[load]]") && text.contains("reference_N = 1000"), "{text}");
    assert!(text.contains("nothing is corrected without the weight"), "{text}");
    assert!(program(shop, &[]).contains("W0502"), "without a weight");
}

#[test]
fn tilt_of_the_table_under_a_weight_is_a_location() {
    let mended = mended(&case(Bench::Load, &[46], 6.0, 2), 1.3);
    assert!(mended.text.contains("at_mm = 100"), "{}", mended.text);
    twice(mended, &["value_urad"], "load");
}

#[test]
fn an_error_over_two_axes_is_a_grid() {
    let Mended { shop, text, .. } = mended(&case(Bench::Plate, &[48], 6.0, 2), 1.3);
    assert!(text.contains("kind = \"grid\""), "{text}");
    program(shop, &[]);
}

#[test]
fn a_shape_without_a_name_is_a_table() {
    let (bench, hide, faults) = (Bench::Laser, Vec::new(), Vec::new());
    let (unknown, size_in_noise, fineness, outliers, seed) = (Some(Unknown::DeadZone), 6.0, 0.12, Some(0.0), 11);
    let recipe = Recipe { bench, hide, unknown, faults, size_in_noise, fineness, outliers, seed };
    let Mended { shop, text, .. } = mended(&recipe.cook().unwrap(), 1.4);
    assert!(text.contains("# diagnosed: unknown") && text.contains("positions_mm"), "{text}");
    program(shop, &[]);
}

#[test]
fn what_has_no_entry_says_why() {
    let (shop, data, held_out) = shop(&case(Bench::HotCold, &[40, 58], 6.0, 2));
    let text = shop.text("machine.toml") + "# not corrected: something of an earlier day: no reason\n";
    let shop = shop.file("old.toml", &text);
    let found = extend(&shop, [&data, &held_out], "old.toml", "extended.toml");
    let all = findings(&found);
    let of = |effect: &str| all.iter().find(|one| one["effect"] == effect).unwrap_or_else(|| panic!("{found:#}"));
    assert_eq!(of("thermal-expansion")["extends"], true, "{found:#}");
    let setup = of("setup");
    assert_eq!(setup["extends"], false);
    let why = setup["extends_why"].as_str().unwrap();
    let text = shop.text("extended.toml");
    assert!(text.contains(&format!("# not corrected: {}", name(setup))) && text.contains(why), "{text}");
    assert!(!text.contains("earlier day"), "{text}");
}

#[test]
fn without_anything_to_write_every_finding_says_why() {
    let (shop, data, held_out) = shop(&case(Bench::HotCold, &[42], 6.0, 2));
    let mut more = vec!["-o", "extended.toml", "--holdout"];
    more.extend(held_out.iter().map(String::as_str));
    let run = run(&shop, &data, "machine.toml", &more);
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let all = findings(&found);
    assert!(!all.is_empty() && run.code != 0 && !shop.path("extended.toml").exists(), "{run:?}");
    for one in &all {
        assert!(one["extends"] == false && one["extends_why"].as_str().is_some_and(|why| why.len() > 20), "{one}");
        assert_eq!(one["correctable"], "no", "{one}");
    }
    // The same is said where no file is asked for.
    let found = report(&crate::diagnose::run(&shop, &data, "machine.toml", &more[2..]));
    let said = |one: &Value| (name(one), one["correctable"].clone(), one["extends_why"].clone());
    assert_eq!(findings(&found).iter().map(said).collect::<Vec<_>>(), all.iter().map(said).collect::<Vec<_>>());
}

/// Makes a change in a text.
fn made(text: &str, change: &Change) -> Result<(String, Anchor), String> {
    let mut edit = Edit::parse(text).unwrap();
    change.make(&mut edit).map(|anchor| (edit.text(), anchor))
}

#[test]
fn waves_of_one_period_add_up_as_phasors() {
    let wave = |period, parts| Change::Wave {
        name: "EXX".parse().unwrap(),
        period,
        parts,
        sigma: 0.2e-3,
        travel: [0.0, 700.0],
    };
    // 3 µm sin + 4 µm cos: 5 µm at 53.13°.
    let (once, anchor) = made("# mine\n", &wave(10.0, [3e-3, 4e-3])).unwrap();
    assert_eq!(anchor, Anchor::Entry("motion", 0));
    assert!(once.contains("amplitude_um = 5.0") && once.contains("phase_deg = 53.130102"), "{once}");
    let (twice, _) = made(&once, &wave(10.0, [3e-3, -4e-3])).unwrap();
    assert!(twice.contains("amplitude_um = 6.0") && twice.matches("[[motion]]").count() == 1, "{twice}");
    // The uncertainty of sine and cosine, 0.2 µm, has the name of the wave.
    assert!(once.contains("\"EXX~10\" = 0.2") && twice.matches("EXX~10").count() == 1, "{twice}");
    let (other, anchor) = made(&once, &wave(5.0, [1e-3, 0.0])).unwrap();
    assert!(other.contains("\"EXX~5\" = 0.2"), "{other}");
    assert_eq!((other.matches("[[motion]]").count(), anchor), (2, Anchor::Entry("motion", 1)));
    // Nearly the same period: one wave, in step in the middle. At X 350 the second has 35 turns less 0.63°.
    let (near, _) = made(&once, &wave(10.0005, [5e-3, 0.0])).unwrap();
    assert!(!near.contains("EXX~10.0005"), "{near}");
    let turned = (360.0_f64 * (350.0 / 10.0005 - 35.0)).to_radians();
    let (sine, cosine) = (3.0 + 5.0 * turned.cos(), 4.0 + 5.0 * turned.sin());
    let amplitude: f64 = near.lines().find_map(|line| line.strip_prefix("amplitude_um = ")).unwrap().parse().unwrap();
    assert!((amplitude - sine.hypot(cosine)).abs() < 1e-5 && near.contains("period_mm = 10.0\n"), "{near}");
}

#[test]
fn a_drift_over_an_axis_gets_a_sensor_at_every_place() {
    let text = "[[drift]]\ndirection = \"Y\"\nover = \"Z\"\nat_mm = 0\nsensors = [{ name = \"a\", um_per_K = 1 }]\n\
                [[drift]]\ndirection = \"Y\"\nover = \"Z\"\nat_mm = 400\nsensors = [{ name = \"b\", um_per_K = 2.5, lag_s = 60 }]\n";
    let drift = |sensor: &str, lag_s| Change::Drift { direction: "Y", sensor: sensor.into(), lag_s, um_per_k: 0.5 };
    let (new, _) = made(text, &drift("b", 60.0)).unwrap();
    assert!(
        new.contains("um_per_K = 3.0, lag_s = 60") && new.contains("{ name = \"b\", um_per_K = 0.5, lag_s = 60.0 }")
    );
    assert_eq!(new.matches("[[drift]]").count(), 2, "{new}");
    // Another lag is another term.
    let (new, _) = made(text, &drift("b", 0.0)).unwrap();
    assert_eq!(new.matches("name = \"b\"").count(), 3, "{new}");
}

#[test]
fn growth_moves_the_place_where_a_scale_is_held() {
    let axis = ncfix_base::geometry::Axis::from_letter(b'X').unwrap();
    let growth = |sensor: &str, um_per_m_k, um_per_k| Change::Growth {
        axis,
        sensor: sensor.into(),
        lag_s: 0.0,
        um_per_m_k,
        um_per_k,
    };
    let text = "[[expansion]]\naxis = \"X\"\nfixed_mm = 100\nworkpiece = { sensors = [\"w\"], um_per_m_K = 11.5 }\n\
                scale = { sensors = [\"s\"], um_per_m_K = 6.0 }\n";
    // 6 · (x − 100) + 2 · (x − 500) = 8 · (x − 200); µm/(m K) · mm/1000 is µm/K.
    let (new, _) = made(text, &growth("s", 2.0, 1.0)).unwrap();
    assert!(new.contains("um_per_m_K = 8.0") && new.contains("fixed_mm = 200.0") && new.contains("fixed_mm = 100\n"));
    assert!(made(text, &growth("other", 2.0, 1.0)).unwrap_err().contains("scale of X"));
    let (new, _) = made("", &growth("s", 2.0, 1.0)).unwrap();
    assert!(new.contains("fixed_mm = 500.0") && new.contains("scale = { sensors = [\"s\"], um_per_m_K = 2.0"), "{new}");
}

/// A wave of 10 mm between points 25 mm apart, whose steps differ and so tell it: no long terms that cancel each other are taken for it, and what is
/// written does no more than there was.
#[test]
fn a_wave_between_points_is_written_and_nothing_that_others_cancel() {
    let mut rows = "run,component,X,Y,Z,X_dir,value_um\n".to_owned();
    // Steps that differ by up to 30 %; noise of half a micrometre, from a congruence.
    let mut state = 12_345_u64;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31) * 2.0 - 1.0
    };
    let points: Vec<f64> = (0..21).map(|k| 100.0 + 25.0 * f64::from(k) + 7.5 * draw()).collect();
    for run in 1..=5 {
        for (sense, order) in [(1, points.clone()), (-1, points.iter().rev().copied().collect())] {
            for x in order {
                let um = 15.0 * (std::f64::consts::TAU * x / 10.0).sin() + 0.8 * draw();
                rows += &format!("{run}{sense:+},EXX,{x:.4},250,200,{sense},{um:.4}\n");
            }
        }
    }
    let shop = Shop::new()
        .file("machine.toml", bare("demo"))
        .file("line.csv", rows)
        .file("line.toml", "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.6\n");
    let run = run(&shop, &["line.csv".to_owned()], "machine.toml", &["-o", "extended.toml"]);
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let left = number(&found["before"], "rms_um");
    for one in findings(&found).iter().filter(|one| one["extends"] == true) {
        assert!(number(one, "rms_um") < 1.5 * left, "{one:#}");
        assert!(number(one, "u95") < number(one, "value").abs(), "{one:#}");
    }
    let all = findings(&found);
    assert!(all.len() == 1 && all[0]["effect"] == "periodic" && all[0]["extends"] == true, "{found:#}");
    assert!((number(&all[0], "period") - 10.0).abs() < 0.03, "{found:#}");
    assert!((number(&all[0], "value") - 15.0).abs() < 1.5 * number(&all[0], "u95"), "{found:#}");
}

/// Five runs with slopes of 30 to 50 µm/m: the mean is uncertain by the scatter of the runs, not by the noise of the readings. The file has the interval
/// that is printed.
#[test]
fn the_file_has_the_uncertainty_that_is_printed() {
    let mut random = crate::plant::random::Random::new(5, "slopes of runs");
    let mut rows = "run,X,Y,Z,X_dir,dx_um\n".to_owned();
    let slopes = [45e-3, 30e-3, 50e-3, 35e-3, 40e-3];
    for (run, slope) in slopes.into_iter().enumerate() {
        for (sense, k) in (0..9).map(|k| (1, k)).chain((0..9).rev().map(|k| (-1, k))) {
            let x = 50.0 * f64::from(k);
            rows += &format!("{},{x},0,0,{sense},{:.4}\n", run + 1, slope * x + 0.3 * random.normal());
        }
    }
    let shop = Shop::new()
        .file("machine.toml", bare("demo"))
        .file("line.csv", rows)
        .file("line.toml", "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\nsigma_um = 0.3\n");
    let found = diagnosed(&shop, &["line.csv".to_owned()], "machine.toml", &["-o", "extended.toml"]);
    let all = findings(&found);
    let one = all.iter().find(|one| one["unit"] == "um/m").unwrap_or_else(|| panic!("{found:#}"));
    let u95 = number(one, "u95");
    // Student's factor of four degrees of freedom is 2.776: 2.776 · 7.906 µm/m/√5 = 9.8 µm/m. Noise alone would give ±0.5 µm/m.
    assert!((0.7 * 9.8..1.4 * 9.8).contains(&u95), "{one:#}");
    let text = shop.text("extended.toml");
    let line = text.lines().find_map(|line| line.strip_prefix("EXX1 = [")).unwrap_or_else(|| panic!("{text}"));
    let parts = line.trim_end_matches(']').split(',').map(|part| part.trim().parse::<f64>().unwrap());
    let sigma = parts.map(|part| part * part).sum::<f64>().sqrt();
    assert!((1.96e6 * sigma / u95 - 1.0).abs() < 0.02, "{sigma} {u95}: {text}");
    assert!(!text.contains("2σ") && text.contains("(95 %): EXX1 "), "{text}");
}
