//! The text of the flat stream, read again, is the same stream.

use ncfix_base::geometry::{AXES, Axis, AxisVector};
use ncfix_language::exec::Options;
use ncfix_machine::snc::{Element, Kind, TextReader, TextWriter};
use proptest::prelude::*;

use crate::flat::execute;
use crate::machines::xyz_machine;
use crate::support::{Shop, machine};

/// Samples whose text holds all there is: arcs in three planes, turns, dwells, tools by name, five axes, splines, cycles.
const SAMPLES: &[(&str, &str)] = &[
    ("helix_bore.mpf", "demo"),
    ("seal_groove.mpf", "demo"),
    ("inch_plate.mpf", "demo"),
    ("cover.mpf", "demo"),
    ("spline.mpf", "demo"),
    ("gear_case.mpf", "demo"),
    ("swarf.mpf", "esmaeili_huron"),
];

#[test]
fn the_text_of_the_samples_is_printed_as_it_was_read() {
    for (program, name) in SAMPLES {
        let machine = machine(name);
        let shop = Shop::new().copy(&format!("samples/programs/sinumerik/{program}"));
        let first = shop.run(["snc", program, "--machine", &machine]).exits(0);
        assert!(first.stdout.lines().count() > 10, "{program}");
        let shop = shop.file("flat.snc", &first.stdout);
        let second = shop.run(["snc", "flat.snc", "--machine", &machine]).exits(0);
        assert!(first.stdout == second.stdout, "{program}");
    }
}

/// A block of a program that stays within the arithmetic of the text, six decimals.
fn block() -> impl Strategy<Value = String> {
    let value = || (-400_000_i32..400_000).prop_map(|micro| f64::from(micro) / 1000.0);
    prop_oneof![
        (value(), value(), value()).prop_map(|(x, y, z)| format!("G0 X{x} Y{y} Z{z}")),
        (value(), 1_u32..5000).prop_map(|(x, feed)| format!("G1 X{x} F{feed}")),
        (value(), value()).prop_map(|(y, z)| format!("G1 Y{y} Z{z}")),
        (value(), 1_u32..4, 17_u32..20).prop_map(|(r, turns, plane)| {
            let center = ["I", "K", "J"][plane as usize - 17];
            format!("G{plane} G{} {center}{} TURN={turns}", 2 + turns % 2, r.abs() + 1.0)
        }),
        (1_u32..900).prop_map(|tenths| format!("G4 F{}", f64::from(tenths) / 10.0)),
        (1_u32..20, 0_u32..9000).prop_map(|(tool, speed)| format!("T{tool} S{speed} M3")),
        (value(), value(), 0_u32..360).prop_map(|(x, y, angle)| format!("TRANS X{x} Y{y}\nAROT RPL={angle}")),
        Just("AMIRROR X0".to_owned()),
    ]
}

/// What of an element is in the text: what it is, where it goes to a millionth, and its line.
fn shown(element: &Element) -> (String, Vec<i64>, u32) {
    let millionths = |value: f64| (value * 1e6).round() as i64;
    let place = |position: &AxisVector| {
        AXES.into_iter()
            .map(|axis: Axis| millionths(if axis.is_rotary() { position[axis].to_degrees() } else { position[axis] }))
            .collect()
    };
    match &element.kind {
        Kind::Move(step) => {
            let arc = step.arc.map(|arc| (arc.plane, arc.clockwise, arc.extra_turns));
            let feed = if step.rapid { 0 } else { millionths(step.feed) };
            (format!("{} {arc:?} {feed}", step.rapid), place(&step.target), element.origin.line)
        }
        // After words read as before words: in a line of their own both are only words.
        Kind::Before(words) | Kind::After(words) => (format!("{words:?}"), Vec::new(), element.origin.line),
        other => (format!("{other:?}"), Vec::new(), element.origin.line),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_program_and_its_text_are_the_same_stream(blocks in prop::collection::vec(block(), 1..25)) {
        let program = format!("G17 G90 G71 G0 X0 Y0 Z0\nF100\n{}\nM30\n", blocks.join("\n"));
        let machine = xyz_machine();
        let (stream, findings) = execute(&program, &machine, Options::default());
        prop_assert!(findings.is_empty(), "{:?}\n{}", findings, program);
        let mut text = TextWriter::new(Vec::new(), "test", machine.axis_set(), |_, tool| *tool).unwrap();
        for element in &stream {
            text.write(element, &[]).unwrap();
        }
        let text = String::from_utf8(text.finish().unwrap()).unwrap();
        let read: Vec<Element> = TextReader::new(&text).map(Result::unwrap).collect();
        let written: Vec<_> = stream.iter().filter(|element| element.kind.is_in_text()).map(shown).collect();
        prop_assert_eq!(written, read.iter().map(shown).collect::<Vec<_>>());
    }
}
