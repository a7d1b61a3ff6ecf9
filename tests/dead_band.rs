//! Backlash as a machine has it: bodies that follow their commands through real dead bands, from whichever side they lie on at first. What the
//! correction and the comparison say of a program must hold for the worst of these sides.
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options as ExecOptions};
use ncfix_language::syntax;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::Element;
use ncfix_model::{ErrorModel, Model};
use ncfix_path::emit::{self, Stamp, WriterOptions};
use ncfix_path::path::{CorrectionOptions, Corrector, Grouping, Increments, compare};

use crate::bench_machine::Random;

/// Programs of a run.
const SEEDS: u64 = 240;
/// The finest word, mm.
const INCREMENT_MM: f64 = 1e-4;
/// What is found between the places that are looked at may be larger by this, mm: less than an increment.
const BETWEEN_MM: f64 = 1e-4;
/// The error before is that of samples a millimeter or two apart, none at the ends: it is looked at in the middle of longer ways, where it changes
/// by less than this from one to the next, mm.
const BEFORE_MM: f64 = 5e-4;
const LONG_MM: f64 = 10.0;
/// Steps of a piece.
const STEPS: u32 = 40;

type Place = [f64; 3];

/// A machine of three axes on the tool side: the tip is where their bodies are, and what their errors add.
struct Bench {
    /// How far each command must go behind a reversal until the body follows, mm.
    lost_mm: Place,
    /// What X, Y and Z are off by per mm of X and of Y, and per square millimeter of either.
    slopes: [[f64; 2]; 3],
    bends: [[f64; 2]; 3],
}

impl Bench {
    fn random(random: &mut Random) -> Bench {
        let lost_mm = [(); 3].map(|()| match random.chance() {
            true => (random.between(1.0, 25.0) * 10.0).round() * 1e-4,
            false if random.chance() => 0.0,
            false => 0.012,
        });
        let is_straight = random.chance();
        let mut of_size =
            |size: f64| [(); 3].map(|()| [(); 2].map(|()| if is_straight { 0.0 } else { random.between(-size, size) }));
        Bench { lost_mm, slopes: of_size(5e-5), bends: of_size(2e-7) }
    }

    fn toml(&self) -> String {
        let mut text = String::from(
            "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n[control]\nincrement_mm = 0.0001\n\
             [[tool]]\nnumber = 1\nlength_mm = 50\nradius_mm = 5\n",
        );
        for (k, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
            let direction = [0, 1, 2].map(|other| i32::from(other == k));
            text += &format!("[axis.{axis}]\ndirection = {direction:?}\ntravel_mm = [-900, 900]\n");
            for (of, by) in ["X", "Y"].into_iter().enumerate() {
                text += &format!(
                    "[[motion]]\ncomponent = \"E{axis}{by}\"\nkind = \"polynomial\"\ncoefficients = [0.0, {:e}, {:e}]\n",
                    self.slopes[k][of], self.bends[k][of]
                );
            }
            if self.lost_mm[k] > 0.0 {
                let value_um = -1e3 * self.lost_mm[k];
                text +=
                    &format!("[[motion]]\ncomponent = \"E{axis}{axis}\"\nkind = \"backlash\"\nvalue_um = {value_um}\n");
            }
        }
        text
    }

    fn tip(&self, command: &Place, lag: &Place) -> Place {
        let [x, y, _] = *command;
        let add = |k: usize| {
            self.slopes[k][0] * x + self.slopes[k][1] * y + self.bends[k][0] * x * x + self.bends[k][1] * y * y
        };
        [0, 1, 2].map(|k| command[k] - lag[k] + add(k))
    }
}

/// A line with a motion.
#[derive(Clone, Debug)]
struct Line {
    text: String,
    rapid: bool,
    from: Place,
    to: Place,
    /// Axes that it names.
    named: [bool; 3],
    /// Center and signed sweep, rad.
    circle: Option<([f64; 2], f64)>,
    /// It goes on with the motion of the line above.
    continues: bool,
    /// A step on the spot.
    on_the_spot: bool,
    /// Nobody knows where the axes have been before it.
    is_lost: bool,
}

