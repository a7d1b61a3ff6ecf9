//! `ncfix resume`: what was carried out for sure, where the tool comes clear of the workpiece, and that nothing goes out to a control that is not idle.
//!
//! Journals here are those of real transfers to a simulated control, cut off where the text says.

use super::cli_feed::{corrected, passes, signal, start};
use super::controls::{Faults, Grbl, Wired};
use super::support::{Run, Shop, machine, repository};

/// Above the 50 mm of [`passes`].
const CLEARANCE: &str = "60mm";

fn grbl(busy_s: f64) -> Grbl {
    Grbl::new(&Faults::default(), busy_s)
}

/// A job whose sender is killed, and whose control loses its current, when so many lines were carried out; the plan for it.
fn broken(control: Grbl, link: &str, after: usize) -> (Shop, Wired<Grbl>, serde_json::Value) {
    broken_in(passes(40), control, link, after)
}

fn broken_in(program: String, control: Grbl, link: &str, after: usize) -> (Shop, Wired<Grbl>, serde_json::Value) {
    let bench = Wired::at_line(control);
    let shop = Shop::new().file("part.ngc", program);
    let mill = machine("knee_mill");
    let mut child = start(&shop, &["feed", "part.ngc", "--machine", &mill, "--link", link, "--port", &bench.name]);
    bench.wait_for(after);
    bench.shared.lock().unwrap().hold();
    // What it has taken meanwhile, as much as it can or as the program has.
    let (mut planned, mut quiet) = (0, 0);
    while quiet < 4 {
        std::thread::sleep(std::time::Duration::from_millis(250));
        let now = bench.shared.lock().unwrap().planned();
        quiet = if now == planned { quiet + 1 } else { 0 };
        planned = now;
    }
    bench.shared.lock().unwrap().fail();
    signal(&child, "KILL");
    child.wait().unwrap();
    let run = shop.run(["resume", "part.ngc.journal", "--json", "--clearance", CLEARANCE]);
    assert_eq!(run.code, 0, "{run:?}");
    let plan = serde_json::from_str(&run.stdout).unwrap();
    (shop, bench, plan)
}

/// A job whose cable is drawn after a number of lines.
fn drawn(shop: &Shop, arguments: &[&str], after: usize) {
    let bench = Wired::at_network(grbl(0.004));
    let mut child = start(shop, &[arguments, &["--port", &bench.name]].concat());
    bench.wait_for(after);
    drop(bench);
    assert_eq!(child.wait().unwrap().code(), Some(5), "{}", shop.text("stderr"));
}

/// A job breaks off twice. The second part has executed nothing for certain, and what the first one has executed is not machined again.
#[test]
fn a_job_that_breaks_off_twice_keeps_what_its_first_part_has_executed() {
    let shop = Shop::new().file("part.ngc", passes(20));
    let mill = machine("knee_mill");
    let plan = |shop: &Shop| -> serde_json::Value {
        let run = shop.run(["resume", "part.ngc.journal", "--json", "--clearance", CLEARANCE]).exits(0);
        serde_json::from_str(&run.stdout).unwrap()
    };
    let resume = ["resume", "part.ngc.journal", "--clearance", CLEARANCE, "--confirm"];
    drawn(&shop, &["feed", "part.ngc", "--machine", &mill, "--link", "grbl"], 160);
    let first = plan(&shop);
    assert!(first["executed"].as_u64().unwrap() > 60 && first["source_line"].as_u64().unwrap() > 60, "{first}");
    drawn(&shop, &[&resume[..], &[first["plan"].as_str().unwrap()]].concat(), 12);
    let second = plan(&shop);
    assert_eq!((&second["source_line"], &second["before"]), (&first["source_line"], &first["before"]), "{second}");
    assert!(second["executed_line"].as_u64() >= first["executed_line"].as_u64(), "{second}");
    let text = shop.run(["resume", "part.ngc.journal", "--clearance", CLEARANCE]).exits(0).stdout;
    assert!(text.contains("for certain, in an earlier part of the job"), "{text}");
    let bench = Wired::at_line(grbl(0.0005));
    let last = [&resume[..], &[second["plan"].as_str().unwrap(), "--port", &bench.name]].concat();
    shop.run(last).exits(0);
    let planned = corrected(&shop, "part.ngc", &["--machine", &mill]);
    let rest = bench.executed().split_off(second["before"].as_array().unwrap().len());
    assert!(planned.ends_with(&rest) && rest.len() < planned.len() - 60, "{rest:?}");
}

