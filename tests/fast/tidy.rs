//! The invariants of the architecture that a machine can check.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use tests::workdir::{self, repository};

/// Longest source file [lines].
const LONGEST: usize = 500;

/// The packages of programs and libraries.
const PACKAGES: [&str; 21] = [
    "cad2fem",
    "cad2fem/implicit",
    "cad2fem/library",
    "cad2fem/mesh",
    "cad2fem/page",
    "cad2fem/program",
    "cad2fem/render",
    "cad2fem/reports",
    "cad2fem/system",
    "tagger",
    "solver",
    "solver/design",
    "solver/measure",
    "solver/mechanics",
    "solver/polyfem",
    "solver/python",
    "solver/run",
    "solver/scene",
    "solver/variables",
    "fab",
    "fab/geometry",
];

/// All files below a folder with an extension, built ones left out.
pub fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap().flatten() {
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            if path.is_dir() && !path.is_symlink() {
                let ours = !name.starts_with('.') && name != "target" && name != "build";
                folders.extend(ours.then_some(path));
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    assert!(!found.is_empty(), "no .{extension} in {}", folder.display());
    found
}

/// A file's text before its tests, and its tests: what follows `#[cfg(test)]`,
/// unless that names a file (`mod tests;`).
pub fn before_tests(text: &str) -> (String, &str) {
    let mut before = String::new();
    let mut rest = text;
    while let Some((code, tests)) = rest.split_once("#[cfg(test)]") {
        before += code;
        match tests.find([';', '{']) {
            Some(end) if tests[end..].starts_with(';') => rest = &tests[end + 1..],
            _ => return (before, tests),
        }
    }
    (before + rest, "")
}

/// The code of a file without comments and tests.
pub fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let without = |line: &str| line.split("//").next().unwrap_or_default().to_owned() + "\n";
    before_tests(&text).0.lines().map(without).collect()
}

/// Files that have `word` in their code, relative to the repository.
pub fn naming(word: &str, files: &[PathBuf]) -> BTreeSet<String> {
    let top = repository();
    let relative = |p: &PathBuf| p.strip_prefix(&top).unwrap().to_string_lossy().into_owned();
    files.iter().filter(|path| code(path).contains(word)).map(relative).collect()
}

/// Sources of the programs and libraries, without tests.
pub fn sources() -> Vec<PathBuf> {
    let top = repository();
    let all = PACKAGES.iter().flat_map(|package| files(&top.join(package).join("src"), "rs"));
    all.filter(|path| !is_test(path)).collect()
}

/// Whether a file holds nothing but unit tests: `tests.rs`, or one in a folder `tests`.
fn is_test(path: &Path) -> bool {
    path.ends_with("tests.rs") || path.parent().is_some_and(|folder| folder.ends_with("tests"))
}

/// Names that code uses from a module, as from `crate`: `crate::name`, `crate::{a, b::c}`.
pub fn used(code: &str, from: &str) -> Vec<String> {
    let mut found = Vec::new();
    for rest in code.split(&format!("{from}::")).skip(1) {
        let word = |s: &str| {
            s.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>()
        };
        let Some(list) = rest.strip_prefix('{') else {
            found.push(word(rest));
            continue;
        };
        let mut depth = 0;
        let mut parts = vec![String::new()];
        for c in list.chars() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => parts.push(String::new()),
                _ => parts.last_mut().expect("never empty").push(c),
            }
        }
        found.extend(parts.iter().map(|p| word(p)).filter(|w| !w.is_empty()));
    }
    found
}

#[test]
fn names_are_found_in_every_way_of_use() {
    let code = "use crate::{a, b::{c, d}};\nuse crate::e::F;\nlet x = crate::g(&crate::h::I);\npub(crate) i: J";
    assert_eq!(used(code, "crate"), ["a", "b", "e", "g", "h"]);
}

#[test]
fn modules_with_a_folder_are_in_it() {
    let top = repository();
    let all = PACKAGES.iter().flat_map(|package| files(&top.join(package).join("src"), "rs"));
    let beside = all.filter(|path| path.with_extension("").is_dir());
    assert_eq!(beside.collect::<Vec<_>>(), Vec::<PathBuf>::new(), "expected NAME/mod.rs");
}

