//! Diagnostics of a fit that does not converge.

use super::*;
use crate::calibrate::bench;

/// Ten readings of a component, described as 1 µm, each with this residual and a weight.
fn unsettled(residual: f64, weight: impl Fn(usize) -> f64) -> Option<Unsettled> {
    let machine = bench::machine();
    let rows = (0..10).fold("X,Y,Z,component,value_um\n".to_owned(), |rows, x| rows + &format!("{x},0,0,EXX,0\n"));
    let data = [bench::table(&machine, &rows, "[measurement]\nkind = \"direct\"\nsigma_um = 1\n")];
    let design = Design::new(&machine, &data, &[] as &[Parameter]);
    let judged = judge(&machine, &ErrorModel::default(), &[], &data).unwrap();
    let mut rounds = Rounds::new(&design, &data, FitOptions { robust: true }, &judged);
    let line = |row| ReadingEquation { residual, set: 0, origin: EquationOrigin::Row(row), is_angle: false };
    rounds.lines = (0..10).map(line).collect();
    rounds.weights = (0..10).map(weight).collect();
    rounds.noise.update(&rounds.lines, &rounds.used, false);
    rounds.unsettled()
}

#[test]
fn a_measurement_is_named_that_leaves_more_than_it_says_or_counts_too_little() {
    // Twice the described value and two rejected rows of ten are not a reason.
    assert_eq!(unsettled(2e-3, |row| if row < 2 { 0.0 } else { 1.0 }), None);
    let found = unsettled(5e-3, |_| 1.0).unwrap();
    assert!(found.set == 0 && (found.times - 5.0).abs() < 1e-9 && found.rejected == [0, 10], "{found:?}");
    let found = unsettled(1e-3, |row| if row < 3 { 0.0 } else { 1.0 }).unwrap();
    assert!((found.times - 1.0).abs() < 1e-9 && found.rejected == [3, 10], "{found:?}");
}
