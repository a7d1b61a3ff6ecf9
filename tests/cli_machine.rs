//! `ncfix machine check`, `ncfix machine show` and `ncfix machine presets`.

use crate::support::{Shop, machine};

#[test]
fn sample_machines_have_no_errors() {
    for name in ["demo", "esmaeili_xyz5", "esmaeili_huron"] {
        let run = Shop::new().run(["machine", "check", &machine(name)]).exits(0);
        assert!(run.stderr.contains("no errors or warnings"), "{}", run.stderr);
    }
}

#[test]
fn a_machine_is_shown() {
    let run = Shop::new().run(["machine", "show", &machine("esmaeili_xyz5")]).exits(0);
    for text in ["wCBXFZYSt", "zero offset", "errors"] {
        assert!(run.stdout.contains(text), "{text}: {}", run.stdout);
    }
}

#[test]
fn faults_of_a_machine_file_have_their_place() {
    let shop = Shop::new().file(
        "m.toml",
        "[machine]\nname = \"m\"\ntopology = \"wFXt\"\ncolour = 3\n\n[axis.X]\ndirection = [1, 0, 0]\n",
    );
    let run = shop.run(["machine", "check", "m.toml"]).exits(4);
    run.says("error[E0402]").says("m.toml:4:1");
}

#[test]
fn a_controller_must_be_a_dialect() {
    let text = "[machine]\nname = \"m\"\ntopology = \"wFXt\"\ncontroller = \"latin\"\n\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 1]\n";
    Shop::new().file("m.toml", text).run(["machine", "check", "m.toml"]).exits(4).says("'latin'");
}

#[test]
fn a_set_up_file_brings_offsets_and_tools() {
    let setup = "[zero_offset.G54]\nX_mm = 123.5\nY_mm = 1\nZ_mm = 2\n";
    let shop = Shop::new().file("s.toml", setup);
    let run = shop.run(["machine", "show", &machine("demo"), "--setup", "s.toml"]).exits(0);
    assert!(run.stdout.contains("G54   X123.5 Y1 Z2"), "{}", run.stdout);
}

#[test]
fn presets_are_listed() {
    let run = Shop::new().run(["machine", "presets"]).exits(0);
    for name in ["spaan-18", "spaan-21", "mayer-13", "84", "12", "81", "10"] {
        assert!(run.stdout.lines().any(|line| line.starts_with(&format!("{name} "))), "{name}: {}", run.stdout);
    }
    assert!(run.stdout.contains("Tables 4-3 and 7-1") && run.stderr.is_empty(), "{}", run.stdout);
    // On a machine: how many parameters, or why none.
    let run = Shop::new().run(["machine", "presets", "--machine", &machine("esmaeili_xyz5")]).exits(0);
    for (name, count) in [("mayer-13", "13"), ("84", "84"), ("81", "81"), ("12", "12"), ("10", "10")] {
        let line = run.stdout.lines().find(|line| line.starts_with(&format!("{name} "))).unwrap();
        assert_eq!(line.split_whitespace().nth(1), Some(count), "{line}");
    }
    let run = Shop::new().run(["machine", "presets", "--machine", &machine("demo")]).exits(0);
    assert!(run.stdout.contains("not applicable: it is for machines with two rotary axes"), "{}", run.stdout);
}

