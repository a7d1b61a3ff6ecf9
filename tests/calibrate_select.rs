//! Which terms the data needs: hidden ones are found and named, and where there is nothing nothing is found, also in noise that drifts.

use ncfix_machine::machine::State;
use ncfix_metrology::calibrate::candidates::{PiecewisePolynomials, of_component};
use ncfix_metrology::calibrate::{FitOptions, Parameter, Rule, Selected, Term, quality, select};
use ncfix_metrology::measure::data::{DataSet, Free};
use ncfix_model::ErrorModel;
use ncfix_model::parameter::ParameterName;

use crate::calibrate::{Bench, at, measurement, named, observation, reading, setup};
use crate::model::Random;

const NOISE_MM: f64 = 4e-4;

/// Five times back and forth along X with a laser (`EXX`) and a straightedge (`EYX`), every 20 mm; a run for each.
fn lines() -> Bench {
    let mut set = measurement("direct", &[Free::Offset]);
    set.setups.push(setup("", [0.0; 3], 0.0));
    set.targets = vec!["EXX".into(), "EYX".into()];
    set.runs = (0..5).map(|run| run.to_string()).collect();
    for (target, name) in ["EXX", "EYX"].into_iter().enumerate() {
        for run in 0..5 {
            for k in (0..36).chain((0..36).rev()) {
                let mut row = observation(
                    reading(at(&[('X', 20.0 * f64::from(k))]), nalgebra::Vector3::zeros(), State::default()),
                    0,
                );
                row.run = run;
                row.target = Some(target);
                row.component = Some(name.parse().unwrap());
                row.values = [Some(0.0), None, None];
                set.observations.push(row);
            }
        }
    }
    let mut bench = Bench::new(crate::model::machine("wXFYZSt"), Vec::new(), vec![set], 1);
    bench.unknowns[0] = vec![3e-3, -2e-3];
    bench
}

/// With errors by their names, mm per power.
fn with(mut bench: Bench, errors: &[(&str, f64)]) -> Bench {
    bench.errors = ErrorModel::default();
    for (name, value) in errors {
        named(name)[0].set(&mut bench.errors, *value);
    }
    bench
}

/// What was measured, with noise of this correlation from row to row.
fn drifting(bench: &Bench, rho: f64, random: &mut Random) -> Vec<DataSet> {
    let (mut data, _) = bench.measured(0.0, 0.0, random);
    let mut last = (usize::MAX, None, 0.0);
    for row in &mut data[0].observations {
        let fresh = random.normal();
        let noise = if (last.0, last.1) == (row.run, row.target) {
            rho * last.2 + (1.0 - rho * rho).sqrt() * fresh
        } else {
            fresh
        };
        last = (row.run, row.target, noise);
        row.values[0] = row.values[0].map(|value| value + NOISE_MM * noise);
    }
    data
}

fn candidates(bench: &Bench, degree: u8) -> Vec<Parameter> {
    let pieces = PiecewisePolynomials { spacing_mm: 50, degree };
    ["EXX", "EYX"]
        .iter()
        .flat_map(|name| of_component(name.parse().unwrap(), &bench.data, pieces))
        .map(Parameter::from)
        .collect()
}

fn parameters(names: Vec<ParameterName>) -> Vec<Parameter> {
    names.into_iter().map(Parameter::from).collect()
}

fn selected(bench: &Bench, data: &[DataSet], candidates: &[Parameter]) -> Selected {
    let options = FitOptions { robust: true };
    select(&bench.machine, &ErrorModel::default(), &[], candidates, data, options, Rule::default()).unwrap()
}

fn names(parameters: &[Parameter]) -> Vec<String> {
    let mut names: Vec<String> = parameters.iter().map(Parameter::to_string).collect();
    names.sort();
    names
}

const HIDDEN: &[(&str, f64)] = &[("EXX1", 3.2e-5), ("EXX2", -9e-8), ("EXX3", 9e-11), ("EYX2@350", 1.2e-7)];

