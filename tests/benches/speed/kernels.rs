//! Single steps of a solve, timed by Criterion.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result};
use criterion::{BatchSize, Criterion, SamplingMode, Throughput};
use mesh::Vec3;
use solver::body::Body;
use solver::energy::{Energy, Hessian};
use solver::forward::{System, certificate};
use solver::math::linear::{Symmetric, norm};
use solver::math::sparse::{BlockMatrix, Pattern};

use crate::cases;
use crate::row::{Row, Seconds, Work};

/// Accuracy of a Newton step's equations in the middle of an iteration.
const FORCING: f64 = 1e-4;

/// A discrete problem at a state near equilibrium.
struct Problem {
    name: String,
    body: Body,
    system: System,
    u: Vec<f64>,
}

impl Problem {
    fn new(name: &str) -> Result<Option<Self>> {
        let Some(scene) = cases::scene(name)? else { return Ok(None) };
        let body = scene.body.clone();
        let system = scene.system(&body)?;
        let u = swollen(&system, &body.mesh.vertices, 1e-2);
        Ok(Some(Self { name: name.to_owned(), body, system, u }))
    }

    fn rest(&self) -> &[Vec3] {
        &self.body.mesh.vertices
    }

    fn hessian(&mut self, u: &[f64]) -> Symmetric {
        self.system.hessian(&self.body.mesh.vertices, u, 1.0, Hessian::Exact)
    }
}

/// The body larger by a fraction in all directions: its Hessian is positive
/// definite, and costs what any other does.
fn swollen(system: &System, rest: &[Vec3], fraction: f64) -> Vec<f64> {
    let nodes = system.space.node_positions(rest);
    nodes.iter().flat_map(|p| [p.x, p.y, p.z].map(|c| fraction * c)).collect()
}

/// Criterion, and the rows it has made.
pub struct Kernels<'a> {
    criterion: Criterion,
    folder: &'a Path,
    wanted: &'a dyn Fn(&str) -> bool,
    rows: Vec<Row>,
}

impl<'a> Kernels<'a> {
    /// Keeps its samples in a folder and times what is `wanted` by its key.
    pub fn new(folder: &'a Path, wanted: &'a dyn Fn(&str) -> bool) -> Self {
        let criterion = Criterion::default()
            .sample_size(10)
            .warm_up_time(Duration::from_millis(100))
            .measurement_time(Duration::from_secs(1))
            .without_plots()
            .output_directory(folder);
        Self { criterion, folder, wanted, rows: Vec::new() }
    }

    /// All steps on a body; returns the operations of its factorisation.
    pub fn all(&mut self, name: &str) -> Result<Option<f64>> {
        let Some(mut problem) = Problem::new(name)? else { return Ok(None) };
        self.assembly(&mut problem)?;
        self.chamber(&mut problem)?;
        self.linear(&mut problem)?;
        Ok(Some(problem.system.linear.factor_flops()))
    }

    /// Assembly alone.
    pub fn assembly_of(&mut self, name: &str) -> Result<()> {
        let Some(mut problem) = Problem::new(name)? else { return Ok(()) };
        self.assembly(&mut problem)
    }

    /// The rows so far.
    pub fn rows(self) -> Vec<Row> {
        self.rows
    }

    fn assembly(&mut self, p: &mut Problem) -> Result<()> {
        let (name, dofs, u) = (p.name.clone(), p.system.len(), p.u.clone());
        let work = Work::Dofs(dofs as f64);
        let Problem { body, system, .. } = p;
        let rest = &body.mesh.vertices;
        self.time("energy", &name, dofs, work, || {
            system.value(rest, &u, 1.0);
        })?;
        self.time("gradient", &name, dofs, work, || {
            system.gradient(rest, &u, 1.0);
        })?;
        self.time("Hessian", &name, dofs, work, || {
            system.hessian(rest, &u, 1.0, Hessian::Exact);
        })?;
        self.time("certificate", &name, dofs, work, || {
            certificate(&system.space, rest, &u).expect("a swollen body has positive volume");
        })
    }

