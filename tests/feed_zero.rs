//! The zero offset and the codes of a control when a job begins: those for which the program was corrected, or no line is sent.

use super::cli_feed::{passes, start};
use super::controls::{Blockwise, Control, Faults, Grbl, Marlin, Rsh, Wired};
use super::support::{Run, Shop};

/// A router whose X error grows with the square of the position, so that the correction depends on the place in the machine.
const ROUTER: &str = "[machine]\nname = \"router\"\ntopology = \"wFYXZSt\"\ncontroller = \"rs274\"\n\
    [control]\nincrement_mm = 0.001\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 600]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 900]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-200, 20]\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, -0.0005, 0.000002]\n\
    [zero_offset.G54]\nX_mm = 100\nY_mm = 100\nZ_mm = -60\n";

const ZERO: [f64; 3] = [100.0, 100.0, -60.0];

fn control(offset: [f64; 3]) -> Grbl {
    Grbl::new(&Faults::default(), 0.002).that_tells_its_place(offset)
}

fn shop(part: &str) -> Shop {
    Shop::new().file("part.ngc", part).file("router.toml", ROUTER)
}

fn feed(shop: &Shop, bench: &Wired<Grbl>) -> Run {
    shop.run(["feed", "part.ngc", "--machine", "router.toml", "--link", "grbl", "--port", &bench.name])
}

/// At X 400 instead of X 100 the error of 2 nm per mm² is another one by 2e-6 (400² − 100²) = 0.3 mm. The rounding of a typed value is no difference.
#[test]
fn a_control_with_another_zero_gets_no_line() {
    let shop = shop(&passes(1));
    let bench = Wired::at_line(control([100.02, 99.98, -60.0]));
    feed(&shop, &bench).exits(0).says("confirmed");
    assert!(shop.text("part.ngc.journal").contains(" O G54 100.020,99.980,-60.000\n"));
    for other in [[400.0, 100.0, -60.0], [100.0, 100.0, -59.8]] {
        let bench = Wired::at_line(control(other));
        let [x, y, z] = other;
        let run = feed(&shop, &bench).exits(6);
        let run = run.says(&format!("G54 of the control is X{x:.3} Y{y:.3} Z{z:.3}")).says("[zero_offset.G54]");
        run.says("G21 G10 L2 P1 X100.000 Y100.000 Z-60.000").says("no line was sent");
        assert!(bench.executed().is_empty());
    }
}

/// G55 is in force from an earlier program, and this one states no zero offset.
#[test]
fn an_offset_that_the_program_does_not_state_must_be_g54() {
    let bare = passes(1).replace("G21 G90 G17 G54 G94\n", "");
    let in_g55 = || {
        let mut control = control(ZERO);
        control.active = "G55";
        Wired::at_line(control)
    };
    let bench = in_g55();
    feed(&shop(&bare), &bench).exits(6).says("the control has G55 in force");
    assert!(bench.executed().is_empty());
    feed(&shop(&passes(1)), &in_g55()).exits(0);
}

/// The state that ncfix assumes of plane, feed and zero offset is in the first line, unless the program states it before its first position.
#[test]
fn the_first_line_states_what_the_program_assumes() {
    let head = "G21 G90 G17 G54 G94\n";
    for (begins, expected) in [
        ("", "G21 G90 G91.1 G40 G17 G94 G54"),
        ("(G17 G54 G94)\nG90 G21\n", "G21 G90 G91.1 G40 G17 G94 G54"),
        ("G21 G90 G54\n", "G21 G90 G91.1 G40 G17 G94"),
        (head, "G21 G90 G91.1 G40"),
    ] {
        let bench = Wired::at_line(control(ZERO));
        feed(&shop(&passes(1).replace(head, begins)), &bench).exits(0);
        assert_eq!(bench.executed()[0], expected, "{begins}");
    }
    // With another plane in the startup code, the correction is for that one.
    let bench = Wired::at_line(control(ZERO));
    let machine = ROUTER.replace("[control]\n", "[control]\nstartup_code = \"G18\"\n");
    let shop = Shop::new().file("part.ngc", passes(1).replace(head, "")).file("router.toml", machine);
    feed(&shop, &bench).exits(0);
    assert_eq!(bench.executed()[0], "G21 G90 G91.1 G40 G18 G94 G54");
}

