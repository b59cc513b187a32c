//! The checkpoint: everything that an interrupted optimisation needs to continue as if it
//! had not been interrupted.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use mesh::io::npy;
use reports::{Castable, Ended, LevelEnd};
use serde::{Deserialize, Serialize};
use variables::step::{Lbfgs, TrustRegion};

use super::Run;
use super::bounds::BoundRow;
use super::ending::{Rejections, at_the_last};

/// The state after an accepted iteration. Numbers are written so that they are
/// read back bit for bit.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Hash of the program's inputs; another hash is another problem.
    pub inputs: String,
    /// Index of the level.
    pub level: usize,
    /// Accepted iterations within the level.
    pub iteration: usize,
    /// The iteration at which the mesh was made: 0, that of the level, or one that flat elements
    /// have held back.
    pub meshed_at: usize,
    /// Flat elements hold back the iterations: a new mesh is to follow.
    pub flat: bool,
    /// Design variables of the level; empty before the level's first solve.
    pub theta: Vec<f64>,
    /// Before the level's first solve the times of states that it is next to [s], one scenario
    /// after the other, or none. The displacements lie in a file ([`Self::read_start`]).
    pub start: Vec<f64>,
    /// Designed loads at the start of the level, as [`DesignMap::loads`](variables::DesignMap::loads) has them; none in the
    /// first.
    pub loads: Vec<f64>,
    /// Weighted terms at θ.
    pub terms: BTreeMap<String, f64>,
    /// Weighted terms at the start of the level.
    pub first_terms: BTreeMap<String, f64>,
    /// Weights of the terms in all levels; none before the first solve.
    pub weights: Vec<f64>,
    /// Gradient at θ.
    pub gradient: Vec<f64>,
    /// Norm of the gradient at the start of the level.
    pub first_gradient: f64,
    /// Computing time of the level so far [s].
    pub spent_s: f64,
    /// Computing time of all levels so far [s].
    pub total_s: f64,
    /// Memory of the optimiser.
    pub lbfgs: Lbfgs,
    /// Model of the objective, and how far it is trusted.
    pub region: TrustRegion,
    /// Lines that history.jsonl has at this point, ...
    pub history: usize,
    /// ... and their SHA-256; empty without any.
    pub lines: String,
    /// SHA-256 of the files that the level reads and of the meshes of those before, by their names.
    pub files: BTreeMap<String, String>,
    /// How the level ended before its iterations did, and why.
    pub ending: Option<(Ended, String)>,
    /// How the levels before this one ended.
    pub endings_before: Vec<LevelEnd>,
    /// Iterations that gained little, one after the other, up to now.
    pub quiet: usize,
    /// Trials that were rejected in these.
    pub quiet_rejections: usize,
    /// Part by which the last iteration lowered the objective [1].
    pub last_fall: f64,
    /// What was tried in the level and not taken.
    pub rejections: Rejections,
    /// What a unit of each constraint is worth, by their order: what the objective would fall by.
    pub multipliers: Vec<f64>,
    /// The bounds of the runs at θ.
    pub bounds: Vec<BoundRow>,
    /// What a violation of each bound costs, in the unit of the objective over that of the bound.
    pub penalties: Vec<f64>,
    /// φ at the start of the design: what is far below it is nothing.
    pub first_merit: f64,
    /// Whether the start of the design did not keep its bounds.
    pub began_outside: bool,
    /// φ at the start of the level.
    pub merit_of_level: f64,
    /// φ at θ.
    pub merit: f64,
    /// What `fab plan` says of the shape at θ, where it is asked.
    pub mold: Option<Castable>,
}

impl Checkpoint {
    /// Before the first solve of the first level.
    pub fn new(inputs: String) -> Self {
        Self { inputs, merit: f64::MAX, ..Self::default() }
    }

    /// Before the first solve of the level after this one.
    pub fn next_level(mut self, loads: Vec<f64>) -> Self {
        let endings_before = self.all_endings();
        // The meshes of the levels before stay in the folder, as a part of the result.
        self.files.retain(|name, _| !is_run(name));
        Self {
            level: self.level + 1,
            total_s: self.total_s,
            history: self.history,
            lines: self.lines,
            weights: self.weights,
            files: self.files,
            loads,
            endings_before,
            mold: self.mold,
            penalties: self.penalties,
            first_merit: self.first_merit,
            began_outside: self.began_outside,
            region: self.region.without_model(),
            ..Self::new(self.inputs)
        }
    }

    /// Before the first solve of the same level on a new mesh of the same shape.
    pub fn on_new_mesh(mut self, loads: Vec<f64>) -> Self {
        self.files.retain(|name, _| !is_run(name));
        Self {
            meshed_at: self.iteration,
            flat: false,
            theta: Vec::new(),
            start: Vec::new(),
            loads,
            lbfgs: Lbfgs::default(),
            region: self.region.without_model(),
            ..self
        }
    }

