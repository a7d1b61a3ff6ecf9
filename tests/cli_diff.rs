//! `ncfix diff`: what was changed, as text, in figures and for programs.

use crate::support::{Shop, machine};

/// Squareness of Y, 100 µrad, and a scale of X, 40 µm/m: at X Y the tip is off by −1e-4·Y + 4e-5·X in X, and the word of X gets that with the
/// other sign.
pub(crate) const MILL: &str = "[machine]\nname = \"mill\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-500, 500]\n\
    [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-400, 400]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-300, 300]\n\
    [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n\
    [zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n\
    [location]\nEC0Y = 100\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 4e-5]\n";
pub(crate) const PROGRAM: &str = "N10 G90 G17 G71 G94 G54\nN15 D0\nN20 G0 X100 Y200 Z50\nN30 R1=150\nN40 G1 X=R1 F1000 ; AN EXPRESSION\n\
    N50 Y0\nN60 X0\nN70 ROT RPL=90\nN80 G1 X200 Y-100\nN90 ROT\nN100 M30\n";

fn shop() -> Shop {
    let shop = Shop::new().file("mill.toml", MILL).file("part.mpf", PROGRAM);
    shop.run(["part.mpf", "-o", "out.mpf", "--machine", "mill.toml"]).exits(0);
    shop
}

fn diff<'a>(more: &[&'a str]) -> Vec<&'a str> {
    ["diff", "part.mpf", "out.mpf", "--machine", "mill.toml"].into_iter().chain(more.iter().copied()).collect()
}

#[test]
fn rows_have_what_hand_arithmetic_gives() {
    let json = shop().run(diff(&["--json", "--top", "100"])).exits(1).json();
    let row = |number: &str| {
        let rows = json["rows"].as_array().unwrap();
        rows.iter().find(|row| row["number"] == number).unwrap_or_else(|| panic!("{number}: {json}")).clone()
    };
    let word = |number: &str, axis: &str| {
        let row = row(number);
        let words = row["words"].as_array().unwrap();
        let word = words.iter().find(|word| word["axis"] == axis).unwrap_or_else(|| panic!("{number} {axis}: {row}"));
        let text = |key: &str| word[key].as_str().unwrap().to_owned();
        (text("before"), text("after"), (word["added"].as_f64().unwrap() * 10.0).round() / 10.0)
    };
    // 1e-4 · 200 − 4e-5 · 100 = 16 µm; 20 − 6 = 14 µm; −6 µm. The expression has no number of its own.
    assert_eq!(word("N20", "X"), ("100".into(), "100.016".into(), 16.0));
    assert_eq!(word("N40", "X"), ("150.000".into(), "150.014".into(), 14.0));
    assert_eq!(word("N50", "X"), ("150.000".into(), "149.994".into(), -6.0));
    // X200 Y-100 in a frame turned by 90° is X100 Y200 of the machine: its X is −Y of the program.
    assert_eq!(word("N80", "Y"), ("-100".into(), "-100.016".into(), -16.0));
    assert_eq!(json["axes"]["X"]["max_line"], 3);
    assert_eq!(
        (json["moves"][0].as_u64(), json["changed"].as_u64(), json["same"].as_bool()),
        (Some(5), Some(4), Some(false))
    );
    // X0 Y0 has no error.
    assert_eq!(json["left"]["without an error of an increment"], 1, "{json}");
    assert_eq!((json["compared"].as_str(), json["schema"].as_u64()), (Some("executed"), Some(1)));
    // X gets 16, 14, −6, 0 µm one after the other, and then Y −16: the largest step is from 14 to −6.
    assert!((json["largest_step"]["um"].as_f64().unwrap() - 20.0).abs() < 0.1, "{json}");
}

#[test]
fn the_status_says_whether_they_differ() {
    let shop = shop();
    shop.run(["diff", "part.mpf", "part.mpf", "--machine", "mill.toml"]).exits(0);
    shop.run(diff(&[])).exits(1);
    shop.run(diff(&["--tolerance", "17um"])).exits(0);
    shop.run(diff(&["--axis", "Z"])).exits(0);
    shop.run(diff(&["--fail-above", "17um"])).exits(0);
    let run = shop.run(diff(&["--fail-above", "15um"])).exits(4).says("E0303").says("16.0 µm");
    assert!(run.stdout.contains("more than the 15.0 µm allowed"), "{}", run.stdout);
    assert!(shop.run(diff(&["--fail-above", "17um"])).exits(0).stdout.contains("verdict      nothing found"));
    // 16 µm are not above 16 µm.
    shop.run(diff(&["--fail-above", "16um"])).exits(0);
    shop.run(diff(&["--fail-above", "15um", "--axis", "X", "--axis", "Z"])).exits(4);
    shop.run(["diff", "part.mpf", "none.mpf", "--machine", "mill.toml"]).exits(2);
    let shop = shop.file("other.mpf", "N10 G90 G71 G54\nN20 G0 X100 Y200 Z50\nN40 G1 X20 F1000\n");
    shop.run(["diff", "part.mpf", "other.mpf", "--machine", "mill.toml"]).exits(4).says("E0311");
    let shop = shop.file("broken.mpf", "N10 G0 X\n");
    shop.run(["diff", "part.mpf", "broken.mpf", "--machine", "mill.toml"]).exits(3).says("broken.mpf:1:8");
}

