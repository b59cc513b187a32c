//! The book in pipelines/book: its commands work, its tables are those of the programs, its pictures are
//! there, and it loads nothing from the network.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use tests::book::{Chapter, chapters, readmes};
use tests::skip::skip;
use tests::workdir::{Workdir, program, repository};

/// A generated part of a chapter: the command that prints it, between these.
const BEGIN: &str = "<!-- $ ";
const END: &str = "<!-- end -->";

#[test]
fn commands_that_take_seconds_work() {
    let count: usize = chapters().iter().map(|chapter| chapter.run(&["test"])).sum();
    assert!(count > 40, "{count} lines of commands");
}

/// A command that runs is half a proof: what the text says of it is checked as well.
#[test]
fn every_block_of_commands_is_checked() {
    for chapter in chapters().iter().chain(&readmes()) {
        let unchecked = chapter.unchecked();
        assert!(
            unchecked.is_empty(),
            "{}: below {unchecked:?} there is no <!-- check: COMMAND -->",
            chapter.path.display()
        );
    }
}

/// The chapter with what the programs print today, and how many commands it has.
fn current(chapter: &Chapter, dir: &Workdir) -> (String, usize) {
    let (mut current, mut rest, mut count) = (String::new(), &chapter.text[..], 0);
    while let Some((before, after)) = rest.split_once(BEGIN) {
        let (command, after) = after.split_once(" -->\n").expect("a command ends");
        let (_, after) = after.split_once(END).expect("every table ends");
        let words: Vec<&str> = command.split(' ').collect();
        let mut run = match words[0].ends_with(".py") {
            true => Command::new("python3"),
            false => Command::new(program(words[0])),
        };
        if words[0].ends_with(".py") {
            run.arg(repository().join(words[0]));
        }
        let run = run.args(&words[1..]).current_dir(dir.path("")).output().unwrap();
        assert!(run.status.success(), "{command}: {run:?}");
        let printed = String::from_utf8(run.stdout).unwrap();
        current += &format!("{before}{BEGIN}{command} -->\n\n{printed}{END}");
        (rest, count) = (after, count + 1);
    }
    (current + rest, count)
}

#[test]
fn tables_are_those_of_the_programs() {
    let (dir, mut tables, mut old) = (Workdir::new(), 0, Vec::new());
    for chapter in chapters() {
        let (text, count) = current(&chapter, &dir);
        tables += count;
        if text != chapter.text {
            let fresh = repository().join("build/fresh").join(chapter.path.file_name().unwrap());
            fs::create_dir_all(fresh.parent().unwrap()).unwrap();
            fs::write(&fresh, text).unwrap();
            old.push(format!("cp {} {}", fresh.display(), chapter.path.display()));
        }
    }
    assert!(old.is_empty(), "tables that are not current; put in their place:\n{}", old.join("\n"));
    assert_eq!(tables, 15, "each file that people write, each report, and the Python package");
}

#[test]
fn chapters_pictures_and_links_are_there() {
    let chapters = chapters();
    let summary = chapters.iter().find(|c| c.path.ends_with("SUMMARY.md")).unwrap();
    let listed: BTreeSet<&str> = targets(&summary.text).into_iter().collect();
    for chapter in &chapters {
        let name = chapter.path.file_name().unwrap().to_str().unwrap();
        // the paper is for a journal, which has its own form
        let apart = ["SUMMARY.md", "paper.md"].contains(&name);
        assert!(apart || listed.contains(name), "{name} is not in SUMMARY.md");
        for target in targets(&chapter.text) {
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            if target.starts_with("https:") {
                continue;
            }
            if !anchor.is_empty() {
                let linked = chapters.iter().find(|c| !file.is_empty() && c.path.ends_with(file));
                let anchors = linked.unwrap_or(chapter).anchors();
                assert!(anchors.contains(anchor), "{name}: there is no {target}, but {anchors:?}");
            }
            if file.is_empty() {
                continue;
            }
            let there = chapter.path.parent().unwrap().join(file);
            assert!(there.is_file(), "{name}: there is no {target}");
            // make book takes pictures of pipelines along, and nothing else
            let picture = [".png", ".svg"].iter().any(|end| file.ends_with(end));
            assert!(!file.contains("..") || picture, "{name}: {target} is not in the book");
        }
    }
}

