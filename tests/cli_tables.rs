//! `ncfix tables` as a person uses it, and programs on a machine whose control has active tables.

use crate::support::{Shop, machine};

/// Squareness of Y and a scale of X: at X100 Y200 Z50 the tip is off by −EC0Y·Y in X and by EXX1·X.
const MILL: &str = "[machine]\nname = \"mill\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 500]\n\
    [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 300]\n\
    [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";
const ERRORS: &str = "[location]\nEC0Y = 100\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 4e-5]\n";
const PROGRAM: &str = "N10 G90 G94 G53 G1 X100 Y200 Z50 F1000\nN20 G53 G1 X150 Y200 Z50\nN30 M30\n";

fn shop() -> Shop {
    Shop::new().file("mill.toml", format!("{MILL}{ERRORS}")).file("part.mpf", PROGRAM)
}

fn make<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let first = ["tables", "--machine", "mill.toml", "--format", "cec", "--scheme", "fik", "-o", "CEC.INI"];
    first.into_iter().chain(more.iter().copied()).collect()
}

#[test]
fn tables_are_made_checked_written_and_read_again() {
    let shop = shop();
    let made = shop.run(make(&["--check", "--json", "--svg", "tables.svg"])).exits(0).json();
    // The squareness tilts Y: −100 µrad · Y in X, a straight table of X over Y; the scale is one of X over X.
    assert_eq!((made["tables"].as_u64(), made["rows"][0]["output"].as_str()), (Some(2), Some("X")), "{made}");
    assert!(made["check"]["before"]["rms_um"].as_f64().unwrap() > 15.0);
    assert!(made["check"]["tables"]["max_um"].as_f64().unwrap() < 0.02, "{made}");
    assert_eq!(made["written"].as_array().unwrap().len(), 2);
    roxmltree::Document::parse(&shop.text("tables.svg")).unwrap();
    let text = shop.text("CEC.INI");
    assert!(text.starts_with("%_N_NC_CEC_INI\n; ncfix ") && text.ends_with("M17\n"), "{text}");
    let read = shop.run(["tables", "--read", "CEC.INI", "--machine", "mill.toml", "--check", "--json"]).exits(0).json();
    assert_eq!(read["check"]["tables"], made["check"]["tables"]);
    let same = shop.run(["tables", "--read", "CEC.INI", "--compare", "CEC.INI", "--json"]).exits(0).json();
    assert!(same["difference"].as_array().unwrap().iter().all(|one| one["max"] == 0.0), "{same}");
    // Written again from what was read: the same tables.
    shop.run(["tables", "--read", "CEC.INI", "--format", "cec", "-o", "AGAIN.INI"]).exits(0);
    let values = |name: &str| -> Vec<String> {
        shop.text(name).lines().filter(|line| line.starts_with('$')).map(str::to_owned).collect()
    };
    assert_eq!(values("AGAIN.INI"), values("CEC.INI"));
}

#[test]
fn values_are_those_of_independent_arithmetic() {
    let shop = shop();
    shop.run(make(&["--points", "5"])).exits(0);
    let text = shop.text("CEC.INI");
    // X over X: −4e-5 · X to the first order, at 500 mm −20 µm; X over Y: +100 µrad · Y, at 400 mm 40 µm.
    let value = |name: &str| -> f64 {
        let line = text.lines().find_map(|line| line.strip_prefix(&format!("{name}="))).unwrap();
        line.parse().unwrap()
    };
    assert!((value("$AN_CEC[0,4]") + 0.020).abs() < 2e-6, "{text}");
    assert!((value("$AN_CEC[1,4]") - 0.040).abs() < 2e-6, "{text}");
    assert!(text.contains("$AN_CEC_INPUT_AXIS[1]=(AX2)\n$AN_CEC_OUTPUT_AXIS[1]=(AX1)"), "{text}");
}

