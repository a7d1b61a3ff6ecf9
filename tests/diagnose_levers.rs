//! A displacement and an angle that act alike on the readings: neither is certain, and a stated hypothesis decides nothing for the other ones.

use serde_json::Value;

use crate::plant::random::Random;
use crate::support::Shop;

/// The table moves along Y, the cross beam carries X and Z. No errors are known.
const MACHINE: &str = "[machine]\nname = \"beam\"\ntopology = \"wYFXZSt\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 400]\n";
const DESCRIPTION: &str =
    "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.3\nreference = \"square\"\n";
const STATED: &str = "EZX ~ X^2*Y";
const COMMAND: &str = "ncfix calibrate DATA --machine M.toml --model \"EBY1,EZX ~ X^2*Y\" -o NEW.toml";

/// The fraction of multiples of the golden ratio, from −0.5 to 0.5: evenly spread, and in no order (Knuth, The Art of Computer Programming 3, 6.4).
fn scatter() -> impl FnMut() -> f64 {
    let mut count = 0.0;
    move || {
        count += 1.0;
        (count * 0.618_033_988_749_895_f64).fract() - 0.5
    }
}

/// Straightness of X at four positions of Y, there and back, twice. The beam sags by 120 µm/m³ · X² · Y: 29.4 µm at the far corner.
fn straightness() -> String {
    let mut text = "X,Y,Z,X_dir,setup,run,component,value_um\n".to_owned();
    let mut scatter_um = scatter();
    for (y, offset_um) in [(0.0, -1.3), (150.0, -3.0), (350.0, 5.7), (500.0, 7.7)] {
        for run in 1..=2 {
            for sense in [1.0, -1.0] {
                for step in 0..=14 {
                    let x = 50.0 * f64::from(if sense > 0.0 { step } else { 14 - step });
                    let value_um = 120e-9 * x * x * y + offset_um + scatter_um();
                    text += &format!("{x},{y},100,{sense},y{y},{run},EZX,{value_um:.3}\n");
                }
            }
        }
    }
    text
}

fn shop() -> Shop {
    Shop::new().file("beam.toml", MACHINE).file("lines.csv", straightness()).file("lines.toml", DESCRIPTION)
}

fn diagnose(shop: &Shop, hypotheses: &[&'static str]) -> Value {
    let mut all = vec!["diagnose", "lines.csv", "--machine", "beam.toml", "--json"];
    hypotheses.iter().for_each(|one| all.extend(["--hypothesis", one]));
    shop.run(all).exits(0).json()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} of {value}"))
}

fn text<'v>(value: &'v Value, key: &str) -> &'v str {
    value[key].as_str().unwrap_or_else(|| panic!("{key} of {value}"))
}

/// A roll of the table with X·Y moves the tool along Z by its arm X, so it has the readings of the sag. It also moves the tool along X by the arm Z, which no
/// reading shows. The odds of both are equal.
#[test]
fn a_roll_and_a_sag_with_the_same_readings_share_the_probability() {
    let shop = shop();
    let report = diagnose(&shop, &[]);
    let of = |term: &str| -> f64 {
        let all = report["explanations"].as_array().unwrap().iter();
        let has = |one: &&Value| one["terms"].as_array().unwrap().contains(&Value::from(term));
        all.filter(has).map(|one| number(one, "probability")).sum()
    };
    let [roll, sag] = ["cross EBY", "cross EZX"].map(of);
    assert!(roll > 0.1 && sag > 0.1, "{roll} {sag}: {}", report["explanations"]);
    for one in report["findings"].as_array().unwrap() {
        assert!(one["certain"] == false && one["correctable"] == "no", "{one}");
    }
    // Nothing is certain, so nothing is written.
    let words = "diagnose lines.csv --machine beam.toml -o extended.toml";
    shop.run(words.split_whitespace()).exits(4).says("E0606");
    assert!(!shop.path("extended.toml").exists());
}

