//! Pairs each line of a corrected program with a line of the original: by the executed moves, and between these by the text.

use super::ReviewRow;

/// Maximum number of pairs of lines that are compared between two moves.
const MOST_COMPARED: usize = 1 << 22;

/// For each line of the corrected program, the line of the main original program, from 1; 0 if it has none.
#[must_use]
pub fn pairs<'t>(
    rows: &[ReviewRow],
    original: impl Iterator<Item = &'t str>,
    corrected: impl Iterator<Item = &'t str>,
) -> Vec<u32> {
    let [original, corrected] = [original.collect::<Vec<&str>>(), corrected.collect()];
    let mut out = vec![0; corrected.len()];
    for row in rows.iter().filter(|row| row.file == 0) {
        if let Some(own) = out.get_mut(row.corrected_line.saturating_sub(1) as usize)
            && *own == 0
        {
            *own = row.line;
        }
    }
    let known: Vec<(usize, usize)> = out
        .iter()
        .enumerate()
        .filter(|(_, line)| **line > 0)
        .map(|(place, line)| (place + 1, *line as usize))
        .collect();
    let end = (corrected.len() + 1, original.len() + 1);
    let mut last = (0, 0);
    for next in known.into_iter().chain([end]) {
        let is_forward = next.1 > last.1;
        if is_forward && next.0 > last.0 + 1 {
            between((last, next), &original, &corrected, &mut out);
        }
        // Loops jump back: lines after them follow the last line that was reached.
        if is_forward {
            last = next;
        } else {
            last.0 = next.0;
        }
    }
    out
}

/// Pairs the lines between two pairs, each given by its line of the corrected program and of the original.
fn between((last, next): ((usize, usize), (usize, usize)), original: &[&str], corrected: &[&str], out: &mut [u32]) {
    let is_same = |(after, before): (usize, usize)| {
        let [after, before] =
            [corrected.get(after - 1), original.get(before - 1)].map(|text| text.map(|text| text.trim()));
        after == before
    };
    let (mut from, mut to) = ((last.0 + 1, last.1 + 1), (next.0 - 1, next.1.saturating_sub(1)));
    while from.0 <= to.0 && from.1 <= to.1 && is_same(from) {
        out[from.0 - 1] = from.1 as u32;
        from = (from.0 + 1, from.1 + 1);
    }
    while from.0 <= to.0 && from.1 <= to.1 && is_same(to) {
        out[to.0 - 1] = to.1 as u32;
        to = (to.0 - 1, to.1 - 1);
    }
    let mut last = (from.0 - 1, from.1 - 1);
    let end = (to.0 + 1, to.1 + 1);
    for next in common(from, end, original, corrected).into_iter().chain([end]) {
        // Equally many lines on both sides: rewritten with evaluated values.
        if next.0 - last.0 == next.1 - last.1 {
            for place in 1..next.0 - last.0 {
                out[last.0 + place - 1] = (last.1 + place) as u32;
            }
        } else {
            taken_apart((last, next), original, corrected, out);
        }
        if next < end {
            out[next.0 - 1] = next.1 as u32;
        }
        last = next;
    }
}

/// Pairs lines that were divided: each goes with the first line of the original that has at least half of its words, and these never go back.
fn taken_apart((last, next): ((usize, usize), (usize, usize)), original: &[&str], corrected: &[&str], out: &mut [u32]) {
    if (next.0 - last.0).saturating_mul(next.1 - last.1) > MOST_COMPARED {
        return;
    }
    let mut from = last.1 + 1;
    for line in last.0 + 1..next.0 {
        let words: Vec<&str> = corrected.get(line - 1).map_or("", |text| text).split_whitespace().collect();
        let has_half = |before: usize| {
            let text = original.get(before - 1).map_or("", |text| text);
            let common = words.iter().filter(|word| text.split_whitespace().any(|other| other == **word)).count();
            common > 0 && 2 * common >= words.len()
        };
        if let Some(found) = (from..next.1).find(|&before| has_half(before)) {
            out[line - 1] = found as u32;
            from = found;
        }
    }
}

