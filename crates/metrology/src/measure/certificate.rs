//! Certificates: the effect of an error of a stated length or scale on all readings that rest on it.
//!
//! Such an error is the same in every reading, so repeated readings do not reduce it (JCGM 100:2008, 5.2.5). It is no unknown of a fit: a fit of the readings
//! changed by one standard uncertainty gives the contribution to each parameter (JCGM 100:2008, 5.1.3, note 2).

use std::collections::BTreeMap;

use super::data::{DataSet, Free, Observation};
use super::kind::{Measurand, Seen};
use ncfix_machine::machine::{Branch, Machine};
use ncfix_model::{ErrorModel, Model};

/// Readings of a measurement: three values for each row, mm.
type ValueChanges = Vec<[f64; 3]>;

/// A length or scale whose error is common to many readings.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Certified {
    /// The scales of all lasers: their air and material temperatures.
    Instrument,
    /// The scales of all artifacts: they were calibrated on one machine.
    Artefact,
    /// A ball-bar, by the label of its rod.
    Rod(String),
    /// A ball-bar without a label, by its length in nanometers.
    Length(u64),
}

/// Changes of all readings by one standard uncertainty of each certificate, mm: for each certificate, the changes of each measurement. Without certificates
/// it is empty.
#[must_use]
pub fn changes(machine: &Machine, sets: &[DataSet]) -> Vec<Vec<ValueChanges>> {
    let mut all: BTreeMap<Certified, Vec<ValueChanges>> = BTreeMap::new();
    let model = Model::new(machine, &ErrorModel::default());
    for (number, data) in sets.iter().enumerate() {
        for (row, observation) in data.observations.iter().enumerate() {
            let Some((what, change)) = change(machine, &model, data, observation) else { continue };
            let of_sets = all
                .entry(what)
                .or_insert_with(|| sets.iter().map(|set| vec![[0.0; 3]; set.observations.len()]).collect());
            if let Some(own) = of_sets.get_mut(number).and_then(|own| own.get_mut(row)) {
                *own = change;
            }
        }
    }
    all.into_values().collect()
}

/// The certificate on which a reading rests, and the change of its values by one standard uncertainty.
fn change(
    machine: &Machine,
    model: &Model,
    data: &DataSet,
    observation: &Observation,
) -> Option<(Certified, [f64; 3])> {
    let setup = data.setups.get(observation.setup);
    let reading = &observation.reading;
    if data.kind.measurand == Measurand::BallDistance {
        // A free length is not that of the certificate.
        let is_free = [Free::Length, Free::Rod].iter().any(|free| data.free.contains(free));
        let setup = setup.filter(|setup| setup.length_sigma_mm > 0.0 && !is_free)?;
        let label = data.rods.get(setup.rod).filter(|label| !label.is_empty());
        let nanometers = (setup.length_mm * 1e6).round() as u64;
        let what = label.map_or(Certified::Length(nanometers), |label| Certified::Rod(label.clone()));
        return Some((what, [setup.length_sigma_mm, 0.0, 0.0]));
    }
    let sigma = Some(data.scale_sigma).filter(|sigma| *sigma > 0.0)?;
    match data.kind.measurand {
        Measurand::Component => {
            let component = observation.component?;
            let axis = observation.motion_axis().filter(|axis| !axis.is_rotary())?;
            if component.direction.is_rotation() || component.direction.index() != axis.dimension() {
                return None;
            }
            // The value is the deviation of the moving body, the laser reads the tool relative to the workpiece.
            let is_on_table = machine.topology.branch(axis) == Some(Branch::Workpiece);
            let way = if is_on_table { -reading.position[axis] } else { reading.position[axis] };
            Some((Certified::Instrument, [sigma * way, 0.0, 0.0]))
        }
        Measurand::LineLength => {
            let seen = Seen::new(machine, model, reading, &reading.tool_mm);
            let tip = seen.nominal.translation;
            let way = match (setup?.direction, setup?.station_mm) {
                (Some(direction), _) => direction.dot(&tip),
                (None, Some(station)) => (tip - station).norm(),
                (None, None) => return None,
            };
            Some((Certified::Instrument, [sigma * way, 0.0, 0.0]))
        }
        Measurand::Displacement => {
            let seen = Seen::new(machine, model, reading, &reading.tool_mm);
            let from_origin = seen.nominal.translation - setup?.origin_mm.unwrap_or_default();
            let grown = seen.to_f * from_origin * -sigma;
            Some((Certified::Artefact, grown.into()))
        }
        _ => None,
    }
}

/// The measurements with their readings changed by one standard uncertainty of a certificate.
#[must_use]
pub fn changed(sets: &[DataSet], changes: &[ValueChanges]) -> Vec<DataSet> {
    let mut out = sets.to_vec();
    for (set, changes) in out.iter_mut().zip(changes) {
        for (row, changes) in set.observations.iter_mut().zip(changes) {
            row.values.iter_mut().zip(changes).for_each(|(value, change)| *value = value.map(|value| value + change));
        }
    }
    out
}