/// Somebody sets the zero in X anew, by 5 mm, with line 40. The reports say so: the axes are held, or stand at the stop after line 50, where nothing waits.
#[test]
fn a_zero_that_moves_during_the_job_stops_it() {
    let mut moving = control(ZERO);
    moving.moves_zero_at = Some(40);
    let bench = Wired::at_line(moving);
    let run = feed(&shop(&passes(30)), &bench)
        .exits(6)
        .says("the zero offset was changed at the control")
        .says("X105.000 Y100.000 Z-60.000")
        .says("reset the control")
        .says("feed hold (!)");
    let done = bench.executed().len();
    assert!(done < 30 * 13, "{done} {}", run.stderr);
}

/// The cable is drawn. Before the job is taken up again, the zero in X is 0.16 mm beside that of its beginning. Each is within 0.1 mm of the file.
#[test]
fn a_job_is_not_taken_up_again_at_another_zero() {
    let shop = shop(&passes(30));
    let bench = Wired::at_network(control([99.92, 100.0, -60.0]));
    let arguments = ["feed", "part.ngc", "--machine", "router.toml", "--link", "grbl", "--port", &bench.name];
    let mut child = start(&shop, &arguments);
    bench.wait_for(60);
    drop(bench);
    assert_eq!(child.wait().unwrap().code(), Some(5), "{}", shop.text("stderr"));
    let plan = shop.run(["resume", "part.ngc.journal", "--clearance", "60mm", "--json"]).exits(0);
    let plan: serde_json::Value = serde_json::from_str(&plan.stdout).unwrap();
    let number = plan["plan"].as_str().unwrap();
    let bench = Wired::at_line(control([100.08, 100.0, -60.0]));
    shop.run(["resume", "part.ngc.journal", "--clearance", "60mm", "--confirm", number, "--port", &bench.name])
        .exits(6)
        .says("G54 of the control has moved since the job began: it is X100.080")
        .says("was X99.920");
    assert!(bench.executed().is_empty());
}

/// A router with a rotary axis beside its table: A is 15° in G54.
fn turning() -> String {
    let chain = ROUTER
        .replace("wFYXZSt", "wAFYXZSt")
        .replace("[[motion]]", "[axis.A]\ndirection = [1, 0, 0]\ntravel_deg = [-720, 720]\n[[motion]]");
    chain + "A_deg = 15\n"
}

fn feed_to<C: Control + Send + 'static>(shop: &Shop, link: &str, bench: &Wired<C>) -> Run {
    let port = ["--port", &bench.name, "--allow-starvation"];
    shop.run(["feed", "part.ngc", "--machine", "router.toml", "--link", link].iter().chain(&port))
}

fn linuxcnc(offset: [f64; 5]) -> Rsh {
    let mut control = Rsh::new(&Faults::default(), 0.002);
    control.offsets[0] = offset;
    control
}

/// LinuxCNC prints its parameters. At another place, turned, with a tool length or with another angle of A, no line is sent.
#[test]
fn linuxcnc_with_another_zero_gets_no_line() {
    let shop = shop(&passes(1));
    let bench = Wired::at_network(linuxcnc([100.02, 99.98, -60.0, 77.0, 0.0]));
    feed_to(&shop, "linuxcnc", &bench).exits(0).says("confirmed");
    assert!(
        shop.text("part.ngc.journal").contains(" O G54 100.020,99.980,-60.000"),
        "{}",
        shop.text("part.ngc.journal")
    );
    for (offset, length, says) in [
        ([400.0, 100.0, -60.0, 0.0, 0.0], 0.0, "G54 of the control is X400.000 Y100.000 Z-60.000"),
        ([100.0, 100.0, -60.0, 0.0, 2.0], 0.0, "rotation_deg = [0, 0, 2.000]"),
        ([100.0, 100.0, -60.0, 0.0, 0.0], 5.0, "G54 of the control with its tool length is X100.000 Y100.000 Z-55.000"),
    ] {
        let mut control = linuxcnc(offset);
        control.length = length;
        let bench = Wired::at_network(control);
        feed_to(&shop, "linuxcnc", &bench).exits(6).says(says).says("no line was sent");
        assert!(bench.executed().is_empty());
    }
}

