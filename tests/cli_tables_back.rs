//! Results back into controls: pitch errors, reversal values, and the errors that tables of a control state.

use crate::support::Shop;

/// A machine with the chain and the direction of Y.
fn mill(chain: &str, y: i8) -> String {
    format!(
        "[machine]\nname = \"mill\"\ntopology = \"{chain}\"\ncontroller = \"fanuc\"\n\
         [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 300]\n\
         [axis.Y]\ndirection = [0, {y}, 0]\ntravel_mm = [0, 200]\n\
         [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 100]\n\
         [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n"
    )
}

fn table(component: &str, positions: &str, values: &str) -> String {
    format!(
        "[[motion]]\ncomponent = \"{component}\"\nkind = \"table\"\npositions_mm = {positions}\nvalues_um = {values}\n"
    )
}

/// The numbers of a key of the machine file, for the entry of a component and kind.
fn numbers(text: &str, component: &str, kind: &str, key: &str) -> Vec<f64> {
    let value: toml::Table = text.parse().unwrap();
    let entries = value["motion"].as_array().unwrap();
    let is = |one: &&toml::Value| one["component"].as_str() == Some(component) && one["kind"].as_str() == Some(kind);
    let found = entries.iter().find(is).unwrap_or_else(|| panic!("{component} {kind}: {text}"));
    let number = |one: &toml::Value| one.as_float().unwrap_or_else(|| one.as_integer().unwrap() as f64);
    found[key].as_array().unwrap().iter().map(number).collect()
}

/// Errors of 0, 2.4, 3.1 and 2.2 µm need the corrections 0, −2.4, −3.1, −2.2; rounded to the detection unit of 1 µm these are 0, −2, −3, −2; so the
/// changes are −2, −1 and +1. The reference position is point 2, one section from the start.
#[test]
fn pitch_errors_are_changes_in_detection_units() {
    let errors = table("EXX", "[0, 100, 200, 300]", "[0.0, 2.4, 3.1, 2.2]");
    let shop = Shop::new().file("m.toml", mill("wFXYZSt", 1) + &errors);
    let make =
        ["tables", "--machine", "m.toml", "--format", "pitch", "--scheme", "own", "--points", "4", "-o", "P.csv"];
    shop.run(make.iter().copied().chain(["--check"])).exits(0);
    let text = shop.text("P.csv");
    for row in [
        "3620,X,2",
        "3621,X,2",
        "3622,X,5",
        "3623,X,1",
        "3624,X,100",
        "2,X,0,0",
        "3,X,100,-2",
        "4,X,200,-1",
        "5,X,300,1",
    ] {
        assert!(text.lines().any(|line| line == row), "{row}: {text}");
    }
    // Out and in: the machine that these values correct has the rounded errors.
    let shop = shop.file("bare.toml", mill("wFXYZSt", 1));
    let shown = shop.run(["tables", "--read", "P.csv", "--machine", "bare.toml", "-o", "back.toml"]).exits(0);
    assert!(shown.stdout.contains("1 error found from the tables"), "{}", shown.stdout);
    let back = shop.text("back.toml");
    assert_eq!(numbers(&back, "EXX", "table", "positions_mm"), [-100.0, 0.0, 100.0, 200.0, 300.0]);
    assert_eq!(numbers(&back, "EXX", "table", "values_um"), [0.0, 0.0, 2.0, 3.0, 2.0]);
}

