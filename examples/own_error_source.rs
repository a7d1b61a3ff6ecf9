//! A custom error source: the table sags when it moves out over its bed along Y.
//!
//! The guides of the table bend under its overhang y, so the workpiece sinks by s (y/L)². The small tilt of the table is left out. The section `[overhang]` of the machine file has the sag s
//! (`sag_um`) at the overhang L (`reach_mm`). ncfix corrects this error together with all others. A calibration fits s under the name `overhang.sag`.
#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use ncfix::extend::source::*;
use ncfix::{Machine, Registry, ToolVector};

const EXAMPLE: &str = "[overhang]\nreach_mm = 500\nsag_um = 9\n";
static OVERHANG: SourceInfo =
    SourceInfo { name: "overhang", title: "sag of the table", sections: &["overhang"], example: EXAMPLE };
struct Overhangs;

impl ErrorSource for Overhangs {
    fn info(&self) -> &'static SourceInfo {
        &OVERHANG
    }
    fn read(&self, reading: &mut MachineFileReading<'_, '_>, errors: &mut ErrorModel) {
        let Some(mut section) = reading.root.section("overhang") else { return };
        let numbers = ["reach_mm", "sag_um"].map(|key| section.required(key, "9", Section::number));
        if let [Some(reach_mm), Some(sag_um)] = numbers {
            errors.effects.push(Box::new(Overhang { reach_mm, sag_mm: sag_um / 1000.0 }));
        }
        section.finish(reading.findings);
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Overhang {
    reach_mm: f64,
    sag_mm: f64,
}

impl Effect for Overhang {
    fn source(&self) -> &'static SourceInfo {
        &OVERHANG
    }
    fn contribute(&self, _: &Condition, sum: &mut Accumulator<'_>) {
        let coefficients = vec![0.0, 0.0, -self.sag_mm / self.reach_mm.powi(2)];
        sum.add_motion("EZY".parse().expect("ISO 230-1"), &EntryFunction::Polynomial(Polynomial { coefficients }), 1.0);
    }
    fn visit_parameters(&mut self, visit: &mut dyn FnMut(&Parameter<'_>, &mut f64)) {
        let written = Some(WrittenAt { entry: 0, key: "sag_um", factor: 1000.0 });
        visit(&Parameter { name: "overhang.sag", is_linear: true, written }, &mut self.sag_mm);
    }
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string("samples/machines/demo.toml")? + EXAMPLE;
    let machine = Machine::from_text_with("demo.toml", &text, &Registry::default().with_source(Overhangs))?;
    for (pose, by_hand_um) in [("Y0", 0.0), ("Y250", 2.25), ("Y500", 9.0_f64)] {
        let at = pose.parse()?;
        let dz = |machine: &Machine| machine.deviation(&at, ToolVector::Length(0.0), &State::default()).position_um[2];
        let rise_um = dz(&machine) - dz(&Machine::demo());
        println!("{pose}: the sag raises the tool by {rise_um:.2} µm relative to the table");
        assert!((rise_um - by_hand_um).abs() < 0.01);
    }
    Ok(())
}
