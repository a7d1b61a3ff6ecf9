//! Programs and measurements as other people have them: cases found with files that were not made for these tests.

use std::fmt::Write as _;

use crate::import::Noise;
use crate::support::{Run, Shop};

/// A mill with X, Y, Z on the tool side, and a rotary table about X.
fn mill(controller: &str) -> String {
    let mut text = format!("[machine]\nname = \"m\"\ntopology = \"wAFXYZSt\"\ncontroller = \"{controller}\"\n");
    for (letter, direction) in [("X", "[1, 0, 0]"), ("Y", "[0, 1, 0]"), ("Z", "[0, 0, 1]")] {
        let _ = write!(text, "\n[axis.{letter}]\ndirection = {direction}\ntravel_mm = [-600, 600]\n");
    }
    text + "\n[axis.A]\ndirection = [1, 0, 0]\npoint_mm = [0, 0, 0]\ntravel_deg = [-3600, 3600]\n\n\
            [zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n\n[[tool]]\nnumber = 1\nlength_mm = 100\n"
}

/// Motions of a program, one text for each.
fn snc(controller: &str, program: &str) -> Run {
    let shop = Shop::new().file("m.toml", mill(controller)).file("p.nc", program);
    shop.run(["snc", "p.nc", "--machine", "m.toml"])
}

fn motions(controller: &str, program: &str) -> Vec<String> {
    let run = snc(controller, program).exits(0);
    run.stdout
        .lines()
        .filter(|line| line.starts_with("G0 ") || line.starts_with("G1 "))
        .map(|line| line.split(" ;").next().unwrap_or(line).to_owned())
        .collect()
}

#[test]
fn a_table_turns_before_the_drill_descends() {
    // Fanuc, canned cycles: the first operation positions all axes but that of the drill, at the level where the tool is.
    for (controller, block) in [("fanuc", "A45."), ("fanuc", "X5. A45."), ("haas", "A45."), ("fanuc", "X5. Y0. A45.")] {
        for cycle in ["G81 Z-5. R2. F100.", "G83 Z-5. R2. Q2. F100.", "G85 Z-5. R2. F100."] {
            let program = format!(
                "%\nO1\nG21 G90 G17 G40 G54\nT1 M6\nG0 X5. Y0. A0.\nS1000 M3\nG43 Z10. H1\nG99 {cycle}\n{block}\nG80\nM30\n%\n"
            );
            let all = motions(controller, &program);
            let word = |line: &str, letter: char| {
                line.split(' ').find_map(|word| word.strip_prefix(letter)).unwrap_or_default().to_owned()
            };
            let mut turned = 0;
            for pair in all.windows(2) {
                if word(&pair[0], 'A') != word(&pair[1], 'A') {
                    assert!(pair[1].starts_with("G0 "), "{controller} {cycle} {block}: {all:?}");
                    assert_eq!(word(&pair[0], 'Z'), word(&pair[1], 'Z'), "{controller} {cycle} {block}: {all:?}");
                    turned += 1;
                }
            }
            assert!(turned == 1 && all.last().is_some_and(|line| word(line, 'A') == "45"), "{all:?}");
        }
    }
}

#[test]
fn repeated_holes_with_an_incremental_table_are_refused() {
    // With L3 the control turns before each hole; three strokes into one hole would break the tool.
    for (controller, count) in [("fanuc", "K3"), ("haas", "L3")] {
        let program = |block: &str| {
            format!(
                "%\nO1\nG21 G90 G17 G40 G54\nT1 M6\nG0 X5. Y0. A0.\nS1000 M3\nG43 Z10. H1\nG99 G81 Z-5. R2. F100.\n{block}\nG90 G80\nM30\n%\n"
            )
        };
        snc(controller, &program(&format!("G91 A30. {count}"))).exits(3).says("E0201").says("a block for each hole");
        snc(controller, &program("G91 A30.")).exits(0);
        snc(controller, &program(&format!("G91 X2. {count}"))).exits(0);
    }
}

#[test]
fn a_haas_ends_the_tool_length_with_g28() {
    let program = |more: &str| {
        format!("%\nO1\nG21 G90 G17 G40 G54\nT1 M6\nG0 X0. Y0. A0.\nG43 Z50. H1\nG28 Z60.\n{more}\nM30\n%\n")
    };
    snc("haas", &program("G0 Z100.")).exits(3).says("E0201").says("ends the tool length compensation");
    for more in ["G43 H1 Z100.", "G49 G0 Z100.", "G53 G0 Z0", "G0 X10."] {
        snc("haas", &program(more)).exits(0);
    }
    snc("fanuc", &program("G0 Z100.")).exits(0);
}

