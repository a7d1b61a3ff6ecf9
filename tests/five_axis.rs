//! Five-axis transformation: the tip on its line in the workpiece, the tool in its direction, and the way back out of the corrected text.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options as ExecOptions};
use ncfix_language::syntax;
use ncfix_machine::machine::{Kinematics, Machine, TipPath, Tool};
use ncfix_machine::snc::{Element, Kind, Turning};
use ncfix_model::{ErrorModel, Model};
use ncfix_path::emit::{self, Stamp, WriterOptions};
use ncfix_path::path::{CorrectionOptions, Corrector, FiveAxis, Increments, OutputFrame, Prediction};

use crate::bench_machine::{load_machine, tired};
use crate::model::machines;

const TOOL_MM: f64 = 150.0;

pub(crate) fn with_tool(mut machine: Machine) -> Machine {
    let tool = Tool { number: 1, name: None, edge: 1, length_mm: [TOOL_MM, 0.0, 0.0], radius_mm: 5.0 };
    machine.tools = vec![tool];
    machine.zero_offsets.clear();
    let mut g54 = AxisVector::ZERO;
    g54.set_xyz(Vector::new(4.0, -3.0, 2.0));
    machine.zero_offsets.insert("G54".into(), g54.into());
    machine.control.initial_zero_offset = Some("G500".into());
    for axis in machine.axes.iter_mut().flatten() {
        if !axis.axis.is_rotary() {
            axis.travel = Some([-2000.0, 2000.0]);
        }
    }
    machine
}

pub(crate) fn execute(text: &str, machine: &Machine) -> (Vec<Element>, Vec<Diagnostic>) {
    let source = Source::new(FileId(0), "test.mpf", text.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, ncfix_dialect::sinumerik());
    assert!(findings.is_empty(), "{findings:?}");
    let strict = ExecOptions { strict: true, ..ExecOptions::default() };
    let (mut elements, mut found) = (Vec::new(), Vec::new());
    for item in Execution::new(program, machine, Box::new(NoLibrary), strict) {
        match item {
            Ok(element) => elements.push(element),
            Err(finding) => found.push(finding),
        }
    }
    (elements, found)
}

pub(crate) fn targets(elements: &[Element], line: u32) -> Vec<AxisVector> {
    let of_line = elements.iter().filter(|element| element.origin.line == line);
    of_line
        .filter_map(|element| if let Kind::Move(motion) = &element.kind { Some(motion.target) } else { None })
        .collect()
}

/// The axis commands of a line, those of a path of the tip as chords that are straight in the axes.
pub(crate) fn chords(elements: &[Element], machine: &Machine, line: u32) -> Vec<AxisVector> {
    let kinematics = Kinematics::new(machine);
    let (mut tool_mm, mut last, mut out) = (Vector::zeros(), AxisVector::ZERO, Vec::new());
    for element in elements {
        match &element.kind {
            Kind::Setup(setup) => tool_mm = setup.tool_mm,
            Kind::Move(motion) => {
                let mut on_line = |command| out.extend((element.origin.line == line).then_some(command));
                match motion.tip {
                    Some(turning) => {
                        let arc = motion.arc.as_ref().map(|arc| (arc, motion.arc_basis.as_ref()));
                        let ends = [&last, &motion.target];
                        let path = TipPath::new(&kinematics, turning == Turning::Vector, ends, &tool_mm);
                        path.divide(arc, machine.control.chord_tolerance_mm, |command, _, _| on_line(command));
                    }
                    None => on_line(motion.target),
                }
                last = motion.target;
            }
            _ => {}
        }
    }
    out
}

pub(crate) fn elements(text: &str, machine: &Machine) -> Vec<Element> {
    let (elements, found) = execute(text, machine);
    assert!(found.is_empty(), "{found:#?}");
    elements
}

