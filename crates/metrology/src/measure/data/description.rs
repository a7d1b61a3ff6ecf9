//! The description of a measurement: NAME.toml.

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, Axis, Vector};
use ncfix_base::source::{Source, Span};
use ncfix_base::units::{mm_from_um, rad_from_urad};
use ncfix_machine::machine::file::{MachineFile, Section};

use super::super::kind::{self, Instruments, Measurand};
use super::super::nest;
use super::{DataSet, Free, KnownLength, Setup, bodies, number_of};

/// Reads the description; the result is a measurement without rows, if its kind is known.
pub(super) fn read(name: &str, source: &Source, instruments: &Instruments) -> (Option<DataSet>, Vec<Diagnostic>) {
    let file = match MachineFile::parse(source) {
        Ok(file) => file,
        Err(findings) => return (None, findings),
    };
    let mut findings = Vec::new();
    let mut root = file.root();
    let (mut data, mut free_place) = (None, None);
    if let Some(mut section) = root.required("measurement", "a section [measurement] with kind", Section::section) {
        data = read_measurement(name, &mut section, instruments);
        free_place = Some(section.place_of("free"));
        section.finish(&mut findings);
    }
    let measurand = data.as_ref().map_or(Measurand::Other, |data: &DataSet| data.kind.measurand);
    let (mut artefact, mut of_artefact) = (Setup::default(), 0.0);
    if let Some(mut section) = (measurand == Measurand::Displacement).then(|| root.section("artefact")).flatten() {
        (artefact, of_artefact) = bodies::read_artefact(&mut section);
        section.finish(&mut findings);
    }
    let sensors = (measurand == Measurand::Displacement).then(|| root.section("sensors")).flatten();
    let sensors = sensors.and_then(|section| nest::read(section, &mut findings));
    let (mut setups, mut rods) = (Vec::new(), Vec::new());
    if let Some(mut section) = root.section("setup") {
        let labels: Vec<&str> = section.keys().collect();
        for label in labels {
            if let Some(mut one) = section.section(label) {
                let centre_mm = one.vector("centre_mm").unwrap_or_default();
                let length_mm = one.number_where("length_mm", "a length above 0", |mm| mm > 0.0).unwrap_or(0.0);
                let mut setup = Setup { label: label.to_owned(), centre_mm, length_mm, ..artefact.clone() };
                bodies::read_setup(&mut one, measurand, &mut setup, &mut rods);
                setups.push(setup);
                one.finish(&mut findings);
            }
        }
        section.finish(&mut findings);
    }
    // Only places of balls can be given, or distances between them; elsewhere these sections are unknown keys.
    let has_balls = !matches!(measurand, Measurand::Component | Measurand::BallDistance | Measurand::LineLength);
    let mut lengths = Vec::new();
    for mut section in has_balls.then(|| root.sections("length")).into_iter().flatten() {
        let from = section.required("from", "\"b1\"", Section::text);
        let to = section.required("to", "\"b2\"", Section::text);
        let value_mm = section.required("value_mm", "500.012", |section, key| {
            section.number_where(key, "a length above 0", |mm| mm > 0.0)
        });
        if from.is_some() && from == to {
            let place = section.place_of("to");
            section.report(Code::BAD_VALUE, place, "a distance of a ball from itself", "name another ball");
        }
        if let (Some(from), Some(to), Some(value_mm)) = (from, to, value_mm) {
            let sigma_mm = section.number_where("sigma_um", "a number above 0", |um| um > 0.0).map(mm_from_um);
            lengths.push((from.to_owned(), to.to_owned(), value_mm, sigma_mm));
        }
        section.finish(&mut findings);
    }
    let fixed = root.section("position").map_or_else(Vec::new, |section| read_fixed(section, &mut findings));
    let has_ranges = measurand == Measurand::Component;
    let ranges = has_ranges
        .then(|| root.section("range"))
        .flatten()
        .map_or_else(Vec::new, |section| read_ranges(section, &mut findings));
    let balls = has_balls
        .then(|| root.section("ball"))
        .flatten()
        .map_or_else(Vec::new, |section| read_balls(section, &mut findings));
    root.finish(&mut findings);
    let data = data.map(|mut data: DataSet| {
        (data.setups, data.rods, data.artefact) = (setups, rods, artefact);
        data.scale_sigma = data.scale_sigma.max(of_artefact);
        data.balls = balls;
        data.fixed = fixed;
        data.ranges = ranges;
        data.sensors = sensors;
        for (from, to, value_mm, sigma_mm) in lengths {
            let between = [from, to].map(|label| number_of(&mut data.targets, &label));
            data.lengths.push(KnownLength { between, value_mm, sigma_mm });
        }
        data
    });
    if let Some((message, help)) = data.as_ref().and_then(bodies::contradiction) {
        let place = Place { file: source.id(), span: Span::default() };
        findings.push(Diagnostic::at(Code::BAD_VALUE, free_place.unwrap_or(place), message, help));
    }
    (data, findings)
}

/// `X_mm = 350`, `B_deg = 0`: constant positions of axes without a column.
fn read_fixed(mut section: Section<'_>, findings: &mut Vec<Diagnostic>) -> Vec<(Axis, f64)> {
    let mut fixed = Vec::new();
    for axis in AXES {
        let key = format!("{axis}_{}", if axis.is_rotary() { "deg" } else { "mm" });
        let value = section.number(&key);
        fixed.extend(value.map(|value| (axis, if axis.is_rotary() { value.to_radians() } else { value })));
    }
    section.finish(findings);
    fixed
}