#[test]
fn control_words_of_a_fanuc_may_have_two_letters() {
    let long = "%\nO1\n#1=0\nWHILE[#1LT3]DO1\n#1=#1+1\nEND1\nIF[#1EQ3]GOTO9\nG90 G54 G0 X1.\nN9 M30\n%\n";
    let short = long.replace("WHILE", "WH").replace("GOTO", "GO");
    let [one, other] = [long, &short].map(|program| snc("fanuc", program).exits(0).stdout);
    assert_eq!(one.lines().filter(|line| line.starts_with('G')).count(), 0, "{one}");
    assert_eq!(one.lines().count(), other.lines().count(), "{other}");
}

/// A printer whose Z axis carries the probe.
fn printer() -> String {
    mill("rs274").replace("wAFXYZSt", "wFXYZSt").split("\n[axis.A]").next().unwrap_or_default().to_owned()
}

#[test]
fn a_height_map_of_a_duet_gives_straightness_and_no_error_of_z() {
    // Layout of RepRapFirmware: the height falls by 1e-6 x² mm; a point outside the plate is a 0 without decimals.
    let mut noise = Noise(5);
    let mut map = "RepRapFirmware height map file v2 generated at 2024-01-01 10:00\n\
                   xmin,xmax,ymin,ymax,radius,xspacing,yspacing,xnum,ynum\n0.00,270.00,0.00,95.00,-1.00,30.00,30.00,10,4\n"
        .to_owned();
    for j in 0..4 {
        let cell = |i: u32| -1e-6 * f64::from(30 * i).powi(2);
        let cells: Vec<String> = (0..10)
            .map(|i| if (i, j) == (9, 3) { "      0".into() } else { format!("{:7.3}", cell(i) + noise.next(5e-4)) })
            .collect();
        let _ = writeln!(map, "{}", cells.join(","));
    }
    let names = map.replace(
        "xmin,xmax,ymin,ymax,radius,xspacing,yspacing,xnum,ynum",
        "axis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1",
    );
    let newer = names.replace("0.00,270.00,0.00,95.00", "X,Y,0.00,270.00,0.00,95.00");
    let shop = Shop::new().file("m.toml", printer()).file("heightmap.csv", map).file("newer.csv", newer);
    let more = ["--machine", "m.toml", "-o", "out", "--force", "--flat-reference", "--at", "X0,Y0,Z10", "--tool", "0"];
    for file in ["heightmap.csv", "newer.csv"] {
        shop.run(["import", file].into_iter().chain(more)).exits(0);
        let table = shop.text("out.csv");
        assert_eq!(table.lines().count(), 40, "{table}");
        let heights: std::collections::BTreeSet<&str> =
            table.lines().skip(1).filter_map(|line| line.split(',').nth(3)).collect();
        assert_eq!(heights.len(), 1, "{table}");
        let words = ["calibrate", "out.csv", "--machine", "m.toml", "--model", "EZX2", "-o", "fitted.toml", "--json"];
        let json = shop.run(words).exits(0).json();
        let value = json["parameters"][0]["value"].as_f64().unwrap();
        assert!((value - 1000.0).abs() < 30.0, "{value}");
    }
    // Nothing is left that a Z which depends on the height could explain.
    let found = shop.run(["diagnose", "out.csv", "--machine", "fitted.toml", "--json"]).exits(0).json();
    assert!(!found["findings"].to_string().contains("EZZ"), "{}", found["findings"]);
    shop.run(["import", "m.toml", "--as", "height-points"].into_iter().chain(more)).exits(4).says("no points x y z");
}

