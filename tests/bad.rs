//! Every code of a diagnostic has a bad sample or a test that covers it. The diagnostics of each bad program are a snapshot beside its source.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use ncfix_base::diagnostic::CODES;

use crate::support::{Shop, dialects, machine, repository};

/// Codes that no program and no machine file can provoke, with the test that covers each.
const COVERED_ELSEWHERE: &[(&str, &str)] = &[
    ("W0246", "left_over_values: an_offset_that_grows_from_run_to_run_is_named"),
    ("W0247", "left_over_values: a_radius_of_0_under_compensation_is_named"),
    ("W0245", "left_over_values: the_length_of_another_tool_is_named"),
    ("W0409", "doubtful_signs: a_backlash_that_goes_too_far_is_named"),
    ("W0407", "machine_new: data_of_the_control_that_contradict_the_machine_file_are_named"),
    ("E0313", "rotary_feeds: what_cannot_say_a_time_is_refused"),
    ("E0243", "cases: every_case_comes_out_as_its_source_says"),
    ("E0244", "heads: what_makes_the_change_unsure_is_refused"),
    ("W0239", "milling: a_correction_says_that_the_strokes_of_a_milling_cycle_are_its_own"),
    ("W0238", "cli_check: a_program_that_moves_nothing_is_pointed_out"),
    ("W0235", "cases: every_case_comes_out_as_its_source_says"),
    ("E0112", "cases: every_case_comes_out_as_its_source_says"),
    ("E0240", "five_axis: poles_and_directions_out_of_reach_are_found_with_their_place"),
    ("E0241", "five_axis: poles_and_directions_out_of_reach_are_found_with_their_place"),
    ("E0308", "cli_fix: a_pose_where_two_linear_axes_are_parallel_has_no_correction"),
    ("E0310", "cli_fix: the_input_is_never_overwritten"),
    ("E0311", "cli_verify: programs_that_differ_cannot_be_compared"),
    ("E0319", "edits: every_edit_is_found_and_named"),
    ("E0320", "edits: every_edit_is_found_and_named"),
    ("E0321", "edits: every_edit_is_found_and_named"),
    ("W0314", "edits: every_edit_is_found_and_named"),
    ("W0315", "edits: every_edit_is_found_and_named"),
    ("W0325", "block_cycle: blocks_shorter_than_the_cycle_are_counted_and_their_division_is_a_warning"),
    ("W0309", "cli_feed_limit: what_cannot_be_slowed_is_named_with_its_line"),
    ("E0314", "newer_files: a_program_that_changes_while_it_is_corrected_stays"),
    ("E0315", "unreadable: a_block_behind_a_carriage_return_is_refused_in_every_language"),
    ("E0316", "unreadable: characters_that_do_not_show_are_refused"),
    ("E0501", "cli_state: what_the_model_needs_and_the_state_lacks_is_said"),
    ("W0501", "cli_state: what_the_model_needs_and_the_state_lacks_is_said"),
    ("W0502", "cli_state: what_the_model_needs_and_the_state_lacks_is_said"),
    ("W0503", "load: a_load_off_the_center_of_a_turning_table_is_pointed_out"),
    ("E0601", "measured: tables_that_are_none_are_refused_at_their_place"),
    ("E0602", "measured: columns_must_fit_the_machine"),
    ("E0603", "measured: cells_must_be_numbers"),
    ("E0604", "strain: readings_that_tell_no_load_are_refused"),
    ("E0605", "cli_calibrate: wrong_input_is_found_at_its_place"),
    ("E0606", "cli_calibrate: what_the_data_cannot_tell_is_named"),
    ("E0607", "crates/metrology/src/results/not_identified.rs: every_fault_is_a_refusal"),
    ("E0608", "cli_calibrate: readings_of_another_unit_are_refused"),
    ("E0609", "cli_calibrate: parameters_must_be_those_of_the_machine"),
    ("E0613", "instruments: a_drift_is_only_taken_out_where_there_is_no_reversal"),
    ("E0614", "diagnose_faults: the_command_reports_faults_and_refuses_what_is_no_data"),
    ("E0615", "diagnose_hypothesis: wrong_text_is_refused_at_its_column"),
    ("E0616", "import: what_the_file_leaves_open_is_asked_with_its_option"),
    ("E0617", "import: files_without_a_layout_are_refused_with_the_export_to_use"),
    ("E0618", "import: files_that_contradict_themselves_are_refused"),
    ("E0701", "cli_feed: what_the_link_cannot_take_is_found_before_anything_is_sent"),
    ("E0702", "cli_feed: a_link_that_is_too_slow_is_refused_beforehand"),
    ("E0703", "cli_feed: the_journal_of_a_broken_job_is_not_overwritten"),
    ("E0704", "cli_feed: what_has_changed_is_not_taken_up_again"),
    ("E0705", "cli_resume: a_link_without_a_question_needs_a_person_who_looked"),
    ("E0706", "cli_resume: a_program_of_one_depth_is_not_taken_up_again_without_a_clearance"),
    ("E0707", "cli_resume: a_program_of_one_depth_is_not_taken_up_again_without_a_clearance"),
    ("W0701", "cli_feed: a_link_that_is_too_slow_is_refused_beforehand"),
    ("W0704", "cli_feed: a_link_names_the_controls_that_cannot_use_it"),
    ("W0703", "lsv2: paths_sensors_and_dialects_are_checked_before_the_port_is_opened"),
    ("W0702", "cli_feed: a_pseudo_terminal_says_what_it_does_not_take"),
    ("W0603", "cli_calibrate: a_gross_outlier_is_listed_and_does_no_harm"),
    ("W0605", "cli_calibrate: a_model_is_reduced_to_what_the_data_tell"),
    ("W0606", "crates/metrology/src/results/repeated.rs: uncertainties_that_repetitions_contradict_are_named"),
    ("W0608", "calibrate_terms: a_term_that_the_readings_do_not_show_is_named"),
    ("W0609", "import_wrong: missing_rows_are_named"),
    ("W0610", "strangers: the_slope_of_a_height_map_is_not_that_of_the_axis"),
    ("W0611", "strangers: a_scale_from_circles_of_unknown_length_is_relative"),
    ("W0244", "cases: every_case_comes_out_as_its_source_says"),
    ("W0243", "fixed_values: a_position_or_a_branch_from_data_of_the_control_is_named"),
    ("W0335", "datum: a_touch_without_angles_is_named"),
    ("W0332", "not_shown: a_straightness_that_no_reading_shows_is_named"),
    ("W0622", "signs_and_lines: a_squareness_under_the_letter_of_the_other_axis_is_turned"),
    ("W0624", "calibrate_contradiction: two_reversal_values_of_one_axis_are_named"),
    ("W0625", "calibrate_sorted: a_sorted_grid_has_no_backlash"),
    ("W0623", "signs_and_lines: a_calibrated_length_needs_its_uncertainty"),
    ("W0621", "reference_lines: an_appended_uncertainty_is_named_when_it_is_replaced"),
    ("W0620", "not_shown: a_squareness_that_the_readings_show_and_the_model_lacks_is_named"),
    ("W0615", "strangers: two_reference_temperatures_are_named"),
    ("W0607", "diagnose_faults: the_command_reports_faults_and_refuses_what_is_no_data"),
    ("W0604", "cli_calibrate: a_poor_model_is_pointed_out"),
    ("W0601", "strain: places_that_the_signals_do_not_tell_are_assumed"),
    ("W0602", "strain: the_command_writes_a_state_file"),
    ("W0308", "unknown_sense: without_room_the_side_stays_unknown_and_is_told"),
    ("E0901", "cli_tables: active_tables_that_cannot_be_read_forbid_the_program"),
    ("E0902", "cli_tables: what_does_not_fit_is_refused_and_nothing_is_written"),
    ("E0903", "worse_than_none: tables_that_make_it_worse_are_not_written"),
    ("E0904", "worse_than_none: a_correction_coarser_than_the_error_is_refused"),
    ("W0901", "cli_tables: a_table_file_with_surplus_is_read_with_a_warning"),
    ("E0801", "realtime: a_line_that_is_no_set_point_ends_the_run"),
    ("W0903", "cli_tables: assumed_numbers_of_axes_are_named"),
    ("W0902", "cli_tables_read: products_are_read_as_the_control_reads_them"),
    ("W0801", "realtime: a_kernel_that_cannot_follow_the_model_is_pointed_out"),
    ("W0802", "realtime: a_state_that_breaks_leaves_the_kernel_in_force"),
    ("E0325", "zero_shift: a_drift_that_varies_over_the_part_is_refused"),
    ("E0324", "cycles_stay: a_longer_output_than_allowed_is_refused"),
    ("E0322", "coverage: a_release_gate_refuses_gaps_and_writes_nothing"),
    ("E0323", "agreement: a_corrected_program_finds_its_own_machine"),
    ("W0316", "coverage: rotary_axes_that_were_never_measured_are_named_and_nothing_is_green"),
    ("W0317", "coverage: a_position_beyond_the_measured_range_is_named_with_its_distance_and_size"),
    ("W0318", "coverage: a_longer_tool_is_named_where_angles_matter"),
    ("W0319", "coverage: an_axis_without_a_stated_range_is_named"),
    ("W0320", "coverage: temperatures_and_loads_beyond_the_measured_ones_are_named"),
    ("W0306", "cli_verify: a_correction_for_another_machine_is_pointed_out"),
    ("W0322", "coverage: a_cut_at_an_unknown_position_is_named"),
    ("W0324", "coverage: rotary_axes_that_nothing_positions_are_named"),
    ("W0612", "calibration_report: a_slope_outside_the_model_is_named"),
    ("W0240", "strangers: a_state_that_the_control_keeps_is_named"),
    ("E0620", "calibrate_terms: a_term_that_the_machine_file_cannot_hold_has_its_own_code"),
    ("E0619", "iso230: a_laser_with_the_wrong_sign_is_refused_by_its_test"),
    ("W0614", "sensor_nest: a_bent_sensor_is_named_and_a_cubic_response_follows_it"),
    ("W0613", "cli_calibrate: scales_without_a_known_distance_rest_on_the_pivots"),
    ("W0242", "part_programs: a_measuring_program_that_sets_an_offset_is_named"),
    ("W0241", "strangers: words_that_a_firmware_lacks_are_named_and_its_cycles_are_moves"),
    ("W0330", "not_shown: a_squareness_that_no_reading_shows_is_named"),
    ("W0327", "coverage: a_tool_of_negative_length_is_named"),
    ("W0333", "bare_tool: a_tool_that_cuts_without_its_length_is_named"),
    ("W0326", "datum: the_length_of_the_tool_at_the_touch_is_asked_for_where_it_matters"),
    ("W0331", "datum: a_zero_that_no_tool_reaches_is_named"),
    ("W0328", "datum: a_stated_zero_in_which_nothing_moves_is_pointed_out"),
    ("W0321", "datum: what_nobody_states_is_pointed_out_with_its_size"),
];

