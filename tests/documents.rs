//! The documents: their commands run in a folder with the samples and print what the pages show, their links lead somewhere, the index has every page.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

use ncfix_metrology::diagnose::explain::assumptions::{ASSUMPTIONS, Size};

use crate::support::{Shop, repository};

/// A part of a page that is done, in its order.
enum Step {
    /// A fenced block with a name: a file of this name and text.
    File(String, String),
    /// `$ cp FROM TO`.
    Copy(String, String),
    /// `$ ncfix …`.
    Run(Call),
}

/// A command of a page.
struct Call {
    /// Its arguments.
    words: Vec<String>,
    /// Lines that it prints; `…` stands for lines that the page leaves out.
    shown: Vec<String>,
    /// Its exit status: that of `$ echo $?` behind it, else 0, and 1 of `diff`, as of every program that differs.
    status: i32,
}

/// The steps of a page. Blocks without a name that are no `console` are not run.
fn steps(page: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some(opening) = line.strip_prefix("```") else { continue };
        let body: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        match opening.split_once(' ') {
            Some((_, name)) => steps.push(Step::File(name.to_owned(), body.join("\n") + "\n")),
            None if opening == "console" => session(&body, &mut steps),
            None => {}
        }
    }
    steps
}

/// The steps of a `console` block.
fn session(lines: &[&str], steps: &mut Vec<Step>) {
    let mut lines = lines.iter().copied();
    while let Some(line) = lines.next() {
        if line == "$ echo $?" {
            let status = lines.next().and_then(|line| line.parse().ok());
            match (steps.last_mut(), status) {
                (Some(Step::Run(call)), Some(status)) => call.status = status,
                _ => panic!("{line} needs a command before it and a number after it"),
            }
        } else if let Some(command) = line.strip_prefix("$ ") {
            // A part in quotation marks is one word.
            let parts = command.split('"').enumerate();
            let words: Vec<&str> = parts
                .flat_map(|(place, part)| match place % 2 {
                    0 => part.split(' ').filter(|word| !word.is_empty()).collect(),
                    _ => vec![part],
                })
                .collect();
            steps.push(match words.as_slice() {
                ["ncfix", arguments @ ..] => Step::Run(Call {
                    words: arguments.iter().map(|word| (*word).to_owned()).collect(),
                    shown: Vec::new(),
                    status: i32::from(arguments.first() == Some(&"diff")),
                }),
                ["cp", from, to] => Step::Copy((*from).to_owned(), (*to).to_owned()),
                _ => panic!("{command}: pages run ncfix and cp only"),
            });
        } else {
            match steps.last_mut() {
                Some(Step::Run(call)) => call.shown.push(line.to_owned()),
                _ => panic!("{line} is shown before any command"),
            }
        }
    }
}

/// Files below a folder of the repository, as paths from its root, sorted.
fn below(folder: &str) -> Vec<String> {
    let mut paths = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(repository(&folder)).unwrap() {
            let entry = entry.unwrap();
            let path = format!("{folder}/{}", entry.file_name().to_str().unwrap());
            if entry.file_type().unwrap().is_dir() { open.push(path) } else { paths.push(path) }
        }
    }
    paths.sort();
    paths
}

/// Pages below a folder of the repository.
fn pages(folder: &str) -> Vec<String> {
    below(folder).into_iter().filter(|path| is_page(path)).collect()
}

fn is_page(path: &str) -> bool {
    Path::new(path).extension().is_some_and(|extension| extension == "md")
}

fn text(path: &str) -> String {
    fs::read_to_string(repository(path)).unwrap().replace("\r\n", "\n")
}

/// Does all steps of a page; gives the number of its commands.
fn done(path: &str) -> usize {
    let steps = steps(&text(path));
    let commands = steps.iter().filter(|step| matches!(step, Step::Run(_))).count();
    if commands == 0 {
        return 0;
    }
    let mut shop = with_samples();
    for step in steps {
        match step {
            Step::File(name, text) => shop = shop.file(&name, text),
            Step::Copy(from, to) => {
                let bytes = shop.bytes(&from);
                shop = shop.file(&to, bytes);
            }
            Step::Run(call) => shows(path, &shop, &call),
        }
    }
    commands
}

/// The line that has most words of another one, and few of its own. With `NCFIX_WRITE_DOCS=1` it takes the place of the first shown line that is not printed any
/// more; look at what it wrote, and run the test again until no line is missing.
fn nearest(line: &str, printed: &str) -> String {
    let words: BTreeSet<&str> = line.split_whitespace().collect();
    let alike = |own: &&str| {
        let all: BTreeSet<&str> = own.split_whitespace().collect();
        2 * all.intersection(&words).count() as i64 - all.symmetric_difference(&words).count() as i64
    };
    printed.lines().max_by_key(alike).unwrap_or_default().trim_end().to_owned()
}

