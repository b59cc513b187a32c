//! JSON Schemas of the files that people write (`PROGRAM schema`), by an independent validator: they
//! take what the programs take, and refuse the keys that the programs refuse.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use jsonschema::Validator;
use program::schema::Format;
use scene::config::SimConfig;
use scene::term::material::MaterialConfig;
use tests::workdir::repository;
use toml::Value;

/// A format, how its files are called, and how its program reads one.
struct Kind {
    prefix: &'static str,
    validator: Validator,
    read: fn(&Path) -> Result<()>,
}

fn kinds() -> Vec<Kind> {
    let kind = |formats: &[Format], name: &str, prefix, read| {
        let format = formats.iter().find(|format| format.name == name).unwrap();
        let validator = jsonschema::validator_for(&(format.schema)()).unwrap();
        Kind { prefix, validator, read }
    };
    let solver = solver::cmd::schema::FORMATS;
    let cad2fem = cad2fem::cmd::schema::FORMATS;
    vec![
        kind(cad2fem, "model", "model", |p| implicit::ModelFile::read(p, &[]).map(drop)),
        kind(cad2fem, "cad2fem", "cad2fem", |p| {
            cad2fem::tetmesh::config::Config::read(Some(p), &[]).map(drop)
        }),
        kind(tagger::cmd::schema::FORMATS, "tags", "tags", |p| {
            tagger::config::Config::read(p, &[]).map(drop)
        }),
        kind(solver, "sim", "sim", read_scene),
        kind(solver, "design", "design", |p| scene::config::DesignConfig::read(p).map(drop)),
        kind(solver, "calibrate", "calibrate", |p| {
            program::read_toml::<solver::study::calibration::Config>(p).map(drop)
        }),
        kind(solver, "validation", "validation", |p| {
            program::read_toml::<solver::study::validation::Config>(p).map(drop)
        }),
        kind(fab::cmd::schema::FORMATS, "mold", "mold", |p| {
            fab::config::Config::read(Some(p), &[]).map(drop)
        }),
    ]
}

/// A scene with its laws, which a program builds when it has the mesh.
fn read_scene(path: &Path) -> Result<()> {
    let scene = SimConfig::read(path)?;
    for body in scene.bodies()? {
        match body.material {
            MaterialConfig::Volumes(volumes) => {
                volumes.iter().try_for_each(|v| v.material()?.specification().map(drop))?;
            }
            one => drop(one.specification()?),
        }
    }
    Ok(())
}

/// Every file in pipelines that one of the programs reads.
fn files() -> Vec<PathBuf> {
    let mut folders = vec![repository().join("pipelines")];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => folders.push(path),
                false if path.extension().is_some_and(|e| e == "toml") => files.push(path),
                false => {}
            }
        }
    }
    files.sort();
    files
}

fn kind_of<'a>(kinds: &'a [Kind], path: &Path) -> Option<&'a Kind> {
    let name = path.file_name()?.to_str()?;
    kinds.iter().find(|kind| name.split('.').next() == Some(kind.prefix))
}

