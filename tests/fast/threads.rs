//! The number of threads changes no bit of what is assembled.

use measure::quantity::{Equilibrium, Partials};
use mechanics::energy::Hessian;
use mechanics::math::random::Random;
use mesh::Vec3;
use scene::config::DesignConfig;
use scene::{ObjectiveBuilder, Scene};
use tests::chamber;
use tests::workdir::Workdir;

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(work)
}

/// Energy, forces, tangent, and every objective with its derivatives at a state
/// that is no equilibrium, as bits.
fn assembled(dir: &Workdir, scene: &str) -> Vec<(String, Vec<u64>)> {
    let scene = Scene::read(&dir.path(scene)).unwrap();
    let (problem, mut workspace) = scene.problem(&scene.body).unwrap();
    let mut random = Random::new(5);
    let rest: Vec<Vec3> =
        scene.body.mesh.vertices.iter().map(|x| x + 2e-4 * random.vector()).collect();
    let u: Vec<f64> = random.numbers(problem.dofs()).iter().map(|u| 1e-4 * u).collect();
    let at = problem.iterate(&rest, &u, 1.0);
    let mut found = vec![
        ("energy".to_owned(), vec![problem.value(&at)]),
        ("gradient".to_owned(), problem.gradient(&at).0),
        ("hessian".to_owned(), workspace.hessian(&problem, &at, Hessian::Exact).lower),
        ("projected".to_owned(), workspace.hessian(&problem, &at, Hessian::Projected).lower),
    ];
    let mut mixed = vec![0.0; 3 * rest.len()];
    for energy in problem.energies.iter() {
        energy.add_mixed_vjp(&at, &u, &mut mixed);
    }
    found.push(("mixed".to_owned(), mixed));
    let path = dir.path("design.toml");
    let design = DesignConfig::read(&path).unwrap();
    let builder = ObjectiveBuilder::new(&path, &design.objective, &scene).unwrap();
    let at = Equilibrium {
        space: &problem.space,
        rest: &rest,
        u: &u,
        time: 1.0,
        contact: &[],
        reaction: &[],
        energies: &problem.energies,
    };
    for term in builder.build(&scene, &scene.body, &problem.space).unwrap() {
        let [mut du, mut contact, mut reaction] = [0, 1, 2].map(|_| vec![0.0; u.len()]);
        let mut drest = vec![0.0; 3 * rest.len()];
        let value = term.quantity.value(&at);
        let (rest, contact, reaction) = (&mut drest[..], &mut contact[..], &mut reaction[..]);
        let mut partials = Partials { u: &mut du, rest, contact, reaction };
        term.quantity.add_partials(&at, term.weight, &mut partials);
        found.push((term.name, [vec![value], du, drest].concat()));
    }
    let bits = |numbers: Vec<f64>| numbers.into_iter().map(f64::to_bits).collect();
    found.into_iter().map(|(name, numbers)| (name, bits(numbers))).collect()
}

#[test]
fn assembly_and_objectives_are_the_same_bit_for_bit() {
    let dir = chamber::workdir();
    for scene in ["p1.toml", "sim.toml"] {
        let one = with_threads(1, || assembled(&dir, scene));
        assert_eq!(one.len(), 9);
        let zero = |bits: &[u64]| bits.iter().all(|&b| f64::from_bits(b) == 0.0);
        for (name, bits) in &one {
            // no surfaces are closer than the activation distance of "clear"
            assert_eq!(zero(bits), name == "clear", "{name}");
        }
        for threads in [2, 7] {
            assert!(with_threads(threads, || assembled(&dir, scene)) == one, "{threads} threads");
        }
    }
}
