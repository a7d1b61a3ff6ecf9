//! The machine file with what a diagnosis found: text of the old one, new entries, and all parameters fitted again together.

use super::diagnose::file_of;
use super::findings::Findings;
use super::input;
use super::machine_choice::Chosen;
use super::output::{Spool, Target};
use super::stop::Stop;
use crate::calibrate::effect::effect_parameters;
use crate::calibrate::{Options, Parameter, fit};
use crate::diagnose::extend::{Extension, noted};
use crate::diagnose::{Scene, levels};
use crate::diagnostic::{Code, Diagnostic};
use crate::model::{ErrorModel, file, write};
use crate::source::{FileId, Source};

const MACHINE: FileId = FileId(0);
/// What is read back may differ by the digits that are written.
const DIGITS: f64 = 1e-9;

/// What shall be written.
pub(super) struct Job<'a> {
    pub(super) chosen: &'a Chosen,
    pub(super) scene: &'a Scene<'a>,
    /// Measurements that were used; those behind them were held out.
    pub(super) used: usize,
    pub(super) extension: Extension,
}

impl Job<'_> {
    /// Writes the extended machine file. Returns whether it did; findings say why not.
    pub(super) fn write(&self, target: Target, findings: &mut Findings) -> Result<bool, Stop> {
        match self.text()? {
            Ok(text) => {
                let mut spool = Spool::new(target)?;
                if let Err(error) = spool.writer().write_all(text.as_bytes()) {
                    return Err(spool.fault(&error));
                }
                spool.publish(false)?;
                Ok(true)
            }
            Err((message, help)) => {
                findings.add(Diagnostic::nowhere(Code::NOT_TOLD, message, help), &[]);
                Ok(false)
            }
        }
    }

    /// The text, or what is wrong and what to do.
    fn text(&self) -> Result<Result<String, (String, &'static str)>, Stop> {
        let extension = &self.extension;
        if extension.entries.is_empty() && extension.parameters.is_empty() {
            let help = "without -o the diagnosis stands by itself";
            return Ok(Err(("nothing was found that a machine file can hold".into(), help)));
        }
        let Some(path) = file_of(self.chosen) else { return Err(Stop::Usage("-o needs --machine".into())) };
        let old = input::read(path, MACHINE)?;
        let Ok(text) = std::str::from_utf8(old.bytes()) else {
            return Err(Stop::Usage(format!("{} is not UTF-8", old.name())));
        };
        let begun = format!("{}\n{}", text.trim_end(), extension.entries);
        let (Some(read), Some(original)) = (load(&old, &begun), load(&old, text)) else {
            let message = format!("what was found does not go beside what {} has already", old.name());
            return Ok(Err((
                message,
                "take entries of the same direction or axis out of it, or add the terms by hand",
            )));
        };
        let errors = self.fitted(&original, &read);
        let changed = match write::write(&begun, &read, &errors) {
            Ok(changed) => changed,
            Err(reason) => return Ok(Err((reason.0, "write location and motion as sections of their own"))),
        };
        let out = noted(&changed, &extension.parameters);
        let Some(written) = load(&old, &out) else {
            return Ok(Err((
                "the result is no machine file".into(),
                "write location and motion as sections of their own",
            )));
        };
        for (name, ..) in &extension.parameters {
            let [found, read] = [name.get(&errors), name.get(&written)];
            if (found - read).abs() > DIGITS * found.abs() + f64::MIN_POSITIVE {
                let message = format!("{name} would read {read:e} in place of {found:e}");
                return Ok(Err((message, "write location and motion as sections of their own")));
            }
        }
        Ok(self.helps(&written).map(|()| out))
    }

    /// All parameters fitted together; their amounts where the fit cannot tell them apart as the search could.
    fn fitted(&self, original: &ErrorModel, read: &ErrorModel) -> ErrorModel {
        let known: Vec<String> = effect_parameters(original).iter().map(|one| one.name().to_owned()).collect();
        let new = effect_parameters(read).into_iter().filter(|one| !known.contains(&one.name().to_owned()));
        let mut parameters: Vec<Parameter> = new.map(Parameter::from).filter(Parameter::is_linear).collect();
        parameters.extend(self.extension.parameters.iter().map(|(name, ..)| Parameter::from(*name)));
        let mut start = read.clone();
        for (name, amount, _) in &self.extension.parameters {
            let value = name.get(&start) + amount;
            name.set(&mut start, value);
        }
        let data = self.scene.sets.get(..self.used).unwrap_or_default();
        match fit(&self.chosen.machine, &start, &parameters, data, Options { robust: true }) {
            Ok(found) => found.errors,
            Err(_) => start,
        }
    }

    /// Whether the model says the data better with it: the data held out where there are any.
    fn helps(&self, errors: &ErrorModel) -> Result<(), (String, &'static str)> {
        let before = levels(self.scene, self.used);
        let after = Scene::new(&self.chosen.machine, errors, self.scene.sets).map(|scene| levels(&scene, self.used));
        let worse = match after {
            Err(_) => Some("the data"),
            Ok(after) if after[0] > before[0] => Some("the data used"),
            Ok(after) if after[1] > before[1] => Some("the data held out"),
            Ok(_) => None,
        };
        match worse {
            None => Ok(()),
            Some(which) => {
                let message = format!("the extended model says {which} worse than the model as it is");
                Err((message, "measure more, or in other poses; the findings stand as they are"))
            }
        }
    }
}

/// The errors of a machine file.
fn load(old: &Source, text: &str) -> Option<ErrorModel> {
    let source = Source::new(MACHINE, old.name(), text.as_bytes().to_vec()).ok()?;
    file::load(&source).0.map(|(_, errors)| errors)
}
