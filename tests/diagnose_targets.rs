//! `ncfix diagnose` on positioning tests as ISO 230-2 describes them: few targets, some runs in both directions, and errors that follow no curve; and
//! texts that must not say more than such data show.

use serde_json::Value;

use crate::support::Shop;

const SLIDE: &str =
    "[machine]\nname = \"slide\"\ntopology = \"wFXSt\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-25, 25]\n";
const DIRECT: &str = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\n";
/// Targets, mm, and the error at each, µm: up and down, as a screw that was mounted badly has it.
const TARGETS: [(f64, f64); 9] = [
    (-20.0, -30.0),
    (-15.0, 18.0),
    (-10.0, 60.0),
    (-5.0, 21.0),
    (0.0, -27.0),
    (5.0, -18.0),
    (10.0, -13.0),
    (15.0, -6.0),
    (20.0, 27.0),
];

/// Runs over the targets in both directions with a reversal value of 26 µm and up to 2 µm that follow no driver; `from` makes other ones of these.
fn runs(count: usize, from: f64, error: impl Fn(f64) -> f64) -> String {
    let mut text = "run,setup,component,X,X_dir,value_um\n".to_owned();
    // The fraction of multiples of the golden ratio: evenly spread, and in no order (Knuth, The Art of Computer Programming 3, 6.4).
    let mut at = from;
    for run in 0..count {
        for side in [1.0, -1.0] {
            let mut order = TARGETS;
            if side < 0.0 {
                order.reverse();
            }
            for (x, own) in order {
                at += 1.0;
                let scatter_um = 4.0 * ((at * 0.618_033_988_749_895_f64).fract() - 0.5);
                text += &format!("r{run},A,EXX,{x},{side},{:.3}\n", error(own) + 13.0 * side + scatter_um);
            }
        }
    }
    text
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} of {value}"))
}

fn shop(train: String, hold: String) -> Shop {
    let shop = Shop::new().file("slide.toml", SLIDE).file("train.csv", train).file("train.toml", DIRECT);
    shop.file("hold.csv", hold).file("hold.toml", DIRECT)
}

#[test]
fn errors_from_target_to_target_do_not_hide_a_reversal_value() {
    let own = |error: f64| error;
    let shop = shop(runs(3, 0.0, own), runs(2, 0.41, own));
    let call =
        ["diagnose", "train.csv", "--machine", "slide.toml", "--holdout", "hold.csv", "-o", "out.toml", "--json"];
    let report = shop.run(call).exits(0).json();
    let finding = |effect: &str| {
        let all = report["findings"].as_array().unwrap();
        all.iter().find(|one| one["effect"] == effect).unwrap_or_else(|| panic!("{effect}: {report}")).clone()
    };
    let backlash = finding("backlash");
    assert!((number(&backlash, "value") - 26.0).abs() < number(&backlash, "u95"), "{backlash}");
    assert!(number(&backlash, "u95") < 8.0 && backlash["extends"] == true, "{backlash}");
    // From −30 to 60 µm.
    let motion = finding("motion");
    assert!((number(&motion, "value") - 90.0).abs() < number(&motion, "u95"), "{motion}");
    // Of 29 µm RMS only the scatter remains, 4/sqrt(12) = 1.15 µm, in readings that were not used too.
    assert!(
        number(&report["after"], "rms_um") < 1.5 && number(&report["after"], "holdout_rms_um") < 1.6,
        "{}",
        report["after"]
    );
    shop.run(["machine", "check", "out.toml"]).exits(0);
    let again = shop.run(["diagnose", "hold.csv", "--machine", "out.toml", "--json"]).exits(0).json();
    assert!(number(&again["before"], "rms_um") < 1.6, "{}", again["before"]);
}

#[test]
fn what_is_far_beyond_the_scatter_of_repeats_is_not_called_noise() {
    // Two runs, whose readings differ by 4 µm at most, are too few for a value of each target.
    let own = |error: f64| error;
    let shop = shop(runs(2, 0.0, own), runs(2, 0.41, own));
    let report = shop.run(["diagnose", "train.csv", "--machine", "slide.toml", "--json"]).exits(0).json();
    let has_findings = !report["findings"].as_array().unwrap().is_empty();
    assert!(has_findings || report["unexplained"]["structure"] == true, "{report}");
    let text = shop.run(["diagnose", "train.csv", "--machine", "slide.toml"]).exits(0);
    let all = text.stdout + &text.stderr;
    assert!(!all.contains("within their noise"), "{all}");
}