/// A body that lags by 4.8 µm is 4.8 µm behind after a positive motion: its reversal value in the sense of ISO 230-2 is −4.8 µm, and the control adds
/// +4.8 µm.
#[test]
fn reversal_values_have_the_names_of_the_machine_data() {
    let play = "[[motion]]\ncomponent = \"EYY\"\nkind = \"backlash\"\nvalue_um = -4.8\n";
    let errors = table("EXX", "[0, 300]", "[0, 9]");
    let shop = Shop::new().file("m.toml", mill("wFXYZSt", 1) + &errors + play);
    let make = ["tables", "--machine", "m.toml", "--format", "enc", "--scheme", "own", "-o", "E.INI"];
    let run = shop.run(make).exits(0);
    for part in [
        "reversal value of Y: 0.00480 mm",
        "MD32450 $MA_BACKLASH[0,AX2] = 0.00480",
        "1851 and 1852 of Y = 5 detection units",
        "[JOINT_1] BACKLASH = 0.00480",
    ] {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
    let json = shop.run(make.iter().copied().chain(["--json"])).exits(0).json();
    assert!((json["reversals"][0]["value"].as_f64().unwrap() - 0.0048).abs() < 1e-9, "{json}");
    // A format with a table for each direction holds it: entering it too would correct it twice.
    let both = ["tables", "--machine", "m.toml", "--format", "comp", "--scheme", "own", "-o", "c.comp", "--json"];
    assert_eq!(shop.run(both).exits(0).json()["reversals"].as_array().unwrap().len(), 0);
    // Alone it needs no table, and is named all the same.
    let shop = shop.file("p.toml", mill("wFXYZSt", 1) + play);
    let alone = ["tables", "--machine", "p.toml", "--format", "enc", "--scheme", "own", "-o", "E.INI"];
    shop.run(alone).exits(4).says("E0902").says("MD32450 $MA_BACKLASH[0,AX2] = 0.00480");
}

/// A sag of the body of Y by −6 µm at Y 200 needs +6 µm of Z if both carry the tool. If Y carries the workpiece, its sag lowers the workpiece, and Z
/// must follow it down.
#[test]
fn the_errors_that_tables_state_have_the_sign_of_the_chain() {
    let cec = |value: f64| {
        format!(
            "$AN_CEC[0,0]=0\n$AN_CEC[0,1]={value}\n$AN_CEC_INPUT_AXIS[0]=AX2\n$AN_CEC_OUTPUT_AXIS[0]=AX3\n$AN_CEC_STEP[0]=200\n\
             $AN_CEC_MIN[0]=0\n$AN_CEC_MAX[0]=200\n$AN_CEC_DIRECTION[0]=0\n$AN_CEC_MULT_BY_TABLE[0]=0\n$AN_CEC_IS_MODULO[0]=0\nM17\n"
        )
    };
    for (chain, y, value_mm) in [("wFXYZSt", 1, 0.006), ("wYFXZSt", 1, -0.006), ("wYFXZSt", -1, -0.006)] {
        let shop = Shop::new().file("bare.toml", mill(chain, y)).file("CEC.INI", cec(value_mm));
        let run =
            shop.run(["tables", "--read", "CEC.INI", "--machine", "bare.toml", "-o", "back.toml", "--json"]).exits(0);
        let back = shop.text("back.toml");
        assert_eq!(numbers(&back, "EZY", "table", "values_um"), [0.0, -6.0], "{chain}");
        assert!(back.contains("active_tables") && back.contains("CEC.INI"), "{back}");
        let json = run.json();
        let [before, left] = ["before", "tables"].map(|key| json["check"][key]["rms_um"].as_f64().unwrap());
        // A straight line from 0 to 6 µm has the RMS 6/√3.
        assert!((before - 6.0 / 3.0_f64.sqrt()).abs() < 0.1 && left < 0.01, "{chain}: {before} {left}");
    }
    // X on the tool side against the sense of its letter: the command grows, and the body goes to −X.
    let shop = Shop::new()
        .file("bare.toml", mill("wFXYZSt", 1).replace("[1, 0, 0]", "[-1, 0, 0]"))
        .file("x.comp", "0 0 0\n300 0.005 0.003\n# axis X\n# COMP_FILE_TYPE = 1\n");
    let shown = shop.run(["tables", "--read", "x.comp", "--machine", "bare.toml", "-o", "back.toml"]).exits(0);
    assert!(shown.stdout.contains("2 errors found from the tables"), "{}", shown.stdout);
    let back = shop.text("back.toml");
    // The mean of 5 and 3 µm, and 5 − 3 µm; the sign of the direction.
    assert_eq!(numbers(&back, "EXX", "table", "values_um"), [0.0, 4.0]);
    assert_eq!(numbers(&back, "EXX", "backlash", "values_um"), [0.0, 2.0]);
}

/// Tables of a known machine, read back by a bare one, state the errors of the known one.
#[test]
fn tables_out_and_in_are_the_errors() {
    let errors = table("EXX", "[0, 150, 300]", "[0, 6, -3]")
        + &table("EYX", "[0, 150, 300]", "[0, 2, 5]")
        + &table("EZY", "[0, 100, 200]", "[0, -4, 1]")
        + "[[motion]]\ncomponent = \"EYY\"\nkind = \"backlash\"\nvalue_um = -4\n";
    for chain in ["wFXYZSt", "wYFXZSt", "wXYFZSt"] {
        let shop = Shop::new().file("m.toml", mill(chain, 1) + &errors).file("bare.toml", mill(chain, 1));
        let make =
            ["tables", "--machine", "m.toml", "--format", "cec", "--scheme", "fik", "--points", "3", "-o", "C.INI"];
        shop.run(make).exits(0);
        shop.run(["tables", "--read", "C.INI", "--machine", "bare.toml", "-o", "back.toml"]).exits(0);
        let back = shop.text("back.toml");
        for (component, kind, truth) in [
            ("EXX", "table", vec![0.0, 6.0, -3.0]),
            ("EYX", "table", vec![0.0, 2.0, 5.0]),
            ("EZY", "table", vec![0.0, -4.0, 1.0]),
            ("EYY", "backlash", vec![-4.0, -4.0]),
        ] {
            let found = numbers(&back, component, kind, "values_um");
            // A constant in a table is a choice of the scheme; shapes count.
            let base = if kind == "table" { found[0] } else { 0.0 };
            let shape: Vec<f64> = found.iter().map(|value| value - base).collect();
            assert!(
                shape.len() == truth.len() && shape.iter().zip(&truth).all(|(a, b)| (a - b).abs() < 0.02),
                "{chain} {component}: {found:?}"
            );
        }
    }
}

#[test]
fn tables_that_state_no_errors_of_single_axes_are_refused() {
    let shop = Shop::new().file("bare.toml", mill("wFXYZSt", 1)).copy("samples/tables/grid.csv");
    let run = shop.run(["tables", "--read", "grid.csv", "--machine", "bare.toml", "-o", "back.toml"]);
    run.exits(4).says("E0902").says("grid");
    let shop = shop.copy("samples/tables/product.ini");
    shop.run(["tables", "--read", "product.ini", "--machine", "bare.toml", "-o", "back.toml"])
        .exits(4)
        .says("products");
    // The same errors must not be counted twice.
    let stated = mill("wFXYZSt", 1) + &table("EXX", "[0, 300]", "[0, 9]");
    let shop = shop.copy("samples/tables/x-pitch.csv").file("stated.toml", stated);
    let run = shop.run(["tables", "--read", "x-pitch.csv", "--machine", "stated.toml", "-o", "back.toml"]);
    run.exits(2).says("already states errors");
    assert!(!shop.names().contains(&"back.toml".to_owned()));
}

/// A machine with a curved positioning error of X, 40 µm/m and 60 µm/m², a scale error of Y, and two squarenesses. The table of X has the correction along the line through
/// the middle of the travel and nothing of the other errors: its sums are the rounded polynomial.
#[test]
fn the_own_table_of_an_axis_is_as_smooth_as_its_error() {
    let poly = |component: &str, values: &str| {
        format!("[[motion]]\ncomponent = \"{component}\"\nkind = \"polynomial\"\ncoefficients = {values}\n")
    };
    let errors =
        poly("EXX", "[0.0, 4.0e-5, 6.0e-8]") + &poly("EYY", "[0.0, -3.0e-5]") + "[location]\nEC0Y = -60\nEB0Z = 80\n";
    let shop = Shop::new().file("m.toml", mill("wFXYZSt", 1) + &errors);
    let make =
        ["tables", "--machine", "m.toml", "--format", "pitch", "--scheme", "own", "--points", "31", "-o", "P.csv"];
    shop.run(make).exits(0);
    let text = shop.text("P.csv");
    let mut sum = 0.0;
    let mut count = 0;
    let values = text.lines().skip_while(|line| *line != "number,axis,position,value").skip(1);
    for cells in values.map(|line| line.split(',').collect::<Vec<_>>()).filter(|cells| cells[1] == "X") {
        let (x, value): (f64, f64) = (cells[2].parse().unwrap(), cells[3].parse().unwrap());
        sum += value;
        let m = x / 1000.0;
        // Below the travel the correction stays that of its start, 0.
        let exact_um = if x > 0.0 { -(40.0 * m + 60.0 * m * m) } else { 0.0 };
        assert!((sum - exact_um).abs() <= 0.5 + 0.05, "X {x}: {sum} instead of {exact_um}\n{text}");
        count += 1;
    }
    assert!(count >= 30, "{text}");
    // The limits that the control has are listed.
    assert!(shop.run(["tables", "--list"]).exits(0).stdout.contains("128 values for an axis"), "limits");
}
