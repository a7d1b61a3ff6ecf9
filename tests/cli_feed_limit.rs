//! `ncfix fix --feed-limit` as a process: feeds that keep a limit, and what it costs.

use crate::support::Shop;

/// A mill whose Y lags 0.6 ms more than its X: (1 − 0.95)/50 less (1 − 0.98)/50.
const MILL: &str = "[machine]\nname = \"mill\"\ntopology = \"wFXYZSt\"\n\
[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-900, 900]\nmax_feed_mm_min = 30000\n\
[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-900, 900]\nmax_feed_mm_min = 30000\n\
[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-900, 900]\nmax_feed_mm_min = 30000\n\
[control]\ninitial_zero_offset = \"G500\"\n\
[servo]\ncycle_ms = 3\nsmoothing_ms = 12\ncorner_tolerance_um = 10\n\
[servo.X]\nvelocity_gain_per_s = 50\nfeed_forward = 0.98\nmax_acceleration_m_s2 = 5\n\
[servo.Y]\nvelocity_gain_per_s = 50\nfeed_forward = 0.95\nmax_acceleration_m_s2 = 5\n\
[servo.Z]\nvelocity_gain_m_min_mm = 3\nfeed_forward = 0.98\nmax_acceleration_m_s2 = 5\n";

/// Feeds of the words F of a program, in their order.
fn feeds(text: &str) -> Vec<f64> {
    let words = text.lines().filter(|line| !line.starts_with([';', '(', '%'])).flat_map(str::split_whitespace);
    words.filter_map(|word| word.strip_prefix('F')?.trim_start_matches('=').parse().ok()).collect()
}

/// Corrects a program with a limit; its text, and the report.
fn limited(name: &str, program: &str, machine: &str, limit: &str) -> (String, serde_json::Value) {
    let shop = Shop::new().file(name, program).file("m.toml", machine);
    let run = shop.run(["fix", name, "-o", "out.nc", "--machine", "m.toml", "--feed-limit", limit, "--json"]);
    let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap_or_else(|_| panic!("{}", run.stderr));
    (shop.text("out.nc"), report)
}

#[test]
fn a_slanting_line_is_slowed_to_what_its_lags_allow() {
    // v dτ/2 at 45°: at 9000 mm/min and 0.6 ms 45 µm; 15 µm allow 3000 mm/min.
    let program = "G90 G500 G0 X0 Y0 Z0\nG1 X100 Y100 F9000\nM0\nX200\nG0 X300\nM30\n";
    let (text, report) = limited("p.mpf", program, MILL, "15um");
    let written = feeds(&text);
    assert!(written.len() == 2 && (2500.0..=3000.0).contains(&written[0]), "{text}");
    // Straight along X nothing is off.
    assert_eq!(written[1], 9000.0, "{text}");
    let limit = &report["feed_limit"];
    let value = |key: &str| limit[key].as_f64().unwrap();
    assert!((limit["contouring_before"]["max_um"].as_f64().unwrap() - 45.0).abs() < 1.0, "{limit}");
    assert!(limit["contouring_after"]["max_um"].as_f64().unwrap() <= 15.0 + 1e-9, "{limit}");
    // 141.4 mm take 1.9 s more at a third of the feed, 2.4 s at 2500.
    assert!((1.7..2.5).contains(&(value("time_after_s") - value("time_before_s"))), "{limit}");
    assert_eq!(report["diagnostics"], serde_json::json!([]));
}

#[test]
fn a_limit_that_holds_changes_nothing() {
    let program = "G90 G500 G0 X0 Y0 Z0\nG1 X100 Y100 F9000\nG2 X120 Y120 I20 J0 F3000\nM30\n";
    let (text, report) = limited("p.mpf", program, MILL, "60um");
    assert_eq!(feeds(&text), [9000.0, 3000.0]);
    assert_eq!(report["feed_limit"]["slowed"], 0);
    assert_eq!(report["feed_limit"]["time_before_s"], report["feed_limit"]["time_after_s"]);
}

#[test]
fn every_dialect_gets_its_feeds_back_behind_a_slow_block() {
    let fanuc = "%\nO1\nG90 G54 G0 X0. Y0. Z0.\nG1 X100. Y100. F9000.\nM0\nX200.\nG3 X200. Y-100. I0. J-100.\nM0\nG1 X100.\nM30\n%\n";
    let machine = MILL.replace("topology", "controller = \"fanuc\"\ntopology").replace("G500", "G54")
        + "[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n";
    let (text, report) = limited("o1.nc", fanuc, &machine, "15um");
    let written = feeds(&text);
    assert!(written.iter().all(|feed| *feed <= 9000.0) && written.contains(&9000.0), "{text}");
    assert!(report["feed_limit"]["contouring_after"]["max_um"].as_f64().unwrap() <= 15.0 + 1e-9, "{report}");
    assert!(report["feed_limit"]["contouring_before"]["max_um"].as_f64().unwrap() > 40.0, "{report}");
}

