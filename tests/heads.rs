//! Machines with several heads. The independent test: with a head, a program gives the same as on a machine whose only spindle is this head.

use crate::support::{Shop, repository};

/// A machine with a turning table and three linear axes, without its spindle; `CONTROL` are the keys of `[control]`.
const CHAIN: &str = "[machine]\nname = \"m\"\ntopology = \"wBXYFZSt\"\ncontroller = \"CONTROLLER\"\n\
    [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 600]\n\
    [axis.B]\ndirection = [0, -1, 0]\npoint_mm = [350, 0, 250]\ntravel_deg = [-180, 180]\n\
    [control]\nincrement_mm = 0.001\nincrement_deg = 0.001\nCONTROL\n\
    [zero_offset.G54]\nX_mm = 300\nY_mm = 200\nZ_mm = 100\nset = \"absolute\"\n\
    [[tool]]\nnumber = 1\nlength_mm = 120\n[[tool]]\nnumber = 2\nlength_mm = 80\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 3e-5]\n\
    [[motion]]\ncomponent = \"EAZ\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-7]\n\
    [[motion]]\ncomponent = \"EYY\"\nkind = \"backlash\"\nvalue_um = 6\n";
/// Location errors of the whole machine, after which those of a spindle may follow.
const LOCATION: &str = "[location]\nEC0X = 40.0\nEB0X = 15.0\nEX0B = 12.0\n";
const HORIZONTAL: &str = "origin_mm = [0, 0, 30]\naxis = [0, 0, 1]\n";
const VERTICAL: &str = "origin_mm = [0, 150, -60]\naxis = [0, 1, 0]\n";
const OF_HORIZONTAL: &str = "EX0S = 5.0\nEA0S = 20.0\n";
const OF_VERTICAL: &str = "EZ0S = -8.0\nEC0S = 30.0\n";
/// The drift of one head: 3 µm/K along Y and 1 µm/K along X.
const DRIFT: &str = "drift]]\ndirection = \"Y\"\nsensors = [{ name = \"T_v\", um_per_K = 3.0 }]\n";
const DRIFT_X: &str = "drift]]\ndirection = \"X\"\nsensors = [{ name = \"T_v\", um_per_K = 1.0 }]\n";
pub(crate) const STATE: &str = "[temperature_C]\nT_v = 25.0\n";

fn chain(controller: &str, control: &str) -> String {
    CHAIN.replace("CONTROLLER", controller).replace("CONTROL", control)
}

/// A Fanuc adds the length perpendicular to the plane only with this setting.
fn of_control(controller: &str) -> &'static str {
    if controller == "fanuc" { "length_compensation = \"B\"" } else { "" }
}

/// A machine with both heads, selected by these words.
fn both(controller: &str, words: [&str; 2]) -> String {
    format!(
        "{}{LOCATION}[[head]]\nname = \"horizontal\"\nselect = [\"{}\"]\nstart = true\n{HORIZONTAL}[head.location]\n{OF_HORIZONTAL}\
         [[head]]\nname = \"vertical\"\nselect = [\"{}\"]\n{VERTICAL}[head.location]\n{OF_VERTICAL}[[head.{DRIFT}[[head.{DRIFT_X}",
        chain(controller, of_control(controller)),
        words[0],
        words[1]
    )
}

/// A machine with one spindle. The words of the heads move its axes, as a head does that swivels.
fn one(controller: &str, is_vertical: bool, words: [&str; 2]) -> String {
    let control = match (controller, is_vertical) {
        ("grundig", true) => "grundig_head = \"M54\"",
        ("grundig", false) => "grundig_head = \"M53\"",
        _ => of_control(controller),
    };
    let (spindle, location) = if is_vertical { (VERTICAL, OF_VERTICAL) } else { (HORIZONTAL, OF_HORIZONTAL) };
    let drift = if is_vertical { format!("[[{DRIFT}[[{DRIFT_X}") } else { String::new() };
    let opaque: String = words.iter().map(|word| format!("[[opaque]]\nname = \"{word}\"\n")).collect();
    format!("{}{LOCATION}{location}[spindle]\n{spindle}{opaque}{drift}", chain(controller, control))
}

