//! The uncertainty of a certified length or scale is in the uncertainty of what rests on it, and the fit itself does not change.

use std::fmt::Write as _;

use serde_json::Value;

use crate::cli_calibrate::bare;
use crate::explain::{DESCRIPTION, Plant};
use crate::support::Shop;

fn one<'r>(report: &'r Value, name: &str) -> &'r Value {
    let all = report["parameters"].as_array().unwrap();
    all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name} of {report:#}"))
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} of {value}"))
}

/// The same calibration with two descriptions: values and uncertainties of a parameter.
fn twice(table: &str, descriptions: [&str; 2], model: &str, name: &str) -> [[f64; 2]; 2] {
    descriptions.map(|description| {
        let shop = Shop::new().file("start.toml", bare("demo")).file("d.csv", table).file("d.toml", description);
        let words = ["calibrate", "d.csv", "--machine", "start.toml", "--model", model, "-o", "m.toml", "--json"];
        let report = shop.run(words).exits(0).json();
        let found = one(&report, name);
        [number(found, "value"), number(found, "sigma")]
    })
}

/// An error of 0.5 µm of a bar of 100 mm looks like 5 µm/m of all axes.
#[test]
fn the_length_of_a_bar_is_in_all_scales() {
    let table = Plant { scale: [30e-6, -20e-6, 10e-6], ..Plant::default() }.measured(7);
    let certified = format!("{DESCRIPTION}length_sigma_um = 0.5\n");
    let model = "EXX1,EYY1,EZZ1,EC0X,EB0Z,EA0Z";
    for name in ["EXX1", "EYY1", "EZZ1"] {
        let [bare, with] = twice(&table, [DESCRIPTION, &certified], model, name);
        assert!((bare[0] - with[0]).abs() < 1e-9, "{name}: {bare:?} {with:?}");
        assert!(bare[1] < 2.0 && (with[1] - bare[1].hypot(5.0)).abs() < 0.05, "{name}: {bare:?} {with:?}");
    }
    // A squareness is not an error of the length.
    let [bare, with] = twice(&table, [DESCRIPTION, &certified], model, "EC0X");
    assert!((bare[1] - with[1]).abs() < 1e-3 * bare[1], "{bare:?} {with:?}");
    // The scales have it in common: the difference of two is as well known as before.
    let shop = Shop::new().file("start.toml", bare_machine()).file("d.csv", &table).file("d.toml", &certified);
    let words = ["calibrate", "d.csv", "--machine", "start.toml", "--model", model, "-o", "m.toml"];
    shop.run(words).exits(0);
    let rows: Value = uncertainties(&shop.text("m.toml"));
    let row = |name: &str| -> Vec<f64> {
        let mut own: Vec<f64> =
            rows[name].as_array().unwrap().iter().map(|part| part.as_f64().unwrap() * 1e6).collect();
        own.resize(6, 0.0);
        own
    };
    let [x, y] = [row("EXX1"), row("EYY1")];
    let size = |row: &[f64]| row.iter().map(|part| part * part).sum::<f64>().sqrt();
    let difference: Vec<f64> = x.iter().zip(&y).map(|(a, b)| a - b).collect();
    assert!(size(&x) > 5.0 && size(&y) > 5.0 && size(&difference) < 2.0, "{x:?} {y:?}");
}

fn bare_machine() -> String {
    bare("demo")
}

/// The rows of `[uncertainty]` of a machine file.
fn uncertainties(text: &str) -> Value {
    let section = text.split("[uncertainty]").nth(1).unwrap();
    let rows = section.lines().filter_map(|line| line.split_once(" = ")).filter(|(_, list)| list.starts_with('['));
    rows.map(|(name, list)| (name.to_owned(), serde_json::from_str::<Value>(list).unwrap())).collect()
}

