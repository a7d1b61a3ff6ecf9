//! `ncfix verify`: the errors of an original and of its correction on the error model.

use crate::support::{Shop, machine, repository};

#[test]
fn a_corrected_program_is_better() {
    let demo = machine("demo");
    for name in ["bolt_circle.mpf", "seal_groove.mpf"] {
        let shop = Shop::new().copy(&format!("samples/programs/sinumerik/{name}"));
        shop.run([name, "-o", "out.mpf", "--machine", &demo]).exits(0);
        let run = shop.run(["verify", name, "out.mpf", "--machine", &demo, "--json"]).exits(0);
        let json = run.json();
        let [before, after] = ["before", "after"].map(|side| json[side].clone());
        for key in ["mean_um", "rms_um", "max_um"] {
            let (before, after) = (before[key].as_f64().unwrap(), after[key].as_f64().unwrap());
            assert!(before > 1.0 && after < 1.5 && after < before / 5.0, "{name} {key}: {json}");
        }
        assert!(json["samples"].as_u64().unwrap() > 50, "{json}");
    }
}

#[test]
fn a_program_compared_with_itself_is_the_same_and_not_corrected() {
    let shop = Shop::new().copy("samples/programs/sinumerik/seal_groove.mpf");
    let verify = ["verify", "seal_groove.mpf", "seal_groove.mpf", "--machine", &machine("demo"), "--json"];
    let run = shop.run(verify).exits(4);
    let json = run.json();
    assert_eq!(json["before"], json["after"]);
    for text in ["nothing was corrected", "E0320", "W0314"] {
        assert!(run.stdout.contains(text), "{text}: {}", run.stdout);
    }
    // Where nothing is to be corrected that is no fault.
    shop.run(verify.into_iter().chain(["--promised", "100um"])).exits(0);
}

#[test]
fn a_program_that_begins_with_a_cut_is_judged_from_its_start() {
    // From (150, 120, 300) of the machine, which is the zero of G54: an arc, a line and a relative move.
    let firsts = ["G2 X20. Y0. I10. J0. F300.", "G1 X20. Y5. F300.", "G91 G1 X20. F300."];
    let start = ["--start", "X150,Y120,Z300"];
    let machine = |control: &str| {
        format!(
            "[machine]\nname = \"m\"\ntopology = \"wXYFZSt\"\ncontroller = \"{control}\"\n\
             [axis.X]\ntravel_mm = [0, 400]\ndirection = [-1, 0, 0]\n[axis.Y]\ntravel_mm = [0, 300]\ndirection = [0, -1, 0]\n\
             [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 400]\n[location]\nEC0X = 40.0\nEA0Z = -30.0\n\
             [zero_offset.G54]\nX_mm = 150\nY_mm = 120\nZ_mm = 300\nset = \"absolute\"\n"
        )
    };
    for (file, head, end, control) in [
        ("a.mpf", "G17 G90 G71 G94 G54", "M30", "sinumerik"),
        ("a.ngc", "G17 G90 G21 G94 G54", "M2", "linuxcnc"),
        ("a.nc", "G17 G90 G21 G94 G54", "M30", "fanuc"),
    ] {
        for first in firsts {
            let text = format!("N10 {head}\nN20 {first}\nN30 G90 G1 X30.\nN40 {end}\n");
            let shop = Shop::new().file("m.toml", machine(control)).file(file, text);
            let fix = [file, "-o", "out", "--machine", "m.toml", "--review", "r.html", "--json"];
            let fixed = shop.run(fix.iter().chain(&start)).exits(0).json();
            assert!(["ok", "warn"].contains(&fixed["verdict"]["grade"].as_str().unwrap()), "{file} {first}: {fixed}");
            let verify = ["verify", file, "out", "--machine", "m.toml", "--json"];
            let run = shop.run(verify.iter().chain(&start)).exits(0);
            // Predicted by the correction, and read again from the text.
            let [before, after] = ["before", "after"].map(|side| run.json()[side]["max_um"].as_f64().unwrap());
            assert!(before > 1.0 && after < 1.0, "{file} {first}: {}", run.stdout);
            let predicted = fixed["after"]["max_um"].as_f64().unwrap();
            assert!((after - predicted).abs() < 0.02, "{file} {first}: {after} {predicted}");
        }
    }
}

#[test]
fn the_result_is_a_table_for_people() {
    let demo = machine("demo");
    let shop = Shop::new().copy("samples/programs/sinumerik/slots.mpf");
    shop.run(["slots.mpf", "-o", "out.mpf", "--machine", &demo]).exits(0);
    let run = shop.run(["verify", "slots.mpf", "out.mpf", "--machine", &demo]).exits(0);
    for row in ["mean", "error before", "error after", "improvement"] {
        assert!(run.stdout.contains(row), "{row}: {}", run.stdout);
    }
}

