//! Play of an axis that shows across it: what `fix` writes, `verify` accepts, or `fix` has named the line.

use std::fmt::Write as _;

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options as ExecOptions};
use ncfix_language::syntax;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::Element;
use ncfix_model::Model;
use ncfix_path::emit::{self, Stamp, WriterOptions};
use ncfix_path::path::{CorrectionOptions, Corrector, Feeds, Grouping, How, Increments, Promise, compare_seeing};

use crate::bench_machine::Random;
use crate::support::Shop;

/// Programs of a run, of the four languages in turn.
const SEEDS: u64 = 200;
const LANGUAGES: [&str; 4] = ["sinumerik", "fanuc", "rs274", "grundig"];

/// A machine of three axes on the tool side without errors.
fn plain(controller: &str, increment_mm: &str) -> String {
    let mut text = format!(
        "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"{controller}\"\n[control]\nincrement_mm = {increment_mm}\n\
         arc_tolerance_mm = 0.01\narc_tolerance_ratio = 0.001\n[[tool]]\nnumber = 1\nlength_mm = 50\nradius_mm = 5\n\
         [zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nset = \"absolute\"\n"
    );
    for (k, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
        let direction = [0, 1, 2].map(|other| i32::from(other == k));
        let _ = writeln!(text, "[axis.{axis}]\ndirection = {direction:?}\ntravel_mm = [-900, 900]");
    }
    text
}

fn play(text: &mut String, component: &str, value_um: f64) {
    let _ = writeln!(text, "[[motion]]\ncomponent = \"{component}\"\nkind = \"backlash\"\nvalue_um = {value_um:.2}");
}

/// Polynomials, lost motion of some axes, and play across most of them.
fn worn(random: &mut Random, controller: &str) -> String {
    let mut text = plain(controller, if random.chance() { "0.001" } else { "0.0001" });
    for by in ["X", "Y", "Z"] {
        for of in ["X", "Y", "Z"] {
            let (slope, bend) = (random.between(-6e-5, 6e-5), random.between(-2e-7, 2e-7));
            let component = format!("E{of}{by}");
            let _ = writeln!(
                text,
                "[[motion]]\ncomponent = \"{component}\"\nkind = \"polynomial\"\ncoefficients = [0.0, {slope:e}, {bend:e}]"
            );
            // Lost motion has one sign, play across the axis either.
            if random.chance() {
                let value_um = if of == by { random.between(-25.0, -2.0) } else { random.between(-12.0, 12.0) };
                play(&mut text, &component, value_um);
            }
        }
    }
    text
}

/// A program in the words of its language.
struct Written {
    text: String,
    number: u32,
    at: [f64; 2],
}

impl Written {
    fn line(&mut self, words: &str) {
        let _ = writeln!(self.text, "N{} {words}", self.number);
        self.number += 10;
    }

    fn go(&mut self, code: &str, at: [f64; 2]) {
        self.at = at.map(|place| (place * 1e3).round() / 1e3);
        let [x, y] = self.at;
        self.line(&format!("{code} X{x:.3} Y{y:.3}"));
    }
}

fn anywhere(random: &mut Random) -> [f64; 2] {
    [(); 2].map(|()| random.between(-300.0, 300.0))
}

fn holes(program: &mut Written, random: &mut Random, language: &str) {
    let places: Vec<[f64; 2]> = (0..3).map(|_| anywhere(random)).collect();
    let depth_mm = random.between(4.0, 30.0);
    match language {
        "sinumerik" => {
            program.line("F200");
            program.line(&format!("MCALL CYCLE81(20,0,2,{:.3})", -depth_mm));
            places.into_iter().for_each(|place| program.go("", place));
            program.line("MCALL");
        }
        "grundig" => {
            program.line(&format!("G81 Y2 Z{:.3} B18 F200", -depth_mm));
            for [x, y] in places {
                program.line(&format!("G79 X{x:.3} Y{y:.3} Z0"));
                program.at = [x, y];
            }
        }
        _ => {
            let code = if random.chance() { "G98" } else { "G99" };
            for (k, [x, y]) in places.into_iter().enumerate() {
                let call = format!("{code} G81 X{x:.3} Y{y:.3} Z{:.3} R2.0 F200.", -depth_mm);
                program.line(&if k == 0 { call } else { format!("X{x:.3} Y{y:.3}") });
                program.at = [x, y];
            }
            program.line("G80");
        }
    }
    program.line("G0 Z50.0");
}