#[test]
fn a_preset_shows_its_parameters_and_what_else_the_file_has() {
    // Table 4-3: EX0C = -0.0956 mm, EA0Y = -0.000038 rad, EYY1 = -0.000023 mm/mm.
    let run = Shop::new().run(["machine", "presets", "mayer-13", "--machine", &machine("esmaeili_xyz5")]).exits(0);
    let row = |stdout: &str, name: &str| -> Vec<String> {
        let line = stdout.lines().find(|line| line.starts_with(&format!("{name} ")));
        line.unwrap_or_else(|| panic!("{name}: {stdout}")).split_whitespace().skip(1).map(str::to_owned).collect()
    };
    assert_eq!(row(&run.stdout, "EX0C"), ["-95.60", "µm"]);
    assert_eq!(row(&run.stdout, "EA0Y"), ["-38.00", "µrad"]);
    assert_eq!(row(&run.stdout, "EYY1"), ["-2.300e-2", "µm/mm"]);
    assert!(run.stdout.contains("no other errors"), "{}", run.stdout);
    // 10 lacks the spindle offsets and the gain of X.
    let run = Shop::new().run(["machine", "presets", "10", "--machine", &machine("esmaeili_xyz5")]).exits(0);
    let (own, others) = run.stdout.split_once("The file also has:").unwrap();
    assert_eq!(row(others, "EX0S"), ["-100.0", "µm"]);
    assert_eq!(row(others, "EXX1"), ["1.700e-2", "µm/mm"]);
    assert!(!own.contains("EX0S") && !others.contains("EYY1"), "{}", run.stdout);
    // Functions that are no parameters are named with their kind.
    let run = Shop::new().run(["machine", "presets", "spaan-21", "--machine", &machine("demo")]).exits(0);
    assert!(run.stdout.contains("The file also has:"), "{}", run.stdout);
}

#[test]
fn a_preset_that_makes_no_sense_says_why() {
    let run = Shop::new().run(["machine", "presets", "mayer-13", "--machine", &machine("demo")]).exits(2);
    run.says("mayer-13").says("two rotary axes, and this one has none");
    Shop::new().run(["machine", "presets", "13", "--machine", &machine("demo")]).exits(2).says("mayer-13, 84, 12");
}

/// A five-axis machine whose errors are constants: 20 µm of X, and C offset by 80 µm: the tip is off by as much at every pose.
const CONSTANT: &str = "[machine]\nname = \"m\"\ntopology = \"wCBFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-200, 200]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-200, 200]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-200, 200]\n[axis.B]\ndirection = [0, -1, 0]\ntravel_deg = [-90, 90]\n\
    [axis.C]\ndirection = [0, 0, -1]\n[spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0.02]\n[location]\nEX0C = 80\n";

/// Lei and Hsu 2003, ch. 5, have 80 % from the rotary axes and 20 % from the linear ones.
#[test]
fn the_share_of_the_rotary_axes_is_shown() {
    let shop = Shop::new().file("m.toml", CONSTANT);
    let shown = shop.run(["machine", "show", "m.toml"]).exits(0).stdout;
    let row = |name: &str| -> Vec<String> {
        let line = shown.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name}: {shown}"));
        line.split_whitespace().skip_while(|word| word.parse::<f64>().is_err()).map(str::to_owned).collect()
    };
    assert_eq!(row("rotary axes"), ["80.0", "µm", "80", "%"]);
    assert_eq!(row("linear axes"), ["20.0", "µm", "20", "%"]);
    // One group has no share to show.
    let alone = CONSTANT.replace("EX0C = 80", "EX0C = 0");
    let shown = Shop::new().file("m.toml", alone).run(["machine", "show", "m.toml"]).exits(0).stdout;
    assert!(!shown.contains("share of the tip error"), "{shown}");
}

/// Esmaeili 2021, Table 7-2: EZOS 55.6 → -7.4 µm, a ratio of -0.13; eq. 38: (55.6 - 7.4) / 55.6 = 87 %.
#[test]
fn what_is_left_of_each_parameter_is_shown() {
    let file = |ey0s: f64, eb0z: f64| {
        let text = std::fs::read_to_string(machine("esmaeili_huron")).unwrap();
        text.replace("EY0S = 55.6", &format!("EY0S = {ey0s}")).replace("EB0Z = 22.0", &format!("EB0Z = {eb0z}"))
    };
    let shop = Shop::new().file("before.toml", file(55.6, 22.0)).file("after.toml", file(-7.4, 39.0));
    let words = ["machine", "presets", "mayer-13", "--machine", "before.toml", "--after", "after.toml"];
    let shown = shop.run(words).exits(0).stdout;
    for (name, ratio, removed) in [("EY0S", "-0.13", "87"), ("EB0Z", "1.77", "-77"), ("EXX1", "1.00", "0")] {
        let line = shown.lines().find(|line| line.starts_with(name)).unwrap();
        let cells: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(cells[cells.len() - 3..], [ratio, removed, "%"], "{shown}");
    }
    shop.run(["machine", "presets", "--after", "after.toml"]).exits(2);
}