/// READMEs of the checkout, and what stands beside them, point to files and headings that are there.
#[test]
fn links_of_readmes_are_there() {
    let root = repository();
    let others = [
        "ARCHITECTURE.md",
        "CONTRIBUTING.md",
        "SECURITY.md",
        "solver/python.md",
        "tests/README.md",
        "pipelines/README.md",
    ];
    let read = |path: PathBuf| Chapter { text: fs::read_to_string(&path).unwrap(), path };
    let others = others.map(|name| read(root.join(name)));
    for page in readmes().iter().chain(&others) {
        for target in targets(&page.text) {
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            if target.starts_with("https:") || file.is_empty() {
                continue;
            }
            let linked = page.path.parent().unwrap().join(file);
            assert!(linked.exists(), "{}: there is no {target}", page.path.display());
            if !anchor.is_empty() {
                let anchors = read(linked).anchors();
                assert!(anchors.contains(anchor), "{}: there is no {target}", page.path.display());
            }
        }
    }
}

/// What links and pictures point to.
fn targets(text: &str) -> Vec<&str> {
    text.split("](").skip(1).filter_map(|after| after.split(')').next()).collect()
}

/// `<!-- from PAGE: TEXT | TEXT -->` in the paper says where its numbers are from; what it cites is in `paper.bib`.
#[test]
fn numbers_of_the_paper_are_those_of_the_book() {
    let book = repository().join("pipelines/book");
    let read = |name: &str| fs::read_to_string(book.join(name)).unwrap();
    let (paper, sources, mut count) = (read("paper.md"), read("paper.bib"), 0);
    for from in paper.split("<!-- from ").skip(1) {
        let (page, texts) = from.split_once(" -->").unwrap().0.split_once(": ").unwrap();
        let text = read(page).replace('\n', " ");
        for words in texts.split(" | ") {
            assert!(text.contains(words), "{page} does not say {words}");
            count += 1;
        }
    }
    assert!(count > 20, "{count} numbers");
    let cited = paper.split(&['[', ' ', '\n']).filter_map(|word| word.strip_prefix('@'));
    for word in cited {
        let key = word.trim_end_matches(|c: char| !c.is_alphanumeric());
        assert!(sources.contains(&format!("{{{key},")), "{key} is not in paper.bib");
    }
    let prose = paper.splitn(3, "---\n").nth(2).unwrap();
    let words = prose.split_whitespace().count();
    assert!((750..=1750).contains(&words), "{words} words");
}

#[test]
fn the_linter_of_prose_finds_what_readers_read_twice() {
    let python = repository().join(".cargo-tools/prose/bin/python");
    if !python.is_file() {
        return skip("proselint (make lint installs it)");
    }
    let dir = Workdir::new();
    let text = "# Page\n\nAll derivatives know it, but\nfor one. Those of the rest were tried in vain.\n\n\
                - VALUE is TOML; what is none is a text. `in vain` is code.\n";
    fs::write(dir.path("page.md"), text).unwrap();
    let script = repository().join(".ci/prose.py");
    let run = Command::new(python).arg("-B").arg(script).arg(dir.path("page.md")).output().unwrap();
    let printed = String::from_utf8_lossy(&run.stdout);
    assert_eq!(run.status.code(), Some(1), "{run:?}");
    for found in [
        "3:5: 'derivatives know'",
        "3:26: 'but for'",
        "'. Those of'",
        "'in vain'",
        "6:23: 'is none'",
    ] {
        assert!(printed.contains(found), "{found}: {printed}");
    }
    assert!(printed.ends_with("prose: 5 findings in 1 files\n"), "{printed}");
}

#[test]
fn the_book_loads_nothing_from_the_network() {
    let mdbook = repository().join(".cargo-tools/bin/mdbook");
    if !mdbook.is_file() {
        return skip("mdbook (make book installs it)");
    }
    let dir = Workdir::new();
    let run = Command::new(mdbook)
        .arg("build")
        .arg(repository().join("pipelines/book"))
        .arg("--dest-dir")
        .arg(dir.path("html"))
        .output()
        .unwrap();
    assert!(run.status.success(), "{run:?}");
    for entry in fs::read_dir(dir.path("html")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "html") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        // a link to a page is followed by the reader; all else is loaded
        for address in
            ["src=\"http", "src=\"//", "<link rel=\"stylesheet\" href=\"http", "url(http"]
        {
            assert!(!text.contains(address), "{}: {address}", path.display());
        }
    }
    assert!(dir.path("html/index.html").is_file());
}
