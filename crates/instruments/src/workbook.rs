//! Workbooks of spreadsheets (.xlsx): their first sheet with numbers as text, cells separated by tabs.

use std::fmt::Write as _;
use std::io::Cursor;

use calamine::{DataRef, Reader as _, Xlsx};
use ncfix_base::csv::DecimalSign;

use crate::numerals::{may_be_thousands, number};

/// Most cells of a sheet that are read: more than a million readings have.
const MOST_CELLS: usize = 4_000_000;

/// Most rows and columns of a sheet, so that one cell at its far end does not make millions of empty ones.
const MOST_SIZE: [u32; 2] = [1_100_000, 512];

/// Largest size of an unpacked part, bytes, as its entry in the archive declares it.
const MOST_UNPACKED: u64 = 256 << 20;

/// Fewest numbers that make a sheet one with readings.
const FEWEST_NUMBERS: usize = 3;

/// Returns the name of the first sheet with numbers, its text, and the names of the other sheets with numbers.
///
/// # Errors
/// A sentence without a full stop if the bytes are no workbook, or too large.
pub(crate) fn text(bytes: &[u8], most_bytes: usize) -> Result<(String, String, Vec<String>), String> {
    if unpacked_size(bytes) > MOST_UNPACKED {
        return Err("a workbook that is too large".into());
    }
    let mut book: Xlsx<_> =
        Xlsx::new(Cursor::new(bytes)).map_err(|error| format!("not a workbook of sheets ({error})"))?;
    let mut found: Option<(String, String)> = None;
    let mut others = Vec::new();
    for name in book.sheet_names() {
        let (sheet, numbers) = sheet(&mut book, &name, most_bytes)?;
        if numbers < FEWEST_NUMBERS {
            continue;
        }
        match found {
            None => found = Some((name, sheet)),
            Some(_) => others.push(name),
        }
    }
    let (name, sheet) = found.ok_or_else(|| "a workbook without numbers".to_owned())?;
    Ok((name, sheet, others))
}

/// A number that a sheet has as text.
#[derive(Debug)]
struct TextNumber {
    /// Its bytes in the text of the sheet.
    at: std::ops::Range<usize>,
    /// Row and column, from 0.
    cell: [u32; 2],
    sign: Option<DecimalSign>,
}

/// Numbers that a sheet has as text: `24,2` in a program with another language than the file.
#[derive(Debug, Default)]
struct TextNumbers {
    found: Vec<TextNumber>,
}

impl TextNumbers {
    /// Appends the text of a cell.
    fn push(&mut self, out: &mut String, text: &str, cell: [u32; 2]) {
        let from = out.len();
        let plain = text.replace(['\u{2212}', '\u{2013}'], "-");
        let is_plain = plain.trim().bytes().all(|byte| byte.is_ascii_digit() || b"+-.,".contains(&byte));
        let [point, comma] = [DecimalSign::Point, DecimalSign::Comma].map(|sign| number(&plain, sign).is_some());
        if !is_plain || !(point || comma) {
            out.extend(text.chars().map(|c| if c.is_control() { ' ' } else { c }));
            return;
        }
        out.push_str(plain.trim());
        // `1,234` and `1.234` may be thousands, an integer has no sign.
        let is_open = |separator: &str| may_be_thousands(&plain.trim().replace(separator, ","));
        let sign = match (plain.contains('.'), plain.contains(',')) {
            (false, false) => None,
            (true, true) => Some(if point { DecimalSign::Point } else { DecimalSign::Comma }),
            (true, false) => Some(DecimalSign::Point).filter(|_| !is_open(".")),
            (false, true) => Some(DecimalSign::Comma).filter(|_| !is_open(",")),
        };
        self.found.push(TextNumber { at: from..out.len(), cell, sign });
    }

    /// Writes the numbers with a decimal point, as the numbers of the sheet are written.
    ///
    /// # Errors
    /// If the decimal sign is not certain: the cell.
    fn write(&self, out: &mut String) -> Result<(), String> {
        let of = |sign: DecimalSign| self.found.iter().find(|one| one.sign == Some(sign));
        let text = |one: &TextNumber| out.get(one.at.clone()).unwrap_or_default().to_owned();
        let sign = match (of(DecimalSign::Point), of(DecimalSign::Comma)) {
            (Some(point), Some(comma)) => {
                return Err(format!(
                    "a workbook with two decimal signs in cells with text: {} in {}, {} in {}",
                    text(point),
                    name_of(point.cell),
                    text(comma),
                    name_of(comma.cell)
                ));
            }
            (Some(_), None) => DecimalSign::Point,
            (None, Some(_)) => DecimalSign::Comma,
            (None, None) => {
                let is_open = |one: &&TextNumber| text(one).contains(['.', ',']);
                match self.found.iter().find(is_open) {
                    Some(open) => {
                        let written = text(open);
                        return Err(format!(
                            "a workbook whose cell {} has '{written}' as text: it may be {} or {}",
                            name_of(open.cell),
                            written.replace(',', "."),
                            written.replace([',', '.'], "")
                        ));
                    }
                    None => DecimalSign::Point,
                }
            }
        };
        let (mut plain, mut from) = (String::with_capacity(out.len()), 0);
        for one in &self.found {
            let own = out.get(one.at.clone()).unwrap_or_default();
            plain.push_str(out.get(from..one.at.start).unwrap_or_default());
            plain.push_str(&match sign {
                DecimalSign::Point => own.replace(',', ""),
                DecimalSign::Comma => own.replace('.', "").replace(',', "."),
            });
            from = one.at.end;
        }
        plain.push_str(out.get(from..).unwrap_or_default());
        *out = plain;
        Ok(())
    }
}