#[test]
fn the_slope_of_a_height_map_is_not_that_of_the_axis() {
    // Heights of 1e-6 x² mm from X 100 to 300: their regression line has the slope 1e-6 · (100 + 300).
    let mut table = "setup,X,Y,Z,tool_x_mm,tool_y_mm,tool_z_mm,dz_um\n".to_owned();
    let mut noise = Noise(9);
    for (i, j) in (0..33).map(|k| (k % 11, k / 11)) {
        let x = 100.0 + 20.0 * f64::from(i);
        let _ = writeln!(table, "A,{x},{},10,0,0,0,{:.4}", 40 * j, 1e-3 * x * x + noise.next(0.05));
    }
    let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\", \"rotation\"]\n";
    let shop = Shop::new().file("m.toml", printer()).file("map.csv", table).file("map.toml", description);
    let fit =
        |model: &'static str| ["calibrate", "map.csv", "--machine", "m.toml", "--model", model, "-o", "fitted.toml"];
    shop.run(fit("EZX1,EZX2")).exits(4).says("E0606");
    shop.run(fit("EZX2")).exits(0).says("warning[W0610]").says("from 100 to 300 mm");
    let written = shop.text("fitted.toml");
    let line = written.lines().find(|line| line.starts_with("coefficients")).unwrap();
    let values: Vec<f64> =
        line.split(['[', ']']).nth(1).unwrap().split(',').map(|value| value.trim().parse().unwrap()).collect();
    assert!((values[2].abs() - 1e-6).abs() < 5e-8 && (values[1] + 400.0 * values[2]).abs() < 1e-9, "{line}");
}

#[test]
fn a_scale_from_circles_of_unknown_length_is_relative() {
    // X has 30 µm/m; on a circle about the middle, that is r cos² φ · 30e-6.
    let mut noise = Noise(4);
    let mut table = "setup,X,Y,Z,tool_x_mm,tool_y_mm,tool_z_mm,dr_um\n".to_owned();
    for k in 0..90 {
        let (sin, cos) = (f64::from(k) * 4.0).to_radians().sin_cos();
        let dr = 30e-3 * 80.0 * cos * cos + noise.next(0.05);
        let _ = writeln!(table, "A,{:.5},{:.5},10,0,0,0,{dr:.4}", 150.0 + 80.0 * cos, 150.0 + 80.0 * sin);
    }
    let description = |free: &str| {
        format!(
            "[measurement]\nkind = \"ballbar\"\nfree = [{free}]\n[setup.A]\ncentre_mm = [150, 150, 10]\nlength_mm = 80\n"
        )
    };
    let known = "\n[[motion]]\ncomponent = \"EYY\"\nkind = \"polynomial\"\ncoefficients = [0, 5e-6]\n";
    let shop = Shop::new()
        .file("m.toml", printer())
        .file("y.toml", printer() + known)
        .file("free.csv", table.clone())
        .file("free.toml", description("\"centre\", \"length\""))
        .file("bar.csv", table)
        .file("bar.toml", description("\"centre\""));
    let fit = |data: &'static str, machine: &'static str, model: &'static str| {
        ["calibrate", data, "--machine", machine, "--model", model, "-o", "fitted.toml"]
    };
    shop.run(fit("free.csv", "m.toml", "EXX1"))
        .exits(0)
        .says("warning[W0611]")
        .says("EXX1 is relative to the scale of Y");
    // A stated scale of Y, or a known length, makes it absolute.
    for (data, machine) in [("free.csv", "y.toml"), ("bar.csv", "m.toml")] {
        let run = shop.run(fit(data, machine, "EXX1")).exits(0);
        assert!(!run.stderr.contains("W0611"), "{}", run.stderr);
    }
}

/// Two lasers, at two heights of Z: no axis but their own moved, and a laser shows its scale whole.
#[test]
fn an_axis_that_stood_at_two_places_has_no_scale_in_the_readings() {
    let table = |axis: char, z: i32| {
        let mut text = "component,X,Y,Z,value_um\n".to_owned();
        for k in 0..12 {
            let at = 20.0 * f64::from(k % 6);
            let (x, y) = if axis == 'X' { (at, 50.0) } else { (50.0, at) };
            let _ = writeln!(text, "E{axis}{axis},{x},{y},{z},{:.3}", 0.03 * at + 0.1 * f64::from(k / 6));
        }
        text
    };
    let description = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\n";
    let shop = Shop::new().file("m.toml", printer());
    let shop = shop.file("x.csv", table('X', 10)).file("x.toml", description);
    let shop = shop.file("y.csv", table('Y', 30)).file("y.toml", description);
    let words = ["calibrate", "x.csv", "y.csv", "--machine", "m.toml", "--model", "EXX1,EYY1", "-o", "fitted.toml"];
    let run = shop.run(words).exits(0);
    assert!(!run.stderr.contains("W0611"), "{}", run.stderr);
}

