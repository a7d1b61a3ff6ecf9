//! `--select`: which candidates there are.

use std::path::Path;

use super::arguments::CalibrateArguments;
use super::findings::Findings;
use super::parameters;
use super::stop::Stop;
use ncfix_machine::machine::Machine;
use ncfix_metrology::calibrate::Parameter;
use ncfix_metrology::calibrate::candidates::{Pieces, of_component, of_motion};
use ncfix_metrology::measure::data::DataSet;
use ncfix_model::ErrorModel;
use ncfix_model::name::{ErrorKind, ErrorName};
use ncfix_model::parameter::ParameterName;
use ncfix_model::preset;

/// Candidates at most.
const MOST: usize = 2000;

/// The candidates of `--select`; `None` where findings forbid to use them.
///
/// # Errors
/// Where a word is nothing, or there are too many of them.
pub(super) fn candidates(
    arguments: &CalibrateArguments,
    words: &str,
    machine: &Machine,
    errors: &ErrorModel,
    data: &[DataSet],
    findings: &mut Findings,
) -> Result<Option<Vec<Parameter>>, Stop> {
    let pieces = Pieces { spacing_mm: arguments.knots, degree: arguments.degree };
    let mut all: Vec<Parameter> = Vec::new();
    for word in words.split(',').map(str::trim) {
        if preset::find(word).is_some() || (Path::new(word).is_file() && word != "motion") {
            let Some(found) = parameters::choose(word, machine, errors, findings)? else { return Ok(None) };
            all.extend(found);
        } else if word == "motion" {
            all.extend(of_motion(machine, data, pieces).into_iter().map(Parameter::from));
        } else {
            all.extend(named(word, machine, data, pieces)?.into_iter().map(Parameter::from));
        }
    }
    if all.len() > MOST {
        let count = all.len();
        return Err(Stop::Usage(format!(
            "--select gives {count} candidates, of which {MOST} can be tried; give wider --knots"
        )));
    }
    Ok(Some(all))
}

/// An error with all its terms, or a parameter.
fn named(word: &str, machine: &Machine, data: &[DataSet], pieces: Pieces) -> Result<Vec<ParameterName>, Stop> {
    let component = word.parse::<ErrorName>().ok().filter(|name| name.kind == ErrorKind::Motion);
    let found = match component {
        Some(component) => of_component(component, data, pieces),
        None => vec![word.parse::<ParameterName>().map_err(|_| {
            Stop::Usage(format!(
                "--select {word} is no preset, no error such as EXX, no parameter such as EXX2@150 and no file; motion has all motion errors of the \
                 linear axes"
            ))
        })?],
    };
    match found.iter().find_map(|name| name.component.axis().filter(|&axis| machine.axis(axis).is_none())) {
        Some(axis) => Err(Stop::Usage(format!("--select {word}: the machine {} has no axis {axis}", machine.name))),
        None => Ok(found),
    }
}
