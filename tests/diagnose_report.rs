//! The page of `ncfix diagnose --report`: one file that asks for nothing, with all that was found and how, and its numbers against the plant's
//! truth and against arithmetic; sentences and shapes of effects without a name.

use ncfix_base::units::{Unit, UnitKey};
use ncfix_metrology::diagnose::cause::EffectKind;
use ncfix_metrology::diagnose::{CauseId, Causes, ExplanationSummary, Gate};
use ncfix_metrology::results::compared::Circle;
use ncfix_metrology::results::diagnosis::{CauseReport, DiagnosisResult, RejectedReport, ShapePlace};
use ncfix_metrology::results::readings::{self, DiagnosisReading, DriverReadings, Set};
use ncfix_report::diagnosis::{DiagnosisReport, PageReadings};
use ncfix_report::page;
use roxmltree::Document;
use serde_json::Value;

use crate::calibration_report::{parsed, rows};
use crate::cli_calibrate::bare;
use crate::plant::{Bench, Case, Recipe, Unknown};
use crate::support::Shop;

const HOSTILE: &str = "<script>alert(1)</script> & a name that is very, very long, longer than any title";

fn recipe(bench: Bench, hide: &[u8], unknown: Option<Unknown>, size_in_noise: f64, seed: u64) -> Recipe {
    let hide = hide.to_vec();
    Recipe { bench, hide, unknown, faults: Vec::new(), size_in_noise, fineness: 0.35, outliers: Some(0.0), seed }
}

fn case(bench: Bench, hide: &[u8], unknown: Option<Unknown>, size_in_noise: f64, seed: u64) -> Case {
    recipe(bench, hide, unknown, size_in_noise, seed).cook().unwrap()
}

/// A folder with the files of a case, and the arguments that diagnose them, with the data held out.
fn shop(case: &Case) -> (Shop, Vec<String>) {
    let shop = Shop::new();
    let paths = case.save(&shop.path("")).unwrap();
    let name = |path: &std::path::PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
    let mut arguments = vec!["diagnose".to_owned()];
    arguments.extend(paths.files.iter().map(name));
    arguments.extend(["--machine".to_owned(), name(&paths.machine), "--holdout".to_owned()]);
    arguments.extend(paths.held_out.iter().map(name));
    (shop, arguments)
}

/// The object and the text of the page.
fn diagnosed(case: &Case) -> (Value, String) {
    let (shop, arguments) = shop(case);
    let more = ["--json", "--report", "page.html"].map(str::to_owned);
    let report = shop.run(arguments.into_iter().chain(more)).exits(0).json();
    assert_eq!(report["report"], "page.html");
    (report, shop.text("page.html"))
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} of {value}"))
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().unwrap_or_else(|| panic!("{key} of {value}"))
}

fn name(value: &Value) -> String {
    format!("{} {}", value["effect"].as_str().unwrap(), value["parameter"].as_str().unwrap()).trim_end().to_owned()
}

/// The texts of elements of a name.
fn texts(document: &Document<'_>, element: &str) -> Vec<String> {
    let all = document.descendants().filter(|node| node.tag_name().name() == element);
    let text = |node: roxmltree::Node<'_, '_>| {
        node.descendants().filter(roxmltree::Node::is_text).filter_map(|node| node.text()).collect()
    };
    all.map(text).collect()
}

/// Titles of pictures.
fn pictures(document: &Document<'_>) -> Vec<String> {
    let svg = document.descendants().filter(|node| node.tag_name().name() == "svg");
    let title = |node: roxmltree::Node<'_, '_>| {
        node.children()
            .find(|child| child.tag_name().name() == "title")
            .and_then(|title| title.text().map(str::to_owned))
    };
    svg.filter_map(title).collect()
}

fn verdict(document: &Document<'_>) -> String {
    let node = document.descendants().find(|node| node.attribute("id") == Some("verdict")).unwrap();
    node.text().unwrap().to_owned()
}

fn percent(cell: &str) -> f64 {
    cell.strip_suffix(" %").unwrap_or_else(|| panic!("{cell}")).parse().unwrap()
}

/// The ranking: its rows by cause, the row of all findings, and what is left over.
fn ranking(document: &Document<'_>) -> Vec<Vec<String>> {
    let rows = rows(document);
    let last = rows.iter().position(|row| row.get(1).is_some_and(|cell| cell == "noise and unexplained part")).unwrap();
    let first = rows[..last].iter().rposition(|row| row.len() != rows[last].len()).map_or(0, |before| before + 1);
    rows[first..=last].to_vec()
}

