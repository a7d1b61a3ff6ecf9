//! Machine files: the samples are sound, every fault is found at its place and all in one run, nothing makes the reader panic.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::file::{DEMO, apply_setup};
use ncfix_machine::machine::{
    CompensationCorner, CompensationStart, DecimalPoint, LengthAxis, Lever, Machine, ToolChange,
};
use ncfix_model::motion::EntryFunction;
use ncfix_model::{ErrorModel, file};

use crate::support::Shop;

fn source(bytes: &[u8]) -> Source {
    Source::new(FileId(0), "machine.toml", bytes.to_vec()).unwrap()
}

pub(crate) fn load(text: &str) -> (Option<(Machine, ErrorModel)>, Vec<Diagnostic>) {
    file::load(&source(text.as_bytes()))
}

/// Code and the text at the place of each finding.
fn seen(text: &str) -> Vec<(String, String)> {
    let findings = load(text).1;
    let at = |finding: &Diagnostic| {
        String::from_utf8_lossy(source(text.as_bytes()).slice(finding.place.unwrap().span)).into()
    };
    findings.iter().map(|finding| (finding.code.to_string(), at(finding))).collect()
}

fn samples(folder: &str) -> Vec<(String, String)> {
    let folder = format!("{}/samples/machines{folder}", env!("CARGO_MANIFEST_DIR"));
    let mut found: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .map(|path| (path.file_stem().unwrap().to_string_lossy().into_owned(), std::fs::read_to_string(path).unwrap()))
        .collect();
    found.sort();
    found
}

const SMALL: &str = "[machine]\nname = \"small\"\ntopology = \"wFXCSt\"\n\
    [axis.X]\ndirection = [2, 0, 0]\ntravel_mm = [0, 700]\n\
    [axis.C]\ndirection = [0, 0, 1]\ntravel_deg = [-180, 180]\n";

#[test]
fn the_samples_are_sound() {
    let found = samples("");
    assert!(found.len() >= 3);
    for (name, text) in found {
        let (machine, findings) = load(&text);
        assert!(findings.is_empty(), "{name}: {findings:#?}");
        let (machine, _) = machine.unwrap();
        assert_eq!(machine.name, name);
        for (offset, position) in &machine.zero_offsets {
            for axis in machine.axis_set().iter() {
                let [low, high] = machine.axis(axis).unwrap().travel.unwrap();
                assert!(
                    (low..=high).contains(&position.shift()[axis]),
                    "{name}: {offset} lies in the travel of {axis}"
                );
            }
        }
    }
    let demo = load(DEMO).0.unwrap().0;
    let mut numbers: Vec<u32> = demo.tools.iter().map(|tool| tool.number).collect();
    numbers.sort_unstable();
    assert_eq!(numbers, (1..=12).collect::<Vec<_>>());
    assert_eq!(demo.zero_offsets.keys().collect::<Vec<_>>(), ["G505", "G506", "G54", "G55", "G56", "G57"]);
}

#[test]
fn each_bad_sample_provokes_its_code_only() {
    let found = samples("/bad");
    let mut codes: Vec<&str> = found.iter().map(|(name, _)| &name[..5]).collect();
    for (name, text) in &found {
        let (machine, findings) = load(text);
        assert!(!findings.is_empty(), "{name} is found bad");
        assert!(findings.iter().all(|finding| finding.code.as_str() == &name[..5]), "{name}: {findings:#?}");
        assert!(findings.iter().all(|finding| finding.place.is_some() && !finding.help.is_empty()));
        assert_eq!(machine.is_some(), name.starts_with('W'), "{name}");
    }
    codes.dedup();
    let registered: Vec<&str> = (ncfix_base::diagnostic::CODES.iter().map(|row| row.code.as_str()))
        // W0407 is about a machine file beside a file of the control, and W0409 is only for machine check.
        .filter(|code| (code.starts_with("E04") || code.starts_with("W04")) && !["W0407", "W0409"].contains(code))
        .collect();
    assert_eq!(codes, registered);
}