/// Such a link needs a person who looked, so the printed command says so.
#[test]
fn the_command_of_a_plan_can_be_carried_out_as_it_stands() {
    let shop = cut_off(&passes(4), 45);
    let command = |shop: &Shop| {
        let run = shop.run(["resume", "part.ngc.journal", "--clearance", CLEARANCE]).exits(0);
        run.stdout.lines().last().unwrap().to_owned()
    };
    assert!(!command(&shop).contains("--i-checked"), "{}", command(&shop));
    let link = std::fs::read_to_string(repository("crates/dnc/links/haas.toml")).unwrap();
    let any: Vec<&str> = link.lines().filter(|line| !line.starts_with("dialects")).collect();
    let shop = Shop::new().file("part.ngc", passes(4)).file("any.toml", any.join("\n"));
    let server = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp:{}", server.local_addr().unwrap());
    // It takes a few lines, and the cable is drawn.
    let reader = std::thread::spawn(move || {
        use std::io::{Read as _, Write as _};
        let (mut stream, _) = server.accept().unwrap();
        stream.write_all(&[0x11]).unwrap();
        stream.read_exact(&mut [0; 60]).unwrap();
    });
    let mill = machine("knee_mill");
    let arguments =
        ["feed", "part.ngc", "--machine", &mill, "--link", "any.toml", "--port", &port, "--allow-starvation"];
    shop.run([&arguments[..], &["--i-checked-the-machine-stands-still"]].concat()).exits(5);
    reader.join().unwrap();
    assert!(command(&shop).ends_with(" --clearance 60mm --i-checked-the-machine-stands-still"), "{}", command(&shop));
}

/// Lines of the program before the place at which a plan begins again.
fn left_out(shop: &Shop, plan: &serde_json::Value) -> usize {
    let mill = machine("knee_mill");
    let lines = corrected(shop, "part.ngc", &["--machine", &mill]);
    if plan["is_beginning"].as_bool().unwrap() {
        return 0;
    }
    let first: Vec<&str> = plan["first"].as_array().unwrap().iter().map(|line| line.as_str().unwrap()).collect();
    let places: Vec<usize> = (0..lines.len()).filter(|&k| lines[k..].iter().zip(&first).all(|(a, b)| a == b)).collect();
    *places.last().unwrap()
}

/// Three contours of 300 short cuts, between them rapid moves above the plate.
fn long_contours() -> String {
    let mut text = "G21 G90 G17 G54 G94\nS2000 M3\nG0 Z50\nG0 X0 Y0\n".to_owned();
    for pass in 0..3 {
        text += &format!("G0 X0 Y{}\nG0 Z2\nG1 Z-1 F300\n", 5 * pass);
        for step in 1..=300 {
            text += &format!("G1 X{:.2} Y{}.{} F1200\n", 0.25 * f64::from(step), 5 * pass, step % 2);
        }
        text += "G1 Z2\nG0 Z50\n";
    }
    text + "M5\nM30\n"
}

#[test]
fn no_block_of_a_deep_planner_is_skipped() {
    for after in [150, 450] {
        let (shop, bench, plan) = broken_in(long_contours(), grbl(0.005).of_a_hundred_blocks(), "grblhal", after);
        let executed = bench.executed().len();
        let [sure, acknowledged] = ["executed", "acknowledged"].map(|key| plan[key].as_u64().unwrap() as usize);
        // Within a contour the control does not come to rest: it has acknowledged nearly all that it holds.
        assert!(acknowledged >= executed + 90, "{acknowledged} {executed}");
        assert!(sure <= executed, "{after}: {sure} for sure, {executed} carried out");
        assert!(left_out(&shop, &plan) <= executed, "{after}: blocks are skipped");
        assert_eq!(plan["holds"], 116);
        assert!(plan["holds_source"].as_str().unwrap().contains("[OPT:V,100,1024]"), "{plan}");
        assert!(after < 450 || !plan["is_beginning"].as_bool().unwrap(), "{plan}");
    }
}

