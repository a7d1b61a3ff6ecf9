//! Axes that turn without end: DC, ACP, ACN, and that the output goes the way that was programmed.

use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_language::exec::Options as ExecOptions;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;
use ncfix_path::path::CorrectionOptions;

use crate::bench_machine::{motion, polynomial};
use crate::flat::{check, execute};
use crate::frame_correction::{check as check_correction, corrected};
use crate::machines::xyz_machine;
use crate::support::Shop;

/// A table C under three linear axes, turning without end.
fn table() -> Machine {
    let mut machine = xyz_machine();
    let mut c = machine.axis(Axis::Z).unwrap().clone();
    c.axis = Axis::C;
    c.direction = -c.direction;
    c.travel = None;
    c.modulo = true;
    machine.axes[Axis::C.slot()] = Some(c);
    machine.topology = "wCFXYZSt".parse().unwrap();
    machine
}

#[test]
fn ways_of_a_modulo_axis_are_counted_on() {
    let machine = table();
    check(
        "G0 C350\nC=DC(10)\nC=ACN(20)\nC=ACP(10)\nC=IC(400)\nC0",
        &machine,
        "G0 C350\nG0 C370\nG0 C20\nG0 C370\nG0 C770\nG0 C720",
    );
    // A plain word stays within the turn, or goes the shortest way.
    check("G0 C350\nC10", &machine, "G0 C350\nG0 C10");
    let mut shortest = table();
    shortest.control.modulo_shortest = true;
    check("G0 C350\nC10\nC=DC(300)", &shortest, "G0 C-10\nG0 C10\nG0 C-60");
    let (_, codes) = execute("G0 C360\nC-1\nX=DC(5)", &machine, ExecOptions::default());
    assert_eq!(codes, ["E0210:1", "E0210:2", "E0210:3"]);
}

#[test]
fn an_axis_with_travel_takes_no_ways() {
    let mut machine = table();
    machine.axes[Axis::C.slot()].as_mut().unwrap().modulo = false;
    check("G0 C370\nC-5", &machine, "G0 C370\nG0 C-5");
    assert_eq!(execute("G0 C=ACP(10)", &machine, ExecOptions::default()).1, ["E0210:1"]);
}

/// Errors that need corrections of C, so that every word is written anew.
fn errors() -> ErrorModel {
    let turning = motion("ECC", polynomial(&[2e-5]));
    ErrorModel { motion: vec![turning, motion("EXX", polynomial(&[0.02, 1e-4]))], ..ErrorModel::default() }
}

#[test]
fn the_output_goes_the_way_of_the_program() {
    let machine = table();
    let program = "G17 G90 G71 G54\nG0 X0 Y0 Z0 C350\nG1 C=DC(10) X20 F500\nC=ACP(5) X30\nC=ACN(6)\nC=IC(800) X0\nC=IC(-20)\nC100\nM30\n";
    let options = CorrectionOptions { max_correction_mm: 1.0, ..CorrectionOptions::default() };
    let done = check_correction(program, &machine, &errors(), &options);
    let turned: f64 = done.pieces.last().unwrap().command[Axis::C].to_degrees();
    // 350, 370, 725, 726 - 360 = 366, 1166, 1146; 1146 is 66 within the turn, so 100 is 1180.
    assert!((turned - 1180.0).abs() < 0.1, "{turned}\n{}", done.text);
    assert!(done.text.contains("C=DC(") && !done.text.contains("C370"), "{}", done.text);
}

#[test]
fn without_errors_the_words_say_the_same_way() {
    let program =
        "G17 G90 G71 G54\nG0 X0 Y0 Z0 C=ACP(350)\nG1 C=DC(10) F500\nC=ACP(5)\nC=ACN(6)\nC=IC(800)\nC100\nM30\n";
    let text = corrected(program, &table(), &ErrorModel::default(), &CorrectionOptions::default()).text;
    let words: Vec<&str> = text.split_whitespace().filter(|word| word.starts_with('C')).collect();
    assert_eq!(words, ["C=ACP(350)", "C=DC(10)", "C=ACP(5)", "C=ACN(6)", "C=IC(800)", "C100"]);
}

