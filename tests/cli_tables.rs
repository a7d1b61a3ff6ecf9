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
    run.exits(4).says("E0902").says("no scheme leaves");
    shop.run(["tables", "--machine", "mill.toml", "--format", "cec", "--scheme", "best", "-o", "CEC.INI"]).exits(2);
    shop.run(["tables", "--machine", "mill.toml", "--format", "cec"]).exits(2).says("give -o");
    shop.run(["tables", "--read", "part.mpf"]).exits(2).says("give --format");
    shop.run(["tables", "--machine", "mill.toml", "--format", "cec", "--range", "X=-5..10", "-o", "CEC.INI"]).exits(2);
    assert_eq!(shop.names(), ["mill.toml", "part.mpf"]);
}

#[test]
fn a_table_file_with_surplus_is_read_with_a_warning() {
    let text = "%_N_NC_CEC_INI\nCHANDATA(1)\n$AN_CEC[0,0]=0\n$AN_CEC[0,1]=0.01\n$AN_CEC[0,2]=0.5\n$AN_CEC_INPUT_AXIS[0]=(AX2)\n\
                $AN_CEC_OUTPUT_AXIS[0]=(AX3)\n$AN_CEC_STEP[0]=100\n$AN_CEC_MIN[0]=0\n$AN_CEC_MAX[0]=100\nM17\n";
    let shop = Shop::new().file("CEC.INI", text);
    let run = shop.run(["tables", "--read", "CEC.INI", "--json"]).exits(0);
    assert_eq!(run.codes(), ["W0901"]);
}

#[test]
fn the_lists_name_everything() {
    let run = Shop::new().run(["tables", "--list"]).exits(0);
    for format in ncfix::tables::FORMATS {
        assert!(run.stdout.contains(format.name), "{}", format.name);
    }
    for scheme in ncfix::tables::SCHEMES {
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
