//! `ncfix explain`, `ncfix --help` and wrong usage.

use ncfix_base::diagnostic::CODES;

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

/// First words of an instruction to the reader.
const INSTRUCTIONS: &str = "Accept Add Allow Change Check Choose Compare Correct Delete Divide End Enter Export Free Give Jump Load Look \
                            Make Measure Move Name Omit Position Program Put Read Remove Rename Renumber Replace Restore Round Save \
                            Search Select Send Set Sort Split State Transfer Turn Use Write";

/// A text says what happened and why it matters; a person then needs the next step. It begins a sentence, so that it is found at a glance.
#[test]
fn every_explanation_says_what_to_do() {
    for row in CODES {
        // Examples are indented.
        let text = row.explain.split("\n\n").filter(|part| !part.starts_with("  "));
        let sentences = text.flat_map(|part| part.split(['.', '?', ':']));
        let mut openings =
            sentences.flat_map(|sentence| sentence.split("\n- ")).filter_map(|one| one.split_whitespace().next());
        let says = openings.any(|word| INSTRUCTIONS.split_whitespace().any(|own| own == word));
        assert!(says, "{}: no sentence begins with an instruction\n{}", row.code, row.explain);
        assert!(
            row.explain.split_whitespace().count() >= 15,
            "{}: what, why and what to do\n{}",
            row.code,
            row.explain
        );
    }
}

#[test]
fn without_a_code_all_are_listed() {
    let run = Shop::new().run(["explain"]).exits(0);
    let mut codes: Vec<&str> = CODES.iter().map(|row| row.code.as_str()).collect();
    codes.sort_unstable();
    let listed: Vec<&str> = run.stdout.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(listed, codes);
}

#[test]
fn an_unknown_code_is_wrong_usage() {
    Shop::new().run(["explain", "E9999"]).exits(2).says("no code and no text has 'E9999'");
    Shop::new().run(["explain", "zyxwv"]).exits(2).says("no code and no text has 'zyxwv'");
}

#[test]
fn words_find_questions_and_codes() {
    let shop = Shop::new();
    let found = shop.run(["explain", "overwrite", "my", "program"]).exits(0);
    assert!(found.stdout.starts_with("Is my program overwritten?\n  No. "), "{}", found.stdout);
    // The page of the answer, without signs of Markdown.
    assert!(found.stdout.contains("docs/reference/command-line.md#output-files"), "{}", found.stdout);
    assert!(!found.stdout.contains("]("), "{}", found.stdout);
    let found = shop.run(["explain", "touching off the zero"]).exits(0);
    assert!(found.stdout.contains("How do I state that the zero was touched?"), "{}", found.stdout);
    assert!(found.stdout.contains("\nW0321  "), "{}", found.stdout);
}

/// The question about the alarm of a guard, as it is printed.
const GUARD_ALARM: &str =
    "The control stops with an alarm at the start, such as `G54 X CHANGED SINCE CORRECTION`: what now?";

const TRANSFER: &str = "How do I transfer (send, copy, upload) the corrected program to the control?";

const HEIGHT_MAP: &str =
    "Is a warped workpiece, such as a PCB, corrected with a height map (auto level, bed leveling)?";

