//! Second step of the correction: adds the correction for the current temperatures to pieces just before they are written (Spaan 1995, ch. 7).
//!
//! The first step has corrected and cut the program for one condition of the machine. Here each piece is solved again for its nominal end, in that
//! condition and in the current one. The difference is the required shift, of which [`Doses`] determines the applied part. Along an arc and on the
//! spot nothing changes, so that centers stay valid: a constant shift moves start, end and center alike. A piece that does not name an axis whose
//! shift has changed gets a word for it.

use std::sync::Arc;

use ncfix_base::geometry::{AXES, AXIS_COUNT, AxisSet, AxisVector, ROTARY_AXES};
use ncfix_machine::machine::{Machine, State};
use ncfix_machine::snc::{Dwell, FeedUnit, Kind, MotionMode};
use ncfix_model::{Model, Solve};

use super::place::CommandSolver;
use super::{CorrectionOptions, Increments, Output, Piece, lost_axes};

/// Input of [`Doses`] for a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Required shift at the start of the piece, mm and rad.
    pub before: AxisVector,
    /// Required shift at the end of the piece, mm and rad.
    pub now: AxisVector,
    /// Tip path length, mm.
    pub way_mm: f64,
    /// Program time since the last piece, s.
    pub time_s: f64,
    /// Permitted change of the shift.
    pub allows: Allows,
}

/// Permitted change of the shift in a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allows {
    /// Another shift at its end: a straight feed path.
    Change,
    /// Another shift at its end, on a path without cutting.
    Rapid,
    /// No change: an arc, a step on the spot.
    Nothing,
    /// Uncorrected piece: no shift is applied at its end, and the next piece begins without one.
    Release,
}

/// Determines the applied part of the required shift.
pub trait Doses {
    /// The shift at the end of the piece, mm and rad.
    fn dose(&mut self, asked: &Asked) -> AxisVector;
}

/// Result for the last piece.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Applied {
    /// Required shift at its end.
    pub asked: AxisVector,
    /// Applied shift at its end.
    pub shift: AxisVector,
    /// Its duration including preceding dwells, s.
    pub time_s: f64,
}

/// Applies the second step to pieces in the order of the program.
pub struct Live<'a> {
    machine: &'a Machine,
    placer: CommandSolver<'a>,
    /// Command of the first step, and nominal position.
    command: AxisVector,
    nominal: AxisVector,
    /// Written position, and the axes for which it is valid.
    sent: AxisVector,
    counts: [i64; AXIS_COUNT],
    written: AxisSet,
    waited_s: f64,
    applied: Applied,
}

impl<'a> Live<'a> {
    /// Starts the second step for pieces that were corrected by `base` with the same options.
    #[must_use]
    pub fn new(machine: &'a Machine, base: &'a Model, options: &CorrectionOptions) -> Self {
        let start = options.start;
        Live {
            machine,
            placer: CommandSolver::new(machine, base, options),
            command: start.unwrap_or(AxisVector::ZERO),
            nominal: start.unwrap_or(AxisVector::ZERO),
            sent: start.unwrap_or(AxisVector::ZERO),
            counts: [0; AXIS_COUNT],
            written: AxisSet::EMPTY,
            waited_s: 0.0,
            applied: Applied::default(),
        }
    }

    /// Result for the last piece.
    pub fn applied(&self) -> &Applied {
        &self.applied
    }

    /// Applies the shift of `now`, which has all heads of the machine, to the next output of the first step; without `now`, the last shift.
    pub fn apply(&mut self, output: Output, now: Option<&Model>, doses: &mut dyn Doses) -> Output {
        let mut element = match output {
            Output::Piece(piece) => return Output::Piece(self.shift(piece, now, doses)),
            Output::Element(element) => element,
            Output::Cycle(_) => return output,
        };
        match &mut element.kind {
            Kind::Here(here) => here.stand_at(here.command + (self.sent - self.command)),
            Kind::Setup(setup) => {
                let [old, new] = [&self.placer.setup.frame, &setup.frame];
                if old.linear() != new.linear() && !self.placer.is_machine_frame() {
                    // The words of all axes change their meaning.
                    self.written = AxisSet::EMPTY;
                }
                self.placer.set_up(Arc::clone(setup), &self.sent, &mut self.counts, &mut self.written);
            }
            Kind::Dwell(Dwell::Seconds(seconds)) => self.waited_s += seconds.max(0.0),
            _ => self.written = self.written.difference(lost_axes(&element, self.machine)),
        }
        Output::Element(element)
    }

    fn shift(&mut self, piece: Piece, now: Option<&Model>, doses: &mut dyn Doses) -> Piece {
        let (way_mm, time_s) = self.way(&piece);
        let allows = match () {
            () if !piece.is_corrected || piece.motion_mode == MotionMode::Reference => Allows::Release,
            () if piece.arc.is_some() || piece.take_up => Allows::Nothing,
            () if piece.rapid => Allows::Rapid,
            () => Allows::Change,
        };
        let asked = Asked {
            before: self.asked(&self.nominal, &self.command, now),
            now: self.asked(&piece.nominal, &piece.command, now),
            way_mm,
            time_s: time_s + std::mem::take(&mut self.waited_s),
            allows,
        };
        let shift = doses.dose(&asked);
        self.applied = Applied { asked: asked.now, shift, time_s: asked.time_s };
        (self.command, self.nominal) = (piece.command, piece.nominal);
        self.place(piece, &shift)
    }

