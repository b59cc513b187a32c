//! Random bodies of the families in `tests/campaign`: their models are what their functions say, and verdicts tell those that
//! cannot be cast. `make campaign` takes as many as one likes to verified molds.

use std::path::{Path, PathBuf};
use std::process::Command;

use implicit::{Fields, Model, ModelFile, surface};
use mechanics::math::random::Random;
use mesh::Vec3;
use mesh::check::check_surface;
use mesh::inside::WindingNumber;
use mesh::measure::bounds;
use rayon::prelude::*;
use tests::workdir::{Run, Workdir, python, repository};

/// Points at which a surface is compared with the functions of its model.
const POINTS: usize = 300;

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
fn bodies_are_modelled() {
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
        dir.run("cad2fem", &command).assert_good();
        assert_eq!(dir.files(&format!("{name}/patches")), patches);
    }
    let said = campaign(&python, "verdict.py", &["shells-1"], &dir);
    assert!(said.contains("chain False in one piece"), "{said}");
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