impl Line {
    fn at(&self, share: f64) -> Place {
        let mut place = [0, 1, 2].map(|k| self.from[k] + (self.to[k] - self.from[k]) * share);
        if let Some((center, sweep)) = self.circle
            && share < 1.0
        {
            let radius = |p: &Place| (p[0] - center[0]).hypot(p[1] - center[1]);
            let angle = (self.from[1] - center[1]).atan2(self.from[0] - center[0]) + sweep * share;
            let reach = radius(&self.from) + (radius(&self.to) - radius(&self.from)) * share;
            place[0] = center[0] + reach * angle.cos();
            place[1] = center[1] + reach * angle.sin();
        }
        place
    }

    fn length_mm(&self) -> f64 {
        let radius = |center: [f64; 2]| (self.from[0] - center[0]).hypot(self.from[1] - center[1]);
        self.circle.map_or(0.0, |(center, sweep)| sweep.abs() * radius(center)).max(distance_mm(&self.from, &self.to))
    }

    /// The distance of a point from the way, mm.
    fn distance_mm(&self, point: &Place) -> f64 {
        let Some((center, sweep)) = self.circle else {
            let way = [0, 1, 2].map(|k| self.to[k] - self.from[k]);
            let square: f64 = way.iter().map(|w| w * w).sum();
            let along: f64 = (0..3).map(|k| (point[k] - self.from[k]) * way[k]).sum();
            let share = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
            return distance_mm(point, &self.at(share));
        };
        let start = (self.from[1] - center[1]).atan2(self.from[0] - center[0]);
        let turned = (point[1] - center[1]).atan2(point[0] - center[0]) - start;
        let share = (turned * sweep.signum()).rem_euclid(std::f64::consts::TAU) / sweep.abs();
        [share.min(1.0), 0.0, 1.0]
            .map(|share| distance_mm(point, &self.at(share)))
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    }
}

fn distance_mm(a: &Place, b: &Place) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// The motions of a program in the plane XY with absolute words.
fn lines(text: &str) -> Vec<Line> {
    let (mut at, mut code, mut is_lost) = ([0.0; 3], 0, true);
    let mut found: Vec<Line> = Vec::new();
    for line in text.lines() {
        let (words, mark) = line.split_once(';').unwrap_or((line, ""));
        let words: Vec<&str> = words.split_whitespace().collect();
        is_lost |= words.contains(&"M6");
        let number = |letter: char| words.iter().find_map(|word| word.strip_prefix(letter)?.parse::<f64>().ok());
        for word in &words {
            if let Some(motion) =
                word.strip_prefix('G').and_then(|value| value.parse::<u8>().ok()).filter(|&value| value < 4)
            {
                code = motion;
            }
        }
        let to = ['X', 'Y', 'Z'].map(number);
        if to.iter().all(Option::is_none) && number('I').or(number('J')).is_none() {
            continue;
        }
        let named = to.map(|word| word.is_some());
        let to = [0, 1, 2].map(|k| to[k].unwrap_or(at[k]));
        let circle = (code > 1).then(|| {
            let center = [at[0] + number('I').unwrap_or(0.0), at[1] + number('J').unwrap_or(0.0)];
            let angle = |p: &Place| (p[1] - center[1]).atan2(p[0] - center[0]);
            let sign = if code == 3 { 1.0 } else { -1.0 };
            let swept = (sign * (angle(&to) - angle(&at))).rem_euclid(std::f64::consts::TAU);
            (center, sign * if swept < 1e-9 { std::f64::consts::TAU } else { swept })
        });
        found.push(Line {
            text: line.to_owned(),
            rapid: code == 0,
            from: at,
            to,
            named,
            circle,
            continues: mark.starts_with('+'),
            on_the_spot: mark.ends_with('~'),
            is_lost: std::mem::take(&mut is_lost),
        });
        at = to;
    }
    found
}

