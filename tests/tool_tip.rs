//! Cuts whose tip is straight in the workpiece while the tool turns: block counts, and the tip on the machine with errors, by a judge of its own.
//!
//! The judge reads the words of the output and follows them as a control does: the tip along its line or circle, the rotary axes in proportion. It has its
//! own kinematics, homogeneous matrices from the numbers of the machine below, and applies the errors itself.

mod direction;
mod feeds;
mod fewest;
mod fixed_step;
mod lost_motion;
mod tilted;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::support::Shop;

/// Length of the tool, mm.
const TOOL_MM: f64 = 150.0;
/// The tolerance, and the rounding of three coordinates to 0.1 µm: half a diagonal of 0.1 µm · √3, mm.
const LIMIT_MM: f64 = 1e-3 + 0.5e-4 * 1.7321;
/// Places of a piece.
const PLACES: u32 = 24;

type Row = [f64; 4];
type Square = [Row; 4];
type Values = BTreeMap<u8, f64>;

fn product(a: &Square, b: &Square) -> Square {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

/// A displacement by `shift` after a rotation by the vector `turn`, rad.
fn rigid(shift: [f64; 3], turn: [f64; 3]) -> Square {
    let [x, y, z] = turn;
    let angle = (x * x + y * y + z * z).sqrt();
    let cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    let (first, second) =
        if angle < 1e-12 { (1.0, 0.5) } else { (angle.sin() / angle, (1.0 - angle.cos()) / (angle * angle)) };
    std::array::from_fn(|i| {
        std::array::from_fn(|j| match (i, j) {
            (3, 3) => 1.0,
            (3, _) => 0.0,
            (_, 3) => shift[i],
            _ => {
                let square: f64 = (0..3).map(|k| cross[i][k] * cross[k][j]).sum();
                f64::from(u8::from(i == j)) + first * cross[i][j] + second * square
            }
        })
    })
}

/// The inverse of a rigid displacement.
fn inverse(a: &Square) -> Square {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| match (i, j) {
            (3, 3) => 1.0,
            (3, _) => 0.0,
            (_, 3) => -(0..3).map(|k| a[k][i] * a[k][3]).sum::<f64>(),
            _ => a[j][i],
        })
    })
}

/// An axis: letter, direction, point, errors of its place (µm, µrad), and coefficients of its motion from degree 1.
#[derive(Clone)]
struct RigAxis {
    letter: u8,
    direction: [f64; 3],
    point_mm: [f64; 3],
    place: [f64; 6],
    motion: [Vec<f64>; 6],
}

impl RigAxis {
    fn link(&self, command: f64, scale: f64) -> Square {
        let way = self.direction.map(|part| part * command);
        let zero = [0.0; 3];
        let nominal = if self.letter < b'D' { rigid(zero, way) } else { rigid(way, zero) };
        let part = |row: usize| {
            let mut power = 1.0;
            let terms = self.motion[row].iter().map(|coefficient| {
                power *= command;
                coefficient * power
            });
            scale * terms.sum::<f64>()
        };
        let place = |row: usize| scale * self.place[row] * if row < 3 { 1e-3 } else { 1e-6 };
        let small = rigid([part(0), part(1), part(2)], [part(3), part(4), part(5)]);
        let placed = rigid([place(0), place(1), place(2)], [place(3), place(4), place(5)]);
        let to = rigid(self.point_mm, zero);
        let back = rigid(self.point_mm.map(|part| -part), zero);
        [placed, nominal, small, back].iter().fold(to, |all, next| product(&all, next))
    }
}

/// A machine: the axes from F to the workpiece, and from F to the tool.
struct Rig {
    name: &'static str,
    topology: &'static str,
    workpiece: Vec<RigAxis>,
    tool: Vec<RigAxis>,
    rotary: [u8; 2],
}

