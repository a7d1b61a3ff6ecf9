//! The feed of cuts that turn rotary axes: what a control takes for every block, by the rules of its manual written out here, is what the
//! program takes. LinuxCNC and Sinumerik take F for X, Y, Z where these move at all, else for the rotary axes in degrees.

use ncfix_base::geometry::AxisVector;
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, Kind};
use ncfix_model::file;

use crate::support::Shop;

/// A table C under three axes, which runs out by 20 µm per radian.
fn table(controller: &str, errors: &str) -> String {
    let point = if controller == "fanuc" { "decimal_point = \"calculator\"\n" } else { "" };
    format!(
        "[machine]\nname = \"t\"\ntopology = \"wCFXYZSt\"\ncontroller = \"{controller}\"\n\
         [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-900, 900]\n\
         [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-900, 900]\n\
         [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-900, 900]\n\
         [axis.C]\ndirection = [0, 0, -1]\ntravel_deg = [-900, 900]\n\
         [control]\nincrement_mm = 0.001\nincrement_deg = 0.001\n{point}[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n{errors}"
    )
}

const ERRORS: &str = "[[motion]]\ncomponent = \"EXC\"\nkind = \"polynomial\"\ncoefficients = [0, 0.02]\n";

/// The minutes that a control takes for the cuts of each block, by its number.
fn minutes(name: &str, text: &str, machine: &Machine) -> Vec<(u32, f64)> {
    let (elements, codes) = crate::iso::elements(name, text, machine, Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{codes:?}\n{text}");
    let (mut at, mut number, mut taken) = (AxisVector::ZERO, 0, Vec::new());
    for Element { number: found, kind, .. } in &elements {
        number = found.map_or(number, |found| found.number);
        let Kind::Move(motion) = kind else { continue };
        let way = motion.target - at;
        at = motion.target;
        let linear_mm = way.xyz().norm();
        let counted = if linear_mm > 1e-9 { linear_mm } else { way.0[8].abs().to_degrees() };
        if !motion.rapid && counted > 0.0 {
            let minutes = if motion.is_inverse_time() { 1.0 / motion.feed } else { counted / motion.feed };
            match taken.last_mut() {
                Some((last, sum)) if *last == number => *sum += minutes,
                _ => taken.push((number, minutes)),
            }
        }
    }
    taken
}

fn corrected(controller: &str, errors: &str, program: &str) -> (String, Vec<[f64; 2]>) {
    let text = table(controller, errors);
    let shop = Shop::new().file("t.toml", &text).file("in.nc", program);
    shop.run(["in.nc", "-o", "out.nc", "--machine", "t.toml", "--dialect", controller]).exits(0);
    let written = shop.text("out.nc");
    let machine = file::load(&Source::new(FileId(0), "t.toml", text.into_bytes()).unwrap()).0.unwrap().0;
    let [before, after] = [program, &written].map(|text| minutes(controller, text, &machine));
    assert_eq!(before.len(), after.len(), "{written}");
    let pairs = before.iter().zip(&after).map(|(&(number, before), &(other, after))| {
        assert_eq!(number, other, "{written}");
        [before, after]
    });
    (written.clone(), pairs.collect())
}

const PROGRAM: &str = "G21 G90 G94 G54\nN1 G0 X50 Y0 Z0 C0\nN10 G1 C90 F500\nN20 X60 F300\nN30 X60.01 C180 F20\nN40 S900 M3\nN50 G1 C0 F700\n\
                       N60 G0 Z5\nN70 G1 C45 F700\nN80 X160 C90 F400\nM30\n";

#[test]
fn blocks_that_turn_an_axis_alone_take_the_time_that_they_took() {
    for controller in ["rs274", "sinumerik"] {
        let program = if controller == "sinumerik" { PROGRAM.replace("G21", "G17 G71") } else { PROGRAM.to_owned() };
        let (text, minutes) = corrected(controller, ERRORS, &program);
        // 90 degrees at 500 degrees a minute, 10 µm at 20 mm a minute, 180 and 45 degrees at 700.
        for (block, wanted) in [(0, 90.0 / 500.0), (2, 0.01 / 20.0), (3, 180.0 / 700.0), (4, 45.0 / 700.0)] {
            assert!((minutes[block][0] / wanted - 1.0).abs() < 1e-9, "{minutes:?}");
        }
        for [before, after] in &minutes {
            assert!((after / before - 1.0).abs() < 0.01, "{controller}: {before} {after}\n{text}");
        }
        let lines: Vec<&str> = text.lines().filter(|line| line.contains("G93") || line.contains("G94")).collect();
        // The program's own; then where only C turns, and back where X moves. The end of the program ends the mode.
        let modes: Vec<&str> =
            lines.iter().flat_map(|line| line.split(' ')).filter(|word| ["G93", "G94"].contains(word)).collect();
        assert_eq!(modes, ["G94", "G93", "G94", "G93", "G94"], "{text}");
        assert!(lines[1].starts_with("N10 G93 G1") && lines[2].starts_with("N20 G94 G1"), "{text}");
    }
}

/// What acts in one block stays in the line of its motion: machine coordinates, an exact stop at the last piece.
#[test]
fn words_of_one_block_stay_with_their_motion() {
    for word in ["SUPA", "G153", "G53"] {
        let program = format!(
            "N1 G17 G71 G90 G94 G54\nN2 G0 X30 Y0 Z20 C0\nN10 {word} G1 C50 F500\nN20 G1 C45\nN30 G9 G1 C90\nN40 G1 X35 F300 M8\nN50 G1 C5 F500 M30\n"
        );
        let text = table("sinumerik", ERRORS).replace("[zero_offset.G54]\nX_mm = 0", "[zero_offset.G54]\nX_mm = 7");
        let shop = Shop::new().file("t.toml", &text).file("in.nc", &program);
        shop.run(["in.nc", "-o", "out.nc", "--machine", "t.toml"]).exits(0);
        let written = shop.text("out.nc");
        // The judge executes both: where the machine coordinates were lost, the programs would differ by the zero offset.
        shop.run(["verify", "in.nc", "out.nc", "--machine", "t.toml"]).exits(0);
        let lines: Vec<&str> = written.lines().collect();
        let first = lines.iter().position(|line| line.starts_with("N10")).unwrap();
        assert!(lines[first].starts_with(&format!("N10 {word} G93 G1")), "{written}");
        let behind = lines[first + 1..].iter().take_while(|line| !line.starts_with('N'));
        assert!(behind.clone().count() > 0 && behind.clone().all(|line| line.starts_with(word)), "{written}");
        let stop = lines.iter().position(|line| line.contains("G9 ")).unwrap();
        assert!(lines[stop].contains('C') && lines[stop + 1].starts_with("N40 G94 G1"), "{written}");
        assert!(lines.last().unwrap().contains("M30"), "{written}");
    }
}

#[test]
fn a_control_that_counts_all_axes_needs_no_times() {
    let (text, _) = corrected("fanuc", ERRORS, PROGRAM);
    assert!(!text.contains("G93"), "{text}");
}

#[test]
fn where_nothing_is_added_feeds_stay() {
    for errors in ["", "[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n"] {
        let (text, _) = corrected("rs274", errors, PROGRAM);
        assert!(!text.contains("G93"), "{text}");
    }
}

/// FGROUP with a rotary axis makes its way part of the path, with the radius FGREF: a few micrometers change nothing then.
#[test]
fn a_program_that_says_for_which_axes_a_feed_is_keeps_it() {
    for (words, is_by_time) in [
        ("FGROUP(X,Y,Z,C) FGREF[C]=10", false),
        ("FGROUP(X,Y)", true),
        ("FGROUP(C)\nN7 FGROUP()", true),
        ("fgroup( x , c )", false),
    ] {
        let program = format!("N1 G17 G71 G90 G94 G54\nN5 {words}\nN9 G0 X50 Y0 Z0 C0\nN10 G1 C90 F500\nN20 M30\n");
        let text = corrected("sinumerik", ERRORS, &program).0;
        assert_eq!(text.contains("G93"), is_by_time, "{text}");
    }
}

#[test]
fn the_end_of_a_program_without_an_end_says_what_a_feed_is() {
    let (text, _) = corrected("rs274", ERRORS, "G21 G90 G94 G54\nN1 G0 X50 Y0 Z0 C0\nN10 G1 C90 F500\n");
    assert!(text.trim_end().ends_with("G94"), "{text}");
}

/// A control may keep G93 after M30, and the next program would read its F as an inverse time.
#[test]
fn a_program_that_ends_after_a_turn_returns_to_its_feed() {
    for (controller, before, end) in
        [("rs274", "G21 G90 G94 G54\n", "M2\n"), ("sinumerik", "G71 G90 G94 G54\n", "M30\n")]
    {
        // In a block of its own, after a rapid move, in the block of the turn.
        for between in ["\nN30 ", "\nN20 G0 Z20.\nN30 ", " "] {
            let program = format!("{before}N1 G0 X50. Y0. Z0. C0.\nN10 G1 C90. F500.{between}{end}");
            let (text, _) = corrected(controller, ERRORS, &program);
            let places = ["G93", "G94", "M"].map(|word| {
                let last = text.lines().enumerate().filter(|(_, line)| {
                    line.split(' ').any(|own| own.starts_with(word)) && !line.starts_with([';', '('])
                });
                last.map(|(number, line)| (number, line.find(word))).last()
            });
            let [by_time, feed, end] = places.map(|place| place.unwrap_or_else(|| panic!("{text}")));
            assert!(by_time < feed && feed < end, "{text}");
        }
    }
}

#[test]
fn what_cannot_say_a_time_is_refused() {
    let grundig = "%PM9001\nN9001\nN1 G17 G90 G71\nN2 G54\nN3 G0 X50 Y0 Z0 C0\nN4 G1 C90 F500\nN5 M30\n";
    let turning = PROGRAM.replace("G21", "G71").replace("G94", "G95").replace("F500", "F5");
    for (controller, program) in [("grundig", grundig), ("sinumerik", &turning)] {
        let shop = Shop::new().file("t.toml", table(controller, ERRORS)).file("in.nc", program);
        let run = shop.run(["in.nc", "-o", "out.nc", "--machine", "t.toml", "--dialect", controller]).exits(4);
        run.says("E0313").says("rotary axes turn here");
        assert!(!shop.names().contains(&"out.nc".to_owned()));
        // Without errors nothing is added.
        let shop = Shop::new().file("t.toml", table(controller, "")).file("in.nc", program);
        shop.run(["in.nc", "-o", "out.nc", "--machine", "t.toml", "--dialect", controller]).exits(0);
    }
}

/// A comparison sees times: what the correction wrote has the feeds of the program, and a block that says it takes a hundredth of its time has not.
#[test]
fn a_comparison_sees_how_long_blocks_take() {
    let text = table("rs274", ERRORS);
    let shop = Shop::new().file("t.toml", &text).file("in.nc", PROGRAM);
    shop.run(["in.nc", "-o", "out.nc", "--machine", "t.toml", "--dialect", "rs274"]).exits(0);
    let compared = |name: &str| {
        shop.run(["diff", "in.nc", name, "--machine", "t.toml", "--dialect", "rs274", "--json"]).exits(1).json()
    };
    let found = compared("out.nc");
    assert_eq!((&found["other_feeds"], &found["feed_share"]), (&0.into(), &serde_json::Value::Null), "{found}");
    let written = shop.text("out.nc");
    let mut is_by_time = false;
    let faster = |line: &str, by: f64| {
        let words = line.split(' ').map(|word| match word.strip_prefix('F') {
            Some(feed) => format!("F{}", feed.parse::<f64>().unwrap() * by),
            None => word.to_owned(),
        });
        words.collect::<Vec<_>>().join(" ") + "\n"
    };
    let times = written.lines().map(|line| {
        is_by_time = (is_by_time || line.contains("G93")) && !line.contains("G94");
        faster(line, if is_by_time { 100.0 } else { 1.0 })
    });
    let times: String = times.collect();
    // 20 in place of the 90/500 min and the 180/700 of N10 and N50; and a feed of X, by 1 %.
    let feeds: String =
        written.lines().map(|line| faster(line, if line.contains("N20") { 1.01 } else { 1.0 })).collect();
    for (name, text, least, most) in [("times.nc", &times, 95.0, 105.0), ("feeds.nc", &feeds, 1.009_99, 1.010_01)] {
        std::fs::write(shop.path(name), text).unwrap();
        let found = compared(name);
        let [low, high] = [0, 1].map(|k| found["feed_share"][k].as_f64().unwrap());
        assert!(found["other_feeds"].as_u64().unwrap() >= 1 && low > least && high < most, "{found}");
    }
    // The flat stream says what is a time.
    let flat = shop.run(["snc", "out.nc", "--machine", "t.toml", "--dialect", "rs274"]).exits(0).stdout;
    let marked = |is_marked: bool| {
        flat.lines().filter(|line| line.starts_with("G1") && line.contains(" G93 ;@") == is_marked).count()
    };
    assert!(marked(true) >= 2 && marked(false) >= 2, "{flat}");
}

/// Feeds of curves that turn an axis are compared as numbers; per minute and per turn are never the same; and what the output writes in machine
/// coordinates under a transformation has the feed of the tip.
#[test]
fn a_comparison_sees_feeds_of_curves_and_units() {
    let text = table("sinumerik", ERRORS);
    let program = "N1 G17 G71 G90 G94 G54\nN2 S500 M3\nN3 G0 X50 Y0 Z0 C0\nN10 G3 X50 Y0 I-10 J0 C60 F1500\nN30 M30\n";
    let shop = Shop::new().file("t.toml", &text).file("in.mpf", program);
    shop.run(["in.mpf", "-o", "out.mpf", "--machine", "t.toml"]).exits(0);
    let written = shop.text("out.mpf");
    std::fs::write(shop.path("fast.mpf"), written.replace("F1500", "F1515")).unwrap();
    let found = shop.run(["diff", "in.mpf", "fast.mpf", "--machine", "t.toml", "--json"]).exits(1).json();
    assert!((found["feed_share"][1].as_f64().unwrap() - 1.01).abs() < 1e-9, "{found}");
    std::fs::write(shop.path("turns.mpf"), written.replace("G94", "G95")).unwrap();
    shop.run(["verify", "in.mpf", "turns.mpf", "--machine", "t.toml"]).exits(4).says("E0321").says("F1500 G95");
    let swarf = crate::support::repository("samples/programs/sinumerik/swarf.mpf").display().to_string();
    let machine = crate::support::machine("esmaeili_huron");
    shop.run([&swarf, "-o", "swarf.mpf", "--frame", "machine", "--machine", &machine]).exits(0);
    let found = shop.run(["diff", &swarf, "swarf.mpf", "--machine", &machine, "--json"]).exits(1).json();
    assert_eq!(found["other_feeds"], 0, "{}", found["feed_share"]);
    // What FGROUP says of the tip and of rotary axes together cannot be said without the transformation.
    let program =
        "G17 G71 G90 G94 G54\nT1 D1\nFGROUP(X,Y,Z,C)\nTRAORI\nG0 X10 Y5 Z20 A0 C0\nG1 A20 X5 C27 F500\nTRAFOOF\nM30\n";
    let shop = shop.file("group.mpf", program);
    let run = shop.run(["group.mpf", "-o", "axes.mpf", "--five-axis", "axes", "--machine", &machine]);
    assert!(run.code == 4 && run.stderr.contains("E0313") && run.stderr.contains("FGROUP"), "{}", run.stderr);
}
