//! What the tests of correction and emission share: error models, runs of the corrector, and a replay of its pieces that knows
//! nothing of how they were made.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Machine, State};
use ncfix_machine::snc::{Element, TextReader};
use ncfix_model::motion::backlash::Backlash;
use ncfix_model::motion::polynomial::Polynomial;
use ncfix_model::motion::table::ErrorTable;
use ncfix_model::motion::{EntryFunction, MotionError};
use ncfix_model::name::DIRECTIONS;
use ncfix_model::{ErrorModel, ErrorName, Model};
use ncfix_path::path::{CorrectionOptions, Corrector, Increments, Output, Piece, Prediction};

/// A small deterministic generator (SplitMix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// Evenly between two values.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn chance(&mut self) -> bool {
        self.next() & 1 == 1
    }
}

pub(crate) fn motion(name: &str, function: EntryFunction) -> MotionError {
    MotionError { name: name.parse().unwrap(), function }
}

pub(crate) fn polynomial(coefficients: &[f64]) -> EntryFunction {
    EntryFunction::Polynomial(Polynomial { coefficients: coefficients.to_vec() })
}

pub(crate) fn table(positions: &[f64], values_um: &[f64]) -> EntryFunction {
    let values = values_um.iter().map(|um| um * 1e-3).collect();
    EntryFunction::Table(ErrorTable { positions: positions.to_vec(), values })
}

pub(crate) fn backlash(value_um: f64) -> EntryFunction {
    EntryFunction::Backlash(Backlash::constant(value_um * 1e-3))
}

/// All 21 errors of three axes as cubic polynomials of the size of a tired machine over 500 mm: up to some tens of µm and µrad.
pub(crate) fn tired(random: &mut Random) -> ErrorModel {
    let mut errors = ErrorModel::default();
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        for direction in DIRECTIONS {
            let size = if direction.is_rotation() { 2e-5 } else { 2e-2 };
            let coefficients: Vec<f64> =
                (0..4).map(|power| random.between(-size, size) / 500_f64.powi(power)).collect();
            errors.motion.push(MotionError {
                name: ErrorName::motion(direction, axis),
                function: EntryFunction::Polynomial(Polynomial { coefficients }),
            });
        }
    }
    errors
}

/// A machine of the samples.
pub(crate) fn load_machine(name: &str) -> (Machine, ErrorModel) {
    let path = format!("{}/samples/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let source = Source::new(FileId(0), name, std::fs::read(path).unwrap()).unwrap();
    ncfix_model::file::load(&source).0.unwrap()
}

/// A corrected stream.
pub(crate) struct Run {
    pub(crate) pieces: Vec<Piece>,
    pub(crate) findings: Vec<Diagnostic>,
    pub(crate) prediction: Prediction,
}

/// Corrects SNC text on a machine with errors.
pub(crate) fn correct(text: &str, machine: &Machine, errors: &ErrorModel, options: CorrectionOptions) -> Run {
    correct_elements(TextReader::new(text).map(Result::unwrap), machine, errors, options)
}

/// Corrects elements.
pub(crate) fn correct_elements(
    elements: impl Iterator<Item = Element>,
    machine: &Machine,
    errors: &ErrorModel,
    options: CorrectionOptions,
) -> Run {
    let model = Model::new(machine, errors);
    let mut corrector = Corrector::new(elements.map(Ok), machine, &model, options);
    let (mut pieces, mut findings) = (Vec::new(), Vec::new());
    for output in corrector.by_ref() {
        match output {
            Ok(Output::Piece(piece)) => pieces.push(piece),
            Ok(Output::Element(_) | Output::Cycle(_)) => {}
            Err(finding) => findings.push(finding),
        }
    }
    let prediction = corrector.prediction().clone();
    Run { pieces, findings, prediction }
}

/// Replays pieces from their counts alone, as a control that stands at the axis zero and has no zero offset would.
pub(crate) struct Replay {
    increments: Increments,
    position: AxisVector,
    state: State,
}

impl Replay {
    pub(crate) fn new(machine: &Machine) -> Replay {
        Replay { increments: Increments::new(&machine.control), position: AxisVector::ZERO, state: State::default() }
    }

    /// `count` commands evenly along a piece with the sense of motion at each, the last at its end.
    pub(crate) fn follow(&mut self, piece: &Piece, count: usize) -> Vec<(AxisVector, State)> {
        let start = self.position;
        let mut end = start;
        for axis in AXES.into_iter().filter(|&axis| piece.words.contains(axis)) {
            let count = piece.counts[axis.slot()] as f64;
            end[axis] = if axis.is_rotary() {
                (count * self.increments.rotary_deg).to_radians()
            } else {
                count * self.increments.linear_mm
            };
        }
        let mut last = start;
        let mut commands = Vec::new();
        for k in 1..=count {
            let fraction = k as f64 / count as f64;
            let mut command = start.lerp(&end, fraction);
            if let Some(arc) = &piece.arc {
                let [abscissa, ordinate, _] = arc.plane.axes();
                let center = [abscissa, ordinate]
                    .map(|axis| start[axis] + arc.center_counts[axis.slot()] as f64 * self.increments.linear_mm);
                let angle = |p: &AxisVector| (p[ordinate] - center[1]).atan2(p[abscissa] - center[0]);
                let radius = |p: &AxisVector| (p[ordinate] - center[1]).hypot(p[abscissa] - center[0]);
                let turn = std::f64::consts::TAU;
                let mut sweep = (angle(&end) - angle(&start)).rem_euclid(turn);
                if arc.clockwise {
                    sweep = (angle(&start) - angle(&end)).rem_euclid(turn);
                }
                if sweep < 1e-9 {
                    sweep = turn;
                }
                sweep += turn * f64::from(arc.extra_turns);
                let at = angle(&start) + fraction * if arc.clockwise { -sweep } else { sweep };
                // A control spreads a small difference of the radii over the arc.
                let reach = radius(&start) + fraction * (radius(&end) - radius(&start));
                command[abscissa] = center[0] + reach * at.cos();
                command[ordinate] = center[1] + reach * at.sin();
            }
            self.state.note_motion(&last, &command);
            commands.push((command, self.state));
            last = command;
        }
        self.position = end;
        commands
    }
}

/// A path in space, sampled densely, and the distance of points from it. Points must come in order.
pub(crate) struct Trace {
    points: Vec<Vector>,
    at: usize,
}

impl Trace {
    pub(crate) fn new(points: Vec<Vector>) -> Trace {
        Trace { points, at: 0 }
    }

    /// Distance of a point from the path near where the last one was, mm.
    pub(crate) fn distance_mm(&mut self, point: &Vector) -> f64 {
        let reach = self.points.len() / 20 + 2;
        let last = (self.at + reach).min(self.points.len() - 1);
        let mut best = f64::INFINITY;
        for k in self.at.saturating_sub(3)..last {
            let (a, b) = (self.points[k], self.points[k + 1]);
            let way = b - a;
            let along = ((point - a).dot(&way) / way.norm_squared().max(1e-30)).clamp(0.0, 1.0);
            let distance = (point - a - way * along).norm();
            if distance < best {
                (best, self.at) = (distance, k);
            }
        }
        best
    }
}