#[test]
fn a_cubic_and_a_bend_are_found_and_named() {
    let bench = with(lines(), HIDDEN);
    let all = candidates(&bench, 3);
    assert_eq!(all.len(), 32);
    for rho in [0.0, 0.5] {
        let mut random = Random(17);
        let data = drifting(&bench, rho, &mut random);
        let found = selected(&bench, &data, &all);
        // Each is there, or is told to be as good as one that is: between two positions a knot says little.
        let terms = &found.choice.terms;
        assert_eq!(terms.len(), HIDDEN.len(), "{:?}", names(&found.parameters));
        for (name, _) in HIDDEN {
            let number = all.iter().position(|known| known.to_string() == *name).unwrap();
            let is_class = |term: &Term| term.rivals.iter().any(|rival| rival.candidate == number);
            assert!(terms.iter().any(|term| term.candidate == number || is_class(term)), "{name}: {terms:?}");
        }
        assert!(names(&found.parameters).contains(&"EYX2@350".to_owned()), "{:?}", names(&found.parameters));
        // Without noise hardly anything is left.
        let (exact, _) = bench.measured(0.0, 0.0, &mut random);
        let left = quality(&bench.machine, &found.fit.errors, &exact[0]).unwrap().left[0];
        assert!(left < 0.2 * NOISE_MM, "{left}");
        let told = found.choice.correlation[0].1;
        assert!((told - rho).abs() < 0.15, "{told} for {rho}");
        let gain = found.choice.gain.unwrap();
        assert!(gain.is_real() && gain.share > 0.95 && gain.after < 1.2, "{gain:?}");
        assert!(found.choice.terms.iter().all(|term| term.p < 1e-6 && term.gain.is_real()));
        // Of data that it has not seen the noise is left.
        let other = drifting(&bench, rho, &mut random);
        let left = quality(&bench.machine, &found.fit.errors, &other[0]).unwrap().left[0];
        assert!((0.85..1.15).contains(&(left / NOISE_MM)), "{left}");
    }
}

#[test]
fn gross_errors_neither_hide_nor_make_terms() {
    let bench = with(lines(), HIDDEN);
    let mut random = Random(5);
    let mut data = drifting(&bench, 0.3, &mut random);
    for k in (7..data[0].observations.len()).step_by(53) {
        let row = &mut data[0].observations[k];
        row.values[0] = row.values[0].map(|value| value + 50.0 * NOISE_MM);
    }
    let found = selected(&bench, &data, &candidates(&bench, 3));
    let (exact, _) = bench.measured(0.0, 0.0, &mut random);
    let left = quality(&bench.machine, &found.fit.errors, &exact[0]).unwrap().left[0];
    assert!(left < 0.2 * NOISE_MM, "{left} {:?}", found.choice.steps);
    assert_eq!(found.parameters.len(), HIDDEN.len(), "{:?}", names(&found.parameters));
}

#[test]
fn nothing_is_found_where_the_instrument_drifts() {
    let bench = with(lines(), &[]);
    let all = candidates(&bench, 2);
    let mut claims = 0;
    let trials = 100;
    for seed in 0..trials {
        let data = drifting(&bench, 0.95, &mut Random(1000 + seed));
        claims += usize::from(!selected(&bench, &data, &all).choice.terms.is_empty());
    }
    assert!(claims * 20 <= trials as usize, "{claims} of {trials}");
}

#[test]
fn what_the_data_does_not_tell_never_enters() {
    let bench = with(lines(), &[("EXX1", 3.2e-5)]);
    let data = drifting(&bench, 0.0, &mut Random(3));
    // Y and Z stand still; a shift of the instrument is unknown.
    let all = parameters(named("EYY1 EAZ1 EXX0 EXX1 EBX2@900"));
    let found = selected(&bench, &data, &all);
    assert_eq!(names(&found.parameters), ["EXX1"]);
    let lost: Vec<String> = found.choice.not_identified.iter().map(|&number| all[number].to_string()).collect();
    assert_eq!(lost, ["EYY1", "EAZ1", "EXX0", "EBX2@900"]);
    assert_eq!(found.choice.tried, 1);
}

#[test]
fn what_cannot_be_told_apart_is_a_class() {
    let bench = with(lines(), &[("EXX1", 3.2e-5)]);
    let data = drifting(&bench, 0.0, &mut Random(4));
    // All positions are on one side of −100 mm, and beside an unknown shift both are the same line.
    let found = selected(&bench, &data, &parameters(named("EXX1 EXX1@-100")));
    assert_eq!(names(&found.parameters), ["EXX1"], "the one without a knot");
    let rivals = &found.choice.terms[0].rivals;
    assert_eq!(rivals.iter().map(|rival| rival.candidate).collect::<Vec<usize>>(), [1]);
    assert!((rivals[0].correlation.abs() - 1.0).abs() < 1e-9 && rivals[0].worse.abs() < 1e-3);
}

#[test]
fn candidates_begin_where_the_machine_file_has_them() {
    // The start knows EXX1 already; what is not chosen stays.
    let bench = with(lines(), &[("EXX1", 3.2e-5), ("EYX2@350", 1.2e-7)]);
    let data = drifting(&bench, 0.0, &mut Random(6));
    let start = with(lines(), &[("EXX1", 3.2e-5)]).errors;
    let options = FitOptions { robust: true };
    let all = candidates(&bench, 2);
    let found = select(&bench.machine, &start, &[], &all, &data, options, Rule::default()).unwrap();
    assert_eq!(names(&found.parameters), ["EYX2@350"], "{:?}", found.choice.steps);
    assert_eq!(named("EXX1")[0].get(&found.fit.errors), 3.2e-5);
}
