//! `ncfix calibrate --select`: the terms that the data needs, in the report and in the machine file.

use std::fmt::Write as _;

use serde_json::Value;

use crate::cli_calibrate::bare;
use crate::support::Shop;

const ERRORS: &str = "[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 3.2e-5, -4.0e-8]\n";

/// A laser along X, four times back and forth.
fn shop() -> Shop {
    let mut plan = "component,run,X,Y,Z\n".to_owned();
    for run in 0..4 {
        for k in (0..36).chain((0..36).rev()) {
            let _ = writeln!(plan, "EXX,{run},{},0,0", 20 * k);
        }
    }
    let start = bare("demo");
    let shop = Shop::new()
        .file("true.toml", format!("{start}{ERRORS}"))
        .file("start.toml", start)
        .file("plan.csv", plan)
        .file("plan.toml", "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\n");
    let arguments =
        ["simulate", "plan.csv", "-o", "laser.csv", "--machine", "true.toml", "--noise", "0.3um", "--seed", "2"];
    shop.run(arguments).exits(0);
    shop
}

const CALIBRATE: [&str; 8] =
    ["calibrate", "laser.csv", "--machine", "start.toml", "--model", "none", "-o", "machine.toml"];

fn names<'a>(list: &'a Value, key: &str) -> Vec<&'a str> {
    list.as_array().unwrap().iter().map(|one| one[key].as_str().unwrap()).collect()
}

#[test]
fn the_terms_that_are_needed_are_chosen_told_and_written() {
    let shop = shop();
    let run = |more: &[&str]| shop.run(CALIBRATE.iter().chain(more).copied());
    let report = run(&["--select", "motion", "--json"]).exits(0).json();
    let selection = &report["selection"];
    assert_eq!(names(&selection["terms"], "name"), ["EXX1", "EXX2"], "{selection}");
    assert_eq!(names(&report["parameters"], "name"), ["EXX1", "EXX2"]);
    // Knots at 50 … 650 mm; 17 of the errors of three axes move nothing that was read, or stand still.
    assert_eq!(selection["tried"], 15, "{selection}");
    assert!(names_of(&selection["not_told"]).contains(&"EYX (all 15 terms)"), "{selection}");
    assert!(selection["held_out"]["gain"].as_f64().unwrap() > 0.95, "{selection}");
    assert_eq!((selection["is_settled"] == true, selection["significance"].as_f64()), (true, Some(0.01)));
    for step in selection["steps"].as_array().unwrap() {
        assert!(step["p"].as_f64().unwrap() < 0.01 && step["freedom"].as_f64().unwrap() >= 1.0, "{step}");
    }
    let written = shop.text("machine.toml");
    assert!(written.contains("component = \"EXX\""), "{written}");
    run(&["--select", "EXX", "--knots", "100mm"])
        .exits(0)
        .says("left-out gain")
        .says("candidates")
        .says("8 tested, 2 chosen");
}

fn names_of(list: &Value) -> Vec<&str> {
    list.as_array().unwrap().iter().map(|one| one.as_str().unwrap()).collect()
}

#[test]
fn what_is_no_candidate_is_refused() {
    let shop = shop();
    let run = |more: &[&str]| shop.run(CALIBRATE.iter().chain(more).copied());
    run(&["--select", "EQQ"]).exits(2).says("is not a preset, an error such as EXX");
    run(&["--select", "ECB1"]).exits(2).says("has no axis B");
    run(&["--select", "EXX", "--knots", "0.5mm"]).exits(2).says("not a whole number of mm");
    run(&["--select", "EXX", "--significance", "60%"]).exits(2).says("up to 50");
    run(&["--select", "motion", "--knots", "1mm"]).exits(2).says("can be tested");
    run(&["--knots", "100mm"]).exits(2).says("--select");
    run(&[]).exits(2).says("neither a file, nor a preset");
}
