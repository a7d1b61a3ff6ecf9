//! Stated hypotheses as values.

use std::sync::Arc;

use super::super::cause::EffectKind;
use super::super::scene::Through;
use ncfix_base::geometry::Axis;
use ncfix_base::source::Span;

/// A hypothesis stated by a user.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedHypothesis {
    /// Its text.
    pub text: String,
    /// Its position in the source text.
    pub span: Span,
    pub(super) statement: StatedContent,
}

/// Content of a hypothesis.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum StatedContent {
    /// A cause by effect and parameter, as in the results: `backlash EXX`.
    Named(EffectKind, String),
    /// A term by its name in explanations: `EYX X order 2`.
    Shape(String),
    /// A deviation as a sum of terms, each with its own amount.
    Sum(Through, Vec<StatedTerm>),
}

/// A product of factors; one without factors is a constant.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StatedTerm {
    /// Its text.
    pub(super) text: String,
    pub(super) factors: Vec<Factor>,
    /// Time constant of its temperatures, s.
    pub(super) lag_s: f64,
}

/// A factor.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Factor {
    /// A quantity, minus another one or a number, to a power.
    Power { of: Quantity, minus: Option<Operand>, power: u8 },
    /// A sine and a cosine with a period, mm or rad.
    Wave { axis: Axis, period: f64 },
    /// 1 where a quantity is above a limit (or below it), 0 elsewhere.
    Step { of: Quantity, is_above: bool, limit: f64 },
}

/// Subtrahend of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Operand {
    Quantity(Quantity),
    /// In the internal unit of the quantity: mm, rad, s, otherwise as in the table.
    Number(f64),
}

/// A driver.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Quantity {
    /// Position of an axis, mm or rad.
    Position(Axis),
    /// Sense of the last motion of an axis, −1, 0, 1.
    Sense(Axis),
    /// Velocity of an axis, mm/s or rad/s.
    Speed(Axis),
    /// Time, s.
    Time,
    /// A temperature sensor by its column.
    Temperature(Arc<str>),
    /// Any other column of numbers.
    Column(Arc<str>),
}

/// The amount of a term of a stated hypothesis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TermAmount {
    /// The term as stated.
    pub term: String,
    /// Its amount.
    pub value: f64,
    /// Expanded uncertainty (95 %), with the autocorrelation of the readings.
    pub u95: f64,
    /// Standard uncertainty; of a term in a model that of uncorrelated readings, as of a parameter.
    pub sigma: f64,
    /// Its unit: `um/m^2`, `um/K`; `um` for a reversal value, an amplitude and a step.
    pub unit: String,
}

impl Factor {
    /// Quantities of the factor.
    pub(super) fn quantities(&self) -> Vec<&Quantity> {
        match self {
            Factor::Power { of, minus: Some(Operand::Quantity(other)), .. } => vec![of, other],
            Factor::Power { of, .. } | Factor::Step { of, .. } => vec![of],
            Factor::Wave { .. } => Vec::new(),
        }
    }

    /// The axis of a wave.
    pub(super) fn wave_axis(&self) -> Option<Axis> {
        match self {
            Factor::Wave { axis, .. } => Some(*axis),
            _ => None,
        }
    }
}

impl Quantity {
    /// Its name as a driver in the results.
    pub(super) fn driver(&self) -> String {
        match self {
            Quantity::Position(axis) => axis.to_string(),
            Quantity::Sense(axis) => format!("{axis}_dir"),
            Quantity::Speed(axis) => format!("v({axis})"),
            Quantity::Time => crate::measure::data::TIME.to_owned(),
            Quantity::Temperature(column) | Quantity::Column(column) => column.to_string(),
        }
    }
}

impl StatedTerm {
    /// Distinct drivers of the term.
    pub(super) fn drivers(&self) -> Vec<String> {
        let mut out: Vec<String> = Vec::new();
        for factor in &self.factors {
            let waves = factor.wave_axis().map(|axis| axis.to_string());
            for name in factor.quantities().into_iter().map(Quantity::driver).chain(waves) {
                if !out.contains(&name) {
                    out.push(name);
                }
            }
        }
        out
    }
}
