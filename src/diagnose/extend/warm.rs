//! Changes of what goes with temperatures.

use crate::geometry::Axis;
use crate::machine::edit::{Edit, Given};

use super::change::{Anchor, entries, number, pushed, rounded, same, text};

const LIST: &str = "drift";
/// Places of an axis are the same up to this, mm.
const CLOSE: f64 = 1.0;

fn term(sensor: &str, lag_s: f64, um_per_k: f64) -> Vec<(String, Given)> {
    let mut own = vec![text("name", sensor), number("um_per_K", um_per_k)];
    own.extend((lag_s > 0.0).then(|| number("lag_s", lag_s)));
    own
}

/// Adds a coefficient to a sensor with this lag, or the sensor.
fn add(edit: &mut Edit, index: usize, (sensor, lag_s): (&str, f64), um_per_k: f64) -> Option<()> {
    let known = (0..edit.length(LIST, index, "sensors")).find(|k| {
        let lag = edit.number(LIST, index, &format!("sensors[{k}].lag_s")).unwrap_or(0.0);
        edit.word(LIST, index, &format!("sensors[{k}].name")) == Some(sensor) && same(lag, lag_s)
    });
    let Some(k) = known else {
        return edit.append(LIST, index, "sensors", &term(sensor, lag_s, um_per_k)).then_some(());
    };
    let path = format!("sensors[{k}].um_per_K");
    let sum = edit.number(LIST, index, &path)? + um_per_k;
    edit.set_at(LIST, index, &path, &Given::Number(sum)).then_some(())
}

/// A sensor goes into every entry of the direction: at each place of an axis it adds the same.
pub(super) fn drift(edit: &mut Edit, direction: &str, sensor: (&str, f64), um_per_k: f64) -> Option<Anchor> {
    let words = [("direction", direction.to_owned())];
    let found: Vec<usize> = entries(edit, LIST, &words).collect();
    let Some(&first) = found.first() else {
        let own = Given::Entries(vec![term(sensor.0, sensor.1, um_per_k)]);
        return pushed(edit, LIST, &[text("direction", direction), ("sensors".into(), own)]);
    };
    found.into_iter().try_for_each(|index| add(edit, index, sensor, um_per_k))?;
    Some(Anchor::Entry(LIST, first))
}

/// A drift that changes along an axis: entries of a direction are all over the same axis.
pub(super) fn drift_over(
    edit: &mut Edit,
    direction: &str,
    over: Axis,
    sensor: (&str, f64),
    nodes: [[f64; 2]; 2],
) -> Result<Anchor, String> {
    let no = || "the machine file has its drift in a form that cannot be added to".to_owned();
    let words = [("direction", direction.to_owned())];
    let found: Vec<usize> = entries(edit, LIST, &words).collect();
    let head = |place: f64| vec![text("direction", direction), text("over", over.to_string()), number("at_mm", place)];
    let Some(&first) = found.first() else {
        let mut out = None;
        for [place, um_per_k] in nodes {
            let own = Given::Entries(vec![term(sensor.0, sensor.1, um_per_k)]);
            let keys: Vec<_> = head(place).into_iter().chain([("sensors".to_owned(), own)]).collect();
            let anchor = pushed(edit, LIST, &keys).ok_or_else(no)?;
            out.get_or_insert(anchor);
        }
        return out.ok_or_else(no);
    };
    if !edit.has(LIST, first, "over") {
        // What is the same everywhere is so at both places.
        let mut terms = Vec::new();
        for k in 0..edit.length(LIST, first, "sensors") {
            let at = |key: &str| format!("sensors[{k}].{key}");
            let name = edit.word(LIST, first, &at("name")).ok_or_else(no)?;
            let um_per_k = edit.number(LIST, first, &at("um_per_K")).ok_or_else(no)?;
            terms.push(term(name, edit.number(LIST, first, &at("lag_s")).unwrap_or(0.0), um_per_k));
        }
        let [[low, _], [high, _]] = nodes;
        let is_done = edit.set_in(LIST, first, "over", &Given::Text(over.to_string()))
            && edit.set_in(LIST, first, "at_mm", &Given::Number(low));
        let keys: Vec<_> = head(high).into_iter().chain([("sensors".to_owned(), Given::Entries(terms))]).collect();
        if !is_done || pushed(edit, LIST, &keys).is_none() {
            return Err(no());
        }
    }
    let found: Vec<usize> = entries(edit, LIST, &words).collect();
    let places: Vec<f64> = found.iter().filter_map(|&index| edit.number(LIST, index, "at_mm")).collect();
    let [[low, from], [high, to]] = nodes;
    let least = places.iter().copied().fold(f64::INFINITY, f64::min);
    let most = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let is_over = found.iter().all(|&index| edit.word(LIST, index, "over") == Some(over.to_string().as_str()));
    if !is_over || places.len() != found.len() || least > low + CLOSE || most < high - CLOSE {
        return Err(format!(
            "the drift of {direction} is over another axis or other places in the machine file; it would have to be over {over} from {low} to \
             {high} mm"
        ));
    }
    for (index, place) in found.into_iter().zip(places) {
        let um_per_k = rounded(from + (to - from) * (place - low) / (high - low));
        add(edit, index, sensor, um_per_k).ok_or_else(no)?;
    }
    Ok(Anchor::Entry(LIST, first))
}