    /// The piece with a shift and the words that it then needs.
    fn place(&mut self, piece: Piece, shift: &AxisVector) -> Piece {
        let mut placed = self.placer.round(&(piece.command + *shift), piece.known);
        let mut words = piece.words;
        if piece.others_stay {
            for axis in AXES.into_iter().filter(|&axis| !words.contains(axis) && self.written.contains(axis)) {
                placed.counts[axis.slot()] = self.counts[axis.slot()];
                placed.command[axis] = self.sent[axis];
            }
        } else {
            for axis in piece.known.iter() {
                let slot = axis.slot();
                if !self.written.contains(axis) || placed.counts[slot] != self.counts[slot] {
                    words.insert(axis);
                }
            }
        }
        let arc = piece.arc.map(|mut arc| {
            for (slot, start) in arc.start_counts.iter_mut().enumerate() {
                *start += placed.counts[slot] - piece.counts[slot];
            }
            for (slot, through) in arc.through_counts.iter_mut().flatten().enumerate() {
                *through += placed.counts[slot] - piece.counts[slot];
            }
            arc
        });
        (self.counts, self.sent) = (placed.counts, placed.command);
        self.written = self.written.union(if piece.others_stay { words } else { piece.known });
        Piece { counts: placed.counts, command: placed.command, words, arc, ..piece }
    }

    /// The required shift of a command in the current condition.
    fn asked(&self, nominal: &AxisVector, command: &AxisVector, now: Option<&Model>) -> AxisVector {
        let Some(now) = now else { return self.applied.asked };
        let tool_mm = &self.placer.setup.tool_mm;
        // The direction of motion affects both solutions equally.
        let solve = |model: &Model, start: &AxisVector| {
            model.solve(nominal, tool_mm, &State::default(), start, Solve::PositionOnly).ok()
        };
        let Some(then) = solve(self.placer.model, command) else { return self.applied.asked };
        let now = now.for_setup(self.placer.setup.head, self.placer.setup.zero);
        let Some(mut moment) = solve(now, &(then + self.applied.asked)) else {
            return self.applied.asked;
        };
        // Rotary axes keep the command of the first step.
        for axis in ROTARY_AXES {
            moment[axis] = then[axis];
        }
        moment - then
    }

    /// Path length of the axes that move the tip, mm, and duration of a piece, s.
    fn way(&self, piece: &Piece) -> (f64, f64) {
        let from = self.command;
        let chord = (piece.command.xyz() - from.xyz()).norm();
        let increment = Increments::new(&self.machine.control).linear_mm;
        let way_mm = piece.arc.map_or(chord, |arc| {
            let [abscissa, ordinate, _] = arc.plane.axes();
            let center = [abscissa, ordinate].map(|axis| arc.center_counts[axis.dimension()] as f64 * increment);
            let [dx, dy] = [abscissa, ordinate].map(|axis| piece.command[axis] - from[axis]);
            let radius = center[0].hypot(center[1]);
            let [from_angle, to_angle] = [(-center[1]).atan2(-center[0]), (dy - center[1]).atan2(dx - center[0])];
            let sense = if arc.clockwise { -1.0 } else { 1.0 };
            let mut turn = (sense * (to_angle - from_angle)).rem_euclid(std::f64::consts::TAU);
            if turn < 1e-9 {
                turn = std::f64::consts::TAU;
            }
            let turn = turn + std::f64::consts::TAU * f64::from(arc.extra_turns);
            let along = (chord * chord - dx * dx - dy * dy).max(0.0).sqrt();
            (radius * turn).hypot(along)
        });
        (way_mm, self.time_s(piece, &from, way_mm))
    }

    /// Duration at the feed, within the speed limits of the axes, s.
    fn time_s(&self, piece: &Piece, from: &AxisVector, way_mm: f64) -> f64 {
        const SECONDS_PER_MINUTE: f64 = 60.0;
        let slowest = self.machine.axes.iter().flatten().map(|data| {
            let way = (piece.command[data.axis] - from[data.axis]).abs();
            let way = if data.axis.is_rotary() { way.to_degrees() } else { way };
            data.max_feed.filter(|feed| *feed > 0.0).map_or(0.0, |feed| way / feed)
        });
        let slowest = slowest.fold(0.0, f64::max);
        let at_feed = match piece.feed {
            _ if piece.rapid => 0.0,
            feed if feed <= 0.0 => 0.0,
            feed if piece.unit == FeedUnit::InverseTime => feed.recip(),
            feed => way_mm / feed,
        };
        SECONDS_PER_MINUTE * at_feed.max(slowest)
    }
}
