//! Predictions against the truth: random machines, measured by simulated instruments, calibrated, corrected, and judged by a rigid-body model of their own.
//!
//! The model below has no line in common with the forward function. It multiplies the transforms of the bodies as `docs/explanation/theory.md` states them:
//! location error, motion, motion error, about the point of each axis.
#![allow(clippy::print_stdout, reason = "rates are worth reading where a test fails")]

use std::fmt::Write as _;

use ncfix::prelude::*;
use ncfix_report::prediction::IntervalReport;
use ncfix_report::verdict::Grade;

type V3 = [f64; 3];

/// Rotation and translation.
#[derive(Clone, Copy)]
struct Rigid {
    turn: [V3; 3],
    shift: V3,
}

const IDENTITY: Rigid = Rigid { turn: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], shift: [0.0; 3] };

impl Rigid {
    fn moved(shift: V3) -> Rigid {
        Rigid { shift, ..IDENTITY }
    }

    /// Rotation by a vector, Rodrigues' formula.
    fn turned(by: V3) -> Rigid {
        let angle = by.iter().map(|part| part * part).sum::<f64>().sqrt();
        if angle == 0.0 {
            return IDENTITY;
        }
        let [x, y, z] = by.map(|part| part / angle);
        let (s, c) = angle.sin_cos();
        let d = 1.0 - c;
        let turn = [
            [c + x * x * d, x * y * d - z * s, x * z * d + y * s],
            [y * x * d + z * s, c + y * y * d, y * z * d - x * s],
            [z * x * d - y * s, z * y * d + x * s, c + z * z * d],
        ];
        Rigid { turn, shift: [0.0; 3] }
    }

    fn of(&self, point: V3) -> V3 {
        std::array::from_fn(|row| self.shift[row] + (0..3).map(|k| self.turn[row][k] * point[k]).sum::<f64>())
    }

    fn then(&self, next: &Rigid) -> Rigid {
        let turn = std::array::from_fn(|row| {
            std::array::from_fn(|column| (0..3).map(|k| self.turn[row][k] * next.turn[k][column]).sum())
        });
        Rigid { turn, shift: self.of(next.shift) }
    }

    /// The point that this transform brings to `point`.
    fn back(&self, point: V3) -> V3 {
        let off: V3 = std::array::from_fn(|row| point[row] - self.shift[row]);
        std::array::from_fn(|row| (0..3).map(|k| self.turn[k][row] * off[k]).sum())
    }
}

/// Axis of a synthetic machine.
struct OwnAxis {
    letter: u8,
    direction: V3,
    point: V3,
}

/// Synthetic machine with its true errors.
struct TrueMachine {
    tool_side: Vec<OwnAxis>,
    workpiece_side: Vec<OwnAxis>,
    /// Name, value in mm, rad or per power of mm.
    errors: Vec<(&'static str, f64)>,
    /// Axes and their lost motions, mm.
    lost: Vec<(u8, f64)>,
}

/// Places of the axis bodies: each is dragged by its command and lags by up to half of the lost motion to either side.
#[derive(Clone, Copy)]
struct Bodies([f64; 6]);

impl Bodies {
    /// Drags the bodies along a motion on which no axis reverses.
    fn drag(&mut self, truth: &TrueMachine, command: &Pose) {
        for ((body, at), letter) in self.0.iter_mut().zip(command).zip(LETTERS) {
            let half = truth.lost.iter().find(|(own, _)| *own == letter).map_or(0.0, |(_, lost)| 0.5 * lost);
            *body = body.clamp(at - half, at + half);
        }
    }
}

/// Axis positions by letter, mm and rad.
type Pose = [f64; 6];
const LETTERS: [u8; 6] = *b"XYZABC";

fn slot(letter: u8) -> usize {
    LETTERS.iter().position(|&own| own == letter).unwrap()
}

impl TrueMachine {
    /// Displacement and rotation of an axis: location errors, or motion errors at a position.
    fn deviation(&self, letter: u8, position: Option<f64>) -> Rigid {
        let mut parts = [0.0; 6];
        for &(name, value) in &self.errors {
            let name = name.as_bytes();
            let direction = slot(name[1]);
            match (name[2] == b'0', position) {
                (true, None) if name[3] == letter => parts[direction] += value,
                (false, Some(q)) if name[2] == letter => parts[direction] += value * q.powi(i32::from(name[3] - b'0')),
                _ => {}
            }
        }
        let [x, y, z, a, b, c] = parts;
        Rigid::moved([x, y, z]).then(&Rigid::turned([a, b, c]))
    }

