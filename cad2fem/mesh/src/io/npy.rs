//! NumPy arrays of 64-bit floats in C order (`.npy` format 1.0).
//!
//! No crate does this as needed: npyz 0.9.1 writes another header (`(2, 3, )`), so that
//! hashes of results would change, accepts a shape whose product overflows, and, as
//! ndarray-npy 0.10, allocates whatever header length a damaged file claims (up to 4 GB).

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::bytes::Cursor;
use super::{IoError, Parsed, open_input, read_bytes, write_atomic};

const MAGIC: &[u8] = b"\x93NUMPY";
/// More bytes than the headers of the arrays that are read by rows have.
const LONGEST_HEADER: u64 = 1 << 16;

/// Writes `values` as an array of `shape`, the last axis running fastest.
pub fn write_f64(path: &Path, values: &[f64], shape: &[usize]) -> Result<(), IoError> {
    let size: usize = shape.iter().product();
    if size != values.len() {
        let n = values.len();
        let message = format!("not written: shape {shape:?} holds {size} values, there are {n}");
        return Err(IoError::content(path, message));
    }
    write_atomic(path, |out| {
        write_header(out, shape)?;
        write_values(out, values)
    })
}

/// Writes an array of two axes row by row, so that it never is in memory as a whole.
pub fn write_rows<R: AsRef<[f64]>>(
    path: &Path,
    shape: [usize; 2],
    rows: impl Iterator<Item = R>,
) -> Result<(), IoError> {
    let wrong = || std::io::Error::other(format!("the rows do not fill the shape {shape:?}"));
    write_atomic(path, |out| {
        write_header(out, &shape)?;
        let mut count = 0;
        for row in rows {
            if row.as_ref().len() != shape[1] {
                return Err(wrong());
            }
            write_values(out, row.as_ref())?;
            count += 1;
        }
        if count == shape[0] { Ok(()) } else { Err(wrong()) }
    })
}

fn write_values(out: &mut dyn Write, values: &[f64]) -> std::io::Result<()> {
    values.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
}

fn write_header(out: &mut dyn Write, shape: &[usize]) -> std::io::Result<()> {
    let axes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let axes = if shape.len() == 1 { axes.trim_end() } else { axes.trim_end_matches(", ") };
    let dict = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({axes}), }}");
    // Magic, version, length, dict and the final line end fill a multiple of 64.
    let length = (MAGIC.len() + 4 + dict.len() + 1).next_multiple_of(64) - MAGIC.len() - 4;
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&(length as u16).to_le_bytes())?;
    writeln!(out, "{dict:<width$}", width = length - 1)
}

/// Reads an array: its values and shape.
pub fn read_f64(path: &Path) -> Result<(Vec<f64>, Vec<usize>), IoError> {
    let bytes = read_bytes(path)?;
    parse(&bytes).map_err(|m| IoError::content(path, m))
}

/// The rows of an array of two axes, read one after the other.
#[derive(Debug)]
pub struct Rows {
    /// Number of rows, and of values in each.
    pub shape: [usize; 2],
    left: usize,
    file: BufReader<File>,
    path: PathBuf,
}

/// Opens an array of two axes that a program of ours has written.
pub fn read_rows(path: &Path) -> Result<Rows, IoError> {
    let fail = |cause| IoError::system(path, "read", cause);
    let mut file = open_input(path)?;
    let size = file.metadata().map_err(fail)?.len();
    let mut start = Vec::new();
    (&mut file).take(LONGEST_HEADER).read_to_end(&mut start).map_err(fail)?;
    let mut cursor = Cursor::new(&start);
    let of = |message| IoError::content(path, message);
    let shape = parse_header(&mut cursor).map_err(of)?;
    let begin = start.len() - cursor.remaining();
    let Ok(shape) = <[usize; 2]>::try_from(&shape[..]) else {
        return Err(of(format!("an array of shape {shape:?}; expected two axes")));
    };
    check_size(&shape, size as usize - begin).map_err(of)?;
    file.seek(SeekFrom::Start(begin as u64)).map_err(fail)?;
    Ok(Rows { shape, left: shape[0], file: BufReader::new(file), path: path.to_owned() })
}

impl Iterator for Rows {
    type Item = Result<Vec<f64>, IoError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.left = self.left.checked_sub(1)?;
        let mut bytes = vec![0; 8 * self.shape[1]];
        let read = self.file.read_exact(&mut bytes);
        Some(read.map(|()| numbers(&bytes)).map_err(|e| IoError::system(&self.path, "read", e)))
    }
}

fn numbers(bytes: &[u8]) -> Vec<f64> {
    let numbers = bytes.chunks_exact(8);
    numbers.map(|b| f64::from_le_bytes(b.try_into().expect("8 bytes"))).collect()
}

