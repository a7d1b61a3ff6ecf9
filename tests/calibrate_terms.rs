//! `ncfix calibrate --model` with terms that a person states: amounts of errors that are written here, the file that holds them, and text that is wrong.

use serde_json::Value;

use crate::support::Shop;

/// Three axes that move the tool, without errors.
const MACHINE: &str = "[machine]\nname = \"bench\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 600]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-300, 0]\n";

/// A grid over X and Y in both directions. Along X: −15 µm/m, a reversal value of 6 µm, and 400 µm/m² times the square of Y. Along Z: 1.8 µm/K of the head.
/// Up to 0.5 µm follow no driver; `from` makes another table of them.
fn readings(from: f64) -> String {
    let mut text = "setup,run,X,Y,Z,X_dir,T_head_C,dx_um,dz_um\n".to_owned();
    // The fraction of multiples of the golden ratio: evenly spread, and in no order (Knuth, The Art of Computer Programming 3, 6.4).
    let mut count = from;
    let mut scatter_um = || {
        count += 1.0;
        (count * 0.618_033_988_749_895_f64).fract() - 0.5
    };
    let mut number = 0.0_f64;
    for y in [0.0, 100.0, 200.0, 300.0, 400.0] {
        for side in [1.0, -1.0] {
            for x in [0.0, 75.0, 150.0, 240.0, 310.0, 400.0, 480.0, 600.0] {
                number += 1.0;
                let head = 20.0 + 8.0 * (number * 0.304_347_826).fract();
                let dx_um = 400e-6 * y * y - 15e-3 * x + 3.0 * side + scatter_um();
                let dz_um = 1.8 * (head - 20.0) + scatter_um();
                text += &format!("S1,r0,{x},{y},0,{side},{head:.3},{dx_um:.4},{dz_um:.4}\n");
            }
        }
    }
    text
}

fn shop() -> Shop {
    let description = "[measurement]\nkind = \"displacement\"\nsigma_um = 0.3\nfree = [\"offset\"]\n";
    Shop::new()
        .file("bench.toml", MACHINE)
        .file("grid.csv", readings(0.0))
        .file("grid.toml", description)
        .file("second.csv", readings(0.37))
        .file("second.toml", description)
}

fn arguments(model: &'static str) -> [&'static str; 8] {
    ["calibrate", "grid.csv", "--machine", "bench.toml", "--model", model, "-o", "out.toml"]
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} of {value}"))
}

/// Checks a value against the truth within three standard uncertainties, which must be small.
fn is_true(one: &Value, truth: f64, at_most: f64) {
    let (value, sigma) = (number(one, "value"), number(one, "sigma"));
    assert!((value - truth).abs() < 3.0 * sigma && sigma < at_most, "{one}: {truth}");
}

#[test]
fn stated_terms_and_parameters_are_fitted_together() {
    let shop = shop();
    let model = arguments("EXX1,EXX ~ Y^2,backlash EXX,thermal-drift Z");
    let report = shop.run(model.into_iter().chain(["--json", "--hold-out", "second.csv"])).exits(0).json();
    let names: Vec<&str> =
        report["parameters"].as_array().unwrap().iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["EXX1", "EXXb", "drift.Z.T_head"]);
    is_true(&report["parameters"][0], -15.0, 0.3);
    is_true(&report["parameters"][1], 3.0, 0.1);
    is_true(&report["parameters"][2], 1.8, 0.05);
    let term = &report["terms"][0];
    assert_eq!(
        (&term["hypothesis"], &term["term"], &term["unit"]),
        (&"EXX ~ Y^2".into(), &"Y^2".into(), &"um/m^2".into())
    );
    is_true(term, 400.0, 2.0);
    // Only the scatter remains, also in readings that the fit has not seen: 1/sqrt(12) µm.
    for data in report["data"].as_array().unwrap() {
        assert!((number(data, "left_rms") - 1.0 / 12.0_f64.sqrt()).abs() < 0.03, "{data}");
    }
    // The file says who stated the term, and is read again without a new amount.
    let text = shop.text("out.toml");
    assert!(text.contains("# stated: EXX ~ Y^2; Y^2 ") && text.contains("# stated: thermal-drift Z; "), "{text}");
    shop.run(["machine", "check", "out.toml"]).exits(0);
    let again =
        ["calibrate", "second.csv", "--machine", "out.toml", "--model", "EXX ~ Y^2", "-o", "again.toml", "--json"];
    let again = shop.run(again).exits(0).json();
    assert!(number(&again["terms"][0], "value").abs() < 3.0, "{}", again["terms"]);
}

