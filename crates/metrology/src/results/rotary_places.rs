//! Location errors of rotary axes that no reading of a calibration can show: where an axis stands in the machine (EX0C), and how it is inclined (EA0C).
//!
//! An autocollimator shows the angle of a rotary table, and says nothing about the place of its axis. The error model then has no such term, and nothing
//! distinguishes it from a measured one of zero.

use crate::calibrate::{Parameter, identify};
use crate::measure::data::DataSet;
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::Machine;
use ncfix_model::name::{DIRECTIONS, Direction, ErrorName};
use ncfix_model::{ErrorModel, Model, ParameterName};

/// Turn of an axis in a measurement from which its place can have an effect, rad.
const TURNS_RAD: f64 = 0.01;
/// Alignment of a direction with an axis from which they are one: a place along its own axis has no effect.
const ALONG: f64 = 0.999;
/// Number of poses at which an effect is examined.
const POSES: usize = 20;
/// Travel of an axis without limits, mm, and rad.
const UNLIMITED: [f64; 2] = [200.0, 1.0];
/// Tool at these poses, mm.
const TOOL_MM: f64 = 100.0;
/// Change of a distance in the workpiece below which an effect is that of another set-up, mm per mm or rad.
const RIGID: f64 = 1e-6;

/// A location error, with the rotary axes whose motion shows it and gives it an effect.
pub(super) struct RotaryPlace {
    pub(super) name: ErrorName,
    pub(super) axes: Vec<Axis>,
}

/// The location errors of the rotary axes of a machine, and those of a spindle that they turn. Errors whose effect is that of another set-up of the workpiece
/// are omitted: the zero offset contains them, and the alignment of the workpiece.
pub(super) fn places(machine: &Machine) -> Vec<RotaryPlace> {
    let rotary = |axis: &Axis| axis.is_rotary();
    let own = machine.axis_set().iter().filter(rotary).filter_map(|axis| Some((axis, machine.axis(axis)?.direction)));
    let of_axis = own.flat_map(|(axis, direction)| {
        let has_effect = move |of: &Direction| of.is_rotation() || !is_along(*of, &direction);
        DIRECTIONS
            .into_iter()
            .filter(has_effect)
            .map(move |of| RotaryPlace { name: ErrorName::location(of, axis), axes: vec![axis] })
    });
    let heads: Vec<Axis> = machine.topology.tool.iter().copied().filter(rotary).collect();
    let across = |of: &Direction| !heads.is_empty() && !is_along(*of, &machine.spindle.axis);
    let of_spindle = DIRECTIONS
        .into_iter()
        .filter(across)
        .map(|of| RotaryPlace { name: ErrorName::spindle(of), axes: heads.clone() });
    let model = Model::new(machine, &ErrorModel::default());
    let poses = poses(machine);
    of_axis.chain(of_spindle).filter(|place| !is_set_up(machine, &model, place.name, &poses)).collect()
}

/// True if a set of readings can show a location error: its axis turns in them, or the error itself was read.
pub(super) fn shows_place(machine: &Machine, place: &RotaryPlace, set: &DataSet) -> bool {
    let is_read = set.observations.iter().any(|row| row.component == Some(place.name));
    let turns = |axis: &Axis| {
        let positions = set.observations.iter().map(|row| row.reading.position[*axis]);
        let [low, high] =
            positions.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
        high - low > TURNS_RAD
    };
    (is_read || place.axes.iter().any(turns)) && shows(machine, place.name, set)
}

/// True for a direction along or about a unit vector.
fn is_along(of: Direction, direction: &Vector) -> bool {
    direction[of.index() % 3].abs() > ALONG * direction.norm()
}

/// Poses in the travel of a machine.
fn poses(machine: &Machine) -> Vec<AxisVector> {
    spread(machine, POSES, |axis| {
        let half = UNLIMITED[usize::from(axis.is_rotary())];
        machine.axis(axis).and_then(|data| data.travel).unwrap_or([-half, half])
    })
}

/// Poses in these ranges of the axes, mm or rad: multiples of the roots of small primes, each in its unit interval, are spread evenly and have no pattern.
pub(super) fn spread(machine: &Machine, count: usize, range: impl Fn(Axis) -> [f64; 2]) -> Vec<AxisVector> {
    const PRIMES: [f64; 9] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0];
    let of = |k: usize| {
        let mut pose = AxisVector::ZERO;
        for (axis, prime) in machine.axis_set().iter().zip(PRIMES.into_iter().cycle()) {
            let [low, high] = range(axis);
            pose[axis] = low + (high - low) * (k as f64 * prime.sqrt()).fract();
        }
        pose
    };
    (1..=count).map(of).collect()
}