/// A laser that refers to 20 °C, and a plate that shows the lengths at 22 °C, differ by 23 µm/m on a machine of steel.
#[test]
fn two_reference_temperatures_are_named() {
    let mut laser = "component,X,Y,Z,value_um\n".to_owned();
    let mut plate = "X,Y,Z,dx_um\n".to_owned();
    for k in 0..12 {
        let x = 20.0 * f64::from(k % 6);
        let noise = 0.05 * f64::from(k * 7 % 5);
        let _ = writeln!(laser, "EXX,{x},50,10,{:.3}", 0.03 * x + noise);
        let _ = writeln!(plate, "{x},{},10,{:.3}", 20 * (k % 4), 0.053 * x + noise);
    }
    let artefact = |celsius: f64| {
        format!(
            "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\n[artefact]\nexpansion_per_K = 11.5e-6\ntemperature_C = {celsius}\n"
        )
    };
    let shop = Shop::new()
        .file("m.toml", printer())
        .file("laser.csv", laser)
        .file("laser.toml", "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\n")
        .file("warm.csv", plate.clone())
        .file("warm.toml", artefact(22.0))
        .file("cool.csv", plate)
        .file("cool.toml", artefact(20.0));
    let fit = |one: &'static str| {
        shop.run(["calibrate", "laser.csv", one, "--machine", "m.toml", "--model", "EXX1", "-o", "fitted.toml"])
    };
    fit("warm.csv").says("warning[W0615]").says("differ by 23.0 µm/m");
    let run = fit("cool.csv");
    assert!(!run.stderr.contains("W0615"), "{}", run.stderr);
    // A search mixes them as a fit does.
    let search = |one: &'static str| shop.run(["diagnose", "laser.csv", one, "--machine", "m.toml"]).stderr;
    assert!(search("warm.csv").contains("warning[W0615]") && !search("cool.csv").contains("W0615"));
    let alone = shop.run(["calibrate", "warm.csv", "--machine", "m.toml", "--model", "EXX1", "-o", "fitted.toml"]);
    assert!(!alone.stderr.contains("W0615"), "{}", alone.stderr);
}

/// Sorted rows state no directions of approach, so a reversal cannot be found in them; that is not one direction only.
#[test]
fn unknown_directions_are_not_one_direction() {
    let mut table = "X,Y,Z,dx_um\n".to_owned();
    for k in 0..24 {
        let _ = writeln!(table, "{},{},10,{:.3}", 20 * (k % 6), 20 * (k / 6), 0.03 * f64::from(20 * (k % 6)));
    }
    let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\norder = \"unknown\"\n";
    let shop = Shop::new().file("m.toml", printer()).file("d.csv", table).file("d.toml", description);
    let run = shop
        .run(["calibrate", "d.csv", "--machine", "m.toml", "--model", "EXX1,EXXb", "-o", "fitted.toml"])
        .exits(4)
        .says("E0606")
        .says("the directions of approach of X are not known")
        .says("X_dir");
    assert!(!run.stderr.contains("one direction only"), "{}", run.stderr);
}

/// LinuxCNC keeps G20 and G98 of an earlier program; grblHAL documents that it starts with G98.
#[test]
fn a_state_that_the_control_keeps_is_named() {
    let machine = |controller: &str, startup: &str| {
        format!(
            "{}\n[control]\nstartup_code = \"{startup}\"\n",
            mill(controller).replace("wAFXYZSt", "wFXYZSt").split("\n[axis.A]").next().unwrap()
        ) + "\n[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n"
    };
    let holes = |unit: &str, mode: &str| {
        format!("{unit}G90 G17 G54\nS1000 M3\nG0 X0 Y0 Z6\n{mode}G81 X1 Y1 Z-3 R2 F10\nX9\nG80\nM2\n")
    };
    let fix = |machine: String, program: String| {
        let shop = Shop::new().file("m.toml", machine).file("p.ngc", program);
        let run = shop.run(["p.ngc", "-o", "out.ngc", "--machine", "m.toml"]).exits(0);
        (run.stderr.matches("warning[W0240]").count(), run.stderr, shop.text("out.ngc"))
    };
    let (count, said, out) = fix(machine("linuxcnc", ""), holes("", ""));
    assert!(!out.contains("G98") && !out.contains("G99"), "the control keeps its own return: {out}");
    assert!(count == 2 && said.contains("G20 or G21") && said.contains("p.ngc:4"), "{said}");
    for (startup, unit, mode) in [("", "G21 ", "G98 "), ("G21 G98", "", ""), ("G98", "G20 (no mm) ", "")] {
        let (count, said, _) = fix(machine("linuxcnc", startup), holes(unit, mode));
        assert_eq!(count, 0, "{startup}: {said}");
    }
    let (count, said, out) = fix(machine("grblHAL", ""), holes("G21 ", ""));
    assert!(count == 0 && out.contains("G98 G81"), "{said}\n{out}");
}

