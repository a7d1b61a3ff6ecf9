//! Telegrams of LSV/2: a name of four letters and its data.
//!
//! Over TCP, four bytes come first: the length of the data, the most significant byte first. The name is not counted.

use super::super::Wire;
use super::super::answers::shown;

/// Longest telegram that is accepted, bytes of data. The largest buffer of a control has 4096 bytes.
const MOST_BYTES: usize = 16_384;
/// Length and name.
const HEAD: usize = 8;

/// One telegram.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Telegram {
    pub(super) name: [u8; 4],
    pub(super) data: Vec<u8>,
}

impl Telegram {
    /// Builds a telegram from its name and data.
    pub(super) fn new(name: [u8; 4], data: Vec<u8>) -> Telegram {
        Telegram { name, data }
    }

    /// Splits the bytes of a telegram without a length.
    ///
    /// # Errors
    /// They do not begin with a name. The error is a sentence.
    pub(super) fn of(bytes: &[u8]) -> Result<Telegram, String> {
        let (name, data) = bytes.split_at_checked(4).ok_or("an answer is shorter than the name of a telegram")?;
        let name: [u8; 4] = name.try_into().map_err(|_| "an answer has no name".to_owned())?;
        check_name(&name)?;
        Ok(Telegram { name, data: data.to_vec() })
    }

    /// Returns its name for display.
    pub(super) fn shown(&self) -> String {
        shown(&String::from_utf8_lossy(&self.name))
    }
}

/// Checks that bytes are the name of a telegram: capitals, digits and `_`.
fn check_name(name: &[u8]) -> Result<(), String> {
    if name.iter().all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit() || *byte == b'_') {
        return Ok(());
    }
    Err(format!("'{}' is not the name of a telegram", shown(&String::from_utf8_lossy(name))))
}

/// Telegrams over TCP.
#[derive(Debug, Default)]
pub(super) struct TcpTelegrams {
    head: Vec<u8>,
    data: Vec<u8>,
}

impl TcpTelegrams {
    pub(super) fn send(telegram: &Telegram, wire: &mut Wire) {
        // No telegram of this program reaches the limit of 32 bits.
        wire.push(&u32::try_from(telegram.data.len()).unwrap_or(u32::MAX).to_be_bytes());
        wire.push(&telegram.name);
        wire.push(&telegram.data);
    }

    /// Takes a received byte. Returns a telegram if it is complete.
    ///
    /// # Errors
    /// The bytes are not a telegram. The error is a sentence.
    pub(super) fn hear(&mut self, byte: u8) -> Result<Option<Telegram>, String> {
        let is_head = self.head.len() < HEAD;
        if is_head { &mut self.head } else { &mut self.data }.push(byte);
        let Some((length, name)) = self.head.split_at_checked(4) else { return Ok(None) };
        let length = length.iter().fold(0, |sum, byte| sum << 8 | usize::from(*byte));
        if length > MOST_BYTES {
            return Err(format!("an answer announces {length} bytes, more than {MOST_BYTES}"));
        }
        check_name(name)?;
        if self.head.len() < HEAD || self.data.len() < length {
            return Ok(None);
        }
        let name = name.try_into().unwrap_or_default();
        self.head.clear();
        Ok(Some(Telegram { name, data: std::mem::take(&mut self.data) }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The login of a published trace: `00 00 00 08 A_LG INSPECT 00`.
    #[test]
    fn a_login_has_the_bytes_of_a_published_trace() {
        let mut wire = Wire::default();
        TcpTelegrams::send(&Telegram::new(*b"A_LG", b"INSPECT\0".to_vec()), &mut wire);
        assert_eq!(wire.next(99), b"\0\0\0\x08A_LGINSPECT\0");
    }

    fn hear(bytes: &[u8]) -> Result<Vec<Telegram>, String> {
        let mut tcp = TcpTelegrams::default();
        let mut found = Vec::new();
        for byte in bytes {
            found.extend(tcp.hear(*byte)?);
        }
        Ok(found)
    }

    #[test]
    fn telegrams_are_split_wherever_the_bytes_are_cut() {
        let found = hear(b"\0\0\0\0T_OK\0\0\0\x02T_ER\x01\x17\0\0\0\x01T").unwrap();
        let expected = [Telegram::new(*b"T_OK", Vec::new()), Telegram::new(*b"T_ER", vec![1, 0x17])];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_giant_length_ends_at_its_fourth_byte() {
        assert!(hear(b"\x7f\xff\xff\xff").unwrap_err().contains("2147483647"));
        assert!(hear(b"HTTP/1.1 400").unwrap_err().contains("announces"));
        assert!(hear(b"\0\0\0\x01\x1b[0m").unwrap_err().contains("not the name"));
        assert!(Telegram::of(b"T_O").is_err() && Telegram::of(b"t_ok").is_err());
    }
}