/// What follows `#[cfg(test)]` escapes the checks here, so only tests may.
#[test]
fn tests_stand_at_the_end_of_their_files() {
    let mut wrong = Vec::new();
    for path in sources() {
        let text = fs::read_to_string(&path).unwrap();
        let (_, tests) = before_tests(&text);
        let code = ["pub ", "fn ", "use ", "impl", "struct ", "enum ", "const ", "static "];
        let escapes = |l: &&str| code.iter().any(|c| l.starts_with(c));
        wrong.extend(tests.lines().find(escapes).map(|l| format!("{}: {l}", path.display())));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn modules_use_only_those_before_them() {
    [
        "solver/mechanics",
        "solver/measure",
        "solver/scene",
        "solver/run",
        "solver/variables",
        "solver",
        "fab",
    ]
    .into_iter()
    .for_each(uses_only_those_before);
}

fn uses_only_those_before(package: &str) {
    let source = repository().join(package).join("src");
    let root = code(&source.join("lib.rs"));
    let declared: Vec<&str> =
        root.lines().filter_map(|l| l.trim().strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    // every file and folder is a module of the list, so that none escapes
    let entries = fs::read_dir(&source).unwrap().flatten().map(|entry| entry.path());
    let stem = |path: PathBuf| path.file_stem().unwrap().to_string_lossy().into_owned();
    let found: BTreeSet<String> = entries.map(stem).collect();
    let others = ["lib", "main", "testing"].map(str::to_owned).into_iter();
    let listed = declared.iter().map(|&name| name.to_owned()).chain(others);
    assert_eq!(found.difference(&listed.collect()).count(), 0, "{found:?} {declared:?}");
    // rustfmt may sort what it should not
    assert!(!declared.is_sorted());
    let mut wrong = Vec::new();
    for (level, module) in declared.iter().enumerate() {
        let folder = source.join(module);
        let paths = if folder.is_dir() {
            files(&folder, "rs")
        } else {
            vec![source.join(module).with_extension("rs")]
        };
        // unit tests in a file of their own may use what is made for tests
        for path in paths.iter().filter(|path| !is_test(path)) {
            for name in used(&code(path), "crate") {
                if !declared[..=level].contains(&name.as_str()) {
                    wrong.push(format!("{} uses {name}", path.display()));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// At any depth: of two modules beside each other at most one uses the other, also through others.
#[test]
fn no_modules_use_each_other() {
    for package in PACKAGES {
        let uses = uses_between(&repository().join(package).join("src"));
        let within = |start: &Vec<String>| {
            let (mut open, mut reached) = (vec![start], BTreeSet::new());
            while let Some(module) = open.pop() {
                for next in uses.get(module).into_iter().flatten() {
                    open.extend(reached.insert(next).then_some(next));
                }
            }
            reached.contains(start)
        };
        let circle: Vec<&Vec<String>> = uses.keys().filter(|module| within(module)).collect();
        assert!(circle.is_empty(), "{package}: {circle:?}");
    }
}

/// Which modules use which: of each pair the parts of their paths from where these part.
fn uses_between(source: &Path) -> BTreeMap<Vec<String>, BTreeSet<Vec<String>>> {
    let path_of = |file: &PathBuf| -> Vec<String> {
        let path = file.strip_prefix(source).unwrap().with_extension("");
        let mut words: Vec<String> =
            path.iter().map(|word| word.to_string_lossy().into_owned()).collect();
        if ["mod", "lib", "main"].contains(&words.last().unwrap().as_str()) {
            words.pop();
        }
        words
    };
    let all = files(source, "rs").into_iter().filter(|file| !is_test(file));
    let modules: BTreeMap<Vec<String>, PathBuf> = all.map(|file| (path_of(&file), file)).collect();
    let mut uses: BTreeMap<Vec<String>, BTreeSet<Vec<String>>> = BTreeMap::new();
    for (module, file) in &modules {
        for target in targets(&code(file), module) {
            let known = (0..=target.len()).rev().find(|&n| modules.contains_key(&target[..n]));
            let target = &target[..known.unwrap_or(0)];
            let shared = module.iter().zip(target).take_while(|(a, b)| a == b).count();
            if shared < module.len().min(target.len()) {
                let from = module[..=shared].to_vec();
                uses.entry(from).or_default().insert(target[..=shared].to_vec());
            }
        }
    }
    uses
}

/// The paths that a module's code names from its crate, from itself and from those around it.
fn targets(code: &str, module: &[String]) -> Vec<Vec<String>> {
    let around = |up: usize| module[..module.len().saturating_sub(up)].to_vec();
    let mut starts = vec![("crate".to_owned(), Vec::new()), ("self".to_owned(), around(0))];
    starts.extend((1..=4).map(|up| (["super"].repeat(up).join("::"), around(up))));
    let mut found = Vec::new();
    for (from, start) in starts {
        for (i, begin) in code.match_indices(&format!("{from}::")) {
            // the end of `super::super::` is none
            if code[..i].ends_with("::") {
                continue;
            }
            let rest = &code[i + begin.len()..];
            let own = rest.split(['{', ';', '(', ' ', ',', '<', ')']).next().unwrap_or_default();
            let words: Vec<&str> = own.split("::").filter(|word| !word.is_empty()).collect();
            let path = |more: &[&str]| {
                [&start[..], &more.iter().map(|&word| word.to_owned()).collect::<Vec<_>>()].concat()
            };
            found.push(path(&words));
            let statement = rest.split(';').next().unwrap_or_default();
            if let Some(list) = statement.strip_prefix(&format!("{own}{{")) {
                let listed = used(&format!("crate::{{{list}"), "crate");
                found.extend(listed.iter().map(|word| path(&[&words[..], &[word]].concat())));
            }
        }
    }
    found
}

/// Formats, files and messages for users are the business of what is built on it.
#[test]
fn mechanics_takes_and_gives_values() {
    let mut sources = files(&repository().join("solver/mechanics/src"), "rs");
    sources.retain(|path| !is_test(path));
    assert!(!naming("thiserror::Error", &sources).is_empty());
    for word in
        ["toml", "serde_json", "schemars", "anyhow", "Path", "log::warn", "log::info", "program::"]
    {
        let found = naming(word, &sources);
        assert!(found.is_empty(), "{word}: {found:?}");
    }
}

#[test]
fn stages_meet_only_in_files() {
    let stages = ["cad2fem", "tagger", "solver", "fab"];
    let shared = ["library", "mesh", "program", "render", "reports", "system"];
    let of_cad2fem =
        ["implicit", "library", "mesh", "page", "program", "render", "reports", "system"];
    let of_solver = ["design", "measure", "mechanics", "polyfem", "run", "scene", "variables"];
    let of_fab = [&shared[..], &["geometry"]].concat();
    let all_of_solver = [&shared[..], &of_solver].concat();
    let of = |stage: &str| match stage {
        "cad2fem" => &of_cad2fem[..],
        "solver" => &all_of_solver,
        "fab" => &of_fab,
        _ => &shared[..],
    };
    let of_scene = ["library", "measure", "mechanics", "mesh", "program", "reports", "system"];
    let of_run = ["measure", "mechanics", "mesh", "program", "reports", "scene"];
    let of_variables = ["mechanics", "mesh", "program", "scene"];
    let of_design = [&of_run[..], &["run", "variables"]].concat();
    let of_python = [&of_design[..], &["design"]].concat();
    let below: [(&str, &[&str]); 17] = [
        ("cad2fem/implicit", &["mesh", "program"]),
        ("cad2fem/library", &[]),
        ("cad2fem/mesh", &["system"]),
        ("cad2fem/page", &["mesh", "program", "reports", "system"]),
        ("cad2fem/program", &["mesh", "system"]),
        ("cad2fem/render", &["mesh"]),
        ("cad2fem/reports", &["program"]),
        ("cad2fem/system", &[]),
        ("solver/mechanics", &["mesh"]),
        ("solver/measure", &["mechanics", "mesh", "program"]),
        ("solver/scene", &of_scene),
        ("solver/polyfem", &["mechanics", "mesh", "program", "scene"]),
        ("solver/run", &of_run),
        ("solver/design", &of_design),
        ("solver/python", &of_python),
        ("solver/variables", &of_variables),
        ("fab/geometry", &["mesh"]),
    ];
    for (package, allowed) in stages.iter().map(|s| (*s, of(s))).chain(below) {
        let path = repository().join(package).join("Cargo.toml");
        let manifest: toml::Table = fs::read_to_string(&path).unwrap().parse().unwrap();
        let names = dependencies(&manifest);
        let known =
            ["serde", "clap", "anyhow", "dunce"].into_iter().any(|name| names.contains(name));
        assert!(known, "{package}: {names:?}");
        for ours in stages.iter().chain(&of_cad2fem).chain(&of_solver).chain(&["geometry", "tests"])
        {
            let uses = names.contains(*ours);
            assert!(!uses || allowed.contains(ours), "{package} depends on {ours}");
        }
    }
}

/// Names of all packages in the tables of dependencies, those of single systems among them.
fn dependencies(manifest: &toml::Table) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for (section, table) in manifest {
        let Some(table) = table.as_table() else { continue };
        if section == "target" {
            names
                .extend(table.values().flat_map(|system| dependencies(system.as_table().unwrap())));
        } else if section.ends_with("dependencies") {
            for (key, value) in table {
                let renamed = value.get("package").and_then(|v| v.as_str());
                names.insert(renamed.unwrap_or(key).to_owned());
            }
        }
    }
    names
}

#[test]
pub fn files_have_telling_names_and_are_read_in_one_sitting() {
    let mut wrong = Vec::new();
    for path in files(&repository(), "rs") {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let folder = path.parent().unwrap().file_name().unwrap().to_string_lossy().into_owned();
        for vague in ["utils", "util", "common", "helpers", "helper", "misc"] {
            if name == vague || folder == vague {
                wrong.push(format!("{}: says nothing", path.display()));
            }
        }
        let lines = fs::read_to_string(&path).unwrap().lines().count();
        if lines > LONGEST {
            wrong.push(format!("{}: {lines} lines", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Goals are named by one word; files that rules make are not goals.
#[test]
fn make_help_lists_every_goal_with_one_line() {
    let makefile = fs::read_to_string(repository().join("Makefile")).unwrap();
    let phony: BTreeSet<String> = {
        let database = make(&["--print-data-base", "--question", "help"]);
        let line = database.lines().find_map(|l| l.strip_prefix(".PHONY: "));
        line.expect("goals are phony").split_whitespace().map(str::to_owned).collect()
    };
    let written = |line: &str| {
        let (name, _) = line.split_once(':')?;
        let word = !name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase() || c == '-');
        word.then(|| name.to_owned())
    };
    let goals: BTreeSet<String> = makefile.lines().filter_map(written).collect();
    // every folder in pipelines is a goal
    assert!(goals.is_subset(&phony), "{:?}", goals.difference(&phony));
    let help = make(&["help"]);
    let listed: Vec<String> = help
        .lines()
        .map(|line| {
            let mut words = line.split_whitespace();
            assert_eq!(words.next(), Some("make"), "{line}");
            let goal = words.next().unwrap_or_default().to_owned();
            assert!(words.next().is_some(), "{goal} is not explained");
            goal
        })
        .collect();
    assert_eq!(listed.len(), phony.len(), "{help}");
    assert_eq!(listed.into_iter().collect::<BTreeSet<_>>(), phony);
}

fn make(arguments: &[&str]) -> String {
    let output = workdir::make().args(arguments).current_dir(repository()).output().unwrap();
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Whoever installs a package of Python does so by its hash.
#[test]
fn packages_of_python_have_hashes() {
    let top = repository();
    for script in [
        "Makefile",
        ".ci/cross/target",
        ".ci/run",
        ".ci/test",
        ".ci/Containerfile",
        ".ci/README.dist",
    ] {
        let text = fs::read_to_string(top.join(script)).unwrap();
        for line in text.lines().filter(|line| line.contains("pip install")) {
            assert!(line.contains("--require-hashes"), "{script}: {line}");
        }
    }
    let lists = [
        "requirements.txt",
        "pipelines/sweep/requirements.txt",
        ".ci/zig.txt",
        ".ci/prose.txt",
        ".ci/wheel.txt",
    ];
    for list in lists {
        let text = fs::read_to_string(top.join(list)).unwrap().replace("\\\n", " ");
        for line in text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#')) {
            let pinned = line.contains("==") && line.contains("--hash=sha256:");
            assert!(pinned, "{list}: {line}");
        }
    }
}

/// Texts of others are text in pages, never markup: neither templates nor scripts put them in as HTML.
#[test]
fn pages_make_no_markup_of_texts() {
    let top = repository();
    let sinks = [
        "innerHTML",
        "outerHTML",
        "insertAdjacentHTML",
        "document.write",
        "DOMParser",
        "srcdoc",
        "setHTML",
        "createContextualFragment",
        "parseFromString",
        "eval(",
        "Function(",
        "javascript:",
        "import(",
    ];
    let studio = "solver/python/softpuffer/studio/page";
    for folder in ["cad2fem/page/web", "pipelines/sweep/web", studio] {
        for path in files(&top.join(folder), "js") {
            let text = fs::read_to_string(&path).unwrap();
            let found: Vec<&&str> = sinks.iter().filter(|sink| text.contains(**sink)).collect();
            assert!(found.is_empty(), "{}: {found:?}", path.display());
        }
    }
    // what is not escaped: our own style and script, JSON in which no `<` is left, Markdown
    let raw = naming("PreEscaped(", &files(&top.join("cad2fem/page/src"), "rs"));
    assert_eq!(Vec::from_iter(raw), ["cad2fem/page/src/document.rs", "cad2fem/page/src/prose.rs"]);
    let page = fs::read_to_string(top.join("pipelines/sweep/web/page.html")).unwrap();
    let safe: Vec<&str> = page
        .split("{{ ")
        .filter_map(|part| part.split_once("|safe }}"))
        .map(|(name, _)| name)
        .collect();
    assert_eq!(safe, ["style", "data", "library", "main"]);
}
