//! Gradients of runs of blocks with sheets on their faces and inside.

use super::*;
use crate::energy::Isobaric;
use crate::energy::{Axis, Direction, Membrane};
use crate::material::sheet::{LAWS, Sheet, TensionField};
use crate::material::{Lame, NeoHookean};

/// A block with gas behind all but its held face, and a sheet across its middle and on its top.
struct Sheets {
    law: usize,
    tension: bool,
    degree: usize,
    /// Pressure on the block: sheets are stretched where it pulls, and wrinkle where it pushes [Pa].
    pressure: f64,
}

impl Sheets {
    /// Thickness relative to that of the case, then the parameters of the law likewise.
    fn problem(&self, factors: &[f64]) -> (Problem, Workspace) {
        let TetMesh { vertices, tets } = Self::mesh();
        let boundary =
            topology::boundary(&TetMesh { vertices: vertices.clone(), tets: tets.clone() });
        let is_at =
            |facet: &[usize; 3], z: f64| facet.iter().all(|&v| (vertices[v].z - z).abs() < 1e-9);
        let all = tets
            .iter()
            .flat_map(|t| topology::TET_FACETS.map(|f| mesh::facet_key(f.map(|c| t[c]))));
        let mut sheets: Vec<[usize; 3]> =
            all.filter(|f| is_at(f, 0.01) || is_at(f, 0.02)).collect();
        sheets.sort_unstable();
        sheets.dedup();
        let wall: Vec<[usize; 3]> = boundary
            .facets
            .into_iter()
            .filter(|f| !is_at(f, 0.0))
            .map(|[a, b, c]| [a, c, b])
            .collect();
        let space = FunctionSpace::new(self.degree, vertices.len(), tets);
        let nodes = space.node_positions(&vertices);
        let fixed: Vec<bool> = nodes.iter().flat_map(|x| [x.z == 0.0; 3]).collect();
        let row = &LAWS[self.law];
        let values: Vec<f64> = row.sample.iter().zip(&factors[1..]).map(|(v, f)| v * f).collect();
        let law = (row.build)(&values);
        let law: Box<dyn Sheet> = if self.tension { Box::new(TensionField(law)) } else { law };
        let mut energies = Energies::elastic(Box::new(NeoHookean(Lame::new(5e4, 0.4))));
        let has_axes = law.has_axes();
        let sheet = Membrane::new(&space, &sheets, 2e-3 * factors[0], law);
        let angle = 0.5 * factors.last().copied().unwrap_or(1.0);
        let axis = Axis { point: Vec3::new(0.005, -0.01, 0.0), along: Vec3::x() };
        let warp = Direction::Helical(axis, angle);
        let sheet = if has_axes { sheet.along(warp) } else { sheet };
        energies.extend([Term::of(Membrane::owner(0), sheet)]);
        let gas = Box::new(Isobaric { pressure: self.pressure.into() });
        let wall = Wall::new(&space, &wall);
        energies = energies.with_chamber("around", Chamber::new(wall, gas));
        let problem = Problem::new(space, energies, &fixed);
        let workspace = Workspace::new(&problem);
        (problem, workspace)
    }

    /// Two cells a side, all vertices but those of the held face away from a lattice.
    fn mesh() -> TetMesh {
        let mut mesh = cube(2, 0.0);
        mesh.vertices.iter_mut().for_each(|v| *v *= 0.02);
        mesh
    }

    fn check(&self) {
        let row = &LAWS[self.law];
        let mut values: Vec<f64> = [2e-3].iter().chain(row.sample).copied().collect();
        values.extend((row.build)(row.sample).has_axes().then_some(0.5));
        let by = |gradient: &Gradient| vec![by_factors(gradient, Membrane::owner(0), &values)];
        let problem = |factors: &[f64]| self.problem(&factors[..values.len()]);
        let runs = Runs { problem: &problem, run: &at_full_load, forces: false };
        runs.check(&Self::mesh().vertices, &[1e-3], by);
    }
}

/// The run of a body to its equilibrium under full load.
pub(super) fn at_full_load(
    problem: &Problem,
    workspace: &mut Workspace,
    rest: &[Vec3],
) -> Trajectory {
    let zero = vec![0.0; problem.dofs()];
    let integrator = Integrator::new(Method::Quasistatic, State::new(zero.clone(), zero));
    let mut stepper = TimeStepper::new(TIGHT, integrator);
    let run = stepper.run(problem, workspace, rest, &[1.0], ON_DISK, |_| ());
    run.expect("an equilibrium")
}

#[test]
fn bodies_with_sheets_have_their_gradient() {
    for law in 0..LAWS.len() {
        for degree in [1, 2] {
            // blown up, pressed together, and the same without compression
            for (tension, pressure) in [(false, 4e3), (false, -4e3), (true, 4e3)] {
                Sheets { law, tension, degree, pressure }.check();
            }
        }
    }
}
