//! Single steps of a solve, and whole ones.

use anyhow::Result;
use criterion::Throughput;
use mechanics::body::Body;
use mechanics::energy::{Energy, Hessian};
use mechanics::forward::{self, Workspace, certificate};
use mechanics::math::linear::{Precision, Symmetric};
use mechanics::math::sparse::{BlockMatrix, Pattern};

use crate::{Bench, cases};

/// Steps of assembly, and those after it.
const ASSEMBLY: [&str; 4] = ["energy", "gradient", "Hessian", "certificate"];
const OTHERS: [&str; 8] = [
    "pressure gradient",
    "pressure Hessian",
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
    /// None where none of the steps on it is asked for, or the body is not at hand.
    fn new(bench: &Bench, name: &str, steps: &[&str]) -> Result<Option<Self>> {
        if !steps.iter().any(|step| bench.wants(step, name)) {
            return Ok(None);
        }
        let Some(scene) = cases::scene(name)? else { return Ok(None) };
        let body = scene.body.clone();
        let (problem, workspace) = scene.problem(&body)?;
        // the body larger by one percent in all directions: its Hessian is positive
        // definite, and costs what any other does
        let nodes = problem.space.node_positions(&body.mesh.vertices);
        let u = nodes.iter().flat_map(|p| [p.x, p.y, p.z].map(|c| 1e-2 * c)).collect();
        Ok(Some(Self { name: name.to_owned(), body, problem, workspace, u }))
    }

    /// Degrees of freedom, as the amount of work.
    fn dofs(&self) -> impl Fn() -> Throughput + use<> {
        let dofs = self.problem.dofs() as u64;
        move || Throughput::Elements(dofs)
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

/// All steps on a body.
pub fn all(bench: &mut Bench, name: &str) -> Result<()> {
    assembly(bench, name)?;
    let Some(mut problem) = Problem::new(bench, name, &OTHERS)? else { return Ok(()) };
    chamber(bench, &problem);
    linear(bench, &mut problem)
}

/// Assembly alone.
pub fn assembly(bench: &mut Bench, name: &str) -> Result<()> {
    let Some(p) = Problem::new(bench, name, &ASSEMBLY)? else { return Ok(()) };
    let dofs = p.dofs();
    let Problem { body, problem, mut workspace, u, .. } = p;
    let rest = &body.mesh.vertices;
    let at = problem.iterate(rest, &u, 1.0);
    let [energy, gradient, hessian, proof] = ASSEMBLY.map(|what| [what, name]);
    bench.time(energy, dofs(), || problem.value(&at));
    bench.time(gradient, dofs(), || problem.gradient(&at));
    bench.time(hessian, dofs(), || workspace.hessian(&problem, &at, Hessian::Exact));
    bench.time(proof, dofs(), || {
        certificate(&problem.space, rest, &u).expect("a swollen body has positive volume");
    });
    Ok(())
}

/// The pressure terms alone, which the assembly contains.
fn chamber(bench: &mut Bench, p: &Problem) {
    let (space, dofs) = (&p.problem.space, p.dofs());
    let at = p.problem.iterate(&p.body.mesh.vertices, &p.u, 1.0);
    let walls = || p.problem.energies.chambers().map(|(_, chamber)| chamber);
    let mut force = vec![0.0; p.problem.dofs()];
    bench.time(["pressure gradient", &p.name], dofs(), || {
        walls().for_each(|wall| wall.add_gradient(&at, &mut force));
    });
    let pattern =
        Pattern::new(space.node_count(), space.element_nodes(), space.nodes_per_element(), &[]);
    let mut matrix = BlockMatrix::zeros(&pattern);
    bench.time(["pressure Hessian", &p.name], dofs(), || {
        walls().for_each(|wall| wall.add_hessian(&at, Hessian::Exact, &mut matrix));
    });
}

fn linear(bench: &mut Bench, p: &mut Problem) -> Result<()> {
    let (hessian, force, nearby) = (p.hessian(1.0), p.force(), p.hessian(1.01));
    let (name, dofs) = (p.name.clone(), p.dofs());
    p.workspace.factor(|linear| {
        let cost = linear.cost();
        let flops = || Throughput::Elements(cost.flops as u64);
        // the factor in single precision forwards and backwards, and values and
        // row indices of the matrix
        let bytes = 2 * 4 * cost.entries + (8 + 8) * hessian.lower.len();
        let stable = "a swollen body is stable";
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        let matrix = || hessian.clone();
        bench.time_with(["factor, double", &name], flops(), matrix, |matrix| {
            linear.factor_positive(matrix, Precision::Double).map(drop).expect(stable);
        });
        bench.time_with(["factor, 1 thread", &name], flops(), matrix, |matrix| {
            one.install(|| linear.factor_positive(matrix, Precision::Single).map(drop))
                .expect(stable);
        });
        bench.time_with(["factor", &name], flops(), matrix, |matrix| {
            linear.factor_positive(matrix, Precision::Single).map(drop).expect(stable);
        });
        let factored = linear.factor_positive(matrix(), Precision::Single).expect(stable);
        let vector = || force.clone();
        // any accuracy will do: one step
        let once = Throughput::Bytes(bytes as u64);
        bench.time_with(["solve, one step", &name], once, vector, |mut x| {
            factored.solve_to(&mut x, f64::INFINITY)
        });
        bench.time_with(["solve to 1e-10", &name], dofs(), vector, |mut x| {
            factored.solve_to(&mut x, ACCURATE)
        });
        bench.time(["CG, old factor", &name], dofs(), || {
            let near = factored.solve_near(&nearby, &force, FORCING);
            near.solved().expect("one percent more is near")
        });
        Ok(())
    })
}

/// From rest to the certified equilibrium, with numbering, pattern, ordering and symbolic factorisation.
pub fn solve(bench: &mut Bench, name: &str) -> Result<()> {
    let what = "static solve";
    if !bench.wants(what, name) {
        return Ok(());
    }
    let Some(scene) = cases::scene(name)? else { return Ok(()) };
    let (problem, _) = scene.problem(&scene.body)?;
    bench.time([what, name], Throughput::Elements(problem.dofs() as u64), || {
        let (problem, mut workspace) = scene.problem(&scene.body).expect("as before");
        let rest = &scene.body.mesh.vertices;
        forward::solve(&problem, &mut workspace, rest, &scene.stepping(), &[1.0])
            .expect("a load it bears")
    });
    Ok(())
}
