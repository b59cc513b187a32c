//! The book in `pipelines/book`: its chapters, and the commands in them.
//!
//! A block of commands is marked after its fence: ```` ```sh test ```` runs in `make test`, ```` ```sh slow ````
//! in `make test-all`, and ```` ```sh ```` nowhere, as it needs what only a reader has. Those of a chapter run
//! one after the other in one folder, in which `pipelines` is, as in the checkout. What a chapter says of a block is
//! checked by a command in a comment below it, `<!-- check: COMMAND -->`, which fails where it is not so.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::workdir::{Workdir, program, repository};

/// A chapter.
pub struct Chapter {
    /// Its file.
    pub path: PathBuf,
    /// Its Markdown.
    pub text: String,
}

/// All chapters, by their names.
///
/// # Panics
/// When one cannot be read.
#[must_use]
pub fn chapters() -> Vec<Chapter> {
    let folder = repository().join("pipelines/book");
    let entries = fs::read_dir(folder).expect("the book");
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

/// The README of the project, whose commands are marked as those of chapters.
///
/// # Panics
/// When it cannot be read.
#[must_use]
pub fn readme() -> Chapter {
    let path = repository().join("README.md");
    let text = fs::read_to_string(&path).expect("a README");
    Chapter { path, text }
}

impl Chapter {
    /// The commands in blocks with one of these marks and their checks, one block after the other.
    #[must_use]
    pub fn commands(&self, marks: &[&str]) -> String {
        let mut commands = String::new();
        let (mut inside, mut wanted) = (false, false);
        for line in self.text.lines() {
            let check =
                line.strip_prefix("<!-- check: ").and_then(|rest| rest.strip_suffix(" -->"));
            match line.strip_prefix("```") {
                Some(_) if inside => inside = false,
                Some(info) => {
                    inside = true;
                    wanted = marks.iter().any(|mark| info == format!("sh {mark}"));
                }
                None if inside && wanted => commands += &format!("{line}\n"),
                None if wanted => commands.extend(check.map(|check| format!("{check}\n"))),
                None => {}
            }
        }
        commands
    }

    /// Runs its commands with these marks, if there are any; `make` is that of the checkout.
    ///
    /// # Panics
    /// When one fails.
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
