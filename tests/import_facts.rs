//! `ncfix import`: a column that states what the readings of a row are is used, or the file is refused; it is never passed over in silence.

use std::fmt::Write as _;

use crate::import::{import, shop};
use crate::support::Shop;

/// Where the ball-bar stood.
const PLACE: [&str; 6] = ["--at", "X300,Y250,Z100", "--tool", "0", "--turn", "ccw"];

/// Two circles with a column of their own; the bar is longer by the cosine of twice the angle, µm.
fn circles(heading: &str, values: [&str; 2]) -> String {
    let mut text = format!("radius_mm;100\nfeed_mm_min;1000\nrun;{heading};angle_deg;dev_um\n");
    for (run, value) in (1..).zip(values) {
        for k in 0..36 {
            let deg = 10.0 * f64::from(k) + 0.5;
            let _ = writeln!(text, "{run};{value};{deg};{:.3}", (2.0 * deg).to_radians().cos() + 0.01 * f64::from(run));
        }
    }
    text
}

fn put(shop: &Shop, name: &str, text: &str) {
    std::fs::write(shop.path(name), text).unwrap();
}

/// Rows of XY and YZ in one table were all taken for XY. The second row of the file with YZ is line 40: three lines, and 36 of XY.
#[test]
fn circles_of_two_planes_are_no_circles_of_one() {
    let shop = shop();
    for heading in ["plane", "Ebene", "Kreisebene", "piano di prova", "plan du cercle"] {
        put(&shop, "bar.csv", &circles(heading, ["XY", "YZ"]));
        for more in [&[][..], &["--plane", "XY"]] {
            let run = import(&shop, "bar.csv", "tool.toml", &[&PLACE[..], more].concat()).exits(4);
            run.says("E0618").says("'xy' (line 4), 'yz' (line 40)").says(&format!("the column '{heading}'"));
            assert!(!shop.path("out.csv").exists(), "{heading}");
        }
    }
    // The same plane in all rows is the plane of the file: a point at 90° from Y is above the center.
    put(&shop, "bar.csv", &circles("plane", ["YZ", "YZ"]));
    import(&shop, "bar.csv", "tool.toml", &PLACE).exits(0);
    let table = shop.text("out.csv");
    let [x, y, z] = [0, 1, 2].map(|k| {
        let heading = ["X", "Y", "Z"][k];
        let column = table.lines().next().unwrap().split(',').position(|own| own == heading).unwrap();
        let cells = table.lines().skip(1).map(move |line| line.split(',').nth(column).unwrap().parse::<f64>().unwrap());
        cells.fold([f64::MAX, f64::MIN], |[low, high], own| [low.min(own), high.max(own)])
    });
    assert!(x == [300.0; 2], "{x:?}");
    // The radius is 100 mm, and the nearest angle to an axis is 0.5° away.
    for ([low, high], center) in [(y, 250.0), (z, 100.0)] {
        assert!((low - center + 100.0).abs() < 0.01 && (high - center - 100.0).abs() < 0.01, "{low} {high}");
    }
    import(&shop, "bar.csv", "tool.toml", &[&PLACE[..], &["--plane", "XY"]].concat())
        .exits(4)
        .says("--plane contradicts");
}

#[test]
fn bars_of_two_lengths_and_feeds_are_no_measurement() {
    let shop = shop();
    let head = "radius_mm;100\nfeed_mm_min;1000\n";
    for (heading, values) in [
        ("bar length", ["100", "150"]),
        ("Radius", ["100", "150"]),
        ("Feed", ["1000", "3000"]),
        ("side", ["left", "right"]),
    ] {
        let text = circles(heading, values).replace(head, "plane;XY\nradius_mm;100\nfeed_mm_min;1000\n");
        put(&shop, "bar.csv", &text);
        import(&shop, "bar.csv", "tool.toml", &PLACE).exits(4).says("E0618").says(&format!("'{heading}'"));
        // A column that the person calls without effect is not read.
        let columns = ["--columns", "run,-,angle,dev um"];
        import(&shop, "bar.csv", "tool.toml", &[&PLACE[..], &columns].concat()).exits(0);
    }
    // One length in all rows is that of the bar.
    put(&shop, "bar.csv", &circles("bar length [mm]", ["150", "150"]).replace(head, "plane;XY\n"));
    import(&shop, "bar.csv", "tool.toml", &PLACE).exits(0);
    assert!(shop.text("out.toml").contains("length_mm = 150"), "{}", shop.text("out.toml"));
    import(&shop, "bar.csv", "tool.toml", &[&PLACE[..], &["--radius", "100"]].concat()).exits(4).says("--radius 100");
}

