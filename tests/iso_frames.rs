//! Mirror, scaling, rotation, polar coordinates, tilted planes and corners of Fanuc: the examples of the reference, and laws.

use ncfix_base::geometry::AxisVector;
use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::snc::Kind;

use crate::iso::{check, check_codes, elements, iso_machine, run};

#[test]
fn i14_tilted_planes_by_all_their_forms() {
    let forms = [
        "G68.2 X10. Y20. Z5. I90. J30. K0",
        // About X by J, then about Z of the workpiece by I.
        "G68.2 P1 Q123 X10. Y20. Z5. I30. J0 K90.",
        "G68.2 P2 Q1 X10. Y20. Z5.\nG68.2 P2 Q2 X10. Y30. Z5.\nG68.2 P2 Q3 X-17310.508 Y25. Z10005.",
        "G68.2 P3 Q1 X10. Y20. Z5. I0 J1. K0\nG68.2 P3 Q2 I0.5 J0 K0.8660254038",
        "G68.2 X10. Y20. Z5. I90. J0 K0\nG68.4 X0 Y0 Z0 I0 J30. K0",
    ];
    for form in forms {
        check(
            "fanuc",
            &format!(
                "N10 G17 G90 G54\n{form}\nN30 G53.1\nN40 G0 X0 Y0 Z0\nN50 G1 X10. F200.\nN60 Y10.\nN70 Z-4.\nN80 G69"
            ),
            &["G0 X10 Y20 Z5", "G1 X10 Y30 Z5 F200", "G1 X1.339746 Y30 Z10 F200", "G1 X-0.660254 Y30 Z6.535898 F200"],
        );
    }
}

/// Ends of the motions of a program, axis commands.
fn ends(text: &str) -> Vec<AxisVector> {
    let (elements, codes) = elements("fanuc", text, &iso_machine(), Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{text} {codes:?}");
    elements
        .iter()
        .filter_map(|element| match &element.kind {
            Kind::Move(step) => Some(step.target),
            _ => None,
        })
        .collect()
}

const CONTOUR: &str = "G1 X10. Y0 F100.
G2 X20. Y10. R10.
G3 X30. Y20. I10. J0
G1 X-5. Y7.
G91 X3. Y-1. Z2.
G90";

#[test]
fn a_frame_maps_every_end_of_a_contour() {
    let plain = ends(&format!("G90 G17 G0 X0 Y0 Z0\n{CONTOUR}"));
    let (sin, cos) = 25_f64.to_radians().sin_cos();
    type Map = fn(f64, f64, f64, f64, f64) -> [f64; 3];
    let cases: [(&str, &str, Map); 5] = [
        ("G68 X5. Y-3. R25.", "G69", |x, y, z, sin, cos| {
            [5.0 + (x - 5.0) * cos - (y + 3.0) * sin, -3.0 + (x - 5.0) * sin + (y + 3.0) * cos, z]
        }),
        ("G51 X1. Y2. Z3. P500", "G50", |x, y, z, _, _| {
            [1.0 + (x - 1.0) / 2.0, 2.0 + (y - 2.0) / 2.0, (z + 3.0) / 2.0]
        }),
        ("G51.1 Y4.", "G50.1", |x, y, z, _, _| [x, 8.0 - y, z]),
        ("G51 X0 Y0 Z0 I-1000 J1000 K1000", "G50", |x, y, z, _, _| [-x, y, z]),
        // A mirror, and a rotation within it that is mirrored with it.
        ("G51.1 X0\nG68 X0 Y0 R25.", "G69\nG50.1", |x, y, z, sin, cos| [-(x * cos - y * sin), x * sin + y * cos, z]),
    ];
    for (begin, end, map) in cases {
        let found = ends(&format!("G90 G17 G0 X0 Y0 Z0\n{begin}\nG0 X0 Y0 Z0\n{CONTOUR}\n{end}\nG0 X0 Y0 Z0"));
        assert_eq!(found.len(), plain.len() + 2, "{begin}");
        for (place, plain) in found[1..].iter().zip(&plain) {
            let [x, y, z] = map(plain.0[0], plain.0[1], plain.0[2], sin, cos);
            let off = (place.0[0] - x).hypot(place.0[1] - y).hypot(place.0[2] - z);
            assert!(off < 1e-9, "{begin}: {place:?} {x} {y} {z}");
        }
        assert_eq!(found.last(), Some(&AxisVector::ZERO), "{begin}");
    }
}

#[test]
fn all_ends_in_one_block_and_ending_nothing_is_nothing() {
    check(
        "fanuc",
        "G90 G17 G40 G49 G50 G50.1 G69 G80 G15
G0 X1. Y1. Z0
G51.1 X0
G51 X0 Y0 Z0 P3000
G68 X0 Y0 R90.
G0 X1. Y1.
G50.1 G50 G69
G0 X1. Y1.",
        // (1, 1): mirrored (-1, 1), scaled (-3, 3), turned by -90 degrees about the zero (3, 3).
        &["G0 X1 Y1 Z0", "G0 X3 Y3 Z0", "G0 X1 Y1 Z0"],
    );
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let begin = "G90 G17 G0 X0 Y0 Z0\n";
    for block in [
        "G68 X0 Y0",
        "G51 X0 Y0 Z0",
        "G51 X0 Y0 Z0 P0",
        "G51.1",
        "G12.1",
        "G68.2 P4 X0 Y0 Z0 I0 J0 K0",
        "G68.3 X0 Y0 Z0",
        "G68.4 X0 Y0 Z0 I0 J0 K0",
        "G68.2 P2 Q7 X0 Y0 Z0",
        "G53.1",
        "G51 X0 Y0 Z0 I2000 J1000 K1000\nG2 X10. Y0 R5. F100.",
    ] {
        let (_, codes) = run("fanuc", &format!("{begin}{block}"));
        assert_eq!(codes.len(), 1, "{block} {codes:?}");
    }
    // What is outer must not change within.
    check_codes("fanuc", &format!("{begin}G68 X0 Y0 R10.\nG51.1 X0"), &["E0201:3"]);
    check_codes("fanuc", &format!("{begin}G51 X0 Y0 Z0 P2000\nG51.1 X0"), &["E0201:3"]);
    check_codes("rs274", "G21 G90 F100\nG0 X0 Y0 Z0\nG7", &["E0201:3"]);
}