#[test]
fn where_the_control_states_no_depth_only_what_it_said_when_it_stood_still_is_sure() {
    let (shop, bench, plan) = broken(grbl(0.002).that_tells_no_sizes(), "grblhal", 200);
    let executed = bench.executed().len();
    let sure = plan["executed"].as_u64().unwrap() as usize;
    // It comes to rest behind a rapid move every 50 lines or some more: a pass has 13 lines or more.
    assert!(0 < sure && sure <= executed && sure + 150 > executed, "{sure} of {executed}: {plan}");
    assert!(left_out(&shop, &plan) <= sure, "{plan}");
    assert_eq!(plan["holds"], serde_json::Value::Null);
    assert!(plan["acknowledged"].as_u64().unwrap() >= 200, "{plan}");
    let told = shop.run(["resume", "part.ngc.journal", "--clearance", CLEARANCE]);
    assert!(told.stdout.contains("did not state how much it holds"), "{told:?}");
    // A bound of the profile, with its source, counts with what still moves beside it; not less than what the control states.
    let (own, text) = (
        "own.toml",
        "name = \"own\"\nprotocol = \"grbl\"\n[window]\nlines = 15\nbytes = 120\n[depth]\nat_most = 10\nsource = \"planner.h\"\n",
    );
    // Slow enough for reports between the lines, however busy the computer is.
    for (control, expected) in [(grbl(0.01).that_tells_no_sizes(), 26), (grbl(0.01), 31)] {
        let bench = Wired::at_line(control);
        let shop = Shop::new().file("part.ngc", passes(40)).file(own, text);
        let mill = machine("knee_mill");
        let mut child = start(&shop, &["feed", "part.ngc", "--machine", &mill, "--link", own, "--port", &bench.name]);
        bench.wait_for(200);
        bench.shared.lock().unwrap().fail();
        signal(&child, "KILL");
        child.wait().unwrap();
        let plan = shop.run(["resume", "part.ngc.journal", "--json", "--clearance", CLEARANCE]).exits(0).json();
        assert_eq!(plan["holds"], expected, "{plan}");
        let sure = plan["executed"].as_u64().unwrap() as usize;
        assert!(0 < sure && sure <= bench.executed().len(), "{plan}");
    }
}

#[test]
fn a_control_that_is_not_idle_gets_no_line_of_a_job_that_is_taken_up_again() {
    let (shop, _bench, plan) = broken(grbl(0.002), "grbl", 200);
    let number = plan["plan"].as_str().unwrap();
    let journal = shop.bytes("part.ngc.journal");
    for (state, word) in
        [("Run", "let it end"), ("Hold:0", "cycle start"), ("Door:0", "door"), ("Check", "$C"), ("Sleep", "sleeps")]
    {
        let busy = Wired::at_line(grbl(0.002).that_says(state));
        let run = shop.run([
            "resume",
            "part.ngc.journal",
            "--port",
            &busy.name,
            "--confirm",
            number,
            "--clearance",
            CLEARANCE,
        ]);
        assert!(
            run.code == 6 && run.stderr.contains(word) && run.stderr.contains("no line was sent"),
            "{state}: {run:?}"
        );
        assert!(busy.executed().is_empty(), "{state}");
        // The job is still there to be taken up again.
        shop.run(["resume", "part.ngc.journal.old", "--clearance", CLEARANCE]).exits(0);
        std::fs::remove_file(shop.path("part.ngc.journal.old")).unwrap();
        std::fs::write(shop.path("part.ngc.journal"), &journal).unwrap();
    }
}