/// Name of a cell by its row and column from 0: `C4`.
pub(crate) fn name_of([row, column]: [u32; 2]) -> String {
    let (mut letters, mut rest) = (Vec::new(), column + 1);
    while rest > 0 {
        letters.push(b'A' + ((rest - 1) % 26) as u8);
        rest = (rest - 1) / 26;
    }
    letters.reverse();
    format!("{}{}", String::from_utf8_lossy(&letters), row + 1)
}

/// Text of a sheet, and the count of its numbers.
///
/// # Errors
/// A sentence without a full stop.
fn sheet(book: &mut Xlsx<Cursor<&[u8]>>, name: &str, most_bytes: usize) -> Result<(String, usize), String> {
    /// A sheet that cannot be read.
    fn damaged<E>(_: E) -> String {
        "a workbook with a damaged or very large sheet".to_owned()
    }
    let mut reader = book.worksheet_cells_reader(name).map_err(damaged)?;
    let mut out = String::new();
    let mut words = TextNumbers::default();
    let (mut row, mut column, mut cells, mut numbers, mut width) = (0, 0, 0usize, 0usize, 0u32);
    while let Some(cell) = reader.next_cell().map_err(damaged)? {
        let (own_row, own_column) = cell.get_position();
        cells += 1;
        width = width.max(own_column);
        if cells > MOST_CELLS || own_row > MOST_SIZE[0] || own_column > MOST_SIZE[1] || out.len() > most_bytes {
            return Err(damaged(()));
        }
        while row < own_row {
            out.push('\n');
            row += 1;
            column = 0;
        }
        while column < own_column {
            out.push('\t');
            column += 1;
        }
        // Writing into a String cannot fail.
        match cell.get_value() {
            DataRef::Int(value) => {
                numbers += 1;
                let _ = write!(out, "{value}");
            }
            DataRef::Float(value) => {
                numbers += 1;
                let _ = write!(out, "{value}");
            }
            DataRef::String(text) => words.push(&mut out, text, [own_row, own_column]),
            DataRef::SharedString(text) => words.push(&mut out, text, [own_row, own_column]),
            _ => {}
        }
    }
    numbers += words.found.len();
    words.write(&mut out)?;
    // Empty cells at the end of a row are not in the file.
    if out.len() + out.lines().count() * width as usize > most_bytes {
        return Err(damaged(()));
    }
    let padded = out.lines().map(|line| {
        format!("{line}{}\n", "\t".repeat(width as usize - line.matches('\t').count().min(width as usize)))
    });
    Ok((padded.collect(), numbers))
}

