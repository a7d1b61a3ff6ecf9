//! Pages of commands, and their pictures as files: their numbers against arithmetic by hand, their markup, and where they may be written.

use roxmltree::Document;

use crate::calibration_report::{parsed, rows};
use crate::cli_diff::{MILL, PROGRAM};
use crate::support::Shop;

const WITH_MILL: [&str; 2] = ["--machine", "mill.toml"];

fn shop() -> Shop {
    Shop::new().file("mill.toml", MILL).file("part.mpf", PROGRAM)
}

fn with_mill<'a>(words: &[&'a str]) -> Vec<&'a str> {
    words.iter().copied().chain(WITH_MILL).collect()
}

/// Entries of the strip of figures.
fn strip(document: &Document<'_>) -> Vec<(String, String)> {
    let strip = document.descendants().find(|node| node.attribute("class") == Some("strip")).unwrap();
    let text = |node: roxmltree::Node<'_, '_>, name: &str| {
        node.children()
            .find(|child| child.has_tag_name(name))
            .and_then(|child| child.text())
            .unwrap_or_default()
            .to_owned()
    };
    let entries = strip.children().filter(|node| node.has_tag_name("div"));
    entries.map(|entry| (text(entry, "span"), text(entry, "b"))).collect()
}

#[test]
fn a_program_is_corrected_and_shown_in_one_run() {
    let shop = shop();
    let run = shop.run(with_mill(&["part.mpf", "-o", "out.mpf", "--review", "page.html", "--json"])).exits(0);
    let json = run.json();
    assert_eq!(json["review"], "page.html");
    assert_eq!(json["verdict"]["grade"], "ok", "{json}");
    let text = shop.text("page.html");
    let (_, object) = text.split_once("<script type=\"application/json\" id=\"review\">").unwrap();
    let (object, _) = object.split_once("</script>").unwrap();
    let review: serde_json::Value = serde_json::from_str(object).unwrap();
    // Rules of style reach the browser as they are.
    assert!(text.contains(".row>span{"));
    // 1e-4 · 200 − 4e-5 · 100 = 16 µm, which is what the correction may do at most: 200 µm.
    assert!((review["axes"]["X"]["max"].as_f64().unwrap().abs() - 16.0).abs() < 0.1, "{review}");
    assert_eq!((&review["limits"][0]["limit_um"], &review["limits"][0]["is_kept"]), (&200.0.into(), &true.into()));
    // The text of the program is in the data alone: not even its comment is on the page.
    assert!(!text.contains("AN EXPRESSION"));
    let people = shop.run(with_mill(&["part.mpf", "-o", "out.mpf", "--review", "page.html"])).exits(0);
    assert!(people.stderr.contains("review       page.html"), "{}", people.stderr);
    assert!(people.stderr.contains("verdict      nothing found against running it"), "{}", people.stderr);
}

/// Warnings of the correction are reasons too, although the comparison of both programs does not give them again.
#[test]
fn every_warning_of_a_correction_is_a_reason_of_the_verdict() {
    let without_y = MILL.replace("Y_mm = 0\n", "");
    assert_ne!(without_y, MILL);
    let shop = Shop::new().file("mill.toml", MILL).file("partial.toml", without_y).file("part.mpf", PROGRAM);
    let reasons = |machine: &[&str]| {
        let run =
            shop.run(["part.mpf", "-o", "out.mpf", "--review", "page.html", "--json"].iter().chain(machine)).exits(0);
        let verdict = run.json()["verdict"].clone();
        let codes: Vec<String> = verdict["reasons"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|reason| Some(reason["code"].as_str()?.to_owned()))
            .collect();
        (verdict["grade"].as_str().unwrap().to_owned(), codes)
    };
    // The complete machine file has no warning at all.
    assert_eq!(reasons(&WITH_MILL), ("ok".to_owned(), Vec::new()));
    for (machine, code) in [(&["--machine", "partial.toml"][..], "W0404"), (&[][..], "W0304")] {
        let (grade, codes) = reasons(machine);
        assert!(grade == "warn" && codes.iter().any(|own| own == code), "{code}: {grade} {codes:?}");
        assert!(shop.text("page.html").contains(code), "{code} is on the page");
    }
}

