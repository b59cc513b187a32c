//! Against numbers of an independent solver (PolyFEM) on the gripper that was
//! published with Gjoka et al. 2024, at 5 kPa without contact.

use mechanics::element::{FunctionSpace, at};
use mechanics::energy::{Chamber, Energies, Isobaric, Wall};
use mechanics::forward::{Newton, Problem, Stepping, Workspace, solve};
use mechanics::material::MooneyRivlin;
use mesh::Vec3;
use tests::published::gripper;

fn compare(degree: usize, reference: &str) {
    let Some(reference) = tests::shared(reference) else { return };
    let Some(body) = gripper() else { return };
    let space = FunctionSpace::new(degree, body.mesh.vertices.len(), body.mesh.tets.clone());
    let mut fixed = vec![false; 3 * space.node_count()];
    for facet in body.facets("fixed").unwrap() {
        for node in space.facet_nodes(facet) {
            fixed[3 * node..3 * node + 3].fill(true);
        }
    }
    let law = MooneyRivlin { c1: 55e3, c2: 5e3, c3: 1.7e3, d1: 1e6 };
    let wall = Wall::new(&space, &body.facets("cavity").unwrap());
    let gas = Box::new(Isobaric { pressure: 5e3.into() });
    let chamber = Chamber::new(wall, gas);
    let energies = Energies::elastic(Box::new(law)).with_chamber("cavity", chamber);
    let problem = Problem::new(space, energies, &fixed);
    let mut workspace = Workspace::new(&problem);
    let newton = Newton {
        iterations: 30,
        relative: 1e-10,
        absolute: 1e-10,
        negligible: 0.0,
        ballooned: None,
    };
    let stepping = Stepping { first: 1.0, largest: 1.0, smallest: 1e-3, newton };
    let rest = body.mesh.vertices.clone();
    let clock = std::time::Instant::now();
    let solution = solve(&problem, &mut workspace, &rest, &stepping, |_| ()).unwrap();
    eprintln!(
        "P{degree}: {} Newton iterations, {:.2} s, {:?}",
        solution.newton_iterations,
        clock.elapsed().as_secs_f64(),
        workspace.timings
    );

    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(reference).unwrap()).unwrap();
    let ids = json["nodes"]["mesh_vertex_id_0based"].as_array().unwrap();
    let step = json["steps"].as_array().unwrap().last().unwrap();
    let expected = step["u_m"].as_array().unwrap();
    let largest = step["max_abs_u_m"].as_f64().unwrap();
    let mut worst = 0.0_f64;
    for (id, u) in ids.iter().zip(expected) {
        let id = usize::try_from(id.as_u64().unwrap()).unwrap();
        let component = |k: usize| u[k].as_f64().unwrap();
        let u = Vec3::new(component(0), component(1), component(2));
        worst = worst.max((at(&solution.u, id) - u).norm());
    }
    eprintln!(
        "P{degree}: worst probe differs by {:.1e} of the largest displacement",
        worst / largest
    );
    // the reference stopped at a relative gradient of 1e-6
    assert!(worst < 1e-6 * largest, "{worst} {largest}");
}

#[test]
fn gripper_with_linear_elements() {
    compare(1, "reference/gripper_static5k_p1.json");
}

#[test]
#[ignore = "half a minute: runs in make test-all"]
fn gripper_with_quadratic_elements() {
    compare(2, "reference/gripper_static5k_p2.json");
}