/// A program of a control in these lines, with its head word.
fn program(controller: &str, lines: &[&str]) -> String {
    let numbered = |(index, line): (usize, &&str)| format!("N{} {line}\n", index + 1);
    let body: String = lines.iter().enumerate().map(numbered).collect();
    match controller {
        "grundig" => format!("%PM9001\nN9001\n{body}"),
        "fanuc" => format!("%\nO0001\n{body}%\n"),
        _ => body,
    }
}

/// The language of a program, and its words for the first lines, a tool, no tool, and the end.
pub(crate) struct Dialect {
    controller: &'static str,
    pub(crate) file: &'static str,
    words: [&'static str; 2],
    begin: &'static str,
    tool: fn(u32) -> Vec<String>,
    no_tool: &'static str,
}

pub(crate) const DIALECTS: [Dialect; 4] = [
    Dialect {
        controller: "grundig",
        file: "p.pm",
        words: ["M53", "M54"],
        begin: "G90 G54",
        tool: |number| vec![format!("T{number} M6")],
        no_tool: "T0 M6",
    },
    Dialect {
        controller: "sinumerik",
        file: "p.mpf",
        words: ["M81", "M82"],
        begin: "G90 G71 G54",
        tool: |number| vec![format!("T{number}"), "M6".into(), "D1".into()],
        no_tool: "D0",
    },
    Dialect {
        controller: "fanuc",
        file: "p.nc",
        words: ["M81", "M82"],
        begin: "G90 G21 G54",
        tool: |number| vec![format!("T{number} M6")],
        no_tool: "G49",
    },
    Dialect {
        controller: "rs274",
        file: "p.ngc",
        words: ["M101", "M154"],
        begin: "G90 G21 G54",
        tool: |number| vec![format!("T{number} M6")],
        no_tool: "G49",
    },
];

impl Dialect {
    /// The moves with one head: along Z in G17 with the horizontal one, along Y in G18 with the vertical one.
    pub(crate) fn moves(&self, is_vertical: bool, number: u32) -> Vec<String> {
        let mut lines = vec![if is_vertical { "G18" } else { "G17" }.to_owned()];
        lines.extend((self.tool)(number));
        lines.push("S2000 M3".into());
        match self.controller {
            "fanuc" => lines.push(format!("G43 H{number}")),
            // LinuxCNC adds the lengths of its table along Z; this word states another direction.
            "rs274" if is_vertical => lines.push(if number == 1 { "G43.1 Y120." } else { "G43.1 Y80." }.to_owned()),
            "rs274" => lines.push(format!("G43 H{number}")),
            _ => {}
        }
        let moves: &[&str] = if is_vertical {
            &["G0 X-50. Y60. Z100. B0", "G1 Y-2. F300", "G1 X80. Z20.", "G1 X0. Z0.", "G0 Y60."]
        } else {
            &["G0 X-50. Y40. Z60. B0", "G1 Z-2. F300", "G1 X80. Y20.", "G1 X10. Y0.", "G0 Z60."]
        };
        lines.extend(moves.iter().map(|line| (*line).to_owned()));
        lines
    }

