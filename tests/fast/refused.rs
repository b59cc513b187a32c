//! What cannot be used is refused by the program: `refused.txt` has a line for each mistake.
//!
//! A section `## SAMPLE | FILE | COMMAND` names a folder of sound files, the one in which mistakes are made, and what
//! reads it, a program with its arguments. A line `OLD -> NEW !! WORDS & WORDS` puts the new text in place of the first old one, or at the end of the
//! file where there is no old one. The program then ends with exit code 2, says all of the words and the name of the
//! file, and leaves no results. In texts `\n` is an end of a line.

use rayon::prelude::*;
use tests::chamber;
use tests::workdir::{Run, Workdir, repository};

use crate::samples::*;
use crate::{
    alike, as_cast, calibrate, error_bars, groove, keep, mullins, probes, relaxation, scenarios,
    symmetry, validate,
};

struct Section<'a> {
    sample: &'a str,
    file: &'a str,
    command: &'a str,
    cases: Vec<&'a str>,
}

fn sections(text: &str) -> Vec<Section<'_>> {
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

fn sample(name: &str) -> Workdir {
    match name {
        "chamber" => chamber::workdir(),
        "fibre" => wound(FIBRE),
        "thread" => wound(WINDING),
        "profiles" => wound(&(FIBRE_PROFILES.to_owned() + WINDING_PROFILES)),
        "depth" => deep(&WINDING.replace("pitch", "depth = 5e-3\npitch")),
        "directions" => covered("\n[[fibre]]\nname = \"weave\"\nk1 = 2e5\nslack = 0.1\n"),
        "sheet" => covered(SHEET),
        "fabric" => covered(FABRIC),
        "volumes" => volumes(TWO),
        "rigid" => glued(""),
        "mullins" => mullins::moved(&mullins::table(mullins::SOFTENING), &[8e-3, 3e-3]),
        "relaxation" => relaxation::bar(&relaxation::table(relaxation::BRANCH), 2),
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
        "alike" => alike::folder(alike::OWN),
        "keep" => keep::folder("[[shape.level]]\nhandles = 3\niterations = 3\n"),
        "part" => symmetry::quarter(),
        "validation" => validate::workdir(),
        "mold" => groove::wound(),
        name => panic!("no sample {name:?}"),
    }
}

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
            let (program, arguments) =
                self.command.split_once(' ').expect("a program and arguments");
            let run = dir.run(program, arguments);
            let said = |words: &str| run.stderr.contains(&words.replace("\\n", "\n"));
            let good = run.code == Some(2) && words.split(" & ").chain([self.file]).all(said);
            assert!(good, "{}: {case}\n{:?} {}", self.sample, run.code, run.stderr);
            assert!(!dir.path("out/report.json").exists(), "{}: {case}", self.sample);
        }
    }
}

#[test]
fn mistakes_are_refused_with_their_place() {
    let text = std::fs::read_to_string(repository().join("tests/fast/refused.txt")).unwrap();
    let sections = sections(&text);
    assert!(sections.iter().map(|section| section.cases.len()).sum::<usize>() > 200);
    sections.par_iter().for_each(Section::check);
}