#[test]
fn rows_are_those_that_are_asked_for() {
    let shop = shop();
    let numbers = |more: &[&str]| -> Vec<String> {
        let page = shop.run(diff(more)).exits(1).stdout;
        let rows = page.lines().filter(|line| line.starts_with('N'));
        rows.map(|line| line.split(' ').next().unwrap().to_owned()).collect()
    };
    assert_eq!(numbers(&[]), ["N20", "N40", "N50", "N80"]);
    assert_eq!(numbers(&["--only", "15um"]), ["N20", "N80"]);
    assert_eq!(numbers(&["--axis", "Y"]), ["N80"]);
    assert_eq!(numbers(&["--top", "3"]), ["N20", "N80", "N40"]);
    assert_eq!(numbers(&["--summary"]), [""; 0]);
    let folded = shop.run(diff(&["--only", "15um"])).exits(1).stdout;
    assert!(folded.contains("… 3 not changed"), "{folded}");
}

/// A step of 25 mm makes pieces; their ends are on the line, at 0.25, 0.5 … of the way.
#[test]
fn a_move_of_several_pieces_is_one_row() {
    let shop = shop();
    shop.run(["part.mpf", "-o", "out.mpf", "--machine", "mill.toml", "--step", "25mm"]).exits(0);
    let json = shop.run(diff(&["--json", "--top", "100"])).exits(1).json();
    let row = json["rows"].as_array().unwrap().iter().find(|row| row["number"] == "N50").unwrap().clone();
    // 200 mm of Y in steps of 25 mm.
    assert_eq!((row["pieces"].as_u64(), row["line"].as_u64()), (Some(8), Some(6)), "{row}");
    assert_eq!(row["corrected"][1].as_u64().unwrap() - row["corrected"][0].as_u64().unwrap(), 7);
    let text = shop.run(diff(&[])).exits(1).stdout;
    assert!(text.contains("N50 1:8"), "{text}");
}

#[test]
fn the_page_keeps_its_width_and_has_colors_where_they_are_wanted() {
    let demo = machine("demo");
    let shop = Shop::new().copy("samples/programs/sinumerik/slots.mpf");
    shop.run(["slots.mpf", "-o", "out.mpf", "--machine", &demo]).exits(0);
    let page = shop.run(["diff", "slots.mpf", "out.mpf", "--machine", &demo]).exits(1).stdout;
    insta::assert_snapshot!("diff_slots", page);
    let in_columns = |columns: &str| {
        let mut command = shop.command(["diff", "slots.mpf", "out.mpf", "--machine", &demo]);
        let run = command.env("COLUMNS", columns).env("CLICOLOR_FORCE", "1").output().unwrap();
        String::from_utf8(run.stdout).unwrap()
    };
    for (columns, width) in [("80", 80), ("160", 160), ("10", 80)] {
        let colored = in_columns(columns);
        assert!(colored.contains("\u{1b}[33m"), "{colored}");
        let plain = colored.replace("\u{1b}[33m", "").replace("\u{1b}[0m", "");
        let widest = plain.lines().skip_while(|line| !line.starts_with("N")).map(|line| line.chars().count()).max();
        assert!(widest.unwrap() <= width, "{columns}: {widest:?}\n{plain}");
    }
    assert!(!page.contains('\u{1b}'));
}

