//! The machine file with the findings of a diagnosis: the old text, new entries, and a joint fit of all parameters.

use super::not_identified;
use super::widened::widen_to;
use crate::calibrate::{Fit, FitOptions, Parameter, add_certificates, fit};
use crate::diagnose::cause::range;
use crate::diagnose::extend::{Anchor, Change, again, cleaned, effect_of_others, note};
use crate::diagnose::{AcceptedCause, DiagnosedCauses, EXPANDED, Scene, levels, residuals};
use crate::measure::data::DataSet;
use crate::measure::ranges::measured_ranges;
use crate::results::not_shown::not_shown;
use crate::results::uncertain::uncertainty_of;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::edit::Edit;
use ncfix_model::motion::EntryFunction;
use ncfix_model::name::{ErrorKind, ErrorName};
use ncfix_model::parameter::ComponentTerm;
use ncfix_model::{ErrorModel, ModelRegisters, ParameterName, file, write};

const MACHINE: FileId = FileId(0);
/// Relative tolerance of values read back, due to the written digits.
const DIGITS: f64 = 1e-9;
const SECTIONS: &str = "write [location] and [[motion]] as separate sections";

/// The content to be written.
pub(super) struct ExtensionJob<'a> {
    pub(super) machine: &'a Machine,
    /// Error types of its file.
    pub(super) registers: ModelRegisters,
    pub(super) scene: &'a Scene<'a>,
    /// Number of used measurements; those after them were held out.
    pub(super) used: usize,
    pub(super) found: &'a DiagnosedCauses,
    /// For every finding its changes, or the reason why it has no changes.
    pub(super) extension: Vec<Result<Vec<Change>, String>>,
}

/// The extended file.
#[derive(Clone, Debug)]
pub struct Extended {
    /// The text, or the reason why it cannot be written, with help.
    pub text: Result<String, NotWritten>,
    /// For every finding the reason why it is not in the file; `None` if it is.
    pub why_not: Vec<Option<String>>,
    /// Residuals of the model and of this file, mm or rad, for the used and for the held-out readings; `None` without a text, or without such
    /// readings.
    pub residuals: [Option<[f64; 2]>; 2],
}

impl Extended {
    /// The text; without one, a diagnostic states the reason.
    #[must_use]
    pub fn text(self, findings: &mut Vec<Diagnostic>) -> Option<String> {
        self.text.map_err(|(message, help)| findings.push(Diagnostic::nowhere(Code::NOT_TOLD, message, help))).ok()
    }
}

/// The machine file at the start, its error types, and the name of the head in use if it has heads.
pub(super) type StartFile<'a> = (&'a Source, &'a ModelRegisters, Option<&'a str>);