#[test]
fn all_faults_are_found_in_one_run_at_their_places() {
    let text = "[machine]\nname = 5\ntopology = \"wFXYSt\"\n\
        [axis.X]\ndirection = [1, 0]\ntravel_mm = [0, inf]\n\
        [axis.Y]\ndirection = [0, 1, 0.001]\ntravel_deg = [0, 1]\n\
        [axis.B]\ndirection = [0, 0, 0]\nlever = \"loose\"\n\
        [spindel]\n\
        [control]\nincrement_mm = 0\ntool_change = \"M06\"\ninitial_zero_offset = \"G58\"\n\
        [zero_offset.G54]\nX_um = 1\n[zero_offset.G53]\nX_mm = 1\n\
        [location]\nEC0Y = \"15\"\nEXX = 1\nEX0Q = 1\n\
        [[tool]]\nname = \"T\"\n[[tool]]\nnumber = 1.5\nlength_mm = [1, 2]\n\
        [[motion]]\ncomponent = \"EXX\"\nkind = \"polynom\"\n\
        [[motion]]\ncomponent = \"EC0Y\"\nkind = \"table\"\n\
        [[motion]]\ncomponent = \"EXB\"\nkind = \"periodic\"\nperiod_mm = 10\namplitude_um = nan\n\
        [[motion]]\ncomponent = \"EXY\"\nkind = \"cross\"\ncoefficients = [1]\nwith = \"Y\"\n";
    let expected = [
        ("E0404", "5"),
        ("E0404", "[1, 0]"),
        ("E0404", "[0, inf]"),
        ("W0401", "[axis.Y]"),
        ("E0404", "[0, 1, 0.001]"),
        ("E0402", "travel_deg"),
        ("E0405", "[axis.B]"),
        ("W0401", "[axis.B]"),
        ("E0404", "[0, 0, 0]"),
        ("E0404", "\"loose\""),
        ("E0402", "spindel"),
        ("E0404", "0"),
        ("E0404", "\"M06\""),
        ("E0404", "\"G58\""),
        ("E0402", "X_um"),
        ("E0402", "G53"),
        ("E0404", "\"15\""),
        ("E0406", "EXX"),
        ("E0406", "EX0Q"),
        ("E0403", "[[tool]]"),
        ("E0403", "[[tool]]"),
        ("E0404", "1.5"),
        ("E0404", "[1, 2]"),
        ("E0404", "\"polynom\""),
        ("E0406", "\"EC0Y\""),
        ("E0407", "period_mm"),
        ("E0404", "nan"),
        ("E0403", "[[motion]]"),
        ("E0404", "\"Y\""),
    ];
    let found = seen(text);
    let found: Vec<(&str, &str)> = found.iter().map(|(code, at)| (code.as_str(), at.as_str())).collect();
    assert_eq!(found, expected);
    let helps: Vec<String> = load(text).1.into_iter().map(|finding| finding.help).collect();
    for hint in ["did you mean `spindle`?", "did you mean `X_mm`?", "did you mean \"polynomial\"?", "write period_deg"]
    {
        assert!(helps.iter().any(|help| help.contains(hint)), "{hint}");
    }
}

