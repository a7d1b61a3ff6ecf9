//! The page of `ncfix calibrate --report`: its numbers against arithmetic by hand, its markup, its size, and when it is written.

use std::fmt::Write as _;

use ncfix_base::units::Unit;
use ncfix_metrology::results::calibration::{CalibrationResult, Data, EstimateReport};
use ncfix_metrology::results::compared::{Circle, MeasurementPart, ReadingPoint, ReadingSeries};
use ncfix_report::calibration::CalibrationReport;
use ncfix_report::page;
use roxmltree::{Document, ParsingOptions};

use crate::cli_calibrate::bare;
use crate::support::Shop;

const HOSTILE: &str = "<script>alert(1)</script>";

pub(crate) fn parsed(text: &str) -> Document<'_> {
    let options = ParsingOptions { allow_dtd: true, nodes_limit: 10_000_000, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).unwrap_or_else(|error| panic!("{error}"));
    assert!(document.descendants().all(|node| node.tag_name().name() != "script"));
    // Nothing is asked of a network: no element loads anything, and the only addresses are names of namespaces.
    for attribute in document.descendants().flat_map(|node| node.attributes()) {
        assert!(!["src", "href", "onload"].contains(&attribute.name()), "{attribute:?}");
    }
    assert!(!text.contains("url(") && !text.contains("@import"));
    document
}

/// The cells of the rows of all tables.
pub(crate) fn rows(document: &Document<'_>) -> Vec<Vec<String>> {
    let rows = document.descendants().filter(|node| node.has_tag_name("tr"));
    rows.map(|row| {
        let cells = row.children().filter(|node| node.has_tag_name("td"));
        cells.map(|cell| cell.text().unwrap_or_default().to_owned()).collect()
    })
    .collect()
}

/// Three digits.
fn shown(value: f64) -> String {
    let decimals = if value.abs() >= 9.995 {
        1
    } else if value.abs() >= 0.9995 {
        2
    } else {
        3
    };
    format!("{value:.decimals$}")
}

const X: [f64; 6] = [100.0, 200.0, 300.0, 400.0, 500.0, 600.0];
/// Readings of EXX in µm, and of EAX in µrad.
const EXX: [f64; 6] = [3.1, 6.4, 8.7, 12.9, 14.8, 18.2];
const EAX: [f64; 6] = [-2.2, -3.7, -6.1, -8.4, -9.6, -12.3];

fn laser() -> Shop {
    let mut text = "component,X,Y,Z,value_um,value_urad\n".to_owned();
    for (x, (exx, eax)) in X.iter().zip(EXX.iter().zip(&EAX)) {
        let _ = writeln!(text, "EXX,{x},0,0,{exx},\nEAX,{x},0,0,,{eax}");
    }
    Shop::new()
        .file("start.toml", bare("demo"))
        .file("laser.csv", text)
        .file("laser.toml", "[measurement]\nkind = \"direct\"\n")
        .file("model.txt", "EXX1\nEAX1\n")
}

const LASER: [&str; 10] = [
    "calibrate",
    "laser.csv",
    "--machine",
    "start.toml",
    "--model",
    "model.txt",
    "-o",
    "machine.toml",
    "--no-robust",
    "--report",
];

