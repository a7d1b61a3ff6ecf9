//! Second step of the correction: what the temperatures of the moment ask for, added to pieces just before they are written (Spaan 1995, ch. 7).
//!
//! The first step has corrected and cut the program in one condition of the machine. Here each piece is solved for its nominal end once more, in that
//! condition and in the one of the moment; the difference is what the model asks for, of which [`Doses`] says how much is applied. Along an arc and
//! on the spot nothing changes, so that centers stay right: a constant shift moves start, end and center alike. A piece that does not name an axis
//! whose shift has changed gets its word.

use std::sync::Arc;

use ncfix_base::geometry::{AXES, AXIS_COUNT, AxisSet, AxisVector, ROTARY_AXES};
use ncfix_machine::machine::{Machine, State};
use ncfix_machine::snc::{Dwell, FeedUnit, Kind, Manner};
use ncfix_model::{Model, Solve};

use super::place::Placer;
use super::{Increments, Options, Output, Piece, lost_axes};

/// What a piece is asked about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// What the model asks for where the axes stand, mm and rad.
    pub before: AxisVector,
    /// The same at the end of the piece.
    pub now: AxisVector,
    /// Way of the tip, mm.
    pub way_mm: f64,
    /// Time that has passed since the last piece, by the program, s.
    pub time_s: f64,
    /// What the piece allows.
    pub allows: Allows,
}

/// What a piece allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allows {
    /// Another shift at its end: a straight way with feed.
    Change,
    /// The same on a way on which nothing is cut.
    Rapid,
    /// No change: an arc, a step on the spot.
    Nothing,
    /// It is not corrected: no shift is applied at its end, and the next piece begins without one.
    Release,
}

/// Says how much of what is asked for is applied.
pub trait Doses {
    /// The shift at the end of the piece, mm and rad.
    fn dose(&mut self, asked: &Asked) -> AxisVector;
}

/// What was made of the last piece.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Applied {
    /// What the model asks for at its end.
    pub asked: AxisVector,
    /// What is applied there.
    pub shift: AxisVector,
    /// How long it takes, dwells before it included, s.
    pub time_s: f64,
}

/// Adds the second step to pieces, one after the other in the order of the program.
pub struct Live<'a> {
    machine: &'a Machine,
    placer: Placer<'a>,
    /// Where the first step has brought the axes, and where they should be.
    command: AxisVector,
    nominal: AxisVector,
    /// Where they were sent: what was written last, and for which axes.
    sent: AxisVector,
    counts: [i64; AXIS_COUNT],
    written: AxisSet,
    waited_s: f64,
    applied: Applied,
}

impl<'a> Live<'a> {
    /// Begins one for pieces that were corrected by `base` with the same options.
    #[must_use]
    pub fn new(machine: &'a Machine, base: &'a Model, options: &Options) -> Self {
        let start = options.start;
        Live {
            machine,
            placer: Placer::new(machine, base, options),
            command: start.unwrap_or(AxisVector::ZERO),
            nominal: start.unwrap_or(AxisVector::ZERO),
            sent: start.unwrap_or(AxisVector::ZERO),
            counts: [0; AXIS_COUNT],
            written: AxisSet::EMPTY,
            waited_s: 0.0,
            applied: Applied::default(),
        }
    }

    /// What was made of the last piece.
    pub fn applied(&self) -> &Applied {
        &self.applied
    }

    /// The next output of the first step, with what `now` asks for; without it with what was applied last.
    pub fn apply(&mut self, output: Output, now: Option<&Model>, doses: &mut dyn Doses) -> Output {
        let element = match output {
            Output::Piece(piece) => return Output::Piece(self.shift(piece, now, doses)),
            Output::Element(element) => element,
        };
        match &element.kind {
            Kind::Setup(setup) => {
                let [old, new] = [&self.placer.setup.frame, &setup.frame];
                if old.linear() != new.linear() && !self.placer.is_machine_frame() {
                    // The words of all axes mean something else.
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
            () if !piece.is_corrected || piece.manner == Manner::Reference => Allows::Release,
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

    /// The piece with a shift, and with the words that it needs.
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
            arc
        });
        (self.counts, self.sent) = (placed.counts, placed.command);
        self.written = self.written.union(if piece.others_stay { words } else { piece.known });
        Piece { counts: placed.counts, command: placed.command, words, arc, ..piece }
    }

    /// What is to be added to a command for the sake of the moment.
    fn asked(&self, nominal: &AxisVector, command: &AxisVector, now: Option<&Model>) -> AxisVector {
        let Some(now) = now else { return self.applied.asked };
        let tool_mm = &self.placer.setup.tool_mm;
        // In which sense the axes move does to both the same.
        let solve = |model: &Model, start: &AxisVector| {
            model.solve(nominal, tool_mm, &State::default(), start, Solve::PositionOnly).ok()
        };
        let Some(then) = solve(self.placer.model, command) else { return self.applied.asked };
        let Some(mut moment) = solve(now, &(then + self.applied.asked)) else { return self.applied.asked };
        // Rotary axes stay as the first step has left them.
        for axis in ROTARY_AXES {
            moment[axis] = then[axis];
        }
        moment - then
    }

    /// Way of the axes that move the tip, mm, and time of a piece, s.
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

    /// At the feed, and no axis faster than it can.
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
