//! Random machines, errors, programs and options.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use ncfix_base::geometry::{AXES, Axis, Vector};
use ncfix_machine::machine::{IncrementSystem, Lever, Machine};
use ncfix_model::motion::backlash::Backlash;
use ncfix_model::motion::periodic::Periodic;
use ncfix_model::motion::polynomial::Polynomial;
use ncfix_model::motion::table::ErrorTable;
use ncfix_model::motion::{EntryFunction, MotionError};
use ncfix_model::name::DIRECTIONS;
use ncfix_model::{ErrorModel, ErrorName, LocationError};
use ncfix_path::emit;
use ncfix_path::path::{Arcs, CorrectionOptions, FiveAxis, OutputFrame, Rapids, Rotary, Subdivision};

use crate::five_axis::with_tool;

/// The block of the first move.
pub(super) const FIRST_MOVE: u32 = 10;
/// Machines with three axes, the foundation at every place.
const THREE: [&str; 6] = ["wFXYZSt", "wXYZFSt", "wXYFZSt", "wXFYZSt", "wYXFZSt", "wZFYXSt"];
/// Table-table, head-head with two pairs of axes, head-table.
const FIVE: [&str; 4] = ["wCBXFZYSt", "wFXYZCBSt", "wFXYZBASt", "wCXFYZASt"];

/// A small deterministic generator (SplitMix64).
pub(super) struct Random(pub(super) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    pub(super) fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }

    pub(super) fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }
}

/// An error function as the judge knows it, mm or rad.
pub(super) enum Shape {
    Powers(Vec<f64>),
    Knots(Vec<f64>, Vec<f64>),
    Wave { amplitude: f64, period: f64, phase: f64 },
    Reversal(f64),
}

impl Shape {
    pub(super) fn value(&self, position: f64, sense: f64) -> f64 {
        match self {
            Shape::Powers(factors) => {
                factors.iter().zip(0..).map(|(factor, power)| factor * position.powi(power)).sum()
            }
            Shape::Knots(places, values) => {
                // Beyond the ends the table keeps its last value.
                let Some(next) = places.iter().position(|&place| place > position) else {
                    return *values.last().unwrap();
                };
                if next == 0 {
                    return values[0];
                }
                let share = (position - places[next - 1]) / (places[next] - places[next - 1]);
                values[next - 1] * (1.0 - share) + values[next] * share
            }
            Shape::Wave { amplitude, period, phase } => amplitude * (TAU * position / period + phase).sin(),
            Shape::Reversal(size) => 0.5 * size * sense,
        }
    }

    fn function(&self) -> EntryFunction {
        match self {
            Shape::Powers(factors) => EntryFunction::Polynomial(Polynomial { coefficients: factors.clone() }),
            Shape::Knots(places, values) => {
                EntryFunction::Table(ErrorTable { positions: places.clone(), values: values.clone() })
            }
            Shape::Wave { amplitude, period, phase } => {
                EntryFunction::Periodic(Periodic { period: *period, amplitude: *amplitude, phase_rad: *phase })
            }
            Shape::Reversal(size) => EntryFunction::Backlash(Backlash::constant(*size)),
        }
    }
}

/// The errors of a machine as the judge knows them, by slot of the axis and component EX EY EZ EA EB EC.
#[derive(Default)]
pub(super) struct Errors {
    pub(super) spindle: [f64; 6],
    pub(super) location: [[f64; 6]; 9],
    pub(super) motion: [Vec<(usize, Shape)>; 9],
}

/// A machine, a program for it, and what is asked of the correction.
pub(super) struct Pair {
    pub(super) seed: u64,
    pub(super) machine: Machine,
    pub(super) errors: Errors,
    /// From the gauge point of the spindle to the tip.
    pub(super) tool_mm: Vector,
    pub(super) dialect: &'static str,
    pub(super) program: String,
    pub(super) options: CorrectionOptions,
    /// Whether the five-axis transformation is on.
    pub(super) is_transformed: bool,
    /// The block with which the axes are where the program says, with the tool.
    pub(super) first_move: u32,
}