#[test]
fn tables_have_the_numbers_of_a_line_through_zero() {
    let shop = laser();
    let report = shop.run(LASER.iter().chain(&["page.html", "--json"])).exits(0).json();
    assert_eq!(report["report"], "page.html");
    let page = shop.text("page.html");
    let document = parsed(&page);
    let rows = rows(&document);
    for (unit, values, index) in [("µm", EXX, 0), ("µrad", EAX, 1)] {
        // Least squares without a constant: k = Σxy / Σxx.
        let slope = X.iter().zip(&values).map(|(x, y)| x * y).sum::<f64>() / X.iter().map(|x| x * x).sum::<f64>();
        let left: Vec<f64> = X.iter().zip(&values).map(|(x, y)| y - slope * x).collect();
        let rms = |values: &[f64]| (values.iter().map(|value| value * value).sum::<f64>() / 6.0).sqrt();
        let most = |values: &[f64]| values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let sum = |values: &[f64]| values.iter().map(|value| value.abs()).sum::<f64>();
        let mean = left.iter().sum::<f64>() / 6.0;
        let sigma = (left.iter().map(|left| (left - mean).powi(2)).sum::<f64>() / 5.0).sqrt();
        let efficiency = 1.0 - sum(&left) / sum(&values);
        let row = rows
            .iter()
            .find(|row| row.first().is_some_and(|name| name == "laser") && row.last().is_some_and(|of| of == unit))
            .unwrap_or_else(|| panic!("{rows:?}"));
        let expected = [
            "6".to_owned(),
            shown(rms(&values)),
            shown(most(&values)),
            shown(rms(&left)),
            shown(most(&left)),
            shown(sigma),
        ];
        assert_eq!(row[2..8], expected);
        assert_eq!(row[9], format!("{:.1} %", efficiency * 100.0));
        let part = &report["data"][index]["parts"][0];
        assert_eq!((part["name"].as_str().unwrap(), part["unit"].as_str().unwrap()), (["EXX", "EAX"][index], unit));
        assert!((part["left_sigma"].as_f64().unwrap() - sigma).abs() < 1e-6 * sigma, "{part} {sigma}");
        assert!((part["efficiency"].as_f64().unwrap() - efficiency).abs() < 1e-6, "{part} {efficiency}");
        // Per m: a thousand times per mm.
        let parameter =
            rows.iter().find(|row| row.first().is_some_and(|name| name == ["EXX1", "EAX1"][index])).unwrap();
        assert!((parameter[1].parse::<f64>().unwrap() - slope * 1000.0).abs() < 0.006, "{parameter:?} {slope}");
    }
    // Files with their hashes.
    for name in ["start.toml", "laser.csv", "laser.toml"] {
        let row = rows.iter().find(|row| row.first().is_some_and(|file| file == name)).unwrap();
        assert!(row[2].len() == 12 && row[2].chars().all(|digit| digit.is_ascii_hexdigit()), "{row:?}");
    }
    // The hash in the head of the machine file is that of table and description together, that of the start the same as here.
    let start = rows.iter().find(|row| row.first().is_some_and(|file| file == "start.toml")).unwrap();
    assert!(shop.text("machine.toml").contains(&format!("began with start.toml ({})", start[2])));
}

#[test]
fn a_refused_calibration_has_a_page_that_says_why() {
    let shop = laser().file("model.txt", "EXX1\nEAX1\nEYY1\n");
    let run = shop.run(LASER.iter().chain(&["page.html"])).exits(4);
    run.says("E0606").says("no machine file was written");
    assert!(!shop.path("machine.toml").exists());
    let page = shop.text("page.html");
    let document = parsed(&page);
    let text: String = document.descendants().filter_map(|node| node.text()).collect();
    assert!(text.contains("no machine file was written") && text.contains("error E0606"), "{text}");
    // A cell that is no number: the page names it.
    let shop = laser().file("laser.csv", "component,X,Y,Z,value_um\nEXX,0,0,0,a<b>\n");
    shop.run(LASER.iter().chain(&["page.html"])).exits(4);
    let page = shop.text("page.html");
    let document = parsed(&page);
    assert!(document.descendants().any(|node| node.text().is_some_and(|text| text.contains("laser.csv:2"))), "{page}");
}

#[test]
fn a_page_takes_no_others_place() {
    let shop = laser();
    shop.run(LASER.iter().chain(&["machine.toml"])).exits(2).says("the same file");
    shop.run(LASER.iter().chain(&["-", "--json"])).exits(2).says("standard output");
    shop.run(LASER.iter().chain(&["laser.csv"])).exits(4).says("overwrite laser.csv");
    assert!(shop.text("laser.csv").starts_with("component") && !shop.path("machine.toml").exists());
    shop.run(LASER.iter().chain(&["missing/page.html"])).exits(2);
    assert!(!shop.path("machine.toml").exists());
}

