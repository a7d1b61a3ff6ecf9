//! Changes of a machine file. Terms are added to existing ones of the same kind, so that none is written twice.

use crate::calibrate::Parameter;
use ncfix_base::geometry::Axis;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::edit::{Edit, Given};
use ncfix_machine::machine::uncertainty;
use ncfix_model::ParameterName;
use ncfix_model::name::{ErrorKind, ErrorName};
use ncfix_model::uncertainty::wave_name;

use super::warm;

/// The unit of a deviation in the file, and the factor to it.
pub(super) fn unit_of(name: ErrorName) -> (f64, &'static str) {
    if name.direction.is_rotation() { (urad_from_rad(1.0), "urad") } else { (um_from_mm(1.0), "um") }
}

/// Positions, periods and forces are equal within this share.
const SAME: f64 = 1e-9;

/// Waves are equal if their phases differ by less than this share of a period over the travel.
const TOGETHER: f64 = 0.05;

/// A change of the machine file.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Increases a parameter of the geometry, mm or rad per power.
    Parameter {
        /// The parameter.
        name: ParameterName,
        /// The increase.
        amount: f64,
    },
    /// A wave: `sine` sin(2π q/p) + `cosine` cos(2π q/p), mm or rad.
    Wave {
        /// The component.
        name: ErrorName,
        /// p, mm or degrees.
        period: f64,
        /// Amplitudes.
        parts: [f64; 2],
        /// Standard uncertainty of each amplitude, mm or rad.
        sigma: f64,
        /// First and last position at which it was measured, mm or degrees.
        travel: [f64; 2],
    },
    /// A table, a grid or a backlash that changes along the axis.
    Shape {
        /// The component.
        name: ErrorName,
        /// `table`, `grid`, `backlash`.
        kind: &'static str,
        /// Positions, mm or degrees.
        places: Vec<f64>,
        /// The other axis of a grid and its positions.
        with: Option<(Axis, Vec<f64>)>,
        /// Values, µm or µrad: one row, or one for each position.
        values: Vec<Vec<f64>>,
        /// Expanded uncertainty of each value, in the same layout.
        u95: Vec<Vec<f64>>,
    },
    /// A drift with a sensor.
    Drift {
        /// `X`, `Y`, `Z`.
        direction: &'static str,
        /// The sensor.
        sensor: String,
        /// Its time constant.
        lag_s: f64,
        /// Its coefficient.
        um_per_k: f64,
    },
    /// Thermal expansion of a scale.
    Growth {
        /// The axis.
        axis: Axis,
        /// The sensor.
        sensor: String,
        /// Its time constant.
        lag_s: f64,
        /// Its coefficient.
        um_per_m_k: f64,
        /// Coefficient times the fixed position, µm/K; the file stores the position.
        um_per_k: f64,
    },
    /// Effect of a weight: `reference_N` and, with `lean`, its position along a direction.
    Load {
        /// The component.
        name: ErrorName,
        /// The reference.
        reference_n: f64,
        /// `along` and `at_mm`.
        lean: Option<(&'static str, f64)>,
        /// The value of a location error, or the coefficients of a polynomial, mm or rad per power.
        values: Vec<f64>,
    },
    /// An entry of a custom source in a list `[[…]]`. The amounts are added to the entry with the same texts in `words` and the same numbers in
    /// `keys`; if there is no such entry, a new one is written.
    Entry {
        /// Its list of sections: `beam` for `[[beam]]`.
        list: &'static str,
        /// Keys with texts that identify the entry: `axis = "X"`.
        words: Vec<(&'static str, String)>,
        /// Keys and the increases of their numbers, in the unit of the key: `mid_um` by −12.5.
        amounts: Vec<(&'static str, f64)>,
        /// Other keys of a new entry. Numbers identify an entry too: `at_mm` 300 is another entry than 500.
        keys: Vec<(&'static str, Given)>,
    },
    /// Keys of a section `[…]` of a custom source, which is added if the file lacks it. The amounts are added to its numbers.
    Section {
        /// The section: `overhang` for `[overhang]`.
        section: &'static str,
        /// Keys and the increases of their numbers, in the unit of the key.
        amounts: Vec<(&'static str, f64)>,
    },
}

/// Position of a change in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// A key of a section.
    Key(&'static str, String),
    /// An entry of a list.
    Entry(&'static str, usize),
}

pub(super) fn same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME * one.abs().max(other.abs())
}

pub(super) fn text(key: &str, text: impl Into<String>) -> (String, Given) {
    (key.to_owned(), Given::Text(text.into()))
}

pub(super) fn number(key: &str, number: f64) -> (String, Given) {
    (key.to_owned(), Given::Number(number))
}

/// Entries of a list of sections with these texts.
pub(super) fn entries<'a>(
    edit: &'a Edit,
    list: &'a str,
    words: &'a [(&'a str, String)],
) -> impl Iterator<Item = usize> + 'a {
    (0..edit.count(list))
        .filter(move |&index| words.iter().all(|(key, word)| edit.word(list, index, key) == Some(word.as_str())))
}