/// Corrects and writes.
pub(crate) fn corrected(
    text: &str,
    machine: &Machine,
    errors: &ErrorModel,
    options: &CorrectionOptions,
) -> (String, Prediction, Vec<AxisVector>) {
    let model = Model::new(machine, errors);
    let source = Source::new(FileId(0), "test.mpf", text.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, ncfix_dialect::sinumerik());
    assert!(findings.is_empty(), "{findings:?}");
    let strict = ExecOptions { strict: true, ..ExecOptions::default() };
    let execution = Execution::new(program, machine, Box::new(NoLibrary), strict);
    let mut corrector = Corrector::new(execution, machine, &model, options.clone());
    let stamp = Stamp { machine: "shop".into(), model: "0a".into(), source: "0b".into(), ..Stamp::default() };
    let increments = Increments::new(&machine.control);
    let writer_options = WriterOptions {
        names: machine.written_names(),
        increments,
        frame: options.frame,
        crlf: false,
        stamp,
        last_block_number: None,
        has_centers_reversed: false,
    };
    let mut writer = emit::writer("Sinumerik", &writer_options).unwrap();
    let mut commands = Vec::new();
    let mut out = Vec::new();
    let stream = corrector.by_ref().inspect(|item| {
        if let Ok(ncfix_path::path::Output::Piece(piece)) = item {
            commands.push(piece.command);
        }
    });
    emit::emit(&mut { stream }, writer.as_mut(), &mut out, |finding| panic!("{finding:?}")).unwrap();
    (String::from_utf8(out).unwrap(), corrector.prediction().clone(), commands)
}

pub(crate) fn machine(topology: &str) -> Machine {
    with_tool(machines().into_iter().find(|machine| machine.topology.to_string() == topology).unwrap())
}

/// The tip as the program means it: in G54, fixed to the workpiece.
pub(crate) fn tip_in_program(model: &Model, machine: &Machine, command: &AxisVector) -> Vector {
    let tool = Vector::new(0.0, 0.0, -TOOL_MM);
    model.nominal(command, &tool).translation - machine.spindle.origin_mm - Vector::new(4.0, -3.0, 2.0)
}

pub(crate) fn topologies() -> Vec<(Machine, [Axis; 2])> {
    let mut all = Vec::new();
    for topology in ["wCBXFZYSt", "wFXYZCBSt", "wFXYZBASt", "wCXFYZASt", "wUXYFVZCBSt"] {
        let machine = machine(topology);
        let rotary: Vec<Axis> = machine.axis_set().iter().filter(|axis| axis.is_rotary()).collect();
        all.push((machine, [rotary[0], rotary[1]]));
    }
    for sample in ["esmaeili_huron", "esmaeili_xyz5"] {
        let machine = with_tool(load_machine(sample).0);
        let rotary: Vec<Axis> = machine.axis_set().iter().filter(|axis| axis.is_rotary()).collect();
        all.push((machine, [rotary[0], rotary[1]]));
    }
    all
}

#[test]
fn the_tip_follows_its_line_while_rotary_axes_turn() {
    for (machine, [first, second]) in topologies() {
        let model = Model::new(&machine, &ErrorModel::default());
        let text = format!(
            "N1 G17 G90 G54 T1 M6\nN2 ORIAXES\nN3 TRAORI\nN4 G0 X-20 Y10 Z5 {first}5 {second}-10\nN5 G1 F500 X40 Y-30 Z25 {first}35 \
             {second}70\nN6 TRAFOOF\n"
        );
        let elements = elements(&text, &machine);
        let (start, pieces) = (targets(&elements, 4)[0], chords(&elements, &machine, 5));
        assert_eq!(targets(&elements, 5).len(), 1, "one move of the tip");
        let (from, to) = (Vector::new(-20.0, 10.0, 5.0), Vector::new(40.0, -30.0, 25.0));
        assert!((tip_in_program(&model, &machine, &start) - from).norm() < 1e-9, "{}", machine.topology);
        assert!((tip_in_program(&model, &machine, pieces.last().unwrap()) - to).norm() < 1e-9, "{}", machine.topology);
        let limit = machine.control.chord_tolerance_mm * 1.001;
        let mut last = start;
        for piece in &pieces {
            for k in 0..=20 {
                let command = last.lerp(piece, f64::from(k) / 20.0);
                // Rotary axes turn in proportion: they tell which part of the line it is.
                let share = (command[second] + 10_f64.to_radians()) / 80_f64.to_radians();
                let wanted = from + (to - from) * share;
                let off = (tip_in_program(&model, &machine, &command) - wanted).norm();
                assert!(off <= limit, "{}: {off}", machine.topology);
                let first_angle = 5_f64.to_radians() + share * 30_f64.to_radians();
                assert!((command[first] - first_angle).abs() < 1e-9);
            }
            last = *piece;
        }
        assert!((2..1000).contains(&pieces.len()), "{}: {} pieces", machine.topology, pieces.len());
    }
}

