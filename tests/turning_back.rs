//! Axes that the corrections turn back within their lost motion: the written pieces keep the tolerance with the bodies where a machine has them.
//!
//! The machines and the path of the tip are computed here, from the words of both programs. The limit is the tolerance of 1 µm, a quarter of the rounding of
//! three axes to 1 µm (0.25 · √3/2 µm), and 5 % for the path between places: 1.2665 µm.

use std::fmt::Write as _;

use crate::support::Shop;

type Place = [f64; 3];

const LIMIT_MM: f64 = 1.2665e-3;
/// Places on a piece.
const PLACES: u32 = 64;

/// A machine of three axes on the tool side, and a program. Errors have the names of ISO 230-1.
struct Worn {
    /// Errors by the first, second and third power of the position, mm.
    shapes: &'static [(&'static str, Place)],
    /// Displacement between the two directions of motion, µm; along the axis it is lost motion.
    reversals: &'static [(&'static str, f64)],
    /// Rapid moves lead all bodies first.
    program: &'static str,
}

/// On each of them an axis turned back within its lost motion on a piece. The tip was off by 1.30, 1.55 and 1.48 µm there, by the same arithmetic.
const MACHINES: [Worn; 3] = [
    Worn {
        shapes: &[
            ("EXX", [-1.241498e-4, 7.107024e-7, -9.662533e-10]),
            ("EYX", [-1.845331e-4, 4.608452e-7, 0.0]),
            ("EZX", [-2.183103e-5, 0.0, 0.0]),
            ("EXY", [7.465423e-5, -6.246826e-7, 1.019521e-9]),
            ("EYY", [3.011219e-4, -2.097721e-6, 3.174581e-9]),
            ("EZY", [-2.830164e-4, 1.830189e-6, -2.669476e-9]),
            ("EXZ", [1.165371e-4, -1.118519e-6, 1.910107e-9]),
            ("EYZ", [-2.230957e-4, 1.297292e-6, -1.781163e-9]),
            ("EZZ", [-1.006304e-4, 6.258089e-7, -8.937461e-10]),
        ],
        reversals: &[("EXX", -11.17), ("EYX", 5.27), ("EYY", -11.07), ("EZZ", -27.79), ("EXZ", -6.04)],
        program: "G17 G90 G94\n\
                  G0 X1 Y1 Z250\n\
                  G0 X2 Y2 Z240\n\
                  N10 G0 Z170.000\n\
                  N20 G0 X121.920 Y337.969\n\
                  N30 G0 X121.908 Y337.969\n\
                  N40 G0 Z122.000\n\
                  N50 G1 Z117.628 F500.\n\
                  N60 G1 Z115.546\n\
                  N70 G1 X338.968 Y337.964\n\
                  G0 Z250\n\
                  M30\n",
    },
    Worn {
        shapes: &[
            ("EYX", [6.024188e-5, -9.404786e-8, 0.0]),
            ("EZX", [1.713947e-4, -1.567206e-6, 2.636287e-9]),
            ("EXY", [4.876572e-5, -2.126279e-7, 0.0]),
            ("EYY", [-2.002474e-4, 1.727375e-6, -2.849735e-9]),
            ("EZY", [-1.166732e-4, 2.313758e-7, 0.0]),
            ("EXZ", [1.432253e-4, -2.771027e-7, 0.0]),
            ("EYZ", [-2.334708e-4, 1.345764e-6, -1.837645e-9]),
            ("EZZ", [-5.722088e-5, 0.0, 0.0]),
        ],
        reversals: &[("EXX", -10.33), ("EYY", -11.7), ("EZY", -6.85), ("EZZ", -6.45)],
        program: "G17 G90 G94\n\
                  G0 X1 Y1 Z250\n\
                  G0 X2 Y2 Z240\n\
                  N10 G0 Z170.000\n\
                  N20 G0 X136.996 Y104.391\n\
                  N30 G0 X411.521 Y143.806\n\
                  N40 G0 Z122.000\n\
                  N50 G1 Z112.207 F500.\n\
                  N60 G1 X49.615 Y352.590\n\
                  N70 G1 X294.909 Y352.590\n\
                  G0 Z250\n\
                  M30\n",
    },
    Worn {
        shapes: &[
            ("EXX", [9.909590e-5, -6.287667e-7, 9.078968e-10]),
            ("EYX", [-2.939346e-4, 1.841039e-6, -2.639668e-9]),
            ("EZX", [-3.425151e-5, 5.354094e-8, 0.0]),
            ("EXY", [1.486651e-4, -1.260239e-6, 2.066381e-9]),
            ("EYY", [6.277545e-5, -1.000500e-7, 0.0]),
            ("EZZ", [-1.614951e-4, 1.037845e-6, -1.508817e-9]),
        ],
        reversals: &[("EXX", -25.46), ("EYY", -9.19), ("EZZ", -7.08)],
        program: "G17 G90 G94\n\
                  G0 X1 Y1 Z250\n\
                  G0 X2 Y2 Z240\n\
                  N10 G0 Z170.000\n\
                  N20 G0 X97.428 Y305.240\n\
                  N30 G0 X97.418 Y305.240\n\
                  N40 G0 Z122.000\n\
                  N50 G1 Z118.120 F500.\n\
                  N60 G1 X97.430 Y407.402\n\
                  N70 G1 X97.430 Y69.413\n\
                  G0 Z250\n\
                  M30\n",
    },
];

