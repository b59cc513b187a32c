//! Thinnest walls of bodies, as `fab` left them in `plan.json`.

use mesh::Vec3;

use crate::reported::{Plan, ThinnestWall};
use crate::survey::Survey;

/// The thinnest wall of a body.
#[derive(Clone, Debug)]
pub struct Wall {
    /// Hash of the mesh of the body.
    sha256: String,
    /// How thick it is [m].
    pub thickness: f64,
    /// Where it begins, in the design [m].
    pub at: Vec3,
}

/// The walls of all plans of a page.
pub fn all(survey: &Survey) -> Vec<Wall> {
    survey.plans.iter().filter_map(of_plan).collect()
}

/// The wall of one of these meshes, and the number of the mesh.
pub fn of<'a>(walls: &'a [Wall], hashes: &[&str]) -> Option<(&'a Wall, usize)> {
    walls.iter().find_map(|wall| {
        let index = hashes.iter().position(|hash| *hash == wall.sha256)?;
        Some((wall, index))
    })
}

/// The wall of a plan, whose numbers are millimetres; none where it measured no wall.
fn of_plan(plan: &Plan) -> Option<Wall> {
    let ThinnestWall { thickness, at } = plan.wall.clone()?;
    let sha256 = plan.input.clone()?.sha256;
    Some(Wall { sha256, thickness: 1e-3 * thickness, at: 1e-3 * Vec3::from(at) })
}
