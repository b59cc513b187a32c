//! Sections and numbers of a Gmsh file, ASCII or binary.

use crate::Vec3;
use crate::io::Parsed;
use crate::io::bytes::Cursor;

/// Reads a Gmsh file number by number. Binary and ASCII files hold the same
/// sequence of numbers, so that the parsers above need not tell them apart.
pub struct Source<'a> {
    cursor: Cursor<'a>,
    is_binary: bool,
}

impl<'a> Source<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { cursor: Cursor::new(bytes), is_binary: false }
    }

    /// Reads `$MeshFormat`; the major version, 2 or 4.
    pub fn header(&mut self) -> Parsed<u32> {
        let first = self.cursor.word().unwrap_or("nothing");
        if first != "$MeshFormat" {
            let first: String = first.chars().take(40).collect();
            return Err(format!("not a Gmsh file: it begins with {first:?}, not \"$MeshFormat\""));
        }
        let version = self.cursor.word().unwrap_or("nothing");
        let major = match version {
            "2" | "2.0" | "2.1" | "2.2" => 2,
            "4.1" => 4,
            _ => {
                return Err(format!(
                    "Gmsh format {version:?}; 2.0 to 2.2 and 4.1 can be read. Convert it with: \
                     gmsh IN.msh -save -format msh41 -o OUT.msh"
                ));
            }
        };
        let binary = self.cursor.word();
        let size = self.cursor.word().unwrap_or("nothing");
        if size != "8" {
            return Err(format!("numbers of {size:?} bytes in $MeshFormat; 8 are needed"));
        }
        self.cursor.line();
        self.is_binary = match binary {
            Some("0") => false,
            Some("1") => match i32::from_le_bytes(self.cursor.array()?) {
                1 => true,
                other => {
                    return Err(format!(
                        "the byte order mark is {other}, not 1 with its lowest byte first"
                    ));
                }
            },
            other => return Err(format!("file type {other:?} is neither 0 (ASCII) nor 1")),
        };
        self.end_section("MeshFormat")?;
        Ok(major)
    }

    /// The name of the next section; `None` at the end of the file.
    pub fn next_section(&mut self) -> Parsed<Option<String>> {
        let Some(word) = self.cursor.word() else { return Ok(None) };
        let name = word.strip_prefix('$').ok_or_else(|| {
            let line = self.cursor.line_number();
            format!("line {line}: found {word:?} where a section such as \"$Nodes\" must begin")
        })?;
        self.cursor.line();
        Ok(Some(name.to_string()))
    }

    pub fn end_section(&mut self, name: &str) -> Parsed<()> {
        match self.cursor.word() {
            Some(word) if word.strip_prefix("$End") == Some(name) => {
                self.cursor.line();
                Ok(())
            }
            Some(word) => {
                let word: String = word.chars().take(40).collect();
                Err(format!("found {word:?} where $End{name} is due: the counts are wrong"))
            }
            None => Err(format!("the file is truncated: $End{name} is missing")),
        }
    }

    /// Skips a section whose content plays no part.
    pub fn skip_section(&mut self, name: &str) -> Parsed<()> {
        let end = format!("$End{name}");
        if !self.cursor.skip_past(end.as_bytes()) {
            return Err(format!("the file is truncated: {end} is missing"));
        }
        self.cursor.line();
        Ok(())
    }

    /// Number and name of the groups of dimension 2, then of those of dimension 3, in
    /// `$PhysicalNames`, which is text in binary files, too.
    pub fn physical_names(&mut self) -> Parsed<[Vec<(i32, String)>; 2]> {
        let count = self.text_count()?;
        let [mut surfaces, mut volumes] = [Vec::new(), Vec::new()];
        for _ in 0..count {
            let line = self.cursor.line().ok_or("the file is truncated")?;
            let line = std::str::from_utf8(line).map_err(|_| "a physical name is not UTF-8")?;
            let (dimension, number, name) = physical_name(line)
                .ok_or_else(|| format!("{line:?} is not of the form: dimension number \"name\""))?;
            match dimension {
                2 => surfaces.push((number, name.to_string())),
                3 => volumes.push((number, name.to_string())),
                _ => {}
            }
        }
        Ok([surfaces, volumes])
    }

    pub fn is_binary(&self) -> bool {
        self.is_binary
    }

    /// A count on a line of its own, text in binary files, too.
    pub fn text_count(&mut self) -> Parsed<usize> {
        let count = self.word()?;
        self.cursor.line();
        Ok(count)
    }

    /// A 32-bit integer.
    pub fn int(&mut self) -> Parsed<i32> {
        if self.is_binary { self.cursor.array().map(i32::from_le_bytes) } else { self.word() }
    }

    /// A 64-bit unsigned integer.
    pub fn size(&mut self) -> Parsed<u64> {
        if self.is_binary { self.cursor.array().map(u64::from_le_bytes) } else { self.word() }
    }

    /// A 64-bit count of things that take at least one byte each; counts beyond
    /// the file's length are errors before anything is allocated.
    pub fn count(&mut self) -> Parsed<usize> {
        let count = self.size()?;
        let left = self.cursor.remaining();
        usize::try_from(count).ok().filter(|&n| n <= left).ok_or_else(|| {
            format!("{count} entries announced, but only {left} bytes are left in the file")
        })
    }

    pub fn double(&mut self) -> Parsed<f64> {
        if self.is_binary { self.cursor.array().map(f64::from_le_bytes) } else { self.word() }
    }

    pub fn point(&mut self) -> Parsed<Vec3> {
        Ok(Vec3::new(self.double()?, self.double()?, self.double()?))
    }

    fn word<T: std::str::FromStr>(&mut self) -> Parsed<T> {
        let word = self.cursor.word().ok_or("the file is truncated where a number is due")?;
        word.parse().map_err(|_| {
            let line = self.cursor.line_number();
            format!("line {line}: found {word:?} where a number is due")
        })
    }
}

fn physical_name(line: &str) -> Option<(i32, i32, &str)> {
    let (dimension, rest) = line.split_once(' ')?;
    let (number, name) = rest.trim_start().split_once(' ')?;
    let name = name.trim().strip_prefix('"')?.strip_suffix('"')?;
    Some((dimension.parse().ok()?, number.parse().ok()?, name))
}
