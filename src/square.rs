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
use ncfix_metrology::diagnose::cause::own as own_error;
use ncfix_metrology::measure::squareness::{MeasuredSquareness, explained_urad};
use ncfix_model::ParameterName;
use ncfix_model::write::write;

/// Smallest angle that other errors explain and that is stated, µrad.
const LEAST_URAD: f64 = 0.05;
/// Coverage factor of the stated interval, 95 %.
const COVERAGE: f64 = 2.0;

/// Readings of a squareness, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SquareReadings {
    /// The diagonals d1 and d2 of a part that the machine cut.
    Diagonals([f64; 2]),
    /// Leg of a square, and the change of a dial gauge along it in the positive direction: + is pressed in, with the plunger in the positive direction of the
    /// other axis.
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

/// Sides of the part.
pub(crate) struct PartSides {
    /// Measured sides, mm.
    measured_mm: [f64; 2],
    /// Programmed sides, mm: as stated, else the measured ones to a whole millimeter.
    pub(crate) nominal_mm: [f64; 2],
    /// True if the programmed sides are stated, so that the measured ones show the scales of the axes.
    shows_scales: bool,
}

impl PartSides {
    /// The sides of a square or a rectangle, and the programmed ones, mm; one length stands for both sides of a square.
    ///
    /// # Errors
    /// If `sides` or `nominal` are more than two, or the part was cut more than 2 % away from its programmed sides.
    pub(crate) fn of(side: Option<f64>, sides: &[f64], nominal: &[f64]) -> Result<PartSides, Error> {
        /// A larger difference is no scale of a machine: a number is wrong, or the two are exchanged.
        const MOST_SHARE: f64 = 0.02;
        let measured_mm = match (side, sides) {
            (Some(side), _) => [side; 2],
            (None, [a, b]) => [*a, *b],
            (None, [a]) => [*a; 2],
            (None, []) => [SHOWN_MM; 2],
            _ => return Err(Error::usage("--sides needs one or two lengths in mm, such as 600,400".into())),
        };
        let nominal_mm = match nominal {
            [] => measured_mm.map(|side| side.round().max(1.0)),
            [a, b] => [*a, *b],
            [a] => [*a; 2],
            _ => return Err(Error::usage("--nominal needs one or two lengths in mm, such as 600,400".into())),
        };
        let is_near = |(side, nominal): (f64, f64)| (side - nominal).abs() <= MOST_SHARE * nominal;
        let shows_scales = !nominal.is_empty();
        if shows_scales && !measured_mm.into_iter().zip(nominal_mm).all(is_near) {
            let [[a, b], [c, d]] = [measured_mm, nominal_mm];
            return Err(Error::usage(format!(
                "sides of {a} and {b} mm were not programmed as {c} and {d} mm: they differ by more than 2 %"
            )));
        }
        Ok(PartSides { measured_mm, nominal_mm, shows_scales })
    }
}

/// Scale of an axis.
struct FoundScale {
    parameter: ParameterName,
    value: f64,
    /// Standard uncertainty.
    uncertainty: f64,
}

/// Largest correction that is allowed without an option, mm.
const USUAL_MM: f64 = 0.2;