#[test]
fn programs_that_do_not_run_here_are_compared_as_they_are_written() {
    let shop = Shop::new()
        .file("old.nc", "O1 (A PART)\nN10 G0 X1. Y2.\nN20 G1 Z-3.5 F100.\nN30 X4.\nM30\n")
        .file("new.nc", "O1\nG0X1.000Y2.0\nG1 Z-3.512 F100 (DEEPER)\nG4 P1.\nX4.\nM30\n")
        .file("alike.nc", "N1 O1\nN2 G00 X1 Y2\nN3 G01 Z-3.5 F0100\nX4\nM30");
    shop.run(["diff", "old.nc", "alike.nc", "--text"]).exits(0);
    let json = shop.run(["diff", "old.nc", "new.nc", "--text", "--json"]).exits(1).json();
    assert_eq!(
        (json["same_lines"].as_u64(), json["changed"].as_u64(), json["new"].as_u64()),
        (Some(4), Some(1), Some(1))
    );
    assert!((json["words"]["Z"]["max"].as_f64().unwrap() + 0.012).abs() < 1e-12, "{json}");
    let text = shop.run(["diff", "old.nc", "new.nc", "--text"]).exits(1).stdout;
    assert!(text.contains("L3        Z      -3.5 → -3.512    (-0.0120)\nnew L4    + G4 P1.\n"), "{text}");
    shop.run(["diff", "old.nc", "new.nc", "--text", "--fail-above", "0.02mm"]).exits(4);
    shop.run(["diff", "old.nc", "alike.nc", "--text", "--fail-above", "0.02mm"]).exits(0);
    let one = shop.run(["diff", "old.nc", "new.nc", "--text", "--top", "1"]).exits(1).stdout;
    assert!(one.contains("+ G4 P1.") && !one.contains("-3.512 "), "{one}");
    // A program that is no program for this machine says how it can be compared.
    shop.run(["diff", "old.nc", "new.nc", "--machine", &machine("demo")]).exits(3).says("--text");
}

/// In inches, the correction of 40 µm/m · 101.6 mm = 4.064 µm is 0.00016 inch.
#[test]
fn words_in_inches_are_compared_in_inches() {
    let mill = MILL.replace("EC0Y = 100", "EC0Y = 0").replace("coefficients = [0, 4e-5]", "coefficients = [0, 4e-4]");
    for (controller, name, text) in [
        ("fanuc", "part.nc", "%\nO1\nG20 G90 G17 G94 G54\nG0 X0. Y0. Z2.\nG1 X4. F20.\nX-1.\nM30\n%\n"),
        ("rs274", "part.ngc", "G20 G90 G17 G94 G54\nG0 X0 Y0 Z2\nG1 X4 F20\nX-1\nM2\n"),
    ] {
        let shop =
            Shop::new().file("mill.toml", mill.replace("\"sinumerik\"", &format!("\"{controller}\""))).file(name, text);
        shop.run([name, "-o", "out.nc", "--machine", "mill.toml"]).exits(0);
        let json = shop.run(["diff", name, "out.nc", "--machine", "mill.toml", "--json"]).exits(1).json();
        let words: Vec<[f64; 2]> = json["rows"]
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|row| row["words"].as_array().unwrap())
            .map(|word| ["before", "after"].map(|key| word[key].as_str().unwrap().parse().unwrap()))
            .collect();
        let of = |before: f64| {
            words.iter().find(|word| (word[0] - before).abs() < 1e-9).unwrap_or_else(|| panic!("{json:#}"))[1]
        };
        // 4 inch too long by 40.6 µm = 0.0016 inch.
        assert!((of(4.0) - 3.9984).abs() < 1.1e-4 && (of(-1.0) + 0.9996).abs() < 1.1e-4, "{json:#}");
    }
}

/// The strokes of a drilling cycle come from one line and have one correction.
#[test]
fn equal_rows_of_a_cycle_are_counted() {
    let mill = MILL.replace("sinumerik", "fanuc") + "[control]\ndecimal_point = \"calculator\"\n";
    let part =
        "O7\nG21 G17 G90 G40 G49 G80 G94 G54\nG0 X20. Y20. Z50.\nG83 X20. Y20. Z-8. R2. Q2. F200.\nG80\nG0 Z50.\nM30\n";
    let shop = Shop::new().file("mill.toml", mill).file("part.nc", part);
    shop.run(["part.nc", "-o", "out.nc", "--machine", "mill.toml"]).exits(0);
    let words = ["diff", "part.nc", "out.nc", "--machine", "mill.toml"];
    let json = shop.run(words.into_iter().chain(["--json", "--top", "100"])).exits(1).json();
    let all = json["rows"].as_array().unwrap().iter().filter(|row| row["line"] == 4).count();
    let text = shop.run(words).exits(1).stdout;
    let shown = text.lines().filter(|line| line.starts_with("L4 ")).count();
    let counted = text.lines().filter_map(|line| line.trim().strip_prefix("… ")?.strip_suffix(" more rows like this"));
    let more: usize = counted.map(|count| count.parse::<usize>().unwrap()).sum();
    // Five pecks of 2 mm: each goes down and up.
    assert!(all >= 10 && more >= 8, "{text}");
    assert_eq!(shown + more, all, "{text}");
}