/// Sixteen readings of 0.3 µm at each of five places of Y, 100 mm apart: alone, the squareness has 0.3 µm / √(16 · 10 · (100 mm)²) = 0.237 µrad. The squares of
/// 0 to 4 correlate with 0 to 4 by r² = 40²/(10 · 174) = 0.9195, so beside the parabola it has 0.237/√(1 − 0.9195) = 0.84 µrad.
#[test]
fn the_uncertainty_of_a_parameter_includes_the_terms_beside_it() {
    let shop = shop();
    let model = arguments("EXX1,EXXb,EC0X,EXX ~ Y^2,thermal-drift Z");
    let report = shop.run(model.into_iter().chain(["--json"])).exits(0).json();
    let all = report["parameters"].as_array().unwrap();
    let sigma = |name: &str| number(all.iter().find(|one| one["name"] == name).unwrap(), "sigma");
    assert!((0.75..0.92).contains(&sigma("EC0X")), "{report:#}");
    // X is balanced over Y: 0.3 µm / √(10 · Σ (x − x̄)²) with Σ (x − x̄)² = 296,597 mm² is 0.174 µm/m.
    assert!((0.15..0.20).contains(&sigma("EXX1")), "{report:#}");
    // The file keeps the larger one: the interval of a correction follows from it.
    assert!(shop.text("out.toml").contains("[uncertainty]"), "{}", shop.text("out.toml"));
}

#[test]
fn every_form_of_a_term_is_one_of_a_model() {
    let shop = shop();
    for (model, parameter) in [
        ("EXX ~ X", "EXX1"),
        ("EXX*X^2", "EXX2"),
        ("EXX ~ dir(X)", "EXXb"),
        ("location EC0X", "EC0X"),
        ("Z ~ T_head_C", "drift.Z.T_head"),
        ("mayer-10,EXX ~ X", "EXX1"),
    ] {
        if model.starts_with("mayer") {
            let text = shop.run(arguments(model)).exits(2).stderr;
            assert!(text.contains("mayer-10 is neither a file"), "{text}");
            continue;
        }
        let report = shop.run(arguments(model).into_iter().chain(["--json"])).exits(0).json();
        assert_eq!(report["parameters"][0]["name"], parameter, "{model}");
    }
    for model in ["EXX.cross", "EXX*Y^2", "EXX ~ Y^2 + X*Y", "EZX X order 2"] {
        let report = shop.run(arguments(model).into_iter().chain(["--json"])).exits(0).json();
        assert!(!report["terms"].as_array().unwrap().is_empty(), "{model}: {report}");
    }
}

#[test]
fn a_model_that_cannot_be_read_or_fitted_says_where_and_why() {
    let shop = shop()
        .file("model.txt", "EXX1\nEC0X # squareness\n  EXX ~ Q^2\nEYY2\n")
        .file("wave.txt", "EXX ~ sin(X/75mm) + X\n");
    let at_line = shop.run(arguments("model.txt")).exits(4).stderr;
    assert!(at_line.contains("E0615") && at_line.contains("model.txt:3:9") && at_line.contains("'Q'"), "{at_line}");
    let equals = shop.run(arguments("EC0X,EXX = Y^2")).exits(4).stderr;
    assert!(equals.contains("E0615") && equals.contains("'='"), "{equals}");
    let unknown = shop.run(arguments("EC0X,nothing")).exits(2).stderr;
    assert!(unknown.contains("nothing is neither a file, nor a preset"), "{unknown}");
    // The clock does not run in these data, and no spindle turns.
    for (model, why) in [("EXX ~ v(X)", "cannot be fitted"), ("EXX ~ Z^2", "Z stays at 0 mm")] {
        let text = shop.run(arguments(model)).exits(4).stderr;
        assert!(text.contains("E0606") && text.contains(why), "{model}: {text}");
    }
    assert!(!shop.path("out.toml").exists());
    // A plan and a selection have no use for terms.
    let select = ["--select", "EXX ~ Y^2"];
    let text = shop.run(arguments("none").into_iter().chain(select)).exits(2).stderr;
    assert!(text.contains("EXX ~ Y^2"), "{text}");
}

