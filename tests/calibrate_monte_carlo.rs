//! Repetitions of a fit on simulated readings scatter as the uncertainties say, and say so where they do not.

use ncfix_metrology::calibrate::{Fit, FitOptions, MonteCarlo, monte_carlo};
use ncfix_metrology::measure::data::DataSet;

use crate::calibrate::{Bench, benches};
use crate::model::Random;

fn repeated(bench: &Bench, fit: &Fit, data: &[DataSet], how: [u64; 2]) -> MonteCarlo {
    let mut last = 0;
    let options = FitOptions { robust: false };
    let found = monte_carlo(&bench.machine, &bench.parameters, data, fit, options, how, &mut |done| {
        assert_eq!(done, last + 1);
        last = done;
    });
    assert_eq!(last, how[0]);
    found.unwrap()
}

/// Probings read positions, not values, as in their files.
fn without_values(mut data: Vec<DataSet>) -> Vec<DataSet> {
    for set in data.iter_mut().filter(|set| set.kind.name == "probe") {
        set.observations.iter_mut().for_each(|row| row.values = [None; 3]);
    }
    data
}

#[test]
fn repetitions_scatter_as_the_uncertainties_say() {
    for mut bench in benches() {
        // Without a described uncertainty every repetition estimates its own.
        bench.data.iter_mut().for_each(|set| set.sigma = Some(2e-3));
        bench.data.iter_mut().for_each(|set| set.sigma_rad = Some(2e-6));
        let data = without_values(bench.measured(2e-3, 0.0, &mut Random(12)).0);
        let mut fit = bench.fit(&data, false);
        let found = repeated(&bench, &fit, &data, [60, 3]);
        assert_eq!((found.runs, found.failed), (60, 0));
        let contradicted = |fit: &Fit| {
            let all = fit.estimates.iter().zip(&found.spreads);
            all.filter(|(one, spread)| found.contradicts(**spread, one.sigma)).count()
        };
        assert_eq!(contradicted(&fit), 0, "{}", bench.data[0].name);
        // Twice the uncertainty is half of the scatter: 50 % are not within 25 % and 28 %. Three times is 67 %.
        let loose = fit.estimates.iter().filter(|one| one.sigma.is_infinite()).count();
        fit.estimates.iter_mut().for_each(|one| one.sigma *= 3.0);
        assert_eq!(contradicted(&fit), fit.estimates.len() - loose);
    }
}

#[test]
fn the_same_seed_gives_the_same_scatter() {
    let bench = &benches()[2];
    let data = without_values(bench.measured(1e-3, 0.0, &mut Random(12)).0);
    let fit = bench.fit(&data, false);
    let one = repeated(bench, &fit, &data, [12, 3]);
    assert_eq!(repeated(bench, &fit, &data, [12, 3]), one);
    assert_ne!(repeated(bench, &fit, &data, [12, 4]).spreads, one.spreads);
}
