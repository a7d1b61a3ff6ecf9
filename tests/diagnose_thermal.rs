//! What goes with temperatures is found by its name, its sensor, its size and its time constant, whatever the runs and clocks of the file are; and a machine
//! file that is extended by it says the same as the search did.

use serde_json::Value;

use crate::diagnose_causes::{diagnosed, recipe, text, words};
use crate::plant::{Bench, Case};

/// The finding of what is hidden first in a case, which must be there, with the right sensor, its size within its interval and its lag within 20 %.
fn holds(case: &Case, findings: &[Value]) -> Result<(), String> {
    let truth = &case.truth.effects[0];
    let sensor = format!("{}_C", truth.sensor.unwrap());
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let own = findings.iter().find(|one| {
        text(&one["effect"]) == truth.effect && text(&one["parameter"]) == truth.parameter && one["sensor"] == sensor
    });
    let Some(own) = own else { return Err("not found".into()) };
    if (number(&own["value"]) - truth.size).abs() > number(&own["u95"]) {
        return Err(format!("{} ± {}", own["value"], own["u95"]));
    }
    let lag = number(&own["lag_s"]);
    match truth.lag_s {
        Some(known) if known > 0.0 && (lag / known - 1.0).abs() <= 0.2 => Ok(()),
        Some(known) if known == 0.0 && lag < 20.0 => Ok(()),
        _ => Err(format!("lag {lag}")),
    }
}

fn all(bench: Bench, row: u8, seeds: &[u64]) {
    let mut out = String::new();
    for &seed in seeds {
        let case = recipe(bench, &[row], None, 6.0, seed).cook().unwrap();
        let report = diagnosed(&case, false);
        let findings = report["findings"].as_array().unwrap();
        if let Err(why) = holds(&case, findings) {
            let said: Vec<String> = findings
                .iter()
                .map(|one| format!("{} {} ± {}, {} lag {}", words(one), one["value"], one["u95"], one["sensor"], one["lag_s"]))
                .collect();
            out += &format!("{why}\n{}  {}\n", case.words(), said.join("\n  "));
        }
    }
    assert!(out.is_empty(), "{out}");
}

#[test]
fn drift_in_runs_of_one_set_up() {
    all(Bench::DriftRuns, 38, &[3, 4, 5, 6]);
}

#[test]
fn growth_of_a_scale() {
    all(Bench::HotCold, 40, &[2]);
}