/// The same scatter at every Y but for 0.05 µm in one reading: least squares over a grid give Y² nearly the amount 0, so its interval contains 0. A term of
/// 400 µm/m² is shown.
#[test]
fn a_term_that_the_readings_do_not_show_is_named() {
    let mut text = "setup,run,X,Y,Z,dx_um\n".to_owned();
    for y in [0.0, 100.0, 200.0, 300.0, 400.0] {
        let first = if y == 400.0 { 0.35 } else { 0.3 };
        for (place, scatter) in [first, -0.2, 0.1, -0.4, 0.2].into_iter().enumerate() {
            text += &format!("S1,r{y},{},{y},0,{scatter}\n", 100 * place);
        }
    }
    let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\n";
    let shop = shop().file("flat.csv", text).file("flat.toml", description);
    let words = ["calibrate", "flat.csv", "--machine", "bench.toml", "--model", "EXX ~ Y^2", "-o", "out.toml"];
    let run = shop.run(words).exits(0).says("warning[W0608]").says("its 95 % interval contains 0");
    assert_eq!(run.stderr.matches("W0608").count(), 1, "{}", run.stderr);
    let shown = shop.run(["calibrate", "grid.csv"].into_iter().chain(arguments("EXX1,EXX ~ Y^2").into_iter().skip(2)));
    assert!(!shown.exits(0).stderr.contains("W0608"));
}

/// A wave of 3 µm with the period 10 mm at 241 places, 2.5 mm apart, with a scatter of 1/sqrt(12) µm. Least squares give its sine and its cosine an uncertainty of
/// 0.289 · sqrt(2/241) = 0.026 µm each.
#[test]
fn a_fitted_wave_has_an_uncertainty_of_its_own() {
    let mut text = "setup,run,X,Y,Z,dx_um\n".to_owned();
    for count in 0..=240 {
        let x = 2.5 * f64::from(count);
        let scatter_um = (f64::from(count) * 0.618_033_988_749_895_f64).fract() - 0.5;
        let wave_um = 3.0 * (std::f64::consts::TAU * x / 10.0 + 0.7).sin();
        text += &format!("S1,r0,{x},0,0,{:.4}\n", 0.02 * x + wave_um + scatter_um);
    }
    let description = "[measurement]\nkind = \"displacement\"\nsigma_um = 0.3\nfree = [\"offset\"]\n";
    let shop = shop().file("fine.csv", text).file("fine.toml", description);
    let model = "EXX1,EXX ~ sin(X/10mm)";
    shop.run(["calibrate", "fine.csv", "--machine", "bench.toml", "--model", model, "-o", "out.toml"]).exits(0);
    let row = |text: &str| {
        let line = text.lines().find(|line| line.starts_with("\"EXX~10\" = ")).map(str::to_owned);
        line.unwrap_or_else(|| panic!("{text}"))
    };
    let own = row(&shop.text("out.toml"));
    let sigma_um: f64 = own.rsplit(' ').next().unwrap().parse().unwrap();
    assert!((0.01..0.06).contains(&sigma_um), "{own}");
    let shown = shop.run(["machine", "show", "out.toml"]).exits(0).stdout;
    assert!(shown.lines().any(|line| line.starts_with("EXX~10 ") && line.ends_with(" µm")), "{shown}");
    // Without this row the wave is not known, although EXX1 is.
    let program = "N10 G90 G71 G17 G500\nN20 G0 X100 Y50 Z-50\nN30 G1 X400 F500\nN40 M30\n";
    let without = shop.text("out.toml").replace(&own, "");
    let shop = shop.file("in.mpf", program).file("without.toml", without);
    for (machine, unknown) in [("out.toml", "[]"), ("without.toml", "[\"EXX~10\"]")] {
        let json = shop.run(["in.mpf", "-o", "out.mpf", "--machine", machine, "--json"]).exits(0).json();
        assert_eq!(json["prediction"]["unknown"].to_string(), unknown, "{machine}");
    }
}