fn parsed(path: &Path) -> Value {
    toml::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn problem(kind: &Kind, value: &Value) -> Option<String> {
    let json = serde_json::to_value(value).unwrap();
    let errors = kind.validator.iter_errors(&json);
    errors.map(|error| format!("{}: {error}", error.instance_path())).next()
}

#[test]
fn every_file_of_the_pipelines_is_valid() {
    let kinds = kinds();
    let mut seen = vec![0; kinds.len()];
    for path in files() {
        let Some(kind) = kind_of(&kinds, &path) else { continue };
        let problem = problem(kind, &parsed(&path));
        assert!(problem.is_none(), "{}: {}", path.display(), problem.unwrap_or_default());
        seen[kinds.iter().position(|k| k.prefix == kind.prefix).unwrap()] += 1;
    }
    assert!(seen.iter().all(|&count| count > 0), "files of every kind: {seen:?}");
}

/// Tables whose keys are names that people gave elsewhere, which a schema cannot know.
const OF_NAMES: [&str; 4] = ["handles", "parameters", "wall", "weights"];

/// Puts a key that nobody knows into every table of every file, and takes each key away.
#[test]
fn schemas_and_programs_agree_on_keys() {
    let (kinds, folder) = (kinds(), tempfile::tempdir().unwrap());
    let (mut added, mut removed) = (0, 0);
    for path in files() {
        let Some(kind) = kind_of(&kinds, &path) else { continue };
        let whole = parsed(&path);
        let file = folder.path().join(path.file_name().unwrap());
        let read = |value: &Value| {
            fs::write(&file, toml::to_string(value).unwrap()).unwrap();
            (kind.read)(&file).context("refused")
        };
        let of_names =
            |way: &[Step]| matches!(way.last(), Some(Step::Key(key)) if OF_NAMES.contains(&&**key));
        for table in tables(&whole).into_iter().filter(|way| !of_names(way)) {
            let mut more = whole.clone();
            at(&mut more, &table).insert("nobodys_key".into(), Value::Float(1.0));
            let (program, schema) = (read(&more), problem(kind, &more));
            assert_eq!(
                program.is_err(),
                schema.is_some(),
                "{}: {table:?}: program {program:?}, schema {schema:?}",
                path.display()
            );
            added += usize::from(program.is_err());
            let keys: Vec<String> = at(&mut more, &table).keys().cloned().collect();
            for key in keys.iter().filter(|key| *key != "nobodys_key") {
                let mut less = whole.clone();
                at(&mut less, &table).remove(key);
                if let Some(schema) = problem(kind, &less) {
                    assert!(
                        read(&less).is_err(),
                        "{}: {table:?} without {key}: the schema alone refuses it: {schema}",
                        path.display()
                    );
                    removed += 1;
                }
            }
        }
    }
    assert!(added > 500 && removed > 500, "{added} and {removed} were refused by both");
}

#[test]
fn a_file_that_includes_others_may_be_a_part() {
    let kinds = kinds();
    let sim = kinds.iter().find(|kind| kind.prefix == "sim").unwrap();
    let value = |text: &str| toml::from_str::<Value>(text).unwrap();
    let design = kinds.iter().find(|kind| kind.prefix == "design").unwrap();
    assert!(problem(design, &value("[shape]\non = 'top'")).is_some());
    let part = "include = 'design.toml'\npuffer = '0.1'\n[shape]\non = 'top'\n";
    assert_eq!(problem(design, &value(part)), None);
    let slip = part.replace("on =", "onto =");
    assert!(problem(design, &value(&slip)).unwrap().contains("onto"));
    // an objective has a weight or a share
    let objective =
        "include = 'a.toml'\n[[objective]]\nkind = 'smoothness'\nname = 'n'\non = 'a'\n";
    for (keys, valid) in
        [("weight = 1", true), ("share = 1", true), ("weight = 1\nshare = 1", false), ("", false)]
    {
        let problem = problem(design, &value(&format!("{objective}{keys}")));
        assert_eq!(problem.is_none(), valid, "{keys}: {problem:?}");
    }
    for (text, valid) in [
        ("include = ['a.toml', 'b.toml']\nmaterial = 'ecoflex-00-30'", true),
        ("include = 'a.toml'\nmaterial = 'ecoflex-00-31'", false),
        ("include = 'a.toml'\nchamber = [{ on = 'c', pressure = '2e4*t' }]", true),
        ("include = 'a.toml'\nchamber = [{ on = 'c', pressure = 1, volume_factor = 1 }]", false),
        ("include = 'a.toml'\ngravity = [0, 0, { t = [0, 1], value = [0, 9] }]", true),
        ("include = 'a.toml'\ngravity = [0, 0]", false),
    ] {
        assert_eq!(problem(sim, &value(text)).is_none(), valid, "{text}");
    }
}

/// A step into a value.
#[derive(Clone, Debug)]
enum Step {
    Key(String),
    Index(usize),
}

/// The way to every table in a value, to itself first.
fn tables(value: &Value) -> Vec<Vec<Step>> {
    let below = |step: Step, value: &Value| -> Vec<Vec<Step>> {
        let ways = tables(value).into_iter();
        ways.map(|way| std::iter::once(step.clone()).chain(way).collect()).collect()
    };
    match value {
        Value::Table(table) => {
            let inner = table.iter().flat_map(|(key, value)| below(Step::Key(key.clone()), value));
            std::iter::once(Vec::new()).chain(inner).collect()
        }
        Value::Array(items) => {
            items.iter().enumerate().flat_map(|(i, item)| below(Step::Index(i), item)).collect()
        }
        _ => Vec::new(),
    }
}

fn at<'a>(value: &'a mut Value, way: &[Step]) -> &'a mut toml::Table {
    let place = way.iter().fold(value, |value, step| match step {
        Step::Key(key) => &mut value[key.as_str()],
        Step::Index(index) => &mut value[*index],
    });
    place.as_table_mut().unwrap()
}
