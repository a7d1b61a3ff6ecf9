//! Errors in the machine file of a size that no machine has: mostly a number in another unit.
//!
//! ISO 10791 allows 5 to 60 µm or µrad for most errors. A factor of 1000, the usual mistake, makes them 5 mm and more, or less than what an instrument
//! resolves. A small number that a fit has found is no mistake: it has an entry in `[uncertainty]`.

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, AxisVector};
use ncfix_base::number::significant;
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::file::Section;
use ncfix_machine::machine::{Machine, State};

use super::motion::EntryFunction;
use super::name::ErrorName;
use super::{LocationError, MotionError};

/// Largest plausible displacement, mm: 500 times the positioning error that ISO 10791-4 allows.
const MOST_MM: f64 = 5.0;
/// Largest plausible angle, rad: 10 mm per meter.
const MOST_RAD: f64 = 0.01;
/// Smallest angle that a person measures, rad: electronic levels and autocollimators resolve 0.1 to 1 µrad.
const LEAST_RAD: f64 = 1e-7;
/// Smallest displacement that a person measures, mm: the resolution of most instruments is 0.1 µm.
const LEAST_MM: f64 = 5e-5;
/// Length over which an angle acts if no linear axis has a travel, mm; range of an axis without limits.
const LENGTH_MM: f64 = 1000.0;
/// Number of intervals of a travel at whose ends an error is evaluated.
const INTERVALS: usize = 64;

/// An error at the position at which it is largest.
struct Largest {
    value: f64,
    at: f64,
}

/// Reports the errors of one level of the file, the machine or a head, whose size is not plausible. `read` are the errors that were read from it.
pub(super) fn check(
    section: &mut Section<'_>,
    machine: &Machine,
    (location, motion): (&[LocationError], &[MotionError]),
    is_fitted: impl Fn(ErrorName) -> bool,
) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    if let Some(own) = section.section("location") {
        for error in location {
            let place = own.place_of(&error.name.to_string());
            found.extend(of_location(machine, error, place, is_fitted(error.name)));
        }
    }
    let entries = section.sections("motion");
    // Without an entry that could not be read, both have the same order.
    if entries.len() == motion.len() {
        for (own, error) in entries.iter().zip(motion) {
            found.extend(of_motion(machine, error, own.place_of("component")));
        }
    }
    found
}

/// Names with an uncertainty of any of their parameters: a calibration found them.
pub(super) fn fitted<'m>(machine: &'m Machine) -> impl Fn(ErrorName) -> bool + 'm {
    move |name| {
        let name = name.to_string();
        machine.uncertainty.iter().any(|known| known.rows.keys().any(|own| own.starts_with(&name)))
    }
}

fn of_location(machine: &Machine, error: &LocationError, place: Place, is_fitted: bool) -> Option<Diagnostic> {
    let size = error.value.abs();
    if error.name.direction.is_rotation() {
        let length = longest(machine);
        let urad = urad_from_rad(error.value);
        let does = format!(
            "{} = {} µrad is {} µm over {} mm",
            error.name,
            plain(urad),
            plain(um_from_mm(size * length)),
            plain(length)
        );
        if size > MOST_RAD {
            let message = format!("{does}: no machine has an angle of this size");
            let help = "angles of [location] are in µrad: 20 µm per meter is 20";
            return Some(Diagnostic::at(Code::IMPLAUSIBLE_SIZE, place, message, help));
        }
        return (size > 0.0 && size < LEAST_RAD && !is_fitted).then(|| {
            let message = format!("{does}: less than any instrument resolves");
            let number = plain(urad);
            let help = format!(
                "angles of [location] are in µrad: if {number} is in mm/m, write {}; if it is in rad, write {}; if it really is so small, remove it",
                plain(urad * 1e3),
                plain(urad * 1e6)
            );
            Diagnostic::at(Code::IMPLAUSIBLE_SIZE, place, message, help)
        });
    }
    let um = um_from_mm(error.value);
    let name = error.name;
    if size > MOST_MM {
        let message = format!("{name} = {} µm is {} mm: no machine has an error of this size", plain(um), plain(size));
        let help = "displacements of [location] are in µm and add to the place that the file states for the axis: correct that place for larger ones";
        return Some(Diagnostic::at(Code::IMPLAUSIBLE_SIZE, place, message, help));
    }
    (size > 0.0 && size < LEAST_MM && !is_fitted).then(|| {
        let message = format!("{name} = {} µm: less than any instrument resolves", plain(um));
        let help = format!(
            "displacements of [location] are in µm: if {} is in mm, write {}; if it really is so small, remove it",
            plain(um),
            plain(um * 1e3)
        );
        Diagnostic::at(Code::IMPLAUSIBLE_SIZE, place, message, help)
    })
}