#[test]
fn what_cannot_be_slowed_is_named_with_its_line() {
    // 141 mm in 0.9428 s are 9000 mm/min.
    let program = "G90 G500 G0 X0 Y0 Z0\nG93\nG1 X100 Y100 F63.64\nG94\nM30\n";
    let (text, report) = limited("p.mpf", program, MILL, "15um");
    assert_eq!(feeds(&text), [63.64]);
    let findings = report["diagnostics"].as_array().unwrap();
    assert_eq!(
        (findings.len(), &findings[0]["code"], &findings[0]["line"]),
        (1, &"W0309".into(), &3.into()),
        "{report}"
    );
    assert!(findings[0]["message"].as_str().unwrap().contains("G93"));
    // What gives way while X accelerates: 200 µm at 5 m/s². At the lowest feed, a step
    // of 7.5 mm/s, at most 2 dv/T = 1.25 m/s² and 50 µm are left; the ramp of 1.5 ms and cycles of 3 ms make it less.
    let machine = format!("{MILL}[[dynamic]]\ncomponent = \"EYX\"\num_per_m_s2 = 40\n");
    let (text, report) = limited("p.mpf", "G90 G500 G0 X0 Y0 Z0\nG1 X100 F9000\nM30\n", &machine, "15um");
    assert_eq!(feeds(&text), [450.0], "{text}");
    let findings = report["diagnostics"].as_array().unwrap();
    assert_eq!(
        (findings.len(), &findings[0]["code"], &findings[0]["line"]),
        (1, &"W0309".into(), &2.into()),
        "{report}"
    );
    let after = report["feed_limit"]["contouring_after"]["max_um"].as_f64().unwrap();
    assert!((35.0..=50.0).contains(&after), "{after}");
}

#[test]
fn corners_are_passed_slowly_where_the_limit_is_below_their_tolerance() {
    let program = "G90 G500 G0 X0 Y0 Z0\nG1 X20 F6000\nY20\nX0\nY0\nM30\n";
    let (text, report) = limited("p.mpf", program, MILL, "7um");
    let after = report["feed_limit"]["contouring_after"]["max_um"].as_f64().unwrap();
    assert!(after <= 7.0 + 1e-9, "{after} {text}");
    assert_eq!(report["diagnostics"], serde_json::json!([]));
    // At 5 mm/s, the lowest feed, a corner is off by up to dv T/12 = 5 µm on both axes: 4 µm are out of reach.
    let (text, report) = limited("p.mpf", program, MILL, "4um");
    assert!(feeds(&text).iter().all(|&feed| feed >= 300.0), "{text}");
    let findings = report["diagnostics"].as_array().unwrap();
    assert!(!findings.is_empty() && findings.iter().all(|finding| finding["code"] == "W0309"), "{report}");
}

#[test]
fn a_hold_lets_the_axes_get_there() {
    // After M0 both axes are within the exact stop of 10 µm. With a window of 1 mm Y is still late when X goes on: 150 µm at 9000 mm/min.
    let program = "G90 G500 G0 X0 Y0 Z0\nG1 Y100 F9000\nM0\nX100\nM30\n";
    let (_, report) = limited("p.mpf", program, MILL, "16um");
    assert_eq!(
        (&report["feed_limit"]["slowed"], &report["diagnostics"]),
        (&0.into(), &serde_json::json!([])),
        "{report}"
    );
    let coarse = MILL.replace("corner_tolerance_um = 10", "corner_tolerance_um = 10\nexact_stop_um = 1000");
    let (_, report) = limited("p.mpf", program, &coarse, "16um");
    assert_ne!(report["feed_limit"]["slowed"], 0, "{report}");
}

#[test]
fn what_rapid_moves_leave_is_not_the_doing_of_a_feed() {
    // Down with feed, up and on rapidly: the rounding of the corner above is off the way back, not off the hole.
    let program = "G90 G500 G0 X0 Y0 Z10\nG1 Z-10 F300\nG0 Z10\nG0 Y100\nG1 Z-10\nG0 Z10\nM30\n";
    let (text, report) = limited("p.mpf", program, MILL, "15um");
    assert_eq!(
        (&report["feed_limit"]["slowed"], &report["diagnostics"]),
        (&0.into(), &serde_json::json!([])),
        "{report}"
    );
    assert!(feeds(&text).iter().all(|&feed| feed == 300.0), "{text}");
}

#[test]
fn faults_of_loops_are_found_together() {
    let machine = MILL
        .replace("cycle_ms = 3", "cycle_ms = 1e-9")
        .replace("feed_forward = 0.95", "feed_forward = 1.5")
        .replace("[servo.Z]\nvelocity_gain_m_min_mm = 3\nfeed_forward = 0.98\nmax_acceleration_m_s2 = 5\n", "");
    let shop = Shop::new().file("m.toml", machine);
    let run = shop.run(["machine", "check", "m.toml"]);
    for said in ["cycle_ms must be a time from 0.01", "feed_forward must be a share", "[servo] has no data for Z"] {
        assert!(run.stderr.contains(said) || run.stdout.contains(said), "{said}: {} {}", run.stderr, run.stdout);
    }
}
