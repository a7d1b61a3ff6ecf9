//! `ncfix verify --at-feed` and `ncfix simulate PROGRAM` as processes: what the axes make of a program, and its trace.

use crate::support::Shop;

/// A mill whose Y lags 0.6 ms more than its X, with a straightness error, and a column that gives way.
pub(crate) const MILL: &str = "[machine]\nname = \"mill\"\ntopology = \"wFXYZSt\"\n\
[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-900, 900]\nmax_feed_mm_min = 30000\n\
[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-900, 900]\nmax_feed_mm_min = 30000\n\
[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-900, 900]\nmax_feed_mm_min = 30000\n\
[control]\ninitial_zero_offset = \"G500\"\n\
[servo]\ncycle_ms = 3\nsmoothing_ms = 24\ncorner_tolerance_um = 50\n\
[servo.X]\nvelocity_gain_per_s = 50\nfeed_forward = 0.98\nmax_acceleration_m_s2 = 5\n\
[servo.Y]\nvelocity_gain_per_s = 40\nfeed_forward = 0.96\nmax_acceleration_m_s2 = 5\n\
[servo.Z]\nvelocity_gain_m_min_mm = 3\nfeed_forward = 0.98\nmax_acceleration_m_s2 = 5\n\
[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n\
[[dynamic]]\ncomponent = \"EXX\"\num_per_m_s2 = 2.5\n";

/// Back and forth in all directions, with corners.
const PATH: &str =
    "G90 G500 G0 X0 Y0 Z0\nG1 X60 F5000\nX90 Y40\nX90 Y80 Z20\nX30 Y60 Z40\nX10 Y10 Z10\nX0 Y0 Z0\nM30\n";

