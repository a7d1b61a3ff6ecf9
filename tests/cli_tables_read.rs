//! `ncfix tables --read`: files of controls with tables of several kinds, in several readings, damaged.

use crate::archives::archive;
use crate::support::{Shop, repository};

/// A machine without errors, wide enough for the samples.
const WIDE: &str = "[machine]\nname = \"wide\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-1000, 1000]\n\
    [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-1000, 1000]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-1000, 1000]\n\
    [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";

fn sample(name: &str) -> Vec<u8> {
    std::fs::read(repository(&format!("samples/tables/{name}"))).unwrap()
}

/// The machine with a line in `[machine]`.
fn with(line: &str) -> String {
    WIDE.replace("controller", &format!("{line}\ncontroller"))
}

/// A table of X over Y or Z with two values at 0 and 400 mm.
fn table(number: usize, input: &str, values: [f64; 2], factor: usize) -> String {
    format!(
        "$AN_CEC[{number},0]={}\n$AN_CEC[{number},1]={}\n$AN_CEC_INPUT_AXIS[{number}]={input}\n$AN_CEC_OUTPUT_AXIS[{number}]=X1\n\
         $AN_CEC_STEP[{number}]=400\n$AN_CEC_MIN[{number}]=0\n$AN_CEC_MAX[{number}]=400\n$AN_CEC_DIRECTION[{number}]=0\n\
         $AN_CEC_MULT_BY_TABLE[{number}]={factor}\n$AN_CEC_IS_MODULO[{number}]=0\n",
        values[0], values[1]
    )
}

/// Sag of Z over Y (0.004 mm at Y-605) and a leadscrew table of X (-0.010 mm at X200) in one archive: both count.
#[test]
fn an_archive_gives_the_tables_of_all_its_members() {
    let shop = Shop::new()
        .file("SAVE.ARC", sample("archive.arc"))
        .file("active.toml", with("active_tables = [\"SAVE.ARC\"]"))
        .file("part.mpf", "N10 G90 G94 G53 G1 X200 Y-605 Z50 F1000\nN30 M30\n");
    let read = shop.run(["tables", "--read", "SAVE.ARC", "--json"]).exits(0).json();
    assert_eq!((read["tables"].as_u64(), read["format"].as_str()), (Some(2), Some("cec, enc")), "{read}");
    shop.run(["part.mpf", "-o", "out.mpf", "--machine", "active.toml"]).exits(0);
    let text = shop.text("out.mpf");
    assert!(text.contains("X200.01") && text.contains("Z49.996"), "{text}");
    // Without the member headers it is one list with both.
    let list: Vec<u8> = sample("archive.arc").split(|&byte| byte == b'\n').skip(8).collect::<Vec<_>>().join(&b'\n');
    let shop = shop.file("LIST.INI", String::from_utf8_lossy(&list).replace("%_N_AX_EEC_INI", ";"));
    let both = shop.run(["tables", "--read", "LIST.INI", "--json"]).exits(0).json();
    assert_eq!(both["tables"].as_u64(), Some(2), "{both}");
    // One kind only where it is asked for, and never silently.
    for format in ["cec", "enc"] {
        let one = shop.run(["tables", "--read", "SAVE.ARC", "--format", format]).exits(0);
        one.says("W0901").says("which are ignored");
    }
    // A fault in either forbids both.
    let damaged =
        String::from_utf8_lossy(&sample("archive.arc")).replace("ENC_COMP[1,1,AX1]=0.01", "ENC_COMP[1,1,AX1]=x");
    let shop = shop.file("SAVE.ARC", damaged);
    shop.run(["part.mpf", "-o", "again.mpf", "--machine", "active.toml"]).exits(4).says("E0901");
}

/// The archive of a control with a folder: tables of any ending are read, a program that sets some is told.
#[test]
fn an_archive_with_folders_gives_all_tables() {
    let sag = table(0, "Y1", [0.0, 0.01], 0) + "M17\n";
    let screw = "$AA_ENC_COMP[0,0,AX1]=0\n$AA_ENC_COMP[0,1,AX1]=0.01\n$AA_ENC_COMP_STEP[0,AX1]=100\n\
                 $AA_ENC_COMP_MIN[0,AX1]=0\n$AA_ENC_COMP_MAX[0,AX1]=100\n$AA_ENC_COMP_IS_MODULO[0,AX1]=0\nM17\n";
    let files = [("NC_CEC.INI", "DATA.DIR", sag.as_str()), ("AX1.EEC", "DATA.DIR", screw)];
    let loader = ("LOAD.MPF", "MPF.DIR", "N10 $AN_CEC[0,0]=0.1\nN20 M30\n");
    let shop = Shop::new().file("A.ARC", archive(&files)).file("B.ARC", archive(&[files[0], files[1], loader]));
    for (name, codes) in [("A.ARC", vec![]), ("B.ARC", vec!["W0901"])] {
        let run = shop.run(["tables", "--read", name, "--json"]).exits(0);
        assert_eq!(
            (run.json()["tables"].as_u64(), run.codes()),
            (Some(2), codes.into_iter().map(str::to_owned).collect())
        );
    }
}

