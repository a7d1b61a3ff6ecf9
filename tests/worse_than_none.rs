//! Corrections that would make a machine worse: said, refused, and nothing is written.

use crate::support::{Shop, machine};

/// A cradle whose A axis is not parallel to X. A table for each axis over its own position knows nothing of what A does to Y and Z.
const CRADLE: &str = r#"
[machine]
name = "cradle"
topology = "wCAYFXZSt"
controller = "sinumerik"
[axis.X]
direction = [1, 0, 0]
travel_mm = [-150, 150]
[axis.Y]
direction = [0, -1, 0]
travel_mm = [-200, 200]
[axis.Z]
direction = [0, 0, 1]
travel_mm = [0, 200]
[axis.A]
direction = [-1, 0, 0]
travel_deg = [-100, 100]
[axis.C]
direction = [0, 0, -1]
travel_deg = [-360, 360]
[spindle]
axis = [0, 0, 1]
[location]
EB0A = 1000.0
EC0A = -800.0
"#;

/// A scale of 100 µm/m along X, and nothing else.
const SCALE: &str = r#"
[machine]
name = "scale"
topology = "wFXYZSt"
controller = "sinumerik"
[axis.X]
direction = [1, 0, 0]
travel_mm = [0, 500]
[axis.Y]
direction = [0, 1, 0]
travel_mm = [0, 300]
[axis.Z]
direction = [0, 0, 1]
travel_mm = [0, 300]
[spindle]
axis = [0, 0, 1]
[[motion]]
component = "EXX"
kind = "polynomial"
coefficients = [0, 1e-4]
"#;

/// A curved positioning error of X, and squarenesses that take most of it away in the corner where it is largest. A table of X alone leaves them there.
const OPPOSED: &str = r#"
[machine]
name = "opposed"
topology = "wFXYZSt"
controller = "fanuc"
[axis.X]
direction = [1, 0, 0]
travel_mm = [0, 300]
[axis.Y]
direction = [0, 1, 0]
travel_mm = [0, 200]
[axis.Z]
direction = [0, 0, 1]
travel_mm = [0, 100]
[spindle]
axis = [0, 0, 1]
[[motion]]
component = "EXX"
kind = "polynomial"
coefficients = [0, 4e-5, 6e-8]
[location]
EC0Y = 60.0
EB0Z = -80.0
"#;

/// A positioning error of X that is large only in the middle of Y, where a table of X is taken, and has the other sign elsewhere: 60 µm at X 300, Y 100, and
/// −30 µm at X 300, Y 0 and Y 200.
const PEAK: &str = r#"
[machine]
name = "peak"
topology = "wFXYZSt"
controller = "fanuc"
[axis.X]
direction = [1, 0, 0]
travel_mm = [0, 300]
[axis.Y]
direction = [0, 1, 0]
travel_mm = [0, 200]
[axis.Z]
direction = [0, 0, 1]
travel_mm = [0, 100]
[spindle]
axis = [0, 0, 1]
[[motion]]
component = "EXX"
kind = "grid"
positions_mm = [0, 300]
with = "Y"
with_positions_mm = [0, 90, 100, 110, 200]
values_um = [[0, 0, 0, 0, 0], [-30, -30, 60, -30, -30]]
"#;

const TABLES: [&str; 6] = ["tables", "--machine", "m.toml", "--format", "cec", "-o"];

#[test]
fn tables_that_make_it_worse_are_not_written() {
    let shop = Shop::new().file("m.toml", PEAK);
    let with = |more: &[&'static str]| {
        let words = ["tables", "--machine", "m.toml", "--format", "pitch", "--scheme", "own", "-o", "t.csv"];
        shop.run(words.iter().chain(more).copied())
    };
    with(&[]).exits(4).says("error[E0903]").says("the tables would increase the error");
    assert_eq!(shop.names(), ["m.toml"]);
    // An old file stays, and JSON has the diagnostic.
    std::fs::write(shop.path("t.csv"), "old").unwrap();
    let run = with(&["--json"]).exits(4);
    assert!(run.stdout.contains("E0903") && run.stdout.contains("\"written\":[]"), "{}", run.stdout);
    assert_eq!(shop.text("t.csv"), "old");
    // If only a constant opposes the table, the next touched zero takes it away: the table is written, and says so.
    std::fs::write(shop.path("m.toml"), OPPOSED).unwrap();
    with(&[]).exits(0);
    assert!(shop.text("t.csv").contains("touch off every zero again"), "{}", shop.text("t.csv"));
}

