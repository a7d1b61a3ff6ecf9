//! `--state`, `--load` and `machine show --at`: the condition of the machine on the command line.

use crate::support::{Run, Shop, repository};

fn shop() -> Shop {
    let maho = std::fs::read(repository("samples/machines/maho700s.toml")).unwrap();
    let text = String::from_utf8(maho).unwrap();
    let sensors = {
        let names = text.split('"').filter(|word| word.starts_with("T_"));
        let mut names: Vec<&str> = names.collect();
        names.sort_unstable();
        names.dedup();
        names
    };
    let warm = |skip: usize| {
        let rows: Vec<String> =
            sensors.iter().skip(skip).enumerate().map(|(k, name)| format!("{name} = {}", 22.0 + k as f64)).collect();
        format!("[temperature_C]\n{}\n", rows.join("\n"))
    };
    Shop::new()
        .file("maho.toml", &text)
        .file("warm.toml", warm(0))
        .file("cold.toml", warm(0).replace("T_bed = 22", "T_bed = 12"))
        .file("short.toml", warm(1))
        .file("zeroed.toml", format!("{}[zero.temperature_C]\nT_bed = 20\n", warm(0)))
        .file("part.pm", "%PM\nN9001\nN1 G17\nN2 G52\nN3 T1 M6\nN4 G0 X0 Y0 Z300 S1000 M3\nN5 G1 Z210 F300\nN6 G1 X100 Y50\nN7 G0 Z300\nN8 M30\n")
}

fn fix(shop: &Shop, more: &[&str]) -> Run {
    let base = ["part.pm", "-o", "out.pm", "--machine", "maho.toml"];
    shop.run(base.iter().chain(more))
}

#[test]
fn what_the_model_needs_and_the_state_lacks_is_said() {
    let shop = shop();
    let run = fix(&shop, &["--json"]).exits(0);
    let codes = run.codes();
    assert!(codes.contains(&"W0501".to_owned()) && codes.contains(&"W0502".to_owned()), "{codes:?}");
    let run = fix(&shop, &["--json", "--load", "0"]).exits(0);
    assert!(!run.codes().contains(&"W0502".to_owned()), "{}", run.stderr);
    let run = fix(&shop, &["--json", "--load", "0", "--state", "warm.toml"]).exits(0);
    assert!(run.codes().iter().all(|code| !code.starts_with("W05")), "{}", run.stderr);
    for state in ["short.toml", "zeroed.toml"] {
        let run = fix(&shop, &["--json", "--load", "0", "--state", state]);
        assert_ne!(run.code, 0);
        assert_eq!(run.codes(), ["E0501"], "{state}");
    }
}

#[test]
fn each_condition_is_corrected_in_its_own_way() {
    let shop = shop();
    let mut outputs = Vec::new();
    for more in [
        &["--load", "0"][..],
        &["--load", "1700@0,0,-280"],
        &["--state", "warm.toml", "--load", "0"],
        &["--state", "cold.toml", "--load", "0"],
    ] {
        fix(&shop, more).exits(0);
        outputs.push(shop.text("out.pm"));
        // On the model in the same condition the output is good, in another one it is not, and another stamp says so.
        let verify = |more: &[&str]| {
            let base = ["verify", "part.pm", "out.pm", "--machine", "maho.toml", "--json"];
            shop.run(base.iter().chain(more))
        };
        let own = verify(more).exits(0);
        assert!(own.json()["after"]["max_um"].as_f64().unwrap() < 2.5, "{more:?}: {}", own.stdout);
        assert!(!own.stdout.contains("W0306"));
        let other = verify(&["--state", "warm.toml", "--load", "5000@0,0,-250"]).exits(4);
        assert!(other.json()["after"]["max_um"].as_f64().unwrap() > 10.0, "{more:?}: {}", other.stdout);
        assert!(other.stdout.contains("W0306"));
    }
    outputs.sort();
    outputs.dedup();
    assert_eq!(outputs.len(), 4);
}

