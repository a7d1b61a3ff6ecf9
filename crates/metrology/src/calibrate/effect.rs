//! Parameters of effects (weight of the workpiece, drift, expansion, structure) in addition to geometric ones.
//!
//! A linear parameter has an exact derivative: its effect at 1 with all others at 0, in the condition of the reading, on the location and motion
//! errors of the axes. Others (arms, time constants) use central differences. The effect of axis errors on the tip is that of the geometric
//! parameters, so that both are combined in one fit.

use std::fmt;
use std::sync::Arc;

use crate::measure::data::DataSet;
use ncfix_base::geometry::AxisVector;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::{Condition, Machine, State};
use ncfix_model::motion::EntryFunction;
use ncfix_model::parameter::ParameterName;
use ncfix_model::{Accumulator, Effect, ErrorModel, ErrorName, uncertainty};

use super::cause::UndeterminedCause;

/// Step of a central difference as a share of the parameter, and its minimum.
const STEP: f64 = 1e-4;
const LEAST_STEP: f64 = 1e-6;
/// Largest relative change of a nonlinear parameter in one iteration, which preserves its sign.
const LARGEST_CHANGE: f64 = 0.5;

/// A parameter of the machine.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameter {
    /// Of a location or motion error.
    Geometry(ParameterName),
    /// Of an effect.
    Effect(EffectParameter),
}

/// A parameter of an effect of one error model.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectParameter {
    /// `load.EAX.coefficients[1]`; a second effect of the same name is `load.EAX~2`.
    name: Arc<str>,
    /// Index of the effect, and of the parameter in it.
    effect: usize,
    index: usize,
    is_linear: bool,
    /// `true` if its effect depends on temperatures.
    has_sensors: bool,
    /// `true` for a coefficient of a truncated power that was 0: zero for a function without steps.
    is_idle_knot: bool,
    /// Its display unit, and the factor to it.
    unit: Arc<str>,
    factor: f64,
}

impl From<ParameterName> for Parameter {
    fn from(name: ParameterName) -> Parameter {
        Parameter::Geometry(name)
    }
}

impl From<EffectParameter> for Parameter {
    fn from(parameter: EffectParameter) -> Parameter {
        Parameter::Effect(parameter)
    }
}

impl Parameter {
    /// Its value in a model, mm, rad, s, per power.
    #[must_use]
    pub fn get(&self, errors: &ErrorModel) -> f64 {
        match self {
            Parameter::Geometry(name) => name.get(errors),
            Parameter::Effect(parameter) => parameter.get(errors),
        }
    }

    /// Sets its value in a model, the inverse of [`Self::get`].
    pub fn set(&self, errors: &mut ErrorModel, value: f64) {
        match self {
            Parameter::Geometry(name) => name.set(errors, value),
            Parameter::Effect(parameter) => {
                if let Some(effect) = errors.effects.get_mut(parameter.effect) {
                    change(&mut **effect, |index, _, own| {
                        if index == parameter.index {
                            *own = value;
                        }
                    });
                }
            }
        }
    }

    /// `true` if the error is proportional to it.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        match self {
            Parameter::Geometry(_) => true,
            Parameter::Effect(parameter) => parameter.is_linear,
        }
    }

    /// `true` if it has no effect because everything that it scales is 0.
    pub(super) fn is_idle(&self, errors: &ErrorModel) -> bool {
        let Parameter::Effect(parameter) = self else { return false };
        let Some(effect) = parameter.effect(errors).filter(|_| !parameter.is_linear) else { return false };
        let mut is_idle = true;
        change(&mut *effect.boxed(), |_, is_linear, value| is_idle &= !is_linear || *value == 0.0);
        is_idle
    }

    /// The value after a step.
    pub(super) fn stepped(&self, value: f64, step: f64) -> f64 {
        let most = LARGEST_CHANGE * value.abs();
        if self.is_linear() || most == 0.0 { value + step } else { value + step.clamp(-most, most) }
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Parameter::Geometry(name) => name.fmt(f),
            Parameter::Effect(parameter) => f.write_str(&parameter.name),
        }
    }
}

/// Visits the parameters of an effect with their indices.
fn change(effect: &mut dyn Effect, mut each: impl FnMut(usize, bool, &mut f64)) {
    let mut index = 0;
    effect.visit_parameters(&mut |parameter, value| {
        each(index, parameter.is_linear, value);
        index += 1;
    });
}

