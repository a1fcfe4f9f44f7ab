//! Reads words, lines and binary numbers from bytes, and reports the position of errors.

use crate::mesh::error::{MeshError, Place, Spot};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// A position in the bytes of a file.
pub(super) struct Cursor<'a> {
    file: PathBuf,
    data: &'a [u8],
    pos: usize,
    /// Whether positions are byte offsets, not lines
    pub binary: bool,
    pub big_endian: bool,
}

impl<'a> Cursor<'a> {
    pub fn new(file: &Path, data: &'a [u8]) -> Self {
        Self { file: file.to_path_buf(), data, pos: 0, binary: false, big_endian: false }
    }

    pub fn place(&self) -> Place {
        let spot = match self.binary {
            true => Spot::Byte(self.pos),
            false => Spot::Line(1 + self.data[..self.pos].iter().filter(|b| **b == b'\n').count()),
        };
        Place { file: self.file.clone(), at: Some(spot) }
    }

    pub fn syntax(&self, wanted: &str, found: &str) -> MeshError {
        MeshError::Syntax { place: self.place(), wanted: wanted.into(), found: found.chars().take(40).collect() }
    }

    pub fn truncated(&self, wanted: &str) -> MeshError {
        MeshError::Truncated { place: self.place(), wanted: wanted.into() }
    }

    /// Returns the next word between white space; `None` at the end of the file.
    pub fn word(&mut self) -> Option<&'a str> {
        let skip = self.data[self.pos..].iter().position(|b| !b.is_ascii_whitespace())?;
        self.pos += skip;
        let rest = &self.data[self.pos..];
        let len = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.pos += len;
        Some(std::str::from_utf8(&rest[..len]).unwrap_or("(bytes that are no text)"))
    }

    /// Reads the next word as a number.
    pub fn parse<T: FromStr>(&mut self, wanted: &str) -> Result<T, MeshError> {
        let word = self.word().ok_or_else(|| self.truncated(wanted))?;
        word.parse().map_err(|_| self.syntax(wanted, word))
    }

    /// Returns the rest of the line, without the line break.
    pub fn line(&mut self) -> Option<&'a str> {
        if self.pos == self.data.len() {
            return None;
        }
        let rest = &self.data[self.pos..];
        let len = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        self.pos += (len + 1).min(rest.len());
        Some(std::str::from_utf8(&rest[..len]).unwrap_or("(bytes that are no text)").trim_end_matches('\r'))
    }

    /// Returns the value that `read` makes from the words of the next line, which must be used up exactly.
    pub fn whole_line<T>(
        &mut self,
        wanted: &str,
        read: impl FnOnce(&mut Self) -> Result<T, MeshError>,
    ) -> Result<T, MeshError> {
        let blanks = self.data[self.pos..].iter().take_while(|b| b.is_ascii_whitespace()).count();
        let begin = self.pos + blanks;
        let line = self.data[begin..].split(|b| *b == b'\n').next().unwrap_or_default();
        let value = read(self);
        let rest = self.data.get(self.pos..begin + line.len());
        if rest.is_some_and(|rest| value.is_err() || rest.trim_ascii().is_empty()) {
            return value;
        }
        self.pos = begin;
        Err(self.syntax(wanted, String::from_utf8_lossy(line).trim()))
    }

    /// Reads `N` bytes, converted to the byte order of the machine.
    fn bytes<const N: usize>(&mut self, wanted: &str) -> Result<[u8; N], MeshError> {
        let rest = &self.data[self.pos..];
        let mut bytes: [u8; N] = rest.get(..N).ok_or_else(|| self.truncated(wanted))?.try_into().expect("N bytes");
        self.pos += N;
        if self.big_endian != cfg!(target_endian = "big") {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// Reads a byte of a binary file.
    pub fn byte(&mut self, wanted: &str) -> Result<i8, MeshError> {
        Ok(i8::from_ne_bytes(self.bytes(wanted)?))
    }

    /// Reads a 2-byte integer of a binary file.
    pub fn short(&mut self, wanted: &str) -> Result<i16, MeshError> {
        Ok(i16::from_ne_bytes(self.bytes(wanted)?))
    }

    /// Reads a 4-byte integer, or a word of a text file.
    pub fn int(&mut self, wanted: &str) -> Result<i64, MeshError> {
        if self.binary { Ok(i32::from_ne_bytes(self.bytes(wanted)?).into()) } else { self.parse(wanted) }
    }

    /// Reads an 8-byte integer, or a word of a text file.
    pub fn long(&mut self, wanted: &str) -> Result<i64, MeshError> {
        if self.binary { Ok(i64::from_ne_bytes(self.bytes(wanted)?)) } else { self.parse(wanted) }
    }

    /// Reads an 8-byte float, or a word of a text file.
    pub fn double(&mut self, wanted: &str) -> Result<f64, MeshError> {
        if self.binary {
            return Ok(f64::from_ne_bytes(self.bytes(wanted)?));
        }
        let word = self.word().ok_or_else(|| self.truncated(wanted))?;
        let number = word.parse().ok().or_else(|| is_no_number(word).then_some(f64::NAN));
        number.ok_or_else(|| self.syntax(wanted, word))
    }

    /// Reads a 4-byte float, or a word of a text file.
    pub fn float(&mut self, wanted: &str) -> Result<f64, MeshError> {
        if self.binary { Ok(f32::from_ne_bytes(self.bytes(wanted)?).into()) } else { self.parse(wanted) }
    }

    /// Checks a count whose entries need at least `bytes_each` bytes each; a count that cannot fit into the rest of the file is refused before memory
    /// is allocated.
    pub fn count(&self, value: i64, bytes_each: usize, wanted: &str) -> Result<usize, MeshError> {
        let count = usize::try_from(value).map_err(|_| self.syntax(wanted, &value.to_string()))?;
        let fits = count.checked_mul(bytes_each).is_some_and(|need| need <= self.data.len() - self.pos);
        if fits { Ok(count) } else { Err(self.truncated(&format!("{wanted} ({count} announced)"))) }
    }

    /// Moves past the next occurrence of `text`; false if there is none.
    pub fn skip_past(&mut self, text: &str) -> bool {
        let found = self.data[self.pos..].windows(text.len()).position(|w| w == text.as_bytes());
        self.pos = found.map_or(self.data.len(), |at| self.pos + at + text.len());
        found.is_some()
    }

    /// Returns the next word without moving.
    pub fn peek(&mut self) -> Option<&'a str> {
        let pos = self.pos;
        let word = self.word();
        self.pos = pos;
        word
    }
}

/// Whether a word is one of the forms in which C on Windows writes values that are not finite: `-nan(ind)`, `1.#QNAN`, `-1.#INF`.
fn is_no_number(word: &str) -> bool {
    let word = word.trim_start_matches('-');
    word.starts_with("1.#") || word.starts_with("nan(") && word.ends_with(')')
}
