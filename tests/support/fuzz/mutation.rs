//! Random changes of files: of bytes, of numbers and words, of lines.

use mechanics::math::random::Random;

/// Texts where limits lie.
const WORDS: [&str; 22] = [
    "0",
    "-1",
    "1",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "1e-320",
    "1e150",
    "0.1",
    "4294967296",
    "2147483648",
    "9223372036854775807",
    "18446744073709551615",
    "99999999999999999999999",
    "1000000",
    "\"\"",
    "[]",
    "{}",
    "true",
    "\u{feff}",
    "[[a]]",
];

/// Numbers where limits lie, as bytes in a file.
const NUMBERS: [u64; 8] = [0, 1, 0xff, 0xffff, 0x7fff_ffff, 0xffff_ffff, u64::MAX >> 1, u64::MAX];

/// The longest file that is made [bytes].
const LONGEST: usize = 1 << 18;

/// A corpus file after one to six random changes.
pub fn mutate(corpus: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut pick =
        |n: usize| (((random.uniform() + 1.0) / 2.0 * n as f64) as usize).min(n.max(1) - 1);
    let mut bytes = corpus[pick(corpus.len())].clone();
    for _ in 0..=pick(6) {
        let other = &corpus[pick(corpus.len())];
        match pick(10) {
            0 => flip(&mut bytes, &mut pick),
            1 => overwrite(&mut bytes, &mut pick),
            2 => bytes.truncate(pick(bytes.len() + 1)),
            3 => drop(bytes.drain(range(bytes.len(), &mut pick))),
            4 => insert(&mut bytes, other, &mut pick),
            5..=7 => replace_word(&mut bytes, other, &mut pick),
            8 => repeat_line(&mut bytes, &mut pick),
            _ => remove_line(&mut bytes, &mut pick),
        }
        bytes.truncate(LONGEST);
    }
    bytes
}

fn range(len: usize, pick: &mut impl FnMut(usize) -> usize) -> std::ops::Range<usize> {
    let begin = pick(len + 1);
    begin..(begin + pick(40)).min(len)
}

fn flip(bytes: &mut [u8], pick: &mut impl FnMut(usize) -> usize) {
    if !bytes.is_empty() {
        let at = pick(bytes.len());
        bytes[at] ^= 1 << pick(8);
    }
}

fn overwrite(bytes: &mut [u8], pick: &mut impl FnMut(usize) -> usize) {
    let (number, size) = (NUMBERS[pick(NUMBERS.len())], [1, 2, 4, 8][pick(4)]);
    if bytes.len() >= size {
        let at = pick(bytes.len() - size + 1);
        bytes[at..at + size].copy_from_slice(&number.to_le_bytes()[..size]);
    }
}

fn insert(bytes: &mut Vec<u8>, other: &[u8], pick: &mut impl FnMut(usize) -> usize) {
    let (at, from) = (pick(bytes.len() + 1), range(other.len(), pick));
    bytes.splice(at..at, other[from].iter().copied());
}

/// Puts another word, of the list or of another file, in the place of one.
fn replace_word(bytes: &mut Vec<u8>, other: &[u8], pick: &mut impl FnMut(usize) -> usize) {
    let old = word_at(bytes, pick);
    let new = if pick(2) == 0 {
        WORDS[pick(WORDS.len())].as_bytes().to_vec()
    } else {
        other[word_at(other, pick)].to_vec()
    };
    bytes.splice(old, new);
}

/// A word: letters, digits and what is within numbers.
fn word_at(bytes: &[u8], pick: &mut impl FnMut(usize) -> usize) -> std::ops::Range<usize> {
    let inside = |b: &u8| b.is_ascii_alphanumeric() || b"._-+".contains(b);
    let at = pick(bytes.len() + 1);
    let begin = bytes[at..].iter().position(inside).map_or(bytes.len(), |n| at + n);
    let length = bytes[begin..].iter().take_while(|b| inside(b)).count();
    begin..begin + length
}

fn line_at(bytes: &[u8], pick: &mut impl FnMut(usize) -> usize) -> std::ops::Range<usize> {
    let at = pick(bytes.len() + 1);
    let begin = bytes[..at].iter().rposition(|&b| b == b'\n').map_or(0, |n| n + 1);
    let end = bytes[at..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |n| at + n + 1);
    begin..end
}

fn repeat_line(bytes: &mut Vec<u8>, pick: &mut impl FnMut(usize) -> usize) {
    let line = line_at(bytes, pick);
    let copies = bytes[line.clone()].repeat([1, 2, 100][pick(3)]);
    bytes.splice(line.end..line.end, copies);
}

fn remove_line(bytes: &mut Vec<u8>, pick: &mut impl FnMut(usize) -> usize) {
    let line = line_at(bytes, pick);
    bytes.drain(line);
}