/// All parameters of the effects of a model.
#[must_use]
pub fn effect_parameters(errors: &ErrorModel) -> Vec<EffectParameter> {
    let mut out: Vec<EffectParameter> = Vec::new();
    uncertainty::visit_effects(errors, &mut |name, place, parameter, value| {
        let (key, factor) = parameter.written.map_or(("", 1.0), |written| (written.key, written.factor));
        let end = parameter.name.match_indices('.').nth(1).map_or(parameter.name.len(), |(at, _)| at);
        let (factor, unit) = shown(parameter.name.split_at(end).0, key, factor);
        out.push(EffectParameter {
            name: name.into(),
            effect: place[0],
            index: place[1],
            is_linear: parameter.is_linear,
            has_sensors: errors.effects.get(place[0]).is_some_and(|effect| !effect.sensors().is_empty()),
            is_idle_knot: key.starts_with("knots[") && value == 0.0,
            unit: unit.into(),
            factor,
        });
    });
    out
}

/// The parameters for a line of a model: the one with this name, or all linear ones with this prefix. Coefficients of truncated powers that are 0
/// stay so, unless they are named.
#[must_use]
pub fn named(all: &[EffectParameter], text: &str) -> Vec<EffectParameter> {
    if let Some(one) = all.iter().find(|one| &*one.name == text) {
        return vec![one.clone()];
    }
    let begins = |one: &&EffectParameter| {
        let rest = one.name.strip_prefix(text);
        rest.is_some_and(|rest| rest.starts_with(['.', '@', '[', '~'])) && one.is_linear && !one.is_idle_knot
    };
    all.iter().filter(begins).cloned().collect()
}

/// The display unit of a parameter, and the factor to it: that of the file, and for coefficients µm and µrad per power of m.
fn shown(stem: &str, key: &str, factor: f64) -> (f64, String) {
    if let Some((_, degree)) = key.rsplit_once("coefficients[") {
        let component = stem.split('.').nth(1).and_then(|name| name.parse::<ErrorName>().ok());
        let is_angle = component.is_some_and(|name| name.direction.is_rotation());
        let is_rotary = component.and_then(|name| name.axis()).is_some_and(|axis| axis.is_rotary());
        return coefficient_unit(is_angle, is_rotary, degree.trim_end_matches(']').parse().unwrap_or(0));
    }
    let word = key.rsplit('.').next().unwrap_or_default();
    let word = word.split('[').next().unwrap_or_default();
    let unit = match word {
        "um_per_K" => "µm/K",
        "urad_per_K" => "µrad/K",
        "um_per_m_K" => "µm/(m K)",
        _ if word.ends_with("_um") => "µm",
        _ if word.ends_with("_urad") => "µrad",
        _ if word.ends_with("_mm") => "mm",
        _ if word.ends_with("_s") => "s",
        _ => "",
    };
    (factor, unit.to_owned())
}

/// The display unit and the factor from mm, rad and powers of them: µm, µrad, per power of m or rad.
#[must_use]
pub fn coefficient_unit(is_angle: bool, is_rotary: bool, degree: u8) -> (f64, String) {
    const MM_OF_M: f64 = 1000.0;
    let (factor, unit) = if is_angle { (urad_from_rad(1.0), "µrad") } else { (um_from_mm(1.0), "µm") };
    let (factor, per) = if is_rotary { (factor, "rad") } else { (factor * MM_OF_M.powi(i32::from(degree)), "m") };
    match degree {
        0 => (factor, unit.into()),
        1 => (factor, format!("{unit}/{per}")),
        degree => (factor, format!("{unit}/{per}^{degree}")),
    }
}

/// The effect of a parameter on one component of the axis errors, per unit.
#[derive(Clone, Debug)]
pub(super) struct ParameterEffect {
    pub(super) component: ErrorName,
    function: Option<EntryFunction>,
    factor: f64,
}

impl ParameterEffect {
    /// The value at a pose, mm or rad per unit.
    pub(super) fn value(&self, command: &AxisVector, state: &State) -> f64 {
        match (&self.function, self.component.axis()) {
            (Some(function), Some(axis)) => self.factor * function.value(axis, command, state),
            _ => self.factor,
        }
    }
}