/// Grbl 1.1 has neither drilling cycles nor M6, G43 with H or several turns (README of Grbl, *List of Supported G-Codes*); grblHAL has them. FluidNC has M6.
#[test]
fn words_that_a_firmware_lacks_are_named_and_its_cycles_are_moves() {
    let machine = |controller: &str| {
        mill(controller).replace("wAFXYZSt", "wFXYZSt").split("\n[axis.A]").next().unwrap().to_owned()
            + "\n[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n[[tool]]\nnumber = 1\nlength_mm = 20\nradius_mm = 2\n"
    };
    let program = "G21 G90 G17 G54 (M6 G43)\nT1 M6\nG43 H1\nS1000 M3\nG0 X0 Y0 Z6\nG98 G81 X1 Y1 Z-3 R2 F10\nX9\nG80\n\
        G2 X9 Y1 I3 J0 P2 F50\n#1=4\nG1 X#1\nM2\n";
    let fix = |controller: &str| {
        let shop = Shop::new().file("m.toml", machine(controller)).file("p.ngc", program);
        let run = shop.run(["p.ngc", "-o", "out.ngc", "--machine", "m.toml"]).exits(0);
        let check = shop.run(["check", "p.ngc", "--machine", "m.toml"]);
        assert_eq!(run.stderr.contains("W0241"), check.stderr.contains("W0241"), "{}", check.stderr);
        (run.stderr, shop.text("out.ngc"))
    };
    let (said, out) = fix("grbl");
    assert!(said.contains("warning[W0241]: Grbl 1.1 does not have these words of the output: M6, G43, H;"), "{said}");
    assert!(said.contains("p.ngc:2:1"), "the first line with one of them: {said}");
    // Two holes as moves: each goes down to Z-3 once, and nothing of the words of the cycle is left.
    assert!(!out.contains("G81") && !out.contains("G98") && !out.contains('#') && !out.contains(" P2"), "{out}");
    // Grbl always follows the exact path: no G61 is written that a G64 would have to end.
    assert!(!out.contains("G61") && !out.contains("G64"), "{out}");
    assert_eq!(out.lines().filter(|line| line.contains("Z-3")).count(), 2, "{out}");
    let (said, out) = fix("fluidnc");
    assert!(
        said.contains("FluidNC does not have these words of the output: G43, H;") && !out.contains("G81"),
        "{said}"
    );
    let (said, out) = fix("grblHAL");
    assert!(!said.contains("W0241") && out.contains("G81") && out.contains("P2"), "{said}\n{out}");
    let (said, out) = fix("linuxcnc");
    assert!(!said.contains("W0241") && out.contains("G81"), "{said}\n{out}");
}

/// X is 30 µm/m too long. The same line with the opposite sign contradicts it, whatever the model.
#[test]
fn a_file_that_contradicts_the_others_is_refused_by_name() {
    let mut noise = Noise(5);
    let mut line = |sign: f64| {
        let mut table = "run,setup,component,X,X_dir,value_um\n".to_owned();
        for k in 0..11 {
            let x = 25.0 * f64::from(k);
            let _ = writeln!(table, "1,A,EXX,{x},1,{:.4}", sign * 30e-3 * x + noise.next(0.1));
        }
        table
    };
    let description = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\n[position]\nY_mm = 100\nZ_mm = 10\n";
    let mut shop = Shop::new().file("m.toml", printer());
    for (name, sign) in [("a", 1.0), ("b", 1.0), ("c", -1.0)] {
        shop = shop.file(&format!("{name}.csv"), line(sign)).file(&format!("{name}.toml"), description);
    }
    let fit = |files: [&'static str; 2]| {
        files.into_iter().fold(vec!["calibrate"], |mut all, file| {
            all.push(file);
            all
        })
    };
    let rest = ["--machine", "m.toml", "--model", "EXX1", "-o", "fitted.toml"];
    shop.run(fit(["a.csv", "b.csv"]).into_iter().chain(rest)).exits(0);
    let three: Vec<&str> = ["calibrate", "a.csv", "b.csv", "c.csv"].into_iter().chain(rest).collect();
    shop.run(three).exits(4).says("E0607").says("the fitted model contradicts c").says("check the sign");
}