impl Change {
    /// True if the change sets a parameter, or writes the entry that contains it.
    #[must_use]
    pub fn is_of(&self, parameter: &Parameter) -> bool {
        match (self, parameter) {
            (Change::Parameter { name, .. }, Parameter::Geometry(own)) => name == own,
            (Change::Drift { direction, sensor, .. }, Parameter::Effect(own)) => {
                let name = own.name();
                name.starts_with(&format!("drift.{direction}")) && name.contains(sensor.as_str())
            }
            (Change::Growth { axis, .. }, Parameter::Effect(own)) => own.name() == format!("expansion.{axis}.scale"),
            (Change::Load { name, .. }, Parameter::Effect(own)) => {
                let rest = own.name().strip_prefix(&format!("load.{name}"));
                rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '~']))
            }
            (Change::Entry { list: section, .. } | Change::Section { section, .. }, Parameter::Effect(own)) => {
                own.name().starts_with(&format!("{section}."))
            }
            _ => false,
        }
    }

    /// Applies the change to a text and returns its position there, or the reason why it is impossible. Parameters are written by
    /// [`ncfix_model::write`].
    ///
    /// # Errors
    /// A sentence without a full stop.
    pub fn make(&self, edit: &mut Edit) -> Result<Anchor, String> {
        let is_done = match self {
            Change::Parameter { name, .. } => return Err(format!("{} is not an entry", name.component)),
            Change::Wave { name, period, parts, sigma, travel } => {
                wave(edit, *name, (*period, *travel), *parts, *sigma)
            }
            Change::Shape { .. } => self.shape(edit),
            Change::Drift { direction, sensor, lag_s, um_per_k } => {
                warm::drift(edit, direction, (sensor, *lag_s), *um_per_k)
            }
            Change::Growth { axis, sensor, lag_s, um_per_m_k, um_per_k } => {
                return warm::growth(edit, *axis, (sensor, *lag_s), [*um_per_m_k, *um_per_k]);
            }
            Change::Load { name, reference_n, lean, values } => load(edit, *name, (*reference_n, *lean), values),
            Change::Entry { list, words, amounts, keys } => entry(edit, list, words, amounts, keys),
            Change::Section { section, amounts } => of_section(edit, section, amounts),
        };
        is_done.ok_or_else(|| "the list of the machine file has a form that cannot be extended".into())
    }

    fn shape(&self, edit: &mut Edit) -> Option<Anchor> {
        let Change::Shape { name, kind, places, with, values, .. } = self else { return None };
        let (_, unit) = unit_of(*name);
        let key = |axis: Option<Axis>| if axis.is_some_and(Axis::is_rotary) { "positions_deg" } else { "positions_mm" };
        let (own, values_key) = (key(name.axis()), format!("values_{unit}"));
        let across = with.as_ref().map(|(axis, _)| format!("with_{}", key(Some(*axis))));
        let are = |edit: &Edit, index: usize, key: &str, places: &[f64]| {
            edit.length("motion", index, key) == places.len()
                && places.iter().enumerate().all(|(k, &place)| {
                    edit.number("motion", index, &format!("{key}[{k}]")).is_some_and(|own| same(own, place))
                })
        };
        let words = [("component", name.to_string()), ("kind", (*kind).to_owned())];
        let found = entries(edit, "motion", &words).find(|&index| {
            are(edit, index, own, places)
                && with.as_ref().zip(across.as_ref()).is_none_or(|((axis, others), key)| {
                    edit.word("motion", index, "with") == Some(axis.to_string().as_str())
                        && are(edit, index, key, others)
                })
        });
        if let Some(index) = found {
            for (row, values) in values.iter().enumerate() {
                for (k, value) in values.iter().enumerate() {
                    let path =
                        if with.is_some() { format!("{values_key}[{row}][{k}]") } else { format!("{values_key}[{k}]") };
                    let sum = edit.number("motion", index, &path)? + value;
                    edit.set_at("motion", index, &path, &Given::Number(sum)).then_some(())?;
                }
            }
            return Some(Anchor::Entry("motion", index));
        }
        let mut keys = vec![text("component", name.to_string()), text("kind", *kind)];
        keys.push((own.to_owned(), Given::Numbers(places.clone())));
        match with.as_ref().zip(across) {
            Some(((axis, others), key)) => {
                keys.push(text("with", axis.to_string()));
                keys.push((key, Given::Numbers(others.clone())));
                keys.push((values_key, Given::Rows(values.clone())));
            }
            None => keys.push((values_key, Given::Numbers(values.first()?.clone()))),
        }
        pushed(edit, "motion", &keys)
    }
}

