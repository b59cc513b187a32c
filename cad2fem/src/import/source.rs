//! One file of a body: its triangles in metres, by patches, and how its unit is known.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use mesh::SurfaceMesh;
use mesh::io::{MshFile, read_surface, read_tets, threemf};
use mesh::measure::diagonal;
use mesh::topology::boundary;
use program::units::{Unit, guess};
use program::{InputFile, sha256_file};

use super::{Patched, Patches};
use crate::mesher::gmsh::{CadOptions, Faces, Kind, mesh_faces};
use crate::model::Facts;
use crate::model::record::{Known, Source};
use crate::model::solids::Solids;

/// How files are read.
#[derive(Debug)]
pub struct Reader {
    /// Unit of the files that state none.
    pub unit: Option<Unit>,
    /// How CAD is read; its unit follows from [`Self::unit`].
    pub cad: CadOptions,
    /// CAD: whether solids that touch or cross are one body.
    pub unite: bool,
    /// What the user would write again with one more option.
    pub command: String,
    /// The unit that the first file without one was taken to have: files of one body have the same.
    pub guessed: Option<Unit>,
    /// What CAD files said about their faces.
    pub facts: Facts,
}

impl Reader {
    /// Reads a file; its patches have its name in theirs if there are `several` files.
    pub fn read(
        &mut self,
        file: &Path,
        several: bool,
        patches: &mut Patches,
    ) -> Result<(Patched, Source)> {
        let extension = file.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let stem = file_name(&file.file_stem().unwrap_or_default().to_string_lossy());
        let extension = extension.to_ascii_lowercase();
        if let (Some(solid), "stl" | "obj" | "ply" | "msh" | "3mf") =
            (self.cad.subtract.first(), extension.as_str())
        {
            bail!(
                "--subtract {solid}: there is no such file, and {} has no solids with names or numbers",
                file.display()
            );
        }
        let (raw, unit, unit_is) = match extension.as_str() {
            "geo" => bail!("{}: a script: use cad2fem model", file.display()),
            "stl" | "obj" | "ply" => {
                let mut surface = read_surface(file)?;
                let (unit, known) = self.unit_of(file, diagonal(&surface.vertices))?;
                surface.vertices.iter_mut().for_each(|v| *v *= unit.metres());
                let name = if several { &stem } else { "outer" };
                (whole(surface, name, patches), unit.symbol(), known)
            }
            "msh" => self.skin(file, several.then_some(&stem), patches)?,
            "3mf" => self.printed(file, several.then_some(&stem), patches)?,
            _ => self.cad(file, several.then_some(&stem), patches)?,
        };
        let source = Source {
            input: InputFile { path: file.to_path_buf(), sha256: sha256_file(file)? },
            unit: unit.into(),
            unit_is,
            triangles: raw.surface.triangles.len(),
            diagonal: diagonal(&raw.surface.vertices),
        };
        log::info!("{}: {}", file.display(), source.described());
        Ok((raw, source))
    }

    /// The unit of a file that states none.
    fn unit_of(&mut self, file: &Path, size: f64) -> Result<(Unit, Known)> {
        let known = match self.unit {
            Some(unit) => (unit, Known::Given),
            None => (self.guessed.map_or_else(|| guess(file, size), Ok)?, Known::Guessed),
        };
        self.guessed = Some(known.0);
        Ok(known)
    }

    /// The boundary of a tetrahedral mesh; a patch for each tag.
    fn skin(
        &mut self,
        file: &Path,
        stem: Option<&String>,
        patches: &mut Patches,
    ) -> Result<(Patched, &'static str, Known)> {
        let MshFile { mut mesh, tags } = read_tets(file)?;
        let (unit, known) = self.unit_of(file, diagonal(&mesh.vertices))?;
        mesh.vertices.iter_mut().for_each(|v| *v *= unit.metres());
        let skin = boundary(&mesh);
        let patch = |facet: &[usize; 3]| {
            let own = tags.get(*facet).map_or("rest", |id| &tags.names[id as usize - 1]);
            patches.index(&of_file(stem, &file_name(own)))
        };
        let patch = skin.facets.iter().map(patch).collect();
        Ok((Patched { surface: skin.surface(&mesh).0, patch }, unit.symbol(), known))
    }

