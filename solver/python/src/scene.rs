//! A scene: bodies, materials, supports and loads.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::{Context, anyhow, ensure};
use design::scene_of;
use mechanics::element::FunctionSpace;
use numpy::{PyArray2, PyReadonlyArray2};
use program::{Change, Keys, Settings};
use pyo3::prelude::*;
use run::error_bars;
use run::next_to::is_free_of_history;
use scene::config::ScenarioConfig;
use scene::number::{Number, Walls};

use crate::body::{Body, points, vectors};
use crate::computing::{collect, compute};
use crate::error::{refused, refused_as};
use crate::run::Run;

/// A scene. It may be used by several threads: each run has a copy of its own.
#[pyclass(frozen, module = "softpuffer._native")]
pub struct Scene {
    state: Mutex<Arc<scene::Scene>>,
}

impl Scene {
    /// A scene that was read, if it can be simulated.
    fn new(scene: scene::Scene) -> anyhow::Result<Self> {
        // what it warns of is said where the scene is simulated
        collect(|| check(&scene)).0?;
        Ok(Self::of(scene.into()))
    }

    fn of_values(
        py: Python<'_>,
        values: toml::Table,
        folder: &Path,
        bodies: &[PyRef<'_, Body>],
    ) -> PyResult<Self> {
        let meshes: Vec<_> = bodies.iter().map(|body| Arc::clone(&body.file)).collect();
        let made = || {
            let meshes = meshes.iter().map(|mesh| (**mesh).clone()).collect();
            Self::new(scene::Scene::of_values(values, &folder.join("scene"), meshes)?)
        };
        compute(py, made)?.map_err(refused)
    }

    fn of(scene: Arc<scene::Scene>) -> Self {
        Self { state: Mutex::new(scene) }
    }

    fn lock(&self) -> MutexGuard<'_, Arc<scene::Scene>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The scene as it is now.
    fn now(&self) -> Arc<scene::Scene> {
        Arc::clone(&self.lock())
    }

    /// Changes the scene, or leaves it as it is where that fails.
    fn change(
        &self,
        py: Python<'_>,
        change: impl FnOnce(&mut scene::Scene) -> anyhow::Result<()> + Send,
    ) -> PyResult<()> {
        let changed = compute(py, || {
            let mut now = self.lock();
            let mut scene = scene::Scene::clone(&now);
            change(&mut scene)?;
            *now = Arc::new(scene);
            anyhow::Ok(())
        });
        changed?.map_err(refused)
    }
}

/// Refuses a scene that cannot be simulated.
fn check(scene: &scene::Scene) -> anyhow::Result<()> {
    let problem = scene.discretise(&scene.body)?;
    scene.probes(&scene.body, &problem.space)?;
    scene.check_loads()?;
    error_bars::check(scene)
}

#[pymethods]
impl Scene {
    /// Reads a scene of TOML and its meshes; `changes` as `--set` of the programs takes them.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf, changes: Vec<String>) -> PyResult<Self> {
        let changes = changes.iter().map(|text| text.parse::<Change>().map_err(refused_as));
        let changes = changes.collect::<PyResult<Vec<_>>>()?;
        let read = || Self::new(scene::Scene::read_with(&path, &[], &changes)?);
        compute(py, read)?.map_err(refused)
    }

    /// A scene by its tables in JSON, whose bodies have these meshes in place of those of files. Its other paths are
    /// relative to a folder.
    #[staticmethod]
    fn of_json(
        py: Python<'_>,
        text: &str,
        folder: PathBuf,
        bodies: Vec<PyRef<'_, Body>>,
    ) -> PyResult<Self> {
        Self::of_values(py, serde_json::from_str(text).map_err(refused)?, &folder, &bodies)
    }

    /// The same by its text in TOML.
    #[staticmethod]
    fn of_toml(
        py: Python<'_>,
        text: &str,
        folder: PathBuf,
        bodies: Vec<PyRef<'_, Body>>,
    ) -> PyResult<Self> {
        Self::of_values(py, text.parse().map_err(refused)?, &folder, &bodies)
    }

    /// The folder to which its paths are relative.
    #[getter]
    fn folder(&self) -> PathBuf {
        self.now().path.parent().map_or_else(PathBuf::new, Path::to_path_buf)
    }

    /// The scene as TOML, with the meshes of these paths where there are any, one for each body. They
    /// hold the walls as they are now; without them, what walls were moved by is written.
    #[pyo3(signature = (meshes=Vec::new()))]
    fn to_toml(&self, meshes: Vec<PathBuf>) -> PyResult<String> {
        let scene = self.now();
        let mut config = scene.config.clone();
        config.numbers = scene.given.clone();
        if !meshes.is_empty() {
            config.numbers.retain(|path, _| path.split('.').next() != Some("wall"));
            config.set_meshes(meshes).map_err(refused)?;
        }
        toml::to_string(&config).map_err(refused)
    }

    /// The bodies one by one with their names, as they are now.
    fn bodies(&self) -> Vec<(String, Body)> {
        let scene = self.now();
        let body = |(part, (_, mesh, tags)): (&scene::ScenePart, (_, _, _))| {
            (part.config.name.clone(), Body { file: Arc::new(mesh::io::MshFile { mesh, tags }) })
        };
        scene.parts.iter().zip(scene.body.separate()).map(body).collect()
    }

