//! The measurement that a diagnosis names next decides between its explanations: after it, the true cause is certain.

use serde_json::Value;

use crate::cli_calibrate::bare;
use crate::diagnose::{findings, name, number, report, run};
use crate::support::Shop;

/// Plans named by a report, with their shares of the doubt.
fn next(report: &Value) -> Vec<(String, f64)> {
    let all = report["measure_next"].as_array().unwrap();
    all.iter().map(|one| (one["command"].as_str().unwrap().to_owned(), number(one, "resolves"))).collect()
}

/// Plans a measurement, and simulates it on a machine.
fn measured(shop: &Shop, command: &str, on: &str, to: &str) {
    let words: Vec<&str> = command.split_whitespace().skip(1).collect();
    let words: Vec<&str> = words.iter().map(|word| if *word == "M.toml" { "m.toml" } else { word }).collect();
    shop.run(words).exits(0);
    shop.run(["simulate", "PLAN.csv", "--machine", on, "--noise", "0.5um", "--seed", "7", "-o", to]).exits(0);
}

#[test]
fn a_circle_of_unknown_length_asks_for_a_line_which_then_decides() {
    // With a free length, one circle shows the difference of two scales only: X too long, or Y too short.
    let scale = "\n[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 4e-5]\n";
    let shop = Shop::new().file("m.toml", bare("demo")).file("true.toml", bare("demo") + scale);
    measured(&shop, "ncfix plan ballbar --plane XY --machine M.toml -o PLAN.csv", "true.toml", "circle.csv");
    let first = report(&run(&shop, &["circle.csv".to_owned()], "m.toml", &[]));
    assert!(findings(&first).iter().all(|one| one["certain"] == false), "{first:#}");
    let plans = next(&first);
    let (command, resolves) = plans.first().unwrap_or_else(|| panic!("{first:#}"));
    assert!(*resolves > 0.9, "{plans:?}");
    assert!(plans.iter().all(|(command, _)| !command.contains("ballbar --plane XY")), "{plans:?}");
    measured(&shop, command, "true.toml", "line.csv");
    let both = report(&run(&shop, &["circle.csv".to_owned(), "line.csv".to_owned()], "m.toml", &[]));
    let all = findings(&both);
    let found = all.iter().find(|one| name(one) == "motion EXX").unwrap_or_else(|| panic!("{command}: {both:#}"));
    assert!(found["certain"] == true && number(found, "probability") >= 0.95, "{command}: {found:#}");
    assert!((number(found, "value") - 40.0).abs() < 2.0 * number(found, "u95").max(0.5), "{found:#}");
    assert!(next(&both).iter().all(|(again, _)| again != command), "{both:#}");
}