#[test]
fn a_review_in_place_shows_the_original_that_was_kept() {
    let shop = shop();
    let run = shop.run(with_mill(&["part.mpf", "--in-place", "--review", "page.html", "--json"])).exits(0);
    assert_eq!(run.json()["backup"], "part.mpf.bak");
    assert!(shop.text("page.html").contains("part.mpf, made from part.mpf.bak"));
}

#[test]
fn a_review_is_not_written_over_a_program() {
    let shop = shop();
    shop.run(with_mill(&["part.mpf", "-o", "-", "--review", "page.html"])).exits(2).says("--review");
    shop.run(with_mill(&["part.mpf", "-o", "out.mpf", "--review", "-"])).exits(2).says("standard output");
    shop.run(with_mill(&["part.mpf", "-o", "out.mpf", "--review", "out.mpf"])).exits(4).says("E0310").says("--review");
    shop.run(with_mill(&["part.mpf", "-o", "out.mpf", "--review", "part.mpf"])).exits(4).says("E0310");
    shop.run(with_mill(&["part.mpf", "-o", "out.mpf", "--review", "mill.toml"])).exits(4).says("E0310");
    assert_eq!(shop.names(), ["mill.toml", "part.mpf"]);
    assert_eq!(shop.text("part.mpf"), PROGRAM);
    // Nothing is written of a program that is refused.
    let shop = shop.file("bad.mpf", "N10 G0 X\n");
    shop.run(with_mill(&["bad.mpf", "-o", "out.mpf", "--review", "page.html"])).exits(3);
    assert_eq!(shop.names(), ["bad.mpf", "mill.toml", "part.mpf"]);
    // Other names of the file, which is not there yet: by another way, and as some disks see it.
    let mut pages = vec!["./out.mpf", "OUT.mpf"];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(".", shop.path("same")).unwrap();
        pages.push("same/out.mpf");
    }
    for page in pages {
        shop.run(with_mill(&["part.mpf", "-o", "out.mpf", "--review", page])).exits(4).says("E0310");
        assert!(!shop.path("out.mpf").exists(), "{page}");
    }
}

#[test]
fn a_verification_has_a_page_and_pictures() {
    let shop = shop();
    shop.run(with_mill(&["part.mpf", "-o", "out.mpf"])).exits(0);
    shop.run(with_mill(&["verify", "part.mpf", "out.mpf", "--report", "page.html", "--svg", "pictures"])).exits(0);
    let text = shop.text("page.html");
    let page = parsed(&text);
    let figure = |name: &str| strip(&page).into_iter().find(|(own, _)| own == name).unwrap().1;
    // At X100 Y200 the tip is off by 16 µm, which is more than anywhere else on a move with feed.
    assert!(figure("largest").starts_with("16.0 µm → "), "{}", figure("largest"));
    let json = shop.run(with_mill(&["verify", "part.mpf", "out.mpf", "--json"])).json();
    assert_eq!(figure("samples"), json["samples"].to_string());
    let rows = rows(&page);
    // The moves with feed are in lines 5, 6, 7 and 9.
    let lines: Vec<&str> = rows.iter().filter_map(|row| row.first()?.strip_prefix("part.mpf:")).collect();
    assert_eq!(lines.len(), 4, "{rows:?}");
    assert!(["5", "6", "7", "9"].iter().all(|line| lines.contains(line)), "{lines:?}");
    let of_line_5 = rows.iter().find(|row| row.first().is_some_and(|cell| cell == "part.mpf:5")).unwrap();
    assert_eq!(of_line_5[1], "16.0 µm");
    let pictures = shop.path("pictures");
    let mut names: Vec<String> =
        std::fs::read_dir(&pictures).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(
        names,
        [
            "01-error-along-the-path.svg",
            "02-residual-along-the-path.svg",
            "03-errors-of-the-original-program.svg",
            "04-errors-of-the-corrected-program.svg"
        ]
    );
    for name in names {
        let text = std::fs::read_to_string(pictures.join(name)).unwrap();
        let root = Document::parse(&text).unwrap();
        assert!(root.root_element().has_tag_name(("http://www.w3.org/2000/svg", "svg")));
        assert!(root.descendants().any(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "style"))));
    }
    shop.run(with_mill(&["verify", "part.mpf", "out.mpf", "--report", "part.mpf"])).exits(4).says("E0310");
    shop.run(with_mill(&["verify", "part.mpf", "out.mpf", "--svg", "part.mpf"])).exits(2).says("folder");
    assert_eq!(shop.text("part.mpf"), PROGRAM);
}

