//! The tutorial, done: its files are written, its commands are run in their order, and they print what it shows.

use crate::support::{Shop, repository};

/// What a fenced block is.
enum Part {
    /// A file of this name and text.
    File(String, String),
    /// A command, and lines that it prints.
    Command(String, Vec<String>),
}

/// The blocks of a page in their order.
fn parts(page: &str) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some(opening) = line.strip_prefix("```") else { continue };
        let body: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        match opening.split_once(' ') {
            Some((_, name)) => parts.push(Part::File(name.to_owned(), body.join("\n") + "\n")),
            None if opening == "console" => {
                for line in body {
                    match (line.strip_prefix("$ ncfix "), parts.last_mut()) {
                        (Some(command), _) => parts.push(Part::Command(command.to_owned(), Vec::new())),
                        (None, Some(Part::Command(_, shown))) => shown.push(line.to_owned()),
                        (None, _) => panic!("{line} is shown before any command"),
                    }
                }
            }
            None => panic!("a block that is neither a file nor a command: {opening}"),
        }
    }
    parts
}

#[test]
fn the_tutorial_does_what_it_says() {
    let page = std::fs::read_to_string(repository("docs/tutorial.md")).unwrap();
    let hidden = std::fs::read_to_string(repository("samples/machines/demo.toml")).unwrap();
    let mut shop = Shop::new().file("hidden.toml", hidden);
    let mut commands = 0;
    for part in parts(&page) {
        match part {
            Part::File(name, text) => shop = shop.file(&name, text),
            Part::Command(command, shown) => {
                // Two programs that differ are 1 to `diff`, as to the program of that name.
                let expected = i32::from(command.starts_with("diff "));
                let run = shop.run(command.split(' ')).exits(expected);
                let printed = run.stdout.clone() + &run.stderr;
                for line in &shown {
                    assert!(printed.lines().any(|own| own.trim_end() == line), "{command}\n{line}\nnot in\n{printed}");
                }
                assert!(!shown.is_empty(), "{command} shows nothing");
                commands += 1;
            }
        }
    }
    assert!(commands > 10, "{commands}");
}
