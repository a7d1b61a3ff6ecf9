//! `ncfix feed` and `ncfix resume` as a person uses them: the built program, a pseudo-terminal, a simulated control at its other end.

use std::fs::File;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use super::controls::{Faults, Grbl, Wired};
use super::support::{Shop, machine};

/// Nothing here takes longer.
const LONG: Duration = Duration::from_secs(60);

fn grbl(busy_s: f64) -> Wired<Grbl> {
    Wired::at_line(Grbl::new(&Faults::default(), busy_s))
}

/// Passes over a plate, between them rapid moves above it.
pub(crate) fn passes(count: usize) -> String {
    let mut text = "G21 G90 G17 G54 G94\nS2000 M3\nG0 Z50\nG0 X0 Y0\n".to_owned();
    for pass in 0..count {
        let y = pass % 50;
        text += &format!("G0 X0 Y{y}\nG0 Z2\nG1 Z-1 F300\n");
        for step in 1..=8 {
            text += &format!("G1 X{} F1200\n", step * 10);
        }
        text += "G1 Z2\nG0 Z50\n";
    }
    text + "M5\nM30\n"
}

fn command(shop: &Shop, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ncfix"));
    command.args(arguments).current_dir(shop.path(".").canonicalize().unwrap()).stdin(Stdio::null());
    command
}

pub(crate) fn start(shop: &Shop, arguments: &[&str]) -> Child {
    let error = File::create(shop.path("stderr")).unwrap();
    command(shop, arguments).stdout(Stdio::piped()).stderr(error).spawn().unwrap()
}

/// What the corrected program has, line by line, without stamp, comments and frame.
pub(crate) fn corrected(shop: &Shop, name: &str, arguments: &[&str]) -> Vec<String> {
    let mut all = vec![name, "-o", "corrected.ngc"];
    all.extend(arguments);
    let run = shop.run(all);
    assert_eq!(run.code, 0, "{run:?}");
    let text = shop.text("corrected.ngc");
    let lines = text.lines().map(|line| line.split(" (").next().unwrap().trim().to_owned());
    lines.filter(|line| !line.is_empty() && !line.starts_with(['(', ';']) && line != "%").collect()
}

#[test]
fn a_program_goes_to_the_control_as_it_would_go_into_a_file() {
    let bench = grbl(0.0002);
    let shop = Shop::new().file("part.ngc", passes(12));
    let mill = machine("knee_mill");
    let run = shop.run(["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", &bench.name, "--json"]);
    assert_eq!(run.code, 0, "{run:?}");
    let planned = corrected(&shop, "part.ngc", &["--machine", &mill]);
    assert_eq!(bench.executed(), planned);
    // 12 passes of 13 blocks, 6 others; pieces are at least as many.
    assert!(planned.len() >= 162, "{}", planned.len());
    let end: serde_json::Value = serde_json::from_str(run.stdout.lines().last().unwrap()).unwrap();
    let forecast: serde_json::Value = serde_json::from_str(run.stdout.lines().next().unwrap()).unwrap();
    assert_eq!((&end["event"], &end["ended"]), (&"end".into(), &"done".into()));
    assert_eq!((&end["acknowledged"], &forecast["lines"]), (&planned.len().into(), &planned.len().into()));
    assert!(shop.text("part.ngc.journal").contains(" E done"));
    // A journal of a job that is done gives way, and is kept.
    let again = shop.run(["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", &bench.name]);
    assert_eq!(again.code, 0, "{again:?}");
    assert!(shop.path("part.ngc.journal.old").exists());
    assert!(
        again.stderr.contains("acknowledged") && again.stderr.contains("buffer       fewest lines waiting: "),
        "{}",
        again.stderr
    );
}

#[test]
fn what_the_link_cannot_take_is_found_before_anything_is_sent() {
    let bench = grbl(0.001);
    let profile = "name = \"short\"\nprotocol = \"grbl\"\n[text]\nlongest_line = 12\nrefused = \"?!~\"\n";
    let shop = Shop::new().file("part.ngc", passes(1)).file("short.toml", profile);
    let mill = machine("knee_mill");
    let run = shop.run(["feed", "part.ngc", "--machine", &mill, "--link", "short.toml", "--port", &bench.name]);
    assert_eq!(run.code, 4, "{run:?}");
    assert!(run.stderr.contains("E0701") && run.stderr.contains("characters"), "{}", run.stderr);
    assert!(bench.executed().is_empty() && !shop.path("part.ngc.journal").exists());
    // A program with a fault is not sent either, and all faults come up.
    let shop = Shop::new().file("bad.ngc", "G0 X1 Y1 Z1\nG1 X5\nG123\nX[1/0]\n");
    let run = shop.run(["feed", "bad.ngc", "--machine", &mill, "--link", "grbl", "--port", &bench.name]);
    assert!(matches!(run.code, 3 | 4), "{run:?}");
    assert!(bench.executed().is_empty());
    let run = shop.run(["feed", "bad.ngc", "--machine", &mill, "--link", "gerbil", "--port", &bench.name]);
    assert!(run.code == 2 && run.stderr.contains("unknown link 'gerbil'"), "{run:?}");
}

