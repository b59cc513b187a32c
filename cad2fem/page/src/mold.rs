//! A mold: its parts and the cast where they are in the closed mold, and how each comes away.

use std::path::Path;

use anyhow::{Result, ensure};
use mesh::SurfaceMesh;
use mesh::bvh::SurfaceBvh;
use mesh::io::vtu::{CellType, Field, read_vtu};
use serde_json::{Value, json};

use crate::reported::{Mold, read};
use crate::store::Store;
use crate::survey::name;
use crate::wall::{self, Wall};

/// A place is on a cast from which it is no farther than this [mm]: files of molds are rounded, and a
/// mesh lies beside its model by its envelope.
const THERE: f64 = 0.5;

/// Parts of a mold [mm]; none if the folder has no `reference/assembly.vtu`.
pub fn packed(folder: &Path, walls: &[Wall], store: &mut Store) -> Result<Option<Value>> {
    let path = folder.join("reference/assembly.vtu");
    if !path.exists() {
        log::warn!("{}: missing, so that the page does not show this mold", path.display());
        return Ok(None);
    }
    let report: Mold = read(&folder.join("mold.json"))?;
    let grid = read_vtu(&path)?;
    let of = |fields: &[Field], name: &str| fields.iter().position(|f| f.name == name);
    let fields = (of(&grid.point_fields, "apart"), of(&grid.cell_fields, "part"));
    let (Some(apart), Some(part), CellType::Tri3) = (fields.0, fields.1, grid.cell_type) else {
        anyhow::bail!("{}: no triangles with the fields apart and part", path.display());
    };
    let (apart, part) = (&grid.point_fields[apart], &grid.cell_fields[part]);
    let fit = apart.components == 3 && part.components == 1;
    ensure!(fit, "{}: apart is no vector or part no number", path.display());
    // the last member is the cast, which is no part to print
    let named = &report.parts;
    let all = part.values.iter().all(|&p| (0.0..=named.len() as f64).contains(&p));
    ensure!(all, "{}: other parts than the {} of mold.json", path.display(), named.len());
    let triangles = grid.cells.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let all = SurfaceMesh { vertices: grid.points.clone(), triangles };
    let of_part = |i: usize| -> Vec<usize> {
        (0..part.values.len()).filter(|&t| part.values[t] as usize == i).collect()
    };
    let mut parts = Vec::new();
    for i in 0..=named.len() {
        let own = of_part(i);
        let Some(&first) = own.first() else { continue };
        let any = all.triangles[first][0];
        let surface = all.part(&own);
        let nodes: Vec<f64> = surface.vertices.iter().flatten().copied().collect();
        let corners: Vec<usize> = surface.triangles.iter().flatten().copied().collect();
        let known = named.get(i);
        parts.push(json!({
            "name": known.map_or("cast", |part| &part.name),
            "printed": known.is_some(),
            "apart": apart.values[3 * any..3 * any + 3],
            "nodes": store.numbers(&nodes, 3),
            "triangles": store.indices(&corners, 3),
        }));
    }
    let cast = all.part(&of_part(named.len()));
    let wall = wall_in(&cast, &report, walls);
    let (name, method) = (name(folder), &report.method);
    Ok(Some(json!({ "name": name, "method": method, "parts": parts, "wall": wall })))
}

/// The thinnest wall [m] of the body and its place in the closed mold [mm]; nothing if it lies in another
/// casting, or no plan tells of it.
fn wall_in(cast: &SurfaceMesh, mold: &Mold, walls: &[Wall]) -> Option<Value> {
    let (wall, _) = wall::of(walls, &[&mold.input.as_ref()?.sha256])?;
    let at = mold.in_mold(&wall.at)?;
    let is_there = SurfaceBvh::new(cast).closest(&at).distance < THERE;
    is_there.then(|| json!({ "thickness": wall.thickness, "at": at.as_slice() }))
}