/// A line before the table states the direction of all circles. With angles that only ascend, nothing else does.
#[test]
fn a_line_with_the_direction_of_the_circles_counts() {
    let shop = shop();
    let place = &PLACE[..4];
    let file = |line: &str| circles("remark", ["", ""]).replace("radius_mm", &format!("plane;XY\n{line}radius_mm"));
    put(&shop, "bar.csv", &file(""));
    import(&shop, "bar.csv", "tool.toml", place).exits(4).says("--turn");
    let first = |line: &str| {
        put(&shop, "bar.csv", &file(line));
        import(&shop, "bar.csv", "tool.toml", place).exits(0);
        let table = shop.text("out.csv");
        let column = table.lines().next().unwrap().split(',').position(|own| own == "run").unwrap();
        table.lines().nth(1).unwrap().split(',').nth(column).unwrap().to_owned()
    };
    assert_eq!(first("Direction;CCW\n"), "1-ccw");
    assert_eq!(first("Drehrichtung;CW\n"), "1-cw");
    put(&shop, "bar.csv", &file("Direction;CCW\n"));
    import(&shop, "bar.csv", "tool.toml", &[place, &["--turn", "cw"]].concat()).exits(4).says("--turn cw contradicts");
}

/// Options for a table of a laser.
const LASER: [&str; 8] = ["--sign", "+", "--tool", "0", "--material", "20C", "--unit", "um"];

/// Six targets on each of two lines: 4 µm more at each target.
fn lines(head: &str, row: impl Fn(usize, usize) -> String) -> String {
    let rows = (0..2).flat_map(|line| (0..6).map(move |k| (line, k)));
    rows.fold(format!("{head}\n"), |text, (line, k)| format!("{text}{};{}\n", row(line, k), 4 * k + line))
}

/// A heading of several words is a column of axes like `Axis`.
#[test]
fn a_column_of_the_axis_may_have_several_words() {
    let shop = shop();
    for heading in ["Linear axis", "Measured axis", "Linearachse", "Axe mesuré", "Asse lineare", "Eje lineal"] {
        let head = format!("{heading};Run;Direction;Target [mm];Deviation [um]");
        let two = |line: usize, k: usize| format!("{};1;+;{}", ["X", "Y"][line], 100 * k);
        put(&shop, "laser.csv", &lines(&head, two));
        let more = [&LASER[..], &["--axis", "X", "--at", "Y200,Z100"]].concat();
        let run = import(&shop, "laser.csv", "tool.toml", &more).exits(4);
        run.says("E0618").says("'x' (line 2), 'y' (line 8)");
        // One axis in all rows is the axis of the file.
        put(&shop, "laser.csv", &lines(&head, |line, k| format!("Y;{};+;{}", line + 1, 80 * k)));
        import(&shop, "laser.csv", "tool.toml", &[&LASER[..], &["--at", "X300,Z100"]].concat()).exits(0);
        assert!(shop.text("out.csv").contains("EYY"), "{}", shop.text("out.csv"));
        import(&shop, "laser.csv", "tool.toml", &more).exits(4).says("contradicts the file");
    }
}

