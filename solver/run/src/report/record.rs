//! What a run writes while it runs, so that nothing is lost when it is killed:
//! a line of `steps.jsonl`, a row of `curve.csv` and a picture per reported step, and the checkpoint.

use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use measure::probe::Probe;
use mechanics::energy::{Iterate, Nature};
use mechanics::forward::{LoadStep, Problem, Progress, Timings};
use mechanics::stability::ArcProgress;
use mesh::Vec3;
use mesh::io::vtu;
use reports::Step;
use scene::Scene;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::report::results::STEPS;
use crate::report::{curve, results, stability};

/// From which an interrupted run continues.
const CHECKPOINT: &str = "checkpoint.json";

/// A run that was interrupted after a time step, or a static one after a load step. Numbers are written so that they
/// are read back bit for bit.
#[derive(Serialize, Deserialize)]
pub struct Checkpoint {
    /// Hash of the program's inputs; another hash is another run.
    pub inputs: String,
    /// Reported steps done.
    pub steps: usize,
    /// All that determines the next step ...
    pub progress: Progress,
    /// ... of a path that is followed by its arc length, too, ...
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<ArcProgress>,
    /// ... with the pairs of nodes that contact couples.
    pub couplings: Vec<[usize; 2]>,
    /// Work of the loads so far.
    pub work: Work,
    /// Time spent so far.
    pub timings: Timings,
    /// Wall time from the first step on [s].
    pub elapsed_s: f64,
}

impl Checkpoint {
    /// The checkpoint of a folder, if there is one.
    pub fn read(folder: &Path, inputs: &str) -> Result<Option<Self>> {
        let path = folder.join(CHECKPOINT);
        if !path.exists() {
            return Ok(None);
        }
        let anew = "to start over with --restart, or another output folder";
        let found: Self = program::read_checkpoint(&path, scene::PROGRAM)?;
        ensure!(
            found.inputs == inputs,
            "{}: a run of another scene or mesh was interrupted here after {} steps\n  {anew}",
            path.display(),
            found.steps
        );
        Ok(Some(found))
    }

    /// Writes it to a folder.
    pub fn write(&self, folder: &Path) -> Result<()> {
        program::write_checkpoint(&folder.join(CHECKPOINT), scene::PROGRAM, self)
    }

    /// Takes it away from a folder.
    pub fn remove(folder: &Path) -> Result<()> {
        Ok(mesh::io::remove_output(&folder.join(CHECKPOINT))?)
    }
}

/// A time step that was computed, or a load step of a static scene.
pub struct Finished {
    /// The load steps, in order.
    pub steps: Vec<LoadStep>,
    /// Which of them are reported.
    pub reported: Range<usize>,
    /// Velocity at its end [m/s].
    pub velocity: Option<Vec<f64>>,
    /// From which the run continues if it is interrupted now, but for `work`, which the recorder knows.
    pub checkpoint: Option<Checkpoint>,
}

/// Measures the reported steps of a run, and writes them.
pub struct Recorder<'a> {
    scene: &'a Scene,
    problem: &'a Problem,
    probes: &'a [Probe],
    /// Where they are written, if they are.
    folder: Option<PathBuf>,
    /// Whether every step gets its picture.
    pictures: bool,
    /// The state at rest, where forces balance there.
    pub rest: Option<Step>,
    /// What was reported of each step.
    pub lines: Vec<Step>,
    work: Work,
    /// Kinetic energy at the start, where the energy is balanced.
    kinetic_at_start: Option<f64>,
}

impl<'a> Recorder<'a> {
    /// Begins with nothing, or after the first `done` lines of the folder.
    pub fn new(
        scene: &'a Scene,
        (problem, probes): (&'a Problem, &'a [Probe]),
        folder: &Path,
        pictures: bool,
        done: Option<&Checkpoint>,
    ) -> Result<Self> {
        let mut own = Self::measuring(scene, (problem, probes))?;
        if let Some(done) = done {
            own.work = done.work.clone();
            let path = folder.join(STEPS);
            let text = mesh::io::read_own_text(&path)?;
            let lines = text.lines().take(done.steps).map(serde_json::from_str);
            own.lines = lines
                .collect::<Result<_, _>>()
                .with_context(|| format!("{}: to start over with --restart", path.display()))?;
            ensure!(
                own.lines.len() == done.steps,
                "{}: not the {} lines that the checkpoint expects; to start over with --restart",
                path.display(),
                done.steps
            );
        }
        Ok(Self { folder: Some(folder.to_path_buf()), pictures, ..own })
    }

    /// Begins with nothing, and writes nothing.
    pub fn measuring(
        scene: &'a Scene,
        (problem, probes): (&'a Problem, &'a [Probe]),
    ) -> Result<Self> {
        Ok(Self {
            scene,
            problem,
            probes,
            folder: None,
            pictures: false,
            rest: results::at_rest(scene, problem, probes)?,
            lines: Vec::new(),
            work: Work::new(problem, &scene.body.mesh.vertices),
            kinetic_at_start: kinetic_at_start(scene, problem),
        })
    }