/// The displaced axis of an error, and the axis that moves.
fn axes_of(error: &str) -> [usize; 2] {
    [1, 2].map(|letter| "XYZ".find(&error[letter..=letter]).unwrap())
}

impl Worn {
    fn toml(&self) -> String {
        let mut text = String::from(
            "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n[control]\nincrement_mm = 0.001\n\
             [[tool]]\nnumber = 1\nlength_mm = 50\nradius_mm = 5\n",
        );
        for (k, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
            let direction = [0, 1, 2].map(|other| i32::from(other == k));
            let _ = writeln!(text, "[axis.{axis}]\ndirection = {direction:?}\ntravel_mm = [-900, 900]");
        }
        for (error, [first, second, third]) in self.shapes {
            let _ = writeln!(
                text,
                "[[motion]]\ncomponent = \"{error}\"\nkind = \"polynomial\"\ncoefficients = [0.0, {first:e}, {second:e}, {third:e}]"
            );
        }
        for (error, value_um) in self.reversals {
            let _ = writeln!(text, "[[motion]]\ncomponent = \"{error}\"\nkind = \"backlash\"\nvalue_um = {value_um}");
        }
        text
    }

    /// Way of the command of an axis after a reversal until its body follows, mm.
    fn lost_mm(&self, axis: usize) -> f64 {
        let along = self.reversals.iter().filter(|(error, _)| axes_of(error) == [axis; 2]);
        along.map(|(_, value_um)| -1e-3 * value_um).sum()
    }
}

/// A line with a motion.
struct Line {
    rapid: bool,
    from: Place,
    to: Place,
    continues: bool,
    on_the_spot: bool,
}

fn lines(text: &str) -> Vec<Line> {
    let (mut at, mut rapid, mut found) = ([0.0; 3], true, Vec::new());
    for line in text.lines() {
        let (words, mark) = line.split_once(';').unwrap_or((line, ""));
        let mut to: Place = at;
        let mut moves = false;
        for word in words.split_whitespace() {
            match word {
                "G0" => rapid = true,
                "G1" => rapid = false,
                _ => {}
            }
            for (k, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
                if let Some(value) = word.strip_prefix(letter).and_then(|value| value.parse().ok()) {
                    (to[k], moves) = (value, true);
                }
            }
        }
        if moves {
            let (continues, on_the_spot) = (mark.starts_with('+'), mark.ends_with('~'));
            found.push(Line { rapid, from: at, to, continues, on_the_spot });
            at = to;
        }
    }
    found
}

fn dot(a: &Place, b: &Place) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// The bodies of a machine: how far each is behind its command, mm, and on which side of its play, −1 to 1.
#[derive(Default)]
struct Bodies {
    lag_mm: Place,
    sides: Place,
}

