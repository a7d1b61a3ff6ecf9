//! What is told, but too badly to be of use; distances that contradict each other; names that are too long for a table; feeds that no axis has.

use ncfix_machine::machine::State;
use ncfix_metrology::calibrate::reduce;
use ncfix_metrology::measure::data::Free;
use ncfix_model::ErrorModel;

use crate::calibrate::{at, measurement, named, observation, reading, setup};
use crate::cli_calibrate::bare;
use crate::support::Shop;

/// Three readings d apart beside an unknown zero tell the slope to σ/(√2 d) and the curvature to √6 σ/(2 d²).
#[test]
fn a_reduced_model_leaves_out_what_is_told_badly() {
    let machine = crate::model::machine("wFXYZSt");
    let left_out = |d: f64| -> Vec<(String, String)> {
        let mut set = measurement("direct", &[Free::Offset]);
        set.setups.push(setup("", [0.0; 3], 0.0));
        set.targets = vec!["EXX".into()];
        for k in 0..3 {
            let mut row = observation(
                reading(at(&[('X', 600.0 + d * f64::from(k))]), nalgebra::Vector3::zeros(), State::default()),
                0,
            );
            row.target = Some(0);
            row.component = Some("EXX".parse().unwrap());
            row.values = [Some(0.0), None, None];
            set.observations.push(row);
        }
        let found = reduce(&machine, &ErrorModel::default(), &named("EXX1 EXX2"), &[set]).unwrap();
        let names = |one: &ncfix_metrology::calibrate::Confused| (one.parameters[0].to_string(), one.sentence.clone());
        found.left_out.iter().map(names).collect()
    };
    let names = |d: f64| left_out(d).into_iter().map(|(name, _)| name).collect::<Vec<_>>();
    // At 1 µm: 0.042 mm of the slope at the tip with 10 mm, 0.14 mm with 3 mm; the curvature is metres off. With 120 mm the curvature
    // is 0.04 mm off and the slope, which is that at X 0 and so 2·720 mm times the curvature's, 0.089 mm; with 110 mm 0.103 mm.
    assert_eq!(names(10.0), ["EXX2"]);
    assert_eq!(names(3.0), ["EXX2", "EXX1"]);
    assert_eq!(names(110.0), ["EXX1"]);
    assert_eq!(names(120.0), [""; 0]);
    let rms = [600.0_f64, 610.0, 620.0].map(|x| x.powi(4)).iter().sum::<f64>() / 3.0;
    let um = rms.sqrt() * 6.0_f64.sqrt() / (2.0 * 10.0_f64.powi(2));
    assert!(left_out(10.0)[0].1.contains(&format!("{um:.0} µm")), "{um}: {:?}", left_out(10.0));
}

/// Six readings of the line, which the curvature follows by millimetres.
#[test]
fn what_is_told_too_badly_is_refused() {
    let rows = [600, 610, 620, 600, 610, 620].iter().zip([0.5, -0.4, 0.6, -0.5, 0.4, -0.6]);
    let rows = rows.fold("X,Y,Z,component,value_um,run\n".to_owned(), |text, (x, um)| {
        text.clone() + &format!("{x},0,0,EXX,{um},{}\n", text.len())
    });
    let shop = Shop::new()
        .file("start.toml", bare("demo"))
        .file("line.csv", rows)
        .file("line.toml", "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\n")
        .file("model.txt", "EXX1\nEXX2\n");
    let words = "calibrate line.csv --machine start.toml --model model.txt -o m.toml";
    let refused =
        shop.run(words.split_whitespace()).exits(4).says("E0606").says("determined so poorly").says("--reduce");
    assert!(!refused.stderr.contains("check units and signs"), "{}", refused.stderr);
    assert!(!shop.path("m.toml").exists());
    shop.run(format!("{words} --reduce").split_whitespace()).exits(0).says("W0605").says("left out: EXX2");
}

#[test]
fn distances_that_contradict_each_other_are_named() {
    let length = |mm: f64| format!("[[length]]\nfrom = \"a\"\nto = \"b\"\nvalue_mm = {mm}\n");
    let description = |lengths: &[f64]| {
        lengths.iter().fold("[measurement]\nkind = \"probe\"\n".to_owned(), |text, mm| text + &length(*mm))
    };
    let shop = |lengths: &[f64]| {
        Shop::new()
            .file("start.toml", bare("demo"))
            .file("balls.csv", BALLS)
            .file("balls.toml", description(lengths))
            .file("model.txt", "EXX1\n")
    };
    let words = "calibrate balls.csv --machine start.toml --model model.txt -o m.toml";
    let found = shop(&[100.0, 100.4]).run(words.split_whitespace()).exits(0).says("W0604");
    // Half of 400 µm on either side, 2000 times 0.1 µm.
    assert!(
        found.stderr.contains("a residual of 200 µm remains in the distance from a to b (100 mm)"),
        "{}",
        found.stderr
    );
    assert!(found.stderr.contains("(100.4 mm), 2000 times its uncertainty"), "{}", found.stderr);
    let sound = shop(&[100.0]).run(words.split_whitespace()).exits(0);
    assert!(!sound.stderr.contains("distance from"), "{}", sound.stderr);
}

/// Two balls 100 mm apart along X, each probed four times.
const BALLS: &str = "X,Y,Z,target\n100,100,100,a\n200,100,100,b\n100.0005,100,100.0002,a\n200.0003,100.0003,100,b\n\
    99.9996,100.0001,100,a\n199.9998,100,99.9997,b\n100.0001,99.9998,100,a\n200.0001,99.9999,100,b\n";

#[test]
fn a_name_may_be_longer_than_a_table_is_wide() {
    let label = "L".repeat(70_000);
    let rows = (0..8).map(|k| format!("{label},{},{},0,{}\n", 50 * k, 20 * (k % 3), [0.1, -0.1][k % 2]));
    let rows = rows.fold("setup,X,Y,Z,dx_um\n".to_owned(), |text, row| text + &row);
    let shop = Shop::new()
        .file("start.toml", bare("demo"))
        .file("plate.csv", rows)
        .file("plate.toml", "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\n")
        .file("model.txt", "EXX1\n");
    let words = "calibrate plate.csv --machine start.toml --model model.txt -o m.toml";
    shop.run(words.split_whitespace()).exits(0).says("X of the artifact");
}

#[test]
fn a_feed_that_no_axis_has_is_refused() {
    let shop = Shop::new().file("demo.toml", bare("demo"));
    let plan = |feed: &str| shop.run(["plan", "ballbar", "--machine", "demo.toml", "-o", "p.csv", "--feed", feed]);
    // Z of the demo machine goes 15 m/min.
    plan("15001").exits(2).says("15000 mm/min");
    assert!(!shop.path("p.csv").exists());
    plan("15000").exits(0);
}
