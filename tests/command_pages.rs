//! A page for every command: what `--help` says, and where there is more. `NCFIX_WRITE_DOCS=1 cargo test command_pages` writes them.

use std::fs;

use crate::support::{Shop, repository};

/// Where there is more about a command.
const MORE: &[(&str, &[&str])] = &[
    (
        "fix",
        &[
            "tutorial",
            "how-to/cam-five-axis-program",
            "how-to/lower-feeds",
            "how-to/review-and-release",
            "reference/command-line",
            "reference/output",
            "reference/settings",
            "reference/servo",
            "reference/temperature",
            "reference/load",
        ],
    ),
    ("check", &["how-to/refused-program", "reference/languages", "reference/codes"]),
    ("snc", &["reference/languages", "reference/output", "reference/snc"]),
    ("diff", &["how-to/review-and-release", "reference/review"]),
    ("verify", &["how-to/review-and-release", "reference/review"]),
    ("max-step", &["explanation/speed", "reference/output"]),
    ("plan", &["reference/plan", "explanation/comparison"]),
    ("simulate", &["reference/data-files", "reference/servo"]),
    ("import", &["how-to/import-an-instruments-file", "reference/instrument-files", "reference/data-files"]),
    ("correct-readings", &["how-to/correct-readings", "reference/output"]),
    ("iso230", &["reference/figures"]),
    ("square", &["how-to/describe-a-new-machine", "how-to/hobby-router-out-of-square"]),
    ("weigh", &["how-to/correct-for-the-weight", "reference/load"]),
    (
        "calibrate",
        &[
            "how-to/ball-bar-to-corrected-part",
            "how-to/calibrate-a-five-axis-machine",
            "reference/calibrate",
            "reference/data-files",
            "explanation/calibration",
        ],
    ),
    ("diagnose", &["how-to/find-what-the-model-lacks", "reference/diagnose", "explanation/diagnosis"]),
    ("decompose", &["reference/decompose", "reference/servo"]),
    ("sensors", &["reference/sensors", "reference/temperature"]),
    ("machine", &["reference/machine-file", "how-to/state-a-new-error-term", "reference/motion", "reference/settings"]),
    ("tables", &["how-to/laser-to-control-tables", "reference/tables", "reference/table-formats"]),
    ("feed", &["how-to/drip-feed-with-a-temperature-sensor", "reference/feed", "reference/sensors"]),
    ("resume", &["reference/feed", "how-to/restart"]),
    ("realtime", &["reference/realtime"]),
    ("explain", &["how-to/refused-program", "reference/codes"]),
    ("completions", &[]),
    ("man", &[]),
];

/// The groups of commands of a help with their names, `help` aside: paragraphs between the usage and the arguments.
fn groups(help: &str) -> Vec<(String, Vec<String>)> {
    let is_heading = |line: &&str| !line.starts_with(' ') && line.ends_with(':');
    let lists = help.split("\n\n").skip_while(|block| !block.starts_with("Usage: ")).skip(1);
    let lists = lists.take_while(|block| !block.starts_with("Arguments:") && !block.starts_with("Options:"));
    lists
        .filter_map(|block| {
            let heading = block.lines().find(is_heading)?.trim_end_matches(':').to_owned();
            let names = block.lines().skip(1).filter_map(|line| line.strip_prefix("  "));
            let names = names.filter(|line| !line.starts_with(' ')).filter_map(|line| line.split_whitespace().next());
            Some((heading, names.filter(|name| *name != "help").map(str::to_owned).collect()))
        })
        .collect()
}

/// The names of the commands of a help.
pub(crate) fn commands(help: &str) -> Vec<String> {
    groups(help).into_iter().flat_map(|(_, names)| names).collect()
}

/// The help of a command as Markdown: the sentences as text, the rest as it is printed.
fn section(title: &str, help: &str) -> String {
    let (about, rest) = help.split_once("\nUsage: ").unwrap();
    format!("{title}\n\n{}\n\n```text\nUsage: {}\n```\n", about.trim(), rest.trim_end())
}