impl FoundSquareness {
    /// The option for corrections as large as the found errors over the travel of the machine; `None` if the default allows them.
    ///
    /// Corrections of more than 5 mm are never proposed: they move the tool far from the programmed path, and a wrong number is more likely.
    pub(crate) fn max_correction(&self, chosen: &Machine) -> Option<String> {
        const MOST_MM: f64 = 5.0;
        let travels = chosen.machine.axes.iter().flatten().filter(|data| !data.axis.is_rotary());
        let longest_mm = travels.filter_map(|data| data.travel).map(|[low, high]| high - low).fold(0.0, f64::max);
        let share = self.value_urad.abs() * 1e-6 + self.scales.iter().map(|one| one.value.abs()).sum::<f64>();
        let largest_mm = share * longest_mm;
        // A whole number that is easy to read, with room for the position in the travel.
        let proposed_mm = (1.5 * largest_mm).ceil();
        (largest_mm > USUAL_MM && proposed_mm <= MOST_MM).then(|| format!("{proposed_mm}mm"))
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
    /// Scales of the axes, if the part was measured and its programmed sides are known.
    scales: Vec<FoundScale>,
}

/// Calculates the squareness of the axes of a plane, and their scales if the programmed sides are stated. `part` is the part, or the one that the page
/// describes; readings are within ± `read_to_mm`.
///
/// # Errors
/// If the readings do not fit, or the machine lacks an axis of the plane.
pub(crate) fn find(
    chosen: &Machine,
    plane: Plane,
    readings: SquareReadings,
    part: &PartSides,
    read_to_mm: f64,
) -> Result<FoundSquareness, Error> {
    let sides_mm = part.measured_mm;
    chosen.check_one_head()?;
    let machine = &chosen.machine;
    let direction = |axis| machine.axis(axis).map(|data| data.direction);
    let [first, second, _] = pair(plane);
    let term = squareness(&machine.topology, plane, direction)
        .ok_or_else(|| Error::usage(format!("{} has no axes {first} and {second}", machine.name)))?;
    let measured = match readings {
        SquareReadings::Diagonals(diagonals) => {
            MeasuredSquareness::of_diagonals(diagonals, (sides_mm, part.shows_scales), read_to_mm)
        }
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
    if let SquareReadings::Dial(leg, dial) = readings {
        let change = if dial < 0.0 { "let out" } else { "pressed in" };
        row(
            "square",
            format!(
                "on the way of {leg} mm in the positive direction, the plunger is {change} by {:.3} mm; on which side of the path the corner of the square is \
                 makes no difference",
                dial.abs()
            ),
        );
    }
    let side = if gamma_urad < 0.0 { "−" } else { "+" };
    row(
        "angle",
        format!(
            "{first}+ to {second}+ is 90° {side} {:.1} µrad ± {half_urad:.1} µrad (95 %), {:.3} mm/m",
            gamma_urad.abs(),
            gamma_urad / 1e3
        ),
    );
    // The term is that of the axis of its name; the model turns this one, and the other keeps its direction.
    let (turned, stays) =
        if term.name.ends_with(char::from(first.letter())) { (first, second) } else { (second, first) };
    row(
        "term",
        format!("{} = {value_urad:.1} µrad on {}: the model tilts {turned}, not {stays}", term.name, machine.topology),
    );
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
            "the angle is not significant: it is not larger than its uncertainty. State how finely you read with --read-to (default ± 0.5 mm for diagonals), use a finer caliper, or measure a larger part".to_owned(),
        );
    }
    let mut found =
        FoundSquareness { page, term, value_urad, uncertainty_urad: half_urad / COVERAGE, scales: Vec::new() };
    if part.shows_scales {
        found.scale(chosen, plane, part, read_to_mm)?;
    }
    Ok(found)
}

impl FoundSquareness {
    /// Calculates the scales of the axes of a plane from the measured and the programmed sides of the part, each read within ± `read_to_mm`.
    ///
    /// # Errors
    /// If an axis is not parallel to its direction of F: its scale is then no single number.
    fn scale(&mut self, chosen: &Machine, plane: Plane, part: &PartSides, read_to_mm: f64) -> Result<(), Error> {
        let [first, second, _] = pair(plane);
        let sides = part.measured_mm.into_iter().zip(part.nominal_mm);
        for (axis, (side, nominal)) in [first, second].into_iter().zip(sides) {
            let along = chosen.machine.axis(axis).map_or(0.0, |data| data.direction[axis.dimension()]);
            if along.abs() < 0.999 {
                return Err(Error::usage(format!("{axis} is not parallel to its axis of F: leave out --nominal")));
            }
            let relative = (side - nominal) / nominal;
            // An axis that carries the workpiece moves against its letter, and so does its error.
            let parameter = ParameterName::coefficient(own_error(axis), 1);
            let (value, uncertainty) = (relative * along.signum(), read_to_mm / 3_f64.sqrt() / nominal);
            let micrometers = |share: f64| share * 1e6;
            let _ = writeln!(
                self.page,
                "{:<12}{parameter} = {value:.3e}: {axis} moves {:+.0} ± {:.0} µm/m (95 %) of its command",
                "scale",
                micrometers(relative),
                micrometers(COVERAGE * uncertainty)
            );
            self.scales.push(FoundScale { parameter, value, uncertainty });
        }
        let _ = writeln!(
            self.page,
            "{:<12}a cutter that is not as wide as the program takes it changes both sides equally: measure the groove or the cut, or cut two sizes",
            "note"
        );
        Ok(())
    }

