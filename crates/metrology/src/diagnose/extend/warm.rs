//! Changes of temperature-dependent terms: drifts and thermal expansion.

use ncfix_base::geometry::Axis;
use ncfix_machine::machine::edit::{Edit, Given};

use super::change::{Anchor, entries, number, pushed, rounded, same, text};

const LIST: &str = "drift";

fn term(sensor: &str, lag_s: f64, um_per_k: f64) -> Vec<(String, Given)> {
    let mut own = vec![text("name", sensor), number("um_per_K", um_per_k)];
    own.extend((lag_s > 0.0).then(|| number("lag_s", lag_s)));
    own
}

/// Adds a coefficient to a sensor with this lag, or adds the sensor.
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

/// Adds a sensor to every entry of the direction, so that it contributes the same at each position of an axis.
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

/// Adds thermal expansion of a scale. An axis has one scale, so another sensor is refused. Its effect is not a drift either: a drift ends when the zero
/// point is set, but the lengths stay wrong.
pub(super) fn growth(
    edit: &mut Edit,
    axis: Axis,
    (sensor, lag_s): (&str, f64),
    [slope, offset]: [f64; 2],
) -> Result<Anchor, String> {
    const LIST: &str = "expansion";
    const NO: &str = "the expansion of the machine file has a form that cannot be extended";
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
        return Err(format!(
            "the scale of {axis} already depends on another sensor or lag in the machine file, and [[expansion]] has one scale for each axis; \
             name its sensors, weights and lag by hand, and calibrate"
        ));
    }
    let (Some(old), Some(fixed)) = (at("scale.um_per_m_K"), at("scale.fixed_mm").or(at("fixed_mm"))) else {
        return Err(NO.into());
    };
    let (sum, offset) = (old + slope, old * fixed / 1e3 + offset);
    let is_done = edit.set_at(LIST, index, "scale.um_per_m_K", &Given::Number(sum))
        && edit.set_at(LIST, index, "scale.fixed_mm", &Given::Number(held(sum, offset)));
    if is_done { Ok(Anchor::Entry(LIST, index)) } else { Err(NO.into()) }
}
