//! `ncfix explain`, `ncfix --help` and wrong usage.

use ncfix::diagnostic::CODES;

use crate::support::Shop;

#[test]
fn every_code_is_explained_in_any_case() {
    let shop = Shop::new();
    for row in CODES {
        let run = shop.run(["explain", &row.code.as_str().to_lowercase()]).exits(0);
        assert!(run.stdout.starts_with(&format!("{}: {}\n\n", row.code, row.title)), "{}", run.stdout);
        assert!(run.stdout.contains(row.explain));
    }
}

#[test]
fn without_a_code_all_are_listed() {
    let run = Shop::new().run(["explain"]).exits(0);
    assert_eq!(run.stdout.lines().count(), CODES.len());
}

#[test]
fn an_unknown_code_is_wrong_usage() {
    Shop::new().run(["explain", "E9999"]).exits(2).says("there is no code 'E9999'");
}

#[test]
fn help_names_examples_and_exit_statuses() {
    let run = Shop::new().run(["--help"]).exits(0);
    for text in ["Examples:", "ncfix part.mpf -o", "Exit status:", "not understood", "verify"] {
        assert!(run.stdout.contains(text), "{text}: {}", run.stdout);
    }
    assert_eq!(Shop::new().run(["--version"]).exits(0).stdout, format!("ncfix {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn nothing_at_all_is_wrong_usage() {
    Shop::new().run([""; 0]).exits(2);
}

#[test]
fn the_help_of_every_command_has_examples() {
    let shop = Shop::new();
    let all = shop.run(["--help"]).exits(0).stdout;
    let commands = all.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1);
    let commands: Vec<&str> =
        commands.take_while(|line| !line.is_empty()).filter_map(|line| line.split_whitespace().next()).collect();
    assert!(commands.len() > 8, "{commands:?}");
    for command in commands.into_iter().filter(|command| *command != "help") {
        let help = shop.run([command, "--help"]).exits(0).stdout;
        assert!(help.contains("Examples:"), "{command}\n{help}");
    }
}