#[test]
fn programs_that_differ_cannot_be_compared() {
    let other = std::fs::read(repository("samples/programs/sinumerik/slots.mpf")).unwrap();
    let shop = Shop::new().copy("samples/programs/sinumerik/saddle.mpf").file("other.mpf", other);
    let run = shop.run(["verify", "saddle.mpf", "other.mpf", "--machine", &machine("demo")]).exits(4);
    run.says("error[E0311]");
}

#[test]
fn findings_say_which_file_they_are_in() {
    let shop = Shop::new().file("a.mpf", "N10 G90 G71 G0 X1 Y1 Z1\nN20 M30\n").file("b.mpf", "N10 G0 X\n");
    shop.run(["verify", "a.mpf", "b.mpf", "--machine", &machine("demo")]).exits(3).says("b.mpf:1:8");
    shop.run(["verify", "a.mpf", "c.mpf", "--machine", &machine("demo")]).exits(2).says("cannot read c.mpf");
}

#[test]
fn moves_of_length_zero_behind_a_tool_change_are_matched_by_the_marks_of_the_text() {
    let program = "N10 G90 G17 G71 G54 T2
N20 M6
N25 D1
N30 G0 X0 Y0 Z320 A65.5302 C335.5302
N40 G1 X10 F500
N50 T5
N60 M6
N70 D1
N80 G0 X0 Y0 Z320
N90 A65.5302 C335.5302
N100 Z320
N110 C335.5302
N120 X51 Y64
N130 G1 X20 F500
N140 M30
";
    let shop = Shop::new().file("in.mpf", program);
    let huron = machine("esmaeili_huron");
    shop.run(["in.mpf", "-o", "out.mpf", "--machine", &huron]).exits(0);
    shop.run(["verify", "in.mpf", "out.mpf", "--json", "--machine", &huron]).exits(0);
    // Without one of its pieces the corrected program is another one.
    let torn: String =
        shop.text("out.mpf").lines().filter(|line| !line.starts_with("N130")).map(|line| format!("{line}\n")).collect();
    let shop = shop.file("torn.mpf", torn);
    shop.run(["verify", "in.mpf", "torn.mpf", "--machine", &huron]).exits(4);
}

#[test]
fn a_correction_for_another_machine_is_pointed_out() {
    let demo = std::fs::read_to_string(machine("demo")).unwrap();
    let shop = Shop::new()
        .file("a.toml", &demo)
        .file("b.toml", demo.replace("[location]", "[location] # measured again"))
        .copy("samples/programs/sinumerik/pocket.mpf");
    shop.run(["pocket.mpf", "-o", "out.mpf", "--machine", "a.toml"]).exits(0);
    let same = shop.run(["verify", "pocket.mpf", "out.mpf", "--machine", "a.toml"]).exits(0);
    assert!(!same.stderr.contains("W0306"), "{}", same.stderr);
    shop.run(["verify", "pocket.mpf", "out.mpf", "--machine", "b.toml"]).exits(0).says("warning[W0306]");
}

#[test]
fn rapid_moves_that_a_control_takes_apart_are_matched() {
    // The tool axis leaves first and arrives last; a correction moves the other axes by micrometers beside it.
    let program = "%PM9001\nN9001\nN1 G17 G71 G90 G54\nN2 T5 M6\nN3 G0 X10 Y10 Z50 S900 M3\nN4 G0 X40 Y30 Z2\nN5 G1 Z-2 F200\n\
                   N6 G1 X90 Y60\nN7 G0 X10 Y10 Z50\nN8 M30\n";
    let shop = Shop::new().file("part.pm", program);
    let machine = ["--machine".to_owned(), machine("universal_mill")];
    let fix = ["fix", "part.pm", "-o", "out.pm"].map(str::to_owned);
    shop.run(fix.iter().chain(&machine)).exits(0);
    let verify = ["verify", "part.pm", "out.pm", "--json"].map(str::to_owned);
    let run = shop.run(verify.iter().chain(&machine)).exits(0);
    let after = run.json()["after"]["mean_um"].as_f64().unwrap();
    assert!(after < 1.0, "{after}");
}

