//! The library as a caller sees it: what may go to other threads, and that it is small.

use ncfix::prelude::*;

use crate::support::{Shop, machine};

fn is_shared<T: Send + Sync>() {}

#[test]
fn what_holds_data_may_go_to_other_threads() {
    is_shared::<Machine>();
    is_shared::<Program>();
    is_shared::<Options>();
    is_shared::<Correction<'_>>();
    is_shared::<Diagnostics>();
    is_shared::<Error>();
}

#[test]
fn the_prelude_is_small() {
    let text = include_str!("../src/prelude.rs");
    let uses: String = text.lines().filter(|line| !line.starts_with("//")).collect();
    let names = uses.split(';').filter(|one| !one.trim().is_empty()).map(|one| one.matches(',').count() + 1);
    let count: usize = names.sum();
    assert!((20..=80).contains(&count), "{count} names");
}

/// What `ncfix fix` writes and what the library writes is one way: the same bytes, with the same options.
#[test]
fn the_command_writes_what_the_library_writes() {
    let part = "N10 G17 G90 G71 G94 G500\nN20 G0 X50 Y50 Z100\nN30 Z5\nN40 G1 Z-2 F300\nN50 X600 F800\nN60 G3 X550 Y100 CR=50\nN70 G0 Z100\nN80 M30\n";
    let demo = machine("demo");
    let shop = Shop::new().file("part.mpf", part);
    shop.run(["part.mpf", "-o", "out.mpf", "--machine", demo.as_str(), "--tolerance", "0.3um", "--arcs", "chords"])
        .exits(0);
    let machine = Machine::from_file(&demo).unwrap();
    let program = Program::parse("part.mpf", part, DialectChoice::Guess).unwrap();
    let mut options = Options::default();
    (options.tolerance_mm, options.arcs) = (3e-4, Arcs::Chords);
    let text = program.correct(&machine, &options).text().unwrap();
    assert_eq!(text, shop.text("out.mpf"));
    assert!(text.lines().count() > part.lines().count(), "an arc became chords: {text}");
}

#[test]
fn an_error_has_its_code_its_place_and_its_help() {
    let error = Program::parse("part.mpf", "N10 G0 X1\nN20 G1 X=(\nN30 M30\n", DialectChoice::Sinumerik).unwrap_err();
    let first = error.diagnostics().errors().next().unwrap();
    assert_eq!((first.file(), first.line(), first.code()), (Some("part.mpf"), Some(2), error.code().unwrap()));
    assert!(error.to_string().starts_with("part.mpf:2:") && !first.help().is_empty(), "{error}");
    let error = Machine::from_file("there/is/none.toml").unwrap_err();
    assert!(error.code().is_none() && error.to_string().contains("there is no such file"), "{error}");
}

#[test]
fn a_program_of_memory_reads_no_file() {
    // L100 lies beside this sample; a program from memory has no folder.
    let text = "L100\nM30\n";
    let machine = Machine::demo();
    let alone = Program::parse("samples/programs/sinumerik/cover.mpf", text, DialectChoice::Sinumerik).unwrap();
    assert!(alone.check(&machine).has_errors());
    let shop = Shop::new().file("main.mpf", text).file("L100.SPF", "G90 G500 G0 X1 Y1 Z1\nM17\n");
    let program = Program::from_file(shop.path("main.mpf"), DialectChoice::Sinumerik).unwrap();
    assert!(!program.check(&machine).has_errors(), "{}", program.check(&machine).drawn());
}

/// Public items of the facade, with the lines of their documents. Modules of the command line and of files are not part of it.
fn items_of_the_facade(folder: &std::path::Path, found: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            if !["cli", "disk"].iter().any(|hidden| entry.ends_with(hidden)) {
                items_of_the_facade(&entry, found);
            }
            continue;
        }
        let text = std::fs::read_to_string(&entry).unwrap();
        let mut documents = String::new();
        for line in text.lines().map(str::trim).take_while(|line| *line != "#[cfg(test)]") {
            let is_item =
                ["pub fn ", "pub struct ", "pub enum ", "pub trait "].iter().any(|start| line.starts_with(start));
            if is_item {
                found.push((format!("{}: {line}", entry.display()), std::mem::take(&mut documents)));
            } else if line.starts_with("///") {
                documents.push_str(line);
                documents.push('\n');
            } else if !line.starts_with("#[") {
                documents.clear();
            }
        }
    }
}

#[test]
fn every_item_of_the_facade_has_an_example_that_runs() {
    let mut items = Vec::new();
    items_of_the_facade(&crate::support::repository("src"), &mut items);
    let lacking = |documents: &str| {
        !documents.contains("```") || documents.contains("```no_run") || documents.contains("```ignore")
    };
    let found: Vec<&str> = items.iter().filter(|(_, text)| lacking(text)).map(|(item, _)| item.as_str()).collect();
    assert!(found.is_empty() && items.len() > 80, "{} items; without an example: {found:#?}", items.len());
}