#[test]
fn tables_with_the_wrong_sign_are_not_converted() {
    let shop = Shop::new().file("m.toml", SCALE);
    shop.run(TABLES.iter().chain(&["t.ini", "--scheme", "own"]).copied()).exits(0);
    let read = ["tables", "--read", "t.ini", "--machine", "m.toml", "--format", "comp", "-o", "t.comp"];
    shop.run(read).exits(0);
    std::fs::remove_file(shop.path("t-x.comp")).unwrap();
    // Every value with the other sign: 100 µm/m become 200.
    let turned: String = shop.text("t.ini").lines().map(|line| line.replace("]=-0.", "]=0.") + "\n").collect();
    let turned = if turned == shop.text("t.ini") { turned.replace("]=0.", "]=-0.") } else { turned };
    let is_axis = |line: &str| line.contains("STEP") || line.contains("MIN") || line.contains("MAX");
    assert!(turned.lines().zip(shop.text("t.ini").lines()).all(|(one, other)| !is_axis(one) || one == other));
    std::fs::write(shop.path("t.ini"), turned).unwrap();
    shop.run(read).exits(4).says("error[E0903]");
    assert_eq!(shop.names(), ["m.toml", "t.ini"]);
    // To look at them is no harm.
    shop.run(["tables", "--read", "t.ini", "--machine", "m.toml", "--check"]).exits(0);
}

#[test]
fn a_correction_coarser_than_the_error_is_refused() {
    let shop = Shop::new().file(
        "part.mpf",
        "N10 G17 G90 G71 G94\nN20 G54 G0 X0 Y0 Z50\nN30 G1 X100.03 Y50.02 F500\nN40 X31.07 Y77.04\nN50 M30\n",
    );
    let demo = machine("demo");
    let with = |more: &[&str]| {
        let first = ["part.mpf", "-o", "out.mpf", "--machine", demo.as_str()];
        shop.run(first.iter().chain(more).copied())
    };
    // On a grid of 0.1 mm the ends alone are off by up to 0.05 mm; the machine is off by some micrometers.
    with(&["--increment", "0.1mm"]).exits(4).says("error[E0904]");
    assert_eq!(shop.names(), ["part.mpf"]);
    with(&[]).exits(0);
}

#[test]
fn measured_has_the_limit_of_fix() {
    // X stands 500 µm off at 5 m: beyond 0.2 mm a correction is a wrong unit.
    let far = SCALE.replace("travel_mm = [0, 500]", "travel_mm = [0, 9000]");
    let shop = Shop::new().file("m.toml", far).file("read.csv", "X,Y,Z\n1000,0,0\n5000,0,0\n9000,0,0\n");
    let with = |more: &[&'static str]| {
        shop.run(["correct-readings", "read.csv", "-o", "out.csv", "--machine", "m.toml"].iter().chain(more).copied())
    };
    let run =
        with(&[]).exits(4).says("error[E0303]: the correction of X is").says("read.csv:3:1").says("also in line 4");
    assert!(!run.stderr.contains("read.csv:2:"), "{}", run.stderr);
    assert_eq!(shop.names(), ["m.toml", "read.csv"]);
    with(&["--max-correction", "95um"]).exits(4).says("read.csv:2:1");
    with(&["--max-correction", "1mm"]).exits(0);
    assert!(shop.names().contains(&"out.csv".to_owned()));
}

#[test]
fn a_rotary_reading_is_judged_by_its_arc() {
    // A is off by 1000 µrad in every pose where its scale has an error of 1e-3 rad per rad: at 57.3 degrees by 1 mrad. The arc at 300 mm is 0.3 mm.
    let rotary = CRADLE.replace("EB0A = 1000.0\nEC0A = -800.0\n", "EA0Z = 0.0\n")
        + "[[motion]]\ncomponent = \"EAA\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-3]\n";
    let shop = Shop::new()
        .file("m.toml", rotary)
        .file("read.csv", "X,Y,Z,A,C,tool_x_mm,tool_y_mm,tool_z_mm\n0,0,0,57.29578,0,0,0,-300\n");
    let with =
        |limit| shop.run(["correct-readings", "read.csv", "-o", "o", "--machine", "m.toml", "--max-correction", limit]);
    with("0.29mm").exits(4).says("error[E0303]");
    with("0.32mm").exits(0);
}

/// A table that moves an axis by micrometers meets a slightly different angular error there: that is no reason to refuse it.
#[test]
fn a_grid_for_a_machine_whose_angles_no_table_changes_is_written() {
    let shop = Shop::new();
    let vmc = machine("vmc");
    let arguments = [
        "tables",
        "--machine",
        &vmc,
        "--format",
        "fanuc",
        "--scheme",
        "grid",
        "--tolerance",
        "3um",
        "--tool",
        "110",
        "-o",
        "GRID.csv",
    ];
    shop.run(arguments).exits(0);
    assert!(shop.text("GRID.csv").lines().count() > 10);
}