#[test]
fn vectors_turn_the_tool_along_a_great_circle() {
    for (machine, _) in topologies() {
        let model = Model::new(&machine, &ErrorModel::default());
        // Both directions are within reach of the 45° table, too.
        let text = "N1 G17 G90 G54 T1 M6\nN2 TRAORI\nN3 ORIWKS ORIVECT\nN4 G0 X0 Y0 Z20 A3=0.3 B3=0.2 C3=1\nN5 G1 F500 X30 Y10 Z10 \
                    A3=0.5 B3=-0.35 C3=0.8\n";
        let (elements, found) = execute(text, &machine);
        if machine.topology.to_string() == "wCXFYZASt" {
            // A turns the tool away from Y only; C on the table does the rest.
            assert!(found.is_empty(), "{found:?}");
        }
        assert!(found.is_empty(), "{}: {found:#?}", machine.topology);
        let direction = |command: &AxisVector| model.nominal(command, &Vector::zeros()).rotation * machine.spindle.axis;
        let (u, v) = (Vector::new(0.3, 0.2, 1.0).normalize(), Vector::new(0.5, -0.35, 0.8).normalize());
        let start = targets(&elements, 4)[0];
        assert!((direction(&start) - u).norm() < 1e-9);
        let pieces = chords(&elements, &machine, 5);
        assert!((direction(pieces.last().unwrap()) - v).norm() < 1e-9, "{}", machine.topology);
        let normal = u.cross(&v).normalize();
        let angle = u.cross(&v).norm().atan2(u.dot(&v));
        let (from, to) = (Vector::new(0.0, 0.0, 20.0), Vector::new(30.0, 10.0, 10.0));
        let limit = machine.control.chord_tolerance_mm * 1.001;
        let mut last = start;
        for piece in &pieces {
            for k in 0..=10 {
                let command = last.lerp(piece, f64::from(k) / 10.0);
                let now = direction(&command);
                assert!(now.dot(&normal).abs() < 1e-4, "{}: off the plane", machine.topology);
                let tip = tip_in_program(&model, &machine, &command);
                let share = (tip - from).dot(&(to - from)) / (to - from).norm_squared();
                assert!((tip - from - (to - from) * share).norm() <= limit, "{}", machine.topology);
                let turned = u.cross(&now).dot(&normal).atan2(u.dot(&now));
                assert!((turned - share * angle).abs() < 2e-4, "{}", machine.topology);
            }
            last = *piece;
        }
    }
}

/// `fix` with errors, the output executed again: the same axis commands, and the tool where it should be.
#[test]
fn the_corrected_program_is_one_with_traori_and_says_what_the_correction_meant() {
    let text = "N1 G17 G90 G54 T1 M6\nN2 TRAORI\nN3 ORIAXES\nN4 G0 X-20 Y10 Z60 A10 C-10\nN5 G1 F500 Z25 A30 C60\nN6 X30 Y20 C90\nN7 G3 \
                X0 Y50 CR=40 A20\nN8 TRAFOOF\nN9 G0 Z300\nN10 M30\n";
    let (machine, errors) = load_machine("esmaeili_huron");
    let machine = with_tool(machine);
    let options = CorrectionOptions { max_correction_mm: 0.5, ..CorrectionOptions::default() };
    let (out, prediction, commands) = corrected(text, &machine, &errors, &options);
    assert!(prediction.before().max_mm > 0.02 && prediction.after().max_mm < 1.2e-3, "{prediction:?}\n{out}");
    for word in ["TRAORI", "TRAFOOF", "ORIAXES", "N7 G3"] {
        assert!(out.contains(word), "{word}\n{out}");
    }
    let again: Vec<AxisVector> = elements(&out, &machine)
        .iter()
        .filter_map(|element| if let Kind::Move(motion) = &element.kind { Some(motion.target) } else { None })
        .collect();
    assert_eq!(again.len(), commands.len(), "no piece is divided again");
    // Behind the block that states all axes, up to TRAFOOF.
    for (k, (again, command)) in again.iter().zip(&commands).enumerate() {
        for axis in AXES {
            assert!((again[axis] - command[axis]).abs() < 1e-9, "{k} {axis}: {again:?} {command:?}");
        }
    }
}

