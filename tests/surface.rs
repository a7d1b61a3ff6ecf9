//! LEAD, TILT and ORIPATH: the tool stands as the tangent of the path and the normal of the surface say, by vector arithmetic.

use ncfix_base::geometry::Vector;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Machine, OriPath, TiltAbout};
use ncfix_machine::snc::Kind;
use ncfix_model::{ErrorModel, Model, file};
use ncfix_path::path::CorrectionOptions;

use crate::bench_machine::load_machine;
use crate::five_axis::{chords, corrected, elements, execute, machine, targets, tip_in_program, topologies, with_tool};

const HEAD: &str = "N1 G17 G90 G54 T1 M6\nN2 TRAORI\nN3 ORIWKS ORIVECT\nN4 G0 X-20 Y10 Z5 A3=0.1 B3=0.2 C3=1\n";

/// The direction in the workpiece at the end of a line of the program.
fn direction(text: &str, line: u32, machine: &Machine) -> Vector {
    let model = Model::new(machine, &ErrorModel::default());
    let command = *targets(&elements(text, machine), line).last().unwrap();
    model.nominal(&command, &Vector::zeros()).rotation * machine.spindle.axis
}

/// Parts of the direction along the tangent, to the left of it on the surface, and along the normal.
///
/// LEAD puts the tool to (sin l, 0, cos l). About the normal TILT turns its shadow to the left; about the tangent it moves the upper end
/// to the right, (0, −sin t, cos t) of what LEAD left upright; where TILT comes first, LEAD shortens only the upright part.
fn parts(about: TiltAbout, lead: f64, tilt: f64) -> [f64; 3] {
    let ([sl, cl], [st, ct]) = ([lead.sin(), lead.cos()], [tilt.sin(), tilt.cos()]);
    match about {
        TiltAbout::Normal => [sl * ct, sl * st, cl],
        TiltAbout::Tangent => [sl, -cl * st, cl * ct],
        TiltAbout::TurnedTangent => [ct * sl, -st, ct * cl],
    }
}

fn expected(tangent: Vector, normal: Vector, parts: [f64; 3]) -> Vector {
    let (tangent, normal) = (tangent.normalize(), normal.normalize());
    tangent * parts[0] + normal.cross(&tangent) * parts[1] + normal * parts[2]
}

#[test]
fn lead_and_tilt_stand_on_tangent_and_normal() {
    for (mut machine, _) in topologies() {
        for about in [TiltAbout::Normal, TiltAbout::Tangent, TiltAbout::TurnedTangent] {
            machine.control.tilt_about = about;
            for (lead, tilt) in [(12.0_f64, 0.0_f64), (9.0, 25.0), (15.0, -10.0), (-4.0, 7.0)] {
                // Along (60, 20, 10), on a surface whose normal is at a right angle to it: (-1, -2, 10) · (60, 20, 10) = 0.
                let text = format!(
                    "{HEAD}ORIAXES\nN5 G1 F500 X40 Y30 Z15 A5=-1 B5=-2 C5=10 LEAD={lead} TILT={tilt}\nN6 G1 X50\n"
                );
                let angles = parts(about, lead.to_radians(), tilt.to_radians());
                let wanted = expected(Vector::new(60.0, 20.0, 10.0), Vector::new(-1.0, -2.0, 10.0), angles);
                let found = direction(&text, 6, &machine);
                assert!((found - wanted).norm() < 1e-9, "{} {about:?} {lead} {tilt}", machine.topology);
                // Without ORIPATH the tool keeps its direction.
                assert!((direction(&text, 7, &machine) - wanted).norm() < 1e-9, "{}", machine.topology);
            }
        }
    }
}

#[test]
fn the_tool_turns_along_a_great_circle_and_the_tip_follows_its_line() {
    for (machine, _) in topologies() {
        let text = format!("{HEAD}N5 G1 F500 X40 Y30 Z15 A5=-1 B5=-2 C5=10 LEAD=15 TILT=20\n");
        let elements = elements(&text, &machine);
        let model = Model::new(&machine, &ErrorModel::default());
        let first = Vector::new(0.1, 0.2, 1.0).normalize();
        let angles = parts(TiltAbout::Normal, 15_f64.to_radians(), 20_f64.to_radians());
        let last = expected(Vector::new(60.0, 20.0, 10.0), Vector::new(-1.0, -2.0, 10.0), angles);
        let plane = first.cross(&last).normalize();
        let whole = first.cross(&last).norm().atan2(first.dot(&last));
        let (from, way) = (Vector::new(-20.0, 10.0, 5.0), Vector::new(60.0, 20.0, 10.0));
        let pieces = chords(&elements, &machine, 5);
        assert!(pieces.len() > 3, "{}: {}", machine.topology, pieces.len());
        for piece in &pieces {
            let tip = tip_in_program(&model, &machine, piece);
            let share = (tip - from).dot(&way) / way.norm_squared();
            assert!((tip - from - way * share).norm() < 1e-9, "{}", machine.topology);
            let now = model.nominal(piece, &Vector::zeros()).rotation * machine.spindle.axis;
            assert!(now.dot(&plane).abs() < 1e-9, "{}", machine.topology);
            let turned = first.cross(&now).dot(&plane).atan2(first.dot(&now));
            assert!((turned - share * whole).abs() < 1e-9, "{}", machine.topology);
        }
    }
}

