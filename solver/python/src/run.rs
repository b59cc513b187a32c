//! A run of a scene: its states, what is measured of them, and derivatives.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use anyhow::{Context, Result};
use measure::probe::{Probe, measure};
use mechanics::adjoint::{self, Gradient};
use mechanics::energy::Iterate;
use mechanics::forward::{
    Event, Linearizations, LoadStep, Problem, Trajectory, Watch, Workspace, predicted_time,
};
use mesh::io::vtu;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2, PyUntypedArrayMethods};
use program::FolderLock;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use reports::Status;
use scene::config::SimConfig;
use solver::number::{Number, Swept, Walls};
use solver::report::failure::Diagnosis;
use solver::report::record::{Finished, Recorder};
use solver::report::reinforcement;
use solver::report::results;
use solver::report::simulation::{self, Spent};
use solver::study::nearby;
use solver::study::sensitivity::sensitivities;
use solver::study::uncertainty;

use crate::body::{by_rows, vectors};
use crate::course::Course;
use crate::error::{NoEquilibrium, refused, refused_as};

/// The name of the derivative by rest positions.
const SHAPE: &str = "shape";

/// A run that has ended well.
#[pyclass(frozen, module = "softpuffer._native")]
pub struct Run {
    scene: Arc<scene::Scene>,
    problem: Problem,
    workspace: Mutex<Workspace>,
    probes: Vec<Probe>,
    trajectory: Trajectory,
    load_steps: Vec<LoadStep>,
    newton_iterations: usize,
    /// Wall time [s].
    seconds: f64,
    /// Predicted wall time [s].
    predicted_s: f64,
}

impl Run {
    /// Solves a scene, next to a displacement [m] if there is one.
    pub fn new(
        py: Python<'_>,
        scene: Arc<scene::Scene>,
        progress: Option<Py<PyAny>>,
        start: Option<Vec<f64>>,
    ) -> PyResult<Self> {
        let broken_off = Arc::new(Mutex::new(None));
        let told = Arc::clone(&broken_off);
        let watch = |own| watch(own, progress, told);
        let outcome = py.detach(|| Self::solve(scene, start.as_deref(), watch));
        if let Some(error) = broken_off.lock().unwrap_or_else(PoisonError::into_inner).take() {
            return Err(error);
        }
        outcome.map_err(refused)?.map_err(NoEquilibrium::new_err)
    }

    /// The displacement at the end [m], from which a scene may be solved.
    pub fn start_of(&self, scene: &scene::Scene) -> PyResult<Vec<f64>> {
        let leave_out = "leave `start` out";
        if scene.config.time.is_some() {
            let why = "the scene goes through time, which begins at rest";
            return Err(refused_as(format!("start: {why}; {leave_out}")));
        }
        if !nearby::is_free_of_history(scene) {
            let why = "with friction an equilibrium depends on the way to it";
            return Err(refused_as(format!("start: {why}; {leave_out}")));
        }
        let [own, other] = [&*self.scene, scene].map(|of| (&of.body.mesh.tets, of.config.degree));
        if own != other {
            let [own, other] = [own, other]
                .map(|(tets, degree)| format!("{} tetrahedra of degree {degree}", tets.len()));
            return Err(refused_as(format!(
                "start: it is a run on another mesh: {own}, and the scene has {other}; {leave_out}"
            )));
        }
        Ok(self.trajectory.last().into_owned())
    }

    /// The run, or why there is no equilibrium.
    fn solve(
        scene: Arc<scene::Scene>,
        start: Option<&[f64]>,
        watch: impl FnOnce(Option<Watch>) -> Watch,
    ) -> Result<Result<Self, String>> {
        let begin = Instant::now();
        let (problem, mut workspace) = scene.problem(&scene.body)?;
        let probes = scene.probes(&scene.body, &problem.space)?;
        scene.check_loads()?;
        scene.warn_of_growth();
        workspace.watch = Some(watch(workspace.watch.take()));
        let predicted_s =
            predicted_time(&problem, &workspace, scene.config.steps(scene.times().len()));
        let course = Course::new(&scene, &problem, &mut workspace, start);
        workspace.watch = None;
        let course = match course {
            Ok(course) => course,
            Err(unreached) => {
                let solver = (&problem, &mut workspace);
                return Ok(Err(Diagnosis::new(&scene, &scene.body, solver, &unreached).message));
            }
        };
        let Course { trajectory, load_steps, newton_iterations } = course;
        let (workspace, seconds) = (Mutex::new(workspace), begin.elapsed().as_secs_f64());
        Ok(Ok(Self {
            scene,
            problem,
            workspace,
            probes,
            trajectory,
            load_steps,
            newton_iterations,
            seconds,
            predicted_s,
        }))
    }

