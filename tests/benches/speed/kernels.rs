//! Single steps of a solve, timed by Criterion.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use criterion::{BatchSize, Criterion, SamplingMode, Throughput};
use mechanics::body::Body;
use mechanics::energy::{Energy, Hessian};
use mechanics::forward::{Workspace, certificate};
use mechanics::math::linear::{Precision, Symmetric};
use mechanics::math::sparse::{BlockMatrix, Pattern};

use crate::cases;
use crate::row::{Row, Seconds, Work};

/// Steps of assembly, and those after it, as the table names them.
const ASSEMBLY: [&str; 4] = ["energy", "gradient", "Hessian", "certificate"];
const CHAMBER: [&str; 2] = ["pressure gradient", "pressure Hessian"];
const LINEAR: [&str; 6] = [
    "factor, 1 thread",
    "factor",
    "factor, double",
    "solve, one step",
    "solve to 1e-10",
    "CG, old factor",
];

/// Accuracy of a Newton step's equations in the middle of an iteration.
const FORCING: f64 = 1e-4;
/// That of an adjoint.
const ACCURATE: f64 = 1e-10;

/// A discrete problem at a state near equilibrium.
struct Problem {
    name: String,
    body: Body,
    problem: mechanics::forward::Problem,
    workspace: Workspace,
    u: Vec<f64>,
}

impl Problem {
    fn new(name: &str) -> Result<Option<Self>> {
        let Some(scene) = cases::scene(name)? else { return Ok(None) };
        let body = scene.body.clone();
        let (problem, workspace) = scene.problem(&body)?;
        // the body larger by one percent in all directions: its Hessian is positive
        // definite, and costs what any other does
        let nodes = problem.space.node_positions(&body.mesh.vertices);
        let u = nodes.iter().flat_map(|p| [p.x, p.y, p.z].map(|c| 1e-2 * c)).collect();
        Ok(Some(Self { name: name.to_owned(), body, problem, workspace, u }))
    }

    /// At a multiple of the displacement.
    fn hessian(&mut self, factor: f64) -> Symmetric {
        let u: Vec<f64> = self.u.iter().map(|u| factor * u).collect();
        let at = self.problem.iterate(&self.body.mesh.vertices, &u, 1.0);
        self.workspace.hessian(&self.problem, &at, Hessian::Exact)
    }

    /// What is out of balance on the free degrees of freedom.
    fn force(&mut self) -> Vec<f64> {
        let at = self.problem.iterate(&self.body.mesh.vertices, &self.u, 1.0);
        let (gradient, _) = self.problem.gradient(&at);
        self.problem.restrict(&gradient)
    }
}

/// What is timed, and how much it is.
struct Step {
    what: &'static str,
    body: String,
    dofs: usize,
    work: Work,
}

impl Step {
    fn per_dof(what: &'static str, p: &Problem) -> Self {
        let dofs = p.problem.dofs();
        Self { what, body: p.name.clone(), dofs, work: Work::Dofs(dofs as f64) }
    }

    fn of(self, work: Work) -> Self {
        Self { work, ..self }
    }
}

/// Criterion, and the rows it has made.
pub struct Kernels<'a> {
    criterion: Criterion,
    folder: PathBuf,
    wanted: &'a dyn Fn(&str) -> bool,
    rows: Vec<Row>,
}

impl<'a> Kernels<'a> {
    /// Keeps its samples in a folder and times what is `wanted` by its key.
    pub fn new(folder: PathBuf, wanted: &'a dyn Fn(&str) -> bool) -> Self {
        let criterion = Criterion::default()
            .sample_size(10)
            .warm_up_time(Duration::from_millis(100))
            .measurement_time(Duration::from_secs(1))
            .without_plots()
            .output_directory(&folder);
        Self { criterion, folder, wanted, rows: Vec::new() }
    }

    /// All steps on a body.
    pub fn all(&mut self, name: &str) -> Result<()> {
        let steps = [&ASSEMBLY[..], &CHAMBER, &LINEAR].concat();
        let Some(mut problem) = self.problem(name, &steps)? else { return Ok(()) };
        self.assembly(&mut problem)?;
        self.chamber(&problem)?;
        self.linear(&mut problem)
    }

    /// Assembly alone.
    pub fn assembly_of(&mut self, name: &str) -> Result<()> {
        let Some(mut problem) = self.problem(name, &ASSEMBLY)? else { return Ok(()) };
        self.assembly(&mut problem)
    }

    /// The problem, if any of the steps on it is wanted.
    fn problem(&self, name: &str, steps: &[&str]) -> Result<Option<Problem>> {
        if steps.iter().any(|step| (self.wanted)(&format!("{step}/{name}"))) {
            return Problem::new(name);
        }
        Ok(None)
    }

    /// The rows since this was asked last.
    pub fn take_rows(&mut self) -> Vec<Row> {
        std::mem::take(&mut self.rows)
    }

    fn assembly(&mut self, p: &mut Problem) -> Result<()> {
        let step = |what| Step::per_dof(what, p);
        let [energy, gradient, hessian, proof] = ASSEMBLY.map(step);
        let Problem { body, problem, workspace, u, .. } = p;
        let rest = &body.mesh.vertices;
        let at = problem.iterate(rest, u, 1.0);
        self.time(&energy, || problem.value(&at))?;
        self.time(&gradient, || problem.gradient(&at))?;
        self.time(&hessian, || workspace.hessian(problem, &at, Hessian::Exact))?;
        self.time(&proof, || {
            certificate(&problem.space, rest, u).expect("a swollen body has positive volume");
        })
    }