#[test]
fn every_command_has_a_page() {
    let shop = Shop::new();
    let help = |words: &[&str]| shop.run(words.iter().copied().chain(["--help"])).exits(0).stdout;
    let names = commands(&help(&[]));
    assert_eq!(
        names,
        MORE.iter().map(|(name, _)| (*name).to_owned()).collect::<Vec<_>>(),
        "MORE has them in this order"
    );
    let folder = repository("docs/commands");
    let mut index =
        "# Commands\n\nEach page shows the help of a command. `ncfix man COMMAND` prints it as a manual page.\n"
            .to_owned();
    let mut pages = Vec::new();
    let groups = groups(&help(&[]));
    for (name, more) in MORE {
        if let Some((group, _)) = groups.iter().find(|(_, names)| names.first().is_some_and(|first| first == name)) {
            index += &format!("\n## {group}\n\n| command | |\n| --- | --- |\n");
        }
        let text = help(&[name]);
        let first = text.split("\n\n").next().unwrap_or_default().replace('\n', " ");
        index += &format!("| [`ncfix {name}`]({name}.md) | {first} |\n");
        let mut page = section(&format!("# ncfix {name}"), &text);
        for inner in commands(&text) {
            page += "\n";
            page += &section(&format!("## ncfix {name} {inner}"), &help(&[name, &inner]));
        }
        if !more.is_empty() {
            let links: Vec<String> = more
                .iter()
                .map(|topic| {
                    assert!(repository(&format!("docs/{topic}.md")).exists(), "{topic}");
                    let name = topic.rsplit('/').next().unwrap();
                    format!("[`{name}.md`](../{topic}.md)")
                })
                .collect();
            page += &format!("\nMore: {}\n", links.join(", "));
        }
        pages.push((format!("{name}.md"), page));
    }
    pages.push(("README.md".to_owned(), index));
    if std::env::var_os("NCFIX_WRITE_DOCS").is_some() {
        fs::create_dir_all(&folder).unwrap();
        pages.iter().for_each(|(name, page)| fs::write(folder.join(name), page).unwrap());
    }
    for (name, page) in &pages {
        let written = fs::read_to_string(folder.join(name)).unwrap_or_default();
        assert!(written == *page, "docs/commands/{name}: run this test with NCFIX_WRITE_DOCS=1");
    }
    assert_eq!(fs::read_dir(&folder).unwrap().count(), pages.len(), "pages of commands that there are not");
}

#[test]
fn the_overview_lists_the_commands_in_groups_and_an_old_name_still_works() {
    let shop = Shop::new();
    let overview = shop.run([""; 0]).exits(2).stderr;
    assert!(overview.lines().count() <= 25, "{overview}");
    for group in ["Program  fix ", "Measure  plan ", "Model    calibrate ", "Machine  machine ", "Live     feed "] {
        assert!(overview.lines().any(|line| line.starts_with(group)), "{group}: {overview}");
    }
    for (old, new) in
        [("measured", "correct-readings"), ("figures", "iso230"), ("steps", "max-step"), ("load", "weigh")]
    {
        assert!(overview.contains(&format!("\n         {new} ")), "{new}: {overview}");
        let help = |name: &str| shop.run([name, "--help"]).exits(0).stdout;
        assert_eq!(help(old), help(new));
    }
    let demo = crate::support::machine("demo");
    let bar = repository("samples/measurements/ball_bar.csv").to_string_lossy().into_owned();
    let old = shop.run(["figures", &bar, "--machine", &demo]).exits(0);
    let new = shop.run(["iso230", &bar, "--machine", &demo]).exits(0);
    assert_eq!(old.stdout, new.stdout);
    let note = "note: `ncfix figures` is now called `ncfix iso230`; the old name still works\n";
    assert_eq!(old.stderr.replace(note, ""), new.stderr);
    assert!(old.stderr.contains(note), "{}", old.stderr);
    assert!(!shop.run(["figures", &bar, "--machine", &demo, "-q"]).exits(0).stderr.contains("note:"));
}

/// The help of commands that read no program does not speak of one in their exit statuses. `calibrate` has no --setup either.
#[test]
fn exit_statuses_fit_the_inputs_of_a_command() {
    let help = |command: &str| Shop::new().run([command, "--help"]).exits(0).stdout;
    for command in ["diagnose", "import", "iso230", "simulate", "square"] {
        let text = help(command);
        assert!(text.contains("control data given with --setup has a syntax error"), "{command}: {text}");
        assert!(!text.contains("the program, or control data"), "{command}: {text}");
    }
    let fit = help("calibrate");
    assert!(!fit.contains("--setup") && !fit.contains("--zero <") && fit.contains("instrument was zeroed"), "{fit}");
    assert!(help("check").contains("the program, or control data given with --setup"));
}
