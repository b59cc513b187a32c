//! The files that a mold was made from, read again.

use std::path::{Path, PathBuf};

use mesh::io::{read_surface, read_tets};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, topology};
use program::{InputFile, sha256_file};

use super::{Against, deviation};
use crate::body::boundary::Boundary;
use crate::body::collar::{self, Collar, FittedTube};
use crate::body::files::BodyFiles;
use crate::body::source::Input;
use crate::config::Casts;
use crate::files::report::MoldReport;

/// Where the files of a body are.
pub struct Origins {
    /// The mesh that was molded.
    pub design: PathBuf,
    /// The surface that it was made from.
    pub model: Option<PathBuf>,
    /// The mesh as modelled, if it was designed since.
    pub modelled: Option<PathBuf>,
}

impl Origins {
    /// Those that a report in `folder` names, or where they are now.
    pub fn new(folder: &Path, input: &Input, against: &Against) -> Self {
        let of = |named: &Path, given: &Option<PathBuf>| {
            given.clone().unwrap_or_else(|| folder.join(named))
        };
        let other = |named: &Option<InputFile>, given| named.as_ref().map(|n| of(&n.path, given));
        Self {
            design: of(&input.path, &against.design),
            model: other(&input.model, &against.model),
            modelled: other(&input.modelled, &against.from),
        }
    }

    /// Whether model and mesh as modelled are as they were.
    pub fn require_unchanged(&self, input: &Input) -> Result<(), String> {
        let pairs = [(&self.model, &input.model), (&self.modelled, &input.modelled)];
        for (path, named) in pairs {
            let (Some(path), Some(named)) = (path, named) else { continue };
            if sha256_file(path).map_err(|e| e.to_string())? != named.sha256 {
                return Err(format!("{} has changed since the mold was made", path.display()));
            }
        }
        Ok(())
    }

    /// The whole body that is to be cast, of the surface `casts`, with its collars and its groove, in the mold's millimetres.
    pub fn whole(&self, report: &MoldReport, casts: Casts) -> Result<SurfaceMesh, String> {
        let plain = self.plain(report, casts)?;
        let Some(groove) = &report.groove else { return Ok(plain) };
        let plain = Solid::from_surface(&plain).map_err(|e| e.to_string())?;
        Ok(plain.difference(&groove.solid()).to_surface())
    }

    /// The body of [`Self::whole`] without its groove.
    pub fn plain(&self, report: &MoldReport, casts: Casts) -> Result<SurfaceMesh, String> {
        let of_model = casts != Casts::Mesh;
        if of_model {
            self.require_unchanged(&report.input)?;
        }
        match report.collars.is_empty() {
            false => collared(&self.read(report, casts)?, report),
            true => Ok(deviation::placed(&self.surface(report, casts)?, report)),
        }
    }

    /// The surface `casts` of the design [m].
    fn surface(&self, report: &MoldReport, casts: Casts) -> Result<SurfaceMesh, String> {
        let of_model = casts != Casts::Mesh;
        match &self.model {
            Some(_) if of_model && self.modelled.is_some() => Ok(self.read(report, casts)?.cast),
            Some(model) if of_model => read_surface(model).map_err(|e| e.to_string()),
            _ => boundary_of(&self.design),
        }
    }

    fn read(&self, report: &MoldReport, casts: Casts) -> Result<Boundary, String> {
        let of_model = casts != Casts::Mesh;
        let files = BodyFiles {
            mesh: &self.design,
            model: self.model.as_deref().filter(|_| of_model),
            modelled: self.modelled.as_deref().filter(|_| of_model),
        };
        let body = files.read(&report.input.chamber, Some(casts)).map_err(|e| format!("{e:#}"))?;
        Ok(body.boundary)
    }

    /// The model that walls are measured on beside what is cast, in the mold's millimetres; of a cast model the mesh.
    /// None of a designed body, nor where there is no model.
    pub fn beside(&self, report: &MoldReport) -> Option<Result<SurfaceMesh, String>> {
        let model = self.model.as_ref().filter(|_| self.modelled.is_none())?;
        let read = || {
            self.require_unchanged(&report.input)?;
            match report.input.surface {
                Casts::Mesh => read_surface(model).map_err(|e| e.to_string()),
                Casts::Model => boundary_of(&self.design),
            }
        };
        Some(read().map(|surface| deviation::placed(&surface, report)))
    }
}

/// The boundary of a mesh [m].
pub fn boundary_of(path: &Path) -> Result<SurfaceMesh, String> {
    let mesh = read_tets(path).map_err(|e| e.to_string())?.mesh;
    Ok(topology::boundary(&mesh).surface(&mesh).0)
}

/// A body and its collars, in the mold's millimetres.
fn collared(boundary: &Boundary, report: &MoldReport) -> Result<SurfaceMesh, String> {
    let placed = |surface: &SurfaceMesh| {
        Solid::from_surface(&deviation::placed(surface, report)).map_err(|e| e.to_string())
    };
    let cores = boundary.cores.iter().map(|core| placed(&core.surface));
    let cores = cores.collect::<Result<Vec<_>, _>>()?;
    let collars: Vec<Collar> = report.collars.iter().map(FittedTube::collar).collect();
    Ok(collar::body(&placed(&boundary.filled)?, &cores, &collars).1.to_surface())
}
