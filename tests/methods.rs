//! `docs/reference/seeds.md`: its rows name commands, options and tests that exist, and its counts are those of its rows.

use std::collections::BTreeMap;
use std::fs;

use crate::support::repository;

/// The cells of the rows of each section, without headings.
fn rows() -> BTreeMap<String, Vec<Vec<String>>> {
    let text = fs::read_to_string(repository("docs/reference/seeds.md")).unwrap();
    let mut sections: BTreeMap<String, Vec<Vec<String>>> = BTreeMap::new();
    let mut section = String::new();
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            title.clone_into(&mut section);
        }
        let is_row = line.starts_with("| ") && !line.starts_with("| ---") && !line.starts_with("| place");
        if is_row && !section.is_empty() {
            let cells = line.trim_matches('|').split(" | ").map(|cell| cell.trim().to_owned()).collect();
            sections.entry(section.clone()).or_default().push(cells);
        }
    }
    sections
}

/// The texts in backquotes.
fn quoted(cell: &str) -> impl Iterator<Item = &str> {
    cell.split('`').skip(1).step_by(2)
}

#[test]
fn the_counts_are_those_of_the_rows() {
    let text = fs::read_to_string(repository("docs/reference/seeds.md")).unwrap();
    let states = ["complete", "partial", "missing"];
    let mut all = [0; 3];
    for (section, rows) in rows() {
        let counts = states.map(|state| rows.iter().filter(|row| row[4].starts_with(state)).count());
        assert_eq!(counts.iter().sum::<usize>(), rows.len(), "{section}: a row has another state");
        let line =
            format!("| [{section}](#{}) | {} | {} | {} |", section.to_lowercase(), counts[0], counts[1], counts[2]);
        assert!(text.contains(&line), "the table at the top needs: {line}");
        all.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
    }
    let line = format!("| all | {} | {} | {} |", all[0], all[1], all[2]);
    assert!(text.contains(&line), "the table at the top needs: {line}");
}

#[test]
fn every_row_names_a_test_that_exists() {
    for row in rows().into_values().flatten() {
        assert_eq!(row.len(), 5, "{row:?}");
        for test in quoted(&row[3]) {
            let (file, name) = test.split_once("::").unwrap_or_else(|| panic!("{test} has no name of a test"));
            let text = fs::read_to_string(repository(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
            assert!(text.contains(&format!("fn {name}(")), "{test}");
        }
        // What is complete has a test, and what is missing has neither.
        assert!(!row[4].starts_with("complete") || row[3].contains("::"), "{row:?}");
        assert!(!row[4].starts_with("missing") || row[3] == "–", "{row:?}");
        // Each state but the first says what is not available.
        assert!(row[4] == "complete" || row[4].contains(": "), "{row:?}");
    }
}

#[test]
fn every_row_names_a_command_with_its_options() {
    for row in rows().into_values().flatten() {
        for command in quoted(&row[2]).filter(|text| text.starts_with("ncfix ")) {
            let mut words = command.split_whitespace().skip(1).peekable();
            let name = words.next().unwrap();
            let page = fs::read_to_string(repository(&format!("docs/commands/{name}.md")))
                .unwrap_or_else(|error| panic!("{command}: {name}: {error}"));
            for option in words.filter(|word| word.starts_with("--")) {
                let is_there = page.contains(&format!("{option} ")) || page.contains(&format!("{option}\n"));
                assert!(is_there, "{command}: {option}");
            }
        }
    }
}