impl Rig {
    fn new(name: &'static str, topology: &'static str, [first, second]: [(u8, [f64; 3], [f64; 3]); 2]) -> Rig {
        let (carried, tool) = topology.split_once('F').unwrap();
        let moves_table = |letter: u8| carried.as_bytes().contains(&letter);
        let make = |letter: u8| {
            let own = [first, second].into_iter().find(|one| one.0 == letter);
            let (direction, point_mm) = own.map_or_else(
                || {
                    let sense = if moves_table(letter) { -1.0 } else { 1.0 };
                    let row = usize::from(letter - b'X');
                    (std::array::from_fn(|k| if k == row { sense } else { 0.0 }), [0.0; 3])
                },
                |one| (one.1, one.2),
            );
            let is_rotary = letter < b'D';
            let sign = if letter.is_multiple_of(2) { 1.0 } else { -1.0 };
            let motion = std::array::from_fn(|row| match (is_rotary, row) {
                (true, 0..=2) => vec![1.8e-3 * sign, 1.2e-3 - 4e-4 * row as f64],
                (true, _) => vec![1.2e-5 * sign],
                (false, 0..=2) => {
                    vec![3e-5 * sign * f64::from(u8::from(row == usize::from(letter - b'X'))), 4e-8 * sign]
                }
                (false, _) => vec![3e-8 * sign, 3e-11],
            });
            let place = match letter {
                b'Y' => [0.0, 0.0, 0.0, 0.0, 0.0, 24.0],
                b'Z' => [0.0, 0.0, 0.0, 30.0, -17.0, 0.0],
                _ if is_rotary => [20.0, -16.0, 11.0, 34.0, -27.0, 19.0],
                _ => [0.0; 6],
            };
            RigAxis { letter, direction, point_mm, place, motion }
        };
        let workpiece = carried.bytes().rev().filter(|&letter| letter != b'w').map(make).collect();
        let tool = tool.bytes().filter(|letter| !b"St".contains(letter)).map(make).collect();
        Rig { name, topology, workpiece, tool, rotary: [first.0, second.0] }
    }

    /// The machine file; without errors if `has_errors` is false.
    fn file(&self, control: &str, has_errors: bool) -> String {
        let mut out = format!(
            "[machine]\nname = \"{}\"\ntopology = \"{}\"\ncontroller = \"{control}\"\n",
            self.name, self.topology
        );
        let mut places = String::from("[location]\n");
        let mut motions = String::new();
        for axis in self.workpiece.iter().chain(&self.tool) {
            let letter = char::from(axis.letter);
            let travel = if axis.letter < b'D' { "travel_deg = [-7200, 7200]" } else { "travel_mm = [-900, 900]" };
            let (direction, point) = (axis.direction, axis.point_mm);
            writeln!(out, "[axis.{letter}]\ndirection = {direction:?}\npoint_mm = {point:?}\n{travel}").unwrap();
            for (row, name) in ["EX", "EY", "EZ", "EA", "EB", "EC"].into_iter().enumerate() {
                if axis.place[row] != 0.0 {
                    writeln!(places, "{name}0{letter} = {:?}", axis.place[row]).unwrap();
                }
                let coefficients: Vec<f64> = std::iter::once(0.0).chain(axis.motion[row].iter().copied()).collect();
                writeln!(
                    motions,
                    "[[motion]]\ncomponent = \"{name}{letter}\"\nkind = \"polynomial\"\ncoefficients = {coefficients:?}"
                )
                .unwrap();
            }
        }
        let control = match control {
            "fanuc" => "[control]\ndecimal_point = \"calculator\"\ntool_change = \"M6\"\n",
            _ => "[control]\ntool_length_plane = 17\n",
        };
        let errors = if has_errors { places + &motions } else { String::new() };
        format!(
            "{out}[spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n{control}{errors}[zero_offset.G54]\nX_mm = 0\nY_mm = \
             0\nZ_mm = 0\nset = \"absolute\"\n[[tool]]\nnumber = 1\nlength_mm = {TOOL_MM}\nradius_mm = 5\n"
        )
    }

