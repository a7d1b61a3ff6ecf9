//! G68.2 and G53.1 of Fanuc: programmed points of the tilted plane are reached by the tip in the workpiece, on machines of every kind.

use ncfix_base::geometry::{Matrix, Vector};
use ncfix_language::exec::{NoLibrary, Options};
use ncfix_model::{ErrorModel, Model};

use crate::iso::elements;
use crate::swivel::{KINDS, commands, machine, on_workpiece, turned};

fn strict() -> Options {
    Options { strict: true, ..Options::default() }
}

#[test]
fn points_of_the_tilted_plane_are_met_on_every_machine() {
    let tool = Vector::new(0.0, 0.0, -95.0);
    for topology in KINDS {
        let machine = machine(topology);
        let model = Model::new(&machine, &ErrorModel::default());
        // A machine with B alone can only tilt about Y: by I 90, J, K -90.
        let forms: &[(&str, Matrix)] = if *topology == "wBFXYZSt" {
            &[("I90. J25. K-90.", turned(2, 90.0) * turned(0, 25.0) * turned(2, -90.0))]
        } else {
            &[
                ("I30. J25. K-10.", turned(2, 30.0) * turned(0, 25.0) * turned(2, -10.0)),
                ("P1 Q123 I20. J-15. K40.", turned(2, 40.0) * turned(1, -15.0) * turned(0, 20.0)),
            ]
        };
        let rotary: String =
            machine.axis_set().iter().filter(|axis| axis.is_rotary()).map(|axis| format!(" {axis}0")).collect();
        for (words, rotation) in forms {
            let program = format!(
                "G17 G90 G21 G54\nG43 H1\nG0 X0 Y0 Z100.{rotary}\nG68.2 X10. Y20. Z30. {words}\nG53.1\n\
                 G0 X5. Y6. Z7.\nG1 X50. F500.\nY-10. Z20.\nG69\nG0 X0 Y0 Z0"
            );
            let (found, codes) = elements("fanuc", &program, &machine, Box::new(NoLibrary), strict());
            assert!(codes.is_empty(), "{topology} {words}: {codes:?}");
            let commands = commands(&found);
            let points = [[5.0, 6.0, 7.0], [50.0, 6.0, 7.0], [50.0, -10.0, 20.0]];
            assert_eq!(commands.len(), 2 + points.len() + 1, "{topology}");
            for (command, point) in commands[2..].iter().zip(points) {
                let point = rotation * Vector::from(point) + Vector::new(10.0, 20.0, 30.0);
                let pose = model.nominal(command, &tool);
                let wanted = on_workpiece(&machine, &model, point);
                assert!((pose.translation - wanted).norm() < 1e-6, "{topology} {words}: {} {wanted}", pose.translation);
                // The tool stands on the plane.
                let up = on_workpiece(&machine, &model, point + rotation * Vector::z()) - wanted;
                let along = pose.rotation * Vector::z();
                assert!((up - along).norm() < 1e-6, "{topology} {words}: {up} {along}");
            }
        }
    }
}

#[test]
fn a_correction_refuses_what_the_control_would_do_otherwise() {
    let machine = machine("wCAYXFZSt");
    let begin = "G17 G90 G21 G54\nG43 H1\nG0 X0 Y0 Z100. A0 C0\nG68.2 X0 Y0 Z0 I30. J25. K0\n";
    for (rest, line) in [
        // The tool was not put on the plane.
        ("G1 X10. F500.", 5),
        ("G53.1\nG49\nG1 X10. Y0 Z0 F500.", 7),
        ("G53.1\nG1 X10. C5. F500.", 6),
    ] {
        let program = format!("{begin}{rest}");
        let (_, codes) = elements("fanuc", &program, &machine, Box::new(NoLibrary), strict());
        assert_eq!(codes, [format!("E0201:{line}")], "{rest}");
    }
    for code in ["G52 X5.", "G55", "G92 X5.", "G10 L2 P1 X5."] {
        let (_, codes) = elements("fanuc", &format!("{begin}G53.1\n{code}"), &machine, Box::new(NoLibrary), strict());
        assert_eq!(codes, ["E0227:6"], "{code}");
    }
    // From a place that is not stated the rotary axes do not turn.
    let program = "G17 G90 G21 G54\nG43 H1\nG0 X0 Y0 Z100.\nG68.2 X0 Y0 Z0 I30. J25. K0\nG53.1";
    let (_, codes) = elements("fanuc", program, &machine, Box::new(NoLibrary), strict());
    assert_eq!(codes, ["E0304:5"]);
    // Out of reach: the head of this machine does not turn about X.
    let (_, codes) = elements(
        "fanuc",
        "G17 G90 G54\nG0 X0 Y0 Z0 B0\nG68.2 X0 Y0 Z0 I0 J25. K0\nG53.1",
        &crate::swivel::machine("wBFXYZSt"),
        Box::new(NoLibrary),
        strict(),
    );
    assert_eq!(codes, ["E0235:4"]);
}
