//! The datum: a program in a touched zero is right relative to the touched sides. The expected positions are worked out by hand.

use crate::support::Shop;

/// Three linear axes on the tool side, tip and gauge point at the origin; the errors follow.
const LINEAR: &str = "[machine]\nname = \"m\"\ntopology = \"wFXYZt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-10, 900]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-10, 900]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-200, 200]\n";
/// 0.3 mm everywhere, and 0.1 mm per meter.
const OFF_AND_LONG: &str = "[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0.3, 1e-4]\n";
const OFF: &str = "[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0.3]\n";
const G54: &str = "[zero_offset.G54]\nX_mm = 100\nY_mm = 0\nZ_mm = 0\n";

/// A shop with this machine and program.
fn shop(machine: &str, program: &str) -> Shop {
    Shop::new().file("m.toml", machine).file("in.mpf", program)
}

/// The words of a letter in the corrected blocks of a program, without its comments.
fn words(shop: &Shop, letter: char) -> Vec<f64> {
    let text = shop.text("out.mpf");
    let code = text.lines().map(|line| line.split(';').next().unwrap_or_default());
    let words = code.flat_map(|line| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>());
    words.filter_map(|word| word.strip_prefix(letter)?.parse().ok()).collect()
}

/// Corrects and gives the last word of a letter.
fn last(shop: &Shop, letter: char, more: &[&str]) -> f64 {
    shop.run(["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml"].iter().chain(more)).exits(0);
    *words(shop, letter).last().unwrap()
}

#[track_caller]
fn near(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1.1e-3, "{found} instead of {wanted}");
}

fn program(end: &str) -> String {
    format!("N10 G17 G90 G71 G94 G54\nN20 G0 X10 Y10 Z50\nN30 G1 Z5 F500\nN40 {end}\nN50 M30\n")
}

/// The touch at X 100 meets the true 100.3. The command 100 leads there again.
#[test]
fn a_constant_error_needs_no_correction_in_a_touched_zero() {
    let machine = format!("{LINEAR}{OFF}{G54}");
    let shop = shop(&format!("{machine}set = \"touched\"\n"), &program("X400"));
    near(last(&shop, 'X', &[]), 400.0);
    assert_eq!(words(&shop, 'X'), [10.0, 400.0]);
    // In the true place the tool must be 0.3 mm back.
    let shop = shop.file("m.toml", format!("{machine}set = \"absolute\"\n"));
    near(last(&shop, 'X', &["--max-correction", "1mm"]), 399.7);
    near(last(&shop, 'X', &["--max-correction", "1mm", "--zero", "G54=touched"]), 400.0);
}

/// At X 100 the tool stands at 100.31. A point at 400 from there is at 500.31: c + 0.3 + c/10⁴ = 500.31 gives c = 500.01/1.0001 = 499.960.
#[test]
fn a_scale_is_corrected_from_the_touched_side() {
    let shop = shop(&format!("{LINEAR}{OFF_AND_LONG}{G54}set = \"probed\"\n"), &program("X0"));
    near(last(&shop, 'X', &[]), 0.0);
    let shop = shop.file("in.mpf", program("X400"));
    near(last(&shop, 'X', &[]), 399.960);
    // Touched at X 600, where the error is 0.36: c + 0.3 + c/10⁴ = 500.36 gives 500.06/1.0001 = 500.010.
    near(last(&shop, 'X', &["--zero", "G54=touched@X600"]), 400.010);
    let stamp = shop.text("out.mpf");
    assert!(stamp.lines().next().unwrap().contains("zero=G54-touched"), "{stamp}");
}

/// The arithmetic of the test before this one. A set-up file sets the zero again: where the machine file says that it was touched is then wrong.
#[test]
fn a_zero_of_a_set_up_file_forgets_where_the_old_one_was_touched() {
    let machine = format!("{LINEAR}{OFF_AND_LONG}{G54}set = \"touched\"\nset_at = {{ X_mm = 600 }}\n");
    let shop = shop(&machine, &program("X400"));
    near(last(&shop, 'X', &[]), 400.010);
    let grundig = machine.replace("\"sinumerik\"", "\"grundig\"");
    let shop = shop
        .file("new.toml", G54)
        .file("new.ini", "$P_UIFR[1]=CTRANS(X,100)\n")
        .file("new.zo", "%ZO\nG54 X100 Y0 Z0\n")
        .file("grundig.toml", grundig)
        .file("in.pm", "%PM\nN9000\nN1 G17 G90 G54\nN2 G0 X10 Y10 Z50\nN3 G1 Z5 F500\nN4 X400\nN5 M30\n");
    for name in ["new.toml", "new.ini"] {
        near(last(&shop, 'X', &["--setup", name]), 399.960);
    }
    for (setup, wanted) in [(&[][..], 400.010), (&["--setup", "new.zo"], 399.960)] {
        shop.run(["fix", "in.pm", "-o", "out.mpf", "--machine", "grundig.toml"].iter().chain(setup)).exits(0);
        near(*words(&shop, 'X').last().unwrap(), wanted);
    }
}