/// A program is corrected for what the tables leave: nothing here; and for everything where they are not active.
#[test]
fn what_active_tables_do_is_not_corrected_twice() {
    let active = MILL.replace("controller", "active_tables = [\"CEC.INI\"]\ncontroller");
    let shop = shop().file("active.toml", format!("{active}{ERRORS}"));
    shop.run(make(&[])).exits(0);
    let line = |machine: &str| -> String {
        shop.run(["part.mpf", "-o", "out.mpf", "--machine", machine]).exits(0);
        shop.text("out.mpf")
            .lines()
            .find(|line| line.starts_with("N20") || line.contains("X150"))
            .unwrap_or("")
            .to_owned()
    };
    let corrected = shop.run(["part.mpf", "-o", "out.mpf", "--machine", "mill.toml", "--json"]).exits(0).json();
    assert!(corrected.to_string().contains("max"), "{corrected}");
    assert!(!line("mill.toml").contains("X150 "), "{}", line("mill.toml"));
    assert!(line("active.toml").contains("X150"), "{}", line("active.toml"));
    // Without an error of its own the program must undo what the tables add.
    let shop = shop.file("good.toml", active);
    shop.run(["part.mpf", "-o", "out.mpf", "--machine", "good.toml"]).exits(0);
    // At X150 Y200 the tables add −6 + 20 µm in X.
    assert!(shop.text("out.mpf").contains("X149.986"), "{}", shop.text("out.mpf"));
    let shown = shop.run(["machine", "show", "active.toml"]).exits(0).stdout;
    assert!(shown.contains("active in the control: CEC.INI"), "{shown}");
}

/// Scales of 40, 20 and 10 µm/m, and a control with one table: X, the best one, is corrected there. The program has the rest: at X500 Y400 Z300
/// −8 µm in Y and −3 µm in Z, and nothing of the 20 µm in X.
#[test]
fn few_tables_take_the_largest_errors_and_the_program_the_rest() {
    let scale = |component: &str, slope: &str| {
        format!("[[motion]]\ncomponent = \"{component}\"\nkind = \"polynomial\"\ncoefficients = [0, {slope}]\n")
    };
    let errors = [("EXX", "4e-5"), ("EYY", "2e-5"), ("EZZ", "1e-5")].map(|(name, slope)| scale(name, slope)).concat();
    let active = MILL.replace("controller", "active_tables = [\"CEC.INI\"]\ncontroller");
    let shop = Shop::new()
        .file("mill.toml", format!("{MILL}{errors}"))
        .file("active.toml", format!("{active}{errors}"))
        .file("part.mpf", "N10 G90 G94 G53 G1 X500 Y400 Z300 F1000\nN20 M30\n");
    let made = shop.run(make(&["--most", "1", "--json"])).exits(0).json();
    assert_eq!((&made["tables"], &made["rows"][0]["input"]), (&1.into(), &"X".into()), "{made}");
    let corrected = |machine: &str| {
        shop.run(["part.mpf", "-o", "out.mpf", "--machine", machine]).exits(0);
        shop.text("out.mpf")
    };
    let whole = corrected("mill.toml");
    assert!(["X499.98", "Y399.992", "Z299.997"].iter().all(|word| whole.contains(word)), "{whole}");
    let rest = corrected("active.toml");
    assert!(["X500", "Y399.992", "Z299.997"].iter().all(|word| rest.contains(word)), "{rest}");
    assert!(!rest.contains("X499"), "{rest}");
}

#[test]
fn active_tables_that_cannot_be_read_forbid_the_program() {
    let active = MILL.replace("controller", "active_tables = [\"CEC.INI\"]\ncontroller");
    let shop = shop().file("active.toml", active).file("CEC.INI", "$AN_CEC[0,0]=oops\n");
    let run = shop.run(["part.mpf", "-o", "out.mpf", "--machine", "active.toml"]).exits(4);
    run.says("E0901").says("CEC.INI:1");
    assert!(!shop.names().contains(&"out.mpf".to_owned()));
}

