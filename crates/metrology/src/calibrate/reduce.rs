//! Reduces a model to what the data can tell.
//!
//! The rule: of parameters that cannot be told from each other the least simple one goes. Parameters of effects go first, then truncated powers, the last ones before
//! the others, then backlashes, then coefficients from the highest degree down, the later ones of the model before the earlier ones; location errors go last.
//! A parameter stays although it is less simple where it takes part by less than 2 % of its effect: without it the others would
//! hardly be told better. Then, one after the other, the least simple one of those goes that are told so badly that readings of 1 µm leave
//! more than 0.1 mm of their effect on the tip uncertain. What was left out counts as it is in the machine file that the calibration begins with.

use crate::measure::data::DataSet;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

use super::effect::Parameter;
use super::exact::exact;
use super::fit::awake;
use super::identify::identify_exact;
use super::words::{Confused, simplicity};

/// Rounds at most: the second one finds nothing but what the limits of the first one left.
const MAX_ROUNDS: usize = 8;

/// Uncertain at the tip with readings of [`READING_MM`], mm: what is told worse is told by nothing that anybody would use.
const BADLY_MM: f64 = 0.1;
const READING_MM: f64 = 1e-3;

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
    /// Leaves out until all others can be told, and are not told badly.
    fn lose(&mut self, machine: &Machine, start: &ErrorModel, exact: &[DataSet]) -> Option<()> {
        for _ in 0..MAX_ROUNDS + self.parameters.len() {
            let found = identify_exact(machine, start, &self.parameters, exact)?;
            if !found.lost.leave_out.is_empty() {
                self.parameters.retain(|name| !found.lost.leave_out.contains(name));
                self.left_out.extend(found.lost.confused);
                continue;
            }
            let uncertain = |k: usize| found.sigmas[k] * READING_MM * found.effects[k];
            let count = self.parameters.len().min(found.sigmas.len()).min(found.effects.len());
            let badly = (0..count).filter(|&k| uncertain(k) > BADLY_MM);
            let Some(worst) = badly.max_by(|&a, &b| {
                let rank = |k: usize| found.columns.get(k).map(simplicity);
                rank(a).cmp(&rank(b)).then(uncertain(a).total_cmp(&uncertain(b)))
            }) else {
                break;
            };
            let parameter = self.parameters.remove(worst);
            let micrometers = 1e3 * uncertain(worst);
            self.left_out.push(Confused {
                sentence: format!(
                    "{parameter} is told, but so badly that readings of 1 µm leave {micrometers:.0} µm of it at the tip"
                ),
                remedy: "measure where it does more, or where the others that look like it do something else".into(),
                parameters: vec![parameter],
                set: None,
            });
        }
        Some(())
    }
}