    fn branch(&self, axes: &[OwnAxis], pose: &Pose, bodies: &Pose, is_true: bool) -> Rigid {
        axes.iter().fold(IDENTITY, |sum, axis| {
            let q = pose[slot(axis.letter)];
            let body = if is_true { bodies[slot(axis.letter)] } else { q };
            let along = axis.direction.map(|part| part * body);
            let motion = if axis.letter < b'D' { Rigid::turned(along) } else { Rigid::moved(along) };
            let to = sum.then(&Rigid::moved(axis.point));
            let own = if is_true {
                self.deviation(axis.letter, None).then(&motion).then(&self.deviation(axis.letter, Some(q)))
            } else {
                motion
            };
            to.then(&own).then(&Rigid::moved(axis.point.map(|part| -part)))
        })
    }

    /// The nominal tip in the workpiece.
    fn nominal(&self, pose: &Pose, tool: V3) -> V3 {
        let tip = self.branch(&self.tool_side, pose, pose, false).of(tool);
        self.branch(&self.workpiece_side, pose, pose, false).back(tip)
    }

    /// The true tip in the workpiece.
    fn tip(&self, pose: &Pose, bodies: &Bodies, tool: V3) -> V3 {
        let tip = self.branch(&self.tool_side, pose, &bodies.0, true).of(tool);
        self.branch(&self.workpiece_side, pose, &bodies.0, true).back(tip)
    }

    /// Deviation of the tip from the workpiece point with which it nominally coincides, along F.
    fn displacement(&self, pose: &Pose, bodies: &Bodies, tool: V3) -> V3 {
        let point = self.nominal(pose, tool);
        let tip = self.branch(&self.tool_side, pose, &bodies.0, true).of(tool);
        let there = self.branch(&self.workpiece_side, pose, &bodies.0, true).of(point);
        std::array::from_fn(|row| tip[row] - there[row])
    }

    /// Bodies on the sides where motions in these directions leave them.
    fn led(&self, pose: &Pose, directions: [f64; 6]) -> Bodies {
        let mut bodies = Bodies(std::array::from_fn(|axis| pose[axis] - directions[axis]));
        bodies.drag(self, pose);
        bodies
    }
}

/// Directions of the last motions of X, Y and Z, and their cells in a row.
struct Senses([f64; 6], Option<Pose>);

impl Senses {
    /// Before the first row, all axes came from below.
    fn new() -> Senses {
        Senses([1.0; 6], None)
    }

    fn moved(&mut self, pose: &Pose) -> ([f64; 6], String) {
        if let Some(last) = &self.1 {
            for axis in 0..6 {
                let step = pose[axis] - last[axis];
                self.0[axis] = if step.abs() > 1e-9 { step.signum() } else { self.0[axis] };
            }
        }
        self.1 = Some(*pose);
        (self.0, format!("{},{},{}", self.0[0], self.0[1], self.0[2]))
    }
}

/// Random numbers: xorshift (Marsaglia 2003) and the sum of twelve uniform numbers.
struct Dice(u64);

impl Dice {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }
}

/// Gap of the measurements.
#[derive(Clone, Copy, PartialEq)]
enum MissingData {
    Nothing,
    /// Z never moves.
    AxisZ,
    /// All measurements have one tool.
    SecondTool,
    /// X is measured up to its middle.
    HalfOfX,
}

/// The spindle was trammed, so its tilt is known.
const THREE: &str = "[machine]\nname = \"three\"\ntopology = \"wFXYZt\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 500]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 500]\n[control]\ninitial_zero_offset = \"G500\"\nincrement_mm = 0.0001\n\
    [[tool]]\nnumber = 1\nlength_mm = 150\n[location]\nEA0S = 0.0\nEB0S = 0.0\n[uncertainty]\nEA0S = [1e-7]\nEB0S = [1e-7]\n";