#[test]
fn a_link_without_a_question_needs_a_person_who_looked() {
    let shop = Shop::new().file("part.ngc", passes(2));
    let mill = machine("knee_mill");
    for link in ["haas", "fanuc-rs232", "siemens-v24", "grundig-v24", "heidenhain-fe1"] {
        // The dialogue alone matters here, so the link accepts any dialect.
        let profile = std::fs::read_to_string(repository(&format!("crates/dnc/links/{link}.toml"))).unwrap();
        let any: Vec<&str> = profile.lines().filter(|line| !line.starts_with("dialects")).collect();
        let link = &format!("{link}.toml");
        std::fs::write(shop.path(link), any.join("\n")).unwrap();
        let arguments = [
            "feed",
            "part.ngc",
            "--machine",
            &mill,
            "--link",
            link,
            "--port",
            "/dev/no-such-port",
            "--allow-starvation",
        ];
        let run = shop.run(arguments);
        assert!(run.code == 4 && run.stderr.contains("E0705"), "{link}: {run:?}");
        let run = shop.run([&arguments[..], &["--i-checked-the-machine-stands-still"]].concat());
        assert!(run.code == 5 && !run.stderr.contains("E0705"), "{link}: {run:?}");
    }
    for link in ["grbl", "grblhal", "marlin", "linuxcnc"] {
        let run = shop.run([
            "feed",
            "part.ngc",
            "--machine",
            &mill,
            "--link",
            link,
            "--port",
            "/dev/no-such-port",
            "--allow-starvation",
        ]);
        assert!(run.code == 5, "{link}: {run:?}");
    }
}

/// A job that is cut off when so many lines were acknowledged.
pub(crate) fn cut_off(program: &str, acknowledged: usize) -> Shop {
    let bench = Wired::at_line(grbl(0.0002));
    // A control that speaks like Grbl and knows all words.
    let profile = std::fs::read_to_string(repository("crates/dnc/links/grbl.toml")).unwrap();
    let any: Vec<&str> = profile.lines().filter(|line| !line.starts_with("firmware")).collect();
    let shop = Shop::new().file("part.ngc", program).file("any.toml", any.join("\n"));
    let mill = machine("knee_mill");
    shop.run(["feed", "part.ngc", "--machine", &mill, "--link", "any.toml", "--port", &bench.name]).exits(0);
    let journal = shop.text("part.ngc.journal");
    let is_kept = |line: &&str| {
        let mut words = line.split(' ');
        match (words.next(), words.next()) {
            (Some(_), Some("F")) => words.next().unwrap().parse::<usize>().unwrap() <= acknowledged + 4,
            (Some(_), Some("A" | "C" | "X" | "E" | "W")) => false,
            _ => true,
        }
    };
    let mut cut: Vec<&str> = journal.lines().filter(is_kept).collect();
    let last = format!("9999 A {acknowledged}\n9999 C {acknowledged}\n");
    cut.push(&last);
    std::fs::write(shop.path("part.ngc.journal"), cut.join("\n")).unwrap();
    shop
}

/// Words of a plan, before the program.
fn before(plan: &serde_json::Value) -> Vec<String> {
    plan["before"].as_array().unwrap().iter().map(|line| line.as_str().unwrap().to_owned()).collect()
}

