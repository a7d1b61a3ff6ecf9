//! CYCLE800: programmed points of the tilted plane are reached by the tip in the workpiece, on machines of every kind.

use ncfix_base::geometry::{Axis, AxisVector, Matrix, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::Options as ExecOptions;
use ncfix_machine::machine::{Machine, Tool};
use ncfix_machine::snc::{Element, Kind};
use ncfix_model::{ErrorModel, Model};
use ncfix_path::path::CorrectionOptions;

use crate::bench_machine::load_machine;
use crate::flat::{check, execute};
use crate::frame_correction::check as check_correction;
use crate::machines::xyz_machine;
use crate::support::Shop;

/// A machine of a topology with its axes along F's directions; what carries the workpiece moves the other way.
pub(crate) fn machine(topology: &str) -> Machine {
    let mut text = format!("[machine]\nname = \"test\"\ntopology = \"{topology}\"\n");
    let foundation = topology.find('F').unwrap();
    for (at, letter) in topology.char_indices().filter(|(_, letter)| "XYZABC".contains(*letter)) {
        let axis = Axis::from_letter(letter as u8).unwrap();
        let mut direction = [0; 3];
        direction[axis.dimension()] = if at < foundation { -1 } else { 1 };
        let (travel, point) = if axis.is_rotary() {
            ("travel_deg = [-360, 360]", "point_mm = [30, -20, 60]")
        } else {
            ("travel_mm = [-2000, 2000]", "")
        };
        text += &format!("[axis.{letter}]\ndirection = {direction:?}\n{travel}\n{point}\n");
    }
    text += "[control]\nswivel_retract_z_mm = 400\n[zero_offset.G54]\nX_mm = 12\nY_mm = -7\nZ_mm = 33\n";
    let source = Source::new(FileId(0), "test.toml", text.into_bytes()).unwrap();
    let (result, findings) = ncfix_model::file::load(&source);
    let (mut machine, _) = result.unwrap_or_else(|| panic!("{findings:?}"));
    machine.tools = vec![Tool { number: 1, name: None, edge: 1, length_mm: [95.0, 0.0, 0.0], radius_mm: 5.0 }];
    machine
}

pub(crate) const KINDS: &[&str] =
    &["wCAYXFZSt", "wCBXFYZSt", "wYFXZCASt", "wFXYZCBSt", "wCXFYZBSt", "wCFXYZASt", "wBFXYZSt"];

/// Axis commands at the ends of the moves.
pub(crate) fn commands(elements: &[Element]) -> Vec<AxisVector> {
    let moves = elements.iter().filter_map(|element| match &element.kind {
        Kind::Move(motion) => Some(motion.target),
        _ => None,
    });
    moves.collect()
}

pub(crate) fn turned(axis: usize, degrees: f64) -> Matrix {
    let (s, c) = degrees.to_radians().sin_cos();
    match axis {
        0 => Matrix::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c),
        1 => Matrix::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c),
        _ => Matrix::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0),
    }
}

/// Where the tip is in the workpiece for a point of the zero offset G54 while the rotary axes stand at zero, by the forward model.
pub(crate) fn on_workpiece(machine: &Machine, model: &Model, point: Vector) -> Vector {
    let offset = machine.zero_offsets["G54"].frame(Default::default()).unwrap();
    let tool = Vector::new(0.0, 0.0, -95.0);
    let mut command = AxisVector::ZERO;
    command.set_xyz(point + offset.offset().xyz() - tool);
    model.nominal(&command, &tool).translation
}

