//! Arrays of numbers in a file.

use std::borrow::Cow;

use super::Field;
use super::encoded::{Base64, Layout, Stream};
use crate::io::Parsed;

/// Numbers of an array, with what its tag says.
pub struct Array<'a> {
    /// The element that it is in: `Points`, `Cells`, `PointData` or `CellData`.
    pub group: &'a str,
    /// What the file calls the array.
    pub label: String,
    unit: String,
    components: usize,
    numbers: Numbers,
}

/// Whole numbers, or others.
enum Numbers {
    Whole(Vec<i64>),
    Real(Vec<f64>),
}

/// How a number is written.
#[derive(Clone, Copy)]
enum Kind {
    /// So many bytes, with a sign or without.
    Whole(usize, bool),
    /// So many bytes.
    Real(usize),
}

impl Kind {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "Int8" => Self::Whole(1, true),
            "UInt8" => Self::Whole(1, false),
            "Int16" => Self::Whole(2, true),
            "UInt16" => Self::Whole(2, false),
            "Int32" => Self::Whole(4, true),
            "UInt32" => Self::Whole(4, false),
            "Int64" => Self::Whole(8, true),
            "UInt64" => Self::Whole(8, false),
            "Float32" => Self::Real(4),
            "Float64" => Self::Real(8),
            _ => return None,
        })
    }

    fn of_text(self, text: &str) -> Parsed<Numbers> {
        let wrong = |word: &str| format!("{word:?} is not such a number");
        let words = text.split_ascii_whitespace();
        Ok(match self {
            Self::Whole(..) => Numbers::Whole(
                words.map(|w| w.parse().map_err(|_| wrong(w))).collect::<Parsed<_>>()?,
            ),
            Self::Real(_) => Numbers::Real(
                words.map(|w| w.parse().map_err(|_| wrong(w))).collect::<Parsed<_>>()?,
            ),
        })
    }

    fn of_bytes(self, bytes: &[u8], big_endian: bool) -> Parsed<Numbers> {
        let (Self::Whole(size, _) | Self::Real(size)) = self;
        if !bytes.len().is_multiple_of(size) {
            return Err(format!("{} bytes do not divide into {size}", bytes.len()));
        }
        let bits = |bytes: &[u8]| {
            let digit = |sum: u64, &byte: &u8| sum << 8 | u64::from(byte);
            match big_endian {
                true => bytes.iter().fold(0, digit),
                false => bytes.iter().rev().fold(0, digit),
            }
        };
        let all = bytes.chunks_exact(size).map(bits);
        let unused = 64 - 8 * size as u32;
        Ok(match self {
            Self::Whole(_, true) => {
                Numbers::Whole(all.map(|b| (b << unused).cast_signed() >> unused).collect())
            }
            Self::Whole(_, false) => {
                let whole = all.map(|b| i64::try_from(b).map_err(|_| format!("{b} is too large")));
                Numbers::Whole(whole.collect::<Parsed<_>>()?)
            }
            Self::Real(4) => {
                Numbers::Real(all.map(|b| f64::from(f32::from_bits(b as u32))).collect())
            }
            Self::Real(_) => Numbers::Real(all.map(f64::from_bits).collect()),
        })
    }
}

impl<'a> Array<'a> {
    /// From its tag and the text in it, with the appended data of the file.
    pub fn parse(
        group: &'a str,
        (tag, text): (&str, &str),
        appended: Option<&Stream>,
        layout: Layout,
    ) -> Parsed<Self> {
        let label = attribute(tag, "Name").ok_or("a DataArray has no Name")?;
        let components = attribute(tag, "NumberOfComponents").map_or(Ok(1), |n| {
            n.parse().map_err(|_| format!("array {label:?}: {n:?} components"))
        })?;
        let unit = attribute(tag, "Unit").unwrap_or_default();
        let numbers = numbers(tag, text, appended, layout);
        let numbers = numbers.map_err(|m| format!("array {label:?}: {m}"))?;
        Ok(Self { group, label, unit, components, numbers })
    }

    /// Whole numbers.
    pub fn whole(&self) -> Parsed<&[i64]> {
        match &self.numbers {
            Numbers::Whole(values) => Ok(values),
            Numbers::Real(_) => Err(format!("array {:?} is not of whole numbers", self.label)),
        }
    }

    /// The numbers of so many points or cells.
    pub fn field(&self, count: usize) -> Parsed<Field> {
        let values: Cow<[f64]> = match &self.numbers {
            Numbers::Whole(values) => values.iter().map(|&i| i as f64).collect(),
            Numbers::Real(values) => Cow::Borrowed(values),
        };
        if count.checked_mul(self.components) != Some(values.len()) {
            let (label, n, parts) = (&self.label, values.len(), self.components);
            return Err(format!("array {label:?} has {n} values, not {count} × {parts}"));
        }
        if let Some(i) = values.iter().position(|x| !x.is_finite()) {
            return Err(format!("array {:?} is {} at index {i}", self.label, values[i]));
        }
        let (name, unit, components) = (self.label.clone(), self.unit.clone(), self.components);
        Ok(Field { name, unit, components, values: values.into_owned() })
    }
}

fn numbers(tag: &str, text: &str, appended: Option<&Stream>, layout: Layout) -> Parsed<Numbers> {
    let name = attribute(tag, "type").unwrap_or_default();
    let kind = Kind::of(&name).ok_or_else(|| format!("{name:?} is no type of numbers"))?;
    let bytes = match attribute(tag, "format").unwrap_or_default().as_str() {
        "ascii" => return kind.of_text(text),
        "binary" => Stream::Base64(Base64::new(text.as_bytes())).array(layout)?,
        "appended" => {
            let data = appended.ok_or("there are no appended data")?;
            return kind
                .of_bytes(&data.from(number(tag, "offset")?)?.array(layout)?, layout.big_endian);
        }
        other => return Err(format!("format {other:?}; ascii, binary or appended is needed")),
    };
    kind.of_bytes(&bytes, layout.big_endian)
}

/// The whole number in an attribute.
pub fn number(tag: &str, name: &str) -> Parsed<usize> {
    let text = attribute(tag, name).ok_or_else(|| format!("the attribute {name} is missing"))?;
    text.parse().map_err(|_| format!("{name} is {text:?}, not a number"))
}

/// The value of an attribute of an XML tag, with the escapes of writers undone.
pub fn attribute(tag: &str, name: &str) -> Option<String> {
    let begins = |&at: &usize| tag[..at].ends_with(|c: char| c.is_ascii_whitespace());
    let start = format!("{name}=\"");
    let at = tag.match_indices(&start).map(|(at, _)| at).find(begins)?;
    let (value, _) = tag[at + start.len()..].split_once('"')?;
    let plain = value
        .replace("&quot;", "\"")
        .replace("&gt;", ">")
        .replace("&lt;", "<")
        .replace("&amp;", "&");
    Some(plain)
}