/// Normal and angles hold until others are programmed; the plane of the normal is that of the frame.
#[test]
fn oripath_turns_the_tool_with_every_block() {
    let z = Vector::z();
    for (machine, _) in topologies() {
        let text = format!(
            "{HEAD}N5 ORIPATH LEAD=10\nN6 G1 F500 X40\nN7 Y40\nN8 G3 X20 Y60 CR=20\nN9 G1 B4=0.1 C4=1 TILT=30 X0\nN10 X-10\nN11 ORIVECT \
             Y50 X-20\nN12 ORIPATH X-30 A4=0.3 C4=1 A5=0 B5=0.2 C5=1\n"
        );
        let lead = 10_f64.to_radians();
        let forward = |tangent: Vector| expected(tangent, z, [lead.sin(), 0.0, lead.cos()]);
        // The arc ends a quarter turn further, towards -X.
        for (line, tangent) in [(6, Vector::x()), (7, Vector::y()), (8, -Vector::x())] {
            let found = direction(&text, line, &machine);
            assert!((found - forward(tangent)).norm() < 1e-9, "{} {line}: {found:?}", machine.topology);
        }
        let both = parts(TiltAbout::Normal, lead, 30_f64.to_radians());
        let wanted = expected(-Vector::x(), Vector::new(0.0, 0.1, 1.0), both);
        for line in [9, 10, 11] {
            let found = direction(&text, line, &machine);
            assert!((found - wanted).norm() < 1e-9, "{} {line}: {found:?}", machine.topology);
        }
        let found = direction(&text, 12, &machine);
        assert!((found - expected(-Vector::x(), Vector::new(0.0, 0.2, 1.0), both)).norm() < 1e-9);
    }
}

#[test]
fn a_frame_turns_path_normal_and_tool_together() {
    let machine = machine("wFXYZCBSt");
    let angles = parts(TiltAbout::Normal, 20_f64.to_radians(), 35_f64.to_radians());
    for (frame, turn) in [
        // X of the program is Y of the machine.
        ("ROT Z90", (|v: Vector| Vector::new(-v.y, v.x, v.z)) as fn(Vector) -> Vector),
        ("MIRROR Y0", |v: Vector| Vector::new(v.x, -v.y, v.z)),
        ("ROT X30", |v: Vector| {
            let (sine, cosine) = 30_f64.to_radians().sin_cos();
            Vector::new(v.x, v.y * cosine - v.z * sine, v.y * sine + v.z * cosine)
        }),
    ] {
        let text = format!(
            "N1 G17 G90 G54 T1 M6\nN2 {frame}\nN3 TRAORI\nN4 G0 X0 Y0 Z0 A3=0 B3=0 C3=1\nN5 G1 F500 X30 Y40 A5=-0.4 B5=0.3 C5=1 LEAD=20 \
             TILT=35\n"
        );
        let wanted = turn(expected(Vector::new(3.0, 4.0, 0.0), Vector::new(-0.4, 0.3, 1.0), angles));
        let found = direction(&text, 5, &machine);
        assert!((found - wanted).norm() < 1e-9, "{frame}: {found:?} {wanted:?}");
    }
}