/// What the page must have of what the object has.
fn agrees(document: &Document<'_>, report: &Value) {
    let (findings, ranking) = (list(report, "findings"), ranking(document));
    assert_eq!(ranking.len(), findings.len() + 2);
    let shares: f64 = findings.iter().map(|one| number(one, "share")).sum();
    let all = &ranking[findings.len()];
    assert!((percent(&all[6]) - 100.0 * shares).abs() < 0.06, "{all:?} {shares}");
    assert!((percent(&ranking[findings.len() + 1][6]) - 100.0 * (1.0 - shares)).abs() < 0.06, "{ranking:?}");
    // What is explained is what the squares fall by.
    let [before, after] = ["before", "after"].map(|key| number(&report[key], "rms_um"));
    assert!((shares - (1.0 - (after / before).powi(2))).abs() < 0.01, "{shares} {before} {after}");
    let cells: f64 = ranking[..findings.len()].iter().map(|row| percent(&row[6])).sum();
    assert!((cells - 100.0 * shares).abs() < 0.06 * findings.len() as f64, "{ranking:?}");
    // The largest goes first.
    assert!(ranking[..findings.len()].is_sorted_by(|one, next| percent(&one[4]) >= percent(&next[4])), "{ranking:?}");
    assert!((findings.iter().map(|one| number(one, "alone_share")).sum::<f64>() - 1.0).abs() < 1e-9);
    let headings = texts(document, "h3");
    for (number_of_it, one) in findings.iter().enumerate() {
        assert!(headings.iter().any(|heading| heading.contains(&name(one))), "{} in {headings:?}", name(one));
        let row = ranking.iter().find(|row| row[0] == (number_of_it + 1).to_string()).unwrap();
        assert!(row[1].starts_with(&name(one)), "{row:?} {one}");
        assert!((percent(&row[4]) - 100.0 * number(one, "alone_share")).abs() < 0.06, "{row:?} {one}");
        for rival in list(one, "class").iter().skip(1).take(5) {
            let rival = rival.as_str().unwrap();
            assert!(texts(document, "dd").iter().any(|text| text.contains(rival)), "{rival}");
        }
    }
    let cells = rows(document);
    for one in list(report, "rejected") {
        let row = cells.iter().find(|row| row.len() == 5 && row[0] == name(one));
        assert!(row.is_some(), "{one} is not among what was rejected");
    }
    // Every cause of the catalogue.
    for cause in Causes::default().iter().map(|cause| cause.cause()) {
        assert!(cells.iter().any(|row| row.len() == 6 && row[0] == cause.name), "{}", cause.name);
    }
}

#[test]
fn a_ball_bar_shows_every_cause_alone() {
    // Squareness, and play of an axis.
    let case = case(Bench::Ballbar, &[8, 20], None, 6.0, 2);
    let (report, text) = diagnosed(&case);
    let document = parsed(&text);
    agrees(&document, &report);
    let (verdict, pictures) = (verdict(&document), pictures(&document));
    for hidden in &case.truth.effects {
        let own = format!("{} {}", hidden.effect, hidden.parameter);
        assert!(verdict.contains(&own), "{own} in {verdict}");
        assert!(pictures.iter().any(|title| title.starts_with(&format!("{own} alone, "))), "{own} in {pictures:?}");
    }
    // A squareness β makes an oval r β sin 2φ / 2: from −r β / 2 to r β / 2. The longest bar of the plant has 150 mm.
    let location = case.truth.effects.iter().find(|effect| effect.effect == "location").unwrap();
    assert_eq!(location.unit, "urad");
    let expected = location.size.abs() * 1e-6 * 150.0 * 1e3;
    let found = list(&report, "findings").iter().find(|one| one["effect"] == "location").unwrap();
    let alone = number(found, "alone_um");
    assert!((alone / expected - 1.0).abs() < 0.1, "{alone} of {expected}");
    let captions = texts(&document, "figcaption");
    let circularity = captions.iter().find_map(|caption| {
        caption.strip_prefix("Circularity of this cause alone: ")?.split(' ').next()?.parse::<f64>().ok()
    });
    assert!(circularity.is_some(), "{captions:?}");
    for wanted in
        ["Ball-bar, XY", "Residual over time", "Residual over X", "Residual over Y", "Residual over feed_mm_min"]
    {
        assert!(pictures.iter().any(|title| title.starts_with(wanted)), "{wanted} in {pictures:?}");
    }
    // Measurements used and held out.
    let headings = texts(&document, "h2");
    assert!(headings.iter().any(|heading| heading.contains("held out, residual before and after")), "{headings:?}");
    assert!(headings.contains(&"Rejected candidates".to_owned()));
}