#[test]
fn shares_of_the_sources_add_up_to_what_moves_the_point() {
    let shop = shop();
    let base = ["machine", "show", "maho.toml", "--at", "X=650,Y100,Z-0,B0", "--tool", "200", "--state", "warm.toml"];
    let run = shop.run(base.iter().chain(&["--load", "1700@0,0,-280", "--json"])).exits(0);
    let json = run.json();
    let position = |value: &serde_json::Value| [0, 1, 2].map(|k| value["position_um"][k].as_f64().unwrap());
    let mut sum = [0.0; 3];
    let sources: Vec<&str> =
        json["sources"].as_array().unwrap().iter().map(|one| one["source"].as_str().unwrap()).collect();
    assert_eq!(sources, ["geometry", "coupling", "load", "drift", "expansion"]);
    for source in json["sources"].as_array().unwrap() {
        for (sum, part) in sum.iter_mut().zip(position(&source["deviation"])) {
            *sum += part;
        }
    }
    let whole = position(&json["sum"]);
    for k in 0..3 {
        assert!((sum[k] - whole[k]).abs() < 0.05, "{sum:?} {whole:?}");
    }
    // Along Y, about which B turns, the correction is the opposite of the deviation, though the table moves.
    let row = json["correction"].as_array().unwrap().iter().find(|row| row[0] == "Y_um").unwrap();
    assert!((row[1].as_f64().unwrap() + whole[1]).abs() < 0.05, "{row} {whole:?}");
    let table = shop.run(base.iter().chain(&["--load", "0"])).exits(0).stdout;
    for word in ["geometry", "EYY", "drift", "expansion", "sum", "correction", "µrad"] {
        assert!(table.contains(word), "{word}\n{table}");
    }
    shop.run(["machine", "show", "maho.toml", "--tool", "5"]).exits(2);
    shop.run(["machine", "show", "maho.toml", "--at", "X1,Q2"]).exits(2);
}

#[test]
fn what_no_axis_can_correct_is_reported_by_source() {
    let shop = shop();
    let run = fix(&shop, &["--load", "1700@0,0,-280", "--json"]).exits(0);
    let json = run.json();
    let left = |name: &str| json["remaining"].as_array().unwrap().iter().find(|row| row["source"] == name).cloned();
    // B turns about Y: the tilt of the table about X stays, 150 µrad · 1700/4800 · 580/300 and what the guideway adds.
    let tilt = left("load").unwrap()["tilt_urad"].as_f64().unwrap();
    let table = 150.0 * 1700.0 / 4800.0 * 580.0 / 300.0;
    assert!(tilt > table - 60.0 && tilt < table + 60.0 && tilt > 20.0, "{tilt} {table}");
    let table = fix(&shop, &["--load", "1700@0,0,-280"]).exits(0).stderr;
    assert!(table.contains("tool tilt") && table.contains("load "), "{table}");
}

