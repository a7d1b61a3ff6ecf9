//! Rods of ball-bars and artifacts: sharing between set-ups, temperature, and thermal expansion.
//!
//! Lengths are those at 20 °C. A rod is longer by its expansion × (temperature − 20 °C); an artifact expands by the same factor from an origin. The
//! origin has no effect if the position of the artifact is unknown; it defaults to the first measured point.

use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Vector;
use ncfix_base::units::mm_from_um;
use ncfix_machine::machine::file::Section;
use ncfix_machine::machine::{Kinematics, Machine};

use super::super::kind::Measurand;
use super::{DataSet, Free, Observation, Setup, number_of};

/// Reference temperature of lengths, °C.
const REFERENCE_C: f64 = 20.0;
/// Accepted temperatures of rods and artifacts, °C.
const RANGE_C: std::ops::RangeInclusive<f64> = -30.0..=150.0;
/// Help for temperatures.
pub(super) const PLAUSIBLE: &str = "write a temperature of -30 to 150 °C, or leave the cell empty";
/// Upper bound of the expansion of solids, per K.
const MOST_PER_K: f64 = 1e-3;

/// The error of an implausible temperature, if it is one.
pub(super) fn implausible(celsius: Option<f64>) -> Option<String> {
    celsius
        .filter(|celsius| !RANGE_C.contains(celsius))
        .map(|celsius| format!("{celsius} °C is not a plausible room temperature"))
}

/// Reads the rod or artefact data of a set-up; `rods` has all labels.
pub(super) fn read_setup(section: &mut Section<'_>, measurand: Measurand, setup: &mut Setup, rods: &mut Vec<String>) {
    match measurand {
        Measurand::BallDistance => {
            // A set-up without a rod name has its own rod.
            let rod = section.text("rod").filter(|rod| !rod.is_empty());
            setup.rod = match rod {
                Some(rod) => number_of(rods, rod),
                None => {
                    rods.push(String::new());
                    rods.len() - 1
                }
            };
            setup.length_sigma_mm = section
                .number_where("length_sigma_um", "a number from 0 to 1000", |um| (0.0..=MOST_LENGTH_UM).contains(&um))
                .map_or(0.0, mm_from_um);
            setup.expansion_per_k = expansion(section, "rod_expansion_per_K").unwrap_or(0.0);
            setup.temperature_c = temperature(section, "rod_temperature_C");
            if setup.temperature_c.is_some() && setup.expansion_per_k <= 0.0 {
                lacks(section, "rod_temperature_C", "rod_expansion_per_K = 11.5e-6");
            }
        }
        Measurand::Displacement => {
            setup.temperature_c = temperature(section, "artefact_temperature_C").or(setup.temperature_c);
            if setup.temperature_c.is_some() && setup.expansion_per_k <= 0.0 && section.has("artefact_temperature_C") {
                lacks(section, "artefact_temperature_C", "expansion_per_K = 11.5e-6 in [artefact]");
            }
            if let Some(origin_mm) = section.vector("origin_mm") {
                setup.origin_mm = Some(origin_mm);
            }
        }
        Measurand::LineLength => {
            setup.station_mm = section.vector("station_mm");
            if let Some(direction) = section.vector("direction") {
                setup.direction = direction.try_normalize(f64::EPSILON);
                if setup.direction.is_none() {
                    let place = section.place_of("direction");
                    section.report(
                        Code::BAD_VALUE,
                        place,
                        "a line without a direction",
                        "write a vector such as [1, 1, 0]",
                    );
                }
            }
        }
        _ => {}
    }
}

/// Largest standard uncertainty of the scale of an instrument or artifact, µm/m, and of the length of a ball-bar, µm.
const MOST_SCALE: f64 = 1000.0;
const MOST_LENGTH_UM: f64 = 1000.0;
/// Relative change per µm/m.
pub(super) const PER_MILLION: f64 = 1e-6;
/// An allowed standard uncertainty of a scale, in words.
pub(super) const SCALE_SIGMA: &str = "a number from 0 to 1000";

/// True if a standard uncertainty of a scale, µm/m, is allowed.
pub(super) fn is_scale_sigma(um_per_m: f64) -> bool {
    (0.0..=MOST_SCALE).contains(&um_per_m)
}