#[test]
fn points_of_the_tilted_plane_are_met_on_every_machine() {
    let tool = Vector::new(0.0, 0.0, -95.0);
    for topology in KINDS {
        let machine = machine(topology);
        let model = Model::new(&machine, &ErrorModel::default());
        // X0 Y0 Z0, Y by 25 degrees (a machine with B alone can do it), X1 Y1 Z1.
        let tilts: &[(&str, Matrix)] = if *topology == "wBFXYZSt" {
            &[("54,10,20,30,25,0,0,1,2,3", turned(1, 25.0))]
        } else {
            &[
                ("54,10,20,30,25,0,0,1,2,3", turned(1, 25.0)),
                ("57,10,20,30,-15,20,40,1,2,3", turned(0, -15.0) * turned(1, 20.0) * turned(2, 40.0)),
                ("39,10,20,30,45,54.365,0,1,2,3", turned(2, 45.0) * turned(0, 54.365)),
            ]
        };
        for (arguments, rotation) in tilts {
            let rotary: Vec<String> =
                machine.axis_set().iter().filter(|a| a.is_rotary()).map(|a| format!("{a}0")).collect();
            let program = format!(
                "G17 G90 G71 G54\nT1 M6\nD1\nG0 X0 Y0 Z100 {}\nCYCLE800(0,\"TC1\",200000,{arguments},-1)\n\
                 G0 X5 Y6 Z7\nG1 X50 F500\nTRANS X1\nY-10 Z20\nATRANS Z5\nX0 Y0 Z0",
                rotary.join(" ")
            );
            let strict = ExecOptions { strict: true, ..ExecOptions::default() };
            let (elements, codes) = execute(&program, &machine, strict);
            assert!(codes.is_empty(), "{topology} {arguments}: {codes:?}");
            let commands = commands(&elements);
            let points = [[5.0, 6.0, 7.0], [50.0, 6.0, 7.0], [50.0, -10.0, 20.0], [1.0, 0.0, 5.0]];
            assert_eq!(commands.len(), 2 + points.len());
            for (command, point) in commands[2..].iter().zip(points) {
                let point =
                    rotation * (Vector::from(point) + Vector::new(1.0, 2.0, 3.0)) + Vector::new(10.0, 20.0, 30.0);
                let pose = model.nominal(command, &tool);
                let wanted = on_workpiece(&machine, &model, point);
                // TRANS has five decimals, AROT six: half of 1e-5 mm in three directions, half of 1e-6 degrees about three axes at 500 mm.
                assert!(
                    (pose.translation - wanted).norm() < 2e-5,
                    "{topology} {arguments}: {} {wanted}",
                    pose.translation
                );
                // The tool stands on the plane.
                let up = on_workpiece(&machine, &model, point + rotation * Vector::z()) - wanted;
                let axis = pose.rotation * Vector::z();
                assert!((axis - up).norm() < 1e-6, "{topology} {arguments}: {axis} {up}");
            }
        }
    }
}

#[test]
fn the_preferred_direction_chooses_between_two_ways() {
    let machine = machine("wCAYXFZSt");
    let start = "G17 G90 G71 G54 T1 M6\nD1\nG0 X0 Y0 Z0 A0 C0\n";
    for (direction, sign) in [(-1, -1.0), (1, 1.0)] {
        let program = format!("{start}CYCLE800(0,\"T\",0,57,0,0,0,30,0,0,0,0,0,{direction})\nG0 X1 Y1 Z1");
        let (elements, codes) = execute(&program, &machine, ExecOptions::default());
        assert_eq!(codes, ["W0302:1"; 0], "{codes:?}");
        let a = commands(&elements).last().unwrap()[Axis::A].to_degrees();
        assert!((a - sign * 30.0).abs() < 1e-9, "{direction}: {a}");
    }
}

#[test]
fn swivels_add_up_and_end() {
    let machine = xyz_machine();
    // Without rotary axes the frame alone.
    let program = "TRANS X5\nCYCLE800(0,\"\",0,57,10,0,0,0,0,90,0,0,0,0)\nG0 X1 Y0\nCYCLE800(0,\"\",1,57,2,0,0,0,0,90,0,0,0,0)\nG0 X1 Y0\n\
                   TRANS Y1\nG0 X0 Y0\nTRANS\nG0 X0 Y0\nCYCLE800()\nG0 X0 Y0";
    check(program, &machine, "G0 X10 Y1\nG0 X9 Y2\nG0 X10 Y1\nG0 X10 Y2\nG0 X0 Y0");
}