/// Sum of the unpacked sizes that the central directory of an archive declares.
fn unpacked_size(bytes: &[u8]) -> u64 {
    let entries = bytes.windows(28).filter(|window| window.starts_with(b"PK\x01\x02"));
    entries.filter_map(|entry| Some(u64::from(u32::from_le_bytes(entry.get(24..28)?.try_into().ok()?)))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checksum of an entry of an archive (polynomial 0xEDB88320).
    fn checksum(bytes: &[u8]) -> u32 {
        let step = |value: u32, _| if value & 1 == 1 { (value >> 1) ^ 0xedb8_8320 } else { value >> 1 };
        !bytes.iter().fold(u32::MAX, |value, byte| (0..8).fold(value ^ u32::from(*byte), step))
    }

    /// An archive of entries that are stored without compression.
    fn archive(entries: &[(&str, String)]) -> Vec<u8> {
        let (mut out, mut directory) = (Vec::new(), Vec::new());
        for (name, text) in entries {
            let start = (out.len() as u32).to_le_bytes();
            let size = (text.len() as u32).to_le_bytes();
            let length = (name.len() as u16).to_le_bytes();
            let common = [
                &[20, 0, 0, 0, 0, 0, 0, 0, 33, 0][..],
                &checksum(text.as_bytes()).to_le_bytes(),
                &size,
                &size,
                &length,
                &[0, 0],
            ]
            .concat();
            directory.extend([b"PK\x01\x02\x14\x00".as_slice(), &common, &[0; 10], &start, name.as_bytes()].concat());
            out.extend([b"PK\x03\x04".as_slice(), &common, name.as_bytes(), text.as_bytes()].concat());
        }
        let count = (entries.len() as u16).to_le_bytes();
        let (place, size) = ((out.len() as u32).to_le_bytes(), (directory.len() as u32).to_le_bytes());
        [&out[..], &directory, b"PK\x05\x06\0\0\0\0", &count, &count, &size, &place, &[0, 0]].concat()
    }

    fn book() -> Vec<u8> {
        let cell = |place: &str, value: f64| format!("<c r=\"{place}\"><v>{value}</v></c>");
        let word = |place: &str, text: &str| format!("<c r=\"{place}\" t=\"inlineStr\"><is><t>{text}</t></is></c>");
        let sheet = format!(
            "<?xml version=\"1.0\"?><worksheet xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\"><sheetData>\
             <row r=\"1\">{}{}</row><row r=\"2\">{}{}</row><row r=\"3\">{}{}</row></sheetData></worksheet>",
            word("A1", "Target [mm]"),
            word("B1", "1+"),
            cell("A2", 0.0),
            cell("B2", 0.5),
            cell("A3", 100.0),
            cell("B3", 2.5)
        );
        let types =
            "<?xml version=\"1.0\"?><Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\"/>"
                .to_owned();
        let workbook = "<?xml version=\"1.0\"?><workbook xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\" \
            xmlns:r=\"http://schemas.openxmlformats.org/officeDocument/2006/relationships\"><sheets><sheet name=\"Lauf\" sheetId=\"1\" r:id=\"rId1\"/></sheets></workbook>".to_owned();
        let links = "<?xml version=\"1.0\"?><Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Id=\"rId1\" \
            Type=\"http://schemas.openxmlformats.org/officeDocument/2006/relationships/worksheet\" Target=\"worksheets/sheet1.xml\"/></Relationships>".to_owned();
        let root = links.replace("worksheet\"", "officeDocument\"").replace("worksheets/sheet1.xml", "xl/workbook.xml");
        archive(&[
            ("[Content_Types].xml", types),
            ("_rels/.rels", root),
            ("xl/workbook.xml", workbook),
            ("xl/_rels/workbook.xml.rels", links),
            ("xl/worksheets/sheet1.xml", sheet),
        ])
    }

    #[test]
    fn a_sheet_becomes_text() {
        let (name, text, others) = text(&book(), 1 << 20).unwrap();
        assert_eq!((name.as_str(), others.len()), ("Lauf", 0));
        assert_eq!(text, "Target [mm]\t1+\n0\t0.5\n100\t2.5\n");
    }

    /// Text cells of a sheet beside its numbers.
    fn written(cells: &[&str]) -> Result<String, String> {
        let (mut out, mut words) = (String::new(), TextNumbers::default());
        for (row, cell) in (0..).zip(cells) {
            words.push(&mut out, cell, [row, 2]);
            out.push('\t');
        }
        words.write(&mut out).map(|()| out)
    }

    #[test]
    fn numbers_that_are_text_get_a_decimal_point() {
        assert_eq!(
            written(&["24,2", "1,234", "Abw. [µm]", "1+", "\u{2212}3,5"]).unwrap(),
            "24.2\t1.234\tAbw. [µm]\t1+\t-3.5\t"
        );
        assert_eq!(written(&["24.2", "1,234.5", "7"]).unwrap(), "24.2\t1234.5\t7\t");
        assert_eq!(written(&["1.234,5", "0,125"]).unwrap(), "1234.5\t0.125\t");
        let open = written(&["7", "1,234"]).unwrap_err();
        assert!(open.contains("cell C2 has '1,234'") && open.contains("1.234 or 1234"), "{open}");
        let two = written(&["24,2", "", "", "2.4"]).unwrap_err();
        assert!(two.contains("2.4 in C4, 24,2 in C1"), "{two}");
        assert_eq!([[0, 0], [3, 25], [9, 26], [0, 701]].map(name_of), ["A1", "Z4", "AA10", "ZZ1"]);
    }

    #[test]
    fn damaged_workbooks_are_refused() {
        let book = book();
        for cut in (0..book.len()).step_by(37) {
            let _ = text(&book[..cut], 1 << 20);
            let mut damaged = book.clone();
            damaged[cut] ^= 0x55;
            let _ = text(&damaged, 1 << 20);
        }
        assert!(text(b"PK\x03\x04", 1 << 20).is_err());
    }
}
