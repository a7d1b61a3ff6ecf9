//! `ncfix simulate` and `ncfix calibrate` with temperatures and loads at each reading: sessions, what is refused, what is written.

use std::fmt::Write as _;

use crate::calibrate_effects::{halved, levels};
use crate::support::{Shop, repository};

const DIRECT: &str = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\n";
const MODEL: &str = "load.EAX   # all coefficients\nload.EAX.arm_mm\nload.EA0B\n";

fn loads() -> Shop {
    let maho = std::fs::read_to_string(repository("samples/machines/maho700s.toml")).unwrap();
    Shop::new()
        .file("true.toml", maho)
        .file("start.toml", halved())
        .file("plan.csv", levels())
        .file("plan.toml", DIRECT)
        .file("model.txt", MODEL)
}

#[test]
fn a_session_of_levels_with_loads() {
    let shop = loads();
    let more = ["--machine", "true.toml", "--noise", "0.5um", "--seed"];
    shop.run(["simulate", "plan.csv", "-o", "levels.csv"].into_iter().chain(more).chain(["1"])).exits(0);
    shop.run(["simulate", "plan.csv", "-o", "held.csv"].into_iter().chain(more).chain(["2"])).exits(0);
    let arguments =
        ["calibrate", "levels.csv", "--machine", "start.toml", "--model", "model.txt", "-o", "machine.toml"];
    let run = shop.run(arguments.into_iter().chain(["--hold-out", "held.csv", "--json"])).exits(0);
    let report = run.json();
    let list = report["parameters"].as_array().unwrap();
    // As the sample file has it: rad per power of mm, shown in µrad per power of m.
    let expected = [
        ("load.EAX.coefficients[0]", 85.75, "µrad"),
        ("load.EAX.coefficients[1]", -490.0, "µrad/m"),
        ("load.EAX.coefficients[2]", 700.0, "µrad/m^2"),
        ("load.EAX.knots[0].coefficients[2]", -1400.0, "µrad/m^2"),
        ("load.EAX.arm_mm", 375.0, "mm"),
        ("load.EA0B", -150.0, "µrad"),
    ];
    assert_eq!(list.len(), expected.len(), "{report}");
    for (name, value, unit) in expected {
        let one = list.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name}: {report}"));
        let [found, sigma] = ["value", "sigma"].map(|key| one[key].as_f64().unwrap());
        assert!((found - value).abs() < 4.0 * sigma && sigma < 0.05 * value.abs(), "{name}: {one}");
        assert_eq!(one["unit"], unit);
        assert!(one["effect_um"].as_f64().unwrap() >= 0.0 && one["inflation"].as_f64().unwrap() >= 1.0);
    }
    for data in report["data"].as_array().unwrap() {
        assert!((data["left_rms"].as_f64().unwrap() / 0.5 - 1.0).abs() < 0.25, "{data}");
    }
    let codes: Vec<&str> =
        report["diagnostics"].as_array().unwrap().iter().filter_map(|one| one["code"].as_str()).collect();
    assert_eq!(codes, ["W0501", "W0501"], "{report}");
    let (start, written) = (shop.text("start.toml"), shop.text("machine.toml"));
    let changed: Vec<&str> = start.lines().filter(|line| !written.lines().any(|new| new == *line)).collect();
    assert_eq!(changed.len(), 4, "{changed:?}");
    assert!(written.contains("# from a sketch") && written.contains("# guessed"), "{written}");
    shop.run(["machine", "check", "machine.toml"]).exits(0);
}

