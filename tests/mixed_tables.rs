//! Mixed compensation on a five-axis machine: tables in the control for the smooth errors, a corrected program for the rest.
//!
//! The arithmetic is that of this file alone: the chain of the machine as matrices, and the tables as the manual of the control describes them (840D sl,
//! K3: linear between points, products of two tables).

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::plant::random::Random;
use super::support::Shop;

type M3 = [[f64; 3]; 3];
type V3 = [f64; 3];
/// A motion: turn, then shift.
type Motion = (M3, V3);

const AXES: [char; 5] = ['X', 'Y', 'Z', 'B', 'C'];
const POSES: usize = 60;
const HEAD: &str = "[machine]\nname = \"mixed\"\ntopology = \"wCBFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [control]\nincrement_mm = 0.0001\nincrement_deg = 0.0001\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-200, 200]\n\
    [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-200, 200]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-200, 200]\n\
    [axis.B]\ndirection = [0, -1, 0]\ntravel_deg = [-60, 60]\n\
    [axis.C]\ndirection = [0, 0, -1]\ntravel_deg = [-180, 180]\n\
    [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";
/// The errors of [`tip`] that change slowly.
const SMOOTH: &str = "[location]\nEC0Y = 40.0\nEB0Z = -30.0\nEA0Z = 25.0\nEX0C = 12.0\nEY0C = -8.0\nEA0C = 20.0\nEX0B = 10.0\nEZ0B = -15.0\nEC0B = 30.0\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 4e-5]\n\
    [[motion]]\ncomponent = \"EYX\"\nkind = \"polynomial\"\ncoefficients = [0, 0, 2e-7]\n\
    [[motion]]\ncomponent = \"EZY\"\nkind = \"polynomial\"\ncoefficients = [0, 0, -1.5e-7]\n\
    [[motion]]\ncomponent = \"EBX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-7]\n\
    [[motion]]\ncomponent = \"EAY\"\nkind = \"polynomial\"\ncoefficients = [0, 1.2e-7]\n";
/// Screw errors shorter than the steps of a table.
const SHORT: &str = "[[motion]]\ncomponent = \"EXX\"\nkind = \"periodic\"\nperiod_mm = 8\namplitude_um = 4\n\
    [[motion]]\ncomponent = \"EYY\"\nkind = \"periodic\"\nperiod_mm = 6\namplitude_um = 3\n";

fn times(a: &Motion, b: &Motion) -> Motion {
    let product = |i: usize, j: usize| (0..3).map(|k| a.0[i][k] * b.0[k][j]).sum();
    let turn = std::array::from_fn(|i| std::array::from_fn(|j| product(i, j)));
    (turn, applied(a, &b.1))
}

fn applied(a: &Motion, v: &V3) -> V3 {
    std::array::from_fn(|i| a.1[i] + (0..3).map(|k| a.0[i][k] * v[k]).sum::<f64>())
}

/// A rotation about an axis of the frame, 0 to 2, rad.
fn turn(axis: usize, angle: f64) -> Motion {
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut out = [[0.0; 3]; 3];
    out[axis][axis] = 1.0;
    (out[a][a], out[b][b]) = (angle.cos(), angle.cos());
    (out[a][b], out[b][a]) = (-angle.sin(), angle.sin());
    (out, [0.0; 3])
}

/// A small displacement: mm and rad.
fn small([x, y, z, a, b, c]: [f64; 6]) -> Motion {
    ([[1.0, -c, b], [c, 1.0, -a], [-b, a, 1.0]], [x, y, z])
}

fn shift(axis: usize, by: f64) -> Motion {
    let mut out = turn(0, 0.0);
    out.1[axis] = by;
    out
}