#[test]
fn a_link_that_is_too_slow_is_refused_beforehand() {
    // 11 bits a character at 9600 Bd: 873 characters a second. Pieces of 1 mm at 3000 mm/min: 50 lines a second of about 18 bytes.
    let mut text = "G21 G90 G17 G54\nG0 X0 Y0 Z5\n".to_owned();
    (1..=300).for_each(|k| text += &format!("G1 X{}.{} Y{} F3000\n", k, k % 10, k % 2));
    let slow = "name = \"slow\"\nprotocol = \"grbl\"\n[serial]\nbaud = 9600\ndata_bits = 7\nparity = \"even\"\nstop_bits = 2\n";
    let shop = Shop::new().file("part.ngc", text).file("slow.toml", slow);
    let mill = machine("knee_mill");
    let arguments =
        ["feed", "part.ngc", "--machine", &mill, "--link", "slow.toml", "--port", "/dev/ttyS0", "--dry-run"];
    let run = shop.run(arguments);
    assert_eq!(run.code, 4, "{run:?}");
    assert!(run.stderr.contains("E0702") && run.stderr.contains("lines/s"), "{}", run.stderr);
    let run = shop.run([&arguments[..], &["--allow-starvation"]].concat());
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.stderr.contains("W0701") && run.stdout.contains("late"), "{run:?}");
    // Over a network it keeps up.
    let run = shop.run(["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", "tcp:x:1", "--dry-run"]);
    assert!(run.code == 0 && run.stdout.contains("keeps up"), "{run:?}");
}

#[test]
fn a_pseudo_terminal_says_what_it_does_not_take() {
    let bench = grbl(0.0002);
    let odd = "name = \"odd\"\nprotocol = \"grbl\"\n[serial]\ndata_bits = 7\nparity = \"even\"\n[window]\nlines = 5\n";
    let shop = Shop::new().file("part.ngc", passes(1)).file("odd.toml", odd);
    let mill = machine("knee_mill");
    let run = shop.run(["feed", "part.ngc", "--machine", &mill, "--link", "odd.toml", "--port", &bench.name]);
    assert!(run.code == 0 && run.stderr.contains("W0702") && run.stderr.contains("7E1"), "{run:?}");
    let run = shop.run(["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", "/dev/no-such-port"]);
    assert!(run.code == 5 && run.stderr.contains("/dev/no-such-port"), "{run:?}");
}

#[test]
fn a_refusal_a_reset_and_a_cut_cable_have_their_status() {
    let mill = machine("knee_mill");
    // All that was sent has room in its planner, so each line has its answer although the axes are held.
    let refusal = Faults { refuses: Some(30), ..Faults::default() };
    let refusing = Wired::at_line(Grbl::new(&refusal, 0.0005).of_a_hundred_blocks());
    let shop = Shop::new().file("part.ngc", passes(8));
    let run = shop.run(["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", &refusing.name]);
    assert!(
        run.code == 6 && run.stderr.contains("refused line 30") && run.stderr.contains("axes are in hold"),
        "{run:?}"
    );
    // Those behind it may have been answered; they are not done before it is.
    let plan = shop.run(["resume", "part.ngc.journal", "--clearance", "60mm"]);
    assert!(plan.code == 0 && plan.stdout.contains("acknowledged  up to 29 "), "{plan:?}");
    // A full planner takes nothing while the axes are held: which line was refused is not sure, as lines behind it have no answer.
    let refusing = Wired::at_line(Grbl::new(&refusal, 0.02));
    let shop = Shop::new().file("part.ngc", passes(8));
    let run = shop.run(["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", &refusing.name]);
    assert!(
        run.code == 6 && run.stderr.contains("the transfer has ended: ") && run.stderr.contains("axes are in hold"),
        "{run:?}"
    );
    assert!(
        run.stderr.contains("refused line 29, 30 or a later one with error:33 (the answers do not show which)"),
        "{run:?}"
    );
    let resetting = Wired::at_line(Grbl::new(&Faults { reset_s: Some(0.8), ..Faults::default() }, 0.05));
    let shop = Shop::new().file("part.ngc", passes(8));
    let run = shop.run(["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", &resetting.name]);
    assert!(run.code == 6 && run.stderr.contains("the transfer has ended: "), "{run:?}");
    let bench = Wired::at_network(Grbl::new(&Faults::default(), 0.02));
    let shop = Shop::new().file("part.ngc", passes(8));
    let mut child = start(&shop, &["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", &bench.name]);
    bench.wait_for(10);
    drop(bench);
    let code = child.wait().unwrap().code();
    assert!(code == Some(5) && shop.text("stderr").contains("the link is gone"), "{code:?} {}", shop.text("stderr"));
}

