//! Tests of hypotheses on readings of synthetic machines: true, false and invisible ones, and wrong syntax.

use super::super::bench;
use super::super::cause::{Causes, Correctable};
use super::super::extend::change::Change;
use super::{HypothesisTrial, StatedTrials, diagnose_stated, read};
use crate::measure::data::DataSet;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;

fn source(text: &str) -> Source {
    Source::new(FileId(7), "--hypothesis", text.as_bytes().to_vec()).unwrap()
}

/// Noise with a standard deviation of 0.5 µm, as of an instrument: sums of twelve uniform numbers (Knuth, The Art of Computer Programming 2, 3.4.1).
fn noise_um() -> impl FnMut() -> f64 {
    let mut state = 20_261_126_u64;
    move || {
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        0.5 * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0)
    }
}

const DISPLACEMENT: &str = "[measurement]\nkind = \"displacement\"\nsigma_um = 0.5\n";

/// A grid over X and Y, measured three times in both directions along X, with a deviation along X by position and direction, µm.
fn grid(machine: &Machine, dx_um: impl Fn(f64, f64, f64) -> f64) -> DataSet {
    let mut noise = noise_um();
    let mut text = "run,X,Y,Z,X_dir,dx_um,dy_um,dz_um\n".to_owned();
    for run in 1..=3 {
        for y in [0.0, 130.0, 250.0, 380.0, 500.0] {
            let there: Vec<f64> = vec![0.0, 90.0, 170.0, 260.0, 310.0, 400.0];
            for sense in [1.0, -1.0] {
                let places: Vec<f64> = if sense > 0.0 { there.clone() } else { there.iter().rev().copied().collect() };
                for x in places {
                    let read = [dx_um(x, y, sense), 0.0, 0.0].map(|own| own + noise());
                    text += &format!("{run},{x},{y},0,{sense},{:.4},{:.4},{:.4}\n", read[0], read[1], read[2]);
                }
            }
        }
    }
    bench::table(machine, &text, DISPLACEMENT)
}

fn tried(machine: &Machine, sets: &[DataSet], used: usize, text: &str) -> StatedTrials {
    let all: Vec<&DataSet> = sets.iter().collect();
    let (stated, faults) = read(&source(text), machine, &all);
    assert!(faults.is_empty(), "{faults:#?}");
    let scene = bench::scene(machine, sets);
    diagnose_stated(&stated, &Causes::default(), &scene, (&scene, used), &mut |_, _| {}).1
}

/// Demands that the amount is within 1.5 times its uncertainty of the true one.
fn demand(trial: &HypothesisTrial, amount: f64, unit: &str, most_u95: f64) {
    let one = &trial.amounts[0];
    assert_eq!(one.unit, unit, "{trial:#?}");
    assert!((one.value - amount).abs() < 1.5 * one.u95 && one.u95 < most_u95, "{amount}: {one:?}");
}

#[test]
fn a_true_hypothesis_a_false_one_and_an_invisible_one() {
    let machine = bench::machine();
    // 40 µm/m² · (0.5 m)² = 10 µm at the far end of Y.
    let bowed = |_: f64, y: f64, _: f64| 40e-6 * y * y;
    let sets = [grid(&machine, bowed), grid(&machine, bowed)];
    let found = tried(&machine, &sets, 1, "EXX ~ Y^2\nEXX ~ X^2\nEXX ~ Z^2\nEXX*Y^2");
    let [right, wrong, hidden, short] = found.trials.as_slice() else { panic!("{found:#?}") };
    demand(right, 40.0, "um/m^2", 2.0);
    assert!(right.evidence_alone > 50.0 && right.evidence_beside > 50.0, "{right:#?}");
    // 10 µm over five positions of Y are 3.8 µm RMS (mean of (y/0.5)⁴ minus the square of that of (y/0.5)², times 10 µm) and the noise is 0.5 µm, so
    // most of it is removed.
    assert!(right.is_held_out && right.gain.unwrap() > 0.5, "{:?}", right.gain);
    assert!(wrong.evidence_beside < 0.0 && wrong.amounts[0].value.abs() < 2.0 * wrong.amounts[0].u95, "{wrong:#?}");
    assert_eq!(wrong.correctable, Correctable::No);
    let why = hidden.why_not_shown.as_deref().unwrap();
    assert!(why.contains("Z stays at 0 mm") && hidden.probability.is_none(), "{why}");
    // The short form is the same statement.
    assert_eq!(short.amounts[0].value, right.amounts[0].value);
    assert!(right.probability.unwrap() > 0.5 * wrong.probability.unwrap(), "{:#?}", found.sets);
}