#[test]
fn a_component_of_an_axis_that_the_machine_does_not_have_is_refused() {
    let wrong = runs(2, 0.0, |error| error).replace(",EXX,", ",EXC,");
    let shop = shop(wrong, runs(2, 0.41, |error| error));
    let calibrate = ["calibrate", "train.csv", "--machine", "slide.toml", "--model", "EXX1", "-o", "out.toml"];
    shop.run(calibrate).exits(4).says("train.csv:2:6").says("the machine slide has no axis C");
    for command in ["diagnose", "iso230"] {
        shop.run([command, "train.csv", "--machine", "slide.toml"]).exits(4).says("E0603").says("EXC is an error of C");
    }
    assert!(!shop.path("out.toml").exists());
}

#[test]
fn a_hot_end_is_a_sound_sensor() {
    // A probe that follows the hot end of a printer by 0.1 µm/K, and its bed not at all.
    let mut text = "run,setup,t_s,T_end_C,T_bed_C,dz_um\n".to_owned();
    for row in 0..240 {
        let (k, t_s) = (f64::from(row), 60.0 * f64::from(row));
        // On after 40 minutes, off after 180; six minutes in both directions.
        let since = |from: f64| if k > from { 1.0 - (-(k - from) / 6.0).exp() } else { 0.0 };
        let end = 25.0 + 195.0 * (since(40.0) - since(180.0));
        let bed = 25.0 + 30.0 * (k * 0.618_033_988_749_895_f64).fract();
        let scatter = (k * 0.414_213_562_373_095_f64).fract() - 0.5;
        text += &format!("r,A,{t_s},{end:.2},{bed:.2},{:.3}\n", 0.1 * (end - 25.0) + scatter);
    }
    let machine = "[machine]\nname = \"printer\"\ntopology = \"wFXYZSt\"\n[axis.X]\ndirection = [1, 0, 0]\n[axis.Y]\ndirection = [0, 1, 0]\n[axis.Z]\ndirection = [0, 0, 1]\n";
    let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\nsigma_um = 0.3\n[position]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n";
    let shop = Shop::new().file("m.toml", machine).file("probe.csv", text).file("probe.toml", description);
    let report = shop.run(["diagnose", "probe.csv", "--machine", "m.toml", "--json"]).exits(0).json();
    let faults = report["data_faults"].as_array().unwrap();
    assert!(faults.iter().all(|one| one["what"] != "dead"), "{faults:?}");
    let first = &report["findings"][0];
    assert_eq!((&first["effect"], &first["sensor"]), (&"thermal-drift".into(), &"T_end_C".into()), "{report}");
    assert!((number(first, "value") - 0.1).abs() < 0.01, "{first}");
}

#[test]
fn a_file_with_a_cause_that_is_not_sure_waits_for_a_measurement() {
    // In these samples, the yaw of X explains the readings more often than its positioning does.
    let sample =
        |name: &str| crate::support::repository(&format!("samples/measurements/{name}.csv")).display().to_string();
    let (bar, laser, demo) = (sample("ball_bar"), sample("laser"), crate::support::machine("demo"));
    let shop = Shop::new();
    let call = ["diagnose", &bar, &laser, "--machine", &demo, "-o", "out.toml"];
    let report = shop.run(call.into_iter().chain(["--json"])).exits(0).json();
    let findings = report["findings"].as_array().unwrap();
    let unsure: Vec<&Value> =
        findings.iter().filter(|one| one["probability"].as_f64().is_some_and(|own| own < 0.95)).collect();
    assert!(!unsure.is_empty() && unsure.iter().all(|one| one["extends"] == false), "{report}");
    assert!(findings.iter().any(|one| one["extends"] == true), "{report}");
    let run = shop.run(["diagnose", &bar, &laser, "--machine", &demo, "-o", "again.toml"]).exits(0);
    let text = run.stdout + &run.stderr;
    let reasons =
        text.lines().filter(|line| line.starts_with("Not written: ") && line.contains("its probability is only"));
    assert_eq!(reasons.count(), unsure.len(), "{text}");
}
