//! Compact storage of numbers and texts of a million lines in a page of some megabytes: integer streams with similar neighbors, packed together.
//!
//! A stream is differenced, its signs are folded in (zigzag), and it is written in groups of seven bits (LEB128). All streams together are compressed with
//! gzip, which browsers decompress themselves, and encoded as base64, in which nothing can be mistaken for markup.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Serialize;
use serde_json::Value;

/// Stream as described in the header.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
struct Stream {
    name: String,
    /// Number of times that it is differenced.
    order: u8,
    count: usize,
    bytes: usize,
}

/// Packed data under construction.
#[derive(Clone, Debug, Default)]
pub(super) struct Packed {
    streams: Vec<Stream>,
    bytes: Vec<u8>,
}

impl Packed {
    /// Adds a stream in the order of differences that is shortest.
    pub(super) fn put(&mut self, name: impl Into<String>, values: &[i64]) {
        let order = (0..3).min_by_key(|&order| differences(values, order).map(length).sum::<usize>()).unwrap_or(0);
        self.put_in(name, values, order);
    }

    /// Adds a stream in a given order.
    pub(super) fn put_in(&mut self, name: impl Into<String>, values: &[i64], order: u8) {
        let from = self.bytes.len();
        for value in differences(values, order) {
            write(&mut self.bytes, folded(value));
        }
        let bytes = self.bytes.len() - from;
        self.streams.push(Stream { name: name.into(), order, count: values.len(), bytes });
    }

    /// Returns everything as text; the caller adds its own header entries.
    pub(super) fn text(&self, header: &mut serde_json::Map<String, Value>) -> Result<String, std::io::Error> {
        header.insert("streams".into(), serde_json::to_value(&self.streams)?);
        let header = serde_json::to_vec(header)?;
        let length = u32::try_from(header.len()).map_err(std::io::Error::other)?;
        let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
        gzip.write_all(&length.to_le_bytes())?;
        gzip.write_all(&header)?;
        gzip.write_all(&self.bytes)?;
        Ok(STANDARD.encode(gzip.finish()?))
    }
}

/// Returns the differences of an order; values before the first one are 0.
fn differences(values: &[i64], order: u8) -> impl Iterator<Item = i64> + '_ {
    let (mut last, mut before) = (0_i64, 0_i64);
    values.iter().map(move |&value| {
        let expected = match order {
            0 => 0,
            1 => last,
            _ => last.wrapping_mul(2).wrapping_sub(before),
        };
        (before, last) = (last, value);
        value.wrapping_sub(expected)
    })
}

/// Maps 0, −1, 1, −2 … to 0, 1, 2, 3 …
fn folded(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)).cast_unsigned()
}

/// Returns the number of bytes of a value.
fn length(value: i64) -> usize {
    (64 - (folded(value) | 1).leading_zeros() as usize).div_ceil(7)
}

fn write(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push((value & 0x7f) as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_written_as_the_standard_says() {
        let mut packed = Packed::default();
        // LEB128: 624485 is E5 8E 26 (DWARF 5, section 7.6); zigzag of −312243 is 624485.
        packed.put_in("one", &[-312_243], 0);
        assert_eq!(packed.bytes, [0xe5, 0x8e, 0x26]);
        // Second differences are 0, 100, 0, 0, 1, doubled: six bytes. The values and their first differences take nine.
        packed.put("line", &[0, 100, 200, 300, 401]);
        assert_eq!(packed.bytes[3..], [0, 200, 1, 0, 0, 2]);
        let both: Vec<(&str, u8, usize, usize)> =
            packed.streams.iter().map(|one| (one.name.as_str(), one.order, one.count, one.bytes)).collect();
        assert_eq!(both, [("one", 0, 1, 3), ("line", 2, 5, 6)]);
        assert_eq!([0, -1, 1, 63, -64, 64, i64::MAX, i64::MIN].map(length), [1, 1, 1, 1, 1, 2, 10, 10]);
    }

    #[test]
    fn what_is_packed_is_gzip_in_base64() {
        use std::io::Read as _;
        let mut packed = Packed::default();
        packed.put_in("some", &[1, 2, 3], 1);
        let text = packed.text(&mut serde_json::Map::new()).unwrap();
        let bytes = STANDARD.decode(text).unwrap();
        let mut plain = Vec::new();
        flate2::read::GzDecoder::new(bytes.as_slice()).read_to_end(&mut plain).unwrap();
        let length = u32::from_le_bytes([plain[0], plain[1], plain[2], plain[3]]) as usize;
        let header: Value = serde_json::from_slice(&plain[4..4 + length]).unwrap();
        let stream = serde_json::json!({"name": "some", "order": 1, "count": 3, "bytes": 3});
        assert_eq!(header, serde_json::json!({ "streams": [stream] }));
        assert_eq!(plain[4 + length..], [2, 2, 2]);
    }
}
