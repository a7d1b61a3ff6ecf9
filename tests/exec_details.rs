//! Details of the languages that a control's manual states and that are easily got the wrong way round, each worked out by hand.

use ncfix_base::geometry::{Axis, Vector};
use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::machine::{Tool, ToolChange};
use ncfix_machine::snc::{Dwell, Kind};

use crate::flat::execute;
use crate::iso::{check_codes, elements, iso_machine};
use crate::iso_core::written;
use crate::machines::xyz_machine;
use crate::{flat, grundig, modes};

fn strict() -> Options {
    Options { strict: true, ..Options::default() }
}

/// Sinumerik, NC programming (12/2019), 3.13.3.4: lengths 1, 2, 3 of a milling tool lie along Z Y X in G17, Y X Z in G18, X Z Y in G19.
#[test]
fn lengths_of_a_tool_turn_with_the_plane() {
    let mut machine = xyz_machine();
    machine.control.tool_change = ToolChange::T;
    machine.tools.push(Tool { number: 5, name: None, edge: 1, length_mm: [100.0, 20.0, 3.0], radius_mm: 5.0 });
    for (plane, wanted) in [
        ("G17", Vector::new(-3.0, -20.0, -100.0)),
        ("G18", Vector::new(-20.0, -100.0, -3.0)),
        ("G19", Vector::new(-100.0, -3.0, -20.0)),
    ] {
        let (elements, codes) = execute(&format!("{plane} T5 D1\nG0 X1 Y2 Z3"), &machine, strict());
        assert!(codes.is_empty(), "{codes:?}");
        let mut setups = elements.iter().filter_map(|element| match &element.kind {
            Kind::Setup(setup) => Some(setup.tool_mm),
            _ => None,
        });
        assert_eq!(setups.next_back(), Some(wanted), "{plane}");
    }
}

#[test]
fn an_intermediate_point_in_inch_is_in_inch() {
    flat::check("G70 G0 X1\nCIP X-1 Y0 I1=0 J1=1 F1", &xyz_machine(), "G0 X25.4\nG3/17 X-25.4 I-25.4");
}

#[test]
fn what_a_control_knows_of_its_tools() {
    let mut machine = xyz_machine();
    machine.tools.push(Tool { number: 7, name: Some("MILL".into()), edge: 1, length_mm: [0.0; 3], radius_mm: 5.0 });
    flat::check("G0 X=$P_TOOLEXIST[7] Y=$P_TOOLEXIST[8] Z=$TC_TP2[7]==\"MILL\"", &machine, "G0 X1 Y0 Z1");
}

#[test]
fn a_return_to_the_start_of_the_program_is_refused_and_one_that_is_not_is_none() {
    assert_eq!(modes::codes("G90 G0 X1\nRET(,,,TRUE)"), ["E0201"]);
    assert_eq!(modes::codes("G90 G0 X1\nRET(,,,FALSE)"), [""; 0]);
}

/// A swivelled plane replaces the one before; an additive one stands on it. 30 and 30 degrees about X from zero, on a machine of three axes.
#[test]
fn a_new_plane_stands_on_the_old_one_only_where_that_is_asked_for() {
    let end = |mode: u32| {
        let program = format!(
            "G17 G90\\nCYCLE800(0,\"\",0,57,0,0,0,0,0,30,0,0,0,0)\\nCYCLE800(0,\"\",{mode},57,0,0,0,0,0,30,0,0,0,0)\\nG0 X1 Y0 Z0"
        );
        let (elements, codes) = execute(&program.replace("\\n", "\n"), &xyz_machine(), Options::default());
        assert!(codes.is_empty(), "{codes:?}");
        flat::moves(&elements, Default::default()).last().unwrap().1.target.xyz()
    };
    let at = |degrees: f64| Vector::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
    assert!((end(0) - at(30.0)).norm() < 1e-9, "{}", end(0));
    assert!((end(1) - at(60.0)).norm() < 1e-9, "{}", end(1));
}

#[test]
fn a_rounding_under_unequal_factors_is_no_circle() {
    let text =
        |factors: &str| format!("G90 G17 G0 X0 Y0 Z0\nG51 X0 Y0 Z0 {factors}\nG1 X10. ,R2. F100.\nY10.\nG50\nM30");
    check_codes("fanuc", &text("I2. J1. K1."), &["E0201:3"]);
    check_codes("fanuc", &text("I2. J2. K2."), &[]);
}