/// A control that takes the shortest way to a plain position needs no word for it, but for ways of half a turn and more.
#[test]
fn where_plain_positions_are_shortest_ways_they_stay_plain() {
    let mut machine = table();
    machine.control.modulo_shortest = true;
    let program = "G17 G90 G71 G54\nG0 X0 Y0 Z0 C=ACP(350)\nG1 C10 F500\nC300\nC=ACP(290)\nM30\n";
    let text = corrected(program, &machine, &ErrorModel::default(), &CorrectionOptions::default()).text;
    let words: Vec<&str> = text.split_whitespace().filter(|word| word.starts_with('C')).collect();
    assert_eq!(words, ["C=ACP(350)", "C10", "C300", "C=ACP(290)"]);
}

/// An error of the angle repeats with every turn.
#[test]
fn errors_repeat_with_every_turn() {
    let machine = table();
    let model = ncfix_model::Model::new(&machine, &errors());
    let mut command = AxisVector([100.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5]);
    let once = model.actual(&command, &Default::default(), &Default::default());
    command[Axis::C] += 4.0 * std::f64::consts::PI;
    let again = model.actual(&command, &Default::default(), &Default::default());
    assert!((once.translation - again.translation).norm() < 1e-9);
}

/// A correction of C is judged by the arc that it makes at the tip, about the line of C as A has turned it: at A90 it lies along Y, so that a tip that is
/// 300 mm above it takes 0.3 mm of a milliradian, and one that is 300 mm along it takes next to nothing.
#[test]
fn rotary_corrections_are_judged_about_the_line_as_it_lies() {
    let rotary =
        |axis: &str, direction: &str| format!("[axis.{axis}]\ndirection = {direction}\ntravel_deg = [-400, 400]\n");
    let linear =
        |axis: &str, direction: &str| format!("[axis.{axis}]\ndirection = {direction}\ntravel_mm = [-900, 900]\n");
    let machine = format!(
        "[machine]\nname = \"t\"\ntopology = \"wCAFXYZSt\"\ncontroller = \"sinumerik\"\n{}{}{}{}{}[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n\
         [[motion]]\ncomponent = \"ECC\"\nkind = \"polynomial\"\ncoefficients = [1e-3]\n",
        linear("X", "[1, 0, 0]"),
        linear("Y", "[0, 1, 0]"),
        linear("Z", "[0, 0, 1]"),
        rotary("A", "[-1, 0, 0]"),
        rotary("C", "[0, 0, -1]"),
    );
    for (place, status) in [("Y10 Z300", 4), ("Y300 Z10", 0)] {
        let shop = crate::support::Shop::new().file("t.toml", &machine);
        let shop = shop.file("in.mpf", format!("G17 G71 G90 G94 G54\nG0 X10 {place} A90 C0\nG1 C20 F1000\nM30\n"));
        let run = shop.run(["in.mpf", "-o", "out.mpf", "--machine", "t.toml"]).exits(status);
        assert_eq!(run.stderr.contains("E0303"), status == 4, "{place}: {}", run.stderr);
    }
}