    /// The pressure terms alone, which the assembly contains.
    fn chamber(&mut self, p: &Problem) -> Result<()> {
        let space = &p.problem.space;
        let at = p.problem.iterate(&p.body.mesh.vertices, &p.u, 1.0);
        let walls = || p.problem.energies.chambers().map(|(_, chamber)| chamber);
        let [gradient, hessian] = CHAMBER.map(|what| Step::per_dof(what, p));
        let mut force = vec![0.0; p.problem.dofs()];
        self.time(&gradient, || walls().for_each(|wall| wall.add_gradient(&at, &mut force)))?;
        let pattern =
            Pattern::new(space.node_count(), space.element_nodes(), space.nodes_per_element(), &[]);
        let mut matrix = BlockMatrix::zeros(&pattern);
        let kind = Hessian::Exact;
        self.time(&hessian, || walls().for_each(|wall| wall.add_hessian(&at, kind, &mut matrix)))
    }

    fn linear(&mut self, p: &mut Problem) -> Result<()> {
        let [factor_1, factor, double, once, solve, near] =
            LINEAR.map(|what| Step::per_dof(what, p));
        let hessian = p.hessian(1.0);
        let force = p.force();
        let nearby = p.hessian(1.01);
        p.workspace.factor(|linear| {
            let cost = linear.cost();
            let flops = Work::Flops(cost.flops);
            // the factor in single precision forwards and backwards, and values and
            // row indices of the matrix
            let entries = (cost.entries, hessian.lower.len());
            let bytes = Work::Bytes((2 * 4 * entries.0 + (8 + 8) * entries.1) as f64);
            let stable = "a swollen body is stable";
            let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
            let matrix = || hessian.clone();
            self.time_with(&double.of(flops), matrix, |matrix| {
                linear.factor_positive(matrix, Precision::Double).map(drop).expect(stable);
            })?;
            self.time_with(&factor_1.of(flops), matrix, |matrix| {
                one.install(|| linear.factor_positive(matrix, Precision::Single).map(drop))
                    .expect(stable);
            })?;
            self.time_with(&factor.of(flops), matrix, |matrix| {
                linear.factor_positive(matrix, Precision::Single).map(drop).expect(stable);
            })?;
            let factored = linear.factor_positive(matrix(), Precision::Single).expect(stable);
            let vector = || force.clone();
            // any accuracy will do: one step
            self.time_with(&once.of(bytes), vector, |mut x| {
                factored.solve_to(&mut x, f64::INFINITY)
            })?;
            self.time_with(&solve, vector, |mut x| factored.solve_to(&mut x, ACCURATE))?;
            self.time(&near, || {
                let near = factored.solve_near(&nearby, &force, FORCING);
                near.solved().expect("one percent more is near")
            })
        })
    }

    fn time<O: Send>(&mut self, step: &Step, mut run: impl FnMut() -> O + Send) -> Result<()> {
        self.time_with(step, || (), |()| run())
    }

    /// Times `run` on what `prepare` makes, on all threads and on one; neither the making
    /// nor the end of what `run` returns is counted.
    fn time_with<T: Send, O: Send>(
        &mut self,
        Step { what, body, dofs, work }: &Step,
        mut prepare: impl FnMut() -> T,
        mut run: impl FnMut(T) -> O + Send,
    ) -> Result<()> {
        if !(self.wanted)(&format!("{what}/{body}")) {
            return Ok(());
        }
        let mut group = self.criterion.benchmark_group(*what);
        group.sampling_mode(SamplingMode::Flat).throughput(Throughput::Elements(*dofs as u64));
        group.bench_function(body, |b| {
            b.iter_batched(&mut prepare, &mut run, BatchSize::PerIteration);
        });
        group.finish();
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        let mut once = || {
            let input = prepare();
            let clock = Instant::now();
            let result = one.install(|| run(input));
            let seconds = clock.elapsed().as_secs_f64();
            drop(result);
            seconds
        };
        let one_thread_s = Some(Seconds::new((0..3).map(|_| once()).collect()).median);
        self.rows.push(Row {
            one_thread_s,
            what: (*what).to_owned(),
            body: body.clone(),
            dofs: Some(*dofs),
            seconds: samples(&self.folder.join(what).join(body))?,
            work: *work,
            peak_mb: None,
            beside: String::new(),
        });
        Ok(())
    }
}

/// Seconds per iteration of the samples that Criterion has left in a folder.
fn samples(folder: &Path) -> Result<Seconds> {
    #[derive(serde::Deserialize)]
    struct Samples {
        iters: Vec<f64>,
        times: Vec<f64>,
    }
    let path = folder.join("new/sample.json");
    let text = mesh::io::read_text(&path)?;
    let Samples { iters, times } =
        serde_json::from_str(&text).with_context(|| path.display().to_string())?;
    Ok(Seconds::new(times.iter().zip(&iters).map(|(t, n)| 1e-9 * t / n).collect()))
}
