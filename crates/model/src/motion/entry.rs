//! Reader of one `[[motion]]` entry: the units in its keys follow from the component and its axis.

use crate::name::ErrorName;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Axis, AxisSet};
use ncfix_base::units::{mm_from_um, rad_from_urad};
use ncfix_machine::machine::file::Section;

/// Units that a key may have by mistake.
const UNITS: [&str; 9] = ["um", "mm", "urad", "mrad", "rad", "deg", "arcsec", "nm", "in"];

fn is_rotary(axis: Option<Axis>) -> bool {
    axis.is_some_and(|axis| axis.is_rotary())
}

/// Returns the key of a position of an axis.
pub(super) fn position_key_of(stem: &str, axis: Option<Axis>) -> String {
    format!("{stem}_{}", if is_rotary(axis) { "deg" } else { "mm" })
}

/// Largest deviation, µm or µrad; a greater value is in another unit.
const MOST_DEVIATION: f64 = 1e6;

/// Largest coefficient, mm and rad per power of mm and rad; a greater value is in another unit.
const MOST_COEFFICIENT: f64 = 1e3;

/// Entry whose component is known.
#[derive(Debug)]
#[non_exhaustive]
pub struct Entry<'a> {
    /// Section.
    pub section: Section<'a>,
    /// Component.
    pub name: ErrorName,
    /// Axes of the machine.
    pub axes: AxisSet,
}