    fn write(&self, folder: &Path, path: &Path, meshes: Vec<PathBuf>) -> Result<()> {
        let mut scene = (*self.scene).clone();
        scene.file = SimConfig::settings(path, &[])?;
        scene.path = path.to_owned();
        scene.parts.iter_mut().zip(meshes).for_each(|(part, mesh)| part.mesh_path = mesh);
        let _lock = FolderLock::new(folder)?;
        results::remove_stale(folder, 0)?;
        let on = (&self.problem, &self.probes[..]);
        let mut recorder = Recorder::new(&scene, on, folder, true, None)?;
        for finished in self.finished() {
            recorder.write(finished)?;
        }
        let last = self.load_steps.last().context("the run has no steps")?;
        let at = self.at(last);
        results::write_end(folder, &self.problem, &at, None)?;
        reinforcement::write_threads(folder, &scene, &self.problem.energies, &at)?;
        let mut workspace = self.workspace.lock().unwrap_or_else(PoisonError::into_inner);
        let (timings, velocity) = (workspace.timings, self.velocity(self.trajectory.steps()));
        let spent = Spent {
            newton_iterations: self.newton_iterations,
            velocity: velocity.as_deref(),
            recorder: &recorder,
            timings: &timings,
            equilibrium_s: self.seconds,
            predicted_s: self.predicted_s,
        };
        let mut report = simulation::begun(&scene, &self.problem, folder)?;
        let (mut end, crossing) = simulation::end(&scene, on, &at, &spent)?;
        end.wall_s = self.seconds;
        end.peak_rss_mb = program::peak_rss_mb();
        let solver = (&self.problem, &mut *workspace);
        end.error_bars = uncertainty::report(&scene, solver, &self.probes, &self.trajectory);
        report.rest.clone_from(&recorder.rest);
        report.steps.clone_from(&recorder.lines);
        report.factor_entries = workspace.linear().cost().entries;
        report.memory_estimate_mb = workspace.memory().bytes as f64 / f64::from(1 << 20);
        if crossing.is_some() {
            (report.usable, report.status) = (false, Status::SurfacesCrossed);
        }
        report.end = Some(end);
        results::write_report(folder, &report)
    }

    /// The load steps as they were made: those of a static scene one by one, those of a time step
    /// together, of which the last is reported.
    fn finished(&self) -> impl Iterator<Item = Finished> {
        let timed = self.scene.config.time.is_some();
        let groups = self.load_steps.chunk_by(move |step, _| timed && !step.ends_time_step);
        (1..).zip(groups).map(move |(n, group)| Finished {
            steps: group.to_vec(),
            reported: group.len() - 1..group.len(),
            velocity: if timed { self.velocity(n) } else { None },
            checkpoint: None,
        })
    }

    /// Velocity at the end of time step n, where there is inertia [m/s].
    fn velocity(&self, n: usize) -> Option<Vec<f64>> {
        let inertia = self.trajectory.method.has_inertia();
        inertia.then(|| self.trajectory.state(n).into_owned().v)
    }

    /// Whether a step is reported.
    fn reports(&self, step: &LoadStep) -> bool {
        step.ends_time_step || self.scene.config.time.is_none()
    }

    /// The load steps of a static scene, the ends of the time steps of another.
    fn steps(&self) -> impl Iterator<Item = &LoadStep> {
        self.load_steps.iter().filter(|step| self.reports(step))
    }

    fn last(&self) -> PyResult<&LoadStep> {
        self.load_steps.last().ok_or_else(|| refused_as("the run has no steps".to_owned()))
    }

    fn at<'a>(&'a self, step: &'a LoadStep) -> Iterate<'a> {
        step.iterate(&self.problem, &self.scene.body.mesh.vertices)
    }

    /// A step, the last by −1 as in Python.
    fn step(&self, step: i64) -> PyResult<&LoadStep> {
        let steps: Vec<&LoadStep> = self.steps().collect();
        let count = steps.len();
        let place = if step < 0 { step + count as i64 } else { step };
        let found = usize::try_from(place).ok().and_then(|place| steps.get(place));
        let found = found.copied();
        found.ok_or_else(|| refused_as(format!("step {step}, but the run has {count}")))
    }