#[test]
fn positions_reached_are_not_taken_for_deviations() {
    let mut table = "Target position (mm);1+;1-;2+;2-\n".to_owned();
    for target in [15.0, 35.0, 55.0] {
        let _ = writeln!(
            table,
            "{target:.4};{:.4};{:.4};{:.4};{:.4}",
            target + 1e-3,
            target - 3e-4,
            target + 1e-3,
            target - 3e-4
        );
    }
    let shop = Shop::new().file("m.toml", printer()).file("act.csv", table.replace("(mm)", "[mm]"));
    let at = ["--machine", "m.toml", "--axis", "X", "--at", "Y0,Z0", "--tool", "0", "--material", "20C"];
    shop.run(["import", "act.csv", "-o", "out"].into_iter().chain(at)).exits(0).says("more than commanded (+)");
    let values: Vec<f64> = shop
        .text("out.csv")
        .lines()
        .skip(1)
        .filter_map(|line| line.rsplit(',').next().and_then(|cell| cell.parse().ok()))
        .collect();
    assert!(
        values.len() == 12 && values.iter().all(|um| [1.0, -0.3].iter().any(|own| (um - own).abs() < 0.01)),
        "{values:?}"
    );
    // Two columns of positions without run and direction.
    let two = "target,actual,actual\n0,0.001,0.002\n100,100.001,100.002\n200,200.001,200.002\n";
    let shop = shop.file("two.csv", two);
    shop.run(["import", "two.csv"].into_iter().chain(at))
        .exits(4)
        .says("E0618")
        .says("--columns, such as target,1+,1-");
}

#[test]
fn headings_of_several_words_stand_over_aligned_columns() {
    let report = "Plate: 7\n\n    Meas X    Meas Y     Nom X     Nom Y     Err X     Err Y\n\
                  \x20  0.010     0.000     0.000     0.000     0.010     0.000\n\
                  \x20100.010    0.005   100.000     0.000     0.010     0.005\n\
                  \x20100.020  100.005   100.000   100.000     0.020     0.005\n\
                  \x20  0.020  100.000     0.000   100.000     0.020     0.000\n";
    let shop = Shop::new().file("m.toml", printer()).file("cmm.txt", report);
    let run = shop.run(["import", "cmm.txt", "--machine", "m.toml"]);
    // The headings are read: only what a report of this kind never states is asked.
    assert!(!run.stderr.contains("E0617") && !run.stderr.contains("no headings"), "{}", run.stderr);
}

/// A log of three points that are read in turn.
struct Log {
    rows: u32,
    step_s: f64,
    /// Step of the random walk of the machine from row to row, µm.
    walk_um: f64,
    /// Displacement in Z by the first two of four temperatures, µm/K.
    z_by: [f64; 2],
}

impl Log {
    /// The findings and faults of the data that a diagnosis reports.
    fn diagnosed(&self, seed: u64) -> [serde_json::Value; 2] {
        let mut noise = Noise(seed);
        let mut table = "t_s,setup,X,Y,Z,tool_z_mm,dx_um,dy_um,dz_um,T_head_C,T_room_C,T_oil_C,T_bed_C\n".to_owned();
        let mut drift = [0.0; 3];
        let mut walks = [22.0, 20.0];
        for k in 0..self.rows {
            let t = f64::from(k) * self.step_s;
            let head = 22.0 + 8.0 * (1.0 - (-t / 3600.0).exp()) + noise.next(0.03);
            let room = 20.0 + 1.5 * (t / 13_000.0).sin() + noise.next(0.03);
            walks.iter_mut().for_each(|own| *own += noise.next(0.05));
            drift.iter_mut().for_each(|own| *own += noise.next(self.walk_um));
            let point = ["P1,100,100,50", "P2,300,80,150", "P3,200,250,100"][(k % 3) as usize];
            let mut read = drift.map(|own| own + noise.next(0.5));
            read[2] += self.z_by[0] * (head - 22.0) + self.z_by[1] * (room - 20.0);
            let read = read.map(|um| format!("{um:.3}"));
            let _ =
                writeln!(table, "{t},{point},0,{},{head:.2},{room:.2},{:.2},{:.2}", read.join(","), walks[0], walks[1]);
        }
        let description = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\nsigma_um = 0.5\n";
        let shop = Shop::new().file("m.toml", printer()).file("log.csv", table).file("log.toml", description);
        let json = shop.run(["diagnose", "log.csv", "--machine", "m.toml", "--json"]).exits(0).json();
        ["findings", "data_faults"].map(|key| json[key].clone())
    }
}

