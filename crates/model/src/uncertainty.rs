//! Variations of an error model within its uncertainty: one model for each independent source of uncertainty.
//!
//! The covariance of the parameters is C = L·Lᵀ. A row of L belongs to a parameter, a column to an independent source of uncertainty with unit variance. The
//! model with one column added is the model after one standard deviation of this source, so the same forward function gives its effect on the tool. An error
//! that is known as a whole (`EXX`) may vary by any smooth function of this standard deviation along its axis; a few waves over the travel stand for it.

use std::f64::consts::{FRAC_PI_2, PI};

use super::ErrorModel;
use super::motion::periodic::Periodic;
use super::motion::table::ErrorTable;
use super::motion::{EntryFunction, MotionError};
use super::name::{ErrorKind, ErrorName};
use super::parameter::{ComponentTerm, ParameterName};
use super::source::Parameter;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::{Machine, Uncertainty, UncertaintyRow};

/// Waves over the travel of an axis that stand for a whole error: pairs of sine and cosine in addition to the constant.
const WAVES: usize = 2;
/// Points of a wave over the travel.
const POINTS: usize = 33;
/// Travel of an axis without limits, mm, and half a turn, rad.
const UNLIMITED: [f64; 2] = [1000.0, PI];

/// Parameter of the error model with an uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UncertainParameter {
    /// Number of a location or motion error.
    Number(ParameterName),
    /// Motion error as a whole.
    Whole(ErrorName),
    /// Wave of a motion error: each of its sine and its cosine.
    Wave {
        /// Motion error.
        name: ErrorName,
        /// Period, mm or rad.
        period: f64,
    },
    /// Parameter of an effect: indices of the effect and of the parameter in it, and the factor to the unit of the file.
    OfEffect {
        /// Index in [`ErrorModel::effects`].
        effect: usize,
        /// Index of the parameter in the effect.
        index: usize,
        /// Factor from its value to that of the file.
        factor: f64,
    },
}

/// Receives an effect of a parameter.
pub type VisitEffect<'v> = dyn FnMut(String, [usize; 2], &Parameter<'_>, f64) + 'v;

/// Calls `each` with every parameter of the effects of a model: its unique name (`load.EAX.coefficients[1]`; a second effect of one name is `load.EAX~2`),
/// the indices of the effect and of the parameter in it, the parameter and its value.
pub fn visit_effects(errors: &ErrorModel, each: &mut VisitEffect<'_>) {
    // The first two words of a name, and the effects that have them.
    let mut stems: Vec<(String, usize)> = Vec::new();
    for (number, effect) in errors.effects.iter().enumerate() {
        let mut index = 0;
        effect.boxed().visit_parameters(&mut |parameter, value| {
            let end = parameter.name.match_indices('.').nth(1).map_or(parameter.name.len(), |(at, _)| at);
            let (stem, rest) = parameter.name.split_at(end);
            if !stems.iter().any(|(known, owner)| known == stem && *owner == number) {
                stems.push((stem.to_owned(), number));
            }
            let before = stems.iter().filter(|(known, owner)| known == stem && *owner < number).count();
            let again = if before > 0 { format!("~{}", before + 1) } else { String::new() };
            each(format!("{stem}{again}{rest}"), [number, index], parameter, *value);
            index += 1;
        });
    }
}

impl UncertainParameter {
    /// Finds a parameter by its name in `[uncertainty]`.
    #[must_use]
    pub fn find(text: &str, errors: &ErrorModel) -> Option<UncertainParameter> {
        if let Ok(name) = text.parse::<ParameterName>() {
            return Some(UncertainParameter::Number(name));
        }
        if let Ok(name) = text.parse::<ErrorName>() {
            return (name.kind == ErrorKind::Motion).then_some(UncertainParameter::Whole(name));
        }
        if let Some(wave) = wave_by_name(text, errors) {
            return Some(wave);
        }
        let mut found = None;
        visit_effects(errors, &mut |name, [effect, index], parameter, _| {
            if name == text {
                let factor = parameter.written.map_or(1.0, |written| written.factor);
                found = Some(UncertainParameter::OfEffect { effect, index, factor });
            }
        });
        found
    }

