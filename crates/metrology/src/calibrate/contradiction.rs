//! Parameters for which two files of a fit have different values, beyond their uncertainties.
//!
//! A fit takes a parameter as the same in all files. Here one file after the other may have its own value of one parameter, while all others stay common. Its
//! difference from the value of the other files is a score test of the common fit (Rao, Mathematical Proceedings of the Cambridge Philosophical Society 44,
//! 1948). A parameter with a certain difference then has a value in each file, and the search goes on for the other parameters.

use nalgebra::DMatrix;

use crate::measure::data::DataSet;
use ncfix_base::numeric::student;
use ncfix_machine::machine::Machine;

use super::by_file::{ReducedFile, by_file, inverse_of};
use super::effect::Parameter;
use super::equivalent::tip_effects;
use super::fit::{Fit, FitOptions};

/// Chance of a difference of four standard deviations of a normal distribution, in either direction. A fit has tens of files and parameters: with three
/// (0.3 %), one fit in ten would have a false difference.
const CHANCE: f64 = 6.334e-5;
/// Differences that displace the tip by less do not matter, root mean square over the readings, mm: the resolution of the instruments of a shop.
const SMALL_MM: f64 = 1e-4;
/// Share of the information of a file about a parameter that must remain beside the others.
const LEAST_SHARE: f64 = 1e-7;
/// Maximum number of parameters with contradictions.
const MOST: usize = 6;
/// Maximum number of multiplications of one test, which is some seconds.
const LONGEST: f64 = 1e10;

/// A parameter for which two files have different values.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// Index of the parameter in the fit.
    pub parameter: usize,
    /// The two files: index, value and standard uncertainty, mm, rad, per power.
    pub files: [FileValue; 2],
    /// Their difference in combined standard uncertainties.
    pub sigmas: f64,
}

/// The value of a parameter in one file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FileValue {
    /// Index of the file.
    pub file: usize,
    /// mm, rad, per power.
    pub value: f64,
    /// Standard uncertainty.
    pub sigma: f64,
}

/// The parameters for which files contradict each other, the most certain first.
#[must_use]
pub fn contradictions(
    machine: &Machine,
    parameters: &[Parameter],
    data: &[DataSet],
    options: FitOptions,
    fit: &Fit,
) -> Vec<Contradiction> {
    let size = (parameters.len() + data.len()) as f64;
    if data.len() < 2 || parameters.is_empty() || size.powi(3) * data.len() as f64 > LONGEST {
        return Vec::new();
    }
    let Some(files) = by_file(machine, fit, parameters, data, options) else { return Vec::new() };
    let effects = tip_effects(machine, &fit.errors, parameters, data);
    let test = HomogeneityTest { files: &files, parameters, effects: &effects };
    let mut apart: Vec<[usize; 2]> = Vec::new();
    while apart.len() < MOST {
        let own: Vec<usize> = apart.iter().map(|[parameter, _]| *parameter).collect();
        let Some(found) = test.solved(&own).and_then(|solved| test.largest(&solved, &own)) else { break };
        apart.push(found);
    }
    let own: Vec<usize> = apart.iter().map(|[parameter, _]| *parameter).collect();
    let Some(solved) = test.solved(&own) else { return Vec::new() };
    apart.iter().filter_map(|&[parameter, file]| test.pair(&solved, fit, parameter, file)).collect()
}

struct HomogeneityTest<'a> {
    files: &'a [ReducedFile],
    parameters: &'a [Parameter],
    /// Tip motion per unit of each parameter, mm.
    effects: &'a [f64],
}

/// A common fit in which some parameters have a value in each file.
struct SplitFit {
    /// The unknown of each parameter, for each file; `None` if the file does not show it.
    places: Vec<Vec<Option<usize>>>,
    covariance: DMatrix<f64>,
    /// Unknowns, then their changes by certificates.
    values: DMatrix<f64>,
}

impl SplitFit {
    /// Difference of two unknowns, and its variance with that of certificates.
    fn difference(&self, one: usize, other: usize) -> [f64; 2] {
        let of = |column: usize| self.values[(one, column)] - self.values[(other, column)];
        let own = self.covariance[(one, one)] + self.covariance[(other, other)] - 2.0 * self.covariance[(one, other)];
        [of(0), own + (1..self.values.ncols()).map(|column| of(column).powi(2)).sum::<f64>()]
    }

    /// Standard uncertainty of an unknown.
    fn sigma(&self, one: usize) -> f64 {
        let certified = (1..self.values.ncols()).map(|column| self.values[(one, column)].powi(2)).sum::<f64>();
        (self.covariance[(one, one)] + certified).sqrt()
    }
}

