//! What Python sees of a run: its states, what is measured of them, and derivatives.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use anyhow::{Context, Result};
use measure::probe::{Probe, measure};
use mechanics::adjoint::Gradient;
use mechanics::forward::{Linearizations, LoadStep};
use mesh::io::vtu;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use reports::Status;
use run::error_bars;
use run::next_to::is_free_of_history;
use run::report::results;
use run::report::simulation::{self, Verdict};
use run::{self, Start};
use scene::number::{Number, Swept, Walls};

use crate::body::{by_rows, vectors};
use crate::computing::{Break, collect, compute};
use crate::error::{NoEquilibrium, refused, refused_as};
use crate::saved::Saved;

/// The name of the derivative by rest positions.
const SHAPE: &str = "shape";

/// A run that has come to its end.
#[pyclass(frozen, module = "softpuffer._native")]
pub struct Run {
    own: run::Run,
    /// What the result is.
    status: Status,
    /// Why it must not be used, if it must not.
    refusal: Option<String>,
    /// What a user should know of it ...
    warnings: Vec<String>,
    /// ... and of what its elements hold back, once that is asked for.
    locking: OnceLock<Vec<String>>,
}

impl Run {
    /// Solves a scene, next to a displacement [m] if there is one. What elements hold back is estimated at once, or when
    /// it is asked for.
    pub fn new(
        py: Python<'_>,
        scene: Arc<scene::Scene>,
        progress: Option<Py<PyAny>>,
        (near, estimates): (Option<Vec<f64>>, bool),
    ) -> PyResult<Self> {
        let broken_off = Break::default();
        let outcome = compute(py, || {
            let watch = |own| broken_off.watch(own, progress);
            let start = Start { near: near.as_deref(), watch: Some(Box::new(watch)) };
            let (found, warnings) = collect(|| {
                scene.check_loads()?;
                simulation::foresee(&scene);
                match run::Run::new(scene, start)? {
                    Ok(own) => Ok(Ok((own.verdict()?, own))),
                    Err(none) => anyhow::Ok(Err(none.in_words())),
                }
            });
            let run = found?.map(|(verdict, own)| Self::judged(own, &verdict, warnings));
            if let (Ok(run), true) = (&run, estimates) {
                run.locking();
            }
            anyhow::Ok(run)
        })?;
        if let Some(error) = broken_off.take() {
            return Err(error);
        }
        outcome.map_err(refused)?.map_err(NoEquilibrium::new_err)
    }

    /// A run of a scene by its bytes.
    pub fn of_bytes(py: Python<'_>, scene: Arc<scene::Scene>, bytes: &[u8]) -> PyResult<Self> {
        let read = || {
            let own = Saved::of_bytes(bytes)?.run(scene)?;
            anyhow::Ok((own.verdict()?, own))
        };
        let (found, warnings) = compute(py, || collect(read))?;
        let (verdict, own) = found.map_err(refused)?;
        Ok(Self::judged(own, &verdict, warnings))
    }

    fn judged(own: run::Run, verdict: &Verdict, warnings: Vec<String>) -> Self {
        let (status, refusal) = (verdict.status(), verdict.refusal());
        Self { own, status, refusal, warnings, locking: OnceLock::new() }
    }

    /// Warnings of what the elements hold back.
    fn locking(&self) -> &[String] {
        self.locking.get_or_init(|| collect(|| self.own.estimate_locking()).1)
    }

    /// The displacement at the end [m], from which a scene may be solved.
    pub fn start_of(&self, scene: &scene::Scene) -> PyResult<Vec<f64>> {
        let leave_out = "leave `start` out";
        if scene.config.time.is_some() {
            let why = "the scene goes through time, which begins at rest";
            return Err(refused_as(format!("start: {why}; {leave_out}")));
        }
        if !is_free_of_history(scene) {
            let why = "with friction an equilibrium depends on the way to it";
            return Err(refused_as(format!("start: {why}; {leave_out}")));
        }
        let [own, other] =
            [&*self.own.scene, scene].map(|of| (&of.body.mesh.tets, of.config.degree));
        if own != other {
            let [own, other] = [own, other]
                .map(|(tets, degree)| format!("{} tetrahedra of degree {degree}", tets.len()));
            return Err(refused_as(format!(
                "start: it is a run on another mesh: {own}, and the scene has {other}; {leave_out}"
            )));
        }
        Ok(self.own.states.last().into_owned())
    }