fn of_motion(machine: &Machine, error: &MotionError, place: Place) -> Option<Diagnostic> {
    let axis = error.name.axis()?;
    let is_angle = error.name.direction.is_rotation();
    let Largest { value, at } = largest(machine, axis, &error.function)?;
    if value.abs() <= if is_angle { MOST_RAD } else { MOST_MM } {
        return None;
    }
    let (shown, unit) = if is_angle { (urad_from_rad(value), "µrad") } else { (um_from_mm(value), "µm") };
    let (at, of_at) = if axis.is_rotary() { (at.to_degrees(), "°") } else { (at, " mm") };
    let message = format!(
        "{} is {} {unit} at {axis} = {}{of_at}: no machine has an error of this size",
        error.name,
        plain(shown),
        plain(at)
    );
    let help = help(&error.function, is_angle, axis.is_rotary());
    Some(Diagnostic::at(Code::IMPLAUSIBLE_SIZE, place, message, help))
}

/// The unit that the file expects, and what the largest coefficient was probably meant to be.
fn help(function: &EntryFunction, is_angle: bool, is_rotary: bool) -> String {
    let (unit, of_axis) = (if is_angle { "rad" } else { "mm" }, if is_rotary { "rad" } else { "mm" });
    let coefficients = match function {
        EntryFunction::Polynomial(own) => own.coefficients.as_slice(),
        EntryFunction::Piecewise(own) => own.coefficients.as_slice(),
        EntryFunction::Cross(own) => own.coefficients.as_slice(),
        _ => {
            let micro = if is_angle { "µrad" } else { "µm" };
            return format!("the values of this entry are in {micro}; check their unit");
        }
    };
    let slope = coefficients.get(1).copied().unwrap_or(0.0);
    let meant = match (is_angle, is_rotary) {
        _ if slope == 0.0 => String::new(),
        (false, false) => format!(": if {slope} is in µm/m, write {}", scientific(slope * 1e-6)),
        (true, false) => format!(": if {slope} is in µrad/m, write {}", scientific(slope * 1e-9)),
        (_, true) => {
            format!(
                ": if {slope} is in {} per rad, write {}",
                if is_angle { "µrad" } else { "µm" },
                scientific(slope * if is_angle { 1e-6 } else { 1e-3 })
            )
        }
    };
    format!("coefficients are in {unit} per power of {of_axis}{meant}")
}

/// The largest size of a function of an axis within its travel, with other axes at the ends and in the middle of theirs, and both directions.
fn largest(machine: &Machine, axis: Axis, function: &EntryFunction) -> Option<Largest> {
    if matches!(function, EntryFunction::Dynamic(_)) {
        return None;
    }
    let mut found: Option<Largest> = None;
    for share in [0.0, 0.5, 1.0] {
        let mut command = AxisVector::ZERO;
        for other in AXES.into_iter().filter(|&other| machine.axis(other).is_some()) {
            let [low, high] = travel(machine, other);
            command[other] = low + share * (high - low);
        }
        let [low, high] = travel(machine, axis);
        for direction in [-1, 1] {
            let state = State { direction: [direction; AXIS_COUNT], ..State::default() };
            for step in 0..=INTERVALS {
                let at = low + (high - low) * step as f64 / INTERVALS as f64;
                command[axis] = at;
                let value = function.value(axis, &command, &state);
                if found.as_ref().is_none_or(|known| value.abs() > known.value.abs()) {
                    found = Some(Largest { value, at });
                }
            }
        }
    }
    found
}

fn travel(machine: &Machine, axis: Axis) -> [f64; 2] {
    let unlimited = if axis.is_rotary() { [0.0, std::f64::consts::TAU] } else { [0.0, LENGTH_MM] };
    machine.axis(axis).and_then(|data| data.travel).unwrap_or(unlimited)
}

/// The longest travel of a linear axis, mm.
fn longest(machine: &Machine) -> f64 {
    let linear = AXES.into_iter().filter(|axis| !axis.is_rotary()).filter_map(|axis| machine.axis(axis)?.travel);
    let most = linear.map(|[low, high]| high - low).fold(0.0, f64::max);
    if most > 0.0 { most } else { LENGTH_MM }
}

/// A number with three significant digits, and all of them if it is very small.
fn plain(value: f64) -> String {
    if value != 0.0 && value.abs() < 0.0995 {
        let digits = (1.0 - value.abs().log10()).ceil().clamp(0.0, 12.0) as usize + 1;
        let text = format!("{value:.digits$}");
        return text.trim_end_matches('0').to_owned();
    }
    let text = significant(value);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A number with four significant digits and its power of ten: `5e-5`.
fn scientific(value: f64) -> String {
    let text = format!("{value:.3e}");
    match text.split_once('e') {
        Some((digits, power)) => format!("{}e{power}", digits.trim_end_matches('0').trim_end_matches('.')),
        None => text,
    }
}
