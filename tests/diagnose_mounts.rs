//! The bend of the mounts of a ball-bar must not be corrected in the machine, and a turn of an axis about itself has the name of the axis that it carries.

use ncfix_base::source::{FileId, Source};
use ncfix_metrology::diagnose::Scene;
use ncfix_metrology::diagnose::explain::assumptions::Family;
use ncfix_metrology::diagnose::explain::term;
use ncfix_metrology::measure::data::load;

use crate::cli_calibrate::bare;
use crate::explain::{DESCRIPTION, Plant};
use crate::support::Shop;

/// The mounts yield sideways by 5 µm: the horizontal share 1 − (z/r)² of the bar counts.
fn with_mounts(table: &str, um: f64) -> String {
    let mut lines = table.lines();
    let mut out = lines.next().unwrap().to_owned() + "\n";
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let share = (cells[4].parse::<f64>().unwrap() - 300.0) / 100.0;
        let last = cells.pop().unwrap().parse::<f64>().unwrap();
        cells.push(format!("{:.5}", last + um * (1.0 - share * share)));
        out += &(cells.join(",") + "\n");
    }
    out
}

#[test]
fn mounts_that_bend_are_no_scales_to_correct() {
    for (seed, um) in [(3, 5.0), (4, -6.0)] {
        let table = with_mounts(&Plant::default().measured(seed), um);
        let shop = Shop::new().file("start.toml", bare("demo")).file("d.csv", &table).file("d.toml", DESCRIPTION);
        let report = shop.run(["diagnose", "d.csv", "--machine", "start.toml", "--json"]).exits(0).json();
        for one in report["findings"].as_array().unwrap() {
            assert!(one["effect"] != "motion" || one["correctable"] == "no", "{one:#}");
        }
        assert!(report["explanations"].to_string().contains("setup mounts"), "{:#}", report["explanations"]);
    }
    // Scales that differ are scales.
    let table = Plant { scale: [50e-6, -50e-6, 0.0], ..Plant::default() }.measured(3);
    let shop = Shop::new().file("start.toml", bare("demo")).file("d.csv", &table).file("d.toml", DESCRIPTION);
    let report = shop.run(["diagnose", "d.csv", "--machine", "start.toml", "--json"]).exits(0).json();
    let is_sure = |name: &str| {
        let mut all = report["findings"].as_array().unwrap().iter();
        all.any(|one| one["parameter"] == name && one["correctable"] == "program")
    };
    assert!(is_sure("EXX") && is_sure("EYY"), "{report:#}");
}

/// On a trunnion that Y carries, a turn of Y about itself is the tilt of A, with its usual size and odds. On a table without rotary axes it stays a squareness.
#[test]
fn a_turn_of_an_axis_about_itself_is_the_tilt_of_what_it_carries() {
    let source = |id, name, text: &str| Source::new(FileId(id), name, text.as_bytes().to_vec()).unwrap();
    let family = |topology: &str, rotary: &str| {
        let text = format!(
            "[machine]\nname = \"m\"\ntopology = \"{topology}\"\n[axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [0, 500]\n\
             [axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 500]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 500]\n{rotary}"
        );
        let (machine, errors) = ncfix_model::file::load(&source(0, "m.toml", &text)).0.unwrap();
        let columns = if rotary.is_empty() { ["", ""] } else { [",A", ",0"] };
        let rows: String = (0..4).map(|k| format!("{},{},0{},0,0,0\n", 100 * k, 50 * k, columns[1])).collect();
        let table = format!("X,Y,Z{},dx_um,dy_um,dz_um\n{rows}", columns[0]);
        let description = "[measurement]\nkind = \"displacement\"\nsigma_um = 1\n";
        let (data, findings) = load("d", &source(1, "d.csv", &table), &source(2, "d.toml", description), &machine);
        let sets = [data.unwrap_or_else(|| panic!("{findings:?}"))];
        let scene = Scene::new(&machine, &errors, &sets).unwrap();
        let all = term::terms(&scene);
        all.iter().find(|one| one.component.to_string() == "EB0Y").map(|one| one.family)
    };
    let trunnion = "[axis.A]\ndirection = [-1, 0, 0]\ntravel_deg = [-110, 110]\n";
    assert_eq!(family("wAYXFZSt", trunnion), Some(Family::Tilt));
    assert_eq!(family("wXYFZSt", ""), Some(Family::Squareness));
}