impl EffectParameter {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The factor to its display unit, and the unit.
    #[must_use]
    pub fn unit(&self) -> (f64, &str) {
        (self.factor, &self.unit)
    }

    /// Its effect in a model.
    #[must_use]
    pub fn effect<'a>(&self, errors: &'a ErrorModel) -> Option<&'a dyn Effect> {
        errors.effects.get(self.effect).map(|effect| &**effect)
    }

    /// Its index among the parameters of the effect; lower ones are simpler.
    pub(super) fn index(&self) -> usize {
        self.index
    }

    fn get(&self, errors: &ErrorModel) -> f64 {
        let mut found = 0.0;
        if let Some(effect) = self.effect(errors) {
            change(&mut *effect.boxed(), |index, _, value| {
                if index == self.index {
                    found = *value;
                }
            });
        }
        found
    }

    /// A probe of its effect, with the other parameters as in a model.
    pub(super) fn probe(&self, errors: &ErrorModel) -> Probe {
        let Some(effect) = self.effect(errors) else { return Probe { sides: Vec::new() } };
        let only = |effect| ErrorModel { effects: vec![effect], ..ErrorModel::default() };
        if self.is_linear {
            let mut unit = effect.boxed();
            change(&mut *unit, |index, is_linear, value| {
                if is_linear {
                    *value = f64::from(u8::from(index == self.index));
                }
            });
            return Probe { sides: vec![(only(unit), 1.0)] };
        }
        let step = (STEP * self.get(errors).abs()).max(LEAST_STEP);
        let sides = [step, -step].into_iter().map(|side| {
            let mut moved = effect.boxed();
            change(&mut *moved, |index, _, value| {
                if index == self.index {
                    *value += side;
                }
            });
            (only(moved), 0.5 / side)
        });
        Probe { sides: sides.collect() }
    }
}

/// The isolated effect of a parameter: with it at 1 and all others at 0, or with a small increase and decrease, each with a factor.
#[derive(Debug)]
pub(super) struct Probe {
    sides: Vec<(ErrorModel, f64)>,
}

impl Probe {
    /// The effect of one unit in a condition.
    pub(super) fn parts(&self, machine: &Machine, condition: &Condition, out: &mut Vec<ParameterEffect>) {
        out.clear();
        let mut middle = 0;
        for (errors, factor) in &self.sides {
            middle = out.len();
            let sum = Accumulator::sum(machine, errors, condition, |_| true);
            out.extend(sum.parts().into_iter().map(|(component, function, value)| ParameterEffect {
                component,
                function: function.cloned(),
                factor: value * factor,
            }));
        }
        if self.sides.len() < 2 {
            return;
        }
        // Unaffected parts are exactly zero, not a small rounding error.
        let (above, below) = out.split_at(middle);
        let alike = |(one, other): (&ParameterEffect, &ParameterEffect)| {
            one.component == other.component
                && one.function == other.function
                && one.factor.to_bits() == (-other.factor).to_bits()
        };
        if above.len() == below.len() && above.iter().zip(below).all(alike) {
            out.clear();
        }
    }
}

/// The cause of an unidentifiable effect: a condition that did not change between the readings.
pub(super) fn lack(effects: &[EffectParameter], data: &[DataSet]) -> Option<UndeterminedCause> {
    let mut loads: Vec<_> = Vec::new();
    let mut is_warm = false;
    let mut last = None;
    for (number, set) in data.iter().enumerate() {
        for row in &set.observations {
            if last.replace((number, row.condition)) == Some((number, row.condition)) {
                continue;
            }
            let condition = set.condition(row);
            is_warm |= condition.has_temperatures();
            if loads.len() < 3 && !loads.iter().any(|known| *known == condition.loads()) {
                loads.push(condition.loads());
            }
        }
    }
    let is_of = |source: &str| effects.iter().any(|one| one.name().starts_with(source));
    match loads.as_slice() {
        [only] if is_of("load.") && only.is_empty() => Some(UndeterminedCause::NoLoad),
        [_] if is_of("load.") => Some(UndeterminedCause::OneLoad),
        _ if !is_warm && !is_of("load.") && effects.iter().any(|one| one.has_sensors) => {
            Some(UndeterminedCause::NoTemperatures)
        }
        _ => None,
    }
}