/// True if an error displaces the tool in the workpiece as another set-up of the workpiece would: then no distance between two places changes.
fn is_set_up(machine: &Machine, model: &Model, name: ErrorName, poses: &[AxisVector]) -> bool {
    let tool_mm = machine.spindle.axis * -TOOL_MM;
    let of = |pose: &AxisVector| {
        let nominal = model.nominal(pose, &tool_mm);
        (nominal.translation, nominal.rotation * model.sensitivity(name, pose, &tool_mm).translation)
    };
    let all: Vec<(Vector, Vector)> = poses.iter().map(of).collect();
    let longer = |(at, by): &(Vector, Vector), (other, other_by): &(Vector, Vector)| {
        let way = at - other;
        let length_mm = way.norm();
        if length_mm > 0.0 { (by - other_by).dot(&way) / length_mm } else { 0.0 }
    };
    all.iter().enumerate().all(|(k, one)| all[..k].iter().all(|other| longer(one, other).abs() < RIGID))
}

/// True if the readings of a measurement can show a location error beside the unknowns of its set-ups.
fn shows(machine: &Machine, error: ErrorName, set: &DataSet) -> bool {
    let parameter = Parameter::from(ParameterName::location(error));
    let found = identify(machine, &ErrorModel::default(), &[parameter], std::slice::from_ref(set));
    found.is_some_and(|found| found.inflation.first().is_some_and(|inflation| inflation.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::source::{FileId, Source};

    fn names(topology: &str, axes: &str) -> Vec<String> {
        let linear: String = ["X", "Y", "Z"]
            .into_iter()
            .enumerate()
            .map(|(k, axis)| {
                let mut direction = [0, 0, 0];
                direction[k] = 1;
                format!("[axis.{axis}]\ndirection = {direction:?}\ntravel_mm = [0, 400]\n")
            })
            .collect();
        let text = format!("[machine]\nname = \"m\"\ntopology = \"{topology}\"\n{linear}{axes}");
        let source = Source::new(FileId(0), "m.toml", text.into_bytes()).unwrap();
        let (machine, _) = ncfix_model::file::load(&source).0.unwrap();
        places(&machine).iter().map(|place| place.name.to_string()).collect()
    }

    #[test]
    fn what_a_set_up_of_the_workpiece_contains_is_no_place() {
        // Table C: its place across its axis, and its tilts. EC0C is the alignment of the workpiece.
        let c = "[axis.C]\ndirection = [0, 0, -1]\ntravel_deg = [-180, 180]\n";
        assert_eq!(names("wCFXYZSt", c), ["EX0C", "EY0C", "EA0C", "EB0C"]);
        // Carried by A, whose zero tilts the turning C. Both stand at the height of 40 mm.
        let a = "[axis.A]\ndirection = [-1, 0, 0]\npoint_mm = [0, 0, 40]\ntravel_deg = [-90, 90]\n";
        let of_both = names("wCAFXYZSt", &format!("{a}{c}"));
        for name in ["EY0A", "EZ0A", "EA0A", "EB0A", "EC0A", "EX0C", "EY0C", "EA0C", "EB0C"] {
            assert!(of_both.contains(&name.to_owned()), "{name}: {of_both:?}");
        }
        assert!(!of_both.contains(&"EX0A".to_owned()) && !of_both.contains(&"EC0C".to_owned()), "{of_both:?}");
        assert!(names("wXFYZSt", "").is_empty());
    }

    #[test]
    fn a_head_that_turns_the_spindle_has_places_of_the_spindle() {
        // The head A carries the spindle: a place of A moves the tool by the same amount everywhere, an offset of the spindle turns with A.
        let a = "[axis.A]\ndirection = [1, 0, 0]\npoint_mm = [0, 0, 150]\ntravel_deg = [-60, 60]\n";
        let of_head = names("wFXYZASt", a);
        assert!(!of_head.contains(&"EY0A".to_owned()) && of_head.contains(&"EY0S".to_owned()), "{of_head:?}");
        assert!(!of_head.contains(&"EZ0S".to_owned()) && !of_head.contains(&"EC0S".to_owned()), "{of_head:?}");
    }
}