#[test]
fn a_drift_is_drawn_over_time_with_its_sensor() {
    let case = case(Bench::Drift, &[38], None, 6.0, 2);
    let (report, text) = diagnosed(&case);
    let document = parsed(&text);
    agrees(&document, &report);
    let hidden = &case.truth.effects[0];
    let found =
        list(&report, "findings").iter().find(|one| name(one) == format!("{} {}", hidden.effect, hidden.parameter));
    let sensor = found.unwrap_or_else(|| panic!("{hidden:?} in {report:#}"))["sensor"].as_str().unwrap();
    let direction = hidden.parameter.to_lowercase();
    let pictures = pictures(&document);
    let wanted = [
        format!("Drift: d{direction} over time"),
        format!("{sensor} over time"),
        format!("Evidence: d{direction} over {sensor}"),
        format!("Residual d{direction} over {sensor}"),
    ];
    for wanted in wanted {
        assert!(pictures.contains(&wanted), "{wanted} in {pictures:?}");
    }
}

#[test]
fn where_nothing_is_hidden_the_page_says_so() {
    let (report, text) = diagnosed(&case(Bench::Plate, &[], None, 5.0, 4));
    assert!(list(&report, "findings").is_empty(), "{report:#}");
    let document = parsed(&text);
    let verdict = verdict(&document);
    assert!(
        verdict.contains("No cause accepted") && verdict.contains("No systematic residual beyond the noise"),
        "{verdict}"
    );
    let headings = texts(&document, "h2");
    assert!(!headings.iter().any(|heading| heading == "Evidence" || heading == "Ranking"), "{headings:?}");
    let all = texts(&document, "body").concat();
    for cause in Causes::default().iter().map(|cause| cause.cause()) {
        assert!(all.contains(cause.name), "{}", cause.name);
    }
    // Nothing to tell apart: one cloud of readings, without a legend.
    assert!(!all.contains("before\n") && pictures(&document).contains(&"Residual dx over X".to_owned()));
}

#[test]
fn an_effect_without_a_name_is_told_in_a_sentence_and_a_shape() {
    // (y − 250) / 200 beyond 400 mm in X, nothing before it: the plant's words for it.
    let case = Recipe { fineness: 1.0, ..recipe(Bench::Plate, &[], Some(Unknown::Beyond), 5.0, 11) }.cook().unwrap();
    let (report, text) = diagnosed(&case);
    let one = &list(&report, "findings")[0];
    let what = one["what"].as_str().unwrap_or_else(|| panic!("{one}"));
    let (head, tail) = what.split_once("only where X is beyond ").unwrap_or_else(|| panic!("{what}"));
    assert_eq!(
        (head, tail.ends_with(" mm; shape attached")),
        ("unknown: an error along Z that depends on Y ", true),
        "{what}"
    );
    let limit: f64 = tail.split(' ').next().unwrap().parse().unwrap();
    assert!((375.0..430.0).contains(&limit), "{what}");
    let size = case.truth.effects[0].size;
    let shape = list(one, "shape");
    assert!(shape.len() > 15, "{shape:?}");
    let mut seen = [0, 0];
    for place in shape {
        let [x, y] = [0, 1].map(|k| place["at"][k].as_f64().unwrap());
        let value = number(place, "value_um");
        // Places stand for those around them.
        if x < 350.0 {
            assert!(value.abs() < 0.05 * size.abs(), "{place}");
            seen[0] += 1;
        } else if x > 450.0 {
            let expected = size * (y - 250.0) / 200.0;
            assert!((value - expected).abs() < 0.35 * size.abs(), "{place}: {expected}");
            seen[1] += 1;
        }
    }
    assert!(seen[0] > 3 && seen[1] > 3, "{seen:?}");
    let document = parsed(&text);
    assert!(verdict(&document).contains("an error along Z that depends on Y only where X is beyond"));
    assert!(pictures(&document).iter().any(|title| title.starts_with("Shape over ")));
    let (shop, arguments) = shop(&case);
    let told = shop.run(arguments).exits(0).stdout;
    assert!(told.contains(what) && told.contains("µm  X"), "{told}");
}