#[test]
fn circles_are_drawn_by_plane_and_sense_and_labels_are_texts() {
    let mut text = "setup,X,Y,Z\n".to_owned();
    for (plane, sense) in [(0, 1), (0, -1), (1, 1), (2, -1)] {
        for step in 0..=36 {
            let (sin, cos) = f64::from(step * 10 * sense).to_radians().sin_cos();
            let (a, b) = (150.0 * cos, 150.0 * sin);
            let off = [[a, b, 0.0], [0.0, a, b], [b, 0.0, a]][plane];
            let _ = writeln!(text, "{HOSTILE},{:.4},{:.4},{:.4}", 350.0 + off[0], 250.0 + off[1], 200.0 + off[2]);
        }
    }
    let toml = format!(
        "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\"]\n\
         [setup.\"{HOSTILE}\"]\ncentre_mm = [350, 250, 200]\nlength_mm = 150\n"
    );
    let machine = bare("demo");
    let shop = Shop::new()
        .file("true.toml", format!("{machine}[location]\nEC0X = 40.0\n"))
        .file("start.toml", machine)
        .file("plan.csv", text)
        .file("plan.toml", toml)
        .file("model.txt", "EC0X\nEB0Z\nEA0Z\n");
    shop.run(["simulate", "plan.csv", "-o", "bar.csv", "--machine", "true.toml", "--noise", "0.2um", "--seed", "1"])
        .exits(0);
    let calibrate = ["calibrate", "bar.csv", "--machine", "start.toml", "--model", "model.txt", "-o", "m.toml"];
    shop.run(calibrate.iter().chain(&["--report", "page.html"])).exits(0);
    let page = shop.text("page.html");
    let document = parsed(&page);
    let pictures: Vec<Vec<&str>> = document
        .descendants()
        .filter(|node| node.tag_name().name() == "svg")
        .map(|svg| svg.descendants().filter(|node| node.is_element()).filter_map(|node| node.text()).collect())
        .filter(|texts: &Vec<&str>| texts.first().is_some_and(|title| title.starts_with("Ball-bar")))
        .collect();
    assert_eq!(pictures.len(), 3, "{pictures:?}");
    for (plane, both, sense) in [("XY", true, "ccw"), ("YZ", false, "ccw"), ("ZX", false, "cw")] {
        let title = format!("Ball-bar {plane}, set-up {HOSTILE}");
        let texts = pictures.iter().find(|texts| texts[0] == title).unwrap_or_else(|| panic!("{pictures:?}"));
        for name in ["measured", "residual"] {
            assert!(texts.contains(&format!("{name} {sense}").as_str()), "{texts:?}");
            let other = if sense == "cw" { "ccw" } else { "cw" };
            assert_eq!(texts.contains(&format!("{name} {other}").as_str()), both, "{texts:?}");
        }
    }
}

#[test]
fn a_million_readings_are_a_page_that_opens() {
    const COUNT: usize = 1_000_000;
    let at = |k: usize| k as f64 / COUNT as f64;
    let points = (0..COUNT).map(|k| {
        let left = (at(k) * 1e5).sin();
        ReadingPoint { row: k + 1, part: k % 3, setup: k % 40, measured: 5.0 * left, left, weight: 1.0 }
    });
    let circle = |setup| Circle {
        setup,
        plane: "XY".into(),
        axes: ["X".into(), "Y".into()],
        radius_mm: 150.0,
        is_counterclockwise: true,
        angles: (0..COUNT).skip(setup).step_by(40).map(|k| (k, at(k) * std::f64::consts::TAU)).collect(),
    };
    let shown = ReadingSeries {
        setups: (0..40).map(|k| format!("<{k}")).collect(),
        points: points.collect(),
        axes: ["X in mm", "Y in mm", "C in °"].map(|axis| (axis.to_owned(), (0..COUNT).map(at).collect())).to_vec(),
        circles: (0..40).map(circle).collect(),
    };
    let parts = ["dx", "dy", "dz"]
        .map(|name| MeasurementPart { name: name.into(), unit: Unit::Um, ..MeasurementPart::default() })
        .to_vec();
    let data = Data {
        name: HOSTILE.into(),
        kind: "ballbar",
        unit: Unit::Um,
        sigma: Some(1.0),
        parts,
        shown,
        ..Data::default()
    };
    let mut unknown = EstimateReport::default();
    unknown.name = HOSTILE.into();
    unknown.sigma = f64::INFINITY;
    unknown.inflation = f64::INFINITY;
    let found = CalibrationResult {
        data: vec![data],
        parameters: vec![unknown.clone(); 5000],
        unknowns: vec![unknown; COUNT / 10],
        machine: HOSTILE.into(),
        ..CalibrationResult::default()
    };
    let page = page::calibration::calibration(&CalibrationReport { found, ..CalibrationReport::default() });
    assert!(page.len() < 4_000_000, "{}", page.len());
    let document = parsed(&page);
    let text: String = document.descendants().filter_map(|node| node.text()).collect();
    assert!(text.contains("99500 more rows are not shown") && text.contains("16 more circles are not drawn"));
    assert!(text.contains("33 others") && text.contains("not identifiable"));
}