#[test]
fn the_length_in_force_is_a_variable_of_a_fanuc() {
    let mut machine = iso_machine();
    machine.tools.push(Tool { number: 5, name: None, edge: 1, length_mm: [80.0, 0.0, 0.0], radius_mm: 4.0 });
    let text = "G21 G90 G17\nG43 H5 G0 X0 Y0 Z100.\nX#5083 Y#5082";
    let (lines, codes) = crate::iso::run_with("fanuc", text, &machine, Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    assert!(lines.last().unwrap().starts_with("G0 X80 Y0 "), "{lines:?}");
}

#[test]
fn dwells_count_turns_where_the_control_says_so() {
    let mut machine = iso_machine();
    let dwells = |machine: &ncfix_machine::machine::Machine, text: &str| -> Vec<Dwell> {
        let (found, codes) = elements("fanuc", text, machine, Box::new(NoLibrary), Options::default());
        assert!(codes.is_empty(), "{codes:?}");
        let dwell = |kind: &Kind| if let Kind::Dwell(dwell) = kind { Some(*dwell) } else { None };
        found.iter().filter_map(|element| dwell(&element.kind)).collect()
    };
    let text = "G21 G90 G94\nG4 P2000\nG95\nG4 P2000\nM30";
    assert_eq!(dwells(&machine, text), [Dwell::Seconds(2.0), Dwell::Seconds(2.0)]);
    machine.control.iso.dwell_turns = true;
    assert_eq!(dwells(&machine, text), [Dwell::Seconds(2.0), Dwell::Turns(2.0)]);
}

#[test]
fn where_nothing_was_probed_the_result_is_known() {
    let codes = |text: &str| crate::iso::run_with("rs274", text, &iso_machine(), Box::new(NoLibrary), strict()).1;
    assert!(codes("G21 G90 G54\nG0 X[#5061+1] Y0 Z0\nM2").is_empty());
    assert_eq!(codes("G21 G90 G54 F100\nG0 X0 Y0 Z10\nG38.2 Z-10\nG0 X[#5061+1]\nM2").len(), 1);
}

#[test]
fn a_shift_of_zeros_reaches_the_control() {
    let lines = written("fanuc", "", "G21 G90 G54\nG52 X5. Y1.\nG0 X1. Y0. Z0.\nG52 X0. Y0.\nG0 X1.\nM30");
    assert!(lines.iter().any(|line| line == "G52 X0. Y0."), "{lines:?}");
    assert!(!lines.iter().any(|line| line.starts_with("G52 X5")), "{lines:?}");
}

#[test]
fn overrides_come_back_one_by_one() {
    let lines = written("rs274", "", "G21 G90 F100\nG0 X0 Y0 Z0\nM70\nM51 P0\nM72\nM2\n");
    let behind = lines.iter().skip_while(|line| !line.starts_with("M51 P0")).skip(1);
    assert!(behind.clone().any(|line| line.contains("M51 P1")), "{lines:?}");
    let lines = written("rs274", "", "G21 G90 F100\nG0 X0 Y0 Z0\nM70\nM50 P0\nM72\nM2\n");
    assert!(lines.iter().any(|line| line.contains("M50 P1")), "{lines:?}");
}

#[test]
fn the_arc_tangent_of_a_grundig_is_in_degrees() {
    let (lines, codes) = grundig::run("%PM9001\nN9001\nN1 G17 G90 G54\nN2 E1=ATAN(1)\nN3 G0 X=E1 Y0 Z0");
    assert!(codes.is_empty(), "{codes:?}");
    // G54 is at X100 Y50.
    assert!(lines.last().unwrap().starts_with("G0 X145 Y50"), "{lines:?}");
}

/// G84 ends at the second clearance B above the first, where there is one.
#[test]
fn tapping_on_a_grundig_ends_at_the_second_clearance() {
    let levels = |words: &str| -> Vec<String> {
        let text = format!(
            "%PM9001\nN9001\nN1 G17 G90 G53 S500 M3\nN2 G0 X0 Y0 Z50\nN3 G84 Y2 {words}Z-10 J1\nN4 G79 X0 Y0 Z0"
        );
        let (lines, codes) = grundig::run(&text);
        // Whether it is rigid depends on the control.
        assert_eq!(codes, ["W0207:5"]);
        let at = |line: &String| line.split(' ').find(|word| word.starts_with('Z')).map(str::to_owned);
        let moves = lines.iter().filter(|line| line.starts_with("G0") || line.starts_with("G1"));
        moves.filter_map(at).collect()
    };
    assert_eq!(levels("B7 ")[1..], ["Z2", "Z-10", "Z2", "Z9"]);
    assert_eq!(levels("")[1..], ["Z2", "Z-10", "Z2"]);
}

/// In a square pocket the tool has no straight way in the middle to begin with.
#[test]
fn no_cycle_of_a_grundig_moves_to_where_it_stands() {
    let mut machine = grundig::mill();
    machine.tools.push(grundig::tool(1, 0.0, 5.0));
    for width in [40.0, 60.0] {
        let text = format!(
            "%PM9001\nN9001\nN1 G17 G90 G53 T1 M6\nN2 G0 X0 Y0 Z50\nN3 G87 X40 Y{width} Z-4 B2 R6 I70 K4 F200\nN4 G79 X0 Y0 Z0"
        );
        let (lines, codes) = grundig::run_on(&text, &machine, Box::new(NoLibrary), Options::default());
        assert!(codes.is_empty(), "{codes:?}");
        let places: Vec<_> =
            lines.iter().filter(|line| line.starts_with('G')).map(|line| grundig::words(line).1).collect();
        let place =
            |words: &std::collections::BTreeMap<char, f64>| ['X', 'Y', 'Z'].map(|axis| words.get(&axis).copied());
        let stands = places.windows(2).filter(|pair| place(&pair[0]) == place(&pair[1]) && !pair[1].contains_key(&'I'));
        assert_eq!(stands.count(), 0, "{lines:#?}");
    }
}

/// Fanuc, B-64484: P1 of G53.1 takes the larger angle of the tilting axis, P2 the smaller one; both put the tool on the plane.
#[test]
fn of_two_ways_onto_a_plane_the_program_may_choose() {
    let machine = crate::swivel::machine("wCAYXFZSt");
    let tilt_deg = |choice: &str| {
        let text = format!(
            "G17 G90 G21 G54\nG43 H1\nG0 X0 Y0 Z100. A0 C0\nG68.2 X0 Y0 Z0 I30. J25. K-10.\nG53.1{choice}\nG0 X5. Y6. Z7."
        );
        let (found, codes) = elements("fanuc", &text, &machine, Box::new(NoLibrary), strict());
        assert!(codes.is_empty(), "{codes:?}");
        crate::swivel::commands(&found).last().unwrap()[Axis::A].to_degrees()
    };
    let (one, other) = (tilt_deg(" P1"), tilt_deg(" P2"));
    assert!((one - 25.0).abs() < 1e-9 && (other + 25.0).abs() < 1e-9, "{one} {other}");
    check_codes("fanuc", "G17 G90 G21\nG53.1", &["E0210:2"]);
}

/// G43.1 is the length that it names, whatever was before; G43.2 adds to it.
#[test]
fn lengths_by_words_replace_and_add() {
    let height = |lengths: &str| {
        let (lines, codes) = crate::iso::run("rs274", &format!("G21 G90 G17\nG0 X0 Y0 Z0\n{lengths}\nG0 Z1\nM2"));
        assert!(codes.is_empty(), "{codes:?}");
        lines
    };
    let axis_z = |lengths: &str| {
        let text = format!("G21 G90 G17\nG0 X0 Y0 Z0\n{lengths}\nG0 Z1\nM2");
        let (found, _) = elements("rs274", &text, &iso_machine(), Box::new(NoLibrary), Options::default());
        let mut setups = found.iter().filter_map(|element| match &element.kind {
            Kind::Setup(setup) => Some(setup.tool_mm.z),
            _ => None,
        });
        setups.next_back().unwrap()
    };
    assert_eq!(axis_z("G43.1 Z5\nG43.1 Z3"), -3.0);
    assert_eq!(axis_z("G43.1 Z5\nG43.1 Z3\nG43.2 Z2"), -5.0);
    assert!(!height("G43.1 Z5").is_empty());
}

#[test]
fn polar_words_need_to_know_what_they_count_from() {
    let codes = |words: &str| {
        crate::iso::run_with(
            "rs274",
            &format!("G21 G90 G54\nG0 {words} Z0\nM2"),
            &iso_machine(),
            Box::new(NoLibrary),
            strict(),
        )
        .1
    };
    assert_eq!(codes("@10 ^30"), [""; 0]);
    assert_eq!(codes("@10"), ["E0304:2"]);
    assert_eq!(codes("^30"), ["E0304:2"]);
    let grundig = |words: &str| {
        let text = format!("%PM9001\nN9001\nN1 G17 G90 G54\nN2 G9 X0 Y0\nN3 G0 {words}");
        grundig::run_on(&text, &grundig::mill(), Box::new(NoLibrary), strict()).1
    };
    assert_eq!(grundig("B2=30 L2=10"), [""; 0]);
    assert_eq!(grundig("B1=30 L1=10"), ["E0304:5"]);
}
