//! What cannot be used is refused by the program: `refused.txt` has a line for each mistake.
//!
//! A section `## SAMPLE | FILE | COMMAND` names a folder of sound files, the one in which mistakes are made, and what
//! reads it, a program with its arguments. A line `OLD -> NEW !! WORDS & WORDS` puts the new text in place of the first old one, or at the end of the
//! file where there is no old one. The program then ends with exit code 2, says all of the words and the name of the
//! file, and leaves no results. In texts `\n` is an end of a line.

use rayon::prelude::*;
use tests::chamber;
use tests::workdir::{Workdir, repository};

use crate::samples::*;
use crate::{as_cast, calibrate, error_bars, groove, probes, scenarios, symmetry, validate};

pub struct Section<'a> {
    pub sample: &'a str,
    pub file: &'a str,
    pub command: &'a str,
    cases: Vec<&'a str>,
}

/// The text of `refused.txt`.
pub fn of_file() -> String {
    std::fs::read_to_string(repository().join("tests/fast/refused.txt")).unwrap()
}

pub fn sections(text: &str) -> Vec<Section<'_>> {
    let mut sections: Vec<Section> = Vec::new();
    for line in text.lines().filter(|line| !line.is_empty()) {
        if let Some(head) = line.strip_prefix("## ") {
            let words: Vec<&str> = head.split(" | ").collect();
            let [sample, file, command] = words[..] else { panic!("{line}") };
            sections.push(Section { sample, file, command, cases: Vec::new() });
        } else {
            sections.last_mut().expect("a section comes first").cases.push(line);
        }
    }
    sections
}

pub fn sample(name: &str) -> Workdir {
    match name {
        "chamber" => chamber::workdir(),
        "fibre" => wound(FIBRE),
        "thread" => wound(WINDING),
        "profiles" => wound(&(FIBRE_PROFILES.to_owned() + WINDING_PROFILES)),
        "directions" => covered("\n[[fibre]]\nname = \"weave\"\nk1 = 2e5\nslack = 0.1\n"),
        "sheet" => covered(SHEET),
        "fabric" => covered(FABRIC),
        "volumes" => volumes(TWO),
        "rigid" => glued(""),
        "mullins" => moved(SOFTENING, &[8e-3, 3e-3]),
        "relaxation" => creeping(2),
        "line" => twins(200e3, &supplied("on = \"left\"", "supply = 20e3", 0.0)),
        "contact" => falling(),
        "half fibre" => half(FIBRE),
        "half profiles" => half(FIBRE_PROFILES),
        "half thread" => half(WINDING),
        "plug" => plugged(),
        "probes" => probes::with_probes("p1.toml", ""),
        "error bars" => error_bars::workdir(""),
        "as cast" => as_cast::workdir(),
        "calibration" => calibrate::measured(),
        "scenarios" => scenarios::workdir(""),
        "pulse" => pulsed(),
        "alike" => alike(OWN),
        "keep" => kept(),
        "part" => symmetry::quarter(),
        "validation" => validate::workdir(),
        "mold" => groove::wound(),
        "tags" | "model" => {
            let dir = chamber::workdir();
            dir.write("tags.toml", TAGS);
            dir.write("model.toml", MODEL);
            dir
        }
        name => panic!("no sample {name:?}"),
    }
}

/// A tag of each kind.
const TAGS: &str = r#"
epsilon = 1e-4

[[tag]]
name = "a"
point = { at = [0.0, 0.02, 0.04], angle = 40 }

[[tag]]
name = "b"
plane = { point = [0, 0, 0.04], normal = [0, 0, 1] }

[[tag]]
name = "c"
box = { min = [0, 0, 0], max = [0.1, 0.1, 0.1] }
"#;

const MODEL: &str = r#"
unit = "mm"
grid = 3

[[solid]]
name = "box"
shape.box = { center = [0, 0, 8], size = [16, 16, 30], rounding = 1 }

[[cavity]]
name = "hole"
shape.sphere = { center = [0, 0, 2], radius = 5 }

[[cut]]
name = "seat"
normal = [0, 0, -1]
offset = 0

[[region]]
name = "seat"
cut = "seat"
"#;

impl Section<'_> {
    fn check(&self) {
        let dir = sample(self.sample);
        let sound = dir.text(self.file);
        for case in &self.cases {
            let (change, words) = case.split_once(" !! ").unwrap_or_else(|| panic!("{case}"));
            let (old, new) = change.split_once("->").unwrap_or_else(|| panic!("{case}"));
            let [old, new] =
                [old.trim_end(), new.trim_start()].map(|text| text.replace("\\n", "\n"));
            assert!(sound.contains(&old), "{}: {old:?} is not in {}", self.sample, self.file);
            let changed = match old.is_empty() {
                true => format!("{sound}\n{new}\n"),
                false => sound.replacen(&old, &new, 1),
            };
            dir.write(self.file, &changed);
            let had_report = dir.path("out/report.json").exists();
            let (program, arguments) =
                self.command.split_once(' ').expect("a program and arguments");
            let run = dir.run(program, arguments);
            let said = |words: &str| run.stderr.contains(&words.replace("\\n", "\n"));
            let good = run.code == Some(2)
                && words.split(" & ").all(said)
                && [self.file, "body.msh"].into_iter().any(said);
            assert!(good, "{}: {case}\n{:?} {}", self.sample, run.code, run.stderr);
            let has_report = dir.path("out/report.json").exists();
            assert_eq!(has_report, had_report, "{}: {case}", self.sample);
        }
    }
}

#[test]
fn mistakes_are_refused_with_their_place() {
    let text = of_file();
    let sections = sections(&text);
    assert!(sections.iter().map(|section| section.cases.len()).sum::<usize>() > 200);
    sections.par_iter().for_each(Section::check);
}
