//! Random changes of files: of bits, of numbers and words, of lines.

use std::ops::Range;

use mechanics::math::random::Random;

/// Texts where limits lie.
const WORDS: [&str; 16] = [
    "0",
    "-1",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "1e-320",
    "1e150",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "\"\"",
    "[]",
    "{}",
    "\u{feff}",
    "[[a]]",
];

/// The longest file that is made [bytes].
const LONGEST: usize = 1 << 18;

/// A corpus file after one to six random changes.
pub fn mutate(corpus: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut pick =
        |n: usize| (((random.uniform() + 1.0) / 2.0 * n as f64) as usize).min(n.max(1) - 1);
    let mut bytes = corpus[pick(corpus.len())].clone();
    for _ in 0..=pick(6) {
        let other = &corpus[pick(corpus.len())];
        let place = pick(bytes.len() + 1);
        let some = place..(place + pick(40)).min(bytes.len());
        match pick(8) {
            0 if place < bytes.len() => bytes[place] ^= 1 << pick(8),
            1 => bytes.truncate(place),
            2 => drop(bytes.drain(some)),
            3 => {
                let number = [0, 0xffff, 0xffff_ffff, u64::MAX >> 1, u64::MAX][pick(5)];
                bytes.splice(some, number.to_le_bytes());
            }
            4 => {
                let line = around(&bytes, place, |b| b != b'\n');
                let copies = bytes[line.clone()].repeat([0, 2, 100][pick(3)]);
                bytes.splice(line, copies);
            }
            _ => {
                let new = match pick(2) {
                    0 => WORDS[pick(WORDS.len())].as_bytes().to_vec(),
                    _ => other[word(other, pick(other.len() + 1))].to_vec(),
                };
                bytes.splice(word(&bytes, place), new);
            }
        }
        bytes.truncate(LONGEST);
    }
    bytes
}

/// The word around a place: letters, digits and what is within numbers.
fn word(bytes: &[u8], place: usize) -> Range<usize> {
    around(bytes, place, |b| b.is_ascii_alphanumeric() || b"._-+".contains(&b))
}

fn around(bytes: &[u8], place: usize, inside: impl Fn(u8) -> bool) -> Range<usize> {
    let begin = bytes[..place].iter().rposition(|&b| !inside(b)).map_or(0, |n| n + 1);
    let end = bytes[place..].iter().position(|&b| !inside(b)).map_or(bytes.len(), |n| place + n);
    begin..end
}
