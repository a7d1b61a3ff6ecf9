//! Backlash of an axis that came to its place from nobody knows where.

use crate::support::Shop;

const MACHINE: &str = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n[axis.X]\ndirection = [1, 0, 0]\n\
    travel_mm = [-700, 700]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-500, 500]\n[axis.Z]\ndirection = [0, 0, 1]\n\
    travel_mm = [-500, 500]\n[control]\nincrement_mm = 0.0001\n[[tool]]\nnumber = 1\nlength_mm = 50\nradius_mm = 5\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = -6\n";

#[track_caller]
fn corrected(program: &str, more: &[&str]) -> (String, Vec<String>) {
    let shop = Shop::new().file("m.toml", MACHINE).file("p.mpf", program);
    let base = ["p.mpf", "-o", "out.mpf", "--machine", "m.toml", "--json"];
    let run = shop.run(base.iter().chain(more)).exits(0);
    // The machine has errors of one axis, and a program that moves others is warned of that.
    let codes = run.codes().into_iter().filter(|code| code != "W0316").collect();
    (shop.text("out.mpf"), codes)
}

/// The table lags by 6 µm and an overshoot goes a quarter of that further: 7.5 µm back from 100 + 3 µm, then forward.
const SETTLED: [&str; 2] = ["G0 X99.9955 Y0 Z10", "X100.003 ;+~"];

#[test]
fn the_approach_settles_the_side_above_the_work() {
    let program = "G0 X100 Y0 Z10\nG1 Z0 F500\nY50\nX150\nX100\nM30\n";
    let (text, codes) = corrected(program, &[]);
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines.windows(2).any(|pair| pair[0] == SETTLED[0] && pair[1].ends_with(SETTLED[1])), "{text}");
    assert!(text.contains("X150.003") && text.contains("X99.997"), "{text}");
    assert!(codes.is_empty(), "{codes:?}");
    // From where it came is given: nothing has to be settled.
    for (start, first) in [("X0,Y0,Z50", "X100.003"), ("X600,Y0,Z50", "X99.997")] {
        let (text, codes) = corrected(program, &["--start", start]);
        assert!(text.contains(first) && !text.contains("99.9955"), "{start}\n{text}");
        assert!(codes.is_empty(), "{codes:?}");
    }
    // Or the program decides it.
    let (text, codes) = corrected("G0 X90 Y0 Z10\nX100\nG1 Z0 F500\nY50\nM30\n", &[]);
    assert!(text.contains("X100.003") && !text.contains("99.9955"), "{text}");
    assert!(codes.is_empty(), "{codes:?}");
}

#[test]
fn an_approach_whose_height_nobody_stated_settles_it_too() {
    // X and Y first, as behind most tool changes: Z is where the change or a person left it, and the next move goes along the tool.
    let (text, codes) = corrected("T1 M6\nD1\nG0 X100 Y0\nG0 Z10\nG1 Z-5 F500\nY50\nM30\n", &[]);
    assert!(text.contains("G0 X99.9955 Y0\nX100.003 ;+~\n"), "{text}");
    assert!(codes.is_empty(), "{codes:?}");
    // One that goes on across the tool may be beside the work.
    let (text, codes) = corrected("T1 M6\nD1\nG0 X100 Y0\nG1 Y50 F500\nM30\n", &[]);
    assert!(!text.contains("99.9955"), "{text}");
    assert_eq!(codes, ["W0308", "W0322"]);
}

/// The control adds more to Y than it loses, and the plunge leaves its body where it is off by nearly the tolerance.
const BROUGHT: &str = "[machine]\nname = \"m\"\ntopology = \"wFYXZSt\"\ncontroller = \"sinumerik\"\n[axis.X]\ndirection = [1, 0, 0]\n\
    [axis.Y]\ndirection = [0, 1, 0]\n[axis.Z]\ndirection = [0, 0, 1]\n[location]\nEC0X = -7.04\nEB0Z = -4.82\nEA0Z = 4.04\n\
    [[motion]]\ncomponent = \"EAX\"\nkind = \"polynomial\"\ncoefficients = [0, 1.0451109831940796e-08, 5.204280334802149e-12]\n\
    [[motion]]\ncomponent = \"EYZ\"\nkind = \"polynomial\"\ncoefficients = [0, 0, 1.3329897838289897e-08]\n\
    [[motion]]\ncomponent = \"EYY\"\nkind = \"backlash\"\npositions_mm = [-50, 150]\nvalues_um = [3.0, 0.912]\n\
    [zero_offset.G54]\nX_mm = -37.5\nZ_mm = -400.5\n[[tool]]\nnumber = 3\nlength_mm = 80.5\nradius_mm = 4\n";