/// Returns the longest common subsequence of two stretches: lines with the same words in any order. Ends are exclusive.
fn common(from: (usize, usize), end: (usize, usize), original: &[&str], corrected: &[&str]) -> Vec<(usize, usize)> {
    let words = |line: Option<&&str>| {
        let mut words: Vec<&str> = line.map_or("", |text| text).split_whitespace().collect();
        words.sort_unstable();
        words.join(" ")
    };
    let [rows, columns] = [end.0.saturating_sub(from.0), end.1.saturating_sub(from.1)];
    if rows.saturating_mul(columns) > MOST_COMPARED {
        return Vec::new();
    }
    let after: Vec<String> = (from.0..end.0).map(|line| words(corrected.get(line - 1))).collect();
    let before: Vec<String> = (from.1..end.1).map(|line| words(original.get(line - 1))).collect();
    let width = columns + 1;
    // Length of the longest common subsequence from a pair of lines on.
    let mut lengths = vec![0_u32; (rows + 1) * width];
    for row in (0..rows).rev() {
        for column in (0..columns).rev() {
            let here = row * width + column;
            lengths[here] = if !after[row].is_empty() && after[row] == before[column] {
                lengths[here + width + 1] + 1
            } else {
                lengths[here + width].max(lengths[here + 1])
            };
        }
    }
    let (mut row, mut column, mut out) = (0, 0, Vec::new());
    while row < rows && column < columns {
        let here = row * width + column;
        if !after[row].is_empty() && after[row] == before[column] {
            out.push((from.0 + row, from.1 + column));
            (row, column) = (row + 1, column + 1);
        } else if lengths[here + width] >= lengths[here + 1] {
            row += 1;
        } else {
            column += 1;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::AXIS_COUNT;

    fn row(line: u32, corrected_line: u32) -> ReviewRow {
        ReviewRow { file: 0, line, corrected_line, added: [0.0; AXIS_COUNT], error_mm: 0.0, flags: 0 }
    }

    fn paired(rows: &[ReviewRow], original: &str, corrected: &str) -> Vec<u32> {
        pairs(rows, original.lines(), corrected.lines())
    }

    #[test]
    fn lines_without_moves_go_with_those_that_are_the_same() {
        let original = "%\nR1=3\nG54\nTRANS X=R1\nG1 X1\n; end\nG1 X2\nM30";
        let corrected = "%\n; stamp\nG54\nTRANS X3\nG1 X1.01\nG1 X1.51 ;+\n; end\nG1 X2.01\nM30";
        let rows = [row(5, 5), row(5, 6), row(7, 8)];
        // `R1=3` now follows the stamp: both sides have equally many lines between the pairs.
        assert_eq!(paired(&rows, original, corrected), [1, 2, 3, 4, 5, 5, 6, 7, 8]);
        // Without the stamp that line is missing, and those after it are still found.
        let shorter = corrected.replace("; stamp\n", "");
        let rows = [row(5, 4), row(5, 5), row(7, 7)];
        assert_eq!(paired(&rows, original, &shorter), [1, 3, 4, 5, 5, 6, 7, 8]);
    }

    #[test]
    fn an_inserted_line_and_words_in_another_order_leave_the_others_paired() {
        let original = "%\n; part\nN10 G17 G90\nN20 T2 M6\nN30 D1 S2200 F900\nG1 X1\nM30";
        let corrected = "%\n; stamp\n; part\nN10 G17 G90\nN20 T2 M6\nN30 F900 D1 S2200\nG1 X1.01\nM30";
        assert_eq!(paired(&[row(6, 7)], original, corrected), [1, 0, 2, 3, 4, 5, 6, 7]);
        // An evaluated line between two that are found.
        let evaluated = corrected.replace("N20 T2", "N20 T3");
        assert_eq!(paired(&[row(6, 7)], original, &evaluated), [1, 0, 2, 3, 4, 5, 6, 7]);
    }

    #[test]
    fn a_line_that_was_divided_stays_beside_its_parts() {
        let original = "%\nG21 G17 G90 G40\nG1 X1\nM30";
        let corrected = "%\n(stamp of it)\nG21 G90\nG17 G40\nG1 X1.01\nM30";
        assert_eq!(paired(&[row(3, 5)], original, corrected), [1, 0, 2, 2, 3, 4]);
    }

    #[test]
    fn loops_go_back_and_do_not_confuse_what_follows() {
        let original = "A\nX1\nX2\nB\nM30";
        let corrected = "A\nX1\nX2\nX1\nX2\nB\nM30";
        let rows = [row(2, 2), row(3, 3), row(2, 4), row(3, 5)];
        assert_eq!(paired(&rows, original, corrected), [1, 2, 3, 2, 3, 4, 5]);
        assert_eq!(paired(&[], "A\nB", "A\nB"), [1, 2]);
        assert!(paired(&[], "", "").is_empty());
    }
}