#[test]
fn limits_hold_for_every_format_of_a_set() {
    let shop = Shop::new().file("SAG.INI", table(0, "Y1", [0.0, 0.01], 0) + "M17\n");
    let shop = shop.file("x.comp", "0 80 80\n400 80 80\n# COMP_FILE_TYPE = 1\n").file("wide.toml", WIDE);
    let run = shop.run(["tables", "--read", "SAG.INI", "x.comp", "--machine", "wide.toml", "--check"]);
    run.exits(4).says("E0901").says("plausible errors of an axis are at most");
}

/// X over Y times X over Z: at Y200 Z200 the own value is 0.05 mm, the factor 0.1 mm, the product 0.005 mm.
#[test]
fn products_are_read_as_the_control_reads_them() {
    let text = table(0, "Y1", [0.0, 0.1], 2) + &table(1, "Z1", [0.0, 0.2], 0);
    let marked = |reading: &str| format!("; products of tables count {reading} the own value\n{text}M17\n");
    let shop = Shop::new()
        .file("NONE.INI", format!("{text}M17\n"))
        .file("INSTEAD.INI", marked("instead of"))
        .file("BESIDE.INI", marked("beside"))
        .file("part.mpf", "N10 G90 G94 G53 G1 X100 Y200 Z200 F1000\nN30 M30\n");
    let x_of = |file: &str, key: &str, code: &str| -> String {
        let shop = shop_with(&shop, "m.toml", &with(&format!("active_tables = [\"{file}\"]\n{key}")));
        let run = shop.run(["part.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
        assert_eq!(run.stderr.contains("W090"), !code.is_empty(), "{}", run.stderr);
        assert!(run.stderr.contains(code), "{}", run.stderr);
        let text = shop.text("out.mpf");
        text.split_whitespace().find(|word| word.starts_with('X')).unwrap_or_default().to_owned()
    };
    // Instead: 0.005 and the factor's own 0.1; beside: 0.05 more.
    let (instead, beside) = ("X99.895", "X99.845");
    assert_eq!(x_of("INSTEAD.INI", "", ""), instead);
    assert_eq!(x_of("BESIDE.INI", "", ""), beside);
    assert_eq!(x_of("NONE.INI", "", "W0902"), instead);
    assert_eq!(x_of("NONE.INI", "table_multiplication = \"beside\"", ""), beside);
    assert_eq!(x_of("INSTEAD.INI", "table_multiplication = \"beside\"", "W0901"), beside);
    let wrong = shop_with(&shop, "m.toml", &with("table_multiplication = \"twice\""));
    wrong.run(["part.mpf", "-o", "no.mpf", "--machine", "m.toml"]).exits(4).says("is not 'instead' or 'beside'");
    // What is read beside and what is read instead differ by the own value: 0 to 0.1 mm over Y.
    let both = ["tables", "--read", "INSTEAD.INI", "--compare", "BESIDE.INI", "--json"];
    let most = shop.run(both).exits(0).json()["difference"][0]["max"].as_f64().unwrap();
    assert!((98.0..=100.0).contains(&most), "{most}");
    let same = ["tables", "--read", "INSTEAD.INI", "--compare", "BESIDE.INI", "--multiplication", "beside", "--json"];
    assert_eq!(shop.run(same).exits(0).json()["difference"][0]["max"], 0.0);
    let others = table(2, "Y1", [0.0, 0.1], 4) + &table(3, "Z1", [0.0, 0.2], 0);
    let shop = shop.file("OTHERS.INI", format!("; products of tables count beside the own value\n{others}M17\n"));
    shop.run(["tables", "--read", "INSTEAD.INI", "OTHERS.INI"]).exits(4).says("E0901").says("another --multiplication");
}

/// The same shop with another file.
fn shop_with(shop: &Shop, name: &str, text: &str) -> Shop {
    let names = shop.names();
    names.iter().fold(Shop::new(), |other, name| other.file(name, shop.text(name))).file(name, text)
}

#[test]
fn tables_of_axes_that_the_machine_lacks_are_refused() {
    let shop = Shop::new().file("CEC.INI", table(0, "B1", [0.0, 0.01], 0) + "M17\n").file("wide.toml", WIDE);
    shop.run(["tables", "--read", "CEC.INI"]).exits(0);
    let run = shop.run(["tables", "--read", "CEC.INI", "--machine", "wide.toml"]).exits(4);
    run.says("E0901").says("axis B, which the machine does not have");
    let shop = shop.file("active.toml", with("active_tables = [\"CEC.INI\"]")).file("part.mpf", "N30 M30\n");
    shop.run(["part.mpf", "-o", "out.mpf", "--machine", "active.toml"]).exits(4).says("E0901");
}

/// A blank cell holds the value of the row before: the sample of the documents is read from the command line too.
#[test]
fn blank_cells_are_read() {
    let shop = Shop::new().file("axis-y.com", sample("axis-y.com")).file("wide.toml", WIDE);
    let read = shop.run(["tables", "--read", "axis-y.com", "--json"]).exits(0).json();
    assert_eq!(read["tables"].as_u64(), Some(3), "{read}");
    shop.run(["tables", "--read", "axis-y.com", "--machine", "wide.toml", "--check"]).exits(0);
    shop.run(["tables", "--read", "axis-y.com", "--format", "cec", "-o", "CEC.INI"]).exits(0);
}

#[test]
fn values_that_no_machine_is_off_by() {
    for (name, text, what) in [
        ("v.csv", "A0Z\n0.2\n", "degrees"),
        ("v.csv", "X EXX\n0 0\n9 12\n", "mm"),
        ("v.csv", "X EAX\n0 0\n9 0.1\n", "degrees"),
        ("v.csv", "X0Z\n-11\n", "mm"),
        ("g.txt", "S1 P0 T1=0 T2=0 T3=0 R1=20000 R2=0 R3=0\nS1 P9 T1=0 T2=0 T3=0 R1=0 R2=0 R3=0\n", "degrees"),
        ("g.txt", "S1 P0 T1=20000 T2=0 T3=0 R1=0 R2=0 R3=0\nS1 P9 T1=0 T2=0 T3=0 R1=0 R2=0 R3=0\n", "mm"),
        ("m.hal", "setp matrixkins.C_xy 0.05\n", "per meter"),
        ("m.hal", "setp matrixkins.C_xx 25.4\n", "per meter"),
    ] {
        let shop = Shop::new().file(name, text).file("wide.toml", WIDE);
        shop.run(["tables", "--read", name, "--machine", "wide.toml", "--check"]).exits(4).says("E0901").says(what);
    }
}

#[test]
fn a_leadscrew_list_with_points_twice_or_too_many() {
    let list = "kopf.log_achs_name X\nkw.ssfk.interval 10000\nkw.ssfk.kw_startpos 0\nkw.ssfk.kw_nr_max 2\nkw.ssfk.unit 1\n\
                kw.ssfk.bilateral 0\nkw.ssfk.table[0].pos 10\nkw.ssfk.table[1].pos 30\n";
    let read = |more: &str| Shop::new().file("x.lis", format!("{list}{more}")).run(["tables", "--read", "x.lis"]);
    read("").exits(0);
    read("kw.ssfk.table[1].pos 30\n").exits(0);
    read("kw.ssfk.table[1].pos 31\n").exits(4).says("E0901").says("twice");
    read("kw.ssfk.table[2].pos 9\n").exits(0).says("W0901").says("1 entries are beyond");
}

/// At X100 the scale of 40 µm/m is 4 µm; the table adds -0.1 mm/m · 100 mm = -10 µm: each has its own row.
#[test]
fn a_pose_shows_tables_in_a_row_of_their_own() {
    let errors = "[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 4e-5]\n";
    let shop = Shop::new()
        .file("CEC.INI", table(0, "X1", [0.0, -0.04], 0) + "M17\n")
        .file("m.toml", with("active_tables = [\"CEC.INI\"]") + errors);
    let shown = shop.run(["machine", "show", "m.toml", "--at", "X100", "--json"]).exits(0).json();
    let x = |source: &str| -> f64 {
        let sources = shown["sources"].as_array().unwrap();
        let share = sources.iter().find(|share| share["source"] == source).unwrap_or_else(|| panic!("{shown}"));
        share["deviation"]["position_um"][0].as_f64().unwrap()
    };
    let motion = shown["sources"][0]["source"].as_str().unwrap().to_owned();
    assert!((x(&motion) - 4.0).abs() < 1e-3 && (x("tables") + 10.0).abs() < 1e-2, "{shown}");
    assert!((shown["sum"]["position_um"][0].as_f64().unwrap() + 6.0).abs() < 1e-2, "{shown}");
}

/// Esmaeili 2021, Fig. 5.10: the functions of two sets over one axis are in one picture, each with its own line and name.
#[test]
fn two_sets_of_tables_are_drawn_in_one_picture() {
    let set = |value: f64| format!("{}M17\n", table(0, "X1", [0.0, value], 0));
    let shop = Shop::new().file("ONE.INI", set(0.01)).file("TWO.INI", set(-0.02));
    shop.run(["tables", "--read", "ONE.INI", "--compare", "TWO.INI", "--svg", "both.svg"]).exits(0);
    let picture = shop.text("both.svg");
    roxmltree::Document::parse(&picture).unwrap();
    assert_eq!((picture.matches(">first table 1<").count(), picture.matches(">second table 1<").count()), (1, 1));
    assert_eq!(picture.matches("added to ").count(), 1, "two charts instead of one");
}

/// Esmaeili 2021, 4.6. X over Y, 0 to 0.04 mm over 400 mm: the program gets at Y200 what a control would add, 0.02 mm.
#[test]
fn tables_that_no_control_uses_are_added_to_programs() {
    let set = format!("{}M17\n", table(0, "Y1", [0.0, 0.04], 0));
    let part = "N10 G90 G94 G53 G1 X100 Y200 Z200 F1000\nN30 M30\n";
    let shop = Shop::new().file("CEC.INI", set).file("part.mpf", part);
    let x_of = |key: &str| -> String {
        let shop = shop_with(&shop, "m.toml", &with(&format!("{key} = [\"CEC.INI\"]")));
        shop.run(["part.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
        let text = shop.text("out.mpf");
        text.split_whitespace().find(|word| word.starts_with('X')).unwrap_or_default().to_owned()
    };
    assert_eq!(x_of("offline_tables"), "X100.02");
    // A control that adds it itself gets 0.02 mm less.
    assert_eq!(x_of("active_tables"), "X99.98");
    let shop = shop_with(&shop, "m.toml", &with("offline_tables = [\"CEC.INI\"]"));
    let shown = shop.run(["machine", "show", "m.toml"]).exits(0).stdout;
    assert!(shown.contains("added to programs: CEC.INI"), "{shown}");
    // The tables remove all of these errors: 0 to 40 µm evenly over Y 0 to 400, held at 0 below and at 40 µm above, RMS over the travel.
    let made = shop.run(["tables", "--read", "CEC.INI", "--machine", "m.toml", "--check", "--json"]).exits(0).json();
    let check = &made["check"];
    let [before, left] = ["before", "tables"].map(|one| check[one]["rms_um"].as_f64().unwrap());
    // Of 2000 mm, 400 mm have the mean square 1600/3 and 600 mm have 1600 µm².
    let rms = (0.2 * 1600.0 / 3.0 + 0.3 * 1600.0_f64).sqrt();
    assert!((before / rms - 1.0).abs() < 0.05 && left < 1e-3, "{before} {rms} {left}");
}

/// A reading of X100 at Y200 where the command would get 0.02 mm more: the tool is 0.02 mm short of what the scale says.
#[test]
fn tables_that_no_control_uses_are_subtracted_from_readings() {
    let set = format!("{}M17\n", table(0, "Y1", [0.0, 0.04], 0));
    let shop = Shop::new().file("CEC.INI", set).file("m.toml", with("offline_tables = [\"CEC.INI\"]"));
    let shop = shop.file("read.csv", "X,Y,Z\n100,200,200\n-50,100,0\n");
    shop.run(["correct-readings", "read.csv", "-o", "true.csv", "--machine", "m.toml"]).exits(0);
    let text = shop.text("true.csv");
    let x: Vec<f64> = text.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
    // Eq. 33: what was read minus the value of the table, at Y100 0.01 mm.
    assert!((x[0] - 99.98).abs() < 2e-6 && (x[1] + 50.01).abs() < 2e-6, "{text}");
}

#[test]
fn offline_tables_stand_alone() {
    let set = format!("{}M17\n", table(0, "Y1", [0.0, 0.04], 0));
    let part = "N10 G90 G94 G53 G1 X100 Y200 Z200 F1000\nN30 M30\n";
    let shop = Shop::new().file("CEC.INI", set).file("part.mpf", part);
    for (line, more, code) in [
        ("offline_tables = [\"CEC.INI\"]", "[location]\nEC0Y = 20\n", "E0902"),
        ("offline_tables = [\"CEC.INI\"]\nactive_tables = [\"CEC.INI\"]", "", "exclude each other"),
        ("offline_tables = [\"NONE.INI\"]", "", "NONE.INI"),
    ] {
        let shop = shop_with(&shop, "m.toml", &(with(line) + more));
        let run = shop.run(["part.mpf", "-o", "out.mpf", "--machine", "m.toml"]);
        assert!(run.stderr.contains(code) && !shop.names().contains(&"out.mpf".to_owned()), "{}", run.stderr);
    }
}