#[test]
fn a_reversal_is_named_as_findings_name_it() {
    let machine = bench::machine();
    // 3 µm in each direction: a reversal value of 6 µm.
    let sets = [grid(&machine, |_, _, sense| 3.0 * sense)];
    let found = tried(&machine, &sets, 1, "EXX ~ dir(X)\nbacklash EXX\nEXX.backlash\nEXX X_dir\nEXX ~ X_dir*Y");
    for trial in &found.trials[..4] {
        demand(trial, 6.0, "um", 0.3);
        assert_eq!(trial.name, "backlash EXX");
        assert!(trial.evidence_beside > 50.0 && trial.gain.unwrap() > 0.3, "{trial:#?}");
        assert_eq!(trial.correctable, Correctable::Program);
    }
    // It represents the accepted cause.
    assert_eq!(found.trials[0].stands_for, ["backlash EXX"]);
    assert!(found.trials[4].evidence_beside < 0.0 && found.trials[4].beside.contains(&"backlash EXX".to_owned()));
}

#[test]
fn a_drift_follows_its_sensor_with_a_lag() {
    let machine = bench::machine();
    let mut noise = noise_um();
    let mut text = "X,Y,Z,t_s,T_head_C,T_bed_C,dx_um,dy_um,dz_um\n".to_owned();
    // A ramp of 1 K in 600 s for two hours. The response of a body with a time constant τ lags by τ (1 − exp(−t/τ)): first-order lag of a ramp.
    for row in 0..120 {
        let t_s = 60.0 * f64::from(row);
        let lag_s = 600.0;
        let rise_k = (t_s - lag_s * (1.0 - (-t_s / lag_s).exp())) / 600.0;
        let dz_um = 4.0 * rise_k + noise();
        text += &format!("100,100,50,{t_s},{:.4},20.0,{:.4},{:.4},{dz_um:.4}\n", 20.0 + t_s / 600.0, noise(), noise());
    }
    let sets = [bench::table(&machine, &text, DISPLACEMENT)];
    let stated =
        "Z ~ T_head_C lag 600s\nEZZ ~ T_head_C lag 10min\nZ ~ (T_head_C - T_bed_C) lag 600s\nY ~ T_head_C lag 600s";
    let found = tried(&machine, &sets, 1, stated);
    for trial in &found.trials[..3] {
        demand(trial, 4.0, "um/K", 0.2);
        assert!(trial.evidence_beside > 10.0, "{trial:#?}");
    }
    for (trial, sensors) in
        found.trials.iter().zip([vec![("T_head", 4.0)], vec![("T_head", 4.0)], vec![("T_head", 4.0), ("T_bed", -4.0)]])
    {
        let changes = trial.changes.clone().unwrap().unwrap_or_else(|why| panic!("{why}: {trial:#?}"));
        assert_eq!(changes.len(), sensors.len());
        for (change, (name, um_per_k)) in changes.iter().zip(sensors) {
            let Change::Drift { direction: "Z", sensor, lag_s: 600.0, um_per_k: own } = change else {
                panic!("{change:?}")
            };
            assert!(sensor == name && (own - um_per_k).abs() < 0.2, "{change:?}");
        }
        assert_eq!(trial.correctable, Correctable::Live);
    }
    assert!(found.trials[3].evidence_beside < 0.0, "{:#?}", found.trials[3]);
}