/// Reason why something is not written, and help.
pub type NotWritten = (String, &'static str);

/// A text with some findings, each with its place.
struct Grown {
    text: String,
    anchors: Vec<Result<Vec<Anchor>, String>>,
}

impl ExtensionJob<'_> {
    /// Creates the extended machine file, written or not: errors that it cannot contain are not called correctable either. `None` if it is not text.
    pub(super) fn make(&self, old: &Source, findings: &mut Vec<Diagnostic>) -> Option<Extended> {
        let text = std::str::from_utf8(old.bytes()).ok()?;
        let grown = self.grow(old, text);
        let mut why_not: Vec<Option<String>> = grown.anchors.iter().map(|one| one.clone().err()).collect();
        let text = self.text(old, text, &grown, findings);
        if let Err((message, _)) = &text {
            for why in &mut why_not {
                why.get_or_insert_with(|| message.clone());
            }
        }
        let residuals = text.as_ref().map_or([None; 2], |text| self.residuals(old, text));
        Some(Extended { text, why_not, residuals })
    }

    /// The machine file, with the head with which the readings were taken.
    fn of<'s>(&'s self, old: &'s Source) -> StartFile<'s> {
        (old, &self.registers, self.machine.heads.first().map(|head| head.name.as_str()))
    }

    /// Residuals of the current model and of a written one, of the used and of the held-out readings.
    fn residuals(&self, old: &Source, text: &str) -> [Option<[f64; 2]>; 2] {
        let Some(written) = load(self.of(old), text) else { return [None; 2] };
        let Some(after) = self.with_errors(&written, &[]) else { return [None; 2] };
        let none = vec![false; self.found.findings.len()];
        let effects = effect_of_others(self.found, self.scene, &none);
        let explained: Vec<f64> =
            self.scene.items.iter().zip(effects).map(|(item, effect)| item.left - effect).collect();
        residuals([self.scene, &after], self.used, &explained)
    }

    /// Applies the changes of one finding after another; incompatible ones are left out.
    fn grow(&self, old: &Source, text: &str) -> Grown {
        let mut grown = Grown { text: note::without_left_out(text), anchors: Vec::new() };
        for changes in &self.extension {
            let made = changes.clone().and_then(|changes| {
                let mut own = grown.text.clone();
                let anchors =
                    changes.iter().map(|change| made(self.of(old), &mut own, change)).collect::<Result<Vec<_>, _>>()?;
                if anchors.is_empty() {
                    return Err("the readings do not determine its size".into());
                }
                Ok((own, anchors))
            });
            grown.anchors.push(made.map(|(text, anchors)| {
                grown.text = text;
                anchors
            }));
        }
        grown
    }

    /// The text, or the error and help.
    fn text(
        &self,
        old: &Source,
        original: &str,
        grown: &Grown,
        findings: &mut Vec<Diagnostic>,
    ) -> Result<String, NotWritten> {
        if grown.anchors.iter().all(Result::is_err) {
            let help = "run the diagnosis without -o; --json gives the reason for each finding (extends_why)";
            let reason = grown.anchors.iter().find_map(|one| one.as_ref().err());
            let message = reason.map_or_else(
                || "nothing was found that a machine file can hold".to_owned(),
                |reason| format!("none of the causes found is written. The first one: {reason}"),
            );
            return Err((message, help));
        }
        let fault = || (format!("{} cannot be read back", old.name()), SECTIONS);
        let from = self.of(old);
        let read = load(from, &grown.text).ok_or_else(fault)?;
        let original = load(from, original).ok_or_else(fault)?;
        let changes: Vec<Change> = self
            .extension
            .iter()
            .zip(&grown.anchors)
            .filter(|(_, anchors)| anchors.is_ok())
            .flat_map(|(changes, _)| changes.iter().flatten().cloned())
            .collect();
        let parameters = again(&original, &read, &changes);
        let mut fitted = self.fitted(&read, &parameters, grown, findings);
        if let Some(fitted) = &mut fitted {
            let all = self.found.findings.iter().zip(&self.extension).zip(&grown.anchors);
            let written: Vec<(&AcceptedCause, &[Change])> = all
                .filter(|(_, anchors)| anchors.is_ok())
                .filter_map(|((one, changes), _)| Some((one, changes.as_deref().ok()?)))
                .collect();
            widen_to(fitted, &written);
        }
        let errors = fitted.as_ref().map_or(&read, |fitted| &fitted.errors);
        let even = self.without_means([&original, errors], &parameters);
        let errors = even.as_ref().unwrap_or(errors);
        let changed = write::write(&grown.text, &read, errors).map_err(|reason| (reason.0, SECTIONS))?;
        let used = self.scene.sets.iter().take(self.used);
        let sets: Vec<&DataSet> = used.collect();
        let mut ranges = measured_ranges(self.machine, sets.iter().copied(), None);
        let known: Vec<ParameterName> = parameters.iter().filter_map(|one| one.to_string().parse().ok()).collect();
        ranges.not_shown = not_shown(self.machine, &original, &ranges, &sets, (&[], &known));
        let changed = ranges.written_into(&changed).ok_or(("measured is not a section".to_owned(), SECTIONS))?;
        let before = self.machine.uncertainty.as_ref();
        let changed = match fitted.as_ref().map(|fit| uncertainty_of(before, fit, None)) {
            Some(found) => found.written_into(&changed).ok_or(("uncertainty is not a section".to_owned(), SECTIONS))?,
            None => changed,
        };
        let out = self.noted(&changed, grown, fitted.as_ref());
        let written = load(from, &out).ok_or(("the result is not a valid machine file".to_owned(), SECTIONS))?;
        for parameter in &parameters {
            let [found, read] = [errors, &written].map(|errors| parameter.get(errors));
            if (found - read).abs() > DIGITS * found.abs() + f64::MIN_POSITIVE {
                return Err((format!("{parameter} would read {read:e} instead of {found:e}"), SECTIONS));
            }
        }
        self.helps(&written, grown).map(|()| out)
    }

    /// Errors in which angles of linear axes do not change their mean over the measured positions, because the mean is a squareness (ISO 230-1),
    /// which the readings may not determine. `None` if there is no such angle, or if the readings determine its mean.
    fn without_means(&self, [old, new]: [&ErrorModel; 2], parameters: &[Parameter]) -> Option<ErrorModel> {
        let mut angles: Vec<ErrorName> = parameters
            .iter()
            .filter_map(|one| match one {
                Parameter::Geometry(name) if matches!(name.term, ComponentTerm::Coefficient(1..)) => {
                    Some(name.component)
                }
                _ => None,
            })
            .filter(|name| name.direction.is_rotation() && name.axis().is_some_and(|axis| !axis.is_rotary()))
            .collect();
        angles.sort_unstable();
        angles.dedup();
        let mut out = new.clone();
        for &component in &angles {
            let [low, high] = range(self.scene, component.axis()?)?;
            let coefficient = |degree| ParameterName { component, term: ComponentTerm::Coefficient(degree) };
            let mean = |errors: &ErrorModel| -> f64 {
                let of = |degree: u8| {
                    let next = i32::from(degree) + 1;
                    coefficient(degree).get(errors) * (high.powi(next) - low.powi(next))
                        / (f64::from(next) * (high - low))
                };
                (1..=HIGHEST_DEGREE).map(of).sum()
            };
            let constant = coefficient(0);
            constant.set(&mut out, constant.get(new) - (mean(new) - mean(old)));
        }
        let [before, after] = self.levels([new, &out], &[]);
        (!angles.is_empty() && after[0] <= SAME * before[0] && after[1] <= SAME * before[1]).then_some(out)
    }

    /// All parameters fitted together; `None` if they keep the values of the search.
    fn fitted(
        &self,
        read: &ErrorModel,
        parameters: &[Parameter],
        grown: &Grown,
        findings: &mut Vec<Diagnostic>,
    ) -> Option<Fit> {
        let holds: Vec<bool> = grown.anchors.iter().map(Result::is_ok).collect();
        if parameters.is_empty() {
            return None;
        }
        let help = "they are written as the search found them; for the best values, calibrate with them";
        let mut stay = |why: String| {
            let message = format!("the new terms were not fitted again together: {why}");
            findings.push(Diagnostic::nowhere(Code::REDUCED, message, help));
        };
        let Some(data) = cleaned(self.found, self.scene, self.used, &holds) else {
            stay("excluded readings, or findings without an entry in the machine file, cannot be removed from these data".into());
            return None;
        };
        // Including time constants, which the search took from a list; without them if that fails.
        let linear: Vec<Parameter> = parameters.iter().filter(|one| one.is_linear()).cloned().collect();
        let found = self.fit(read, parameters, &data);
        let found =
            if linear.len() < parameters.len() { found.or_else(|_| self.fit(read, &linear, &data)) } else { found };
        found.map_err(stay).ok()
    }

    /// A fit as good as the result of the search; least squares without autocorrelation of the noise fail if terms are similar.
    fn fit(&self, read: &ErrorModel, parameters: &[Parameter], data: &[DataSet]) -> Result<Fit, String> {
        let found = fit(self.machine, read, parameters, data, FitOptions { robust: true });
        let mut found = found.map_err(not_identified::words)?;
        add_certificates(self.machine, parameters, data, FitOptions { robust: true }, &mut found)
            .map_err(not_identified::words)?;
        let [of_search, level] = self.levels([read, &found.errors], &[]);
        if level[0] > LOST * of_search[0] {
            return Err("the residual was larger than with the values of the search".into());
        }
        if level[1] > LOST * of_search[1] {
            return Err("the values of the search predict the held-out data better".into());
        }
        Ok(found)
    }

    /// The text with notes at the terms, and a list of left-out findings after it.
    fn noted(&self, text: &str, grown: &Grown, fitted: Option<&Fit>) -> String {
        let Some(mut edit) = Edit::parse(text) else { return text.to_owned() };
        let name = |set: &DataSet| set.name.clone();
        let (used, held_out) = self.scene.sets.split_at(self.used.min(self.scene.sets.len()));
        let files =
            note::Files { used: used.iter().map(name).collect(), held_out: held_out.iter().map(name).collect() };
        let mut behind = Vec::new();
        let all = self.found.findings.iter().zip(&self.extension).zip(&grown.anchors);
        for ((one, changes), anchors) in all {
            match (changes, anchors) {
                (Ok(changes), Ok(anchors)) => {
                    let mut lines = note::lines(one, changes, &files, &estimates(changes, fitted));
                    lines.extend(self.with_every_head(changes));
                    let is_done = match anchors.first() {
                        Some(Anchor::Key(section, key)) => edit.note_key(section, key, &lines),
                        Some(Anchor::Entry(list, index)) => edit.note(list, *index, &lines),
                        None => false,
                    };
                    if !is_done {
                        behind.extend(lines.iter().map(|line| format!("# {line}")));
                    }
                }
                (_, Err(why)) | (Err(why), _) => behind.push(note::left_out(one, why)),
            }
        }
        let mut out = edit.text();
        if !behind.is_empty() {
            out = format!("{}\n\n{}\n", out.trim_end(), behind.join("\n"));
        }
        out
    }

    /// The line about an error of an axis of a machine with several heads: it acts with all of them.
    fn with_every_head(&self, changes: &[Change]) -> Option<String> {
        let head = self.machine.heads.first().filter(|_| self.machine.heads.len() > 1)?;
        let is_of_axis =
            |change: &Change| matches!(change, Change::Parameter { name, .. } if name.component.axis().is_some());
        changes
            .iter()
            .any(is_of_axis)
            .then(|| format!("  an error of an axis acts with every head; it was found with {}", head.name))
    }

    /// RMS levels of the readings with two models, after subtracting an amount from each, mm or rad.
    fn levels(&self, errors: [&ErrorModel; 2], away: &[f64]) -> [[f64; 2]; 2] {
        let scenes = errors.map(|errors| self.with_errors(errors, away));
        match &scenes {
            [Some(one), Some(other)] => levels([one, other], self.used),
            _ => [[f64::INFINITY; 2]; 2],
        }
    }

    /// The readings with other errors, after subtracting an amount from each, mm or rad; `None` if they do not determine the set-ups.
    fn with_errors(&self, errors: &ErrorModel, away: &[f64]) -> Option<Scene<'_>> {
        let new = Scene::new(self.machine, errors, self.scene.sets).ok()?;
        // Data excluded as faulty do not count here either, and rows with their own zero keep it.
        let mut scene = self.scene.clone();
        scene.items.iter_mut().zip(&new.items).for_each(|(item, new)| item.left = new.left);
        scene.items.iter_mut().zip(away).for_each(|(item, away)| item.left -= away);
        Some(scene)
    }

    /// Checks that the model fits the data better with the change, on the held-out data if there are any. The effects of findings that the file does
    /// not hold are subtracted from the readings for both models: they remain uncorrected and may have absorbed a part of the correction.
    fn helps(&self, errors: &ErrorModel, grown: &Grown) -> Result<(), NotWritten> {
        let holds: Vec<bool> = grown.anchors.iter().map(Result::is_ok).collect();
        let away = effect_of_others(self.found, self.scene, &holds);
        let [before, after] = self.levels([&self.scene.errors, errors], &away);
        let which = if after[0].is_infinite() {
            "the data"
        } else if after[0] > before[0] {
            "the data used"
        } else if after[1] > before[1] {
            "the data held out"
        } else {
            return Ok(());
        };
        let message = format!("the extended model predicts {which} worse than the current model");
        Err((message, "measure more, or in other poses; the findings remain unchanged"))
    }
}