/// The codes of the diagnostics as they are drawn.
fn drawn_codes(stderr: &str) -> Vec<String> {
    let heads = stderr.lines().filter(|line| line.starts_with("error[") || line.starts_with("warning["));
    let codes: BTreeSet<String> =
        heads.filter_map(|line| Some(line.split_once('[')?.1.split_once(']')?.0.to_owned())).collect();
    codes.into_iter().collect()
}

/// All bad programs, each with its machine.
fn programs() -> Vec<(PathBuf, &'static str)> {
    let of = |(dialect, machine): (&str, &'static str)| {
        files(&format!("samples/programs/{dialect}/bad")).into_iter().map(move |path| (path, machine))
    };
    dialects().into_iter().flat_map(of).collect()
}

/// Files of a folder of the repository.
fn files(folder: &str) -> Vec<PathBuf> {
    let mut files: Vec<_> = fs::read_dir(repository(folder)).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_none_or(|extension| extension != "md"));
    files.sort();
    files
}

/// The code in a file name such as `E0203_arc_end_off_circle.mpf`.
fn code(path: &Path) -> String {
    path.file_name().unwrap().to_str().unwrap()[..5].to_owned()
}

/// What a corrected bad program would be called.
const OUTPUT: &str = "corrected";

/// The arguments for a bad program: those of a comment in its first lines, see the README of the samples.
fn arguments(path: &Path, on: &str) -> Vec<String> {
    let bytes = fs::read(path).unwrap();
    let head: Vec<String> =
        bytes.split(|&byte| byte == b'\n').take(3).map(|line| String::from_utf8_lossy(line).into_owned()).collect();
    let mut words: Vec<String> = head
        .iter()
        .find_map(|line| line.split_once("args: "))
        .map_or(Vec::new(), |(_, words)| words.trim_end_matches(')').split_whitespace().map(str::to_owned).collect());
    if words.first().is_none_or(|word| word.starts_with('-')) {
        words.splice(0..0, ["fix", "-o", OUTPUT].map(str::to_owned));
    }
    words.insert(1, path.file_name().unwrap().to_str().unwrap().to_owned());
    if code(path) != "W0304" {
        words.extend(["--machine".to_owned(), machine(on)]);
    }
    words
}

