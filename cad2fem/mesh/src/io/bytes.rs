//! A cursor over the content of a file, for formats that mix text and binary.

use super::Parsed;

/// Reads lines, words and bytes one after another.
pub struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Number of bytes not read yet.
    pub fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Number of the current line, starting at 1.
    pub fn line_number(&self) -> usize {
        1 + self.bytes[..self.at].iter().filter(|&&b| b == b'\n').count()
    }

    /// The next `n` bytes.
    pub fn take(&mut self, n: usize) -> Parsed<&'a [u8]> {
        let end = self.at.checked_add(n).filter(|&end| end <= self.bytes.len());
        let end = end.ok_or_else(|| {
            let (at, left) = (self.at, self.remaining());
            format!("the file is truncated: {n} more bytes needed at byte {at}, {left} left")
        })?;
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }

    /// The next `N` bytes as an array.
    pub fn array<const N: usize>(&mut self) -> Parsed<[u8; N]> {
        self.take(N).map(|bytes| bytes.try_into().expect("take returns N bytes"))
    }

    /// The rest of the line without its end and surrounding blanks; `None` at
    /// the end of the file.
    pub fn line(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return None;
        }
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        Some(rest[..length].trim_ascii())
    }

    /// The next word, over line ends; `None` at the end of the file.
    pub fn word(&mut self) -> Option<&'a str> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += length;
        (length > 0).then(|| std::str::from_utf8(&rest[..length]).unwrap_or("(not text)"))
    }

    /// Moves to the next byte that is not blank.
    pub fn skip_blanks(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
    }

    /// Moves behind the next occurrence of `pattern`; false if there is none.
    pub fn skip_past(&mut self, pattern: &[u8]) -> bool {
        let found = self.bytes[self.at..].windows(pattern.len()).position(|w| w == pattern);
        self.at += found.map_or(0, |i| i + pattern.len());
        found.is_some()
    }
}