/// Sends a signal.
pub(crate) fn signal(child: &Child, name: &str) {
    let status = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status().unwrap();
    assert!(status.success());
}

#[test]
fn the_first_ctrl_c_lets_the_control_run_out_and_the_second_holds_it() {
    let mill = machine("knee_mill");
    let bench = grbl(0.02);
    let shop = Shop::new().file("part.ngc", passes(20));
    let mut child = start(&shop, &["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", &bench.name]);
    bench.wait_for(10);
    signal(&child, "INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let planned = corrected(&shop, "part.ngc", &["--machine", &mill]);
    let executed = bench.executed();
    assert!(executed.len() < planned.len() && planned.starts_with(&executed), "{executed:?}");
    // Every line that was sent was carried out before it ended.
    assert!(shop.text("part.ngc.journal").contains(&format!("A {}\n", executed.len())));
    assert!(shop.text("stderr").contains("executes"), "{}", shop.text("stderr"));

    let bench = grbl(0.2);
    let shop = Shop::new().file("part.ngc", passes(20));
    let mut child = start(&shop, &["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", &bench.name]);
    bench.wait_for(3);
    signal(&child, "INT");
    thread::sleep(Duration::from_millis(100));
    signal(&child, "INT");
    let from = Instant::now();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(from.elapsed() < Duration::from_secs(2));
    let held = bench.executed().len();
    thread::sleep(Duration::from_millis(600));
    assert!(bench.executed().len() <= held + 1, "the axes go on");
    assert!(shop.text("stderr").contains("spindle keeps turning"), "{}", shop.text("stderr"));
    assert!(shop.text("part.ngc.journal").contains(" E held: "), "{}", shop.text("part.ngc.journal"));
}

#[test]
fn the_journal_of_a_broken_job_is_not_overwritten() {
    let mill = machine("knee_mill");
    let bench = grbl(0.02);
    let shop = Shop::new().file("part.ngc", passes(20));
    let arguments = ["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", &bench.name];
    let mut child = start(&shop, &arguments);
    bench.wait_for(10);
    let other = grbl(0.02);
    let run = shop.run(["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", &other.name]);
    assert!(run.code == 4 && run.stderr.contains("a job that is running"), "{run:?}");
    assert!(other.executed().is_empty());
    signal(&child, "KILL");
    child.wait().unwrap();
    let before = shop.bytes("part.ngc.journal");
    let run = shop.run(arguments);
    assert!(run.code == 4 && run.stderr.contains("E0703"), "{run:?}");
    assert_eq!(shop.bytes("part.ngc.journal"), before);
    let run = shop.run([&arguments[..], &["--journal", "part.ngc"]].concat());
    assert!(run.code == 4 && run.stderr.contains("not a journal"), "{run:?}");
}

/// A job that is killed, and the plan for it.
fn killed(shop: &Shop, bench: &Wired<Grbl>, mill: &str, after: usize) -> serde_json::Value {
    let arguments = ["feed", "part.ngc", "--machine", mill, "--link", "grbl", "--port", &bench.name];
    let mut child = start(shop, &arguments);
    bench.wait_for(after);
    signal(&child, "KILL");
    child.wait().unwrap();
    // The control carries out what it has.
    let (mut count, mut quiet) = (0, 0);
    while quiet < 4 {
        let now = bench.executed().len();
        quiet = if now == count { quiet + 1 } else { 0 };
        count = now;
        thread::sleep(Duration::from_millis(200));
    }
    let run = shop.run(["resume", "part.ngc.journal", "--json", "--clearance", "60mm"]);
    assert_eq!(run.code, 0, "{run:?}");
    serde_json::from_str(&run.stdout).unwrap()
}

/// The executed lines, as soon as the control executes no more: on a busy computer it is still at the lines of a job that was killed.
fn at_rest(bench: &Wired<Grbl>) -> Vec<String> {
    let (mut executed, mut quiet) = (bench.executed(), 0);
    while quiet < 6 {
        thread::sleep(Duration::from_millis(300));
        let now = bench.executed();
        quiet = if now.len() == executed.len() { quiet + 1 } else { 0 };
        executed = now;
    }
    executed
}

#[test]
fn a_killed_job_is_taken_up_again_above_the_part_and_leaves_nothing_out() {
    let mill = machine("knee_mill");
    for after in [3, 80, 137, 200] {
        let bench = grbl(0.005);
        let shop = Shop::new().file("part.ngc", passes(20));
        let plan = killed(&shop, &bench, &mill, after);
        let first = at_rest(&bench);
        // What the control has carried out lies where the plan says.
        let [sure, sent] = ["executed", "sent"].map(|key| plan[key].as_u64().unwrap() as usize);
        assert!(sure <= first.len() && first.len() <= sent, "{sure} {} {sent}", first.len());
        let number = plan["plan"].as_str().unwrap();
        let wrong = shop.run(["resume", "part.ngc.journal", "--confirm", "000000000000", "--clearance", "60mm"]);
        assert!(wrong.code == 2 && bench.executed() == first, "{wrong:?}");
        let run = shop.run(["resume", "part.ngc.journal", "--confirm", number, "--clearance", "60mm"]);
        assert_eq!(run.code, 0, "{run:?}");
        let old = shop.run(["resume", "part.ngc.journal.old"]);
        assert!(old.code == 2 && old.stderr.contains("was resumed"), "{old:?}");
        let all = bench.executed();
        let before: Vec<&str> = plan["before"].as_array().unwrap().iter().map(|line| line.as_str().unwrap()).collect();
        let planned = corrected(&shop, "part.ngc", &["--machine", &mill]);
        // On a busy computer a line of the first job may still be on its way when the second begins; it comes first, in its order.
        let begins = before.first().copied().unwrap_or(&planned[0]);
        let late = all[first.len()..].iter().position(|line| line == begins).unwrap_or_default();
        let (before_it, second) = all.split_at(first.len() + late);
        assert!(before_it.len() <= sent && planned.starts_with(before_it), "{:?}", &before_it[first.len()..]);
        assert_eq!(second[..before.len()], before, "the way there");
        // The rest is the end of the program, and begins where it was carried out for sure.
        let rest = &second[before.len()..];
        assert!(planned.ends_with(rest), "{rest:?}");
        assert!(planned.len() - rest.len() <= sure, "{after}: something was left out");
        // Answers count from the next report on, five times in a second.
        if after >= 90 {
            assert!(rest.len() < planned.len() && before.iter().any(|line| line.contains("M3")), "{before:?}");
            // First up to the stated height, and with a feed down to where the program had retracted to.
            let first = before.iter().find(|line| line.starts_with("G0 ")).unwrap();
            assert_eq!(*first, "G0 Z60.", "{before:?}");
            let down = before.iter().find_map(|line| line.strip_prefix("G1 Z")).unwrap().split(' ').next().unwrap();
            assert!((down.parse::<f64>().unwrap() - 50.0).abs() < 0.1, "{before:?}");
        }
    }
}

#[test]
fn what_has_changed_is_not_taken_up_again() {
    let mill = machine("knee_mill");
    let bench = grbl(0.01);
    let shop = Shop::new().file("part.ngc", passes(20));
    killed(&shop, &bench, &mill, 60);
    let count = bench.executed().len();
    std::fs::write(shop.path("part.ngc"), passes(20).replace("S2000", "S2100")).unwrap();
    let run = shop.run(["resume", "part.ngc.journal"]);
    assert!(run.code == 4 && run.stderr.contains("E0704") && run.stderr.contains("the program"), "{run:?}");
    assert_eq!(bench.executed().len(), count);
}

#[test]
fn another_link_other_sensors_and_a_lost_zero_are_not_taken_up_again() {
    let bench = grbl(0.01);
    let profile = "name = \"own\"\nprotocol = \"grbl\"\n[window]\nlines = 5\n";
    let sensors = "[source.log]\nkind = \"replay\"\npath = \"warm.csv\"\n[channel.T_head]\nsource = \"log\"\n";
    let shop = Shop::new()
        .file("part.ngc", passes(20))
        .file("own.toml", profile)
        .file("warm.csv", "t_s,T_head_C\n0,20\n600,21\n")
        .file("s.toml", sensors)
        .file("mill.toml", warm_mill());
    let arguments = ["feed", "part.ngc", "--machine", "mill.toml", "--link", "own.toml", "--port", &bench.name];
    let mut child = start(&shop, &[&arguments[..], &["--sensors", "s.toml", "--zero-now"]].concat());
    bench.wait_for(30);
    signal(&child, "KILL");
    child.wait().unwrap();
    let run = shop.run(["resume", "part.ngc.journal"]);
    assert!(run.code == 4 && run.stderr.matches("E0704").count() == 1 && run.stderr.contains("--zero-now"), "{run:?}");
    std::fs::write(shop.path("own.toml"), profile.replace('5', "6")).unwrap();
    std::fs::write(shop.path("s.toml"), format!("{sensors}range_C = [0, 50]\n")).unwrap();
    let run = shop.run(["resume", "part.ngc.journal"]);
    assert!(run.code == 4 && run.stderr.matches("E0704").count() == 3, "{run:?}");
    assert!(run.stderr.contains("profile of the link") && run.stderr.contains("file of the sensors"), "{run:?}");
}

#[test]
fn a_control_in_alarm_does_not_use_up_the_journal_of_a_broken_job() {
    let mill = machine("knee_mill");
    let bench = grbl(0.005);
    let shop = Shop::new().file("part.ngc", passes(20));
    let plan = killed(&shop, &bench, &mill, 137);
    let alarmed = Wired::at_line(Grbl::new(&Faults::default(), 0.005).in_alarm());
    let number = plan["plan"].as_str().unwrap();
    let run =
        shop.run(["resume", "part.ngc.journal", "--port", &alarmed.name, "--confirm", number, "--clearance", "60mm"]);
    assert!(run.code == 6 && run.stderr.contains("no line was sent"), "{run:?}");
    assert!(alarmed.executed().is_empty());
    // Its own journal is empty and does not begin at the beginning; that of the broken job is as good as before.
    let empty = shop.run(["resume", "part.ngc.journal"]);
    assert!(empty.code == 2 && empty.stderr.contains("part.ngc.journal.old"), "{empty:?}");
    let anew = shop.run(["feed", "part.ngc", "--machine", &mill, "--link", "grbl", "--port", &bench.name]);
    assert!(anew.code == 4 && anew.stderr.contains("E0703"), "{anew:?}");
    let again = shop.run(["resume", "part.ngc.journal.old", "--json", "--clearance", "60mm"]);
    let again: serde_json::Value = serde_json::from_str(&again.stdout).unwrap();
    assert_eq!([&again["source_line"], &again["before"]], [&plan["source_line"], &plan["before"]]);
}

#[test]
fn a_second_job_does_not_take_the_journal_of_one_that_waits_for_its_sensors() {
    let sensors =
        "poll_s = 1\n[source.a]\nkind = \"file\"\nmode = \"value\"\npath = \"t.txt\"\n[channel.T_a]\nsource = \"a\"\n";
    let (one, two) = (grbl(0.01), grbl(0.01));
    let shop = Shop::new().file("part.ngc", passes(20)).file("s.toml", sensors);
    let mill = machine("knee_mill");
    let arguments = |port: &str| {
        [
            "feed",
            "part.ngc",
            "--machine",
            &mill,
            "--link",
            "grbl",
            "--sensors",
            "s.toml",
            "--every",
            "0.1",
            "--port",
            port,
        ]
        .map(str::to_owned)
    };
    let first = arguments(&one.name);
    let mut child = start(&shop, &first.iter().map(String::as_str).collect::<Vec<_>>());
    let from = Instant::now();
    while !shop.path("part.ngc.journal").exists() {
        assert!(from.elapsed() < LONG);
        thread::sleep(Duration::from_millis(10));
    }
    // The first one waits; the second one may not.
    let run = shop.run(arguments(&two.name));
    assert!(run.code == 4 && run.stderr.contains("E0703") && run.stderr.contains("running"), "{run:?}");
    // A first value counts when a later one agrees.
    let from = Instant::now();
    while one.executed().len() < 60 {
        assert!(from.elapsed() < LONG, "{} lines", one.executed().len());
        std::fs::write(shop.path("t.new"), "20.0\n").unwrap();
        std::fs::rename(shop.path("t.new"), shop.path("t.txt")).unwrap();
        thread::sleep(Duration::from_millis(100));
    }
    let run = shop.run(arguments(&two.name));
    assert!(run.code == 4 && run.stderr.contains("E0703"), "{run:?}");
    assert!(two.executed().is_empty() && !shop.path("part.ngc.journal.old").exists());
    signal(&child, "KILL");
    child.wait().unwrap();
    assert!(shop.text("part.ngc.journal").contains(" F 60 "));
}

/// The knee mill with a head that grows by 3 µm/K downwards.
fn warm_mill() -> String {
    let text = std::fs::read_to_string(machine("knee_mill")).unwrap();
    text + "\n[[drift]]\ndirection = \"Z\"\nsensors = [{ name = \"T_head\", um_per_K = -3 }]\n"
}

/// What the second step added to Z, by line, µm, and the texts of the lines.
fn added_um(journal: &str, lines: &[String]) -> Vec<(f64, String)> {
    let frozen = journal.lines().filter(|line| line.split(' ').nth(1) == Some("F"));
    let value = |line: &str| {
        let word = line.split(' ').find_map(|word| word.strip_prefix('Z'));
        // What was added, and behind the slash what temperatures asked for.
        let added = word.and_then(|word| word.split('/').next());
        added.map_or(0.0, |value| 1e3 * value.parse::<f64>().unwrap())
    };
    frozen.zip(lines).map(|(line, text)| (value(line), text.clone())).collect()
}

#[test]
fn a_head_that_warms_up_is_followed_in_doses() {
    let bench = grbl(0.01);
    // 1 K in half a minute, played sixty times as fast: 2 K/s, which is what the rate is held against.
    let log: String = (0..60).map(|k| format!("{},{}\n", 30 * k, 20 + k)).collect();
    let sensors = "range_C = [0, 90]\nmax_rate_K_per_min = 300\n[source.log]\nkind = \"replay\"\npath = \"warm.csv\"\nspeed = 60\n\
                   [channel.T_head]\nsource = \"log\"\n";
    let shop = Shop::new()
        .file("part.ngc", passes(20))
        .file("warm.csv", "t_s,T_head_C\n".to_owned() + &log)
        .file("s.toml", sensors)
        .file("mill.toml", warm_mill());
    let arguments =
        ["feed", "part.ngc", "--machine", "mill.toml", "--link", "grbl", "--port", &bench.name, "--sensors", "s.toml"];
    let run = shop.run([&arguments[..], &["--every", "0.1", "--warn-shift", "5um", "--json"]].concat());
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.stdout.contains("\"event\":\"shift\""), "{run:?}");
    let executed = bench.executed();
    let added = added_um(&shop.text("part.ngc.journal"), &executed);
    let cold = corrected(&shop, "part.ngc", &["--machine", "mill.toml"]);
    assert_eq!((added.len(), executed.len()), (cold.len(), cold.len()));
    let height = |line: &str| line.split(' ').find_map(|word| word.strip_prefix('Z')?.parse::<f64>().ok());
    let (mut last, mut motion) = (0.0, "");
    for ((um, line), cold) in added.iter().zip(&cold) {
        if line.starts_with("G0") || line.starts_with("G1") {
            motion = &line[..2];
        }
        // Each line went out with what the journal says: both are rounded to 0.1 µm.
        if let (Some(warm), Some(cold)) = (height(line), height(cold)) {
            assert!((1e3 * (warm - cold) - um).abs() < 0.11, "{line}: {um} µm, without {cold}");
        }
        // A rapid move that leads to no cut goes as it is programmed.
        if motion == "G0" && *um == 0.0 {
            continue;
        }
        // 1 µm a block and no more where something is cut.
        assert!(motion != "G1" || (um - last).abs() < 1.0 + 1e-6, "{line}: from {last} to {um} µm");
        last = *um;
    }
    // 20 passes of 13 lines and 10 ms: about 2.6 s, 5 K, 16 µm; a loaded computer takes longer.
    assert!(last > 6.0, "{last} µm");
    // Rapid moves only: on the way in the part it stays.
    let bench = grbl(0.01);
    let arguments =
        ["feed", "part.ngc", "--machine", "mill.toml", "--link", "grbl", "--port", &bench.name, "--sensors", "s.toml"];
    let run = shop.run([&arguments[..], &["--every", "0.1", "--rapids-only", "--zero-now"]].concat());
    assert_eq!(run.code, 0, "{run:?}");
    let added = added_um(&shop.text("part.ngc.journal"), &bench.executed());
    let steps = added.windows(2).filter(|pair| pair[1].1.starts_with("G1") && pair[0].0 != pair[1].0).count();
    let last = added.iter().rev().find(|(um, _)| *um != 0.0);
    assert!(steps == 0 && last.is_some_and(|(um, _)| *um > 3.0), "{added:?}");
    // More than is allowed ends it.
    let bench = grbl(0.01);
    let arguments =
        ["feed", "part.ngc", "--machine", "mill.toml", "--link", "grbl", "--port", &bench.name, "--sensors", "s.toml"];
    let dry = shop.run([&arguments[..], &["--dry-run"]].concat());
    assert!(dry.code == 0 && !dry.stderr.contains("error"), "{dry:?}");
    std::fs::write(shop.path("bad.toml"), "[source.log]\nkind = \"replay\"\npol_s = 1\npath = \"warm.csv\"\n").unwrap();
    let bad = [
        "feed",
        "part.ngc",
        "--machine",
        "mill.toml",
        "--link",
        "grbl",
        "--port",
        &bench.name,
        "--sensors",
        "bad.toml",
    ];
    let dry = shop.run([&bad[..], &["--dry-run"]].concat());
    assert!(dry.code != 0 && dry.stderr.contains("pol_s"), "{dry:?}");
    let run = shop.run([&arguments[..], &["--every", "0.1", "--max-shift", "4um"]].concat());
    assert!(run.code == 4 && run.stderr.contains("--max-shift"), "{run:?}");
    // No line is cut in two: all that were sent were carried out.
    let journal = shop.text("part.ngc.journal");
    assert_eq!(journal.lines().filter(|line| line.split(' ').nth(1) == Some("F")).count(), bench.executed().len());
}

