//! Reduces a model to what the data can tell.
//!
//! The rule: of parameters that cannot be told from each other the least simple one goes. Parameters of effects go first, then truncated powers, the last ones before
//! the others, then backlashes, then coefficients from the highest degree down, the later ones of the model before the earlier ones; location errors go last.
//! A parameter stays although it is less simple where it takes part by less than 2 % of its effect: without it the others would
//! hardly be told better. What was left out counts as it is in the machine file that the calibration begins with.

use crate::machine::Machine;
use crate::measure::data::DataSet;
use crate::model::ErrorModel;

use super::effect::Parameter;
use super::exact::exact;
use super::fit::awake;
use super::identify::identify_exact;
use super::words::Confused;

/// Rounds at most: the second one finds nothing but what the limits of the first one left.
const MAX_ROUNDS: usize = 8;

/// A reduced model.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduced {
    /// The parameters that can be told, in the order in which they were given.
    pub parameters: Vec<Parameter>,
    /// What was left out, by reason.
    pub left_out: Vec<Confused>,
}

/// Leaves out what the data cannot tell. `None` where positions are so large that numbers are not finite.
#[must_use]
pub fn reduce(
    machine: &Machine,
    start: &ErrorModel,
    parameters: &[impl Clone + Into<Parameter>],
    data: &[DataSet],
) -> Option<Reduced> {
    let mut out = Reduced { parameters: parameters.iter().cloned().map(Into::into).collect(), left_out: Vec::new() };
    let exact = exact(machine, data);
    if out.parameters.iter().any(|parameter| parameter.is_idle(start)) {
        // As the fit begins: arms and time constants are judged beside what they change, once that is not 0.
        let (linear, others) = out.parameters.iter().cloned().partition(Parameter::is_linear);
        let mut first = Reduced { parameters: linear, ..out };
        first.lose(machine, start, &exact)?;
        let told = awake(machine, start, &[first.parameters.clone(), others].concat(), data);
        let all: Vec<Parameter> = parameters.iter().cloned().map(Into::into).collect();
        let stays = |one: &Parameter| !one.is_linear() || first.parameters.contains(one);
        out = Reduced { parameters: all.into_iter().filter(stays).collect(), ..first };
        out.lose(machine, told.as_ref().unwrap_or(start), &exact)?;
    } else {
        out.lose(machine, start, &exact)?;
    }
    Some(out)
}

impl Reduced {
    /// Leaves out until all others can be told.
    fn lose(&mut self, machine: &Machine, start: &ErrorModel, exact: &[DataSet]) -> Option<()> {
        for _ in 0..MAX_ROUNDS {
            let lost = identify_exact(machine, start, &self.parameters, exact)?.lost;
            if lost.leave_out.is_empty() {
                break;
            }
            self.parameters.retain(|name| !lost.leave_out.contains(name));
            self.left_out.extend(lost.confused);
        }
        Some(())
    }
}