/// Highest degree of a polynomial that a finding writes.
const HIGHEST_DEGREE: u8 = 6;
/// The readings are insensitive to a change if the residual increases by a smaller factor than this.
const SAME: f64 = 1.001;
/// Largest accepted ratio of the residual to that of the search.
const LOST: f64 = 1.01;

/// Makes one change in a text. Returns its place, or the reason why it fails.
pub(super) fn made(from: StartFile<'_>, text: &mut String, change: &Change) -> Result<Anchor, String> {
    let no = || "it conflicts with an entry of the machine file".to_owned();
    let anchor = if let Change::Parameter { name, amount } = change {
        let read = load(from, text).ok_or_else(no)?;
        let mut errors = read.clone();
        name.set(&mut errors, name.get(&read) + amount);
        *text = write::write(text, &read, &errors).map_err(|reason| reason.0)?;
        place_of(name, &errors)
    } else if from.2.is_some() {
        return Err("the machine has heads, and such an entry may belong to one of them: write it by hand".into());
    } else {
        let mut edit = Edit::parse(text).ok_or_else(no)?;
        let anchor = change.make(&mut edit)?;
        *text = edit.text();
        anchor
    };
    load(from, text).ok_or_else(no)?;
    Ok(anchor)
}

/// Place of a parameter.
fn place_of(name: &ParameterName, errors: &ErrorModel) -> Anchor {
    if name.component.kind == ErrorKind::Location {
        return Anchor::Key("location", name.component.to_string());
    }
    let own = |function: &EntryFunction| match name.term {
        ComponentTerm::Backlash => matches!(function, EntryFunction::Backlash(_)),
        ComponentTerm::Knot { .. } => matches!(function, EntryFunction::Piecewise(_)),
        _ => matches!(function, EntryFunction::Polynomial(_) | EntryFunction::Piecewise(_)),
    };
    let index = errors.motion.iter().position(|error| error.name == name.component && own(&error.function));
    Anchor::Entry("motion", index.unwrap_or(0))
}