/// A dry run says before the job that a sensor has no value: a file that is not there, and one with a value out of its range.
#[test]
fn a_dry_run_asks_each_sensor() {
    let sensors = |range: &str| {
        format!(
            "poll_s = 1\n[source.head]\nkind = \"file\"\nmode = \"value\"\npath = \"head\"\n[channel.T_head]\nsource = \"head\"\nrange_C = {range}\n"
        )
    };
    let shop = Shop::new()
        .file("part.ngc", passes(2))
        .file("mill.toml", warm_mill())
        .file("s.toml", sensors("[10, 60]"))
        .file("cold.toml", sensors("[-10, 10]"));
    let dry = |file: &str, more: &[&str]| {
        let words = ["feed", "part.ngc", "--machine", "mill.toml", "--link", "grbl", "--sensors", file, "--dry-run"];
        shop.run(words.iter().chain(more))
    };
    let run = dry("s.toml", &[]).exits(7).says("no good value of T_head");
    assert!(run.stdout.contains("\nsensors      T_head: "), "{}", run.stdout);
    let answers = dry("s.toml", &["--json"]).exits(7).json()["sensors"].clone();
    assert!(answers[0]["name"] == "T_head" && answers[0]["value_c"].is_null(), "{answers}");
    std::fs::write(shop.path("head"), "24.5\n").unwrap();
    let run = dry("s.toml", &[]).exits(0);
    assert!(run.stdout.contains("\nsensors      T_head 24.50 °C\n"), "{}", run.stdout);
    dry("cold.toml", &[]).exits(7).says("no good value of T_head");
    // Without sensors none is asked.
    let run = shop.run(["feed", "part.ngc", "--machine", "mill.toml", "--link", "grbl", "--dry-run"]).exits(0);
    assert!(!run.stdout.contains("sensors "), "{}", run.stdout);
}

