//! Where the tip of the tool goes in the workpiece, piece by piece: by points, and by how much the way may lie beyond them.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::{FiveAxis, Increments, Options, Output, OutputFrame, Piece, PieceArc, lost_axes};
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_machine::machine::{Kinematics, Machine};
use ncfix_machine::snc::{Kind, Setup};

/// Points of an arc and of a turn of a rotary axis are so far apart, rad: what lies beyond them is 4·10⁻⁵ of the radius.
const APART: f64 = TAU / 360.0;
/// Points of one piece, at most.
const MOST: f64 = 1440.0;
/// Directions that differ by less are the same: the square is lost in the arithmetic.
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
    /// Where the axes stand, as the program asks for it; `None` where nobody knows.
    stands: Option<AxisVector>,
}

impl<'a> Tips<'a> {
    /// Begins before the first output of a program that was corrected by these options.
    #[must_use]
    pub fn new(machine: &'a Machine, options: &Options) -> Tips<'a> {
        Tips {
            machine,
            kinematics: Kinematics::new(machine),
            increments: Increments::new(&machine.control),
            frame: options.frame,
            keeps_transform: options.five_axis == FiveAxis::Tcp,
            setup: Arc::default(),
            stands: None,
        }
    }

    /// Where the axes stand before the next output; `None` where nobody knows.
    #[must_use]
    pub fn stands(&self) -> Option<&AxisVector> {
        self.stands.as_ref()
    }

    /// Takes the next output: behind it the axes stand at its end.
    pub fn take(&mut self, output: &Output) {
        match output {
            Output::Piece(piece) => self.stands = Some(piece.nominal),
            Output::Element(element) => {
                if let Kind::Setup(setup) = &element.kind {
                    self.setup = Arc::clone(setup);
                }
                if !lost_axes(element, self.machine).is_empty() {
                    self.stands = None;
                }
            }
        }
    }

    /// The tip in the workpiece with the axes there, mm.
    #[must_use]
    pub fn tip_mm(&self, command: &AxisVector) -> Vector {
        self.kinematics.tip_mm(command, &self.setup.tool_mm)
    }

    /// From the tip to the spindle, in the workpiece, with the axes there.
    #[must_use]
    pub fn direction(&self, command: &AxisVector) -> Vector {
        self.kinematics.direction(command)
    }

    /// Whether the tool leaves the workpiece along itself when Z of the machine rises, with the axes there.
    #[must_use]
    pub fn rises_along_itself(&self, command: &AxisVector) -> bool {
        let mut above = *command;
        above[Axis::Z] += 1.0;
        (self.tip_mm(&above) - self.tip_mm(command)).dot(&self.direction(command)) > 1.0 - SAME
    }

    /// Z of the program with the axes there, mm; `None` where that is not the height along Z of the machine.
    #[must_use]
    pub fn programmed_z_mm(&self, command: &AxisVector) -> Option<f64> {
        let is_height = !(self.keeps_transform && self.setup.transform.is_some())
            && self.frame == OutputFrame::Work
            && (self.setup.frame.apply_direction(Vector::z()) - Vector::z()).norm() < SAME;
        is_height.then(|| self.setup.programmed(command)[Axis::Z])
    }

    /// Where Z is within its travel with the other axes there, mm of Z of the program; `None` where that is not the height along Z of the machine.
    /// Without limits it is everywhere.
    #[must_use]
    pub fn programmed_travel_mm(&self, command: &AxisVector) -> Option<[f64; 2]> {
        let programmed_mm = self.programmed_z_mm(command)?;
        let travel = self.machine.axis(Axis::Z).and_then(|data| data.travel);
        let [low, high] = travel.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        Some([low, high].map(|end| end - command[Axis::Z] + programmed_mm))
    }

    /// Shows points of the way of a piece that is to be taken next, in the workpiece, mm, and by how much the way may lie beyond each.
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
            // More than a turn: each point of the circle at both ends of the way along its axis.
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
        // No way at all is a whole turn.
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
}

/// An arc as it lies in its frame.
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
    /// From a place on the straight way between its ends to one on the arc, mm.
    fn bulge(&self, share: f64, along: f64) -> Vector {
        // What goes further than a turn has been everywhere after one.
        let angle = self.first + self.sweep.clamp(-TAU, TAU) * share;
        let on = [angle.cos(), angle.sin()].map(|part| self.radius_mm * part);
        let straight = |k: usize| self.from[k] + (self.to[k] - self.from[k]) * along;
        self.basis[0] * (on[0] - straight(0)) + self.basis[1] * (on[1] - straight(1))
    }
}