#[test]
fn no_verdict_rests_on_a_zero_or_a_tool_without_value() {
    // X errs by 100 µm/m: the error at the cut depends on the zero offset, so that no verdict is possible without it.
    let machine = |controller: &str, offset: &str| {
        format!(
            "[machine]\nname = \"m\"\ntopology = \"wXYFZSt\"\ncontroller = \"{controller}\"\n{offset}\n[control]\ndecimal_point = \"calculator\"\n\
            [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [-1000, 1000]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-1000, 1000]\n\
            [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-1000, 1000]\n[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n"
        )
    };
    let tool = "[[tool]]\nnumber = 1\nlength_mm = 100\n";
    let cases = [
        ("sinumerik", "a.mpf", "N10 G54 G90 G71\nN20 T1 D1 M6\nN30 G0 X10 Y10 Z50\nN40 G1 X80 F500\nN50 M30\n"),
        (
            "fanuc",
            "a.nc",
            "%\nO1\nN10 G54 G90 G21\nN20 T1 M6\nN30 G43 H1 G0 X10 Y10 Z50\nN40 G1 X80 F500\nN50 M30\n%\n",
        ),
        ("rs274", "a.ngc", "N10 G54 G90 G21\nN20 T1 M6\nN30 G43 H1 G0 X10 Y10 Z50\nN40 G1 X80 F500\nN50 M30\n"),
        (
            "grundig",
            "a.pm",
            "%PM9001\nN9001\nN1 G17 G71 G90\nN2 G54\nN3 T1 M6\nN4 G0 X10 Y10 Z50\nN5 G1 X80 F500\nN6 M30\n",
        ),
    ];
    for (controller, name, program) in cases {
        let offset = "[zero_offset.G54]\nX_mm = 200\nY_mm = 0\nZ_mm = 0\nset = \"absolute\"\n";
        let whole = machine(controller, &format!("{offset}{tool}"));
        let shop = Shop::new()
            .file("m.toml", whole)
            .file("zero.toml", machine(controller, tool))
            .file("tool.toml", machine(controller, offset))
            .file(name, program);
        shop.run(["fix", name, "--machine", "m.toml", "-o", "out.nc"]).exits(0);
        shop.run(["verify", name, "out.nc", "--machine", "m.toml"]).exits(0);
        for (file, code) in [("zero.toml", "E0306"), ("tool.toml", "E0307")] {
            let run = shop.run(["verify", name, "out.nc", "--machine", file, "-q"]).exits(4);
            assert!(run.stderr.contains(code) && !run.stdout.contains("error after"), "{controller} {file}: {run:?}");
            let run = shop.run(["diff", name, "out.nc", "--machine", file, "-q"]).exits(4);
            assert!(run.stderr.contains(code), "{controller} {file}: {run:?}");
        }
    }
}

/// X and Y err by 30 µm/m each, at right angles to their motion.
const SKEW: &str = "[machine]\nname = \"m\"\ntopology = \"wXYFZSt\"\ncontroller = \"fanuc\"\n[control]\ndecimal_point = \"calculator\"\n\
    [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [-1000, 1000]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-1000, 1000]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-1000, 1000]\n[[motion]]\ncomponent = \"EYX\"\nkind = \"polynomial\"\n\
    coefficients = [0, 0, 1e-6]\n[[tool]]\nnumber = 1\nlength_mm = 100\n[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nset = \"absolute\"\n";
const CIRCLE: &str = "%\nO1\nN10 G54 G90 G21 G17\nN20 T1 M6\nN30 G43 H1 G0 X20. Y0. Z50.\nN40 G1 Z0. F500.\nN50 G3 X20. Y0. I-20. J0.\nN60 G0 Z50.\nN70 M30\n%\n";

#[test]
fn a_tolerance_that_permits_any_path_is_refused() {
    let shop = Shop::new().file("m.toml", SKEW).file("a.nc", CIRCLE);
    for tolerance in ["10mm", "500mm", "0.21mm"] {
        let run = shop.run(["fix", "a.nc", "--machine", "m.toml", "-o", "o.nc", "--tolerance", tolerance]).exits(2);
        run.says("--max-correction").says("check the unit");
    }
    // Chords of 0.15 mm on a circle whose error is below a micrometer are as requested, but the original is better.
    let coarse = ["fix", "a.nc", "--machine", "m.toml", "-o", "o.nc", "--tolerance", "0.15mm", "--arcs", "chords"];
    shop.run(coarse).exits(0);
    shop.run(["verify", "a.nc", "o.nc", "--machine", "m.toml"]).exits(4);
}