#[test]
fn a_program_of_one_depth_is_not_taken_up_again_without_a_clearance() {
    // Letters 0.05 mm deep, all retracts to 0.2 mm: the plunges begin there.
    let mut text = "G21 G90 G17 G54\nS12000 M3\nG0 Z0.2\n".to_owned();
    for k in 0..30 {
        text += &format!("G0 X{} Y0\nG1 Z-0.05 F100\nG1 X{} F300\nG1 Y4\nG0 Z0.2\n", 5 * k, 5 * k + 3);
    }
    let shop = cut_off(&(text + "M5\nM30\n"), 120);
    let run = shop.run(["resume", "part.ngc.journal"]);
    assert!(run.code == 4 && run.stderr.contains("E0706") && run.stderr.contains("--clearance"), "{run:?}");
    let low = shop.run(["resume", "part.ngc.journal", "--clearance", "0.2mm"]);
    assert!(low.code == 4 && low.stderr.contains("E0707") && low.stderr.contains("0.200 mm of the program"), "{low:?}");
    // Not 1 mm above it either; and the machine ends at 420 mm, 360 mm of the program in G54 (60 mm).
    let low = shop.run(["resume", "part.ngc.journal", "--clearance", "1.1mm"]);
    assert!(low.code == 4 && low.stderr.contains("E0707"), "{low:?}");
    for beyond in ["9000mm", "360.5mm"] {
        let run = shop.run(["resume", "part.ngc.journal", "--clearance", beyond]);
        assert!(run.code == 4 && run.stderr.contains("E0707") && run.stderr.contains("to 360.000 mm"), "{run:?}");
    }
    shop.run(["resume", "part.ngc.journal", "--clearance", "359.5mm"]).exits(0);
    let plan = |run: Run| run.exits(0).json();
    let found = plan(shop.run(["resume", "part.ngc.journal", "--clearance", "5mm", "--json"]));
    assert!(!found["is_beginning"].as_bool().unwrap(), "{found}");
    // 5 − 0.2 mm.
    assert!((found["above_mm"].as_f64().unwrap() - 4.8).abs() < 0.01, "{found}");
    // The place itself is at the highest feed move, Z0.2: the height is that of the way to it.
    let shown = shop.run(["resume", "part.ngc.journal", "--clearance", "5mm"]).exits(0).stdout;
    assert!(shown.contains(", a rapid move; the tool crosses 4.8 mm above the highest feed move\n"), "{shown}");
    assert!(shown.contains("the first move goes to Z5. at rapid: down, if the tool is higher"), "{shown}");
    let lines = before(&found);
    let moves: Vec<&String> = lines.iter().filter(|line| line.starts_with("G0 ")).collect();
    // Down with a feed, and nothing rapid to below the stated height.
    assert!(
        moves.len() == 3 && moves[0] == "G0 Z5." && moves[1].starts_with("G0 X") && moves[2] == moves[1],
        "{lines:?}"
    );
    assert!(lines.iter().any(|line| line.starts_with("G1 Z0.") && line.ends_with(" F200.")), "{lines:?}");
    assert!(shop.run(["resume", "part.ngc.journal", "--clearance", "5"]).code == 2, "without a unit");
    // Another clearance is another plan.
    let number = found["plan"].as_str().unwrap();
    let other = shop.run(["resume", "part.ngc.journal", "--clearance", "6mm", "--confirm", number]);
    assert!(other.code == 2 && other.stderr.contains("not the plan number"), "{other:?}");
    // It is carried out as it was shown.
    let bench = Wired::at_line(grbl(0.0002));
    shop.run(["resume", "part.ngc.journal", "--clearance", "5mm", "--confirm", number, "--port", &bench.name]).exits(0);
    assert_eq!(bench.executed()[..lines.len()], lines);
}

