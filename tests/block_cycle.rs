//! Cutting blocks that take less time at their feed than the control needs for a block: own reader of the output, own times.

use crate::support::Shop;

/// EYX is a wave of 20 µm every 40 mm: a line is divided into pieces of a few millimeters.
fn machine(cycle: &str) -> String {
    let mut text = format!(
        "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n[control]\n{cycle}\n\
        [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-1000, 1000]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-1000, 1000]\n\
        [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-1000, 1000]\n[[motion]]\ncomponent = \"EYX\"\nkind = \"table\"\n"
    );
    let places: Vec<String> = (0..=100).map(|k| (k * 4).to_string()).collect();
    let waves = (0..=100).map(|k| format!("{:.6}", 20.0 * (f64::from(k) * std::f64::consts::TAU / 10.0).sin()));
    text +=
        &format!("positions_mm = [{}]\nvalues_um = [{}]\n", places.join(", "), waves.collect::<Vec<_>>().join(", "));
    text
}

const PROGRAM: &str =
    "N10 G90 G71 G94\nN20 G0 X0 Y0 Z0\nN30 G1 X200 F6000\nN40 X200.05\nN50 X200.1\nN60 Y50 F60\nN70 M30\n";

/// The times of the cutting blocks of an output, s: G1 lines with X, Y, Z and F, modal.
fn times(text: &str) -> Vec<f64> {
    let (mut at, mut feed, mut cuts, mut out) = ([0.0_f64; 3], 0.0, false, Vec::new());
    for line in text.lines() {
        let line = line.split(';').next().unwrap();
        let mut to = at;
        for word in line.split_whitespace() {
            let number = || word[1..].trim_start_matches('=').parse::<f64>();
            match (&word[..1], word) {
                (_, "G0" | "G00") => cuts = false,
                (_, "G1" | "G01") => cuts = true,
                ("X", _) => to[0] = number().unwrap(),
                ("Y", _) => to[1] = number().unwrap(),
                ("Z", _) => to[2] = number().unwrap(),
                ("F", _) => feed = number().unwrap(),
                _ => {}
            }
        }
        let length = at.iter().zip(to).map(|(a, b)| (b - a).powi(2)).sum::<f64>().sqrt();
        if cuts && length > 0.0 {
            out.push(60.0 * length / feed);
        }
        at = to;
    }
    out
}

#[test]
fn blocks_shorter_than_the_cycle_are_counted_and_their_division_is_a_warning() {
    let written = |cycle: &str, expects_warning: bool| {
        let shop = Shop::new().file("a.mpf", PROGRAM).file("m.toml", machine(cycle));
        let run = shop.run(["fix", "a.mpf", "--machine", "m.toml", "-o", "o.mpf", "--json"]).exits(0);
        assert_eq!(run.stdout.contains("W0325"), expects_warning, "{cycle}: {}", run.stdout);
        (run.json(), times(&shop.text("o.mpf")))
    };
    // Without the key there is no statement.
    let (json, all) = written("", false);
    assert!(json["short_blocks"].is_null() && all.len() > 30, "{json}");
    // 6000 mm/min is 0.1 mm per ms: the two steps of 0.05 mm take 0.5 ms, and the pieces of the line take 10 to 60 ms.
    for (cycle_ms, divides) in [(0.2, false), (2.0, false), (100.0, true)] {
        let (json, all) = written(&format!("block_cycle_ms = {cycle_ms}"), divides);
        let short: Vec<f64> = all.iter().copied().filter(|time| time * 1e3 < cycle_ms).collect();
        let said = &json["short_blocks"];
        assert_eq!(said["written"].as_u64(), Some(short.len() as u64), "{cycle_ms}: {said} {short:?}");
        assert_eq!(said["source"].as_u64(), Some(if cycle_ms < 0.5 { 0 } else { 2 }), "{said}");
        match short.iter().copied().reduce(f64::min) {
            Some(least) => {
                assert!((said["shortest_ms"].as_f64().unwrap() - least * 1e3).abs() < 0.02, "{said} {least}")
            }
            None => assert!(said["shortest_ms"].is_null(), "{said}"),
        }
    }
}