    /// Writes the squareness into the text of a machine file, and keeps the rest of the text. With `adds`, the value is added to the existing one: the part
    /// was cut with the correction.
    ///
    /// # Errors
    /// If the text cannot be changed, or states the same angle under the other name too.
    pub(crate) fn written(&mut self, chosen: &Machine, text: &str, adds: bool) -> Result<String, Error> {
        let (errors, mut changed) = (&chosen.errors, chosen.errors.clone());
        for FoundScale { parameter, value, .. } in &self.scales {
            let old = parameter.get(errors);
            parameter.set(&mut changed, value + if adds { old } else { 0.0 });
            if old != 0.0 {
                let verb = if adds { "added to" } else { "replaces" };
                let _ = writeln!(self.page, "{:<12}{verb} {parameter} = {old:e} of the machine file", "written");
            }
        }
        let text = &write(text, errors, &changed).map_err(|reason| Error::usage(reason.0))?;
        let SquarenessTerm { name, other, .. } = &self.term;
        let mut edit = Edit::parse(text).ok_or_else(|| Error::usage("the machine file is not TOML".into()))?;
        if edit.number("location", 0, other).is_some_and(|value| value != 0.0) {
            return Err(Error::usage(format!(
                "the machine file states {other}, which is the same squareness by another name: remove it, then run this command again"
            )));
        }
        let old = edit.number("location", 0, name);
        let explained = if adds { 0.0 } else { explained_urad(&chosen.machine, errors, &self.term) };
        if explained.abs() >= LEAST_URAD {
            let _ = writeln!(
                self.page,
                "{:<12}other errors of the machine file, such as the mean slope of a straightness, explain {explained:.1} µrad of it: {name} = {:.1} µrad is written",
                "written",
                self.value_urad - explained
            );
        }
        let value = self.value_urad - explained + if adds { old.unwrap_or_default() } else { 0.0 };
        // A tenth of a microradian is below any of these readings.
        let tenths = |value: f64| Given::Number((value * 10.0).round() / 10.0);
        for (section, value) in [("location", value), (uncertainty::SECTION, self.uncertainty_urad)] {
            if !edit.set(section, name, &tenths(value)) {
                let message = format!("the section [{section}] of the machine file cannot be changed");
                return Err(Error::usage(message));
            }
        }
        for FoundScale { parameter, uncertainty: sigma, .. } in &self.scales {
            if !edit.set(uncertainty::SECTION, &parameter.to_string(), &Given::Number(*sigma)) {
                let message = format!("the section [{}] of the machine file cannot be changed", uncertainty::SECTION);
                return Err(Error::usage(message));
            }
        }
        if let Some(old) = old {
            let verb = if adds { "added to" } else { "replaces" };
            let _ = writeln!(self.page, "{:<12}{verb} {name} = {old} of the machine file", "written");
        }
        let scales = self.scales.iter().map(|one| one.parameter.to_string());
        Ok(scales.chain([name.clone()]).fold(edit.text(), |text, name| describe::measured(&text, &name)))
    }
}