/// A statement that a zero is absolute was written beside a value. A set-up file with another value comes from somebody who has set the zero since.
#[test]
fn a_new_value_beside_an_old_absolute_is_asked_for() {
    let machine = format!("{LINEAR}{OFF_AND_LONG}{G54}set = \"absolute\"\n");
    let shop = shop(&machine, &program("X400"))
        .file("new.ini", "$P_UIFR[1]=CTRANS(X,101)\n")
        .file("same.ini", "$P_UIFR[1]=CTRANS(X,100)\n")
        .file("stated.toml", "[zero_offset.G54]\nX_mm = 101\nY_mm = 0\nZ_mm = 0\nset = \"absolute\"\n")
        .file("method.toml", machine.replace(G54, "[zero_offset.G54]\n"));
    let asks = |more: &[&str]| {
        let fix = ["fix", "in.mpf", "-o", "out.mpf", "--max-correction", "1mm"];
        let run = shop.run(fix.iter().chain(more)).exits(0);
        run.stderr.contains("W0321")
    };
    let machine = ["--machine", "m.toml"];
    assert!(!asks(&machine), "nothing has changed");
    assert!(!asks(&[&machine[..], &["--setup", "same.ini"]].concat()), "the same value");
    assert!(asks(&[&machine[..], &["--setup", "new.ini"]].concat()), "X 101 in place of X 100");
    assert!(!asks(&[&machine[..], &["--setup", "stated.toml"]].concat()), "the set-up file states the method");
    assert!(!asks(&[&machine[..], &["--setup", "new.ini", "--zero", "G54=absolute"]].concat()), "stated for this run");
    // A method without a value was written for every value.
    assert!(!asks(&["--machine", "method.toml", "--setup", "new.ini"]));
}