impl Entry<'_> {
    fn is_rotary(&self) -> bool {
        is_rotary(self.name.axis())
    }

    /// Returns the key of a deviation: `values` as `values_um` or `values_urad`.
    pub fn deviation_key(&self, stem: &str) -> String {
        format!("{stem}_{}", if self.name.direction.is_rotation() { "urad" } else { "um" })
    }

    /// Returns the key of a position: `positions` as `positions_mm` or `positions_deg`.
    pub fn position_key(&self, stem: &str) -> String {
        position_key_of(stem, self.name.axis())
    }

    /// Returns the factor from the unit of deviations to mm or rad.
    fn deviation_factor(&self) -> f64 {
        if self.name.direction.is_rotation() { rad_from_urad(1.0) } else { mm_from_um(1.0) }
    }

    /// Converts a position of the file to mm or rad.
    fn position_from_file(&self, value: f64) -> f64 {
        if self.is_rotary() { value.to_radians() } else { value }
    }

    /// Reads a deviation, mm or rad.
    pub fn deviation(&mut self, stem: &str) -> Option<f64> {
        let key = self.deviation_key(stem);
        self.check_deviation_unit(stem, &key)?;
        let value = self.section.required(&key, "6.0", |section, key| {
            section.number_where(key, "a deviation of less than a meter", |value| value.abs() <= MOST_DEVIATION)
        })?;
        Some(value * self.deviation_factor())
    }

    /// Reads deviations, mm or rad.
    pub fn deviations(&mut self, stem: &str) -> Option<Vec<f64>> {
        let key = self.deviation_key(stem);
        self.check_deviation_unit(stem, &key)?;
        let values = self.section.required(&key, "[0, 4, -1]", Section::numbers)?;
        if let Some(index) = values.iter().position(|value| value.abs() > MOST_DEVIATION) {
            let place = self.section.place_of_item(&key, index);
            let help = format!("check the unit: {key}");
            self.section.report(Code::BAD_VALUE, place, "a deviation of more than a meter", help);
            return None;
        }
        Some(values.into_iter().map(|value| value * self.deviation_factor()).collect())
    }

    /// Reads a position, mm or rad.
    pub fn position(&mut self, stem: &str) -> Option<f64> {
        let key = self.position_key(stem);
        self.check_position_unit(stem, &key, self.name.axis())?;
        let value = self.section.required(&key, "100", Section::number)?;
        Some(self.position_from_file(value))
    }

    /// Reads a positive length along the axis, mm or rad.
    pub fn length(&mut self, stem: &str) -> Option<f64> {
        let key = self.position_key(stem);
        self.check_position_unit(stem, &key, self.name.axis())?;
        let value = self.section.required(&key, "10.0", |section, key| {
            section.number_where(key, "a number above 0", |length| length > 0.0)
        })?;
        Some(self.position_from_file(value))
    }

    /// Reads positions, mm or rad.
    pub fn positions(&mut self, stem: &str) -> Option<Vec<f64>> {
        self.positions_of(stem, self.name.axis())
    }

    /// Reads positions of an axis, mm or rad.
    pub fn positions_of(&mut self, stem: &str, axis: Option<Axis>) -> Option<Vec<f64>> {
        let key = position_key_of(stem, axis);
        self.check_position_unit(stem, &key, axis)?;
        let mut values = self.section.required(&key, "[0, 350, 700]", Section::numbers)?;
        if is_rotary(axis) {
            values.iter_mut().for_each(|value| *value = value.to_radians());
        }
        Some(values)
    }

    /// Reads rows of deviations, mm or rad.
    pub fn deviation_rows(&mut self, stem: &str) -> Option<Vec<Vec<f64>>> {
        let key = self.deviation_key(stem);
        self.check_deviation_unit(stem, &key)?;
        let mut rows = self.section.required(&key, "[[0, 4], [1, 5]]", Section::rows)?;
        rows.iter_mut().flatten().for_each(|value| *value *= self.deviation_factor());
        Some(rows)
    }

    /// Reads an axis of the machine other than that of the component.
    pub fn other_axis(&mut self, key: &str) -> Option<Axis> {
        let letter = self.section.required(key, "\"X\"", Section::text)?;
        let axis = match letter.as_bytes() {
            [byte @ b'A'..=b'Z'] => Axis::from_letter(*byte),
            _ => None,
        };
        let own = self.name.axis();
        let found = axis.filter(|&axis| self.axes.contains(axis) && Some(axis) != own);
        if found.is_none() {
            let place = self.section.place_of(key);
            let message = format!("{key} must be another axis of the machine, found \"{letter}\"");
            let others: Vec<String> =
                self.axes.iter().filter(|&axis| Some(axis) != own).map(|axis| axis.to_string()).collect();
            self.section.report(Code::BAD_VALUE, place, message, format!("write one of {}", others.join(" ")));
        }
        found
    }

    /// Reports the key of a deviation with a wrong unit for its component.
    fn check_deviation_unit(&mut self, stem: &str, key: &str) -> Option<()> {
        let kind = if self.name.direction.is_rotation() { "rotation" } else { "displacement" };
        let reason = format!("{} is a {kind}", self.name);
        self.check_unit(stem, key, &reason)
    }

    /// Reports the key of a position with a wrong unit for its axis.
    fn check_position_unit(&mut self, stem: &str, key: &str, axis: Option<Axis>) -> Option<()> {
        let kind = if is_rotary(axis) { "rotary" } else { "linear" };
        let reason = match axis {
            Some(axis) if self.name.axis() != Some(axis) => format!("the axis {axis} is {kind}"),
            _ => format!("the axis of {} is {kind}", self.name),
        };
        self.check_unit(stem, key, &reason)
    }

    /// Reports the key with a wrong unit.
    fn check_unit(&mut self, stem: &str, key: &str, reason: &str) -> Option<()> {
        let Some(wrong) =
            UNITS.iter().map(|unit| format!("{stem}_{unit}")).find(|wrong| wrong != key && self.section.has(wrong))
        else {
            return Some(());
        };
        let place = self.section.place_of_key(&wrong);
        self.section.accept(&wrong);
        self.section.accept(key);
        self.section.report(
            Code::WRONG_UNIT,
            place,
            format!("{wrong}: {reason}"),
            format!("write {key}, with values in that unit"),
        );
        None
    }

    /// Reads coefficients, mm and rad without conversion.
    pub fn coefficients(&mut self, key: &str) -> Option<Vec<f64>> {
        let values = self.section.required(key, "[0, 1e-5]", Section::numbers)?;
        if let Some(index) = values.iter().position(|value| value.abs() > MOST_COEFFICIENT) {
            let place = self.section.place_of_item(key, index);
            let help = format!("{key} are in mm and rad per power of mm and rad; check the unit");
            self.section.report(Code::BAD_VALUE, place, "a coefficient that makes errors of meters", help);
            return None;
        }
        Some(values)
    }

    /// True if there is a key of this stem, whatever its unit.
    pub fn has_stem(&self, stem: &str) -> bool {
        UNITS.iter().any(|unit| self.section.has(&format!("{stem}_{unit}")))
    }

    /// Reports `E0408` if positions do not increase strictly.
    pub fn demand_increase(&mut self, key: &str, positions: &[f64]) -> Option<()> {
        let fault = positions.windows(2).position(|pair| pair[0] >= pair[1]);
        if let Some(index) = fault {
            let place = self.section.place_of_item(key, index + 1);
            let message = format!("position {} of {key} is not above the one before it", index + 2);
            self.section.report(Code::BAD_TABLE, place, message, "sort the positions and remove duplicates");
            return None;
        }
        Some(())
    }

    /// Finishes a subsection of this entry.
    pub fn take_findings(&mut self, subsection: Section<'_>) {
        let mut findings = Vec::new();
        subsection.finish(&mut findings);
        self.section.add(findings);
    }
}
