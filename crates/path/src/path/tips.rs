//! The path of the tool tip in the workpiece, piece by piece, as points with a bound for the path beyond them.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::space_arc::SpatialCircle;
use super::{CorrectionOptions, Increments, Output, OutputFrame, Piece, PieceArc, lost_axes};
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_machine::machine::{Kinematics, Machine};
use ncfix_machine::snc::{Kind, Setup};

/// Angle between points of an arc or of a rotary turn, rad: the path exceeds them by at most 4·10⁻⁵ of the radius.
const APART: f64 = TAU / 360.0;
/// Maximum number of points of one piece.
const MOST: f64 = 1440.0;
/// Directions that differ by less are equal: the square vanishes in double precision.
const SAME: f64 = 1e-9;

/// Follows the tip.
#[derive(Clone, Debug)]
pub struct Tips<'a> {
    machine: &'a Machine,
    kinematics: Kinematics,
    increments: Increments,
    frame: OutputFrame,
    keeps_transform: bool,
    setup: Arc<Setup>,
    /// Nominal position of the axes; `None` if unknown.
    stands: Option<AxisVector>,
}

impl<'a> Tips<'a> {
    /// Starts before the first output of a program that was corrected with these options.
    #[must_use]
    pub fn new(machine: &'a Machine, options: &CorrectionOptions) -> Tips<'a> {
        Tips {
            machine,
            kinematics: Kinematics::new(machine),
            increments: Increments::new(&machine.control),
            frame: options.frame,
            keeps_transform: options.keeps_transform(),
            setup: Arc::default(),
            stands: None,
        }
    }

    /// Position of the axes before the next output; `None` if unknown.
    #[must_use]
    pub fn stands(&self) -> Option<&AxisVector> {
        self.stands.as_ref()
    }

    /// Takes the next output; afterwards the axes are at its end.
    pub fn take(&mut self, output: &Output) {
        match output {
            Output::Piece(piece) => self.stands = Some(piece.nominal),
            Output::Cycle(block) => self.stands = Some(block.nominal),
            Output::Element(element) => {
                if let Kind::Setup(setup) = &element.kind {
                    self.setup = Arc::clone(setup);
                    self.kinematics.set_head(self.machine, setup.head);
                }
                if !lost_axes(element, self.machine).is_empty() {
                    self.stands = None;
                }
            }
        }
    }

    /// The tip in the workpiece at an axis position, mm.
    #[must_use]
    pub fn tip_mm(&self, command: &AxisVector) -> Vector {
        self.kinematics.tip_mm(command, &self.setup.tool_mm)
    }

    /// Direction from the tip to the spindle, in the workpiece, at an axis position.
    #[must_use]
    pub fn direction(&self, command: &AxisVector) -> Vector {
        self.kinematics.direction(command)
    }

    /// `true` if a rise of Z of the machine retracts the tool along itself, at an axis position.
    #[must_use]
    pub fn rises_along_itself(&self, command: &AxisVector) -> bool {
        let mut above = *command;
        above[Axis::Z] += 1.0;
        (self.tip_mm(&above) - self.tip_mm(command)).dot(&self.direction(command)) > 1.0 - SAME
    }

    /// Z of the program at an axis position, mm; `None` if that is not the height along Z of the machine.
    #[must_use]
    pub fn programmed_z_mm(&self, command: &AxisVector) -> Option<f64> {
        let is_height = !(self.keeps_transform && self.setup.transform.is_some())
            && self.frame == OutputFrame::Work
            && (self.setup.frame.apply_direction(Vector::z()) - Vector::z()).norm() < SAME;
        is_height.then(|| self.setup.programmed(command)[Axis::Z])
    }

    /// Travel of Z with the other axes at an axis position, mm of Z of the program; `None` if that is not the height along Z of the machine. Without
    /// limits it is infinite.
    #[must_use]
    pub fn programmed_travel_mm(&self, command: &AxisVector) -> Option<[f64; 2]> {
        let programmed_mm = self.programmed_z_mm(command)?;
        let travel = self.machine.axis(Axis::Z).and_then(|data| data.travel);
        let [low, high] = travel.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        Some([low, high].map(|end| end - command[Axis::Z] + programmed_mm))
    }

    /// Calls `look` with points of the path of the next piece, in the workpiece, mm, and with the largest excess of the path beyond each.
    pub fn points(&self, piece: &Piece, look: &mut dyn FnMut(&Vector, f64)) {
        let end = &piece.nominal;
        let start = self.stands.as_ref();
        start.iter().for_each(|start| look(&self.tip_mm(start), 0.0));
        look(&self.tip_mm(end), 0.0);
        let turn = start.map_or(0.0, |start| {
            AXES.into_iter()
                .filter(|axis| axis.is_rotary())
                .map(|axis| (end[axis] - start[axis]).abs())
                .fold(0.0, f64::max)
        });
        let arc = piece.arc.map(|arc| self.circle(piece, &arc));
        let sweep = arc.as_ref().map_or(0.0, |arc| arc.sweep.abs().min(TAU));
        let count = (turn.max(sweep) / APART).ceil().min(MOST);
        if count < 1.0 {
            return;
        }
        let is_transformed = self.keeps_transform && self.setup.transform.is_some();
        let radius_mm = arc.as_ref().map_or(0.0, |arc| arc.radius_mm);
        let arm_mm = start.map_or(0.0, |start| (self.tip_mm(start).norm()).max(self.tip_mm(end).norm()));
        let half = 0.5 / count;
        let slack_mm = radius_mm * (1.0 - (sweep * half).cos()) + arm_mm * (1.0 - (turn * half).cos());
        for step in 0..=count as u32 {
            let share = f64::from(step) / count;
            let from = start.unwrap_or(end);
            // More than a turn: each point of the circle is taken at both ends of the path along its axis.
            let shares = arc.as_ref().filter(|arc| arc.sweep.abs() > TAU).map_or([share, share], |_| [0.0, 1.0]);
            for along in shares {
                let bulge = arc.as_ref().map_or(Vector::zeros(), |arc| arc.bulge(share, along));
                if is_transformed {
                    look(&(self.tip_mm(from).lerp(&self.tip_mm(end), along) + bulge), slack_mm);
                    continue;
                }
                let mut command = from.lerp(end, along);
                command.set_xyz(command.xyz() + bulge);
                look(&self.tip_mm(&command), slack_mm);
            }
        }
    }

    fn circle(&self, piece: &Piece, arc: &PieceArc) -> Circle {
        if let Some(circle) = arc.spatial(&piece.counts, &self.increments) {
            return self.spatial(&circle);
        }
        let [abscissa, ordinate, _] = arc.plane.axes();
        let at = |axis: Axis, count: i64| self.increments.position(axis, count);
        let place = |axis: Axis| arc.start_counts.get(axis.dimension()).copied().unwrap_or(0);
        let center = |axis: Axis| arc.center_counts.get(axis.dimension()).copied().unwrap_or(0);
        // From the center to the start, and to the end.
        let from = [abscissa, ordinate].map(|axis| -at(axis, center(axis)));
        let to = [abscissa, ordinate].map(|axis| at(axis, piece.counts[axis.slot()] - place(axis) - center(axis)));
        let first = from[1].atan2(from[0]);
        let mut sweep = to[1].atan2(to[0]) - first;
        let sense = if arc.clockwise { -1.0 } else { 1.0 };
        // A zero sweep is a full turn.
        while sense * sweep <= SAME {
            sweep += sense * TAU;
        }
        sweep += sense * f64::from(arc.extra_turns) * TAU;
        let basis = [abscissa, ordinate].map(|axis| {
            let mut unit = Vector::zeros();
            unit[axis.dimension()] = 1.0;
            if self.frame == OutputFrame::Machine { unit } else { self.setup.frame.apply_direction(unit) }
        });
        let radius_mm = from[0].hypot(from[1]).max(to[0].hypot(to[1]));
        Circle { basis, first, sweep, radius_mm, from, to }
    }

    /// The arc of a circle through an intermediate point: its first direction leads to the start.
    fn spatial(&self, circle: &SpatialCircle) -> Circle {
        let radius_mm = circle.to_center.norm();
        let first = -circle.to_center / radius_mm;
        let second = circle.normal.cross(&first);
        let last = circle.to_end - circle.to_center;
        let in_machine = |unit: Vector| {
            if self.frame == OutputFrame::Machine { unit } else { self.setup.frame.apply_direction(unit) }
        };
        Circle {
            basis: [in_machine(first), in_machine(second)],
            first: 0.0,
            sweep: circle.sweep_rad(),
            radius_mm,
            from: [radius_mm, 0.0],
            to: [last.dot(&first), last.dot(&second)],
        }
    }
}

/// An arc in its frame.
struct Circle {
    /// The directions of its plane.
    basis: [Vector; 2],
    first: f64,
    sweep: f64,
    radius_mm: f64,
    from: [f64; 2],
    to: [f64; 2],
}

impl Circle {
    /// Vector from a place on the straight chord to the corresponding place on the arc, mm.
    fn bulge(&self, share: f64, along: f64) -> Vector {
        // After one turn the arc has passed every direction.
        let angle = self.first + self.sweep.clamp(-TAU, TAU) * share;
        let on = [angle.cos(), angle.sin()].map(|part| self.radius_mm * part);
        let straight = |k: usize| self.from[k] + (self.to[k] - self.from[k]) * along;
        self.basis[0] * (on[0] - straight(0)) + self.basis[1] * (on[1] - straight(1))
    }
}
