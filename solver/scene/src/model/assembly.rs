//! A scene from its settings and the meshes of its bodies.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use mechanics::body::Body;
use mesh::Vec3;
use mesh::io::MshFile;
use program::Settings;

use super::{Scene, ScenePart};
use crate::config::{BodyConfig, SimConfig};
use crate::term::material::laws;

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
            let rigid =
                !config.body.is_empty() && config.rigid.iter().any(|own| own.on == body.name);
            let owner = (parts.len(), &*body.name, rigid);
            let own = laws(owner, &body.material, &mut file.mesh, &mut file.tags);
            all_laws.extend(own.with_context(context)?);
            meshes.push((body.name.clone(), file.mesh, file.tags));
            parts.push(ScenePart { config: body, mesh_path });
        }
        for law in all_laws.iter_mut().filter(|_| parts.len() > 1) {
            if let Some(volume) = &law.volume {
                law.name = format!("{}.{volume}", law.body);
            }
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
        scene.check_laws().with_context(context)?;
        Ok(scene)
    }
}
