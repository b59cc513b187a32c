//! Random bodies from model to verified mold: what becomes of them, by kind; and random bodies of families
//! that are hard to mesh.
//!
//! `BODIES_COUNT` is how many, `BODIES_SEED` the first of their seeds, of either. Six families more, with verdicts
//! that use none of our programs, are in `campaign`: `make campaign`.
#![allow(missing_docs, clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use cad2fem::implicit::{Fields, Model, ModelFile, surface};
use mechanics::math::random::Random;
use mesh::Vec3;
use mesh::check::check_surface;
use mesh::inside::WindingNumber;
use mesh::measure::bounds;
use rayon::prelude::*;
use tests::bodies::{Body, tags};
use tests::families;
use tests::workdir::{Run, Workdir, python, repository};

/// Points at which a surface is compared with the functions of its model.
const POINTS: usize = 300;

/// Enough for every kind, not fine.
const MESH: &str =
    "[tetmesh]\nrelative_edge_length = 0.08\nrelative_envelope = 2e-3\nmax_iterations = 20\n";

/// What became of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum End {
    NoModel,
    NoMesh,
    /// By `fab plan`, with a reason.
    Refused,
    /// By `fab mold` or `fab verify`, although there was a plan.
    NoMold,
    Verified,
}

/// Whether the surface of a model is sound and has inside what its functions say, further from it
/// than a cell of the grid.
fn modelled(model: &Model) -> Result<(), String> {
    let fields = Fields::new(model, false);
    let skin = surface(model, &fields).map_err(|e| format!("{e:#}"))?;
    let found = check_surface(&skin.surface);
    if !found.is_empty() {
        return Err(format!("{found:?}"));
    }
    let depth = |p: &Vec3| {
        let cuts = model.cut.iter().map(|c| {
            let normal = Vec3::from(c.normal).normalize();
            normal.dot(p) - c.offset
        });
        cuts.fold(fields.solid.at(p).max(-fields.cavity.at(p)), f64::max)
    };
    let metres = model.unit.metres();
    let (winding, (min, max)) = (WindingNumber::new(&skin.surface), bounds(&skin.surface.vertices));
    let mut random = Random::new(1);
    for _ in 0..POINTS {
        let p = (min + max) / 2.0 + random.vector().component_mul(&((max - min) * 0.55));
        let d = depth(&(p / metres));
        if d.abs() > model.grid && winding.contains(&p) != (d < 0.0) {
            return Err(format!("{:?} is on the wrong side: d = {d}", p / metres));
        }
    }
    Ok(())
}

/// Those of the seeds whose body, a name and a model, is not modelled.
fn wrong<'a>(
    seeds: impl ParallelIterator<Item = u64>,
    body: impl Fn(u64) -> (&'a str, String) + Sync,
) -> Vec<String> {
    let wrong = |seed| {
        let (name, text) = body(seed);
        let model = ModelFile::parse(&text).unwrap().model;
        modelled(&model).err().map(|what| format!("{seed}, {name}: {what}"))
    };
    seeds.filter_map(wrong).collect()
}

fn of_kind(seed: u64) -> (&'static str, String) {
    let body = Body::new(seed);
    (body.kind, body.model)
}

/// A number from the environment.
fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// A body from its model to its mold, in a folder of its own.
fn mold(seed: u64) -> (&'static str, End, String) {
    let (dir, body) = (Workdir::new(), Body::new(seed));
    dir.write("model.toml", &body.model);
    dir.write("cad2fem.toml", MESH);
    dir.write("mold.toml", "");
    let run = |program: &str, arguments: &str| -> Result<(), String> {
        let run = dir.run(program, arguments);
        assert!(!run.stderr.contains("panicked"), "seed {seed}: {}", run.stderr);
        (run.code == Some(0)).then_some(()).ok_or(format!("{}{}", run.stdout, run.stderr))
    };
    let mut end = End::NoModel;
    let mut chain = || {
        run("cad2fem", "-q model model.toml -o model")?;
        end = End::NoMesh;
        let patches = dir.files("model/patches");
        let names: Vec<&str> =
            patches.iter().filter_map(|p| Path::new(p).file_stem()?.to_str()).collect();
        dir.write("tags.toml", &tags(&names));
        run(
            "cad2fem",
            "-q tetmesh model/model.stl --config cad2fem.toml --no-cache -o volume.msh",
        )?;
        run("tagger", "-q tag volume.msh --config tags.toml --patches model/patches -o body.msh")?;
        end = End::Refused;
        run("fab", "-q plan body.msh --model model/model.stl --config mold.toml -o plan")?;
        end = End::NoMold;
        run(
            "fab",
            "-q mold body.msh --model model/model.stl --config mold.toml -o mold --no-pictures",
        )?;
        run("fab", "verify mold")?;
        end = End::Verified;
        Ok::<_, String>(())
    };
    let said = chain().err().unwrap_or_default();
    (body.kind, end, said)
}