#[test]
fn every_bad_program_provokes_its_code_and_no_other() {
    let mut wrong = Vec::new();
    for (path, on) in programs() {
        let shop = Shop::new().copy(path.to_str().unwrap());
        let mut arguments = arguments(&path, on);
        let is_stream = arguments[0] == "snc";
        if !is_stream {
            arguments.push("--json".to_owned());
        }
        let run = shop.run(&arguments);
        let found = if is_stream { drawn_codes(&run.stderr) } else { run.codes() };
        if found != [code(&path)] {
            wrong.push(format!("{}: {found:?}", path.display()));
        }
        let is_error = code(&path).starts_with('E');
        assert_eq!(run.code == 0, !is_error, "{}: exit status {}", path.display(), run.code);
        assert!(!(is_error && shop.path(OUTPUT).exists()), "{} was written", path.display());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_finding_is_drawn() {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_snapshot_path("snapshots/bad");
    settings.set_omit_expression(true);
    for (path, on) in programs() {
        let shop = Shop::new().copy(path.to_str().unwrap());
        let run = shop.run(arguments(&path, on));
        let stderr = run.stderr.split("\n\n").filter(|part| part.contains("]: ")).collect::<Vec<_>>().join("\n\n");
        let source = String::from_utf8_lossy(&fs::read(&path).unwrap()).into_owned();
        let source: String = source.lines().map(|line| format!("{line:.120}\n")).collect();
        settings.bind(|| {
            insta::assert_snapshot!(path.file_stem().unwrap().to_str().unwrap(), format!("{source}\n---\n{stderr}\n"));
        });
    }
}

#[test]
fn every_code_has_a_sample() {
    let mut covered: BTreeSet<String> = COVERED_ELSEWHERE.iter().map(|(code, _)| (*code).to_owned()).collect();
    covered.extend(programs().iter().map(|(path, _)| code(path)));
    covered.extend(files("samples/machines/bad").iter().map(|path| code(path)));
    let known: BTreeSet<String> = CODES.iter().map(|row| row.code.as_str().to_owned()).collect();
    assert_eq!(known.len(), CODES.len(), "a code stands twice in the register");
    assert_eq!(covered.difference(&known).collect::<Vec<_>>(), [""; 0], "samples of codes that do not exist");
    assert_eq!(known.difference(&covered).collect::<Vec<_>>(), [""; 0], "codes without a sample");
}

/// A code that is said to be covered elsewhere by a test that is gone would be covered by none.
#[test]
fn the_tests_that_cover_other_codes_exist() {
    for (code, covered) in COVERED_ELSEWHERE {
        let (place, name) = covered.split_once(": ").unwrap();
        let file = if place.ends_with(".rs") { place.to_owned() } else { format!("tests/{place}.rs") };
        let text = fs::read_to_string(repository(&file)).unwrap_or_else(|_| panic!("{code}: there is no {file}"));
        assert!(text.contains(&format!("fn {name}(")), "{code}: {file} has no test {name}");
    }
}
