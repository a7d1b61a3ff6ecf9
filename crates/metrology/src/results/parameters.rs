//! The model of a calibration from a text: parameters by name, and terms stated by the user.

use std::collections::HashSet;

use crate::calibrate::Parameter;
use crate::calibrate::effect::{self, EffectParameter, effect_parameters};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};
use ncfix_machine::machine::Machine;
use ncfix_model::parameter::ParameterName;
use ncfix_model::{ErrorModel, ErrorName};

/// Maximum number of names in a help text.
const MOST_SHOWN: usize = 12;

/// The message for a line that begins like effect parameters but names none of this machine file.
fn no_effect(text: &str, effects: &[EffectParameter]) -> Option<(String, String)> {
    const SECTIONS: [&str; 4] = ["load", "drift", "expansion", "segment"];
    let end = text.find(['.', '@', '[', '~']).unwrap_or(text.len());
    let section = SECTIONS.into_iter().find(|&section| text.get(..end) == Some(section))?;
    let own: Vec<&str> =
        effects.iter().map(EffectParameter::name).filter(|name| name.split('.').next() == Some(section)).collect();
    if own.is_empty() {
        let message = format!("{text}: the machine file has no [[{section}]]");
        return Some((message, format!("add [[{section}]] with initial values to the machine file")));
    }
    let shown = own.iter().take(MOST_SHOWN).copied().collect::<Vec<_>>().join(", ");
    let more = if own.len() > MOST_SHOWN { " …" } else { "" };
    Some((format!("{text} is not a parameter of [[{section}]]"), format!("there are {shown}{more}")))
}

/// A model in a text.
#[derive(Clone, Debug, Default)]
pub struct ModelText {
    /// Named parameters.
    pub parameters: Vec<Parameter>,
    /// The lines with stated terms, at their positions in the text, for [`crate::diagnose::stated::read`]; `None` without any.
    pub terms: Option<Source>,
}

/// True for a line of a model that states a term: parameters have no spaces, signs or points but those of effects.
#[must_use]
pub fn states_term(text: &str) -> bool {
    let is_component = |name: &str| name.parse::<ErrorName>().is_ok();
    text.contains(|sign: char| sign.is_whitespace() || "~*(=".contains(sign))
        || text.split_once('.').is_some_and(|(name, _)| is_component(name))
}

/// The model of a text: a parameter or a term per line, with comments after `#`. Diagnostics for invalid and repeated lines.
#[must_use]
pub fn read(source: &Source, machine: &Machine, errors: &ErrorModel) -> (ModelText, Vec<Diagnostic>) {
    let (mut parameters, mut findings) = (Vec::new(), Vec::new());
    // Other lines become comments of their length.
    let mut terms = Vec::new();
    let mut has_terms = false;
    let effects = effect_parameters(errors);
    let mut seen = HashSet::new();
    let mut start = 0;
    for line in source.bytes().split(|&byte| byte == b'\n' || byte == b'\r') {
        let first = start;
        start += line.len() + 1;
        terms.resize(first, b'\n');
        terms.extend(std::iter::repeat_n(b'#', line.len()));
        let content = line.split(|&byte| byte == b'#').next().unwrap_or_default();
        let word = content.trim_ascii();
        if word.is_empty() {
            continue;
        }
        let from = first + (content.len() - content.trim_ascii_start().len());
        let place = Place { file: source.id(), span: Span::new(from, from + word.len()) };
        let mut report = |message: String, help: &str| {
            findings.push(Diagnostic::at(Code::BAD_PARAMETER, place, message, help));
        };
        let text = String::from_utf8_lossy(word);
        let of_effects = effect::named(&effects, &text);
        if !of_effects.is_empty() {
            for one in of_effects {
                if seen.insert(one.name().to_owned()) {
                    parameters.push(Parameter::from(one));
                } else {
                    report(format!("{} is given twice", one.name()), "remove one of the lines");
                }
            }
            continue;
        }
        if let Some((message, help)) = no_effect(&text, &effects) {
            report(message, &help);
            continue;
        }
        if states_term(&text) {
            has_terms = true;
            terms.truncate(first);
            terms.extend_from_slice(line);
            continue;
        }
        let help = "write one in each line: EC0Y, EXX1, EXXb, EXX2@150, load.EAX, drift, or a term such as EXX ~ Y^2; comments begin with #";
        match text.parse::<ParameterName>() {
            Err(_) => report(format!("'{text}' is not a parameter"), help),
            Ok(name) => match name.component.axis().filter(|&axis| machine.axis(axis).is_none()) {
                Some(axis) => report(
                    format!("{name}: the machine {} has no axis {axis}", machine.name),
                    "remove it, or check --machine",
                ),
                None if !seen.insert(name.to_string()) => {
                    report(format!("{name} is given twice"), "remove one of them")
                }
                None => parameters.push(Parameter::from(name)),
            },
        }
    }
    if parameters.is_empty() && findings.is_empty() && !has_terms {
        let place = Place { file: source.id(), span: Span::new(0, source.bytes().len().min(1)) };
        findings.push(Diagnostic::at(Code::BAD_PARAMETER, place, "the file names no parameter", "write at least one"));
    }
    let terms = Source::new(source.id(), source.name(), terms).ok().filter(|_| has_terms);
    (ModelText { parameters, terms }, findings)
}
