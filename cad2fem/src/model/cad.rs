//! CAD route: a gmsh/OpenCASCADE script, a STEP, BREP or IGES file → surface in patches.

use std::path::Path;

use anyhow::{Context, Result, bail};
use mesh::check::orient_by_nesting;

use crate::mesher::gmsh::{CadOptions, Faces, mesh_faces};
use crate::model::solids::Solids;
use crate::model::{Facts, LabelledSurface};

/// Meshes the faces of a CAD file; one region per physical surface, of other files than scripts
/// one per name, colour or face, and what solids it has. Outer shells face outward, cavities inward. Physical surfaces
/// between two volumes or embedded in one are inside; of each physical volume there is the boundary.
pub fn read(path: &Path, options: &CadOptions) -> Result<(LabelledSurface, Solids)> {
    let faces = mesh_faces(path, options)?;
    Ok((labelled(&faces), Solids::of(&faces)))
}

/// The boundary of the body in its regions, the surfaces inside, and the volumes.
fn labelled(faces: &Faces) -> LabelledSurface {
    let all = 0..faces.patch.len();
    let skin: Vec<usize> = all.clone().filter(|&t| !faces.inside[t]).collect();
    let mut names = Vec::new();
    let mut inside = Vec::new();
    let mut place = vec![None; faces.names.len()];
    for (i, name) in faces.names.iter().enumerate() {
        let own = |t: &usize| faces.inside[*t] && faces.patch[*t] == Some(i);
        let triangles: Vec<usize> = all.clone().filter(own).collect();
        if triangles.is_empty() {
            place[i] = Some(names.len());
            names.push(name.clone());
        } else {
            inside.push((name.clone(), faces.surface.part(&triangles)));
        }
    }
    let mut surface = faces.surface.part(&skin);
    orient_by_nesting(&mut surface);
    let region = skin.iter().map(|&t| faces.patch[t].and_then(|patch| place[patch])).collect();
    let volumes = faces.volumes.iter().map(|(name, triangles)| {
        let mut volume = faces.surface.part(triangles);
        orient_by_nesting(&mut volume);
        (name.clone(), volume)
    });
    LabelledSurface {
        surface,
        names,
        region,
        inside,
        volumes: volumes.collect(),
        facts: Facts::of(faces, |name| name.to_owned()),
        ..LabelledSurface::default()
    }
}

/// Reads `NAME=VALUE`.
pub fn parse_number(text: &str) -> Result<(String, f64)> {
    let (name, value) = text.split_once('=').context("NAME=VALUE is needed")?;
    let value: f64 = value.trim().parse().with_context(|| format!("{value:?} is not a number"))?;
    if name.trim().is_empty() || !value.is_finite() {
        bail!("a name and a finite number are needed, found {text:?}");
    }
    Ok((name.trim().to_owned(), value))
}