/// Nothing is known of the load yet: arms are judged and fitted once what they change is not 0, what no reading feels is left out, and
/// repetitions have the loads of their rows.
#[test]
fn loads_from_nothing_with_repetitions() {
    let zero = std::fs::read_to_string(repository("samples/machines/maho700s.toml")).unwrap();
    let zero = zero.replace("8.575e-05, -4.9e-07, 7.0e-10", "0, 0, 0").replace("0, 0, -1.4e-09", "0, 0, 0");
    let model = format!("{MODEL}load.EAX.knots[0].coefficients[2]\nEYX2\n");
    let shop = loads().file("zero.toml", zero.replace("value_urad = -150", "value_urad = 0")).file("model.txt", model);
    let simulated = "simulate plan.csv -o levels.csv --machine true.toml --noise 0.5um --seed 1";
    shop.run(simulated.split_whitespace()).exits(0);
    let words = "calibrate levels.csv --machine zero.toml --model model.txt -o m.toml --reduce --monte-carlo 30 --json";
    let report = shop.run(words.split_whitespace()).exits(0).json();
    let codes = report["diagnostics"].as_array().unwrap().iter().filter_map(|one| one["code"].as_str());
    assert_eq!(codes.collect::<Vec<_>>(), ["W0501", "W0605"], "{report}");
    let list = report["parameters"].as_array().unwrap();
    let arm = list.iter().find(|one| one["name"] == "load.EAX.arm_mm").unwrap();
    let number = |one: &serde_json::Value, key: &str| one[key].as_f64().unwrap();
    assert!((number(arm, "value") - 375.0).abs() < 4.0 * number(arm, "sigma"), "{arm}");
    assert_eq!(list.len(), 6);
    for one in list {
        // Of 30 repetitions a standard deviation is known to 13 %.
        let share = number(one, "sigma_monte_carlo") / number(one, "sigma");
        assert!((0.5..1.6).contains(&share), "{one}");
    }
}

#[test]
fn one_load_does_not_tell_its_effect_from_the_geometry() {
    let mut table = "X,Y,Z,B,component,value_urad,load_N,load_z_mm\n".to_owned();
    for k in 0..15 {
        let _ = writeln!(table, "{},200,100,0,EAX,{},4800,0", 50 * k, k % 3);
    }
    let shop =
        loads().file("one.csv", table).file("one.toml", DIRECT).file("model.txt", "EAX1\nload.EAX.coefficients[1]\n");
    let run = shop.run(["calibrate", "one.csv", "--machine", "start.toml", "--model", "model.txt", "-o", "m.toml"]);
    let run = run.exits(4).says("E0606").says("load.EAX.coefficients[1] is not separable from EAX1");
    run.says("there was only one load").says("measure also without the load");
    assert!(!shop.names().contains(&"m.toml".to_owned()));
}

const THREE: &str = "[machine]\nname = \"three\"\ntopology = \"wFXYZSt\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n\
    [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 600]\n";

fn drift(um_per_k: f64) -> String {
    format!(
        "{THREE}[[drift]]\ndirection = \"Z\"\nsensors = [{{ name = \"T_head\", um_per_K = {um_per_k}, lag_s = 300 }}]   # one is enough\n"
    )
}