#[test]
fn axes_take_the_place_of_the_transformation_where_that_is_wanted() {
    let text = "N1 G17 G90 G54 T1 M6\nN2 TRAORI\nN3 ORIAXES\nN4 G0 X-20 Y10 Z60 A10 C-10\nN5 G1 F500 Z25 A30 C60\nN8 TRAFOOF\nN10 M30\n";
    let (machine, errors) = load_machine("esmaeili_huron");
    let machine = with_tool(machine);
    let options = CorrectionOptions {
        max_correction_mm: 0.5,
        five_axis: FiveAxis::Axes,
        frame: OutputFrame::Machine,
        ..CorrectionOptions::default()
    };
    let (out, _, commands) = corrected(text, &machine, &errors, &options);
    assert!(!out.contains("TRA") && !out.contains("ORI") && out.contains("G153"), "{out}");
    let elements = elements(&out, &machine);
    let moves: Vec<_> =
        elements.iter().filter_map(|e| if let Kind::Move(motion) = &e.kind { Some(motion) } else { None }).collect();
    assert_eq!(moves.len(), commands.len());
    let model = Model::new(&machine, &ErrorModel::default());
    let tool = Vector::new(0.0, 0.0, -TOOL_MM);
    for (k, (motion, command)) in moves.iter().zip(&commands).enumerate() {
        for axis in AXES {
            assert!((motion.target[axis] - command[axis]).abs() < 1e-9, "{k} {axis}");
        }
        if k > 1 {
            // The feed of the axes brings the tip forward with F500.
            let (from, to) = (&moves[k - 1].target, &motion.target);
            let minutes = (to.xyz() - from.xyz()).norm() / motion.feed;
            let tip = model.nominal(to, &tool).translation - model.nominal(from, &tool).translation;
            assert!((tip.norm() / minutes - 500.0).abs() < 5.0, "{k}: {}", tip.norm() / minutes);
        }
    }
}

#[test]
fn errors_of_a_head_machine_are_corrected_under_traori() {
    let machine = machine("wFXYZCBSt");
    let errors = tired(&mut crate::bench_machine::Random(5));
    let text = "N1 G17 G90 G54 T1 M6\nN2 TRAORI\nN4 G0 X-20 Y10 Z60 A3=0.2 B3=0.3 C3=1\nN5 G1 F500 X100 Y100 A3=0.5 B3=0.3 C3=1\nN6 \
                Z20 A3=0.5 B3=-0.2 C3=1\nN7 M30\n";
    let (_, prediction, _) = corrected(text, &machine, &errors, &CorrectionOptions::default());
    assert!(prediction.before().max_mm > 5e-3 && prediction.after().max_mm < 1.2e-3, "{prediction:?}");
}

#[test]
fn poles_and_directions_out_of_reach_are_found_with_their_place() {
    let machine = machine("wCBXFZYSt");
    let head = "N1 G17 G90 G54 T1 M6\nN2 TRAORI\nN3 ORIVECT\n";
    let cases = [
        // From one side past the pole at one degree to the other side.
        ("N4 G0 X0 Y0 Z0 A3=0.5 B3=0.02 C3=1\nN5 G1 F500 X10 A3=-0.5 B3=0.02 C3=1\n", "E0241"),
        ("N4 G0 X0 Y0 Z0 A3=0.5 C3=1\nN5 G1 F500 X10 A3=-0.5 C3=-1\n", "E0241"),
        ("N4 G0 X0 Y0 Z0 A3=0 B3=0 C3=0\n", "E0210"),
        ("N4 TRAFOOF\nN5 G0 X0 Y0 Z0 A3=0 B3=0 C3=1\n", "E0210"),
        ("N4 G0 X0 Y0 Z0 B0 C0 A3=0 B3=0 C3=1\n", "E0111"),
        ("N4 G0 X0 Y0 Z0 A6=0 B6=0 C6=1\n", "E0201"),
    ];
    for (text, code) in cases {
        let (_, found) = execute(&format!("{head}{text}"), &machine);
        let codes: Vec<&str> = found.iter().map(|finding| finding.code.as_str()).collect();
        assert_eq!(codes, [code], "{text}: {found:#?}");
        assert!(found[0].place.is_some());
    }
    let huron = with_tool(load_machine("esmaeili_huron").0);
    let (_, found) = execute(&format!("{head}N4 G0 X0 Y0 Z0 A3=1 B3=0 C3=-0.2\n"), &huron);
    assert_eq!(found[0].code.as_str(), "E0240");
    let xyz = crate::machines::xyz_machine();
    let (_, found) = execute("N2 TRAORI\n", &xyz);
    assert_eq!(found[0].code.as_str(), "E0309");
}

/// Through the pole exactly is no trouble where the tilting axis goes on to the other side.
#[test]
fn a_tool_may_pass_exactly_through_the_pole() {
    let machine = machine("wCBXFZYSt");
    let text = "N1 G17 G90 G54 T1 M6\nN2 TRAORI\nN3 ORIVECT\nN4 G0 X0 Y0 Z0 A3=0.5 C3=1\nN5 G1 F500 X10 A3=-0.5 C3=1\n";
    let pieces = chords(&elements(text, &machine), &machine, 5);
    let model = Model::new(&machine, &ErrorModel::default());
    let direction = model.nominal(pieces.last().unwrap(), &Vector::zeros()).rotation * machine.spindle.axis;
    assert!((direction - Vector::new(-0.5, 0.0, 1.0).normalize()).norm() < 1e-9);
    assert!(pieces.iter().all(|piece| (piece[Axis::C] - pieces[0][Axis::C]).abs() < 1e-9));
}

