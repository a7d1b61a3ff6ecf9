//! `ncfix completions` and `ncfix man`: shells and the pager of manuals take what they print.

use std::io::Write as _;
use std::process::{Command, Output, Stdio};

use crate::support::Shop;

/// Whether a program can be run here.
fn has(program: &str) -> bool {
    Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
}

/// Runs a program with a text on its standard input.
fn piped(program: &str, arguments: &[&str], input: &str) -> Output {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let text = input.to_owned();
    let writer = std::thread::spawn(move || stdin.write_all(text.as_bytes()));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    output
}

/// The commands of the program, with those below them.
fn commands() -> Vec<Vec<&'static str>> {
    let help = Shop::new().run(["--help"]).exits(0).stdout;
    let names = [
        "fix",
        "check",
        "snc",
        "verify",
        "diff",
        "correct-readings",
        "max-step",
        "weigh",
        "diagnose",
        "decompose",
        "sensors",
        "feed",
        "realtime",
        "resume",
        "plan",
        "calibrate",
        "simulate",
        "iso230",
        "square",
        "tables",
        "machine",
        "explain",
        "completions",
        "man",
    ];
    names.iter().for_each(|name| assert!(help.contains(&format!("\n  {name} ")), "{name}"));
    let mut commands: Vec<Vec<&str>> = names.into_iter().map(|name| vec![name]).collect();
    commands.extend(["check", "show", "presets", "new"].map(|name| vec!["machine", name]));
    commands
}

/// The long options that a help lists.
fn options(help: &str) -> Vec<String> {
    let words = help.lines().map(str::trim_start).filter(|line| line.starts_with('-')).flat_map(str::split_whitespace);
    let mut options: Vec<String> = words
        .filter(|word| word.starts_with("--"))
        .map(|word| word.split(['.', ',', ';', ':', ')', '[']).next().unwrap().to_owned())
        .filter(|word| word.len() > 2)
        .collect();
    options.sort();
    options.dedup();
    options
}

#[test]
fn every_shell_gets_a_script() {
    for (shell, mark) in [
        ("bash", "complete -F _ncfix"),
        ("zsh", "#compdef ncfix"),
        ("fish", "complete -c ncfix"),
        ("powershell", "Register-ArgumentCompleter"),
        ("elvish", "edit:completion:arg-completer[ncfix]"),
    ] {
        let run = Shop::new().run(["completions", shell]).exits(0);
        assert!(run.stdout.contains(mark), "{shell}");
        assert!(run.stdout.contains("max-correction") && run.stdout.contains("calibrate"), "{shell}");
        assert_eq!(run.stderr, "");
    }
    Shop::new().run(["completions", "csh"]).exits(2).says("possible values: bash");
}

#[test]
fn bash_completes_commands_and_options() {
    if !has("bash") {
        // There is no bash on this system, and nothing else that reads its scripts.
        return;
    }
    let script = Shop::new().run(["completions", "bash"]).exits(0).stdout;
    assert!(piped("bash", &["-n"], &script).status.success());
    let complete = |words: &[&str]| -> Vec<String> {
        let quoted: Vec<String> = words.iter().map(|word| format!("'{word}'")).collect();
        let last = words.len() - 1;
        let call = format!(
            "{script}\nCOMP_WORDS=({})\nCOMP_CWORD={last}\n_ncfix ncfix '{}' '{}'\nprintf '%s\\n' \"${{COMPREPLY[@]}}\"\n",
            quoted.join(" "),
            words[last],
            words[last - 1]
        );
        let output = piped("bash", &["--norc"], &call);
        assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
    };
    assert_eq!(complete(&["ncfix", "cali"]), ["calibrate"]);
    assert_eq!(complete(&["ncfix", "calibrate", "--hold"]), ["--hold-out"]);
    assert_eq!(complete(&["ncfix", "machine", "pre"]), ["presets"]);
    assert_eq!(complete(&["ncfix", "machine", "show", "--orig"]), ["--origin"]);
    assert_eq!(complete(&["ncfix", "fix", "--arcs", "ch"]), ["chords"]);
    assert_eq!(complete(&["ncfix", "check", "--qui"]), ["--quiet"]);
}

#[test]
fn every_page_names_every_option_and_what_a_status_means() {
    for command in commands() {
        let help = Shop::new().run(command.iter().chain(&["--help"])).exits(0).stdout;
        let page = Shop::new().run(["man"].iter().chain(&command)).exits(0).stdout;
        // Hyphens that are part of a word are written \- in a page.
        let plain = page.replace("\\-", "-");
        let named = options(&help);
        assert!(named.len() >= 3, "{command:?}: {named:?}");
        for option in named {
            assert!(plain.contains(&option), "{command:?} {option}");
        }
        for text in [".SH \"EXIT STATUS\"", ".SH EXAMPLES", ".SH ENVIRONMENT", "NCFIX_MACHINE", "usage error"] {
            assert!(plain.contains(text), "{command:?} {text}\n{plain}");
        }
    }
}

#[test]
fn pages_are_set_without_a_warning() {
    let shop = Shop::new();
    shop.run(["man", "-o", "pages"]).exits(0).says("30 pages written into pages");
    let names: Vec<_> = std::fs::read_dir(shop.path("pages")).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(names.len(), 30);
    for name in ["ncfix.1", "ncfix-fix.1", "ncfix-machine-show.1", "ncfix-tables.1"] {
        assert!(shop.path("pages").join(name).is_file(), "{name}");
    }
    if !has("groff") {
        // Only groff (behind man, too) knows what a page is; without it there is nobody to ask.
        return;
    }
    for path in names {
        let page = path.display().to_string();
        let output =
            Command::new("groff").args(["-man", "-ww", "-Kutf8", "-Tutf8", "-P-cbou", &page]).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && said.is_empty(), "{page}: {said}");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(text.contains("EXIT STATUS") && text.contains("EXAMPLES"), "{page}");
    }
}

#[test]
fn a_command_that_is_not_there_has_no_page() {
    Shop::new().run(["man", "cook"]).exits(2).says("'cook' is not a command of ncfix; commands: fix, check");
    Shop::new().run(["man", "machine", "cook"]).exits(2).says("of ncfix machine; commands: check, show, presets");
}