#[test]
fn play_that_is_less_than_an_increment_is_left_and_said() {
    let machine = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n[axis.X]\ndirection = [1, 0, 0]\n\
        travel_mm = [-500, 500]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-500, 500]\n[axis.Z]\ndirection = [0, 0, 1]\n\
        travel_mm = [-500, 500]\n[control]\nincrement_mm = 0.001\n[location]\nEA0Z = 40\n[[motion]]\ncomponent = \"EXX\"\n\
        kind = \"backlash\"\nvalue_um = -0.8\n";
    let shop = Shop::new().file("m.toml", machine).file("p.mpf", "G0 X0 Y0 Z0\nG1 X50 F500\nX0\nY30\nX50 Z-20\nM30\n");
    let json = shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml", "--json"]).exits(0).json();
    let row =
        |name: &str| json["remaining"].as_array().unwrap().iter().find(|row| row["source"] == name).unwrap().clone();
    // Half the play on either side, and the tilt that a machine without rotary axes keeps.
    let play = row("reversal")["position_um"].as_f64().unwrap();
    assert!((play - 0.4).abs() < 1e-6, "{json}");
    let tilt = row("geometry")["tilt_urad"].as_f64().unwrap();
    assert!((tilt - 40.0).abs() < 1e-3, "{json}");
    let table = shop.run(["p.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0).stderr;
    assert!(table.contains("uncorrected") && table.contains("up to 0.4") && table.contains("(reversal)"), "{table}");
}

#[test]
fn instants_must_lie_in_a_log() {
    let shop = shop().file("log.csv", log());
    for (arguments, word) in [
        (&["--state", "log.csv", "--time", "5000"][..], "outside the log"),
        (&["--state", "log.csv", "--time", "nan"], "outside the log"),
        (&["--state", "log.csv", "--time", "50", "--zero-time", "60"], "after the time of the state"),
        (&["--state", "warm.toml", "--time", "0"], "needs a log"),
    ] {
        fix(&shop, arguments).exits(2).says(word);
    }
}

/// All sensors of the sample rise by 10 K in 100 s.
fn log() -> String {
    let text = std::fs::read_to_string(repository("samples/machines/maho700s.toml")).unwrap();
    let mut sensors: Vec<&str> = text.split('"').filter(|word| word.starts_with("T_")).collect();
    sensors.sort_unstable();
    sensors.dedup();
    let row = |time: f64, value: f64| format!("{time},{}\n", vec![value.to_string(); sensors.len()].join(","));
    let header: Vec<String> = sensors.iter().map(|name| format!("{name}_C")).collect();
    format!("t_s,{}\n{}{}", header.join(","), row(0.0, 20.0), row(100.0, 30.0))
}

#[test]
fn a_zero_point_ends_the_drift_where_it_was_set() {
    let machine = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 500]\n\
        [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 300]\n\
        [[drift]]\ndirection = \"Y\"\nover = \"Z\"\nat_mm = 0\nsensors = [{ name = \"T_a\", um_per_K = 1 }]\n\
        [[drift]]\ndirection = \"Y\"\nover = \"Z\"\nat_mm = 300\nsensors = [{ name = \"T_a\", um_per_K = 4 }]\n";
    let shop = Shop::new()
        .file("m.toml", machine)
        .file("whole.toml", "[temperature_C]\nT_a = 30\n[zero.temperature_C]\nT_a = 30\n")
        .file("there.toml", "[temperature_C]\nT_a = 30\n[zero.temperature_C]\nT_a = 30\n[zero.at]\nZ_mm = 100\n")
        .file("log.csv", "t_s,T_a_C\n0,30\n10,30\n")
        .file("only.toml", "[zero.temperature_C]\nT_a = 30\n");
    let along_y = |z: &str, more: &[&str]| {
        let base = ["machine", "show", "m.toml", "--at", z, "--json"];
        shop.run(base.iter().chain(more)).exits(0).json()["sum"]["position_um"][1].as_f64().unwrap()
    };
    // 10 and 40 µm at 10 K, 20 µm at Z 100 where the zero was set.
    for (z, whole, there) in [("Z0", 0.0, -10.0), ("Z100", 0.0, 0.0), ("Z300", 0.0, 20.0)] {
        assert!((along_y(z, &["--state", "whole.toml"]) - whole).abs() < 1e-6);
        assert!((along_y(z, &["--state", "there.toml"]) - there).abs() < 1e-6, "{z}");
        let by_log = along_y(z, &["--state", "log.csv", "--zero-time", "0", "--zero-at", "Z100"]);
        assert!((by_log - there).abs() < 1e-6, "{z}: {by_log}");
    }
    let run = shop.run(["machine", "show", "m.toml", "--at", "Z0", "--state", "only.toml"]);
    assert_ne!(run.code, 0);
    run.says("E0501");
    shop.run(["machine", "show", "m.toml", "--at", "Z900"]).exits(2).says("outside the travel");
    shop.run(["machine", "show", "m.toml", "--load", "5"]).exits(2).says("--at");
    let shown = shop.run(["machine", "show", "m.toml"]).exits(0).stdout;
    assert!(shown.contains("drift") && shown.contains("T_a"), "{shown}");
}

#[test]
fn a_weight_may_be_laid_over_temperatures() {
    let shop = shop().file("heavy.toml", "[[load]]\nforce_N = 1700\nposition_mm = [0, 0, -280]\n");
    let base = ["machine", "show", "maho.toml", "--at", "X650", "--json"];
    let sum = |more: &[&str]| shop.run(base.iter().chain(more)).exits(0).json()["sum"].to_string();
    let both = sum(&["--state", "warm.toml", "--state", "heavy.toml"]);
    assert_eq!(both, sum(&["--state", "warm.toml", "--load", "1700@0,0,-280"]));
    assert_ne!(both, sum(&["--state", "warm.toml", "--load", "0"]));
}

