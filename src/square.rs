//! Squareness of two axes of a machine: from readings to the location error of its chain, its machine file and a test square.

use std::fmt::Write as _;

use crate::error::Error;
use crate::machine::Machine;
use ncfix_base::geometry::Plane;
use ncfix_base::units::urad_from_rad;
use ncfix_machine::describe;
use ncfix_machine::machine::edit::{Edit, Given};
use ncfix_machine::machine::squareness::{SquarenessTerm, pair, squareness};
use ncfix_machine::machine::uncertainty;
use ncfix_metrology::measure::squareness::MeasuredSquareness;

/// Coverage factor of the stated interval, 95 %.
const COVERAGE: f64 = 2.0;

/// Readings of a squareness, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SquareReadings {
    /// The diagonals d1 and d2 of a part that the machine cut.
    Diagonals([f64; 2]),
    /// Leg of a square, and the change of a dial gauge along it: + is pressed in, with the plunger in the positive direction of the other axis.
    Dial(f64, f64),
}

impl SquareReadings {
    /// The readings of a command, with their usual uncertainty, ± mm: two diagonals, or the leg of a square with the change of a dial gauge.
    ///
    /// # Errors
    /// If neither is there.
    pub(crate) fn of(
        diagonals: Option<(f64, f64)>,
        dial: Option<(f64, f64)>,
        is_negative: bool,
    ) -> Result<(SquareReadings, f64), Error> {
        match (diagonals, dial) {
            (Some((d1, d2)), _) => Ok((SquareReadings::Diagonals([d1, d2]), 0.5)),
            (None, Some((leg, dial))) => Ok((SquareReadings::Dial(leg, if is_negative { -dial } else { dial }), 0.005)),
            (None, None) => Err(Error::usage("give --d1 and --d2, or --square and --dial".into())),
        }
    }
}

/// Sides of the part that the page describes if a square was measured, mm.
const SHOWN_MM: f64 = 300.0;

/// The sides of the part, mm.
///
/// # Errors
/// If `sides` are not two.
pub(crate) fn sides_mm(side: Option<f64>, sides: &[f64]) -> Result<[f64; 2], Error> {
    match (side, sides) {
        (Some(side), _) => Ok([side; 2]),
        (None, [a, b]) => Ok([*a, *b]),
        (None, []) => Ok([SHOWN_MM; 2]),
        _ => Err(Error::usage("--sides needs two lengths in mm, such as 600,400".into())),
    }
}

/// Squareness of a machine.
pub(crate) struct FoundSquareness {
    /// Page for people.
    pub(crate) page: String,
    term: SquarenessTerm,
    value_urad: f64,
    /// Standard uncertainty, µrad.
    uncertainty_urad: f64,
}

/// Calculates the squareness of the axes of a plane. `sides_mm` are those of the part, or of the part that the page describes; readings are within
/// ± `read_to_mm`.
///
/// # Errors
/// If the readings do not fit, or the machine lacks an axis of the plane.
pub(crate) fn find(
    chosen: &Machine,
    plane: Plane,
    readings: SquareReadings,
    sides_mm: [f64; 2],
    read_to_mm: f64,
) -> Result<FoundSquareness, Error> {
    chosen.check_one_head()?;
    let machine = &chosen.machine;
    let direction = |axis| machine.axis(axis).map(|data| data.direction);
    let [first, second, _] = pair(plane);
    let term = squareness(&machine.topology, plane, direction)
        .ok_or_else(|| Error::usage(format!("{} has no axes {first} and {second}", machine.name)))?;
    let measured = match readings {
        SquareReadings::Diagonals(diagonals) => MeasuredSquareness::of_diagonals(diagonals, sides_mm, read_to_mm),
        SquareReadings::Dial(leg, dial) => MeasuredSquareness::of_dial(leg, dial, read_to_mm),
    }
    .map_err(Error::usage)?;
    let gamma_urad = urad_from_rad(measured.gamma_rad);
    let half_urad = COVERAGE * urad_from_rad(measured.uncertainty_rad);
    let value_urad = term.factor * gamma_urad;
    let mut page = String::new();
    let mut row = |name: &str, text: String| {
        // Writing into a String cannot fail.
        let _ = writeln!(page, "{name:<12}{text}");
    };
    let side = if gamma_urad < 0.0 { "−" } else { "+" };
    row(
        "angle",
        format!(
            "{first}+ to {second}+ is 90° {side} {:.1} µrad ± {half_urad:.1} µrad (95 %), {:.3} mm/m",
            gamma_urad.abs(),
            gamma_urad / 1e3
        ),
    );
    row("term", format!("{} = {value_urad:.1} µrad on {}", term.name, machine.topology));
    let [d1, d2] = measured.diagonals_mm(sides_mm);
    let [a, b] = sides_mm;
    let lean_mm = a.max(b) * measured.gamma_rad.abs();
    row(
        "before",
        format!("a part of {a} x {b} mm is out of square by {lean_mm:.3} mm; diagonals {d1:.3} and {d2:.3} mm"),
    );
    let rest_mm = COVERAGE * measured.uncertainty_rad * 2.0 * a * b / a.hypot(b);
    row("after", format!("squareness only: diagonals of {:.3} mm, equal within {rest_mm:.3} mm", a.hypot(b)));
    if half_urad >= gamma_urad.abs() {
        row(
            "note",
            "the angle is not significant: it is not larger than its uncertainty. Measure a larger part, or use a finer scale".to_owned(),
        );
    }
    Ok(FoundSquareness { page, term, value_urad, uncertainty_urad: half_urad / COVERAGE })
}

impl FoundSquareness {
    /// Writes the squareness into the text of a machine file, and keeps the rest of the text. With `adds`, the value is added to the existing one: the part
    /// was cut with the correction.
    ///
    /// # Errors
    /// If the text cannot be changed, or states the same angle under the other name too.
    pub(crate) fn written(&mut self, text: &str, adds: bool) -> Result<String, Error> {
        let SquarenessTerm { name, other, .. } = &self.term;
        let mut edit = Edit::parse(text).ok_or_else(|| Error::usage("the machine file is not TOML".into()))?;
        if edit.number("location", 0, other).is_some_and(|value| value != 0.0) {
            return Err(Error::usage(format!(
                "the machine file states {other}, which is the same squareness by another name: remove it, then run this command again"
            )));
        }
        let old = edit.number("location", 0, name);
        let value = self.value_urad + if adds { old.unwrap_or_default() } else { 0.0 };
        // A tenth of a microradian is below any of these readings.
        let tenths = |value: f64| Given::Number((value * 10.0).round() / 10.0);
        for (section, value) in [("location", value), (uncertainty::SECTION, self.uncertainty_urad)] {
            if !edit.set(section, name, &tenths(value)) {
                let message = format!("the section [{section}] of the machine file cannot be changed");
                return Err(Error::usage(message));
            }
        }
        if let Some(old) = old {
            let verb = if adds { "added to" } else { "replaces" };
            let _ = writeln!(self.page, "{:<12}{verb} {name} = {old} of the machine file", "written");
        }
        Ok(describe::measured(&edit.text(), name))
    }
}