#[test]
fn what_no_cut_makes_smaller_costs_no_blocks() {
    let program = "G17 G90 G54\nT3 M6\nG0 X30 Y40\nG1 Z-1 F800\nG3 X32.614 Y42.52 I0.725 J1.864\nG0 Z100\nG0 X30 Y63.333\nG0 Z20\nG1 Z-3 F300\n";
    let shop = Shop::new().file("m.toml", BROUGHT).file("p.mpf", program);
    let run = shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    assert!(run.stderr.contains("W0305"), "{}", run.stderr);
    // Pieces of 0.01 mm would be 2,300.
    let lines = shop.text("out.mpf").lines().count();
    assert!(lines < 40, "{lines} lines\n{}", shop.text("out.mpf"));
}

/// Increments of 1 µm leave bodies up to one and a half of them within their dead bands; play of the column moves the tip aside then.
const COARSE: &str = r#"[machine]
name = "m"
topology = "wXYFZSt"
controller = "fanuc"
[axis.X]
direction = [-1, 0, 0]
travel_mm = [99.95, 250.05]
[axis.Y]
direction = [0, -1, 0]
travel_mm = [-60.3, 89.80000000000001]
[axis.Z]
direction = [0, 0, 1]
travel_mm = [-300, 600]
[location]
EC0X = -12.75
EB0Z = -11.25
EA0Z = -0.77
[[motion]]
component = "EXX"
kind = "polynomial"
coefficients = [0, -3.5207270954094614e-06, -2.4014707614836705e-08]
[[motion]]
component = "EYX"
kind = "polynomial"
coefficients = [0, 0, 1.4505332312326912e-08]
[[motion]]
component = "EXX"
kind = "backlash"
value_um = 15.000
[[motion]]
component = "EXZ"
kind = "backlash"
value_um = 2.008
[[motion]]
component = "EBZ"
kind = "backlash"
value_urad = 5.934
[zero_offset.G54]
X_mm = 100.0
Y_mm = -60.25
Z_mm = 0
set = "absolute"
[[tool]]
number = 1
length_mm = 80.5
radius_mm = 4
"#;

#[test]
fn an_axis_at_rest_beside_a_plunge_keeps_the_promise() {
    let program = "N10 G21\nN40 G0 G43 Z11.000 H1\nN50 G0 X0. Y25.250\nN70 G1 Z-0.500 F800.000\nN80 G0 Z1.000\nN90 G0 X0. Y40.321\nN100 G1 Z-0.500 F800.000\n";
    let shop = Shop::new().file("m.toml", COARSE).file("p.nc", program);
    let run = shop.run(["p.nc", "-o", "out.nc", "--machine", "m.toml", "--json"]).exits(0);
    let after_um = run.json()["after"]["max_um"].as_f64().unwrap();
    // The tolerance of 1 µm, and half an increment in each of three directions: a tip further off is not what was promised.
    assert!(after_um <= 1.0 + 0.5 * 3.0_f64.sqrt() * 0.25, "{after_um}");
    assert!(run.codes().is_empty(), "{:?}", run.codes());
    shop.run(["verify", "p.nc", "out.nc", "--machine", "m.toml"]).exits(0);
}

#[test]
fn without_room_the_side_stays_unknown_and_is_told() {
    // The tool is at its depth already: nobody knows what stands beside it.
    let (text, codes) = corrected("G0 X100 Y0 Z0\nG1 Y50 F500\nX150\nM30\n", &[]);
    assert!(text.contains("G0 X100 Y0 Z0"), "{text}");
    assert_eq!(codes, ["W0308"]);
}

#[test]
fn a_move_that_is_shorter_than_the_backlash_settles_nothing() {
    // Behind the tool change X is anywhere in its 6 µm; 1 µm of the program and 3 µm of its correction would lead through four of them.
    let program = "T1 M6\nD1\nG0 X100 Y0 Z0\nX100.001\nG1 Y50 F500\nM30\n";
    let (text, codes) = corrected(program, &[]);
    assert!(text.contains("X100.001"), "{text}");
    assert_eq!(codes, ["W0308"]);
    // 10 µm and 3 µm are more than that, and it cuts where it is.
    let (text, codes) = corrected(&program.replace("X100.001", "X100.01"), &[]);
    assert!(text.contains("G0 X100.013\nG1 Y50 F500\n"), "{text}");
    assert!(codes.is_empty(), "{codes:?}");
}

#[test]
fn a_tool_change_makes_the_side_unknown_again() {
    let program = "G0 X90 Y0 Z100\nX100\nT1 M6\nD1\nG0 X100 Y0 Z100\nG1 Y50 F500\nM30\n";
    let (_, codes) = corrected(program, &[]);
    assert_eq!(codes, ["W0308"]);
}