#[test]
fn what_the_data_held_out_denies_is_rejected_with_its_gain() {
    let (used, other) = (case(Bench::Plate, &[20], None, 6.0, 3), case(Bench::Plate, &[], None, 6.0, 3));
    let (shop, arguments) = shop(&used);
    let shop = shop.file("other.csv", &other.held_out[0].csv).file("other.toml", &other.held_out[0].toml);
    let kept = arguments.iter().take_while(|argument| *argument != "--holdout").map(String::as_str);
    let more = ["--holdout", "other.csv", "--json", "--report", "page.html"];
    let report = shop.run(kept.chain(more)).exits(0).json();
    let own = format!("{} {}", used.truth.effects[0].effect, used.truth.effects[0].parameter);
    let rejected = list(&report, "rejected").iter().find(|one| name(one) == own);
    let rejected = rejected.unwrap_or_else(|| panic!("{own} in {report:#}"));
    assert_eq!(rejected["why"], "held-out data");
    assert!(number(rejected, "gain") < 0.01 && number(rejected, "p") < 1e-3, "{rejected}");
    let page = shop.text("page.html");
    let row = rows(&parsed(&page)).into_iter().find(|row| row.len() == 5 && row[0] == own).unwrap();
    assert!(row[2].contains("held-out") && percent(&row[4]) < 1.0, "{row:?}");
}

/// A level over one axis: angles only, a slope of 20 µrad over 600 mm and a spread that is no noise of a generator but an irrational step.
fn level() -> Shop {
    let mut text = "component,X,Y,Z,run,value_urad\n".to_owned();
    for run in 0..4 {
        for k in 0..31 {
            let x = 50.0 + 20.0 * f64::from(k);
            let spread = (f64::from(31 * run + k) * 0.618_034).fract() - 0.5;
            text += &format!("EAX,{x},100,100,{run},{:.4}\n", 20.0 * (x - 350.0) / 600.0 + spread);
        }
    }
    Shop::new()
        .file("start.toml", bare("demo"))
        .file("level.csv", text)
        .file("level.toml", "[measurement]\nkind = \"direct\"\nsigma_urad = 0.3\nfree = [\"offset\"]\n")
}

const LEVEL: [&str; 4] = ["diagnose", "level.csv", "--machine", "start.toml"];

#[test]
fn angles_are_told_in_angles() {
    let shop = level();
    let run = shop.run(LEVEL.iter().chain(&["--json", "--report", "page.html"])).exits(0);
    let report = run.json();
    assert_eq!(report["unit"], "urad", "{report:#}");
    let page = shop.text("page.html");
    let document = parsed(&page);
    let body = texts(&document, "body").concat();
    assert!(verdict(&document).contains("µrad") && !body.contains("µm"), "{body}");
    let told = shop.run(LEVEL).exits(0).stdout;
    assert!(told.contains("µrad RMS over 124 readings") && !told.contains("µm"), "{told}");
}

#[test]
fn a_page_takes_no_others_place_and_says_why_data_are_refused() {
    let shop = level();
    let run = |more: &[&str]| shop.run(LEVEL.iter().chain(more));
    run(&["-o", "out.toml", "--report", "out.toml"]).exits(2).says("the same file");
    run(&["--json", "--report", "-"]).exits(2).says("standard output");
    run(&["-o", "-", "--report", "-"]).exits(2).says("standard output");
    run(&["--report", "missing/page.html"]).exits(2);
    for input in ["level.csv", "level.toml", "start.toml"] {
        let before = shop.text(input);
        run(&["--report", input]).exits(4).says(&format!("overwrite {input}"));
        assert_eq!(shop.text(input), before);
    }
    assert_eq!(shop.names(), ["level.csv", "level.toml", "start.toml"]);
    // The page to standard output, the text for people beside it.
    let out = run(&["--report", "-"]).exits(0);
    assert!(out.stdout.starts_with("<!DOCTYPE html>") && out.stderr.contains("RMS over 124 readings"), "{out:?}");
    let shop = level().file("level.csv", "component,X,Y,Z,value_urad\nEAX,0,0,0,a<b>\n");
    shop.run(LEVEL.iter().chain(&["--report", "page.html"])).exits(4);
    let page = shop.text("page.html");
    let document = parsed(&page);
    assert!(verdict(&document).starts_with("Refused"));
    assert!(document.descendants().any(|node| node.text().is_some_and(|text| text.contains("level.csv:2"))), "{page}");
}

