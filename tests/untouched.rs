//! Corrected programs that nobody has touched: whatever the options and whatever stands in the program, nothing is named.

use std::fs;

use crate::support::{Run, Shop, machine, repository};

/// Codes that name a difference.
const NAMING: [&str; 6] = ["E0311", "E0319", "E0320", "E0321", "W0306", "W0314"];

fn raises_no_alarm(run: &Run, what: &str) {
    for code in NAMING {
        assert!(!run.stdout.contains(&format!("\"{code}\"")), "{what}: {}", run.stdout);
    }
}

/// A sample with options.
fn sample(dialect: &str, machine_name: &str, program: &str, options: &str) -> Shop {
    let machine = machine(machine_name);
    let out = format!("out.{}", program.split_once('.').unwrap().1);
    let mut shop = Shop::new();
    for entry in fs::read_dir(repository(&format!("samples/programs/{dialect}"))).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            shop = shop.copy(path.to_str().unwrap());
        }
    }
    let fix = ["fix", program, "-o", &out, "--machine", &machine];
    shop.run(fix.into_iter().chain(options.split_whitespace())).exits(0);
    let run = shop.run(["verify", program, &out, "--machine", &machine, "--json"]);
    raises_no_alarm(&run, &format!("{program} {options}"));
    shop
}

#[test]
fn fine_tolerances_and_coarse_increments_are_kept_as_far_as_rounding_goes() {
    for (dialect, machine, program, options) in [
        ("sinumerik", "demo", "helix_bore.mpf", "--tolerance 0.2um"),
        ("sinumerik", "demo", "profile.mpf", "--tolerance 0.2um"),
        ("fanuc", "vmc", "helix_bore.nc", "--tolerance 0.2um"),
        ("fanuc", "vmc", "profile_comp.nc", "--tolerance 0.2um"),
        ("fanuc", "vmc", "inch_bracket.nc", "--increment 10um"),
    ] {
        sample(dialect, machine, program, options);
    }
}

#[test]
fn a_coarse_increment_changes_no_feed() {
    let machine = machine("esmaeili_huron");
    let shop = Shop::new().copy("samples/programs/sinumerik/swarf.mpf");
    shop.run(["fix", "swarf.mpf", "-o", "out.mpf", "--machine", &machine, "--increment", "10um"]).exits(0);
    let run = shop.run(["verify", "swarf.mpf", "out.mpf", "--machine", &machine, "--json"]);
    assert!(!run.stdout.contains("\"E0321\""), "{}", run.stdout);
}

/// IS-B: one increment of a program in inches is 0.0001 in, which are 2.54 µm.
#[test]
fn an_inch_program_keeps_the_increment_of_inches() {
    let file = fs::read_to_string(machine("vmc")).unwrap();
    let coarse = file
        .replace("increment_mm = 0.0001", "increment_mm = 0.001")
        .replace("increment_deg = 0.0001", "increment_deg = 0.001")
        .replace("IS-C", "IS-B");
    assert_ne!(file, coarse);
    let program = "%\nO1300\nN10 G20 G17 G90 G40 G49 G80 G94\nN20 T9 M6\nN30 G54 G0 X0. Y0. S300 M3\nN40 G43 H9 Z2.\n\
                   N50 G1 Z-0.2 F20.\nN60 X3.\nN70 Y2.\nN80 G2 X1. Y2. I-1. J0.\nN90 G0 Z2.\nN100 M30\n%\n";
    let shop = Shop::new().file("vmc.toml", coarse).file("part.nc", program);
    shop.run(["fix", "part.nc", "-o", "out.nc", "--machine", "vmc.toml"]).exits(0);
    let run = shop.run(["verify", "part.nc", "out.nc", "--machine", "vmc.toml", "--json"]);
    raises_no_alarm(&run, "inch");
}