#[test]
fn waves_steps_and_products_have_their_amounts() {
    let machine = bench::machine();
    // A step of 5 µm beyond X 200, and a product that is 8 µm at (400, 500): 40 µm/m².
    let sets = [grid(&machine, |x, y, _| if x > 200.0 { 5.0 } else { 0.0 } + 40e-6 * x * y)];
    let found = tried(&machine, &sets, 1, "EXX ~ step(X > 200mm) + X*Y");
    let trial = &found.trials[0];
    let [step, product] = trial.amounts.as_slice() else { panic!("{trial:#?}") };
    assert!((step.value - 5.0).abs() < 1.5 * step.u95 && step.u95 < 0.5 && step.unit == "um", "{step:?}");
    assert!(
        (product.value - 40.0).abs() < 1.5 * product.u95 && product.u95 < 3.0 && product.unit == "um/m^2",
        "{product:?}"
    );
    assert!(trial.evidence_alone > 50.0, "{trial:#?}");
    // 3 µm sin(2π x/700 mm) has an amplitude of 3 µm whatever its phase.
    let wave = |x: f64, _: f64, _: f64| 3.0 * (std::f64::consts::TAU * x / 700.0 + 1.0).sin();
    let found = tried(&machine, &[grid(&machine, wave)], 1, "EXX ~ sin(X/700mm)");
    demand(&found.trials[0], 3.0, "um", 0.5);
}

#[test]
fn every_fault_has_its_column_and_says_what_to_write() {
    let machine = bench::machine();
    let sets = [grid(&machine, |_, _, _| 0.0)];
    let all: Vec<&DataSet> = sets.iter().collect();
    let faults = |text: &str| -> Vec<(usize, String)> {
        let (stated, found) = read(&source(text), &machine, &all);
        assert_eq!(stated.is_empty(), !found.is_empty());
        found.iter().map(|one| (one.place.unwrap().span.start as usize, one.message.clone())).collect()
    };
    for (text, expected) in [
        ("", vec![(0, "a hypothesis is empty")]),
        ("EXX ~", vec![(5, "a factor is missing before the end")]),
        ("EXX ~ C^2", vec![(6, "the machine has no axis C")]),
        (
            "EXC ~ T_nose_C",
            vec![(0, "the machine has no axis C"), (6, "'T_nose_C' is neither an axis nor a column of the data")],
        ),
        ("EXX ~ Y^1.5", vec![(8, "a power is a whole number from 1 to 9")]),
        ("EXX ~ 3*Y", vec![(6, "a number is not a factor: the fit determines the amount of each term")]),
        ("EXX ~ Y lag 5s", vec![(8, "a lag needs a temperature in its term")]),
        ("EXX ~ t_s", vec![(6, "the data have no column t_s")]),
        ("EXX ~ sin(X)", vec![(11, "'/' is missing before ')'")]),
        ("EXX ~ cos(X/5mm)", vec![(6, "'cos' is not a function")]),
        ("EXX ~ step(X > 400s)", vec![(15, "the unit does not fit X")]),
        ("EXX ~ Y Z", vec![(8, "'Z' is not expected here")]),
        ("EQX ~ Y", vec![(0, "'EQX' is not an error component")]),
        ("gremlins EXX", vec![(0, "'gremlins' is neither an error nor a cause")]),
        // Each line has its own errors; comments are skipped.
        ("# of today\nEXX ~ Y^2\nEXX ~ Q", vec![(27, "'Q' is neither an axis nor a column of the data")]),
    ] {
        let found = faults(text);
        let own: Vec<(usize, &str)> = found.iter().map(|(at, message)| (*at, message.as_str())).collect();
        assert_eq!(own, expected, "{text}");
    }
    for text in [
        "EXX ~ (X-300mm)*Y^2",
        // A file ends with a line end, and may have empty lines.
        "EXX ~ Y^2\n",
        "\nEXX ~ Y^2\n\n# bow\nEYX X order 2\r\n",
        "EYX~X*Y",
        "EC0Y ~ 1",
        "X ~ step(Y < -5)",
        "EXX ~ v(X)",
        "location EC0Y",
        "EYX X order 2",
    ] {
        assert_eq!(faults(text), [], "{text}");
    }
}
