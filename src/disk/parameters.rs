//! Parameters of a model: those of a preset or of a file (`--model`), and candidates among which is chosen (`--select`).

use std::path::Path;

use super::files;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use ncfix_base::source::FileId;
use ncfix_machine::machine::Machine;
use ncfix_metrology::calibrate::Parameter;
use ncfix_metrology::calibrate::candidates::{PiecewisePolynomials, of_component, of_motion};
use ncfix_metrology::measure::data::DataSet;
use ncfix_metrology::results::parameters::read;
use ncfix_model::ErrorModel;
use ncfix_model::name::{ErrorKind, ErrorName};
use ncfix_model::parameter::ParameterName;
use ncfix_model::preset::{PRESETS, find};

/// The parameters of `--model`; `None` if there are errors. A preset goes before a file of its name.
///
/// # Errors
/// If there is neither preset nor file, or the preset does not suit the machine.
pub(crate) fn choose(
    model: &str,
    machine: &Machine,
    errors: &ErrorModel,
    findings: &mut Diagnostics,
) -> Result<Option<Vec<Parameter>>, Error> {
    if let Some(preset) = find(model) {
        let parameters = (preset.parameters)(machine).map_err(|reason| {
            Error::usage(format!("preset {model} is not applicable to the machine {}: {reason}", machine.name))
        })?;
        return Ok(Some(parameters.into_iter().map(Parameter::from).collect()));
    }
    let path = Path::new(model);
    if !path.is_file() {
        let known: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        let known = known.join(", ");
        return Err(Error::usage(format!("--model {model} is neither a file nor a preset; the presets are {known}")));
    }
    let source = files::read_written(path, FileId(0), "parameters of the model, --model")?;
    let (parameters, found) = read(&source, machine, errors);
    let is_sound = found.is_empty();
    findings.extend(found, std::slice::from_ref(&source));
    Ok(is_sound.then_some(parameters))
}

/// Candidates at most.
const MOST: usize = 2000;

/// The candidates of `--select`: presets, files, errors, parameters, `motion`; `None` if there are errors.
///
/// # Errors
/// If a word is nothing, or there are too many of them.
pub(crate) fn candidates(
    (words, pieces): (&str, PiecewisePolynomials),
    machine: &Machine,
    errors: &ErrorModel,
    data: &[DataSet],
    findings: &mut Diagnostics,
) -> Result<Option<Vec<Parameter>>, Error> {
    let mut all: Vec<Parameter> = Vec::new();
    for word in words.split(',').map(str::trim) {
        if find(word).is_some() || (Path::new(word).is_file() && word != "motion") {
            let Some(found) = choose(word, machine, errors, findings)? else { return Ok(None) };
            all.extend(found);
        } else if word == "motion" {
            all.extend(of_motion(machine, data, pieces).into_iter().map(Parameter::from));
        } else {
            all.extend(named(word, machine, data, pieces)?.into_iter().map(Parameter::from));
        }
    }
    if all.len() > MOST {
        let count = all.len();
        return Err(Error::usage(format!(
            "--select gives {count} candidates, but at most {MOST} can be tested; give wider --knots"
        )));
    }
    Ok(Some(all))
}

/// An error with all its terms, or a parameter.
fn named(
    word: &str,
    machine: &Machine,
    data: &[DataSet],
    pieces: PiecewisePolynomials,
) -> Result<Vec<ParameterName>, Error> {
    let component = word.parse::<ErrorName>().ok().filter(|name| name.kind == ErrorKind::Motion);
    let found = match component {
        Some(component) => of_component(component, data, pieces),
        None => vec![word.parse::<ParameterName>().map_err(|_| {
            Error::usage(format!(
                "--select {word} is not a preset, an error such as EXX, a parameter such as EXX2@150 or a file; motion has all motion errors of the linear axes"
            ))
        })?],
    };
    match found.iter().find_map(|name| name.component.axis().filter(|&axis| machine.axis(axis).is_none())) {
        Some(axis) => Err(Error::usage(format!("--select {word}: the machine {} has no axis {axis}", machine.name))),
        None => Ok(found),
    }
}
