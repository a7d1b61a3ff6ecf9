//! Simulate and fit: without noise the truth comes back, with noise it is inside the uncertainties, with gross errors too.
#![allow(clippy::print_stdout, reason = "shares and spreads are worth reading where a test fails")]

use ncfix_base::geometry::AXES;
use ncfix_metrology::calibrate::{Column, Estimate, quality};
use ncfix_metrology::measure::data::Observation;
use ncfix_metrology::measure::kind::Unknown;

use crate::calibrate::{Bench, benches};
use crate::model::Random;

fn name(bench: &Bench) -> &'static str {
    bench.data[0].kind.name
}

/// Estimates with their true values, but for places across circles, which move nothing.
fn told<'a>(estimates: &'a [Estimate], truth: &'a [f64]) -> impl Iterator<Item = (&'a Estimate, f64)> {
    let all = estimates.iter().zip(truth.iter().copied());
    all.filter(|(estimate, _)| {
        assert!(estimate.sigma.is_finite() || matches!(estimate.column, Column::Unknown(_, Unknown::Centre(..))));
        estimate.sigma.is_finite()
    })
}

#[test]
fn without_noise_the_truth_comes_back() {
    for bench in benches() {
        let name = name(&bench);
        assert_eq!(bench.lost(), [""; 0], "{name}");
        let (data, _) = bench.measured(0.0, 0.0, &mut Random(1));
        for robust in [false, true] {
            println!("{name}, robust {robust}");
            let found = bench.fit(&data, robust);
            let whole = found.estimates.iter().fold(0.0, |most, estimate| f64::max(most, estimate.effect_mm));
            assert!(whole > 0.01, "errors that are worth a fit");
            for (estimate, truth) in told(&found.estimates, &bench.truth()) {
                let error = (estimate.value - truth).abs();
                // Tip effect of a parameter; unknowns themselves are lengths or angles at arms below 1 m.
                let effect =
                    if estimate.effect_mm > 0.0 { error / estimate.value.abs() * estimate.effect_mm } else { error };
                assert!(effect < 1e-9 * whole, "{name} {}: {effect:e}", estimate.column.name(&data));
            }
            assert!(found.residuals.iter().all(|(.., residual, _)| residual.abs() < 1e-9));
            assert!(found.rejected().is_empty());
        }
    }
}

/// Shares of estimates within 1 and 3 σ, and of the noise: mean of the estimated one, mean of held-out residuals.
struct Tally {
    within: [f64; 2],
    sigma: f64,
    held_out: f64,
    kept: f64,
    missed: usize,
}

fn tally(bench: &Bench, noise_mm: f64, outliers: f64, repetitions: u64) -> Tally {
    let truth = bench.truth();
    let mut within = [0.0; 2];
    let (mut count, mut sigma, mut held_out, mut kept, mut missed) = (0.0, 0.0, 0.0, 0.0, 0);
    for seed in 0..repetitions {
        let mut random = Random(1000 * seed + 7);
        let (data, off) = bench.measured(noise_mm, outliers, &mut random);
        let found = bench.fit(&data, outliers > 0.0);
        for (estimate, truth) in told(&found.estimates, &truth) {
            let error = (estimate.value - truth).abs() / estimate.sigma;
            within[0] += f64::from(u8::from(error < 1.0));
            within[1] += f64::from(u8::from(error < 3.0));
            count += 1.0;
        }
        sigma += found.sigmas[0] / noise_mm;
        let rejected = found.rejected();
        missed += off.iter().filter(|row| !rejected.contains(row)).count();
        let rows = data.iter().map(|set| set.observations.len()).sum::<usize>() as f64;
        kept += 1.0 - rejected.iter().filter(|row| !off.contains(row)).count() as f64 / rows;
        // Data of the same plan that the fit has not seen.
        if seed % 20 == 0 {
            let (other, _) = bench.measured(noise_mm, 0.0, &mut random);
            let left = quality(&bench.machine, &found.errors, &other[0]).unwrap().left[0];
            // Angles have a thousandth of the noise, which adds nothing to the sum of squares.
            let is_angle = |row: &Observation| row.component.is_some_and(|name| name.direction.is_rotation());
            let rows = &other[0].observations;
            let lengths = rows.iter().filter(|row| !is_angle(row)).count() as f64 / rows.len() as f64;
            held_out += left / lengths.sqrt() / noise_mm * 20.0;
        }
    }
    let all = repetitions as f64;
    Tally {
        within: within.map(|sum| sum / count),
        sigma: sigma / all,
        held_out: held_out / all,
        kept: kept / all,
        missed,
    }
}

pub(crate) fn check(bench: &Bench, outliers: f64) {
    let name = name(bench);
    let found = tally(bench, 1e-3, outliers, 200);
    println!(
        "{name}, {outliers}: within 1σ {:.4}, 3σ {:.4}; σ {:.4}; held out {:.3}; kept {:.4}; missed {}",
        found.within[0], found.within[1], found.sigma, found.held_out, found.kept, found.missed
    );
    assert!(found.within[1] >= 0.99, "{name}: {} within 3 σ", found.within[1]);
    assert!((0.65..0.72).contains(&found.within[0]), "{name}: {} within 1 σ", found.within[0]);
    assert!((0.97..1.03).contains(&found.sigma), "{name}: σ of readings {}", found.sigma);
    assert!((0.9..1.15).contains(&found.held_out), "{name}: held out {}", found.held_out);
    assert!(found.kept > 0.995, "{name}: good rows rejected");
    assert_eq!(found.missed, 0, "{name}: gross errors not rejected");
}

#[test]
fn plates_with_noise() {
    let bench = crate::calibrate::plates();
    check(&bench, 0.0);
    check(&bench, 0.02);
}

#[test]
fn circles_with_noise() {
    let bench = crate::calibrate::circles(24, &[1.0, -1.0]);
    check(&bench, 0.0);
    check(&bench, 0.02);
}

#[test]
fn probings_with_noise() {
    let bench = &benches()[2];
    check(bench, 0.0);
    check(bench, 0.02);
}

#[test]
fn lines_with_noise() {
    let bench = crate::calibrate::lines();
    check(&bench, 0.0);
    check(&bench, 0.02);
}

#[test]
fn five_axis_benches_turn_their_axes() {
    let bench = &benches()[2];
    let turned = AXES.iter().filter(|axis| axis.is_rotary());
    let turned = turned.filter(|axis| bench.data[0].observations.iter().any(|row| row.reading.position[**axis] != 0.0));
    assert_eq!(turned.count(), 2);
}