impl Bodies {
    /// The tip after the commands go from one place straight to another near to it.
    fn follow(&mut self, worn: &Worn, last: &Place, command: &Place) -> Place {
        for k in 0..3 {
            let (half_mm, step) = (0.5 * worn.lost_mm(k), command[k] - last[k]);
            self.lag_mm[k] = (self.lag_mm[k] + step).clamp(-half_mm, half_mm);
            if half_mm > 0.0 {
                self.sides[k] = self.lag_mm[k] / half_mm;
            } else if step != 0.0 {
                self.sides[k] = step.signum();
            }
        }
        let mut tip = [0, 1, 2].map(|k| command[k] - self.lag_mm[k]);
        for (error, powers) in worn.shapes {
            let [of, by] = axes_of(error);
            let at = command[by];
            tip[of] += powers[0] * at + powers[1] * at * at + powers[2] * at * at * at;
        }
        for (error, value_um) in worn.reversals {
            let [of, by] = axes_of(error);
            if of != by {
                tip[of] += 0.5e-3 * value_um * self.sides[by];
            }
        }
        tip
    }

    /// `true` if a body is between its sides: the tool then lags on its way.
    fn is_between(&self, worn: &Worn) -> bool {
        (0..3).any(|k| worn.lost_mm(k) > 0.0 && self.sides[k].abs() < 1.0 - 1e-6)
    }
}

/// The largest distance of the tip from its place on the cuts of a program, mm. Between the ends of a piece its place on the move goes in proportion.
fn worst_mm(worn: &Worn, nominal: &[Line], written: &[Line]) -> f64 {
    let (mut bodies, mut of, mut from, mut worst) = (Bodies::default(), 0, 0.0, 0.0_f64);
    for (index, line) in written.iter().enumerate() {
        if !line.continues {
            (of, from) = (of + 1, 0.0);
        }
        let meant = &nominal[of - 1];
        let way = [0, 1, 2].map(|k| meant.to[k] - meant.from[k]);
        let mut last = line.from;
        let tips: Vec<(Place, bool)> = (0..=PLACES)
            .map(|place| {
                let share = f64::from(place) / f64::from(PLACES);
                let command = [0, 1, 2].map(|k| line.from[k] + (line.to[k] - line.from[k]) * share);
                let tip = bodies.follow(worn, &last, &command);
                last = command;
                (tip, bodies.is_between(worn))
            })
            .collect();
        if meant.rapid || line.on_the_spot {
            continue;
        }
        let off = |tip: &Place, share: f64| [0, 1, 2].map(|k| tip[k] - meant.from[k] - way[k] * share);
        let is_last = written.get(index + 1).is_none_or(|next| !next.continues);
        let end = tips[PLACES as usize].0;
        let to = if is_last { 1.0 } else { (dot(&off(&end, 0.0), &way) / dot(&way, &way)).clamp(from, 1.0) };
        for (place, (tip, is_between)) in tips.iter().enumerate() {
            let share = from + (to - from) * place as f64 / f64::from(PLACES);
            let mut off = off(tip, share);
            if *is_between && share < 1.0 {
                let along = dot(&off, &way) / dot(&way, &way);
                off = [0, 1, 2].map(|k| off[k] - along * way[k]);
            }
            worst = worst.max(dot(&off, &off).sqrt());
        }
        from = to;
    }
    assert_eq!(of, nominal.len());
    worst
}

#[test]
fn a_correction_that_turns_an_axis_back_keeps_the_tolerance() {
    for (k, worn) in MACHINES.iter().enumerate() {
        let program = worn.program;
        let shop = Shop::new().file("m.toml", worn.toml()).file("p.mpf", program);
        let run = shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
        assert!(!run.stderr.contains("W0305"), "machine {k}: {run:?}");
        let text = shop.text("out.mpf");
        shop.run(["verify", "p.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
        let (nominal, written) = (lines(program), lines(&text));
        let (before, after) = (worst_mm(worn, &nominal, &nominal), worst_mm(worn, &nominal, &written));
        assert!(before > 20e-3 && after <= LIMIT_MM, "machine {k}: {before} and {after}\n{text}");
    }
}