#[test]
fn verify_sees_it_the_same_way() {
    for (program, range_um) in [
        ("G0 X100 Y0 Z10\nG1 Z0 F500\nY50\nX150\nX100\nM30\n", 0.0..0.2),
        // The side may be either: half of 6 µm.
        ("G0 X100 Y0 Z0\nG1 Y50 F500\nM30\n", 2.9..3.1),
    ] {
        let shop = Shop::new().file("m.toml", MACHINE).file("p.mpf", program);
        let fixed = shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml", "--json"]).exits(0).json();
        let verified = shop.run(["verify", "p.mpf", "out.mpf", "--machine", "m.toml", "--json"]).exits(0).json();
        for json in [fixed, verified] {
            assert!(range_um.contains(&json["after"]["max_um"].as_f64().unwrap()), "{json}");
        }
    }
}

#[test]
fn verify_takes_the_own_output_where_the_sides_of_two_axes_are_unknown() {
    // The step that takes up the play of X leaves the tip at its place only if X, and not Y, is at one end of what is possible: one corner of both is not
    // enough to see that.
    let ordinary = [[-9.0, -5.0], [-5.0, -9.0], [-3.0, -20.0]];
    let over_compensated = [[9.0, 5.0], [5.0, 9.0], [9.0, -5.0], [-9.0, 5.0], [12.0, 12.0], [3.0, 20.0]];
    for [x_um, y_um] in ordinary.into_iter().chain(over_compensated) {
        let machine = MACHINE.replace("value_um = -6", &format!("value_um = {x_um}"))
            + &format!("[[motion]]\ncomponent = \"EYY\"\nkind = \"backlash\"\nvalue_um = {y_um}\n");
        for moves in ["G1 X5 F300\nG1 Y40\nG1 X30 Y10", "G1 Y40 F300\nG1 X5\nG1 Y1", "G1 X95 F300\nG3 X85 Y10 CR=10"] {
            for plane in ["G17", "G19"] {
                if plane == "G19" && moves.contains("G3") {
                    continue;
                }
                let program = format!("{plane} G90\nT1 M6\nD1\nS1000 M3\nG0 X90 Y0 Z0\n{moves}\nM30\n");
                let shop = Shop::new().file("m.toml", &machine).file("p.mpf", &program);
                let fixed = shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml", "--json"]).exits(0);
                // A control that adds too much at a reversal may leave more than the tolerance; the correction says so.
                if fixed.codes().contains(&"W0305".to_owned()) {
                    assert!(x_um > 0.0 || y_um > 0.0, "{x_um} {y_um} {program}");
                    continue;
                }
                let run = shop.run(["verify", "p.mpf", "out.mpf", "--machine", "m.toml", "--json"]);
                let codes = run.codes();
                assert!(
                    run.code == 0 && !codes.iter().any(|code| code.starts_with('E')),
                    "{x_um} {y_um} {program}\n{run:?}\n{}",
                    shop.text("out.mpf")
                );
            }
        }
    }
}