/// A table as `ncfix sensors` reads it: no columns of axes, no set-ups.
#[test]
fn a_table_of_drift_needs_no_columns_of_axes() {
    let mut table = "t_s,dz_um,T_head_C\n".to_owned();
    let mut follower = 21.0;
    let head = |t_s: f64| 21.0 + t_s.min(3000.0) / 500.0;
    for k in 0..40 {
        let t_s = 120.0 * f64::from(k);
        // 2.5 µm/K of what follows with 300 s, from the first row on; ± 0.1 µm.
        let noise = if k % 2 == 0 { 0.1 } else { -0.1 };
        let _ = writeln!(table, "{t_s},{:.4},{}", 2.5 * (follower - 21.0) + noise, head(t_s));
        for step in 0..1200 {
            let at = t_s + 0.1 * (f64::from(step) + 0.5);
            follower += 0.1 * (head(at) - follower) / 300.0;
        }
    }
    let description =
        "[measurement]\nkind = \"displacement\"\nsigma_um = 0.1\n[position]\nX_mm = 350\nY_mm = 250\nZ_mm = 300\n";
    let shop = Shop::new()
        .file("start.toml", drift(0.0))
        .file("run.csv", table)
        .file("run.toml", description)
        .file("model.txt", "drift\ndrift.Z.T_head.lag_s\n");
    let arguments =
        ["calibrate", "run.csv", "--machine", "start.toml", "--model", "model.txt", "-o", "m.toml", "--json"];
    let report = shop.run(arguments).exits(0).json();
    let list = report["parameters"].as_array().unwrap();
    for (one, (name, value, unit)) in
        list.iter().zip([("drift.Z.T_head", 2.5, "µm/K"), ("drift.Z.T_head.lag_s", 300.0, "s")])
    {
        assert_eq!((one["name"].as_str(), one["unit"].as_str()), (Some(name), Some(unit)));
        let [found, sigma] = ["value", "sigma"].map(|key| one[key].as_f64().unwrap());
        assert!((found - value).abs() < 3.0 * sigma && sigma < 0.05 * value, "{one}");
    }
    assert_eq!(list.len(), 2);
    let written = shop.text("m.toml");
    assert!(written.contains("# one is enough") && written.contains("um_per_K = 2."), "{written}");
    // The same table selects sensors.
    shop.run(["sensors", "run.csv", "--machine", "start.toml"]).exits(0);
    // Its rows have the temperatures, so no warning says that they are missing.
    let run = shop.run(["simulate", "run.csv", "--machine", "start.toml", "-o", "again.csv"]).exits(0);
    assert!(!run.stderr.contains("W0501"), "{}", run.stderr);
    // Its axes must be somewhere, on this machine.
    let shop = shop.file("run.toml", "[measurement]\nkind = \"displacement\"\n[position]\nX_mm = 350\nZ_mm = 300\n");
    let arguments = &arguments[..arguments.len() - 1];
    shop.run(arguments).exits(4).says("E0602").says("there is no column Y");
    let shop = shop.file("run.toml", format!("{description}A_deg = 3\n"));
    shop.run(arguments).exits(4).says("E0602").says("has no axis A");
}

/// Readings without columns of temperatures on a machine that grows by 2.5 µm/K: 25 µm at 30 °C, 12.5 µm half-way of a log.
#[test]
fn the_condition_may_stand_beside_the_tables() {
    let table = |um: f64, off: f64| {
        let rows = (0..8).map(|k| format!("{},200,100,{}\n", 50 * k, um + if k % 2 == 0 { off } else { -off }));
        rows.fold("X,Y,Z,dz_um\n".to_owned(), |text, row| text + &row)
    };
    let description = "[measurement]\nkind = \"displacement\"\nsigma_um = 0.1\n";
    let grows = "[[drift]]\ndirection = \"Z\"\nsensors = [{ name = \"T_head\", um_per_K = 1 }]\n";
    let shop = Shop::new()
        .file("start.toml", format!("{THREE}{grows}"))
        .file("warm.csv", table(25.0, 0.1))
        .file("warm.toml", description)
        .file("half.csv", table(12.5, 0.1))
        .file("half.toml", description)
        .file("again_warm.csv", table(25.0, -0.1))
        .file("again_warm.toml", description)
        .file("again_half.csv", table(12.5, -0.1))
        .file("again_half.toml", description)
        .file("log.csv", "t_s,T_head_C\n0,20\n100,30\n")
        .file("model.txt", "drift\n");
    let calibrate = |table: &str, more: &str| {
        let words = format!("calibrate {table} --machine start.toml --model model.txt -o m.toml --json {more}");
        shop.run(words.split_whitespace())
    };
    let refused = calibrate("warm.csv", "").exits(4).json();
    assert_eq!(refused["diagnostics"][0]["code"], "E0501", "{refused}");
    for (table, more) in [("warm.csv", "--state log.csv"), ("half.csv", "--state log.csv --time 50")] {
        let report = calibrate(table, &format!("{more} --hold-out again_{table}")).exits(0).json();
        let one = &report["parameters"][0];
        assert!((one["value"].as_f64().unwrap() - 2.5).abs() < 1e-6, "{report}");
        assert!(report["diagnostics"].as_array().unwrap().is_empty(), "{report}");
        for data in report["data"].as_array().unwrap() {
            assert!((data["left_rms"].as_f64().unwrap() - 0.1).abs() < 1e-6, "{data}");
        }
        assert_eq!(report["data"].as_array().unwrap().len(), 2);
        let roles: Vec<&str> =
            report["inputs"].as_array().unwrap().iter().map(|one| one["role"].as_str().unwrap()).collect();
        assert!(roles.contains(&"condition"), "{roles:?}");
        assert!(shop.text("m.toml").lines().next().unwrap().contains(", condition "));
    }
    // What was fitted is no test, and readings that count twice look better than they are.
    for words in ["warm.csv", "--hold-out warm.csv"] {
        let refused = calibrate("warm.csv", &format!("--state log.csv {words}")).exits(4);
        assert_eq!(refused.codes(), ["E0605"]);
    }
    // A load that no effect feels is said, a log that is to be overwritten is kept.
    let report = calibrate("warm.csv", "--state log.csv --load 1700").exits(0).json();
    assert_eq!(report["diagnostics"][0]["code"], "W0502", "{report}");
    shop.run("calibrate warm.csv --machine start.toml --model model.txt --state log.csv -o log.csv".split_whitespace())
        .exits(4);
    assert!(shop.text("log.csv").starts_with("t_s"));
}

