//! A scene from its file or text, with the meshes that it names or others.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use mechanics::body::Body;
use mesh::Vec3;
use mesh::io::MshFile;
use program::{Change, Settings};

use super::{Scene, SceneMembrane, ScenePart, laws};
use crate::config::{BodyConfig, SimConfig, beside};

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
            Self::of(file, path, config, bodies.into_iter().zip(meshes))
        })
    }

    /// A scene as text that a program has made, TOML in a folder to which its paths are relative, whose bodies have
    /// these meshes and not those of files.
    pub fn of_text(text: &str, path: &Path, meshes: Vec<MshFile>) -> Result<Self> {
        let file = Settings::made(text);
        file.checked(|file| {
            let (config, bodies) = config_of(file, path)?;
            ensure!(
                bodies.len() == meshes.len(),
                "the scene has {} bodies, but there are {} meshes",
                bodies.len(),
                meshes.len()
            );
            let meshes = meshes.into_iter().map(|mesh| (path.to_path_buf(), mesh));
            Self::of(file, path, config, bodies.into_iter().zip(meshes))
        })
    }

    fn of(
        file: &Settings,
        path: &Path,
        config: SimConfig,
        bodies: impl Iterator<Item = (BodyConfig, (PathBuf, MshFile))>,
    ) -> Result<Self> {
        let context = || path.display().to_string();
        let (mut parts, mut meshes, mut all_laws) = (Vec::new(), Vec::new(), Vec::new());
        for (body, (mesh_path, mut file)) in bodies {
            if let Some(finding) = mesh::check::check_tets(&file.mesh).first() {
                bail!("{}: {}", mesh_path.display(), finding.message);
            }
            file.mesh.vertices.iter_mut().for_each(|v| *v += Vec3::from(body.translate));
            let own = laws::laws(parts.len(), &body, &mut file.mesh, &mut file.tags);
            all_laws.extend(own.with_context(context)?);
            meshes.push((body.name.clone(), file.mesh, file.tags));
            parts.push(ScenePart { config: body, mesh_path });
        }
        let body = match meshes.pop() {
            Some((_, mesh, tags)) if meshes.is_empty() && config.body.is_empty() => {
                Body::new(mesh, tags)
            }
            last => Body::of_several(meshes.into_iter().chain(last).collect()),
        };
        let body = body.cut_by(&config.cuts()).with_context(context)?;
        if let (false, Some(finding)) =
            (body.planes.is_empty(), mesh::check::check_tets(&body.mesh).first())
        {
            bail!("{}: once cuts are moved into their planes: {}", path.display(), finding.message);
        }
        let membranes = config.membrane.iter().map(SceneMembrane::new).collect::<Result<_>>();
        let membranes = membranes.with_context(context)?;
        let mut scene = Self {
            path: path.to_path_buf(),
            file: file.clone(),
            config,
            parts,
            laws: all_laws,
            membranes,
            body,
            certify: true,
        };
        scene.set_branches().with_context(context)?;
        scene.set_mullins().with_context(context)?;
        scene.check_dilatation().with_context(context)?;
        Ok(scene)
    }
}

/// The settings of a scene and of its bodies.
fn config_of(file: &Settings, path: &Path) -> Result<(SimConfig, Vec<BodyConfig>)> {
    let context = || path.display().to_string();
    let config = SimConfig::of(file)?.bound().with_context(context)?;
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
