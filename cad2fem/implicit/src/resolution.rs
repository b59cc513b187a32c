//! Whether a grid resolves a model: its thin primitives, its walls, and how its surface bends.

use anyhow::Result;
use mesh::measure::enclosed_volume;
use mesh::topology::boundary_loops;
use mesh::{SurfaceMesh, Vec3, walls};

use super::model::Model;
use super::skin::{Part, Skin};
use super::{Field, Fields};

/// Cells of the lattice across the thinnest primitive, at least.
const ACROSS: f64 = 2.0;

/// Part of the volume of a set that its triangles may leave out without a warning: what a ball with
/// four cells across loses.
const LEFT_OUT: f64 = 0.05;

/// Step of the differences that give normals [grid].
const STEP: f64 = 1e-4;

/// The grid, or a finer one if a primitive is too thin for it [unit].
pub fn resolved(model: &Model) -> Result<f64> {
    let bodies = model.solid.iter().chain(&model.cavity).filter(|p| p.is_body());
    let thin = bodies.filter_map(|p| Some((p.shape.thickness()?, &p.name)));
    let Some((thickness, name)) = thin.min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return Ok(model.grid);
    };
    let grid = thickness / ACROSS;
    if grid >= model.grid {
        return Ok(model.grid);
    }
    model.require_cells(grid).map_err(|error| {
        error.context(format!(
            "{name:?} is {thickness:.4} {} thin, and a grid of {} passes over it",
            model.unit.symbol(),
            model.grid
        ))
    })?;
    log::warn!(
        "{name:?} is {thickness:.4} {} thin: a grid of {grid:.4} is used in place of {}",
        model.unit.symbol(),
        model.grid
    );
    Ok(grid)
}

/// Says where the thinnest wall is, and which grid would do if it is thinner than the grid.
pub fn remark_on_walls(model: &Model, fields: &Fields, skin: &Skin, grid: f64) {
    let (metres, unit) = (model.unit.metres(), model.unit.symbol());
    let normal = |(t, part): (usize, &Part)| {
        let p = skin.surface.centroid(t) / metres;
        match part {
            Part::Outside => fields.solid.outward(&p, STEP * grid),
            Part::Cavity => -fields.cavity.outward(&p, STEP * grid),
            Part::Cut(cut) => Vec3::from(model.cut[*cut].normal).normalize(),
        }
    };
    let normals: Vec<Vec3> = skin.part.iter().enumerate().map(normal).collect();
    let Some((thickness, at)) = walls::thinnest_along(&skin.surface, &normals) else { return };
    let (thickness, at) = (thickness / metres, at / metres);
    let place = format!("({:.4}, {:.4}, {:.4})", at.x, at.y, at.z);
    if thickness < grid {
        log::warn!(
            "the thinnest wall, at {place}, has {thickness:.4} {unit}, less than the grid of {grid:.4}: its \
             shape is rough; grid = {thickness:.4} resolves it"
        );
    } else {
        log::info!("the thinnest wall has {thickness:.4} {unit}, at {place}");
    }
}

/// Says where the grid is too coarse for how a surface bends, and which grid would do.
pub fn remark_on_chords(model: &Model, fields: &Fields, skin: &Skin, grid: f64) {
    for (set, part, field) in
        [("solid", Part::Outside, &fields.solid), ("cavity", Part::Cavity, &fields.cavity)]
    {
        let left_out = left_out(skin, part, field, model.unit.metres());
        if left_out > LEFT_OUT {
            log::warn!(
                "a grid of {grid:.4} {} cuts corners: {:.0} % of the volume of the {set} lies between \
                 its triangles and its surface; grid = {:.4} would leave out at most {:.0} %",
                model.unit.symbol(),
                100.0 * left_out,
                grid * (LEFT_OUT / left_out).sqrt(),
                100.0 * LEFT_OUT
            );
        }
    }
}

/// The volume between the triangles of a part and its surface, where `field` is zero, over the volume
/// that the part encloses, its openings closed. A field is a distance to first order, and zero at the
/// corners of a triangle: the mean of the distances at the middles of its edges is exact to second
/// order. It falls with the square of the grid.
fn left_out(skin: &Skin, part: Part, field: &Field, metres: f64) -> f64 {
    let chosen = skin.surface.triangles.iter().zip(&skin.part).filter(|(_, p)| **p == part);
    let mut triangles: Vec<[usize; 3]> = chosen.map(|(t, _)| *t).collect();
    let mut surface = SurfaceMesh { vertices: skin.surface.vertices.clone(), triangles };
    surface.vertices.iter_mut().for_each(|v| *v /= metres);
    let beside = |t: usize| {
        let [a, b, c] = surface.corners(t);
        let mean =
            [a + b, b + c, c + a].map(|sum| field.at(&(sum / 2.0))).iter().sum::<f64>() / 3.0;
        surface.area(t) * mean.abs()
    };
    let volume = (0..surface.triangles.len()).map(beside).sum::<f64>();
    triangles = std::mem::take(&mut surface.triangles);
    for rim in boundary_loops(&triangles) {
        let middle = rim.iter().map(|&v| surface.vertices[v]).sum::<Vec3>() / rim.len() as f64;
        let hub = surface.vertices.len();
        surface.vertices.push(middle);
        triangles.extend((0..rim.len()).map(|i| [rim[(i + 1) % rim.len()], rim[i], hub]));
    }
    let closed = SurfaceMesh { vertices: surface.vertices, triangles };
    let enclosed = enclosed_volume(&closed).abs();
    if enclosed > 0.0 { volume / enclosed } else { 0.0 }
}