#[test]
fn exact_stops_stay_at_the_ends_of_blocks() {
    for program in ["bolt_circle.mpf", "gear_case.mpf"] {
        let shop = sample("sinumerik", "demo", program, "--rapids all");
        // A stop in a line that moves nothing is none.
        let text = shop.text("out.mpf");
        let is_bare = |line: &&str| line.starts_with("G60 ") && !line.contains(['X', 'Y', 'Z']);
        assert_eq!(text.lines().find(is_bare), None);
    }
    // Pieces of a curve under a transformation run through, also those that the control makes of it.
    let program = "N10 G17 G90 G71 G94 G60\nN20 T1\nN30 M6\nN40 D1\nN50 S3000 M3\nN60 G54\nN70 G0 X50 Y0 Z150 A0 C0\nN80 TRAORI\n\
                   N90 G0 X50 Y0 Z62\nN100 G1 X40 Y0 Z60 A-8 C-20 F1500\nN110 G0 Z150\nN120 TRAFOOF\nN130 M30\n";
    let machine = machine("esmaeili_huron");
    let shop = Shop::new().file("part.mpf", program);
    shop.run(["fix", "part.mpf", "-o", "out.mpf", "--machine", &machine]).exits(0);
    raises_no_alarm(&shop.run(["verify", "part.mpf", "out.mpf", "--machine", &machine, "--json"]).exits(0), "G60");
    // The last one stops, and where it does not that is named.
    let text = shop.text("out.mpf").replacen("\nG60 ", "\n", 1);
    let shop = shop.file("bad.mpf", text);
    shop.run(["verify", "part.mpf", "bad.mpf", "--machine", &machine, "--json"]).exits(4);
}

#[test]
fn rotary_axes_that_are_corrected_or_in_machine_coordinates_raise_no_alarm() {
    let program = "N10 G17 G90 G71 G94 G64\nN20 T1\nN30 M6\nN40 D1\nN50 S3000 M3\nN60 G54\nN65 G0 X0 Y0 Z300 A0 C0\n\
                   N70 CYCLE800(0,\"TABLE\",100000,57,0,0,0,30,0,0,0,0,0,-1,100,1)\nN80 G0 X0 Y0\nN90 Z100\nN100 G1 Z70 F500\nN110 X20\n\
                   N120 G0 Z120\nN130 CYCLE800()\nN140 G153 G0 Z150\nN150 M30\n";
    let machine = machine("esmaeili_huron");
    let shop = Shop::new().file("part.mpf", program);
    for options in [&["--rotary", "correct"][..], &["--frame", "machine"], &[]] {
        let fix = ["fix", "part.mpf", "-o", "out.mpf", "--machine", &machine];
        shop.run(fix.into_iter().chain(options.iter().copied())).exits(0);
        let run = shop.run(["verify", "part.mpf", "out.mpf", "--machine", &machine, "--json"]).exits(0);
        raises_no_alarm(&run, &options.join(" "));
    }
    // The first line of what stands for a block has its number.
    let text = shop.text("out.mpf");
    for line in ["N70 SUPA", "N130 CYCLE800()"] {
        assert!(text.contains(line), "{line} in\n{text}");
    }
}