#[test]
fn a_sensor_that_falls_silent_is_held_and_then_ends_the_job() {
    let bench = grbl(0.02);
    let sensors = "poll_s = 0.1\nmax_age_s = 0.5\nact_after_s = 0.5\naction = \"stop\"\nconfirm = 1\nmedian = 1\n\
                   [source.head]\nkind = \"file\"\nmode = \"value\"\npath = \"head\"\n[channel.T_head]\nsource = \"head\"\n";
    let shop = Shop::new().file("part.ngc", passes(40)).file("s.toml", sensors).file("mill.toml", warm_mill());
    let arguments =
        ["feed", "part.ngc", "--machine", "mill.toml", "--link", "grbl", "--port", &bench.name, "--sensors", "s.toml"];
    let is_warm = Arc::new(AtomicBool::new(true));
    let (writes, path) = (Arc::clone(&is_warm), shop.path("head"));
    let probe = thread::spawn(move || {
        while writes.load(Ordering::Relaxed) {
            std::fs::write(&path, "24.0\n").unwrap();
            thread::sleep(Duration::from_millis(50));
        }
    });
    let mut child = start(&shop, &[&arguments[..], &["--every", "0.1"]].concat());
    bench.wait_for(5);
    is_warm.store(false, Ordering::Relaxed);
    probe.join().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(7), "{}", shop.text("stderr"));
    let said = shop.text("stderr");
    assert!(said.contains("sensor readings are doubtful") && said.contains("T_head"), "{said}");
    let executed = bench.executed();
    let added = added_um(&shop.text("part.ngc.journal"), &executed);
    // It was 24 °C, and never anything else: 12 µm from the first rapid move on, but for those that lead to no cut.
    let cuts: Vec<_> = added.iter().filter(|(um, line)| line.starts_with("G1 ") || *um != 0.0).collect();
    assert!(cuts.len() > 10 && cuts.iter().all(|(um, _)| (um - 12.0).abs() < 0.11), "{added:?}");
    // A model that needs a sensor which nobody reads is refused.
    let shop = Shop::new()
        .file("part.ngc", passes(1))
        .file("s.toml", sensors.replace("T_head", "T_bed"))
        .file("mill.toml", warm_mill());
    let run = shop.run(arguments);
    assert!(run.code == 4 && run.stderr.contains("E0501"), "{run:?}");
}