#[test]
fn a_random_walk_that_all_points_share_is_explained_by_no_temperature() {
    let log = |z_by_head: f64| Log { rows: 180, step_s: 120.0, walk_um: 0.25, z_by: [z_by_head, 0.0] };
    for seed in 1..=8 {
        let [none, _] = log(0.0).diagnosed(seed);
        assert!(none.as_array().is_some_and(Vec::is_empty), "{seed}: {none}");
    }
    // A drift of 32 µm beside a walk of 3 µm is found.
    let [one, _] = log(4.0).diagnosed(1);
    assert_eq!((one[0]["effect"].as_str(), one[0]["parameter"].as_str()), (Some("thermal-drift"), Some("Z")), "{one}");
    assert!(one.to_string().contains("T_head"), "{one}");
}

#[test]
fn a_short_log_of_many_sensors_has_no_clock_of_its_own() {
    // 28 rows of each point, and four sensors: with all their time constants, more columns than rows can bear.
    for seed in 1..=6 {
        let [found, faults] = Log { rows: 84, step_s: 240.0, walk_um: 0.05, z_by: [0.0, 6.0] }.diagnosed(seed);
        assert!(faults.as_array().is_some_and(Vec::is_empty), "{seed}: {faults}");
        assert_eq!(found[0]["sensor"], "T_room_C", "{seed}: {found}");
    }
}

#[test]
fn few_rows_on_a_circle_tell_the_backlash() {
    // 24 rows on each circle, directions not stated: dx = ±1.5 µm by the direction of X, which turns between two rows.
    let mut table = "X,Y,Z,setup,run,dr_um\n".to_owned();
    let mut description = "[measurement]\nkind = \"ballbar\"\nsigma_um = 0.3\nfree = [\"centre\"]\n".to_owned();
    for circle in 0..4_u32 {
        let [x, y] = [f64::from(circle % 2), f64::from(circle / 2)].map(|k| 150.0 + 150.0 * k);
        let _ = write!(description, "[setup.s{circle}]\ncentre_mm = [{x}, {y}, 100]\nlength_mm = 100\n");
        let sense = if circle % 2 == 0 { 1.0 } else { -1.0 };
        for k in 0..24 {
            let angle = sense * (f64::from(k) * std::f64::consts::TAU / 24.0 + 0.1);
            let back = if -angle.sin() * sense > 0.0 { 1.5 } else { -1.5 };
            let [at_x, at_y] = [x + 100.0 * angle.cos(), y + 100.0 * angle.sin()];
            let _ = writeln!(table, "{at_x:.7},{at_y:.7},100,s{circle},{circle},{:.6}", back * angle.cos());
        }
    }
    let shop = Shop::new().file("m.toml", printer()).file("c.csv", table).file("c.toml", description);
    let words = ["calibrate", "c.csv", "--machine", "m.toml", "--model", "EXXb,EYYb", "-o", "fitted.toml", "--json"];
    let json = shop.run(words).exits(0).json();
    let value = |name: &str| {
        let rows = json["parameters"].as_array().unwrap();
        rows.iter().find(|row| row["name"] == name).and_then(|row| row["value"].as_f64()).unwrap()
    };
    assert!((value("EXXb") - 1.5).abs() < 0.01 && value("EYYb").abs() < 0.01, "{json}");
}

#[test]
fn a_spiral_of_a_post_stays_one_block_without_errors() {
    // The radius at the end is 0.0127 mm larger than at the start: the control accepts that and runs a spiral.
    for (controller, end) in [("haas", "M30\n%"), ("fanuc", "M30\n%"), ("rs274", "M2")] {
        let head = if controller == "rs274" { "" } else { "%\nO3\n" };
        let program = format!(
            "{head}G20 G90 G17 G40\nG54\nT1 M6\nG0 G43 Z0.6 H1\nG0 X1. Y0.\nG1 Z-0.1 F10.\nG2 X0. Y-1.0005 I-1. J0.\nG1 X-1.\n{end}\n"
        );
        let more = "\n[control]\nincrement_mm = 0.001\narc_tolerance_mm = 0.05\n";
        let machine = mill(controller).replace("[zero_offset.G54]", &format!("{more}\n[zero_offset.G54]"));
        let shop = Shop::new().file("m.toml", machine).file("p.nc", program);
        shop.run(["fix", "p.nc", "--machine", "m.toml", "-o", "out.nc"]).exits(0);
        let arcs: Vec<String> =
            shop.text("out.nc").lines().filter(|line| line.contains(" I-")).map(str::to_owned).collect();
        assert_eq!(arcs, ["G2 X0. Y-1.0005 I-1. J0."], "{controller}: {}", shop.text("out.nc"));
    }
}

