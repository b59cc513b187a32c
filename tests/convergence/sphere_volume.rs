//! The volume behind a wall that is bent onto the unit sphere: straight facets,
//! displacement nodes on the sphere.

use mechanics::element::FunctionSpace;
use mechanics::energy::Wall;
use tests::equilibrium::{facets_where, scientific};
use tests::meshes::ball;

/// Relative error with 20 · 4^level facets.
fn error(degree: usize, level: usize) -> f64 {
    let mesh = ball(level);
    let facets = facets_where(&mesh, |p| p.norm() > 0.5);
    let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone());
    let mut x = space.node_positions(&mesh.vertices);
    let wall = Wall::new(&space, &facets);
    for facet in &facets {
        for node in space.facet_nodes(*facet) {
            x[node] = x[node].normalize();
        }
    }
    // the gas is behind the facets, here outside of the ball
    let exact = 4.0 / 3.0 * std::f64::consts::PI;
    -wall.volume(&space, |n| x[n]) / exact - 1.0
}

#[test]
fn volume_errors_are_the_known_ones() {
    let quadratic: Vec<f64> = (0..4).map(|level| error(2, level)).collect();
    let reference = [-2.997e-2, -2.210e-3, -1.439e-4, -9.083e-6];
    eprintln!("sphere volume P2: {}, reference {}", scientific(&quadratic), scientific(&reference));
    for (ours, theirs) in quadratic.iter().zip(reference) {
        assert!((ours / theirs - 1.0).abs() < 1e-3, "{ours} {theirs}");
    }
    let linear = [error(1, 2), error(1, 3)];
    eprintln!("sphere volume P1: {}, reference at 1280 facets -8.6e-3", scientific(&linear));
    assert!((linear[1] / -8.6e-3 - 1.0).abs() < 0.01);
    assert!(((linear[0] / linear[1]).log2() - 2.0).abs() < 0.1);
    let cubic = [error(3, 2), error(3, 3)];
    let order = (cubic[0] / cubic[1]).log2();
    eprintln!("sphere volume P3: {}, order {order:.2}", scientific(&cubic));
    assert!(order > 3.8, "{order}");
}