#[test]
fn a_beginning_that_crosses_is_no_place_either() {
    // In inches; nothing is sure, as the planner may hold all of it.
    let text = "G20 G90 G54 G17\nS9000 M3\nG0 Z0.2\nG0 X0.5 Y0.5\nG1 Z-0.05 F40\nG91\nG1 X0.5\nG90\nG0 Z0.2\nG0 X1.5\nG1 Z-0.05\nG1 X2\nG0 Z0.2\nM5\nM2\n";
    let shop = cut_off(text, 10);
    let run = shop.run(["resume", "part.ngc.journal"]);
    assert!(run.code == 4 && run.stderr.contains("E0706") && run.stderr.contains("--clearance"), "{run:?}");
    let plan = shop.run(["resume", "part.ngc.journal", "--clearance", "1in", "--json"]).exits(0).json();
    let lines = before(&plan);
    assert!(plan["is_beginning"].as_bool().unwrap() && lines.len() == 2, "{plan}");
    assert_eq!(lines[1], if lines[0].contains("G20") { "G0 Z1." } else { "G0 Z25.4" });
    // Behind a tool length Z means something else: nothing can be sent before it.
    let shop = cut_off(&text.replace("S9000", "T1 M6\nG43 H1\nS9000"), 10);
    let run = shop.run(["resume", "part.ngc.journal", "--clearance", "1in"]);
    assert!(run.code == 4 && run.stderr.contains("E0706") && run.stderr.contains("by hand"), "{run:?}");
    // One that begins by lifting the tool to that height or above needs nothing.
    let lifting =
        text.replace("S9000", "T1 M6\nG43 H1\nS9000").replace("G0 Z0.2\nG0 X0.5 Y0.5", "G0 Z2\nG0 X0.5 Y0.5\nG0 Z0.2");
    let shop = cut_off(&lifting, 10);
    let plan = shop.run(["resume", "part.ngc.journal", "--json", "--clearance", "1.2in"]).exits(0).json();
    assert!(plan["is_beginning"].as_bool().unwrap() && before(&plan).is_empty(), "{plan}");
    // 1.2 − 0.2 inch.
    assert!((plan["above_mm"].as_f64().unwrap() - 25.4).abs() < 0.01, "{plan}");
    let run = shop.run(["resume", "part.ngc.journal", "--clearance", "2.5in"]);
    assert!(run.code == 4 && run.stderr.contains("E0706"), "{run:?}");
}

#[test]
fn before_a_tool_that_was_not_sent_yet_nothing_is_lifted() {
    // The first lines were only prepared: the control has neither the tool nor its length, and Z means something else there.
    let text = "G21 G90 G54 G17\nS3000 M3\nT1 M6\nG43 H1\nG0 Z5\nG0 X0 Y0\nG1 Z-1 F300\nG1 X50\nG0 Z5\nM5\nM2\n";
    for sent in 0..6 {
        let shop = cut_off(text, 10);
        let journal = shop.text("part.ngc.journal");
        let is_kept = |line: &&str| {
            let mut words = line.split(' ').skip(1);
            match words.next() {
                Some("F") => words.next().unwrap().parse::<usize>().unwrap() <= sent,
                Some("A" | "C" | "X" | "E" | "W") => false,
                _ => true,
            }
        };
        let cut: Vec<&str> = journal.lines().filter(is_kept).collect();
        std::fs::write(shop.path("part.ngc.journal"), cut.join("\n") + "\n").unwrap();
        let run = shop.run(["resume", "part.ngc.journal", "--clearance", "30mm"]);
        assert!(run.code == 4 && run.stderr.contains("E0706"), "{sent}: {run:?}");
        // Without a tool the same height is certain, with its units in front of it.
        let shop = cut_off(&text.replace("T1 M6\nG43 H1\n", ""), 10);
        let journal = shop.text("part.ngc.journal");
        let cut: Vec<&str> = journal.lines().filter(is_kept).collect();
        std::fs::write(shop.path("part.ngc.journal"), cut.join("\n") + "\n").unwrap();
        let plan = shop.run(["resume", "part.ngc.journal", "--clearance", "30mm", "--json"]).exits(0).json();
        let lines = before(&plan);
        assert!(
            lines.iter().position(|line| line.contains("G21")) < lines.iter().position(|line| line.contains("Z30")),
            "{plan}"
        );
        assert!(lines.iter().any(|line| line.contains("Z30")), "{sent}: {plan}");
    }
}

