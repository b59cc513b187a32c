//! Bytes of arrays as VTK encodes them: raw or in base64, whole or in blocks of zlib.

use std::borrow::Cow;
use std::io::Read;

use flate2::read::ZlibDecoder;

use crate::io::Parsed;
use crate::io::bytes::Cursor;

/// Most that zlib makes of a byte; what says that it has more is broken.
const LARGEST_RATIO: usize = 1032;

/// How a file writes the sizes in front of its data.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Bytes of a size: 4 or 8.
    pub word: usize,
    /// Whether numbers begin with their highest byte.
    pub big_endian: bool,
    /// Whether data are blocks of zlib.
    pub compressed: bool,
}

/// Encoded bytes that are read from front to back.
#[derive(Clone)]
pub enum Stream<'a> {
    /// As they are.
    Raw(&'a [u8]),
    /// In base64, of which each part that was encoded by itself ends with its padding.
    Base64(Base64<'a>),
}

/// Text in base64, and bytes that were decoded too early.
#[derive(Clone)]
pub struct Base64<'a> {
    text: &'a [u8],
    early: Vec<u8>,
}

impl<'a> Base64<'a> {
    pub fn new(text: &'a [u8]) -> Self {
        Self { text, early: Vec::new() }
    }

    /// The next character that is not blank.
    fn next(&mut self) -> Parsed<u8> {
        let blank = self.text.iter().take_while(|c| c.is_ascii_whitespace()).count();
        let (&c, rest) = self.text[blank..].split_first().ok_or("the file is truncated")?;
        self.text = rest;
        Ok(c)
    }

    /// Decodes the next four characters.
    fn decode(&mut self) -> Parsed<()> {
        let (mut bits, mut kept) = (0_u32, 3);
        for place in 0..4 {
            let c = self.next()?;
            let value = match c {
                b'A'..=b'Z' => c - b'A',
                b'a'..=b'z' => c - b'a' + 26,
                b'0'..=b'9' => c - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                b'=' if place > 1 => {
                    kept = kept.min(place - 1);
                    0
                }
                _ => return Err(format!("{:?} is no base64", char::from(c))),
            };
            bits = bits << 6 | u32::from(value);
        }
        self.early.extend(&bits.to_be_bytes()[1..=kept]);
        Ok(())
    }

    fn take(&mut self, n: usize) -> Parsed<Vec<u8>> {
        if n > self.early.len() + self.text.len() {
            return Err(format!("the file is truncated: {n} more bytes needed"));
        }
        while self.early.len() < n {
            self.decode()?;
        }
        let rest = self.early.split_off(n);
        Ok(std::mem::replace(&mut self.early, rest))
    }
}

impl<'a> Stream<'a> {
    /// From a place on: a byte of raw data, a character of base64.
    pub fn from(&self, offset: usize) -> Parsed<Self> {
        let after = |data: &'a [u8]| data.get(offset..).ok_or("the file is truncated");
        Ok(match self {
            Self::Raw(data) => Self::Raw(after(data)?),
            Self::Base64(base) => Self::Base64(Base64::new(after(base.text)?)),
        })
    }

    fn take(&mut self, n: usize) -> Parsed<Cow<'a, [u8]>> {
        match self {
            Self::Raw(data) => {
                let mut cursor = Cursor::new(data);
                let taken = cursor.take(n)?;
                *data = &data[n..];
                Ok(Cow::Borrowed(taken))
            }
            Self::Base64(base) => base.take(n).map(Cow::Owned),
        }
    }

    /// A size in front of data.
    fn size(&mut self, layout: Layout) -> Parsed<usize> {
        let bytes = self.take(layout.word)?;
        let digit = |sum: u64, &byte: &u8| sum << 8 | u64::from(byte);
        let size = match layout.big_endian {
            true => bytes.iter().fold(0, digit),
            false => bytes.iter().rev().fold(0, digit),
        };
        usize::try_from(size).map_err(|_| format!("{size} bytes of an array"))
    }

    /// The bytes of the array that begins here.
    pub fn array(&mut self, layout: Layout) -> Parsed<Cow<'a, [u8]>> {
        let first = self.size(layout)?;
        if !layout.compressed {
            return self.take(first);
        }
        let [each, last] = [self.size(layout)?, self.size(layout)?];
        // one by one: a count that is too large ends with the file
        let mut sizes = Vec::new();
        for _ in 0..first {
            sizes.push(self.size(layout)?);
        }
        let mut all = Vec::new();
        for (i, &size) in sizes.iter().enumerate() {
            let is_part = i + 1 == first && last > 0;
            inflate(&self.take(size)?, if is_part { last } else { each }, &mut all)?;
        }
        Ok(Cow::Owned(all))
    }
}

/// Adds a block that has so many bytes.
fn inflate(block: &[u8], size: usize, out: &mut Vec<u8>) -> Parsed<()> {
    let wrong = |found: String| format!("a block of zlib {found}; {size} bytes are needed");
    if size / LARGEST_RATIO > block.len() {
        return Err(wrong(format!("has {} bytes", block.len())));
    }
    let before = out.len();
    let mut decoder = ZlibDecoder::new(block).take(size as u64 + 1);
    decoder.read_to_end(out).map_err(|error| wrong(format!("is broken ({error})")))?;
    if out.len() - before != size {
        return Err(wrong(format!("makes {} bytes or more", out.len() - before)));
    }
    Ok(())
}