#[test]
fn steps_have_a_page() {
    // EYX = 1e-9 · x² mm: over a piece of length s the chord is off by 1e-9 · s² / 4 mm, so that 0.01 µm leave room for 200 mm.
    let bent = format!("{MILL}[[motion]]\ncomponent = \"EYX\"\nkind = \"polynomial\"\ncoefficients = [0, 0, 1e-9]\n");
    let shop = Shop::new().file("mill.toml", bent);
    shop.run(with_mill(&["max-step", "--residual", "0.01um", "--report", "page.html", "--svg", "steps.svg"])).exits(0);
    let text = shop.text("page.html");
    let page = parsed(&text);
    let banner = page.descendants().find(|node| node.attribute("class") == Some("banner")).unwrap();
    let step: f64 = banner.text().unwrap().split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!((195.0..=200.0).contains(&step), "{:?}", banner.text());
    assert!(rows(&page).len() > 10);
    assert!(page.descendants().any(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "circle"))));
    Document::parse(&shop.text("steps.svg")).unwrap();
    shop.run(with_mill(&["max-step", "--report", "mill.toml"])).exits(4).says("E0310");
    shop.run(with_mill(&["max-step", "--report", "-"])).exits(2);
}

#[test]
fn tables_have_a_page() {
    let shop = shop();
    let make = ["tables", "--format", "cec", "--scheme", "free", "-o", "mill.ini", "--check", "--poses", "200"];
    let run = shop.run(with_mill(&[&make[..], &["--report", "page.html", "--json"]].concat())).exits(0);
    let json = run.json();
    assert_eq!(json["written"], serde_json::json!(["mill.ini", "page.html"]));
    let text = shop.text("page.html");
    let page = parsed(&text);
    let rows = rows(&page);
    let cell = |name: &str, k: usize| -> f64 {
        rows.iter().find(|row| row.first().is_some_and(|first| first == name)).unwrap()[k].parse().unwrap()
    };
    for (name, key) in [("without", "before"), ("with the tables", "tables"), ("corrected exactly", "exact")] {
        for (k, figure) in [(1, "mean_um"), (2, "rms_um"), (3, "max_um")] {
            let value = json["check"][key][figure].as_f64().unwrap();
            assert!((cell(name, k) - value).abs() <= 0.006 * value.max(0.1), "{name} {figure}: {value}");
        }
    }
    // X off by −1e-4·Y + 4e-5·X over ±500 and ±400 mm: sqrt((4e-5·500)² / 3 + (1e-4·400)² / 3) mm RMS.
    let rms = f64::hypot(4e-5 * 500.0, 1e-4 * 400.0) / 3_f64.sqrt() * 1e3;
    assert!((cell("without", 2) - rms).abs() < 0.1 * rms, "{} {rms}", cell("without", 2));
    assert!(page.descendants().filter(|node| node.has_tag_name("figure")).count() >= 3, "histograms and tables");
    // One histogram before and one after, each over the distances of the poses.
    for title in ["Tip errors without tables", "Tip errors with the tables"] {
        assert!(text.contains(title), "{title}");
    }
    assert!(text.matches("distance of the tip from its position, µm").count() >= 2);
    shop.run(with_mill(&[&make[..], &["--report", "mill.ini"]].concat())).exits(2);
    shop.run(with_mill(&[&make[..], &["--report", "mill.toml"]].concat())).exits(4).says("E0310");
}
