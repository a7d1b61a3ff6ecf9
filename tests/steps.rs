//! `ncfix max-step`: the largest fixed step that keeps a residual, against the sag of chords worked out by hand.

use ncfix_base::geometry::{Axis, Vector};
use ncfix_machine::machine::{AxisData, Lever, Machine};
use ncfix_model::{ErrorModel, Model};
use ncfix_path::path::{ResidualSteps, Rotary, StepTrial, Steps, volume};

use crate::bench_machine::{motion, polynomial};
use crate::machines::xyz_machine;
use crate::support::{Shop, machine};

/// X, Y and Z on the tool side, with travels from 0, mm.
fn sized(travels: [f64; 3]) -> Machine {
    let mut machine = xyz_machine();
    for (data, travel) in machine.axes.iter_mut().flatten().zip(travels) {
        data.travel = Some([0.0, travel]);
    }
    machine
}

fn search(machine: &Machine, errors: &ErrorModel, tool_mm: f64, limit_mm: f64) -> Steps {
    let model = Model::new(machine, errors);
    let lines = volume(machine, &Vector::new(0.0, 0.0, -tool_mm));
    StepTrial::new(&model, Rotary::Correct).search(&lines, limit_mm, |_| {})
}

#[track_caller]
fn finds(steps: &Steps, wanted_mm: f64) {
    let ResidualSteps::UpTo(step_mm) = steps.answer else { panic!("{:?}", steps.answer) };
    assert!((step_mm / wanted_mm - 1.0).abs() < 0.02, "{step_mm} instead of {wanted_mm}");
}

fn errors(functions: &[(&str, &[f64])]) -> ErrorModel {
    let motion = functions.iter().map(|(name, coefficients)| motion(name, polynomial(coefficients))).collect();
    ErrorModel { motion, ..ErrorModel::default() }
}

#[test]
fn a_parabola_sags_by_a_quarter_of_its_coefficient_times_the_square_of_the_step() {
    // The chord of a x² over s is off by a s² / 4 in the middle, wherever it is.
    let (a, limit_mm) = (1e-6, 1e-3);
    let steps = search(&sized([500.0, 300.0, 200.0]), &errors(&[("EXX", &[0.0, 0.0, a])]), 0.0, limit_mm);
    finds(&steps, 2.0 * f64::sqrt(limit_mm / a));
    // In the table too; below 5 mm the noise of the ends, which are corrected to 1e-7 mm, is no less than the sag.
    for row in steps.rows.iter().filter(|row| (5.0..200.0).contains(&row.step_mm)) {
        assert!((row.residual_mm / (a * row.step_mm.powi(2) / 4.0) - 1.0).abs() < 0.02, "{row:?}");
    }
    assert!(steps.worst.max_mm <= limit_mm && steps.worst.max_mm > 0.98 * limit_mm);
}

#[test]
fn a_rotation_counts_with_the_length_of_the_tool() {
    // Pitch of X moves the tip of a tool of length L by L · EBX, roll as much at right angles to it. Y and Z hardly move, so that
    // the arm is the tool.
    let (b, limit_mm) = (1e-8, 1e-3);
    let machine = sized([500.0, 0.1, 0.1]);
    for length_mm in [100.0, 400.0] {
        let step = |arms: f64| 2.0 * (limit_mm / (b * length_mm * arms)).sqrt();
        let pitch = errors(&[("EBX", &[0.0, 0.0, b])]);
        finds(&search(&machine, &pitch, length_mm, limit_mm), step(1.0));
        let both = errors(&[("EBX", &[0.0, 0.0, b]), ("EAX", &[0.0, 0.0, b])]);
        finds(&search(&machine, &both, length_mm, limit_mm), step(2_f64.sqrt()));
    }
}