    /// The derivatives by names: `shape`, or paths of numbers.
    fn derivatives<'py>(
        &self,
        py: Python<'py>,
        by: &Gradient,
        names: &[String],
    ) -> PyResult<Bound<'py, PyDict>> {
        let scene = &*self.scene;
        let paths = names.iter().filter(|name| *name != SHAPE);
        let numbers = paths.map(|path| Number::find(scene, path)).collect::<Result<Vec<_>>>();
        let numbers = numbers.map_err(refused)?;
        let walls = Walls::of(&numbers, scene).map_err(refused)?;
        let swept = Swept::new(scene, &self.problem, walls.as_ref(), by);
        let found = PyDict::new(py);
        if names.iter().any(|name| name == SHAPE) {
            found.set_item(SHAPE, by_rows(py, by.rest.clone(), 3)?)?;
        }
        for number in &numbers {
            found.set_item(&number.path, number.derivative(&swept))?;
        }
        Ok(found)
    }
}

#[pymethods]
impl Run {
    /// The times of the steps [s]; in a static scene parts of the load.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.steps().map(|step| step.time).collect())
    }

    /// Number of time steps, of which a static scene has one.
    fn ends(&self) -> usize {
        self.trajectory.steps()
    }

    /// Iterations of Newton's method, those of rejected steps included.
    #[getter]
    fn newton_iterations(&self) -> usize {
        self.newton_iterations
    }

    /// Rest positions of the nodes (n, 3) [m], those of the vertices first, a copy.
    #[getter]
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.problem.space.node_positions(&self.scene.body.mesh.vertices))
    }

    /// Displacement of the nodes at a step (n, 3) [m], a copy.
    fn displacement_at<'py>(
        &self,
        py: Python<'py>,
        step: i64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        by_rows(py, self.step(step)?.u.clone(), 3)
    }

    /// The values of all probes at all steps, by their names.
    fn probes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let values = py.detach(|| {
            let one = |step: &LoadStep| measure(&self.probes, &self.problem, &self.at(step));
            self.steps().map(one).collect::<Vec<_>>()
        });
        let found = PyDict::new(py);
        for probe in &self.probes {
            let own = values.iter().map(|step| step[&probe.name]).collect();
            found.set_item(&probe.name, PyArray1::from_vec(py, own))?;
        }
        Ok(found)
    }

    /// Names, kinds and units of the probes.
    fn probe_units(&self) -> Vec<(String, &'static str, &'static str)> {
        let one = |probe: &Probe| (probe.name.clone(), probe.kind.key, probe.kind.unit);
        self.probes.iter().map(one).collect()
    }

    /// Pressures [Pa] and volumes [m³] of the chambers at a step, by their names.
    fn chambers<'py>(&self, py: Python<'py>, step: i64) -> PyResult<Bound<'py, PyDict>> {
        let step = self.step(step)?;
        let found = PyDict::new(py);
        for (name, chamber) in results::chambers(&self.problem.energies, &self.at(step)) {
            let own = PyDict::new(py);
            own.set_item("pressure", chamber.pressure)?;
            own.set_item("volume", chamber.volume)?;
            own.set_item("volume_rest", chamber.volume_rest)?;
            found.set_item(name, own)?;
        }
        Ok(found)
    }

    /// Fields at a step: of nodes, and of cells; name to unit and array (n, components).
    fn fields<'py>(
        &self,
        py: Python<'py>,
        step: i64,
    ) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
        let step = self.step(step)?;
        let grid = py.detach(|| results::grid_with_fields(&self.problem.energies, &self.at(step)));
        let dict = |fields: Vec<vtu::Field>| -> PyResult<Bound<'py, PyDict>> {
            let found = PyDict::new(py);
            for vtu::Field { name, unit, components, values } in fields {
                found.set_item(name, (unit, by_rows(py, values, components)?))?;
            }
            Ok(found)
        };
        Ok((dict(grid.point_fields)?, dict(grid.cell_fields)?))
    }

    /// Error bars of the probes, as `[uncertainty]` of the scene asks for them, in JSON; none without.
    fn error_bars(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let found = py.detach(|| {
            let mut workspace = self.workspace.lock().unwrap_or_else(PoisonError::into_inner);
            let solver = (&self.problem, &mut *workspace);
            uncertainty::report(&self.scene, solver, &self.probes, &self.trajectory)
        });
        found.map(|bars| serde_json::to_string(&bars)).transpose().map_err(refused)
    }

    /// Writes what `solver simulate` writes into a folder, of a scene that lies in a file with its
    /// meshes.
    fn save(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        scene: PathBuf,
        meshes: Vec<PathBuf>,
    ) -> PyResult<()> {
        py.detach(|| self.write(&folder, &scene, meshes)).map_err(refused)
    }

    /// Writes a step with all fields for ParaView.
    fn write_vtu(&self, py: Python<'_>, path: PathBuf, step: i64) -> PyResult<()> {
        let step = self.step(step)?;
        let written = py.detach(|| {
            let grid = results::grid_with_fields(&self.problem.energies, &self.at(step));
            vtu::write_vtu(&path, &grid)
        });
        written.map_err(refused)
    }

    /// Derivatives of a result from its derivatives by the displacements (n, 3) at the ends of time steps,
    /// counted from 1; a static scene has one.
    fn gradient<'py>(
        &self,
        py: Python<'py>,
        by_displacements: Vec<(usize, PyReadonlyArray2<'_, f64>)>,
        names: Vec<String>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (count, dofs) = (self.trajectory.steps(), self.problem.dofs());
        let mut by_u: Vec<Option<Vec<f64>>> = vec![None; count + 1];
        for (moment, by) in &by_displacements {
            let (shape, nodes) = (by.shape(), dofs / 3);
            if shape != [nodes, 3] {
                return Err(refused_as(format!(
                    "a derivative by displacements of shape {shape:?}, needed ({nodes}, 3)"
                )));
            }
            if !(1..=count).contains(moment) {
                return Err(refused_as(format!("time step {moment}, but there are {count}")));
            }
            by_u[*moment] = Some(by.as_array().iter().copied().collect());
        }
        let swept = py.detach(|| {
            let mut workspace = self.workspace.lock().unwrap_or_else(PoisonError::into_inner);
            let on = (&self.scene.body.mesh.vertices[..], &self.trajectory);
            adjoint::sweep(
                &self.problem,
                &mut workspace,
                on,
                &Linearizations::default(),
                |_, moment, out| {
                    let own = by_u[moment].iter().flatten();
                    out.by_u.iter_mut().zip(own).for_each(|(to, by)| *to += by);
                },
            )
        });
        let swept = swept.map_err(|error| NoEquilibrium::new_err(error.to_string()))?;
        self.derivatives(py, &swept, &names)
    }

    /// The value of a probe at the end, and its derivatives.
    fn probe_gradient<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        names: Vec<String>,
    ) -> PyResult<(f64, Bound<'py, PyDict>)> {
        let probe = self.probes.iter().find(|probe| probe.name == name).with_context(|| {
            let known: Vec<&str> = self.probes.iter().map(|probe| &*probe.name).collect();
            format!("unknown probe \"{name}\"; the scene has: {}", known.join(", "))
        });
        let probe = probe.map_err(refused)?;
        let found = py.detach(|| {
            let mut workspace = self.workspace.lock().unwrap_or_else(PoisonError::into_inner);
            let on = (&[probe][..], &self.trajectory, self.trajectory.steps());
            sensitivities(&self.scene, (&self.problem, &mut workspace), on)
        });
        let found = found.map_err(|error| NoEquilibrium::new_err(format!("{error:#}")))?;
        let (value, by) = &found[0];
        Ok((*value, self.derivatives(py, by, &names)?))
    }

    fn __repr__(&self) -> PyResult<String> {
        let (last, steps) = (self.last()?, self.steps().count());
        let largest = last.u.chunks_exact(3).map(|u| u.iter().map(|c| c * c).sum::<f64>());
        let largest = 1e3 * largest.fold(0.0, f64::max).sqrt();
        let iterations = self.newton_iterations;
        Ok(format!(
            "<Run: {steps} steps, {iterations} Newton iterations, largest displacement {largest:.4} mm>"
        ))
    }
}

/// Calls Python at every iterate, and breaks off where that raises, or Ctrl-C was pressed. Other events
/// are for the watch of the scene.
fn watch(
    mut scene: Option<Watch>,
    progress: Option<Py<PyAny>>,
    broken_off: Arc<Mutex<Option<PyErr>>>,
) -> Watch {
    Box::new(move |event| {
        let &Event::Iterate { time, iteration, residual, wanted } = event else {
            return scene.as_mut().map_or(ControlFlow::Continue(()), |watch| watch(event));
        };
        // after a failure next to another run, a second search from rest would ignore the break
        if broken_off.lock().unwrap_or_else(PoisonError::into_inner).is_some() {
            return ControlFlow::Break(());
        }
        let said = Python::attach(|py| {
            py.check_signals()?;
            match &progress {
                Some(call) => call.call1(py, (time, iteration, residual, wanted)).map(drop),
                None => Ok(()),
            }
        });
        match said {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                *broken_off.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                ControlFlow::Break(())
            }
        }
    })
}