    fn printed(
        &self,
        file: &Path,
        stem: Option<&String>,
        patches: &mut Patches,
    ) -> Result<(Patched, &'static str, Known)> {
        ensure!(self.unit.is_none(), "{}: 3MF states its unit; leave out --unit", file.display());
        let model = threemf::read(file)?;
        let several = model.shapes.len() > 1;
        let mut all = Patched::default();
        for (i, shape) in model.shapes.iter().enumerate() {
            let mut surface = shape.placed();
            surface.vertices.iter_mut().for_each(|v| *v *= model.metres);
            let own = match (&shape.name, several) {
                (_, false) => "outer".to_owned(),
                (name, _) if name.is_empty() => format!("object-{}", i + 1),
                (name, _) => file_name(name),
            };
            let name = stem.map_or(own.clone(), |stem| {
                if several { format!("{stem}-{own}") } else { stem.clone() }
            });
            all.add(whole(surface, &name, patches));
        }
        ensure!(!all.patch.is_empty(), "{}: it has no triangles to build", file.display());
        Ok((all, model.unit, Known::Stated))
    }

    fn cad(
        &mut self,
        file: &Path,
        stem: Option<&String>,
        patches: &mut Patches,
    ) -> Result<(Patched, &'static str, Known)> {
        let brep = Kind::of(file)? == Kind::Brep;
        ensure!(
            !brep || self.unit.is_some() || self.cad.edge_length.is_none(),
            "{}: a .brep file states no unit: --edge-length needs --unit",
            file.display()
        );
        let (unit, known) = match (brep, self.unit) {
            // one that is given is refused
            (false, unit) => (unit, Known::Stated),
            (true, Some(unit)) => (Some(unit), Known::Given),
            // how large it is says what its unit is, and so how fine triangles are to be
            (true, None) => {
                let options = CadOptions { unit: Some(Unit::M), chord: None, ..self.cad.clone() };
                let coarse = mesh_faces(file, &options)?;
                let (unit, known) = self.unit_of(file, diagonal(&coarse.surface.vertices))?;
                (Some(unit), known)
            }
        };
        let faces = mesh_faces(file, &CadOptions { unit, ..self.cad.clone() })?;
        self.look_at_solids(file, &Solids::of(&faces))?;
        self.facts.extend(Facts::of(&faces, |name| of_file(stem, name)));
        let symbol = unit.map_or("its own", Unit::symbol);
        Ok((boundary_of(&faces, stem, patches), symbol, known))
    }
}

impl Reader {
    /// Refuses solids that meet unless they are one body, and says which are chambers.
    fn look_at_solids(&self, file: &Path, solids: &Solids) -> Result<()> {
        if let (false, Some(complaint)) = (self.unite, solids.complaint(file, &self.command)) {
            bail!("{complaint}\nif they are one body: {} --unite", self.command);
        }
        solids.remark_on_chambers(file);
        Ok(())
    }
}

/// The name of a patch of one file of several.
fn of_file(stem: Option<&String>, name: &str) -> String {
    stem.map_or(name.to_owned(), |stem| format!("{stem}-{name}"))
}

/// All faces that are no boundary between volumes.
fn boundary_of(faces: &Faces, stem: Option<&String>, patches: &mut Patches) -> Patched {
    let index: Vec<u32> =
        faces.names.iter().map(|name| patches.index(&of_file(stem, name))).collect();
    let rest = of_file(stem, "rest");
    let mut of = |t: usize| faces.patch[t].map_or_else(|| patches.index(&rest), |i| index[i]);
    let patch: Vec<u32> = (0..faces.patch.len()).map(&mut of).collect();
    let skin: Vec<usize> = (0..patch.len()).filter(|&t| !faces.inside[t]).collect();
    Patched { surface: faces.surface.clone(), patch }.part(&skin)
}

fn whole(surface: SurfaceMesh, name: &str, patches: &mut Patches) -> Patched {
    let patch = vec![patches.index(name); surface.triangles.len()];
    Patched { surface, patch }
}

/// A name that can be one of a file.
fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    name.chars().map(safe).collect()
}
