//! `ncfix diagnose --hypothesis`: the answer to a stated term, from readings of a machine whose error is written here, and text that is wrong.

use serde_json::Value;

use crate::plant::random::Random;
use crate::support::Shop;

/// Three axes that move the tool, without errors.
const MACHINE: &str = "[machine]\nname = \"bench\"\ntopology = \"wFXYZSt\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 400]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 300]\n";

/// Readings of a grid over X and Y, three times, with an error along X of 40 µm/m² times the square of Y, and up to 0.4 µm that follow no driver.
fn readings() -> String {
    let mut text = "run,X,Y,Z,dx_um,dy_um\n".to_owned();
    // The fraction of multiples of the golden ratio: evenly spread, and in no order (Knuth, The Art of Computer Programming 3, 6.4).
    let mut count = 0.0;
    let mut scatter_um = || {
        count += 1.0;
        0.8 * ((count * 0.618_033_988_749_895_f64).fract() - 0.5)
    };
    for run in 1..=3 {
        for y in [0.0, 130.0, 250.0, 380.0, 500.0] {
            for x in [0.0, 90.0, 170.0, 260.0, 310.0, 400.0] {
                let [dx_um, dy_um] = [40e-6 * y * y + scatter_um(), scatter_um()];
                text += &format!("{run},{x},{y},0,{dx_um:.4},{dy_um:.4}\n");
            }
        }
    }
    text
}

fn shop() -> Shop {
    let description = "[measurement]\nkind = \"displacement\"\nsigma_um = 0.3\n";
    Shop::new().file("bench.toml", MACHINE).file("grid.csv", readings()).file("grid.toml", description)
}