const FIVE: &str = "[machine]\nname = \"five\"\ntopology = \"wCAYFXZt\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-250, 250]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-250, 250]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 500]\n[axis.A]\ndirection = [-1, 0, 0]\npoint_mm = [0, 0, -40]\ntravel_deg = [-60, 60]\n\
    [axis.C]\ndirection = [0, 0, -1]\npoint_mm = [5, 0, 0]\ntravel_deg = [-180, 180]\n\
    [control]\ninitial_zero_offset = \"G500\"\nincrement_mm = 0.0001\nincrement_deg = 0.0001\n[[tool]]\nnumber = 1\nlength_mm = 150\n";

/// Parameters with their standard deviations over the machines: mm, rad, per power of mm.
const OF_THREE: [(&str, f64); 13] = [
    ("EXX1", 20e-6),
    ("EXX2", 4e-8),
    ("EYY1", 20e-6),
    ("EYY2", 4e-8),
    ("EZZ1", 20e-6),
    ("EC0Y", 20e-6),
    ("EA0Z", 20e-6),
    ("EB0Z", 20e-6),
    ("EYX2", 3e-8),
    ("EZX2", 3e-8),
    ("EXY2", 3e-8),
    ("EBX1", 1e-7),
    ("EAY1", 1e-7),
];
const OF_FIVE: [(&str, f64); 14] = [
    ("EXX1", 20e-6),
    ("EYY1", 20e-6),
    ("EZZ1", 20e-6),
    ("EC0Y", 20e-6),
    ("EA0Z", 20e-6),
    ("EB0Z", 20e-6),
    ("EY0A", 5e-3),
    ("EZ0A", 5e-3),
    ("EB0A", 30e-6),
    ("EC0A", 30e-6),
    ("EX0C", 5e-3),
    ("EY0C", 5e-3),
    ("EA0C", 30e-6),
    ("EB0C", 30e-6),
];

/// A machine, its measurements and its program.
struct Case {
    truth: TrueMachine,
    file: &'static str,
    parameters: Vec<String>,
    data: Vec<DataSet>,
    program: String,
}

const TOOL: V3 = [0.0, 0.0, -150.0];

