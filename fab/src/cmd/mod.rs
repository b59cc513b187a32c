//! The verbs, one per file.

pub mod mold;
pub mod plan;
mod proof;
pub mod schema;
pub mod verify;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use clap::Subcommand;
use geometry::MM;
use mesh::Vec3;
use mesh::io::{IoError, MshFile, read_tets};
use mesh::measure::volume;
use program::schema::SchemaArguments;
use program::{Changes, InputFile};

use crate::body::boundary::Boundary;
use crate::body::collar::{self, Collar};
use crate::body::files::{Body, BodyFiles};
use crate::body::layer::Layer;
use crate::body::source::{CastPart, Input};
use crate::body::thread::Thread;
use crate::config::{Casts, Config};

use crate::plan::{Plan, Refused};

/// What `fab` can do.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Tagged volume mesh → printable mold parts and mold.json
    Mold(mold::Args),
    /// Tagged volume mesh → how it is to be molded, and why (plan.json)
    Plan(Task),
    /// Read a mold back from its files and prove it right
    Verify(verify::Args),
    /// The JSON Schema of a file that this program reads, for editors and other programs
    Schema(SchemaArguments),
}

/// What is to be molded, and where to.
#[derive(Debug, clap::Args)]
pub struct Task {
    /// Tagged tetrahedral mesh (.msh) [m]
    pub mesh: PathBuf,
    /// What is asked for (mold.toml); without it, what is measured decides
    #[arg(long)]
    pub config: Option<PathBuf>,
    /// Folder for what is made
    #[arg(short, long)]
    pub output: PathBuf,
    /// Surface that the mesh was made from (model.stl) [m]: it is cast in place of the boundary of the
    /// tetrahedra, with the regions in the folder `patches` beside it
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Leave out the pictures, which take most of the time
    #[arg(long)]
    pub no_pictures: bool,
    /// The mesh as modelled, if the shape of the body was designed since: what did not move is cast as in the model
    #[arg(long, value_name = "MODELLED", requires = "model")]
    pub from: Option<PathBuf>,
    /// What is asked for instead
    #[command(flatten)]
    pub changes: Changes,
}

/// How a task is to be done.
pub struct Planned {
    /// What was asked for.
    pub config: Config,
    /// The body.
    pub boundary: Boundary,
    /// The choices.
    pub plan: Plan,
    /// Around its inlets.
    pub collars: Vec<Collar>,
    /// Sheets that are laid in.
    pub layers: Vec<Layer>,
    /// Threads that are wound on it.
    pub threads: Vec<Thread>,
    /// Where they run [m].
    pub lines: Vec<Vec<Vec3>>,
    /// The mesh with its tags.
    pub file: MshFile,
    /// Volume of what lies in the mold already [mm³].
    pub inside: f64,
}

impl Task {
    /// Measures the body and makes the choices.
    pub fn plan(&self) -> Result<Planned> {
        let config = Config::read(self.config.as_deref(), &self.changes.set)?;
        let (model, modelled) = (self.model.as_deref(), self.from.as_deref());
        let files = BodyFiles { mesh: &self.mesh, model, modelled };
        let Body { boundary, file } = files.read(&config.chamber, config.surface)?;
        let layer = |tag: &String| Layer::find(&file, tag).map_err(|message| anyhow!(message));
        let layers = self.named(config.layers.iter().map(layer).collect::<Result<_>>())?;
        let threads = self.named(self.threads(&config))?;
        let lines = self.named(self.lines(&config))?;
        let inside = self.named(self.inside(&config))?;
        log::debug!("measuring a body of {} triangles", boundary.cast.triangles.len());
        let (boundary, collars) = self.named(collar::fit(boundary, &config))?;
        let plan = self.choose(&boundary, &config, &[])?;
        if let Some(weight) = &plan.report.weight {
            log::info!("the finished cast weighs {}", weight.in_words());
        }
        Ok(Planned { config, boundary, plan, collars, layers, threads, lines, file, inside })
    }

    /// The threads that are wound on the casting.
    fn threads(&self, config: &Config) -> Result<Vec<Thread>> {
        config.wound.as_ref().map_or(Ok(Vec::new()), |report| Thread::read(&self.beside(report)))
    }

    /// Where they run, if they get a groove [m].
    fn lines(&self, config: &Config) -> Result<Vec<Vec<Vec3>>> {
        let report = config.wound.as_ref().filter(|_| config.groove.is_some());
        report.map_or(Ok(Vec::new()), |report| Thread::lines(&self.beside(report)))
    }

    /// Volume of what lies in the mold already [mm³].
    fn inside(&self, config: &Config) -> Result<f64> {
        let Some(mesh) = &config.around else { return Ok(0.0) };
        let mesh = read_tets(&self.beside(mesh)).context("around")?.mesh;
        Ok(volume(&mesh) * MM.powi(3))
    }

    /// A path from the folder of the configuration.
    fn beside(&self, path: &Path) -> PathBuf {
        let folder = self.config.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        folder.join(path)
    }

    /// The choices, without methods that were tried.
    fn choose(&self, boundary: &Boundary, config: &Config, refused: &[Refused]) -> Result<Plan> {
        let input = self.input(&self.output, config, CastPart::Whole, boundary.casts)?;
        let plan = self.named(Plan::new(boundary, config, input, refused))?;
        log::info!("{}: {}", plan.report.method, plan.report.reason);
        Ok(plan)
    }

    /// The mesh, of which a part and a surface are cast, as a report in `folder` names it.
    pub fn input(
        &self,
        folder: &Path,
        config: &Config,
        part: CastPart,
        surface: Casts,
    ) -> Result<Input, IoError> {
        let named = |path: &PathBuf| InputFile::new(path, folder);
        let InputFile { path, sha256 } = named(&self.mesh)?;
        let model = self.model.as_ref().map(named).transpose()?;
        let modelled = self.from.as_ref().map(named).transpose()?;
        Ok(Input { path, sha256, chamber: config.chamber.clone(), part, surface, model, modelled })
    }

    /// A result whose error names the mesh.
    pub fn named<T, E>(&self, result: Result<T, E>) -> Result<T>
    where
        Result<T, E>: Context<T, E>,
    {
        result.with_context(|| self.mesh.display().to_string())
    }
}

impl Verb {
    /// Runs the verb.
    pub fn run(&self) -> Result<()> {
        match self {
            Self::Mold(args) => mold::run(args),
            Self::Plan(task) => plan::run(task),
            Self::Verify(args) => verify::run(args),
            Self::Schema(args) => args.print(schema::FORMATS),
        }
    }
}
