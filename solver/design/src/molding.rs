//! How the shapes of a design can be cast: what `fab plan` says of them.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail, ensure};
use mechanics::body::Body;
use mesh::{Tags, TetMesh};
use program::{KeyPath, Process, misfit};
use reports::Castable;
use scene::config::{DesignConfig, beside};
use serde::Deserialize;
use tempfile::TempDir;

use run::report::mirror::mirror_body;

/// Name of the mesh as modelled.
const MODELLED: &str = "modelled.msh";
/// Exit code of a plan whose file is wrong, or asks for what the body does not have.
const WRONG: i32 = 2;

/// Asks `fab plan`, which runs as a program of its own.
pub struct Molding {
    config: PathBuf,
    /// The part of the body that is cast.
    part: usize,
    /// Whether shapes that cannot be cast are rejected.
    pub required: bool,
    /// The surface that the mesh was made from, and a folder with the mesh as modelled.
    modelled: Option<(PathBuf, TempDir)>,
}

impl Molding {
    /// As a design asks for it, if it does; `path` is its file, and `body` the shape at the start.
    pub fn new(path: &Path, design: &DesignConfig, body: &Body) -> Result<Option<Self>> {
        let Some(mold) = &design.mold else { return Ok(None) };
        let config = beside(path, &mold.config);
        let key = |key: &str| KeyPath::table("mold").key(key);
        ensure!(
            config.exists(),
            key("config").told(format!("[mold] config: {}: no such file", config.display()))
        );
        let names: Vec<&str> = body.parts.iter().filter_map(|part| part.name.as_deref()).collect();
        let known = names.join(", ");
        let part = match &mold.body {
            None if body.parts.len() == 1 => 0,
            None => bail!(misfit!(KeyPath::table("mold"), " needs body = ..., one of {known}")),
            Some(name) => names.iter().position(|other| other == name).ok_or_else(|| {
                let what = format!("[mold] body: there is no \"{name}\", only {known}");
                key("body").told(what)
            })?,
        };
        let required = match mold.required {
            Some(required) => required,
            None => names_a_method(&config)?,
        };
        let mut molding = Self { config, part, required, modelled: None };
        if let Some(model) = &mold.model {
            let (folder, model) = (tempfile::tempdir()?, beside(path, model));
            ensure!(
                model.exists(),
                key("model").told(format!("[mold] model: {}: no such file", model.display()))
            );
            let (mesh, tags) = molding.whole(body)?;
            mesh::io::write_tets(&folder.path().join(MODELLED), &mesh, &tags)?;
            molding.modelled = Some((model, folder));
        }
        if let Err((said, code)) = molding.plan(body)?
            && (code == Some(WRONG) || required)
        {
            let config = molding.config.display();
            let what =
                if code == Some(WRONG) { "" } else { "the shape at the start cannot be cast: " };
            bail!(
                key("config")
                    .told(format!("[mold] config: fab plan --config {config}: {what}{said}"))
            );
        }
        Ok(Some(molding))
    }

    /// The verdict on a shape.
    pub fn ask(&self, shape: &Body) -> Result<Castable> {
        Ok(self.plan(shape)?.unwrap_or_else(|(refused, _)| Castable::Refused { refused }))
    }

    /// The verdict, or what `fab plan` said with its exit code.
    fn plan(&self, shape: &Body) -> Result<Result<Castable, (String, Option<i32>)>> {
        let folder = tempfile::tempdir()?;
        let (mesh, tags) = self.whole(shape)?;
        let file = folder.path().join("shape.msh");
        mesh::io::write_tets(&file, &mesh, &tags)?;
        let plan = folder.path().join("plan");
        let mut command = Command::new(program::beside("fab"));
        command.arg("-q").arg("plan").arg(&file).arg("--config").arg(&self.config);
        if let Some((model, folder)) = &self.modelled {
            command.arg("--model").arg(model).arg("--from").arg(folder.path().join(MODELLED));
        }
        command
            .arg("--no-pictures")
            .arg("--output")
            .arg(&plan)
            .stdin(Stdio::null())
            .stderr(Stdio::piped());
        let process = Process::spawn(&mut command)
            .context("fab, which plans molds: it should lie beside solver, or on the PATH")?;
        let mut said = String::new();
        if let Some(mut stderr) = process.take_stderr() {
            stderr.read_to_string(&mut said)?;
        }
        let status = process.wait()?;
        if status.success() {
            return verdict(&plan.join("plan.json")).map(Ok);
        }
        let said = said.trim().trim_start_matches("fab: ");
        Ok(Err((said.replace(&format!("{}: ", file.display()), ""), status.code())))
    }

    /// The body that is cast, without symmetry.
    fn whole(&self, shape: &Body) -> Result<(TetMesh, Tags)> {
        let (name, mut mesh, mut tags) = shape.separate().swap_remove(self.part);
        let prefix = name.map_or_else(String::new, |name| format!("{name}."));
        for cut in shape.cuts() {
            let own: Vec<String> =
                cut.iter().filter_map(|tag| tag.strip_prefix(&prefix)).map(str::to_owned).collect();
            if !own.is_empty() {
                let body = Body::new(mesh, tags).cut_by(&[own])?;
                (mesh, tags) = mirror_body(&body.mesh, &body.tags, &body.planes[0]);
            }
        }
        Ok((mesh, tags))
    }
}

/// Whether a mold's file names the method, so that others are not wanted.
fn names_a_method(config: &Path) -> Result<bool> {
    let text = mesh::io::read_own_text(config)?;
    let table: toml::Table = toml::from_str(&text).with_context(|| config.display().to_string())?;
    Ok(table.contains_key("method"))
}

/// What is read of a plan.
#[derive(Deserialize)]
struct Plan {
    method: String,
    reason: String,
    measures: Vec<Measure>,
}

#[derive(Deserialize)]
struct Measure {
    name: String,
    value: Option<f64>,
}

/// What a plan says, in short.
fn verdict(path: &Path) -> Result<Castable> {
    let plan = serde_json::from_str(&mesh::io::read_own_text(path)?);
    let Plan { method, reason, measures } = plan.with_context(|| path.display().to_string())?;
    let measures = measures.into_iter().map(|measure| (measure.name, measure.value)).collect();
    Ok(Castable::Planned { method, reason, measures })
}

/// Says how a shape can be cast where that differs from what was `before`.
pub fn say(now: &Castable, before: Option<&Castable>) {
    match (now, before) {
        (Castable::Refused { .. }, Some(Castable::Refused { .. })) => {}
        (Castable::Refused { refused }, _) => {
            log::warn!("fab plan: this shape cannot be cast: {refused}");
        }
        (Castable::Planned { method, .. }, Some(Castable::Planned { method: same, .. }))
            if method == same => {}
        (Castable::Planned { method, reason, .. }, _) => {
            log::info!("fab plan: {method}: {reason}");
        }
    }
}