/// `X_mm = [100, 500]`: ranges of linear axes over which a squareness was measured.
fn read_ranges(mut section: Section<'_>, findings: &mut Vec<Diagnostic>) -> Vec<(Axis, [f64; 2])> {
    let mut ranges = Vec::new();
    for axis in AXES.into_iter().filter(|axis| !axis.is_rotary()) {
        let key = format!("{axis}_mm");
        match section.numbers(&key).as_deref() {
            None => {}
            Some(&[low, high]) if low < high => ranges.push((axis, [low, high])),
            Some(_) => {
                let place = section.place_of(&key);
                let message = format!("{key} must be the lowest and the highest position");
                section.report(Code::BAD_VALUE, place, message, format!("write {key} = [100, 500], for example"));
            }
        }
    }
    section.finish(findings);
    ranges
}

fn read_balls(mut section: Section<'_>, findings: &mut Vec<Diagnostic>) -> Vec<(String, Vector)> {
    let mut balls = Vec::new();
    let labels: Vec<&str> = section.keys().collect();
    for label in labels {
        if let Some(mut one) = section.section(label) {
            let place = one.required("place_mm", "[100, 0, 50]", Section::vector);
            balls.extend(place.map(|place| (label.to_owned(), place)));
            one.finish(findings);
        }
    }
    section.finish(findings);
    balls
}

/// The index of a word that must be one of these.
fn choice(section: &mut Section<'_>, key: &str, words: [&str; 2]) -> Option<usize> {
    let text = section.text(key)?;
    let found = words.iter().position(|word| *word == text);
    if found.is_none() {
        let place = section.place_of(key);
        let help = format!("write one of {}", words.join(", "));
        section.report(Code::BAD_VALUE, place, format!("unknown {key} \"{text}\""), help);
    }
    found
}

fn read_measurement(name: &str, section: &mut Section<'_>, instruments: &Instruments) -> Option<DataSet> {
    let kind = section.required("kind", "\"ballbar\"", Section::text).and_then(|text| {
        let kind = instruments.find(text).copied();
        if kind.is_none() {
            let names: Vec<&str> = instruments.names().collect();
            let place = section.place_of("kind");
            section.report(
                Code::BAD_VALUE,
                place,
                format!("unknown kind \"{text}\""),
                format!("write one of {}; a laser interferometer is direct", names.join(", ")),
            );
        }
        kind
    });
    let sigma = section.number_where("sigma_um", "a number above 0", |um| um > 0.0).map(mm_from_um);
    let sigma_rad = section.number_where("sigma_urad", "a number above 0", |urad| urad > 0.0).map(rad_from_urad);
    let scale_sigma = section.number_where("sigma_um_per_m", bodies::SCALE_SIGMA, bodies::is_scale_sigma);
    let free = section.texts("free");
    let date = section.date("date").map(str::to_owned);
    let head = section.text("head").map(str::to_owned);
    let order = choice(section, "order", ["motion", "unknown"]);
    let is_unit_stated = choice(section, "unit", ["stated", "assumed"]) == Some(0);
    let kind = kind?;
    if scale_sigma.is_some() && !matches!(kind.measurand, Measurand::Component | Measurand::LineLength) {
        let place = section.place_of("sigma_um_per_m");
        let help = match kind.measurand {
            Measurand::BallDistance => "write length_sigma_um in [setup.NAME]",
            Measurand::Displacement => "write sigma_um_per_m in [artefact]",
            _ => "write sigma_um in [[length]]",
        };
        section.report(Code::BAD_VALUE, place, format!("a {} measurement has no scale of its own", kind.name), help);
    }
    let scale_sigma = scale_sigma.unwrap_or(0.0) * bodies::PER_MILLION;
    // Only an alignment that may be an unknown has a reference.
    let alignment = [Free::Slope, Free::Rotation].into_iter().find(|free| kind.free.contains(free));
    let reference = alignment.and_then(|_| choice(section, "reference", ["square", "straightedge"]));
    let mut unknowns = Vec::new();
    for (index, word) in free.unwrap_or_default().iter().enumerate() {
        match kind.free.iter().find(|&&free| kind::word(free) == word) {
            Some(&free) => unknowns.push(free),
            None => {
                let known: Vec<&str> = kind.free.iter().map(|&free| kind::word(free)).collect();
                let place = section.place_of_item("free", index);
                let message = format!("\"{word}\" is not a possible unknown of a {} measurement", kind.name);
                section.report(Code::BAD_VALUE, place, message, format!("write any of {}", known.join(", ")));
            }
        }
    }
    if reference == Some(1) {
        for free in alignment.into_iter().chain([Free::Offset]) {
            if !unknowns.contains(&free) {
                unknowns.push(free);
            }
        }
    }
    Some(DataSet {
        name: name.to_owned(),
        kind,
        date,
        head,
        sigma,
        sigma_rad,
        scale_sigma,
        free: unknowns,
        artefact: Setup::default(),
        rods: Vec::new(),
        cycles: Vec::new(),
        setups: Vec::new(),
        runs: Vec::new(),
        targets: Vec::new(),
        lengths: Vec::new(),
        balls: Vec::new(),
        is_plan: false,
        fixed: Vec::new(),
        ranges: Vec::new(),
        is_in_order: order != Some(1),
        is_order_stated: order.is_some(),
        is_unit_stated,
        is_square_stated: reference == Some(0),
        sensors: None,
        conditions: Vec::new(),
        has_senses: false,
        observations: Vec::new(),
        drivers: Vec::new(),
    })
}