impl HomogeneityTest<'_> {
    /// Information of a file about a parameter.
    fn information(&self, file: usize, parameter: usize) -> f64 {
        self.files[file].normal[(parameter, parameter)]
    }

    /// Information of the file that shows a parameter best.
    fn most(&self, parameter: usize) -> f64 {
        (0..self.files.len()).map(|file| self.information(file, parameter)).fold(0.0, f64::max)
    }

    /// The common fit in which these parameters have a value in each file.
    fn solved(&self, apart: &[usize]) -> Option<SplitFit> {
        let mut places = vec![vec![None; self.parameters.len()]; self.files.len()];
        let mut count = 0;
        for parameter in 0..self.parameters.len() {
            let least = LEAST_SHARE * self.most(parameter);
            for (file, own) in places.iter_mut().enumerate() {
                let is_apart = apart.contains(&parameter);
                if !is_apart {
                    own[parameter] = Some(count);
                } else if self.information(file, parameter) > least {
                    own[parameter] = Some(count);
                    count += 1;
                }
            }
            count += usize::from(!apart.contains(&parameter));
        }
        let mut normal = DMatrix::zeros(count, count);
        let mut sides = DMatrix::zeros(count, self.files.first()?.sides.ncols());
        for (file, own) in self.files.iter().zip(&places) {
            let own: Vec<(usize, usize)> =
                own.iter().enumerate().filter_map(|(parameter, place)| Some((parameter, (*place)?))).collect();
            for &(parameter, place) in &own {
                (0..sides.ncols()).for_each(|side| sides[(place, side)] += file.sides[(parameter, side)]);
                own.iter().for_each(|&(other, at)| normal[(place, at)] += file.normal[(parameter, other)]);
            }
        }
        let covariance = inverse_of(&normal)?;
        let values = &covariance * sides;
        Some(SplitFit { places, covariance, values })
    }

    /// The parameter and the file with the most certain difference from the other files.
    fn largest(&self, solved: &SplitFit, apart: &[usize]) -> Option<[usize; 2]> {
        let mut best: Option<(f64, [usize; 2])> = None;
        for parameter in
            (0..self.parameters.len()).filter(|one| !apart.contains(one) && self.parameters[*one].is_linear())
        {
            for file in 0..self.files.len() {
                let Some([difference, variance]) = self.score(solved, parameter, file) else { continue };
                let sigmas = difference.abs() / variance.sqrt();
                let effect_mm = difference.abs() * self.effects.get(parameter).copied().unwrap_or(0.0);
                // A reading of a location error itself has no place, and no displacement there.
                let is_small = effect_mm > 0.0 && effect_mm < SMALL_MM;
                let is_chance = || student::two_sided(sigmas, self.freedom(parameter, file)) > CHANCE;
                if is_small || best.is_some_and(|(most, _)| most >= sigmas) || is_chance() {
                    continue;
                }
                best = Some((sigmas, [parameter, file]));
            }
        }
        best.map(|(_, found)| found)
    }

    /// Degrees of freedom of a difference: the lesser of those of the file and of the one that shows the parameter best among the others.
    fn freedom(&self, parameter: usize, file: usize) -> f64 {
        let others = (0..self.files.len()).filter(|other| *other != file);
        let best = others
            .max_by(|one, other| self.information(*one, parameter).total_cmp(&self.information(*other, parameter)));
        best.map_or(0.0, |best| self.files[best].freedom).min(self.files[file].freedom)
    }

    /// Difference of the value of a parameter in a file from that of the others, and its variance; `None` if one of them does not show it.
    fn score(&self, solved: &SplitFit, parameter: usize, file: usize) -> Option<[f64; 2]> {
        let (own, places) = (&self.files[file], &solved.places[file]);
        let information = own.normal[(parameter, parameter)];
        let factors: Vec<(usize, f64)> = places
            .iter()
            .enumerate()
            .filter_map(|(other, place)| Some(((*place)?, own.normal[(parameter, other)])))
            .collect();
        let common: f64 = factors
            .iter()
            .map(|(one, factor)| {
                factors.iter().map(|(other, by)| by * solved.covariance[(*one, *other)]).sum::<f64>() * factor
            })
            .sum();
        let alone = information - common;
        if information <= LEAST_SHARE * self.most(parameter) || alone <= LEAST_SHARE * information {
            return None;
        }
        let difference = |side: usize| {
            let predicted: f64 = factors.iter().map(|(place, factor)| factor * solved.values[(*place, side)]).sum();
            (own.sides[(parameter, side)] - predicted) / alone
        };
        let certified: f64 = (1..own.sides.ncols()).map(|side| difference(side).powi(2)).sum();
        Some([difference(0), 1.0 / alone + certified])
    }

    /// The values of a parameter in a file, and in the one that differs from it with most certainty.
    fn pair(&self, solved: &SplitFit, fit: &Fit, parameter: usize, file: usize) -> Option<Contradiction> {
        let place = |file: usize| solved.places[file][parameter];
        let own = place(file)?;
        let sigmas = |other: usize| {
            let [difference, variance] = solved.difference(own, other);
            difference.abs() / variance.sqrt()
        };
        let others = (0..self.files.len()).filter(|other| *other != file);
        let others = others.filter_map(|other| Some((other, sigmas(place(other)?))));
        let (other, sigmas) = others.max_by(|one, other| one.1.total_cmp(&other.1))?;
        let start = fit.estimates.get(parameter)?.value;
        let of_file = |file: usize| {
            let own = place(file)?;
            Some(FileValue { file, value: start + solved.values[(own, 0)], sigma: solved.sigma(own) })
        };
        let mut files = [of_file(file)?, of_file(other)?];
        files.sort_by_key(|one| one.file);
        Some(Contradiction { parameter, files, sigmas })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::{bench, fit};
    use crate::measure::noise::Noise;
    use ncfix_model::{ErrorModel, ParameterName};
    use std::fmt::Write as _;

    fn parameters(names: &[&str]) -> Vec<Parameter> {
        names.iter().map(|name| name.parse::<ParameterName>().unwrap().into()).collect()
    }

    /// A laser along X in both directions: 12 µm/m and ± half of a reversal value of 5 µm, changed by these amounts.
    fn laser(noise: &mut Noise, description: &str, targets: u32, [scale, half]: [f64; 2]) -> DataSet {
        let mut rows = "X,Y,Z,component,X_dir,value_um\n".to_owned();
        for side in [1.0, -1.0] {
            for target in 0..targets {
                let x = 600.0 * f64::from(target) / f64::from(targets - 1);
                let um = (12e-3 + scale) * x + (2.5 + half) * side + 0.5 * noise.normal() + 7.0;
                let _ = writeln!(rows, "{x},0,0,EXX,{side},{um:.3}");
            }
        }
        let text = format!("[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\n{description}");
        bench::table(&bench::machine(), &rows, &text)
    }

    /// A grid over X and Y without directions, with a squareness of 30 µrad: Y turns, so that X is shifted by −30e-3 · y µm.
    fn grid(noise: &mut Noise) -> DataSet {
        let mut rows = "X,Y,Z,X_dir,Y_dir,dx_um,dy_um\n".to_owned();
        for place in 0..25 {
            let [x, y] = [150.0 * f64::from(place % 5), 100.0 * f64::from(place / 5)];
            let dx = 12e-3 * x + 2.5 - 30e-3 * y + 0.3 * noise.normal();
            let dy = -8e-3 * y + 0.3 * noise.normal();
            let _ = writeln!(rows, "{x},{y},0,1,1,{dx:.3},{dy:.3}");
        }
        bench::table(&bench::machine(), &rows, "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\n")
    }

    fn found(data: &[DataSet], names: &[&str]) -> Vec<Contradiction> {
        let (machine, names, options) = (bench::machine(), parameters(names), FitOptions { robust: true });
        let fit = fit(&machine, &ErrorModel::default(), &names, data, options).unwrap();
        contradictions(&machine, &names, data, options, &fit)
    }

    const MODEL: [&str; 4] = ["EXX1", "EXXb", "EYY1", "EC0Y"];

    #[test]
    fn consistent_files_do_not_contradict_each_other() {
        let mut noise = Noise::new(5);
        let mut false_alarms = 0;
        for number in 0..200 {
            let stated = if number % 2 == 0 { "sigma_um = 0.5\n" } else { "" };
            let targets = if number % 4 < 2 { 11 } else { 4 };
            let one = laser(&mut noise, stated, 11, [0.0; 2]);
            let other = laser(&mut noise, stated, targets, [0.0; 2]);
            false_alarms += usize::from(!found(&[one, other, grid(&mut noise)], &MODEL).is_empty());
        }
        // 200 sets with four parameters and three files: 0.15 chances of four standard deviations are expected.
        assert!(false_alarms <= 1, "{false_alarms} of 200");
    }

    #[test]
    fn a_file_of_another_state_is_found_by_its_parameter() {
        let mut noise = Noise::new(6);
        for number in 0..20 {
            let stated = if number % 2 == 0 { "sigma_um = 0.5\n" } else { "" };
            let one = laser(&mut noise, stated, 11, [0.0; 2]);
            // A reversal value that is larger by 4 µm, so 4.5 instead of 2.5 on either side.
            let other = laser(&mut noise, stated, 11, [0.0, 2.0]);
            let all = found(&[one.clone(), grid(&mut noise), other], &MODEL);
            assert_eq!(all.len(), 1, "{number}: {all:?}");
            assert_eq!((all[0].parameter, all[0].files.map(|of| of.file)), (1, [0, 2]));
            // 22 readings of 0.5 µm: each half has 0.5/√22 = 0.107 µm.
            for (of, truth) in all[0].files.iter().zip([2.5e-3, 4.5e-3]) {
                assert!((of.value - truth).abs() < 4e-4 && (of.sigma - 0.107e-3).abs() < 0.06e-3, "{number}: {of:?}");
            }
            assert!((8.0..25.0).contains(&all[0].sigmas), "{number}: {all:?}");
            // A scale that differs by 10 µm/m.
            let other = laser(&mut noise, stated, 11, [10e-3, 0.0]);
            let all = found(&[one, other], &["EXX1", "EXXb"]);
            assert!(all.len() == 1 && all[0].parameter == 0, "{number}: {all:?}");
        }
    }
}