#[test]
fn wrong_conditions_are_found_at_their_place() {
    let cases = [
        ("X,Y,Z,dz_um,T_head_C\n1,2,3,4,20\n1,2,4,4,nan\n", "E0603", "3:9"),
        ("X,Y,Z,dz_um,T_head_C\n1,2,3,4,20\n1,2,4,4,warm\n", "E0603", "3:9"),
        ("X,Y,Z,dz_um,T_head_C\n1,2,3,4,2000\n1,2,4,4,20\n", "E0603", "2:9"),
        ("X,Y,Z,dz_um,T_head_C\n1,2,3,4,20\n1,2,4,4,\n", "E0603", "3:9"),
        ("t_s,X,Y,Z,dz_um,T_head_C\n5,1,2,3,4,20\n4,1,2,4,4,21\n", "E0603", "3:1"),
        ("t_s,X,Y,Z,dz_um,T_head_C\n5,1,2,3,4,20\n,1,2,4,4,21\n", "E0603", "3:1"),
        ("X,Y,Z,dz_um,T_head_C,load_N\n1,2,3,4,20,100\n", "E0602", "1:22"),
        ("X,Y,Z,dz_um,T_head_C,load_z_mm\n1,2,3,4,20,100\n", "E0602", "1:1"),
        ("X,Y,Z,dz_um,T_head_C,load_N,load_z_mm\n1,2,3,4,20,-100,0\n", "E0603", "2:12"),
        ("X,Y,Z,dz_um,T_head_C,load_N,load_z_mm\n1,2,3,4,20,1e9,0\n", "E0603", "2:12"),
    ];
    for (table, code, place) in cases {
        let shop = Shop::new()
            .file("start.toml", drift(1.0))
            .file("run.csv", table)
            .file("run.toml", "[measurement]\nkind = \"displacement\"\n")
            .file("model.txt", "drift\n");
        let run = shop.run(["calibrate", "run.csv", "--machine", "start.toml", "--model", "model.txt", "-o", "m.toml"]);
        run.exits(4).says(code).says(&format!("run.csv:{place}"));
        assert!(!shop.names().contains(&"m.toml".to_owned()), "{table}");
    }
}