/// What is cut along the program: the largest distance of the tip from its place, mm, and the line where that is. Bodies of which nobody knows where
/// they lie are on these sides, −1 to 1.
fn worst_mm(bench: &Bench, [nominal, driven]: [&[Line]; 2], sides: &Place, in_the_middle: bool) -> (f64, String) {
    let half = |k: usize| 0.5 * bench.lost_mm[k];
    let mut lag = [0.0; 3];
    let mut known = [false; 3];
    let mut worst = (0.0, String::new());
    let mut of = 0_usize;
    for (index, line) in driven.iter().enumerate() {
        of += usize::from(!line.continues);
        let meant = &nominal[of - 1];
        if line.is_lost {
            known = [false; 3];
        }
        let mut last = line.from;
        let from_anywhere = [0, 1, 2].map(|k| line.named[k] && !known[k]);
        let mut judge = |away_mm: f64| {
            if away_mm > worst.0 {
                worst = (away_mm, line.text.clone());
            }
        };
        for step in 0..=STEPS {
            let command = line.at(f64::from(step) / f64::from(STEPS));
            for k in 0..3 {
                lag[k] = if from_anywhere[k] || !known[k] {
                    sides[k] * half(k)
                } else {
                    (lag[k] + command[k] - last[k]).clamp(-half(k), half(k))
                };
            }
            last = command;
            let is_middle = (STEPS / 4..=STEPS - STEPS / 4).contains(&step) && line.length_mm() > LONG_MM;
            if !meant.rapid && !line.on_the_spot && (is_middle || !in_the_middle) {
                judge(meant.distance_mm(&bench.tip(&command, &lag)));
            }
        }
        if !meant.rapid && !in_the_middle && driven.get(index + 1).is_none_or(|next| !next.continues) {
            judge(distance_mm(&bench.tip(&line.to, &lag), &meant.to));
        }
        known = [0, 1, 2].map(|k| known[k] || line.named[k]);
    }
    assert_eq!(of, nominal.len());
    worst
}

