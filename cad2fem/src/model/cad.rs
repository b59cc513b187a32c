//! CAD route: a gmsh/OpenCASCADE script, a STEP, BREP or IGES file → surface in patches.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use mesh::check::orient_by_nesting;

use crate::mesher::gmsh::{FaceOptions, Faces, Kind, mesh_faces};
use crate::mesher::python::Python;
use crate::model::solids::Solids;
use crate::model::{Facts, LabelledSurface};
use crate::units::Unit;

/// How a CAD file is read.
#[derive(Clone, Debug)]
pub struct CadOptions {
    /// Unit of a `.geo` script or a `.brep` file; other files state their own.
    pub unit: Option<Unit>,
    /// Numbers to set in a `.geo` script.
    pub numbers: BTreeMap<String, f64>,
    /// Longest edge [m].
    pub edge_length: Option<f64>,
    /// Largest distance of triangles from their faces that is wanted [m]; without it, triangles are as the file or gmsh
    /// wants them.
    pub chord: Option<f64>,
    /// Whether a `.geo` script may run programs, and read and write files.
    pub trust: bool,
    /// Solids that are taken out of the others, by their names or their numbers from 1.
    pub subtract: Vec<String>,
    /// Longest time gmsh may take.
    pub timeout: Duration,
}

/// Meshes the faces of a CAD file; one region per physical surface, of other files than scripts
/// one per name, colour or face, and what solids it has. Outer shells face outward, cavities inward. Physical surfaces
/// between two volumes or embedded in one are inside; of each physical volume there is the boundary.
pub fn read(path: &Path, options: &CadOptions) -> Result<(LabelledSurface, Solids)> {
    let faces = read_faces(path, options)?;
    Ok((labelled(&faces), Solids::of(&faces)))
}

/// The faces of a CAD file [m].
pub fn read_faces(path: &Path, options: &CadOptions) -> Result<Faces> {
    let (scale, unit) = scale(path, options)?;
    let options = FaceOptions {
        numbers: options.numbers.clone(),
        unit,
        edge_length: options.edge_length.map(|h| h / scale),
        chord: options.chord.map(|chord| chord / scale),
        metres: scale,
        trust: options.trust,
        subtract: options.subtract.clone(),
        timeout: options.timeout,
    };
    let mut faces = mesh_faces(&Python::find()?, path, &options)?;
    for v in &mut faces.surface.vertices {
        *v *= scale;
    }
    faces.chord_error = faces.chord_error.map(|error| error * scale);
    Ok(faces)
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

/// Metres per unit of what gmsh returns, and the unit that it is asked for: files that a script
/// reads come in the unit of its numbers. What is to follow the faces comes in millimetres, in which OpenCASCADE's
/// tolerances are meant.
fn scale(path: &Path, options: &CadOptions) -> Result<(f64, Option<&'static str>)> {
    match (Kind::of(path)?, options.unit) {
        (Kind::Script | Kind::Brep, Some(unit)) => Ok((unit.metres(), Some(unit.of_cad()))),
        (Kind::Script, None) => {
            bail!("{}: a .geo script has no unit; say --unit mm", path.display())
        }
        (Kind::Brep, None) => bail!("{}: a .brep file has no unit; say --unit mm", path.display()),
        (Kind::Step, None) if options.chord.is_some() => {
            Ok((Unit::Mm.metres(), Some(Unit::Mm.of_cad())))
        }
        (Kind::Step, None) => Ok((1.0, Some("M"))),
        (Kind::Iges, None) => Ok((Unit::Mm.metres(), None)),
        (Kind::Step | Kind::Iges, Some(_)) => {
            bail!("{}: a STEP or IGES file states its unit; leave out --unit", path.display())
        }
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