#[test]
fn a_turning_table_counts_at_an_arm_of_a_hundred_millimeters() {
    // An error e of the table that turns with it is corrected by e cos C, e sin C: a circle, whose chord over the angle w sags by
    // e (1 − cos w/2). The nominal line is straight in the axes, else a turning table would leave far more.
    let mut machine = sized([300.0, 200.0, 100.0]);
    machine.topology = "wCFXYZSt".parse().unwrap();
    let c = AxisData {
        axis: Axis::C,
        name: None,
        direction: Vector::z(),
        point_mm: Vector::new(150.0, 100.0, 0.0),
        travel: Some([-7200_f64.to_radians(), 7200_f64.to_radians()]),
        modulo: false,
        max_feed: None,
        start_rad: None,
        clamps: Vec::new(),
        lever: Lever::Carried,
    };
    machine.axes[Axis::C.slot()] = Some(c);
    let (e, limit_mm) = (0.05, 1e-3);
    let steps = search(&machine, &errors(&[("EXC", &[e])]), 100.0, limit_mm);
    finds(&steps, 200.0 * f64::acos(1.0 - limit_mm / e));
    assert_eq!(steps.worst.failures, 0);
    // One turn of the table is 628 mm; twenty would be 25 m.
    assert!(steps.rows.last().unwrap().step_mm < 629.0);
}

#[test]
fn without_bending_any_step_will_do() {
    let machine = sized([500.0, 300.0, 200.0]);
    let none = search(&machine, &ErrorModel::default(), 100.0, 1e-6);
    assert_eq!((none.answer, none.worst.max_mm), (ResidualSteps::Any, 0.0));
    // Scale and squareness are straight: ends corrected, nothing is left between.
    let straight = errors(&[("EXX", &[0.0, 1e-4]), ("EYX", &[0.0, -2e-4])]);
    let steps = search(&machine, &straight, 100.0, 1e-6);
    assert_eq!(steps.answer, ResidualSteps::Any);
}

#[test]
fn smaller_steps_count_for_larger_ones() {
    let machine = sized([200.0, 0.1, 0.1]);
    let wave = "period_mm = 10.0\namplitude_um = 10.0\nphase_deg = 0.0";
    let shop = Shop::new()
        .file("m.toml", file("", &format!("[[motion]]\ncomponent = \"EXX\"\nkind = \"periodic\"\n{wave}\n")));
    let run = shop.run(["max-step", "--machine", "m.toml", "--residual", "2um", "--json"]).exits(0);
    let json = run.json();
    let rows = json["steps"].as_array().unwrap();
    let largest: Vec<f64> = rows.iter().map(|row| row["largest_um"].as_f64().unwrap()).collect();
    assert!(largest.windows(2).all(|pair| pair[1] >= pair[0]));
    // Chords over a peak sag by 10 µm (1 − cos π s / 10 mm): 2 µm at 2.05 mm, more where no chord is centered on the peak.
    let step = json["largest_step_mm"].as_f64().unwrap();
    assert!((2.0..2.5).contains(&step), "{step}");
    // However small it may be: a residual that no step keeps.
    let tight = errors(&[("EXX", &[0.0, 0.0, 1e-4])]);
    let steps = search(&machine, &tight, 0.0, 1e-6);
    assert_eq!(steps.answer, ResidualSteps::None);
}

/// A machine file with X of 500 mm; Y and Z hardly move.
fn file(tools: &str, motion: &str) -> String {
    let axis = |letter: &str, direction: &str, travel: &str| {
        format!("[axis.{letter}]\ndirection = {direction}\ntravel_mm = [0, {travel}]\n")
    };
    format!(
        "[machine]\nname = \"narrow & small\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n{}{}{}{tools}{motion}",
        axis("X", "[1, 0, 0]", "500"),
        axis("Y", "[0, 1, 0]", "0.1"),
        axis("Z", "[0, 0, 1]", "0.1")
    )
}

const TOOLS: &str =
    "[[tool]]\nnumber = 1\nlength_mm = 100\nradius_mm = 5\n[[tool]]\nnumber = 2\nlength_mm = 400\nradius_mm = 5\n";
const PITCH: &str = "[[motion]]\ncomponent = \"EBX\"\nkind = \"polynomial\"\ncoefficients = [0, 0, 1e-8]\n";

