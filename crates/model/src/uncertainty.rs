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
/// Highest degree of a coefficient that has a name.
const HIGHEST_NAMED: u8 = 9;
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
                ComponentTerm::Whole => of_deviation(&name.component),
                // The fitted parameter is half of it.
                ComponentTerm::Backlash => format!("{} of the reversal value", of_deviation(&name.component)),
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

    /// True if this parameter has the uncertainty of a wave.
    fn is_of_wave(&self, entry: &MotionError) -> bool {
        matches!(*self, UncertainParameter::Wave { name, period }
            if name == entry.name && period_of(entry).is_some_and(|own| is_same(period, own)))
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

/// Returns the names of errors and effects of the model for which no uncertainty is known, each once, in the order of the model. If only some numbers of a
/// component or an effect have one, the others are named: `EXX2`, `load.EAX.coefficients[1]`. A curve without such numbers has the name of its component.
#[must_use]
pub fn unknown_of(errors: &ErrorModel, uncertainty: &Uncertainty) -> Vec<String> {
    let known: Vec<UncertainParameter> =
        uncertainty.rows.keys().filter_map(|name| UncertainParameter::find(name, errors)).collect();
    let is_number = |name: ParameterName| known.contains(&UncertainParameter::Number(name));
    let mut names: Vec<String> = Vec::new();
    let mut add = |whole: String, parts: Vec<(String, bool)>| {
        if parts.iter().all(|(_, is_known)| !is_known) && !parts.is_empty() {
            names.push(whole);
        } else {
            names.extend(parts.into_iter().filter(|(_, is_known)| !is_known).map(|(name, _)| name));
        }
    };
    for error in &errors.location {
        add(error.name.to_string(), vec![(error.name.to_string(), is_number(ParameterName::location(error.name)))]);
    }
    let mut components: Vec<ErrorName> = Vec::new();
    for error in &errors.motion {
        if !components.contains(&error.name) {
            components.push(error.name);
        }
    }
    for component in components.into_iter().filter(|name| !known.contains(&UncertainParameter::Whole(*name))) {
        let own = || errors.motion.iter().filter(|entry| entry.name == component);
        for wave in own().filter(|entry| period_of(entry).is_some()) {
            let name = name_of_entry(wave);
            add(name.clone(), vec![(name, known.iter().any(|one| one.is_of_wave(wave)))]);
        }
        let of_number = |number: Option<ParameterName>| match number {
            Some(number) => (number.to_string(), is_number(number)),
            None => (component.to_string(), false),
        };
        let mut parts: Vec<(String, bool)> = numbers(errors, component).into_iter().map(of_number).collect();
        // All of its numbers are zero.
        if parts.is_empty() && own().any(|entry| period_of(entry).is_none()) {
            parts.push((component.to_string(), known.iter().any(|one| one.component() == Some(component))));
        }
        add(component.to_string(), parts);
    }
    let mut parts: Vec<Vec<(String, bool)>> = vec![Vec::new(); errors.effects.len()];
    visit_effects(errors, &mut |name, [effect, index], parameter, value| {
        let is_this = |one: &UncertainParameter| matches!(one, UncertainParameter::OfEffect { effect: own, index: at, .. } if *own == effect && *at == index);
        if let Some(list) = parts.get_mut(effect).filter(|_| parameter.is_linear && value != 0.0) {
            list.push((name, known.iter().any(is_this)));
        }
    });
    for (effect, mut parts) in errors.effects.iter().zip(parts) {
        let whole = format!("{} {}", effect.source().name, effect.label());
        // An effect without linear numbers has no uncertainty that could be stated.
        if parts.is_empty() {
            parts.push((whole.clone(), false));
        }
        add(whole, parts);
    }
    let mut seen = std::collections::HashSet::new();
    names.retain(|name| seen.insert(name.clone()));
    names
}

/// The numbers of a component that are not zero; `None` for a part that only the uncertainty of the whole component could describe.
fn numbers(errors: &ErrorModel, component: ErrorName) -> Vec<Option<ParameterName>> {
    /// Constants below this come from rounding, mm or rad: a knot keeps the origin in its place.
    const ROUNDED: f64 = 1e-12;
    let own = || errors.motion.iter().filter(|error| error.name == component).map(|error| &error.function);
    let coefficients = (0..=HIGHEST_NAMED).map(|degree| ParameterName::coefficient(component, degree));
    let simple = coefficients.chain([ParameterName::backlash(component)]);
    let mut found: Vec<Option<ParameterName>> = simple
        .filter(|name| name.get(errors).abs() > if name.degree() == 0 { ROUNDED } else { 0.0 })
        .map(Some)
        .collect();
    for function in own() {
        match function {
            EntryFunction::Polynomial(_) | EntryFunction::Periodic(_) => {}
            EntryFunction::Piecewise(piecewise) => {
                for knot in &piecewise.knots {
                    let is_rotary = component.axis().is_some_and(|axis| axis.is_rotary());
                    let at = if is_rotary { knot.at.to_degrees() } else { knot.at };
                    let powers = knot.coefficients.iter().enumerate().filter(|(_, value)| **value != 0.0);
                    found.extend(powers.map(|(degree, _)| {
                        let degree = u8::try_from(degree).ok()?;
                        let is_whole = (at - at.round()).abs() < 1e-6;
                        is_whole.then_some(ParameterName {
                            component,
                            term: ComponentTerm::Knot { degree, at: at.round() as i32 },
                        })
                    }));
                }
            }
            EntryFunction::Backlash(backlash) if backlash.reversal.positions.len() == 1 => {}
            _ => found.push(None),
        }
    }
    found
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
    fn a_number_without_an_uncertainty_is_named() {
        let of = |own: &str| {
            let (machine, errors) = read(own);
            unknown_of(&errors, machine.uncertainty.as_ref().unwrap())
        };
        // Only the reversal of EXX is known, or only its slope.
        assert_eq!(of("[uncertainty]\nEC0X = 1\nEXXb = 0.5\nEYX = 1\n"), ["EXX1"]);
        assert_eq!(of("[uncertainty]\nEC0X = 1\nEXX1 = 1e-6\nEYX = 1\n"), ["EXXb"]);
        assert_eq!(of("[uncertainty]\nEYX = 1\n"), ["EC0X", "EXX"]);
        assert_eq!(of("[uncertainty]\nEC0X = 1\nEXX = 1\nEYX = 1\n"), [""; 0]);
        // A table has no number of its own, so a slope of the component does not describe it.
        let slope = "[[motion]]\ncomponent = \"EYX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-6]\n";
        assert_eq!(of(&format!("{slope}[uncertainty]\nEC0X = 1\nEXX1 = 1e-6\nEXXb = 1\nEYX1 = 1e-6\n")), ["EYX"]);
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
        let (machine, errors) = read(&format!("{wave}[uncertainty]\nEC0X = 1\nEXX1 = 1e-6\nEXXb = 1\nEYX = 1\n"));
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
