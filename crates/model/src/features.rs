//! Required sampling of the errors of an axis along a path.

use ncfix_base::geometry::{AXES, AXIS_COUNT};
use ncfix_machine::machine::Machine;

use super::MotionError;
use super::motion::EntryFunction;
use super::motion::table::ErrorTable;

/// Length over which an axis without error functions counts as smooth, mm.
const LINEAR_LENGTH_MM: f64 = 500.0;
/// Angle over which a rotary axis without error functions counts as smooth, rad; its motion bends every path.
const ROTARY_LENGTH_RAD: f64 = std::f64::consts::FRAC_PI_6;

/// Finest features that are followed, mm; a file could otherwise require an excessive number of samples.
const FINEST_MM: f64 = 1e-3;
/// Finest features that are followed on a rotary axis, rad.
const FINEST_RAD: f64 = 1e-5;

/// Features of the error functions of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    /// Length (mm or rad) over which the functions of the axis may be taken as smooth: 1/8 of it is a safe sampling step.
    pub length: f64,
    /// Commands (mm or rad) at which a function has a kink, strictly increasing.
    pub knots: Vec<f64>,
    /// True if a function depends on the direction of motion of the axis.
    pub backlash: bool,
    /// Lost motion of the axis along its command, mm or rad: entries add up, each with the factor of its direction. If the sum is negative, the control adds
    /// more than the axis loses.
    lost: Vec<(f64, ErrorTable)>,
}

impl Features {
    /// Returns the distance that the command must travel after a reversal until the body follows, mm or rad.
    #[must_use]
    pub fn lost_motion(&self, command: f64) -> f64 {
        self.loss(command).max(0.0)
    }

    /// True if the control adds more at a reversal than the axis loses.
    #[must_use]
    pub fn is_over_compensated(&self, command: f64) -> bool {
        self.loss(command) < 0.0
    }

    fn loss(&self, command: f64) -> f64 {
        self.lost.iter().map(|(factor, reversal)| factor * reversal.value(command)).sum()
    }

    pub(super) fn note_length(&mut self, length: f64) {
        self.length = self.length.min(length);
    }

    /// Notes a degree: a polynomial of degree d bends about d times over the travel; a constant does not bend.
    pub(super) fn note_degree(&mut self, degree: usize, travel: f64) {
        if degree > 0 {
            self.note_length(travel / degree as f64 / 2.0);
        }
    }

    /// Notes kinks, increasing, and the smallest distance between two of them.
    pub(super) fn note_knots(&mut self, knots: impl Iterator<Item = f64>) {
        let mut last = None;
        for knot in knots {
            if let Some(last) = last {
                self.note_length(knot - last);
            }
            last = Some(knot);
            self.knots.push(knot);
        }
    }
}

/// Returns the features of every axis by slot, including axes that the machine lacks.
pub(super) fn of(machine: &Machine, motion: &[MotionError]) -> [Features; AXIS_COUNT] {
    let limit = AXES.map(|axis| if axis.is_rotary() { ROTARY_LENGTH_RAD } else { LINEAR_LENGTH_MM });
    let travels = AXES.map(|axis| {
        let travel = machine.axis(axis).and_then(|data| data.travel);
        // Without travel limits: one turn, or the length that gives a line the smoothness of an error-free axis.
        let unlimited = if axis.is_rotary() { std::f64::consts::TAU } else { 2.0 * LINEAR_LENGTH_MM };
        travel.map_or(unlimited, |[low, high]| high - low)
    });
    let mut features = limit.map(|length| Features { length, knots: Vec::new(), backlash: false, lost: Vec::new() });
    if let Some(active) = &machine.active_tables.control {
        for axis in AXES {
            let own = &mut features[axis.slot()];
            own.note_knots(active.knots(axis).into_iter());
            own.backlash |= active.has_senses(axis);
        }
    }
    for error in motion.iter().filter(|error| !error.function.is_zero()) {
        if let Some(axis) = error.name.axis() {
            error.function.note_features(axis, &travels, &mut features);
            let own = axis.dimension() + if axis.is_rotary() { 3 } else { 0 };
            if let (EntryFunction::Backlash(backlash), Some(data)) = (&error.function, machine.axis(axis))
                && error.name.direction.index() == own
            {
                // A lagging body remains behind, against the direction of the command.
                let factor = -data.direction[axis.dimension()];
                features[axis.slot()].lost.push((factor, backlash.reversal.clone()));
            }
        }
    }
    for (axis, feature) in AXES.into_iter().zip(&mut features) {
        feature.length = feature.length.max(if axis.is_rotary() { FINEST_RAD } else { FINEST_MM });
        feature.knots.sort_by(f64::total_cmp);
        feature.knots.dedup();
    }
    features
}