#[test]
fn retraction_goes_where_the_machine_file_says() {
    let machine = machine("wCAYXFZSt");
    let start = "G17 G90 G71 G54 T1 M6\nD1\nG0 X0 Y0 Z0 A0 C0\n";
    let program =
        format!("{start}CYCLE800(1,\"T\",0,57,0,0,0,30,0,0,0,0,0,1)\nCYCLE800(5,\"T\",0,57,0,0,0,0,0,0,0,0,0,1,50)");
    let (elements, codes) = execute(&program, &machine, ExecOptions::default());
    assert!(codes.is_empty(), "{codes:?}");
    let z: Vec<f64> = commands(&elements).iter().map(|command| command[Axis::Z]).collect();
    // The zero offset and the tool length; the machine position of the axis; 50 mm farther along the tool.
    let wanted = [128.0, 400.0, 400.0, 450.0, 450.0];
    assert_eq!(z.len(), wanted.len());
    assert!(z.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-9), "{z:?}");
}

#[test]
fn what_cannot_be_swivelled_is_refused() {
    let machine = machine("wCAYXFZSt");
    let mut short = machine.clone();
    short.axes[Axis::A.slot()].as_mut().unwrap().travel = Some([-0.1, 0.1]);
    let start = "G17 G90 G71 G54 T1 M6\nD1\nG0 X0 Y0 Z0 A0 C0\n";
    for (machine, call) in [
        (&short, "CYCLE800(0,\"T\",0,57,0,0,0,30,0,0,0,0,0,1)"),
        (&machine, "CYCLE800(0,\"T\",0,57,0,0,0,30,0,0,0,0,0,0)"),
        (&machine, "CYCLE800(2,\"T\",0,57,0,0,0,30,0,0,0,0,0,1)"),
        (&machine, "CYCLE800(0,\"T\",10,57,0,0,0,30,0,0,0,0,0,1)"),
        (&machine, "CYCLE800(0,\"T\",0,192,0,0,0,30,0,0,0,0,0,1)"),
        (&xyz_machine(), "CYCLE800(0,\"T\",0,57,0,0,0,30,0,0,0,0,0,1)"),
    ] {
        let start = if machine.axis(Axis::A).is_some() { start } else { "G54\n\n\n" };
        assert_eq!(execute(&format!("{start}{call}"), machine, ExecOptions::default()).1, ["E0235:4"], "{call}");
    }
    let program = format!("{start}CYCLE800(0,\"T\",0,57,0,0,0,30,0,0,0,0,0,1)\nG500\n$P_PFRAME=CTRANS(X,1)\nROT Z30");
    assert_eq!(execute(&program, &machine, ExecOptions::default()).1, ["E0235:5", "E0235:6"]);
}

/// On a machine with errors: the output has the turned axes and the frame in place of the call.
#[test]
fn a_swivelled_program_is_corrected() {
    let (machine, errors) = load_machine("esmaeili_xyz5");
    let middle = |axis| {
        let [low, high] = machine.axis(axis).unwrap().travel.unwrap();
        (low + high) / 2.0
    };
    let names: Vec<Axis> = machine.axis_set().iter().filter(|axis| axis.is_rotary()).collect();
    // About the axis that tilts, the way that leaves the other one where it is.
    let mode = if names[0] == Axis::A { 57 } else { 54 };
    let [x, y, z] = [Axis::X, Axis::Y, Axis::Z].map(middle);
    let program = |direction| {
        format!(
            "G17 G90 G71\nG0 X{x} Y{y} Z{z} {}0 {}0\nCYCLE800(0,\"T\",0,{mode},{x},{y},{z},5,0,0,0,0,0,{direction})\n\
             G0 X0 Y0 Z0\nG1 X30 F500\nY20 Z-2\nG3 X10 Y40 I-20\nTRANS X5\nG1 X0 Y0\nM30\n",
            names[0], names[1]
        )
    };
    let is_short = |program: &String| {
        let (elements, _) = execute(program, &machine, ExecOptions::default());
        commands(&elements)[1][names[1]].abs() < 1e-9
    };
    let program = [program(-1), program(1)].into_iter().find(is_short).unwrap();
    let options = CorrectionOptions { max_correction_mm: 2.0, ..CorrectionOptions::default() };
    let done = check_correction(&program, &machine, &errors, &options);
    assert!(
        !done.text.contains("CYCLE800(0") && done.text.contains("TRANS X") && done.text.contains("SUPA"),
        "{}",
        done.text
    );
}