/// A table A without end and a head B. With ORIWKS the tool turns along a great circle, so A passes 0° by the degree between both directions; with ORIAXES
/// the axes move in proportion, and a plain word stays within the turn: 359 degrees back.
#[test]
fn under_oriwks_a_modulo_axis_passes_zero() {
    let axis = |letter: &str, text: &str| format!("[axis.{letter}]\n{text}\n");
    let file = "[machine]\nname = \"m\"\ntopology = \"wAFXYZBSt\"\ncontroller = \"sinumerik\"\n".to_owned()
        + &axis("A", "direction = [-1, 0, 0]\npoint_mm = [0, 0, 0]\nmodulo = true")
        + &axis("B", "direction = [0, 1, 0]\npoint_mm = [0, 0, 200]\ntravel_deg = [-120, 120]")
        + &axis("X", "direction = [1, 0, 0]\ntravel_mm = [-900, 900]")
        + &axis("Y", "direction = [0, 1, 0]\ntravel_mm = [-900, 900]")
        + &axis("Z", "direction = [0, 0, 1]\ntravel_mm = [-900, 900]")
        + "[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nA_deg = 0\nB_deg = 0\n[[tool]]\nnumber = 1\nlength_mm = 100\nradius_mm = 3\n";
    let program = |interpolation: &str, b: &str| {
        format!(
            "N10 G17 G90 G71 G54\nN20 T1 D1\nN30 M6\nN40 G0 G53 D0 Z500\nN50 G0 A358 B{b}\nN60 TRAORI\nN65 {interpolation}\nN70 G54 D1\n\
             N80 G0 X0 Y0 Z60\nN90 G1 X0 Y0 Z50 F1000\nN100 X5 A359.5\nN110 X10 A0.5\nN120 X20 A2\nN130 X10 A359\nN140 TRAFOOF\nN150 M30\n"
        )
    };
    let shop = Shop::new()
        .file("m.toml", &file)
        .file("p.mpf", program("ORIWKS", "0"))
        .file("tilted.mpf", program("ORIWKS", "20"))
        .file("axes.mpf", program("ORIAXES", "0"));
    for (name, b) in [("p.mpf", "0"), ("tilted.mpf", "20")] {
        let flat = shop.run(["snc", name, "--machine", "m.toml"]).exits(0).stdout;
        let ends: Vec<&str> = flat
            .lines()
            .filter(|line| line.starts_with("G1"))
            .filter_map(|line| line.split(' ').find(|word| word.starts_with('A')))
            .collect();
        assert_eq!(ends.last(), Some(&"A359"), "{b}: {flat}");
        assert!(ends.contains(&"A360.5") && ends.contains(&"A362"), "{b}: {flat}");
        shop.run(["fix", name, "-o", "out.mpf", "--machine", "m.toml", "--review", "r.html", "--zero", "G54=absolute"])
            .exits(0);
        let out = shop.text("out.mpf");
        assert!(out.contains("N110 X10 A0.5") && out.contains("N130 X10 A359"), "error-free, so as programmed: {out}");
    }
    let flat = shop.run(["snc", "axes.mpf", "--machine", "m.toml"]).exits(0).stdout;
    assert!(flat.contains(" A0.5 ") && !flat.contains("A360.5"), "{flat}");
}