    /// Returns the error component; `None` for a parameter of an effect.
    #[must_use]
    pub fn component(&self) -> Option<ErrorName> {
        match self {
            UncertainParameter::Number(name) => Some(name.component),
            UncertainParameter::Whole(name) | UncertainParameter::Wave { name, .. } => Some(*name),
            UncertainParameter::OfEffect { .. } => None,
        }
    }

    /// Returns the factor from mm, rad and powers of them to the unit of the file: µm and µrad for a location error, for a reversal (of which the parameter
    /// is half) and for a whole error; mm and rad per power for a coefficient.
    #[must_use]
    pub fn file_factor(&self) -> f64 {
        let of_deviation =
            |name: &ErrorName| if name.direction.is_rotation() { urad_from_rad(1.0) } else { um_from_mm(1.0) };
        match self {
            UncertainParameter::Number(name) => match name.term {
                ComponentTerm::Whole => of_deviation(&name.component),
                ComponentTerm::Backlash => 2.0 * of_deviation(&name.component),
                ComponentTerm::Coefficient(_) | ComponentTerm::Knot { .. } => 1.0,
            },
            UncertainParameter::Whole(name) | UncertainParameter::Wave { name, .. } => of_deviation(name),
            UncertainParameter::OfEffect { factor, .. } => *factor,
        }
    }

    /// Returns the unit of its number in the file; empty for a parameter of an effect, whose name has it.
    #[must_use]
    pub fn file_unit(&self) -> String {
        let of_deviation = |name: &ErrorName| if name.direction.is_rotation() { "µrad" } else { "µm" }.to_owned();
        match self {
            UncertainParameter::Number(name) => match name.term {
                ComponentTerm::Whole | ComponentTerm::Backlash => of_deviation(&name.component),
                ComponentTerm::Coefficient(_) | ComponentTerm::Knot { .. } => name.unit(),
            },
            UncertainParameter::Whole(name) | UncertainParameter::Wave { name, .. } => of_deviation(name),
            UncertainParameter::OfEffect { .. } => String::new(),
        }
    }

    /// Adds a change, in the unit of the file.
    fn add(&self, errors: &mut ErrorModel, change: f64) {
        let change = change / self.file_factor();
        match *self {
            UncertainParameter::Number(name) => {
                let value = name.get(errors) + change;
                name.set(errors, value);
            }
            UncertainParameter::OfEffect { effect, index, .. } => {
                let mut number = 0;
                if let Some(effect) = errors.effects.get_mut(effect) {
                    effect.visit_parameters(&mut |_, value| {
                        if number == index {
                            *value += change;
                        }
                        number += 1;
                    });
                }
            }
            UncertainParameter::Whole(_) | UncertainParameter::Wave { .. } => {}
        }
    }

    /// Returns the independent motion errors of one standard deviation, mm or rad; empty for a parameter that is a number of the model.
    fn apart(&self, machine: &Machine, sigma: f64) -> Vec<MotionError> {
        match *self {
            UncertainParameter::Whole(name) => waves(machine, name, sigma),
            UncertainParameter::Wave { name, period } => {
                let of = |phase_rad| Periodic { period, amplitude: sigma, phase_rad };
                let parts = [0.0, FRAC_PI_2].map(|phase| EntryFunction::Periodic(of(phase)));
                parts.map(|function| MotionError { name, function }).into()
            }
            UncertainParameter::Number(_) | UncertainParameter::OfEffect { .. } => Vec::new(),
        }
    }

    /// True if this parameter has the uncertainty of an entry: of a polynomial or a backlash through its numbers, of a wave through its period, of any
    /// other entry as a whole.
    fn is_of_entry(&self, entry: &MotionError) -> bool {
        let has_numbers = matches!(
            entry.function,
            EntryFunction::Polynomial(_) | EntryFunction::Piecewise(_) | EntryFunction::Backlash(_)
        );
        self.component() == Some(entry.name)
            && match (self, &entry.function) {
                (UncertainParameter::Whole(_), _) => true,
                (UncertainParameter::Wave { period, .. }, EntryFunction::Periodic(own)) => is_same(*period, own.period),
                (UncertainParameter::Number(_), _) => has_numbers,
                _ => false,
            }
    }
}

