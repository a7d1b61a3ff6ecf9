//! Entries of causes with their own form in the machine file: waves, temperatures, weights.

use ncfix_base::units::um_from_mm;
use ncfix_model::name::ErrorKind;

use super::super::cause::{Candidate, thermal};
use super::super::scene::{Scene, Through};
use super::super::verdict::AcceptedCause;
use super::change::{Change, rounded};
use super::component;

/// Parts per million: µm/(m K).
const MILLION: f64 = 1e6;
/// Largest deviation of the direction of an axis from a coordinate.
const ALONG: f64 = 1e-6;
/// Units of the weight, N, and of the arm, mm, in columns of loads.
const LOAD: [f64; 2] = [1000.0, 100.0];

pub(super) fn periodic(one: &AcceptedCause, scene: &Scene<'_>) -> Result<Vec<Change>, String> {
    let ([sine, cosine], Some((period, _)), Some(name)) =
        (one.amounts.values.as_slice(), one.candidate.constant, component(&one.candidate))
    else {
        return Err("it is not a wave of one component of the error".into());
    };
    let axis = name.axis().ok_or("it is not an error of an axis")?;
    let travel = super::super::cause::range(scene, axis).ok_or("it has no travel")?;
    let travel = travel.map(|place| if axis.is_rotary() { place.to_degrees() } else { place });
    // Sine and cosine have about the same uncertainty; the larger one stands for both.
    let sigma = [[1.0, 0.0], [0.0, 1.0]].map(|part| one.amounts.form(&part).1).into_iter().fold(0.0, f64::max);
    Ok(vec![Change::Wave { name, period, parts: [*sine, *cosine], sigma, travel }])
}

/// Name of a sensor, from its column.
fn sensor_of(candidate: &Candidate) -> Option<String> {
    let column = candidate.sensor.as_deref()?;
    Some(column.strip_suffix("_C").unwrap_or(column).to_owned())
}

fn lag_of(candidate: &Candidate) -> f64 {
    match candidate.constant {
        Some((lag, "s")) => lag,
        _ => 0.0,
    }
}

pub(super) fn expansion(one: &AcceptedCause, scene: &Scene<'_>) -> Result<Vec<Change>, String> {
    let candidate = &one.candidate;
    let axis = component(candidate).filter(|name| name.kind == ErrorKind::Motion).and_then(|name| name.axis());
    let data = axis.and_then(|axis| scene.machine.axis(axis));
    let (Some(sensor), Some(axis), Some(data)) = (sensor_of(candidate), axis, data) else {
        return Err("it is not a thermal expansion of one axis with one sensor".into());
    };
    let share = data.direction[axis.dimension()];
    if axis.is_rotary() || (share.abs() - 1.0).abs() > ALONG {
        return Err(format!("{axis} is not along a coordinate of the machine"));
    }
    let (slope, offset) = match one.amounts.values.as_slice() {
        [slope] => (*slope, 0.0),
        [slope, offset] => (*slope, *offset),
        _ => return Err("it is not a straight line".into()),
    };
    // e = slope · x + offset = strain · (x − fixed).
    Ok(vec![Change::Growth {
        axis,
        sensor,
        lag_s: lag_of(candidate),
        um_per_m_k: rounded(MILLION * slope / share),
        um_per_k: -um_from_mm(offset) / share,
    }])
}

pub(super) fn drift(one: &AcceptedCause) -> Result<Vec<Change>, String> {
    let candidate = &one.candidate;
    if candidate.cause.name == thermal::ON.name {
        return Err("a drift counts from the first row of each set-up in each run, but this one continues from run to run: give runs without a zero setting between them the same label"
            .into());
    }
    let (Some(sensor), [amount]) = (sensor_of(candidate), one.amounts.values.as_slice()) else {
        return Err("[[drift]] is proportional to the temperatures of sensors, but this is not".into());
    };
    let mut all = candidate.columns.iter().flatten();
    let (Some((Through::Tip(direction), _)), None) = (all.next(), all.next()) else {
        return Err("it is not a displacement along one direction".into());
    };
    if candidate.drivers.len() != 1 {
        return Err(format!(
            "it depends on {}, but [[drift]] depends only on temperatures",
            candidate.drivers.join(" and ")
        ));
    }
    let direction = ["X", "Y", "Z"].get(*direction).copied().unwrap_or("Z");
    let um_per_k = rounded(um_from_mm(*amount));
    Ok(vec![Change::Drift { direction, sensor, lag_s: lag_of(candidate), um_per_k }])
}

/// Columns: weight/1000 N times a power of the scaled position, and these times position/100 mm.
pub(super) fn load(one: &AcceptedCause, scene: &Scene<'_>) -> Result<Vec<Change>, String> {
    const NO: &str = "it is not a load effect on one component of the error";
    let candidate = &one.candidate;
    let name = component(candidate).ok_or(NO)?;
    let along = candidate.drivers.iter().find_map(|driver| match driver.as_str() {
        "load_x_mm" => Some("X"),
        "load_y_mm" => Some("Y"),
        "load_z_mm" => Some("Z"),
        _ => None,
    });
    let lean = along.map(|along| (along, LOAD[1]));
    let change = |lean, values| Change::Load { name, reference_n: LOAD[0], lean, values };
    let amounts = one.amounts.values.as_slice();
    let Some(axis) = name.axis().filter(|_| name.kind == ErrorKind::Motion) else {
        return match amounts {
            [amount] => Ok(vec![change(lean, vec![*amount])]),
            _ => Err(NO.into()),
        };
    };
    let [low, high] = super::super::cause::range(scene, axis).ok_or(NO)?;
    // Powers of the scaled position (2x − low − high)/(high − low), written as powers of x.
    let (factor, middle) = (2.0 / (high - low), f64::midpoint(low, high));
    let powers = |[flat, slope, bend]: [f64; 3]| {
        vec![
            flat - slope * factor * middle + bend * (factor * middle).powi(2),
            slope * factor - 2.0 * bend * factor * factor * middle,
            bend * factor * factor,
        ]
    };
    let of = |lean, parts: [f64; 3]| change(lean, powers(parts));
    match (amounts, lean) {
        ([slope, bend], None) => Ok(vec![of(None, [0.0, *slope, *bend])]),
        ([slope, bend, flat], None) => Ok(vec![of(None, [*flat, *slope, *bend])]),
        ([slope, bend, off_slope, off_bend], Some(_)) => {
            Ok(vec![of(None, [0.0, *slope, *bend]), of(lean, [0.0, *off_slope, *off_bend])])
        }
        ([slope, bend, off_slope, off_bend, flat, off_flat], Some(_)) => {
            Ok(vec![of(None, [*flat, *slope, *bend]), of(lean, [*off_flat, *off_slope, *off_bend])])
        }
        _ => Err(NO.into()),
    }
}
