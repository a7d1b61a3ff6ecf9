//! Values that an earlier program has left in the control: a correction refuses to read them, in every dialect.

use super::support::{Shop, machine};

const GRUNDIG: &str = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"grundig\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-500, 500]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-500, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-500, 500]\n[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n\
    [[tool]]\nnumber = 1\nlength_mm = 100\nradius_mm = 5\n";

/// The height of the retracts is a parameter that the operator has set: read as 0, they stay at the surface.
fn retracts(set: &str) -> String {
    format!(
        "%PM9001\nN9001\nN1 G17 G54\nN2 T1 M6\n{set}N4 G0 X0 Y0 Z=E5\nN5 G1 Z-2 F200\nN6 G0 Z=E5\nN7 G0 X80 Y0\nN8 M30\n"
    )
}

#[test]
fn an_e_parameter_without_a_value_is_refused() {
    let shop = Shop::new().file("m.toml", GRUNDIG).file("p.pm", retracts("")).file("set.pm", retracts("N3 E5=50\n"));
    let run = shop.run(["p.pm", "-o", "o.pm", "--machine", "m.toml"]).exits(4);
    run.says("error[E0219]").says("E5 keeps its value between programs").says("p.pm:5");
    assert!(!shop.path("o.pm").exists());
    shop.run(["check", "p.pm", "--machine", "m.toml"]).exits(4).says("E0219");
    let flat = shop.run(["snc", "p.pm", "--machine", "m.toml"]).exits(0).says("warning[W0240]").says("0 is used");
    assert!(flat.stdout.contains("Z0"), "{}", flat.stdout);
    shop.run(["set.pm", "-o", "s.pm", "--machine", "m.toml"]).exits(0);
    let stated = Shop::new().file("m.toml", format!("{GRUNDIG}[system]\nE5 = 50\n")).file("p.pm", retracts(""));
    stated.run(["p.pm", "-o", "o.pm", "--machine", "m.toml"]).exits(0);
    assert!(stated.text("o.pm").lines().any(|line| line.starts_with("N6 G0 Z50")), "{}", stated.text("o.pm"));
}

/// LinuxCNC keeps `#31` to `#5000` until it ends, and those of its parameter file beyond. The arguments of a subroutine that are not given are 0.
#[test]
fn a_parameter_of_rs274_without_a_value_is_refused() {
    let mill = machine("knee_mill");
    let program = |set: &str, name: &str| {
        format!("G21 G90 G17 G54\n{set}G0 X0 Y0 Z{name}\nG1 Z-2 F200\nG0 Z{name}\nG0 X80 Y0\nM2\n")
    };
    for name in ["#100", "#5", "[#31+1]"] {
        let shop = Shop::new().file("p.ngc", program("", name));
        let run = shop.run(["p.ngc", "-o", "o.ngc", "--machine", &mill]).exits(4);
        run.says("error[E0219]").says("keeps its value between programs").says("p.ngc:2");
        assert!(!shop.path("o.ngc").exists());
    }
    let shop = Shop::new().file("p.ngc", program("#100=50\n", "#100"));
    shop.run(["p.ngc", "-o", "o.ngc", "--machine", &mill]).exits(0);
    let sub = "o10 sub\nG0 Z[50+#2]\nG1 X#1 F500\no10 endsub\nG21 G90 G17 G54\nG0 X0 Y0 Z50\no10 call [20]\nM2\n";
    Shop::new().file("p.ngc", sub).run(["p.ngc", "-o", "o.ngc", "--machine", &mill]).exits(0);
}

/// T1 has 110 mm and H2 90 mm: the tip would be 20 mm too deep. H3 is T1 with another wear.
#[test]
fn the_length_of_another_tool_is_named() {
    let tools = [(1, 110.0), (2, 90.0), (3, 109.95)]
        .map(|(number, length)| format!("[[tool]]\nnumber = {number}\nlength_mm = {length}\nradius_mm = 5\n"));
    let file = GRUNDIG.replace("grundig", "fanuc").split("[[tool]]").next().unwrap().to_owned() + &tools.concat();
    let program =
        |words: &str| format!("%\nO1\nG21 G17 G90 G54\n{words}\nG0 X0. Y0.\nG1 Z-1. F100.\nG0 Z50.\nM30\n%\n");
    for (words, count) in [
        ("T1 M6\nG43 H2 Z20.", 1),
        ("T1 M6\nG43 H1 Z20.", 0),
        ("T1 M6\nG43 H3 Z20.", 0),
        ("T2 M6\nG43 H1 Z20.\nG43 H1 Z10.", 1),
    ] {
        let shop = Shop::new().file("m.toml", &file).file("p.nc", program(words));
        let run = shop.run(["p.nc", "-o", "o.nc", "--machine", "m.toml"]).exits(0);
        assert_eq!(run.stderr.matches("warning[W0245]").count(), count, "{words}: {}", run.stderr);
    }
}