    pub(crate) fn text(&self, parts: &[(bool, Vec<String>)]) -> String {
        let mut lines = vec![self.begin.to_owned()];
        for (index, (is_vertical, moves)) in parts.iter().enumerate() {
            if index > 0 {
                lines.push(self.no_tool.to_owned());
            }
            lines.push(self.words[usize::from(*is_vertical)].to_owned());
            lines.extend(moves.iter().cloned());
        }
        lines.push("M30".to_owned());
        program(self.controller, &lines.iter().map(String::as_str).collect::<Vec<_>>())
    }
}

/// The lines of a corrected text without the stamp, which names the machine file.
fn body(shop: &Shop, file: &str) -> Vec<String> {
    let is_stamp = |line: &&str| line.to_ascii_lowercase().contains("ncfix");
    shop.text(file).lines().filter(|line| !is_stamp(line)).map(str::to_owned).collect()
}

pub(crate) fn shop(dialect: &Dialect, text: &str) -> Shop {
    Shop::new()
        .file("both.toml", both(dialect.controller, dialect.words))
        .file("horizontal.toml", one(dialect.controller, false, dialect.words))
        .file("vertical.toml", one(dialect.controller, true, dialect.words))
        .file("state.toml", STATE)
        .file(dialect.file, text)
}

/// Corrects with a machine file, and returns the lines and the predicted errors.
pub(crate) fn corrected(
    shop: &Shop,
    dialect: &Dialect,
    machine: &str,
    more: &[&str],
) -> (Vec<String>, Vec<serde_json::Value>) {
    let arguments = ["fix", dialect.file, "-o", "out.txt", "--json", "--machine", machine];
    let ran = shop.run(arguments.iter().chain(more)).exits(0);
    let report: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    let figures = ["before", "after", "max_correction", "remaining", "zeros"].map(|key| report[key].clone());
    (body(shop, "out.txt"), figures.to_vec())
}

#[test]
fn a_head_gives_what_a_machine_with_this_spindle_alone_gives() {
    for dialect in &DIALECTS {
        for (is_vertical, machine) in [(false, "horizontal.toml"), (true, "vertical.toml")] {
            let shop = shop(dialect, &dialect.text(&[(is_vertical, dialect.moves(is_vertical, 2))]));
            for more in [&[][..], &["--state", "state.toml"]] {
                let found = corrected(&shop, dialect, "both.toml", more);
                let expected = corrected(&shop, dialect, machine, if is_vertical { more } else { &[] });
                assert_eq!(found, expected, "{} {machine} {more:?}", dialect.controller);
                let word = dialect.words[usize::from(is_vertical)];
                assert!(found.0.iter().any(|line| line.contains(word)), "the word stays: {:?}", found.0);
            }
        }
    }
}

/// Both parts of a program with two heads are those of the programs with one head each.
#[test]
fn each_part_of_a_program_is_corrected_with_its_head() {
    for dialect in &DIALECTS {
        let parts = [(false, dialect.moves(false, 1)), (true, dialect.moves(true, 2))];
        let shop = shop(dialect, &dialect.text(&parts));
        let (found, _) = corrected(&shop, dialect, "both.toml", &["--state", "state.toml"]);
        let alone = [("horizontal.toml", &parts[0], &[][..]), ("vertical.toml", &parts[1], &["--state", "state.toml"])];
        let moves = |lines: &[String]| -> Vec<String> {
            // Block numbers differ between the programs.
            let is_move = |line: &&String| ["X", "Y", "Z"].iter().any(|letter| line.contains(letter));
            let words = |line: &String| {
                line.split_whitespace().filter(|word| !word.starts_with('N')).collect::<Vec<_>>().join(" ")
            };
            lines.iter().filter(is_move).map(words).collect()
        };
        let mut expected = Vec::new();
        for (machine, part, more) in alone {
            let shop = shop_of(&shop, dialect, part);
            expected.extend(moves(&corrected(&shop, dialect, machine, more).0));
        }
        assert_eq!(moves(&found), expected, "{}", dialect.controller);
        // The comparison executes both programs with their heads.
        let arguments =
            ["verify", dialect.file, "out.txt", "--machine", "both.toml", "--state", "state.toml", "--json"];
        let report: serde_json::Value = serde_json::from_str(&shop.run(arguments).exits(0).stdout).unwrap();
        let [before, after] = ["before", "after"].map(|key| report[key]["max_um"].as_f64().unwrap());
        // An increment of 1 µm rounds each axis by half of it; the tolerance is 1 µm.
        assert!(before > 10.0 && after < 1.5, "{}: {before} {after}", dialect.controller);
    }
}

fn shop_of(shop: &Shop, dialect: &Dialect, part: &(bool, Vec<String>)) -> Shop {
    let text = dialect.text(std::slice::from_ref(part));
    let files = ["both.toml", "horizontal.toml", "vertical.toml", "state.toml"];
    files.iter().fold(Shop::new(), |new, file| new.file(file, shop.text(file))).file(dialect.file, text)
}

#[test]
fn what_makes_the_change_unsure_is_refused() {
    let grundig = &DIALECTS[0];
    let sinumerik = &DIALECTS[1];
    for (dialect, lines, reason) in [
        (
            grundig,
            &["G17 G90 G54", "T1 M6", "M54", "G0 X0 Y0 Z0 B0", "M30"][..],
            "a tool length of 120.000 mm is active",
        ),
        (grundig, &["G17 G90 G54", "M54 G0 X0 Y0 Z0 B0", "M30"], "the block also has a motion, a dwell or axis words"),
        (
            grundig,
            &["G17 G90 G54", "M53 M54", "G0 X0 Y0 Z0 B0", "M30"],
            "M53 and M54 select different heads in one block",
        ),
        (
            sinumerik,
            &["G17 G90 G54", "ROT RPL=30", "M82", "G0 X0 Y0 Z0 B0", "M30"],
            "a rotated, mirrored or scaled frame",
        ),
        (
            sinumerik,
            &["G17 G90 G54", "ID=1 WHENEVER $A_IN[1]==1 DO M82", "G0 X0 Y0 Z0 B0", "M30"],
            "a synchronized action",
        ),
        (sinumerik, &["G17 G90 G54", "M=QU(82)", "G0 X0 Y0 Z0 B0", "M30"], "acknowledged later"),
        (
            sinumerik,
            &["G17 G90 G54", "ID=1 WHENEVER $A_IN[1]==1 DO M=82", "G0 X0 Y0", "M30"],
            "may change the head (M=82)",
        ),
        (
            sinumerik,
            &["G17 G90 G54", "R5=82", "ID=1 WHENEVER $A_IN[1]==1 DO M0=R5", "M30"],
            "may change the head (M0=82)",
        ),
        (sinumerik, &["G17 G90 G54", "M0=82", "G0 X0 Y0 Z0 B0", "M30"], "an address extension"),
        (sinumerik, &["G17 G90 G54", "M2=QU(82)", "G0 X0 Y0 Z0 B0", "M30"], "an address extension"),
        (sinumerik, &["G17 G90 G54", "G74 X1=0 M82", "M30"], "the block also has a motion, a dwell or axis words"),
        (
            grundig,
            &["G17 G90 G54", "G0 X0 Y0 Z50 B0", "G78 P1 X10 Y10 Z50", "G1 P1 F100 M54", "M30"],
            "the block also has a motion, a dwell or axis words",
        ),
        (
            &DIALECTS[3],
            &["G17 G90 G54", "G0 X0 Y0 Z0", "G28 M154", "M2"],
            "the block also has a motion, a dwell or axis words",
        ),
    ] {
        let shop = shop(dialect, &program(dialect.controller, lines));
        let ran = shop.run(["fix", dialect.file, "-o", "out.txt", "--machine", "both.toml"]);
        assert!(ran.stderr.contains("error[E0244]") && ran.stderr.contains(reason), "{lines:?}\n{}", ran.stderr);
        assert!(!shop.path("out.txt").exists(), "{lines:?}");
    }
    // The word of the active head changes nothing, whatever is in force.
    let lines = ["G17 G90 G54", "T1 M6", "M53", "S1000 M3", "G0 X0 Y0 Z0 B0", "G1 X5 F100", "M30"];
    let shop = shop(grundig, &program("grundig", &lines));
    shop.run(["fix", "p.pm", "-o", "out.txt", "--machine", "both.toml"]).exits(0);
}

#[test]
fn the_flat_stream_has_the_words_and_is_read_again() {
    let dialect = &DIALECTS[0];
    let parts = [(false, dialect.moves(false, 1)), (true, dialect.moves(true, 2))];
    let shop = shop(dialect, &dialect.text(&parts));
    let flat = shop.run(["snc", "p.pm", "--machine", "both.toml"]).exits(0).stdout;
    let words: Vec<&str> = flat.lines().filter(|line| line.starts_with("M5")).collect();
    assert!(words.len() == 2 && words[0].starts_with("M53 ") && words[1].starts_with("M54 "), "{flat}");
    let again = shop.file("p.snc", &flat);
    assert_eq!(again.run(["snc", "p.snc", "--machine", "both.toml"]).exits(0).stdout, flat);
}

/// A dwell has M functions too: a head word beside it changes the head, and back.
#[test]
fn a_word_beside_a_dwell_changes_the_head() {
    let dialect = &DIALECTS[1];
    let text = dialect.text(&[(false, dialect.moves(false, 1)), (true, dialect.moves(true, 2))]);
    let shop = shop(dialect, &text);
    let (expected, _) = corrected(&shop, dialect, "both.toml", &["--state", "state.toml"]);
    let with_dwell = text.replace("M82", "G4 F1 M82");
    assert_ne!(with_dwell, text);
    let shop = shop.file(dialect.file, with_dwell);
    let (found, _) = corrected(&shop, dialect, "both.toml", &["--state", "state.toml"]);
    let found: Vec<String> = found.iter().map(|line| line.replace("G4 F1 M82", "M82")).collect();
    assert_eq!(found, expected);
    let refused = shop.run(["max-step", dialect.file, "--machine", "both.toml", "--head", "horizontal"]);
    assert!(refused.stderr.contains("error[E0244]"), "{}", refused.stderr);
}

/// A plan belongs to its head.
#[test]
fn a_plan_names_its_head() {
    let shop = Shop::new().file("both.toml", both("sinumerik", ["M81", "M82"]));
    let plan = ["plan", "laser", "--axis", "X", "--machine", "both.toml", "--head", "vertical", "-o", "plan.csv"];
    shop.run(plan).exits(0);
    assert!(shop.text("plan.toml").contains("head = \"vertical\"\n"), "{}", shop.text("plan.toml"));
    let simulate = |head: &'static str| {
        shop.run(["simulate", "plan.csv", "--machine", "both.toml", "--head", head, "-o", "data.csv"])
    };
    simulate("horizontal").exits(4).says("with the head vertical");
    simulate("vertical").exits(0);
}