#[test]
fn lines_and_sensors_that_are_unknown_are_named() {
    let table = "t_s,X,Y,Z,dz_um,T_hed_C\n0,1,2,3,4,20\n9,1,2,3,5,25\n";
    let shop = Shop::new()
        .file("start.toml", drift(1.0))
        .file("run.csv", table)
        .file("run.toml", "[measurement]\nkind = \"displacement\"\n");
    let calibrate = |model: &str| {
        let shop = shop.run(["calibrate", "run.csv", "--machine", "start.toml", "--model", model, "-o", "m.toml"]);
        shop.exits(4)
    };
    std::fs::write(shop.path("a.txt"), "EZZ1\n drift.Z.T_nose # this\n").unwrap();
    calibrate("a.txt").says("E0609").says("a.txt:2:2").says("drift.Z.T_head");
    std::fs::write(shop.path("b.txt"), "load\n").unwrap();
    calibrate("b.txt").says("E0609").says("b.txt:1:1").says("no [[load]]");
    std::fs::write(shop.path("c.txt"), "drift\ndrift.Z\n").unwrap();
    calibrate("c.txt").says("c.txt:2:1").says("given twice");
    std::fs::write(shop.path("d.txt"), "drift\n").unwrap();
    calibrate("d.txt").says("E0501").says("T_head");
}

/// Transducers at two heights of a cylinder in the spindle, 60 and 260 mm from the gauge point, read along Y: 2 µm/K of displacement, and a rotation about X
/// of 5 µrad/K, which is 5 · 0.06 = 0.3 and 5 · 0.26 = 1.3 µm/K (Spaan 1995, Fig. 5.1).
#[test]
fn two_heights_of_transducers_give_the_rotation_of_the_tool_holder() {
    let mut table = "t_s,T_head_C,tool_z_mm,dy_um\n".to_owned();
    for k in 0..40 {
        let rise = f64::from(k) / 4.0;
        let noise = if k % 2 == 0 { 0.1 } else { -0.1 };
        for (tool_mm, per_k) in [(-60, 2.3), (-260, 3.3)] {
            let _ = writeln!(table, "{},{},{tool_mm},{:.4}", 60 * k, 20.0 + rise, per_k * rise + noise);
        }
    }
    let entry = |direction: &str, key: &str| {
        format!("[[drift]]\ndirection = \"{direction}\"\nsensors = [{{ name = \"T_head\", {key} = 0 }}]\n")
    };
    let shop = Shop::new()
        .file("start.toml", format!("{THREE}{}{}", entry("Y", "um_per_K"), entry("A", "urad_per_K")))
        .file("run.csv", table)
        .file(
            "run.toml",
            "[measurement]\nkind = \"displacement\"\nsigma_um = 0.1\n[position]\nX_mm = 350\nY_mm = 250\nZ_mm = 300\n",
        )
        .file("model.txt", "drift\n");
    let arguments =
        ["calibrate", "run.csv", "--machine", "start.toml", "--model", "model.txt", "-o", "m.toml", "--json"];
    let report = shop.run(arguments).exits(0).json();
    let list = report["parameters"].as_array().unwrap();
    assert_eq!(list.len(), 2, "{report}");
    for (name, value) in [("drift.Y.T_head", 2.0), ("drift.A.T_head", 5.0)] {
        let one = list.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{report}"));
        assert!((one["value"].as_f64().unwrap() - value).abs() < 0.05, "{one}");
    }
    assert!(shop.text("m.toml").contains("urad_per_K = "), "{}", shop.text("m.toml"));
}