/// A line whose words keep their values keeps its bytes: blanks, zeros, order, lower case, and comments in any encoding.
#[test]
fn lines_in_which_nothing_changes_keep_their_bytes() {
    // Only X has an error: 20 µm at 200 mm.
    let machine = "[machine]\nname = \"m\"\ntopology = \"wFXYZt\"\ncontroller = \"LANGUAGE\"\n\
        [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-10, 500]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-10, 500]\n\
        [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-200, 400]\n[zero_offset.G54]\nset = \"absolute\"\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n\
        [[tool]]\nnumber = 1\nlength_mm = 0\n[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n";
    let programs: [(&str, &[u8]); 3] = [
        (
            "sinumerik",
            b"N010 G54 G90 G71 G17  T1 M06\nN020 d1\nn30 g0 x0.00 y10.500 z50 ; Fl\xe4che\nN40 G01 Z-2.0 F0500\nN50   Y+20.\nN60 X200 Y30.0\nN70 M09  M5\nN80 M30\n",
        ),
        (
            "fanuc",
            b"%\nO0001 (PART)\nN010 G54 G90 G21 G17  T01 M06\nN030 g0 x0.0 y10.500 z50. (FL\xc4CHE)\nN40 G01 Z-2.0 F0500.\nN50   Y+20.\nN60 X200.00 Y30.0\nN70 M09\nN80 M30\n%\n",
        ),
        (
            "rs274",
            b"N010 G54 G90 G21 G17  T1 M06\nN030 g0 x0.00 y10.500 z50 (face)\nN40 G01 Z-2.0 F0500\nN50   Y+20.\nN60 X200 Y30.0\nN70 M09\nN80 M30\n",
        ),
    ];
    for (dialect, program) in programs {
        let shop = Shop::new().file("m.toml", machine.replace("LANGUAGE", dialect)).file("in.nc", program);
        shop.run(["in.nc", "-o", "out.nc", "--machine", "m.toml", "--dialect", dialect]).exits(0);
        let written = shop.bytes("out.nc");
        let lines: Vec<&[u8]> = written.split(|&byte| byte == b'\n').collect();
        for line in program.split(|&byte| byte == b'\n').filter(|line| !line.starts_with(b"N60")) {
            assert!(
                lines.contains(&line),
                "{dialect} {}: {}",
                String::from_utf8_lossy(line),
                String::from_utf8_lossy(&written)
            );
        }
        assert!(!lines.iter().any(|line| line.starts_with(b"N60 X200")), "{}", String::from_utf8_lossy(&written));
    }
}

/// Three passes of a loop: the first line of the second and of the third one says so, and nothing else does.
#[test]
fn each_further_pass_of_a_loop_is_marked() {
    let sinumerik = "DEF INT K\nN10 G17 G90 G71 G94 G54\nN20 T1 M6\nN30 D1 S3000 M3\nN40 G0 X10 Y10 Z150\nN50 FOR K=1 TO 3\nN60 G0 X=K*50 Y10\n\
                     N70 G1 Z100 F300\nN80 Y50\nN90 G0 Z150\nN100 ENDFOR\nN110 M30\n";
    let fanuc = "%\nO1\nN10 G21 G17 G90 G94 G54\nN20 T1 M6\nN30 G0 X10. Y10. Z150.\n#1=1\nWHILE[#1LE3]DO1\nN60 G0 X[#1*50] Y10.\n\
                 N70 G1 Z100. F300.\nN80 Y50.\nN90 G0 Z150.\n#1=#1+1\nEND1\nN110 M30\n%\n";
    let programs = [
        ("part.mpf", "sinumerik", sinumerik, ["; pass 2 of N60", "; pass 3 of N60"]),
        ("part.nc", "fanuc", fanuc, ["(PASS 2 OF N60)", "(PASS 3 OF N60)"]),
    ];
    for (name, control, program, marks) in programs {
        let file = format!(
            "[machine]\nname = \"m\"\ntopology = \"wFXYZt\"\ncontroller = \"{control}\"\n\
             [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-10, 500]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-10, 500]\n\
             [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-200, 400]\n[zero_offset.G54]\nset = \"absolute\"\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n\
             [[tool]]\nnumber = 1\nlength_mm = 0\n[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n"
        );
        let shop = Shop::new().file("m.toml", file).file(name, program);
        shop.run(["fix", name, "-o", "out.txt", "--machine", "m.toml"]).exits(0);
        let text = shop.text("out.txt");
        for mark in marks {
            let marked: Vec<&str> = text.lines().filter(|line| line.ends_with(mark)).collect();
            assert!(marked.len() == 1 && marked[0].starts_with("G0 X"), "{mark}\n{text}");
        }
        assert_eq!(text.to_ascii_lowercase().matches("pass ").count(), 2, "{text}");
        shop.run(["verify", name, "out.txt", "--machine", "m.toml", "--dialect", control]).exits(0);
    }
}