/// The position after a turn is a rounding beside that of the word: nothing turns, so no time is written for it.
#[test]
fn a_turn_of_a_rounding_has_no_time() {
    let file = "[machine]\nname = \"m\"\ntopology = \"wAFXYZSt\"\ncontroller = \"sinumerik\"\n\
        [axis.A]\ndirection = [-1, 0, 0]\npoint_mm = [0, 0, 0]\nmodulo = true\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-900, 900]\n\
        [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-900, 900]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-900, 900]\n\
        [location]\nEC0Y = 30.0\n[control]\ninitial_zero_offset = \"G500\"\n";
    for k in 0..60 {
        let [from, to] = [100.3 + f64::from(k), 12.9 + 0.1 * f64::from(k)];
        let program = format!(
            "N10 G0 G53 X1 Y2 Z3 A{from:.1}\nN20 G0 G53 A{to:.1}\nN30 G1 A{to:.1} F10000\nN40 G1 X50 Y60\nN50 M30\n"
        );
        let shop = Shop::new().file("m.toml", file).file("p.mpf", program);
        shop.run(["fix", "p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
        let out = shop.text("out.mpf");
        assert!(!out.contains("G93"), "{out}");
    }
}

/// A head B corrects the tilt of its column, 40 µrad, in a cut. The rapid move after it leaves B as it stands: 200 mm below the axis, a tip that was placed for
/// an uncorrected B would be 8 µm off.
#[test]
fn a_rapid_move_is_placed_for_the_rotary_axes_that_stay() {
    let axis = |letter: &str, text: &str| format!("[axis.{letter}]\n{text}\n");
    let file = "[machine]\nname = \"m\"\ntopology = \"wAFXYZBSt\"\ncontroller = \"sinumerik\"\n".to_owned()
        + &axis("A", "direction = [-1, 0, 0]\npoint_mm = [0, 0, 0]\nmodulo = true")
        + &axis("B", "direction = [0, 1, 0]\npoint_mm = [0, 0, 200]\ntravel_deg = [-120, 120]")
        + &axis("X", "direction = [1, 0, 0]\ntravel_mm = [-900, 900]")
        + &axis("Y", "direction = [0, 1, 0]\ntravel_mm = [-900, 900]")
        + &axis("Z", "direction = [0, 0, 1]\ntravel_mm = [-900, 900]")
        + "[location]\nEC0Y = 60.0\nEB0Z = -40.0\nEA0Z = 30.0\n[control]\ninitial_zero_offset = \"G500\"\n";
    let program = |transform: &str, rapid: &str| {
        format!(
            "N5 G0 X0 Y0 Z500 A80 B0\nN10 G1 A85 F10000\nN20 {transform}\nN30 G1 X210 Y-6 Z-12 B-0.03 F1000\nN40 {rapid} X209.9 Y-45 Z-46\nN50 M30\n"
        )
    };
    for (transform, rapid) in [("TRAORI", "G0"), ("TRAORI", "G1"), ("STOPRE", "G0"), ("STOPRE", "G1")] {
        let shop = Shop::new().file("m.toml", &file).file("p.mpf", program(transform, rapid));
        shop.run(["fix", "p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
        let run = shop.run(["verify", "p.mpf", "out.mpf", "--machine", "m.toml"]);
        assert!(run.code == 0 && !run.stdout.contains("E0320"), "{transform} {rapid}: {run:?}");
    }
}

/// A table begins at 0° and is corrected to 30 µrad below it: 359.998°. The review finds it beside the original.
#[test]
fn a_first_position_below_zero_is_beside_the_original() {
    let axis = |letter: &str, text: &str| format!("[axis.{letter}]\n{text}\n");
    let file = "[machine]\nname = \"m\"\ntopology = \"wAFXYZBSt\"\ncontroller = \"sinumerik\"\n".to_owned()
        + &axis("A", "direction = [-1, 0, 0]\npoint_mm = [0, 0, 0]\nmodulo = true")
        + &axis("B", "direction = [0, 1, 0]\npoint_mm = [0, 0, 200]\ntravel_deg = [-120, 120]")
        + &axis("X", "direction = [1, 0, 0]\ntravel_mm = [-900, 900]")
        + &axis("Y", "direction = [0, 1, 0]\ntravel_mm = [-900, 900]")
        + &axis("Z", "direction = [0, 0, 1]\ntravel_mm = [-900, 900]")
        + "[location]\nEC0Y = 60.0\nEB0Z = -40.0\nEA0Z = 30.0\n[control]\ninitial_zero_offset = \"G500\"\n";
    let program = "N5 G0 X0 Y0 Z500 A0 B0\nN10 G1 X1 Z490 A85 F10000\nN30 G1 X210 Y-6 Z-12 B-0.03 F1000\nN40 G1 X209.9 Y-45 Z-46\nN50 M30\n";
    let shop = Shop::new().file("m.toml", file).file("p.mpf", program);
    shop.run(["fix", "p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    // 30 µrad are 0.0017 degrees. Without DC the axis would turn back by 275 degrees.
    let out = shop.text("out.mpf");
    assert!(out.contains("A359.9983") && out.contains("A=DC(84.9983)"), "{out}");
    shop.run(["verify", "p.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
}