/// A laser along X and Y with 20 and −30 µm/m, twice in both directions.
fn laser() -> String {
    let mut table = "run,component,X,Y,Z,value_um\n".to_owned();
    // No two readings are equal: equal rows are copies.
    let mut step = 0.0;
    let mut scatter = |is_up: bool| {
        step += 0.001;
        if is_up { 0.2 + step } else { -0.2 - step }
    };
    for run in 0..2 {
        for k in (0..8).chain((0..8).rev()) {
            let scatter = scatter((k + run) % 2 == 0);
            let x = 80.0 * f64::from(k);
            let _ = writeln!(table, "{run},EXX,{x},200,100,{:.4}", 20e-3 * x + scatter);
        }
        for k in (0..8).chain((0..8).rev()) {
            let scatter = scatter((k + run) % 2 == 0);
            let y = 60.0 * f64::from(k);
            let _ = writeln!(table, "{run},EYY,300,{y},100,{:.4}", -30e-3 * y + scatter);
        }
    }
    table
}

#[test]
fn the_scale_of_a_laser_and_of_a_plate_is_in_the_scales_of_the_axes() {
    let laser = laser();
    let direct = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.3\n";
    let certified = format!("{direct}sigma_um_per_m = 2.0\n");
    for name in ["EXX1", "EYY1"] {
        let [bare, with] = twice(&laser, [direct, &certified], "EXX1,EYY1", name);
        assert!((with[1] - bare[1].hypot(2.0)).abs() < 1e-3 && bare[1] < 0.5, "{name}: {bare:?} {with:?}");
    }
    let mut plate = "X,Y,Z,tool_z_mm,dx_um,dy_um\n".to_owned();
    for k in 0..64 {
        let [x, y] = [100.0 + 60.0 * f64::from(k % 8), 50.0 + 50.0 * f64::from(k / 8)];
        let scatter = if (k * 7) % 5 < 2 { 0.3 } else { -0.2 };
        let _ = writeln!(plate, "{x},{y},100,-120,{:.4},{:.4}", 20e-3 * x + scatter, -30e-3 * y - scatter);
    }
    let free = "[measurement]\nkind = \"displacement\"\nfree = [\"offset\", \"rotation\"]\nsigma_um = 0.3\n";
    let certified = format!("{free}[artefact]\nsigma_um_per_m = 1.5\n");
    let model = "EXX1,EYY1,EC0X";
    for name in ["EXX1", "EYY1"] {
        let [bare, with] = twice(&plate, [free, &certified], model, name);
        assert!((with[1] - bare[1].hypot(1.5)).abs() < 1e-3 && bare[1] < 0.8, "{name}: {bare:?} {with:?}");
    }
    let [bare, with] = twice(&plate, [free, &certified], model, "EC0X");
    assert!((bare[1] - with[1]).abs() < 1e-3, "{bare:?} {with:?}");
}

#[test]
fn a_diagnosis_has_the_certificate_in_its_intervals() {
    let table = Plant { scale: [60e-6, -45e-6, 0.0], ..Plant::default() }.measured(5);
    let of = |description: &str| {
        let shop = Shop::new().file("start.toml", bare("demo")).file("d.csv", &table).file("d.toml", description);
        let report = shop.run(["diagnose", "d.csv", "--machine", "start.toml", "--json"]).exits(0).json();
        let all = report["findings"].as_array().unwrap();
        let found = all.iter().find(|one| one["parameter"] == "EXX").unwrap_or_else(|| panic!("{report:#}"));
        [number(found, "value"), number(found, "u95")]
    };
    let (bare, with) = (of(DESCRIPTION), of(&format!("{DESCRIPTION}length_sigma_um = 1.0\n")));
    assert!((bare[0] - with[0]).abs() < 0.1, "{bare:?} {with:?}");
    // 1 µm of 100 mm: 10 µm/m, times 1.96 is 19.6. The usual size of a scale, 50 µm/m or more, narrows this to at least 19.6/√(1 + (10/50)²) = 19.2.
    assert!(bare[1] < 15.0 && with[1] > 19.2, "{bare:?} {with:?}");
}

#[test]
fn a_key_at_the_wrong_place_says_where_it_belongs() {
    let table = Plant::default().measured(5);
    let shop = Shop::new()
        .file("start.toml", bare("demo"))
        .file("d.csv", table)
        .file("d.toml", DESCRIPTION.replace("sigma_um = 0.5\n", "sigma_um = 0.5\nsigma_um_per_m = 5\n"));
    let words = ["calibrate", "d.csv", "--machine", "start.toml", "-o", "m.toml"];
    shop.run(words).exits(4).says("length_sigma_um in [setup.NAME]");
}