/// Another screen reads the messages of LinuxCNC. ncfix names what a person compares, and still detects the offset in force after the first line.
#[test]
fn linuxcnc_whose_messages_are_read_elsewhere_is_compared_after_a_line() {
    let shop = shop(&passes(1));
    for (x, code) in [(100.0, 0), (400.0, 6)] {
        let mut control = linuxcnc([x, 100.0, -60.0, 0.0, 0.0]);
        control.has_other_screen = true;
        let bench = Wired::at_network(control);
        let run = feed_to(&shop, "linuxcnc", &bench).exits(code);
        let run = run.says("compare G54 X100.000 Y100.000 Z-60.000 at the control");
        if code != 0 {
            run.says("G54 of the control is X400.000");
            assert!(bench.executed().iter().all(|line| !line.contains('X')), "{:?}", bench.executed());
        }
    }
}

/// A line that LinuxCNC reports as done, and whose axes stay, ends the job at once: the next line would hide it.
#[test]
fn a_line_that_linuxcnc_did_not_execute_is_detected_before_the_next_one() {
    let shop = shop(&passes(1));
    let faults = Faults { ignored: Some(9), ..Faults::default() };
    let mut control = Rsh::new(&faults, 0.002);
    control.offsets[0] = [100.0, 100.0, -60.0, 0.0, 0.0];
    let bench = Wired::at_network(control);
    let run = feed_to(&shop, "linuxcnc", &bench).exits(6).says("the control is at another position");
    run.says("in line 9");
    assert_eq!(bench.executed().len(), 9);
}

/// Grbl and LinuxCNC state the offset of a rotary axis in degrees. The machine file has 15°.
#[test]
fn the_offset_of_a_rotary_axis_is_compared() {
    let part = passes(1).replace("G0 X0 Y0\n", "G0 X0 Y0 A30\n");
    let shop = Shop::new().file("part.ngc", part).file("router.toml", turning());
    for (a, code) in [(15.0, 0), (15.5, 6), (375.0, 0)] {
        let bench = Wired::at_network(linuxcnc([100.0, 100.0, -60.0, a, 0.0]));
        let run = feed_to(&shop, "linuxcnc", &bench).exits(code);
        if code != 0 {
            run.says("A15.500, and the program is corrected for X100.000 Y100.000 Z-60.000 A15.000")
                .says("A_deg = 15.500");
            assert!(bench.executed().is_empty());
        }
    }
    // A grblHAL with three axes has no A: its offset counts as 0.
    let bench = Wired::at_line(control(ZERO));
    feed_to(&shop, "grblhal", &bench).exits(6).says("A0.000").says("no line was sent");
}

/// Marlin with `M114_DETAIL` states the offset in force after `G54`. Another build is not compared, and a person reads what to compare.
#[test]
fn marlin_with_another_zero_gets_no_motion() {
    let shop = shop(&passes(1));
    let marlin = |offset: Option<[f64; 3]>| {
        let mut control = Marlin::new(&Faults::default(), 0.002);
        (control.offset, control.tells_place) = (offset, true);
        Wired::at_line(control)
    };
    feed_to(&shop, "marlin", &marlin(Some(ZERO))).exits(0);
    assert!(shop.text("part.ngc.journal").contains(" O G54 100.000,100.000,-60.000\n"));
    let bench = marlin(Some([100.0, 107.0, -60.0]));
    let other = self::shop(&passes(1));
    feed_to(&other, "marlin", &bench).exits(6).says("G54 of the control is X100.000 Y107.000 Z-60.000");
    assert!(bench.executed().iter().all(|line| !line.contains('X') && !line.contains('Z')), "{:?}", bench.executed());
    let run = feed_to(&shop, "marlin", &marlin(None)).exits(0);
    run.says("M114_DETAIL").says("compare G54 X100.000 Y100.000 Z-60.000 at the control");
}

/// A link that cannot ask names the offsets once, before the start.
#[test]
fn a_link_without_a_question_names_what_to_compare() {
    let link = "name = \"own\"\nprotocol = \"block\"\n[frame]\nstart = \"15\"\n[text]\nlongest_line = 128\n";
    let shop = shop(&passes(1)).file("own.toml", link);
    let bench = Wired::at_network(Blockwise::new(&Faults::default(), 0.001));
    let more = ["--port", &bench.name, "--allow-starvation", "--i-checked-the-machine-stands-still"];
    let run = shop.run(["feed", "part.ngc", "--machine", "router.toml", "--link", "own.toml"].iter().chain(&more));
    let said = run.exits(0).stderr;
    assert_eq!(
        said.matches("compare G54 X100.000 Y100.000 Z-60.000 of the machine file with the control").count(),
        1,
        "{said}"
    );
}
