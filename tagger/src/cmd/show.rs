//! `tagger show`: a table of the tags of a mesh.

use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::PathBuf;

use anyhow::Result;
use mesh::io::MshFile;
use mesh::{Tags, TetMesh, Volumes, facet_key, io, measure, topology};

use crate::facets;

/// Prints tag, id, facets, area, components and boundary loops; then the volumes.
#[derive(clap::Args)]
pub struct Args {
    /// Tagged mesh (Gmsh .msh with physical groups of triangles).
    tagged: PathBuf,
}

struct Row {
    name: String,
    id: u32,
    facets: usize,
    area: f64,
    components: usize,
    loops: usize,
}

/// Runs `tagger show`.
pub fn run(args: &Args) -> Result<()> {
    let MshFile { mesh, tags } = io::read_tets(&args.tagged)?;
    let mut out = program::stdout();
    out.write_all(table(&mesh, &tags).as_bytes())?;
    out.flush()?;
    Ok(())
}

/// The tags of a mesh, one a line, then its volumes.
pub fn table(mesh: &TetMesh, tags: &Tags) -> String {
    let boundary = topology::boundary(mesh).facets;
    let named = tags.names.iter().filter_map(|name| Some((name.as_str(), tags.id(name)?)));
    let all = named.chain([("(none)", 0)]);
    let mut rows: Vec<Row> = all.map(|(name, id)| row(name, id, mesh, &boundary, tags)).collect();
    rows.retain(|row| row.id > 0 || row.facets > 0);
    of_tags(&rows) + &of_volumes(mesh, &tags.volumes)
}

fn row(name: &str, id: u32, mesh: &TetMesh, boundary: &[[usize; 3]], tags: &Tags) -> Row {
    let mut facets: Vec<[usize; 3]> =
        boundary.iter().copied().filter(|&f| tags.get(f).unwrap_or(0) == id).collect();
    let on_boundary: BTreeSet<[usize; 3]> = facets.iter().copied().map(facet_key).collect();
    facets.extend(tags.facets_of(id).into_iter().filter(|f| !on_boundary.contains(f)));
    Row {
        name: name.to_owned(),
        id,
        facets: facets.len(),
        area: facets::area(mesh, &facets),
        components: topology::components(&facets).len(),
        loops: topology::boundary_loops(&facets).len(),
    }
}

fn of_tags(rows: &[Row]) -> String {
    let width = rows.iter().map(|r| r.name.chars().count()).max().unwrap_or(0).max(3);
    let head = format!(
        "{:width$}  {:>3}  {:>7}  {:>12}  {:>10}  {:>5}\n",
        "tag", "id", "facets", "area [mm²]", "components", "loops"
    );
    let line = |Row { name, id, facets, area, components, loops }: &Row| {
        let area = 1e6 * area;
        format!("{name:width$}  {id:>3}  {facets:>7}  {area:>12.3}  {components:>10}  {loops:>5}\n")
    };
    rows.iter().map(line).fold(head, |table, line| table + &line)
}

/// Volumes with their tetrahedra, where there are any.
fn of_volumes(mesh: &TetMesh, Volumes { names, of }: &Volumes) -> String {
    let line = |(i, name): (usize, &String)| {
        let own = (0..of.len()).filter(|&t| of[t] == i).map(|t| {
            let [a, b, c, d] = mesh.corners(t);
            measure::tet_volume(a, b, c, d)
        });
        let (count, size) = own.fold((0, 0.0), |(n, sum), volume| (n + 1, sum + volume));
        format!("volume {name}: {count} tetrahedra, {:.3} mm³\n", 1e9 * size)
    };
    names.iter().enumerate().map(line).collect()
}