pub(super) fn pushed(edit: &mut Edit, list: &'static str, keys: &[(String, Given)]) -> Option<Anchor> {
    edit.push(list, keys).then(|| Anchor::Entry(list, edit.count(list).saturating_sub(1)))
}

fn wave(
    edit: &mut Edit,
    name: ErrorName,
    (period, [low, high]): (f64, [f64; 2]),
    [sine, cosine]: [f64; 2],
    sigma: f64,
) -> Option<Anchor> {
    let (factor, unit) = unit_of(name);
    let (amplitude, phase) = (format!("amplitude_{unit}"), "phase_deg");
    let key = if name.axis().is_some_and(Axis::is_rotary) { "period_deg" } else { "period_mm" };
    let words = [("component", name.to_string()), ("kind", "periodic".to_owned())];
    // Waves that stay in phase over the travel are one wave.
    let apart = |own: f64| 1.0 / period - 1.0 / own;
    let found = entries(edit, "motion", &words).find_map(|index| {
        let own = edit.number("motion", index, key).filter(|&own| apart(own).abs() * (high - low).abs() < TOGETHER)?;
        Some((index, own))
    });
    let (mut sine, mut cosine) = (factor * sine, factor * cosine);
    if let Some((index, own)) = found {
        let old = edit.number("motion", index, &amplitude)?;
        let angle = edit.number("motion", index, phase).unwrap_or(0.0).to_radians();
        // Converted to the period of the existing wave, in phase in the middle of the travel.
        let (turned, straight) = (std::f64::consts::TAU * apart(own) * f64::midpoint(low, high)).sin_cos();
        (sine, cosine) = (sine * straight - cosine * turned, sine * turned + cosine * straight);
        sine += old * angle.cos();
        cosine += old * angle.sin();
    }
    let written = found.map_or(period, |(_, own)| own);
    let found = found.map(|(index, _)| index);
    let keys =
        [number(&amplitude, rounded(sine.hypot(cosine))), number(phase, rounded(cosine.atan2(sine).to_degrees()))];
    let anchor = match found {
        Some(index) => keys
            .iter()
            .all(|(key, given)| edit.set_in("motion", index, key, given))
            .then_some(Anchor::Entry("motion", index)),
        None => {
            let head = [text("component", name.to_string()), text("kind", "periodic"), number(key, period)];
            pushed(edit, "motion", &head.into_iter().chain(keys).collect::<Vec<_>>())
        }
    };
    // An unknown uncertainty is not 0.
    let sigma = rounded(factor * sigma);
    let is_known = sigma.is_finite() && sigma > 0.0;
    let is_done = !is_known || edit.set(uncertainty::SECTION, &wave_name(name, written), &Given::Number(sigma));
    anchor.filter(|_| is_done)
}

