//! How many lines of Rust each folder may have, so that what is added is weighed against what could go.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use tests::workdir::repository;

use crate::tidy::{before_tests, files};

/// A folder, and how many lines of code and how many of tests it may have, all lines counted, those of comments, too.
///
/// Tests are modules behind `#[cfg(test)]`, in their file or in one of their own, and what lies in a folder `tests`.
const BUDGETS: &[(&str, usize, usize)] = &[
    ("cad2fem", 26_950, 7_450),
    ("fab", 12_700, 3_200),
    ("solver", 68_650, 11_350),
    ("tagger", 1_650, 460),
    ("tests/benches", 0, 700),
    ("tests/convergence", 0, 3_100),
    ("tests/design", 0, 950),
    ("tests/fast", 0, 10_310),
    ("tests/fuzz", 0, 320),
    ("tests/slow", 0, 1_100),
    ("tests/support", 0, 2_060),
];

/// Files of modules behind `#[cfg(test)]`, without extension; those below are tests, too.
fn test_modules(files: &[PathBuf]) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    for path in files {
        let text = fs::read_to_string(path).unwrap();
        let stem = path.file_stem().unwrap();
        let is_root = ["mod", "lib", "main"].iter().any(|name| stem == *name);
        let folder = if is_root { path.parent().unwrap().into() } else { path.with_extension("") };
        for after in text.split("#[cfg(test)]\n").skip(1) {
            let line = after.lines().next().unwrap_or_default().trim();
            let name = line.strip_prefix("pub ").unwrap_or(line).strip_prefix("mod ");
            if let Some(name) = name.and_then(|name| name.strip_suffix(';')) {
                found.insert(folder.join(name));
            }
        }
    }
    found
}

/// Lines of code and lines of tests below a folder.
fn lines(folder: &str) -> [usize; 2] {
    let files = files(&repository().join(folder), "rs");
    let modules = test_modules(&files);
    let mut found = [0, 0];
    for path in &files {
        let text = fs::read_to_string(path).unwrap();
        let (before, _) = before_tests(&text);
        let all = text.lines().count();
        let code = if is_test(path, &modules) { 0 } else { before.lines().count() };
        found = [found[0] + code, found[1] + all - code];
    }
    found
}

fn is_test(path: &Path, modules: &BTreeSet<PathBuf>) -> bool {
    let stem = path.file_stem().unwrap().to_string_lossy();
    let relative = path.strip_prefix(repository()).unwrap();
    relative.components().any(|part| part.as_os_str() == "tests")
        || stem.ends_with("_tests")
        || path.with_extension("").ancestors().any(|above| modules.contains(above))
}

/// 12 345 for 12345.
fn thousands(count: usize) -> String {
    match count / 1000 {
        0 => count.to_string(),
        many => format!("{many} {:03}", count % 1000),
    }
}

#[test]
fn folders_keep_to_their_budgets() {
    let mut over = Vec::new();
    for &(folder, code, tests) in BUDGETS {
        for (of, found, budget) in
            [("", lines(folder)[0], code), (" of tests", lines(folder)[1], tests)]
        {
            eprintln!("{folder}: {} lines{of} of {}", thousands(found), thousands(budget));
            if found > budget {
                over.push(format!(
                    "{folder} has {} lines{of}, its budget is {}: take something away, or raise it in the same \
                     commit with the reason",
                    thousands(found),
                    thousands(budget)
                ));
            }
        }
    }
    assert!(over.is_empty(), "{}", over.join("\n"));
}

#[test]
fn every_folder_has_a_budget() {
    let all = files(&repository(), "rs");
    let has_one = |path: &&PathBuf| {
        let relative = path.strip_prefix(repository()).unwrap();
        BUDGETS.iter().any(|(folder, ..)| relative.starts_with(folder))
    };
    // the roots of the tests' programs lie beside their folders
    let roots = repository().join("tests");
    let open: Vec<&PathBuf> = all.iter().filter(|path| !has_one(path)).collect();
    assert!(open.iter().all(|path| path.parent() == Some(&roots)), "{open:?}");
}
