//! Plans that go with measurements which are there already: what they tell together, and which further poses help then.

use ncfix_base::geometry::{Plane, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;
use ncfix_metrology::calibrate::{identify, improve};
use ncfix_metrology::measure::data::DataSet;
use ncfix_metrology::measure::plan::builder::Builder;
use ncfix_metrology::measure::plan::{Wishes, find};
use ncfix_model::ErrorModel;
use ncfix_model::parameter::ParameterName;

use crate::support::{Run, Shop, machine};

/// What a plate in XY tells: two gains and a squareness. One in YZ: two gains and another squareness.
const MODEL: &str = "EXX1\nEYY1\nEZZ1\nEC0X\nEA0Z\nEB0Z\n";

fn plate(shop: &Shop, plane: &str, output: &str, more: &[&str]) -> Run {
    let demo = machine("demo");
    let arguments =
        ["plan", "plate", "--plane", plane, "--tool", "100", "--machine", &demo, "--model", "model.txt", "-o", output];
    shop.run(arguments.iter().chain(more))
}

#[test]
fn plates_of_several_planes_tell_together_what_one_does_not() {
    let shop = Shop::new().file("model.txt", MODEL);
    // In each plate two shifts and a rotation are told beside the machine, of six; X and Y only are read on the first.
    plate(&shop, "XY", "xy.csv", &[])
        .exits(0)
        .says("6 parameters and 6 unknowns of the set-up: the plan determines 6 of 12");
    let both = plate(&shop, "YZ", "yz.csv", &["--with", "xy.csv"]).exits(0);
    let both = both.says("6 parameters and 6 unknowns of the set-up: the plan alone determines 6 of 12");
    // EYY1 is in both.
    let both = both.says(
        "6 parameters and 12 unknowns of the set-up: together with 1 other measurement the plan determines 11 of 18",
    );
    assert!(both.stderr.contains("EB0Z"), "{}", both.stderr);
    let all = plate(&shop, "ZX", "zx.csv", &["--with", "xy.csv", "--with", "yz.csv"]).exits(0);
    all.says(
        "6 parameters and 18 unknowns of the set-up: together with 2 other measurements the plan determines 15 of 24",
    );
}

#[test]
fn a_measurement_counts_by_what_was_read() {
    let shop = Shop::new().file("model.txt", MODEL);
    plate(&shop, "XY", "xy.csv", &[]).exits(0);
    let demo = machine("demo");
    shop.run(["simulate", "xy.csv", "-o", "made.csv", "--noise", "1um", "--machine", &demo]).exits(0);
    plate(&shop, "YZ", "a.csv", &["--with", "made.csv"])
        .exits(0)
        .says("together with 1 other measurement the plan determines 11 of 18");
    // Without the readings of X neither its gain nor, beside the rotation of the plate, the squareness is told, and one shift less.
    let text = shop.text("made.csv");
    let column = text.lines().next().unwrap().split(',').position(|name| name == "dx_um").unwrap();
    let lines = text.lines().enumerate().map(|(number, line)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        if number > 0 {
            cells[column] = "";
        }
        cells.join(",") + "\n"
    });
    std::fs::write(shop.path("half.csv"), lines.collect::<String>()).unwrap();
    std::fs::copy(shop.path("made.toml"), shop.path("half.toml")).unwrap();
    // Y only: its gain, a shift, and the rotation or the squareness.
    plate(&shop, "YZ", "b.csv", &["--with", "half.csv"])
        .exits(0)
        .says("together with 1 other measurement the plan determines 8 of 18");
    let wrong = plate(&shop, "YZ", "c.csv", &["--with", "model.txt"]);
    assert!(wrong.code != 0 && !shop.names().contains(&"c.csv".to_owned()), "{}", wrong.stderr);
    let alone = shop.run(["plan", "plate", "--machine", &demo, "-o", "d.csv", "--with", "xy.csv"]);
    assert!(alone.code != 0 && alone.stderr.contains("--model"), "{}", alone.stderr);
}

fn xyz5() -> Machine {
    let source = Source::new(FileId(0), "m", std::fs::read(machine("esmaeili_xyz5")).unwrap()).unwrap();
    ncfix_model::file::load(&source).0.unwrap().0
}