impl Case {
    fn three(dice: &mut Dice, gap: MissingData, is_loose: bool) -> Case {
        let axis = |letter, direction| OwnAxis { letter, direction, point: [0.0; 3] };
        // From machines that need no correction to bad ones, and instruments from good to poor.
        let size = 10_f64.powf(dice.between(-1.7, 0.0));
        let sigma_um = dice.between(0.3, 2.0);
        let lost = if is_loose {
            vec![(b'X', 8e-3 * size * dice.uniform()), (b'Y', 8e-3 * size * dice.uniform())]
        } else {
            Vec::new()
        };
        let truth = TrueMachine {
            lost,
            tool_side: vec![axis(b'X', [1.0, 0.0, 0.0]), axis(b'Y', [0.0, 1.0, 0.0]), axis(b'Z', [0.0, 0.0, 1.0])],
            workpiece_side: Vec::new(),
            errors: OF_THREE.map(|(name, sigma)| (name, sigma * size * dice.normal())).to_vec(),
        };
        let is_flat = gap == MissingData::AxisZ;
        let last_x = if gap == MissingData::HalfOfX { 250.0 } else { 500.0 };
        let tools: &[f64] = if gap == MissingData::SecondTool { &[100.0] } else { &[100.0, 250.0] };
        let [low_z, high_z] = if is_flat { [200.0; 2] } else { [100.0, 400.0] };
        // A laser along X, Y and Z.
        let mut laser =
            "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_x_mm,tool_y_mm,tool_z_mm,dx_um,dy_um,dz_um\n".to_owned();
        for (axis, ends) in [[0.0, last_x], [0.0, 400.0], [low_z, high_z]].into_iter().enumerate() {
            let zero = 5.0 * dice.normal();
            let mut senses = Senses::new();
            // Forward and, on a machine with lost motion, back.
            let back = (0..if is_loose { 21 } else { 0 }).rev();
            for k in (0..21).chain(back) {
                let mut pose = [last_x / 2.0, 200.0, 200.0, 0.0, 0.0, 0.0];
                pose[axis] = ends[0] + (ends[1] - ends[0]) * f64::from(k) / 20.0;
                let (directions, senses) = senses.moved(&pose);
                let bodies = truth.led(&pose, directions);
                let read = truth.displacement(&pose, &bodies, [0.0, 0.0, -100.0])[axis];
                let read = zero + 1e3 * read + sigma_um * dice.normal();
                let cells: Vec<String> =
                    (0..3).map(|k| if k == axis { format!("{read:.5}") } else { String::new() }).collect();
                let _ = writeln!(
                    laser,
                    "{axis},{axis},{},{},{},{senses},0,0,-100,{}",
                    pose[0],
                    pose[1],
                    pose[2],
                    cells.join(",")
                );
            }
        }
        // A ball-bar of 100 mm in one or three planes.
        let centre = [last_x / 2.0, 200.0, 220.0];
        let mut bar = "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_x_mm,tool_y_mm,tool_z_mm,dr_um\n".to_owned();
        let planes: &[[usize; 2]] = if is_flat { &[[0, 1]] } else { &[[0, 1], [1, 2], [2, 0]] };
        for (plane, &[first, second]) in planes.iter().enumerate() {
            let ball = {
                let at = truth.nominal(&[centre[0], centre[1], centre[2], 0.0, 0.0, 0.0], [0.0; 3]);
                at.map(|part| part + 3e-3 * dice.normal())
            };
            let longer_um = 2.0 * dice.normal();
            let mut senses = Senses::new();
            for k in 0..36 {
                let angle = f64::from(k) * std::f64::consts::TAU / 36.0;
                let mut at = centre;
                at[first] += 100.0 * angle.cos();
                at[second] += 100.0 * angle.sin();
                let pose = [at[0], at[1], at[2], 0.0, 0.0, 0.0];
                let (directions, senses) = senses.moved(&pose);
                let tip = truth.tip(&pose, &truth.led(&pose, directions), [0.0; 3]);
                let far = tip.iter().zip(ball).map(|(one, other)| (one - other).powi(2)).sum::<f64>().sqrt();
                let read = 1e3 * (far - 100.0) + longer_um + sigma_um * dice.normal();
                let _ =
                    writeln!(bar, "{plane},P{plane},{:.9},{:.9},{:.9},{senses},0,0,0,{read:.5}", at[0], at[1], at[2]);
            }
        }
        let setups = (0..planes.len()).map(|plane| {
            format!("[setup.P{plane}]\ncentre_mm = [{}, {}, {}]\nlength_mm = 100\n", centre[0], centre[1], centre[2])
        });
        let setups: String = setups.collect();
        // A grid of displacements against an artifact of unknown position.
        let mut grid = "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_x_mm,tool_y_mm,tool_z_mm,dx_um,dy_um,dz_um\n".to_owned();
        for (number, &length) in tools.iter().enumerate() {
            let off: V3 = std::array::from_fn(|_| 5.0 * dice.normal());
            let mut senses = Senses::new();
            for k in 0..48 {
                let [i, j, l] = [k % 4, (k / 4) % 4, k / 16].map(f64::from);
                let pose = [last_x * i / 3.0, 400.0 * j / 3.0, low_z + (high_z - low_z) * l / 2.0, 0.0, 0.0, 0.0];
                let (directions, senses) = senses.moved(&pose);
                let read = truth.displacement(&pose, &truth.led(&pose, directions), [0.0, 0.0, -length]);
                let read: V3 = std::array::from_fn(|k| off[k] + 1e3 * read[k] + sigma_um * dice.normal());
                let _ = writeln!(
                    grid,
                    "{number},T{number},{:.9},{:.9},{},{senses},0,0,-{length},{:.5},{:.5},{:.5}",
                    pose[0], pose[1], pose[2], read[0], read[1], read[2]
                );
            }
        }
        let of = |kind: &str, free: &str| {
            format!("[measurement]\nkind = \"{kind}\"\nsigma_um = {sigma_um}\nfree = [{free}]\n")
        };
        let data = vec![
            DataSet::parse("laser.csv", laser, of("displacement", "\"offset\"")).unwrap(),
            DataSet::parse("bar.csv", bar, of("ballbar", "\"centre\", \"length\"") + &setups).unwrap(),
            DataSet::parse("grid.csv", grid, of("displacement", "\"offset\"")).unwrap(),
        ];
        let of_z = ["EZZ1", "EA0Z", "EB0Z"];
        let with_one_tool = ["EBX1", "EAY1"];
        let parameters = OF_THREE.iter().map(|(name, _)| *name);
        let parameters = parameters.filter(|name| !is_flat || !(of_z.contains(name) || with_one_tool.contains(name)));
        let parameters = parameters.chain(["EXXb", "EYYb"].into_iter().filter(|_| is_loose));
        let mut program =
            "N10 G17 G90 G71 G94 G500\nN20 T1 M6\nN25 D1\nN28 G0 X10 Y10 Z160\nN30 G0 X50 Y50 Z150\nN40 G1 Z20 F500\n"
                .to_owned();
        for k in 0..6 {
            let [x, y, z] = [dice.between(20.0, 480.0), dice.between(20.0, 380.0), dice.between(10.0, 150.0)];
            let x = if k == 2 { 470.0 } else { x };
            let _ = writeln!(program, "N{} G1 X{x:.3} Y{y:.3} Z{z:.3}", 50 + k);
        }
        program += "N60 M30\n";
        Case { truth, file: THREE, parameters: parameters.map(String::from).collect(), data, program }
    }