#[test]
fn what_does_not_fit_is_refused_and_nothing_is_written() {
    let shop = shop();
    let run = shop.run(["tables", "--machine", "mill.toml", "--format", "enc", "--scheme", "fik", "-o", "EEC.INI"]);
    run.exits(4).says("E0902");
    let run =
        shop.run(["tables", "--machine", "mill.toml", "--format", "cec", "--tolerance", "0.000001um", "-o", "CEC.INI"]);
    run.exits(4).says("E0902").says("no scheme reaches");
    shop.run(["tables", "--machine", "mill.toml", "--format", "cec", "--scheme", "best", "-o", "CEC.INI"]).exits(2);
    shop.run(["tables", "--machine", "mill.toml", "--format", "cec"]).exits(2).says("give -o");
    shop.run(["tables", "--read", "part.mpf"]).exits(2).says("give --format");
    shop.run(["tables", "--machine", "mill.toml", "--format", "cec", "--range", "X=-5..10", "-o", "CEC.INI"]).exits(2);
    assert_eq!(shop.names(), ["mill.toml", "part.mpf"]);
}

#[test]
fn a_table_file_with_surplus_is_read_with_a_warning() {
    let text = "%_N_NC_CEC_INI\nCHANDATA(1)\n$AN_CEC[0,0]=0\n$AN_CEC[0,1]=0.01\n$AN_CEC[0,2]=0.5\n$AN_CEC_INPUT_AXIS[0]=(AX2)\n\
                $AN_CEC_OUTPUT_AXIS[0]=(AX3)\n$AN_CEC_STEP[0]=100\n$AN_CEC_MIN[0]=0\n$AN_CEC_MAX[0]=100\n$AN_CEC_DIRECTION[0]=0\n\
                $AN_CEC_MULT_BY_TABLE[0]=0\n$AN_CEC_IS_MODULO[0]=0\nM17\n";
    let shop = Shop::new().file("CEC.INI", text);
    let run = shop.run(["tables", "--read", "CEC.INI", "--json"]).exits(0);
    assert_eq!(run.codes(), ["W0901"]);
}

#[test]
fn the_lists_name_everything() {
    let run = Shop::new().run(["tables", "--list"]).exits(0);
    for format in ncfix_tables::tables::FORMATS {
        assert!(run.stdout.contains(format.name), "{}", format.name);
    }
    for scheme in ncfix_tables::tables::SCHEMES {
        assert!(run.stdout.contains(scheme.name), "{}", scheme.name);
    }
}

#[test]
fn the_45_degree_machine_from_the_command_line() {
    let shop = Shop::new();
    let huron = machine("esmaeili_huron");
    let made = shop
        .run([
            "tables",
            "--machine",
            &huron,
            "--format",
            "cec",
            "--scheme",
            "auto",
            "--tool",
            "150",
            "-o",
            "CEC.INI",
            "--check",
            "--json",
        ])
        .exits(0)
        .json();
    assert!(made["check"]["tables"]["rms_um"].as_f64().unwrap() <= 1.0, "{made}");
    assert!(made["tables"].as_u64().unwrap() <= 40 && !made["tried"].as_array().unwrap().is_empty(), "{made}");
}

/// A table of an axis over another one with two values in mm, and further lines.
fn two_points(number: usize, values: [f64; 2], more: &str) -> String {
    format!(
        "$AN_CEC[{number},0]={}\n$AN_CEC[{number},1]={}\n$AN_CEC_INPUT_AXIS[{number}]=(AX2)\n$AN_CEC_OUTPUT_AXIS[{number}]=(AX3)\n\
         $AN_CEC_STEP[{number}]=400\n$AN_CEC_MIN[{number}]=0\n$AN_CEC_MAX[{number}]=400\n\
         $AN_CEC_DIRECTION[{number}]=0\n$AN_CEC_MULT_BY_TABLE[{number}]=0\n$AN_CEC_IS_MODULO[{number}]=0\n{more}\nM17\n",
        values[0], values[1]
    )
}