#[test]
fn both_programs_are_driven_and_their_own_paths_count() {
    // A line at 45°: v dτ/2 with lags (1 − f)/K of 0.4 and 1.0 ms at 100 mm/s.
    let program = "G90 G500 G0 X0 Y0 Z0\nG1 X200 Y200 F6000\nM30\n";
    let shop = Shop::new().file("p.mpf", program).file("m.toml", MILL);
    let fixed = shop.run(["fix", "p.mpf", "-o", "o.mpf", "--machine", "m.toml"]);
    assert_eq!(fixed.code, 0, "{}", fixed.stderr);
    let run = shop.run(["verify", "p.mpf", "o.mpf", "--machine", "m.toml", "--at-feed", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap_or_else(|_| panic!("{}", run.stderr));
    for key in ["original_at_feed", "corrected_at_feed"] {
        let at_feed = &report[key];
        assert!((at_feed["max_um"].as_f64().unwrap() - 30.0).abs() < 1.5, "{report}");
        assert_eq!(at_feed["line"], 2 + i32::from(key == "corrected_at_feed"), "{report}");
        // 282.84 mm at 100 mm/s, with 7.07 m/s² at both ends 14 ms more, 24 ms of smoothing. Y is 71 µm late then, and needs less than 50 ms
        // to get within 10 µm.
        let over_s = at_feed["time_s"].as_f64().unwrap() - (2.8284 + 0.0141 + 0.024);
        assert!((0.0..0.05).contains(&over_s), "{report}");
    }
    // The text says the same, and without the option neither does.
    let text = shop.run(["verify", "p.mpf", "o.mpf", "--machine", "m.toml", "--at-feed"]).stdout;
    assert!(text.contains("at feed") && text.contains("p.mpf:2"), "{text}");
    let text = shop.run(["verify", "p.mpf", "o.mpf", "--machine", "m.toml", "--json"]).stdout;
    assert!(!text.contains("at_feed"), "{text}");
    // A machine without loops is refused.
    let bare = MILL.split("[servo]").next().unwrap();
    let bare = Shop::new().file("p.mpf", program).file("m.toml", bare);
    for arguments in [&["verify", "p.mpf", "p.mpf", "--at-feed"][..], &["simulate", "p.mpf", "-o", "t.csv"][..]] {
        let run = bare.run([arguments, &["--machine", "m.toml"]].concat());
        assert_eq!(run.code, 4, "{}", run.stderr);
        assert!(run.stderr.contains("E0312"), "{}", run.stderr);
    }
    assert!(!bare.path("t.csv").exists() && !bare.path("t.toml").exists());
}

#[test]
fn a_simulated_trace_is_divided_into_what_made_it() {
    let shop = Shop::new().file("p.mpf", PATH).file("m.toml", MILL);
    let run = shop.run([
        "simulate",
        "p.mpf",
        "--machine",
        "m.toml",
        "--feed",
        "1000,5000,15000,25000",
        "-o",
        "trace.csv",
        "--noise",
        "0.1um",
    ]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    // The same machine, of which neither loops nor what gives way is known.
    let known = MILL.split("[servo]").next().unwrap();
    let shop = shop.file("known.toml", known);
    let run = shop.run(["decompose", "trace.csv", "--machine", "known.toml", "--json"]);
    let found: serde_json::Value = serde_json::from_str(&run.stdout).unwrap_or_else(|_| panic!("{}", run.stderr));
    let loops = found["servo"].as_array().unwrap();
    for (axis, gain, forward) in [("X", 50.0, 0.98), ("Y", 40.0, 0.96), ("Z", 50.0, 0.98)] {
        let own = loops.iter().find(|one| one["axis"] == axis).unwrap_or_else(|| panic!("{found}"));
        let value = |key: &str| own[key].as_f64().unwrap();
        assert!((value("velocity_gain_per_s") / gain - 1.0).abs() < 0.05, "{own}");
        assert!((value("feed_forward") - forward).abs() < 0.005, "{own}");
    }
    let named = found["compliances"].as_array().unwrap();
    assert_eq!(named.len(), 1, "{found}");
    assert_eq!((&named[0]["component"], &named[0]["unit"]), (&"EXX".into(), &"um_per_m_s2".into()));
    assert!((named[0]["value"].as_f64().unwrap() - 2.5).abs() < 0.125, "{found}");
}

#[test]
fn a_trace_goes_the_way_of_the_program() {
    // 200 mm in X at 6000 mm/min: lag 100 mm/s · 0.4 ms = 40 µm; the scale of 100 µm/m is read, and the lag.
    let program = "G90 G500 G0 X0 Y0 Z0\nG1 X200 F6000\nM30\n";
    let shop = Shop::new().file("p.mpf", program).file("m.toml", MILL);
    let run = shop.run(["simulate", "p.mpf", "--machine", "m.toml", "-o", "trace.csv"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let text = shop.text("trace.csv");
    let mut lines = text.lines();
    assert_eq!(
        lines.next().unwrap(),
        "run,t_s,X,Y,Z,X_enc,Y_enc,Z_enc,dx_um,dy_um,dz_um,tool_x_mm,tool_y_mm,tool_z_mm"
    );
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect()).collect();
    let middle = rows.iter().find(|row| row[1] > 100.0).unwrap();
    assert!((middle[1] - middle[4] - 0.04).abs() < 1e-6, "{middle:?}");
    assert!((middle[7] - (0.1 * middle[4] - 40.0)).abs() < 1e-3, "{middle:?}");
    // Every 3 ms, 2 s and v/a = 20 ms long, and at its end.
    assert!(rows.windows(2).all(|pair| (pair[1][0] - pair[0][0] - 0.003).abs() < 1e-6));
    let end = rows.last().unwrap();
    assert!((end[1] - 200.0).abs() < 1e-9 && (end[4] - 200.0).abs() < 1e-3 && (2.0..2.3).contains(&end[0]), "{end:?}");
}

#[test]
fn wrong_orders_are_refused() {
    let shop = Shop::new().file("p.mpf", PATH).file("m.toml", MILL).file("still.mpf", "M8\nM30\n");
    let refused = |arguments: &[&str]| {
        let run = shop.run([&["simulate", "--machine", "m.toml"], arguments].concat());
        (run.code, run.stderr)
    };
    for (arguments, code, said) in [
        (&["p.mpf", "-o", "t.csv", "--feed", "1000,1000"][..], 2, "twice"),
        (&["p.mpf", "-o", "t.csv", "--feed", "1e-9"], 2, "from 1"),
        (&["p.mpf", "-o", "-"], 2, "pair of files"),
        (&["plan.csv", "-o", "t.csv", "--feed", "1000"], 2, "part programs"),
        (&["still.mpf", "-o", "t.csv"], 4, "E0304"),
    ] {
        let (status, text) = refused(arguments);
        assert_eq!((status, text.contains(said)), (code, true), "{arguments:?}: {text}");
    }
    assert!(!shop.path("t.csv").exists() && !shop.path("t.toml").exists());
}

/// Five axes at six feeds, a deflection of 1.5 µm per m/s² under X that the machine file does not know: what was recorded on one clock is
/// found on one clock, and the deflection at its size, both within three times what they are said to be uncertain by.
#[test]
fn a_simulated_trace_of_five_axes_has_one_clock() {
    let machine = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/samples/machines/esmaeili_huron.toml"));
    let mut text = machine.unwrap()
        + "\n[servo]\ncycle_ms = 3.0\nsmoothing_ms = 12.0\ncorner_tolerance_um = 10.0\nexact_stop_um = 10.0\n";
    for axis in ["X", "Y", "Z", "A", "C"] {
        let most = if "XYZ".contains(axis) { "max_acceleration_m_s2 = 5.0" } else { "max_acceleration_rad_s2 = 20.0" };
        text += &format!("[servo.{axis}]\nvelocity_gain_per_s = 50.0\nfeed_forward = 0.98\n{most}\n");
    }
    let hidden = text.clone() + "[[dynamic]]\ncomponent = \"EXX\"\num_per_m_s2 = 1.5\n";
    let path = "G54 G90 G94 G17\nG0 X100 Y0 Z100 A0 C0\nG1 X150 Y30 Z120 A10 C20 F5000\nX80 Y60 Z100 A20 C40\n\
                X120 Y-20 Z140 A30 C10\nX60 Y-60 Z100 A15 C-20\nX140 Y10 Z150 A0 C-40\nX100 Y70 Z110 A10 C0\n\
                X150 Y0 Z100 A25 C30\nX100 Y0 Z100 A0 C0\nM30\n";
    let shop = Shop::new().file("m.toml", &text).file("hidden.toml", &hidden).file("p.mpf", path);
    for seed in ["1", "2", "3"] {
        let simulate = ["simulate", "p.mpf", "--machine", "hidden.toml", "--feed", "500,1000,2000,5000,10000,15000"];
        shop.run([&simulate[..], &["--noise", "0.2um", "--seed", seed, "-o", "t.csv"]].concat()).exits(0);
        let json = shop.run(["decompose", "t.csv", "--machine", "m.toml", "--json"]).exits(0).json();
        let number = |place: &str| json.pointer(place).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
        let (delay, uncertainty) = (number("/reading_delay/ms"), number("/reading_delay/uncertainty_ms"));
        assert!(delay.abs() < 3.0 * uncertainty && uncertainty < 0.02, "seed {seed}: {delay} ± {uncertainty} ms");
        let found = &json["compliances"][0];
        assert_eq!(found["component"], "EXX", "{json}");
        let value = [&found["value"], &found["uncertainty"]].map(|value| value.as_f64().unwrap_or(f64::NAN));
        assert!((value[0] - 1.5).abs() < 3.0 * value[1] && value[1] < 0.05, "seed {seed}: {value:?}");
    }
}
