//! `ncfix calibrate` with files that contradict each other (W0624): two reversal values, two squareness errors.

use std::fmt::Write as _;

use crate::import::Noise;
use crate::support::{Run, Shop};

/// All axes carry the tool.
const BRIDGE: &str = "[machine]\nname = \"bridge\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-50, 450]\n";

/// A laser along X, two runs in both directions: 15 µm/m, and this reversal value. A tenth of a micrometer of noise.
fn laser(reversal_um: f64, seed: u64) -> String {
    let mut noise = Noise(seed);
    let mut rows = "run,X,Y,Z,component,X_dir,value_um\n".to_owned();
    for run in 1..=2 {
        for side in [1.0, -1.0] {
            for x in (0..=600).step_by(60) {
                let um = 15e-3 * f64::from(x) + reversal_um / 2.0 * side + noise.next(0.1);
                let _ = writeln!(rows, "{run},{x},100,0,EXX,{side},{um:.3}");
            }
        }
    }
    rows
}

/// Six readings of the angle between X and Y.
fn square(urad: f64) -> String {
    let read = |off: &f64| format!("EC0Y,0,0,0,{}\n", urad + off);
    "component,X,Y,Z,value_urad\n".to_owned() + &[0.5, -0.5, 1.0, -1.0, 0.2, -0.2].iter().map(read).collect::<String>()
}

fn shop() -> Shop {
    let mut shop = Shop::new().file("bridge.toml", BRIDGE);
    for (name, reversal_um, seed) in [("spring", 4.0, 3), ("autumn", 8.0, 4), ("again", 4.0, 5)] {
        let description = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.2\n";
        shop = shop.file(&format!("{name}.csv"), laser(reversal_um, seed)).file(&format!("{name}.toml"), description);
    }
    for (name, urad) in [("granite", 20.0), ("steel", 60.0), ("granite2", 20.4)] {
        let description = "[measurement]\nkind = \"direct\"\nsigma_urad = 1.0\n";
        shop = shop.file(&format!("{name}.csv"), square(urad)).file(&format!("{name}.toml"), description);
    }
    shop
}

fn calibrate(shop: &Shop, data: &str, more: &str) -> Run {
    let words = format!("calibrate {data} --machine bridge.toml -o out.toml {more}");
    shop.run(words.split_whitespace()).exits(0)
}

/// Value and uncertainty of a parameter of the report.
fn estimate(run: &Run, name: &str) -> [f64; 2] {
    let json = run.json();
    let all = json["parameters"].as_array().unwrap();
    let one = all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{json}"));
    ["value", "sigma"].map(|key| one[key].as_f64().unwrap())
}

#[test]
fn two_reversal_values_of_one_axis_are_named() {
    let shop = shop();
    for model in ["", "--model EXX1,EXXb"] {
        let run = calibrate(&shop, "spring.csv autumn.csv", model);
        // Half of each reversal value: 2 and 4 µm.
        let said = run.stderr.lines().find(|line| line.contains("W0624")).unwrap_or_else(|| panic!("{}", run.stderr));
        for part in ["EXXb is ", "spring.csv", "autumn.csv", "combined standard uncertainties apart"] {
            assert!(said.contains(part), "{said}");
        }
        assert_eq!(run.stderr.matches("W0624").count(), 1, "{}", run.stderr);
        // Between both or at one of them, and both are within one standard uncertainty.
        let [value, sigma] = estimate(&calibrate(&shop, "spring.csv autumn.csv", &format!("{model} --json")), "EXXb");
        let reach = (value - 2.0).abs().max((value - 4.0).abs());
        assert!((1.9..4.1).contains(&value) && sigma > 0.95 * reach && sigma < 1.2 * reach, "{value} ± {sigma}");
        // The machine file has that of the whole reversal value, as the length of a list.
        let file = shop.text("out.toml");
        let list =
            file.lines().find_map(|line| line.trim().strip_prefix("EXXb = [")).unwrap_or_else(|| panic!("{file}"));
        let squares = list.trim_end_matches(']').split(',').map(|part| part.trim().parse::<f64>().unwrap().powi(2));
        assert!((squares.sum::<f64>().sqrt() - 2.0 * sigma).abs() < 0.01 * sigma, "{file}");
    }
}

#[test]
fn two_squareness_errors_are_named() {
    let shop = shop();
    let run = calibrate(&shop, "granite.csv steel.csv", "--model EC0Y --json");
    assert!(run.json().to_string().contains("W0624"), "{}", run.stdout);
    let [value, sigma] = estimate(&run, "EC0Y");
    // 20 and 60 µrad, both within one standard uncertainty.
    let reach = (value - 20.0).abs().max((value - 60.0).abs());
    assert!((19.0..61.0).contains(&value) && sigma > 0.95 * reach && sigma < 1.2 * reach, "{value} ± {sigma}");
}

#[test]
fn files_of_one_state_are_not() {
    let shop = shop();
    for data in ["spring.csv again.csv", "granite.csv granite2.csv", "spring.csv granite.csv again.csv granite2.csv"] {
        let run = calibrate(&shop, data, "");
        assert!(!run.stderr.contains("W0624"), "{data}: {}", run.stderr);
    }
    // Held out, the other file is only compared.
    let run = calibrate(&shop, "spring.csv", "--hold-out autumn.csv");
    assert!(!run.stderr.contains("W0624"), "{}", run.stderr);
}
