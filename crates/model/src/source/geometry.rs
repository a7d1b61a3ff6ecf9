//! Geometry: location errors and the motion errors that depend on the position of their own axis.
//!
//! Sections `[location]` and `[[motion]]`; the sum of both is the volumetric error model of ISO 230-1 (Spaan 1995, ch. 2; Esmaeili 2021, ch. 2).

use super::{Effect, MachineFileReading, Parameter, SourceInfo, coupling, reversal};
use crate::accumulator::Accumulator;
use crate::file;
use crate::motion::EntryFunction;
use crate::{ErrorModel, LocationError, MotionError};
use ncfix_machine::machine::Condition;

/// Name, title and sections of the source.
pub(super) static SOURCE: SourceInfo = SourceInfo {
    name: "geometry",
    title: "location and motion errors",
    sections: &["location", "motion"],
    example: "\
[location]
EC0Y = 15.0
[[motion]]
component = \"EXX\"
kind = \"polynomial\"
coefficients = [0.0, 1.2e-5, -3e-8]
[[motion]]
component = \"EAX\"
kind = \"table\"
positions_mm = [0, 350, 700]
values_urad = [0, 12, -8]
",
};

pub(super) fn read(reading: &mut MachineFileReading<'_, '_>, errors: &mut ErrorModel) {
    if let Some(section) = reading.root.section("location") {
        errors.location.extend(file::read_location(section, reading.axes, reading.findings));
    }
    for section in reading.root.sections("motion") {
        errors.motion.extend(file::read_motion(section, reading.axes, reading.kinds, reading.findings));
    }
}

impl Effect for LocationError {
    fn source(&self) -> &'static SourceInfo {
        &SOURCE
    }

    fn label(&self) -> String {
        self.name.to_string()
    }

    fn contribute(&self, _: &Condition, sum: &mut Accumulator<'_>) {
        sum.add_location(self.name, self.value);
    }

    fn visit_parameters(&mut self, visit: &mut dyn FnMut(&Parameter<'_>, &mut f64)) {
        visit(&Parameter { name: &self.name.to_string(), is_linear: true, written: None }, &mut self.value);
    }
}

impl Effect for MotionError {
    fn source(&self) -> &'static SourceInfo {
        match self.function {
            EntryFunction::Backlash(_) => &reversal::SOURCE,
            EntryFunction::Cross(_) | EntryFunction::Grid(_) => &coupling::SOURCE,
            _ => &SOURCE,
        }
    }

    fn label(&self) -> String {
        self.name.to_string()
    }

    fn contribute(&self, _: &Condition, sum: &mut Accumulator<'_>) {
        sum.add_motion(self.name, &self.function, 1.0);
    }

    fn visit_parameters(&mut self, visit: &mut dyn FnMut(&Parameter<'_>, &mut f64)) {
        let component = self.name.to_string();
        self.function.visit_values(&mut |name, value| {
            visit(&Parameter { name: &format!("{component}.{name}"), is_linear: true, written: None }, value);
        });
    }
}