    /// Names of the probes.
    fn probes(&self) -> Vec<String> {
        self.now().config.probe.iter().map(|probe| probe.name().to_owned()).collect()
    }

    /// Numbers of tetrahedra, and the degree.
    fn size(&self) -> (usize, usize) {
        let scene = self.now();
        (scene.body.mesh.tets.len(), scene.config.degree)
    }

    /// Number of nodes that a run has.
    fn node_count(&self) -> usize {
        let scene = self.now();
        let mesh = &scene.body.mesh;
        let degree = scene.config.degree;
        FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone()).node_count()
    }

    /// A scene of its own, as a scenario of a design has it, by its table in JSON.
    fn scenario(&self, py: Python<'_>, changes: &str) -> PyResult<Self> {
        let before = self.now();
        let changes = serde_json::from_str(changes).map_err(refused)?;
        let values = Settings::of_values(changes, Keys::default());
        let config: ScenarioConfig = values.and_then(|values| values.parse()).map_err(refused)?;
        let scene = compute(py, || scene_of(&before, &config))?;
        let mut scene = scene.map_err(refused)?;
        for (tag, distance) in config.walls() {
            let path = tag.map_or_else(|| "wall".to_owned(), |tag| format!("wall.{tag}"));
            *scene.given.entry(path).or_default() += distance;
        }
        Ok(Self::of(scene.into()))
    }

    /// Whether an equilibrium does not depend on the way to it, so that one may be sought from another.
    fn is_free_of_history(&self) -> bool {
        is_free_of_history(&self.now())
    }

    /// A scene of its own that is like this one.
    fn copy(&self) -> Self {
        Self::of(self.now())
    }

    /// The numbers of the scene: path, SI unit and value.
    fn numbers(&self) -> Vec<(String, &'static str, Option<f64>)> {
        let scene = self.now();
        let all = Number::all(&scene);
        all.into_iter().map(|n| (n.path.clone(), n.unit, n.constant(&scene))).collect()
    }

    /// The value of a number.
    fn get(&self, path: &str) -> PyResult<f64> {
        let scene = self.now();
        let number = Number::find(&scene, path).map_err(refused)?;
        let found = number.constant(&scene).with_context(|| format!("{path} {NOT_CONSTANT}"));
        found.map_err(refused)
    }

    /// Gives numbers their values, all or none. A wall is moved by its value from where it is.
    fn set(&self, py: Python<'_>, values: Vec<(String, f64)>) -> PyResult<()> {
        self.change(py, |scene| {
            let find = |(path, _): &(String, f64)| Number::find(scene, path);
            let numbers = values.iter().map(find).collect::<anyhow::Result<Vec<_>>>()?;
            let walls = Walls::of(&numbers, scene)?;
            for (number, (_, value)) in numbers.iter().zip(&values) {
                number.replace(scene, walls.as_ref(), *value)?;
            }
            numbers.iter().try_for_each(|number| number.check(scene))
        })
    }

    /// Rest positions of the vertices (n, 3) [m], body after body, a copy.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.now().body.mesh.vertices)
    }

    /// Gives the vertices other rest positions (n, 3) [m].
    fn move_to(&self, py: Python<'_>, vertices: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let vertices = points(&vertices)?;
        self.change(py, |scene| {
            let mesh = &mut scene.body.mesh;
            let (found, needed) = (vertices.len(), mesh.vertices.len());
            ensure!(found == needed, "{found} vertices, but the scene has {needed}");
            let finite = vertices.iter().position(|x| !x.iter().all(|c| c.is_finite()));
            ensure!(finite.is_none(), "vertex {} is not finite", finite.unwrap_or_default());
            mesh.vertices = vertices;
            match mesh::check::check_tets(mesh).first() {
                Some(finding) => Err(anyhow!("{}", finding.message)),
                None => Ok(()),
            }
        })
    }

    /// The body with its tags, several as one, as it is now.
    fn body(&self) -> Body {
        let scene = self.now();
        let (mesh, tags) = (scene.body.mesh.clone(), scene.body.tags.clone());
        Body { file: Arc::new(mesh::io::MshFile { mesh, tags }) }
    }

    /// Solves the scene. `progress` is called with the time, the number of an iteration of Newton's
    /// method, the unbalanced force and the one wanted [N]. The equilibrium is sought next to that of
    /// `start` first. What elements hold back is estimated at once, or where it is asked for.
    #[pyo3(signature = (progress=None, start=None, estimates=false))]
    fn simulate(
        &self,
        py: Python<'_>,
        progress: Option<Py<PyAny>>,
        start: Option<PyRef<'_, Run>>,
        estimates: bool,
    ) -> PyResult<Run> {
        let scene = self.now();
        let start = start.map(|run| run.start_of(&scene)).transpose()?;
        Run::new(py, scene, progress, (start, estimates))
    }

    /// A run of this scene by its bytes.
    fn run_of_bytes(&self, py: Python<'_>, bytes: &[u8]) -> PyResult<Run> {
        Run::of_bytes(py, self.now(), bytes)
    }
}

/// What is said of a number that a function of time stands for.
const NOT_CONSTANT: &str = "is a function of time or place: write it in the table of the scene";