#[test]
fn a_program_of_another_dialect_is_not_sent() {
    let demo = machine("demo");
    let part = "N10 G90 G71 G54\nN20 G0 X50 Y50 Z100\nN30 G1 X600 F500\nN40 M30\n";
    let own = "name = \"own\"\nprotocol = \"block\"\n[text]\ndialects = [\"sinumerik\", \"rs274\"]\n";
    let shop = Shop::new().file("part.mpf", part).file("own.toml", own);
    for link in ["grbl", "grblhal", "marlin", "linuxcnc", "fanuc-rs232", "haas", "grundig-v24"] {
        let run = shop.run(["feed", "part.mpf", "--machine", &demo, "--link", link, "--dry-run"]).exits(4);
        run.says("error[E0701]").says("this program is sinumerik");
    }
    for link in ["siemens-v24", "own.toml"] {
        let run = shop.run(["feed", "part.mpf", "--machine", &demo, "--link", link, "--dry-run", "--allow-starvation"]);
        assert!(!run.stderr.contains("E0701"), "{link}: {}", run.stderr);
    }
}

/// Siemens: an 840D or 828D reads no part program over V.24 line by line. Their programs are Sinumerik programs, too.
#[test]
fn a_link_names_the_controls_that_cannot_use_it() {
    let demo = machine("demo");
    let part = "N10 G90 G71 G54\nN20 G0 X50 Y50 Z100\nN30 G1 X500 F500\nN40 M30\n";
    let own = "name = \"own\"\nprotocol = \"block\"\n[text]\ndialects = [\"sinumerik\"]\n";
    let shop = Shop::new().file("part.mpf", part).file("own.toml", own);
    let feed = |link: &str| {
        shop.run(["feed", "part.mpf", "--machine", &demo, "--link", link, "--dry-run", "--allow-starvation"]).exits(0)
    };
    feed("siemens-v24").says("warning[W0704]").says("840D or 828D").says("load the corrected program");
    assert!(!feed("own.toml").stderr.contains("W0704"));
}

/// The length of numbers is no remedy where the control does not execute the word.
#[test]
fn the_help_for_a_line_fits_its_reason() {
    let mill = machine("knee_mill");
    let short = "name = \"short\"\nprotocol = \"grbl\"\n[text]\nlongest_line = 12\n";
    let part = passes(1).replace("M30\n", "M0\nM30\n");
    assert!(part.contains("M0"), "{part}");
    let shop = Shop::new().file("part.ngc", part).file("short.toml", short);
    let feed = |link: &str| shop.run(["feed", "part.ngc", "--machine", &mill, "--link", link, "--dry-run"]).exits(4);
    let run = feed("linuxcnc").says("error[E0701]").says("M0, M1 and M60").says("load the corrected program");
    assert!(!run.stderr.contains("--increment"), "{}", run.stderr);
    feed("short.toml").says("error[E0701]").says("choose a larger --increment");
}