#[test]
fn the_longest_tool_of_the_machine_decides() {
    let shop = Shop::new().file("ncfix.toml", file(TOOLS, PITCH));
    let step = |arguments: &[&str]| {
        let run = shop.run(["max-step", "--json"].iter().chain(arguments)).exits(0);
        let json = run.json();
        assert_eq!(json["answer"], "up_to");
        assert!(json["residual_um"].as_f64().unwrap() <= json["residual_limit_um"].as_f64().unwrap());
        json["largest_step_mm"].as_f64().unwrap()
    };
    let [longest, shorter] = [step(&[]), step(&["--tool", "100"])];
    // 2 √(5 µm / 400 mm / 1e-8), and the root of the ratio of the lengths.
    assert!((longest / 70.71 - 1.0).abs() < 0.02, "{longest}");
    assert!((shorter / longest / 2.0 - 1.0).abs() < 0.005, "{shorter} {longest}");
    assert_eq!(step(&["--tool", "0,0,-100"]), shorter);
    // The step of a residual grows with its root.
    assert!((step(&["--residual", "1.25um"]) * 2.0 / longest - 1.0).abs() < 0.005);
}

/// The weight doubles the pitch of its reference load: 2 · 1e-8 on a tool of 400 mm, so that the step is 2 √(5 µm / 400 mm / 2e-8) = 50 mm. Half of the weight
/// has the root of 2 more.
#[test]
fn the_full_load_has_the_smallest_step() {
    let load =
        "[[load]]\ncomponent = \"EBX\"\nreference_N = 1000\nkind = \"polynomial\"\ncoefficients = [0, 0, 1e-8]\n";
    let shop = Shop::new().file("ncfix.toml", file(TOOLS, load));
    let step = |load: &str| {
        let json = shop.run(["max-step", "--json", "--load", load]).exits(0).json();
        assert_eq!(json["answer"], "up_to", "{json}");
        json["largest_step_mm"].as_f64().unwrap()
    };
    let [full, half] = [step("2000"), step("1000")];
    assert!((full / 50.0 - 1.0).abs() < 0.02, "{full}");
    assert!((half / full / 2_f64.sqrt() - 1.0).abs() < 0.005, "{half} {full}");
    // The empty table has no pitch at all.
    let empty = shop.run(["max-step", "--json", "--load", "0"]).exits(0).json();
    assert_eq!(empty["answer"], "any", "{empty}");
}

