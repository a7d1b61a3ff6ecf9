//! Every kind of plan on every sample machine: plan, program, simulated readings and a calibration from them, or a reason why there is none.

use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;
use ncfix_metrology::calibrate::identify;
use ncfix_metrology::measure::data::load_plan;
use ncfix_metrology::measure::plan::PLANS;
use ncfix_model::ErrorModel;
use ncfix_model::parameter::ParameterName;

use crate::support::{Shop, machine, repository};

/// The sample machines.
fn machines() -> Vec<String> {
    let entries = std::fs::read_dir(repository("samples/machines")).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter_map(|name| name.strip_suffix(".toml").map(str::to_owned)).collect();
    names.sort();
    assert!(names.len() >= 7);
    names
}

/// Plans with what they need, at least one of every kind; on how many of the machines they are possible.
const CASES: &[(&[&str], &[&str])] = &[
    (&["ballbar", "--tool", "100"], &["all"]),
    (&["sphere", "--tool", "100", "--chord", "2"], &["all"]),
    (&["sphere", "--variant", "esmaeili", "--tool", "100", "--chord", "2"], &["all"]),
    (
        &["sphere", "--variant", "spaan", "--chord", "2"],
        &["demo", "esmaeili_huron", "esmaeili_xyz5", "knee_mill", "maho700s", "universal_mill", "worn_mill"],
    ),
    (&["probe", "--tool", "150"], &["esmaeili_huron", "esmaeili_xyz5", "knee_mill", "maho700s", "vmc"]),
    (&["probe", "--variant", "samba", "--tool", "150"], &["esmaeili_xyz5"]),
    (&["probe", "--variant", "rumba", "--tool", "74"], &["esmaeili_huron"]),
    (&["probe", "--variant", "rumba-check", "--tool", "74"], &["esmaeili_huron"]),
    (
        &["rtest", "--tool", "150", "--runs", "1", "--every", "30"],
        &["esmaeili_huron", "esmaeili_xyz5", "knee_mill", "maho700s", "vmc"],
    ),
    (
        &["ballbar", "--variant", "rotary", "--tool", "150", "--every", "30"],
        // The others need another place of the ball (--ball).
        &["esmaeili_huron", "vmc"],
    ),
    (&["laser"], &["all"]),
    (&["laser", "--axis", "Z", "--component", "EAZ"], &["all"]),
    (&["diagonal", "--runs", "1"], &["all"]),
    (&["diagonal", "--variant", "all", "--points", "3", "--runs", "2"], &["all"]),
    (&["drift", "--hours", "1"], &["all"]),
    (&["drift", "--variant", "pseudo-din"], &["all"]),
    (&["drift", "--variant", "random", "--hours", "3"], &["all"]),
    (&["drift", "--variant", "steady", "--hours", "3"], &["all"]),
    (&["plate", "--tool", "100"], &["all"]),
    (&["load", "--force", "1000"], &["all"]),
    (&["load", "--variant", "plate", "--force", "1000", "--tool", "100"], &["all"]),
    (&["workpiece"], &["all"]),
];

/// What each kind may tell; those are taken that a plan tells beside all others.
const CANDIDATES: &str = "EC0Y EC0X EA0Z EA0Y EB0Z EB0X EXX1 EYY1 EZZ1 EAZ1 EAZ2 EA0B EC0B EX0C EY0C EB0A EC0A";

fn loaded(name: &str) -> (Machine, ErrorModel) {
    let bytes = std::fs::read(machine(name)).unwrap();
    let source = Source::new(FileId(0), name, bytes).unwrap();
    ncfix_model::file::load(&source).0.unwrap()
}

/// Parameters that a plan tells.
fn fitting(shop: &Shop, machine: &Machine, errors: &ErrorModel) -> Vec<ParameterName> {
    let source = |name: &str, id: u16| Source::new(FileId(id), name, shop.bytes(name)).unwrap();
    let (data, found) = load_plan("p", &source("p.csv", 1), &source("p.toml", 2), machine);
    assert!(found.is_empty(), "{found:?}");
    let data = [data.unwrap()];
    let is_told = |parameters: &[ParameterName]| {
        let found = identify(machine, errors, parameters, &data).unwrap();
        let worst = found.inflation.iter().take(parameters.len()).copied().fold(0.0, f64::max);
        found.lost.leave_out.is_empty() && worst < 50.0
    };
    let mut out = Vec::new();
    for name in CANDIDATES.split(' ') {
        let name: ParameterName = name.parse().unwrap();
        if name.component.axis().is_some_and(|axis| machine.axis(axis).is_none()) {
            continue;
        }
        out.push(name);
        if !is_told(&out) {
            out.pop();
        }
    }
    out
}

