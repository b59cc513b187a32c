//! NumPy arrays of 64-bit floats in C order (`.npy` format 1.0).

use std::path::Path;

use super::bytes::Cursor;
use super::{IoError, Parsed, read_bytes, write_atomic};

const MAGIC: &[u8] = b"\x93NUMPY";

/// Writes `values` as an array of `shape`, the last axis running fastest.
///
/// # Errors
/// If the product of `shape` is not the number of values, or the file cannot be
/// written.
pub fn write_f64(path: &Path, values: &[f64], shape: &[usize]) -> Result<(), IoError> {
    let size: usize = shape.iter().product();
    if size != values.len() {
        let n = values.len();
        let message = format!("not written: shape {shape:?} holds {size} values, there are {n}");
        return Err(IoError::content(path, message));
    }
    let axes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let axes = if shape.len() == 1 { axes.trim_end() } else { axes.trim_end_matches(", ") };
    let dict = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({axes}), }}");
    // Magic, version, length, dict and the final line end fill a multiple of 64.
    let length = (MAGIC.len() + 4 + dict.len() + 1).next_multiple_of(64) - MAGIC.len() - 4;
    write_atomic(path, |out| {
        out.write_all(MAGIC)?;
        out.write_all(&[1, 0])?;
        out.write_all(&(length as u16).to_le_bytes())?;
        writeln!(out, "{dict:<width$}", width = length - 1)?;
        values.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
    })
}

/// Reads an array: its values and shape.
///
/// # Errors
/// If the file cannot be read, is no array of little-endian 64-bit floats in C
/// order, or its size does not fit its shape.
pub fn read_f64(path: &Path) -> Result<(Vec<f64>, Vec<usize>), IoError> {
    let bytes = read_bytes(path)?;
    parse(&bytes).map_err(|m| IoError::content(path, m))
}

fn parse(bytes: &[u8]) -> Parsed<(Vec<f64>, Vec<usize>)> {
    let mut cursor = Cursor::new(bytes);
    if cursor.take(MAGIC.len()).ok() != Some(MAGIC) {
        return Err("not a NumPy array: it does not begin with \\x93NUMPY".into());
    }
    let length = match cursor.array()? {
        [1, _] => u16::from_le_bytes(cursor.array()?) as usize,
        [2 | 3, _] => u32::from_le_bytes(cursor.array()?) as usize,
        [major, _] => return Err(format!("NumPy format {major}; 1 to 3 can be read")),
    };
    let header = String::from_utf8_lossy(cursor.take(length)?).into_owned();
    for (key, needed) in [("descr", "'<f8'"), ("fortran_order", "False")] {
        let found = value_of(&header, key);
        if !found.is_some_and(|value| value.starts_with(needed)) {
            return Err(format!("{key} must be {needed}; the header is {}", header.trim_end()));
        }
    }
    let shape = shape_of(&header).ok_or_else(|| format!("no shape in the header {header}"))?;
    let size = shape.iter().try_fold(8_usize, |size, &n| size.checked_mul(n));
    if size != Some(cursor.remaining()) {
        let left = cursor.remaining();
        return Err(format!("shape {shape:?} of 8-byte numbers does not fit {left} bytes of data"));
    }
    let numbers = cursor.take(cursor.remaining())?.chunks_exact(8);
    let values = numbers.map(|b| f64::from_le_bytes(b.try_into().expect("8 bytes"))).collect();
    Ok((values, shape))
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

    #[test]
    fn arrays_of_any_rank_come_back_bit_for_bit() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.npy");
        let values = [0.1, -0.0, f64::MIN_POSITIVE, f64::INFINITY, 1e300, -7.0];
        for shape in [vec![6], vec![2, 3], vec![1, 3, 2], vec![6, 1]] {
            write_f64(&path, &values, &shape).expect("writable");
            let (read, read_shape) = read_f64(&path).expect("what was written");
            assert_eq!(read.map_bits(), values.to_vec().map_bits());
            assert_eq!(read_shape, shape);
        }
        write_f64(&path, &[], &[0, 3]).expect("an empty array");
        assert_eq!(read_f64(&path).expect("an empty array"), (vec![], vec![0, 3]));
        write_f64(&path, &[5.0], &[]).expect("a number");
        assert_eq!(read_f64(&path).expect("a number"), (vec![5.0], vec![]));
    }

    trait MapBits {
        fn map_bits(self) -> Vec<u64>;
    }

    impl MapBits for Vec<f64> {
        fn map_bits(self) -> Vec<u64> {
            self.into_iter().map(f64::to_bits).collect()
        }
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.npy");
        assert!(write_f64(&path, &[1.0, 2.0], &[3]).is_err());
        assert!(!path.exists());
        write_f64(&path, &[1.0, 2.0], &[2]).expect("writable");
        let bytes = std::fs::read(&path).expect("readable");
        // The data begin at a multiple of 64 bytes, as the format demands.
        assert_eq!(bytes.len(), 128 + 16);
        for length in 0..bytes.len() {
            assert!(parse(&bytes[..length]).is_err(), "{length}");
        }
        let other = String::from_utf8_lossy(&bytes[..128]).replace("<f8", "<f4");
        let message = parse(other.as_bytes()).expect_err("32 bits");
        assert!(message.contains("<f8") || message.contains("begin"), "{message}");
    }
}