/// With a cutter of 20 mm, the left side of the contour Y0 is at Y10. Without a radius the tool center moves on the contour itself.
#[test]
fn a_radius_of_0_under_compensation_is_named() {
    let program = "%\nO1\nG21 G17 G90 G54\nT1 M6\nG43 H1 Z20.\nG0 X-20. Y-20.\nG1 Z-1. F100.\nG41 D1 X0. Y0.\nX100.\nG40 X120. Y-20.\nG0 Z50.\nM30\n%\n";
    let fanuc = GRUNDIG.replace("grundig", "fanuc");
    let bare = fanuc.replace("radius_mm = 5\n", "");
    let toa = "%_N_TO_TOA\n$TC_DP1[1,1]=120\n$TC_DP3[1,1]=100\nM17\n";
    let shop = Shop::new().file("m.toml", &bare).file("p.nc", program);
    shop.run(["p.nc", "-o", "o.nc", "--machine", "m.toml"]).exits(0).says("warning[W0247]").says("D1").says("line 8");
    assert!(!shop.run(["p.nc", "--review", "--machine", "m.toml"]).stdout.contains("nothing speaks against"));
    for (file, count) in [(fanuc.replace("radius_mm = 5", "radius_mm = 10"), 0), (bare.clone(), 1)] {
        let shop = Shop::new().file("m.toml", &file).file("p.nc", program);
        let run = shop.run(["check", "p.nc", "--machine", "m.toml"]).exits(0);
        assert_eq!(run.stdout.matches("W0247").count() + run.stderr.matches("W0247").count(), count, "{}", run.stdout);
    }
    let sinumerik = bare.replace("fanuc", "sinumerik");
    let part =
        "G17 G54 G90 G71 G64\nT1 D1\nM6\nG0 X-20 Y-20 Z20\nG1 Z-1 F100\nG41 X0 Y0\nX100\nG40 X120 Y-20\nG0 Z50\nM30\n";
    let shop = Shop::new().file("m.toml", sinumerik).file("p.mpf", part).file("to.toa", toa);
    shop.run(["p.mpf", "-o", "o.mpf", "--machine", "m.toml", "--setup", "to.toa"]).exits(0).says("warning[W0247]");
    // The control compensates with its own radius, which must be 0 plus wear: W0237 says so.
    let shop = Shop::new().file("m.toml", &bare).file("p.nc", program);
    let wear = shop.run(["p.nc", "-o", "o.nc", "--machine", "m.toml", "--compensation", "wear"]);
    assert!(!wear.stderr.contains("W0247"), "{}", wear.stderr);
}

/// A program that adds to its zero offset and does not take it back is corrected for one run only.
#[test]
fn an_offset_that_grows_from_run_to_run_is_named() {
    let moves = "G0 X0. Y0. Z20.\nG1 Z-1. F100.\nX40.\nG0 Z20.\n";
    let fanuc =
        |set: &str, end: &str| format!("%\nO1\nG21 G17 G90 G54\nT1 M6\n{set}G90 G54 G43 H1\n{moves}{end}M30\n%\n");
    let rs274 = |set: &str, end: &str| format!("G21 G17 G90 G54\nT1 M6 G43\n{set}G90 G54\n{moves}{end}M2\n");
    let sinumerik = |set: &str, end: &str| format!("G17 G54 G90 G71 G64\nT1 D1\nM6\n{set}G54\n{moves}{end}M30\n");
    let step = "$P_UIFR[1,X,TR]=$P_UIFR[1,X,TR]";
    let cases = [
        ("fanuc", fanuc("G91 G10 L2 P1 X10.\n", ""), Some("X by 10")),
        ("fanuc", fanuc("#5221=#5221+10.\n", ""), Some("X by 10")),
        ("fanuc", fanuc("G10 L2 P1 X[#5221+10.]\n", ""), Some("X by 10")),
        // Set to a number, taken back, or too little for the correction to change.
        ("fanuc", fanuc("G10 L2 P1 X10. Y0. Z0.\nG91 G10 L2 P1 X10.\n", ""), None),
        ("fanuc", fanuc("G91 G10 L2 P1 X10.\n", "G91 G10 L2 P1 X-10.\nG90\n"), None),
        ("fanuc", fanuc("G91 G10 L2 P1 X0.02\n", ""), None),
        ("rs274", rs274("G10 L2 P1 X[#5221+10]\n", ""), Some("X by 10")),
        ("rs274", rs274("#5222=[#5222-4]\n", ""), Some("Y by -4")),
        ("rs274", rs274("G10 L2 P1 X10\n", ""), None),
        ("sinumerik", sinumerik(&format!("{step}+10\n"), ""), Some("X by 10")),
        ("sinumerik", sinumerik(&format!("{step}+10\n"), &format!("{step}-10\n")), None),
        ("sinumerik", sinumerik(&format!("$P_UIFR[1,X,TR]=0\n{step}+10\n"), ""), None),
    ];
    for (language, program, words) in cases {
        let shop = Shop::new().file("m.toml", GRUNDIG.replace("grundig", language)).file("p.nc", &program);
        let args = ["check", "p.nc", "--machine", "m.toml", "--dialect", language];
        let run = shop.run(args).exits(0);
        let said = format!("{}{}", run.stdout, run.stderr);
        assert_eq!(said.contains("warning[W0246]"), words.is_some(), "{program}{said}");
        assert!(said.contains(words.unwrap_or_default()), "{program}{said}");
    }
}

/// LinuxCNC begins with the offset in force: G54 only after M2 and M30.
#[test]
fn an_offset_in_force_that_the_program_does_not_name_is_named() {
    let file = GRUNDIG.replace("grundig", "linuxcnc")
        + "[control]\nsaved_unit = \"mm\"\n[zero_offset.G55]\nX_mm = 200\nY_mm = 0\nZ_mm = 0\n";
    let program = |offset: &str| format!("G21 G90 G17 {offset}\nG0 X0 Y0 Z50\nG1 Z-2 F200\nG0 Z50\nM2\n");
    for (offset, in_force, count) in [("", 2, 1), ("", 1, 0), ("G54", 2, 0)] {
        let shop = Shop::new()
            .file("m.toml", &file)
            .file("lc.var", format!("5220\t{in_force}.000000\n5221\t0.000000\n5241\t200.000000\n"))
            .file("p.ngc", program(offset));
        let run = shop.run(["p.ngc", "-o", "o.ngc", "--machine", "m.toml", "--setup", "lc.var"]).exits(0);
        assert_eq!(run.stderr.matches("G55 in force").count(), count, "{offset} {in_force}: {}", run.stderr);
    }
}