#[test]
fn a_million_readings_and_many_findings_are_a_page_that_opens() {
    const COUNT: usize = 1_000_000;
    let at = |k: usize| k as f64 / COUNT as f64;
    let wave = |k: usize| (at(k) * 1e5).sin();
    let readings = (0..COUNT).map(|k| DiagnosisReading {
        row: k / 3 + 1,
        part: k % 3,
        before: 5.0 * wave(k),
        after: wave(k),
        counts: k % 1000 != 7,
    });
    let driver = |name: &str| DriverReadings {
        name: name.into(),
        title: format!("{name} in mm"),
        is_time: false,
        values: (0..COUNT).map(|k| at(k) * 500.0).collect(),
    };
    let circle = |setup: usize| Circle {
        setup,
        plane: "XY".into(),
        axes: ["X".into(), "Y".into()],
        radius_mm: 150.0,
        is_counterclockwise: setup.is_multiple_of(2),
        angles: (0..COUNT).skip(setup).step_by(40).map(|k| (k, at(k) * std::f64::consts::TAU)).collect(),
    };
    let names = ["X", "Y", "Z", "t_s", "X_dir", "T_a_C", "T_b_C", HOSTILE];
    let set = Set {
        name: HOSTILE.into(),
        kind: "ballbar",
        unit: Unit::Um,
        parts: ["dx", "dy", HOSTILE].map(str::to_owned).to_vec(),
        setups: (0..40).map(|k| format!("<{k}")).collect(),
        readings: readings.collect(),
        doing: (0..10).map(|_| (0..COUNT).map(wave).collect()).collect(),
        drivers: names.iter().map(|name| driver(name)).collect(),
        circles: (0..40).map(circle).collect(),
        ..Set::default()
    };
    let grid = (0..100).map(|k| ShapePlace { at: vec![f64::from(k % 10), f64::from(k / 10)], value_um: f64::from(k) });
    let mut cause = CauseReport::default();
    cause.effect = "thermal-drift".into();
    cause.parameter = HOSTILE.into();
    cause.drivers = vec!["X".into(), "T_a_C".into()];
    cause.sensor = Some("T_a_C".into());
    cause.class = vec![HOSTILE.into(); 3000];
    cause.shape = grid.collect();
    cause.alone_um = f64::NAN;
    cause.unit = "um".into();
    let rejected = RejectedReport { effect: HOSTILE.into(), why: Gate::Chance, ..RejectedReport::default() };
    let mut found = DiagnosisResult::default();
    found.unit = UnitKey::Um;
    found.machine = HOSTILE.into();
    found.readings = COUNT;
    found.findings = vec![cause; 10];
    found.rejected = vec![rejected; 3000];
    let readings = readings::ShownReadings { sets: vec![set], ..readings::ShownReadings::default() };
    let shown = PageReadings { readings, ..PageReadings::default() };
    let report = DiagnosisReport { found, ..DiagnosisReport::default() };
    let page = page::diagnosis::diagnosis(&report, &shown);
    assert!(page.len() < 5_000_000, "{}", page.len());
    let document = parsed(&page);
    let text: String = document.descendants().filter_map(|node| node.text()).collect();
    assert!(
        text.contains("2500 more rows are not shown") && text.contains("34 more circles are not drawn"),
        "{}",
        page.len()
    );
    assert!(report.page().len() < 200_000);
}

/// Without a certain cause, the first line names the test that the most probable explanation failed.
#[test]
fn an_explanation_that_is_not_accepted_names_the_failed_test() {
    let first = |rejected: Vec<RejectedReport>, terms: &[CauseId]| {
        let mut found = DiagnosisResult::default();
        found.readings = 90;
        found.unit = UnitKey::Um;
        found.unexplained.structure = true;
        found.unexplained.rms_um = 1.5;
        found.explanations = vec![ExplanationSummary { terms: terms.to_vec(), probability: 0.999 }];
        found.rejected = rejected;
        DiagnosisReport { found, ..DiagnosisReport::default() }.headline()
    };
    let drift = RejectedReport {
        effect: "drift".into(),
        parameter: "Y".into(),
        why: Gate::Unseen,
        ..RejectedReport::default()
    };
    let of_drift = CauseId::Effect(EffectKind::Drift, "Y".to_owned());
    let of_location = CauseId::Effect(EffectKind::Location, "EC0X".to_owned());
    let alone = first(vec![drift.clone()], std::slice::from_ref(&of_drift));
    assert!(alone.contains("drift Y (probability > 99 %) failed the test on left-out readings"), "{alone}");
    let two = first(vec![drift], &[of_location, of_drift.clone()]);
    assert!(two.contains("drift Y failed the test on left-out readings"), "{two}");
    let unknown = first(Vec::new(), std::slice::from_ref(&of_drift));
    assert!(unknown.contains("the search did not confirm"), "{unknown}");
    assert!([alone, two, unknown].iter().all(|text| !text.contains("although")));
}