#[test]
fn the_page_names_answer_and_place_without_colors() {
    let shop = Shop::new().file("m.toml", file(TOOLS, PITCH));
    let run = shop.run(["max-step", "--machine", "m.toml", "--svg", "s.svg"]).exits(0);
    for text in
        ["µm residual", "largest step 70", " mm for 5.00 µm", "on the line  X", "tool length  400 mm", "█", "limit"]
    {
        assert!(run.stdout.contains(text), "{text}: {}", run.stdout);
    }
    assert!(!run.stdout.contains('\u{1b}'), "{}", run.stdout);
    let svg = shop.text("s.svg");
    for text in ["<svg ", "step in mm", "residual in µm", "limit 5 µm", "narrow &amp; small", "<circle", "</svg>\n"] {
        assert!(svg.contains(text), "{text}: {svg}");
    }
    for element in ["text", "svg"] {
        assert_eq!(svg.matches(&format!("<{element} ")).count(), svg.matches(&format!("</{element}>")).count());
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
}

#[test]
fn a_program_is_judged_by_its_own_moves() {
    let program = "N10 G90 G71 G54 G0 X0 Y0 Z0.05\nN20 T2 D1 M6\nN30 G0 X0 Y0 Z0.05\nN40 G1 X100 F500\nN50 X400\nN60 X390\nN70 G0 X0\nN80 M30\n";
    let offset = "[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = -399.95\n";
    let shop = Shop::new().file("m.toml", file(&format!("{TOOLS}{offset}"), PITCH)).file("p.mpf", program);
    let json = shop.run(["max-step", "p.mpf", "--machine", "m.toml", "--json"]).exits(0).json();
    assert_eq!((json["moves"].as_u64(), json["worst"]["line"].as_u64()), (Some(3), Some(5)), "{json}");
    assert_eq!(json["worst"]["file"], "p.mpf");
    let step = json["largest_step_mm"].as_f64().unwrap();
    assert!((step / 70.71 - 1.0).abs() < 0.02, "{step}");
    // Moves that are shorter than the step stay whole.
    let short = program.replace("X400", "X150").replace("X390", "X200").replace("X100", "X50");
    let shop = shop.file("short.mpf", short.replace("N50 X150", "N50 X100").replace("N60 X200", "N60 X150"));
    let run = shop.run(["max-step", "short.mpf", "--machine", "m.toml"]).exits(0);
    assert!(run.stdout.contains("any: every line is within 5.00 µm even as one piece"), "{}", run.stdout);
    // A tool of one's own choice.
    let run = shop.run(["max-step", "p.mpf", "--machine", "m.toml", "--tool", "100", "--json"]).exits(0);
    assert!((run.json()["largest_step_mm"].as_f64().unwrap() / 141.42 - 1.0).abs() < 0.02);
}

#[test]
fn what_cannot_be_looked_at_is_said() {
    let shop = Shop::new().file("m.toml", file("", "")).file("bad.mpf", "N10 G0 X\n");
    let run = shop.run(["max-step", "--machine", "m.toml", "--svg", "s.svg"]).exits(0);
    assert!(run.stdout.contains("any: no line bends"), "{}", run.stdout);
    assert!(shop.text("s.svg").contains("no residual at any step"));
    shop.run(["max-step", "bad.mpf", "--machine", "m.toml"]).exits(3).says("bad.mpf:1:8");
    shop.run(["max-step", "none.mpf", "--machine", "m.toml"]).exits(2).says("cannot read none.mpf");
    shop.run(["max-step", "--machine", "m.toml", "--tool", "long"]).exits(2).says("is neither a length nor a vector");
    shop.run(["max-step", "--machine", "m.toml", "--svg", "m.toml"]).exits(4).says("E0310");
}

#[test]
fn a_machine_without_any_correction_has_no_answer() {
    // X that does not move whatever is commanded.
    let stuck = "[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, -1.0]\n";
    let shop = Shop::new().file("m.toml", file("", stuck));
    let run = shop.run(["max-step", "--machine", "m.toml", "--json"]).exits(4);
    let codes = vec!["E0308".to_owned(), "W0408".to_owned()];
    assert_eq!((run.codes(), run.json()["answer"].clone()), (codes, serde_json::Value::Null));
}

#[test]
fn the_sample_machines_have_an_answer() {
    for name in ["demo", "esmaeili_huron"] {
        let json = Shop::new().run(["max-step", "--machine", &machine(name), "--json"]).exits(0).json();
        assert_eq!(json["answer"], "up_to", "{name}: {json}");
        assert_eq!(json["failures"], 0, "{name}: {json}");
    }
}

/// Readings every 50 mm (Spaan 1995, ch. 7, chose a step of 20 mm for 5 µm). Where the slope changes by k, a chord of the length s leaves k·s/4.
/// Along X, the slopes change most at 250 mm: by −10, −19 and 22 µm over 50 mm, together 30.8/50. With the worst changes of Y (26.9/50) and Z (18.4/50),
/// and the pitch (27 µrad/50 at an arm of at most 650 mm), the sum is 93.6/50.
#[test]
fn readings_every_50_mm_need_a_step_of_about_20_mm() {
    let shop = Shop::new();
    let step_mm = |words: &[&str]| -> f64 {
        let run = shop.run(["max-step", "--residual", "5um", "--json", "-q"].iter().chain(words)).exits(0);
        run.json()["largest_step_mm"].as_f64().unwrap()
    };
    let worn = step_mm(&["--machine", &machine("worn_mill")]);
    let [of_all, of_x] = [93.6, 30.8].map(|change| 4.0 * 5.0 / (change / 50.0));
    assert!(of_all < worn && worn < of_x, "{of_all} {worn} {of_x}");
    // Errors without such corners allow much longer steps.
    let smooth = step_mm(&["--machine", &machine("maho700s"), "--load", "4800", "--tool", "245"]);
    assert!(smooth > 3.0 * of_x, "{smooth}");
}
