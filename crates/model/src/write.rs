//! Writes changed errors into the text of a machine file and keeps the rest unchanged.
//!
//! The sources state the places of the parameters of effects ([`super::source::WrittenAt`]). The other errors must be those that were read from this text, with
//! some numbers changed and entries appended, as by [`ParameterName::set`](super::parameter::ParameterName::set).

use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::edit::{Edit, Given};

use super::motion::{EntryFunction, MotionError};
use super::{Effect, ErrorModel, LocationError};

/// Reason why a change cannot be written: a sentence without a full stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotWritable(pub String);

/// Returns the text of a machine file with `changed` instead of `read`, which was read from it.
///
/// # Errors
/// [`NotWritable`] if the text does not contain what was read from it.
pub fn write(text: &str, read: &ErrorModel, changed: &ErrorModel) -> Result<String, NotWritable> {
    let mut edit = Edit::parse(text).ok_or_else(|| NotWritable("the machine file is not TOML".into()))?;
    // Index of the head of an error, and the index of the error in it; `None` for a common error.
    let in_head = |kind: usize, index: usize| {
        let entries = read.head_entries?;
        Some((entries.index, index.checked_sub(entries.common[kind])?))
    };
    for (index, error) in changed.location.iter().enumerate() {
        let old = read.location.get(index);
        if old == Some(error) {
            continue;
        }
        let (key, given) = (error.name.to_string(), value_of(error));
        // A new error of the spindle is that of its head.
        let is_done = match in_head(0, index).filter(|_| old.is_some() || error.name.axis().is_none()) {
            Some((head, _)) => edit.set_of("head", head, "location", &key, &given),
            None => edit.set("location", &key, &given),
        };
        if !is_done {
            return Err(NotWritable("location of the machine file is not a section".into()));
        }
    }
    for (index, error) in changed.motion.iter().enumerate() {
        let old = read.motion.get(index);
        if old == Some(error) {
            continue;
        }
        let keys = keys_of(error, old)?;
        let is_done = match old {
            Some(_) => match in_head(1, index) {
                Some((head, own)) => {
                    keys.iter().all(|(key, given)| edit.set_at("head", head, &format!("motion[{own}].{key}"), given))
                }
                None => keys.iter().all(|(key, given)| edit.set_in("motion", index, key, given)),
            },
            None => {
                let head = [("component".to_owned(), Given::Text(error.name.to_string()))];
                edit.push("motion", &head.into_iter().chain(keys).collect::<Vec<_>>())
            }
        };
        if !is_done {
            return Err(NotWritable(format!("the machine file has no [[motion]] number {}", index + 1)));
        }
    }
    for (number, (changed, old)) in changed.effects.iter().zip(&read.effects).enumerate() {
        let is_done = values_of(&**changed).iter().zip(values_of(&**old)).all(|(new, old)| {
            new.value.to_bits() == old.value.to_bits()
                || new.key.as_ref().is_some_and(|(entry, key)| {
                    let list = changed.source().sections.first().copied().unwrap_or_default();
                    let given = Given::Number(new.value * new.factor);
                    match in_head(2, number) {
                        Some((head, _)) => {
                            edit.set_at("head", head, &format!("{list}[{entry}].{key}"), &given)
                                || *entry == 0 && edit.set_at("head", head, &format!("{list}.{key}"), &given)
                        }
                        None => edit.set_at(list, *entry, key, &given),
                    }
                })
        });
        if !is_done {
            return Err(NotWritable(format!(
                "the machine file has no effect number {} of {}",
                number + 1,
                changed.label()
            )));
        }
    }
    Ok(edit.text())
}

/// Parameter of an effect with its place in the file.
struct Shown {
    value: f64,
    key: Option<(usize, String)>,
    factor: f64,
}

fn values_of(effect: &dyn Effect) -> Vec<Shown> {
    let mut out = Vec::new();
    effect.boxed().visit_parameters(&mut |parameter, value| {
        let factor = parameter.written.map_or(1.0, |written| written.factor);
        out.push(Shown {
            value: *value,
            key: parameter.written.map(|written| (written.entry, written.key.to_owned())),
            factor,
        });
    });
    out
}

fn value_of(error: &LocationError) -> Given {
    let is_rotation = error.name.direction.is_rotation();
    Given::Number(if is_rotation { urad_from_rad(error.value) } else { um_from_mm(error.value) })
}

/// Returns the keys to be written: all of a new entry; of an existing entry those that may have changed.
fn keys_of(error: &MotionError, old: Option<&MotionError>) -> Result<Vec<(String, Given)>, NotWritable> {
    let is_rotation = error.name.direction.is_rotation();
    let mut keys = Vec::new();
    let mut key = |name: &str, given| keys.push((name.to_owned(), given));
    match &error.function {
        EntryFunction::Polynomial(polynomial) => {
            if old.is_none() {
                key("kind", Given::Text("polynomial".into()));
            }
            key("coefficients", Given::Numbers(polynomial.coefficients.clone()));
        }
        EntryFunction::Piecewise(piecewise) => {
            let knots = &piecewise.knots;
            if old.is_none() {
                key("kind", Given::Text("piecewise".into()));
            }
            let parts = knots.iter().map(|knot| &knot.coefficients).chain([&piecewise.coefficients]);
            let degree = parts.map(Vec::len).max().unwrap_or(1).saturating_sub(1);
            key("degree", Given::Whole(i64::try_from(degree).unwrap_or(i64::MAX)));
            key("coefficients", Given::Numbers(piecewise.coefficients.clone()));
            let is_rotary = error.name.axis().is_some_and(|axis| axis.is_rotary());
            let entry = |knot: &super::motion::piecewise::Knot| {
                let (name, at) = if is_rotary { ("at_deg", knot.at.to_degrees()) } else { ("at_mm", knot.at) };
                vec![
                    (name.to_owned(), Given::Number(at)),
                    ("coefficients".to_owned(), Given::Numbers(knot.coefficients.clone())),
                ]
            };
            key("knots", Given::Entries(knots.iter().map(entry).collect()));
        }
        EntryFunction::Backlash(backlash) if backlash.reversal.values.len() == 1 => {
            if old.is_none() {
                key("kind", Given::Text("backlash".into()));
            }
            let value = backlash.reversal.values.first().copied().unwrap_or(0.0);
            let (name, value) =
                if is_rotation { ("value_urad", urad_from_rad(value)) } else { ("value_um", um_from_mm(value)) };
            key(name, Given::Number(value));
        }
        _ => return Err(NotWritable(format!("the error {} is of a kind that has no parameters", error.name))),
    }
    Ok(keys)
}