fn random_program(random: &mut Random, language: &str) -> String {
    let head = match language {
        "sinumerik" => "G17 G90 G71 G94 G54\nT1\nM6\nD1\n",
        "fanuc" => "%\nO1000\nG21 G17 G90 G40 G49 G80 G94\nT1 M6\nG54 G90\n",
        "rs274" => "G21 G90 G17 G94 G54\nT1 M6\nG43 H1\n",
        _ => "%PM1000\nN1000 (M)\nN1 G17 G71 G90\nN2 G54\nN3 T1 M6\n",
    };
    let mut program = Written { text: head.to_owned(), number: 10, at: [0.0; 2] };
    match language {
        "fanuc" => {
            program.go("G0 S1000 M3", anywhere(random));
            program.line("G43 Z50. H1");
        }
        _ => {
            program.line("G0 Z50.0 S1000 M3");
            program.go("G0", anywhere(random));
        }
    }
    for _ in 0..2 {
        if random.chance() {
            holes(&mut program, random, language);
        }
        let near = [program.at[0] + random.between(-0.02, 0.02), program.at[1]];
        if random.chance() {
            program.at = near;
            program.line(&format!("G0 X{:.3}", near[0]));
        } else {
            program.go("G0", anywhere(random));
        }
        program.line("G0 Z2.0");
        program.line("G1 Z-5.0 F500.");
        for _ in 0..(random.between(1.0, 6.0) as u32) {
            let [x, y] = program.at;
            match random.between(0.0, 5.0) as u32 {
                0 => program.go("G1", anywhere(random)),
                1 => program.go("G1", [x, random.between(-300.0, 300.0)]),
                2 => program.go("G1", [x + random.between(-0.03, 0.03), y + random.between(-0.03, 0.03)]),
                3 => program.line(&format!("G1 Z{:.3}", random.between(-9.0, -1.0))),
                _ => {
                    let center = [(); 2].map(|()| (random.between(-40.0, 40.0) * 1e3).round() / 1e3);
                    program.at = [x, y].map(|place| (place * 1e3).round() / 1e3);
                    let from = if language == "grundig" { program.at } else { [0.0; 2] };
                    let [i, j] = [0, 1].map(|k| from[k] + center[k]);
                    let [x, y] = program.at;
                    program.line(&format!("G2 X{x:.3} Y{y:.3} I{i:.3} J{j:.3}"));
                }
            }
        }
        program.line("G0 Z50.0");
    }
    program.line("M30");
    program.text + if language == "fanuc" { "%\n" } else { "" }
}

fn executed(text: &str, machine: &Machine, language: &str) -> Vec<Element> {
    let source = Source::new(FileId(0), "p", text.as_bytes().to_vec()).unwrap();
    let (program, _) = syntax::parse(&source, ncfix_dialect::find(language).unwrap());
    Execution::new(program, machine, Box::new(NoLibrary), ExecOptions::default()).map(Result::unwrap).collect()
}

/// The lines of a program that the comparison refuses, and those that the correction names with W0305.
fn refused_and_named(text: &str, machine: &Machine, model: &Model, language: &str) -> (String, [Vec<u32>; 2]) {
    let options = CorrectionOptions { hole_tolerance_mm: 2e-3, ..CorrectionOptions::default() };
    let mut corrector =
        Corrector::new(executed(text, machine, language).into_iter().map(Ok), machine, model, options.clone());
    let writer_options = WriterOptions {
        names: machine.written_names(),
        increments: Increments::new(&machine.control),
        frame: options.frame,
        crlf: false,
        stamp: Stamp::default(),
        last_block_number: None,
        has_centers_reversed: false,
    };
    let mut writer = emit::writer(language, &writer_options).unwrap();
    let (mut out, mut found) = (Vec::new(), Vec::<Diagnostic>::new());
    emit::emit(&mut corrector, writer.as_mut(), &mut out, |finding| found.push(finding)).unwrap();
    let out = String::from_utf8(out).unwrap();
    let line = |finding: &Diagnostic| {
        let before = text.get(..finding.place?.span.start as usize)?;
        Some(before.matches('\n').count() as u32 + 1)
    };
    let named = found.iter().filter(|finding| finding.code.as_str() == "W0305").filter_map(line).collect();
    let how = How {
        grouping: Grouping::ByMarks,
        feeds: [Feeds::default(); 2],
        promise: Some(Promise::of(&options)),
        start: None,
    };
    let [before, after] = [text, &out].map(|text| executed(text, machine, language).into_iter());
    let mut refused = Vec::new();
    let compared = compare_seeing(
        before,
        after,
        how,
        machine,
        model,
        (&mut |_| {}, &mut |difference| refused.push(difference.original.line)),
    );
    assert!(compared.is_ok(), "{text}\n{out}");
    (out, [refused, named])
}