    /// Follows the work of the loads through all load steps, writes those that are reported,
    /// then the checkpoint.
    pub fn write(&mut self, finished: Finished) -> Result<()> {
        for (i, step) in finished.steps.iter().enumerate() {
            let at = step.iterate(self.problem, &self.scene.body.mesh.vertices);
            self.work.follow(self.problem, &at);
            if finished.reported.contains(&i) {
                self.record(step, finished.velocity.as_deref())?;
            }
        }
        let (Some(checkpoint), Some(folder)) = (finished.checkpoint, &self.folder) else {
            return Ok(());
        };
        Checkpoint { work: self.work.clone(), ..checkpoint }.write(folder)
    }

    /// Work of gas, dead loads and moving supports so far.
    pub fn work(&self) -> &Work {
        &self.work
    }

    /// Largest energy gain of all steps over the largest stored and kinetic energy of a step [1].
    pub fn largest_gain(&self) -> Option<f64> {
        let start = self.kinetic_at_start?;
        let gains =
            || self.lines.iter().filter_map(|line| Some((line.energy_gain?, line.work_of_loads)));
        let energy = gains().map(|(gain, work)| gain + work + start).fold(start, f64::max);
        let gain = gains().map(|(gain, _)| gain).fold(0.0, f64::max);
        (energy > 0.0).then_some(gain / energy)
    }

    /// Writes what is known of a step, which has the velocity `v` [m/s].
    fn record(&mut self, step: &LoadStep, v: Option<&[f64]>) -> Result<()> {
        let body = &self.scene.body;
        let measured = (self.probes, self.work.total);
        let mut line = results::step(self.scene, body, self.problem, step, v, measured)?;
        let at = step.iterate(self.problem, &body.mesh.vertices);
        if let Some(start) = self.kinetic_at_start {
            let internal = results::internal_energy(&self.problem.energies, &at);
            let energy = internal + line.energies["kinetic"];
            line.energy_gain = Some(energy - start - self.work.total);
        }
        self.lines.push(line);
        let Some(folder) = &self.folder else { return Ok(()) };
        if self.pictures {
            let mut grid = results::grid_with_fields(&self.problem.energies, &at);
            let mode = step.path.as_ref().map(|path| stability::field(&path.stability.mode));
            grid.point_fields.extend(mode);
            vtu::write_vtu(&folder.join(picture(self.lines.len() - 1)), &grid)?;
            // ParaView sorts by these: the load of a path falls and rises
            let order = |line: &Step| line.path.as_ref().map_or(line.t, |path| path.arc_length);
            let picture = |(i, line): (usize, &Step)| (order(line), picture(i));
            let all: Vec<_> = self.lines.iter().enumerate().map(picture).collect();
            vtu::write_pvd(&folder.join("result.pvd"), &all)?;
        }
        mesh::io::write_atomic(&folder.join(STEPS), |out| {
            self.lines.iter().try_for_each(|line| writeln!(out, "{}", json!(line)))
        })?;
        curve::write(folder, self.rest.iter().chain(&self.lines), self.probes)
    }
}

/// Kinetic energy at t = 0, of a scene with inertia whose obstacles stand still: the work of those that
/// move is not followed [J].
fn kinetic_at_start(scene: &Scene, problem: &Problem) -> Option<f64> {
    let balanced = scene.config.method().has_inertia()
        && scene.config.obstacle.iter().all(|obstacle| obstacle.displacement.is_zero());
    let start = || scene.integrator(&scene.body, problem).last().v.clone();
    let rest = &scene.body.mesh.vertices;
    balanced.then(|| results::kinetic_energy(&problem.energies, &problem.space, rest, &start()))
}

fn picture(step: usize) -> String {
    format!("step_{step:03}.vtu")
}

/// Work of gas, dead loads and moving supports along the load steps by the
/// trapezoidal rule [J]: second order in the load increment, so it meets the
/// elastic energy only roughly.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Work {
    /// Pairs of a force and the quantity it works on, at the last step: gas on
    /// volumes, dead loads and supports on displacements. Reactions at supports hold forces of
    /// inertia and contact: they cannot be computed anew once the time step is over.
    last: Vec<[f64; 2]>,
    /// [J]
    pub total: f64,
}

impl Work {
    /// Begins at rest.
    fn new(problem: &Problem, rest: &[Vec3]) -> Self {
        let still = results::still(problem);
        Self { last: pairs(problem, &still.iterate(problem, rest)), total: 0.0 }
    }

    fn follow(&mut self, problem: &Problem, at: &Iterate) {
        let next = pairs(problem, at);
        for ([f, q], [next_f, next_q]) in self.last.iter().zip(&next) {
            self.total += 0.5 * (f + next_f) * (next_q - q);
        }
        self.last = next;
    }
}

/// Forces and the quantities that they work on.
fn pairs(problem: &Problem, at: &Iterate) -> Vec<[f64; 2]> {
    let (reactions, _) = problem.gradient(at);
    let mut dead = vec![0.0; at.u.len()];
    for term in problem.energies.terms().filter(|term| term.nature() == Nature::DeadLoad) {
        term.energy.add_gradient(at, &mut dead);
    }
    let gas = problem.energies.chambers().map(|(_, chamber)| {
        let (volume, gas) = chamber.state(at);
        [gas.pressure, volume]
    });
    let fixed = problem.dirichlet.fixed();
    let dofs = (0..at.u.len()).map(|dof| {
        let reaction = if fixed[dof] { reactions[dof] } else { 0.0 };
        [reaction - dead[dof], at.u[dof]]
    });
    gas.chain(dofs).collect()
}
