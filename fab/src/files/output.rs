//! What is written beside the STL files: the same parts with unit, names and places,
//! and views of the whole.

use std::path::Path;

use anyhow::Result;
use mesh::io::threemf::{self, Place, Shape};
use mesh::io::{IoError, write_atomic};
use mesh::{SurfaceMesh, Vec3, measure};

use crate::body::layer::LaidIn;
use crate::files::assembly::{Member, assembly};
use crate::files::picture;
use crate::files::report::{MoldReport, Part, Role};
use crate::files::sheet::{self, Sheet};
use crate::files::slicer;
use crate::mold::Purpose;

/// All parts where they are in the closed mold.
pub const ASSEMBLY: &str = "assembly.3mf";

/// All parts where they are in the closed mold, with the cast, for ParaView.
pub const GRID: &str = "reference/assembly.vtu";

/// Picture of the closed mold, cut open.
pub const ASSEMBLED: &str = "assembled.png";

/// Picture of the parts and the cast taken apart.
pub const EXPLODED: &str = "exploded.png";

/// The 3MF file of a part, beside its STL file.
pub fn threemf_file(part: &Part) -> String {
    format!("{}.3mf", part.name)
}

/// The files that [`write`] and [`draw`] make, relative to the folder of the report.
pub fn files(report: &MoldReport) -> Vec<String> {
    let parts = report.parts.iter().flat_map(|part| [threemf_file(part), slicer::file(part)]);
    let others = [ASSEMBLY, GRID, ASSEMBLED, EXPLODED, sheet::FILE];
    let templates = report.layers.iter().map(LaidIn::file);
    parts.chain(templates).chain(others.map(str::to_owned)).collect()
}

/// Writes the parts and their assembly as 3MF, how parts are sliced, the assembly for
/// ParaView, and what the sheet for casting says. `surfaces` are those of the STL files, the cast last.
pub fn write(folder: &Path, report: &MoldReport, surfaces: &[SurfaceMesh]) -> Result<()> {
    let shape = |(part, surface): (&Part, &SurfaceMesh), place| Shape {
        name: part.name.clone(),
        surface: surface.clone(),
        place,
    };
    let shapes = report.parts.iter().zip(surfaces);
    for (part, surface) in shapes.clone() {
        let alone = shape((part, surface), Place::at(Vec3::zeros()));
        threemf::write(&folder.join(threemf_file(part)), &report.program, &part.name, &[alone])?;
    }
    slicer::write(folder, report)?;
    for layer in &report.layers {
        write_atomic(&folder.join(layer.file()), |out| out.write_all(layer.svg().as_bytes()))?;
    }
    let closed: Vec<Shape> = shapes
        .map(|both| shape(both, Place { turn: both.0.turn(), shift: Vec3::zeros() }))
        .collect();
    threemf::write(&folder.join(ASSEMBLY), &report.program, "closed mold", &closed)?;
    picture::grid(&folder.join(GRID), &assembly(report, surfaces))?;
    Sheet::new(report).write(folder)
}

/// Draws the mold closed and taken apart.
pub fn draw(folder: &Path, report: &MoldReport, surfaces: &[SurfaceMesh]) -> Result<(), IoError> {
    let members = assembly(report, surfaces);
    let (centre, along) = section_plane(report, &members);
    let path = folder.join(ASSEMBLED);
    picture::assembled(&path, "closed, cut open", &members, &centre, &along)?;
    picture::exploded(&folder.join(EXPLODED), "taken apart", &members)
}

/// The plane that shows most: through the axis of the first socket, or else of the mold,
/// to the sprue; if that is above, across shells that come off sideways, or else along
/// the longer side of the cores, or of the mold. A point and a horizontal direction [mm].
fn section_plane(report: &MoldReport, members: &[Member]) -> (Vec3, Vec3) {
    let [low, high] = [report.block.min, report.block.max].map(Vec3::from);
    let place = |purpose| report.outlines(purpose).next().map(|f| Vec3::from(f.base));
    let centre = place(Purpose::Socket).unwrap_or((low + high) / 2.0);
    let offset = place(Purpose::Sprue).map_or(Vec3::zeros(), |sprue| sprue - centre);
    let level = Vec3::new(offset.x, offset.y, 0.0);
    let mold = high - low;
    let cores = report.parts.iter().zip(members).filter(|(part, _)| part.role == Role::Core);
    let cores: Vec<Vec3> = cores.flat_map(|(_, m)| m.surface.vertices.iter().copied()).collect();
    let size =
        if cores.is_empty() { mold } else { measure::bounds(&cores).1 - measure::bounds(&cores).0 };
    let sideways = report.parts.iter().any(|part| part.demolding[1] != 0.0);
    let along = match () {
        () if level.norm() > 0.1 * mold.xy().norm() => level,
        () if sideways || size.y > size.x => Vec3::y(),
        () => Vec3::x(),
    };
    (centre, along)
}
