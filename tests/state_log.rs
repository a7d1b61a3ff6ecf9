//! `--state` with a log: the program is corrected for the machine as it was at an instant.

use crate::support::{Run, Shop};

const MACHINE: &str = "[machine]\nname = \"m\"\ntopology = \"wXYFZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 400]\n\
    [[drift]]\ndirection = \"X\"\nsensors = [{ name = \"T_head\", um_per_K = 2 }]\n\
    [[drift]]\ndirection = \"Y\"\nover = \"Z\"\nat_mm = 0\nsensors = [{ name = \"T_head\", um_per_K = -1 }]\n\
    [[drift]]\ndirection = \"Y\"\nover = \"Z\"\nat_mm = 400\nsensors = [{ name = \"T_head\", um_per_K = -3 }]\n";

/// The head gets warmer by 10 K in 10 min.
const LOG: &str = "t_s;T_head_C;rpm\n0;20,0;0\n600;30,0;6000\n";

fn fix(arguments: &[&str]) -> (Run, String) {
    let shop = Shop::new()
        .file("m.toml", MACHINE)
        .file("warm.csv", LOG)
        .file("fault.csv", LOG.replace("30,0", "3O,0"))
        .file("other.csv", LOG.replace("T_head", "T_bed"))
        .file("part.mpf", "N1 G90 G1 X100 Y50 Z200 F500\nN2 M30\n");
    let run = shop.run(["part.mpf", "-o", "out.mpf", "--machine", "m.toml"].iter().chain(arguments));
    let text = if run.code == 0 { shop.text("out.mpf") } else { String::new() };
    (run, text)
}

#[test]
fn a_program_is_corrected_for_an_instant_of_a_log() {
    // 2 and −2 µm/K where Z is 200.
    for (arguments, x, y) in [
        (&["--state", "warm.csv"][..], "X99.98", "Y50.02"),
        (&["--state", "warm.csv", "--time", "300"], "X99.99", "Y50.01"),
        (&["--state", "warm.csv", "--time", "600", "--zero-time", "450"], "X99.995", "Y50.005"),
        (&["--state", "warm.csv", "--time", "0"], "X100", "Y50"),
        (&[], "X100", "Y50"),
    ] {
        let (run, text) = fix(arguments);
        let run = run.exits(0);
        let words: Vec<&str> = text.split_whitespace().collect();
        assert!(words.contains(&x) && words.contains(&y), "{arguments:?}\n{text}\n{}", run.stderr);
    }
}

#[test]
fn a_log_with_a_fault_or_without_a_sensor_is_refused() {
    let (run, _) = fix(&["--state", "fault.csv"]);
    assert_ne!(run.code, 0);
    run.says("fault.csv:3:5").says("3O,0");
    let (run, _) = fix(&["--state", "other.csv"]);
    assert_ne!(run.code, 0);
    run.says("T_head");
}
