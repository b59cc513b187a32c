//! Every number of the samples of `refused.rs`, replaced by one at the limits: a program ends with a result or a message,
//! without a panic and before long.

use std::fs::File;
use std::process::{Command, Stdio};

use rayon::prelude::*;
use tests::workdir::program;

use crate::refused::{Section, of_file, sample};

/// Numbers where powers, differences and counts leave what can be computed.
const NUMBERS: [&str; 13] = [
    "1e155",
    "1e308",
    "-1e308",
    "5e-324",
    "-0.0",
    "0",
    "-1",
    "1e30",
    "1e-30",
    "nan",
    "-inf",
    "9223372036854775807",
    "-9223372036854775808",
];

/// Where the numbers of a text are that are no part of a word.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let is_part = |c: char| c.is_alphanumeric() || "._-+\"".contains(c);
    let mut found = Vec::new();
    let mut begin = 0;
    for (end, c) in text.char_indices().chain([(text.len(), ' ')]) {
        if !is_part(c) {
            let is_number = text[begin..end].starts_with(|c: char| c == '-' || c.is_ascii_digit());
            if is_number && text[begin..end].parse::<f64>().is_ok() {
                found.push(begin..end);
            }
            begin = end + c.len_utf8();
        }
    }
    found
}

/// Tries one in so many of all changes of a section, from the `seed`-th on; what is wrong with which.
fn failures(section: &Section, one_in: usize, seed: usize) -> Vec<String> {
    let dir = sample(section.sample);
    let sound = dir.text(section.file);
    let places = numbers(&sound);
    assert!(!places.is_empty(), "{} has no numbers", section.sample);
    let (name, arguments) = section.command.split_once(' ').unwrap();
    let mut failures = Vec::new();
    for case in (seed % one_in..places.len() * NUMBERS.len()).step_by(one_in) {
        let (place, number) = (&places[case / NUMBERS.len()], NUMBERS[case % NUMBERS.len()]);
        let mut text = sound.clone();
        text.replace_range(place.clone(), number);
        dir.write(section.file, &text);
        // what does not end when it is asked to is killed
        let mut command = Command::new("timeout");
        command.args(["-s", "INT", "-k", "10", "20"]).arg(program(name));
        command.args(arguments.split(' ')).current_dir(dir.path(""));
        let said = File::create(dir.path("said")).unwrap();
        let code = command.stdout(Stdio::null()).stderr(said).status().unwrap().code();
        let said = dir.text("said");
        let good = matches!(code, Some(0..=3 | 124)) && !said.contains("panicked");
        if !good || said.len() > 20_000 {
            failures.push(format!("{}: {number} at {place:?}: {code:?} {said}", section.sample));
        }
        let _ = std::fs::remove_dir_all(dir.path("out"));
    }
    failures
}

fn campaign(one_in: usize, seed: usize) {
    let text = of_file();
    let sections = crate::refused::sections(&text);
    let failures: Vec<String> =
        sections.par_iter().flat_map(|section| failures(section, one_in, seed)).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[test]
fn some_numbers_at_the_limits() {
    campaign(211, 1);
}

/// All of them take half an hour: `make fuzz` tries one in ten, others for every seed.
#[test]
#[ignore = "minutes: make fuzz"]
fn numbers_at_the_limits_in_every_key() {
    campaign(10, std::env::var("FUZZ_SEED").map_or(1, |seed| seed.parse().unwrap()));
}
