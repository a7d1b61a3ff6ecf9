//! `--model`: the parameters of a preset, or those of a file.

use std::path::Path;

use super::files;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use ncfix_base::source::FileId;
use ncfix_machine::machine::Machine;
use ncfix_metrology::calibrate::Parameter;
use ncfix_metrology::results::parameters::read;
use ncfix_model::ErrorModel;
use ncfix_model::preset::{PRESETS, find};

/// The parameters of `--model`; `None` where findings forbid to use them. A preset goes before a file of its name.
///
/// # Errors
/// Where there is neither preset nor file, or the preset does not suit the machine.
pub(crate) fn choose(
    model: &str,
    machine: &Machine,
    errors: &ErrorModel,
    findings: &mut Diagnostics,
) -> Result<Option<Vec<Parameter>>, Error> {
    if let Some(preset) = find(model) {
        let parameters = (preset.parameters)(machine).map_err(|reason| {
            Error::usage(format!("preset {model} does not suit the machine {}: {reason}", machine.name))
        })?;
        return Ok(Some(parameters.into_iter().map(Parameter::from).collect()));
    }
    let path = Path::new(model);
    if !path.is_file() {
        let known: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        let known = known.join(", ");
        return Err(Error::usage(format!("--model {model} is no file and no preset; the presets are {known}")));
    }
    let source = files::read_written(path, FileId(0), "parameters of the model, --model")?;
    let (parameters, found) = read(&source, machine, errors);
    let is_sound = found.is_empty();
    findings.extend(found, std::slice::from_ref(&source));
    Ok(is_sound.then_some(parameters))
}
