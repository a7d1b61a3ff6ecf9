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
    ("snc", &["reference/languages", "reference/output"]),
    ("verify", &["how-to/review-and-release", "reference/review"]),
    ("diff", &["how-to/review-and-release", "reference/review"]),
    ("measured", &["how-to/correct-readings", "reference/output"]),
    ("steps", &["explanation/speed", "reference/output"]),
    ("load", &["how-to/correct-for-the-weight", "reference/load"]),
    ("diagnose", &["how-to/find-what-the-model-lacks", "reference/diagnose", "explanation/diagnosis"]),
    ("decompose", &["reference/decompose", "reference/servo"]),
    ("sensors", &["reference/sensors", "reference/temperature"]),
    ("feed", &["how-to/drip-feed-with-a-temperature-sensor", "reference/feed", "reference/sensors"]),
    ("realtime", &["reference/realtime"]),
    ("resume", &["reference/feed", "how-to/restart"]),
    ("plan", &["reference/plan", "explanation/comparison"]),
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
    ("simulate", &["reference/data-files", "reference/servo"]),
    ("figures", &["reference/figures"]),
    ("tables", &["how-to/laser-to-control-tables", "reference/tables", "reference/table-formats"]),
    ("machine", &["reference/machine-file", "how-to/state-a-new-error-term", "reference/motion", "reference/settings"]),
    ("explain", &["how-to/refused-program", "reference/codes"]),
    ("completions", &[]),
    ("man", &[]),
];

/// The names below "Commands:" of a help, `help` aside.
fn commands(help: &str) -> Vec<String> {
    help.lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.strip_prefix("  "))
        .filter(|line| !line.starts_with(' '))
        .filter_map(|line| line.split_whitespace().next().map(str::to_owned))
        .filter(|name| name != "help")
        .collect()
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
    let mut index = "# Commands\n\nWhat `ncfix COMMAND --help` prints, a page each; `ncfix man --help` says how to have them as pages of the manual.\n\n\
                     | command | |\n| --- | --- |\n"
        .to_owned();
    let mut pages = Vec::new();
    for (name, more) in MORE {
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