/// Reads `[artefact]`: its data, and the standard uncertainty of its scale, relative.
pub(super) fn read_artefact(section: &mut Section<'_>) -> (Setup, f64) {
    let expansion_per_k = expansion(section, "expansion_per_K").unwrap_or(0.0);
    let temperature_c = temperature(section, "temperature_C");
    if temperature_c.is_some() && expansion_per_k <= 0.0 {
        lacks(section, "temperature_C", "expansion_per_K = 11.5e-6");
    }
    let scale_sigma = section.number_where("sigma_um_per_m", SCALE_SIGMA, is_scale_sigma).unwrap_or(0.0);
    let origin_mm = section.vector("origin_mm");
    (Setup { expansion_per_k, temperature_c, origin_mm, ..Setup::default() }, scale_sigma * PER_MILLION)
}

fn expansion(section: &mut Section<'_>, key: &str) -> Option<f64> {
    section.number_where(key, "an expansion of 0 to 0.001 per K, such as 11.5e-6", |value| {
        (0.0..=MOST_PER_K).contains(&value)
    })
}

fn temperature(section: &mut Section<'_>, key: &str) -> Option<f64> {
    section.number_where(key, "a temperature of -30 to 150 °C", |celsius| RANGE_C.contains(&celsius))
}

fn lacks(section: &mut Section<'_>, key: &str, example: &str) {
    let place = section.place_of(key);
    section.report(
        Code::BAD_VALUE,
        place,
        format!("{key} has no effect without an expansion"),
        format!("write for example {example}"),
    );
}

/// The reason why an unknown is not identifiable, if any.
pub(super) fn contradiction(data: &DataSet) -> Option<(&'static str, &'static str)> {
    let has = |free: Free| data.free.contains(&free);
    let no_expansion = |setup: &Setup| setup.expansion_per_k <= 0.0;
    if has(Free::Length) && has(Free::Rod) {
        let help = "remove \"length\": set-ups with the same rod then have the same length";
        return Some(("a length for every set-up and one for every rod cannot be separated", help));
    }
    if has(Free::RodTemperature) && (has(Free::Length) || has(Free::Rod)) {
        let help = "remove \"rod_temperature\" or the length, and give rod_temperature_C where it was measured";
        return Some(("a warmer rod is a longer rod: its temperature and its length cannot be separated", help));
    }
    if has(Free::RodTemperature) && data.setups.iter().any(no_expansion) {
        return Some(("a temperature of a rod needs its expansion", "give rod_expansion_per_K in every set-up"));
    }
    if has(Free::Drift) && !has(Free::Offset) {
        return Some(("a drift moves the zero of the instrument", "write free = [\"offset\", \"drift\"]"));
    }
    if (has(Free::Slope) || has(Free::Rotation)) && data.is_square_stated {
        let help = "remove \"slope\" or \"rotation\" from free, or write reference = \"straightedge\"";
        return Some(("the direction of a square is exact, so its alignment is not an unknown", help));
    }
    if has(Free::Slope) && !has(Free::Offset) {
        return Some(("an alignment moves the zero of the instrument too", "write free = [\"offset\", \"slope\"]"));
    }
    let lengths = |setup: &Setup| data.setups.iter().any(|other| other.rod == setup.rod && differs(other, setup));
    if data.kind.measurand == Measurand::BallDistance && data.setups.iter().any(lengths) {
        return Some((
            "set-ups with the same rod differ in length_mm, length_sigma_um or rod_expansion_per_K",
            "give them the same values, or give each rod its own name",
        ));
    }
    None
}

fn differs(one: &Setup, other: &Setup) -> bool {
    (one.length_mm - other.length_mm).abs() > 0.0
        || (one.length_sigma_mm - other.length_sigma_mm).abs() > 0.0
        || (one.expansion_per_k - other.expansion_per_k).abs() > 0.0
}

/// Fills in the origins of the expansion of artifacts.
pub(super) fn finish(data: &mut DataSet, machine: &Machine) {
    let kinematics = Kinematics::new(machine);
    let mut first: Vec<Option<Vector>> = vec![None; data.setups.len()];
    for row in &data.observations {
        if let Some(first) = first.get_mut(row.setup) {
            first.get_or_insert_with(|| kinematics.tip_mm(&row.reading.position, &row.reading.tool_mm));
        }
    }
    for (setup, first) in data.setups.iter_mut().zip(first) {
        setup.origin_mm = setup.origin_mm.or(first);
    }
}

impl DataSet {
    /// Length of the rod or artifact of a row relative to 20 °C: a factor.
    #[must_use]
    pub fn stretch(&self, row: &Observation) -> f64 {
        let Some(setup) = self.setups.get(row.setup).filter(|setup| setup.expansion_per_k > 0.0) else { return 1.0 };
        let celsius = row.temperature_c.or(setup.temperature_c).unwrap_or(REFERENCE_C);
        1.0 + setup.expansion_per_k * (celsius - REFERENCE_C)
    }
}
