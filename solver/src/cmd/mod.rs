//! The verbs of `solver`.

mod calibrate;
mod carry;
mod check;
mod compare;
mod design;
mod export;
mod fit;
mod gradient;
mod import;
mod list;
mod map;
mod mirror;
mod optimize;
mod plot;
pub mod schema;
mod simulate;
mod validate;

use std::path::PathBuf;

use anyhow::Result;
use clap::Subcommand;
use clap::builder::RangedU64ValueParser;
use program::Changes;
use program::schema::SchemaArguments;
use scene::Scene;

use ::design::Problem;

/// What `solver` can do.
#[derive(Subcommand)]
#[allow(missing_docs)] // the arguments of each verb say what it does
pub enum Verb {
    Simulate(simulate::Arguments),
    Design(design::Arguments),
    Optimize(optimize::Arguments),
    Carry(carry::Arguments),
    Check(check::Arguments),
    Gradient(gradient::Arguments),
    List(list::Arguments),
    Map(map::Arguments),
    Export(export::Arguments),
    Fit(fit::Arguments),
    Compare(compare::Arguments),
    Plot(plot::Arguments),
    Import(import::Arguments),
    Calibrate(calibrate::Arguments),
    Validate(validate::Arguments),
    Mirror(mirror::Arguments),
    Schema(SchemaArguments),
}

impl Verb {
    /// Does it.
    pub fn run(&self) -> Result<()> {
        match self {
            Self::Simulate(arguments) => simulate::run(arguments),
            Self::Design(arguments) => design::run(arguments),
            Self::Optimize(arguments) => optimize::run(arguments),
            Self::Carry(arguments) => carry::run(arguments),
            Self::Check(arguments) => check::run(arguments),
            Self::Gradient(arguments) => gradient::run(arguments),
            Self::List(arguments) => list::run(arguments),
            Self::Map(arguments) => map::run(arguments),
            Self::Export(arguments) => export::run(arguments),
            Self::Fit(arguments) => fit::run(arguments),
            Self::Compare(arguments) => compare::run(arguments),
            Self::Plot(arguments) => plot::run(arguments),
            Self::Import(arguments) => import::run(arguments),
            Self::Calibrate(arguments) => calibrate::run(arguments),
            Self::Validate(arguments) => validate::run(arguments),
            Self::Mirror(arguments) => mirror::run(arguments),
            Self::Schema(arguments) => arguments.print(schema::FORMATS),
        }
    }
}

/// A mesh in place of a scene's, and the name of its body if there are several.
type OtherMesh = (Option<String>, PathBuf);

/// A scene with what is other in it.
#[derive(clap::Args)]
struct SceneArguments {
    /// The scene
    scene: PathBuf,
    /// Another tagged mesh in place of the scene's
    #[arg(long, value_parser = other_mesh)]
    mesh: Vec<OtherMesh>,
    /// Another degree of the displacement in place of the scene's: 1, 2 or 3
    #[arg(long, value_parser = RangedU64ValueParser::<usize>::new().range(1..=3))]
    degree: Option<usize>,
    #[command(flatten)]
    changes: Changes,
}

impl SceneArguments {
    fn read(&self) -> Result<Scene> {
        let mut scene = Scene::read_with(&self.scene, &self.mesh, &self.changes.set)?;
        scene.config.degree = self.degree.unwrap_or(scene.config.degree);
        Ok(scene)
    }
}

/// What the states of a scene depend on: the scene, the changes to it, its meshes and its obstacles.
fn hash_inputs(scene: &Scene) -> Result<String> {
    let step = scene.config.solver.largest_load_step();
    let mut hashes = vec![scene.file.hash(), scene.config.degree.to_string(), step.to_string()];
    let obstacles = scene.config.obstacle.iter();
    let obstacles = obstacles.map(|own| scene::config::beside(&scene.path, &own.surface));
    for path in scene.parts.iter().map(|part| part.mesh_path.clone()).chain(obstacles) {
        hashes.push(program::sha256_file(&path)?);
    }
    Ok(hashes.join(" "))
}

/// A design problem at one shape.
#[derive(clap::Args)]
struct DesignArguments {
    /// The design problem
    design: PathBuf,
    /// At this tagged mesh, such as an optimised design.msh, in place of the scene's
    #[arg(long, value_parser = other_mesh)]
    mesh: Vec<OtherMesh>,
    #[command(flatten)]
    changes: Changes,
}

impl DesignArguments {
    fn read(&self) -> Result<Problem> {
        Problem::read(&self.design, &self.mesh, &self.changes)
    }
}

/// `path`, or `body=path`.
fn other_mesh(text: &str) -> Result<OtherMesh, String> {
    match text.split_once('=') {
        Some((body, path)) if !body.is_empty() && !path.is_empty() => {
            Ok((Some(body.to_owned()), PathBuf::from(path)))
        }
        Some(_) => Err("expected a path, or body=path".to_owned()),
        None => Ok((None, PathBuf::from(text))),
    }
}