/// The worst of all sides.
fn worst_of_all_mm(bench: &Bench, ways: [&[Line]; 2], in_the_middle: bool) -> (f64, String) {
    let sides = |bits: i32| [0, 1, 2].map(|k| f64::from(((bits >> k) & 1) * 2 - 1));
    let all = (0..8).map(|bits| worst_mm(bench, ways, &sides(bits), in_the_middle));
    all.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

fn random_program(random: &mut Random) -> String {
    let grid = |value: f64| (value * 1e3).round() / 1e3;
    let mut text = String::from("G17 G90 G94\n");
    let mut number = 10;
    let mut line = |text: &mut String, words: &str| {
        *text += &format!("N{number} {words}\n");
        number += 10;
    };
    let operations = if random.chance() { 1 } else { 2 };
    for _ in 0..operations {
        if random.chance() {
            line(&mut text, "T1 M6");
        }
        let mut at = [(); 2].map(|()| grid(random.between(-300.0, 300.0)));
        let approaches = [[true, true], [true, false], [false, true], [false, false]];
        match approaches[(random.between(0.0, 4.0) as usize).min(3)] {
            [true, true] => line(&mut text, &format!("G0 X{} Y{} Z20", at[0], at[1])),
            [true, false] => {
                line(&mut text, &format!("G0 X{} Y{}", at[0], at[1]));
                line(&mut text, "G0 Z20");
            }
            [false, true] => {
                line(&mut text, "G0 Z50");
                line(&mut text, &format!("G0 X{} Y{}", at[0], at[1]));
                line(&mut text, "G0 Z2");
            }
            [false, false] => line(&mut text, &format!("G0 X{} Y{} Z-3", at[0], at[1])),
        }
        if random.chance() {
            at[0] = grid(at[0] + random.between(-0.015, 0.015));
            line(&mut text, &format!("G0 X{}", at[0]));
        }
        line(&mut text, "G1 Z-5 F500");
        for _ in 0..(random.between(1.0, 7.0) as u32) {
            match random.between(0.0, 6.0) as u32 {
                0 => {
                    at = [(); 2].map(|()| grid(random.between(-300.0, 300.0)));
                    line(&mut text, &format!("G1 X{} Y{}", at[0], at[1]));
                }
                1 => {
                    at[0] = grid(random.between(-300.0, 300.0));
                    line(&mut text, &format!("G1 X{}", at[0]));
                }
                2 => {
                    at[1] = grid(at[1] + random.between(-30.0, 30.0));
                    line(&mut text, &format!("G1 Y{} Z{}", at[1], grid(random.between(-9.0, -1.0))));
                }
                3 => {
                    // Within the dead band, or little more.
                    at = at.map(|place| grid(place + random.between(-0.03, 0.03)));
                    line(&mut text, &format!("G1 X{} Y{}", at[0], at[1]));
                }
                4 => {
                    let center = [(); 2].map(|()| grid(random.between(-40.0, 40.0)));
                    let code = if random.chance() { 2 } else { 3 };
                    if random.chance() {
                        at = [0, 1].map(|k| grid(at[k] + 2.0 * center[k]));
                    }
                    line(&mut text, &format!("G{code} X{} Y{} I{} J{}", at[0], at[1], center[0], center[1]));
                }
                _ => {
                    line(&mut text, "G0 Z20");
                    at = [(); 2].map(|()| grid(random.between(-300.0, 300.0)));
                    line(&mut text, &format!("G0 X{} Y{}", at[0], at[1]));
                    line(&mut text, "G1 Z-4");
                }
            }
        }
        line(&mut text, "G0 Z50");
    }
    text + "M30\n"
}

fn executed(text: &str, machine: &Machine) -> Vec<Element> {
    let source = Source::new(FileId(0), "p.mpf", text.as_bytes().to_vec()).unwrap();
    let (program, _) = syntax::parse(&source, ncfix_dialect::find("sinumerik").unwrap());
    Execution::new(program, machine, Box::new(NoLibrary), ExecOptions::default()).map(Result::unwrap).collect()
}

/// What is said of a program.
struct Said {
    text: String,
    /// Largest error before and after it, mm: of the correction, and of the comparison.
    fix_mm: [f64; 2],
    verify_mm: [f64; 2],
    codes: Vec<String>,
}

fn corrected(program: &str, machine: &Machine, errors: &ErrorModel) -> Said {
    let model = Model::new(machine, errors);
    let options = CorrectionOptions::default();
    let mut corrector = Corrector::new(executed(program, machine).into_iter().map(Ok), machine, &model, options);
    let writer_options = WriterOptions {
        names: machine.written_names(),
        increments: Increments::new(&machine.control),
        frame: CorrectionOptions::default().frame,
        crlf: false,
        stamp: Stamp::default(),
        last_block_number: None,
        has_centers_reversed: false,
    };
    let mut writer = emit::writer("sinumerik", &writer_options).unwrap();
    let (mut out, mut codes) = (Vec::new(), Vec::new());
    emit::emit(&mut corrector, writer.as_mut(), &mut out, |finding| codes.push(finding.code.to_string())).unwrap();
    let text = String::from_utf8(out).unwrap();
    let prediction = corrector.prediction().clone();
    let [before, after] = [program, &text].map(|text| executed(text, machine));
    let verified = compare(before.into_iter(), after.into_iter(), Grouping::ByMarks, machine, &model).unwrap();
    Said {
        text,
        fix_mm: [prediction.before().max_mm, prediction.after().max_mm],
        verify_mm: [verified.before.max_mm, verified.after.max_mm],
        codes,
    }
}

#[test]
fn the_error_after_holds_from_whichever_side_the_axes_come() {
    let mut unknown = 0;
    for seed in 0..SEEDS {
        let mut random = Random(0xdead + seed);
        let bench = Bench::random(&mut random);
        let program = random_program(&mut random);
        let source = Source::new(FileId(0), "m.toml", bench.toml().into_bytes()).unwrap();
        let (machine, errors) = ncfix_model::file::load(&source).0.unwrap();
        let said = corrected(&program, &machine, &errors);
        let (nominal, driven) = (lines(&program), lines(&said.text));
        let context = || format!("seed {seed}\n{}\n{program}\n{}\n{:?}", bench.toml(), said.text, said.codes);
        let after = worst_of_all_mm(&bench, [&nominal, &driven], false);
        let before = worst_of_all_mm(&bench, [&nominal, &nominal], true);
        for (who, [said_before_mm, said_after_mm]) in [("fix", said.fix_mm), ("verify", said.verify_mm)] {
            let told = format!("{who} says {said_before_mm} and {said_after_mm}");
            assert!(after.0 <= said_after_mm + BETWEEN_MM, "{told}, but {after:?}\n{}", context());
            assert!(before.0 <= said_before_mm + BEFORE_MM, "{told}, but {before:?} before\n{}", context());
        }
        let is_unknown = said.codes.iter().any(|code| code == "W0308");
        unknown += u64::from(is_unknown);
        if said.codes.is_empty() {
            // Nothing is left that would have to be said.
            let limit_mm = CorrectionOptions::default().tolerance_mm + INCREMENT_MM;
            assert!(after.0 <= limit_mm, "{after:?}\n{}", context());
        }
    }
    // Both kinds are among them.
    assert!((SEEDS / 20..SEEDS - SEEDS / 20).contains(&unknown), "{unknown}");
}