fn arguments(hypotheses: &[&'static str]) -> Vec<&'static str> {
    let mut all = vec!["diagnose", "grid.csv", "--machine", "bench.toml"];
    hypotheses.iter().for_each(|one| all.extend(["--hypothesis", one]));
    all
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} of {value}"))
}

#[test]
fn a_hypothesis_gets_its_answer_first() {
    let shop = shop();
    let stated = arguments(&["EXX ~ Y^2", "EXX ~ X^2", "EXX ~ Z^2"]);
    let more = ["--json", "--report", "page.html"];
    let report = shop.run(stated.iter().copied().chain(more)).exits(0).json();
    let all = report["hypotheses"].as_array().unwrap();
    let answers: Vec<&str> = all.iter().map(|one| one["answer"].as_str().unwrap()).collect();
    assert!(answers[0] == "supported" && answers[1] != "supported" && answers[2] == "not-shown", "{answers:?}");
    let amount = &all[0]["amounts"][0];
    assert_eq!(amount["unit"], "um/m^2");
    assert!((number(amount, "value") - 40.0).abs() < number(amount, "u95") && number(amount, "u95") < 2.0, "{amount}");
    assert!(number(&all[0], "log_evidence_beside") > 20.0 && number(&all[0], "gain_unseen") > 0.5, "{}", all[0]);
    assert!(number(&all[1], "log_evidence_beside") < 0.0, "{}", all[1]);
    assert!(all[2]["why_not_shown"].as_str().unwrap().contains("Z stays at 0 mm"), "{}", all[2]);
    assert!(all[2]["probability"].is_null() && number(&all[0], "probability") > 0.99, "{report}");
    // Without a hypothesis the findings are the same.
    let plain = shop.run(arguments(&[]).into_iter().chain(["--json"])).exits(0).json();
    assert_eq!((&plain["findings"], &plain["hypotheses"]), (&report["findings"], &Value::Array(Vec::new())));
    let page = shop.text("page.html");
    assert!(page.contains("EXX ~ Y^2: dx over Y") && page.contains("without it"), "{page:.2000}");
    let text = shop.run(stated).exits(0).stdout;
    assert!(text.starts_with("Hypothesis EXX ~ Y^2: supported, the readings are 10^"), "{text}");
    assert!(
        text.contains(" µm/m² (95 %)") && text.contains("\nComparison with equal prior odds: EXX ~ Y^2 "),
        "{text}"
    );
}

/// The search may explain a product of two positions by others that do it only together. The hypothesis is then tested in their place. Seven by five positions,
/// in both directions, with 4 µm of lost motion.
#[test]
fn a_term_that_findings_absorb_together_gets_its_amount() {
    for seed in 1..=6 {
        let mut random = Random::new(seed, "product");
        let mut table = "run,X,Y,Z,X_dir,Y_dir,tool_z_mm,dx_um,dy_um\n".to_owned();
        for run in 1..=2 {
            for j in 0..5 {
                for k in 0..7 {
                    let sense = if run == 1 { 1.0 } else { -1.0 };
                    let at = if run == 1 { k } else { 6 - k };
                    let (x, y) = (40.0 + 50.0 * f64::from(at), 50.0 + 100.0 * f64::from(j));
                    let dx_um = 100e-6 * x * y - 2.0 * sense + 0.5 * random.normal();
                    let dy_um = 0.5 * random.normal();
                    table += &format!("{run},{x},{y},0,{sense},1,{},{dx_um:.4},{dy_um:.4}\n", -60 * run);
                }
            }
        }
        let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\nsigma_um = 0.5\n";
        let shop = Shop::new().file("bench.toml", MACHINE).file("grid.csv", table).file("grid.toml", description);
        let report = shop.run(arguments(&["EXX ~ X*Y"]).into_iter().chain(["--json"])).exits(0).json();
        let one = &report["hypotheses"][0];
        let amount = &one["amounts"][0];
        assert_eq!((&one["answer"], &amount["unit"]), (&Value::from("supported"), &Value::from("um/m^2")), "{one}");
        assert!((number(amount, "value") - 100.0).abs() < 1.5 * number(amount, "u95"), "{seed}: {amount}");
        assert!(number(amount, "u95") > 0.5, "{amount}");
    }
}

/// A machine that was calibrated without the parabola has a wrong squareness: 40 µm/m² over 0 to 500 mm is 20 µm/m on average. Its own parameter does not hide
/// the term.
#[test]
fn a_parameter_that_was_fitted_without_the_term_is_fitted_again() {
    let wrong = format!("{MACHINE}[location]\nEC0X = -20.0\n");
    let shop = shop().file("bench.toml", wrong);
    let report = shop.run(arguments(&["EXX ~ Y^2"]).into_iter().chain(["--json"])).exits(0).json();
    let one = &report["hypotheses"][0];
    let amount = &one["amounts"][0];
    assert_eq!(one["answer"], "supported", "{one}");
    assert!((number(amount, "value") - 40.0).abs() < 1.5 * number(amount, "u95"), "{amount}");
    assert!(one["beside"].as_array().unwrap().contains(&Value::from("location EC0X")), "{one}");
}

/// A parabola and a slope of one error: 66.7 µm/m² and −20 µm/m. The search explains them by a curve and a slope of its own. Beside these, nothing would be
/// left of the terms, so the amounts are those of a fit without them.
#[test]
fn the_curve_of_the_search_does_not_take_the_amount_of_a_hypothesis() {
    let mut covered = [0; 3];
    for seed in 1..=6 {
        let mut random = Random::new(seed, "parabola");
        let mut table = "run,X,Y,Z,X_dir,dx_um\n".to_owned();
        for run in 1..=5 {
            for (sense, k) in (0..9).map(|k| (1, k)).chain((0..9).rev().map(|k| (-1, k))) {
                let x = 50.0 * f64::from(k);
                let dx_um = 66.7e-6 * x * x - 20e-3 * x + 0.3 * random.normal();
                table += &format!("{run},{x},0,0,{sense},{dx_um:.4}\n");
            }
        }
        let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\nsigma_um = 0.3\n";
        let shop = Shop::new().file("bench.toml", MACHINE).file("grid.csv", table).file("grid.toml", description);
        let stated = arguments(&["EXX ~ X + X^2", "EXX ~ X^2"]);
        let report = shop.run(stated.into_iter().chain(["--json"])).exits(0).json();
        let [sum, square] = [0, 1].map(|k| &report["hypotheses"][k]);
        let amounts = [&sum["amounts"][0], &sum["amounts"][1], &square["amounts"][0]];
        for (k, (amount, truth)) in amounts.into_iter().zip([-20.0, 66.7, 66.7]).enumerate() {
            let [value, u95] = ["value", "u95"].map(|key| number(amount, key));
            assert!((value - truth).abs() < 2.5 * u95, "{seed}: {amount} instead of {truth}");
            covered[k] += usize::from((value - truth).abs() < u95);
            // 90 readings of 0.3 µm over 0 to 400 mm, in a least-squares fit of offset, slope and square: ±1.76 µm/m and ±4.24 µm/m².
            let least = if k == 0 { 1.76 } else { 4.24 };
            assert!((0.7 * least..3.0 * least).contains(&u95), "{seed}: {amount}");
        }
        assert_eq!(
            (&sum["answer"], &square["answer"]),
            (&Value::from("supported"), &Value::from("supported")),
            "{report}"
        );
        assert!(!sum["stands_for"].as_array().unwrap().is_empty(), "{sum}");
        assert_eq!(square["beside"], Value::from(vec!["motion EXX (slope)"]), "{square}");
    }
    assert!(covered.into_iter().all(|count| count >= 3), "{covered:?}");
}

#[test]
fn wrong_text_is_refused_at_its_column() {
    let shop = shop();
    let stated = arguments(&["EXX ~ T_nose_C", "", "EXC ~ Y^2 *"]);
    let run = shop.run(stated.iter().copied().chain(["--json"])).exits(4);
    assert_eq!(run.codes(), ["E0615"]);
    let report = run.json();
    let places: Vec<(u64, u64)> = report["diagnostics"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| (one["line"].as_u64().unwrap(), one["column"].as_u64().unwrap()))
        .collect();
    // The line is the number of the hypothesis.
    assert_eq!(places, [(1, 7), (2, 1), (3, 1), (3, 12)], "{report}");
    shop.run(stated)
        .exits(4)
        .says("'T_nose_C' is neither an axis nor a column of the data")
        .says("the machine has no axis C");
}

/// Two runs over a grid of 100 mm with a product of X and Y, and noise.
fn product(is_shuffled: bool) -> Shop {
    let mut random = Random::new(7, "product");
    let mut text = "run,X,Y,dx_um,dy_um\n".to_owned();
    for run in 1..=2 {
        let mut rows: Vec<String> = Vec::new();
        for (x, y) in (0..5).flat_map(|y| (0..5).map(move |x| (100.0 * f64::from(x), 100.0 * f64::from(y)))) {
            let dx_um = 1e-4 * (x - 200.0) * (y - 200.0) + 0.35 * random.normal();
            rows.push(format!("{run},{x},{y},{dx_um:.3},{:.3}\n", 0.35 * random.normal()));
        }
        if is_shuffled {
            (1..rows.len()).rev().for_each(|k| rows.swap(k, random.below(k + 1)));
        }
        text += &rows.concat();
    }
    let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\", \"rotation\"]\nsigma_um = 0.4\n[position]\nZ_mm = 100\n";
    Shop::new().file("bench.toml", MACHINE).file("grid.csv", text).file("grid.toml", description)
}

/// Every 100 mm, a wave of 200 mm is read at the same two phases: half of it is not there.
#[test]
fn a_wave_of_two_positions_cannot_be_shown() {
    let stated = arguments(&["EXX ~ sin(X/200mm)"]);
    let report = product(false).run(stated.into_iter().chain(["--json"])).exits(0).json();
    let one = &report["hypotheses"][0];
    assert_eq!(one["answer"], "not-shown", "{one}");
    assert!(one["why_not_shown"].as_str().unwrap().contains("half a period apart"), "{one}");
}

/// A line over Y has no part in a product of X and Y, in whichever order the rows are.
#[test]
fn what_another_cause_leaves_is_no_evidence() {
    for is_shuffled in [false, true] {
        let report = product(is_shuffled).run(arguments(&["EXX ~ Y"]).into_iter().chain(["--json"])).exits(0).json();
        let one = &report["hypotheses"][0];
        assert!(["refuted", "undecided"].contains(&one["answer"].as_str().unwrap()), "{one:#}");
        assert!(number(one, "log_evidence_beside") < 3.0, "{one:#}");
    }
}

/// A drift counts from the first row of a run. A temperature that changes only between the set-ups causes none there.
#[test]
fn a_temperature_that_is_constant_within_each_run_is_named() {
    let mut text = "setup,run,component,X,T_a_C,T_b_C,value_um\n".to_owned();
    let mut random = Random::new(5, "bow");
    for (setup, [a, b]) in [("A", [20.0, 20.0]), ("B", [26.0, 21.0]), ("C", [30.0, 22.0])] {
        for run in 1..=2 {
            for x in (0..=400).step_by(40) {
                let value_um = 0.8 * (a - b) + 0.2 * random.normal();
                text += &format!("{setup},{setup}{run},EYX,{x},{a},{b},{value_um:.4}\n");
            }
        }
    }
    let description = "[measurement]\nkind = \"direct\"\nsigma_um = 0.2\nfree = [\"offset\", \"slope\"]\n\
        [position]\nY_mm = 0\nZ_mm = 0\n";
    let shop = Shop::new().file("bench.toml", MACHINE).file("bow.csv", text).file("bow.toml", description);
    let stated = ["--hypothesis", "EYX ~ (T_a_C - T_b_C)", "--hypothesis", "Y ~ T_a_C", "--json"];
    let report = shop.run(["diagnose", "bow.csv", "--machine", "bench.toml"].into_iter().chain(stated)).exits(0).json();
    let why = |number: usize| report["hypotheses"][number]["why_not_shown"].as_str().unwrap().to_owned();
    assert!(why(0).starts_with("T_a_C and T_b_C are constant within each run of a set-up"), "{}", why(0));
    assert!(why(1).starts_with("T_a_C is constant within each run of a set-up"), "{}", why(1));
    assert!(!why(0).contains("stay at zero"), "{}", why(0));
}