/// The words of a person in a shop, and the text that must be among the first three answers.
#[test]
fn words_of_the_shop_find_the_answer() {
    let shop = Shop::new();
    for (words, wanted) in [
        ("program stopped tool broke block", "The program stopped, or the tool broke: how do I go on at a block?"),
        ("tool broken", "The program stopped, or the tool broke: how do I go on at a block?"),
        ("corners", "My corners are not square, the diagonals differ: what now?"),
        ("diagonals", "My corners are not square, the diagonals differ: what now?"),
        ("out of square", "My corners are not square, the diagonals differ: what now?"),
        ("Haas", "What happens to the codes of a Haas, such as G154, G187, G84 and G28?"),
        ("G154", "What happens to the codes of a Haas, such as G154, G187, G84 and G28?"),
        ("feedrate changes", "When does F change?"),
        ("three touches", "I touched X, Y and Z at three different places with one tool: how do I state this?"),
        ("sensor fails dnc", "A temperature sensor fails during the drip feed: what now?"),
        ("ballbar", "From a ball-bar export to a corrected part"),
        ("ball-bar", "From a ball-bar export to a corrected part"),
        ("holdout", "How do I test a fit on data that it did not use?"),
        ("hold-out", "How do I test a fit on data that it did not use?"),
        ("restart after power cut", "Power cut while the control ran the program: what now?"),
        ("alarm", GUARD_ALARM),
        ("alarm at the start", GUARD_ALARM),
        ("3001", GUARD_ALARM),
        ("65000", GUARD_ALARM),
        ("SETAL", GUARD_ALARM),
        ("#3000", GUARD_ALARM),
        ("CHANGED SINCE CORRECTION", GUARD_ALARM),
        ("machine builder", "What happens to feeds, spindle, coolant, tools and M codes?"),
        ("coolant", "What happens to feeds, spindle, coolant, tools and M codes?"),
        ("M88", "What happens to feeds, spindle, coolant, tools and M codes?"),
        ("edge finder", "How do I state that the zero was touched?"),
        ("rectangle too long X", "A rectangle is too long in X: what now?"),
        ("subprograms in other files", "My subprograms are in other files: where does ncfix look?"),
        ("check it", "The verdict is check it before it runs: what do I do?"),
        ("yaw", "Which instrument measures pitch, yaw and roll of a linear axis?"),
        ("SAMBA", "Can I use SAMBA, RUMBA or an R-test?"),
        ("R-test", "Can I use SAMBA, RUMBA or an R-test?"),
        ("unexplained", "Where are the residuals of single readings?"),
        ("router gantry crooked", "A hobby router out of square: corners, diagonals"),
        ("transfer program to machine", TRANSFER),
        ("send program USB", TRANSFER),
        ("program with drilling cycles", "What happens to drilling cycles (G81, G83, CYCLE81, CYCLE83)?"),
        ("height map", HEIGHT_MAP),
        ("bed leveling", HEIGHT_MAP),
        ("raise air cut Haas", "How do I raise a program for an air cut?"),
        ("compare two measurements", "How do I compare two measurements of one machine, before and after?"),
        ("granite square squareness", "How do I enter a squareness measured with a granite square?"),
        ("thermal effects sensors model", "How are thermal effects modeled, and with which sensors?"),
        (
            "predict volumetric error interval work volume",
            "How do I predict the volumetric error over the work volume, with an interval?",
        ),
        ("99 %", "What do the percentages of a diagnosis mean, such as 99 %?"),
        ("correct a point", "How do I find the correction of one point (a position)?"),
        ("units of the library", "What are units, frames and signs of the API (library)?"),
        // Sections of pages.
        ("what is not corrected", "What is not corrected"),
        ("how does diagnosis decide", "How diagnosis decides"),
        ("state hypothesis", "Terms of a hypothesis"),
        ("MD32700", "Formats of compensation tables: `enc`: `$AA_ENC_COMP`"),
        ("measure rotary axis", "Calibrate a five-axis machine by probing balls: Which instrument shows which error"),
    ] {
        let found = shop.run(["explain", words]).exits(0).stdout;
        // An answer is its title, and then lines that are indented.
        let titles: Vec<&str> = found.lines().filter(|line| !line.is_empty() && !line.starts_with(' ')).collect();
        assert!(titles.iter().take(3).any(|title| *title == wanted), "{words}: {titles:#?}");
    }
}

#[test]
fn a_code_of_a_control_is_found_with_its_meaning() {
    let found = Shop::new().run(["explain", "G154"]).exits(0).stdout;
    assert!(found.contains("\nG154  Fanuc and Haas: additional work coordinate system"), "{found}");
    let found = Shop::new().run(["explain", "M06"]).exits(0).stdout;
    assert!(found.contains("M6  RS274/NGC: "), "{found}");
}