/// Demands that a command ends as its page says and prints the lines that are shown there.
fn shows(path: &str, shop: &Shop, call: &Call) {
    let command = call.words.join(" ");
    let run = shop.run(&call.words);
    let printed = format!("{}{}", run.stdout, run.stderr);
    assert_eq!(run.code, call.status, "{path}: {command}\n{printed}");
    assert!(!call.shown.is_empty(), "{path}: {command} shows nothing");
    let shown: Vec<&str> =
        call.shown.iter().map(|line| line.trim_end()).filter(|line| !matches!(*line, "" | "…")).collect();
    // A page shows both streams as a terminal mixes them: in their order, one stream after the other.
    let missing = |printed: &str| {
        let mut lines = printed.lines();
        shown.iter().copied().find(|shown| !lines.any(|own| own.trim_end() == *shown))
    };
    let swapped = format!("{}{}", run.stderr, run.stdout);
    if let (Some(line), Some(_)) = (missing(&printed), missing(&swapped)) {
        if std::env::var_os("NCFIX_WRITE_DOCS").is_some() {
            let page = text(path).replace(line, &nearest(line, &printed));
            fs::write(repository(path), page).unwrap();
        }
        panic!("{path}: {command}\n{line}\nis not there, or before the line above it:\n{printed}");
    }
}

#[test]
fn the_tutorial_does_what_it_says() {
    assert!(done("docs/tutorial.md") > 10);
}

#[test]
fn the_readme_does_what_it_says() {
    assert!(done("README.md") > 3);
    assert!(text("README.md").lines().count() <= 100, "the README is for the first minute");
}

/// A shop with the samples.
fn with_samples() -> Shop {
    below("samples").iter().fold(Shop::new(), |shop, name| shop.file(name, fs::read(repository(name)).unwrap()))
}

/// A reader copies the commands within the lines too: each ends with status 0, except a name alone, such as `ncfix diff`.
#[test]
fn the_commands_within_the_lines_of_the_readme_work() {
    let shop = with_samples();
    let mut count = 0;
    for line in outside_of_fences(&text("README.md")) {
        for code in line.split('`').skip(1).step_by(2).filter_map(|code| code.strip_prefix("ncfix ")) {
            let words: Vec<&str> = code.split(" | ").next().unwrap_or_default().split_whitespace().collect();
            if words.len() > 1 || words[0].starts_with('-') || words[0] == "man" {
                shop.run(&words).exits(0);
                count += 1;
            }
        }
    }
    assert!(count >= 4, "{count}");
}

#[test]
fn every_how_to_does_what_it_says() {
    let commands: usize = pages("docs/how-to").iter().map(|path| done(path)).sum();
    assert!(commands > 40, "{commands}");
}

#[test]
fn reference_and_explanation_do_what_they_say() {
    let commands: usize =
        ["docs/reference", "docs/explanation"].iter().flat_map(|folder| pages(folder)).map(|path| done(&path)).sum();
    assert!(commands > 1, "{commands}");
}

/// The targets of links outside of fenced blocks.
fn links(page: &str) -> Vec<String> {
    let mut links = Vec::new();
    for line in outside_of_fences(page) {
        for (at, _) in line.match_indices("](") {
            let target = line[at + 2..].split(')').next().unwrap_or_default();
            if !target.is_empty() && !target.contains(char::is_whitespace) {
                links.push(target.to_owned());
            }
        }
    }
    links
}

fn outside_of_fences(page: &str) -> impl Iterator<Item = &str> {
    let mut is_inside = false;
    page.lines().filter(move |line| {
        let is_fence = line.starts_with("```");
        is_inside ^= is_fence;
        !is_inside && !is_fence
    })
}

/// What headings of a page are called in links.
fn anchors(page: &str) -> BTreeSet<String> {
    let headings = outside_of_fences(page)
        .filter_map(|line| line.trim_start_matches('#').strip_prefix(' ').filter(|_| line.starts_with('#')));
    headings
        .map(|heading| {
            // A link in a heading counts by its text.
            let shown: String = heading.split("](").enumerate().fold(String::new(), |shown, (index, part)| {
                shown + if index == 0 { part } else { part.split_once(')').map_or("", |(_, rest)| rest) }
            });
            let letters = shown
                .to_lowercase()
                .chars()
                .filter(|letter| letter.is_alphanumeric() || "-_ ".contains(*letter))
                .collect::<String>();
            letters.replace(' ', "-")
        })
        .collect()
}