    /// How this level ended, at the latest.
    pub fn end(&self) -> LevelEnd {
        let level = self.level + 1;
        let mut end = match &self.ending {
            Some((ending, why)) => LevelEnd { level, ending: *ending, why: why.clone() },
            None => at_the_last(level, self.last_fall),
        };
        if let (Some(said), false) = (self.rejections.describe(), end.ending == Ended::Converged) {
            end.why = format!("{}; {said}", end.why);
        }
        end
    }

    /// How the levels up to this one ended.
    pub fn all_endings(&self) -> Vec<LevelEnd> {
        self.endings_before.iter().cloned().chain([self.end()]).collect()
    }

    /// Whether the shape is another than that of the mesh.
    pub fn has_moved(&self) -> bool {
        self.iteration > self.meshed_at
    }

    /// Counts computing time [s].
    pub fn spend(&mut self, seconds: f64) {
        self.spent_s += seconds;
        self.total_s += seconds;
    }

    fn path(folder: &Path) -> PathBuf {
        folder.join("checkpoint.json")
    }

    /// Reads the checkpoint of a folder; none when the folder has none.
    pub fn read(folder: &Path) -> Result<Option<Self>> {
        let path = Self::path(folder);
        if !path.exists() {
            return Ok(None);
        }
        program::read_checkpoint(&path, scene::PROGRAM).map(Some)
    }

    fn states_path(&self, folder: &Path, of: impl Display) -> PathBuf {
        let Self { level, meshed_at, .. } = self;
        let mesh = if *meshed_at == 0 { String::new() } else { format!("-{meshed_at}") };
        folder.join(format!("run-{}{mesh}-{of}.npy", level + 1))
    }

    fn run_path(&self, folder: &Path) -> PathBuf {
        self.states_path(folder, self.iteration)
    }

    /// Puts displacements at times [s, m] on disk, next to which the level's first runs are.
    pub fn write_start(&mut self, folder: &Path, states: &[(f64, Vec<f64>)]) -> Result<()> {
        let path = self.states_path(folder, "start");
        let shape = [states.len(), states.first().map_or(0, |(_, u)| u.len())];
        npy::write_rows(&path, shape, states.iter().map(|(_, u)| u))?;
        self.start = states.iter().map(|(time, _)| *time).collect();
        self.add_file(&path)
    }

    /// The displacements of [`Self::write_start`] [m].
    pub fn read_start(&self, folder: &Path) -> Result<npy::Rows> {
        Ok(npy::read_rows(&self.states_path(folder, "start"))?)
    }

    /// Displacements at the ends of the time steps of the accepted runs, one scenario after
    /// the other [m].
    pub fn read_runs(&self, folder: &Path) -> Result<npy::Rows> {
        Ok(npy::read_rows(&self.run_path(folder))?)
    }

    /// Writes the checkpoint of a folder with the runs that it belongs to, and then
    /// removes those of the one before.
    pub fn write_with_runs(&mut self, folder: &Path, runs: &[Run]) -> Result<()> {
        let path = self.run_path(folder);
        let steps: usize = runs.iter().map(|run| run.states.steps()).sum();
        let dofs = runs.first().map_or(0, |run| run.states.last().len());
        let displacements = runs.iter().flat_map(|run| run.states.displacements());
        npy::write_rows(&path, [steps, dofs], displacements)?;
        self.files.retain(|name, _| !is_run(name));
        self.add_file(&path)?;
        self.write(folder)?;
        self.remove_other_runs(folder)
    }

    /// Removes runs that it does not belong to, as a kill may leave them.
    pub fn remove_other_runs(&self, folder: &Path) -> Result<()> {
        for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
            let other = entry?.path();
            let name = name_of(&other);
            if is_run(&name) && !self.files.contains_key(&name) {
                mesh::io::remove_output(&other)?;
            }
        }
        Ok(())
    }

    /// Remembers a file as it is now.
    pub fn add_file(&mut self, path: &Path) -> Result<()> {
        self.files.insert(name_of(path), program::sha256_file(path)?);
        Ok(())
    }

    /// Makes sure that all files are as they were when the checkpoint was written.
    pub fn check_files(&self, folder: &Path) -> Result<()> {
        let mut files = self.files.iter();
        files.try_for_each(|(name, hash)| program::check_unaltered(&folder.join(name), hash))
    }

    /// Makes sure that it belongs to these inputs.
    pub fn check_inputs(&self, folder: &Path, inputs: &str) -> Result<()> {
        ensure!(
            self.inputs == inputs,
            "{}: level {}, iteration {} of another problem (scene, design, mesh or target have \
             changed)\n  to start over with --restart, or another output folder",
            Self::path(folder).display(),
            self.level + 1,
            self.iteration
        );
        Ok(())
    }

    /// Writes the checkpoint of a folder.
    pub fn write(&self, folder: &Path) -> Result<()> {
        program::write_checkpoint(&Self::path(folder), scene::PROGRAM, self)
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// Whether a file of this name holds the states of a run.
fn is_run(name: &str) -> bool {
    name.starts_with("run-") && name.ends_with(".npy")
}