impl Pair {
    pub(super) fn new(seed: u64) -> Pair {
        let mut random = Random(seed.wrapping_mul(0x2545_F491_4F6C_DD1D));
        let random = &mut random;
        let has_five = random.one_in(4);
        let topology = if has_five { random.of(&FIVE) } else { random.of(&THREE) };
        let mut machine = with_tool(crate::model::machine(topology));
        machine.control.increment_mm = random.of(&[1e-2, 1e-3, 1e-3, 1e-4, 1e-4, 1e-4, 1e-5]);
        machine.control.increment_rad = random.of(&[1e-3_f64, 1e-4, 1e-4]).to_radians();
        place(&mut machine, random);
        let errors = draw_errors(&machine, random);
        let dialects = ["sinumerik", "sinumerik", "fanuc", "rs274", "grundig"];
        let dialect = random.of(if has_five { &dialects[..4] } else { &dialects });
        if dialect == "fanuc" {
            // The finest grid that it has for its words.
            machine.control.iso.increment_system = IncrementSystem::C;
            machine.control.increment_mm = machine.control.increment_mm.max(1.0 / IncrementSystem::C.per_unit());
        }
        machine.control.grid = [machine.control.increment_mm, machine.control.increment_rad];
        let is_transformed = has_five && dialect != "rs274" && random.one_in(2);
        let is_tip_control = is_transformed && dialect == "fanuc";
        let has_tool = dialect == "sinumerik" || is_tip_control;
        let tool_mm = Vector::new(0.0, 0.0, if has_tool { -machine.tools[0].length_mm[0] } else { 0.0 });
        let mut writing = Writing::new(&machine, dialect, is_transformed, random);
        writing.program(random);
        let is_turned = writing.is_turned;
        let program = writing.text;
        let tolerance_mm = 10_f64.powf(random.between(-3.3, -1.7));
        let can_be_machine = dialect == "sinumerik" && !is_transformed && !is_turned;
        let entry = emit::entry(dialect).unwrap();
        let options = CorrectionOptions {
            tolerance_mm,
            subdivision: if random.one_in(6) {
                Subdivision::Step(random.between(2.0, 60.0))
            } else {
                Subdivision::Adaptive
            },
            arcs: if random.one_in(4) { Arcs::Chords } else { Arcs::Keep },
            turns: entry.turns,
            centers: entry.centers,
            feeds: entry.feeds,
            rapids: random.of(&[Rapids::Ends, Rapids::Ends, Rapids::None, Rapids::All]),
            frame: if can_be_machine && random.one_in(4) { OutputFrame::Machine } else { OutputFrame::Work },
            five_axis: if dialect != "sinumerik" || random.one_in(2) { FiveAxis::Tcp } else { FiveAxis::Axes },
            max_correction_mm: random.of(&[0.2, 0.2, 0.1, 0.03]),
            // A table that is corrected where G43.4 begins turns the coordinates of the control with it.
            rotary: if is_tip_control || random.one_in(3) { Rotary::Hold } else { Rotary::Correct },
            ..CorrectionOptions::default()
        };
        let first_move = if is_tip_control { FIRST_MOVE + 1 } else { FIRST_MOVE };
        Pair { seed, machine, errors, tool_mm, dialect, program, options, is_transformed, first_move }
    }

    /// The errors as the correction knows them.
    pub(super) fn model(&self) -> ErrorModel {
        let mut model = ErrorModel::default();
        let letters = ["X", "Y", "Z", "A", "B", "C"];
        let mut locate = |carrier: char, values: &[f64; 6]| {
            for (letter, &value) in letters.iter().zip(values).filter(|(_, value)| **value != 0.0) {
                let name = format!("E{letter}0{carrier}").parse().unwrap();
                model.location.push(LocationError { name, value });
            }
        };
        locate('S', &self.errors.spindle);
        for data in self.machine.axes.iter().flatten() {
            locate(char::from(data.axis.letter()), &self.errors.location[data.axis.slot()]);
        }
        for axis in AXES {
            for (component, shape) in &self.errors.motion[axis.slot()] {
                let name = ErrorName::motion(DIRECTIONS[*component], axis);
                model.motion.push(MotionError { name, function: shape.function() });
            }
        }
        model
    }
}

/// Puts rotary axes and the spindle anywhere, and turns the lever around at times.
fn place(machine: &mut Machine, random: &mut Random) {
    let point = |random: &mut Random| {
        Vector::new(random.between(-80.0, 80.0), random.between(-80.0, 80.0), random.between(-80.0, 80.0))
    };
    machine.spindle.origin_mm = point(random);
    let lever = if random.one_in(4) { Lever::Fixed } else { Lever::Carried };
    for data in machine.axes.iter_mut().flatten() {
        data.lever = lever;
        if data.axis.is_rotary() {
            data.point_mm = point(random);
        }
    }
}