    fn five(dice: &mut Dice) -> Case {
        let linear = |letter, direction| OwnAxis { letter, direction, point: [0.0; 3] };
        let size = 10_f64.powf(dice.between(-1.5, 0.0));
        let sigma_um = dice.between(0.3, 2.0);
        let truth = TrueMachine {
            lost: Vec::new(),
            tool_side: vec![linear(b'X', [1.0, 0.0, 0.0]), linear(b'Z', [0.0, 0.0, 1.0])],
            workpiece_side: vec![
                linear(b'Y', [0.0, -1.0, 0.0]),
                OwnAxis { letter: b'A', direction: [-1.0, 0.0, 0.0], point: [0.0, 0.0, -40.0] },
                OwnAxis { letter: b'C', direction: [0.0, 0.0, -1.0], point: [5.0, 0.0, 0.0] },
            ],
            errors: OF_FIVE.map(|(name, sigma)| (name, sigma * size * dice.normal())).to_vec(),
        };
        let mut rows = "run,setup,X,Y,Z,A,C,tool_x_mm,tool_y_mm,tool_z_mm,dx_um,dy_um,dz_um\n".to_owned();
        for k in 0..120 {
            let degrees = [dice.between(-60.0, 60.0).round(), dice.between(-180.0, 180.0).round()];
            let degrees = match k {
                0 => [-60.0, -180.0],
                1 => [60.0, 180.0],
                _ => degrees,
            };
            let edge = |dice: &mut Dice, low: f64, high: f64| match k {
                0 => low,
                1 => high,
                _ => dice.between(low, high).round(),
            };
            let at = [edge(dice, -200.0, 200.0), edge(dice, -200.0, 200.0), edge(dice, 100.0, 400.0)];
            let length = if k % 2 == 0 { 100.0 } else { 250.0 };
            let pose = [at[0], at[1], at[2], degrees[0].to_radians(), 0.0, degrees[1].to_radians()];
            let read = truth.displacement(&pose, &Bodies(pose), [0.0, 0.0, -length]);
            let read: V3 = std::array::from_fn(|k| 1e3 * read[k] + sigma_um * dice.normal());
            let _ = writeln!(
                rows,
                "1,A,{},{},{},{},{},0,0,-{length},{:.5},{:.5},{:.5}",
                at[0], at[1], at[2], degrees[0], degrees[1], read[0], read[1], read[2]
            );
        }
        let description = format!("[measurement]\nkind = \"displacement\"\nsigma_um = {sigma_um}\n");
        let data = vec![DataSet::parse("rows.csv", rows, description).unwrap()];
        let mut program =
            "N10 G17 G90 G71 G94 G500\nN20 T1 M6\nN25 D1\nN30 G0 X50 Y50 Z150 A0 C0\nN40 G1 Z20 F500\n".to_owned();
        for k in 0..6 {
            let [x, y, z] = [dice.between(-180.0, 180.0), dice.between(-180.0, 180.0), dice.between(10.0, 150.0)];
            let [a, c] = [dice.between(-50.0, 50.0), dice.between(-170.0, 170.0)];
            let _ = writeln!(program, "N{} G1 X{x:.3} Y{y:.3} Z{z:.3} A{a:.3} C{c:.3}", 50 + k);
        }
        program += "N60 M30\n";
        let parameters = OF_FIVE.iter().map(|(name, _)| (*name).to_owned()).collect();
        Case { truth, file: FIVE, parameters, data, program }
    }

