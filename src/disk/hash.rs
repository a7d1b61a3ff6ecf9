//! Hashes of files: short ones for stamps and comments, complete ones for journals.

use ncfix_base::source::Source;
use ncfix_report::inputs::InputFile;
use sha2::{Digest as _, Sha256};

/// The first 12 hexadecimal digits of SHA-256: long enough to distinguish versions of a file, short enough for a comment.
pub(crate) fn short_hash<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut hasher = Sha256::new();
    for part in parts {
        // The length before each part keeps the parts separate.
        hasher.update((part.len() as u64).to_le_bytes());
        hasher.update(part);
    }
    hasher.finalize().iter().take(6).map(|byte| format!("{byte:02x}")).collect()
}

/// All digits of the SHA-256 of a file, as printed by `sha256sum`.
pub(crate) fn whole_hash(bytes: &[u8]) -> String {
    digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256.
pub(crate) fn digest(bytes: &[u8]) -> Vec<u8> {
    Sha256::digest(bytes).to_vec()
}

/// An input file of a result, with its role.
pub(crate) fn input_of(source: &Source, role: &'static str) -> InputFile {
    InputFile { file: source.name().to_owned(), role, hash: short_hash([source.bytes()]) }
}

#[cfg(test)]
mod tests {
    use super::short_hash;

    #[test]
    fn the_hash_is_that_of_sha256_and_keeps_borders() {
        // `printf '\3\0\0\0\0\0\0\0abc' | sha256sum`
        assert_eq!(short_hash([&b"abc"[..]]), "ce91dc5eec01");
        assert_ne!(short_hash([&b"ab"[..], b"c"]), short_hash([&b"a"[..], b"bc"]));
    }
}
