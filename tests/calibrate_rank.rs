//! What plans of the literature can tell, what cannot be told in words, and how long a fit takes.
#![allow(clippy::print_stdout, reason = "what a plan can tell, and times are worth reading where a test fails")]

use std::time::Instant;

use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_base::numeric::RANK_LIMIT;
use ncfix_metrology::calibrate::{FitError, FitOptions, Identified, fit, identify};
use ncfix_model::ErrorModel;

use crate::calibrate::{Bench, circles, cubic, named, preset, rumba, samba};
use crate::model::{Random, machine};

fn identified(bench: &Bench) -> Identified {
    identify(&bench.machine, &ErrorModel::default(), &bench.parameters, &bench.data).unwrap()
}

/// Singular values on both sides of the rank, as shares of the largest one.
fn gap(found: &Identified) -> (f64, f64) {
    let share = |k: usize| found.singular_values.get(k).map_or(0.0, |value| value / found.singular_values[0]);
    (share(found.rank - 1), share(found.rank))
}

/// Far from the limit on both sides.
fn assert_gap(found: &Identified) {
    let (last, next) = gap(found);
    println!("{} columns, rank {}, {last:e} | {next:e}", found.columns.len(), found.rank);
    assert!(last > 100.0 * RANK_LIMIT && next < 1e-3 * RANK_LIMIT, "{last:e} | {next:e}");
}

/// Esmaeili 2021, ch. 5: 137 columns with 12 coordinates of balls and 3 of the tool, rank 96, of which 81 of the machine.
#[test]
fn rumba_tells_81() {
    let bench = rumba(cubic(&machine("wCAYFXZSt")));
    let found = identified(&bench);
    assert_eq!((found.columns.len(), found.rank, found.machine_rank), (137, 96, 81));
    assert_eq!(found.lost.leave_out.len(), 41);
    assert_gap(&found);
    let bench = rumba(preset("81", &bench.machine));
    let found = identified(&bench);
    assert_eq!((found.columns.len(), found.rank, found.machine_rank), (96, 96, 81));
    assert_gap(&found);
    println!("condition {}", found.condition);
    // The thesis has 3900 at places of balls that it does not print.
    assert!((500.0..10_000.0).contains(&found.condition), "{}", found.condition);
}

/// The same, ch. 4: rank 105 with a scale bar, which tells one, and 84 of the machine.
#[test]
fn samba_tells_84_and_the_scale_bar_one_of_them() {
    let parameters = cubic(&machine("wCBXFZYSt"));
    let [with, without] = [true, false].map(|bar| identified(&samba(parameters.clone(), bar)));
    assert_eq!((with.columns.len(), with.rank, with.machine_rank), (143, 105, 84));
    assert_eq!((without.rank, without.machine_rank), (104, 83));
    assert_gap(&with);
    assert_gap(&without);
    let found = identified(&samba(preset("84", &machine("wCBXFZYSt")), true));
    assert_eq!((found.columns.len(), found.rank, found.machine_rank), (105, 105, 84));
    assert_gap(&found);
    println!("condition {}", found.condition);
    assert!((500.0..10_000.0).contains(&found.condition), "{}", found.condition);
}

/// Probings in which C never turns: what C has for offsets is where the balls are.
#[test]
fn an_axis_that_never_turned_is_named() {
    let mut bench = samba(named("EX0C EB0C EX0S EXX1 EYY1 EZZ1"), true);
    bench.data[0].targets.truncate(1);
    bench.data[0].lengths.clear();
    bench.data[0].observations.retain(|row| row.target == Some(0));
    let mut random = Random(3);
    for row in &mut bench.data[0].observations {
        row.reading.position = AxisVector::ZERO;
        row.reading.position.set_xyz(Vector::from_fn(|_, _| 100.0 * random.symmetric()));
    }
    bench.parameters = named("EX0C");
    bench.data[0].free.clear();
    assert_eq!(bench.lost(), ["EX0C is not separable from X of ball b1; C was at 1 position; at least 2 are needed"]);
    // Two balls both go with it.
    bench.data[0].targets.push("b2".into());
    bench.data[0].observations.iter_mut().step_by(2).for_each(|row| row.target = Some(1));
    assert_eq!(
        bench.lost(),
        ["EX0C is not separable from X of ball b1 and X of ball b2; C was at 1 position; at least 2 are needed"]
    );
    let fault =
        fit(&bench.machine, &ErrorModel::default(), &bench.parameters, &bench.data, FitOptions { robust: true });
    let Some(FitError::NotIdentified(lost)) = fault.err() else { panic!("told") };
    assert_eq!(lost.confused.iter().map(|one| one.sentence.clone()).collect::<Vec<_>>(), bench.lost());
    assert_eq!(lost.confused[0].remedy, "index C to at least 1 more angle, or leave it out of the model");
}