#[test]
fn readings_are_corrected_for_the_time_at_which_they_were_taken() {
    let machine = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 500]\n\
        [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 300]\n\
        [[drift]]\ndirection = \"X\"\nsensors = [{ name = \"T_a\", um_per_K = 1 }]\n";
    let shop = Shop::new()
        .file("m.toml", machine)
        .file("log.csv", "t_s,T_a_C\n0,20\n100,30\n")
        .file("d.csv", "t_s,X,Y,Z\n0,100,0,0\n50,100,0,0\n100,100,0,0\n")
        .file("late.csv", "t_s,X,Y,Z\n0,100,0,0\n500,100,0,0\n");
    let run =
        |data: &str| shop.run(["correct-readings", data, "-o", "out.csv", "--machine", "m.toml", "--state", "log.csv"]);
    run("d.csv").exits(0);
    // The tool is 0, 5 and 10 µm ahead of what was read.
    let rows: Vec<f64> =
        shop.text("out.csv").lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect();
    for (row, wanted) in rows.iter().zip([100.0, 100.005, 100.01]) {
        assert!((row - wanted).abs() < 1e-7, "{rows:?}");
    }
    let late = run("late.csv");
    assert_ne!(late.code, 0);
    late.says("late.csv:3:1").says("outside the log");
}

#[test]
fn loads_and_deviations_beyond_all_machines_are_refused() {
    let shop = shop().file("empty.csv", "").file("heavy.toml", "[[load]]\nforce_N = 1e9\n");
    for load in ["1e308@1e308,0,1e308", "1e8", "5@0,0,1e9"] {
        fix(&shop, &["--load", load]).exits(2).says("no machine tool");
    }
    let run = fix(&shop, &["--state", "heavy.toml"]);
    assert_ne!(run.code, 0);
    run.says("heavy.toml:2:11").says("E0410");
    // A log that was cut off before its first line is no state.
    assert_ne!(fix(&shop, &["--load", "0", "--state", "empty.csv"]).code, 0);
    let maho = shop.text("maho.toml");
    for (from, to) in [
        ("um_per_K = 3.6", "um_per_K = 1e308"),
        ("um_per_m_K = 8.0", "um_per_m_K = 1e308"),
        ("value_urad = -150", "value_urad = -1e308"),
    ] {
        let text = maho.replacen(from, to, 1);
        assert_ne!(text, maho);
        let shop = Shop::new().file("m.toml", text);
        shop.run(["machine", "check", "m.toml"]).exits(4).says("error[E04").says(from.split(' ').next().unwrap());
    }
    let periodic = "[[motion]]\ncomponent = \"EXX\"\nkind = \"periodic\"\nperiod_mm = 1e-300\namplitude_um = 1\n";
    let shop = Shop::new().file("m.toml", format!("{maho}\n{periodic}"));
    shop.run(["machine", "check", "m.toml"]).exits(4).says("too short");
}

/// A machine without drift: the state changes nothing, so it is said, and the output with its stamp is that without a state.
#[test]
fn a_state_without_effect_is_said() {
    let shop = Shop::new()
        .file("mill.toml", crate::cli_diff::MILL)
        .file("part.mpf", crate::cli_diff::PROGRAM)
        .file("warm.toml", "[temperature_C]\nT_head = 35\n");
    let said = |run: &Run| run.codes().contains(&"W0501".to_owned());
    let run = shop.run(["part.mpf", "-o", "cold.mpf", "--machine", "mill.toml", "--json"]).exits(0);
    assert!(!said(&run), "{}", run.stderr);
    let warm = ["--machine", "mill.toml", "--state", "warm.toml"];
    let run = shop.run(["part.mpf", "-o", "warm.mpf", "--json"].iter().chain(&warm)).exits(0);
    assert!(said(&run), "{}", run.stderr);
    assert_eq!(shop.text("warm.mpf"), shop.text("cold.mpf"));
    for output in ["warm.mpf", "cold.mpf"] {
        shop.run(["verify", "part.mpf", output].iter().chain(&warm)).exits(0).says("--state has no effect");
        let run = shop.run(["verify", "part.mpf", output, "--machine", "mill.toml"]).exits(0);
        assert!(!run.stderr.contains("W0306") && !run.stderr.contains("W0501"), "{}", run.stderr);
    }
    shop.run(["diff", "part.mpf", "warm.mpf"].iter().chain(&warm)).exits(1).says("W0501");
}