/// A second column of positions: readings of X along two lines at Y 100 and Y 300 are no single line, and one Y in all rows is its position.
#[test]
fn positions_of_the_other_axes_are_read() {
    let shop = shop();
    put(&shop, "laser.csv", &lines("X [mm];Y [mm];dev [um]", |line, k| format!("{};{}", 100 * k, 100 + 200 * line)));
    import(&shop, "laser.csv", "tool.toml", &[&LASER[..], &["--at", "Z100"]].concat())
        .exits(4)
        .says("E0618")
        .says("Y is not at one place: its column goes from 100 to 300");
    put(&shop, "laser.csv", &lines("Y [mm];X [mm];dev [um]", |line, k| format!("250;{}", 100 * k + line)));
    import(&shop, "laser.csv", "tool.toml", &[&LASER[..], &["--at", "Z100"]].concat()).exits(0);
    let table = shop.text("out.csv") + &shop.text("out.toml");
    assert!(table.contains("EXX") && table.contains("250"), "{table}");
    import(&shop, "laser.csv", "tool.toml", &[&LASER[..], &["--at", "Y0,Z100"]].concat())
        .exits(4)
        .says("--at Y0 contradicts the column Y of the file: 250");
}

/// All kinds of files with rows of two groups: a column that divides them is never only listed.
#[test]
fn a_column_that_divides_the_rows_is_never_passed_over() {
    let shop = shop();
    let touches = || {
        let sides = [(10, 0, 0), (-10, 0, 0), (0, 10, 0), (0, -10, 0), (0, 0, 10)];
        let of_ball = |(name, x, side): (&str, i32, &str)| {
            sides.map(|(dx, dy, dz)| format!("{name};{};{};{};{side}\n", x + dx, 100 + dy, 50 + dz)).concat()
        };
        [("b1", 100, "one"), ("b2", 200, "two")].map(of_ball).concat()
    };
    let list = "0;0;0;1;one\n100;0;0;2;one\n200;0;0;3;two\n300;0;0;5;two\n";
    for heading in ["setup", "Aufspannung", "side", "sign", "fixture"] {
        let files = [
            ("touches.csv", format!("ball;X;Y;Z;{heading}\n{}", touches()), &["--tool", "0", "--unit", "mm"][..]),
            ("list.csv", format!("X;Y;Z;dx [um];{heading}\n{list}"), &["--tool", "0", "--sign", "+"]),
            (
                "laser.csv",
                lines(&format!("{heading};Target [mm];Deviation [um]"), |line, k| {
                    format!("{};{}", ["one", "two"][line], 100 * k)
                }),
                &["--axis", "X", "--sign", "+", "--tool", "0", "--material", "20C", "--at", "Y200,Z100"],
            ),
            (
                "wide.csv",
                lines(&format!("Target [mm];{heading};1+ [um]"), |line, k| {
                    format!("{};{}", 100 * k + 50 * line, ["one", "two"][line])
                }),
                &["--axis", "X", "--sign", "+", "--tool", "0", "--material", "20C", "--at", "Y200,Z100"],
            ),
        ];
        for (name, text, more) in files {
            put(&shop, name, &text);
            let run = import(&shop, name, "tool.toml", more).exits(4);
            run.says("E0618").says(&format!("the column '{heading}' is not read")).says("'one'");
        }
    }
    // A report of features says where each of them is; only the set-up is no property of a feature.
    let report = "name;nom x;nom y;act x;act y;setup\nA;0;0;0.01;0.02;1\nB;100;0;100.01;0.03;1\nC;0;100;0.02;100.05;2\nD;100;100;100.01;100.04;2\n";
    put(&shop, "report.csv", report);
    let more = ["--at", "X100,Y100,Z0", "--sign", "+", "--tool", "0", "--material", "20C", "--unit", "mm"];
    import(&shop, "report.csv", "tool.toml", &more).exits(4).says("E0618").says("'setup'");
}

/// A column `Messwert` in µm beside targets in mm has deviations: 4 µm more at each target.
#[test]
fn measured_values_in_another_unit_are_deviations() {
    let shop = shop();
    let more = [&LASER[..4], &["--material", "20C", "--axis", "X", "--at", "Y200,Z100"]].concat();
    for heading in ["Ziel [mm];Messwert [µm]", "Soll [mm];Ist [µm]", "Ziel in mm;Positionsabweichung in µm"] {
        put(&shop, "laser.csv", &lines(heading, |line, k| format!("{}", 100 * k + 10 * line)));
        let run = import(&shop, "laser.csv", "tool.toml", &more).exits(0);
        let text = shop.text("out.csv");
        assert!(text.contains("500") && text.contains(",20"), "{heading}: {}\n{text}", run.stdout);
    }
    // Positions of the laser in the unit of the targets stay positions.
    put(&shop, "laser.csv", &{
        let rows: String = (0..6).map(|k| format!("{};{}.00{k}\n", 100 * k, 100 * k)).collect();
        format!("Ziel [mm];Messwert [mm]\n{rows}")
    });
    import(&shop, "laser.csv", "tool.toml", &more).exits(0);
    assert!(shop.text("out.csv").contains(",5"), "{}", shop.text("out.csv"));
}