#[test]
fn the_pose_stays_when_the_transformation_or_the_tool_length_changes() {
    let mut machine = machine("wFXYZCBSt");
    machine.tools.push(Tool { number: 1, name: None, edge: 2, length_mm: [90.0, 0.0, 0.0], radius_mm: 5.0 });
    let text = "N1 G17 G90 G54 T1 M6\nN2 G0 X10 Y20 Z30 B30 C40\nN3 TRAORI\nN4 G0 X1 Y2 Z3 B30 C40\nN5 D2\nN6 G0 X5 Y6 Z7\nN7 \
                TRAFOOF\nN8 G91 G0 X1 Y1 Z1\n";
    let elements = elements(text, &machine);
    let model = Model::new(&machine, &ErrorModel::default());
    let tip = |command: &AxisVector, length: f64| {
        model.nominal(command, &Vector::new(0.0, 0.0, -length)).translation - Vector::new(4.0, -3.0, 2.0)
    };
    assert!((tip(&targets(&elements, 4)[0], 150.0) - Vector::new(1.0, 2.0, 3.0)).norm() < 1e-9);
    let standing = targets(&elements, 6)[0];
    assert!((tip(&standing, 90.0) - Vector::new(5.0, 6.0, 7.0)).norm() < 1e-9);
    let moved = targets(&elements, 8)[0];
    assert!((moved.xyz() - standing.xyz() - Vector::new(1.0, 1.0, 1.0)).norm() < 1e-9);
}

#[test]
fn angles_of_both_kinds_name_the_direction() {
    let machine = machine("wFXYZCBSt");
    let model = Model::new(&machine, &ErrorModel::default());
    let [sine, cosine] = [30_f64.to_radians().sin(), 30_f64.to_radians().cos()];
    for (code, words, wanted) in [
        // C2 = 90 turns about Z what A2 has turned about X: (0, -s, c) becomes (s, 0, c).
        ("ORIRPY", "A2=30 C2=90", Vector::new(sine, 0.0, cosine)),
        ("ORIRPY", "B2=30", Vector::new(sine, 0.0, cosine)),
        // A2 about Z, B2 about the new X: (0, -s, c) turned by 90 degrees.
        ("ORIEULER", "A2=90 B2=30 C2=17", Vector::new(sine, 0.0, cosine)),
    ] {
        let text = format!("N1 G17 G90 G54 T1 M6\nN2 TRAORI\nN3 {code}\nN4 G0 X0 Y0 Z0 {words}\n");
        let command = targets(&elements(&text, &machine), 4)[0];
        let direction = model.nominal(&command, &Vector::zeros()).rotation * Vector::z();
        assert!((direction - wanted).norm() < 1e-9, "{code} {words}");
    }
    // A turned frame turns the direction with it, unless ORIMKS says otherwise.
    for (code, wanted) in [("ORIWKS", Vector::new(0.0, sine, cosine)), ("ORIMKS", Vector::new(sine, 0.0, cosine))] {
        let text =
            format!("N1 G17 G90 G54 T1 M6\nN2 ROT Z90\nN3 TRAORI\nN4 {code} G0 X0 Y0 Z0 A3={sine} C3={cosine}\n");
        let command = targets(&elements(&text, &machine), 4)[0];
        let direction = model.nominal(&command, &Vector::zeros()).rotation * Vector::z();
        assert!((direction - wanted).norm() < 1e-9, "{code}");
    }
}

#[test]
fn radius_compensation_under_the_transformation_is_refused() {
    let (machine, _) = topologies().swap_remove(0);
    let machine = with_tool(machine);
    let text = "N1 G17 G90 G54 T1 M6\nN2 TRAORI\nN3 G0 X0 Y0 Z50\nN4 G41 G1 F500 X10 Y10\nN5 Y40\nN6 G40 X0\nN7 M30\n";
    let (_, findings) = execute(text, &machine);
    assert!(findings.iter().any(|found| found.code.to_string() == "E0201"), "{findings:?}");
    assert!(execute(&text.replace("G41 ", ""), &machine).1.iter().all(|found| found.code.to_string() != "E0201"));
}