#[test]
fn poses_are_chosen_for_what_the_others_do_not_tell() {
    let machine = xyz5();
    let tool = Vector::new(0.0, 0.0, -150.0);
    let build = |kind: &str, wishes: Wishes| -> Builder { (find(kind).unwrap().build)(&machine, &wishes).unwrap() };
    let mut few = build(
        "probe",
        Wishes {
            tools_mm: vec![tool],
            balls_mm: vec![Vector::new(70.0, 0.0, 40.0)],
            points: Some(2),
            ..Wishes::default()
        },
    );
    few.data.observations.truncate(2);
    let plates = [Plane::XY, Plane::ZX].map(|plane| {
        let plan = build("plate", Wishes { tools_mm: vec![tool], planes: vec![plane], ..Wishes::default() });
        let mut data = plan.data;
        data.observations.iter_mut().for_each(|row| row.values = plan.reads.map(|read| read.then_some(0.0)));
        data
    });
    let names = "EXX1 EYY1 EZZ1 EA0B EC0B EZ0B EA0C EB0C EX0C EC0Z EA0Z";
    let parameters: Vec<ParameterName> = names.split(' ').map(|name| name.parse().unwrap()).collect();
    let together = |more: &[usize]| -> Vec<DataSet> {
        let mut own = few.data.clone();
        own.observations.extend(more.iter().map(|&number| few.candidates[number]));
        std::iter::once(own).chain(plates.clone()).collect()
    };
    let rank = |data: &[DataSet]| identify(&machine, &ErrorModel::default(), &parameters, data).unwrap().rank;
    let best = (0..few.candidates.len()).map(|number| rank(&together(&[number]))).max().unwrap();
    let chosen = improve(&machine, &ErrorModel::default(), &parameters, &together(&[]), &few.candidates, 4);
    assert_eq!(chosen.len(), 4);
    assert_eq!(rank(&together(&chosen[..1])), best, "no other pose would have told more");
    assert!(best > rank(&together(&[])));
    // Chosen with what is there, four poses tell together at least what those tell that were chosen for the balls alone.
    let alone =
        improve(&machine, &ErrorModel::default(), &parameters, std::slice::from_ref(&few.data), &few.candidates, 4);
    assert!(rank(&together(&chosen)) >= rank(&together(&alone)));
}

/// A plate that is moved along the diagonal of the plane; four of its holes come to places where others were (Spaan 1995, Fig. 3.6: at least two). The machine
/// has the same error there, so the difference of the readings is that of the two mountings alone: with rotations of 80 and −150 µrad, dx differs by 230 µrad
/// times Y. What the machine does between the places of one mounting and those of the other is then known too.
#[test]
fn shared_holes_tie_two_places_of_a_plate() {
    let text = "[machine]\nname = \"three\"\ntopology = \"wFXYZSt\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n\
        [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 600]\n";
    // Offsets in µm and the rotation in µrad of either mounting.
    let mountings = [[100.0, -50.0, 80.0], [-200.0, 30.0, -150.0]];
    // The tip stands at the axis positions; the error of X grows with its square, that of Y with Y.
    let read = |x: f64, y: f64, [ox, oy, turn]: [f64; 3]| {
        let [ex, ey] = [0.04 * x + 60e-6 * x * x, -0.03 * y];
        [ex + turn * 1e-3 * y - ox, ey - turn * 1e-3 * x - oy]
    };
    let mut table = "setup,X,Y,Z,dx_um,dy_um\n".to_owned();
    let mut holes = Vec::new();
    for (number, mounting) in mountings.into_iter().enumerate() {
        let corner = 50.0 + 150.0 * number as f64;
        for (i, j) in (0..25).map(|k| (k % 5, k / 5)) {
            let (x, y) = (corner + 50.0 * f64::from(i), corner + 50.0 * f64::from(j));
            let [dx, dy] = read(x, y, mounting);
            table += &format!("P{},{x},{y},100,{dx:.5},{dy:.5}\n", number + 1);
            holes.push((number, x, y, dx));
        }
    }
    // By hand: the holes at which both were.
    let shared: Vec<(f64, f64)> = holes
        .iter()
        .filter(|hole| hole.0 == 0)
        .filter_map(|(_, x, y, dx)| {
            let other = holes.iter().find(|other| other.0 == 1 && (other.1, other.2) == (*x, *y))?;
            Some((*y, dx - other.3))
        })
        .collect();
    assert_eq!(shared.len(), 4);
    let (first, last) = (shared[0], shared[3]);
    let turn = (last.1 - first.1) / (last.0 - first.0) * 1e3;
    assert!((turn - 230.0).abs() < 0.01, "{turn}");
    let shop = Shop::new().file("m.toml", text).file("model.txt", "EXX1\nEXX2\nEYY1\n").file("plates.csv", table).file(
        "plates.toml",
        "[measurement]\nkind = \"displacement\"\nsigma_um = 0.1\nfree = [\"offset\", \"rotation\"]\n",
    );
    let words = ["calibrate", "plates.csv", "--machine", "m.toml", "--model", "model.txt", "-o", "out.toml", "--json"];
    let json = shop.run(words).exits(0).json();
    let value = |list: &str, is_it: &dyn Fn(&str) -> bool| {
        let rows = json[list].as_array().unwrap();
        let row = rows.iter().find(|row| is_it(row["name"].as_str().unwrap())).unwrap_or_else(|| panic!("{json}"));
        row["value"].as_f64().unwrap()
    };
    for (name, expected) in [("EXX1", 40.0), ("EXX2", 60.0), ("EYY1", -30.0)] {
        let found = value("parameters", &|one| one == name);
        assert!((found - expected).abs() < 0.1, "{name}: {found}");
    }
    let turned = ["P1", "P2"].map(|setup| {
        value("unknowns", &|name| name.contains(setup) && name.contains("rotation") && name.contains('Z'))
    });
    assert!((turned[0] - turned[1] - turn).abs() < 0.2, "{turned:?}");
}