    /// Calibrates, corrects, and compares the prediction with the truth; `None` if the readings are not larger than their uncertainty.
    fn run(&self) -> Option<Judged> {
        let bare = Machine::from_text("bare.toml", self.file).unwrap();
        let mut options = CalibrationOptions::default();
        options.parameters.clone_from(&self.parameters);
        let found = match Calibration::run(&bare, &self.data, &options) {
            Ok(found) => found,
            Err(error) if error.to_string().contains("E0608") => return None,
            Err(error) => panic!("{error}"),
        };
        // The machine goes through its file, as in the shop.
        let machine = Machine::from_text("own.toml", &found.extended_machine_text(self.file).unwrap()).unwrap();
        let program = Program::parse("part.mpf", self.program.as_str(), DialectChoice::Sinumerik).unwrap();
        // The worst of these machines need more than the usual limit.
        let mut options = Options::default();
        options.max_correction_mm = 2.0;
        let correction = program.correct(&machine, &options);
        let report = correction.report().unwrap_or_else(|error| panic!("{error}"));
        let corrected = Program::parse("out.mpf", correction.text().unwrap(), DialectChoice::Sinumerik).unwrap();
        let verdict = program.verify(&corrected, &machine).unwrap().verdict.unwrap();
        // The truth along the straight pieces, every 2 mm or so. Before the first motion the bodies are anywhere.
        let [mut before, mut after] = [Vec::new(), Vec::new()];
        let mut last: Option<([Pose; 2], [Bodies; 2])> = None;
        let pose =
            |command: &AxisVector| [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C].map(|axis| command[axis]);
        for output in correction.pieces().unwrap() {
            let Output::Piece(piece) = output.unwrap() else { continue };
            let ends = [pose(&piece.nominal), pose(&piece.command)];
            let (start, mut bodies) = last.unwrap_or_else(|| (ends, ends.map(Bodies)));
            let size = (0..3).map(|k| (ends[0][k] - start[0][k]).powi(2)).sum::<f64>().sqrt();
            let count = (size / 2.0).ceil().max(1.0) as u32;
            for k in 1..=count {
                let share = f64::from(k) / f64::from(count);
                let [nominal, command] = [0, 1].map(|which| -> Pose {
                    std::array::from_fn(|k| start[which][k] + (ends[which][k] - start[which][k]) * share)
                });
                let wanted = self.truth.nominal(&nominal, TOOL);
                let mut off = |which: usize, command: &Pose| {
                    bodies[which].drag(&self.truth, command);
                    let tip = self.truth.tip(command, &bodies[which], TOOL);
                    1e3 * tip.iter().zip(wanted).map(|(one, other)| (one - other).powi(2)).sum::<f64>().sqrt()
                };
                let both = [off(0, &nominal), off(1, &command)];
                // A step on the spot only prepares the bodies.
                if !piece.rapid && !piece.take_up {
                    before.push(both[0]);
                    after.push(both[1]);
                }
            }
            last = Some((ends, bodies));
        }
        let figures = |all: &[f64]| {
            let rms = (all.iter().map(|one| one * one).sum::<f64>() / all.len() as f64).sqrt();
            [rms, all.iter().copied().fold(0.0, f64::max)]
        };
        let prediction = report.prediction.clone().unwrap();
        let codes = report.coverage.unwrap().gaps.iter().map(|gap| gap.code).collect();
        let is_green = verdict.is_supported() && verdict.grade == Grade::Ok;
        Some(Judged {
            before: figures(&before),
            after: figures(&after),
            intervals: [prediction.before.unwrap(), prediction.after.unwrap()],
            codes,
            is_green,
        })
    }
}

/// A case with its truth: root mean square and largest error, µm.
struct Judged {
    before: [f64; 2],
    after: [f64; 2],
    intervals: [IntervalReport; 2],
    codes: Vec<&'static str>,
    is_green: bool,
}