/// The gauge point in the frame of the workpiece at a command, mm and degrees.
fn tip([x, y, z, b, c]: [f64; 5], has_errors: bool) -> V3 {
    let e = |values: [f64; 6]| small(values.map(|value| if has_errors { value } else { 0.0 }));
    let wave = |at: f64, period: f64, amplitude: f64| amplitude * (TAU * at / period).sin();
    let tool = [
        shift(0, x),
        e([4e-5 * x + wave(x, 8.0, 4e-3), 2e-7 * x * x, 0.0, 0.0, 1e-7 * x, 0.0]),
        e([0.0, 0.0, 0.0, 0.0, 0.0, 40e-6]),
        shift(1, y),
        e([0.0, wave(y, 6.0, 3e-3), -1.5e-7 * y * y, 1.2e-7 * y, 0.0, 0.0]),
        e([0.0, 0.0, 0.0, 25e-6, -30e-6, 0.0]),
        shift(2, z),
    ];
    // Both rotary axes turn about the negative directions of F.
    let table = [
        e([10e-3, 0.0, -15e-3, 0.0, 0.0, 30e-6]),
        turn(1, -b.to_radians()),
        e([12e-3, -8e-3, 0.0, 20e-6, 0.0, 0.0]),
        turn(2, -c.to_radians()),
    ];
    let whole = |all: &[Motion]| all.iter().fold(turn(0, 0.0), |sum, one| times(&sum, one));
    let (turned, place) = whole(&table);
    let from: V3 = std::array::from_fn(|k| whole(&tool).1[k] - place[k]);
    // The turn is a rotation to the second order of 50 µrad.
    std::array::from_fn(|i| (0..3).map(|k| turned[k][i] * from[k]).sum())
}

/// The tables of a control: `$AN_CEC`.
#[derive(Default)]
struct Tables {
    values: BTreeMap<usize, BTreeMap<usize, f64>>,
    fields: BTreeMap<(usize, String), String>,
}

impl Tables {
    fn read(text: &str) -> Tables {
        let mut out = Tables::default();
        for line in text.lines() {
            let Some((name, value)) = line.strip_prefix("$AN_CEC").and_then(|line| line.split_once('=')) else {
                continue;
            };
            let (field, index) = name.strip_suffix(']').unwrap().split_once('[').unwrap();
            match index.split_once(',') {
                Some((table, point)) => {
                    let points = out.values.entry(table.parse().unwrap()).or_default();
                    points.insert(point.parse().unwrap(), value.parse().unwrap());
                }
                None => _ = out.fields.insert((index.parse().unwrap(), field[1..].to_owned()), value.to_owned()),
            }
        }
        out
    }

    fn field(&self, table: usize, name: &str) -> &str {
        &self.fields[&(table, name.to_owned())]
    }

    fn axis(&self, table: usize, name: &str) -> usize {
        self.field(table, name).trim_matches(['(', ')']).strip_prefix("AX").unwrap().parse::<usize>().unwrap() - 1
    }

    /// Value of a table alone: linear between points, constant outside.
    fn value(&self, table: usize, command: &[f64; 5]) -> f64 {
        let number = |name: &str| self.field(table, name).parse::<f64>().unwrap();
        let (least, most, step) = (number("MIN"), number("MAX"), number("STEP"));
        let points = &self.values[&table];
        let last = points.len() - 1;
        let at = (command[self.axis(table, "INPUT_AXIS")].clamp(least, most) - least) / step;
        let from = (at.floor() as usize).min(last.saturating_sub(1));
        let share = at - from as f64;
        points[&from] * (1.0 - share) + points[&last.min(from + 1)] * share
    }

    /// The command with the tables that the control adds.
    fn add(&self, command: [f64; 5]) -> [f64; 5] {
        let mut out = command;
        for &table in self.values.keys() {
            assert_eq!([self.field(table, "DIRECTION"), self.field(table, "IS_MODULO")], ["0", "0"]);
            let factor = match self.field(table, "MULT_BY_TABLE").parse::<usize>().unwrap() {
                0 => 1.0,
                other => self.value(other - 1, &command),
            };
            out[self.axis(table, "OUTPUT_AXIS")] += self.value(table, &command) * factor;
        }
        out
    }
}

/// Commands at the ends of the cutting blocks N30, N50 …
fn ends(text: &str) -> Vec<[f64; 5]> {
    let (mut at, mut number, mut out) = ([0.0; 5], 0, BTreeMap::new());
    for line in text.lines().filter(|line| !line.starts_with(';')) {
        let line = line.split(';').next().unwrap();
        for word in line.split_ascii_whitespace() {
            if let Some(n) = word.strip_prefix('N') {
                number = n.parse().unwrap();
            } else if let Some(axis) = AXES.iter().position(|axis| word.starts_with(*axis)) {
                at[axis] = word[1..].trim_start_matches('=').parse().unwrap();
            }
        }
        if number > 10 && number % 20 == 10 {
            out.insert(number, at);
        }
    }
    out.into_values().take(POSES).collect()
}