fn check_size(shape: &[usize], bytes: usize) -> Parsed<()> {
    let size = shape.iter().try_fold(8_usize, |size, &n| size.checked_mul(n));
    if size == Some(bytes) {
        return Ok(());
    }
    Err(format!("shape {shape:?} of 8-byte numbers does not fit {bytes} bytes of data"))
}

fn parse(bytes: &[u8]) -> Parsed<(Vec<f64>, Vec<usize>)> {
    let mut cursor = Cursor::new(bytes);
    let shape = parse_header(&mut cursor)?;
    check_size(&shape, cursor.remaining())?;
    Ok((numbers(cursor.take(cursor.remaining())?), shape))
}

/// The shape; the cursor is then where the data begin.
fn parse_header(cursor: &mut Cursor) -> Parsed<Vec<usize>> {
    if cursor.take(MAGIC.len()).ok() != Some(MAGIC) {
        return Err("not a NumPy array: it does not begin with \\x93NUMPY".into());
    }
    let [major, _] = cursor.array()?;
    if major != 1 {
        return Err(format!("NumPy format {major}; 1 can be read"));
    }
    let length = u16::from_le_bytes(cursor.array()?) as usize;
    let header = String::from_utf8_lossy(cursor.take(length)?).into_owned();
    for (key, needed) in [("descr", "'<f8'"), ("fortran_order", "False")] {
        let found = value_of(&header, key);
        if !found.is_some_and(|value| value.starts_with(needed)) {
            return Err(format!("{key} must be {needed}; the header is {}", header.trim_end()));
        }
    }
    shape_of(&header).ok_or_else(|| format!("no shape in the header {header}"))
}

/// What follows `'key':` in the header.
fn value_of<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let (_, rest) = header.split_once(&format!("'{key}':"))?;
    Some(rest.trim_start())
}

fn shape_of(header: &str) -> Option<Vec<usize>> {
    let (axes, _) = value_of(header, "shape")?.strip_prefix('(')?.split_once(')')?;
    let axes = axes.split(',').map(str::trim).filter(|axis| !axis.is_empty());
    axes.map(|axis| axis.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bits(values: &[f64]) -> Vec<u64> {
        values.iter().map(|x| x.to_bits()).collect()
    }

    #[test]
    fn arrays_come_back_bit_for_bit_whole_and_by_rows() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.npy");
        let values = [0.1, -0.0, f64::MIN_POSITIVE, f64::INFINITY, 1e300, -7.0];
        for shape in [&[6][..], &[2, 3], &[1, 3, 2], &[6, 1]] {
            write_f64(&path, &values, shape).expect("writable");
            let (read, read_shape) = read_f64(&path).expect("what was written");
            assert_eq!((bits(&read), &read_shape[..]), (bits(&values), shape));
        }
        write_f64(&path, &[], &[0, 3]).expect("an empty array");
        assert_eq!(read_f64(&path).expect("an empty array"), (vec![], vec![0, 3]));
        write_f64(&path, &[5.0], &[]).expect("a number");
        assert_eq!(read_f64(&path).expect("a number"), (vec![5.0], vec![]));
        write_rows(&path, [2, 3], values.chunks(3)).expect("writable");
        let rows = read_rows(&path).expect("an array");
        assert_eq!(rows.shape, [2, 3]);
        let rows: Vec<Vec<f64>> = rows.collect::<Result<_, _>>().expect("two rows");
        assert_eq!(bits(&rows.concat()), bits(&values));
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.npy");
        assert!(write_f64(&path, &[1.0, 2.0], &[3]).is_err());
        for shape in [[3, 3], [1, 3], [2, 2]] {
            assert!(write_rows(&path, shape, [[0.0; 3]; 2].iter()).is_err());
        }
        assert!(!path.exists());
        write_f64(&path, &[1.0, 2.0], &[2]).expect("writable");
        assert!(read_rows(&path).expect_err("one axis").to_string().contains("two axes"));
        let bytes = std::fs::read(&path).expect("readable");
        // The data begin at a multiple of 64 bytes, as the format demands.
        assert_eq!(bytes.len(), 128 + 16);
        for length in 0..bytes.len() {
            assert!(parse(&bytes[..length]).is_err(), "{length}");
        }
        write_rows(&path, [1, 2], [[1.0, 2.0]].iter()).expect("writable");
        let cut = std::fs::read(&path).expect("readable");
        std::fs::write(&path, &cut[..cut.len() - 1]).expect("writable");
        assert!(read_rows(&path).expect_err("cut").to_string().contains("15 bytes"));
    }
}