#[test]
fn units_become_millimeters_and_radians() {
    let text = format!(
        "{SMALL}max_feed_deg_min = 3600\nlever = \"fixed\"\npoint_mm = [1, 2, 3]\n\
        [spindle]\naxis = [0, 3, 4]\n\
        [control]\nincrement_deg = 0.001\ntool_change = \"T\"\n\
        [zero_offset.G54]\nX_mm = 10\nC_deg = 90\n\
        [location]\nEX0C = -2.0\nEA0C = 30.0\n\
        [[tool]]\nnumber = 3\nlength_mm = [100, 1, 2]\n\
        [[motion]]\ncomponent = \"EAC\"\nkind = \"table\"\npositions_deg = [-180, 180]\nvalues_urad = [-5, 5]\n\
        [[motion]]\ncomponent = \"EXC\"\nkind = \"periodic\"\nperiod_deg = 360\namplitude_um = 2\nphase_deg = 90\n\
        [[motion]]\ncomponent = \"EZX\"\nkind = \"piecewise\"\ndegree = 2\ncoefficients = [0, 1e-5]\n\
        knots = [{{ at_mm = 100, coefficients = [0, 0, 3e-8] }}]\n\
        [[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 6\n\
        [[motion]]\ncomponent = \"EAX\"\nkind = \"cross\"\ncoefficients = [0, 1e-9]\nwith = \"C\"\nwith_coefficients = [1]\n"
    );
    let (result, findings) = load(&text);
    assert!(findings.is_empty(), "{findings:#?}");
    let (machine, errors) = result.unwrap();
    let c = machine.axis(Axis::C).unwrap();
    assert_eq!(machine.axis(Axis::X).unwrap().direction, Vector::x(), "normalized");
    assert!((c.travel.unwrap()[1] - std::f64::consts::PI).abs() < 1e-15);
    assert_eq!((c.lever, c.max_feed, c.point_mm), (Lever::Fixed, Some(3600.0), Vector::new(1.0, 2.0, 3.0)));
    assert_eq!(machine.spindle.axis, Vector::new(0.0, 0.6, 0.8));
    assert!((machine.control.increment_rad - 1.745_329_251_994_33e-5).abs() < 1e-17);
    assert_eq!(machine.control.tool_change, ToolChange::T);
    assert!((machine.zero_offsets["G54"].translation[Axis::C] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert_eq!(machine.tool(3, 1).unwrap().length_mm, [100.0, 1.0, 2.0]);
    assert!((errors.location[0].value + 2e-3).abs() < 1e-18 && (errors.location[1].value - 3e-5).abs() < 1e-18);
    let EntryFunction::Table(table) = &errors.motion[0].function else { panic!("{:?}", errors.motion[0]) };
    assert!((table.value(std::f64::consts::FRAC_PI_2) - 2.5e-6).abs() < 1e-18);
    let EntryFunction::Periodic(periodic) = &errors.motion[1].function else { panic!("{:?}", errors.motion[1]) };
    assert!((periodic.value(0.0) - 2e-3).abs() < 1e-17 && periodic.value(std::f64::consts::FRAC_PI_2).abs() < 1e-17);
    let EntryFunction::Piecewise(piecewise) = &errors.motion[2].function else { panic!("{:?}", errors.motion[2]) };
    assert!((piecewise.value(200.0) - (2e-3 + 3e-4)).abs() < 1e-17);
    let EntryFunction::Backlash(backlash) = &errors.motion[3].function else { panic!("{:?}", errors.motion[3]) };
    assert_eq!(backlash.value(0.0, -1), -3e-3);
}

#[test]
fn tables_and_knots_must_fit() {
    let with = |entry: &str| seen(&format!("{SMALL}[[motion]]\ncomponent = \"EXX\"\n{entry}"));
    let one = |code: &str, at: &str| vec![(code.to_owned(), at.to_owned())];
    assert_eq!(with("kind = \"table\"\npositions_mm = [0, 1]\nvalues_um = [0]\n"), one("E0408", "[0]"));
    assert_eq!(with("kind = \"table\"\npositions_mm = []\nvalues_um = []\n"), one("E0408", "[]"));
    assert_eq!(with("kind = \"table\"\npositions_mm = [0, 5, 4]\nvalues_um = [0, 1, 2]\n"), one("E0408", "4"));
    assert_eq!(with("kind = \"piecewise\"\ndegree = 1\ncoefficients = [0, 0, 1e-9]\n"), one("E0404", "[0, 0, 1e-9]"));
    let knots = "kind = \"piecewise\"\ncoefficients = [0]\nknots = [{ at_mm = 5, coefficients = [1] }, { at_deg = 9, coefficients = [1] }]\n";
    assert_eq!(with(knots)[0], ("E0407".to_owned(), "at_deg".to_owned()));
    assert_eq!(with("kind = \"backlash\"\nvalue_um = 1\nvalue_urad = 1\n"), one("E0407", "value_urad"));
    assert_eq!(with("kind = \"backlash\"\nvalue_um = 1\nextra = 1\n"), one("E0402", "extra"));
}

#[test]
fn backlash_and_grids_must_fit() {
    let with = |entry: &str| seen(&format!("{SMALL}[[motion]]\ncomponent = \"EXX\"\n{entry}"));
    let one = |code: &str, at: &str| vec![(code.to_owned(), at.to_owned())];
    let ends = |values: &str| with(&format!("kind = \"backlash\"\npositions_mm = [0, 700]\n{values}\n"));
    assert_eq!(ends("values_um = [4, 6]"), []);
    assert_eq!(ends("values_um = [4]"), one("E0408", "[4]"));
    assert_eq!(ends("values_urad = [4, 6]"), one("E0407", "values_urad"));
    assert_eq!(ends("values_um = [4, 6]\nvalue_um = 5"), one("E0402", "value_um"));
    assert_eq!(
        with("kind = \"backlash\"\npositions_deg = [0, 9]\nvalues_um = [4, 6]\n"),
        one("E0407", "positions_deg")
    );
    let grid = |rest: &str| with(&format!("kind = \"grid\"\npositions_mm = [0, 700]\n{rest}\n"));
    let on_c = |rest: &str| grid(&format!("with = \"C\"\nwith_positions_deg = [-90, 0, 90]\n{rest}"));
    assert_eq!(on_c("values_um = [[1, 2, 3], [4, 5, 6]]"), []);
    assert_eq!(on_c("values_um = [[1, 2, 3], [4, 5]]"), one("E0408", "[4, 5]"));
    assert_eq!(on_c("values_um = [[1, 2, 3]]"), one("E0408", "[[1, 2, 3]]"));
    assert_eq!(on_c("values_um = [1, 2, 3]"), one("E0404", "[1, 2, 3]"));
    assert_eq!(on_c("values_um = [[1, 2, 3], [4, 5, nan]]"), one("E0404", "[[1, 2, 3], [4, 5, nan]]"));
    assert_eq!(
        grid("with = \"C\"\nwith_positions_mm = [0, 9]\nvalues_um = [[1, 2], [3, 4]]"),
        one("E0407", "with_positions_mm")
    );
    assert_eq!(grid("with = \"C\"\nwith_positions_deg = [9, 9]\nvalues_um = [[1, 2], [3, 4]]"), one("E0408", "9"));
    assert_eq!(grid("with = \"C\"\nwith_positions_deg = []\nvalues_um = [[], []]"), one("E0408", "[]"));
    assert_eq!(grid("with = \"X\"\nwith_positions_mm = [0, 9]\nvalues_um = [[1, 2], [3, 4]]"), one("E0404", "\"X\""));
}

#[test]
fn a_set_up_replaces_and_adds_and_an_unsound_one_changes_nothing() {
    let mut machine = load(DEMO).0.unwrap().0;
    let before = machine.clone();
    let bad = apply_setup(&source(b"[zero_offset.G54]\nX_mm = 1\n[[tool]]\nnumber = 1\n[axis.X]\n"), &mut machine);
    assert_eq!(bad.iter().map(|finding| finding.code.as_str()).collect::<Vec<_>>(), ["W0404", "E0403", "E0402"]);
    assert_eq!(machine, before);
    let text = "[zero_offset.G54]\nX_mm = 1\n[zero_offset.G599]\nY_mm = 2\n\
        [[tool]]\nnumber = 5\nlength_mm = 77\n[[tool]]\nnumber = 5\nedge = 2\nlength_mm = 78\n";
    // An offset of the set-up takes the place of the whole one: what it does not state is 0, not what stood there.
    let found: Vec<String> =
        apply_setup(&source(text.as_bytes()), &mut machine).into_iter().map(|one| one.message).collect();
    let expected = [
        "G54 gives X but not Y and Z, which count as 0 unless a later --setup states them",
        "G599 gives Y but not X and Z, which count as 0 unless a later --setup states them",
    ];
    assert_eq!(found, expected);
    assert_eq!(machine.zero_offsets["G54"].translation.xyz(), Vector::new(1.0, 0.0, 0.0));
    assert_eq!(machine.zero_offsets["G599"].translation.xyz(), Vector::new(0.0, 2.0, 0.0));
    assert_eq!(machine.zero_offsets["G55"], before.zero_offsets["G55"]);
    assert_eq!(machine.tool(5, 1).unwrap().length_mm[0], 77.0);
    assert_eq!(machine.tool(5, 2).unwrap().length_mm[0], 78.0);
    assert_eq!(machine.tools.len(), before.tools.len() + 1);
}

/// Cutting, doubling and overwriting bytes of a sound file makes findings, never a panic, and never a machine with a number that is none.
#[test]
fn no_bytes_make_it_panic() {
    let mut seed = 1_u64;
    let mut random = |limit: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % limit
    };
    let sound = DEMO.as_bytes();
    for _ in 0..300 {
        let mut bytes = sound.to_vec();
        for _ in 0..=random(4) {
            let at = random(bytes.len());
            match random(4) {
                0 => bytes.truncate(at + 1),
                1 => bytes[at] = random(256) as u8,
                2 => drop(bytes.remove(at)),
                _ => bytes.insert(at, b"[]{}=\".,-0e\n"[random(12)]),
            }
        }
        let (machine, findings) = file::load(&source(&bytes));
        assert_eq!(machine.is_none(), findings.iter().any(Diagnostic::is_error));
        for finding in findings {
            assert!(finding.place.unwrap().span.range().end <= bytes.len() + 1);
        }
    }
    assert_eq!(seen("")[0].0, "E0403");
    assert!(file::load(&source(&[0xff, 0xfe, 0])).0.is_none());
    assert_eq!(seen("axis = 3\nmotion = 1\nlocation = []\nmachine = \"x\"\n").len(), 4);
}

#[test]
fn settings_of_radius_compensation() {
    let small = SMALL.replace("[machine]\n", "[machine]\ncontroller = \"fanuc\"\n");
    let control = |lines: &str| load(&format!("{small}[control]\n{lines}")).0.unwrap().0.control;
    assert_eq!(control("").compensation_start, CompensationStart::A);
    assert_eq!(control("").compensation_corner, None);
    let set = control("compensation_start = \"B\"\ncompensation_corner = \"circular\"\n");
    assert_eq!(set.compensation_start, CompensationStart::B);
    assert_eq!(set.compensation_corner, Some(CompensationCorner::Circular));
    let set = control("compensation_corner = \"linear\"\n");
    assert_eq!(set.compensation_corner, Some(CompensationCorner::Linear));
    let bad = seen(&format!("{small}[control]\ncompensation_start = \"C\"\ncompensation_corner = \"round\"\n"));
    let code = "E0404".to_owned();
    assert_eq!(bad, [(code.clone(), "\"C\"".to_owned()), (code, "\"round\"".to_owned())]);
}

#[test]
fn settings_of_iso_controls() {
    let small = SMALL.replace("[machine]\n", "[machine]\ncontroller = \"fanuc\"\n");
    let iso = |lines: &str| load(&format!("{small}[control]\n{lines}")).0.unwrap().0.control.iso;
    assert_eq!(iso("").decimal_point, None);
    assert_eq!(iso("decimal_point = \"increment\"\n").decimal_point, Some(DecimalPoint::Increment));
    assert_eq!(iso("length_compensation = \"C\"\n").length_axis, LengthAxis::Programmed);
    assert_eq!(iso("reference_point_2_X_mm = -3.5\n").reference_points.get(&(2, Axis::X)), Some(&-3.5));
    assert!(iso("dwell_turns = true\n").dwell_turns);
    let bad = seen(&format!("{small}[control]\ndecimal_point = \"point\"\nlength_compensation = \"D\"\n"));
    let code = "E0404".to_owned();
    assert_eq!(bad, [(code.clone(), "\"point\"".to_owned()), (code, "\"D\"".to_owned())]);
}

#[test]
fn keys_of_other_controls_are_reported() {
    let keys = "[control]\ntilt_about = \"tangent\"\ndecimal_point = \"calculator\"\ngrundig_mirror_outside = true\nrollover = \"none\"\n";
    let on = |controller: &str| {
        let head = format!("[machine]\ncontroller = \"{controller}\"\n");
        let found = seen(&format!("{}{keys}", SMALL.replace("[machine]\n", &head)));
        assert!(found.iter().all(|(code, _)| code == "W0406"), "{controller}: {found:?}");
        found.into_iter().map(|(_, key)| key).collect::<Vec<_>>()
    };
    assert_eq!(on("sinumerik"), ["decimal_point", "grundig_mirror_outside", "rollover"]);
    assert_eq!(on("fanuc"), ["tilt_about", "grundig_mirror_outside"]);
    assert_eq!(on("haas"), ["tilt_about", "grundig_mirror_outside"]);
    assert_eq!(on("rs274"), ["tilt_about", "decimal_point", "grundig_mirror_outside"]);
    assert_eq!(on("millplus"), ["tilt_about", "decimal_point"]);
}

#[test]
fn axes_that_are_passed_on_are_not_those_of_the_machine() {
    let bad = seen(&format!("{SMALL}[control]\npassed_on_axes = [\"W\", \"x\", \"1Q\"]\n"));
    assert_eq!(bad, [("E0404".to_owned(), "\"x\"".to_owned()), ("E0404".to_owned(), "\"1Q\"".to_owned())]);
}

#[test]
fn the_output_is_not_finer_than_the_words_that_a_control_reads() {
    // A Fanuc reads 0.001 mm unless it has IS-C: it would round the fourth decimal, and the tool would not be where the report says.
    let vmc = std::fs::read_to_string(crate::support::repository("samples/machines/vmc.toml")).unwrap();
    let without = vmc.replace("increment_system = \"IS-C\"\n", "");
    assert_ne!(vmc, without);
    let shop = Shop::new()
        .file("without.toml", &without)
        .file(
            "coarse.toml",
            without
                .replace("increment_mm = 0.0001", "increment_mm = 0.001")
                .replace("increment_deg = 0.0001", "increment_deg = 0.001"),
        )
        .file("part.nc", "O1\nG21 G90 G17 G54\nG0 X10. Y0. Z0.\nG1 X20. F100\nM30\n");
    shop.run(["part.nc", "-o", "plain.nc", "--machine", "without.toml"]).exits(0);
    let decimals = |word: &str| word.split_once('.').map_or(0, |(_, behind)| behind.len());
    let is_move = |line: &&str| line.starts_with("G0 X") || line.starts_with("G1 X");
    let written = shop.text("plain.nc");
    assert!(written.lines().filter(is_move).count() == 2 && written.contains('.'), "{written}");
    assert!(
        written.lines().filter(is_move).flat_map(|line| line.split(' ')).all(|word| decimals(word) <= 3),
        "{written}"
    );
    shop.run(["machine", "check", "coarse.toml"]).exits(0);
    shop.run(["part.nc", "-o", "out.nc", "--machine", "coarse.toml"]).exits(0);
    shop.run(["part.nc", "-o", "fine.nc", "--machine", "coarse.toml", "--increment", "0.1um"])
        .exits(2)
        .says("finer than 0.001 mm");
    assert!(!shop.names().contains(&"fine.nc".to_owned()));
    // A Sinumerik reads what MD10200 says; a third of a millimeter is no decimal.
    let demo = std::fs::read_to_string(crate::support::repository("samples/machines/demo.toml")).unwrap();
    let with = |per_mm: u32| demo.replacen("[control]\n", &format!("[control]\nincrements_per_mm = {per_mm}\n"), 1);
    assert!(with(7).contains("increments_per_mm = 7\n"), "the sample has [control]");
    let program = "N10 G90 G71 G17 G94 G54\nN20 T1 D1 M6\nN30 G0 X10.1234 Y20 Z50\nN40 G1 X33.3333 F500\nN50 M30\n";
    let shop = shop.file("thousand.toml", with(1000)).file("seven.toml", with(7)).file("part.mpf", program).file(
        "inch.mpf",
        program.replace("G71", "G70").replace("X33", "X3").replace("X10", "X1").replace("Y20 Z50", "Y1 Z2"),
    );
    for name in ["part.mpf", "inch.mpf"] {
        let out = format!("out_{name}");
        shop.run([name, "-o", &out, "--machine", "thousand.toml"]).exits(0);
        let written = shop.text(&out);
        let is_position = |word: &&str| word.starts_with(['X', 'Y', 'Z']);
        let positions: Vec<&str> =
            written.lines().skip(1).flat_map(|line| line.split(' ')).filter(is_position).collect();
        assert!(positions.len() > 3 && positions.iter().all(|word| decimals(word) <= 3), "{written}");
        assert!(positions.iter().any(|word| decimals(word) == 3), "{written}");
    }
    shop.run(["part.mpf", "-o", "fine.mpf", "--machine", "thousand.toml", "--increment", "0.1um"])
        .exits(2)
        .says("finer than");
    shop.run(["part.mpf", "-o", "no.mpf", "--machine", "seven.toml"]).says("a whole number that divides 1000000000");
    assert!(!shop.names().contains(&"no.mpf".to_owned()));
    // A Grundig reads what its file says.
    let mill = crate::support::machine("universal_mill");
    let shop = shop.file("part.pm", "%PM9001\nN9001\nN1 G54\nN2 G0 X0 Y0 Z0\nN3 G1 X1 F1000\nN4 M30\n");
    shop.run(["part.pm", "-o", "fine.pm", "--machine", &mill, "--increment", "0.1um"]).exits(2).says("finer than");
}

/// The chain of a mill with a travel of 500 mm in X, and errors below it.
fn with_errors(errors: &str) -> Vec<(String, String, String)> {
    let text = format!(
        "[machine]\nname = \"mill\"\ntopology = \"wXYFZSt\"\n[axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [0, 500]\n\
         [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 400]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 300]\n{errors}"
    );
    let found = load(&text).1.into_iter();
    found.map(|one| (one.code.as_str().to_owned(), one.message, one.help)).collect()
}

#[test]
fn a_number_in_another_unit_is_named_with_what_was_meant() {
    // 0.03 µrad over the longest travel, 500 mm, is 0.015 µm; 0.03 mm/m is 30 µrad.
    let found = with_errors("[location]\nEC0X = 0.03\n");
    assert_eq!(found.len(), 1, "{found:?}");
    let (code, message, help) = &found[0];
    assert!(code == "W0408" && message.contains("0.03 µrad is 0.015 µm over 500 mm"), "{message}");
    assert!(help.contains("mm/m, write 30;") && help.contains("rad, write 30000;"), "{help}");
    // 50 mm per mm over 500 mm is 25 m; 50 µm/m is 5e-5.
    let found = with_errors("[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 50]\n");
    assert_eq!(found.len(), 1, "{found:?}");
    let (code, message, help) = &found[0];
    assert!(code == "W0408" && message.contains("EXX is 25000000 µm at X = 500 mm"), "{message}");
    assert!(help.contains("if 50 is in µm/m, write 5e-5"), "{help}");
    // A reversal value in mm instead of µm would be small, one in nm large; a usual one is neither.
    assert!(with_errors("[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 8.0\n").is_empty());
    let found = with_errors("[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 14000.0\n");
    assert!(found.len() == 1 && found[0].0 == "W0408", "{found:?}");
}

#[test]
fn a_small_number_that_a_fit_has_found_is_no_mistake() {
    assert!(with_errors("[location]\nEC0X = 0.03\n[uncertainty]\nEC0X = 0.4\n").is_empty());
    assert!(with_errors("[location]\nEC0X = 0\n").is_empty());
    assert!(with_errors("[location]\nEC0X = 30\n").is_empty());
}
