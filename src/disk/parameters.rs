//! Parameters of a model: those of a preset or of a file (`--model`), and candidates among which is chosen (`--select`).

use std::path::Path;

use super::files;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;
use ncfix_metrology::calibrate::automatic::{angle_candidates, usual_candidates, usual_errors};
use ncfix_metrology::calibrate::candidates::{PiecewisePolynomials, of_component, of_motion};
use ncfix_metrology::calibrate::{Parameter, effect, reduce};
use ncfix_metrology::measure::data::DataSet;
use ncfix_metrology::results::not_shown::shown_angles;
use ncfix_metrology::results::parameters::{ModelText, read, states_term};
use ncfix_model::ErrorModel;
use ncfix_model::name::{ErrorKind, ErrorName};
use ncfix_model::parameter::ParameterName;
use ncfix_model::preset::{PRESETS, find};

/// The word for the model that the data determine, and for its candidates.
pub(crate) const AUTO: &str = "auto";

/// The model of a calibration.
#[derive(Debug, Default)]
pub(crate) struct ChosenModel {
    /// Named parameters and stated terms.
    pub(crate) text: ModelText,
    /// True if the usual errors of the machine are added to them, as far as the data determine them.
    pub(crate) is_automatic: bool,
}

impl ChosenModel {
    /// Reads `--model` of a calibration: as [`choose_model`], also with the word `auto`, and `none` if candidates are given; `None` if there are errors.
    ///
    /// # Errors
    /// Those of [`choose_model`].
    pub(crate) fn read(
        model: &str,
        has_candidates: bool,
        machine: &Machine,
        errors: &ErrorModel,
        findings: &mut Diagnostics,
    ) -> Result<Option<ChosenModel>, Error> {
        let words: Vec<&str> = model.split(',').map(str::trim).collect();
        let is_automatic = words.contains(&AUTO) && !Path::new(model).is_file();
        let rest = words.iter().copied().filter(|word| *word != AUTO).collect::<Vec<_>>().join(",");
        let named = if is_automatic { rest.as_str() } else { model };
        let text = match named {
            "" if is_automatic => Some(ModelText::default()),
            "none" if has_candidates => Some(ModelText::default()),
            named => choose_model(named, machine, errors, findings)?,
        };
        Ok(text.map(|text| ChosenModel { text, is_automatic }))
    }

    /// The model with the usual errors, if it is automatic; and usual errors that the data do not determine, which only a fit without stated terms takes, to
    /// report them.
    pub(crate) fn for_data(
        self,
        machine: &Machine,
        errors: &ErrorModel,
        data: &[DataSet],
    ) -> (ModelText, Vec<Parameter>) {
        let mut text = self.text;
        if !self.is_automatic {
            return (text, Vec::new());
        }
        let usual = usual_errors(machine, errors, data).into_iter().map(Parameter::from);
        let more: Vec<Parameter> = usual.filter(|one| !text.parameters.contains(one)).collect();
        text.parameters.extend(more);
        let found = text.terms.as_ref().and_then(|_| reduce(machine, errors, &text.parameters, data));
        let Some(found) = found else { return (text, Vec::new()) };
        let (kept, others) = text.parameters.into_iter().partition(|one| found.parameters.contains(one));
        (ModelText { parameters: kept, ..text }, others)
    }
}

/// The parameters of a model without stated terms; `None` if there are errors.
///
/// # Errors
/// If it has such terms, or [`choose_model`] cannot read it.
pub(crate) fn choose(
    model: &str,
    machine: &Machine,
    errors: &ErrorModel,
    findings: &mut Diagnostics,
) -> Result<Option<Vec<Parameter>>, Error> {
    let Some(found) = choose_model(model, machine, errors, findings)? else { return Ok(None) };
    if found.terms.is_some() {
        return Err(Error::usage(format!(
            "{model} states terms, which only `ncfix calibrate --model` and `ncfix diagnose --hypothesis` take; name parameters here, such as EXX1"
        )));
    }
    Ok(Some(found.parameters))
}

/// The model of `--model`: a preset, a file, or parameters and terms separated by commas; `None` if there are errors. A preset takes precedence over a file with its name.
///
/// # Errors
/// If it is not one of these, or a preset does not suit the machine.
pub(crate) fn choose_model(
    model: &str,
    machine: &Machine,
    errors: &ErrorModel,
    findings: &mut Diagnostics,
) -> Result<Option<ModelText>, Error> {
    let of_preset = |name: &str| {
        let preset = find(name)?;
        let parameters = (preset.parameters)(machine).map_err(|reason| {
            Error::usage(format!("preset {name} is not applicable to the machine {}: {reason}", machine.name))
        });
        Some(parameters.map(|all| all.into_iter().map(Parameter::from).collect::<Vec<_>>()))
    };
    if let Some(parameters) = of_preset(model) {
        return Ok(Some(ModelText { parameters: parameters?, terms: None }));
    }
    let path = Path::new(model);
    let (mut parameters, mut lines) = (Vec::new(), Vec::new());
    let source = if path.is_file() {
        files::read_written(path, FileId(0), files::option("parameters of the model, --model"))?
    } else {
        for part in model.split(',').map(str::trim) {
            if let Some(own) = of_preset(part) {
                parameters.extend(own?);
            } else if is_named(part, errors) || states_term(part) {
                lines.push(part);
            } else {
                let known: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
                let known = known.join(", ");
                if part == AUTO {
                    return Err(Error::usage(format!(
                        "--model auto needs readings, so only `ncfix calibrate` takes it; name a preset ({known}) or parameters such as EXX1 here"
                    )));
                }
                return Err(Error::usage(format!(
                    "--model {part} is neither a file, nor a preset, a parameter such as EXX1 or a term such as \"EXX ~ Y^2\"; the presets are {known}; separate several by commas; auto takes what the data determine, and `none` needs --select"
                )));
            }
        }
        if lines.is_empty() {
            return Ok(Some(ModelText { parameters, terms: None }));
        }
        let text = lines.join("\n").into_bytes();
        Source::new(FileId(0), "--model", text).map_err(|_| Error::usage("--model is too long".into()))?
    };
    let (mut found, faults) = read(&source, machine, errors);
    let is_sound = faults.is_empty();
    findings.extend(faults, std::slice::from_ref(&source));
    found.parameters.retain(|one| !parameters.contains(one));
    found.parameters.splice(..0, parameters);
    Ok(is_sound.then_some(found))
}

/// True for a text that names a parameter of the geometry or of an effect.
fn is_named(text: &str, errors: &ErrorModel) -> bool {
    text.parse::<ParameterName>().is_ok() || !effect::named(&effect::effect_parameters(errors), text).is_empty()
}

/// Maximum number of candidates.
const MOST: usize = 2000;

/// The candidates of `--select`: presets, files, errors, parameters, `motion`; `None` if there are errors.
///
/// # Errors
/// If a word names no candidate, or there are too many of them.
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
        } else if word == AUTO {
            all.extend(usual_candidates(machine, data, pieces).into_iter().map(Parameter::from));
            let angles = shown_angles(machine, errors, data);
            all.extend(angle_candidates(&angles, pieces).into_iter().map(Parameter::from));
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