fn entry(
    edit: &mut Edit,
    list: &'static str,
    words: &[(&'static str, String)],
    amounts: &[(&'static str, f64)],
    keys: &[(&'static str, Given)],
) -> Option<Anchor> {
    // An entry at another position is another entry.
    let is_there = |index: usize| {
        keys.iter().all(|(key, given)| match given {
            Given::Number(wanted) => edit.number(list, index, key).is_some_and(|own| same(own, *wanted)),
            _ => true,
        })
    };
    let found = entries(edit, list, words).find(|&index| is_there(index));
    if let Some(index) = found {
        for (key, amount) in amounts {
            let sum = edit.number(list, index, key).unwrap_or(0.0) + amount;
            edit.set_at(list, index, key, &Given::Number(rounded(sum))).then_some(())?;
        }
        return Some(Anchor::Entry(list, index));
    }
    let mut all: Vec<(String, Given)> = words.iter().map(|(key, word)| text(key, word)).collect();
    all.extend(keys.iter().map(|(key, given)| ((*key).to_owned(), given.clone())));
    all.extend(amounts.iter().map(|(key, amount)| number(key, rounded(*amount))));
    pushed(edit, list, &all)
}

fn of_section(edit: &mut Edit, section: &'static str, amounts: &[(&'static str, f64)]) -> Option<Anchor> {
    for (key, amount) in amounts {
        let sum = edit.number(section, 0, key).unwrap_or(0.0) + amount;
        edit.set(section, key, &Given::Number(rounded(sum))).then_some(())?;
    }
    amounts.first().map(|(key, _)| Anchor::Key(section, (*key).to_owned()))
}

/// Rounds to 1 pm, or to 1e-6 of a degree.
pub(super) fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn load(
    edit: &mut Edit,
    name: ErrorName,
    (reference_n, lean): (f64, Option<(&str, f64)>),
    values: &[f64],
) -> Option<Anchor> {
    const LIST: &str = "load";
    let is_constant = name.kind == ErrorKind::Location;
    let (factor, unit) = unit_of(name);
    let value_key = format!("value_{unit}");
    let words = [("component", name.to_string())];
    let found = entries(edit, LIST, &words).find(|&index| {
        let at = |key: &str| edit.number(LIST, index, key);
        let is_form = if is_constant {
            edit.has(LIST, index, &value_key)
        } else {
            edit.word(LIST, index, "kind") == Some("polynomial")
                && edit.length(LIST, index, "coefficients") >= values.len()
        };
        let leans = match lean {
            None => !edit.has(LIST, index, "along"),
            Some((along, place)) => {
                edit.word(LIST, index, "along") == Some(along) && at("at_mm").is_some_and(|own| same(own, place))
            }
        };
        is_form && leans && at("reference_N").is_some_and(|own| same(own, reference_n))
    });
    if let Some(index) = found {
        for (k, value) in values.iter().enumerate() {
            let (path, value) =
                if is_constant { (value_key.clone(), factor * value) } else { (format!("coefficients[{k}]"), *value) };
            let sum = edit.number(LIST, index, &path)? + value;
            edit.set_at(LIST, index, &path, &Given::Number(sum)).then_some(())?;
        }
        return Some(Anchor::Entry(LIST, index));
    }
    let mut keys = vec![text("component", name.to_string()), number("reference_N", reference_n)];
    keys.extend(lean.into_iter().flat_map(|(along, place)| [text("along", along), number("at_mm", place)]));
    if is_constant {
        keys.push(number(&value_key, factor * values.first()?));
    } else {
        keys.push(text("kind", "polynomial"));
        keys.push(("coefficients".to_owned(), Given::Numbers(values.to_vec())));
    }
    pushed(edit, LIST, &keys)
}
