//! `ncfix tables --watch`: tables that follow the temperatures of a log that grows.

use std::io::Write as _;
use std::time::{Duration, Instant};

use crate::support::Shop;

/// X has a scale error of 40 µm/m at 20 °C, and 8 µm/m more for each kelvin: at 500 mm 20 µm, and 4 µm more for each kelvin.
const MILL: &str = "[machine]\nname = \"mill\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 500]\n\
    [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 300]\n\
    [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n\
    [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 4e-5]\n\
    [[expansion]]\naxis = \"X\"\nfixed_mm = 0\nscale = { sensors = [\"T_scale\"], um_per_m_K = 8.0 }\n";
const WORDS: [&str; 15] = [
    "tables",
    "--machine",
    "m.toml",
    "--format",
    "cec",
    "--scheme",
    "fik",
    "-o",
    "CEC.INI",
    "--state",
    "log.csv",
    "--watch",
    "--update-s",
    "0.1",
    "--change",
];

fn shop() -> Shop {
    Shop::new().file("m.toml", MILL).file("log.csv", "t_s,T_scale_C\n0,20\n")
}

/// The correction at X 500 mm, µm.
fn last_um(text: &str) -> f64 {
    let mut values = text.lines().filter_map(|line| line.strip_prefix("$AN_CEC[0,36]=")?.parse::<f64>().ok());
    values.next_back().unwrap_or_else(|| panic!("{text}")) * 1e3
}

#[test]
fn tables_follow_a_log_that_grows() {
    let shop = shop();
    let child = shop.command(WORDS.iter().chain(&["1um", "--for", "60"]).copied()).spawn().unwrap();
    let wait = |is_so: &dyn Fn() -> bool| {
        let start = Instant::now();
        while !is_so() {
            assert!(start.elapsed() < Duration::from_secs(50));
            std::thread::sleep(Duration::from_millis(20));
        }
    };
    let append = |text: &str| {
        let mut log = std::fs::File::options().append(true).open(shop.path("log.csv")).unwrap();
        log.write_all(text.as_bytes()).unwrap();
    };
    wait(&|| shop.path("CEC.INI").exists());
    let cold = shop.text("CEC.INI");
    assert!((last_um(&cold) + 20.0).abs() < 0.1, "{cold}");
    // 0.1 K is 0.4 µm, less than the 1 µm of --change; half a row is no row: its 2 would be 2 °C.
    append("60,20.1\n");
    std::thread::sleep(Duration::from_millis(1000));
    append("120,2");
    std::thread::sleep(Duration::from_millis(1000));
    assert_eq!(shop.text("CEC.INI"), cold);
    // 25 °C: 5 K are 20 µm more.
    append("5\n");
    wait(&|| shop.text("CEC.INI") != cold);
    let warm = shop.text("CEC.INI");
    assert!((last_um(&warm) + 40.0).abs() < 0.1, "{warm}");
    // A log that cannot be used leaves the file as it is.
    append("180,hot\n");
    std::thread::sleep(Duration::from_millis(1000));
    assert_eq!(shop.text("CEC.INI"), warm);
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let (said, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{errors}");
    let lines: Vec<&str> = said.lines().filter(|line| line.contains("a change of")).collect();
    assert!(lines.len() == 1 && lines[0].ends_with("a change of 20.0 µm: CEC.INI was written"), "{said}");
    assert!(errors.contains("W0802") && errors.contains("the tables were not renewed"), "{errors}");
}

#[test]
fn a_watch_ends_after_its_time_and_needs_a_state_and_a_scheme() {
    let shop = shop();
    shop.run(WORDS.iter().chain(&["1um", "--for", "0.3"]).copied()).exits(0);
    assert!(shop.path("CEC.INI").exists());
    let auto = WORDS.map(|word| if word == "fik" { "auto" } else { word });
    shop.run(auto.iter().chain(&["1um"]).copied()).exits(2).says("--scheme other than auto");
    let stateless = ["tables", "--machine", "m.toml", "--format", "cec", "--scheme", "fik", "-o", "T.INI", "--watch"];
    shop.run(stateless).exits(2).says("--state");
}