    /// The pressure terms alone, which the assembly contains.
    fn chamber(&mut self, p: &mut Problem) -> Result<()> {
        let space = &p.system.space;
        let dofs = p.system.len();
        let work = Work::Dofs(dofs as f64);
        let at = p.system.iterate(p.rest(), &p.u, 1.0);
        let walls: Vec<&dyn Energy> =
            p.system.energies.iter().skip(1).map(std::convert::AsRef::as_ref).collect();
        let mut force = vec![0.0; dofs];
        self.time("pressure gradient", &p.name, dofs, work, || {
            walls.iter().for_each(|wall| wall.add_gradient(&at, &mut force));
        })?;
        let pattern =
            Pattern::new(space.node_count(), space.element_nodes(), space.nodes_per_element());
        let mut matrix = BlockMatrix::zeros(&pattern);
        self.time("pressure Hessian", &p.name, dofs, work, || {
            walls.iter().for_each(|wall| wall.add_hessian(&at, Hessian::Exact, &mut matrix));
        })
    }

    fn linear(&mut self, p: &mut Problem) -> Result<()> {
        let (name, dofs, u) = (p.name.clone(), p.system.len(), p.u.clone());
        let hessian = p.hessian(&u);
        let near = p.hessian(&u.iter().map(|u| 1.01 * u).collect::<Vec<_>>());
        let force = {
            let (gradient, _) = p.system.gradient(&p.body.mesh.vertices, &u, 1.0);
            p.system.restrict(&gradient)
        };
        let linear = &mut p.system.linear;
        let flops = Work::Flops(linear.factor_flops());
        let factor = |linear: &mut solver::math::linear::SparseSolver, matrix| {
            linear.factor_positive(matrix).expect("a swollen body is stable");
        };
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        self.time_with(
            "factor, 1 thread",
            &name,
            dofs,
            flops,
            || hessian.clone(),
            |matrix| {
                one.install(|| factor(linear, matrix));
            },
        )?;
        self.time_with(
            "factor",
            &name,
            dofs,
            flops,
            || hessian.clone(),
            |matrix| {
                factor(linear, matrix);
            },
        )?;
        // forwards and backwards
        let bytes = Work::Bytes(2.0 * 8.0 * linear.factor_len() as f64);
        self.time_with(
            "triangular solves",
            &name,
            dofs,
            bytes,
            || force.clone(),
            |mut x| {
                linear.apply_inverse(&mut x);
            },
        )?;
        let work = Work::Dofs(dofs as f64);
        let relative = norm(&force);
        assert!(relative > 0.0);
        self.time("CG, old factor", &name, dofs, work, || {
            linear.solve_near(&near, &force, FORCING).expect("one percent more is near");
        })
    }

    fn time(
        &mut self,
        what: &str,
        body: &str,
        dofs: usize,
        work: Work,
        mut run: impl FnMut(),
    ) -> Result<()> {
        self.time_with(what, body, dofs, work, || (), |()| run())
    }

    /// Times `run` on what `prepare` makes, which is not counted.
    fn time_with<T>(
        &mut self,
        what: &str,
        body: &str,
        dofs: usize,
        work: Work,
        mut prepare: impl FnMut() -> T,
        mut run: impl FnMut(T),
    ) -> Result<()> {
        if !(self.wanted)(&format!("{what}/{body}")) {
            return Ok(());
        }
        let mut group = self.criterion.benchmark_group(what);
        group.sampling_mode(SamplingMode::Flat).throughput(Throughput::Elements(dofs as u64));
        group.bench_function(body, |b| {
            b.iter_batched(&mut prepare, &mut run, BatchSize::PerIteration);
        });
        group.finish();
        self.rows.push(Row {
            what: what.to_owned(),
            body: body.to_owned(),
            dofs: Some(dofs),
            seconds: samples(&self.folder.join(what).join(body))?,
            work,
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