#[test]
fn what_is_refused_was_named() {
    for seed in 0..SEEDS {
        let mut random = Random(0x1a7e + seed);
        let language = LANGUAGES[(seed % 4) as usize];
        let (toml, program) = (worn(&mut random, language), random_program(&mut random, language));
        let source = Source::new(FileId(0), "m.toml", toml.clone().into_bytes()).unwrap();
        let (machine, errors) = ncfix_model::file::load(&source).0.unwrap();
        let model = Model::new(&machine, &errors);
        let (out, [refused, named]) = refused_and_named(&program, &machine, &model, language);
        let silent: Vec<&u32> = refused.iter().filter(|line| !named.contains(line)).collect();
        assert!(silent.is_empty(), "seed {seed}, lines {silent:?}\n{toml}\n{program}\n{out}");
    }
}

/// The tip is 4 µm towards X+ after Y has gone up. X100 changes the error of Y by 10 µm, but a rapid move of X leaves Y: it does not come down, and X stays
/// 4 µm short.
#[test]
fn a_rapid_move_of_one_axis_counts_with_the_sides_of_those_that_stay() {
    let mut machine = plain("sinumerik", "0.0001");
    play(&mut machine, "EXY", 8.0);
    machine += "[[motion]]\ncomponent = \"EYX\"\nkind = \"polynomial\"\ncoefficients = [0.0, 1e-4]\n";
    let program = "G17 G90 G71 G94 G54\nT1\nM6\nD1\nG0 X0 Y0 Z10\nG1 Z5 F500\nY10\nG0 X100\nG0 X100 Y40\nG0 Z50\nM30\n";
    let shop = Shop::new().file("m.toml", machine).file("p.mpf", program);
    shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    let text = shop.text("out.mpf");
    assert!(text.contains("\nG0 X99.996\n"), "{text}");
    shop.run(["verify", "p.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
}

/// Z loses 24 µm: going down the body is 12 µm too high, and the words of the hole are 12 µm lower. On the way out the body is on the other side, 24 µm from
/// the place for which the words are: no fault of the program.
#[test]
fn the_way_out_of_a_hole_is_on_the_other_side_of_the_lost_motion() {
    for (controller, name, program, bottom) in [
        (
            "sinumerik",
            "p.mpf",
            "G17 G90 G71 G94 G54\nT1\nM6\nD1\nG0 X10 Y10 Z50\nF200\nMCALL CYCLE81(20,0,2,-10)\nX10 Y20\nX30 Y20\nMCALL\nG0 Z50\nM30\n",
            "CYCLE81(19.988,-0.012,2,-10.012)",
        ),
        (
            "fanuc",
            "p.nc",
            "%\nO1\nG21 G17 G90 G40 G49 G80 G94\nT1 M6\nG54 G0 X10. Y10.\nG43 Z50. H1\nG99 G81 X10. Y20. Z-10. R2. F200.\nX30.\nG80\nG0 Z50.\nM30\n%\n",
            "Z-10.012",
        ),
    ] {
        let mut machine = plain(controller, "0.001");
        play(&mut machine, "EZZ", -24.0);
        let shop = Shop::new().file("m.toml", machine).file(name, program);
        let out = format!("out_{name}");
        shop.run([name, "-o", &out, "--machine", "m.toml"]).exits(0);
        let text = shop.text(&out);
        assert!(text.contains(bottom), "{text}");
        shop.run(["verify", name, &out, "--machine", "m.toml"]).exits(0);
    }
}
