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

/// A machine of three axes on the tool side. Index 0, 1 and 2 are X, Y and Z.
struct Worn {
    /// How far each command must go behind a reversal until the body follows, µm.
    lost_um: Place,
    /// Deviation of each axis along X and along Y: 10 µm/m, and 10⁻⁷ mm for each square millimeter.
    slopes: [[f64; 2]; 3],
    bends: [[f64; 2]; 3],
    /// Play across an axis: the axis that is displaced, the axis that moves, and the displacement between its sides, µm.
    play: &'static [(usize, usize, f64)],
    /// Where the cut begins, and what Y moves during the way along X, mm.
    at: Place,
}

/// On each of them an axis turned back within its lost motion on a piece: the tip was off by 1.30 to 1.71 µm there, by the same arithmetic.
const MACHINES: [Worn; 8] = [
    Worn {
        lost_um: [0.0, 6.0, 10.0],
        slopes: [[0.0, 8.0], [5.0, 5.0], [3.0, -5.0]],
        bends: [[3.0, -1.0], [1.0, -3.0], [-2.0, 3.0]],
        play: &[(0, 1, 5.0), (0, 2, 12.0)],
        at: [-60.0, 0.0, 0.0],
    },
    Worn {
        lost_um: [0.0, 5.0, 11.0],
        slopes: [[8.0, -6.0], [6.0, -6.0], [-1.0, 6.0]],
        bends: [[-2.0, 1.0], [-3.0, 3.0], [0.0, -4.0]],
        play: &[(0, 1, 13.0), (0, 2, 14.0)],
        at: [-100.0, 37.0, 0.0],
    },
    Worn {
        lost_um: [0.0, 7.0, 6.0],
        slopes: [[-2.0, -5.0], [-1.0, -6.0], [0.0, 1.0]],
        bends: [[-1.0, 2.0], [-4.0, 4.0], [-1.0, -3.0]],
        play: &[(2, 1, 8.0), (0, 2, 10.0)],
        at: [-150.0, -81.0, -0.006],
    },
    Worn {
        lost_um: [0.0, 5.0, 5.0],
        slopes: [[-1.0, -6.0], [6.0, -7.0], [1.0, -3.0]],
        bends: [[3.0, -3.0], [-1.0, -1.0], [-2.0, -4.0]],
        play: &[(2, 1, -13.0), (0, 2, -7.0)],
        at: [-100.0, 0.0, 0.005],
    },
    Worn {
        lost_um: [0.0, 6.0, 11.0],
        slopes: [[4.0, -7.0], [1.0, 6.0], [-2.0, -7.0]],
        bends: [[4.0, -1.0], [2.0, 2.0], [-1.0, 4.0]],
        play: &[(2, 1, -13.0), (0, 2, 14.0)],
        at: [-100.0, -81.0, 0.005],
    },
    Worn {
        lost_um: [0.0, 8.0, 7.0],
        slopes: [[6.0, 4.0], [7.0, -1.0], [-1.0, 7.0]],
        bends: [[1.0, 2.0], [-4.0, 3.0], [1.0, -3.0]],
        play: &[(2, 1, -14.0), (0, 2, -9.0)],
        at: [-60.0, 37.0, -0.003],
    },
    Worn {
        lost_um: [0.0, 9.0, 7.0],
        slopes: [[7.0, -2.0], [-3.0, 5.0], [-4.0, 2.0]],
        bends: [[0.0, 3.0], [-3.0, -2.0], [2.0, -4.0]],
        play: &[(0, 1, -10.0)],
        at: [-150.0, 0.0, 0.002],
    },
    Worn {
        lost_um: [0.0, 8.0, 9.0],
        slopes: [[-4.0, 3.0], [-8.0, 3.0], [-2.0, -4.0]],
        bends: [[1.0, 2.0], [-1.0, 0.0], [2.0, 2.0]],
        play: &[(2, 1, -14.0), (0, 2, 13.0)],
        at: [-60.0, 37.0, -0.003],
    },
];