/// A plane that an earlier job has not ended is in system frames of the control, which TRANS does not delete.
#[test]
fn the_output_ends_a_plane_of_an_earlier_job() {
    let machine = crate::support::machine("esmaeili_huron");
    let start = "N10 G17 G90 G71 G94\nN20 CYCLE800()\nN30 G0 X0 Y0 Z200 A0 C0\n";
    let end = "N50 G1 X20 F500\nN60 G0 Z200\n";
    let plane = "N40 CYCLE800(0,\"\",0,57,0,0,0,45,0,0,0,0,0,-1)\n";
    let shop = Shop::new()
        .file("flat.mpf", format!("{start}{end}N90 M30\n"))
        .file("tilted.mpf", format!("{}{plane}{end}N70 CYCLE800()\nN90 M30\n", start.replace("N20 CYCLE800()\n", "")));
    for (name, order) in
        [("flat.mpf", &["CYCLE800()", "G1 "][..]), ("tilted.mpf", &["CYCLE800()", "AROT", "G1 ", "CYCLE800()", "M30"])]
    {
        shop.run([name, "-o", "out.mpf", "--machine", &machine]).exits(0);
        let text = shop.text("out.mpf");
        let mut rest = text.as_str();
        for word in order {
            let at = rest.find(word);
            assert!(at.is_some(), "{word} is missing or too early:\n{text}");
            rest = &rest[at.unwrap_or(0) + word.len()..];
        }
        shop.run(["verify", name, "out.mpf", "--machine", &machine]).exits(0);
    }
}

#[test]
fn a_plane_without_shift_is_turned_in_the_output_too() {
    // Zero offset and pivot are one point: the frame is a rotation only.
    let program = "N10 G17 G90 G71 G94\nN20 G0 X0 Y0 Z200 A0 C0\nN30 CYCLE800(0,\"\",0,57,0,0,0,45,0,0,0,0,0,-1)\n\
        N40 G0 X0 Y0 Z100\nN50 G1 X20 Y0 F500\nN60 Y20\nN70 G0 Z200\nN80 CYCLE800()\nN90 M30\n";
    let machine = crate::support::machine("esmaeili_huron");
    let shop = Shop::new().file("part.mpf", program);
    shop.run(["part.mpf", "-o", "out.mpf", "--machine", &machine]).exits(0);
    let text = shop.text("out.mpf");
    assert!(text.contains("AROT Z"), "{text}");
    for line in text.lines().filter(|line| line.contains("TRANS ") || line.contains("ROT ")) {
        let most = if line.contains("TRANS ") { 5 } else { 6 };
        let decimals = line.split_whitespace().filter_map(|word| word.split_once('.')).map(|(_, part)| part.len());
        assert!(decimals.max().unwrap_or(0) <= most, "{line}\n{text}");
    }
    shop.run(["verify", "part.mpf", "out.mpf", "--machine", &machine]).exits(0);
}

#[test]
fn a_transformation_in_a_swivelled_plane_is_refused() {
    let text = "G0 X0 Y0 Z200 A0 C0\nCYCLE800(0,\"\",0,57,0,0,0,20,0,0,0,0,0,-1)\nTRAORI\nM30\n";
    assert_eq!(execute(text, &machine("wCAYXFZSt"), ExecOptions::default()).1, ["E0235:3"]);
}
