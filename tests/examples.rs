//! The examples run, and are short enough to be read.

#[path = "../examples/correct_a_program.rs"]
mod correct_a_program;
#[path = "../examples/error_at_a_pose.rs"]
mod error_at_a_pose;
#[path = "../examples/feed_with_own_sensor.rs"]
mod feed_with_own_sensor;
#[path = "../examples/fit_ball_bar_data.rs"]
mod fit_ball_bar_data;

/// Lines of an example at most.
const MOST_LINES: usize = 60;

#[test]
fn a_program_is_corrected() {
    correct_a_program::main().unwrap();
}

#[test]
fn a_machine_says_its_error_at_a_pose() {
    error_at_a_pose::main().unwrap();
}

#[test]
fn a_link_is_fed_with_a_sensor_of_ones_own() {
    feed_with_own_sensor::main().unwrap();
}

#[test]
fn parameters_are_fitted_to_a_ball_bar() {
    fit_ball_bar_data::main().unwrap();
}

#[test]
fn no_example_is_long() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let lines = std::fs::read_to_string(&path).unwrap().lines().count();
        assert!(lines <= MOST_LINES, "{} has {lines} lines", path.display());
    }
}