#[test]
fn what_is_not_known_is_refused() {
    let mut machine = machine("wCBXFZYSt");
    let cases = [
        ("N5 G1 F500 X30 LEAD=5 A3=0 B3=0 C3=1\n", "E0111"),
        ("N5 G1 F500 X30 LEAD=5 B20\n", "E0111"),
        ("N5 G1 F500 LEAD=5 B3=0.1 C3=1\n", "E0111"),
        ("N5 G1 F500 X30 A5=1 LEAD=5\n", "E0210"),
        ("N5 G1 F500 X30 A5=0 B5=0 C5=0 LEAD=5\n", "E0210"),
        ("N5 G1 F500 X30 LEAD=IC(5)\n", "E0210"),
        ("N5 G1 F500 X30 TILT=200\n", "E0210"),
        ("N5 G1 F500 X-20 LEAD=5\n", "E0210"),
        ("N5 ORIPATH\nN6 G1 F500 X30\n", "E0210"),
        ("N5 ORIPATH LEAD=5\nN6 G1 F500 X30 B10\n", "E0201"),
        ("N5 ORIPATH LEAD=5\nN6 G1 F500 X30 A3=0 C3=1\n", "E0201"),
        ("N5 ORIMKS\nN6 G1 F500 X30 LEAD=5\n", "E0201"),
        ("N5 G1 F500\nN6 POLY PO[X]=(10,2) PO[Y]=(20) LEAD=5\n", "E0201"),
        ("N5 TRAFOOF\nN6 LEAD=5\n", "E0210"),
        ("N5 TRAFOOF\nN6 G0 X1 A5=0 C5=1\n", "E0210"),
        ("N5 ORIPATHS\n", "E0201"),
    ];
    for (text, code) in cases {
        let (_, found) = execute(&format!("{HEAD}{text}"), &machine);
        let codes: Vec<&str> = found.iter().map(|finding| finding.code.as_str()).collect();
        assert_eq!(codes, [code], "{text}: {found:#?}");
        assert!(found[0].place.is_some());
    }
    machine.control.ori_path = OriPath::Path;
    let (_, found) = execute(&format!("{HEAD}N5 ORIPATH\n"), &machine);
    assert_eq!(found[0].code.as_str(), "E0201");
}

/// A block that only turns keeps its direction under ORIPATH, and a normal alone moves nothing.
#[test]
fn words_without_a_path_move_nothing() {
    let machine = machine("wCBXFZYSt");
    let text = format!("{HEAD}N5 ORIPATH LEAD=5 TILT=3\nN6 A5=0.1 B5=0 C5=1\nN7 G0 X-20\nN8 F300 A4=0.3 C4=1\n");
    let elements = elements(&text, &machine);
    for line in [5, 6, 8] {
        assert!(targets(&elements, line).is_empty(), "{line}");
    }
    assert_eq!(targets(&elements, 7), targets(&elements, 4));
}

/// The output says where the rotary axes stand, and neither LEAD nor the normals nor ORIPATH.
#[test]
fn the_output_states_what_lead_and_tilt_meant() {
    let text = "N1 G17 G90 G54 T1 M6\nN2 TRAORI\nN4 G0 X-20 Y10 Z60 A3=0.1 B3=0.2 C3=1\nN5 ORIPATH LEAD=12 TILT=8\nN6 G1 F500 X30 Y20 \
                A5=0.1 B5=0.1 C5=1\nN7 X35 Y50\nN8 TRAFOOF\nN9 G0 Z300\nN10 M30\n";
    let (machine, errors) = load_machine("esmaeili_huron");
    let machine = with_tool(machine);
    let options = CorrectionOptions { max_correction_mm: 0.5, ..CorrectionOptions::default() };
    let (out, prediction, commands) = corrected(text, &machine, &errors, &options);
    assert!(prediction.before().max_mm > 0.02 && prediction.after().max_mm < 1.2e-3, "{prediction:?}");
    for word in ["LEAD", "TILT", "ORIPATH", "A5", "C5"] {
        assert!(!out.contains(word), "{word}\n{out}");
    }
    assert!(out.contains("ORIVECT"));
    let again: Vec<_> = elements(&out, &machine)
        .iter()
        .filter_map(|element| if let Kind::Move(motion) = &element.kind { Some(motion.target) } else { None })
        .collect();
    assert_eq!(again.len(), commands.len(), "no piece is divided again");
    for (again, command) in again.iter().zip(&commands) {
        for axis in ncfix_base::geometry::AXES {
            assert!((again[axis] - command[axis]).abs() < 1e-9, "{axis}: {again:?} {command:?}");
        }
    }
}

#[test]
fn the_machine_file_says_what_tilt_and_oripath_mean() {
    let head = "[machine]\nname = \"a\"\ntopology = \"wFXSt\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n";
    let load = |control: &str| {
        let text = format!("{head}[control]\n{control}\n");
        file::load(&Source::new(FileId(0), "machine.toml", text.into_bytes()).unwrap())
    };
    for (text, about, ori_path) in [
        ("", TiltAbout::Normal, OriPath::End),
        ("tilt_about = \"normal\"\noripath = \"end\"", TiltAbout::Normal, OriPath::End),
        ("tilt_about = \"tangent\"\noripath = \"path\"", TiltAbout::Tangent, OriPath::Path),
        ("tilt_about = \"turned_tangent\"", TiltAbout::TurnedTangent, OriPath::End),
    ] {
        let (loaded, findings) = load(text);
        assert!(findings.is_empty(), "{text}: {findings:#?}");
        let control = loaded.unwrap().0.control;
        assert_eq!((control.tilt_about, control.ori_path), (about, ori_path), "{text}");
    }
    for text in ["tilt_about = \"axis\"", "oripath = \"always\"", "oripath = 1"] {
        let findings = load(text).1;
        assert_eq!(findings.len(), 1, "{text}: {findings:#?}");
    }
}