fn draw_errors(machine: &Machine, random: &mut Random) -> Errors {
    let mut errors = Errors::default();
    // From none to more than most limits allow.
    let size = if random.one_in(12) { 0.0 } else { 10_f64.powf(random.between(-1.5, 0.35)) };
    let linear = [0.015 * size, 2e-5 * size];
    if random.one_in(3) {
        for component in 3..5 {
            errors.spindle[component] = random.between(-1.0, 1.0) * linear[1];
        }
    }
    for data in machine.axes.iter().flatten() {
        let slot = data.axis.slot();
        let reach = if data.axis.is_rotary() { TAU } else { 400.0 };
        for component in 0..6 {
            let size = linear[usize::from(component > 2)];
            if component > 2 || data.axis.is_rotary() {
                errors.location[slot][component] = random.between(-1.0, 1.0) * size;
            }
            if random.one_in(5) {
                continue;
            }
            let shape = match random.below(8) {
                0 => Shape::Knots(
                    (0..=8).map(|k| reach * (f64::from(k) / 4.0 - 1.0)).collect(),
                    (0..=8).map(|_| random.between(-0.5, 0.5) * size).collect(),
                ),
                1 => Shape::Wave {
                    amplitude: random.between(0.02, 0.15) * size,
                    period: reach / random.between(1.0, 30.0),
                    phase: random.between(0.0, TAU),
                },
                2 if random.one_in(3) => Shape::Reversal(random.between(-0.4, 0.4) * size),
                _ => Shape::Powers((0..4).map(|power| random.between(-1.0, 1.0) * size / reach.powi(power)).collect()),
            };
            if size > 0.0 {
                errors.motion[slot].push((component, shape));
            }
        }
    }
    errors
}

/// A program while it is written.
struct Writing {
    text: String,
    number: u32,
    /// Positions as programmed, mm and degrees, by slot.
    at: [f64; 9],
    rotary: Vec<Axis>,
    /// mm of a unit of the program, and decimals of its words.
    unit: (f64, usize),
    is_turned: bool,
    /// Feed as the reciprocal of the time of a block.
    is_inverse: bool,
    is_grundig: bool,
    /// Tool center point control of a Fanuc: it begins behind the first move, where the axes of the table are at zero.
    is_tip_control: bool,
}

impl Writing {
    fn new(machine: &Machine, dialect: &'static str, is_transformed: bool, random: &mut Random) -> Writing {
        let is_inch = random.one_in(6);
        let (is_sinumerik, is_grundig) = (dialect == "sinumerik", dialect == "grundig");
        let rotary: Vec<Axis> = machine.axis_set().iter().filter(|axis| axis.is_rotary()).collect();
        let mut writing = Writing {
            text: String::new(),
            number: 0,
            at: [0.0; 9],
            rotary,
            unit: if is_inch { (25.4, 5) } else { (1.0, 4) },
            is_turned: false,
            is_inverse: !is_transformed && !is_grundig && random.one_in(8),
            is_grundig,
            is_tip_control: is_transformed && dialect == "fanuc",
        };
        let measure = match (is_sinumerik || is_grundig, is_inch) {
            (true, true) => "G70",
            (true, false) => "G71",
            (false, true) => "G20",
            (false, false) => "G21",
        };
        let tool = if is_sinumerik { " T1 M6" } else { "" };
        if is_grundig {
            let _ = writeln!(writing.text, "%PM9001\nN9001\nN1 G17 G90 {measure}\nN2 G54");
            return writing;
        }
        let _ = writeln!(writing.text, "N1 G17 G90 G94 {measure} G54{tool}");
        if is_sinumerik && random.one_in(4) {
            let _ =
                writeln!(writing.text, "N2 TRANS X{:.3} Y{:.3}", random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        }
        if is_sinumerik && !is_transformed && writing.rotary.is_empty() && random.one_in(5) {
            let _ = writeln!(writing.text, "N3 AROT Z{:.2}", random.between(-90.0, 90.0));
            writing.is_turned = true;
        }
        if dialect == "fanuc" && writing.rotary.is_empty() && random.one_in(5) {
            let _ = writeln!(writing.text, "N3 G68 X1. Y-2. R{:.2}", random.between(-90.0, 90.0));
        }
        if is_transformed && is_sinumerik {
            writing.text += "N4 TRAORI\nN5 ORIAXES\n";
        }
        writing
    }

    /// A word for an axis at a place, mm or degrees; notes where it is in truth, rounded as it is written.
    fn word(&mut self, axis: Axis, place: f64) -> String {
        let (unit, decimals) = if axis.is_rotary() { (1.0, 3) } else { self.unit };
        let text = format!("{:.decimals$}", place / unit);
        self.at[axis.slot()] = text.parse::<f64>().unwrap() * unit;
        format!(" {}{text}", char::from(axis.letter()))
    }

    fn block(&mut self, words: &str) {
        self.number = if self.number == 0 { FIRST_MOVE } else { self.number + 10 };
        let _ = writeln!(self.text, "N{} {}", self.number, words.trim_start());
    }

    fn feed(&mut self, random: &mut Random) -> String {
        if self.is_inverse {
            format!(" F{:.2}", random.between(1.0, 60.0))
        } else {
            format!(" F{}.", 50 * (1 + random.below(80)))
        }
    }

    fn program(&mut self, random: &mut Random) {
        let mut words = "G0".to_owned();
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            words += &self.word(axis, random.between(-150.0, 150.0));
        }
        for axis in self.rotary.clone() {
            let place = if self.is_tip_control { 0.0 } else { random.between(-40.0, 40.0) };
            words += &self.word(axis, place);
        }
        self.block(&words);
        if self.is_tip_control {
            let word = self.word(Axis::Z, random.between(-150.0, 150.0));
            let _ = writeln!(self.text, "N11 G43.4 H1{word}");
            self.number += 1;
        }
        if self.is_inverse {
            self.text += "N11 G93\n";
            self.number += 1;
        }
        for _ in 0..2 + random.below(9) {
            match random.below(6) {
                0 => self.rapid(random),
                1 | 2 => self.arc(random),
                _ => self.line(random),
            }
        }
        let _ = writeln!(self.text, "N{} M30", self.number + 10);
    }