#[test]
fn tables_of_which_a_control_would_have_one_are_refused() {
    let active = |files: &str| {
        format!("{}{ERRORS}", MILL.replace("controller", &format!("active_tables = [{files}]\ncontroller")))
    };
    let shop = shop()
        .file("A.INI", two_points(0, [0.01, 0.02], ""))
        .file("B.INI", two_points(1, [0.01, 0.02], ""))
        .file("C.INI", two_points(1, [0.0, 0.05], ""))
        .file("same.toml", active("\"A.INI\", \"A.INI\""))
        .file("both.toml", active("\"B.INI\", \"C.INI\""))
        .file("sum.toml", active("\"A.INI\", \"C.INI\""));
    shop.run(["part.mpf", "-o", "out.mpf", "--machine", "same.toml"])
        .exits(4)
        .says("E0901")
        .says("this is A.INI again");
    shop.run(["part.mpf", "-o", "out.mpf", "--machine", "both.toml"]).exits(4).says("table 1 is also in B.INI");
    shop.run(["tables", "--read", "B.INI", "C.INI"]).exits(4).says("E0901");
    assert!(!shop.names().contains(&"out.mpf".to_owned()));
    // Tables of other numbers are added.
    shop.run(["part.mpf", "-o", "out.mpf", "--machine", "sum.toml"]).exits(0);
    let comp = "0 0 0\n400 0.01 0.01\n";
    let shop = shop.file("x.comp", comp).file("X.comp", "0 0 0\n400 0.02 0.02\n");
    shop.run(["tables", "--read", "x.comp", "X.comp"]).exits(4).says("E0901");
}

#[test]
fn values_that_no_axis_is_off_by_are_refused() {
    for (name, text) in [
        ("CEC.INI", two_points(0, [0.0, 55.0], "")),
        ("CEC.INI", two_points(0, [0.0, 1e308], "$SN_CEC_TABLE_WEIGHT[0]=10")),
        ("x.comp", "0 0 0\n400 800 800\n".to_owned()),
    ] {
        let shop = Shop::new().file(name, text).file("mill.toml", MILL);
        shop.run(["tables", "--read", name, "--machine", "mill.toml", "--check"]).exits(4).says("E0901");
    }
}

#[test]
fn a_file_without_tables_in_use_writes_nothing() {
    let text = "%_N_NC_CEC_INI\n$AN_CEC[0,0]=0\n$AN_CEC_STEP[0]=0\nM17\n";
    let shop = Shop::new().file("CEC.INI", text);
    let run = shop.run(["tables", "--read", "CEC.INI", "--format", "cec", "-o", "OUT.INI"]).exits(2);
    run.says("has no compensation table in use").says("W0901");
    assert_eq!(shop.names(), ["CEC.INI"]);
}

/// Lost motion of 6 µm in X: the tip is 3 µm to one side of the middle or the other. A machine checked in the middle would show nothing.
#[test]
fn a_check_reaches_its_poses_in_both_senses() {
    let backlash = "[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 6\n";
    let shop = Shop::new().file("mill.toml", format!("{MILL}{ERRORS}{backlash}"));
    let made = shop.run(make(&["--check", "--json"])).exits(0).json();
    let check = &made["check"];
    assert_eq!(check["senses"], serde_json::json!(["X"]), "{made}");
    assert!(check["tables"]["max_um"].as_f64().unwrap() < 0.05, "{made}");
    // The same tables but those for one sense leave half of it at every pose.
    let text = shop.text("CEC.INI");
    let senses = text.lines().filter(|line| line.contains("_DIRECTION[") && !line.ends_with("=0"));
    let numbers: Vec<String> = senses.map(|line| line.split(['[', ']']).nth(1).unwrap().to_owned()).collect();
    assert_eq!(numbers.len(), 2, "{text}");
    let is_off =
        |line: &str| numbers.iter().any(|n| line.contains(&format!("[{n},")) || line.contains(&format!("[{n}]")));
    let without: Vec<&str> = text.lines().filter(|line| !is_off(line)).collect();
    let shop = shop.file("FEWER.INI", without.join("\n"));
    let fewer = ["tables", "--read", "FEWER.INI", "--machine", "mill.toml", "--check", "--json"];
    let left = shop.run(fewer).exits(0).json()["check"]["tables"]["rms_um"].as_f64().unwrap();
    assert!((left - 3.0).abs() < 0.05, "{left}");
    let both = shop.run(["tables", "--read", "FEWER.INI", "--compare", "CEC.INI", "--machine", "mill.toml", "--json"]);
    let differs = both.exits(0).json()["difference"][0]["max"].as_f64().unwrap();
    assert!((differs - 3.0).abs() < 0.05, "{differs}");
}

