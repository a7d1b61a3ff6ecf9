//! Effect of one unit of each parameter on the tool.

use super::design::Design;
use super::effect::{ParameterEffect, Probe};
use crate::measure::kind::{Equation, PathDerivative};
use crate::measure::reading::Reading;
use ncfix_base::geometry::{Matrix, Vector};
use ncfix_machine::machine::Condition;
use ncfix_model::{ErrorModel, ErrorName, Model};

/// The index of a component; a new one is added.
pub(super) fn number_of(components: &mut Vec<ErrorName>, name: ErrorName) -> usize {
    components.iter().position(|known| *known == name).unwrap_or_else(|| {
        components.push(name);
        components.len() - 1
    })
}

/// Effect of one unit of each parameter on the tool, in one condition and at one pose.
pub(super) struct Units<'a> {
    design: &'a Design<'a>,
    /// The components of all parameters.
    components: Vec<ErrorName>,
    /// Probes of the effect parameters, with their columns.
    probes: Vec<(usize, Probe)>,
    /// Effects of one of them in the condition.
    own: Vec<ParameterEffect>,
    /// Effects of all of them in the condition, with their columns and components.
    pub(super) parts: Vec<(usize, usize, ParameterEffect)>,
    /// Effect of one unit of each component on tip and direction of the tool.
    by_component: Vec<[Vector; 2]>,
    /// Share of a component in one unit of a parameter: column, component, share.
    shares: Vec<(usize, usize, f64)>,
}

impl<'a> Units<'a> {
    /// Effects are those of `errors`.
    pub(super) fn new(design: &'a Design<'a>, errors: &ErrorModel) -> Units<'a> {
        let shares = design.geometry.iter().map(|&(column, _, component)| (column, component, 0.0)).collect();
        let probes = design.effects.iter().map(|(column, parameter)| (*column, parameter.probe(errors))).collect();
        let (components, parts, by_component) = (design.components.clone(), Vec::new(), Vec::new());
        Units { design, components, probes, own: Vec::new(), parts, by_component, shares }
    }

    /// Sets another condition.
    pub(super) fn enter(&mut self, condition: &Condition) {
        self.parts.clear();
        for (column, probe) in &self.probes {
            probe.parts(self.design.machine, condition, &mut self.own);
            for part in self.own.drain(..) {
                let component = number_of(&mut self.components, part.component);
                self.parts.push((*column, component, part));
            }
        }
        self.shares.truncate(self.design.geometry.len());
        self.shares.extend(self.parts.iter().map(|&(column, component, _)| (column, component, 0.0)));
    }

    /// Sets a pose; directions are rotated by `turn`.
    pub(super) fn stand(&mut self, model: &Model, reading: &Reading, turn: &Matrix) {
        self.by_component.clear();
        self.by_component.extend(self.components.iter().map(|name| {
            let unit = model.sensitivity(*name, &reading.position, &reading.tool_mm);
            [turn * unit.translation, turn * unit.rotation]
        }));
        let command = self.design.within_turn(&reading.position);
        let geometry = self.design.geometry.iter().map(|(_, name, _)| name.weight(&command, &reading.state));
        let effects = self.parts.iter().map(|(_, _, part)| part.value(&command, &reading.state));
        for ((_, _, share), value) in self.shares.iter_mut().zip(geometry.chain(effects)) {
            *share = value;
        }
    }

    /// The derivatives with respect to all parameters of an equation that was read along a path.
    pub(super) fn factors_along(&mut self, model: &Model, equation: &Equation, out: &mut [f64]) {
        let mut one = vec![0.0; out.len()];
        out.fill(0.0);
        for PathDerivative { reading, by_tip, by_component } in &equation.by_path {
            let nominal = model.nominal(&reading.position, &reading.tool_mm);
            self.stand(model, reading, &nominal.rotation);
            let own = Equation { by_tip: *by_tip, by_location: *by_component, ..Equation::default() };
            self.factors(&own, &mut one);
            out.iter_mut().zip(&one).for_each(|(sum, part)| *sum += part);
        }
    }

    /// The derivatives with respect to all parameters, from those of an equation with respect to tip, direction and components; 0 for unknowns.
    pub(super) fn factors(&self, equation: &Equation, out: &mut [f64]) {
        out.fill(0.0);
        for &(column, component, share) in &self.shares {
            let [tip, turn] = &self.by_component[component];
            let own = equation.by_component(self.components[component]);
            out[column] += (equation.by_tip.dot(tip) + equation.by_turn.dot(turn) + own) * share;
        }
    }

    /// Tip motion per unit of each parameter.
    pub(super) fn moved(&self, out: &mut [Vector]) {
        out.fill(Vector::zeros());
        for &(column, component, share) in &self.shares {
            out[column] += self.by_component[component][0] * share;
        }
    }
}