/// The same lines, and the roll itself as a level reads it: 120 µrad/m² · X · Y.
#[test]
fn readings_of_the_angle_decide() {
    let mut table = "X,Y,Z,Y_dir,setup,run,component,value_urad\n".to_owned();
    let mut scatter_urad = scatter();
    for x in [0.0, 350.0, 700.0] {
        for run in 1..=2 {
            for y in [0.0, 100.0, 200.0, 300.0, 400.0, 500.0] {
                let value_urad = 120e-6 * x * y + scatter_urad();
                table += &format!("{x},{y},100,1,x{x},{run},EBY,{value_urad:.3}\n");
            }
        }
    }
    let shop = shop().file("level.csv", table).file("level.toml", DESCRIPTION.replace("sigma_um", "sigma_urad"));
    let words = "diagnose lines.csv level.csv --machine beam.toml --json";
    let report = shop.run(words.split_whitespace()).exits(0).json();
    let is_roll = |one: &&Value| one["effect"] == "cross" && one["parameter"] == "EBY";
    let roll = report["findings"].as_array().unwrap().iter().find(is_roll).unwrap();
    assert!(roll["certain"] == true && roll["correctable"] == "program", "{roll}");
}

#[test]
fn each_hypothesis_is_tested_as_if_it_were_the_only_one() {
    let shop = shop();
    let alone = diagnose(&shop, &["cross EZX"]);
    let together = diagnose(&shop, &[STATED, "cross EZX"]);
    let [one, other] = [&alone["hypotheses"][0], &together["hypotheses"][1]];
    for key in ["answer", "name", "log_evidence", "log_evidence_beside", "amounts", "variants", "stands_for", "rivals"]
    {
        assert_eq!(one[key], other[key], "{key}");
    }
    // The sag is a cross EZX that is curved along X.
    assert!(one["answer"] == "supported" && text(one, "variant").contains("X and Y"), "{one}");
}

#[test]
fn a_supported_hypothesis_leads_to_the_calibration() {
    let shop = shop();
    let report = diagnose(&shop, &[STATED]);
    let one = &report["hypotheses"][0];
    assert!(one["answer"] == "supported" && one["next"] == COMMAND, "{one}");
    let amount = &one["amounts"][0];
    assert!((number(amount, "value") - 120.0).abs() < 1.5 * number(amount, "u95"), "{amount}");
    // The findings in its place are less probable, and act elsewhere in another way.
    for name in one["stands_for"].as_array().unwrap() {
        let is_one = |own: &&Value| *name == format!("{} {}", text(own, "effect"), text(own, "parameter"));
        let finding = report["findings"].as_array().unwrap().iter().find(is_one).unwrap();
        assert!(finding["certain"] == false && finding["extends_why"].is_string(), "{finding}");
        assert!(finding["rivals"].as_array().unwrap().iter().any(|rival| rival["cause"] == STATED), "{finding}");
    }
    let words = ["diagnose", "lines.csv", "--machine", "beam.toml", "--hypothesis", STATED];
    let run = shop.run(words).exits(0);
    assert!(run.stdout.contains(&format!("   next: {COMMAND}\n")), "{}", run.stdout);
    assert!(run.stdout.contains(&format!("Next: fit and write the hypothesis with {COMMAND}")), "{}", run.stdout);
    // An efficiency of 0 has no sign.
    assert!(!run.stdout.contains("-0 %"), "{}", run.stdout);
}

/// A term that names what a finding names contests nothing: both correct the same.
#[test]
fn the_same_error_in_other_words_leaves_the_finding_certain() {
    let mut table = "X,Y,Z,X_dir,run,dx_um,dy_um,dz_um\n".to_owned();
    let mut scatter_um = scatter();
    for run in 1..=3 {
        for sense in [1.0, -1.0] {
            for step in 0..=14 {
                let x = 50.0 * f64::from(if sense > 0.0 { step } else { 14 - step });
                let [dx, dy, dz] = [3.0 * sense + scatter_um(), scatter_um(), scatter_um()];
                table += &format!("{x},100,100,{sense},{run},{dx:.3},{dy:.3},{dz:.3}\n");
            }
        }
    }
    let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\nsigma_um = 0.3\n";
    let shop = Shop::new().file("beam.toml", MACHINE).file("lines.csv", table).file("lines.toml", description);
    let [plain, stated] = [diagnose(&shop, &[]), diagnose(&shop, &["EXX ~ dir(X)"])];
    assert_eq!(plain["findings"], stated["findings"]);
    let is_play = |one: &&Value| one["effect"] == "backlash";
    let play = stated["findings"].as_array().unwrap().iter().find(is_play).unwrap();
    assert_eq!(play["certain"], true, "{play}");
    assert_eq!(stated["hypotheses"][0]["answer"], "supported", "{}", stated["hypotheses"][0]);
}