/// OK and NG follow from the readings, and a remark belongs to its own row.
#[test]
fn a_verdict_of_a_tolerance_divides_nothing() {
    let shop = shop();
    let row = |line: usize, k: usize| format!("{};{};{}", 100 * k + 50 * line, if k > 3 { "NG" } else { "OK" }, k % 2);
    put(&shop, "laser.csv", &lines("Target [mm];status;flag;Deviation [um]", row));
    let more = [&LASER[..], &["--axis", "X", "--at", "Y200,Z100"]].concat();
    let run = import(&shop, "laser.csv", "tool.toml", &more).exits(0);
    assert!(run.stderr.contains("columns that are not read: status"), "{}", run.stderr);
}

/// Three tables of a laser in one file: each is named with its rows.
#[test]
fn several_tables_in_one_file_are_named_with_their_lines() {
    let table = |axis: &str| format!("Axis;{axis}\nTarget [mm];1+ [um];1- [um]\n0;0;1\n100;2;3\n200;4;6\n\n");
    let shop = shop().file("three.csv", ["X", "Y", "Z"].map(table).concat());
    let run = import(&shop, "three.csv", "tool.toml", &[]).exits(4);
    run.says("E0601").says("rows are in the lines 3 to 5, 9 to 11, 15 to 17");
}

/// The unit of a report with one row for each feature may be in a column.
#[test]
fn a_column_of_units_counts_in_a_report_of_features() {
    let shop = shop();
    let report =
        "name;nom x;nom y;act x;act y;unit\nA;0;0;0.01;0.02;mm\nB;100;0;100.01;0.03;mm\nC;0;100;0.02;100.05;mm\n";
    put(&shop, "report.csv", report);
    let more = ["--at", "X100,Y100,Z0", "--sign", "+", "--tool", "0", "--material", "20C"];
    import(&shop, "report.csv", "tool.toml", &more).exits(0);
    import(&shop, "report.csv", "tool.toml", &[&more[..], &["--unit", "inch"]].concat())
        .exits(4)
        .says("--unit inch contradicts");
}

/// Positions for all files of a folder: X 300 is where X stood while Y moved, and would shift the targets of the file in which X moved.
#[test]
fn a_common_position_does_not_shift_the_targets_of_an_axis_that_moved() {
    let table = |axis: &str| format!("Axis;{axis}\nTarget [mm];1+ [um];1- [um]\n0;0;1\n100;2;3\n200;4;6\n");
    let shop = shop().file("exports/lx.csv", table("X")).file("exports/ly.csv", table("Y"));
    let folder = |at: &[&'static str]| {
        let words = ["import", "exports", "--machine", "tool.toml", "-o", "read", "--force"];
        let all = words.into_iter().chain(["--sign", "+", "--tool", "0", "--material", "20C"]);
        shop.run(all.chain(at.iter().flat_map(|at| ["--at", at])))
    };
    let run = folder(&["X300,Y200,Z100"]).exits(4);
    run.says("E0618").says("X moved in lx.csv, so X300 of --at would shift its targets by 300").says("--at lx=");
    assert!(!shop.path("read").exists());
    folder(&["lx=Y200,Z100", "ly=X300,Z100"]).exits(0);
    assert!(shop.text("read/lx.csv").contains("200"), "{}", shop.text("read/lx.csv"));
    // For one file alone, the position is that of target 0.
    folder(&["lx=X300,Y200,Z100", "ly=X300,Z100"]).exits(0);
    assert!(shop.text("read/lx.csv").contains("500"), "{}", shop.text("read/lx.csv"));
}
