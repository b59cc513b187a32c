//! What is done in one place of the sources only.

use std::collections::BTreeSet;

use tests::workdir::repository;

use crate::tidy::{code, naming, sources, used};

#[test]
fn outside_programs_and_libraries_are_called_in_one_place() {
    let sources = sources();
    let one = |path: &str| BTreeSet::from([path.to_owned()]);
    let faer = naming("faer", &sources);
    assert!(!faer.is_empty());
    assert!(faer.iter().all(|p| p.starts_with("solver/mechanics/src/math/linear/")), "{faer:?}");
    assert_eq!(naming("manifold_rust", &sources), one("cad2fem/mesh/src/solid/mod.rs"));
    let programs = naming("Command::new", &sources);
    assert!(!programs.is_empty());
    // the meshers, and our own programs where one asks another
    let asking = ["solver/design/src/molding.rs", "solver/src/cmd/optimize/starts.rs"];
    let ours = |p: &str| p.starts_with("cad2fem/src/mesher/") || asking.contains(&p);
    assert!(programs.iter().all(|p| ours(p)), "{programs:?}");
}

/// What may be a link or a pipe that others have put there is opened and removed with care, in one place.
#[test]
fn files_are_opened_in_one_place() {
    let io = |name: &str| format!("cad2fem/mesh/src/io/{name}.rs");
    let mut sources = sources();
    sources.retain(|path| !path.starts_with(repository().join("cad2fem/system")));
    for word in ["File::open", "File::create", "File::options", "OpenOptions", "DirBuilder"] {
        let found = naming(word, &sources);
        assert!(found.is_subset(&BTreeSet::from([io("open")])), "{word}: {found:?}");
    }
    let looking = ["read_dir", "metadata", "symlink_metadata", "remove_dir"];
    let removing = [io("inputs"), io("unfinished"), "cad2fem/program/src/lock.rs".into()];
    let mut functions = 0;
    for path in &sources {
        let place = path.strip_prefix(repository()).unwrap().to_string_lossy().into_owned();
        for name in used(&code(path), "fs").iter().filter(|n| !n.starts_with(char::is_uppercase)) {
            let removes = name.starts_with("remove_") && removing.contains(&place);
            assert!(looking.contains(&name.as_str()) || removes, "{place}: fs::{name}");
            functions += 1;
        }
    }
    assert!(functions > 0);
}

#[test]
fn systems_differ_in_one_crate() {
    let sources = sources();
    for word in ["std::os", "nix::", "windows_sys", "cfg(unix)", "cfg(windows)"] {
        let found = naming(word, &sources);
        let others: Vec<_> = found.iter().filter(|p| !p.starts_with("cad2fem/system/")).collect();
        assert!(others.is_empty(), "{word}: {others:?}");
    }
    assert!(!naming("nix::", &sources).is_empty());
}

/// An error in settings carries its keys, and is not read for them.
#[test]
fn messages_of_errors_are_not_read() {
    let program = repository().join("cad2fem/program/src");
    let readers = ["settings/key_path", "settings/place", "settings/reading", "nearest"];
    for name in readers {
        let code = code(&program.join(name).with_extension("rs"));
        for word in ["strip_prefix", "strip_suffix", "starts_with", "ends_with", "message."] {
            assert!(!code.contains(word), "{name}: {word}");
        }
    }
    // texts of errors of `toml` are shown in one place
    let shown = BTreeSet::from(["cad2fem/program/src/settings/mod.rs".to_owned()]);
    assert_eq!(naming(".message()", &sources()), shown);
}