/// Between the name of an error and the period of its wave: `EXX~10`.
const OF_PERIOD: char = '~';
/// Periods are equal within this share.
const SAME_PERIOD: f64 = 1e-6;

fn is_same(period: f64, other: f64) -> bool {
    (period - other).abs() <= SAME_PERIOD * other.abs()
}

/// Returns the name of a wave in `[uncertainty]`: that of the error, and the period in mm or degrees.
#[must_use]
pub fn wave_name(name: ErrorName, period: f64) -> String {
    // Ten digits hide the rounding of a conversion between degrees and rad.
    let period: f64 = format!("{period:.9e}").parse().unwrap_or(period);
    format!("{name}{OF_PERIOD}{period}")
}

/// Finds a wave of the model by its name.
fn wave_by_name(text: &str, errors: &ErrorModel) -> Option<UncertainParameter> {
    let (name, period) = text.split_once(OF_PERIOD)?;
    let name: ErrorName = name.parse().ok()?;
    let period: f64 = period.parse().ok()?;
    let period = if name.axis()?.is_rotary() { period.to_radians() } else { period };
    let of_model = errors.motion.iter().filter(|entry| entry.name == name);
    let is_there = of_model.filter_map(period_of).any(|own| is_same(period, own));
    is_there.then_some(UncertainParameter::Wave { name, period })
}

/// Returns the period of a wave, mm or rad.
fn period_of(entry: &MotionError) -> Option<f64> {
    match &entry.function {
        EntryFunction::Periodic(wave) => Some(wave.period),
        _ => None,
    }
}

/// Returns the key of an entry in `[uncertainty]` for people: the error, for a wave with its period.
fn name_of_entry(entry: &MotionError) -> String {
    let is_rotary = entry.name.axis().is_some_and(|axis| axis.is_rotary());
    let in_file = |period: f64| if is_rotary { period.to_degrees() } else { period };
    period_of(entry).map_or_else(|| entry.name.to_string(), |period| wave_name(entry.name, in_file(period)))
}

/// Returns the models after one standard deviation of each independent source of uncertainty.
#[must_use]
pub fn variations(machine: &Machine, errors: &ErrorModel, uncertainty: &Uncertainty) -> Vec<ErrorModel> {
    let known: Vec<(UncertainParameter, &UncertaintyRow)> = uncertainty
        .rows
        .iter()
        .filter_map(|(name, row)| Some((UncertainParameter::find(name, errors)?, row)))
        .filter(|(parameter, _)| {
            parameter.component().and_then(|name| name.axis()).is_none_or(|axis| machine.axis(axis).is_some())
        })
        .collect();
    let mut all = Vec::new();
    for cause in 0..uncertainty.causes() {
        let mut varied = errors.clone();
        let mut is_varied = false;
        for (parameter, row) in &known {
            let UncertaintyRow::Shared(row) = row else { continue };
            let Some(&part) = row.get(cause).filter(|part| **part != 0.0) else { continue };
            // The waves of a whole error are sources of their own, as are the parts of a wave; a list of one entry is a number.
            if matches!(parameter, UncertainParameter::Whole(_) | UncertainParameter::Wave { .. }) {
                continue;
            }
            parameter.add(&mut varied, part);
            is_varied = true;
        }
        all.extend(is_varied.then_some(varied));
    }
    for (parameter, row) in &known {
        let sigma = row.sigma();
        if sigma == 0.0 {
            continue;
        }
        match (parameter, row) {
            (UncertainParameter::Whole(_) | UncertainParameter::Wave { .. }, _) => {
                all.extend(parameter.apart(machine, sigma / parameter.file_factor()).into_iter().map(|wave| {
                    let mut varied = errors.clone();
                    varied.motion.push(wave);
                    varied
                }));
            }
            (_, UncertaintyRow::Alone(_)) => {
                let mut varied = errors.clone();
                parameter.add(&mut varied, sigma);
                all.push(varied);
            }
            _ => {}
        }
    }
    all
}