/// A path without `.` and `..`.
fn straight(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut straight, part| {
        match part {
            Component::ParentDir => {
                straight.pop();
            }
            Component::CurDir => {}
            part => straight.push(part),
        }
        straight
    })
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let mut paths = pages("docs");
    paths.extend(pages("samples"));
    paths.extend(["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(str::to_owned));
    let mut faults = Vec::new();
    for path in &paths {
        let page = text(path);
        for link in links(&page).into_iter().filter(|link| !link.contains("://")) {
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() {
                PathBuf::from(path)
            } else {
                straight(&Path::new(path).parent().unwrap().join(file))
            };
            let target = target.to_str().unwrap();
            if !repository(target).exists() {
                faults.push(format!("{path}: there is no {link}"));
            } else if !anchor.is_empty() && is_page(target) && !anchors(&text(target)).contains(anchor) {
                faults.push(format!("{path}: {target} has no heading {anchor}"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_index_has_every_page() {
    let listed: BTreeSet<String> =
        links(&text("docs/SUMMARY.md")).into_iter().map(|link| format!("docs/{link}")).collect();
    let present: BTreeSet<String> = pages("docs").into_iter().filter(|path| path != "docs/SUMMARY.md").collect();
    assert_eq!(listed, present);
}

#[test]
fn every_how_to_has_its_parts() {
    for path in pages("docs/how-to") {
        let page = text(&path);
        for part in ["\n**Goal.** ", "\n## What you need\n", "\n## What can go wrong\n", "\n## Reference\n"] {
            assert!(page.contains(part), "{path} lacks{part}");
        }
    }
}

/// Words of a card, with its commands: it is read before the page, in a minute.
const MOST_WORDS_OF_A_CARD: usize = 200;

#[test]
fn every_how_to_begins_with_a_card() {
    for path in pages("docs/how-to") {
        let page = text(&path);
        let (_, rest) = page.split_once("\n## In short\n").unwrap_or_else(|| panic!("{path} has no card"));
        let (card, _) = rest.split_once("\n## What you need\n").unwrap_or_else(|| panic!("{path}: the card is first"));
        let places = ["**You need:** ", "\n```sh\n", "**You get:** ", "**Check first:** "]
            .map(|part| card.find(part).unwrap_or_else(|| panic!("{path}: the card lacks {part}")));
        assert!(places.is_sorted(), "{path}: the parts of the card are in another order");
        // Text that is no part of the card, such as the length of a bar, has a bold head of its own.
        let words = card.split("\n**").take(4).flat_map(str::split_whitespace).count();
        assert!(words <= MOST_WORDS_OF_A_CARD, "{path}: {words} words");
    }
}

/// Rows of the tables of a page, without heads and rules.
fn rows(page: &str) -> Vec<Vec<&str>> {
    let lines: Vec<&str> = outside_of_fences(page).collect();
    let is_rule = |line: &str| line.starts_with("| ---");
    let body = lines.iter().enumerate().filter(|(at, line)| {
        line.starts_with('|') && !is_rule(line) && !lines.get(at + 1).is_some_and(|next| is_rule(next))
    });
    body.map(|(_, line)| line.trim_matches('|').split(" | ").map(str::trim).collect()).collect()
}

#[test]
fn the_questions_have_short_answers_and_their_commands_work() {
    let path = "docs/questions.md";
    assert!(done(path) > 5);
    let page = text(path);
    let groups: Vec<&str> = page.split("\n## ").skip(1).collect();
    assert_eq!(groups.len(), 3, "one group for each reader");
    let mut asked = BTreeSet::new();
    for group in groups {
        let rows = rows(group);
        assert!(rows.len() >= 20, "{}: {} questions", group.lines().next().unwrap_or_default(), rows.len());
        for row in rows {
            let [question, answer] = row[..] else { panic!("a question and an answer: {row:?}") };
            assert!(question.ends_with('?') || question.contains(": what now?"), "{question}");
            assert!(asked.insert(question), "asked twice: {question}");
            let words = answer.split_whitespace().count();
            assert!((1..=75).contains(&words), "{question} {words} words");
        }
    }
}

/// Commands that a page names without running them: lines of its blocks without a name, and code within a line.
fn named_commands(page: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut is_run = false;
    let mut is_inside = false;
    for line in page.lines() {
        if let Some(opening) = line.strip_prefix("```") {
            is_inside = !is_inside;
            is_run = is_inside && (opening == "console" || opening.contains(' '));
        } else if is_inside && !is_run && line.starts_with("ncfix ") {
            found.push(line.split("   #").next().unwrap_or_default().trim_end().to_owned());
        } else if !is_inside {
            let code = line.split('`').skip(1).step_by(2);
            found.extend(code.filter(|code| code.starts_with("ncfix ")).map(str::to_owned));
        }
    }
    found
}

#[test]
fn every_option_of_a_named_command_exists() {
    let shop = Shop::new();
    let help = |command: &[&str]| shop.run(command.iter().copied().chain(["--help"])).exits(0).stdout;
    let top = help(&[]);
    let all = crate::command_pages::commands(&top);
    let mut texts = BTreeMap::new();
    let mut count = 0;
    let mut paths = pages("docs/how-to");
    paths.extend(["README.md", "docs/questions.md", "docs/tutorial.md"].map(str::to_owned));
    for path in paths {
        for command in named_commands(&text(&path)) {
            let words: Vec<&str> = command.split_whitespace().skip(1).collect();
            let is_command = words.first().is_some_and(|word| all.iter().any(|own| own == word));
            let is_part = words.first() == Some(&"machine") && words.get(1).is_some_and(|word| !word.starts_with('-'));
            let called = if is_command { &words[..1 + usize::from(is_part)] } else { &[] };
            let known = texts.entry(called.join(" ")).or_insert_with(|| help(called));
            for option in words.iter().filter(|word| word.starts_with("--") && word.len() > 2) {
                let option = option.split(['=', ',']).next().unwrap_or_default();
                let is_known =
                    known.split(|letter: char| !letter.is_alphanumeric() && letter != '-').any(|own| own == option);
                assert!(is_known, "{path}: {command}: there is no {option}");
                count += 1;
            }
        }
    }
    assert!(count > 100, "{count}");
}

/// The keys of a machine file, with their defaults, as the program knows them.
#[test]
fn every_key_of_the_sample_machines_is_listed() {
    let listed: String =
        ["machine-file", "settings", "grundig"].map(|page| text(&format!("docs/reference/{page}.md"))).concat();
    let machines =
        below("samples/machines").into_iter().filter(|path| path.ends_with("toml") && !path.contains("/bad/"));
    let mut missing = BTreeSet::new();
    for machine in machines {
        let path = repository(&machine);
        let run = Shop::new().run(["machine", "show", path.to_str().unwrap(), "--origin"]);
        for line in run.stdout.lines().skip(1) {
            let name = line.split("  ").next().unwrap();
            // Names of errors and values that a program calls are no keys.
            if !name.contains('.') || ["location.", "system.", "gud."].iter().any(|section| name.starts_with(section)) {
                continue;
            }
            let key = name.rsplit('.').next().unwrap().split('[').next().unwrap();
            // Shifts of zero offsets are listed from X to C.
            let is_shift = key.trim_start_matches("fine_").chars().next().is_some_and(char::is_uppercase);
            if !is_shift && !listed.contains(&format!("`{key}`")) {
                missing.insert(key.to_owned());
            }
        }
    }
    assert!(missing.is_empty(), "keys that no page lists: {missing:?}");
}

/// A reader of the book does not see the name behind the fence.
#[test]
fn every_file_of_a_page_is_named_above_it() {
    for path in pages("docs/how-to").into_iter().chain(["docs/tutorial.md".to_owned()]) {
        let page = text(&path);
        let mut above = Vec::new();
        let mut is_inside = false;
        for line in page.lines() {
            if let Some(opening) = line.strip_prefix("```") {
                is_inside = !is_inside;
                if let Some((_, name)) = opening.split_once(' ').filter(|_| is_inside) {
                    let is_named = above.iter().any(|line: &&str| line.contains(&format!("`{name}`")));
                    assert!(is_named, "{path}: the text above the block does not name {name}");
                }
                above.clear();
            } else if !is_inside {
                above.push(line);
            }
        }
    }
}

#[test]
fn the_table_of_usual_sizes_is_that_of_the_program() {
    let page = text("docs/explanation/diagnosis.md");
    let rows = page.lines().skip_while(|line| !line.starts_with("| error | usual size | odds |")).skip(2);
    let row =
        |line: &str| -> Vec<String> { line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect() };
    let mut written: Vec<String> =
        rows.take_while(|line| line.starts_with('|')).map(|line| row(line)[1..].join(" | ")).collect();
    let size = |size: Size| match size {
        Size::Um(um) => format!("{um} µm"),
        Size::Urad(urad) => format!("{urad} µrad"),
        Size::UmPerM(um) => format!("{um} µm/m"),
        Size::Ms(ms) => format!("{ms} ms"),
        Size::UmPerMs2(um) => format!("{um} µm per m/s²"),
    };
    let mut used: Vec<String> =
        ASSUMPTIONS.iter().map(|one| format!("{} | {} | {}", size(one.size), one.odds, one.source)).collect();
    written.sort();
    used.sort();
    assert_eq!(written, used);
}