/// A straightness of X that changes with the difference of two sensors: 2 µm/(K m²) times the square of X. Three set-ups at three differences, 0, 5 and
/// 8 K, two runs each.
fn of_two_sensors() -> Shop {
    let mut text = "setup,run,component,X,T_a_C,T_b_C,value_um\n".to_owned();
    let mut count = 0.0_f64;
    for (setup, [a, b]) in [("A", [20.0, 20.0]), ("B", [26.0, 21.0]), ("C", [30.0, 22.0])] {
        for run in 1..=2 {
            for x in [0.0, 50.0, 110.0, 160.0, 220.0, 290.0, 340.0, 400.0, 460.0, 510.0, 560.0, 600.0] {
                count += 1.0;
                let scatter_um = 0.4 * ((count * 0.618_033_988_749_895_f64).fract() - 0.5);
                let value_um: f64 = 2.0 * (a - b) * (1e-3 * x) * (1e-3 * x) + scatter_um;
                text += &format!("{setup},{setup}{run},EYX,{x},{a},{b},{value_um:.4}\n");
            }
        }
    }
    let description = "[measurement]\nkind = \"direct\"\nsigma_um = 0.2\nfree = [\"offset\", \"slope\"]\n\
        [position]\nY_mm = 100\nZ_mm = 0\n";
    Shop::new().file("bench.toml", MACHINE).file("bow.csv", text).file("bow.toml", description)
}

#[test]
fn a_term_that_the_machine_file_cannot_hold_has_its_own_code() {
    let shop = of_two_sensors();
    let term = "EYX ~ (T_a_C - T_b_C)*X^2";
    let fit = ["calibrate", "bow.csv", "--machine", "bench.toml", "--model", term, "-o", "out.toml"];
    let text = shop.run(fit).exits(4).says("E0620").says("T_a_C").says("remove it from --model").stderr;
    assert!(!text.contains("E0606") && !shop.path("out.toml").exists(), "{text}");
    // The readings show it: only the file has no entry.
    let test = ["diagnose", "bow.csv", "--machine", "bench.toml", "--hypothesis", term, "--json"];
    let report = shop.run(test).exits(0).json();
    let one = &report["hypotheses"][0];
    assert_eq!(one["answer"], "supported", "{one}");
    assert!(one["extends_why"].as_str().unwrap().contains("T_a_C"), "{one}");
    let amount = &one["amounts"][0];
    let [value, u95] = ["value", "u95"].map(|key| number(amount, key));
    assert!((value - 2.0).abs() < 1.5 * u95 && u95 < 0.6, "{amount}");
}

/// Eighty readings, rounded to 0.01 µm: no other measurement. Readings with a scatter of their own are one.
#[test]
fn a_rounded_copy_is_no_second_measurement() {
    let shop = shop();
    let table = shop.text("grid.csv");
    let mut lines: Vec<&str> = table.lines().collect();
    let head = lines.remove(0);
    let rounded = |line: &&str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        for cell in cells.iter_mut().skip(7) {
            *cell = format!("{:.2}", cell.parse::<f64>().unwrap());
        }
        cells.join(",")
    };
    let copy: Vec<String> = std::iter::once(head.to_owned()).chain(lines.iter().map(rounded)).collect();
    let description = shop.text("grid.toml");
    let shop = shop.file("copy.csv", copy.join("\n")).file("copy.toml", description);
    for more in [vec!["copy.csv"], vec!["--hold-out", "copy.csv"]] {
        shop.run(arguments("EXX1").into_iter().chain(more)).exits(4).says("error[E0605]");
    }
    shop.run(arguments("EXX1").into_iter().chain(["--hold-out", "second.csv"])).exits(0);
}

/// Two of three readings of a coarse display are the same number: the others are its steps, not outliers. The middle of the residuals is no spread here.
#[test]
fn steps_of_a_display_are_not_rejected() {
    let steps = [0, 0, 1, 0, 0, -1];
    let rows = (0..60).fold("X,Y,Z,component,value_um\n".to_owned(), |text, k| {
        text + &format!("{},0,0,EYX,{}\n", 10 * k, steps[k as usize % steps.len()])
    });
    let shop = Shop::new()
        .file("bench.toml", MACHINE)
        .file("line.csv", rows)
        .file("line.toml", "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nreference = \"square\"\n");
    let words = ["calibrate", "line.csv", "--machine", "bench.toml", "--model", "EYX2", "-o", "out.toml", "--json"];
    let report = shop.run(words).exits(0).json();
    let rejected = report["weighted_down"].as_array().unwrap();
    assert!(rejected.iter().all(|row| number(row, "weight") > 0.01), "{rejected:?}");
    // At least the noise of a step of 1 µm: 1/√12 µm. The readings scatter by √(1/3) µm; robust weights count less of it.
    let sigma = number(&report["data"][0], "sigma");
    assert!((12.0_f64.sqrt().recip()..0.6).contains(&sigma), "{}", report["data"][0]);
}