/// Returns smooth functions along the travel of an axis whose independent sum has a standard deviation, mm or rad, at every position.
fn waves(machine: &Machine, name: ErrorName, sigma: f64) -> Vec<MotionError> {
    let Some(axis) = name.axis() else { return Vec::new() };
    let [unlimited_mm, unlimited_rad] = UNLIMITED;
    let half = if axis.is_rotary() { unlimited_rad } else { unlimited_mm };
    let [low, high] = machine.axis(axis).and_then(|data| data.travel).unwrap_or([-half, half]);
    let own = sigma / ((1 + WAVES) as f64).sqrt();
    let of = |wave: usize, phase: f64| {
        let share = |point: usize| point as f64 / (POINTS - 1) as f64;
        let positions = (0..POINTS).map(|point| low + (high - low) * share(point)).collect();
        let values = (0..POINTS).map(|point| own * (PI * wave as f64 * share(point) + phase).cos()).collect();
        MotionError { name, function: EntryFunction::Table(ErrorTable { positions, values }) }
    };
    let pairs = (1..=WAVES).flat_map(|wave| [of(wave, 0.0), of(wave, -PI / 2.0)]);
    std::iter::once(of(0, 0.0)).chain(pairs).collect()
}

/// Returns the names of error components and effects of the model for which no uncertainty is known, each once, in the order of the model.
#[must_use]
pub fn unknown_of(errors: &ErrorModel, uncertainty: &Uncertainty) -> Vec<String> {
    let known: Vec<UncertainParameter> =
        uncertainty.rows.keys().filter_map(|name| UncertainParameter::find(name, errors)).collect();
    let is_location = |name: ErrorName| known.iter().any(|one| one.component() == Some(name));
    let is_entry = |entry: &MotionError| known.iter().any(|one| one.is_of_entry(entry));
    let locations = errors.location.iter().map(|error| error.name).filter(|&name| !is_location(name));
    let mut names: Vec<String> = locations.map(|name| name.to_string()).collect();
    names.extend(errors.motion.iter().filter(|entry| !is_entry(entry)).map(name_of_entry));
    for (number, effect) in errors.effects.iter().enumerate() {
        let is_known =
            known.iter().any(|one| matches!(one, UncertainParameter::OfEffect { effect, .. } if *effect == number));
        if !is_known {
            names.push(format!("{} {}", effect.source().name, effect.label()));
        }
    }
    let mut seen = std::collections::HashSet::new();
    names.retain(|name| seen.insert(name.clone()));
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::source::{FileId, Source};

    const MILL: &str = "[machine]\nname = \"mill\"\ntopology = \"wFXt\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 400]\n\
                        [location]\nEC0X = 10\n[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-5]\n\
                        [[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 4\n\
                        [[motion]]\ncomponent = \"EYX\"\nkind = \"table\"\npositions_mm = [0, 400]\nvalues_um = [0, 3]\n";

    fn read(own: &str) -> (Machine, ErrorModel) {
        let source = Source::new(FileId(0), "m.toml", format!("{MILL}{own}").into_bytes()).unwrap();
        let (found, findings) = crate::file::load(&source);
        found.unwrap_or_else(|| panic!("{findings:?}"))
    }

    #[test]
    fn a_variation_adds_a_column_in_the_units_of_the_file() {
        let (machine, errors) = read("[uncertainty]\nEC0X = [2, 1]\nEXX1 = [0, 3e-6]\nEXXb = 0.5\n");
        let uncertainty = machine.uncertainty.as_ref().unwrap();
        let all = variations(&machine, &errors, uncertainty);
        assert_eq!(all.len(), 3);
        let value = |which: usize, name: &str| {
            let name: ParameterName = name.parse().unwrap();
            name.get(&all[which]) - name.get(&errors)
        };
        assert!((value(0, "EC0X") - 2e-6).abs() < 1e-15 && value(0, "EXX1") == 0.0);
        assert!((value(1, "EC0X") - 1e-6).abs() < 1e-15 && (value(1, "EXX1") - 3e-6).abs() < 1e-15);
        // A reversal of 0.5 µm is a parameter of 0.25 µm.
        assert!((value(2, "EXXb") - 0.25e-3).abs() < 1e-12 && value(2, "EC0X") == 0.0);
        assert_eq!(unknown_of(&errors, uncertainty), ["EYX"]);
    }

    #[test]
    fn a_whole_error_has_its_standard_uncertainty_at_every_position() {
        let (machine, errors) = read("[uncertainty]\nEYX = 2\n");
        let all = variations(&machine, &errors, machine.uncertainty.as_ref().unwrap());
        for x in [0.0, 100.0, 175.0, 400.0] {
            let at = |errors: &ErrorModel| -> f64 {
                let mut command = ncfix_base::geometry::AxisVector::ZERO;
                command[ncfix_base::geometry::Axis::X] = x;
                let own = errors.motion.iter().filter(|error| error.name.to_string() == "EYX");
                own.map(|error| error.function.value(ncfix_base::geometry::Axis::X, &command, &Default::default()))
                    .sum()
            };
            let square: f64 = all.iter().map(|varied| (at(varied) - at(&errors)).powi(2)).sum();
            assert!((square.sqrt() - 2e-3).abs() < 1e-9, "{x} {square}");
        }
    }

    #[test]
    fn a_wave_has_a_row_of_its_own() {
        let wave =
            "[[motion]]\ncomponent = \"EXX\"\nkind = \"periodic\"\nperiod_mm = 10\namplitude_um = 3\nphase_deg = 20\n";
        let (machine, errors) = read(&format!("{wave}[uncertainty]\nEC0X = 1\nEXX1 = 1e-6\nEYX = 1\n"));
        assert_eq!(unknown_of(&errors, machine.uncertainty.as_ref().unwrap()), ["EXX~10"]);
        let (machine, errors) = read(&format!("{wave}[uncertainty]\n\"EXX~10\" = 0.5\n"));
        let uncertainty = machine.uncertainty.as_ref().unwrap();
        // The coefficients and the backlash of the same error stay unknown.
        assert_eq!(unknown_of(&errors, uncertainty), ["EC0X", "EXX", "EYX"]);
        let all = variations(&machine, &errors, uncertainty);
        assert_eq!(all.len(), 2);
        for x in [0.0, 1.3, 2.5, 307.0] {
            let at = |errors: &ErrorModel| -> f64 {
                let mut command = ncfix_base::geometry::AxisVector::ZERO;
                command[ncfix_base::geometry::Axis::X] = x;
                let own = errors.motion.iter().filter(|error| error.name.to_string() == "EXX");
                own.map(|error| error.function.value(ncfix_base::geometry::Axis::X, &command, &Default::default()))
                    .sum()
            };
            let square: f64 = all.iter().map(|varied| (at(varied) - at(&errors)).powi(2)).sum();
            assert!((square.sqrt() - 0.5e-3).abs() < 1e-12, "{x} {square}");
        }
    }

    #[test]
    fn unknown_names_are_refused_at_their_place() {
        for (text, code) in
            [("\"EXX~10\"", "E0406"), ("EXQ1", "E0406"), ("EYY1", "E0406"), ("\"load.EAX\"", "E0406"), ("ezx", "E0406")]
        {
            let source = Source::new(FileId(0), "m.toml", format!("{MILL}[uncertainty]\n{text} = 1\n").into_bytes());
            let (_, findings) = crate::file::load(&source.unwrap());
            let own: Vec<_> = findings.iter().filter(|one| one.code.as_str() == code).collect();
            assert_eq!(own.len(), 1, "{text}: {findings:?}");
            assert!(own[0].place.is_some());
        }
    }
}