#[test]
fn every_plan_runs_through_or_says_why_not() {
    for kind in PLANS {
        assert!(CASES.iter().any(|(case, _)| case[0] == kind.name), "no case of {}", kind.name);
    }
    let mut calibrated = 0;
    for name in machines() {
        let (loaded, errors) = loaded(&name);
        let on = machine(&name);
        for (case, possible) in CASES {
            let what = format!("{name}: {}", case.join(" "));
            let shop = Shop::new();
            let with = |more: &[&str]| shop.run(more.iter().copied().chain(["--machine", on.as_str()]));
            let mut arguments = vec!["plan"];
            arguments.extend(*case);
            let run = with(&[arguments.as_slice(), &["-o", "p.csv", "--program", "p.nc"]].concat());
            if !possible.contains(&"all") && !possible.contains(&name.as_str()) {
                assert_eq!(run.code, 2, "{what} is possible now");
                assert!(run.stderr.contains(" is not possible: ") && shop.names().is_empty(), "{what}: {}", run.stderr);
                continue;
            }
            assert_eq!(run.code, 0, "{what}: {}", run.stderr);
            // A part program has the zero offset and the tool that the plan names.
            std::fs::write(shop.path("job.toml"), crate::workpiece::job(&run.stderr)).unwrap();
            with(&["check", "p.nc", "--setup", "job.toml"]).exits(0);
            // Errors of the machine lead beyond no end of travel.
            let run = with(&["simulate", "p.csv", "-o", "s.csv", "--noise", "0.5um", "--seed", "3"]);
            assert_eq!(run.code, 0, "{what}: {}", run.stderr);
            // One machine has no pitch of Z, so its angles are noise alone.
            if ["drift", "load"].contains(&case[0]) || (name == "worn_mill" && case.contains(&"EAZ")) {
                continue;
            }
            let parameters = fitting(&shop, &loaded, &errors);
            assert!(!parameters.is_empty(), "{what} tells nothing");
            let names: Vec<String> = parameters.iter().map(ToString::to_string).collect();
            std::fs::write(shop.path("model.txt"), names.join("\n")).unwrap();
            let mut calibrate = vec!["calibrate", "s.csv", "--model", "model.txt", "-o", "out.toml"];
            if case[0] == "diagonal" {
                // A diagonal contains all errors, also those that the model does not have: no reading is an outlier.
                // A turn of a rotary axis that stands has next to no effect.
                calibrate.extend(["--no-robust", "--reduce"]);
            }
            let run = with(&calibrate);
            assert_eq!(run.code, 0, "{what} {names:?}: {}", run.stderr);
            assert!(shop.names().contains(&"out.toml".to_owned()));
            calibrated += 1;
        }
    }
    // Eight machines: nine plans on all of them with geometry, without the angle of one; spheres, balls; R-tests and turning ball-bars.
    assert_eq!(calibrated, 8 * 9 - 1 + 7 + 5 + 3 + 5 + 2);
}

#[test]
fn the_margin_is_room_for_what_errors_do() {
    let shop = Shop::new();
    let on = machine("esmaeili_xyz5");
    let line = |range: &str, margin: &str| {
        shop.run(["plan", "laser", "--machine", &on, "-o", "p.csv", "--range", range, "--margin", margin])
    };
    // X goes from −305 to 305.
    line("-303,303", "2mm").exits(0);
    line("-303,303", "2.1").exits(2).says("X would go to -303.0000 mm, less than the margin of 2.1 mm");
    line("-305,305", "0").exits(0);
    line("-306,306", "0").exits(2).says("outside its travel of -305 to 305 mm");
    shop.run(["plan", "laser", "--machine", &on, "-o", "p.csv", "--range", "-304,304"]).exits(2).says("margin of 2 mm");
}
