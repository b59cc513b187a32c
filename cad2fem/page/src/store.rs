//! Arrays of numbers, compressed as the page holds them.
//!
//! A blob is zlib in base64, in an element of its own; the data of the page refer to it by
//! its number, with what is needed to read it: type, components per entry, and for quantised
//! numbers `low` and `step` of each component, value = low + step × integer. Arrays that are the same, such as a
//! field that does not change from state to state, share a blob.

use std::collections::HashMap;
use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use program::sha256;
use serde_json::{Value, json};

/// Largest quantised integer; the one above stands for what is not a number.
const LEVELS: f64 = 65_534.0;
/// What is not a number.
const MISSING: u16 = u16::MAX;

/// The blobs of a page.
#[derive(Debug, Default)]
pub struct Store {
    /// Base64 of each.
    pub blobs: Vec<String>,
    /// Blobs by the hash of what they hold and of how it is read.
    known: HashMap<String, usize>,
}

impl Store {
    /// What the page knows of an array: `how` it is read, and its blob.
    fn add(&mut self, bytes: &[u8], mut how: Value) -> Value {
        let key = sha256(&[how.to_string().as_bytes(), bytes].concat());
        let known = self.known.get(&key).copied();
        let blob = known.unwrap_or_else(|| self.add_blob(bytes));
        self.known.insert(key, blob);
        how["blob"] = blob.into();
        how
    }

    fn add_blob(&mut self, bytes: &[u8]) -> usize {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
        let packed = encoder.write_all(bytes).and_then(|()| encoder.finish());
        // a vector takes all that is written to it
        self.blobs.push(STANDARD.encode(packed.unwrap_or_default()));
        self.blobs.len() - 1
    }

    /// Indices, `components` per entry, in as few bytes as they need.
    #[must_use = "the page finds the blob by what is returned"]
    pub fn indices(&mut self, values: &[usize], components: usize) -> Value {
        let largest = values.iter().copied().max().unwrap_or(0);
        let (kind, bytes): (&str, Vec<u8>) = if largest <= usize::from(u8::MAX) {
            ("u8", values.iter().map(|&v| v as u8).collect())
        } else if largest <= usize::from(u16::MAX) {
            ("u16", values.iter().flat_map(|&v| (v as u16).to_le_bytes()).collect())
        } else {
            ("u32", values.iter().flat_map(|&v| (v as u32).to_le_bytes()).collect())
        };
        self.add(&bytes, json!({ "type": kind, "components": components }))
    }

    /// Numbers, `components` per entry, each component in 16 bits of its own range: the error
    /// is at most its range / 131 068. What is not finite becomes a NaN.
    #[must_use = "the page finds the blob by what is returned"]
    pub fn numbers(&mut self, values: &[f64], components: usize) -> Value {
        let range = |c: usize| {
            let finite = values.iter().skip(c).step_by(components).filter(|v| v.is_finite());
            finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)))
        };
        let ranges: Vec<(f64, f64)> = (0..components).map(range).collect();
        let low: Vec<f64> = ranges.iter().map(|r| if r.0 <= r.1 { r.0 } else { 0.0 }).collect();
        let step: Vec<f64> = ranges.iter().map(|r| ((r.1 - r.0) / LEVELS).max(0.0)).collect();
        let integer = |(i, &v): (usize, &f64)| {
            let c = i % components;
            match (v.is_finite(), step[c] > 0.0) {
                (false, _) => MISSING,
                (true, false) => 0,
                (true, true) => ((v - low[c]) / step[c]).round() as u16,
            }
        };
        let bytes: Vec<u8> =
            values.iter().enumerate().map(integer).flat_map(u16::to_le_bytes).collect();
        let how = json!({ "type": "u16", "components": components, "low": low, "step": step });
        self.add(&bytes, how)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::io::Read as _;

    use super::*;

    /// The integers of a blob of 16-bit numbers.
    fn integers(store: &Store, packed: &Value) -> Vec<u16> {
        let blob = &store.blobs[packed["blob"].as_u64().unwrap() as usize];
        let mut bytes = Vec::new();
        let zlib = STANDARD.decode(blob).unwrap();
        flate2::read::ZlibDecoder::new(&zlib[..]).read_to_end(&mut bytes).unwrap();
        bytes.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect()
    }

    #[test]
    fn numbers_come_back_within_half_a_step() {
        let mut store = Store::default();
        let values = [0.1, -3.0, 0.25, 1e3, 0.2, f64::NAN, 0.15, 2.0];
        let packed = store.numbers(&values, 2);
        for (i, (found, v)) in integers(&store, &packed).iter().zip(values).enumerate() {
            let at = |key: &str| packed[key][i % 2].as_f64().unwrap();
            if v.is_nan() {
                assert_eq!(*found, MISSING);
                continue;
            }
            let value = at("low") + at("step") * f64::from(*found);
            assert!((value - v).abs() <= 0.500_001 * at("step"), "{v} became {value}");
        }
    }

    #[test]
    fn numbers_that_are_all_the_same_or_missing_have_no_range() {
        let mut store = Store::default();
        let same = store.numbers(&[2.5, 2.5], 1);
        assert_eq!((&same["low"][0], &same["step"][0]), (&json!(2.5), &json!(0.0)));
        assert_eq!(integers(&store, &same), [0, 0]);
        let missing = store.numbers(&[f64::NAN], 1);
        assert_eq!(integers(&store, &missing), [MISSING]);
        assert_eq!(missing["low"][0], json!(0.0));
    }

    #[test]
    fn what_is_the_same_is_there_once() {
        let mut store = Store::default();
        let first = store.numbers(&[0.0, 1.0], 1);
        assert_eq!(store.numbers(&[0.0, 1.0], 1), first);
        // the same integers, which stand for others
        assert_ne!(store.numbers(&[0.0, 2.0], 1)["blob"], first["blob"]);
        assert_ne!(store.numbers(&[0.0, 1.0], 2)["blob"], first["blob"]);
        assert_eq!(store.blobs.len(), 3);
    }

    #[test]
    fn indices_take_as_few_bytes_as_they_need() {
        let mut store = Store::default();
        for (largest, kind) in [(255, "u8"), (256, "u16"), (65_535, "u16"), (65_536, "u32")] {
            assert_eq!(store.indices(&[0, 1, largest], 3)["type"], kind);
        }
    }
}