#[test]
fn nothing_begins_at_the_depth_of_a_cut_or_goes_down_to_it() {
    // One depth, all of it at Z-1, plunges and crossings beside the part at rapid: what begins there begins in what a broken tool has left.
    let mut text = "G21 G90 G17 G54\nS3000 M3\nG0 Z20\nG0 X0 Y0\nG0 Z-1\nG1 X1 F600\n".to_owned();
    for k in 0..40 {
        let (y, x) = (2 * k, if k % 2 == 0 { 50 } else { 0 });
        text += &format!(
            "G0 X{} Y{y}\nG1 X{x} F600\nG2 X{x} Y{} I0 J1 F600\nG0 Z20\nG0 X{} Y{}\nG0 Z-1\n",
            50 - x,
            y + 2,
            x,
            y + 2
        );
    }
    let shop = cut_off(&(text + "G0 Z20\nM30\n"), 160);
    let plan = shop.run(["resume", "part.ngc.journal", "--json", "--clearance", "30mm"]).exits(0).json();
    assert!(!plan["is_beginning"].as_bool().unwrap(), "{plan}");
    let lines = before(&plan);
    let depth = |line: &str| line.split(' ').find_map(|word| word.strip_prefix('Z')).map(|z| z.parse::<f64>().unwrap());
    for line in &lines {
        assert!(depth(line).is_none_or(|z| z > 19.9), "{lines:?}");
        assert!(!line.starts_with("G2") && !line.starts_with("G3") && *line != "G1", "{lines:?}");
        assert!(!line.starts_with("G0 Z") || depth(line).unwrap() >= 30.0, "{lines:?}");
    }
    let first = plan["first"][0].as_str().unwrap();
    assert!(first.starts_with("G0 X") && depth(first).is_none_or(|z| z > 19.9), "{plan}");
}

#[test]
fn a_local_retract_is_no_height_to_cross_at_from_elsewhere() {
    // A boss of 50 mm that the program cuts around; all retracts are 1.5 mm above what it cuts.
    let mut text = "G21 G90 G17 G54\nG0 Z80\nG0 X0 Y0\n".to_owned();
    for k in 0..40 {
        text += &format!("G0 X{k} Y0\nG0 Z2\nG1 Z-20 F300\nG1 Y3 F900\nG0 Z3.5\n");
    }
    let shop = cut_off(&(text + "M30\n"), 130);
    for arguments in [&["resume", "part.ngc.journal"][..], &["resume", "part.ngc.journal", "--confirm", "000000000000"]]
    {
        let run = shop.run(arguments);
        assert!(run.code == 4 && run.stderr.contains("E0706") && run.stderr.contains("--clearance"), "{run:?}");
        assert!(run.stderr.contains("Z 2.000 mm"), "{run:?}");
    }
    let plan = shop.run(["resume", "part.ngc.journal", "--json", "--clearance", "70mm"]).exits(0).json();
    let lines = before(&plan);
    let across = lines.iter().position(|line| line.starts_with("G0 X")).unwrap();
    assert_eq!(lines[across - 1], "G0 Z70.", "{lines:?}");
}

#[test]
fn codes_tools_and_coolant_are_rebuilt_as_they_were() {
    let mut text =
        "G21 G90 G17 G54\nT1 M6\nG43 H1\nG43.2 H9\nT2\nG64 P0.02\nM7\nM8\nS3000 M3\nG0 Z60\nG0 X0 Y0\n".to_owned();
    for k in 0..40 {
        text += &format!("G0 X{k} Y0\nG0 Z2\nG1 Z-1 F300\nG1 Y3 F900\nG0 Z20\n");
    }
    let shop = cut_off(&(text + "M30\n"), 130);
    let plan = shop.run(["resume", "part.ngc.journal", "--json", "--clearance", "30mm"]).exits(0).json();
    assert!(!plan["is_beginning"].as_bool().unwrap() && plan["tool"] == "T1", "{plan}");
    let lines = before(&plan);
    let at = |text: &str| lines.iter().position(|line| line == text).unwrap_or_else(|| panic!("{text}: {lines:?}"));
    assert!(at("G43 H1") < at("G43.2 H9") && at("G43.2 H9") < at("G0 Z30."), "{lines:?}");
    for line in ["G64 P0.02", "M7", "M8", "T2", "S3000 M3"] {
        assert!(at(line) < at("G0 Z30."), "{lines:?}");
    }
}