    /// The tip in the workpiece at axis commands, with errors if `scale` is 1.
    fn tip(&self, commands: &Values, scale: f64) -> [f64; 3] {
        let pose = self.pose(commands, scale);
        [pose[0][3], pose[1][3], pose[2][3]]
    }

    /// The direction of the tool in the workpiece, from the tip to the spindle.
    fn direction(&self, commands: &Values, scale: f64) -> [f64; 3] {
        let pose = self.pose(commands, scale);
        [pose[0][2], pose[1][2], pose[2][2]]
    }

    /// The tool in the workpiece, with its tip as origin.
    fn pose(&self, commands: &Values, scale: f64) -> Square {
        let branch = |axes: &[RigAxis]| {
            axes.iter()
                .fold(rigid([0.0; 3], [0.0; 3]), |all, axis| product(&all, &axis.link(commands[&axis.letter], scale)))
        };
        let tool = product(&branch(&self.tool), &rigid([0.0, 0.0, -TOOL_MM], [0.0; 3]));
        product(&inverse(&branch(&self.workpiece)), &tool)
    }

    /// The axis commands of the control for a tip and rotary angles.
    fn commands(&self, words: &Values) -> Values {
        let mut commands = words.clone();
        // The nominal tip is linear in X, Y and Z: Cramer's rule.
        let mut at = |x: f64, y: f64, z: f64| {
            for (letter, value) in [(b'X', x), (b'Y', y), (b'Z', z)] {
                commands.insert(letter, value);
            }
            self.tip(&commands, 0.0)
        };
        let base = at(0.0, 0.0, 0.0);
        let columns = [at(1.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(0.0, 0.0, 1.0)].map(|tip| minus(&tip, &base));
        let wanted = minus(&[words[&b'X'], words[&b'Y'], words[&b'Z']], &base);
        let whole = volume(&columns[0], &columns[1], &columns[2]);
        let x = volume(&wanted, &columns[1], &columns[2]) / whole;
        let y = volume(&columns[0], &wanted, &columns[2]) / whole;
        let z = volume(&columns[0], &columns[1], &wanted) / whole;
        at(x, y, z);
        commands
    }
}

fn minus(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn size(a: &[f64; 3]) -> f64 {
    a.iter().map(|part| part * part).sum::<f64>().sqrt()
}

fn volume(a: &[f64; 3], b: &[f64; 3], c: &[f64; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// A block with motion under the transformation: number of its block, G word, words before and after it, I and J.
#[derive(Clone, Debug)]
struct TipBlock {
    number: u32,
    motion: u32,
    /// F, and `true` if it is the reciprocal of the time (G93).
    feed: f64,
    is_by_time: bool,
    from: Values,
    to: Values,
    center: [f64; 2],
}

impl TipBlock {
    /// X Y Z and the rotary angles at a share of the block.
    fn at(&self, share: f64) -> Values {
        let mut out: Values = self.from.iter().map(|(k, from)| (*k, from + (self.to[k] - from) * share)).collect();
        if self.motion > 1 {
            let ends = [&self.from, &self.to].map(|end| [end[&b'X'], end[&b'Y']]);
            let mut center = [ends[0][0] + self.center[0], ends[0][1] + self.center[1]];
            let chord = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
            let length = chord[0].hypot(chord[1]);
            if length > 1e-9 {
                // Both radii are made equal: the center is on the bisector.
                let off =
                    (0..2).map(|k| (center[k] - ends[0][k].midpoint(ends[1][k])) * chord[k] / length).sum::<f64>();
                center = [center[0] - off * chord[0] / length, center[1] - off * chord[1] / length];
            }
            let [first, last] = ends.map(|end| (end[1] - center[1]).atan2(end[0] - center[0]));
            let radius = (ends[0][0] - center[0]).hypot(ends[0][1] - center[1]);
            let turn = std::f64::consts::TAU;
            let sense = if self.motion == 3 { 1.0 } else { -1.0 };
            let sweep = if length < 1e-9 { turn } else { (sense * (last - first)).rem_euclid(turn) };
            let angle = first + sense * sweep * share;
            out.insert(b'X', center[0] + radius * angle.cos());
            out.insert(b'Y', center[1] + radius * angle.sin());
        }
        out
    }

    fn tip(&self, share: f64) -> [f64; 3] {
        let words = self.at(share);
        [words[&b'X'], words[&b'Y'], words[&b'Z']]
    }
}

/// Reads the blocks between the words that begin and end the transformation.
fn blocks(text: &str) -> Vec<TipBlock> {
    let (mut number, mut motion, mut is_on) = (0, 0, false);
    let (mut feed, mut is_by_time) = (0.0, false);
    let mut place: Values = b"XYZABC".iter().map(|&letter| (letter, 0.0)).collect();
    let mut out = Vec::new();
    for line in text.lines() {
        let line = line.split([';', '(']).next().unwrap_or_default();
        let from = place.clone();
        let (mut center, mut moves) = ([0.0; 2], false);
        for word in line.split_whitespace() {
            match word {
                "TRAORI" | "G43.4" => is_on = true,
                "TRAFOOF" | "G49" => is_on = false,
                "G93" => is_by_time = true,
                "G94" => is_by_time = false,
                _ => {}
            }
            let (letter, value) = (word.as_bytes()[0], word[1..].trim_start_matches('=').parse::<f64>());
            let Ok(value) = value else { continue };
            match letter {
                b'N' => number = value as u32,
                b'F' => feed = value,
                b'G' if [0.0, 1.0, 2.0, 3.0].contains(&value) => motion = value as u32,
                b'X' | b'Y' | b'Z' => {
                    place.insert(letter, value);
                    moves = true;
                }
                b'A' | b'B' | b'C' => {
                    place.insert(letter, value.to_radians());
                    moves = true;
                }
                b'I' => (center[0], moves) = (value, true),
                b'J' => (center[1], moves) = (value, true),
                _ => {}
            }
        }
        if moves && is_on {
            out.push(TipBlock { number, motion, feed, is_by_time, from, to: place.clone(), center });
        }
    }
    out
}

/// The share of a block whose tip is nearest to a point, or, if the tip stays, at which a rotary axis has an angle.
fn share_at(block: &TipBlock, from: f64, tip: &[f64; 3], piece: &TipBlock) -> f64 {
    if size(&minus(&block.tip(0.5), &block.tip(0.0))) < 1e-6 {
        let way = |letter: u8| block.to[&letter] - block.from[&letter];
        let letter = *b"ABC".iter().max_by(|a, b| way(**a).abs().total_cmp(&way(**b).abs())).unwrap();
        return (piece.to[&letter] - block.from[&letter]) / way(letter);
    }
    let off = |share: f64| size(&minus(&block.tip(share), tip));
    let best = (0..=400).map(|k| from + (1.0 - from) * f64::from(k) / 400.0).min_by(|a, b| off(*a).total_cmp(&off(*b)));
    let half = (1.0 - from) / 400.0;
    let (mut low, mut high) = (best.unwrap() - half, best.unwrap() + half);
    for _ in 0..80 {
        let third = (high - low) / 3.0;
        if off(low + third) < off(high - third) { high -= third } else { low += third }
    }
    low.midpoint(high)
}

/// The number of pieces of each cut, and the largest distance of the tip from its place, mm.
fn judged(rig: &Rig, before: &str, after: &str) -> (Vec<usize>, f64) {
    let after = blocks(after);
    let (mut counts, mut worst) = (Vec::new(), 0.0_f64);
    for block in blocks(before).iter().filter(|block| block.motion > 0) {
        let pieces: Vec<&TipBlock> = after.iter().filter(|piece| piece.number == block.number).collect();
        let mut from = 0.0;
        for (k, piece) in pieces.iter().enumerate() {
            let actual = |share: f64| rig.tip(&rig.commands(&piece.at(share)), 1.0);
            let to = if k + 1 == pieces.len() { 1.0 } else { share_at(block, from, &actual(1.0), piece) };
            for place in 0..=PLACES {
                let share = f64::from(place) / f64::from(PLACES);
                worst = worst.max(size(&minus(&actual(share), &block.tip(from + (to - from) * share))));
            }
            from = to;
        }
        counts.push(pieces.len());
    }
    (counts, worst)
}

fn rigs() -> Vec<Rig> {
    let half = 0.5_f64.sqrt();
    let (zero, head) = ([0.0; 3], [0.0, 0.0, 150.0]);
    let table = (b'C', [0.0, 0.0, -1.0], zero);
    vec![
        Rig::new("tables", "wCAYFXZSt", [(b'A', [-1.0, 0.0, 0.0], [0.0, 0.0, -50.0]), table]),
        Rig::new("mixed", "wCXFYZBSt", [(b'B', [0.0, 1.0, 0.0], head), table]),
        Rig::new("nutating_table", "wCAYFXZSt", [(b'A', [-half, 0.0, -half], zero), table]),
        Rig::new("nutating_head", "wCXFYZBSt", [(b'B', [0.0, half, half], head), table]),
        Rig::new("heads", "wFXYZCBSt", [(b'B', [0.0, 1.0, 0.0], head), (b'C', [0.0, 0.0, 1.0], zero)]),
    ]
}

/// A program of a control that follows the tip during `cuts`.
fn framed(rig: &Rig, control: &str, cuts: &str) -> String {
    let [a, b] = rig.rotary.map(char::from);
    match control {
        "fanuc" => format!(
            "%\nO7\nN10 G21 G17 G90 G40 G49 G80 G94\nN20 T1 M6\nN30 G54 G0 X-50. Y-30. {a}0. {b}0. S8000 M3\nN40 G43.4 H1 \
             Z250.\n{cuts}N140 G49\nN150 G53 G0 Z500.\nN160 M30\n%\n"
        ),
        _ => format!(
            "N10 G17 G90 G71 G94 G54\nN20 T1 M6\nN30 D1 S8000 M3\nN35 G0 X-50 Y-30 Z250 {a}0 {b}0\nN40 TRAORI\nN45 ORIAXES\n{cuts}N140 \
             TRAFOOF\nN150 G0 Z400\nN160 M30\n"
        ),
    }
}

/// A program of seven cuts: four lines and a turn about the tip, an arc with a turning tool, a helix with a standing one.
fn program(rig: &Rig, control: &str) -> String {
    let [a, b] = rig.rotary.map(char::from);
    let cuts = format!(
        "N50 G0 X-50 Y-30 Z40 {a}4 {b}12\nN60 G1 Z3 F2000\nN70 X55 Y-25 Z1 {a}18 {b}40\nN80 X45 Y35 Z6 {a}30 {b}85\nN90 X-45 Y40 {a}10 \
         {b}150\nN100 {a}16 {b}165\nN110 G2 X45 Y40 I45 J0 {a}14 {b}190\nN120 G3 X45 Y40 I-15 J0 Z3\nN130 G0 Z60 {a}20 {b}120\n"
    );
    framed(rig, control, &cuts)
}

fn fixed(rig: &Rig, control: &str, text: &str, has_errors: bool) -> (Shop, String) {
    let shop = Shop::new().file("rig.toml", rig.file(control, has_errors)).file("part.nc", text);
    let run = shop.run(["fix", "part.nc", "--machine", "rig.toml", "-o", "out.nc", "--max-correction", "0.5mm"]);
    assert_eq!(run.code, 0, "{} {control}: {}", rig.name, run.stderr);
    let out = shop.text("out.nc");
    (shop, out)
}

#[test]
fn a_cut_with_a_turning_tool_is_a_few_blocks_within_the_tolerance() {
    for rig in rigs() {
        for control in ["sinumerik", "fanuc"] {
            let text = program(&rig, control);
            let (shop, out) = fixed(&rig, control, &text, true);
            let (counts, worst_mm) = judged(&rig, &text, &out);
            let all: usize = counts.iter().sum();
            assert!(worst_mm < LIMIT_MM, "{} {control}: {counts:?}, {worst_mm} mm\n{out}", rig.name);
            assert!(all <= 20, "{} {control}: {counts:?}\n{out}", rig.name);
            let rapids = blocks(&out).iter().filter(|block| block.motion == 0 && block.number == 130).count();
            assert_eq!(rapids, 1, "{} {control}\n{out}", rig.name);
            let run = shop.run(["verify", "part.nc", "out.nc", "--machine", "rig.toml"]);
            assert_eq!(run.code, 0, "{} {control}: {}{}", rig.name, run.stdout, run.stderr);
        }
    }
}

#[test]
fn without_errors_each_block_stays_one_block() {
    for rig in rigs() {
        for control in ["sinumerik", "fanuc"] {
            let text = program(&rig, control);
            let (_, out) = fixed(&rig, control, &text, false);
            let (before, after) = (blocks(&text), blocks(&out));
            assert_eq!(before.len(), after.len(), "{} {control}\n{out}", rig.name);
            for (before, after) in before.iter().zip(&after) {
                for (letter, value) in &before.to {
                    assert!((after.to[letter] - value).abs() < 1e-4, "{} {control} {before:?} {after:?}", rig.name);
                }
            }
        }
    }
}

#[test]
fn short_blocks_of_a_surface_stay_one_block_each() {
    for rig in rigs() {
        let [a, b] = rig.rotary.map(char::from);
        let mut cuts = String::new();
        for k in 0..200 {
            let way = f64::from(k);
            let (x, y) = (-50.0 + 0.5 * way, 20.0 * (0.03 * way).sin());
            let (tilt, turn) = (12.0 + 6.0 * (0.02 * way).sin(), 30.0 + 0.2 * way);
            writeln!(cuts, "N{} G1 X{x:.4} Y{y:.4} Z2 {a}{tilt:.4} {b}{turn:.4} F3000", 100 + k).unwrap();
        }
        let text = format!(
            "N10 G17 G90 G71 G94 G54\nN20 T1 M6\nN30 D1 S8000 M3\nN35 G0 X-50 Y0 Z250 {a}0 {b}0\nN40 TRAORI\nN45 ORIAXES\nN50 G0 X-50 Y0 Z2 \
             {a}12 {b}30\n{cuts}N900 TRAFOOF\nN910 M30\n"
        );
        let (_, out) = fixed(&rig, "sinumerik", &text, true);
        let (counts, worst_mm) = judged(&rig, &text, &out);
        assert!(counts.iter().all(|&count| count == 1), "{}: {counts:?}", rig.name);
        assert!(worst_mm < LIMIT_MM, "{}: {worst_mm}", rig.name);
    }
}

/// A block that only turns has its duration (G93); the feed mode that the source states in it is written where the output goes back to it.
#[test]
fn a_block_has_one_feed_mode() {
    let program = "N10 G17 G90 G71 G94 G54\nN20 T1 M6\nN30 D1\nN35 G0 X10 Y10 Z250 A0 C0\nN40 TRAORI\nN45 ORIAXES\nN50 G1 X20 Y15 Z40 F2000\n\
                   N60 G1 A20 G94 F2000\nN70 G1 X30\nN80 TRAFOOF\nN90 M30\n";
    let machine = crate::support::machine("esmaeili_huron");
    let shop = Shop::new().file("in.mpf", program);
    shop.run(["in.mpf", "-o", "out.mpf", "--machine", &machine]).exits(0);
    shop.run(["verify", "in.mpf", "out.mpf", "--machine", &machine]).exits(0);
    assert!(shop.text("out.mpf").contains("N60 G93 G1 "), "{}", shop.text("out.mpf"));
    for line in shop.text("out.mpf").lines().filter(|line| !line.starts_with(';')) {
        let modes = line.split(' ').filter(|word| ["G93", "G94", "G95"].contains(word)).count();
        assert!(modes <= 1, "{line}");
    }
}