/// The program of a plan selects its head before the first move, and is otherwise that of a machine with this spindle alone.
#[test]
fn the_program_of_a_plan_selects_its_head() {
    for dialect in &DIALECTS {
        let shop = shop(dialect, "");
        let program = |machine: &str, more: &[&str]| {
            let words = ["plan", "laser", "--axis", "X", "--runs", "1", "-o", "plan.csv", "--program", dialect.file];
            shop.run(words.iter().chain(&["--machine", machine]).chain(more)).exits(0);
            // Without block numbers: the lines of the head shift them.
            let bare = |line: String| match line.split_once(' ') {
                Some((number, rest)) if number.strip_prefix('N').is_some_and(|n| n.parse::<u32>().is_ok()) => {
                    rest.to_owned()
                }
                _ => line,
            };
            body(&shop, dialect.file).into_iter().map(bare).collect::<Vec<String>>()
        };
        for (is_vertical, head) in [(false, "horizontal"), (true, "vertical")] {
            let alone = program(&format!("{head}.toml"), &[]);
            let found = program("both.toml", &["--head", head]);
            let word = dialect.words[usize::from(is_vertical)];
            let without: Vec<String> = found.iter().filter(|line| !line.contains(word)).cloned().collect();
            assert_eq!(without, alone, "{}", dialect.controller);
            let is_place =
                |word: &str| word.strip_prefix('X').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
            let is_move = |line: &String| line.split_whitespace().any(is_place);
            let [at, first] =
                [found.iter().position(|line| line == word), found.iter().position(is_move)].map(Option::unwrap);
            assert!(at < first, "{found:?}");
            // It is read again, with the head that it selects.
            let flat = shop.run(["snc", dialect.file, "--machine", "both.toml"]).exits(0).stdout;
            assert!(flat.lines().any(|line| line.starts_with(&format!("{word} "))), "{flat}");
        }
    }
}