#[test]
fn a_script_learns_that_a_program_should_not_run() {
    let shop = Shop::new().file("m.toml", SKEW).file("a.nc", CIRCLE);
    shop.run(["fix", "a.nc", "--machine", "m.toml", "-o", "o.nc"]).exits(0);
    shop.run(["verify", "a.nc", "o.nc", "--machine", "m.toml"]).exits(0);
    shop.run(["diff", "a.nc", "o.nc", "--machine", "m.toml", "--fail-above", "0.2mm"]).exits(0);
    // A person has moved the start and the end of the circle by 0.1 mm each, within the promise that is stated.
    let text = shop.text("o.nc");
    let moved = text.lines().map(|line| {
        let is_xy = line.contains(" X20") || line.contains(" X19.99");
        if is_xy { line.replace("X20.", "X20.1").replace("X19.99", "X20.09") } else { line.to_owned() }
    });
    let moved: String = moved.map(|line| format!("{line}\n")).collect();
    let shop = shop.file("moved.nc", moved);
    let verify = shop.run(["verify", "a.nc", "moved.nc", "--machine", "m.toml", "--promised", "1mm"]);
    assert!(verify.stdout.contains("should not run") && verify.code == 4, "{verify:?}");
    let diff =
        shop.run(["diff", "a.nc", "moved.nc", "--machine", "m.toml", "--promised", "1mm", "--fail-above", "0.2mm"]);
    assert!(diff.stdout.contains("should not run") && diff.code == 4, "{diff:?}");
}

#[test]
fn the_end_of_a_main_program_that_begins_again_is_written() {
    let body = CIRCLE.replace("M30", "M99");
    let shop = Shop::new().file("m.toml", SKEW).file("a.nc", &body);
    shop.run(["fix", "a.nc", "--machine", "m.toml", "-o", "o.nc"]).exits(0);
    assert!(
        shop.text("o.nc")
            .lines()
            .any(|line| line.trim_start_matches(|c: char| c == 'N' || c.is_ascii_digit()).trim() == "M99"),
        "{}",
        shop.text("o.nc")
    );
    shop.run(["verify", "a.nc", "o.nc", "--machine", "m.toml"]).exits(0);
    // Without it the part would be cut once, so that its absence is no correction.
    let without: String =
        shop.text("o.nc").lines().filter(|line| !line.contains("M99")).map(|line| format!("{line}\n")).collect();
    let shop = shop.file("cut.nc", without);
    shop.run(["verify", "a.nc", "cut.nc", "--machine", "m.toml"]).exits(4).says("M99");
    // LinuxCNC begins such a program again as well.
    let rs274 = body.replace("%\nO1\n", "").replace("%\n", "");
    let machine = SKEW.replace("\"fanuc\"", "\"rs274\"").replace("[control]\ndecimal_point = \"calculator\"\n", "");
    let shop = Shop::new().file("m.toml", machine).file("a.ngc", rs274);
    shop.run(["fix", "a.ngc", "--machine", "m.toml", "-o", "o.ngc"]).exits(0);
    assert!(shop.text("o.ngc").contains("M99"), "{}", shop.text("o.ngc"));
}

#[test]
fn a_length_offset_without_its_number_is_refused() {
    let shop = Shop::new().file("m.toml", SKEW).file("a.nc", CIRCLE.replace("G43 H1", "G43"));
    for command in
        [&["check", "a.nc", "--machine", "m.toml"][..], &["fix", "a.nc", "--machine", "m.toml", "-o", "o.nc"]]
    {
        let run = shop.run(command).exits(4);
        run.says("E0307").says("without H");
    }
    // After H1 the number holds.
    let later = CIRCLE.replace("N60 G0 Z50.", "N55 G49\nN60 G43 G0 Z50.");
    let shop = Shop::new().file("m.toml", SKEW).file("a.nc", later);
    shop.run(["check", "a.nc", "--machine", "m.toml"]).exits(0);
}

#[test]
fn a_guard_that_ends_the_program_asks_for_a_new_correction() {
    let part = "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S300 M3\nN40 G0 X10 Y10 Z50\nN50 G1 Z-4 F200\nN60 X60\nN70 G0 Z50\nN80 M30\n";
    let demo = machine("demo");
    let shop = Shop::new()
        .file("part.mpf", part)
        .file("other.toml", "[[tool]]\nnumber = 2\nlength_mm = 100.5\nradius_mm = 4.0\n");
    shop.run(["part.mpf", "-o", "out.mpf", "--machine", &demo, "--guard"]).exits(0);
    shop.run(["verify", "part.mpf", "out.mpf", "--machine", &demo, "--setup", "other.toml"])
        .exits(4)
        .says("error[E0311]")
        .says("if they have changed since, correct the original again");
}
