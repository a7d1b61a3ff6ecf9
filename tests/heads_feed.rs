//! Jobs of a machine with several heads: each line is that of the head in use.

use super::controls::{Blockwise, Faults, Wired};
use super::heads::{DIALECTS, STATE, corrected, shop};

/// The lines that a control gets: each part is that of its head, and only the vertical head drifts. At 25 °C it drifts by 5 K · 3 µm/K = 15 µm along Y and
/// 5 µm along X. X and Y move the table, so the correction is the drift with its sign.
#[test]
fn a_job_follows_the_heads_of_its_program() {
    let dialect = &DIALECTS[1];
    let parts = [(false, dialect.moves(false, 1)), (true, dialect.moves(true, 2)), (false, dialect.moves(false, 1))];
    let link = "name = \"own\"\nprotocol = \"block\"\n[frame]\nstart = \"15\"\n[text]\nlongest_line = 128\n";
    let sensors = "[source.v]\nkind = \"replay\"\npath = \"log.csv\"\n[channel.T_v]\nsource = \"v\"\n";
    let shop = shop(dialect, &dialect.text(&parts)).file("own.toml", link).file("s.toml", sensors);
    let shop = shop.file("log.csv", "t_s,T_v_C\n0,25.0\n3600,25.0\n");
    let fed = |more: &[&str]| {
        let bench = Wired::at_network(Blockwise::new(&Faults::default(), 0.001));
        let fixed = ["feed", dialect.file, "--machine", "both.toml", "--link", "own.toml", "--allow-starvation"];
        let rest = ["--i-checked-the-machine-stands-still", "--port", &bench.name];
        shop.run(fixed.iter().chain(&rest).chain(more)).exits(0);
        bench.executed()
    };
    let cold = ["--state", "cold.toml"];
    let shop_cold = STATE.replace("25.0", "20.0");
    std::fs::write(shop.path("cold.toml"), shop_cold).unwrap();
    let without = fed(&cold);
    // Without temperatures the lines are those of the corrected file, which the other tests judge.
    let (file, _) = corrected(&shop, dialect, "both.toml", &cold);
    let words = |lines: &[String]| -> Vec<(char, f64)> {
        let all = lines.iter().flat_map(|line| line.split_whitespace());
        let axis = |word: &str| Some((word.chars().next()?, word[1..].trim_start_matches('=').parse().ok()?));
        all.filter(|word| word.starts_with(['X', 'Y', 'Z'])).filter_map(axis).collect()
    };
    assert_eq!(words(&without), words(&file));
    let doses = ["--dose-per-block", "1mm", "--dose-per-mm", "1mm", "--dose-per-s", "1mm"];
    let warm = fed(&[&["--sensors", "s.toml"][..], &doses].concat());
    let (state, _) = corrected(&shop, dialect, "both.toml", &["--state", "state.toml"]);
    let [warm, state, cold] = [&warm, &state, &without].map(|lines| words(lines));
    let is_near = |(one, other): (&(char, f64), &(char, f64))| one.0 == other.0 && (one.1 - other.1).abs() < 0.0021;
    assert!(warm.len() == state.len() && warm.iter().zip(&state).all(is_near), "{warm:?}\n{state:?}");
    let moved = |letter: char, by: f64| {
        let both = warm.iter().zip(&cold).filter(|(one, _)| one.0 == letter);
        both.filter(|(one, other)| ((one.1 - other.1).abs() - by).abs() < 0.0021).count()
    };
    let (all_y, all_x) =
        (warm.iter().filter(|one| one.0 == 'Y').count(), warm.iter().filter(|one| one.0 == 'X').count());
    // The horizontal parts stay, the vertical one moves.
    assert!(
        moved('Y', 0.015) > 2 && moved('Y', 0.0) > 4 && moved('Y', 0.015) + moved('Y', 0.0) == all_y,
        "{warm:?}\n{cold:?}"
    );
    assert!(
        moved('X', 0.005) > 2 && moved('X', 0.0) > 4 && moved('X', 0.005) + moved('X', 0.0) == all_x,
        "{warm:?}\n{cold:?}"
    );
}