/// Makes the molds and prints what became of them; the ends, in the order of the seeds.
fn molds(seeds: std::ops::Range<u64>) -> Vec<End> {
    let all: Vec<_> = seeds
        .into_par_iter()
        .map(|seed| {
            let (kind, end, said) = mold(seed);
            let line = said.lines().filter(|l| !l.contains(" ok ")).collect::<Vec<_>>().join(" | ");
            eprintln!("{seed:>5} {kind:<15} {end:?} {line}");
            (kind, end)
        })
        .collect();
    let mut table: BTreeMap<&str, BTreeMap<End, usize>> = BTreeMap::new();
    for &(kind, end) in &all {
        *table.entry(kind).or_default().entry(end).or_default() += 1;
        *table.entry("all").or_default().entry(end).or_default() += 1;
    }
    for (kind, ends) in table {
        eprintln!("{kind:<15} {ends:?}");
    }
    all.into_iter().map(|(_, end)| end).collect()
}

#[test]
fn a_body_of_each_kind_is_modelled() {
    let wrong = wrong((0..11).into_par_iter(), of_kind);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// A script of `campaign`, with what it prints.
fn campaign(python: &Path, script: &str, arguments: &[&str], dir: &Workdir) -> String {
    let mut command = Command::new(python);
    command.arg("-B").arg(repository().join("tests/campaign").join(script)).args(arguments);
    let run: Run = command.current_dir(dir.path(".")).output().unwrap().into();
    run.assert_good();
    run.stdout
}

/// Bodies of a family from the seed 0 on.
fn family(python: &Path, name: &str, count: usize, dir: &Workdir) -> Vec<PathBuf> {
    let arguments = [".", "--family", name, "--count", &count.to_string()];
    campaign(python, "bodies.py", &arguments, dir);
    (0..count).map(|seed| dir.path(&format!("{name}-{seed}"))).collect()
}

#[test]
fn bodies_of_the_campaign_are_modelled() {
    let Some(python) = python("numpy, gmsh, manifold3d") else { return };
    let dir = Workdir::new();
    let mut models = family(&python, "shells", 4, &dir);
    models.extend(family(&python, "lattices", 2, &dir));
    models.par_iter().for_each(|folder| {
        let model = ModelFile::read(&folder.join("model.toml"), &[]).unwrap().model;
        assert_eq!(modelled(&model), Ok(()), "{}", folder.display());
    });
    let step = "model FAMILY-0/model.step";
    let stl = "import FAMILY-0/skin.stl --subtract FAMILY-0/cavity.stl --unit mm";
    for (name, command, patches) in [
        ("fillets", step, vec!["ch1.stl", "ch2.stl", "seat.stl", "skin.stl"]),
        ("lofts", step, vec!["cavity.stl", "seat.stl", "skin.stl"]),
        ("periodic", stl, vec!["cavity.stl", "skin.stl"]),
    ] {
        family(&python, name, 1, &dir);
        let command = format!("-q {} -o {name}", command.replace("FAMILY", name));
        let run = dir.run("cad2fem", &command);
        run.assert_good();
        assert_eq!(dir.files(&format!("{name}/patches")), patches);
    }
    assert!(
        campaign(&python, "verdict.py", &["shells-1"], &dir).contains("chain False in one piece")
    );
}

#[test]
#[ignore = "a minute: runs in make test-all"]
fn verdicts_tell_bodies_that_cannot_be_cast() {
    let Some(python) = python("numpy, manifold3d") else { return };
    let dir = Workdir::new();
    family(&python, "shells", 20, &dir);
    family(&python, "lattices", 4, &dir);
    let said = campaign(&python, "verdict.py", &["shells-19", "lattices-3", "lattices-0"], &dir);
    for found in ["shells-19 coil True", "lattices-3 cage True", "lattices-0 frame False"] {
        assert!(said.contains(found), "{said}");
    }
}

#[test]
#[ignore = "two minutes: runs in make test-all"]
fn two_hundred_bodies_are_modelled() {
    let wrong = wrong((0..200).into_par_iter(), of_kind);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
#[ignore = "200 bodies in minutes, or as many as BODIES_COUNT says, from BODIES_SEED on"]
fn bodies_of_hard_families_are_modelled() {
    let (first, count) =
        (number("BODIES_SEED").unwrap_or(0), number("BODIES_COUNT").unwrap_or(200));
    let wrong = wrong((first..first + count).into_par_iter(), families::body);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
#[ignore = "11 bodies in minutes, or as many as BODIES_COUNT says: make bodies"]
fn bodies_become_molds() {
    let (first, count) = (number("BODIES_SEED").unwrap_or(0), number("BODIES_COUNT").unwrap_or(11));
    let ends = molds(first..first + count);
    let part = |end: &[End]| ends.iter().filter(|e| end.contains(e)).count() as f64;
    let meshed = part(&[End::Refused, End::NoMold, End::Verified]);
    assert!(part(&[End::NoModel]) <= 0.02 * count as f64);
    assert!(part(&[End::Verified]) >= 0.95 * meshed, "{} of {meshed}", part(&[End::Verified]));
}