/// Steps of 50 mm: 10 and 2 periods, or half a period.
#[test]
fn the_reason_for_a_wave_states_how_far_the_positions_are_apart() {
    let report = diagnose(&shop(), &["EZX ~ sin(X/5mm)", "EZX ~ sin(X/25mm)", "EZX ~ sin(X/100mm)"]);
    let why = |number: usize| text(&report["hypotheses"][number], "why_not_shown").to_owned();
    for number in [0, 1] {
        assert!(why(number).contains("whole periods") && !why(number).contains("half"), "{}", why(number));
    }
    assert!(why(2).contains("half a period apart"), "{}", why(2));
}

#[test]
fn names_in_small_letters_are_corrected() {
    let shop = shop();
    let run = shop.run(["diagnose", "lines.csv", "--machine", "beam.toml", "--hypothesis", "ezx ~ x^2*Foo"]).exits(4);
    run.says("write EZX").says("write X").says("the data have no columns of drivers");
}

/// The residual of the fit is the scatter, 1/√12 µm, so the variant is the right one. Its name says which.
#[test]
fn a_calibration_names_the_best_variant_of_a_cause() {
    let shop = shop();
    let words =
        ["calibrate", "lines.csv", "--machine", "beam.toml", "--model", "cross EZX", "-o", "out.toml", "--json"];
    let report = shop.run(words).exits(0).json();
    assert_eq!(report["terms"][0]["term"], "cross EZX: curved over X and Y", "{}", report["terms"]);
    let left = number(&report["data"][0], "left_rms");
    assert!((left - 1.0 / 12.0_f64.sqrt()).abs() < 0.03, "{left}");
    assert!(shop.text("out.toml").contains("cross EZX: curved over X and Y"), "{}", shop.text("out.toml"));
}

/// The largest value of the grid is the amount times (0.7 m)² · 0.5 m, and so is its uncertainty.
#[test]
fn the_uncertainty_of_a_stated_term_is_in_the_file() {
    let shop = shop();
    let words = ["calibrate", "lines.csv", "--machine", "beam.toml", "--model", STATED, "-o", "out.toml", "--json"];
    let report = shop.run(words).exits(0).json();
    let expected = number(&report["terms"][0], "sigma") * 0.7 * 0.7 * 0.5;
    let file: toml::Table = shop.text("out.toml").parse().unwrap();
    let written = file["uncertainty"]["EZX"].as_float().unwrap();
    assert!(expected > 0.0 && (written - expected).abs() < 0.02 * expected + 1e-4, "{written} {expected}");
}

/// A sag of the table along Y, as a component and as a displacement of the tool: one error, and one answer.
#[test]
fn a_component_and_a_displacement_of_the_tool_have_one_remedy() {
    let mut table = "X,Y,Z,setup,run,dx_um,dy_um,dz_um\n".to_owned();
    let mut random = Random::new(5, "table");
    let mut noise_um = || 0.3 * random.normal();
    for (x, setup) in [(100.0, "a"), (600.0, "b")] {
        for run in 1..=3 {
            for step in 0..=20 {
                let y = 50.0 * f64::from(if step <= 10 { step } else { 20 - step });
                let [dx, dy, dz] = [noise_um(), noise_um(), 36e-6 * y * y + noise_um()];
                table += &format!("{x},{y},200,{setup},{run},{dx:.3},{dy:.3},{dz:.3}\n");
            }
        }
    }
    let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\nsigma_um = 0.3\n";
    let shop = Shop::new().file("beam.toml", MACHINE).file("lines.csv", table).file("lines.toml", description);
    let report = diagnose(&shop, &["EZY ~ Y^2", "Z ~ Y^2"]);
    for one in report["hypotheses"].as_array().unwrap() {
        assert!(one["answer"] == "supported" && one["correctable"] == "program", "{one}");
        // 36 µm/m²; an error of the table moves the tool the other way.
        let amount = &one["amounts"][0];
        assert!((number(amount, "value").abs() - 36.0).abs() < 1.5 * number(amount, "u95"), "{amount}");
    }
}
