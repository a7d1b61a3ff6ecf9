//! The description of a trace: NAME.toml.

use std::collections::BTreeMap;

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Vector;
use ncfix_base::source::Source;
use ncfix_base::units::mm_from_um;
use ncfix_machine::machine::file::{MachineFile, Section};

use super::{Trace, UNKNOWNS};
use crate::measure::nest::{self, SensorNest};

/// A description.
#[derive(Clone, Debug, Default)]
pub struct Described {
    /// Its trace, without runs yet.
    pub trace: Trace,
    /// The file with the signals of a control next to the table, if they are not in it.
    pub control: Option<String>,
    /// Columns (`X`, `X_enc`) by the signals of such a file.
    pub signals: BTreeMap<String, String>,
    /// Programmed feed of a trace of one run, mm/min.
    pub feed_mm_min: Option<f64>,
    /// The response of the sensors, if their columns are not yet displacements along F.
    pub sensors: Option<SensorNest>,
}

/// Reads the description of a trace; `None` for another kind, which is not an error.
#[must_use]
pub fn describe(name: &str, source: &Source) -> Option<(Option<Described>, Vec<Diagnostic>)> {
    let file = MachineFile::parse(source).ok()?;
    let mut root = file.root();
    let mut section = root.section("measurement")?;
    if section.text("kind") != Some("trace") {
        return None;
    }
    let mut findings = Vec::new();
    let mut described = read_measurement(&mut section);
    described.trace.name = name.to_owned();
    section.finish(&mut findings);
    if let Some(section) = root.section("ball") {
        described.trace.ball_mm = read_ball(section, &mut findings);
    }
    if let Some(section) = root.section("sensors") {
        described.sensors = nest::read(section, &mut findings);
    }
    if let Some(mut section) = root.section("signals") {
        let keys: Vec<&str> = section.keys().collect();
        for key in keys {
            let signal = section.text(key).map(str::to_owned);
            described.signals.extend(signal.map(|signal| (key.to_owned(), signal)));
        }
        section.finish(&mut findings);
    }
    root.finish(&mut findings);
    let sound = !findings.iter().any(Diagnostic::is_error);
    Some((sound.then_some(described), findings))
}

fn read_measurement(section: &mut Section<'_>) -> Described {
    let mut trace = Trace {
        sigma_mm: section.number_where("sigma_um", "a number above 0", |um| um > 0.0).map(mm_from_um),
        ..Trace::default()
    };
    for (index, word) in section.texts("free").unwrap_or_default().iter().enumerate() {
        match UNKNOWNS.iter().find(|(known, _)| known == word) {
            Some(&(_, unknown)) => trace.free.push(unknown),
            None => {
                let known: Vec<&str> = UNKNOWNS.iter().map(|&(word, _)| word).collect();
                let place = section.place_of_item("free", index);
                let message = format!("\"{word}\" is not a possible unknown of a trace");
                section.report(Code::BAD_VALUE, place, message, format!("write any of {}", known.join(", ")));
            }
        }
    }
    let control = section.text("control").map(str::to_owned);
    let feed_mm_min = section.number_where("feed_mm_min", "a feed above 0", |feed| feed > 0.0);
    Described { trace, control, signals: BTreeMap::new(), feed_mm_min, sensors: None }
}

/// `[ball.NAME] place_mm`: as for other kinds; a trace has one ball.
fn read_ball(mut section: Section<'_>, findings: &mut Vec<Diagnostic>) -> Option<Vector> {
    let labels: Vec<&str> = section.keys().collect();
    let mut ball = None;
    for (number, label) in labels.into_iter().enumerate() {
        let place = section.place_of_key(label);
        let Some(mut one) = section.section(label) else { continue };
        let at = one.required("place_mm", "[100, 0, 50]", Section::vector);
        one.finish(findings);
        if number > 0 {
            let help = "a trace follows one ball; remove the others";
            section.report(Code::BAD_VALUE, place, "a second ball", help);
        }
        ball = ball.or(at);
    }
    section.finish(findings);
    ball
}