    fn targets(&mut self, random: &mut Random) -> String {
        let mut words = String::new();
        let size = 10_f64.powf(random.between(-1.0, 2.3));
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            if !random.one_in(3) {
                let place = (self.at[axis.slot()] + random.between(-size, size)).clamp(-180.0, 180.0);
                words += &self.word(axis, place);
            }
        }
        for axis in self.rotary.clone() {
            if random.one_in(2) {
                let place = (self.at[axis.slot()] + random.between(-30.0, 30.0)).clamp(-70.0, 70.0);
                words += &self.word(axis, place);
            }
        }
        if words.is_empty() {
            words = self.word(Axis::X, -self.at[0]);
        }
        words
    }

    fn line(&mut self, random: &mut Random) {
        let words = self.targets(random) + &self.feed(random);
        self.block(&format!("G1{words}"));
    }

    fn rapid(&mut self, random: &mut Random) {
        let words = self.targets(random);
        self.block(&format!("G0{words}"));
    }

    /// An arc or a helix of the XY plane, at times a full circle.
    fn arc(&mut self, random: &mut Random) {
        let radius = 10_f64.powf(random.between(-0.3, 2.0));
        let start_angle = random.between(0.0, TAU);
        let (x, y) = (self.at[0], self.at[1]);
        let (center_x, center_y) = (x - radius * start_angle.cos(), y - radius * start_angle.sin());
        let is_full = random.one_in(6);
        let swept = random.between(0.05, 0.95) * TAU;
        let clockwise = random.one_in(2);
        let angle = start_angle + if clockwise { -swept } else { swept };
        let mut words = if clockwise { "G2" } else { "G3" }.to_owned();
        if !is_full {
            words += &self.word(Axis::X, center_x + radius * angle.cos());
            words += &self.word(Axis::Y, center_y + radius * angle.sin());
        }
        if random.one_in(3) && !(self.is_grundig && is_full) {
            let place = (self.at[2] + random.between(-20.0, 20.0)).clamp(-180.0, 180.0);
            words += &self.word(Axis::Z, place);
        }
        let (unit, decimals) = self.unit;
        let center = if self.is_grundig { [center_x, center_y] } else { [center_x - x, center_y - y] };
        let _ = write!(words, " I{:.decimals$} J{:.decimals$}", center[0] / unit, center[1] / unit);
        if self.is_grundig && is_full {
            words += " B5=360";
        }
        words += &self.feed(random);
        self.block(&words);
    }
}