#[test]
fn pictures_of_the_page_are_files_too() {
    let shop = laser();
    shop.run(LASER.iter().chain(&["page.html", "--svg", "pictures"])).exits(0);
    let text = shop.text("page.html");
    let figures = parsed(&text).descendants().filter(|node| node.has_tag_name("figure")).count();
    let files: Vec<_> = std::fs::read_dir(shop.path("pictures")).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(figures > 0);
    assert_eq!(files.len(), figures);
    for file in files {
        Document::parse(&std::fs::read_to_string(&file).unwrap()).unwrap_or_else(|fault| panic!("{file:?}: {fault}"));
    }
    // Without a page.
    let shop = laser();
    shop.run(LASER[..LASER.len() - 1].iter().chain(&["--svg", "pictures"])).exits(0);
    assert!(!shop.names().contains(&"page.html".to_owned()) && shop.path("pictures").is_dir());
}

/// A bow of 40 µm/m² at an angle of 60 µrad to the reference: y = 4e-5 x² + 0.06 x, µm over mm.
#[test]
fn a_slope_outside_the_model_is_named() {
    let rows: Vec<String> = (0..13)
        .map(|k| {
            let x = 50.0 * f64::from(k);
            format!("EYX,{x},0,100,{:.3},1", 4e-5 * x * x + 0.06 * x + [0.1, -0.1][k as usize % 2])
        })
        .collect();
    let table = format!("component,X,Y,Z,value_um,X_dir\n{}\n", rows.join("\n"));
    let curvature = |free: &str, model: &str| {
        let shop = Shop::new()
            .file("m.toml", "[machine]\nname = \"m\"\ntopology = \"wFXYZt\"\n[axis.X]\ndirection = [1, 0, 0]\n[axis.Y]\ndirection = [0, 1, 0]\n[axis.Z]\ndirection = [0, 0, 1]\n")
            .file("bow.csv", table.clone())
            .file("bow.toml", format!("[measurement]\nkind = \"direct\"\nfree = [{free}]\nsigma_um = 0.1\n"));
        let run = shop
            .run(["calibrate", "bow.csv", "--machine", "m.toml", "--model", model, "-o", "fitted.toml", "--json"])
            .exits(0);
        let json = run.json();
        let own = json["parameters"].as_array().unwrap().iter().find(|one| one["name"] == "EYX2").unwrap();
        (run.codes().contains(&"W0612".to_owned()), own["value"].as_f64().unwrap())
    };
    let (is_named, value) = curvature("\"offset\"", "EYX2");
    assert!(is_named && (value - 40.0).abs() > 20.0, "{value}");
    for (free, model) in [("\"offset\", \"slope\"", "EYX2"), ("\"offset\"", "EYX1,EYX2")] {
        let (is_named, value) = curvature(free, model);
        assert!(!is_named && (value - 40.0).abs() < 2.0, "{free} {model}: {value}");
    }
}
