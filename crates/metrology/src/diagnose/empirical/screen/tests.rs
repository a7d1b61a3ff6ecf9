//! Tests: shapes over a plate explain all of a matching effect.

use super::*;
use crate::diagnose::bench;

/// Points at 24 by 12 positions in X and Y, 10 mm apart, with a value at each.
fn found(
    at: impl Fn(f64, f64) -> f64,
    look: impl Fn(&Empirical, &[[f64; 2]], &mut Vec<(f64, Form)>),
) -> Vec<(f64, Form)> {
    let machine = bench::machine();
    let places: Vec<[f64; 2]> = (0..288).map(|k| [f64::from(10 * (k % 24)), f64::from(10 * (k / 24))]).collect();
    let rows: String = places.iter().map(|[x, y]| format!("{x},{y},0,0\n")).collect();
    let description = "[measurement]\nkind = \"displacement\"\nsigma_um = 1\n";
    let sets = [bench::table(&machine, &format!("X,Y,Z,dx_um\n{rows}"), description)];
    let empirical = Empirical::new(&bench::scene(&machine, &sets));
    let sums: Vec<[f64; 2]> = places.iter().map(|&[x, y]| [at(x, y), 1.0]).collect();
    let mut out = Vec::new();
    look(&empirical, &sums, &mut out);
    out.sort_by(|one, other| other.0.total_cmp(&one.0));
    out
}

#[test]
fn what_goes_with_one_axis_on_one_side_of_another_says_all_of_it() {
    // Y from −5.5 to 5.5 in the upper half of X: 12 · Σ y² = 12 · 143.
    let of = |x: f64, y: f64| if x > 115.0 { (y - 55.0) / 10.0 } else { 0.0 };
    let found = found(of, |all, sums, out| all.forms((0, 1), (sums, sums), 0.0, out));
    let is_it = |(_, form): &&(f64, Form)| matches!(form, Form::Beyond(0, 1, 12, ..));
    let (worth, form) = found.iter().find(is_it).unwrap();
    assert!((worth - 1716.0).abs() < 1e-9, "{worth}");
    assert_eq!(*form, Form::Beyond(0, 1, 12, 115.0, 1.0));
}

#[test]
fn a_bump_is_found_where_it_is() {
    let bump = |x: f64, y: f64| (-((x - 150.0).powi(2) + (y - 60.0).powi(2)) / (2.0 * 20.0 * 20.0)).exp();
    let found = found(bump, |all, sums, out| all.bumps(sums, 0.0, out));
    let [(worth, Form::Bump(0, 1, at, wide))] = found.as_slice() else { panic!("{found:?}") };
    assert!((at[0] - 150.0).abs() < 5.0 && (at[1] - 60.0).abs() < 5.0 && (15.0..25.0).contains(wide), "{at:?} {wide}");
    // The sum of its squares over positions 10 mm apart is π 20² / 10² if it is far from the ends.
    assert!((worth / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.05, "{worth}");
}

#[test]
fn a_product_says_all_of_itself_beside_both() {
    let of = |x: f64, y: f64| (x - 115.0) * (y - 55.0) * 1e-3;
    let [both, all] = [0.0, 1.0].map(|more| {
        let found = found(
            |x, y| of(x, y) + more * x * 1e-2,
            |all, sums, out| {
                out.push((1.0, Form::Product(0, 1)));
                all.products(sums, 0.0, out);
            },
        );
        found[0].0
    });
    // Σ x² Σ y² over 24 and 12 positions about their middles, (n³ − n)/12 each: 1150 · 100 · 143 · 100 · 1e-6; plus 12 · 1150 · 100 · 1e-4 of X
    // alone.
    assert!((both - 1644.5).abs() < 1e-6, "{both}");
    assert!((all - 1644.5 - 138.0).abs() < 1e-6, "{all}");
}