/// Readings of the vertical head show its tilt of 30 µrad: 80 and 180 mm below the gauge point 2.4 and 5.4 µm. The machine file with it keeps the other head.
#[test]
fn a_diagnosis_writes_into_its_head() {
    let dialect = &DIALECTS[0];
    let truth = both("grundig", dialect.words);
    let start = truth.replace("EZ0S = -8.0\nEC0S = 30.0\n", "EZ0S = -8.0\n");
    let shop = Shop::new()
        .file("truth.toml", &truth)
        .file("start.toml", &start)
        .file("plan.csv", plan())
        .file("plan.toml", "[measurement]\nkind = \"displacement\"\nfree = []\n");
    let simulate = ["simulate", "plan.csv", "--noise", "0.1um", "-o", "data.csv"];
    shop.run(simulate.iter().chain(&["--machine", "truth.toml", "--head", "vertical"])).exits(0);
    let words = ["diagnose", "data.csv", "--machine", "start.toml", "--head", "vertical", "-o", "new.toml"];
    shop.run(words).exits(0);
    let text = shop.text("new.toml");
    let (common, vertical) = text.split_once("name = \"vertical\"").unwrap();
    let value = vertical.lines().find_map(|line| line.strip_prefix("EC0S = ")?.parse::<f64>().ok()).unwrap();
    assert!((value - 30.0).abs() < 0.5, "{value}");
    let (_, horizontal) = common.split_once("name = \"horizontal\"").unwrap();
    assert!(horizontal.contains("EX0S = 5.0\nEA0S = 20.0\n") && !common.contains("EC0S = "), "{common}");
    assert!(vertical.contains("[[head.drift]]"), "{vertical}");
    // The other head is corrected as before.
    let show = |file: &str| {
        let words = ["machine", "show", file, "--head", "horizontal", "--at", "X50,Y100,Z20,B0", "--tool", "80"];
        let page = shop.run(words).exits(0).stdout;
        page.lines().filter(|line| line.contains("E")).map(str::to_owned).collect::<Vec<_>>()
    };
    let rows =
        |file: &str| show(file).into_iter().filter(|line| line.trim_start().starts_with('E')).collect::<Vec<_>>();
    assert_eq!(rows("new.toml"), rows("start.toml"));
}