/// The touched zero contains 0.6 mm of 1 mm per meter. A retract in machine coordinates knows no touch: there the tool is 0.7 mm off, as in the original.
#[test]
fn a_retract_in_machine_coordinates_after_a_large_touched_error_is_no_difference() {
    let long = "[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-3]\n";
    let zero = "[zero_offset.G54]\nX_mm = 600\nY_mm = 0\nZ_mm = 0\nset = \"touched\"\n";
    let program = "N10 G17 G90 G71 G94 G54\nN20 G0 X10 Y10 Z50\nN30 G1 Z5 F500\nN40 X100\nN50 SUPA G0 Z150\nN60 M30\n";
    let shop = shop(&format!("{LINEAR}{long}{zero}"), program);
    let options = ["--machine", "m.toml", "--max-correction", "2mm"];
    shop.run(["fix", "in.mpf", "-o", "out.mpf"].iter().chain(&options)).exits(0);
    // 100 mm beside the zero 1 mm per meter is 0.1 mm: c + (600 + c)/1000 = 100 + 0.6 gives 100/1.001.
    near(*words(&shop, 'X').last().unwrap(), 99.900);
    shop.run(["verify", "in.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
}

/// The first move is along Z alone, at X and Y that no program states. Relative to a zero far from there, the squareness is 1.2 mm: no difference of the two
/// programs.
#[test]
fn the_error_of_an_unstated_start_is_no_difference_of_the_programs() {
    let machine = format!(
        "{LINEAR}[location]\nEC0X = 1500\n[zero_offset.G54]\nX_mm = 540\nY_mm = 790\nZ_mm = 0\nset = \"touched\"\n"
    );
    for first in ["N20 G0 Z50\n", "N20 G0 Z50\nN25 G0 Z40\n"] {
        let text = format!("N10 G17 G90 G71 G94 G54\n{first}N30 G0 X10 Y10\nN40 G1 Z5 F500\nN50 X300\nN60 M30\n");
        let shop = shop(&machine, &text);
        let fix =
            ["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--max-correction", "2mm", "--review", "r.html"];
        shop.run(fix).exits(0);
        shop.run(["verify", "in.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
    }
}

/// G55 is touched at X 500, where the tool stands at 500.35. A point at 100 from there: c = 600.05/1.0001 = 599.990.
#[test]
fn each_zero_counts_from_its_own_place() {
    let machine = format!(
        "{LINEAR}{OFF_AND_LONG}{G54}set = \"touched\"\n[zero_offset.G55]\nX_mm = 500\nY_mm = 0\nZ_mm = 0\nset = \"touched\"\n"
    );
    let text = program("X0\nG55 X0\nX100\nG54 X400\nG55 X0");
    let shop = shop(&machine, &text);
    near(last(&shop, 'X', &[]), 0.0);
    let found = words(&shop, 'X');
    let wanted = [9.999, 0.0, 0.0, 99.990, 399.960, 0.0];
    assert_eq!(found.len(), wanted.len(), "{found:?}");
    found.iter().zip(wanted).for_each(|(found, wanted)| near(*found, wanted));
}

/// X is touched at Y 300, where Y moves the tool by 0.03 along X; Y is touched at X 400, where X moves it by 0.08 along Y. The true corner is at
/// (100.03, 50.08): x + y/10⁴ = 100.03 and y + 2x/10⁴ = 50.08 give x = 100.025 and y = 50.060.
#[test]
fn sides_touched_one_by_one_give_their_own_component() {
    let machine = format!(
        "{LINEAR}[[motion]]\ncomponent = \"EXY\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n\
         [[motion]]\ncomponent = \"EYX\"\nkind = \"polynomial\"\ncoefficients = [0, 2e-4]\n\
         [zero_offset.G54]\nX_mm = 100\nY_mm = 50\nZ_mm = 0\nset = \"touched\"\n\
         set_at = {{ X = {{ X_mm = 100, Y_mm = 300 }}, Y = {{ X_mm = 400, Y_mm = 50 }} }}\n"
    );
    let shop = shop(&machine, &program("X0 Y0"));
    near(last(&shop, 'X', &[]), 0.025);
    near(*words(&shop, 'Y').last().unwrap(), 0.060);
}

/// A table whose axis is 0.1 mm off in X carries the workpiece. Touched at C 0, the correction there is zero. At C 90 the touched side has turned with
/// the table, the offset of the axis has not: (0.1, 0) − (0, 0.1).
#[test]
fn a_touched_side_turns_with_the_table() {
    let machine = "[machine]\nname = \"m\"\ntopology = \"wCFXYZt\"\ncontroller = \"sinumerik\"\n\
        [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-500, 500]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-500, 500]\n\
        [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-200, 200]\n[axis.C]\ndirection = [0, 0, 1]\ntravel_deg = [-360, 360]\n\
        [location]\nEX0C = 100.0\n[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nC_deg = 0\nset = \"touched\"\n";
    let of =
        |angle: &str| format!("N10 G17 G90 G71 G94 G54\nN20 G0 X10 Y10 Z50 C{angle}\nN30 G1 X40 Y20 F500\nN40 M30\n");
    let shop = shop(machine, &of("0"));
    near(last(&shop, 'X', &[]), 40.0);
    near(*words(&shop, 'Y').last().unwrap(), 20.0);
    let shop = shop.file("in.mpf", of("90"));
    near(last(&shop, 'X', &[]), 40.1);
    near(*words(&shop, 'Y').last().unwrap(), 19.9);
}

/// Without a statement the zero counts as true, and the size of the doubt is named: 0.3 + 100/10⁴ = 0.31 mm.
#[test]
fn what_nobody_states_is_pointed_out_with_its_size() {
    let shop = shop(&format!("{LINEAR}{OFF_AND_LONG}{G54}"), &program("X400"));
    let fix = ["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--max-correction", "1mm"];
    let run = shop.run(fix).exits(0);
    run.says("warning[W0321]: nothing states how G54 was set, so it counts as touched")
        .says("X 310 µm")
        .says("G54=touched");
    let json = shop.run(fix.iter().chain(&["--json"])).exits(0).json();
    assert_eq!(json["zeros"][0]["set"], "touched");
    assert_eq!(json["zeros"][0]["is_stated"], false);
    assert!((json["zeros"][0]["distance_um"].as_f64().unwrap() - 310.0).abs() < 1e-6, "{json}");
    // Of 0.31 to 0.35 mm at X 100 to 500 only the part beyond 0.31 is form.
    let [before, form] = ["before", "before_form"].map(|key| json[key]["max_um"].as_f64().unwrap());
    assert!((before - 40.0).abs() < 1.0 && (form - 40.0).abs() < 1.0, "{json}");
    let absolute = shop.run(fix.iter().chain(&["--zero", "G54=absolute", "--json"])).exits(0).json();
    let [before, form] = ["before", "before_form"].map(|key| absolute[key]["max_um"].as_f64().unwrap());
    assert!((before - 350.0).abs() < 1.0 && (form - 40.0).abs() < 1.0, "{absolute}");
    let check = shop.run(["check", "in.mpf", "--machine", "m.toml", "--max-correction", "1mm"]).exits(0);
    check.says("warning[W0321]");
    for set in ["touched", "absolute"] {
        let zero = format!("G54={set}");
        let run = shop.run(fix.iter().chain(&["--zero", zero.as_str()])).exits(0);
        assert!(!run.stderr.contains("W0321"), "{}", run.stderr);
        let words = ["verify", "in.mpf", "out.mpf", "--machine", "m.toml", "--json", "--zero", zero.as_str()];
        let verified = shop.run(words).exits(0).json();
        assert_eq!(verified["zeros"][0]["set"], set);
        assert!(verified["after"]["max_um"].as_f64().unwrap() < 1.5, "{verified}");
        let most_um = verified["before"]["max_um"].as_f64().unwrap();
        assert!((most_um - if set == "touched" { 40.0 } else { 350.0 }).abs() < 1.0, "{verified}");
    }
    // Corrected for a touched zero, and judged as if it were true: 0.31 mm off, and the stamp says another state.
    shop.run(fix.iter().chain(&["--zero", "G54=touched"])).exits(0);
    let words = ["verify", "in.mpf", "out.mpf", "--machine", "m.toml", "--zero", "G54=absolute"];
    shop.run(words).exits(4).says("W0306").says("temperatures, weight or method of the zero");
}

/// Drift of 3 µm/K in Z at +5 K: 15 µm are in a zero that was touched off in this state. Without a statement they are corrected nevertheless.
#[test]
fn drift_at_an_unstated_zero_is_pointed_out_with_its_size() {
    let drift = "[[drift]]\ndirection = \"Z\"\nsensors = [{ name = \"T_head\", um_per_K = 3.0 }]\n";
    let shop =
        shop(&format!("{LINEAR}{drift}{G54}"), &program("X400")).file("warm.toml", "[temperature_C]\nT_head = 25\n");
    let fix = ["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--state", "warm.toml"];
    let run = shop.run(fix).exits(0);
    run.says("warning[W0321]: nothing states how G54 was set, so temperature and weight")
        .says("if you touched off at these temperatures and this weight, the correction is too large by Z 15.0 µm");
    near(*words(&shop, 'Z').last().unwrap(), 4.985);
    // Nothing is open once the method or the time is stated, or without a state.
    let cold = &fix[..6];
    for words in [
        cold.to_vec(),
        [&fix[..], &["--zero", "G54=touched"]].concat(),
        [&fix[..], &["--zero", "G54=absolute"]].concat(),
    ] {
        let run = shop.run(words).exits(0);
        assert!(!run.stderr.contains("W0321"), "{}", run.stderr);
    }
}

/// A weight of 1000 N makes X 0.1 mm per meter too long: 10 µm at the zero, X 100.
#[test]
fn a_weight_at_an_unstated_zero_is_pointed_out_with_its_size() {
    let load = "[[load]]\ncomponent = \"EXX\"\nreference_N = 1000\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n";
    let shop = shop(&format!("{LINEAR}{load}{G54}"), &program("X400"));
    let fix = ["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--load", "1000"];
    shop.run(fix)
        .exits(0)
        .says("warning[W0321]: nothing states how G54 was set, so temperature and weight")
        .says("if you touched off at these temperatures and this weight, the correction is too large by X 10.0 µm");
    let stated = shop.run(fix.iter().chain(&["--zero", "G54=touched"])).exits(0);
    assert!(!stated.stderr.contains("W0321"), "{}", stated.stderr);
}

#[test]
fn a_program_without_a_zero_offset_is_as_it_was() {
    let text = "N10 G17 G90 G71 G94\nN20 G0 G53 X110 Y10 Z50\nN30 G1 G53 X500 F500\nN40 M30\n";
    let shop = shop(&format!("{LINEAR}{OFF_AND_LONG}{G54}set = \"touched\"\n"), text);
    let fix = ["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--max-correction", "1mm", "--json"];
    let json = shop.run(fix).exits(0).json();
    assert_eq!(json["zeros"].as_array().unwrap().len(), 0, "{json}");
    assert!((json["before"]["max_um"].as_f64().unwrap() - 350.0).abs() < 1.0, "{json}");
}

/// The program moves in G54 alone, so a statement about G55 changes nothing.
#[test]
fn a_stated_zero_in_which_nothing_moves_is_pointed_out() {
    let machine =
        format!("{LINEAR}{OFF_AND_LONG}{G54}set = \"touched\"\n[zero_offset.G55]\nX_mm = 300\nY_mm = 0\nZ_mm = 0\n");
    let shop = shop(&machine, &program("X400"));
    let fix = |zero: &str| shop.run(["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--zero", zero]).exits(0);
    fix("G55=absolute").says("warning[W0328]: --zero G55=… has no effect: the axes move in G54");
    // 499.960 mm as without the statement: the arithmetic is that of a scale from the touched side.
    near(*words(&shop, 'X').last().unwrap(), 399.960);
    let used = fix("G54=touched");
    assert!(!used.stderr.contains("W0328"), "{}", used.stderr);
    let words = ["check", "in.mpf", "--machine", "m.toml", "--zero", "G55=absolute"];
    shop.run(words).exits(0).says("warning[W0328]");
}

/// In G53 and in G500 without values, positions are those of the machine: at X 500 the tool is 0.35 mm off, which no touch contains.
#[test]
fn a_program_in_no_zero_offset_says_that_positions_are_those_of_the_machine() {
    let machine = format!("{LINEAR}{OFF_AND_LONG}{G54}set = \"touched\"\n");
    for text in [
        "N10 G17 G90 G71 G94\nN20 G0 G53 X110 Y10 Z50\nN30 G1 G53 X500 F500\nN40 M30\n",
        "N10 G17 G90 G71 G94 G500\nN20 G0 X110 Y10 Z50\nN30 G1 X500 F500\nN40 M30\n",
    ] {
        let shop = shop(&machine, text);
        let fix = ["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--max-correction", "1mm"];
        let all = [&fix[..], &["--zero", "G54=touched", "--review", "page.html"]].concat();
        let run = shop.run(all).exits(0);
        run.says("zero         no offset in force: corrected to true positions of the machine")
            .says("warning[W0328]: --zero G54=… has no effect: no zero offset is in force where the axes move");
        // c + 0.3 + c/10⁴ = 500 gives 499.7/1.0001 = 499.650.
        near(*words(&shop, 'X').last().unwrap(), 499.650);
        assert!(shop.text("page.html").contains("corrected to true positions of the machine"));
    }
}

#[test]
fn a_wrong_statement_is_refused() {
    let shop = shop(&format!("{LINEAR}{OFF}{G54}set = \"touched\"\n"), &program("X400"));
    let fix = |zero: &str| shop.run(["in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--zero", zero]);
    fix("G54").exits(2).says("write for example G54=touched");
    fix("G54=guessed").exits(2).says("write for example G54=touched");
    fix("G57=touched").exits(2).says("G57");
    let shop = shop.file("m.toml", format!("{LINEAR}{OFF}{G54}set = \"guessed\"\nset_at = {{ Q_mm = 1 }}\n"));
    shop.run(["machine", "check", "m.toml"]).exits(4).says("not a method of setting a zero").says("Q_mm");
}

/// A program that is sent line by line is corrected from the same assumed touch, so it says so.
#[test]
fn a_feed_says_that_a_zero_counts_as_touched() {
    let machine = format!("{LINEAR}{OFF_AND_LONG}{G54}").replace("sinumerik", "rs274");
    let shop = shop(&machine, "G21 G90 G54\nG0 X10 Y10 Z50\nG1 Z5 F500\nX400\nM2\n");
    let feed = ["feed", "in.mpf", "--machine", "m.toml", "--link", "grbl", "--dry-run"];
    let run = shop.run(feed);
    run.says("warning[W0321]: nothing states how G54 was set, so it counts as touched").says("X 310 µm");
    let stated = shop.run(feed.iter().chain(&["--zero", "G54=touched"]));
    assert!(!stated.stderr.contains("W0321"), "{}", stated.stderr);
}

/// The values that a program gives to its zero offset are values of the control: touched, if nothing is stated. At X 100 the tool stands at 100.31, and a
/// point 400 from there is commanded at 499.960. In the true place it is 500 = c + 0.3 + c/10⁴, that is 499.650.
#[test]
fn an_offset_that_the_program_sets_counts_as_touched() {
    let sinumerik = "N10 G17 G90 G71 G94\nN15 $P_UIFR[1]=CTRANS(X,100,Y,0,Z,0)\nN16 G54\nN20 G0 X10 Y10 Z50\nN30 G1 Z5 F500\nN40 X400\nN50 M30\n";
    let fanuc =
        "%\nO1\nG17 G90 G21 G94\nG10 L2 P1 X100. Y0. Z0.\nG54\nG0 X10. Y10. Z50.\nG1 Z5. F500.\nX400.\nM30\n%\n";
    for (controller, text) in [("sinumerik", sinumerik), ("fanuc", fanuc)] {
        let machine = format!("{LINEAR}{OFF_AND_LONG}").replace("sinumerik", controller);
        let mut own = shop(&machine, text);
        let fix = [
            "fix",
            "in.mpf",
            "-o",
            "out.mpf",
            "--machine",
            "m.toml",
            "--max-correction",
            "1mm",
            "--dialect",
            controller,
        ];
        own.run(fix).exits(0).says("nothing states how G54 was set, so it counts as touched").says("X 310 µm");
        near(*words(&own, 'X').last().unwrap(), 399.960);
        let verified = own
            .run(["verify", "in.mpf", "out.mpf", "--machine", "m.toml", "--dialect", controller, "--json"])
            .exits(0)
            .json();
        assert_eq!((&verified["zeros"][0]["name"], &verified["zeros"][0]["is_stated"]), (&"G54".into(), &false.into()));
        assert!(verified["after"]["max_um"].as_f64().unwrap() < 1.5, "{verified}");
        for (set, wanted) in [("touched", 399.960), ("absolute", 399.650)] {
            own = own.file("m.toml", format!("{machine}[zero_offset.G54]\nset = \"{set}\"\n"));
            let run = own.run(fix).exits(0);
            assert!(!run.stderr.contains("W0321"), "{}", run.stderr);
            near(*words(&own, 'X').last().unwrap(), wanted);
        }
    }
}

/// A program that sets its offset twice has two touched places: at X 100 the tool stands at 100.31, at X 500 at 500.35.
#[test]
fn each_value_that_the_program_sets_has_its_own_place() {
    let text = "N10 G17 G90 G71 G94\n$P_UIFR[1]=CTRANS(X,100)\nG54\nG0 X10 Y10 Z50\nG1 Z5 F500\nX0\n$P_UIFR[1]=CTRANS(X,500)\nG54\nX0\nX100\nM30\n";
    let shop = shop(&format!("{LINEAR}{OFF_AND_LONG}"), text);
    near(last(&shop, 'X', &["--max-correction", "1mm"]), 99.990);
    let found = words(&shop, 'X');
    near(found[found.len() - 2], 0.0);
}

/// b = 0.1 mm: the tool stands 0.05 mm further in X after a positive motion, and 0.05 mm less after a negative one. The cut comes from below. A side touched
/// from below contains the same half; touched from above it contains the other one, 0.1 mm away; without a direction it is in the middle.
#[test]
fn the_direction_of_the_touch_decides_the_half_of_the_backlash() {
    let machine = format!(
        "{LINEAR}[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 100\n{G54}set = \"touched\"\n"
    );
    for (at, wanted) in
        [("set_at = { X = { X_dir = 1 } }\n", 400.0), ("set_at = { X_dir = -1 }\n", 399.9), ("", 399.95)]
    {
        let shop = shop(&format!("{machine}{at}"), &program("X400"));
        near(last(&shop, 'X', &["--max-correction", "1mm"]), wanted);
    }
    let shop = shop(&format!("{machine}set_at = {{ X_dir = 2 }}\n"), &program("X400"));
    shop.run(["machine", "check", "m.toml"]).exits(4).says("E0404").says("X_dir");
}

/// Z tilts the tool by 0.1 mrad: a probe of 100 mm stands at −0.01 mm, the bare gauge point of the program at 0.
#[test]
fn the_length_of_the_touch_counts() {
    let tilt = "[[motion]]\ncomponent = \"EBZ\"\nkind = \"polynomial\"\ncoefficients = [1e-4]\n";
    let shop = shop(&format!("{LINEAR}{tilt}{G54}set = \"touched\"\n"), &program("X400"));
    near(last(&shop, 'X', &[]), 400.0);
    near(last(&shop, 'X', &["--zero", "G54=touched@L100"]), 399.990);
    near(last(&shop, 'X', &["--zero", "G54=touched@X100,Y0,Z100,L100"]), 399.990);
    shop.run(["in.mpf", "-o", "x.mpf", "--machine", "m.toml", "--zero", "G54=touched@Lx"]).exits(2).says("L100");
}

/// Z is 0.1 mm per meter too long and 2 µm too high at 0. With 110 mm below the spindle, Z stands at 110 when the tip touches 0: the zero contains 11 µm more.
#[test]
fn the_length_of_the_tool_at_the_touch_is_asked_for_where_it_matters() {
    let long = "[[motion]]\ncomponent = \"EZZ\"\nkind = \"polynomial\"\ncoefficients = [0.002, 1e-4]\n";
    let tool = "[[tool]]\nnumber = 1\nlength_mm = 110.0\nradius_mm = 4.0\n";
    let program = "N10 G17 G90 G71 G94 G54\nN15 T1 M6\nN18 D1\nN20 G0 X10 Y10 Z50\nN30 G1 Z5 F500\nN40 X40\nN50 M30\n";
    let shop = shop(&format!("{LINEAR}{long}{G54}{tool}"), program);
    for command in [["fix", "-o"], ["check", ""]] {
        let words = |zero: &'static str| {
            let out = ["-o", "out.mpf"].into_iter().filter(|_| command[1] == "-o");
            [command[0], "in.mpf", "--machine", "m.toml", "--zero", zero].into_iter().chain(out).collect::<Vec<_>>()
        };
        let run = shop.run(words("G54=touched")).exits(0);
        // Nothing states the tool: the first one of the program has touched. Without a tool, Z would have stood at 0 and 11 µm lower.
        run.says("warning[W0326]: G54 counts as touched with the first tool of the program there, of length 110 mm")
            .says("if a tool of length 0 mm touched")
            .says("by Z -11.0 µm")
            .says("--zero G54=touched@L110");
        for zero in ["G54=touched@L110", "G54=probed@L0", "G54=absolute"] {
            let run = shop.run(words(zero)).exits(0);
            assert!(!run.stderr.contains("W0326"), "{zero}: {}", run.stderr);
        }
    }
    // With the length, the surface that was touched is cut where the touch was.
    let shop = shop.file("in.mpf", program.replace("Z5 F", "Z0 F"));
    near(last(&shop, 'Z', &["--zero", "G54=touched@L110"]), 0.0);
    near(last(&shop, 'Z', &["--zero", "G54=touched"]), 0.0);
    near(last(&shop, 'Z', &["--zero", "G54=touched@L0"]), -0.011);
    // Lengths from the machine zero are negative: Z stands at -110 when the tip touches 0.
    let shop = shop.file("m.toml", format!("{LINEAR}{long}{G54}{}", tool.replace("110.0", "-110.0")));
    let run = shop.run(["fix", "in.mpf", "--machine", "m.toml", "--zero", "G54=touched", "-o", "out.mpf"]).exits(0);
    run.says("of length -110 mm").says("by Z 11.0 µm").says("--zero G54=touched@L-110");
}

/// Each zero counts with the first tool that cuts in it: G54 with T1 of 110 mm, G55 with T2 of 60 mm. Z is 0.1 mm per meter too long.
#[test]
fn each_zero_has_its_own_first_tool() {
    let long = "[[motion]]\ncomponent = \"EZZ\"\nkind = \"polynomial\"\ncoefficients = [0, 1e-4]\n";
    let tool =
        |number: u32, length: f64| format!("[[tool]]\nnumber = {number}\nlength_mm = {length:?}\nradius_mm = 4.0\n");
    let zeros = format!("{G54}set = \"touched\"\n{}set = \"touched\"\n", G54.replace("G54", "G55"));
    let machine = format!("{LINEAR}{long}{zeros}{}{}", tool(1, 110.0), tool(2, 60.0));
    let program = "N10 G17 G90 G71 G94 G54\nN15 T1 M6\nN18 D1\nN20 G0 X10 Y10 Z50\nN30 G1 Z0 F500\nN40 X40\nN50 G0 Z50\n\
        N55 T2 M6\nN58 D1\nN60 G55\nN65 G0 X10 Y10 Z50\nN70 G1 Z0 F500\nN80 X40\nN90 G54 G0 Z50\nN95 G1 Z0\nN99 M30\n";
    let shop = shop(&machine, program);
    shop.run(["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0).says("W0326");
    let feeds = shop.text("out.mpf");
    let of_block = |number: &str| {
        let lines = feeds.lines().filter(|line| line.starts_with(number));
        let word = lines.flat_map(str::split_whitespace).filter_map(|word| word.strip_prefix('Z')).next_back();
        word.unwrap_or_else(|| panic!("{number}: {feeds}")).parse::<f64>().unwrap()
    };
    near(of_block("N30 "), 0.0);
    near(of_block("N70 "), 0.0);
    // T2 in the zero of T1: Z stands at 60 instead of 110, where it is 5 µm lower.
    near(of_block("N95 "), 0.005);
}

/// The places of the touches one by one, their sides and the radius of the edge finder: by hand as in the tests before.
#[test]
fn sides_and_radius_of_a_touch_are_stated_on_the_command_line() {
    let shop = shop(&format!("{LINEAR}{OFF_AND_LONG}{G54}set = \"touched\"\n"), &program("X400"));
    let of = |zero: &str| last(&shop, 'X', &["--zero", zero]);
    // Touched at X 600, whatever the pose of the other touches.
    near(of("G54=touched@X:X600"), 400.010);
    near(of("G54=touched@X700@X:X600@Y:X0,Y10"), 400.010);
    near(of("G54=touched@Y:X600"), 399.960);
    // The center stood at 100 − 50, where the error is 0.305: c + 0.3 + c/10⁴ = 500.305 gives 500.005/1.0001.
    near(of("G54=touched@X+,R50"), 399.955);
    // From the other side it stood at 150: 500.015/1.0001.
    near(of("G54=touched@X:X-,R50"), 399.965);
    let machine = format!(
        "{LINEAR}[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 100\n{G54}set = \"touched\"\n"
    );
    let shop = shop.file("m.toml", machine);
    for (zero, wanted) in [("G54=touched@X+", 400.0), ("G54=touched@X:X100-", 399.9), ("G54=touched@Y+", 399.95)] {
        near(last(&shop, 'X', &["--max-correction", "1mm", "--zero", zero]), wanted);
    }
    let run = ["in.mpf", "-o", "x.mpf", "--machine", "m.toml", "--zero"];
    for (zero, says) in [
        ("G54=touched@R5", "without the side"),
        ("G54=touched@W:X1", "states no zero"),
        ("G54=touched@X100+,R5", "give one of them"),
        ("G54=touched@X100,R5,X+", "give one of them"),
    ] {
        shop.run(run.iter().chain([&zero])).exits(2).says(says);
    }
}

/// X goes from −10 to 900, Z from −200 to 200: an axis cannot touch elsewhere.
#[test]
fn a_touch_outside_the_travel_is_refused() {
    let shop = shop(&format!("{LINEAR}{OFF}{G54}"), &program("X400"));
    for zero in ["G54=touched@X950", "G54=touched@Z:X100,Z250,L50", "G54=probed@X+,R200"] {
        let run = shop.run(["in.mpf", "-o", "x.mpf", "--machine", "m.toml", "--zero", zero]).exits(2);
        run.says("cannot stand at").says("travel");
        assert!(!shop.path("x.mpf").exists(), "{zero}");
    }
    for at in ["set_at = { X_mm = 950 }", "set_at = { Z = { Z_mm = -201 } }"] {
        std::fs::write(shop.path("m.toml"), format!("{LINEAR}{OFF}{G54}set = \"touched\"\n{at}\n")).unwrap();
        shop.run(["machine", "check", "m.toml"]).exits(4).says("E0302").says("outside the travel");
    }
}

/// Without tools in the file, a tool may have up to 500 mm: Z −600 is reached, Z −800 and Z 300 are not. X ends at 900.
#[test]
fn a_zero_that_no_tool_reaches_is_named() {
    let check = |x: f64, z: f64, tool: &str| {
        let zero = format!("[zero_offset.G54]\nX_mm = {x}\nY_mm = 0\nZ_mm = {z}\n");
        let shop = Shop::new().file("m.toml", format!("{LINEAR}{OFF}{zero}{tool}"));
        let run = shop.run(["machine", "check", "m.toml"]).exits(0);
        run.stderr.lines().filter(|line| line.starts_with("warning[W0331]")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert!(check(100.0, -600.0, "").is_empty());
    for (x, z, says) in [(9000.0, 0.0, "X 9000 mm of G54"), (100.0, -800.0, "Z -800 mm"), (100.0, 300.0, "Z 300 mm")] {
        let found = check(x, z, "");
        assert!(found.len() == 1 && found[0].contains(says), "{found:?}");
    }
    // The longest tool has 110 mm: −600 + 110 is below −200.
    let found = check(100.0, -600.0, "[[tool]]\nnumber = 1\nlength_mm = 110.0\nradius_mm = 4.0\n");
    assert!(found.len() == 1 && found[0].contains("Z -600 mm"), "{found:?}");
}

/// C turns 0.2 mrad per radian too far. At C 90 this is 0.2 · π/2 = 0.314 mrad; the table turns about −Z, so the sign is that of the axis. The zero of X, Y and Z is
/// on the axis of the table, where this turn moves nothing.
#[test]
fn the_zero_of_a_rotary_table_is_a_true_angle() {
    let table = "[machine]\nname = \"m\"\ntopology = \"wCXYFZt\"\ncontroller = \"sinumerik\"\n\
        [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [-400, 400]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [-400, 400]\n\
        [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-200, 200]\n\
        [axis.C]\ndirection = [0, 0, SIGN]\ntravel_deg = [-360, 360]\n\
        [[motion]]\ncomponent = \"ECC\"\nkind = \"polynomial\"\ncoefficients = [0, 2e-4]\n";
    let program = "N10 G17 G90 G71 G94 G54\nN20 G0 X100 Y0 Z20 C0\nN30 G1 Z-2 F600\nN40 X150\nN50 M30\n";
    for (sign, urad) in [("1", "C 314 µrad"), ("-1", "C -314 µrad")] {
        let offset = |c: &str| format!("[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nC_deg = {c}\n");
        let run = |c: &str, zero: &'static str| {
            let shop = shop(&format!("{}{}", table.replace("SIGN", sign), offset(c)), program);
            shop.run(["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--zero", zero]).exits(0)
        };
        run("90", "G54=touched").says("its rotary zero counts as a true angle, and would contain").says(urad);
        for (c, zero) in [("0", "G54=touched"), ("90", "G54=absolute")] {
            let text = run(c, zero).stderr;
            assert!(!text.contains("true angle"), "{c} {zero}: {text}");
        }
    }
}

/// The axis of C stands 50 µm off in X. A workpiece that was touched at C 180 has this error with the other sign: 100 µm away from one that was touched at C 0.
#[test]
fn a_touch_without_angles_is_named() {
    let table = "[machine]\nname = \"m\"\ntopology = \"wCFXYZt\"\ncontroller = \"sinumerik\"\n\
        [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-10, 900]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-10, 900]\n\
        [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-200, 200]\n[axis.C]\ndirection = [0, 0, 1]\nmodulo = true\n\
        [location]\nEX0C = 50.0\n";
    let text = "N10 G17 G90 G71 G94 G54\nN20 G0 X10 Y10 Z50 C0\nN30 G1 Z5 F500\nN40 X100\nN50 M30\n";
    let shop = shop(&format!("{table}{G54}"), text);
    let fix = |zero: &str| shop.run(["fix", "in.mpf", "-o", "out.mpf", "--machine", "m.toml", "--zero", zero]).exits(0);
    let run = fix("G54=touched@X100,Y0,Z0,L0");
    let run = run.says("warning[W0335]: G54 counts as touched at C 0°").says("if C was at 180°").says("--zero");
    assert!(run.stderr.contains("wrong by X 100 µm") || run.stderr.contains("wrong by X -100 µm"), "{}", run.stderr);
    for zero in ["G54=touched@X100,Y0,Z0,C0,L0", "G54=touched@L0", "G54=absolute"] {
        assert!(!fix(zero).stderr.contains("W0335"), "{zero}: {}", fix(zero).stderr);
    }
}
