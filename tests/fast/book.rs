//! The book in pipelines/book: its commands work, the chapters that programs print can be made, its pictures and
//! links are there, and it loads nothing from the network.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use tests::book::{Chapter, chapters, printed, readmes};
use tests::skip::skip;
use tests::workdir::{Workdir, repository};

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

#[test]
fn chapters_pictures_and_links_are_there() {
    let (dir, mut book) = (Workdir::new(), chapters());
    let summary = book.iter().find(|c| c.path.ends_with("SUMMARY.md")).unwrap().text.clone();
    let listed: BTreeSet<&str> = targets(&summary).into_iter().collect();
    let printed = printed(&dir.path(""));
    let keys = |name: &&&str| name.starts_with("keys-");
    assert_eq!(printed.len(), listed.iter().filter(keys).count() + 1, "and the Python package");
    book.extend(printed);
    for chapter in &book {
        let name = chapter.path.file_name().unwrap().to_str().unwrap();
        assert!(name == "SUMMARY.md" || listed.contains(name), "{name} is not in SUMMARY.md");
        for target in targets(&chapter.text) {
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            if target.starts_with("https:") {
                continue;
            }
            let linked = match file.is_empty() {
                true => Some(chapter),
                false => book.iter().find(|c| c.path.ends_with(file)),
            };
            if !anchor.is_empty() {
                let anchors = linked.unwrap_or_else(|| panic!("{name}: {target}")).anchors();
                assert!(anchors.contains(anchor), "{name}: there is no {target}, but {anchors:?}");
            }
            let there = || chapter.path.parent().unwrap().join(file).is_file();
            assert!(linked.is_some() || there(), "{name}: there is no {target}");
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
    let root = repository();
    let read = |name: &str| fs::read_to_string(root.join(name)).unwrap();
    let (paper, sources, mut count) =
        (read("pipelines/paper/paper.md"), read("pipelines/paper/paper.bib"), 0);
    for from in paper.split("<!-- from ").skip(1) {
        let (page, texts) = from.split_once(" -->").unwrap().0.split_once(": ").unwrap();
        let text = read(&format!("pipelines/book/{page}")).replace('\n', " ");
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

/// The sentences of the programs are held to what those of the book are.
#[test]
fn the_linter_of_prose_finds_nothing_in_what_programs_print() {
    let python = repository().join(".cargo-tools/prose/bin/python");
    if !python.is_file() {
        return skip("proselint (make lint installs it)");
    }
    let dir = Workdir::new();
    let files = printed(&dir.path("")).len();
    let pages = dir.files("").into_iter().map(|name| dir.path(&name));
    let script = repository().join(".ci/prose.py");
    let run = Command::new(python).arg("-B").arg(script).args(pages).output().unwrap();
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success() && said.ends_with(&format!("in {files} files\n")), "{said}");
}

#[test]
fn the_book_loads_nothing_from_the_network() {
    let mdbook = repository().join(".cargo-tools/bin/mdbook");
    if !mdbook.is_file() {
        return skip("mdbook (make book installs it)");
    }
    let dir = Workdir::new();
    let source = dir.path("book");
    fs::create_dir(&source).unwrap();
    printed(&source);
    for entry in fs::read_dir(repository().join("pipelines/book")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            fs::copy(&path, source.join(path.file_name().unwrap())).unwrap();
        }
    }
    let run = Command::new(mdbook)
        .arg("build")
        .arg(source)
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