#[test]
fn an_axis_that_the_control_moves_too_far_gets_no_step_in_its_old_direction() {
    // X is 6 um ahead of its command in either direction: 19.994 takes the tip to 20, and a step further would cut 12 um into the wall.
    let machine = MACHINE.replace("value_um = -6", "value_um = 12");
    let program = "G17 G90\nT1 M6\nD1\nS1000 M3\nG0 X0 Y0 Z2\nG1 Z-1 F500\nX20\nX0\nG0 Z30\nM30\n";
    let shop = Shop::new().file("m.toml", machine).file("p.mpf", program);
    shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    let text = shop.text("out.mpf");
    assert!(text.contains("X19.994\n") && text.contains("X0.006\n"), "{text}");
    let commands =
        text.lines().filter_map(|line| line.split('X').nth(1)?.split([' ', ';']).next()?.parse::<f64>().ok());
    let most = commands.fold(0.0, f64::max);
    assert!(most <= 19.994, "{text}");
    shop.run(["verify", "p.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
    // On an arc whose start reverses X the step is the smaller evil. It takes the tip 12 um beyond its place, and the correction says so.
    let arc = program.replace("X20\nX0\n", "X20\nG3 X10 Y10 CR=10\n");
    let found =
        shop.file("arc.mpf", arc).run(["arc.mpf", "-o", "arc_out.mpf", "--machine", "m.toml", "--json"]).exits(0);
    assert!(found.codes().contains(&"W0305".to_owned()), "{}", found.stdout);
}

#[test]
fn no_piece_of_an_arc_is_so_short_that_a_control_could_mill_a_full_circle() {
    // Arcs that begin or end next to a quadrant point, where X or Y reverses. A Sinumerik as delivered rounds both ends to 1 um.
    let errors = "[[motion]]\ncomponent = \"EYY\"\nkind = \"backlash\"\nvalue_um = -5\n[[motion]]\ncomponent = \"EYX\"\nkind = \"polynomial\"\n\
        coefficients = [0, -6e-6, -2e-7]\n[[motion]]\ncomponent = \"EXY\"\nkind = \"polynomial\"\ncoefficients = [0, 4e-6, 1e-7]\n";
    let mut arcs = 0;
    for increment in ["0.0001", "0.001"] {
        let machine = MACHINE.replace("increment_mm = 0.0001", &format!("increment_mm = {increment}")) + errors;
        for number in 0..12_u32 {
            // From a quadrant point to half a radian after the next: the start is moved along the circle by 0 to 11 um.
            let (radius, turn) = (5.0, f64::from(number % 4) * std::f64::consts::FRAC_PI_2);
            let angle = turn + f64::from(number) * 1e-3 / radius;
            let at = |angle: f64| [19.4 + radius * angle.cos(), 26.5 + radius * angle.sin()];
            let ([x, y], [to_x, to_y]) = (at(angle), at(angle + 2.1));
            let (i, j) = (19.4 - x, 26.5 - y);
            let program = format!(
                "G17 G90\nT1 M6\nD1\nS1000 M3\nG0 X{x:.4} Y{y:.4} Z2\nG1 Z-1 F500\nG3 X{to_x:.4} Y{to_y:.4} I{i:.4} J{j:.4}\n\
                 G2 X{x:.4} Y{y:.4} I{:.4} J{:.4}\nG0 Z30\nM30\n",
                19.4 - to_x,
                26.5 - to_y
            );
            let shop = Shop::new().file("m.toml", &machine).file("p.mpf", &program);
            shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
            let text = shop.text("out.mpf");
            // An independent reader of the lines: the last X and Y, and the mode.
            let (mut place, mut mode) = ([f64::NAN; 2], 0);
            for line in text.lines().map(|line| line.split(';').next().unwrap()) {
                let word = |letter: char| -> Option<f64> {
                    line.split(' ').find_map(|word| word.strip_prefix(letter))?.parse().ok()
                };
                mode = line
                    .split(' ')
                    .find_map(|word| match word {
                        "G0" | "G1" => Some(1),
                        "G2" | "G3" => Some(2),
                        _ => None,
                    })
                    .unwrap_or(mode);
                let next = [word('X').unwrap_or(place[0]), word('Y').unwrap_or(place[1])];
                if mode == 2 && (word('I').is_some() || word('J').is_some()) {
                    let apart = (next[0] - place[0]).abs().max((next[1] - place[1]).abs());
                    assert!(apart > 0.001, "{line}\n{text}");
                    arcs += 1;
                }
                place = next;
            }
            shop.run(["verify", "p.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
        }
    }
    assert!(arcs > 48, "{arcs}");
}

#[test]
fn the_mark_of_a_step_stays_where_the_block_has_a_comment() {
    // Lost motion of Z and X: the plunge and the reversals begin with a step. Without its mark, the comparison takes it for a cut.
    let errors = "[[motion]]\ncomponent = \"EZZ\"\nkind = \"backlash\"\nvalue_um = -6\n[[motion]]\ncomponent = \"EYY\"\nkind = \"backlash\"\nvalue_um = -5\n";
    for (control, open, close, head) in [
        ("sinumerik", "; ", "", "T1 M6\nD1"),
        ("fanuc", "(", ")", "T1 M6\nG43 H1"),
        ("rs274", "(", ")", "T1 M6\nG43 H1"),
    ] {
        let machine = MACHINE.replace("controller = \"sinumerik\"", &format!("controller = \"{control}\""))
            + errors
            + "[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nset = \"absolute\"\n";
        let cuts = ["G1 Z-1. F500.", "X20. Y5.", "X10. Y2.", "X15. Y9.", "Z-2."];
        let cuts: Vec<String> =
            (1..).zip(cuts).map(|(number, cut)| format!("{cut} {open}CUT {number}{close}")).collect();
        let program =
            format!("G17 G90 G40 G54\n{head}\nS1000 M3\nG0 X30. Y10. Z5.\n{}\nG0 Z30.\nM30\n", cuts.join("\n"));
        let shop = Shop::new().file("m.toml", machine).file("p.nc", &program);
        shop.run(["p.nc", "-o", "out.nc", "--machine", "m.toml"]).exits(0);
        let text = shop.text("out.nc");
        for number in 1..=5 {
            assert!(text.contains(&format!("{open}CUT {number}{close}")), "{control}\n{text}");
        }
        let marked = text.lines().filter(|line| line.ends_with(";~") || line.ends_with("(~)")).count();
        assert!(marked > 0, "{control}\n{text}");
        shop.run(["verify", "p.nc", "out.nc", "--machine", "m.toml"]).exits(0);
    }
}