#[test]
fn too_little_in_common_finds_nothing() {
    for words in ["zyxwv program", "purple elephant tool", "zyxwv yxwvz zero"] {
        Shop::new().run(["explain", words]).exits(2).says("no code and no text has");
    }
}

#[test]
fn help_names_examples_and_exit_statuses() {
    let run = Shop::new().run(["--help"]).exits(0);
    for text in ["Examples:", "ncfix part.mpf -o", "Exit status:", "cannot execute", "verify"] {
        assert!(run.stdout.contains(text), "{text}: {}", run.stdout);
    }
    assert_eq!(Shop::new().run(["--version"]).exits(0).stdout, format!("ncfix {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn nothing_at_all_is_wrong_usage() {
    Shop::new().run([""; 0]).exits(2);
}

#[test]
fn contradictions_are_refused() {
    for line in [
        "a.mpf",
        "a.mpf -o b.mpf --in-place",
        "a.mpf -o b.mpf --tolerance 5",
        "a.mpf -o b.mpf --tolerance=-5um",
        "a.mpf -o b.mpf --arcs maybe",
        "-q check -v a.mpf",
    ] {
        // Nothing is read: there is no a.mpf, and it is not named.
        let shown = Shop::new().run(line.split(' ')).exits(2).stderr;
        assert!(!shown.contains("cannot read"), "{line}: {shown}");
    }
}

#[test]
fn the_help_of_every_command_says_its_statuses_and_ends_with_examples() {
    let shop = Shop::new();
    let all = crate::command_pages::commands(&shop.run(["--help"]).exits(0).stdout);
    assert!(all.len() > 20, "{all:?}");
    let mut commands: Vec<Vec<String>> = vec![Vec::new()];
    commands.extend(all.into_iter().map(|command| vec![command]));
    let machine = crate::command_pages::commands(&shop.run(["machine", "--help"]).exits(0).stdout);
    assert_eq!(machine, ["check", "show", "presets", "new"]);
    commands.extend(machine.into_iter().map(|command| vec!["machine".to_owned(), command]));
    for command in commands {
        let help = shop.run(command.iter().map(String::as_str).chain(["--help"])).exits(0).stdout;
        let (said, examples) = help.split_once("\nExamples:\n").unwrap_or_else(|| panic!("{command:?}\n{help}"));
        assert!(said.contains("Exit status:\n  0  "), "{command:?}\n{help}");
        // Nothing but commands to try; a long one is wrapped.
        for line in examples.lines() {
            let is_example = line.starts_with("  ncfix ") || line.starts_with("  source <(ncfix ");
            assert!(is_example || line.starts_with("  ") && line.len() < 100, "{command:?} ends with: {line}");
        }
        assert!(examples.starts_with("  ncfix "), "{command:?}: {examples}");
        let of_link = ["feed", "resume"].iter().any(|name| command.iter().any(|word| word == name));
        assert_eq!(said.contains("  6  the control refused"), of_link, "{command:?}");
    }
}

#[test]
fn what_is_wrong_with_a_command_line_names_what_to_write() {
    let shop = Shop::new().file("part.mpf", "N10 M30\n");
    for (words, says) in [
        (&["part.mpf"][..], "<--output <OUT>|--in-place|--zero-shift <FILE>>"),
        (&["chek", "part.mpf"], "did you mean `ncfix check`?"),
        (&["check", "part.mpf", "--machin", "m.toml"], "'--machine'"),
        (
            &["check", "part.mpf", "--machine", "m.toml"],
            "cannot read m.toml: there is no such file or folder (machine file, --machine)",
        ),
        (&["check", "part.mpf", "--setup", "s.toml"], "(set-up file, --setup)"),
        (&["part.mpf", "-o", "o.mpf", "--state", "s.toml"], "(state, --state)"),
        (&["check", "part.mpf", "--dialect", "funuc"], "did you mean --dialect fanuc?"),
        (&["part.mpf", "-o", "o.mpf", "--tolerance", "5"], "'--tolerance <LENGTH>': '5' has no unit"),
        (&["machine", "show", "--json"], "give --at or --origin"),
    ] {
        shop.run(words).exits(2).says(says);
    }
}