/// An axis has one scale: what goes with another sensor, or another lag, is a drift over the axis.
pub(super) fn growth(
    edit: &mut Edit,
    axis: Axis,
    (sensor, lag_s): (&str, f64),
    [slope, offset]: [f64; 2],
    nodes: [[f64; 2]; 2],
) -> Result<Anchor, String> {
    const LIST: &str = "expansion";
    const NO: &str = "the machine file has its expansion in a form that cannot be added to";
    // µm/K = µm/(m K) · m.
    let held = |slope: f64, offset: f64| if slope == 0.0 { 0.0 } else { rounded(offset / slope * 1e3) };
    let words = [("axis", axis.to_string())];
    let found = entries(edit, LIST, &words).next();
    let own = |fixed: Option<f64>| {
        let mut keys = vec![("sensors".to_owned(), Given::Texts(vec![sensor.to_owned()])), number("um_per_m_K", slope)];
        keys.extend((lag_s > 0.0).then(|| number("lag_s", lag_s)));
        keys.extend(fixed.map(|fixed| number("fixed_mm", fixed)));
        ("scale".to_owned(), Given::Entry(keys))
    };
    let Some(index) = found else {
        let keys = [text("axis", axis.to_string()), number("fixed_mm", held(slope, offset)), own(None)];
        return pushed(edit, LIST, &keys).ok_or_else(|| NO.into());
    };
    if !edit.has(LIST, index, "scale") {
        let (key, given) = own(Some(held(slope, offset)));
        return if edit.set_at(LIST, index, &key, &given) { Ok(Anchor::Entry(LIST, index)) } else { Err(NO.into()) };
    }
    let at = |key: &str| edit.number(LIST, index, key);
    let lag = at("scale.lag_s").unwrap_or(0.0);
    let is_same = edit.length(LIST, index, "scale.sensors") == 1
        && edit.word(LIST, index, "scale.sensors[0]") == Some(sensor)
        && same(lag, lag_s);
    if !is_same {
        return drift_over(edit, &axis.to_string(), axis, (sensor, lag_s), nodes).map_err(|why| {
            format!(
                "the scale of {axis} goes with another sensor or another lag in the machine file already, and {why}"
            )
        });
    }
    let (Some(old), Some(fixed)) = (at("scale.um_per_m_K"), at("scale.fixed_mm").or(at("fixed_mm"))) else {
        return Err(NO.into());
    };
    let (sum, offset) = (old + slope, old * fixed / 1e3 + offset);
    let is_done = edit.set_at(LIST, index, "scale.um_per_m_K", &Given::Number(sum))
        && edit.set_at(LIST, index, "scale.fixed_mm", &Given::Number(held(sum, offset)));
    if is_done { Ok(Anchor::Entry(LIST, index)) } else { Err(NO.into()) }
}