impl Judged {
    /// True for each figure that lies in its interval: RMS and maximum before, RMS and maximum after.
    fn hits(&self) -> [bool; 4] {
        let [before, after] = &self.intervals;
        let is_in = |value: f64, [low, high]: [f64; 2]| low <= value && value <= high;
        [
            is_in(self.before[0], before.rms_um),
            is_in(self.before[1], before.max_um),
            is_in(self.after[0], after.rms_um),
            is_in(self.after[1], after.max_um),
        ]
    }

    /// True for each figure that lies below its interval.
    fn below(&self) -> [bool; 4] {
        let [before, after] = &self.intervals;
        let figures = [before.rms_um, before.max_um, after.rms_um, after.max_um];
        let truth = [self.before, self.after].concat();
        std::array::from_fn(|k| truth[k] < figures[k][0])
    }

    fn is_worse(&self) -> bool {
        self.after[0] > self.before[0] || self.after[1] > self.before[1]
    }
}

/// Sums over simulated machines.
#[derive(Default)]
struct Tally {
    /// Machines that were judged, and those whose readings are below their uncertainty.
    judged: usize,
    refused: usize,
    /// Figures in their interval: RMS and maximum before, RMS and maximum after; and those below it.
    hits: [usize; 4],
    below: [usize; 4],
    /// Green verdicts, and machines that got worse.
    green: usize,
    worse: usize,
}

/// Judges machines with three and five axes, every other one of three axes with lost motion.
fn counted(cases: usize, seed: u64) -> Tally {
    let mut dice = Dice(seed);
    let mut out = Tally::default();
    for number in 0..cases {
        let case = match number % 4 {
            3 => Case::five(&mut dice),
            kind => Case::three(&mut dice, MissingData::Nothing, kind == 1),
        };
        let Some(judged) = case.run() else {
            out.refused += 1;
            continue;
        };
        assert!(judged.codes.is_empty(), "case {number}: {:?}", judged.codes);
        out.judged += 1;
        out.hits.iter_mut().zip(judged.hits()).for_each(|(sum, is_hit)| *sum += usize::from(is_hit));
        out.below.iter_mut().zip(judged.below()).for_each(|(sum, is_below)| *sum += usize::from(is_below));
        out.green += usize::from(judged.is_green);
        out.worse += usize::from(judged.is_worse());
        assert!(
            !(judged.is_green && judged.is_worse()),
            "case {number} is green: {:?} → {:?}",
            judged.before,
            judged.after
        );
    }
    println!(
        "{} machines, {} without readings above their uncertainty: in the interval {:?} (RMS, max before; RMS, max after), below it {:?}, {} green, {} worse",
        out.judged, out.refused, out.hits, out.below, out.green, out.worse
    );
    out
}

#[test]
fn the_true_error_lies_in_the_predicted_interval() {
    let found = counted(40, 0x9e37_79b9);
    // Of 40 cases with a probability of 95 % each, fewer than 34 are in the interval once in 300 times.
    assert!(found.hits.iter().all(|&hits| hits + found.refused >= 34), "{:?}", found.hits);
    // Green needs measured axes and a certain gain: about a quarter of these machines.
    assert!(found.green > 10 && found.refused < 4, "{} {}", found.green, found.refused);
}

#[test]
#[ignore = "a minute: 1000 machines"]
fn the_true_error_lies_in_the_predicted_interval_in_95_of_100_cases() {
    let seed = std::env::var("NCFIX_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(0x1234_5678_9abc);
    let found = counted(1000, seed);
    let share = found.hits.map(|hits| hits as f64 / found.judged as f64);
    // The lower ends before the correction also cover the scatter that the model contains, so more of them hit.
    assert!(share.iter().all(|share| *share >= 0.93), "{share:?}");
    assert!(share[2..].iter().all(|share| *share <= 0.97), "{share:?}");
}

#[test]
fn gaps_of_the_measurements_are_named_and_never_green() {
    let mut dice = Dice(0xfeed_beef);
    for (gap, codes) in [
        (MissingData::AxisZ, ["W0316"].as_slice()),
        (MissingData::SecondTool, &["W0318"]),
        (MissingData::HalfOfX, &["W0317"]),
    ] {
        for number in 0..6 {
            let judged = Case::three(&mut dice, gap, number % 2 == 1).run().unwrap();
            assert_eq!(judged.codes, codes);
            assert!(!judged.is_green);
        }
    }
}
