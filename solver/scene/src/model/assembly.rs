//! A scene from its settings and the meshes of its bodies.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use mechanics::body::Body;
use mesh::Vec3;
use mesh::io::MshFile;
use program::Settings;

use super::{Scene, ScenePart, laws};
use crate::config::{BodyConfig, SimConfig};

impl Scene {
    /// A scene whose `[numbers]` have not been given their values.
    pub(crate) fn assembled(
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
        let scene = Self {
            path: path.to_path_buf(),
            file: file.clone(),
            config,
            parts,
            laws: all_laws,
            body,
            given: BTreeMap::new(),
            certify: true,
        };
        scene.check_beside_laws().with_context(context)?;
        scene.check_dilatation().with_context(context)?;
        Ok(scene)
    }
}
