//! A scene from its file or values, with the meshes that it names or others.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use mesh::io::MshFile;
use program::{Change, Settings};

use crate::config::{BodyConfig, SimConfig, beside};
use crate::model::Scene;
use crate::number;

impl Scene {
    /// Reads a scene and its meshes.
    pub fn read(path: &Path) -> Result<Self> {
        Self::read_with(path, &[], &[])
    }

    /// Reads a scene with other meshes in place of its own: (name of the body, path),
    /// without a name where there is only one body; and with other values.
    pub fn read_with(
        path: &Path,
        others: &[(Option<String>, PathBuf)],
        changes: &[Change],
    ) -> Result<Self> {
        let file = SimConfig::settings(path, changes)?;
        Self::made(&file, path, |bodies| meshes_of(bodies, path, others))
    }

    /// A scene of values that a program gives, with the file that it would be, from which its paths begin. Its bodies
    /// have these meshes and not those of files.
    pub fn of_values(values: toml::Table, path: &Path, meshes: Vec<MshFile>) -> Result<Self> {
        Self::made(&SimConfig::settings_of(values)?, path, |bodies| {
            ensure!(
                bodies.len() == meshes.len(),
                "the scene has {} bodies, but there are {} meshes",
                bodies.len(),
                meshes.len()
            );
            Ok(meshes.into_iter().map(|mesh| (path.to_path_buf(), mesh)).collect())
        })
    }

    /// The scene of a file and the meshes of its bodies, with the values of its `[numbers]`.
    fn made(
        file: &Settings,
        path: &Path,
        meshes: impl FnOnce(&[BodyConfig]) -> Result<Vec<(PathBuf, MshFile)>>,
    ) -> Result<Self> {
        file.checked(|file| {
            let config = SimConfig::of(file)?;
            let bodies = config.bodies().with_context(|| path.display().to_string())?;
            let meshes = meshes(&bodies)?;
            let mut scene = Self::assembled(file, path, config, bodies.into_iter().zip(meshes))?;
            let values = std::mem::take(&mut scene.config.numbers);
            let set = number::set(&mut scene, &values);
            set.with_context(|| format!("{}: [numbers]", path.display()))?;
            Ok(scene)
        })
    }
}

/// The meshes of the bodies with their files, some of which others stand for.
fn meshes_of(
    bodies: &[BodyConfig],
    path: &Path,
    others: &[(Option<String>, PathBuf)],
) -> Result<Vec<(PathBuf, MshFile)>> {
    let stands_for = |other: &Option<String>, body: &BodyConfig| match other {
        None => bodies.len() == 1,
        Some(name) => *name == body.name,
    };
    for (name, mesh) in others {
        ensure!(
            bodies.iter().any(|body| stands_for(name, body)),
            "{}: {} cannot take the place of a mesh; expected the name of one of the bodies, \
             as in --mesh {}={}",
            path.display(),
            mesh.display(),
            bodies[0].name,
            mesh.display()
        );
    }
    let mesh_of = |body: &BodyConfig| {
        let other = others.iter().find(|(name, _)| stands_for(name, body));
        other.map_or_else(|| beside(path, &body.mesh), |(_, mesh)| mesh.clone())
    };
    let read = |body: &BodyConfig| {
        let path = mesh_of(body);
        let file = mesh::io::read_tets(&path)?;
        Ok((path, file))
    };
    bodies.iter().map(read).collect()
}