#[test]
fn a_check_says_which_tool_it_is_for() {
    let shop = shop();
    shop.run(make(&["--tool", "120"])).exits(0);
    let other = shop.run(["tables", "--read", "CEC.INI", "--machine", "mill.toml", "--check"]).exits(0);
    assert!(other.stdout.contains("tool 0 0 0 mm") && other.stdout.contains("--tool 0,0,-120"), "{}", other.stdout);
    let own = ["tables", "--read", "CEC.INI", "--machine", "mill.toml", "--check", "--tool", "120"];
    assert!(!shop.run(own).exits(0).stdout.contains("another tool"));
}

/// A spindle or a loader between the axes has a number too, whether or not ncfix knows it.
#[test]
fn axes_have_the_numbers_of_the_control() {
    let order = MILL.replace("controller", "axis_order = [\"X\", \"A\", \"Z\"]\ncontroller");
    let shop = Shop::new().file("mill.toml", format!("{order}{ERRORS}"));
    shop.run(make(&[])).exits(0);
    // X over Y: AX1 over what comes behind X A Z.
    let text = shop.text("CEC.INI");
    assert!(text.contains("$AN_CEC_INPUT_AXIS[1]=(AX4)\n$AN_CEC_OUTPUT_AXIS[1]=(AX1)"), "{text}");
    // An axis that ncfix does not know has a number, too.
    let order = MILL.replace("controller", "axis_order = [\"-\", \"X\", \"-\", \"Y\", \"Z\"]\ncontroller");
    let shop = Shop::new().file("mill.toml", format!("{order}{ERRORS}"));
    shop.run(make(&[])).exits(0);
    let text = shop.text("CEC.INI");
    assert!(text.contains("$AN_CEC_INPUT_AXIS[1]=(AX4)\n$AN_CEC_OUTPUT_AXIS[1]=(AX2)"), "{text}");
    assert!(text.contains("; axes: X AX2, Y AX4\n"), "{text}");
}

/// With a rotary axis, a number that nobody stated is named; with names it is not.
#[test]
fn assumed_numbers_of_axes_are_named() {
    let turned = MILL.replace("wFXYZSt", "wCFXYZSt");
    let axis = "[axis.C]\ndirection = [0, 0, 1]\ntravel_deg = [-90, 90]\n[location]\nEC0Y = 100\n\
        [[motion]]\ncomponent = \"ECC\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n";
    let shop = Shop::new().file("mill.toml", format!("{turned}{axis}"));
    shop.run(make(&[])).exits(0).says("warning[W0903]").says("C AX4");
    assert!(shop.text("CEC.INI").contains("; axes (assumed): "), "{}", shop.text("CEC.INI"));
    let named = shop.run(make(&["--axis-name", "C=AX5"])).exits(0);
    assert!(!named.stderr.contains("W0903"), "{}", named.stderr);
}

/// A zero that was touched before the tables were active does not fit to them: 100 µrad of Y move X by 20 µm in the mean of 400 mm of Y, and
/// the scale of 40 µm/m by 10 µm in the mean of 500 mm of X.
#[test]
fn a_shift_of_all_positions_is_in_the_header() {
    let shop = shop();
    shop.run(make(&[])).exits(0);
    let text = shop.text("CEC.INI");
    let line =
        text.lines().find(|line| line.contains("touch off every zero again")).unwrap_or_else(|| panic!("{text}"));
    let x: f64 = line.split(" X ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    // The error before is −EC0Y·Y + EXX1·X = −20 + 10 µm in the mean; the tables take it away.
    assert!((x - 10.0).abs() < 1.5, "{line}");
}