/// RMS and largest error of the tip, µm.
fn judged(nominal: &[[f64; 5]], sent: &[[f64; 5]], tables: Option<&Tables>) -> [f64; 2] {
    assert_eq!((nominal.len(), sent.len()), (POSES, POSES));
    let errors = nominal.iter().zip(sent).map(|(nominal, sent)| {
        let (wanted, is) = (tip(*nominal, false), tip(tables.map_or(*sent, |tables| tables.add(*sent)), true));
        1e3 * (0..3).map(|k| (is[k] - wanted[k]).powi(2)).sum::<f64>().sqrt()
    });
    let (mut sum, mut most) = (0.0, 0.0_f64);
    for error in errors {
        sum += error * error;
        most = most.max(error);
    }
    [(sum / POSES as f64).sqrt(), most]
}

/// Up to 62 tables take the smooth errors, and leave the screw errors of X and Y: √((4² + 3²) / 2) = 3.54 µm RMS. The program takes the rest, down to its
/// increment of 0.1 µm. If the machine file did not name the tables, the smooth errors would be corrected twice, and remain with the other sign.
#[test]
fn tables_take_the_smooth_errors_and_the_program_the_rest() {
    let mut random = Random::new(5, "mixed");
    let mut part = "N10 G90 G94\n".to_owned();
    for pose in 0..POSES {
        let [x, y, z] = [(); 3].map(|()| random.between(-180.0, 180.0));
        let (b, c) = (random.between(-55.0, 55.0), random.between(-170.0, 170.0));
        let rest = format!("Y{y:.3} Z{z:.3} B{b:.3} C{c:.3}");
        let n = 20 * (pose + 1);
        writeln!(part, "N{n} G53 G0 X{:.3} {rest}\nN{} G53 G1 X{x:.3} {rest} F5000", x - 0.4, n + 10).unwrap();
    }
    part += "N2000 M30\n";
    let named =
        HEAD.replace("controller", "active_tables = [\"CEC.INI\"]\ntable_multiplication = \"instead\"\ncontroller");
    let shop = Shop::new()
        .file("part.mpf", &part)
        .file("smooth.toml", format!("{HEAD}{SMOOTH}"))
        .file("unnamed.toml", format!("{HEAD}{SMOOTH}{SHORT}"))
        .file("named.toml", format!("{named}{SMOOTH}{SHORT}"));
    let made = ["tables", "--machine", "smooth.toml", "--format", "cec", "--scheme", "fik", "--most", "62"];
    shop.run(made.iter().chain(&["--multiplication", "instead", "-o", "CEC.INI"])).exits(0);
    let tables = Tables::read(&shop.text("CEC.INI"));
    assert!((20..=62).contains(&tables.values.len()), "{}", tables.values.len());
    let corrected = |machine: &str| {
        shop.run(["fix", "part.mpf", "-o", "out.mpf", "--machine", machine]).exits(0);
        let out = ends(&shop.text("out.mpf"));
        std::fs::remove_file(shop.path("out.mpf")).unwrap();
        out
    };
    let nominal = ends(&part);
    let before = judged(&nominal, &nominal, None);
    let by_tables = judged(&nominal, &nominal, Some(&tables));
    let by_both = judged(&nominal, &corrected("named.toml"), Some(&tables));
    let by_program = judged(&nominal, &corrected("unnamed.toml"), None);
    let twice = judged(&nominal, &corrected("unnamed.toml"), Some(&tables));
    let all = format!("{before:.3?} {by_tables:.3?} {by_both:.3?} {by_program:.3?} {twice:.3?}");
    assert!(before[0] > 25.0, "{all}");
    // The short errors of the screws, 3.54 µm, and what 62 tables leave of the smooth ones.
    assert!((by_tables[0] - 3.54_f64.hypot(2.2)).abs() < 0.3 && by_tables[1] < 9.0, "{all}");
    // Half an increment of each linear axis, and of the rotary axes 200 mm · 0.00005°.
    assert!(by_both[0] < 0.1 && by_both[1] < 0.25, "{all}");
    assert!(by_program[0] < 0.1 && by_program[1] < 0.25, "{all}");
    assert!(twice[0] > 0.9 * before[0], "{all}");
}
