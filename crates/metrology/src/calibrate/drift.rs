//! Reversal errors of a model that are not distinguishable from an unknown drift of readings.
//!
//! A length reading depends on the reversal error of its own component and those of the angles of its axis, through their Abbe arms; an angle reading
//! depends on its own.

use crate::measure::data::DataSet;
use ncfix_model::motion::EntryFunction;
use ncfix_model::parameter::{ComponentTerm, ParameterName};
use ncfix_model::{ErrorModel, ErrorName};

use super::effect::Parameter;

/// A sentence for every component that was read with an unknown drift and has a reversal error, either fitted or in the initial model.
#[must_use]
pub fn reversals<'a>(
    errors: &ErrorModel,
    parameters: impl Iterator<Item = &'a Parameter>,
    data: &[DataSet],
) -> Vec<String> {
    let backlash = |parameter: &Parameter| match parameter {
        Parameter::Geometry(name) if name.term == ComponentTerm::Backlash => Some(*name),
        _ => None,
    };
    let backlashes: Vec<ParameterName> = parameters.filter_map(backlash).collect();
    let mut out = Vec::new();
    for set in data.iter().filter(|set| !set.cycles.is_empty()) {
        let mut read: Vec<usize> = set.cycles.iter().map(|cycle| cycle.target).collect();
        read.sort_unstable();
        read.dedup();
        let names = read.iter().filter_map(|&target| set.targets.get(target)?.parse::<ErrorName>().ok());
        for read in names {
            let feels = |own: &ErrorName| {
                *own == read
                    || (own.axis() == read.axis() && own.direction.is_rotation() && !read.direction.is_rotation())
            };
            let fitted = backlashes.iter().find(|name| feels(&name.component));
            let known = errors.motion.iter().find(|entry| {
                let EntryFunction::Backlash(backlash) = &entry.function else { return false };
                feels(&entry.name) && backlash.reversal.values.iter().any(|&value| value != 0.0)
            });
            let cause = match (fitted, known) {
                (Some(name), _) => format!("the model contains {name}"),
                (None, Some(entry)) => format!("the machine file has backlash in {}", entry.name),
                (None, None) => continue,
            };
            out.push(format!("{}: {read} was read with an unknown drift, but {cause}", set.name));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::bench;
    use crate::measure::data::cycles::RepeatCycle;

    #[test]
    fn a_length_feels_the_angles_of_its_axis_and_an_angle_only_itself() {
        let machine = bench::machine();
        let found = |component: &str, value: &str, fitted: &str| {
            let rows = format!("X,Y,Z,component,{value}\n0,0,0,{component},0\n");
            let mut data = bench::table(&machine, &rows, "[measurement]\nkind = \"direct\"\n");
            data.cycles = vec![RepeatCycle { setup: 0, target: 0, number: 1, level: None }];
            let name: Parameter = fitted.parse::<ParameterName>().unwrap().into();
            reversals(&ErrorModel::default(), [name].iter(), &[data]).len()
        };
        assert_eq!(["EXXb", "EBXb", "EYXb", "EBYb"].map(|fitted| found("EXX", "value_um", fitted)), [1, 1, 0, 0]);
        assert_eq!(["EBXb", "EAXb", "EXXb"].map(|fitted| found("EBX", "value_urad", fitted)), [1, 0, 0]);
    }
}
