//! Reduces a model to its identifiable part.
//!
//! The rule: of parameters that are not distinguishable the least simple one is removed. Parameters of effects go first, then truncated powers, the
//! last ones before the others, then backlashes. Then follow coefficients from the highest degree down, later ones of the model before earlier ones;
//! location errors go last. A less simple parameter stays if its involvement is below 2 % of its effect: its removal would hardly improve the others.
//! Afterwards the least simple of the very uncertain parameters is removed, one by one: those for which readings of 1 µm leave an uncertainty of more
//! than 0.1 mm at the tip. A removed parameter keeps its value of the initial machine file.

use crate::measure::data::DataSet;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

use super::effect::Parameter;
use super::exact::exact;
use super::fit::awake;
use super::identify::identify_exact;
use super::words::{Confused, simplicity};

/// Maximum number of iterations: the second one handles only effects of the first one's limits.
const MAX_ROUNDS: usize = 8;

/// Tip uncertainty for readings of [`READING_MM`] above which a parameter is useless, mm.
const BADLY_MM: f64 = 0.1;
const READING_MM: f64 = 1e-3;

/// A reduced model.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduced {
    /// The identifiable parameters, in the given order.
    pub parameters: Vec<Parameter>,
    /// Removed parameters, by reason.
    pub left_out: Vec<Confused>,
}

/// Removes unidentifiable parameters. `None` if positions are so large that numbers are not finite.
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
        // As at the start of the fit: arms and time constants are judged with nonzero values of everything they scale.
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
    /// Removes parameters until all others are identifiable with sufficient certainty.
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
                    "{parameter} is determined so poorly that readings with 1 µm uncertainty give it an uncertainty of {micrometers:.0} µm at the tip"
                ),
                remedy: "measure where its effect is larger, or where similar parameters have another effect".into(),
                parameters: vec![parameter],
                set: None,
            });
        }
        Some(())
    }
}
