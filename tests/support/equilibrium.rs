//! Equilibria of small bodies without a scene file.

use std::ops::ControlFlow;

use mechanics::element::{FunctionSpace, at};
use mechanics::energy::Energies;
use mechanics::forward::{
    Configuration, Converged, Failure, Integrator, LoadStep, Method, Newton, Problem, Reached,
    State, Stepping, TimeStepper, Workspace, certificate,
};
use mechanics::material::MooneyRivlin;
use mechanics::stability::{ArcLength, Continuation, FirstLimit, LimitSearch};
use mesh::{TetMesh, Vec3};
use solver::plot::{Axes, Series, Style, draw};

use crate::workdir::repository;

/// The silicone of the frog, finger and gripper of Gjoka et al. 2024.
pub const SILICONE: MooneyRivlin = MooneyRivlin { c1: 55e3, c2: 5e3, c3: 1.7e3, d1: 1e6 };

/// Shear and bulk modulus of [`SILICONE`] at small strain [Pa].
pub const MODULI: (f64, f64) = (120e3, 2e6);

/// A body under loads that grow together.
pub struct Equilibrium {
    /// Rest positions of the vertices [m].
    pub rest: Vec<Vec3>,
    /// The discrete problem.
    pub problem: Problem,
    /// What solving it needs.
    pub workspace: Workspace,
    /// Displacement of the last equilibrium [m].
    pub u: Vec<f64>,
}

impl Equilibrium {
    /// Elements of a degree on a mesh; `energies` may look at the space, and
    /// `held` gives the components that are fixed at a rest position.
    pub fn new(
        mesh: TetMesh,
        degree: usize,
        energies: impl Fn(&FunctionSpace) -> Energies,
        held: impl Fn(Vec3) -> [bool; 3],
    ) -> Self {
        let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets);
        let rest = mesh.vertices;
        let fixed: Vec<bool> = space.node_positions(&rest).into_iter().flat_map(held).collect();
        let energies = energies(&space);
        let u = vec![0.0; fixed.len()];
        let problem = Problem::new(space, energies, &fixed);
        Self { rest, workspace: Workspace::new(&problem), problem, u }
    }

    /// Moves on to the equilibrium at a fraction of the load.
    pub fn solve(&mut self, load: f64) {
        // slender bodies cancel large inner forces: 1e-10 is below their rounding
        let newton = newton(40, 1e-9);
        self.balance(&newton, load).unwrap_or_else(|failure| panic!("load {load}: {failure}"));
        certificate(&self.problem.space, &self.rest, &self.u)
            .unwrap_or_else(|found| panic!("load {load}: {found}"));
    }

    /// The same by Newton's method alone.
    pub fn balance(&mut self, newton: &Newton, load: f64) -> Result<Converged, Failure> {
        let u = std::mem::take(&mut self.u);
        let mut state = Configuration::new(&self.problem, &self.rest, u, load);
        let result = newton.solve(&self.problem, &mut self.workspace, &mut state);
        self.u = state.u;
        result
    }

    /// The first limit on the path from rest to the full load, whose states are shown to `observe`.
    pub fn first_limit(&mut self, mut observe: impl FnMut(&LoadStep)) -> FirstLimit {
        let zero = vec![0.0; self.problem.dofs()];
        let start = Reached::of(&self.problem.iterate(&self.rest, &zero, 0.0));
        let (stepping, integrator) = at_rest(&self.problem);
        let (problem, rest) = (&self.problem, &self.rest);
        let search = LimitSearch { problem, rest, stepping, most: 1.0, integrator };
        search.from(&mut self.workspace, start, |step| {
            observe(step);
            ControlFlow::Continue(())
        })
    }

    /// The path from rest as long as states are wanted, through limits, to the full load at most.
    pub fn follow(&mut self, largest: f64, wanted: impl Fn(&LoadStep) -> bool) -> Vec<LoadStep> {
        let (stepping, integrator) = at_rest(&self.problem);
        let mut stepper = TimeStepper::new(stepping, integrator);
        let path = ArcLength { first: 0.1, largest, smallest: 1e-3, end: 1.0 };
        let mut follower = Continuation::new(path);
        let mut steps = Vec::new();
        loop {
            let step = follower.next(&mut stepper, &self.problem, &mut self.workspace, &self.rest);
            let step = step.unwrap_or_else(|unreached| panic!("{unreached}"));
            let ends = step.ends_time_step || !wanted(&step);
            steps.push(step);
            if ends {
                return steps;
            }
        }
    }

    /// Rest and deformed positions of all nodes [m].
    pub fn nodes(&self) -> Vec<(Vec3, Vec3)> {
        let rest = self.problem.space.node_positions(&self.rest);
        rest.into_iter().enumerate().map(|(i, x)| (x, x + at(&self.u, i))).collect()
    }

    /// Rest and deformed positions of the mesh vertices [m].
    pub fn vertices(&self) -> Vec<(Vec3, Vec3)> {
        let mut nodes = self.nodes();
        nodes.truncate(self.rest.len());
        nodes
    }
}

/// Newton's method to a part of the forces.
pub fn newton(iterations: usize, relative: f64) -> Newton {
    Newton { iterations, relative, absolute: 0.0, negligible: 0.0, ballooned: None }
}

/// How a path is followed, from rest.
fn at_rest(problem: &Problem) -> (Stepping, Integrator) {
    let newton = newton(30, 1e-9);
    let zero = vec![0.0; problem.dofs()];
    let stepping = Stepping { first: 1.0, largest: 1.0, smallest: 1e-3, newton };
    (stepping, Integrator::new(Method::Quasistatic, State::new(zero.clone(), zero)))
}

/// Boundary facets, oriented out of the solid, whose vertices all satisfy a
/// condition.
pub fn facets_where(mesh: &TetMesh, inside: impl Fn(Vec3) -> bool) -> Vec<[usize; 3]> {
    let facets = mesh::topology::boundary(mesh).facets;
    facets.into_iter().filter(|f| f.iter().all(|&v| inside(mesh.vertices[v]))).collect()
}

/// The mean of some numbers.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Numbers in scientific notation, for tables.
pub fn scientific(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:.3e}")).collect::<Vec<_>>().join(" ")
}

/// Draws a path and its closed form in `build`, with the names of the axes.
pub fn draw_path(name: &str, [x, y]: [&str; 2], states: &[[f64; 2]], closed: &[[f64; 2]]) {
    let series = |label: &str, points: &[[f64; 2]], style: Style, turn: usize| Series {
        label: Some(label.to_owned()),
        points: points.iter().map(|&[x, y]| (x, y)).collect(),
        style,
        turn,
    };
    let curves = [
        series("closed form", closed, Style::Dotted(2), 0),
        series("solver", states, Style::Circles(5), 1),
    ];
    let axes = Axes { x: x.to_owned(), y: y.to_owned(), ..Axes::default() };
    let folder = repository().join("build");
    std::fs::create_dir_all(&folder).expect("a folder for results");
    draw(&folder.join(name), &axes, &curves).expect("a picture");
}
