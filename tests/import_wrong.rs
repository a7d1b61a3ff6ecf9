//! `ncfix import`: files with wrong or missing data, and options that contradict the file, end in a question, a refusal or a warning.

use std::fmt::Write as _;

use crate::import::{import, shop};

/// A circle of the ball-bar, one reading per degree: angle, and 0.1 µm more for each ten degrees.
fn circle(head: &str, degrees: impl Iterator<Item = u32>) -> String {
    let mut text = format!("{head}Angle (deg);Run 1 CCW (µm)\n");
    for deg in degrees {
        let _ = writeln!(text, "{deg};{:.2}", f64::from(deg) / 100.0);
    }
    text
}

/// Options for a circle at a place of the machine.
const CENTER: &[&str] = &["--at", "X300,Y250,Z100", "--tool", "0"];

#[test]
fn an_option_that_contradicts_the_file_is_refused() {
    let head = "Test plane;XY\nTest radius (mm);150.0000\nFeedrate (mm/min);1000.0\n";
    let shop = shop().file("bar.csv", circle(head, 0..=360));
    // The words before the facts are understood.
    let run = import(&shop, "bar.csv", "tool.toml", CENTER).exits(0);
    assert!(run.stderr.contains("(line 2: Test radius (mm);150.0000)"), "{}", run.stderr);
    assert!(shop.text("out.toml").contains("length_mm = 150"), "{}", shop.text("out.toml"));
    import(&shop, "bar.csv", "tool.toml", &[CENTER, &["--radius", "150", "--feed", "1000"]].concat()).exits(0);
    for [option, value] in
        [["--radius", "100"], ["--feed", "2000"], ["--plane", "YZ"], ["--sign", "-"], ["--unit", "mm"]]
    {
        let run = import(&shop, "bar.csv", "tool.toml", &[CENTER, &[option, value]].concat());
        run.exits(4).says("E0618").says(&format!("{option}{}", if option == "--plane" { "" } else { " " }));
    }
    let center = format!("{head}Center X;300\n");
    let shop = shop.file("center.csv", circle(&center, 0..=360));
    import(&shop, "center.csv", "tool.toml", CENTER).exits(0);
    import(&shop, "center.csv", "tool.toml", &["--at", "X310,Y250,Z100", "--tool", "0"])
        .exits(4)
        .says("--at X310 contradicts the file");
    // Two lines that differ.
    let shop = shop.file("two.csv", circle(&format!("{head}Radius;100\n"), 0..=360));
    import(&shop, "two.csv", "tool.toml", CENTER).exits(4).says("lines 2 and 4");
}

/// A table of a laser with one run in both directions, 0 to 600 mm.
fn laser(head: &str, title: &str) -> String {
    let mut text = format!("{head}{title}\n");
    for k in 0..7 {
        let x = f64::from(100 * k);
        let _ = writeln!(text, "{x:.1};{:.2};{:.2}", 0.04 * x + 3.0, 0.04 * x - 3.1);
    }
    text
}

/// Options that answer the questions of a laser, without axis and unit.
const LASER: &[&str] = &["--at", "Y200,Z100", "--sign", "+", "--tool", "0"];

#[test]
fn the_material_and_the_component_of_a_laser_are_those_of_the_file() {
    let head = "Axis;X\nUnit;um\nMaterial temperature (°C);24.0\nExpansion coefficient (ppm/°C);11.7\n";
    let shop = shop().file("l.csv", laser(head, "Target [mm];1+;1-"));
    for state in ["20C", "11.7@24", "12@24.3"] {
        import(&shop, "l.csv", "tool.toml", &[LASER, &["--material", state]].concat()).exits(0);
    }
    for state in ["11.7@30", "23.8@24"] {
        import(&shop, "l.csv", "tool.toml", &[LASER, &["--material", state]].concat())
            .exits(4)
            .says("--material contradicts");
    }
    let component = |text: &str| {
        import(&shop, "l.csv", "tool.toml", &[LASER, &["--material", "20C", "--component", text]].concat())
    };
    component("EXX").exits(0);
    component("EZY").exits(4).says("E0618").says("--component EZY contradicts the file");
    let columns = ["--material", "20C", "--columns", "target [inch],1+,1-"];
    import(&shop, "l.csv", "tool.toml", &[LASER, &columns].concat())
        .exits(4)
        .says("E0618")
        .says("whose heading says mm");
    // The headings say "correction".
    let shop = shop.file("c.csv", "Axis;X\nTarget [mm];Correction [um]\n0;1.0\n100;2.0\n200;3.5\n");
    import(&shop, "c.csv", "tool.toml", &[LASER, &["--material", "20C"]].concat())
        .exits(4)
        .says("--sign + contradicts");
}
