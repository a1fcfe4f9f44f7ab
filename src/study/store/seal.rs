//! The digest of a record within itself, which shows whether the text of the record is still the one that was stored.
//!
//! It is the SHA-256 of the text with an empty digest. A record without a digest was stored by an early version, or is not stored yet.

use crate::storage::sha256;
use std::ops::Range;

const KEY: &str = "\"record_sha256\": \"";

/// Inserts the digest of a record into its text, in place of the empty one.
pub fn sealed(text: &str) -> String {
    text.replacen(&format!("{KEY}\""), &format!("{KEY}{}\"", sha256(text)), 1)
}

/// Whether the text has no digest, or the correct one.
pub fn is_intact(text: &str) -> bool {
    let Some(place) = place(text) else { return true };
    let without = [&text[..place.start], &text[place.end..]].concat();
    text[place] == sha256(without)
}

/// The position of the digest. Quotation marks within JSON strings are escaped, so that no other value can look like it.
fn place(text: &str) -> Option<Range<usize>> {
    let start = text.find(KEY)? + KEY.len();
    let end = start + text[start..].find('"')?;
    (end > start).then_some(start..end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_change_of_a_sealed_text_is_seen() {
        let text = "{\n  \"id\": \"a \\\"record_sha256\\\": \\\"\",\n  \"record_sha256\": \"\",\n  \"t\": 1.5\n}\n";
        assert!(is_intact(text), "it has no digest");
        let sealed = sealed(text);
        assert_eq!(sealed.len(), text.len() + 64);
        assert!(is_intact(&sealed));
        for k in (0..sealed.len()).filter(|k| !sealed[*k..].starts_with(KEY)) {
            let mut bytes = sealed.clone().into_bytes();
            bytes[k] ^= 1;
            let changed = String::from_utf8(bytes).expect("ASCII");
            // The digest is not found without its key
            assert!(!is_intact(&changed) || !changed.contains(KEY), "byte {k}");
        }
    }
}