#[test]
fn a_place_is_clear_of_every_point_of_every_cut() {
    let plunge = |from: &str| format!("G0 Z{from}\nG1 Z-1 F300\nG1 Y3 F900\n");
    // Up to where it cuts, and whether its retracts are places.
    let strokes: [(&str, String, &str, f64, bool); 9] = [
        // Retracts at the height from which the tool plunges.
        ("G17", plunge("2"), "2", 2.0, true),
        ("G17", plunge("2"), "3.5", 2.0, true),
        ("G17", plunge("2"), "1.5", 2.0, false),
        // G3 in ZX from X0 to X20 around (10, 0) goes by way of +Z, 10 mm above its ends; G2 below them.
        ("G18", "G0 Z0\nG3 X{x+20} Z0 I10 K0 F3000\n".into(), "8", 10.0, false),
        ("G18", "G0 Z0\nG3 X{x+20} Z0 I10 K0 F3000\n".into(), "12", 10.0, true),
        ("G18", "G0 Z0\nG2 X{x+20} Z0 I10 K0 F3000\n".into(), "8", 0.0, true),
        // In YZ the same: G2 from Y0 to Y20 around (10, 0) goes by way of +Z.
        ("G19", "G0 Z0\nG2 Y20 Z0 J10 K0 F3000\n".into(), "8", 10.0, false),
        ("G19", "G0 Z0\nG3 Y20 Z0 J10 K0 F3000\n".into(), "8", 0.0, true),
        // A helix that ends 6 mm above its start.
        ("G17", "G0 Z0\nG3 X{x} Y0 Z6 I5 J0 F3000\n".into(), "8", 6.0, true),
    ];
    for (plane, stroke, height, highest_mm, is_place) in strokes {
        let mut text = format!("G21 G90 {plane} G54\nG0 Z60\nG0 X0 Y0\n");
        for k in 0..40 {
            let of = |text: &str| text.replace("{x+20}", &(k + 20).to_string()).replace("{x}", &k.to_string());
            text += &format!("G0 X{k} Y0\n{}G0 Z{height}\n", of(&stroke));
        }
        let shop = cut_off(&(text + "M30\n"), 130);
        let with = |clearance_mm: f64| {
            shop.run(["resume", "part.ngc.journal", "--json", "--clearance", &format!("{clearance_mm}mm")])
        };
        let low = with(highest_mm + 0.9);
        assert!(low.code == 4 && low.stderr.contains(&format!("Z {highest_mm:.2}")), "{stroke} {height}: {low:?}");
        let plan = with(highest_mm + 1.1).exits(0).json();
        let is_first = plan["source_line"].as_u64().unwrap() <= 4;
        assert!(plan["executed"].as_u64().unwrap() > 60, "{stroke}: {plan}");
        assert_eq!(is_first, !is_place, "{stroke} {height}: {plan}");
        assert!((plan["above_mm"].as_f64().unwrap() - 1.1).abs() < 0.02, "{stroke} {height}: {plan}");
    }
}

#[test]
fn in_a_tilted_plane_heights_are_measured_along_the_tool() {
    // The table turns about X through Y0, Z120 of the machine; G54 is at Y−40, Z60. At A0 the tool cuts from Y−100 to Y100 of the machine: with A90 an end
    // of that stands 100 mm above the axis. Z20 of the program is 40 mm below the axis, Z200 140 mm above it.
    let mut text = "G21 G90 G17 G54\nG0 Z200\nG0 A0\nG0 X0 Y-60\n".to_owned();
    for k in 0..10 {
        text += &format!("G0 X{k} Y-60\nG0 Z20\nG1 Z0 F500\nG1 Y140 F6000\nG0 Z20\n");
    }
    text += "G0 Z200\nG0 A90\nG0 X0 Y0\n";
    let turned = text.lines().count();
    for k in 0..30 {
        text += &format!("G0 X{} Y0\nG0 Z20\nG1 Z-5 F500\nG1 Y10 F3000\nG0 Z20\n", 3 * k);
    }
    let shop = cut_off(&(text + "M30\n"), 170);
    let plan = shop.run(["resume", "part.ngc.journal", "--json", "--clearance", "200mm"]).exits(0).json();
    let line = plan["source_line"].as_u64().unwrap() as usize;
    assert!((turned..=turned + 1).contains(&line), "{line} {turned}: {plan}");
    assert!((plan["above_mm"].as_f64().unwrap() - 40.0).abs() < 0.1, "{plan}");
}