    /// A computation on the run, which ends where Ctrl-C is pressed.
    fn interruptible<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&run::Run) -> T + Send,
    ) -> PyResult<T> {
        let broken_off = Break::default();
        let found = compute(py, || {
            self.own.workspace().watch = Some(broken_off.watch(None, None));
            let found = work(&self.own);
            self.own.workspace().watch = None;
            found
        })?;
        broken_off.take().map_or(Ok(found), Err)
    }

    /// A step, the last by −1 as in Python.
    fn step(&self, step: i64) -> PyResult<&LoadStep> {
        let steps: Vec<&LoadStep> = self.own.reported().collect();
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
        let scene = &*self.own.scene;
        let paths = names.iter().filter(|name| *name != SHAPE);
        let numbers = paths.map(|path| Number::find(scene, path)).collect::<Result<Vec<_>>>();
        let numbers = numbers.map_err(refused)?;
        let walls = Walls::of(&numbers, scene).map_err(refused)?;
        let swept = Swept::new(scene, &self.own.problem, walls.as_ref(), by);
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
        PyArray1::from_vec(py, self.own.reported().map(|step| step.time).collect())
    }

    /// Number of time steps, of which a static scene has one.
    fn ends(&self) -> usize {
        self.own.states.steps()
    }

    /// Iterations of Newton's method, those of rejected steps included.
    #[getter]
    fn newton_iterations(&self) -> usize {
        self.own.newton_iterations
    }

    /// Whether there is an equilibrium that may be used, as in report.json.
    #[getter]
    fn status(&self) -> PyResult<String> {
        let word = serde_json::to_value(self.status).map_err(refused)?;
        Ok(word.as_str().unwrap_or_default().to_owned())
    }

    /// Why the result must not be used; none where it may be.
    #[getter]
    fn refusal(&self) -> Option<&str> {
        self.refusal.as_deref()
    }

    /// What a user should know of it.
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// What a user should know of what its elements hold back.
    fn locking_warnings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        compute(py, || self.locking().to_vec())
    }

    /// The run as bytes, without its scene.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = compute(py, || Saved::new(&self.own).to_bytes())?.map_err(refused)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Nodes of each tetrahedron (m, k), its corners first.
    #[getter]
    fn elements<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let space = &self.own.problem.space;
        let nodes = space.element_nodes().iter().map(|&node| node as i64).collect();
        by_rows(py, nodes, space.nodes_per_element())
    }

    /// Nodes of each facet of a tag (m, k), its corners first.
    fn facets<'py>(&self, py: Python<'py>, tag: &str) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let (body, space) = (&self.own.scene.body, &self.own.problem.space);
        let facets = body.facets(tag).map_err(refused)?;
        let nodes: Vec<Vec<usize>> = facets.iter().map(|&f| space.facet_nodes(f)).collect();
        let each = nodes.first().map_or(3, Vec::len);
        by_rows(py, nodes.iter().flatten().map(|&node| node as i64).collect(), each)
    }

    /// Rest positions of the nodes (n, 3) [m], those of the vertices first, a copy.
    #[getter]
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.own.problem.space.node_positions(&self.own.scene.body.mesh.vertices))
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
        let values = compute(py, || {
            let one =
                |step: &LoadStep| measure(&self.own.probes, &self.own.problem, &self.own.at(step));
            self.own.reported().map(one).collect::<Vec<_>>()
        })?;
        let found = PyDict::new(py);
        for probe in &self.own.probes {
            let own = values.iter().map(|step| step[&probe.name]).collect();
            found.set_item(&probe.name, PyArray1::from_vec(py, own))?;
        }
        Ok(found)
    }

    /// Names, kinds and units of the probes.
    fn probe_units(&self) -> Vec<(String, &'static str, &'static str)> {
        let one = |probe: &Probe| (probe.name.clone(), probe.kind.key, probe.kind.unit);
        self.own.probes.iter().map(one).collect()
    }

    /// Pressures [Pa] and volumes [m³] of the chambers at a step, by their names.
    fn chambers<'py>(&self, py: Python<'py>, step: i64) -> PyResult<Bound<'py, PyDict>> {
        let step = self.step(step)?;
        let chambers =
            compute(py, || results::chambers(&self.own.problem.energies, &self.own.at(step)))?;
        let found = PyDict::new(py);
        for (name, chamber) in chambers {
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
        let fields = || results::grid_with_fields(&self.own.problem.energies, &self.own.at(step));
        let grid = compute(py, fields)?;
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
        let found = self.interruptible(py, |run| {
            let solver = (&run.problem, &mut *run.workspace());
            error_bars::report(&run.scene, solver, &run.probes, &run.states)
        })?;
        found.map(|bars| serde_json::to_string(&bars)).transpose().map_err(refused)
    }

    /// Writes what `solver simulate` writes into a folder, of a scene that lies in a file with its
    /// meshes, and gives back what it warns of.
    fn save(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        scene: PathBuf,
        meshes: Vec<PathBuf>,
    ) -> PyResult<Vec<String>> {
        let write = || self.own.write(&folder, &scene, meshes);
        let (written, warnings) = compute(py, || collect(write))?;
        written.map(|()| warnings).map_err(refused)
    }

    /// Writes a step with all fields for ParaView.
    fn write_vtu(&self, py: Python<'_>, path: PathBuf, step: i64) -> PyResult<()> {
        let step = self.step(step)?;
        let written = compute(py, || {
            let grid = results::grid_with_fields(&self.own.problem.energies, &self.own.at(step));
            vtu::write_vtu(&path, &grid)
        })?;
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
        let (count, dofs) = (self.own.states.steps(), self.own.problem.dofs());
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
        let swept = self.interruptible(py, |run| {
            run.gradient(&Linearizations::default(), |_, moment, out| {
                let own = by_u[moment].iter().flatten();
                out.by_u.iter_mut().zip(own).for_each(|(to, by)| *to += by);
            })
        })?;
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
        let probe = self.own.probes.iter().find(|probe| probe.name == name).with_context(|| {
            let known: Vec<&str> = self.own.probes.iter().map(|probe| &*probe.name).collect();
            format!("unknown probe \"{name}\"; the scene has: {}", known.join(", "))
        });
        let probe = probe.map_err(refused)?;
        let last = self.own.states.steps();
        let found = self.interruptible(py, |run| run.sensitivities(&[probe], last))?;
        let found = found.map_err(|error| NoEquilibrium::new_err(format!("{error:#}")))?;
        let (value, by) = &found[0];
        Ok((*value, self.derivatives(py, by, &names)?))
    }
}
