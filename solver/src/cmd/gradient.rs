//! `solver gradient`: the shape gradient (sensitivities) of an objective as a picture.

use std::path::PathBuf;

use anyhow::Result;
use mechanics::element::FunctionSpace;
use mechanics::math::linear::sum;
use mesh::io::vtu;
use program::FolderLock;
use serde_json::json;

use super::DesignArguments;
use design::Derivative;
use run::report::results;

/// Write the gradient of a design problem for ParaView
///
/// Writes to the output folder: gradient.vtu, the body at rest with dJ/dX of each
/// vertex [1/m of J] as it is and with the interior following the boundary, and
/// gradient.json with the terms, dJ by the variables of the shape, and dJ by each number of the scene,
/// such as a pressure, a modulus or the friction, with path and unit.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    of: DesignArguments,
    /// Folder for the results; made if missing
    #[arg(short, long)]
    output: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let problem = arguments.of.read()?;
    let objectives = problem.objectives()?;
    let (level, at) = problem.start(&objectives, &problem.design.levels()[0])?;
    let theta = vec![0.0; level.variables()];
    let swept = level.sweep(&at, None)?;
    let by_rest = sum(swept.iter().map(|by| &by.rest));
    let on_boundary = level.map.on_boundary(&by_rest);
    let field = |name: &str, values: Vec<f64>| vtu::Field::new(name, "1/m", 3, values);
    let mesh = &level.body.mesh;
    let space = FunctionSpace::new(1, mesh.vertices.len(), mesh.tets.clone());
    let mut grid = results::grid(&space, &mesh.vertices, &vec![0.0; 3 * mesh.vertices.len()]);
    grid.point_fields =
        vec![field("gradient", on_boundary), field("gradient_of_each_vertex", by_rest)];
    let folder = &arguments.output;
    let _lock = FolderLock::new(folder)?;
    vtu::write_vtu(&folder.join("gradient.vtu"), &grid)?;
    let by_shape = level.vjp(&theta, &swept)[..level.map.shape_variables()].to_vec();
    let report = json!({
        "program": scene::PROGRAM,
        "objective": at.objective,
        "terms": at.terms,
        "shape": {"derivative": by_shape, "unit": "1/m"},
        "numbers": Derivative::of(&problem, &level, &swept),
    });
    program::write_json(&folder.join("gradient.json"), &report)
}