/// Fitted parameters of some changes: name, value, expanded uncertainty (95 %), unit.
fn estimates(changes: &[Change], fitted: Option<&Fit>) -> Vec<(String, f64, f64, String)> {
    let Some(fitted) = fitted else { return Vec::new() };
    let is_own = |parameter: &Parameter| changes.iter().any(|change| change.is_of(parameter));
    let mut out = Vec::new();
    for estimate in &fitted.estimates {
        let Some(parameter) = estimate.column.parameter().filter(is_own) else { continue };
        let (factor, unit) = match &parameter {
            Parameter::Geometry(name) => (1.0, name.unit()),
            Parameter::Effect(own) => (own.unit().0, own.unit().1.to_owned()),
        };
        // The file has the full value.
        let is_half = matches!(parameter, Parameter::Geometry(name) if name.term == ComponentTerm::Backlash);
        let half = if is_half { " (half of the reversal value)" } else { "" };
        out.push((format!("{parameter}{half}"), factor * estimate.value, factor * EXPANDED * estimate.sigma, unit));
    }
    out
}

/// The errors of a machine file, with the head in use.
pub(super) fn load((old, registers, head): StartFile<'_>, text: &str) -> Option<ErrorModel> {
    let source = Source::new(MACHINE, old.name(), text.as_bytes().to_vec()).ok()?;
    let (machine, errors) = file::load_with(&source, registers).0?;
    match head {
        None => Some(errors).filter(|errors| errors.heads.is_empty()),
        Some(name) => Some(errors.of_head(u16::try_from(machine.head_named(name)?).ok()?)),
    }
}
