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
        file.checked(|file| {
            let (config, bodies) = config_of(file, path)?;
            let meshes = meshes_of(&bodies, path, others)?;
            let scene = Self::assembled(file, path, config, bodies.into_iter().zip(meshes))?;
            scene.numbered()
        })
    }

    /// A scene of values that a program gives, with the file that it would be, from which its paths begin. Its bodies
    /// have these meshes and not those of files.
    pub fn of_values(values: toml::Table, path: &Path, meshes: Vec<MshFile>) -> Result<Self> {
        let file = SimConfig::settings_of(values)?;
        file.checked(|file| {
            let (config, bodies) = config_of(file, path)?;
            ensure!(
                bodies.len() == meshes.len(),
                "the scene has {} bodies, but there are {} meshes",
                bodies.len(),
                meshes.len()
            );
            let meshes = meshes.into_iter().map(|mesh| (path.to_path_buf(), mesh));
            let scene = Self::assembled(file, path, config, bodies.into_iter().zip(meshes))?;
            scene.numbered()
        })
    }

    /// This scene with the values of its `[numbers]`.
    fn numbered(mut self) -> Result<Self> {
        let values = std::mem::take(&mut self.config.numbers);
        let set = number::set(&mut self, &values);
        set.with_context(|| format!("{}: [numbers]", self.path.display()))?;
        Ok(self)
    }
}

/// The settings of a scene and of its bodies.
fn config_of(file: &Settings, path: &Path) -> Result<(SimConfig, Vec<BodyConfig>)> {
    let context = || path.display().to_string();
    let config = SimConfig::of(file)?;
    let bodies = config.bodies().with_context(context)?;
    Ok((config, bodies))
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