/// A machine ages (Spaan 1995, ch. 5.5): its head drifts by 3 µm/K when the model is made, and by 4 µm/K a year later. The model leaves a quarter of the
/// newer drift, so that its efficiency falls from nearly 1 to 1 − 1/4.
#[test]
fn an_older_machine_loses_efficiency() {
    let run = |per_k: f64, noise_um: f64| {
        let mut table = "t_s,T_head_C,dy_um\n".to_owned();
        for k in 0..40 {
            let rise = f64::from(k) / 4.0;
            let noise = if k % 2 == 0 { noise_um } else { -noise_um };
            let _ = writeln!(table, "{},{},{:.4}", 60 * k, 20.0 + rise, per_k * rise + noise);
        }
        table
    };
    let description =
        "[measurement]\nkind = \"displacement\"\nsigma_um = 0.1\n[position]\nX_mm = 350\nY_mm = 250\nZ_mm = 300\n";
    let start = format!("{THREE}[[drift]]\ndirection = \"Y\"\nsensors = [{{ name = \"T_head\", um_per_K = 0 }}]\n");
    let mut shop = Shop::new().file("start.toml", start).file("model.txt", "drift\n");
    for (name, per_k, noise_um) in [("new", 3.0, 0.01), ("check", 3.0, 0.02), ("old", 4.0, 0.01)] {
        shop = shop.file(&format!("{name}.csv"), run(per_k, noise_um)).file(&format!("{name}.toml"), description);
    }
    let words = ["calibrate", "new.csv", "--machine", "start.toml", "--model", "model.txt", "-o", "m.toml", "--json"];
    let efficiency = |held: &str| {
        let json = shop.run(words.iter().chain(&["--hold-out", held])).exits(0).json();
        let data = json["data"].as_array().unwrap();
        let one = data.iter().find(|one| one["is_held_out"] == true).unwrap_or_else(|| panic!("{json}"));
        one["efficiency"].as_f64().unwrap()
    };
    assert!(efficiency("check.csv") > 0.99);
    let aged = efficiency("old.csv");
    assert!((aged - 0.75).abs() < 0.005, "{aged}");
}

/// An analytical model with an empirical part (Spaan 1995, ch. 9): a column of 800 mm with 11 µm/(m K) lengthens by 8.8 µm/K. What it leaves is fitted to the
/// head: 1.5 µm/K along Z and 3 µm/K along Y.
#[test]
fn a_drift_is_fitted_to_what_the_segments_leave() {
    let segment = "[[segment]]\nname = \"column\"\nbefore = \"Z\"\nfrom_mm = [250, 300, -600]\nto_mm = [250, 300, 200]\num_per_m_K = 11.0\n\
        across = [0, 1, 0]\nacross_mm = 400\nsensors_from = [\"T_c1\", \"T_c2\"]\nsensors_to = [\"T_c3\", \"T_c4\"]\n";
    let mut table = "t_s,T_head_C,T_c1_C,T_c2_C,T_c3_C,T_c4_C,dy_um,dz_um\n".to_owned();
    for k in 0..40 {
        // The head is warm before the column.
        let (head, column) = (f64::from(k.min(10)), f64::from(k) / 10.0);
        let noise = if k % 2 == 0 { 0.1 } else { -0.1 };
        let (y, z) = (3.0 * head + noise, 8.8 * column + 1.5 * head - noise);
        let (head, column) = (20.0 + head, 20.0 + column);
        let _ = writeln!(table, "{},{head},{column},{column},{column},{column},{y:.4},{z:.4}", 60 * k);
    }
    let entry = |direction: &str| {
        format!("[[drift]]\ndirection = \"{direction}\"\nsensors = [{{ name = \"T_head\", um_per_K = 0 }}]\n")
    };
    let shop = Shop::new()
        .file("start.toml", format!("{THREE}{segment}{}{}", entry("Y"), entry("Z")))
        .file("run.csv", table)
        .file(
            "run.toml",
            "[measurement]\nkind = \"displacement\"\nsigma_um = 0.1\n[position]\nX_mm = 350\nY_mm = 250\nZ_mm = 300\n",
        )
        .file("model.txt", "drift\n");
    let arguments =
        ["calibrate", "run.csv", "--machine", "start.toml", "--model", "model.txt", "-o", "m.toml", "--json"];
    let report = shop.run(arguments).exits(0).json();
    let list = report["parameters"].as_array().unwrap();
    for (name, value) in [("drift.Y.T_head", 3.0), ("drift.Z.T_head", 1.5)] {
        let one = list.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{report}"));
        assert!((one["value"].as_f64().unwrap() - value).abs() < 0.02, "{one}");
    }
    assert!(report["data"][0]["left_rms"].as_f64().unwrap() < 0.15, "{report}");
}