#[test]
fn words_of_a_haas_that_other_controls_lack() {
    let program =
        |line: &str| format!("%\nO1\nG21 G90 G17 G40 G54\nT1 M6\nG0 X0. Y0. A0.\nG43 Z50. H1\n{line}\nG80\nM30\n%\n");
    // P is the number of the output, and stays with its code.
    let shop = Shop::new().file("m.toml", mill("haas")).file("p.nc", program("M59 P1103\nG1 X5. F100.\nM69 P1103"));
    shop.run(["fix", "p.nc", "--machine", "m.toml", "-o", "out.nc"]).exits(0);
    let text = shop.text("out.nc");
    assert!(text.contains("\nM59 P1103\n") && text.contains("\nM69 P1103\n"), "{text}");
    snc("fanuc", &program("M59 P1103")).exits(4).says("P has no effect");
    snc("haas", &program("G84 X1. Z-5. R2. J2. F500.")).exits(3).says("E0201").says("omit J");
    snc("fanuc", &program("G42 H19 X10. F39.")).exits(4).says("E0232").says("H may be a radius");
}

#[test]
fn a_letter_in_place_of_a_digit_is_named() {
    for controller in ["sinumerik", "fanuc", "haas", "rs274", "grundig"] {
        for (word, letter) in [
            ("GO X10.", "letter O"),
            ("G0O X1.", "letter O"),
            ("XO", "letter O"),
            ("G0 X1O.", "letter O"),
            ("MO6", "letter O"),
            ("TO1", "letter O"),
            ("SlOOO", "letter O"),
            ("G0l X1.", "letter I or l"),
            ("G0 Xl0.", "letter I or l"),
        ] {
            let run = snc(controller, &format!("N1 G90 G17\nN2 {word}\nN3 M30\n"));
            assert!(run.code >= 3 && run.stderr.contains(letter), "{controller} {word}: {}", run.stderr);
        }
    }
}

#[test]
fn a_depth_of_cut_of_an_earlier_cycle_is_named_at_the_tap() {
    // Q stays until G80, as do the other data of the hole (Fanuc operator's manual, canned cycle).
    let program = |between: &str, q: &str| {
        format!(
            "%\nO1\nG21 G90 G17 G40 G94 G54\nT1 M6\nS500 M3\nG0 X0. Y0. A0.\nG43 Z20. H1\nG83 X5. Y5. Z-10. R2. Q2. F100.\n{between}G84 X15. Y5. Z-10. R2. {q}F500.\nG80\nM30\n%\n"
        )
    };
    for controller in ["fanuc", "haas"] {
        snc(controller, &program("", "")).exits(3).says("E0201").says("Q of an earlier cycle").says("G80");
        snc(controller, &program("", "Q2. ")).exits(3).says("E0201").says("tapping in pecks (Q)");
        snc(controller, &program("G80\n", "")).exits(0);
        snc(controller, &program("", "Q0 ")).exits(0);
    }
}

/// The holes of a tap share the Q of its first block. Outside of a hole, a Fanuc does not store Q (operator's manual, restrictions of the cycles).
#[test]
fn the_holes_of_a_tap_in_pecks_share_its_q() {
    let program = |blocks: &str| {
        format!("%\nO1\nG21 G90 G17 G40 G94 G54\nT1 M6\nS500 M3\nG0 X0. Y0. A0.\nG43 Z20. H1\n{blocks}G80\nM30\n%\n")
    };
    let shop = Shop::new()
        .file("m.toml", mill("fanuc"))
        .file("own.nc", program("M29 S500\nG99 G84 X15. Y5. Z-10. R2. Q2. F500.\nX25.\nX35.\n"))
        .file("alone.nc", program("M29 S500\nG99 G84 Q2.\nX15. Y5. Z-10. R2. F500.\n"))
        .file("stored.nc", program("M29 S500\nG99 G84 Z-10. R2. Q2. F500. K0\nX15. Y5.\nX25.\n"));
    for file in ["own.nc", "stored.nc"] {
        shop.run(["fix", file, "-o", "out.nc", "--machine", "m.toml"]).exits(0);
        let text = shop.text("out.nc");
        assert_eq!((text.matches("Q2.").count(), text.matches("G84").count()), (1, 1), "{text}");
    }
    shop.run(["fix", "alone.nc", "-o", "out.nc", "--machine", "m.toml"]).says("E0210").says("alone.nc:9:9");
}
