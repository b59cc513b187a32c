//! The book in `pipelines/book`: its chapters, and the commands in them.
//!
//! A block of commands is marked after its fence: ```` ```sh test ```` runs in `make test`, ```` ```sh slow ````
//! in `make test-all`, and ```` ```sh ```` nowhere, as it needs what only a reader has. Those of a chapter run
//! one after the other in one folder, in which `pipelines` is, as in the checkout. Below every block that runs stand
//! comments, `<!-- check: COMMAND -->`: commands that fail if what the chapter says of the block is not true.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::workdir::{Workdir, program, repository};

/// A chapter.
pub struct Chapter {
    /// The file of the chapter.
    pub path: PathBuf,
    /// Its Markdown.
    pub text: String,
}

/// All chapters that people write, by their names.
pub fn chapters() -> Vec<Chapter> {
    let mut chapters = pages(&repository().join("pipelines/book"));
    // `make book` leaves those that programs print beside them
    chapters.retain(|chapter| {
        let name = chapter.path.file_name().expect("a file").to_string_lossy();
        !name.starts_with("keys-") && name != "python-api.md"
    });
    chapters
}

/// All chapters that programs print, made in the folder, as if they stood in the book.
pub fn printed(folder: &Path) -> Vec<Chapter> {
    let (book, programs) = (repository().join("pipelines/book"), program("solver"));
    let made = Command::new("python3")
        .arg("-B")
        .arg(book.join("generate.py"))
        .args([programs.parent().expect("a folder"), folder])
        .output()
        .expect("python3");
    assert!(made.status.success(), "{made:?}");
    let beside =
        |page: Chapter| Chapter { path: book.join(page.path.file_name().expect("a file")), ..page };
    pages(folder).into_iter().map(beside).collect()
}

/// The Markdown in a folder, by its names.
fn pages(folder: &Path) -> Vec<Chapter> {
    let entries = fs::read_dir(folder).expect("a folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let mut paths: Vec<PathBuf> =
        paths.filter(|p| p.extension().is_some_and(|e| e == "md")).collect();
    paths.sort();
    let chapter = |path: PathBuf| {
        let text = fs::read_to_string(&path).expect("a chapter");
        Chapter { path, text }
    };
    paths.into_iter().map(chapter).collect()
}

/// The READMEs of the project and of its programs, whose commands are marked as those of chapters.
pub fn readmes() -> Vec<Chapter> {
    let read = |folder: &str| {
        let path = repository().join(folder).join("README.md");
        let text = fs::read_to_string(&path).expect("a README");
        Chapter { path, text }
    };
    ["", "cad2fem", "tagger", "solver", "fab"].map(read).into()
}

/// The command of a check, if the line is one.
fn check(line: &str) -> Option<&str> {
    line.strip_prefix("<!-- check: ")?.strip_suffix(" -->")
}

impl Chapter {
    /// The commands in blocks with one of these marks and their checks, one block after the other.
    pub fn commands(&self, marks: &[&str]) -> String {
        let mut commands = String::new();
        let (mut inside, mut wanted) = (false, false);
        for line in self.text.lines() {
            match line.strip_prefix("```") {
                Some(_) if inside => inside = false,
                Some(info) => {
                    inside = true;
                    wanted = marks.iter().any(|mark| info == format!("sh {mark}"));
                }
                None if inside && wanted => commands += &format!("{line}\n"),
                // bash does not end where the first part of `a && b` fails
                None if wanted => commands.extend(check(line).map(|check| {
                    format!("{{ {check}; }} || {{ echo 'the check above failed' >&2; exit 1; }}\n")
                })),
                None => {}
            }
        }
        commands
    }

    /// First lines of the blocks that tests run without a check below them.
    pub fn unchecked(&self) -> Vec<&str> {
        let (mut found, mut first, mut inside) = (Vec::new(), None, false);
        let mut lines = self.text.lines().peekable();
        while let Some(line) = lines.next() {
            let Some(info) = line.strip_prefix("```") else { continue };
            inside = !inside;
            if inside {
                let runs = ["sh test", "sh slow"].contains(&info);
                first = lines.peek().copied().filter(|_| runs);
            } else if lines.peek().and_then(|next| check(next)).is_none() {
                found.extend(first);
            }
        }
        found
    }

    /// What links to its headings end with, as GitHub and mdBook make it.
    pub fn anchors(&self) -> BTreeSet<String> {
        let (mut anchors, mut inside) = (BTreeSet::new(), false);
        for line in self.text.lines() {
            inside ^= line.starts_with("```");
            let heading = line.trim_start_matches('#');
            if !inside && heading.len() < line.len() && heading.starts_with(' ') {
                let kept = |c: &char| c.is_alphanumeric() || "-_ ".contains(*c);
                let words: String = heading.trim().chars().filter(kept).collect();
                anchors.insert(words.to_lowercase().replace(' ', "-"));
            }
        }
        anchors
    }

    /// Runs its commands with these marks, if there are any; `make` is that of the checkout.
    pub fn run(&self, marks: &[&str]) -> usize {
        let commands = self.commands(marks);
        if commands.is_empty() {
            return 0;
        }
        let dir = Workdir::new();
        let (root, programs) = (repository(), program("solver"));
        link(&root.join("pipelines"), &dir.path("pipelines"));
        if marks.contains(&"slow") {
            fs::create_dir_all(root.join("build")).expect("build");
            link(&root.join("build"), &dir.path("build"));
        }
        let script = format!(
            "set -euxo pipefail\n\
             make() {{ command make -C {} \"${{@/#DIR=/DIR=$PWD/}}\"; }}\n{commands}",
            root.display()
        );
        let path = std::env::var("PATH").unwrap_or_default();
        let run = Command::new("bash")
            .args(["-c", &script])
            // a make that runs these tests must not hand its own flags down
            .env_remove("MAKEFLAGS")
            .env_remove("MAKELEVEL")
            .env_remove("MAKEOVERRIDES")
            .env("PATH", format!("{}:{path}", programs.parent().expect("a folder").display()))
            .current_dir(dir.path(""))
            .output()
            .expect("bash");
        assert!(
            run.status.success(),
            "{}: {}\n{}",
            self.path.display(),
            run.status,
            String::from_utf8_lossy(&run.stderr)
        );
        commands.lines().count()
    }
}

fn link(from: &Path, to: &Path) {
    std::os::unix::fs::symlink(from, to).expect("a link");
}