impl Worn {
    fn toml(&self) -> String {
        let names = ["X", "Y", "Z"];
        let mut text = String::from(
            "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n[control]\nincrement_mm = 0.001\n\
             [[tool]]\nnumber = 1\nlength_mm = 50\nradius_mm = 5\n",
        );
        for (k, axis) in names.into_iter().enumerate() {
            let direction = [0, 1, 2].map(|other| i32::from(other == k));
            let _ = writeln!(text, "[axis.{axis}]\ndirection = {direction:?}\ntravel_mm = [-900, 900]");
            for (of, by) in ["X", "Y"].into_iter().enumerate() {
                let (slope, bend) = (self.slopes[k][of] * 1e-5, self.bends[k][of] * 1e-7);
                let _ = writeln!(
                    text,
                    "[[motion]]\ncomponent = \"E{axis}{by}\"\nkind = \"polynomial\"\ncoefficients = [0.0, {slope:e}, {bend:e}]"
                );
            }
            if self.lost_um[k] > 0.0 {
                let value_um = -self.lost_um[k];
                let _ = writeln!(
                    text,
                    "[[motion]]\ncomponent = \"E{axis}{axis}\"\nkind = \"backlash\"\nvalue_um = {value_um:.1}"
                );
            }
        }
        for &(of, by, value_um) in self.play {
            let _ = writeln!(
                text,
                "[[motion]]\ncomponent = \"E{}{}\"\nkind = \"backlash\"\nvalue_um = {value_um:.1}",
                names[of], names[by]
            );
        }
        text
    }

    /// Rapid moves lead all bodies first. Then come a way along X on which Y hardly moves, one along Y, and the way back.
    fn program(&self) -> String {
        let [x, y, step] = self.at;
        format!(
            "G17 G90 G94\nN10 G0 X{} Y{} Z90\nN20 G0 X{} Y{} Z60\nN30 G0 X{x} Y{y} Z20\nN40 G1 Z-2 F500\nN50 G1 Y{} Z-5\n\
             N60 G1 X{} Y{:.3}\nN70 G1 Y{}\nN80 G1 X{x}\nN90 G0 Z50\nM30\n",
            x - 9.0,
            y - 9.0,
            x - 5.0,
            y - 5.0,
            y + 5.0,
            x + 230.0,
            y + 5.0 + step,
            y + 120.0
        )
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
            let (half_mm, step) = (0.5e-3 * worn.lost_um[k], command[k] - last[k]);
            self.lag_mm[k] = (self.lag_mm[k] + step).clamp(-half_mm, half_mm);
            if half_mm > 0.0 {
                self.sides[k] = self.lag_mm[k] / half_mm;
            } else if step != 0.0 {
                self.sides[k] = step.signum();
            }
        }
        let [x, y, _] = *command;
        let mut tip = [0, 1, 2].map(|k| {
            let straight = 1e-5 * (worn.slopes[k][0] * x + worn.slopes[k][1] * y);
            command[k] - self.lag_mm[k] + straight + 1e-7 * (worn.bends[k][0] * x * x + worn.bends[k][1] * y * y)
        });
        for &(of, by, value_um) in worn.play {
            tip[of] += 0.5e-3 * value_um * self.sides[by];
        }
        tip
    }

    /// `true` if a body is between its sides: the tool then lags on its way.
    fn is_between(&self, worn: &Worn) -> bool {
        (0..3).any(|k| worn.lost_um[k] > 0.0 && self.sides[k].abs() < 1.0 - 1e-6)
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
        let program = worn.program();
        let shop = Shop::new().file("m.toml", worn.toml()).file("p.mpf", &program);
        let run = shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
        assert!(!run.stderr.contains("W0305"), "machine {k}: {run:?}");
        let text = shop.text("out.mpf");
        shop.run(["verify", "p.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
        let (nominal, written) = (lines(&program), lines(&text));
        let (before, after) = (worst_mm(worn, &nominal, &nominal), worst_mm(worn, &nominal, &written));
        assert!(before > 5e-3 && after <= LIMIT_MM, "machine {k}: {before} and {after}\n{text}");
    }
}