/// Ball-bar circles: in one sense backlash is still told (each axis goes both ways); where no axis ever turns round it is not. All gains
/// together are the length of the bar.
#[test]
fn ball_bars_do_not_tell_scale_from_length() {
    let mut bench = circles(24, &[1.0]);
    bench.parameters = named("EXX1 EYY1 EZZ1");
    assert_eq!(
        bench
            .lost()
            .iter()
            .map(|sentence| sentence.starts_with("EZZ1 is not separable from EXX1, EYY1, "))
            .collect::<Vec<_>>(),
        [true],
        "{:?}",
        bench.lost()
    );
    bench.parameters = named("EYY1 EZZ1 EXXb EYYb EZZb");
    assert_eq!(bench.lost(), [""; 0]);
    // The ball's place across each circle, which does no harm.
    let loose = identified(&bench).lost.unknowns;
    assert_eq!(loose.len(), 6);
    assert_eq!(loose[0], "X of the table ball of set-up 0 has no effect on the measurements");
    for row in &mut bench.data[0].observations {
        row.reading.state.direction[0] = 1;
    }
    // A constant of X is the X of every table ball that X moves about.
    let lost = bench.lost();
    assert_eq!(lost.len(), 1);
    assert!(
        lost[0].starts_with(
            "EXXb is not separable from X of the table ball of set-up 2, X of the table ball of set-up 3, "
        ),
        "{}",
        lost[0]
    );
    assert!(lost[0].ends_with("; X was approached in one direction only"), "{}", lost[0]);
}

/// Degrees beyond the number of positions follow from the lower ones.
#[test]
fn a_degree_needs_its_positions() {
    let mut bench = crate::calibrate::plates();
    bench.parameters = named("EXX1 EXX2 EXX3");
    assert_eq!(bench.lost(), [""; 0]);
    for row in &mut bench.data[0].observations {
        row.reading.position.0[0] = (row.reading.position.0[0] / 150.0).round() * 150.0;
    }
    let lost = bench.lost();
    assert_eq!(lost.len(), 1, "{lost:?}");
    assert!(lost[0].starts_with("EXX3 is not separable from EXX1"), "{lost:?}");
    // What no reading sees.
    bench.parameters = named("EZZ1 ECX2 EX0S");
    bench.data[0].free.clear();
    bench.data[0].observations.iter_mut().for_each(|row| {
        row.values = [None, None, Some(0.0)];
    });
    let lost = bench.lost();
    assert_eq!(lost, ["ECX2 and EX0S have no effect on the measurements"]);
}

/// Prints how long fits take; in an optimized build the limits are asserted.
#[test]
fn fits_are_quick() {
    let horizontal = machine("wCBXFZYSt");
    let thirteen = samba(preset("mayer-13", &horizontal), true);
    let cubic = samba(preset("84", &horizontal), true);
    // 20,000 rows of 60 parameters and unknowns of the set-ups.
    let mut circles = circles(1667, &[1.0, -1.0]);
    circles.parameters = named(
        "EC0Y EA0Z EB0Z EYY1 EZZ1 EXXb EYYb EZZb EXX2 EXX3 EYY2 EYY3 EZZ2 EZZ3 EYX2 EYX3 EZX2 EZX3 EXY2 EXY3 EZY2 EZY3 \
         EXZ2 EXZ3 EYZ2 EYZ3",
    );
    for component in ["EXX", "EYY", "EZZ", "EYX", "EZX", "EXY", "EZY", "EXZ", "EYZ"] {
        circles.parameters.extend(named(&[-120, -60, 60, 120].map(|at| format!("{component}2@{at}")).join(" ")));
    }
    for axis in ["X", "Y", "Z"] {
        circles
            .parameters
            .extend(named(&["A", "B", "C"].map(|letter| format!("E{letter}{axis}1 E{letter}{axis}2")).join(" ")));
    }
    // Some of these cannot be told on circles.
    let lost: Vec<String> =
        circles.lost().iter().filter_map(|sentence| Some(sentence.split_once(' ')?.0.to_owned())).collect();
    circles.parameters.retain(|parameter| !lost.contains(&parameter.to_string()));
    circles.parameters.truncate(60);
    assert_eq!(circles.parameters.len(), 60, "not told: {lost:?}");
    circles.errors = crate::calibrate::errors(&circles.parameters, 0.01, &mut Random(31));
    for (name, bench, limit) in [("13", thirteen, 0.05), ("84", cubic, 1.0), ("60 x 20,000", circles, 1.0)] {
        let (data, _) = bench.measured(1e-3, 0.02, &mut Random(9));
        for robust in [false, true] {
            let start = Instant::now();
            let found = bench.fit(&data, robust);
            let seconds = start.elapsed().as_secs_f64();
            println!(
                "{name}, robust {robust}: {seconds:.4} s, {} rounds, {} columns, condition {:.0}",
                found.rounds,
                found.estimates.len(),
                found.condition
            );
            assert!(cfg!(debug_assertions) || seconds < limit, "{name}: {seconds} s");
        }
    }
}