/// The gauge point of the vertical head: with the tool along Y, EC0S turns the tip by 80 mm · 30 µrad = 2.4 µm along X.
#[test]
fn commands_about_one_head_need_its_name() {
    let dialect = &DIALECTS[0];
    let shop = shop(dialect, &dialect.text(&[(true, dialect.moves(true, 2))]));
    let at = ["--at", "X0,Y0,Z0", "--tool", "80"];
    let show = |more: &[&str]| shop.run(["machine", "show", "both.toml"].iter().chain(more));
    let refused = show(&at).exits(2);
    assert!(refused.stderr.contains("choose it with --head horizontal or vertical"), "{}", refused.stderr);
    let page = show(&[&at[..], &["--head", "vertical"]].concat()).exits(0).stdout;
    let row = page.lines().find(|line| line.trim_start().starts_with("EC0S")).unwrap();
    assert!(row.contains(" 2.40 "), "{row}");
    assert!(!page.contains("EX0S"), "{page}");
    let unknown = show(&["--head", "vertica"]).exits(2);
    assert!(unknown.stderr.contains("did you mean vertical?"), "{}", unknown.stderr);
    for command in [
        &["tables", "--scheme", "grid", "--format", "fanuc", "-o", "g.csv"][..],
        &["max-step"],
        &["fix", "p.pm", "--zero-shift", "z.mpf", "--state", "state.toml"],
    ] {
        let ran = shop.run(command.iter().chain(&["--machine", "both.toml"]));
        assert!(ran.code == 2 && ran.stderr.contains("choose it with --head"), "{command:?}\n{}", ran.stderr);
    }
    // A run for one head refuses the word of another one.
    let ran = shop.run(["max-step", "p.pm", "--machine", "both.toml", "--head", "horizontal"]);
    assert!(ran.stderr.contains("error[E0244]: M54 selects the head vertical"), "{}", ran.stderr);
    let tables = |machine: &[&str], out: &str| {
        let fixed = ["tables", "--scheme", "grid", "--format", "fanuc", "--tolerance", "2um", "-o", out];
        shop.run(fixed.iter().chain(machine)).exits(0);
        // The head of a file names the machine file.
        shop.text(out).lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(
        tables(&["--machine", "both.toml", "--head", "vertical"], "a.csv"),
        tables(&["--machine", "vertical.toml"], "b.csv")
    );
    // The option names the head at the start of a program.
    let text = dialect.text(&[(true, dialect.moves(true, 2))]).replace("M54", "M8");
    let shop = shop.file("p.pm", text);
    let (found, _) = corrected(&shop, dialect, "both.toml", &["--head", "vertical"]);
    let (expected, _) = corrected(&shop, dialect, "vertical.toml", &[]);
    assert_eq!(found, expected);
}

#[test]
fn a_word_with_another_meaning_is_refused() {
    for (controller, words, meaning) in [
        ("grundig", ["M53", "M6"], "M6, which selects the head vertical, already means: tool change"),
        ("rs274", ["M101", "M53"], "M53, which selects the head vertical, already means: feed stop input"),
        ("sinumerik", ["M81", "M30"], "M30, which selects the head vertical, already means: a standard function"),
    ] {
        let shop = Shop::new().file("m.toml", both(controller, words));
        let ran = shop.run(["machine", "check", "m.toml"]);
        assert!(ran.stderr.contains("error[E0411]") && ran.stderr.contains(meaning), "{controller}\n{}", ran.stderr);
    }
    for (controller, words, more, meaning) in [
        ("fanuc", ["M81", "M10"], "", "M10, which selects the head vertical, already means: a clamp of an axis"),
        ("fanuc", ["M81", "M82"], "macro_codes = { M82 = 9010 }", "already means: the call of a program"),
    ] {
        let text = both(controller, words).replace("increment_mm = 0.001", &format!("increment_mm = 0.001\n{more}"));
        let ran = Shop::new().file("m.toml", text).run(["machine", "check", "m.toml"]);
        assert!(ran.stderr.contains("error[E0411]") && ran.stderr.contains(meaning), "{controller}\n{}", ran.stderr);
    }
    let text = format!("{}\n[head.segmemt]\n", both("grundig", ["M53", "M54"]));
    let ran = Shop::new().file("m.toml", text).run(["machine", "check", "m.toml"]);
    assert!(ran.stderr.contains("unknown key segmemt in [[head]]"), "{}", ran.stderr);
    let text = both("grundig", ["M53", "M54"]).replace("EC0S", "EB0S");
    let ran = Shop::new().file("m.toml", text).run(["machine", "check", "m.toml"]);
    assert!(ran.stderr.contains("EB0S is a rotation of the spindle about its own axis"), "{}", ran.stderr);
}

/// A transformation places the tip of the active head, also where the output resolves it.
#[test]
fn a_five_axis_transformation_is_that_of_the_head() {
    const SPINDLE: &str = "[spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";
    let huron = std::fs::read_to_string(repository("samples/machines/esmaeili_huron.toml")).unwrap();
    let own = "origin_mm = [3, -4, 150]\n";
    assert!(huron.contains(SPINDLE) && huron.contains("EX0S = -2.1") && huron.contains("EY0S = 55.6"));
    let one = huron.replace(SPINDLE, &format!("[[opaque]]\nname = \"M82\"\n[spindle]\n{own}"));
    let common = huron.replace(SPINDLE, "").replace("EX0S = -2.1", "#").replace("EY0S = 55.6", "#");
    let both = format!(
        "{common}\n[[head]]\nname = \"a\"\nselect = [\"M81\"]\nstart = true\norigin_mm = [-80, 20, -55]\n[head.location]\nEX0S = 100\n\
         [[head]]\nname = \"b\"\nselect = [\"M82\"]\n{own}[head.location]\nEX0S = -2.1\nEY0S = 55.6\n"
    );
    let program = std::fs::read_to_string(repository("samples/programs/sinumerik/swarf.mpf")).unwrap();
    let (before, rest) = program.split_once("N20 ").unwrap();
    let shop = Shop::new()
        .file("one.toml", one)
        .file("both.toml", both)
        .file("p.mpf", format!("{before}M82\nN20 {rest}"))
        .file("alone.mpf", &program);
    let sinumerik = &DIALECTS[1];
    for more in [&[][..], &["--five-axis", "axes"], &["--rotary", "correct"]] {
        let [found, expected] = ["both.toml", "one.toml"].map(|machine| corrected(&shop, sinumerik, machine, more));
        assert_eq!(found, expected, "{more:?}");
    }
    let flat = |machine: &str| {
        let text = shop.run(["snc", "p.mpf", "--machine", machine]).exits(0).stdout;
        text.split_once('\n').unwrap().1.to_owned()
    };
    assert_eq!(flat("both.toml"), flat("one.toml"));
    // With the other head the axes stand elsewhere.
    let other = shop.run(["snc", "alone.mpf", "--machine", "both.toml"]).exits(0).stdout;
    let moves = |text: &str| text.lines().filter(|line| line.starts_with('G')).map(str::to_owned).collect::<Vec<_>>();
    assert_ne!(moves(&other), moves(&flat("one.toml")));
}

/// Displacements of the tip with two lengths of the tool along Y.
fn plan() -> String {
    let mut text = "X,Y,Z,B,tool_y_mm\n".to_owned();
    for tool_mm in [-80, -180] {
        for x in [20, 340, 680] {
            for y in [30, 250, 480] {
                text += &format!("{x},{y},0,0,{tool_mm}\n{x},{y},300,0,{tool_mm}\n");
            }
        }
    }
    text
}

/// Readings of one head are fitted to the errors of this head, and written into its section: those of the other head and of the machine stay.
#[test]
fn a_calibration_writes_into_its_head() {
    let dialect = &DIALECTS[0];
    let truth = both("grundig", dialect.words);
    let start = truth.replace("EZ0S = -8.0\nEC0S = 30.0\n", "EZ0S = 0.0\n");
    let shop = Shop::new()
        .file("truth.toml", &truth)
        .file("start.toml", &start)
        .file("plan.csv", plan())
        .file("plan.toml", "[measurement]\nkind = \"displacement\"\nfree = []\n");
    let simulate = ["simulate", "plan.csv", "--noise", "0.1um", "-o", "data.csv"];
    shop.run(simulate.iter().chain(&["--machine", "truth.toml", "--head", "vertical"])).exits(0);
    let fit = ["calibrate", "data.csv", "--machine", "start.toml", "--model", "EC0S", "-o", "new.toml"];
    let refused = shop.run(fit).exits(2);
    assert!(refused.stderr.contains("choose it with --head"), "{}", refused.stderr);
    shop.run(fit.iter().chain(&["--head", "vertical"])).exits(0);
    let text = shop.text("new.toml");
    let (common, vertical) = text.split_once("name = \"vertical\"").unwrap();
    let value_of = |part: &str| part.lines().find_map(|line| line.strip_prefix("EC0S = ")?.parse::<f64>().ok());
    let value = value_of(vertical).unwrap();
    // 0.1 µm of noise over levers of 80 to 180 mm in 36 readings.
    assert!((value - 30.0).abs() < 0.5, "{value}");
    assert_eq!(value_of(common), None, "{common}");
    assert!(common.contains("EX0S = 5.0") && common.contains("EA0S = 20.0"), "{common}");
    // A description that names the head is compared with the run.
    let description = shop.text("data.toml").replace("[measurement]\n", "[measurement]\nhead = \"vertical\"\n");
    let shop = shop.file("data.toml", description);
    let ran = shop.run(fit.iter().chain(&["--head", "horizontal"]));
    assert!(
        ran.stderr.contains("were taken with the head vertical, and this run is for the head horizontal"),
        "{}",
        ran.stderr
    );
}
